"""Rollers of the cams as springs of their own (``contact.needles = "each"``), in the static equilibrium of `balance`.

Each roller is a unilateral spring along its direction from the middle of the bore, as those of the crank bearings of an
RV reducer (``statics.rv``). Their cage rolls between cam and disc. A bearing that is a single spring has the stiffness
of the same rollers without clearance, averaged over a turn of the cage.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.rv_bodies import needle_directions, needle_share
from cycloid_mj.statics.kernel import KernelSprings
from cycloid_mj.statics.springs import Springs

EVEN_SHARE = np.pi / 4.0
"""Resultant of the forces of many rollers without clearance over their sum: start value of `CamNeedles.shares`."""

MAX_DEFLECTION = 100.0
"""Displacement of a cam, over that under its working force, up to which the equations include only its rollers
(heuristic)."""


@dataclass(frozen=True)
class CamNeedles:
    """Rollers of D cams at m crank angles.

    Attributes
    ----------
    directions
        Unit vectors from the middle of a bore to its Z rollers, equal for all cams, shape (m, Z, 2).
    stiffness
        Stiffness of a roller [N/m].
    reach
        Largest displacement of a cam in its bore [m].
    shares
        Resultant of the forces of the rollers of a cam over their sum [1], shape (m, D). Friction acts on the
        resultant.
    """

    directions: Array
    stiffness: float
    reach: float
    shares: Array

    def extend(self, contacts: KernelSprings, teeth: int) -> KernelSprings:
        """Return the contact springs with a spring for each needle roller in place of a spring for each cam.

        The rollers are inserted between the first `teeth` springs of `contacts`, those with the ring, and those of
        output pins.
        """
        cam_positions = contacts.cam_position
        angles, discs, unknowns = len(cam_positions), cam_positions.shape[1], contacts.slope.shape[2]
        needles = self.directions.shape[1]
        slope, shape = np.zeros((angles, discs, needles, unknowns)), (angles, discs * needles)
        friction = np.zeros((angles if contacts.friction_per_force.size else 0, discs, needles, unknowns))
        for disc in range(discs):
            slope[:, disc, :, 3 * disc : 3 * disc + 2] = self.directions
            if contacts.friction_per_force.size:
                friction[:, disc, :, 3 * disc + 2] = contacts.cam_friction_per_force * self.shares[:, disc, np.newaxis]
        zero_values = dict.fromkeys(("shift", "curvature", "curvature_rate", "phase"), np.zeros(shape))
        needle_values: Mapping[str, Any] = {
            "disc": np.repeat(np.arange(discs), needles),
            "rotates": np.zeros(shape[1], bool),
            "clearance": np.full(shape[1], contacts.cam_clearance),
            "distance": -np.einsum("mdj,mzj->mdz", cam_positions, self.directions).reshape(shape),
            "slope": slope.reshape(*shape, unknowns),
            "shift_slope": np.zeros((*shape, unknowns)),
            "stiffness": np.full(shape, self.stiffness),
            "friction_per_force": friction.reshape(len(friction), shape[1], unknowns),
            **zero_values,
        }
        replacements: dict[str, Any] = {
            name: _insert(getattr(contacts, name), values, teeth) for name, values in needle_values.items()
        }
        return contacts._replace(**replacements, cam_clearance=self.reach)

    def split(self, forces: Array, teeth: int) -> tuple[Array, Array]:
        """Split forces of the contact springs from `extend` [N] into those of other contacts and of needle rollers.

        `forces` has the shape (m, n + D Z) for m crank angles, n contacts, and D discs with Z rollers each. `teeth` is
        the number of contacts with the ring, which precede the rollers.

        Returns
        -------
        tuple
            Forces of the contacts, shape (m, n), and of the rollers, shape (m, D, Z).
        """
        discs, needles = self.shares.shape[1], self.directions.shape[1]
        rollers_end = teeth + discs * needles
        roller_forces = forces[:, teeth:rollers_end].reshape(len(forces), discs, needles)
        return np.concatenate([forces[:, :teeth], forces[:, rollers_end:]], axis=1), roller_forces

    def resultants(self, rollers: Array) -> Array:
        """Return the force of each cam on its disc [N], shape (m, D, 2), from those of its rollers, shape (m, D, Z)."""
        return np.einsum("mdz,mzj->mdj", rollers, self.directions)

    def with_shares(self, rollers: Array) -> "CamNeedles":
        """Return the rollers with the shares that follow from their forces [N], shape (m, D, Z)."""
        total_force = np.maximum(rollers.sum(axis=2), np.finfo(float).tiny)
        return replace(self, shares=np.linalg.norm(self.resultants(rollers), axis=2) / total_force)


def cam_needles(reducer: Reducer, springs: Springs) -> CamNeedles | None:
    """Return the needle rollers between discs and cams as contact springs; None if a cam is a single spring.

    They are computed at the crank angles of the other contact springs, `springs`.
    """
    needles = reducer.separate_needles
    if not needles:
        return None
    cam_contact = reducer.at_rated_load.contacts["cam"]
    return CamNeedles(
        directions=needle_directions(reducer, springs.crank),
        stiffness=needle_share(needles) * springs.contacts.cam_stiffness,
        reach=springs.contacts.cam_clearance + MAX_DEFLECTION * cam_contact.force / springs.contacts.cam_stiffness,
        shares=np.full((springs.crank.size, reducer.design.gear.discs), EVEN_SHARE),
    )


def _insert(values: Array, inserted: Array, position: int) -> Array:
    """Insert contacts at a position of the axis of contacts: the first of a vector, else the second."""
    axis = 0 if values.ndim == 1 else 1
    before, after = np.split(values, [position], axis=axis)
    return np.concatenate([before, inserted, after], axis=axis)
