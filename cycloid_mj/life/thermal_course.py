"""Temperatures of a drive over time under the points of a duty cycle, from a cold start to a periodic state."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.life.thermal_network import Network


@dataclass(frozen=True)
class HeatingPoint:
    """Heat of a point of a duty cycle, linear in the temperature rise of one node.

    Attributes
    ----------
    duration
        Time at this point in each cycle [s].
    heat
        Heat put into each node at the reference rise [W].
    slope
        Change of this heat per kelvin of the controlling node [W/K]: viscosity and clearances change with temperature.
    """

    duration: float
    heat: Mapping[str, float]
    slope: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class TemperatureCourse:
    """Temperature rises over the air during the warm-up.

    Attributes
    ----------
    times
        Times [s], shape (m,).
    rises
        Rise of each node [K], shape (m,).
    periodic
        Rise of each node over a cycle of the periodic state that follows [K], shape (n,).
    """

    times: Array
    rises: Mapping[str, Array]
    periodic: Mapping[str, Array]

    def peak(self, node: str) -> float:
        """Return the largest rise of a node in the periodic state [K]."""
        return float(np.max(self.periodic[node]))


def solve_course(
    network: Network,
    points: Sequence[HeatingPoint],
    controlling: str,
    reference_rise: float,
    end: float,
    samples: int,
) -> TemperatureCourse:
    """Compute the temperature rises [K] over time [s] of the nodes of a thermal network in a warm-up.

    The start is at the temperature of the air. The solution is exact at the returned times (matrix exponential of each
    point of the duty). The result also has the rises over a cycle of the periodic state that follows the warm-up, in
    which each cycle ends at the temperatures at which it began.

    Parameters
    ----------
    network
        Conductances and heat capacities.
    points
        Points of the duty cycle in their order.
    controlling, reference_rise
        Node on whose temperature the heat depends, and its temperature rise [K] for which `HeatingPoint.heat` is
        stated.
    end
        Shortest duration of the warm-up [s], which is rounded up to complete cycles.
    samples
        Approximate number of returned times; each point of each cycle has at least one.
    """
    from scipy.linalg import expm

    cycle_duration = sum(point.duration for point in points)
    cycles = max(1, math.ceil(end / cycle_duration * (1.0 - 1e-9)))
    samples_per_cycle = max(1, round(samples / cycles))
    nodes = list(network.capacities)
    capacity = np.array([network.capacities[node] for node in nodes])
    steps: list[tuple[Array, float]] = []
    for point in points:
        step_count = max(1, round(samples_per_cycle * point.duration / cycle_duration))
        heat, slope = (
            np.array([values_by_node.get(node, 0.0) for node in nodes]) for values_by_node in (point.heat, point.slope)
        )
        rate_matrix = np.zeros((len(nodes) + 1, len(nodes) + 1))
        rate_matrix[:-1, :-1] = -network.matrix
        rate_matrix[:-1, nodes.index(controlling)] += slope
        rate_matrix[:-1, -1] = heat - slope * reference_rise
        rate_matrix[:-1] /= capacity[:, np.newaxis]
        duration = point.duration / step_count
        steps += [(expm(duration * rate_matrix), duration)] * step_count
    step_matrices = [matrix for matrix, _ in steps]
    cycle_matrix = np.linalg.multi_dot([*step_matrices[::-1], np.eye(len(nodes) + 1)])
    periodic_start = np.linalg.solve(np.eye(len(nodes)) - cycle_matrix[:-1, :-1], cycle_matrix[:-1, -1])
    times = np.cumsum([0.0, *[duration for _, duration in steps] * cycles])
    rises, periodic_rises = (
        dict(zip(nodes, _follow(start_rises, matrices), strict=True))
        for start_rises, matrices in ((np.zeros(len(nodes)), step_matrices * cycles), (periodic_start, step_matrices))
    )
    return TemperatureCourse(times, rises, periodic_rises)


def _follow(start_rises: Array, step_matrices: Sequence[Array]) -> Array:
    """Return the rises [K] of n nodes at the start, `start_rises` (n,), and after each of k steps, (n, k + 1)."""
    states = [np.append(start_rises, 1.0)]
    for matrix in step_matrices:
        states.append(matrix @ states[-1])
    return np.array(states)[:, :-1].T
