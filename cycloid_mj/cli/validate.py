"""``cycloid-mj validate``: hold the simulation against closed forms and published cases, rung by rung."""

from time import monotonic
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import JsonFlag
from cycloid_mj.cli.progress import seconds_left
from cycloid_mj.cli.terminal import say, say_json, say_table, tell

if TYPE_CHECKING:
    from cycloid_mj.validate.ladder import RungPart
    from cycloid_mj.validate.row import ValidationRow

EXAMPLES = """Examples:
  cycloid-mj validate --quick
  cycloid-mj validate --only sharing cam
  cycloid-mj validate --json > validation.json"""

HEADER = ("quantity", "ours", "reference", "source", "error", "bound", "result")
FAILURE = 1

QuickFlag = Annotated[bool, Parameter(help="Shorter runs and fewer crank angles: under a minute on two cores.")]
OnlyFlag = Annotated[
    tuple[str, ...], Parameter(metavar="NAME", consume_multiple=True, help="Rungs to climb, by name. Default: all.")
]


def validate(*, quick: QuickFlag = False, only: OnlyFlag = (), json: JsonFlag = False) -> int:
    """Hold the simulation against closed forms and published cases.

    Prints a table of quantity, ours, reference, source, error, bound and
    result, rung by rung: two-body, friction, mechanism, backlash, sharing,
    cam, published, energy, steps, mirror, gravity, witness. "told" marks a row
    without a bound, which states a difference; its reason stands below the table.
    Exit code 1 if any row fails. Two processes at a time, for some minutes.
    """
    tell("starting")
    from cycloid_mj.validate.ladder import chosen

    parts = chosen(only)
    start = monotonic()
    rows = _climbed(parts, quick)
    wall = monotonic() - start
    failed = sum(row.verdict == "fail" for row in rows)
    if json:
        say_json({"passed": not failed, "quick": quick, "wall_s": wall, "rows": [row.as_json() for row in rows]})
    else:
        _report(rows, wall)
    return FAILURE if failed else 0


def _climbed(parts: "tuple[RungPart, ...]", quick: bool) -> "list[ValidationRow]":
    """Run the parts and tell how far they are."""
    from cycloid_mj.validate.ladder import climb, in_order

    start, whole = monotonic(), sum(part.cost[not quick] for part in parts)
    done, climbed = 0.0, []
    for number, rows in climb(parts, quick):
        climbed.append((number, rows))
        done += parts[number].cost[not quick]
        left = seconds_left(start, done / whole)
        tell(f"{len(climbed)} of {len(parts)} parts, last of {parts[number].rung!r}; about {left:.0f} s left")
    return in_order(climbed)


def _report(rows: "list[ValidationRow]", wall: float) -> None:
    """Write the table, the notes below it, and the sum."""
    from cycloid_mj.validate.ladder import RUNGS
    from cycloid_mj.validate.row import RowOutcome

    numbers = {rung: number for number, rung in enumerate(RUNGS, start=1)}
    climbed = dict.fromkeys(row.rung for row in rows)
    title = "validation: " + ", ".join(f"{numbers[rung]} {rung}" for rung in climbed)
    say_table(title, HEADER, [_line(numbers[row.rung], row) for row in rows])
    for row in rows:
        if row.measured.note:
            say(f"{numbers[row.rung]} {row.measured.name} ({row.measured.source}): {row.measured.note}")
    counts = (f"{sum(row.verdict == each for row in rows)} {each}" for each in RowOutcome)
    say(f"{', '.join(counts)}; {wall:.0f} s")


def _line(number: int, row: "ValidationRow") -> tuple[str, ...]:
    """Format a row as text; the bound is in the error's unit."""
    one = row.measured
    return (
        f"{number} {one.name}",
        f"{one.value:.5g} {one.unit}".strip(),
        f"{one.reference:.5g}",
        one.source,
        f"{row.difference:.2g} {row.difference_unit}".strip(),
        "" if row.bound is None else f"{row.bound:.3g}",
        row.verdict,
    )
