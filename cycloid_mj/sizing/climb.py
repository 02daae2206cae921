"""The most that a size bears: proportions change where the weakest item asks for it, until no change helps."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import product

from cycloid_mj.sizing.proportions import LEVELS, Proportions, shaped
from cycloid_mj.sizing.requirement import Requirement
from cycloid_mj.sizing.trial import TorqueTrial, settled, tried

HELPS = {
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
"""Part whose item is the weakest -> shares that may help it, and their sense, the most likely first."""

BEGINNINGS = {
    "cam": "cam",
    "shaft": "shaft",
    "output": "output",
    "peak_pin": "output",
    "hole": "output",
    "bore": "output",
    "housing": "housing",
    "temperature": "heat",
}
"""How the key of an item begins -> the part that it is about; others are about the teeth."""

PRESSED = ("peak_yield", "peak_dents")
PRESSURES = ("_yield", "_set")
"""Stops by pressure, and how the items end that tell which contacts are pressed the most."""

GAIN = 1.01
"""A change counts that raises the torque by so much."""

GUESS = {"steel": 6e3, "milled": 3e3, "printed": 1e3}
"""Torque over the cube of the diameter [Pa] at which the search begins; far below what most bear, so statics hold."""

FIRST_SHORT_WIDTHS, FIRST_BORES = (0.78, 0.84, 0.72, 0.6, 0.48, 0.36), (0.42, 0.54)
"""With which the search begins, the usual ones first."""

CLIMB, USUAL_WORK = 40.0, 1.5e4
"""Trials of a climb, and the work of a balance, times the teeth, that costs as much as all else in a trial."""

REMEMBERED = 32
"""First steps that are kept: other torques and backlashes are asked for of the same drives when ways out are found."""

LOOK = 0.1
"""What proportions cost that are drawn and checked, in trials."""

Step = tuple[Proportions, TorqueTrial]


@dataclass
class Budget:
    """What may still be solved, whatever the pace of the machine: one for each drive of few teeth, easily balanced."""

    left: float = CLIMB

    def spend(self, trial: TorqueTrial) -> None:
        """Take one trial from the budget."""
        self.left -= 1.0 + trial.work / USUAL_WORK

    def look(self, asked: Requirement) -> None:
        """Take one look from the budget: proportions drawn and checked where a length is asked for, most too long."""
        self.left -= LOOK if asked.length < math.inf else 0.0


def climbed(asked: Requirement, budget: Budget) -> Iterator[Step]:
    """Yield proportions and what they bear, each better than the one before; nothing where none can be built.

    What is tried does not depend on the torque that is asked for, so that the most that goes is the same for all.
    """
    best = _begun(asked.but(torque=1.0, backlash=math.inf, tightened=False), budget)
    tested: set[Proportions] = set()
    while best:
        yield best
        tested.add(best[0])
        best = _better(asked, best, tested, budget)


def _begun(asked: Requirement, budget: Budget) -> Step | None:
    """Return the first step and take what it costs from a budget; one that is looked for with all of it is kept."""
    step, left = _first(asked, CLIMB)
    if budget.left <= CLIMB - left:
        step, budget.left = _first(asked, budget.left)
    else:
        budget.left -= CLIMB - left
    return step


@lru_cache(maxsize=REMEMBERED)
def _first(asked: Requirement, left: float) -> tuple[Step | None, float]:
    """Return the first proportions that hold a load, or else can be built, and what is left of a budget.

    They are as wide as may be, then as eccentric. Where the play is a good part of the eccentricity, teeth of some
    heights alone hold a load.
    """
    usual, budget = Proportions(), Budget(left)
    widths = [width for width in reversed(LEVELS["width"]) if width <= usual.width]
    guess = GUESS[asked.process] * asked.diameter**3
    built: Step | None = None
    for width, bore, short_width in product(widths, FIRST_BORES, FIRST_SHORT_WIDTHS):
        of = usual.but(short_width=short_width, bore=bore, width=width)
        looked = (width, bore) == (built[0].width, built[0].bore) if built else True
        if not looked or (budget.left <= 0.0 and (built or asked.length < math.inf)):
            break
        budget.look(asked)
        if reducer := shaped(asked, of, guess):
            trial = tried(reducer, guess)
            budget.spend(trial)
            if trial.rating:
                return (of, settled(reducer, guess)), budget.left
            built = built or (of, trial)
    return built, budget.left


def _better(asked: Requirement, best: Step, tested: set[Proportions], budget: Budget) -> Step | None:
    """Return the first change that raises the torque; nothing where none does, or the budget is spent."""
    for of in _changed(best):
        if of in tested:
            continue
        if budget.left <= 0.0:
            return None
        tested.add(of)
        budget.look(asked)
        bears = best[1].bears
        if not (reducer := shaped(asked, of, bears)):
            continue
        trial = tried(reducer, bears)
        budget.spend(trial)
        if trial.rating and trial.bears > GAIN * bears:
            return of, trial
    return None


def _changed(best: Step) -> Iterator[Proportions]:
    of, trial = best
    for name, sense in HELPS[part_of(trial)]:
        at = LEVELS[name].index(getattr(of, name)) + sense
        if 0 <= at < len(LEVELS[name]):
            yield of.but(**{name: LEVELS[name][at]})


def part_of(trial: TorqueTrial) -> str:
    """Name the part that is the weakest: a key of `HELPS`."""
    if not trial.weakest or not trial.rating:
        return "tooth"
    key = trial.weakest.key
    if key in PRESSED:
        items = [item for item in trial.rating.items.values() if item.key.endswith(PRESSURES) and item.unit == "MPa"]
        key = max(items, key=lambda item: item.value / item.limit).key
    return next((part for start, part in BEGINNINGS.items() if key.startswith(start)), "tooth")
