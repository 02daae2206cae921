"""The search: elites of closed-form estimates, corrected by ratings of the candidates that matter."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from scipy.spatial.distance import cdist

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.explore.sampling import sample_design, tolerance_zones
from cycloid_mj.life.as_built import SETTINGS as SAMPLES
from cycloid_mj.life.as_built import Parts, find_critical_sample
from cycloid_mj.life.figures import drive_mass
from cycloid_mj.life.item import RatedItem, Rating
from cycloid_mj.life.items import rate
from cycloid_mj.life.loading import POSES
from cycloid_mj.life.rated import is_momentary, is_strength, torque_limits
from cycloid_mj.reducer import Reducer
from cycloid_mj.sizing.candidates import DIMENSIONS, Sizes, build_drive, casing_of, conditions, decode
from cycloid_mj.sizing.estimate import Estimate, capacity, estimate
from cycloid_mj.sizing.requirement import Requirement


@dataclass(frozen=True)
class SearchSettings:
    """Settings of the search; none of them decides what a drive withstands.

    Attributes
    ----------
    start, children, generations
        Points of the R sequence, children of each generation and their number: 0.6 s of CPU.
    cells, weakest
        Cells per factor e of torque and of length (neighbours differ by 4 %), and the least torque relative to the
        largest.
    scatter, line
        Standard deviations of a child about its parent and along the line to another elite, as recommended.
    calibrations, ratings
        Elites that are rated first, and the most ratings of a search: 0.1 s of CPU each.
    calibration_share
        Torque of the first ratings over the estimates. These are for perfect parts: within their tolerances, drives are
        rated for about half.
    margin, reach
        Error of an estimate at this distance in the cube from the nearest rated candidate, and beyond: candidates that
        could be better by it are rated (confidence bounds, Srinivas et al., arXiv:0912.3995).
    poses
        Crank angles of a rating: capacities differ by 3 % from those of the data sheet.
    """

    start: int = 2048
    children: int = 1024
    generations: int = 6
    cells: float = 25.0
    weakest: float = 0.02
    scatter: float = 0.02
    line: float = 0.2
    calibrations: int = 6
    calibration_share: float = 0.5
    ratings: int = 24
    margin: float = 0.08
    reach: float = 0.1
    poses: int = 61


SETTINGS = SearchSettings()

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

    @cached_property
    def mass(self) -> float:
        """Mass of the drive [kg], from the solids of all parts; infinite if a part does not fit."""
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

    def figure(self, key: str) -> float:
        """Return a figure of the estimate: the torque limit of an item [N m], mass [kg] or length [m]."""
        return self.mass if key == "mass" else self.figures.get(key, NO_LIMIT)


def load_drive(reducer: Reducer, torque: float) -> Reducer:
    """Return a drive whose nominal torque is an output torque [N m], and its power in proportion."""
    drive, needed = reducer.design.drive, torque / reducer.design.reduction
    return reducer.but(drive={"torque": needed, "power": drive.power * needed / drive.torque})


def rate_drive(
    requirement: Requirement,
    reducer: Reducer,
    torque: float,
    estimated: tuple[str, ...] = (),
    poses: int = POSES,
    sample: int | None = None,
) -> Rated | None:
    """Rate a drive within its tolerances at a torque [N m] under the conditions of a requirement.

    As `cycloid-mj rate` does, by the samples at the percentile of the largest forces, or by a `sample` with a number.
    None if it has no equilibrium, or all samples jam.
    """
    loaded = load_drive(reducer, torque)
    design, zones = loaded.design, tolerance_zones(loaded)
    parts: Parts = "toleranced" if zones and sample is None else "perfect"
    try:
        if zones and sample is not None:
            design = sample_design(loaded, zones, SAMPLES.seed, sample)
        rating = rate(design, requirement.duty_at(torque), requirement.life, poses=poses, parts=parts)
        low, high = casing_of(requirement, loaded).ends
    except CycloidError:
        return None
    items = {key: item for key, item in rating.items.items() if item.decisive}
    limits = torque_limits(items.values(), torque, requirement.life)
    other = min((limit for key, limit in limits.items() if key not in estimated), default=NO_LIMIT)
    weakest = min(limits, key=lambda key: limits[key])
    figures = {**limits, "other": other, "length": high - low}
    return Rated(loaded, torque, rating, figures, limits[weakest], items[weakest])


def rate_candidate(
    requirement: Requirement, sizes: Sizes, torque: float, estimated: tuple[str, ...], sample: int | None
) -> Rated | None:
    """Rate a `sample` of a candidate at a torque [N m] near its capacity, or at less without equilibrium.

    None if it cannot be built, or has no equilibrium at either torque.
    """
    reducer = build_drive(requirement, sizes, torque)
    if not reducer:
        return None
    tries = (
        rate_drive(requirement, reducer, share * torque, estimated, SETTINGS.poses, sample) for share in (1.0, UNSOUND)
    )
    return next((rated for rated in tries if rated), None)


Objective = Callable[[Array, Array, Array], Array]
Meets = Callable[[Array, Array], Mask]
"""What to minimize by capacity, mass and length, and which capacities and lengths are feasible."""

Accept = Callable[[Rated], bool]
"""Whether a rated candidate meets what no estimate has."""


@dataclass(frozen=True, eq=False)
class Archive:
    """Elites of a kind of drive: points of the cube, sizes, a drive, and factors of the estimates by item.

    All candidates are rated with the errors of the same `sample` within the tolerances, by its number: capacities
    differ by up to 10 % from those by the samples at the percentile of the loads of each.
    """

    points: Array
    sizes: Sizes
    drive: Reducer
    factors: Mapping[str, float]
    sample: int | None


@dataclass(eq=False)
class Pool:
    """Candidates under the conditions of a requirement, and their ratings so far, which correct the estimates."""

    requirement: Requirement
    archive: Archive
    points: Array
    sizes: Sizes
    guess: Estimate
    rated: dict[int, Rated | None] = field(default_factory=dict)
    """Ratings by index; None where a candidate cannot be built or balanced."""

    def corrected(self, *, weigh: bool = False) -> Estimate:
        """Return the estimates times the factors of the ratings nearby (Shepard's inverse distance weighting).

        The mass is that of the estimate unless the rated candidates are to be weighed.
        """
        if not self.rated:
            return self.guess
        rows = list(self.rated)
        weight = 1.0 / (cdist(self.points, self.points[rows], "sqeuclidean") + 1e-9) ** 2
        weight /= weight.sum(axis=1, keepdims=True) + 1.0

        def factor(key: str, guess: Array) -> Array:
            unsound = UNSOUND if key == "other" else 1.0
            true = [one.figure(key) if one else unsound * guess[row] for row, one in self.rated.items()]
            return np.asarray(np.exp(weight @ _log_ratio(np.array(true), guess[rows])))

        return {
            key: guess * factor(key, guess) if weigh or key != "mass" else guess for key, guess in self.guess.items()
        }

    def capacities_under(self, changed: Requirement) -> Array:
        """Compute the capacities of the rated candidates under changed conditions, in proportion to estimates [N m]."""
        rated = {row: one for row, one in self.rated.items() if one and one.length <= changed.length}
        sizes, drive = self.sizes[[*rated]].view(np.recarray), self.archive.drive
        before, after = (scaled_estimate(wanted, sizes, drive, {}) for wanted in (self.requirement, changed))
        limits = {
            key: np.array([one.figure(key) for one in rated.values()]) * after[key] / np.maximum(before[key], 1e-9)
            for key in after
            if key not in ("mass", "length")
        }
        return capacity(limits) if rated else np.empty(0)

    def largest(
        self, length: float, enough: float = math.inf, accept: Accept = lambda _: True, give_up: float = 0.0
    ) -> Rated | None:
        """Find the candidate of the largest capacity within a length [m], or the first with enough of it [N m].

        It ends where no estimate, corrected by some ratings, promises a torque of `give_up` [N m].
        """
        return self._best(
            lambda torque, mass, size: -torque, lambda torque, size: size <= length, accept, -enough, -give_up
        )

    def lightest(self, torque: Callable[[], float], length: float, accept: Accept) -> Rated | None:
        """Find the lightest candidate for a torque [N m], which may grow meanwhile, within a length [m]."""
        return self._best(
            lambda limit, mass, size: mass,
            lambda limit, size: (limit >= torque()) & (size <= length),
            accept,
            weigh=True,
        )

    def shortest(self, torque: float) -> Rated | None:
        """Find the shortest candidate for a torque [N m]."""
        return self._best(lambda limit, mass, size: size, lambda limit, size: limit >= torque, lambda _: True)

    def _best(
        self,
        objective: Objective,
        meets: Meets,
        accept: Accept,
        enough: float = -math.inf,
        give_up: float = math.inf,
        *,
        weigh: bool = False,
    ) -> Rated | None:
        """Rate the candidate with the best corrected estimate until none is left that could be better."""
        rejected, extended, ratings = set[int](), set[int](), SETTINGS.ratings
        while True:
            known = self._known(objective, meets, rejected, weigh)
            if known and known[1] <= enough and accept(self._of(known[0])):
                return self._of(known[0])
            if known and known[1] <= enough:
                rejected.add(known[0])
                continue
            guess = self.corrected(weigh=weigh)
            torque = capacity(guess)
            value, feasible = objective(torque, guess["mass"], guess["length"]), meets(torque, guess["length"])
            value = value - self._errors() * np.abs(value)
            feasible = feasible & (value < known[1]) if known else feasible.copy()
            feasible[list(self.rated)] = False
            feasible &= (value <= give_up) | (SETTINGS.ratings - ratings < SETTINGS.calibrations)
            started = SETTINGS.ratings - ratings >= SETTINGS.calibrations or not feasible.any()
            if ratings and started and known and known[0] not in extended and known[1] <= give_up:
                extended.add(known[0])
                self._extend(known[0])
            elif ratings and feasible.any():
                index = int(np.argmin(np.where(feasible, value, np.inf)))
                limit = max(float(torque[index]), 1e-6)
                keys = tuple(self.guess)
                self.rated[index] = rate_candidate(
                    self.requirement, self.sizes[index], limit, keys, self.archive.sample
                )
                ratings -= self.rated[index] is not None
            elif not known:
                return None
            elif accept(self._of(known[0])):
                return self._of(known[0])
            else:
                rejected.add(known[0])

    def _errors(self) -> Array:
        """Return the relative errors of the estimates by their distance from the rated candidates, shape (n,)."""
        if not self.rated:
            return np.zeros(len(self.points))
        nearest = cdist(self.points, self.points[list(self.rated)]).min(axis=1)
        return np.asarray(SETTINGS.margin * np.minimum(nearest / SETTINGS.reach, 1.0))

    def _extend(self, index: int) -> None:
        """Add neighbours of a candidate: changes of a single variable, for a local search by estimates and ratings."""
        steps = np.concatenate([sign * np.geomspace(0.02, 0.5, 8) for sign in (-1.0, 1.0)])
        changes = (np.eye(DIMENSIONS)[:, np.newaxis] * steps[:, np.newaxis]).reshape(-1, DIMENSIONS)
        points, sizes = decode(self.requirement, np.clip(self.points[index] + changes, 0.0, 1.0 - 1e-9))
        _, first = np.unique(np.concatenate([self.sizes, sizes]), return_index=True)
        new = first[first >= len(self.sizes)] - len(self.sizes)
        points, sizes = points[new], sizes[new].view(np.recarray)
        guess = scaled_estimate(self.requirement, sizes, self.archive.drive, self.archive.factors)
        self.points = np.concatenate([self.points, points])
        self.sizes = np.concatenate([self.sizes, sizes]).view(np.recarray)
        self.guess = {key: np.concatenate([values, guess[key]]) for key, values in self.guess.items()}

    def _of(self, index: int) -> Rated:
        rated = self.rated[index]
        assert rated
        return rated

    def _known(self, objective: Objective, meets: Meets, rejected: set[int], weigh: bool) -> tuple[int, float] | None:
        """Return the best rated candidate and its objective; None if no rated candidate is feasible."""
        rows = [index for index, one in self.rated.items() if one and index not in rejected]
        rated = [self._of(row) for row in rows]
        numbers = np.array([(one.capacity, one.mass if weigh else 0.0, one.length) for one in rated])
        if not rows:
            return None
        value = np.where(meets(numbers[:, 0], numbers[:, 2]), objective(*numbers.T), np.inf)
        best = int(np.argmin(value))
        return (rows[best], float(value[best])) if np.isfinite(value[best]) else None


def pool_of(requirement: Requirement) -> Pool | None:
    """Return the elites of the kind of drive that is required, under its conditions; None if there are none."""
    archive = archive_of(requirement.kind)
    if not archive:
        return None
    guess = scaled_estimate(requirement, archive.sizes, archive.drive, archive.factors)
    return Pool(requirement, archive, archive.points, archive.sizes, guess)


def scaled_estimate(requirement: Requirement, sizes: Sizes, drive: Reducer, factors: Mapping[str, float]) -> Estimate:
    """Estimate candidates under the conditions of a requirement, each figure times its factor."""
    design = drive.but(**conditions(requirement)).design
    return {key: factors.get(key, 1.0) * guess for key, guess in estimate(requirement, sizes, design).items()}


@lru_cache(maxsize=32)
def archive_of(kind: Requirement) -> Archive | None:
    """Run MAP-Elites on the estimates of a kind of drive; None if none can be built.

    So that the elites serve all conditions, an archive each has the lightest candidates by all items, without the limit
    of temperature, and by strength alone. Halfway, ratings of some elites calibrate the estimates item by item.
    """
    drive = first_drive(kind)
    if not drive:
        return None
    random, factors = np.random.default_rng(0), dict[str, float]()
    sample: int | None = None
    points, sizes = decode(kind, _sequence(SETTINGS.start))
    for generation in range(SETTINGS.generations + 1):
        guess = scaled_estimate(kind, sizes, drive, factors)
        elites = _elites(guess)
        points, sizes = points[elites], sizes[elites].view(np.recarray)
        if generation == SETTINGS.generations:
            break
        if generation == SETTINGS.generations // 2:
            factors, sample = _calibrate(kind, sizes, {key: values[elites] for key, values in guess.items()})
        parents, others = random.integers(len(points), size=(2, SETTINGS.children))
        along = SETTINGS.line * random.standard_normal((SETTINGS.children, 1))
        about = SETTINGS.scatter * random.standard_normal((SETTINGS.children, DIMENSIONS))
        children = points[parents] + about + along * (points[others] - points[parents])
        born, bred = decode(kind, np.clip(children, 0.0, 1.0 - 1e-9))
        points, sizes = np.concatenate([points, born]), np.concatenate([sizes, bred]).view(np.recarray)
    return Archive(points, sizes, drive, factors, sample)


def _elites(guess: Estimate) -> Integers:
    """Return the lightest candidate of each cell of torque and length, by all items and by some."""
    by_life = [key for key in guess if not (is_momentary(key) or is_strength(key))]
    chosen = []
    for left_out in ((), ("temperature", "other"), tuple(by_life)):
        torque = np.where(guess["other"] > 0.0, capacity(guess, left_out), 0.0)
        strong = np.flatnonzero(torque > SETTINGS.weakest * torque.max())
        order = strong[np.argsort(guess["mass"][strong], kind="stable")]
        cell = np.floor(SETTINGS.cells * np.log(np.stack([torque[order], guess["length"][order]], axis=1)))
        chosen.append(order[np.unique(cell, axis=0, return_index=True)[1]])
    return np.unique(np.concatenate(chosen))


def _calibrate(kind: Requirement, sizes: Sizes, guess: Estimate) -> tuple[dict[str, float], int | None]:
    """Return the median ratio of ratings to estimates by item, of some candidates of the upper three quarters.

    The second item is the number of the sample that is rated, the critical one of the middle candidate.
    """
    torque = capacity(guess)
    loads = SETTINGS.calibration_share * torque
    order = np.argsort(torque)[len(torque) // 4 :]
    rows = order[np.linspace(0, len(order) - 1, SETTINGS.calibrations).astype(int)].tolist()
    middle = rows[len(rows) // 2]
    reducer = build_drive(kind, sizes[middle], float(loads[middle]))
    sample = find_critical_sample(reducer) if reducer else 0
    rated = {row: rate_candidate(kind, sizes[row], float(loads[row]), tuple(guess), sample) for row in rows}
    known = {row: one for row, one in rated.items() if one}
    factors = {
        key: float(np.exp(np.median([_log_ratio(one.figure(key), values[row]) for row, one in known.items()])))
        for key, values in guess.items()
        if known
    }
    return factors, sample


def _log_ratio(true: Array | float, guess: Array) -> Array:
    """Return the logarithm of rated over estimated figures, within a factor of 20."""
    return np.asarray(np.log(np.clip(true / np.maximum(guess, 1e-9), 0.05, 20.0)))


def first_drive(requirement: Requirement) -> Reducer | None:
    """Return the first drive of the sequence that can be built, for its materials and friction."""
    guess = 1e3 * requirement.diameter**3
    _, sizes = decode(requirement, _sequence(SETTINGS.start))
    return next((drive for row in sizes[:200] if (drive := build_drive(requirement, row, guess))), None)


def _sequence(count: int) -> Array:
    """Return the first points of the R sequence in the unit cube (Roberts, 2018): steps by powers of a golden ratio."""
    ratio = 2.0
    for _ in range(50):
        ratio = (1.0 + ratio) ** (1.0 / (DIMENSIONS + 1))
    return np.asarray((0.5 + np.arange(1, count + 1)[:, np.newaxis] / ratio ** np.arange(1, DIMENSIONS + 1)) % 1.0)
