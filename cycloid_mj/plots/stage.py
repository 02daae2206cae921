"""The figure of an animation: moving parts, force arrows, and bars of the load on the ring."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Affine2D

from cycloid_mj.analysis import condition
from cycloid_mj.base.array import Array
from cycloid_mj.base.names import CRANK_BEARING, GEAR, OUTPUT, SHAFT
from cycloid_mj.geometry.envelope import sample_ring_by_sagitta
from cycloid_mj.geometry.kinematics import gear_centre
from cycloid_mj.parts import Prism, circle, gear_solid, housing_solid
from cycloid_mj.parts.accuracy import SCREEN_CHORD_ERROR
from cycloid_mj.parts.gear import tooth_profile
from cycloid_mj.parts.polygon import arc
from cycloid_mj.parts.rv import rv_parts
from cycloid_mj.plots.mechanism import MAX_ARROW, PART_STYLES
from cycloid_mj.plots.rv_stage import closed_path, draw_circle, draw_dashed, draw_rv_parts, move_rv_parts
from cycloid_mj.plots.style import BLACK, BLUE, VERMILION
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.reducer.sockets import socket_half_angle
from cycloid_mj.scene import ContactForces, Drawing, RvDrawing, ring_outline
from cycloid_mj.scene.drawing import MeshDrawing, Radii
from cycloid_mj.scene.pose import ring_places

WIDTH, HEIGHT = 6.4, 8.0
"""Size of the figure [in]."""

FORCES = {
    "pin_gear": ("ring pins", VERMILION),
    "tooth": ("internal gear", VERMILION),
    "cam": ("cam", BLACK),
    "output": ("output pins", BLUE),
    CRANK_BEARING: ("cranks", BLUE),
}
RING = ("pin_gear", "tooth")
PIN, SOCKET, OTHER_DISCS = "pin", "socket", "other_discs"
DARK = {"color": "#3B4046"}
SOCKET_STYLE = {"facecolor": "white", "edgecolor": PART_STYLES["ring"]["edgecolor"], "zorder": 1.2}


@dataclass(frozen=True, eq=False)
class AnimatedFigure:
    """The figure of an animation, and its artists that change from picture to picture.

    Attributes
    ----------
    figure, axes
        The figure, and its axes with the mechanism [mm].
    clock
        Text with crank angle and time.
    parts
        By name of the part a list with an entry for each copy (such as each pin): its artists, which move together.
    housing
        Patch of the housing or internal gear.
    arrows
        Kind of contact -> its force arrows.
    bars, ideal_steps
        Bars of the forces on the ring, and their closed form; None without such forces.
    """

    figure: Figure
    axes: Axes
    clock: Any
    parts: Mapping[str, list[Any]]
    housing: Any
    arrows: Mapping[str, Any]
    bars: Any
    ideal_steps: Any


@dataclass(frozen=True, eq=False)
class Script:
    """The motion and the forces in the n pictures of an animation.

    Attributes
    ----------
    reducer
        The reducer.
    drawn
        Positions of all parts: a `Drawing`, or an `RvDrawing` of an RV reducer.
    acting
        Contact forces.
    ideal
        Force on each ring pin by the closed form [N], shape (n, N); None for an internal gear.
    """

    reducer: Reducer
    drawn: Drawing | RvDrawing
    acting: ContactForces
    ideal: Array | None


def create_stage(script: Script, width: int) -> AnimatedFigure:
    """Draw the first picture of an animation; return it with the drawn elements that later pictures change.

    `script` has the motion and the forces of all pictures.
    `width` is the width of the figure [pixels].
    """
    reducer, forces = script.reducer, script.acting
    figure = Figure(figsize=(WIDTH, HEIGHT), dpi=width / WIDTH)
    axes = figure.add_axes((0.02, 0.262, 0.96, 0.7), aspect="equal")
    axis_limit = 1.02e3 * reducer.design.housing.outer_radius
    axes.set(xlim=(-axis_limit, axis_limit), ylim=(-axis_limit, axis_limit))
    axes.axis("off")
    housing = _draw_housing(axes, reducer)
    parts = _draw_parts(axes, reducer, script.drawn)
    arrows = {kind: _draw_arrows(axes, reducer, forces.of(kind)) for kind in FORCES if kind in forces.kinds}
    figure.text(0.025, 0.972, _title(reducer, script.drawn), fontsize=9.5, weight="bold")
    condition_lines = (str(condition(reducer)), *_view_words(script.drawn, reducer))
    figure.text(0.025, 0.961, "\n".join(condition_lines), fontsize=8.5, va="top")
    clock = figure.text(0.975, 0.972, "", fontsize=9.5, ha="right", family="DejaVu Sans Mono")
    _add_legend(figure, forces)
    bars, ideal_line = _draw_load_bars(figure, forces.of(*RING), script.ideal)
    return AnimatedFigure(figure, axes, clock, parts, housing, arrows, bars, ideal_line)


def update_stage(stage: AnimatedFigure, script: Script, row: int) -> None:
    """Change the figure `stage` to the picture `row` of an animation: move the parts, force arrows and load bars.

    `script` has the motion and the forces of all pictures.
    """
    poses = script.drawn
    _move_part(stage, GEAR, [poses.gear[row]])
    _move_part(stage, OTHER_DISCS, _other_disc_poses(script, row))
    if isinstance(poses, RvDrawing):
        move_rv_parts(partial(_move_part, stage), poses, row)
    else:
        _move_part(stage, SHAFT, [poses.shaft[row]])
        _move_part(stage, OUTPUT, poses.output_pins[row])
    socket_angles = np.arctan2(*ring_places(script.reducer).T[::-1])
    _move_part(stage, SOCKET, np.column_stack([poses.sockets[row], socket_angles]))
    _move_part(stage, PIN, np.column_stack([poses.ring[row], poses.gaps.pin_angle[row]]))
    if script.reducer.design.ring.kind != "pin":
        _update_ring(stage.housing, script, row)
    _update_forces(stage, script, row)


def _move_part(stage: AnimatedFigure, part: str, poses: Any) -> None:
    """Move copies of a part to poses, shape (copies, 2 or 3): x [m], y [m] and optionally an angle [rad]."""
    for artists, (x, y, *angle) in zip(stage.parts[part], poses, strict=False):
        transform = Affine2D().rotate(*(angle or [0.0])).translate(1e3 * x, 1e3 * y) + stage.axes.transData
        for artist in artists:
            artist.set_transform(transform)


def _update_forces(stage: AnimatedFigure, script: Script, row: int) -> None:
    """Set the force arrows and load bars of `stage` to the contact forces in picture `row` of an animation.

    `script` has the forces of all pictures. Contacts without force have no arrow.
    """
    for kind, arrows in stage.arrows.items():
        forces = script.acting.of(kind)
        arrows.set_offsets(1e3 * forces.point[row])
        is_unloaded = forces.size[row] <= 0.0
        arrows.set_UVC(*(np.ma.masked_array(component, is_unloaded) for component in forces.force[row].T))
    if stage.bars is not None:
        for bar, force_size in zip(stage.bars, script.acting.of(*RING).size[row], strict=True):
            bar.set_height(force_size)
    if stage.ideal_steps is not None and script.ideal is not None:
        stage.ideal_steps.set_data(script.ideal[row])


def _title(reducer: Reducer, poses: MeshDrawing) -> str:
    """Return the name of the design and the magnification of clearances."""
    return reducer.design.name + (
        f",  clearances magnified {poses.magnification:g} times" if poses.magnification > 1 else ""
    )


def _view_words(poses: MeshDrawing, reducer: Reducer) -> tuple[str, ...]:
    """Return lines of text: which of several discs is shown with its forces, and the reference frame of the view."""
    disc = (f"disc {poses.gaps.disc + 1},", "others dashed") if reducer.design.gear.discs > 1 else ()
    return (*disc, "seen from the ring") if reducer.design.output.turns_ring else disc


def _other_discs(reducer: Reducer, disc: int) -> list[int]:
    return [other for other in range(reducer.design.gear.discs) if other != disc]


def _other_disc_poses(script: Script, row: int) -> list[Array]:
    """Return the ideal poses of the other discs, drawn as dashed outlines, in picture `row` of an animation.

    `script` has the motion of all parts. The other discs are all but the disc that is shown with its forces. A pose has
    shape (3,): x [m], y [m] and angle [rad].
    """
    gaps, profile, phases = script.drawn.gaps, script.reducer.tooth_profile, script.reducer.phases
    crank_angle, disc_angle = gaps.crank_angle[row], gaps.gear[row, 2]
    return [
        np.array([*gear_centre(profile, crank_angle + phases[other]), disc_angle])
        for other in _other_discs(script.reducer, gaps.disc)
    ]


def _draw_housing(axes: Axes, reducer: Reducer) -> Any:
    """Draw the housing, and return its patch: a plain ring below the pins and sockets, or the internal gear."""
    prism = housing_solid(reducer, SCREEN_CHORD_ERROR).prisms[0]
    hole = prism.holes[0]
    if reducer.design.ring.kind == "pin":
        hole = circle(float(np.linalg.norm(hole, axis=1).min()), SCREEN_CHORD_ERROR)
    return _draw_region(axes, [prism.outline, hole[::-1]], "ring", 1)


def _update_ring(housing: Any, script: Script, row: int) -> None:
    """Set the outline of an internal gear, the artist `housing`, to that in picture `row` of an animation."""
    ring_samples = sample_ring_by_sagitta(script.reducer.tooth_profile, SCREEN_CHORD_ERROR)
    hole = ring_outline(script.reducer, ring_samples.points, ring_samples.normals, script.drawn, row)
    outline = circle(script.reducer.design.housing.outer_radius, SCREEN_CHORD_ERROR)
    housing.set_path(closed_path([outline, hole]))


def _draw_parts(axes: Axes, reducer: Reducer, drawing: Drawing | RvDrawing) -> dict[str, list[Any]]:
    """Draw the parts from back to front, each in its own coordinates, and return their artists.

    Dots on disc and shaft show their rotation. `drawing` is that of the whole animation: only its radii and the shown
    disc are used. The result has a list for each part name: for every copy of the part, such as each pin, the list of
    the artists that move together.
    """
    design = reducer.design
    ring, radii, disc = design.ring, drawing.radii, drawing.gaps.disc
    has_pins = design.ring.kind == "pin"
    prism = _disc_prism(reducer, disc)
    disc_dot = (0.0, *_rotation_dot(reducer))
    shared_parts: dict[str, list[Any]] = {
        SOCKET: [
            [_draw_socket(axes, radii.socket, socket_half_angle(design))]
            for _ in range(ring.has_sockets * ring.mate_count)
        ],
        PIN: [_draw_pin(axes, radii.pin) for _ in range(has_pins * ring.mate_count)],
        GEAR: [
            [
                _draw_region(axes, [prism.outline, *(hole[::-1] for hole in prism.holes)], "gear", 1.5),
                draw_circle(axes, disc_dot, DARK, 3),
            ]
        ],
        OTHER_DISCS: [[_dashed_outline(axes, reducer, other)] for other in _other_discs(reducer, disc)],
    }
    if isinstance(drawing, RvDrawing):
        return shared_parts | draw_rv_parts(axes, cast(RvReducer, reducer), drawing)
    return shared_parts | _draw_central_parts(axes, reducer, drawing.radii, disc)


def _draw_central_parts(axes: Axes, reducer: Reducer, radii: Radii, disc: int) -> dict[str, list[Any]]:
    """Draw output pins and crank of a reducer with a central crank, each in its own coordinates; return the artists.

    `radii` are those with which parts are drawn, and `disc` is the index of the visible disc. The result has a list for
    each kind of part: for every copy of the part, the list of the artists that move together.
    """
    design = reducer.design
    output, gear = design.output, design.gear
    cam_x, cam_y = gear_centre(tooth_profile(design), reducer.phases[disc])
    return {
        OUTPUT: [
            [draw_circle(axes, (0.0, 0.0, radii.output_pin), PART_STYLES["output"], 3)] for _ in range(output.pins)
        ],
        SHAFT: [
            [
                draw_circle(axes, (float(cam_x), float(cam_y), radii.cam), PART_STYLES["cam"], 3),
                draw_circle(axes, (0.0, 0.0, design.shaft.radius), PART_STYLES["shaft"], 3),
                draw_circle(axes, (0.0, 0.8 * gear.bore_radius, 0.06 * gear.bore_radius), DARK, 3),
            ]
        ],
    }


def _dashed_outline(axes: Axes, reducer: Reducer, disc: int) -> Any:
    """Draw the outline of the disc with the index `disc` as a dashed line, in its own coordinates; return its patch."""
    return draw_dashed(axes, _disc_prism(reducer, disc).outline, PART_STYLES["gear"]["edgecolor"])


def _disc_prism(reducer: Reducer, disc: int) -> Prism:
    """Return the disc with an index as a prism."""
    if isinstance(reducer, RvReducer):
        return rv_parts(reducer)[reducer.gears[disc]].solid(SCREEN_CHORD_ERROR).prisms[0]
    return gear_solid(reducer, SCREEN_CHORD_ERROR, disc).prisms[0]


def _rotation_dot(reducer: Reducer) -> tuple[float, float]:
    """Return distance from the centre and radius [m] of the dot that marks the rotation of a disc.

    The dot is on +y, between a hole or crank bore and a valley of the teeth.
    """
    ring, output, gear = reducer.design.ring, reducer.design.output, reducer.design.gear
    valley_radius = ring.pin_circle_radius - ring.pin_radius - gear.eccentricity
    if isinstance(reducer, RvReducer):
        hole_edge_radius = reducer.crank_radius + reducer.bore_radius
        return 0.5 * (valley_radius + hole_edge_radius), 0.2 * (valley_radius - hole_edge_radius)
    return 0.5 * (valley_radius + output.pin_circle_radius + output.hole_radius), 0.2 * output.pin_radius


def _draw_socket(axes: Axes, radius: float, half_angle: float) -> Any:
    """Draw the arc of a socket, radius [m] and half angle [rad] about +x, which points outward; return its patch."""
    return axes.add_patch(
        PathPatch(Path(1e3 * arc(radius, -half_angle, half_angle, SCREEN_CHORD_ERROR)), linewidth=0.6, **SOCKET_STYLE)
    )


def _draw_pin(axes: Axes, radius: float) -> list[Any]:
    """Draw a pin of a radius [m] with a line that shows its rotation; return both artists."""
    (line,) = axes.plot(
        [0.0, 0.8e3 * radius], [0.0, 0.0], color=PART_STYLES["pins"]["edgecolor"], linewidth=0.8, zorder=2.1
    )
    return [draw_circle(axes, (0.0, 0.0, radius), PART_STYLES["pins"], 2), line]


def _draw_region(axes: Axes, rings: Sequence[Array], patch_style: str, order: float) -> Any:
    return axes.add_patch(
        PathPatch(closed_path(rings), linewidth=0.6, joinstyle="round", zorder=order, **PART_STYLES[patch_style])
    )


def _draw_arrows(axes: Axes, reducer: Reducer, forces: ContactForces) -> Any:
    """Draw and return the force arrows of one kind of contact in the first frame, with their tips at the contacts.

    The largest force of all frames has an arrow of `MAX_ARROW` times the housing's radius.
    """
    largest_force = max(float(forces.size.max(initial=0.0)), 1e-9)
    return axes.quiver(
        *(1e3 * forces.point[0]).T,
        *forces.force[0].T,
        color=FORCES[forces.kinds[0]][1],
        pivot="tip",
        angles="xy",
        scale_units="xy",
        scale=largest_force / (MAX_ARROW * 1e3 * reducer.design.housing.outer_radius),
        units="width",
        width=0.005,
        minlength=0.1,
        zorder=5,
    )


def _add_legend(figure: Figure, forces: ContactForces) -> None:
    """Add a legend of the force arrows, with the largest force [N] of each kind of contact over all frames.

    `figure` is the picture, `forces` are the contact forces.
    """
    entries = [
        Patch(color=colour, label=f"{name}: at most {forces.of(kind).size.max():.4g} N")
        for kind, (name, colour) in FORCES.items()
        if kind in forces.kinds
    ]
    if entries:
        title = "forces on the disc (separate scale for each kind)"
        legend_position: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.5, 0.262)}
        figure.legend(
            handles=entries, ncols=len(entries), title=title, title_fontsize=8.0, handlelength=1.2, **legend_position
        )


def _draw_load_bars(figure: Figure, ring: ContactForces, ideal: Array | None) -> tuple[Any, Any]:
    """Draw the force on each pin or lobe of the ring in the first frame as bars, and the closed form as a step line.

    `figure` is the picture. `ring` are the contact forces of the ring, and `ideal` are the forces by the closed form
    [N], shape (frames, pins), or None.

    Returns
    -------
    tuple
        Artists of the bars and of the line; None where nothing is drawn.
    """
    if not ring.names:
        return None, None
    axes = figure.add_axes((0.095, 0.06, 0.88, 0.125))
    numbers = np.arange(1, len(ring.names) + 1)
    bars = axes.bar(numbers, ring.size[0], width=0.8, color=VERMILION)
    max_force = max(float(ring.size.max()), 1e-9)
    ideal_line = None
    if ideal is not None and ideal.any():
        ideal_line = axes.stairs(ideal[0], np.arange(numbers.size + 1) + 0.5, color=BLACK, linewidth=1.0, baseline=None)
        ideal_line.set_label("closed form, no clearance, no friction")
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.97), borderaxespad=0.0)
        max_force = max(max_force, float(ideal.max()))
    contact_name = "pin" if ring.kinds[0] == "pin_gear" else "lobe of the internal gear"
    axes.set(xlim=(0.4, numbers.size + 0.6), ylim=(0.0, 1.08 * max_force), ylabel="force [N]")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_xlabel(f"{contact_name} (1 on +y, clockwise)", labelpad=1.0)
    return bars, ideal_line
