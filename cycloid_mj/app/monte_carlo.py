"""The Monte Carlo study of the tolerances tab: samples in blocks, with intermediate results."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_mj.app.state import at_load, parse_design
from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.errors import UsageError
from cycloid_mj.design import Design
from cycloid_mj.design.layouts import Layout
from cycloid_mj.explore.jam import find_jams, stops_study
from cycloid_mj.explore.rv_samples import ERRORS
from cycloid_mj.explore.sampling import list_batches, tolerance_zones
from cycloid_mj.explore.tolerance_zones import has_tolerances
from cycloid_mj.explore.tolerances import Tolerances, solve_sample_batch, tolerance
from cycloid_mj.figures import SAMPLED, figure
from cycloid_mj.figures.sampled import ANGLES, condition
from cycloid_mj.reducer import Reducer, reducer_of


@dataclass(frozen=True)
class MonteCarloSettings:
    """Size of the study of the tolerances tab."""

    samples: int = 4096
    budget_samples: int = 200
    """Samples of the distributions, and of the error budget."""
    seed: int = 0
    bins: int = 24
    """Random seed, and bars of a histogram."""
    max_half_width_um: float = 500.0
    """Largest half width of a tolerance [um]."""


STUDY = MonteCarloSettings()


TOLERANCES: Mapping[Layout, tuple[str, tuple[str, ...]]] = {
    "central": ("tolerance", ("mesh", "cam", "output", "pin_position", "eccentricity")),
    "rv": ("crank_tolerance", tuple(key for key in ERRORS if key != "pin_position")),
}
"""Layout -> table of the design file and its keys, which are set to the half width of the page.

Ring pins of RV reducers are left out: statics of so many samples takes a minute.
"""

UNITS = ("arcmin", "arcsec")
"""Units of the figures that are shown."""


def study_tolerances(on_progress: Callable[[Any], None], values: Any, spread_um: Any) -> dict[str, Any]:
    """Compute distributions and error budget of a design from random samples within its tolerances, as JSON values.

    Parameters
    ----------
    on_progress
        Called after each block of samples with a dict: ``doing`` in words, ``share`` (completed fraction), and ``seen``
        (the distributions so far).
    values
        The design as the page sends it: keys of the design file -> values, see `parse_design`.
    spread_um
        Half width of each tolerance [um]; None for the tolerances of the design.

    Returns
    -------
    dict
        The distributions (`_sample_distributions`) and three keys of the error budget. ``budget``: the share of each
        source in the variance of a quantity; ``budget_of``: the name of this quantity; ``no_budget``: the reason if
        there are no shares, else empty. If too many samples of the first block jam, the study stops without these three
        keys.

    Raises
    ------
    UsageError
        The design has no tolerances, or the half width is out of range.
    """
    reducer = at_load(reducer_of(set_tolerances(parse_design(values), spread_um)))
    if not has_tolerances(reducer):
        table, _ = TOLERANCES[reducer.LAYOUT]
        raise UsageError(
            "this design has no tolerances: enter one tolerance for all dimensions (greater than 0, at most "
            f"{STUDY.max_half_width_um:g} um), or set the table [{table}] of the design file"
        )
    return STUDIES[reducer.LAYOUT](reducer, on_progress)


def _study_central(reducer: Reducer, on_progress: Callable[[Any], None]) -> dict[str, Any]:
    """Return the result of `study_tolerances` for a drive with a central crank.

    Each sample drive is solved for static equilibrium. `on_progress` is called with the distributions so far.
    """
    zones = tolerance_zones(reducer)
    columns: dict[str, Array] = {}
    for batch in list_batches(STUDY.samples):
        block = solve_sample_batch(reducer, zones, STUDY.seed, ANGLES, (batch, tuple(SAMPLED)))
        jams_early = not columns and stops_study(find_jams(block))
        columns = {
            key: np.concatenate([columns[key], block_values]) if columns else block_values
            for key, block_values in block.items()
        }
        distributions = _sample_distributions(columns, find_jams(columns), condition(reducer))
        count = distributions["samples"]
        on_progress(
            {"doing": f"{count} of {STUDY.samples} samples", "share": count / STUDY.samples, "seen": distributions}
        )
        if jams_early:
            return distributions
    on_progress({"doing": "computing the error budget", "share": 1.0, "seen": distributions})
    return {**distributions, **_budget_json(tolerance(reducer.design, STUDY.budget_samples, STUDY.seed))}


def _study_rv(reducer: Reducer, on_progress: Callable[[Any], None]) -> dict[str, Any]:
    """Return the result of `study_tolerances` for an RV reducer, from the closed form of its transmission error."""
    on_progress({"doing": f"{STUDY.samples} samples", "share": 0.0})
    study = tolerance(reducer.design, STUDY.samples, STUDY.seed)
    return {**_sample_distributions(study.figures, study.jams, study.condition), **_budget_json(study)}


STUDIES: Mapping[Layout, Callable[[Reducer, Callable[[Any], None]], dict[str, Any]]] = {
    "central": _study_central,
    "rv": _study_rv,
}
"""Layout -> function that computes the study of the tolerances tab."""


def _budget_json(study: Tolerances) -> dict[str, Any]:
    """Convert the error budget of a study to JSON values: ``budget``, ``budget_of`` and ``no_budget``."""
    shares = [{"source": share.source, "share": share.total} for share in study.budget]
    return {"budget": shares, "budget_of": figure(study.budget_of).name, "no_budget": study.no_budget}


def set_tolerances(design: Design, spread_um: Any) -> Design:
    """Return a design in which all tolerances are uniform with the half width `spread_um` [um]; unchanged for None.

    Raises
    ------
    UsageError
        The half width is not a number, or is out of range.
    """
    if spread_um is None:
        return design
    if (
        type(spread_um) not in (int, float)
        or not 0.0 < spread_um <= STUDY.max_half_width_um
        or not math.isfinite(spread_um)
    ):
        raise UsageError(
            f"the tolerance is {spread_um!r} um, which is out of range: choose a value greater than 0 and at most "
            f"{STUDY.max_half_width_um:g} um"
        )
    zone, (table, keys) = f"uniform {spread_um:g}", TOLERANCES[design.layout]
    return design.but(**{table: dict.fromkeys(keys, zone)})


def _sample_distributions(columns: Mapping[str, Array], jams: Mask, condition_text: str) -> dict[str, Any]:
    """Compute the distributions of the samples solved so far, as JSON values.

    ``samples`` is the number of samples, ``jam`` the share that jams, and ``charts`` a list with ``name``, ``unit``,
    histogram (``counts``, ``edges``) and percentiles (``p05``, ``p50``, ``p95``) of each quantity. `columns` are the
    computed quantities by key, and `jams` is which samples jam, shape (samples,) each. `condition_text` states the load
    and the model with which they were computed; it becomes ``condition``. Jammed samples are left out of the
    histograms, and so are quantities with fewer than two solved samples or in a unit not in `UNITS`.
    """
    charts = list[dict[str, Any]]()
    for key, values in columns.items():
        catalogue_figure, solved_values = figure(key), values[~jams & np.isfinite(values)]
        if catalogue_figure.unit not in UNITS or len(solved_values) < 2:
            continue
        counts, edges = np.histogram(solved_values, STUDY.bins)
        low, median, high = np.percentile(solved_values, [5.0, 50.0, 95.0]).tolist()
        histogram = {"counts": counts.tolist(), "edges": edges.tolist(), "p05": low, "p50": median, "p95": high}
        charts.append({"name": catalogue_figure.name, "unit": catalogue_figure.unit, **histogram})
    return {"samples": len(jams), "jam": float(jams.mean()), "charts": charts, "condition": condition_text}
