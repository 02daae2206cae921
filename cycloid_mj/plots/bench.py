"""Figures of bench measurements: measured and modelled loops with residuals, and transmission error by order."""

import numpy as np
from matplotlib.figure import Figure

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import ARCSECOND, DEGREE
from cycloid_mj.bench import BenchComparison, Calibration, MeasuredLoop
from cycloid_mj.bench.protocol import Protocol
from cycloid_mj.plots.style import (
    BLUE,
    GREY,
    ORANGE,
    THEORY,
    VERMILION,
    centre_on_zero,
    legend_above,
    sheet,
    state,
    with_style,
)
from cycloid_mj.statics.windup import LOST_MOTION_SHARE

MEASURED = {"color": BLUE, "linestyle": "none", "marker": ".", "markersize": 2.5}
MODEL = {"color": VERMILION, "linewidth": 1.1}


@with_style
def calibration_figure(calibration: Calibration) -> Figure:
    """Draw each measured and modelled loop, with the residual below."""
    fitted, loops = calibration.fitted, calibration.fitted.loops
    figure = sheet(4.4)
    grid = figure.subplots(2, len(loops), squeeze=False, sharex="col", height_ratios=(3.0, 1.0))
    for column, loop in enumerate(loops):
        above, below = grid[0, column], grid[1, column]
        above.plot(loop.torque, loop.deflection / DEGREE, **MEASURED)
        for torque, turn in fitted.branches[column]:
            above.plot(torque, turn / DEGREE, **MODEL)
        above.set_title(loop.name)
        above.margins(x=0.02)
        below.plot(loop.torque, (loop.deflection - fitted.turns[column]) / DEGREE, **MEASURED)
        centre_on_zero(below, (loop.deflection - fitted.turns[column]) / DEGREE)
        below.set_xlabel("torque at the output [N m]")
    grid[0, 0].set_ylabel("deflection [deg]")
    grid[1, 0].set_ylabel("residual [deg]")
    legend_above(grid[0, -1], ("measured", MEASURED), ("model", MODEL))
    state(
        figure, f"{calibration.design.name}, {fitted.bench.held} fixed, crank at {fitted.bench.crank / DEGREE:.4g} deg"
    )
    return figure


@with_style
def protocol_figure(result: Protocol) -> Figure:
    """Draw the loops from which a protocol is evaluated, measured and modelled, each about its middle."""
    figure = sheet(3.2)
    axes = figure.subplots(1, 1, squeeze=False)[0, 0]
    for loop in result.loops:
        axes.plot(loop.torque, _centred_turn(loop), **MODEL)
    for loop in result.bench_loops:
        axes.plot(loop.torque, _centred_turn(loop), **MEASURED)
    for side in (-1.0, 1.0):
        axes.axvline(side * LOST_MOTION_SHARE * result.rated, color=GREY, linewidth=0.6)
    axes.set(xlabel="torque at the output [N m]", ylabel="deflection [deg]")
    shown = [("model", MODEL), *([("measured", MEASURED)] if result.bench_loops else [])]
    legend_above(axes, *shown)
    state(figure, f"{result.design}, crank fixed; lines at 3 % of {result.rated:.4g} N m")
    return figure


def _centred_turn(loop: MeasuredLoop) -> Array:
    """Return the deflection of a loop about the middle of its range [deg], shape (n,): a bench has no zero."""
    turn = loop.deflection / DEGREE
    return np.asarray(turn - 0.5 * (turn.max() + turn.min()))


@with_style
def comparison_figure(result: BenchComparison) -> Figure:
    """Draw measured and modelled transmission error over the crank angle and by order."""
    figure = sheet(4.4)
    above, below = figure.subplots(2, 1)
    crank = result.measured.crank / DEGREE
    error = result.measured.error - result.measured.error.mean()
    above.plot(crank, error / ARCSECOND, **THEORY)
    above.plot(crank, result.model / ARCSECOND, color=VERMILION, linewidth=0.9)
    above.set(xlabel="crank angle [deg]", ylabel="transmission error [arcsec]")
    legend_above(above, ("measured", THEORY), ("model", {"color": VERMILION, "linewidth": 0.9}))
    width = 0.35
    below.bar(result.order - width / 2, np.abs(result.bench_amplitude) / ARCSECOND, width, color=GREY)
    below.bar(result.order + width / 2, np.abs(result.model_amplitude) / ARCSECOND, width, color=ORANGE)
    below.set(xlabel="order [per crank turn]", ylabel="amplitude [arcsec]")
    legend_above(below, ("measured", {"color": GREY, "linewidth": 4}), ("model", {"color": ORANGE, "linewidth": 4}))
    state(
        figure,
        f"{result.measured.name} and {result.design}, {result.load:.4g} N m, {result.explained_share:.1%} explained",
    )
    return figure
