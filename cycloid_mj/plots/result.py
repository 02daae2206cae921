"""The figures of any result of the library, by name: `result.plot()` returns the first."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import singledispatch

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cycloid_mj.analysis import Findings
from cycloid_mj.analysis.spectrum import Orders
from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Curve
from cycloid_mj.base.units import ARCMINUTE, DEGREE
from cycloid_mj.bench.calibration import Calibration
from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.prediction import Prediction
from cycloid_mj.bench.protocol import Protocol
from cycloid_mj.bench.te import BenchComparison
from cycloid_mj.checks import Checks
from cycloid_mj.comparison import Comparison
from cycloid_mj.design import Design
from cycloid_mj.explore.optimum import Optimum
from cycloid_mj.explore.sweeps import Sweep
from cycloid_mj.explore.tolerances import Tolerances
from cycloid_mj.life.accuracy_life import WearLife
from cycloid_mj.life.datasheet import Datasheet
from cycloid_mj.life.item import Rating
from cycloid_mj.life.thermal_state import ThermalState
from cycloid_mj.measure import Measurement
from cycloid_mj.parts.export import Export
from cycloid_mj.plots import figures
from cycloid_mj.plots.bench import calibration_figure, comparison_figure, protocol_figure
from cycloid_mj.plots.comparison import comparison_figures
from cycloid_mj.plots.curvature import curvature_figure
from cycloid_mj.plots.datasheet import datasheet_pictures
from cycloid_mj.plots.explored import figure_words, sweep_figure
from cycloid_mj.plots.measure import curves_figure, measurement_figure
from cycloid_mj.plots.mechanism import mechanism
from cycloid_mj.plots.optimum import tradeoff_figure
from cycloid_mj.plots.stress import stress_figures
from cycloid_mj.plots.style import BLUE, GREY, VERMILION, add_condition, create_figure, with_style
from cycloid_mj.plots.tolerance import tolerance_figures
from cycloid_mj.plots.wear import wear_figure
from cycloid_mj.reducer import Reducer
from cycloid_mj.robot.reducer import ReducedJoint
from cycloid_mj.sizing.answer import Answer
from cycloid_mj.statics.sheet import Sheet
from cycloid_mj.stress.study import StressStudy

Figures = Mapping[str, Figure]


@dataclass(frozen=True)
class ResultStyle:
    """Sizes and limits of the figures of results."""

    row: float = 0.26
    head: float = 1.1
    """Height of a bar, and of title and axis [in]."""
    points: int = 201
    """Points of a curve over the torque."""
    min_margin: float = 0.01
    """Left end of the axis of margins: a far smaller margin would hide the differences of the others."""
    max_checks: int = 20
    """Checks or rated items that are drawn, those with the smallest margins."""


RESULT = ResultStyle()


SIZING_FIGURES = ("mass_kg", "rated_torque_nm", "backlash_arcmin", "stiffness_nm_per_arcmin", "life_h")
"""Figures of drives that are compared."""


def figure_of(result: object, name: str = "") -> Figure:
    """Return the diagram of a result that is called `name`, or its first diagram if `name` is empty.

    Raises
    ------
    UsageError
        The result has no figures, or none of that name.
    """
    figures_by_name = figures_of(result)
    if name and name not in figures_by_name:
        available_names = ", ".join(figures_by_name)
        raise UsageError(f"a {type(result).__name__} has no figure {name!r}: choose one of {available_names}")
    return figures_by_name[name or next(iter(figures_by_name))]


@singledispatch
def figures_of(result: object) -> Figures:
    """Return the figures of a result by name; raise UsageError if it has none."""
    raise UsageError(f"a result of type {type(result).__name__} has no figure to draw: use .to_frame() for its values")


figures_of.register(Run, figures)
figures_of.register(Datasheet, datasheet_pictures)
figures_of.register(Tolerances, tolerance_figures)
figures_of.register(Design, lambda design: {"mechanism": mechanism(Reducer(design))})
figures_of.register(Measurement, lambda result: {result.measure: measurement_figure(result)})
figures_of.register(Curve, lambda result: {result.name: curves_figure([result])})
figures_of.register(Calibration, lambda result: {"calibration": calibration_figure(result)})
figures_of.register(Protocol, lambda result: {"loops": protocol_figure(result)})
figures_of.register(BenchComparison, lambda result: {"transmission_error": comparison_figure(result)})
figures_of.register(Sweep, lambda result: {"sweep": sweep_figure(result, result.quantities)})
figures_of.register(Optimum, lambda result: {"tradeoff": tradeoff_figure(result)})
figures_of.register(StressStudy, lambda result: stress_figures([result.findings]))
figures_of.register(ThermalState, lambda result: {"warm_up": curves_figure(result.curves)})
figures_of.register(WearLife, lambda result: {"wear": wear_figure(result)})


@figures_of.register
def _draw_comparison(comparison: Comparison) -> Figures:
    """Draw the signals and spectra of all compared runs, and the relative curvature of the designs, by figure name."""
    if not comparison.motions:
        raise UsageError(
            "this comparison has no simulations to draw: compare designs with simulations, or use .to_frame() for its "
            "values"
        )
    designs = [trial.design for trial in comparison.at(comparison.loads[0])]
    return {**comparison_figures(comparison.motions), "compare_curvature": curvature_figure(designs)}


@figures_of.register
@with_style
def _draw_prediction(prediction: Prediction) -> Figures:
    """Draw measured loops next to those that the model predicts, a panel for each loop, as the figure ``loops``."""
    figure = create_figure(2.8)
    panels: Sequence[Axes] = figure.subplots(1, len(prediction.loops), squeeze=False)[0]
    for axes, loop, model_angles in zip(panels, prediction.loops, prediction.turns, strict=True):
        axes.plot(loop.torque, loop.deflection / DEGREE, ".", color=GREY, markersize=2.0, label="measured")
        axes.plot(loop.torque, model_angles / DEGREE, color=BLUE, label="model")
        axes.set_title(loop.name)
        axes.set_xlabel("torque at the output [N m]")
    panels[0].set_ylabel("deflection [deg]")
    panels[0].legend()
    add_condition(figure, prediction.line)
    return {"loops": figure}


@figures_of.register
def _draw_checks(checks: Checks) -> Figures:
    tightest = dict(sorted(checks.margins.items(), key=lambda item: item[1])[: RESULT.max_checks])
    label = "margin: factor between value and limit [1]"
    return {"margins": _draw_bars(tightest, label, f"{checks.line[:120]}; below 1: not passed", fails_below_1=True)}


@figures_of.register
def _draw_clearances(exported: Export) -> Figures:
    ratios = {pair.pair: 0.5 * (pair.least + pair.most) / pair.asked for pair in exported.clearances if pair.asked}
    if not ratios:
        raise UsageError("this export has no clearances to draw: use .to_frame() for the list of files")
    return {"clearances": _draw_bars(ratios, "clearance of the exported parts / nominal clearance", exported.line)}


@figures_of.register
def _draw_joint(joint: ReducedJoint) -> Figures:
    """Draw the output angle of a reduced joint against the torque on the output, as the figure ``wind_up``.

    The crank is locked. The step at zero torque is the backlash.
    """
    torque = joint.rated_torque * np.linspace(0.0, 1.0, RESULT.points)
    wind_up = np.array([joint.wind_up(load) for load in torque])
    low, high = joint.stops
    output_angle = np.concatenate([(low - wind_up)[::-1], high + wind_up]) / ARCMINUTE
    return {
        "wind_up": _draw_curve(
            np.concatenate([-torque[::-1], torque]), output_angle, "output angle [arcmin]", joint.line
        )
    }


@figures_of.register
def _draw_losses(findings: Findings) -> Figures:
    watts = {loss.pair: loss.friction_w + loss.normal_w for loss in findings.losses}
    condition = f"{findings.design}, {findings.condition_words}"
    return {"losses": _draw_bars(watts, "loss by kind of contact [W]", condition)}


@figures_of.register
def _draw_rating(rating: Rating) -> Figures:
    """Draw the smallest safety factors, or lives over the required life, of a rating as the figure ``margins``."""
    margins = {item.name: item.margin(rating.life) for item in rating.items.values() if item.decisive}
    finite_margins = {name: margin for name, margin in margins.items() if math.isfinite(margin)}
    smallest_margins = dict(sorted(finite_margins.items(), key=lambda item: item[1])[: RESULT.max_checks])
    condition = f"{rating.design}, {rating.duty}, for {rating.life:g} h; below 1: not passed"
    return {
        "margins": _draw_bars(
            smallest_margins, "safety factor, or life / required life [1]", condition, fails_below_1=True
        )
    }


@figures_of.register
def _draw_sheet(sheet: Sheet) -> Figures:
    ratios = {item.name: item.value / item.reference for item in sheet.quantities.values() if item.reference}
    return {
        "closed_form": _draw_bars(ratios, "static equilibrium / closed form [1]", f"{sheet.design}, {sheet.condition}")
    }


@figures_of.register
@with_style
def _draw_sizing(answer: Answer) -> Figures:
    """Draw a bar chart for each quantity in `SIZING_FIGURES`, with a bar for each drive, as the figure ``drives``.

    `answer` is the result of a search, which has the drives.
    """
    if not answer.drives:
        raise UsageError(f"there is no drive to draw, because no drive meets the requirement: {answer.refusal}")
    keys = [key for key in SIZING_FIGURES if key in answer.drives[0].figures]
    figure = create_figure(2.2)
    panels: Sequence[Axes] = figure.subplots(1, len(keys), squeeze=False)[0]
    titles = [drive.title for drive in answer.drives]
    for axes, key in zip(panels, keys, strict=True):
        axes.bar(range(len(titles)), [drive.figures[key] for drive in answer.drives], color=BLUE)
        axes.set_xticks(range(len(titles)), titles, rotation=40, ha="right")
        axes.set_title(figure_words(key))
    add_condition(figure, answer.line)
    return {"drives": figure}


@with_style
def _draw_curve(torque: Array, angle: Array, label: str, condition: str) -> Figure:
    """Draw an output angle over the torque on the output [N m], at n points (n,).

    `label` names the angle with its unit, `condition` is printed below.
    """
    figure = create_figure(2.8)
    axes = figure.subplots()
    axes.plot(torque, angle, color=BLUE)
    axes.set_xlabel("torque at the output [N m]")
    axes.set_ylabel(label)
    add_condition(figure, condition)
    return figure


@with_style
def _draw_stems(order: Array, amplitude: Array, condition: str) -> Figure:
    """Draw the amplitude at each of n orders as a vertical line, arrays of shape (n,); `condition` is printed below."""
    figure = create_figure(2.4)
    axes = figure.subplots()
    axes.vlines(order, 0.0, amplitude, color=BLUE, linewidth=1.0)
    axes.set_xlabel("order [per crank turn]")
    axes.set_ylabel("amplitude [unit of the signal]")
    add_condition(figure, condition)
    return figure


@with_style
def _draw_bars(values: Mapping[str, float], label: str, condition: str, fails_below_1: bool = False) -> Figure:
    """Draw a horizontal bar for each of `values`, by name, the first at the top.

    `label` is the label of the value axis, and `condition` is printed below. If `fails_below_1` is True, the axis is
    logarithmic and bars extend from 1, with a different colour below 1.
    """
    figure = create_figure(RESULT.head + RESULT.row * len(values))
    axes = figure.subplots()
    names, numbers = list(values), list(values.values())
    if fails_below_1:
        axes.set_xscale("log")
        axes.axvline(1.0, color=GREY, linewidth=0.8)
        colours = [BLUE if value >= 1.0 else VERMILION for value in numbers]
        axes.barh(names, [value - 1.0 for value in numbers], left=1.0, color=colours, height=0.6)
        axes.set_xlim(left=max(axes.get_xlim()[0], RESULT.min_margin))
    else:
        axes.barh(names, numbers, color=BLUE, height=0.6)
    axes.invert_yaxis()
    axes.set_xlabel(label)
    add_condition(figure, condition)
    return figure


figures_of.register(Orders, lambda result: {"orders": _draw_stems(result.order, result.amplitude, result.line)})
figures_of.register(
    MeasuredLoop,
    lambda result: {"loop": _draw_curve(result.torque, result.deflection / DEGREE, "deflection [deg]", result.line)},
)
