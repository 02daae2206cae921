"""The search: elites of closed-form estimates, rated by statics as far as they could be the best."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Self

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
from cycloid_mj.sizing.candidates import (
    DIMENSIONS,
    Sizes,
    build_drive,
    casing_of,
    decode,
    design_of,
)
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
    ratings, few_ratings, studies
        Most candidates that a search rates (0.15 s of CPU each), that of a remedy or for efficiency rates, and most
        tolerance studies (0.5 s each).
    strong
        Candidates of each estimate of the torque among which remedies are searched.
    likely
        Share of a torque that estimates promise at least where candidates are rated for it.
    margin, torque_margin, reach
        Error of an estimate at this distance in the cube from the nearest rated candidate, and beyond: candidates that
        could be better by it are rated (confidence bounds, Srinivas et al., arXiv:0912.3995). The second one is for the
        largest torque, whose estimates are less accurate than those of mass and length.
    gain
        Least relative improvement for which a candidate is rated.
    mass_tolerance
        The most efficient drive is chosen among those whose mass is larger than the lowest by at most this share.
    study_share
        Torque of a tolerance study over the capacity that is expected, where the required torque is larger.
    build_share
        Time to build a candidate that cannot be rated over that of a rating.
    poses
        Crank angles of a rating: capacities differ by up to 2 % from those at 121 angles.
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
    ratings: int = 20
    few_ratings: int = 8
    strong: int = 60
    studies: int = 8
    likely: float = 0.7
    margin: float = 0.08
    torque_margin: float = 0.25
    reach: float = 0.3
    gain: float = 0.03
    mass_tolerance: float = 0.02
    study_share: float = 0.97
    build_share: float = 0.2
    poses: int = 61
    min_yield: float = 99.0


SETTINGS = SearchSettings()

UNSOUND = 0.3
"""Factor of estimates next to a candidate that cannot be built or balanced."""

Figures = Mapping[str, float]
Point = tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Rated:
    """A drive rated at a torque [N m]: its rating, figures by the keys of the estimate, capacity, and weakest item.

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

    def known(self, keys: Iterable[str]) -> dict[str, float]:
        """Return its figures by the keys of an estimate; ``other`` is the smallest torque limit of other items."""
        others = [limit for item, limit in self.figures.items() if item not in keys]
        figures = self.figures if not others else {**self.figures, "other": min(others)}
        return {key: figures[key] for key in keys if key in figures}


def rate_drive(
    requirement: Requirement, reducer: Reducer, torque: float, sample: int | None = None, poses: int = POSES
) -> Rated | None:
    """Rate a drive within its tolerances at a torque [N m] under the conditions of a requirement.

    The tooth forces are the governing ones of parts within the tolerances, as in `rate`, or with `sample` those of the
    tolerance sample with this index. They are computed at `poses` crank angles of a turn. The result has torque limits
    by item [N m], mass [kg], length [m] and, if the requirement limits it, backlash [arcmin]. It is None if the drive
    has no equilibrium, all samples jam, or a part does not fit.
    """
    loaded = reducer.with_nominal_torque(torque)
    design, zones = loaded.design, tolerance_zones(loaded)
    try:
        if zones and sample is not None:
            design = sample_design(loaded, zones, SAMPLES.seed, sample)
        parts: Parts = "toleranced" if zones and sample is None else "perfect"
        rating = rate(design, requirement.duty_at(torque), requirement.life, poses=poses, parts=parts)
        low, high = casing_of(requirement, loaded).ends
        figures = {"mass": drive_mass(loaded), "length": high - low}
        if requirement.backlash < math.inf:
            figures["backlash"] = figure("backlash_arcmin").value(Reducer(design))
    except CycloidError:
        return None
    limits = torque_limits((item for item in rating.items.values() if item.decisive), torque, requirement.life)
    return Rated(loaded, torque, {**limits, **figures}, min(limits.values()), rating.items)


def rate_candidate(requirement: Requirement, sizes: Sizes, torque: float) -> Rated | None:
    """Rate a candidate at its capacity (the torque that it carries), or at the required torque if that is smaller.

    The capacity depends on the torque of the rating, because more teeth carry at larger loads. So the rating is
    repeated at the capacity of the previous rating (fixed-point iteration). Tooth forces are those of a critical sample
    of the tolerances.

    Parameters
    ----------
    requirement
        Conditions of the rating, and the required torque.
    sizes
        Dimensions of the candidate.
    torque
        Torque of the first rating [N m].

    Returns
    -------
    Rated or None
        The rated drive; None if the candidate cannot be built, or has no equilibrium.
    """
    most = requirement.torque
    reducer, rated = build_drive(requirement, sizes, min(torque, most)), None
    if not reducer:
        return None
    sample = find_critical_sample(reducer)
    for _ in range(SETTINGS.iterations):
        load = min(torque, most)
        drive = rate_drive(requirement, reducer, load, sample, SETTINGS.poses)
        rated, torque = drive or rated, drive.capacity if drive else UNSOUND * load
        if drive and (load == most <= torque or abs(math.log(torque / load)) < SETTINGS.consistency):
            break
    return rated


def tolerance_study(requirement: Requirement, reducer: Reducer) -> Figures:
    """Compute yield and backlash of a drive over samples of its tolerances: key -> value.

    The keys are ``turning_percent``, the share of samples that do not jam [%]; ``yield_percent``, the share that also
    has a backlash within the limit [%]; ``backlash_arcmin``, the median; and ``backlash_p05_arcmin``, p95 and p99, the
    percentiles of the backlash.
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
    """Return the excess of candidates over the required length or backlash, relative to the limit; 0 within both."""
    length, backlash = figures["length"] / requirement.length, figures["backlash"] / requirement.backlash
    return np.asarray(np.maximum(np.maximum(length, backlash) - 1.0, 0.0))


def strongest(requirement: Requirement) -> Objective:
    """Return an objective whose minimum is the drive with the largest capacity within the limits of a requirement.

    Its value is minus the capacity [N m]. If a drive exceeds the required length or backlash, it is this excess, a
    positive number (`violation`). Without any capacity, it is infinite.
    """

    def objective(figures: Estimate) -> Array:
        torque, excess = capacity(figures), violation(requirement, figures)
        return np.where(torque > 0.0, np.where(excess > 0.0, excess, -torque), np.inf)

    return objective


def lightest(requirement: Requirement) -> Objective:
    """Return the objective of the lowest mass of candidates that meet a requirement."""
    return lambda figures: np.where(_suits(requirement, figures), -1.0 / figures["mass"], np.inf)


def shortest(requirement: Requirement) -> Objective:
    """Return the objective of the smallest length of candidates that meet a requirement, whatever length it allows."""
    free = requirement.but(length=math.inf)
    return lambda figures: np.where(_suits(free, figures), -1.0 / figures["length"], np.inf)


def most_efficient(requirement: Requirement, mass: float) -> Objective:
    """Return the objective of the lowest loss of candidates up to a mass [kg]: of the highest torque limit by heat."""
    return lambda figures: np.where(
        _suits(requirement, figures) & (figures["mass"] <= mass), -figures["temperature"], np.inf
    )


def _suits(requirement: Requirement, figures: Estimate) -> Mask:
    return np.asarray((capacity(figures) >= requirement.torque) & (violation(requirement, figures) <= 0.0))


@dataclass(eq=False)
class Pool:
    """Candidates under the conditions of a requirement, and their ratings so far, which correct the estimates.

    `guess` are the estimates of all candidates. `rated` has None where a candidate cannot be built or balanced, or
    jams. By the point of a rated candidate, `corrections` has the logarithms of its figures over their estimates, and
    `biases` those of its capacity and its backlash by a tolerance study over those by one sample.
    """

    requirement: Requirement
    points: Array
    sizes: Sizes
    guess: Estimate
    corrections: dict[Point, Figures] = field(default_factory=dict)
    biases: dict[Point, tuple[float, float]] = field(default_factory=dict)
    rated: dict[int, Rated | None] = field(default_factory=dict)

    @classmethod
    def of(cls, requirement: Requirement, points: Array) -> Self | None:
        """Return the candidates at points of the cube; None if there are no parts for any of them."""
        points, sizes = decode(requirement, points)
        return cls(requirement, points, sizes, _estimate(requirement, sizes)) if len(points) else None

    def changed(self, requirement: Requirement) -> Self | None:
        """Return these candidates under a changed requirement, without ratings; both share their corrections."""
        pool = self.of(requirement, self.points)
        return pool and replace(pool, corrections=self.corrections, biases=self.biases)

    @property
    def strong_part(self) -> Self:
        """The candidates with the largest estimated torques as a pool of their own, without their ratings.

        For each of the torques of `_capacities`, these are the `SETTINGS.strong` best of all candidates, and the
        `SETTINGS.strong` best of those within the limits of length and backlash.
        """
        figures = self.corrected
        within = violation(self.requirement, figures) <= 0.0
        ranks = [np.argsort(-torque * share) for torque in _capacities(figures) for share in (1.0, within)]
        rows = np.unique(np.concatenate([rank[: SETTINGS.strong] for rank in ranks]))
        sizes = self.sizes[rows].view(np.recarray)
        return replace(self, points=self.points[rows], sizes=sizes, guess=_estimate(self.requirement, sizes), rated={})

    @property
    def corrected(self) -> Estimate:
        """The estimates, corrected by the ratings nearby; capacities and backlash are those of a tolerance study."""
        records = [*self.corrections.values()]
        values = np.reshape([[record.get(key, 0.0) for key in self.guess] for record in records], (-1, len(self.guess)))
        factors = dict(zip(self.guess, np.exp(_interpolate(self.points, self.corrections, values)).T, strict=True))
        studied = self.study_factors
        return {key: studied.get(key, 1.0) * factors[key] * guess for key, guess in self.guess.items()}

    @property
    def study_factors(self) -> Mapping[str, Array]:
        """Expected ratios of torque limits and backlash by a tolerance study to those by one sample, by key.

        Figures that a study does not change are left out.
        """
        values = np.reshape([*self.biases.values()], (-1, 2))
        torque, backlash = np.exp(_interpolate(self.points, self.biases, values)).T
        return {key: torque for key in self.guess if key not in FIGURES} | {"backlash": backlash}

    @property
    def promise(self) -> float:
        """Largest corrected estimate of the torque within the limits [N m]."""
        figures = self.corrected
        return float(np.max(capacity(figures) * (violation(self.requirement, figures) <= 0.0)))

    def lightest(self) -> Rated | None:
        """Return the most efficient of the drives whose mass is close to the lowest, after its tolerance study.

        It is None if no drive passes.
        """
        for study in (False, True):
            first = self.best(lightest(self.requirement), study=study)
            if not first:
                break
            mass = (1.0 + SETTINGS.mass_tolerance) * first.figures["mass"]
            if drive := self.best(most_efficient(self.requirement, mass), max_ratings=SETTINGS.few_ratings):
                return drive
        return None

    def best(
        self,
        objective: Objective,
        goal: float = -math.inf,
        *,
        only_goal: bool = False,
        study: bool = True,
        max_ratings: int = SETTINGS.ratings,
        margin: float = SETTINGS.margin,
    ) -> Rated | None:
        """Return the drive with the smallest `objective`, or the first that reaches `goal`; None if there is none.

        1. The candidate with the best estimate is rated, again and again, until no estimate is better than the best
           rated drive, or `max_ratings` candidates are rated.
        2. Neighbours of the best rated candidate, which differ in one variable, are added once and rated in the same
           manner.
        3. With `study`, the tolerance study of the best drive follows. If it fails, the search continues with the next
           best.

        The goal is a value of the objective; with `only_goal`, candidates whose estimate does not reach it are not
        rated. A drive that exceeds the required length or backlash is returned if no other is left.
        """
        ratings, studies, extended = 0.0, 0, set[int]()
        while True:
            values, known, torque = self._values(objective, margin)
            row = int(np.argmin(np.where(known, values, np.inf)))
            best = float(values[row]) if known[row] else math.inf
            better = best - SETTINGS.gain * abs(best) if math.isfinite(best) else best
            limit = goal if self.rated else SETTINGS.likely * goal
            open_rows = ~known & (values < better) & ((values <= limit) | (not only_goal))
            drive = self.rated.get(row)
            if best > goal and open_rows.any() and ratings < max_ratings:
                new = int(np.argmin(np.where(open_rows, values, np.inf)))
                is_rated = self._rate(new, max(float(torque[new]), 1e-3 * self.requirement.torque))
                ratings += 1.0 if is_rated else SETTINGS.build_share
            elif not drive or not math.isfinite(best):
                return None
            elif best > goal and row not in extended and ratings < max_ratings:
                extended.add(row)
                self._extend(row)
            elif only_goal and best > goal:
                return None
            elif best > 0.0 or drive.passed or not study:
                return drive
            elif studies == SETTINGS.studies:
                passed = [index for index, drive in self.rated.items() if drive and drive.passed]
                return self.rated[min(passed, key=lambda index: values[index])] if passed else None
            else:
                studies += 1
                self.study(row)

    def _rate(self, row: int, torque: float) -> bool:
        """Rate the candidate `row` and store the result; return whether it could be rated.

        `torque` is the torque of its first rating [N m]. The logarithms of the ratios of rated to estimated figures are
        stored in `corrections`.
        """
        self.rated[row] = drive = rate_candidate(self.requirement, self.sizes[row], torque)
        true = drive.known(self.guess) if drive else {"other": UNSOUND * float(self.guess["other"][row])}
        self.corrections[tuple(self.points[row])] = {
            key: float(np.log(np.clip(value / max(self.guess[key][row], 1e-9), 0.05, 20.0)))
            for key, value in true.items()
        }
        return drive is not None

    def study(self, row: int) -> Rated | None:
        """Rate the candidate `row` with its tolerance study, and store and return the result.

        The torque is the required one, or the largest that the candidate is expected to carry. If a study shows that
        such a torque was too large, it is repeated once at a torque by a secant step with the slope 1/3: when the
        torque is reduced, a capacity limited by pitting falls by a third to a half of the reduction, because fewer
        teeth are in contact, and a capacity limited by bearings is constant. The result is None if too many samples
        jam.
        """
        drive, required = self.rated[row], self.requirement.torque
        if not drive:
            return None
        expected = float(self.study_factors["other"][row]) * drive.capacity
        if drive.study:
            expected = _secant_torque(drive)
        torque = required if expected >= required else floor_digits(SETTINGS.study_share * expected)
        full = self._study_at(drive.reducer, torque)
        if full and torque < required <= full.capacity:
            full = self._study_at(drive.reducer, required)
        elif full and full.capacity < torque < required:
            full = self._study_at(drive.reducer, floor_digits(SETTINGS.study_share * _secant_torque(full)))
        if full and not drive.study:
            backlash = full.figures["backlash"] / drive.figures.get("backlash", full.figures["backlash"])
            self.biases[tuple(self.points[row])] = math.log(full.capacity / drive.capacity), math.log(backlash)
        self.rated[row] = full
        return full

    def nearer_to_capacity(self, drive: Rated) -> Rated:
        """Repeat the study of a drive at a larger torque, nearer to its capacity; return the drive that passed last."""
        torque = floor_digits(min(SETTINGS.study_share * drive.capacity, self.requirement.torque))
        full = self._study_at(drive.reducer, torque) if torque > drive.torque else None
        return full if full and full.passed else drive

    def _study_at(self, reducer: Reducer, torque: float) -> Rated | None:
        """Rate a drive with toleranced parts at a torque [N m], and add its tolerance study to the result.

        The backlash becomes the 99th percentile of the study, and `passed` says whether the drive carries the torque
        and enough samples are good. The result is None if the drive cannot be rated, or if too many samples jam (see
        `SETTINGS.min_yield`).
        """
        full = rate_drive(self.requirement, reducer, torque)
        study = tolerance_study(self.requirement, full.reducer) if full else {}
        if not full or study["turning_percent"] < SETTINGS.min_yield:
            return None
        passed = full.capacity >= torque and study["yield_percent"] >= SETTINGS.min_yield
        return replace(
            full, figures={**full.figures, "backlash": study["backlash_p99_arcmin"]}, study=study, passed=passed
        )

    def _values(self, objective: Objective, margin: float) -> tuple[Array, Mask, Array]:
        """Evaluate an objective for all n candidates, both rated and only estimated.

        `margin` is the largest relative error of an estimate.

        Returns
        -------
        tuple
            The objective, which assumes the favourable end of the error of an estimate; whether the candidate is rated;
            and its estimated capacity [N m]; shape (n,) each.
        """
        known = np.zeros(len(self.points), bool)
        known[list(self.rated)] = True
        errors, likely, studied = np.full(len(self.points), margin), self.corrected, self.study_factors
        if self.corrections:
            errors *= np.minimum(cdist(self.points, list(self.corrections)).min(axis=1) / SETTINGS.reach, 1.0)
        figures = {key: values * (1.0 - errors if key in FIGURES else 1.0 + errors) for key, values in likely.items()}
        for row, drive in self.rated.items():
            for key, value in drive.known(self.guess).items() if drive else dict.fromkeys(figures, math.nan).items():
                figures[key][row] = value * (
                    studied[key][row] if key in studied and not (drive and drive.study) else 1.0
                )
        values = objective(figures)
        return np.where(np.isnan(values), np.inf, values), known, capacity(likely)

    def _extend(self, index: int) -> None:
        """Add the neighbours of a candidate to the pool, for a local search; each differs from it in a single variable.

        `index` is the index of the candidate. Neighbours that are in the pool already are not added.
        """
        steps = np.concatenate([sign * np.geomspace(*SETTINGS.neighbours) for sign in (-1.0, 1.0)])
        changes = (np.eye(DIMENSIONS)[:, np.newaxis] * steps[:, np.newaxis]).reshape(-1, DIMENSIONS)
        points, sizes = decode(self.requirement, np.clip(self.points[index] + changes, 0.0, 1.0 - 1e-9))
        _, first = np.unique(np.concatenate([self.sizes, sizes]), return_index=True)
        new = first[first >= len(self.sizes)] - len(self.sizes)
        self.points = np.concatenate([self.points, points[new]])
        self.sizes = np.concatenate([self.sizes, sizes[new]]).view(np.recarray)
        self.guess = _estimate(self.requirement, self.sizes)


def _interpolate(points: Array, known: Iterable[Point], values: Array) -> Array:
    """Interpolate the logarithms of m factors at n points by inverse distances (Shepard's method), shape (n, m).

    `points` (n, `DIMENSIONS`) are the n points, and `values` (k, m) are the logarithms at the k points `known`. Far
    from all known points, the result approaches the median of the known values and two zeros (factors of 1), which
    limits the influence of a single exceptional candidate.
    """
    places = np.reshape(list(known), (-1, DIMENSIONS))
    weight = 1.0 / (cdist(points, places, "sqeuclidean") + 1e-9) ** 2
    weight /= weight.sum(axis=1, keepdims=True) + SETTINGS.reach**-4
    middle = np.median(np.concatenate([np.zeros((2, values.shape[1])), values]), axis=0)
    return np.asarray(weight @ values + (1.0 - weight.sum(axis=1, keepdims=True)) * middle)


def _secant_torque(drive: Rated) -> float:
    """Return the torque [N m] at which a drive that was rated at too large a torque is expected to equal its capacity.

    It is at least half of the capacity.
    """
    return max(1.5 * drive.capacity - 0.5 * drive.torque, 0.5 * drive.capacity)


def floor_digits(value: float) -> float:
    """Round down to three digits."""
    scale = 10.0 ** (math.floor(math.log10(value)) - 2)
    return significant(math.floor(value / scale) * scale)


def pool_of(requirement: Requirement, source: Pool | None = None) -> Pool | None:
    """Return the pool of the elites for a requirement, under its conditions; None if no drive can be built.

    It shares the corrections of the pool `source`, if there is one.
    """
    pool = Pool.of(requirement, _find_elites(requirement.kind))
    return replace(pool, corrections=source.corrections, biases=source.biases) if pool and source else pool


def _estimate(requirement: Requirement, sizes: Sizes) -> Estimate:
    """Estimate candidates of a requirement, with materials and friction of the design of the first."""
    return estimate(requirement, sizes, design_of(requirement, sizes[0]))


@lru_cache(maxsize=32)
def _find_elites(kind: Requirement) -> Array:
    """Find a diverse set of good candidates for a `Requirement.kind` by MAP-Elites on the estimates.

    MAP-Elites keeps the best candidate (elite) of each cell of torque and length. There is an archive of cells for each
    of `_capacities`, so that the elites include good candidates for any conditions.

    Returns
    -------
    Array
        Points of the elites in the unit cube (`decode`), shape (k, `DIMENSIONS`); k = 0 if no drive can be built.
    """
    if not first_drive(kind):
        return np.empty((0, DIMENSIONS))
    random = np.random.default_rng(0)
    points, sizes = decode(kind, _sequence(SETTINGS.start))
    for _ in range(SETTINGS.generations):
        parents = points[_elites(_estimate(kind, sizes))]
        chosen, others = random.integers(len(parents), size=(2, SETTINGS.children))
        along = SETTINGS.line * random.standard_normal((SETTINGS.children, 1))
        about = SETTINGS.scatter * random.standard_normal((SETTINGS.children, DIMENSIONS))
        children = parents[chosen] + about + along * (parents[others] - parents[chosen])
        points, sizes = decode(kind, np.concatenate([parents, np.clip(children, 0.0, 1.0 - 1e-9)]))
    return points[_elites(_estimate(kind, sizes))]


def _elites(guess: Estimate) -> Integers:
    """Return the indices of the elites: the lightest candidate of each cell of torque and length.

    `guess` are the estimates of all candidates. There are elites for each of the torques of `_capacities`.
    """
    chosen = []
    for torque in _capacities(guess):
        strong = np.flatnonzero(torque > SETTINGS.weakest * torque.max())
        order = strong[np.argsort(guess["mass"][strong], kind="stable")]
        cell = np.floor(SETTINGS.cells * np.log(np.stack([torque[order], guess["length"][order]], axis=1)))
        chosen.append(order[np.unique(cell, axis=0, return_index=True)[1]])
    return np.unique(np.concatenate(chosen))


def _capacities(guess: Estimate) -> list[Array]:
    """Return the torque limits by all items, without that of the temperature, and by strength alone [N m]."""
    by_life = tuple(key for key in guess if not (is_momentary(key) or is_strength(key)))
    left_out = ((), ("temperature", "other"), by_life)
    return [np.where(guess["other"] > 0.0, capacity(guess, keys), 0.0) for keys in left_out]


def first_drive(requirement: Requirement) -> Reducer | None:
    """Return the first drive of the sequence that can be built; None if there is none."""
    guess = 1e3 * requirement.diameter**3
    _, sizes = decode(requirement, _sequence(SETTINGS.start))
    return next((drive for row in sizes[:200] if (drive := build_drive(requirement, row, guess))), None)


def _sequence(count: int) -> Array:
    """Return the first points of the R sequence in the unit cube (Roberts, 2018): steps by powers of a golden ratio."""
    ratio = 2.0
    for _ in range(50):
        ratio = (1.0 + ratio) ** (1.0 / (DIMENSIONS + 1))
    return np.asarray((0.5 + np.arange(1, count + 1)[:, np.newaxis] / ratio ** np.arange(1, DIMENSIONS + 1)) % 1.0)
