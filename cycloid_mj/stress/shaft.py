"""The eccentric shaft under load: bearings, and unit loads whose sum is the load at any crank angle.

The bearing presses on half of the cam: p(psi) = 2 F/(pi R L) max(0, cos psi), psi from the middle of the loaded
side. Its Fourier series, 1/pi + cos(psi)/2 + (2/pi) sum (-1)^(j+1) cos(2 j psi)/(4 j^2 - 1), rotates with the force, so
that a few unit loads are enough for all directions.

Two bearings, if the design has them, press on the shaft and do not pull: they are rows of radial springs, each on a pad
of the journal. Open pads carry no load; an active-set method determines them from the compliance between the few
hundred pads. Bearings have no other reaction (assumed). The crank's torque enters as shear on the end face.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy import sparse

from cycloid_mj.base import names
from cycloid_mj.base.array import Array, Integers, Mask, cross
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.parts.crank import ShaftDimensions, shaft_dimensions
from cycloid_mj.reducer import Reducer
from cycloid_mj.stress import elastic
from cycloid_mj.stress.case import LoadCase, Response, mass_coefficients
from cycloid_mj.stress.grid import Grid
from cycloid_mj.stress.loads import PartLoads
from cycloid_mj.stress.surface import select_surface, traction_loads


@dataclass(frozen=True)
class ShaftModel:
    """Model of the bearings on cams and journals.

    Attributes
    ----------
    harmonics
        Orders of the pressure around the cam that are used; the remainder is 0.4 % of the peak.
    bearing_stiffness
        Radial stiffness of a bearing over Young's modulus times journal radius, assumed: that of rolling bearings. The
        softer they are, the closer their loads are to those of point supports in their middles.
    sectors, strips
        Number of pads of a bearing around the journal and along it.
    """

    harmonics: tuple[int, ...] = (0, 1, 2, 4, 6, 8)
    bearing_stiffness: float = 0.1
    sectors: int = 16
    strips: int = 4


MODEL = ShaftModel()

AXIS = np.zeros(2)
"""Position of the journals' axis [m]."""


@dataclass(frozen=True)
class Pads:
    """Pads of all bearings, p in number.

    Attributes
    ----------
    press
        Loads on the unknowns by a uniform outward force of 1 N on each pad, sparse (n, p). Its transpose computes the
        mean displacement of each pad along its normal.
    stiffness
        Stiffness of the spring under each pad (p,) [N/m].
    """

    press: Any
    stiffness: Array

    @property
    def springs(self) -> Any:
        """Sparse (n, n) [N/m] of all springs, as if they pulled as well."""
        return (self.press @ sparse.diags(self.stiffness) @ self.press.T).tocsr()


def bearing_pads(grid: Grid, shaft: ShaftDimensions, stiffness: float) -> Pads:
    """Divide the bearing seats of a shaft into patches ("pads"); return unit load and elastic support of each.

    The unit load of a pad is a uniform outward pressure with a sum of 1 N, as nodal forces of `grid`, the
    finite-element mesh. `stiffness` [N/m] is the radial stiffness of a bearing.

    Raises
    ------
    CycloidError
        The grid has no face in a bearing: it is too coarse.
    """
    pad_loads, springs = [], []
    for z0, z1 in shaft.bearings:  # ends of the seat [m]
        seat_surface = select_surface(grid, partial(_on_seat, shaft, (z0, z1)))
        if not len(seat_surface.nodes):
            raise CycloidError(
                "the finite-element mesh of the shaft is too coarse: no element lies on the bearing seat from z = "
                f"{1e3 * z0:.4g} to {1e3 * z1:.4g} mm. Use a finer mesh: omit --quick or, in Python, increase "
                "GridSettings.refinement"
            )
        bed_stiffness = stiffness / (np.pi / 2 * shaft.radius * (z1 - z0))
        x, y, z = seat_surface.points[..., 0], seat_surface.points[..., 1], seat_surface.points[..., 2]
        sector = np.floor(np.arctan2(y, x) / (2 * np.pi) * MODEL.sectors).astype(int) % MODEL.sectors
        strip = np.clip(((z - z0) / (z1 - z0) * MODEL.strips).astype(int), 0, MODEL.strips - 1)
        outward_normals = (
            seat_surface.points * np.array([1.0, 1.0, 0.0]) / np.hypot(x, y)[..., np.newaxis]
        )  # no moment about the axis
        for pad in range(MODEL.sectors * MODEL.strips):
            is_in_pad = sector * MODEL.strips + strip == pad
            area = float(seat_surface.area[is_in_pad].sum())
            if area > 0.0:
                pad_load = traction_loads(seat_surface, outward_normals * is_in_pad[..., np.newaxis] / area)
                pad_loads.append(sparse.csc_matrix(pad_load[:, np.newaxis]))
                springs.append(bed_stiffness * area)
    return Pads(sparse.hstack(pad_loads).tocsc(), np.array(springs))


def solve_open_pads(pads: Pads, compliance: Array, loaded_displacements: Array) -> Array:
    """Compute the outward forces [N] (p,) by which p pads of bearing seats lift off; 0 for pads in compression.

    A pad is a patch of a bearing seat on an elastic support. Where the support would be in tension, the pad opens: the
    force k d cancels the tension of its spring of stiffness k at the outward displacement d < 0. d depends on the
    forces on all open pads. An active-set method therefore iterates the set of open pads.

    Parameters
    ----------
    pads
        The pads.
    compliance
        Displacement [m] of each pad under 1 N on each (p, p), with all springs.
    loaded_displacements
        Displacement of the pads [m] (p,) under the loads, with all springs.

    Raises
    ------
    CycloidError
        The active set does not converge: the bearings do not support the shaft.
    """
    forces, displacements = np.zeros_like(loaded_displacements), loaded_displacements
    is_open: Mask = np.zeros(len(loaded_displacements), bool)
    for _ in range(60):  # about five are usual
        is_in_tension = displacements < 0.0
        if np.array_equal(is_in_tension, is_open):
            return forces
        is_open = is_in_tension
        open_pads = np.flatnonzero(is_open)
        forces = np.zeros_like(loaded_displacements)
        forces[open_pads] = np.linalg.solve(
            np.diag(1.0 / pads.stiffness[open_pads]) - compliance[np.ix_(open_pads, open_pads)],
            loaded_displacements[open_pads],
        )
        displacements = loaded_displacements + compliance[:, open_pads] @ forces[open_pads]
    raise CycloidError(
        "the bearings cannot support the shaft under these loads: no distribution of bearing forces is in equilibrium. "
        "Check the positions of the bearings on the shaft (shaft.* in the design)"
    )


def shaft_case(reducer: Reducer, grid: Grid, loads: PartLoads) -> LoadCase:
    """Factorise the stiffness matrix of the shaft on its bearings; return a function of the crank angles.

    The function in the result (`LoadCase.response`) solves for displacements and support forces. `grid` is the
    finite-element mesh. The loads at each angle are a linear combination of unit loads, which are solved here. Bearings
    press on the shaft and do not pull.

    Raises
    ------
    CycloidError
        The loads do not act on the cams of the shaft.
    """
    shaft = shaft_dimensions(reducer)
    cam_names = tuple(names.of_disc(names.CAM, disc, len(shaft.cams)) for disc in range(len(shaft.cams)))
    if loads.part != "shaft" or loads.labels != cam_names:
        raise CycloidError(
            f"the stress of the shaft needs loads on {', '.join(cam_names)}, but the loads given act on the "
            f"{loads.part} at {', '.join(loads.labels) or 'no contact'}: pass the loads on the shaft"
        )
    material = reducer.design.material_of("shaft")
    pads = bearing_pads(grid, shaft, MODEL.bearing_stiffness * material.youngs_modulus * shaft.radius)
    part = elastic.assemble_body(grid, material, springs=pads.springs, loose=(2, 5))
    cam_loads = [
        unit_load for cam_index in range(len(cam_names)) for unit_load in _cam_unit_loads(grid, shaft, cam_index)
    ]
    unit_loads = np.hstack([*cam_loads, _torsion_load(grid, shaft), elastic.mass_loads(part, grid.points)])
    unit_loads, imbalances = elastic.equilibrate_loads(part, unit_loads)
    unit_displacements = elastic.displacements(part, unit_loads)
    cam_factors = [
        factor for cam_index in range(len(cam_names)) for factor in _cam_load_factors(shaft, loads, cam_index)
    ]
    load_factors = np.vstack([*cam_factors, loads.torque, mass_coefficients(loads)])
    unit_pad_displacements, compliance = _pad_compliance(part, pads)
    moment_weights = section_moment_weights(grid.points, shaft.stations)

    def solve_response(angle_indices: Integers) -> Response:
        """Solve for displacements, support forces and section moments at c crank angles with `angle_indices`, (c,).

        Bearings press on the shaft and do not pull: the opening force on a pad cancels the tension of its spring.
        """
        weights = load_factors[:, angle_indices]
        opening_forces = np.column_stack(
            [
                solve_open_pads(pads, compliance, pad_displacements)
                for pad_displacements in (pads.press.T @ (unit_displacements @ weights)).T
            ]
        )
        applied_forces, pad_relief_forces = unit_loads @ weights, pads.press @ opening_forces
        displacements = unit_displacements @ weights + unit_pad_displacements @ opening_forces
        pad_forces = pad_relief_forces - pads.springs @ displacements
        return Response(
            forces=applied_forces + pad_relief_forces,
            displacements=displacements,
            imbalance=weights.T @ imbalances,
            reaction=pad_forces.T @ part.motions,
            moments=np.tensordot(applied_forces + pad_forces, moment_weights, (0, 0)),
        )

    return LoadCase(part, solve_response, len(loads.angle), np.zeros(0, np.int64), np.zeros((0, 2)))


def _cam_load_factors(shaft: ShaftDimensions, loads: PartLoads, cam_index: int) -> Iterator[Array]:
    """Yield the factor of each unit load of a cam, in the order of `_cam_unit_loads`, at k crank angles, (k,).

    The sum of the unit loads times their factors is the load on the cam. First come the factors of the pressures [N]:
    for each harmonic the factor of the cosine and of the sine (order 0 has no sine). The last factor is the moment
    about the centre of the cam [N m]. The pressure is distributed as the cosine over half of the cam.

    Parameters
    ----------
    shaft, loads
        Dimensions of the shaft, and the loads on its cams.
    cam_index
        Index of the cam.
    """
    position = loads.position[:, cam_index]
    force = np.where(np.isfinite(position), loads.force[:, cam_index], 0.0)
    arm = np.nan_to_num(position) - shaft.cam_centres[cam_index]
    magnitude, direction = np.hypot(force[..., 0], force[..., 1]), np.arctan2(-force[..., 1], -force[..., 0])
    for order in MODEL.harmonics:
        weight = _half_cosine(order) / _half_cosine(1) * magnitude
        yield weight * np.cos(order * direction)
        if order:
            yield weight * np.sin(order * direction)
    yield cross(arm, force)


def _half_cosine(order: int) -> float:
    """Compute the Fourier coefficient of max(0, cos) of an order that is 0, 1 or even."""
    if order == 0:
        return 1 / np.pi
    return 0.5 if order == 1 else 2 / np.pi * (-1) ** (order // 2 + 1) / (order**2 - 1)


def _cam_unit_loads(grid: Grid, shaft: ShaftDimensions, cam_index: int) -> tuple[Array, Array]:
    """Compute the nodal forces [N] of 11 unit pressures on a cam, (n, 11) for n unknowns, and of a couple, (n, 1).

    `cam_index` is the index of the cam on the `shaft`, `grid` the finite-element mesh. The pressures vary around the
    cam as the cosine and sine of multiples of the angle, `MODEL.harmonics`. Those of order 1 have the resultants -1 N
    along x and y, the others have none. The couple of 1 N m about z is shear around the cam, without resultant.
    """
    cam_surface = select_surface(grid, lambda x: _on_cam(x, shaft, cam_index))
    x, y = shaft.cam_centres[cam_index]
    angle = np.arctan2(cam_surface.points[..., 1] - y, cam_surface.points[..., 0] - x)
    waves = [wave(order * angle) for order in MODEL.harmonics for wave in ((np.cos, np.sin) if order else (np.cos,))]
    pressure_loads = np.column_stack(
        [traction_loads(cam_surface, -wave[..., np.newaxis] * _radial(cam_surface.normals)) for wave in waves]
    )
    unit_forces = -pressure_loads[:, 1:3] @ np.linalg.inv(_resultant(pressure_loads[:, 1:3]))
    z0, z1 = shaft.cams[cam_index]
    pressure_loads = pressure_loads / (np.pi * shaft.cam_radius * (z1 - z0))
    pressure_loads = pressure_loads + unit_forces @ _resultant(pressure_loads)
    pressure_loads[:, 1:3] = unit_forces
    couple = traction_loads(cam_surface, _rotate_quarter(cam_surface.normals))[:, np.newaxis]
    return pressure_loads, _scale_to_unit_moment(
        grid, couple + unit_forces @ _resultant(couple)
    )  # a couple has no resultant


def _torsion_load(grid: Grid, shaft: ShaftDimensions) -> Array:
    """Compute the nodal load (n, 1) of 1 N m about z as shear of torsion on the input end."""
    end = select_surface(grid, lambda x: x[2] - shaft.end < 1e-6 * shaft.radius)
    force_loads = _cam_unit_loads(grid, shaft, 0)[0][:, 1:3]
    load = traction_loads(end, _rotate_quarter(end.points))[:, np.newaxis]
    return _scale_to_unit_moment(grid, load + force_loads @ _resultant(load))


def _scale_to_unit_moment(grid: Grid, load: Array) -> Array:
    """Scale nodal forces (n, 1) so that their moment about z is 1 N m."""
    x, y = grid.points[:, 0], grid.points[:, 1]
    return np.asarray(load / (x @ load[1::3] - y @ load[0::3]))


def _pad_compliance(part: elastic.ElasticBody, pads: Pads) -> tuple[Array, Array]:
    """Compute the displacements (n, p) under an outward force of 1 N on each pad, and the compliance (p, p) [m/N]."""
    loads, _ = elastic.equilibrate_loads(part, pads.press.toarray())
    displacements = elastic.displacements(part, loads)
    return displacements, np.asarray(pads.press.T @ displacements)


def section_moment_weights(points: Array, positions: Array) -> Array:
    """Return the weights of nodal forces in the moments in s cross-sections of the shaft [m], shape (3 n, s, 3).

    The moment in a section is caused by the forces on all nodes with a smaller z. It is about x, y and z (last axis)
    through the point of the section on the shaft's axis.

    Parameters
    ----------
    points
        The n nodes (n, 3) [m].
    positions
        z of the sections (s,) [m].
    """
    is_before = points[:, 2, np.newaxis] < positions - 1e-6
    rotations = [elastic.rigid_motions(points - (0.0, 0.0, height))[:, 3:] for height in positions]
    return np.stack(rotations, axis=1) * np.repeat(is_before, 3, axis=0)[..., np.newaxis]


def _on_cylinder(x: Array, radius: float, centre: Array) -> Mask:
    """Return which middles (3, f) [m] of faces belong to a cylinder, with chords below it, and not to an end face."""
    return np.abs(np.hypot(x[0] - centre[0], x[1] - centre[1]) - radius) < 0.05 * radius


def _on_seat(shaft: ShaftDimensions, seat_ends: tuple[float, float], x: Array) -> Mask:
    return _on_cylinder(x, shaft.radius, AXIS) & (seat_ends[0] < x[2]) & (x[2] < seat_ends[1])


def _on_cam(x: Array, shaft: ShaftDimensions, cam_index: int) -> Mask:
    z0, z1 = shaft.cams[cam_index]
    return _on_cylinder(x, shaft.cam_radius, shaft.cam_centres[cam_index]) & (x[2] > z0) & (x[2] < z1)


def _radial(normals: Array) -> Array:
    """Remove the axial component, which is an error of the grid, from the normals of a cylinder."""
    return normals * np.array([1.0, 1.0, 0.0])


def _rotate_quarter(vectors: Array) -> Array:
    """Turn vectors (..., 3) by a quarter about z: z x v."""
    return np.stack([-vectors[..., 1], vectors[..., 0], np.zeros(vectors.shape[:-1])], axis=-1)


def _resultant(loads: Array) -> Array:
    """Compute the forces (2, c) in the plane of loads (n, c)."""
    return np.stack([loads[0::3].sum(axis=0), loads[1::3].sum(axis=0)])
