"""Drives for a requirement over its numbers of discs and clearances, or the maximum torque and its limit."""

from collections.abc import Iterator
from dataclasses import dataclass

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.reducer import Reducer
from cycloid_mj.sizing.answer import Answer
from cycloid_mj.sizing.requirement import Requirement
from cycloid_mj.sizing.search import SETTINGS, Pool, Rated, lightest, pool_of, strongest

MAX_RATIOS = 7
"""Number of ratios tried in a range, evenly spaced: 1.5 s of CPU each."""


@dataclass(frozen=True, eq=False)
class Trial:
    """Discs and clearances that were searched: their pool, and the best drive, the strongest if none is feasible."""

    pool: Pool
    best: Rated | None

    @property
    def requirement(self) -> Requirement:
        """The requirement with its discs and clearances."""
        return self.pool.requirement

    @property
    def is_feasible(self) -> bool:
        """Whether the best drive meets the requirement."""
        return bool(self.best and self.best.passed and self.best.capacity >= self.requirement.torque)

    @property
    def most(self) -> float:
        """Largest torque that a drive carries within all limits [N m]; 0 if there is none."""
        return self.best.torque if self.best and self.best.passed else 0.0


def solve(requirement: Requirement) -> tuple[Trial | None, Answer, list[Pool]]:
    """Find the lightest drive of a requirement; else a refusal with the maximum torque and its limit, and the pools."""
    failed: list[Pool] = []
    for trial in _trials(requirement):
        if trial.is_feasible:
            best = trial.pool.best(lightest(trial.requirement)) or trial.best
            return Trial(trial.pool, best), Answer(trial.requirement, ()), []
        failed.append(trial.pool)
    if not failed:
        return None, Answer(requirement, (), 0.0, _no_room(requirement)), []
    failed.sort(key=lambda pool: -pool.promise(pool.requirement))
    first = failed[0]
    trial = Trial(first, first.best(strongest(first.requirement)))
    return None, Answer(requirement, (), trial.most, _limit(trial)), failed


def is_feasible(requirement: Requirement, *, study: bool = True) -> bool:
    """Return whether the search finds a drive; without a `study`, whether one is rated for the torque."""
    return any(trial.is_feasible or (trial.best and not study) for trial in _trials(requirement, study=study))


def _trials(requirement: Requirement, *, study: bool = True) -> Iterator[Trial]:
    """Yield the trials of a requirement for each of its numbers of discs, each with the first drive found.

    Clearances that are not required are the usual ones, then the largest of the finer ones with which estimates promise
    the torque within the backlash; more teeth carry with them.
    """
    for discs in requirement.numbers_of_discs:
        fixed: Requirement | None = requirement.but(discs=discs)
        while fixed:
            pool = pool_of(fixed)
            if not pool:
                break
            yield Trial(pool, pool.best(strongest(fixed), -fixed.torque, only_goal=True, study=study))
            finer = [fixed.but(clearance=clearance, tightened=True) for clearance in fixed.finer_clearances]
            likely = (other for other in finer if pool.promise(other) >= SETTINGS.likely * fixed.torque)
            fixed = next(likely, finer[-1] if finer else None)


def _limit(trial: Trial) -> str:
    """Return what limits the torque of a trial without a solution."""
    requirement, one = trial.requirement, trial.best
    rated = [drive for drive in trial.pool.rated.values() if drive and drive.items]
    if not one and rated:
        return max(rated, key=lambda drive: drive.capacity).weakest.name
    if not one:
        return "its teeth skip under any load, or no drive can be balanced"
    if one.figures["length"] > requirement.length:
        return f"no drive is shorter than {MILLIMETRES * one.figures['length']:.3g} mm ({length_parts(one.reducer)})"
    if one.figures.get("backlash", 0.0) > requirement.backlash:
        return (
            f"its backlash is {one.figures['backlash']:.3g} arcmin or less in 99 % of drives with clearances of "
            f"{1e6 * requirement.usual_clearance:.3g} um"
        )
    return one.weakest.name


def _no_room(requirement: Requirement) -> str:
    """Return the reason why no drive of the required size exists, for a message."""
    discs = requirement.numbers_of_discs[0]
    if not requirement.custom and pool_of(requirement.but(custom=True, discs=discs)):
        return "no pins and bearings in stock fit"
    if requirement.motor != "auto" and pool_of(requirement.but(motor="auto", discs=discs)):
        return f"no crank that fits is thick enough for the shaft of the motor {requirement.motor}"
    return (
        f"no disc with a ratio of {requirement.ratio} fits into {MILLIMETRES * requirement.diameter:g} mm with "
        f"clearances of {1e6 * requirement.usual_clearance:g} um ({requirement.process})"
    )


def length_parts(reducer: Reducer) -> str:
    """Describe what the length of a drive consists of."""
    low, high = casing(reducer).ends
    half = 0.5 * reducer.design.gear.stack_width
    discs = "disc" if reducer.design.gear.discs == 1 else "discs"
    return (
        f"{MILLIMETRES * (-half - low):.3g} mm of motor flange and input bearings, "
        f"{MILLIMETRES * 2.0 * half:.3g} mm of {discs}, {MILLIMETRES * (high - half):.3g} mm of output and its bearings"
    )


def best_ratio(requirement: Requirement, low: int, high: int) -> Requirement:
    """Choose the ratio of a range with the largest estimated torque, among evenly spaced ratios.

    Raises
    ------
    UsageError
        The range is empty.
    """
    if low > high:
        raise UsageError(f"--ratio: the range of ratios {low} to {high} is empty: give the smaller ratio first")
    count = min(MAX_RATIOS, high - low + 1)
    ratios = [round(low + (high - low) * number / max(count - 1, 1)) for number in range(count)]

    def torque(ratio: int) -> float:
        changed = requirement.but(ratio=ratio, discs=requirement.numbers_of_discs[0])
        pool = pool_of(changed)
        return pool.promise(changed) if pool else 0.0

    return requirement.but(ratio=max(ratios, key=torque))
