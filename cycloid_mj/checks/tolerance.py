"""Checks of manufacturing errors against the clearances that must take them up."""

import math
from collections.abc import Iterator, Sequence

from cycloid_mj.checks.limit import Check, Limit, single_changes, value_and_limit
from cycloid_mj.design.units import MICROMETRE
from cycloid_mj.reducer import Reducer

SIGMAS = 3.0
"""Standard deviations that are taken for the tolerance of a part: 3 parts in 1000 lie beyond."""


def tolerance_checks(reducer: Reducer) -> Iterator[Check]:
    """Check each manufacturing error of the design that is not 0; all are warnings."""
    design = reducer.design
    errors, clearance, pair = design.errors, design.clearance, design.tooth_pair
    mesh = getattr(clearance, pair) + design.modification.equidistant + design.pin_play
    place, radius = _spread(errors.pin_position, errors.pin_x, errors.pin_y), _spread(errors.pin_radius, errors.pin_dr)
    pins = math.hypot(place, radius)
    yield from _tolerance(reducer, "pin_tolerance", "a ring pin's place and radius", pins, pair, mesh)
    holes = _spread(errors.hole_position, errors.hole_x, errors.hole_y)
    yield from _tolerance(reducer, "hole_tolerance", "a hole's place", holes, "output", clearance.output)
    flanks = _spread(errors.disc_size, errors.disc_dr)
    yield from _tolerance(reducer, "disc_tolerance", "a disc's flanks", flanks, pair, mesh)
    cams = _spread(errors.cam_position, errors.cam_x, errors.cam_y)
    yield from _tolerance(reducer, "cam_tolerance", "a cam's place", cams, "cam", clearance.cam + mesh)
    off = abs(errors.eccentricity)
    yield from _tolerance(reducer, "eccentricity_tolerance", "the eccentricity", off, "cam", clearance.cam + mesh)


def _spread(deviation: float, *listed: Sequence[float]) -> float:
    """Compute the tolerance [m]: that of the random draw, or the largest of what is listed."""
    largest = [max(abs(value) for value in values) for values in listed if values]
    return math.hypot(*largest) if largest else SIGMAS * deviation


def _tolerance(reducer: Reducer, name: str, what: str, size: float, pair: str, room: float) -> Iterator[Check]:
    """Check that an error of a `size` [m] finds `room` [m], of which the clearance of a `pair` is part."""
    if size == 0.0:
        return
    passed = size <= room
    got, limit = value_and_limit(size, "at most", room, MICROMETRE)
    enough = Limit(f"clearance.{pair}", "at least", getattr(reducer.design.clearance, pair) + size - room)
    lower = f"lower the errors to {room / size:.0%} of what they are"
    yield Check(
        name=name,
        passed=passed,
        got=f"{got} ({SIGMAS:g} standard deviations, or the largest listed)",
        limit=f"{limit} (its clearance)",
        why="a part that is off by more than its clearance is pressed, and takes the load of the others",
        remedy="" if passed else ", or ".join(filter(None, (enough.remedy(reducer), lower))),
        severity="warning",
        key=f"the error of {what}",
        changes=() if passed else single_changes(reducer, [enough]),
    )
