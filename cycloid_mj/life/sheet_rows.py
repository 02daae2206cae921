"""Rows of a data sheet about operation and mounting: torque without load, hysteresis, environment, run-out, screws."""

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError, RunError
from cycloid_mj.base.result import Curve, Quantity
from cycloid_mj.base.units import ARCMINUTE, RPM
from cycloid_mj.design import Design
from cycloid_mj.design.model import HEATED
from cycloid_mj.figures import compute, quantity
from cycloid_mj.life import rolling
from cycloid_mj.life.bearings import bearing_forces, bearings_of
from cycloid_mj.life.duty import constant_duty
from cycloid_mj.life.heat import describe_cooling, describe_duty, heat_limits
from cycloid_mj.life.joints import screwed_joints
from cycloid_mj.life.loading import solve_loading
from cycloid_mj.life.no_load import GREASE, NoLoadTorque, grease_of, no_load_torque
from cycloid_mj.life.rated import momentary_torque
from cycloid_mj.life.steady_state import solve_steady_state
from cycloid_mj.life.thermal import thermal
from cycloid_mj.life.thermal_limits import find_rise_limit
from cycloid_mj.life.thermal_state import ThermalState
from cycloid_mj.parts import crank_segments
from cycloid_mj.parts.crank import shaft_dimensions
from cycloid_mj.parts.export.bearings import bearing_clearances
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.statics.film import lubricant_temperature, state_seals
from cycloid_mj.statics.film_spread import Spread
from cycloid_mj.statics.friction_path import Losses, follow_torque_path
from cycloid_mj.statics.sheet import Sheet, sheet_part
from cycloid_mj.statics.springs import turn_evenly


@dataclass(frozen=True)
class RowSettings:
    """Conditions of the rows."""

    cold: float = 20.0
    warm: float = 60.0
    """Temperatures of the torque without load [°C]: a workshop, and the case temperature that manufacturers allow."""
    loop_end: float = 0.01
    """Torque at which the ends of the hysteresis loop are read, over the nominal: at 0 weight moves loose parts."""
    loop_angles: int = 4
    speed_shares: tuple[float, ...] = (0.1, 0.25, 0.5, 0.75, 1.0, 1.5)
    """Points of the curve of the torque without load, over the design's speed."""

    @property
    def loop(self) -> Array:
        """Torque path of the hysteresis loop over the nominal torque; its ends are the rows 4 and 8."""
        return np.array([0.0, 0.5, 1.0, 0.5, self.loop_end, -0.5, -1.0, -0.5, -self.loop_end])


SETTINGS = RowSettings()

RADIAL_RUN_OUTS = ((18, 10), (30, 13), (50, 15), (80, 20), (120, 25), (180, 30), (250, 40))
"""ISO 492:2014, normal class, K_ia: largest bore [mm] and radial run-out of an inner ring [um]."""


def describe_speed(reducer: Reducer) -> str:
    """Format the design's speed."""
    return f"{abs(reducer.design.drive.speed) / RPM:.0f} rpm"


def warm_text(reducer: Reducer) -> str:
    """Return the temperature of the lubricant in the teeth for the name of a curve with film friction, or ""."""
    design = reducer.design
    if not design.has_film:
        return ""
    return f", lubricant at {lubricant_temperature(reducer, design.tooth_pair):.3g} °C"


def ratio_row(design: Design) -> Quantity:
    """Return the row of the ratio."""
    direction = "same" if design.ratio > 0 else "opposite"
    return Quantity("ratio", "Reduction ratio", design.reduction, "1", note=f"input to output, {direction} direction")


def nominal_torque_row(design: Design) -> Quantity:
    """Return the row of the nominal torque [N m]."""
    note = "motor torque times the ratio (drive.torque_nm); figures below are at this torque"
    return Quantity("nominal_torque", "Nominal torque", design.rated_torque, "N m", note=note)


def figure_row(reducer: Reducer, key: str, name: str, condition: str) -> Quantity:
    """Compute a quantity of the catalogue for a line of the sheet; if that fails, its note says why."""
    computed = quantity(reducer, key)
    note = condition if math.isfinite(computed.value) else computed.note
    return with_interval(Quantity(key, name, computed.value, computed.unit, note=note), computed)


def with_name(quantity: Quantity, name: str, condition: str) -> Quantity:
    """Return a quantity with another name, and a condition as its note if it has none."""
    note = condition if quantity.low is not None else quantity.note or condition
    return with_interval(Quantity(quantity.key, name, quantity.value, quantity.unit, note=note), quantity)


def with_interval(row: Quantity, interval: Quantity | Spread) -> Quantity:
    """Return a row with an interval and its causes, which are also added to its note; unchanged without an interval."""
    row = replace(row, low=interval.low, high=interval.high, causes=interval.causes)
    return replace(row, note=f"{row.note}; {row.interval_text}") if row.interval_text else row


def hysteresis(reducer: Reducer) -> Quantity:
    """Compute the hysteresis loss [arcmin]: the width of the torque-rotation loop of the output near zero torque.

    The crank is locked and the loop reaches plus and minus the nominal torque. The width is the difference of rotation
    between its two unloading branches, at plus and minus 1 % of the nominal torque (`RowSettings.loop_end`). The
    result is the mean over 4 crank angles (`RowSettings.loop_angles`).
    """
    torque = reducer.design.rated_torque
    widths = []
    for crank in turn_evenly(reducer, SETTINGS.loop_angles):
        rows, turns = follow_torque_path(reducer, torque * SETTINGS.loop, float(crank), Losses())
        start_turn, end_turn = np.interp((4.0, 8.0), rows, turns)
        widths.append(abs(start_turn - end_turn) / ARCMINUTE)
    note = f"after loads of +-{torque:.4g} N m, crank locked, with the backlash; friction of the contacts only"
    return Quantity("hysteresis_loss", "Hysteresis loss", float(np.mean(widths)), "arcmin", note=note)


def torques_without_load(reducer: Reducer, static_sheet: Sheet) -> tuple[Quantity, ...]:
    """Return the data-sheet rows of no-load torque at 20 and 60 °C, starting and back-driving torque at 20 °C [N m].

    They include grease, bearings and seals. The back-driving torque acts on the output, the others on the crank.
    `static_sheet` is the data sheet computed by statics, whose efficiency of back-driving is used.
    """
    design, speed = reducer.design, abs(reducer.design.drive.speed)
    running_row, warm_running_row, starting_row, back_driving_row = (
        contact_torque(reducer, key, temperature)
        for key, temperature in (
            ("no_load_torque_nm", SETTINGS.cold),
            ("no_load_torque_nm", SETTINGS.warm),
            ("starting_torque_nm", SETTINGS.cold),
            ("back_driving_torque_free_nm", SETTINGS.cold),
        )
    )
    cold_torque, warm_torque = (
        no_load_torque(reducer, speed, temperature) for temperature in (SETTINGS.cold, SETTINGS.warm)
    )
    start_torque = no_load_torque(reducer, 0.0, SETTINGS.cold)
    efficiency = 0.01 * static_sheet.quantities["back_driving_efficiency"].value
    torque_ratio = design.reduction / efficiency if efficiency > 0.0 else math.nan
    range_text = "range" if not design.has_film else "5 to 95 % of the film, and range of the bearings"
    rows = (
        ("running_torque_cold", "No-load torque, 20 °C", running_row, cold_torque, 1.0, "on the crank"),
        ("running_torque_warm", "No-load torque, 60 °C", warm_running_row, warm_torque, 1.0, "on the crank"),
        ("starting_torque_drive", "Starting torque, 20 °C", starting_row, start_torque, 1.0, "on the crank"),
        (
            "back_driving_torque_drive",
            "Back-driving torque, 20 °C",
            back_driving_row,
            start_torque,
            torque_ratio,
            "on the output, crank free",
        ),
    )
    return tuple(_torque_row(*row, range_text) for row in rows)


def _torque_row(
    key: str,
    name: str,
    contact_row: Quantity,
    bearing_torque: NoLoadTorque,
    torque_ratio: float,
    shaft_text: str,
    range_text: str,
) -> Quantity:
    """Return the data-sheet row of a no-load torque [N m]: contact friction plus bearing and seal friction.

    Parameters
    ----------
    key, name
        Key and name of the row.
    contact_row
        Torque of the contacts at the shaft of the row; the ends of its interval are added to those of the bearings.
    bearing_torque
        Torque of bearings and seals referred to the crank, with its range.
    torque_ratio
        Factor that refers `bearing_torque` to the shaft of the row [1].
    shaft_text, range_text
        Texts for the note: which shaft it is, and what the ends of the interval mean.
    """
    if not math.isfinite(contact_row.value):
        return replace(contact_row, key=key, name=name)
    low = (contact_row.value if contact_row.low is None else contact_row.low) + torque_ratio * bearing_torque.low
    high = (contact_row.value if contact_row.high is None else contact_row.high) + torque_ratio * bearing_torque.high
    causes_text = (
        f", mostly from {' and '.join(cause for cause, _ in contact_row.causes[:2])}" if contact_row.causes else ""
    )
    interval = f"{low:.3g} to {high:.3g} ({range_text}){causes_text}; " if math.isfinite(low) else ""
    note = f"with seals, grease, bearings; {shaft_text}; {interval}Palmgren's M0 and ISO/TR 14179-2"
    row = Quantity(key, name, contact_row.value + torque_ratio * bearing_torque.total, "N m", note=note)
    return replace(row, low=low, high=high, causes=contact_row.causes) if contact_row.causes else row


def contact_torque(reducer: Reducer, key: str, temperature: float) -> Quantity:
    """Compute a no-load torque by the friction of the contacts alone [N m], at a temperature of the parts [°C].

    `key` is "no_load_torque_nm", "starting_torque_nm" or "back_driving_torque_free_nm". The temperature has an effect
    with the friction law ``film`` only. If the parts jam, the torque is NaN and its note has the reason.
    """
    try:
        return quantity(_at_temperature(reducer, temperature), key)
    except DesignError as error:
        return Quantity(key, key, math.nan, "N m", note=str(error))


def _contact_torques_by_speed(reducer: Reducer, speeds: Array, temperature: float) -> Array:
    """Compute the no-load torque of the contacts on the crank [N m] at n speeds of the crank [rad/s], shape (n,).

    Torques are NaN if the parts jam at the temperature [°C], or where there is no equilibrium.
    """
    key, torques = "no_load_torque_nm", np.full(len(speeds), math.nan)
    for index, speed in enumerate(speeds):
        with suppress(DesignError, RunError):
            driven_reducer = state_seals(reducer).but(drive={"speed": float(speed)})
            torques[index] = compute(_at_temperature(driven_reducer, temperature), [key])[key]
    return torques


def _at_temperature(reducer: Reducer, temperature: float) -> Reducer:
    """Return a reducer with all parts at a temperature [°C]; it is unchanged with the friction law ``coulomb``."""
    return reducer.but(thermal=dict.fromkeys(HEATED, temperature)) if reducer.design.has_film else reducer


def no_load_curves(reducer: Reducer) -> tuple[Curve, ...]:
    """Compute the no-load torque on the crank [N m] over its speed [rpm], a curve each for cold and warm parts.

    The torque includes contacts, grease, bearings and seals. The temperatures are 20 and 60 °C (`SETTINGS.cold` and
    `warm`).
    """
    design = reducer.design
    speeds = np.array(SETTINGS.speed_shares) * abs(design.drive.speed)
    curves: list[Curve] = []
    for temperature in (SETTINGS.cold, SETTINGS.warm):
        if reducer.design.has_film or not curves:  # Coulomb friction is the same at both temperatures
            contacts = _contact_torques_by_speed(reducer, speeds, temperature)
        idle_torques = [no_load_torque(reducer, float(speed), temperature).total for speed in speeds]
        name = f"{temperature:g} °C"
        panel = "No-load torque"
        curves.append(
            Curve(panel, name, speeds / RPM, contacts + idle_torques, "input speed [rpm]", "crank torque [N m]")
        )
    return tuple(curves)


def grease_rows(design: Design) -> Iterator[Quantity]:
    """Yield the rows of the viscosity of the grease [mm2/s] and of the lowest ambient temperature [°C]."""
    grease = grease_of(design)
    yield Quantity("base_oil_viscosity", "Grease, base oil at 40 °C", grease.viscosity_40, "mm2/s", note=grease.name)
    note = "assumed: the grease (K2K-20)" if grease.coldest == GREASE.coldest else f"assumed: {grease.name}"
    yield Quantity("ambient_min", "Ambient temperature, from", grease.coldest, "°C", note=note)


def environment_rows(reducer: Reducer) -> Iterator[Quantity]:
    """Yield the data-sheet rows of grease viscosity, lowest and highest ambient temperature, and permissible duty.

    The duty is the share of the time at nominal torque and speed [%] that heat allows. Temperature rises are assumed to
    be the share of the time multiplied by those in the steady state of continuous duty (`solve_steady_state`). The
    highest ambient temperature is left out if the nominal torque allows no temperature in the range of the grease. If
    the sizes are those of warm parts (``thermal.applied``), only the rows of the grease are yielded.
    """
    design = reducer.design
    yield from grease_rows(design)
    if design.thermal.applied:
        return
    duty_share, ambient = design.service.duty_share, design.service.ambient_temperature
    continuous = reducer_of(design.at_reference.but(service={"duty_share": 1.0}))
    temperatures = solve_steady_state(continuous, constant_duty(design.rated_torque, design.drive.speed)).temperatures
    rises = {part: value - ambient for part, value in temperatures.items()}
    rise_limit, max_rise = find_rise_limit(continuous, rises), duty_share * max(rises.values())
    limit = min(heat_limits(reducer), key=lambda item: item.temperature)
    condition = f"{design.rated_torque:.4g} N m, {describe_speed(reducer)}, {describe_cooling(design)}"
    limit_text = f"{limit.temperature:g} °C at the hottest part ({limit.name})"
    if limit.temperature - max_rise >= grease_of(design).coldest:
        jam_note = "; the parts jam at any ambient temperature" if thermal(design).jams else ""
        note = f"{condition}, {describe_duty(design)}; then {limit_text}{jam_note}"
        yield Quantity("ambient_max", "Ambient temperature, to", limit.temperature - max_rise, "°C", note=note)
    share = 100.0 * min(rise_limit.factor, 1.0)
    note = f"{condition}; limit: {rise_limit.name if share < 100.0 else limit_text}"
    yield Quantity("duty", "Duty at nominal torque and speed", share, "%", note=note)


def backlash_with_bearings(reducer: Reducer) -> Iterator[Quantity]:
    """Yield the backlash [arcmin] with the play of needle bearings and rollers, which no clearance of a design has.

    It is the mean over a turn without load, by statics. Yields nothing without such bearings.
    """
    clearances, added_clearances = reducer.design.clearance, bearing_clearances(reducer)
    if not added_clearances:
        return
    total_clearances = {key: getattr(clearances, key) + play for key, (_, play) in added_clearances.items()}
    backlash = sheet_part(reducer.but(clearance=total_clearances), "motions")["backlash"]
    play_text = ", ".join(f"{key} {1e6 * play:.3g} um ({fit})" for key, (fit, play) in added_clearances.items())
    note = f"without load, mean over a turn; mean radial play of needles and rollers added: {play_text}"
    yield with_name(replace(backlash, key="backlash_with_bearings"), "Backlash, with bearings", note)


def thermal_torque_row(reducer: Reducer, state: ThermalState, condition: str) -> Iterator[Quantity]:
    """Yield the row of the thermal torque limit [N m] in a thermal `state` of a drive; nothing if it is infinite.

    The note has the `condition`, what limits the torque, and a smaller momentary torque.
    """
    if math.isfinite(state.torque):
        limit_text = replace(state, momentary_torque=momentary_torque(reducer)[0]).torque_words
        note = f"{condition}; limit: {limit_text}"
        yield Quantity("thermal_torque", "Thermal torque limit", state.torque, "N m", note=note)


def mounting_rows(reducer: Reducer, efficiency: float) -> Iterator[Quantity]:
    """Yield the data-sheet rows for mounting a drive with covers.

    They are radial and axial run-out of the output [um], radial load at the end of the input shaft [N], continuous
    torque of the motor and tightening torque of each screwed joint [N m]. `efficiency` is that of the drive at its
    nominal torque and speed (0 to 1).
    """
    design, covers = reducer.design, casing(reducer)
    bore_mm = 1e3 * covers.hub.bore
    radial_run_out = next(
        (run_out for max_bore, run_out in RADIAL_RUN_OUTS if bore_mm <= max_bore), RADIAL_RUN_OUTS[-1][1]
    )
    if covers.hub.has_crossed_rollers:
        axial_run_out, reason = (
            float(radial_run_out),
            "that of the inner ring, as large as the radial one (THK, No. 382-3E)",
        )
    else:
        inner_z, outer_z = (0.5 * sum(ends) for ends in covers.bearings)
        axial_run_out = 2.0 * radial_run_out * covers.flange_radius / (outer_z - inner_z)
        reason = "both bearings tilt the hub"
    bearing = f"{covers.hub.designation}, normal class (ISO 492, K_ia)"
    yield Quantity("radial_run_out", "Run-out of the output, radial", radial_run_out, "um", note=f"at most; {bearing}")
    yield Quantity(
        "axial_run_out",
        "Run-out of the output flange, axial",
        axial_run_out,
        "um",
        note=f"at most, at {2e3 * covers.flange_radius:.4g} mm diameter: {reason}",
    )
    yield _input_load_row(reducer)
    motor_torque = design.drive.torque / efficiency
    condition = f"for {design.rated_torque:.4g} N m at {describe_speed(reducer)}, efficiency {efficiency:.1%}"
    power = f"{abs(motor_torque * design.drive.speed):.3g} W"
    note = f"{covers.motor.name}; {condition}, {power}"
    yield Quantity("motor_torque", "Motor, continuous torque", motor_torque, "N m", note=note)
    for screwed_joint in screwed_joints(reducer):
        key = screwed_joint.joint.name.replace(" ", "_")
        note = f"{screwed_joint.designation}, {1e-3 * screwed_joint.preload:.3g} kN each, friction 0.12 (VDI 2230)"
        name = f"Tightening, {screwed_joint.joint.name}"
        yield Quantity(f"tightening_{key}", name, screwed_joint.tightening_torque, "N m", note=note)


def _input_load_row(reducer: Reducer) -> Quantity:
    """Compute the limit of a radial load at the end of the input shaft [N], in addition to the nominal torque.

    The bearings of the shaft limit it, by their life (ISO 281) and static rating.
    """
    design, shaft = reducer.design, shaft_dimensions(reducer)
    loading = solve_loading(
        reducer, constant_duty(design.rated_torque, design.drive.speed).points[0], with_wind_up=False
    )
    far_bearing, near_bearing = (0.5 * sum(ends) for ends in shaft.bearings)
    shaft_end = crank_segments(reducer)["journal"].z0
    near_share = (shaft_end - far_bearing) / (near_bearing - far_bearing)
    shares = {"shaft_bearing_far": 1.0 - near_share, "shaft_bearing_near": near_share}
    limits = []
    for bearing in bearings_of(reducer):
        if share := abs(shares.get(bearing.key, 0.0)):
            speed = bearing.speed(reducer, design.drive.speed)
            force_for_life = rolling.load_for_life(
                bearing.ratings.dynamic, design.service.life, speed, design.bearing.reliability
            )
            nominal_force = float(bearing_forces(reducer, bearing.key, loading).max())
            spare_force = min(force_for_life / design.bearing.service_factor, bearing.ratings.static) - nominal_force
            limits.append(max(spare_force, 0.0) / share)
    return Quantity(
        "input_radial_load",
        "Radial load on the input shaft",
        min(limits),
        "N",
        note=f"at its end, {design.service.life:g} h; in addition to {design.rated_torque:.4g} N m",
    )
