"""A model's loop laid over a measured one: the model's branches, and how far each measured point lies from its own.

A point's distance counts torque and deflection as shares of their ranges: where the loop crosses its play a little
torque is a large turn, and where it sticks it is none, so that neither alone would do.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.compiling import announced, njit
from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.parameters import Model, Parameter
from cycloid_mj.statics.friction_path import Held, course_along
from cycloid_mj.statics.locked import load_friction, locked_branches, locked_curve, slip_elements

GRID, LEAD = 24, 8
"""Torques of a branch of the model, and of each that only leads to the loop."""

REACH = 0.05
"""Turn between two points of the model, as a share of the loop's height, from which on there are more between them."""

Branches = list[tuple[Array, Array]]


@dataclass(frozen=True, eq=False)
class LoopCondition:
    """Under what the loops were taken: what was held, at which crank angle [rad], and up to which torque [N m]."""

    held: Held
    crank: float
    most: float


def put_all(model: Model, parameters: Sequence[Parameter], values: Array) -> Model:
    """Return a model with the values of parameters."""
    for parameter, value in zip(parameters, values, strict=False):
        model = parameter.put(model, float(value))
    return model


def model_branches(model: Model, bench: LoopCondition, loop: MeasuredLoop, shift: float = 0.0) -> Branches:
    """Compute torque [N m] and turn [rad] of a model along each branch of a loop, less a `shift` of torque [N m].

    The course before the loop is a loop as large, so that its first branch is that of a loop which closes.
    """
    ends = [end - shift for end in loop.turns]
    if model.rubs:
        return _rubbing_branches(model, bench, ends, REACH * loop.height)
    curve = locked_curve(model.reducer, bench.most, bench.crank)
    # two stretches lead to the loop: from rest to its second end, and round to its first
    load = load_friction(model.losses.load, model.reducer.design.springs.friction_travel)
    return locked_branches(curve, slip_elements(model.reducer), [0.0, ends[1], *ends], load)[2:]


def _rubbing_branches(model: Model, bench: LoopCondition, ends: list[float], reach: float) -> Branches:
    ways = list(pairwise(ends))
    lead = [np.linspace(a, b, LEAD, endpoint=False) for a, b in ((0.0, ends[1]), (ends[1], ends[0]))]
    first = [way for place, way in enumerate(ways) if ways.index(way) == place]
    course = np.concatenate([*lead, *(np.linspace(a, b, GRID) for a, b in first)])
    when, turn = course_along(model.reducer, course, bench.crank, model.losses, bench.held, reach)
    load = np.interp(when, np.arange(len(course)), course)
    parts = np.searchsorted(when, 2 * LEAD + GRID * np.arange(len(first) + 1))
    branches = [(load[a:b], turn[a:b]) for a, b in pairwise(parts)]
    # a closed loop takes the same way again
    return [branches[first.index(way)] for way in ways]


def deflections(loop: MeasuredLoop, branches: Branches) -> Array:
    """Compute the model's deflection at every measured point [rad], shape (n,): that of its branch at the torque."""
    turn = np.empty(len(loop.torque))
    for number, (torque, deflection) in enumerate(branches):
        here, order = loop.branch == number, np.argsort(torque)
        turn[here] = np.interp(loop.torque[here], torque[order], deflection[order])
    return turn


def distances(loop: MeasuredLoop, branches: Branches, torque: float, deflection: float) -> Array:
    """Compute the signed distance of every point from the model's branch, as shares of the loop's ranges.

    Points that only lead to the loop have none, shape (n - lead,). The model's loop is moved by an offset of `torque`
    [N m] and of `deflection` [rad].
    """
    ranges = float(np.ptp(loop.torque)), loop.height
    distance = np.zeros(len(loop.torque))
    points = loop.torque / ranges[0], loop.deflection / ranges[1]
    with announced():
        for number, (loads, turns) in enumerate(branches):
            line = (loads + torque) / ranges[0], (turns + deflection) / ranges[1]
            _put_distances(points, loop.branch == number, line, distance)
    return distance[loop.lead :]


@njit(cache=True)
def _put_distances(points: tuple[Array, Array], chosen: Mask, line: tuple[Array, Array], distance: Array) -> None:
    """Put the distance of chosen points (n,) from a line through points (m,), positive to the left of its way."""
    for place in np.flatnonzero(chosen):
        nearest = np.inf
        for begin in range(len(line[0]) - 1):
            way_x, way_y = line[0][begin + 1] - line[0][begin], line[1][begin + 1] - line[1][begin]
            x, y = points[0][place] - line[0][begin], points[1][place] - line[1][begin]
            share = min(max((x * way_x + y * way_y) / max(way_x**2 + way_y**2, 1e-30), 0.0), 1.0)
            apart = math.hypot(x - share * way_x, y - share * way_y)
            if apart < nearest:
                nearest = apart
                distance[place] = apart if way_x * y - way_y * x >= 0.0 else -apart
