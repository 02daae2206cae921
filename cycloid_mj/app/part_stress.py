"""Stress of each kind of part: the largest away from contacts, and the contact and fatigue stress of the rating."""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, cast

from cycloid_mj.app.state import at_load, parse_design
from cycloid_mj.app.verdicts import rated_item
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.judgement import judge
from cycloid_mj.base.names import CRANK, PLANET, SUN
from cycloid_mj.base.units import MEGAPASCAL
from cycloid_mj.design.layouts import Layout
from cycloid_mj.figures import figure
from cycloid_mj.life.item import Rating
from cycloid_mj.life.items import rate_for_verdict
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.stress.figures import for_one_turn
from cycloid_mj.stress.rv_strength import compute_rv_strength
from cycloid_mj.stress.study import QUICK


class StressedPart(NamedTuple):
    """A kind of part: its name, the part that names its material, and words of the rated items that belong to it."""

    name: str
    material: str
    words: tuple[str, ...]


PARTS: Mapping[Layout, Mapping[str, StressedPart]] = {
    "central": {
        "output": StressedPart("output pins", "output", ("output", "peak")),
        "gear": StressedPart("disc", "gear", ("gear", "tooth", "bore", "hole")),
        "shaft": StressedPart("crank", "shaft", ("shaft", "crank", "cam", "key")),
        "pin": StressedPart("ring pins", "pin", ("pin",)),
        "ring": StressedPart("ring", "housing", ("housing", "ring")),
    },
    "rv": {
        SUN: StressedPart("sun", "shaft", (SUN,)),
        "gear": StressedPart("disc", "gear", ("gear", "tooth")),
        CRANK: StressedPart("cranks", "shaft", (CRANK,)),
        PLANET: StressedPart("planets", "shaft", (PLANET,)),
        "pin": StressedPart("ring pins", "pin", ("pin",)),
        "ring": StressedPart("ring", "housing", ("housing", "ring")),
    },
}
"""Layout -> kind of part, as in the keys of the catalogue -> the part. The first kind with a word of a rated item has
this item; items without any such word belong to the ring."""

CLOSED_FORMS = {
    CRANK: "Largest stress at the ends of the eccentrics over a turn of the cranks: beam theory with notch factors",
    SUN: "Stress at the root of a tooth that carries the largest force of a mesh alone: ISO 6336-3",
    PLANET: "Stress at the root of a tooth that carries the largest force of a mesh alone: ISO 6336-3",
}
"""Parts of an RV reducer whose stress has a closed form, and this form."""

COLOURS = ("#313695", "#4575b4", "#74add1", "#fdae61", "#f46d43", "#a50026")
"""Colours from no stress to the limit and above: the ends of the map RdYlBu of ColorBrewer, in reverse."""


def stress(on_progress: Callable[[Any], None], values: Any) -> dict[str, Any]:
    """Compute the largest stress of each kind of part over a crank turn, and compare it with yield.

    It is the stress by finite elements; cranks and gears of an RV reducer have closed forms. A part that does not yield
    away from its contacts can still fail at its surface or by fatigue. The result therefore also has the contact and
    fatigue stresses of the rating at the same load. `values` is the design as the page sends it, see `parse_design`.
    `on_progress` is called before each part with the results of the ``parts`` so far.

    Returns
    -------
    dict
        ``parts``: for each kind its ``name``, and lists of rows of its ``rated`` contact and fatigue stresses and of
        its ``bulk`` stress. A row has ``name``, ``text``, ``judgement``, ``title``, and ``share`` and ``colour`` of a
        bar. A kind without any row is left out.

    Raises
    ------
    CycloidError
        The extra ``fem`` is not installed, or the run failed.
    """
    reducer = reducer_of(parse_design(values))
    parts = _collect_rated_stress(reducer.LAYOUT, rate_for_verdict(at_load(reducer)))
    kinds = PARTS[reducer.LAYOUT]
    for number, (kind, part) in enumerate(kinds.items()):
        on_progress(
            {"doing": f"stress of the {part.name}", "share": number / len(kinds), "parts": list(parts.values())}
        )
        name, largest_stress, definition = _largest_stress(reducer, kind, part.name)
        if not math.isnan(largest_stress):
            limit = reducer.design.material_of(part.material).yield_strength / MEGAPASCAL
            parts[kind]["bulk"].append(_bulk_row(name, largest_stress, limit, definition))
    if not any(part["bulk"] for part in parts.values()):
        raise CycloidError(
            "the finite-element analysis found no stress away from the contacts in any part of this design: check the "
            "design with `cycloid-mj design check`, or choose a preset such as pin"
        )
    return {"parts": [part for part in parts.values() if part["rated"] or part["bulk"]]}


def _largest_stress(reducer: Reducer, kind: str, part_name: str) -> tuple[str, float, str]:
    """Return name, value [MPa] and definition of the largest stress of a kind of part; NaN if it has none."""
    if kind in CLOSED_FORMS:
        strength = compute_rv_strength(cast(RvReducer, reducer_of(for_one_turn(reducer.design))), QUICK.turn)
        return f"largest stress of the {part_name}", strength.largest[kind] / MEGAPASCAL, CLOSED_FORMS[kind]
    entry = figure(f"{kind}_stress_mpa")
    return entry.name, entry.value(reducer), entry.definition


def _collect_rated_stress(layout: Layout, rating: Rating) -> dict[str, dict[str, Any]]:
    """Return the contact and fatigue stresses of a rating as table rows for the page, by kind of part of a layout.

    A kind has its ``name``, ``rated`` with a row for each stress (`rated_item`, and length and colour of its bar), and
    an empty list ``bulk``.
    """
    kinds = PARTS[layout]
    parts: dict[str, dict[str, Any]] = {
        kind: {"name": part.name, "rated": [], "bulk": []} for kind, part in kinds.items()
    }
    for item in rating.items.values():
        if item.unit == "MPa":
            words = set(item.key.split("_"))
            kind = next((kind for kind, part in kinds.items() if words & set(part.words)), "ring")
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
