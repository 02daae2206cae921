"""The answer to a requirement: up to three drives that hold it, or the most that goes and what would help."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

from cycloid_mj.base.array import significant
from cycloid_mj.base.errors import CycloidError, UsageError
from cycloid_mj.base.frame import Frame, framed
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.units import MILLIMETRES, RPM
from cycloid_mj.design import Design, fits
from cycloid_mj.figures import figure
from cycloid_mj.life.datasheet import momentary_torque
from cycloid_mj.life.figures import drive_length
from cycloid_mj.life.rated import is_momentary, rated_torque
from cycloid_mj.parts.export.casing import casing, covers_fit
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.sizing.climb import GUESS, Budget, Step, climbed
from cycloid_mj.sizing.process import PROCESSES
from cycloid_mj.sizing.proportions import LEVELS, NARROWEST, Proportions, shaped
from cycloid_mj.sizing.reasons import reasons_of
from cycloid_mj.sizing.requirement import LARGEST_PAIR, MOST_RATIOS, Requirement
from cycloid_mj.sizing.trial import FEW, RESERVE, TorqueTrial, holds, settled, tried
from cycloid_mj.statics import loads, springs_of
from cycloid_mj.statics.springs import turn_evenly

SURELY = 0.97
"""Of what the best proportions bear by the laws of their items: what is told as the most, if it is found to hold."""

NARROWINGS = 4
LOWERINGS, LEAST = 6, 0.02
"""Torques that are tried for it, and the least over the first guess: below, teeth barely touch within their play."""


TIGHTER = 0.9
"""Of the clearances that a backlash asks for in proportion, since other proportions have more of it."""

EASY, HARD = 5e3, 5.0
"""Work of a balance that costs as much as all else in a look; and looks that one costs, over the least, beyond which
the lightest is told alone: others are as slow to balance, and to compare."""

COMPARED = 36.0
"""What is looked at beside the lightest, over the least look."""

SETTLED = 4.0
"""Looks that it takes to find what first proportions bear, about."""

DIFFERENT = 1.05
"""How much stiffer, or longer living, a drive is that is told beside the lightest."""

BESIDE = (
    *(("pin", -1), ("hole", 1), ("output_pins", 1), ("bore", 1), ("output_pins", -1), ("short_width", 1)),
    *(("bore", -1), ("pin", 1), ("hole", -1), ("short_width", -1), ("wall", 1)),
)
"""Shares that make a drive stiffer, or last longer, and their sense, the most likely first."""

WIDER = 1.4
"""Face width of the stiffest and the longest living, over that of the lightest, as far as it goes."""

GROWTH, LEAST_STEP, TRIES = 2.3, 1.04, 5
"""Torque by the diameter to this power, as a guess; at least so much larger, so often."""

FAR = 1.5
"""How much larger where no torque at all is held."""

PROMISES, LOOKED_AHEAD = 0.75, 3.0
"""Of the torque: what a change must leave the best proportions bearing, so that it is looked at closely; and how many
times what they bore before is looked at."""

COOLER, SLOWER = 0.9, 3
"""Of the speed at which a torque would be held by the law of what fails: what is tried; and how often at most."""

NO_BALANCE = "with clearances of {0:g} um its teeth skip under any load"

NO_STOCK, FREE = "no pins and bearings in stock fit", "free sizes of pins and bearings"

MOST_WAYS, LOOKED_FOR, TOGETHER = 3, 16.0, 30.0
"""Ways out beside a larger diameter, and the budgets within which all are looked for, and then several at once."""

TOUCHING = 1e-6
"""Relative: covers that stand out by no more are as wide as the ring."""

TOLD = 3e-2
"""Relative: how near to the rated torque of a shortlist a drive is rated; the law of its weakest item does the rest."""

NEARLY = 1.1
"""Momentary torque over the rated one, from the drive's few angles, below which it is computed at all of them."""

SLOWEST = 30.0 * RPM
LARGEST = 3.0
"""Slowest crank [rad/s] and largest diameter [m] that a way out names."""

REMEMBERED = 16
"""Searches whose outcome is kept: the same are asked for when ways out are found, and when they are tried."""

Figures = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class SizedDrive:
    """A drive that holds what is asked of it: why it is shown, its design, figures by key, and reasons by value."""

    title: str
    why: str
    design: Design
    figures: Figures
    reasons: Mapping[str, str]


@dataclass(frozen=True)
class Way:
    """A change of the requirement with which it can be met: in words, and as it is asked for."""

    words: str
    asked: Requirement


@dataclass(frozen=True, eq=False, repr=False)
class Answer(Presented):
    """Drives, the first of which is to be taken; or the `most` torque [N m], what it is limited by, and ways out."""

    asked: Requirement
    drives: tuple[SizedDrive, ...]
    most: float = 0.0
    limit: str = ""
    ways: tuple[Way, ...] = ()

    @property
    def frame(self) -> Frame:
        """The drives, a row each: title and figures."""
        figures = self.drives[0].figures if self.drives else {}
        return framed([{"title": one.title, **one.figures} for one in self.drives], ("title", *figures), {})

    @property
    def line(self) -> str:
        """The requirement, and the drives or the reason why there is none."""
        asked = f"{self.asked.ratio}:1, {1e3 * self.asked.diameter:g} mm, {self.asked.torque:g} N m"
        drives = ", ".join(f"{one.title} {one.figures['mass_kg']:.3g} kg" for one in self.drives)
        return f"{asked}; {drives or self.refusal}"

    @property
    def refusal(self) -> str:
        """What is not feasible and why, and changes with which it was found to be."""
        found = ", or ".join(way.words for way in self.ways)
        remedy = (
            f"{self.asked.torque:g} N m is feasible with {found}"
            if found
            else f"no change of size, discs or material was found that makes {self.asked.torque:g} N m feasible"
        )
        if not self.most:
            return f"not feasible: {self.limit}; {remedy}"
        return f"not feasible: the limit is {self.most:g} N m ({self.limit}); {remedy}"


Listed = Callable[[Requirement, Step], Iterator[SizedDrive]]
"""Chooses drives to show, from the first proportions that hold a requirement."""


def answered(asked: Requirement, noted: Callable[[Answer], None] = lambda _: None) -> Answer:
    """Find drives that hold a requirement, or the most that goes with its other values.

    `noted` gets a refusal as soon as the most that goes is known, and again with each way out that is found.
    """
    return _answered(asked, _shortlist, noted)


def _briefly(asked: Requirement) -> Answer:
    """Answer with the first drive that holds a requirement alone, and its backlash: whether it can be met, and how."""
    return _answered(asked, _first_alone)


def _first_alone(asked: Requirement, step: Step) -> Iterator[SizedDrive]:
    reducer = step[1].reducer
    yield SizedDrive("first", "", reducer.design, {"backlash_arcmin": figure("backlash_arcmin").value(reducer)}, {})


def _answered(asked: Requirement, listed: Listed, noted: Callable[[Answer], None] = lambda _: None) -> Answer:
    asked, step, path = _searched(asked)
    if step:
        drives = tuple(listed(asked, step))
        exact = tuple(drive for drive in drives if drive.figures["backlash_arcmin"] <= asked.backlash)
        if exact:
            return Answer(asked, exact)
        return _too_loose(asked, min(drive.figures["backlash_arcmin"] for drive in drives), listed)
    if not path:
        free = asked.but(custom=True)
        if not asked.custom and next(climbed(free, Budget()), None):
            found = (
                _larger(asked, 0.0, Budget(LOOKED_FOR)),
                _longer(asked),
                Way(FREE, free) if _held(free, Budget())[0] else None,
            )
            ways = tuple(way for way in found if way and _is_exact(way.asked))
            return Answer(asked, (), 0.0, NO_STOCK, ways or tuple(_beyond(asked)))
        return _none_fits(asked)
    most, held = _most(asked, path[-1])
    if most and (least := figure("backlash_arcmin").value(held.reducer)) > asked.backlash:
        return _too_loose(asked, least, listed, held=False)
    limit = held.weakest.name if held.weakest else NO_BALANCE.format(1e6 * asked.usual_clearance)
    refused = Answer(asked, (), most, limit)
    noted(refused)
    for way in _ways(asked, path[-1], most):
        refused = replace(refused, ways=(*refused.ways, way))
        noted(refused)
    return refused


def _none_fits(asked: Requirement) -> Answer:
    """Answer that no gear of a ratio fits into a size, with a length or a diameter into which one does."""
    within = f"{1e3 * asked.diameter:g} mm"
    within += f" by {1e3 * asked.length:g} mm" if asked.length < math.inf else ""
    limit = (
        f"no disc with a ratio of {asked.ratio} fits into {within} with clearances of "
        f"{1e6 * asked.usual_clearance:g} um ({asked.process})"
    )
    way = _longer(asked) or _larger(asked, 0.0, Budget(LOOKED_FOR))
    return Answer(asked, (), 0.0, limit, (way,) if way and _is_exact(way.asked) else tuple(_beyond(asked)))


def _beyond(asked: Requirement) -> Iterator[Way]:
    """Yield the least diameter tried into which a gear fits with its parts in stock, and what that needs more."""
    larger = _of_diameter(asked, FAR * asked.diameter)
    while larger:
        answer = _briefly(larger) if next(climbed(larger, Budget()), None) else None
        size = f"{1e3 * larger.diameter:g} mm"
        if answer and answer.drives:
            yield Way(size, larger)
            return
        if answer and answer.ways:
            way = answer.ways[0]
            yield Way(way.words if way.asked.diameter != larger.diameter else f"{size} and {way.words}", way.asked)
            return
        larger = _of_diameter(larger, FAR * larger.diameter)


def _longer(asked: Requirement) -> Way | None:
    """Find a length with which the torque is held, where one is asked for, or a diameter and a length."""
    if asked.length == math.inf:
        return None
    free, words = asked.but(length=math.inf), ""
    step = _held(free, Budget())[0]
    if not step and (larger := _larger(free, 0.0, Budget(LOOKED_FOR))):
        free, words = larger.asked, f"{larger.words} and "
        step = _held(free, Budget())[0]
    if not step:
        return None
    reducer = step[1].reducer
    longer = free.but(length=math.ceil(drive_length(reducer)) / MILLIMETRES)
    held = _held(longer, Budget())[0]
    length = f"{words}a length of {MILLIMETRES * longer.length:g} mm (a drive exists with {length_parts(reducer)})"
    return Way(length, longer) if held else None


def length_parts(reducer: Reducer) -> str:
    """State what the length of a drive is made of, along its axis."""
    low, high = casing(reducer).ends
    half = 0.5 * reducer.design.gear.stack_width
    discs = "disc" if reducer.design.gear.discs == 1 else "discs"
    return (
        f"{MILLIMETRES * (-half - low):.3g} mm of motor flange and input bearings, "
        f"{MILLIMETRES * 2.0 * half:.3g} mm of {discs}, {MILLIMETRES * (high - half):.3g} mm of output and its bearings"
    )


def _is_exact(asked: Requirement) -> bool:
    """Tell whether a requirement whose torque is held is so with the backlash that it asks for, if any."""
    return asked.backlash == math.inf or _exact(asked)


def _exact(asked: Requirement) -> bool:
    """Tell whether a requirement is held, its backlash included."""
    asked, step, _ = _searched(asked)
    return step is not None and figure("backlash_arcmin").value(step[1].reducer) <= asked.backlash


def _too_loose(asked: Requirement, least: float, listed: Listed, held: bool = True) -> Answer:
    """Answer with tighter clearances where drives have too much backlash [arcmin]; where those are too tight, tell.

    Where the torque is not `held` either, one change is seldom enough.
    """
    share, finest = asked.backlash / least, PROCESSES[asked.process].finest
    if asked.tightened and asked.usual_clearance > finest:
        return _answered(asked.but(clearance=max(TIGHTER * share * asked.usual_clearance, finest)), listed)
    limit = f"the smallest backlash is {least:.3g} arcmin with clearances of {1e6 * asked.usual_clearance:.3g} um"
    ways = []
    if (clearance := TIGHTER * share * asked.usual_clearance) >= finest:
        ways.append(Way(f"clearances of {1e6 * clearance:.2g} um", asked.but(clearance=clearance, fit="")))
    if larger := _of_diameter(asked, asked.diameter / (TIGHTER * share)):
        ways.append(Way(f"{1e3 * larger.diameter:g} mm", larger))
    looser = asked.but(backlash=math.ceil(100.0 * least) / 100.0)
    ways.append(Way(f"a backlash of {looser.backlash:g} arcmin", looser))
    exact = tuple(way for way in ways if _exact(way.asked)) if held else ()
    return Answer(asked, (), 0.0, limit, exact or tuple(_both(asked, ways[-1])))


def _both(asked: Requirement, looser: Way) -> Iterator[Way]:
    """Yield the strongest process, or a looser backlash, with what that needs to hold the torque too."""
    for words, changed in [*reversed(list(_processes(asked))), (looser.words, looser.asked)]:
        answer = _briefly(changed)
        if answer.drives:
            yield Way(words, changed)
            return
        if way := next((way for way in answer.ways if _exact(way.asked)), None):
            yield Way(f"{words} and {way.words}", way.asked)
            return


def best_ratio(asked: Requirement, low: int, high: int) -> Requirement:
    """Choose the ratio of a range with which the usual proportions bear the most, of a few evenly spaced ones.

    Where they are slow to balance, only the first and the last are tried.

    Raises
    ------
    UsageError
        The range is none.
    """
    if low > high:
        raise UsageError(f"the range of ratios {low} to {high} is empty: give the smaller ratio first")
    count = min(MOST_RATIOS, high - low + 1)
    ratios = sorted({round(low + (high - low) * place / max(count - 1, 1)) for place in range(count)})

    borne: dict[int, float] = {}
    left = COMPARED
    for ratio in (ratios[0], ratios[-1], *ratios[1:-1]):
        if left > 0.0:
            step = next(climbed(asked.but(ratio=ratio), Budget()), None)
            borne[ratio] = step[1].bears if step else 0.0
            left -= SETTLED * _effort(step[1]) if step else 1.0
    return asked.but(ratio=max(borne, key=lambda ratio: borne[ratio]))


def _searched(asked: Requirement) -> tuple[Requirement, Step | None, list[Step]]:
    """Search with the discs and the clearance that are asked for, or that are needed; return what was asked for then.

    Nothing found leaves the steps to the most that goes.
    """
    tighter = _tightened(asked)
    for discs in [asked.discs] if asked.discs else [1, 2]:
        last = tighter.but(discs=discs)
        step, path = _held_at_any_backlash(last.but(backlash=math.inf, tightened=False))
        if step:
            return last, step, path
    return last, None, path


@lru_cache(maxsize=REMEMBERED)
def _held_at_any_backlash(asked: Requirement) -> tuple[Step | None, list[Step]]:
    return _held(asked, Budget())


def _held(asked: Requirement, budget: Budget) -> tuple[Step | None, list[Step]]:
    """Return the first proportions on the way up that hold the torque at all crank angles, and the way to them."""
    path: list[Step] = []
    for of, trial in climbed(asked, budget):
        path.append((of, trial))
        if trial.bears >= asked.torque and (sure := _holding(asked, of, asked.torque)):
            return (of, sure), path
    return None, path


def _holding(asked: Requirement, of: Proportions, torque: float) -> TorqueTrial | None:
    reducer = shaped(asked, of, torque)
    return holds(reducer, torque) if reducer else None


def _tightened(asked: Requirement) -> Requirement:
    """Lower the clearances as far as the backlash asks for and the process can."""
    if asked.backlash == math.inf or asked.clearance or asked.fit:
        return asked
    step = next(climbed(asked.but(discs=asked.discs or 1), Budget()), None)
    if not step:
        return asked
    share = asked.backlash / figure("backlash_arcmin").value(step[1].reducer)
    finest = PROCESSES[asked.process].finest
    return asked.but(clearance=max(min(TIGHTER * share, 1.0) * asked.usual_clearance, finest), tightened=True)


def _most(asked: Requirement, top: Step) -> tuple[float, TorqueTrial]:
    """Find the most torque [N m] that the best proportions are sure to hold, rounded down to three digits."""
    of, trial = top
    trial = settled(trial.reducer, trial.bears)
    torque = SURELY * min(trial.bears, top[1].bears)  # beyond what was seen on the way up, the search would not look
    for _ in range(LOWERINGS):
        torque = _floored(torque)
        if torque < LEAST * GUESS[asked.process] * asked.diameter**3:
            break
        if (sure := _holding(asked, of, torque)) and _has_play(sure.reducer):
            return torque, sure
        torque *= SURELY**2
    return 0.0, replace(trial, weakest=None)


def _has_play(reducer: Reducer) -> bool:
    """Tell whether statics finds the backlash of a drive, which its data sheet tells."""
    try:
        figure("backlash_arcmin").value(reducer)
    except CycloidError:
        return False
    return True


def _floored(value: float) -> float:
    """Round down to three digits."""
    scale = 10.0 ** (math.floor(math.log10(value)) - 2)
    return significant(math.floor(value / scale) * scale)


def _ways(asked: Requirement, top: Step, most: float) -> Iterator[Way]:
    """Yield changes with which the torque is held, each found to work as it would be asked for."""
    budget = Budget(LOOKED_FOR)
    larger = _larger(asked, most, budget)
    if larger and _is_exact(larger.asked):
        yield larger
    yielded = 0
    for way in _conceivable(asked, top, most):
        if yielded < MOST_WAYS and _works(way.asked, top, budget) and _is_exact(way.asked):
            yielded += 1
            yield way
    if not larger and not yielded:
        yield from (way for way in _together(asked) if _is_exact(way.asked))


def _conceivable(asked: Requirement, top: Step, most: float) -> Iterator[Way]:
    limits, weakest = PROCESSES[asked.process], top[1].weakest
    if weakest and (weakest.key == "temperature" or weakest.life is not None):
        share = most / asked.torque if weakest.key == "temperature" else (most / asked.torque) ** 4
        slower = math.floor(COOLER * share * asked.speed / RPM / 10.0) * 10.0 * RPM
        if slower >= SLOWEST:
            yield Way(f"{slower / RPM:.0f} rpm", asked.but(speed=slower))
    if not (asked.clearance or asked.fit) and asked.usual_clearance > limits.finest:
        yield Way(f"a clearance of {1e6 * limits.finest:g} um", asked.but(clearance=limits.finest))
    for material in limits.others:
        if material != asked.made_of:
            yield Way(material, asked.but(material=material))
    if asked.discs in (0, 1):
        yield Way("two discs", asked.but(discs=2))
    for words, changed in _processes(asked):
        yield Way(words, changed)
    if not asked.custom:
        yield Way(FREE, asked.but(custom=True))


def _processes(asked: Requirement) -> Iterator[tuple[str, Requirement]]:
    for process in PROCESSES[asked.process].stronger:
        yield f"{process} in place of {asked.process}", asked.but(process=process, material="", clearance=0.0, fit="")


def _works(asked: Requirement, top: Step, budget: Budget) -> bool:
    """Tell whether a changed requirement is held; a first look at the best proportions saves the search."""
    torque = min(asked.torque, LOOKED_AHEAD * top[1].bears)
    reducer = shaped(asked, top[0], torque)
    if reducer and tried(reducer, torque).bears < PROMISES * torque:
        return False
    return _held(asked, budget)[0] is not None


def _larger(asked: Requirement, bears: float, budget: Budget) -> Way | None:
    """Find a diameter with which the torque is held, from one with which less is [N m].

    Where no drive of a size can be made, as with no parts in stock so large, it lies between that and the one before.
    """
    made, beyond = asked.diameter, math.inf
    for _ in range(TRIES):
        grown = made * max((asked.torque / bears) ** (1.0 / GROWTH), LEAST_STEP) if bears else FAR * made
        larger = _of_diameter(asked, min(grown, math.sqrt(made * beyond)))
        if larger is None or not made < larger.diameter < beyond:
            return None
        step, path = _held(larger, budget)
        if step:
            return Way(f"{1e3 * larger.diameter:g} mm", larger)
        if not path and bears:
            beyond = larger.diameter
        else:
            made, bears = larger.diameter, _borne(path)
    return None


def _borne(path: list[Step]) -> float:
    """Return what the last proportions on a way up are sure to bear [N m]."""
    return SURELY * path[-1][1].bears if path and path[-1][1].rating else 0.0


def _together(asked: Requirement) -> Iterator[Way]:
    """Yield a larger diameter together with another process, slower cranks, or two discs, where none alone is enough.

    The crank of what gets too hot is slowed down first.
    """
    budget = Budget(TOGETHER)
    for also, changed in [*reversed(list(_processes(asked))), ("", asked), ("two discs", asked.but(discs=2))]:
        slower, words = changed, [also] if also else []
        step, path = _held(changed, budget)
        for _ in range(SLOWER):
            speed = math.floor(COOLER * _borne(path) / asked.torque * slower.speed / RPM) * RPM
            if step or not _is_heated(path) or slower.speed <= SLOWEST:
                break
            slower = changed.but(speed=max(speed, SLOWEST))
            step, path = _held(slower, budget)
        if slower != changed:
            words.append(f"{slower.speed / RPM:.0f} rpm")
        larger = None if step or _is_heated(path) or not words else _larger(slower, _borne(path), budget)
        if not (step or larger) and SLOWEST < slower.speed < changed.speed:
            slower, words = changed.but(speed=SLOWEST), words[:-1]
            step, path = _held(slower, budget)
            words.append(f"{slower.speed / RPM:.0f} rpm")
            larger = None if step else _larger(slower, _borne(path), budget)
        if step or larger:
            ends = f" and {larger.words}" if larger else ""
            yield Way(", ".join(words) + ends, larger.asked if larger else slower)
            return


def _is_heated(path: list[Step]) -> bool:
    """Tell whether heat is what the last proportions on a way up bear the least."""
    weakest = path[-1][1].weakest if path else None
    return weakest is not None and weakest.key == "temperature"


def _of_diameter(asked: Requirement, diameter: float) -> Requirement | None:
    """Ask for a diameter [m], rounded up to 1 mm, from 50 mm on to 5 mm, from 200 mm on to 10 mm; none if too large."""
    step = 1e-3 if diameter < 0.05 else 5e-3 if diameter < 0.2 else 1e-2
    rounded = round(math.ceil(diameter / step - 1e-9) * step, 6)
    return asked.but(diameter=rounded) if rounded <= (fits.LARGEST / LARGEST_PAIR if asked.fit else LARGEST) else None


def _shortlist(asked: Requirement, step: Step) -> Iterator[SizedDrive]:
    """Yield the lightest, the stiffest and the longest living of some drives that hold the torque, if they differ."""
    asked = asked.but(covered=covers_fit(step[1].reducer))
    narrowed = _narrowed(asked, step)
    hard = _effort(narrowed[1]) >= HARD
    others = [] if hard else _others(asked, narrowed)
    drives: dict[Design, Step] = {}
    for of, trial in (narrowed, *others):
        drives.setdefault(trial.reducer.design, (of, trial))  # some round to the same parts in stock
    lightest, *rest = _lightest_first(asked, list(drives.values()))
    beside = list(_beside(asked, lightest[1], rest))
    why = f"lowest mass of the candidates without loss of stiffness{_why_so_few(hard, len(beside))}"
    yield _drive(asked, *lightest, "lightest", why)
    yield from (_drive(asked, *one) for one in beside)


def _why_so_few(hard: bool, beside: int) -> str:
    """Return why fewer than two candidates are shown next to the lightest; empty where two are."""
    if hard:
        return "; the only candidate shown, as drives with so much clearance or so many teeth take long to compare"
    differs = f"is {DIFFERENT - 1.0:.0%} stiffer or has {DIFFERENT - 1.0:.0%} more life"
    return {0: f"; the only candidate shown, as no other {differs}", 1: f"; only one other candidate {differs}"}.get(
        beside, ""
    )


def _beside(
    asked: Requirement, lightest: TorqueTrial, rest: list[Step]
) -> Iterator[tuple[Proportions, TorqueTrial, str, str]]:
    """Yield the stiffest and the longest living; or beside one of these alone another that beats the lightest."""
    if not rest:
        return
    stiffer, longer = DIFFERENT * _first_stiffness(lightest.reducer), DIFFERENT * lightest.life
    longest = _best(asked, rest, lambda trial: trial.life, longer)
    others = [one for one in rest if not longest or one[0] != longest[0]]
    reached = _first_stiffness(longest[1].reducer) if longest else 0.0
    stiffest = _best(asked, others, lambda trial: _first_stiffness(trial.reducer), max(reached, stiffer))
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
            (of, trial)
            for of, trial in rest
            if of != one[0] and (trial.life > longer or _first_stiffness(trial.reducer) > stiffer)
        ]
        if between := _best(asked, some, lambda trial: -figure("mass_kg").value(trial.reducer), -math.inf):
            yield (
                *between,
                "in between",
                "stiffer or with more life than the lightest, for the smallest additional mass",
            )


def _best(asked: Requirement, steps: list[Step], merit: Callable[[TorqueTrial], float], least: float) -> Step | None:
    """Return the drive with the most of a merit, above the least, that holds the torque at all crank angles."""
    merits = [(merit(trial), of) for of, trial in steps]
    for looked, of in sorted(merits, key=lambda pair: pair[0], reverse=True):
        if looked <= least:
            return None
        if (sure := _holding(asked, of, asked.torque)) and merit(sure) > least:
            return of, sure
    return None


def _lightest_first(asked: Requirement, steps: list[Step]) -> list[Step]:
    """Put the lightest first that holds the torque at all crank angles, as the first of the steps is known to.

    What is lighter and not as stiff is left out: a light drive is not bought by a soft one.
    """
    first, *others = steps
    masses = {step[0]: figure("mass_kg").value(step[1].reducer) for step in steps}
    lighter = sorted((step for step in others if masses[step[0]] < masses[first[0]]), key=lambda step: masses[step[0]])
    heavier = [step for step in others if masses[step[0]] >= masses[first[0]]]
    stiffness = _first_stiffness(first[1].reducer) if lighter else 0.0
    for of, trial in lighter:
        if _first_stiffness(trial.reducer) >= stiffness and (sure := _holding(asked, of, asked.torque)):
            return [(of, sure), first, *heavier]
    return [first, *heavier]


def _others(asked: Requirement, lightest: Step) -> list[Step]:
    """List drives that hold the torque at a first look beside the lightest: wider, with other pins and bores.

    The stiffest of them is then varied in its turn.
    """
    narrow, left = lightest[0], int(COMPARED / _effort(lightest[1]))
    found: list[Step] = []
    seen = {narrow}
    start: Proportions | None = narrow
    while start and left > 0:
        wide = start.but(width=min(WIDER * start.width, LEVELS["width"][-1]))
        varied = [wide, *(one for change in BESIDE for of in (start, wide) for one in _varied(of, *change))]
        unseen = [of for of in varied if of not in seen][:left]
        seen.update(unseen)
        left -= len(unseen)
        found += [(of, trial) for of in unseen if (trial := _looked_at(asked, of))]
        stiffest = max(found, key=lambda one: _first_stiffness(one[1].reducer), default=lightest)[0]
        start = stiffest if stiffest != start else None
    return found


def _effort(trial: TorqueTrial) -> float:
    """Estimate what a look at a drive costs, over that of one disc which is easily balanced."""
    return trial.reducer.design.gear.discs * (1.0 + trial.work / EASY)


def _varied(of: Proportions, name: str, sense: int) -> Iterator[Proportions]:
    levels = LEVELS[name]
    at = levels.index(getattr(of, name)) + sense
    if 0 <= at < len(levels):
        yield of.but(**{name: levels[at]})


def _looked_at(asked: Requirement, of: Proportions) -> TorqueTrial | None:
    """Try proportions at few crank angles, with a reserve; nothing where they do not hold the torque."""
    reducer = shaped(asked, of, asked.torque)
    trial = tried(reducer, asked.torque) if reducer else None
    return trial if trial and trial.rating and trial.bears >= RESERVE * asked.torque else None


def _narrowed(asked: Requirement, step: Step) -> Step:
    """Return the narrowest drive of found proportions that holds the torque."""
    low, high = NARROWEST, step[0].width
    enough: list[Proportions] = []
    for _ in range(NARROWINGS):
        of = step[0].but(width=math.sqrt(low * high))
        if _looked_at(asked, of):
            high = of.width
            enough.append(of)
        else:
            low = of.width
    for of in reversed(enough):
        if sure := _holding(asked, of, asked.torque):
            return of, sure
    return step


def _drive(asked: Requirement, of: Proportions, trial: TorqueTrial, title: str, why: str) -> SizedDrive:
    figures = _figures(trial)
    if figures["drive_diameter_mm"] > (1.0 + TOUCHING) * figures["outer_diameter_mm"]:
        why += f"; covers of {figures['drive_diameter_mm']:.3g} mm, as no screw in stock fits in the ring's wall"
    return SizedDrive(title, why, trial.reducer.design, figures, dict(reasons_of(asked, of, trial)))


def _figures(trial: TorqueTrial) -> Figures:
    reducer, rating = trial.reducer, trial.rating
    design = reducer.design
    speed, life = design.drive.speed, design.service.life
    about, _ = rated_torque(reducer, speed, life, guess=trial.torque, poses=FEW, exact=TOLD)
    lasting, _ = rated_torque(reducer, speed, life, guess=max(about, trial.torque), exact=TOLD)
    stops = [item.safety or 0.0 for item in rating.items.values() if is_momentary(item.key)] if rating else [0.0]
    momentary = 2.0 * trial.torque * min(stops)
    if momentary < NEARLY * lasting:  # it ends the rated torque: told as the data sheet has it
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
    """Compute the stiffness between half the torque and all of it, one way, at few crank angles [N m/rad]."""
    still, torque = reducer.but(drive={"speed": 0.0}), reducer.design.rated_torque
    springs = springs_of(still, turn_evenly(reducer, FEW), friction=False)
    half, whole = (loads(still, springs, share * torque).output_turn for share in (0.5, 1.0))
    return 0.5 * torque / float((whole - half).mean())


def _stiffness(reducer: Reducer) -> float:
    return figure("stiffness_nm_per_arcmin").value(reducer.but(load={"torque": reducer.design.rated_torque}))
