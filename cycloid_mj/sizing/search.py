"""The search: an archive of elites by closed forms, corrected by ratings of the candidates that matter."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from functools import lru_cache

import numpy as np

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.life.figures import drive_length, drive_mass
from cycloid_mj.life.item import RatedItem, Rating
from cycloid_mj.life.items import rate
from cycloid_mj.life.loading import POSES
from cycloid_mj.life.rated import torque_limits
from cycloid_mj.reducer import Reducer
from cycloid_mj.sizing.candidates import DIMENSIONS, Sizes, build_drive, conditions, decode
from cycloid_mj.sizing.estimate import DriveEstimate, estimate
from cycloid_mj.sizing.requirement import Requirement


@dataclass(frozen=True)
class ArchiveSettings:
    """Settings of the search; none of them decides what a drive withstands.

    Attributes
    ----------
    start, children, generations
        Points of the R sequence, and children of each generation: 0.3 s of CPU.
    cells, weakest
        Cells per factor e of torque and of length (neighbours differ by 4 %), and the least torque relative to the
        largest.
    scatter, line
        Standard deviations of a child about its parent and along the line to another elite, as recommended.
    calibrations, ratings, remedy_ratings
        Elites that are rated first, and the most ratings of a search and of one for a remedy: 0.07 s of CPU each.
    margin
        Estimates that miss the best by less are rated as well.
    poses
        Crank angles of a rating: margins differ by 0.5 % from those of the data sheet.
    """

    start: int = 2048
    children: int = 1024
    generations: int = 5
    cells: float = 25.0
    weakest: float = 0.02
    scatter: float = 0.02
    line: float = 0.2
    calibrations: int = 6
    ratings: int = 20
    remedy_ratings: int = 6
    rounds: int = 2
    prior: float = 1.0
    margin: float = 0.04
    poses: int = 7


SETTINGS = ArchiveSettings()

NO_LIMIT, UNSOUND = 1e9, 0.3
"""Torque limit of what has none [N m], and the factor of estimates next to a candidate that cannot be built."""


@dataclass(frozen=True, eq=False)
class Rated:
    """A candidate rated at a torque [N m]: its rating, its figures of the estimate, its capacity and weakest item."""

    reducer: Reducer
    torque: float
    rating: Rating
    figures: Mapping[str, float]
    capacity: float
    weakest: RatedItem

    @property
    def mass(self) -> float:
        """Mass of the drive [kg], from the solids of all parts in 0.05 s of CPU; infinite if a part does not fit."""
        try:
            return drive_mass(self.reducer)
        except CycloidError:
            return math.inf

    @property
    def length(self) -> float:
        """Length of the drive [m]."""
        return self.figures["length"]

    @property
    def life(self) -> float:
        """Shortest life of its parts [h]."""
        lives = [item.life for item in self.rating.items.values() if item.decisive]
        return min((life for life in lives if life is not None), default=math.inf)


def _figure(rated: Rated, key: str) -> float:
    return rated.mass if key == "mass" else rated.figures.get(key, NO_LIMIT)


def rate_drive(
    requirement: Requirement, reducer: Reducer, torque: float, estimated: tuple[str, ...] = (), poses: int = POSES
) -> Rated | None:
    """Rate a drive at a torque [N m] under the conditions of a requirement; None if it has no equilibrium."""
    drive = reducer.design.drive
    needed = torque / reducer.design.reduction
    loaded = reducer.but(drive={"torque": needed, "power": drive.power * needed / drive.torque})
    try:
        rating = rate(loaded.design, requirement.duty_at(torque), requirement.life, poses=poses)
        length = 1e-3 * drive_length(loaded)
    except CycloidError:
        return None
    items = {key: item for key, item in rating.items.items() if item.decisive}
    limits = torque_limits(items.values(), torque, requirement.life)
    other = min((limit for key, limit in limits.items() if key not in estimated), default=NO_LIMIT)
    weakest = min(limits, key=lambda key: limits[key])
    return Rated(loaded, torque, rating, {**limits, "other": other, "length": length}, limits[weakest], items[weakest])


Objective = Callable[[Array, Array, Array], Array]
Meets = Callable[[Array, Array], Mask]
"""What to minimize by capacity, mass and length, and which capacities and lengths are feasible."""

Accept = Callable[[Rated], bool]
"""Whether a rated candidate meets what no estimate has."""


@dataclass(eq=False)
class Pool:
    """Elites of a requirement without its limits, and their ratings so far, which correct the estimates."""

    requirement: Requirement
    sample: Reducer
    factors: Mapping[str, float]
    points: Array
    sizes: Sizes
    estimated: DriveEstimate
    rated: dict[int, Rated | None] = field(default_factory=dict)
    """Ratings by index; None where a candidate cannot be built or balanced."""

    def rate(self, index: int, torque: float) -> Rated | None:
        """Rate a candidate at a torque [N m] near its capacity; less where it has no equilibrium."""
        if index not in self.rated:
            reducer, keys = build_drive(self.requirement, self.sizes.row(index), torque), tuple(self.estimated.limits)
            tries = (
                rate_drive(self.requirement, reducer, share * torque, keys, SETTINGS.poses)
                for share in (1.0, UNSOUND)
                if reducer
            )
            self.rated[index] = next((rated for rated in tries if rated), None)
        return self.rated[index]

    def corrected(self, *, weighed: bool = False) -> tuple[dict[str, Array], Array, Array]:
        """Return torque limits by item [N m], mass [kg] and length [m] of all candidates, corrected by the ratings.

        The mass is that of the estimate unless the rated candidates are `weighed`.
        """
        limits, mass, length = dict(self.estimated.limits), self.estimated.mass, self.estimated.length
        if not self.rated:
            return limits, mass, length
        rows = list(self.rated)
        weight = 1.0 / (((self.points[:, None] - self.points[rows]) ** 2).sum(axis=2) + 1e-9) ** 2
        weight /= weight.sum(axis=1, keepdims=True) + SETTINGS.prior

        def factor(key: str, guess: Array) -> Array:
            unsound = UNSOUND if key == "other" else 1.0
            true = [_figure(one, key) if one else unsound * guess[row] for row, one in self.rated.items()]
            return np.asarray(
                np.exp(weight @ np.log(np.clip(np.array(true) / np.maximum(guess[rows], 1e-9), 0.05, 20.0)))
            )

        limits = {key: limit * factor(key, limit) for key, limit in limits.items()}
        if weighed:
            mass = mass * factor("mass", mass)
        return limits, mass, length * factor("length", length)

    def under(self, requirement: Requirement) -> "Pool":
        """Return the same candidates under other conditions: life, speed, share of the time, cooling."""
        sample = self.sample.but(**conditions(requirement))
        before, after = (
            estimate(conditioned, self.sizes, drive.design).limits
            for conditioned, drive in ((self.requirement, self.sample), (requirement, sample))
        )
        limits, mass, length = self.corrected()
        scaled = {key: limit * after[key] / np.maximum(before[key], 1e-9) for key, limit in limits.items()}
        return Pool(requirement, sample, self.factors, self.points, self.sizes, DriveEstimate(scaled, mass, length))

    def exists(self, torque: float, length: float = math.inf) -> bool:
        """Return whether a candidate for a torque [N m] within a length [m] is found."""
        largest = self.largest(length, torque)
        return largest is not None and largest.capacity >= torque

    def largest(
        self, length: float = math.inf, enough: float = math.inf, ratings: int = SETTINGS.ratings
    ) -> Rated | None:
        """Find the candidate of the largest capacity within a length [m], or the first with enough of it [N m]."""
        return self._best(
            lambda capacity, mass, length: -capacity,
            lambda capacity, size: size <= length,
            lambda _: True,
            -enough,
            ratings,
        )

    def lightest(self, torque: float, length: float = math.inf, accept: Accept = lambda _: True) -> Rated | None:
        """Find the lightest candidate for a torque [N m] within a length [m]."""
        return self._best(
            lambda capacity, mass, length: mass,
            lambda capacity, size: (capacity >= torque) & (size <= length),
            accept,
            weighed=True,
        )

    def shortest(self, torque: float) -> Rated | None:
        """Find the shortest candidate for a torque [N m]."""
        return self._best(
            lambda capacity, mass, length: length, lambda capacity, size: capacity >= torque, lambda _: True
        )

    def _best(
        self,
        objective: Objective,
        meets: Meets,
        accept: Accept,
        enough: float = -math.inf,
        ratings: int = SETTINGS.ratings,
        *,
        weighed: bool = False,
    ) -> Rated | None:
        """Rate the candidate with the best corrected estimate until none is left that could be better."""
        rejected: set[int] = set()
        rounds = 0
        for _ in range(ratings):
            limits, mass, length = self.corrected(weighed=weighed)
            capacity = np.min(list(limits.values()), axis=0)
            value, feasible = objective(capacity, mass, length), meets(capacity, length)
            known = self._known(objective, meets, rejected, weighed)
            if known:
                index, best = known
                if best <= enough:
                    break
                feasible &= value < best + SETTINGS.margin * abs(best)
            feasible[list(self.rated)] = False
            if feasible.any():
                chosen = int(np.argmin(np.where(feasible, value, np.inf)))
                self.rate(chosen, max(float(capacity[chosen]), 1e-6))
            elif known and not accept(self._of(index)):
                rejected.add(index)
            elif known and rounds < SETTINGS.rounds:
                rounds += 1
                self._extend(index)
            else:
                break
        while known := self._known(objective, meets, rejected, weighed):
            if accept(self._of(known[0])):
                return self._of(known[0])
            rejected.add(known[0])
        return None

    def _extend(self, index: int) -> None:
        """Add neighbours of a candidate: changes of a single variable, for a local search by estimates and ratings."""
        steps = np.concatenate([sign * np.geomspace(0.01, 0.3, 8) for sign in (-1.0, 1.0)])
        changes = (np.eye(DIMENSIONS)[:, np.newaxis] * steps[:, np.newaxis]).reshape(-1, DIMENSIONS)
        points = np.clip(self.points[index] + changes, 0.0, 1.0 - 1e-9)
        sizes = decode(self.requirement, points)
        points, sizes = points[sizes.valid], _rows(sizes, sizes.valid)
        guess = estimate(self.requirement, sizes, self.sample.design).scaled(self.factors)
        self.points = np.concatenate([self.points, points])
        self.sizes = _joined(self.sizes, sizes)
        self.estimated = self.estimated.joined(guess)

    def _of(self, index: int) -> Rated:
        rated = self.rated[index]
        assert rated
        return rated

    def _known(self, objective: Objective, meets: Meets, rejected: set[int], weighed: bool) -> tuple[int, float] | None:
        """Return the best rated candidate and its objective; None if no rated candidate is feasible."""
        rows = [index for index, one in self.rated.items() if one and index not in rejected]
        rated = [self._of(row) for row in rows]
        numbers = np.array([(one.capacity, one.mass if weighed else 0.0, one.length) for one in rated])
        if not rows:
            return None
        value = np.where(meets(numbers[:, 0], numbers[:, 2]), objective(*numbers.T), np.inf)
        best = int(np.argmin(value))
        return (rows[best], float(value[best])) if np.isfinite(value[best]) else None


@lru_cache(maxsize=32)
def pool_of(requirement: Requirement) -> Pool | None:
    """Return the elites of a requirement without its limits of torque, length and backlash; None if there are none.

    The estimates of a first archive are calibrated item by item with some of its elites, for a second archive.
    """
    sample = first_drive(requirement)
    if not sample:
        return None
    first = _illuminate(requirement, sample, {})
    limits, _, _ = first.corrected()
    capacity = np.min(list(limits.values()), axis=0)
    order = np.argsort(capacity)[len(capacity) // 4 :]
    for index in order[np.linspace(0, len(order) - 1, SETTINGS.calibrations).astype(int)]:
        first.rate(int(index), float(capacity[index]))
    known = {index: rated for index, rated in first.rated.items() if rated}
    factors: dict[str, float] = {}
    guesses = {**limits, "mass": first.estimated.mass, "length": first.estimated.length}
    for key, limit in guesses.items() if known else ():
        ratios = [np.clip(_figure(one, key) / limit[index], 0.05, 20.0) for index, one in known.items()]
        factors[key] = float(np.exp(np.median(np.log(ratios))))
    return _illuminate(requirement, sample, factors)


def first_drive(requirement: Requirement) -> Reducer | None:
    """Return the first drive of the sequence that can be built, for its materials and friction."""
    sizes, guess = decode(requirement, _sequence(SETTINGS.start)), 1e3 * requirement.diameter**3
    drives = (build_drive(requirement, sizes.row(int(index)), guess) for index in np.flatnonzero(sizes.valid)[:200])
    return next((drive for drive in drives if drive), None)


def _sequence(count: int) -> Array:
    """Return the first points of the R sequence in the unit cube (Roberts, 2018): steps by powers of a golden ratio."""
    ratio = 2.0
    for _ in range(50):
        ratio = (1.0 + ratio) ** (1.0 / (DIMENSIONS + 1))
    return np.asarray((0.5 + np.arange(1, count + 1)[:, np.newaxis] / ratio ** np.arange(1, DIMENSIONS + 1)) % 1.0)


def _illuminate(requirement: Requirement, sample: Reducer, factors: Mapping[str, float]) -> Pool:
    """Run MAP-Elites on the estimates, each torque limit times the factor of its item."""
    random = np.random.default_rng(0)
    points, elites = _sequence(SETTINGS.start), np.empty((0, DIMENSIONS))
    for _ in range(SETTINGS.generations + 1):
        points = np.concatenate([elites, points])
        sizes = decode(requirement, points)
        points, sizes = points[sizes.valid], _rows(sizes, sizes.valid)
        guess = estimate(requirement, sizes, sample.design).scaled(factors)
        limits = guess.limits
        capacity = np.min(list(limits.values()), axis=0)
        strong = np.flatnonzero(capacity > SETTINGS.weakest * capacity.max())
        order = strong[np.argsort(guess.mass[strong], kind="stable")]
        cell = np.floor(SETTINGS.cells * np.log(np.stack([capacity[order], guess.length[order]], axis=1)))
        kept = np.sort(order[np.unique(cell, axis=0, return_index=True)[1]])
        elites, sizes = points[kept], _rows(sizes, kept)
        guess = guess.rows(kept)
        parents, others = random.integers(len(elites), size=(2, SETTINGS.children))
        along = SETTINGS.line * random.standard_normal((SETTINGS.children, 1))
        about = SETTINGS.scatter * random.standard_normal((SETTINGS.children, DIMENSIONS))
        points = np.clip(elites[parents] + about + along * (elites[others] - elites[parents]), 0.0, 1.0 - 1e-9)
    return Pool(requirement, sample, factors, elites, sizes, guess)


def _joined(first: Sizes, second: Sizes) -> Sizes:
    return Sizes(*(np.concatenate([getattr(first, one.name), getattr(second, one.name)]) for one in fields(Sizes)))


def _rows(sizes: Sizes, rows: Integers | Mask) -> Sizes:
    return Sizes(*(getattr(sizes, one.name)[rows] for one in fields(Sizes)))
