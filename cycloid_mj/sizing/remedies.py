"""Changes of a requirement that make it feasible, in the order in which a user can act on them, each verified."""

import itertools
import math
from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any

from cycloid_mj.base.units import MILLIMETRES, RPM
from cycloid_mj.design import fits
from cycloid_mj.design.processes import PROCESSES
from cycloid_mj.life.heat import COOLING
from cycloid_mj.sizing.answer import FeasibleChange
from cycloid_mj.sizing.requirement import LARGEST_PAIR, MAX_DISCS, Requirement
from cycloid_mj.sizing.search import SETTINGS, Pool, create_pool
from cycloid_mj.sizing.solve import (
    LENGTH_WORDS,
    create_pools,
    find_drive,
    is_feasible,
    least_length,
)

MIN_SPEED = 30.0 * RPM
"""Slowest crank of a remedy [rad/s]."""

STEP = 1.04
"""Factor between values that are tried (heuristic); with their rounding, a remedy is at most 5 % above the smallest."""

SERIES: dict[str, tuple[float, float, str]] = {
    "life": (100.0, 1.0, "a life of {:.4g} h"),
    "duty_share": (0.05, 1.0, "a duty of {:.3g} of the time"),
    "speed": (MIN_SPEED, RPM, "{:.4g} rpm"),
    "backlash": (60.0, 1.0, "a backlash of {:.3g} arcmin"),
    "diameter": (3.0, 1e-3, "{:g} mm"),
}
"""Largest change of a value in SI, its unit in SI, and the words of a change."""

MAX_PROBES, MAX_VERIFICATIONS, MAX_REMEDIES = 6, 5, 4
"""Largest number of values that are searched for a remedy (heuristic), of those that are verified from the smallest
on, and of remedies; a diameter is among them."""

Changes = Sequence[FeasibleChange]
"""Changes of the same kind, the smallest first."""


def remedies(
    requirement: Requirement, max_torque: float, pool: Pool | None, length_changes: Changes = ()
) -> Iterator[FeasibleChange]:
    """Yield single changes of a requirement that make it feasible; where there are none, combined changes.

    Parameters
    ----------
    requirement
        A requirement that no drive meets.
    max_torque
        Largest torque of the drives that meet its other limits [N m].
    pool
        Candidate drives whose computed torque limits predict by how much a change increases this torque; None if there
        are none.
    length_changes
        Feasible changes of the length.
    """
    if not pool:  # no drive of this size exists: that of the next larger size, or with free sizes, predicts others
        larger = (change.requirement for change in list_changes(requirement, "diameter")[3::4])
        others = itertools.chain(larger, [requirement.but(custom=True)])
        pools = (create_pool(changed.but(discs=changed.numbers_of_discs[0])) for changed in others)
        pool = next(filter(None, pools), None)
    if not pool:
        return
    search, smallest_of = RemedySearch(requirement, max_torque, pool), itertools.chain.from_iterable
    single = itertools.chain(smallest_of(map(search.smallest, _single_changes(requirement))), length_changes)
    last = map(search.smallest, (list_changes(requirement, "diameter"), _processes(requirement)))
    all_remedies = itertools.chain(itertools.islice(single, MAX_REMEDIES - 1), smallest_of(last))
    count = 0
    for remedy in itertools.islice(all_remedies, MAX_REMEDIES):
        count += 1
        yield remedy
    if not count:
        combined = smallest_of(map(search.smallest, _combined_changes(requirement)))
        yield from (_shorten_remedy(remedy, requirement.length) for remedy in itertools.islice(combined, 1))


def first_feasible(changes: Changes, is_met: Callable[[Any], bool]) -> Iterator[FeasibleChange]:
    """Yield the first of some changes whose requirement `is_met` by a search; nothing if none is.

    Steps between the changes that are tried double, and `MAX_VERIFICATIONS` of them are tried at most.
    """
    indices = [2**number - 1 for number in range(MAX_VERIFICATIONS)]
    likely = (changes[index] for index in indices if index < len(changes))
    yield from itertools.islice((change for change in likely if is_met(change.requirement)), 1)


class RemedySearch:
    """Searches for the smallest feasible changes of a requirement, by the ratings of a pool."""

    def __init__(self, requirement: Requirement, most: float, pool: Pool) -> None:
        self.pool = pool.strong_part
        predicted = self._predict(requirement)
        self.scale = most / predicted if most and predicted else 1.0

    def _predict(self, changed: Requirement) -> float:
        """Predict the largest torque of a requirement [N m]."""
        variants = [changed.but(discs=discs) for discs in changed.numbers_of_discs]
        variants += [finer for variant in variants for finer in variant.finer[-1:]]
        return max((pool.promise for pool in map(self.pool.changed, variants) if pool), default=0.0)

    def _rate(self, changed: Requirement) -> float:
        """Return the largest torque that the ratings so far and a few more show, with the effect of a study [N m]."""
        torque = 0.0
        for pool in create_pools(changed, self.pool):
            if drive := find_drive(pool, study=False, max_evaluations=SETTINGS.few_ratings):
                return drive.capacity
            torque = max(torque, pool.rated_torque)
        return torque

    def smallest(self, changes: Changes) -> Iterator[FeasibleChange]:
        """Yield the smallest of several changes of a requirement that makes it feasible; nothing if there is none.

        `changes` are sorted from the smallest. The first one whose predicted torque suffices is rated, and the ratio of
        rated to predicted torque corrects the predictions, until one change suffices and the next smaller one does not.
        Where none is predicted to suffice any more, steps double (galloping search). Complete searches, as for a new
        requirement, verify the result.
        """
        predict = cache(lambda index: self._predict(changes[index].requirement))
        scale, low, high = self.scale, 0, _count_buildable(predict, len(changes))
        for probe in range(MAX_PROBES):
            if low == high:
                break
            required = changes[low].requirement.torque
            index = _first_above(predict, required / max(scale, 1e-9), low, high)
            if index == high < len(changes):
                index = high - 1
            elif index == high and probe:  # larger changes may suffice, although they are not predicted to
                index = min(low - 1 + 2 ** (probe - 1), high - 1)
            elif index == high:
                break
            torque = self._rate(changes[index].requirement)
            scale = torque / max(predict(index), 1e-9)
            low, high = (low, index) if torque >= required else (index + 1, high)
        yield from first_feasible(changes[high:], is_feasible)


def _count_buildable(predict: Callable[[int], float], count: int) -> int:
    """Return the number of changes up to the last for which a torque above 0 is predicted.

    It is less than `count` if no parts in stock suit the largest diameters; it is found by bisection.
    """
    if not count or predict(count - 1):
        return count
    first = _first_above(predict, math.ulp(0.0), 0, count)
    return bisect_left(range(count), True, first, key=lambda index: not predict(index))


def _first_above(function: Callable[[int], float], bound: float, low: int, high: int) -> int:
    """Return the first index from `low` to `high` - 1 at which a `function` is at least a `bound`; `high` if none is.

    The index is searched in steps that double, then by bisection, as if the function did not decrease.
    """
    last, index = low - 1, low
    while index < high and function(index) < bound:
        last, index = index, max(min(2 * index - low + 1, high - 1), index + 1)
    return high if index >= high else bisect_left(range(index), bound, last + 1, key=function)


def _shorten_remedy(remedy: FeasibleChange, required: float) -> FeasibleChange:
    """Replace a length in a remedy that exceeds the `required` length [m] by the smallest feasible length."""
    changed = remedy.requirement
    length = least_length(create_pools(changed)) if changed.length > required else math.inf
    if not length < changed.length:
        return remedy
    old_text, new_text = (LENGTH_WORDS.format(MILLIMETRES * value) for value in (changed.length, length))
    return FeasibleChange(remedy.words.replace(old_text, new_text), changed.but(length=length))


def list_changes(requirement: Requirement, key: str) -> Changes:
    """List changes of one value of a requirement in steps of the factor `STEP`, the smallest change first.

    `key` is the value, one of `SERIES`. Values are rounded to three digits.
    """
    value, (end, unit, text) = getattr(requirement, key), SERIES[key]
    if key == "diameter" and requirement.fit:
        end = min(end, fits.LARGEST / LARGEST_PAIR)
    step = STEP if end > value else 1.0 / STEP
    count = max(math.floor(math.log(end / value) / math.log(step)), 0) if math.isfinite(value) else 0
    numbers = dict.fromkeys(float(f"{value * step**exponent / unit:.3g}") for exponent in range(1, count + 1))
    return [FeasibleChange(text.format(number), requirement.but(**{key: number * unit})) for number in numbers]


def better_cooling(requirement: Requirement) -> Changes:
    """List the kinds of cooling that are better than the required one."""
    cooling = {name: film for name, film in COOLING.items() if film > requirement.film}
    return [FeasibleChange(f"cooling: {name}", requirement.but(film=film)) for name, film in cooling.items()]


def _single_changes(requirement: Requirement) -> Iterator[Changes]:
    """Yield series of changes of a single value, each series from the smallest change to the largest.

    The values are life, duty (share of the time under load), speed, cooling, material, discs, clearance and backlash,
    in this order. With a duty file, life, duty and speed do not change. `requirement` is that for the drive.
    """
    if not requirement.duty:
        yield from (list_changes(requirement, key) for key in ("life", "duty_share", "speed"))
    yield better_cooling(requirement)
    for name in PROCESSES[requirement.process].others:
        yield [FeasibleChange(name, requirement.but(material=name))] if name != requirement.made_of else []
    disc_numbers = range(max(requirement.numbers_of_discs) + 1, MAX_DISCS)
    yield [FeasibleChange(f"{discs} discs", requirement.but(discs=discs)) for discs in disc_numbers]
    text, clearances = "clearances of {:.3g} um", () if requirement.fit else requirement.tighter_clearances
    yield [
        FeasibleChange(text.format(1e6 * clearance), requirement.but(clearance=clearance)) for clearance in clearances
    ]
    yield list_changes(requirement, "backlash")


def _processes(requirement: Requirement) -> Changes:
    """List processes that allow larger torques, then pins and bearings of any size."""
    usual = requirement.but(material="", clearance=0.0, fit="")
    stronger = PROCESSES[requirement.process].stronger
    free = [] if requirement.custom else [FeasibleChange("free sizes of pins and bearings", usual.but(custom=True))]
    words = f"{{}} in place of {requirement.process}"
    return [FeasibleChange(words.format(process), usual.but(process=process)) for process in stronger] + free


def _combined_changes(requirement: Requirement) -> Iterator[Changes]:
    """Yield combined changes of a requirement: a process, a length and a crank speed, with a series of diameters.

    The process is the one that allows the largest torque, or that of the requirement, each with the required sizes of
    pins and bearings, then with free ones. The length is the required one, or twice the diameter. The speed is the
    required one, a quarter, or a sixteenth of it.
    """
    processes = *PROCESSES[requirement.process].stronger[-1:], requirement.process
    kinds = ((process, custom) for process in processes for custom in (requirement.custom, True))
    for process, is_custom in dict.fromkeys(kinds):
        texts = [] if process == requirement.process else [f"{process} in place of {requirement.process}"]
        texts += ["free sizes of pins and bearings"] if is_custom != requirement.custom else []
        base = (
            requirement.but(process=process, custom=is_custom, material="", clearance=0.0, fit="")
            if texts
            else requirement
        )
        for length in dict.fromkeys((requirement.length, max(requirement.length, 2.0 * requirement.diameter))):
            length_text = [LENGTH_WORDS.format(MILLIMETRES * length)] if length > requirement.length else []
            for slowdown in (1.0, 4.0, 16.0):
                speed = max(float(f"{base.speed / slowdown / RPM:.3g}") * RPM, MIN_SPEED)
                changed = base.but(speed=speed, length=length)
                speed_text = [f"{speed / RPM:.4g} rpm"] if speed != base.speed else []
                yield [
                    FeasibleChange(" and ".join([*texts, *speed_text, *length_text, larger.words]), larger.requirement)
                    for larger in list_changes(changed, "diameter")
                ]
