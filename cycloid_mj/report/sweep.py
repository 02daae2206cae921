"""The page of a sweep: fills the template ``assets/sweep.html``."""

from base64 import b64encode
from collections.abc import Sequence

from cycloid_mj.base.result import Table
from cycloid_mj.base.text import four_digits
from cycloid_mj.design import dump
from cycloid_mj.explore.ranks import tabulate_quantities
from cycloid_mj.explore.sweeps import Sweep
from cycloid_mj.report.page import environment
from cycloid_mj.report.tables import TextTable

MAX_ERRORS = 12
"""Different errors that the page lists."""

MAX_ROWS = 500
"""Points that the page lists; the files contain all of them."""


def sweep_page(sweep: Sweep, quantities: Sequence[str], figure: bytes) -> str:
    """Return a sweep as one HTML page: inputs, ranges of quantities, correlations, errors and the figure.

    `quantities` are names of numeric columns, and `figure` is the content of an SVG file.
    """
    task = sweep.task
    return (
        environment()
        .get_template("sweep.html")
        .render(
            title=f"cycloid_mj: sweep of {task.reducer.design.name}",
            sweep=sweep,
            varied=_inputs_table(sweep),
            figure=b64encode(figure).decode(),
            tables=tabulate_quantities(sweep, tuple(quantities)),
            errors=list(sweep.errors.items())[:MAX_ERRORS],
            more_errors=max(0, len(sweep.errors) - MAX_ERRORS),
            rows=_points_table(sweep, quantities),
            texts=TextTable.of,
            shown=min(len(sweep), MAX_ROWS),
            cpu=sum(row.cpu for row in sweep.rows.values()),
            design=dump(task.reducer.design),
        )
    )


def _inputs_table(sweep: Sweep) -> Table:
    """Tabulate the varied keys of a sweep with their values: a range for numbers, a list for words.

    Further rows have the keys that follow from varied keys, with their rules.
    """
    rows = []
    for key in sweep.task.keys:
        values = list(dict.fromkeys(sweep[key].tolist()))
        if key in sweep.frame.numbers:
            text = f"{min(values):g} to {max(values):g}, {len(values)} values"
        else:
            text = ", ".join(map(str, values))
        rows.append((key, text))
    rows += [(link.key, f"follows: {link.words}") for link in sweep.task.links]
    return Table("inputs", ("key of the design file", "values"), tuple(rows))


def _points_table(sweep: Sweep, quantities: Sequence[str]) -> Table:
    """Tabulate the first `MAX_ROWS` points with inputs, linked keys, quantities and errors; NaN is an empty cell."""
    linked_keys = (link.key for link in sweep.task.links)
    names = ("point", *sweep.task.keys, *linked_keys, *quantities, "error")
    columns = [sweep[name][:MAX_ROWS].tolist() for name in names]
    cells = ((str(point), *map(_format_cell, values)) for point, *values in zip(*columns, strict=True))
    return Table("points", names, tuple(cells))


def _format_cell(value: float | str | bool) -> str:
    return "" if value != value else four_digits(value) if isinstance(value, float) else str(value)
