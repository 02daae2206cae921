"""The moving mechanism as Foxglove messages: frames, parts and contact forces.

Topics: ``/tf`` (``foxglove.FrameTransforms``, one transform for each part, parent `ROOT`), ``/scene/parts``
(``foxglove.SceneUpdate``, once: an entity with an embedded GLB for each part, in that part's frame) and
``/scene/forces`` (``foxglove.SceneUpdate``: an entity of arrows for each kind of mating pair). The parts have a topic
of their own because a viewer that jumps in time shows the last message of each topic.

A force on the gear is an arrow whose tip is where the contact is. Ring contacts, the cam and the output pins have
scales of their own, [N/m] in the entities' metadata.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.descriptor_pb2 import FileDescriptorSet

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.names import CRANK, pin
from cycloid_mj.design import Design
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.reducer.rv_bodies import crank_names
from cycloid_mj.scene.force import ARROWS, FORCE_COLOURS, ContactForces, arrow_heights, reference_force, shown_forces
from cycloid_mj.scene.glb import MEDIA_TYPE, encode_glb
from cycloid_mj.scene.pose import poses, ring_places
from cycloid_mj.scene.shape import shapes

Message = tuple[str, int, bytes]
"""Topic, time [ns] and serialized content of a message."""

RATE = 60.0
"""Frames per second of simulated time."""


@dataclass(frozen=True)
class FrameSettings:
    """Settings of the frame rate of a run."""

    frames_per_turn: int = 36
    """Frames per turn of the crank, for a replay to show which way it turns."""
    max_frames: int = 900
    """Largest number of these frames, as many as a viewer shows in 15 s; a run of many turns has fewer in each."""
    max_rate: float = 1e5
    """Highest frame rate [1/s]."""


FRAME = FrameSettings()

ROOT = "reducer"
FRAMES, PARTS, FORCES = "/tf", "/scene/parts", "/scene/forces"


def frame_rate(reducer: Reducer) -> float:
    """Compute the number of frames per second of simulated time in a run's log [1/s].

    There is a frame for every 10 deg of crank rotation, but at most `FrameSettings.max_frames` in a long run, to limit
    the size of its log. The rate is at least ``settings.scene_rate``, and at most `FrameSettings.max_rate`.
    """
    design = reducer.design
    rate_by_angle = FRAME.frames_per_turn * abs(reducer.orbit_speed) / (2.0 * math.pi)
    rate_by_count = FRAME.max_frames / (design.drive.ramp + design.drive.hold)
    return min(max(design.settings.scene_rate, min(rate_by_angle, rate_by_count)), FRAME.max_rate)


@dataclass(frozen=True)
class Scene:
    """Messages for viewers: a pure function of the design and of samples.

    Attributes
    ----------
    design
        The design.
    rate
        Frames per second of simulated time [1/s].

    Raises
    ------
    UsageError
        `rate` is not positive or too large.
    """

    design: Design
    rate: float = RATE

    def __post_init__(self) -> None:
        if not 0.0 < self.rate <= FRAME.max_rate:
            raise UsageError(
                f"the frame rate of the 3-D scene is {self.rate:g} per second, which is out of range: choose a rate "
                f"greater than 0 and at most {FRAME.max_rate:g} per second"
            )

    @cached_property
    def reducer(self) -> Reducer:
        """The reducer of the design."""
        return reducer_of(self.design)

    @property
    def schemas(self) -> dict[str, tuple[str, bytes]]:
        """Name and serialized FileDescriptorSet of the message of each topic."""
        kinds: dict[str, Any] = {FRAMES: FrameTransforms, PARTS: SceneUpdate, FORCES: SceneUpdate}
        return {topic: (kind.DESCRIPTOR.full_name, _message_descriptors(kind)) for topic, kind in kinds.items()}

    def opening(self, time: float) -> Iterator[Message]:
        """Yield a single message with the meshes of all parts (topic `PARTS`), to be written before the first frame.

        `time` [s] is its time stamp.
        """
        message = SceneUpdate()
        glb_by_part = {name: encode_glb(pieces) for name, pieces in shapes(self.reducer).items()}
        pin_glb = glb_by_part.pop("pin", b"")
        if isinstance(self.reducer, RvReducer):
            crank_glb = glb_by_part.pop(CRANK)
            glb_by_part |= dict.fromkeys(crank_names(self.reducer), crank_glb)
        if pin_glb:
            glb_by_part |= {pin(number): pin_glb for number, _ in enumerate(ring_places(self.reducer), start=1)}
        for part, glb_content in glb_by_part.items():
            entity = message.entities.add(frame_id=part, id=part, frame_locked=True)
            entity.timestamp.FromNanoseconds(_nanoseconds(time))
            model = entity.models.add(data=glb_content, media_type=MEDIA_TYPE)
            model.pose.orientation.w = 1.0
            model.scale.x = model.scale.y = model.scale.z = 1.0
        yield PARTS, _nanoseconds(time), message.SerializeToString(deterministic=True)

    def frames(self, time: Array, columns: Mapping[str, Array]) -> Iterator[Message]:
        """Yield the messages of frames at k times: transforms of the parts, and arrows of the contact forces.

        Times at which a pose is not finite are skipped.

        Parameters
        ----------
        time
            The k times [s], shape (k,).
        columns
            Log columns by name, shape (k,), in SI units.
        """
        poses_by_part = poses(self.reducer, columns)
        stacked_poses = np.stack(list(poses_by_part.values()), axis=1)
        rows = np.flatnonzero(np.isfinite(stacked_poses.sum(axis=(1, 2)))).tolist()
        nanoseconds = np.rint(1e9 * time).astype(np.int64).tolist()
        forces = shown_forces(self.reducer, columns)
        arrows = self._compute_arrows(forces)
        rows_by_kind = {
            kind: [row for row, pair_kind in enumerate(forces.kinds) if pair_kind == kind]
            for kind in dict.fromkeys(forces.kinds)
        }
        for row in rows:
            yield (
                FRAMES,
                nanoseconds[row],
                self._encode_transforms(list(poses_by_part), stacked_poses[row], nanoseconds[row]),
            )
            yield FORCES, nanoseconds[row], self._encode_forces(rows_by_kind, arrows[row], nanoseconds[row])

    def _encode_transforms(self, parts: list[str], poses: Array, nanoseconds: int) -> bytes:
        """Encode the transforms of parts at a time stamp [ns]: translation, and rotation about z as a quaternion.

        `poses` (parts, 3) has x [m], y [m] and angle [rad] of each of `parts`. `nanoseconds` is the time stamp.
        """
        message, half_angle = FrameTransforms(), 0.5 * poses[:, 2]
        rows = np.column_stack([poses[:, :2], np.sin(half_angle), np.cos(half_angle)]).tolist()
        for part, (x, y, sine, cosine) in zip(parts, rows, strict=True):
            transform = message.transforms.add(parent_frame_id=ROOT, child_frame_id=part)
            transform.timestamp.FromNanoseconds(nanoseconds)
            transform.translation.x, transform.translation.y = x, y
            transform.rotation.z, transform.rotation.w = sine, cosine
        return bytes(message.SerializeToString(deterministic=True))

    def _encode_forces(self, rows_by_kind: Mapping[str, Sequence[int]], arrows: Array, nanoseconds: int) -> bytes:
        """Encode the arrows of all forces at a time stamp [ns] for a viewer: one entity for each kind of mating pair.

        `nanoseconds` is the time stamp. `arrows` (k, 7) are those of k forces from `_compute_arrows` at this time, and
        `rows_by_kind` has the row indices of each kind of pair. Forces of zero have no arrow.
        """
        message, thickness = SceneUpdate(), ARROWS.thickness * self.design.ring.pin_circle_radius
        for kind, rows in rows_by_kind.items():
            entity = message.entities.add(frame_id=ROOT, id=kind)
            entity.timestamp.FromNanoseconds(nanoseconds)
            entity.metadata.add(key="scale [N/m]", value=f"{1.0 / self._scales[kind]:.6g}")
            for x, y, z, sine, cosine, shaft_length, head_length in arrows[rows].tolist():
                if not shaft_length + head_length > 0.0:
                    continue
                arrow = entity.arrows.add(shaft_length=shaft_length, head_length=head_length)
                position, rotation = arrow.pose.position, arrow.pose.orientation
                position.x, position.y, position.z, rotation.z, rotation.w = x, y, z, sine, cosine
                arrow.shaft_diameter, arrow.head_diameter = thickness, 2.0 * thickness
                arrow.color.r, arrow.color.g, arrow.color.b, arrow.color.a = FORCE_COLOURS[kind]
        return bytes(message.SerializeToString(deterministic=True))

    def _compute_arrows(self, forces: ContactForces) -> Array:
        """Compute the arrows of k forces at n times, shape (n, k, 7); their tips are at the contacts.

        The last axis has position x, y, z of the tail [m], sine and cosine of half the angle from +x, and the lengths
        of shaft and head [m].
        """
        scale = np.array([self._scales[kind] for kind in forces.kinds])
        tail = forces.point - forces.force * scale[:, np.newaxis]
        half_angle = 0.5 * np.arctan2(forces.force[..., 1], forces.force[..., 0])
        height = np.broadcast_to([arrow_heights(self.reducer)[disc] for disc in forces.discs], half_angle.shape)
        length = forces.size * scale
        head_length = np.minimum(3.0 * ARROWS.thickness * self.design.ring.pin_circle_radius, 0.5 * length)
        arrow_values = (
            tail[..., 0],
            tail[..., 1],
            height,
            np.sin(half_angle),
            np.cos(half_angle),
            length - head_length,
            head_length,
        )
        return np.stack(arrow_values, axis=-1)

    @cached_property
    def _scales(self) -> dict[str, float]:
        """Length of an arrow per newton [m/N], by kind of mating pair."""
        max_length = ARROWS.length * self.design.ring.pin_circle_radius
        return {kind: max_length / force for kind, force in reference_force(self.reducer).items()}


def _nanoseconds(time: float) -> int:
    return round(1e9 * time)


def _message_descriptors(message: Any) -> bytes:
    """Return the serialized FileDescriptorSet of a Protobuf message type: its definition, with dependencies first."""
    files: dict[str, Any] = {}

    def add(file: Any) -> None:
        for dependency in file.dependencies:
            add(dependency)
        if file.name not in files:
            files[file.name] = file

    add(message.DESCRIPTOR.file)
    descriptors = FileDescriptorSet()
    for file in files.values():
        file.CopyToProto(descriptors.file.add())
    return bytes(descriptors.SerializeToString(deterministic=True))
