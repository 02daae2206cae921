"""Path and velocity of the point q of the disc (Figs 7 and 8 of Hsieh 2014)."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cycloid_mj.analysis import MICROMETRE, Compared, Series
from cycloid_mj.base.array import Array
from cycloid_mj.plots import style

_LIGHT = {style.BLUE: "#9CCBEA", style.ORANGE: "#F6D9A0", style.GREEN: "#A5D9CB"}


@style.with_style
def path_figure(motion: Series) -> Figure:
    """Draw the path of point q of the disc over a crank turn, simulated and by Eq. 16 of Hsieh 2014 (Fig. 7 there).

    Further panels magnify the path where the difference of both is largest, and show this error over the crank angle.
    `motion` are the time series of the run.
    """
    figure = style.create_figure(5.0)
    axes = figure.subplot_mosaic("pn;ee", width_ratios=[1.55, 1], height_ratios=[1.5, 1])
    degrees, position = style.turn_degrees(motion), motion.q_position.select(motion.one_turn)
    worst_sample = int(np.argmax(position.error_size))
    _draw_path(axes["p"], position, motion.q)
    _draw_detail(axes["n"], position, worst_sample)
    _connect_detail(axes["p"], axes["n"], 1e3 * position.theory[worst_sample])
    _draw_error(axes["e"], degrees, position, worst_sample)
    return figure


@style.with_style
def velocity_figure(motion: Series) -> Figure:
    """Draw the velocity of point q of the disc over a crank turn, by simulation and closed form (Hsieh 2014, Fig. 8).

    The closed form is Eqs 17 and 18 there. The lower panel has the difference of both. `motion` are the time series of
    the run.
    """
    figure = style.create_figure(4.2)
    velocity_axes, error_axes = figure.subplots(2, 1, sharex=True, height_ratios=[1.4, 1])
    degrees, velocity = style.turn_degrees(motion), motion.q_velocity.select(motion.one_turn)
    x, y = (Compared(velocity.simulated[:, axis], velocity.theory[:, axis]) for axis in range(2))
    components = (("$v_x$", x, style.BLUE), ("$v_y$", y, style.ORANGE), ("$|v|$", velocity.size, style.GREEN))
    for _, component, color in components:
        velocity_axes.plot(degrees, 1e3 * component.theory, color=_LIGHT[color], linewidth=3.2)
        velocity_axes.plot(degrees, 1e3 * component.simulated, color=color, linewidth=0.9)
        error_axes.plot(degrees, 1e3 * component.error, color=color, linewidth=0.8)
    velocity_axes.set_ylabel("velocity of q [mm/s]")
    velocity_axes.set_title("Velocity of q")
    entries = [(label, {"color": color, "linewidth": 1.2}) for label, _, color in components]
    closed_form_style = {"color": "#C9C9C9", "linewidth": 3.2}
    style.legend_above(
        velocity_axes,
        *entries,
        ("closed form", closed_form_style),
        ("simulation", {"color": style.BLACK, "linewidth": 0.9}),
    )
    style.centre_on_zero(error_axes, *(1e3 * component.error for _, component, _ in components))
    error_axes.set_ylabel("error [mm/s]")
    style.crank_axis(error_axes, degrees)
    figure.align_ylabels()
    return figure


def _draw_path(axes: Axes, point_path: Compared, q: Array) -> None:
    """Draw the simulated path of point q and its closed form, in mm.

    `point_path` has both paths in m. `q` is the point in the frame of the disc [m], shape (2,).
    """
    axes.plot(*(1e3 * point_path.theory.T), **style.THEORY)
    axes.plot(*(1e3 * point_path.simulated.T), **style.SIMULATED)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.08)
    axes.set_xlabel("x from the initial disc centre [mm]")
    axes.set_ylabel("y [mm]")
    axes.set_title(style.typeset(f"Path of q = ({1e3 * q[0]:.4g}, {1e3 * q[1]:.4g}) mm"))
    axes.legend(handles=style.legend_handles(*style.BOTH), loc="best", frameon=True, framealpha=0.9, edgecolor="none")


def _draw_detail(axes: Axes, position: Compared, sample: int) -> None:
    """Draw the simulated and the closed-form path of a point, in um relative to the closed form at `sample`.

    `position` has both paths in m, and `sample` is the index of the centre of the drawing. Lines connect the two points
    of each sample.
    """
    origin = position.theory[sample]
    closed_form_path, simulated_path = (1e6 * (path - origin).T for path in (position.theory, position.simulated))
    sample_distances = np.linalg.norm(np.diff(closed_form_path.T, axis=0), axis=1)
    spacing = float(sample_distances[max(0, sample - 1) : sample + 1].mean()) if sample_distances.size else 1.0
    half_span = max(2.5e6 * float(position.error_size[sample]), 1.3 * spacing, 1e-3)
    axes.plot(*closed_form_path, marker="o", markersize=5, **style.THEORY)
    axes.plot(*simulated_path, marker="o", markersize=2.5, **style.SIMULATED)
    is_inside = np.abs(closed_form_path).max(axis=0) < 3 * half_span
    for start, end in zip(closed_form_path.T[is_inside], simulated_path.T[is_inside], strict=True):
        axes.plot(*zip(start, end, strict=True), **style.ERROR)
    style.set_square_limits(axes, half_span)
    axes.set_title("largest difference")
    axes.yaxis.tick_right()
    axes.yaxis.set_label_position("right")
    for frame_line in axes.spines.values():
        frame_line.set(visible=True, color=style.VERMILION)


def _connect_detail(axes: Axes, detail: Axes, point: Array) -> None:
    """Mark a point (2,) [mm] of the path, and draw lines from it to the panel `detail` in which it is magnified."""
    axes.plot(
        *point, marker="o", markersize=7, markerfacecolor="none", markeredgecolor=style.VERMILION, markeredgewidth=1.0
    )
    for corner in ((0.0, 0.0), (0.0, 1.0)):
        axes.annotate(
            "",
            xy=(float(point[0]), float(point[1])),
            xycoords="data",
            xytext=corner,
            textcoords=detail.transAxes,
            arrowprops={"arrowstyle": "-", "color": style.VERMILION, "linewidth": 0.6, "alpha": 0.6, "shrinkB": 3.5},
            annotation_clip=False,
        ).set_in_layout(False)


def _draw_error(axes: Axes, degrees: Array, position: Compared, sample: int) -> None:
    """Draw the path error (x, y and magnitude) [um] against the crank angle [deg], and mark one sample.

    Parameters
    ----------
    degrees
        The n crank angles [deg], shape (n,).
    position
        Simulated and closed-form path [m].
    sample
        Index of the marked sample.
    """
    error, error_size = 1e6 * position.error, 1e6 * position.error_size
    axes.plot(degrees, error[:, 0], color=style.BLUE, linewidth=0.8)
    axes.plot(degrees, error[:, 1], color=style.ORANGE, linewidth=0.8)
    axes.plot(degrees, error_size, **style.ERROR)
    axes.plot(
        degrees[sample],
        error_size[sample],
        marker="o",
        markersize=7,
        markerfacecolor="none",
        markeredgecolor=style.VERMILION,
    )
    axes.axhline(0.0, color=style.BLACK, linewidth=0.5)
    axes.margins(y=0.12)
    axes.set_ylabel(f"error [{MICROMETRE}]")
    style.crank_axis(axes, degrees)
    labels = (("x", style.BLUE), ("y", style.ORANGE), ("distance", style.VERMILION))
    style.legend_above(axes, *((name, {"color": color, "linewidth": 1.2}) for name, color in labels))
