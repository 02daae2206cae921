"""What refuses a design in a search: its failed checks, and by how much it fails them."""

import math

from cycloid_mj.checks import WALLS, check, soundness
from cycloid_mj.reducer import Reducer


def refusals(reducer: Reducer, strict: bool) -> dict[str, float]:
    """Compute the failed checks of a design by name, each with how far it is off, as a share of its bound.

    Those that make it impossible to build, and walls thinner than is assumed; `strict`: all warnings, too.
    """
    found = check(reducer.design) if strict else soundness(reducer)
    failed = [one for one in found if not one.passed and (strict or one.severity == "error" or one.name in WALLS)]
    return {one.name: _excess(one.value, one.bound) for one in failed}


def _excess(value: float | None, bound: float | None) -> float:
    """Compute by how much a value misses its bound, relative; 1 where that is no number."""
    if value is None or bound is None or not math.isfinite(value - bound):
        return 1.0
    return abs(value - bound) / max(abs(value), abs(bound), 1e-12)
