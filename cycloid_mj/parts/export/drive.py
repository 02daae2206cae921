"""Mass, inertia and length that covers, bearings, screws and flanges add to a mechanism."""

from cycloid_mj.base import names
from cycloid_mj.parts import mass_properties
from cycloid_mj.parts.accuracy import EXPORT_CHORD_ERROR
from cycloid_mj.parts.export.assembly import assembly_parts, places
from cycloid_mj.parts.export.casing import FLANGE, MOTOR_COVER, OUTPUT_COVER, Casing, casing, casing_or_none
from cycloid_mj.parts.export.printing import PrintedPart, manufactured_parts
from cycloid_mj.reducer import Reducer, once

BEARING_FILL = 0.67
"""Mass of a rolling bearing relative to a solid ring: 608, 61804, 6204, HK1010 have 0.66 to 0.70 (SKF)."""

TURNING = {names.OUTPUT: (names.OUTPUT, FLANGE), names.HOUSING: (names.HOUSING, MOTOR_COVER, OUTPUT_COVER)}
"""Parts that rotate with the loaded body, by body."""


def has_casing(reducer: Reducer) -> bool:
    """Return whether covers, bearings and screws fit a mechanism."""
    return casing_or_none(reducer)[0] is not None


@once
def drive_mass(reducer: Reducer) -> float:
    """Compute the mass of a drive with its covers [kg].

    Raises
    ------
    DesignError
        A part does not fit.
    """
    with_one_ring = reducer.but(ring={"halves": 1, "preload": 0.0}) if reducer.design.ring.halves > 1 else reducer
    return assembly_mass(with_one_ring, casing(with_one_ring))


def assembly_mass(reducer: Reducer, sizes: Casing) -> float:
    """Compute the mass of all solids of an assembly [kg], bearings filled by `BEARING_FILL`."""
    parts = assembly_parts(reducer, sizes)
    mass = {name: filling(name) * mass_properties(part.solid(EXPORT_CHORD_ERROR)).mass for name, part in parts.items()}
    return sum(mass[place.part] for place in places(reducer, 0.0, sizes))


def filling(part: str) -> float:
    """Return the mass of a part relative to that of its solid: less than 1 for rolling bearings."""
    return BEARING_FILL if part.endswith("_bearing") else 1.0


def casing_inertia(reducer: Reducer) -> float:
    """Compute the inertia that the casing adds at the input [kg m2]: hub and flange, less the bore of the shaft.

    Raises
    ------
    DesignError
        A part does not fit.
    """
    bare, cased = (manufactured_parts(reducer, EXPORT_CHORD_ERROR, sizes=sizes) for sizes in (None, casing(reducer)))
    slow, fast = (
        sum(_inertia(cased.get(name)) - _inertia(bare.get(name)) for name in turning)
        for turning in (TURNING[reducer.mechanism.turning], (names.SHAFT,))
    )
    return fast + slow / reducer.design.reduction**2


def drive_length(reducer: Reducer) -> float:
    """Compute the length from motor flange to output flange [m].

    Raises
    ------
    DesignError
        A part does not fit.
    """
    low, high = casing(reducer).ends
    return high - low


def drive_diameter(reducer: Reducer) -> float:
    """Compute the diameter of the covers [m], larger than the ring if the screws are outside of it.

    Raises
    ------
    DesignError
        A part does not fit.
    """
    return 2.0 * casing(reducer).outer


def _inertia(part: PrintedPart | None) -> float:
    """Compute the moment of inertia of a part about the axis [kg m2]; 0 without it."""
    if part is None:
        return 0.0
    whole = mass_properties(part.solid)
    return float(whole.inertia[2, 2] + whole.mass * (whole.centroid[:2] ** 2).sum())
