"""``cycloid-mj measure lost-motion``: hysteresis, lost motion and torsional stiffness at locked crank angles."""

from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import DesignFlag, JsonFlag, SetFlag, designed
from cycloid_mj.cli.measure.backlash import FEWEST, QUICK, QuickFlag
from cycloid_mj.cli.measure.deliver import LogFlag, OutFlag, QuietFlag, deliver, told
from cycloid_mj.errors import UsageError

EXAMPLES = """Examples:
  cycloid-mj measure lost-motion --design pin
  cycloid-mj measure lost-motion --design nonpin --rated-nm 30 --quick
  cycloid-mj measure lost-motion --design pin --set 'ring.pins="fixed"' --json"""

MOST = 1e7

RatedFlag = Annotated[
    float | None,
    Parameter(
        metavar="X",
        help="Rated torque at the output [N m], more than 0. Default: the rated input torque, drive.torque_nm, times "
        "the ratio.",
    ),
]


def lost_motion(
    *,
    design: DesignFlag = "pin",
    set_: SetFlag = (),
    rated_nm: RatedFlag = None,
    out: OutFlag = None,
    quick: QuickFlag = False,
    json: JsonFlag = False,
    quiet: QuietFlag = False,
    no_log: LogFlag = False,
) -> int:
    """Measure hysteresis, lost motion and torsional stiffness at locked crank angles.

    A slow torque at the output goes up to the rated torque and back, both
    ways, at 8 crank angles over the turn and over the mesh period: the design
    as it is, then without friction and weight. Lost motion is read at +-3 % of
    the rated torque, as the makers of reducers do, stiffness from 50 to 100 %,
    backlash at zero. Beside them stands an independent static balance of all
    contacts. The share of output pins, cam and teeth is told apart.
    """
    if rated_nm is not None and not 0.0 < rated_nm < MOST:
        raise UsageError(f"--rated-nm {rated_nm:g}: must be more than 0 and less than {MOST:g} [N m]")
    chosen = designed(design, set_, [])
    from cycloid_mj.checks import require_sound
    from cycloid_mj.measure.lost_motion import measure_lost_motion

    require_sound(chosen)
    found = measure_lost_motion(chosen, rated_nm, QUICK if quick else FEWEST, told("lost motion", quiet))
    return deliver([found], out, json, quiet, no_log)
