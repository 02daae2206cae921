"""Stages of MuJoCo's step that a model has nothing for: a run leaves them out."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import mujoco


@contextmanager
def left_out(model: Any) -> Iterator[None]:
    """Leave out, inside this ``with`` block, the stages that a model has nothing for; what it computes is the same.

    They look at every degree of freedom at every step: 3 % of one with moving pins. Outside of runs the model keeps
    them, so that springs or limits which somebody gives it act.
    """
    added = unused(model) & ~model.opt.disableflags
    model.opt.disableflags |= added
    try:
        yield
    finally:
        model.opt.disableflags &= ~added


def unused(model: Any) -> int:
    """Return MuJoCo's flags, as bits, that disable what a model has none of; 0 of one with tendons."""
    bit = mujoco.mjtDisableBit
    has = {
        bit.mjDSBL_EQUALITY: model.neq > 0,
        bit.mjDSBL_FRICTIONLOSS: model.dof_frictionloss.any(),
        bit.mjDSBL_LIMIT: model.jnt_limited.any(),
        bit.mjDSBL_SPRING: model.jnt_stiffness.any(),
        bit.mjDSBL_DAMPER: model.dof_damping.any(),
        bit.mjDSBL_CLAMPCTRL: model.actuator_ctrllimited.any(),
    }
    return 0 if model.ntendon else sum(int(flag) for flag, some in has.items() if not some)
