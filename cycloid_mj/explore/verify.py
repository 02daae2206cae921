"""Comparison of statics and full dynamics (friction, inertia, moving pins) for the worst samples."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.names import CRANK_BEARING
from cycloid_mj.base.units import ARCSECONDS
from cycloid_mj.design.layouts import Layout
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.figures import SAMPLED, compute, figure
from cycloid_mj.measure.conditions import STEADY
from cycloid_mj.measure.contact_pressure import contact_pressures
from cycloid_mj.measure.steady import run_steady, steady_design
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics.rv import compute_rv_springs, solve_rv_loads
from cycloid_mj.statics.rv_film import running_friction
from cycloid_mj.statics.rv_sheet import output_rotation, torque_on_carrier

TEETH = "teeth"
"""Stands for the kind of pair of the teeth, which depends on the design."""


@dataclass(frozen=True)
class ComparedFigures:
    """Figures of a layout that a run is compared in.

    Attributes
    ----------
    statics
        Function that computes the figures by statics, by key.
    transmission_error
        Key of the peak-to-peak transmission error.
    forces
        Key of a largest force -> kind of pair.
    """

    statics: Callable[[Reducer], dict[str, float]]
    transmission_error: str
    forces: Mapping[str, str]


_RV_FORCES = {"pin_gear_peak_force_n": TEETH, "crank_bearing_running_force_n": CRANK_BEARING}
"""Forces of planets are not compared: a run has the resultant of both flanks."""

_RV_ERROR = "te_loaded_forward_arcsec"

ANGLES_PER_TOOTH = 8
"""Crank angles of statics in a mesh period of an RV reducer (heuristic)."""


def _compute_rv_statics(reducer: Reducer) -> dict[str, float]:
    """Compute the peak-to-peak transmission error [arcsec] and the largest forces [N] of an RV reducer by statics.

    The keys are ``te_loaded_forward_arcsec`` and, for the forces on a pin and of a crank, those of `_RV_FORCES`.
    Friction is included. The crank angles are those of the turn of the cranks that a run covers. Over a turn of the
    carrier, errors of bores and carrier cause larger forces.
    """
    assert isinstance(reducer, RvReducer)
    count = ANGLES_PER_TOOTH * reducer.design.ring.teeth
    angles = float(np.sign(reducer.speed_against_ring)) * np.linspace(0.0, reducer.mesh_turn, count, endpoint=False)
    torque = torque_on_carrier(reducer, reducer.design.rated_torque)
    loaded_reducer = reducer.but(load={"torque": reducer.design.rated_torque})
    loads = solve_rv_loads(
        compute_rv_springs(loaded_reducer, angles),
        torque,
        running_friction(loaded_reducer, angles, float(np.sign(torque))),
    )
    rotation = output_rotation(reducer, loads.carrier_turn)
    forces = dict(zip(_RV_FORCES, (float(loads.pins.max()), float(loads.bearings.max())), strict=True))
    return {_RV_ERROR: ARCSECONDS * float(np.ptp(rotation)), **forces}


COMPARED: Mapping[Layout, ComparedFigures] = {
    "central": ComparedFigures(
        partial(compute, keys=SAMPLED),
        "te_loaded_arcsec",
        {"tooth_force_n": TEETH, "output_pin_force_n": "output", "cam_force_n": "cam"},
    ),
    "rv": ComparedFigures(_compute_rv_statics, _RV_ERROR, _RV_FORCES),
}


@dataclass(frozen=True)
class DynamicsCheck:
    """Figures of a run over a crank turn at the design's speed and nominal torque, and by statics."""

    design: str
    """Its name."""
    statics: Mapping[str, float]
    dynamics: Mapping[str, float]
    """Figures by their keys in the catalogue; `dynamics` has some of them, and none if the run failed."""
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
    """Run a design, and return its quantities with those of statics; the note has the error of a run that fails."""
    statics = COMPARED[reducer.LAYOUT].statics(reducer)
    try:
        return DynamicsCheck(reducer.design.name, statics, _simulate_quantities(reducer, solver), solver=solver)
    except CycloidError as error:
        return DynamicsCheck(reducer.design.name, statics, {}, str(error), solver)


def _simulate_quantities(reducer: Reducer, solver: Solver) -> dict[str, float]:
    """Simulate a crank turn at nominal torque and the design's speed; return the quantities in `COMPARED` by key.

    These are the peak-to-peak transmission error, such as ``te_loaded_arcsec``, and the largest force of each kind of
    contact, such as ``tooth_force_n``. `solver` is "planar" or "mujoco".
    """
    design = reducer.design
    loaded_reducer = steady_design(reducer).but(load={"torque": design.rated_torque})
    run = run_steady(loaded_reducer, STEADY.settling_time, design.ring.teeth, solver)
    transmission_error = run["output_angle"] - reducer.member.output_angle(run[f"{run.driven_shaft}_angle"])
    contacts, compared_quantities = contact_pressures(run, loaded_reducer), COMPARED[reducer.LAYOUT]
    forces = {
        key: contacts[design.tooth_pair if pair == TEETH else pair].peak_force
        for key, pair in compared_quantities.forces.items()
    }
    return {compared_quantities.transmission_error: ARCSECONDS * float(np.ptp(transmission_error)), **forces}


def table_rows(check: DynamicsCheck) -> list[tuple[str, ...]]:
    """Format statics, dynamics and their difference, a row for each quantity."""
    return [
        (check.design, key, f"{check.statics[key]:.5g}", f"{value:.5g}", f"{100.0 * change:+.2f} %", figure(key).unit)
        for (key, value), change in zip(check.dynamics.items(), check.differences.values(), strict=True)
    ]
