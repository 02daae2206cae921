"""Rotation of the output at a locked crank along a torque path: elastic contacts with backlash, parallel to friction.

The contacts carry T_s and rotate the output by x(T_s) without friction (`statics.balance`); friction H acts in
parallel: T = T_s(x) + H(x). H is distributed over elements, each a spring that slips at a limit of its own (Iwan 1966,
J. Appl. Mech. 33, 893-900), so that it builds up over a travel as 1 - exp(-x/travel) and has hysteresis. Unlike in
`statics.friction_path`, the contacts have no friction: with stiff ones, they slide little at a locked crank.
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
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.balance import loads
from cycloid_mj.statics.friction_path import slip_turns
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
    return LoadFriction(share, slip_turns(travel, ELEMENTS)) if share else NO_LOAD_FRICTION


def slip_elements(reducer: Reducer) -> SlipElements:
    """Return the slip elements of the friction of a design's wind-up; empty without such friction."""
    springs = reducer.design.springs
    frictions = [
        (size, travel)
        for size, travel in (
            (springs.friction, springs.friction_travel),
            (springs.hysteresis, springs.hysteresis_travel),
        )
        if size > 0.0
    ]
    limits = np.repeat([size / ELEMENTS for size, _ in frictions], ELEMENTS)
    turns = [slip_turns(travel, ELEMENTS) for _, travel in frictions]
    return SlipElements(limits, limits / np.concatenate(turns) if turns else limits)


@dataclass(frozen=True)
class LockedCurve:
    """Rotation of the output [rad] over the torque of the contacts [N m], both increasing, shape (m,)."""

    torque: Array
    turn: Array


def locked_curve(reducer: Reducer, most: float, crank: float) -> LockedCurve:
    """Solve for the rotation of the output without friction and weight under torques from -`most` to `most` [N m].

    Raises
    ------
    RunError
        There is no equilibrium.
    """
    design = reducer.design
    drive = design.drive.model_copy(update={"speed": 0.0})
    shaped = Reducer(design.model_copy(update={"springs": StructureSprings(), "drive": drive}))
    curve = _curve(shaped, 2.0 ** math.ceil(math.log2(most)), crank)
    return replace(curve, turn=curve.turn + (wind_up(reducer) - wind_up(shaped)) * curve.torque)


@lru_cache(maxsize=16)
def _curve(reducer: Reducer, most: float, crank: float) -> LockedCurve:
    """Solve for the curve of the contacts; torsion is added later, so that a fit of torsion needs no new solution."""
    still = reducer.but(environment={"gravity_x": 0.0, "gravity_y": 0.0})
    shares = np.array(SHARES)
    springs = springs_of(still, np.full(len(shares), crank), friction=False)
    # from the largest torque down: solutions with barely touching contacts start from those with firm contact
    falling = most * shares[::-1]
    sides = [loads(still, springs, way * falling, follow=True).output_turn[::-1] for way in (-1.0, 1.0)]
    # the line through the two smallest torques extrapolates to the point where the contacts close
    stops = [side[0] - (side[1] - side[0]) * shares[0] / (shares[1] - shares[0]) for side in sides]
    # a small torque across the backlash, so that the torque is unique at every rotation
    torque = most * np.concatenate([-shares[::-1], [-1e-6, 1e-6], shares])
    turn = np.concatenate([sides[0][::-1], [stops[0], stops[1]], sides[1]])
    return LockedCurve(torque, np.maximum.accumulate(turn))


def locked_course(curve: LockedCurve, elements: SlipElements, torque: Array) -> Array:
    """Compute the rotation of the output [rad] along a torque path [N m], shape (n,) each, from rest.

    The curve is extrapolated linearly.
    """
    course = np.concatenate([[0.0], torque])
    turning = 1 + np.flatnonzero(np.diff(np.sign(np.diff(course))))
    ends = [0, *turning.tolist(), len(torque)]
    lines = locked_branches(curve, elements, course[ends].tolist())
    stretches = zip(pairwise(ends), lines, strict=True)
    return np.concatenate([np.interp(course[a + 1 : b + 1], *_increasing(line)) for (a, b), line in stretches])


def locked_branches(
    curve: LockedCurve, elements: SlipElements, ends: Sequence[float], load: LoadFriction = NO_LOAD_FRICTION
) -> list[tuple[Array, Array]]:
    """Compute torque [N m] and rotation [rad] at the vertices, shape (m,) each, from torque to torque, from rest.

    T(x) is piecewise linear between the points of the curve and the slip limits of the elements; it increases, and is
    inverted.
    """
    largest = max(map(abs, ends)) + float(elements.limits.sum())
    turn, carried = _extend(curve, largest / (1.0 - load.share))
    with announce_compilation():
        lines: list[tuple[Array, Array]] = _compute_vertices(
            turn, carried, elements.limits, elements.stiffness, load.share, load.slips, np.array(ends)
        )
    return lines


@njit(cache=True)
def _compute_vertices(
    turn: Array, carried: Array, limits: Array, stiffness: Array, share: float, load_slip: Array, ends: Array
) -> list[tuple[Array, Array]]:
    """Compute the vertices of torque and rotation of each branch; see `locked_branches`."""
    slip = limits / stiffness
    # rest positions of the elements of constant friction and of load-dependent friction
    origin, load_origin = np.zeros(len(slip)), np.zeros(len(load_slip))
    lines = []
    for place in range(len(ends) - 1):
        inner = np.concatenate((load_origin - load_slip, load_origin + load_slip))
        bends = np.sort(np.concatenate((turn, origin - slip, origin + slip, inner)))
        held = np.interp(bends, turn, carried)
        if len(load_slip):
            rising = np.zeros(len(bends))
            for element in range(len(load_slip)):
                rising += np.minimum(np.maximum((bends - load_origin[element]) / load_slip[element], -1.0), 1.0)
            held += share / len(load_slip) * np.abs(held) * rising
        for element in range(len(slip)):
            stretch = np.minimum(np.maximum(bends - origin[element], -slip[element]), slip[element])
            held += stiffness[element] * stretch
        low, high = min(ends[place], ends[place + 1]), max(ends[place], ends[place + 1])
        between = held[(held > low) & (held < high)]
        torque = np.concatenate((np.array([low]), between, np.array([high])))
        if ends[place + 1] < ends[place]:
            torque = torque[::-1].copy()
        reached = np.interp(torque, held, bends)
        lines.append((torque, reached))
        origin = np.minimum(np.maximum(origin, reached[-1] - slip), reached[-1] + slip)
        load_origin = np.minimum(np.maximum(load_origin, reached[-1] - load_slip), reached[-1] + load_slip)
    return lines


def _increasing(line: tuple[Array, Array]) -> tuple[Array, Array]:
    return line if line[0][-1] >= line[0][0] else (line[0][::-1], line[1][::-1])


def _extend(curve: LockedCurve, far: float) -> tuple[Array, Array]:
    """Draw a curve on to a torque at either end: turns and torques, both rising strictly."""
    slopes = [np.diff(curve.turn)[end] / np.diff(curve.torque)[end] for end in (0, -1)]
    ends = [
        curve.turn[end] + slope * (way * far - curve.torque[end])
        for end, slope, way in zip((0, -1), slopes, (-1.0, 1.0), strict=True)
    ]
    inside = abs(curve.torque[0]) < far
    torque = np.concatenate([[-far], curve.torque, [far]]) if inside else curve.torque
    turn = np.concatenate([[ends[0]], curve.turn, [ends[1]]]) if inside else curve.turn
    rising = np.concatenate([[True], np.diff(turn) > 0.0])
    return turn[rising], torque[rising]
