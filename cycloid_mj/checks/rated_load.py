"""Static loads of a design at its nominal torque, computed once for all checks and the summary."""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.errors import RunError
from cycloid_mj.geometry import ideal_loads, profile
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.statics import Loads, Springs, loads, peak_force, peak_pressure, springs_of, torque_at_pressure


@dataclass(frozen=True)
class LoadShares:
    """Shares below which a load counts as none."""

    torque: float = 1e-6  # of the nominal torque: below it the pressure is that of inertia forces
    tooth: float = 0.01  # of the largest force of a tooth


MIN_SHARE = LoadShares()


@dataclass(frozen=True, eq=False)
class RatedLoad:
    """Static loads of a design at its nominal torque.

    Attributes
    ----------
    reducer
        The reducer of the design.
    torque
        Torque on the output, that of the motor times the ratio [N m], in the sense of `member.share`.
    springs, contact_loads
        The contact springs and the static equilibrium.
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
        """Compute the output torque [N m] at which the peak Hertz pressure in a kind of contact is `pressure` [Pa].

        `kind` is a kind of mating pair, such as ``pin_gear``. Return NaN if no torque causes this pressure, if inertia
        forces alone cause a larger one, or if there is no equilibrium.
        """
        try:
            with np.errstate(invalid="ignore"):  # shares of the torque where it vanishes
                torque, _ = torque_at_pressure(
                    self.reducer, self.springs, {kind: pressure}, self.torque, self.contact_loads
                )
        except RunError:
            return math.nan
        return abs(torque) if abs(torque) > MIN_SHARE.torque * abs(self.torque) else math.nan

    @property
    def concentration(self) -> float:
        """Largest force on a tooth over that of ideal load sharing [1]."""
        torque_per_mesh = (
            self.reducer.share * self.torque / (self.reducer.design.gear.discs * self.reducer.design.ring.halves)
        )
        ideal_sharing = ideal_loads.ideal_load_sharing(self.reducer.tooth_profile, torque_per_mesh, self.springs.crank)
        return float(self.contact_loads.teeth.max() / ideal_sharing.forces.max())

    @property
    def loaded_teeth(self) -> float:
        """Mean number of loaded contact lines of a disc with the ring [1]."""
        mean_count = (self.contact_loads.teeth > MIN_SHARE.tooth * self.contact_loads.teeth.max()).sum(axis=1).mean()
        return float(mean_count) / self.reducer.design.gear.discs

    @property
    def pressure_angle(self) -> float:
        """Pressure angle of the tooth forces, averaged by force [rad]."""
        tooth_profile, forces = self.reducer.tooth_profile, self.contact_loads.by_disc(self.contact_loads.teeth)
        eccentric_angles = self.springs.crank[:, np.newaxis] + np.array(self.reducer.phases)
        pin_angles = (
            np.tile(profile.pin_angles(tooth_profile), self.reducer.design.ring.halves)
            + eccentric_angles[..., np.newaxis]
        )
        return float(np.sum(profile.pressure_angle(tooth_profile, pin_angles) * forces) / forces.sum())


@once
def rated_load(reducer: Reducer) -> RatedLoad:
    """Return the static loads of a sound design at its nominal torque; raise RunError without an equilibrium."""
    torque = math.copysign(reducer.design.rated_torque, reducer.design.drive.speed)
    springs = springs_of(reducer)
    return RatedLoad(reducer, torque, springs, loads(reducer, springs, torque, warm_start=True))


def loaded_teeth(reducer: Reducer) -> float:
    """Compute the mean number of loaded teeth of a disc at the nominal torque [1]."""
    return rated_load(reducer).loaded_teeth


def pressure_angle(reducer: Reducer) -> float:
    """Compute the pressure angle at the nominal torque, averaged by force [deg]."""
    return math.degrees(rated_load(reducer).pressure_angle)
