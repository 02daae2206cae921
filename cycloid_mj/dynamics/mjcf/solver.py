"""Choice of MuJoCo's constraint solver for a model: both minimise the same convex cost, to the same tolerance."""

from collections.abc import Mapping
from typing import Any

import mujoco

from cycloid_mj.dynamics.law import ContactParameters
from cycloid_mj.dynamics.regime import stiffness_ratio

MAX_CG_STIFFNESS_RATIO = 0.3
"""Largest K dt^2/m for which conjugate gradients are used.

The cost is that of the masses plus K dt^2 on each contact, so this ratio bounds its condition number. Up to 0.3 they
cost 0.8 to 0.97 of Newton's step with its factorisation (36 moving pins, without load and at 36 N m); at 1 they take
18 iterations under load, and Newton's two are cheaper by a fifth.
"""


def set_solver(spec: Any, laws: Mapping[str, ContactParameters], loaded: bool) -> None:
    """Set solver, Jacobian and islands of an editable model with moving pins from the contact laws of its pairs.

    Each contact touches a few of many degrees of freedom: sparse matrices, whatever MuJoCo's own choice from 60 degrees
    of freedom on. Without moving pins there are five, and Newton's exact step is as cheap as any.

    Under load the pins that carry are one island with gear and output, and those that do not stay out of its matrix: a
    step costs 0.91 of one without islands at 10 N m and 0.95 at 36.68 N m (36 pins). Without load nearly every pin in
    its socket is an island of its own, and finding them costs more than they save, 1.17.
    """
    if loaded:
        spec.option.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_ISLAND)
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE
    if max(stiffness_ratio(law, spec.option.timestep) for law in laws.values()) <= MAX_CG_STIFFNESS_RATIO:
        spec.option.solver = mujoco.mjtSolver.mjSOL_CG
