"""``cycloid-mj measure efficiency``: efficiency over torque and speed, losses by pair, back-driving."""

from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import LOAD, DesignFlag, JsonFlag, SetFlag
from cycloid_mj.cli.measure.deliver import deliver, told
from cycloid_mj.cli.measure.flags import (
    OUT,
    NoLogFlag,
    OutFlag,
    QuietFlag,
    SpeedsFlag,
    prepared,
    rad_per_second,
    several,
    sound,
)
from cycloid_mj.papers import published_torques

EXAMPLES = """Examples:
  cycloid-mj measure efficiency --design pin
  cycloid-mj measure efficiency --design nonpin --load-nm 5 20 36 --speed-rpm 500 3000
  cycloid-mj measure efficiency --design pin --quick --json"""

LoadsFlag = Annotated[
    tuple[float, ...],
    several(
        LOAD,
        "Output torques of the map",
        "Default: a quarter, half and all of the rated torque, drive.torque_nm times the ratio (36.68 in the presets).",
    ),
]
QuickFlag = Annotated[
    bool, Parameter(help="Shorter averages, no run with half the step, and by default the rated point alone.")
]


def efficiency(
    *,
    design: DesignFlag = "pin",
    set_: SetFlag = (),
    load_nm: LoadsFlag = (),
    speed_rpm: SpeedsFlag = (),
    quick: QuickFlag = False,
    out: OutFlag = OUT,
    no_log: NoLogFlag = False,
    json: JsonFlag = False,
    quiet: QuietFlag = False,
) -> int:
    """Measure the efficiency over torque and speed, and where the losses go.

    Friction by kind of pair and the work of the normal forces, which add up
    with input and output power to the residual that is told. Then the torque
    without a load, and from the output: from rest, at speed with the crank
    free, and against the rated torque on the crank. Beside the efficiency
    stand ideal load sharing with Coulomb friction, and the formula of Wang et
    al. 2016 at the same friction. The efficiency builds up from teeth, cam,
    output and seals, and each input that is assumed (play, the cam, friction,
    creep speed, damping) is varied alone: how far the efficiency moves with
    them stands beside its numerical error.
    """
    from cycloid_mj.measure import efficiency as measure_efficiency

    chosen, into = sound(design, set_), prepared(out)
    speeds, progress = rad_per_second(speed_rpm), told("efficiency", quiet)
    found = measure_efficiency(chosen, load_nm, speeds, quick, progress, published_torques(chosen))
    return deliver([found], into, json, quiet, no_log)
