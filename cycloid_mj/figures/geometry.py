"""Figures of dimensions and materials: shape of the teeth, size, mass."""

from collections import Counter

from cycloid_mj.base import names
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.design.layouts import BOTH, Layout
from cycloid_mj.figures.figure import Compute, Figure, Need
from cycloid_mj.geometry import profile
from cycloid_mj.parts import attached_parts, mass_properties, parts
from cycloid_mj.reducer import Reducer, RvReducer, once

CHORD_ERROR = 1e-6
"""Largest distance of a chord from its curve [m]; the mass is accurate to about 1e-4."""


@once
def masses(reducer: Reducer) -> dict[str, float]:
    """Compute the masses of the parts [kg] by name, such as "gear"; "pin" is all ring pins (or sleeves) together.

    Spacers and rollers are counted likewise. Those of an RV reducer are `rv_masses`, with needles and the tapered
    bearings of the cranks.
    """
    if isinstance(reducer, RvReducer):
        from cycloid_mj.parts.export.rv_assembly import rv_masses

        return rv_masses(reducer)
    carried_parts = Counter(
        part for body in (names.SHAFT, names.OUTPUT) for part, _ in attached_parts(reducer, body).values()
    )
    counts = {names.PIN: reducer.design.ring.teeth, **carried_parts}
    return {
        name: mass_properties(solid).mass * counts.get(name, 1) for name, solid in parts(reducer, CHORD_ERROR).items()
    }


def mass(reducer: Reducer) -> float:
    """Compute the mass of all parts [kg]."""
    return sum(masses(reducer).values())


def specific_torque(reducer: Reducer) -> float:
    """Compute the nominal torque over the mass of all parts [N m/kg]."""
    return reducer.design.rated_torque / mass(reducer)


def least_convex_radius(reducer: Reducer) -> float:
    """Compute the smallest convex radius of the lobes [mm]."""
    return MILLIMETRES * (profile.undercut_radius(reducer.gear_profile) - reducer.profile_offset)


def short_width(reducer: Reducer) -> float:
    """Compute the short-width coefficient K1 = c N / E [1]: eccentricity c, N ring teeth, pin-circle radius E."""
    ring = reducer.design.ring
    return ring.teeth * reducer.design.gear.eccentricity / ring.pin_circle_radius


def _make_entry(
    key: str,
    name: str,
    unit: str,
    definition: str,
    function: Compute | str,
    *aliases: str,
    deprecated: tuple[str, ...] = (),
    layouts: tuple[Layout, ...] = BOTH,
) -> Figure:
    """Return the catalogue entry (`Figure`) of a quantity that depends on dimensions and materials only.

    `function` computes the quantity from a reducer, or is the name ``module:function`` of such a function. `aliases`
    and `deprecated` are further keys; `name`, `unit` and `definition` are texts for the user, `layouts` the types of
    reducer that have the quantity.
    """
    return Figure(
        key=key,
        name=name,
        unit=unit,
        definition=definition,
        need=Need.GEOMETRY,
        function=function,
        aliases=aliases,
        deprecated=deprecated,
        layouts=layouts,
    )


# fmt: off
OF_GEOMETRY = (
    _make_entry("ratio", "turns of the input per turn of the output", "1",
            "Turns of the input (crank or sun) per turn of the output, without sign.",
            lambda reducer: float(abs(reducer.design.ratio))),
    _make_entry("nominal_torque_nm", "nominal torque", "N m",
            "Torque of the motor times the ratio: the default load of a design.",
            lambda reducer: reducer.design.rated_torque, "nominal_torque", deprecated=("rated_torque_nm",)),
    _make_entry("outer_diameter_mm", "outer diameter", "mm",
            "Outer diameter of the housing.",
            lambda reducer: 2.0 * MILLIMETRES * reducer.design.housing.outer_radius, "outer_diameter"),
    _make_entry("mass_kg", "mass of all parts", "kg",
            "Mass of all parts as drawn, without covers and the rings of bearings; of an RV reducer with needles and "
            "tapered bearings, without main bearings.", mass, "mass"),
    _make_entry("specific_torque_nm_per_kg", "nominal torque over mass", "N m/kg",
            "Nominal torque divided by the mass of all parts as drawn.",
            specific_torque),
    _make_entry("least_convex_radius_mm", "smallest convex radius of the lobes", "mm",
            "Smallest radius of curvature of the convex profile of the disc, with clearance and modification.",
            least_convex_radius),
    _make_entry("short_width", "K1 = c N / E", "1",
            "Eccentricity times the number of ring teeth, divided by the pin-circle radius.",
            short_width),
)
# fmt: on
