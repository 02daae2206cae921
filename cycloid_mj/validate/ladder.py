"""The ladder: every rung's parts, and how they are run, two at a time in processes of their own."""

import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module

from cycloid_mj.base.engine import Engine
from cycloid_mj.base.errors import CycloidError, CycloidWarning, UsageError
from cycloid_mj.base.validation import ValidationRow, broken
from cycloid_mj.validate import (
    backlash,
    balance,
    cam_load,
    energy,
    incline,
    mechanism,
    published,
    shakedown,
    sharing,
    steps,
    symmetry,
    two_bodies,
    witness,
)
from cycloid_mj.validate.rig import FIXED, FREE, KINDS, NONPIN, SLEEVED

RUNGS = (
    *("two-body", "friction", "mechanism", "backlash", "sharing", "cam"),
    *("published", "energy", "steps", "mirror", "gravity"),
    "witness",
)
"""Name of every rung, from the ground up."""

OF_ROOMS_BESIDE = ("cycloid_mj.life.witnesses:bearing_rows", "cycloid_mj.life.witnesses:fatigue_rows")
"""Functions of rooms beside this one that give rows, each imported when it is run."""

WORKERS = 2


@dataclass(frozen=True)
class RungPart:
    """A part of a rung that runs on its own.

    Attributes
    ----------
    rung
        Name of its rung.
    rows
        Gives its rows; takes whether to be quick.
    cost
        Seconds that it takes, quick and in full, on one core of 2026: the longest parts start first.
    """

    rung: str
    rows: Callable[[bool], list[ValidationRow]]
    cost: tuple[float, float]


def _parts() -> Iterator[RungPart]:
    yield RungPart("two-body", two_bodies.rows, (1.0, 1.0))
    yield RungPart("friction", incline.rows, (0.2, 0.2))
    yield RungPart("mechanism", mechanism.rows, (9.0, 9.0))
    yield RungPart("mechanism", balance.rows, (9.0, 9.0))
    yield RungPart("backlash", backlash.rows, (4.0, 4.0))
    for kind in KINDS:
        yield RungPart("sharing", partial(sharing.ideal_rows, kind), (1.0, 2.0))
    yield RungPart("sharing", sharing.patch_rows, (1.5, 2.5))
    for kind, cost in ((FIXED, (1.0, 2.0)), (FREE, (2.0, 4.0)), (NONPIN, (7.0, 15.0))):
        yield RungPart("sharing", partial(sharing.clearance_rows, kind), cost)
    yield RungPart("cam", cam_load.rows, (6.0, 7.0))
    yield RungPart("published", published.hertz_rows, (0.1, 0.1))
    yield RungPart("published", published.efficiency_rows, (1.0, 2.0))
    yield RungPart("published", published.printed_rows, (3.0, 3.0))
    yield RungPart("published", published.two_disc_rows, (0.2, 0.5))
    for name in OF_ROOMS_BESIDE:
        yield RungPart("published", partial(_imported, name), (0.1, 0.1))
    yield RungPart("published", shakedown.rows, (0.1, 0.1))
    for kind, cost in ((FIXED, (0.7, 2.0)), (FREE, (2.0, 4.0)), (NONPIN, (1.0, 3.0))):
        yield RungPart("energy", partial(energy.rows, kind), cost)
    yield RungPart("energy", energy.idle_rows, (1.0, 1.0))
    yield RungPart("energy", energy.jolt_rows, (2.0, 2.0))
    for kind, cost in ((FIXED, (0.4, 2.0)), (FREE, (2.5, 7.0)), (SLEEVED, (2.0, 6.0)), (NONPIN, (0.5, 2.5))):
        yield RungPart("steps", partial(steps.rows, kind), cost)
    for kind, cost in ((FIXED, (1.0, 1.2)), (FREE, (2.5, 4.0)), (NONPIN, (1.3, 2.0))):
        yield RungPart("mirror", partial(symmetry.mirror_rows, kind), cost)
    yield RungPart("gravity", partial(symmetry.gravity_rows, FIXED), (4.0, 4.0))
    yield RungPart("gravity", partial(symmetry.gravity_rows, FREE), (12.0, 12.0))
    yield RungPart("witness", witness.rows, (6.0, 6.0))


def _imported(name: str, quick: bool) -> list[ValidationRow]:
    """Return the rows of a function of another room, named as module:function."""
    module, _, function = name.partition(":")
    rows: list[ValidationRow] = getattr(import_module(module), function)(quick)
    return rows


PARTS = tuple(_parts())


def chosen(only: Sequence[str] = ()) -> tuple[RungPart, ...]:
    """List the parts of some rungs, or of all.

    Raises
    ------
    UsageError
        There is no rung of a name.
    """
    unknown = [name for name in only if name not in RUNGS]
    if unknown:
        raise UsageError(f"there is no rung {unknown[0]!r} to validate; choose from: {', '.join(RUNGS)}")
    return tuple(part for part in PARTS if not only or part.rung in only)


def climb(
    parts: Sequence[RungPart], quick: bool = False, workers: int = WORKERS
) -> Iterator[tuple[int, list[ValidationRow]]]:
    """Run parts and give the number and the rows of each as it ends, the longest first.

    A part that cannot be run gives one row, which fails and says why.
    """
    order = sorted(range(len(parts)), key=lambda number: parts[number].cost[not quick], reverse=True)
    work = [(parts[number], quick) for number in order]
    # a single part needs no process of its own
    for place, (rows, issued) in Engine(workers if len(work) > 1 else 1).stream(_run, work):
        for text in issued:
            warnings.warn(text, CycloidWarning, stacklevel=2)
        yield order[place], rows


def in_order(rung_rows: Iterable[tuple[int, list[ValidationRow]]]) -> list[ValidationRow]:
    """List all rows in the order of the ladder."""
    return [row for _, rows in sorted(rung_rows, key=lambda one: one[0]) for row in rows]


def _run(work: tuple[RungPart, bool]) -> tuple[list[ValidationRow], list[str]]:
    """Run a part; give also what it was warned of, which would not leave a process of its own."""
    part, quick = work
    with warnings.catch_warnings(record=True) as issued:
        warnings.simplefilter("always")
        try:
            rows = part.rows(quick)
        except CycloidError as error:
            rows = [broken(str(error))]
    return [replace(row, rung=part.rung) for row in rows], [str(one.message) for one in issued]
