"""Stress of line contacts in closed form (Hertz), reported separately from the bulk stress of the finite elements.

A grid that does not resolve a patch of some ten micrometres shows neither of them.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize_scalar

from cycloid_mj.base.array import Array
from cycloid_mj.reducer import Reducer
from cycloid_mj.stress.loads import PartLoads
from cycloid_mj.stress.region import material_of


@dataclass(frozen=True)
class LineStress:
    """Stress of each contact at each crank angle, shape (k, m): zero without force, not a number where conformal.

    `peak_pressure` p0 [Pa], and the largest `von_mises` stress [Pa] below the surface.
    """

    peak_pressure: Array
    von_mises: Array


def line_stress(loads: PartLoads, reducer: Reducer) -> LineStress:
    """Compute Hertz's peak pressure and largest von Mises stress [Pa] of the m contacts of a part at k crank angles.

    Both have the shape (k, m). They are 0 without a force, and NaN where the contact is too conformal for Hertz's
    theory. If a contact is conformal at the angle of its largest `loads.pressure`, its stresses are NaN at every angle,
    because the largest of the remaining values would be mistaken for its maximum.
    """
    largest_rows = np.argmax(loads.pressure, axis=0)
    is_valid = loads.hertz & loads.hertz[largest_rows, np.arange(len(loads.labels))]
    pressure = np.where(is_valid, loads.pressure, np.nan)
    von_mises_ratio, _ = largest_von_mises(material_of(reducer, loads.part).poisson)
    return LineStress(pressure, von_mises_ratio * pressure)


def von_mises_below(depth: npt.ArrayLike, poisson: float) -> Array:
    """Compute the von Mises stress below the middle of a line contact, divided by the peak pressure [1].

    `depth` is the depth divided by the half width of the contact, z [1]; the result has its shape. With s = sqrt(1 +
    z^2), the principal stresses are sigma_x = -(1 + 2 z^2)/s + 2 z and sigma_z = -1/s. Since the strip is long, sigma_y
    = nu (sigma_x + sigma_z) with Poisson's ratio nu (Johnson 1985, Eq. 4.46).
    """
    z = np.asarray(depth, float)
    s = np.sqrt(1.0 + z**2)
    lateral_stress, normal_stress = -(1.0 + 2.0 * z**2) / s + 2.0 * z, -1.0 / s
    axial_stress = poisson * (lateral_stress + normal_stress)
    return np.sqrt(
        (
            (lateral_stress - axial_stress) ** 2
            + (axial_stress - normal_stress) ** 2
            + (normal_stress - lateral_stress) ** 2
        )
        / 2.0
    )


@cache
def largest_von_mises(poisson: float) -> tuple[float, float]:
    """Compute the largest von Mises stress below a line contact, and its depth.

    Returns
    -------
    tuple of float
        Stress divided by the peak pressure [1], and depth divided by the half width of the contact [1]: 0.558 and 0.7
        for a Poisson's ratio of 0.3.
    """
    # for any Poisson's ratio it is less deep than 3 b
    minimum = minimize_scalar(lambda z: -float(von_mises_below(z, poisson)), bounds=(0.0, 3.0), method="bounded")
    return float(-minimum.fun), float(minimum.x)
