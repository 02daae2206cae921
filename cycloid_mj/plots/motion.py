"""Crank speed, disc speed (Figs 5 and 6 of Hsieh 2014) and transmission error."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cycloid_mj.analysis import SIGNALS, Series
from cycloid_mj.base.array import Array
from cycloid_mj.plots import style

SPEED_SPAN = 0.01
"""Half the span of the axis of the disc speed, relative to the speed: shows the error at its true size."""

SPAN_MARGIN, MIN_SPAN = 1.2, 1e-9
"""Half the span over the largest deviation from the mean, at least; and its smallest value [rad/s]."""


@style.with_style
def input_figure(motion: Series) -> Figure:
    """Draw prescribed and simulated crank speed over the entire run, and their difference (Hsieh 2014, Fig. 5).

    `motion` are the time series of the run.
    """
    figure, speed_axes, error_axes = _draw_speed(motion, "crank_speed", slice(None), motion.time, height_ratios=[3, 2])
    speed_axes.axhline(0.0, color=style.BLACK, linewidth=0.5)
    speed_axes.margins(y=0.08)
    speed_axes.set_title("Crank speed")
    error_axes.set_xlabel("time [s]")
    figure.align_ylabels()
    return figure


@style.with_style
def gear_speed_figure(motion: Series) -> Figure:
    """Draw the disc speed over a crank turn, simulated and by Eq. 12 of Hsieh 2014, above its error (Fig. 6 there).

    `motion` are the time series of the run.
    """
    degrees = style.turn_degrees(motion)
    figure, speed_axes, error_axes = _draw_speed(motion, "gear_speed", motion.one_turn, degrees)
    speed = motion.gear_speed.select(motion.one_turn)
    mean_speed = float(np.mean(speed.theory))
    largest_deviation = max(float(np.abs(values - mean_speed).max()) for values in (speed.theory, speed.simulated))
    half_span = max(SPEED_SPAN * abs(mean_speed), SPAN_MARGIN * largest_deviation, MIN_SPAN)
    speed_axes.set_ylim(mean_speed - half_span, mean_speed + half_span)
    speed_axes.set_title("Speed of the cycloid disc")
    style.crank_axis(error_axes, degrees)
    figure.align_ylabels()
    return figure


def _draw_speed(motion: Series, key: str, rows: slice, x: Array, **layout: Any) -> tuple[Figure, Axes, Axes]:
    """Draw a simulated speed and its closed form, and their difference in a panel below.

    Parameters
    ----------
    key
        Name of the speed [rad/s] in `SIGNALS`; its error is the signal ``KEY_error`` there.
    rows, x
        The samples to draw, and their abscissa: time [s] or crank angle [deg], shape (n,).
    layout
        Further arguments of `Figure.subplots`.

    Returns
    -------
    tuple
        The figure, the axes of the speed, and the axes of the difference.
    """
    figure = style.create_figure(3.6)
    speed_axes, error_axes = figure.subplots(2, 1, sharex=True, **layout)
    speed, error = SIGNALS[key], SIGNALS[f"{key}_error"]
    if speed.theory:
        speed_axes.plot(x, speed.theory(motion)[rows], **style.THEORY)
    speed_axes.plot(x, speed.simulated(motion)[rows], **style.SIMULATED)
    difference = error.simulated(motion)[rows]
    error_axes.plot(x, difference, **style.ERROR)
    style.centre_on_zero(error_axes, difference)
    style.add_degree_axis(speed_axes)
    speed_axes.set_ylabel(speed.label)
    error_axes.set_ylabel(error.label)
    style.legend_above(speed_axes, *style.BOTH)
    return figure, speed_axes, error_axes


@style.with_style
def transmission_error_figure(motion: Series) -> Figure:
    """Draw the transmission errors of output and disc over a crank turn, with their means and peak-to-peak values.

    `motion` are the time series of the run.
    """
    figure, degrees = style.create_figure(3.6), style.turn_degrees(motion)
    curves = (("output", "output_te", style.BLUE), ("cycloid disc", "gear_te", style.ORANGE))
    for axes, (part, key, color) in zip(figure.subplots(2, 1, sharex=True), curves, strict=True):
        error = SIGNALS[key].simulated(motion)[motion.one_turn]
        axes.plot(degrees, error, color=color, linewidth=1.0)
        axes.axhline(float(error.mean()), color=color, linewidth=0.7, linestyle=(0, (4, 3)))
        axes.set_ylabel("angle [arcsec]")
        peak_to_peak_text, mean_text = (style.typeset(f"{value:.4g}") for value in (np.ptp(error), error.mean()))
        axes.set_title(
            f"Transmission error of the {part}: {peak_to_peak_text} arcsec peak to peak, mean {mean_text} arcsec"
        )
        axes.margins(y=0.12)
        style.crank_axis(axes, degrees)
        axes.label_outer()
    return figure
