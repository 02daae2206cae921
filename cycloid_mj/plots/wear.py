"""Figure of a worn drive: lost motion over the hours with its interval, and the depth along each worn surface."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.life.accuracy_life import WearLife
from cycloid_mj.plots.style import BLACK, BLUE, GREY, VERMILION, create_figure, with_style

PANEL_HEIGHT = 2.0
"""Height of a panel [in]."""


@with_style
def wear_figure(result: WearLife) -> Figure:
    """Draw the lost motion against the operating hours, and below it the wear depth of each unevenly worn surface.

    `result` is that of the wear computation. The wear depth is drawn along the section of the surface, after the last
    hour of the typical case.
    """
    unevenly_worn = [wear for wear in result.surfaces if wear.surface.contact_coordinate is not None]
    figure = create_figure(PANEL_HEIGHT * (1 + len(unevenly_worn)) + 0.4)
    panels = figure.subplots(1 + len(unevenly_worn), 1, squeeze=False)[:, 0]
    panels[0].set_title(f"{result.design}: lost motion, {result.condition}", fontsize="small")
    _draw_lost_motion(panels[0], result)
    panels[0].set(xlabel="time [h]", ylabel="lost motion [arcmin]", xlim=(0.0, result.hours), ylim=(0.0, None))
    panels[0].legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0)
    last_hour = result.courses["typical"].hours[-1]
    for axes, wear in zip(panels[1:], unevenly_worn, strict=True):
        axes.plot(1e3 * wear.surface.coordinates, 1e6 * wear.depth, color=BLUE, linewidth=0.9)
        axes.set_title(f"{wear.surface.name}: depth of wear after {last_hour:.4g} h, typical")
        axes.set(xlabel="along the section [mm]", ylabel="depth [um]", ylim=(0.0, None))
    return figure


def _draw_lost_motion(axes: Axes, result: WearLife) -> None:
    """Draw the lost motion against the operating hours, with the limit, for each case of the wear coefficients.

    `result` is that of the wear computation. The cases are "low", "typical" and "high" coefficients: 5 % quantile,
    typical value and 95 % quantile.
    """
    courses = {
        case: (wear_course.hours, wear_course.lost_motion / ARCMINUTE) for case, wear_course in result.courses.items()
    }
    if {"low", "high"} <= courses.keys():
        hours, high_curve = courses["high"]
        axes.fill_between(hours, np.interp(hours, *courses["low"]), high_curve, color=BLUE, alpha=0.12, linewidth=0.0)
    case_styles = {"low": ("5 %", GREY, 0.9), "typical": ("typical", BLUE, 1.4), "high": ("95 %", BLACK, 0.9)}
    for case, (label, colour, line_width) in case_styles.items():
        if case in courses:
            axes.plot(*courses[case], label=label, color=colour, linewidth=line_width)
    axes.axhline(result.limit / ARCMINUTE, color=VERMILION, linewidth=0.9, linestyle="--", label="limit")
