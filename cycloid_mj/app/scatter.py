"""Many drives made within tolerances, drawn and balanced block by block, with results on the way."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from cycloid_mj.app.state import at_load, design_of
from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import UsageError
from cycloid_mj.design import Design
from cycloid_mj.explore.draw import blocks, tolerances
from cycloid_mj.explore.jam import jams_of, jams_too_often
from cycloid_mj.explore.tolerances import balanced, tolerance
from cycloid_mj.figures import SAMPLED, figure
from cycloid_mj.figures.sampled import ANGLES, condition
from cycloid_mj.reducer import Reducer

DRIVES, BUDGETED = 4096, 200
"""Drives in all, and those of the study that shares their spread out."""

SEED = 0
BINS = 24
MOST_SPREAD = 500.0

SPREAD = ("mesh", "cam", "output", "pin_position", "eccentricity")
"""Tolerances that one half width stands for, where the design has none of its own."""

UNITS = ("arcmin", "arcsec")
"""Of the figures that are shown."""


def samples(told: Callable[[Any], None], values: Any, spread_um: Any) -> dict[str, Any]:
    """Draw drives within the design's tolerances, or within a half width for each size [um], block after block.

    Raises
    ------
    UsageError
        There are no tolerances, or the half width is none.
    """
    reducer = at_load(Reducer(spread_design(design_of(values), spread_um)))
    zones = tolerances(reducer)
    if not zones:
        raise UsageError("the design has no tolerances: give a half width for each size")
    columns: dict[str, Array] = {}
    for batch in blocks(DRIVES):
        block = balanced(reducer, zones, SEED, ANGLES, (batch, tuple(SAMPLED)))
        columns = {key: np.concatenate([columns[key], one]) if columns else one for key, one in block.items()}
        count = len(jams_of(columns))
        told({"doing": f"{count} of {DRIVES} drives", "share": count / DRIVES, "seen": _seen(reducer, columns)})
        if batch.first == 0 and batch.number == 0 and jams_too_often(jams_of(columns)):
            break
    else:
        told({"doing": "what to tighten first", "share": 1.0, "seen": _seen(reducer, columns)})
        study = tolerance(reducer.design, BUDGETED, SEED)
        shares = [{"source": one.source, "share": one.total} for one in study.budget]
        return {**_seen(reducer, columns), "budget": shares, "budget_of": figure(study.budget_of).name}
    return _seen(reducer, columns)


def spread_design(design: Design, spread_um: Any) -> Design:
    """Return a design with a half width [um] as its tolerances; with its own where that is nothing.

    Raises
    ------
    UsageError
        The half width is none.
    """
    if spread_um is None:
        return design
    if type(spread_um) not in (int, float) or not 0.0 < spread_um <= MOST_SPREAD or not math.isfinite(spread_um):
        raise UsageError(f"a spread of {spread_um!r} um: give more than 0, up to {MOST_SPREAD:g}")
    zone = f"uniform {spread_um:g}"
    return design.but(tolerance=dict.fromkeys(SPREAD, zone))


def _seen(reducer: Reducer, columns: Mapping[str, Array]) -> dict[str, Any]:
    """Sum up the drives that are balanced so far."""
    jams, charts = jams_of(columns), list[dict[str, Any]]()
    for key, values in columns.items():
        row, fits = figure(key), values[~jams & np.isfinite(values)]
        if row.unit not in UNITS or len(fits) < 2:
            continue
        counts, edges = np.histogram(fits, BINS)
        low, middle, high = np.percentile(fits, [5.0, 50.0, 95.0]).tolist()
        shape = {"counts": counts.tolist(), "edges": edges.tolist(), "p05": low, "p50": middle, "p95": high}
        charts.append({"name": row.name, "unit": row.unit, **shape})
    return {"samples": len(jams), "jam": float(jams.mean()), "charts": charts, "condition": condition(reducer)}
