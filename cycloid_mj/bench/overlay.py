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
from cycloid_mj.statics.friction_path import Held, follow_torque_path
from cycloid_mj.statics.locked import load_friction, locked_branches, slip_elements, solve_locked_curve


@dataclass(frozen=True)
class BranchSettings:
    """Points of the branches of a model with friction in its contacts.

    Attributes
    ----------
    points, lead_points
        Number of torques of a branch, and of each branch that leads to the loop.
    max_rotation
        Largest rotation between two points, as a share of the loop's height; more points are inserted.
    """

    points: int = 24
    lead_points: int = 8
    max_rotation: float = 0.05


SETTINGS = BranchSettings()

Branches = list[tuple[Array, Array]]


@dataclass(frozen=True, eq=False)
class LoopCondition:
    """Condition of a measurement: the locked shaft, the crank angle [rad], and the largest torque [N m]."""

    held: Held
    crank: float
    max_torque: float


def apply_values(model: Model, parameters: Sequence[Parameter], values: Array) -> Model:
    """Return a model with the values of parameters, in their units; values beyond the parameters are ignored."""
    for parameter, value in zip(parameters, values, strict=False):
        model = parameter.apply(model, float(value))
    return model


def model_branches(model: Model, condition: LoopCondition, loop: MeasuredLoop, torque_offset: float = 0.0) -> Branches:
    """Compute torque [N m] and rotation [rad] of a model along each branch of a measured loop, as pairs of arrays.

    A branch is the curve between two reversals of the torque. The model reverses at the reversal torques of the loop
    minus `torque_offset` [N m]. It starts from rest; two branches that lead from rest to the loop are computed and
    omitted. `condition` has the locked shaft and the crank angle of the measurement.
    """
    reversals = [reversal - torque_offset for reversal in loop.turns]
    if model.contact_friction:
        return _branches_with_contact_friction(model, condition, reversals, SETTINGS.max_rotation * loop.height)
    curve = solve_locked_curve(model.reducer, condition.max_torque, condition.crank)
    # two branches lead to the loop: from rest to its second end, and back to its first
    load = load_friction(model.losses.load, model.reducer.design.springs.friction_travel)
    return locked_branches(curve, slip_elements(model.reducer), [0.0, reversals[1], *reversals], load)[2:]


def _branches_with_contact_friction(
    model: Model, condition: LoopCondition, reversals: list[float], max_turn: float
) -> Branches:
    """Compute torque [N m] and rotation [rad] along the branches between reversals, with friction in the contacts.

    `model` is the model of the drive, and `condition` has the locked shaft and the crank angle of the measurement.
    `reversals` are torques [N m], `max_turn` [rad] is the largest rotation between neighbouring points. Two branches,
    from rest to the second reversal and back to the first, are computed first and omitted from the result.
    """
    torque_spans = list(pairwise(reversals))
    lead_torques = [
        np.linspace(start, end, SETTINGS.lead_points, endpoint=False)
        for start, end in ((0.0, reversals[1]), (reversals[1], reversals[0]))
    ]
    distinct_spans = list(dict.fromkeys(torque_spans))
    torque_path = np.concatenate(
        [*lead_torques, *(np.linspace(start, end, SETTINGS.points) for start, end in distinct_spans)]
    )
    positions, rotation = follow_torque_path(
        model.reducer, torque_path, condition.crank, model.losses, condition.held, max_turn
    )
    load = np.interp(positions, np.arange(len(torque_path)), torque_path)
    branch_starts = np.searchsorted(
        positions, 2 * SETTINGS.lead_points + SETTINGS.points * np.arange(len(distinct_spans) + 1)
    )
    branches = [(load[start:end], rotation[start:end]) for start, end in pairwise(branch_starts)]
    # a closed loop repeats its branches
    return [branches[distinct_spans.index(span)] for span in torque_spans]


def interpolate_deflections(loop: MeasuredLoop, branches: Branches) -> Array:
    """Interpolate the model's deflection [rad] at every measured point, on its branch at the same torque, (n,)."""
    deflection_at_points = np.empty(len(loop.torque))
    for branch_index, (torque, deflection) in enumerate(branches):
        is_on_branch, order = loop.branch == branch_index, np.argsort(torque)
        deflection_at_points[is_on_branch] = np.interp(loop.torque[is_on_branch], torque[order], deflection[order])
    return deflection_at_points


def branch_distances(loop: MeasuredLoop, branches: Branches, torque_offset: float, deflection_offset: float) -> Array:
    """Compute the signed distance [1] of each measured point from the model's branch, shape (points,).

    The points that only lead from rest to the loop (`MeasuredLoop.points_left_out`) are omitted.
    `branches` are the model's curves between reversals of the torque. Torque and deflection are divided by the loop's
    ranges. `torque_offset` [N m] and `deflection_offset` [rad] are added to the branches. The distance is positive for
    points to the left of the branch, seen in its direction.
    """
    ranges = float(np.ptp(loop.torque)), loop.height
    distance = np.zeros(len(loop.torque))
    points = loop.torque / ranges[0], loop.deflection / ranges[1]
    with announce_compilation():
        for branch_index, (loads, rotations) in enumerate(branches):
            polyline = (loads + torque_offset) / ranges[0], (rotations + deflection_offset) / ranges[1]
            _write_distances(points, loop.branch == branch_index, polyline, distance)
    return distance[loop.points_left_out :]


@njit(cache=True)
def _write_distances(points: tuple[Array, Array], mask: Mask, polyline: tuple[Array, Array], distance: Array) -> None:
    """Compute the signed distance of selected points from a polyline, positive on its left, and write it to `distance`.

    `points` and `polyline` are pairs of coordinates x and y of n points and m vertices, shapes (n,) and (m,). `mask`
    (n,) selects the points; only their values in `distance` (n,) are changed, in place.
    """
    for index in np.flatnonzero(mask):
        min_offset = np.inf
        for vertex in range(len(polyline[0]) - 1):
            edge_x, edge_y = (
                polyline[0][vertex + 1] - polyline[0][vertex],
                polyline[1][vertex + 1] - polyline[1][vertex],
            )
            x, y = points[0][index] - polyline[0][vertex], points[1][index] - polyline[1][vertex]
            edge_share = min(max((x * edge_x + y * edge_y) / max(edge_x**2 + edge_y**2, 1e-30), 0.0), 1.0)
            offset = math.hypot(x - edge_share * edge_x, y - edge_share * edge_y)
            if offset < min_offset:
                min_offset = offset
                distance[index] = offset if edge_x * y - edge_y * x >= 0.0 else -offset
