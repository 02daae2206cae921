"""Stress of each kind of part: the largest by finite elements, and the contact and fatigue stress of the rating."""

import math
from collections.abc import Callable
from typing import Any

from cycloid_mj.app.state import design_of
from cycloid_mj.app.summary import rating_at_load
from cycloid_mj.app.verdicts import rated_item
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.judgement import judge
from cycloid_mj.base.units import MEGAPASCAL
from cycloid_mj.figures import figure
from cycloid_mj.reducer import Reducer

PARTS = {"gear": "gear", "output": "output", "shaft": "shaft", "pin": "pin", "ring": "housing"}
"""Kind of part in the keys of the catalogue -> the part that names its material."""


def stress(on_progress: Callable[[Any], None], values: Any) -> dict[str, Any]:
    """Compute the largest stress of each part over one crank turn under the load, and judge it by the yield strength.

    A part whose bulk does not yield can still fail at its surface or by fatigue: those items of the rating at the
    same load come first. `on_progress` is called with the rows so far after each part.

    Raises
    ------
    CycloidError
        The extra ``fem`` is not installed, or the run failed.
    """
    design = design_of(values)
    reducer = Reducer(design)
    rating = rating_at_load(reducer)
    rated = [rated_item(item, rating.life) for item in rating.items.values() if item.unit == "MPa"]
    rows = list[dict[str, Any]]()
    for number, (kind, part) in enumerate(PARTS.items()):
        progress = number / len(PARTS)
        on_progress({"doing": f"stress of the {kind}", "share": progress, "rated": rated, "rows": list(rows)})
        entry = figure(f"{kind}_stress_mpa")
        largest = entry.value(reducer)
        if not math.isnan(largest):
            rows.append(
                _row(entry.name, largest, design.material_of(part).yield_strength / MEGAPASCAL, entry.definition)
            )
    if not rows:
        raise CycloidError("no part of this design has a stress that can be computed")
    return {"rated": rated, "rows": rows}


def _row(name: str, stress_mpa: float, yield_mpa: float, definition: str) -> dict[str, Any]:
    """Return a bulk stress as a row with a bar, judged by the yield strength."""
    return {
        "name": name,
        "text": f"{stress_mpa:.3g} of {yield_mpa:.3g} MPa",
        "judgement": judge(yield_mpa / stress_mpa if stress_mpa > 0.0 else math.inf),
        "share": min(1.0, stress_mpa / yield_mpa),
        "title": definition,
    }
