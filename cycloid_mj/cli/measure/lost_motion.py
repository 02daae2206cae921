"""``cycloid-mj measure lost-motion``: hysteresis, lost motion and torsional stiffness at locked crank angles."""

from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import DesignFlag, JsonFlag, SetFlag
from cycloid_mj.cli.measure.deliver import deliver, told
from cycloid_mj.cli.measure.flags import OUT, NoLogFlag, OutFlag, QuietFlag, prepared, sound, torque_flag

EXAMPLES = """Examples:
  cycloid-mj measure lost-motion --design pin
  cycloid-mj measure lost-motion --design nonpin --load-nm 30 --quick
  cycloid-mj measure lost-motion --design pin --set 'ring.pins="fixed"' --json"""

FEWEST, QUICK = 6, 2

LoadFlag = Annotated[float | None, torque_flag("Largest torque of the loop, of which lost motion is read at 3 %")]
QuickFlag = Annotated[bool, Parameter(help=f"{QUICK} crank angles instead of {FEWEST}.")]


def lost_motion(
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
    """Measure hysteresis, lost motion and torsional stiffness at locked crank angles.

    A slow torque at the output goes up to the rated torque and back, both
    ways, at 6 crank angles over the turn and over the mesh period: the design
    as it is, then without friction and weight. Lost motion is read at +-3 % of
    the rated torque, as the makers of reducers do, stiffness from 50 to 100 %,
    backlash at zero. Beside them stands an independent static balance of all
    contacts. The share of output pins, cam and teeth is told apart.
    """
    from cycloid_mj.measure import lost_motion as measure_lost_motion

    chosen, into = sound(design, set_), prepared(out)
    found = measure_lost_motion(chosen, load_nm, quick=quick, progress=told("lost motion", quiet))
    return deliver([found], into, json, quiet, no_log)
