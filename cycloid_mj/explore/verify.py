"""Comparison of statics and full dynamics (friction, inertia, moving pins) for the worst samples."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.units import ARCSECONDS
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.figures import SAMPLED, compute, figure
from cycloid_mj.measure.conditions import STEADY
from cycloid_mj.measure.contact_pressure import contact_pressures
from cycloid_mj.measure.steady import run_steady, steady_design
from cycloid_mj.reducer import Reducer

CONTACT_KINDS = {"output_pin_force_n": "output", "cam_force_n": "cam"}


@dataclass(frozen=True)
class DynamicsCheck:
    """Figures of a run over a crank turn at the design's speed and nominal torque, and by statics."""

    design: str
    """Its name."""
    statics: Mapping[str, float]
    dynamics: Mapping[str, float]
    """Figures by their keys in `SAMPLED`; `dynamics` has some of them, and none if the run failed."""
    note: str = ""
    """Why the run failed."""
    solver: Solver = "planar"
    """Solver of the run."""

    @property
    def differences(self) -> dict[str, float]:
        """Difference of dynamics to statics, relative to statics."""
        return {
            key: value / self.statics[key] - 1.0 if self.statics[key] else math.nan
            for key, value in self.dynamics.items()
        }


def verify_design(reducer: Reducer, solver: Solver = "planar") -> DynamicsCheck:
    """Run a design, and return its figures with those of statics; the note has the error of a run that fails."""
    statics = compute(reducer, SAMPLED)
    try:
        return DynamicsCheck(reducer.design.name, statics, _simulate_figures(reducer, solver), solver=solver)
    except CycloidError as error:
        return DynamicsCheck(reducer.design.name, statics, {}, str(error), solver)


def _simulate_figures(reducer: Reducer, solver: Solver) -> dict[str, float]:
    """Simulate a crank turn at nominal torque and the design's speed; return figures by key.

    These are the peak-to-peak transmission error [arcsec], and the largest force of each kind of contact [N].
    """
    design = reducer.design
    loaded_reducer = steady_design(reducer).but(load={"torque": design.rated_torque})
    run = run_steady(loaded_reducer, STEADY.settling_time, design.ring.teeth, solver)
    transmission_error = run["output_angle"] - reducer.member.output_angle(run["crank_angle"])
    contacts = contact_pressures(run, loaded_reducer)
    pair_of_figure = {"tooth_force_n": design.tooth_pair, **CONTACT_KINDS}
    return {
        "te_loaded_arcsec": ARCSECONDS * float(np.ptp(transmission_error)),
        **{key: contacts[pair].peak_force for key, pair in pair_of_figure.items()},
    }


def table_rows(check: DynamicsCheck) -> list[tuple[str, ...]]:
    """Format statics, dynamics and their difference, a row for each figure."""
    return [
        (check.design, key, f"{check.statics[key]:.5g}", f"{value:.5g}", f"{100.0 * change:+.2f} %", figure(key).unit)
        for (key, value), change in zip(check.dynamics.items(), check.differences.values(), strict=True)
    ]
