"""Figures of a design that take little time: what an optimisation can minimise, maximise or limit."""

import math
from collections.abc import Callable, Collection, Iterable, Mapping

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.result import Quantity, keyed
from cycloid_mj.base.units import ARCMINUTE, MILLIMETRES
from cycloid_mj.checks import WALLS, check, soundness, summary
from cycloid_mj.design import PRESETS
from cycloid_mj.figures.geometry import masses
from cycloid_mj.geometry import profile
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.statics.sheet import PARTS_OF_SHEET, sheet_part


def _geometry(reducer: Reducer) -> dict[str, Quantity]:
    """Collect what the shape of the teeth alone decides."""
    design = reducer.design
    gear, ring = reducer.gear_profile, design.ring
    bend = MILLIMETRES * (profile.undercut_radius(gear) - reducer.profile_offset)
    share = ring.teeth * design.gear.eccentricity / ring.pin_circle_radius
    return keyed(
        [
            Quantity("least_convex_radius_mm", "sharpest convex bend of the lobes: its radius", bend, "mm"),
            Quantity("short_width", "K1 = c N / E", share, "1"),
            Quantity("outer_diameter_mm", "outer diameter", 2.0 * MILLIMETRES * design.housing.outer_radius, "mm"),
            Quantity("ratio", "turns of the crank in one of the output", float(abs(design.ratio)), "1"),
        ]
    )


def _mass(reducer: Reducer) -> dict[str, Quantity]:
    return keyed([Quantity("mass_kg", "mass of all parts", sum(masses(reducer).values()), "kg")])


def _summary(reducer: Reducer) -> dict[str, Quantity]:
    """Collect what `design check` sums up, under the keys of its JSON."""
    found = summary(reducer)
    angle, play = math.degrees(found.pressure_angle), found.backlash / ARCMINUTE
    return keyed(
        [
            Quantity("loaded_teeth", "teeth that carry at the rated torque, on average", found.loaded_teeth, "1"),
            Quantity("pressure_angle_deg", "pressure angle, mean by force", angle, "deg"),
            Quantity("backlash_arcmin", "backlash of rigid parts, mean", play, "arcmin"),
            Quantity("capacity_nm", "torque at which a contact first yields", found.capacity, "N m"),
        ]
    )


def _statics(part: str) -> Callable[[Reducer], dict[str, Quantity]]:
    return lambda design: sheet_part(design, part)


GROUPS: Mapping[str, Callable[[Reducer], dict[str, Quantity]]] = {
    "geometry": _geometry,
    "mass": _mass,
    "summary": _summary,
    **{part: _statics(part) for part in PARTS_OF_SHEET},
}
"""What gives figures together, by name: shape, mass, summary, and the parts of `statics` under its keys."""


@once
def catalogue(reducer: Reducer) -> Mapping[str, tuple[str, Quantity]]:
    """Collect every figure that designs like this have, by key: its group, and what it is.

    Where a design cannot be built, or has no balance, they are those of a preset with such teeth: the same keys.
    """
    ring = reducer.design.ring
    pins = {"ring": {"pins": ring.pins}} if ring.kind == "pin" else {}
    sound = not refusals(reducer, strict=False)
    try:
        return _all_figures(Reducer(reducer.design if sound else PRESETS[ring.kind].but(**pins)))
    except CycloidError:
        return _all_figures(Reducer(PRESETS[ring.kind].but(**pins)))


def _all_figures(reducer: Reducer) -> Mapping[str, tuple[str, Quantity]]:
    return {key: (group, one) for group, of in GROUPS.items() for key, one in of(reducer).items()}


def figures(reducer: Reducer, groups: Iterable[str]) -> dict[str, float]:
    """Compute the figures of some groups by their keys."""
    return {key: one.value for group in groups for key, one in GROUPS[group](reducer).items()}


def refusals(reducer: Reducer, strict: bool) -> dict[str, float]:
    """Compute the failed checks of a design by name, each with how far it is off, as a share of its bound.

    Those that make it impossible to build, and walls thinner than is assumed; `strict`: all warnings, too.
    """
    found = check(reducer.design) if strict else soundness(reducer)
    failed = [one for one in found if not one.passed and (strict or one.severity == "error" or one.name in WALLS)]
    return {one.name: _excess(one.value, one.bound) for one in failed}


def _excess(value: float | None, bound: float | None) -> float:
    """Compute by how much a value misses its bound, relative; 1 where that is no number."""
    if value is None or bound is None or not math.isfinite(value - bound):
        return 1.0
    return abs(value - bound) / max(abs(value), abs(bound), 1e-12)


def known(keys: Collection[str], limit: int = 200) -> str:
    """Tell the keys there are, in one line."""
    return ", ".join(sorted(keys)[:limit])
