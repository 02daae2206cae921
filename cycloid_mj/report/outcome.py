"""The page of an outcome: what the template ``assets/outcome.html`` is filled with."""

import base64

from cycloid_mj.base.outcome import Outcome, Picture
from cycloid_mj.base.result import Table
from cycloid_mj.report.page import environment
from cycloid_mj.report.tables import TextTable


def outcome_page(outcome: Outcome) -> str:
    """Render an outcome as one page that needs no other file."""
    return environment().get_template("outcome.html").render(outcome=outcome, texts=_texts, source=_source)


def _texts(table: Table) -> TextTable:
    return TextTable([table.header], table.cells)


def _source(picture: Picture) -> str:
    return f"data:image/svg+xml;base64,{base64.b64encode(picture('svg')).decode()}"
