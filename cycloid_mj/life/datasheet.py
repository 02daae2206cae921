"""What a maker's data sheet tells of a reducer, each number with the condition under which it holds."""

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np

from cycloid_mj.base.engine import Progress, silent
from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.frame import Frame
from cycloid_mj.base.names import PIN, SHAFT
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.result import Curve, Quantity, quantity_frame
from cycloid_mj.base.units import ARCMINUTE, RPM
from cycloid_mj.design import PARTS, Design, Named, resolve
from cycloid_mj.figures import figure, quantities, quantity, values_json
from cycloid_mj.life.bearings import bearing_losses
from cycloid_mj.life.duty import DutyPoint, steady
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.items import rate_at_rated_load
from cycloid_mj.life.loading import loading
from cycloid_mj.life.output_bearing import USUAL, hub
from cycloid_mj.life.rated import is_bearing_life, is_held_once, rated_torque
from cycloid_mj.parts import body_solids, mass_properties, moving_masses, parts, turning_inertia
from cycloid_mj.parts.accuracy import VISUAL_CHORD_ERROR
from cycloid_mj.parts.export.casing import FLANGE_CIRCLE, FLANGE_SCREWS, casing
from cycloid_mj.parts.export.drive import has_casing
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import loads, powers, springs_of
from cycloid_mj.statics.sheet import Sheet, sheet

FEW, NEAR = 61, 2e-3
"""Crank angles, and relative accuracy, of the points of a curve."""

SPEEDS = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0)
TORQUES = (0.05, 0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.25)
TURNS = (0.01, 0.03, 0.1, 0.25, 0.5, 0.75, 1.0)
"""Shares of the rated speed and torque at which curves have their points."""


WHOLE = {
    "drive_mass_kg": ("Mass", "with covers, bearings, screws; without motor and grease"),
    "drive_inertia_kg_cm2": ("Inertia at the input", "with the output's hub and flange; without the motor"),
    "drive_length_mm": ("Length over all", "motor's flange to output's"),
    "drive_diameter_mm": ("Diameter over all", "of the covers"),
}
"""Figures of the whole drive -> name, and condition."""

LUBRICANT = "grease of lithium soap, NLGI 2, its base oil a PAO where parts are of plastic (assumed)"


@dataclass(frozen=True, repr=False)
class Datasheet(Presented):
    """The data sheet of one design.

    Attributes
    ----------
    design
        The design.
    life
        Hours that the rated torque is for.
    groups
        Heading -> quantities; the note of each is its condition.
    curves
        Of the panels, in their order.
    notes
        What all of it stands on, a sentence each.
    figures
        The catalogue's, of geometry and statics, by key.
    weakest
        What decides the rated torque.
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
        return quantity_frame({one.key: one for group in self.groups.values() for one in group})

    @property
    def line(self) -> str:
        """Design, rated torque, life, and what decides them."""
        torque = self.value("rated_torque")
        return f"{self.design.name}, rated torque {torque:.4g} N m for {self.life:g} h by {self.weakest.name}"

    def value(self, key: str) -> float:
        """Return the value of a quantity."""
        return next(one.value for group in self.groups.values() for one in group if one.key == key)

    def as_json(self) -> dict[str, Any]:
        """Convert the sheet to JSON values."""
        items = [one for group in self.groups.values() for one in group]
        return {
            "design": self.design.name,
            "rated_torque_nm": self.value("rated_torque"),
            "life_h": self.life,
            "momentary_torque_nm": self.value("momentary_torque"),
            "lubricant": f"{LUBRICANT}, to {self.design.service.grease_temperature:g} °C",
            "weakest": {"key": self.weakest.key, **self.weakest.as_json()},
            "quantities": {
                item.key: {"name": item.name, "value": item.value, "unit": item.unit, "condition": item.note}
                for item in items
            },
            "figures": values_json(self.figures),
            "curves": [curve.as_json() for curve in self.curves],
            "notes": list(self.notes),
        }


def datasheet(reducer: Reducer, life: float = 0.0, progress: Progress = silent) -> Datasheet:
    """Compute the data sheet of a sound design, its rated torque at the rated speed for a life [h] (0: its own).

    `progress` is called with how many parts of the work are done, and of how many.
    """
    design = reducer.design
    life = life or design.service.life
    whole, done = len(SPEEDS) + 4, count(1)

    def advance() -> None:
        progress(next(done), whole)

    static = sheet(reducer, design.rated_torque)
    advance()
    momentary, stop = momentary_torque(reducer)
    lasting = rated_torque(reducer, design.drive.speed, life)
    rated, weakest = min(lasting, (momentary, stop), key=lambda one: one[0])
    advance()
    groups = {
        "Ratings": _ratings(reducer, life, (rated, weakest), (momentary, stop)),
        "Accuracy and stiffness": _accuracy(reducer, static),
        "Efficiency and heat": _efficiency(reducer, static),
        "Speed": _speeds(reducer),
        "Mass and size": _mass(reducer),
    }
    if has_casing(reducer):
        groups |= {"Output bearing": _bearing(reducer), "Interfaces": _interfaces(reducer)}
    advance()
    curves = (
        life_curve(reducer, life, momentary, lasting[0], advance),
        _efficiency_curve(reducer),
        _wind_up_curve(reducer),
    )
    figures = quantities(reducer.but(load={"torque": design.rated_torque}))
    advance()
    return Datasheet(
        design=design,
        life=life,
        groups=groups,
        curves=curves,
        notes=_notes(reducer, life, static),
        figures=figures,
        weakest=weakest,
    )


def momentary_torque(reducer: Reducer) -> tuple[float, RatedItem]:
    """Compute the torque [N m] that is held once with a safety of 1, and the item that ends it.

    Forces go with the torque from those at the nominal torque.
    """
    design = reducer.design
    duty = steady(design.rated_torque, design.drive.speed)
    stops = [item for item in rate_at_rated_load(reducer).items.values() if is_held_once(item.key)]
    first = min(stops, key=lambda item: item.safety or 0.0)
    return duty.peak * (first.safety or 0.0), first


def _ratings(
    reducer: Reducer, life: float, lasting: tuple[float, RatedItem], once: tuple[float, RatedItem]
) -> tuple[Quantity, ...]:
    design = reducer.design
    speed, way = design.drive.speed, "forwards" if design.ratio > 0 else "backwards"
    at = f"{abs(speed) / RPM:.0f} rpm input"
    by_bearings, bearing = rated_torque(reducer, speed, life, is_bearing_life)
    (rated, weakest), (momentary, stop) = lasting, once
    return (
        Quantity("ratio", "Reduction ratio", design.reduction, "1", note=f"input to output, turning {way}"),
        Quantity("rated_torque", f"Rated torque, {life:g} h", rated, "N m", note=f"{at}, safety 1; by {weakest.name}"),
        Quantity(
            "bearing_torque",
            "Torque by its bearings alone",
            by_bearings,
            "N m",
            note=f"{life:g} h, {at}; by {bearing.name}",
        ),
        Quantity(
            "momentary_torque",
            "Momentary torque",
            momentary,
            "N m",
            note=f"once, safety 1; by {stop.name}",
        ),
        Quantity(
            "nominal_torque",
            "Nominal torque",
            design.rated_torque,
            "N m",
            note="motor torque times the ratio (drive.torque_nm); figures below are at this torque",
        ),
        Quantity("input_speed", "Rated input speed", abs(speed) / RPM, "rpm", note="of the crank"),
    )


def _accuracy(reducer: Reducer, static: Sheet) -> tuple[Quantity, ...]:
    quantities, at = static.quantities, f"{reducer.design.rated_torque:.4g} N m"
    error = quantities["output_peak_to_peak_loaded_forward_speed"]
    return (
        _renamed(quantities["backlash"], "Backlash", "without load, mean of a turn"),
        _renamed(quantities["lost_motion_ideal"], "Lost motion", f"at 3 % of {at}, both ways"),
        _renamed(quantities["stiffness_ideal"], "Torsional stiffness", f"50 to 100 % of {at}, input locked"),
        _renamed(error, "Transmission error, peak to peak", f"{at}, forward, slow"),
    )


def _efficiency(reducer: Reducer, static: Sheet) -> tuple[Quantity, ...]:
    design = reducer.design
    quantities = static.quantities
    at = f"{design.rated_torque:.4g} N m, {abs(design.drive.speed) / RPM:.0f} rpm"
    hot = rate_at_rated_load(reducer).items["temperature"]
    ambient = design.service.ambient_temperature
    return (
        _figure(reducer, "drive_efficiency_percent", "Efficiency", f"{at}, all bearings included"),
        _renamed(quantities["efficiency"], "Efficiency of the contacts", f"{at}, without bearings of shaft and output"),
        _renamed(quantities["back_driving_torque_rated"], "Back-driving torque", "against drive.torque_nm"),
        _figure(reducer, "back_driving_torque_free_nm", "Back-driving torque, crank free", "without a motor, slowly"),
        _figure(reducer, "no_load_torque_nm", "No-load running torque", f"on the crank, {_speed(reducer)}"),
        _figure(reducer, "starting_torque_nm", "Starting torque", "on the crank, without a load"),
        Quantity("temperature_rise", "Temperature rise", hot.value - ambient, "K", note=f"{at}, still air"),
    )


def _speeds(reducer: Reducer) -> tuple[Quantity, ...]:
    return (
        _figure(
            reducer, "continuous_speed_rpm", "Input speed, all of the time", "nominal torque, S1, by heat, bearings"
        ),
        _figure(reducer, "intermittent_speed_rpm", "Input speed, a quarter of it", "nominal torque, S3 25 %"),
        _figure(reducer, "largest_speed_rpm", "Largest input speed", "bearings, n d_m 300 000, grease"),
    )


def _bearing(reducer: Reducer) -> tuple[Quantity, ...]:
    """Compute what the output's flange carries; the spread of its stiffness is that of the balls' load."""
    seat, torque = hub(reducer), f"beside {reducer.design.rated_torque:.4g} N m"
    loose = seat.tilting_stiffness(USUAL) * ARCMINUTE
    bearings = f"2 x {seat.bearing.designation}, {1e3 * seat.spacing:.4g} mm apart"
    return (
        _figure(reducer, "output_tilting_capacity_nm", "Tilting moment", f"{torque}; {bearings}, ISO 281 and 76"),
        _figure(
            reducer,
            "output_tilting_stiffness_nm_per_arcmin",
            "Tilting stiffness",
            f"at half of it, Palmgren; {loose:.3g} with usual clearance, taken up",
        ),
        _figure(reducer, "output_radial_load_n", "Radial load", f"on the flange's face, {torque}"),
        _figure(reducer, "output_axial_load_n", "Axial load", "alone, 0.25 C0 (SKF)"),
    )


def _interfaces(reducer: Reducer) -> tuple[Quantity, ...]:
    """List what motor, load and frame are bolted to [mm]."""
    sizes = casing(reducer)
    motor, screws = sizes.motor, sizes.screws
    coupled = f"shaft of {2e3 * motor.shaft:.4g} mm" if motor.shaft else "coupled to the journal"
    return (
        Quantity("motor_circle", "Motor flange, bolt circle", 2e3 * motor.circle, "mm", note=_threads(4, motor.thread)),
        Quantity("motor_pilot", "Motor flange, pilot", 2e3 * motor.pilot, "mm", note=f"{motor.name}, {coupled}"),
        Quantity(
            "output_circle",
            "Output flange, bolt circle",
            1e3 * FLANGE_CIRCLE * sizes.hub.bore,
            "mm",
            note=_threads(FLANGE_SCREWS, sizes.flange_bolt.thread),
        ),
        Quantity("cover_diameter", "Covers, diameter", 2e3 * sizes.outer, "mm", note="both"),
        Quantity(
            "cover_circle",
            "Covers, bolt circle",
            2e3 * screws.circle,
            "mm",
            note=_threads(len(screws.angles), screws.bolt.thread),
        ),
    )


def _threads(count: int, thread: float) -> str:
    return f"{count} x M{1e3 * thread:g}"


def _speed(reducer: Reducer) -> str:
    return f"{abs(reducer.design.drive.speed) / RPM:.0f} rpm"


def _figure(reducer: Reducer, key: str, name: str, condition: str) -> Quantity:
    """Compute a figure of the catalogue for a line of the sheet; one that cannot be computed says why."""
    computed = quantity(reducer, key)
    note = condition if math.isfinite(computed.value) else computed.note
    return Quantity(key, name, computed.value, computed.unit, note=note)


def _renamed(quantity: Quantity, name: str, condition: str) -> Quantity:
    return Quantity(quantity.key, name, quantity.value, quantity.unit, note=quantity.note or condition)


def _mass(reducer: Reducer) -> tuple[Quantity, ...]:
    design = reducer.design
    gear, housing = design.gear, design.housing
    solids = {name: mass_properties(solid) for name, solid in body_solids(reducer).items()}
    count = {PIN: design.ring.teeth}
    mass = sum(solid.mass * count.get(name, 1) for name, solid in solids.items())
    length = axial_extent(reducer)
    return (
        Quantity("mass", "Mass of the mechanism", mass, "kg", note="parts as drawn: no covers, no bearings' rings"),
        Quantity("inertia", "Inertia of the mechanism", 1e4 * input_inertia(reducer), "kg cm2", note="at the input"),
        *(
            _figure(reducer, key, name, condition)
            for key, (name, condition) in WHOLE.items()
            if figure(key).exists(reducer)
        ),
        Quantity("outer_diameter", "Outer diameter", 2e3 * housing.outer_radius, "mm", note="ring"),
        Quantity(
            "length",
            "Length of the mechanism",
            1e3 * (length[1] - length[0]),
            "mm",
            note="input journal to output disc",
        ),
        Quantity("input_diameter", "Input shaft diameter", 2e3 * design.shaft.radius, "mm", note="journal"),
        Quantity(
            "face_width", "Face width", 1e3 * gear.face_width, "mm", note=f"of {gear.discs} disc{'s'[: gear.discs > 1]}"
        ),
    )


def input_inertia(reducer: Reducer) -> float:
    """Compute the inertia at the input [kg m2]: of crank, discs on their orbit, and what turns slowly over the ratio^2.

    Pins that spin in a ring that is held are left out: some 1e-4 of it.
    """
    design, masses = reducer.design, moving_masses(reducer)
    shaft, discs = masses[SHAFT], [masses[disc.part] for disc in reducer.mechanism.discs]
    crank = shaft.inertia[2, 2] + shaft.mass * float(np.sum(shaft.centroid[:2] ** 2))
    orbit = sum(disc.mass for disc in discs) * design.gear.eccentricity**2
    return float(crank) + orbit + turning_inertia(reducer) / design.reduction**2


def axial_extent(reducer: Reducer) -> tuple[float, float]:
    """Compute where the reducer begins and ends along z [m]."""
    drawn = parts(reducer, VISUAL_CHORD_ERROR).values()
    ends = [end for solid in drawn for prism in solid.prisms for end in (prism.z0, prism.z1)]
    return min(ends), max(ends)


def life_curve(
    reducer: Reducer,
    life: float,
    momentary: float = np.inf,
    rated: float = 0.0,
    advance: Callable[[], None] = lambda: None,
) -> Curve:
    """Compute the rated torque over the speed.

    Parameters
    ----------
    reducer, life
        Whose, and for how many hours.
    momentary
        Momentary torque, which ends the curve above [N m].
    rated
        Rated torque at the design's own speed, where it is known [N m].
    advance
        Called after each speed.

    Speeds at which no torque lasts so long have no point.
    """
    points: list[tuple[float, float]] = []
    for share in SPEEDS:
        speed = share * abs(reducer.design.drive.speed)
        with suppress(DesignError):
            torque = rated if share == 1.0 else 0.0
            if not torque:
                guess = points[-1][1] if points else rated
                torque, _ = rated_torque(reducer, speed, life, guess=guess, poses=FEW, exact=NEAR)
            points.append((speed / RPM, min(torque, momentary)))
        advance()
    x, y = np.array(points).T
    return Curve(f"Rated torque for {life:g} h", "all items", x, y, "input speed [rpm]", "output torque [N m]")


def _efficiency_curve(reducer: Reducer) -> Curve:
    """Compute the efficiency over the torque, all bearings included: their losses are a straight line of the torque."""
    design = reducer.design
    torques, speed = np.array(TORQUES) * design.rated_torque, abs(design.drive.speed)
    ends = torques[[0, -1]]
    points = (DutyPoint(float(torque), speed, 1.0) for torque in ends)
    lost = [sum(bearing_losses(reducer, loading(reducer, point, FEW, stops=False)).values()) for point in points]
    shares = []
    for torque, in_bearings in zip(torques, np.interp(torques, ends, lost), strict=True):
        contacts = powers(reducer, float(torque))
        shares.append(contacts.delivered / (contacts.supplied + in_bearings))
    panel = f"Efficiency at {speed / RPM:.0f} rpm"
    return Curve(
        panel, "all bearings included", torques, 100.0 * np.array(shares), "output torque [N m]", "efficiency [%]"
    )


def _wind_up_curve(reducer: Reducer) -> Curve:
    still = reducer.but(drive={"speed": 0.0}, environment={"gravity_x": 0.0, "gravity_y": 0.0})
    springs = springs_of(still, friction=False)
    torques = reducer.design.rated_torque * np.array([*(-np.array(TURNS[::-1])), *TURNS])
    turns = [float(loads(still, springs, float(torque)).output_turn.mean()) / ARCMINUTE for torque in torques]
    panel = "Torsion, input locked"
    return Curve(panel, "mean of a turn", torques, np.array(turns), "output torque [N m]", "output turn [arcmin]")


def _notes(reducer: Reducer, life: float, static: Sheet) -> tuple[str, ...]:
    return (
        f"Computed by cycloid_mj from the design {reducer.design.name}; nothing here is measured on a built drive.",
        f"Rated torque: what bearings (ISO 281, 90 %), surfaces (pitting, shakedown), parts (Goodman) and heat "
        f"bear for {life:g} h, and what is held once; wear is left out. Momentary torque: held once, by first yield, "
        "dents, bent or sheared pins, or a jumped tooth. Both with a safety of 1.",
        _materials(reducer),
        f"Lubricant: {LUBRICANT}, to {reducer.design.service.grease_temperature:g} °C.",
        *(f"{sentence[0].upper()}{sentence[1:]}." for sentence in static.assumptions),
    )


def _materials(reducer: Reducer) -> str:
    """Describe materials and clearances."""
    design = reducer.design
    materials = ", ".join(f"{part} {design.material_of(part).name or 'of its own numbers'}" for part in PARTS)
    clearances = ", ".join(
        f"{kind.replace('_', ' ')} {1e6 * getattr(design.clearance, kind):.4g}" for kind in design.pair_kinds
    )
    return f"Materials: {materials}. Clearances [um]: {clearances}."


def datasheet_of(design: Named, life_h: float = 0.0) -> Datasheet:
    """Compute the data sheet of a design; from Python as ``cm.datasheet(design)``.

    Parameters
    ----------
    design
        A sound design, or the name of a preset or a file.
    life_h
        Hours that the rated torque is for; by default the design's own.

    Raises
    ------
    UsageError
        There is no such design.
    DesignError
        The design cannot be read, its crank stands still, or nothing bears even the least torque for so long.
    RunError
        No static balance was found, as where friction jams the reducer.
    """
    return datasheet(Reducer(resolve(design)), life_h)
