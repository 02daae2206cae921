"""How far rigid parts can move at a locked crank, as linear programmes: the pose with the most room, and the stops.

Rigid contacts only push, so every gap is a limit on the unknowns of ``gaps``. A cam's play is a circle: a polygon
around it stands for it, larger than the circle by 1 - cos(pi/sides).
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import RunError
from cycloid_mj.geometry import profile
from cycloid_mj.reducer.gaps import Gaps, cam_places, gaps, unknowns

if TYPE_CHECKING:
    from cycloid_mj.reducer import Reducer

_SCALE = 1e-6
"""Unit of length of the programmes [m]."""

CAM_SIDES = 720
"""Sides of the polygon around a cam's play: it is larger than the circle by 1e-5 of the play."""

_FIT_SIDES = 16
"""The same where only a place to start from is looked for."""

_TOGETHER = 8
"""Crank angles whose stops are looked for in one programme: most of a small one's time is to hand it over."""


@dataclass(frozen=True)
class Fit:
    """A pose at one crank angle: that which leaves the most room, or any other.

    Attributes
    ----------
    room
        Smallest gap of any pair in this pose [m]; negative where the parts only go together pressed into each other.
    shift
        Of each disc's centre from the ideal one, seen from the ring [m], shape (D, 2).
    gear_turn
        Angle of each disc less the ideal one [rad], shape (D,).
    output_turn
        Angle of the output less the ideal one [rad].
    pin_shift
        Of each pin or sleeve that moves, out of the gear's way [m], shape (N, 2); zero for pins that do not.
    """

    room: float
    shift: Array
    gear_turn: Array
    output_turn: float
    pin_shift: Array


def best_fit(reducer: "Reducer", crank: float) -> Fit:
    """Find the pose at a crank angle [rad] that leaves the most room in all pairs."""
    mesh_gaps, pose, least, _ = _most_room(reducer, crank)
    return _fit(reducer, mesh_gaps, pose, least)


def pressed_fit(reducer: "Reducer", crank: float, pose: Array) -> Fit:
    """Tell a pose of the unknowns of ``gaps`` [m], shape (u,), at a crank angle [rad]; its room is not looked for."""
    return _fit(reducer, gaps(reducer, float(reducer.member.against_ring(crank))), pose, math.nan)


def _fit(reducer: "Reducer", mesh_gaps: Gaps, pose: Array, least: float) -> Fit:
    design = reducer.design
    radius, discs = design.output.pin_circle_radius, pose[:-1].reshape(-1, 3)
    turned, carrier = discs[:, 2] / radius, float(pose[-1]) / radius
    output = reducer.member.sense * reducer.share * carrier
    ring, _ = reducer.member.ring_and_carrier(output)
    # a ring that turns at a locked crank takes the gear along by N/(N-1) of its turn
    turned = turned + ring * design.ring.teeth / design.lobes
    return Fit(least, discs[:, :2], turned, output, _aside(reducer, mesh_gaps, pose))


def tightest(reducer: "Reducer", crank: float) -> tuple[float, dict[str, float]]:
    """Find the room of `best_fit` at a crank angle [rad], and which pairs leave no more.

    Clearances may be negative here, as in no design file.

    Returns
    -------
    The room [m], and the share of each kind of pair, ``cam`` among them, in the forces that would press the parts into
    this pose (the programme's dual values): together 1.
    """
    mesh_gaps, _, least, forces = _most_room(reducer, crank)
    kinds = np.concatenate([mesh_gaps.kind, np.full(len(forces) - len(mesh_gaps.kind), "cam")])
    return least, {str(kind): float(forces[kinds == kind].sum()) for kind in np.unique(kinds)}


def _most_room(reducer: "Reducer", crank: float) -> tuple[Gaps, Array, float, Array]:
    """Return the gaps at a crank angle [rad], the pose (u,) [m] with the most room, that room [m], and dual values."""
    from scipy.optimize import linprog

    crank = float(reducer.member.against_ring(crank))
    mesh_gaps, cams = gaps(reducer, crank), cam_places(reducer, crank)
    slope, room = _limits(reducer, mesh_gaps, cams, _FIT_SIDES)
    count = unknowns(reducer)
    matrix = np.concatenate([-slope, np.ones((len(room), 1))], axis=1)
    best = linprog([0.0] * count + [-1.0], A_ub=matrix, b_ub=room / _SCALE, bounds=[(None, None)] * (count + 1))
    *free, least = np.asarray(best.x, dtype=np.float64)
    return mesh_gaps, _SCALE * np.array(free), _SCALE * float(least), -np.asarray(best.ineqlin.marginals)


def stops(reducer: "Reducer", crank: float, sides: int = CAM_SIDES) -> tuple[float, float]:
    """Compute the output's stops [rad], clockwise and counter-clockwise of the ideal angle, at a crank angle [rad].

    As `stops_at`, errors too.
    """
    low, high = stops_at(reducer, np.array([crank]), sides)[0].tolist()
    return low, high


def stops_at(reducer: "Reducer", cranks: Array, sides: int = CAM_SIDES) -> Array:
    """Compute the output's stops [rad], clockwise and counter-clockwise of the ideal angle, at crank angles [rad] (n,).

    All clearances, errors and modifications are in it; `sides` are those of the polygon around a cam's play.

    Returns
    -------
    Array
        Shape (n, 2).

    Raises
    ------
    RunError
        The errors leave no place for the gear: it jams.
    """
    together = [cranks[first : first + _TOGETHER] for first in range(0, len(cranks), _TOGETHER)]
    return np.concatenate([_stops(reducer, some, sides) for some in together])


def _stops(reducer: "Reducer", cranks: Array, sides: int) -> Array:
    """Solve one programme for the stops at some crank angles, which have no limits in common."""
    from scipy.optimize import linprog
    from scipy.sparse import block_diag, csc_array

    design, count = reducer.design, unknowns(reducer)
    seen = reducer.member.against_ring(cranks).tolist()
    limits = [_limits(reducer, gaps(reducer, angle), cam_places(reducer, angle), sides) for angle in seen]
    slope: Any = block_diag([csc_array(-slope) for slope, _ in limits for _ in range(2)], format="csc")
    room = np.concatenate([room for _, room in limits for _ in range(2)])
    goal = np.zeros((len(cranks), 2, count))
    goal[:, :, -1] = 1.0, -1.0
    # to look for limits that say nothing takes longer than to solve with them
    ends = linprog(goal.ravel(), slope, room / _SCALE, bounds=(None, None), options={"presolve": False})
    if ends.x is None:
        if len(cranks) > 1:
            return np.concatenate([_stops(reducer, crank, sides) for crank in cranks[:, np.newaxis]])
        at = f"at crank angle {float(cranks[0]):.4f} rad"
        if design.ring.preload:
            raise RunError(
                f"the two halves of the ring clamp the disc {at}: rigid parts have no free rotation there; use the "
                "static loads, which include deflection, or lower ring.preload_arcmin"
            )
        raise RunError(
            f"the disc jams {at}: manufacturing errors exceed the clearances; increase clearance.* or reduce errors.*"
        )
    turns = np.asarray(ends.x).reshape(goal.shape)[:, :, -1] * _SCALE / design.output.pin_circle_radius
    return np.sort(reducer.member.sense * reducer.share * turns, axis=1)


def widest_play(reducer: "Reducer", crank: float, sides: int = CAM_SIDES) -> float:
    """Compute the output's play between rigid parts [rad] at a crank angle [rad]; errors as `stops`.

    Halves of a ring count as not turned against each other: that leaves the most.
    """
    low, high = stops(reducer.but(ring={"preload": 0.0}), crank, sides)
    return high - low


def _limits(reducer: "Reducer", mesh_gaps: Gaps, cams: Array, sides: int) -> tuple[Array, Array]:
    """Compute gradients (m, u) [1] and rooms (m,) [m] of slope . z + room >= 0: contacts, then polygons of `cams`.

    These are the cams' places [m], shape (D, 2).
    """
    slopes, rooms = [mesh_gaps.slope], [mesh_gaps.width + mesh_gaps.play]
    around = profile.unit(np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False))
    for disc, place in enumerate(cams):
        slope = np.zeros((sides, unknowns(reducer)))
        slope[:, 3 * disc : 3 * disc + 2] = -around
        slopes.append(slope)
        rooms.append(reducer.design.clearance.cam + around @ place)
    return np.concatenate(slopes), np.concatenate(rooms)


def _aside(reducer: "Reducer", mesh_gaps: Gaps, pose: Array) -> Array:
    """Put each pin that discs would cut half-way between the one that cuts deepest and the far side of its play."""
    design = reducer.design
    if not design.ring.has_moving_pins:
        return np.zeros((design.ring.mates, 2))
    teeth = mesh_gaps.select(mesh_gaps.kind == design.tooth_pair)
    gap = teeth.width + teeth.slope @ pose
    outwards = -teeth.slope[:, :-1].reshape(len(gap), -1, 3)[np.arange(len(gap)), teeth.disc, :2]
    deepest = np.lexsort((gap, teeth.owner))[:: design.gear.discs]
    aside = ((teeth.play - gap) / 2.0)[:, np.newaxis] * outwards
    return np.asarray(np.where(gap[:, np.newaxis] < 0.0, aside, 0.0)[deepest])
