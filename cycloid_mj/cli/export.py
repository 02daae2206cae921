"""``cycloid-mj export``: the parts of a design as files for CAD and printing."""

from dataclasses import asdict
from typing import Annotated, Literal

from cyclopts import Parameter

from cycloid_mj.cli.flags import FLAT, DesignOptions, JsonFlag, within
from cycloid_mj.cli.outfile import folder
from cycloid_mj.cli.terminal import say, say_json, say_table

EXAMPLES = """Examples:
  cycloid-mj export --design pin --format stl
  cycloid-mj export --design nonpin --format dxf --out drawings
  cycloid-mj export --design my.toml --set clearance.tooth_um=20 --format step"""

SMALLEST_UM, LARGEST_UM = 0.001, 100.0

FormatFlag = Annotated[
    Literal["stl", "obj", "dxf", "step"],
    Parameter(
        name="--format",
        help="stl, obj: meshes; dxf: outlines with one spline a lobe; step: solids (needs the extra cad: pip install "
        "'cycloid-mj[cad]'). All in mm.",
    ),
]
OutFlag = Annotated[
    str | None,
    Parameter(
        metavar="DIR",
        help="Folder for the parts, made if there is none; parts that it holds are replaced. "
        "Default: <design>-<format>.",
    ),
]
ChordFlag = Annotated[
    float,
    Parameter(
        metavar="X",
        validator=within(SMALLEST_UM, LARGEST_UM),
        help="Largest distance of a mesh's edges from the true outline [um], for stl and obj. Default: 1.",
    ),
]


def export(
    *,
    chosen: Annotated[DesignOptions, FLAT],
    format_: FormatFlag,
    out: OutFlag = None,
    chord_error_um: ChordFlag = 1.0,
    json: JsonFlag = False,
) -> int:
    """Write every part of a design for CAD or printing.

    Parts: housing, shaft, gear, output, and pin (one of N) where the ring has
    pins. Several discs are gear_1, gear_2, ..., on a crank built up of the
    shaft, cam_1, cam_2, ... and spacer. The outlines contain the clearances that the design asks for; what
    they really contain is measured and told. A part that is not watertight, or
    has the wrong volume or clearance, is an error and writes nothing.
    """
    from cycloid_mj.export import export as exported
    from cycloid_mj.whole import write_whole

    design = chosen.sound()
    made = exported(design, format_, chord_error_um * 1e-6)
    into = folder(f"{design.name}-{format_}" if out is None else out, "the parts")
    files = {into / name: content for name, content in made.files.items()}
    write_whole(files)
    paths = list(files)
    if json:
        say_json({"files": [str(path) for path in paths], "clearances": [asdict(one) for one in made.clearances]})
        return 0
    for path in paths:
        say(str(path))
    rows = [
        (one.pair, *(f"{1e6 * value:.4f}" for value in (one.asked, one.least, one.most))) for one in made.clearances
    ]
    say_table("clearance in the outlines [um]", ("pair", "asked for", "least", "most"), rows)
    return 0
