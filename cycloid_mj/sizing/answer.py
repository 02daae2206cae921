"""The result of sizing: up to three drives that meet a requirement, or the maximum torque and remedies."""

import math
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

from cycloid_mj.base.array import significant
from cycloid_mj.base.errors import CycloidError, UsageError
from cycloid_mj.base.frame import Frame, make_frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.units import MILLIMETRES, RPM
from cycloid_mj.design import Design, fits
from cycloid_mj.figures import figure
from cycloid_mj.life.datasheet import momentary_torque
from cycloid_mj.life.figures import drive_length
from cycloid_mj.life.rated import is_momentary, rated_torque
from cycloid_mj.parts.export.casing import casing, covers_fit
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.sizing.climb import START_TORQUE, Budget, Step, coordinate_search
from cycloid_mj.sizing.process import PROCESSES
from cycloid_mj.sizing.proportions import GRID, MIN_WIDTH, Proportions, build_drive
from cycloid_mj.sizing.reasons import reasons_of
from cycloid_mj.sizing.requirement import LARGEST_PAIR, MOST_RATIOS, Requirement
from cycloid_mj.sizing.trial import (
    FEW_ANGLES,
    TORQUE_RESERVE,
    TorqueTrial,
    rate_at_all_angles,
    rate_drive,
    solve_capacity,
)
from cycloid_mj.statics import loads, springs_of
from cycloid_mj.statics.springs import turn_evenly

TORQUE_MARGIN = 0.97
"""Reported maximum torque relative to the computed capacity of the best proportions, if a rating confirms it."""

WIDTH_BISECTIONS = 4
MAX_TORQUE_STEPS, MIN_TORQUE_SHARE = 6, 0.02
"""Maximum number of torques tried for the maximum, and the smallest relative to the start torque."""


CLEARANCE_MARGIN = 0.9
"""Reduction of clearances below the proportional estimate from the backlash limit."""

BALANCE_WORK, MAX_EFFORT = 5e3, 5.0
"""Work of an equilibrium that costs as much as the rest of a trial; effort above which only the lightest is shown."""

COMPARISON_BUDGET = 36.0
"""Budget of trials for drives to compare with the lightest."""

CAPACITY_COST = 4.0
"""Approximate number of trials to compute the capacity of the first proportions."""

MIN_DIFFERENCE = 1.05
"""Ratio of stiffness or life from which a drive is shown next to the lightest."""

VARIATIONS = (
    *(("pin", -1), ("hole", 1), ("output_pins", 1), ("bore", 1), ("output_pins", -1), ("short_width", 1)),
    *(("bore", -1), ("pin", 1), ("hole", -1), ("short_width", -1), ("wall", 1)),
)
"""Changes of one proportion that can increase stiffness or life, the most promising first."""

WIDTH_RATIO = 1.4
"""Face width of the wide variants relative to the lightest drive."""

TORQUE_EXPONENT, MIN_DIAMETER_STEP, MAX_DIAMETER_STEPS = 2.3, 1.04, 5
"""Estimated exponent of torque over diameter; minimum step and maximum number of steps of the diameter."""

DIAMETER_STEP = 1.5
"""Step of the diameter if no torque is feasible."""

MIN_CAPACITY_SHARE, CAPACITY_FACTOR = 0.75, 3.0
"""Capacity, relative to the torque, from which a remedy is examined; and the largest torque relative to the old one."""

SPEED_MARGIN, MAX_SPEED_STEPS = 0.9, 3
"""Tried speed relative to the estimate at which the torque is feasible; maximum number of speeds."""

NO_EQUILIBRIUM = "with clearances of {0:g} um its teeth skip under any load"

NO_STOCK, ANY_SIZE = "no pins and bearings in stock fit", "free sizes of pins and bearings"

MAX_REMEDIES, REMEDY_BUDGET, COMBINATION_BUDGET = 3, 16.0, 30.0
"""Maximum number of remedies besides a larger diameter; search budgets of single and of combined remedies."""

FLUSH_RTOL = 1e-6
"""Relative tolerance of the diameter of covers that are flush with the ring."""

RATED_TORQUE_RTOL = 3e-2
"""Relative tolerance of the rated torque of shortlisted drives."""

MOMENTARY_MARGIN = 1.1
"""Ratio of momentary to rated torque below which the momentary torque is computed at all crank angles."""

MIN_SPEED = 30.0 * RPM
MAX_DIAMETER = 3.0
"""Slowest crank [rad/s] and largest diameter [m] of a remedy."""

CACHED_SEARCHES = 16
"""Number of cached searches, which remedies repeat."""

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
class Remedy:
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
    remedies: tuple[Remedy, ...] = ()

    @property
    def asked(self) -> Requirement:
        """The requirement, under its name before 0.3."""
        warnings.warn("Answer.asked is Answer.requirement since 0.3", DeprecationWarning, stacklevel=2)
        return self.requirement

    @property
    def ways(self) -> tuple[Remedy, ...]:
        """The remedies, under their name before 0.3."""
        warnings.warn("Answer.ways is Answer.remedies since 0.3", DeprecationWarning, stacklevel=2)
        return self.remedies

    @property
    def frame(self) -> Frame:
        """The drives, a row each: title and figures."""
        figures = self.drives[0].figures if self.drives else {}
        return make_frame([{"title": one.title, **one.figures} for one in self.drives], ("title", *figures), {})

    @property
    def line(self) -> str:
        """The requirement, and the drives or the refusal."""
        requirement = (
            f"{self.requirement.ratio}:1, {1e3 * self.requirement.diameter:g} mm, {self.requirement.torque:g} N m"
        )
        drives = ", ".join(f"{one.title} {one.figures['mass_kg']:.3g} kg" for one in self.drives)
        return f"{requirement}; {drives or self.refusal}"

    @property
    def refusal(self) -> str:
        """The reason why the requirement is not feasible, and feasible remedies."""
        found = ", or ".join(remedy.words for remedy in self.remedies)
        remedy = (
            f"{self.requirement.torque:g} N m is feasible with {found}"
            if found
            else f"no change of size, discs or material was found that makes {self.requirement.torque:g} N m feasible"
        )
        if not self.most:
            return f"not feasible: {self.limit}; {remedy}"
        return f"not feasible: the limit is {self.most:g} N m ({self.limit}); {remedy}"


Choice = Callable[[Requirement, Step], Iterator[SizedDrive]]
"""A function that chooses drives to show, from the first proportions that meet the requirement."""


def size_drive(requirement: Requirement, on_progress: Callable[[Answer], None] = lambda _: None) -> Answer:
    """Find drives that meet a requirement, or the maximum torque with its other values.

    `on_progress` receives a refusal as soon as the maximum is known, and again with each remedy.
    """
    return _size_drive(requirement, _shortlist, on_progress)


def _size_first_drive(requirement: Requirement) -> Answer:
    """Size the first drive that meets a requirement, with its backlash only, to see whether it is feasible."""
    return _size_drive(requirement, _first_drive)


def _first_drive(requirement: Requirement, step: Step) -> Iterator[SizedDrive]:
    reducer = step[1].reducer
    yield SizedDrive("first", "", reducer.design, {"backlash_arcmin": figure("backlash_arcmin").value(reducer)}, {})


def _size_drive(
    requirement: Requirement, choose: Choice, on_progress: Callable[[Answer], None] = lambda _: None
) -> Answer:
    """Search for drives, choose those to show, or collect the maximum torque and remedies."""
    requirement, step, path = _search(requirement)
    if step:
        drives = tuple(choose(requirement, step))
        exact = tuple(drive for drive in drives if drive.figures["backlash_arcmin"] <= requirement.backlash)
        if exact:
            return Answer(requirement, exact)
        return _resolve_backlash(requirement, min(drive.figures["backlash_arcmin"] for drive in drives), choose)
    if not path:
        free = requirement.but(custom=True)
        if not requirement.custom and next(coordinate_search(free, Budget()), None):
            found = (
                _larger_diameter(requirement, 0.0, Budget(REMEDY_BUDGET)),
                _longer_drive(requirement),
                Remedy(ANY_SIZE, free) if _search_within(free, Budget())[0] else None,
            )
            remedies = tuple(remedy for remedy in found if remedy and _is_exact(remedy.requirement))
            return Answer(requirement, (), 0.0, NO_STOCK, remedies or tuple(_larger_with_stock(requirement)))
        return _none_fits(requirement)
    most, held = _max_torque(requirement, path[-1])
    if most and (minimum := figure("backlash_arcmin").value(held.reducer)) > requirement.backlash:
        return _resolve_backlash(requirement, minimum, choose, held=False)
    limit = held.weakest.name if held.weakest else NO_EQUILIBRIUM.format(1e6 * requirement.usual_clearance)
    refused = Answer(requirement, (), most, limit)
    on_progress(refused)
    for remedy in _remedies(requirement, path[-1], most):
        refused = replace(refused, remedies=(*refused.remedies, remedy))
        on_progress(refused)
    return refused


def _none_fits(requirement: Requirement) -> Answer:
    """Return a refusal because no disc fits into the size, with a feasible length or diameter."""
    within = f"{1e3 * requirement.diameter:g} mm"
    within += f" by {1e3 * requirement.length:g} mm" if requirement.length < math.inf else ""
    limit = (
        f"no disc with a ratio of {requirement.ratio} fits into {within} with clearances of "
        f"{1e6 * requirement.usual_clearance:g} um ({requirement.process})"
    )
    remedy = _longer_drive(requirement) or _larger_diameter(requirement, 0.0, Budget(REMEDY_BUDGET))
    return Answer(
        requirement,
        (),
        0.0,
        limit,
        (remedy,) if remedy and _is_exact(remedy.requirement) else tuple(_larger_with_stock(requirement)),
    )


def _larger_with_stock(requirement: Requirement) -> Iterator[Remedy]:
    """Yield the smallest tried diameter with parts in stock, and further changes that it needs."""
    larger = _of_diameter(requirement, DIAMETER_STEP * requirement.diameter)
    while larger:
        changed = larger.requirement
        answer = _size_first_drive(changed) if next(coordinate_search(changed, Budget()), None) else None
        if answer and answer.drives:
            yield larger
            return
        if answer and answer.remedies:
            remedy = answer.remedies[0]
            same_size = remedy.requirement.diameter == changed.diameter
            words = f"{larger.words} and {remedy.words}" if same_size else remedy.words
            yield Remedy(words, remedy.requirement)
            return
        larger = _of_diameter(changed, DIAMETER_STEP * changed.diameter)


def _longer_drive(requirement: Requirement) -> Remedy | None:
    """Find a feasible length, if a length is required, or a feasible diameter and length."""
    if requirement.length == math.inf:
        return None
    free, words = requirement.but(length=math.inf), ""
    step = _search_within(free, Budget())[0]
    if not step and (larger := _larger_diameter(free, 0.0, Budget(REMEDY_BUDGET))):
        free, words = larger.requirement, f"{larger.words} and "
        step = _search_within(free, Budget())[0]
    if not step:
        return None
    reducer = step[1].reducer
    longer = free.but(length=math.ceil(drive_length(reducer)) / MILLIMETRES)
    held = _search_within(longer, Budget())[0]
    length = f"{words}a length of {MILLIMETRES * longer.length:g} mm (a drive exists with {length_parts(reducer)})"
    return Remedy(length, longer) if held else None


def length_parts(reducer: Reducer) -> str:
    """Describe what the length of a drive consists of."""
    low, high = casing(reducer).ends
    half = 0.5 * reducer.design.gear.stack_width
    discs = "disc" if reducer.design.gear.discs == 1 else "discs"
    return (
        f"{MILLIMETRES * (-half - low):.3g} mm of motor flange and input bearings, "
        f"{MILLIMETRES * 2.0 * half:.3g} mm of {discs}, {MILLIMETRES * (high - half):.3g} mm of output and its bearings"
    )


def _is_exact(requirement: Requirement) -> bool:
    """Return whether a requirement with a feasible torque also meets its backlash limit, if any."""
    return requirement.backlash == math.inf or _exact(requirement)


def _exact(requirement: Requirement) -> bool:
    """Return whether a requirement is feasible, including its backlash limit."""
    requirement, step, _ = _search(requirement)
    return step is not None and figure("backlash_arcmin").value(step[1].reducer) <= requirement.backlash


def _resolve_backlash(requirement: Requirement, minimum: float, choose: Choice, held: bool = True) -> Answer:
    """Size with tighter clearances if the backlash [arcmin] is too large; return a refusal if they are too tight.

    If the torque is not feasible either (`held` is False), remedies combine two changes.
    """
    share, finest = requirement.backlash / minimum, PROCESSES[requirement.process].finest
    if requirement.tightened and requirement.usual_clearance > finest:
        return _size_drive(
            requirement.but(clearance=max(CLEARANCE_MARGIN * share * requirement.usual_clearance, finest)), choose
        )
    limit = (
        f"the smallest backlash is {minimum:.3g} arcmin with clearances of {1e6 * requirement.usual_clearance:.3g} um"
    )
    remedies = []
    if (clearance := CLEARANCE_MARGIN * share * requirement.usual_clearance) >= finest:
        remedies.append(Remedy(f"clearances of {1e6 * clearance:.2g} um", requirement.but(clearance=clearance, fit="")))
    if larger := _of_diameter(requirement, requirement.diameter / (CLEARANCE_MARGIN * share)):
        remedies.append(larger)
    looser = requirement.but(backlash=math.ceil(100.0 * minimum) / 100.0)
    remedies.append(Remedy(f"a backlash of {looser.backlash:g} arcmin", looser))
    exact = tuple(remedy for remedy in remedies if _exact(remedy.requirement)) if held else ()
    return Answer(requirement, (), 0.0, limit, exact or tuple(_process_and_backlash(requirement, remedies[-1])))


def _process_and_backlash(requirement: Requirement, looser: Remedy) -> Iterator[Remedy]:
    """Yield the strongest process, or a larger backlash, with the further change that the torque needs."""
    for change in (*reversed(_stronger_processes(requirement)), looser):
        answer = _size_first_drive(change.requirement)
        if answer.drives:
            yield change
            return
        if remedy := next((remedy for remedy in answer.remedies if _exact(remedy.requirement)), None):
            yield Remedy(f"{change.words} and {remedy.words}", remedy.requirement)
            return


def best_ratio(requirement: Requirement, low: int, high: int) -> Requirement:
    """Choose the ratio of a range with the largest capacity of the usual proportions, among evenly spaced ratios.

    If they are slow to balance, only the first and the last are tried.

    Raises
    ------
    UsageError
        The range is empty.
    """
    if low > high:
        raise UsageError(f"the range of ratios {low} to {high} is empty: give the smaller ratio first")
    count = min(MOST_RATIOS, high - low + 1)
    ratios = sorted({round(low + (high - low) * place / max(count - 1, 1)) for place in range(count)})

    borne: dict[int, float] = {}
    left = COMPARISON_BUDGET
    for ratio in (ratios[0], ratios[-1], *ratios[1:-1]):
        if left > 0.0:
            step = next(coordinate_search(requirement.but(ratio=ratio), Budget()), None)
            borne[ratio] = step[1].capacity if step else 0.0
            left -= CAPACITY_COST * _effort(step[1]) if step else 1.0
    return requirement.but(ratio=max(borne, key=lambda ratio: borne[ratio]))


def _search(requirement: Requirement) -> tuple[Requirement, Step | None, list[Step]]:
    """Search with the required or necessary discs and clearances; return the requirement searched for.

    If nothing is feasible, the steps lead to the maximum torque.
    """
    tighter = _with_tighter_clearances(requirement)
    for discs in [requirement.discs] if requirement.discs else [1, 2]:
        last = tighter.but(discs=discs)
        step, path = _search_at_any_backlash(last.but(backlash=math.inf, tightened=False))
        if step:
            return last, step, path
    return last, None, path


@lru_cache(maxsize=CACHED_SEARCHES)
def _search_at_any_backlash(requirement: Requirement) -> tuple[Step | None, list[Step]]:
    return _search_within(requirement, Budget())


def _search_within(requirement: Requirement, budget: Budget) -> tuple[Step | None, list[Step]]:
    """Return the first proportions of the search that support the torque at all crank angles, and all steps."""
    path: list[Step] = []
    for proportions, trial in coordinate_search(requirement, budget):
        path.append((proportions, trial))
        if trial.capacity >= requirement.torque and (
            sure := _rate_proportions(requirement, proportions, requirement.torque)
        ):
            return (proportions, sure), path
    return None, path


def _rate_proportions(requirement: Requirement, proportions: Proportions, torque: float) -> TorqueTrial | None:
    reducer = build_drive(requirement, proportions, torque)
    return rate_at_all_angles(reducer, torque) if reducer else None


def _with_tighter_clearances(requirement: Requirement) -> Requirement:
    """Reduce the clearances as far as the backlash limit requires and the process allows."""
    if requirement.backlash == math.inf or requirement.clearance or requirement.fit:
        return requirement
    step = next(coordinate_search(requirement.but(discs=requirement.discs or 1), Budget()), None)
    if not step:
        return requirement
    share = requirement.backlash / figure("backlash_arcmin").value(step[1].reducer)
    finest = PROCESSES[requirement.process].finest
    return requirement.but(
        clearance=max(min(CLEARANCE_MARGIN * share, 1.0) * requirement.usual_clearance, finest), tightened=True
    )


def _max_torque(requirement: Requirement, top: Step) -> tuple[float, TorqueTrial]:
    """Find the maximum torque [N m] that a rating of the best proportions confirms, rounded down to three digits."""
    proportions, trial = top
    trial = solve_capacity(trial.reducer, trial.capacity)
    # no search for a torque finds more than the capacity of its last step, even if a rating confirms more
    torque = TORQUE_MARGIN * min(trial.capacity, top[1].capacity)
    for _ in range(MAX_TORQUE_STEPS):
        torque = _floor_digits(torque)
        if torque < MIN_TORQUE_SHARE * START_TORQUE[requirement.process] * requirement.diameter**3:
            break
        if (sure := _rate_proportions(requirement, proportions, torque)) and _has_play(sure.reducer):
            return torque, sure
        torque *= TORQUE_MARGIN**2
    return 0.0, replace(trial, weakest=None)


def _has_play(reducer: Reducer) -> bool:
    """Return whether statics can compute the backlash of a drive."""
    try:
        figure("backlash_arcmin").value(reducer)
    except CycloidError:
        return False
    return True


def _floor_digits(value: float) -> float:
    """Round down to three digits."""
    scale = 10.0 ** (math.floor(math.log10(value)) - 2)
    return significant(math.floor(value / scale) * scale)


def _remedies(requirement: Requirement, top: Step, most: float) -> Iterator[Remedy]:
    """Yield changes that make the torque feasible, each verified."""
    budget = Budget(REMEDY_BUDGET)
    larger = _larger_diameter(requirement, most, budget)
    if larger and _is_exact(larger.requirement):
        yield larger
    yielded = 0
    for remedy in _candidate_remedies(requirement, top, most):
        if yielded < MAX_REMEDIES and _meets_torque(remedy.requirement, top, budget) and _is_exact(remedy.requirement):
            yielded += 1
            yield remedy
    if not larger and not yielded:
        yield from (remedy for remedy in _combined_remedies(requirement) if _is_exact(remedy.requirement))


def _candidate_remedies(requirement: Requirement, top: Step, most: float) -> Iterator[Remedy]:
    """Yield single changes of the requirement that could make it feasible, the most promising first."""
    limits, weakest = PROCESSES[requirement.process], top[1].weakest
    if weakest and (weakest.key == "temperature" or weakest.life is not None):
        share = most / requirement.torque if weakest.key == "temperature" else (most / requirement.torque) ** 4
        slower = math.floor(SPEED_MARGIN * share * requirement.speed / RPM / 10.0) * 10.0 * RPM
        if slower >= MIN_SPEED:
            yield Remedy(f"{slower / RPM:.0f} rpm", requirement.but(speed=slower))
    if not (requirement.clearance or requirement.fit) and requirement.usual_clearance > limits.finest:
        yield Remedy(f"a clearance of {1e6 * limits.finest:g} um", requirement.but(clearance=limits.finest))
    for material in limits.others:
        if material != requirement.made_of:
            yield Remedy(material, requirement.but(material=material))
    if requirement.discs in (0, 1):
        yield Remedy("two discs", requirement.but(discs=2))
    yield from _stronger_processes(requirement)
    if not requirement.custom:
        yield Remedy(ANY_SIZE, requirement.but(custom=True))


def _stronger_processes(requirement: Requirement) -> tuple[Remedy, ...]:
    """Return the changes to the stronger processes, with their usual material and clearances."""
    return tuple(
        Remedy(
            f"{process} in place of {requirement.process}",
            requirement.but(process=process, material="", clearance=0.0, fit=""),
        )
        for process in PROCESSES[requirement.process].stronger
    )


def _meets_torque(requirement: Requirement, top: Step, budget: Budget) -> bool:
    """Return whether a changed requirement is feasible; a first rating of the best proportions avoids most searches."""
    torque = min(requirement.torque, CAPACITY_FACTOR * top[1].capacity)
    reducer = build_drive(requirement, top[0], torque)
    if reducer and rate_drive(reducer, torque).capacity < MIN_CAPACITY_SHARE * torque:
        return False
    return _search_within(requirement, budget)[0] is not None


def _larger_diameter(requirement: Requirement, capacity: float, budget: Budget) -> Remedy | None:
    """Find a feasible diameter, starting from one with a smaller capacity [N m].

    If a size cannot be built, as parts in stock end, the diameter is searched between it and the previous one.
    """
    built, unbuildable = requirement.diameter, math.inf
    for _ in range(MAX_DIAMETER_STEPS):
        grown = (
            built * max((requirement.torque / capacity) ** (1.0 / TORQUE_EXPONENT), MIN_DIAMETER_STEP)
            if capacity
            else DIAMETER_STEP * built
        )
        larger = _of_diameter(requirement, min(grown, math.sqrt(built * unbuildable)))
        if larger is None or not built < (diameter := larger.requirement.diameter) < unbuildable:
            return None
        step, path = _search_within(larger.requirement, budget)
        if step:
            return larger
        if not path and capacity:
            unbuildable = diameter
        else:
            built, capacity = diameter, _safe_capacity(path)
    return None


def _safe_capacity(path: list[Step]) -> float:
    """Return the capacity of the last proportions of a search, less the margin [N m]."""
    return TORQUE_MARGIN * path[-1][1].capacity if path and path[-1][1].rating else 0.0


def _combined_remedies(requirement: Requirement) -> Iterator[Remedy]:
    """Yield a larger diameter combined with another process, a slower crank or two discs, if no single change suffices.

    If heat limits the torque, the crank is slowed down first.
    """
    budget = Budget(COMBINATION_BUDGET)
    unchanged, two_discs = Remedy("", requirement), Remedy("two discs", requirement.but(discs=2))
    for change in (*reversed(_stronger_processes(requirement)), unchanged, two_discs):
        changed, words = change.requirement, [change.words] if change.words else []
        slower = changed
        step, path = _search_within(changed, budget)
        for _ in range(MAX_SPEED_STEPS):
            speed = math.floor(SPEED_MARGIN * _safe_capacity(path) / requirement.torque * slower.speed / RPM) * RPM
            if step or not _is_heated(path) or slower.speed <= MIN_SPEED:
                break
            slower = changed.but(speed=max(speed, MIN_SPEED))
            step, path = _search_within(slower, budget)
        if slower != changed:
            words.append(f"{slower.speed / RPM:.0f} rpm")
        larger = (
            None if step or _is_heated(path) or not words else _larger_diameter(slower, _safe_capacity(path), budget)
        )
        if not (step or larger) and MIN_SPEED < slower.speed < changed.speed:
            slower, words = changed.but(speed=MIN_SPEED), words[:-1]
            step, path = _search_within(slower, budget)
            words.append(f"{slower.speed / RPM:.0f} rpm")
            larger = None if step else _larger_diameter(slower, _safe_capacity(path), budget)
        if step or larger:
            ends = f" and {larger.words}" if larger else ""
            yield Remedy(", ".join(words) + ends, larger.requirement if larger else slower)
            return


def _is_heated(path: list[Step]) -> bool:
    """Return whether heat limits the last proportions of a search."""
    weakest = path[-1][1].weakest if path else None
    return weakest is not None and weakest.key == "temperature"


def _of_diameter(requirement: Requirement, diameter: float) -> Remedy | None:
    """Return the change to a diameter [m], rounded up to 1, 5 or 10 mm; None if it is too large."""
    step = 1e-3 if diameter < 0.05 else 5e-3 if diameter < 0.2 else 1e-2
    rounded = round(math.ceil(diameter / step - 1e-9) * step, 6)
    if rounded > (fits.LARGEST / LARGEST_PAIR if requirement.fit else MAX_DIAMETER):
        return None
    return Remedy(f"{MILLIMETRES * rounded:g} mm", requirement.but(diameter=rounded))


def _shortlist(requirement: Requirement, step: Step) -> Iterator[SizedDrive]:
    """Yield the lightest, the stiffest and the longest-lived of some feasible drives, if they differ."""
    requirement = requirement.but(covered=covers_fit(step[1].reducer))
    narrowed = _narrowest(requirement, step)
    is_expensive = _effort(narrowed[1]) >= MAX_EFFORT
    others = [] if is_expensive else _others(requirement, narrowed)
    drives: dict[Design, Step] = {}
    for proportions, trial in (narrowed, *others):
        drives.setdefault(trial.reducer.design, (proportions, trial))  # some round to the same parts in stock
    lightest, *rest = _lightest_first(requirement, list(drives.values()))
    beside = list(_other_choices(requirement, lightest[1], rest))
    why = f"lowest mass of the candidates without loss of stiffness{_why_so_few(is_expensive, len(beside))}"
    yield _drive(requirement, *lightest, "lightest", why)
    yield from (_drive(requirement, *one) for one in beside)


def _why_so_few(is_expensive: bool, beside: int) -> str:
    """Return why fewer than two drives are shown next to the lightest; empty if there are two."""
    if is_expensive:
        return "; the only candidate shown, as drives with so much clearance or so many teeth take long to compare"
    differs = f"is {MIN_DIFFERENCE - 1.0:.0%} stiffer or has {MIN_DIFFERENCE - 1.0:.0%} more life"
    return {0: f"; the only candidate shown, as no other {differs}", 1: f"; only one other candidate {differs}"}.get(
        beside, ""
    )


def _other_choices(
    requirement: Requirement, lightest: TorqueTrial, rest: list[Step]
) -> Iterator[tuple[Proportions, TorqueTrial, str, str]]:
    """Yield the stiffest and the longest-lived drive; or, if only one differs, another that beats the lightest."""
    if not rest:
        return
    stiffer, longer = MIN_DIFFERENCE * _first_stiffness(lightest.reducer), MIN_DIFFERENCE * lightest.life
    longest = _best_by(requirement, rest, lambda trial: trial.life, longer)
    others = [one for one in rest if not longest or one[0] != longest[0]]
    reached = _first_stiffness(longest[1].reducer) if longest else 0.0
    stiffest = _best_by(requirement, others, lambda trial: _first_stiffness(trial.reducer), max(reached, stiffer))
    if longest and stiffest and stiffest[1].life >= longest[1].life:  # at all crank angles the stiffest lives longer
        longest, stiffest = stiffest, None
        reached = _first_stiffness(longest[1].reducer)
    if stiffest:
        yield *stiffest, "stiffest", "highest stiffness of the candidates"
    if longest and (stiffest or reached < stiffer):
        yield *longest, "longest life", "longest life of the candidates"
    elif longest:
        yield *longest, "stiffest", "highest stiffness and longest life of the candidates"
    one = stiffest or longest
    if one and not (stiffest and longest):
        some = [
            (proportions, trial)
            for proportions, trial in rest
            if proportions != one[0] and (trial.life > longer or _first_stiffness(trial.reducer) > stiffer)
        ]
        if between := _best_by(requirement, some, lambda trial: -figure("mass_kg").value(trial.reducer), -math.inf):
            yield (
                *between,
                "in between",
                "stiffer or with more life than the lightest, for the smallest additional mass",
            )


def _best_by(
    requirement: Requirement, steps: list[Step], merit: Callable[[TorqueTrial], float], minimum: float
) -> Step | None:
    """Return the drive with the largest merit above a minimum that supports the torque at all crank angles."""
    merits = [(merit(trial), proportions) for proportions, trial in steps]
    for estimate, proportions in sorted(merits, key=lambda pair: pair[0], reverse=True):
        if estimate <= minimum:
            return None
        if (sure := _rate_proportions(requirement, proportions, requirement.torque)) and merit(sure) > minimum:
            return proportions, sure
    return None


def _lightest_first(requirement: Requirement, steps: list[Step]) -> list[Step]:
    """Return the steps with the lightest drive first that supports the torque at all crank angles.

    Lighter but softer drives are omitted: stiffness is not traded for mass.
    """
    first, *others = steps
    masses = {step[0]: figure("mass_kg").value(step[1].reducer) for step in steps}
    lighter = sorted((step for step in others if masses[step[0]] < masses[first[0]]), key=lambda step: masses[step[0]])
    heavier = [step for step in others if masses[step[0]] >= masses[first[0]]]
    stiffness = _first_stiffness(first[1].reducer) if lighter else 0.0
    for proportions, trial in lighter:
        if _first_stiffness(trial.reducer) >= stiffness and (
            sure := _rate_proportions(requirement, proportions, requirement.torque)
        ):
            return [(proportions, sure), first, *heavier]
    return [first, *heavier]


def _others(requirement: Requirement, lightest: Step) -> list[Step]:
    """Return drives that support the torque in a first rating: wider, or with other pins and bores.

    The stiffest of them is varied in turn.
    """
    narrow, left = lightest[0], int(COMPARISON_BUDGET / _effort(lightest[1]))
    found: list[Step] = []
    seen = {narrow}
    start: Proportions | None = narrow
    while start and left > 0:
        wide = start.but(width=min(WIDTH_RATIO * start.width, GRID["width"][-1]))
        neighbours = (proportions.neighbour(*change) for change in VARIATIONS for proportions in (start, wide))
        unseen = [proportions for proportions in (wide, *neighbours) if proportions and proportions not in seen][:left]
        seen.update(unseen)
        left -= len(unseen)
        found += [(proportions, trial) for proportions in unseen if (trial := _first_rating(requirement, proportions))]
        stiffest = max(found, key=lambda one: _first_stiffness(one[1].reducer), default=lightest)[0]
        start = stiffest if stiffest != start else None
    return found


def _effort(trial: TorqueTrial) -> float:
    """Estimate the cost of rating a drive relative to one disc that is easily balanced."""
    return trial.reducer.design.gear.discs * (1.0 + trial.work / BALANCE_WORK)


def _first_rating(requirement: Requirement, proportions: Proportions) -> TorqueTrial | None:
    """Rate proportions at few crank angles with a reserve; return None if they do not support the torque."""
    reducer = build_drive(requirement, proportions, requirement.torque)
    trial = rate_drive(reducer, requirement.torque) if reducer else None
    return trial if trial and trial.rating and trial.capacity >= TORQUE_RESERVE * requirement.torque else None


def _narrowest(requirement: Requirement, step: Step) -> Step:
    """Return the narrowest drive of some proportions that supports the torque, by bisection."""
    low, high = MIN_WIDTH, step[0].width
    enough: list[Proportions] = []
    for _ in range(WIDTH_BISECTIONS):
        proportions = step[0].but(width=math.sqrt(low * high))
        if _first_rating(requirement, proportions):
            high = proportions.width
            enough.append(proportions)
        else:
            low = proportions.width
    for proportions in reversed(enough):
        if sure := _rate_proportions(requirement, proportions, requirement.torque):
            return proportions, sure
    return step


def _drive(requirement: Requirement, proportions: Proportions, trial: TorqueTrial, title: str, why: str) -> SizedDrive:
    figures = _figures(trial)
    if figures["drive_diameter_mm"] > (1.0 + FLUSH_RTOL) * figures["outer_diameter_mm"]:
        why += f"; covers of {figures['drive_diameter_mm']:.3g} mm, as no screw in stock fits in the ring's wall"
    return SizedDrive(title, why, trial.reducer.design, figures, dict(reasons_of(requirement, proportions, trial)))


def _figures(trial: TorqueTrial) -> Figures:
    """Compute the figures of a drive that the table of `design new` shows, by key."""
    reducer, rating = trial.reducer, trial.rating
    design = reducer.design
    speed, life = design.drive.speed, design.service.life
    about, _ = rated_torque(reducer, speed, life, guess=trial.torque, poses=FEW_ANGLES, exact=RATED_TORQUE_RTOL)
    lasting, _ = rated_torque(reducer, speed, life, guess=max(about, trial.torque), exact=RATED_TORQUE_RTOL)
    stops = [item.safety or 0.0 for item in rating.items.values() if is_momentary(item.key)] if rating else [0.0]
    momentary = 2.0 * trial.torque * min(stops)
    if momentary < MOMENTARY_MARGIN * lasting:  # it may limit the rated torque: compute it as the data sheet does
        momentary, _ = momentary_torque(reducer)
    return {
        "ratio": design.reduction,
        "outer_diameter_mm": 2e3 * design.housing.outer_radius,
        "drive_length_mm": figure("drive_length_mm").value(reducer),
        "drive_diameter_mm": figure("drive_diameter_mm").value(reducer),
        "mass_kg": figure("mass_kg").value(reducer),
        "rated_torque_nm": min(lasting, momentary),
        "momentary_torque_nm": momentary,
        "life_h": trial.life,
        "temperature_c": rating.items["temperature"].value if rating else math.nan,
        "stiffness_nm_per_arcmin": _stiffness(reducer),
        "backlash_arcmin": figure("backlash_arcmin").value(reducer),
    }


@once
def _first_stiffness(reducer: Reducer) -> float:
    """Compute the stiffness between half and full torque at few crank angles [N m/rad]."""
    still, torque = reducer.but(drive={"speed": 0.0}), reducer.design.rated_torque
    springs = springs_of(still, turn_evenly(reducer, FEW_ANGLES), friction=False)
    half, whole = (loads(still, springs, share * torque).output_turn for share in (0.5, 1.0))
    return 0.5 * torque / float((whole - half).mean())


def _stiffness(reducer: Reducer) -> float:
    return figure("stiffness_nm_per_arcmin").value(reducer.but(load={"torque": reducer.design.rated_torque}))
