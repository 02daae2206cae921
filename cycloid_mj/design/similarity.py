"""Geometrically similar designs: the same shape in another size, under the torque that causes the same stresses."""

from collections.abc import Mapping

from cycloid_mj.design.layouts import applies
from cycloid_mj.design.model import Design
from cycloid_mj.design.units import unit_of

EXPONENTS: Mapping[str, int] = {"mm": 1, "um": 1, "n_m": 1, "n": 2, "nm": 3, "nm_arcmin": 3, "kw": 3}
"""Suffix of a unit -> exponent of the ratio of lengths with which its quantities grow at equal stress and speed."""

TABLES = (
    *("ring", "gear", "planet", "cranks", "output", "shaft", "housing", "clearance", "modification"),
    *("stiffness", "springs", "working_force", "bearing", "drag", "drive", "load"),
)
"""Tables of the drive and its load; the others describe materials, surfaces, tolerances, surroundings and the run."""


def scale_design(design: Design, factor: float) -> Design:
    """Return a geometrically similar design, whose lengths are `factor` times those of a design.

    Dimensions and clearances grow with the factor, forces with its square, torques and power with its cube. Stresses,
    backlash and wind-up (as angles) therefore stay the same. Speed, counts, materials, friction, errors and tolerances
    do not change. The result is not validated: a value may exceed its bounds.
    """
    tables = {name: section for name in TABLES if (section := getattr(design, name)) is not None}
    scaled_values = {
        table: {
            name: getattr(section, name) * factor ** EXPONENTS[unit_of(field).suffix]
            for name, field in type(section).model_fields.items()
            if unit_of(field).suffix in EXPONENTS and applies(design.layout, table, name)
        }
        for table, section in tables.items()
    }
    return design.model_copy(
        update={table: section.model_copy(update=scaled_values[table]) for table, section in tables.items()}
    )
