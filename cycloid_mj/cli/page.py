"""Help pages: as wide as the terminal, but no wider than reads well; their paragraphs fill that width."""

import re
from typing import TYPE_CHECKING

from cyclopts import App

if TYPE_CHECKING:
    from rich.console import Console

WIDEST = 80
"""Columns of a help page on a wide terminal, and where there is none."""

FOLD = " \\"
"""At the end of a line that a shell goes on from."""


def console(stderr: bool = False) -> "Console":
    """Return the console that help pages are printed on: stdout or `stderr`."""
    from rich.console import Console

    return Console(stderr=stderr, width=min(WIDEST, Console(stderr=stderr).width), highlight=False)


def flowing(app: App) -> App:
    """Build an app whose help, and that of all its commands, breaks lines where the page ends, not the source."""
    app.help = paragraphs(app.help)
    app.help_epilogue = "\n".join(folded(line) for line in (app.help_epilogue or "").splitlines()) or None
    for name in commands(app):
        flowing(app[name])
    return app


def folded(line: str) -> str:
    """Break a command that is wider than a page between its flags, so that a shell takes it as one."""
    if len(line) <= WIDEST:
        return line
    first, *flags = re.split(r" (?=--|&& )", line)
    lines = [first]
    for flag in flags:
        if len(lines[-1]) + len(flag) + len(FOLD) < WIDEST:
            lines[-1] += f" {flag}"
        else:
            lines.append(f"      {flag}")
    return f"{FOLD}\n".join(lines)


def commands(app: App) -> list[str]:
    """List the names of an app's commands."""
    return [name for name in app if not name.startswith("-")]


def paragraphs(text: str) -> str:
    """Join each paragraph of a docstring into one line."""
    return "\n\n".join(" ".join(paragraph.split()) for paragraph in re.split(r"\n\s*\n", text.strip()))
