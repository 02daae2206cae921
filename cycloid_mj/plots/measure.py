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
            axes.plot(curve.x, curve.y, "o", markersize=3.0, label=curve.name, color=next(colours))
        elif curve.style == "polar":
            axes.plot(np.radians(curve.x), curve.y, label=curve.name, color=next(colours), linewidth=0.9)
        else:
            axes.plot(curve.x, curve.y, label=curve.name, color=next(colours), linewidth=0.9)
    if curves[0].style == "bars":
        axes.set_xlim(left=0.0)
    if curves[0].style != "polar":
        axes.set(xlabel=curves[0].x_label, ylabel=curves[0].y_label)
    else:
        axes.set_title(f"{curves[0].panel}: {curves[0].y_label}")
        polar: Any = axes
        polar.set_theta_zero_location("N")
        polar.set_theta_direction(-1)
    axes.yaxis.set_major_formatter(lambda value, _: typeset(f"{value:g}"))
    if len(curves) > 1 or curves[0].name:
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0)
