"""Recordings for the Rerun viewer: parts and forces, which its MCAP loader ignores, and all columns."""

import importlib
import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.atomic_write import atomic_file
from cycloid_mj.base.extras import import_extra
from cycloid_mj.base.names import column, family, gears, planar_speeds
from cycloid_mj.base.record import Run
from cycloid_mj.parts.parts import Colour
from cycloid_mj.reducer import Reducer
from cycloid_mj.scene.force import ARROWS, FORCE_COLOURS, ContactForces, arrow_heights, shown_forces
from cycloid_mj.scene.pose import poses
from cycloid_mj.scene.shading import shade
from cycloid_mj.scene.shape import Piece, shapes

TIMELINE = "time"
MECHANISM, SIGNALS = "mechanism", "signals"


def write_rerun(run: Run, reducer: Reducer, path: str | os.PathLike[str]) -> None:
    """Write a run as a Rerun recording (.rrd): moving parts, forces on the disc, all columns, and a layout.

    Parameters
    ----------
    path
        File to write; replaced if it exists.
    """
    rerun = import_extra("rerun", "a recording", "rerun")
    poses_by_part, forces = poses(reducer, run.columns), shown_forces(reducer, run.columns)
    application = "cycloid_mj_" + "_".join(reducer.design.name.split())
    with atomic_file(path) as temporary_path:
        recording = rerun.RecordingStream(application)
        recording.save(str(temporary_path), default_blueprint=_viewer_layout(reducer, run.topics))
        time = rerun.TimeColumn(TIMELINE, duration=run.time)
        _log_parts(rerun, recording, reducer, time, poses_by_part)
        _log_forces(rerun, recording, reducer, time, forces)
        for topic, names in run.topics.items():
            for name in names:
                scalars = rerun.Scalars.columns(scalars=run[name])
                recording.send_columns(f"{SIGNALS}{topic}/{name}", indexes=[time], columns=scalars)
        recording.flush()
        recording.disconnect()


def _log_parts(rerun: Any, recording: Any, reducer: Reducer, time: Any, poses_by_part: Mapping[str, Array]) -> None:
    """Log the meshes of the parts, and their poses at all samples; parts that do not move are logged once.

    Parameters
    ----------
    rerun, recording
        The module ``rerun``, and the recording.
    time
        Rerun's time column of n samples.
    poses_by_part
        x [m], y [m] and angle [rad] of each part by name, shape (n, 3).
    """
    pieces_by_part = shapes(reducer)
    for part, pose in poses_by_part.items():
        entity = f"{MECHANISM}/{part}"
        for piece in pieces_by_part[part if part in pieces_by_part else family(part)]:
            recording.log(f"{entity}/{piece.name}", _rerun_mesh(rerun, piece), static=True)
        translation = np.column_stack([pose[:, :2], np.zeros(len(pose))])
        quaternion = np.zeros((len(pose), 4))
        quaternion[:, 2], quaternion[:, 3] = np.sin(0.5 * pose[:, 2]), np.cos(0.5 * pose[:, 2])
        if np.ptp(pose, axis=0).any():
            transforms = rerun.Transform3D.columns(translation=translation, quaternion=quaternion)
            recording.send_columns(entity, indexes=[time], columns=transforms)
        else:
            recording.log(entity, rerun.Transform3D(translation=translation[0], quaternion=quaternion[0]), static=True)


def _rerun_mesh(rerun: Any, piece: Piece) -> Any:
    """Return a piece as a mesh of Rerun."""
    mesh, colour = shade(piece.mesh), _colour_bytes(piece.colour)
    return rerun.Mesh3D(
        vertex_positions=mesh.vertices, vertex_normals=mesh.normals, triangle_indices=mesh.faces, albedo_factor=colour
    )


def _colour_bytes(colour: Colour) -> list[int]:
    return [round(255 * part) for part in colour]


def _log_forces(rerun: Any, recording: Any, reducer: Reducer, time: Any, forces: ContactForces) -> None:
    """Log the force arrows of each kind of mating pair over time, with their tips at the contacts, on a disc face.

    `rerun` is the module ``rerun``, `recording` the recording, `time` its time column of n samples, and `forces` are
    the contact forces at these samples. The largest force of a kind over all times has an arrow of `ARROWS.length`
    times the pin-circle radius.
    """
    ring_radius, arrow_z = reducer.design.ring.pin_circle_radius, np.array(arrow_heights(reducer))
    for kind in dict.fromkeys(forces.kinds):
        forces_of_kind = forces.of(kind)
        scale = ARROWS.length * ring_radius / forces_of_kind.size.max(initial=1e-9)
        vectors = np.concatenate([scale * forces_of_kind.force, np.zeros((*forces_of_kind.size.shape, 1))], axis=2)
        arrow_z_by_force = np.broadcast_to(
            arrow_z[list(forces_of_kind.discs)][:, np.newaxis], (*forces_of_kind.size.shape, 1)
        )
        origins = np.concatenate([forces_of_kind.point, arrow_z_by_force], axis=2) - vectors
        sample_count, pair_count = forces_of_kind.size.shape
        arrows = rerun.Arrows3D.columns(vectors=vectors.reshape(-1, 3), origins=origins.reshape(-1, 3))
        entity = f"{MECHANISM}/forces/{kind}"
        style = rerun.Arrows3D.from_fields(
            colors=[_colour_bytes(FORCE_COLOURS[kind])], radii=0.4 * ARROWS.thickness * ring_radius
        )
        recording.log(entity, style, static=True)
        recording.send_columns(entity, indexes=[time], columns=arrows.partition([pair_count] * sample_count))


def _viewer_layout(reducer: Reducer, topics: Mapping[str, tuple[str, ...]]) -> Any:
    """Return the initial layout of the viewer, a blueprint: the mechanism, and plots of speeds, torques and peak force.

    `topics` has the column names that belong to each topic.
    """
    rrb = importlib.import_module("rerun.blueprint")
    entities = {name: f"/{SIGNALS}{topic}/{name}" for topic, names in topics.items() for name in names}
    speed_columns = tuple(planar_speeds(gear)[2] for gear in gears(reducer.design.gear.discs))
    torque_columns = (column(reducer.INPUT, "torque"), "load_torque")
    plots = [
        rrb.TimeSeriesView(name=", ".join(names), contents=[entities[name] for name in names])
        for names in (speed_columns, ("output_speed",), torque_columns, ("peak_force",))
        if all(name in entities for name in names)
    ]
    housing_radius = reducer.design.housing.outer_radius
    eye_controls = rrb.EyeControls3D(
        position=[0.8 * housing_radius, 0.6 * housing_radius, 3.2 * housing_radius],
        look_target=[0, 0, 0],
        eye_up=[0, 1, 0],
    )
    mechanism_view = rrb.Spatial3DView(
        origin=f"/{MECHANISM}", name="mechanism", eye_controls=eye_controls, line_grid=False
    )
    return rrb.Blueprint(rrb.Horizontal(mechanism_view, rrb.Vertical(*plots)))
