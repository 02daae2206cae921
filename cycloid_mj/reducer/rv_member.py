"""Output member and kinematics of an RV reducer, in terms of its sun."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.geometry.rv import RvKinematics
from cycloid_mj.reducer.member import Member


@dataclass(frozen=True)
class RvMember(Member):
    """Kinematics of sun, cranks, discs, carrier, ring and output; the input of all functions is the sun.

    All angles are against the ground, except for those of `against_ring` and `against_carrier`. Speeds map to speeds.
    The sun of `rv80e` turns its carrier in its own sense, and its ring in the opposite sense.

    Attributes
    ----------
    kinematics
        Ratios by the numbers of teeth.
    """

    kinematics: RvKinematics

    def output_angle(self, sun: npt.ArrayLike) -> Array:
        """Return the angle of the output [rad] at angles of the sun [rad]."""
        return np.asarray(np.asarray(sun, dtype=np.float64) / float(self.kinematics.ratio))

    def gear_angle(self, sun: npt.ArrayLike) -> Array:
        """Return the angle of discs and carrier [rad] at angles of the sun [rad]."""
        return np.zeros_like(self.output_angle(sun)) if self.turns_ring else self.output_angle(sun)

    def ring_angle(self, sun: npt.ArrayLike) -> Array:
        """Return the angle of the ring [rad] at angles of the sun [rad]."""
        return self.output_angle(sun) if self.turns_ring else np.zeros_like(self.output_angle(sun))

    def against_ring(self, sun: npt.ArrayLike) -> Array:
        """Return the angle of the cranks relative to the ring [rad], which determines the mesh."""
        return self.mesh_angle(sun, self.ring_angle(sun))

    def crank_angle(self, driven: npt.ArrayLike) -> Array:
        """Return the angle of the cranks [rad] at angles of the sun [rad]; speeds map to speeds."""
        return np.asarray(self.against_ring(driven) + self.ring_angle(driven))

    def driven_angle(self, crank: npt.ArrayLike) -> Array:
        """Return the angle of the sun [rad] at angles of the cranks [rad], both against the ground."""
        return np.asarray(np.asarray(crank, dtype=np.float64) / float(self.crank_angle(1.0)))

    def mesh_angle(self, driven: npt.ArrayLike, ring: npt.ArrayLike) -> Array:
        """Return the crank angle relative to the ring [rad] at angles of the sun and the ring [rad]."""
        against_ring = np.asarray(driven, dtype=np.float64) - np.asarray(ring)
        return np.asarray(against_ring * float(self.kinematics.crank_per_sun))

    def against_carrier(self, sun: npt.ArrayLike) -> Array:
        """Return the angle of the cranks relative to the carrier [rad], by which their bearings turn."""
        return np.asarray(self.crank_angle(sun) - self.gear_angle(sun))

    @property
    def share(self) -> float:
        """Torque on the carrier, seen from the ring, per torque on the output, without losses."""
        return self.kinematics.share

    @property
    def sense(self) -> int:
        """Sign of a torque on the output that brakes a sun that turns counter-clockwise: -1 on the carrier."""
        return -1 if self.kinematics.ratio > 0 else 1
