"""Claims on stress, judged by numbers at no load over independent starts: heights, orders and patterns (Figs 12-16)."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from cycloid_mj.analysis.series import design_of
from cycloid_mj.comparison import Spread, order, settled
from cycloid_mj.record import Run
from cycloid_mj.result import Claim, Value
from hsieh2014.cycle import cycle
from hsieh2014.idle_stress import IdleStress
from hsieh2014.peaks import by_angle, largest_of_halves, likeness, share_near, standing_for_pin_1
from hsieh2014.stated import HEIGHTS, LEAST, MOST, NEAR, ORDER, PIN_1_LOADED, SHAFT_PEAKS
from hsieh2014.statements import (
    BY_DESIGN,
    PIN_1_CYCLE,
    stress_height,
    stress_of_designs,
    stress_of_output,
    stress_of_parts,
    stress_peaks,
)
from hsieh2014.verdicts import joint_verdict, order_verdict, range_verdict, share_verdict, spread_error, spread_value

REGULAR = 0.5
"""A curve counts as regular if each start's correlates by this with the mean of the others."""

MOSTLY = 0.5
"""Pin 1 is loaded about crank angle 0 if this share of what presses it over a turn falls there."""

ERROR = "one more refinement, or where bulk begins"
TREATMENT = (
    "the treatment of contact: the paper states no stiffness, damping or mesh of its motion solver; see the hypothesis"
)
OF_THE_PEAKS = "share of the turn's peaks"


def stress_claims(
    found: Mapping[str, IdleStress], starts: Mapping[str, Sequence[Run]], rated: Mapping[str, Run]
) -> Iterator[Claim]:
    """Judge every claim on stress.

    Parameters
    ----------
    found
        Design name -> its stress.
    starts, rated
        Design name -> its runs at no load, and its run under the rated load.
    """
    for name, one in found.items():
        for part in ORDER:
            yield height(name, part, one)
        yield parts_in_order(name, one)
        if name == "pin":
            yield shaft_peaks(one, starts[name])
        yield output(name, one, starts[name])
        if name == "pin":
            yield pin_1_cycle(starts[name], starts["nonpin"], rated[name])
    for part in ORDER:
        yield designs_in_order(part, found["pin"], found["nonpin"])


def height(design: str, part: str, one: IdleStress) -> Claim:
    """Judge how high the curve of a part reaches."""
    theirs, ours = HEIGHTS[part, design], one.starts[part]
    return stress_height(part, design).judged(
        found=spread_value(f"{ours.words} MPa at impact peaks, 1/{theirs / ours.mean:.0f} of that", ours, "MPa"),
        error=_error(one, [part]),
        verdict=range_verdict(ours, LEAST * theirs, MOST * theirs),
        decided_by=TREATMENT,
        rated=_rated(one, part),
    )


def parts_in_order(design: str, one: IdleStress) -> Claim:
    """Judge which part is stressed most, and which least."""
    spreads = [one.starts[part] for part in ORDER]
    words = ", ".join(f"{part} {size.words}" for part, size in zip(ORDER, spreads, strict=True))
    return stress_of_parts(design).judged(
        found=Value(f"{words} MPa"),
        error=_error(one, ORDER),
        verdict=joint_verdict(order_verdict(order(*pair), {})[0] for pair in pairwise(spreads)),
        decided_by="the parts' assumed dimensions, and where bulk stress begins",
        rated=Value(", ".join(f"{part} {one.rated[part].high:.3g}" for part in ORDER) + " MPa"),
    )


def designs_in_order(part: str, pin: IdleStress, nonpin: IdleStress) -> Claim:
    """Judge whether a part is stressed less without pins."""
    ours = (pin.starts[part], nonpin.starts[part])
    ratio = ours[1].over(ours[0])
    mean = ratio.values[0]
    rated = nonpin.rated[part].high / pin.rated[part].high
    return stress_of_designs(part).judged(
        found=Value(
            f"{ours[1].words} against {ours[0].words} MPa, {mean:.2g} to 1",
            mean,
            BY_DESIGN,
            (ratio.low, ratio.high),
        ),
        error=Value(ERROR, mean * max(pin.error(part), nonpin.error(part)), BY_DESIGN),
        verdict=order_verdict(order(*ours), {})[0],
        decided_by="how hard the gear strikes: through two clearances and a loose pin, or one",
        rated=Value(
            f"{nonpin.rated[part].high:.3g} against {pin.rated[part].high:.3g} MPa, {rated:.2g} to 1",
            rated,
            BY_DESIGN,
        ),
    )


def shaft_peaks(one: IdleStress, starts: Sequence[Run]) -> Claim:
    """Judge where the shaft's two peaks a turn are: those of the cam's force, which alone loads it."""
    curves = [by_angle(run, ["cam"]) for run in starts]
    each = [largest_of_halves(curve) for curve in curves]
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
        verdict=share_verdict(
            all(abs(angle - wanted) <= NEAR for angle, wanted in zip(pair, SHAFT_PEAKS, strict=True)) for pair in each
        ),
        decided_by="gravity against the gear's centrifugal force, which makes two maxima a turn where neither wins",
        rated=Value(f"{one.rated['shaft'].words} MPa over the turn, in whose frame the cam's force all but stands"),
    )


def output(design: str, one: IdleStress, starts: Sequence[Run]) -> Claim:
    """Judge whether the output is stressed less than the most stressed other part, and alike in every start."""
    pins = range(1, design_of(starts[0]).output.pins + 1)
    alike = likeness([by_angle(run, [f"output_pin_{number}" for number in pins]) for run in starts])
    others = Spread.of(max(sizes) for sizes in zip(*(one.starts[part].values for part in ORDER), strict=True))
    ours = one.starts["output"]
    low, _ = order_verdict(order(others, ours), {})
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
    return Value(f"{one.rated[part].high:.3g} MPa", one.rated[part].high, "MPa")


def _error(one: IdleStress, parts: Sequence[str]) -> Value:
    share, part = max((one.error(part), part) for part in parts)
    return Value(f"{part}: {ERROR}", share * one.starts[part].mean, "MPa")
