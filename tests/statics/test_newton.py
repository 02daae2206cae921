"""Steps of Newton's method downhill, where the energy is not convex everywhere."""

import numpy as np
import pytest

from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import njit
from cycloid_mj.statics.kernel.newton import modified_newton_step


@njit()
def rolled_off(matrix: Array, right: Array, floating: float) -> Array:
    out, vectors = np.empty_like(right), np.empty_like(matrix)
    modified_newton_step(matrix.copy(), right, out, floating, vectors)
    return out


@pytest.mark.slow
@pytest.mark.parametrize("least", [2.0, 0.2, 0.05, 0.0, -0.05, -3.0])
def test_a_descent_step_uses_the_absolute_curvature_above_a_floor(least: float) -> None:
    random = np.random.default_rng(1)
    ways, _ = np.linalg.qr(random.normal(size=(7, 7)))
    curvature, right = np.array([least, 0.3, 1.0, 2.0, 4.0, 5.0, 9.0]), random.normal(size=7)
    matrix = (ways * curvature) @ ways.T
    expected = ways @ ((ways.T @ right) / np.maximum(np.abs(curvature), 0.1))
    np.testing.assert_allclose(rolled_off((matrix + matrix.T) / 2.0, right, 0.1), expected, rtol=1e-9)
