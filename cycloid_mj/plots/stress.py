"""Figures of stress: maxima against crank angle, coloured maps, grids, refinement (as Hsieh 2014, Figs 10-16)."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.names import GEAR, gears
from cycloid_mj.base.units import MEGAPASCAL, MILLIMETRE
from cycloid_mj.plots.comparison import COLORS
from cycloid_mj.plots.style import BLACK, GREY, crank_axis, create_figure, legend_handles, with_style
from cycloid_mj.stress.field import StressMap
from cycloid_mj.stress.findings import MAX_CHANGE, StressFindings
from cycloid_mj.stress.grid import Grid

Entries = list[tuple[str, dict[str, Any]]]

GEARS = (GEAR, *gears(4))
TITLES = {
    "shaft": "eccentric shaft",
    **{name: " ".join(["cycloid", *name.replace("gear", "disc").split("_")]) for name in GEARS},
    **{"ring": "ring", "output": "output", "pin_1": "pin 1"},
}
"""Names of the parts; the ring has pins or is an internal gear, each of several discs is a part."""
NUMBERS = {"shaft": 12, **dict.fromkeys(GEARS, 13), "ring": 14, "output": 15, "pin_1": 16}
RANGE: dict[str, Any] = {"linestyle": (0, (5, 3)), "linewidth": 0.8}
MARK: dict[str, Any] = {"linestyle": "", "markersize": 4.0}
COLOUR_MAP, EDGE = "turbo", "#134A73"
SIDE = np.array([[0.45, 0.0, -0.89], [0.15, 0.97, 0.2]])
FRONT = np.array([[0.94, 0.0, -0.34], [0.12, 0.94, 0.32]])
BACK = np.array([[-0.94, 0.0, -0.34], [0.12, 0.94, -0.32]])
"""Rows: directions of the part that point right and up in its picture, before orthogonalisation."""
VIEWS = {"shaft": SIDE, "output": BACK}
"""Views of solid parts; the default is the front."""

PANEL = 2.9
"""Height of a row of maps or grids [in]."""


@with_style
def maxima_figure(findings: Sequence[StressFindings], part: str) -> Figure:
    """Draw the largest von Mises stress of a part against the crank angle, with a curve for each design.

    The upper panel has the bulk stress (away from the contacts), the lower panel the stress below the contacts by
    Hertz. For designs of Hsieh 2014 at the load of that paper, a dashed line marks the largest stress that it reports.
    `findings` are the stresses of the parts, one for each design.
    """
    studies = [
        (index, findings_of_design, findings_of_design[part])
        for index, findings_of_design in enumerate(findings)
        if part in findings_of_design
    ]
    figure = create_figure(4.0)
    bulk_axes, contact_axes = figure.subplots(2, 1, sharex=True)
    for index, findings_of_design, maxima in studies:
        degrees, line_style = np.degrees(maxima.angle), _line_style(index)
        bulk_axes.plot(degrees, maxima.bulk / MEGAPASCAL, **line_style)
        bulk_peak = maxima.bulk_peak
        bulk_axes.plot(np.degrees(bulk_peak.angle), bulk_peak.stress / MEGAPASCAL, "o", markersize=3.5, **line_style)
        contact_axes.plot(degrees, maxima.contact / MEGAPASCAL, **line_style)
        if published_limit := findings_of_design.published_limit(part):
            bulk_axes.axhline(published_limit / MEGAPASCAL, color=_color(index), **RANGE)
    bulk_axes.set_title(f"Largest bulk stress of {TITLES[part]} (von Mises, away from contacts)")
    contact_axes.set_title("Largest stress below a contact (von Mises, by Hertz)")
    for panel in (bulk_axes, contact_axes):
        panel.set_ylabel("[MPa]")
        panel.set_ylim(0.0, 1.05 * panel.get_ylim()[1])
        crank_axis(panel, np.concatenate([np.degrees(maxima.angle) for _, _, maxima in studies]))
    bulk_axes.set_xlabel("")
    entries: Entries = [
        (f"{findings_of_design.design}, {findings_of_design.load:g} N m", {"color": _color(index)})
        for index, findings_of_design, _ in studies
    ]
    if any(findings_of_design.published_limit(part) for _, findings_of_design, _ in studies):
        entries.append(("range of Hsieh 2014", {"color": GREY, **RANGE}))
    figure.legend(handles=legend_handles(*entries), loc="outside lower center", ncols=len(entries))
    return figure


@with_style
def map_figure(maps: Mapping[str, StressMap], condition: str) -> Figure:
    """Draw a map of the von Mises stress of every part, at the crank angle of its `StressMap`.

    The colour scale ends at the part's largest bulk stress (away from the contacts).

    Parameters
    ----------
    maps
        Stress at the nodes, by name of the part.
    condition
        Design and load, for the title.
    """
    figure, panels = _create_panels(list(maps), f"{condition}: von Mises stress")
    for axes, (part, stress_map) in zip(panels, maps.items(), strict=False):
        max_stress = float(stress_map.von_mises[stress_map.bulk].max()) / MEGAPASCAL
        image = _draw_map(axes, stress_map, stress_map.von_mises / MEGAPASCAL, max_stress)
        figure.colorbar(image, ax=axes, extend="max", shrink=0.85, label="[MPa]")
        axes.set_title(
            f"{TITLES[part]} at {np.degrees(stress_map.angle):.0f} deg:\nat most {max_stress:.3g} MPa in bulk"
        )
    return figure


@with_style
def grid_figure(grids: Mapping[str, Grid], design: str) -> Figure:
    """Draw the finite-element mesh of every part, and magnified lobes of the discs whose mesh is planar.

    `grids` are the meshes by name of the part, `design` is the name of the design for the heading.
    """
    magnified_parts = [part for part, grid in grids.items() if part in GEARS and grid.dimension == 2]
    names = [name for part in grids for name in ([part, f"{part}, magnified"] if part in magnified_parts else [part])]
    figure, panels = _create_panels(names, f"{design}: grids of quadratic elements")
    for axes, name in zip(panels, names, strict=False):
        part = name.partition(",")[0]
        grid = grids[part]
        _draw_grid(axes, grid, 0.25 if part == name else 0.5)
        axes.set_title(f"{TITLES[part]}, {grid.unknowns} unknowns" if part == name else f"{TITLES[part]}, magnified")
        if part != name:
            _magnify(axes, grid)
    return figure


@with_style
def refinement_figure(findings: Sequence[StressFindings]) -> Figure:
    """Draw the mesh convergence of each part: its largest bulk stress against the number of unknowns of the mesh.

    The stress is drawn as relative deviation [%] from the stress with the finest mesh. The grey band is the allowed
    change per refinement, `MAX_CHANGE`. `findings` are the stresses of the parts, one for each design.
    """
    figure = create_figure(3.4)
    axes = figure.subplots()
    markers = dict(zip(TITLES, "osspPXD^v", strict=True))
    for index, findings_of_design in enumerate(findings):
        for maxima in findings_of_design.parts:
            largest_stress = maxima.refinement.stress.max(axis=1)
            axes.plot(
                maxima.refinement.unknowns,
                100 * (largest_stress / largest_stress[-1] - 1.0),
                marker=markers[maxima.part],
                markersize=4.0,
                **_line_style(index),
            )
    axes.axhspan(-100 * MAX_CHANGE, 100 * MAX_CHANGE, color="#EFEFEF", zorder=0)
    axes.axhline(0.0, color=BLACK, linewidth=0.5)
    axes.set_xscale("log")
    axes.margins(x=0.05)
    axes.set_xlabel("unknowns")
    axes.set_ylabel("largest bulk stress relative to the finest grid [%]")
    axes.set_title(f"Mesh refinement; allowed change per refinement: {100 * MAX_CHANGE:g} % (grey)")
    parts = dict.fromkeys(part.part for findings_of_design in findings for part in findings_of_design.parts)
    entries: Entries = [
        (findings_of_design.design, {"color": _color(index)}) for index, findings_of_design in enumerate(findings)
    ]
    entries += [(TITLES[part], {"color": GREY, "marker": markers[part], **MARK}) for part in parts]
    figure.legend(handles=legend_handles(*entries), loc="outside lower center", ncols=4)
    return figure


def maxima_figures(findings: Sequence[StressFindings]) -> dict[str, Figure]:
    """Return `maxima_figure` of each part by the name of the figure."""
    parts = [part for part in TITLES if any(part in findings_of_design for findings_of_design in findings)]
    return {f"fig{NUMBERS[part]}_stress_{part}": maxima_figure(findings, part) for part in parts}


def stress_figures(findings: Sequence[StressFindings]) -> dict[str, Figure]:
    """Return the figures that need no finite-element mesh, by name: maxima of each part, and mesh refinement."""
    return maxima_figures(findings) | {"stress_refinement": refinement_figure(findings)}


def _line_style(number: int) -> dict[str, Any]:
    return {"color": _color(number), "linewidth": 1.0}


def _color(number: int) -> str:
    return COLORS[number % len(COLORS)]


def _create_panels(names: Sequence[str], title: str) -> tuple[Figure, list[Axes]]:
    """Create a figure with a title and a panel for each name, axes in mm, in up to two columns.

    Returns
    -------
    tuple
        The figure, and the axes of the panels.
    """
    columns = 2 if len(names) > 1 else 1
    rows = -(-len(names) // columns)
    figure = create_figure(PANEL * rows + 0.4)
    figure.suptitle(title, x=0.01, ha="left", fontsize=9.5)
    panels = list(np.ravel(figure.subplots(rows, columns, squeeze=False)))
    for axes in panels[len(names) :]:
        axes.set_axis_off()
    for axes in panels[: len(names)]:
        axes.set_aspect("equal")
        axes.grid(False)
        axes.set_xlabel("x [mm]")
        axes.set_ylabel("y [mm]")
    return figure, panels


def _draw_map(axes: Axes, stress_map: StressMap, stress: Array, max_stress: float) -> Any:
    """Draw the `stress` at the n nodes of a part (n,) as colours on the mesh of `stress_map`; return the triangles.

    It is interpolated linearly between nodes. A solid part is drawn in its view (`VIEWS`), visible faces only. The
    colour scale is from 0 to `max_stress`, in the unit of `stress`.
    """
    map_style: dict[str, Any] = {
        "cmap": COLOUR_MAP,
        "vmin": 0.0,
        "vmax": max_stress,
        "shading": "gouraud",
        "rasterized": True,
    }
    if stress_map.points.shape[1] == 2:
        triangulation = _triangulate(stress_map.points / MILLIMETRE, stress_map.cells)
        return axes.tripcolor(triangulation, stress, **map_style)
    points, faces, _ = _project_surface(stress_map.points, stress_map.cells, stress_map.part)
    axes.set_axis_off()
    return axes.tripcolor(_triangulate(points, faces), stress, **map_style)


def _draw_grid(axes: Axes, grid: Grid, width: float) -> None:
    """Draw the element edges of a planar mesh, or the visible faces of a solid mesh; `width` is the line width [pt].

    `grid` is the mesh.
    """
    points, cells = grid.points, grid.cells
    line_style: dict[str, Any] = {"linewidths": width, "rasterized": True}
    if points.shape[1] == 2:
        edge_nodes = np.sort(np.concatenate([cells[:, [0, 1]], cells[:, [1, 2]], cells[:, [0, 2]]]), axis=1)
        lines = points[np.unique(edge_nodes, axis=0)] / MILLIMETRE
        axes.add_collection(LineCollection(list(lines), colors=EDGE, **line_style))
    else:
        projected_points, faces, _ = _project_surface(points, cells, grid.part)
        axes.add_collection(
            PolyCollection(list(projected_points[faces[:, :3]]), facecolors="#EAF2F8", edgecolors=EDGE, **line_style)
        )
        axes.set_axis_off()
    axes.autoscale_view()


def _magnify(axes: Axes, grid: Grid) -> None:
    """Limit the axes of a drawn mesh to the lobes at +y."""
    top = grid.points[:, 1].max()
    half_height = 0.09 * top
    axes.set_xlim(-1.3 * half_height / MILLIMETRE, 1.3 * half_height / MILLIMETRE)
    axes.set_ylim((top - 2 * half_height) / MILLIMETRE, 1.01 * top / MILLIMETRE)


def _triangulate(points: Array, cells: Integers) -> Triangulation:
    """Return a triangulation of `points` (n, 2) with four linear triangles for each quadratic one of `cells` (m, 6)."""
    x, y = points.T
    return Triangulation(x, y, cells[:, [[0, 3, 5], [1, 4, 3], [2, 5, 4], [3, 4, 5]]].reshape(-1, 3))


def _project_surface(points: Array, cells: Integers, part: str) -> tuple[Array, Integers, Array]:
    """Project the surface of a solid part onto the plane of its view (`VIEWS`), and select the visible faces.

    Parameters
    ----------
    points, cells
        The n nodes [m], shape (n, 3), and m quadratic tetrahedra (node indices), shape (m, 10).
    part
        Name of the part.

    Returns
    -------
    tuple of Array
        Positions of all nodes in the view [mm], shape (n, 2); node indices of the f visible faces from far to near,
        shape (f, 6); and coordinates of the faces along the line of sight [m], shape (f,), larger if nearer.
    """
    view_axes = VIEWS.get(part, FRONT)
    right_axis = view_axes[0] / np.linalg.norm(view_axes[0])
    up_axis = view_axes[1] - (view_axes[1] @ right_axis) * right_axis
    up_axis = up_axis / np.linalg.norm(up_axis)
    view_direction = np.cross(right_axis, up_axis)
    faces, opposite_corner = _outer_faces(cells)
    corners = points[faces[:, :3]]
    face_normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outward_signs = np.sign(np.sum(face_normals * (corners.mean(axis=1) - points[opposite_corner]), axis=1))
    is_visible = outward_signs * (face_normals @ view_direction) > 0.0
    depth = corners.mean(axis=1) @ view_direction
    far_to_near = np.flatnonzero(is_visible)[np.argsort(depth[is_visible])]
    return points @ np.stack([right_axis, up_axis], axis=1) / MILLIMETRE, faces[far_to_near], depth[far_to_near]


def _outer_faces(cells: Integers) -> tuple[Integers, Integers]:
    """Find the f outer faces of quadratic tetrahedra, which belong to one tetrahedron only.

    `cells` (m, 10) are node indices of m tetrahedra: corners 0 to 3, then the midside nodes of the edges between the
    corners 0-1, 1-2, 0-2, 0-3, 1-3 and 2-3.

    Returns
    -------
    tuple of Integers
        Node indices of the faces, shape (f, 6): three corners, then three midside nodes; and for each face the corner
        of its tetrahedron that is opposite to it, shape (f,).
    """
    sides = ((0, 1, 2, 4, 5, 6, 3), (0, 1, 3, 4, 8, 7, 2), (1, 2, 3, 5, 9, 8, 0), (0, 2, 3, 6, 9, 7, 1))
    faces = np.concatenate([cells[:, side] for side in sides])
    _, first_index, count = np.unique(np.sort(faces[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
    outer_faces = faces[first_index[count == 1]]
    return outer_faces[:, :6], outer_faces[:, 6]
