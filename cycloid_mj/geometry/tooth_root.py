"""Stress at the roots of spur gear teeth by ISO 6336-3:2019, method B: form factor and stress correction factor."""

import math
from dataclasses import dataclass

from cycloid_mj.geometry.involute import CORNER_RADIUS, DEDENDUM, InvoluteGear, involute

TANGENT_ANGLE = math.pi / 3.0
"""Constant T of the standard for external gears, for tangents at 30 deg."""


@dataclass(frozen=True)
class ToothRoot:
    """Critical section of a tooth, where the tangents of the fillets are at 30 deg to its axis.

    Attributes
    ----------
    chord
        Thickness of the tooth there, over the module: s_Fn.
    arm
        Bending arm of the force at the outer point of single contact, over the module: h_Fe.
    radius
        Radius of curvature of the fillet there, over the module: rho_F.
    force_angle
        Angle of that force to the perpendicular of the tooth's axis [rad]: alpha_Fen.
    pressure_angle
        At the reference circle [rad].
    """

    chord: float
    arm: float
    radius: float
    force_angle: float
    pressure_angle: float

    @property
    def form_factor(self) -> float:
        """Form factor Y_F."""
        return 6.0 * self.arm * math.cos(self.force_angle) / (self.chord**2 * math.cos(self.pressure_angle))

    @property
    def correction_factor(self) -> float:
        """Stress correction factor Y_S, which the standard states for a notch parameter q_s of 1 to 8."""
        slenderness = self.chord / self.arm
        notch = self.chord / (2.0 * self.radius)
        return float((1.2 + 0.13 * slenderness) * notch ** (1.0 / (1.21 + 2.3 / slenderness)))


def contact_ratio(gear: InvoluteGear, mate: InvoluteGear, centre_distance: float) -> float:
    """Compute the transverse contact ratio of two gears at a distance of their axes [m]."""
    base_radii = gear.base_radius + mate.base_radius
    along = sum(math.sqrt(item.tip_radius**2 - item.base_radius**2) for item in (gear, mate))
    path = along - math.sqrt(centre_distance**2 - base_radii**2)
    return path / (2.0 * math.pi * gear.base_radius / gear.teeth)


def tooth_root(gear: InvoluteGear, mate: InvoluteGear, centre_distance: float) -> ToothRoot:
    """Compute thickness, fillet radius, bending arm and force angle at the critical section of a gear tooth's root.

    Lengths in the result are relative to the module [1]. The tooth of `gear` is loaded at the outer point of single
    contact with its `mate`. `centre_distance` is the distance of the axes [m]. In the code, `auxiliary_e`,
    `auxiliary_g` and `auxiliary_h` are the values E (over the module), G and H of ISO 6336-3, and `tangent_angle` is
    its theta [rad]. The rack is profile A of ISO 53. Thinning for backlash is included as a smaller profile shift.
    """
    tooth_count, angle = gear.teeth, gear.pressure_angle
    shift = gear.shift - gear.thinning / (2.0 * gear.module * math.tan(angle))
    auxiliary_e = math.pi / 4.0 - DEDENDUM * math.tan(angle) - (1.0 - math.sin(angle)) * CORNER_RADIUS / math.cos(angle)
    auxiliary_g = CORNER_RADIUS - DEDENDUM + shift
    auxiliary_h = 2.0 / tooth_count * (math.pi / 2.0 - auxiliary_e) - TANGENT_ANGLE
    tangent_angle = _solve_tangent(2.0 * auxiliary_g / tooth_count, auxiliary_h)
    chord = tooth_count * math.sin(TANGENT_ANGLE - tangent_angle) + math.sqrt(3.0) * (
        auxiliary_g / math.cos(tangent_angle) - CORNER_RADIUS
    )
    radius = CORNER_RADIUS + 2.0 * auxiliary_g**2 / (
        math.cos(tangent_angle) * (tooth_count * math.cos(tangent_angle) ** 2 - 2.0 * auxiliary_g)
    )
    base_pitch = 2.0 * math.pi * gear.base_radius / tooth_count
    overlap = (contact_ratio(gear, mate, centre_distance) - 1.0) * base_pitch
    tangent_length = math.sqrt(gear.tip_radius**2 - gear.base_radius**2) - overlap
    load_radius = math.hypot(tangent_length, gear.base_radius)
    load_pressure_angle = math.atan2(tangent_length, gear.base_radius)
    half_thickness = (math.pi / 2.0 + 2.0 * math.tan(angle) * shift) / tooth_count
    gamma = half_thickness + involute(angle) - involute(load_pressure_angle)
    force_angle = load_pressure_angle - gamma
    arm = 0.5 * (
        (math.cos(gamma) - math.sin(gamma) * math.tan(force_angle)) * 2.0 * load_radius / gear.module
        - tooth_count * math.cos(TANGENT_ANGLE - tangent_angle)
        - auxiliary_g / math.cos(tangent_angle)
        + CORNER_RADIUS
    )
    return ToothRoot(chord, arm, radius, force_angle, angle)


def _solve_tangent(factor: float, offset: float) -> float:
    """Solve theta = factor tan(theta) - offset for the angle theta [rad] by Newton's method, from 30 deg."""
    theta = math.pi / 6.0
    for _ in range(20):
        slope = 1.0 - factor / math.cos(theta) ** 2
        theta -= (theta - factor * math.tan(theta) + offset) / slope
    return theta
