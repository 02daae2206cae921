"""Limits of motion of rigid parts at a locked crank, by linear programming: best fit, and stops of the output.

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


@dataclass(frozen=True)
class FitSettings:
    """Settings of the linear programs of best fit and of the stops."""

    scale: float = 1e-6
    """Length unit of the linear programs [m]."""
    cam_sides: int = 720
    """Sides of the polygon around the clearance of a cam: it is larger than the circle by 1e-5 of the clearance."""
    fit_sides: int = 16
    """Sides of that polygon for a starting point."""
    batch: int = 8
    """Number of crank angles per linear program, most of whose time is its set-up."""


FIT = FitSettings()


@dataclass(frozen=True)
class Fit:
    """Pose of discs and output at one crank angle.

    Attributes
    ----------
    room
        Smallest gap of any pair in this pose [m]; negative where the parts only go together pressed into each other.
    shift
        Displacement of each disc's centre from the ideal one, seen from the ring [m], shape (D, 2).
    gear_turn
        Angle of each disc less the ideal one [rad], shape (D,).
    output_turn
        Angle of the output less the ideal one [rad].
    pin_shift
        Displacement of each moving pin or sleeve that avoids an overlap [m], shape (N, 2); zero for fixed pins.
    """

    room: float
    shift: Array
    gear_turn: Array
    output_turn: float
    pin_shift: Array


def best_fit(reducer: "Reducer", crank: float) -> Fit:
    """Return the pose with the largest minimum gap of all pairs at a crank angle [rad]."""
    mesh_gaps, pose, least, _ = _most_room(reducer, crank)
    return _fit(reducer, mesh_gaps, pose, least)


def pressed_fit(reducer: "Reducer", crank: float, pose: Array) -> Fit:
    """Return the pose for unknowns of ``gaps`` [m], shape (u,), at a crank angle [rad], without its minimum gap."""
    return _fit(reducer, gaps(reducer, float(reducer.member.against_ring(crank))), pose, math.nan)


def _fit(reducer: "Reducer", mesh_gaps: Gaps, pose: Array, least: float) -> Fit:
    """Return the pose for unknowns of ``gaps`` [m], shape (u,), with its minimum gap [m]."""
    design = reducer.design
    radius, discs = design.output.pin_circle_radius, pose[:-1].reshape(-1, 3)
    turned, carrier = discs[:, 2] / radius, float(pose[-1]) / radius
    output = reducer.member.sense * reducer.share * carrier
    ring, _ = reducer.member.ring_and_carrier(output)
    # a ring that turns at a locked crank takes the gear along by N/(N-1) of its turn
    turned = turned + ring * design.ring.teeth / design.lobes
    return Fit(least, discs[:, :2], turned, output, _aside(reducer, mesh_gaps, pose))


def tightest(reducer: "Reducer", crank: float) -> tuple[float, dict[str, float]]:
    """Return the minimum gap of `best_fit` at a crank angle [rad], and the pairs that have it.

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
    """Return gaps, best fit (u,) [m], its minimum gap [m] and dual values at a crank angle [rad]."""
    from scipy.optimize import linprog

    crank = float(reducer.member.against_ring(crank))
    mesh_gaps, cams = gaps(reducer, crank), cam_places(reducer, crank)
    slope, room = _limits(reducer, mesh_gaps, cams, FIT.fit_sides)
    count = unknowns(reducer)
    matrix = np.concatenate([-slope, np.ones((len(room), 1))], axis=1)
    best = linprog([0.0] * count + [-1.0], A_ub=matrix, b_ub=room / FIT.scale, bounds=[(None, None)] * (count + 1))
    *free, least = np.asarray(best.x, dtype=np.float64)
    return mesh_gaps, FIT.scale * np.array(free), FIT.scale * float(least), -np.asarray(best.ineqlin.marginals)


def stops(reducer: "Reducer", crank: float, sides: int = FIT.cam_sides) -> tuple[float, float]:
    """Compute the output's stops [rad], clockwise and counter-clockwise of the ideal angle, at a crank angle [rad].

    As `stops_at`, errors too.
    """
    low, high = stops_at(reducer, np.array([crank]), sides)[0].tolist()
    return low, high


def stops_at(reducer: "Reducer", cranks: Array, sides: int = FIT.cam_sides) -> Array:
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
    together = [cranks[first : first + FIT.batch] for first in range(0, len(cranks), FIT.batch)]
    return np.concatenate([_stops(reducer, some, sides) for some in together])


def _stops(reducer: "Reducer", cranks: Array, sides: int) -> Array:
    """Solve one linear program for the stops at several crank angles, which are independent of each other."""
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
    ends = linprog(goal.ravel(), slope, room / FIT.scale, bounds=(None, None), options={"presolve": False})
    if ends.x is None:
        if len(cranks) > 1:
            return np.concatenate([_stops(reducer, crank, sides) for crank in cranks[:, np.newaxis]])
        where = f"at crank angle {float(cranks[0]):.4f} rad"
        if design.ring.preload:
            raise RunError(
                f"the two halves of the ring clamp the disc {where}, so rigid parts cannot rotate there: reduce "
                "ring.preload_arcmin, or use `cycloid-mj statics`, which includes deflection"
            )
        raise RunError(
            f"the disc jams {where}, because the manufacturing errors exceed the clearances: increase clearance.* or "
            "reduce errors.*"
        )
    turns = np.asarray(ends.x).reshape(goal.shape)[:, :, -1] * FIT.scale / design.output.pin_circle_radius
    return np.sort(reducer.member.sense * reducer.share * turns, axis=1)


def widest_play(reducer: "Reducer", crank: float, sides: int = FIT.cam_sides) -> float:
    """Compute the backlash of the output with rigid parts [rad] at a crank angle [rad]; errors as `stops`.

    Halves of a ring count as not turned against each other: that leaves the most.
    """
    low, high = stops(reducer.but(ring={"preload": 0.0}), crank, sides)
    return high - low


def _limits(reducer: "Reducer", mesh_gaps: Gaps, cams: Array, sides: int) -> tuple[Array, Array]:
    """Return gradients (m, u) [1] and gaps (m,) [m] of slope . z + gap >= 0: contacts, then polygons of `cams`.

    These are the cams' places [m], shape (D, 2).
    """
    slopes, rooms = [mesh_gaps.slope], [mesh_gaps.width + mesh_gaps.play]
    around = profile.unit(np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False))
    for disc, cam in enumerate(cams):
        slope = np.zeros((sides, unknowns(reducer)))
        slope[:, 3 * disc : 3 * disc + 2] = -around
        slopes.append(slope)
        rooms.append(reducer.design.clearance.cam + around @ cam)
    return np.concatenate(slopes), np.concatenate(rooms)


def _aside(reducer: "Reducer", mesh_gaps: Gaps, pose: Array) -> Array:
    """Return the displacements of moving pins [m], shape (mates, 2), that avoid an overlap with the discs.

    They are half-way from the deepest overlap to the far side of the clearance; 0 without an overlap.
    """
    design = reducer.design
    if not design.ring.has_moving_pins:
        return np.zeros((design.ring.mates, 2))
    teeth = mesh_gaps.select(mesh_gaps.kind == design.tooth_pair)
    gap = teeth.width + teeth.slope @ pose
    outwards = -teeth.slope[:, :-1].reshape(len(gap), -1, 3)[np.arange(len(gap)), teeth.disc, :2]
    deepest = np.lexsort((gap, teeth.owner))[:: design.gear.discs]
    aside = ((teeth.play - gap) / 2.0)[:, np.newaxis] * outwards
    return np.asarray(np.where(gap[:, np.newaxis] < 0.0, aside, 0.0)[deepest])
