"""The largest stress of each kind of part by finite elements, part after part."""

import math
from collections.abc import Callable
from typing import Any

from cycloid_mj.app.state import design_of
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.units import MEGAPASCAL
from cycloid_mj.figures import figure
from cycloid_mj.reducer import Reducer

KINDS = {"gear": "gear", "output": "output", "shaft": "shaft", "pin": "pin", "ring": "housing"}
"""Kind of part -> the part whose material it has."""


def stress(told: Callable[[Any], None], values: Any) -> dict[str, Any]:
    """Compute the largest stresses in a turn under the load, quickly, and tell each as it comes.

    Raises
    ------
    CycloidError
        The extra fem is not there, or the run went wrong.
    """
    design = design_of(values)
    reducer, rows = Reducer(design), list[dict[str, Any]]()
    for number, (kind, part) in enumerate(KINDS.items()):
        told({"doing": f"stress of the {kind}", "share": number / len(KINDS), "rows": list(rows)})
        row = figure(f"{kind}_stress_mpa")
        largest = row.value(reducer)
        if math.isnan(largest):
            continue
        allowed = design.material_of(part).yield_strength / MEGAPASCAL
        rows.append({"name": row.name, "mpa": largest, "yield_mpa": allowed, "note": row.definition})
    if not rows:
        raise CycloidError("no part of this design has a stress that can be computed")
    return {"rows": rows}
