"""Capacity of a size by coordinate search (Hooke & Jeeves 1961); the weakest item selects the change."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import product

from cycloid_mj.sizing.proportions import GRID, Proportions, build_drive
from cycloid_mj.sizing.requirement import Requirement
from cycloid_mj.sizing.trial import TorqueTrial, rate_drive, solve_capacity

MOVES = {
    "tooth": (("width", 1), ("short_width", 1), ("pin", 1), ("short_width", -1), ("pin", -1)),
    "cam": (("width", 1), ("bore", 1), ("short_width", 1)),
    "shaft": (("shaft", 1), ("bore", 1), ("width", -1), ("short_width", 1)),
    "output": (
        ("width", -1),
        ("hole", 1),
        ("bore", -1),
        ("output_pins", 1),
        ("output_pins", -1),
        ("short_width", -1),
        ("width", 1),
    ),
    "housing": (("width", 1), ("wall", 1), ("short_width", 1)),
    "heat": (("width", 1), ("short_width", 1), ("pin", -1)),
}
"""Changes of proportions by the part with the weakest item, the most promising first."""

PART_OF_ITEM = {
    "cam": "cam",
    "shaft": "shaft",
    "output": "output",
    "peak_pin": "output",
    "hole": "output",
    "bore": "output",
    "housing": "housing",
    "temperature": "heat",
}
"""Part by the beginning of the key of an item; other items concern the teeth."""

PRESSURE_STOPS = ("peak_yield", "peak_dents")
PRESSURE_SUFFIXES = ("_yield", "_set")
"""Emergency stops limited by pressure, and the suffixes of items with contact pressures."""

MIN_GAIN = 1.01
"""Minimum ratio of torques for a change to be accepted."""

START_TORQUE = {"steel": 6e3, "milled": 3e3, "printed": 1e3}
"""Start torque over the cube of the diameter [Pa], far below the capacity of most drives."""

FIRST_SHORT_WIDTHS, FIRST_BORES = (0.78, 0.84, 0.72, 0.6, 0.48, 0.36), (0.42, 0.54)
"""Proportions that the search starts with, the usual ones first."""

SEARCH_BUDGET, TRIAL_WORK = 40.0, 1.5e4
"""Trials of a search, and work of an equilibrium times teeth that costs as much as the rest of a trial."""

CACHED_SEARCHES = 32
"""Number of cached first steps, which remedies repeat."""

DRAWING_COST = 0.1
"""Cost of drawing and checking proportions, in trials."""

Step = tuple[Proportions, TorqueTrial]


@dataclass
class Budget:
    """Remaining number of trials, independent of the speed of the machine."""

    left: float = SEARCH_BUDGET

    def spend(self, trial: TorqueTrial) -> None:
        """Subtract a trial from the budget."""
        self.left -= 1.0 + trial.work / TRIAL_WORK

    def look(self, requirement: Requirement) -> None:
        """Subtract the drawing of proportions from the budget if a length is required."""
        self.left -= DRAWING_COST if requirement.length < math.inf else 0.0


def coordinate_search(requirement: Requirement, budget: Budget) -> Iterator[Step]:
    """Yield proportions of increasing capacity; nothing if none can be built.

    The trials do not depend on the required torque, so that the maximum is the same for all torques.
    """
    best = _start(requirement.but(torque=1.0, backlash=math.inf, tightened=False), budget)
    tested: set[Proportions] = set()
    while best:
        yield best
        tested.add(best[0])
        best = _first_improvement(requirement, best, tested, budget)


def _start(requirement: Requirement, budget: Budget) -> Step | None:
    """Return the first step and subtract its cost from a budget; a search with the full budget is cached."""
    step, left = _first(requirement, SEARCH_BUDGET)
    if budget.left <= SEARCH_BUDGET - left:
        step, budget.left = _first(requirement, budget.left)
    else:
        budget.left -= SEARCH_BUDGET - left
    return step


@lru_cache(maxsize=CACHED_SEARCHES)
def _first(requirement: Requirement, left: float) -> tuple[Step | None, float]:
    """Return the first proportions that support a load, or else can be built, and the remaining budget.

    Wide and eccentric proportions come first. If clearances are a large part of the eccentricity, only some tooth
    heights support a load.
    """
    usual, budget = Proportions(), Budget(left)
    widths = [width for width in reversed(GRID["width"]) if width <= usual.width]
    guess = START_TORQUE[requirement.process] * requirement.diameter**3
    built: Step | None = None
    for width, bore, short_width in product(widths, FIRST_BORES, FIRST_SHORT_WIDTHS):
        proportions = usual.but(short_width=short_width, bore=bore, width=width)
        is_considered = (width, bore) == (built[0].width, built[0].bore) if built else True
        if not is_considered or (budget.left <= 0.0 and (built or requirement.length < math.inf)):
            break
        budget.look(requirement)
        if reducer := build_drive(requirement, proportions, guess):
            trial = rate_drive(reducer, guess)
            budget.spend(trial)
            if trial.rating:
                return (proportions, solve_capacity(reducer, guess)), budget.left
            built = built or (proportions, trial)
    return built, budget.left


def _first_improvement(requirement: Requirement, best: Step, tested: set[Proportions], budget: Budget) -> Step | None:
    """Return the first change that increases the capacity; None if there is none or the budget is spent."""
    for proportions in _moves(best):
        if proportions in tested:
            continue
        if budget.left <= 0.0:
            return None
        tested.add(proportions)
        budget.look(requirement)
        capacity = best[1].capacity
        if not (reducer := build_drive(requirement, proportions, capacity)):
            continue
        trial = rate_drive(reducer, capacity)
        budget.spend(trial)
        if trial.rating and trial.capacity > MIN_GAIN * capacity:
            return proportions, trial
    return None


def _moves(best: Step) -> Iterator[Proportions]:
    proportions, trial = best
    for change in MOVES[part_of(trial)]:
        if neighbour := proportions.neighbour(*change):
            yield neighbour


def part_of(trial: TorqueTrial) -> str:
    """Return the part with the weakest item: a key of `MOVES`."""
    if not trial.weakest or not trial.rating:
        return "tooth"
    key = trial.weakest.key
    if key in PRESSURE_STOPS:
        items = [
            item for item in trial.rating.items.values() if item.key.endswith(PRESSURE_SUFFIXES) and item.unit == "MPa"
        ]
        key = max(items, key=lambda item: item.value / item.limit).key
    return next((part for start, part in PART_OF_ITEM.items() if key.startswith(start)), "tooth")
