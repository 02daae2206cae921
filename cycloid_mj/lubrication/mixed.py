"""Mixed friction: boundary friction of the asperities and shear of the film, by the ratio of film to roughness.

The asperities carry the share 1 - 0.82 lambda^0.28 of the load, with lambda the film thickness over the roughness Rq of
both surfaces (Castro and Seabra 2007, for gears; 0 from lambda 2.03 on). The film shears as an Eyring fluid with a
limiting stress (Johnson and Tevaarwerk 1977). None of these laws is validated below 1 m/s and a radius of 2 mm.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.lubrication.film import FORMULAS, isoviscous_elastic, line_contact_groups
from cycloid_mj.lubrication.journal import solve_journal

MIN_FORCE = 1e-6
"""Smallest force of a contact whose coefficient is computed [N]; its friction does not matter."""


@dataclass(frozen=True)
class FilmLaw:
    """State of the lubricant and the surfaces, and constants of the friction laws.

    Attributes
    ----------
    viscosity, pressure_coefficient
        Viscosity at ambient pressure [Pa s] and its pressure coefficient [1/Pa].
    roughness
        Composite rms roughness Rq of both surfaces [m].
    boundary
        Coefficient of boundary friction [1].
    formula
        Name of the film thickness formula, one of `film.FORMULAS`.
    film_factor
        Film thickness over that of the formula [1]: its spread, and starvation of grease.
    film_share, share_exponent
        Load share of the film at lambda = 1 [1], and the exponent of lambda (Castro and Seabra 2007).
    eyring_stress
        Eyring stress [Pa]: 2 to 10 MPa of mineral oils.
    limiting_shear
        Limiting shear stress over the mean pressure [1]: 0.04 to 0.08 of mineral oils.
    max_pressure_exponent
        Largest alpha p of the viscosity in the film: beyond, Barus' law overestimates it and the stress is limited.
    """

    viscosity: float
    pressure_coefficient: float
    roughness: float
    boundary: float
    formula: str = "pan-hamrock"
    film_factor: float = 1.0
    film_share: float = 0.82
    share_exponent: float = 0.28
    eyring_stress: float = 5e6
    limiting_shear: float = 0.06
    max_pressure_exponent: float = 25.0


@dataclass(frozen=True, eq=False)
class MixedFriction:
    """Friction of contacts; arrays of one shape.

    Attributes
    ----------
    coefficient
        Friction coefficient [1].
    ratio
        Film thickness over roughness, lambda [1].
    asperity_share
        Share of the load that the asperities carry [1]; 1 is boundary lubrication.
    """

    coefficient: Array
    ratio: Array
    asperity_share: Array

    def scaled(self, factor: float) -> "MixedFriction":
        """Return the friction with its coefficient times a factor, as at another radius of the same part."""
        return replace(self, coefficient=factor * self.coefficient)


def asperity_share(law: FilmLaw, ratio: npt.ArrayLike) -> Array:
    """Compute the share of the load on asperities [1] from the ratio lambda of film thickness to roughness."""
    return np.asarray(1.0 - np.minimum(1.0, law.film_share * np.asarray(ratio, float) ** law.share_exponent))


def line_friction(
    law: FilmLaw,
    force: npt.ArrayLike,
    entrainment: npt.ArrayLike,
    sliding: npt.ArrayLike,
    radius: npt.ArrayLike,
    length: float,
    modulus: float,
) -> MixedFriction:
    """Compute friction coefficient, film ratio and load share of the asperities [1] of line contacts in mixed friction.

    The film thickness is computed by the formulas for hard (piezoviscous-elastic) and for soft (isoviscous-elastic)
    contacts; the larger result is used.

    Parameters
    ----------
    law
        Lubricant and surfaces.
    force
        Normal force [N]; where it is 0, the result is the limit for a vanishing force.
    entrainment, sliding
        Entrainment and sliding speed [m/s]; signs have no effect.
    radius, length
        Reduced radius and length of the contacts [m].
    modulus
        Contact modulus E* [Pa] of `ideal_loads.contact_modulus`.
    """
    positive_force, reduced_radius = np.maximum(np.asarray(force, float), MIN_FORCE), np.asarray(radius, float)
    contact = line_contact_groups(
        positive_force, entrainment, reduced_radius, length, law.viscosity, law.pressure_coefficient, 2.0 * modulus
    )
    film = law.film_factor * np.maximum(FORMULAS[law.formula](contact), isoviscous_elastic(contact))
    mean_pressure = 0.25 * math.pi * np.sqrt(positive_force * modulus / (math.pi * reduced_radius * length))
    return _mixed(law, film, _film_coefficient(law, film, sliding, mean_pressure))


def journal_friction(
    law: FilmLaw,
    force: npt.ArrayLike,
    entrainment: npt.ArrayLike,
    sliding: npt.ArrayLike,
    radius: float,
    clearance: float,
    length: float,
) -> MixedFriction:
    """Compute friction coefficient, film ratio and load share of the asperities [1] of journal bearings.

    Without clearance or viscosity there is no film.

    Parameters
    ----------
    law
        Lubricant and surfaces.
    force
        Load [N].
    entrainment, sliding
        Entrainment and sliding speed [m/s]; signs have no effect.
    radius, clearance, length
        Radius, radial clearance and length of the bearings [m].
    """
    force = np.maximum(np.asarray(force, float), MIN_FORCE)
    if not (clearance > 0.0 and law.viscosity > 0.0):
        return _mixed(law, np.zeros_like(force), np.zeros_like(force))
    bearing = solve_journal(force, entrainment, sliding, radius, clearance, length, law.viscosity)
    return _mixed(law, law.film_factor * bearing.film, bearing.friction)


def _film_coefficient(law: FilmLaw, film: Array, sliding: npt.ArrayLike, pressure: Array) -> Array:
    """Compute the coefficient of the film's shear [1] under a mean pressure [Pa]."""
    viscosity = law.viscosity * np.exp(np.minimum(law.pressure_coefficient * pressure, law.max_pressure_exponent))
    rate = np.abs(sliding) / np.maximum(film, np.finfo(float).tiny)
    stress = law.eyring_stress * np.arcsinh(np.minimum(viscosity * rate / law.eyring_stress, np.finfo(float).max))
    return np.asarray(np.minimum(stress / pressure, law.limiting_shear))


def _mixed(law: FilmLaw, film: Array, film_coefficient: Array) -> MixedFriction:
    """Combine boundary friction and film shear; a thin film has no more friction than a boundary layer."""
    ratio = film / law.roughness
    share = asperity_share(law, ratio)
    coefficient = share * law.boundary + (1.0 - share) * np.minimum(film_coefficient, law.boundary)
    return MixedFriction(np.asarray(coefficient), np.asarray(ratio), share)
