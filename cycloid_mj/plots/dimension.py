"""Dimension lines as on a technical drawing, in mm: a line with arrows, extension lines, and the number above it."""

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
BEYOND = 0.012
"""How far extension lines reach beyond a dimension line, over the height of the axes."""


def along(
    axes: Axes, ends: tuple[float, float], at: float, reach: tuple[float, float], text: str, upright: bool
) -> None:
    """Dimension a distance between two places along x, or along y where it is `upright`.

    Parameters
    ----------
    axes
        In mm, with their limits set.
    ends
        The two places.
    at
        Where the dimension line stands, across.
    reach
        Where the extension line of each end begins, across.
    text
        What stands on the line.
    upright
        Whether the distance is along y.
    """
    low, high = axes.get_ylim()
    beyond = BEYOND * abs(high - low)
    for end, begin in zip(ends, reach, strict=True):
        last = at + (beyond if at >= begin else -beyond)
        axes.plot(*_swapped((end, end), (begin, last), upright), **LINE)
    (x0, x1), (y0, y1) = _swapped(ends, (at, at), upright)
    short = abs(ends[1] - ends[0]) < 6.0 * beyond
    inwards = {**ARROW, "arrowstyle": "-"} if short else ARROW
    axes.annotate("", (x1, y1), (x0, y0), arrowprops=inwards)
    if short:
        _ticks(axes, ends, at, beyond, upright)
    middle = 0.5 * (ends[0] + ends[1])
    x, y = (at, middle) if upright else (middle, at)
    axes.text(x, y, text, rotation=90 if upright else 0, bbox=PAPER, zorder=9, **TEXT)


def leader(axes: Axes, point: tuple[float, float], text_at: tuple[float, float], text: str) -> None:
    """Name something by a line from a point [mm] to a text."""
    side = "left" if text_at[0] >= point[0] else "right"
    axes.annotate(
        text,
        point,
        text_at,
        arrowprops={**ARROW, "arrowstyle": "-|>,head_length=0.28,head_width=0.09"},
        bbox=PAPER,
        zorder=9,
        **{**TEXT, "ha": side},
    )


def _ticks(axes: Axes, ends: tuple[float, float], at: float, size: float, upright: bool) -> None:
    """Mark the ends of a dimension that is too short for arrows by slanting ticks."""
    half = 0.5 * size
    for end in ends:
        axes.plot(*_swapped((end - half, end + half), (at - half, at + half), upright), **{**LINE, "linewidth": 0.8})


def _swapped(
    along: tuple[float, float], across: tuple[float, float], upright: bool
) -> tuple[tuple[float, float], tuple[float, float]]:
    return (across, along) if upright else (along, across)
