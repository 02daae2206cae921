"""Arrays of a page: decimated to what a screen resolves, in single precision."""

import base64
from typing import Any

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array


def encode_array(values: npt.ArrayLike) -> dict[str, Any]:
    """Encode an array of any shape as JSON values: its shape, and float32 in base64."""
    array = np.asarray(values, dtype="<f4")
    return {"shape": list(array.shape), "f32": base64.b64encode(array.tobytes()).decode()}


def decimate(time: Array, values: Array, max_samples: int) -> tuple[Array, Array]:
    """Reduce k columns of n samples to about `max_samples` samples with every extreme (min-max decimation).

    Parameters
    ----------
    time
        Times of the samples, increasing, shape (n,).
    values
        Columns, shape (n, k).
    max_samples
        Requested number of samples.

    Returns
    -------
    tuple
        Times (m,) and values (m, k) of m samples. They are unchanged if there are at most `max_samples` samples.
        Otherwise each column has its smallest and its largest value in each of m/2 spans of time, in the order in which
        they occur.
    """
    sample_count = time.size
    if sample_count <= max_samples:
        return time, values
    span_length = -(-sample_count // max(1, max_samples // 2))
    span_count = -(-sample_count // span_length)
    # the last span is padded with its last sample, which changes no extreme
    rows = np.minimum(np.arange(span_count * span_length), sample_count - 1).reshape(span_count, span_length)
    extreme_values = np.empty((2 * span_count, values.shape[1]))
    for column, samples in enumerate(values.T):  # column by column: a copy of all would be as large as the run
        block = samples[rows]
        extreme_indices = np.sort(np.stack([block.argmin(axis=1), block.argmax(axis=1)], axis=1), axis=1)
        extreme_values[:, column] = np.take_along_axis(block, extreme_indices, axis=1).ravel()
    return time[rows[:, [0, span_length // 2]]].ravel(), extreme_values
