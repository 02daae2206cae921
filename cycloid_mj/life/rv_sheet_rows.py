"""Rows, curves and notes of the data sheet of an RV reducer."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.result import Curve, Quantity
from cycloid_mj.base.units import ARCMINUTE, KG_CM2, MILLIMETRES, RPM
from cycloid_mj.explore.rv_samples import draw_rv_samples
from cycloid_mj.life.as_built import SETTINGS as TOLERANCE_SETTINGS
from cycloid_mj.life.heat import describe_cooling, describe_duty
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.rated import is_bearing_life, momentary_torque, rated_torque
from cycloid_mj.life.sheet_rows import (
    SETTINGS,
    contact_torque,
    describe_speed,
    environment_rows,
    figure_row,
    nominal_torque_row,
    ratio_row,
    thermal_torque_row,
    warm_text,
    with_interval,
    with_name,
)
from cycloid_mj.life.steady_state import at_steady_temperatures
from cycloid_mj.life.thermal import permissible_speed, thermal
from cycloid_mj.parts import input_inertia
from cycloid_mj.parts.export.rv_assembly import rv_mass
from cycloid_mj.parts.rv import axial_layout
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics import rv_sheet
from cycloid_mj.statics.film import film_text
from cycloid_mj.statics.rv_sheet import solve_rv_equilibrium
from cycloid_mj.statics.sheet import Sheet, shaft_powers, sheet_part

ERROR_SAMPLES = 2_000
"""Samples of the transmission error of toleranced parts: its 95 % percentile scatters by less than 3 %."""

NOT_COMPUTED = (
    "Not computed: acceleration torque, back-driving torques and hysteresis loss; strength of discs, cranks and tooth "
    "roots (`cycloid-mj stress`), of carrier, posts and screws; {} of the main bearings; speed limits of bearings and "
    "planets; churning of the grease."
)
"""Note of the data sheet on the figures of a central crank that it does not have for an RV reducer."""


@dataclass(frozen=True)
class RvTorqueLimits:
    """Rated torque, rated torque of the bearings, and momentary torque, each with the item that limits it [N m].

    `rated_alone` is the rated torque without the limit of the momentary torque.
    """

    rated_alone: tuple[float, RatedItem]
    bearings: tuple[float, RatedItem]
    momentary: tuple[float, RatedItem]

    @property
    def rated(self) -> tuple[float, RatedItem]:
        """Rated torque [N m] and its limiting item; it is at most the momentary torque."""
        return min(self.rated_alone, self.momentary, key=lambda limit: limit[0])


def compute_rv_limits(reducer: RvReducer, life: float) -> RvTorqueLimits:
    """Compute rated torque of drive and bearings, and momentary torque of an RV reducer [N m], each with its limit.

    A limit is the rated item, a part with a kind of failure, that sets the torque. Rated torques are for a `life` [h]
    at the design's speed.

    Raises
    ------
    DesignError
        There is no rated torque for that life.
    """
    speed = reducer.design.drive.speed
    rated_alone, bearings = (
        rated_torque(reducer, speed, life, limits_torque) for limits_torque in (None, is_bearing_life)
    )
    return RvTorqueLimits(rated_alone, bearings, momentary_torque(reducer))


def rv_performance_groups(
    reducer: RvReducer, life: float, limits: RvTorqueLimits, static: Sheet
) -> dict[str, tuple[Quantity, ...]]:
    """Return data-sheet rows on torques, accuracy, efficiency and heat of an RV reducer: heading -> quantities.

    `static` is the data sheet computed by statics at the nominal torque, `limits` the rated and momentary torque for a
    `life` [h].
    """
    return {
        "Ratings": tuple(_rating_rows(reducer, life, limits)),
        "Accuracy and stiffness": tuple(_accuracy_rows(reducer, static)),
        "Efficiency and heat": tuple(_efficiency_rows(reducer)),
        **({"Without load": tuple(_no_load_rows(reducer))} if reducer.design.has_film else {}),
    }


def rv_further_groups(reducer: RvReducer) -> dict[str, tuple[Quantity, ...]]:
    """Return the groups that do not depend on errors of the parts: heading -> quantities."""
    return {
        "Mass and size": tuple(_mass_rows(reducer)),
        "Lubrication and environment": tuple(environment_rows(reducer)),
    }


def _rating_rows(reducer: RvReducer, life: float, limits: RvTorqueLimits) -> Iterator[Quantity]:
    """Yield the data-sheet rows of ratio, torques [N m] and rated speeds [rpm] of an RV reducer.

    The torques are the rated torque of the drive and of its crank bearings alone, momentary and nominal torque; the
    speeds those of input and output. `limits` are the rated and momentary torque for a `life` [h] at the design's
    speed.
    """
    design, (rated_value, weakest_item), (momentary_value, stop_item) = reducer.design, limits.rated, limits.momentary
    bearing_torque, bearing = limits.bearings
    condition = f"{describe_speed(reducer)} input"
    yield ratio_row(design)
    yield Quantity(
        "rated_torque",
        f"Rated torque, {life:g} h",
        rated_value,
        "N m",
        note=f"{condition}, without heat; limited by {weakest_item.name}",
    )
    yield Quantity(
        "bearing_torque",
        "Rated torque of the crank bearings alone",
        bearing_torque,
        "N m",
        note=f"{life:g} h, {condition}; limited by {bearing.name}",
    )
    yield Quantity(
        "momentary_torque",
        "Momentary torque, emergency stop",
        momentary_value,
        "N m",
        note=f"crank bearings and teeth only; limited by {stop_item.name}",
    )
    yield nominal_torque_row(design)
    yield Quantity("input_speed", "Rated input speed", abs(design.drive.speed) / RPM, "rpm", note="of the sun")
    yield Quantity(
        "output_speed", "Rated output speed", abs(reducer.output_speed) / RPM, "rpm", note="input over ratio"
    )


def _accuracy_rows(reducer: RvReducer, static: Sheet) -> Iterator[Quantity]:
    """Yield the data-sheet rows of backlash, lost motion, torsional stiffness and transmission errors, in this order.

    The transmission errors, peak to peak, are that under load, and that by the errors of the parts if the design has
    any. `static` is the data sheet computed by statics at the nominal torque.
    """
    quantities, torque_text = static.quantities, f"{reducer.design.rated_torque:.4g} N m"
    error_row = quantities["output_peak_to_peak_loaded_forward_speed"]
    play_text = (
        f"play of the planet teeth {1e6 * reducer.planet.backlash:.3g} um, of the crank bearings "
        f"{1e6 * reducer.bearing_clearance:.3g} um"
    )
    yield with_name(
        quantities["backlash"], "Backlash", f"without load, mean over a turn of the carrier, sun locked; {play_text}"
    )
    yield with_name(
        quantities["lost_motion_ideal"],
        "Lost motion",
        f"between -3 and 3 % of {torque_text}, sun locked; {play_text}",
    )
    yield with_name(quantities["stiffness_ideal"], "Torsional stiffness", f"50 to 100 % of {torque_text}, sun locked")
    yield with_name(error_row, "Transmission error, peak to peak", f"{torque_text}, forward, slow")
    if quantities["te_errors"].value:
        condition = "cranks, bores, carrier, planets, output without clearance and load; pins at the nominal torque"
        yield with_name(quantities["te_errors"], "Transmission error by errors, peak to peak", condition)


def toleranced_error_rows(reducer: RvReducer) -> tuple[Quantity, ...]:
    """Return the data-sheet row of the transmission error [arcsec] within the tolerances; empty without tolerances.

    It is a percentile (`as_built.SETTINGS`) of the peak-to-peak errors of random drives within the tolerances.
    """
    percentile = TOLERANCE_SETTINGS.percentile
    try:
        samples = draw_rv_samples(reducer, ERROR_SAMPLES, TOLERANCE_SETTINGS.seed, 0)
    except UsageError:
        return ()
    return (
        Quantity(
            "te_errors_toleranced",
            "Transmission error, toleranced parts",
            float(np.percentile(samples.values, percentile)),
            "arcsec",
            note=f"{percentile:g} % percentile of {ERROR_SAMPLES} samples, peak to peak; positions of pins at the "
            "nominal torque, all else without clearance and load",
        ),
    )


def _efficiency_rows(reducer: RvReducer) -> Iterator[Quantity]:
    """Yield the data-sheet rows on losses and heat of an RV reducer at the nominal torque and speed.

    They are the efficiency [%], with the law ``film`` no-load and starting torque on the sun [N m], and `_thermal_rows`
    unless the dimensions of the design already include thermal expansion (``thermal.applied``).
    """
    design = reducer.design
    losses_text = "main bearings and seal without their load" if design.has_film else "without main bearings and seals"
    warm_reducer = at_steady_temperatures(reducer)
    film_note, warm_note = (f"; {film_text(item)}" if design.has_film else "" for item in (reducer, warm_reducer))
    condition = f"{design.rated_torque:.4g} N m, {describe_speed(reducer)}; {losses_text}{warm_note}"
    yield with_name(sheet_part(warm_reducer, "losses", design.rated_torque)["efficiency"], "Efficiency", condition)
    if design.has_film:
        shaft_note = f"on the sun, main bearings without preload{film_note}"
        speed_note = f"{describe_speed(reducer)}, {shaft_note}"
        yield figure_row(reducer, "no_load_torque_nm", "No-load running torque", speed_note)
        yield figure_row(reducer, "starting_torque_nm", "Starting torque", shaft_note)
    if not design.thermal.applied:
        yield from _thermal_rows(reducer)


def _thermal_rows(reducer: RvReducer) -> Iterator[Quantity]:
    """Yield the data-sheet rows of the steady temperatures and thermal limits of an RV reducer at the nominal torque.

    They are the temperature rise of the housing over the air [K], the torque [N m] and the continuous speed [rpm] that
    heat allows (left out if they are infinite), and the temperature of the disc over that of the ring [K].
    """
    thermal_state = thermal(reducer.design)
    temperatures = thermal_state.temperatures
    cooling_text = f"{describe_cooling(reducer.design)}, {describe_duty(reducer.design)}"
    condition = f"{reducer.design.rated_torque:.4g} N m, {describe_speed(reducer)}, {cooling_text}"
    housing_rise = temperatures["housing"] - reducer.design.service.ambient_temperature
    hottest_part = max(temperatures, key=lambda part: temperatures[part])
    yield Quantity(
        "temperature_rise",
        "Temperature rise",
        housing_rise,
        "K",
        note=f"housing; {hottest_part} {temperatures[hottest_part] - temperatures['housing']:.3g} K warmer; "
        f"{condition}",
    )
    yield from thermal_torque_row(reducer, thermal_state, f"{describe_speed(reducer)}, {cooling_text}")
    if math.isfinite(speed := permissible_speed(reducer.design, 1.0)):
        note = f"nominal torque, {describe_cooling(reducer.design)}, S1; limited by heat only"
        yield Quantity("continuous_speed_rpm", "Continuous input speed", speed / RPM, "rpm", note=note)
    note = f"{condition}; {thermal_state.jam_difference:.3g} K close the teeth"
    yield Quantity("disc_over_ring", "Disc warmer than the ring", thermal_state.difference, "K", note=note)


def _no_load_rows(reducer: RvReducer) -> Iterator[Quantity]:
    """Yield the rows of no-load (20, 60 °C) and starting torque (20 °C) on the sun [N m].

    The design has the friction law ``film``.
    """
    for key, name, figure_key, temperature in (
        ("running_torque_cold", "No-load torque, 20 °C", "no_load_torque_nm", SETTINGS.cold),
        ("running_torque_warm", "No-load torque, 60 °C", "no_load_torque_nm", SETTINGS.warm),
        ("starting_torque_drive", "Starting torque, 20 °C", "starting_torque_nm", SETTINGS.cold),
    ):
        torque = contact_torque(reducer, figure_key, temperature)
        note = "on the sun, with seal and grease; main bearings without preload"
        row = Quantity(key, name, torque.value, "N m", note=note if math.isfinite(torque.value) else torque.note)
        yield with_interval(row, torque)


def _mass_rows(reducer: RvReducer) -> Iterator[Quantity]:
    """Yield the data-sheet rows on the size of an RV reducer.

    They are mass [kg], inertia at the sun [kg cm2], outer diameter, length and face width [mm].
    """
    design, discs = reducer.design, reducer.design.gear.discs
    yield Quantity(
        "mass",
        "Mass of the mechanism",
        rv_mass(reducer),
        "kg",
        note=f"without {'' if reducer.main_bearing else 'main bearings, '}screws, grease and the shaft of the sun",
    )
    inertia = KG_CM2 * input_inertia(reducer)
    note = "at the sun; without its shaft, needles and motor"
    yield Quantity("inertia", "Inertia of the mechanism", inertia, "kg cm2", note=note)
    diameter = 2.0 * MILLIMETRES * design.housing.outer_radius
    yield Quantity("outer_diameter", "Outer diameter", diameter, "mm", note="housing, without a mounting flange")
    length = MILLIMETRES * axial_layout(reducer).length
    yield Quantity("length", "Length of the mechanism", length, "mm", note="planets to the outer face of the carrier")
    width = MILLIMETRES * design.gear.face_width
    yield Quantity("face_width", "Face width", width, "mm", note=f"of {discs} disc{'s'[: discs > 1]}")


def rv_efficiency_curve(reducer: RvReducer, shares: tuple[float, ...]) -> Curve:
    """Compute the efficiency [%] at the design's speed over the output torque [N m].

    `shares` are the torques of the points over the nominal torque [1].
    """
    torques = np.array(shares) * reducer.design.rated_torque
    efficiency = 100.0 * np.array(
        [shaft_powers(reducer.but(load={"torque": torque}), torque).efficiency for torque in torques.tolist()]
    )
    included = "all bearings included" if reducer.design.has_film else "without main bearings and seals"
    panel = f"Efficiency at {describe_speed(reducer)}"
    name = f"{included}{warm_text(reducer)}"
    return Curve(panel, name, torques, efficiency, "output torque [N m]", "efficiency [%]")


def rv_wind_up_curve(reducer: RvReducer, shares: tuple[float, ...]) -> Curve:
    """Compute the rotation of the output [arcmin] over its torque [N m], at a fixed sun and without friction.

    `shares` are the positive torques over the nominal torque; the curve also has the same negative torques. A positive
    torque opposes the rotation of the running drive; a positive rotation has the direction of a positive torque.
    """
    rotation_sign = float(np.sign(reducer.design.drive.speed))
    torques = reducer.design.rated_torque * np.array([*(-np.array(shares[::-1])), *shares])
    count = rv_sheet.SETTINGS.rotation_angles
    rotations = [
        reducer.share * float(np.mean(solve_rv_equilibrium(reducer, torque, count).carrier_turn)) / ARCMINUTE
        for torque in torques.tolist()
    ]
    name, panel = "mean over a turn of the carrier", "Torsion, sun locked"
    return Curve(
        panel, name, torques, -rotation_sign * np.array(rotations), "output torque [N m]", "output turn [arcmin]"
    )


def rv_notes(reducer: RvReducer, life: float) -> tuple[str, ...]:
    """Return the assumptions on which the torques of an RV data sheet are based, for a life [h], a sentence each."""
    missing = (
        "friction by preload and run-out" if reducer.main_bearing else "load ratings, stiffness, preload and run-out"
    )
    return (
        f"Rated torque: limited by crank bearings (ISO 281, 90 %) and pitting of cycloid teeth and sun for {life:g} h, "
        "and by the momentary torque; heat and wear are left out. Momentary torque (emergency stop): limited by dents "
        "in the crank bearings (ISO 76) and first yield of the cycloid teeth, with a safety factor of 1.",
        NOT_COMPUTED.format(missing),
    )
