"""Claims on the course of stress over a crank turn without load: shaft, output, pin 1 (Figs 12, 15, 16)."""

from collections.abc import Sequence
from statistics import median

import numpy as np

from cycloid_mj.base.names import OUTPUT
from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Claim, Range, Removal, Value, Verdict
from cycloid_mj.comparison import StartSpread, Variation, settle_run
from hsieh2014 import verdicts
from hsieh2014.cycle import cycle
from hsieh2014.idle_stress import IdleStress, rated_value, stress_error
from hsieh2014.over_starts import OverStarts, ruling
from hsieh2014.peaks import PIN_1, largest_of_halves, likeness, share_near
from hsieh2014.plan import LEFT_OPEN
from hsieh2014.stated import NEAR, ORDER, PIN_1_LOADED, SHAFT_PEAKS
from hsieh2014.statements import PIN_1_CYCLE, stress_of_output, stress_peaks
from hsieh2014.stress_evidence import Evidence

REGULAR = 0.5
"""Smallest correlation of each start's curve with the mean of the others for a regular curve (heuristic)."""

MOSTLY = 0.5
"""Smallest share of pin 1's load near crank angle 0 for a pin that is loaded there (heuristic)."""

OF_THE_PEAKS = "share of the turn's peaks"

OUTPUT_RANGES = (
    Range("output.pin_radius_mm", 4.0, 5.0, "mm", "as assumed, to holes that leave the gear's web as wide as they are"),
    Range("output.support", 0.0, 1.0, "cantilever or both_ends", "one disc, or a second one beyond the gear"),
)
"""What the paper leaves open of the output pins, with the searched ranges."""


def shaft_peaks(idle_stress: IdleStress, evidence: Evidence, ranges: Sequence[Range]) -> Claim:
    """Judge whether the shaft has the paper's two stress peaks per turn, from the peaks of the cam's force.

    `idle_stress` has the stress of the pin design, `evidence` the forces of all runs; `ranges` were searched.
    """
    curves = [forces["shaft"] for forces in evidence.forces["pin"]]
    each = [largest_of_halves(curve) for curve in curves]
    others = {
        changed: [largest_of_halves(forces["shaft"]) for forces in varied["pin"]]
        for changed, varied in evidence.varied.items()
    }
    verdict = verdicts.majority_verdict(_near_the_papers(each))
    # some starts are enough to say that the paper's angles can come out
    near = [changed for changed, angles in others.items() if any(_near_the_papers(angles))]
    changes, stated_changes = (
        [each.words for each in near if (each.parameter in LEFT_OPEN) == is_open] for is_open in (True, False)
    )
    verdict = Verdict.DEPENDS if changes and verdict == Verdict.DISAGREES else verdict
    deciding = [f"omitted by the paper: {', '.join(changes)}"] if changes else []
    deciding += [f"stated by the paper: {', '.join(stated_changes)}"] if stated_changes else []
    mean = largest_of_halves(np.mean(curves, axis=0))
    angles = [StartSpread.of(angles) for angles in zip(*each, strict=True)]
    return stress_peaks("pin").judge(
        ours=Value(
            f"the cam's force peaks at {angles[0].words} and {angles[1].words} deg; its mean over the starts at "
            f"{mean[0]:g} and {mean[1]:g} deg",
            mean[0],
            "deg",
            (angles[0].low, angles[0].high),
        ),
        error=verdicts.spread_error(angles[0], "deg"),
        verdict=verdict,
        decided_by="; ".join(deciding) or "nothing varied gives the paper's angles",
        searched=ranges,
        removals=[
            Removal(changed.words, angles_in_words(angles), verdicts.majority_verdict(_near_the_papers(angles)))
            for changed, angles in others.items()
        ],
        p=verdicts.sign_test_p(_near_the_papers(each)),
        rated=Value(
            f"{idle_stress.rated['shaft'].words} MPa over the turn: "
            "in the frame of the shaft, the cam force is almost constant"
        ),
    )


def _near_the_papers(pairs: Sequence[tuple[float, float]]) -> list[bool]:
    """Return for each start whether both of its peaks are near the paper's."""
    return [all(abs(angle - wanted) <= NEAR for angle, wanted in zip(pair, SHAFT_PEAKS, strict=True)) for pair in pairs]


def angles_in_words(pairs: Sequence[tuple[float, float]]) -> str:
    """Return in words the range and median of the peaks, and how many starts have both near the paper's."""
    first, second = (StartSpread.of(angles) for angles in zip(*pairs, strict=True))
    near = sum(_near_the_papers(pairs))
    return (
        f"{first.words} and {second.words} deg, in the median {median(first.values):g} and "
        f"{median(second.values):g}; {near} of {len(pairs)} starts near the paper's"
    )


def output(design: str, evidence: Evidence, ranges: Sequence[Range]) -> Claim:
    """Judge whether the output's stress is lower than that of the other parts, and similar in every start.

    `evidence` has the stress and the forces of all runs; `ranges` were searched.
    """
    each, ours = evidence.stress[design], evidence.peaks(design, OUTPUT)

    def regular(changed: Variation | None) -> verdicts.Part:
        alike = [each >= REGULAR for each in likeness(evidence.curves(design, OUTPUT, changed))]
        return verdicts.majority_verdict(alike), verdicts.sign_test_p(alike)

    def others(changed: Variation | None) -> StartSpread:
        sizes = [evidence.peaks(design, part, changed).values for part in ORDER]
        return StartSpread.of(max(each) for each in zip(*sizes, strict=True))

    def low(sizes: StartSpread, changed: Variation | None) -> verdicts.Part:
        return verdicts.order_verdict(verdicts.rank_order(others(changed), sizes), {})[0], verdicts.chance(
            others(changed), sizes
        )

    def words(sizes: StartSpread, changed: Variation | None) -> str:
        alike = StartSpread.of(likeness(evidence.curves(design, OUTPUT, changed)))
        return (
            f"{sizes.words} MPa, the most stressed other part {others(changed).words} MPa; its force over the turn "
            f"correlates between starts by {alike.words}"
        )

    def removal(what: str, sizes: StartSpread, changed: Variation | None) -> Removal:
        return Removal(what, words(sizes, changed), verdicts.jointly([low(sizes, changed), regular(changed)])[0])

    verdict, p = verdicts.jointly([low(ours, None), regular(None)])
    of_pins = [removal(what, sizes, None) for what, sizes in each.outputs.items()]
    of_runs = {each: removal(each.words, evidence.peaks(design, OUTPUT, each), each) for each in evidence.varied}
    left_open = [*of_pins, *(removal for each, removal in of_runs.items() if each.parameter in LEFT_OPEN)]
    agreeing = [each.what for each in left_open if each.verdict == Verdict.AGREES]
    return stress_of_output(design).judge(
        ours=verdicts.spread_value(words(ours, None), ours, "MPa"),
        error=stress_error(each, [OUTPUT]),
        verdict=Verdict.DEPENDS if agreeing and verdict == Verdict.DISAGREES else verdict,
        decided_by=f"omitted by the paper: {', '.join(agreeing)}"
        if agreeing
        else "no variation leads to the claimed result",
        rated=rated_value(each, OUTPUT),
        searched=(*ranges, *OUTPUT_RANGES),
        removals=[*of_pins, *of_runs.values()],
        p=p,
    )


def pin_1_cycle(evidence: Evidence, rated: Run, ranges: Sequence[Range]) -> Claim:
    """Judge whether pin 1 is loaded only from 350 to 10 deg; also report lobe 1 of the nonpin design.

    `evidence` has the forces of all runs, `rated` is the run under the rated load; `ranges` were searched.
    """
    reach = PIN_1_LOADED[1] + NEAR

    def shares(design: str, changed: Variation | None) -> StartSpread:
        return StartSpread.of(share_near(curve, reach) for curve in evidence.curves(design, PIN_1, changed))

    pin, lobe = shares("pin", None), shares("nonpin", None)
    begins, ends, turn, _ = cycle(settle_run(rated))
    judged = ruling(
        OverStarts(pin.values, {changed: shares("pin", changed).values for changed in evidence.varied}, tuple(ranges)),
        lambda share: share >= MOSTLY,
        lambda some: f"{_percent(StartSpread.of(some))} within {reach:g} deg of 0",
    )
    return PIN_1_CYCLE.judge(
        ours=verdicts.spread_value(
            f"{_percent(pin)} of the force's integral over a turn is within {reach:g} deg of 0, "
            f"which is 11 % of the turn; for lobe 1 without pins {_percent(lobe)}",
            pin,
            OF_THE_PEAKS,
        ),
        error=verdicts.spread_error(pin, OF_THE_PEAKS),
        searched=ranges,
        rated=Value(f"loaded from {begins:.0f} to {ends:.0f} deg, {turn:.0f} % of the turn"),
        **vars(judged),
    )


def _percent(shares: StartSpread) -> str:
    return f"{100 * shares.low:.0f} to {100 * shares.high:.0f} %"
