"""Dimensioned drawing of an RV reducer [mm]: front view of the last disc, and section through its axis."""

import math
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Rectangle

from cycloid_mj.base import names
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.geometry import profile
from cycloid_mj.parts import Prism
from cycloid_mj.parts.accuracy import VISUAL_CHORD_ERROR
from cycloid_mj.parts.cut import cut_prism
from cycloid_mj.parts.export.rv_assembly import place_rv_parts, rv_assembly_parts
from cycloid_mj.parts.polygon import rotate_points
from cycloid_mj.parts.rv import (
    CARRIER,
    CRANK,
    NEEDLE,
    PLANET,
    SUN,
    TAPERED_BEARING,
    axial_layout,
    crank_centres,
    post_centres,
)
from cycloid_mj.plots.dimension import AXIS, LINE_SPACING, TEXT, draw_dimension, draw_leader
from cycloid_mj.plots.mechanism import PART_STYLES, draw_disc, draw_region, draw_ring_pins
from cycloid_mj.reducer import RvReducer

PARTS = {
    names.HOUSING: ("ring", "////"),
    names.GEAR: ("gear", "\\\\\\\\"),
    names.PIN: ("pins", ""),
    CARRIER: ("output", "////"),
    CRANK: ("shaft", ""),
    PLANET: ("cam", "\\\\\\\\"),
    SUN: ("cam", "////"),
    NEEDLE: ("pins", ""),
    TAPERED_BEARING: ("pins", "xxxx"),
}
"""Family of parts -> style and hatching in the section."""

LABEL_ANGLES = math.radians(128.0), math.radians(50.0)
"""Angles of the labels of ring pins and cranks, from +x [rad]."""


def draw_rv_views(axes: Axes, reducer: RvReducer) -> None:
    """Draw the dimensioned front view and, to its right, the axial section of an RV reducer in mm, at crank angle 0.

    The front view has the reducer's axis at the origin, the section has it at y = 0. The plane of the section contains
    the axis and crank 1.
    """
    outer, mm, axial = MILLIMETRES * reducer.design.housing.outer_radius, MILLIMETRES, axial_layout(reducer)
    ends = (mm * min(axial.planets[0], axial.flanges[0][0]), mm * axial.flanges[1][1])
    shift = outer * (1.0 + 2.0 * LINE_SPACING) - ends[0]
    axes.set(
        xlim=(-outer * (1.0 + 2.0 * LINE_SPACING), ends[1] + shift + 4.2 * LINE_SPACING * outer),
        ylim=(-outer * (1.0 + 4.2 * LINE_SPACING), outer * (1.0 + 2.6 * LINE_SPACING)),
    )
    axes.set_aspect("equal")
    axes.axis("off")
    _draw_front_view(axes, reducer, outer)
    _draw_section(axes, reducer, shift, ends)
    _draw_dimensions(axes, reducer, shift, ends)


def _draw_front_view(axes: Axes, reducer: RvReducer, outer: float) -> None:
    """Draw ring, pins, last disc, posts, needles and crank eccentrics, seen from the output, with dimensions [mm].

    `outer` is the radius of the housing [mm].
    """
    design, ring, cranks, mm = reducer.design, reducer.design.ring, reducer.cranks, MILLIMETRES
    solids = {name: part.solid(VISUAL_CHORD_ERROR) for name, part in rv_assembly_parts(reducer).items()}
    offset = design.gear.eccentricity * profile.unit(np.array([-reducer.phases[-1]]))[0]
    draw_region(axes, solids[names.HOUSING].prisms[0], "ring", np.zeros(3))
    draw_ring_pins(axes, reducer)
    draw_region(axes, solids[reducer.gears[-1]].prisms[0], "gear", np.array([*offset, 0.0]))
    for centre in post_centres(reducer):
        draw_disc(axes, centre, cranks.post_radius, "output")
    pitch = cranks.eccentric_radius + cranks.needle_radius
    needles = pitch * profile.unit(2.0 * np.pi * np.arange(cranks.needles) / cranks.needles)
    for centre in crank_centres(reducer):
        draw_disc(axes, centre + offset, cranks.eccentric_radius, "cam")
        draw_disc(axes, centre, reducer.journal_radius, "shaft")
        for needle in needles:
            draw_disc(axes, centre + offset + needle, cranks.needle_radius, "pins")
    for radius in (ring.pin_circle_radius, reducer.crank_radius):
        axes.add_patch(Circle((0.0, 0.0), mm * radius, fill=False, **AXIS))
    half_size = outer * (1.0 + 0.4 * LINE_SPACING)
    axes.plot((-half_size, half_size), (0.0, 0.0), **AXIS)
    axes.plot((0.0, 0.0), (-half_size, half_size), **AXIS)
    title = "front view, without the near flange"
    axes.text(0.0, outer * (1.0 + 2.2 * LINE_SPACING), title, **{**TEXT, "fontsize": 7.0})
    teeth = f"{ring.teeth} pins Ø{2 * mm * ring.pin_radius:.4g}" if ring.kind == "pin" else f"{ring.teeth} lobes"
    eccentrics = f"{cranks.count} cranks, eccentrics Ø{2 * mm * cranks.eccentric_radius:.4g}"
    last_crank = crank_centres(reducer)[1]
    pin = ring.pin_circle_radius * np.array([math.cos(LABEL_ANGLES[0]), math.sin(LABEL_ANGLES[0])])
    for (x, y), radius, text, side in (
        (pin, ring.pin_circle_radius, teeth, -1.0),
        (last_crank, reducer.crank_radius, eccentrics, 1.0),
    ):
        place = (side * outer * (0.78 + LINE_SPACING), outer * (0.86 + LINE_SPACING))
        draw_leader(axes, (mm * float(x), mm * float(y)), place, f"{text}\non Ø{2 * mm * radius:.5g}")
    level = -outer * (1.0 + 1.6 * LINE_SPACING)
    draw_dimension(axes, (-outer, outer), level, (0.0, 0.0), f"Ø{2 * outer:.4g}", upright=False)


def _draw_section(axes: Axes, reducer: RvReducer, shift: float, ends: tuple[float, float]) -> None:
    """Draw the axial section with hatched parts and its centre line; `shift` and `ends` along the axis are in mm."""
    for family, prism in _placed_prisms(reducer):
        style, hatch = PARTS[family]
        patch_style = {**PART_STYLES[style], "linewidth": 0.6, "hatch": hatch}
        for low, high in cut_prism(prism):
            corner = (MILLIMETRES * prism.z0 + shift, MILLIMETRES * low)
            axes.add_patch(Rectangle(corner, MILLIMETRES * prism.height, MILLIMETRES * (high - low), **patch_style))
    overhang = 0.08 * (ends[1] - ends[0])
    axes.plot((ends[0] + shift - overhang, ends[1] + shift + overhang), (0.0, 0.0), **AXIS)
    outer = MILLIMETRES * reducer.design.housing.outer_radius
    middle = 0.5 * sum(ends) + shift
    axes.text(middle, outer * (1.0 + 2.2 * LINE_SPACING), "section", **{**TEXT, "fontsize": 7.0})


def _placed_prisms(reducer: RvReducer) -> Iterator[tuple[str, Prism]]:
    """Yield the prisms of all parts in the frame of the reducer, each with the family of its part."""
    parts = rv_assembly_parts(reducer)
    solids = {name: part.solid(VISUAL_CHORD_ERROR) for name, part in parts.items()}
    for place in place_rv_parts(reducer):
        x, y, z = place.origin
        for prism in solids[place.part].prisms:
            outline, *holes = (
                rotate_points(ring, place.angle) + np.array([x, y]) for ring in (prism.outline, *prism.holes)
            )
            yield _family(place.part), Prism(outline, tuple(holes), prism.z0 + z, prism.z1 + z)


def _family(part: str) -> str:
    """Return the key of a part in `PARTS`: its name without a number."""
    return part if part in PARTS else names.family(part)


def _draw_dimensions(axes: Axes, reducer: RvReducer, shift: float, ends: tuple[float, float]) -> None:
    """Draw the dimensions of the section [mm]: stack of discs, total length, diameters of carrier and housing.

    `ends` are the ends of the drive along its axis; in the drawing, they are moved by `shift`.
    """
    mm, half_width = MILLIMETRES, 0.5 * MILLIMETRES * reducer.design.gear.stack_width
    outer, flange = mm * reducer.design.housing.outer_radius, mm * reducer.flange_radius
    for (low, high), row, start in (((-half_width, half_width), 1, -outer), (ends, 2, -flange)):
        level, text = -outer * (1.0 + row * LINE_SPACING), f"{high - low:.4g}"
        draw_dimension(axes, (low + shift, high + shift), level, (start, start), text, upright=False)
    for radius, end, spacings in ((flange, ends[1], 1.3), (outer, half_width, 2.8)):
        level = ends[1] + shift + spacings * LINE_SPACING * outer
        starts = (end + shift, end + shift)
        draw_dimension(axes, (-radius, radius), level, starts, f"Ø{2 * radius:.4g}", upright=True)
