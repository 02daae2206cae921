"""Changes of a requirement that make it feasible, in the order in which a user can act on them, each verified."""

import itertools
import math
from collections.abc import Callable, Iterator, Sequence

from cycloid_mj.base.units import MILLIMETRES, RPM
from cycloid_mj.design import fits
from cycloid_mj.design.processes import PROCESSES
from cycloid_mj.life.heat import COOLING
from cycloid_mj.sizing.answer import FeasibleChange
from cycloid_mj.sizing.requirement import LARGEST_PAIR, MAX_DISCS, Requirement
from cycloid_mj.sizing.search import SETTINGS, Pool, pool_of
from cycloid_mj.sizing.solve import is_feasible

STEP = 1.04
"""Factor between values that are tried; with their rounding, a remedy is at most 5 % above the smallest."""

MAX_DIAMETER, MIN_LIFE, MIN_SHARE, MIN_SPEED = 3.0, 100.0, 0.05, 30.0 * RPM
"""Largest diameter [m], shortest life [h], smallest share of the time and slowest crank [rad/s] of a remedy."""

MAX_PROBES, MAX_REMEDIES = 3, 4
"""Largest number of values that are searched for a remedy, and of remedies; a diameter is among them."""

Promise = Callable[[Requirement], float]
"""Largest torque that is predicted for a requirement, over the required one."""


def remedies(requirement: Requirement, most: float, pools: Sequence[Pool]) -> Iterator[FeasibleChange]:
    """Yield single changes that make a requirement feasible; where there are none, combined changes.

    `most` is the largest torque that was found for it [N m], and `pools` are those that were searched. Their ratings
    predict by how much a change increases this torque.
    """
    if not pools:  # no drive of this size exists: that of the next larger size predicts others
        larger = (requirement.but(diameter=_diameter(requirement, steps)) for steps in range(4, 80, 4))
        found = (pool_of(changed.but(discs=changed.numbers_of_discs[0])) for changed in larger)
        pools = [pool for pool in [next(filter(None, found), None)] if pool]

    def estimated(changed: Requirement) -> float:
        largest = 0.0
        for pool in pools:
            variants = [changed, *(changed.but(clearance=clearance) for clearance in changed.finer_clearances[-1:])]
            options = [variant.but(discs=discs) for variant in variants for discs in variant.numbers_of_discs]
            largest = max(largest, *map(pool.promise, options))
        return largest

    before = estimated(requirement)
    scale = most / before if most and before else 1.0

    def promise(changed: Requirement) -> float:
        return scale * estimated(changed) / changed.torque

    searches = (search(requirement, promise) for search in (_conditions, _options, _lengths))
    several = itertools.islice(itertools.chain.from_iterable(searches), MAX_REMEDIES - 1)
    count = 0
    for remedy in itertools.chain(several, _diameters(requirement, promise)):
        count += 1
        yield remedy
    for remedy in _processes(requirement, promise) if count < MAX_REMEDIES else ():
        count += 1
        yield remedy
    if not count:
        yield from _combined(requirement, promise)


def _smallest(change: Callable[[int], Requirement], steps: int, promise: Promise) -> Requirement | None:
    """Return the feasible change by the fewest of some steps, each by a factor `STEP`; None if none is found.

    Doubling and a bisection by the predicted torque lead to a first number of steps, from which the search goes on by
    ratings (galloping search). The last is verified with its tolerance study.
    """
    doubled = [*(2**power for power in range(steps.bit_length())), steps] if steps > 0 else []
    high = next((number for number in doubled if promise(change(number)) >= 1.0), 0)
    if not high:
        return None
    low = high // 2
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if promise(change(middle)) >= 1.0 else (middle, high)
    probe, low, high = high, 0, steps + 1
    for number in range(MAX_PROBES):
        if is_feasible(change(probe), study=False):
            high, probe = probe, max(probe - 2**number, low + 1)
        else:
            low, probe = probe, min(probe + 2**number, high - 1)
        if high - low == 1:
            break
    verified = (change(number) for number in range(high, min(high + 3, steps + 1)))
    return next((changed for changed in verified if is_feasible(changed)), None)


def _three_digits(value: float) -> float:
    return float(f"{value:.3g}")


def _conditions(requirement: Requirement, promise: Promise) -> Iterator[FeasibleChange]:
    """Yield a shorter life, a smaller share of the time, a slower crank, and cooling."""
    scales: list[tuple[str, float, float, str]] = [
        ("life", MIN_LIFE, 1.0, "a life of {:.4g} h"),
        ("duty_share", MIN_SHARE, 1.0, "a duty of {:.3g} of the time"),
        ("speed", MIN_SPEED, RPM, "{:.4g} rpm"),
    ]
    for key, least, unit, words in () if requirement.duty else scales:
        value = getattr(requirement, key)

        def change(steps: int, key: str = key, value: float = value, unit: float = unit) -> Requirement:
            return requirement.but(**{key: _three_digits(value / STEP**steps / unit) * unit})

        steps = math.floor(math.log(value / least) / math.log(STEP))
        if promise(change(max(steps, 0))) >= 1.0 and (changed := _smallest(change, steps, promise)):
            yield FeasibleChange(words.format(getattr(changed, key) / unit), changed)
    cooled = [(f"cooling: {name}", requirement.but(film=film)) for name, film in COOLING.items()]
    yield from _first([option for option in cooled if option[1].film > requirement.film], promise)


def _first(options: Sequence[tuple[str, Requirement]], promise: Promise) -> Iterator[FeasibleChange]:
    """Yield the first feasible option."""
    for words, changed in options:
        if promise(changed) >= SETTINGS.likely and is_feasible(changed):
            yield FeasibleChange(words, changed)
            return


def _options(requirement: Requirement, promise: Promise) -> Iterator[FeasibleChange]:
    """Yield another material, more discs, or tighter clearances."""
    others = [name for name in PROCESSES[requirement.process].others if name != requirement.made_of]
    yield from _first([(name, requirement.but(material=name)) for name in others], promise)
    more = range(max(requirement.numbers_of_discs) + 1, MAX_DISCS)
    yield from _first([(f"{discs} discs", requirement.but(discs=discs)) for discs in more], promise)
    tighter = [] if requirement.fit else [*requirement.tighter_clearances]
    words = "clearances of {:.3g} um"
    yield from _first([(words.format(1e6 * one), requirement.but(clearance=one)) for one in tighter], promise)


def _lengths(requirement: Requirement, promise: Promise) -> Iterator[FeasibleChange]:
    """Yield the smallest feasible length, if a length is required."""
    if requirement.length == math.inf:
        return
    steps = math.floor(math.log(2.0 * requirement.diameter / requirement.length) / math.log(STEP))

    def change(steps: int) -> Requirement:
        return requirement.but(length=round(requirement.length * STEP**steps, 4))

    if changed := _smallest(change, steps, promise):
        yield FeasibleChange(f"a length of {MILLIMETRES * changed.length:g} mm", changed)


def _diameter(requirement: Requirement, steps: int) -> float:
    """Return a diameter [m] that is larger by some steps, rounded to half a millimetre, or to one from 100 mm."""
    diameter = requirement.diameter * STEP**steps
    return round(diameter, 3) if diameter >= 0.1 else round(2.0 * diameter, 3) / 2.0


def _diameters(requirement: Requirement, promise: Promise) -> Iterator[FeasibleChange]:
    """Yield the smallest feasible diameter."""
    largest = min(MAX_DIAMETER, fits.LARGEST / LARGEST_PAIR) if requirement.fit else MAX_DIAMETER
    steps = math.floor(math.log(largest / requirement.diameter) / math.log(STEP))
    changed = _smallest(lambda steps: requirement.but(diameter=_diameter(requirement, steps)), steps, promise)
    if changed:
        yield FeasibleChange(f"{MILLIMETRES * changed.diameter:g} mm", changed)


def _processes(requirement: Requirement, promise: Promise) -> Iterator[FeasibleChange]:
    """Yield a stronger process, or free sizes."""
    usual = requirement.but(material="", clearance=0.0, fit="")
    stronger = PROCESSES[requirement.process].stronger
    options = [(f"{process} in place of {requirement.process}", usual.but(process=process)) for process in stronger]
    free = [] if requirement.custom else [("free sizes of pins and bearings", requirement.but(custom=True))]
    yield from _first([*options, *free], promise)


def _combined(requirement: Requirement, promise: Promise) -> Iterator[FeasibleChange]:
    """Yield the first feasible diameter with the strongest process, a slower crank, or a longer drive."""
    for process in (*PROCESSES[requirement.process].stronger[-1:], requirement.process):
        words = [] if process == requirement.process else [f"{process} in place of {requirement.process}"]
        base = requirement.but(process=process, material="", clearance=0.0, fit="") if words else requirement
        for length in dict.fromkeys((requirement.length, 2.0 * requirement.diameter)):
            free = [f"a length of {MILLIMETRES * length:g} mm"] if length > requirement.length else []
            for slower in (1.0, 4.0, 16.0):
                speed = max(_three_digits(base.speed / slower / RPM) * RPM, MIN_SPEED)
                changed = base.but(speed=speed, length=max(length, requirement.length))
                rpm = [f"{speed / RPM:.4g} rpm"] if speed != base.speed else []
                for remedy in _diameters(changed, promise):
                    yield FeasibleChange(" and ".join([*words, *rpm, *free, remedy.words]), remedy.requirement)
                    return
