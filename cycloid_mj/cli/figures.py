"""``cycloid-mj figures``: every figure by its key, with unit and definition."""

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from cycloid_mj.base.outcome import Outcome
from cycloid_mj.base.result import Table
from cycloid_mj.cli.delivery import claim_destination, deliver
from cycloid_mj.cli.flags import DELIVERY, FLAT, Delivery

if TYPE_CHECKING:
    from cycloid_mj.figures import Figure

NeedFlag = Annotated[
    Literal["geometry", "statics", "life", "stress", "run"] | None,
    Parameter(name="--need", help="Only quantities that are computed from this. Default: all."),
]

EXAMPLES = """Examples:
  cycloid-mj figures
  cycloid-mj figures --need life
  cycloid-mj figures --json"""


HEADER = ("key", "unit", "needs", "definition")


def figures(*, need: NeedFlag = None, output_flags: Annotated[Delivery, FLAT] = DELIVERY) -> int:
    """List all quantities that commands print, limit and vary, by key.

    A key ends in its unit and denotes the same quantity in `statics`, `sweep --measure`, `optimize`, `tolerance` and
    the data sheet. The column "needs" shows the cost: geometry takes milliseconds, statics tenths of a second, life
    a second, stress (finite elements) and run (simulation) minutes. JSON includes former keys, which are still
    accepted.
    """
    from cycloid_mj.base.frame import make_frame
    from cycloid_mj.figures import FIGURES

    destination = claim_destination(output_flags, "figures")
    rows = [row for row in FIGURES.values() if need is None or row.need == need]
    cells = tuple(map(_cells, rows))
    outcome = Outcome(
        title=f"{len(rows)} figures",
        tables=[Table("figures", HEADER, cells, words=range(len(HEADER)))],
        frame=make_frame([dict(zip(HEADER, row, strict=True)) for row in cells], HEADER, {}),
        result={"figures": {row.key: row.as_json() for row in rows}},
    )
    # the list is the requested result, however long
    return deliver(outcome, destination, replace(output_flags, all=True))


def _cells(row: "Figure") -> tuple[str, ...]:
    return row.key, row.unit, row.need, row.definition
