"""Elements of a dimensioned drawing that every layout shares: axes, front view, hatched section, outer diameters."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Rectangle

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts import Prism
from cycloid_mj.parts.cut import cut_prism
from cycloid_mj.parts.polygon import rotate_points
from cycloid_mj.plots.dimension import AXIS, LINE_SPACING, TEXT, draw_dimension, draw_leader
from cycloid_mj.plots.mechanism import PART_STYLES
from cycloid_mj.reducer import Reducer

RING_LABEL_ANGLE = math.radians(128.0)
"""Angle of the label of the ring pins, from +x [rad]."""


@dataclass(frozen=True)
class ViewFrame:
    """Frame of the drawing of a reducer [mm]: front view about the origin, and section about y = 0 to its right."""

    axes: Axes
    reducer: Reducer
    ends: tuple[float, float]
    """Ends of the reducer in the section, along x [mm]."""
    shift: float
    """Displacement of the section along x [mm]: the middle of the stack of discs is there."""

    @property
    def outer(self) -> float:
        """Outer radius of the housing [mm]."""
        return MILLIMETRES * self.reducer.design.housing.outer_radius

    @property
    def half_width(self) -> float:
        """Half the width of the stack of discs [mm]."""
        return 0.5 * MILLIMETRES * self.reducer.design.gear.stack_width

    def level(self, rows: float) -> float:
        """Return y of the dimension line that is `rows` spacings below the housing [mm]."""
        return -self.outer * (1.0 + rows * LINE_SPACING)

    def label_front_view(self, title: str, pitch_radius: float, point: Array, text: str) -> None:
        """Draw title, pitch circles, centre lines, outer diameter and both labels of the front view.

        One label has number and size of the ring pins or lobes. The other has `text`; it points at `point`, shape (2,)
        [m], on the circle of `pitch_radius` [m].
        """
        axes, ring, outer_radius = self.axes, self.reducer.design.ring, self.outer
        for radius in (ring.pin_circle_radius, pitch_radius):
            axes.add_patch(Circle((0.0, 0.0), MILLIMETRES * radius, fill=False, **AXIS))
        half_size = outer_radius * (1.0 + 0.4 * LINE_SPACING)
        axes.plot((-half_size, half_size), (0.0, 0.0), **AXIS)
        axes.plot((0.0, 0.0), (-half_size, half_size), **AXIS)
        self._write_title(0.0, title)
        size_text = f"pins Ø{2 * MILLIMETRES * ring.pin_radius:.4g}" if ring.kind == "pin" else "lobes"
        ring_text = f"{ring.teeth} {size_text}\non Ø{2 * MILLIMETRES * ring.pin_circle_radius:.5g}"
        ring_point = ring.pin_circle_radius * np.array([math.cos(RING_LABEL_ANGLE), math.sin(RING_LABEL_ANGLE)])
        for label_point, label, side in ((ring_point, ring_text, -1.0), (point, text, 1.0)):
            text_position = (side * outer_radius * (0.78 + LINE_SPACING), outer_radius * (0.86 + LINE_SPACING))
            draw_leader(
                axes, (MILLIMETRES * float(label_point[0]), MILLIMETRES * float(label_point[1])), text_position, label
            )
        draw_dimension(
            axes, (-outer_radius, outer_radius), self.level(1.6), (0.0, 0.0), f"Ø{2 * outer_radius:.4g}", upright=False
        )

    def draw_section(self, parts: Iterable[tuple[tuple[str, str], Prism]]) -> None:
        """Draw the axial section of prisms in the frame of the reducer, with centre line and title.

        `parts` has for each prism a pair, the key of a style in `PART_STYLES` and a hatching of Matplotlib, and the
        prism.
        """
        for (style_key, hatch), prism in parts:
            patch_style = {**PART_STYLES[style_key], "linewidth": 0.6, "hatch": hatch}
            for low, high in cut_prism(prism):
                corner = (MILLIMETRES * prism.z0 + self.shift, MILLIMETRES * low)
                height = MILLIMETRES * (high - low)
                self.axes.add_patch(Rectangle(corner, MILLIMETRES * prism.height, height, **patch_style))
        left_end, right_end = self.ends
        overhang = 0.08 * (right_end - left_end)
        self.axes.plot((left_end - overhang, right_end + overhang), (0.0, 0.0), **AXIS)
        self._write_title(0.5 * (left_end + right_end), "section")

    def draw_length(self, ends: tuple[float, float], row: int, starts: tuple[float, float]) -> None:
        """Draw the dimension of an axial length in a row below the section.

        `ends` are the ends of the length on the z axis of the reducer [mm], and `row` counts from the housing
        downwards. The extension lines begin at the y coordinates `starts` [mm].
        """
        low, high = ends
        shifted_ends = (low + self.shift, high + self.shift)
        draw_dimension(self.axes, shifted_ends, self.level(row), starts, f"{high - low:.4g}", upright=False)

    def draw_outer_diameters(self, radius: float, end: float) -> None:
        """Draw the diameters to the right of the section: the output disc or flange, and the housing.

        `radius` is that of the output disc or flange [mm], and `end` the position of its outer face on the z axis of
        the reducer [mm].
        """
        for drawn_radius, face, spacings in ((radius, end, 1.3), (self.outer, self.half_width, 2.8)):
            level, x = self.ends[1] + spacings * LINE_SPACING * self.outer, face + self.shift
            draw_dimension(
                self.axes, (-drawn_radius, drawn_radius), level, (x, x), f"Ø{2 * drawn_radius:.4g}", upright=True
            )

    def _write_title(self, x: float, title: str) -> None:
        """Write the title of a view above its middle `x` [mm]."""
        self.axes.text(x, self.outer * (1.0 + 2.2 * LINE_SPACING), title, **{**TEXT, "fontsize": 7.0})


def frame_views(axes: Axes, reducer: Reducer, ends: tuple[float, float], gap: float) -> ViewFrame:
    """Set limits and equal scales of `axes` for the front view of a reducer and, to its right, the section.

    Parameters
    ----------
    axes
        Axes of the drawing, whose frame and ticks are hidden.
    ends
        Lower and upper end of the reducer along z [m].
    gap
        Distance between the housing in the front view and the section, in spacings of dimension lines: multiples of
        `LINE_SPACING` times the outer radius.

    Returns
    -------
    ViewFrame
        Frame of both views [mm], with methods to draw them.
    """
    lower_end, upper_end = (MILLIMETRES * end for end in ends)
    outer_radius = MILLIMETRES * reducer.design.housing.outer_radius
    shift = outer_radius * (1.0 + gap * LINE_SPACING) - lower_end
    frame = ViewFrame(axes, reducer, (lower_end + shift, upper_end + shift), shift)
    axes.set(
        xlim=(-outer_radius * (1.0 + 2.0 * LINE_SPACING), frame.ends[1] + 4.2 * LINE_SPACING * outer_radius),
        ylim=(frame.level(4.2), outer_radius * (1.0 + 2.6 * LINE_SPACING)),
    )
    axes.set_aspect("equal")
    axes.axis("off")
    return frame


def place_prism(prism: Prism, origin: tuple[float, float, float], angle: float = 0.0) -> Prism:
    """Return a prism of a part in the frame of the reducer: rotated by `angle` [rad], then moved to `origin` [m]."""
    x, y, z = origin
    outline, *holes = (rotate_points(ring, angle) + np.array([x, y]) for ring in (prism.outline, *prism.holes))
    return Prism(outline, tuple(holes), prism.z0 + z, prism.z1 + z)
