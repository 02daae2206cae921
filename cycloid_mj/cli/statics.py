"""``cycloid-mj statics``: the figures of a data sheet, without a simulation."""

from collections.abc import Mapping, Sequence
from math import isnan
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_mj.base.outcome import Outcome, headline
from cycloid_mj.base.result import Quantity, Table
from cycloid_mj.base.text import four_digits
from cycloid_mj.cli.delivery import claim_destination, deliver
from cycloid_mj.cli.flags import DELIVERY, FLAT, LOADED, RATED, Delivery, DesignOptions
from cycloid_mj.design import Inheritance
from cycloid_mj.reducer import reducer_of

if TYPE_CHECKING:
    from cycloid_mj.figures.film_map import MapPoint
    from cycloid_mj.statics.sheet import Sheet

EXAMPLES = """Examples:
  cycloid-mj statics --design pin
  cycloid-mj statics --design nonpin --load-nm 20 --set clearance.tooth_um=3
  cycloid-mj statics --design my.toml --set errors.hole_position_um=2 --json"""

HEADLINE = (
    *("backlash", "lost_motion_ideal", "stiffness_ideal"),
    *("output_peak_to_peak_unloaded_forward_speed", "output_peak_to_peak_loaded_forward_speed"),
    *("pin_gear_peak_force", "tooth_peak_force", "cam_peak_force", "output_peak_force"),
    *("capacity", "capacity_shakedown", "efficiency", "back_driving_efficiency"),
    *("crank_bearing_force", "crank_bearing_mean_force", "te_ideal"),
)
"""Keys of the figures that one looks for first; a design's ring has pins or teeth."""

HEADER = ("quantity", "value", "unit", "known difference", "parts")

SOURCES = {
    "given": "--load-nm",
    "load.torque_nm": "load.torque_nm of the design",
    "rated torque": "the nominal torque, drive.torque_nm times the ratio",
}

LoadFlag = Annotated[
    float | None,
    Parameter(
        metavar="X",
        validator=LOADED.require,
        help="Output torque [N m], greater than 0. Default: the magnitude of load.torque_nm, or if that is 0 "
        f"the {RATED}.",
    ),
]


MapFlag = Annotated[
    bool,
    Parameter(
        name="--map",
        negative="",
        help='With friction.law = "film": efficiency over torque, speed and temperature, and starting, no-load and '
        "back-driving torque, with intervals.",
    ),
]


def statics(
    design_options: Annotated[DesignOptions, FLAT],
    *,
    load_nm: LoadFlag = None,
    map_: MapFlag = False,
    output_flags: Annotated[Delivery, FLAT] = DELIVERY,
) -> int:
    """Compute data-sheet figures without a simulation, in a second.

    The figures are backlash, lost motion and torsional stiffness; transmission error, loaded and unloaded, in both
    directions; forces and Hertz pressures by kind of contact; the torque at which a contact first yields; efficiency
    and losses by pair, also for back-driving. They include all clearances, manufacturing errors, modifications and
    friction of the design. Keys are those of `cycloid-mj measure` and `cycloid-mj figures`.

    Inertia is neglected, except for the centrifugal force of the disc at the crank speed. Known differences from
    simulations are printed next to each figure. With friction.law = "film", --map adds the efficiency over torque,
    speed and temperature.
    """
    from cycloid_mj.figures import quantities
    from cycloid_mj.figures.film_map import compute_film_map
    from cycloid_mj.statics.sheet import sheet

    design = design_options.resolve_checked()
    destination = claim_destination(output_flags, f"{design.name}-statics")
    loaded_design = design if load_nm is None else design.but(load={"torque": load_nm})
    static = sheet(reducer_of(design), load_nm)
    points = compute_film_map(reducer_of(design.at_reference)) if map_ else ()
    outcome = _outcome(static, quantities(reducer_of(loaded_design)), design_options.inheritance(), points)
    return deliver(outcome, destination, output_flags)


def _outcome(
    sheet: "Sheet",
    figures: Mapping[str, Quantity],
    inheritance: Inheritance | None,
    points: Sequence["MapPoint"],
) -> Outcome:
    """Convert the statics of a design to printable results: quantities, and the efficiency map if it was computed.

    `sheet` has the quantities of the static data sheet. `figures` are those of the table by keys of `cycloid-mj
    figures`, such as ``backlash_arcmin``. `inheritance` has the values that the design file takes from its preset; None
    without a file. `points` are the points of the efficiency map; empty if it was not computed.
    """
    from cycloid_mj.base.result import quantity_frame
    from cycloid_mj.figures import values_json
    from cycloid_mj.figures.film_map import map_tables
    from cycloid_mj.statics.sheet import COMPARED

    rows = []
    for quantity in sheet.quantities.values():
        known_difference = sheet.known_difference(quantity)
        value_text = "-" if quantity.value != quantity.value else four_digits(quantity.value)
        if quantity.low is not None and quantity.high is not None:
            value_text = f"{quantity.value:.4g} ({quantity.low:.4g} to {quantity.high:.4g})"
        rows.append(
            (
                quantity.name,
                value_text,
                quantity.unit,
                "" if known_difference is None else f"{100.0 * known_difference:g} %",
                sheet.parts,
            )
        )
    return Outcome(
        title=f"statics: {sheet.design}",
        condition=sheet.condition,
        headline=headline(item for key, item in sheet.quantities.items() if key in HEADLINE),
        tables=[
            Table(f"statics: {sheet.design}, {sheet.condition}", HEADER, tuple(rows)),
            Table("figures by their keys: see `cycloid-mj figures`", ("key", "value", "unit"), _by_key(figures)),
            *(map_tables(points) if points else ()),
        ],
        summary=[f"{item.name}: {item.note}" for item in sheet.quantities.values() if item.low is not None],
        notes=[
            f"load: {SOURCES[sheet.load_source]}",
            *([inheritance.note] if inheritance and inheritance.note else []),
            *(f"{item.name}: {item.note}" for item in sheet.quantities.values() if item.note and item.low is None),
            *([f"known difference: the largest, relative, from {COMPARED}"] if sheet.has_known_differences else []),
            *(f"assumed: {sentence}" for sentence in sheet.assumptions),
        ],
        frame=quantity_frame(sheet.quantities),
        result=sheet.as_json()
        | {"figures": values_json(figures)}
        | ({"map": [point.as_json() for point in points]} if points else {}),
    )


def _by_key(figures: Mapping[str, Quantity]) -> tuple[tuple[str, str, str], ...]:
    return tuple(
        (key, "-" if isnan(figure.value) else four_digits(figure.value), figure.unit) for key, figure in figures.items()
    )
