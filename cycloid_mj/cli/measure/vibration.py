"""``cycloid-mj measure vibration``: accelerations, housing force and unbalance over crank speed."""

from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import DesignFlag, JsonFlag, SetFlag
from cycloid_mj.cli.measure.deliver import deliver, told
from cycloid_mj.cli.measure.flags import (
    OUT,
    LoadedFlag,
    NoLogFlag,
    OutFlag,
    QuietFlag,
    SpeedsFlag,
    TurnsFlag,
    prepared,
    rad_per_second,
    sound,
)

EXAMPLES = """Examples:
  cycloid-mj measure vibration --design nonpin
  cycloid-mj measure vibration --design pin --speed-rpm 500 3000 --json"""

QuickFlag = Annotated[bool, Parameter(help="At the design's speed only, and no runs with half the step.")]


def vibration(
    *,
    design: DesignFlag = "pin",
    set_: SetFlag = (),
    load_nm: LoadedFlag = None,
    speed_rpm: SpeedsFlag = (),
    turns: TurnsFlag = 1,
    quick: QuickFlag = False,
    out: OutFlag = OUT,
    no_log: NoLogFlag = False,
    json: JsonFlag = False,
    quiet: QuietFlag = False,
) -> int:
    """Measure the vibration of gear, output and housing over crank speed.

    The rms and the spectrum of the accelerations of the gear's centre and the
    output about the closed form, and of the force on the housing, unloaded and
    loaded; the unbalance with and without the counterweight. The design's own
    speed is always run.
    """
    from cycloid_mj.measure import vibration as measure_vibration

    chosen, into = sound(design, set_), prepared(out)
    speeds = rad_per_second(speed_rpm)
    found = measure_vibration(chosen, load_nm, speeds, turns, quick, told("vibration", quiet))
    return deliver([found], into, json, quiet, no_log)
