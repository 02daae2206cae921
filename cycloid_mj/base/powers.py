"""The power balance of a reducer: power through the shafts, losses, stored power, and the efficiency."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from cycloid_mj.base.names import FRICTION_POWER, NORMAL_POWER
from cycloid_mj.base.record import Run

SELF_LOCKING = "self-locking"


@dataclass(frozen=True)
class Powers:
    """Mean powers [W].

    Attributes
    ----------
    crank, output
        Into the reducer through each shaft; negative where power flows out.
    friction, normal
        Kind of pair, or part -> power lost to sliding, rolling and seals; and to normal forces by damping, with the
        growth of elastic energy.
    stored
        Growth of kinetic and potential energy per time.
    """

    crank: float
    output: float
    friction: Mapping[str, float] = field(default_factory=dict)
    normal: Mapping[str, float] = field(default_factory=dict)
    stored: float = 0.0

    @property
    def supplied(self) -> float:
        """Power of the shafts that drive [W]: of both where the reducer is self-locking."""
        return max(0.0, self.crank) + max(0.0, self.output)

    @property
    def delivered(self) -> float:
        """Power of the shafts that are driven [W]."""
        return max(0.0, -self.crank) + max(0.0, -self.output)

    @property
    def lost(self) -> float:
        """Power lost to friction and normal forces [W]."""
        return sum(self.friction.values()) + sum(self.normal.values())

    @property
    def missing(self) -> float:
        """Input power that is neither lost nor stored [W]."""
        return self.crank + self.output - self.lost - self.stored

    @property
    def efficiency(self) -> float:
        """Power delivered over that supplied, whichever shaft drives: 0 if self-locking, NaN if nothing is supplied."""
        return self._share(self.delivered)

    @property
    def note(self) -> str:
        """Note on an efficiency of 0 (both shafts drive, and friction consumes all power); empty otherwise."""
        return SELF_LOCKING if min(self.crank, self.output) > 0.0 else ""

    @property
    def residual(self) -> float:
        """Residual of the power balance relative to the power supplied; NaN if there is none."""
        return self._share(self.missing)

    def loss_shares(self) -> dict[str, float]:
        """Map each loss by kind, of friction and of normal forces, to its share of the power supplied."""
        friction = {f"{kind}_friction": self._share(power) for kind, power in self.friction.items()}
        return friction | {f"{kind}_normal": self._share(power) for kind, power in self.normal.items()}

    def _share(self, power: float) -> float:
        return power / self.supplied if self.supplied > 0.0 else math.nan


def mean_powers(run: Run) -> Powers:
    """Compute the mean powers of a run [W]: through the shafts, losses by kind of mating pair, and stored power.

    Powers through shafts are positive into the reducer. Powers that were not logged count as 0. For an RV reducer,
    `Powers.crank` is the power of the sun.
    """
    zeros, driven_shaft = np.zeros(len(run)), run.driven_shaft
    energy = run.columns.get("kinetic_energy", zeros) + run.columns.get("potential_energy", zeros)
    return Powers(
        crank=float(np.mean(run[f"{driven_shaft}_torque"] * run[f"{driven_shaft}_speed"])),
        output=float(np.mean(run["load_torque"] * run["output_speed"])),
        friction={kind: float(np.mean(power)) for kind, power in run.by_stem(FRICTION_POWER).items()},
        normal={kind: float(np.mean(power)) for kind, power in run.by_stem(NORMAL_POWER).items()},
        stored=float((energy[-1] - energy[0]) / (run.time[-1] - run.time[0])),
    )
