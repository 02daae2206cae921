"""Summary of a sweep: the range of each quantity, and its rank correlation with each input."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.result import Table
from cycloid_mj.explore.sweeps import Sweep
from cycloid_mj.figures import figure

HEADLINES = (
    "backlash_arcmin",
    "stiffness_nm_per_arcmin",
    "te_loaded_forward_arcsec",
    "output_peak_to_peak_loaded_forward_speed_arcsec",
    "efficiency_percent",
    "capacity_nm",
    "cam_peak_force_n",
    "transmission_error_peak_to_peak_arcsec",
    "efficiency",
    "contact_summary_peak_force_n",
    "mass_kg",
    "failed_errors",
)
"""Quantities that are shown first, in this order; the others follow in the order of the measure."""

MAX_SHOWN = 6
"""Quantities that are shown without a request."""

CONSTANT_RTOL = 1e-6
"""Relative range of a column up to which it counts as constant: rounding errors are below."""


@dataclass(frozen=True)
class Ranks:
    """Spearman's rank correlations."""

    inputs: tuple[str, ...]
    quantities: tuple[str, ...]
    """Names of columns."""
    rho: Array
    """Correlation of each quantity with each input, shape (quantities, inputs); NaN where one of them never changes."""


def number_inputs(sweep: Sweep) -> tuple[str, ...]:
    """List the inputs that are numbers."""
    numbers = sweep.frame.numbers
    return tuple(key for key in sweep.task.keys if key in numbers)


def select_quantities(sweep: Sweep, requested: tuple[str, ...] = ()) -> tuple[str, ...]:
    """Return the names of the columns of a sweep to show: the requested names, or at most `MAX_SHOWN`.

    Without a request, the columns that vary are returned, or constant columns if none varies. Those in `HEADLINES` come
    first.

    Raises
    ------
    UsageError
        There is no such quantity, or it is not a number.
    """
    number_columns = sweep.frame.numbers
    available_names = [name for name in sweep.quantities if name in number_columns]
    requested = tuple(name if name in available_names else _catalogue_key(name) for name in requested)
    if unknown_names := [name for name in requested if name not in available_names]:
        raise UsageError(
            f"--show {unknown_names[0]}: unknown quantity. Choose from "
            f"{', '.join(available_names) or 'none (the sweep has no numeric results)'}"
        )
    if requested:
        return requested
    finite_columns = {name: values for name in available_names if (values := _finite(number_columns[name])).size}
    varying_names = [
        name for name, values in finite_columns.items() if np.ptp(values) > CONSTANT_RTOL * np.abs(values).max()
    ]
    headline_order = {name: position for position, name in enumerate(HEADLINES)}
    sorted_names = sorted(
        varying_names or available_names,
        key=lambda name: headline_order.get(name.rpartition(".")[2], len(headline_order)),
    )
    return tuple(sorted_names[:MAX_SHOWN])


def _catalogue_key(name: str) -> str:
    """Return the name of a sweep's column, with the main key of its quantity in place of an alias or old key.

    `name` is ``key`` or ``measure.key``. Other names are returned unchanged.
    """
    measure, dot, key = name.rpartition(".")
    try:
        return f"{measure}{dot}{figure(key).key}"
    except UsageError:
        return name


def rank_correlations(sweep: Sweep, quantities: tuple[str, ...]) -> Ranks:
    """Compute Spearman's correlations of quantities with the inputs that are numbers, over the points with both."""
    numbers, inputs = sweep.frame.numbers, number_inputs(sweep)
    rho = np.array([[_spearman(numbers[key], numbers[name]) for key in inputs] for name in quantities])
    return Ranks(inputs, quantities, rho.reshape(len(quantities), len(inputs)))


def tabulate_quantities(sweep: Sweep, quantities: tuple[str, ...]) -> tuple[Table, ...]:
    """Tabulate minimum, median and maximum of quantities; if several inputs vary, also their rank correlations.

    `sweep` has the values of all points. Values that are not finite are left out. The column "points" has the number of
    finite values.
    """
    number_columns = sweep.frame.numbers
    rows = []
    for name in quantities:
        values = _finite(number_columns[name])
        low, median, high = np.percentile(values, [0.0, 50.0, 100.0]).tolist() if values.size else [np.nan] * 3
        rows.append((name, low, median, high, str(values.size)))
    tables = [Table("quantities", ("quantity", "minimum", "median", "maximum", "points"), tuple(rows))]
    if len(number_inputs(sweep)) > 1 and quantities:
        correlations = rank_correlations(sweep, quantities)
        correlation_texts = (
            ["-" if np.isnan(rho) else f"{rho:+.2f}" for rho in row] for row in correlations.rho.tolist()
        )
        correlation_rows = tuple((name, *row) for name, row in zip(quantities, correlation_texts, strict=True))
        tables.append(Table("rank correlations (Spearman)", ("quantity", *correlations.inputs), correlation_rows))
    return tuple(tables)


def _finite(values: Array) -> Array:
    return values[np.isfinite(values)]


def _spearman(values_a: Array, values_b: Array) -> float:
    """Compute Spearman's rank correlation [1] of two columns, shape (points,) each, over the points with both values.

    NaN for fewer than 3 points, and where a column is constant.
    """
    from scipy.stats import spearmanr

    has_both = np.isfinite(values_a) & np.isfinite(values_b)
    x, y = values_a[has_both], values_b[has_both]
    if len(x) < 3 or np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
        return float("nan")
    return float(spearmanr(x, y).statistic)
