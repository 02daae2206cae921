"""``cycloid-mj measure loads``: what every part carries, its Hertz pressure, and which part limits the torque."""

from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import DesignFlag, JsonFlag, SetFlag
from cycloid_mj.cli.measure.deliver import deliver, told
from cycloid_mj.cli.measure.flags import OUT, NoLogFlag, OutFlag, QuietFlag, prepared, sound, torque_flag

EXAMPLES = """Examples:
  cycloid-mj measure loads --design pin
  cycloid-mj measure loads --design nonpin --load-nm 20 --json"""

LoadFlag = Annotated[float | None, torque_flag("Torque on the output")]
QuickFlag = Annotated[bool, Parameter(help="Two mesh periods instead of a whole turn of the crank.")]


def loads(
    *,
    design: DesignFlag = "pin",
    set_: SetFlag = (),
    load_nm: LoadFlag = None,
    quick: QuickFlag = False,
    out: OutFlag = OUT,
    no_log: NoLogFlag = False,
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
    from cycloid_mj.measure import loads as measure_loads

    chosen, into = sound(design, set_), prepared(out)
    return deliver([measure_loads(chosen, load_nm, quick, told("loads", quiet))], into, json, quiet, no_log)
