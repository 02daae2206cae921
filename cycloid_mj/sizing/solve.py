"""Drives for a requirement over its numbers of discs and clearances, or the maximum torque and its limit."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import NamedTuple

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.reducer import Reducer
from cycloid_mj.sizing.answer import Answer, FeasibleChange
from cycloid_mj.sizing.objective import shortest, strongest
from cycloid_mj.sizing.requirement import QUANTITIES, Requirement
from cycloid_mj.sizing.search import SETTINGS, Pool, Rated, create_pool, floor_digits, most_frequent_obstacle

LENGTH_WORDS = "a length of {:.4g} mm"
"""Words of a change of the length [mm]."""

EXCESS = 1.1
"""Factor of the maximum torque for which a search of its own must fail before the maximum is stated (heuristic)."""

MAX_RATIOS = 7
"""Number of ratios tried in a range, evenly spaced (heuristic): 1.5 s of CPU each."""


class Trial(NamedTuple):
    """A set of candidates (pool) with the same discs and clearance, and its best drive, which meets the requirement."""

    pool: Pool
    best: Rated


def solve(requirement: Requirement) -> tuple[Trial | None, Answer, Pool | None]:
    """Find the best drive for a requirement, or the largest feasible torque if there is none.

    Returns
    -------
    tuple
        Three values. If the requirement is feasible: the best drive with the set of candidates that was searched (its
        pool), an answer to which the caller adds the drives, and None. Otherwise: None; the answer with the largest
        torque, what limits it, and the smallest feasible length as a remedy; and the pool in which the drive with this
        torque was found, or None if there are no candidates.
    """
    trial, failed = _search_pools(requirement)
    if trial:
        return Trial(trial.pool, trial.pool.lightest() or trial.best), Answer(trial.pool.requirement, ()), None
    if not failed:
        return None, Answer(requirement, (), 0.0, _describe_infeasible_size(requirement)), None
    trial, length_changes = _search_longer(requirement, failed)
    if trial:
        return trial, Answer(trial.pool.requirement, ()), None
    pool, drive = _find_strongest(requirement)
    if drive and drive.torque >= requirement.torque:  # the search for the maximum found what that for the torque missed
        pool = pool.changed(pool.requirement.but(torque=requirement.torque)) or pool
        return Trial(pool, pool.lightest() or drive), Answer(pool.requirement, ()), None
    most = drive.torque if drive else 0.0
    return None, Answer(requirement, (), most, _describe_torque_limit(pool), length_changes), pool


def _search_pools(requirement: Requirement) -> tuple[Trial | None, list[Pool]]:
    """Return the first drive that meets a requirement, or None, and the pools of candidates searched before in vain."""
    failed: list[Pool] = []
    for pool in create_pools(requirement):
        if drive := find_drive(pool, study=True):
            return Trial(pool, drive), failed
        failed.append(pool)
    return None, failed


def _find_strongest(requirement: Requirement) -> tuple[Pool, Rated | None]:
    """Find the drive with the largest torque for a requirement, and its pool; None if no drive passes its study.

    The required torque does not influence the result, so that every refusal states the same maximum. A search for the
    largest torque can miss drives that a search for a given torque finds, so it is followed by searches for `EXCESS`
    times the torque, until one fails.
    """
    unlimited = requirement.but(torque=QUANTITIES["torque"].high)
    pools = sorted(create_pools(unlimited), key=_rated_merit, reverse=True)
    results = ((pool, drive) for pool in pools if (drive := pool.best(strongest(pool.requirement))))
    pool, drive = next(results, (pools[0], None))
    drive = drive and pool.nearer_to_capacity(drive)
    while drive and EXCESS * drive.torque <= unlimited.torque:
        stronger, _ = _search_pools(requirement.but(torque=floor_digits(EXCESS * drive.torque)))
        if not stronger:
            break
        pool, drive = stronger.pool, stronger.best
    return pool, drive


def find_drive(pool: Pool, *, study: bool, max_evaluations: int = SETTINGS.ratings) -> Rated | None:
    """Return a drive of a pool of candidates that carries the required torque within the limits; None if there is none.

    With `study`, it must pass its tolerance study; otherwise its computed torque limit is sufficient. At most
    `max_evaluations` candidates are evaluated. If the length is limited, the shortest drive is searched until one is
    short enough. The limit does not enter the search otherwise, so that a drive which is found at one limit is found at
    all larger ones.
    """
    requirement = pool.requirement
    torque, without_length_limit = requirement.torque, requirement.but(length=math.inf)
    drive = pool.best(strongest(without_length_limit, torque), torque, study=study, max_evaluations=max_evaluations)
    if drive and drive.figures["length"] > requirement.length:
        drive = pool.best(shortest(requirement), requirement.length, study=study, max_evaluations=max_evaluations)
    return drive if drive and drive.capacity >= torque and drive.figures["length"] <= requirement.length else None


def _rated_merit(pool: Pool) -> float:
    """Return a merit of a pool of candidates: the largest computed torque limit [N m] within the required limits.

    If all candidates exceed the required length or backlash, it is minus the logarithm of the smallest excess; -inf if
    none can be evaluated. Tolerance studies are left out.
    """
    objective = strongest(pool.requirement)
    drive = pool.best(objective, study=False, max_evaluations=SETTINGS.few_ratings) or pool.nearest(objective)
    if not drive:
        return -math.inf
    excess = float(objective.excess({"capacity": drive.capacity, **drive.figures}))
    return -excess if excess > 0.0 else drive.capacity


def _search_longer(requirement: Requirement, pools: Iterable[Pool]) -> tuple[Trial | None, tuple[FeasibleChange, ...]]:
    """Search for the lightest drive of the smallest feasible length, if the required length is too small for `pools`.

    The lightest drive can be shorter than the shortest of the search for the length. If it has the required length, it
    is returned; otherwise the change of the length to that of this drive, if there is one.
    """
    length = least_length(pools) if requirement.length < math.inf else math.inf
    if not requirement.length < length < math.inf:
        return None, ()
    trial, _ = _search_pools(requirement.but(length=length))
    if trial:
        drive = trial.pool.lightest() or trial.best
        if drive.figures["length"] <= requirement.length:
            short = trial.pool.requirement.but(length=requirement.length)
            return Trial(replace(trial.pool, requirement=short), drive), ()
        length = round_up_length(drive.figures["length"])
    return None, (change_length(requirement, length),)


def least_length(pools: Iterable[Pool]) -> float:
    """Return the smallest length of drives of some pools that carry the torque within their tolerances [m], or inf.

    The length is rounded up.
    """
    drives = [pool.best(shortest(pool.requirement), max_evaluations=SETTINGS.few_ratings) for pool in pools]
    return min((round_up_length(drive.figures["length"]) for drive in drives if drive), default=math.inf)


def change_length(requirement: Requirement, length: float) -> FeasibleChange:
    """Return the change of a requirement to another length [m]."""
    return FeasibleChange(LENGTH_WORDS.format(MILLIMETRES * length), requirement.but(length=length))


def round_up_length(length: float) -> float:
    """Round a length [m] up to tenths of a millimetre."""
    return math.ceil(1e4 * length) / 1e4


def is_feasible(requirement: Requirement) -> bool:
    """Return whether a new search finds a drive that meets a requirement, without looking for the lightest."""
    return any(find_drive(pool, study=False) and find_drive(pool, study=True) for pool in create_pools(requirement))


def create_pools(requirement: Requirement, source: Pool | None = None) -> Iterator[Pool]:
    """Yield the pools of candidates to search for a requirement: one for each number of discs and each clearance.

    If no clearance is required, the first pool has the usual clearance. Pools with finer clearances follow, because
    more teeth carry with them. The next clearance is always the largest for which the estimates nearly reach the torque
    within length and backlash, or the finest if there is none. The first pool for each number of discs uses the ratios
    of rated to estimated torque limits that were found in the pool `source`, if it is passed.
    """
    for discs in requirement.numbers_of_discs:
        fixed = requirement.but(discs=discs)
        same_size = source and source.requirement.diameter == fixed.diameter
        pool = source.changed(fixed) if source and same_size else create_pool(fixed, source)
        while pool:
            yield pool
            finer = (pool.changed(changed) for changed in pool.requirement.finer)
            pools = [replace(other, corrections={}) for other in finer if other]
            promising = (other for other in pools if other.promise >= SETTINGS.likely * fixed.torque)
            pool = next(promising, pools[-1] if pools else None)


def _describe_torque_limit(pool: Pool) -> str:
    """Describe what limits the torque of the best drive that was evaluated in a pool."""
    requirement = pool.requirement
    drive = pool.nearest(strongest(requirement))
    if not drive:
        return "its teeth skip under any load, or no drive can be balanced"
    if drive.figures["length"] > requirement.length:
        return (
            f"no drive is shorter than {MILLIMETRES * drive.figures['length']:.4g} mm ({length_parts(drive.reducer)})"
        )
    if drive.figures.get("backlash", 0.0) > requirement.backlash:
        return (
            f"its backlash is {drive.figures['backlash']:.3g} arcmin or less in 99 % of drives with clearances of "
            f"{1e6 * requirement.usual_clearance:.3g} um"
        )
    return drive.weakest.name


def _describe_infeasible_size(requirement: Requirement) -> str:
    """Describe why no drive of the required size exists: parts in stock, motor shaft, assembly, or ratio and clearance.

    The assembly is the reason if there are discs, but none can be built into a drive.
    """
    required = requirement.but(discs=requirement.numbers_of_discs[0])
    free = required.but(custom=True)
    if not requirement.custom and create_pool(free):
        return "no pins and bearings in stock fit"
    if requirement.motor != "auto" and create_pool(required.but(motor="auto")):
        return f"no crank that fits is thick enough for the shaft of the motor {requirement.motor}"
    size = f"with a ratio of {requirement.ratio} fits into {MILLIMETRES * requirement.diameter:g} mm"
    if obstacle := most_frequent_obstacle(required.kind) or most_frequent_obstacle(free.kind):
        return f"no drive {size} ({requirement.process}): {obstacle}"
    return f"no disc {size} with clearances of {1e6 * requirement.usual_clearance:g} um ({requirement.process})"


def length_parts(reducer: Reducer) -> str:
    """Describe in words which parts add up to the length of a drive."""
    low, high = casing(reducer).ends
    half = 0.5 * reducer.design.gear.stack_width
    discs = "disc" if reducer.design.gear.discs == 1 else "discs"
    return (
        f"{MILLIMETRES * (-half - low):.3g} mm of motor flange and input bearings, "
        f"{MILLIMETRES * 2.0 * half:.3g} mm of {discs}, {MILLIMETRES * (high - half):.3g} mm of output and its bearings"
    )


def best_ratio(requirement: Requirement, low: int, high: int) -> Requirement:
    """Return the requirement with the ratio, from `low` to `high`, that has the largest estimated torque.

    Up to `MAX_RATIOS` evenly spaced ratios are compared.

    Raises
    ------
    UsageError
        The range is empty.
    """
    if low > high:
        raise UsageError(f"--ratio-range {low}:{high} is empty: give the smaller ratio first")
    count = min(MAX_RATIOS, high - low + 1)
    ratios = [round(low + (high - low) * number / max(count - 1, 1)) for number in range(count)]

    def torque(ratio: int) -> float:
        pool = create_pool(requirement.but(ratio=ratio, discs=requirement.numbers_of_discs[0]))
        return pool.promise if pool else 0.0

    return requirement.but(ratio=max(ratios, key=torque))
