"""Output rollers with a spring for each needle (``contact.needles = "each"``), in the static equilibrium of `balance`.

The force of a roller depends on its needles in a non-linear way. The equilibrium is solved with linear springs, which
are tangents of this force, until force and springs agree (Newton's method).
"""

from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.roller_needles import RollerNeedles
from cycloid_mj.statics.kernel import KernelSprings, linearise_rollers
from cycloid_mj.statics.springs import Springs


@dataclass(frozen=True)
class RollerSprings:
    """Linear springs of n output rollers at m crank angles: the force is `slope` times (approach - `start`).

    Attributes
    ----------
    needles
        Needles of the rollers.
    angle
        Direction of the force on each roller, relative to that of a needle [rad], shape (m, n).
    stiffness
        Stiffness of the contacts with the holes [N/m], shape (m, n).
    slope, start
        Slope [N/m], and approach of hole and core without force [m], shape (m, n).
    """

    needles: RollerNeedles
    angle: Array
    stiffness: Array
    slope: Array
    start: Array

    def linearise(self, approach: Array) -> tuple["RollerSprings", Array]:
        """Return the springs at an approach of hole and core (m, n) [m], and the forces there (m, n) [N]."""
        force, slope, start = (np.zeros(approach.shape) for _ in range(3))
        linearise_rollers(self.needles, self.angle, self.stiffness, approach, force, slope, start)
        return replace(self, slope=slope, start=start), force

    def approach(self, force: Array) -> Array:
        """Return the approach [m] under the forces of these linear springs [N], both (m, n); 0 without force."""
        return np.where(force > 0.0, self.start + force / self.slope, 0.0)

    def insert(self, contacts: KernelSprings, teeth: int) -> KernelSprings:
        """Return contact springs with these springs behind the first `teeth` contacts, those with the ring."""
        stiffness, distance = contacts.stiffness.copy(), contacts.distance.copy()
        stiffness[:, teeth:] = self.slope
        distance[:, teeth:] += self.start - np.maximum(contacts.clearance[teeth:], 0.0)
        return contacts._replace(stiffness=stiffness, distance=distance)


def roller_springs(reducer: Reducer, springs: Springs) -> RollerSprings | None:
    """Return the output rollers on separate needles as linear springs between hole and core pin; None without needles.

    They are linearised without load, at the crank angles of the contact springs `springs`. At the crank angle 0, a
    needle is on +y.
    """
    needles = reducer.at_rated_load.roller_needles
    if not needles.needles:
        return None
    directions, carrier_angle = springs.directions[:, springs.teeth :], -springs.crank / reducer.design.lobes
    cage_angle = carrier_angle + needles.cage_ratio * (springs.crank - carrier_angle)
    stiffness = np.ascontiguousarray(springs.contacts.stiffness[:, springs.teeth :])
    angle = np.arctan2(-directions[..., 0], directions[..., 1]) - cage_angle[:, np.newaxis]
    unloaded_springs = RollerSprings(needles, angle, stiffness, stiffness, stiffness)
    return unloaded_springs.linearise(np.zeros(stiffness.shape))[0]
