"""Ring pin 1 in its socket (the paper's Fig. 9)."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from cycloid_mj.analysis import PinPath, Series
from cycloid_mj.plots.motion import turn_degrees
from cycloid_mj.plots.style import (
    BLACK,
    BLUE,
    GREY,
    MICROMETRE,
    SIMULATED,
    crank_axis,
    legend_above,
    sheet,
    square,
    styled,
)
from cycloid_mj.types import Array

CLEARANCE: dict[str, Any] = {"color": GREY, "linewidth": 1.0, "linestyle": "--"}
OVER_ANGLE: dict[str, Any] = {"color": BLUE, "linewidth": 0.9}


@styled
def pin_figure(motion: Series, pin: PinPath) -> Figure:
    """Draw the path of pin 1's centre within its clearance circle, its distance and its spin over a crank turn."""
    figure = sheet(3.2)
    axes = figure.subplot_mosaic("pr;ps", width_ratios=[1, 1.15])
    path, radial, spin = axes["p"], axes["r"], axes["s"]
    rows, clearance = motion.one_turn, 1e6 * pin.clearance
    place = "sleeve 1 on its pin" if motion.design.ring.has_sleeves else "pin 1 in its socket"
    _path(path, 1e6 * pin.position[rows], clearance, place)
    degrees = turn_degrees(motion)
    _radial(radial, degrees, 1e6 * pin.radial[rows], clearance)
    _spin(spin, degrees, pin.spin[rows])
    radial.tick_params(labelbottom=False)
    radial.set_xlabel("")
    figure.align_ylabels([radial, spin])
    return figure


def _path(axes: Axes, position: Array, clearance: float, place: str) -> None:
    axes.add_patch(Circle((0.0, 0.0), clearance, fill=False, **CLEARANCE))
    axes.plot(*position.T, **SIMULATED)
    axes.plot(*position[0], marker="o", markersize=4, color=BLUE)
    axes.plot(0.0, 0.0, marker="+", markersize=7, color=BLACK, markeredgewidth=0.7)
    square(axes, 1.12 * max(clearance, float(np.abs(position).max())))
    axes.set_title(f"Centre of {place} (dot: start)")


def _radial(axes: Axes, degrees: Array, radial: Array, clearance: float) -> None:
    axes.plot(degrees, radial, **OVER_ANGLE)
    axes.axhline(clearance, **CLEARANCE)
    axes.set_ylim(0.0, 1.15 * max(clearance, float(radial.max())))
    axes.set_title("Distance from the centre")
    axes.set_ylabel(f"distance [{MICROMETRE}]")
    legend_above(axes, ("clearance", CLEARANCE))
    crank_axis(axes, degrees)


def _spin(axes: Axes, degrees: Array, spin: Array) -> None:
    axes.plot(degrees, spin, **OVER_ANGLE)
    axes.axhline(0.0, color=BLACK, linewidth=0.5)
    axes.margins(y=0.1)
    axes.set_title("Spin")
    axes.set_ylabel("spin [rad/s]")
    crank_axis(axes, degrees)
