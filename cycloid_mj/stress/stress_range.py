"""Stress range at a node over a turn, which decides fatigue.

The distance of two states of stress is the von Mises stress of their difference. A node's stress range lies between the
two states that are farthest from each other: half of their distance is its amplitude, and the von Mises stress of the
state midway, with the sign of its trace, its mean. Both are the same in every frame. Instants at which a node lies near
a narrow patch do not count: what happens there is Hertz's (``closed``), and pitting.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.units import MEGAPASCAL, MILLIMETRE
from cycloid_mj.stress.field import LoadedPart
from cycloid_mj.stress.recover import von_mises

RANGE_PARTS = ("gear", "ring")
"""Parts with webs and ligaments, whose fatigue depends on the stress range of their nodes; others have fillets."""


@dataclass(frozen=True)
class StressRange:
    """Stress over a turn at the worst node of a part: `amplitude` and `mean` [Pa] there, and its `position` [m]."""

    amplitude: float
    mean: float
    position: Array

    def as_json(self) -> dict[str, Any]:
        """Convert the range to JSON values: ``amplitude_mpa``, ``mean_mpa`` and the position ``place_mm``."""
        return {
            "amplitude_mpa": self.amplitude / MEGAPASCAL,
            "mean_mpa": self.mean / MEGAPASCAL,
            "place_mm": [float(value) / MILLIMETRE for value in self.position],
        }


def sample_angles(angles: int) -> Integers:
    """Choose the indices of the crank angles that are evaluated, of all in a turn."""
    return np.arange(0, angles, max(1, min(6, angles // 24)))


def critical_stress_range(part: LoadedPart, states: Mapping[int, Array], distance: float) -> StressRange:
    """Return stress amplitude [Pa], mean stress [Pa] and position [m] of the node of `part` critical for fatigue.

    `states` maps the indices of the angles of `sample_angles` to the stress components of n nodes (components, n) [Pa].
    A state does not count at nodes within `distance` [m] of a narrow patch at that angle. At the critical node, 2
    amplitude + mean is largest: Goodman's criterion with an endurance limit of half the tensile strength. A negative
    mean counts as 0.
    """
    all_nodes = np.arange(len(part.grid.points))
    bulk_states = [
        np.where(part.distances.from_patches(angle, all_nodes) < distance, np.nan, state)
        for angle, state in states.items()
    ]
    amplitude, mean, candidates = worst_nodes(np.stack(bulk_states))
    critical_index = int(np.argmax(2.0 * amplitude + np.maximum(mean, 0.0)))
    return StressRange(
        float(amplitude[critical_index]), float(mean[critical_index]), part.grid.points[candidates[critical_index]]
    )


def worst_nodes(states: Array) -> tuple[Array, Array, Integers]:
    """Compute stress amplitude and mean stress of the nodes with the largest stress ranges, at most 1500.

    The stress range is the largest von Mises stress of the difference between two instants. The amplitude is half of
    this range. The mean is the von Mises stress of the mean of both instants, with the sign of its trace. A node with a
    single state has the amplitude 0; a node without any state is left out.

    Parameters
    ----------
    states
        Stress components of n nodes at each of c instants (c, components, n) [Pa], NaN where a state does not count.

    Returns
    -------
    tuple
        Amplitude [Pa], mean [Pa] and index of each of m nodes, shape (m,) each.
    """
    nodes_with_state = np.flatnonzero(np.isfinite(states[:, 0]).any(axis=0))
    range_bound = rank_by_range(states[:, :, nodes_with_state])
    candidates = nodes_with_state[np.argsort(range_bound)[-1500:]]  # the others cannot be critical
    histories = states[:, :, candidates].astype(np.float64)
    indices, largest_range = np.arange(len(candidates)), np.zeros(len(candidates))
    first_instant, second_instant = np.zeros(len(candidates), int), np.zeros(len(candidates), int)
    for instant in range(len(histories)):
        ranges = np.nan_to_num(von_mises(np.moveaxis(histories - histories[instant], 1, 0)), nan=-1.0)
        other_instant = ranges.argmax(axis=0)
        instant_range = ranges[other_instant, indices]
        is_larger = instant_range > largest_range
        largest_range = np.where(is_larger, instant_range, largest_range)
        first_instant = np.where(is_larger, instant, first_instant)
        second_instant = np.where(is_larger, other_instant, second_instant)
    mean_stress = 0.5 * (histories[first_instant, :, indices] + histories[second_instant, :, indices]).T
    # a node with a single state, or whose stress is constant, has its mean state
    mean_state = np.nan_to_num(histories[0]) if len(histories) == 1 else np.nanmean(histories, axis=0)
    mean_stress = np.where(largest_range > 0.0, mean_stress, mean_state)
    trace = mean_stress[: 2 if len(mean_stress) == 3 else 3].sum(axis=0)
    return 0.5 * largest_range, np.copysign(von_mises(mean_stress), trace), candidates


def rank_by_range(states: Array) -> Array:
    """Compute an upper bound of stress range plus mean of each of n nodes [Pa], (n,), to preselect critical nodes.

    It is sqrt(3) times the norm of the ranges of the stress components, plus half the norm of their largest magnitudes.
    `states` (c, components, n) [Pa] are the components at c instants, NaN where a state does not count.
    """
    max_components, min_components = (
        np.fmax.reduce(states, axis=0),
        np.fmin.reduce(states, axis=0),
    )  # no numbers are passed over
    largest_magnitude = np.maximum(np.abs(max_components), np.abs(min_components))
    return np.asarray(
        np.sqrt(3.0) * np.linalg.norm(max_components - min_components, axis=0)
        + 0.5 * np.linalg.norm(largest_magnitude, axis=0)
    )
