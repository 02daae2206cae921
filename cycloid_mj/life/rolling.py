"""Rolling bearings: load ratings from their rollers or balls, and rating life (ISO 76, ISO 281:2007)."""

import math

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array

EXPONENT = 10.0 / 3.0
"""p of the life of roller bearings, L = (C/P)^p millions of turns."""

MACHINED_FACTOR = 1.1
"""b_m of roller bearings with machined rings, of contemporary steel (ISO 281:2007, Table 8)."""

ROLLER_FACTOR, ROLLER_REDUCTION = 208.0, 0.83
"""Of the formula behind the table of f_c [N, mm], and its reduction lambda nu for uneven loads along a roller."""

BALL_EXPONENT = 3.0
"""p of the life of ball bearings."""

BALL_FACTOR, BALL_REDUCTION, BALL_STEEL = 40.2, 0.95, 1.3
"""Of the formula behind the table of f_c of deep groove ball bearings [N, mm], its reduction lambda, and b_m.

With grooves of 0.52 D the formula gives Table 2 of ISO 281:2007 from gamma 0.01 to 0.3 within its rounding.
"""

GROOVE = 0.52
"""Radius of the grooves of a deep groove ball bearing over the balls' diameter (ISO 281:2007, 5.1)."""

WEIBULL_SLOPE, MIN_LIFE_SHARE = 1.5, 0.05
"""Weibull slope of the lives, and the share of L10 that every bearing reaches (ISO 281:2007, Table 12)."""


def dynamic_capacity(rollers: float, diameter: float, length: float, pitch_diameter: float) -> float:
    """Compute the basic dynamic load rating of a row of radial rollers [N]: C = b_m f_c L^(7/9) Z^(3/4) D^(29/27).

    ISO 281:2007, 7.2, with f_c by the formula from which its table is made (ISO/TR 1281-1): lengths [m]. `rollers` need
    not be an integer.
    """
    gamma = diameter / pitch_diameter
    ratio = 1.04 * ((1.0 - gamma) / (1.0 + gamma)) ** (143.0 / 108.0)
    shape = gamma ** (2.0 / 9.0) * (1.0 - gamma) ** (29.0 / 27.0) / (1.0 + gamma) ** 0.25
    factor = ROLLER_FACTOR * ROLLER_REDUCTION * shape * (1.0 + ratio**4.5) ** (-2.0 / 9.0)
    millimetres = (1e3 * length) ** (7.0 / 9.0) * (1e3 * diameter) ** (29.0 / 27.0)
    return MACHINED_FACTOR * factor * rollers**0.75 * millimetres


def static_capacity(rollers: float, diameter: float, length: float, pitch_diameter: float) -> float:
    """Compute the basic static load rating of a row of radial rollers [N]: 44 (1 - D/D_pw) Z L D (ISO 76), in [m]."""
    return 44.0 * (1.0 - diameter / pitch_diameter) * rollers * (1e3 * length) * (1e3 * diameter)


def ball_capacity(balls: float, diameter: float, pitch_diameter: float) -> float:
    """Compute the basic dynamic load rating of a row of deep groove balls [N]: C = b_m f_c Z^(2/3) D^1.8.

    ISO 281:2007, 5.1, for balls of at most 25.4 mm, with f_c by the formula behind its Table 2; lengths [m].
    """
    gamma = diameter / pitch_diameter
    ratio = 1.04 * ((1.0 - gamma) / (1.0 + gamma)) ** 1.72
    groove = (2.0 * GROOVE / (2.0 * GROOVE - 1.0)) ** 0.41
    shape = gamma**0.3 * (1.0 - gamma) ** 1.39 / (1.0 + gamma) ** (1.0 / 3.0)
    factor = BALL_FACTOR * BALL_REDUCTION * groove * shape * (1.0 + ratio ** (10.0 / 3.0)) ** -0.3
    return float(BALL_STEEL * factor * balls ** (2.0 / 3.0) * (1e3 * diameter) ** 1.8)


def side_by_side(capacity: float, count: int) -> float:
    """Compute the dynamic load rating of several like roller bearings next to each other [N], from one (ISO 281)."""
    return count ** (7.0 / 9.0) * capacity


def mean_load(force: npt.ArrayLike, weight: npt.ArrayLike = 1.0, exponent: float = EXPONENT) -> float:
    """Compute the equivalent load of forces [N] with weights, numbers of turns: (sum w F^p/sum w)^(1/p)."""
    forces, weights = np.broadcast_arrays(np.asarray(force, float), np.asarray(weight, float))
    return float((np.sum(weights * forces**exponent) / np.sum(weights)) ** (1.0 / exponent))


def reliability_factor(reliability: float) -> float:
    """Compute a_1 at a reliability S, at least 0.9: 1 at 90 %, 0.64 at 95 %, 0.25 at 99 % (ISO 281:2007, Table 12)."""
    ratio = math.log(1.0 / reliability) / math.log(1.0 / 0.9)
    return MIN_LIFE_SHARE + (1.0 - MIN_LIFE_SHARE) * ratio ** (1.0 / WEIBULL_SLOPE)


def life_hours(
    capacity: float, load: float, speed: float, reliability: float = 0.9, exponent: float = EXPONENT
) -> float:
    """Compute the rating life [h] at a load [N] and a relative speed of the rings [rad/s]: a_1 10^6 (C/P)^p turns."""
    if load == 0.0 or speed == 0.0:
        return math.inf
    turns = reliability_factor(reliability) * 1e6 * (capacity / load) ** exponent
    return float(turns * 2.0 * math.pi / abs(speed) / 3600.0)


def load_for_life(capacity: float, life: float, speed: float, reliability: float) -> float:
    """Compute the load on a ball bearing [N] for a life [h] at a relative speed of its rings [rad/s]."""
    turns = life * 3600.0 * abs(speed) / (2.0 * math.pi)
    return float(capacity * (reliability_factor(reliability) * 1e6 / turns) ** (1.0 / BALL_EXPONENT))


def magnitudes(force: Array) -> Array:
    """Compute the magnitudes of forces, shape (..., 2) -> (...)."""
    return np.asarray(np.linalg.norm(force, axis=-1))
