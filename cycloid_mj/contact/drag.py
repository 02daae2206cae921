"""What MuJoCo's solver found in the drag of seals and lubricant on the shafts, which is joint friction."""

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from cycloid_mj.types import Array


def dragged_joints(model: Any, drags: Mapping[str, str]) -> dict[str, int]:
    """Give loss -> degree of freedom for those of the joints, by loss, that a model brakes."""
    dofs = {name: int(model.joint(joint).dofadr[0]) for name, joint in drags.items()}
    return {name: dof for name, dof in dofs.items() if model.dof_frictionloss[dof] > 0.0}


def drag_powers(data: Any, dofs: Mapping[str, int]) -> Array:
    """Give the power that each drag takes [W], shape (drags,), of the step just taken.

    `data` is ``MjData`` after ``mj_step``, `dofs` from `dragged_joints`.
    """
    if not dofs:
        return np.zeros(0)
    friction = data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF)
    taken = -data.efc_force[friction] * data.efc_vel[friction]
    powers: dict[int, float] = dict(zip(data.efc_id[friction].tolist(), taken.tolist(), strict=True))
    return np.array([powers[dof] for dof in dofs.values()])
