"""Figures of tolerance studies: error budget, and distributions of the figures over the samples."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cycloid_mj.base.array import Array
from cycloid_mj.explore.constraints import FigureLimit
from cycloid_mj.explore.tolerances import CONSTANT_RTOL, Tolerances
from cycloid_mj.figures import figure as row_of
from cycloid_mj.plots import style


@dataclass(frozen=True)
class HistogramSettings:
    """Settings of the histograms and of the error budget."""

    columns: int = 3
    """Histograms in a row."""
    row_height: float = 1.75
    """Height of a row [in]."""
    max_bins: int = 60
    """Bins of a histogram."""
    name_width: int = 34
    """Characters of a line of a title."""
    outlier_share: float = 0.001
    """Share of the samples at either end that a histogram leaves out."""


HISTOGRAM = HistogramSettings()


def tolerance_figures(tolerances: Tolerances) -> Mapping[str, Figure]:
    """Return the figures of a study by name: the error budget, if there is one, and the distributions."""
    figures = {"distributions": distributions_figure(tolerances)}
    if any(np.isfinite(share.total) for share in tolerances.budget):
        figures = {"budget": budget_figure(tolerances), **figures}
    return figures


@style.with_style
def budget_figure(tolerances: Tolerances) -> Figure:
    """Draw the error budget of a quantity: the share of each tolerance in its variance (Sobol index), as bars.

    The quantity is `Tolerances.budget_of`. For each tolerance, a wide bar is the total index with its 95 % confidence
    interval, and a narrow bar inside it is the first-order index, which is drawn as 0 if negative.
    """
    figure = style.create_figure(1.3 + 0.26 * len(tolerances.budget))
    axes = figure.subplots()
    bar_positions = np.arange(len(tolerances.budget))
    total_indices = np.array([share.total for share in tolerances.budget])
    interval_ends = np.array([share.ci95 for share in tolerances.budget])
    axes.barh(bar_positions, total_indices, height=0.66, color=style.SKY)
    axes.barh(bar_positions, [max(share.first_order, 0.0) for share in tolerances.budget], height=0.3, color=style.BLUE)
    interval_lengths = np.maximum(np.abs(interval_ends - total_indices[:, np.newaxis]).T, 0.0)
    axes.errorbar(
        total_indices, bar_positions, xerr=interval_lengths, fmt="none", ecolor=style.BLACK, elinewidth=0.8, capsize=2.0
    )
    axes.set_yticks(bar_positions, [share.source.replace("_", " ") for share in tolerances.budget])
    axes.invert_yaxis()
    axes.set_xlim(0.0, max(1.0, 1.05 * float(np.nanmax(interval_ends))))
    axes.grid(visible=False, axis="y")
    axes.set(xlabel="share of the variance [1]", title=f"Error budget: {row_of(tolerances.budget_of).name}")
    entries = (
        ("total effect, 95 % confidence interval", {"color": style.SKY, "linewidth": 6}),
        ("first-order effect", {"color": style.BLUE, "linewidth": 3}),
    )
    figure.legend(handles=style.legend_handles(*entries), loc="outside lower left", ncols=len(entries))
    style.add_condition(figure, f"{tolerances.design}, jammed samples excluded")
    return figure


@style.with_style
def distributions_figure(tolerances: Tolerances) -> Figure:
    """Draw a histogram of each computed quantity over the samples that do not jam, with lines at its limits.

    `tolerances` is the result of the tolerance study.
    """
    figure_keys = list(tolerances.figures)
    rows = -(-len(figure_keys) // HISTOGRAM.columns)
    figure = style.create_figure(HISTOGRAM.row_height * rows + 0.4)
    panels = np.ravel(figure.subplots(rows, HISTOGRAM.columns))
    for axes in panels[len(figure_keys) :]:
        axes.remove()
    for axes, key in zip(panels, figure_keys, strict=False):
        _draw_histogram(
            axes,
            key,
            tolerances.figures[key][~tolerances.jams],
            [limit for limit in tolerances.limits if limit.key == key],
        )
    style.add_condition(
        figure, f"{tolerances.design}, {tolerances.samples} samples, seed {tolerances.seed}; jammed samples excluded"
    )
    return figure


def _draw_histogram(axes: Axes, key: str, values: Array, limits: list[FigureLimit]) -> None:
    """Draw the histogram of n `values` (n,) of the quantity `key`, with lines at its limits.

    Values that are not finite are dropped, and the share `HistogramSettings.outlier_share` of the smallest and of the
    largest values is not shown. If the quantity is constant or has no values, a text says so.
    """
    axes.set_title(style.wrap_label(row_of(key).name, HISTOGRAM.name_width), fontsize=8.0)
    axes.set_yticks([])
    axes.grid(visible=False, axis="y")
    unit = row_of(key).unit
    axes.set_xlabel("" if unit == "1" else f"[{unit}]")
    axes.locator_params(axis="x", nbins=3)
    values = values[np.isfinite(values)]
    low, high = (
        np.quantile(values, [HISTOGRAM.outlier_share, 1.0 - HISTOGRAM.outlier_share])
        if values.size
        else (math.nan, math.nan)
    )
    if not high - low > CONSTANT_RTOL * max(abs(low), abs(high)):
        caption = f"constant: {low:.4g}" if values.size else "no value"
        axes.text(0.5, 0.5, caption, ha="center", va="center", transform=axes.transAxes)
        axes.set_xticks([])
        return
    axes.hist(
        values,
        bins=min(HISTOGRAM.max_bins, round(values.size**0.5) + 1),
        range=(float(low), float(high)),
        color=style.BLUE,
    )
    for limit in limits:
        axes.axvline(limit.bound, color=style.VERMILION, linewidth=1.2)
        axes.set_title(str(limit), fontsize=8.0, color=style.VERMILION)
