"""The page of a study of many designs or samples: what the template ``assets/study.html`` is filled with."""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from cycloid_mj.base.result import Table
from cycloid_mj.plots.save import drawn
from cycloid_mj.report.page import environment
from cycloid_mj.report.tables import TextTable as Texts


@dataclass(frozen=True)
class PageSection:
    """One section of the page: its title, a paragraph, figures by what their captions say, tables, and notes."""

    title: str
    text: str = ""
    figures: Mapping[str, Figure] | None = None
    tables: Sequence[Table] = ()
    notes: Sequence[str] = ()


def study_page(title: str, about: Sequence[str], numbers: Mapping[str, str], parts: Sequence[PageSection]) -> str:
    """Write a study as one page that needs no other file.

    Parameters
    ----------
    title
        Of the page.
    about
        Lines on what was done, and under what condition.
    numbers
        What one looks for first, by name.
    parts
        The sections.
    """
    return (
        environment()
        .get_template("study.html")
        .render(title=title, about=about, numbers=numbers, parts=parts, texts=_texts, source=_source)
    )


def _texts(table: Table) -> Texts:
    return Texts([table.header], table.cells)


def _source(figure: Figure) -> str:
    return f"data:image/svg+xml;base64,{base64.b64encode(drawn(figure, 'svg')).decode()}"
