"""The backlash of a reducer by its springs: how far the output turns between loads that bend next to nothing."""

from dataclasses import replace

import numpy as np

from cycloid_mj.design import Design
from cycloid_mj.loaded.balance import loads
from cycloid_mj.loaded.springs import springs_of, turn_evenly

POSES = 11
TOUCH = 1e-5
"""Load that brings the parts together, as a share of the rated torque."""


def backlash(design: Design) -> float:
    """Give the mean play of the output from stop to stop over a turn of the crank [rad].

    Raises
    ------
    ContactError
        The working force flattens a pin beyond a line contact.
    RunError
        No balance was found.
    """
    springs = springs_of(design, turn_evenly(POSES))
    still = replace(
        springs,
        body_force=np.zeros_like(springs.body_force),
        rubbing=np.zeros_like(springs.rubbing),
        cam_rubbing=0.0,
    )
    torque = TOUCH * design.rated_torque
    width = loads(design, still, torque).output_turn - loads(design, still, -torque).output_turn
    return float(width.mean())
