"""Which tolerance makes how much of a figure's variance: Sobol indices of two sets of samples and their mixtures.

A figure is nearly linear in small departures. So the linear part, fitted to both sets, is counted by its known variance
and the samples have to tell the rest alone, as a control variate: shares are right to 0.02 with some hundred samples.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.explore.draw import WAVE, Batch
from cycloid_mj.explore.zone import Zone

MOST_SAMPLES, FEWEST_SAMPLES = 512, 32
"""Of each of the two sets; powers of two, as Sobol's sequence is even for these."""

RESAMPLES = 200
"""Of the samples, for the confidence of the shares."""

LEAST_SAMPLES = 16
"""With a number: fewer, where the others jam, have no shares."""

FIT_SHARE = 0.25
"""Most numbers that a sample is made of, as a share of the samples, for its linear part to be fitted."""


@dataclass(frozen=True)
class Share:
    """What one tolerance does to the variance of a figure.

    Attributes
    ----------
    source
        Its key in the design file's table; ``profile_2`` is the wave of the profile of order 2.
    first_order, total
        Share of the variance that it has alone, and with all it acts together with (Sobol).
    ci95
        Lowest and highest of `total`, 95 % confidence.
    """

    source: str
    first_order: float
    total: float
    ci95: tuple[float, float]


def budget_samples(samples: int, most: int = MOST_SAMPLES) -> int:
    """Return how many samples each set of the budget has in a study of so many: the next power of two, at `most`."""
    return min(most, max(FEWEST_SAMPLES, 1 << (samples - 1).bit_length()))


def budget_blocks(zones: Mapping[str, Zone], samples: int) -> dict[str, Batch]:
    """Collect the sets that are compared by name: two, and the first with one tolerance at a time of the second."""
    swapped = {key: Batch(0, samples, compared=True, second=(key,)) for key in zones}
    both = {name: Batch(0, samples, compared=True, second=keys) for name, keys in (("A", ()), ("B", tuple(zones)))}
    return both | swapped


def shares(
    zones: Mapping[str, Zone],
    departures: Sequence[Mapping[str, Array]],
    values: Mapping[str, Array],
    generator: np.random.Generator,
) -> tuple[Share, ...]:
    """Share out the variance of a figure; the largest share comes first.

    First order by Saltelli et al. 2010 (Comput. Phys. Commun. 181, 259-270, table 2 b), total by Jansen 1999, each with
    the linear part of the figure as a control variate. Samples that have no number, as where they jam, are left out.

    Parameters
    ----------
    zones
        Of all tolerances that are drawn.
    departures
        Of the sets A and B, by tolerance, shape (samples, ...).
    values
        Of the figure in the sets of `budget_blocks`, shape (samples,) each.
    generator
        Draws the resamples.
    """
    names = list(zones)
    if len(names) == 1:
        return (Share(names[0], 1.0, 1.0, (1.0, 1.0)),)
    table = np.array([values["A"], values["B"], *(values[name] for name in names)])
    rows = np.flatnonzero(np.isfinite(table[:2]).all(axis=0))
    if min(np.isfinite(table[2:, rows]).sum(axis=1)) < LEAST_SAMPLES:
        return tuple(Share(name, np.nan, np.nan, (np.nan, np.nan)) for name in names)
    f = _Sets(table[0, rows], table[1, rows], table[2:, rows])
    if np.ptp(np.concatenate([f.first, f.second])) == 0.0:
        return tuple(Share(name, 0.0, 0.0, (0.0, 0.0)) for name in names)
    linear = _linear_part([_scaled(zones, departure, rows) for departure in departures], f)
    first_order, total = _indices(f, linear, np.arange(rows.size))
    resampled = [generator.integers(0, rows.size, rows.size) for _ in range(RESAMPLES)]
    low, high = np.percentile([_indices(f, linear, each)[1] for each in resampled], [2.5, 97.5], axis=0).tolist()
    ranked = sorted(range(len(names)), key=lambda i: -total[i])
    return tuple(Share(names[i], first_order[i], total[i], (low[i], high[i])) for i in ranked)


class _Sets(NamedTuple):
    """Values in the sets A and B, shape (n,), and in A with each tolerance of B, shape (tolerances, n)."""

    first: Array
    second: Array
    mixed: Array


class _Linear(NamedTuple):
    """The linear part of a figure: its mean, its values about that, and the variance by each tolerance."""

    mean: float
    values: _Sets
    variances: Array


def _scaled(zones: Mapping[str, Zone], departures: Mapping[str, Array], rows: Integers) -> list[Array]:
    """Compute departures by tolerance as numbers of mean 0 and variance 1, shape (rows, numbers) each."""
    scaled = []
    for key, zone in zones.items():
        values = departures[key][rows].reshape(rows.size, -1)
        if key.startswith(WAVE):  # a wave begins anywhere: its cosine and sine have half of its mean square each
            scaled.append(values / math.sqrt(0.5 * (zone.middle**2 + zone.deviation**2)))
        else:
            scaled.append((values - zone.middle) / (zone.deviation or 1.0))
    return scaled


def _linear_part(departures: Sequence[list[Array]], f: _Sets) -> _Linear:
    """Fit a figure in both sets by departures that have the mean 0 and the variance 1; not by those that are idle."""
    moved = np.any(f.mixed != f.first, axis=1)
    in_a, in_b = ([values * moves for values, moves in zip(departure, moved, strict=True)] for departure in departures)
    both = np.concatenate([np.concatenate(in_a, axis=1), np.concatenate(in_b, axis=1)])
    columns = np.concatenate([np.ones((len(both), 1)), both], axis=1)
    slopes = np.zeros(columns.shape[1])
    target = np.concatenate([f.first, f.second])
    if columns.shape[1] <= FIT_SHARE * len(columns):
        slopes = np.linalg.lstsq(columns, target, rcond=None)[0]
    else:
        slopes[0] = target.mean()
    by_source = np.split(slopes[1:], np.cumsum([values.shape[1] for values in in_a])[:-1])
    a, b = (np.array([x @ slope for x, slope in zip(one, by_source, strict=True)]) for one in (in_a, in_b))
    values = _Sets(a.sum(axis=0), b.sum(axis=0), a.sum(axis=0) - a + b)
    return _Linear(float(slopes[0]), values, np.array([slope @ slope for slope in by_source]))


def _indices(f: _Sets, linear: _Linear, rows: Integers) -> tuple[list[float], list[float]]:
    """Return first-order and total indices from some of the samples."""

    def means(sets: _Sets, mean: float) -> tuple[float, Array, Array]:
        """Compute what the variance, and its shares of first order and in total, are estimated by."""
        first, second, mixed = sets.first[rows] - mean, sets.second[rows] - mean, sets.mixed[:, rows] - mean
        variance = 0.5 * float(np.mean(first**2 + second**2))
        return variance, np.nanmean(second * (mixed - first), axis=1), 0.5 * np.nanmean((first - mixed) ** 2, axis=1)

    same = linear.values._replace(mixed=np.where(np.isnan(f.mixed), np.nan, linear.values.mixed))
    whole, part = means(f, linear.mean), means(same, 0.0)
    variance = float(linear.variances.sum()) + whole[0] - part[0]
    first_order, total = ((linear.variances + whole[i] - part[i]) / variance for i in (1, 2))
    return first_order.tolist(), total.tolist()
