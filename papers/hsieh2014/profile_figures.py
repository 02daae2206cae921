"""Generation of the profiles (the paper's Figs 1-4): trochoid, gear, conjugate contact, internal gear."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from cycloid_mj.base.array import Array
from cycloid_mj.geometry import envelope, kinematics, profile
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.plots import style

CRANK = np.radians(25.0)
"""Crank angle of the drawings of contact [rad]."""
POINTS, ORBIT = 7000, 360
"""Points of an outline, and positions of the gear on its orbit."""

GEAR: dict[str, Any] = {"color": style.BLUE, "linewidth": 1.2}
TROCHOID: dict[str, Any] = {"color": style.ORANGE, "linewidth": 1.0, "linestyle": (0, (4, 2))}
PIN: dict[str, Any] = {"color": style.GREY, "linewidth": 0.6}
ARC: dict[str, Any] = {"color": style.BLACK, "linewidth": 1.4}
SIGMA: dict[str, Any] = {"color": style.VERMILION, "linewidth": 1.4}
DOT: dict[str, Any] = {"linestyle": "", "marker": "o", "markersize": 2.6}


def generation_figures(gear: CycloidGear) -> dict[str, Figure]:
    """Return the four figures by name."""
    figures = {"fig1_rolling": rolling_figure, "fig2_gear": gear_figure, "fig3_meshing": meshing_figure}
    return {name: draw(gear) for name, draw in (figures | {"fig4_ring": ring_figure}).items()}


@style.with_style
def rolling_figure(gear: CycloidGear) -> Figure:
    """Draw the pitch circles, the path of a pin's centre in the gear, and the gear's outline."""
    figure, overview, near = _pair()
    N, c, E, _ = gear.symbols
    t = np.linspace(0.0, 2 * np.pi, POINTS)
    for axes in (overview, near):
        axes.plot(*_mm(profile.trochoid(gear, t)), **TROCHOID)
        axes.plot(*_mm(profile.outline(gear, t)), **GEAR)
        axes.add_patch(Circle((0.0, 0.0), 1e3 * c * (N - 1), fill=False, color=style.GREEN, linewidth=0.9))
        axes.add_patch(Circle((0.0, -1e3 * c), 1e3 * c * N, fill=False, color=style.VERMILION, linewidth=0.9))
    pitch_point = (0.0, 1e3 * c * (N - 1))
    near.plot(*pitch_point, color=style.BLACK, **DOT)
    near.annotate("pitch point", pitch_point, xytext=(6, -12), textcoords="offset points", fontsize=7.5)
    for step in np.linspace(-1.0, 1.0, 9):
        centre = profile.trochoid(gear, step * 2 * np.pi / (N - 1))
        near.plot(
            *_mm(np.stack([centre, centre - gear.pin_radius * profile.normals(gear, step * 2 * np.pi / (N - 1))])),
            **PIN,
        )
    overview.set(xlim=_span(1.08e3 * E), ylim=_span(1.08e3 * E))
    near.set(xlim=(-8.5, 8.5), ylim=(33.5, 43.5))
    overview.set_title("Pitch circles, trochoid and gear")
    near.set_title("at +y (grey: rho along the normal)")
    entries = (
        ("ring's pitch circle, c N", {"color": style.VERMILION}),
        ("gear's, c (N\N{MINUS SIGN}1)", {"color": style.GREEN}),
        ("path of a pin's centre", TROCHOID),
        ("gear", GEAR),
    )
    figure.legend(handles=style.legend_handles(*entries), loc="outside lower center", ncols=4)
    return figure


@style.with_style
def gear_figure(gear: CycloidGear) -> Figure:
    """Draw the gear as the inner envelope of a pin in all its positions, and the gear's curvature along a lobe."""
    figure = style.create_figure(3.3)
    near, bend = figure.subplots(1, 2, width_ratios=[1.25, 1])
    lobe = 2 * np.pi / gear.lobes
    for turn in np.linspace(-lobe, lobe, 2 * 41 - 1):
        near.add_patch(Circle(tuple(1e3 * profile.trochoid(gear, turn)), 1e3 * gear.pin_radius, fill=False, **PIN))
    t = np.linspace(-1.4 * lobe, 1.4 * lobe, 1200)
    near.plot(*_mm(profile.trochoid(gear, t)), **TROCHOID)
    near.plot(*_mm(profile.outline(gear, t)), **GEAR)
    near.set(xlim=(-7.0, 7.0), ylim=(36.6, 44.2), aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
    near.set_title("A pin in all its positions in the gear")
    phase = np.linspace(0.0, np.pi, 400)
    bend.plot(np.degrees(phase), 1e-3 * profile.curvature(gear, -phase / gear.lobes), **GEAR)
    inflection = np.degrees(profile.inflection_phase(gear))
    bend.axhline(0.0, color=style.BLACK, linewidth=0.5)
    bend.axvline(inflection, color=style.GREY, linewidth=0.7, linestyle=":")
    bend.set(xlabel="phase of the contact [deg]: 0 valley, 180 tip", ylabel="curvature [1/mm]", xlim=(0, 180))
    bend.set_xticks(range(0, 181, 45))
    bend.set_title(f"Curvature (inflection at {inflection:.2f} deg)")
    entries = (("pin", PIN), ("path of its centre", TROCHOID), ("gear", GEAR))
    figure.legend(handles=style.legend_handles(*entries), loc="outside lower center", ncols=3)
    return figure


@style.with_style
def meshing_figure(gear: CycloidGear) -> Figure:
    """Draw the gear among its pins at one crank angle, with every contact and its normal through the pitch point."""
    figure, overview, near = _pair()
    N, _, E, rho = gear.symbols
    contacts = envelope.arc_contacts(gear, CRANK)
    pitch_point = N * kinematics.gear_centre(gear, CRANK)
    outline = _on_orbit(gear, CRANK)
    lines = np.stack([contacts.points, np.broadcast_to(pitch_point, contacts.points.shape)], axis=1)
    for axes in (overview, near):
        axes.add_collection(LineCollection(list(1e3 * lines), colors=style.GREY, linewidths=0.4))
        for centre in E * profile.unit(profile.pin_angles(gear)):
            axes.add_patch(Circle(tuple(1e3 * centre), 1e3 * rho, fill=False, color=style.BLACK, linewidth=0.8))
        axes.plot(*_mm(outline), **GEAR)
        axes.plot(*_mm(contacts.points), color=style.VERMILION, **DOT)
        axes.plot(*(1e3 * pitch_point), color=style.GREEN, **DOT)
    reach = 1.08e3 * (E + rho)
    overview.set(xlim=_span(reach), ylim=_span(reach))
    middle = 1e3 * pitch_point * 1.06
    near.set(xlim=middle[0] + _span(7.5), ylim=middle[1] + _span(7.5))
    overview.set_title(f"All {N} pins touch; crank at {np.degrees(CRANK):g} deg")
    near.set_title("about the pitch point, magnified")
    entries = (
        ("gear", GEAR),
        ("pins", {"color": style.BLACK, "linewidth": 0.8}),
        ("contact", {"color": style.VERMILION, **DOT}),
        ("common normals", {"color": style.GREY, "linewidth": 0.6}),
        ("pitch point", {"color": style.GREEN, **DOT}),
    )
    figure.legend(handles=style.legend_handles(*entries), loc="outside lower center", ncols=5)
    return figure


@style.with_style
def ring_figure(gear: CycloidGear) -> Figure:
    """Draw the internal gear as the outer envelope of the gear on its orbit, and where both touch."""
    figure, near, overview = _pair()
    ring = envelope.sample_ring(gear, POINTS)
    closed = np.concatenate([ring.points, ring.points[:1]])
    part = np.concatenate([ring.part, ring.part[:1]])
    swept = [_on_orbit(gear, angle) for angle in 2 * np.pi * np.arange(ORBIT) / ORBIT]
    nearby = [1e3 * outline[np.abs(np.arctan2(outline[:, 0], outline[:, 1])) < 0.2] for outline in swept]
    near.add_collection(LineCollection(nearby, colors="#C8D9E8", linewidths=0.25, rasterized=True))
    for axes in (near, overview):
        for names, look in ((("arc",), ARC), (("sigma1", "sigma2"), SIGMA)):
            shown = np.where(np.isin(part, names)[:, np.newaxis], closed, np.nan)
            axes.plot(*_mm(shown), **look)
    near.plot(*_mm(envelope.junction(gear)), color=style.GREEN, **DOT)
    near.set(xlim=(-5.2, 5.2), ylim=(37.2, 42.0))
    near.set_title("The gear's orbit sweeps the ring out")
    overview.plot(*_mm(_on_orbit(gear, CRANK)), **GEAR)
    for contacts, color in (
        (envelope.arc_contacts(gear, CRANK), style.BLACK),
        (envelope.sigma_contacts(gear, CRANK), style.VERMILION),
    ):
        overview.plot(*_mm(contacts.points), color=color, **DOT)
    middle = 1e3 * (gear.pin_circle_radius - gear.pin_radius) * np.array([-np.sin(CRANK), np.cos(CRANK)])
    overview.set(xlim=middle[0] + _span(9.0), ylim=middle[1] + _span(9.0))
    overview.set_title(f"where both touch; crank at {np.degrees(CRANK):g} deg")
    entries = (
        ("pins' arcs", ARC),
        ("second envelope", SIGMA),
        ("junctions", {"color": style.GREEN, **DOT}),
        ("gear", GEAR),
        ("gear on its orbit", {"color": "#C8D9E8"}),
    )
    figure.legend(handles=style.legend_handles(*entries), loc="outside lower center", ncols=5)
    return figure


def _pair() -> tuple[Figure, Axes, Axes]:
    figure = style.create_figure(3.7)
    left, right = figure.subplots(1, 2)
    for axes in (left, right):
        axes.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
    return figure, left, right


def _on_orbit(gear: CycloidGear, crank: float) -> Array:
    """Outline of the gear at a crank angle, in the ring's frame, shape (n, 2) [m]."""
    points = profile.outline(gear, np.linspace(0.0, 2 * np.pi, POINTS))
    turn = float(kinematics.gear_rotation(gear, crank))
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    return kinematics.gear_centre(gear, crank) + points @ rotation.T


def _mm(points: Array) -> Array:
    """Return the x and y coordinates of points (n, 2) in mm."""
    return 1e3 * points.T


def _span(reach: float) -> Array:
    return np.array([-reach, reach])
