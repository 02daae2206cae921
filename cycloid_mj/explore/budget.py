"""Error budget: the share of each tolerance in the variance of a figure, by Sobol indices with a control variate.

`scipy.stats.sobol_indices` (1.17.1) and SALib (1.6) have no control variate and accept no samples that jam. For six
normal tolerances and a nearly linear figure, the rms errors of the total indices are 0.003 here against 0.030 of
SciPy's at 64 samples, 0.0029 against 0.0079 at 128, and 0.0022 against 0.0025 at 512 (November 2026).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.base.statistics import student_half_width
from cycloid_mj.design.zone import Zone
from cycloid_mj.explore.sampling import WAVE, Batch


@dataclass(frozen=True)
class SobolSettings:
    """Settings of the Sobol indices: pick-freeze estimators with a cross-fitted linear control variate."""

    min_samples: int = 64
    """Samples of each set below which there is no budget. From 64 on the 95 % intervals of a nearly linear figure
    contain the exact share in 90 % or more of the studies (`tests/explore/test_budget.py`)."""
    min_drawn: int = 80
    """Samples of each set that are drawn at least, so that some may jam."""
    max_samples: int = 512
    """Samples of each set at most: a share is then known to 0.03."""
    folds: int = 4
    """Parts of the samples; the linear part that is subtracted from one part is fitted to the others."""
    max_columns: float = 0.25
    """Columns of a linear fit at most, as a share of its rows."""


SOBOL = SobolSettings()


@dataclass(frozen=True)
class Share:
    """Share of one tolerance in the variance of a figure."""

    source: str
    """Its key in the design file's table; ``profile_2`` is the wave of the profile of order 2."""
    first_order: float
    total: float
    """Sobol indices: the share of the variance that it causes alone, and together with all others."""
    ci95: tuple[float, float]
    """Bounds of the 95 % confidence interval of `total`."""


def size_of_budget_sets(samples: int) -> int:
    """Return the size of each set of the budget in a study of so many samples; 0 where it is too small for a budget."""
    return min(max(samples, SOBOL.min_drawn), SOBOL.max_samples) if samples >= SOBOL.min_samples else 0


def list_budget_sets(zones: Mapping[str, Zone], samples: int) -> dict[str, Batch]:
    """Return the sets of random samples for Sobol indices, by name: "A", "B", and one per tolerance.

    A `Batch` only states which random numbers belong to a set; nothing is drawn here.
    A sample is a random drive within the tolerances. The sets A and B are independent. The mixed set of a tolerance has
    the values of this tolerance from B and those of all others from A (pick-freeze); its name is the key of the
    tolerance. `zones` are the tolerances by key, and `samples` is the size of each set.
    """
    mixed_sets = {key: Batch(0, samples, compared=True, second=(key,)) for key in zones}
    independent_sets = {
        name: Batch(0, samples, compared=True, second=keys) for name, keys in (("A", ()), ("B", tuple(zones)))
    }
    return independent_sets | mixed_sets


def find_usable_rows(values: Mapping[str, Array]) -> Integers:
    """Return the numbers of the samples that have a value in every set: those that jam in none."""
    return np.flatnonzero(np.isfinite(np.array(list(values.values()))).all(axis=0))


def compute_shares(
    zones: Mapping[str, Zone], deviations: Sequence[Mapping[str, Array]], values: Mapping[str, Array]
) -> tuple[Share, ...]:
    """Compute the Sobol indices of all tolerances: their shares in the variance of a quantity, largest total first.

    First-order indices are estimated as by Saltelli et al. 2010 (Comput. Phys. Commun. 181, 259-270, table 2 b), total
    indices as by Jansen 1999. A linear model of the quantity, whose variance is known, serves as control variate, so
    that only the nonlinear remainder is sampled. The model is cross-fitted: each fold of the samples is corrected by
    the model fitted to the other folds, which keeps the estimators unbiased. Tolerances with the fewest random numbers
    enter the model first (the position errors of 40 pins are 80 numbers), as long as the fit has enough rows. The
    intervals of the total indices follow from the jackknife of the logarithm of the ratio and Student's t. If the
    quantity is equal in all samples, all shares are 0.

    Parameters
    ----------
    zones
        All tolerances of the design, by key.
    deviations
        Deviations from the nominal design in the sample sets A and B, by tolerance, shape (samples, ...).
    values
        Values of the quantity in the sets of `list_budget_sets`, shape (samples,) each; NaN where a sample jams.

    Returns
    -------
    A share for each tolerance, projected on 0 <= first order <= total <= 1, which the exact indices satisfy. An empty
    tuple if fewer than `SobolSettings.min_samples` samples have a value in every set.
    """
    names, usable_rows = list(zones), find_usable_rows(values)
    if usable_rows.size < SOBOL.min_samples:
        return ()
    figure_sets = _FigureSets(
        values["A"][usable_rows], values["B"][usable_rows], np.array([values[name][usable_rows] for name in names])
    )
    if np.ptp(np.concatenate([figure_sets.set_a, figure_sets.set_b])) == 0.0:
        return tuple(Share(name, 0.0, 0.0, (0.0, 0.0)) for name in names)
    terms = _estimator_terms(
        figure_sets, [_standardise_deviations(zones, deviation, usable_rows) for deviation in deviations]
    )
    first_order_shares = terms.first_order.mean(axis=1) / terms.variance.mean()
    total_shares, lower_bounds, upper_bounds = _jackknife_ratios(terms.total, terms.variance)
    shares = [
        Share(
            name,
            _clip_share(first_order_shares[index], _clip_share(total_shares[index])),
            _clip_share(total_shares[index]),
            (_clip_share(lower_bounds[index]), _clip_share(upper_bounds[index])),
        )
        for index, name in enumerate(names)
    ]
    return tuple(sorted(shares, key=lambda share: -share.total))


def _clip_share(value: float, upper: float = 1.0) -> float:
    """Clip a share to the range from 0 to `upper`."""
    return float(min(max(value, 0.0), upper))


class _FigureSets(NamedTuple):
    """Values in the sets A and B, shape (n,), and in A with each tolerance from B, shape (tolerances, n)."""

    set_a: Array
    set_b: Array
    mixed: Array


class _Terms(NamedTuple):
    """Terms by sample whose means are the variance, shape (n,), and the partial variances, shape (tolerances, n)."""

    variance: Array
    first_order: Array
    total: Array


def _standardise_deviations(zones: Mapping[str, Zone], deviations: Mapping[str, Array], rows: Integers) -> list[Array]:
    """Scale the deviations of parts to mean 0 and variance 1; return an array (rows, k) per tolerance.

    k is the number of random numbers of the tolerance in a sample, such as 80 for the positions of 40 pins. `zones` are
    the tolerances by key, `deviations` are in metres, by tolerance, shape (samples, ...); `rows` are the indices of the
    samples to use.
    """
    standardised_deviations = []
    for key, zone in zones.items():
        values = deviations[key][rows].reshape(rows.size, -1)
        if key.startswith(WAVE):  # the phase is uniform: cosine and sine have half of the mean square each
            standardised_deviations.append(values / math.sqrt(0.5 * (zone.middle**2 + zone.standard_deviation**2)))
        else:
            standardised_deviations.append((values - zone.middle) / (zone.standard_deviation or 1.0))
    return standardised_deviations


def _estimator_terms(values: _FigureSets, deviations: Sequence[list[Array]]) -> _Terms:
    """Compute terms for each of n samples whose means are the variance of a quantity, and its parts by tolerance.

    The parts are the first-order and the total variance of each tolerance. A linear model serves as control variate
    (`_fit_control_variate`). `values` are the values of the quantity in all sample sets. `deviations` are those in the
    sets A and B, from `_standardise_deviations`: an array (n, k) for each tolerance, with its k random numbers.
    """
    constants, model, variances = _fit_control_variate(values, deviations)
    values_a, values_b, values_mixed = values.set_a - constants, values.set_b - constants, values.mixed - constants
    variance = 0.5 * (values_a**2 + values_b**2) - 0.5 * (model.set_a**2 + model.set_b**2) + variances.sum(axis=0)
    first_order = values_b * (values_mixed - values_a) - model.set_b * (model.mixed - model.set_a) + variances
    total_order = 0.5 * (values_a - values_mixed) ** 2 - 0.5 * (model.set_a - model.mixed) ** 2 + variances
    return _Terms(variance, first_order, total_order)


def _fit_control_variate(values: _FigureSets, deviations: Sequence[list[Array]]) -> tuple[Array, _FigureSets, Array]:
    """Fit a linear model of a quantity to the deviations by cross-validation, as a control variate of its variance.

    In each fold of the samples the model has the coefficients fitted to the other folds. `values` are the values of the
    quantity in all sample sets. `deviations` are those in the sets A and B, from `_standardise_deviations`: an array
    (n, k) for each tolerance, with its k random numbers in n samples.

    Returns
    -------
    tuple
        For each sample the constant of the model, shape (n,), the model's values in all sets without the constant, and
        the variance that the model attributes to each tolerance, shape (tolerances, n).
    """
    deviations_a, deviations_b = deviations
    tolerance_count, sample_count = values.mixed.shape
    fold_of_sample = np.arange(sample_count) % SOBOL.folds
    fit_a, fit_b, variances = np.zeros((3, tolerance_count, sample_count))
    constants = np.zeros(sample_count)
    model_tolerances = _choose_model_tolerances(values, deviations_a)
    column_ends = np.cumsum([deviations_a[index].shape[1] for index in model_tolerances], dtype=int)
    for fold_index in range(SOBOL.folds):
        training, validation = fold_of_sample != fold_index, fold_of_sample == fold_index
        columns = np.concatenate(
            [_columns(deviations_a, model_tolerances, training), _columns(deviations_b, model_tolerances, training)]
        )
        target = np.concatenate([values.set_a[training], values.set_b[training]])
        # normal equations: the columns are independent draws, four rows and more for each
        constant, *slopes = np.split(np.linalg.solve(columns.T @ columns, columns.T @ target), [1, *(1 + column_ends)])
        constants[validation] = constant[0]
        for index, slope in zip(model_tolerances, slopes[: len(model_tolerances)], strict=True):
            fit_a[index, validation], fit_b[index, validation] = (
                deviations_a[index][validation] @ slope,
                deviations_b[index][validation] @ slope,
            )
            variances[index, validation] = slope @ slope
    return constants, _FigureSets(fit_a.sum(axis=0), fit_b.sum(axis=0), fit_a.sum(axis=0) - fit_a + fit_b), variances


def _choose_model_tolerances(values: _FigureSets, deviations: list[Array]) -> list[int]:
    """Choose the tolerances in the linear model of a quantity; return their indices in ascending order.

    Only tolerances that change the value of at least one sample are included, those with the fewest random numbers
    first. The number of columns of the fit is limited to the number of its rows times `SobolSettings.max_columns`.
    `values` are the values of the quantity in all sample sets; `deviations` are those in set A, from
    `_standardise_deviations`: an array (n, k) for each tolerance, with its k random numbers in n samples.
    """
    fit_rows = 2.0 * values.set_a.size * (1.0 - 1.0 / SOBOL.folds)
    free_columns = SOBOL.max_columns * fit_rows - 1.0
    selected_tolerances = []
    for index in sorted(range(len(deviations)), key=lambda index: deviations[index].shape[1]):
        if np.any(values.mixed[index] != values.set_a) and deviations[index].shape[1] <= free_columns:
            selected_tolerances.append(index)
            free_columns -= deviations[index].shape[1]
    return sorted(selected_tolerances)


def _columns(deviations: list[Array], chosen: Sequence[int], rows: Mask) -> Array:
    """Stack the columns of a linear model: a constant, and the deviations of the tolerances with the indices `chosen`.

    `deviations` has an array (n, k) for each tolerance, with its k random numbers in n samples; `rows` (n,) selects
    samples.
    """
    return np.concatenate([np.ones((int(rows.sum()), 1)), *(deviations[i][rows] for i in chosen)], axis=1)


def _jackknife_ratios(partial_variance: Array, variance: Array) -> tuple[Array, Array, Array]:
    """Compute k ratios of mean `partial_variance` to mean `variance` over n samples, and their 95 % bounds.

    `partial_variance` has the shape (k, n), `variance` (n,). The standard error is that of the logarithm of the ratio,
    by the jackknife (leave one sample out), since errors of variance ratios are proportional to the ratio.

    Returns
    -------
    tuple of Array
        Ratio, lower and upper bound, shape (k,) each.
    """
    sample_count = variance.size
    ratio = partial_variance.mean(axis=1) / variance.mean()
    leave_one_out = (partial_variance.sum(axis=1, keepdims=True) - partial_variance) / (variance.sum() - variance)
    deviations = leave_one_out - leave_one_out.mean(axis=1, keepdims=True)
    standard_error = np.sqrt((sample_count - 1.0) / sample_count * np.sum(deviations**2, axis=1))
    relative_error = standard_error / np.maximum(np.abs(ratio), np.finfo(float).tiny)
    factor = np.exp(np.minimum(student_half_width(sample_count - 1, 0.95) * relative_error, math.log(1e6)))
    clipped_ratio = np.maximum(ratio, 0.0)
    return ratio, clipped_ratio / factor, np.maximum(clipped_ratio * factor, ratio + standard_error)
