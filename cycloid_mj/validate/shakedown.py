"""Validation step "published": shakedown of a rolling line contact."""

import math

import numpy as np
from scipy.optimize import minimize

from cycloid_mj.base.array import Array
from cycloid_mj.base.validation import ValidationRow, relative
from cycloid_mj.design.materials import SHAKEDOWN_PRESSURE, YIELD_PRESSURE


def rows(quick: bool) -> list[ValidationRow]:
    """Compare first yield and shakedown under a rolling line contact with the elastic stress field below it.

    Residual stresses can cancel all stresses but the orthogonal shear, which changes sign as the load passes (Melan).
    At shakedown, the largest orthogonal shear is therefore the shear strength k. By Johnson (Contact Mechanics, 1985,
    9.2, Eqs 9.5 and 9.6), it is 0.25 of Hertz's peak pressure p0, at (0.87, 0.50) half widths; the load at shakedown is
    1.66 times the load at first yield. Yield is by von Mises with Poisson's ratio 0.3.

    The first two rows are p0/k at shakedown and the position of the largest orthogonal shear, both from the stress
    field. The third compares `SHAKEDOWN_PRESSURE` with this p0/k. The last is the ratio of the loads at shakedown and
    at first yield. `quick` is ignored.
    """
    shear_minimum = minimize(_minus_shear, np.array([0.8, 0.5]), method="Nelder-Mead", tol=1e-10)
    source = "Johnson, Contact Mechanics (1985), 9.2"
    shakedown_limit = 1.0 / -shear_minimum.fun
    ratio = (SHAKEDOWN_PRESSURE / YIELD_PRESSURE) ** 2
    return [
        relative("shakedown of a rolling line, p0/k, from the field", shakedown_limit, 4.0, "1", source, 1.0),
        relative("position of the largest orthogonal shear, x/a", abs(shear_minimum.x[0]), 0.87, "1", source, 1.0),
        relative(
            "shakedown, p0/k, in use", SHAKEDOWN_PRESSURE * math.sqrt(3.0), shakedown_limit, "1", "the field above", 1.0
        ),
        relative("load at shakedown over that at first yield", ratio, 1.66, "1", source, 1.0),
    ]


def _minus_shear(position: Array) -> float:
    """Compute -|tau_xz|/p0 below a line contact at (x, z) half widths (McEwen; Johnson 1985, Eq. 4.49)."""
    x, z = float(position[0]), abs(float(position[1])) + 1e-12
    base = 1.0 - x**2 + z**2
    root = math.sqrt(base**2 + 4.0 * x**2 * z**2)
    m, n = math.sqrt(0.5 * (root + base)), math.copysign(math.sqrt(max(0.5 * (root - base), 0.0)), x)
    return -abs(n * (m**2 - z**2) / (m**2 + n**2))
