"""Vibration over crank speed: acceleration of gear centre and output, force on the housing, and unbalance."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from operator import attrgetter, methodcaller
from typing import Any

import numpy as np

from cycloid_mj.analysis.spectrum import SPECTRUM, tapered_orders
from cycloid_mj.base.engine import Progress, each_in_threads, silent
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.base.result import Curve, Quantity, by_key
from cycloid_mj.base.statistics import rms
from cycloid_mj.base.units import RPM
from cycloid_mj.design import Named, resolve
from cycloid_mj.design.layouts import Layout
from cycloid_mj.dynamics.massless import require_pin_bodies
from cycloid_mj.dynamics.planar.timestep import acceleration_timestep
from cycloid_mj.dynamics.run import Solver, model_for
from cycloid_mj.measure.conditions import STEADY, describe_loads, halve_time_step, load_cases, require_motion
from cycloid_mj.measure.measurement import Measurement
from cycloid_mj.measure.reaction import unbalance, weight_force
from cycloid_mj.measure.trace import copy_model
from cycloid_mj.measure.vibration_runs import VibrationRun, run_vibration
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of

SPEED_FRACTIONS = (0.5, 0.75, 1.0, 1.25, 1.5)
"""Speeds of the sweep relative to the design's (heuristic)."""
SPECTRUM_SIGNALS = ("gear_centre", "output", "housing")
"""Signals whose spectra are drawn."""
_HZ = "frequency [Hz]"
_NOTE = "sum of all contact forces; m a does not include the inertia of free pins and sleeves"
_SIGNALS = {"gear_centre": ("acceleration of the disc's centre", "m/s2")}
_SIGNALS |= {"output": ("acceleration of the output", "rad/s2"), "housing": ("force on the housing", "N")}
_OF_COUNTERWEIGHT = {"housing_bare": ("force on the housing, no counterweight", "N")}
"""Signals of a single disc on a central crank, which a counterweight balances."""
_OF_PLANES = {
    "shaft_tilting": ("tilting moment of the discs on the shaft", "N m"),
    "output_tilting": ("tilting moment of the discs on the output", "N m"),
    "shaft_bearing_far": ("force of the shaft's bearing far from the discs", "N"),
    "shaft_bearing_near": ("force of the shaft's bearing near the discs", "N"),
}
"""Signals of several discs, whose forces act in different planes."""
_LAYOUT_SIGNALS: Mapping[Layout, tuple[Mapping[str, tuple[str, str]], Mapping[str, tuple[str, str]]]] = {
    "central": (_OF_COUNTERWEIGHT, _OF_PLANES),
    "rv": ({}, {"output_tilting": ("tilting moment of the discs on the carrier", "N m")}),
}
"""Further signals of each layout, with a single disc and with several discs."""


@shows_progress
def vibration(
    design: Named,
    load: float | None = None,
    speeds: Sequence[float] = (),
    turns: int = 1,
    quick: bool = False,
    progress: Progress = silent,
    solver: Solver = "planar",
) -> Measurement:
    """Measure the vibration of a design over crank speed, unloaded and loaded.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file.
    load
        Torque of the loaded runs [N m]; by default the rated torque, drive.torque times the ratio.
    speeds
        Speeds of crank or sun besides the design's [rad/s]; by default the design's speed times each of
        `SPEED_FRACTIONS`.
    turns, quick
        Crank turns of each run after it has settled; whether to measure only the design's speed, and skip the runs with
        half the time step.
    progress, solver
        Called after each run with the numbers of finished and of all runs; solver of the runs.

    Returns
    -------
    Measurement
        For each load the rms accelerations of disc centre [m/s2] and output [rad/s2], forces on the housing [N] and
        unbalance, with numerical errors and closed forms; curves over the speed and spectra.
    """
    reducer = reducer_of(resolve(design))
    require_motion(reducer)
    require_pin_bodies(reducer, "vibration")
    speed, torques = reducer.design.drive.speed, load_cases(reducer, load)
    reducer = reducer.working_at(torques["loaded"])
    if solver == "planar":
        reducer = reducer.but(settings={"timestep": acceleration_timestep(reducer)})
    other_speeds = [] if quick else list(speeds) or [share * speed for share in SPEED_FRACTIONS]
    all_runs = _run_sweep(reducer, torques, sorted({speed, *other_speeds}, key=abs), turns, not quick, solver, progress)
    finer_runs = {} if quick else {run.load: run for run in all_runs[-len(torques) :]}
    full_runs = all_runs[: len(all_runs) - len(finer_runs)]
    runs_at_speed = [run for run in full_runs if run.speed == speed]
    return Measurement(
        measure="vibration",
        design=reducer.design,
        condition=(
            f"{describe_loads(torques)}, spectra at {abs(speed) / RPM:.0f} rpm, {reducer.design.condition_words}, "
            f"{SOLVERS[solver]}"
        ),
        quantities=by_key(
            _level_quantities(reducer, runs_at_speed, finer_runs),
            _unbalance_quantities(reducer, runs_at_speed, finer_runs),
        ),
        curves=(*_sweep_curves(reducer, full_runs), *_spectrum_curves(reducer, runs_at_speed)),
        assumptions=_assumptions(reducer, runs_at_speed[0]),
        runs={f"{run.load}_{abs(run.rpm):.0f}rpm": run.run for run in full_runs},
        details={"band_hz": 0.5 * runs_at_speed[0].rate, "sweep": [_sweep_row(reducer, run) for run in full_runs]},
    )


def _run_sweep(
    reducer: Reducer,
    torques: Mapping[str, float],
    speeds: Sequence[float],
    turns: int,
    check_step: bool,
    solver: Solver,
    progress: Progress,
) -> list[VibrationRun]:
    """Simulate every load at every speed of the driven shaft [rad/s], each over some crank `turns`.

    With `check_step`, runs at the design's speed with half the time step follow. `torques` maps the name of a load to
    the torque on the output [N m]. `solver` is the solver of the runs, MuJoCo or the planar solver.
    """
    points = [(reducer, model_for(solver, reducer), speed) for speed in speeds]
    if check_step:
        half_step_reducer = halve_time_step(reducer, solver)
        points.append((half_step_reducer, model_for(solver, half_step_reducer), reducer.design.drive.speed))
    tasks = [
        (drive, copy_model(model), *load, speed, turns) for drive, model, speed in points for load in torques.items()
    ]
    return each_in_threads(lambda task: run_vibration(*task), tasks, progress)


def _signals(reducer: Reducer) -> dict[str, tuple[str, str]]:
    """Return the name and unit of each signal of a design, by key."""
    return _SIGNALS | dict(_LAYOUT_SIGNALS[reducer.LAYOUT][reducer.design.gear.discs > 1])


def _spectrum_keys(reducer: Reducer) -> tuple[str, ...]:
    """List the keys of the signals whose spectra are drawn."""
    _, plane_signals = _LAYOUT_SIGNALS[reducer.LAYOUT]
    return (*SPECTRUM_SIGNALS, *(plane_signals if reducer.design.gear.discs > 1 else ()))


def _level_quantities(
    reducer: Reducer, runs: Sequence[VibrationRun], half_step_runs: Mapping[str, VibrationRun]
) -> Iterator[Quantity]:
    """Yield the rms of each acceleration and force at the design's speed, and further quantities of the vibration.

    The rms levels include frequencies up to half of `VibrationRun.rate`. The further quantities are the mean force on
    the housing, the rms acceleration of the disc's centre including that of the ideal motion, and, for the signals of
    `_spectrum_keys`, the share of their power above that frequency [%]. The rms force on the housing has a reference:
    the force by the momentum balance of disc and shaft.

    Parameters
    ----------
    runs
        Runs at the design's speed, one per load.
    half_step_runs
        Runs with half the time step by load, for the error; empty without this check.
    """
    orbit_acceleration = reducer.design.gear.eccentricity * reducer.orbit_speed**2
    weight, all_signals = float(np.hypot(*weight_force(reducer))), _signals(reducer)
    shaft_word = "sun" if isinstance(reducer, RvReducer) else "shaft"
    for run in runs:
        half_step_run = half_step_runs.get(run.load)
        for key, (name, unit) in all_signals.items():
            level, error = run.rms(key), _step_change(run, half_step_run, methodcaller("rms", key))
            error = None if error is None else max(error, abs(rms(run.signals[key][: len(run.crank) // 2]) - level))
            reference, source = (
                (run.rms("momentum"), f"m a of disc and {shaft_word}") if key == "housing" else (None, "")
            )
            note = _NOTE if key == "housing" else ""
            level_name = f"rms {name} below {5e-4 * run.rate:.3g} kHz, {run.load}"
            yield Quantity(f"{key}_rms_{run.load}", level_name, level, unit, error, reference, source, note)
        for key in _spectrum_keys(reducer):
            name, _ = all_signals[key]
            level_name = f"share of the power of the {name} above {5e-4 * run.rate:.3g} kHz, {run.load}"
            error = _step_change(run, half_step_run, methodcaller("above", key))
            error = None if error is None else 1e2 * error
            note = f"sampled at {1e-3 * run.sampled_rate:.4g} kHz; the figures include the part below"
            yield Quantity(f"{key}_above_band_{run.load}", level_name, 1e2 * run.above(key), "%", error, note=note)
        level_name, error = (
            f"full acceleration of the disc's centre, {run.load}",
            _step_change(run, half_step_run, attrgetter("orbit")),
        )
        yield Quantity(f"orbit_{run.load}", level_name, run.orbit, "m/s2", error, orbit_acceleration, "c omega^2")
        level_name, error = f"mean force on the housing, {run.load}", _step_change(run, half_step_run, _mean_force)
        yield Quantity(
            f"mean_force_{run.load}", level_name, _mean_force(run), "N", error, weight, "weight of the moving parts"
        )


def _unbalance_quantities(
    reducer: Reducer, runs: Sequence[VibrationRun], half_step_runs: Mapping[str, VibrationRun]
) -> Iterator[Quantity]:
    """Yield static unbalance [g mm] and rocking couple [N m] of the solids, and the force rotating with the crank [N].

    The force is evaluated in the first of the `runs`. Its closed form is the sum of m c omega^2, with mass,
    eccentricity and crank speed. `half_step_runs` are the runs with half the time step by load, for the error.
    """
    unbalances, speed_squared = unbalance(reducer), reducer.orbit_speed**2
    has_counterweight = "housing_bare" in _signals(reducer)
    first_run, half_step_run = runs[0], half_step_runs.get(runs[0].load)
    unbalanced_text, balanced_text = (
        (", without counterweight", ", with counterweight") if has_counterweight else ("", "")
    )
    without_counterweight = [("housing_bare", unbalanced_text, unbalances.bare)] if has_counterweight else []
    for key, condition, closed_form in (*without_counterweight, ("housing", balanced_text, unbalances.balanced)):
        yield Quantity(
            key=f"{key}_rotating",
            name=f"force that rotates with the crank{condition}",
            value=first_run.rotating(key),
            unit="N",
            error=_step_change(first_run, half_step_run, methodcaller("rotating", key)),
            reference=abs(closed_form) * speed_squared,
            source="sum of m c omega^2",
        )
    couple = abs(unbalances.couple) * speed_squared
    arrangement_text = "the counterweight lies next to the disc" if has_counterweight else "discs balance each other"
    note = f"{arrangement_text}: the force is balanced, the couple is not"
    if reducer.design.gear.discs == 1 and not has_counterweight:
        note = "a single disc is not balanced"
    parts_text = " of discs" if isinstance(reducer, RvReducer) else " of discs and cams"
    yield Quantity("unbalance", f"unbalance{unbalanced_text or parts_text}", 1e6 * unbalances.bare, "g mm")
    yield Quantity("couple", f"rocking couple{balanced_text}", couple, "N m", note=note)


def _step_change(
    run: VibrationRun, half_step_run: VibrationRun | None, read_value: Callable[[VibrationRun], float]
) -> float | None:
    """Return the change of a reading with half the time step; None without such a run."""
    return None if half_step_run is None else abs(read_value(half_step_run) - read_value(run))


def _mean_force(run: VibrationRun) -> float:
    return float(np.hypot(*run.mean_force))


def _sweep_curves(reducer: Reducer, runs: Sequence[VibrationRun]) -> Iterator[Curve]:
    """Yield a curve of each signal and load: its rms level over the speed of crank or sun [rpm].

    The force on the housing without counterweight also has a curve of its closed form, m c omega^2 of the discs. `runs`
    are the simulated runs.
    """
    static_unbalance, speed_label = unbalance(reducer).bare, f"{reducer.INPUT} speed [rpm]"
    for key, (name, unit) in _signals(reducer).items():
        panel = f"rms of the {name}"
        loads = dict.fromkeys(run.load for run in runs)
        if key == "housing_bare":
            rpm = np.linspace(0.0, max(abs(run.rpm) for run in runs), 61)
            force = static_unbalance * (rpm * RPM) ** 2
            yield Curve(panel, "sum of m c omega^2", rpm, force, speed_label, f"rms [{unit}]", "theory")
        for load in loads:
            points = [run for run in runs if run.load == load]
            x, y = np.array([abs(point.rpm) for point in points]), np.array([point.rms(key) for point in points])
            yield Curve(panel, load, x, y, speed_label, f"rms [{unit}]", "points" if len(points) == 1 else "line")


def _spectrum_curves(reducer: Reducer, runs: Sequence[VibrationRun]) -> Iterator[Curve]:
    """Yield the amplitude spectra of accelerations [m/s2, rad/s2] and forces [N] over the frequency [Hz].

    The amplitude of a vector is the root of the sum of the squared amplitudes of its components. Runs that are shorter
    than the window of the spectrum have none.
    """
    for key in _spectrum_keys(reducer):
        name, unit = _signals(reducer)[key]
        for run in runs:
            turns_per_second = abs(run.crank_speed) / (2.0 * np.pi)
            spectra = [orders for axis in run.signals[key].T if (orders := tapered_orders(run.crank, axis)) is not None]
            if spectra:
                amplitude = np.sqrt(np.sum([spectrum.amplitude**2 for spectrum in spectra], axis=0))
                min_frequency, max_frequency = (order * turns_per_second for order in spectra[0].band)
                axis_label = f"{_HZ}, accurate to 1 % from {min_frequency:.0f} to {max_frequency:.0f} Hz"
                frequency, panel = spectra[0].order * turns_per_second, f"spectrum of the {name}"
                yield Curve(panel, run.load, frequency, amplitude, axis_label, f"amplitude [{unit}]")


def _assumptions(reducer: Reducer, run: VibrationRun) -> tuple[str, ...]:
    """Return the assumptions of a vibration measurement by simulation, a sentence each.

    They are about bearings, references, sampling, load and numerical errors of the runs.
    """
    beam_text = (
        ""
        if isinstance(reducer, RvReducer)
        else ", and the shaft is a beam on its two bearings, without its own unbalance"
    )
    plane_notes = (
        "several discs: the disc's centre is that of disc 1; forces act in the plane of each disc, tilting moments "
        f"are about the middle of all discs{beam_text}",
    )
    return (
        "bearings and housing are rigid; a bearing's force is the inertia of its body minus contact forces and weight",
        "accelerations are relative to the closed form (Eqs 12 and 14) at the measured crank angle, forces to their "
        "mean",
        *(plane_notes if reducer.design.gear.discs > 1 else ()),
        f"accelerations and forces are sampled at {1e-3 * run.sampled_rate:.4g} kHz and filtered before they are "
        f"stored at {1e-3 * run.rate:.4g} kHz: their rms includes the part below {5e-4 * run.rate:.3g} kHz (the "
        f"filter falls from {1e-3 * SPECTRUM.band * run.rate:.3g} to {1e-3 * (1.0 - SPECTRUM.band) * run.rate:.3g} "
        f"kHz), the spectra end at {1e-3 * SPECTRUM.band * run.rate:.3g} kHz",
        f"unloaded: a drag of {STEADY.drag_share:.0%} of the nominal torque, which presses the flanks together before "
        "the window; the spectra are at the design's speed",
        "contacts have the secant stiffness of one working force in all runs, that of the loaded ones: "
        f"{reducer.contacts.working_forces_text(tuple(reducer.clearance_keys))}",
        "numerical error: change with half the time step at the design's speed (not available with --quick), of an "
        "rms also the change with half the window; unloaded pins rattle, and a run with other rounding may differ by "
        "some percent",
    )


def _sweep_row(reducer: Reducer, run: VibrationRun) -> dict[str, Any]:
    levels = {f"{key}_rms": run.rms(key) for key in _signals(reducer)}
    return {"speed_rpm": run.rpm, "load": run.load, "orbit_m_s2": run.orbit, **levels}
