"""The eccentric shaft under load: bearings, and unit loads whose sum is the load at any crank angle.

The cam's bearing presses on half of the cam: p(psi) = 2 F/(pi R L) max(0, cos psi), psi from the middle of the loaded
side. Its Fourier series, 1/pi + cos(psi)/2 + (2/pi) sum (-1)^(j+1) cos(2 j psi)/(4 j^2 - 1), turns with the force, so a
few unit loads serve all directions.

Two bearings, where the design has them, press on the shaft and do not pull: they are rows of radial springs that each
hold a pad of the journal, and open ones bear nothing (an active set of the few hundred pads decides which, from the
compliance between them). They hold nothing else, assumed; the crank's torque enters as shear on the end face.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from cycloid_mj.design import Design
from cycloid_mj.errors import CycloidError
from cycloid_mj.stress import elastic
from cycloid_mj.stress.case import Case, Response, mass_coefficients
from cycloid_mj.stress.grid import Grid
from cycloid_mj.stress.loads import PartLoads
from cycloid_mj.stress.shaftgrid import Shaft, shaft_measures
from cycloid_mj.stress.surface import surface, traction_loads
from cycloid_mj.types import Array, Integers, Mask

HARMONICS = (0, 1, 2, 4, 6, 8)
"""Orders of the pressure around the cam that are kept; what is left out is 0.4 % of the peak."""

BEARING_STIFFNESS = 0.1
"""Radial stiffness of a bearing over Young's modulus times journal radius, assumed: that of rolling bearings.

The softer they are, the more the two carry as statics says of point supports in their middles."""

SECTORS, STRIPS = 16, 4
"""Pads of a bearing round the journal and along it."""

CHORD = 0.05
"""Share of the radius by which the middle of a face's corners may lie below its cylinder."""

ROUNDS = 60
"""Rounds of the active set; it takes about five."""

ROUNDING = 1e-6
"""Share of the shaft's radius by which a point may miss the end face."""


@dataclass(frozen=True)
class Pads:
    """The pads of all bearings, p of them.

    Attributes
    ----------
    press
        Sparse (n, p): what a push of 1 N outwards, even over a pad, puts on the unknowns; transposed, it gives the mean
        displacement of each pad along its normal.
    stiffness
        Of the spring under each pad (p,) [N/m].
    """

    press: Any
    stiffness: Array

    @property
    def springs(self) -> Any:
        """Sparse (n, n) [N/m] of all springs, as if they pulled as well."""
        return (self.press @ sparse.diags(self.stiffness) @ self.press.T).tocsr()


def bearing_pads(grid: Grid, shaft: Shaft, stiffness: float) -> Pads:
    """Give the pads under a shaft, whose bearings have a radial stiffness [N/m] each.

    Half of a bearing presses: a bed of k per area takes k R w pi/2 as its force per radial displacement.

    Raises
    ------
    CycloidError
        The grid has no face in a bearing: it is too coarse.
    """
    press, springs = [], []
    for z0, z1 in shaft.bearings:
        face = surface(grid, lambda x, z0=z0, z1=z1: _on_cylinder(x, shaft.radius, 0.0) & (z0 < x[2]) & (x[2] < z1))  # type: ignore[misc]
        if not len(face.nodes):
            raise CycloidError("the shaft's grid has no face in one of its bearings: raise the refinement")
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


def opened(pads: Pads, compliance: Array, pressed: Array) -> Array:
    """Give the forces (p,) [N] outwards on the pads that take back what springs that pull would do.

    An open pad, whose mean displacement d is inwards, is pulled out by its spring with -k d: the force k d undoes it.
    d depends on the forces on all open pads, so their set is corrected until it is that of the pads with d < 0.

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
        No set of open pads is right: the bearings do not hold the shaft.
    """
    freed, displaced = np.zeros_like(pressed), pressed
    is_open: Mask = np.zeros(len(pressed), bool)
    for _ in range(ROUNDS):
        now = displaced < 0.0
        if np.array_equal(now, is_open):
            return freed
        is_open = now
        at = np.flatnonzero(is_open)
        freed = np.zeros_like(pressed)
        freed[at] = np.linalg.solve(np.diag(1.0 / pads.stiffness[at]) - compliance[np.ix_(at, at)], pressed[at])
        displaced = pressed + compliance[:, at] @ freed[at]
    raise CycloidError(
        "the bearings do not hold the shaft: no pattern of pressed places is in balance; check the shaft"
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
    steel = design.material_of("shaft")
    pads = bearing_pads(grid, shaft, BEARING_STIFFNESS * steel.youngs_modulus * shaft.radius)
    part = elastic.body(grid, steel, springs=pads.springs, loose=(2, 5))
    pressures = _pressures(grid, shaft)
    units = np.hstack([pressures, _couples(grid, shaft, pressures), elastic.mass_loads(part, grid.points)])
    units, imbalances = elastic.balanced(part, units)
    moved = elastic.displacements(part, units)
    shares = np.vstack([*_cam_shares(shaft, loads), mass_coefficients(loads)])
    relief, compliance = _relieved(part, pads)

    def response(block: Integers) -> Response:
        some = shares[:, block]
        freed = np.column_stack([opened(pads, compliance, pressed) for pressed in (pads.press.T @ (moved @ some)).T])
        forces, found = units @ some + pads.press @ freed, moved @ some + relief @ freed
        held = pads.press @ freed - pads.springs @ found
        return Response(
            forces=forces,
            moved=found,
            imbalance=some.T @ imbalances,
            reaction=held.T @ part.motions,
            moments=section_moments(grid.points, units @ some + held, shaft.stations),
        )

    return Case(part, response, np.zeros(0, np.int64), np.zeros((0, 2)))


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


def _relieved(part: elastic.Body, pads: Pads) -> tuple[Array, Array]:
    """Give displacements (n, p) under 1 N out on each pad, and the compliance (p, p) [m/N] between the pads."""
    loads, _ = elastic.balanced(part, pads.press.toarray())
    moved = elastic.displacements(part, loads)
    return moved, np.asarray(pads.press.T @ moved)


def section_moments(points: Array, forces: Array, places: Array) -> Array:
    """Give the moments about x, y and z (c, s, 3) [N m] that forces (3 n, c) [N] on nodes before places z (s,) hand on.

    About the axis, in the section at each place; they are in balance with what comes after it.
    """
    x, y, z = points.T
    fx, fy, fz = forces[0::3], forces[1::3], forces[2::3]
    found = []
    for place in places:
        before = z < place - ROUNDING
        arm = (z[before] - place)[:, np.newaxis]
        about_x = y[before] @ fz[before] - np.sum(arm * fy[before], axis=0)
        about_y = np.sum(arm * fx[before], axis=0) - x[before] @ fz[before]
        found.append(np.stack([about_x, about_y, x[before] @ fy[before] - y[before] @ fx[before]], axis=-1))
    return np.stack(found, axis=1)


def _on_cylinder(x: Array, radius: float, height: float) -> Mask:
    """Tell middles (3, f) [m] of faces on a cylinder, whose chords reach below it, from those on its end faces."""
    return np.abs(np.hypot(x[0], x[1] - height) - radius) < CHORD * radius


def _on_cam(x: Array, shaft: Shaft) -> Mask:
    return _on_cylinder(x, shaft.cam_radius, shaft.eccentricity) & (x[2] > shaft.cam[0]) & (x[2] < shaft.cam[1])


def _at_end(x: Array, shaft: Shaft) -> Mask:
    return x[2] - shaft.end < ROUNDING * shaft.radius


def _radial(normals: Array) -> Array:
    """Take the axial part, which only the grid has, from the normals of a cylinder."""
    return normals * np.array([1.0, 1.0, 0.0])


def _turned(vectors: Array) -> Array:
    """Turn vectors (..., 3) by a quarter about z: z x v."""
    return np.stack([-vectors[..., 1], vectors[..., 0], np.zeros(vectors.shape[:-1])], axis=-1)


def _resultant(loads: Array) -> Array:
    """Give the forces (2, c) in the plane of loads (n, c)."""
    return np.stack([loads[0::3].sum(axis=0), loads[1::3].sum(axis=0)])
