"""``cycloid-mj rate``: how long a reducer lasts, item by item, the weakest first."""

from math import isfinite
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import FLAT, PRESET, DesignOptions, JsonFlag
from cycloid_mj.cli.terminal import say, say_json, show
from cycloid_mj.errors import UsageError

LoadFlag = Annotated[float | None, Parameter(help="Torque on the output [N m]. Default: the rated torque.")]
SpeedFlag = Annotated[float | None, Parameter(help="Speed of the crank [rpm]. Default: drive.speed_rpm.")]
DutyFlag = Annotated[
    Path | None,
    Parameter(metavar="DUTY.csv", help="Duty cycle instead: columns torque_nm, speed_rpm, share of the time."),
]
LifeFlag = Annotated[float, Parameter(help="Life that is asked for [h].")]
PeakFlag = Annotated[
    float | None, Parameter(help="Torque of an emergency stop [N m]. Default: twice the largest of the duty.")
]

EXAMPLES = """Examples:
  cycloid-mj rate --design pin
  cycloid-mj rate --design my.toml --load-nm 20 --speed-rpm 1000 --life-h 6000
  cycloid-mj rate --design my.toml --duty duty.csv --json"""


def rate(
    *,
    chosen: Annotated[DesignOptions, FLAT] = PRESET,
    load_nm: LoadFlag = None,
    speed_rpm: SpeedFlag = None,
    duty: DutyFlag = None,
    life_h: LifeFlag = 10_000.0,
    peak_nm: PeakFlag = None,
    json: JsonFlag = False,
) -> int:
    """Rate life, fatigue, wear and heat of a reducer, the weakest item first.

    Loads are those of statics with the real clearances and friction, at the rated
    torque and speed, at others, or over a duty cycle (Miner's rule). Bearings by
    ISO 281 and ISO 76, surfaces by shakedown and pitting, shaft, output pins and
    walls by Goodman with notch, surface, size and reliability, wear by Archard,
    the housing's temperature in still air, and an emergency stop. What the design
    file does not say is assumed, and said: [bearing] and [service] take ratings
    and limits. The exit code is 0 whatever the safeties are.
    """
    from cycloid_mj.rating.duty import read_duty, steady
    from cycloid_mj.rating.items import rate as rated
    from cycloid_mj.units import RPM

    for flag, value in (("--life-h", life_h), ("--peak-nm", peak_nm)):
        if value is not None and not 0.0 < value < float("inf"):
            raise UsageError(f"{flag} {value:g}: give a number more than 0")
    for flag, value in (("--load-nm", load_nm), ("--speed-rpm", speed_rpm)):
        if value is not None and duty:
            raise UsageError(f"--duty has torques and speeds of its own: leave {flag} out")
        if value is not None and not (value != 0.0 and isfinite(value)):
            raise UsageError(f"{flag} {value:g}: give a number that is not 0")
    design = chosen.sound()
    if duty:
        cycle = read_duty(duty, peak_nm)
    else:
        torque = design.rated_torque if load_nm is None else load_nm
        cycle = steady(torque, design.drive.speed if speed_rpm is None else speed_rpm * RPM, peak_nm)
    found = rated(design, cycle, life_h)
    if json:
        say_json(found.as_json())
        return 0
    show(found.table())
    for item in found.items.values():
        if item.note:
            say(f"{item.name}: {item.note}")
    for sentence in found.assumptions:
        say(f"assumed: {sentence}")
    say(f"weakest: {found.weakest.name}")
    return 0
