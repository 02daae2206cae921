"""Poses of the parts in the plane, from the columns of a run, in the frame of the reducer axis."""

from collections.abc import Mapping

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array, rotate
from cycloid_mj.base.errors import LogError
from cycloid_mj.base.record import usable
from cycloid_mj.geometry.profile import unit
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.reducer.rv_bodies import crank_joint, crank_names


def pose_columns(reducer: Reducer) -> tuple[str, ...]:
    """Return the names of the log columns that `poses` requires: angles of input and output, and poses of the discs."""
    planar = (name for gear in names.gears(reducer.design.gear.discs) for name in names.planar_joints(gear))
    cranks = map(crank_joint, crank_names(reducer)) if isinstance(reducer, RvReducer) else ()
    return (f"{reducer.INPUT}_angle", *planar, *cranks, "output_angle")


def ring_places(reducer: Reducer) -> Array:
    """Compute the nominal centres of the N ring pins or lobes [m], shape (N, 2): the first on +y, then clockwise.

    In a ring of two halves, those of the first half come first; each half is rotated by its preload angle (`ahead`).
    """
    ring = reducer.design.ring
    pin_angles = 2 * np.pi * np.arange(ring.teeth) / ring.teeth
    return ring.pin_circle_radius * unit(np.concatenate([pin_angles - lead_angle for lead_angle in ring.ahead]))


def poses(reducer: Reducer, columns: Mapping[str, Array]) -> dict[str, Array]:
    """Compute the planar poses of all parts at n times by name: x [m], y [m] and angle [rad], shape (n, 3).

    Parts are housing, shaft, gear (of several discs gear_1, gear_2, ...), output and, if the ring has pins, pin_1 ...
    pin_N. Instead of the shaft, an RV reducer has sun, and crank_1 ... crank_n with their planets. The position of
    gears, pins, sun and cranks is that of their centres; other parts have the position of the reducer axis. Angles are
    counter-clockwise.

    Parameters
    ----------
    columns
        Columns of a log by their names, shape (n,), in SI units. Those in `pose_columns` of the reducer are required.
        Pins without columns are fixed to the ring, or are massless pins: these are placed in contact with disc and
        socket.

    Raises
    ------
    LogError
        A column in `pose_columns` is missing.
    """
    design = reducer.design
    missing_columns = [name for name in pose_columns(reducer) if name not in columns]
    if missing_columns:
        raise LogError(
            f"the log lacks the columns {', '.join(missing_columns)}, which determine the positions of the parts: run "
            "`cycloid-mj simulate` again to write a complete log"
        )
    zeros = np.zeros_like(columns["output_angle"])
    ring_angle, carrier_angle = reducer.member.ring_and_carrier(columns["output_angle"])
    poses_by_part = {
        names.HOUSING: _pose(zeros, zeros, ring_angle),
        **(
            _crank_poses(reducer, columns, carrier_angle)
            if isinstance(reducer, RvReducer)
            else {names.SHAFT: _pose(zeros, zeros, columns["crank_angle"])}
        ),
        **{
            disc: _pose(*(columns[name] for name in names.planar_joints(disc)))
            for disc in names.gears(design.gear.discs)
        },
        names.OUTPUT: _pose(zeros, zeros, carrier_angle),
    }
    if design.ring.kind == "pin":
        pin_poses = _pin_poses(reducer, columns, ring_angle)
        poses_by_part |= {names.pin(number): pose for number, pose in enumerate(pin_poses, start=1)}
    return poses_by_part


def _crank_poses(reducer: RvReducer, columns: Mapping[str, Array], carrier_angle: Array) -> dict[str, Array]:
    """Compute the poses of sun and cranks by name, shape (n, 3) each: x [m], y [m] and angle [rad].

    `columns` are the log columns by name, shape (n,), `carrier_angle` (n,) [rad] is the angle of the carrier.
    """
    zeros = np.zeros_like(carrier_angle)
    x, y, angle = (columns.get(name, zeros) for name in names.planar_joints(names.SUN))
    poses_by_part = {names.SUN: _pose(x, y, angle)}
    for crank in crank_names(reducer):
        centre = rotate(np.broadcast_to(reducer.mechanism.body(crank).position, (carrier_angle.size, 2)), carrier_angle)
        crank_angle = usable(carrier_angle) + usable(columns[crank_joint(crank)])
        poses_by_part[crank] = _pose(centre[:, 0], centre[:, 1], crank_angle)
    return poses_by_part


def _pin_poses(reducer: Reducer, columns: Mapping[str, Array], ring_angle: Array) -> Array:
    """Compute the poses of all N ring pins at n samples, shape (N, n, 3): x [m], y [m] and angle [rad].

    `ring_angle` (n,) [rad] are the angles of the ring, and `columns` the log columns, which have the pins'
    displacements in the frame of the ring. Pins without columns do not move in this frame, except massless pins: they
    are displaced by their clearance in the direction in which the discs push them.
    """
    nominal_centres = ring_places(reducer)
    pin_numbers, zeros = range(1, len(nominal_centres) + 1), np.zeros_like(ring_angle)
    displacements = np.array(
        [
            [columns.get(names.column(names.pin(number), name), zeros) for name in ("x", "y", "angle")]
            for number in pin_numbers
        ]
    ).swapaxes(1, 2)
    if reducer.design.ring.has_massless_pins:
        forces_on_discs = np.array(
            [
                [_force_on_discs(reducer, columns, number, axis) for axis in (names.FORCE_X, names.FORCE_Y)]
                for number in pin_numbers
            ]
        )
        displacements[..., :2] = _pressed_displacements(reducer, rotate(forces_on_discs.swapaxes(1, 2), -ring_angle))
    centres = rotate(nominal_centres[:, np.newaxis] + displacements[..., :2], ring_angle)
    return usable(np.concatenate([centres, displacements[..., 2:] + ring_angle[:, np.newaxis]], axis=-1))


def _force_on_discs(reducer: Reducer, columns: Mapping[str, Array], number: int, axis: str) -> Array:
    """Return the force of a pin on all discs along an axis [N], shape (n,); 0 without columns."""
    discs = reducer.design.gear.discs
    pairs = [names.column(names.of_disc(names.pin(number), disc, discs), axis) for disc in range(discs)]
    return np.sum([columns.get(pair, np.zeros_like(columns["output_angle"])) for pair in pairs], axis=0)


def _pressed_displacements(reducer: Reducer, force: Array) -> Array:
    """Compute the displacements of massless pins [m]: by their clearance, against the `force` [N] on the discs."""
    magnitude = np.maximum(np.linalg.norm(force, axis=-1, keepdims=True), np.finfo(float).tiny)
    return -reducer.design.pin_play * force / magnitude


def transform(pose: Array, points: Array) -> Array:
    """Transform points (..., 2) [m] of a body with the poses (..., 3) to the frame of the reducer axis."""
    return pose[..., :2] + rotate(points, pose[..., 2])


def _pose(x: Array, y: Array, angle: Array) -> Array:
    return usable(np.stack([x, y, angle], axis=1))
