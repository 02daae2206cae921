"""The page of a rating: fills the template ``assets/rating.html``."""

from cycloid_mj.base.judgement import Judgement
from cycloid_mj.life import Rating
from cycloid_mj.report.page import environment
from cycloid_mj.report.tables import TextTable

STYLES = {
    Judgement.PASSED: "holds",
    Judgement.WARNING: "near",
    Judgement.FAILED: "fails",
    Judgement.NOT_APPLICABLE: "figure",
}
"""Style of a row, by the judgement of its item."""


def rating_page(rating: Rating) -> str:
    """Return a rating as one HTML page with its parts and kinds of failure, the weakest first, and its assumptions."""
    states = [STYLES[rated_item.judgement(rating.life)] for rated_item in rating.items.values()]
    table = rating.table()
    return (
        environment()
        .get_template("rating.html")
        .render(
            title=f"cycloid_mj: rating of {rating.design}",
            rating=rating,
            header=table.header,
            rows=list(zip(states, table.cells, strict=True)),
            failing=len(rating.failing),
            texts=TextTable.of,
        )
    )
