"""Dimensioned drawing of a reducer [mm]: front view from the output, and section through its axis."""

import math
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes

from cycloid_mj.base.names import GEAR, HOUSING, OUTPUT, PIN, SHAFT, family
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts import Prism, body_solids, output_centres, parts
from cycloid_mj.parts.accuracy import VISUAL_CHORD_ERROR
from cycloid_mj.parts.export.placement import place_discs
from cycloid_mj.plots.dimension import LINE_SPACING, draw_dimension
from cycloid_mj.plots.mechanism import draw_disc, draw_output_pins, draw_region, draw_ring_pins
from cycloid_mj.plots.rv_views import draw_rv_views
from cycloid_mj.plots.view_frame import ViewFrame, frame_views, place_prism
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.scene import ring_places

PARTS = {
    HOUSING: ("ring", "////"),
    GEAR: ("gear", "\\\\\\\\"),
    OUTPUT: ("output", "////"),
    PIN: ("pins", ""),
    SHAFT: ("shaft", ""),
}
"""Family of parts -> style and hatching in the section."""

LABEL_ANGLE = math.radians(50.0)
"""Angle about which the labelled output pin is, from +x [rad]."""


def draw_views(axes: Axes, reducer: Reducer) -> None:
    """Draw the dimensioned front view and, to its right, the axial section of a reducer in mm, at crank angle 0.

    The front view has the reducer's axis at the origin, the section has it at y = 0. The plane of the section contains
    the axis and the direction of the eccentricity. An RV reducer is drawn by `rv_views`.
    """
    if isinstance(reducer, RvReducer):
        draw_rv_views(axes, reducer)
        return
    placed_prisms = list(_placed_prisms(reducer))
    end_heights = [end for _, prism in placed_prisms for end in (prism.z0, prism.z1)]
    frame = frame_views(axes, reducer, (min(end_heights), max(end_heights)), gap=4.0)
    _draw_front_view(frame, reducer)
    frame.draw_section((PARTS[family(name)], prism) for name, prism in placed_prisms)
    _draw_dimensions(frame, reducer)


def _draw_front_view(frame: ViewFrame, reducer: Reducer) -> None:
    """Draw ring, ring pins, the disc nearest the output, output pins, cam and shaft, with the labels of the front view.

    The view is from the output, at crank angle 0. `frame` has the axes and the scale of the views. A label states
    number, diameter and pitch circle of the ring pins; for an internal gear, it states the number of lobes and their
    circle. Another label states number, diameter and pitch circle of the output pins.
    """
    design, axes, origin = reducer.design, frame.axes, np.zeros(3)
    solids, output = parts(reducer, VISUAL_CHORD_ERROR), design.output
    *_, front_disc = place_discs(reducer, 0.0, 0.0)
    centre = np.array(front_disc.origin[:2])
    draw_region(axes, solids[HOUSING].prisms[0], "ring", origin)
    draw_ring_pins(axes, reducer)
    draw_region(axes, solids[front_disc.part].prisms[0], "gear", np.array([*centre, 0.0]))
    draw_output_pins(axes, reducer, output_centres(reducer))
    draw_disc(axes, centre, design.gear.bore_radius, "cam")
    draw_disc(axes, origin[:2], design.shaft.radius, "shaft")
    label_angle = _pin_angle(reducer)
    labelled_pin = output.pin_circle_radius * np.array([math.cos(label_angle), math.sin(label_angle)])
    frame.label_front_view("front view, from the output", output.pin_circle_radius, labelled_pin, _pins_label(reducer))


def _pin_angle(reducer: Reducer) -> float:
    """Return the angle of the output pin with the label: nearest to `LABEL_ANGLE`, counter-clockwise from +x [rad]."""
    angles = math.pi / 2 - 2.0 * math.pi * np.arange(reducer.design.output.pins) / reducer.design.output.pins
    return float(min(angles, key=lambda angle: abs(angle - LABEL_ANGLE)))


def _pins_label(reducer: Reducer) -> str:
    output, mm = reducer.design.output, MILLIMETRES
    core_text = f"Ø{2 * mm * output.core_radius:.4g}, rollers " if output.has_roller_parts else ""
    size_text = f"{core_text}Ø{2 * mm * output.pin_radius:.4g}"
    return f"{output.pins} output pins {size_text}\non Ø{2 * mm * output.pin_circle_radius:.4g}"


def _placed_prisms(reducer: Reducer) -> Iterator[tuple[str, Prism]]:
    """Yield the prisms of all parts in the frame of the reducer, each with the name of its part."""
    origins_of_discs = {placed_disc.part: placed_disc.origin for placed_disc in place_discs(reducer, 0.0, 0.0)}
    for name, solid in body_solids(reducer).items():
        origins = [origins_of_discs.get(name, (0.0, 0.0, 0.0))]
        if name == PIN:
            origins = [(x, y, 0.0) for x, y in ring_places(reducer).tolist()]
        for origin in origins:
            yield from ((name, place_prism(prism, origin)) for prism in solid.prisms)


def _draw_dimensions(frame: ViewFrame, reducer: Reducer) -> None:
    """Draw the dimensions of the axial section of a reducer.

    `frame` has the axes and the scale of the views. Below it are the lengths of the stack of discs, the output disc
    and, at the bottom, the whole reducer. The diameter of the input journal is on the left, those of output disc and
    housing are on the right.
    """
    mm, outer_radius, (left_end, right_end) = MILLIMETRES, frame.outer, frame.ends
    output_disc, shaft_radius = body_solids(reducer)[OUTPUT].prisms[0], MILLIMETRES * reducer.design.shaft.radius
    disc_radius = mm * float(np.linalg.norm(output_disc.outline, axis=1).max())
    frame.draw_length((-frame.half_width, frame.half_width), 1, (-outer_radius, -outer_radius))
    frame.draw_length((mm * output_disc.z0, mm * output_disc.z1), 2, (-disc_radius, -disc_radius))
    frame.draw_length((left_end - frame.shift, right_end - frame.shift), 3, (-shaft_radius, -disc_radius))
    level = left_end - LINE_SPACING * outer_radius
    draw_dimension(
        frame.axes, (-shaft_radius, shaft_radius), level, (left_end, left_end), f"Ø{2 * shaft_radius:.4g}", upright=True
    )
    frame.draw_outer_diameters(disc_radius, mm * output_disc.z1)
