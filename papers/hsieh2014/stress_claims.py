"""Claims on stress, judged by numbers at no load: heights, orders and patterns (Figs 12-16)."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from cycloid_mj.analysis.series import design_of
from cycloid_mj.comparison import Spread, order
from cycloid_mj.record import Run
from hsieh2014 import stated
from hsieh2014.claims import (
    Claim,
    NumericalError,
    Result,
    Stated,
    Verdict,
    order_verdict,
    range_verdict,
    share_verdict,
)
from hsieh2014.cycle import cycle
from hsieh2014.idle_stress import IdleStress
from hsieh2014.phases import by_angle, largest_of_halves, likeness, share_near, standing_for_pin_1
from hsieh2014.plan import no_load

REGULAR = 0.5
"""A curve counts as regular if each start's correlates by this with the mean of the others."""

MOSTLY = 0.5
"""Pin 1 is loaded about crank angle 0 if this share of what presses it over a turn falls there."""

ERROR = "one more refinement, or where bulk begins"
TREATMENT = (
    "the treatment of contact: the paper states no stiffness, damping or mesh of its motion solver; see the hypothesis"
)


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
        for part in stated.ORDER:
            yield height(name, part, one)
        yield parts_in_order(name, one)
        if name == "pin":
            yield shaft_peaks(one, starts[name])
        yield output(name, one, starts[name])
        if name == "pin":
            yield pin_1_cycle(starts[name], starts["nonpin"], rated[name])
    for part in stated.ORDER:
        yield designs_in_order(part, found["pin"], found["nonpin"])


def height(design: str, part: str, one: IdleStress) -> Claim:
    """Judge how high the curve of a part reaches."""
    theirs, ours = stated.HEIGHTS[part, design], one.starts[part]
    return Claim(
        key=f"stress_height_{part}_{design}",
        figure=stated.FIGURES[part],
        part=part,
        design=design,
        condition=no_load(),
        paper=Stated(
            f"the {part}'s stress reaches up to about {theirs:g} MPa", "height", f"{theirs:g} MPa", theirs, "MPa"
        ),
        ours=Result(
            f"{ours.words} MPa at impact peaks, 1/{theirs / ours.mean:.0f} of that",
            ours.mean,
            "MPa",
            (ours.low, ours.high),
        ),
        error=_error(one, [part]),
        verdict=range_verdict(ours, stated.LEAST * theirs, stated.MOST * theirs),
        decided_by=TREATMENT,
        rated=_rated(one, part),
    )


def parts_in_order(design: str, one: IdleStress) -> Claim:
    """Judge which part is stressed most, and which least."""
    spreads = [one.starts[part] for part in stated.ORDER]
    orders = [order(spreads[0], spreads[1]), order(spreads[1], spreads[2])]
    theirs = [stated.HEIGHTS[part, design] for part in stated.ORDER]
    return Claim(
        key=f"stress_order_of_parts_{design}",
        figure="Figs 12-14",
        part="all",
        design=design,
        condition=no_load(),
        paper=Stated(" > ".join(stated.ORDER), "order", " > ".join(f"{size:g}" for size in theirs) + " MPa"),
        ours=Result(
            ", ".join(f"{part} {size.words}" for part, size in zip(stated.ORDER, spreads, strict=True)) + " MPa",
        ),
        error=_error(one, stated.ORDER),
        verdict=chain_verdict(orders),
        decided_by="the parts' assumed dimensions, and where bulk stress begins",
        rated=Result(", ".join(f"{part} {one.rated[part].high:.3g}" for part in stated.ORDER) + " MPa"),
    )


def chain_verdict(orders: Sequence[int]) -> Verdict:
    """Judge a chain of orders, each 1 (as stated), -1 (the other way) or 0 (not told apart)."""
    if any(each < 0 for each in orders):
        return "disagrees"
    return "agrees" if all(each > 0 for each in orders) else "not determined"


def designs_in_order(part: str, pin: IdleStress, nonpin: IdleStress) -> Claim:
    """Judge whether a part is stressed less without pins."""
    theirs = stated.HEIGHTS[part, "nonpin"] / stated.HEIGHTS[part, "pin"]
    ours = (pin.starts[part], nonpin.starts[part])
    verdict, _ = order_verdict(order(*ours), {})
    ratio = ours[1].over(ours[0])
    rated = nonpin.rated[part].high / pin.rated[part].high
    return Claim(
        key=f"stress_order_of_designs_{part}",
        figure=stated.FIGURES[part],
        part=part,
        design="both",
        condition=no_load(),
        paper=Stated(
            f"{part}: less stress without pins than with them", "order", f"{theirs:.2g} to 1", theirs, "nonpin / pin"
        ),
        ours=Result(
            f"{ours[1].words} against {ours[0].words} MPa, {ratio.values[0]:.2g} to 1",
            ratio.values[0],
            "nonpin / pin",
            (ratio.low, ratio.high),
        ),
        error=NumericalError(ratio.values[0] * max(pin.error(part), nonpin.error(part)), "nonpin / pin", ERROR),
        verdict=verdict,
        decided_by="how hard the gear strikes: through two clearances and a loose pin, or one",
        rated=Result(
            f"{nonpin.rated[part].high:.3g} against {pin.rated[part].high:.3g} MPa, {rated:.2g} to 1",
            rated,
            "nonpin / pin",
        ),
    )


def shaft_peaks(one: IdleStress, starts: Sequence[Run]) -> Claim:
    """Judge where the shaft's two peaks a turn are: those of the cam's force, which alone loads it."""
    curves = [by_angle(run, ["cam"]) for run in starts]
    each = [largest_of_halves(curve) for curve in curves]
    mean = largest_of_halves(np.mean(curves, axis=0))
    at = [Spread.of(angles) for angles in zip(*each, strict=True)]
    holds = [
        all(abs(angle - wanted) <= stated.NEAR for angle, wanted in zip(pair, stated.SHAFT_PEAKS, strict=True))
        for pair in each
    ]
    return Claim(
        key="stress_peaks_shaft_pin",
        figure=stated.FIGURES["shaft"],
        part="shaft",
        design="pin",
        condition=no_load(),
        paper=Stated(
            "two peaks a turn, near 75 and 255 deg, the highest at 74 deg", "pattern", "75, 255 deg", 74.0, "deg"
        ),
        ours=Result(
            f"the cam's force peaks at {at[0].words} and {at[1].words} deg; over all starts at {mean[0]:g} and "
            f"{mean[1]:g} deg",
            mean[0],
            "deg",
            (at[0].low, at[0].high),
        ),
        error=NumericalError(at[0].half, "deg", f"spread of {len(starts)} starts"),
        verdict=share_verdict(holds),
        decided_by="gravity against the gear's centrifugal force, which makes two maxima a turn where neither wins",
        rated=Result(f"{one.rated['shaft'].words} MPa over the turn, in whose frame the cam's force all but stands"),
    )


def output(design: str, one: IdleStress, starts: Sequence[Run]) -> Claim:
    """Judge whether the output is stressed less than the most stressed other part, and alike in every start."""
    count = _output_pins(starts[0])
    alike = likeness([by_angle(run, [f"output_pin_{number}" for number in range(1, count + 1)]) for run in starts])
    others = [max(sizes) for sizes in zip(*(one.starts[part].values for part in stated.ORDER), strict=True)]
    low = order(Spread.of(others), one.starts["output"])
    regular = share_verdict([each >= REGULAR for each in alike])
    return Claim(
        key=f"stress_output_{design}",
        figure=stated.FIGURES["output"],
        part="output",
        design=design,
        condition=no_load(),
        paper=Stated("the output's stress is low and regular", "pattern", "low, regular"),
        ours=Result(
            f"{one.starts['output'].words} MPa, the most stressed other part {Spread.of(others).words} MPa; its force "
            f"over the turn correlates between starts by {Spread.of(alike).words}",
            one.starts["output"].mean,
            "MPa",
            (one.starts["output"].low, one.starts["output"].high),
        ),
        error=_error(one, ["output"]),
        verdict=both(chain_verdict([low]), regular),
        decided_by="the output pins' assumed dimensions (low); chaos (regular)",
        rated=_rated(one, "output"),
    )


def both(one: Verdict, other: Verdict) -> Verdict:
    """Judge a claim of two halves: it fails with either, and agrees with both."""
    if "disagrees" in (one, other):
        return "disagrees"
    return "agrees" if one == other == "agrees" else "not determined"


def pin_1_cycle(starts: Sequence[Run], nonpin: Sequence[Run], rated: Run) -> Claim:
    """Judge whether pin 1 is loaded from 350 to 10 deg alone; lobe 1 of the nonpin design stands beside."""
    from cycloid_mj.comparison import settled

    reach = stated.PIN_1_LOADED[1] + stated.NEAR
    shares, of_lobe = (
        Spread.of(share_near(by_angle(run, [f"{stem}_{standing_for_pin_1(design_of(run))}"]), reach) for run in each)
        for stem, each in (("pin", starts), ("lobe", nonpin))
    )
    begins, ends, turn, _ = cycle(settled(rated))
    return Claim(
        key="stress_cycle_pin_1",
        figure=stated.FIGURES["pin_1"],
        part="pin_1",
        design="pin",
        condition=no_load(),
        paper=Stated("pin 1 is loaded at 0, relieved by 10 deg, loaded again from 350 deg", "pattern", "350 to 10 deg"),
        ours=Result(
            f"of what presses it over a turn, {100 * shares.low:.0f} to {100 * shares.high:.0f} % comes within "
            f"{reach:g} deg of 0, a ninth of the turn; of lobe 1 without pins {100 * of_lobe.low:.0f} to "
            f"{100 * of_lobe.high:.0f} %",
            shares.mean,
            "share of the turn's peaks",
            (shares.low, shares.high),
        ),
        error=NumericalError(shares.half, "share of the turn's peaks", f"spread of {len(starts)} starts"),
        verdict=share_verdict([share >= MOSTLY for share in shares.values]),
        decided_by="the clearance: at no load the gear floats, and touches the pins that it is farthest out at",
        rated=Result(f"loaded from {begins:.0f} to {ends:.0f} deg, {turn:.0f} % of the turn"),
    )


def _rated(one: IdleStress, part: str) -> Result:
    return Result(f"{one.rated[part].high:.3g} MPa", one.rated[part].high, "MPa")


def _error(one: IdleStress, parts: Sequence[str]) -> NumericalError:
    share, part = max((one.error(part), part) for part in parts)
    return NumericalError(share * one.starts[part].mean, "MPa", f"{part}: {ERROR}")


def _output_pins(run: Run) -> int:
    return sum(name.startswith("output_pin_") and name.endswith("_moment") for name in run.columns)
