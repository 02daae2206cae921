"""Rolling bearings: load ratings from their rollers or balls, and rating life (ISO 76, ISO 281:2007)."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import HOUR

EXPONENT = 10.0 / 3.0
"""p of the life of roller bearings, L = (C/P)^p millions of turns."""

BALL_EXPONENT = 3.0
"""p of the life of ball bearings."""


@dataclass(frozen=True)
class Iso281:
    """Factors of the basic load ratings and the reliability of ISO 281:2007.

    Attributes
    ----------
    roller_steel, ball_steel
        b_m of roller bearings with machined rings, and of deep groove ball bearings (Table 8, contemporary steel).
    roller_factor, roller_reduction
        Factor of the formula behind the table of f_c of rollers [N, mm], and its reduction lambda nu for uneven loads
        along a roller (ISO/TR 1281-1).
    ball_factor, ball_reduction
        The same of balls, with lambda: the formula agrees with Table 2 from gamma 0.01 to 0.3 within its rounding.
    groove
        Radius of the grooves of a deep groove ball bearing over the balls' diameter (5.1).
    weibull_slope, min_life_share
        Weibull slope of the lives, and the share of L10 that every bearing reaches (Table 12).
    """

    roller_steel: float = 1.1
    ball_steel: float = 1.3
    roller_factor: float = 208.0
    roller_reduction: float = 0.83
    ball_factor: float = 40.2
    ball_reduction: float = 0.95
    groove: float = 0.52
    weibull_slope: float = 1.5
    min_life_share: float = 0.05


ISO_281 = Iso281()


def dynamic_capacity(rollers: float, diameter: float, length: float, pitch_diameter: float) -> float:
    """Compute the basic dynamic load rating of a row of radial rollers [N]: C = b_m f_c L^(7/9) Z^(3/4) D^(29/27).

    By ISO 281:2007, 7.2, with its factors b_m and f_c; f_c follows from the formula behind its table (ISO/TR 1281-1).
    `rollers` Z is the number of rollers, which need not be an integer; `diameter` D and `length` L of a roller and the
    `pitch_diameter` are in [m], and are converted to mm for the formula.
    """
    gamma = diameter / pitch_diameter
    raceway_ratio = 1.04 * ((1.0 - gamma) / (1.0 + gamma)) ** (143.0 / 108.0)
    size_factor = gamma ** (2.0 / 9.0) * (1.0 - gamma) ** (29.0 / 27.0) / (1.0 + gamma) ** 0.25
    factor = ISO_281.roller_factor * ISO_281.roller_reduction * size_factor * (1.0 + raceway_ratio**4.5) ** (-2.0 / 9.0)
    size_in_mm = (1e3 * length) ** (7.0 / 9.0) * (1e3 * diameter) ** (29.0 / 27.0)
    return ISO_281.roller_steel * factor * rollers**0.75 * size_in_mm


def static_capacity(rollers: float, diameter: float, length: float, pitch_diameter: float) -> float:
    """Compute the basic static load rating of a row of radial rollers [N]: 44 (1 - D/D_pw) Z L D (ISO 76), in [m]."""
    return 44.0 * (1.0 - diameter / pitch_diameter) * rollers * (1e3 * length) * (1e3 * diameter)


def ball_capacity(balls: float, diameter: float, pitch_diameter: float) -> float:
    """Compute the basic dynamic load rating of a row of deep groove balls [N]: C = b_m f_c Z^(2/3) D^1.8.

    By ISO 281:2007, 5.1, for balls of at most 25.4 mm, with its factors b_m and f_c; f_c follows from the formula
    behind its Table 2. `balls` Z is the number of balls; `diameter` D of a ball and `pitch_diameter` are in [m], and
    are converted to mm for the formula.
    """
    gamma = diameter / pitch_diameter
    raceway_ratio = 1.04 * ((1.0 - gamma) / (1.0 + gamma)) ** 1.72
    groove_factor = (2.0 * ISO_281.groove / (2.0 * ISO_281.groove - 1.0)) ** 0.41
    size_factor = gamma**0.3 * (1.0 - gamma) ** 1.39 / (1.0 + gamma) ** (1.0 / 3.0)
    factor = (
        ISO_281.ball_factor
        * ISO_281.ball_reduction
        * groove_factor
        * size_factor
        * (1.0 + raceway_ratio ** (10.0 / 3.0)) ** -0.3
    )
    return float(ISO_281.ball_steel * factor * balls ** (2.0 / 3.0) * (1e3 * diameter) ** 1.8)


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
    least = ISO_281.min_life_share
    return least + (1.0 - least) * ratio ** (1.0 / ISO_281.weibull_slope)


def life_hours(
    capacity: float, load: float, speed: float, reliability: float = 0.9, exponent: float = EXPONENT
) -> float:
    """Compute the rating life [h] of a bearing: a_1 10^6 (C/P)^p turns (ISO 281:2007); infinite without load or speed.

    Parameters
    ----------
    capacity, load
        Basic dynamic load rating C and equivalent load P [N].
    speed
        Relative speed of the rings [rad/s].
    reliability, exponent
        Share of bearings that reach the life, at least 0.9, and the exponent p.
    """
    if load == 0.0 or speed == 0.0:
        return math.inf
    turns = reliability_factor(reliability) * 1e6 * (capacity / load) ** exponent
    return float(turns * 2.0 * math.pi / abs(speed) / HOUR)


def load_for_life(
    capacity: float, life: float, speed: float, reliability: float, exponent: float = BALL_EXPONENT
) -> float:
    """Compute the load on a bearing [N] for a life [h] at a relative speed of its rings [rad/s]."""
    turns = life * HOUR * abs(speed) / (2.0 * math.pi)
    return float(capacity * (reliability_factor(reliability) * 1e6 / turns) ** (1.0 / exponent))


def magnitudes(force: Array) -> Array:
    """Compute the magnitudes of forces, shape (..., 2) -> (...)."""
    return np.asarray(np.linalg.norm(force, axis=-1))
