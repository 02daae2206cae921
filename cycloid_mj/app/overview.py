"""Figures of a design that the page cannot draw or change, as of an RV reducer, and the commands that support it."""

from collections.abc import Mapping
from typing import Any

from cycloid_mj.app.summary import format_quantity, rated_items, sentence_in_words
from cycloid_mj.base.judgement import gravest
from cycloid_mj.design import Design
from cycloid_mj.design.layouts import SUPPORTED, Layout
from cycloid_mj.figures import figure
from cycloid_mj.life import rate
from cycloid_mj.life.checks import check_design
from cycloid_mj.reducer import reducer_of
from cycloid_mj.statics.sheet import sheet

KINDS: Mapping[Layout, str] = {"rv": "RV reducer"}
"""Layout -> its name in words."""


def overview(design: Design) -> dict[str, Any]:
    """Return what the page shows of a design that it cannot draw or change, such as an RV reducer, as JSON values.

    Returns
    -------
    dict
        ``title``: name, kind and ratio; ``words``: a sentence on what the page cannot do with the design; ``commands``:
        the commands that support its layout; ``checks``: their summary, and the reasons of failures and warnings;
        ``condition``: load and speed of the figures; ``rows``: name, value and note of each figure that statics
        computes; ``rating``: duty, required life and rated items.

    Raises
    ------
    CycloidError
        The design has no static equilibrium, or cannot be rated.
    """
    results = check_design(design)
    static, rating = sheet(reducer_of(design)), rate(design)
    kind = KINDS[design.layout]
    return {
        "title": f"{design.name}: {kind}, {design.reduction:g}:1",
        "words": f"This page shows the figures of an {kind}. It cannot draw, change, simulate or export it.",
        "commands": [f"cycloid-mj {command}" for command in SUPPORTED[design.layout]],
        "checks": {
            "judgement": gravest(check.judgement for check in results),
            "words": f"{len(results)} checks: {results.counts}",
            "failed": [sentence_in_words(check.why) for check in (*results.failures, *results.warnings)],
        },
        "condition": static.condition,
        "rows": [
            {
                "name": figure(key).name.replace("pin_gear", "teeth"),
                "value": format_quantity(quantity).removesuffix(" 1"),
                "note": quantity.note or figure(key).definition,
            }
            for key, quantity in static.quantities.items()
        ],
        "rating": {"condition": rating.duty, "required_h": rating.life, "items": rated_items(rating)},
    }
