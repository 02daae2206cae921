"""Limits of motion of rigid parts at a locked crank, by linear programming: best fit, and stops of the output.

Rigid contacts only push, so every gap is a limit on the unknowns. A pose is a vector of the unknowns z of the module
``gaps``, in metres, shape (u,), u = 3 D + 1: x, y and R phi of each of the D discs, and R psi of the output, with the
radius R of the circle of output pins. The clearance of a cam is a circle, represented by a polygon around it, which is
larger by 1 - cos(pi/sides).
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.deprecated import deprecated_attribute
from cycloid_mj.base.errors import RunError
from cycloid_mj.geometry import profile
from cycloid_mj.reducer.gaps import Gaps, cam_displacements, gaps, unknowns

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
    min_gap
        Smallest gap of any pair in this pose [m]; negative if parts can be assembled by force only.
    shift
        Displacement of each disc's centre from its ideal position, in the frame of the ring [m], shape (D, 2).
    gear_turn
        Rotation of each disc from its ideal angle [rad], counter-clockwise, shape (D,).
    output_turn
        Rotation of the output from its ideal angle [rad], counter-clockwise.
    pin_shift
        Displacement of each moving pin or sleeve that avoids an overlap [m], shape (N, 2); zero for fixed pins.
    """

    min_gap: float
    shift: Array
    gear_turn: Array
    output_turn: float
    pin_shift: Array
    room = deprecated_attribute("Fit", "room", "min_gap")


def best_fit(reducer: "Reducer", crank_angle: float) -> Fit:
    """Return the pose of discs and output with the largest minimum gap of all pairs at a crank angle [rad]."""
    mesh_gaps, pose, min_gap, _ = _maximize_min_gap(reducer, crank_angle)
    return _make_fit(reducer, mesh_gaps, pose, min_gap)


def pressed_fit(reducer: "Reducer", crank_angle: float, pose: Array) -> Fit:
    """Convert a pose at a crank angle [rad] to a `Fit`, without the smallest gap (`min_gap` is NaN).

    `pose` [m] has x, y and rotation of each disc, and the rotation of the output, relative to the ring; rotations are
    multiplied by the radius of the circle of output pins.
    """
    return _make_fit(reducer, gaps(reducer, float(reducer.member.against_ring(crank_angle))), pose, math.nan)


def _make_fit(reducer: "Reducer", mesh_gaps: Gaps, pose: Array, min_gap: float) -> Fit:
    """Convert a pose of discs and output to displacements [m] and rotations [rad] of the parts (`Fit`).

    `pose` [m] has x, y and rotation of each disc, and the rotation of the output, relative to the ring; rotations are
    multiplied by the radius of the circle of output pins. Angles in `Fit` are not relative to the ring: if the ring is
    the output, a rotation of the ring by its `output_turn` also rotates each disc, by N/(N-1) as much with N ring
    teeth, which is added to `gear_turn`. `mesh_gaps` are the gaps at this crank angle, from which `pin_shift` is
    computed, and `min_gap` [m] is the smallest gap in this pose.
    """
    design = reducer.design
    radius, disc_poses = design.output.pin_circle_radius, pose[:-1].reshape(-1, 3)
    disc_rotations, carrier_angle = disc_poses[:, 2] / radius, float(pose[-1]) / radius
    output_angle = reducer.member.sense * reducer.share * carrier_angle
    ring_angle, _ = reducer.member.ring_and_carrier(output_angle)
    # a ring that turns at a locked crank takes the gear along by N/(N-1) of its turn
    disc_rotations = disc_rotations + ring_angle * design.ring.teeth / design.lobes
    return Fit(min_gap, disc_poses[:, :2], disc_rotations, output_angle, _pin_displacements(reducer, mesh_gaps, pose))


def find_tightest_pairs(reducer: "Reducer", crank_angle: float) -> tuple[float, dict[str, float]]:
    """Compute the minimum gap in the best pose at a crank angle [rad], and which mating pairs limit it.

    The best pose is that with the largest minimum gap. Clearances may be negative here, unlike in a design file.

    Returns
    -------
    tuple
        The minimum gap [m]; and kind of pair, including ``cam`` -> its share of the limit, from 0 to 1; the sum is 1.
        The shares are dual values of the linear program: contact forces that press the parts into this pose.
    """
    mesh_gaps, _, min_gap, forces = _maximize_min_gap(reducer, crank_angle)
    kinds = np.concatenate([mesh_gaps.kind, np.full(len(forces) - len(mesh_gaps.kind), "cam")])
    return min_gap, {str(kind): float(forces[kinds == kind].sum()) for kind in np.unique(kinds)}


def _maximize_min_gap(reducer: "Reducer", crank_angle: float) -> tuple[Gaps, Array, float, Array]:
    """Find the pose with the largest minimum gap at a crank angle [rad] by linear programming.

    Returns
    -------
    tuple
        Gaps (n,) of teeth and output pins; the pose [m]: x, y and rotation of each disc, and rotation of the output,
        times the radius of the circle of output pins; its minimum gap [m]; and the dual values [1] of the constraints:
        one for each of the n gaps, then one for each side of each cam's polygon.
    """
    from scipy.optimize import linprog

    crank_angle = float(reducer.member.against_ring(crank_angle))
    mesh_gaps, cam_offsets = gaps(reducer, crank_angle), cam_displacements(reducer, crank_angle)
    slope, widths = _linear_limits(reducer, mesh_gaps, cam_offsets, FIT.fit_sides)
    count = unknowns(reducer)
    matrix = np.concatenate([-slope, np.ones((len(widths), 1))], axis=1)
    solution = linprog(
        [0.0] * count + [-1.0], A_ub=matrix, b_ub=widths / FIT.scale, bounds=[(None, None)] * (count + 1)
    )
    *pose, min_gap = np.asarray(solution.x, dtype=np.float64)
    return mesh_gaps, FIT.scale * np.array(pose), FIT.scale * float(min_gap), -np.asarray(solution.ineqlin.marginals)


def stops(reducer: "Reducer", crank: float, sides: int = FIT.cam_sides) -> tuple[float, float]:
    """Compute the rotations [rad] from the ideal angle at which the output stops, clockwise and counter-clockwise.

    The crank is locked at an angle [rad]. `sides` and errors are those of `stops_at`.
    """
    clockwise_stop, counter_clockwise_stop = stops_at(reducer, np.array([crank]), sides)[0].tolist()
    return clockwise_stop, counter_clockwise_stop


def stops_at(reducer: "Reducer", cranks: Array, sides: int = FIT.cam_sides) -> Array:
    """Compute how far the output can turn from its ideal angle in both directions, at n crank angles [rad].

    Parts are rigid, with all clearances, errors and modifications. `cranks` (n,) are the crank angles, `sides` is the
    number of sides of the polygon that represents a cam's clearance.

    Returns
    -------
    Array
        Rotations [rad], shape (n, 2), counter-clockwise positive: the stop in clockwise direction, then the other.

    Raises
    ------
    RunError
        The errors leave no room for the disc, or the halves of a preloaded ring clamp it.
    """
    batches = [cranks[batch_start : batch_start + FIT.batch] for batch_start in range(0, len(cranks), FIT.batch)]
    return np.concatenate([_solve_stops(reducer, batch, sides) for batch in batches])


def _solve_stops(reducer: "Reducer", cranks: Array, side_count: int) -> Array:
    """Compute how far the output can turn in both directions (n, 2) [rad] at n crank angles [rad] by a linear program.

    The first column is the stop in clockwise direction. The angles `cranks` are independent of each other. If the
    program has no solution, each angle is solved alone, so that the error message can name the angle at which the disc
    jams. `side_count` is the number of sides of a cam's polygon.

    Raises
    ------
    RunError
        The errors leave no room for the disc, or the halves of a preloaded ring clamp it.
    """
    from scipy.optimize import linprog
    from scipy.sparse import block_diag, csc_array

    design, unknown_count = reducer.design, unknowns(reducer)
    angles = reducer.member.against_ring(cranks).tolist()
    limits_by_angle = [
        _linear_limits(reducer, gaps(reducer, angle), cam_displacements(reducer, angle), side_count) for angle in angles
    ]
    slope: Any = block_diag([csc_array(-slope) for slope, _ in limits_by_angle for _ in range(2)], format="csc")
    widths = np.concatenate([widths for _, widths in limits_by_angle for _ in range(2)])
    objective = np.zeros((len(cranks), 2, unknown_count))
    objective[:, :, -1] = 1.0, -1.0
    # presolving takes longer than solving with the redundant limits
    solution = linprog(objective.ravel(), slope, widths / FIT.scale, bounds=(None, None), options={"presolve": False})
    if solution.x is None:
        if len(cranks) > 1:
            return np.concatenate(
                [_solve_stops(reducer, crank_angle, side_count) for crank_angle in cranks[:, np.newaxis]]
            )
        location = f"at a crank angle of {math.degrees(cranks[0]):.4g} deg"
        if design.ring.preload:
            raise RunError(
                f"the two halves of the ring clamp the disc of {design.name} {location}, so rigid parts cannot rotate "
                "there: reduce ring.preload_arcmin, or use `cycloid-mj statics`, which includes deflection"
            )
        cause, remedy = "the manufacturing errors exceed", "increase clearance.* or reduce errors.*"
        if temperature := design.thermal.words:
            cause = f"thermal expansion ({temperature}) and manufacturing errors exceed"
            remedy += ", or keep the parts closer to 20 °C"
        raise RunError(f"the disc of {design.name} jams {location}, because {cause} the clearances: {remedy}")
    rotations = np.asarray(solution.x).reshape(objective.shape)[:, :, -1] * FIT.scale / design.output.pin_circle_radius
    return np.sort(reducer.member.sense * reducer.share * rotations, axis=1)


def widest_play(reducer: "Reducer", crank: float, sides: int = FIT.cam_sides) -> float:
    """Compute the backlash of the output with rigid parts [rad] at a crank angle [rad]; errors as `stops`.

    The preload angle between the halves of a ring is ignored, which makes the backlash the largest.
    """
    clockwise_stop, counter_clockwise_stop = stops(reducer.but(ring={"preload": 0.0}), crank, sides)
    return counter_clockwise_stop - clockwise_stop


def _linear_limits(reducer: "Reducer", mesh_gaps: Gaps, cam_offsets: Array, side_count: int) -> tuple[Array, Array]:
    """Return the limits on the pose z [m] of discs and output as inequalities ``slope @ z + gap >= 0``.

    The pose is x, y and rotation of each disc, and the rotation of the output, times the radius of the circle of output
    pins. There is an inequality for each contact, then one for each side of each cam's polygon, which has `side_count`
    sides. `mesh_gaps` are the gaps of teeth and output pins, and `cam_offsets` (D, 2) [m] are the displacements of the
    cams by errors of the crank.

    Returns
    -------
    tuple of Array
        ``slope`` [1] of m inequalities by u unknowns, shape (m, u), and ``gap`` [m], shape (m,).
    """
    slopes, widths = [mesh_gaps.slope], [mesh_gaps.width + mesh_gaps.play]
    directions = profile.unit(np.linspace(0.0, 2.0 * np.pi, side_count, endpoint=False))
    for disc, cam_offset in enumerate(cam_offsets):
        slope = np.zeros((side_count, unknowns(reducer)))
        slope[:, 3 * disc : 3 * disc + 2] = -directions
        slopes.append(slope)
        widths.append(reducer.design.clearance.cam + directions @ cam_offset)
    return np.concatenate(slopes), np.concatenate(widths)


def _pin_displacements(reducer: "Reducer", mesh_gaps: Gaps, pose: Array) -> Array:
    """Return the displacement of each ring pin that avoids an overlap with the discs in a pose, shape (n, 2) [m].

    The n pins (or lobes) are those of the ring, or of both of its halves. A moving pin that overlaps a disc is
    displaced along the normal of the deepest overlap, to the middle between touching the disc and touching its seat.
    The displacement of all other pins is 0.

    Parameters
    ----------
    mesh_gaps
        Gaps at this crank angle.
    pose
        x, y and rotation of each disc, and rotation of the output [m]; rotations are multiplied by the radius of the
        circle of output pins.
    """
    design = reducer.design
    if not design.ring.has_moving_pins:
        return np.zeros((design.ring.mate_count, 2))
    tooth_gaps = mesh_gaps.select(mesh_gaps.kind == design.tooth_pair)
    gap_width = tooth_gaps.width + tooth_gaps.slope @ pose
    normals = -tooth_gaps.slope[:, :-1].reshape(len(gap_width), -1, 3)[np.arange(len(gap_width)), tooth_gaps.disc, :2]
    smallest_index = np.lexsort((gap_width, tooth_gaps.owner))[:: design.gear.discs]
    shifts = ((tooth_gaps.play - gap_width) / 2.0)[:, np.newaxis] * normals
    return np.asarray(np.where(gap_width[:, np.newaxis] < 0.0, shifts, 0.0)[smallest_index])
