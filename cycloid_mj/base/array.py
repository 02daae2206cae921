"""Arrays: names of their types, and rounding of derived numbers to their significant digits.

SI units and radians throughout, shapes in the docstrings that use the types. The last bits of a sum or a sine depend on
the machine and on the number of threads, and within some turns a rattling gear makes them visible. What enters a model
is rounded, so that the same design is the same model everywhere.
"""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
Bytes = npt.NDArray[np.uint8]

DIGITS = 12
"""Significant digits of derived numbers; what is known of materials and parts ends far before them."""

LENGTH = 1e-15
"""Grid of derived coordinates [m], and of sines and cosines [1]: around zero they have no significant digits."""


def significant(value: float) -> float:
    """Round a number to `DIGITS` significant digits."""
    return float(f"{value:.{DIGITS - 1}e}")


def significant_tensor(values: npt.ArrayLike) -> Array:
    """Return the array `values` with all elements rounded to the same decimals: `DIGITS` digits for the largest."""
    array = np.asarray(values, dtype=np.float64)
    largest_magnitude = float(np.abs(array).max(initial=0.0))
    if largest_magnitude == 0.0:
        return array
    decimals = DIGITS - 1 - int(np.floor(np.log10(largest_magnitude)))
    return (
        np.array([significant(float(element)) for element in np.round(array, decimals).ravel()]).reshape(array.shape)
        + 0.0
    )


def on_grid(values: npt.ArrayLike) -> Array:
    """Round coordinates [m], sines or cosines to the grid of `LENGTH`."""
    decimals = -int(np.log10(LENGTH))
    rounded: Array = np.asarray(values, dtype=np.float64).round(decimals) + 0.0
    return rounded


def cross(a: Array, b: Array) -> Array:
    """Compute the z of vector products of planar vectors, shapes (..., 2)."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def dot(a: Array, b: Array) -> Array:
    """Compute the scalar products of planar vectors, shapes (..., 2); a zero is positive, as that of np.sum."""
    return np.asarray(0.0 + a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1])


def quarter_turned(vectors: Array) -> Array:
    """Rotate planar vectors (..., 2) by 90 degrees counter-clockwise."""
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)


def rotate(vectors: Array, angle: npt.ArrayLike) -> Array:
    """Rotate planar vectors (..., 2) counter-clockwise about the origin by angles (...) [rad]."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
