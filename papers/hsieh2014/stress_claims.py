"""Claims on stress, judged by numbers at no load over independent starts: heights, orders and patterns (Figs 12-16)."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from cycloid_mj.analysis.series import design_of
from cycloid_mj.base.names import OUTPUT
from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Claim, Range, Removal, Value, Verdict
from cycloid_mj.base.types import Array
from cycloid_mj.comparison import Spread, Variation, settled
from hsieh2014.cycle import cycle
from hsieh2014.idle_stress import IdleStress
from hsieh2014.peaks import (
    by_angle,
    curves_by_angle,
    largest_of_halves,
    likeness,
    pairs_on,
    share_near,
    standing_for_pin_1,
)
from hsieh2014.plan import CONTACT_RANGES, LEFT_OPEN
from hsieh2014.stated import HEIGHTS, LEAST, MOST, NEAR, ORDER, PIN_1_LOADED, SHAFT_PEAKS
from hsieh2014.statements import (
    BY_DESIGN,
    PIN_1_CYCLE,
    Statement,
    stress_fluctuation,
    stress_height,
    stress_mean,
    stress_of_designs,
    stress_of_output,
    stress_of_parts,
    stress_peaks,
)
from hsieh2014.verdicts import (
    chance,
    joint_verdict,
    order_verdict,
    range_verdict,
    rank_order,
    share_verdict,
    spread_error,
    spread_value,
)

REGULAR = 0.5
"""A curve counts as regular if each start's correlates by this with the mean of the others."""

MOSTLY = 0.5
"""Pin 1 is loaded about crank angle 0 if this share of what presses it over a turn falls there."""

ERROR = "one more refinement, or where bulk begins"
TREATMENT = (
    "the treatment of contact: the paper states no stiffness, damping or mesh of its motion solver; see the hypothesis"
)
OF_THE_PEAKS = "share of the turn's peaks"


Forces = Mapping[str, Sequence[Mapping[str, Array]]]
"""Design name -> start by start, part -> the largest force on it in each part of a crank turn [N]."""


@dataclass(frozen=True, eq=False)
class Searched:
    """What the claims on stress were searched over.

    Attributes
    ----------
    ranges
        Of what the paper leaves open.
    varied
        What was changed alone -> design name -> its idle runs.
    reached
        Part and design -> treatment of contact -> the stress [MPa] that its forces make.
    """

    ranges: tuple[Range, ...] = ()
    varied: Mapping[Variation, Mapping[str, Sequence[Run]]] = field(default_factory=dict)
    reached: Mapping[tuple[str, str], Mapping[str, float]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Evidence:
    """Stress of both designs with the forces of all runs: a stress goes with the largest force on its part."""

    stress: Mapping[str, IdleStress]
    forces: Forces
    varied: Mapping[Variation, Forces]

    def sizes(self, design: str, part: str, of: Callable[[Array], float], changed: Variation | None = None) -> Spread:
        """Give the stress [MPa] of a design's part that a property `of` the force's curve makes, start by start."""
        largest = float(np.mean([one[part].max() for one in self.forces[design]]))
        base = self.stress[design].starts[part].mean / largest if largest else 0.0
        runs = self.forces[design] if changed is None else self.varied[changed][design]
        return Spread.of(base * of(one[part]) for one in runs)


def forces_of(runs: Mapping[str, Sequence[Run]]) -> Forces:
    """Give the force on the shaft, the ring and the gear over a crank turn, in every run."""
    return {
        name: [curves_by_angle(run, {part: pairs_on(run, part) for part in ORDER}) for run in each]
        for name, each in runs.items()
    }


def stress_claims(
    found: Mapping[str, IdleStress],
    starts: Mapping[str, Sequence[Run]],
    rated: Mapping[str, Run],
    searched: Searched | None = None,
) -> Iterator[Claim]:
    """Judge every claim on stress.

    Parameters
    ----------
    found
        Design name -> its stress.
    starts, rated
        Design name -> its runs at no load, and its run under the rated load.
    searched
        What else was tried.
    """
    searched = searched or Searched()
    evidence = Evidence(found, forces_of(starts), {one: forces_of(runs) for one, runs in searched.varied.items()})
    for name, one in found.items():
        for part in ORDER:
            yield height(name, part, one, evidence, searched)
        yield parts_in_order(name, one)
        if name == "pin":
            yield shaft_peaks(one, evidence, searched.ranges)
        yield output(name, one, starts[name])
        if name == "pin":
            yield pin_1_cycle(starts[name], starts["nonpin"], rated[name])
    for part in ORDER:
        yield designs_in_order(part, evidence, searched.ranges)
        yield smaller(stress_mean(part), part, np.mean, evidence, searched.ranges)
        yield smaller(stress_fluctuation(part), part, np.std, evidence, searched.ranges)


def height(design: str, part: str, one: IdleStress, evidence: Evidence, searched: Searched) -> Claim:
    """Judge how high the curve of a part reaches: ours, and by every treatment of contact that was searched.

    Forces grow without a jump with stiffness and chord error: a height between two that are reached is reached.
    """
    theirs, ours = HEIGHTS[part, design], one.starts[part]
    low, high = LEAST * theirs, MOST * theirs
    cases = {each.words: evidence.sizes(design, part, np.max, each) for each in evidence.varied}
    cases |= {words: Spread((size,)) for words, size in searched.reached.get((part, design), {}).items()}
    verdict, sizes = range_verdict(ours, low, high), [*cases.values(), ours]
    if (
        verdict == Verdict.DISAGREES
        and min(each.low for each in sizes) <= high <= max(each.high for each in sizes) / LEAST
    ):
        verdict = Verdict.DEPENDS
    highest = max(cases, key=lambda words: cases[words].high, default="")
    return stress_height(part, design).judged(
        found=spread_value(f"{ours.words} MPa at impact peaks, 1/{theirs / ours.mean:.0f} of that", ours, "MPa"),
        error=_error(one, [part]),
        verdict=verdict,
        decided_by=TREATMENT + (f"; {highest}: {cases[highest].high:.3g} MPa" if highest else ""),
        rated=_rated(one, part),
        searched=(*searched.ranges, *CONTACT_RANGES),
        removals=[Removal(words, f"{_of(size)} MPa", range_verdict(size, low, high)) for words, size in cases.items()],
    )


def smaller(
    statement: Statement, part: str, of: Callable[[Array], float], evidence: Evidence, ranges: Sequence[Range]
) -> Claim:
    """Judge whether a part's stress is less without pins: a property `of` its curve over a turn."""

    def sizes(changed: Variation | None) -> tuple[Spread, Spread]:
        pin, nonpin = (evidence.sizes(name, part, of, changed) for name in ("pin", "nonpin"))
        return pin, nonpin

    pin, nonpin = sizes(None)
    ratio = nonpin.over(pin)
    varied = {each: sizes(each) for each in evidence.varied}
    turned = {each.words: rank_order(*both) for each, both in varied.items() if each.parameter in LEFT_OPEN}
    verdict, by = order_verdict(rank_order(pin, nonpin), turned)
    return statement.judged(
        found=Value(
            f"{nonpin.words} against {pin.words} MPa, {ratio.values[0]:.2g} to 1, p = {chance(pin, nonpin):.2g}",
            ratio.values[0],
            BY_DESIGN,
            (ratio.low, ratio.high),
        ),
        error=Value(f"spread of {len(pin.values)} starts", ratio.half, BY_DESIGN),
        verdict=verdict,
        decided_by=f"left open by the paper: {', '.join(by)}"
        if by
        else "how hard the gear strikes; nothing varied turns it",
        searched=ranges,
        removals=_orders(varied),
        p=chance(pin, nonpin),
    )


def _orders(varied: Mapping[Variation, tuple[Spread, Spread]]) -> list[Removal]:
    """Judge the order of pin and nonpin with each thing changed alone."""
    return [
        Removal(
            each.words,
            f"{nonpin.words} without pins, {pin.words} MPa with them, p = {chance(pin, nonpin):.2g}",
            order_verdict(rank_order(pin, nonpin), {})[0],
        )
        for each, (pin, nonpin) in varied.items()
    ]


def _of(size: Spread) -> str:
    return size.words if len(size.values) > 1 else f"{size.mean:.3g}"


def parts_in_order(design: str, one: IdleStress) -> Claim:
    """Judge which part is stressed most, and which least."""
    spreads = [one.starts[part] for part in ORDER]
    words = ", ".join(f"{part} {size.words}" for part, size in zip(ORDER, spreads, strict=True))
    return stress_of_parts(design).judged(
        found=Value(f"{words} MPa"),
        error=_error(one, ORDER),
        verdict=joint_verdict(order_verdict(rank_order(*pair), {})[0] for pair in pairwise(spreads)),
        decided_by="the parts' assumed dimensions, and where bulk stress begins",
        rated=Value(", ".join(f"{part} {one.rated[part].high:.3g}" for part in ORDER) + " MPa"),
    )


def designs_in_order(part: str, evidence: Evidence, ranges: Sequence[Range]) -> Claim:
    """Judge whether a part is stressed less without pins."""
    pin, nonpin = (evidence.stress[name] for name in ("pin", "nonpin"))
    ours = (pin.starts[part], nonpin.starts[part])
    varied = {
        each: (evidence.sizes("pin", part, np.max, each), evidence.sizes("nonpin", part, np.max, each))
        for each in evidence.varied
    }
    turned = {each.words: rank_order(*both) for each, both in varied.items() if each.parameter in LEFT_OPEN}
    verdict, by = order_verdict(rank_order(*ours), turned)
    ratio = ours[1].over(ours[0])
    mean = ratio.values[0]
    rated = nonpin.rated[part].high / pin.rated[part].high
    return stress_of_designs(part).judged(
        found=Value(
            f"{ours[1].words} against {ours[0].words} MPa, {mean:.2g} to 1, p = {chance(*ours):.2g}",
            mean,
            BY_DESIGN,
            (ratio.low, ratio.high),
        ),
        error=Value(ERROR, mean * max(pin.error(part), nonpin.error(part)), BY_DESIGN),
        verdict=verdict,
        decided_by=f"left open by the paper: {', '.join(by)}"
        if by
        else "how hard the gear strikes; nothing varied turns it",
        searched=ranges,
        removals=_orders(varied),
        p=chance(*ours),
        rated=Value(
            f"{nonpin.rated[part].high:.3g} against {pin.rated[part].high:.3g} MPa, {rated:.2g} to 1",
            rated,
            BY_DESIGN,
        ),
    )


def shaft_peaks(one: IdleStress, evidence: Evidence, ranges: Sequence[Range]) -> Claim:
    """Judge where the shaft's two peaks a turn are: those of the cam's force, which alone loads it."""
    curves = [forces["shaft"] for forces in evidence.forces["pin"]]
    each = [largest_of_halves(curve) for curve in curves]
    others = {
        changed: [largest_of_halves(forces["shaft"]) for forces in varied["pin"]]
        for changed, varied in evidence.varied.items()
    }
    verdict = _near_the_papers(each)
    # some starts are enough to say that the paper's angles can come out
    by = [changed.words for changed, angles in others.items() if _near_the_papers(angles) != Verdict.DISAGREES]
    verdict = Verdict.DEPENDS if by and verdict == Verdict.DISAGREES else verdict
    mean = largest_of_halves(np.mean(curves, axis=0))
    at = [Spread.of(angles) for angles in zip(*each, strict=True)]
    return stress_peaks("pin").judged(
        found=Value(
            f"the cam's force peaks at {at[0].words} and {at[1].words} deg; over all starts at {mean[0]:g} and "
            f"{mean[1]:g} deg",
            mean[0],
            "deg",
            (at[0].low, at[0].high),
        ),
        error=spread_error(at[0], "deg"),
        verdict=verdict,
        decided_by=f"left open by the paper: {', '.join(by)}"
        if by
        else "gravity; nothing varied gives the paper's angles",
        searched=ranges,
        removals=[
            Removal(changed.words, _angles(angles), _near_the_papers(angles)) for changed, angles in others.items()
        ],
        rated=Value(f"{one.rated['shaft'].words} MPa over the turn, in whose frame the cam's force all but stands"),
    )


def _near_the_papers(pairs: Sequence[tuple[float, float]]) -> Verdict:
    return share_verdict(
        all(abs(angle - wanted) <= NEAR for angle, wanted in zip(pair, SHAFT_PEAKS, strict=True)) for pair in pairs
    )


def _angles(pairs: Sequence[tuple[float, float]]) -> str:
    first, second = (Spread.of(angles) for angles in zip(*pairs, strict=True))
    return f"{first.words} and {second.words} deg"


def output(design: str, one: IdleStress, starts: Sequence[Run]) -> Claim:
    """Judge whether the output is stressed less than the most stressed other part, and alike in every start."""
    pins = range(1, design_of(starts[0]).output.pins + 1)
    alike = likeness([by_angle(run, [f"output_pin_{number}" for number in pins]) for run in starts])
    others = Spread.of(max(sizes) for sizes in zip(*(one.starts[part].values for part in ORDER), strict=True))
    ours = one.starts["output"]
    low, _ = order_verdict(rank_order(others, ours), {})
    return stress_of_output(design).judged(
        found=spread_value(
            f"{ours.words} MPa, the most stressed other part {others.words} MPa; its force over the turn correlates "
            f"between starts by {Spread.of(alike).words}",
            ours,
            "MPa",
        ),
        error=_error(one, ["output"]),
        verdict=joint_verdict([low, share_verdict(each >= REGULAR for each in alike)]),
        decided_by="the output pins' assumed dimensions (low); chaos (regular)",
        rated=_rated(one, "output"),
    )


def pin_1_cycle(starts: Sequence[Run], nonpin: Sequence[Run], rated: Run) -> Claim:
    """Judge whether pin 1 is loaded from 350 to 10 deg alone; lobe 1 of the nonpin design stands beside."""
    reach = PIN_1_LOADED[1] + NEAR
    shares, of_lobe = (
        Spread.of(share_near(by_angle(run, [f"{stem}_{standing_for_pin_1(design_of(run))}"]), reach) for run in each)
        for stem, each in (("pin", starts), ("lobe", nonpin))
    )
    begins, ends, turn, _ = cycle(settled(rated))
    return PIN_1_CYCLE.judged(
        found=spread_value(
            f"of what presses it over a turn, {100 * shares.low:.0f} to {100 * shares.high:.0f} % comes within "
            f"{reach:g} deg of 0, a ninth of the turn; of lobe 1 without pins {100 * of_lobe.low:.0f} to "
            f"{100 * of_lobe.high:.0f} %",
            shares,
            OF_THE_PEAKS,
        ),
        error=spread_error(shares, OF_THE_PEAKS),
        verdict=share_verdict(share >= MOSTLY for share in shares.values),
        decided_by="the clearance: at no load the gear floats, and touches the pins that it is farthest out at",
        rated=Value(f"loaded from {begins:.0f} to {ends:.0f} deg, {turn:.0f} % of the turn"),
    )


def _rated(one: IdleStress, part: str) -> Value:
    at = " at the fillet of a pin" if part == OUTPUT else ""
    return Value(f"{one.rated[part].high:.3g} MPa{at}", one.rated[part].high, "MPa")


def _error(one: IdleStress, parts: Sequence[str]) -> Value:
    share, part = max((one.error(part), part) for part in parts)
    return Value(f"{part}: {ERROR}", share * one.starts[part].mean, "MPa")
