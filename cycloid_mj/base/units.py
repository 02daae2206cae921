"""Units that people read, as numbers: those of the design file are in ``design.units``."""

import math
import re

RPM = math.pi / 30.0
"""One turn a minute [rad/s]."""

DEGREE = math.pi / 180.0
ARCMINUTE = DEGREE / 60.0
ARCSECOND = ARCMINUTE / 60.0
"""[rad]."""

ARCSECONDS = 3600.0 * 180.0 / math.pi
"""Arc seconds in a radian."""

FREEZING_POINT = 273.15
"""0 °C [K]."""

HOUR = 3600.0
"""[s]."""

MILLIMETRES = 1e3
"""Millimetres in a metre."""

MICROMETRES = 1e6
"""Micrometres in a metre."""

KG_CM2 = 1e4
"""kg cm2 in a kg m2."""

MILLIMETRE, MEGAPASCAL = 1e-3, 1e6
"""[m], [Pa]."""


def in_mm(length: float) -> str:
    """Format a length [m] in mm with five digits, without its unit."""
    return f"{MILLIMETRES * length:.5g}"


def unit_suffix(unit: str) -> str:
    """Return a unit as the ending of a key or column name, such as ``nm_per_arcmin`` for "N m/arcmin"; empty for "1".

    The word "per" is used only in quotients with a torque. Other quotients are written without it, as in logs:
    ``mm_s``.
    """
    if unit in ("", "1"):
        return ""
    unit_words = unit.replace("N m/", "nm per ").replace("/(N m)", " per nm").replace("N m", "nm")
    unit_words = unit_words.replace("%", "percent").lower()
    return "_".join(re.findall(r"[a-z0-9]+", unit_words))


def with_unit(key: str, unit: str) -> str:
    """Return a key that ends in its unit, once."""
    suffix = unit_suffix(unit)
    return key if not suffix or key.endswith(f"_{suffix}") else f"{key}_{suffix}"
