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

    A cell of the head that is followed by empty ones spans them.
    """
    rows = "".join(tag("tr", _spanned(row)) for row in head)
    lines = "".join(
        tag("tr", tag("th", text(first), scope="row") + "".join(tag("td", text(cell)) for cell in cells))
        for first, *cells in body
    )
    inside = (tag("thead", rows) if rows else "") + tag("tbody", lines)
    return tag("div", tag("table", inside, **attributes), class_="scroll", tabindex="0")


def _spanned(row: Row) -> str:
    starts = [i for i, cell in enumerate(row) if cell or i == 0]
    ends = [*starts[1:], len(row)]
    return "".join(
        tag("th", text(row[start]), scope="col", colspan=str(end - start))
        for start, end in zip(starts, ends, strict=True)
    )
