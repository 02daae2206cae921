"""Preload of the teeth of an RV reducer whose discs expand more than the clearance of the ring allows.

Ring and discs then deform elastically, so that the springs of the pins take only a share of the interference.
"""

import math

import numpy as np

from cycloid_mj.reducer.contact import tooth_stiffness
from cycloid_mj.reducer.reducer import Reducer


def preload_share(reducer: Reducer) -> float:
    """Compute the fraction [1] of a radial interference of discs and ring that the tooth contacts take as deflection.

    Housing and discs yield by the rest. In series with the contacts, the housing expands as a thin ring and each disc
    shrinks as a full plate, under equal radial forces of all pins on all discs.
    """
    design, ring = reducer.design, reducer.design.ring
    housing, disc = design.material_of("housing"), design.material_of("gear")
    section_area = (design.housing.outer_radius - design.ring_root_radius) * design.gear.stack_width
    mean_radius = 0.5 * (design.housing.outer_radius + design.ring_root_radius)
    housing_compliance = (
        ring.teeth * design.gear.discs * mean_radius / (2.0 * math.pi * housing.youngs_modulus * section_area)
    )
    disc_compliance = (1.0 - disc.poisson) * ring.teeth
    disc_compliance /= 2.0 * math.pi * design.gear.face_width * disc.youngs_modulus
    tooth_compliance = 1.0 / float(np.mean(tooth_stiffness(reducer, np.array([1.0 / ring.pin_radius]))))
    return tooth_compliance / (tooth_compliance + housing_compliance + disc_compliance)
