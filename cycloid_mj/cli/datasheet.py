"""``cycloid-mj datasheet``: a data sheet as in a manufacturer's catalogue: three pages as PDF, and one HTML page."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.outcome import Outcome, headline
from cycloid_mj.base.result import by_key, quantity_table
from cycloid_mj.cli.delivery import RUNS, Destination, claim_destination, deliver
from cycloid_mj.cli.flags import FLAT, PRESET, Delivery, PresetOptions, out_flag
from cycloid_mj.reducer import reducer_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from cycloid_mj.base.result import Quantity
    from cycloid_mj.life.datasheet import Datasheet


@dataclass(frozen=True, kw_only=True)
class Sheets(Delivery):
    """The same; the sheet is always written."""

    out: Annotated[str | None, out_flag("NAME-datasheet.pdf, .html, .json and .csv", RUNS)] = None


SHEETS = Sheets()

LifeFlag = Annotated[
    float | None, Parameter(metavar="X", help="Required life at the rated torque [h]. Default: service.life_h.")
]

EXAMPLES = """Examples:
  cycloid-mj datasheet --design pin
  cycloid-mj datasheet --design my.toml --out sheets --life-h 10000"""


def datasheet(
    design_options: Annotated[PresetOptions, FLAT] = PRESET,
    *,
    life_h: LifeFlag = None,
    output_flags: Annotated[Sheets, FLAT] = SHEETS,
) -> int:
    """Write a manufacturer-style data sheet as PDF and HTML.

    The sheet states the rated torque for a required life (service.life_h), the momentary torque, lost motion,
    stiffness, efficiency, backlash, mass and inertia, with curves and a dimensioned drawing. The rated torque is
    computed with the checks of `rate`. All values are computed by statics and stated with their conditions.
    """
    from cycloid_mj.cli.progress import count_progress
    from cycloid_mj.life.datasheet import datasheet as compute_datasheet

    if life_h is not None and not 0.0 < life_h < float("inf"):
        raise UsageError(
            f"--life-h {life_h:g} is out of range: give a finite number of hours greater than 0, e.g. --life-h 6000"
        )
    design = design_options.resolve_checked()
    stem = f"{design.name}-datasheet"
    destination = claim_destination(output_flags, stem, [f"{stem}.pdf"], RUNS, with_page=True)
    progress = count_progress("data sheet", output_flags.quiet)
    sheet = compute_datasheet(reducer_of(design), life_h or 0.0, progress)
    inheritance = design_options.inheritance()
    if inheritance and inheritance.note:
        sheet = replace(sheet, notes=(*sheet.notes, inheritance.note))
    return deliver(_outcome(sheet, destination), destination, output_flags)


HEADLINE = (
    *("ratio", "nominal_torque", "input_speed", "rated_torque", "rated_torque_toleranced"),
    *("momentary_torque", "momentary_torque_toleranced", "backlash", "backlash_with_bearings"),
    "stiffness_ideal",
    *("drive_efficiency_percent", "drive_mass_kg", "drive_length_mm"),
)
"""Keys of the quantities that the terminal shows first."""

MECHANISM = {"drive_efficiency_percent": "efficiency", "drive_mass_kg": "mass", "drive_length_mm": "length"}
"""Key of a quantity of the complete drive -> key of the same quantity of the mechanism."""


def _headline_keys(quantities: "Mapping[str, Quantity]") -> "Iterator[str]":
    """Yield the keys of `HEADLINE` that a sheet has; if it has none of the complete drive, the key of the mechanism."""
    for key in HEADLINE:
        if key in quantities:
            yield key
        elif MECHANISM.get(key) in quantities:
            yield MECHANISM[key]


def _outcome(sheet: "Datasheet", destination: Destination) -> Outcome:
    """Convert a data sheet to results for the terminal and for files: headline, tables, PDF and HTML page.

    No file is written: the outcome contains the PDF as bytes and a function that creates the page. `destination` has
    the paths of the output files.
    """
    from cycloid_mj.base.result import quantity_frame
    from cycloid_mj.plots.datasheet import datasheet_pages
    from cycloid_mj.plots.save import document
    from cycloid_mj.report.datasheet import datasheet_page

    pdf = f"{destination.stem}.pdf"
    quantities = by_key(*sheet.groups.values())
    printed_paths = [*destination.paths([pdf]), str(destination.page)]
    return Outcome(
        title=f"data sheet: {sheet.design.name}",
        condition=", ".join(filter(None, (f"rated for {sheet.life:g} h", sheet.design.thermal.words))),
        headline=headline(quantities[key] for key in _headline_keys(quantities)),
        summary=printed_paths,
        tables=[quantity_table(heading, group) for heading, group in sheet.groups.items()],
        notes=[*(f"{item.name}: {item.note}" for item in quantities.values() if item.note), *sheet.notes],
        files={pdf: document(datasheet_pages(sheet))},
        frame=quantity_frame(quantities),
        result=sheet.as_json() | {"files": printed_paths},
        page=lambda: datasheet_page(sheet),
    )
