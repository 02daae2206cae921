"""Figures of the layers above `figures`: checks, life and stress; each function is imported when it is first used."""

from collections.abc import Callable, Iterable

from cycloid_mj.base.units import with_unit
from cycloid_mj.design.layouts import BOTH, CENTRAL, Layout
from cycloid_mj.figures.figure import Compute, Figure, Need
from cycloid_mj.reducer import Reducer, RvReducer

_RATED = "at the nominal torque and speed"

_FUNCTIONS = {
    "loaded_teeth_per_disc": "loaded_teeth",
    "output_tilting_capacity": "tilting_moment",
    "output_tilting_stiffness": "tilting_stiffness",
    "output_radial_load": "radial_load",
    "output_axial_load": "axial_load",
    "momentary_torque": "momentary",
    "torque_for_6000_h": "torque_for_life",
}
"""Key of a figure -> name of its function, if another."""

_ALIASES = {"input_inertia": ("inertia",)}
"""Key of a figure -> its aliases, if other than the key without its unit."""

PARTS = {
    "shaft": "the shaft",
    "gear": "the discs",
    "ring": "the ring",
    "output": "the output",
    "pin": "ring pin 1",
}
"""Parts whose stress is computed -> words."""


def _has_covers(reducer: Reducer) -> bool:
    """Return whether covers and output bearings fit the design."""
    from cycloid_mj.parts.export.drive import has_casing

    return has_casing(reducer)


def _has_output_bearings(reducer: Reducer) -> bool:
    """Return whether the design has output bearings that fit: with covers, or the main bearings of an RV reducer."""
    return reducer.main_bearing is not None if isinstance(reducer, RvReducer) else _has_covers(reducer)


def _has_cold_sizes(reducer: Reducer) -> bool:
    """Return whether the sizes are those at 20 °C, not of warm parts as in a log."""
    return not reducer.design.thermal.applied


def _make_catalogue_entries(
    need: Need,
    module: str,
    rows: Iterable[tuple[str, str, str, str]],
    exists: Callable[[Reducer], bool] = lambda _: True,
    layouts: tuple[Layout, ...] = CENTRAL,
) -> tuple[Figure, ...]:
    """Return the catalogue entries (`Figure`) of quantities that `cycloid_mj.<module>` computes, one per row.

    A row is the key without unit, the unit, the name and the definition. The function of the module that computes a
    quantity has the name of its key, or the name in `_FUNCTIONS`. `need` states what the quantities are computed from.
    `exists` returns whether a reducer of these `layouts` has the quantities.
    """
    return tuple(
        Figure(
            key=(key_with_unit := with_unit(key, unit)),
            name=name,
            unit=unit,
            definition=definition,
            need=need,
            function=f"cycloid_mj.{module}:{_FUNCTIONS.get(key, key)}",
            aliases=() if key == key_with_unit else _ALIASES.get(key, (key,)),
            exists=exists,
            layouts=layouts,
        )
        for key, unit, name, definition in rows
    )


def _part_function(kind: str, name: str) -> Compute:
    """Return a function that computes the quantity `name` of a kind of part of a reducer by finite elements.

    `kind` is the kind of part, a key of `PARTS` such as "gear"; `name` is a key of ``stress.figures.FIGURES_OF_PARTS``.
    Of several parts of a kind, such as two discs, the value is the largest, or that of the smallest safety factor.
    """

    def compute(reducer: Reducer) -> float:
        from cycloid_mj.stress.figures import part_figure

        return part_figure(reducer, kind, name)

    return compute


def _make_part_entries(key: str, unit: str, name: str, definition: str) -> tuple[Figure, ...]:
    """Return the catalogue entries (`Figure`) of a finite-element quantity, one for each kind of part.

    `key` and `unit` are those of the quantity. The key of an entry is that of the part, "_" and `key`; {} in `name` and
    `definition` is replaced by the words for the part.
    """
    return tuple(
        Figure(
            key=f"{kind}_{key}",
            name=name.format(words),
            unit=unit,
            definition=definition.format(words),
            need=Need.STRESS,
            function=_part_function(kind, key),
            layouts=BOTH if kind in ("gear", "ring", "pin") else CENTRAL,
        )
        for kind, words in PARTS.items()
    )


# fmt: off
UPPER_FIGURES = (
    *_make_catalogue_entries(Need.STATICS, "checks.rated_load", [
        ("pressure_angle", "deg", "pressure angle, averaged by force",
         "Pressure angle of the tooth forces, averaged by force under the nominal torque, with friction."),
        ("loaded_teeth_per_disc", "1", "loaded teeth of a disc at the nominal torque, mean number",
         "Contacts of one disc with the ring with at least 1 % of the largest force under the nominal torque, with "
         "friction: mean number."),
    ]),
    *_make_catalogue_entries(Need.GEOMETRY, "life.figures", [
        ("input_inertia", "kg cm2", "inertia at the input",
         "Inertia at the crank (RV reducer: at the sun): crank, discs on their orbit, and all other parts divided by "
         "the square of the ratio."),
        ("length", "mm", "length of the mechanism",
         "Distance along the axis from the input journal (RV reducer: from the planets) to the far side of the output "
         "disc."),
    ], layouts=BOTH),
    *_make_catalogue_entries(Need.GEOMETRY, "life.figures", [
        ("drive_mass", "kg", "mass of the drive",
         "Mass including covers, bearings, screws, dowels and output flange, without motor and grease."),
        ("drive_inertia", "kg cm2", "inertia of the drive at the input",
         "Inertia at the crank, including hub and flange of the output divided by the square of the ratio."),
        ("drive_length", "mm", "overall length",
         "Distance along the axis from the motor flange to the face of the output flange, with covers."),
        ("drive_diameter", "mm", "overall diameter",
         "Diameter of the covers: that of the ring, or more if their screws do not fit into its wall."),
    ], _has_covers),
    *_make_catalogue_entries(Need.GEOMETRY, "life.figures", [
        ("largest_speed", "rpm", "largest speed of the crank",
         "Speed of the crank that the bearings of cams and shaft allow with grease: 300 000 divided by their mean "
         "diameter in mm, half of it for rollers without a cage."),
    ]),
    *_make_catalogue_entries(Need.LIFE, "life.figures", [
        (f"{key}_speed", "rpm", f"largest speed of the crank, {words}",
         f"Speed of the crank at which the hottest part reaches its temperature limit, or the parts jam, under the "
         f"nominal torque, {words}, by `cycloid-mj thermal`; at most the largest speed that its bearings allow.")
        for key, words in (("continuous", "continuous"), ("intermittent", "for a quarter of the time"))
    ], _has_cold_sizes),
    *_make_catalogue_entries(Need.STATICS, "life.output_bearing", [
        ("output_tilting_capacity", "N m", "tilting moment on the output",
         "Moment perpendicular to the axis that the bearings of the output's hub carry in addition to the nominal "
         "torque, for the life of the design with its service factor (ISO 281) and at standstill (ISO 76)."),
        ("output_tilting_stiffness", "N m/arcmin", "tilting stiffness of the output",
         "Moment perpendicular to the axis divided by the tilt, at half the moment limit, without clearance; balls or "
         "rollers and seats in plastic covers are elastic, hub and metal covers rigid."),
        ("output_radial_load", "N", "radial load on the output",
         "Radial force at the face of the flange that the hub's bearings carry in addition to the nominal torque, "
         "computed like the tilting moment."),
        ("output_axial_load", "N", "axial load on the output",
         "Axial force on the flange without other loads: a quarter of the static rating of a deep groove bearing; for "
         "other bearings by ISO 281 and ISO 76."),
    ], _has_output_bearings, BOTH),
    *_make_catalogue_entries(Need.LIFE, "life.figures", [
        ("life", "h", "life",
         f"Time until the first part fails, without wear, by `cycloid-mj rate`, {_RATED}."),
        ("bearing_life", "h", "life of the bearings",
         f"Shortest life of the bearings by ISO 281, {_RATED}."),
        ("least_safety", "1", "smallest safety factor",
         f"Smallest safety factor of `cycloid-mj rate`, {_RATED}."),
    ], layouts=BOTH),
    *_make_catalogue_entries(Need.LIFE, "life.figures", [
        ("drive_efficiency", "%", "efficiency with all bearings",
         f"Output power divided by power of the crank, with the bearings of shaft and output, {_RATED}; with film "
         "friction at the steady temperatures."),
        ("temperature_rise", "K", "temperature rise",
         f"Temperature of the housing above ambient, {_RATED}; with film friction in the steady state."),
    ]),
    *_make_catalogue_entries(Need.LIFE, "life.figures", [
        ("momentary_torque", "N m", "momentary torque",
         "Torque on the output in an emergency stop at which the weakest contact, pin, bearing or joint has a safety "
         "factor of 1 (RV reducer: the weakest cycloid tooth or crank bearing)."),
        ("torque_for_6000_h", "N m", "torque for 6000 h",
         "Rated torque on the output for service.life_h (by default 6000 h) at the design's speed; at most the "
         "momentary torque (RV reducer: heat not considered)."),
    ], layouts=BOTH),
    *_make_part_entries(
        "stress_mpa", "MPa", "largest stress of {}",
        "Largest von Mises stress of {} away from contacts, or at a fillet by its notch factor, over a turn of the "
        "crank under the load (the nominal torque if there is no load), by `cycloid-mj stress --quick`.",
    ),
    *_make_part_entries(
        "contact_pressure_mpa", "MPa", "largest contact pressure on {}",
        "Largest Hertz pressure on {} over a turn of the crank under the load (the nominal torque if there is no "
        "load), by `cycloid-mj stress --quick`; none if every contact is conformal.",
    ),
    *_make_part_entries(
        "contact_safety", "1", "safety factor of the contact pressure on {}",
        "Shakedown limit 4 k of the surface divided by the largest Hertz pressure on {}, by `cycloid-mj stress "
        "--quick`: below 1, the surface yields at every pass (pitting life: `cycloid-mj rate`).",
    ),
)
# fmt: on
