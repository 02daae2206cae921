"""``cycloid-mj measure backlash``: the output's backlash at locked crank angles, whole and by each clearance alone."""

from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import DesignFlag, JsonFlag, SetFlag
from cycloid_mj.cli.measure.deliver import deliver, told
from cycloid_mj.cli.measure.flags import OUT, NoLogFlag, OutFlag, QuietFlag, prepared, sound

EXAMPLES = """Examples:
  cycloid-mj measure backlash --design pin
  cycloid-mj measure backlash --design nonpin --set clearance.tooth_um=5
  cycloid-mj measure backlash --design pin --set errors.pin_position_um=0.3 --json"""

FEWEST, QUICK = 8, 2

QuickFlag = Annotated[bool, Parameter(help=f"{QUICK} crank angles instead of {FEWEST}.")]


def backlash(
    *,
    design: DesignFlag = "pin",
    set_: SetFlag = (),
    quick: QuickFlag = False,
    out: OutFlag = OUT,
    no_log: NoLogFlag = False,
    json: JsonFlag = False,
    quiet: QuietFlag = False,
) -> int:
    """Measure the backlash of the output at locked crank angles.

    A small torque presses the output to either stop, at 8 crank angles over
    the turn and over the mesh period, without friction and weight. Then the
    same with each clearance alone: teeth, pin sockets or sleeves, cam, output
    pins. Beside it stand the closed forms: for each clearance alone, and for
    all together a linear programme of rigid contacts, manufacturing errors
    included.
    """
    from cycloid_mj.measure import backlash as measure_backlash

    chosen, into = sound(design, set_), prepared(out)
    found = measure_backlash(chosen, quick=quick, progress=told("backlash", quiet))
    return deliver([found], into, json, quiet, no_log)
