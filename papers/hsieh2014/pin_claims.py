"""Claims on pin 1 without load: displacement, rotation and sliding on the gear (Figs 9 and 16)."""

from collections.abc import Callable, Sequence

from cycloid_mj.base.result import Claim, Value, Verdict
from cycloid_mj.comparison import StartSpread
from hsieh2014 import statements
from hsieh2014.over_starts import OverStarts, ruling
from hsieh2014.pin_motion import PinMotion
from hsieh2014.verdicts import majority_verdict, spread_error, spread_value

SEEN_TURN, ROLLS = 1.0, 0.5
"""Smallest visible rotation of a pin [deg], and share of the gear's surface speed above which a pin rolls
(heuristic)."""

SWAYS, GIVE = 0.1, 0.05
"""Shares of the clearance (heuristic): smallest displacement that counts, and allowed deflection of the socket."""

Motions = OverStarts[PinMotion]


def pin_claims(motions: Motions, rated: PinMotion) -> tuple[Claim, ...]:
    """Judge every claim on pin 1 by its motion in the starts without load; also report it under the rated load."""
    return tuple(judged(motions, rated) for judged in (sway, spin, turns, slides))


def sway(motions: Motions, rated: PinMotion) -> Claim:
    """Judge by the `motions` of the starts without load whether pin 1 stays within its clearance; report `rated`, too.

    The clearance is increased by the deflection of the contact.
    """
    starts, clearance = motions.base, motions.base[0].clearance
    reach, span = _spread(starts, lambda one: one.reach), _spread(starts, lambda one: one.span)
    judged = ruling(
        motions,
        lambda one: one.span > SWAYS * one.clearance and one.reach <= (1.0 + GIVE) * one.clearance,
        lambda some: f"{_um(_spread(some, lambda one: one.reach))} um from the middle",
    )
    words = f"range {_um(span)} um, largest distance from the middle {_um(reach)} um; clearance {1e6 * clearance:g} um"
    under = (
        f"range {1e6 * rated.span:.3g} um, largest distance from the middle {1e6 * rated.reach:.3g} um, "
        "because the socket deflects"
    )
    return statements.pin_1_sway(clearance).judge(
        ours=Value(words, 1e3 * reach.mean, "mm", (1e3 * reach.low, 1e3 * reach.high)),
        error=Value(f"spread of {len(starts)} runs", 1e6 * reach.half, "um"),
        searched=motions.ranges,
        rated=Value(under, 1e3 * rated.reach, "mm"),
        **vars(judged),
    )


def _one_way(ahead: Sequence[bool]) -> Verdict:
    """Judge a continued rotation: it agrees if most starts rotate in the same direction."""
    return Verdict.AGREES if majority_verdict(ahead) != Verdict.NOT_DETERMINED else Verdict.NOT_DETERMINED


def spin(motions: Motions, rated: PinMotion) -> Claim:
    """Judge by the `motions` of the starts without load whether pin 1 keeps rotating; report `rated`, too.

    It does if its mean speed has the same sign in most starts.
    """
    means = _spread(motions.base, lambda one: one.mean_spin)
    rocking = _spread(motions.base, lambda one: one.rms_spin)

    def words(some: Sequence[PinMotion]) -> str:
        return f"mean {_spread(some, lambda one: one.mean_spin).words} rad/s"

    judged = ruling(motions, lambda one: one.mean_spin > 0.0, words, judged=_one_way)
    return statements.PIN_1_SPIN.judge(
        ours=spread_value(f"mean speed {means.words} rad/s, rms {rocking.words} rad/s", means, "rad/s"),
        error=spread_error(means, "rad/s"),
        searched=motions.ranges,
        rated=Value(
            f"mean {rated.mean_spin:.3g} rad/s, which the creep speed of the friction law alone sets (a factor of 5 "
            "between 20 and 1 mm/s): not determined",
            rated.mean_spin,
            "rad/s",
        ),
        **vars(judged),
    )


def turns(motions: Motions, rated: PinMotion) -> Claim:
    """Judge by the `motions` of the starts without load whether pin 1 is visibly rotated at the angles of Fig. 9(a)."""
    widest = _spread(motions.base, lambda one: one.seen_turned)
    first = ", ".join(f"{angle:.2g}" for angle in motions.base[0].turned)
    judged = ruling(
        motions,
        lambda one: one.seen_turned >= SEEN_TURN,
        lambda some: f"{_spread(some, lambda one: one.seen_turned).words} deg",
    )
    return statements.PIN_1_TURNS.judge(
        ours=spread_value(f"{first} deg in the first run; largest difference {widest.words} deg", widest, "deg"),
        error=spread_error(widest, "deg"),
        searched=motions.ranges,
        rated=Value(", ".join(f"{angle:.3g}" for angle in rated.turned) + " deg"),
        **vars(judged),
    )


def slides(motions: Motions, rated: PinMotion) -> Claim:
    """Judge by the `motions` of the starts without load whether pin 1 slides on the gear, in contrast to rolling."""
    shares = _spread(motions.base, lambda one: one.rolling)
    percent = f"{100 * shares.low:.2g} to {100 * shares.high:.2g}"
    judged = ruling(
        motions,
        lambda one: one.rolling < ROLLS,
        lambda some: f"{100 * _spread(some, lambda one: one.rolling).high:.2g} % of that of the disc at most",
    )
    return statements.PIN_1_SLIDES.judge(
        ours=spread_value(f"the surface speed of the pin is {percent} % of that of the disc", shares, "1"),
        error=spread_error(shares, "1"),
        searched=motions.ranges,
        rated=Value(f"{100 * rated.rolling:.3g} %", rated.rolling, "1"),
        **vars(judged),
    )


def _spread(starts: Sequence[PinMotion], figure: Callable[[PinMotion], float]) -> StartSpread:
    return StartSpread.of(map(figure, starts))


def _um(lengths: StartSpread) -> str:
    return StartSpread.of(1e6 * each for each in lengths.values).words
