"""Friction of a turning crank's contacts: it acts against the way in which the ideal parts slide."""

import numpy as np

from cycloid_mj.design import Design
from cycloid_mj.mechanism.gaps import Gaps
from cycloid_mj.types import Array


def rubbing(design: Design, found: Gaps, motion: Array) -> Array:
    """Give the generalised friction of each contact per normal force [1], shape (..., n, u).

    `motion` is how the unknowns move with time, shape (..., u): `mechanism.gaps.ideal_motion` times the crank's speed.
    """
    sliding = np.einsum("...nu,...u->...n", found.slip_slope, motion)
    coefficient = np.where(found.kind == "output", design.friction_of("output"), design.mesh_friction)
    return np.asarray(-(coefficient * np.sign(sliding))[..., np.newaxis] * found.slip_slope)
