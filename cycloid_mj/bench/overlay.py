"""Branches of a model's loop at the torques of a measured loop, and distances of the measured points from them.

A distance is computed with torque and deflection as shares of their ranges. Across the play a small torque is a large
rotation, and where the loop sticks it is none, so that a difference in one of them alone would be misleading.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.compiling import announce_compilation, njit
from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.parameters import Model, Parameter
from cycloid_mj.statics.friction_path import Held, course_along
from cycloid_mj.statics.locked import load_friction, locked_branches, locked_curve, slip_elements

BRANCH_POINTS, LEAD_POINTS = 24, 8
"""Torques of a branch of the model with friction in its contacts, and of each branch that leads to the loop."""

MAX_TURN = 0.05
"""Largest rotation between two points of that model, as a share of the loop's height; more points are inserted."""

Branches = list[tuple[Array, Array]]


@dataclass(frozen=True, eq=False)
class LoopCondition:
    """Condition of a measurement: the locked shaft, the crank angle [rad], and the largest torque [N m]."""

    held: Held
    crank: float
    max_torque: float


def apply_values(model: Model, parameters: Sequence[Parameter], values: Array) -> Model:
    """Return a model with the values of parameters."""
    for parameter, value in zip(parameters, values, strict=False):
        model = parameter.apply(model, float(value))
    return model


def model_branches(model: Model, bench: LoopCondition, loop: MeasuredLoop, shift: float = 0.0) -> Branches:
    """Compute torque [N m] and turn [rad] of a model along each branch of a loop.

    The torques are those of the loop less a `shift` [N m]. A loop of the same size precedes it, so that it closes.
    """
    ends = [end - shift for end in loop.turns]
    if model.contact_friction:
        return _branches_with_contact_friction(model, bench, ends, MAX_TURN * loop.height)
    curve = locked_curve(model.reducer, bench.max_torque, bench.crank)
    # two branches lead to the loop: from rest to its second end, and back to its first
    load = load_friction(model.losses.load, model.reducer.design.springs.friction_travel)
    return locked_branches(curve, slip_elements(model.reducer), [0.0, ends[1], *ends], load)[2:]


def _branches_with_contact_friction(model: Model, bench: LoopCondition, ends: list[float], max_turn: float) -> Branches:
    """Compute the branches between torques [N m] with friction in the contacts, at most `max_turn` [rad] apart."""
    spans = list(pairwise(ends))
    lead = [np.linspace(a, b, LEAD_POINTS, endpoint=False) for a, b in ((0.0, ends[1]), (ends[1], ends[0]))]
    distinct = list(dict.fromkeys(spans))
    course = np.concatenate([*lead, *(np.linspace(a, b, BRANCH_POINTS) for a, b in distinct)])
    when, turn = course_along(model.reducer, course, bench.crank, model.losses, bench.held, max_turn)
    load = np.interp(when, np.arange(len(course)), course)
    parts = np.searchsorted(when, 2 * LEAD_POINTS + BRANCH_POINTS * np.arange(len(distinct) + 1))
    branches = [(load[a:b], turn[a:b]) for a, b in pairwise(parts)]
    # a closed loop repeats its branches
    return [branches[distinct.index(span)] for span in spans]


def deflections(loop: MeasuredLoop, branches: Branches) -> Array:
    """Compute the model's deflection [rad] at every measured point, on its branch at the same torque, shape (n,)."""
    turn = np.empty(len(loop.torque))
    for number, (torque, deflection) in enumerate(branches):
        inside, order = loop.branch == number, np.argsort(torque)
        turn[inside] = np.interp(loop.torque[inside], torque[order], deflection[order])
    return turn


def distances(loop: MeasuredLoop, branches: Branches, torque: float, deflection: float) -> Array:
    """Compute the signed distance of each point from the model's branch, as a share of the loop's ranges.

    The model's loop is moved by an offset of `torque` [N m] and of `deflection` [rad]. Points before the loop are
    omitted, shape (n - points_left_out,).
    """
    ranges = float(np.ptp(loop.torque)), loop.height
    distance = np.zeros(len(loop.torque))
    points = loop.torque / ranges[0], loop.deflection / ranges[1]
    with announce_compilation():
        for number, (loads, turns) in enumerate(branches):
            line = (loads + torque) / ranges[0], (turns + deflection) / ranges[1]
            _fill_distances(points, loop.branch == number, line, distance)
    return distance[loop.points_left_out :]


@njit(cache=True)
def _fill_distances(points: tuple[Array, Array], chosen: Mask, line: tuple[Array, Array], distance: Array) -> None:
    """Write the distance of chosen points (n,) from a polyline (m,), positive on its left, into `distance`."""
    for index in np.flatnonzero(chosen):
        nearest = np.inf
        for begin in range(len(line[0]) - 1):
            along_x, along_y = line[0][begin + 1] - line[0][begin], line[1][begin + 1] - line[1][begin]
            x, y = points[0][index] - line[0][begin], points[1][index] - line[1][begin]
            share = min(max((x * along_x + y * along_y) / max(along_x**2 + along_y**2, 1e-30), 0.0), 1.0)
            away = math.hypot(x - share * along_x, y - share * along_y)
            if away < nearest:
                nearest = away
                distance[index] = away if along_x * y - along_y * x >= 0.0 else -away
