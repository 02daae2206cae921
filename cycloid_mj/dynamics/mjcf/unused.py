"""Disabling of MuJoCo's stages that a model does not use during runs."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import mujoco


@contextmanager
def disable_unused(model: Any) -> Iterator[None]:
    """Disable unused stages inside this ``with`` block, without changing results.

    They visit every degree of freedom in every step, which takes 3 % of a step with moving pins. Outside of runs they
    stay enabled, so that springs or limits added by a user work.
    """
    added = unused_flags(model) & ~model.opt.disableflags
    model.opt.disableflags |= added
    try:
        yield
    finally:
        model.opt.disableflags &= ~added


def unused_flags(model: Any) -> int:
    """Return the flag bits that disable the stages which a model does not use; 0 for a model with tendons."""
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
