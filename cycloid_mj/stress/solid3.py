"""The eccentric shaft as a solid body: tetrahedra, bearings, and unit loads whose sum is the load at any crank angle.

The cam's bearing presses on half of the cam: p(psi) = 2 F/(pi R L) max(0, cos psi), psi from the middle of the loaded
side. Its Fourier series, 1/pi + cos(psi)/2 + (2/pi) sum (-1)^(j+1) cos(2 j psi)/(4 j^2 - 1), turns with the force, so a
few unit loads serve all directions.

Assumed, since the design leaves it open: two bearings on the input journal, one at its end and one before the
counterweight, which are elastic radially and hold nothing else; the crank's torque enters as shear on the end face.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from cycloid_mj.design import Design
from cycloid_mj.errors import CycloidError
from cycloid_mj.solid import shaft_solid
from cycloid_mj.stress import elastic
from cycloid_mj.stress.field import Case, PartStress, mass_coefficients, solve
from cycloid_mj.stress.grid import Grid, GridSettings, quadratic
from cycloid_mj.stress.loads import PartLoads
from cycloid_mj.stress.packages import MILLIMETRES, mesher
from cycloid_mj.stress.surface import foundation, surface, traction_loads

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
Flags = npt.NDArray[np.bool_]

HARMONICS = (0, 1, 2, 4, 6, 8)
"""Orders of the pressure around the cam that are kept; what is left out is 0.4 % of the peak."""

BEARING_STIFFNESS = 0.1
"""Radial stiffness of a bearing over Young's modulus times journal radius; two bearings carry as statics says."""

CORNER_DISTANCE = 0.15
"""Share of the shaft's radius by which the bulk keeps off sharp inner corners, which in truth have fillets."""

CORNER_EDGE = 1 / 3
"""Edges at the inner corners as a share of those elsewhere."""

ROUNDING = 1e-6
"""Share of the shaft's radius by which a point may miss the end face."""

CHORD = 0.05
"""Share of the radius by which the middle of a face's corners may lie below its cylinder."""


@dataclass(frozen=True)
class Shaft:
    """Measures of the shaft [m]: radii, eccentricity, and along z its end, counterweight and cam."""

    radius: float
    cam_radius: float
    eccentricity: float
    counterweight_radius: float
    end: float
    counterweight: tuple[float, float]
    cam: tuple[float, float]

    @property
    def bearings(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Stretches of the journal in the two bearings: as long as its radius, or a third of it."""
        z0, z1 = self.end, self.counterweight[0]
        width = min(self.radius, (z1 - z0) / 3)
        return (z0, z0 + width), (z1 - width, z1)


def shaft_measures(design: Design) -> Shaft:
    """Give the measures of a design's balanced shaft."""
    journal, counterweight, _, cam = shaft_solid(design).prisms
    return Shaft(
        radius=design.shaft.radius,
        cam_radius=design.gear.bore_radius,
        eccentricity=design.gear.eccentricity,
        counterweight_radius=design.shaft.counterweight_radius,
        end=journal.z0,
        counterweight=(counterweight.z0, counterweight.z1),
        cam=(cam.z0, cam.z1),
    )


def shaft_stress(
    design: Design,
    loads: PartLoads,
    settings: GridSettings | None = None,
    progress: Callable[[float], None] | None = None,
) -> PartStress:
    """Give the maxima of stress in the shaft at each crank angle of its loads; see ``solve``.

    Raises
    ------
    CycloidError
        The loads are not on the cam, the shaft does not mesh, or a package of the extra ``fem`` is missing.
    """
    return solve(design, shaft_grid(design, GridSettings() if settings is None else settings), loads, progress)


def shaft_grid(design: Design, settings: GridSettings) -> Grid:
    """Give the grid of the shaft in the frame of its solid: the reducer axis, cam towards +y.

    Raises
    ------
    CycloidError
        The shaft does not mesh, or a package of the extra ``fem`` is missing.
    """
    shaft = shaft_measures(design)
    edge = settings.solid_edge * shaft.radius / settings.refinement
    return Grid(
        part="shaft",
        mesh=_tetrahedra(shaft, edge),
        thickness=1.0,
        loops=(),
        held=np.zeros(0, np.int64),
        bulk_distance=CORNER_DISTANCE * shaft.radius,
        keep_off=_inner_corners(shaft),
    )


def shaft_case(design: Design, grid: Grid, loads: PartLoads) -> Case:
    """Solve the unit loads of the shaft; each angle is a sum of them.

    Raises
    ------
    CycloidError
        A load acts elsewhere than on the cam.
    """
    if loads.part != "shaft" or any(label != "cam" for label in loads.labels):
        raise CycloidError(
            f"the shaft's grid takes the loads of its cam, got {', '.join(loads.labels) or 'none'} on the {loads.part}"
        )
    shaft = shaft_measures(design)
    part = elastic.body(grid, design.material, springs=_bearings(grid, shaft, design), loose=(2, 5))
    pressures = _pressures(grid, shaft)
    units = np.hstack([pressures, _couples(grid, shaft, pressures), elastic.mass_loads(part, grid.points)])
    units, imbalances = elastic.balanced(part, units)
    moved = elastic.displacements(part, units)
    shares = np.vstack([*_cam_shares(shaft, loads), mass_coefficients(loads)])

    def response(block: Indices) -> tuple[Array, Array, Array]:
        some = shares[:, block]
        return units @ some, moved @ some, some.T @ imbalances

    nowhere, none = np.zeros(0, np.int64), np.zeros(0, bool)
    return Case(part, response, nowhere, np.zeros((0, 3)), none, np.zeros(len(loads.angle), bool))


def _cam_shares(shaft: Shaft, loads: PartLoads) -> Iterator[Array]:
    """Give the shares (units, k) of the pressures, then of the couples, in the loads."""
    force = np.where(np.isfinite(loads.place), loads.force, 0.0)
    arm = np.nan_to_num(loads.place) - np.array([0.0, shaft.eccentricity])
    size, middle = np.hypot(force[..., 0], force[..., 1]), np.arctan2(-force[..., 1], -force[..., 0])
    for order in HARMONICS:
        weight = _half_cosine(order) / _half_cosine(1) * size
        yield np.sum(weight * np.cos(order * middle), axis=1)[np.newaxis]
        if order:
            yield np.sum(weight * np.sin(order * middle), axis=1)[np.newaxis]
    couple = np.sum(arm[..., 0] * force[..., 1] - arm[..., 1] * force[..., 0], axis=1)
    yield couple[np.newaxis]
    yield loads.torque[np.newaxis]


def _half_cosine(order: int) -> float:
    """Fourier coefficient of max(0, cos)."""
    if order == 0:
        return 1 / np.pi
    return 0.5 if order == 1 else 2 / np.pi * (-1) ** (order // 2 + 1) / (order**2 - 1)


def _pressures(grid: Grid, shaft: Shaft) -> Array:
    """Give loads (n, 11) of pressures cos and sin (m phi) round the cam; those of order 1 have a resultant of -1 N.

    The other orders have no resultant; what the grid leaves of it is taken away with those of order 1.
    """
    cam = surface(grid, lambda x: _on_cam(x, shaft))
    phi = np.arctan2(cam.points[..., 1] - shaft.eccentricity, cam.points[..., 0])
    waves = [wave(order * phi) for order in HARMONICS for wave in ((np.cos, np.sin) if order else (np.cos,))]
    loads = np.column_stack([traction_loads(cam, -wave[..., np.newaxis] * _radial(cam.normals)) for wave in waves])
    first = -loads[:, 1:3] @ np.linalg.inv(_resultant(loads[:, 1:3]))
    loads = loads / (np.pi * shaft.cam_radius * (shaft.cam[1] - shaft.cam[0]))
    loads = loads + first @ _resultant(loads)
    loads[:, 1:3] = first
    return loads


def _couples(grid: Grid, shaft: Shaft, pressures: Array) -> Array:
    """Give loads (n, 2) of 1 N m about z: as shear round the cam, and as that of torsion on the input end."""
    cam, end = surface(grid, lambda x: _on_cam(x, shaft)), surface(grid, lambda x: _at_end(x, shaft))
    loads = np.column_stack([traction_loads(cam, _turned(cam.normals)), traction_loads(end, _turned(end.points))])
    loads = loads + pressures[:, 1:3] @ _resultant(loads)  # a couple has no resultant
    x, y = grid.points[:, 0], grid.points[:, 1]
    return loads / (x @ loads[1::3] - y @ loads[0::3])


def _bearings(grid: Grid, shaft: Shaft, design: Design) -> Any:
    """Springs along the normal of the journal in its bearings."""
    stiffness = BEARING_STIFFNESS * design.material.youngs_modulus * shaft.radius
    return sum(
        foundation(
            surface(grid, lambda x, z0=z0, z1=z1: _on_journal(x, shaft, z0, z1)),  # type: ignore[misc]
            stiffness / (np.pi * shaft.radius * (z1 - z0)),
        )
        for z0, z1 in shaft.bearings
    )


def _on_cam(x: Array, shaft: Shaft) -> Flags:
    return _on_cylinder(x, shaft.cam_radius, shaft.eccentricity) & (x[2] > shaft.cam[0]) & (x[2] < shaft.cam[1])


def _on_journal(x: Array, shaft: Shaft, z0: float, z1: float) -> Flags:
    return _on_cylinder(x, shaft.radius, 0.0) & (z0 < x[2]) & (x[2] < z1)


def _at_end(x: Array, shaft: Shaft) -> Flags:
    return x[2] - shaft.end < ROUNDING * shaft.radius


def _on_cylinder(x: Array, radius: float, height: float) -> Flags:
    """Tell middles of faces on a cylinder, whose chords reach below it, from those on its end faces."""
    return np.abs(np.hypot(x[0], x[1] - height) - radius) < CHORD * radius


def _radial(normals: Array) -> Array:
    """Take the axial part, which only the grid has, from the normals of a cylinder."""
    return normals * np.array([1.0, 1.0, 0.0])


def _turned(vectors: Array) -> Array:
    """Turn vectors (..., 3) by a quarter about z: z x v."""
    return np.stack([-vectors[..., 1], vectors[..., 0], np.zeros(vectors.shape[:-1])], axis=-1)


def _resultant(loads: Array) -> Array:
    """Give the forces (2, c) in the plane of loads (n, c)."""
    return np.stack([loads[0::3].sum(axis=0), loads[1::3].sum(axis=0)])


def _inner_corners(shaft: Shaft) -> Array:
    """Points along the sharp inner edges: at both faces and the flats of the counterweight, and at the cam's face."""
    step = CORNER_DISTANCE * shaft.radius / 8
    turn = np.linspace(0, 2 * np.pi, int(np.ceil(2 * np.pi * shaft.radius / step)))
    x, y = shaft.radius * np.cos(turn), shaft.radius * np.sin(turn)
    z0, z1 = shaft.counterweight
    rings = [
        np.column_stack([x[keep], y[keep], np.full(keep.sum(), z)])
        for z, keep in ((z0, y <= 0), (z1, y <= 0), (shaft.cam[0], y < np.inf))
    ]
    z = np.linspace(z0, z1, int(np.ceil((z1 - z0) / step)) + 1)
    flats = [np.column_stack([np.full(len(z), side * shaft.radius), np.zeros(len(z)), z]) for side in (-1, 1)]
    return np.concatenate([*rings, *flats])


def _tetrahedra(shaft: Shaft, edge: float) -> Any:
    """Let gmsh's OpenCASCADE join the shaft's cylinders, and fill them; edges are finer at the inner corners."""
    with mesher("shaft", edge) as gmsh:
        occ = gmsh.model.occ
        _cylinder(occ, 0.0, shaft.radius, shaft.end, shaft.cam[0])
        weight = _cylinder(occ, 0.0, shaft.counterweight_radius, *shaft.counterweight, angle=np.pi)
        occ.rotate([(3, weight)], 0, 0, 0, 0, 0, 1, np.pi)
        _cylinder(occ, shaft.eccentricity, shaft.cam_radius, *shaft.cam)
        solids, _ = occ.fuse([(3, 1)], [(3, 2), (3, 3)])
        occ.synchronize()
        if len(solids) != 1:
            raise CycloidError("the shaft does not mesh: its stretches do not make one solid; check the design")
        _finer_at(gmsh, _inner_corners(shaft), edge)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, nodes = gmsh.model.mesh.getElementsByType(11)
    return _from_gmsh(tags, coordinates.reshape(-1, 3) / MILLIMETRES, nodes.reshape(-1, 10))


def _cylinder(occ: Any, height: float, radius: float, z0: float, z1: float, angle: float = 2 * np.pi) -> int:
    mm = MILLIMETRES
    return int(occ.addCylinder(0, height * mm, z0 * mm, 0, 0, (z1 - z0) * mm, radius * mm, angle=angle))


def _finer_at(gmsh: Any, places: Array, edge: float) -> None:
    """Let edges grow from a share of the longest at some places to the longest at one longest edge from there."""
    field, longest = gmsh.model.mesh.field, edge * MILLIMETRES
    near = field.add("Distance")
    points = [gmsh.model.geo.addPoint(*place) for place in places[::8] * MILLIMETRES]
    gmsh.model.geo.synchronize()
    field.setNumbers(near, "PointsList", points)
    grow = field.add("Threshold")
    for name, value in (
        ("InField", near),
        ("SizeMin", CORNER_EDGE * longest),
        ("SizeMax", longest),
        ("DistMin", 0.0),
        ("DistMax", 2 * longest),
    ):
        field.setNumber(grow, name, value)
    field.setAsBackgroundMesh(grow)


def _from_gmsh(tags: Any, points: Array, nodes: Any) -> Any:
    """Make the quadratic mesh from gmsh's tetrahedra of ten nodes."""
    place = np.zeros(int(tags.max()) + 1, np.int64)
    place[tags.astype(np.int64)] = np.arange(len(tags))
    cells = place[nodes.astype(np.int64)]
    corners, index = np.unique(cells[:, :4], return_inverse=True)
    cell = index.reshape(-1, 4)
    pairs = [(0, 1), (1, 2), (2, 0), (3, 0), (3, 2), (3, 1)]
    ends = np.concatenate([cell[:, list(pair)] for pair in pairs])
    mesh, _ = quadratic(points[corners], cell, ends, points[cells[:, 4:].T.ravel()], "shaft")
    return mesh
