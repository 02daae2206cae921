"""``cycloid-mj validate``: compare the simulation with closed forms and published cases."""

from time import monotonic
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_mj.base.outcome import Outcome
from cycloid_mj.base.result import Table
from cycloid_mj.cli.delivery import claim_destination, deliver
from cycloid_mj.cli.flags import DELIVERY, FLAT, Delivery
from cycloid_mj.cli.progress import seconds_left
from cycloid_mj.cli.terminal import note

if TYPE_CHECKING:
    from cycloid_mj.base.validation import ValidationPart, ValidationRow

EXAMPLES = """Examples:
  cycloid-mj validate --quick
  cycloid-mj validate --only sharing cam
  cycloid-mj validate --json > validation.json"""

HEADER = ("quantity", "ours", "reference", "source", "error", "bound", "result")
STEM = "validation"

QuickFlag = Annotated[bool, Parameter(help="Use shorter runs and fewer crank angles: less than a minute on two cores.")]
OnlyFlag = Annotated[
    tuple[str, ...], Parameter(metavar="NAME", consume_multiple=True, help="Names of validation steps. Default: all.")
]


def validate(
    *, quick: QuickFlag = False, only: OnlyFlag = (), output_flags: Annotated[Delivery, FLAT] = DELIVERY
) -> int:
    """Compare the simulation with closed forms and published cases.

    The steps are, from simple to complex: two-body (a single contact), friction (bodies on
    an incline), mechanism (gaps and forces of the static model), backlash, sharing (load
    sharing of the teeth), cam (load on the cam), published (published results), energy
    (energy balance), steps (shorter time steps), mirror (reversed rotation), gravity (effect
    of the weight), witness (MuJoCo against the planar solver), rv (an RV reducer by statics
    and both solvers). A row has quantity, our value, reference, source, error, bound and
    result. Failed rows are always printed, all
    rows only with --all. The result "stated" means that the row has no bound for its error;
    a note explains the error. The exit code is 1 if a row fails. The validation takes some
    minutes on two cores.
    """
    note("starting")
    from cycloid_mj.base.engine.engine import cores
    from cycloid_mj.life import witnesses
    from cycloid_mj.validate.suite import select_parts

    parts = select_parts(only, witnesses.PARTS)
    destination = claim_destination(output_flags, STEM)
    start = monotonic()
    rows = _run_parts(parts, quick, output_flags.workers or cores())
    return deliver(_outcome(rows, quick, monotonic() - start), destination, output_flags)


def _run_parts(parts: "tuple[ValidationPart, ...]", quick: bool, workers: int) -> "list[ValidationRow]":
    """Run the parts of a validation in `workers` processes with progress on stderr; return the rows of all of them.

    A row compares a value with a reference. With `quick`, the parts use fewer cases.
    """
    from cycloid_mj.validate.suite import run_parts, sort_rows

    start_time, total_cost = monotonic(), sum(part.cost[not quick] for part in parts)
    finished_cost, finished_parts = 0.0, []
    for index, rows in run_parts(parts, quick, workers):
        finished_parts.append((index, rows))
        finished_cost += parts[index].cost[not quick]
        remaining_time = seconds_left(start_time, finished_cost / total_cost)
        note(
            f"{len(finished_parts)} of {len(parts)} parts of the validation finished, last: {parts[index].rung}; about "
            f"{remaining_time:.0f} s left"
        )
    return sort_rows(finished_parts)


def _outcome(rows: "list[ValidationRow]", quick: bool, wall: float) -> Outcome:
    """Convert the rows of a validation to printable results: failed rows first.

    `quick` is whether the validation was the shorter one, `wall` its duration [s].
    """
    from cycloid_mj.base.frame import make_frame
    from cycloid_mj.base.validation import RowOutcome
    from cycloid_mj.validate.suite import STEP_NAMES

    step_numbers = {name: step_number for step_number, name in enumerate(STEP_NAMES, start=1)}
    step_names = dict.fromkeys(row.rung for row in rows)
    counts = {row_outcome: sum(row.verdict == row_outcome for row in rows) for row_outcome in RowOutcome}
    failed_rows = [_format_row(step_numbers[row.rung], row) for row in rows if row.verdict is RowOutcome.FAIL]
    json_rows = [row.as_json() for row in rows]
    return Outcome(
        title="validation: " + ", ".join(f"{step_numbers[name]} {name}" for name in step_names),
        failures=[
            f"{name}: {result}, {source}: {reference}; difference {deviation}"
            for name, result, reference, source, deviation, *_ in failed_rows
        ],
        summary=[f"{', '.join(f'{count} {row_outcome}' for row_outcome, count in counts.items())}; {wall:.0f} s"],
        tables=[Table("every row", HEADER, tuple(_format_row(step_numbers[row.rung], row) for row in rows))],
        notes=[
            f"{step_numbers[row.rung]} {row.measured.name} ({row.measured.source}): {row.measured.note}"
            for row in rows
            if row.measured.note
        ],
        frame=make_frame(json_rows, json_rows[0] if json_rows else (), {}),
        result={"passed": not failed_rows, "quick": quick, "wall_s": wall, "rows": json_rows},
        code=1 if failed_rows else 0,
    )


def _format_row(step_number: int, row: "ValidationRow") -> tuple[str, ...]:
    """Format a row of a validation as cells of text; `step_number` is that of its step.

    The bound is in the unit of the error.
    """
    quantity = row.measured
    return (
        f"{step_number} {quantity.name}",
        f"{quantity.value:.5g} {quantity.unit}".strip(),
        f"{quantity.reference:.5g}",
        quantity.source,
        f"{row.difference:.2g} {row.difference_unit}".strip(),
        "" if row.bound is None else f"{row.bound:.3g}",
        row.verdict,
    )
