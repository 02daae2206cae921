"""Errata of Hsieh 2014: printed formula, corrected formula, and a numerical proof.

A proof differentiates the preceding equation by finite differences of fourth order (error h^4 in the step h, rounding
eps/h or eps/h^2). It computes the relative errors of the printed and of the corrected formula.
"""

# ruff: noqa: RUF001 - the formulas are shown as they are printed, in Greek and with minus signs

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.geometry import kinematics
from cycloid_mj.geometry.kinematics import CrankLaw
from cycloid_mj.geometry.profile import unit
from hsieh2014 import equations as eq

TIMES = np.linspace(0.113, 0.149, 37)
"""Times of a crank turn at constant speed, and of part of one in the ramp [s]."""

LAWS = ((eq.HOLD, 5e-5), (eq.RAMP, 2e-4))
"""Laws of the crank, and the step of second differences in each [s]."""

GRAVITY = 9.8
RIGHT = 1e-8
"""Largest relative error allowed for a corrected formula; finite differences are more accurate."""


@dataclass(frozen=True)
class Erratum:
    """An erratum: the paper's `equation`, the `printed` and the `right` formula, and the reference (`proof`).

    `errors` returns the relative errors of both formulas against the reference. An erratum is `harmless` if the printed
    formula nevertheless yields the right numbers.
    """

    equation: str
    printed: str
    right: str
    proof: str
    errors: Callable[[], tuple[float, float]]
    harmless: bool = False

    def as_json(self) -> dict[str, Any]:
        """Convert the erratum with its two errors to JSON values."""
        printed, right = self.errors()
        texts = {"equation": self.equation, "printed": self.printed, "right": self.right, "proof": self.proof}
        return {**texts, "printed_error": printed, "right_error": right, "harmless": self.harmless}


def first(function: Callable[[Array], Array], points: npt.ArrayLike, h: float) -> Array:
    """Differentiate a function once, at points of shape (n,)."""
    x = np.asarray(points, float)
    near, far = (function(x + k * h) - function(x - k * h) for k in (1, 2))
    return (8 * near - far) / (12 * h)


def second(function: Callable[[Array], Array], points: npt.ArrayLike, h: float) -> Array:
    """Differentiate a function twice, at points of shape (n,)."""
    x = np.asarray(points, float)
    near, far = (function(x + k * h) + function(x - k * h) for k in (1, 2))
    return (16 * near - far - 30 * function(x)) / (12 * h**2)


def relative_error(computed: npt.ArrayLike, wanted: npt.ArrayLike) -> float:
    """Compute the largest difference of two arrays as a share of the largest value wanted."""
    computed, wanted = np.asarray(computed, float), np.asarray(wanted, float)
    return float(np.abs(computed - wanted).max() / np.abs(wanted).max())


def misses(printed: npt.ArrayLike, right: npt.ArrayLike, wanted: npt.ArrayLike) -> tuple[float, float]:
    """Compute the relative errors of a printed and of a corrected formula."""
    return relative_error(printed, wanted), relative_error(right, wanted)


def least_and_most(errors: Iterable[tuple[float, float]]) -> tuple[float, float]:
    """Return the smallest error of the printed and the largest error of the right formula over several cases."""
    printed, right = zip(*errors, strict=True)
    return min(printed), max(right)


def tangency_error(sign: int) -> float:
    """Compute how far the outline by Eq. 2 is from being tangent to the pin [1]: largest cosine of tangent and radius.

    An outline touches a pin where its tangent is perpendicular to the pin's radius. `sign` is that of `equations.eq2`.
    """
    worst = 0.0
    for pin_angle in 2 * np.pi * np.array([1, 5, 11]) / eq.GEAR.ring_teeth:
        crank = pin_angle - np.linspace(0.3, 2.8, 26)
        point, pin = eq.eq2(sign, pin_angle, crank)
        run = first(partial(eq.eq2_point, sign, pin_angle), crank, 1e-3)
        normal = (pin - point) / eq.GEAR.pin_radius
        worst = max(worst, float(np.abs(np.sum(run * normal, axis=1) / np.linalg.norm(run, axis=1)).max()))
    return worst


def _eq6() -> tuple[float, float]:
    angle = np.linspace(0.1, 6.0, 25)
    wanted = first(lambda turn: eq.GEAR.pin_circle_radius * unit(-turn), angle, 1e-3)
    printed, right = (eq.eq6(third, eq.GEAR.pin_circle_radius * unit(-angle))[:, :2] for third in (1.0, 0.0))
    return misses(printed, right, wanted)


def orbit_speed(rate: float) -> float:
    """Speed [rad/s] at which the gear's centre by Eq. 16 revolves counter-clockwise, at a rate dzeta/dt."""
    moved = first(lambda time: kinematics.gear_centre(eq.GEAR, eq.GEAR.lobes * rate * time), np.array([0.01]), 1e-5)
    later = kinematics.gear_centre(eq.GEAR, eq.GEAR.lobes * rate * 0.01)
    return float((later[0] * moved[0, 1] - later[1] * moved[0, 0]) / eq.GEAR.eccentricity**2)


def _eq12() -> tuple[float, float]:
    return misses(orbit_speed(eq.eq12(-1, eq.SPEED)), orbit_speed(eq.eq12(1, eq.SPEED)), eq.SPEED)


def _eq13() -> tuple[float, float]:
    speed = np.linalg.norm(first(partial(eq.centre, eq.HOLD), TIMES, 1e-5), axis=1)
    return misses(eq.eq13(eq.SPEED / eq.GEAR.lobes), eq.eq13(eq.SPEED), speed)


def _eq14() -> tuple[float, float]:
    return least_and_most(
        misses(eq.eq14_printed(law, TIMES), eq.eq14_right(law, TIMES), np.linalg.norm(at_law, axis=1))
        for law, at_law in ((law, second(partial(eq.centre, law), TIMES, step)) for law, step in LAWS)
    )


def _eq17() -> tuple[float, float]:
    zeta = eq.zeta_at(eq.HOLD)(TIMES)
    wanted = first(eq.place, zeta, 2e-4)
    return misses(eq.eq17(1, zeta), eq.eq17(-1, zeta), wanted)


def _eq18() -> tuple[float, float]:
    zeta = eq.zeta_at(eq.HOLD)(TIMES)
    wanted = np.linalg.norm(first(eq.place, zeta, 2e-4), axis=1)
    return misses(np.linalg.norm(eq.eq17(1, zeta), axis=1), eq.eq18(zeta), wanted)


def acceleration(law: CrankLaw, h: float) -> Array:
    """Second difference of the position of q by time [m/s^2], shape (n, 2)."""
    return second(lambda time: eq.place(eq.zeta_at(law)(time)), TIMES, h)


def _eq19() -> tuple[float, float]:
    return least_and_most(
        misses(eq.eq19_printed(law, TIMES), eq.eq19_right(law, TIMES), acceleration(law, step)) for law, step in LAWS
    )


def _eq20() -> tuple[float, float]:
    """Compute the relative errors of Eq. 20 as printed and as corrected, at constant speed and in the ramp.

    The reference is the magnitude of the acceleration of q.
    """
    wanted = np.linalg.norm(acceleration(eq.HOLD, 5e-5), axis=1)
    zeta, rate = eq.zeta_at(eq.HOLD)(TIMES), eq.SPEED / eq.GEAR.lobes
    ramp_run = np.linalg.norm(acceleration(eq.RAMP, 2e-4), axis=1)
    motion = eq.RAMP.angle_at(TIMES), eq.RAMP.speed_at(TIMES), eq.RAMP.acceleration_at(TIMES)
    in_ramp = relative_error(kinematics.point_acceleration(eq.GEAR, eq.Q, *motion), ramp_run)
    printed, right = misses(rate**2 * eq.eq20(-1, zeta), rate**2 * eq.eq20(1, zeta), wanted)
    return printed, max(right, in_ramp)


def _eq21() -> tuple[float, float]:
    """Compute the relative errors of Eq. 21 as printed and as corrected, for a unit mass that swings on the eccentric.

    The acceleration of the mass follows from constant energy.
    """
    c, theta, rate = eq.GEAR.eccentricity, 0.7, 30.0
    growth = GRAVITY / c * np.sin(theta)
    at_rest = np.array([0.0])
    swing = second(lambda t: kinematics.gear_centre(eq.GEAR, theta + rate * t + growth * t**2 / 2), at_rest, 2e-5)[0]
    position = kinematics.gear_centre(eq.GEAR, theta)
    variation = np.array([-np.cos(theta), -np.sin(theta)])
    weight = np.array([0.0, -GRAVITY])
    return eq.eq21(position, weight, swing), eq.eq21(variation, weight, swing)


def _eq27() -> tuple[float, float]:
    time = 0.0123
    wanted = second(partial(eq.centre, eq.HOLD), np.array([time]), 5e-5)[0]
    speed = first(partial(eq.centre, eq.HOLD), np.array([time]), 1e-5)[0]
    return misses(eq.eq27(np.ones(2), time), eq.eq27(speed, time), wanted)


PERPENDICULAR = "at the contact, the profile is perpendicular to the pin's radius"
ONCE = "Eq. 16, differentiated"
SWING = "acceleration of a mass that swings on the eccentric, from constant energy"
ERRATA = (
    Erratum("2", "α + ζ", "α − ζ", PERPENDICULAR, lambda: (tangency_error(1), tangency_error(-1))),
    Erratum(
        "6, 10",
        "R with the third component 1",
        "third component 0",
        "velocity of a rotating point, by differentiation of its position",
        _eq6,
        True,
    ),
    Erratum(
        "12, 17",
        "ω_c = −ω_i/SR and ω_c = dζ/dt",
        "dζ/dt = +ω_i/SR in Eqs 16–20",
        "the disc's centre of Eq. 16 orbits at the crank speed, +ω_i",
        _eq12,
    ),
    Erratum("13", "v_c = c ω_c", "v_c = c ω_i", "position of the disc's centre, differentiated", _eq13),
    Erratum(
        "14",
        "a_c = c ω_c²",
        "a_c = c ω_i²; in the ramp also c dω_i/dt along the tangent",
        "position of the disc's centre, differentiated twice, at constant speed and in the ramp",
        _eq14,
    ),
    Erratum(
        "17",
        "+c(N−1) cos((N−1)ζ), +c(N−1) sin((N−1)ζ)",
        "−c(N−1) cos((N−1)ζ), −c(N−1) sin((N−1)ζ)",
        "Eq. 16, differentiated",
        _eq17,
    ),
    Erratum(
        "18",
        "equal to the magnitude of the printed Eq. 17",
        "equal to the magnitude of the corrected Eq. 17",
        ONCE,
        _eq18,
    ),
    Erratum(
        "19",
        "ω_c² = d²ζ/dt²",
        "(dζ/dt)²; in the ramp also Eq. 17 / ω_c times d²ζ/dt²",
        "Eq. 16, differentiated twice by time, at constant speed and in the ramp",
        _eq19,
    ),
    Erratum(
        "20",
        "−2c(N−1)² (q_y cos Nζ − q_x sin Nζ)",
        "+2c(N−1)² (q_y cos Nζ − q_x sin Nζ); in the ramp also the tangential term",
        "magnitude of the second derivative of Eq. 16, at constant speed and in the ramp",
        _eq20,
    ),
    Erratum("21", "κ sᵀ(F − M s″) = 0", "δsᵀ(F − M s″) = 0", SWING, _eq21),
    Erratum(
        "27",
        "2 dΩ_s/dt (a matrix; evaluated with s′ = (1, 1))",
        "2 (dΩ_s/dt) s′",
        "position of the disc's centre, differentiated twice (constraints rotate with the crank)",
        _eq27,
    ),
)


def errata() -> list[dict[str, Any]]:
    """Return every erratum with the errors of the printed and of the right formula."""
    return [erratum.as_json() for erratum in ERRATA]
