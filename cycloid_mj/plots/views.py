"""Dimensioned drawing of a reducer [mm]: front view from the output, and section through its axis."""

import math
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Rectangle

from cycloid_mj.base.array import Array
from cycloid_mj.base.names import GEAR, HOUSING, OUTPUT, PIN, SHAFT, family, gears
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts import Prism, body_solids, output_centres, parts
from cycloid_mj.parts.accuracy import VISUAL_CHORD_ERROR
from cycloid_mj.parts.cut import cut_prism
from cycloid_mj.parts.polygon import rotate_points
from cycloid_mj.plots.dimension import AXIS, LINE_SPACING, TEXT, draw_dimension, draw_leader
from cycloid_mj.plots.mechanism import PART_STYLES, draw_disc, draw_output_pins, draw_region, draw_ring_pins
from cycloid_mj.plots.rv_views import draw_rv_views
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.scene import ring_places

HATCHES = {HOUSING: "////", GEAR: "\\\\\\\\", OUTPUT: "////", PIN: "", SHAFT: ""}
PARTS = {HOUSING: "ring", GEAR: "gear", OUTPUT: "output", PIN: "pins", SHAFT: "shaft"}
"""Hatching of a part in the section, and its style."""

LABEL_ANGLE, RING_LABEL_ANGLE = math.radians(50.0), math.radians(128.0)
"""Angle about which the labelled output pin is, and angle of the label of the ring pins, from +x [rad]."""


def draw_views(axes: Axes, reducer: Reducer) -> None:
    """Draw the dimensioned front view and, to its right, the axial section of a reducer in mm, at crank angle 0.

    The front view has the reducer's axis at the origin, the section has it at y = 0. An RV reducer is drawn by
    `rv_views`.
    """
    if isinstance(reducer, RvReducer):
        draw_rv_views(axes, reducer)
        return
    outer, mm = MILLIMETRES * reducer.design.housing.outer_radius, MILLIMETRES
    z = [mm * end for solid in body_solids(reducer).values() for prism in solid.prisms for end in (prism.z0, prism.z1)]
    shift = outer * (1.0 + 4.0 * LINE_SPACING) - min(z)
    right_end = max(z) + shift + 4.2 * LINE_SPACING * outer
    axes.set(
        xlim=(-outer * (1.0 + 2.0 * LINE_SPACING), right_end),
        ylim=(-outer * (1.0 + 4.2 * LINE_SPACING), outer * (1.0 + 2.6 * LINE_SPACING)),
    )
    axes.set_aspect("equal")
    axes.axis("off")
    _draw_front_view(axes, reducer, outer)
    _draw_section(axes, reducer, shift)
    _draw_lengths(axes, reducer, shift, outer)
    _draw_diameters(axes, reducer, shift, outer, (min(z), max(z)))


def _draw_front_view(axes: Axes, reducer: Reducer, outer: float) -> None:
    """Draw ring, pins, last disc, output pins and cam, seen from the output, with their dimensions [mm].

    `outer` is the housing's radius [mm]. Labels state number and diameter of the ring pins, or the number of lobes, and
    the same for the output pins.
    """
    design = reducer.design
    solids, ring, output, mm = parts(reducer, VISUAL_CHORD_ERROR), design.ring, design.output, MILLIMETRES
    origin, name = np.zeros(3), gears(design.gear.discs)[-1]
    centre = _disc_centres(reducer)[-1]
    draw_region(axes, solids[HOUSING].prisms[0], "ring", origin)
    draw_ring_pins(axes, reducer)
    draw_region(axes, solids[name].prisms[0], "gear", np.array([*centre, 0.0]))
    draw_output_pins(axes, reducer, output_centres(reducer))
    draw_disc(axes, centre, design.gear.bore_radius, "cam")
    draw_disc(axes, origin[:2], design.shaft.radius, "shaft")
    for radius in (ring.pin_circle_radius, output.pin_circle_radius):
        axes.add_patch(Circle((0.0, 0.0), mm * radius, fill=False, **AXIS))
    half_size = outer * (1.0 + 0.4 * LINE_SPACING)
    axes.plot((-half_size, half_size), (0.0, 0.0), **AXIS)
    axes.plot((0.0, 0.0), (-half_size, half_size), **AXIS)
    axes.text(0.0, outer * (1.0 + 2.2 * LINE_SPACING), "front view, from the output", **{**TEXT, "fontsize": 7.0})
    teeth = f"{ring.teeth} pins Ø{2 * mm * ring.pin_radius:.4g}" if ring.kind == "pin" else f"{ring.teeth} lobes"
    for angle, radius, text, side in (
        (RING_LABEL_ANGLE, ring.pin_circle_radius, f"{teeth}\non Ø{2 * mm * ring.pin_circle_radius:.5g}", -1.0),
        (_pin_angle(reducer), output.pin_circle_radius, _pins_label(reducer), 1.0),
    ):
        point = (mm * radius * math.cos(angle), mm * radius * math.sin(angle))
        draw_leader(axes, point, (side * outer * (0.78 + LINE_SPACING), outer * (0.86 + 1.0 * LINE_SPACING)), text)
    draw_dimension(
        axes, (-outer, outer), -outer * (1.0 + 1.6 * LINE_SPACING), (0.0, 0.0), f"Ø{2 * outer:.4g}", upright=False
    )


def _pin_angle(reducer: Reducer) -> float:
    """Return the angle of the output pin with the label: nearest to `LABEL_ANGLE`, counter-clockwise from +x [rad]."""
    angles = math.pi / 2 - 2.0 * math.pi * np.arange(reducer.design.output.pins) / reducer.design.output.pins
    return float(min(angles, key=lambda angle: abs(angle - LABEL_ANGLE)))


def _pins_label(reducer: Reducer) -> str:
    output, mm = reducer.design.output, MILLIMETRES
    core = f"Ø{2 * mm * output.core_radius:.4g}, rollers " if output.has_roller_parts else ""
    round_ = f"{core}Ø{2 * mm * output.pin_radius:.4g}"
    return f"{output.pins} output pins {round_}\non Ø{2 * mm * output.pin_circle_radius:.4g}"


def _disc_centres(reducer: Reducer) -> list[Array]:
    """Return the centre of each disc at crank angle 0 [m], shape (2,) each."""
    up = np.array([[0.0, reducer.design.gear.eccentricity]])
    return [rotate_points(up, phase)[0] for phase in reducer.phases]


def _draw_section(axes: Axes, reducer: Reducer, shift: float) -> None:
    """Draw the axial section of a reducer with hatched parts and its centre line, in mm.

    The plane of the section contains the axis and the direction of the eccentricity. `shift` moves the section along x
    [mm].
    """
    for name, prism, centre, plane in _placed_prisms(reducer):
        part = family(name)
        patch_style = {**PART_STYLES[PARTS[part]], "linewidth": 0.6, "hatch": HATCHES[part]}
        for low, high in cut_prism(prism, (float(centre[0]), float(centre[1]))):
            corner = (MILLIMETRES * (prism.z0 + plane) + shift, MILLIMETRES * low)
            axes.add_patch(Rectangle(corner, MILLIMETRES * prism.height, MILLIMETRES * (high - low), **patch_style))
    ends = [MILLIMETRES * end + shift for _, prism, _, plane in _placed_prisms(reducer) for end in (prism.z0, prism.z1)]
    overhang = 0.08 * (max(ends) - min(ends))
    axes.plot((min(ends) - overhang, max(ends) + overhang), (0.0, 0.0), **AXIS)
    outer = MILLIMETRES * reducer.design.housing.outer_radius
    axes.text(0.5 * (min(ends) + max(ends)), outer * (1.0 + 2.2 * LINE_SPACING), "section", **{**TEXT, "fontsize": 7.0})


def _placed_prisms(reducer: Reducer) -> Iterator[tuple[str, Prism, Array, float]]:
    """Yield the prisms of all parts of a drive, each with the position of its part.

    Yields
    ------
    tuple
        Name of the part; the prism; and position of the part's frame: (x, y) [m], shape (2,), and z [m].
    """
    design = reducer.design
    discs = dict(
        zip(gears(design.gear.discs), zip(_disc_centres(reducer), design.gear.disc_planes, strict=True), strict=True)
    )
    for name, solid in body_solids(reducer).items():
        origins = [discs.get(name, (np.zeros(2), 0.0))]
        if name == PIN:
            origins = [(pin, 0.0) for pin in ring_places(reducer)]
        for centre, plane in origins:
            yield from ((name, prism, centre, plane) for prism in solid.prisms)


def _draw_lengths(axes: Axes, reducer: Reducer, shift: float, outer: float) -> None:
    """Draw three axial dimensions [mm] below the section: stack of discs, output disc, and total length at the bottom.

    `shift` is the displacement of the section along x, and `outer` the housing's radius [mm].
    """
    mm, half_width = MILLIMETRES, 0.5 * MILLIMETRES * reducer.design.gear.stack_width
    solids = body_solids(reducer)
    output_disc = solids[OUTPUT].prisms[0]
    ends = [mm * end for solid in solids.values() for prism in solid.prisms for end in (prism.z0, prism.z1)]
    rows = (
        ((-half_width, half_width), 1, -outer),
        ((mm * output_disc.z0, mm * output_disc.z1), 2, -mm * _outer_radius(output_disc)),
        ((min(ends), max(ends)), 3, 0.0),
    )
    for (low, high), row, start in rows:
        level, text = -outer * (1.0 + row * LINE_SPACING), f"{high - low:.4g}"
        starts = (start, start) if row < 3 else (-mm * reducer.design.shaft.radius, -mm * _outer_radius(output_disc))
        draw_dimension(axes, (low + shift, high + shift), level, starts, text, upright=False)


def _draw_diameters(axes: Axes, reducer: Reducer, shift: float, outer: float, ends: tuple[float, float]) -> None:
    """Draw the diameters beside the section: input journal on the left, output disc and housing on the right.

    `shift` is the displacement of the section along x, `outer` the housing's radius, and `ends` are the coordinates of
    both ends of the drive along its axis, without `shift`; all in mm.
    """
    mm, half_width = MILLIMETRES, 0.5 * MILLIMETRES * reducer.design.gear.stack_width
    shaft, disc = mm * reducer.design.shaft.radius, body_solids(reducer)[OUTPUT].prisms[0]
    left_end = ends[0] + shift
    draw_dimension(
        axes, (-shaft, shaft), left_end - LINE_SPACING * outer, (left_end, left_end), f"Ø{2 * shaft:.4g}", upright=True
    )
    right_end = ends[1] + shift
    disc_radius = mm * _outer_radius(disc)
    for radius, start, row in ((disc_radius, mm * disc.z1 + shift, 1.3), (outer, half_width + shift, 2.8)):
        level = right_end + row * LINE_SPACING * outer
        draw_dimension(axes, (-radius, radius), level, (start, start), f"Ø{2 * radius:.4g}", upright=True)


def _outer_radius(prism: Prism) -> float:
    """Return the largest radius of a prism [m]."""
    return float(np.linalg.norm(prism.outline, axis=1).max())
