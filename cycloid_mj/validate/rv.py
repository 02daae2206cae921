"""Validation step "rv": the RV reducer `rv80e` by statics and both solvers, against closed forms and each other.

The statics of an RV reducer (``statics.rv``), the planar solver and MuJoCo share geometry and contact stiffness, but
neither equations nor solution method. The closed forms are those of ideal sharing and of rigid parts
(``geometry.rv_loads``).
"""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.powers import mean_powers
from cycloid_mj.base.record import Run
from cycloid_mj.base.statistics import peak_to_peak
from cycloid_mj.base.units import ARCSECONDS
from cycloid_mj.base.validation import ValidationRow, absolute, relative
from cycloid_mj.design import PRESETS
from cycloid_mj.dynamics.run import Solver, model_for, simulate
from cycloid_mj.geometry.rv_loads import mean_force
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.film import drag_torques
from cycloid_mj.statics.rv import RvLoads, compute_rv_springs, solve_rv_loads
from cycloid_mj.statics.rv_film import running_friction
from cycloid_mj.statics.rv_sheet import closed_rotation, ideal_rv, solve_rv_equilibrium, torque_on_carrier
from cycloid_mj.statics.sheet import shaft_powers


@dataclass(frozen=True)
class RvConditions:
    """Conditions of the runs, and the part error of the error map.

    Attributes
    ----------
    settled, hold
        Times [s] at which the evaluation of a run begins and ends: a third of a turn of the cranks.
    short_settled, short_hold, rise
        The same for runs in MuJoCo, and the time over which their load rises.
    error
        Displacement of a crank bore [m].
    error_angles
        Crank angles over a turn of the carrier at which rotations are compared.
    """

    settled: float = 0.03
    hold: float = 0.066
    short_settled: float = 0.006
    short_hold: float = 0.012
    rise: float = 0.004
    error: float = 1e-5
    error_angles: int = 241


CONDITIONS = RvConditions()


def rows(quick: bool) -> list[ValidationRow]:
    """Return the comparisons of this validation step (rows of its table); `quick` omits the runs in MuJoCo."""
    reducer = RvReducer(PRESETS["rv80e"].but(ring={"pins": "fixed"}))
    run_rows = _compare_run_with_statics(reducer, "planar", CONDITIONS.settled, CONDITIONS.hold)
    if not quick:
        run_rows += _compare_run_with_statics(reducer, "mujoco", CONDITIONS.short_settled, CONDITIONS.short_hold)
    return [*_static_rows(reducer), *run_rows]


def _static_rows(reducer: RvReducer) -> list[ValidationRow]:
    """Compare the statics of an RV reducer with closed forms: a bearing force, and the effect of a manufacturing error.

    The force of stiff crank bearings is compared with that of ideal load sharing, and the rotation of the carrier by a
    displaced crank bore with a published formula.
    """
    torque = reducer.design.load.torque
    stiff_reducer = RvReducer(reducer.design.but(cranks=dict.fromkeys(("needle_stiffness", "taper_stiffness"), 2e11)))
    spring_mean, ideal_mean = (
        max(mean_force(force) for force in loads.bearings.reshape(len(loads.bearings), -1).T)
        for loads in (solve_rv_equilibrium(stiff_reducer, torque), ideal_rv(reducer, torque))
    )
    displaced_reducer = RvReducer(reducer.design.but(crank_errors={"bore_x": (CONDITIONS.error, *([0.0] * 5))}))
    ideal_turn, displaced_turn = (
        solve_rv_equilibrium(case_reducer, torque, CONDITIONS.error_angles).carrier_turn
        for case_reducer in (reducer, displaced_reducer)
    )
    return [
        relative(
            "mean force of a crank bearing, rv80e with bearings a thousand times as stiff",
            spring_mean,
            ideal_mean,
            "N",
            "ideal sharing, 10/3-power mean over a turn of the carrier",
            bound=1.0,
        ),
        relative(
            "p-p rotation by a crank bore displaced by 10 um, rv80e",
            ARCSECONDS * peak_to_peak(displaced_turn - ideal_turn),
            ARCSECONDS * peak_to_peak(closed_rotation(displaced_reducer)),
            "arcsec",
            "Yang et al. 2021, Eq. 30, rigid parts",
            bound=3.0,
        ),
    ]


def _compare_run_with_statics(reducer: RvReducer, solver: Solver, settled: float, hold: float) -> list[ValidationRow]:
    """Compare ratio, mean wind-up, mean crank bearing force and efficiency of a run with statics at its crank angles.

    The ratio is the quotient of the angles by which sun and output turn. Its bound, 0.01 %, is 0.2 arcsec of
    the output in the 6 ms of a run in MuJoCo, twice the transmission error of ideal parts at full speed. The run lasts
    for the time `hold` [s] at constant speed; samples up to the time `settled` [s] are left out. `solver` is the solver
    of the run.
    """
    drive, load = {"ramp": 0.0, "hold": hold}, {"rise": CONDITIONS.rise} if solver == "mujoco" else {}
    reducer = RvReducer(reducer.design.but(drive=drive, load=load))
    run = simulate(reducer.design, model_for(solver, reducer))
    run = run.select(run.time > settled)
    static = _static_loads(reducer, run)
    wind_up = run["output_angle"] - reducer.member.output_angle(run["sun_angle"])
    forces = np.linalg.norm(run.forces(names.CRANK_BEARING), axis=2)
    case, source = f"rv80e, {solver}", "statics with friction at the same crank angles"
    ratio = peak_to_peak(run["sun_angle"]) / peak_to_peak(run["output_angle"])
    return [
        relative(f"ratio, {case}", ratio, reducer.design.ratio, "1", "numbers of teeth", bound=0.01),
        relative(
            f"mean wind-up, {case}",
            ARCSECONDS * abs(float(wind_up.mean())),
            ARCSECONDS * abs(float(static.carrier_turn.mean())),
            "arcsec",
            source,
            bound=0.15,
        ),
        relative(
            f"mean crank bearing force, {case}",
            float(forces.mean()),
            float(static.bearings.mean()),
            "N",
            source,
            bound=0.15,
        ),
        absolute(
            f"efficiency, {case}",
            100.0 * mean_powers(run).efficiency,
            100.0 * shaft_powers(reducer, reducer.design.load.torque).efficiency,
            "%",
            "statics with friction, mean over a turn of the carrier",
            bound=0.3,
        ),
    ]


def _static_loads(reducer: RvReducer, run: Run) -> RvLoads:
    """Solve for the static equilibrium with friction at the crank angles of a run.

    The drag of seal and main bearings on the output adds to the load.
    """
    springs = compute_rv_springs(reducer, _mesh_angles(reducer, run))
    torque = torque_on_carrier(reducer, reducer.design.load.torque + drag_torques(reducer)[1])
    return solve_rv_loads(springs, torque, running_friction(reducer, springs.crank, float(np.sign(torque))))


def _mesh_angles(reducer: RvReducer, run: Run) -> Array:
    """Return the crank angles of a run relative to the ring [rad]."""
    ring_rotation, _ = reducer.member.ring_and_carrier(run["output_angle"])
    return reducer.member.mesh_angle(run["sun_angle"], ring_rotation)
