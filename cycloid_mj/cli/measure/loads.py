"""``cycloid-mj measure loads``: what every part carries, its Hertz pressure, and which part limits the torque."""

from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import LOAD, DesignFlag, JsonFlag, SetFlag, designed
from cycloid_mj.cli.measure.deliver import LogFlag, OutFlag, QuietFlag, deliver, told
from cycloid_mj.cli.simulate import require_possible

EXAMPLES = """Examples:
  cycloid-mj measure loads --design pin
  cycloid-mj measure loads --design nonpin --load-nm 20 --json"""

LoadFlag = Annotated[
    float | None,
    Parameter(
        metavar="X",
        validator=LOAD.require,
        help=f"Torque on the output [N m], {LOAD.range}. Default: the rated torque, drive.torque_nm times the ratio "
        "(36.68 in the presets).",
    ),
]
QuickFlag = Annotated[bool, Parameter(help="Two mesh periods instead of a whole turn of the crank.")]


def loads(
    *,
    design: DesignFlag = "pin",
    set_: SetFlag = (),
    load_nm: LoadFlag = None,
    quick: QuickFlag = False,
    out: OutFlag = None,
    no_log: LogFlag = False,
    json: JsonFlag = False,
    quiet: QuietFlag = False,
) -> int:
    """Measure the force on each pin, tooth, output pin and the cam against crank angle.

    At a given output torque and the design's speed, over a turn of the crank:
    peaks, means, the angle of the peak, beside ideal sharing; Hertz pressure
    with the local relative curvature and the margin against the material's
    yield for each kind of contact; and the capacity: which part limits the
    torque, and at what torque.
    """
    from cycloid_mj.measure.loads import measure_loads

    chosen = designed(design, set_, [])
    require_possible(chosen)
    return deliver([measure_loads(chosen, load_nm, quick, told("loads", quiet))], out, json, quiet, no_log)
