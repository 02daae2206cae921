"""``cycloid-mj measure torque``: the output torque under a given input torque, as the paper measured it."""

from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import SPEED, JsonFlag, Quantity, SetFlag
from cycloid_mj.cli.measure.deliver import deliver, told
from cycloid_mj.cli.measure.flags import OUT, NoLogFlag, OutFlag, QuietFlag, prepared, sound
from cycloid_mj.errors import UsageError
from cycloid_mj.papers import published_torques

EXAMPLES = """Examples:
  cycloid-mj measure torque pin nonpin
  cycloid-mj measure torque --design pin --set friction.pin_gear=0.02 --quick
  cycloid-mj measure torque --torque-nm 0.5 --json"""

BOTH = ("pin", "nonpin")
TORQUE = Quantity("drive", "torque")

DesignsArgument = Annotated[
    str, Parameter(metavar="DESIGN", help="Designs: pin, nonpin, or TOML files. Default: pin and nonpin.")
]
AlsoFlag = Annotated[
    tuple[str, ...],
    Parameter(name="--design", metavar="NAME|FILE", help="A design, as by its name alone. May be repeated."),
]
QuickFlag = Annotated[
    bool,
    Parameter(help="A shorter average, no run with half the step, and only the friction of all sliding pairs varied."),
]


def torque(
    *designs: DesignsArgument,
    design: AlsoFlag = (),
    set_: SetFlag = (),
    torque_nm: Annotated[float | None, TORQUE.flag("Input torque")] = None,
    speed_rpm: Annotated[float | None, SPEED.flag("Crank speed")] = None,
    quick: QuickFlag = False,
    out: OutFlag = OUT,
    no_log: NoLogFlag = False,
    json: JsonFlag = False,
    quiet: QuietFlag = False,
) -> int:
    """Measure the output torque under the rated input torque.

    The paper's test: the crank feels a given torque, a brake holds the
    output at its speed. Mean and ripple of the output torque, its rate
    against the torque without losses, how the rate answers to the friction
    of each pair with pins free, fixed and sleeved, and which friction would
    give the paper's figures. Each input that is assumed (play, the cam,
    friction, creep speed, damping) is varied alone: how far the rate moves
    with them stands beside its numerical error. --set changes every design.
    """
    from cycloid_mj.measure import torque as measure_torque

    names = (*designs, *design) or BOTH
    values = [(TORQUE, torque_nm), (SPEED, speed_rpm)]
    chosen = [sound(name, set_, values) for name in names]
    called = [one.name for one in chosen]
    if twice := next((name for name in called if called.count(name) > 1), None):
        raise UsageError(f"two of the designs are called {twice!r}: give each a name of its own in its file")
    into = prepared(out)
    found = [measure_torque(one, quick, told(f"torque of {one.name}", quiet), published_torques(one)) for one in chosen]
    return deliver(found, into, json, quiet, no_log)
