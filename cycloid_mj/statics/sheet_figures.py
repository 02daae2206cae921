"""Definitions of the figures of the static sheet: key, unit, name, definition, and which designs have them."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Literal

from cycloid_mj.base.result import Quantity
from cycloid_mj.design.layouts import BOTH, CENTRAL, RV, Layout
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.film_spread import Spread

SheetPart = Literal["motions", "errors", "loads", "losses"]

CASES = {"unloaded": 0.01, "loaded": 1.0}
"""Shares of the load for the transmission error, by the name of the case, as in `measure te`."""

DIRECTIONS = {"forward": 1.0, "reverse": -1.0}
"""Signs of the crank's speed, by name."""

SHAFTS = ("gear", "output")
"""Parts with a transmission error."""

COMPLIANT = {
    "output": "output pins",
    "cam": "cam",
    "mesh": "teeth, pins and sockets",
    "bending": "bending of the output pins",
    "carrier": "torsion of the carrier",
    "shaft": "torsion of the crank",
    "housing": "torsion of the housing",
}
"""Elastic parts in series -> words."""

CONTACTS = {
    "pin_gear": "disc on a ring pin",
    "pin_socket": "ring pin in its socket",
    "pin_sleeve": "sleeve on its ring pin",
    "tooth": "disc on a lobe of the ring",
    "cam": "cam in the bore of its disc",
    "output": "output pin in a hole",
}
"""Kinds of contacts -> words."""

BEARINGS = {
    "shaft_bearing_far": "shaft bearing far from the discs",
    "shaft_bearing_near": "shaft bearing near the discs",
    "output_bearing_far": "bearing of the output disc next to the motor",
    "output_bearing_near": "bearing of the output disc away from the motor",
}
"""Bearings of drives with several discs -> words."""

INERTIA_SHARE = "inertia_torque_share"

_IDEAL = "without friction and weight, at a locked crank: mean over a turn"
_TURN = "over a turn of the crank (RV reducer: of the carrier)"
_LOADED = f"under the load, with friction, {_TURN}"
_AT_SPEED = "under the load at the design's speed"


@dataclass(frozen=True)
class SheetFigure:
    """A figure of the static sheet.

    Attributes
    ----------
    key, unit, name
        Key in the sheet, unit as printed, and name in words.
    definition
        Definition and condition, in a sentence.
    catalogue_key
        Key in the catalogue of figures; by default the key with its unit.
    exists
        Returns whether a reducer has the figure.
    layouts
        Layouts of reducers that have the figure.
    part
        Part of the sheet that has the figure.
    """

    key: str
    unit: str
    name: str
    definition: str
    catalogue_key: str = ""
    exists: Callable[[Reducer], bool] = lambda _: True
    layouts: tuple[Layout, ...] = CENTRAL
    part: SheetPart = "motions"


def _has_springs(reducer: Reducer) -> bool:
    return reducer.design.structure == "springs"


def _has_several_discs(reducer: Reducer) -> bool:
    return reducer.design.gear.discs > 1


def _has_two_output_discs(reducer: Reducer) -> bool:
    return _has_several_discs(reducer) and reducer.design.output.support == "both_ends"


def _has_contact(kind: str) -> Callable[[Reducer], bool]:
    return lambda reducer: kind in reducer.design.pair_kinds


def _has_disc(disc_number: int) -> Callable[[Reducer], bool]:
    return lambda reducer: reducer.design.gear.discs >= max(disc_number, 2)


# fmt: off
def _motion_rows() -> Iterator[SheetFigure]:
    """Yield the catalogue entries of backlash, lost motion, stiffness and compliances (key, name, unit, definition)."""
    yield SheetFigure(
        "backlash", "arcmin", "backlash of the output, mean",
        "Rotation of the output from stop to stop at a locked crank, as the limit for a torque of zero: mean over a "
        "turn, without friction and weight.", layouts=BOTH)
    for suffix, extreme in (("min", "smallest"), ("max", "largest")):
        yield SheetFigure(
            f"backlash_{suffix}", "arcmin", f"backlash, {extreme} over the crank angle",
            f"{extreme.capitalize()} rotation of the output from stop to stop at any crank angle, otherwise as "
            "`backlash_arcmin`.",
            layouts=BOTH)
    yield SheetFigure(
        "lost_motion_ideal", "arcmin", "lost motion at +-3 % of the load",
        f"Rotation of the output between -3 and 3 % of the load, {_IDEAL}.", "lost_motion_arcmin", layouts=BOTH)
    definition = "Change of torque per rotation of the output, from 50 to 100 % of the load"
    yield SheetFigure(
        "stiffness_ideal", "N m/arcmin", "torsional stiffness, 50 to 100 % of the load",
        f"{definition}, {_IDEAL}.", "stiffness_nm_per_arcmin", layouts=BOTH)
    yield SheetFigure(
        "stiffness_contacts", "N m/arcmin", "torsional stiffness of the contacts only",
        f"{definition} with rigid parts, {_IDEAL}.", "stiffness_contacts_nm_per_arcmin", _has_springs)
    for part, part_text in COMPLIANT.items():
        yield SheetFigure(
            f"compliance_{part}", "arcmin/(N m)", f"compliance of {part_text}, in series",
            f"Rotation of the output per torque due to the compliance of {part_text} only, {_IDEAL}.",
            f"compliance_{part}_arcmin_per_nm",
            (lambda _: True) if part in ("output", "cam", "mesh") else _has_springs)


def _error_rows() -> Iterator[SheetFigure]:
    """Yield the catalogue entries of transmission errors of disc and output (key, name, unit, definition)."""
    for shaft in SHAFTS:
        prefix, layouts = ("", BOTH) if shaft == "output" else (f"{shaft}_", CENTRAL)
        for case, direction in product(CASES, DIRECTIONS):
            suffix, condition = f"{case}_{direction}", f"{case}, {direction}"
            angle = f"the {shaft}'s angle minus its ideal angle, {condition}, with friction, {_TURN}."
            yield SheetFigure(
                f"{shaft}_peak_to_peak_{suffix}_speed", "arcsec",
                f"transmission error, peak to peak, {shaft}, {condition}", f"Range of {angle}",
                f"{prefix}te_{suffix}_arcsec", layouts=layouts)
            yield SheetFigure(
                f"{shaft}_rms_{suffix}_speed", "arcsec",
                f"transmission error, rms about its mean, {shaft}, {condition}", f"Standard deviation of {angle}",
                f"{prefix}te_rms_{suffix}_arcsec", layouts=layouts)
        yield SheetFigure(
            f"{shaft}_reversal", "arcsec", f"mean of the {shaft}, forward minus reverse, unloaded",
            f"Mean deviation of the {shaft} from its ideal angle in forward motion minus that in reverse motion, "
            "unloaded, with friction.", layouts=layouts)
        yield SheetFigure(
            f"{shaft}_wind_up", "arcsec", f"mean of the {shaft}, loaded minus unloaded, forward",
            f"Mean deviation of the {shaft} from its ideal angle under the load minus that under 1 % of the load, "
            "in forward motion, with friction.",
            layouts=layouts)
    yield SheetFigure(
        INERTIA_SHARE, "1", "inertia torque of the load if it followed that error, over the load",
        "Inertia of the parts that rotate with the output times the second derivative of its loaded transmission "
        "error, forward, at the design's speed, divided by the load: rms over a turn; from 0.1 on, runs differ from "
        "statics.")


def _load_rows() -> Iterator[SheetFigure]:
    """Yield the catalogue entries of load shares, forces, pressures and capacities (key, name, unit, definition)."""
    for disc_number in range(1, 5):
        name = f"share of disc {disc_number} in the torque"
        yield SheetFigure(
            f"disc_{disc_number}_share", "1", name, f"Mean {name} on the output {_LOADED}.",
            exists=_has_disc(disc_number))
    for kind, pair in CONTACTS.items():
        for suffix, unit, name, definition in (
            ("peak_force", "N", "largest force", f"Largest normal force, {pair}, {_LOADED}."),
            ("mean_force", "N", "mean force of the loaded contacts", f"Mean normal force, {pair}, {_LOADED}."),
            ("carrying", "1", "loaded contacts, mean number", f"Number of loaded contacts, {pair}, {_LOADED}: mean."),
            ("pressure", "MPa", "largest Hertz pressure", f"Largest Hertz pressure, {pair}, {_LOADED}."),
            ("margin", "1", "margin against first yield", f"Pressure of first yield / largest pressure, {pair}."),
        ):
            yield SheetFigure(f"{kind}_{suffix}", unit, f"{kind}: {name}", definition, exists=_has_contact(kind),
                              layouts=BOTH if kind in ("pin_gear", "tooth") else CENTRAL)
    yield from _rv_load_rows()
    for member, (suffix, unit) in product(("shaft", "output", "ring"), (("net_force", "N"), ("tilting_moment", "N m"))):
        name = suffix.replace("_", " ")
        yield SheetFigure(
            f"{member}_{suffix}", unit, f"{name} of the discs on the {member}, largest",
            f"Largest {name} of all discs together on the {member} {_LOADED}.", exists=_has_several_discs)
    for key, pair in BEARINGS.items():
        yield SheetFigure(
            f"{key}_force", "N", f"{pair}: largest force",
            f"Largest force on the {pair} due to the forces of the discs, {_LOADED}.",
            exists=_has_two_output_discs if key.startswith("output") else _has_several_discs)
    yield SheetFigure(
        "capacity", "N m", "capacity: torque at which a contact first yields, below its surface",
        "Torque on the output at which the first contact yields below its surface.")
    yield SheetFigure(
        "capacity_shakedown", "N m", "shakedown limit: largest torque with elastic repeated rolling",
        "Torque on the output at which the first contact reaches the shakedown limit of rolling.")


def _rv_load_rows() -> Iterator[SheetFigure]:
    """Yield the catalogue entries of quantities that only RV reducers have (key, name, unit, definition).

    They are bearing and planet forces, and transmission errors.
    """
    ideal_condition = "ideal sharing by rigid parts without clearance and errors, over a turn of the carrier"
    balanced_condition = "in equilibrium of all springs with clearances and errors, over a turn of the carrier"
    for name, method, condition in (
        ("", "ideal sharing", ideal_condition),
        ("balanced_", "springs and clearances", f"{balanced_condition}, without friction"),
        ("running_", "springs, clearances and friction", f"{balanced_condition}, with friction"),
    ):
        yield SheetFigure(
            f"crank_bearing_{name}force", "N", f"largest force of a crank on a disc, {method}",
            f"Largest force of a crank on its bearing in a disc under the load: {condition}.", layouts=RV)
        yield SheetFigure(
            f"crank_bearing_{name}mean_force", "N", f"10/3-power mean force of a crank on a disc, {method}",
            f"Mean of this force F that determines the life of roller bearings, (mean F^(10/3))^(3/10): {condition}.",
            layouts=RV)
    yield SheetFigure(
        "planet_mesh_force", "N", "largest force of a planet on the sun",
        f"Largest normal force of a planet on the sun under the load: {balanced_condition}, with friction.", layouts=RV)
    yield SheetFigure(
        "te_errors", "arcsec", "transmission error by errors of cranks, bores, planets, output and pins, peak to peak",
        "Range of the output's angle at a fixed sun over a turn of the carrier, due to errors of cranks, bores, "
        "carrier and planets and run-out of the output (closed form without clearance and load), and due to position "
        "errors of the ring pins (statics under the nominal torque).", "te_errors_arcsec", layouts=RV)
    yield SheetFigure(
        "te_ideal", "arcsec", "transmission error under the load, without friction, peak to peak",
        "Range of the output's angle minus its ideal angle under the load at a fixed sun, without friction and "
        "weight, over a turn of the carrier.", "te_ideal_arcsec", layouts=RV)


def _loss_rows() -> Iterator[SheetFigure]:
    """Yield the catalogue entries of efficiencies and losses (key, name, unit, definition)."""
    yield SheetFigure(
        "efficiency", "%", "efficiency",
        "Output power divided by input power under the load, at the design's speed, without the losses in the "
        "bearings of shaft and output.", layouts=BOTH)
    for kind in ("pin_gear", "tooth", "cam", "output"):
        yield SheetFigure(
            f"{kind}_friction_power", "W", f"friction of {kind}",
            f"Mean power lost to friction, {CONTACTS[kind]}, {_AT_SPEED}.", exists=_has_contact(kind),
            layouts=BOTH if kind in ("pin_gear", "tooth") else CENTRAL)
    for key, name in (
        ("seals_power", "drag of seals and lubricant"), ("input_power", "input power"), ("output_power", "output power")
    ):
        yield SheetFigure(key, "W", name, f"{name[0].upper()}{name[1:]} {_AT_SPEED}: mean over a turn.", layouts=BOTH)
    for key, part in (("crank_bearing", "bearings of the cranks in discs and carrier"), ("planet", "planet meshes")):
        yield SheetFigure(
            f"{key}_friction_power", "W", f"friction of the {part}",
            f"Mean power lost to friction, {part}, {_AT_SPEED}.", layouts=RV)
    yield SheetFigure(
        "back_driving_torque_rated", "N m", "output torque that drives the crank against its share of the load",
        "Torque on the output that drives the crank against its share of the load; none if self-locking.")
    yield SheetFigure(
        "back_driving_efficiency", "%", "efficiency of back-driving",
        "Power of the crank divided by power of the output, if the output drives against the crank's share of the "
        "load.")
# fmt: on


def _rows_by_key(part: SheetPart, rows: Iterator[SheetFigure]) -> dict[str, SheetFigure]:
    return {row.key: replace(row, part=part) for row in rows}


SHEET_FIGURES: Mapping[str, SheetFigure] = {
    **_rows_by_key("motions", _motion_rows()),
    **_rows_by_key("errors", _error_rows()),
    **_rows_by_key("loads", _load_rows()),
    **_rows_by_key("losses", _loss_rows()),
}
"""Key -> figure of the sheet."""


def sheet_quantity(
    key: str, value: float, reference: float | None = None, source: str = "", note: str = ""
) -> Quantity:
    """Return the quantity with a `key` of `SHEET_FIGURES`; `value` and `reference` are in the unit of the key.

    `source` describes the reference, and `note` is a remark.
    """
    entry = SHEET_FIGURES[key]
    return Quantity(key, entry.name, value, entry.unit, reference=reference, source=source, note=note)


def spread_quantity(key: str, spread: Spread) -> Quantity:
    """Return the quantity with a `key` of `SHEET_FIGURES`, with its interval and the causes of its spread."""
    quantity = replace(sheet_quantity(key, spread.value), low=spread.low, high=spread.high, causes=spread.causes)
    return replace(quantity, note=quantity.interval_text)
