"""Figs 5-9: input law, gear speed, path and velocity of q, pin 1; and the claims on ratio, speed and pin 1."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from cycloid_mj.analysis import Findings, Series, judge, series
from cycloid_mj.comparison import Spread, load_words, settled, settling
from cycloid_mj.design import Design
from cycloid_mj.result import Claim, Table, Value, Verdict
from cycloid_mj.types import Array
from hsieh2014 import statements
from hsieh2014.plan import LOGGED, Plan, designs, idle_runs, main_runs, ramped
from hsieh2014.stage import Found, Plate, Progress, Runs
from hsieh2014.verdicts import range_verdict, share_verdict, spread_error, spread_value

SPEED_ERROR = 1e-3
"""The mean gear speed agrees with the ratio within this share."""

SWAYS, GIVE = 0.1, 0.05
"""Shares of the clearance: a pin sways if it moves farther than the one; the give of its socket is within the other."""

NUMBERS: tuple[tuple[str, str, Callable[[Findings], float]], ...] = (
    ("gear_speed_mean_rad_s", "gear speed, mean [rad/s]", lambda one: one.gear_speed.mean_rad_s),
    ("gear_speed_rms_error_rad_s", "gear speed, rms error [rad/s]", lambda one: one.gear_speed.rms_error_rad_s),
    ("q_path_rms_error_um", "path of q, rms error [um]", lambda one: one.q_path.rms_error_um),
    ("q_path_max_error_um", "path of q, largest error [um]", lambda one: one.q_path.max_error_um),
    ("q_velocity_rms_error_mm_s", "velocity of q, rms error [mm/s]", lambda one: one.q_speed.rms_error_mm_s),
    (
        "transmission_error_arcsec",
        "transmission error, peak to peak [arcsec]",
        lambda one: one.transmission_error.peak_to_peak_arcsec,
    ),
    ("contacts_mean", "contacts that carry force, mean", lambda one: one.contact_summary.mean_active),
    ("peak_force_n", "largest force of a contact [N]", lambda one: one.contact_summary.peak_force_n),
)
"""Figs 6-8 in numbers: key, words, and the number of a run."""


def motions(plan: Plan, runs: Runs) -> list[Series]:
    """Give the main runs beside their closed form, at every logged sample."""
    return [settled(run) for run in runs(main_runs(plan))]


def idle_motions(plan: Plan, runs: Runs, design: Design) -> list[Series]:
    """Give the independent starts of a design at no load beside their closed form."""
    return [settled(run) for run in runs(idle_runs(plan, design))]


def _rated(found: Sequence[Series], design: Design) -> Series:
    return next(one for one in found if one.design.name == design.name and one.design.load.torque)


def input_law(plan: Plan, runs: Runs, progress: Progress) -> Found:
    """Fig. 5: the crank's speed over time."""
    from cycloid_mj.plots.motion import input_figure

    cases = [ramped(design) for design in designs()] if plan.ramp else main_runs(plan)[:2]
    found = [series(run) for run in runs(cases)]
    what = "ramp of 1 s, then constant" if plan.ramp else "QUICK: from full speed, without the ramp"
    plates = [
        Plate(
            f"fig5_input_{one.design.name}",
            "Fig. 5",
            f"{one.design.name}: speed of the crank, {what}; below, how far the servo is off the law.",
            input_figure(one),
        )
        for one in found
    ]
    errors = {one.design.name: float(np.abs(one.crank_speed.error).max()) for one in found}
    note = "The paper's law: 0 to 1640 rpm (9840 deg/s, 171.74 rad/s) in a linear ramp of 1 s, then constant."
    return Found(tuple(plates), findings={"largest_error_rad_s": errors, "ramp": plan.ramp}, notes=(note,))


def gear_speed(plan: Plan, runs: Runs, progress: Progress) -> Found:
    """Fig. 6: the angular velocity of the cycloid gear."""
    from cycloid_mj.plots.motion import gear_speed_figure

    found = motions(plan, runs)
    words = "angular velocity of the cycloid gear over a crank turn, with -omega_i/35 (Eq. 12); below, the difference"
    judged = {_key(one): judge(one) for one in found}
    head = ("over the settled turns", *(f"{one.design.name}, {_load(one)}" for one in found))
    rows: list[tuple[str | float, ...]] = [(name, *map(number, judged.values())) for _, name, number in NUMBERS]
    return Found(
        _plates(found, "fig6_gear_speed", "Fig. 6", words, gear_speed_figure),
        (Table("Figs 6-8 in numbers", head, tuple(rows)),),
        tuple(_ratio(design.name, idle_motions(plan, runs, design), _rated(found, design)) for design in designs()),
        {name: {key: number(one) for key, _, number in NUMBERS} for name, one in judged.items()},
        ("The paper: the gear turns at 4.907 rad/s against the crank, with small fluctuations, larger with pins.",),
    )


def q_path(plan: Plan, runs: Runs, progress: Progress) -> Found:
    """Fig. 7: the path of q, with a local magnification."""
    from cycloid_mj.plots.point import path_figure

    words = "path of q, the centre of hole 1, with Eq. 16 and the place where they differ most, magnified"
    note = "The paper magnifies its path to show that the simulated point strays from the closed form, more with pins."
    return Found(_plates(motions(plan, runs), "fig7_q_path", "Fig. 7", words, path_figure), notes=(note,))


def q_velocity(plan: Plan, runs: Runs, progress: Progress) -> Found:
    """Fig. 8: the velocity of q and its error."""
    from cycloid_mj.plots.point import velocity_figure

    words = "velocity of q with Eqs 17 and 18 (corrected), and its error"
    note = "The paper: both designs follow the closed form; the velocity fluctuates more with pins."
    return Found(_plates(motions(plan, runs), "fig8_q_velocity", "Fig. 8", words, velocity_figure), notes=(note,))


def pin_1(plan: Plan, runs: Runs, progress: Progress) -> Found:
    """Fig. 9: spin and centre of pin 1."""
    from cycloid_mj.plots.pin import pin_figure

    found = [one for one in motions(plan, runs) if one.pin_1]
    words = "centre of pin 1 in its socket (dashed: the clearance), its distance from the middle, and its spin"
    plates = _plates(found, "fig9_pin_1", "Fig. 9", words, lambda one: pin_figure(one, _pin(one)))
    note = "The paper: pin 1 sways within its clearance and turns; the nonpin design has no such part."
    design = designs()[0]
    starts, rated = idle_motions(plan, runs, design), _rated(found, design)
    return Found(plates, claims=(_sway(starts, rated), _spin(starts, rated)), notes=(note,))


def _plates(
    found: Sequence[Series], name: str, figure: str, words: str, draw: Callable[[Series], Any]
) -> tuple[Plate, ...]:
    """Draw each run at the paper's sampling."""
    return tuple(
        Plate(f"{name}_{_key(one)}", figure, f"{one.design.name}, {_load(one)}: {words}.", draw(at_degrees(one)))
        for one in found
    )


def at_degrees(motion: Series) -> Series:
    """Give a run at one sample for each degree, the paper's sampling."""
    return series(motion.run.select(slice(None, None, LOGGED)), motion.q, settling(motion.design))


def _load(motion: Series) -> str:
    return load_words(motion.design.load.torque)


def _key(motion: Series) -> str:
    return f"{motion.design.name}_{'loaded' if motion.design.load.torque else 'unloaded'}"


def _pin(motion: Series) -> Any:
    return motion.pin_1


def _ratio(name: str, starts: Sequence[Series], rated: Series) -> Claim:
    """Hold the mean gear speed of a design against the ratio, in every start at no load."""
    speeds = Spread.of(_mean_speed(one) for one in starts)
    exact = abs(starts[0].design.drive.speed) / starts[0].design.lobes
    return statements.gear_speed(name).judged(
        found=spread_value(f"{speeds.mean:.5g} rad/s", speeds, "rad/s"),
        error=spread_error(speeds, "rad/s"),
        verdict=range_verdict(speeds, exact * (1.0 - SPEED_ERROR), exact * (1.0 + SPEED_ERROR)),
        decided_by="the number of teeth",
        rated=Value(f"{_mean_speed(rated):.5g} rad/s", _mean_speed(rated), "rad/s"),
    )


def _sway(starts: Sequence[Series], rated: Series) -> Claim:
    """Judge whether pin 1 moves about in its clearance, and does not leave it but by the give of the contact."""
    clearance = _pin(starts[0]).clearance
    reach = Spread.of(_reach(one) for one in starts)
    span = Spread.of(_span(one) for one in starts)
    pairs = zip(span.values, reach.values, strict=True)
    return statements.pin_1_sway(clearance).judged(
        found=Value(
            f"{_um(span)} um across, {_um(reach)} um from the middle; clearance {1e6 * clearance:g} um",
            1e3 * reach.mean,
            "mm",
            (1e3 * reach.low, 1e3 * reach.high),
        ),
        error=Value(f"spread of {len(starts)} starts", 1e6 * reach.half, "um"),
        verdict=share_verdict(least > SWAYS * clearance and most <= (1.0 + GIVE) * clearance for least, most in pairs),
        decided_by="the clearance",
        rated=Value(
            f"{1e6 * _span(rated):.3g} um across, {1e6 * _reach(rated):.3g} um from the middle, by the give of the "
            "socket",
            1e3 * _reach(rated),
            "mm",
        ),
    )


def _spin(starts: Sequence[Series], rated: Series) -> Claim:
    """Judge whether pin 1 turns on: whether its mean spin has one sign in all starts."""
    means = Spread.of(mean_spin(one) for one in starts)
    rocking = Spread.of(float(np.sqrt(np.mean(_spins(one) ** 2))) for one in starts)
    turns_on = means.low > 0.0 or means.high < 0.0
    return statements.PIN_1_SPIN.judged(
        found=spread_value(f"mean {means.words} rad/s, rms {rocking.words} rad/s", means, "rad/s"),
        error=spread_error(means, "rad/s"),
        verdict=Verdict.AGREES if turns_on else Verdict.NOT_DETERMINED,
        decided_by="the scatter of the starts: an idle pin rocks to and fro; how far it turns on is set by friction",
        rated=Value(
            f"mean {mean_spin(rated):.3g} rad/s, which the creep speed of the friction law alone sets (a factor of 5 "
            "between 20 and 1 mm/s): not determined",
            mean_spin(rated),
            "rad/s",
        ),
    )


def _um(lengths: Spread) -> str:
    return Spread.of(1e6 * each for each in lengths.values).words


def _mean_speed(motion: Series) -> float:
    """Give the mean speed of the gear against the crank [rad/s], over whole turns."""
    speed = motion.gear_speed.simulated[motion.whole_periods]
    return -float(np.mean(speed)) * float(np.sign(motion.design.drive.speed))


def mean_spin(motion: Series) -> float:
    """Give the mean spin of pin 1 [rad/s], over whole turns."""
    return float(np.mean(_spins(motion)))


def _spins(motion: Series) -> Array:
    spins: Array = _pin(motion).spin[motion.whole_periods]
    return spins


def _reach(motion: Series) -> float:
    """Give how far pin 1 gets from the middle of its socket [m]."""
    return float(_pin(motion).radial[motion.hold].max())


def _span(motion: Series) -> float:
    """Give the width that the centre of pin 1 moves in [m]."""
    return float(np.ptp(_pin(motion).position[motion.hold], axis=0).max())
