"""``cycloid-mj measure te``: the transmission error of gear and output."""

from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import SPEED, DesignFlag, JsonFlag, SetFlag
from cycloid_mj.cli.measure.deliver import deliver, told
from cycloid_mj.cli.measure.flags import (
    OUT,
    LoadedFlag,
    NoLogFlag,
    OutFlag,
    QuietFlag,
    TurnsFlag,
    prepared,
    sound,
    torque_flag,
)

EXAMPLES = """Examples:
  cycloid-mj measure te --design pin --set errors.pin_position_um=2
  cycloid-mj measure te --design nonpin --quick --json"""

DRAG = "0 lets the gear float in its backlash. Default: 1 % of the rated torque."

DragFlag = Annotated[float | None, torque_flag("Torque of the unloaded runs", DRAG)]
SlowFlag = Annotated[
    float | None,
    Parameter(
        metavar="X",
        validator=SPEED.require,
        help=f"Crank speed of the slow runs [rpm], {SPEED.range}; both ways are run. Default: a quarter of the "
        "design's.",
    ),
]
QuickFlag = Annotated[bool, Parameter(help="At speed only, and no runs with half the step.")]


def te(
    *,
    design: DesignFlag = "pin",
    set_: SetFlag = (),
    load_nm: LoadedFlag = None,
    drag_nm: DragFlag = None,
    slow_rpm: SlowFlag = None,
    turns: TurnsFlag = 1,
    quick: QuickFlag = False,
    out: OutFlag = OUT,
    no_log: NoLogFlag = False,
    json: JsonFlag = False,
    quiet: QuietFlag = False,
) -> int:
    """Measure the transmission error of gear and output against crank angle.

    Over whole crank turns, in both directions, unloaded and loaded, slow and
    at speed: peak to peak, rms, what reversal and load shift, and the order
    spectrum, with the orders that errors of pins, holes and eccentricity give.
    Beside it stand the same figures from statics.
    """
    from cycloid_mj.measure import te as measure_te

    chosen, into = sound(design, set_), prepared(out)
    slow = None if slow_rpm is None else SPEED.unit.to_si(abs(slow_rpm))
    found = measure_te(chosen, load_nm, drag_nm, slow, turns, quick, told("transmission error", quiet))
    return deliver([found], into, json, quiet, no_log)
