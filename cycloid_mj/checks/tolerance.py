"""Checks of manufacturing errors against the clearances that must compensate them."""

import math
from collections.abc import Iterator, Sequence

from cycloid_mj.checks.check import Check
from cycloid_mj.checks.limit import Limit, single_remedies, value_and_limit
from cycloid_mj.design.units import MICROMETRE
from cycloid_mj.reducer import Reducer

SIGMAS = 3.0
"""Tolerance of a part over the standard deviation of its error: 3 parts in 1000 are beyond."""


def tolerance_checks(reducer: Reducer) -> Iterator[Check]:
    """Yield the checks that the manufacturing errors of a design are smaller than its clearances; all are warnings.

    For a ring pin, the root of the sum of squares of its errors of position and radius counts. Errors of the cams'
    positions and of the eccentricity are compared with the sum of the clearances of cam and mesh.
    """
    design = reducer.design
    errors, measurements, clearance, pair = design.errors, design.measured, design.clearance, design.tooth_pair
    mesh_clearance = getattr(clearance, pair) + design.modification.equidistant + design.pin_play
    position_error, radius_error = (
        _tolerance_of(
            errors.pin_position, errors.pin_x, errors.pin_y, measurements.pins_radial, measurements.pins_tangential
        ),
        _tolerance_of(errors.pin_radius, errors.pin_dr, measurements.pins_radius),
    )
    pin_error = math.hypot(position_error, radius_error)
    yield from _check_error(
        reducer, "pin_tolerance", "position and radius of a ring pin", pin_error, pair, mesh_clearance
    )
    hole_error = _tolerance_of(errors.hole_position, errors.hole_x, errors.hole_y)
    yield from _check_error(reducer, "hole_tolerance", "the position of a hole", hole_error, "output", clearance.output)
    flank_error = _tolerance_of(errors.disc_size, errors.disc_dr, measurements.gear_deviation)
    yield from _check_error(reducer, "disc_tolerance", "the flanks of a disc", flank_error, pair, mesh_clearance)
    cam_error = _tolerance_of(errors.cam_position, errors.cam_x, errors.cam_y)
    yield from _check_error(
        reducer, "cam_tolerance", "the position of a cam", cam_error, "cam", clearance.cam + mesh_clearance
    )
    eccentricity_error = abs(errors.eccentricity)
    yield from _check_error(
        reducer, "eccentricity_tolerance", "the eccentricity", eccentricity_error, "cam", clearance.cam + mesh_clearance
    )


def _tolerance_of(deviation: float, *listed: Sequence[float]) -> float:
    """Compute the tolerance of an error [m]: the largest listed values, or three standard deviations of random errors.

    `deviation` is the standard deviation [m]. If several lists are not empty, their largest values add as squares.
    """
    largest_values = [max(abs(value) for value in values) for values in listed if values]
    return math.hypot(*largest_values) if largest_values else SIGMAS * deviation


def _check_error(
    reducer: Reducer, name: str, quantity: str, error: float, pair: str, available_clearance: float
) -> Iterator[Check]:
    """Yield the check that a manufacturing error [m] is at most `available_clearance` [m]; nothing without an error.

    `name` is that of the check, `pair` the kind of pair whose clearance the remedy increases, and `quantity` what
    deviates, in words.
    """
    if error == 0.0:
        return
    is_passed = error <= available_clearance
    size_text, limit_text = value_and_limit(error, "at most", available_clearance, MICROMETRE)
    clearance_limit = Limit(
        f"clearance.{pair}", "at least", getattr(reducer.design.clearance, pair) + error - available_clearance
    )
    error_remedy = f"reduce the errors to {available_clearance / error:.0%} of their present values"
    yield Check(
        name=name,
        passed=is_passed,
        got=f"{size_text} ({SIGMAS:g} standard deviations, or the largest listed)",
        limit=f"{limit_text} (the clearance)",
        why="a part whose error exceeds its clearance is pressed and takes load from the others",
        severity="warning",
        key=f"the error of {quantity}",
        **single_remedies(reducer, [] if is_passed else [clearance_limit], error_remedy),
    )
