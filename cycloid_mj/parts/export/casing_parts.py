"""Solids and places of the casing: the bodies of covers, hub and flange, with the holes and bought parts of joints."""

from collections.abc import Iterator
from dataclasses import dataclass

from cycloid_mj.base import names
from cycloid_mj.parts import Part, lay_out_parts
from cycloid_mj.parts.export.casing import (
    FLANGE,
    MOTOR_COVER,
    OUTPUT_COVER,
    Casing,
    motor_bore,
    output_cover_step,
    shoulder_radius,
)
from cycloid_mj.parts.export.joints import Point, bought_parts, drive_joints
from cycloid_mj.parts.export.round_part import AXIS, Round, RoundPart, with_holes
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP


@dataclass(frozen=True)
class CasingPlace:
    """Position of a part of the casing: its name there, the part, its origin [m], and the body that it moves with."""

    name: str
    part: str
    origin: Point
    body: str


def casing_parts(reducer: Reducer, sizes: Casing) -> dict[str, RoundPart]:
    """Return all parts of the casing by name; for parts of the mechanism, what the casing adds to them."""
    joints = drive_joints(reducer, sizes)
    bodies = {
        names.HOUSING: (names.HOUSING, ()),
        names.OUTPUT: (names.OUTPUT, _hub(reducer, sizes)),
        MOTOR_COVER: (names.HOUSING, _motor_cover(reducer, sizes)),
        OUTPUT_COVER: (names.HOUSING, _output_cover(reducer, sizes)),
        FLANGE: (names.OUTPUT, ((sizes.flange_radius, sizes.top, sizes.top + sizes.flange_thickness),)),
        names.SHAFT: (names.SHAFT, ()),
    }
    parts = {}
    for name, (material, rounds) in bodies.items():
        holes = tuple(hole for joint in joints for hole in joint.holes_in(name))
        if holes or rounds or name == names.HOUSING:
            parts[name] = RoundPart(material, rounds, holes)
    return parts | {part.item: part.solid for part in bought_parts(joints)}


def casing_places(reducer: Reducer, sizes: Casing) -> Iterator[CasingPlace]:
    """Yield the places of the parts of the casing at the crank angle 0; ring and output are not among them."""
    for name in (MOTOR_COVER, OUTPUT_COVER):
        yield CasingPlace(name, name, (0.0, 0.0, 0.0), names.HOUSING)
    yield CasingPlace(FLANGE, FLANGE, (0.0, 0.0, 0.0), names.OUTPUT)
    for part in bought_parts(drive_joints(reducer, sizes)):
        for number, origin in enumerate(part.origins, start=part.first):
            yield CasingPlace(names.numbered(part.item, number), part.item, origin, part.body)


def bored_shaft(reducer: Reducer, sizes: Casing | None, chord_error: float | None = None) -> Part:
    """Return the shaft, bored where the motor's shaft enters if `sizes` state one.

    `chord_error` [m] is that of the outlines that balance, see `lay_out_parts`.
    """
    shaft = lay_out_parts(reducer, chord_error)[names.SHAFT]
    bore = motor_bore(reducer, sizes) if sizes else None
    if not bore:
        return shaft
    return shaft.of(with_holes(names.SHAFT, RoundPart(names.SHAFT, holes=((AXIS, *bore),)), shaft.stretches))


def _motor_cover(reducer: Reducer, sizes: Casing) -> tuple[Round, ...]:
    half = reducer.design.gear.stack_width / 2.0
    return ((sizes.outer, sizes.face, half if sizes.screws.outside else -half),)


def _output_cover(reducer: Reducer, sizes: Casing) -> tuple[Round, ...]:
    """Return the cover: one cylinder, or a slimmer one beyond the heads of its screws."""
    half, slim = reducer.design.gear.stack_width / 2.0, sizes.output_cavity + 2.0 * sizes.wall
    step = output_cover_step(reducer, sizes)
    if step:
        return (sizes.outer, half, step), (slim, step, sizes.top)
    return ((sizes.outer, half, sizes.top),)


def _hub(reducer: Reducer, sizes: Casing) -> tuple[Round, ...]:
    """Return what stands on the disc of the output: a floor over its bores, the shoulder and the hub."""
    floor = reducer.design.gear.stack_width / 2.0 + AXIAL_GAP + reducer.design.output.disc_thickness
    hub, shoulder = 0.5 * sizes.hub.bore, floor + 0.5 * AXIAL_GAP
    return (
        (sizes.rim, floor, shoulder),
        (shoulder_radius(hub, 0.5 * sizes.hub.outside), shoulder, sizes.hub_floor),
        (hub, sizes.hub_floor, sizes.top),
    )
