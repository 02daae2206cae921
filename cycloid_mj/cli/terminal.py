"""What reaches the user: results on stdout, messages on stderr."""

import json
import math
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from cycloid_mj.cli.warned import with_warnings

if TYPE_CHECKING:
    from cycloid_mj.result import Table

PIPE_WIDTH = 120

LONGEST_MESSAGE = 4000
"""Characters of a message; of a longer one the start is written."""


def say(text: str) -> None:
    """Write a result; control codes in it, as of a hostile log, are shown and not obeyed."""
    _write(printable(text))


def say_json(value: Any) -> None:
    """Write one JSON object, warnings included; what is no number there (JSON has no NaN) becomes null."""
    noted = with_warnings(value) if isinstance(value, dict) else value
    say(json.dumps(finite(noted), indent=2, allow_nan=False))


def tell(text: str) -> None:
    """Write a message; control codes in it are shown and not obeyed, and of one too long the start is written."""
    text = printable(text)
    if len(text) > LONGEST_MESSAGE:
        text = f"{text[:LONGEST_MESSAGE]}... ({len(text):,} characters in all)"
    sys.stderr.write(f"{text}\n")
    sys.stderr.flush()


def show(table: "Table") -> None:
    """Write a table of results."""
    say_table(table.title, table.header, table.cells)


def say_table(title: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Write a table: the first column names the row, the others are set flush right."""
    say_groups(title, header, [("", rows)])


def say_groups(title: str, header: Sequence[str], groups: Sequence[tuple[str, Sequence[Sequence[str]]]]) -> None:
    """Write a table whose rows stand in groups, each under its name; a group without a name has no heading."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title=printable(title), title_justify="left")
    for number, name in enumerate(header):
        table.add_column(printable(name), justify="right" if number else "left", overflow="fold")
    for name, rows in groups:
        if name:
            table.add_section()
            table.add_row(f"[{printable(name)}]")
        for row in rows:
            table.add_row(*map(printable, row))
    width = None if sys.stdout.isatty() else PIPE_WIDTH
    console = Console(file=sys.stdout, width=width, markup=False, highlight=False)
    with console.capture() as captured:
        console.print(table)
    _write(captured.get().rstrip("\n"))


def printable(text: str) -> str:
    """Give text with what cannot be seen written as its escape, but for spaces, ends of lines and tabs."""
    return "".join(
        sign if sign.isprintable() or sign in "\n\t" else sign.encode("unicode_escape").decode() for sign in text
    )


def _write(text: str) -> None:
    sys.stdout.write(f"{text}\n")


def finite(value: Any) -> Any:
    """Give a value with null in place of what is no number: JSON has no NaN."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
