"""The law of one contact, stiffness and damping, and its translation to MuJoCo's constraint parameters.

MuJoCo's normal force obeys ``R f + a + b v + k r = 0`` with relative acceleration a, velocity v and gap r. So k/R is
the stiffness K [N/m], b/R the damping C [N s/m], and 1/R an added mass [kg] that acts on the relative motion only.
K and C come from physics; the added mass is as small as the time step allows.
"""

import math
from dataclasses import dataclass

from cycloid_mj.errors import ContactError

_LEAST_SHARE = 1e-3
_IMPEDANCE = (1e-4, 0.9999)


@dataclass(frozen=True)
class ContactLaw:
    """Stiffness K [N/m], damping C [N s/m], added mass 1/R [kg] and friction coefficient of one contact."""

    stiffness: float
    damping: float
    added_mass: float
    friction: float


@dataclass(frozen=True)
class SolverParameters:
    """The attributes of a ``<pair>`` that make MuJoCo follow a contact law."""

    condim: int
    friction: tuple[float, float, float, float, float]
    solref: tuple[float, float]
    solimp: tuple[float, float, float, float, float]


def contact_law(
    stiffness: float, damping_ratio: float, effective_mass: float, friction: float, timestep: float
) -> ContactLaw:
    """Give the law of a contact between two bodies of a given effective mass.

    Parameters
    ----------
    stiffness
        K [N/m].
    damping_ratio
        Share of the critical damping 2 sqrt(K m).
    effective_mass
        m [kg], 1/m = sum of both bodies' inverse masses along the normal.
    friction
        Coulomb friction coefficient [1].
    timestep
        Time step dt [s]. A free pin sits between two contacts, so each can count on half its mass: with the added
        mass, K dt^2 is at most half of m/2 + 1/R (the oscillation of the contact is resolved) and
        K dt^2/2 + C dt at most all of it (half of what the explicit step would bear).
    """
    damping = 2.0 * damping_ratio * math.sqrt(stiffness * effective_mass)
    stiff = stiffness * timestep**2
    needed = max(2.0 * stiff, 0.5 * stiff + damping * timestep) - 0.5 * effective_mass
    return ContactLaw(stiffness, damping, max(needed, _LEAST_SHARE * effective_mass), friction)


def solver_parameters(law: ContactLaw, inverse_weight: float) -> SolverParameters:
    """Translate a contact law for MuJoCo.

    Parameters
    ----------
    law
        What the contact shall do.
    inverse_weight
        Sum of both bodies' translational ``body_invweight0`` [1/kg], MuJoCo's estimate of A in R = (1-d)/d A.

    Raises
    ------
    ContactError
        The added mass lies outside what MuJoCo's impedance can represent.
    """
    regularisation = 1.0 / law.added_mass
    impedance = inverse_weight / (regularisation + inverse_weight)
    low, high = _IMPEDANCE
    if not low <= impedance <= high:
        raise ContactError(
            f"a contact of stiffness {law.stiffness:.3g} N/m needs an added mass of {law.added_mass:.3g} kg, impedance "
            f"{impedance:.3g}, but MuJoCo allows {low} to {high}; lengthen or shorten settings.timestep_us"
        )
    scale = regularisation * impedance
    slide = (law.friction, law.friction, 0.0, 0.0, 0.0)
    return SolverParameters(
        condim=3 if law.friction > 0.0 else 1,
        friction=slide,
        solref=(-law.stiffness * scale, -law.damping * scale),
        solimp=(impedance, impedance, 1.0, 0.5, 1.0),
    )
