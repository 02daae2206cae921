"""The sketches of the glossary: small drawings from the exact geometry of a reducer of seven pins."""

import math
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
from drawings import FEW
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon, Wedge

from cycloid_mj.base.array import Array
from cycloid_mj.geometry import envelope, kinematics, profile
from cycloid_mj.geometry.modification import tooth_profile
from cycloid_mj.plots.mechanism import PART_STYLES
from cycloid_mj.plots.style import BLUE, GREEN, GREY, STYLE, VERMILION
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import loads, springs_of

SIZE, FONT_SIZE = 2.3, 9.0
"""Width and height of a sketch [in], and size of its text [pt]."""

CRANK_ANGLE = 0.6
"""Crank angle of the sketches [rad]."""

OUTLINE_POINTS = 600

GEAR = tooth_profile(FEW)
PIN_CIRCLE, PIN_RADIUS, ECCENTRICITY = (1e3 * value for value in GEAR.symbols[2:] + GEAR.symbols[1:2])
"""Radii of the pin circle and of a pin, and the eccentricity [mm]."""

ARROW = {"arrowstyle": "-|>", "color": VERMILION, "shrinkA": 0.0, "shrinkB": 0.0, "linewidth": 1.3}
DIMENSION = {"arrowstyle": "<->", "color": VERMILION, "shrinkA": 0.0, "shrinkB": 0.0, "linewidth": 1.0}


def write(folder: Path) -> None:
    """Draw all sketches into a folder, except those that are there."""
    folder.mkdir(exist_ok=True)
    for draw in SKETCHES:
        path = folder / f"{draw.__name__}.svg"
        if not path.exists():
            with rc_context(STYLE | {"font.size": FONT_SIZE, "svg.fonttype": "path"}):
                figure = Figure(figsize=(SIZE, SIZE), layout="constrained")
                axes = figure.subplots()
                axes.set(aspect="equal", xlim=(-40.0, 40.0), ylim=(-40.0, 40.0))
                axes.axis("off")
                draw(axes)
                figure.savefig(path, metadata={"Date": None})


def cycloid_disc(axes: Axes) -> None:
    """Draw the disc with one lobe marked."""
    _disc(axes)
    points = _disc_points(np.linspace(-0.5, 0.5, 60) * 2.0 * math.pi / GEAR.lobes + math.pi / GEAR.lobes)
    axes.plot(*points.T, color=VERMILION, linewidth=3.0)
    axes.annotate("lobe", points[30], (30.0, 34.0), ha="center", arrowprops={"arrowstyle": "-", "linewidth": 0.8})


def ring_pin(axes: Axes) -> None:
    """Draw the disc among the ring pins."""
    _disc(axes)
    _pins(axes)
    axes.add_patch(Circle((0.0, 0.0), PIN_CIRCLE, fill=False, edgecolor=GREY, linestyle=":"))


def internal_gear(axes: Axes) -> None:
    """Draw the disc in the internal gear: the envelope of all its positions."""
    axes.add_patch(Circle((0.0, 0.0), 38.0, **PART_STYLES["ring"]))
    ring = 1e3 * envelope.sample_ring(GEAR, OUTLINE_POINTS).points
    axes.add_patch(Polygon(ring, facecolor="white", edgecolor=PART_STYLES["ring"]["edgecolor"]))
    _disc(axes)


def eccentric(axes: Axes) -> None:
    """Draw the cam, whose centre lies next to the axis of the crank by the eccentricity, three times as large."""
    scale = 5.0
    centre = scale * ECCENTRICITY * np.array([-math.sin(CRANK_ANGLE), math.cos(CRANK_ANGLE)])
    axes.add_patch(Circle(tuple(centre), 24.0, **PART_STYLES["cam"]))
    axes.add_patch(Circle((0.0, 0.0), 9.0, **PART_STYLES["shaft"]))
    axes.plot([0.0, centre[0]], [0.0, centre[1]], color=VERMILION, marker="o", markersize=3.0)
    axes.annotate("c", centre / 2.0, (5.0, 8.0), color=VERMILION)
    axes.text(0.0, -24.0, "cam", ha="center")
    axes.text(0.0, -6.0, "shaft", ha="center", color="white")


def output_pin(axes: Axes) -> None:
    """Draw an output pin in its hole, which is wider by the eccentricity on each side."""
    axes.add_patch(Polygon([(-38, -38), (38, -38), (38, 38), (-38, 38)], facecolor=PART_STYLES["gear"]["facecolor"]))
    axes.add_patch(Circle((0.0, 0.0), 28.0, facecolor="white", edgecolor=PART_STYLES["gear"]["edgecolor"]))
    axes.add_patch(Circle((-9.9, -9.9), 14.0, **PART_STYLES["output"]))
    axes.annotate("", (0.0, 0.0), (-9.9, -9.9), arrowprops=DIMENSION)
    axes.text(1.0, -5.0, "c", color=VERMILION)
    axes.text(-14.0, -14.0, "pin", ha="center", va="center", color="white")
    axes.text(0.0, 31.0, "hole of the disc", ha="center")


def clearance(axes: Axes) -> None:
    """Draw a pin apart from the flank of a disc."""
    axes.add_patch(Wedge((0.0, -62.0), 60.0, 20.0, 160.0, facecolor=PART_STYLES["gear"]["facecolor"], edgecolor="none"))
    axes.add_patch(Circle((0.0, 21.0), 15.0, **PART_STYLES["pins"]))
    axes.annotate("", (0.0, -2.0), (0.0, 6.0), arrowprops=DIMENSION)
    axes.text(3.0, 0.0, "clearance δ", color=VERMILION)
    axes.text(0.0, 21.0, "pin", ha="center", va="center")
    axes.text(0.0, -22.0, "disc", ha="center")


def free_rotation(axes: Axes) -> None:
    """Draw the disc at both ends of its backlash, widely drawn."""
    _pins(axes, radius=0.8 * PIN_RADIUS)
    for turn, color in ((-0.09, BLUE), (0.09, VERMILION)):
        axes.add_patch(Polygon(_disc_points(turn=turn), fill=False, edgecolor=color, linewidth=1.0))
    axes.add_patch(Wedge((0.0, 0.0), 15.0, 90.0 - 5.2, 90.0 + 5.2, facecolor=GREEN))
    axes.text(0.0, -4.0, "backlash", ha="center", color=GREEN)


def tooth_force(axes: Axes) -> None:
    """Draw the force of the disc on a pin, and the pressure angle to the direction of motion."""
    angle = float(profile.pin_angles(GEAR)[1])
    normal = profile.normals(GEAR, _touching_parameter(angle))
    turned = _turn(kinematics.gear_rotation(GEAR, CRANK_ANGLE)) @ normal
    centre = PIN_CIRCLE * profile.unit(angle)
    _disc(axes)
    _pins(axes)
    axes.annotate("", centre + 22.0 * turned, centre, arrowprops=ARROW)
    tangent = np.array([centre[1], -centre[0]]) / PIN_CIRCLE
    tangent *= math.copysign(1.0, float(tangent @ turned))
    axes.plot(*np.array([centre, centre + 20.0 * tangent]).T, color=GREY, linestyle="--")
    axes.set(xlim=(5.0, 50.0), ylim=(-5.0, 40.0))


def load_sharing(axes: Axes) -> None:
    """Draw the forces of the ring pins on the disc under a torque, from the static model."""
    reducer = Reducer(FEW)
    forces = loads(reducer, springs_of(reducer, [CRANK_ANGLE], friction=False), 20.0).teeth[0]
    _disc(axes)
    _pins(axes)
    for angle, force in zip(profile.pin_angles(GEAR), forces, strict=True):
        if force > 0.0:
            place = (PIN_CIRCLE - PIN_RADIUS) * profile.unit(angle)
            axes.add_patch(
                Wedge((0.0, 0.0), float(np.hypot(*place)) - 1.0, *_span(angle), width=14.0 * force / forces.max(),
                      facecolor=VERMILION)
            )  # fmt: skip


def contact_pressure(axes: Axes) -> None:
    """Draw the pressure between a pin and a flank: half an ellipse over the width of the contact."""
    x = np.linspace(-20.0, 20.0, 101)
    pressure = 34.0 * np.sqrt(1.0 - (x / 20.0) ** 2)
    axes.add_patch(Polygon([(-40, 0), (40, 0), (40, -30), (-40, -30)], facecolor=PART_STYLES["gear"]["facecolor"]))
    axes.fill_between(x, pressure, color=VERMILION, alpha=0.35)
    axes.plot(x, pressure, color=VERMILION)
    axes.annotate("", (-20.0, -5.0), (20.0, -5.0), arrowprops=DIMENSION)
    axes.text(0.0, -13.0, "2 b", ha="center", color=VERMILION)
    axes.text(2.0, 14.0, "p₀")
    axes.plot([0.0, 0.0], [0.0, 34.0], color=GREY, linewidth=0.8)


def socket(axes: Axes) -> None:
    """Draw a pin in a half-open and in a closed socket."""
    for x, first, last, name in ((-20.0, 0.0, 180.0, "half-open"), (20.0, 0.0, 360.0, "closed")):
        axes.add_patch(Wedge((x, 0.0), 17.0, first, last, width=4.0, facecolor=PART_STYLES["ring"]["facecolor"]))
        axes.add_patch(Wedge((x, 0.0), 13.0, first, last, width=0.01, edgecolor=PART_STYLES["ring"]["edgecolor"]))
        axes.add_patch(Circle((x, 0.0), 11.5, **PART_STYLES["pins"]))
        axes.text(x, 24.0, name, ha="center")
    axes.text(0.0, -30.0, "the disc is below", ha="center", color=GREY)


def two_discs(axes: Axes) -> None:
    """Draw two discs, half a turn apart on the crank."""
    axes.add_patch(Polygon(_disc_points(crank=CRANK_ANGLE + math.pi, turn=math.pi / GEAR.lobes), facecolor="#C9D8E4",
                           edgecolor=GREY))  # fmt: skip
    axes.add_patch(Polygon(_disc_points(), facecolor=PART_STYLES["gear"]["facecolor"], alpha=0.7, edgecolor="#134A73"))
    _pins(axes)


def _touching_parameter(pin_angle: float) -> float:
    """Return the parameter of the outline [rad] at which the disc touches a pin at the crank angle of the sketches."""
    turn = float(kinematics.gear_rotation(GEAR, CRANK_ANGLE))
    parameter = np.linspace(0.0, 2.0 * math.pi, OUTLINE_POINTS)
    centre = kinematics.gear_centre(GEAR, CRANK_ANGLE)
    places = profile.trochoid(GEAR, parameter) @ _turn(turn).T + centre
    return float(parameter[np.argmin(np.hypot(*(places - 1e-3 * PIN_CIRCLE * profile.unit(pin_angle)).T))])


def _disc_points(parameter: Array | None = None, crank: float = CRANK_ANGLE, turn: float = 0.0) -> Array:
    """Return points of the disc's outline [mm] at a crank angle, with an additional turn [rad]."""
    parameter = np.linspace(0.0, 2.0 * math.pi, OUTLINE_POINTS) if parameter is None else parameter
    rotation = _turn(float(kinematics.gear_rotation(GEAR, crank)) + turn)
    return 1e3 * (profile.outline(GEAR, parameter) @ rotation.T + kinematics.gear_centre(GEAR, crank))


def _turn(angle: float) -> Array:
    return np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])


def _span(angle: float) -> tuple[float, float]:
    """Return the ends of a force bar in the degrees of Matplotlib, for a pin's clockwise angle from +y [rad]."""
    middle = 90.0 - math.degrees(angle)
    return middle - 7.0, middle + 7.0


def _disc(axes: Axes) -> None:
    axes.add_patch(Polygon(_disc_points(), **PART_STYLES["gear"]))
    centre = 1e3 * kinematics.gear_centre(GEAR, CRANK_ANGLE)
    axes.add_patch(Circle(tuple(centre), 1e3 * FEW.gear.bore_radius, facecolor="white", edgecolor="#134A73"))


def _pins(axes: Axes, radius: float = PIN_RADIUS) -> None:
    for angle in profile.pin_angles(GEAR):
        axes.add_patch(Circle(tuple(PIN_CIRCLE * profile.unit(angle)), radius, **PART_STYLES["pins"]))


SKETCHES: Iterable[Callable[[Axes], None]] = (
    *(cycloid_disc, ring_pin, internal_gear, eccentric, output_pin, clearance, free_rotation, tooth_force),
    *(load_sharing, contact_pressure, socket, two_discs),
)
"""Each draws into axes of 80 by 80 mm about the axis of the reducer."""
