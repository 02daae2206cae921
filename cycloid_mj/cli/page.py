"""Help pages: as wide as the terminal, from 60 to 80 columns, with paragraphs that fill this width."""

import re
from typing import TYPE_CHECKING

from cyclopts import App, Parameter

if TYPE_CHECKING:
    from rich.console import Console

NARROWEST, WIDEST = 60, 80
"""Columns of a help page on a narrow terminal, and on a wide one or none: below 60, names of flags would be cut off."""

FLAGS = Parameter(negative=(), show_default=False)
"""Settings of all flags: no ``--no-...`` or ``--empty-...``, and the default is stated in the help text."""

LINE_CONTINUATION = " \\"
"""Continuation of a shell command on the next line."""


def console(stderr: bool = False) -> "Console":
    """Return the console that prints help pages, to stdout or to `stderr`."""
    from rich.console import Console

    width = min(WIDEST, max(NARROWEST, Console(stderr=stderr).width))
    return Console(stderr=stderr, width=width, highlight=False)


def set_help_format(app: App) -> App:
    """Set the format of the help pages of an app and of all its commands, in place; return the app.

    Paragraphs are joined to single lines, which break at the page width. Flags have no negative form (``--no-...``).
    """
    # its own, too: the command reference and completion look at a command without the defaults of the app around it
    app.default_parameter = FLAGS
    app.help = paragraphs(app.help)
    app.help_epilogue = "\n".join(fold_line(line) for line in (app.help_epilogue or "").splitlines()) or None
    for name in commands(app):
        set_help_format(app[name])
    return app


def fold_line(line: str) -> str:
    """Break a command line that is wider than a page into several lines, which end in a backslash except the last."""
    if len(line) <= WIDEST:
        return line
    command, *flags = re.split(r" (?=--|&& )", line)
    lines = [command]
    for flag in flags:
        if len(lines[-1]) + len(flag) + len(LINE_CONTINUATION) < WIDEST:
            lines[-1] += f" {flag}"
        else:
            lines.append(f"      {flag}")
    return f"{LINE_CONTINUATION}\n".join(lines)


def commands(app: App) -> list[str]:
    """List the names of an app's commands."""
    return [name for name in app if not name.startswith("-")]


def paragraphs(text: str) -> str:
    """Join each paragraph of a docstring into one line."""
    return "\n\n".join(" ".join(paragraph.split()) for paragraph in re.split(r"\n\s*\n", text.strip()))
