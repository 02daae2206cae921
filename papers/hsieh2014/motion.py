"""Figs 5-9: input law, disc speed, path and velocity of q, pin 1; and the claims on ratio and transmission error."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from operator import attrgetter
from typing import Any

import numpy as np

from cycloid_mj.analysis import Findings, Series, judge, series
from cycloid_mj.base.result import Claim, Removal, Table, Value, Verdict
from cycloid_mj.comparison import StartSpread, load_words, settle_run, settling_time
from cycloid_mj.design import Design
from hsieh2014 import statements
from hsieh2014.over_starts import OverStarts, over_starts, ruling
from hsieh2014.pin_claims import pin_claims
from hsieh2014.pin_motion import pin_motion
from hsieh2014.plan import SAMPLES, Plan, designs, main_runs, ramp_run
from hsieh2014.run_figures import mean_speed, transmission_error
from hsieh2014.stage import PaperFigure, Progress, Runs, StageResult
from hsieh2014.verdicts import spread_error, spread_value

TE = "transmission error, peak to peak [arcsec]"
NUMBERS: tuple[tuple[str, str, Callable[[Findings], float]], ...] = (
    ("gear_speed_mean_rad_s", "disc speed, mean [rad/s]", lambda each: each.gear_speed.mean_rad_s),
    ("gear_speed_rms_error_rad_s", "disc speed, rms error [rad/s]", lambda each: each.gear_speed.rms_error_rad_s),
    ("q_path_rms_error_um", "path of q, rms error [um]", lambda each: each.q_path.rms_error_um),
    ("q_path_max_error_um", "path of q, largest error [um]", lambda each: each.q_path.max_error_um),
    ("q_velocity_rms_error_mm_s", "velocity of q, rms error [mm/s]", lambda each: each.q_speed.rms_error_mm_s),
    ("transmission_error_arcsec", TE, lambda each: each.transmission_error.peak_to_peak_arcsec),
    ("contacts_mean", "contacts that carry force, mean", lambda each: each.contact_summary.mean_active),
    ("peak_force_n", "largest force of a contact [N]", lambda each: each.contact_summary.peak_force_n),
)
"""Numbers of Figs 6-8: key, label, and function of a run's results."""


def motions(plan: Plan, runs: Runs) -> list[Series]:
    """Return the main runs with their closed form, at every logged sample."""
    return [settle_run(run) for run in runs(main_runs(plan))]


def _rated_run(compared: Sequence[Series], design: Design) -> Series:
    return next(each for each in compared if each.design.name == design.name and each.design.load.torque)


def input_law(plan: Plan, runs: Runs, progress: Progress) -> StageResult:
    """Draw Fig. 5, the speed of the crank over time."""
    from cycloid_mj.plots.motion import input_figure

    cases = [ramp_run(plan, design) for design in designs()] if plan.ramp else main_runs(plan)[:2]
    compared = [series(run) for run in runs(cases)]
    what = "ramp of 1 s, then constant" if plan.ramp else "quick: from full speed, without the ramp"
    plates = [
        PaperFigure(
            f"fig5_input_{each.design.name}",
            "Fig. 5",
            f"{each.design.name}: speed of the crank, {what}; below: deviation of the servo from the prescribed speed.",
            input_figure(each),
        )
        for each in compared
    ]
    errors = {each.design.name: float(np.abs(each.crank_speed.error).max()) for each in compared}
    note = "The paper's law: 0 to 1640 rpm (9840 deg/s, 171.74 rad/s) in a linear ramp of 1 s, then constant."
    return StageResult(tuple(plates), findings={"largest_error_rad_s": errors, "ramp": plan.ramp}, notes=(note,))


def gear_speed(plan: Plan, runs: Runs, progress: Progress) -> StageResult:
    """Draw Fig. 6, the angular velocity of the gear, and judge its mean against the ratio."""
    from hsieh2014.paper_figures import speeds_figure

    compared = motions(plan, runs)
    words = "angular velocity of the cycloid gear over a crank turn, with -omega_i/35 (Eq. 12)"
    judged = {_key(each): judge(each) for each in compared}
    head = ("over the settled turns", *(f"{each.design.name}, {_load(each)}" for each in compared))
    rows: list[tuple[str | float, ...]] = [(name, *map(number, judged.values())) for _, name, number in NUMBERS]
    return StageResult(
        _figures_by_load(compared, "fig6_gear_speed", "Fig. 6", words, speeds_figure),
        (Table("Figs 6-8 in numbers", head, tuple(rows)),),
        tuple(
            _judge_gear_speed(over_starts(plan, runs, design, attrgetter("mean_speed")), _rated_run(compared, design))
            for design in designs()
        ),
        {name: {key: number(each) for key, _, number in NUMBERS} for name, each in judged.items()},
        ("The paper: the gear turns at 4.907 rad/s against the crank, with small fluctuations, larger with pins.",),
    )


def q_path(plan: Plan, runs: Runs, progress: Progress) -> StageResult:
    """Draw Fig. 7, the path of q with a magnified part, and judge the transmission error."""
    from cycloid_mj.plots.point import path_figure
    from hsieh2014.paper_figures import paths_figure

    words = "path of q, the centre of hole 1, with Eq. 16, and its distance from that"
    magnified = "path of q with Eq. 16 and the region of the largest difference, magnified"
    note = (
        "The paper magnifies the path to show that the simulated point deviates from the closed form, more with pins."
    )
    compared = motions(plan, runs)
    claims = [
        _judge_transmission_error(
            over_starts(plan, runs, design, attrgetter("transmission_error")), _rated_run(compared, design)
        )
        for design in designs()
    ]
    plates = _figures_by_load(compared, "fig7_q_path", "Fig. 7", words, paths_figure)
    near = _figures_by_run(compared[:2], "fig7_q_path_magnified", "Fig. 7", magnified, path_figure)
    return StageResult((*plates, *near), claims=tuple(claims), notes=(note,))


def q_velocity(plan: Plan, runs: Runs, progress: Progress) -> StageResult:
    """Draw Fig. 8, the velocity of q and its error."""
    from hsieh2014.paper_figures import velocities_figure

    words = "velocity of q with Eq. 18, and its error"
    note = "The paper: both designs follow the closed form; the velocity fluctuates more with pins."
    return StageResult(
        _figures_by_load(motions(plan, runs), "fig8_q_velocity", "Fig. 8", words, velocities_figure), notes=(note,)
    )


def pin_1(plan: Plan, runs: Runs, progress: Progress) -> StageResult:
    """Draw Fig. 9, rotation and centre of pin 1, and judge the claims on them."""
    from cycloid_mj.plots.pin import pin_figure
    from hsieh2014.paper_figures import pins_figure

    compared = [motion for motion in motions(plan, runs) if motion.pin_1]
    words = "centre of pin 1 in its socket (dashed: the clearance), its distance from the middle, and its spin"
    plates = _figures_by_run(compared, "fig9_pin_1", "Fig. 9", words, lambda each: pin_figure(each, _pin(each)))
    shown = pins_figure({_load(each): at_degrees(each) for each in compared})
    words = "Pin 1 in its socket at crank angles of 0, 120, 240 and 360 deg; displacements are magnified."
    plates = (PaperFigure("fig9a_pin_1_turned", "Fig. 9(a)", words, shown), *plates)
    note = "The paper: pin 1 moves within its clearance and turns; the nonpin design has no such part."
    design = designs()[0]
    claims = pin_claims(
        over_starts(plan, runs, design, attrgetter("pin_1"), lambda changed: changed.ring.has_moving_pins),
        pin_motion(_rated_run(compared, design)),
    )
    return StageResult(plates, claims=claims, notes=(note,))


def _figures_by_load(
    compared: Sequence[Series], name: str, figure: str, words: str, draw: Callable[[Sequence[Series]], Any]
) -> tuple[PaperFigure, ...]:
    """Draw the runs of each load together in one figure, with one sample per degree.

    `name`, `figure` and `words` are the start of the file name, the paper's figure and the caption; `draw` draws runs.
    """
    loads: dict[str, list[Series]] = {}
    for each in compared:
        loads.setdefault(_load(each), []).append(at_degrees(each))
    return tuple(
        PaperFigure(
            f"{name}_{'loaded' if each[0].design.load.torque else 'unloaded'}", figure, f"{load}: {words}.", draw(each)
        )
        for load, each in loads.items()
    )


def _figures_by_run(
    compared: Sequence[Series], name: str, figure: str, words: str, draw: Callable[[Series], Any]
) -> tuple[PaperFigure, ...]:
    """Draw each run in a separate figure, with one sample per degree; parameters as those of `_figures_by_load`."""
    return tuple(
        PaperFigure(
            f"{name}_{_key(each)}", figure, f"{each.design.name}, {_load(each)}: {words}.", draw(at_degrees(each))
        )
        for each in compared
    )


def at_degrees(motion: Series) -> Series:
    """Return a run with one sample per degree, the paper's sampling."""
    return series(motion.run.select(slice(None, None, SAMPLES.logged)), motion.q, settling_time(motion.reducer))


def _load(motion: Series) -> str:
    return load_words(motion.design.load.torque)


def _key(motion: Series) -> str:
    return f"{motion.design.name}_{'loaded' if motion.design.load.torque else 'unloaded'}"


def _pin(motion: Series) -> Any:
    return motion.pin_1


def _judge_gear_speed(evidence: OverStarts[float], rated: Series) -> Claim:
    """Judge whether the mean disc speed is the crank speed over the ratio, within 1e-3, in the starts without load.

    `evidence` are the mean speeds of the starts [rad/s], `rated` is the run under the rated load, whose speed is
    reported.
    """
    design, speeds = rated.design, StartSpread.of(evidence.base)
    exact = abs(design.drive.speed) / design.lobes
    fewer = exact * design.lobes / (design.lobes - 1)

    def words(some: Sequence[float]) -> str:
        return f"{StartSpread.of(some).mean:.5g} rad/s"

    judged = ruling(evidence, lambda speed: abs(speed - exact) <= 1e-3 * exact, words, "the number of teeth")
    lobe = Removal("a lobe of the gear, by Eq. 12", f"{fewer:.5g} rad/s", Verdict.DISAGREES)
    return statements.gear_speed(design.name).judge(
        ours=spread_value(f"{speeds.mean:.5g} rad/s", speeds, "rad/s"),
        error=spread_error(speeds, "rad/s"),
        rated=Value(f"{mean_speed(rated):.5g} rad/s", mean_speed(rated), "rad/s"),
        searched=evidence.ranges,
        **vars(replace(judged, removals=(lobe, *judged.removals))),
    )


def _judge_transmission_error(evidence: OverStarts[float], rated: Series) -> Claim:
    """Judge whether the disc has a transmission error of 0.1 arcsec or more, in the starts without load.

    `evidence` are the peak-to-peak errors of the starts [arcsec], `rated` is the run under the rated load.
    """
    sizes, under = StartSpread.of(evidence.base), transmission_error(rated)
    cause = "the clearances: the disc floats within them without load"
    judged = ruling(evidence, lambda size: size >= 0.1, lambda some: f"{StartSpread.of(some).words} arcsec", cause)
    return statements.transmission_error(rated.design.name).judge(
        ours=spread_value(f"{sizes.words} arcsec peak to peak", sizes, "arcsec"),
        error=spread_error(sizes, "arcsec"),
        rated=Value(f"{under:.3g} arcsec", under, "arcsec"),
        searched=evidence.ranges,
        **vars(judged),
    )
