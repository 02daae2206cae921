"""Which of MuJoCo's constraint solvers a model takes: both minimise the same convex cost, to the same tolerance."""

from collections.abc import Mapping
from typing import Any

import mujoco

from cycloid_mj.contact.law import ContactLaw
from cycloid_mj.contact.regime import steps_ratio

WELL_CONDITIONED = 1.5
"""Largest K dt^2/m for conjugate gradients.

The cost is that of the masses plus K dt^2 on each contact, so this ratio bounds its condition number. Up to 1.5 some 4
gradient steps are enough and cost 0.55 to 0.85 of one Newton step with its factorisation (12 to 60 moving pins, with
and without load); from 3 on it takes 20 to 50, and Newton's 1 to 5 steps win.
"""


def set_solver(spec: Any, laws: Mapping[str, ContactLaw], moving_pins: bool) -> None:
    """Set solver and Jacobian of an editable model from the contact laws of its pairs.

    With moving pins each contact touches a few of many degrees of freedom: sparse matrices, whatever MuJoCo's own
    choice from 60 degrees of freedom on. Without them there are five, and Newton's exact step is as cheap as any.
    """
    if not moving_pins:
        return
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE
    if max(steps_ratio(law, spec.option.timestep) for law in laws.values()) <= WELL_CONDITIONED:
        spec.option.solver = mujoco.mjtSolver.mjSOL_CG
