"""``cycloid-mj figures``: every figure by its key, with unit and definition."""

from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from cycloid_mj.cli.flags import JsonFlag, QuietFlag
from cycloid_mj.cli.terminal import say_json, say_table

if TYPE_CHECKING:
    from cycloid_mj.figures import Figure

NeedFlag = Annotated[
    Literal["geometry", "statics", "life", "stress", "run"] | None,
    Parameter(name="--need", help="Only the figures that are computed from this. Default: all."),
]

EXAMPLES = """Examples:
  cycloid-mj figures
  cycloid-mj figures --need life
  cycloid-mj figures --json"""


def figures(*, need: NeedFlag = None, json: JsonFlag = False, _quiet: QuietFlag = False) -> int:
    """List the figures that commands print, limit and vary, by key.

    A key ends in its unit, and means the same number in `statics`, `sweep
    --measure`, `optimize`, `tolerance` and the data sheet. What a figure needs
    says what it costs: geometry milliseconds, statics tenths of a second, life a
    second, stress (finite elements) and a run minutes. JSON has the older keys
    of each figure too, which flags still take.
    """
    from cycloid_mj.figures import FIGURES

    rows = [row for row in FIGURES.values() if need is None or row.need == need]
    if json:
        say_json({"figures": {row.key: row.as_json() for row in rows}})
    else:
        say_table("figures", ("key", "unit", "needs", "definition"), [_cells(row) for row in rows], words=range(4))
    return 0


def _cells(row: "Figure") -> tuple[str, ...]:
    return row.key, row.unit, row.need, row.definition
