"""Lubricants by name: viscosity over temperature, pressure coefficient and density; dry and greased plastics.

The values are in ``lubricants.toml``, each with its source. Viscosity follows Walther (ASTM D341), the pressure
coefficient Gold et al. (2001): alpha = s nu^t.
"""

import math
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.units import FREEZING_POINT

if TYPE_CHECKING:
    from cycloid_mj.design.model import Design

TABLE = Path(__file__).with_suffix(".toml")


@dataclass(frozen=True)
class OilDensity:
    """Density of oils: temperature at which it is stated [°C], and its change with temperature [kg/(m3 K)].

    The change is a volume expansion of 7e-4 to 8e-4 1/K (ISO 91).
    """

    reference_temperature: float = 15.0
    slope: float = -0.65


DENSITY = OilDensity()


@dataclass(frozen=True)
class Lubricant:
    """An oil, or a grease with its base oil.

    Attributes
    ----------
    name, base
        Name, and kind of base oil: mineral, PAO, PAG or ester.
    viscosity_40, viscosity_100
        Kinematic viscosity of the (base) oil at 40 and 100 °C [mm2/s].
    density
        Density at 15 °C [kg/m3].
    pressure_factor, pressure_exponent
        s and t of alpha = s nu^t 1e-8 1/Pa, with nu in mm2/s (Gold et al. 2001).
    gear_factor
        Lubricant factor X_L of Schlenk's friction law (ISO/TR 14179-2).
    source
        Origin of the viscosities.
    thickener, nlgi
        Thickener and consistency of a grease; empty for an oil.
    coldest
        Lowest temperature in service [°C]: that of usual multi-purpose greases (DIN 51825, K2K-20), unless the table
        states another. The largest is ``service.grease_temperature_c``.
    """

    name: str
    base: str
    viscosity_40: float
    viscosity_100: float
    density: float
    pressure_factor: float
    pressure_exponent: float
    gear_factor: float
    source: str
    thickener: str = ""
    nlgi: str = ""
    coldest: float = -20.0

    def kinematic_viscosity(self, temperature: float) -> float:
        """Compute the kinematic viscosity [mm2/s] at a temperature [°C] by Walther's equation."""
        return walther(self.viscosity_40, self.viscosity_100, temperature)

    def viscosity(self, temperature: float) -> float:
        """Compute the dynamic viscosity [Pa s] at a temperature [°C] and ambient pressure."""
        density = self.density + DENSITY.slope * (temperature - DENSITY.reference_temperature)
        return 1e-6 * self.kinematic_viscosity(temperature) * density

    def pressure_coefficient(self, temperature: float) -> float:
        """Compute the pressure coefficient of viscosity alpha [1/Pa] at a temperature [°C] (Gold et al. 2001)."""
        return 1e-8 * self.pressure_factor * self.kinematic_viscosity(temperature) ** self.pressure_exponent


@dataclass(frozen=True)
class PlasticPair:
    """Sliding friction of a plastic: lowest and highest coefficient, dry and greased, and the dry PV limit [Pa m/s]."""

    pair: str
    dry: tuple[float, float]
    greased: tuple[float, float]
    pv_limit: float
    source: str


def walther(viscosity_40: float, viscosity_100: float, temperature: float) -> float:
    """Interpolate a kinematic viscosity [mm2/s] at a temperature [°C]: lg lg (nu + 0.7) = A - B lg T (ASTM D341)."""
    double_log_40, double_log_100 = (math.log10(math.log10(value + 0.7)) for value in (viscosity_40, viscosity_100))
    kelvin = [math.log10(FREEZING_POINT + each) for each in (40.0, 100.0, temperature)]
    slope = (double_log_40 - double_log_100) / (kelvin[1] - kelvin[0])
    return float(10.0 ** (10.0 ** (double_log_40 - slope * (kelvin[2] - kelvin[0])))) - 0.7


def lubricant_warnings(design: "Design") -> Iterator[str]:
    """Yield a warning if the temperatures of a design are outside the range of the lubricant of its film friction.

    The temperatures are those of parts in contact, if the design sets them, and that of the air, at which a drive
    starts. Nothing is yielded without film friction, or if the design's dimensions already include thermal expansion
    (``thermal.applied``), as in the design stored in a log.
    """
    if not design.has_film or design.thermal.applied:
        return
    oil, max_temperature = lubricant(design.friction.lubricant), design.service.grease_temperature
    parts = ("disc", "ring", "crank", "output") if design.thermal.words else ()
    temperatures = {part: getattr(design.thermal, part) for part in parts} | {"air": design.service.ambient_temperature}
    invalid_temperatures = {
        body: value for body, value in temperatures.items() if not oil.coldest <= value <= max_temperature
    }
    if not invalid_temperatures:
        return
    bodies = ", ".join(f"{body} {value:g} °C" for body, value in invalid_temperatures.items())
    effect, remedy = (
        (
            "does not flow",
            "choose another friction.lubricant, such as low-temperature grease 18 (to -50 °C), or higher temperatures",
        )
        if min(invalid_temperatures.values()) < oil.coldest
        else (
            "decomposes",
            "choose lower temperatures, or set service.grease_temperature_c to the limit of your lubricant",
        )
    )
    yield (
        f"temperatures outside the range of {oil.name}, {oil.coldest:g} to {max_temperature:g} °C: {bodies}. "
        f"The lubricant {effect} there, and its viscosity is extrapolated: friction and losses are not valid. "
        f"Remedy: {remedy} (--at-c, [thermal], service.ambient_temperature_c)"
    )


@cache
def lubricants() -> Mapping[str, Lubricant]:
    """Return all oils and greases of the package by name.

    The name of an oil is its base oil and ISO viscosity grade, such as ``PAO 150``.
    """
    table = _table()
    properties = {
        base_oil: {name: row[name] for name in ("density", "pressure_factor", "pressure_exponent", "gear_factor")}
        for base_oil, row in table["base_oil"].items()
    }
    oils = [
        Lubricant(
            f"{base_oil} {grade}",
            base_oil,
            float(grade),
            viscosity_at_100,
            source=row["source"],
            **properties[base_oil],
        )
        for base_oil, row in table["base_oil"].items()
        for grade, viscosity_at_100 in row["viscosity_100"].items()
    ]
    greases = [Lubricant(**row, **properties[row["base"]]) for row in table["grease"]]
    return {item.name: item for item in (*oils, *greases)}


@cache
def lubricant(name: str) -> Lubricant:
    """Return the lubricant with a name, ignoring case: viscosities, density and other properties.

    Raises
    ------
    DesignError
        No lubricant has this name.
    """
    names = {lubricant_name.casefold(): lubricant_name for lubricant_name in lubricants()}
    if name.casefold() not in names:
        similar_names = get_close_matches(name.casefold(), names, n=1)
        hint = f'did you mean "{names[similar_names[0]]}"? ' if similar_names else ""
        raise DesignError(
            f"friction.lubricant: unknown lubricant {name!r}; {hint}choose one of {', '.join(lubricants())}"
        )
    return lubricants()[names[name.casefold()]]


@cache
def plastic_pairs() -> Mapping[str, PlasticPair]:
    """Return the sliding pairs of plastics by name."""
    return {
        row["pair"]: PlasticPair(row["pair"], tuple(row["dry"]), tuple(row["greased"]), 1e6 * row["pv"], row["source"])
        for row in _table()["plastic"]
    }


def greased_friction(material: str) -> tuple[float, float]:
    """Return lowest and highest friction coefficient [1] of a greased plastic on steel, by the name of the plastic.

    A plastic that is not in the table counts as a filled thermoplastic.
    """
    rows = {name: row["pair"] for row in _table()["plastic"] for name in row.get("materials", [])}
    return plastic_pairs()[rows.get(material, "filled thermoplastic on steel")].greased


@cache
def _table() -> dict[str, Any]:
    return tomllib.loads(TABLE.read_text(encoding="utf-8"))
