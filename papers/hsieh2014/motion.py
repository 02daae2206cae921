"""Figs 5-9: input law, gear speed, path and velocity of q, pin 1; and the claims on ratio, speed and pin 1."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from cycloid_mj.analysis import Findings, Series, judge, series
from cycloid_mj.base.result import Claim, Range, Removal, Table, Value, Verdict
from cycloid_mj.base.types import Array
from cycloid_mj.comparison import Spread, Variation, load_words, settled, settling
from cycloid_mj.design import Design
from cycloid_mj.reducer import Reducer
from hsieh2014 import statements
from hsieh2014.plan import (
    LEFT_OPEN,
    LOGGED,
    Plan,
    designs,
    idle_runs,
    main_runs,
    ramped,
    ranges,
    variations,
    varied_idle_runs,
)
from hsieh2014.stage import Found, Plate, Progress, Runs
from hsieh2014.stated import PIN_1_LOADED, SHOWN
from hsieh2014.verdicts import range_verdict, share_verdict, spread_error, spread_value

SPEED_ERROR = 1e-3
"""The mean gear speed agrees with the ratio within this share."""

SEEN_TURN, SEEN_ERROR, ROLLS = 1.0, 0.1, 0.5
"""A pin is seen turned from this angle on [deg], a gear strays from this transmission error on [arcsec], and a pin
rolls if its surface goes along with this share of the gear's.
"""

Varied = Mapping[Variation, Sequence[Series]]
"""What was changed alone -> the idle starts with it."""

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
    from hsieh2014.paper_figures import speeds_figure

    found = motions(plan, runs)
    words = "angular velocity of the cycloid gear over a crank turn, with -omega_i/35 (Eq. 12)"
    judged = {_key(one): judge(one) for one in found}
    head = ("over the settled turns", *(f"{one.design.name}, {_load(one)}" for one in found))
    rows: list[tuple[str | float, ...]] = [(name, *map(number, judged.values())) for _, name, number in NUMBERS]
    return Found(
        _plates(found, "fig6_gear_speed", "Fig. 6", words, speeds_figure),
        (Table("Figs 6-8 in numbers", head, tuple(rows)),),
        tuple(_ratio(design.name, idle_motions(plan, runs, design), _rated(found, design)) for design in designs()),
        {name: {key: number(one) for key, _, number in NUMBERS} for name, one in judged.items()},
        ("The paper: the gear turns at 4.907 rad/s against the crank, with small fluctuations, larger with pins.",),
    )


def q_path(plan: Plan, runs: Runs, progress: Progress) -> Found:
    """Fig. 7: the path of q, with a local magnification."""
    from cycloid_mj.plots.point import path_figure
    from hsieh2014.paper_figures import paths_figure

    words = "path of q, the centre of hole 1, with Eq. 16, and its distance from that"
    magnified = "path of q with Eq. 16 and the place where they differ most, magnified"
    note = "The paper magnifies its path to show that the simulated point strays from the closed form, more with pins."
    found = motions(plan, runs)
    both = {design.name: idle_motions(plan, runs, design) for design in designs()}
    claims = [_strays(name, starts, _rated(found, starts[0].design)) for name, starts in both.items()]
    plates = _plates(found, "fig7_q_path", "Fig. 7", words, paths_figure)
    near = _each(found[:2], "fig7_q_path_magnified", "Fig. 7", magnified, path_figure)
    return Found((*plates, *near), claims=tuple(claims), notes=(note,))


def q_velocity(plan: Plan, runs: Runs, progress: Progress) -> Found:
    """Fig. 8: the velocity of q and its error."""
    from hsieh2014.paper_figures import velocities_figure

    words = "velocity of q with Eq. 18, and its error"
    note = "The paper: both designs follow the closed form; the velocity fluctuates more with pins."
    return Found(_plates(motions(plan, runs), "fig8_q_velocity", "Fig. 8", words, velocities_figure), notes=(note,))


def pin_1(plan: Plan, runs: Runs, progress: Progress) -> Found:
    """Fig. 9: spin and centre of pin 1."""
    from cycloid_mj.plots.pin import pin_figure
    from hsieh2014.paper_figures import pins_figure

    found = [one for one in motions(plan, runs) if one.pin_1]
    words = "centre of pin 1 in its socket (dashed: the clearance), its distance from the middle, and its spin"
    plates = _each(found, "fig9_pin_1", "Fig. 9", words, lambda one: pin_figure(one, _pin(one)))
    shown = pins_figure({_load(one): at_degrees(one) for one in found})
    words = "Pin 1 in its socket at crank angles of 0, 120, 240 and 360 deg; ways magnified, turns not."
    plates = (Plate("fig9a_pin_1_turned", "Fig. 9(a)", words, shown), *plates)
    note = "The paper: pin 1 sways within its clearance and turns; the nonpin design has no such part."
    design = designs()[0]
    starts, rated = idle_motions(plan, runs, design), _rated(found, design)
    varied = {
        one: [settled(run) for run in runs(varied_idle_runs(plan, one, design))]
        for one in variations(plan)
        if one.of(Reducer(design)).ring.has_moving_pins
    }
    claims = [judged(starts, rated, varied, ranges(plan)) for judged in (_sway, _spin, _turns, _slides)]
    return Found(plates, claims=tuple(claims), notes=(note,))


def _plates(
    found: Sequence[Series], name: str, figure: str, words: str, draw: Callable[[Sequence[Series]], Any]
) -> tuple[Plate, ...]:
    """Draw the runs of each load together, at the paper's sampling."""
    loads: dict[str, list[Series]] = {}
    for one in found:
        loads.setdefault(_load(one), []).append(at_degrees(one))
    return tuple(
        Plate(
            f"{name}_{'loaded' if each[0].design.load.torque else 'unloaded'}", figure, f"{load}: {words}.", draw(each)
        )
        for load, each in loads.items()
    )


def _each(
    found: Sequence[Series], name: str, figure: str, words: str, draw: Callable[[Series], Any]
) -> tuple[Plate, ...]:
    """Draw each run by itself at the paper's sampling."""
    return tuple(
        Plate(f"{name}_{_key(one)}", figure, f"{one.design.name}, {_load(one)}: {words}.", draw(at_degrees(one)))
        for one in found
    )


def at_degrees(motion: Series) -> Series:
    """Give a run at one sample for each degree, the paper's sampling."""
    return series(motion.run.select(slice(None, None, LOGGED)), motion.q, settling(Reducer(motion.design)))


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


def _sway(starts: Sequence[Series], rated: Series, varied: Varied, searched: Sequence[Range]) -> Claim:
    """Judge whether pin 1 moves about in its clearance, and does not leave it but by the give of the contact."""

    def holds(motions: Sequence[Series]) -> Verdict:
        return share_verdict(
            _span(one) > SWAYS * clearance and _reach(one) <= (1.0 + GIVE) * clearance for one in motions
        )

    clearance = _pin(starts[0]).clearance
    reach = Spread.of(_reach(one) for one in starts)
    span = Spread.of(_span(one) for one in starts)
    return statements.pin_1_sway(clearance).judged(
        found=Value(
            f"{_um(span)} um across, {_um(reach)} um from the middle; clearance {1e6 * clearance:g} um",
            1e3 * reach.mean,
            "mm",
            (1e3 * reach.low, 1e3 * reach.high),
        ),
        error=Value(f"spread of {len(starts)} starts", 1e6 * reach.half, "um"),
        verdict=_searched(holds(starts), [holds(found) for one, found in varied.items() if one.parameter in LEFT_OPEN]),
        decided_by=_decided(holds, starts, varied),
        searched=searched,
        removals=_removals(varied, holds, lambda found: f"{_um(Spread.of(map(_reach, found)))} um from the middle"),
        rated=Value(
            f"{1e6 * _span(rated):.3g} um across, {1e6 * _reach(rated):.3g} um from the middle, by the give of the "
            "socket",
            1e3 * _reach(rated),
            "mm",
        ),
    )


def _spin(starts: Sequence[Series], rated: Series, varied: Varied, searched: Sequence[Range]) -> Claim:
    """Judge whether pin 1 turns on: whether its mean spin has one sign in all starts."""

    def holds(motions: Sequence[Series]) -> Verdict:
        spins = Spread.of(mean_spin(one) for one in motions)
        return Verdict.AGREES if spins.low > 0.0 or spins.high < 0.0 else Verdict.NOT_DETERMINED

    means = Spread.of(mean_spin(one) for one in starts)
    rocking = Spread.of(float(np.sqrt(np.mean(_spins(one) ** 2))) for one in starts)
    return statements.PIN_1_SPIN.judged(
        found=spread_value(f"mean {means.words} rad/s, rms {rocking.words} rad/s", means, "rad/s"),
        error=spread_error(means, "rad/s"),
        verdict=holds(starts),
        decided_by=_decided(holds, starts, varied),
        searched=searched,
        removals=_removals(varied, holds, lambda found: f"mean {Spread.of(map(mean_spin, found)).words} rad/s"),
        rated=Value(
            f"mean {mean_spin(rated):.3g} rad/s, which the creep speed of the friction law alone sets (a factor of 5 "
            "between 20 and 1 mm/s): not determined",
            mean_spin(rated),
            "rad/s",
        ),
    )


def _turns(starts: Sequence[Series], rated: Series, varied: Varied, searched: Sequence[Range]) -> Claim:
    """Judge whether pin 1 is seen turned at the crank angles of Fig. 9(a)."""

    def holds(motions: Sequence[Series]) -> Verdict:
        return share_verdict(bool(np.ptp(_turned(one)) >= SEEN_TURN) for one in motions)

    turned = [_turned(one) for one in starts]
    widest = Spread.of(float(np.ptp(one)) for one in turned)
    first = ", ".join(f"{angle:.2g}" for angle in turned[0])
    return statements.PIN_1_TURNS.judged(
        found=spread_value(f"{first} deg in the first start; {widest.words} deg between them", widest, "deg"),
        error=spread_error(widest, "deg"),
        verdict=_searched(holds(starts), [holds(found) for one, found in varied.items() if one.parameter in LEFT_OPEN]),
        decided_by=_decided(holds, starts, varied),
        rated=Value(", ".join(f"{angle:.3g}" for angle in _turned(rated)) + " deg"),
        searched=searched,
        removals=_removals(
            varied, holds, lambda found: f"{Spread.of(float(np.ptp(_turned(one))) for one in found).words} deg"
        ),
    )


def _slides(starts: Sequence[Series], rated: Series, varied: Varied, searched: Sequence[Range]) -> Claim:
    """Judge whether pin 1 slides on the gear away from crank angle 0: one that rolls would turn as the gear passes."""

    def holds(motions: Sequence[Series]) -> Verdict:
        return share_verdict(_rolling(one) < ROLLS for one in motions)

    shares = Spread.of(map(_rolling, starts))
    return statements.PIN_1_SLIDES.judged(
        found=spread_value(
            f"its surface goes along with {100 * shares.low:.2g} to {100 * shares.high:.2g} % of the gear's",
            shares,
            "1",
        ),
        error=spread_error(shares, "1"),
        verdict=_searched(holds(starts), [holds(found) for one, found in varied.items() if one.parameter in LEFT_OPEN]),
        decided_by=_decided(holds, starts, varied),
        rated=Value(f"{100 * _rolling(rated):.3g} %", _rolling(rated), "1"),
        searched=searched,
        removals=_removals(
            varied, holds, lambda found: f"{100 * Spread.of(map(_rolling, found)).high:.2g} % of the gear's at most"
        ),
    )


def _strays(name: str, starts: Sequence[Series], rated: Series) -> Claim:
    """Judge whether the gear has a transmission error, in every start."""
    sizes = Spread.of(judge(one).gear_transmission_error.peak_to_peak_arcsec for one in starts)
    under = judge(rated).gear_transmission_error.peak_to_peak_arcsec
    return statements.transmission_error(name).judged(
        found=spread_value(f"{sizes.words} arcsec peak to peak", sizes, "arcsec"),
        error=spread_error(sizes, "arcsec"),
        verdict=share_verdict(size >= SEEN_ERROR for size in sizes.values),
        decided_by="the clearances: within them an idle gear floats",
        rated=Value(f"{under:.3g} arcsec", under, "arcsec"),
    )


def _searched(own: Verdict, others: Sequence[Verdict]) -> Verdict:
    """Let a claim depend that fails here, and holds with something that the paper leaves open."""
    return Verdict.DEPENDS if own == Verdict.DISAGREES and Verdict.AGREES in others else own


def _decided(holds: Callable[[Sequence[Series]], Verdict], starts: Sequence[Series], varied: Varied) -> str:
    """Tell what of all that is varied alone changes a verdict."""
    own = holds(starts)
    others = [f"{one.words} ({verdict})" for one, found in varied.items() if (verdict := holds(found)) != own]
    return ", ".join(others) or "nothing that was varied alone changes it"


def _removals(
    varied: Varied, holds: Callable[[Sequence[Series]], Verdict], words: Callable[[Sequence[Series]], str]
) -> list[Removal]:
    return [Removal(one.words, words(found), holds(found)) for one, found in varied.items()]


def _turned(motion: Series) -> Array:
    """Give how far pin 1 has turned since the turn began, at the crank angles of Fig. 9(a) [deg], shape (4,)."""
    rows = motion.one_turn
    crank = np.abs(np.degrees(motion.crank_angle[rows]))
    angle = np.degrees(motion.run["pin_1_angle"][rows])
    shown = np.interp(crank[0] + np.array(SHOWN), crank, angle)
    return np.asarray(shown - angle[0])


def _rolling(motion: Series) -> float:
    """Give the speed of pin 1's surface as a share of the gear's where that passes, from 10 to 350 deg [1].

    Where gear and pin touch, the gear's speed is along both. The crank angle is counted from gravity's direction in the
    first start, where pin 1 is at 0 deg.
    """
    gear, rows = motion.design.gear, motion.whole_periods
    crank = motion.crank_angle[rows]
    away = np.abs((np.degrees(crank) + 180.0) % 360.0 - 180.0) >= PIN_1_LOADED[1]
    centre = gear.eccentricity * np.stack([-np.sin(crank), np.cos(crank)], axis=1)
    arm = np.array([0.0, motion.design.ring.pin_circle_radius]) - centre
    speed, spin = motion.design.drive.speed, motion.gear_speed.theory[rows]
    passing = speed * np.stack([-centre[:, 1], centre[:, 0]], axis=1)
    passing += spin[:, np.newaxis] * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
    surface = motion.design.ring.pin_radius * np.abs(_spins(motion))
    return float(np.mean(surface[away]) / np.mean(np.linalg.norm(passing[away], axis=1)))


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
