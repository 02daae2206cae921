"""Drawings of the manufactured parts of an RV reducer: discs, ring, cranks, sun, planets and flanges of the carrier.

Fits of the crank bearings: the load is at rest on the outer rings of the tapered bearings and turns on their inner
rings, so H7 and k6 (SKF, Rolling bearings, 2018); raceways of needles without rings h5 and G6 (INA needle roller
bearings). The load on the output is at rest or swings with it, so main bearings have H6 outside and k5 on the flanges,
as the bearings of the output of a central crank. Splines and screws have no drawn geometry, as in ``parts.rv``.
"""

import math
from collections import Counter
from collections.abc import Iterator

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.units import MILLIMETRES, in_mm
from cycloid_mj.geometry.involute import InvoluteGear, span_measurement
from cycloid_mj.parts.accuracy import SAME_LENGTH
from cycloid_mj.parts.export.drawing import (
    ECCENTRICITY_TOLERANCE,
    PartDrawing,
    describe_lobes,
    describe_ring_teeth,
    describe_surface,
    first_angle,
    largest_deviation,
    lay_out_drawing,
    section_diameters,
    title_block,
)
from cycloid_mj.parts.export.rv_assembly import place_rv_parts
from cycloid_mj.parts.part import Part
from cycloid_mj.parts.rv import CRANK, FLANGES, NEEDLE, PLANET, SUN, crank_centres, post_centres, rv_parts
from cycloid_mj.reducer import RvReducer

INNER_RING, OUTER_RING, NEEDLE_SHAFT, NEEDLE_BORE = "k6", "H7", "h5", "G6"
"""Tolerance zones of the seats of tapered bearings on crank and in flange, and of the raceways of needles."""

MAIN_SEAT, MAIN_BORE = "k5", "H6"
"""Tolerance zones of the seats of main bearings on the flanges and in the housing (as ``ANGULAR_HUB_FIT``)."""

POSITION, LOOSE_POSITION, RUN_OUT = 0.01, 0.2, 0.01
"""Position of crank bores, and of posts and their windows; run-out of seats and teeth [mm] (assumed)."""

MATERIAL_OF = {
    **dict.fromkeys((CRANK, PLANET, SUN), names.SHAFT),
    **dict.fromkeys(FLANGES, names.OUTPUT),
    names.STOP_RING: names.HOUSING,
}
"""Part of the mechanism that sets the material of a part; a part that is not in it has its own."""


def rv_part_drawings(reducer: RvReducer) -> tuple[PartDrawing, ...]:
    """Return the drawings of all manufactured parts of an RV reducer; pins and needles are bought.

    Raises
    ------
    DesignError
        A part cannot be manufactured.
    """
    counts = Counter(placement.part for placement in place_rv_parts(reducer))
    manufactured_parts = (part for part in rv_parts(reducer).values() if part.name not in (NEEDLE, names.PIN))
    return tuple(_draw_part(reducer, part, counts[part.name]) for part in manufactured_parts)


def _draw_part(reducer: RvReducer, part: Part, count: int) -> PartDrawing:
    """Return the drawing of a part of which a drive has `count` copies."""
    material = reducer.design.material_of(MATERIAL_OF.get(part.name, names.family(part.name)))
    diameters = section_diameters(
        part,
        names.ECCENTRIC,
        lambda radius, inner: (_zone(reducer, part.name, radius, inner), 2.0 * radius),
        _limit(reducer, "eccentricity", 2.0 * reducer.cranks.eccentric_radius, ECCENTRICITY_TOLERANCE),
    )
    datum = "datum B: the face at the lower end of the lengths"
    notes = (*_drawing_notes(reducer, part.name), datum, *describe_surface(part.name, material, material.is_plastic))
    return lay_out_drawing(part, part.name, title_block(reducer, part.name, count, material), diameters, notes)


def _zone(reducer: RvReducer, name: str, radius: float, inner: bool) -> str:
    """Return the tolerance zone of a surface about the axis of the part `name`, such as ``H7``; empty if it has none.

    The surface has a `radius` [m], and is a bore if `inner`.
    """
    bearing = reducer.main_bearing
    if bearing and name in FLANGES and not inner and abs(radius - 0.5 * bearing.bore) < SAME_LENGTH:
        return MAIN_SEAT
    if bearing and name == names.HOUSING and inner and abs(radius - 0.5 * bearing.outside) < SAME_LENGTH:
        return MAIN_BORE
    if name != CRANK or inner:
        return ""
    on_eccentric = abs(radius - reducer.cranks.eccentric_radius) < SAME_LENGTH
    return NEEDLE_SHAFT if on_eccentric else INNER_RING


def _drawing_notes(reducer: RvReducer, name: str) -> Iterator[str]:
    """Yield the notes on the drawing of the part `name` of an RV reducer: datums, teeth, holes and their tolerances."""
    design, cranks = reducer.design, reducer.cranks
    if name == names.HOUSING:
        yield describe_ring_teeth(design, "the axis (datum A)")
        if reducer.main_bearing:
            yield f"run-out of the seats and shoulders of the main bearings to A: {RUN_OUT}"
    elif names.family(name) == names.GEAR:
        yield describe_lobes(design, "A, the axis of the crank bores' circle")
        yield _describe_hole_pattern(
            crank_centres(reducer),
            reducer.bore_radius,
            NEEDLE_BORE,
            "raceways of the needles",
            _position(reducer, "bore_position", reducer.bore_radius),
        )
        yield _describe_hole_pattern(
            post_centres(reducer), reducer.window_radius, "", "windows for the posts", LOOSE_POSITION
        )
    elif name in FLANGES:
        yield _describe_hole_pattern(
            crank_centres(reducer),
            cranks.taper_radius,
            OUTER_RING,
            "seats of the tapered bearings",
            _position(reducer, "carrier_position", cranks.taper_radius),
        )
        if name == FLANGES[1]:
            yield _describe_hole_pattern(post_centres(reducer), cranks.post_radius, "", "posts", LOOSE_POSITION)
        yield f"bore both flanges together; datum A: axis of the circle of the seats; {_describe_undrawn(reducer)}"
        if reducer.main_bearing:
            yield f"run-out of the seat and shoulder of the main bearing to A: {RUN_OUT}"
    elif name == CRANK:
        angles = ", ".join(f"{math.degrees(phase) % 360.0:.4g}°" for phase in reducer.phases)
        yield f"datum A: common axis of both journals; eccentrics at {angles}, parallel to A within {RUN_OUT}"
        yield f"run-out of the journals to A: {RUN_OUT}; spline for the planet not drawn"
        yield f"fillets next to the journals R{in_mm(reducer.journal_fillet)}"
    elif name == names.STOP_RING:
        yield f"datum A: the axis; both faces parallel within {RUN_OUT}"
    else:
        sun, planet = reducer.stage_gears
        yield from _describe_teeth(sun if name == SUN else planet)
        yield f"radial run-out of the teeth to the bore: {RUN_OUT}" if name == PLANET else "shaft of the sun not drawn"


def _describe_undrawn(reducer: RvReducer) -> str:
    """Return a note on the parts that the drawing of a flange does not show."""
    return "screws not drawn" if reducer.main_bearing else "screws and main bearings not drawn"


def _describe_teeth(gear: InvoluteGear) -> Iterator[str]:
    """Yield two notes for the drawing of an involute gear: its basic dimensions, and its span over k teeth."""
    count, span = span_measurement(gear)
    tip, root = in_mm(2.0 * gear.tip_radius), in_mm(2.0 * gear.root_radius)
    yield (
        f"z = {gear.teeth}, m = {in_mm(gear.module)}, alpha = {math.degrees(gear.pressure_angle):.4g}°, x = "
        f"{gear.shift:.4f}, basic rack ISO 53 A, tip ⌀{tip}, root ⌀{root}"
    )
    yield f"span over {count} teeth W{count} = {MILLIMETRES * span:.4f}; flank tolerance class 6, ISO 1328-1 (assumed)"


def _limit(reducer: RvReducer, key: str, size: float, default: float) -> float:
    """Return the largest deviation [m] of a tolerance of the cranks at a diameter [m]; `default` without one."""
    return largest_deviation(getattr(reducer.crank_tolerance, key), key, size, default)


def _position(reducer: RvReducer, key: str, radius: float) -> float:
    """Return the diameter [mm] of the zone of the axes of seats with a `radius` [m]: that of the tolerance study."""
    return 2.0 * MILLIMETRES * _limit(reducer, key, 2.0 * radius, 0.5 * POSITION / MILLIMETRES)


def _describe_hole_pattern(centres: Array, radius: float, zone: str, purpose: str, position: float) -> str:
    """Return the note of equal holes or posts on a circle: number, diameter, zone, circle and first angle."""
    circle_diameter = 2.0 * float(np.hypot(*centres.T).mean())
    size = f"{len(centres)} x ⌀{in_mm(2.0 * radius)}{f' {zone}' if zone else ''} on ⌀{in_mm(circle_diameter)}"
    return f"{size}, the first at {first_angle(centres):.4g}°, position ⌀{position:.3g} to A ({purpose})"
