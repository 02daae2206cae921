"""Dimension lines of a technical drawing [mm]: a line with arrows, extension lines and a number."""

from typing import Any

from matplotlib.axes import Axes

INK = "#26323D"
LINE: dict[str, Any] = {"color": INK, "linewidth": 0.45}
TEXT: dict[str, Any] = {"fontsize": 6.2, "color": "#26323D", "ha": "center", "va": "center"}
PAPER = {"facecolor": "white", "edgecolor": "none", "pad": 0.6}
ARROW: dict[str, Any] = {
    **{"arrowstyle": "<|-|>,head_length=0.28,head_width=0.09", "mutation_scale": 10.0, "shrinkA": 0.0, "shrinkB": 0.0},
    **{"edgecolor": INK, "facecolor": INK, "linewidth": 0.45},
}
OVERSHOOT = 0.012
"""Length of extension lines beyond a dimension line, relative to the height of the axes."""

AXIS: dict[str, Any] = {"color": "#7A8590", "linewidth": 0.45, "linestyle": (0, (9, 2.5, 1.5, 2.5))}
"""Style of centre lines and pitch circles."""

LINE_SPACING = 0.19
"""Distance between dimension lines, and from the part, relative to the outer radius of the housing."""


def draw_dimension(
    axes: Axes, ends: tuple[float, float], level: float, starts: tuple[float, float], text: str, upright: bool
) -> None:
    """Draw a dimension line with arrows, extension lines and text, along x or, if `upright`, along y.

    Parameters
    ----------
    axes
        Axes in mm, whose limits are already set.
    ends
        Coordinates of both ends of the distance [mm].
    level
        Coordinate of the dimension line, perpendicular to the distance [mm].
    starts
        Coordinates at which the two extension lines begin, perpendicular to the distance [mm]. They end at the
        dimension line.
    text
        Text of the dimension.
    upright
        Whether the distance is along y.
    """
    low, high = axes.get_ylim()
    overshoot = OVERSHOOT * abs(high - low)
    for end, start in zip(ends, starts, strict=True):
        end_of_line = level + (overshoot if level >= start else -overshoot)
        axes.plot(*_to_xy((end, end), (start, end_of_line), upright), **LINE)
    (x0, x1), (y0, y1) = _to_xy(ends, (level, level), upright)
    is_short = abs(ends[1] - ends[0]) < 6.0 * overshoot
    arrow = {**ARROW, "arrowstyle": "-"} if is_short else ARROW
    axes.annotate("", (x1, y1), (x0, y0), arrowprops=arrow)
    if is_short:
        _draw_ticks(axes, ends, level, overshoot, upright)
    midpoint = 0.5 * (ends[0] + ends[1])
    x, y = (level, midpoint) if upright else (midpoint, level)
    axes.text(x, y, text, rotation=90 if upright else 0, bbox=PAPER, zorder=9, **TEXT)


def draw_leader(axes: Axes, point: tuple[float, float], text_position: tuple[float, float], text: str) -> None:
    """Draw a leader line from a text at `text_position` to an arrow head at `point`, both (x, y) [mm]."""
    alignment = "left" if text_position[0] >= point[0] else "right"
    axes.annotate(
        text,
        point,
        text_position,
        arrowprops={**ARROW, "arrowstyle": "-|>,head_length=0.28,head_width=0.09"},
        bbox=PAPER,
        zorder=9,
        **{**TEXT, "ha": alignment},
    )


def _draw_ticks(axes: Axes, ends: tuple[float, float], level: float, size: float, upright: bool) -> None:
    """Mark the ends of a dimension that is too short for arrows by oblique ticks.

    `ends` are the coordinates of both ends, `level` is that of the dimension line, and `size` the extent of a tick, all
    in mm. The dimension is along x or, if `upright`, along y.
    """
    half_size = 0.5 * size
    for end in ends:
        axes.plot(
            *_to_xy((end - half_size, end + half_size), (level - half_size, level + half_size), upright),
            **{**LINE, "linewidth": 0.8},
        )


def _to_xy(
    along: tuple[float, float], across: tuple[float, float], upright: bool
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return two points by their coordinates along and across a dimension as x and y; swapped if it is upright."""
    return (across, along) if upright else (along, across)
