"""The search: elites of closed-form estimates, rated by statics as far as they could be the best."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from scipy.spatial.distance import cdist

from cycloid_mj.base.array import Array, Integers, Mask, significant
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.explore.sampling import sample_design, tolerance_zones
from cycloid_mj.figures import figure
from cycloid_mj.life.as_built import SETTINGS as SAMPLES
from cycloid_mj.life.as_built import Parts, find_critical_sample, select_rated_samples
from cycloid_mj.life.figures import drive_mass
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.items import rate
from cycloid_mj.life.loading import POSES
from cycloid_mj.life.rated import is_momentary, is_strength, torque_limits
from cycloid_mj.reducer import Reducer
from cycloid_mj.sizing.candidates import DIMENSIONS, Sizes, build_drive, casing_of, conditions, decode
from cycloid_mj.sizing.estimate import FIGURES, Estimate, capacity, estimate
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
    neighbours
        Smallest and largest change of a single variable about a good candidate, in the unit cube, and their number in
        each direction, in a geometric series.
    iterations, consistency
        Ratings of a candidate at most, and the largest logarithm of its capacity over the torque of the last.
    calibrations, ratings, studies
        Candidates that are rated first, the most ratings of a search (0.2 s of CPU each), and the most tolerance
        studies of a search (2 s each).
    likely
        Share of a torque that an estimate promises at least where candidates are rated for it.
    calibration_share
        Torque of the first ratings over the estimates. These are for perfect parts: within their tolerances, drives are
        rated for about a third.
    margin, reach
        Error of an estimate at this distance in the cube from the nearest rated candidate, and beyond: candidates that
        could be better by it are rated (confidence bounds, Srinivas et al., arXiv:0912.3995).
    gain
        Least relative improvement for which a candidate is rated.
    study_share
        Torque of a tolerance study over the capacity that is expected, where the required torque is larger.
    build_share
        Time to build a candidate that cannot be rated, or is too long, over that of a rating.
    poses
        Crank angles of a rating: capacities differ by 3 % from those of the data sheet.
    min_yield
        Smallest share of the samples of a drive within its tolerances that turn and have the required backlash [%].
    """

    start: int = 2048
    children: int = 1024
    generations: int = 6
    cells: float = 25.0
    weakest: float = 0.02
    scatter: float = 0.02
    line: float = 0.2
    neighbours: tuple[float, float, int] = (0.02, 0.5, 8)
    iterations: int = 3
    consistency: float = 0.2
    calibrations: int = 4
    ratings: int = 30
    studies: int = 4
    likely: float = 0.7
    calibration_share: float = 0.3
    margin: float = 0.08
    reach: float = 0.3
    gain: float = 0.01
    study_share: float = 0.96
    poses: int = 61
    build_share: float = 0.2
    min_yield: float = 99.0


SETTINGS = SearchSettings()

UNSOUND = 0.3
"""Factor of estimates next to a candidate that cannot be built or balanced."""

Figures = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Rated:
    """A drive rated at a torque [N m]: its rating, figures by the keys of the estimate, capacity, and weakest item.

    A drive that is too long has only the figures of its size, and neither a rating nor a weakest item.
    `study` has yield [%] and backlash [arcmin] of the tolerance study; it is empty before. A drive that `passed` it
    carries the torque.
    """

    reducer: Reducer
    torque: float
    figures: Figures
    capacity: float
    items: Mapping[str, RatedItem] = field(default_factory=dict)
    study: Figures = field(default_factory=dict)
    passed: bool = False

    @property
    def life(self) -> float:
        """Shortest life of its parts [h]."""
        lives = [item.life for item in self.items.values() if item.decisive]
        return min((life for life in lives if life is not None), default=math.inf)

    @property
    def weakest(self) -> RatedItem:
        """The item that limits the torque."""
        limits = {key: limit for key, limit in self.figures.items() if key in self.items}
        return self.items[min(limits, key=lambda key: limits[key])]

    def complete(self, guess: Estimate, row: int) -> dict[str, float]:
        """Return the figures of an estimate in a row, as far as they are known those of the drive.

        The item ``other`` is the smallest torque limit of items that are not estimated.
        """
        others = [limit for item, limit in self.figures.items() if item not in guess]
        known = self.figures if not others else {**self.figures, "other": min(others)}
        return {key: known.get(key, float(values[row])) for key, values in guess.items()}


def rate_drive(
    requirement: Requirement, reducer: Reducer, torque: float, sample: int | None = None, poses: int = POSES
) -> Rated | None:
    """Rate a drive within its tolerances at a torque [N m] under the conditions of a requirement.

    As `cycloid-mj rate` does, by the samples at the percentile of the largest forces, or by a `sample` with a number.
    None if it has no equilibrium, all samples jam, or a part does not fit.
    """
    loaded = reducer.with_nominal_torque(torque)
    design, zones = loaded.design, tolerance_zones(loaded)
    parts: Parts = "toleranced" if zones and sample is None else "perfect"
    try:
        if zones and sample is not None:
            design = sample_design(loaded, zones, SAMPLES.seed, sample)
        rating = rate(design, requirement.duty_at(torque), requirement.life, poses=poses, parts=parts)
        low, high = casing_of(requirement, loaded).ends
        figures = {"mass": drive_mass(loaded), "length": high - low}
        if requirement.backlash < math.inf:
            figures["backlash"] = figure("backlash_arcmin").value(Reducer(design))
    except CycloidError:
        return None
    limits = torque_limits((item for item in rating.items.values() if item.decisive), torque, requirement.life)
    return Rated(loaded, torque, {**limits, **figures}, min(limits.values()), rating.items)


def rate_candidate(requirement: Requirement, sizes: Sizes, torque: float, most: float = math.inf) -> Rated | None:
    """Rate a candidate at its capacity or at `most` [N m], by a fixed-point iteration from a torque [N m].

    More teeth carry at larger loads, so that capacities by a rating far from them would be wrong. The errors are those
    of its sample with a critical tooth force. None if it cannot be built, or has no equilibrium.
    """
    reducer, rated = build_drive(requirement, sizes, min(torque, most)), None
    if not reducer:
        return None
    low, high = casing_of(requirement, reducer).ends
    if high - low > requirement.length:
        return Rated(reducer, torque, {"length": high - low}, torque)
    sample = find_critical_sample(reducer)
    for _ in range(SETTINGS.iterations):
        load = min(torque, most)
        one = rate_drive(requirement, reducer, load, sample, SETTINGS.poses)
        rated, torque = one or rated, one.capacity if one else UNSOUND * load
        if one and (load == most <= torque or abs(math.log(torque / load)) < SETTINGS.consistency):
            break
    return rated


def tolerance_study(requirement: Requirement, reducer: Reducer) -> Figures:
    """Compute the yield of a drive within its tolerances [%], and median and 5 to 95 % of its backlash [arcmin].

    A sample is good if it does not jam and its backlash is within the limit.
    """
    if tolerance_zones(reducer):
        samples = select_rated_samples(reducer)
        jams, backlash = samples.jams, samples.backlash
    else:
        jams, backlash = np.zeros(1, bool), np.array([figure("backlash_arcmin").value(reducer)])
    good = ~jams & (backlash <= requirement.backlash)
    keys = {"backlash_arcmin": 50.0} | {f"backlash_p{share:02.0f}_arcmin": share for share in (5.0, 95.0, 99.0)}
    percentiles = dict(zip(keys, np.percentile(backlash[~jams], [*keys.values()]).tolist(), strict=True))
    shares = {"turning_percent": 100.0 * float((~jams).mean()), "yield_percent": 100.0 * float(good.mean())}
    return shares | percentiles


Objective = Callable[[Estimate], Array]
"""What to minimize: negative where candidates meet all limits, else positive; infinite where they are excluded."""


def violation(requirement: Requirement, figures: Estimate) -> Array:
    """Return by how much candidates exceed the required length or backlash, relative to them; 0 within both."""
    length, backlash = figures["length"] / requirement.length, figures["backlash"] / requirement.backlash
    return np.asarray(np.maximum(np.maximum(length, backlash) - 1.0, 0.0))


def strongest(requirement: Requirement) -> Objective:
    """Return an objective to minimise: minus the capacity [N m], or the violation of length and backlash, if any.

    It is infinite without capacity.
    """

    def objective(figures: Estimate) -> Array:
        torque, excess = capacity(figures), violation(requirement, figures)
        return np.where(torque > 0.0, np.where(excess > 0.0, excess, -torque), np.inf)

    return objective


def lightest(requirement: Requirement) -> Objective:
    """Return the objective of the lowest mass of candidates that meet a requirement."""

    def objective(figures: Estimate) -> Array:
        suits = (capacity(figures) >= requirement.torque) & (violation(requirement, figures) <= 0.0)
        return np.where(suits, -1.0 / figures["mass"], np.inf)

    return objective


@dataclass(frozen=True, eq=False)
class Archive:
    """Elites of a kind of drive: points of the cube, sizes, a drive, and factors of the estimates by item."""

    points: Array
    sizes: Sizes
    drive: Reducer
    factors: Figures


@dataclass(eq=False)
class Pool:
    """Candidates under the conditions of a requirement, and their ratings so far, which correct the estimates.

    `rated` has None where a candidate cannot be built or balanced, or jams. `ratios` are those of capacities by
    tolerance studies to those by one sample.
    """

    requirement: Requirement
    archive: Archive
    points: Array
    sizes: Sizes
    guess: Estimate
    rated: dict[int, Rated | None] = field(default_factory=dict)
    ratios: list[float] = field(default_factory=list)

    @property
    def bias(self) -> float:
        """Mean ratio of a capacity by a tolerance study to that by one sample, with 1 as the first."""
        return math.exp(sum(map(math.log, self.ratios)) / (len(self.ratios) + 1))

    def factors(self, points: Array) -> dict[str, Array]:
        """Return the factors of estimates at points by the ratings nearby (Shepard's inverse distance weighting)."""
        if not self.rated:
            return {key: np.ones(len(points)) for key in self.guess}
        rows = list(self.rated)
        weight = 1.0 / (cdist(points, self.points[rows], "sqeuclidean") + 1e-9) ** 2
        weight /= weight.sum(axis=1, keepdims=True) + 1.0
        factors, known = {}, {row: one.complete(self.guess, row) for row, one in self.rated.items() if one}
        for key, guess in self.guess.items():
            unsound = UNSOUND if key == "other" else 1.0
            true = [known[row][key] if row in known else unsound * guess[row] for row in rows]
            factors[key] = np.exp(weight @ _log_ratio(np.array(true), guess[rows]))
        return factors

    def promise(self, changed: Requirement) -> float:
        """Return the largest capacity [N m] of a changed requirement by estimates with the factors of the ratings."""
        same = (changed.process, changed.made_of) == (self.requirement.process, self.requirement.made_of)
        drive = self.archive.drive if same else first_drive(changed)
        points, sizes = decode(changed, self.points)
        if not drive or not len(points):
            return 0.0
        factors, guess = self.factors(points), scaled_estimate(changed, sizes, drive, self.archive.factors)
        guess = {key: factors.get(key, 1.0) * values for key, values in guess.items()}
        return float(np.max(self.bias * capacity(guess) * (violation(changed, guess) <= 0.0)))

    def best(
        self, objective: Objective, goal: float = -math.inf, *, only_goal: bool = False, study: bool = True
    ) -> Rated | None:
        """Return the drive with the least objective that passes its tolerance study, or the first within a `goal`.

        The candidate with the best estimate is rated until none is left that could be better than the best rated one.
        Changes of a single variable of the latter follow, then its tolerance study unless it is left out. A drive that
        violates a limit is returned where no other remains. With `only_goal`, candidates beyond the goal are left out.
        """
        ratings, studies, extended = 0.0, 0, set[int]()
        while True:
            values, known, torque = self._values(objective)
            row = int(np.argmin(np.where(known, values, np.inf)))
            best = float(values[row]) if known[row] else math.inf
            better = best - SETTINGS.gain * abs(best) if math.isfinite(best) else best
            limit = goal if ratings >= SETTINGS.calibrations else SETTINGS.likely * goal
            open_rows = ~known & (values < better) & ((values <= limit) | (not only_goal))
            one = self.rated.get(row)
            if best > goal and open_rows.any() and ratings < SETTINGS.ratings:
                new = int(np.argmin(np.where(open_rows, values, np.inf)))
                start, most = max(float(torque[new]), 1e-6), self.requirement.torque
                self.rated[new] = drive = rate_candidate(self.requirement, self.sizes[new], start, most)
                ratings += 1.0 if drive and drive.items else SETTINGS.build_share
            elif not one or not math.isfinite(best):
                return None
            elif best > goal and row not in extended and ratings < SETTINGS.ratings:
                extended.add(row)
                self._extend(row)
            elif only_goal and best > goal:
                return None
            elif best > 0.0 or one.passed or not study:
                return one
            elif studies == SETTINGS.studies:
                passed = [index for index, drive in self.rated.items() if drive and drive.passed]
                return self.rated[min(passed, key=lambda index: values[index])] if passed else None
            else:
                studies += 1
                self.rated[row] = self.study(one)

    def study(self, one: Rated) -> Rated | None:
        """Rate a drive as on its design file, at the required torque or the most it carries.

        After a study at too much torque, the next is far below, as capacities by pitting fall nearly with the torque.
        None if samples jam.
        """
        ratio = (one.capacity / one.torque) ** 2 if one.study else self.bias
        torque = min(self.requirement.torque, floor_digits(SETTINGS.study_share * min(ratio, 1.0) * one.capacity))
        full = rate_drive(self.requirement, one.reducer, torque)
        if full and full.capacity >= self.requirement.torque > torque:
            torque = self.requirement.torque
            full = rate_drive(self.requirement, one.reducer, torque)
        study = tolerance_study(self.requirement, full.reducer) if full else {}
        if not full or study["turning_percent"] < SETTINGS.min_yield:
            return None
        self.ratios += [] if one.study else [full.capacity / one.capacity]
        passed = full.capacity >= torque and study["yield_percent"] >= SETTINGS.min_yield
        figures = {**full.figures, "backlash": study["backlash_p99_arcmin"]}
        return replace(full, figures=figures, study=study, passed=passed)

    def _values(self, objective: Objective) -> tuple[Array, Mask, Array]:
        """Return the objective of each candidate, whether it is rated, and its estimated capacity [N m].

        Objectives of estimates are optimistic by their error.
        """
        known = np.zeros(len(self.points), bool)
        known[list(self.rated)] = True
        errors = np.full(len(self.points), SETTINGS.margin)
        if self.rated:
            errors *= np.minimum(cdist(self.points, self.points[known]).min(axis=1) / SETTINGS.reach, 1.0)
        factors = self.factors(self.points)
        likely = {key: guess * factors[key] for key, guess in self.guess.items()}
        figures = {
            key: values * (1.0 - errors if key in FIGURES else (1.0 + errors) * self.bias)
            for key, values in likely.items()
        }
        for row, one in self.rated.items():
            known_figures = one.complete(self.guess, row) if one else dict.fromkeys(figures, math.nan)
            for key, value in known_figures.items():
                figures[key][row] = value * (1.0 if key in FIGURES or (one and one.study) else self.bias)
        values = objective(figures)
        return np.where(np.isnan(values), np.inf, values), known, capacity(likely)

    def _extend(self, index: int) -> None:
        """Add neighbours of a candidate: changes of a single variable, for a local search by estimates and ratings."""
        steps = np.concatenate([sign * np.geomspace(*SETTINGS.neighbours) for sign in (-1.0, 1.0)])
        changes = (np.eye(DIMENSIONS)[:, np.newaxis] * steps[:, np.newaxis]).reshape(-1, DIMENSIONS)
        points, sizes = decode(self.requirement, np.clip(self.points[index] + changes, 0.0, 1.0 - 1e-9))
        _, first = np.unique(np.concatenate([self.sizes, sizes]), return_index=True)
        new = first[first >= len(self.sizes)] - len(self.sizes)
        points, sizes = points[new], sizes[new].view(np.recarray)
        guess = scaled_estimate(self.requirement, sizes, self.archive.drive, self.archive.factors)
        self.points = np.concatenate([self.points, points])
        self.sizes = np.concatenate([self.sizes, sizes]).view(np.recarray)
        self.guess = {key: np.concatenate([values, guess[key]]) for key, values in self.guess.items()}


def floor_digits(value: float) -> float:
    """Round down to three digits."""
    scale = 10.0 ** (math.floor(math.log10(value)) - 2)
    return significant(math.floor(value / scale) * scale)


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
    points, sizes = decode(kind, _sequence(SETTINGS.start))
    for generation in range(SETTINGS.generations + 1):
        guess = scaled_estimate(kind, sizes, drive, factors)
        elites = _elites(guess)
        points, sizes = points[elites], sizes[elites].view(np.recarray)
        if generation == SETTINGS.generations:
            break
        if generation == SETTINGS.generations // 2:
            factors = _calibrate(kind, sizes, {key: values[elites] for key, values in guess.items()})
        parents, others = random.integers(len(points), size=(2, SETTINGS.children))
        along = SETTINGS.line * random.standard_normal((SETTINGS.children, 1))
        about = SETTINGS.scatter * random.standard_normal((SETTINGS.children, DIMENSIONS))
        children = points[parents] + about + along * (points[others] - points[parents])
        born, bred = decode(kind, np.clip(children, 0.0, 1.0 - 1e-9))
        points, sizes = np.concatenate([points, born]), np.concatenate([sizes, bred]).view(np.recarray)
    return Archive(points, sizes, drive, factors)


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


def _calibrate(kind: Requirement, sizes: Sizes, guess: Estimate) -> dict[str, float]:
    """Return the median ratio of ratings to estimates by item, of some candidates of the upper three quarters."""
    torque = capacity(guess)
    order = np.argsort(torque)[len(torque) // 4 :]
    rows = order[np.linspace(0, len(order) - 1, SETTINGS.calibrations).astype(int)].tolist()
    rated = {row: rate_candidate(kind, sizes[row], SETTINGS.calibration_share * float(torque[row])) for row in rows}
    true = {row: one.complete(guess, row) for row, one in rated.items() if one}
    return {
        key: float(np.exp(np.median([_log_ratio(figures[key], values[row]) for row, figures in true.items()])))
        for key, values in guess.items()
        if true
    }


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
