"""HTML from Python values: text is escaped here and nowhere else."""

from collections.abc import Iterable, Sequence
from html import escape

Row = Sequence[str]


def tag(name: str, content: str = "", **attributes: str) -> str:
    """Give an element whose content is HTML already; a trailing underscore of an attribute's name is dropped."""
    told = "".join(f' {key.rstrip("_").replace("_", "-")}="{escape(value)}"' for key, value in attributes.items())
    return f"<{name}{told}>{content}</{name}>"


def text(words: str) -> str:
    """Give plain text as HTML."""
    return escape(words)


def table(head: Iterable[Row], body: Iterable[Row], **attributes: str) -> str:
    """Give a table of plain text in a box that scrolls where it is too wide; the first cell of a row names it.

    A cell of the head that is followed by empty ones spans them. A row of one cell is the heading of those below.
    """
    head, body = list(head), list(body)
    rows = "".join(tag("tr", _spanned(row)) for row in head)
    width = max(map(len, (*head, *body)), default=1)
    lines = "".join(_line(row, width) for row in body)
    inside = (tag("thead", rows) if rows else "") + tag("tbody", lines)
    return tag("div", tag("table", inside, **attributes), class_="scroll", tabindex="0")


def _line(row: Row, width: int) -> str:
    first, *cells = row
    if not cells and width > 1:
        return tag("tr", tag("th", text(first), scope="rowgroup", colspan=str(width)), class_="group")
    return tag("tr", tag("th", text(first), scope="row") + "".join(tag("td", text(cell)) for cell in cells))


def _spanned(row: Row) -> str:
    starts = [i for i, cell in enumerate(row) if cell or i == 0]
    ends = [*starts[1:], len(row)]
    return "".join(
        tag("th", text(row[start]), scope="col", colspan=str(end - start))
        for start, end in zip(starts, ends, strict=True)
    )
