"""Backlash of the output, from stop to stop at a locked crank: by all clearances and by each alone.

Two small torques press the output against either stop; the line through both angles, extrapolated to zero torque, is
the stop of rigid parts. Friction and weight are switched off: friction would hold parts on the way, and weight would
press them to one side. The driven shaft is locked: the crank, or the sun of an RV reducer.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_mj.analysis.transmission import output_error
from cycloid_mj.base.array import Array
from cycloid_mj.base.engine import Progress, each_in_threads, silent
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Curve, Quantity, by_key
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.design import Errors, Measured, Modification, Named, resolve
from cycloid_mj.design.layouts import Layout
from cycloid_mj.design.rv import CrankErrors
from cycloid_mj.dynamics.massless import assumptions, massless
from cycloid_mj.dynamics.run import Solver
from cycloid_mj.dynamics.settling import rotation_time
from cycloid_mj.measure import bench, rigid_backlash
from cycloid_mj.measure.measurement import Measurement
from cycloid_mj.measure.sampled import ClosedForm, add_errors, error_of_mean, extreme_quantities
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.statics.rv_motion import rv_backlash


@dataclass(frozen=True)
class PressSettings:
    """Settings of the press of the output against its stops (`press_to_stops`), and of its check."""

    angles: int = 8
    quick_angles: int = 2
    """Crank angles by default, and of a quick measurement."""
    share: float = 0.0025
    """The smaller torque relative to the rated one; the larger is twice as large."""
    levels: tuple[float, ...] = (20.0, 2.0, 1.0, -20.0, -2.0, -1.0)
    """Sequence of torques in units of the smaller torque; the larger torques seat the parts."""
    settling: float = 4.0
    """Time at each torque, relative to the time in which it moves output and disc across their clearance."""
    all_clearances: float = 4.0
    """Factor on that time where all clearances are open: the parts take longer to come to rest."""
    read_share: float = 0.25
    """Last part of that time, over which the angle is averaged."""
    no_clearance: float = 1e-10
    """Clearance of the other pairs [m] where one is measured alone."""
    samples: int = 200
    """Samples at each torque."""
    longer: float = 1.5
    finer: float = 1.5
    """Factors of the check on the time at each torque, and on the number of time steps."""
    planar_ratio: float = 0.5
    """Planar time step relative to the bench's, as a divisor: massless pins do not chatter, and only rest is evaluated.

    With 35 us instead of 17.5 us the mean of `pin` changes by 8e-6; that of 54 sleeved pins with 20 um of clearance by
    0.5 %, towards the linear programme.
    """


PRESS = PressSettings()


NAMES = {
    **{"pin_gear": "teeth on pins", "pin_socket": "pins in sockets", "pin_sleeve": "sleeves on pins"},
    **{"tooth": "teeth", "cam": "cam", "output": "output pins"},
    **{"crank_bearing": "crank bearings", "planet_mesh": "planets"},
}
_FORMULAS = {
    "cam": "2 delta/(c (N-1))",
    "output": "delta (1/max R sin beta + 1/max -R sin beta)",
}
_MESH_FORMULA = "delta (1/max l + 1/max -l), about 2 delta/(c (N-1))"
_STATICS = "statics under the same torques"
_ALL = "all"


@dataclass(frozen=True)
class StopPair:
    """Angles of the output at both stops of rigid parts [rad], at a crank angle [rad], by a run."""

    crank: float
    low: float
    high: float
    run: Run

    @property
    def backlash(self) -> float:
        """Angle from stop to stop [rad]."""
        return self.high - self.low


@shows_progress
def backlash(
    design: Named,
    angles: int | None = None,
    quick: bool = False,
    progress: Progress = silent,
    solver: Solver = "planar",
) -> Measurement:
    """Measure the backlash of a design at several locked crank angles.

    It is measured with all clearances together, and with the clearance of each kind of mating pair alone.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file; its load, speed, friction and weight do not matter.
    angles
        Number of crank angles, spread over the turn and over the mesh period; by default `PRESS.angles`.
    quick
        Whether the default of `angles` is the smaller number `PRESS.quick_angles`.
    progress, solver
        Called after each run with the numbers of finished and of all runs; solver of the runs.

    Raises
    ------
    UsageError
        The number of angles is not positive.
    RunError
        A run failed, or the disc jams.

    Returns
    -------
    Measurement
        Backlash [arcmin]: mean and extremes with all clearances together, mean with each clearance alone; with
        numerical errors and closed forms; curves over the crank angle.
    """
    reducer = reducer_of(resolve(design))
    angles = (PRESS.quick_angles if quick else PRESS.angles) if angles is None else angles
    if angles < 1:
        raise UsageError(f"angles = {angles} (the number of crank angles) is out of range: choose 1 or more")
    reducer = reducer.at_rated_load
    crank_angles = [float(crank) for crank in bench.crank_angles(reducer, angles)]
    stops_by_case, checks = _simulate_stops(reducer, crank_angles, solver, progress)
    closed_forms = REFERENCES[reducer.LAYOUT](reducer, crank_angles)
    test_text = f"{reducer.INPUT} locked, without friction and weight"
    return Measurement(
        measure="backlash",
        design=reducer.design,
        condition=", ".join(filter(None, (test_text, reducer.design.thermal.words, SOLVERS[solver]))),
        quantities=by_key(_quantities(stops_by_case, checks, closed_forms)),
        curves=_curves(reducer, stops_by_case, closed_forms),
        assumptions=_assumptions(reducer, [pair.run for pairs in stops_by_case.values() for pair in pairs], solver),
        runs={name: stop_pairs[0].run for name, stop_pairs in stops_by_case.items()},
        details={"angles": _angle_rows(stops_by_case, closed_forms)},
    )


def _simulate_stops(
    reducer: Reducer, crank_angles: list[float], solver: Solver, progress: Progress
) -> tuple[dict[str, list[StopPair]], dict[str, StopPair]]:
    """Simulate the output pressed to both stops at each crank angle [rad], with all clearances and with one kind alone.

    The cases are "all", for all clearances together, and the kinds of mating pairs, for the clearance of one kind
    alone. `solver` is the solver of the runs, MuJoCo or the planar solver.

    Returns
    -------
    stops_by_case
        For each case the stops, one pair per crank angle.
    checks
        For each case the stops at the first angle, pressed for a longer time with a shorter time step, for the
        numerical error.
    """
    cases = {_ALL: bench.without_friction(reducer)} | {
        kind: with_single_clearance(reducer, kind) for kind in _kinds_with_clearance(reducer)
    }
    if solver == "planar":
        cases = {case: massless(drive) for case, drive in cases.items()}
    time_factors = {case: PRESS.all_clearances if case == _ALL else 1.0 for case in cases}
    divisor = PRESS.planar_ratio if solver == "planar" and not reducer.design.settings.timestep else 1.0
    jobs = [
        (drive, crank_angles[0], PRESS.longer * time_factors[case], PRESS.finer * divisor)
        for case, drive in cases.items()
    ]
    jobs += [(drive, angle, time_factors[case], divisor) for case, drive in cases.items() for angle in crank_angles]
    all_stop_pairs = each_in_threads(lambda job: press_to_stops(*job, solver), jobs, progress)
    checks, stop_pairs = dict(zip(cases, all_stop_pairs, strict=False)), all_stop_pairs[len(cases) :]
    count = len(crank_angles)
    stops_by_case = {
        case: stop_pairs[case_index * count : (case_index + 1) * count] for case_index, case in enumerate(cases)
    }
    return stops_by_case, checks


def with_single_clearance(reducer: Reducer, kind: str) -> Reducer:
    """Return the design with the clearance of one kind of mating pair only, and no errors, friction or weight.

    `kind` is the kind of pair that keeps its clearance; the others have the clearance `PRESS.no_clearance`. The nominal
    radius of the holes is that of the output pins plus the eccentricity.
    """
    design = reducer.design
    replacements: dict[str, Any] = {"errors": Errors(), "measured": Measured(), "modification": Modification()}
    if design.crank_errors is not None:
        replacements["crank_errors"] = CrankErrors()
    changes: dict[str, dict[str, float]] = {}
    for other_kind, keys in reducer.clearance_keys.items():
        for table, key in keys if other_kind != kind else ():
            changes.setdefault(table, {})[key] = PRESS.no_clearance
    if "output" in reducer.clearance_keys:
        changes["output"] = {"hole_radius": design.output.pin_radius + design.gear.eccentricity}
    replacements |= {table: getattr(design, table).model_copy(update=lengths) for table, lengths in changes.items()}
    return bench.without_friction(type(reducer)(design.model_copy(update=replacements)))


def _kinds_with_clearance(reducer: Reducer) -> list[str]:
    """List the kinds of pairs that have a clearance, without preloaded bearings."""
    return [
        kind
        for kind, keys in reducer.clearance_keys.items()
        if sum(getattr(getattr(reducer.design, table), key) for table, key in keys) > 0.0
    ]


def press_to_stops(
    reducer: Reducer, crank_angle: float, time_factor: float = 1.0, step_divisor: float = 1.0, solver: Solver = "planar"
) -> StopPair:
    """Simulate the output pressed against both stops, with the cranks locked at an angle [rad]; return their angles.

    A large torque seats the parts, then two smaller torques follow (`PRESS.levels`); the line through the angles at
    these two is extrapolated to zero torque. The same follows in the other direction. The design has no friction and no
    weight. `solver` is the solver of the runs, MuJoCo or the planar solver.

    Parameters
    ----------
    time_factor
        Factor on the time at each torque.
    step_divisor
        Divisor of the time step.
    """
    torque = PRESS.share * reducer.design.rated_torque
    press_time = time_factor * PRESS.settling * rotation_time(reducer, reducer.play_at(crank_angle), torque)
    torques = torque * np.array(PRESS.levels)

    def torque_at(time: Array) -> Array:
        return torques[np.minimum(time / press_time, len(PRESS.levels) - 0.5).astype(int)]

    max_torque, duration, samples = (
        max(PRESS.levels) * torque,
        len(PRESS.levels) * press_time,
        len(PRESS.levels) * PRESS.samples,
    )
    run = bench.run_with_step_retries(
        reducer, crank_angle, torque_at, max_torque, duration, samples, step_divisor, solver
    )
    rotation, phase = output_error(run, reducer), run.time / press_time
    stop_angles = [
        float(rotation[(phase > level + 1 - PRESS.read_share) & (phase < level + 1)].mean())
        for level in range(len(PRESS.levels))
    ]
    _, double_high, single_high, _, double_low, single_low = stop_angles
    return StopPair(crank_angle, low=2.0 * single_low - double_low, high=2.0 * single_high - double_high, run=run)


def _compute_closed_forms(reducer: Reducer, crank_angles: list[float]) -> dict[str, ClosedForm]:
    """Compute the backlash [rad] by a linear programme (all clearances) and by closed forms (each kind of clearance).

    The result maps "all" and each kind of mating pair to two arrays: the backlash at `crank_angles` [rad], and at the
    angles of a full turn (`rigid_backlash.full_turn_angles`). It is empty for a preloaded ring.
    """
    if reducer.design.ring.preload:
        return {}
    turn_angles = rigid_backlash.full_turn_angles(reducer)
    closed_forms = {}
    if rigid_backlash.has_linear_gaps(reducer):
        closed_forms[_ALL] = ClosedForm(
            rigid_backlash.total_backlash(reducer, np.array(crank_angles)),
            rigid_backlash.backlash_over_turn(reducer)[1],
            "rigid contacts: linear programme",
        )
    for kind in _kinds_with_clearance(reducer):
        single_clearance_reducer = with_single_clearance(reducer, kind)
        sampled_backlash, turn_backlash = (
            rigid_backlash.single_clearance_backlash(single_clearance_reducer, angles)[kind]
            for angles in (np.array(crank_angles), turn_angles)
        )
        closed_forms[kind] = ClosedForm(sampled_backlash, turn_backlash, _FORMULAS.get(kind, _MESH_FORMULA))
    return closed_forms


def _compute_static_backlash(reducer: Reducer, crank_angles: list[float]) -> dict[str, ClosedForm]:
    """Compute the backlash of an RV reducer [rad] by statics, at `crank_angles` [rad] and over the turn.

    The result has the single key "all", for all clearances together.
    """
    cases = {_ALL: reducer} | {kind: with_single_clearance(reducer, kind) for kind in _kinds_with_clearance(reducer)}
    turn_angles, torque = rigid_backlash.full_turn_angles(reducer), PRESS.share * reducer.design.rated_torque
    return {
        case: ClosedForm(rv_backlash(drive, crank_angles, torque), rv_backlash(drive, turn_angles, torque), _STATICS)
        for case, drive in cases.items()
        if isinstance(drive, RvReducer)
    }


REFERENCES: Mapping[Layout, Callable[[Reducer, list[float]], dict[str, ClosedForm]]] = {
    "central": _compute_closed_forms,
    "rv": _compute_static_backlash,
}
"""Function that computes the references of each layout."""


def _quantities(
    stops_by_case: dict[str, list[StopPair]], checks: dict[str, StopPair], closed_forms: dict[str, ClosedForm]
) -> Iterator[Quantity]:
    """Yield the quantities of the backlash [arcmin].

    They are mean and extremes with all clearances together, the mean with each clearance alone, and the sum of these
    means.

    Parameters
    ----------
    stops_by_case
        Stops by case ("all" clearances, or the kind of a single clearance), one pair per crank angle.
    checks
        Stops at the first angle by case, with other settings, for the numerical error.
    closed_forms
        Closed forms by the same cases; a case without a closed form has no reference.
    """
    single_clearances = []
    for case, stop_pairs in stops_by_case.items():
        backlashes, closed_form = np.array([pair.backlash for pair in stop_pairs]), closed_forms.get(case)
        numerical_error = abs(checks[case].backlash - stop_pairs[0].backlash)
        error = add_errors(numerical_error, error_of_mean(backlashes, closed_form))
        error = None if error is None else error / ARCMINUTE
        reference = None if closed_form is None else float(closed_form.turn.mean()) / ARCMINUTE
        mean, source = float(backlashes.mean()) / ARCMINUTE, "" if closed_form is None else closed_form.source
        if case == _ALL:
            yield Quantity("backlash", "backlash of the output, mean", mean, "arcmin", error, reference, source)
            extreme_arguments = "backlash", "backlash", backlashes, numerical_error, "arcmin"
            yield from extreme_quantities(
                *extreme_arguments, scale=ARCMINUTE, closed_form=closed_form, reference=closed_form, source=source
            )
        else:
            label = f"by clearance of {NAMES[case]} alone, mean"
            single_clearances.append(Quantity(f"backlash_{case}", label, mean, "arcmin", error, reference, source))
    yield from single_clearances
    yield Quantity(
        "sum_of_parts",
        "sum of the parts",
        sum(quantity.value for quantity in single_clearances),
        "arcmin",
        add_errors(*(quantity.error for quantity in single_clearances)),
        note="less than the total: together, the clearances allow motions of the disc that none allows alone",
    )


def _curves(
    reducer: Reducer, stops_by_case: dict[str, list[StopPair]], closed_forms: dict[str, ClosedForm]
) -> tuple[Curve, ...]:
    """Return curves of the backlash [arcmin] over the crank angle [deg], simulated and by closed form.

    There are two curves for each case. A case is "all" clearances, or the clearance of one kind of mating pair alone.
    `stops_by_case` are the simulated stops by case, from `_simulate_stops`; `closed_forms` have the same keys.
    """
    curve_list = []
    axis_labels = "crank angle [deg]", "backlash [arcmin]"
    for case, stop_pairs in stops_by_case.items():
        panel = "all clearances" if case == _ALL else f"clearance of {NAMES[case]} alone"
        crank_deg = np.degrees([pair.crank for pair in stop_pairs])
        if case in closed_forms:
            turn_angles = np.degrees(rigid_backlash.full_turn_angles(reducer))
            curve_list.append(
                Curve(panel, "closed form", turn_angles, closed_forms[case].turn / ARCMINUTE, *axis_labels, "theory")
            )
        backlashes = np.array([pair.backlash for pair in stop_pairs]) / ARCMINUTE
        curve_list.append(Curve(panel, "simulated", crank_deg, backlashes, *axis_labels, "points"))
    return tuple(curve_list)


def _assumptions(reducer: Reducer, runs: list[Run], solver: Solver) -> tuple[str, ...]:
    """Return the assumptions of a backlash measurement by simulation, a sentence each.

    They are about torques, friction, contact stiffness, time steps and errors. `runs` are all runs of the measure, for
    their time steps. `solver` is the solver of the runs, MuJoCo or the planar solver.
    """
    torque = PRESS.share * reducer.design.rated_torque
    return (
        f"the {reducer.INPUT} is locked; the output is pressed against its stops by {torque:.2g} and "
        f"{2.0 * torque:.2g} N m, and the line through both angles is extrapolated to zero torque",
        "without friction and weight; `measure lost-motion` includes them",
        "contacts have their stiffness under the rated load, whose effect the extrapolation removes: "
        f"{reducer.contacts.working_forces_text(tuple(reducer.clearance_keys))}",
        f"a clearance alone: the others are {1e6 * PRESS.no_clearance:g} um, without manufacturing errors and "
        "modification",
        f"time step {bench.timesteps_text(runs)}; numerical error: change with {PRESS.longer:g} times the time at each "
        f"torque and a {PRESS.finer:g} times shorter time step at the first crank angle, and the error of the turn's "
        "mean and extremes by its angles (by the closed form, and by the scatter of the remainder)",
        *(assumptions(reducer, "all runs") if solver == "planar" else ()),
    )


def _angle_rows(stops_by_case: dict[str, list[StopPair]], closed_forms: dict[str, ClosedForm]) -> list[dict[str, Any]]:
    """Return a JSON object for each crank angle: both stops and backlash [arcmin], its closed form, and time steps [s].

    The stops are those with all clearances together. Backlash, closed form and time step have a value for each case:
    "all" clearances, or the clearance of one kind of mating pair alone, with the kind as its key. `stops_by_case` has a
    pair of stops per crank angle for each case, from `_simulate_stops`; `closed_forms` are by case, too.
    """
    return [
        {
            "crank_angle_deg": math.degrees(pair.crank),
            "low_arcmin": pair.low / ARCMINUTE,
            "high_arcmin": pair.high / ARCMINUTE,
            "backlash_arcmin": {case: pairs[index].backlash / ARCMINUTE for case, pairs in stops_by_case.items()},
            "timestep_s": {case: bench.timestep_of(pairs[index].run) for case, pairs in stops_by_case.items()},
            "closed_form_arcmin": {
                case: float(closed_form.sampled[index]) / ARCMINUTE for case, closed_form in closed_forms.items()
            },
        }
        for index, pair in enumerate(stops_by_case[_ALL])
    ]
