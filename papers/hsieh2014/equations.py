"""Equations of Hsieh 2014 as printed and as corrected; `errata` checks both numerically.

Symbols as in `kinematics` and `profile`: N ring teeth, c eccentricity, E, rho, theta crank angle, zeta = theta/(N-1),
q a point of the gear; SI units, the paper's gear.
"""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.geometry import kinematics
from cycloid_mj.geometry.kinematics import CrankLaw
from cycloid_mj.geometry.profile import CycloidGear, conjugate_alpha, unit

GEAR = CycloidGear(ring_teeth=36, eccentricity=1e-3, pin_circle_radius=40.75e-3, pin_radius=2.25e-3)
Q = np.array([5e-3, 24e-3])
"""A point of the gear off its axes, so that no term of Eqs 16-20 vanishes [m]."""

SPEED = 1640.0 * np.pi / 30.0
"""Crank speed of the paper [rad/s]."""
HOLD, RAMP = CrankLaw(SPEED, 0.0), CrankLaw(SPEED, 1.0)


def place(zeta: npt.ArrayLike) -> Array:
    """Position of q for a rotation of the disc (Eq. 16), from its initial centre, shape (..., 2) [m]."""
    return kinematics.point_path(GEAR, Q, GEAR.lobes * np.asarray(zeta, float)).position


def centre(law: CrankLaw, time: Array) -> Array:
    """Gear centre from the axis, shape (n, 2) [m]."""
    return kinematics.gear_centre(GEAR, law.angle_at(time))


def zeta_at(law: CrankLaw) -> Callable[[Array], Array]:
    """Return zeta(t) = theta(t)/(N-1) of a crank law."""
    return lambda time: law.angle_at(time) / GEAR.lobes


def eq2(sign: int, pin_angle: float, crank: npt.ArrayLike) -> tuple[Array, Array]:
    """Compute the point of the gear that a pin touches, and that pin's centre, in the gear frame (Eq. 2), (..., 2) [m].

    The point is the pin's centre E u(zeta) less rho (-sin, cos)(alpha + sign zeta), rotated into the gear frame. `sign`
    1 is as printed, -1 as corrected; `pin_angle` is the pin's angle on the ring, `crank` the crank angle [rad].
    """
    N, c, E, rho = GEAR.symbols
    phi = np.asarray(crank, float)
    alpha, turn = conjugate_alpha(GEAR, pin_angle - phi), phi / (N - 1)
    centre = E * unit(pin_angle + turn) - c * unit(N * turn)
    return centre - rho * unit(-(alpha + sign * pin_angle) + turn), centre


def eq2_point(sign: int, pin_angle: float, crank: npt.ArrayLike) -> Array:
    """Point of the gear that a pin touches (Eq. 2), shape (..., 2) [m]."""
    return eq2(sign, pin_angle, crank)[0]


def eq6(third: float, position: Array) -> Array:
    """Velocity k x R of a point [m/s at 1 rad/s] whose R has a third component (Eqs 6 and 10), shape (..., 3)."""
    R = np.concatenate([position, np.full((*position.shape[:-1], 1), third)], axis=-1)
    return np.cross([0.0, 0.0, 1.0], R)


def eq12(sign: int, omega_i: float) -> float:
    """Rate dzeta/dt = sign omega_i/(N-1) [rad/s] in Eqs 16-20 (Eqs 12 and 17)."""
    return sign * omega_i / GEAR.lobes


def eq13(omega: float) -> float:
    """Speed of the gear's centre c omega [m/s] (Eq. 13): printed with omega_c, right with omega_i."""
    return GEAR.eccentricity * omega


def eq14_printed(law: CrankLaw, time: Array) -> Array:
    """Acceleration of the gear's centre c omega_c^2 [m/s^2], shape (n,), as printed."""
    return GEAR.eccentricity * (law.speed_at(time) / GEAR.lobes) ** 2


def eq14_right(law: CrankLaw, time: Array) -> Array:
    """Acceleration of the gear's centre: c omega_i^2, and c domega_i/dt across it [m/s^2], shape (n,)."""
    return GEAR.eccentricity * np.hypot(law.speed_at(time) ** 2, law.acceleration_at(time))


def eq17(sign: int, zeta: Array) -> Array:
    """Compute the derivative dr/dzeta of q [m], shape (n, 2), with `sign` c (N-1) (cos, sin) ((N-1) zeta)."""
    q_x, q_y = Q
    orbit = GEAR.eccentricity * GEAR.lobes * np.stack([np.cos(GEAR.lobes * zeta), np.sin(GEAR.lobes * zeta)], axis=1)
    x, y = q_y * np.cos(zeta) - q_x * np.sin(zeta), -q_x * np.cos(zeta) - q_y * np.sin(zeta)
    return np.stack([x, y], axis=1) + sign * orbit


def eq18(zeta: Array) -> Array:
    """Size of dr/dzeta [m], shape (n,), as printed: sqrt(c^2 (N-1)^2 + q^2 + 2 c (N-1) (q_x sin - q_y cos)(N zeta))."""
    turn, arm = GEAR.ring_teeth * zeta, GEAR.eccentricity * GEAR.lobes
    return np.sqrt(arm**2 + Q @ Q + 2 * arm * (Q[0] * np.sin(turn) - Q[1] * np.cos(turn)))


def curve(zeta: Array) -> Array:
    """Second derivative d2r/dzeta2 of the position of q [m], shape (n, 2), as in Eq. 19."""
    N, c = GEAR.lobes, GEAR.eccentricity
    q_x, q_y = Q
    orbit = c * N**2 * np.stack([np.sin(N * zeta), -np.cos(N * zeta)], axis=1)
    x, y = -q_x * np.cos(zeta) - q_y * np.sin(zeta), q_x * np.sin(zeta) - q_y * np.cos(zeta)
    return np.stack([x, y], axis=1) + orbit


def eq19_printed(law: CrankLaw, time: Array) -> Array:
    """Acceleration of q with omega_c^2 = d2zeta/dt2, as printed [m/s^2], shape (n, 2)."""
    return curve(zeta_at(law)(time)) * (law.acceleration_at(time) / GEAR.lobes)[:, np.newaxis]


def eq19_right(law: CrankLaw, time: Array) -> Array:
    """Acceleration of q: d2r/dzeta2 (dzeta/dt)^2 + dr/dzeta d2zeta/dt2 [m/s^2], shape (n, 2)."""
    zeta = zeta_at(law)(time)
    rate, growth = law.speed_at(time) / GEAR.lobes, law.acceleration_at(time) / GEAR.lobes
    return curve(zeta) * rate[:, np.newaxis] ** 2 + eq17(-1, zeta) * growth[:, np.newaxis]


def eq20(sign: int, zeta: Array) -> Array:
    """Size of d2r/dzeta2 [m], shape (n,), with `sign` 2 c (N-1)^2 (q_y cos N zeta - q_x sin N zeta)."""
    turn, arm = GEAR.ring_teeth * zeta, GEAR.eccentricity * GEAR.lobes**2
    return np.sqrt(arm**2 + Q @ Q + sign * 2 * arm * (Q[1] * np.cos(turn) - Q[0] * np.sin(turn)))


def eq21(direction: Array, force: Array, inertia: Array) -> float:
    """Work (F - M s'') along a direction, per unit of it and of the weight (Eq. 21): 0 for admissible directions."""
    return float(abs(direction @ (force - inertia)) / np.linalg.norm(direction) / np.linalg.norm(force))


def eq27(speed: Array, time: float) -> Array:
    """Compute the acceleration of the gear's centre [m/s^2], shape (2,), from two constraints that move (Eq. 27).

    Omega(s, t) = (s . u, s . v - c) with u, v across and along the eccentric: Omega_s s'' = -(2 (dOmega_s/dt) s' +
    d2Omega/dt2). `speed` is inserted for s', shape (2,); `time` is in seconds.
    """
    law = HOLD
    theta, omega, s = law.angle_at(time), SPEED, kinematics.gear_centre(GEAR, law.angle_at(time))
    frame = np.array([[np.cos(theta), np.sin(theta)], [-np.sin(theta), np.cos(theta)]])
    turned = omega * np.array([[-np.sin(theta), np.cos(theta)], [-np.cos(theta), -np.sin(theta)]])
    return np.linalg.solve(frame, -(2 * turned @ speed - omega**2 * frame @ s))
