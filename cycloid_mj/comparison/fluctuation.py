"""Fluctuation of a quantity about its closed form: rms over full crank turns, and of each turn."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.analysis import Series
from cycloid_mj.analysis.window import turn_by_turn
from cycloid_mj.base.array import Array
from cycloid_mj.base.statistics import rms


@dataclass(frozen=True)
class Level:
    """Rms value of a fluctuation over full crank turns, and of each turn."""

    rms: float
    by_turn: tuple[float, ...]


def full_turns(motion: Series) -> list[slice]:
    """List the samples of each full crank turn of the settled hold; all samples where it is shorter than a turn."""
    first_index = int(np.argmax(motion.hold))
    return [
        slice(first_index + turn.start, first_index + turn.stop)
        for turn in turn_by_turn(motion.crank_angle[first_index:])
    ]


def compute_level(values: Array, parts: Sequence[slice]) -> Level:
    """Compute the level of a signal, shape (n,), or of the magnitude of vectors, shape (n, 2), over parts of it."""
    size = np.linalg.norm(values, axis=1) if values.ndim == 2 else values
    return Level(rms(np.concatenate([size[part] for part in parts])), tuple(rms(size[part]) for part in parts))


def remove_steady_shifts(errors: Array, crank_angle: Array, gear_angle: Array) -> Array:
    """Subtract steady shifts from n errors of a path or a velocity, shape (n, 2), by linear least squares.

    A shift that is constant in the frame of the housing, the crank or the disc is clearance taken up or elastic
    deflection, not vibration. With x + i y these are the terms a + b e^(i theta) + d e^(i phi) at `crank_angle` theta
    and ideal `gear_angle` phi = -theta/(N-1) [rad], shape (n,), for N ring teeth; the last term coincides with the
    first for a disc that does not turn. Returns the remaining errors, shape (n, 2).
    """
    shift_terms = np.exp(1j * np.stack([np.zeros_like(crank_angle), crank_angle, gear_angle], axis=1))
    complex_error = errors[:, 0] + 1j * errors[:, 1]
    remainder = complex_error - shift_terms @ np.linalg.lstsq(shift_terms, complex_error, rcond=None)[0]
    return np.stack([remainder.real, remainder.imag], axis=1)
