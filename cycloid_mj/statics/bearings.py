"""What the bearings of shaft, output and ring hold where several discs pull in planes of their own: statics in space.

Each disc's forces act in its own plane. Those of two discs may cancel; their couples, force times spacing, do not.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.result import Quantity
from cycloid_mj.parts.shaft import bearing_seats
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP
from cycloid_mj.statics.balance import Loads
from cycloid_mj.statics.springs import Springs


@dataclass(frozen=True, eq=False)
class Planes:
    """In-plane forces on one part, those of each disc in the plane of that disc.

    Attributes
    ----------
    force
        Shape (m, D, 2) [N].
    place
        Of the planes along the reducer's axis [m], shape (D,); 0 is the middle of all discs.
    """

    force: Array
    place: Array

    @property
    def net(self) -> Array:
        """Sum of the forces [N], shape (m, 2)."""
        return np.asarray(self.force.sum(axis=1))

    @property
    def moment(self) -> Array:
        """Tilting moment about the middle of all discs [N m], shape (m, 2): about x, and about y."""
        x, y = np.einsum("d,mdi->im", self.place, self.force)
        return np.stack([-y, x], axis=1)

    def held_at(self, far: float, near: float) -> tuple[Array, Array]:
        """Compute what two bearings at places [m] answer with [N], shape (m, 2) each, the part being a beam on both."""
        share = (self.place - far) / (near - far)
        at_near = -np.einsum("d,mdi->mi", share, self.force)
        return -self.net - at_near, at_near


@dataclass(frozen=True, eq=False)
class Reactions:
    """What discs put on shaft, output and ring, and what the bearings answer with, shape (m, 2) [N].

    Attributes
    ----------
    shaft, output, ring
        Forces of the discs on them.
    shaft_far, shaft_near
        Of the shaft's bearings, the far and the near one.
    output_far, output_near
        Of the bearings of the two output discs, where there are two: that of the one next to the motor, and of the
        other. None where there is one, whose bearing holds the whole force and the whole moment.
    """

    shaft: Planes
    output: Planes
    ring: Planes
    shaft_far: Array
    shaft_near: Array
    output_far: Array | None
    output_near: Array | None


HELD = {
    "shaft_bearing_far": "shaft bearing far from the discs",
    "shaft_bearing_near": "shaft bearing near the discs",
    "output_bearing_far": "bearing of the output disc next to the motor",
    "output_bearing_near": "bearing of the output disc away from the motor",
}
"""Bearings, by their keys."""


def reaction_quantities(reactions: Reactions) -> Iterator[Quantity]:
    """Yield the largest forces and tilting moments over the crank angle."""
    for part in ("shaft", "output", "ring"):
        planes: Planes = getattr(reactions, part)
        tilts, nets = (float(np.hypot(*one.T).max()) for one in (planes.moment, planes.net))
        yield Quantity(f"{part}_net_force", f"net force of the discs on the {part}, largest", nets, "N")
        yield Quantity(f"{part}_tilting_moment", f"tilting moment of the discs on the {part}, largest", tilts, "N m")
    for key, name in HELD.items():
        forces = getattr(reactions, key.replace("_bearing", ""))
        if forces is not None:
            yield Quantity(f"{key}_force", f"{name}: largest force", float(np.hypot(*forces.T).max()), "N")


def reactions(reducer: Reducer, springs: Springs, contact_loads: Loads) -> Reactions:
    """Compute what bearings hold under static forces; without the weight and the unbalance of shaft and output."""
    slope = springs.contacts.slope
    push = slope[..., :-1].reshape(*slope.shape[:2], contact_loads.discs, 3)[..., :2].sum(axis=2)
    count = springs.teeth

    def of(forces: Array, ways: Array) -> Array:
        by_disc = (forces[..., np.newaxis] * ways).reshape(len(forces), contact_loads.discs, -1, 2)
        return np.asarray(-by_disc.sum(axis=2))

    return spatial(
        reducer, -contact_loads.cam, of(contact_loads.output, push[:, count:]), of(contact_loads.teeth, push[:, :count])
    )


def spatial(reducer: Reducer, shaft: Array, output: Array, ring: Array) -> Reactions:
    """Compute what bearings hold under forces of each disc on shaft, output and ring [N], shape (m, D, 2) each."""
    design = reducer.design
    gear = design.gear
    on_shaft, on_output, on_ring = (Planes(force, np.array(gear.disc_planes)) for force in (shaft, output, ring))
    far, near = (0.5 * sum(seat) for seat in bearing_seats(reducer))
    answers = on_shaft.held_at(far, near)
    ends: tuple[Array | None, Array | None] = (None, None)
    if design.output.support == "both_ends":
        plate = 0.5 * gear.stack_width + AXIAL_GAP + 0.5 * design.output.disc_thickness
        ends = on_output.held_at(-plate, plate)
    return Reactions(on_shaft, on_output, on_ring, *answers, *ends)
