"""What the measures that turn the crank set alike: time step, speed, load and rate of their runs."""

from cycloid_mj.base.errors import DesignError
from cycloid_mj.dynamics.run import STEP_RULES, Solver
from cycloid_mj.reducer import Reducer

LOG_RATE = 20e3
"""Samples per second."""
DRAG = 0.01
"""Torque that keeps the flanks of an unloaded reducer in touch, as a share of the rated one."""


def require_motion(reducer: Reducer) -> None:
    """Refuse a design whose crank stands still.

    Raises
    ------
    DesignError
        ``drive.speed`` is 0.
    """
    if reducer.design.drive.speed == 0.0:
        raise DesignError("drive.speed_rpm is 0, but this measure turns the crank: give another speed, such as 1640")


def drag_assumption(reducer: Reducer) -> str:
    """Tell the drag of seals and lubricant on the shafts, and that it is an assumption where there is none."""
    drags = [
        f"drag.{shaft}_nm {torque:g} N m" if torque else f"drag.{shaft}_nm 0: left out"
        for shaft, torque in (("crank", reducer.design.drag.crank), ("output", reducer.design.drag.output))
    ]
    return f"seals and lubricant: {', '.join(drags)}"


def halved(reducer: Reducer, solver: Solver) -> Reducer:
    """Halve the time step that a solver takes of a design."""
    return reducer.but(settings={"timestep": 0.5 * STEP_RULES[solver].choose(reducer).seconds})
