"""The drawings of the page on concepts, computed by the package from the exact geometry."""

import math
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from cycloid_mj.base.array import Array
from cycloid_mj.design import Design, loads
from cycloid_mj.geometry import kinematics, profile
from cycloid_mj.geometry.modification import tooth_profile
from cycloid_mj.plots import mechanism
from cycloid_mj.plots.style import BLUE, GREEN, GREY, ORANGE, STYLE, VERMILION
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import loads as balanced
from cycloid_mj.statics import springs_of, transmission_error

FEW = loads(
    """
name = "few"
[ring]
teeth = 7
pin_circle_radius_mm = 30.0
pin_radius_mm = 5.0
[gear]
eccentricity_mm = 2.0
bore_radius_mm = 8.0
[output]
pins = 4
pin_radius_mm = 2.0
pin_circle_radius_mm = 15.5
hole_radius_mm = 4.0
[shaft]
radius_mm = 4.0
"""
)
"""A reducer with seven pins (6:1), few enough to distinguish them in a drawing."""

WIDTH, FONT_SIZE = 5.2, 10.0
"""Width of a drawing [in] and size of its text [pt], which a phone shows at two thirds."""

RATED_TORQUE = 36.68
"""Nominal torque of the preset `pin` on its output [N m]."""

ARCMIN, ARCSEC = math.pi / 10800.0, math.pi / 648000.0


def write(folder: Path) -> None:
    """Draw all drawings into a folder, except those that are there."""
    folder.mkdir(exist_ok=True)
    from matplotlib import rc_context

    for draw in (parts, backlash, error, play):
        path = folder / f"{draw.__name__}.svg"
        if not path.exists():
            sizes = dict.fromkeys(("font.size", "axes.titlesize", "legend.fontsize"), FONT_SIZE)
            with rc_context(STYLE | sizes | {"svg.fonttype": "path"}):
                draw().savefig(path, metadata={"Date": None})


def parts() -> Figure:
    """Draw a reducer of seven pins with the names of its parts."""
    figure = mechanism(Reducer(FEW), crank_angle=0.6)
    axes = figure.axes[0]
    figure.legends[0].remove()
    figure.set_size_inches(WIDTH, 0.86 * WIDTH)
    gear, reach = tooth_profile(FEW), 1e3 * FEW.housing.outer_radius
    centre, turn = 1e3 * kinematics.gear_centre(gear, 0.6), float(kinematics.gear_rotation(gear, 0.6))
    pin = 1e3 * gear.pin_circle_radius * profile.unit(2.0 * math.pi / 7.0)
    hole = 1e3 * FEW.output.pin_circle_radius * profile.unit(math.pi / 2.0 - turn)
    _name(axes, "ring pin,\nin its socket", pin, (1.0 * reach, 0.88 * reach))
    _name(axes, "cycloid disc:\n6 lobes on 7 pins", centre + np.array([-14.0, -17.0]), (-1.0 * reach, -0.98 * reach))
    _name(axes, "output pin in\na hole of the disc", hole, (1.0 * reach, -0.98 * reach))
    _name(axes, "eccentric cam,\neccentricity c", centre + np.array([-4.5, 4.5]), (-1.0 * reach, 0.88 * reach))
    axes.set(xlim=(-1.4 * reach, 1.4 * reach), ylim=(-1.15 * reach, 1.15 * reach))
    return figure


def backlash() -> Figure:
    """Draw the rotation of the output over its torque at a locked crank, without friction."""
    reducer = Reducer(Design().but(environment={"gravity_x": 0.0, "gravity_y": 0.0}, drive={"speed": 0.0}))
    torque = np.concatenate([-np.geomspace(RATED_TORQUE, 1e-3, 40), np.geomspace(1e-3, RATED_TORQUE, 40)])
    springs = springs_of(reducer, [0.4], friction=False)
    turn = np.array([balanced(reducer, springs, float(value)).output_turn[0] for value in torque]) / ARCMIN
    figure = Figure(figsize=(WIDTH, 3.4), layout="constrained")
    axes = figure.subplots()
    axes.plot(torque, turn, color=BLUE, linewidth=1.6)
    below, above = turn[torque < 0.0].max(), turn[torque > 0.0].min()
    lost = np.interp([-0.03 * RATED_TORQUE, 0.03 * RATED_TORQUE], torque, turn)
    axes.annotate("", (0.0, below), (0.0, above), arrowprops={"arrowstyle": "<->", "color": VERMILION})
    axes.text(-0.8, 0.1, f"backlash {above - below:.2f} arcmin", color=VERMILION, ha="right")
    axes.hlines(lost, [-0.03 * RATED_TORQUE, 0.03 * RATED_TORQUE], 12.0, color=GREEN, linewidth=0.8)
    axes.annotate("", (12.0, lost[0]), (12.0, lost[1]), arrowprops={"arrowstyle": "<->", "color": GREEN})
    label = f"lost motion {lost[1] - lost[0]:.2f} arcmin,\nbetween ±3 % of\nthe nominal torque"
    axes.text(13.0, 0.0, label, color=GREEN, va="center")
    slope = (np.interp(RATED_TORQUE, torque, turn) - np.interp(0.5 * RATED_TORQUE, torque, turn)) / (0.5 * RATED_TORQUE)
    axes.text(
        20.0, np.interp(20.0, torque, turn) + 0.1, f"stiffness {1.0 / slope:.0f} N m/arcmin", color=BLUE, ha="right"
    )
    axes.set(
        xlabel="torque on the output [N m]",
        ylabel="rotation of the output [arcmin]",
        xlim=(-RATED_TORQUE, RATED_TORQUE),
    )
    return figure


def error() -> Figure:
    """Draw the transmission error of a reducer with displaced pins over a crank turn, and its orders."""
    reducer = Reducer(Design().but(errors={"pin_position": 2e-6, "seed": 3}))
    crank = np.linspace(0.0, 2.0 * np.pi, 721)[:-1]
    error_curve = transmission_error(reducer, crank, RATED_TORQUE)[:, 1] / ARCSEC
    error_curve = error_curve - error_curve.mean()
    figure = Figure(figsize=(WIDTH, 4.4), layout="constrained")
    curve, orders = figure.subplots(2, 1)
    curve.plot(np.degrees(crank), error_curve, color=BLUE)
    curve.set(xlabel="crank angle [deg]", ylabel="transmission error\nof the output [arcsec]", xlim=(0.0, 360.0))
    size = 2.0 * np.abs(np.fft.rfft(error_curve)) / error_curve.size
    orders.bar(np.arange(1, 41), size[1:41], color=[VERMILION if k == 36 else BLUE for k in range(1, 41)])
    orders.annotate("mesh order 36", (36.0, size[36]), (22.0, 0.7 * size[1:41].max()), arrowprops={"arrowstyle": "-"})
    orders.set(xlabel="order: cycles per crank turn", ylabel="amplitude [arcsec]", xlim=(0.0, 41.0))
    return figure


def play() -> Figure:
    """Draw a pin between disc and socket: free, pressed and massless, with enlarged clearance."""
    figure = Figure(figsize=(WIDTH, 2.5), layout="constrained")
    free, pressed, massless = figure.subplots(1, 3)
    for axes, title, shift, gear in (
        (free, "free pin, no load", 0.0, -1.12),
        (pressed, "free pin, pressed", 0.12, -0.88),
        (massless, "massless pin", 0.12, -0.88),
    ):
        angle = np.linspace(0.0, math.pi, 60)
        axes.plot(1.12 * np.cos(angle), 1.12 * np.sin(angle), color=GREY, linewidth=2.0)
        axes.fill_between([-1.7, 1.7], gear, -1.9, color="#8DBFE3")
        fill = "none" if axes is massless else "#F3C969"
        axes.add_patch(Circle((0.0, shift), 1.0, facecolor=fill, edgecolor=ORANGE, linewidth=1.4))
        axes.text(0.0, 1.3, "socket", ha="center", color=GREY)
        axes.text(0.0, -1.55, "disc", ha="center")
        axes.set(xlim=(-1.8, 1.8), ylim=(-2.9, 1.7), aspect="equal")
        axes.set_title(title, loc="center")
        axes.axis("off")
    for axes, shift in ((free, 0.0), (pressed, 0.12)):
        axes.text(0.0, shift, "pin", ha="center", va="center")
    massless.plot([0.0, -0.3, 0.3, -0.3, 0.3, 0.0], np.linspace(-0.88, 1.12, 6), color=VERMILION)
    free.text(0.0, -2.7, "two contacts,\none at a time", ha="center")
    pressed.text(0.0, -2.7, "two contacts\nin series", ha="center")
    massless.text(0.0, -2.7, "one contact:\nboth springs", ha="center")
    return figure


def _name(axes: Axes, text: str, at: Array, text_place: tuple[float, float]) -> None:
    axes.annotate(
        text,
        tuple(at),
        text_place,
        ha="center",
        fontsize=FONT_SIZE,
        arrowprops={"arrowstyle": "-", "color": "#222222", "linewidth": 0.8, "shrinkB": 0},
    )
