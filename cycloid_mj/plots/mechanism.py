"""A drawing of the mechanism to scale, with the forces on the discs of a run."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, Patch, PathPatch
from matplotlib.path import Path

from cycloid_mj.base.array import Array
from cycloid_mj.base.names import HOUSING, OUTPUT, SHAFT, gears, planar_joints
from cycloid_mj.base.record import Run
from cycloid_mj.geometry import kinematics
from cycloid_mj.parts import VISUAL_CHORD_ERROR, Prism, output_centres, parts, pin_radius, sleeve_core_radius
from cycloid_mj.plots.style import BLACK, BLUE, GREEN, PURPLE, VERMILION, NotebookFigure, with_style
from cycloid_mj.reducer import Reducer
from cycloid_mj.scene import ContactForces, cams, contact_forces, poses, ring_places, transform

CRANK_ANGLE = math.radians(35.0)
"""Default crank angle [rad]."""

PART_STYLES: dict[str, dict[str, Any]] = {
    "ring": {"facecolor": "#D9DFE4", "edgecolor": "#54606B"},
    "pins": {"facecolor": "#F3C969", "edgecolor": "#7A5A00"},
    "gear": {"facecolor": "#8DBFE3", "edgecolor": "#134A73"},
    "disc": {"facecolor": "#D3EBE3", "edgecolor": "none"},
    "output": {"facecolor": "#3FAF8B", "edgecolor": "#00543C"},
    "cam": {"facecolor": "#EDA77C", "edgecolor": "#8A3B00"},
    "shaft": {"facecolor": "#8B9199", "edgecolor": "#3B4046"},
}
"""Part -> properties of the patch with which it is drawn."""
FRONT_OPACITY = 0.55
"""Opacity of discs and cams in front of others."""

DISC_COLOURS = (VERMILION, BLUE, GREEN, PURPLE)
"""Colours of the forces on each disc."""

FORCE: dict[str, Any] = {"width": 0.0032, "angles": "xy", "scale_units": "xy", "zorder": 5}
MAX_ARROW = 0.3
"""Length of the largest force arrow, relative to the outer radius of the housing."""


@with_style
def mechanism(reducer: Reducer, run: Run | None = None, crank_angle: float | None = None) -> Figure:
    """Draw ring, discs, output pins, cam and shaft to scale; with a `run`, also the contact forces on the discs.

    Parameters
    ----------
    reducer
        The reducer.
    run
        Run that determines the poses and forces; without it, the ideal mechanism is drawn without forces.
    crank_angle
        Crank angle [rad]; by default `CRANK_ANGLE`. With a run, the nearest sample of its last turn is drawn, and by
        default its last sample.
    """
    figure = NotebookFigure(figsize=(6.5, 6.9), layout="constrained")
    axes = figure.subplots()
    if run is None:
        columns = _ideal_columns(reducer, CRANK_ANGLE if crank_angle is None else crank_angle)
    else:
        sample = _nearest_sample(run, crank_angle)
        columns = {name: values[sample : sample + 1] for name, values in run.columns.items()}
        degrees = math.degrees(float(columns["crank_angle"][0])) % 360
        axes.set_title(f"crank angle {degrees:.1f} deg, {run.time[sample]:.4f} s", loc="center")
    pose = {part: values[0] for part, values in poses(reducer, columns).items()}
    _draw_parts(axes, reducer, pose)
    _draw_motion(axes, reducer, pose)
    _draw_forces(axes, reducer, contact_forces(reducer, columns).of("pin_gear", "tooth", "output"))
    axis_limit = 1.02e3 * reducer.design.housing.outer_radius
    axes.set(xlim=(-axis_limit, axis_limit), ylim=(-axis_limit, axis_limit), aspect="equal")
    axes.axis("off")
    has_force_colours = run is not None and reducer.design.gear.discs > 1
    figure.legend(
        handles=_list_legend(reducer, has_force_colours),
        loc="outside lower center",
        ncols=6,
        handlelength=1.2,
        columnspacing=1.4,
    )
    return figure


def _ideal_columns(reducer: Reducer, crank_angle: float) -> dict[str, Array]:
    """Return the log columns that `poses` needs, such as ``crank_angle``, one sample each, for the ideal mechanism.

    `crank_angle` is in [rad].
    """
    design = reducer.design
    gear, angle = reducer.tooth_profile, np.array([crank_angle])
    turn = reducer.member.gear_angle(angle)
    columns = {"crank_angle": angle, "output_angle": reducer.member.output_angle(angle)}
    for name, phase in zip(gears(design.gear.discs), reducer.phases, strict=True):
        columns |= dict(zip(planar_joints(name), (*kinematics.gear_centre(gear, angle + phase).T, turn), strict=True))
    return columns


def _nearest_sample(run: Run, crank_angle: float | None) -> int:
    """Return the index of the last turn's sample that is nearest to a crank angle [rad]; for None, the last index."""
    angle = run["crank_angle"]
    if crank_angle is None:
        return len(run) - 1
    distance = np.abs((angle - crank_angle + np.pi) % (2 * np.pi) - np.pi)
    is_in_last_turn = np.abs(angle[-1] - angle) < 2 * np.pi
    return int(np.argmin(np.where(is_in_last_turn, distance, np.inf)))


def _draw_parts(axes: Axes, reducer: Reducer, pose: Mapping[str, Array]) -> None:
    """Draw the parts from back to front at the poses of a sample; discs in front of others are translucent.

    `pose` has x [m], y [m] and angle [rad] of each part by name, shape (3,).
    """
    design = reducer.design
    solids = parts(reducer, VISUAL_CHORD_ERROR)
    axis = np.zeros(3)
    output_disc_radius = float(np.linalg.norm(solids[OUTPUT].prisms[0].outline, axis=1).max())
    draw_region(axes, solids[HOUSING].prisms[0], "ring", axis)
    draw_ring_pins(axes, reducer)
    draw_disc(axes, axis, output_disc_radius, "disc")
    for disc, part in enumerate(gears(design.gear.discs)):
        draw_region(axes, solids[part].prisms[0], "gear", pose[part], 1.0 if disc == 0 else FRONT_OPACITY)
    draw_output_pins(axes, reducer, transform(pose[OUTPUT], output_centres(reducer)))
    for disc, cam_pose in enumerate(cams(reducer, pose[SHAFT][np.newaxis])[0]):
        draw_disc(axes, cam_pose, design.gear.bore_radius, "cam", 1.0 if disc == 0 else FRONT_OPACITY)
    draw_disc(axes, axis, design.shaft.radius, "shaft")


def draw_ring_pins(axes: Axes, reducer: Reducer) -> None:
    """Draw the ring pins, with the cores of sleeves; an internal gear has none."""
    ring = reducer.design.ring
    for centre in ring_places(reducer) if ring.kind == "pin" else ():
        draw_disc(axes, centre, ring.pin_radius, "pins")
        if ring.has_sleeves:
            draw_disc(axes, centre, sleeve_core_radius(reducer), "ring")


def draw_output_pins(axes: Axes, reducer: Reducer, centres: Array) -> None:
    """Draw the output pins at their centres [m], shape (pins, 2), with the cores of rollers."""
    output = reducer.design.output
    for centre in centres:
        draw_disc(axes, centre, output.pin_radius, "output")
        if output.has_roller_parts:
            draw_disc(axes, centre, pin_radius(reducer), "output")


def _draw_motion(axes: Axes, reducer: Reducer, pose: Mapping[str, Array]) -> None:
    """Mark the axis and the centres of the discs, and draw arrows for the rotation of crank and front disc.

    `pose` has x [m], y [m] and angle [rad] of each part by name, shape (3,). The arrows point in opposite directions.
    """
    design = reducer.design
    direction = math.copysign(1.0, design.drive.speed)
    centres = [1e3 * pose[gear][:2] for gear in gears(design.gear.discs)]
    centre = centres[-1]
    axes.plot(0.0, 0.0, marker="+", markersize=9, color="white", markeredgewidth=1.0)
    for disc_centre in centres:
        axes.plot(*disc_centre, marker="o", markersize=2.5, color="white")
    ring, output = design.ring, design.output
    radius = (ring.pin_circle_radius - ring.pin_radius + output.pin_circle_radius + output.hole_radius) / 2
    start = math.pi / 2 + pose[SHAFT][2]
    _rotation_arrow(axes, np.zeros(2), (design.shaft.radius + design.gear.bore_radius) / 2, start, 1.9 * direction)
    _rotation_arrow(
        axes, centre, radius - design.gear.eccentricity / 2, math.pi / 2 + 0.25 * direction, -0.5 * direction
    )


def _draw_forces(axes: Axes, reducer: Reducer, contacts: ContactForces) -> None:
    """Draw the forces of ring and output pins on the discs as arrows with a common scale, in a colour for each disc.

    Only the first sample of `contacts` is drawn. Contacts without force have no arrow. The longest arrow has the length
    `MAX_ARROW` times the housing's radius; a reference arrow states the scale [N].
    """
    has_force = contacts.size[0] > 0.0
    if not has_force.any():
        return
    largest_force, disc_indices = float(contacts.size.max()), np.array(contacts.discs)
    scale = largest_force / (MAX_ARROW * 1e3 * reducer.design.housing.outer_radius)
    for disc in range(reducer.design.gear.discs):
        is_drawn, colour = has_force & (disc_indices == disc), DISC_COLOURS[disc]
        points, forces = 1e3 * contacts.point[0, is_drawn].T, contacts.force[0, is_drawn].T
        arrows = axes.quiver(*points, *forces, scale=scale, color=colour, **FORCE)
    power_of_ten = 10.0 ** math.floor(math.log10(largest_force))
    reference_force = power_of_ten * max(factor for factor in (1.0, 2.0, 5.0) if factor * power_of_ten <= largest_force)
    axes.quiverkey(
        arrows, 0.1, 0.05, reference_force, f"{reference_force:g} N", labelpos="N", labelcolor=DISC_COLOURS[disc]
    )


def draw_region(axes: Axes, prism: Prism, part: str, pose: Array, opacity: float = 1.0) -> None:
    """Draw the outline and the holes of a prism in mm, at a `pose` (3,): x [m], y [m] and angle [rad].

    `part` is the key of the part's style in `PART_STYLES`, such as "ring"; `opacity` is that of its fill, 0 to 1.
    """
    contours = [1e3 * transform(pose, contour) for contour in (prism.outline, *(hole[::-1] for hole in prism.holes))]
    path = Path.make_compound_path(*(Path(np.vstack([contour, contour[:1]]), closed=True) for contour in contours))
    axes.add_patch(PathPatch(path, linewidth=0.7, joinstyle="round", **_part_style(part, opacity)))


def draw_disc(axes: Axes, centre: Array, radius: float, part: str, opacity: float = 1.0) -> None:
    """Draw a filled circle of a radius [m] about a centre [m], in mm.

    `part` is the key of the part's style in `PART_STYLES`, and `opacity` is the opacity of the fill, 0 to 1.
    """
    patch_style = _part_style(part, opacity)
    axes.add_patch(Circle((1e3 * centre[0], 1e3 * centre[1]), 1e3 * radius, linewidth=0.7, **patch_style))


def _part_style(part: str, opacity: float) -> dict[str, Any]:
    """Return the style of a part with an opacity of its fill."""
    patch_style = PART_STYLES[part]
    return patch_style if opacity == 1.0 else patch_style | {"facecolor": (patch_style["facecolor"], opacity)}


def _rotation_arrow(axes: Axes, centre: Array, radius: float, start: float, sweep: float) -> None:
    """Draw an arc with an arrow head; `centre` (2,) is in [mm], the unit of the axes, and `radius` in [m].

    The arc begins at the angle `start` [rad], counter-clockwise from +x. It covers the angle `sweep` [rad], clockwise
    if negative.
    """
    angle = np.linspace(start, start + sweep, 60)
    arc = centre + 1e3 * radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    patch_style: dict[str, Any] = {"arrowstyle": "-|>", "mutation_scale": 10.0, "color": BLACK, "linewidth": 1.2}
    axes.add_patch(FancyArrowPatch(path=Path(arc), **patch_style))


def _list_legend(reducer: Reducer, with_forces: bool) -> list[Patch]:
    """Return the legend of the parts of a mechanism and, if `with_forces` is True, of the forces on each disc."""
    has_pins = reducer.design.ring.kind == "pin"
    names = {"ring": "ring" if has_pins else "internal gear", "pins": "ring pins" if has_pins else ""}
    names |= {"gear": "cycloid disc", "output": "output pins", "cam": "cam", "shaft": "input shaft"}
    parts = [Patch(label=name, linewidth=0.7, **PART_STYLES[part]) for part, name in names.items() if name]
    disc_count = reducer.design.gear.discs if with_forces else 0
    return parts + [Patch(label=f"force on disc {disc + 1}", color=DISC_COLOURS[disc]) for disc in range(disc_count)]
