"""Notch factors of the shoulder of a round shaft, and bending moments at the roots of the output pins.

DIN 743-2:2012 (shoulder, in bending and torsion)::

    alpha = 1 + 1/sqrt(A r/t + 2 B r/d (1 + 2 r/d)^2 + C (r/t)^z d/D),   t = (D - d)/2
"""

import math

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP

BENDING = (0.62, 5.8, 0.2, 3.0)
TORSION = (3.4, 19.0, 1.0, 2.0)
"""Coefficients A, B, C and z of a shoulder, by DIN 743-2."""


def shoulder_factor(radius: float, fillet: float, outer: float, terms: tuple[float, float, float, float]) -> float:
    """Compute the notch factor alpha [1] of a shoulder of a round shaft in bending or torsion, by DIN 743-2.

    At the shoulder, the radius of the shaft increases from `radius` to `outer` [m]; inf is a wide disc. `fillet` [m] is
    the radius of the fillet between them. `terms` are the coefficients of the formula: `BENDING` or `TORSION`.
    """
    a, b, c, z = terms
    depth = outer - radius
    relative_fillet, fillet_over_depth = fillet / (2.0 * radius), 0.0 if math.isinf(outer) else fillet / depth
    diameter_ratio = 0.0 if math.isinf(outer) else radius / outer
    return 1.0 + 1.0 / math.sqrt(
        a * fillet_over_depth
        + 2.0 * b * relative_fillet * (1.0 + 2.0 * relative_fillet) ** 2
        + c * fillet_over_depth**z * diameter_ratio
    )


def root_arms(reducer: Reducer) -> Array:
    """Compute the bending moments at the roots of an output pin per force of each of D discs [m], shape (roots, D).

    Forces act in the middle planes of the discs. A cantilever has one root, where a force F has the moment F a. A beam
    clamped at both ends has two roots, with moments F a b^2/l^2. a is the distance of the force from the root, b that
    from the other root, and l their sum (Roark, Formulas for Stress and Strain, 8.1, case 1d).
    """
    gear = reducer.design.gear
    root_position = gear.stack_width / 2.0 + AXIAL_GAP
    root_distance = root_position - np.array(gear.disc_planes)
    if reducer.design.output.support == "cantilever":
        return root_distance[np.newaxis]
    other_distance = 2.0 * root_position - root_distance
    return np.stack(
        [
            distance * opposite_distance**2 / (distance + opposite_distance) ** 2
            for distance, opposite_distance in ((root_distance, other_distance), (other_distance, root_distance))
        ]
    )
