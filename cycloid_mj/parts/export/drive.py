"""Mass, inertia and length that covers, bearings, screws and flanges add to a mechanism."""

from cycloid_mj.base import names
from cycloid_mj.parts import mass_properties
from cycloid_mj.parts.accuracy import EXPORT_CHORD_ERROR
from cycloid_mj.parts.export.assembly import assembly_parts, place_parts
from cycloid_mj.parts.export.casing import Casing, casing, casing_or_none
from cycloid_mj.parts.export.printing import PrintedPart, manufactured_parts
from cycloid_mj.parts.export.rv_assembly import BEARING_FILL
from cycloid_mj.reducer import Reducer, RvReducer

SEAL_FILL = 0.5
"""Mass of a seal ring relative to a solid ring of steel: a steel ring in rubber, with a hollow lip (assumed)."""

TURNING = {
    names.OUTPUT: (names.OUTPUT, names.SECOND_OUTPUT, names.FLANGE),
    names.HOUSING: (names.HOUSING, names.STOP_RING, *names.COVERS),
}
"""Parts that rotate with the loaded body, by body."""


def has_casing(reducer: Reducer) -> bool:
    """Return whether covers, bearings and screws fit a mechanism; never that of an RV reducer."""
    return not isinstance(reducer, RvReducer) and casing_or_none(reducer)[0] is not None


def drive_mass(reducer: Reducer) -> float:
    """Compute the mass [kg] of a drive with its covers; a ring in two halves is replaced by an undivided ring.

    Drives with equal parts share the result, which is cached.

    Raises
    ------
    DesignError
        A part does not fit.
    """
    undivided_reducer = reducer.but(ring={"halves": 1, "preload": 0.0}) if reducer.design.ring.halves > 1 else reducer
    drive_casing = casing(undivided_reducer)
    key = (assembly_mass, drive_casing, undivided_reducer.design.contact.cam_rollers)
    return undivided_reducer.shape.kept(key, lambda: assembly_mass(undivided_reducer, drive_casing))


def assembly_mass(reducer: Reducer, casing: Casing) -> float:
    """Compute the mass of all solids of an assembly [kg], bearings filled by `BEARING_FILL`."""
    parts = assembly_parts(reducer, casing)
    mass_by_part = {name: filling(name) * part.mass(EXPORT_CHORD_ERROR) for name, part in parts.items()}
    return sum(mass_by_part[placement.part] for placement in place_parts(reducer, 0.0, casing))


def filling(part: str) -> float:
    """Return the mass of a part relative to that of its solid of steel: less than 1 for rolling bearings and seals."""
    return SEAL_FILL if part == names.SHAFT_SEAL else BEARING_FILL if part.endswith("_bearing") else 1.0


def casing_inertia(reducer: Reducer) -> float:
    """Compute how much rotating parts of the casing change the inertia of the mechanism [kg m2], reduced to the input.

    Hub and flange of the output add to it, and the bore of the crankshaft reduces it, so the result may be negative.

    Raises
    ------
    DesignError
        A part does not fit.
    """
    mechanism, drive = (
        manufactured_parts(reducer, EXPORT_CHORD_ERROR, casing=variant) for variant in (None, casing(reducer))
    )
    output_inertia, shaft_inertia = (
        sum(_inertia(drive.get(name)) - _inertia(mechanism.get(name)) for name in bodies)
        for bodies in (TURNING[reducer.mechanism.turning], (names.SHAFT,))
    )
    return shaft_inertia + output_inertia / reducer.design.reduction**2


def drive_length(reducer: Reducer) -> float:
    """Compute the length [m] of a drive from the flange of the motor to the output flange.

    Raises
    ------
    DesignError
        A part does not fit.
    """
    z_start, z_end = casing(reducer).ends
    return z_end - z_start


def drive_diameter(reducer: Reducer) -> float:
    """Compute the diameter [m] of the covers of a drive; they are larger than the ring if the screws are outside of it.

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
    properties = mass_properties(part.solid)
    return float(properties.inertia[2, 2] + properties.mass * (properties.centroid[:2] ** 2).sum())
