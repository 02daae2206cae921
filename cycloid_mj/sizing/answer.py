"""The result of sizing: up to three drives that meet a requirement, or the maximum torque and remedies."""

import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from cycloid_mj.base.array import significant
from cycloid_mj.base.errors import CycloidError, UsageError
from cycloid_mj.base.frame import Frame, make_frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.design import Design
from cycloid_mj.figures import figure
from cycloid_mj.life.as_built import has_tolerances, select_rated_samples
from cycloid_mj.life.checks import life_checks
from cycloid_mj.life.rated import is_momentary, weakest_torque
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.sizing.reasons import reasons_of
from cycloid_mj.sizing.requirement import Requirement
from cycloid_mj.sizing.search import Pool, Rated, pool_of, rate_drive
from cycloid_mj.statics import loads, springs_of
from cycloid_mj.statics.springs import turn_evenly

MIN_YIELD = 99.0
"""Smallest share of the samples of a drive within its tolerances that turn and have the required backlash [%]."""

MIN_SHARE = 0.8
"""Share of the backlash of a strong drive from which others may meet a limit with the same clearances."""

MIN_DIFFERENCE = 1.05
"""Ratio of stiffness or life from which a drive is shown next to the lightest."""

HOPELESS = 0.8
"""Share of the required torque that an estimate promises at least where the search goes on."""

MAX_TRIALS = 4
"""Candidates that are rated at all crank angles and studied within their tolerances: 0.5 s of CPU each."""

STUDY_MARGIN = 1.03, 1.1
"""Capacity over the required torque from which candidates are studied: at first, and at most after too weak ones."""

MAX_RATIOS = 7
"""Number of ratios tried in a range, evenly spaced."""

Figures = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class SizedDrive:
    """A drive that meets the requirement: why it is shown, its design, figures by key, and reasons by value."""

    title: str
    why: str
    design: Design
    figures: Figures
    reasons: Mapping[str, str]


@dataclass(frozen=True)
class FeasibleChange:
    """A change of the requirement that makes it feasible: in words, and as a requirement."""

    words: str
    requirement: Requirement


@dataclass(frozen=True, eq=False, repr=False)
class Answer(Presented):
    """Drives, the default first; or the maximum torque `most` [N m], what limits it, and remedies."""

    requirement: Requirement
    drives: tuple[SizedDrive, ...]
    most: float = 0.0
    limit: str = ""
    remedies: tuple[FeasibleChange, ...] = ()

    @property
    def asked(self) -> Requirement:
        """The requirement, under its name before 0.3."""
        warnings.warn(
            "the attribute Answer.asked is deprecated: use Answer.requirement", DeprecationWarning, stacklevel=2
        )
        return self.requirement

    @property
    def ways(self) -> tuple[FeasibleChange, ...]:
        """The remedies, under their name before 0.3."""
        warnings.warn("the attribute Answer.ways is deprecated: use Answer.remedies", DeprecationWarning, stacklevel=2)
        return self.remedies

    @property
    def frame(self) -> Frame:
        """The drives, a row each: title and figures."""
        figures = self.drives[0].figures if self.drives else {}
        return make_frame([{"title": item.title, **item.figures} for item in self.drives], ("title", *figures), {})

    @property
    def line(self) -> str:
        """The requirement, and the drives or the refusal."""
        requirement = (
            f"{self.requirement.ratio}:1, {1e3 * self.requirement.diameter:g} mm, {self.requirement.torque:g} N m"
        )
        drives = ", ".join(f"{item.title} {item.figures['mass_kg']:.3g} kg" for item in self.drives)
        return f"{requirement}; {drives or self.refusal}"

    @property
    def refusal(self) -> str:
        """The reason why the requirement is not feasible, and feasible remedies."""
        torque = f"{self.requirement.torque:g} N m"
        options = ", or ".join(remedy.words for remedy in self.remedies)
        remedy = (
            f"{torque} is feasible with {options}"
            if options
            else f"no change of size, discs or material was found that makes {torque} feasible"
        )
        if not self.most:
            return f"not feasible: {self.limit}; {remedy}"
        return f"not feasible: the limit is {self.most:g} N m ({self.limit}); {remedy}"


@dataclass(frozen=True, eq=False)
class Solution:
    """A drive for a requirement with its final discs and clearances, its pool, and figures of its tolerance study."""

    requirement: Requirement
    pool: Pool
    rated: Rated
    study: Figures


@dataclass(eq=False)
class _Acceptance:
    """Rating and tolerance study of candidates as on their design files: the last steps before a drive is accepted.

    `trials` candidates are studied at most, with a capacity that is likely to be `enough`: studies have less, as they
    rate the largest force of each pair.
    """

    requirement: Requirement
    trials: int = MAX_TRIALS
    drives: dict[Rated, Rated | None] = field(default_factory=dict)
    studies: dict[Rated, Figures] = field(default_factory=dict)
    enough: float = 0.0

    def __post_init__(self) -> None:
        self.enough = STUDY_MARGIN[0] * self.requirement.torque

    def __call__(self, rated: Rated) -> bool:
        """Return whether a candidate is rated for the torque within its tolerances, and enough samples turn."""
        if rated not in self.drives and len(self.drives) < self.trials:
            self.drives[rated] = full = self._rate(rated) if math.isfinite(rated.mass) else None
            self.studies[rated] = tolerance_study(self.requirement, full.reducer) if full else {}
        return self.studies.get(rated, {}).get("yield_percent", 0.0) >= MIN_YIELD

    def _rate(self, rated: Rated) -> Rated | None:
        """Rate a candidate as on its design file; None if it has too little torque, or a check of its life fails."""
        torque = self.requirement.torque
        full = rate_drive(self.requirement, rated.reducer, torque)
        if full and full.capacity < torque:
            self.enough = min(max(rated.capacity / full.capacity, STUDY_MARGIN[0]), STUDY_MARGIN[1]) * torque
            return None
        lasts = full and (self.requirement.duty or all(check.passed for check in life_checks(full.reducer)))
        return full if lasts else None

    def is_too_weak_or_accepted(self, rated: Rated) -> bool:
        """Return whether a candidate has less than the torque, so that no study matters, or is accepted."""
        return rated.capacity < self.requirement.torque or self(rated)

    def solution(self, pool: Pool, rated: Rated) -> Solution:
        """Return the solution of an accepted candidate."""
        full = self.drives[rated]
        assert full
        return Solution(self.requirement, pool, full, self.studies[rated])

    @property
    def least_backlash(self) -> float:
        """The smallest backlash of 95 % of the drives that were studied [arcmin]; infinite if there is none."""
        return min((study.get("backlash_p95_arcmin", math.inf) for study in self.studies.values()), default=math.inf)


@dataclass(frozen=True, eq=False)
class _Trial:
    """A number of discs and clearances that were tried: their pool, the best candidate, and what accepted it."""

    requirement: Requirement
    pool: Pool
    best: Rated | None
    accept: _Acceptance

    @property
    def solution(self) -> Solution | None:
        """The drive, if it is strong enough."""
        if not self.best or self.best.capacity < self.requirement.torque:
            return None
        return self.accept.solution(self.pool, self.best)


def solve(requirement: Requirement) -> tuple[Solution | None, Answer, list[Pool]]:
    """Find the lightest drive of a requirement; else a refusal with the maximum torque, its limit, and the pools."""
    failed: list[_Trial] = []
    for trial in _trials(requirement, requirement.variants, lightest=True):
        if trial.solution:
            return trial.solution, Answer(trial.requirement, ()), []
        failed.append(trial)
    if not failed:
        return None, Answer(requirement, (), 0.0, _no_room(requirement)), []
    failed.sort(key=lambda trial: -trial.best.capacity if trial.best else 0.0)
    refusals = (_refusal(trial) for trial in failed)
    first = next(refusals)
    refused = first if first.most else next((other for other in refusals if other.most), first)
    return None, refused, [trial.pool for trial in failed]


def is_feasible(requirement: Requirement) -> bool:
    """Return whether the search finds a drive; it ends where a search for the maximum would go on."""
    return any(trial.solution for trial in _trials(requirement, requirement.variants[-1:], give_up=True))


def _trials(
    requirement: Requirement, variants: Sequence[Requirement], *, lightest: bool = False, give_up: bool = False
) -> Iterator[_Trial]:
    """Yield the trials of a requirement, for each of its numbers of discs.

    The order of the candidates does not depend on the torque, so that what is found for one torque is found for every
    smaller one. The `variants` have larger clearances before smaller ones, with whose closer tolerances more teeth
    carry; those that a backlash requires follow. All but the last end where no estimate promises `HOPELESS` of the
    torque; the last only to `give_up`, as others have no maximum.
    """
    for discs in requirement.numbers_of_discs:
        queue = [variant.but(discs=discs) for variant in variants]
        while queue:
            fixed = queue.pop(0)
            pool = pool_of(fixed)
            if not pool:
                continue
            least = HOPELESS * fixed.torque if queue or give_up else 0.0
            trial = _try(fixed, pool, least, lightest)
            yield trial
            if fixed.backlash < math.inf and fixed.has_usual_clearances:
                queue += [*_finer(fixed, trial)] or [fixed.finest]


def _try(fixed: Requirement, pool: Pool, least: float, lightest: bool) -> _Trial:
    """Search the lightest or the strongest candidate that is accepted; the strongest of all if none has the torque."""
    accept = _Acceptance(fixed)
    best = pool.largest(fixed.length, accept.enough, give_up=least)
    if best and best.capacity >= fixed.torque:
        best = pool.lightest(lambda: accept.enough, fixed.length, accept) if lightest else None
        accept.trials += MAX_TRIALS if lightest else 0
        best = best or pool.largest(fixed.length, accept.enough, accept.is_too_weak_or_accepted, least)
    return _Trial(fixed, pool, best, accept)


def _finer(fixed: Requirement, trial: _Trial) -> Iterator[Requirement]:
    """Yield the requirement with the clearances that its backlash requires, three at most."""
    backlash = trial.accept.least_backlash
    if trial.best and not trial.accept.studies:
        backlash = tolerance_study(fixed, trial.best.reducer).get("backlash_p95_arcmin", math.inf)
    if backlash <= fixed.backlash:
        return
    listed, share = [*fixed.tighter_clearances], fixed.backlash / backlash
    finer = [item for item in listed if item <= share / MIN_SHARE * fixed.usual_clearance] if share else listed
    for clearance in (finer or listed[-1:])[:3]:
        yield fixed.but(clearance=clearance, tightened=True)


def tolerance_study(requirement: Requirement, reducer: Reducer) -> Figures:
    """Compute the yield of a drive within its tolerances [%], and median and 5 to 95 % of its backlash [arcmin].

    A sample is good if it does not jam and its backlash is within the limit.
    """
    if not has_tolerances(reducer.design):
        backlash = figure("backlash_arcmin").value(reducer)
        return {"yield_percent": 100.0 if backlash <= requirement.backlash else 0.0, "backlash_arcmin": backlash}
    try:
        samples = select_rated_samples(reducer)
    except CycloidError:
        return {"yield_percent": 0.0}
    jams, backlashes = samples.jams, samples.backlash
    good = ~jams & (backlashes <= requirement.backlash)
    share = 100.0 * float(good.mean())
    low, median, high = np.percentile(backlashes[~jams], [5.0, 50.0, 95.0]).tolist()
    return {"yield_percent": share, "backlash_arcmin": median, "backlash_p05_arcmin": low, "backlash_p95_arcmin": high}


def _refusal(trial: _Trial) -> Answer:
    """Return the maximum torque of a trial without a solution, and its limit."""
    requirement, pool = trial.requirement, trial.pool
    largest = trial.best or pool.largest(requirement.length)
    if not largest:
        shortest = pool.shortest(0.0)
        limit = f"no drive is shorter than {MILLIMETRES * shortest.length:.3g} mm" if shortest else NO_EQUILIBRIUM
        limit += f" ({length_parts(shortest.reducer)})" if shortest else ""
        return Answer(requirement, (), 0.0, limit)
    if requirement.backlash < math.inf:
        study = tolerance_study(requirement, largest.reducer)
        backlash = min(trial.accept.least_backlash, study.get("backlash_p95_arcmin", math.inf))
        if backlash > requirement.backlash:
            limit = f"its backlash is {backlash:.3g} arcmin or less in 95 % of drives with clearances of "
            return Answer(requirement, (), 0.0, f"{limit}{1e6 * requirement.usual_clearance:.3g} um")
    torque, tried = min(largest.capacity, requirement.torque), largest
    for _ in range(4):
        torque = _floor_digits(0.99 * torque)
        full = rate_drive(requirement, largest.reducer, torque)
        if full and full.capacity >= torque:
            return Answer(requirement, (), torque, full.weakest.name)
        tried, torque = full or tried, full.capacity if full else 0.9 * torque
    return Answer(requirement, (), 0.0, tried.weakest.name)


NO_EQUILIBRIUM = "its teeth skip under any load, or no drive can be balanced"


def _no_room(requirement: Requirement) -> str:
    """Return why no drive of a size exists."""
    if not requirement.custom and pool_of(requirement.but(custom=True, discs=requirement.discs or 1)):
        return "no pins and bearings in stock fit"
    if requirement.motor != "auto" and pool_of(requirement.but(motor="auto", discs=requirement.discs or 1)):
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


def _floor_digits(value: float) -> float:
    """Round down to three digits."""
    scale = 10.0 ** (math.floor(math.log10(value)) - 2)
    return significant(math.floor(value / scale) * scale)


def best_ratio(requirement: Requirement, low: int, high: int) -> Requirement:
    """Choose the ratio of a range with the largest torque limit, among evenly spaced ratios.

    Raises
    ------
    UsageError
        The range is empty.
    """
    if low > high:
        raise UsageError(f"the range of ratios {low} to {high} is empty: give the smaller ratio first")
    count = min(MAX_RATIOS, high - low + 1)
    limits: dict[int, float] = {}
    for number in range(count):
        ratio = round(low + (high - low) * number / max(count - 1, 1))
        pool = pool_of(requirement.but(ratio=ratio, discs=requirement.discs or 1))
        largest = pool.largest(requirement.length) if pool else None
        limits[ratio] = largest.capacity if largest else 0.0
    return requirement.but(ratio=max(limits, key=lambda ratio: limits[ratio]))


def other_drives(solution: Solution) -> Iterator[SizedDrive]:
    """Yield the stiffest and the longest-lived of the rated candidates, if they differ from the lightest."""
    requirement, first = solution.requirement, solution.rated
    accept = _Acceptance(requirement)
    strong = [item for item in solution.pool.rated.values() if item and item.mass > first.mass]
    strong = [item for item in strong if item.capacity >= requirement.torque and item.length <= requirement.length]
    found: list[Solution] = []
    for merit in (_stiffness_of, _capacity_of):
        promising = sorted((item for item in strong if merit(item) > merit(first)), key=merit, reverse=True)
        accepted = next((item for item in promising[:2] if accept(item)), None)
        found += [accept.solution(solution.pool, accepted)] if accepted else []
    best = {
        title: max(found, key=lambda other: merit(other.rated))
        for title, merit in (("stiffest", _stiffness_of), ("longest life", _life_of))
        if any(merit(other.rated) > MIN_DIFFERENCE * merit(first) for other in found)
    }
    both = " and ".join(best) if len({other.rated for other in best.values()}) == 1 else ""
    for title, other in [*best.items()][: 1 if both else 2]:
        yield sized_drive(other, other.rated, title, WHY[both or title])


WHY = {
    "stiffest": "highest stiffness of the candidates",
    "longest life": "longest life of the candidates",
    "stiffest and longest life": "highest stiffness and longest life of the candidates",
}
"""Why a drive is shown next to the lightest, by what it is best in."""


def _life_of(rated: Rated) -> float:
    return rated.life


def _capacity_of(rated: Rated) -> float:
    return rated.capacity


def sized_drive(solution: Solution, rated: Rated, title: str, why: str) -> SizedDrive:
    """Return a drive to show, with its figures and reasons."""
    requirement, reducer = solution.requirement, rated.reducer
    figures = _figures(requirement, rated) | dict(solution.study)
    if figures["drive_diameter_mm"] > figures["outer_diameter_mm"] + 1e-3:
        why += f"; covers of {figures['drive_diameter_mm']:.3g} mm, with screws outside of the ring"
    reasons = dict(reasons_of(requirement, reducer, rated.weakest))
    return SizedDrive(title, why, reducer.design, figures, reasons)


def _figures(requirement: Requirement, rated: Rated) -> dict[str, float]:
    """Compute the figures of a drive that the table of `design new` shows, by key."""
    reducer, design, items = rated.reducer, rated.reducer.design, rated.rating.items.values()
    momentary, _ = weakest_torque((item for item in items if is_momentary(item.key)), 2.0 * design.rated_torque, 1.0)
    return {
        "ratio": design.reduction,
        "outer_diameter_mm": 2e3 * design.housing.outer_radius,
        "drive_length_mm": figure("drive_length_mm").value(reducer),
        "drive_diameter_mm": figure("drive_diameter_mm").value(reducer),
        "mass_kg": rated.mass,
        "mechanism_mass_kg": figure("mass_kg").value(reducer),
        "rated_torque_nm": min(rated.capacity, momentary),
        "momentary_torque_nm": momentary,
        "life_h": rated.life,
        "temperature_c": rated.rating.items["temperature"].value,
        "stiffness_nm_per_arcmin": figure("stiffness_nm_per_arcmin").value(
            reducer.but(load={"torque": design.rated_torque})
        ),
    }


def _stiffness_of(rated: Rated) -> float:
    return _first_stiffness(rated.reducer)


@once
def _first_stiffness(reducer: Reducer) -> float:
    """Compute the stiffness between half and full torque at few crank angles [N m/rad]."""
    still, torque = reducer.but(drive={"speed": 0.0}), reducer.design.rated_torque
    springs = springs_of(still, turn_evenly(reducer, 19), friction=False)
    half, full = (loads(still, springs, share * torque).output_turn for share in (0.5, 1.0))
    return 0.5 * torque / float((full - half).mean())
