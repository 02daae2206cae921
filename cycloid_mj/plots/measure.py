"""Figures of measurements: a panel for each panel title of the curves.

The axes do not exaggerate differences: a panel of positive values starts at zero, or spans at least a quarter of its
largest value. Bars of several curves are drawn next to each other, coincident points as rings around each other.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import ScaledTranslation

from cycloid_mj.base.result import Curve
from cycloid_mj.measure import Measurement
from cycloid_mj.plots.style import GREY, PALETTE, THEORY, create_figure, typeset, with_style

COLOURS = (*PALETTE, GREY)


@dataclass(frozen=True)
class PanelStyle:
    """Sizes and limits of the panels."""

    height: float = 1.9
    """Height of a panel [in]."""
    polar_height: float = 3.2
    """Height of a polar panel [in]."""
    min_span: float = 0.25
    """Span of a y axis relative to its largest value, at least."""
    max_from_zero: float = 0.75
    """Smallest over largest value below which the axis of positive values starts at zero."""
    margin: float = 0.06
    """Space above and below the values, relative to the height of a panel."""
    bar_width: float = 1.4
    """Width of a bar [pt]."""
    min_bar_width: float = 0.3
    """Width of one of very many bars [pt]."""
    bars_width: float = 300.0
    """Total width of the bars of a panel [pt]."""
    marker_size: float = 5.5
    """Diameter of the markers of the first curve [pt]."""
    marker_decrement: float = 1.3
    """Decrease of the diameter for each further curve [pt]."""
    max_markers: int = 72
    """Contacts around a ring up to which each has a marker."""


PANEL = PanelStyle()


def measurement_figure(measurement: Measurement) -> Figure:
    """Draw the curves of a measurement, one panel below the other."""
    title = f"{measurement.measure}: {measurement.design.name}"
    return curves_figure(measurement.curves, f"{title}, {measurement.condition}" if measurement.condition else title)


@with_style
def curves_figure(curves: Sequence[Curve], title: str = "") -> Figure:
    """Draw curves in panels one below the other, under a `title`; curves with the same `Curve.panel` share one."""
    panels: dict[str, list[Curve]] = {}
    for curve in curves:
        panels.setdefault(curve.panel, []).append(curve)
    heights = [PANEL.polar_height if curves[0].style == "polar" else PANEL.height for curves in panels.values()]
    figure = create_figure(sum(heights) + 0.4)
    grid = figure.add_gridspec(len(panels), 1, height_ratios=heights)
    for row, (name, panel_curves) in enumerate(panels.items()):
        is_polar = panel_curves[0].style == "polar"
        axes = figure.add_subplot(grid[row], projection="polar" if is_polar else None)
        axes.set_title(name)
        if is_polar:
            _draw_polar(axes, panel_curves)
        else:
            _draw_curves(axes, panel_curves)
            _limit_axes(axes, panel_curves)
            axes.set(xlabel=panel_curves[0].x_label, ylabel=panel_curves[0].y_label)
        axes.yaxis.set_major_formatter(lambda value, _: typeset(f"{value:g}"))
        if axes.get_legend_handles_labels()[1]:
            axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0)
    if title:
        figure.suptitle(title, fontsize=9.5)
    return figure


def _draw_curves(axes: Axes, curves: list[Curve]) -> None:
    """Draw the curves of a panel as lines, bars or markers according to `Curve.style`, with labels for the legend."""
    measured_curves = [curve for curve in curves if curve.style not in ("theory", "rings")]
    colours = {id(curve): COLOURS[number % len(COLOURS)] for number, curve in enumerate(measured_curves)}
    colour_by_name = {curve.name: colours[id(curve)] for curve in measured_curves}
    bars = [curve for curve in measured_curves if curve.style == "bars"]
    points = [curve for curve in measured_curves if curve.style == "points"]
    for name in dict.fromkeys(curve.name for curve in curves if curve.of):
        axes.plot([], [], label=name, **{**THEORY, "color": GREY, "alpha": 0.4})
    for curve in curves:
        if curve.style == "theory":
            reference_style: dict[str, Any] = (
                {"color": colour_by_name[curve.of], "alpha": 0.35} if curve.of else {"label": curve.name}
            )
            axes.plot(curve.x, curve.y, **{**THEORY, **reference_style})
        elif curve.style == "rings":
            ring_style: dict[str, Any] = {
                "markersize": PANEL.marker_size + 3.0,
                "markerfacecolor": "none",
                "markeredgewidth": 2.0,
                "clip_on": False,
            }
            axes.plot(curve.x, curve.y, "o", label=curve.name, markeredgecolor=THEORY["color"], **ring_style)
        elif curve.style == "bars":
            _draw_bars(axes, curve, bars, colours[id(curve)])
        elif curve.style == "points":
            size = max(PANEL.marker_size - PANEL.marker_decrement * points.index(curve), PANEL.marker_decrement)
            # markers on the edge of the panel are not clipped
            marker_style: dict[str, Any] = {"markersize": size, "color": colours[id(curve)], "clip_on": False}
            axes.plot(curve.x, curve.y, "o", label=curve.name, **marker_style)
        else:
            axes.plot(curve.x, curve.y, label=curve.name, color=colours[id(curve)], linewidth=0.9)


def _draw_bars(axes: Axes, curve: Curve, bars: list[Curve], colour: str) -> None:
    """Draw the bars of a curve next to those of the other curves of the panel."""
    count = len(bars) * max(len(bar.x) for bar in bars)
    width = float(np.clip(0.7 * PANEL.bars_width / count, PANEL.min_bar_width, PANEL.bar_width))
    offset = (bars.index(curve) - 0.5 * (len(bars) - 1)) * 1.15 * width / 72.0
    shifted_transform = axes.transData + ScaledTranslation(offset, 0.0, axes.figure.dpi_scale_trans)
    axes.vlines(curve.x, 0.0, curve.y, label=curve.name, color=colour, linewidth=width, transform=shifted_transform)


def _draw_polar(axes: Axes, curves: list[Curve]) -> None:
    """Draw forces around a ring in polar axes: `Curve.x` is the angle [deg] clockwise from +y, `Curve.y` the radius.

    A curve with at most `PanelStyle.max_markers` points is drawn as markers, other curves as lines.
    """
    for number, curve in enumerate(curves):
        angle, colour = np.radians(curve.x), COLOURS[number % len(COLOURS)]
        if len(curve.x) > PANEL.max_markers:
            axes.plot(angle, curve.y, label=curve.name, color=colour, linewidth=0.9)
            continue
        # no line from contact to contact: there are no forces in between
        if number == 0:
            axes.vlines(angle, 0.0, curve.y, color=colour, linewidth=1.2)
        face = colour if number == 0 else "none"
        marker_style: dict[str, Any] = {"markersize": 3.5, "markerfacecolor": face, "markeredgecolor": colour}
        axes.plot(angle, curve.y, "o", label=curve.name, **marker_style)
    axes.set_title(f"{curves[0].panel}: {curves[0].y_label}")
    polar: Any = axes
    polar.set_theta_zero_location("N")
    polar.set_theta_direction(-1)
    polar.set_rmin(0.0)
    polar.yaxis.set_major_locator(MaxNLocator(4))
    # labels of the radii opposite the largest value, where there is space
    polar.set_rlabel_position(float(curves[0].x[np.argmax(curves[0].y)]) + 180.0)


def _limit_axes(axes: Axes, curves: list[Curve]) -> None:
    """Set the limits of the axes so that all finite points of the curves are inside.

    The y axis begins at 0 if the values are positive and their relative variation is large; otherwise it spans at least
    `PanelStyle.min_span` of the largest magnitude.
    """
    x, y = (np.concatenate([getattr(curve, name) for curve in curves]) for name in ("x", "y"))
    x, y = x[np.isfinite(x)], y[np.isfinite(y)]
    if not len(x) or not len(y):
        return
    if curves[0].style == "bars":
        axes.set_xlim(0.0, 1.02 * x.max())
    elif x.min() == x.max() > 0.0:
        axes.set_xlim(0.0, 1.1 * x.max())
    elif np.ptp(x) > 0.0 and all(curve.style in ("points", "rings") for curve in curves):
        axes.set_xlim(x.min() - PANEL.margin * np.ptp(x), x.max() + PANEL.margin * np.ptp(x))
    low, high = float(y.min()), float(y.max())
    if low >= 0.0 and low < PANEL.max_from_zero * high:
        axes.set_ylim(0.0, (1.0 + PANEL.margin) * high)
    elif low < high or low != 0.0:
        half_span = max((0.5 + PANEL.margin) * (high - low), 0.5 * PANEL.min_span * max(abs(low), abs(high)))
        axes.set_ylim(0.5 * (low + high) - half_span, 0.5 * (low + high) + half_span)
