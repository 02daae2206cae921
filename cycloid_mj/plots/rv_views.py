"""Dimensioned drawing of an RV reducer [mm]: front view of the last disc, and section through its axis."""

from collections.abc import Iterator, Mapping

import numpy as np
from matplotlib.axes import Axes

from cycloid_mj.base import names
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts import Prism, Solid
from cycloid_mj.parts.accuracy import VISUAL_CHORD_ERROR
from cycloid_mj.parts.export.rv_assembly import place_rv_parts, rv_assembly_parts
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
from cycloid_mj.plots.mechanism import draw_disc, draw_region, draw_ring_pins
from cycloid_mj.plots.view_frame import ViewFrame, frame_views, place_prism
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
    names.OUTPUT_BEARING: ("pins", "xxxx"),
    names.STOP_RING: ("ring", "////"),
}
"""Family of parts -> style and hatching in the section."""


def draw_rv_views(axes: Axes, reducer: RvReducer) -> None:
    """Draw the dimensioned front view and, to its right, the axial section of an RV reducer in mm, at crank angle 0.

    The front view has the reducer's axis at the origin, the section has it at y = 0. The plane of the section contains
    the axis and crank 1.
    """
    frame = frame_views(axes, reducer, axial_layout(reducer).ends, gap=2.0)
    solids = {name: part.solid(VISUAL_CHORD_ERROR) for name, part in rv_assembly_parts(reducer).items()}
    _draw_front_view(frame, reducer, solids)
    frame.draw_section((PARTS[_family(name)], prism) for name, prism in _placed_prisms(reducer, solids))
    _draw_dimensions(frame, reducer)


def _draw_front_view(frame: ViewFrame, reducer: RvReducer, solids: Mapping[str, Solid]) -> None:
    """Draw ring, pins, last disc, posts, needles and crank eccentrics, seen from the output, with dimensions.

    `frame` has the axes and the scale of the views; `solids` are the solids of the parts by name.
    """
    cranks, axes, placed_parts = reducer.cranks, frame.axes, list(place_rv_parts(reducer))
    disc = next(placed_part for placed_part in placed_parts if placed_part.part == reducer.gears[-1])
    offset = np.array(disc.origin[:2])
    draw_region(axes, solids[names.HOUSING].prisms[0], "ring", np.zeros(3))
    draw_ring_pins(axes, reducer)
    draw_region(axes, solids[disc.part].prisms[0], "gear", np.array([*offset, 0.0]))
    for centre in post_centres(reducer):
        draw_disc(axes, centre, cranks.post_radius, "output")
    for centre in crank_centres(reducer):
        draw_disc(axes, centre + offset, cranks.eccentric_radius, "cam")
        draw_disc(axes, centre, reducer.journal_radius, "shaft")
    for placed_part in placed_parts:
        if placed_part.part == NEEDLE and placed_part.origin[2] == disc.origin[2]:
            draw_disc(axes, np.array(placed_part.origin[:2]), cranks.needle_radius, "pins")
    crank_text = f"{cranks.count} cranks, eccentrics Ø{2 * MILLIMETRES * cranks.eccentric_radius:.4g}"
    label_text = f"{crank_text}\non Ø{2 * MILLIMETRES * reducer.crank_radius:.5g}"
    frame.label_front_view(
        "front view, without the near flange", reducer.crank_radius, crank_centres(reducer)[1], label_text
    )


def _placed_prisms(reducer: RvReducer, solids: Mapping[str, Solid]) -> Iterator[tuple[str, Prism]]:
    """Yield the prisms of all parts in the frame of the reducer, each with the name of its part."""
    for placed_part in place_rv_parts(reducer):
        for prism in solids[placed_part.part].prisms:
            yield placed_part.part, place_prism(prism, placed_part.origin, placed_part.angle)


def _family(part: str) -> str:
    """Return the key of a part in `PARTS`: its name without a number."""
    return part if part in PARTS else names.family(part)


def _draw_dimensions(frame: ViewFrame, reducer: RvReducer) -> None:
    """Draw the dimensions of the section: stack of discs, total length, diameters of carrier and housing."""
    lower_end, upper_end = (end - frame.shift for end in frame.ends)
    flange = MILLIMETRES * reducer.flange_outer_radius
    frame.draw_length((-frame.half_width, frame.half_width), 1, (-frame.outer, -frame.outer))
    frame.draw_length((lower_end, upper_end), 2, (-flange, -flange))
    frame.draw_outer_diameters(flange, upper_end)
