"""A model's loop laid over a measured one: the model's branches, and how far each measured point lies from its own.

A point's distance counts torque and deflection as shares of their ranges: where the loop crosses its play a little
torque is a large turn, and where it sticks it is none, so that neither alone would do.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.parameters import Model, Parameter
from cycloid_mj.statics.locked import locked_course, locked_curve, slip_elements
from cycloid_mj.statics.sliding import Held, course_along

GRID, LEAD = 24, 8
"""Torques of a branch of the model, and of each that only leads to the loop."""

LOCKED_GRID = 96
"""Torques of a branch where contacts do not rub: there are no more where the output leaps."""

REACH = 0.05
"""Turn between two points of the model, as a share of the loop's height, from which on there are more between them."""

Branches = list[tuple[Array, Array]]


@dataclass(frozen=True, eq=False)
class LoopCondition:
    """Under what the loops were taken: what was held, and at which crank angle [rad]."""

    held: Held
    crank: float


def put_all(model: Model, parameters: Sequence[Parameter], values: Array) -> Model:
    """Return a model with the values of parameters."""
    for parameter, value in zip(parameters, values, strict=False):
        model = parameter.put(model, float(value))
    return model


def model_branches(model: Model, bench: LoopCondition, loop: MeasuredLoop, shift: float = 0.0) -> Branches:
    """Compute torque [N m] and turn [rad] of a model along each branch of a loop, less a `shift` of torque [N m].

    The course before the loop is a loop as large, so that its first branch is that of a loop which closes.

    Raises
    ------
    RunError
        There is no balance.
    """
    ends, points = [end - shift for end in loop.turns], GRID if model.rubs else LOCKED_GRID
    ways = list(pairwise(ends))
    lead = [np.linspace(a, b, LEAD, endpoint=False) for a, b in ((0.0, ends[1]), (ends[1], ends[0]))]
    first = [way for place, way in enumerate(ways) if ways.index(way) == place]
    each = [np.linspace(a, b, points) for a, b in first]
    course = np.concatenate([*lead, *each])
    if model.rubs:
        when, turn = course_along(model.reducer, course, bench.crank, model.losses, bench.held, REACH * loop.height)
    else:
        curve = locked_curve(model.reducer, max(map(abs, ends)), bench.crank)
        when, turn = (
            np.arange(len(course), dtype=np.float64),
            locked_course(curve, slip_elements(model.reducer), course),
        )
    load = np.interp(when, np.arange(len(course)), course)
    parts = np.searchsorted(when, 2 * LEAD + points * np.arange(len(each) + 1))
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
    for number, (loads, turns) in enumerate(branches):
        here = loop.branch == number
        points = np.stack([loop.torque[here] / ranges[0], loop.deflection[here] / ranges[1]], axis=-1)
        line = np.stack([(loads + torque) / ranges[0], (turns + deflection) / ranges[1]], axis=-1)
        distance[here] = _from_line(points, line)
    return distance[loop.lead :]


def _from_line(points: Array, line: Array) -> Array:
    """Compute the distance of points (n, 2) from a line through points (m, 2), positive to the right of its way."""
    begin, along = line[:-1], np.diff(line, axis=0)
    square = np.maximum(np.sum(along**2, axis=1), 1e-30)
    way = points[:, np.newaxis] - begin
    share = np.clip(np.sum(way * along, axis=-1) / square, 0.0, 1.0)
    apart = way - share[..., np.newaxis] * along
    distance = np.linalg.norm(apart, axis=-1)
    nearest = np.argmin(distance, axis=1)
    rows = np.arange(len(points))
    beside, direction = apart[rows, nearest], along[nearest]
    cross = direction[:, 0] * beside[:, 1] - direction[:, 1] * beside[:, 0]
    return np.asarray(np.where(cross < 0.0, -1.0, 1.0) * distance[rows, nearest])
