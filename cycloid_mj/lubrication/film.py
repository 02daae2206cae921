"""Film thickness of elastohydrodynamic line contacts, isothermal and fully flooded.

Groups: U = eta u/(E' R), G = alpha E', W = w/(E' R L), with the viscosity eta at the inlet, the entrainment speed u,
the radius 1/R = 1/R1 + 1/R2 and the modulus 2/E' = (1 - nu1^2)/E1 + (1 - nu2^2)/E2. The formulas are fits to numerical
solutions in the piezoviscous-elastic regime and agree to about 20 %.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array


@dataclass(frozen=True)
class Groups:
    """Dimensionless groups of a line contact; arrays of one shape.

    Attributes
    ----------
    speed, material, load
        U, G and W.
    radius
        Reduced radius R [m].
    length
        Length L of the line [m].
    """

    speed: Array
    material: float
    load: Array
    radius: Array
    length: float


def line_contact_groups(
    force: npt.ArrayLike,
    entrainment: npt.ArrayLike,
    radius: npt.ArrayLike,
    length: float,
    viscosity: float,
    pressure_coefficient: float,
    modulus: float,
) -> Groups:
    """Compute the dimensionless groups of line contacts, from which the formulas of this module compute film thickness.

    They are the speed group U = eta u/(E' R), the material group G = alpha E' and the load group W = w/(E' R L), with
    the parameters eta, u, R, alpha, w (force), L and E'.

    Parameters
    ----------
    force, entrainment, radius
        Normal force w [N], entrainment speed u [m/s], whose sign has no effect, and reduced radius R [m].
    length
        Length L of the line [m].
    viscosity, pressure_coefficient
        Viscosity eta at the inlet [Pa s], and its pressure coefficient alpha [1/Pa].
    modulus
        Reduced modulus E' [Pa], which is twice the result of `ideal_loads.contact_modulus`.
    """
    force, speed, radius = (np.asarray(array, float) for array in (force, entrainment, radius))
    return Groups(
        speed=np.asarray(viscosity * np.abs(speed) / (modulus * radius)),
        material=pressure_coefficient * modulus,
        load=np.asarray(force / (modulus * radius * length)),
        radius=radius,
        length=length,
    )


def dowson_higginson(contact: Groups) -> Array:
    """Compute the minimum film thickness [m] of line contacts (Dowson and Higginson 1966)."""
    return _power_law(contact, 2.65, 0.70, 0.54, -0.13)


def pan_hamrock(contact: Groups) -> Array:
    """Compute the minimum film thickness [m] of line contacts (Pan and Hamrock 1989)."""
    return _power_law(contact, 1.714, 0.694, 0.568, -0.128)


def hamrock_dowson(contact: Groups) -> Array:
    """Compute the minimum film thickness [m] of long elliptic contacts (Hamrock and Dowson 1977, k to infinity)."""
    point_load = contact.load * contact.length / contact.radius
    return _power_law(contact, 3.63, 0.68, 0.49, -0.073, point_load)


def isoviscous_elastic(contact: Groups) -> Array:
    """Compute the minimum film thickness [m] of soft line contacts such as plastics (Herrebrugh 1968)."""
    return _power_law(contact, 3.10, 0.60, 0.0, -0.20)


FORMULAS: Mapping[str, Callable[[Groups], Array]] = {
    "pan-hamrock": pan_hamrock,
    "dowson-higginson": dowson_higginson,
    "hamrock-dowson": hamrock_dowson,
}
"""Minimum film thickness by name of its formula."""


def _power_law(
    line_contact: Groups,
    factor: float,
    speed_power: float,
    material_power: float,
    load_power: float,
    load_group: Array | None = None,
) -> Array:
    """Compute the film thickness of line contacts [m] by a power law; 0 without speed or force.

    It is `factor` U^a G^b W^c R. U, G and W are the groups of `line_contact`, R is its reduced radius; the result has
    the shape of W. The exponents a, b and c are `speed_power`, `material_power` and `load_power`. If `load_group` is
    not None, it is used in place of W.
    """
    load_group = line_contact.load if load_group is None else load_group
    positive_load = np.maximum(load_group, np.finfo(float).tiny)
    thickness = (
        factor
        * line_contact.speed**speed_power
        * line_contact.material**material_power
        * positive_load**load_power
        * line_contact.radius
    )
    return np.asarray(np.where(load_group > 0.0, thickness, 0.0))
