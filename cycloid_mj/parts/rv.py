"""The parts of an RV reducer: discs, ring, cranks with planets, sun, and the two flanges of the carrier.

Along z, from the motor: planets and sun, flange 1, the discs, flange 2 with the posts. Crank 1 is on +y; cranks and
posts are numbered clockwise. Not drawn: splines, screws, seals, the shaft of the sun, and the shims and rings that hold
the crank bearings. Main bearings are drawn if the design has them (``cranks.main_bearings``).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.geometry import profile
from cycloid_mj.parts.contour import CircleContour, TurnedContour, circles_at
from cycloid_mj.parts.fit import require_below
from cycloid_mj.parts.gear import GearContour
from cycloid_mj.parts.housing import housing_part, pin_part
from cycloid_mj.parts.part import Part, Segment
from cycloid_mj.parts.spur_gear import SpurGearContour
from cycloid_mj.reducer import RvReducer, once
from cycloid_mj.reducer.bending import AXIAL_GAP
from cycloid_mj.reducer.rv_main_bearings import (
    flange_face,
    main_bearing_ends,
    require_main_bearings,
    stop_ring_thickness,
)

CRANK, PLANET, SUN, CARRIER = names.CRANK, names.PLANET, names.SUN, "carrier"
"""Parts of an RV reducer, besides housing, pin and discs; the flanges are ``carrier_1`` and ``carrier_2``."""

NEEDLE, TAPERED_BEARING = "needle", "tapered_bearing"
"""Bearings of the cranks: a needle in a disc, and a tapered bearing in a flange, drawn as a ring."""

FLANGES = names.all_numbered(CARRIER, 2)

PIN_END_PLAY = 0.1e-3
"""Distance of a ring pin from the outer ring of a main bearing at each end [m] (assumed, as from a metal cover)."""


@dataclass(frozen=True)
class AxialLayout:
    """Ends along z [m] of the flanges on both sides of the discs, and of the planets."""

    flanges: tuple[tuple[float, float], tuple[float, float]]
    planets: tuple[float, float]

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the reducer along z [m]: face of the planets, and outer face of the second flange."""
        return self.planets[0], self.flanges[1][1]

    @property
    def length(self) -> float:
        """Length between the `ends` [m]."""
        near, far = self.ends
        return far - near

    @property
    def planet_middle(self) -> float:
        """Middle of sun and planets along z [m]."""
        return sum(self.planets) / 2.0


def axial_layout(reducer: RvReducer) -> AxialLayout:
    """Return the ends of flanges and planets along z, with `AXIAL_GAP` between faces that turn against each other."""
    near = reducer.design.gear.stack_width / 2.0 + AXIAL_GAP
    far = near + reducer.cranks.flange_thickness
    planets = (-far - AXIAL_GAP - reducer.planet.face_width, -far - AXIAL_GAP)
    return AxialLayout(((-far, -near), (near, far)), planets)


def crank_bearing_ends(reducer: RvReducer) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the ends along z [m] of the crank bearings in both flanges.

    Bearings in stock begin at the faces of the flanges next to the discs; special ones are as wide as the flanges.
    """
    flanges, bearing = axial_layout(reducer).flanges, reducer.crank_bearing
    if bearing is None:
        return flanges
    return (flanges[0][1] - bearing.width, flanges[0][1]), (flanges[1][0], flanges[1][0] + bearing.width)


def rv_parts(reducer: RvReducer) -> dict[str, Part]:
    """Return the parts of an RV reducer by name, such as ``crank``, each once and in its own frame.

    Housing and flanges are in the frame of the reducer's axis.

    Raises
    ------
    DesignError
        A part cannot be manufactured, or does not fit.
    """
    return dict(_rv_parts(reducer.shape))


def rv_bearings(reducer: RvReducer) -> dict[str, Part]:
    """Return the bearings as rings about z = 0, by name: `TAPERED_BEARING`, and ``output_bearing``, if there is any."""
    crank_bearing = reducer.crank_bearing
    crank_bearing_width = crank_bearing.width if crank_bearing else reducer.cranks.flange_thickness
    radii = {TAPERED_BEARING: (reducer.cranks.taper_radius, reducer.journal_radius, crank_bearing_width)}
    if bearing := reducer.main_bearing:
        radii[names.OUTPUT_BEARING] = 0.5 * bearing.outside, 0.5 * bearing.bore, bearing.width
    density = reducer.design.material_of("shaft").density
    return {
        name: Part(
            name, (Segment(name, CircleContour(outer), (CircleContour(inner),), -width / 2.0, width / 2.0),), density
        )
        for name, (outer, inner, width) in radii.items()
    }


def rv_body_parts(reducer: RvReducer) -> dict[str, Part]:
    """Return one part per moving body of an RV reducer by the name of its main part, in the frame of the body.

    A crank includes its planet. The carrier, named ``names.OUTPUT``, includes both flanges and the tapered bearings,
    with the density of the flanges. Needles and main bearings are not included.

    Raises
    ------
    DesignError
        A part cannot be manufactured, or does not fit.
    """
    parts = rv_parts(reducer)
    sun, planet = (_shift_to_planets(reducer, parts[name]) for name in (SUN, PLANET))
    planet_segments = [replace(item, outline=TurnedContour(item.outline, planet_angle(reducer))) for item in planet]
    flanges = [parts[name] for name in FLANGES]
    tapers = [
        Segment(TAPERED_BEARING, outer, (CircleContour(reducer.journal_radius, outer.centre),), z0, z1)
        for z0, z1 in crank_bearing_ends(reducer)
        for outer in circles_at(reducer.cranks.taper_radius, crank_centres(reducer))
    ]
    single_parts = {names.HOUSING, *reducer.gears, names.PIN} & parts.keys()
    return {name: parts[name] for name in parts if name in single_parts} | {
        SUN: parts[SUN].of(sun),
        CRANK: parts[CRANK].of([*parts[CRANK].segments, *planet_segments]),
        names.OUTPUT: flanges[0].of([*(item for flange in flanges for item in flange.segments), *tapers], names.OUTPUT),
    }


def planet_angle(reducer: RvReducer) -> float:
    """Return the angle of a planet's teeth [rad] at the crank angle 0: a tooth points at a tooth space of the sun."""
    return float(np.pi - np.pi / reducer.planet.planet_teeth)


def _shift_to_planets(reducer: RvReducer, part: Part) -> list[Segment]:
    """Return the segments of a gear that is centred on z = 0, at the planets along z."""
    middle = axial_layout(reducer).planet_middle
    return [replace(item, z0=item.z0 + middle, z1=item.z1 + middle) for item in part.segments]


def crank_centres(reducer: RvReducer) -> Array:
    """Return the crank axes in the frame of the carrier (n, 2) [m]."""
    return reducer.stage.crank_positions([0.0])[0]


def post_centres(reducer: RvReducer) -> Array:
    """Return the axes of the posts in the frame of the carrier (n, 2) [m]: one between two cranks."""
    count = reducer.cranks.count
    return np.asarray(reducer.post_circle_radius * profile.unit(2.0 * np.pi * (np.arange(count) + 0.5) / count))


def _middle_hole(reducer: RvReducer) -> tuple[CircleContour, ...]:
    """Return the hole in the middle of discs and flanges; none if its radius is 0."""
    radius = reducer.cranks.middle_hole_radius
    return (CircleContour(radius),) if radius else ()


@once
def _rv_parts(reducer: RvReducer) -> dict[str, Part]:
    """Return the parts of an RV reducer by name, each once and in its own frame; computed once for each reducer."""
    if reducer.cranks.main_bearings != "none":
        require_main_bearings(reducer)
    parts = [_rv_housing(reducer), *_rv_discs(reducer), *_crank_and_gears(reducer), *_carrier_flanges(reducer)]
    if reducer.design.ring.kind == "pin":
        parts.append(_rv_pin(reducer))
    parts += _stop_rings(reducer)
    half_width = reducer.design.gear.face_width / 2.0
    needle = Segment(NEEDLE, CircleContour(reducer.cranks.needle_radius), (), -half_width, half_width)
    parts.append(Part(NEEDLE, (needle,), reducer.design.material_of("shaft").density))
    return {part.name: part for part in parts}


def _rv_housing(reducer: RvReducer) -> Part:
    """Return the housing: the ring, and the seats of the main bearings at both ends, if there are any.

    The ring is then as wide as the distance of the flanges.
    """
    ring_part, bearing = housing_part(reducer), reducer.main_bearing
    if bearing is None:
        return ring_part
    start, (_, end) = flange_face(reducer), main_bearing_ends(reducer, bearing)
    seat = Segment("bearing seat", ring_part.segments[0].outline, (CircleContour(0.5 * bearing.outside),), start, end)
    seats = replace(seat, z0=-end, z1=-start), seat
    return ring_part.of([*(replace(segment, z0=-start, z1=start) for segment in ring_part.segments), *seats])


def _rv_pin(reducer: RvReducer) -> Part:
    """Return a ring pin; between main bearings or their stop rings it has `PIN_END_PLAY` at both ends."""
    pin = pin_part(reducer)
    if reducer.main_bearing is None:
        return pin
    half_length = flange_face(reducer) - PIN_END_PLAY
    return pin.of([replace(segment, z0=-half_length, z1=half_length) for segment in pin.segments])


def _stop_rings(reducer: RvReducer) -> Iterator[Part]:
    """Yield the stop ring of a main bearing, about z = 0, if its outer ring does not retain the ring pins."""
    bearing = reducer.main_bearing
    if bearing and (thickness := stop_ring_thickness(reducer, bearing)):
        outline, bore = CircleContour(0.5 * bearing.outside), CircleContour(reducer.design.pin_retaining_radius)
        ring = Segment(names.STOP_RING, outline, (bore,), -thickness / 2.0, thickness / 2.0)
        yield Part(names.STOP_RING, (ring,), reducer.design.material_of("housing").density)


def _rv_discs(reducer: RvReducer) -> Iterator[Part]:
    """Yield the discs of an RV reducer: valley 1 and crank bore 1 on +y, lobes of later discs turned by their phase."""
    design = reducer.design
    profile.require_no_undercut(reducer.gear_profile, reducer.profile_offset)
    holes = (
        *_middle_hole(reducer),
        *circles_at(reducer.bore_radius, crank_centres(reducer)),
        *circles_at(reducer.window_radius, post_centres(reducer)),
    )
    half_width = design.gear.face_width / 2.0
    for name, phase in zip(reducer.gears, reducer.phases, strict=True):
        outline = TurnedContour(GearContour(reducer.shape), -phase / design.lobes)
        yield Part(
            name, (Segment("gear", outline, holes, -half_width, half_width),), design.material_of("gear").density
        )


def _crank_and_gears(reducer: RvReducer) -> Iterator[Part]:
    """Yield a crank in the frame of its axis, and planet and sun in frames of their own, a tooth space on +y."""
    design, axial = reducer.design, axial_layout(reducer)
    require_below("gear.eccentricity", design.gear.eccentricity, reducer.cranks.eccentric_radius, "no journal is left")
    density, journal = design.material_of("shaft").density, CircleContour(reducer.journal_radius)
    half_width, start, segments = design.gear.face_width / 2.0, axial.planets[0], []
    for number, (phase, plane) in enumerate(zip(reducer.phases, design.gear.disc_planes, strict=True), start=1):
        x, y = design.gear.eccentricity * profile.unit(-phase)
        eccentric = CircleContour(reducer.cranks.eccentric_radius, (float(x), float(y)))
        segments.append(Segment(f"journal {number}", journal, (), start, plane - half_width))
        segments.append(Segment(f"eccentric {number}", eccentric, (), plane - half_width, plane + half_width))
        start = plane + half_width
    segments.append(Segment("last journal", journal, (), start, axial.flanges[1][1]))
    yield Part(CRANK, tuple(segments), density)
    sun, planet = reducer.stage_gears
    for name, gear in ((SUN, sun), (PLANET, planet)):
        if gear.fault:
            raise DesignError(
                f"planet.{name}_teeth = {gear.teeth} with a profile shift of {gear.shift:.3g}: these teeth are "
                f"{gear.fault}. Use more teeth or a larger planet.pressure_angle_deg. In both cases, also set "
                "cranks.radius_mm = 0, so that the centre distance of sun and planets follows from their teeth"
            )
    half_width = reducer.planet.face_width / 2.0
    yield Part(PLANET, (Segment(PLANET, SpurGearContour(planet), (journal,), -half_width, half_width),), density)
    yield Part(SUN, (Segment(SUN, SpurGearContour(sun), (), -half_width, half_width),), density)


def _carrier_flanges(reducer: RvReducer) -> Iterator[Part]:
    """Yield both flanges of the carrier, the second with the posts, which reach to the first.

    With main bearings, a flange has their seat next to the discs and a larger shoulder behind it.
    """
    cranks, axial = reducer.cranks, axial_layout(reducer)
    holes = (*_middle_hole(reducer), *circles_at(cranks.taper_radius, crank_centres(reducer)))
    density = reducer.design.material_of("output").density
    posts = [
        Segment("post", post, (), axial.flanges[0][1], axial.flanges[1][0])
        for post in circles_at(cranks.post_radius, post_centres(reducer))
    ]
    for name, ends, flange_posts in zip(FLANGES, axial.flanges, ((), posts), strict=True):
        yield Part(name, (*_flange_segments(reducer, holes, *ends), *flange_posts), density)


def _flange_segments(reducer: RvReducer, holes: tuple[CircleContour, ...], z0: float, z1: float) -> Iterator[Segment]:
    """Yield the segments of a flange from `z0` to `z1` [m] with some `holes`: seat and shoulder of a main bearing.

    Without main bearings, the flange is a single segment. The seat is next to the discs.
    """
    bearing, seat = reducer.main_bearing, CircleContour(reducer.flange_radius)
    if bearing is None:
        yield Segment("flange", seat, holes, z0, z1)
        return
    shoulder, (_, seat_end) = CircleContour(reducer.flange_outer_radius), main_bearing_ends(reducer, bearing)
    if z0 < 0.0:
        yield Segment("bearing seat", seat, holes, -seat_end, z1)
        yield Segment("shoulder", shoulder, holes, z0, -seat_end)
    else:
        yield Segment("bearing seat", seat, holes, z0, seat_end)
        yield Segment("shoulder", shoulder, holes, seat_end, z1)
