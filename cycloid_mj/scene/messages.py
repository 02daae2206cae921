"""The moving mechanism as Foxglove messages: frames, parts and contact forces.

Topics: ``/tf`` (``foxglove.FrameTransforms``, one transform for each part, parent `ROOT`), ``/scene/parts``
(``foxglove.SceneUpdate``, once: an entity with an embedded GLB for each part, in that part's frame) and
``/scene/forces`` (``foxglove.SceneUpdate``: an entity of arrows for each kind of mating pair). The parts have a topic
of their own because a viewer that jumps in time shows the last message of each topic.

A force on the gear is an arrow whose tip is where the contact is. Ring contacts, the cam and the output pins have
scales of their own, [N/m] in the entities' metadata.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.descriptor_pb2 import FileDescriptorSet

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.names import pin
from cycloid_mj.design import Design
from cycloid_mj.parts.parts import Colour
from cycloid_mj.reducer import Reducer
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
"""Topic, time [ns] and serialized content."""

RATE = 60.0
"""Frames per second of simulated time."""

FRAMES_A_TURN = 36
"""Frames of a run in a turn of the crank, for a replay to show which way it turns."""

MOST_FRAMES = 1500
"""Of those; a run of more turns has fewer in each."""

HIGHEST_RATE = 1e5
ROOT = "reducer"
FRAMES, PARTS, FORCES = "/tf", "/scene/parts", "/scene/forces"


def frame_rate(reducer: Reducer) -> float:
    """Compute the frames per second [1/s] of a run: every 10 deg of crank, or ``settings.scene_rate`` if that is more.

    A run of many turns has `MOST_FRAMES` of them, which bounds the size of its log.
    """
    design = reducer.design
    by_angle = FRAMES_A_TURN * abs(design.drive.speed) / (2.0 * math.pi)
    at_most = MOST_FRAMES / (design.drive.ramp + design.drive.hold)
    return min(max(design.settings.scene_rate, min(by_angle, at_most)), HIGHEST_RATE)


_Arrows = tuple[str, list[list[float]]]
"""A kind of pairs, and of each of its arrows x, y and z of the tail [m], angle [rad] and length [m]."""


@dataclass(frozen=True)
class Scene:
    """What a viewer gets of a run: a pure function of the design and of samples.

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
        if not 0.0 < self.rate <= HIGHEST_RATE:
            raise UsageError(
                f"a scene cannot have {self.rate:g} frames per second: give more than 0, at most {HIGHEST_RATE:g}"
            )

    @cached_property
    def reducer(self) -> Reducer:
        """What is shown."""
        return Reducer(self.design)

    @property
    def schemas(self) -> dict[str, tuple[str, bytes]]:
        """Map topic to name and serialized FileDescriptorSet of its message."""
        kinds: dict[str, Any] = {FRAMES: FrameTransforms, PARTS: SceneUpdate, FORCES: SceneUpdate}
        return {topic: (kind.DESCRIPTOR.full_name, _descriptors(kind)) for topic, kind in kinds.items()}

    def opening(self, time: float) -> Iterator[Message]:
        """Yield what comes once, before the first frame, at `time` [s]; errors as `shapes`."""
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
            Name -> values, shape (k,), in SI units.
        """
        place = poses(self.reducer, columns)
        parts, by_time = list(place), np.stack(list(place.values()), axis=1)
        sums: list[float] = by_time.sum(axis=(1, 2)).tolist()
        arrows = self._arrows(on_gear(self.reducer, columns))
        for now, whole, at, shown in zip(time.tolist(), sums, by_time.tolist(), arrows, strict=True):
            if math.isfinite(whole):
                stamp = _nanoseconds(now)
                yield FRAMES, stamp, _transforms(stamp, zip(parts, at, strict=True))
                yield FORCES, stamp, self._update(stamp, shown)

    def _arrows(self, acting: ContactForces) -> Iterator[list[_Arrows]]:
        """Yield the arrows of each time, those of a kind together."""
        scale = np.array([self._scales[kind] for kind in acting.kinds])
        tail = acting.point - acting.force * scale[:, np.newaxis]
        angle = np.arctan2(acting.force[..., 1], acting.force[..., 0])
        height = np.broadcast_to([self._heights[disc] for disc in acting.discs], angle.shape)
        arrows = np.stack([tail[..., 0], tail[..., 1], height, angle, acting.size * scale], axis=-1)
        rows = {kind: [row for row, this in enumerate(acting.kinds) if this == kind] for kind in acting.kinds}
        for now in arrows:
            yield [(kind, now[of_kind][now[of_kind, -1] > 0.0].tolist()) for kind, of_kind in rows.items()]

    def _update(self, stamp: int, shown: list[_Arrows]) -> bytes:
        update = SceneUpdate()
        for kind, arrows in shown:
            entity = update.entities.add(frame_id=ROOT, id=kind)
            entity.timestamp.FromNanoseconds(stamp)
            entity.metadata.add(key="scale [N/m]", value=f"{1.0 / self._scales[kind]:.6g}")
            for x, y, z, angle, length in arrows:
                self._add_arrow(entity.arrows.add(), (x, y, z), angle, length, FORCE_COLOURS[kind])
        return bytes(update.SerializeToString(deterministic=True))

    def _add_arrow(
        self, arrow: Any, tail: tuple[float, float, float], angle: float, length: float, colour: Colour
    ) -> None:
        """Fill in an arrow along `angle` [rad] from its `tail` [m]."""
        thickness = THICKNESS * self.design.ring.pin_circle_radius
        head = min(3.0 * thickness, 0.5 * length)
        arrow.shaft_length, arrow.head_length = length - head, head
        arrow.shaft_diameter, arrow.head_diameter = thickness, 2.0 * thickness
        arrow.color.r, arrow.color.g, arrow.color.b, arrow.color.a = colour
        _place(arrow.pose.position, arrow.pose.orientation, tail, angle)

    @cached_property
    def _heights(self) -> tuple[float, ...]:
        return arrow_heights(self.reducer)

    @cached_property
    def _scales(self) -> dict[str, float]:
        """Length of an arrow for each newton of force [m/N], by kind of pair."""
        longest = ARROW * self.design.ring.pin_circle_radius
        return {kind: longest / force for kind, force in reference_force(self.reducer).items()}


def _transforms(stamp: int, place: Iterable[tuple[str, list[float]]]) -> bytes:
    message = FrameTransforms()
    for part, (x, y, angle) in place:
        transform = message.transforms.add(parent_frame_id=ROOT, child_frame_id=part)
        transform.timestamp.FromNanoseconds(stamp)
        _place(transform.translation, transform.rotation, (x, y, 0.0), angle)
    return bytes(message.SerializeToString(deterministic=True))


def _place(position: Any, orientation: Any, at: tuple[float, float, float], angle: float) -> None:
    """Fill in a place and a rotation about z [rad]."""
    position.x, position.y, position.z = at
    orientation.z, orientation.w = math.sin(0.5 * angle), math.cos(0.5 * angle)


def _nanoseconds(time: float) -> int:
    return round(1e9 * time)


def _descriptors(message: Any) -> bytes:
    """Encode the FileDescriptorSet of a message, each file after those that it needs."""
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
