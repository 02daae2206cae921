"""Closed-form motion of the ideal reducer (Hsieh 2014, Eqs 12-20, corrected), without clearance or elasticity.

Axes: +x right, +y up; the crank angle theta is counter-clockwise, with the gear centre at (0, +c) for theta = 0.
The gear turns by -theta/(N-1); zeta = theta/(N-1) is that turn, clockwise. SI units throughout.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.geometry.profile import CycloidGear


@dataclass(frozen=True)
class CrankLaw:
    """Crank motion: a linear ramp of the speed from rest over `ramp` [s], then the constant `speed` [rad/s].

    `ramp` = 0 means full speed from t = 0; before t = 0 the crank rests at the angle 0.

    Raises
    ------
    DesignError
        If `ramp` is negative, or either value is not finite.
    """

    speed: float
    ramp: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.speed) and math.isfinite(self.ramp) and self.ramp >= 0):
            raise DesignError(
                f"a crank speed of {self.speed} rad/s with a ramp of {self.ramp} s is not allowed: both must be "
                "finite, and the ramp at least 0 s. Correct drive.speed_rpm or drive.ramp_s"
            )

    def angle_at(self, time: npt.ArrayLike) -> Array:
        """Crank angle theta [rad] at `time` [s]."""
        time = np.maximum(time, 0.0)
        if self.ramp == 0:
            return self.speed * time
        ramped = np.minimum(time, self.ramp)
        return self.speed * (ramped**2 / (2 * self.ramp) + (time - ramped))

    def speed_at(self, time: npt.ArrayLike) -> Array:
        """Crank speed omega_i [rad/s] at `time` [s]."""
        time = np.asarray(time, float)
        share = np.clip(time / self.ramp, 0.0, 1.0) if self.ramp > 0 else np.where(time >= 0, 1.0, 0.0)
        return self.speed * share

    def acceleration_at(self, time: npt.ArrayLike) -> Array:
        """Crank acceleration [rad/s^2] at `time` [s]: speed/ramp for 0 <= time < ramp, else 0."""
        time = np.asarray(time, float)
        if self.ramp == 0:
            return np.zeros_like(time)
        return np.where((time >= 0) & (time < self.ramp), self.speed / self.ramp, 0.0)


@dataclass(frozen=True)
class PointPath:
    """Motion of a point of the gear: `position` [m], `velocity` [m/s], `acceleration` [m/s^2], each (..., 2)."""

    position: Array
    velocity: Array
    acceleration: Array


def gear_speed(omega_i: npt.ArrayLike, lobes: int) -> Array:
    """Gear speed omega_c = -omega_i/(N-1) [rad/s], counter-clockwise positive (Eq. 12)."""
    return -np.asarray(omega_i, float) / lobes


def gear_rotation(gear: CycloidGear, crank_angle: npt.ArrayLike) -> Array:
    """Rotation of the gear -theta/(N-1) [rad], counter-clockwise positive."""
    return -np.asarray(crank_angle, float) / gear.lobes


def gear_centre(gear: CycloidGear, crank_angle: npt.ArrayLike) -> Array:
    """Gear centre c (-sin theta, cos theta) from the reducer's axis, shape (..., 2) [m]."""
    return gear.eccentricity * _radial(crank_angle)


def gear_centre_velocity(gear: CycloidGear, crank_angle: npt.ArrayLike, crank_speed: npt.ArrayLike) -> Array:
    """Velocity of the gear centre, of size c omega_i along the tangent, shape (..., 2) [m/s] (Eq. 13 corrected)."""
    return gear.eccentricity * _column(crank_speed) * _tangential(crank_angle)


def gear_centre_acceleration(
    gear: CycloidGear, crank_angle: npt.ArrayLike, crank_speed: npt.ArrayLike, crank_acceleration: npt.ArrayLike = 0.0
) -> Array:
    """Compute the acceleration of the centre of a cycloidal gear (..., 2) [m/s^2] (Hsieh 2014, Eq. 14 corrected).

    It is the sum of c omega_i^2 towards the axis and c domega_i/dt along the tangent, with the eccentricity c. Crank
    angle [rad], speed omega_i [rad/s] and acceleration [rad/s^2] are counter-clockwise and broadcast to the shape
    (...).
    """
    centripetal = -(_column(crank_speed) ** 2) * _radial(crank_angle)
    tangential_acceleration = _column(crank_acceleration) * _tangential(crank_angle)
    return gear.eccentricity * (centripetal + tangential_acceleration)


def point_path(
    gear: CycloidGear,
    q: npt.ArrayLike,
    crank_angle: npt.ArrayLike,
    crank_speed: npt.ArrayLike = 0.0,
    crank_acceleration: npt.ArrayLike = 0.0,
    turning: bool = True,
) -> PointPath:
    """Compute position, velocity and acceleration of a point of the gear (Hsieh 2014, Eqs 16, 17, 19 corrected).

    Parameters
    ----------
    gear, q
        The mesh, and the point (q_x, q_y) in the gear's frame [m].
    crank_angle, crank_speed, crank_acceleration
        Motion of the crank [rad], [rad/s], [rad/s^2], counter-clockwise; they broadcast to the shape (...).
    turning
        Whether the gear rotates. If not, as its carrier is fixed, all its points move on circles whose radius is the
        eccentricity.

    Returns
    -------
    PointPath
        Vectors of shape (..., 2). The origin is that of Eq. 16, the *initial* gear centre: add (0, eccentricity) for
        positions from the reducer's axis.
    """
    theta, speed, acceleration = np.broadcast_arrays(crank_angle, crank_speed, crank_acceleration)
    if not turning:
        return PointPath(
            position=gear_centre(gear, theta) - gear_centre(gear, 0.0) + np.asarray(q, float),
            velocity=gear_centre_velocity(gear, theta, speed),
            acceleration=gear_centre_acceleration(gear, theta, speed, acceleration),
        )
    zeta, zeta_dot, zeta_ddot = theta / gear.lobes, _column(speed) / gear.lobes, _column(acceleration) / gear.lobes
    q_x, q_y = np.asarray(q, float)
    rotated_q = np.stack([q_x * np.cos(zeta) + q_y * np.sin(zeta), q_y * np.cos(zeta) - q_x * np.sin(zeta)], axis=-1)
    turned_by_zeta = np.stack([rotated_q[..., 1], -rotated_q[..., 0]], axis=-1)

    arm = gear.eccentricity * gear.lobes
    first_derivative = arm * _tangential(theta) + turned_by_zeta
    second_derivative = -arm * gear.lobes * _radial(theta) - rotated_q
    return PointPath(
        position=gear_centre(gear, theta) - gear_centre(gear, 0.0) + rotated_q,
        velocity=zeta_dot * first_derivative,
        acceleration=zeta_dot**2 * second_derivative + zeta_ddot * first_derivative,
    )


def point_motion(q: npt.ArrayLike, pose: Array, motion: Array) -> tuple[Array, Array]:
    """Compute position p + R q and velocity dp/dt + w x R q of a point q of a body.

    q is fixed to the body. p is the position of the body, R its rotation matrix and w its angular speed, at n instants.

    Parameters
    ----------
    q
        The point (q_x, q_y) [m] in the body's frame.
    pose
        x, y [m] and counter-clockwise rotation [rad] of the body, shape (n, 3).
    motion
        Derivatives of the pose with respect to time, [m/s] and [rad/s], shape (n, 3).

    Returns
    -------
    tuple of Array
        Position [m] and velocity [m/s], shape (n, 2) each.
    """
    (q_x, q_y), cos, sin = np.asarray(q, float), np.cos(pose[:, 2]), np.sin(pose[:, 2])
    arm_x, arm_y, angular_speed = q_x * cos - q_y * sin, q_x * sin + q_y * cos, motion[:, 2:]
    position = pose[:, :2] + np.stack([arm_x, arm_y], axis=1)
    return position, motion[:, :2] + angular_speed * np.stack([-arm_y, arm_x], axis=1)


def point_speed(gear: CycloidGear, q: npt.ArrayLike, crank_angle: npt.ArrayLike, crank_speed: npt.ArrayLike) -> Array:
    """Compute the speed of a point `q` of the gear (...) [m/s] (Hsieh 2014, Eq. 18).

    |dzeta/dt| sqrt(c^2 (N-1)^2 + q^2 + 2 c (N-1) (q_x sin N zeta - q_y cos N zeta)). Parameters as in `point_path`.
    """
    return np.abs(np.asarray(crank_speed, float)) / gear.lobes * np.sqrt(_slope_squared(gear, q, crank_angle))


def point_acceleration(
    gear: CycloidGear,
    q: npt.ArrayLike,
    crank_angle: npt.ArrayLike,
    crank_speed: npt.ArrayLike,
    crank_acceleration: npt.ArrayLike = 0.0,
) -> Array:
    """Compute the magnitude of the acceleration (...) [m/s^2] of a point q of the gear (Hsieh 2014, Eq. 20 corrected).

    `q` is (q_x, q_y) [m] in the frame of the gear. `crank_angle` [rad], `crank_speed` [rad/s] and `crank_acceleration`
    [rad/s2] have any common shape (...).

    Notes
    -----
    With derivatives r', r'' of the position by zeta, the crank angle over N - 1: |r'' (dzeta/dt)^2 + r' d2zeta/dt2|,
    where |r''|^2 = c^2 (N-1)^4 + |q|^2 + 2 c (N-1)^2 (q_y cos N zeta - q_x sin N zeta), |r'| is that of Eq. 18, and
    r' . r'' = c N (N-1) (q_x cos N zeta + q_y sin N zeta), with N ring teeth and the eccentricity c.
    """
    N, c = gear.ring_teeth, gear.eccentricity
    q_x, q_y = np.asarray(q, float)
    n_zeta = N * np.asarray(crank_angle, float) / (N - 1)
    zeta_dot, zeta_ddot = np.asarray(crank_speed, float) / (N - 1), np.asarray(crank_acceleration, float) / (N - 1)
    turn_term = (
        c**2 * (N - 1) ** 4 + q_x**2 + q_y**2 + 2 * c * (N - 1) ** 2 * (q_y * np.cos(n_zeta) - q_x * np.sin(n_zeta))
    )
    mixed_term = c * N * (N - 1) * (q_x * np.cos(n_zeta) + q_y * np.sin(n_zeta))
    squared_slope = _slope_squared(gear, q, crank_angle)
    return np.sqrt(turn_term * zeta_dot**4 + 2 * mixed_term * zeta_dot**2 * zeta_ddot + squared_slope * zeta_ddot**2)


def _slope_squared(gear: CycloidGear, q: npt.ArrayLike, crank_angle: npt.ArrayLike) -> Array:
    """Compute |dr/dzeta|^2 [m^2]: r is the position of the point `q`, zeta the crank angle over N - 1, as in Eq. 18."""
    N, c = gear.ring_teeth, gear.eccentricity
    q_x, q_y = np.asarray(q, float)
    turn = N * np.asarray(crank_angle, float) / (N - 1)
    square = c**2 * (N - 1) ** 2 + q_x**2 + q_y**2 + 2 * c * (N - 1) * (q_x * np.sin(turn) - q_y * np.cos(turn))
    return np.maximum(square, 0.0)


def _radial(angle: npt.ArrayLike) -> Array:
    """Return unit vectors at counter-clockwise angles from +y, (..., 2)."""
    return np.stack([-np.sin(angle), np.cos(angle)], axis=-1)


def _tangential(angle: npt.ArrayLike) -> Array:
    """Differentiate `_radial` by the angle, (..., 2)."""
    return np.stack([-np.cos(angle), -np.sin(angle)], axis=-1)


def _column(values: npt.ArrayLike) -> Array:
    """Add a last axis, so that the values scale vectors."""
    return np.asarray(values, float)[..., np.newaxis]
