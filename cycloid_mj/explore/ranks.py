"""What a sweep says at a glance: the range of each quantity, and how its rank goes with that of each input."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.result import Table
from cycloid_mj.explore.sweeps import Sweep
from cycloid_mj.figures import figure

FEWEST = 3
"""Points of which a rank correlation says anything."""

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
"""What one looks for first, in this order; other quantities come after, as the measure has them."""

MOST_SHOWN = 6

LEAST_CHANGE = 1e-6
"""Relative; what changes by less is not worth a panel."""


@dataclass(frozen=True)
class Ranks:
    """Spearman's rank correlations.

    Attributes
    ----------
    inputs, quantities
        Names of the columns.
    rho
        Correlation of each quantity with each input, shape (quantities, inputs); NaN where one of them never changes.
    """

    inputs: tuple[str, ...]
    quantities: tuple[str, ...]
    rho: Array


def number_inputs(sweep: Sweep) -> tuple[str, ...]:
    """List the inputs that are numbers."""
    numbers = sweep.frame.numbers
    return tuple(key for key in sweep.task.keys if key in numbers)


def shown(sweep: Sweep, wanted: tuple[str, ...] = ()) -> tuple[str, ...]:
    """List the quantities to show: those wanted, else some that change, the headlines first.

    Raises
    ------
    UsageError
        There is no such quantity, or it is no number.
    """
    numbers = sweep.frame.numbers
    there = [name for name in sweep.quantities if name in numbers]
    wanted = tuple(name if name in there else _catalogue_key(name) for name in wanted)
    if unknown := [name for name in wanted if name not in there]:
        raise UsageError(f"--show {unknown[0]}: there is no such number; there are {', '.join(there) or 'none'}")
    if wanted:
        return wanted
    changing = [name for name in there if _changes(_finite(numbers[name]))] or there
    first = {name: place for place, name in enumerate(HEADLINES)}
    ranked = sorted(changing, key=lambda name: first.get(name.rpartition(".")[2], len(first)))
    return tuple(ranked[:MOST_SHOWN])


def _catalogue_key(name: str) -> str:
    """Return a column by the catalogue's key where it is an older name of a figure: ``stiffness_ideal_nm_arcmin``."""
    measure, dot, key = name.rpartition(".")
    try:
        return f"{measure}{dot}{figure(key).key}"
    except UsageError:
        return name


def ranks(sweep: Sweep, quantities: tuple[str, ...]) -> Ranks:
    """Correlate the ranks of quantities with those of the inputs that are numbers, over the points that have both."""
    numbers, inputs = sweep.frame.numbers, number_inputs(sweep)
    rho = np.array([[_rho(numbers[key], numbers[name]) for key in inputs] for name in quantities])
    return Ranks(inputs, quantities, rho.reshape(len(quantities), len(inputs)))


def tables(sweep: Sweep, quantities: tuple[str, ...]) -> tuple[Table, ...]:
    """Tabulate the ranges of quantities, and their rank correlations where there are several inputs."""
    numbers = sweep.frame.numbers
    rows = []
    for name in quantities:
        values = _finite(numbers[name])
        low, middle, high = np.percentile(values, [0.0, 50.0, 100.0]).tolist() if values.size else [np.nan] * 3
        rows.append((name, low, middle, high, str(values.size)))
    tables = [Table("quantities", ("quantity", "least", "median", "largest", "points"), tuple(rows))]
    if len(number_inputs(sweep)) > 1 and quantities:
        one = ranks(sweep, quantities)
        cells = (["-" if np.isnan(rho) else f"{rho:+.2f}" for rho in row] for row in one.rho.tolist())
        lines = tuple((name, *row) for name, row in zip(quantities, cells, strict=True))
        tables.append(Table("rank correlations (Spearman)", ("quantity", *one.inputs), lines))
    return tuple(tables)


def _finite(values: Array) -> Array:
    return values[np.isfinite(values)]


def _changes(values: Array) -> bool:
    return values.size > 0 and bool(np.ptp(values) > LEAST_CHANGE * np.abs(values).max())


def _ranked(values: Array) -> Array:
    """Compute the rank of each value [1]: of those that are equal, the mean of theirs."""
    _, place, count = np.unique(values, return_inverse=True, return_counts=True)
    return np.asarray((np.cumsum(count) - 0.5 * (count - 1))[place])


def _rho(one: Array, other: Array) -> float:
    both = np.isfinite(one) & np.isfinite(other)
    x, y = _ranked(one[both]), _ranked(other[both])
    if both.sum() < FEWEST or np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
        return float("nan")
    return float(np.corrcoef(x, y)[0, 1])
