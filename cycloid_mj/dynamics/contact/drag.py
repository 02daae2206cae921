"""The drag of seals and lubricant on the shafts, which is joint friction: where MuJoCo's solver has it."""

from collections.abc import Mapping
from typing import Any

import numpy as np


def drag_rows(model: Any, drags: Mapping[str, str]) -> dict[str, int]:
    """Map loss to row of its constraint, for those of the joints, by loss, that a model brakes.

    A model of ours has no equalities: the rows of joint friction come first, in the order of the degrees of freedom.
    """
    braked = model.dof_frictionloss > 0.0
    dofs = {name: int(model.joint(joint).dofadr[0]) for name, joint in drags.items()}
    return {name: int(np.count_nonzero(braked[:dof])) for name, dof in dofs.items() if braked[dof]}
