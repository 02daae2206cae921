"""Changes of a requirement that make it feasible, in the order in which a user can act on them, each verified."""

import math
from collections.abc import Callable, Iterable, Iterator

from cycloid_mj.base.units import MILLIMETRES, RPM
from cycloid_mj.design import fits
from cycloid_mj.sizing.answer import FeasibleChange, length_parts, solve
from cycloid_mj.sizing.process import COOLING, PROCESSES
from cycloid_mj.sizing.requirement import LARGEST_PAIR, MAX_DISCS, Requirement
from cycloid_mj.sizing.search import SETTINGS, Pool, pool_of

TOLERANCE = 1.05
"""A remedy's value is at most this factor above the smallest at which the search finds a drive."""

TORQUE_EXPONENT = 2.5
"""Estimated exponent of torque over diameter, for the first diameter that is tried."""

MIN_SPEED, MAX_DIAMETER = 30.0 * RPM, 3.0
"""Slowest crank [rad/s] and largest diameter [m] of a remedy."""

MAX_GAIN = 4.0
"""Ratio of the required torque to the largest beyond which no other material, discs or clearances are searched."""

MAX_STEPS = 6
"""Largest number of diameters tried one after the other."""

MAX_REMEDIES = 4
"""Number of remedies after which no other is searched for."""

MIN_LIFE, MIN_SHARE = 100.0, 0.05
"""Shortest life [h] and smallest share of the time of a remedy."""


def remedies(requirement: Requirement, most: float) -> Iterator[FeasibleChange]:
    """Yield single changes that make a requirement feasible; where there are none, combined changes."""
    found = False
    for remedy in _single(requirement, most):
        found = True
        yield remedy
    if not found:
        yield from _combined(requirement)


def _single(requirement: Requirement, most: float) -> Iterator[FeasibleChange]:
    """Yield feasible single changes, each with the smallest value that suffices; a diameter is among them."""
    searches: list[Iterator[FeasibleChange]] = [
        *(_conditions(requirement) if most else ()),
        *([_first(_options(requirement))] if requirement.torque <= MAX_GAIN * most or not most else ()),
        _longer(requirement),
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


def is_feasible(requirement: Requirement) -> bool:
    """Return whether the search finds a drive."""
    return solve(requirement)[0] is not None


def _capacity(requirement: Requirement) -> float:
    """Return a torque that some drive is rated for [N m]: at least the required one if it is found, else the largest.

    Where the backlash is limited, it is the required torque of a drive that meets both limits, or 0.
    """
    if requirement.backlash < math.inf:
        return requirement.torque if is_feasible(requirement) else 0.0
    ratings = SETTINGS.remedy_ratings
    largest = (pool.largest(requirement.length, requirement.torque, ratings) for pool in _pools(requirement))
    return max((one.capacity for one in largest if one), default=0.0)


def _pools(requirement: Requirement) -> Iterator[Pool]:
    for discs in (requirement.discs,) if requirement.discs else (1, 2):
        if pool := pool_of(requirement.but(discs=discs).without_limits):
            yield pool


def _conditions(requirement: Requirement) -> Iterator[Iterator[FeasibleChange]]:
    """Yield the searches for a shorter life, a smaller share of the time, a slower crank and cooling."""
    if not requirement.duty:
        yield _smallest(
            lambda factor: requirement.but(life=float(f"{requirement.life / factor:.3g}")),
            requirement.life / MIN_LIFE,
            lambda changed: f"a life of {changed.life:.4g} h",
        )
        yield _smallest(
            lambda factor: requirement.but(duty_share=float(f"{requirement.duty_share / factor:.3g}")),
            requirement.duty_share / MIN_SHARE,
            lambda changed: f"a duty of {changed.duty_share:.3g} of the time",
        )
        yield _smallest(
            lambda factor: requirement.but(speed=float(f"{requirement.speed / factor / RPM:.3g}") * RPM),
            requirement.speed / MIN_SPEED,
            lambda changed: f"{changed.speed / RPM:.4g} rpm",
        )
    yield _cooled(requirement)


def _cooled(requirement: Requirement) -> Iterator[FeasibleChange]:
    """Yield the weakest kind of cooling that suffices."""
    for name, film in COOLING.items():
        changed = requirement.but(film=film)
        if film > requirement.film and _exists_under(changed, _pools(requirement)) and is_feasible(changed):
            yield FeasibleChange(f"cooling: {name}", changed)
            return


def _exists_under(changed: Requirement, pools: Iterable[Pool]) -> bool:
    """Return whether pools rated under other conditions have a candidate for a requirement."""
    return any(
        pool.under(changed.but(discs=pool.requirement.discs).without_limits).exists(changed.torque, changed.length)
        for pool in pools
    )


def _smallest(
    change: Callable[[float], Requirement], most: float, words: Callable[[Requirement], str]
) -> Iterator[FeasibleChange]:
    """Yield the smallest change by a factor between 1 and the largest that is feasible, within `TOLERANCE`.

    The candidates of the requirement are rated under the changed conditions; the search then verifies the change.
    """
    pools = [*_pools(change(1.0))]

    def exists(factor: float) -> bool:
        return _exists_under(change(factor), pools)

    if most <= TOLERANCE or not exists(most):
        return
    low, high = 1.0, most
    while high > math.sqrt(TOLERANCE) * low:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if exists(middle) else (middle, high)
    for factor in (high, TOLERANCE * high, TOLERANCE**2 * high):
        if is_feasible(change(factor)):
            yield FeasibleChange(words(change(factor)), change(factor))
            return


def _first(options: Iterator[FeasibleChange]) -> Iterator[FeasibleChange]:
    """Yield the first feasible option."""
    feasible = next((option for option in options if _is_promising(option.requirement)), None)
    if feasible:
        yield feasible


def _is_promising(requirement: Requirement) -> bool:
    return _capacity(requirement) >= requirement.torque and is_feasible(requirement)


def _options(requirement: Requirement) -> Iterator[FeasibleChange]:
    """Yield other materials, more discs and tighter clearances."""
    for material in PROCESSES[requirement.process].others:
        if material != requirement.made_of:
            yield FeasibleChange(material, requirement.but(material=material))
    for discs in range(max(requirement.discs, 2 if requirement.discs == 0 else 1) + 1, MAX_DISCS):
        yield FeasibleChange(f"{discs} discs", requirement.but(discs=discs))
    if not requirement.fit and not requirement.tightened:
        clearances = list(requirement.tighter_clearances)
        if clearances and _capacity(requirement.but(clearance=clearances[-1])) >= requirement.torque:
            for clearance in clearances:
                yield FeasibleChange(f"clearances of {1e6 * clearance:.3g} um", requirement.but(clearance=clearance))


def _longer(requirement: Requirement) -> Iterator[FeasibleChange]:
    """Yield the smallest feasible length, if a length is required."""
    if requirement.length == math.inf:
        return
    pool = pool_of(requirement.but(discs=requirement.discs or 1).without_limits)
    shortest = pool.shortest(requirement.torque) if pool else None
    if shortest:
        length = math.ceil(1e4 * shortest.length) / 1e4
        longer = requirement.but(length=length)
        if is_feasible(longer):
            parts = length_parts(shortest.reducer)
            yield FeasibleChange(f"a length of {MILLIMETRES * length:g} mm (a drive exists with {parts})", longer)


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
