"""Common conditions of the measures that turn the crank: time step, speed, load and log rate of their runs."""

from cycloid_mj.base.errors import DesignError
from cycloid_mj.dynamics.run import STEP_RULES, Solver
from cycloid_mj.reducer import Reducer

LOG_RATE = 20e3
"""Log rate of the runs at least [Hz]."""

DRAG_SHARE = 0.01
"""Torque that keeps the flanks of an unloaded reducer in contact, relative to the rated one."""


def require_motion(reducer: Reducer) -> None:
    """Require that the crank of a design turns.

    Raises
    ------
    DesignError
        ``drive.speed`` is 0.
    """
    if reducer.design.drive.speed == 0.0:
        raise DesignError(
            "drive.speed_rpm is 0, but this measurement needs a crank that turns: set a speed other than 0, such as "
            "1640 rpm"
        )


def drag_assumption(reducer: Reducer) -> str:
    """Describe the drag of seals and lubricant on the shafts, or that it is neglected."""
    drags = [
        f"drag.{shaft}_nm {torque:g} N m" if torque else f"drag.{shaft}_nm 0: neglected"
        for shaft, torque in (("crank", reducer.design.drag.crank), ("output", reducer.design.drag.output))
    ]
    return f"seals and lubricant: {', '.join(drags)}"


def halve_time_step(reducer: Reducer, solver: Solver) -> Reducer:
    """Return the design with half the time step that the solver would choose."""
    return reducer.but(settings={"timestep": 0.5 * STEP_RULES[solver].choose(reducer).seconds})
