"""The moves by which a drive is assembled, and whether each part can pass the parts that are already there.

A part moves along the axis to its place. Swept along its path, its cross-section must not overlap those of the parts
that it passes. Parts that fit into each other, such as a pin in its bore, may touch.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import manifold3d
import numpy as np

from cycloid_mj.base import names
from cycloid_mj.parts import Prism
from cycloid_mj.parts.accuracy import SAME_LENGTH, VISUAL_CHORD_ERROR
from cycloid_mj.parts.export.assembly import assembly_parts, place_parts
from cycloid_mj.parts.export.casing import Casing
from cycloid_mj.parts.export.step import PlacedPart
from cycloid_mj.parts.polygon import rotate_points
from cycloid_mj.reducer import Reducer

PASSAGE = 4.0 * VISUAL_CHORD_ERROR
"""Overlap of sections that counts as touching [m]: chord errors of both, and interference of press fits."""

FLEX_SEGMENTS = 720
"""Number of edges of the circle to which a retaining ring is spread or pressed together: 0.2 um of error at 20 mm."""

CAM_BEFORE_GEAR = "shrink", "clamp"
"""Joints of cams that are put on the shaft before the bearings of their discs: hot cams, and those with screws."""

DRIVE = "drive"
"""The group that becomes the whole drive."""

UP, DOWN = 1, -1
"""Directions of a move along z: from motor to output, and back."""


@dataclass(frozen=True)
class Move:
    """Parts that move together into a group of parts, or start a group: their names, and the direction along z."""

    parts: tuple[str, ...]
    group: str
    direction: int = 0


@dataclass(frozen=True)
class Blockage:
    """A part that another part cannot pass on its way to its place."""

    part: str
    other: str


def assembly_moves(reducer: Reducer, casing: Casing) -> tuple[Move, ...]:
    """Return the moves of `order.assembly_order`; a group, once complete, moves by its name."""
    return tuple(_list_moves(reducer, casing, place_parts(reducer, 0.0, casing)))


def blockages(reducer: Reducer, casing: Casing) -> tuple[Blockage, ...]:
    """Find the parts of a drive that cannot be mounted because other parts are in their way.

    All moves are along z. The outlines of moving parts are compared with those of all parts ahead of them that are
    mounted already. Each `Blockage` names the moving part and the part in its way; they are in the order of assembly.
    """
    placement_by_name = {placement.name: placement for placement in place_parts(reducer, 0.0, casing)}
    prisms = {name: part.solid(VISUAL_CHORD_ERROR).prisms for name, part in assembly_parts(reducer, casing).items()}
    groups: dict[str, list[str]] = {}

    @cache
    def mounting_sections(name: str) -> tuple[tuple[float, float, manifold3d.CrossSection], ...]:
        placement = placement_by_name[name]
        sections = tuple(_placed_section(placement, prism) for prism in prisms[placement.part])
        return _flex_ring(reducer, casing, placement.part, sections)

    blocked_pairs = []
    for move in assembly_moves(reducer, casing):
        moving_parts = [part for name in move.parts for part in groups.pop(name, [name])]
        present_parts = groups.setdefault(move.group, [])
        blocked_pairs += [
            Blockage(moving_part, present_part)
            for moving_part in _representative_names(moving_parts, placement_by_name)
            for present_part in present_parts
            if move.direction
            and _is_blocked(mounting_sections(moving_part), mounting_sections(present_part), move.direction)
        ]
        present_parts += moving_parts
    return tuple(blocked_pairs)


def _representative_names(moving_names: list[str], placement_by_name: dict[str, PlacedPart]) -> list[str]:
    """Return one name for each group of equal parts at the same height, whose paths are equal by symmetry.

    `moving_names` are names, `placement_by_name` the positions by name.
    """
    representatives = {
        (placement_by_name[name].part, round(placement_by_name[name].origin[2], 9)): name
        for name in reversed(moving_names)
    }
    return [name for name in moving_names if name in representatives.values()]


def _placed_section(placement: PlacedPart, prism: Prism) -> tuple[float, float, manifold3d.CrossSection]:
    """Return the ends along z [m] of a prism in its place, and its section in micrometres."""
    x, y, z = placement.origin
    polygons = [rotate_points(polygon, placement.angle) + np.array([x, y]) for polygon in (prism.outline, *prism.holes)]
    section = manifold3d.CrossSection([1e6 * polygon for polygon in polygons], manifold3d.FillRule.EvenOdd)
    return prism.z0 + z, prism.z1 + z, section


def _flex_ring(reducer: Reducer, casing: Casing, part: str, sections: "Sections") -> "Sections":
    """Return the cross-sections of a part during mounting; a retaining ring is spread or squeezed for it.

    A ring is spread over the shaft or squeezed into a bore. `part` is the name of the part, and `sections` are both
    ends along z [m] and the outline [um] of each of its sections as mounted. Those of parts that are not retaining
    rings are returned unchanged.
    """
    if part == names.SHAFT_RING:
        shaft_section = manifold3d.CrossSection.circle(1e6 * reducer.design.shaft.radius, FLEX_SEGMENTS)
        return tuple((z0, z1, section - shaft_section) for z0, z1, section in sections)
    if part == names.BORE_RING:
        bore_section = manifold3d.CrossSection.circle(1e6 * casing.seat, FLEX_SEGMENTS)
        return tuple((z0, z1, section ^ bore_section) for z0, z1, section in sections)
    return sections


Sections = tuple[tuple[float, float, manifold3d.CrossSection], ...]


def _is_blocked(moving_sections: Sections, present_sections: Sections, direction: int) -> bool:
    """Return whether sections of a moving part would overlap others on their path along z; touching does not count.

    Parameters
    ----------
    moving_sections, present_sections
        For each section both ends along z [m], and its outline [um].
    direction
        `UP` or `DOWN`.
    """
    for moving_z0, moving_z1, moving_section in moving_sections:
        for z0, z1, present_section in present_sections:
            is_ahead = z0 < moving_z1 - SAME_LENGTH if direction == UP else z1 > moving_z0 + SAME_LENGTH
            if not is_ahead:
                continue
            overlap = moving_section ^ present_section
            if not overlap.is_empty() and not overlap.offset(-0.5e6 * PASSAGE).is_empty():
                return True
    return False


def _list_moves(reducer: Reducer, casing: Casing, placements: tuple[PlacedPart, ...]) -> Iterator[Move]:
    """Yield the moves along the axis that assemble a drive, in order: output, ring, discs and crank, motor cover.

    `placements` are all parts of the drive with their final positions.
    """
    yield from _list_output_moves(casing, placements)
    yield from _list_crank_moves(reducer, casing, placements)
    yield Move((names.MOTOR_COVER,), names.MOTOR_COVER)
    yield Move(_names_of_family(placements, names.SCREW_INSERT), names.MOTOR_COVER, DOWN)
    yield Move(_names_of_family(placements, names.MOTOR_INSERT), names.MOTOR_COVER, UP)
    yield Move(_names_of_family(placements, names.MOTOR_SCREW), names.MOTOR_COVER, DOWN)
    yield Move(_names_of_family(placements, names.SHAFT_SEAL), names.MOTOR_COVER, DOWN)
    first_bearing, *other_bearings = sorted(_names_of_family(placements, names.SHAFT_BEARING, DOWN))
    yield Move((first_bearing,), names.MOTOR_COVER, DOWN)
    yield Move(_names_of_family(placements, names.BEARING_SPACER), names.MOTOR_COVER, DOWN)
    yield Move(tuple(other_bearings), names.MOTOR_COVER, DOWN)
    yield Move(_names_of_family(placements, names.BORE_RING), names.MOTOR_COVER, DOWN)
    yield Move(_names_of_family(placements, names.DOWEL, DOWN), names.MOTOR_COVER, DOWN)
    yield Move((names.MOTOR_COVER,), DRIVE, UP)
    yield Move(_names_of_family(placements, names.SCREW), DRIVE, DOWN)
    yield Move(_names_of_family(placements, names.SHAFT_RING), DRIVE, UP)


def _names_of_family(placements: tuple[PlacedPart, ...], family: str, side: int = 0) -> tuple[str, ...]:
    """Return the names of the parts of a family, all or those on one side of the middle of the discs."""
    return tuple(
        placement.name
        for placement in placements
        if names.family(placement.part) == family and (not side or (placement.origin[2] >= 0.0) == (side == UP))
    )


def _names_of_moving_parts(placements: tuple[PlacedPart, ...], gear: str) -> tuple[str, ...]:
    """Return the names of the parts that move with the disc `gear`."""
    return tuple(item.name for item in placements if item.body == gear and item.name != gear)


def _screws_of_cam(reducer: Reducer, placements: tuple[PlacedPart, ...], number: int) -> tuple[str, ...]:
    """Return the names of the screws of a clamped cam by its number from 1; none of other cams."""
    screws = _names_of_family(placements, names.CAM_SCREW)
    screws_per_cam = len(screws) // len(reducer.gears)
    return screws[(number - 1) * screws_per_cam : number * screws_per_cam]


def _list_output_moves(casing: Casing, placements: tuple[PlacedPart, ...]) -> Iterator[Move]:
    """Yield the moves along the axis that assemble the output, its bearings and flange, then the ring and its pins.

    `placements` are all parts of the drive with their final positions.
    """
    yield Move((names.OUTPUT,), "hub")
    yield Move(_names_of_family(placements, names.FLANGE_INSERT), "hub", DOWN)
    yield Move(_names_of_family(placements, names.OUTPUT_PIN), "hub", UP)
    yield Move((names.OUTPUT_COVER,), DRIVE)
    *inner_bearings, outer_bearing = sorted(_names_of_family(placements, names.OUTPUT_BEARING))
    yield Move(_names_of_family(placements, names.RETAINER_INSERT), DRIVE, DOWN)
    if not casing.motor_bearing:
        yield Move(tuple(inner_bearings), DRIVE, UP)
    yield Move((outer_bearing,), DRIVE, UP if casing.has_outer_lip else DOWN)
    for family in (names.RETAINER, names.RETAINER_SCREW):
        yield Move(_names_of_family(placements, family), DRIVE, DOWN)
    if casing.far:
        yield Move(_names_of_family(placements, names.SHAFT_BEARING, UP), "hub", UP)
    yield Move(("hub",), DRIVE, UP)
    yield Move(_names_of_family(placements, names.FLANGE_DOWEL), DRIVE, DOWN)
    yield Move((names.FLANGE,), "flange")
    yield Move(_names_of_family(placements, names.LOAD_INSERT), "flange", DOWN)
    yield Move(("flange",), DRIVE, DOWN)
    yield Move(_names_of_family(placements, names.FLANGE_WASHER), DRIVE, DOWN)
    yield Move(_names_of_family(placements, names.FLANGE_SCREW), DRIVE, DOWN)
    yield Move(_names_of_family(placements, names.DOWEL, UP), DRIVE, UP)
    yield Move((names.HOUSING,), DRIVE, UP)
    for family in (names.PRESSED_PIN, names.PIN):
        yield Move(_names_of_family(placements, family), DRIVE, UP)
    rollers = names.ROLLER, names.ROLLER_BEARING
    yield Move(tuple(name for family in rollers for name in _names_of_family(placements, family)), DRIVE, UP)


def _list_second_disc_moves(casing: Casing, placements: tuple[PlacedPart, ...]) -> Iterator[Move]:
    """Yield the moves along the axis that mount a second disc of the output, with its bearing if there is one.

    A bearing that is supported by a stop ring is on the disc before. `placements` are all parts of the drive with their
    final positions.
    """
    disc, bearing = (names.SECOND_OUTPUT,), _names_of_family(placements, names.OUTPUT_BEARING, DOWN)
    if casing.stop_ring:
        yield Move(disc, names.SECOND_OUTPUT)
        yield Move(bearing, names.SECOND_OUTPUT, DOWN)
        yield Move((names.STOP_RING,), DRIVE, UP)
        yield Move((names.SECOND_OUTPUT,), DRIVE, UP)
    elif any(placement.name == names.SECOND_OUTPUT for placement in placements):
        yield Move(disc, DRIVE, UP)
        yield Move(bearing, DRIVE, UP)


def _list_crank_moves(reducer: Reducer, casing: Casing, placements: tuple[PlacedPart, ...]) -> Iterator[Move]:
    """Yield the moves along the axis that insert a single disc and then the crank, or the crank with its several discs.

    `placements` are all parts of the drive with their final positions.
    """
    ring_names, shaft = _names_of_family(placements, names.CRANK_RING), names.SHAFT
    second_disc_moves = tuple(_list_second_disc_moves(casing, placements))
    if reducer.design.gear.discs == 1:
        yield Move((names.GEAR,), names.GEAR)
        yield Move(_names_of_family(placements, names.CAM_BEARING), names.GEAR, UP)
        yield Move((names.GEAR,), DRIVE, UP)
        yield Move((shaft,), shaft)
        yield Move(ring_names[:1], shaft, UP)
        yield Move(ring_names[1:], shaft, DOWN)
        yield from (*second_disc_moves, Move((shaft,), DRIVE, UP))
        return
    if reducer.design.has_one_piece_crank:
        yield Move((shaft,), shaft)
        for gear, direction in zip(reducer.gears, (UP, DOWN), strict=True):
            yield Move((gear,), gear)
            yield Move(_names_of_moving_parts(placements, gear), gear, direction)
            yield Move((gear,), shaft, direction)
        yield from (Move((shaft,), DRIVE, UP), *second_disc_moves)
        return
    yield Move((shaft, *_names_of_family(placements, names.KEY)), shaft)
    is_cam_first = reducer.design.cam_joint in CAM_BEFORE_GEAR
    for number, gear in enumerate(reducer.gears, start=1):
        if number > 1:
            yield Move((names.numbered_name(names.SPACER, number - 1),), shaft, DOWN)
        cam_move = Move((names.numbered_name(names.CAM, number),), shaft if is_cam_first else gear, DOWN)
        if is_cam_first:
            yield cam_move
            yield Move(_screws_of_cam(reducer, placements, number), shaft)
        yield Move((gear,), gear)
        yield Move(_names_of_moving_parts(placements, gear), gear, DOWN)
        if not is_cam_first:
            yield cam_move
        yield Move((gear,), shaft, DOWN)
    yield Move(ring_names[1:], shaft, DOWN)
    yield from (Move((shaft,), DRIVE, UP), *second_disc_moves)
    yield Move(ring_names[:1], DRIVE, UP)
