"""What the measures that turn the crank set alike: time step, speed, load and rate of their runs."""

from cycloid_mj.contact.timestep import timestep
from cycloid_mj.design import Design
from cycloid_mj.errors import DesignError

"""One turn a minute [rad/s]."""
LOG_RATE = 20e3
"""Samples per second."""
DRAG = 0.01
"""Torque that keeps the flanks of an unloaded reducer in touch, as a share of the rated one."""


def require_motion(design: Design) -> None:
    """Refuse a design whose crank stands still.

    Raises
    ------
    DesignError
        ``drive.speed`` is 0.
    """
    if design.drive.speed == 0.0:
        raise DesignError("drive.speed_rpm is 0, but this measure turns the crank: give another speed, such as 1640")


def drag_told(design: Design) -> str:
    """Tell the drag of seals and lubricant on the shafts, and that it is an assumption where there is none."""
    told = [
        f"drag.{shaft}_nm {torque:g} N m" if torque else f"drag.{shaft}_nm 0: left out"
        for shaft, torque in (("crank", design.drag.crank), ("output", design.drag.output))
    ]
    return f"seals and lubricant: {', '.join(told)}"


def halved(design: Design) -> Design:
    """Give the design with half the time step."""
    return design.but(settings={"timestep": 0.5 * timestep(design)})
