"""Heat: how warm the housing gets, what that does to the clearances, and what the materials bear."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from cycloid_mj.design import PARTNERS, PARTS
from cycloid_mj.design.materials import MATERIALS
from cycloid_mj.design.model import Service
from cycloid_mj.life.bearings import bearing_losses
from cycloid_mj.life.item import RatedItem
from cycloid_mj.life.loading import Loading
from cycloid_mj.parts.export.casing import casing
from cycloid_mj.parts.export.drive import has_casing
from cycloid_mj.reducer import Reducer

HOTTEST = 120.0
"""Service temperature [°C] of a material that is not of the library (assumed)."""

GREASE = "service.grease_temperature_c, assumed: from 100 to 120 on greases are made for heat, its maker tells"
SEALS = "service.seal_temperature_c, assumed: nitrile rubber lasts to some 100, FKM to 200, its maker tells"
"""Where the limits of what seals and lubricates are from.

"High-Temperature Lubricants", Machinery Lubrication 30674: 100 to 120 °C is where those begin; 10 K halve an oil's
life. Grundfos, "Shaft Seals", p. 22: nitrile rubber to 100 °C (120 for short), FKM to 200 °C.
"""

STILL_AIR = 8.0, 15.0
"""What a housing gives to still air, from least to most [W/(m2 K)]."""

REFERENCE = 20.0
"""Temperature [°C] at which clearances are as drawn (ISO 1)."""


def heat(reducer: Reducer, loadings: Sequence[Loading]) -> Iterator[RatedItem]:
    """Rate the housing's temperature in still air, and the clearance that each kind of pair loses by it."""
    design = reducer.design
    service = design.service
    losses = mean_losses(reducer, loadings)
    lost = sum(losses.values())
    area = outside(reducer)
    hot = service.ambient_temperature + lost / (service.film_coefficient * area)
    limits = sorted(hottest(reducer), key=lambda one: one.hottest)
    first = limits[0]
    yield RatedItem(
        "power_lost",
        "power lost",
        lost,
        math.nan,
        "W",
        None,
        None,
        "friction of teeth, cam, output pins and seals, mu F d/2 of the bearings of shaft and output; mean of the duty",
        ", ".join(f"{part.replace('_', ' ')} {power:.3g} W" for part, power in losses.items())
        + ("" if has_casing(reducer) else "; the output's bearing is left out: the drive has no covers to hold it"),
    )
    warm, cool = (service.ambient_temperature + lost / (film * area) for film in STILL_AIR)
    rise, room = hot - service.ambient_temperature, first.hottest - service.ambient_temperature
    yield RatedItem(
        "temperature",
        f"housing temperature, {first.name}",
        hot,
        first.hottest,
        "°C",
        room / rise if rise else math.inf,
        None,
        "dT = losses/(h A); safety of the rise",
        f"{lost:.3g} W at h {service.film_coefficient:g} W/(m2 K) (assumed; {warm:.3g} to {cool:.3g} °C at 8 to 15) "
        f"from {1e4 * area:.3g} cm2, the outside of {_outside_of(reducer)}; "
        f"{service.ambient_temperature:g} °C around it; limits: "
        f"{', '.join(f'{limit.hottest:g} °C {limit.name} ({limit.source})' for limit in limits)}",
    )
    for kind in design.pair_kinds:
        grown = clearance_growth(reducer, kind) * (hot - REFERENCE)
        clearance = getattr(design.clearance, kind)
        materials = " on ".join(design.material_of(one).name or "unnamed" for one in PARTNERS[kind])
        yield RatedItem(
            f"{kind}_hot_clearance",
            f"clearance of {kind.replace('_', ' ')} lost by heat",
            0.0 - 1e6 * grown,
            1e6 * clearance,
            "um",
            clearance / -grown if grown < 0.0 else math.inf,
            None,
            "both parts' thermal expansion from 20 °C; safety of the clearance",
            f"all parts at the housing's {hot:.3g} °C (assumed); {materials}; less than nothing: it grows",
        )


def mean_losses(reducer: Reducer, loadings: Sequence[Loading]) -> dict[str, float]:
    """Compute the mean power lost over a duty by part [W]: the contacts, the seals, and each bearing."""
    total: dict[str, float] = {}
    for loading in loadings:
        for part, power in {**loading.losses, **bearing_losses(reducer, loading)}.items():
            total[part] = total.get(part, 0.0) + power * loading.point.share
    return total


def outside(reducer: Reducer) -> float:
    """Compute what gives heat to the air [m2]: the outside of the covers, but for what motor and load are bolted to.

    Without covers, it is a cylinder round ring and output disc, both ends included.
    """
    design = reducer.design
    if has_casing(reducer):
        sizes = casing(reducer)
        bolted = sizes.motor.circle**2 + sizes.flange_radius**2
        return math.pi * (2.0 * sizes.outer * (sizes.outer + sizes.top - sizes.face) - bolted)
    radius = design.housing.outer_radius
    return 2.0 * math.pi * radius * (radius + design.gear.stack_width + design.output.disc_thickness)


def _outside_of(reducer: Reducer) -> str:
    return "the covers, without their flanges" if has_casing(reducer) else "ring and output disc"


def clearance_growth(reducer: Reducer, kind: str) -> float:
    """Compute how much the clearance of a kind of pair grows per kelvin [m/K]; the tightest place counts.

    Pins stand on the housing's circle, output pins on the output disc's, the gear grows from its centre:
    mesh a_h E - a_p rho - a_g (E - rho), output a_g r_h - a_o r_o - |a_g - a_o| R_o, others a_bore r - a_pin r.
    """
    design = reducer.design
    ring, output = design.ring, design.output
    alpha = {part: design.material_of(part).expansion for part in PARTS}
    if kind == "pin_gear":
        tips = ring.pin_circle_radius - ring.pin_radius
        return alpha["housing"] * ring.pin_circle_radius - alpha["pin"] * ring.pin_radius - alpha["gear"] * tips
    if kind == "tooth":
        return (alpha["housing"] - alpha["gear"]) * (ring.pin_circle_radius - ring.pin_radius)
    if kind == "output":
        apart = abs(alpha["gear"] - alpha["output"]) * output.pin_circle_radius
        return (
            alpha["gear"] * output.hole_radius
            - alpha["output"] * (output.pin_radius + design.gear.eccentricity)
            - apart
        )
    inner, outer = {"cam": ("shaft", "gear"), "pin_socket": ("pin", "housing"), "pin_sleeve": ("pin", "pin")}[kind]
    radius = {"cam": design.gear.bore_radius, "pin_socket": ring.pin_radius, "pin_sleeve": ring.sleeve_bore_radius}[
        kind
    ]
    return (alpha[outer] - alpha[inner]) * radius


@dataclass(frozen=True)
class HeatLimit:
    """What ends first when a reducer gets hot: its name, the temperature it bears [°C], and where that is from."""

    name: str
    hottest: float
    source: str


def hottest(reducer: Reducer) -> Iterator[HeatLimit]:
    """List what bears a temperature: grease, seals and every material of a part; `HOTTEST` where that is unknown."""
    design = reducer.design
    for name, temperature, source in (
        ("grease", design.service.grease_temperature, GREASE),
        ("seals", design.service.seal_temperature, SEALS),
    ):
        usual = Service.model_fields[f"{name.rstrip('s')}_temperature"].default
        yield HeatLimit(name, temperature, source if temperature == usual else "of the design file")
    parts: dict[str, list[str]] = {}
    for part in PARTS:
        parts.setdefault(design.material_of(part).name, []).append(part)
    for material, made in parts.items():
        entry, name = MATERIALS.get(material), f"{' and '.join(made)}, {material or 'a material without a name'}"
        yield HeatLimit(name, entry.hottest, "library") if entry else HeatLimit(name, HOTTEST, "assumed")
