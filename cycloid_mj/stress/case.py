"""A factorised load case of a part: each crank angle is one right-hand side, or a sum of unit loads."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.names import disc_of
from cycloid_mj.reducer import Reducer
from cycloid_mj.stress import elastic
from cycloid_mj.stress.elastic import ElasticBody
from cycloid_mj.stress.grid import Grid, SectionGrid
from cycloid_mj.stress.loads import PartLoads, select_contacts
from cycloid_mj.stress.patch import distribute_contacts
from cycloid_mj.stress.region import material_of


@dataclass(frozen=True)
class Response:
    """Response of a part to its loads at c angles.

    Attributes
    ----------
    forces, displacements
        Balanced loads on its unknowns (n, c) [N], and displacements (n, c) [m].
    imbalance
        Imbalance of the loads (c, r), as in ``elastic.equilibrate_loads``.
    reaction
        Resultants of the supports (c, r), as in ``elastic.reactions``.
    moments
        Moments about x, y and z at the stations of the shaft (c, s, 3) [N m]; other parts have none.
    """

    forces: Array
    displacements: Array
    imbalance: Array
    reaction: Array
    moments: Array


@dataclass(frozen=True)
class LoadCase:
    """A part with its loads, ready for any angles.

    Attributes
    ----------
    body
        The factorised part.
    response
        Function from indices of angles (c,) to the response.
    angles
        Number of angles.
    angle, points
        Index of the angle (p,) and centre (p, 2) [m] of each narrow patch, about which stress falls as 1/distance.
    """

    body: ElasticBody
    response: Callable[[Integers], Response]
    angles: int
    angle: Integers
    points: Array


def patch_case(reducer: Reducer, grid: Grid, loads: PartLoads) -> LoadCase:
    """Factorise the stiffness matrix of a part; return it with a function that solves for the displacements.

    The function takes indices of the crank angles of `loads`. The result (`LoadCase`) also has the narrow contact
    patches: Hertz's strips, without conformal contacts and rows of rollers. `grid` is the finite-element mesh of the
    part. The loads at a crank angle are contact pressure, weight and inertia. The load torque of the output acts at its
    hub, where the supports carry it. Loads on a part without supports are in equilibrium with its acceleration
    (d'Alembert).
    """
    contact_patches = distribute_contacts(grid if grid.section is None else grid.section.grid, loads)
    contact_loads = contact_patches.loads if grid.section is None else _extrude_loads(grid.section, loads)
    body = elastic.assemble_body(grid, material_of(reducer, grid.part))
    unit_mass_loads, mass_factors = elastic.mass_loads(body, grid.points), mass_coefficients(loads)
    contact_accelerations, imbalance = elastic.solve_accelerations(body, contact_loads)
    mass_accelerations, mass_imbalance = elastic.solve_accelerations(body, unit_mass_loads)
    imbalance += mass_factors.T @ mass_imbalance
    # both are spread over the mass: one dense product at each angle, and few forces of contacts
    unit_nodal_forces, force_factors = (
        np.hstack([unit_mass_loads, body.carried]),
        np.vstack([mass_factors, -contact_accelerations - mass_accelerations @ mass_factors]),
    )

    def solve_response(angle_indices: Integers) -> Response:
        """Solve for the response to the loads at the angles with these indices, shape (c,)."""
        contact_entries = contact_loads[:, angle_indices].tocoo()
        forces = unit_nodal_forces @ force_factors[:, angle_indices]
        forces[contact_entries.row, contact_entries.col] += contact_entries.data
        displacement = elastic.displacements(body, forces)
        reaction = elastic.reactions(body, displacement, forces)
        return Response(forces, displacement, imbalance[angle_indices], reaction, np.zeros((len(angle_indices), 0, 3)))

    return LoadCase(body, solve_response, len(loads.angle), contact_patches.angle, contact_patches.points)


def _extrude_loads(section: SectionGrid, loads: PartLoads) -> Any:
    """Return the nodal loads [N] of the contact forces on an extruded solid at k angles, a sparse matrix (n, k).

    `loads` are those of the part. The forces on the planar mesh, `section`, are distributed over the width of the disc
    on which they act; n is the number of the solid's unknowns.
    """
    discs = np.array([disc_of(label) for label in loads.labels])
    disc_loads = [
        distribution
        @ distribute_contacts(
            section.grid, loads if len(section.distributions) == 1 else select_contacts(loads, discs == disc)
        ).loads
        for disc, distribution in enumerate(section.distributions)
    ]
    return sum(disc_loads[1:], disc_loads[0]).tocsc()


def mass_coefficients(loads: PartLoads) -> Array:
    """Compute the factors (4, k) of the four columns of ``elastic.mass_loads`` in weight and inertia at k angles."""
    return np.vstack([loads.body_force.T, loads.spin**2, loads.spin_rate])
