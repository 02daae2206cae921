"""The result of an optimisation: Pareto front of two objectives or convergence of one, and the varied keys."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cycloid_mj.base.array import Array
from cycloid_mj.explore.optimum import Optimum
from cycloid_mj.plots import style
from cycloid_mj.plots.explored import figure_words

MAX_KEYS = 6
"""Keys with a panel."""

POINT: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 2.5}
FEASIBLE, INFEASIBLE, START, BEST = "feasible", "infeasible", "start", "best"
MARKERS: dict[str, dict[str, Any]] = {
    FEASIBLE: {**POINT, "color": style.BLUE},
    INFEASIBLE: {**POINT, "color": style.SKY},
    START: {**POINT, "color": style.GREY, "marker": "s", "markersize": 6.0},
    BEST: {**POINT, "color": style.VERMILION, "marker": "*", "markersize": 11.0},
}
"""Kind of point -> its marker, in the order of the legend."""

COLUMNS = 3
"""Panels in a row."""


@style.with_style
def tradeoff_figure(optimum: Optimum) -> Figure:
    """Draw the evaluated points of an optimisation: its two objectives in the upper panel, its variables below.

    The upper panel has the second objective against the first, or a single objective against the number of the
    evaluation. Each lower panel has the first objective against a varied key of the design. Keys with a list of values
    and keys beyond the first `MAX_KEYS` have no panel. The axes cover the feasible points and the starting design.
    `optimum` is the result of the optimisation.
    """
    objectives, varied_ranges = optimum.task.objectives, optimum.task.ranges[:MAX_KEYS]
    rows = -(-len(varied_ranges) // COLUMNS)
    figure = style.create_figure(3.0 + 1.9 * rows)
    panel_grid = figure.add_gridspec(1 + rows, COLUMNS, height_ratios=[3.0, *([1.9] * rows)])
    main_axes = figure.add_subplot(panel_grid[0, :])
    columns = optimum.frame.columns
    if len(objectives) > 1:
        x, y = (np.asarray(columns[objective.key], dtype=float) for objective in objectives)
        _scatter_points(main_axes, optimum, x, y)
        front_rows = list(optimum.front)
        main_axes.step(x[front_rows], y[front_rows], where="post", color=style.BLUE, linewidth=0.9)
        main_axes.set(xlabel=_axis_label(optimum, objectives[0].key), ylabel=_axis_label(optimum, objectives[1].key))
    else:
        y = np.asarray(columns[objectives[0].key], dtype=float)
        _scatter_points(main_axes, optimum, np.asarray(columns["evaluation"], dtype=float), y)
        main_axes.set(xlabel="evaluation", ylabel=_axis_label(optimum, objectives[0].key))
    has_infeasible = len(optimum.feasible) < np.isfinite(y).sum()
    style.legend_above(main_axes, *(marker for marker in MARKERS.items() if has_infeasible or marker[0] != INFEASIBLE))
    for number, key_range in enumerate(varied_ranges):
        axes = figure.add_subplot(panel_grid[1 + number // COLUMNS, number % COLUMNS])
        _scatter_points(
            axes,
            optimum,
            np.asarray(columns[key_range.key], dtype=float),
            np.asarray(columns[objectives[0].key], float),
        )
        axes.set(
            xlabel=_axis_label(optimum, key_range.key),
            ylabel="" if number % COLUMNS else _axis_label(optimum, objectives[0].key),
        )
    style.add_condition(figure, optimum.words)
    return figure


def _axis_label(optimum: Optimum, key: str) -> str:
    """Return the axis label of a key of the design or of a figure, with its unit."""
    return style.in_words(key, optimum.frame.units.get(key, "")) if key in optimum.task.keys else figure_words(key)


def _scatter_points(axes: Axes, optimum: Optimum, x: Array, y: Array) -> None:
    """Draw the n evaluated points of an optimisation at coordinates x and y, (n,), with start and best point marked.

    Points with a coordinate that is not finite are left out. The limits of the axes cover the feasible points and the
    starting design. `optimum` is the result of the optimisation.
    """
    has_values = np.isfinite(x) & np.isfinite(y)
    is_feasible = np.zeros(len(x), dtype=bool)
    is_feasible[optimum.feasible] = True
    for kind, rows in ((INFEASIBLE, has_values & ~is_feasible), (FEASIBLE, has_values & is_feasible)):
        axes.plot(x[rows], y[rows], **MARKERS[kind])
    for kind, row in ((START, 0), (BEST, optimum.best)):
        if row is not None and has_values[row]:
            axes.plot(x[row], y[row], **MARKERS[kind])
    is_inside = has_values & is_feasible
    is_inside[0] |= has_values[0]
    for values, set_limits in ((x[is_inside], axes.set_xlim), (y[is_inside], axes.set_ylim)):
        if values.size and np.ptp(values) > 0.0:
            low, high = float(values.min()), float(values.max())
            set_limits(low - 0.06 * (high - low), high + 0.06 * (high - low))
