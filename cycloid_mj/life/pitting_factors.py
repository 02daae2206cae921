"""Influence of the lubricant film on pitting: factors Z_L, Z_v and Z_R of ISO 6336-2:2006, section 12.

They multiply the allowed contact pressure of a gear. ISO 6336-2 has them for involute gears with surfaces that roll at
the sum 2 v sin(alpha) of their speeds; here v is the speed of an involute gear with the same entrainment and a pressure
angle of 20 deg.
"""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.design import Design
from cycloid_mj.design.lubricants import lubricant
from cycloid_mj.life.loading import Loading
from cycloid_mj.statics.film import FilmSurfaces

RZ_OVER_RA, RA_OVER_RQ = 6.0, math.sqrt(2.0 / math.pi)
"""Rz over Ra (ISO 6336-2:2006, 12.3.1.3), and Ra over Rq of normally distributed heights."""

PRESSURE_ANGLE = math.radians(20.0)
"""Pressure angle of the involute gear whose pitch-line speed stands for the entrainment (ISO 53)."""

STATIC_CYCLES, FULL_CYCLES = 1e5, 5e7
"""Numbers of loads up to which the factors are 1, and from which they count in full (ISO 6336-2:2006, 11)."""


@dataclass(frozen=True)
class PittingFactors:
    """Factors of the lubricant [1] on the allowed pressure, and their inputs.

    Attributes
    ----------
    lubricant, speed, roughness
        Z_L, Z_v and Z_R.
    viscosity_40
        Viscosity of the (base) oil at 40 °C [mm2/s].
    pitch_speed
        Equivalent pitch-line speed v [m/s].
    mean_roughness
        Relative peak-to-valley roughness Rz10 [um].
    """

    lubricant: float
    speed: float
    roughness: float
    viscosity_40: float
    pitch_speed: float
    mean_roughness: float

    @property
    def product(self) -> float:
        """Return the product of lubricant, speed and roughness factor [1]."""
        return self.lubricant * self.speed * self.roughness


def lubricant_factor(viscosity_40: float, limit: float) -> float:
    """Compute Z_L [1] from the viscosity at 40 °C [mm2/s] and the pressure allowed for long life [Pa], Eq. 17."""
    constant = _interpolate(limit, 0.83, 0.91)
    return constant + 4.0 * (1.0 - constant) / (1.2 + 134.0 / viscosity_40) ** 2


def speed_factor(speed: float, limit: float) -> float:
    """Compute Z_v [1] from the pitch-line speed [m/s] and the pressure allowed for long life [Pa], Eq. 19."""
    constant = _interpolate(limit, 0.85, 0.93)
    return constant + 2.0 * (1.0 - constant) / math.sqrt(0.8 + 32.0 / speed) if speed > 0.0 else constant


def roughness_factor(mean_roughness: float, limit: float) -> float:
    """Compute Z_R [1] from Rz10 [um] and the pressure allowed for long life [Pa], Eq. 23."""
    return float((3.0 / mean_roughness) ** _interpolate(limit, 0.15, 0.08))


def relative_roughness(roughness: float, radius: float) -> float:
    """Compute Rz10 [um] from the composite Rq of both surfaces and the reduced radius, both in [m], Eq. 21.

    Both surfaces are taken as equally rough: each has Rq/sqrt(2).
    """
    one_surface = 1e6 * roughness / math.sqrt(2.0)
    return RZ_OVER_RA * RA_OVER_RQ * one_surface * (10.0 / (1e3 * radius)) ** (1.0 / 3.0)


def _interpolate(limit: float, soft: float, hard: float) -> float:
    """Interpolate a constant between those up to 850 and from 1200 MPa of allowed pressure [Pa]."""
    return float(np.interp(1e-6 * limit, (850.0, 1200.0), (soft, hard)))


def pitting_factors(loading: Loading, kind: str, limit: float) -> PittingFactors | None:
    """Compute the lubricant, speed and roughness factors Z_L, Z_v and Z_R [1] of a kind of mating pair (ISO 6336-2).

    They are valid at one point of a duty cycle. They follow from means over the loaded contacts of `loading`. `limit`
    is the pressure allowed for long life [Pa]. Returns None for pairs other than teeth and output pins in holes, or if
    the design does not have the friction law ``film``.
    """
    reducer, film = loading.reducer, loading.springs.film
    design = reducer.design
    if film is None or kind not in (design.tooth_pair, "output"):
        return None
    if kind == "output":
        speeds = film.surfaces.hole_speeds
        entrainment, radius = float(speeds.entrainment), 1.0 / reducer.contacts["output"].relative_curvature
    else:
        friction = loading.contacts.friction
        assert friction is not None
        surfaces = film.displaced(loading.contacts.departures).surfaces
        entrainment, radius = mean_speed_and_radius(friction.rolls, surfaces, loading.contacts.teeth)
    return factors_of_contact(design, entrainment, radius, limit)


def mean_speed_and_radius(rolls: Mask, surfaces: FilmSurfaces, force: Array) -> tuple[float, float]:
    """Return the mean entrainment speed [m/s] and the reduced radius [m] of tooth contacts, weighted by their forces.

    The radius is the inverse of the mean curvature. `rolls` is true for contacts whose pin rolls on the disc and slides
    in its seat. `surfaces` are those of the contacts, and `force` [N] their normal forces; all have one shape.
    """
    speed = np.where(rolls, np.abs(surfaces.flank.moving), np.abs(surfaces.flank.entrainment))
    return float(np.average(speed, weights=force)), 1.0 / float(np.average(1.0 / surfaces.radius, weights=force))


def factors_of_contact(design: Design, entrainment: float, radius: float, limit: float) -> PittingFactors:
    """Compute the lubricant, speed and roughness factors [1] of a contact of a design with the friction law ``film``.

    Parameters
    ----------
    entrainment, radius
        Entrainment speed [m/s], and reduced radius [m].
    limit
        Pressure allowed for long life [Pa].
    """
    viscosity = lubricant(design.friction.lubricant).viscosity_40
    pitch_speed = abs(entrainment) / math.sin(PRESSURE_ANGLE)
    roughness = relative_roughness(design.friction.roughness, radius)
    return PittingFactors(
        lubricant_factor(viscosity, limit),
        speed_factor(pitch_speed, limit),
        roughness_factor(roughness, limit),
        viscosity,
        pitch_speed,
        roughness,
    )


def lubricated_cycles(cycles: float, factor: float, power: float) -> float:
    """Compute the number of load cycles until pitting with a factor Z of the lubricant (ISO 6336-2:2006, 11.3).

    Z multiplies the allowed pressure. Up to `STATIC_CYCLES` it has no effect, and from `FULL_CYCLES` on it has its full
    effect. In between, the pressure is multiplied by Z^e, where e rises from 0 to 1 linearly with the logarithm of the
    number of cycles.

    Parameters
    ----------
    cycles
        Number n of load cycles without the factor: n = (S/p)^(1/power), with the pressure p and a constant S.
    factor, power
        Factor Z [1], and exponent of the curve.
    """
    if cycles <= STATIC_CYCLES:
        return cycles
    log_shift, log_start, log_span = (
        math.log(factor) / power,
        math.log(STATIC_CYCLES),
        math.log(FULL_CYCLES / STATIC_CYCLES),
    )
    log_cycles = (
        (math.log(cycles) - log_shift * log_start / log_span) / (1.0 - log_shift / log_span)
        if log_shift < log_span
        else math.inf
    )
    return math.exp(log_cycles) if log_cycles < log_start + log_span else cycles * factor ** (1.0 / power)
