"""Mass, centroid and inertia of a solid, exact for its polygons."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cycloid_mj.base.array import Array, on_grid, significant, significant_tensor
from cycloid_mj.parts.polygon import AreaMoments, area_moments
from cycloid_mj.parts.prism import Prism, Solid


@dataclass(frozen=True)
class MassProperties:
    """Mass [kg], volume [m3], centroid (3,) [m] and inertia (3, 3) about the centroid [kg m2]."""

    mass: float
    volume: float
    centroid: Array
    inertia: Array


@lru_cache(maxsize=12)  # the parts of one design: they hold their outlines
def mass_properties(solid: Solid) -> MassProperties:
    """Compute mass, volume, centroid and inertia of a solid, rounded to `DIGITS` digits.

    V, s and S are the integrals of 1, r and r r^T over the volume. The centroid is s/V. The inertia about the centroid
    is density (tr(C) 1 - C) with C = S - s s^T / V (the parallel-axis theorem).
    """
    moments = [_volume_moments(prism) for prism in solid.prisms]
    volume = sum(prism_moments[0] for prism_moments in moments)
    first_moment = np.sum([prism_moments[1] for prism_moments in moments], axis=0)
    second_moment = np.sum([prism_moments[2] for prism_moments in moments], axis=0)
    central_moment = second_moment - np.outer(first_moment, first_moment) / volume
    return MassProperties(
        mass=significant(solid.density * volume),
        volume=significant(volume),
        centroid=on_grid(first_moment / volume),
        inertia=significant_tensor(solid.density * (np.trace(central_moment) * np.eye(3) - central_moment)),
    )


def region_moments(prism: Prism) -> AreaMoments:
    """Compute the area moments of a prism's cross-section: its outline less its holes."""
    polygon_moments = [np.array(area_moments(prism.outline)), *(-np.array(area_moments(hole)) for hole in prism.holes)]
    return AreaMoments(*map(float, np.sum(polygon_moments, axis=0)))


def _volume_moments(prism: Prism) -> tuple[float, Array, Array]:
    """Integrate 1, r and r r^T over the volume of a prism, about the origin.

    Returns
    -------
    tuple
        Volume [m3], first moments (3,) [m4] and second moments (3, 3) [m5].
    """
    area, x, y, xx, yy, xy = region_moments(prism)
    height, z0, z1 = prism.height, prism.z0, prism.z1
    mid_height = (z0 + z1) / 2
    zz = (z0 * z0 + z0 * z1 + z1 * z1) / 3
    first_moment = height * np.array([x, y, area * mid_height])
    second_moment = height * np.array(
        [[xx, xy, x * mid_height], [xy, yy, y * mid_height], [x * mid_height, y * mid_height, area * zz]]
    )
    return area * height, first_moment, second_moment
