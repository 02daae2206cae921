"""``cycloid-mj measure te``: the transmission error of gear and output."""

import math
from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import LOAD, SPEED, DesignFlag, JsonFlag, SetFlag, designed, whole, within
from cycloid_mj.cli.measure.deliver import LogFlag, OutFlag, QuietFlag, deliver, told

EXAMPLES = """Examples:
  cycloid-mj measure te --design pin --set errors.pin_position_um=2
  cycloid-mj measure te --design nonpin --quick --json"""

LoadFlag = Annotated[
    float | None,
    Parameter(
        metavar="X",
        validator=LOAD.require,
        help=f"Torque of the loaded runs [N m], {LOAD.range}. Default: the rated torque, drive.torque_nm times the "
        "ratio (36.68 in the presets).",
    ),
]
DragFlag = Annotated[
    float | None,
    Parameter(
        metavar="X",
        validator=LOAD.require,
        help=f"Torque of the unloaded runs [N m], {LOAD.range}; 0 lets the gear float in its backlash. Default: 1 % of "
        "the rated torque.",
    ),
]
SlowFlag = Annotated[
    float | None,
    Parameter(
        metavar="X",
        validator=SPEED.require,
        help="Crank speed of the slow runs [rpm]. Default: a quarter of the design's.",
    ),
]
TurnsFlag = Annotated[
    int,
    Parameter(
        metavar="N",
        converter=whole,
        validator=within(1, 1000),
        help="Crank turns of each run, from 1 to 1000. One turn of the output tells all orders apart. Default: 1.",
    ),
]
QuickFlag = Annotated[bool, Parameter(help="At speed only, and no runs with half the step.")]


def te(
    *,
    design: DesignFlag = "pin",
    set_: SetFlag = (),
    load_nm: LoadFlag = None,
    drag_nm: DragFlag = None,
    slow_rpm: SlowFlag = None,
    turns: TurnsFlag = 1,
    quick: QuickFlag = False,
    out: OutFlag = None,
    no_log: LogFlag = False,
    json: JsonFlag = False,
    quiet: QuietFlag = False,
) -> int:
    """Measure the transmission error of gear and output against crank angle.

    Over whole crank turns, in both directions, unloaded and loaded, slow and
    at speed: peak to peak, rms, what reversal and load shift, and the order
    spectrum, with the orders that errors of pins, holes and eccentricity give.
    Beside it stand the same figures from statics.
    """
    from cycloid_mj.measure.te import measure_te

    chosen = designed(design, set_, [])
    slow = None if slow_rpm is None else abs(slow_rpm) * math.pi / 30.0
    found = measure_te(chosen, load_nm, drag_nm, slow, turns, quick, told("transmission error", quiet))
    return deliver([found], out, json, quiet, no_log)
