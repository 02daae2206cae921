"""The search: elites of closed-form estimates, rated by statics as far as they could be the best."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import islice
from typing import Self

import numpy as np
from scipy.spatial.distance import cdist

from cycloid_mj.base.array import Array, Integers, significant
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.design import Design, Material
from cycloid_mj.design.processes import TOLERANCE_SHARE
from cycloid_mj.explore.sampling import sample_design, tolerance_zones
from cycloid_mj.figures import figure
from cycloid_mj.life.as_built import SETTINGS as SAMPLES
from cycloid_mj.life.as_built import Parts, find_critical_sample, find_likely_critical_samples, select_rated_samples
from cycloid_mj.life.estimate import FIGURES, FIRST_TORQUE, Estimate, Sizes, add_capacity, capacity, estimate
from cycloid_mj.life.figures import drive_mass
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.items import rate
from cycloid_mj.life.loading import POSES
from cycloid_mj.life.rated import is_momentary, is_strength, torque_limits
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.reducer import Reducer
from cycloid_mj.sizing.candidates import (
    DIMENSIONS,
    assemble_drive,
    build_drive,
    decode,
    design_of,
)
from cycloid_mj.sizing.objective import Objective, lightest, most_efficient, strongest
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
        Most candidates that a search rates (0.06 to 0.2 s of CPU each), that of a remedy or for efficiency rates, and
        most tolerance studies (0.6 to 4 s each).
    strong
        Candidates of each estimate of the torque among which remedies are searched.
    likely
        Share of a torque that estimates promise at least where candidates are rated for it.
    reach
        Distance in the cube from the nearest rated candidate beyond which estimates have their full error.
    first_error, least_error
        Errors of estimates before any rating, and next to a rated candidate, as shares of `DEVIATIONS`.
    min_improvement, min_probability
        Smallest expected improvement (relative), and smallest probability that a candidate meets all limits while none
        is known, for which candidates are rated.
    mass_tolerance
        The most efficient drive is chosen among those whose mass is larger than the lowest by at most this share.
    study_share
        Torque of a tolerance study over the expected capacity, where the required torque is larger; and required torque
        over the expected capacity at which the search for a drive ends with a study.
    build_share
        Time to build a candidate that cannot be rated over that of a rating.
    poses
        Crank angles of a rating: capacities differ by up to 2 % from those at 121 angles.
    reference_drives
        Drives that determine the tolerance samples among which that of each rating is found.
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
    ratings: int = 40
    few_ratings: int = 8
    strong: int = 60
    studies: int = 8
    likely: float = 0.7
    reach: float = 0.3
    first_error: float = 3.0
    least_error: float = 0.1
    min_improvement: float = 0.01
    min_probability: float = 0.02
    mass_tolerance: float = 0.02
    study_share: float = 0.97
    build_share: float = 0.2
    poses: int = 61
    reference_drives: int = 3
    min_yield: float = 99.0


SETTINGS = SearchSettings()

UNSOUND = 0.3
"""Factor of estimates next to a candidate that cannot be built or balanced (heuristic)."""

Figures = Mapping[str, float]
Point = tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Rated:
    """A drive rated at a torque [N m]: its rating, figures by the keys of the estimate, capacity, and weakest item.

    `study` has yield [%] and backlash [arcmin] of the tolerance study; it is empty before. A drive that `passed` it
    carries the torque; `too_large` is a torque [N m] at which its study failed before.
    """

    reducer: Reducer
    torque: float
    figures: Figures
    capacity: float
    items: Mapping[str, RatedItem] = field(default_factory=dict)
    study: Figures = field(default_factory=dict)
    passed: bool = False
    too_large: float = math.inf

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
        """Return its quantities by the keys of an estimate; ``other`` is the smallest torque limit of other items."""
        others = [limit for item, limit in self.figures.items() if item not in keys]
        figures = self.figures if not others else {**self.figures, "other": min(others)}
        return {key: figures[key] for key in keys if key in figures}


def rate_drive(
    requirement: Requirement, reducer: Reducer, torque: float, sample: int | None = None, poses: int = POSES
) -> Rated | None:
    """Compute the torque limits of a drive within its tolerances at a torque [N m] and the required conditions.

    The result has torque limits by part and kind of failure [N m], mass [kg], length [m] and, if the requirement limits
    it, backlash [arcmin]. It is None if the drive has no equilibrium, all samples jam, or a part does not fit.

    Parameters
    ----------
    requirement
        Requirement with the conditions, such as speed and life.
    reducer, torque
        The drive, and its output torque [N m].
    sample
        Index of the tolerance sample that determines the tooth forces; emergency stops and joints of metal drives are
        then left out, and heat is rated with the friction at 20 °C instead of that in the steady state, which would
        take three times as long. By default, the rating is that of `rate`, within the tolerances.
    poses
        Number of crank angles of a turn at which tooth forces are computed.
    """
    loaded = reducer.with_nominal_torque(torque)
    design, zones = loaded.design, tolerance_zones(loaded)
    try:
        if zones and sample is not None:
            design = sample_design(loaded, zones, SAMPLES.seed, sample)
        parts: Parts = "toleranced" if zones and sample is None else "perfect"
        with_stops = sample is None or Material(name=requirement.made_of).is_plastic
        rating = rate(
            design,
            requirement.duty_at(torque),
            requirement.life,
            poses=poses,
            stops=with_stops,
            parts=parts,
            steady=sample is None,
        )
        low, high = casing(loaded, requirement.motor).ends
        figures = {"mass": drive_mass(loaded), "length": high - low}
        if requirement.backlash < math.inf:
            figures["backlash"] = figure("backlash_arcmin").value(Reducer(design))
    except CycloidError:
        return None
    limits = torque_limits((item for item in rating.items.values() if item.decisive), torque, requirement.life)
    return Rated(loaded, torque, {**limits, **figures}, min(limits.values()), rating.items)


def rate_candidate(requirement: Requirement, sizes: Sizes, torque: float, samples: Sequence[int] = ()) -> Rated | None:
    """Compute the torque limits of a candidate at its capacity, or at the required torque if that is smaller.

    The capacity is the torque that it carries. It depends on the torque of the computation, because more teeth carry at
    larger loads. So the computation is repeated at the capacity of the previous one (fixed-point iteration). Emergency
    stops and joints of metal drives are left to the tolerance study: they take half of the time, and seldom limit the
    torque.

    Parameters
    ----------
    requirement
        Requirement with the conditions and the torque.
    sizes
        Dimensions of the candidate.
    torque
        Torque of the first computation [N m].
    samples
        Numbers of the tolerance samples of which the critical one determines the tooth forces (`find_critical_sample`).

    Returns
    -------
    Rated or None
        The drive with its torque limits; None if the candidate cannot be built, or has no equilibrium.
    """
    max_torque = requirement.torque
    reducer, rated = build_drive(requirement, sizes, min(torque, max_torque)), None
    if not reducer:
        return None
    sample = find_critical_sample(reducer, samples)
    for _ in range(SETTINGS.iterations):
        load = min(torque, max_torque)
        drive = rate_drive(requirement, reducer, load, sample, SETTINGS.poses)
        rated, torque = drive or rated, drive.capacity if drive else UNSOUND * load
        if drive and (load == max_torque <= torque or abs(math.log(torque / load)) < SETTINGS.consistency):
            break
    return rated


def tolerance_study(requirement: Requirement, reducer: Reducer) -> Figures:
    """Compute yield and backlash of a drive over samples of its tolerances: key -> value.

    `requirement` limits the backlash. The keys are ``turning_percent``, the share of samples that do not jam [%];
    ``yield_percent``, the share that also has a backlash within the limit [%]; ``backlash_arcmin``, the median; and
    ``backlash_p05_arcmin``, p95 and p99, the percentiles of the backlash.
    """
    if tolerance_zones(reducer):
        samples = select_rated_samples(reducer)
        jams, backlash = samples.jams, samples.backlash
    else:
        jams, backlash = np.zeros(1, bool), np.array([figure("backlash_arcmin").value(reducer)])
    is_good = ~jams & (backlash <= requirement.backlash)
    keys = {"backlash_arcmin": 50.0} | {f"backlash_p{rank:02.0f}_arcmin": rank for rank in (5.0, 95.0, 99.0)}
    percentiles = dict(zip(keys, np.percentile(backlash[~jams], [*keys.values()]).tolist(), strict=True))
    percentages = {"turning_percent": 100.0 * float((~jams).mean()), "yield_percent": 100.0 * float(is_good.mean())}
    return percentages | percentiles


@dataclass(eq=False)
class Pool:
    """Set of candidate drives for a requirement, with their estimates, and the ratings so far, which correct these.

    `guess` are the estimates of all candidates. `rated` has None where a candidate cannot be built or balanced, or
    jams. The tooth forces of ratings are those of one of the tolerance `samples`. By the point of a rated candidate,
    `corrections` has the logarithms of its figures over their estimates, and `biases` those of its capacity and its
    backlash by a tolerance study over those by the one sample. `extended` are the candidates whose neighbours were
    added.
    """

    requirement: Requirement
    points: Array
    sizes: Sizes
    guess: Estimate
    samples: tuple[int, ...] = ()
    corrections: dict[Point, Figures] = field(default_factory=dict)
    biases: dict[Point, tuple[float, float]] = field(default_factory=dict)
    rated: dict[int, Rated | None] = field(default_factory=dict)
    extended: set[int] = field(default_factory=set)

    @classmethod
    def of(cls, requirement: Requirement, points: Array) -> Self | None:
        """Return the candidates at points of the cube; None if there are no parts for any of them."""
        points, sizes = decode(requirement, points)
        return cls(requirement, points, sizes, _estimate(requirement, sizes)) if len(points) else None

    def changed(self, requirement: Requirement) -> Self | None:
        """Return these candidates for a changed requirement, without ratings, but with the corrections of estimates."""
        if requirement.kind == self.requirement.kind:  # the sizes are the same
            guess = _estimate(requirement, self.sizes)
            return replace(self, requirement=requirement, guess=guess, rated={}, extended=set())
        pool = self.of(requirement, self.points)
        return pool and replace(pool, samples=self.samples, corrections=self.corrections, biases=self.biases)

    @property
    def strong_part(self) -> Self:
        """Return the candidates with the largest estimated torques as a new pool, without computed limits.

        For each kind of torque limit (`_capacities`), these are the `SETTINGS.strong` best of all candidates, and the
        `SETTINGS.strong` best of those within the limits of length and backlash.
        """
        figures = self.corrected
        is_within = strongest(self.requirement).excess(figures) <= 0.0
        ranks = [np.argsort(-torque * weights) for torque in _capacities(figures) for weights in (1.0, is_within)]
        rows = np.unique(np.concatenate([rank[: SETTINGS.strong] for rank in ranks]))
        sizes = self.sizes[rows].view(np.recarray)
        return replace(
            self,
            points=self.points[rows],
            sizes=sizes,
            guess=_estimate(self.requirement, sizes),
            rated={},
            extended=set(),
        )

    @property
    def corrected(self) -> Estimate:
        """Return the estimates of all candidates, corrected by the computed torque limits of similar ones.

        The key ``capacity`` has the smallest torque limit. The estimates include the expected effect of a tolerance
        study (`study_factors`).
        """
        records = [*self.corrections.values()]
        values = np.reshape([[record.get(key, 0.0) for key in self.guess] for record in records], (-1, len(self.guess)))
        factors = dict(zip(self.guess, np.exp(_interpolate(self.points, self.corrections, values)).T, strict=True))
        factors_of_study = self.study_factors
        figures = {key: factors_of_study.get(key, 1.0) * factors[key] * guess for key, guess in self.guess.items()}
        return add_capacity(figures)

    @property
    def study_factors(self) -> Mapping[str, Array]:
        """Return the ratios of torque limits and backlash by a tolerance study to those by one sample, by key, (n,).

        The ratios are expected values for n candidates.
        """
        values = np.reshape([*self.biases.values()], (-1, 2))
        torque, backlash = np.exp(_interpolate(self.points, self.biases, values)).T
        return {key: torque for key in self.guess if key not in FIGURES} | {"backlash": backlash}

    @property
    def promise(self) -> float:
        """Largest corrected estimate of the torque within the limits [N m]."""
        figures = self.corrected
        return float(np.max(figures["capacity"] * (strongest(self.requirement).excess(figures) <= 0.0)))

    @property
    def rated_torque(self) -> float:
        """Largest torque within the limits that a candidate is rated for, with the effect of a study [N m]."""
        figures, _ = self._known_quantities()
        torque = figures["capacity"] * (strongest(self.requirement).excess(figures) <= 0.0)
        return max((float(torque[row]) for row, drive in self.rated.items() if drive), default=0.0)

    def lightest(self) -> Rated | None:
        """Return the drive with the lowest losses of those close to the lowest mass, after its tolerance study.

        It is None if no drive passes.
        """
        lightest_drive = self.best(lightest(self.requirement))
        if not lightest_drive:
            return None
        max_mass = (1.0 + SETTINGS.mass_tolerance) * lightest_drive.figures["mass"]
        return (
            self.best(most_efficient(self.requirement, max_mass), max_evaluations=SETTINGS.few_ratings)
            or lightest_drive
        )

    def best(
        self,
        objective: Objective,
        goal: float = math.nan,
        *,
        study: bool = True,
        max_evaluations: int = SETTINGS.ratings,
    ) -> Rated | None:
        """Search for the best drive by an objective, such as mass, or the first that reaches `goal`; None without one.

        `goal` is a value of the quantity of the objective, in its unit; NaN: none. The candidate with the largest
        expected improvement is evaluated by the full computation, again and again, until no improvement is expected or
        `max_evaluations` candidates are evaluated (efficient global optimization: Jones, Schonlau and Welch, J. Global
        Optim. 13, 1998). The neighbours of each best drive, which differ in one variable, are added to the candidates.
        With `study`, the tolerance study of the best drive follows. If it fails, the search continues. Drives that
        barely reach a `goal` of the capacity often fail their study, so the search for it first continues to a reserve
        above the goal (`SETTINGS.study_share`). The result is within all limits of the objective.
        """
        target_merit = objective.merit({objective.key: goal})
        reserve = -math.log(SETTINGS.study_share) if study and objective.key == "capacity" else 0.0
        ratings, studies = 0.0, 0
        while True:
            figures, scale = self._known_quantities()
            merits, excesses = objective.merit(figures), objective.excess(figures)
            row = self._best_row(merits, excesses)
            best = -math.inf if row is None or excesses[row] > 0.0 else float(merits[row])
            drive = None if row is None else self.rated[row]
            is_reached = best >= target_merit + (0.0 if drive and drive.passed else reserve)
            if not is_reached and ratings < max_evaluations:
                cost = self._search_step(objective, figures, scale, row, best)
                if cost is not None:
                    ratings += cost
                    continue
            if row is None or not math.isfinite(best):
                return None
            if not study or (drive and drive.passed):
                return drive
            if studies == SETTINGS.studies:
                passed = [index for index, drive in self.rated.items() if drive and drive.passed]
                passed = [index for index in passed if excesses[index] <= 0.0]
                return self.rated[max(passed, key=lambda index: merits[index])] if passed else None
            studies += 1
            self.study(row)

    def _search_step(
        self, objective: Objective, figures: Estimate, scale: Array, row: int | None, best: float
    ) -> float | None:
        """Do one step of the search of `best`: evaluate the most promising candidate, or add neighbours of the best.

        Neighbours come first if the best candidate is within all limits, else last. Without any evaluated candidate,
        the one that exceeds the limits least is evaluated even if it is unlikely to be within them.

        Parameters
        ----------
        objective
            Quantity to be improved, such as mass.
        figures, scale
            Results of `_known_quantities`.
        row, best
            Index of the best evaluated candidate, or None; and its merit, or -inf if it exceeds a limit.

        Returns
        -------
        float or None
            The number of evaluations, 0 for neighbours; None if no improvement is expected.
        """
        is_within = math.isfinite(best)
        if row is not None and is_within and self._add_neighbours(row):
            return 0.0
        improvements = objective.expected_improvement(figures, scale, best)
        if row is None and SETTINGS.build_share * len(self.rated) < SETTINGS.few_ratings:
            improvements = 1.0 / (1.0 + objective.excess(figures))
        improvements[list(self.rated)] = 0.0
        candidate = int(np.argmax(improvements))
        if improvements[candidate] > (SETTINGS.min_improvement if is_within else SETTINGS.min_probability):
            least_load = 1e-3 * FIRST_TORQUE * self.requirement.diameter**3
            torque = max(float(figures["capacity"][candidate]), least_load)
            return 1.0 if self._rate_candidate(candidate, torque) else SETTINGS.build_share
        return 0.0 if row is not None and self._add_neighbours(row) else None

    def nearest(self, objective: Objective) -> Rated | None:
        """Return the best rated drive by an objective, or the one that exceeds its limits least; None without any."""
        figures, _ = self._known_quantities()
        row = self._best_row(objective.merit(figures), objective.excess(figures))
        return None if row is None else self.rated[row]

    def _best_row(self, merits: Array, excesses: Array) -> int | None:
        """Return the index of the best rated candidate, or of the one with the smallest excess; None without one.

        `merits` and `excesses` are those of an objective for all n candidates, shape (n,).
        """
        rows = [index for index, drive in self.rated.items() if drive and math.isfinite(merits[index])]
        return min(rows, key=lambda index: (excesses[index], -merits[index]), default=None)

    def _rate_candidate(self, row: int, torque: float) -> bool:
        """Compute and store the torque limits of the candidate with the index `row`; return whether this succeeded.

        `torque` is that of the first computation [N m]. The logarithms of the ratios of rated to estimated quantities
        are stored in `corrections`.
        """
        self.rated[row] = drive = rate_candidate(self.requirement, self.sizes[row], torque, self.samples)
        rated_figures = drive.known(self.guess) if drive else {"other": UNSOUND * float(self.guess["other"][row])}
        self.corrections[tuple(self.points[row])] = {
            key: float(np.log(np.clip(value / max(self.guess[key][row], 1e-9), 0.05, 20.0)))
            for key, value in rated_figures.items()
        }
        return drive is not None

    def study(self, row: int) -> Rated | None:
        """Compute the torque limits of the candidate with the index `row` by a tolerance study; store and return them.

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
        studied = self._study_at(drive.reducer, torque)
        if studied and torque < required <= studied.capacity:
            studied = self._study_at(drive.reducer, required)
        elif studied and studied.capacity < torque < required:
            smaller = self._study_at(drive.reducer, floor_digits(SETTINGS.study_share * _secant_torque(studied)))
            studied = smaller and replace(smaller, too_large=torque)
        if studied and not drive.study:
            backlash = studied.figures["backlash"] / drive.figures.get("backlash", studied.figures["backlash"])
            self.biases[tuple(self.points[row])] = math.log(studied.capacity / drive.capacity), math.log(backlash)
        self.rated[row] = studied
        return studied

    def nearer_to_capacity(self, drive: Rated) -> Rated:
        """Repeat the tolerance study of a drive at a larger torque; return the drive that passed last.

        The torque is nearer to what the drive carries. If a study failed at a larger torque, the torque is the
        geometric mean of both (bisection).
        """
        middle = math.sqrt(drive.torque * drive.too_large)
        torque = floor_digits(min(SETTINGS.study_share * drive.capacity, middle, self.requirement.torque))
        full = self._study_at(drive.reducer, torque) if torque > drive.torque else None
        return full if full and full.passed else drive

    def _study_at(self, reducer: Reducer, torque: float) -> Rated | None:
        """Rate a drive with toleranced parts under a torque [N m], and study samples of its tolerances.

        The backlash of the result is the 99th percentile of the samples. `passed` says whether no torque limit is below
        the torque, and enough samples turn and have the required backlash. The result is None if the drive cannot be
        rated, or if too many samples jam (see `SETTINGS.min_yield`).
        """
        drive = rate_drive(self.requirement, reducer, torque)
        study = tolerance_study(self.requirement, drive.reducer) if drive else {}
        if not drive or study["turning_percent"] < SETTINGS.min_yield:
            return None
        passed = drive.capacity >= torque and study["yield_percent"] >= SETTINGS.min_yield
        return replace(
            drive, figures={**drive.figures, "backlash": study["backlash_p99_arcmin"]}, study=study, passed=passed
        )

    def _known_quantities(self) -> tuple[Estimate, Array]:
        """Return torque limits, mass, length and backlash of all n candidates, and the scale of their errors.

        All have the shape (n,). The values are computed, corrected by `study_factors`, or estimated. The standard
        deviations of estimates are `DEVIATIONS` times the scale, which decreases with the distance to the nearest
        evaluated candidate.
        """
        figures, study_factors = self.corrected, self.study_factors
        for row, drive in self.rated.items():
            for key, value in drive.known(self.guess).items() if drive else dict.fromkeys(self.guess, math.nan).items():
                factor = study_factors[key][row] if key in study_factors and not (drive and drive.study) else 1.0
                figures[key][row] = value * factor
        scale = np.full(len(self.points), SETTINGS.first_error)
        if self.corrections:
            distance = cdist(self.points, list(self.corrections)).min(axis=1)
            scale = np.clip(distance / SETTINGS.reach, SETTINGS.least_error, 1.0)
        return add_capacity(figures), scale

    def _add_neighbours(self, index: int) -> bool:
        """Add the neighbours of a candidate to the pool, for a local search; each differs from it in a single variable.

        `index` is the index of the candidate. Neighbours that are in the pool already are not added. Returns False if
        the neighbours of this candidate were added before.
        """
        if index in self.extended:
            return False
        self.extended.add(index)
        steps = np.concatenate([sign * np.geomspace(*SETTINGS.neighbours) for sign in (-1.0, 1.0)])
        changes = (np.eye(DIMENSIONS)[:, np.newaxis] * steps[:, np.newaxis]).reshape(-1, DIMENSIONS)
        points, sizes = decode(self.requirement, np.clip(self.points[index] + changes, 0.0, 1.0 - 1e-9))
        _, first_rows = np.unique(np.concatenate([self.sizes, sizes]), return_index=True)
        new_rows = first_rows[first_rows >= len(self.sizes)] - len(self.sizes)
        if len(new_rows):
            new_sizes = sizes[new_rows].view(np.recarray)
            guess = _estimate(self.requirement, new_sizes, design_of(self.requirement, self.sizes[0]))
            self.guess = {key: np.concatenate([values, guess[key]]) for key, values in self.guess.items()}
            self.points = np.concatenate([self.points, points[new_rows]])
            self.sizes = np.concatenate([self.sizes, new_sizes]).view(np.recarray)
        return True


def _interpolate(points: Array, known: Iterable[Point], values: Array) -> Array:
    """Interpolate the logarithms of m factors at n points by inverse distances (Shepard's method), shape (n, m).

    `points` (n, `DIMENSIONS`) are the n points, and `values` (k, m) are the logarithms at the k points `known`. Far
    from all known points, the result approaches the median of the known values and two zeros (factors of 1), which
    limits the influence of a single exceptional candidate.
    """
    known_points = np.reshape(list(known), (-1, DIMENSIONS))
    weight = 1.0 / (cdist(points, known_points, "sqeuclidean") + 1e-9) ** 2
    weight /= weight.sum(axis=1, keepdims=True) + SETTINGS.reach**-4
    middle = np.median(np.concatenate([np.zeros((2, values.shape[1])), values]), axis=0)
    return np.asarray(weight @ values + (1.0 - weight.sum(axis=1, keepdims=True)) * middle)


def _secant_torque(drive: Rated) -> float:
    """Return the torque [N m] at which a drive that was rated at too large a torque is expected to equal its capacity.

    It is at least half of the capacity.
    """
    return max(1.5 * drive.capacity - 0.5 * drive.torque, 0.5 * drive.capacity)


def floor_digits(value: float) -> float:
    """Round a positive number down to three significant digits."""
    scale = 10.0 ** (math.floor(math.log10(value)) - 2)
    return significant(math.floor(value / scale) * scale)


def create_pool(requirement: Requirement, source: Pool | None = None) -> Pool | None:
    """Search good, diverse candidates for a requirement, and return this pool; None if no drive can be built.

    The factors by which computed ratings correct the estimates of capacity, mass and so on are shared with the pool
    `source`, if there is one.
    """
    pool = Pool.of(requirement, _find_elites(requirement.kind))
    if not pool:
        return None
    pool.samples = _find_likely_critical_samples(requirement.kind)
    return replace(pool, corrections=source.corrections, biases=source.biases) if source else pool


@lru_cache(maxsize=32)
def _find_likely_critical_samples(kind: Requirement) -> tuple[int, ...]:
    """Return the numbers of the tolerance samples that are likely critical for requirements of one kind.

    Requirements are of one `kind` if they differ only in limits and conditions (`Requirement.kind`). In a critical
    sample, the deviations of the parts cause the governing tooth forces. The samples are found from some of these
    drives. The result is empty if these have no tolerances or cannot be built.
    """
    _, sizes = decode(kind, _find_elites(kind))
    torque = capacity(_estimate(kind, sizes))
    order = np.argsort(-torque, kind="stable")[:: max(len(torque) // SETTINGS.ratings, 1)]
    drives = (drive for row in order if (drive := build_drive(kind, sizes[row], float(torque[row]))))
    return find_likely_critical_samples(islice(drives, SETTINGS.reference_drives))


def _estimate(requirement: Requirement, sizes: Sizes, design: Design | None = None) -> Estimate:
    """Estimate candidates of a requirement; materials and friction are those of a `design`, by default of the first."""
    deviation = TOLERANCE_SHARE * requirement.usual_clearance
    return estimate(sizes, design or design_of(requirement, sizes[0]), requirement.diameter, deviation)


@lru_cache(maxsize=32)
def _find_elites(kind: Requirement) -> Array:
    """Find a diverse set of good candidates (elites) for requirements of the same `Requirement.kind`, by MAP-Elites.

    Candidates are compared by their estimates. MAP-Elites keeps the best candidate (elite) of each cell of torque and
    length. There is an archive of cells for each kind of torque limit (`_capacities`), so that the elites include good
    candidates for any conditions.

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
        parents = points[_elite_indices(_estimate(kind, sizes))]
        parent_rows, partners = random.integers(len(parents), size=(2, SETTINGS.children))
        line_steps = SETTINGS.line * random.standard_normal((SETTINGS.children, 1))
        random_steps = SETTINGS.scatter * random.standard_normal((SETTINGS.children, DIMENSIONS))
        children = parents[parent_rows] + random_steps + line_steps * (parents[partners] - parents[parent_rows])
        points, sizes = decode(kind, np.concatenate([parents, np.clip(children, 0.0, 1.0 - 1e-9)]))
    return points[_elite_indices(_estimate(kind, sizes))]


def _elite_indices(guess: Estimate) -> Integers:
    """Return the indices of the lightest candidate in each cell of torque and length (elites).

    `guess` are the estimates of all candidates. There are elites for each kind of torque limit (`_capacities`).
    """
    elite_rows = []
    for torque in _capacities(guess):
        strong_rows = np.flatnonzero(torque > SETTINGS.weakest * torque.max())
        order = strong_rows[np.argsort(guess["mass"][strong_rows], kind="stable")]
        cell = np.floor(SETTINGS.cells * np.log(np.stack([torque[order], guess["length"][order]], axis=1)))
        elite_rows.append(order[np.unique(cell, axis=0, return_index=True)[1]])
    return np.unique(np.concatenate(elite_rows))


def _capacities(guess: Estimate) -> list[Array]:
    """Return the torque limits by all items, without that of the temperature, and by strength alone [N m]."""
    by_life = tuple(key for key in guess if not (is_momentary(key) or is_strength(key)))
    left_out = ((), ("temperature", "other"), by_life)
    return [np.where(guess["other"] > 0.0, capacity(guess, keys), 0.0) for keys in left_out]


def first_drive(requirement: Requirement) -> Reducer | None:
    """Return the first drive of the sequence that can be built; None if there is none."""
    return _build_first_drive(requirement)[0]


def most_frequent_obstacle(requirement: Requirement) -> str:
    """Return the most frequent reason why `first_drive` finds no drive; "" if no sizes of parts are compatible."""
    obstacles = _build_first_drive(requirement)[1]
    kinds = [re.sub(r"[\d.]+", "", obstacle) for obstacle in obstacles]
    return max(zip(obstacles, kinds, strict=True), key=lambda pair: kinds.count(pair[1]), default=("", ""))[0]


@lru_cache(maxsize=8)
def _build_first_drive(requirement: Requirement) -> tuple[Reducer | None, tuple[str, ...]]:
    """Build the first 200 candidates of the sequence until one succeeds; return this drive, or None.

    The second result has the reasons why the candidates before it cannot be built, without remedies.
    """
    _, sizes = decode(requirement, _sequence(SETTINGS.start))
    obstacles: list[str] = []
    for row in sizes[:200]:
        try:
            return assemble_drive(requirement, row, FIRST_TORQUE * requirement.diameter**3), tuple(obstacles)
        except CycloidError as error:
            obstacles.append(str(error).partition(": ")[0])
    return None, tuple(obstacles)


def _sequence(count: int) -> Array:
    """Return the first points of the R sequence in the unit cube (Roberts, 2018): steps by powers of a golden ratio."""
    ratio = 2.0
    for _ in range(50):
        ratio = (1.0 + ratio) ** (1.0 / (DIMENSIONS + 1))
    return np.asarray((0.5 + np.arange(1, count + 1)[:, np.newaxis] / ratio ** np.arange(1, DIMENSIONS + 1)) % 1.0)
