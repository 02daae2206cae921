"""Arrays for the page: as many points as can be told apart, in single precision."""

import base64
from typing import Any

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array


def encoded(values: npt.ArrayLike) -> dict[str, Any]:
    """Encode an array of any shape as JSON that the page decodes."""
    array = np.asarray(values, dtype="<f4")
    return {"shape": list(array.shape), "f32": base64.b64encode(array.tobytes()).decode()}


def decimated(time: Array, values: Array, most: int) -> tuple[Array, Array]:
    """Compute at most about `most` samples of columns that keep every extreme.

    Parameters
    ----------
    time
        Shape (n,).
    values
        Shape (n, k).
    most
        Samples wanted.

    Returns
    -------
    tuple
        Times (m,) and values (m, k): themselves if there are not more samples, else the smallest and the largest value
        of each column in each of m/2 spans of time, in the order in which they occur.
    """
    count = time.size
    if count <= most:
        return time, values
    width = -(-count // max(1, most // 2))
    spans = -(-count // width)
    # the last span is filled up with its last sample, which changes no extreme
    rows = np.minimum(np.arange(spans * width), count - 1).reshape(spans, width)
    kept = np.empty((2 * spans, values.shape[1]))
    for column, whole in enumerate(values.T):  # one at a time: a copy of all would be as large as a long run
        block = whole[rows]
        both = np.sort(np.stack([block.argmin(axis=1), block.argmax(axis=1)], axis=1), axis=1)
        kept[:, column] = np.take_along_axis(block, both, axis=1).ravel()
    return time[rows[:, [0, width // 2]]].ravel(), kept
