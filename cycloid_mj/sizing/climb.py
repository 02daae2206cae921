"""The most that a size bears: proportions change where the weakest item asks for it, until no change helps."""

from collections.abc import Iterator
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

Step = tuple[Proportions, TorqueTrial]


def climbed(asked: Requirement) -> Iterator[Step]:
    """Yield proportions and what they bear, each better than the one before; nothing where none can be built.

    What is tried does not depend on the torque that is asked for, so that the most that goes is the same for all.
    """
    best = _first(asked)
    tested: set[Proportions] = set()
    while best:
        yield best
        tested.add(best[0])
        best = _better(asked, best, tested)


def _first(asked: Requirement) -> Step | None:
    """Return the first proportions that can be built: as wide as may be, then as eccentric."""
    usual = Proportions()
    widths = [width for width in reversed(LEVELS["width"]) if width <= usual.width]
    short_widths = sorted(LEVELS["short_width"], key=lambda level: abs(level - usual.short_width))
    guess = GUESS[asked.process] * asked.diameter**3
    for width, short_width in product(widths, short_widths):
        of = usual.but(short_width=short_width, width=width)
        if reducer := shaped(asked, of, guess):
            return of, settled(reducer, guess)
    return None


def _better(asked: Requirement, best: Step, tested: set[Proportions]) -> Step | None:
    """Return the first change that raises the torque; nothing where none does."""
    for of in _changed(best):
        if of in tested:
            continue
        tested.add(of)
        bears = best[1].bears
        reducer = shaped(asked, of, bears)
        trial = tried(reducer, bears) if reducer else None
        if trial and trial.rating and trial.bears > GAIN * bears:
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
