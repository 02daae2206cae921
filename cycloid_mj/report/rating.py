"""The page of a rating: what the template ``assets/rating.html`` is filled with."""

from cycloid_mj.life import RatedItem, Rating
from cycloid_mj.report.page import environment
from cycloid_mj.report.tables import TextTable

NEAR = 1.5
"""Margin below which an item that holds is shown as near its limit."""


def rating_page(rating: Rating) -> str:
    """Write a rating as one page that needs no other file."""

    def state(item: RatedItem) -> str:
        margin = item.margin(rating.life)
        return "figure" if item.verdict == "" else "fails" if margin < 1.0 else "near" if margin < NEAR else "holds"

    table, give = rating.table(), rating.cam_give.table() if rating.cam_give else None
    failing = sum(state(item) == "fails" for item in rating.items.values())
    return (
        environment()
        .get_template("rating.html")
        .render(
            title=f"cycloid_mj: rating of {rating.design}",
            rating=rating,
            header=table.header,
            rows=list(zip(map(state, rating.items.values()), table.cells, strict=True)),
            failing=failing,
            give=None if give is None else TextTable([give.header], give.cells),
            give_title=give.title if give else "",
        )
    )
