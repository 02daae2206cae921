"""``cycloid-mj measure efficiency``: efficiency over torque and speed, losses by pair, back-driving."""

import math
from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import LOAD, SPEED, DesignFlag, JsonFlag, Quantity, SetFlag, designed
from cycloid_mj.cli.measure.deliver import LogFlag, OutFlag, QuietFlag, deliver, told
from cycloid_mj.errors import UsageError

EXAMPLES = """Examples:
  cycloid-mj measure efficiency --design pin
  cycloid-mj measure efficiency --design nonpin --torques-nm 5 20 36 --speeds-rpm 500 3000
  cycloid-mj measure efficiency --design pin --quick --json"""

TorquesFlag = Annotated[
    tuple[float, ...],
    Parameter(
        metavar="X",
        consume_multiple=True,
        help="Output torques of the map [N m], above 0. Default: a quarter, half and all of the rated torque, "
        "drive.torque_nm times the ratio (36.68 in the presets).",
    ),
]
SpeedsFlag = Annotated[
    tuple[float, ...],
    Parameter(
        metavar="X",
        consume_multiple=True,
        help="Crank speeds of the map [rpm], above 0. Default: 0.5, 1 and 1.5 of the design's.",
    ),
]
QuickFlag = Annotated[
    bool, Parameter(help="Shorter averages, no run with half the step, and by default the rated point alone.")
]


def efficiency(
    *,
    design: DesignFlag = "pin",
    set_: SetFlag = (),
    torques_nm: TorquesFlag = (),
    speeds_rpm: SpeedsFlag = (),
    quick: QuickFlag = False,
    out: OutFlag = None,
    no_log: LogFlag = False,
    json: JsonFlag = False,
    quiet: QuietFlag = False,
) -> int:
    """Measure the efficiency over torque and speed, and where the losses go.

    Friction by kind of pair and the work of the normal forces, which add up
    with input and output power to the residual that is told. Then the torque
    without a load, and from the output: from rest, at speed with the crank
    free, and against the rated torque on the crank. Beside the efficiency
    stand ideal load sharing with Coulomb friction, and the formula of Wang et
    al. 2016 at the same friction.
    """
    from cycloid_mj.measure.efficiency import measure_efficiency

    chosen = designed(design, set_, [])
    _require("--torques-nm", LOAD, torques_nm)
    _require("--speeds-rpm", SPEED, speeds_rpm)
    found = measure_efficiency(
        chosen, torques_nm, [rpm * math.pi / 30.0 for rpm in speeds_rpm], quick, told("efficiency", quiet)
    )
    return deliver([found], out, json, quiet, no_log)


def _require(flag: str, quantity: Quantity, values: tuple[float, ...]) -> None:
    """Refuse values that are not above zero or beyond the limits that they have in the design file."""
    for value in values:
        try:
            quantity.require(value)
        except ValueError as error:
            raise UsageError(f"{flag} {value:g}: each value {error}") from error
        if value <= 0.0:
            raise UsageError(f"{flag} {value:g}: each value must be more than 0")
