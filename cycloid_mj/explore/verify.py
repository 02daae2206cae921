"""Samples in full dynamics beside their statics: what friction, inertia and moving pins make of the worst of them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.units import ARCSECONDS
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.figures import SAMPLED, compute, figure
from cycloid_mj.measure.contact_pressure import pressed
from cycloid_mj.measure.steady import SETTLED, steady, steady_design
from cycloid_mj.reducer import Reducer

KINDS = {"output_pin_force_n": "output", "cam_force_n": "cam"}


@dataclass(frozen=True)
class Verified:
    """A design run over a turn of the crank, at its own speed and under its rated torque, beside its statics.

    Attributes
    ----------
    design
        Its name.
    statics, dynamics
        Figures by their keys in `SAMPLED`; `dynamics` are fewer, and none where the run went wrong.
    note
        Why there are none.
    solver
        What took the steps of the run.
    """

    design: str
    statics: Mapping[str, float]
    dynamics: Mapping[str, float]
    note: str = ""
    solver: Solver = "planar"

    @property
    def differences(self) -> dict[str, float]:
        """Dynamics less statics, as a share of the statics."""
        return {
            key: value / self.statics[key] - 1.0 if self.statics[key] else math.nan
            for key, value in self.dynamics.items()
        }


def verified(reducer: Reducer, solver: Solver = "planar") -> Verified:
    """Run a design and give its figures beside those of its statics; a run that goes wrong is told in the note."""
    statics = compute(reducer, SAMPLED)
    try:
        return Verified(reducer.design.name, statics, _dynamics(reducer, solver), solver=solver)
    except CycloidError as error:
        return Verified(reducer.design.name, statics, {}, str(error), solver)


def _dynamics(reducer: Reducer, solver: Solver) -> dict[str, float]:
    design = reducer.design
    loaded = steady_design(reducer).but(load={"torque": design.rated_torque})
    run = steady(loaded, SETTLED, design.ring.teeth, solver)
    error = run["output_angle"] - reducer.member.output_angle(run["crank_angle"])
    contacts = pressed(run, loaded)
    kinds = {"tooth_force_n": design.tooth_pair, **KINDS}
    return {
        "te_loaded_arcsec": ARCSECONDS * float(np.ptp(error)),
        **{key: contacts[kind].peak_force for key, kind in kinds.items()},
    }


def table_rows(verified: Verified) -> list[tuple[str, ...]]:
    """List statics, dynamics and their difference as rows of text, a figure each."""
    return [
        (
            verified.design,
            key,
            f"{verified.statics[key]:.5g}",
            f"{value:.5g}",
            f"{100.0 * verified.differences[key]:+.2f} %",
            figure(key).unit,
        )
        for key, value in verified.dynamics.items()
    ]
