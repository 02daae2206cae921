"""Solids and places of the casing: the bodies of covers, hub and flange, with the holes and bought parts of joints."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from cycloid_mj.base import names
from cycloid_mj.parts import Part, Segment, crank_segments, lay_out_parts
from cycloid_mj.parts.accuracy import SAME_LENGTH
from cycloid_mj.parts.cam_bearing import cam_bearing
from cycloid_mj.parts.contour import CircleContour, TurnedContour
from cycloid_mj.parts.export.bearings import pin_pieces, ring_pin_radius, roller_bore, sleeve_pin_length
from cycloid_mj.parts.export.cam_clamp import cam_clamp, slotted_contour
from cycloid_mj.parts.export.cam_splines import cam_spline, spline_contour
from cycloid_mj.parts.export.casing import Casing, output_cover_step
from cycloid_mj.parts.export.crank_joints import cam_key
from cycloid_mj.parts.export.crank_rings import (
    CrankRing,
    bearing_spacers,
    counterweight_shift,
    crank_collars,
    crank_rings,
    disc_collar_neck,
    hub_radius,
)
from cycloid_mj.parts.export.joint import Point
from cycloid_mj.parts.export.joints import bought_parts, drive_joints
from cycloid_mj.parts.export.keyway import KeywayContour, SplineContour
from cycloid_mj.parts.export.round_part import AXIS, Pocket, Round, RoundPart, cut_holes
from cycloid_mj.parts.shaft import COUNTERWEIGHT, INNER, JOURNAL
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP

COLLAR = "collar"
"""Segment of a crank in one piece that locates it between its bearings."""

MIN_POCKET = 3e-3
"""Least width and depth of a pocket [m], for a cutter (assumed)."""


@dataclass(frozen=True)
class CasingPosition:
    """Position of a part of the casing: its name there, the part, its origin [m], and the body that it moves with."""

    name: str
    part: str
    origin: Point
    body: str


def casing_parts(reducer: Reducer, casing: Casing) -> dict[str, RoundPart]:
    """Return the parts of the casing, such as ``names.MOTOR_COVER``, as cylinders with holes and pockets, by name.

    The values of housing, output and shaft, parts of the mechanism, are only the cylinders and holes that the casing
    adds to them. Bought parts, such as screws, are included.
    """
    joints = drive_joints(reducer, casing)
    bodies = {
        names.HOUSING: (names.HOUSING, ()),
        names.OUTPUT: (names.OUTPUT, _hub_cylinders(reducer, casing)),
        names.MOTOR_COVER: (names.HOUSING, _motor_cover_cylinders(casing)),
        names.OUTPUT_COVER: (names.HOUSING, _output_cover(casing)),
        names.FLANGE: (names.OUTPUT, _flange_rounds(casing)),
        names.RETAINER: (names.HOUSING, _retainer_rounds(casing)),
        names.STOP_RING: (names.HOUSING, _stop_ring_rounds(casing)),
        names.SHAFT: (names.SHAFT, ()),
    }
    parts = {}
    for ring in (*crank_rings(reducer, casing), *bearing_spacers(reducer, casing)):
        bore = AXIS, ring.bore, ring.low, ring.high
        parts[ring.name] = RoundPart(names.SHAFT, ((ring.radius, ring.low, ring.high),), (bore,))
    for name, (material, cylinders) in bodies.items():
        holes = tuple(hole for joint in joints for hole in joint.holes_in(name))
        if holes or cylinders:
            pockets = _motor_pocket(casing) if name == names.MOTOR_COVER else ()
            parts[name] = RoundPart(material, cylinders, holes, pockets=pockets)
    return parts | {part.item: part.solid for part in bought_parts(joints)}


def place_casing(reducer: Reducer, casing: Casing) -> Iterator[CasingPosition]:
    """Yield the parts of the casing with their positions at crank angle 0; ring and output are not among them."""
    rings = ((names.RETAINER, casing.retainer), (names.STOP_RING, casing.stop_ring))
    for name in (names.MOTOR_COVER, names.OUTPUT_COVER, *(name for name, ring in rings if ring)):
        yield CasingPosition(name, name, (0.0, 0.0, 0.0), names.HOUSING)
    yield CasingPosition(names.FLANGE, names.FLANGE, (0.0, 0.0, 0.0), names.OUTPUT)
    for ring in (*crank_rings(reducer, casing), *bearing_spacers(reducer, casing)):
        yield CasingPosition(ring.name, ring.name, (0.0, 0.0, 0.0), ring.body)
    for part in bought_parts(drive_joints(reducer, casing)):
        for number, origin in enumerate(part.origins, start=part.first):
            yield CasingPosition(names.numbered_name(part.item, number), part.item, origin, part.body)


def bored_shaft(reducer: Reducer, casing: Casing | None, chord_error: float | None = None) -> Part:
    """Return the shaft as exact outlines, adapted to its joints by `fit_part` and with the bore for the motor's shaft.

    With `casing` None, it is the shaft of the mechanism. The crank is balanced for a `chord_error` [m] of its outlines,
    see `lay_out_parts`.
    """
    shaft = lay_out_parts(reducer, chord_error)[names.SHAFT]
    if not casing:
        return shaft
    bore = casing.motor_bore
    holes = ((AXIS, *bore),) if bore else ()
    fitted_part = fit_part(reducer, casing, names.SHAFT, shaft)
    return fitted_part.of(cut_holes(names.SHAFT, RoundPart(names.SHAFT, holes=holes), fitted_part.segments))


def fit_part(reducer: Reducer, casing: Casing, name: str, part: Part) -> Part:
    """Adapt a part of the mechanism to its joints in a drive: axial clearances, bores, grooves and keyways.

    `name` is the name of the part. The ring is wider than discs, pins and sleeves. The counterweight makes room for a
    collar next to its bearing. A spacer touches the cams; its rim, which guides discs that turn at another speed, is
    narrower. So is the collar between two discs on a crank in one piece. Shaft, cams and spacer have keyways. Bearings
    in stock are pressed into the discs, and rollers turn on their pins.
    """
    segments, family = part.segments, names.family(name)
    if name == names.HOUSING:
        return part.of(_lengthen(item, casing.play, item is segments[0], item is segments[-1]) for item in segments)
    if name == names.PRESSED_PIN:
        half_pin_length = 0.5 * sleeve_pin_length(reducer)
        return part.of(replace(segment, z0=-half_pin_length, z1=half_pin_length) for segment in segments)
    if name == names.PIN:
        _, length = pin_pieces(reducer)
        outline = CircleContour(ring_pin_radius(reducer))
        return part.of(replace(item, outline=outline, z0=-0.5 * length, z1=0.5 * length) for item in segments)
    if name == names.OUTPUT and reducer.design.output.has_disc_seat:
        return part.of(_split_output_disc(casing, segments))
    if name == names.SECOND_OUTPUT and casing.motor_bearing:
        return part.of(_split_second_disc(casing, casing.motor_bearing, segments))
    if family == names.GEAR and cam_bearing(reducer):
        bore = CircleContour(reducer.design.gear.bore_radius)
        return part.of(replace(segment, holes=(bore, *segment.holes[1:])) for segment in segments)
    if name == names.ROLLER:
        bore = CircleContour(roller_bore(reducer))
        return part.of(replace(segment, holes=(bore,)) for segment in segments)
    if family in (names.CAM, names.SPACER, names.SHAFT):
        return part.of(_fit_crank_segments(reducer, casing, family, segments))
    return part


def _split_output_disc(casing: Casing, segments: Sequence[Segment]) -> Iterator[Segment]:
    """Yield the segments of the output, whose first segment, the disc, is the seat of the output's bearings.

    The disc is divided into the shoulder of the bearings and their seat. There is no shoulder next to a stop ring: the
    flange clamps the inner ring towards the other bearing.
    """
    disc, *others = segments
    seat = CircleContour(0.5 * casing.hub.bore)
    if casing.stop_ring:
        yield replace(disc, outline=seat)
    else:
        shoulder_end = casing.bearings[-1 if casing.motor_bearing else 0][0]
        yield replace(disc, outline=CircleContour(casing.hub.shoulders[0]), z1=shoulder_end)
        yield replace(disc, outline=seat, z0=shoulder_end)
    yield from others


def _split_second_disc(casing: Casing, bearing: tuple[float, float], segments: Sequence[Segment]) -> Iterator[Segment]:
    """Yield the segments of the output's second disc, divided into the seat of a bearing around it and its shoulder.

    The shoulder is next to the cycloid discs, or with a stop ring at the other side of the bearing. `bearing` are the
    ends of the bearing along z [m].
    """
    seat, shoulder = CircleContour(0.5 * casing.hub.bore), CircleContour(casing.hub.shoulders[0])
    first, second, step = (shoulder, seat, bearing[0]) if casing.stop_ring else (seat, shoulder, bearing[1])
    for disc in segments:
        yield replace(disc, outline=first, z1=step)
        yield replace(disc, outline=second, z0=step)


def _lengthen(segment: Segment, play: float, at_start: bool, at_end: bool) -> Segment:
    """Return a segment that is longer by a play [m] at its start, its end or both."""
    return replace(segment, z0=segment.z0 - play * at_start, z1=segment.z1 + play * at_end)


def _fit_crank_segments(
    reducer: Reducer, casing: Casing, family: str, segments: Sequence[Segment]
) -> Iterator[Segment]:
    """Adapt the segments of a shaft, cam or spacer to a drive: keyways, axial clearances, and where a shaft starts.

    A shaft starts at `casing.journal`. Yields the segments along z. `family` is the kind of the part: ``names.SHAFT``,
    ``names.CAM`` or ``names.SPACER``.
    """
    if family == names.SHAFT:
        segments = (*_cut_groove(casing, replace(segments[0], z0=casing.journal)), *segments[1:])
    if reducer.design.has_one_piece_crank:
        segments = tuple(_cut_disc_collars(reducer, casing, segments))
        counterweight_offset, collars = counterweight_shift(reducer), crank_collars(reducer, casing, segments)
        for segment in segments:
            moves_start, moves_end = segment.name in (COUNTERWEIGHT, INNER), segment.name in (JOURNAL, COUNTERWEIGHT)
            shifted_segment = replace(
                segment,
                z0=segment.z0 + counterweight_offset * moves_start,
                z1=segment.z1 + counterweight_offset * moves_end,
            )
            yield from _add_collars(shifted_segment, collars)
        return
    key, radius = cam_key(reducer, casing), reducer.design.shaft.radius
    pieces = _split_spacer(reducer, casing, segments) if family == names.SPACER else tuple(segments)
    if spline := cam_spline(reducer):
        yield from _cut_splines(reducer, family, pieces, spline_contour(spline))
    elif cam_clamp(reducer) and family == names.CAM:
        yield from (replace(piece, outline=slotted_contour(reducer, _cam_phase(piece)), holes=()) for piece in pieces)
    elif key is None:
        yield from pieces
    elif family == names.SHAFT:
        *groove_pieces, shaft = pieces
        yield from groove_pieces
        slot = KeywayContour(radius, key.bought.width, -key.bought.in_shaft, key.angle)
        yield replace(shaft, z1=key.low)
        yield replace(shaft, outline=slot, z0=key.low, z1=key.high)
        yield replace(shaft, z0=key.high)
    else:
        slot = KeywayContour(radius, key.bought.width, key.bought.in_hub, key.angle)
        yield from (replace(piece, holes=(slot,)) for piece in pieces)


def _cam_phase(cam: Segment) -> float:
    """Return the phase of a cam [rad]."""
    return cam.outline.angle if isinstance(cam.outline, TurnedContour) else 0.0


def _cut_splines(reducer: Reducer, family: str, pieces: Sequence[Segment], spline: SplineContour) -> Iterator[Segment]:
    """Yield the pieces of a shaft, cam or spacer with the splines that join cams and shaft.

    `family` is the kind of the part: ``names.SHAFT``, ``names.CAM`` or ``names.SPACER``. On the shaft, the splines
    extend from the first to the last cam.
    """
    if family != names.SHAFT:
        yield from (replace(piece, holes=(spline,)) for piece in pieces)
        return
    segments = crank_segments(reducer)
    cams = [segments[name] for name in names.all_numbered(names.CAM, reducer.design.gear.discs)]
    *groove_pieces, shaft = pieces
    yield from groove_pieces
    yield replace(shaft, z1=cams[0].z0)
    yield replace(shaft, outline=spline, z0=cams[0].z0, z1=cams[-1].z1)
    if shaft.z1 > cams[-1].z1 + SAME_LENGTH:
        yield replace(shaft, z0=cams[-1].z1)


def _cut_disc_collars(reducer: Reducer, casing: Casing, segments: Iterable[Segment]) -> Iterator[Segment]:
    """Yield the segments of a one-piece crank for two discs: the collar between them gets a neck at both sides."""
    neck = CircleContour(reducer.design.shaft.radius)
    length = disc_collar_neck(reducer, casing)
    for segment in segments:
        if names.family(segment.name) != names.SPACER:
            yield segment
            continue
        neck_start, neck_end = segment.z0 + length, segment.z1 - length
        yield replace(segment, outline=neck, z1=neck_start)
        yield replace(segment, z0=neck_start, z1=neck_end)
        yield replace(segment, outline=neck, z0=neck_end)


def _cut_groove(casing: Casing, journal: Segment) -> Iterator[Segment]:
    """Split the journal of a crank at the groove of its retaining ring; yield the pieces along z."""
    ring = casing.crank_end.shaft_ring
    if ring is None:
        yield journal
        return
    end = casing.near[0]
    start = end - ring.groove_width
    yield replace(journal, z1=start)
    yield replace(journal, outline=CircleContour(0.5 * ring.groove), z0=start, z1=end)
    yield replace(journal, z0=end)


def _add_collars(segment: Segment, collars: Sequence[CrankRing]) -> Iterator[Segment]:
    """Split a segment of the crank at the ends of its collars; yield the pieces along z, collars included."""
    start = segment.z0
    for collar in collars:
        if segment.z0 - SAME_LENGTH < collar.low and collar.high < segment.z1 + SAME_LENGTH:
            if collar.low > start + SAME_LENGTH:
                yield replace(segment, z0=start, z1=collar.low)
            yield Segment(COLLAR, CircleContour(collar.radius), segment.holes, max(collar.low, start), collar.high)
            start = collar.high
    if segment.z1 > start + SAME_LENGTH:
        yield replace(segment, z0=start)


def _split_spacer(reducer: Reducer, casing: Casing, segments: Sequence[Segment]) -> tuple[Segment, ...]:
    """Split a spacer into hub, wide rim and hub along z; the rim is narrower by the axial play on both sides."""
    (spacer,) = segments
    hub = replace(spacer, outline=CircleContour(hub_radius(reducer, casing)))
    rim_start, rim_end = spacer.z0 + casing.play, spacer.z1 - casing.play
    return replace(hub, z1=rim_start), replace(spacer, z0=rim_start, z1=rim_end), replace(hub, z0=rim_end)


def _motor_cover_cylinders(casing: Casing) -> tuple[Round, ...]:
    """Return the cylinders of the motor cover along z: a narrow one next to the motor, if stepped, and the wide one.

    The wide cylinder ends at the ring, or, with screws outside of the ring, continues around it as a rim. The rim ends
    below the other end of the ring by the axial play, so that the other cover clamps the ring and not the rim.
    """
    cover_end = casing.end - casing.play if casing.screws.outside else -casing.end
    if casing.step - casing.face > 2.0 * casing.wall and casing.slim + casing.wall < casing.outer:
        return (casing.slim, casing.face, casing.step), (casing.outer, casing.step, cover_end)
    return ((casing.outer, casing.face, cover_end),)


def _motor_pocket(casing: Casing) -> tuple[Pocket, ...]:
    """Return the pocket around the boss of the bearing in the motor cover, if there is room for a cutter."""
    if min(casing.cavity - casing.boss, casing.floor - casing.pocket) < MIN_POCKET:
        return ()
    return ((casing.cavity, casing.boss, casing.pocket, casing.floor),)


def _output_cover(casing: Casing) -> tuple[Round, ...]:
    """Return the cylinders of the output cover: a single one, or a slimmer one beyond the heads of its screws."""
    step_height = output_cover_step(casing)
    if step_height:
        return (casing.outer, casing.end, step_height), (casing.output_neck, step_height, casing.output_cover_end)
    return ((casing.outer, casing.end, casing.output_cover_end),)


def _retainer_rounds(casing: Casing) -> tuple[Round, ...]:
    """Return the cylinder of the retainer of a crossed roller bearing; none for a pair of bearings."""
    ring = casing.retainer
    return ((ring.radius, casing.top, casing.top + ring.thickness),) if ring else ()


def _stop_ring_rounds(casing: Casing) -> tuple[Round, ...]:
    """Return the cylinder of the stop ring of the bearing around the second disc of the output; none without it."""
    ring = casing.stop_ring
    return ((ring.radius, -casing.end - ring.thickness, -casing.end),) if ring else ()


def _flange_rounds(casing: Casing) -> tuple[Round, ...]:
    """Return the cylinders of the output flange: one that clamps the inner ring, and a wider one that covers a gap."""
    end, step_height = casing.top + casing.flange_thickness, casing.top + casing.play
    if casing.gap_seal_radius == casing.flange_radius:
        return ((casing.flange_radius, casing.top, end),)
    return (casing.flange_radius, casing.top, step_height), (casing.gap_seal_radius, step_height, end)


def _hub_cylinders(reducer: Reducer, casing: Casing) -> tuple[Round, ...]:
    """Return the cylinders that the casing adds to the disc of the output: floor, shoulder of the bearings, and hub.

    The floor covers the bores for the output pins. If the bearings are around the disc itself, there is only a cylinder
    that continues the disc to the flange, if a gap is left.
    """
    floor_z = reducer.design.gear.stack_width / 2.0 + AXIAL_GAP + reducer.design.output.disc_thickness
    if reducer.design.output.has_disc_seat:
        return ((0.5 * casing.hub.bore, floor_z, casing.top),) if casing.top > floor_z + SAME_LENGTH else ()
    shoulder_z, first_bearing = floor_z + 0.5 * AXIAL_GAP, casing.bearings[0][0]
    return (
        (casing.rim, floor_z, shoulder_z),
        (casing.hub.shoulders[0], shoulder_z, first_bearing),
        (0.5 * casing.hub.bore, first_bearing, casing.top),
    )
