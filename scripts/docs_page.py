"""Generated sections of the documentation's pages, and tables for download; the other `docs_*.py` scripts use them.

A generated section lies between two comments, which name the section and the script that writes it.
"""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from cycloid_mj.base.result import Table

DOCS = Path(__file__).resolve().parent.parent / "docs"
DATA = DOCS / "data"
"""Folder of the tables that the pages offer for download."""

MARK = "<!-- {word} of {name}: {script} writes what stands here -->"


def replace_sections(page: str, sections: Mapping[str, str], script: str) -> str:
    """Return the text of a page with its generated sections replaced by others, by the names in their marks.

    `script` is the calling script as the marks name it. Raise ValueError if the page lacks the marks of a section.
    """
    for name, text in sections.items():
        begin, end = (MARK.format(word=word, name=name, script=script) for word in ("Begin", "End"))
        if begin not in page or end not in page:
            raise ValueError(f"the page lacks {begin} or {end}")
        page = f"{page.partition(begin)[0]}{begin}\n\n{text}\n\n{end}{page.partition(end)[2]}"
    return page


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table."""
    return Table("", tuple(head), tuple(map(tuple, rows))).as_markdown()


def csv_text(lines: Iterable[Iterable[Any]]) -> str:
    """Return lines of cells as CSV text."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(lines)
    return text.getvalue()


def read_csv(path: Path) -> list[dict[str, str]]:
    """Read the rows of a table for download, each by its column names."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
