"""Validation step "energy": conservation of energy over ramp and hold, evaluated at every time step.

    input work = output work + friction + normal forces (damping, and elastic energy) + change of kinetic and
    potential energy

The last row has no friction and a sudden load, so that damping is the only loss.
"""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.names import FRICTION_POWER, NORMAL_POWER
from cycloid_mj.base.record import Run
from cycloid_mj.base.validation import ValidationRow, relative
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.dynamics.timestep import timestep
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate import rig
from cycloid_mj.validate.rig import FIXED, FREE, RATED_LOAD, design_of_kind


@dataclass(frozen=True)
class EnergyBalance:
    """Works over a run [J]: `supplied` to the driven shaft, `delivered` to the load, `friction`, `normal`, `stored`."""

    supplied: float
    delivered: float
    friction: float
    normal: float
    stored: float

    @property
    def total_output(self) -> float:
        """Sum of delivered, dissipated and stored energy [J], equal to the input work."""
        return self.delivered + self.friction + self.normal + self.stored


def rows(kind: str, quick: bool) -> list[ValidationRow]:
    """Compare input work with output, dissipated and stored energy, for a kind of ring; `quick` has no effect."""
    drive_changes = "drive.ramp_s=0.012", "drive.hold_s=0.012", f"load.torque_nm={RATED_LOAD}"
    energy_balance = balance(_logged_at_every_step(kind, *drive_changes))
    source = "output + friction + normal + stored"
    return [relative(f"input work, {kind}", energy_balance.supplied, energy_balance.total_output, "J", source, 1e-5)]


def idle_rows(quick: bool) -> list[ValidationRow]:
    """Compare works without load, where free pins leave the walls of sockets and touch edges; `quick` has no effect."""
    works = balance(_logged_at_every_step(FREE, "drive.hold_s=0.012"))
    source = "friction + normal + stored"
    return [relative(f"input work, idle {FREE}", 1e3 * works.supplied, 1e3 * works.total_output, "mJ", source, 1e-3)]


def jolt_rows(quick: bool) -> list[ValidationRow]:
    """Compare the work of the normal forces under a sudden load with the rest of the energy balance.

    The rest is the work at the input minus the work at the output minus the stored energy; there is no friction.
    `quick` has no effect.
    """
    drive_changes = "drive.hold_s=0.005", "load.rise_s=0.00001", f"load.torque_nm={RATED_LOAD}"
    energy_balance = balance(_logged_at_every_step(FIXED, *rig.without_friction(), *drive_changes))
    lost_work = energy_balance.supplied - energy_balance.delivered - energy_balance.stored
    source = "input - output - stored"
    return [
        relative(
            "work of the normal forces in a jolt", 1e3 * energy_balance.normal, 1e3 * lost_work, "mJ", source, 1e-4
        )
    ]


def _logged_at_every_step(kind: str, *changes: str) -> Run:
    """Simulate with the automatic time step and log every step."""
    design = design_of_kind(kind, *changes)
    reducer = Reducer(design)
    return simulate(rig.with_changes(reducer, f"settings.log_rate_hz={1.0 / timestep(reducer)!r}").design)


def balance(run: Run) -> EnergyBalance:
    """Integrate the logged powers of a run over time: the energy balance of works and stored energy [J]."""
    energy = run["kinetic_energy"] + run["potential_energy"]
    return EnergyBalance(
        supplied=_work(run, run[f"{run.driven_shaft}_torque"] * run[f"{run.driven_shaft}_speed"]),
        delivered=-_work(run, run["load_torque"] * run["output_speed"]),
        friction=sum(_work(run, power) for power in run.by_stem(FRICTION_POWER).values()),
        normal=sum(_work(run, power) for power in run.by_stem(NORMAL_POWER).values()),
        stored=float(energy[-1] - energy[0]),
    )


def _work(run: Run, power: Array) -> float:
    return float(np.trapezoid(power, run.time))
