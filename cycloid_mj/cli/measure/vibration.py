"""``cycloid-mj measure vibration``: accelerations, housing force and unbalance over crank speed."""

import math
from typing import Annotated, Any

from cyclopts import Parameter

from cycloid_mj.cli.flags import LOAD, SPEED, DesignFlag, JsonFlag, SetFlag, designed, whole, within
from cycloid_mj.cli.measure.deliver import LogFlag, OutFlag, QuietFlag, deliver, told

EXAMPLES = """Examples:
  cycloid-mj measure vibration --design nonpin
  cycloid-mj measure vibration --design pin --speed-rpm 500 --speed-rpm 3000 --json"""


def _require_each(_: Any, speeds: tuple[float, ...]) -> None:
    for speed in speeds:
        SPEED.require(speed)


LoadFlag = Annotated[
    float | None,
    Parameter(
        metavar="X",
        validator=LOAD.require,
        help=f"Torque of the loaded runs [N m], {LOAD.range}. Default: the rated torque, drive.torque_nm times the "
        "ratio (36.68 in the presets).",
    ),
]
SpeedsFlag = Annotated[
    tuple[float, ...],
    Parameter(
        metavar="X",
        validator=_require_each,
        help=f"Crank speed of the sweep [rpm], {SPEED.range}; may be repeated. Default: 0.5, 0.75, 1, 1.25 and 1.5 "
        "times the design's, which is always run.",
    ),
]
TurnsFlag = Annotated[
    int,
    Parameter(
        metavar="N",
        converter=whole,
        validator=within(1, 1000),
        help="Crank turns of each run, from 1 to 1000. Default: 1.",
    ),
]
QuickFlag = Annotated[bool, Parameter(help="At the design's speed only, and no runs with half the step.")]


def vibration(
    *,
    design: DesignFlag = "pin",
    set_: SetFlag = (),
    load_nm: LoadFlag = None,
    speed_rpm: SpeedsFlag = (),
    turns: TurnsFlag = 1,
    quick: QuickFlag = False,
    out: OutFlag = None,
    no_log: LogFlag = False,
    json: JsonFlag = False,
    quiet: QuietFlag = False,
) -> int:
    """Measure the vibration of gear, output and housing over crank speed.

    The rms and the spectrum of the accelerations of the gear's centre and the
    output about the closed form, and of the force on the housing, unloaded and
    loaded; the unbalance with and without the counterweight.
    """
    from cycloid_mj.measure.vibration import measure_vibration

    speeds = [speed * math.pi / 30.0 for speed in speed_rpm]
    chosen = designed(design, set_, [])
    found = measure_vibration(chosen, load_nm, speeds, turns, quick, told("vibration", quiet))
    return deliver([found], out, json, quiet, no_log)
