"""Journal bearing of a pin in a half socket: film thickness and friction over Sommerfeld's number.

The bearing is long, its arc of 180 deg is centred on the load, and its film ends where pressure and pressure gradient
vanish (Reynolds' end condition; Cameron 1966, The Principles of Lubrication, chapter 14). Surface speeds are those past
the load line: twice the entrainment, 2 u, builds the pressure, and the sliding v shears the film; under a load at rest
both are the speed of the pin's surface. Sommerfeld's number is S = eta 2 u/(2 pi r)/p (r/c)^2 with the mean pressure
p = w/(2 r L), the radius r, the radial clearance c, the force w and the length L.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array

ECCENTRICITY = np.array([0.99, 0.98, 0.95, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.05, 0.02])
SOMMERFELD = np.array(
    [
        *(0.00130, 0.00259, 0.00643, 0.01276, 0.02532, 0.03821, 0.05221),
        *(0.06865, 0.09009, 0.12207, 0.18048, 0.34719, 0.68104, 1.69103),
    ]
)
SHEAR = np.array(
    [
        *(0.1311, 0.1829, 0.2820, 0.3892, 0.5384, 0.6621, 0.7888),
        *(0.9404, 1.1390, 1.4087, 1.9312, 3.5093, 6.7637, 16.7044),
    ]
)
PRESSURE = np.array(
    [
        *(0.0827, 0.1108, 0.1568, 0.1938, 0.2198, 0.2193, 0.2051),
        *(0.1821, 0.1532, 0.1218, 0.0876, 0.0477, 0.0247, 0.0100),
    ]
)
"""Solutions of Reynolds' equation by eccentricity ratio: S, and friction f r/c by shear at 2 u = v and by pressure.

A test solves the equation again. Behind the film, shear is 0.3 of that of a full gap (streamers of lubricant, assumed).
"""


@dataclass(frozen=True)
class JournalState:
    """State of journal bearings; arrays of one shape.

    Attributes
    ----------
    sommerfeld, eccentricity
        Sommerfeld's number S and eccentricity ratio.
    film
        Smallest film thickness [m].
    friction
        Friction coefficient of the film at the radius of the pin [1].
    """

    sommerfeld: Array
    eccentricity: Array
    film: Array
    friction: Array


def solve_journal(
    force: npt.ArrayLike,
    entrainment: npt.ArrayLike,
    sliding: npt.ArrayLike,
    radius: float,
    clearance: npt.ArrayLike,
    length: float,
    viscosity: float,
) -> JournalState:
    """Compute film thickness [m] and friction coefficient [1] of journal bearings with half sockets, from a table.

    Above the tabulated Sommerfeld numbers S, a concentric bearing is assumed for the friction (Petroff); below them,
    the film thickness is proportional to S.

    Parameters
    ----------
    force
        Load [N], more than 0. `force`, `entrainment`, `sliding` and `clearance` broadcast to the shape of the result.
    entrainment
        Half of the sum of the speeds of both surfaces relative to the line of the load [m/s]; its sign has no effect.
    sliding
        Difference of these two speeds [m/s]; its sign has no effect.
    radius, clearance, length
        Radius, radial clearance and length [m].
    viscosity
        Dynamic viscosity [Pa s].
    """
    force, clearance = np.asarray(force, float), np.asarray(clearance, float)
    tiny = np.finfo(float).tiny
    sommerfeld_per_speed = (
        viscosity / (2.0 * math.pi * radius) * 2.0 * radius * length / force * (radius / clearance) ** 2
    )
    sommerfeld = np.maximum(sommerfeld_per_speed * 2.0 * np.abs(entrainment), tiny)
    shear_number = sommerfeld_per_speed * np.abs(sliding)
    log_sommerfeld, log_table = np.log(sommerfeld), np.log(SOMMERFELD)
    is_below_table, is_above_table = sommerfeld < SOMMERFELD[0], sommerfeld > SOMMERFELD[-1]
    relative_film = np.interp(log_sommerfeld, log_table, 1.0 - ECCENTRICITY)
    relative_film = np.where(is_below_table, (1.0 - ECCENTRICITY[0]) * sommerfeld / SOMMERFELD[0], relative_film)
    relative_film = np.where(is_above_table, 1.0 - ECCENTRICITY[-1] * SOMMERFELD[-1] / sommerfeld, relative_film)
    shear_factor = np.exp(np.interp(log_sommerfeld, log_table, np.log(SHEAR)))
    shear_factor = np.where(is_below_table, SHEAR[0] * np.sqrt(sommerfeld / SOMMERFELD[0]), shear_factor)
    shear_factor = np.where(is_above_table, math.pi**2 * sommerfeld, shear_factor)
    pressure_term = np.interp(log_sommerfeld, log_table, PRESSURE)
    friction = (clearance / radius) * (shear_factor * shear_number / sommerfeld + pressure_term)
    return JournalState(sommerfeld, 1.0 - relative_film, clearance * relative_film, np.asarray(friction))
