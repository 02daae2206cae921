"""Changes of a requirement that make it feasible, in the order in which a user can act on them, each verified."""

import itertools
import math
from collections.abc import Iterator, Sequence

from cycloid_mj.base.units import MILLIMETRES, RPM
from cycloid_mj.design import fits
from cycloid_mj.design.processes import PROCESSES
from cycloid_mj.life.heat import COOLING
from cycloid_mj.sizing.answer import FeasibleChange
from cycloid_mj.sizing.requirement import LARGEST_PAIR, MAX_DISCS, Requirement
from cycloid_mj.sizing.search import SETTINGS, Pool, pool_of
from cycloid_mj.sizing.solve import (
    LENGTH_WORDS,
    find_drive,
    finer_requirements,
    is_feasible,
    least_length,
    pools_of,
)

STEP = 1.04
"""Factor between values that are tried (heuristic); with their rounding, a remedy is at most 5 % above the smallest."""

MAX_DIAMETER, MIN_LIFE, MIN_SHARE, MIN_SPEED, MAX_BACKLASH = 3.0, 100.0, 0.05, 30.0 * RPM, 60.0
"""Largest diameter [m], shortest life [h], smallest share of the time, slowest crank [rad/s] and largest backlash
[arcmin] of a remedy."""

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
    if not pool:  # no drive of this size exists: that of the next larger size predicts others
        larger = (change.requirement for change in _larger_diameters(requirement)[3::4])
        pools = (pool_of(changed.but(discs=changed.numbers_of_discs[0])) for changed in larger)
        pool = next(filter(None, pools), None)
    if not pool:
        return
    search = _RemedySearch(requirement, max_torque, pool)
    single = itertools.chain(
        itertools.chain.from_iterable(map(search.smallest, _single_changes(requirement))), iter(length_changes)
    )
    count = 0
    for remedy in itertools.chain(
        itertools.islice(single, MAX_REMEDIES - 1), search.smallest(_larger_diameters(requirement))
    ):
        count += 1
        yield remedy
    if count < MAX_REMEDIES:
        for remedy in search.smallest(_processes(requirement)):
            count += 1
            yield remedy
    if not count:
        combined = itertools.chain.from_iterable(map(search.smallest, _combined_changes(requirement)))
        yield from (_shorten_remedy(remedy, requirement.length) for remedy in itertools.islice(combined, 1))


class _RemedySearch:
    """Searches for the smallest feasible changes of a requirement, by the ratings of a pool."""

    def __init__(self, requirement: Requirement, most: float, pool: Pool) -> None:
        self.requirement, self.pool = requirement, pool.strong_part
        predicted = self._predict(requirement)
        self.scale = most / predicted if most and predicted else 1.0

    def _predict(self, changed: Requirement) -> float:
        """Predict the largest torque of a requirement [N m]."""
        variants = [changed.but(discs=discs) for discs in changed.numbers_of_discs]
        variants += [finer for variant in variants for finer in finer_requirements(variant)[-1:]]
        return max((pool.promise for pool in map(self.pool.changed, variants) if pool), default=0.0)

    def _is_promising(self, changed: Requirement) -> bool:
        """Return whether the ratings so far and a few more find a drive, before its tolerance study."""
        pools = pools_of(changed, self.pool)
        return any(find_drive(pool, study=False, max_evaluations=SETTINGS.few_ratings) for pool in pools)

    def smallest(self, changes: Changes) -> Iterator[FeasibleChange]:
        """Yield the smallest of several changes of a requirement that makes it feasible; nothing if there is none.

        `changes` are sorted from the smallest. The index of the result is searched in three stages. Predicted torques
        lead to a first index: it is doubled until the torque suffices, then bisected. From there computed torque limits
        of candidates decide, in steps that double (galloping search). Complete searches, as for a new requirement,
        verify the result, again in steps that double.
        """
        count = len(changes)

        def is_predicted(index: int) -> bool:
            requirement = changes[index].requirement
            return self.scale * self._predict(requirement) >= requirement.torque

        doubling_indices = [*(2**power - 1 for power in range(count.bit_length())), count - 1] if count else []
        high = next((index for index in doubling_indices if is_predicted(index)), -1)
        if high < 0:
            return
        low = (high + 1) // 2 - 1
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if is_predicted(middle) else (middle, high)
        probe, low, high = high, -1, count
        for number in range(MAX_PROBES):
            if self._is_promising(changes[probe].requirement):
                high, probe = probe, max(probe - 2**number, low + 1)
            else:
                low, probe = probe, min(probe + 2**number, high - 1)
            if high - low == 1:
                break
        verified_indices = [high + 2**number - 1 for number in range(MAX_VERIFICATIONS)]
        likely_changes = (changes[index] for index in verified_indices if index < count)
        yield from itertools.islice((change for change in likely_changes if is_feasible(change.requirement)), 1)


def _shorten_remedy(remedy: FeasibleChange, required: float) -> FeasibleChange:
    """Replace the length in a remedy by the smallest feasible length, if it exceeds the `required` length [m]."""
    changed = remedy.requirement
    length = least_length(pools_of(changed)) if changed.length > required else math.inf
    if not length < changed.length:
        return remedy
    old_text, new_text = (LENGTH_WORDS.format(MILLIMETRES * value) for value in (changed.length, length))
    return FeasibleChange(remedy.words.replace(old_text, new_text), changed.but(length=length))


def _change_series(requirement: Requirement, key: str, end: float, unit: float, text_format: str) -> Changes:
    """List changes of one value of a requirement in a geometric series by the factor `STEP`, the smallest change first.

    `key` is the value that changes, up to `end` (in SI). `unit` is the unit of the message in SI, and `text_format` the
    format of the message, such as "{:.4g} rpm".
    """
    value, step = getattr(requirement, key), STEP if end > getattr(requirement, key) else 1.0 / STEP
    steps = max(math.floor(math.log(end / value) / math.log(step)), 0) if math.isfinite(value) else 0
    values = dict.fromkeys(float(f"{value * step**exponent / unit:.3g}") for exponent in range(1, steps + 1))
    return [FeasibleChange(text_format.format(number), requirement.but(**{key: number * unit})) for number in values]


def _single_changes(requirement: Requirement) -> Iterator[Changes]:
    """Yield series of changes of a single value, each series from the smallest change to the largest.

    The values are life, duty (share of the time under load), speed, cooling, material, discs, clearance and backlash,
    in this order. With a duty file, life, duty and speed do not change. `requirement` is that for the drive.
    """
    if not requirement.duty:
        yield _change_series(requirement, "life", MIN_LIFE, 1.0, "a life of {:.4g} h")
        yield _change_series(requirement, "duty_share", MIN_SHARE, 1.0, "a duty of {:.3g} of the time")
        yield _change_series(requirement, "speed", MIN_SPEED, RPM, "{:.4g} rpm")
    cooling = {name: film for name, film in COOLING.items() if film > requirement.film}
    yield [FeasibleChange(f"cooling: {name}", requirement.but(film=film)) for name, film in cooling.items()]
    for name in PROCESSES[requirement.process].others:
        yield [FeasibleChange(name, requirement.but(material=name))] if name != requirement.made_of else []
    disc_numbers = range(max(requirement.numbers_of_discs) + 1, MAX_DISCS)
    yield [FeasibleChange(f"{discs} discs", requirement.but(discs=discs)) for discs in disc_numbers]
    clearances = [] if requirement.fit else [*requirement.tighter_clearances]
    text = "clearances of {:.3g} um"
    yield [
        FeasibleChange(text.format(1e6 * clearance), requirement.but(clearance=clearance)) for clearance in clearances
    ]
    yield _change_series(requirement, "backlash", MAX_BACKLASH, 1.0, "a backlash of {:.3g} arcmin")


def _larger_diameters(requirement: Requirement) -> Changes:
    """List changes of a requirement to larger diameters, in steps of the factor `STEP`, the smallest first.

    They are rounded to 0.5 mm below 100 mm, and to 1 mm above.
    """
    largest = min(MAX_DIAMETER, fits.LARGEST / LARGEST_PAIR) if requirement.fit else MAX_DIAMETER
    steps = math.floor(math.log(largest / requirement.diameter) / math.log(STEP))
    values = (requirement.diameter * STEP**number for number in range(1, steps + 1))
    diameters = dict.fromkeys(round(value, 3) if value >= 0.1 else round(2.0 * value, 3) / 2.0 for value in values)
    larger = (value for value in diameters if value > requirement.diameter)
    return [FeasibleChange(f"{MILLIMETRES * value:g} mm", requirement.but(diameter=value)) for value in larger]


def _processes(requirement: Requirement) -> Changes:
    """List processes that allow larger torques, then pins and bearings of any size."""
    usual = requirement.but(material="", clearance=0.0, fit="")
    stronger = PROCESSES[requirement.process].stronger
    free = [] if requirement.custom else [FeasibleChange("free sizes of pins and bearings", usual.but(custom=True))]
    words = f"{{}} in place of {requirement.process}"
    return [FeasibleChange(words.format(process), usual.but(process=process)) for process in stronger] + free


def _combined_changes(requirement: Requirement) -> Iterator[Changes]:
    """Yield combined changes of a requirement: a process, a length and a crank speed, with a series of diameters.

    The process is the one that allows the largest torque, with sizes in stock, then free ones; or that of the
    requirement. The length is the required one, or twice the diameter. The speed is the required one, a quarter, or a
    sixteenth of it.
    """
    kinds = [(process, requirement.custom) for process in PROCESSES[requirement.process].stronger[-1:]]
    kinds += [(process, True) for process, _ in kinds]
    for process, is_custom in dict.fromkeys([*kinds, (requirement.process, requirement.custom)]):
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
                    for larger in _larger_diameters(changed)
                ]
