"""Figures with the axes and units of the paper, with theory, pin and nonpin in one plot (Figs 6-9, 12-16)."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from cycloid_mj.analysis import Series
from cycloid_mj.base.array import Array
from cycloid_mj.plots import style
from cycloid_mj.plots.comparison import COLORS
from hsieh2014.peaks import middle
from hsieh2014.stated import SHOWN

FARTHEST = 0.35
"""Largest drawn displacement of a pin, in radii of the pin."""


LINES = ("-", (0, (3, 1.5)))
"""Line styles of the two contact laws."""
HEIGHT: dict[str, Any] = {"linestyle": (0, (6, 3)), "linewidth": 0.9}


@style.with_style
def speeds_figure(motions: Sequence[Series]) -> Figure:
    """Draw the gear's speed over a crank turn, all designs in one plot, in deg/s as the paper, and rad/s (Fig. 6)."""
    figure = style.create_figure(3.4)
    axes = figure.subplots()
    first = motions[0].gear_speed.select(motions[0].one_turn)
    axes.plot(style.turn_degrees(motions[0]), np.degrees(first.theory), **style.THEORY)
    for number, motion in enumerate(motions):
        speed = motion.gear_speed.select(motion.one_turn)
        axes.plot(style.turn_degrees(motion), np.degrees(speed.simulated), **_look(number))
    axes.margins(y=0.08)
    axes.set_ylabel("speed of the gear [deg/s]")
    other = axes.secondary_yaxis("right", functions=(np.radians, np.degrees))
    other.set_ylabel("[rad/s]")
    style.crank_axis(axes, style.turn_degrees(motions[0]))
    _legend(figure, motions)
    return figure


@style.with_style
def paths_figure(motions: Sequence[Series]) -> Figure:
    """Draw the path of q over a crank turn with Eq. 16, all designs in one plot, and its error (Fig. 7)."""
    figure = style.create_figure(3.6)
    path, error = figure.subplots(1, 2, width_ratios=[1, 1.5])
    theory = motions[0].q_position.select(motions[0].one_turn).theory
    path.plot(*(1e3 * theory.T), **style.THEORY)
    for number, motion in enumerate(motions):
        position = motion.q_position.select(motion.one_turn)
        path.plot(*(1e3 * position.simulated.T), **_look(number))
        error.plot(style.turn_degrees(motion), 1e6 * position.error_size, **_look(number))
    path.set(aspect="equal", adjustable="datalim", xlabel="x from the initial gear centre [mm]", ylabel="y [mm]")
    path.margins(0.1)
    path.set_title("Path of q")
    error.set_ylabel("[\N{MICRO SIGN}m]")
    error.set_title("Distance of q from Eq. 16")
    error.set_ylim(0.0, 1.08 * error.get_ylim()[1])
    style.crank_axis(error, style.turn_degrees(motions[0]))
    _legend(figure, motions)
    return figure


@style.with_style
def velocities_figure(motions: Sequence[Series]) -> Figure:
    """Draw the velocity of q over a crank turn with Eq. 18, all designs in one plot, and its error (Fig. 8)."""
    figure = style.create_figure(4.4)
    top, bottom = figure.subplots(2, 1, sharex=True)
    theory = motions[0].q_velocity.size.select(motions[0].one_turn).theory
    top.plot(style.turn_degrees(motions[0]), 1e3 * theory, **style.THEORY)
    for number, motion in enumerate(motions):
        speed = motion.q_velocity.size.select(motion.one_turn)
        top.plot(style.turn_degrees(motion), 1e3 * speed.simulated, **_look(number))
        bottom.plot(style.turn_degrees(motion), 1e3 * speed.error, **_look(number))
    top.set_ylabel("velocity of q [mm/s]")
    bottom.set_ylabel("error [mm/s]")
    for panel in (top, bottom):
        panel.margins(y=0.08)
    style.crank_axis(bottom, style.turn_degrees(motions[0]))
    figure.align_ylabels()
    _legend(figure, motions)
    return figure


@style.with_style
def pins_figure(motions: Mapping[str, Series]) -> Figure:
    """Draw pin 1 in its socket at the crank angles of the paper's Fig. 9(a), with its rotation.

    Displacements are magnified so that the largest of a run is `FARTHEST` of the pin's radius; rotations are not. The
    circle marks the clearance; in a half-open socket, the pin can leave it.
    """
    figure = style.create_figure(1.75 * len(motions) + 0.5)
    panels = figure.subplots(len(motions), len(SHOWN), squeeze=False)
    for row, (name, motion) in zip(panels, motions.items(), strict=True):
        rows = motion.one_turn
        degrees = np.abs(style.turn_degrees(motion) - style.turn_degrees(motion)[0])
        pin, angle = motion.pin_1, np.degrees(motion.run["pin_1_angle"][rows])
        assert pin is not None
        scale = FARTHEST / max(pin.clearance, float(pin.radial[rows].max()))
        for axes, shown in zip(row, SHOWN, strict=True):
            column = int(np.argmin(np.abs(degrees - shown)))
            displacement = scale * pin.position[rows][column]
            turned = angle[column] - angle[0]
            _pin(axes, displacement, turned, 1.0 + scale * pin.clearance)
            axes.set_title(f"{shown:g} deg: {turned:+.2g} deg", fontsize=7.5)
        row[0].set_ylabel(name)
    figure.suptitle("pin 1 at crank angles: turned by (line: the mark at 0 deg)", x=0.01, ha="left", fontsize=8)
    return figure


@style.with_style
def heights_figure(
    curves: Mapping[str, tuple[Array, Array]], heights: Mapping[str, float], marks: Sequence[float] = ()
) -> Figure:
    """Draw the largest stress of a part over a crank turn on a logarithmic axis, with the paper's heights.

    Parameters
    ----------
    curves
        ``design, contact law`` -> crank angles [deg] and stress [MPa].
    heights
        Design -> approximate maximum of the paper's curve [MPa].
    marks
        Crank angles of the paper's peaks [deg].
    """
    figure = style.create_figure(3.6)
    axes = figure.subplots()
    names = list(dict.fromkeys(label.partition(", ")[0] for label in curves))
    laws = list(dict.fromkeys(label.partition(", ")[2] for label in curves))
    top = max([*(float(stress.max()) for _, stress in curves.values()), *heights.values()])
    looks: dict[str, dict[str, Any]] = {}
    for label, (degrees, stress) in curves.items():
        name, _, law = label.partition(", ")
        looks[label] = {"color": COLORS[names.index(name)], "linestyle": LINES[laws.index(law)], "linewidth": 1.0}
        # a whole turn: it begins and ends between the last and the first
        around = np.concatenate([[degrees[-1] - 360.0], degrees, [degrees[0] + 360.0]])
        closed = np.concatenate([stress[-1:], stress, stress[:1]])
        axes.plot(around, np.where(closed > 1e-4 * top, closed, np.nan), **looks[label])
    for name, height in heights.items():
        axes.axhline(height, color=COLORS[names.index(name)], **HEIGHT)
        looks[f"{name}, the paper"] = {"color": COLORS[names.index(name)], **HEIGHT}
    for mark in marks:
        axes.axvline(mark, color=style.GREY, linewidth=0.7, linestyle=":")
    axes.set_yscale("log")
    axes.set_ylim(axes.get_ylim()[0] / 1.3, 1.6 * top)
    axes.set_ylabel("von Mises stress, largest in bulk [MPa]")
    style.crank_axis(axes, np.array([0.0, 360.0]))
    # two rows: a column for each design, one for the paper
    figure.legend(
        handles=style.legend_handles(*looks.items()), loc="outside lower center", ncols=math.ceil(len(looks) / 2)
    )
    return figure


@style.with_style
def cam_figure(curves: Mapping[str, Array], marks: Sequence[float]) -> Figure:
    """Draw the cam's force over a crank turn: a panel for each design, a line for each case.

    `curves` are the forces in bins of the turn [N], by ``design, case``; `marks` are angles of dotted lines [deg].
    """
    names = list(dict.fromkeys(label.partition(", ")[0] for label in curves))
    figure = style.create_figure(3.0)
    panels = figure.subplots(1, len(names), sharey=True, squeeze=False)[0]
    cases = list(dict.fromkeys(label.partition(", ")[2] for label in curves))
    for panel, name in zip(panels, names, strict=True):
        for number, case in enumerate(cases):
            force = curves[f"{name}, {case}"]
            panel.plot([middle(bin_number) for bin_number in range(len(force))], force, **_look(number))
        for mark in marks:
            panel.axvline(mark, color=style.GREY, linewidth=0.8, linestyle=":")
        panel.set_title(name)
        style.crank_axis(panel, np.array([0.0, 360.0]))
    panels[0].set_ylim(0.0, 1.05 * max(float(force.max()) for force in curves.values()))
    panels[0].set_ylabel("force of the cam [N]")
    handles = style.legend_handles(*((case, _look(number)) for number, case in enumerate(cases)))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(cases))
    return figure


@style.with_style
def torques_figure(
    ours: Mapping[str, Mapping[str, float]], stated: Mapping[str, Mapping[str, float]], ideal: float
) -> Figure:
    """Draw output torques: a panel for each design, a bar for each computed case and a grey bar for each stated torque.

    `ours` and `stated` are torques [N m] by design, then by case; a dashed line is `ideal`, the torque without losses
    [N m].
    """
    figure = style.create_figure(2.2)
    panels = figure.subplots(1, len(ours), sharex=True, sharey=True, squeeze=False)[0]
    for number, (panel, (name, torques)) in enumerate(zip(panels, ours.items(), strict=True)):
        bars = {**torques, **stated[name]}
        rows = range(len(bars))
        panel.barh(
            rows,
            list(bars.values()),
            height=0.65,
            color=[COLORS[number]] * len(torques) + [style.GREY] * len(stated[name]),
        )
        for row, torque in zip(rows, bars.values(), strict=True):
            look: dict[str, Any] = {"textcoords": "offset points", "ha": "right", "va": "center", "color": "w"}
            panel.annotate(f"{torque:.2f}", (torque, row), (-4, 0), **look)
        panel.axvline(ideal, color=style.BLACK, linewidth=0.8, linestyle=(0, (4, 2)))
        panel.set_yticks(rows, list(bars))
        panel.set_title(name)
        panel.set_xlabel("output torque [N m]")
        panel.grid(False, axis="y")
    panels[0].invert_yaxis()
    panels[0].set_xlim(0.0, 1.05 * ideal)
    return figure


@style.with_style
def picture_figure(pictures: Mapping[str, Any]) -> Figure:
    """Draw rendered pictures, shape (height, width, 3) each, with their names, up to three side by side."""
    columns = min(len(pictures), 3)
    rows = math.ceil(len(pictures) / columns)
    figure = style.create_figure((style.WIDTH / columns + 0.25) * rows)
    panels = figure.subplots(rows, columns, squeeze=False).flat
    for panel, (name, picture) in zip(panels, pictures.items(), strict=False):
        panel.imshow(picture)
        panel.set_title(name)
    for panel in figure.axes:
        panel.set_axis_off()
    return figure


def _pin(axes: Axes, displacement: Array, turned: float, socket: float) -> None:
    """Draw a pin of radius 1 in a socket of radius `socket`, displaced by `displacement`, rotated by `turned` [deg]."""
    axes.add_patch(Circle((0.0, 0.0), socket, fill=False, color=style.GREY, linewidth=0.9))
    x, y = displacement.tolist()
    axes.add_patch(Circle((x, y), 1.0, facecolor="#DCE9F3", edgecolor=style.BLACK, linewidth=0.8))
    angle = np.radians(90.0 + turned)
    end = displacement + np.array([np.cos(angle), np.sin(angle)])
    axes.plot([displacement[0], end[0]], [displacement[1], end[1]], color=style.BLACK, linewidth=1.1)
    axes.set(xlim=(-1.45, 1.45), ylim=(-1.45, 1.45), aspect="equal", xticks=[], yticks=[])
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _look(number: int) -> dict[str, Any]:
    return {"color": COLORS[number], "linewidth": 0.9}


def _legend(figure: Figure, motions: Sequence[Series]) -> None:
    entries = [
        ("closed form", style.THEORY),
        *((motion.design.name, _look(number)) for number, motion in enumerate(motions)),
    ]
    figure.legend(handles=style.legend_handles(*entries), loc="outside lower center", ncols=len(entries))
