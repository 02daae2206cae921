"""Crank, gear speed and transmission error (the paper's Figs 5 and 6)."""

import numpy as np
from matplotlib.figure import Figure

from cycloid_mj.analysis import Series
from cycloid_mj.plots.style import (
    BLACK,
    BLUE,
    BOTH,
    ERROR,
    ORANGE,
    SIMULATED,
    THEORY,
    centred,
    crank_axis,
    legend_above,
    sheet,
    styled,
    typeset,
)
from cycloid_mj.types import Array

ARCSEC = 3600 * 180 / np.pi
SPEED_SPAN = 0.01
"""Half of the span of the gear's speed as a share of it, so that the eye sees the error at its true size."""


def turn_degrees(motion: Series) -> Array:
    """Crank angle [deg] of one turn's samples, from the start of that turn, shape (n,)."""
    angle = np.degrees(motion.crank_angle[motion.one_turn])
    return angle - 360.0 * np.trunc(angle[0] / 360.0 + np.copysign(1e-6, angle[0]))


@styled
def input_figure(motion: Series) -> Figure:
    """Draw the crank's law and its measured speed over the whole run, and their difference (Fig. 5)."""
    figure = sheet(3.6)
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[3, 2])
    time, speed = motion.time, motion.crank_speed
    top.plot(time, speed.theory, **THEORY)
    top.plot(time, speed.simulated, **SIMULATED)
    top.axhline(0.0, color=BLACK, linewidth=0.5)
    top.margins(y=0.08)
    top.set_ylabel("crank speed [rad/s]")
    top.set_title("Speed of the crank")
    legend_above(top, *BOTH)
    bottom.plot(time, 1e3 * speed.error, **ERROR)
    centred(bottom, 1e3 * speed.error)
    bottom.set_ylabel("error [mrad/s]")
    bottom.set_xlabel("time [s]")
    figure.align_ylabels()
    return figure


@styled
def gear_speed_figure(motion: Series) -> Figure:
    """Draw the gear's speed over a crank turn with Eq. 12, and the error magnified (Fig. 6)."""
    figure = sheet(3.6)
    top, bottom = figure.subplots(2, 1, sharex=True)
    degrees, speed = turn_degrees(motion), motion.gear_speed.at(motion.one_turn)
    top.plot(degrees, speed.theory, **THEORY)
    top.plot(degrees, speed.simulated, **SIMULATED)
    middle = float(np.mean(speed.theory))
    swing = max(float(np.abs(part - middle).max()) for part in (speed.theory, speed.simulated))
    reach = max(SPEED_SPAN * abs(middle), 1.2 * swing, 1e-9)
    top.set_ylim(middle - reach, middle + reach)
    top.set_ylabel("gear speed [rad/s]")
    top.set_title("Speed of the cycloid gear")
    legend_above(top, *BOTH)
    bottom.plot(degrees, 1e3 * speed.error, **ERROR)
    centred(bottom, 1e3 * speed.error)
    bottom.set_ylabel("error [mrad/s]")
    crank_axis(bottom, degrees)
    figure.align_ylabels()
    return figure


@styled
def transmission_error_figure(motion: Series) -> Figure:
    """Draw the transmission error of output and gear over a crank turn."""
    figure = sheet(3.6)
    degrees, rows = turn_degrees(motion), motion.one_turn
    parts = (("output", motion.output_angle, BLUE), ("cycloid gear", motion.gear_angle, ORANGE))
    for axes, (part, angle, color) in zip(figure.subplots(2, 1, sharex=True), parts, strict=True):
        error = ARCSEC * angle.error[rows]
        axes.plot(degrees, error, color=color, linewidth=1.0)
        axes.axhline(float(error.mean()), color=color, linewidth=0.7, linestyle=(0, (4, 3)))
        axes.set_ylabel("angle [arcsec]")
        swing, mean = (typeset(f"{value:.4g}") for value in (np.ptp(error), error.mean()))
        axes.set_title(f"Transmission error of the {part}: {swing} arcsec p-p about {mean} (play and wind-up)")
        axes.margins(y=0.12)
        crank_axis(axes, degrees)
        axes.label_outer()
    return figure
