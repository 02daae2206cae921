"""Bearing forces of shaft, output and ring with several discs: statics in space.

The forces of each disc act in its own plane. Forces of two discs may cancel; their couples, force times spacing, do
not.
"""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.deprecated import deprecated_attribute
from cycloid_mj.parts.shaft import bearing_seats
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP
from cycloid_mj.statics.balance import Loads
from cycloid_mj.statics.springs import Springs


@dataclass(frozen=True, eq=False)
class Planes:
    """In-plane forces of the discs on a part, in the plane of each disc.

    Attributes
    ----------
    force
        Forces [N], shape (m, D, 2).
    axial_position
        Axial positions of the planes [m], shape (D,), from the middle of all discs.
    """

    force: Array
    axial_position: Array

    place = deprecated_attribute("Planes", "place", "axial_position")

    @property
    def net(self) -> Array:
        """Sum of the forces [N], shape (m, 2)."""
        return np.asarray(self.force.sum(axis=1))

    @property
    def moment(self) -> Array:
        """Tilting moment about the middle of all discs [N m], shape (m, 2): about x, and about y."""
        x, y = np.einsum("d,mdi->im", self.axial_position, self.force)
        return np.stack([-y, x], axis=1)

    def reactions_at(self, far_position: float, near_position: float) -> tuple[Array, Array]:
        """Compute the reactions of two bearings to the forces on a part, as a beam on two supports.

        Parameters
        ----------
        far_position, near_position
            Axial positions of the two bearings [m], in the coordinate of `axial_position`.

        Returns
        -------
        tuple of Array
            Forces [N] on the part by the bearing at `far_position`, then by that at `near_position`, shape (m, 2) each.
        """
        near_share = (self.axial_position - far_position) / (near_position - far_position)
        near_reaction = -np.einsum("d,mdi->mi", near_share, self.force)
        return -self.net - near_reaction, near_reaction


@dataclass(frozen=True, eq=False)
class Reactions:
    """Forces of the discs on shaft, output and ring, and reactions of the bearings, shape (m, 2) [N].

    Attributes
    ----------
    shaft, output, ring
        Forces of the discs on the part.
    shaft_far, shaft_near
        Reactions of the shaft's bearings far from and near the discs.
    output_far, output_near
        Reactions of the bearings of two output discs: next to the motor, and away from it. None for a single output
        disc, whose bearing supports the total force and moment.
    """

    shaft: Planes
    output: Planes
    ring: Planes
    shaft_far: Array
    shaft_near: Array
    output_far: Array | None
    output_near: Array | None


def compute_reactions(reducer: Reducer, springs: Springs, contact_loads: Loads) -> Reactions:
    """Compute the forces of the D discs on shaft, output and ring, and the bearing reactions, at m crank angles.

    Weight and unbalance of shaft and output are left out.

    Parameters
    ----------
    reducer, springs
        The reducer, and its contact springs at the m crank angles.
    contact_loads
        Contact forces of these springs.

    Returns
    -------
    Reactions
        Forces of the discs (m, D, 2) [N], and reactions of the bearings (m, 2) [N].
    """
    ring_force = _react_by_disc(contact_loads.teeth, springs.directions[:, : springs.teeth], contact_loads.discs)
    return compute_spatial_reactions(reducer, -contact_loads.cam, output_forces(springs, contact_loads), ring_force)


def output_forces(springs: Springs, contact_loads: Loads) -> Array:
    """Compute the force of each of D discs on all output pins together [N] at m crank angles, shape (m, D, 2)."""
    return _react_by_disc(contact_loads.output, springs.directions[:, springs.teeth :], contact_loads.discs)


def _react_by_disc(forces: Array, directions: Array, discs: int) -> Array:
    """Compute the force by which each of D discs reacts to the normal forces on it [N], shape (m, D, 2).

    `forces` (m, D n) [N] act on the discs along the unit vectors `directions` (m, D n, 2).
    """
    reactions = (forces[..., np.newaxis] * directions).reshape(len(forces), discs, -1, 2)
    return np.asarray(-reactions.sum(axis=2))


def compute_spatial_reactions(reducer: Reducer, shaft: Array, output: Array, ring: Array) -> Reactions:
    """Compute the reactions of the bearings [N] to known forces of each of the D discs on shaft, output and ring.

    `shaft`, `output` and `ring` are the forces on these parts [N], shape (m, D, 2) each. Each acts in the plane of its
    disc, so the bearings also support the tilting moments. If ``output.support`` is "both_ends", the output has a
    bearing in each of its two end discs; otherwise the reactions of the output's bearings are None.
    """
    design = reducer.design
    gear = design.gear
    shaft_planes, output_planes, ring_planes = (
        Planes(force, np.array(gear.disc_planes)) for force in (shaft, output, ring)
    )
    far_position, near_position = (0.5 * sum(seat_ends) for seat_ends in bearing_seats(reducer))
    shaft_reactions = shaft_planes.reactions_at(far_position, near_position)
    output_reactions: tuple[Array | None, Array | None] = (None, None)
    if design.output.support == "both_ends":
        disc_position = 0.5 * gear.stack_width + AXIAL_GAP + 0.5 * design.output.disc_thickness
        output_reactions = output_planes.reactions_at(-disc_position, disc_position)
    return Reactions(shaft_planes, output_planes, ring_planes, *shaft_reactions, *output_reactions)
