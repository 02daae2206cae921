"""The data sheet of a reducer as manufacturers publish it, each figure with its condition."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import count
from typing import Any

import numpy as np

from cycloid_mj.base.arguments import require_number
from cycloid_mj.base.engine import Progress, silent
from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.frame import Frame
from cycloid_mj.base.names import PIN
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.base.result import Curve, Quantity, quantity_frame
from cycloid_mj.base.units import ARCMINUTE, KG_CM2, RPM
from cycloid_mj.design import PARTS, Design, Named, resolve
from cycloid_mj.design.layouts import applies
from cycloid_mj.explore.tolerance_zones import has_tolerances
from cycloid_mj.figures import figure, quantities, values_json
from cycloid_mj.life.as_built import SETTINGS
from cycloid_mj.life.bearings import bearing_losses
from cycloid_mj.life.duty import DutyPoint, constant_duty
from cycloid_mj.life.heat import describe_cooling, describe_duty
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.items import rate, rate_at_rated_load
from cycloid_mj.life.loading import solve_loading
from cycloid_mj.life.no_load import grease_of
from cycloid_mj.life.output_bearing import output_bearings
from cycloid_mj.life.rated import (
    is_bearing_life,
    is_strength,
    momentary_torque,
    rated_and_momentary_torque,
    rated_torque,
)
from cycloid_mj.life.rv_sheet_rows import (
    compute_rv_limits,
    rv_efficiency_curve,
    rv_further_groups,
    rv_notes,
    rv_performance_groups,
    rv_wind_up_curve,
    toleranced_error_rows,
)
from cycloid_mj.life.sheet_rows import (
    backlash_with_bearings,
    describe_speed,
    environment_rows,
    figure_row,
    hysteresis,
    mounting_rows,
    no_load_curves,
    nominal_torque_row,
    ratio_row,
    thermal_torque_row,
    torques_without_load,
    warm_text,
    with_interval,
    with_name,
)
from cycloid_mj.life.steady_state import at_steady_temperatures
from cycloid_mj.life.thermal import thermal
from cycloid_mj.parts import body_solids, input_inertia, mass_properties, parts
from cycloid_mj.parts.accuracy import VISUAL_CHORD_ERROR
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.parts.export.drive import has_casing
from cycloid_mj.parts.rv import axial_layout
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.statics import loads, powers, springs_of
from cycloid_mj.statics.film import film_text
from cycloid_mj.statics.sheet import Sheet, sampled_efficiency, sampled_losses, sheet, sheet_part
from cycloid_mj.statics.springs import at_rest


@dataclass(frozen=True)
class SheetCurveSettings:
    """Points of the curves.

    Attributes
    ----------
    crank_angles, rtol
        Number of crank angles, and relative accuracy of a rated torque.
    speed_shares, torque_shares, torsion_shares
        Speeds of the rated torque, and torques of efficiency and torsion, over the design's speed and nominal torque.
    """

    crank_angles: int = 61
    rtol: float = 2e-3
    speed_shares: tuple[float, ...] = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0)
    torque_shares: tuple[float, ...] = (0.05, 0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.25)
    torsion_shares: tuple[float, ...] = (0.01, 0.03, 0.1, 0.25, 0.5, 0.75, 1.0)


CURVES = SheetCurveSettings()


DRIVE_FIGURES = {
    "drive_mass_kg": ("Mass", "with covers, bearings and screws, without motor and grease"),
    "drive_inertia_kg_cm2": ("Inertia at the input", "with hub and flange of the output, without the motor"),
    "drive_length_mm": ("Overall length", "from motor flange to output flange"),
    "drive_diameter_mm": ("Overall diameter", "of the covers"),
}
"""Key of a figure of the complete drive -> name and condition."""


BY_GEOMETRY_ALONE = ("ratio", "nominal_torque", "input_speed", "output_speed", "largest_speed_rpm")
"""Keys of quantities in the groups of loads and motions that do not depend on the errors of the parts."""


@dataclass(frozen=True, repr=False)
class Datasheet(Presented):
    """The data sheet of one design.

    Attributes
    ----------
    design
        The design.
    life
        Life for which the torque is rated [h].
    groups
        Heading -> quantities; the note of each is its condition.
    curves
        Curves of the panels, in their order.
    notes
        Assumptions, a sentence each.
    figures
        Figures of geometry and statics of the catalogue, by key.
    weakest
        The item that limits the rated torque.
    """

    design: Design
    life: float
    groups: dict[str, tuple[Quantity, ...]]
    curves: tuple[Curve, ...]
    notes: tuple[str, ...]
    figures: Mapping[str, Quantity]
    weakest: RatedItem

    @property
    def frame(self) -> Frame:
        """The quantities, a row each."""
        return quantity_frame({item.key: item for group in self.groups.values() for item in group})

    @property
    def line(self) -> str:
        """Design, rated torque, life, and the item that limits the torque."""
        torque = self.value("rated_torque")
        return f"{self.design.name}, rated torque {torque:.4g} N m for {self.life:g} h, limited by {self.weakest.name}"

    def value(self, key: str) -> float:
        """Return the value of a quantity."""
        return next(item.value for group in self.groups.values() for item in group if item.key == key)

    @property
    def diameter(self) -> float:
        """Overall diameter [mm], with the covers if the drive has any."""
        sizes = {item.key: item.value for item in self.groups.get("Mass and size", ())}
        return sizes.get("drive_diameter_mm", 2e3 * self.design.housing.outer_radius)

    def as_json(self) -> dict[str, Any]:
        """Convert the data sheet to JSON values.

        Keys are ``design`` (its name), ``rated_torque_nm``, ``life_h``, ``momentary_torque_nm``, ``lubricant``,
        ``weakest`` (the item that limits the rated torque), ``quantities`` and ``figures`` (both by key), ``curves``
        and ``notes``.
        """
        items = [item for group in self.groups.values() for item in group]
        return {
            "design": self.design.name,
            "rated_torque_nm": self.value("rated_torque"),
            "life_h": self.life,
            "momentary_torque_nm": self.value("momentary_torque"),
            "lubricant": _lubricant_text(self.design),
            "weakest": {"key": self.weakest.key, **self.weakest.as_json()},
            "quantities": {
                item.key: {
                    "name": item.name,
                    "value": item.value,
                    "unit": item.unit,
                    "condition": item.note,
                    **item.interval_json(),
                }
                for item in items
            },
            "figures": values_json(self.figures),
            "curves": [curve.as_json() for curve in self.curves],
            "notes": list(self.notes),
        }


def datasheet(reducer: Reducer, life: float = 0.0, progress: Progress = silent) -> Datasheet:
    """Compute the data sheet of a valid design: quantities in groups, curves over torque and speed, and assumptions.

    The rated torque is rated for a `life` [h] at the design's speed; the default, 0, stands for the life that the
    design states. `progress` is called with the number of finished steps and the number of all steps.
    """
    design = reducer.design
    life = life or design.service.life
    step_count, step_numbers = len(CURVES.speed_shares) + 5, count(1)

    def advance() -> None:
        progress(next(step_numbers), step_count)

    static_sheet = sheet(reducer, design.rated_torque)
    advance()
    if isinstance(reducer, RvReducer):
        contents = _rv_contents(reducer, life, static_sheet, advance)
    else:
        contents = _central_contents(reducer, life, static_sheet, advance)
    groups, curves, ratings, weakest_item = contents
    catalogue = quantities(reducer.but(load={"torque": design.rated_torque}))
    advance()
    return Datasheet(design, life, groups, curves, _notes(reducer, ratings, static_sheet), catalogue, weakest_item)


Contents = tuple[dict[str, tuple[Quantity, ...]], tuple[Curve, ...], tuple[str, ...], RatedItem]
"""Groups of quantities by heading, curves, assumptions of the ratings, and item that limits the rated torque."""


def _central_contents(reducer: Reducer, life: float, static: Sheet, advance: Callable[[], None]) -> Contents:
    """Compute the contents of the data sheet of a central-crank drive.

    They are, in this order: groups of quantities by heading, curves, assumptions (sentences), and the rated item (a
    part with a kind of failure) that limits the rated torque.
    `life` is the required life [h]. `static` is the data sheet computed by statics at the nominal torque. `advance`
    is called after each step, without arguments, to report progress.
    """
    design = reducer.design
    momentary_limit, stop_item = momentary_torque(reducer)
    life_limit = rated_torque(reducer, design.drive.speed, life)
    rated_limit, weakest_item = min(life_limit, (momentary_limit, stop_item), key=lambda pair: pair[0])
    advance()
    groups = {
        "Ratings": _rating_rows(reducer, life, (rated_limit, weakest_item), (momentary_limit, stop_item)),
        "Accuracy and stiffness": _accuracy_rows(reducer, static),
        "Efficiency and heat": _efficiency_rows(reducer, static),
        "Speed": _speed_rows(reducer),
        "Without load": torques_without_load(reducer, static),
        **({"Output bearing": _output_bearing_rows(reducer)} if has_casing(reducer) else {}),
    }
    groups = {heading: _add_condition_notes(reducer, group) for heading, group in groups.items()}
    groups["Ratings"] += _toleranced_torque_rows(reducer, life)
    groups["Mass and size"] = _mass_rows(reducer)
    groups["Lubrication and environment"] = tuple(environment_rows(reducer))
    if has_casing(reducer):
        groups["Interfaces"] = _interface_rows(reducer)
        groups["Assembly"] = tuple(mounting_rows(reducer, 0.01 * groups["Efficiency and heat"][0].value))
    advance()
    curves = (
        life_curve(reducer, life, momentary_limit, life_limit[0], advance),
        _efficiency_curve(at_steady_temperatures(reducer)),
        _wind_up_curve(reducer),
        *no_load_curves(reducer),
    )
    advance()
    return groups, curves, (_describe_ratings(life),), weakest_item


def _rv_contents(reducer: RvReducer, life: float, static: Sheet, advance: Callable[[], None]) -> Contents:
    """Compute the contents of the data sheet of an RV reducer.

    They are, in this order: groups of quantities by heading, curves, assumptions (sentences), and the rated item (a
    part with a kind of failure) that limits the rated torque.
    `life` is the required life [h]. `static` is the data sheet computed by statics at the nominal torque. `advance`
    is called after each step, without arguments, to report progress.
    """
    limits = compute_rv_limits(reducer, life)
    advance()
    groups = {
        heading: _add_condition_notes(reducer, group)
        for heading, group in rv_performance_groups(reducer, life, limits, static).items()
    }
    groups["Ratings"] += _toleranced_torque_rows(reducer, life)
    groups["Accuracy and stiffness"] += toleranced_error_rows(reducer)
    if reducer.main_bearing:
        groups["Output bearing"] = _add_condition_notes(reducer, _output_bearing_rows(reducer))
    groups |= rv_further_groups(reducer)
    advance()
    curves = (
        life_curve(reducer, life, limits.momentary[0], limits.rated_alone[0], advance),
        rv_efficiency_curve(at_steady_temperatures(reducer), CURVES.torque_shares),
        rv_wind_up_curve(reducer, CURVES.torsion_shares),
        *(no_load_curves(reducer) if reducer.design.has_film else ()),
    )
    advance()
    return groups, curves, rv_notes(reducer, life), limits.rated[1]


def _add_condition_notes(reducer: Reducer, group: tuple[Quantity, ...]) -> tuple[Quantity, ...]:
    """Return the quantities of a `group` with a note that states whether parts are perfect or have errors.

    Quantities that do not depend on errors (`BY_GEOMETRY_ALONE`) are unchanged.
    """
    note = f"parts {reducer.parts_text}" if reducer.has_errors else "perfect parts"
    return tuple(
        item if item.key in BY_GEOMETRY_ALONE else replace(item, note=f"{note}; {item.note}" if item.note else note)
        for item in group
    )


def _rating_rows(
    reducer: Reducer, life: float, rated_limit: tuple[float, RatedItem], momentary_limit: tuple[float, RatedItem]
) -> tuple[Quantity, ...]:
    """Return the data-sheet rows of the ratio, the input speed [rpm] and the permissible torques [N m].

    The torques are the rated torque of the drive and of its bearings alone, and the acceleration, momentary and nominal
    torque. `rated_limit` and `momentary_limit` are each a torque [N m] and the item that limits it; `life` is in [h].
    """
    design = reducer.design
    speed = design.drive.speed
    condition = f"{describe_speed(reducer)} input"
    bearing_torque, bearing_item = rated_torque(reducer, speed, life, is_bearing_life)
    (rated_value, weakest_item), (momentary_value, stop_item) = rated_limit, momentary_limit
    acceleration_torque, strength_item = min(
        rated_torque(reducer, speed, life, is_strength, crank_angles=CURVES.crank_angles, rtol=CURVES.rtol),
        (momentary_value, stop_item),
        key=lambda pair: pair[0],
    )
    return (
        ratio_row(design),
        Quantity(
            "rated_torque",
            f"Rated torque, {life:g} h",
            rated_value,
            "N m",
            note=f"{condition}, safety factor 1; limited by {weakest_item.name}{_heat_note(reducer, rated_value)}",
        ),
        Quantity(
            "bearing_torque",
            "Rated torque of the bearings alone",
            bearing_torque,
            "N m",
            note=f"{life:g} h, {condition}; limited by {bearing_item.name}",
        ),
        Quantity(
            "acceleration_torque",
            "Acceleration torque",
            acceleration_torque,
            "N m",
            note=f"at every start and stop, safety factor 1; limited by {strength_item.name}",
        ),
        Quantity(
            "momentary_torque",
            "Momentary torque, emergency stop",
            momentary_value,
            "N m",
            note=f"safety factor 1; limited by {stop_item.name}",
        ),
        nominal_torque_row(design),
        Quantity("input_speed", "Rated input speed", abs(speed) / RPM, "rpm", note="of the crank"),
    )


def _heat_note(reducer: Reducer, rated_torque_limit: float) -> str:
    """Return a clause on a rated torque [N m] beyond the thermal torque limit; empty if it is below, or not known."""
    if reducer.design.thermal.applied:
        return ""
    limit = thermal(reducer.design).torque
    return f"; more than the thermal torque limit, {limit:.4g} N m" if limit < rated_torque_limit else ""


def _toleranced_torque_rows(reducer: Reducer, life: float) -> tuple[Quantity, ...]:
    """Return rated and momentary torque [N m] of drives with errors within the tolerances; empty without tolerances.

    The drives are the samples at the percentile of the largest forces (`select_rated_samples`). Torques are
    extrapolated from the rating at the nominal torque for a `life` [h].
    """
    design = reducer.design
    if not has_tolerances(reducer):
        return ()
    nominal_torque = design.rated_torque
    rating = rate(design, constant_duty(nominal_torque, design.drive.speed), life, parts="toleranced")
    limits = rated_and_momentary_torque(rating.items.values(), nominal_torque, life, reducer)
    percentile = f"{SETTINGS.percentile:g} % percentile of {SETTINGS.samples} samples"
    rows = (
        ("rated_torque_toleranced", "Rated torque, toleranced parts", *limits[0]),
        ("momentary_torque_toleranced", "Momentary torque, toleranced parts", *limits[1]),
    )
    return tuple(
        Quantity(key, name, limit, "N m", note=f"{percentile}; limited by {item.name}")
        for key, name, limit, item in rows
    )


def _accuracy_rows(reducer: Reducer, static: Sheet) -> tuple[Quantity, ...]:
    """Return the data-sheet rows of backlash, lost motion, torsional stiffness, transmission error and hysteresis loss.

    Stiffness is in [N m/arcmin], the peak-to-peak transmission error in [arcsec], the others in [arcmin]. `static` is
    the data sheet computed by statics at the nominal torque.
    """
    quantities, torque_text = static.quantities, f"{reducer.design.rated_torque:.4g} N m"
    error_row = quantities["output_peak_to_peak_loaded_forward_speed"]
    bearing_rows = tuple(backlash_with_bearings(reducer))
    without_play = "; without the play of needles and rollers" if bearing_rows else ""
    return (
        with_name(quantities["backlash"], "Backlash", f"without load, mean over a turn{without_play}"),
        *bearing_rows,
        with_name(quantities["lost_motion_ideal"], "Lost motion", f"between -3 and 3 % of {torque_text}{without_play}"),
        with_name(quantities["stiffness_ideal"], "Torsional stiffness", f"50 to 100 % of {torque_text}, input locked"),
        with_name(error_row, "Transmission error, peak to peak", f"{torque_text}, forward, slow"),
        hysteresis(reducer),
    )


def _efficiency_rows(reducer: Reducer, static: Sheet) -> tuple[Quantity, ...]:
    """Return the data-sheet rows on losses and heat at the nominal torque and speed, in this order.

    They are the efficiency [%] with all bearings and that of the contacts, back-driving torque under and without the
    torque of the crank, no-load and starting torque of the contacts [N m], temperature rise of the housing [K], and
    `_thermal_rows`. `static` is the data sheet computed by statics at the nominal torque.
    """
    design = reducer.design
    warm_reducer, quantities = at_steady_temperatures(reducer), static.quantities
    film_note, warm_note = (f", {film_text(item)}" if design.has_film else "" for item in (reducer, warm_reducer))
    condition = f"{design.rated_torque:.4g} N m, {describe_speed(reducer)}{warm_note}"
    film_condition = "with seals, and grease in the cams, without bearings of shaft and output"
    contact_note = f"{film_condition}{film_note}" if design.has_film else "without seals, grease and bearings"
    contact_efficiency = sheet_part(warm_reducer, "losses", design.rated_torque)["efficiency"]
    housing_item = rate_at_rated_load(reducer).items["temperature"]
    ambient, cooling_text = design.service.ambient_temperature, f"{describe_cooling(design)}, {describe_duty(design)}"
    return (
        _drive_efficiency(reducer, warm_reducer, f"{condition}, all bearings included"),
        with_name(
            contact_efficiency, "Efficiency of the contacts", f"{condition}, without bearings of shaft and output"
        ),
        with_name(
            quantities["back_driving_torque_rated"], "Back-driving torque", f"{contact_note}; against drive.torque_nm"
        ),
        figure_row(reducer, "back_driving_torque_free_nm", "Back-driving torque, crank free", f"{contact_note}; slow"),
        figure_row(
            reducer,
            "no_load_torque_nm",
            "No-load running torque",
            f"{contact_note}; on the crank, {describe_speed(reducer)}",
        ),
        figure_row(reducer, "starting_torque_nm", "Starting torque", f"{contact_note}; on the crank"),
        Quantity(
            "temperature_rise",
            "Temperature rise",
            housing_item.value - ambient,
            "K",
            note=f"{condition}, {cooling_text}",
        ),
        *_thermal_rows(reducer),
    )


def _drive_efficiency(reducer: Reducer, warm_reducer: Reducer, condition: str) -> Quantity:
    """Return the data-sheet row of the efficiency [%] at the nominal torque, including losses of all bearings.

    With the friction law ``film``, it has a 5 to 95 % interval, that of `warm_reducer`, the reducer at the
    temperatures of its losses. `condition` is the note of the row: torque and speed in words.
    """
    efficiency = figure_row(reducer, "drive_efficiency_percent", "Efficiency", condition)
    torque = reducer.design.rated_torque
    if not reducer.design.has_film:
        return efficiency
    output_power = torque * abs(reducer.design.drive.speed) / reducer.design.reduction
    bearing_loss = output_power * (100.0 / efficiency.value - 1.0) - sampled_losses(warm_reducer, torque)[0]
    return with_interval(efficiency, sampled_efficiency(warm_reducer, torque, further_loss=bearing_loss))


def _thermal_rows(reducer: Reducer) -> Iterator[Quantity]:
    """Yield the data-sheet rows of the thermal torque limit [N m] and the temperature difference of disc and ring [K].

    The limit is left out if it is infinite. The note of the difference states at which difference the teeth jam. No row
    is yielded for a design whose dimensions already include thermal expansion (``thermal.applied``).
    """
    if reducer.design.thermal.applied:
        return
    thermal_state = thermal(reducer.design)
    condition = f"{thermal_state.condition}; conductances assumed"
    yield from thermal_torque_row(reducer, thermal_state, condition)
    jam_note = f"{condition}; {thermal_state.jam_difference:.3g} K close the teeth"
    yield Quantity("disc_over_ring", "Disc warmer than the ring", thermal_state.difference, "K", note=jam_note)


def _speed_rows(reducer: Reducer) -> tuple[Quantity, ...]:
    """Return the rows of a data sheet on the continuous, the intermittent and the largest input speed [rpm].

    The first two are for the nominal torque, all the time (S1) and for a quarter of it (S3). They are left out if the
    sizes are those of warm parts (``thermal.applied``). The grease in the bearings limits the largest speed.
    """
    conditions = {
        "continuous_speed_rpm": ("Continuous input speed", "nominal torque, S1, limited by heat and bearings"),
        "intermittent_speed_rpm": ("Intermittent input speed", "nominal torque, S3 25 %, limited by heat and bearings"),
        "largest_speed_rpm": (
            "Maximum input speed",
            "grease-lubricated bearings, n d_m 300 000 (half without a cage)",
        ),
    }
    return tuple(
        figure_row(reducer, key, name, condition)
        for key, (name, condition) in conditions.items()
        if key == "largest_speed_rpm" or not reducer.design.thermal.applied
    )


def _output_bearing_rows(reducer: Reducer) -> tuple[Quantity, ...]:
    """Return the data-sheet rows of the output bearings: tilting moment, tilting stiffness, radial load and axial load.

    Moment [N m] and loads [N] are limits: each may act together with the nominal torque, except the axial load, which
    acts alone. The radial load acts on the face of the flange. The stiffness is in [N m/arcmin].
    """
    bearings, torque_text = output_bearings(reducer), f"in addition to {reducer.design.rated_torque:.4g} N m"
    return (
        figure_row(
            reducer,
            "output_tilting_capacity_nm",
            "Tilting moment",
            f"{torque_text}; {bearings.layout}, {bearings.moment_source}",
        ),
        figure_row(
            reducer,
            "output_tilting_stiffness_nm_per_arcmin",
            "Tilting stiffness",
            f"at half the tilting moment, Palmgren; {bearings.stiffness_note}",
        ),
        figure_row(reducer, "output_radial_load_n", "Radial load", f"on the face of the flange, {torque_text}"),
        figure_row(reducer, "output_axial_load_n", "Axial load", f"alone, {bearings.axial_source}"),
    )


def _interface_rows(reducer: Reducer) -> tuple[Quantity, ...]:
    """Return the rows of a data sheet on bolt circles and diameters [mm] of motor flange, output flange and covers."""
    covers = casing(reducer)
    motor, screws = covers.motor, covers.screws
    shaft_text = f"shaft of {2e3 * motor.shaft:.4g} mm" if motor.shaft else "coupled to the input journal"
    if reducer.design.shaft.bore_radius:
        shaft_text = "around the hollow crank, for a frameless motor or the guard of a belt"
    return (
        Quantity(
            "motor_circle",
            "Motor flange, bolt circle",
            2e3 * motor.circle,
            "mm",
            note=_threads(motor.screws, motor.thread),
        ),
        Quantity("motor_pilot", "Motor flange, pilot", 2e3 * motor.pilot, "mm", note=f"{motor.name}, {shaft_text}"),
        Quantity(
            "output_circle",
            "Output flange, bolt circle",
            2e3 * covers.flange_circle,
            "mm",
            note=_threads(covers.flange_screws, covers.flange_bolt.thread),
        ),
        Quantity("cover_diameter", "Covers, diameter", 2e3 * covers.outer, "mm", note="both"),
        Quantity(
            "cover_circle",
            "Covers, bolt circle",
            2e3 * screws.circle,
            "mm",
            note=_threads(len(screws.angles), screws.bolt.thread),
        ),
    )


def _threads(count: int, thread: float) -> str:
    """Format a number of threads of a diameter [m]."""
    return f"{count} x M{1e3 * thread:g}"


def _mass_rows(reducer: Reducer) -> tuple[Quantity, ...]:
    """Return the rows of a data sheet on mass [kg], inertia [kg cm2] and dimensions [mm].

    There are rows for the mechanism alone and, from `DRIVE_FIGURES`, for the drive with covers.
    """
    design = reducer.design
    gear, housing = design.gear, design.housing
    solids = {name: mass_properties(solid) for name, solid in body_solids(reducer).items()}
    count_by_solid = {PIN: design.ring.teeth}
    mass = sum(solid.mass * count_by_solid.get(name, 1) for name, solid in solids.items())
    z_ends = axial_extent(reducer)
    return (
        Quantity("mass", "Mass of the mechanism", mass, "kg", note="parts as drawn, without covers and bearing rings"),
        Quantity("inertia", "Inertia of the mechanism", KG_CM2 * input_inertia(reducer), "kg cm2", note="at the input"),
        *(
            figure_row(reducer, key, name, condition)
            for key, (name, condition) in DRIVE_FIGURES.items()
            if figure(key).applies_to(reducer)
        ),
        Quantity("outer_diameter", "Outer diameter", 2e3 * housing.outer_radius, "mm", note="ring"),
        Quantity(
            "length",
            "Length of the mechanism",
            1e3 * (z_ends[1] - z_ends[0]),
            "mm",
            note="input journal to output disc",
        ),
        Quantity("input_diameter", "Input shaft diameter", 2e3 * design.shaft.radius, "mm", note="journal"),
        *(
            (Quantity("through_bore", "Through bore", 2e3 * design.shaft.bore_radius, "mm", note="shaft and hub"),)
            if design.shaft.bore_radius
            else ()
        ),
        Quantity(
            "face_width", "Face width", 1e3 * gear.face_width, "mm", note=f"of {gear.discs} disc{'s'[: gear.discs > 1]}"
        ),
    )


def axial_extent(reducer: Reducer) -> tuple[float, float]:
    """Compute the ends of the mechanism along z [m]."""
    if isinstance(reducer, RvReducer):
        return axial_layout(reducer).ends
    solids = parts(reducer, VISUAL_CHORD_ERROR).values()
    ends = [end for solid in solids for prism in solid.prisms for end in (prism.z0, prism.z1)]
    return min(ends), max(ends)


def life_curve(
    reducer: Reducer,
    life: float,
    momentary: float = np.inf,
    rated: float = 0.0,
    on_point: Callable[[], None] = lambda: None,
) -> Curve:
    """Compute the rated output torque [N m] for a required life over the input speed [rpm].

    The speeds are `CURVES.speed_shares` of that of the design. Speeds without any rated torque have no point.

    Parameters
    ----------
    reducer, life
        The reducer, and its required life [h].
    momentary
        Momentary torque, the upper limit of the curve [N m].
    rated
        Rated torque at the design's own speed, if it is known [N m]; 0: unknown.
    on_point
        Called after each speed.
    """
    points: list[tuple[float, float]] = []
    for share in CURVES.speed_shares:
        speed = share * abs(reducer.design.drive.speed)
        with suppress(DesignError):
            torque = rated if share == 1.0 else 0.0
            if not torque:
                guess = points[-1][1] if points else rated
                torque, _ = rated_torque(
                    reducer,
                    speed,
                    life,
                    start_torque=guess,
                    crank_angles=CURVES.crank_angles,
                    rtol=CURVES.rtol,
                )
            points.append((speed / RPM, min(torque, momentary)))
        on_point()
    speeds, torques = np.array(points).T
    return Curve(
        f"Rated torque for {life:g} h", "all items", speeds, torques, "input speed [rpm]", "output torque [N m]"
    )


def _efficiency_curve(reducer: Reducer) -> Curve:
    """Compute the efficiency [%] over the output torque [N m] at the design's speed, with the losses of all bearings.

    All points have the temperatures of the reducer. The losses of the bearings are interpolated linearly between the
    smallest and the largest torque.
    """
    design = reducer.design
    torques, speed = np.array(CURVES.torque_shares) * design.rated_torque, abs(design.drive.speed)
    end_torques = torques[[0, -1]]
    points = (DutyPoint(float(torque), speed, 1.0) for torque in end_torques)
    end_losses = [
        sum(bearing_losses(reducer, solve_loading(reducer, point, CURVES.crank_angles, with_wind_up=False)).values())
        for point in points
    ]
    efficiencies = []
    for torque, bearing_loss in zip(torques, np.interp(torques, end_torques, end_losses), strict=True):
        contact_powers = powers(reducer, float(torque))
        efficiencies.append(contact_powers.delivered / (contact_powers.supplied + bearing_loss))
    panel, name = f"Efficiency at {describe_speed(reducer)}", f"all bearings included{warm_text(reducer)}"
    return Curve(panel, name, torques, 100.0 * np.array(efficiencies), "output torque [N m]", "efficiency [%]")


def _wind_up_curve(reducer: Reducer) -> Curve:
    """Compute the rotation of the output [arcmin] over its torque [N m] with locked input, the mean over a turn.

    Friction is left out.
    """
    static_reducer = at_rest(reducer)
    springs = springs_of(static_reducer, friction=False)
    torques = reducer.design.rated_torque * np.array(
        [*(-np.array(CURVES.torsion_shares[::-1])), *CURVES.torsion_shares]
    )
    twists = [float(loads(static_reducer, springs, float(torque)).output_turn.mean()) / ARCMINUTE for torque in torques]
    panel = "Torsion, input locked"
    return Curve(panel, "mean over a turn", torques, np.array(twists), "output torque [N m]", "output turn [arcmin]")


def _notes(reducer: Reducer, ratings: tuple[str, ...], static: Sheet) -> tuple[str, ...]:
    """Return the assumptions of the data sheet, a sentence each: statics, rated torque, friction, material, clearances.

    `ratings` are the sentences on the rated torque, and `static` is the data sheet computed by statics, with
    its assumptions.
    """
    temperature = reducer.design.thermal.words
    return (
        f"Computed by cycloid_mj from the design {reducer.design.name}; nothing was measured on a built drive.",
        *([f"Temperature of the parts: {temperature}, unless a row states another."] if temperature else []),
        *ratings,
        _material_text(reducer),
        f"Lubricant: {_lubricant_text(reducer.design)}.",
        *(f"{sentence[0].upper()}{sentence[1:]}." for sentence in static.assumptions),
    )


def _describe_ratings(life: float) -> str:
    """Return sentences on the definition of the rated torque for a life [h] and of the momentary torque."""
    return (
        f"Rated torque: limited by bearings (ISO 281, 90 %), surfaces (pitting, shakedown), parts (Goodman) and heat "
        f"for {life:g} h, and by the momentary torque; wear is left out. Momentary torque (emergency stop): limited by "
        "first yield, dents, bent or sheared pins, a skipped tooth, or a joint that slips. Both have a safety factor "
        "of 1."
    )


def _lubricant_text(design: Design) -> str:
    """Describe the lubricant and its largest temperature."""
    return f"{grease_of(design).name}, to {design.service.grease_temperature:g} °C"


def _material_text(reducer: Reducer) -> str:
    """Return a sentence for the data sheet on the material of each part, and one on the clearances [um]."""
    design = reducer.design
    materials = ", ".join(f"{part} {design.material_of(part).name or 'of its own numbers'}" for part in PARTS)
    kinds = [kind for kind in design.pair_kinds if applies(design.layout, "clearance", kind)]
    clearances = {kind.replace("_", " "): getattr(design.clearance, kind) for kind in kinds}
    if isinstance(reducer, RvReducer):
        clearances["crank bearing, radial"] = reducer.bearing_clearance
        clearances["planet backlash"] = reducer.planet.backlash
    clearance_text = ", ".join(f"{name} {1e6 * value:.4g}" for name, value in clearances.items())
    return f"Materials: {materials}. Clearances [um]: {clearance_text}."


@shows_progress
def datasheet_of(design: Named, life_h: float = 0.0, progress: Progress = silent) -> Datasheet:
    """Compute the data sheet of a design; from Python as ``cm.datasheet(design)``.

    Parameters
    ----------
    design
        A valid design, or the name of a preset or a file.
    life_h
        Life for which the torque is rated [h]; by default that of the design.
    progress
        Called with the number of finished steps and the number of all steps.

    Returns
    -------
    Datasheet
        Quantities in groups, each with its condition, and curves over torque and speed.

    Raises
    ------
    UsageError
        The design does not exist, or the life is negative.
    DesignError
        The design cannot be read, its crank does not turn, or no torque is rated for that life.
    RunError
        No static equilibrium exists, for example because friction jams the reducer.
    """
    if life_h:
        require_number("life_h", life_h, "h", above=0.0)
    return datasheet(reducer_of(resolve(design)), life_h, progress)
