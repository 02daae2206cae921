"""How much a quantity fluctuates about its closed form: over whole crank turns, and turn by turn."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.analysis import Series
from cycloid_mj.analysis.window import turn_by_turn
from cycloid_mj.base.array import Array
from cycloid_mj.base.statistics import rms


@dataclass(frozen=True)
class Level:
    """The rms value of a fluctuation over some crank turns, and that of each turn."""

    rms: float
    by_turn: tuple[float, ...]


def turns(motion: Series) -> list[slice]:
    """List the samples of each whole crank turn of the settled hold; all of them where it is shorter than a turn."""
    first = int(np.argmax(motion.hold))
    return [slice(first + turn.start, first + turn.stop) for turn in turn_by_turn(motion.crank_angle[first:])]


def level(values: Array, parts: Sequence[slice]) -> Level:
    """Compute the level of a signal (n,), or of a vector's size (n, 2), over parts of it."""
    size = np.linalg.norm(values, axis=1) if values.ndim == 2 else values
    return Level(rms(np.concatenate([size[part] for part in parts])), tuple(rms(size[part]) for part in parts))


def unshifted(error: Array, crank_angle: Array, gear_angle: Array) -> Array:
    """Take from the errors (n, 2) of a path or a velocity what a steady shift explains, by least squares.

    A shift that is constant in the frame of the housing, of the crank or of the gear is play taken up or elastic
    deflection, not vibration: with x + i y, the terms a + b e^(i theta) + d e^(i phi) at `crank_angle` theta and ideal
    `gear_angle` phi = -theta/(N-1) [rad], shape (n,); the last drops out of a gear that does not turn.
    """
    shifts = np.exp(1j * np.stack([np.zeros_like(crank_angle), crank_angle, gear_angle], axis=1))
    together = error[:, 0] + 1j * error[:, 1]
    left = together - shifts @ np.linalg.lstsq(shifts, together, rcond=None)[0]
    return np.stack([left.real, left.imag], axis=1)
