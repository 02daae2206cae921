"""Claims on the maxima and the order of stress, judged without load over independent starts."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from statistics import median

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Claim, Range, Removal, Value, Verdict
from cycloid_mj.comparison import StartSpread, Variation
from hsieh2014 import statements, verdicts
from hsieh2014.idle_stress import ERROR, IdleStress, rated_value, stress_error
from hsieh2014.plan import LEFT_OPEN
from hsieh2014.run_figures import RunFigures
from hsieh2014.stated import HEIGHTS, LEAST, MOST, ORDER
from hsieh2014.stress_evidence import Evidence, Searched, forces_of
from hsieh2014.stress_patterns import output, pin_1_cycle, shaft_peaks

TREATMENT = "the contact model: the paper states no stiffness, damping or mesh of its motion solver"


def stress_claims(
    studies: Mapping[str, IdleStress],
    starts: Mapping[str, Sequence[RunFigures]],
    rated: Mapping[str, Run],
    searched: Searched | None = None,
) -> Iterator[Claim]:
    """Yield the judged claims on stress, part by part.

    `studies` are the stresses, `starts` the runs without load and `rated` the run under the rated load, by design.
    `searched` are the variations.
    """
    searched = searched or Searched()
    evidence = Evidence(
        studies, forces_of(starts), {variation: forces_of(runs) for variation, runs in searched.varied.items()}
    )
    for name, study in studies.items():
        for part in ORDER:
            yield height(name, part, study, evidence, searched)
        yield parts_in_order(name, evidence, searched)
        if name == "pin":
            yield shaft_peaks(study, evidence, searched.ranges)
        yield output(name, evidence, searched.ranges)
        if name == "pin":
            yield pin_1_cycle(evidence, rated[name], searched.ranges)
    for part in ORDER:
        yield designs_in_order(part, evidence, searched.ranges)
        yield smaller(statements.stress_mean(part), part, np.mean, evidence, searched.ranges)
        yield smaller(statements.stress_fluctuation(part), part, np.std, evidence, searched.ranges)


def height(design: str, part: str, idle_stress: IdleStress, evidence: Evidence, searched: Searched) -> Claim:
    """Judge whether a part's largest stress is the paper's, with our contacts and with every searched contact law.

    `idle_stress` has the stress of the design, `evidence` the forces of all runs, `searched` the variations. Forces
    depend continuously on stiffness and chord error: a stress between two computed maxima can be reached.
    """
    theirs, ours = HEIGHTS[part, design], idle_stress.starts[part]
    low, high = LEAST * theirs, MOST * theirs
    cases = {each.words: evidence.sizes(design, part, np.max, each) for each in evidence.varied}
    cases |= {words: StartSpread((size,)) for words, size in searched.reached.get((part, design), {}).items()}
    verdict, sizes = verdicts.range_verdict(ours, low, high), [*cases.values(), ours]
    if (
        verdict == Verdict.DISAGREES
        and min(each.low for each in sizes) <= high <= max(each.high for each in sizes) / LEAST
    ):
        verdict = Verdict.DEPENDS
    highest = max(cases, key=lambda words: cases[words].high, default="")
    return statements.stress_height(part, design).judge(
        ours=verdicts.spread_value(
            f"{ours.words} MPa at impact peaks, 1/{theirs / ours.mean:.0f} of the paper's value", ours, "MPa"
        ),
        error=stress_error(idle_stress, [part]),
        verdict=verdict,
        decided_by=TREATMENT + (f"; {highest}: {cases[highest].high:.3g} MPa" if highest else ""),
        rated=rated_value(idle_stress, part),
        searched=(*searched.ranges, *searched.contact_ranges),
        removals=[
            Removal(words, f"{_range_words(size)} MPa", verdicts.range_verdict(size, low, high))
            for words, size in cases.items()
        ],
        p=verdicts.sign_test_p(verdicts.within(ours, low, high)),
    )


def smaller(
    statement: statements.Statement,
    part: str,
    property_of: Callable[[Array], float],
    evidence: Evidence,
    ranges: Sequence[Range],
) -> Claim:
    """Judge whether a part's mean stress, or its fluctuation, is smaller without pins than with them.

    `property_of` computes this quantity [MPa] from the stress curve over a turn.
    """

    def sizes(changed: Variation | None) -> tuple[StartSpread, StartSpread]:
        pin, nonpin = (evidence.sizes(name, part, property_of, changed) for name in ("pin", "nonpin"))
        return pin, nonpin

    pin, nonpin = sizes(None)
    ratio = nonpin.over(pin)
    # to what does not fluctuate in some start there is no ratio
    compared = f"{ratio.values[0]:.2g} to 1, " if math.isfinite(ratio.high) else ""
    varied = {each: sizes(each) for each in evidence.varied}
    missed = max(evidence.stress[name].by_force[part].residual for name in ("pin", "nonpin"))
    verdict, changes = verdicts.order_verdict(_order(pin, nonpin, missed), _left_open(varied, missed))
    words = f"{nonpin.words} against {pin.words} MPa, {compared}p = {verdicts.chance(pin, nonpin):.2g}"
    number, spread = (ratio.values[0], (ratio.low, ratio.high)) if compared else (None, None)
    return statement.judge(
        ours=Value(words, number, statements.BY_DESIGN, spread),
        error=Value(f"error of the linear fit of stress over force; {len(pin.values)} runs", missed, "MPa"),
        verdict=verdict,
        decided_by=verdicts.order_cause(verdict, changes, "none of the varied values that the paper omits"),
        searched=ranges,
        removals=_orders(varied, missed),
        p=verdicts.chance(pin, nonpin),
    )


def _order(pin: StartSpread, nonpin: StartSpread, missed: float) -> int:
    """Return which is larger; 0 if the difference is within the error of the estimate [MPa]."""
    return verdicts.rank_order(pin, nonpin) if abs(median(pin.values) - median(nonpin.values)) > missed else 0


def _left_open(varied: Mapping[Variation, tuple[StartSpread, StartSpread]], missed: float = 0.0) -> dict[str, int]:
    """Return the order of pin and nonpin for each change of what the paper leaves open."""
    return {each.words: _order(*both, missed) for each, both in varied.items() if each.parameter in LEFT_OPEN}


def _orders(varied: Mapping[Variation, tuple[StartSpread, StartSpread]], missed: float = 0.0) -> list[Removal]:
    """Judge for each single change whether the stress is smaller without pins.

    `varied` are the stresses of pin and nonpin [MPa]; medians that differ by less than `missed` [MPa] have no order.
    """
    removals = []
    for each, (pin, nonpin) in varied.items():
        words = f"{nonpin.words} without pins, {pin.words} MPa with them, p = {verdicts.chance(pin, nonpin):.2g}"
        removals.append(Removal(each.words, words, verdicts.order_verdict(_order(pin, nonpin, missed), {})[0]))
    return removals


def _range_words(size: StartSpread) -> str:
    return size.words if len(size.values) > 1 else f"{size.mean:.3g}"


def parts_in_order(design: str, evidence: Evidence, searched: Searched) -> Claim:
    """Judge the order of the parts by stress, with our contacts and with every searched treatment of contact.

    `evidence` has the stress and the forces of all runs, `searched` the variations.
    """
    each = evidence.stress[design]

    def sizes(changed: Variation | None) -> list[StartSpread]:
        return [evidence.peaks(design, part, changed) for part in ORDER]

    verdict, p = _descending(sizes(None))
    of_runs = {
        each: Removal(each.words, f"{_of_parts(sizes(each))} MPa", _descending(sizes(each))[0])
        for each in evidence.varied
    }
    of_contact = []
    for words in searched.reached.get((ORDER[0], design), {}):
        stresses = [searched.reached[part, design][words] for part in ORDER]
        descends = verdicts.majority_verdict([stresses == sorted(stresses, reverse=True)])
        of_contact.append(Removal(words, f"{_of_parts(stresses)} MPa", descends))
    left_open = [*of_contact, *(removal for each, removal in of_runs.items() if each.parameter in LEFT_OPEN)]
    agreeing = [each.what for each in left_open if each.verdict == Verdict.AGREES]
    return statements.stress_of_parts(design).judge(
        ours=Value(f"{_of_parts(sizes(None))} MPa"),
        error=stress_error(each, ORDER),
        verdict=Verdict.DEPENDS if agreeing and verdict == Verdict.DISAGREES else verdict,
        decided_by=f"omitted by the paper: {', '.join(agreeing)}"
        if agreeing
        else "no variation leads to the claimed result",
        rated=Value(", ".join(f"{part} {each.rated[part].high:.3g}" for part in ORDER) + " MPa"),
        searched=(*searched.ranges, *searched.contact_ranges),
        removals=[*of_runs.values(), *of_contact],
        p=p,
    )


def _of_parts(sizes: Sequence[StartSpread | float]) -> str:
    texts = [size.words if isinstance(size, StartSpread) else f"{size:.3g}" for size in sizes]
    return ", ".join(f"{part} {text}" for part, text in zip(ORDER, texts, strict=True))


def _descending(sizes: Sequence[StartSpread]) -> verdicts.Part:
    """Judge whether the stress decreases from part to part; return verdict and p value."""
    return verdicts.jointly(
        [
            (verdicts.order_verdict(verdicts.rank_order(*pair), {})[0], verdicts.chance(*pair))
            for pair in pairwise(sizes)
        ]
    )


def designs_in_order(part: str, evidence: Evidence, ranges: Sequence[Range]) -> Claim:
    """Judge whether a part has a lower stress without pins, by the `evidence` of all runs; `ranges` were searched."""
    pin, nonpin = (evidence.stress[name] for name in ("pin", "nonpin"))
    ours = (pin.starts[part], nonpin.starts[part])
    varied = {
        each: (evidence.peaks("pin", part, each), evidence.peaks("nonpin", part, each)) for each in evidence.varied
    }
    verdict, changes = verdicts.order_verdict(verdicts.rank_order(*ours), _left_open(varied))
    ratio = ours[1].over(ours[0])
    mean = ratio.values[0]
    rated = nonpin.rated[part].high / pin.rated[part].high
    words = f"{ours[1].words} against {ours[0].words} MPa, {mean:.2g} to 1, p = {verdicts.chance(*ours):.2g}"
    under = f"{nonpin.rated[part].high:.3g} against {pin.rated[part].high:.3g} MPa, {rated:.2g} to 1"
    return statements.stress_of_designs(part).judge(
        ours=Value(words, mean, statements.BY_DESIGN, (ratio.low, ratio.high)),
        error=Value(ERROR, mean * max(pin.error(part), nonpin.error(part)), statements.BY_DESIGN),
        verdict=verdict,
        decided_by=verdicts.order_cause(verdict, changes, "none of the varied values that the paper omits"),
        searched=ranges,
        removals=_orders(varied),
        p=verdicts.chance(*ours),
        rated=Value(under, rated, statements.BY_DESIGN),
    )
