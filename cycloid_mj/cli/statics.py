"""``cycloid-mj statics``: the figures of a data sheet, without a simulation."""

from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_mj.cli.flags import FLAT, LOAD, DesignOptions, JsonFlag
from cycloid_mj.cli.terminal import say, say_json, say_table
from cycloid_mj.reducer import Reducer

if TYPE_CHECKING:
    from cycloid_mj.statics.sheet import Sheet

EXAMPLES = """Examples:
  cycloid-mj statics --design pin
  cycloid-mj statics --design nonpin --load-nm 20 --set clearance.tooth_um=3
  cycloid-mj statics --design my.toml --set errors.hole_position_um=2 --json"""

HEADER = ("quantity", "value", "unit", "known difference")

SOURCES = {"given": "--load-nm", "load.torque_nm": "load.torque_nm of the design", "rated torque": "the rated torque"}

LoadFlag = Annotated[
    float | None,
    Parameter(
        metavar="X",
        validator=LOAD.require,
        help="Torque on the output [N m], more than 0. Default: the size of load.torque_nm; where that is 0 the rated "
        "torque, drive.torque_nm times the ratio (36.68 in the presets).",
    ),
]


def statics(chosen: Annotated[DesignOptions, FLAT], *, load_nm: LoadFlag = None, json: JsonFlag = False) -> int:
    """Tell what a data sheet has of a reducer, by statics, in under a second.

    Backlash, lost motion, torsional stiffness; transmission error, loaded and
    unloaded, both ways; forces and Hertz pressures by kind of contact; the
    torque at which a contact first yields; efficiency and losses by pair, and
    the same with the output as the driver. With all clearances, manufacturing
    errors, modification and friction of the design, under the keys that
    `cycloid-mj measure` has in its JSON.

    Nothing is simulated: the crank turns so slowly that of inertia only the
    gear's centrifugal force counts. Beside each figure stands how far dynamic
    runs are known to differ from it.
    """
    from cycloid_mj.checks import require_sound
    from cycloid_mj.statics.sheet import sheet

    design = chosen.resolved()
    reducer = Reducer(design)
    require_sound(reducer)
    found = sheet(reducer, load_nm)
    if json:
        say_json(found.as_json())
    else:
        _print(found)
    return 0


def _print(found: "Sheet") -> None:
    from cycloid_mj.statics.sheet import COMPARED, known_difference

    rows = []
    for one in found.quantities.values():
        known = known_difference(one)
        value = "-" if one.value != one.value else f"{one.value:.6g}"
        rows.append((one.name, value, one.unit, "" if known is None else f"{100.0 * known:g} %"))
    say_table(f"statics: {found.design}, {found.condition}", HEADER, rows)
    say(f"load: {SOURCES[found.load_source]}")
    for one in found.quantities.values():
        if one.note:
            say(f"{one.name}: {one.note}")
    say(f"known difference: the largest, relative, from {COMPARED}")
    for sentence in found.assumptions:
        say(f"assumed: {sentence}")
