"""The Monte Carlo study of the tolerances tab: samples in blocks, with intermediate results."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from cycloid_mj.app.state import at_load, design_of
from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import UsageError
from cycloid_mj.design import Design
from cycloid_mj.explore.jam import find_jams, jams_too_often
from cycloid_mj.explore.sampling import list_batches, tolerance_zones
from cycloid_mj.explore.tolerances import balance_batch, tolerance
from cycloid_mj.figures import SAMPLED, figure
from cycloid_mj.figures.sampled import ANGLES, condition
from cycloid_mj.reducer import Reducer

SAMPLES, BUDGET_SAMPLES = 4096, 200
"""Samples of the distributions, and of the error budget."""

SEED = 0
BINS = 24
MAX_HALF_WIDTH_UM = 500.0

TOLERANCE_KEYS = ("mesh", "cam", "output", "pin_position", "eccentricity")
"""Tolerances that are set to the half width of the page."""

UNITS = ("arcmin", "arcsec")
"""Units of the figures that are shown."""


def samples(on_progress: Callable[[Any], None], values: Any, spread_um: Any) -> dict[str, Any]:
    """Solve samples of a design within its tolerances, and share out the variance.

    Parameters
    ----------
    on_progress
        Called after each block with the distributions so far.
    values
        The design, by its values of the page.
    spread_um
        Half width of each tolerance [um]; None for the tolerances of the design.

    Raises
    ------
    UsageError
        The design has no tolerances, or the half width is out of range.
    """
    reducer = at_load(Reducer(spread_design(design_of(values), spread_um)))
    zones = tolerance_zones(reducer)
    if not zones:
        raise UsageError(
            "this design has no tolerances: enter one tolerance for all sizes (more than 0, at most "
            f"{MAX_HALF_WIDTH_UM:g} um), or set the table [tolerance] of the design file"
        )
    columns: dict[str, Array] = {}
    for batch in list_batches(SAMPLES):
        block = balance_batch(reducer, zones, SEED, ANGLES, (batch, tuple(SAMPLED)))
        jams_early = not columns and jams_too_often(find_jams(block))
        columns = {key: np.concatenate([columns[key], added]) if columns else added for key, added in block.items()}
        seen = _distributions(reducer, columns)
        count = seen["samples"]
        on_progress({"doing": f"{count} of {SAMPLES} samples", "share": count / SAMPLES, "seen": seen})
        if jams_early:
            return seen
    on_progress({"doing": "computing the error budget", "share": 1.0, "seen": seen})
    study = tolerance(reducer.design, BUDGET_SAMPLES, SEED)
    shares = [{"source": share.source, "share": share.total} for share in study.budget]
    return {**seen, "budget": shares, "budget_of": figure(study.budget_of).name, "no_budget": study.no_budget}


def spread_design(design: Design, spread_um: Any) -> Design:
    """Return a design whose tolerances have a half width [um]; unchanged for None.

    Raises
    ------
    UsageError
        The half width is not a number, or is out of range.
    """
    if spread_um is None:
        return design
    if type(spread_um) not in (int, float) or not 0.0 < spread_um <= MAX_HALF_WIDTH_UM or not math.isfinite(spread_um):
        raise UsageError(
            f"the tolerance is {spread_um!r} um, which is out of range: choose more than 0 and at most "
            f"{MAX_HALF_WIDTH_UM:g} um"
        )
    zone = f"uniform {spread_um:g}"
    return design.but(tolerance=dict.fromkeys(TOLERANCE_KEYS, zone))


def _distributions(reducer: Reducer, columns: Mapping[str, Array]) -> dict[str, Any]:
    """Return the distributions of the samples solved so far: histograms, percentiles, share of jams."""
    jams, charts = find_jams(columns), list[dict[str, Any]]()
    for key, values in columns.items():
        row, solved = figure(key), values[~jams & np.isfinite(values)]
        if row.unit not in UNITS or len(solved) < 2:
            continue
        counts, edges = np.histogram(solved, BINS)
        low, middle, high = np.percentile(solved, [5.0, 50.0, 95.0]).tolist()
        shape = {"counts": counts.tolist(), "edges": edges.tolist(), "p05": low, "p50": middle, "p95": high}
        charts.append({"name": row.name, "unit": row.unit, **shape})
    return {"samples": len(jams), "jam": float(jams.mean()), "charts": charts, "condition": condition(reducer)}
