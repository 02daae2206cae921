"""Hertz's pressure in the line contacts of a reducer, and the pressures that its material bears."""

import math

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.design.materials import SOFTEST_METAL
from cycloid_mj.geometry import ideal_loads
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.working import STRIBECK

YIELD_PRESSURE = 1.79
"""Peak pressure at which a line contact first yields, over the yield strength (von Mises; Johnson 1985, 4.4)."""

SHAKEDOWN_PRESSURE = 4.0 / math.sqrt(3.0)
"""Peak pressure up to which rolling stays elastic after a first yield, 4 k (Johnson 1985, 9.2), over the same: 2.31."""

HARDNESS_PRESSURE = 9.807 / 3.45
"""Brinell hardness as a pressure over the tensile strength of steel: HB is 0.29 of the MPa (ISO 18265): 2.84."""

HERTZ_REACH = 0.3
"""Assumed: Hertz's strip, of half planes, holds up to this half width, over the radius of the thinner body.

Hertz takes b << R (Johnson 1985, 4.1); a strip of 0.3 R, 17 deg to each side, is where conformal solutions leave it."""


def line_curvature(reducer: Reducer, kind: str) -> float:
    """Find the relative curvature [1/m] of a kind of contact but the teeth; of a rolling cam, that of its rollers."""
    design = reducer.design
    if kind == "cam" and _has_rollers(reducer):
        return 1.0 / roller_radius(reducer) + 1.0 / design.gear.bore_radius
    inner, outer = {
        "cam": (design.gear.bore_radius, design.gear.bore_radius + design.clearance.cam),
        "output": (design.output.pin_radius, design.output.hole_radius + design.clearance.output),
        "pin_socket": (design.ring.pin_radius, design.ring.pin_radius + design.clearance.pin_socket),
        "pin_sleeve": (
            design.ring.sleeve_bore_radius - design.clearance.pin_sleeve,
            design.ring.sleeve_bore_radius,
        ),
    }[kind]
    return 1.0 / inner - 1.0 / outer


def roller_radius(reducer: Reducer) -> float:
    """Compute the radius of the cam's rollers [m], which fill its circle, one touching the next."""
    return reducer.design.gear.bore_radius * math.sin(math.pi / reducer.design.contact.cam_rollers)


def line_share(reducer: Reducer, kind: str) -> float:
    """Compute the share of a pair's force that its most loaded line contact bears: of a rolling cam, one roller."""
    return STRIBECK / reducer.design.contact.cam_rollers if kind == "cam" and _has_rollers(reducer) else 1.0


def pair_modulus(reducer: Reducer, kind: str) -> float:
    """Compute the modulus E* [Pa] of a kind of pair, of the materials of both parts."""
    one, other = reducer.design.partners(kind)
    return ideal_loads.contact_modulus(one.youngs_modulus, one.poisson, other.youngs_modulus, other.poisson)


def pair_strength(reducer: Reducer, kind: str) -> float:
    """Compute the yield strength [Pa] of the weaker of the two surfaces that meet in a kind of pair."""
    return min(part.surface_strength for part in reducer.design.partners(kind))


def weaker_is_plastic(reducer: Reducer, kind: str) -> bool:
    """Tell whether the weaker of the two surfaces that meet in a kind of pair is a plastic."""
    weaker = min(reducer.design.partners(kind), key=lambda part: part.surface_strength)
    return weaker.youngs_modulus < SOFTEST_METAL


def hertz_pressure(reducer: Reducer, kind: str, force: npt.ArrayLike, curvature: npt.ArrayLike) -> Array:
    """Compute Hertz's peak pressure [Pa] of whole lines; conformal ones count as flat on flat.

    `force` [N] and relative `curvature` [1/m] broadcast to the shape of the result.
    """
    modulus = pair_modulus(reducer, kind)
    curvature = np.maximum(curvature, np.finfo(float).tiny)
    return ideal_loads.hertz_line_contact(force, reducer.design.line_length(kind), curvature, modulus).peak_pressure


def hertz_holds(reducer: Reducer, kind: str, force: npt.ArrayLike, curvature: npt.ArrayLike) -> Mask:
    """Tell where a line contact of a kind is no conformal one: its strip is narrow against the thinner body.

    `force` [N] on the line and relative `curvature` [1/m] broadcast to the shape of the result.
    """
    modulus = pair_modulus(reducer, kind)
    curvature = np.maximum(curvature, np.finfo(float).tiny)
    strip = ideal_loads.hertz_line_contact(force, reducer.design.line_length(kind), curvature, modulus).half_width
    return np.asarray(strip < HERTZ_REACH * _thinner_radius(reducer, kind))


def _thinner_radius(reducer: Reducer, kind: str) -> float:
    """Radius [m] of the smaller body of a kind of contact."""
    design = reducer.design
    if kind == "cam":
        return roller_radius(reducer) if _has_rollers(reducer) else design.gear.bore_radius
    return {"output": design.output.pin_radius, "pin_sleeve": design.ring.sleeve_bore_radius}.get(
        kind, design.ring.pin_radius
    )


def _has_rollers(reducer: Reducer) -> bool:
    return reducer.design.gear.bearing == "rolling"
