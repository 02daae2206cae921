"""``cycloid-mj datasheet``: what a maker's catalogue tells of a reducer, as two pages to print and one to read."""

from typing import Annotated

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError
from cycloid_mj.cli.flags import FLAT, PRESET, ForceFlag, JsonFlag, PresetOptions
from cycloid_mj.cli.outfile import folder
from cycloid_mj.cli.terminal import say, say_json
from cycloid_mj.reducer import Reducer

RUNS = "runs"

OutFlag = Annotated[
    str,
    Parameter(metavar="DIR", help=f"Folder of NAME-datasheet.pdf and .html. Default: {RUNS}."),
]
LifeFlag = Annotated[float, Parameter(help="Hours that the rated torque is for. Default: 6000.")]

EXAMPLES = """Examples:
  cycloid-mj datasheet --design pin
  cycloid-mj datasheet --design my.toml --out sheets --life-h 10000"""


def datasheet(
    chosen: Annotated[PresetOptions, FLAT] = PRESET,
    *,
    out: OutFlag = RUNS,
    life_h: LifeFlag = 6000.0,
    force: ForceFlag = False,
    json: JsonFlag = False,
) -> int:
    """Write a data sheet, as makers of reducers do: two pages as PDF, and one as HTML.

    Rated torque for 6000 h, solved for with the items of `rate`, momentary torque,
    lost motion, stiffness, efficiency, backlash, mass, inertia, curves, and a
    dimensioned drawing. Every number is this model's, by statics, and has its
    condition beside it.
    """
    from cycloid_mj.base.whole import write_whole
    from cycloid_mj.life.datasheet import datasheet as computed
    from cycloid_mj.plots.datasheet import datasheet_pages
    from cycloid_mj.plots.save import document
    from cycloid_mj.report.datasheet import datasheet_page

    if not 0.0 < life_h < float("inf"):
        raise UsageError(f"--life-h {life_h:g}: give a number more than 0")
    design = chosen.sound()
    pdf, html = (f"{design.name}-datasheet.{form}" for form in ("pdf", "html"))
    into = folder(out, "the data sheet", (pdf, html), force)
    sheet = computed(Reducer(design), life_h)
    files = {into / pdf: document(datasheet_pages(sheet)), into / html: datasheet_page(sheet).encode()}
    write_whole(files)
    if json:
        say_json(sheet.as_json() | {"files": [str(path) for path in files]})
        return 0
    for path in files:
        say(str(path))
    return 0
