"""Fig. 19: the output torque at the rated input torque, and the friction that reproduces the paper's."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from cycloid_mj.analysis import Series
from cycloid_mj.base.engine import Progress as Steps
from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Claim, Range, Removal, Table, Value, Verdict
from cycloid_mj.base.units import ARCSECOND
from cycloid_mj.comparison import settle_run
from cycloid_mj.design import Design
from cycloid_mj.life.duty import DutyPoint
from cycloid_mj.life.emergency_stop import rate_emergency_stop
from cycloid_mj.life.loading import solve_loading
from cycloid_mj.measure import Measurement
from cycloid_mj.reducer import Reducer
from hsieh2014.lubrication import lubrication_table
from hsieh2014.pictures import pictures
from hsieh2014.plan import Plan, designs, equal_play_design, rated_runs
from hsieh2014.stage import PaperFigure, Progress, Runs, StageResult
from hsieh2014.stated import IDEAL, TORQUES, torques
from hsieh2014.statements import AHEAD, BY_DESIGN, CAPACITY, PRECISION, TORQUE_ORDER, output_torque
from hsieh2014.torque_search import GRID, RANGES, SEARCHED, Case, TorqueSearch, search

NEAR = 0.01
"""Torques agree within this share of the torque without losses."""
ERROR = "comparison with half the time step or half the averaging time"

TO_PIN = "of the internal gear, to that of both clearances of a pin"
PLAYS = (Range("total play of gear and housing", 1.0, 2.0, "um", TO_PIN),)
"""Searched ranges of play and stiffness for the claims on double lines of contact."""


def torque(plan: Plan, runs: Runs, progress: Progress) -> StageResult:
    """Measure the output torque of both designs, as `cycloid-mj measure torque` does."""
    from cycloid_mj.measure import torque as measure_torque
    from cycloid_mj.plots.measure import measurement_figure

    measurements = {
        design.name: measure_torque(design, plan.quick, _steps(progress, design.name), torques(design))
        for design in designs()
    }
    progress("search over what the paper leaves open")
    searches = {
        design.name: search(design, {torque.method: torque.rate for torque in torques(design)}) for design in designs()
    }
    progress(equal_play_design().name)
    alike = _at_equal_play(plan)
    plates = tuple(
        PaperFigure(
            f"fig19_torque_{name}",
            "Fig. 19",
            f"{name}: output torque at 1.048 N m on the crank, its ripple by order, and the output rate over friction. "
            "Marks: the paper's rates, if one friction coefficient of all contacts leads to them.",
            measurement_figure(measurement),
        )
        for name, measurement in measurements.items()
    )
    views, missing = pictures(runs(rated_runs(plan)[:2]))
    order = torque_order(measurements, searches)
    tables = [
        replace(table, title=f"{name}: {table.title}")
        for name, measurement in measurements.items()
        for table in measurement.tables
    ]
    return StageResult(
        (*views, *plates),
        (_torque_table(measurements, alike), _search_table(searches), lubrication_table(), *tables),
        (*claims(measurements, searches), order, precision(runs(rated_runs(plan))), capacity()),
        {
            name: {key: each.as_json() for key, each in measurement.quantities.items()}
            for name, measurement in measurements.items()
        }
        | {equal_play_design().name: {"output_torque_nm": alike}},
        (
            *dict.fromkeys(sentence for measurement in measurements.values() for sentence in measurement.assumptions),
            *missing,
        ),
    )


def _at_equal_play(plan: Plan) -> float:
    """Compute the output torque [N m] of the nonpin design with the pin design's total play and series stiffness."""
    from cycloid_mj.measure.conditions import STEADY
    from cycloid_mj.measure.steady import averaging_periods, steady_design
    from cycloid_mj.measure.torque import rated_test

    design = steady_design(Reducer(equal_play_design()))
    return rated_test(design, averaging_periods(design, STEADY.min_periods(plan.quick))).output


def _torque_table(measurements: Mapping[str, Measurement], alike: float) -> Table:
    """Return the table of output torques of pin, nonpin, and nonpin with the pin design's play and stiffness.

    `alike` is the output torque of the last [N m], which separates the effect of the design from clearance and
    compliance.
    """
    torques = {name: measurement["output_torque"] for name, measurement in measurements.items()} | {
        equal_play_design().name: alike
    }
    return Table(
        "output torque at equal friction, 1.048 N m on the crank; third: total play and series stiffness of pin",
        ("", *torques),
        (
            ("output torque [N m]", *(f"{torque:.2f}" for torque in torques.values())),
            ("output rate [%]", *(f"{100 * torque / IDEAL:.2f}" for torque in torques.values())),
        ),
    )


def _search_table(searches: Mapping[str, TorqueSearch]) -> Table:
    """Return the table of the output rate of both designs over the searched friction."""
    rows: list[tuple[str | float, ...]] = [
        (bearings.words, friction, *(100 * search.grid[bearings, friction] for search in searches.values()))
        for bearings in SEARCHED
        for friction in GRID
    ]
    head = ("cam, output pins, seals", "friction of the teeth", *(f"{name}, rate [%]" for name in searches))
    return Table("output rate over all friction that the paper leaves open", head, tuple(rows))


def _steps(progress: Progress, name: str) -> Steps:
    """Return a progress callback for the runs of a design."""
    return lambda done, of: progress(f"{name}, {done} of {of} runs")


def claims(measurements: Mapping[str, Measurement], searches: Mapping[str, TorqueSearch]) -> Iterator[Claim]:
    """Yield a claim on each output torque of the paper.

    It agrees within 1 % of the ideal torque. Otherwise it depends, if friction within the searched ranges reproduces
    it.
    """
    none = "nothing within the ranges searched gives it"
    for name, kinds in TORQUES.items():
        claim = measurements[name]
        ours, error = claim["output_torque"], claim.quantities["output_torque"].error
        for kind, paper in kinds.items():
            solutions = searches[name].solutions[kind]
            yield output_torque(kind, name).judge(
                ours=Value(f"{ours:.2f} N m, {100 * ours / IDEAL:.1f} %", ours, "N m"),
                error=Value(ERROR, error, "N m"),
                verdict=_verdict(ours, paper, bool(solutions)),
                decided_by=f"friction, omitted by the paper: {'; '.join(each.words for each in solutions) or none}",
                searched=RANGES,
                removals=[
                    Removal(f"our own friction, for {case}", f"{each.rate * IDEAL:.2f} N m", Verdict.AGREES)
                    for each in solutions
                    for case in [each.bearings.of_teeth(each.friction)]
                ]
                + [
                    Removal(what, f"{rate * IDEAL:.2f} N m, {100 * rate:.1f} %", _verdict(rate * IDEAL, paper, False))
                    for what, rate in searches[name].removed.items()
                ],
            )


def _verdict(ours: float, paper: float, reproduced: bool) -> Verdict:
    """Return the verdict on a torque [N m]; `reproduced` states whether something left open reproduces the paper's."""
    if abs(ours - paper) <= NEAR * IDEAL:
        return Verdict.AGREES
    return Verdict.DEPENDS if reproduced else Verdict.DISAGREES


def torque_order(measurements: Mapping[str, Measurement], searches: Mapping[str, TorqueSearch]) -> Claim:
    """Judge which design has more output torque: as designed, at any equal friction, and at separate frictions."""
    ours = {name: measurement["output_torque"] for name, measurement in measurements.items()}
    error = sum(measurement.quantities["output_torque"].error or 0.0 for measurement in measurements.values())
    ahead = ours["nonpin"] - ours["pin"]
    grids = searches["pin"].grid, searches["nonpin"].grid
    alike = {case: IDEAL * (grids[1][case] - grids[0][case]) for case in grids[0]}
    best, least = max(alike, key=lambda case: alike[case]), min(alike, key=lambda case: alike[case])
    own = [searches[name].solutions["simulated"] for name in ("pin", "nonpin")]
    removals = [
        Removal(_case_words(case), f"{alike[case]:+.2f} N m", _ahead(alike[case], error)) for case in (best, least)
    ]
    if all(own):
        words = f"pin: {own[0][-1].words}; nonpin: {own[1][-1].words}"
        gained = IDEAL * (own[1][-1].rate - own[0][-1].rate)
        removals.append(Removal(f"equal friction, for {words}", f"{gained:+.2f} N m", _ahead(gained, error)))
    return TORQUE_ORDER.judge(
        ours=Value(f"nonpin {ours['nonpin']:.2f}, pin {ours['pin']:.2f} N m", ahead, AHEAD),
        error=Value(ERROR, error, AHEAD),
        verdict=order_of_torques(ahead, error, any(removal.verdict == Verdict.AGREES for removal in removals)),
        decided_by="friction, omitted by the paper: at equal friction the nonpin design is ahead by "
        f"{alike[least]:+.2f} ({_case_words(least)}) to {alike[best]:+.2f} N m ({_case_words(best)})",
        searched=RANGES,
        removals=removals,
    )


def precision(rated: Sequence[Run]) -> Claim:
    """Judge whether the nonpin design has the smaller transmission error of the output under the rated load.

    `rated` are the runs of pin, nonpin, and nonpin with the pin design's play.
    """
    strays = {run.provenance["design"]: _transmission_error(settle_run(run)) for run in rated}
    (pin, nonpin, alike), errors = zip(*strays.values(), strict=True)
    sizes = ", ".join(f"{name} {size:.2g}" for name, (size, _) in strays.items())
    return PRECISION.judge(
        ours=Value(f"{sizes} arcsec peak to peak", nonpin / pin, BY_DESIGN),
        error=Value("comparison with half the turns of each run", max(errors) / pin, BY_DESIGN),
        verdict=Verdict.AGREES if nonpin < pin else Verdict.DISAGREES,
        decided_by="play and stiffness between disc and housing"
        if alike > 0.5 * (pin + nonpin)
        else "the lines themselves: with the pin design's play and stiffness the nonpin design stays ahead",
        searched=PLAYS,
        removals=[_at_equal_fit(f"{alike:.2g} to {pin:.2g} arcsec", alike < pin)],
    )


def _at_equal_fit(words: str, better: bool) -> Removal:
    """Judge whether the nonpin design is still better with the pin design's play and stiffness."""
    what = "the nonpin design's smaller play and stiffer contacts"
    return Removal(what, words, Verdict.AGREES if better else Verdict.DISAGREES)


def _transmission_error(motion: Series) -> tuple[float, float]:
    """Return the output's transmission error, peak to peak, and the difference of its halves [arcsec]."""
    error = motion.output_angle.error[motion.hold] / ARCSECOND
    whole, half = float(np.ptp(error)), len(error) // 2
    return whole, max(whole - float(np.ptp(part)) for part in (error[:half], error[half:]))


def capacity() -> Claim:
    """Judge whether the teeth of the nonpin design reach first yield at a larger torque, by statics."""
    pin, nonpin, alike = (_first_yield(design) for design in (*designs(), equal_play_design()))
    return CAPACITY.judge(
        ours=Value(
            f"first yield at {nonpin:.3g} N m without pins, at {pin:.3g} N m with pins", nonpin / pin, BY_DESIGN
        ),
        error=Value("static model", 0.0, BY_DESIGN),
        verdict=Verdict.AGREES if nonpin > pin else Verdict.DISAGREES,
        decided_by="number of contact lines that carry load, and how closely the surfaces fit",
        searched=PLAYS,
        removals=[_at_equal_fit(f"{alike:.3g} to {pin:.3g} N m", alike > pin)],
    )


def _first_yield(design: Design) -> float:
    """Compute the torque on the output [N m] at which the first contact yields."""
    reducer = Reducer(design)
    point = DutyPoint(torque=design.rated_torque, speed=design.drive.speed, share=1.0)
    items = rate_emergency_stop(reducer, design.rated_torque, solve_loading(reducer, point))
    return next(item.limit for item in items if item.key == "peak_yield")


def _case_words(case: Case) -> str:
    bearings, friction = case
    return f"{bearings.of_teeth(friction)} in both" if friction is not None else bearings.words


def _ahead(ahead: float, error: float) -> Verdict:
    if ahead > error:
        return Verdict.AGREES
    return Verdict.DISAGREES if ahead < -error else Verdict.NOT_DETERMINED


def order_of_torques(ahead: float, error: float, reproduced: bool) -> Verdict:
    """Return the verdict on the order from the nonpin design's excess torque [N m], its error, and the search."""
    verdict = _ahead(ahead, error)
    return Verdict.DEPENDS if verdict != Verdict.AGREES and reproduced else verdict
