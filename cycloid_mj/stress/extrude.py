"""Planar grids extruded along z: the same parts as solid bodies of quadratic tetrahedra.

Every triangle of the section becomes a prism in each layer that it fills, and every prism three tetrahedra, cut from
the lowest of its corners to the highest. Their nodes are then those of the section, at the faces and in the middle of
every layer: curved edges stay as exact as they are in the plane, and a load of the plane is handed on height by height.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from scipy import sparse

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.base.names import GEAR, family
from cycloid_mj.parts import output_centres
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP
from cycloid_mj.stress.grid import Grid, GridSettings, SectionGrid, planar_grid, quadratic_mesh
from cycloid_mj.stress.region import part_region

COARSER = {"contact_edge": 3.0, "wide_edge": 2.0, "free_edge": 2.5, "inner_edge": 3.0, "turn": 2.0, "growth": 8.0}
"""Settings of a section relative to those of a planar grid: a solid has fifteen unknowns or more for two."""

MIN_LAYERS = {"output": 4}
"""Smallest number of layers over the disc's width; of other parts two, so that forces act at five heights or more."""

_TETRAHEDRA = (((0, 0), (1, 0), (2, 0), (2, 1)), ((0, 0), (1, 0), (1, 1), (2, 1)), ((0, 0), (0, 1), (1, 1), (2, 1)))
"""Tetrahedra of a prism: (corner by rising number, bottom or top) of each of their corners."""

_NODE = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
"""Node of a quadratic triangle between two of its corners; the corner itself on the diagonal."""


def solid_grid(reducer: Reducer, part: str, settings: GridSettings) -> Grid:
    """Mesh a part other than the shaft by solid finite elements (quadratic tetrahedra).

    `part` is the name of a disc ("gear", "gear_1", ...), "ring", "output" or "pin_1". The output is one body of its
    disc, its pins and, with support at both ends, its second disc. The attribute `section` of the result is the planar
    grid of the part, from which contact forces are distributed over the face width of each disc. Fillets are not
    meshed. Nodes near the roots of the output pins and the rims of the hubs are therefore excluded from the search for
    the bulk stress (`stress.bulk`).
    """
    design = reducer.design
    unit_length, gear = design.ring.pin_radius, design.gear
    # the stress of the output is largest at the roots of its pins, not near contacts
    edge_factor = 0.8 if part == "output" else 1.0
    coarser_edges: dict[str, Any] = {
        name: edge_factor * getattr(settings, name) for name, edge_factor in COARSER.items()
    }
    section_settings = replace(settings, **coarser_edges, refinement=edge_factor * settings.refinement)
    section = planar_grid(part_region(reducer, part), section_settings, unit_length, section=True)
    layer_height = settings.layer_edge * unit_length / settings.refinement
    min_layers = MIN_LAYERS.get(part, 2)
    planes = (0.0,) if family(part) == GEAR else gear.disc_planes
    layer_height = min(layer_height, gear.face_width / min_layers)
    disc_levels = [_levels(plane - gear.face_width / 2, plane + gear.face_width / 2, layer_height) for plane in planes]
    # neighbours are joined by a layer across their gap
    stack_levels = np.concatenate(disc_levels)
    if part != "output":
        return extrude_section(
            section, stack_levels, np.ones((len(stack_levels) - 1, len(section.cells)), bool), _layers_of(disc_levels)
        )
    output_face, disc_thickness = gear.stack_width / 2 + AXIAL_GAP, design.output.disc_thickness
    output_levels = _levels(
        output_face, output_face + disc_thickness, settings.layer_edge * unit_length / settings.refinement
    )
    second_levels = -output_levels[::-1] if design.output.support == "both_ends" else np.zeros(0)
    levels = np.concatenate([second_levels, stack_levels, output_levels])
    is_filled = np.ones((len(levels) - 1, len(section.cells)), bool)
    pin_layers = slice(max(len(second_levels) - 1, 0), len(second_levels) + len(stack_levels))
    is_filled[pin_layers] = _within_pins(reducer, section)
    grid = extrude_section(section, levels, is_filled, _layers_of(disc_levels, len(second_levels)))
    # the bulk excludes the roots of the pins and the rims of the hub
    corner_distance = 0.5 * design.output.root_radius
    corners = [_output_corners(reducer, output_face, output_levels[-1], corner_distance / 4)]
    corners += (
        [_output_corners(reducer, -output_face, -output_levels[-1], corner_distance / 4)] if len(second_levels) else []
    )
    return replace(grid, singular_points=np.concatenate(corners), corner_distance=corner_distance)


def _layers_of(discs: list[Array], first_level: int = 0) -> list[slice]:
    """Return the slice of each disc's levels in the concatenated levels of all discs, which begin at `first_level`."""
    boundaries = first_level + np.cumsum([0, *(len(levels) for levels in discs)])
    return [slice(int(start), int(end)) for start, end in pairwise(boundaries)]


def extrude_section(section: Grid, levels: Array, is_filled: Mask, loaded_slices: Sequence[slice]) -> Grid:
    """Extrude a planar grid of m triangles along z into a solid grid of quadratic tetrahedra with the same supports.

    Parameters
    ----------
    section
        The planar grid.
    levels
        Heights z of the l + 1 faces of the l layers [m], increasing.
    is_filled
        Whether there is material in each layer above each triangle of the section, (l, m).
    loaded_slices
        For each disc the slice of `levels` over which its contact forces are distributed, in proportion to the layer
        heights.
    """
    vertex_index = np.full((len(levels), section.mesh.nvertices), -1, np.int64)
    for layer, filled_cells in enumerate(is_filled):
        vertex_index[layer : layer + 2, np.unique(section.mesh.t[:, filled_cells])] = 0
    vertex_index[vertex_index == 0] = np.arange(np.count_nonzero(vertex_index == 0))
    level, vertex = np.nonzero(vertex_index >= 0)
    points = np.column_stack([section.points[vertex], levels[level]])
    tetrahedra, edge_ends, nodes, heights = _divide_prisms(section, is_filled, vertex_index)
    section_node, height_index = np.concatenate(nodes), np.concatenate(heights)
    z = np.interp(np.arange(2 * len(levels) - 1) / 2, np.arange(len(levels)), levels)
    middles = np.column_stack([section.points[section_node], z[height_index]])
    mesh, vertices, middle_nodes = quadratic_mesh(
        points, np.concatenate(tetrahedra), np.concatenate(edge_ends), middles, section.part
    )
    node_index = np.full((len(z), len(section.points)), -1, np.int64)
    node_index[::2, : section.mesh.nvertices][level, vertex] = vertices
    node_index[height_index, section_node] = middle_nodes
    fixed_nodes = node_index[:, section.fixed_nodes]
    pressed_nodes = [node_index[2 * loaded_slice.start : 2 * loaded_slice.stop - 1] for loaded_slice in loaded_slices]
    unknowns = 3 * len(mesh.doflocs.T)
    return Grid(
        part=section.part,
        mesh=mesh,
        thickness=1.0,
        loops=(),
        fixed_nodes=np.unique(fixed_nodes[fixed_nodes >= 0]),
        bulk_distance=section.bulk_distance,
        singular_points=np.zeros((0, 3)),
        section=SectionGrid(
            section,
            np.concatenate(pressed_nodes),
            tuple(
                _distribution_matrix(nodes, _simpson(levels[loaded_slice]), unknowns)
                for nodes, loaded_slice in zip(pressed_nodes, loaded_slices, strict=True)
            ),
        ),
    )


def _divide_prisms(section: Grid, is_filled: Mask, vertex_index: Integers) -> tuple[list[Array], ...]:
    """Divide the prism over each triangle of each layer of an extruded mesh into three quadratic tetrahedra.

    Parameters
    ----------
    section
        The planar grid.
    is_filled
        Whether there is material in each of l layers above each of m triangles, (l, m).
    vertex_index
        Index of the solid's vertex at each of the l + 1 levels above each of v vertices of the section, (l + 1, v).

    Returns
    -------
    tuple
        Four lists of arrays, to be concatenated: corners of t tetrahedra (t, 4), vertices at both ends of their e edges
        (e, 2), node of the section over which the middle of each edge is (e,), and index of the height of this middle
        (e,), where level i has the index 2 i.
    """
    sorted_corners = np.argsort(section.mesh.t.T, axis=1)
    tetrahedra, edge_ends, nodes, heights = [], [], [], []
    for layer, filled_cells in enumerate(is_filled):
        cell_indices = np.flatnonzero(filled_cells)
        for corners in _TETRAHEDRA:
            orders = [sorted_corners[cell_indices, rank] for rank, _ in corners]
            tetrahedron = [
                vertex_index[layer + upper, section.cells[cell_indices, order]]
                for order, (_, upper) in zip(orders, corners, strict=True)
            ]
            tetrahedra.append(np.column_stack(tetrahedron))
            for i, j in zip(*np.triu_indices(4, 1), strict=True):
                edge_ends.append(np.column_stack([tetrahedron[i], tetrahedron[j]]))
                nodes.append(section.cells[cell_indices, _NODE[orders[i], orders[j]]])
                heights.append(np.full(len(cell_indices), 2 * layer + corners[i][1] + corners[j][1]))
    return tetrahedra, edge_ends, nodes, heights


def _distribution_matrix(solid_nodes: Integers, weights: Array, unknowns: int) -> Any:
    """Return the sparse matrix (n, 2 m) that distributes loads on m nodes of a planar section over the solid's heights.

    Parameters
    ----------
    solid_nodes
        Node of the solid at each of h heights above each node of the section, (h, m); -1 where there is none.
    weights
        Share of each height in a load, (h,). A node of the section without a node at some height receives no load.
    unknowns
        Number of unknowns n of the solid.
    """
    complete_nodes = np.flatnonzero((solid_nodes >= 0).all(axis=0))
    rows = 3 * solid_nodes[:, complete_nodes, np.newaxis] + np.arange(2)
    columns = np.broadcast_to(2 * complete_nodes[:, np.newaxis] + np.arange(2), rows.shape)
    values = np.broadcast_to(weights[:, np.newaxis, np.newaxis], rows.shape)
    entries = (values.ravel(), (rows.ravel(), columns.ravel()))
    return sparse.coo_matrix(entries, shape=(unknowns, 2 * solid_nodes.shape[1])).tocsr()


def _simpson(levels: Array) -> Array:
    """Compute the share (2 l + 1,) of faces and middles of l layers in a uniform load, by Simpson's rule."""
    share, height = np.zeros(2 * len(levels) - 1), np.diff(levels) / np.ptp(levels)
    for offset, weight in enumerate((1 / 6, 2 / 3, 1 / 6)):
        share[offset : offset + 2 * len(height) : 2] += weight * height
    return share


def _levels(z0: float, z1: float, layer: float) -> Array:
    return np.linspace(z0, z1, math.ceil((z1 - z0) / layer) + 1)


def _within_pins(reducer: Reducer, section: Grid) -> Mask:
    """Return which triangles (m,) of the output's section are in its pins."""
    middle = section.points[section.cells[:, :3]].mean(axis=1)
    distances = np.linalg.norm(middle[:, np.newaxis] - output_centres(reducer), axis=2)
    return np.asarray(distances.min(axis=1) < reducer.design.output.root_radius)


def _output_corners(reducer: Reducer, face: float, back: float, spacing: float) -> Array:
    """Return n points [m] along the roots of the output pins and both rims of the hub, shape (n, 3).

    `spacing` [m] is their distance. `face` and `back` are the heights z [m] of the faces of the output disc; the pins
    are on `face`.
    """
    pin_radius, hub_radius = reducer.design.output.root_radius, reducer.design.shaft.radius
    root_circles = [_ring(pin_radius, spacing, face) + np.append(centre, 0.0) for centre in output_centres(reducer)]
    return np.concatenate([*root_circles, _ring(hub_radius, spacing, face), _ring(hub_radius, spacing, back)])


def _ring(radius: float, spacing: float, z: float) -> Array:
    turn = 2 * np.pi * np.arange(math.ceil(2 * np.pi * radius / spacing)) / math.ceil(2 * np.pi * radius / spacing)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.full(len(turn), z)])
