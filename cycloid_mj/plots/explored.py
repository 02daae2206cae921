"""Figures of sweeps: lines over one input, maps over two, and a grid of quantities over inputs for more."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from cycloid_mj.base.array import Array
from cycloid_mj.explore.ranks import number_inputs, rank_correlations
from cycloid_mj.explore.sweeps import Sweep
from cycloid_mj.figures import find_figure
from cycloid_mj.plots import style

COLOURS = (*style.PALETTE, style.BLACK)


@dataclass(frozen=True)
class SweepStyle:
    """Sizes and limits of the figures of a sweep."""

    row_height: float = 2.2
    """Height of a row of panels [in]."""
    title_width: int = 38
    """Characters of a line of a title."""
    label_width: int = 22
    """Characters of a line of an axis label."""
    max_points: int = 4000
    """Points of a panel of a pair plot; of more, evenly spaced points are drawn."""
    max_markers: int = 60
    """Points of a line up to which each has a marker."""
    max_inputs: int = 6
    """Inputs of a pair plot: those with the largest rank correlations."""


SWEEP = SweepStyle()


@style.with_style
def sweep_figure(sweep: Sweep, quantities: Sequence[str]) -> Figure:
    """Draw quantities of a sweep against its inputs; failed points are marked on the axis of the input.

    With one input, the points are joined by a line. With two inputs, the figure is a contour map, or a line for each
    value of one of them. With more inputs, each quantity is drawn as points against each input.

    Parameters
    ----------
    quantities
        Numeric columns: a panel each, or a row of panels if there are more than two inputs.
    """
    keys = sweep.task.keys
    numbers = number_inputs(sweep)
    if len(keys) == 1:
        return _draw_panels(sweep, quantities, lambda axes, name: _draw_over_input(axes, sweep, keys[0], name))
    if len(keys) == len(numbers) == 2 and _spans_a_plane(_scaled_points(*(sweep.frame.numbers[key] for key in keys))):
        return _draw_panels(sweep, quantities, lambda axes, name: _draw_map(axes, sweep, name))
    if len(keys) == 2 and (inputs := numbers or keys):
        parameter = next(key for key in keys if key != inputs[0])
        if len(set(sweep[parameter].tolist())) <= len(COLOURS):
            return _draw_panels(
                sweep, quantities, lambda axes, name: _draw_lines(axes, sweep, inputs[0], parameter, name)
            )
    return _draw_pairs(sweep, quantities)


def _draw_panels(sweep: Sweep, quantities: Sequence[str], draw: Callable[[Axes, str], None]) -> Figure:
    """Return a figure with a panel for each quantity of a sweep; `draw` is called with axes and name of each."""
    rows = max(1, math.ceil(len(quantities) / 2))
    figure = style.NotebookFigure(figsize=(style.WIDTH, SWEEP.row_height * rows + 0.4), layout="constrained")
    panels = figure.subplots(rows, 2, squeeze=False).ravel()
    for axes, name in zip(panels, quantities, strict=False):
        draw(axes, name)
        axes.set_title(style.wrap_label(_title(sweep, name), SWEEP.title_width))
    for axes in panels[len(quantities) :]:
        axes.remove()
    _add_heading(figure, sweep)
    return figure


def _add_heading(figure: Figure, sweep: Sweep) -> None:
    """Add design and number of points above a figure."""
    failed_text = f", {sweep.failed} failed" if sweep.failed else ""
    style.add_condition(figure, f"{sweep.task.reducer.design.name}: {len(sweep)} points{failed_text}")


def _title(sweep: Sweep, name: str) -> str:
    """Return a column in words with its unit."""
    unit = sweep.frame.units.get(name, "")
    return style.in_words(name, unit) if name in sweep.task.keys else figure_words(name, unit)


def figure_words(column: str, unit: str = "") -> str:
    """Return a column of a measure in words with its unit, as in the catalogue of figures if it contains it."""
    measure, _, key = column.rpartition(".")
    if (figure := find_figure(key)) is None:
        return style.in_words(column, unit)
    words = f"{figure.name} [{figure.unit}]" if figure.unit != "1" else figure.name
    return f"{measure}: {words}" if measure else words


def _draw_over_input(axes: Axes, sweep: Sweep, key: str, name: str) -> None:
    """Draw the quantity `name` of all points of a sweep over the input `key`."""
    _draw_line(axes, _input_positions(axes, sweep, key), sweep.frame.numbers[name], COLOURS[0])
    _mark_failures(axes, sweep, key)


def _draw_lines(axes: Axes, sweep: Sweep, abscissa: str, parameter: str, name: str) -> None:
    """Draw the quantity `name` against the input `abscissa`, with a line for each value of `parameter`.

    `sweep` has the values of all points.
    """
    positions, values = _input_positions(axes, sweep, abscissa), sweep.frame.numbers[name]
    for colour, value in zip(COLOURS, dict.fromkeys(sweep[parameter].tolist()), strict=False):
        is_on_line = sweep[parameter] == value
        label = f"{value:g}" if isinstance(value, float) else str(value)
        _draw_line(axes, positions[is_on_line], values[is_on_line], colour, label)
    axes.legend(title=_title(sweep, parameter), title_fontsize=6.5, fontsize=6.5)
    _mark_failures(axes, sweep, abscissa)


def _draw_line(axes: Axes, x: Array, y: Array, colour: str, label: str = "") -> None:
    """Draw a line through n points in the order of x; `x` and `y` have shape (n,).

    Every point has a marker if there are at most `SWEEP.max_markers`. `label` is its text in the legend.
    """
    order = np.argsort(x, kind="stable")
    has_markers = len(x) <= SWEEP.max_markers
    axes.plot(
        x[order], y[order], "o-" if has_markers else "-", color=colour, markersize=2.8, linewidth=1.1, label=label
    )
    axes.margins(x=0.03)


def _input_positions(axes: Axes, sweep: Sweep, key: str) -> Array:
    """Label the x axis with the input `key`, and return the x coordinate of each point of the sweep, shape (points,).

    The coordinate is the value of the input. Values that are text get the coordinates 0, 1, ... in the order in which
    they first occur.
    """
    axes.set_xlabel(_title(sweep, key))
    if key in sweep.frame.numbers:
        return sweep.frame.numbers[key]
    choices = list(dict.fromkeys(map(str, sweep[key].tolist())))
    axes.set_xticks(range(len(choices)), choices)
    return np.array([choices.index(str(value)) for value in sweep[key].tolist()], dtype=float)


def _mark_failures(axes: Axes, sweep: Sweep, key: str) -> None:
    """Mark failed points of a sweep by crosses on the x axis, at their values of the input `key`."""
    is_failed = sweep["error"] != ""
    if is_failed.any():
        positions = _input_positions(axes, sweep, key)[is_failed]
        axes.plot(
            positions, np.zeros(is_failed.sum()), "x", color=style.VERMILION, markersize=5, clip_on=False,
            transform=axes.get_xaxis_transform(),
        )  # fmt: skip


def _scaled_points(x: Array, y: Array) -> Array:
    """Return the points of two inputs, each scaled to the range 0 to 1, so that both have the same weight."""
    return np.column_stack([_scale(x), _scale(y)])


def _scale(values: Array) -> Array:
    """Scale values to the range 0 to 1."""
    low, high = values.min(initial=math.inf), values.max(initial=-math.inf)
    return (values - low) / (high - low) if high > low else np.zeros_like(values)


def _spans_a_plane(points: Array) -> bool:
    """Return whether points span a plane: a map needs three points that are not collinear."""
    return len(points) > 2 and np.linalg.matrix_rank(points - points[0], tol=1e-6) == 2


def _draw_map(axes: Axes, sweep: Sweep, name: str) -> None:
    """Draw the quantity `name` of a sweep as a contour map over two inputs, triangulated between the points."""
    numbers = sweep.frame.numbers
    x_input, y_input = number_inputs(sweep)
    x, y, z = numbers[x_input], numbers[y_input], numbers[name]
    is_finite = np.isfinite(z)
    axes.set(xlabel=_title(sweep, x_input), ylabel=_title(sweep, y_input))
    axes.grid(False)
    points = _scaled_points(x[is_finite], y[is_finite])
    if _spans_a_plane(points) and np.ptp(z[is_finite]) > 0.0:
        triangles = Triangulation(*points.T).triangles
        contours = axes.tricontourf(
            Triangulation(x[is_finite], y[is_finite], triangles), z[is_finite], levels=10, cmap="viridis"
        )
        axes.figure.colorbar(contours, ax=axes, pad=0.02)
    if is_finite.sum() <= 10 * SWEEP.max_markers:
        axes.plot(x[is_finite], y[is_finite], ".", color=style.BLACK, markersize=1.5)
    axes.plot(x[~is_finite], y[~is_finite], "x", color=style.VERMILION, markersize=3)
    axes.margins(0.03)


def _draw_pairs(sweep: Sweep, quantities: Sequence[str]) -> Figure:
    """Draw every quantity of a sweep against every input as points, with Spearman's rank correlation for numbers.

    There is a row of panels for each quantity, and a column for each input.
    """
    keys = _main_inputs(sweep, quantities)
    rows = max(1, len(quantities))
    figure = style.NotebookFigure(figsize=(max(style.WIDTH, 1.45 * len(keys)), 1.35 * rows + 0.7), layout="constrained")
    panels = figure.subplots(rows, len(keys), squeeze=False, sharex="col", sharey="row")
    correlations = rank_correlations(sweep, tuple(quantities))
    point_stride = math.ceil(len(sweep) / SWEEP.max_points) or 1
    for row, name in enumerate(quantities):
        for column, key in enumerate(keys):
            axes = panels[row, column]
            values = sweep.frame.numbers[name][::point_stride]
            correlation = (
                correlations.rho[row, correlations.inputs.index(key)] if key in correlations.inputs else math.nan
            )
            strength = 0.0 if math.isnan(correlation) else abs(correlation)
            colour = style.VERMILION if strength > 0.5 else style.BLUE
            axes.plot(
                _input_positions(axes, sweep, key)[::point_stride],
                values,
                ".",
                color=colour,
                markersize=2.0,
                rasterized=True,
            )
            axes.margins(x=0.05)
            axes.set_xlabel(
                style.wrap_label(_title(sweep, key), SWEEP.label_width) if row == rows - 1 else "", fontsize=7.0
            )
            axes.set_title(
                "" if math.isnan(correlation) else style.typeset(f"{correlation:+.2f}"),
                fontsize=7.0,
                pad=2.0,
                loc="right",
            )
            if column == 0:
                axes.set_ylabel(style.wrap_label(_title(sweep, name), SWEEP.label_width), fontsize=6.5)
    _add_heading(figure, sweep)
    return figure


def _main_inputs(sweep: Sweep, quantities: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the inputs to draw: all, or at most `SWEEP.max_inputs`.

    If there are more, those with the largest rank correlations with any of the `quantities` are selected. Their order
    is that of the sweep.
    """
    if len(sweep.task.keys) <= SWEEP.max_inputs:
        return sweep.task.keys
    correlations = rank_correlations(sweep, tuple(quantities))
    correlation_sizes = np.nan_to_num(np.abs(correlations.rho))
    largest_correlations = (
        correlation_sizes.max(axis=0, initial=0.0) if len(quantities) else np.zeros(len(correlations.inputs))
    )
    main_inputs = {
        correlations.inputs[index] for index in np.argsort(-largest_correlations, kind="stable")[: SWEEP.max_inputs]
    }
    return tuple(key for key in sweep.task.keys if key in main_inputs) or sweep.task.keys[: SWEEP.max_inputs]
