"""Bending of the output pins as round beams, in series with the contacts of the discs."""

import math
from typing import TYPE_CHECKING

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.design.model import Material

if TYPE_CHECKING:
    from cycloid_mj.reducer import Reducer

AXIAL_GAP = 1e-3
"""Distance of the output disc and of the counterweight from the faces of the discs [m] (heuristic)."""


def pin_flexibility(reducer: "Reducer") -> Array:
    """Compute the flexibility matrix of an output pin, shape (D, D) [m/N]: deflection at each disc per force on each.

    D is the number of discs. The pin is a round beam. Its root, or both of its ends, is built in at the faces of the
    plates that support it, and its load acts in the middle of each disc. Shear adds to bending: Timoshenko's beam with
    Cowper's coefficient 6 (1 + nu)/(7 + 6 nu), with Poisson's ratio nu (Cowper 1966, J. Appl. Mech. 33, 335-340, Table
    1). If the pin has a roller, only the core bends. The matrix is zero for ``structure = "rigid"``.
    """
    design = reducer.design
    disc_planes, gear = np.array(design.gear.disc_planes), design.gear
    if design.structure == "rigid":
        return np.zeros((disc_planes.size, disc_planes.size))
    material, radius = design.material_of("output"), design.output.root_radius
    root_distances = gear.stack_width / 2.0 + AXIAL_GAP - disc_planes
    span = gear.stack_width + 2.0 * AXIAL_GAP
    return beam_flexibility(material, radius, root_distances, span if design.output.support == "both_ends" else None)


def beam_flexibility(material: Material, radius: float, arms: Array, length: float | None = None) -> Array:
    """Compute the flexibility matrix (n, n) [m/N] of a round cantilever: its deflection at n points per force at each.

    `arms` (n,) are the distances of the points from its root and `radius` is the radius of the beam [m], `material` has
    its modulus. With a `length` [m], its far end is built in as well (force method): the reactions there keep
    deflection and rotation 0.
    """
    bending, shearing = round_beam(material, radius)

    def cantilever(positions: Array, other_positions: Array) -> Array:
        """Return the deflections at positions per force at other positions [m/N], without the far support."""
        smaller_distance, larger_distance = (
            np.minimum.outer(positions, other_positions),
            np.maximum.outer(positions, other_positions),
        )
        return np.asarray(
            smaller_distance**2 * (3.0 * larger_distance - smaller_distance) / (6.0 * bending)
            + smaller_distance / shearing
        )

    flexibility = cantilever(arms, arms)
    if length is None:
        return flexibility
    far_end = np.array([length])
    coupling = np.stack([cantilever(arms, far_end)[:, 0], arms**2 / (2.0 * bending)], axis=1)
    end_rotation = length**2 / (2.0 * bending)
    end_flexibility = np.array([[cantilever(far_end, far_end)[0, 0], end_rotation], [end_rotation, length / bending]])
    return np.asarray(flexibility - coupling @ np.linalg.solve(end_flexibility, coupling.T))


def round_beam(material: Material, radius: float) -> tuple[float, float]:
    """Return the stiffness of a round beam in bending, E I [N m2], and in shear, kappa G A [N]."""
    bending = material.youngs_modulus * math.pi * radius**4 / 4.0
    return bending, shear_coefficient(material) * shear_modulus(material) * math.pi * radius**2


def shear_coefficient(material: Material) -> float:
    """Compute Cowper's shear coefficient of a round beam [1]."""
    return 6.0 * (1.0 + material.poisson) / (7.0 + 6.0 * material.poisson)


def shear_modulus(material: Material) -> float:
    """Compute the shear modulus E/(2 (1 + nu)) [Pa]."""
    return material.youngs_modulus / (2.0 * (1.0 + material.poisson))
