"""Peaks of forces against the crank angle, counted from gravity, so that starts at all phases share one axis."""

from collections.abc import Sequence

import numpy as np

from cycloid_mj.comparison import gravity_turn, settled
from cycloid_mj.design import Design
from cycloid_mj.record import Run
from cycloid_mj.types import Array
from hsieh2014.peaks import peak

BINS = 36
"""Parts of a crank turn: ten degrees each, a mesh period of the paper's ring."""


def by_angle(run: Run, pairs: Sequence[str]) -> Array:
    """Give the largest force of any of some pairs [N] in each bin of the crank turn, shape (BINS,)."""
    motion = settled(run)
    force = np.max([peak(run, pair) for pair in pairs], axis=0)[motion.hold]
    turned = np.mod(motion.crank_angle[motion.hold] - gravity_turn(motion.design), 2 * np.pi)
    number = np.minimum((turned * BINS / (2 * np.pi)).astype(int), BINS - 1)
    found = np.zeros(BINS)
    np.maximum.at(found, number, force)
    return found


def middle(number: int) -> float:
    """Give the middle of a bin [deg]."""
    return (number + 0.5) * 360.0 / BINS


def largest_of_halves(force: Array) -> tuple[float, float]:
    """Give where a curve over the bins is largest in each half turn [deg]."""
    half = BINS // 2
    return middle(int(np.argmax(force[:half]))), middle(half + int(np.argmax(force[half:])))


def share_near(force: Array, reach: float) -> float:
    """Give the share of a curve's sum that lies within so many degrees of crank angle 0, to either side."""
    bins = round(reach * BINS / 360.0)
    total = float(force.sum())
    return float(force[:bins].sum() + force[-bins:].sum()) / total if total else 0.0


def standing_for_pin_1(design: Design) -> int:
    """Give the number of the ring pin, or lobe, that a start has where gravity finds pin 1: as far from straight up."""
    pitches = round(gravity_turn(design) * design.ring.teeth / (2 * np.pi))
    return (-pitches) % design.ring.teeth + 1


def likeness(curves: Sequence[Array]) -> tuple[float, ...]:
    """Give the correlation of each curve with the mean of the others: 1 where each start repeats the same."""
    return tuple(
        float(np.corrcoef(curve, np.mean([other for other in curves if other is not curve], axis=0))[0, 1])
        for curve in curves
    )
