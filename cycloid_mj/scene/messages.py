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
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.descriptor_pb2 import FileDescriptorSet

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.names import pin
from cycloid_mj.base.protobuf import varint
from cycloid_mj.design import Design
from cycloid_mj.reducer import Reducer
from cycloid_mj.scene.encoding import Build, encode_messages
from cycloid_mj.scene.force import (
    ARROW,
    FORCE_COLOURS,
    THICKNESS,
    ContactForces,
    arrow_heights,
    on_gear,
    reference_force,
)
from cycloid_mj.scene.glb import MEDIA_TYPE, glb
from cycloid_mj.scene.pose import poses, ring_places
from cycloid_mj.scene.shape import shapes

Message = tuple[str, int, bytes]
"""Topic, time [ns] and serialized content of a message."""

RATE = 60.0
"""Frames per second of simulated time."""

FRAMES_PER_TURN = 36
"""Frames of a run per turn of the crank, for a replay to show which way it turns."""

MAX_FRAMES = 900
"""Largest number of these frames, as many as a viewer shows in 15 s; a run of many turns has fewer in each."""

MAX_RATE = 1e5
"""Highest frame rate [1/s]."""
ROOT = "reducer"
ENTITIES_TAG = b"\x12"
"""Key of field 2 of ``foxglove.SceneUpdate``, its entities, before the length of each."""

FRAMES, PARTS, FORCES = "/tf", "/scene/parts", "/scene/forces"


def frame_rate(reducer: Reducer) -> float:
    """Compute the frame rate of a run [1/s]: a frame every 10 deg of crank, or ``settings.scene_rate`` if that is more.

    A run of many turns has `MAX_FRAMES` of them, which bounds the size of its log.
    """
    design = reducer.design
    by_angle = FRAMES_PER_TURN * abs(design.drive.speed) / (2.0 * math.pi)
    at_most = MAX_FRAMES / (design.drive.ramp + design.drive.hold)
    return min(max(design.settings.scene_rate, min(by_angle, at_most)), MAX_RATE)


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
        if not 0.0 < self.rate <= MAX_RATE:
            raise UsageError(
                f"a frame rate of {self.rate:g} per second is out of range: it must be above 0 and at most {MAX_RATE:g}"
            )

    @cached_property
    def reducer(self) -> Reducer:
        """The reducer of the design."""
        return Reducer(self.design)

    @property
    def schemas(self) -> dict[str, tuple[str, bytes]]:
        """Name and serialized FileDescriptorSet of the message of each topic."""
        kinds: dict[str, Any] = {FRAMES: FrameTransforms, PARTS: SceneUpdate, FORCES: SceneUpdate}
        return {topic: (kind.DESCRIPTOR.full_name, _descriptors(kind)) for topic, kind in kinds.items()}

    def opening(self, time: float) -> Iterator[Message]:
        """Yield the message that precedes the first frame, at `time` [s]; for errors see `shapes`."""
        update = SceneUpdate()
        files = {name: glb(pieces) for name, pieces in shapes(self.reducer).items()}
        one_pin = files.pop("pin", b"")
        if one_pin:
            files |= {pin(number): one_pin for number, _ in enumerate(ring_places(self.reducer), start=1)}
        for part, data in files.items():
            entity = update.entities.add(frame_id=part, id=part, frame_locked=True)
            entity.timestamp.FromNanoseconds(_nanoseconds(time))
            model = entity.models.add(data=data, media_type=MEDIA_TYPE)
            model.pose.orientation.w = 1.0
            model.scale.x = model.scale.y = model.scale.z = 1.0
        yield PARTS, _nanoseconds(time), update.SerializeToString(deterministic=True)

    def frames(self, time: Array, columns: Mapping[str, Array]) -> Iterator[Message]:
        """Yield the frames at k times.

        Parameters
        ----------
        time
            Shape (k,), [s].
        columns
            Values by name, shape (k,), in SI units.
        """
        place = np.stack(list((by_part := poses(self.reducer, columns)).values()), axis=1)
        rows = np.flatnonzero(np.isfinite(place.sum(axis=(1, 2))))
        if not len(rows):
            return
        stamps = np.rint(1e9 * time).astype(np.int64)[rows]
        transforms = self._transforms(list(by_part), place[rows], stamps)
        forces = self._forces(on_gear(self.reducer, columns), rows, stamps)
        for stamp, frame, update in zip(stamps.tolist(), transforms, forces, strict=True):
            yield FRAMES, stamp, frame
            yield FORCES, stamp, update

    def _transforms(self, parts: list[str], place: Array, stamps: Integers) -> list[bytes]:
        """Return the transforms of parts in poses (k, parts, 3) [m, rad]."""
        turn = 0.5 * place[..., 2]
        values = np.stack([place[..., 0], place[..., 1], np.sin(turn), np.cos(turn)], axis=-1)

        def build(values: Sequence[float], stamp: int) -> bytes:
            message = FrameTransforms()
            for number, part in enumerate(parts):
                transform = message.transforms.add(parent_frame_id=ROOT, child_frame_id=part)
                transform.timestamp.FromNanoseconds(stamp)
                moved, turned = transform.translation, transform.rotation
                moved.x, moved.y, turned.z, turned.w = values[4 * number : 4 * number + 4]
            return bytes(message.SerializeToString(deterministic=True))

        return encode_messages(build, values.reshape(len(stamps), -1), stamps)

    def _forces(self, acting: ContactForces, rows: Integers, stamps: Integers) -> list[bytes]:
        """Return the updates of the arrows of some rows: an entity for each kind of pairs, an arrow for each force."""
        tails, angles, lengths = self._arrows(acting)
        updates = [b""] * len(rows)
        for kind in dict.fromkeys(acting.kinds):
            of_kind = np.array([row for row, this in enumerate(acting.kinds) if this == kind])
            of_rows = np.ix_(rows, of_kind)
            loaded = lengths[of_rows] > 0.0
            arrows = self._arrow_records(
                kind, tails[of_rows][loaded], angles[of_rows][loaded], lengths[of_rows][loaded]
            )
            ends = np.cumsum(loaded.sum(axis=1)).tolist()
            heads = encode_messages(self._entity(kind), np.zeros((len(rows), 0)), stamps)
            for number, (start, end, head) in enumerate(zip([0, *ends], ends, heads, strict=False)):
                entity = head + b"".join(arrows[start:end])
                updates[number] += ENTITIES_TAG + varint(len(entity)) + entity
        return updates

    def _arrows(self, acting: ContactForces) -> tuple[Array, Array, Array]:
        """Compute tails (n, k, 3) [m], angles (n, k) [rad] and lengths (n, k) [m] of the arrows of all pairs."""
        scale = np.array([self._scales[kind] for kind in acting.kinds])
        tail = acting.point - acting.force * scale[:, np.newaxis]
        angle = np.arctan2(acting.force[..., 1], acting.force[..., 0])
        height = np.broadcast_to([self._heights[disc] for disc in acting.discs], angle.shape)
        return np.concatenate([tail, height[..., np.newaxis]], axis=-1), angle, acting.size * scale

    def _entity(self, kind: str) -> Build:
        """Return what encodes the entity of a kind of pairs, without its arrows."""

        def build(_: Sequence[float], stamp: int) -> bytes:
            entity = SceneEntity(frame_id=ROOT, id=kind)
            entity.timestamp.FromNanoseconds(stamp)
            entity.metadata.add(key="scale [N/m]", value=f"{1.0 / self._scales[kind]:.6g}")
            return bytes(entity.SerializeToString(deterministic=True))

        return build

    def _arrow_records(self, kind: str, tails: Array, angles: Array, lengths: Array) -> list[bytes]:
        """Return n arrows of a kind as fields of their entity, from tails (n, 3) [m], angles [rad] and lengths [m]."""
        thickness = THICKNESS * self.design.ring.pin_circle_radius
        heads = np.minimum(3.0 * thickness, 0.5 * lengths)
        columns = [np.sin(0.5 * angles), np.cos(0.5 * angles), lengths - heads, heads]

        def build(values: Sequence[float], _: int) -> bytes:
            entity = SceneEntity()
            arrow = entity.arrows.add()
            position, turned = arrow.pose.position, arrow.pose.orientation
            position.x, position.y, position.z, turned.z, turned.w = values[:5]
            arrow.shaft_length, arrow.head_length = values[5:]
            arrow.shaft_diameter, arrow.head_diameter = thickness, 2.0 * thickness
            arrow.color.r, arrow.color.g, arrow.color.b, arrow.color.a = FORCE_COLOURS[kind]
            return bytes(entity.SerializeToString(deterministic=True))

        return encode_messages(build, np.column_stack([tails, *columns]), np.zeros(len(tails), np.int64))

    @cached_property
    def _heights(self) -> tuple[float, ...]:
        return arrow_heights(self.reducer)

    @cached_property
    def _scales(self) -> dict[str, float]:
        """Length of an arrow per newton [m/N], by kind of mating pair."""
        longest = ARROW * self.design.ring.pin_circle_radius
        return {kind: longest / force for kind, force in reference_force(self.reducer).items()}


def _nanoseconds(time: float) -> int:
    return round(1e9 * time)


def _descriptors(message: Any) -> bytes:
    """Return the FileDescriptorSet of a message, in topological order of the files."""
    files: dict[str, Any] = {}

    def add(file: Any) -> None:
        for needed in file.dependencies:
            add(needed)
        if file.name not in files:
            files[file.name] = file

    add(message.DESCRIPTOR.file)
    descriptors = FileDescriptorSet()
    for file in files.values():
        file.CopyToProto(descriptors.file.add())
    return bytes(descriptors.SerializeToString(deterministic=True))
