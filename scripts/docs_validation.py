"""Write the summary of docs/trust.md and its table for download from the JSON of `cycloid-mj validate`.

python scripts/docs_validation.py          # from docs/data/validation.csv
python scripts/docs_validation.py FILE     # from the output of `cycloid-mj validate --json`, which is kept as CSV

`scripts/docs_figures.py` runs the command and calls this script.
"""

import json
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from docs_page import DATA, DOCS, csv_text, markdown_table, read_csv, replace_sections

PAGE, KEPT = DOCS / "trust.md", DATA / "validation.csv"
SCRIPT = "scripts/docs_validation.py"

COLUMNS = ("rung", "quantity", "source", "ours", "reference", "unit", "error", "bound", "error_unit", "note")
"""Columns of the table for download: the keys of a row in the command's JSON."""


@dataclass(frozen=True)
class Group:
    """A line of the summary: what is compared with what, and the rows of the command that it sums up."""

    result: str
    reference: str
    """Texts of the first two columns."""
    rung: str
    """Part of the command that has the rows."""
    unit: str
    """Unit of their errors."""
    pattern: str = ""
    """Regular expression that the start of a row's quantity or source matches."""

    def rows(self, every: Iterable[Mapping[str, str]]) -> list[Mapping[str, str]]:
        """Return the rows that the line sums up; raise ValueError if there are none."""
        rows = [
            row
            for row in every
            if (row["rung"], row["error_unit"]) == (self.rung, self.unit)
            and row["bound"]
            and float(row["bound"]) > 0.0
            and (re.match(self.pattern, row["quantity"]) or re.match(self.pattern, row["source"]))
        ]
        if not rows:
            raise ValueError(f"no row of the validation belongs to {self.result}, {self.reference}")
        return rows


GROUPS = (
    Group("Contact of two bodies: force, frequency, restitution", "closed forms", "two-body", "%"),
    Group("Friction of blocks and cylinders", "closed forms", "friction", "%"),
    Group("Gaps, forces and stops of the static model", "exact geometry, solved by SciPy", "mechanism", "%"),
    Group("Backlash", "closed form 2 δ/(c (N-1))", "backlash", "%"),
    Group("Load sharing, no clearance", "closed form", "sharing", "%", "ideal"),
    Group("Load sharing with clearance", "independent static solver", "sharing", "%", "static solution"),
    Group("Cam force at low, high and rated load", "closed forms", "cam", "%"),
    Group("Hertz stress (9 values)", "Król et al. 2019", "published", "MPa"),
    Group("Bearing ratings (7 needle cages)", "NTN catalogue 2300/E", "published", "%", "NTN"),
    Group("Efficiency", "Wang et al. 2016", "published", "points"),
    Group("Energy balance of a run", "conservation of energy", "energy", "%"),
    Group("Rms speed, peak-to-peak error, forces", "runs with shorter time steps", "steps", "%"),
    Group("Efficiency", "runs with shorter time steps", "steps", "points"),
    Group("Runs with reversed rotation", "mirror image of the run", "mirror", "%"),
    Group("Effect of gravity", "weight of the parts", "gravity", "%"),
    Group("MuJoCo: transmission error, forces, speeds", "planar solver", "witness", "%"),
    Group("MuJoCo: efficiency", "planar solver", "witness", "points"),
    Group("RV reducer: ratio, wind-up, forces, error map", "closed forms, statics", "rv", "%"),
    Group("RV reducer: efficiency in both solvers", "statics", "rv", "points"),
)


@dataclass(frozen=True)
class Summary:
    """The row of a group that uses most of its allowed error."""

    group: Group
    """Line of the summary."""
    error: float
    bound: float
    """Largest error relative to its bound, and that bound, in the unit of the group."""
    number: int
    """Number of rows in the group."""

    @property
    def share(self) -> float:
        """Return the error as a share of the allowed error."""
        return self.error / self.bound


def summaries(rows: Sequence[Mapping[str, str]]) -> list[Summary]:
    """Find the row with the largest share of its bound in every group."""
    result = []
    for group in GROUPS:
        members = group.rows(rows)
        worst = max(members, key=lambda row: float(row["error"]) / float(row["bound"]))
        result.append(Summary(group, float(worst["error"]), float(worst["bound"]), len(members)))
    return result


def table(rows: Sequence[Mapping[str, str]]) -> str:
    """Return the summary as a Markdown table."""
    head = ("Result", "Compared with", "Number of checks", "Largest error", "Allowed error")
    lines = []
    for worst in summaries(rows):
        errors = (f"{error:.2g} {worst.group.unit}" for error in (worst.error, worst.bound))
        lines.append((worst.group.result, worst.group.reference, str(worst.number), *errors))
    return markdown_table(head, lines)


def read_rows() -> list[dict[str, str]]:
    """Read the kept rows."""
    return read_csv(KEPT)


def keep(content: Mapping[str, Any]) -> None:
    """Write the rows of the command's JSON to the table for download; raise ValueError if a check failed."""
    if not content["passed"] or content["quick"]:
        raise ValueError("the page is written from a full run of `cycloid-mj validate` in which every check passes")
    lines = ([_cell(row.get(name, "")) for name in COLUMNS] for row in content["rows"])
    KEPT.write_text(csv_text([COLUMNS, *lines]), encoding="utf-8", newline="")


def _cell(value: Any) -> Any:
    return f"{value:.6g}" if isinstance(value, float) else value


def main(arguments: Sequence[str]) -> int:
    """Write the page and return the exit code."""
    if arguments:
        keep(json.loads(Path(arguments[0]).read_text(encoding="utf-8")))
    text = replace_sections(PAGE.read_text(encoding="utf-8"), {"summary": table(read_rows())}, SCRIPT)
    PAGE.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
