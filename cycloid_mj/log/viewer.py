"""Interface for viewer message writers, and when a message is due."""

from collections.abc import Iterable, Mapping
from typing import Protocol

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array

Message = tuple[str, int, bytes]
"""Topic, time [ns] and content of a message."""

RATE = "rate_hz"
"""Key of a viewer channel's metadata: its frames per second."""


class Viewer(Protocol):
    """Makes the viewers' messages of a log from its samples."""

    @property
    def rate(self) -> float:
        """Frames per second of the log's time [1/s]."""

    @property
    def schemas(self) -> Mapping[str, tuple[str, bytes]]:
        """Topic -> name and serialized FileDescriptorSet of its protobuf message."""

    def opening(self, time: float) -> Iterable[Message]:
        """Yield the messages that come once, at the `time` [s] of the first sample."""

    def frames(self, time: Array, columns: Mapping[str, Array]) -> Iterable[Message]:
        """Yield the messages of k samples: `time` [s] and each column have shape (k,)."""


def due(time: Array, last: float, rate: float) -> npt.NDArray[np.intp]:
    """Find the samples that are the first at or after a multiple of 1/`rate` [s].

    Parameters
    ----------
    time
        Times of the samples [s], increasing.
    last
        Time of the sample before them [s], -inf if there is none.
    rate
        Frames per second.
    """
    # a sample that rounding puts just before its frame still belongs to it
    frame = np.floor(rate * time + 1e-6)
    before = np.floor(rate * last + 1e-6) if np.isfinite(last) else -1.0
    return np.flatnonzero(np.diff(frame, prepend=before) > 0.0)
