"""Heat: temperature of the housing, thermal change of the clearances, and limits of grease, seals and materials."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from cycloid_mj.base.units import FREEZING_POINT
from cycloid_mj.design import PARTNERS, PARTS, Design
from cycloid_mj.design.materials import MATERIALS
from cycloid_mj.design.model import Service
from cycloid_mj.life.bearings import bearing_losses
from cycloid_mj.life.loading import Loading
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.parts.export.drive import has_casing
from cycloid_mj.reducer import Reducer, RvReducer

USUAL_LIMIT = 120.0
"""Assumed service temperature of a material that is not in the library [°C]."""

GREASE = "service.grease_temperature_c, assumed: above 100 to 120 special greases are needed, see its data sheet"
SEALS = "service.seal_temperature_c, assumed: nitrile rubber to about 100, FKM to 200, see its data sheet"
"""Sources of the limits of grease and seals.

"High-Temperature Lubricants", Machinery Lubrication 30674: they begin at 100 to 120 °C; 10 K halve the life of an oil.
Grundfos, "Shaft Seals", p. 22: nitrile rubber to 100 °C (120 for a short time), FKM to 200 °C.
"""

STILL_AIR = 8.0, 15.0
"""Range of the heat transfer coefficient of a housing in still air [W/(m2 K)]."""

COOLING = {"still": 12.0, "mounted": 18.0, "fan": 30.0}
"""Heat transfer coefficient of the housing [W/(m2 K)]: in still air, bolted to a machine that conducts as much again as
half of its surface gives off, and in a stream of 2 to 3 m/s (assumed; still air has 8 to 15)."""


def running_share(reducer: Reducer, loadings: Sequence[Loading]) -> float:
    """Return the share of the time [1] by which `mean_losses` of a duty are to be multiplied: that of rests it omits.

    It is ``service.duty_share`` for a constant duty, and 1 for several points, among which a duty file states its rests
    (as `duty.add_rests`).
    """
    return reducer.design.service.duty_share if len(loadings) == 1 and loadings[0].point.share == 1.0 else 1.0


def mean_losses(reducer: Reducer, loadings: Sequence[Loading]) -> dict[str, float]:
    """Compute the mean power lost over a duty [W], by source: the contacts, the seals, and each bearing."""
    mean_power: dict[str, float] = {}
    for loading in loadings:
        for source, power in {**loading.losses, **bearing_losses(reducer, loading)}.items():
            mean_power[source] = mean_power.get(source, 0.0) + power * loading.point.share
    return mean_power


def still_air_coefficient(
    height: float, wall_temperature: float, ambient_temperature: float, emissivity: float
) -> float:
    """Compute the heat transfer coefficient of a housing in still air by convection and radiation [W/(m2 K)].

    By ISO/TR 14179-2 it is 18 (H/0.1)^-0.1 ((T_w - T_a)/T_a)^0.3 + 0.23e-6 eps ((T_w + T_a)/2)^3, with T_w and T_a in
    kelvin. A wall that is colder than the air has no convection.

    Parameters
    ----------
    height
        Height H of the housing [m].
    wall_temperature, ambient_temperature
        Temperatures T_w of the outer wall of the housing and T_a of the air [°C].
    emissivity
        Emissivity eps of the wall [1].
    """
    wall_kelvin, air_kelvin = wall_temperature + FREEZING_POINT, ambient_temperature + FREEZING_POINT
    convection = 18.0 * (height / 0.1) ** -0.1 * (max(wall_kelvin - air_kelvin, 0.0) / air_kelvin) ** 0.3
    return float(convection + 0.23e-6 * emissivity * (0.5 * (wall_kelvin + air_kelvin)) ** 3)


def heat_transfer_coefficient(reducer: Reducer, wall_temperature: float) -> float:
    """Return the heat transfer coefficient of the housing [W/(m2 K)] at its `wall_temperature` [°C].

    It is that of the design (``service.film_coefficient_w_m2_k``), or if that is 0 `still_air_coefficient`.
    """
    service = reducer.design.service
    outer_radius = casing(reducer).outer if has_casing(reducer) else reducer.design.housing.outer_radius
    emissivity = reducer.design.thermal.emissivity
    return service.film_coefficient or still_air_coefficient(
        2.0 * outer_radius, wall_temperature, service.ambient_temperature, emissivity
    )


def describe_cooling(design: Design) -> str:
    """Return the cooling of the housing in words, such as "still air" or "cooled with 18 W/(m2 K)"."""
    coefficient = design.service.film_coefficient
    return f"cooled with {coefficient:g} W/(m2 K)" if coefficient > STILL_AIR[1] else "still air"


def describe_duty(design: Design) -> str:
    """Return the share of the time under load by IEC 60034-1: "S1" for continuous load, or such as "S3 25 %"."""
    share = design.service.duty_share
    return "S1" if share == 1.0 else f"S3 {100.0 * share:.3g} %"


def housing_temperature(reducer: Reducer, power_lost: float) -> float:
    """Compute the steady temperature of the housing [°C] at which it passes `power_lost` [W] to the air."""
    ambient, area = reducer.design.service.ambient_temperature, cooling_area(reducer)
    if reducer.design.service.film_coefficient:
        return ambient + power_lost / (reducer.design.service.film_coefficient * area)
    from scipy.optimize import brentq

    max_temperature = ambient + power_lost / (
        still_air_coefficient(1.0, ambient, ambient, reducer.design.thermal.emissivity) * area
    )
    excess_power = lambda wall: heat_transfer_coefficient(reducer, wall) * area * (wall - ambient) - power_lost  # noqa: E731
    return float(brentq(excess_power, ambient, max_temperature + 1.0))


def cooling_area(reducer: Reducer) -> float:
    """Compute the area that passes heat to the air [m2]: the outside of the covers without the mounting faces.

    Without covers, it is a cylinder around ring and output disc, with both ends. For an RV reducer, it is a cylinder
    around discs and flanges.
    """
    design, radius = reducer.design, reducer.design.housing.outer_radius
    if isinstance(reducer, RvReducer):
        length = design.gear.stack_width + 2.0 * reducer.cranks.flange_thickness
        return 2.0 * math.pi * radius * (radius + length)
    if has_casing(reducer):
        drive_casing = casing(reducer)
        mounting_term = drive_casing.motor.circle**2 + drive_casing.flange_radius**2
        return math.pi * (
            2.0 * drive_casing.outer * (drive_casing.outer + drive_casing.top - drive_casing.face) - mounting_term
        )
    return 2.0 * math.pi * radius * (radius + design.gear.stack_width + design.output.disc_thickness)


def cooled_end_area(reducer: Reducer) -> float:
    """Compute the part of `cooling_area` that belongs to the output [m2].

    It is both ends of the carrier of an RV reducer, or an end of an output disc without covers. With covers it is 0,
    because they belong to the housing.
    """
    if isinstance(reducer, RvReducer):
        return 2.0 * math.pi * reducer.flange_radius**2
    return 0.0 if has_casing(reducer) else math.pi * reducer.design.housing.outer_radius**2


def clearance_growth(reducer: Reducer, kind: str) -> float:
    """Compute the growth of the clearance of a kind of mating pair per kelvin [m/K], at its tightest contact.

    It is negative if heat closes the clearance. `kind` is a key of `PARTNERS`, such as "output". All parts have the
    same temperature. Ring pins move with the housing, output pins with the output disc, and the disc expands from its
    centre. For output pins, the tightest pin includes the mismatch of the circles of pins and holes.
    """
    design = reducer.design
    ring, output = design.ring, design.output
    expansions = {part: design.material_of(part).expansion for part in PARTS}
    parts = (*PARTNERS[kind], "housing") if kind == "pin_gear" else PARTNERS[kind]
    if len({expansions[part] for part in parts}) == 1:
        return 0.0  # not the rounding error of terms that cancel
    if kind == "pin_gear":
        tip_radius = ring.pin_circle_radius - ring.pin_radius
        return (
            expansions["housing"] * ring.pin_circle_radius
            - expansions["pin"] * ring.pin_radius
            - expansions["gear"] * tip_radius
        )
    if kind == "tooth":
        return (expansions["housing"] - expansions["gear"]) * (ring.pin_circle_radius - ring.pin_radius)
    if kind == "output":
        circle_mismatch = abs(expansions["gear"] - expansions["output"]) * output.pin_circle_radius
        return (
            expansions["gear"] * output.hole_radius
            - expansions["output"] * (output.pin_radius + design.gear.eccentricity)
            - circle_mismatch
        )
    inner, outer = {"cam": ("shaft", "gear"), "pin_socket": ("pin", "housing"), "pin_sleeve": ("pin", "pin")}[kind]
    radius = {"cam": design.gear.bore_radius, "pin_socket": ring.pin_radius, "pin_sleeve": ring.sleeve_bore_radius}[
        kind
    ]
    return (expansions[outer] - expansions[inner]) * radius


@dataclass(frozen=True)
class HeatLimit:
    """A limit of the temperature of the housing: what it protects, the temperature [°C], and the source."""

    name: str
    temperature: float
    source: str


def heat_limits(reducer: Reducer) -> Iterator[HeatLimit]:
    """Yield the temperature limits [°C] of grease, seals and the material of each part, with their sources.

    A material that is not in the library has `USUAL_LIMIT`.
    """
    design = reducer.design
    for name, temperature, source in (
        ("grease", design.service.grease_temperature, GREASE),
        ("seals", design.service.seal_temperature, SEALS),
    ):
        default = Service.model_fields[f"{name.rstrip('s')}_temperature"].default
        yield HeatLimit(name, temperature, source if temperature == default else "of the design file")
    parts_by_material: dict[str, list[str]] = {}
    for part in PARTS:
        parts_by_material.setdefault(design.material_of(part).name, []).append(part)
    for material, part_names in parts_by_material.items():
        library_entry, name = (
            MATERIALS.get(material),
            f"{' and '.join(part_names)}, {material or 'a material without a name'}",
        )
        yield (
            HeatLimit(name, library_entry.hottest, "library")
            if library_entry
            else HeatLimit(name, USUAL_LIMIT, "assumed")
        )
