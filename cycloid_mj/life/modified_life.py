"""Modified rating life of rolling bearings: lubrication and contamination (ISO 281:2007, 9)."""

import math
from dataclasses import dataclass

from cycloid_mj.base.units import RPM
from cycloid_mj.life.rolling import BALL_EXPONENT


@dataclass(frozen=True)
class LifeLimits:
    """Limits of a_ISO and of the fatigue load limit (ISO 281:2007, 9 and B.3.3.3).

    Attributes
    ----------
    min_kappa, max_kappa
        Range of viscosity ratios for which a_ISO is defined; a larger ratio counts as the largest.
    min_factor, max_factor
        Range of a_ISO; the least is used below `min_kappa`, where the standard has no value.
    full_size
        Pitch diameter [m] up to which C_u follows from C0 alone.
    """

    min_kappa: float = 0.1
    max_kappa: float = 4.0
    min_factor: float = 0.1
    max_factor: float = 50.0
    full_size: float = 0.1


LIMITS = LifeLimits()


@dataclass(frozen=True)
class LifeCurve:
    """Constants of a_ISO = 0.1 (1 - (a - b/kappa^c)^d (e_C C_u/P)^e)^f, of balls or rollers.

    `ranges` has upper ends of kappa with b and c (ISO 281:2007, Eqs 31 to 36); `static_share` is C0/C_u of a small
    bearing, and `size_exponent` the decrease of C_u with the pitch diameter beyond `LifeLimits.full_size`.
    """

    offset: float
    ranges: tuple[tuple[float, float, float], ...]
    film_exponent: float
    load_exponent: float
    exponent: float
    static_share: float
    size_exponent: float


BALLS = LifeCurve(
    2.5671,
    ((0.4, 2.2649, 0.054381), (1.0, 1.9987, 0.19087), (LIMITS.max_kappa, 1.9987, 0.071739)),
    0.83,
    1.0 / 3.0,
    -9.3,
    22.0,
    0.5,
)
ROLLERS = LifeCurve(
    1.5859,
    ((0.4, 1.3993, 0.054381), (1.0, 1.2348, 0.19087), (LIMITS.max_kappa, 1.2348, 0.071739)),
    1.0,
    0.4,
    -9.185,
    8.2,
    0.3,
)
"""Radial bearings: Eqs 31 to 33 of balls, 34 to 36 of rollers."""


def life_curve(exponent: float) -> LifeCurve:
    """Return the constants of ball bearings if the exponent of the life is 3, else those of roller bearings."""
    return BALLS if exponent == BALL_EXPONENT else ROLLERS


def reference_viscosity(speed: float, pitch_diameter: float) -> float:
    """Compute the reference kinematic viscosity nu_1 [mm2/s] of a bearing (ISO 281:2007, Eqs 28 and 29).

    Parameters
    ----------
    speed
        Speed of the rings against each other [rad/s], not 0.
    pitch_diameter
        Pitch diameter [m].
    """
    rpm, pitch_mm = abs(speed) / RPM, 1e3 * pitch_diameter
    factor = 45000.0 * rpm**-0.83 if rpm < 1000.0 else 4500.0 / math.sqrt(rpm)
    return factor / math.sqrt(pitch_mm)


def fatigue_load_limit(static: float, pitch: float, curve: LifeCurve) -> float:
    """Compute the fatigue load limit C_u [N] from C0 [N] and the pitch diameter [m] (ISO 281:2007, B.3.3.3)."""
    return static / curve.static_share * min(1.0, LIMITS.full_size / pitch) ** curve.size_exponent


def life_factor(kappa: float, cleanliness: float, limit: float, load: float, curve: LifeCurve) -> float:
    """Compute the life modification factor a_ISO [1] of a radial bearing (ISO 281:2007, Eqs 31 to 36).

    Below the viscosity ratio 0.1, where a_ISO is not defined, its smallest value is returned.

    Parameters
    ----------
    kappa
        Viscosity ratio nu/nu_1 [1], with nu_1 of `reference_viscosity`.
    cleanliness
        Contamination factor e_C [1], from 0 to 1.
    limit, load
        Fatigue load limit C_u and equivalent load P [N].
    curve
        `BALLS` or `ROLLERS`.
    """
    if kappa < LIMITS.min_kappa:
        return LIMITS.min_factor
    kappa = min(kappa, LIMITS.max_kappa)
    factor, power = next(
        (coefficient, exponent)
        for max_range_kappa, coefficient, exponent in curve.ranges
        if kappa < max_range_kappa or max_range_kappa == LIMITS.max_kappa
    )
    film_term = (curve.offset - factor / kappa**power) ** curve.film_exponent
    denominator = 1.0 - film_term * (cleanliness * limit / load) ** curve.load_exponent
    return (
        min(LIMITS.max_factor, LIMITS.min_factor * denominator**curve.exponent)
        if denominator > 0.0
        else LIMITS.max_factor
    )
