"""Ring pin 1 in its socket (the paper's Fig. 9)."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from cycloid_mj.analysis import MICROMETRE, SIGNALS, PinPath, Series
from cycloid_mj.plots.style import (
    BLACK,
    BLUE,
    GREY,
    SIMULATED,
    crank_axis,
    legend_above,
    sheet,
    square,
    styled,
    turn_degrees,
)
from cycloid_mj.types import Array

CLEARANCE: dict[str, Any] = {"color": GREY, "linewidth": 1.0, "linestyle": "--"}


@styled
def pin_figure(motion: Series, pin: PinPath) -> Figure:
    """Draw the path of pin 1's centre within its clearance circle, its distance and its spin over a crank turn."""
    figure = sheet(3.2)
    axes = figure.subplot_mosaic("pr;ps", width_ratios=[1, 1.15])
    distance, spin, clearance = axes["r"], axes["s"], 1e6 * pin.clearance
    degrees = turn_degrees(motion)
    place = "sleeve 1 on its pin" if motion.design.ring.has_sleeves else "pin 1 in its socket"
    position, radial, speed = (
        SIGNALS[key].simulated(motion)[motion.one_turn] for key in ("pin_path", "pin_radial", "pin_spin")
    )
    _path(axes["p"], position, clearance, place)
    for panel, values, title in ((distance, radial, "Distance from the centre"), (spin, speed, "Spin")):
        panel.plot(degrees, values, color=BLUE, linewidth=0.9)
        panel.set_title(title)
        crank_axis(panel, degrees)
    distance.axhline(clearance, **CLEARANCE)
    distance.set_ylim(0.0, 1.15 * max(clearance, float(radial.max())))
    distance.set_ylabel(f"distance [{MICROMETRE}]")
    legend_above(distance, ("clearance", CLEARANCE))
    distance.tick_params(labelbottom=False)
    distance.set_xlabel("")
    spin.axhline(0.0, color=BLACK, linewidth=0.5)
    spin.margins(y=0.1)
    spin.set_ylabel(SIGNALS["pin_spin"].label)
    figure.align_ylabels([distance, spin])
    return figure


def _path(axes: Axes, position: Array, clearance: float, place: str) -> None:
    axes.add_patch(Circle((0.0, 0.0), clearance, fill=False, **CLEARANCE))
    axes.plot(*position.T, **SIMULATED)
    axes.plot(*position[0], marker="o", markersize=4, color=BLUE)
    axes.plot(0.0, 0.0, marker="+", markersize=7, color=BLACK, markeredgewidth=0.7)
    square(axes, 1.12 * max(clearance, float(np.abs(position).max())))
    axes.set_title(f"Centre of {place} (dot: start)")
