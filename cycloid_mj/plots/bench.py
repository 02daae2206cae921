"""Figures of bench measurements: measured and modelled loops with residuals, and transmission error by order."""

import numpy as np
from matplotlib.figure import Figure

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import ARCSECOND, DEGREE
from cycloid_mj.bench import BenchComparison, Calibration, MeasuredLoop
from cycloid_mj.bench.protocol import Protocol
from cycloid_mj.plots import style
from cycloid_mj.statics.windup import LOST_MOTION_SHARE

MEASURED = {"color": style.BLUE, "linestyle": "none", "marker": ".", "markersize": 2.5}
MODEL = {"color": style.VERMILION, "linewidth": 1.1}


@style.with_style
def calibration_figure(calibration: Calibration) -> Figure:
    """Draw deflection against torque for each measured loop and the fitted model, and the residual below each loop.

    `calibration` is the result of the fit.
    """
    fit, loops = calibration.fitted, calibration.fitted.loops
    figure = style.create_figure(4.4)
    grid = figure.subplots(2, len(loops), squeeze=False, sharex="col", height_ratios=(3.0, 1.0))
    for column, loop in enumerate(loops):
        loop_axes, residual_axes = grid[0, column], grid[1, column]
        loop_axes.plot(loop.torque, loop.deflection / DEGREE, **MEASURED)
        for torque, model_angles in fit.branches[column]:
            loop_axes.plot(torque, model_angles / DEGREE, **MODEL)
        loop_axes.set_title(loop.name)
        loop_axes.margins(x=0.02)
        residual_axes.plot(loop.torque, (loop.deflection - fit.turns[column]) / DEGREE, **MEASURED)
        style.centre_on_zero(residual_axes, (loop.deflection - fit.turns[column]) / DEGREE)
        residual_axes.set_xlabel("torque at the output [N m]")
    grid[0, 0].set_ylabel("deflection [deg]")
    grid[1, 0].set_ylabel("residual [deg]")
    style.legend_above(grid[0, -1], ("measured", MEASURED), ("model", MODEL))
    style.add_condition(
        figure,
        f"{calibration.design.name}, {fit.condition.held} fixed, crank at {fit.condition.crank / DEGREE:.4g} deg",
    )
    return figure


@style.with_style
def protocol_figure(result: Protocol) -> Figure:
    """Draw the hysteresis loops of a test protocol, model and measurement: rotation of the output over its torque.

    `result` has the loops. The crank is fixed. Each loop is shifted so that the middle of its range of deflection is at
    zero.
    """
    figure = style.create_figure(3.2)
    axes = figure.subplots(1, 1, squeeze=False)[0, 0]
    for loop in result.loops:
        axes.plot(loop.torque, _centred_turn(loop), **MODEL)
    for loop in result.bench_loops:
        axes.plot(loop.torque, _centred_turn(loop), **MEASURED)
    for side in (-1.0, 1.0):
        axes.axvline(side * LOST_MOTION_SHARE * result.rated, color=style.GREY, linewidth=0.6)
    axes.set(xlabel="torque at the output [N m]", ylabel="deflection [deg]")
    entries = [("model", MODEL), *([("measured", MEASURED)] if result.bench_loops else [])]
    style.legend_above(axes, *entries)
    style.add_condition(figure, f"{result.design}, crank fixed; lines at 3 % of {result.rated:.4g} N m")
    return figure


def _centred_turn(loop: MeasuredLoop) -> Array:
    """Return the deflection of a loop about the middle of its range [deg], shape (n,): a bench has no zero."""
    deflection = loop.deflection / DEGREE
    return np.asarray(deflection - 0.5 * (deflection.max() + deflection.min()))


@style.with_style
def comparison_figure(result: BenchComparison) -> Figure:
    """Draw measured and modelled transmission error against the crank angle; the lower panel has their spectra.

    `result` has both curves. The spectra are bars with the amplitude at each order, in cycles per crank turn.
    """
    figure = style.create_figure(4.4)
    error_axes, order_axes = figure.subplots(2, 1)
    crank_degrees = result.measured.crank / DEGREE
    error = result.measured.error - result.measured.error.mean()
    error_axes.plot(crank_degrees, error / ARCSECOND, **style.THEORY)
    error_axes.plot(crank_degrees, result.model / ARCSECOND, color=style.VERMILION, linewidth=0.9)
    error_axes.set(xlabel="crank angle [deg]", ylabel="transmission error [arcsec]")
    style.legend_above(error_axes, ("measured", style.THEORY), ("model", {"color": style.VERMILION, "linewidth": 0.9}))
    width = 0.35
    order_axes.bar(result.order - width / 2, np.abs(result.bench_amplitude) / ARCSECOND, width, color=style.GREY)
    order_axes.bar(result.order + width / 2, np.abs(result.model_amplitude) / ARCSECOND, width, color=style.ORANGE)
    order_axes.set(xlabel="order [per crank turn]", ylabel="amplitude [arcsec]")
    style.legend_above(
        order_axes,
        ("measured", {"color": style.GREY, "linewidth": 4}),
        ("model", {"color": style.ORANGE, "linewidth": 4}),
    )
    style.add_condition(
        figure,
        f"{result.measured.name} and {result.design}, {result.load:.4g} N m, {result.explained_share:.1%} explained",
    )
    return figure
