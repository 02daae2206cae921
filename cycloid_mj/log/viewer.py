"""Interface of what writes messages for viewers, and the selection of their samples."""

from collections.abc import Iterable, Mapping
from typing import Protocol

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array

Message = tuple[str, int, bytes]
"""Topic, time [ns] and content of a message."""

FRAME_TOLERANCE = 1e-6
"""Part of a frame by which a sample may precede its frame: it does by rounding."""

RATE = "rate_hz"
"""Key of the frames per second in the metadata of a viewer channel."""


class Viewer(Protocol):
    """Computes the messages for viewers from the samples of a log."""

    @property
    def rate(self) -> float:
        """Frames per second of the log's time [1/s]."""

    @property
    def schemas(self) -> Mapping[str, tuple[str, bytes]]:
        """Topic -> name and serialized FileDescriptorSet of its protobuf message."""

    def opening(self, time: float) -> Iterable[Message]:
        """Yield the messages that occur once, at the `time` [s] of the first sample."""

    def frames(self, time: Array, columns: Mapping[str, Array]) -> Iterable[Message]:
        """Yield the messages of k samples: `time` [s] and each column have shape (k,)."""


def select_frames(time: Array, previous_time: float, rate: float) -> npt.NDArray[np.intp]:
    """Return the indices of the samples to show: the first at or after each multiple of 1/`rate`, shape (frames,).

    Parameters
    ----------
    time
        Times of the samples [s], increasing.
    previous_time
        Time of the sample before them [s], -inf if there is none.
    rate
        Frames per second.
    """
    frame = np.floor(rate * time + FRAME_TOLERANCE)
    previous_frame = np.floor(rate * previous_time + FRAME_TOLERANCE) if np.isfinite(previous_time) else -1.0
    return np.flatnonzero(np.diff(frame, prepend=previous_frame) > 0.0)
