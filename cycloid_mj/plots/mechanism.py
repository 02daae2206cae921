"""A drawing of the reducer in its plane, true to scale, with the forces on the gear where a run tells them."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, Patch, PathPatch
from matplotlib.path import Path

from cycloid_mj import kinematics
from cycloid_mj.design import Design
from cycloid_mj.modification import tooth_profile
from cycloid_mj.plots.style import BLACK, VERMILION, styled
from cycloid_mj.profile import unit
from cycloid_mj.record import Run
from cycloid_mj.solid import VISUAL_CHORD_ERROR, Prism, output_centres, parts, sleeve_core_radius
from cycloid_mj.types import Array

CRANK_ANGLE = math.radians(35.0)
"""Where the crank is drawn by default [rad]."""

LOOKS: dict[str, dict[str, Any]] = {
    "ring": {"facecolor": "#D9DFE4", "edgecolor": "#54606B"},
    "pins": {"facecolor": "#F3C969", "edgecolor": "#7A5A00"},
    "gear": {"facecolor": "#8DBFE3", "edgecolor": "#134A73"},
    "disc": {"facecolor": "#D3EBE3", "edgecolor": "none"},
    "output": {"facecolor": "#3FAF8B", "edgecolor": "#00543C"},
    "cam": {"facecolor": "#EDA77C", "edgecolor": "#8A3B00"},
    "shaft": {"facecolor": "#8B9199", "edgecolor": "#3B4046"},
}
FORCE: dict[str, Any] = {"color": VERMILION, "width": 0.0032, "angles": "xy", "scale_units": "xy", "zorder": 5}
LONGEST = 0.3
"""Length of the largest force on a pin, as a share of the housing's radius."""


@dataclass(frozen=True)
class Pose:
    """Where the parts are: crank, gear and output angle [rad], gear centre from the reducer's axis (2,) [m]."""

    crank_angle: float
    gear_centre: Array
    gear_angle: float
    output_angle: float


@styled
def mechanism(design: Design, run: Run | None = None, crank_angle: float | None = None) -> Figure:
    """Draw the ring, the gear with its holes, the output pins, the cam and the shaft.

    Parameters
    ----------
    design
        The design.
    run
        If given, the parts stand as in its last turn, and the forces on the gear are drawn as the run has them.
    crank_angle
        Crank angle [rad]; with a run, the nearest sample's, modulo a turn, and by default that of the last one.

    Raises
    ------
    DesignError
        A part cannot be made.
    LogError
        The run lacks a column of the motion.
    """
    figure = Figure(figsize=(6.5, 6.9), layout="constrained")
    axes = figure.subplots()
    sample = None if run is None else _sample(run, crank_angle)
    if run is None or sample is None:
        pose = _ideal_pose(design, CRANK_ANGLE if crank_angle is None else crank_angle)
    else:
        pose = _measured_pose(run, sample)
    _draw_parts(axes, design, pose)
    _draw_motion(axes, design, pose)
    if run is not None and sample is not None:
        _draw_forces(axes, design, pose, {name: float(values[sample]) for name, values in run.columns.items()})
        axes.set_title(
            f"crank at {math.degrees(pose.crank_angle) % 360:.1f} deg, {run.time[sample]:.4f} s", loc="center"
        )
    reach = 1.02e3 * design.housing.outer_radius
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    axes.axis("off")
    figure.legend(handles=_legend(design), loc="outside lower center", ncols=6, handlelength=1.2, columnspacing=1.4)
    return figure


def _ideal_pose(design: Design, crank_angle: float) -> Pose:
    gear = tooth_profile(design)
    turn = float(kinematics.gear_rotation(gear, crank_angle))
    return Pose(crank_angle, kinematics.gear_centre(gear, crank_angle), turn, turn)


def _sample(run: Run, crank_angle: float | None) -> int:
    """Give the sample of the last turn that is nearest to a crank angle, modulo a turn."""
    angle = run["crank_angle"]
    if crank_angle is None:
        return len(run) - 1
    away = np.abs((angle - crank_angle + np.pi) % (2 * np.pi) - np.pi)
    last_turn = np.abs(angle[-1] - angle) < 2 * np.pi
    return int(np.argmin(np.where(last_turn, away, np.inf)))


def _measured_pose(run: Run, sample: int) -> Pose:
    crank, x, y, gear, output = (
        float(run[name][sample]) for name in ("crank_angle", "gear_x", "gear_y", "gear_angle", "output_angle")
    )
    return Pose(crank, np.array([x, y]), gear, output)


def _draw_parts(axes: Axes, design: Design, pose: Pose) -> None:
    """Draw from the back to the front; the output disc shows through the holes of the gear."""
    solids = parts(design, VISUAL_CHORD_ERROR)
    axis = np.zeros(2)
    disc = float(np.linalg.norm(solids["output"].prisms[0].outline, axis=1).max())
    _region(axes, solids["housing"].prisms[0], "ring", axis, 0.0)
    for centre in _ring_centres(design):
        _disc(axes, centre, design.ring.pin_radius, "pins")
        if design.ring.has_sleeves:
            _disc(axes, centre, sleeve_core_radius(design), "ring")
    _disc(axes, axis, disc, "disc")
    _region(axes, solids["gear"].prisms[0], "gear", pose.gear_centre, pose.gear_angle)
    for centre in _turned(output_centres(design), pose.output_angle):
        _disc(axes, centre, design.output.pin_radius, "output")
    _disc(axes, kinematics.gear_centre(tooth_profile(design), pose.crank_angle), design.gear.bore_radius, "cam")
    _disc(axes, axis, design.shaft.radius, "shaft")


def _draw_motion(axes: Axes, design: Design, pose: Pose) -> None:
    """Mark the axis, the gear's centre and hole 1, and show which way crank and gear turn."""
    direction = math.copysign(1.0, design.drive.speed)
    centre = 1e3 * pose.gear_centre
    axes.plot(0.0, 0.0, marker="+", markersize=9, color="white", markeredgewidth=1.0)
    axes.plot(*centre, marker="o", markersize=2.5, color="white")
    ring, output = design.ring, design.output
    between = (ring.pin_circle_radius - ring.pin_radius + output.pin_circle_radius + output.hole_radius) / 2
    start = math.pi / 2 + pose.crank_angle
    _turning(axes, np.zeros(2), (design.shaft.radius + design.gear.bore_radius) / 2, start, 1.9 * direction)
    _turning(axes, centre, between - design.gear.eccentricity / 2, math.pi / 2 + 0.25 * direction, -0.5 * direction)


def _draw_forces(axes: Axes, design: Design, pose: Pose, values: Mapping[str, float]) -> None:
    """Draw the forces of ring and output pins on the gear to one scale; the cam's balances them."""
    pins = list(_pin_forces(design, pose, values))
    if not pins:
        return
    contact, force = (np.array(column) for column in zip(*pins, strict=True))
    largest = float(np.linalg.norm(force, axis=1).max())
    scale = largest / (LONGEST * 1e3 * design.housing.outer_radius)
    arrows = axes.quiver(*(1e3 * contact.T), *force.T, scale=scale, **FORCE)
    power = 10.0 ** math.floor(math.log10(largest))
    reference = power * max(step for step in (1.0, 2.0, 5.0) if step * power <= largest)
    axes.quiverkey(arrows, 0.1, 0.05, reference, f"{reference:g} N", labelpos="N", labelcolor=VERMILION)


def _pin_forces(design: Design, pose: Pose, values: Mapping[str, float]) -> Iterator[tuple[Array, Array]]:
    """Give contact (2,) [m] and force on the gear (2,) [N] of each loaded ring pin and output pin in the run."""
    ring = ((f"pin_{i}", centre, design.ring.pin_radius) for i, centre in enumerate(_ring_centres(design), start=1))
    turned = _turned(output_centres(design), pose.output_angle)
    output = ((f"output_pin_{i}", centre, design.output.pin_radius) for i, centre in enumerate(turned, start=1))
    for name, centre, radius in (*ring, *output):
        force = np.array([values.get(f"{name}_force_x", 0.0), values.get(f"{name}_force_y", 0.0)])
        size = math.hypot(*force)
        if size > 0:
            yield centre + radius * force / size, force


def _ring_centres(design: Design) -> Array:
    """Centres of the ring's pins (N, 2) [m]; none for an internal gear."""
    if design.ring.kind != "pin":
        return np.empty((0, 2))
    return design.ring.pin_circle_radius * unit(2 * np.pi * np.arange(design.ring.teeth) / design.ring.teeth)


def _region(axes: Axes, prism: Prism, part: str, centre: Array, angle: float) -> None:
    """Draw a region with its holes, turned and moved."""
    rings = [1e3 * (centre + _turned(ring, angle)) for ring in (prism.outline, *(hole[::-1] for hole in prism.holes))]
    path = Path.make_compound_path(*(Path(np.vstack([ring, ring[:1]]), closed=True) for ring in rings))
    axes.add_patch(PathPatch(path, linewidth=0.7, joinstyle="round", **LOOKS[part]))


def _disc(axes: Axes, centre: Array, radius: float, part: str) -> None:
    axes.add_patch(Circle((1e3 * centre[0], 1e3 * centre[1]), 1e3 * radius, linewidth=0.7, **LOOKS[part]))


def _turning(axes: Axes, centre: Array, radius: float, start: float, sweep: float) -> None:
    """Draw an arc with an arrow head, angles counter-clockwise from +x [rad], radius [m], centre [mm]."""
    angle = np.linspace(start, start + sweep, 60)
    arc = centre + 1e3 * radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    look: dict[str, Any] = {"arrowstyle": "-|>", "mutation_scale": 10.0, "color": BLACK, "linewidth": 1.2}
    axes.add_patch(FancyArrowPatch(path=Path(arc), **look))


def _turned(points: Array, angle: float) -> Array:
    """Turn points (n, 2) counter-clockwise about the origin."""
    cos, sin = math.cos(angle), math.sin(angle)
    return points @ np.array([[cos, sin], [-sin, cos]])


def _legend(design: Design) -> list[Patch]:
    pinned = design.ring.kind == "pin"
    names = {"ring": "pinwheel" if pinned else "internal gear", "pins": "ring pins" if pinned else ""}
    names |= {"gear": "cycloid gear", "output": "output pins", "cam": "cam", "shaft": "input shaft"}
    return [Patch(label=name, linewidth=0.7, **LOOKS[part]) for part, name in names.items() if name]
