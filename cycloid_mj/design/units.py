"""Units of the design file: the suffix a key carries there, and the factor to SI."""

import math
from dataclasses import dataclass
from itertools import chain
from typing import Any, get_args

from pydantic import BaseModel, Field
from pydantic.fields import FieldInfo

PAPER = "Hsieh 2014"
ASSUMED = "assumed"
ALLOY_STEEL = "SolidWorks Alloy Steel"
"""The entry of SolidWorks' material library whose values the paper's Table 1 prints."""
CATALOGUE = "SKF, JTEKT catalogues"
"""Makers' catalogues of rolling bearings; see `Friction`."""


@dataclass(frozen=True)
class Unit:
    """A unit of the design file.

    One file unit is ``multiplier / divisor`` SI units. Division by a power of ten is exactly rounded where
    multiplication by its inverse is not, so 40.75 mm becomes the float nearest to 0.04075 m.
    """

    suffix: str
    divisor: float = 1.0
    multiplier: float = 1.0

    def to_si(self, value: float) -> float:
        """Convert a value of the file to SI."""
        return value * self.multiplier / self.divisor

    def from_si(self, value: float) -> float:
        """Convert an SI value to the shortest number in the file's unit that `to_si` converts back exactly.

        Such a number exists for every value that was read from a file. For other values the nearest number is returned,
        whose SI value may differ in the last bit.
        """
        value_in_unit = value * self.divisor / self.multiplier
        rounded_values = (float(f"{value_in_unit:.{digits}g}") for digits in (14, 15, 16))
        neighbours = (value_in_unit + ulps * math.ulp(value_in_unit) for ulps in (0, -1, 1, -2, 2, -3, 3))
        return next(
            (candidate for candidate in chain(rounded_values, neighbours) if self.to_si(candidate) == value),
            value_in_unit,
        )


NONE = Unit("")
MILLIMETRE = Unit("mm", divisor=1e3)
MICROMETRE = Unit("um", divisor=1e6)
RPM = Unit("rpm", divisor=60.0, multiplier=2.0 * math.pi)
DEGREE = Unit("deg", divisor=180.0, multiplier=math.pi)
ARCMINUTE = Unit("arcmin", divisor=10800.0, multiplier=math.pi)
ARCSECOND = Unit("arcsec", divisor=648000.0, multiplier=math.pi)
SECOND = Unit("s")
HOUR = Unit("h")
MICROSECOND = Unit("us", divisor=1e6)
NEWTON = Unit("n")
NEWTON_METRE = Unit("nm")
NEWTON_PER_METRE = Unit("n_m")
NEWTON_AT_MILLIMETRE = Unit("n_mm")
"""N/mm^e of a spring F = k d^e: the force at a depth of 1 mm, which the value is in SI as well."""
DAMPING = Unit("n_s_mm", multiplier=1e3)
TORSION = Unit("nm_arcmin", multiplier=10800.0 / math.pi)
MEGAPASCAL = Unit("mpa", multiplier=1e6)
DENSITY = Unit("kg_m3")
EXPANSION = Unit("um_m_k", divisor=1e6)
INERTIA = Unit("kg_m2")
ACCELERATION = Unit("m_s2")
MILLIMETRE_PER_SECOND = Unit("mm_s", divisor=1e3)
KILOWATT = Unit("kw", multiplier=1e3)
CELSIUS = Unit("c")
FILM = Unit("w_m2_k")
CONDUCTIVITY = Unit("w_m_k")
VISCOSITY = Unit("mm2_s", divisor=1e6)
WEAR = Unit("mm3_nm", divisor=1e9)
HERTZ = Unit("hz")

BOUNDS = {"gt": "greater than", "ge": "at least", "lt": "less than", "le": "at most"}
"""Name of a bound in pydantic and in `operator`, and in words."""


def quantity(default: Any, text: str, unit: Unit = NONE, source: str = ASSUMED, **bounds: Any) -> Any:
    """Declare a numeric value of the design model: return a pydantic field whose default and bounds are in SI units.

    Parameters
    ----------
    default
        Value of the preset ``pin``, in the file's unit.
    text
        Meaning of the value; printed as its comment in the design file.
    unit
        Unit of the file; the value of the field is in SI.
    source
        Source of the default: the paper, another source, or assumed.
    bounds
        ``gt``, ``ge``, ``lt``, ``le`` in the file's unit.
    """
    bounds_in_si: dict[str, Any] = {name: unit.to_si(bound) for name, bound in bounds.items()}
    value = unit.to_si(default) if isinstance(default, float) else default
    if isinstance(value, float):
        bounds_in_si["allow_inf_nan"] = False
    return Field(
        default=value, description=text, json_schema_extra={"unit": unit.suffix, "source": source}, **bounds_in_si
    )


def choice(default: str, text: str, source: str = ASSUMED, **shape: Any) -> Any:
    """Declare a text value of the design, with ``pattern`` and ``max_length`` for free text.

    A pattern that itself counts up to the length takes as long to compile as the rest of the design.
    """
    return Field(default=default, description=text, json_schema_extra={"unit": "", "source": source}, **shape)


def switch(default: bool, text: str, source: str = ASSUMED) -> Any:
    """Declare one value of the design that is true or false."""
    return Field(default=default, description=text, json_schema_extra={"unit": "", "source": source})


def list_quantity(text: str, unit: Unit, per: str, source: str = ASSUMED) -> Any:
    """Declare a list of the design, empty by default: one value for each of the parts that ``per`` counts.

    ``per`` is the ``table.name`` of an integer of the model, or of several that are multiplied, with a space between.
    """
    return Field(default=(), description=text, json_schema_extra={"unit": unit.suffix, "source": source, "per": per})


UNITS = {
    unit.suffix: unit
    for unit in (
        NONE,
        MILLIMETRE,
        MICROMETRE,
        RPM,
        DEGREE,
        ARCMINUTE,
        ARCSECOND,
        SECOND,
        HOUR,
        MICROSECOND,
        NEWTON,
        NEWTON_METRE,
        NEWTON_PER_METRE,
        NEWTON_AT_MILLIMETRE,
        DAMPING,
        TORSION,
        MEGAPASCAL,
        DENSITY,
        EXPANSION,
        INERTIA,
        ACCELERATION,
        MILLIMETRE_PER_SECOND,
        KILOWATT,
        CELSIUS,
        FILM,
        CONDUCTIVITY,
        VISCOSITY,
        WEAR,
        HERTZ,
    )
}


def unit_of(field: FieldInfo) -> Unit:
    """Return the file's unit of a declared value."""
    extra = field.json_schema_extra
    return UNITS[str(extra["unit"])] if isinstance(extra, dict) else NONE


def bounds_of(field: FieldInfo) -> dict[str, float]:
    """Return the bounds [SI] of a declared number by the names of `BOUNDS`."""
    return {name: getattr(item, name) for item in field.metadata for name in BOUNDS if hasattr(item, name)}


def source_of(field: FieldInfo) -> str:
    """Return where the default of a declared value comes from."""
    extra = field.json_schema_extra
    return str(extra["source"]) if isinstance(extra, dict) else ASSUMED


def counted_by(field: FieldInfo) -> tuple[tuple[str, str], ...]:
    """List table and name of the integers whose product is the length of a declared list; none if it is no list."""
    extra = field.json_schema_extra
    per = str(extra.get("per", "")) if isinstance(extra, dict) else ""
    return tuple((table, name) for table, _, name in (key.partition(".") for key in per.split()))


def section_of(field: FieldInfo) -> Any:
    """Return the class of the table that a declared value is; None for a value that is none."""
    kinds = (field.annotation, *get_args(field.annotation))
    return next((kind for kind in kinds if isinstance(kind, type) and issubclass(kind, BaseModel)), None)


def file_key(name: str, field: FieldInfo) -> str:
    """Return the key of a declared value in the file: its name and its unit."""
    suffix = unit_of(field).suffix
    return f"{name}_{suffix}" if suffix else name
