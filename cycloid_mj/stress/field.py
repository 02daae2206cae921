"""Stress of a part: its maxima at every crank angle (``PartStress``), and whole fields at one (``StressMap``)."""

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from cycloid_mj.design import Design
from cycloid_mj.errors import UsageError
from cycloid_mj.stress import elastic
from cycloid_mj.stress.elastic import Body
from cycloid_mj.stress.grid import Grid
from cycloid_mj.stress.loads import PartLoads
from cycloid_mj.stress.patch import patches
from cycloid_mj.stress.probe import probe
from cycloid_mj.stress.recover import principal, recovery, stresses, von_mises

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Indices = npt.NDArray[np.int64]

BLOCK = 24
"""Angles worked on together: enough for speed, few enough for memory."""

RIM_POINTS = 24
"""Points on the circle about each narrow patch where the bulk begins."""


@dataclass(frozen=True)
class PartStress:
    """Stress of one part at k crank angles; d is 2 for a planar part, 3 for a solid one.

    Attributes
    ----------
    part
        Its name.
    angle
        Crank angle [rad], (k,).
    bulk_stress, bulk_place
        Largest von Mises stress [Pa] (k,) farther than `bulk_distance` from every loaded patch, and where [m] (k, d).
    contact_stress, contact_place
        The same over all nodes. It means something only where `resolved`.
    resolved
        Whether the grid resolves every loaded patch (two edges to a half width), (k,); never for the shaft, whose
        sharp inner corners have no finite stress.
    reaction
        Resultants of all supports on the part [N], [N m] (k, 3 or 6): forces, then moments about the origin. Those of
        the auxiliary supports of a free part are zero but for rounding.
    imbalance
        What was out of balance in the loads of a free part [N], [N m] (k, 3 or 6); it was spread over the mass.
    load
        The largest contact force [N], to hold the imbalance against, (k,).
    bulk_distance
        [m]; it does not change with the refinement.
    edge
        Longest edge of the outlines that other parts touch [m].
    unknowns
        Displacements solved for.
    """

    part: str
    angle: Array
    bulk_stress: Array
    bulk_place: Array
    contact_stress: Array
    contact_place: Array
    resolved: Flags
    reaction: Array
    imbalance: Array
    load: Array
    bulk_distance: float
    edge: float
    unknowns: int


@dataclass(frozen=True)
class StressMap:
    """Fields on a part at one crank angle.

    Attributes
    ----------
    part, angle
        Its name, and the crank angle [rad].
    points, cells
        Nodes (n, d) [m], and the nodes of each quadratic triangle (m, 6) or tetrahedron (m, 10), corners first.
    displacement
        (n, d) [m]; of a free part up to a rigid motion.
    stress
        Components xx, yy, xy, or xx, yy, zz, yz, xz, xy [Pa] (n, 3 or 6).
    von_mises, principal
        [Pa] (n,), and (n, d) with the largest first.
    bulk
        Whether a node counts as bulk, (n,).
    """

    part: str
    angle: float
    points: Array
    cells: Indices
    displacement: Array
    stress: Array
    von_mises: Array
    principal: Array
    bulk: Flags


@dataclass(frozen=True)
class Case:
    """A part with its loads, ready for any angles.

    Attributes
    ----------
    body
        The factorised part.
    response
        Balanced loads (n, c) [N], displacements (n, c) [m] and imbalance (c, r) at the angles of given indices (c,).
    angle, points, narrow
        Points (p, d) [m] of loaded patches that the bulk keeps off, the index of the angle (p,) of each, and whether
        it is the centre of a narrow patch (p,), about which stress falls as 1/distance.
    resolved
        Whether the grid resolves the stress at the patches, (k,).
    """

    body: Body
    response: Callable[[Indices], tuple[Array, Array, Array]]
    angle: Indices
    points: Array
    narrow: Flags
    resolved: Flags


@dataclass(frozen=True)
class _Rim:
    """Points (p, 2) [m] just where the bulk begins about narrow patches, the angle (p,) of each, and their probe."""

    points: Array
    angle: Indices
    operator: Any


def solve(design: Design, grid: Grid, loads: PartLoads, progress: Callable[[float], None] | None = None) -> PartStress:
    """Give the maxima of stress on a part at each crank angle of its loads.

    Parameters
    ----------
    design
        The design; its material.
    grid
        The part's grid.
    loads
        The loads on the same part.
    progress
        Told the share that is done, 0 to 1.

    Raises
    ------
    CycloidError
        The loads are not this part's, its support is singular, or a package of the extra ``fem`` is missing.
    """
    case, operators = _case(design, grid, loads), recovery(grid).at_nodes
    near, always, rim = _near(grid, case), _near_corners(grid), _rim(grid, case)
    found: list[tuple[Array, ...]] = []
    for block in _blocks(len(loads.angle)):
        forces, moved, imbalance = case.response(block)
        components = stresses(operators, moved, design.material)
        stress = von_mises(components)
        contact = _largest(stress, grid.points)
        stress[always] = 0.0
        for column, angle in enumerate(block):
            stress[near[angle], column] = 0.0
        bulk = _or_on_rim(rim, block, components, *_largest(stress, grid.points))
        found.append((*bulk, *contact, elastic.reactions(case.body, moved, forces), imbalance))
        if progress is not None:
            progress(float(block[-1] + 1) / len(loads.angle))
    bulk_stress, bulk_place, contact_stress, contact_place, reaction, imbalance = map(
        np.concatenate, zip(*found, strict=True)
    )
    return PartStress(
        part=grid.part,
        angle=np.array(loads.angle),
        bulk_stress=bulk_stress,
        bulk_place=bulk_place,
        contact_stress=contact_stress,
        contact_place=contact_place,
        resolved=case.resolved,
        reaction=reaction,
        imbalance=imbalance,
        load=np.nan_to_num(np.linalg.norm(loads.force, axis=2)).max(axis=1, initial=0.0),
        bulk_distance=grid.bulk_distance,
        edge=_longest_edge(grid),
        unknowns=grid.unknowns,
    )


def stress_map(design: Design, grid: Grid, loads: PartLoads, index: int) -> StressMap:
    """Give the fields on a part at the crank angle of an index.

    Raises
    ------
    UsageError
        There is no such index.
    CycloidError
        As for ``solve``.
    """
    if not 0 <= index < len(loads.angle):
        raise UsageError(f"the loads have no angle of index {index}; choose 0 to {len(loads.angle) - 1}")
    case = _case(design, grid, loads)
    _, moved, _ = case.response(np.array([index]))
    stress = stresses(recovery(grid).at_nodes, moved, design.material)[..., 0]
    bulk = np.ones(len(grid.points), bool)
    bulk[_near_corners(grid)] = False
    bulk[_near(grid, case)[index]] = False
    return StressMap(
        part=grid.part,
        angle=float(loads.angle[index]),
        points=grid.points,
        cells=grid.cells,
        displacement=moved.reshape(-1, grid.dimension),
        stress=stress.T,
        von_mises=von_mises(stress),
        principal=principal(stress),
        bulk=bulk,
    )


def mass_coefficients(loads: PartLoads) -> Array:
    """Give the shares (4, k) of ``elastic.mass_loads`` in the loads of the mass."""
    return np.vstack([loads.body_force.T, loads.spin**2, loads.spin_rate])


def _case(design: Design, grid: Grid, loads: PartLoads) -> Case:
    if grid.dimension == 3:
        from cycloid_mj.stress.solid3 import shaft_case

        return shaft_case(design, grid, loads)
    return planar_case(design, grid, loads)


def planar_case(design: Design, grid: Grid, loads: PartLoads) -> Case:
    """Factorise a planar part; each angle is one right-hand side of patches and mass.

    A moment that is carried elsewhere is the support's: the output's load torque acts at its hub.
    """
    put = patches(grid, loads)
    part = elastic.body(grid, design.material)
    mass, shares = elastic.mass_loads(part, grid.points), mass_coefficients(loads)

    def response(block: Indices) -> tuple[Array, Array, Array]:
        applied = put.loads[:, block].toarray() + mass @ shares[:, block]
        forces, imbalance = elastic.balanced(part, applied)
        return forces, elastic.displacements(part, forces), imbalance

    return Case(part, response, put.angle, put.points, put.narrow, put.resolved)


def _blocks(count: int) -> Iterator[Indices]:
    for start in range(0, count, BLOCK):
        yield np.arange(start, min(start + BLOCK, count))


def _near(grid: Grid, case: Case) -> list[Indices]:
    """Nodes within the bulk distance of the loaded patches of each angle."""
    tree = cKDTree(grid.points)
    order = np.argsort(case.angle, kind="stable")
    found: Any = tree.query_ball_point(case.points[order], grid.bulk_distance, return_sorted=False)
    ends = np.searchsorted(case.angle[order], np.arange(len(case.resolved) + 1))
    return [np.array([node for nodes in found[a:b] for node in nodes], np.int64) for a, b in itertools.pairwise(ends)]


def _rim(grid: Grid, case: Case) -> _Rim:
    """Give points on circles of the bulk distance about the narrow patches, as far as they lie in the bulk.

    There the bulk stress of a part in contact is largest; the nearest nodes would find it only by chance.
    """
    turn = 2 * np.pi * np.arange(RIM_POINTS) / RIM_POINTS
    circle = grid.bulk_distance * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    centres = case.points[case.narrow]
    angle = np.repeat(case.angle[case.narrow], RIM_POINTS)
    if not len(centres):
        return _Rim(centres, angle, None)
    points = (centres[:, np.newaxis] + circle).reshape(-1, 2)
    apart = 1e3 * float(np.ptp(grid.points))  # the angles lie on planes, one above the other
    tree = cKDTree(np.column_stack([case.points, apart * case.angle]))
    distance, _ = tree.query(np.column_stack([points, apart * angle]))
    kept = distance > grid.bulk_distance * (1 - 1e-6)
    operator, inside = probe(grid, points[kept])
    order = np.argsort(angle[kept][inside], kind="stable")
    return _Rim(points[kept][inside][order], angle[kept][inside][order], operator[inside][order])


def _largest(stress: Array, points: Array) -> tuple[Array, Array]:
    """Largest values (c,) of columns (p, c), and where they are."""
    return stress.max(axis=0), points[stress.argmax(axis=0)]


def _or_on_rim(rim: _Rim, block: Indices, components: Array, largest: Array, place: Array) -> tuple[Array, Array]:
    """Give the larger of the nodes' maxima and those on the rim, and where they are."""
    ends = np.searchsorted(rim.angle, [block, block + 1]).T
    for column, (a, b) in enumerate(ends):
        if a < b:
            on_rim = von_mises(np.stack([rim.operator[a:b] @ component[:, column] for component in components]))
            if on_rim.max() > largest[column]:
                largest[column], place[column] = on_rim.max(), rim.points[a + on_rim.argmax()]
    return largest, place


def _near_corners(grid: Grid) -> Indices:
    if not len(grid.keep_off):
        return np.zeros(0, np.int64)
    distance, _ = cKDTree(grid.keep_off).query(grid.points)
    return np.flatnonzero(distance < grid.bulk_distance)


def _longest_edge(grid: Grid) -> float:
    ends = np.concatenate([loop[:, [0, 2]] for loop in grid.loops]) if grid.loops else np.zeros((0, 2), np.int64)
    pairs: Any = grid.points[ends]
    return float(np.linalg.norm(pairs[:, 1] - pairs[:, 0], axis=1).max(initial=0.0))
