"""Pressure limits of bare rollers between cam and disc, and which cams have a bought bearing instead."""

import math
from collections.abc import Iterator

from cycloid_mj.geometry import ideal_loads
from cycloid_mj.parts.cam_bearing import cam_bearing
from cycloid_mj.reducer import Reducer


def has_bare_rollers(reducer: Reducer) -> bool:
    """Return whether rollers run on the cam and in the disc's bore, without the rings of a bought bearing."""
    return reducer.design.gear.bearing == "rolling" and cam_bearing(reducer) is None


def roller_contacts(reducer: Reducer) -> Iterator[tuple[str, float]]:
    """Yield the two parts on which the rollers of a cam without bearing rings press, each with its pressure ratio.

    The ratio is the true Hertz pressure on the part over that of the model's contact ``cam``. This contact has the
    curvature of a roller on the cam, but the modulus of shaft on disc. In fact, roller and cam are of the same
    material, and in the bore of the disc the curvature is smaller. Hertz's pressure is proportional to sqrt(curvature x
    modulus).

    Yields
    ------
    tuple
        Name of the part, "shaft" or "gear", and the pressure ratio [1].
    """
    design, contact = reducer.design, reducer.contacts["cam"]
    shaft_material, roller_radius, bore_radius = (
        design.material_of("shaft"),
        reducer.contacts.roller_radius,
        design.gear.bore_radius,
    )
    shaft_modulus = ideal_loads.contact_modulus(shaft_material.youngs_modulus, shaft_material.poisson)
    yield "shaft", math.sqrt(shaft_modulus / contact.modulus)
    yield "gear", math.sqrt((1.0 / roller_radius - 1.0 / bore_radius) / contact.relative_curvature)


def cam_pressure_limit(reducer: Reducer, factor: float, strength: str) -> float:
    """Compute the largest allowed pressure [Pa] of the model's contact ``cam`` for rollers without bearing rings.

    At this pressure the cam or the bore reaches its limit, `factor` times the attribute `strength` of its material.
    """
    limits = (
        factor * getattr(reducer.design.material_of(part), strength) / ratio for part, ratio in roller_contacts(reducer)
    )
    return min(limits)
