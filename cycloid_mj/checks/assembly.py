"""Checks of whether the parts of a reducer with manufacturing errors or modified flanks can be assembled."""

from collections.abc import Iterator

import numpy as np

from cycloid_mj.checks.check import Check
from cycloid_mj.checks.limit import Limit, joint_remedy, single_remedies, value_and_limit
from cycloid_mj.design.units import MICROMETRE
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.limits import best_fit

MAX_POSES = 36
"""Crank angles at which the parts are fitted: one in each mesh period of 36 ring pins."""


def assembly_checks(reducer: Reducer) -> Iterator[Check]:
    """Yield the checks that parts with manufacturing errors or modified profiles fit together; none for ideal parts."""
    if reducer.is_ideal:
        return
    if reducer.design.ring.has_sockets:
        yield _check_pins_in_sockets(reducer)
    if not reducer.design.ring.preload:
        # preloaded parts are pressed into each other on purpose
        yield _check_assembly_gap(reducer)


def _check_pins_in_sockets(reducer: Reducer) -> Check:
    """Return the check that the free ring pin with the largest radius is smaller than its socket."""
    radius_errors = reducer.deviations.pin_radius
    thickest_index = int(np.argmax(radius_errors))
    play = reducer.design.clearance.pin_socket
    is_passed = bool(radius_errors[thickest_index] < play)
    value_text, limit_text = value_and_limit(float(radius_errors[thickest_index]), "less than", play, MICROMETRE)
    clearance_limit = Limit("clearance.pin_socket", "more than", float(radius_errors[thickest_index]))
    return Check(
        name="pin_in_socket",
        passed=is_passed,
        got=f"{value_text} (pin {thickest_index + 1})",
        limit=f"{limit_text} (clearance.pin_socket_um)",
        why="a free pin must be smaller than its socket",
        key="errors.pin_dr_um",
        **single_remedies(reducer, [] if is_passed else [clearance_limit], "lower the errors of the pins"),
    )


def _check_assembly_gap(reducer: Reducer) -> Check:
    """Return the check that the parts have a pose without overlap at every crank angle; a failure is a warning.

    Parts that overlap without load can turn only if they deform. At up to `MAX_POSES` crank angles, the pose with the
    largest minimum gap is computed (`best_fit`). The remedy widens all clearances of the disc together.
    """
    angle_count = min(MAX_POSES, reducer.design.ring.teeth)
    smallest_gap = min(best_fit(reducer, 2 * np.pi * index / angle_count).min_gap for index in range(angle_count))
    value_text, limit_text = value_and_limit(smallest_gap, "at least", 0.0, MICROMETRE)
    pairs = (reducer.design.tooth_pair, "cam", "output")
    limits = [
        Limit(f"clearance.{pair}", "at least", getattr(reducer.design.clearance, pair) - smallest_gap) for pair in pairs
    ]
    return Check(
        name="assembly",
        passed=smallest_gap >= 0.0,
        got=f"{value_text} (smallest gap with the disc where it fits best, at the worst crank angle)",
        limit=limit_text,
        why="errors and modification exceed the clearances: the parts can be assembled by force only",
        severity="warning",
        key="the gap left by errors and modification",
        **joint_remedy(reducer, [] if smallest_gap >= 0.0 else limits, "lower the errors"),
    )
