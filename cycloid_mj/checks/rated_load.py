"""What the contacts of a sound design carry at its nominal torque: computed once, for all checks and the summary."""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.errors import RunError
from cycloid_mj.geometry import ideal_loads, profile
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.statics import Loads, Springs, loads, peak_force, peak_pressure, springs_of, torque_at_pressure

CARRIES = 0.01
"""A tooth carries where its force is at least this share of the largest."""


@dataclass(frozen=True, eq=False)
class Rated:
    """A design under its nominal torque.

    Attributes
    ----------
    design
        The design.
    torque
        On the output, that of the drive times the ratio [N m], in the sense of `member.share`.
    springs, found
        The statics and their solution.
    """

    reducer: Reducer
    torque: float
    springs: Springs
    contact_loads: Loads

    def peak_force(self, kind: str) -> float:
        """Compute the largest force on a contact of a kind [N]."""
        return peak_force(self.contact_loads, kind)

    def peak_pressure(self, kind: str) -> float:
        """Compute the largest Hertz pressure on a kind of contact [Pa]."""
        return peak_pressure(self.reducer, self.springs, self.contact_loads, kind)

    def torque_at(self, kind: str, pressure: float) -> float:
        """Find the torque on the output at which a kind of contact has a peak pressure [Pa]; NaN if none is found."""
        try:
            found, _ = torque_at_pressure(self.reducer, self.springs, {kind: pressure}, self.torque, self.contact_loads)
        except RunError:
            return math.nan
        return abs(found)

    @property
    def concentration(self) -> float:
        """Largest force on a tooth over that of ideal sharing [1]."""
        carried = self.reducer.share * self.torque / (self.reducer.design.gear.discs * self.reducer.design.ring.halves)
        ideal = ideal_loads.ideal_load_sharing(self.reducer.tooth_profile, carried, self.springs.crank)
        return float(self.contact_loads.teeth.max() / ideal.forces.max())

    @property
    def loaded_teeth(self) -> float:
        """Contact lines of a disc with the ring that carry, on average [1]."""
        carrying = (self.contact_loads.teeth > CARRIES * self.contact_loads.teeth.max()).sum(axis=1).mean()
        return float(carrying) / self.reducer.design.gear.discs

    @property
    def pressure_angle(self) -> float:
        """Angle of the tooth forces to the way that they turn the gear, averaged by force [rad]."""
        gear, forces = self.reducer.tooth_profile, self.contact_loads.by_disc(self.contact_loads.teeth)
        ahead = self.springs.crank[:, np.newaxis] + np.array(self.reducer.phases)
        B = np.tile(profile.pin_angles(gear), self.reducer.design.ring.halves) + ahead[..., np.newaxis]
        return float(np.sum(profile.pressure_angle(gear, B) * forces) / forces.sum())


@once
def rated(reducer: Reducer) -> Rated:
    """Return a sound design under its nominal torque."""
    torque = math.copysign(reducer.design.rated_torque, reducer.design.drive.speed)
    springs = springs_of(reducer)
    return Rated(reducer, torque, springs, loads(reducer, springs, torque, follow=True))


def loaded_teeth(reducer: Reducer) -> float:
    """Compute how many teeth of a disc carry at the nominal torque, on average [1]."""
    return rated(reducer).loaded_teeth


def pressure_angle(reducer: Reducer) -> float:
    """Compute the pressure angle at the nominal torque, averaged by force [deg]."""
    return math.degrees(rated(reducer).pressure_angle)
