"""Strength of joints by the formulas of their standards: screws, press fits, keys, dowels, inserts and glue.

Sources: VDI 2230-1:2015 (R: its equations), DIN 7190-1:2017, DIN 6885-1 with DIN 6892:2012 (method C), and for pins
Roloff/Matek, Maschinenelemente, 24th ed., and EN 1995-1-1:2004, 8.2 (Johansen). All values are in SI; strengths are
those of the weaker part.
"""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class JointStrengthSettings:
    """Assumed frictions and strengths of joints, with their sources."""

    interface_friction: float = 0.15
    interface_friction_spread: tuple[float, float] = (0.10, 0.20)
    """Friction of clamped faces and press fits, and its range, degreased to dry (VDI 2230, A6)."""
    thread_friction: float = 0.12
    thread_friction_spread: tuple[float, float] = (0.10, 0.16)
    """Friction of threads and heads, and its range, oiled to plain (VDI 2230, A5, classes A and B)."""
    utilisation: float = 0.7
    """Preload over the yield force of the stress area: what a torque wrench reaches without yield, with its scatter."""
    dowel_shear: float = 896e6
    """Shear strength of hardened dowels [Pa], 130 000 psi (ASME B18.8.2)."""
    glue_strength: float = 25e6
    """Shear strength of an anaerobic retaining compound on steel at 23 °C [Pa] (ISO 10123)."""
    plastic_glue_strength: float = 3e6
    """Shear strength of two-part epoxy on plastics at 23 °C [Pa] (lowest of 3 to 12 MPa, kraska.biz, bonding of small
    plastic parts); anaerobic compounds need ions of a metal to cure, and can crack thermoplastics."""
    metal_shear: float = 0.6
    plastic_shear: float = 1.0 / math.sqrt(3.0)
    """Shear over tensile strength of metals (VDI 2230, 5.5.5: 0.60 to 0.70), over yield strength of plastics."""
    plastic_preload: float = 0.5
    """Share of the force that threads and faces of a plastic withstand once, which they keep as a preload (assumed)."""
    pin_roughness: float = 2e-6
    hole_roughness: float = 4e-6
    """Mean depths Rz of ground pins and reamed holes [m] (ISO 8734 has Ra 0.8 um at most; Rz assumed)."""
    spline_share: float = 0.75
    """Share of the flanks of a spline that carry, with a hub centred on the minor diameter (Roloff/Matek 12.8)."""
    wall_ratio: float = 2.0
    """Outside diameter of the wall around a pressed-in pin over that of the pin (assumed)."""
    shrink_difference: float = 278.5
    """Largest temperature difference of hub and shaft in a shrink fit [K]: 200 °C, which case-hardened steel
    withstands (DIN 7190-1), and dry ice at -78.5 °C."""


JOINTS = JointStrengthSettings()

PROOF_STRESS = {"8.8": 640e6, "10.9": 940e6, "12.9": 1100e6}
"""ISO 898-1:2013, table 3: property class -> stress at 0.2 % [Pa]; 640 MPa up to M16."""


@dataclass(frozen=True)
class Thread:
    """A metric thread of a screw: nominal diameter and pitch [m]."""

    diameter: float
    pitch: float

    @property
    def pitch_diameter(self) -> float:
        """Pitch diameter d2 [m] (ISO 724)."""
        return self.diameter - 0.75 * math.sqrt(0.75) * self.pitch

    @property
    def stress_area(self) -> float:
        """Stress area A_s [m2] (ISO 898-1)."""
        return 0.25 * math.pi * self._stress_diameter**2

    @property
    def _stress_diameter(self) -> float:
        core_diameter = self.diameter - 17.0 / 12.0 * math.sqrt(0.75) * self.pitch
        return 0.5 * (self.pitch_diameter + core_diameter)

    def largest_preload(
        self, proof: float, friction: float = JOINTS.thread_friction, utilisation: float = 0.9
    ) -> float:
        """Compute the largest assembly preload [N] at a proof stress [Pa], with torsion of the shank (R8/1)."""
        slope = self.pitch / (math.pi * self.pitch_diameter) + 1.155 * friction
        torsion_ratio = 1.5 * self.pitch_diameter / self._stress_diameter * slope
        return self.stress_area * utilisation * proof / math.sqrt(1.0 + 3.0 * torsion_ratio**2)

    def usual_preload(self, proof: float) -> float:
        """Compute the preload [N] of `JointStrengthSettings.utilisation`."""
        return JOINTS.utilisation * proof * self.stress_area

    def tightening_torque(self, preload: float, head: float, friction: float = JOINTS.thread_friction) -> float:
        """Compute the tightening torque [N m] of a preload [N]; `head` is the mean diameter under the head (R13)."""
        lever = 0.16 * self.pitch + friction * (0.58 * self.pitch_diameter + 0.5 * head)
        return preload * lever

    def stripping_force(self, engaged_length: float, shear: float) -> float:
        """Compute the force [N] that strips an internal thread over an engaged length [m].

        VDI 2230 (2015) 5.5.5, without the factors C1 to C3. `shear` is the shear strength of the nut's material [Pa];
        0.8 of a pitch does not carry.
        """
        width_per_pitch = 0.5 * self.pitch + (self.diameter - self.pitch_diameter) / math.sqrt(3.0)
        engaged_turns = max(engaged_length / self.pitch - 0.8, 0.0)
        return shear * math.pi * self.diameter * engaged_turns * width_per_pitch


def head_pressure(preload: float, bearing: float, hole: float) -> float:
    """Compute the pressure under a head [Pa]; diameters of its bearing face and of the hole [m] (R10/1)."""
    return preload / (0.25 * math.pi * (bearing**2 - hole**2))


def washer_bearing(head: float, thickness: float, outside: float) -> float:
    """Return the effective diameter under a washer [m]: d_wa = d_w + 1.6 h, at most its outside (VDI 2230, 5.5.4)."""
    return min(head + 1.6 * thickness, outside)


def friction_torque(screws: int, preload: float, radius: float, friction: float = JOINTS.interface_friction) -> float:
    """Compute the torque [N m] at which a face clamped by screws on a circle [m] slips (R2/2)."""
    return screws * preload * friction * radius


def pull_out_force(diameter: float, length: float, shear: float) -> float:
    """Compute the force [N] that pulls an insert out: shear of the plastic on its cylinder [m]."""
    return math.pi * diameter * length * shear


def glued_force(diameter: float, length: float, on_plastic: bool = False) -> float:
    """Compute the force [N] that a glued cylindrical joint transmits along its surface.

    `diameter` and `length` are in [m]. The adhesive is a retaining compound, or with a part of plastic an epoxy.
    """
    return math.pi * diameter * length * (JOINTS.plastic_glue_strength if on_plastic else JOINTS.glue_strength)


def dowel_force(diameter: float, depth: float, yield_strength: float, shear: float = JOINTS.dowel_shear) -> float:
    """Compute the force [N] that a dowel transmits: shear of its section, or yield of a hole of some depth [m].

    Roloff/Matek 9.15 and 9.16: tau = F/A, p = F/(d s).
    """
    return min(0.25 * math.pi * diameter**2 * shear, diameter * depth * yield_strength)


def tilting_dowel_force(
    diameter: float,
    depths: tuple[float, float],
    yield_strengths: tuple[float, float],
    shear: float = JOINTS.dowel_shear,
) -> float:
    """Compute the force [N] at which a stiff dowel across the face of two soft parts shears, or tilts in both holes.

    The holes have `depths` [m] in both parts and yield at the `yield_strengths` [Pa] of these: Johansen's limit load,
    EN 1995-1-1, 8.6 (a) to (c), without friction. For equal holes of the depth s it is 0.414 d s R_e. `diameter` d
    [m] is that of the dowel, and `shear` [Pa] its shear strength.
    """
    (depth, other_depth), (strength, other_strength) = depths, yield_strengths
    depth_ratio, strength_ratio = other_depth / depth, other_strength / strength
    root = (
        strength_ratio
        + 2.0 * strength_ratio**2 * (1.0 + depth_ratio + depth_ratio**2)
        + strength_ratio**3 * depth_ratio**2
    )
    tilting_share = (math.sqrt(root) - strength_ratio * (1.0 + depth_ratio)) / (1.0 + strength_ratio)
    hole_forces = (dowel_force(diameter, *hole, shear) for hole in zip(depths, yield_strengths, strict=True))
    return min(*hole_forces, diameter * depth * strength * tilting_share)


def clamped_pin_pressure(force: float, moment: float, diameter: float, depth: float) -> float:
    """Compute the largest pressure [Pa] in the hole of a pin that bends in it (Roloff/Matek 9.19).

    `moment` is that at the mouth of the hole [N m]: p = F/(d s) + 6 (M + F s/2)/(d s^2) = F (6 h + 4 s)/(d s^2).
    """
    return (force + 6.0 * (moment + 0.5 * force * depth) / depth) / (diameter * depth)


@dataclass(frozen=True)
class PressFit:
    """A cylindrical press fit, elastic (DIN 7190-1).

    Attributes
    ----------
    diameter, length
        Diameter and length of the joint [m].
    outside, bore
        Outside diameter of the hub, and bore of the shaft [m].
    hub, shaft
        Young's modulus [Pa] and Poisson's ratio of both.
    """

    diameter: float
    length: float
    outside: float
    hub: tuple[float, float]
    shaft: tuple[float, float]
    bore: float = 0.0

    def pressure(self, interference: float) -> float:
        """Compute the joint pressure [Pa] of an effective interference in diameter [m]; 0 for a clearance (Lame)."""
        squared_hub_ratio, squared_bore_ratio = (self.diameter / self.outside) ** 2, (self.bore / self.diameter) ** 2
        (hub_modulus, hub_poisson), (shaft_modulus, shaft_poisson) = self.hub, self.shaft
        compliance = ((1.0 + squared_hub_ratio) / (1.0 - squared_hub_ratio) + hub_poisson) / hub_modulus
        compliance += ((1.0 + squared_bore_ratio) / (1.0 - squared_bore_ratio) - shaft_poisson) / shaft_modulus
        return max(interference, 0.0) / (self.diameter * compliance)

    def yield_pressure(self, yield_strength: float) -> float:
        """Compute the pressure [Pa] at which the bore of the hub yields: (1 - Q^2) R_e/sqrt(3)."""
        return (1.0 - (self.diameter / self.outside) ** 2) * yield_strength / math.sqrt(3.0)

    def shaft_yield_pressure(self, yield_strength: float) -> float:
        """Compute the pressure [Pa] at which the shaft yields: 2 R_e/sqrt(3), with a bore (1 - Q^2) R_e/sqrt(3)."""
        factor = 1.0 - (self.bore / self.diameter) ** 2 if self.bore else 2.0
        return factor * yield_strength / math.sqrt(3.0)

    def growth(self, pressure: float) -> float:
        """Compute by how much the outside diameter of the hub grows [m] under a joint pressure [Pa] (Lame)."""
        squared_ratio, (modulus, _) = (self.diameter / self.outside) ** 2, self.hub
        return 2.0 * pressure * squared_ratio / (1.0 - squared_ratio) * self.outside / modulus

    def force(self, pressure: float, friction: float = JOINTS.interface_friction) -> float:
        """Compute the axial force [N] that a joint pressure [Pa] transmits."""
        return friction * pressure * math.pi * self.diameter * self.length

    def torque(self, pressure: float, friction: float = JOINTS.interface_friction) -> float:
        """Compute the torque [N m] that a joint pressure [Pa] transmits."""
        return 0.5 * self.diameter * self.force(pressure, friction)


def effective_interference(measured: float, roughness_hub: float, roughness_shaft: float) -> float:
    """Return the interference [m] that is left when the peaks of both surfaces (Rz [m]) are smoothed (DIN 7190-1)."""
    return measured - 0.8 * (roughness_hub + roughness_shaft)


def shrink_difference(diameter: float, interference: float, expansion: float) -> float:
    """Compute the temperature difference [K] to join a shrink fit, with a play of 0.1 % of its diameter (DIN 7190-1).

    `diameter` and the largest `interference` are in [m], the linear `expansion` in [1/K].
    """
    return (interference + 1e-3 * diameter) / (expansion * diameter)


@dataclass(frozen=True)
class StraightSpline:
    """A straight-sided spline of ISO 14 in a hub: number of splines, diameters and length of the hub [m].

    Attributes
    ----------
    count
        Number of splines.
    minor, major
        Minor diameter, on which the hub is centred, and major diameter.
    length
        Length of the hub.
    """

    count: int
    minor: float
    major: float
    length: float

    @property
    def flank_height(self) -> float:
        """Height of the flanks that carry, without chamfers: 0.4 (D - d) [m] (Roloff/Matek, table 12-3)."""
        return 0.4 * (self.major - self.minor)

    def pressure(self, torque: float) -> float:
        """Compute the pressure on the flanks [Pa] of a torque [N m]; three quarters of the flanks carry.

        p = 2 T/(d_m h l 0.75 n), d_m = (D + d)/2, for a hub that is centred on the minor diameter (Roloff/Matek 12.8).
        """
        mean_diameter = 0.5 * (self.major + self.minor)
        return 2.0 * torque / (mean_diameter * self.flank_height * self.length * JOINTS.spline_share * self.count)

    def torque(self, yield_strength: float) -> float:
        """Compute the torque [N m] at which the flanks of the weakest part yield [Pa]."""
        return yield_strength / self.pressure(1.0)


@dataclass(frozen=True)
class SlottedHub:
    """A hub with one slot that screws across the slot clamp on a shaft, as a lever about its closed side.

    Attributes
    ----------
    diameter
        Diameter of the shaft [m].
    screw_arm, shaft_arm
        Distances of the screws and of the shaft's axis from the middle of the wall opposite to the slot [m].
    wall, width
        Thickness of this wall, and width of the hub along the axis [m].
    youngs_modulus
        Young's modulus of the hub [Pa].
    """

    diameter: float
    screw_arm: float
    shaft_arm: float
    wall: float
    width: float
    youngs_modulus: float

    def closing_moment(self, clearance: float) -> float:
        """Compute the moment in the wall [N m] that closes a clearance in diameter [m].

        An open ring with the mean radius R of the wall bends until its curvature suits the smaller radius R - c/2, c
        being the clearance: M = E I c/(2 R^2), with the bending stiffness E I of the wall.
        """
        stiffness = self.youngs_modulus * self.width * self.wall**3 / 12.0
        return stiffness * max(clearance, 0.0) / (2.0 * self.shaft_arm**2)

    def torque(self, force: float, clearance: float = 0.0, friction: float = JOINTS.interface_friction) -> float:
        """Compute the torque [N m] at which the hub slips, at the force F of all screws [N].

        The halves press on the shaft along two opposite lines, each with the force N = (F l1 - M)/l2, where l1 is
        `screw_arm`, l2 `shaft_arm` and M the `closing_moment` at the `clearance` in diameter [m]. The torque is mu N d
        with the coefficient of `friction` mu and the `diameter` d (Roloff/Matek 12.3.4). An even pressure would
        transmit pi/2 times as much.
        """
        normal_force = max(force * self.screw_arm - self.closing_moment(clearance), 0.0) / self.shaft_arm
        return friction * normal_force * self.diameter


@dataclass(frozen=True)
class ParallelKey:
    """A parallel key of DIN 6885-1: height, depth in the shaft and carrying length, without round ends [m]."""

    height: float
    depth: float
    carrying_length: float

    def pressure(self, torque: float, shaft: float) -> float:
        """Compute the side pressure in the hub [Pa] of a torque [N m] on a shaft diameter [m] (DIN 6892, method C)."""
        return 2.0 * torque / (shaft * (self.height - self.depth) * self.carrying_length)

    def torque(self, shaft: float, yield_strength: float) -> float:
        """Compute the torque [N m] at 0.9 of the yield strength of the weakest part [Pa] (DIN 6892, method C)."""
        return 0.9 * yield_strength / self.pressure(1.0, shaft)
