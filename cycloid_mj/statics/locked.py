"""Rotation of the output at a locked crank along a torque path: elastic contacts with backlash, parallel to friction.

The contacts carry T_s and rotate the output by x(T_s) without friction (`statics.balance`); friction H acts in
parallel: T = T_s(x) + H(x). H is distributed over elements, each a spring that slips at a limit of its own (Iwan 1966,
J. Appl. Mech. 33, 893-900), so that it builds up over a travel as 1 - exp(-x/travel) and has hysteresis. Unlike in
`statics.friction_path`, the contacts have no friction: if they are stiff, they slide little at a locked crank.
Load-dependent friction (`LoadFriction`) adds mu |T_s| s(x), where s, from -1 to 1, builds up over a travel like H: that
of a reducer whose crank rotates during wind-up, so that all contacts slide.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import announce_compilation, njit
from cycloid_mj.design.model import StructureSprings
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics.balance import loads
from cycloid_mj.statics.friction_path import slip_rotations
from cycloid_mj.statics.rv import compute_rv_springs, solve_rv_loads
from cycloid_mj.statics.springs import springs_of
from cycloid_mj.statics.structure import wind_up

ELEMENTS = 3
"""Elements per friction: the number of joints that a MuJoCo model has for it."""

SHARES = (1e-3, 0.003, 0.01, 0.03, 0.06, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 1.0)
"""Torques relative to the largest, at which the rotation without friction is solved; it is interpolated linearly."""


class SlipElements(NamedTuple):
    """Slipping springs in parallel (Jenkin elements): limits [N m] and stiffness [N m/rad], shape (n,)."""

    limits: Array
    stiffness: Array


class LoadFriction(NamedTuple):
    """Friction proportional to the torque of the contacts.

    Attributes
    ----------
    share
        Fully developed friction relative to the torque of the contacts [1], below 1.
    slips
        Rotations at which its elements slip [rad], shape (n,).
    """

    share: float
    slips: Array


NO_LOAD_FRICTION = LoadFriction(0.0, np.zeros(0))


def load_friction(share: float, travel: float) -> LoadFriction:
    """Return friction of a share of the torque of the contacts [1] that builds up over a travel [rad]."""
    return LoadFriction(share, slip_rotations(travel, ELEMENTS)) if share else NO_LOAD_FRICTION


def slip_elements(reducer: Reducer) -> SlipElements:
    """Return the elastic elements that slip at a limit (Jenkin) and model constant friction and hysteresis of a design.

    They are parallel to the torsion of the output; their limits are in the table ``springs`` of the design. Friction
    and hysteresis have `ELEMENTS` elements each if their limit is above 0, and none otherwise.
    """
    springs = reducer.design.springs
    components = [
        (limit, travel)
        for limit, travel in (
            (springs.friction, springs.friction_travel),
            (springs.hysteresis, springs.hysteresis_travel),
        )
        if limit > 0.0
    ]
    limits = np.repeat([limit / ELEMENTS for limit, _ in components], ELEMENTS)
    rotations = [slip_rotations(travel, ELEMENTS) for _, travel in components]
    return SlipElements(limits, limits / np.concatenate(rotations) if rotations else limits)


@dataclass(frozen=True)
class LockedCurve:
    """Rotation of the output [rad] over the torque of the contacts [N m], both increasing, shape (m,)."""

    torque: Array
    turn: Array


def solve_locked_curve(reducer: Reducer, max_torque: float, crank: float) -> LockedCurve:
    """Solve for the curve of output rotation over torque, with the crank locked at an angle [rad].

    The sun of an RV reducer is locked instead; `crank` is the angle of its cranks relative to the ring. Friction and
    weight are left out. The torque of the curve reaches the next power of 2 from `max_torque` [N m] in both directions,
    so that similar torques share a solution.

    Raises
    ------
    RunError
        There is no equilibrium.
    """
    design = reducer.design
    drive = design.drive.model_copy(update={"speed": 0.0})
    if isinstance(reducer, RvReducer):
        rv_reducer = RvReducer(design.model_copy(update={"springs": StructureSprings(), "drive": drive}))
        return _solve_rv_curve(rv_reducer, 2.0 ** math.ceil(math.log2(max_torque)), crank)
    rigid_reducer = Reducer(design.model_copy(update={"springs": StructureSprings(), "drive": drive}))
    curve = _solve_contact_curve(rigid_reducer, 2.0 ** math.ceil(math.log2(max_torque)), crank)
    return replace(curve, turn=curve.turn + (wind_up(reducer) - wind_up(rigid_reducer)) * curve.torque)


@lru_cache(maxsize=16)
def _solve_contact_curve(reducer: Reducer, max_torque: float, crank: float) -> LockedCurve:
    """Solve for torque and rotation of the output at a locked crank angle [rad], up to +-`max_torque` [N m].

    Across the backlash, the torque rises from -1e-6 to 1e-6 of `max_torque`, so that it increases everywhere.
    `reducer` must have a rigid structure: the caller adds the torsion, so that a fit of torsion needs no new solution.
    """
    weightless_reducer = reducer.but(environment={"gravity_x": 0.0, "gravity_y": 0.0})
    torque_shares = np.array(SHARES)
    springs = springs_of(weightless_reducer, np.full(len(torque_shares), crank), friction=False)
    # from the largest torque down: solutions with barely touching contacts start from those with firm contact
    decreasing_torque = max_torque * torque_shares[::-1]
    side_rotations = [
        loads(weightless_reducer, springs, sign * decreasing_torque, warm_start=True).output_turn[::-1]
        for sign in (-1.0, 1.0)
    ]
    return _join_sides(max_torque, side_rotations)


@lru_cache(maxsize=16)
def _solve_rv_curve(reducer: RvReducer, max_torque: float, crank: float) -> LockedCurve:
    """Solve for torque and rotation of the output of an RV reducer at a locked sun, up to +-`max_torque` [N m]."""
    torque_shares = np.array(SHARES)
    torque = reducer.share * max_torque * np.concatenate([-torque_shares, torque_shares])
    turn = reducer.share * solve_rv_loads(compute_rv_springs(reducer, np.full(torque.size, crank)), torque).carrier_turn
    return _join_sides(max_torque, np.split(turn, 2))


def _join_sides(max_torque: float, side_rotations: Sequence[Array]) -> LockedCurve:
    """Join the output rotations [rad] under negative and under positive torques to a curve over the torque.

    `side_rotations` are the rotations under negative, then those under positive torques. The torques are `SHARES`
    of `max_torque` [N m], the same on both sides.
    """
    torque_shares = np.array(SHARES)
    # the line through the two smallest torques extrapolates to the point where the contacts close
    stop_rotations = [
        turns[0] - (turns[1] - turns[0]) * torque_shares[0] / (torque_shares[1] - torque_shares[0])
        for turns in side_rotations
    ]
    # a small torque across the backlash, so that the torque is unique at every rotation
    torque = max_torque * np.concatenate([-torque_shares[::-1], [-1e-6, 1e-6], torque_shares])
    rotation = np.concatenate([side_rotations[0][::-1], [stop_rotations[0], stop_rotations[1]], side_rotations[1]])
    return LockedCurve(torque, np.maximum.accumulate(rotation))


def follow_locked_path(curve: LockedCurve, elements: SlipElements, torque: Array) -> Array:
    """Compute the rotation of the output [rad] along a torque path of n points [N m], (n,), from rest.

    `curve` is the rotation due to the contacts without friction, which is extrapolated linearly; `elements` are the
    slip elements. Between reversals of the path, the rotation is interpolated on a branch of `locked_branches`.
    """
    path = np.concatenate([[0.0], torque])
    reversals = 1 + np.flatnonzero(np.diff(np.sign(np.diff(path))))
    end_indices = [0, *reversals.tolist(), len(torque)]
    branches = locked_branches(curve, elements, path[end_indices].tolist())
    return np.concatenate(
        [
            np.interp(path[start_index + 1 : end_index + 1], *_by_increasing_torque(branch))
            for (start_index, end_index), branch in zip(pairwise(end_indices), branches, strict=True)
        ]
    )


def locked_branches(
    curve: LockedCurve, elements: SlipElements, reversals: Sequence[float], friction: LoadFriction = NO_LOAD_FRICTION
) -> list[tuple[Array, Array]]:
    """Compute the branches of a hysteresis loop with a locked crank, from each reversal torque to the next.

    The torque T(x) of contacts, slip elements and load-dependent friction is piecewise linear and increasing in the
    rotation x, with vertices at the points of the curve and at the slip limits. The inverse of this function is a
    branch. At a reversal, each element keeps its force (Masing's rules follow).

    Parameters
    ----------
    curve, elements
        Rotation due to the contacts without friction, and slip elements of constant friction.
    reversals
        Torques at which branches begin and end [N m], shape (branches + 1,); the first is the torque at rest.
    friction
        Friction proportional to the torque of the contacts.

    Returns
    -------
    list of tuple
        Torque [N m] and rotation [rad] at the vertices of each branch, shape (m,) each, in the order of the path.
    """
    largest_torque = max(map(abs, reversals)) + float(elements.limits.sum())
    rotation, contact_torque = _extend_curve(curve, largest_torque / (1.0 - friction.share))
    with announce_compilation():
        branches: list[tuple[Array, Array]] = _compute_vertices(
            rotation,
            contact_torque,
            # numba compiles everything again for another memory layout
            np.ascontiguousarray(elements.limits),
            np.ascontiguousarray(elements.stiffness),
            friction.share,
            friction.slips,
            np.array(reversals),
        )
    return branches


@njit(cache=True)
def _compute_vertices(
    rotation: Array,
    contact_torque: Array,
    limits: Array,
    stiffness: Array,
    share: float,
    friction_slip: Array,
    reversals: Array,
) -> list[tuple[Array, Array]]:
    """Compute torque [N m] and rotation [rad] at the vertices of each branch of a loop, which is piecewise linear.

    Parameters
    ----------
    rotation, contact_torque
        Points of the curve due to the contacts, both increasing, shape (points,) [rad] and [N m].
    limits, stiffness
        Limits [N m] and stiffness [N m/rad] of the slip elements of constant friction, shape (elements,).
    share, friction_slip
        Share [1] and slip rotations [rad] of the friction in proportion to the torque of the contacts.
    reversals
        Torques at which branches begin and end [N m], shape (branches + 1,).
    """
    slip = limits / stiffness
    # rest positions of the elements of constant friction and of load-dependent friction
    origin, load_origin = np.zeros(len(slip)), np.zeros(len(friction_slip))
    branches = []
    for branch in range(len(reversals) - 1):
        friction_vertices = np.concatenate((load_origin - friction_slip, load_origin + friction_slip))
        vertices = np.sort(np.concatenate((rotation, origin - slip, origin + slip, friction_vertices)))
        total_torque = np.interp(vertices, rotation, contact_torque)
        if len(friction_slip):
            friction_state = np.zeros(len(vertices))
            for element in range(len(friction_slip)):
                friction_state += np.minimum(
                    np.maximum((vertices - load_origin[element]) / friction_slip[element], -1.0), 1.0
                )
            total_torque += share / len(friction_slip) * np.abs(total_torque) * friction_state
        for element in range(len(slip)):
            element_rotation = np.minimum(np.maximum(vertices - origin[element], -slip[element]), slip[element])
            total_torque += stiffness[element] * element_rotation
        min_torque, max_torque = (
            min(reversals[branch], reversals[branch + 1]),
            max(reversals[branch], reversals[branch + 1]),
        )
        inner_torque = total_torque[(total_torque > min_torque) & (total_torque < max_torque)]
        torque = np.concatenate((np.array([min_torque]), inner_torque, np.array([max_torque])))
        if reversals[branch + 1] < reversals[branch]:
            torque = torque[::-1].copy()
        vertex_rotation = np.interp(torque, total_torque, vertices)
        branches.append((torque, vertex_rotation))
        origin = np.minimum(np.maximum(origin, vertex_rotation[-1] - slip), vertex_rotation[-1] + slip)
        load_origin = np.minimum(
            np.maximum(load_origin, vertex_rotation[-1] - friction_slip), vertex_rotation[-1] + friction_slip
        )
    return branches


def _by_increasing_torque(branch: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return a branch, torque [N m] and rotation [rad], in the order of increasing torque."""
    torque, rotation = branch
    return branch if torque[-1] >= torque[0] else (torque[::-1], rotation[::-1])


def _extend_curve(curve: LockedCurve, end_torque: float) -> tuple[Array, Array]:
    """Extend a curve of torque and rotation linearly to +-`end_torque` [N m].

    A point is left out unless its rotation exceeds that of all points before it, so that torque and rotation increase.

    Returns
    -------
    tuple of Array
        Rotations [rad] and torques [N m], shape (m,) each.
    """
    slopes = [np.diff(curve.turn)[end_index] / np.diff(curve.torque)[end_index] for end_index in (0, -1)]
    end_rotations = [
        curve.turn[end_index] + slope * (sign * end_torque - curve.torque[end_index])
        for end_index, slope, sign in zip((0, -1), slopes, (-1.0, 1.0), strict=True)
    ]
    is_shorter = abs(curve.torque[0]) < end_torque
    torque = np.concatenate([[-end_torque], curve.torque, [end_torque]]) if is_shorter else curve.torque
    rotation = np.concatenate([[end_rotations[0]], curve.turn, [end_rotations[1]]]) if is_shorter else curve.turn
    is_increasing = np.concatenate([[True], rotation[1:] > np.maximum.accumulate(rotation)[:-1]])
    return rotation[is_increasing], torque[is_increasing]
