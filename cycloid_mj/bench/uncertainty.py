"""Uncertainty of fitted values: their covariance from the slopes of the residuals, and their autocorrelation."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.statistics import student_half_width


@dataclass(frozen=True)
class IntervalSettings:
    """Settings of the intervals of fitted values."""

    confidence: float = 0.95
    """Coverage of an interval."""
    max_lag: float = 0.25
    """Largest lag of the autocorrelation that is summed, as a share of a loop's points."""
    max_leverage: float = 0.9
    """Upper limit of a point's leverage h in 1/(1-h): a point that decides a value alone does not show its own
    noise."""
    unknown_error: float = 1e6
    """Standard error of a scaled value on which no residual depends."""


INTERVAL = IntervalSettings()


def autocorrelation_time(residuals: Array) -> float:
    """Compute the autocorrelation time of n residuals, (n,): the number of points per independent point [1].

    It is 1 for white noise, and larger for systematic deviations of a model. It is 1 + 2 sum rho_k, up to the first lag
    k whose correlation rho_k is not significant (Geyer's initial sequence).
    """
    centred_residuals = residuals - residuals.mean()
    variance = float(np.mean(centred_residuals**2))
    time = 1.0
    for lag in range(1, int(INTERVAL.max_lag * len(residuals))):
        correlation = float(np.mean(centred_residuals[lag:] * centred_residuals[:-lag])) / variance if variance else 0.0
        if correlation <= 2.0 / np.sqrt(len(residuals)):
            break
        time += 2.0 * correlation
    return time


@dataclass(frozen=True, eq=False)
class FitUncertainty:
    """Uncertainty of v fitted values."""

    covariance: Array
    """Covariance of the values, shape (v, v)."""
    inverse: Array
    """Inverse of half the curvature of the sum of squares: the covariance for noise of size 1, shape (v, v)."""
    influence: Array
    """Change of the values per residual of a point, over the square root of 1 minus its leverage, shape (n, v)."""
    point_count: Array
    """Number of successive points that count as one independent point, at each point, shape (n,)."""

    @property
    def errors(self) -> Array:
        """Standard errors, shape (v,)."""
        return np.sqrt(np.diag(self.covariance))

    @cached_property
    def half_widths(self) -> Array:
        """Half widths of the confidence intervals of the values at `INTERVAL.confidence`, shape (v,)."""
        return self.quantiles(INTERVAL.confidence) * self.errors

    def quantiles(self, confidence: float) -> Array:
        """Return the half width of each value's confidence interval, over its standard error [1], shape (v,)."""
        return np.array([self.quantile_along(row, confidence) for row in np.eye(len(self.inverse))])

    def quantile_along(self, direction: Array, confidence: float) -> float:
        """Return the half width of the confidence interval of a sum of fitted values, over its standard error [1].

        The sum is weighted: `direction` (v,) has the coefficients of the v fitted values. The result is the
        quantile of Student's t distribution. It is larger if few points determine the sum, because its standard error
        is then estimated from few residuals. The degrees of freedom are Satterthwaite's, (sum a)^2 / sum a^2. a is the
        contribution of an independent point to the variance of the sum (Bell and McCaffrey, Survey Methodology 28,
        2002, 169-181; Imbens and Kolesar, Rev. Econ. Stat. 98, 2016, 701-712).
        """
        shares = (self.influence @ direction) ** 2
        squares = float(self.point_count @ shares**2)
        max_freedom = max(float(np.sum(1.0 / self.point_count)) - np.count_nonzero(np.diag(self.inverse)), 1.0)
        freedom = float(shares.sum()) ** 2 / squares if squares else max_freedom
        return student_half_width(min(max(freedom, 1.0), max_freedom), confidence)


def estimate_uncertainty(
    slopes: Sequence[Array], residuals: Sequence[Array], is_free: Mask, prior: Array | None = None
) -> FitUncertainty:
    """Return the covariance of v fitted values, and the influence of each point on them, for confidence intervals.

    The covariance is the sandwich estimate HC3, (A'A)^-1 A' diag(r^2/(1-h)^2) A (A'A)^-1 with slopes A, residuals r and
    leverages h (MacKinnon and White, J. Econometrics 29, 1985, 305-325), in which each point has its own noise. It is
    multiplied by the `autocorrelation_time` of each loop.

    Parameters
    ----------
    slopes, residuals
        Slopes (n, v) and residuals (n,) of the n points of each loop, weighted as in the sum of squares.
    is_free
        Which values are free, shape (v,); the others have no error. A free value on which no residual depends has the
        error `INTERVAL.unknown_error`.
    prior
        Slope of the residual of each value's prior, shape (v,). A prior reduces the error, but has no noise.
    """
    information = np.sum([loop_slopes.T @ loop_slopes for loop_slopes in slopes], axis=0)
    if prior is not None:
        information += np.diag(prior**2)
    inverse_information = np.zeros_like(information)
    free_block = np.ix_(is_free, is_free)
    eigenvalues, eigenvectors = np.linalg.eigh(information[free_block])
    min_eigenvalue = 1e-12 * max(float(eigenvalues.max(initial=0.0)), 1e-300)
    null_vectors = eigenvectors[:, eigenvalues <= min_eigenvalue]
    inverse_information[free_block] = (eigenvectors / np.maximum(eigenvalues, min_eigenvalue)) @ eigenvectors.T
    covariance, influence, correlation_times = np.zeros_like(information), [], []
    for loop_residuals, loop_slopes in zip(residuals, slopes, strict=True):
        leverage = np.minimum(np.sum(loop_slopes @ inverse_information * loop_slopes, axis=1), INTERVAL.max_leverage)
        gain, correlation_time = loop_slopes @ inverse_information, autocorrelation_time(loop_residuals)
        # a sum of squares, so that no small variance is rounded below 0
        scaled_residuals = gain * (loop_residuals / (1.0 - leverage))[:, np.newaxis]
        covariance += correlation_time * scaled_residuals.T @ scaled_residuals
        influence.append(gain / np.sqrt(1.0 - leverage)[:, np.newaxis])
        correlation_times.append(np.full(len(loop_residuals), correlation_time))
    covariance[free_block] += INTERVAL.unknown_error**2 * null_vectors @ null_vectors.T
    return FitUncertainty(covariance, inverse_information, np.concatenate(influence), np.concatenate(correlation_times))
