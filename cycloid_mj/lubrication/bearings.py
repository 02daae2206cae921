"""Friction torques of rolling bearings (Palmgren) and radial shaft seals (ISO/TR 14179-2)."""

from cycloid_mj.base.units import MILLIMETRES, RPM

SEAL_POWER = 7.69e-6
"""Power of a radial shaft seal over d^2 n [W/(mm2/min)] (ISO/TR 14179-2)."""

MIN_VISCOUS = 2000.0
"""Viscosity times speed [mm2/s/min] below which M0 is constant."""


def idle_torque(factor: float, diameter: float, speed: float, viscosity: float) -> float:
    """Compute Palmgren's load-independent friction torque M0 of a rolling bearing [N m].

    `factor` is f0 [1], `diameter` the mean diameter [m], `speed` the speed of one ring relative to the other [rad/s],
    and `viscosity` the kinematic viscosity [mm2/s].
    """
    viscosity_speed = max(viscosity * abs(speed) / RPM, MIN_VISCOUS)
    torque_per_volume = 160e-7 if viscosity_speed == MIN_VISCOUS else 1e-7 * viscosity_speed ** (2.0 / 3.0)
    return 1e-3 * torque_per_volume * factor * (MILLIMETRES * diameter) ** 3


def seal_torque(diameter: float) -> float:
    """Compute the friction torque [N m] of a radial seal on a shaft diameter [m]; it does not depend on speed."""
    return SEAL_POWER * (MILLIMETRES * diameter) ** 2 / RPM
