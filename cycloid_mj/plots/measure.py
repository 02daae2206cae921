"""The figure of a measurement: a panel for each title that its curves name."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cycloid_mj.measure import Curve, Measurement
from cycloid_mj.plots.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, THEORY, VERMILION, sheet, styled, typeset

COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, GREY)
HEIGHT, POLAR_HEIGHT = 1.9, 3.2
"""Of one panel [in]."""
FINEST = 0.01
"""Least half height of a panel of points, as a share of its values: less would make a difference of nothing."""


@styled
def measurement_figure(found: Measurement) -> Figure:
    """Draw every curve of a measurement, panel below panel."""
    panels: dict[str, list[Curve]] = {}
    for curve in found.curves:
        panels.setdefault(curve.panel, []).append(curve)
    heights = [POLAR_HEIGHT if curves[0].style == "polar" else HEIGHT for curves in panels.values()]
    figure = sheet(sum(heights) + 0.4)
    grid = figure.add_gridspec(len(panels), 1, height_ratios=heights)
    for place, (title, curves) in enumerate(panels.items()):
        polar = curves[0].style == "polar"
        axes = figure.add_subplot(grid[place], projection="polar" if polar else None)
        axes.set_title(title)
        _draw(axes, curves)
    figure.suptitle(f"{found.measure}: {found.design.name}", fontsize=9.5)
    return figure


def _draw(axes: Axes, curves: list[Curve]) -> None:
    colours = iter(COLOURS * (1 + len(curves) // len(COLOURS)))
    for curve in curves:
        if curve.style == "theory":
            axes.plot(curve.x, curve.y, label=curve.name, **THEORY)
        elif curve.style == "bars":
            axes.vlines(curve.x, 0.0, curve.y, label=curve.name, color=next(colours), linewidth=1.4)
        elif curve.style == "points":
            # points on the edge of the panel are drawn whole
            axes.plot(curve.x, curve.y, "o", markersize=3.0, label=curve.name, color=next(colours), clip_on=False)
        elif curve.style == "polar":
            axes.plot(np.radians(curve.x), curve.y, label=curve.name, color=next(colours), linewidth=0.9)
        else:
            axes.plot(curve.x, curve.y, label=curve.name, color=next(colours), linewidth=0.9)
    if curves[0].style == "bars":
        axes.set_xlim(left=0.0)
    if any(curve.style == "points" for curve in curves):
        low, high = axes.get_ylim()
        middle, reach = 0.5 * (low + high), max(0.5 * (high - low), FINEST * 0.5 * abs(low + high))
        axes.set_ylim(middle - reach, middle + reach)
    if curves[0].style != "polar":
        axes.set(xlabel=curves[0].x_label, ylabel=curves[0].y_label)
    else:
        axes.set_title(f"{curves[0].panel}: {curves[0].y_label}")
        polar: Any = axes
        polar.set_theta_zero_location("N")
        polar.set_theta_direction(-1)
        # the radii stand opposite to the largest value, where there is room
        polar.set_rlabel_position(float(curves[0].x[np.argmax(curves[0].y)]) + 180.0)
    axes.yaxis.set_major_formatter(lambda value, _: typeset(f"{value:g}"))
    if any(curve.name for curve in curves):
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0)
