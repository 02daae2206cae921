"""Uncertainty of fitted values: their covariance from the slopes of the residuals and their correlation."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array, Mask

COVERED = 0.95
"""What an interval covers."""

LONGEST_MEMORY = 0.25
"""Largest lag over which residuals count as one, as a share of a loop's points."""

MOST_LEVERAGE = 0.9
"""A point that all but decides a value by itself tells no more of its own noise."""

UNKNOWN = 1e6
"""Error of what no residual answers to, on its scale."""


def memory(residuals: Array) -> float:
    """Compute how many residuals that follow each other count as one: 1 for noise, more for what a model leaves out.

    That is 1 + 2 sum rho_k, up to the first lag k whose correlation rho_k is not above 0 (Geyer's initial sequence).
    """
    centred = residuals - residuals.mean()
    variance = float(np.mean(centred**2))
    total = 1.0
    for lag in range(1, int(LONGEST_MEMORY * len(residuals))):
        correlation = float(np.mean(centred[lag:] * centred[:-lag])) / variance if variance else 0.0
        if correlation <= 2.0 / np.sqrt(len(residuals)):
            break
        total += 2.0 * correlation
    return total


@dataclass(frozen=True, eq=False)
class FitUncertainty:
    """How sure fitted values are.

    Attributes
    ----------
    covariance
        Of the values, shape (v, v).
    inverse
        Of half the curvature of the sum of squares, which alone would be the covariance for noise of size 1, (v, v).
    influence
        By how much each point moves the values, over the root of one less its leverage, shape (n, v).
    alike
        How many points count as one at each, shape (n,).
    """

    covariance: Array
    inverse: Array
    influence: Array
    alike: Array

    @property
    def errors(self) -> Array:
        """Standard errors, shape (v,)."""
        return np.sqrt(np.diag(self.covariance))

    def reach(self, covered: float) -> Array:
        """Compute how many standard errors an interval of each value reaches to either side to cover a share, (v,)."""
        return np.array([self.reach_along(row, covered) for row in np.eye(len(self.inverse))])

    def reach_along(self, direction: Array, covered: float) -> float:
        """Compute the interval of a sum of the values with factors (v,): Student's t.

        A few points may decide a value, such as those of a leap: of 181 some six. The error is then an estimate from as
        few residuals, and its degrees of freedom are Satterthwaite's, (sum a)^2 / sum a^2 with the share a that each
        point has in it (Bell and McCaffrey, Survey Methodology 28, 2002, 169-181; Imbens and Kolesar, Rev. Econ. Stat.
        98, 2016, 701-712).
        """
        from scipy.special import stdtrit

        shares = (self.influence @ direction) ** 2
        squares = float(self.alike @ shares**2)
        most = max(float(np.sum(1.0 / self.alike)) - np.count_nonzero(np.diag(self.inverse)), 1.0)
        freedom = float(shares.sum()) ** 2 / squares if squares else most
        return float(stdtrit(min(max(freedom, 1.0), most), 0.5 + 0.5 * covered))


def spread(
    slopes: Sequence[Array], residuals: Sequence[Array], free: Mask, known: Array | None = None
) -> FitUncertainty:
    """Compute the standard errors and intervals of fitted values.

    `slopes` (n, v) and `residuals` (n,) are those of each loop, weighted as in the sum of squares. Noise of a turn is
    none along a branch that is steep, so that each point brings its own: the sandwich estimate HC3 of MacKinnon and
    White (J. Econometrics 29, 1985, 305-325), (A'A)^-1 A' diag(r^2/(1-h)^2) A (A'A)^-1 with leverages h, in which a
    point counts as often as `memory` tells. What is `known` of each value without the loops (v,), as the slope of a
    residual of its own, has no noise: it only bounds. Values that are not `free` (v,) have none; what no residual
    answers to has an infinite error, here `UNKNOWN`.
    """
    information = np.sum([rows.T @ rows for rows in slopes], axis=0)
    if known is not None:
        information += np.diag(known**2)
    inverse = np.zeros_like(information)
    chosen = np.ix_(free, free)
    values, vectors = np.linalg.eigh(information[chosen])
    least = 1e-12 * max(float(values.max(initial=0.0)), 1e-300)
    unseen = vectors[:, values <= least]
    inverse[chosen] = (vectors / np.maximum(values, least)) @ vectors.T
    covariance, influence, memories = np.zeros_like(information), [], []
    for part, rows in zip(residuals, slopes, strict=True):
        leverage = np.minimum(np.sum(rows @ inverse * rows, axis=1), MOST_LEVERAGE)
        moved, alike = rows @ inverse, memory(part)
        # a sum of squares, so that no variance of what is hardly seen is rounded below 0
        scaled = moved * (part / (1.0 - leverage))[:, np.newaxis]
        covariance += alike * scaled.T @ scaled
        influence.append(moved / np.sqrt(1.0 - leverage)[:, np.newaxis])
        memories.append(np.full(len(part), alike))
    covariance[chosen] += UNKNOWN**2 * unseen @ unseen.T
    return FitUncertainty(covariance, inverse, np.concatenate(influence), np.concatenate(memories))
