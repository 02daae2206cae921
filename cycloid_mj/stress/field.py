"""Stress of a part: maxima at all crank angles (``PartStress``), and full fields at a single angle (``StressMap``)."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import count

import numpy as np

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.base.errors import UsageError
from cycloid_mj.design import Design
from cycloid_mj.design.model import Material
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.stress.bulk import (
    DISTANCES_PER_OCTAVE,
    Distances,
    find_plateau,
    largest_beyond,
    measure_distances,
    search_distances,
)
from cycloid_mj.stress.case import LoadCase, Response
from cycloid_mj.stress.grid import Grid
from cycloid_mj.stress.loads import PartLoads
from cycloid_mj.stress.part import part_case
from cycloid_mj.stress.recover import Recovery, build_recovery, principal, stresses, von_mises
from cycloid_mj.stress.region import material_of

MAX_BLOCK_ANGLES, MAX_FIELD_BYTES = 32, 2**25
"""Largest number of angles that are processed together, and of bytes of one of their fields: larger arrays are
requested from the system each time (`base.memory`)."""


@dataclass(frozen=True)
class PartStress:
    """Stress of one part at k crank angles; d is 2 for a planar part, 3 for a solid one.

    Attributes
    ----------
    part
        Name of the part.
    angle
        Crank angle [rad], (k,).
    bulk_stress, bulk_place
        Largest von Mises stress [Pa] (k,) farther than `bulk_distance` from all narrow patches and sharp corners,
        and its position [m] (k, d).
    distances, stress_by_distance
        Distances [m] (s,), and the largest von Mises stress beyond each of them [Pa] (s, k).
    reaction
        Resultants of all supports on the part [N], [N m] (k, 3 or 6): forces, then moments about the origin. Those of
        the auxiliary supports of a free part are zero except for rounding.
    imbalance
        Imbalance of the loads of a free part [N], [N m] (k, 3 or 6), which was distributed over the mass.
    moments
        Moments about x, y and z [N m] in the sections at the shaft's stations (k, s, 3); other parts have none.
    load
        Largest contact force [N], as a reference for the imbalance, (k,).
    bulk_distance
        Distance at which the largest stress reaches its plateau [m].
    unknowns
        Number of displacements.
    """

    part: str
    angle: Array
    bulk_stress: Array
    bulk_place: Array
    distances: Array
    stress_by_distance: Array
    reaction: Array
    imbalance: Array
    moments: Array
    load: Array
    bulk_distance: float
    unknowns: int


CORNER_DISTANCES = (0.5, 1.0, 2.0)
"""Multiples of the distance from sharp corners at which the bulk stress is evaluated as well."""


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
    cells: Integers
    displacement: Array
    stress: Array
    von_mises: Array
    principal: Array
    bulk: Mask


def solve(
    design: Design,
    grid: Grid,
    loads: PartLoads,
    distance: float | None = None,
) -> PartStress:
    """Compute bulk stress, reactions and residual of the loads of a part at each crank angle of the loads.

    The residual (`PartStress.imbalance`) is the resultant force and moment of the loads of a part without supports.

    Parameters
    ----------
    design
        The design, for its material.
    grid
        Finite-element grid of the part.
    loads
        Contact forces, weight and inertia of this part at crank angles.
    distance
        Distance from contact patches from which the stress counts as bulk stress [m]. The default is the distance at
        which the largest stress of all crank angles reaches a plateau (`search_distances`, from `grid.bulk_distance`).

    Raises
    ------
    CycloidError
        The loads belong to another part, or its finite-element equations cannot be solved.
    """
    reducer = reducer_of(design)
    case = part_case(reducer, grid, loads)
    responses = list(_responses(case))
    distances = measure_distances(grid, case)
    del case  # its factor: with it the operators would be the peak of memory
    operators, material = build_recovery(grid), material_of(reducer, grid.part)
    return _collect_maxima(
        grid, loads, distances, distance, responses, lambda displacements: stresses(operators, displacements, material)
    )


@dataclass(frozen=True)
class LoadedPart:
    """A part under its loads, factorised once for its maxima and for all maps.

    `operators` recover its stress, `material` is its own, `distances` are those of its nodes from narrow
    patches.
    """

    grid: Grid
    loads: PartLoads
    material: Material
    operators: Recovery
    case: LoadCase
    distances: Distances

    def components(self, displacements: Array) -> Array:
        """Compute the stress components at the nodes under displacements (n d, c) [m], as ``recover.stresses``."""
        return stresses(self.operators, displacements, self.material)


def assemble_part(reducer: Reducer, grid: Grid, loads: PartLoads) -> LoadedPart:
    """Assemble a part and factorise its stiffness, for `solve_maxima` and `evaluate_map`; errors as `solve`."""
    operators = build_recovery(grid)  # first: with the factor its own needs would be the peak of memory
    case = part_case(reducer, grid, loads)
    return LoadedPart(grid, loads, material_of(reducer, grid.part), operators, case, measure_distances(grid, case))


StateObserver = Callable[[int, Array], None]
"""Function that receives index and stress components (components, n) [Pa] of each crank angle, in their order."""


def ignore_state(index: int, stress: Array) -> None:
    """Ignore a state: the observer where there is none."""


def solve_maxima(part: LoadedPart, on_state: StateObserver = ignore_state) -> PartStress:
    """Solve a part at each crank angle, and return the maxima of its stress, as `solve`.

    `on_state` is called with index and stress components of each angle.
    """
    responses = _responses(part.case)
    return _collect_maxima(part.grid, part.loads, part.distances, None, responses, part.components, on_state)


def _responses(case: LoadCase) -> Iterator[Response]:
    """Yield the response of a part to its loads, a block of angles at a time."""
    block = min(MAX_BLOCK_ANGLES, max(1, MAX_FIELD_BYTES // case.body.motions[:, 0].nbytes - 1))
    for start in range(0, case.angles, block):
        yield case.response(np.arange(start, min(start + block, case.angles)))


def _collect_maxima(
    grid: Grid,
    loads: PartLoads,
    distances: Distances,
    distance: float | None,
    responses: Iterable[Response],
    components: Callable[[Array], Array],
    on_state: StateObserver = ignore_state,
) -> PartStress:
    """Compute the largest bulk stress of a part at each crank angle, with its position, from responses to the loads.

    Parameters
    ----------
    grid, loads
        Finite-element grid of the part, and its loads.
    distances
        Distances of the grid's nodes from narrow patches and corners.
    distance
        Distance from contact patches beyond which stress counts as bulk stress [m]; None: where the turn's largest
        stress reaches a plateau.
    responses
        Responses of the part to the loads, in blocks of consecutive crank angles.
    components
        Function from displacements of n nodes in d dimensions for c angles, (n d, c) [m], to stress components
        (components, n, c) [Pa].
    on_state
        Called with the index of each angle and the stress components of all nodes at it.
    """
    tried_distances = search_distances(distances, grid.bulk_distance) if distance is None else np.array([distance])
    maxima: list[tuple[Array, ...]] = []
    angle_indices = count()
    for response in responses:
        stress, block_maxima = components(response.displacements), []
        for state, equivalent_stress in zip(
            np.moveaxis(stress, -1, 0), np.ascontiguousarray(von_mises(stress).T), strict=True
        ):
            on_state(index := next(angle_indices), state)
            block_maxima.append(largest_beyond(distances, tried_distances, index, equivalent_stress))
        largest_stresses, nodes = map(np.array, zip(*block_maxima, strict=True))
        maxima.append((largest_stresses, nodes, response.reaction, response.imbalance, response.moments))
    largest_stresses, nodes, reaction, imbalance, moments = map(np.concatenate, zip(*maxima, strict=True))
    plateau_index = find_plateau(largest_stresses.max(axis=0), DISTANCES_PER_OCTAVE) if distance is None else 0
    return PartStress(
        part=grid.part,
        angle=np.array(loads.angle),
        bulk_stress=largest_stresses[:, plateau_index],
        bulk_place=grid.points[nodes[:, plateau_index]],
        distances=tried_distances,
        stress_by_distance=largest_stresses.T,
        reaction=reaction,
        imbalance=imbalance,
        moments=moments,
        load=np.nan_to_num(np.linalg.norm(loads.force, axis=2)).max(axis=1, initial=0.0),
        bulk_distance=float(tried_distances[plateau_index]),
        unknowns=grid.unknowns,
    )


def vary_corner_distance(part: LoadedPart, index: int, distance: float) -> tuple[tuple[float, float], ...]:
    """Compute the bulk stress at one crank angle for several distances from sharp corners.

    Bulk stress is the largest von Mises stress beyond this distance from corners and beyond `distance` [m] from narrow
    patches. If it varies with the distance from corners, it belongs to a corner. `index` is the index of the angle.
    Returns pairs of the distance from corners [m], one for each of `CORNER_DISTANCES`, and the bulk stress [Pa]; no
    pairs if the part has no such corners.
    """
    grid = part.grid
    if not len(grid.singular_points):
        return ()
    stress = von_mises(part.components(part.case.response(np.array([index])).displacements)[..., 0])
    stress_by_distance = []
    for factor in CORNER_DISTANCES:
        distances = measure_distances(replace(grid, corner_distance=factor * grid.corner_distance), part.case)
        patch_distance = min(distance, distances.farthest() * (1.0 - 1e-9))
        largest_stresses, _ = largest_beyond(distances, np.array([patch_distance]), index, stress)
        stress_by_distance.append((factor * grid.corner_distance, float(largest_stresses[0])))
    return tuple(stress_by_distance)


def stress_map(design: Design, grid: Grid, loads: PartLoads, index: int, distance: float | None = None) -> StressMap:
    """Compute the fields on a part at one crank angle: displacement, stress components, von Mises and principal stress.

    Parameters
    ----------
    design, grid, loads
        The design, the grid of one of its parts, and the loads on that part.
    index
        Index of the crank angle in the loads.
    distance
        Distance from contacts beyond which stress counts as bulk [m]; by default `grid.bulk_distance`.

    Raises
    ------
    UsageError
        There is no such index.
    CycloidError
        The grid has several pieces, a rigid motion is free, or the matrix cannot be factorised.
    """
    reducer = reducer_of(design)
    if not 0 <= index < len(loads.angle):
        raise UsageError(
            f"index = {index} is out of range: the loads have {len(loads.angle)} crank angles, so choose an index from "
            f"0 to {len(loads.angle) - 1}"
        )
    return evaluate_map(assemble_part(reducer, grid, loads), index, distance)


def evaluate_map(part: LoadedPart, index: int, distance: float | None = None) -> StressMap:
    """Compute displacement [m] and stresses [Pa] at all nodes of a part at one crank angle, for a picture.

    `index` is the index of the crank angle. Nodes beyond a `distance` [m] from contacts count as bulk, except those
    next to sharp corners. The default distance is `grid.bulk_distance`.
    """
    grid = part.grid
    node_displacements = part.case.response(np.array([index])).displacements
    stress = part.components(node_displacements)[..., 0]
    distances = part.distances.from_patches(index, np.arange(len(grid.points)))
    return StressMap(
        part=grid.part,
        angle=float(part.loads.angle[index]),
        points=grid.points,
        cells=grid.cells,
        displacement=node_displacements.reshape(-1, grid.dimension),
        stress=stress.T,
        von_mises=von_mises(stress),
        principal=principal(stress),
        bulk=distances >= (grid.bulk_distance if distance is None else distance),
    )
