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
from typing import Any

import numpy as np
from scipy import sparse

from cycloid_mj.base import names
from cycloid_mj.base.array import Array, Integers, Mask, cross
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.parts.crank import ShaftDimensions, shaft_measures
from cycloid_mj.reducer import Reducer
from cycloid_mj.stress import elastic
from cycloid_mj.stress.case import LoadCase, Response, mass_coefficients
from cycloid_mj.stress.grid import Grid
from cycloid_mj.stress.loads import PartLoads
from cycloid_mj.stress.surface import surface, traction_loads

HARMONICS = (0, 1, 2, 4, 6, 8)
"""Orders of the pressure around the cam that are used; the remainder is 0.4 % of the peak."""

BEARING_STIFFNESS = 0.1
"""Radial stiffness of a bearing over Young's modulus times journal radius, assumed: that of rolling bearings.

The softer they are, the closer their loads are to those of point supports in their middles."""

SECTORS, STRIPS = 16, 4
"""Pads of a bearing around the journal and along it."""

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
    """Return the pads under a shaft, whose bearings have a radial stiffness [N/m] each.

    Half of a bearing presses: a bed of k per area takes k R w pi/2 as its force per radial displacement.

    Raises
    ------
    CycloidError
        The grid has no face in a bearing: it is too coarse.
    """
    press, springs = [], []
    for z0, z1 in shaft.bearings:
        face = surface(grid, lambda x, z0=z0, z1=z1: _on_cylinder(x, shaft.radius, AXIS) & (z0 < x[2]) & (x[2] < z1))  # type: ignore[misc]
        if not len(face.nodes):
            raise CycloidError(
                "the finite-element mesh of the shaft is too coarse: no element lies on the bearing seat from z = "
                f"{1e3 * z0:.4g} to {1e3 * z1:.4g} mm. Increase the refinement (without --quick, or "
                "GridSettings.refinement in Python)"
            )
        bed = stiffness / (np.pi / 2 * shaft.radius * (z1 - z0))
        x, y, z = face.points[..., 0], face.points[..., 1], face.points[..., 2]
        sector = np.floor(np.arctan2(y, x) / (2 * np.pi) * SECTORS).astype(int) % SECTORS
        strip = np.clip(((z - z0) / (z1 - z0) * STRIPS).astype(int), 0, STRIPS - 1)
        outwards = face.points * np.array([1.0, 1.0, 0.0]) / np.hypot(x, y)[..., np.newaxis]  # no moment about the axis
        for pad in range(SECTORS * STRIPS):
            chosen = sector * STRIPS + strip == pad
            area = float(face.area[chosen].sum())
            if area > 0.0:
                push = traction_loads(face, outwards * chosen[..., np.newaxis] / area)
                press.append(sparse.csc_matrix(push[:, np.newaxis]))
                springs.append(bed * area)
    return Pads(sparse.hstack(press).tocsc(), np.array(springs))


def solve_open_pads(pads: Pads, compliance: Array, pressed: Array) -> Array:
    """Compute the outward forces (p,) [N] on open pads that cancel the tension of their springs (active-set method).

    The spring of an open pad, with mean inward displacement d, would pull with -k d, which the force k d cancels. d
    depends on the forces on all open pads, so their set is iterated until it is that of the pads with d < 0.

    Parameters
    ----------
    pads
        The pads.
    compliance
        Displacement [m] of each pad under 1 N on each (p, p), with all springs.
    pressed
        Displacement of the pads [m] (p,) under the loads, with all springs.

    Raises
    ------
    CycloidError
        The active set does not converge: the bearings do not support the shaft.
    """
    freed, displaced = np.zeros_like(pressed), pressed
    is_open: Mask = np.zeros(len(pressed), bool)
    for _ in range(60):  # about five are usual
        pulls = displaced < 0.0
        if np.array_equal(pulls, is_open):
            return freed
        is_open = pulls
        at = np.flatnonzero(is_open)
        freed = np.zeros_like(pressed)
        freed[at] = np.linalg.solve(np.diag(1.0 / pads.stiffness[at]) - compliance[np.ix_(at, at)], pressed[at])
        displaced = pressed + compliance[:, at] @ freed[at]
    raise CycloidError(
        "the bearings cannot support the shaft under these loads: no distribution of bearing forces is in equilibrium. "
        "Check the bearings of the shaft (shaft.* in the design)"
    )


def shaft_case(reducer: Reducer, grid: Grid, loads: PartLoads) -> LoadCase:
    """Solve the unit loads of the shaft; each angle is a sum of them.

    Raises
    ------
    CycloidError
        A load acts elsewhere than on the cam.
    """
    shaft = shaft_measures(reducer)
    cams = tuple(names.of_disc(names.CAM, disc, len(shaft.cams)) for disc in range(len(shaft.cams)))
    if loads.part != "shaft" or loads.labels != cams:
        raise CycloidError(
            f"the shaft needs the loads of {', '.join(cams)}, but these loads are {', '.join(loads.labels) or 'none'} "
            f"on the {loads.part}: use the loads of the shaft"
        )
    steel = reducer.design.material_of("shaft")
    pads = bearing_pads(grid, shaft, BEARING_STIFFNESS * steel.youngs_modulus * shaft.radius)
    part = elastic.body(grid, steel, springs=pads.springs, loose=(2, 5))
    on_cams = [unit for cam in range(len(cams)) for unit in _on_cam_units(grid, shaft, cam)]
    units = np.hstack([*on_cams, _torsion(grid, shaft), elastic.mass_loads(part, grid.points)])
    units, imbalances = elastic.balance_loads(part, units)
    moved = elastic.displacements(part, units)
    on_cams = [share for cam in range(len(cams)) for share in _cam_shares(shaft, loads, cam)]
    shares = np.vstack([*on_cams, loads.torque, mass_coefficients(loads)])
    relief, compliance = _pad_compliance(part, pads)
    turns = section_turns(grid.points, shaft.stations)

    def response(block: Integers) -> Response:
        """Sum the unit loads at some angles, and open the pads in tension."""
        some = shares[:, block]
        freed = np.column_stack(
            [solve_open_pads(pads, compliance, pressed) for pressed in (pads.press.T @ (moved @ some)).T]
        )
        given, relieved = units @ some, pads.press @ freed
        displaced = moved @ some + relief @ freed
        on_pads = relieved - pads.springs @ displaced
        return Response(
            forces=given + relieved,
            moved=displaced,
            imbalance=some.T @ imbalances,
            reaction=on_pads.T @ part.motions,
            moments=np.tensordot(given + on_pads, turns, (0, 0)),
        )

    return LoadCase(part, response, len(loads.angle), np.zeros(0, np.int64), np.zeros((0, 2)))


def _cam_shares(shaft: ShaftDimensions, loads: PartLoads, cam: int) -> Iterator[Array]:
    """Yield the shares (k,) of the pressures on a cam, then of its couple, in the loads."""
    position = loads.position[:, cam]
    force = np.where(np.isfinite(position), loads.force[:, cam], 0.0)
    arm = np.nan_to_num(position) - shaft.cam_centres[cam]
    size, middle = np.hypot(force[..., 0], force[..., 1]), np.arctan2(-force[..., 1], -force[..., 0])
    for order in HARMONICS:
        weight = _half_cosine(order) / _half_cosine(1) * size
        yield weight * np.cos(order * middle)
        if order:
            yield weight * np.sin(order * middle)
    yield cross(arm, force)


def _half_cosine(order: int) -> float:
    """Compute a Fourier coefficient of max(0, cos)."""
    if order == 0:
        return 1 / np.pi
    return 0.5 if order == 1 else 2 / np.pi * (-1) ** (order // 2 + 1) / (order**2 - 1)


def _on_cam_units(grid: Grid, shaft: ShaftDimensions, number: int) -> tuple[Array, Array]:
    """Compute the unit loads on a cam: (n, 11) of pressures cos and sin (m phi) round it, and (n, 1) of a couple.

    The pressures of order 1 have a resultant of -1 N, the others none; what the grid leaves of it is taken away with
    those of order 1. The couple of 1 N m about the axis is shear round the cam.
    """
    cam = surface(grid, lambda x: _on_cam(x, shaft, number))
    x, y = shaft.cam_centres[number]
    phi = np.arctan2(cam.points[..., 1] - y, cam.points[..., 0] - x)
    waves = [wave(order * phi) for order in HARMONICS for wave in ((np.cos, np.sin) if order else (np.cos,))]
    loads = np.column_stack([traction_loads(cam, -wave[..., np.newaxis] * _radial(cam.normals)) for wave in waves])
    first = -loads[:, 1:3] @ np.linalg.inv(_resultant(loads[:, 1:3]))
    z0, z1 = shaft.cams[number]
    loads = loads / (np.pi * shaft.cam_radius * (z1 - z0))
    loads = loads + first @ _resultant(loads)
    loads[:, 1:3] = first
    couple = traction_loads(cam, _rotate_quarter(cam.normals))[:, np.newaxis]
    return loads, _of_unit_moment(grid, couple + first @ _resultant(couple))  # a couple has no resultant


def _torsion(grid: Grid, shaft: ShaftDimensions) -> Array:
    """Compute the load (n, 1) of 1 N m about z as the shear of torsion on the input end."""
    end = surface(grid, lambda x: _at_end(x, shaft))
    first = _on_cam_units(grid, shaft, 0)[0][:, 1:3]
    load = traction_loads(end, _rotate_quarter(end.points))[:, np.newaxis]
    return _of_unit_moment(grid, load + first @ _resultant(load))


def _of_unit_moment(grid: Grid, load: Array) -> Array:
    """Scale a load (n, 1) to 1 N m about z."""
    x, y = grid.points[:, 0], grid.points[:, 1]
    return np.asarray(load / (x @ load[1::3] - y @ load[0::3]))


def _pad_compliance(part: elastic.ElasticBody, pads: Pads) -> tuple[Array, Array]:
    """Compute displacements (n, p) under 1 N out on each pad, and the compliance (p, p) [m/N] between the pads."""
    loads, _ = elastic.balance_loads(part, pads.press.toarray())
    moved = elastic.displacements(part, loads)
    return moved, np.asarray(pads.press.T @ moved)


def section_turns(points: Array, positions: Array) -> Array:
    """Return the weights (3 n, s, 3) [m] of forces on nodes (n, 3) [m] in the moments of sections at places z (s,).

    The moments about x, y, z, about the axis in the section at each place, are those that the forces on nodes before it
    hand on; they are in balance with what comes after it.
    """
    before = points[:, 2, np.newaxis] < positions - 1e-6
    turns = [elastic.rigid_motions(points - (0.0, 0.0, height))[:, 3:] for height in positions]
    return np.stack(turns, axis=1) * np.repeat(before, 3, axis=0)[..., np.newaxis]


def _on_cylinder(x: Array, radius: float, centre: Array) -> Mask:
    """Return which middles (3, f) [m] of faces belong to a cylinder, with chords below it, and not to an end face."""
    return np.abs(np.hypot(x[0] - centre[0], x[1] - centre[1]) - radius) < 0.05 * radius


def _on_cam(x: Array, shaft: ShaftDimensions, number: int) -> Mask:
    z0, z1 = shaft.cams[number]
    return _on_cylinder(x, shaft.cam_radius, shaft.cam_centres[number]) & (x[2] > z0) & (x[2] < z1)


def _at_end(x: Array, shaft: ShaftDimensions) -> Mask:
    return x[2] - shaft.end < 1e-6 * shaft.radius


def _radial(normals: Array) -> Array:
    """Remove the axial component, which is an error of the grid, from the normals of a cylinder."""
    return normals * np.array([1.0, 1.0, 0.0])


def _rotate_quarter(vectors: Array) -> Array:
    """Turn vectors (..., 3) by a quarter about z: z x v."""
    return np.stack([-vectors[..., 1], vectors[..., 0], np.zeros(vectors.shape[:-1])], axis=-1)


def _resultant(loads: Array) -> Array:
    """Compute the forces (2, c) in the plane of loads (n, c)."""
    return np.stack([loads[0::3].sum(axis=0), loads[1::3].sum(axis=0)])
