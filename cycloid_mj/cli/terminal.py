"""Output to the user: results on stdout; messages, log messages of the package and warnings on stderr."""

import json
import logging
import math
import sys
import warnings
from collections.abc import Callable, Container, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

from cycloid_mj.base.errors import CycloidError, CycloidWarning
from cycloid_mj.base.text import escape_controls, legible

if TYPE_CHECKING:
    from cycloid_mj.base.result import Table

PIPE_WIDTH = 120
"""Width of the output [characters] if it is not a terminal."""

_seen: ContextVar[dict[str, None]] = ContextVar("seen")


def say(text: str) -> None:
    """Write a result; control codes in it, as of a hostile log, are shown and not obeyed."""
    _write(printable(text))


def say_json(value: Any) -> None:
    """Print one JSON object with its warnings; NaN and infinities become null."""
    say(json_text(value))


def json_text(value: Any) -> str:
    """Format a JSON object as text, warnings included."""
    content = with_warnings(value) if isinstance(value, dict) else value
    return json.dumps(finite(content), indent=2, allow_nan=False)


def tell(text: str) -> None:
    """Write a message to stderr in one line, with control characters escaped and very long text shortened."""
    sys.stderr.write(f"{legible(text)}\n")
    sys.stderr.flush()


def tell_error(error: CycloidError) -> None:
    """Write an error to stderr: its message, and below it each of its details on an indented line."""
    tell(f"error: {error.message}")
    for line in error.details:
        sys.stderr.write(f"  {line}\n")
    sys.stderr.flush()


def note(text: str) -> None:
    """Print a message as `tell` does, unless ``--quiet`` is set."""
    logging.getLogger(__name__).info("%s", escape_controls(text))


def show(table: "Table") -> None:
    """Write a table of results."""
    say_table(table.title, table.header, table.cells, table.words)


def say_table(
    title: str, header: Sequence[str], rows: Sequence[Sequence[str]], left_aligned: Container[int] = ()
) -> None:
    """Print a table; columns align right, except the first one and those with an index in `left_aligned`."""
    say_groups(title, header, [("", rows)], left_aligned)


def say_groups(
    title: str,
    header: Sequence[str],
    groups: Sequence[tuple[str, Sequence[Sequence[str]]]],
    left_aligned: Container[int] = (),
) -> None:
    """Print a table with grouped rows on stdout, each group under its name; a group without a name has no heading.

    Parameters
    ----------
    title, header
        Title of the table, and names of its columns.
    groups
        Name and rows of each group.
    left_aligned
        Indices of the columns that are aligned left, such as words. The first column always is; others align right.
    """
    from rich.console import Console
    from rich.table import Table

    table = Table(title=printable(title), title_justify="left")
    for column_index, name in enumerate(header):
        table.add_column(
            printable(name),
            justify="right" if column_index and column_index not in left_aligned else "left",
            overflow="fold",
        )
    for name, rows in groups:
        if name:
            table.add_section()
            table.add_row(f"[{printable(name)}]")
        for row in rows:
            table.add_row(*map(printable, row))
    width = None if sys.stdout.isatty() else PIPE_WIDTH
    console = Console(file=sys.stdout, width=width, markup=False, highlight=False)
    with console.capture() as captured_output:
        console.print(table)
    _write(captured_output.get().rstrip("\n"))


def printable(text: str) -> str:
    """Escape the control characters of a text, except line ends and tabs."""
    return escape_controls(text, keep="\n\t")


def _write(text: str) -> None:
    sys.stdout.write(f"{text}\n")


def finite(value: Any) -> Any:
    """Replace NaN and infinities by None, because JSON has neither."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


@contextmanager
def collect_warnings(show: Callable[[str], None] | None) -> Iterator[None]:
    """Collect the package's warnings of all threads while the context is open, and pass each once to `show`.

    If `show` is None, they are collected without being shown. Other Python warnings are shown as usual.
    """
    unique_warnings: dict[str, None] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("always", CycloidWarning)
        show_other_warning = warnings.showwarning

        def collect(message: Warning | str, category: type[Warning], *location: Any, **options: Any) -> None:
            if not issubclass(category, CycloidWarning):
                show_other_warning(message, category, *location, **options)
            elif (text := str(message)) not in unique_warnings:
                unique_warnings[text] = None
                if show:
                    show(f"warning: {text}")

        warnings.showwarning = collect
        previous_state = _seen.set(unique_warnings)
        try:
            yield
        finally:
            _seen.reset(previous_state)


def with_warnings(content: dict[str, Any]) -> dict[str, Any]:
    """Return the JSON object of a command with the collected warnings, unless it has the key ``warnings``."""
    issued = _seen.get(None)
    return content if issued is None or "warnings" in content else content | {"warnings": list(issued)}


@contextmanager
def log_to_stderr(quiet: bool) -> Iterator[None]:
    """Write log messages of level info and above to stderr while the context is open; none if `quiet`."""
    log, handler = logging.getLogger("cycloid_mj"), _Teller()
    level = log.level
    if not quiet:
        log.addHandler(handler)
        log.setLevel(logging.INFO)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(level)


class _Teller(logging.Handler):
    def emit(self, record: logging.LogRecord) -> None:
        tell(record.getMessage())
