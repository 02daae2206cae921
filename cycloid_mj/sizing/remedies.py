"""Changes of a requirement that make it feasible, in the order in which a user can act on them, each verified."""

import math
from collections.abc import Callable, Iterator, Sequence

from cycloid_mj.base.units import MILLIMETRES, RPM
from cycloid_mj.design import fits
from cycloid_mj.sizing.answer import HOPELESS, FeasibleChange, is_feasible, length_parts
from cycloid_mj.sizing.process import COOLING, PROCESSES
from cycloid_mj.sizing.requirement import LARGEST_PAIR, MAX_DISCS, Requirement
from cycloid_mj.sizing.search import Pool, pool_of

TOLERANCE = 1.05
"""A remedy's value is at most this factor above the smallest at which the search finds a drive."""

TORQUE_EXPONENT = 2.5
"""Estimated exponent of torque over diameter, for the first diameter that is tried."""

MIN_LIFE, MIN_SHARE, MIN_SPEED, MAX_DIAMETER = 100.0, 0.05, 30.0 * RPM, 3.0
"""Shortest life [h], smallest share of the time, slowest crank [rad/s], and largest diameter [m] of a remedy."""

MAX_GAIN = 4.0
"""Ratio of the required torque to the largest beyond which no other material, discs or clearances are searched."""

MAX_STEPS, MAX_REMEDIES = 6, 4
"""Largest number of values tried one after the other, and of remedies."""


def remedies(requirement: Requirement, most: float, pools: Sequence[Pool]) -> Iterator[FeasibleChange]:
    """Yield single changes that make a requirement feasible; where there are none, combined changes.

    `most` is the largest torque that was found [N m], and `pools` are those that were searched for it.
    """
    found = False
    for remedy in _single(requirement, most, pools):
        found = True
        yield remedy
    if not found:
        yield from _combined(requirement)


def _single(requirement: Requirement, most: float, pools: Sequence[Pool]) -> Iterator[FeasibleChange]:
    """Yield feasible single changes, each with the smallest value that suffices; a diameter is among them."""
    near = requirement.torque <= MAX_GAIN * most or not most
    searches = [
        *(_conditions(requirement, pools) if most else ()),
        *([_first(_options(requirement))] if near else ()),
        _longer(requirement, pools),
    ]
    count = 0
    for found in searches:
        for remedy in found if count < MAX_REMEDIES - 1 else ():
            count += 1
            yield remedy
    for remedy in _larger(requirement, most):
        count += 1
        yield remedy
    if count < MAX_REMEDIES:
        yield from _first(_processes(requirement))


def _capacity(requirement: Requirement) -> float:
    """Return a torque that some drive is rated for [N m]: at least the required one if it is found, else the largest.

    Clearances are the finest of the process, unless others are required. Where the backlash is limited, the result is
    the required torque of a drive that meets both limits, or 0.
    """
    if requirement.backlash < math.inf:
        return requirement.torque if is_feasible(requirement) else 0.0
    pools = [pool_of(requirement.variants[-1].but(discs=discs)) for discs in requirement.numbers_of_discs]
    give_up = HOPELESS * requirement.torque
    largest = [pool.largest(requirement.length, requirement.torque, give_up=give_up) for pool in pools if pool]
    return max((one.capacity for one in largest if one), default=0.0)


def _conditions(requirement: Requirement, pools: Sequence[Pool]) -> Iterator[Iterator[FeasibleChange]]:
    """Yield the searches for a shorter life, a smaller share of the time, a slower crank and cooling."""
    if not requirement.duty:
        yield _smallest(
            lambda factor: requirement.but(life=float(f"{requirement.life / factor:.3g}")),
            requirement.life / MIN_LIFE,
            lambda changed: f"a life of {changed.life:.4g} h",
            pools,
        )
        yield _smallest(
            lambda factor: requirement.but(duty_share=float(f"{requirement.duty_share / factor:.3g}")),
            requirement.duty_share / MIN_SHARE,
            lambda changed: f"a duty of {changed.duty_share:.3g} of the time",
            pools,
        )
        yield _smallest(
            lambda factor: requirement.but(speed=float(f"{requirement.speed / factor / RPM:.3g}") * RPM),
            requirement.speed / MIN_SPEED,
            lambda changed: f"{changed.speed / RPM:.4g} rpm",
            pools,
        )
    cooled = [(name, requirement.but(film=film)) for name, film in COOLING.items() if film > requirement.film]
    yield _first(FeasibleChange(f"cooling: {name}", changed) for name, changed in cooled if _is_likely(changed, pools))


def _is_likely(changed: Requirement, pools: Sequence[Pool]) -> bool:
    """Return whether a rated candidate is strong enough under changed conditions, in proportion to the estimates."""
    return any((pool.capacities_under(changed) >= changed.torque).any() for pool in pools)


def _smallest(
    change: Callable[[float], Requirement], most: float, words: Callable[[Requirement], str], pools: Sequence[Pool]
) -> Iterator[FeasibleChange]:
    """Yield the smallest change by a factor between 1 and `most` that is feasible, within `TOLERANCE`.

    A bisection by the rated candidates leads to a first factor; the search verifies this one and its neighbours.
    """
    if most <= TOLERANCE or not _is_likely(change(most), pools):
        return
    low, high = 1.0, most
    while high > math.sqrt(TOLERANCE) * low:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if _is_likely(change(middle), pools) else (middle, high)
    step = math.sqrt(TOLERANCE) if is_feasible(change(high)) else TOLERANCE
    factor = high
    if step < TOLERANCE:  # feasible: try smaller changes
        for _ in range(MAX_STEPS):
            if factor / TOLERANCE <= 1.0 or not is_feasible(change(factor / TOLERANCE)):
                break
            factor /= TOLERANCE
    else:
        factors = (min(high * TOLERANCE**number, most) for number in (1, 2, 4))
        factor = next((factor for factor in factors if is_feasible(change(factor))), 0.0)
    if factor:
        yield FeasibleChange(words(change(factor)), change(factor))


def _first(options: Iterator[FeasibleChange]) -> Iterator[FeasibleChange]:
    """Yield the first feasible option."""
    feasible = next((option for option in options if is_feasible(option.requirement)), None)
    if feasible:
        yield feasible


def _options(requirement: Requirement) -> Iterator[FeasibleChange]:
    """Yield other materials, more discs and tighter clearances."""
    for material in PROCESSES[requirement.process].others:
        if material != requirement.made_of:
            yield FeasibleChange(material, requirement.but(material=material))
    for discs in range(max(requirement.numbers_of_discs) + 1, MAX_DISCS):
        yield FeasibleChange(f"{discs} discs", requirement.but(discs=discs))
    if not requirement.fit and not requirement.tightened:
        clearances = list(requirement.tighter_clearances)
        if clearances and _capacity(requirement.but(clearance=clearances[-1])) >= requirement.torque:
            for clearance in clearances:
                yield FeasibleChange(f"clearances of {1e6 * clearance:.3g} um", requirement.but(clearance=clearance))


def _longer(requirement: Requirement, pools: Sequence[Pool]) -> Iterator[FeasibleChange]:
    """Yield the smallest feasible length, if a length is required."""
    found = [pool.shortest(requirement.torque) for pool in pools] if requirement.length < math.inf else []
    shortest = min((one for one in found if one), key=lambda one: one.length, default=None)
    if shortest:
        for length in (shortest.length, TOLERANCE * shortest.length):
            longer = requirement.but(length=math.ceil(1e4 * length) / 1e4)
            if is_feasible(longer):
                parts = length_parts(shortest.reducer)
                words = f"a length of {MILLIMETRES * longer.length:g} mm (a drive exists with {parts})"
                yield FeasibleChange(words, longer)
                return


def _larger(requirement: Requirement, most: float) -> Iterator[FeasibleChange]:
    """Yield the smallest feasible diameter, by steps along the power law of the torque and secants."""
    largest = min(MAX_DIAMETER, fits.LARGEST / LARGEST_PAIR) if requirement.fit else MAX_DIAMETER
    low, high, capacity, below = requirement.diameter, requirement.diameter, most, most
    for _ in range(MAX_STEPS):
        share = max((requirement.torque / capacity) ** (1.0 / TORQUE_EXPONENT), TOLERANCE) if capacity else 1.5
        low, high = high, _rounded_up(share * high)
        below, capacity = capacity, _capacity(requirement.but(diameter=high)) if high <= largest else 0.0
        if capacity >= requirement.torque:
            break
        if high > largest or capacity < below:
            return
    else:
        return
    while high > TOLERANCE * low:
        middle = math.sqrt(low * high)
        if 0.0 < below < requirement.torque < capacity < math.inf:  # secant of the logarithms
            share = math.log(requirement.torque / below) / math.log(capacity / below)
            middle = min(max(low * (high / low) ** share, TOLERANCE * low), high / TOLERANCE)
        middle = _rounded_up(middle)
        if not low < middle < high:
            break
        found = _capacity(requirement.but(diameter=middle))
        if found >= requirement.torque:
            high, capacity = middle, found
        else:
            low, below = middle, found
    for diameter in (high, _rounded_up(TOLERANCE * high)):
        if is_feasible(requirement.but(diameter=diameter)):
            yield FeasibleChange(f"{MILLIMETRES * diameter:g} mm", requirement.but(diameter=diameter))
            return


def _rounded_up(diameter: float) -> float:
    """Round a diameter [m] up to millimetres, or to 1 %."""
    step = 1e-3 if diameter < 0.2 else 2e-3
    return round(math.ceil(diameter / step - 1e-9) * step, 6)


def _processes(requirement: Requirement) -> Iterator[FeasibleChange]:
    """Yield stronger processes, then free sizes."""
    for process in PROCESSES[requirement.process].stronger:
        changed = requirement.but(process=process, material="", clearance=0.0, fit="")
        yield FeasibleChange(f"{process} in place of {requirement.process}", changed)
    if not requirement.custom:
        yield FeasibleChange("free sizes of pins and bearings", requirement.but(custom=True))


def _combined(requirement: Requirement) -> Iterator[FeasibleChange]:
    """Yield the first feasible diameter with the strongest process, a slower crank, or a longer drive."""
    for process in (*PROCESSES[requirement.process].stronger[-1:], requirement.process):
        words = [] if process == requirement.process else [f"{process} in place of {requirement.process}"]
        base = requirement.but(process=process, material="", clearance=0.0, fit="") if words else requirement
        for length in dict.fromkeys((requirement.length, math.inf)):
            free = [f"a length of more than {MILLIMETRES * requirement.length:g} mm"] if length > base.length else []
            for slower in (1.0, 4.0, 16.0):
                speed = max(float(f"{base.speed / slower / RPM:.3g}") * RPM, MIN_SPEED)
                changed = base.but(speed=speed, length=length)
                rpm = [f"{speed / RPM:.4g} rpm"] if speed != base.speed else []
                for remedy in _larger(changed, _capacity(changed)):
                    yield FeasibleChange(" and ".join([*words, *rpm, *free, remedy.words]), remedy.requirement)
                    return
