"""Kinematics and assembly of an RV reducer in closed form: speeds, orders, planets that mesh, discs that are one part.

Symbols: z_s teeth of the sun, z_p of a planet, N ring pins, k = N minus the lobes of a disc, n cranks. The discs turn
with the carrier. Angles are counter-clockwise; s, c, r and psi are those of sun, carrier, ring and cranks, all against
the ground. The planet mesh requires (psi - c) = -z_s/z_p (s - c), the pin mesh (N - k) (c - psi) = N (r - psi).
"""

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property


@dataclass(frozen=True)
class RvKinematics:
    """Speeds of an RV reducer: s = R c - (R - 1) r with R = 1 + N z_p/(k z_s).

    Attributes
    ----------
    sun_teeth, planet_teeth
        z_s and z_p.
    pins, lobes
        N ring pins, and lobes of a disc.
    turns_ring
        Whether the ring is the output and the carrier is fixed; otherwise the ring is fixed.
    """

    sun_teeth: int
    planet_teeth: int
    pins: int
    lobes: int
    turns_ring: bool = False

    @cached_property
    def to_carrier(self) -> Fraction:
        """Turns of the sun per turn of the carrier, both against the ring: R."""
        return 1 + Fraction(self.pins * self.planet_teeth, (self.pins - self.lobes) * self.sun_teeth)

    @property
    def ratio(self) -> Fraction:
        """Turns of the sun per turn of the output: R, or 1 - R if the ring is the output."""
        return 1 - self.to_carrier if self.turns_ring else self.to_carrier

    @property
    def share(self) -> float:
        """Torque on the carrier, seen from the ring, per torque on the output without losses: 1, or R/(R - 1)."""
        return float(self.to_carrier / (self.to_carrier - 1)) if self.turns_ring else 1.0

    @property
    def crank_per_carrier(self) -> Fraction:
        """Turns of a crank per turn of the carrier, both against the ring: -(N - k)/k."""
        return Fraction(-self.lobes, self.pins - self.lobes)

    @property
    def bearing_turns(self) -> Fraction:
        """Turns of every crank bearing per turn of the output, in the discs and in the carrier: N/k."""
        return Fraction(self.pins, self.pins - self.lobes)

    @property
    def crank_per_sun(self) -> Fraction:
        """Turns of a crank against the ring per turn of the sun against the ring: -(N - k)/(k R)."""
        return self.crank_per_carrier / self.to_carrier

    @property
    def orders(self) -> dict[str, Fraction]:
        """Return the orders of periodic errors, in cycles per turn of the output, by the source of the error.

        The keys "crank against the ring" and "crank against the carrier", and likewise those of the sun, count turns of
        this shaft relative to ring or carrier. "planet mesh" and "pin mesh" count pairs of teeth that pass each other.
        "output" has the order 1.
        """
        turns_against_ring, turns_against_carrier = abs(self.crank_per_carrier), self.bearing_turns
        return {
            "output": Fraction(1),
            "sun against the ring": self.to_carrier,
            "sun against the carrier": self.to_carrier - 1,
            "crank against the ring": turns_against_ring,
            "crank against the carrier": turns_against_carrier,
            "planet mesh": turns_against_carrier * self.planet_teeth,
            "pin mesh": turns_against_ring * self.pins,
        }


def planet_misfit(sun_teeth: int, planet_teeth: int, count: int) -> Fraction:
    """Compute the largest misalignment of the teeth of identical planets at equal angles [pitches]; 0 if all mesh.

    Planet i has to be rotated on its crank by the fractional part of i (z_s + z_p)/n pitches, because there is no ring
    gear. z_s are the teeth of the sun, z_p those of a planet, and n is the `count` of planets. All mesh if n divides
    z_s + z_p.
    """
    pitch_fractions = [Fraction(planet * (sun_teeth + planet_teeth), count) % 1 for planet in range(count)]
    return max(min(fraction, 1 - fraction) for fraction in pitch_fractions)


def meshing_planet_teeth(sun_teeth: int, planet_teeth: int, count: int) -> tuple[int, ...]:
    """Return two tooth numbers of planets that mesh, just below and just above `planet_teeth`, the nearest first.

    `sun_teeth` is the number of teeth of the sun, `count` the number of identical planets. If both are at the same
    distance, the larger number comes first.
    """
    changes = [
        next(change for change in range(1, count + 1) if (sun_teeth + planet_teeth + sign * change) % count == 0) * sign
        for sign in (1, -1)
    ]
    return tuple(planet_teeth + change for change in sorted(changes, key=lambda change: (abs(change), -change)))


def disc_clocking(pins: int, lobes: int, discs: int, disc: int) -> Fraction:
    """Return by how much the lobes of a disc are turned against its crank bores [lobe pitches], from 0 to 1."""
    return Fraction(-(pins - lobes) * disc, discs) % 1


def are_one_part(pins: int, lobes: int, discs: int, cranks: int) -> bool:
    """Return whether all discs are identical parts, which differ only by a rotation by steps of their crank bores.

    A rotation by j steps moves the lobes against the bores by j lobes/n pitches, with n = `cranks`.
    """
    steps = [Fraction(lobes * step, cranks) % 1 for step in range(cranks)]
    return all(disc_clocking(pins, lobes, discs, disc) in steps for disc in range(discs))


def flip_clockings(pins: int, lobes: int, cranks: int) -> tuple[Fraction, ...]:
    """Return the angles between lobes and crank bores for which disc 2 is disc 1 turned over [lobe pitches].

    With these angles, both discs of a drive are identical parts. An angle q leads from the axis of a lobe to bore 1;
    the result contains all solutions from 0 to 1 in increasing order. Turning a disc over about the axis through bore 1
    changes the sign of q. With k = pins - lobes and n = `cranks` bores, q has to solve -q + j lobes/n =
    q + k/2 (modulo 1) for a whole number j.
    """
    required_clocking = disc_clocking(pins, lobes, 2, 1)
    doubled_angles = {(Fraction(lobes * bore_index, cranks) - required_clocking) % 1 for bore_index in range(cranks)}
    return tuple(
        sorted({(doubled / 2 + half_pitch) % 1 for doubled in doubled_angles for half_pitch in (0, Fraction(1, 2))})
    )


def dead_points(cranks: int, discs: int) -> bool:
    """Return whether all cranks pass dead points together, which is so for two cranks and a single disc.

    At a dead point the eccentrics line up, and the disc cannot turn the cranks against each other, so only the planets
    keep them in phase.
    """
    return cranks == 2 and discs == 1


def mesh_stiffness(sun_teeth: int, planet_teeth: int, pressure_angle: float, face_width: float) -> float:
    """Compute the mean mesh stiffness of spur gears of steel along the line of action [N/m].

    ISO 6336-1:2006, method B: c' = 0.8/q' with equation (82) for q' without profile shift, and c_gamma = c' (0.75
    epsilon_alpha + 0.25), equation (89). The contact ratio assumes full-depth teeth (addendum = module).

    Parameters
    ----------
    sun_teeth, planet_teeth
        Numbers of teeth.
    pressure_angle
        At the pitch circle [rad].
    face_width
        Common face width [m].
    """
    flexibility = 0.04723 + 0.15551 / sun_teeth + 0.25791 / planet_teeth
    single_stiffness = 0.8 / flexibility * 1e9
    return single_stiffness * (0.75 * contact_ratio(sun_teeth, planet_teeth, pressure_angle) + 0.25) * face_width


def contact_ratio(sun_teeth: int, planet_teeth: int, pressure_angle: float) -> float:
    """Compute the transverse contact ratio of full-depth spur gears [1]; the pressure angle is in [rad]."""
    return sum(_tip_contact_ratios(sun_teeth, planet_teeth, pressure_angle))


def mesh_loss_factor(sun_teeth: int, planet_teeth: int, pressure_angle: float) -> float:
    """Compute the loss factor H_v of a spur gear mesh [1]: the power loss is H_v mu times the transmitted power.

    ISO/TR 14179-2, equation (31): pi (u + 1)/(z_1 u) (1 - epsilon_alpha + epsilon_1^2 + epsilon_2^2), for full-depth
    teeth. z_1 = `sun_teeth`, u is the ratio of tooth numbers `planet_teeth`/z_1, epsilon_1 and epsilon_2 are the
    contact ratios of the tips, epsilon_alpha is their sum, and mu is the friction coefficient; the pressure angle is in
    [rad].
    """
    gear_ratio = planet_teeth / sun_teeth
    tip_contact_ratios = _tip_contact_ratios(sun_teeth, planet_teeth, pressure_angle)
    contact_factor = 1.0 - sum(tip_contact_ratios) + sum(ratio_of_tip**2 for ratio_of_tip in tip_contact_ratios)
    return math.pi * (gear_ratio + 1.0) / (sun_teeth * gear_ratio) * contact_factor


def _tip_contact_ratios(sun_teeth: int, planet_teeth: int, pressure_angle: float) -> tuple[float, float]:
    """Compute the contact ratios of the tips of sun and planet, counted from the pitch point.

    The arguments are the numbers of teeth of sun and planet, and the pressure angle [rad].

    Returns
    -------
    tuple of float
        Ratios of sun and planet [1].
    """

    def tip_contact_ratio(teeth: int) -> float:
        """Compute the contact ratio of the tip of a gear with some `teeth` [1]."""
        tip_angle = math.acos(teeth * math.cos(pressure_angle) / (teeth + 2.0))
        return teeth * (math.tan(tip_angle) - math.tan(pressure_angle)) / (2.0 * math.pi)

    return tip_contact_ratio(sun_teeth), tip_contact_ratio(planet_teeth)
