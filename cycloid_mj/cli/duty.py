"""Flags of a duty cycle: torque and speed, or a file, shared by the commands that rate life and heat."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError
from cycloid_mj.cli.flags import SPEED, DesignValue
from cycloid_mj.design import Design

if TYPE_CHECKING:
    from cycloid_mj.life import Duty

LoadFlag = Annotated[
    float | None,
    DesignValue("load", "torque", nonzero=True).flag("Output torque", ". Default: the nominal torque."),
]
SpeedFlag = Annotated[float | None, SPEED.flag("Crank speed", ". Default: drive.speed_rpm.")]
DutyFlag = Annotated[
    Path | None,
    Parameter(
        metavar="DUTY.csv",
        help="CSV file of a duty cycle instead of torque and speed: columns torque_nm, speed_rpm, share (of the time).",
    ),
]


def duty_cycle(
    design: Design, load_nm: float | None, speed_rpm: float | None, duty: Path | None, peak_nm: float | None = None
) -> "Duty":
    """Return the duty cycle that the flags of a command define: one torque and speed, or the rows of a file.

    Parameters
    ----------
    load_nm, speed_rpm
        Torque on the output [N m] and speed of the crank [rpm], not 0; None for the nominal values of the design.
    duty
        CSV file of the duty cycle; `load_nm` and `speed_rpm` must then be None.
    peak_nm
        Peak torque of an emergency stop [N m]; None: twice the largest torque.

    Raises
    ------
    UsageError
        Torque or speed are set together with a file, or the file cannot be read.
    """
    from cycloid_mj.base.units import RPM
    from cycloid_mj.life.duty import constant_duty, read_duty

    for flag, value in (("--load-nm", load_nm), ("--speed-rpm", speed_rpm)):
        if value is not None and duty:
            raise UsageError(
                f"{flag} and --duty cannot be used together, because the duty cycle defines torques and speeds: remove "
                "one of the two"
            )
    if duty:
        return read_duty(duty, peak_nm)
    torque = design.rated_torque if load_nm is None else load_nm
    return constant_duty(torque, design.drive.speed if speed_rpm is None else speed_rpm * RPM, peak_nm)
