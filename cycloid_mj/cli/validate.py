"""``cycloid-mj validate``: hold the simulation against closed forms and published cases, rung by rung."""

from time import monotonic
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_mj.base.outcome import Outcome
from cycloid_mj.base.result import Table
from cycloid_mj.cli.delivery import claimed, deliver
from cycloid_mj.cli.flags import DELIVERY, FLAT, Delivery
from cycloid_mj.cli.progress import seconds_left
from cycloid_mj.cli.terminal import note

if TYPE_CHECKING:
    from cycloid_mj.base.validation import ValidationRow
    from cycloid_mj.validate.ladder import RungPart

EXAMPLES = """Examples:
  cycloid-mj validate --quick
  cycloid-mj validate --only sharing cam
  cycloid-mj validate --json > validation.json"""

HEADER = ("quantity", "ours", "reference", "source", "error", "bound", "result")
FAILURE = 1
STEM = "validation"

QuickFlag = Annotated[bool, Parameter(help="Shorter runs and fewer crank angles: under a minute on two cores.")]
OnlyFlag = Annotated[
    tuple[str, ...], Parameter(metavar="NAME", consume_multiple=True, help="Rungs to climb, by name. Default: all.")
]


def validate(*, quick: QuickFlag = False, only: OnlyFlag = (), delivery: Annotated[Delivery, FLAT] = DELIVERY) -> int:
    """Hold the simulation against closed forms and other sources.

    Rows of quantity, ours, reference, source, error, bound and result (all of
    them with --all), rung by rung: two-body, friction, mechanism, backlash, sharing,
    cam, published, energy, steps, mirror, gravity, witness. "told" marks a row
    without a bound, which states a difference; its reason stands below the table.
    Exit code 1 if any row fails. Two processes at a time, unless --workers, for some minutes.
    """
    note("starting")
    from cycloid_mj.validate.ladder import WORKERS, chosen

    parts = chosen(only)
    place = claimed(delivery, STEM)
    start = monotonic()
    rows = _climbed(parts, quick, delivery.workers or WORKERS)
    return deliver(_outcome(rows, quick, monotonic() - start), place, delivery)


def _climbed(parts: "tuple[RungPart, ...]", quick: bool, workers: int) -> "list[ValidationRow]":
    """Run the parts and tell how far they are."""
    from cycloid_mj.validate.ladder import climb, in_order

    start, whole = monotonic(), sum(part.cost[not quick] for part in parts)
    done, climbed = 0.0, []
    for number, rows in climb(parts, quick, workers):
        climbed.append((number, rows))
        done += parts[number].cost[not quick]
        left = seconds_left(start, done / whole)
        note(f"{len(climbed)} of {len(parts)} parts, last of {parts[number].rung!r}; about {left:.0f} s left")
    return in_order(climbed)


def _outcome(rows: "list[ValidationRow]", quick: bool, wall: float) -> Outcome:
    from cycloid_mj.base.frame import framed
    from cycloid_mj.base.validation import RowOutcome
    from cycloid_mj.validate.ladder import RUNGS

    numbers = {rung: number for number, rung in enumerate(RUNGS, start=1)}
    climbed = dict.fromkeys(row.rung for row in rows)
    counts = {each: sum(row.verdict == each for row in rows) for each in RowOutcome}
    failed = [_line(numbers[row.rung], row) for row in rows if row.verdict is RowOutcome.FAIL]
    table = [row.as_json() for row in rows]
    return Outcome(
        title="validation: " + ", ".join(f"{numbers[rung]} {rung}" for rung in climbed),
        failures=[
            f"{name}: {ours}, {source}: {reference}; off by {off}" for name, ours, reference, source, off, *_ in failed
        ],
        summary=[f"{', '.join(f'{count} {each}' for each, count in counts.items())}; {wall:.0f} s"],
        tables=[Table("every row", HEADER, tuple(_line(numbers[row.rung], row) for row in rows))],
        notes=[
            f"{numbers[row.rung]} {row.measured.name} ({row.measured.source}): {row.measured.note}"
            for row in rows
            if row.measured.note
        ],
        frame=framed(table, table[0] if table else (), {}),
        result={"passed": not failed, "quick": quick, "wall_s": wall, "rows": table},
        code=FAILURE if failed else 0,
    )


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
