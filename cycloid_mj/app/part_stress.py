"""Stress of each kind of part: the largest by finite elements, and the contact and fatigue stress of the rating."""

import math
from collections.abc import Callable
from typing import Any

from cycloid_mj.app.state import at_load, parse_design
from cycloid_mj.app.verdicts import rated_item
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.judgement import judge
from cycloid_mj.base.units import MEGAPASCAL
from cycloid_mj.figures import figure
from cycloid_mj.life.item import Rating
from cycloid_mj.life.items import rate_for_verdict
from cycloid_mj.reducer import Reducer

PARTS = {
    "output": ("output pins", "output", ("output", "peak")),
    "gear": ("disc", "gear", ("gear", "tooth", "bore", "hole")),
    "shaft": ("crank", "shaft", ("shaft", "crank", "cam", "key")),
    "pin": ("ring pins", "pin", ("pin",)),
    "ring": ("ring", "housing", ("housing", "ring")),
}
"""Kind of part in the keys of the catalogue -> its name, the part that names its material, and words of the rated items
that belong to it; the first kind with a word of an item has it."""

COLOURS = ("#313695", "#4575b4", "#74add1", "#fdae61", "#f46d43", "#a50026")
"""Colours from no stress to the limit and above: the ends of the map RdYlBu of ColorBrewer, in reverse."""


def stress(on_progress: Callable[[Any], None], values: Any) -> dict[str, Any]:
    """Compute the largest stress of each kind of part over a crank turn by finite elements, and compare it with yield.

    A part that does not yield away from its contacts can still fail at its surface or by fatigue. The result therefore
    also has the contact and fatigue stresses of the rating at the same load. `values` is the design as the page sends
    it, see `parse_design`. `on_progress` is called before each part with the results of the ``parts`` so far.

    Returns
    -------
    dict
        ``parts``: for each kind its ``name`` and the rows of its ``rated`` contact and fatigue stresses and of its
        ``bulk`` stress [MPa]; a kind without any row is left out.

    Raises
    ------
    CycloidError
        The extra ``fem`` is not installed, or the run failed.
    """
    design = parse_design(values)
    reducer = Reducer(design)
    parts = _collect_rated_stress(rate_for_verdict(at_load(reducer)))
    for number, (kind, (name, part, _)) in enumerate(PARTS.items()):
        on_progress({"doing": f"stress of the {name}", "share": number / len(PARTS), "parts": list(parts.values())})
        entry = figure(f"{kind}_stress_mpa")
        largest = entry.value(reducer)
        if not math.isnan(largest):
            limit = design.material_of(part).yield_strength / MEGAPASCAL
            parts[kind]["bulk"].append(_bulk_row(entry.name, largest, limit, entry.definition))
    if not any(part["bulk"] for part in parts.values()):
        raise CycloidError(
            "the finite-element analysis found no stress away from the contacts in any part of this design: check the "
            "design with `cycloid-mj design check`, or choose a preset such as pin"
        )
    return {"parts": [part for part in parts.values() if part["rated"] or part["bulk"]]}


def _collect_rated_stress(rating: Rating) -> dict[str, dict[str, Any]]:
    """Return the contact and fatigue stresses of a rating as rows for the page: kind of part -> dict of its rows.

    A kind has its ``name``, the rows ``rated`` with value, limit and bar of each stress, and an empty list ``bulk``.
    """
    parts: dict[str, dict[str, Any]] = {
        kind: {"name": name, "rated": [], "bulk": []} for kind, (name, *_) in PARTS.items()
    }
    for item in rating.items.values():
        if item.unit == "MPa":
            words = set(item.key.split("_"))
            kind = next((kind for kind, (*_, part_words) in PARTS.items() if words & set(part_words)), "ring")
            parts[kind]["rated"].append(_add_bar(rated_item(item, rating.life), item.margin(rating.life)))
    return parts


def _add_bar(row: dict[str, Any], margin: float) -> dict[str, Any]:
    """Add length ``share`` (0 to 1) and ``colour`` of a bar to a row, by the load over its limit, 1 / `margin`."""
    share = 1.0 / margin if margin > 0.0 else math.inf
    colour_index = min(len(COLOURS) - 1, int(share * (len(COLOURS) - 1)))
    return row | {"share": min(1.0, share), "colour": COLOURS[colour_index]}


def _bulk_row(name: str, stress_mpa: float, yield_mpa: float, definition: str) -> dict[str, Any]:
    """Return a bulk stress as a row with a bar, judged by the yield strength."""
    margin = yield_mpa / stress_mpa if stress_mpa > 0.0 else math.inf
    row = {"name": name, "text": f"{stress_mpa:.3g} of {yield_mpa:.3g} MPa", "judgement": judge(margin)}
    return _add_bar(row | {"title": definition}, margin)
