"""Mass, inertia and length that covers, bearings, screws and flanges add to a mechanism."""

from collections.abc import Mapping

from cycloid_mj.base import names
from cycloid_mj.parts import Part, mass_properties
from cycloid_mj.parts.cam_bearing import cam_bearing
from cycloid_mj.parts.export.casing import (
    FLANGE,
    MOTOR_COVER,
    OUTPUT_BEARING,
    OUTPUT_COVER,
    SHAFT_BEARING,
    Casing,
    casing,
    casing_or_none,
)
from cycloid_mj.parts.export.casing_parts import casing_parts, casing_places
from cycloid_mj.parts.export.printing import STEEL, PrintedPart, manufactured_parts, separate_parts
from cycloid_mj.parts.export.round_part import RoundPart, tube, with_holes
from cycloid_mj.reducer import Reducer, once

BEARING_FILL = 0.67
"""Mass of a rolling bearing relative to a solid ring: 608, 61804, 6204, HK1010 have 0.66 to 0.70 (SKF)."""

CHORD_ERROR = 1e-6
"""Largest distance of a chord from its curve [m]; volumes are accurate to 1e-4."""

TURNING = {names.OUTPUT: (names.OUTPUT, FLANGE), names.HOUSING: (names.HOUSING, MOTOR_COVER, OUTPUT_COVER)}
"""Parts that rotate with the loaded body, by body."""


def has_casing(reducer: Reducer) -> bool:
    """Return whether covers, bearings and screws fit a mechanism."""
    return casing_or_none(reducer)[0] is not None


def casing_mass(reducer: Reducer) -> float:
    """Compute the mass that the casing adds to the drawn parts [kg]: covers, hub, flange, screws, dowels, bearings.

    Holes in ring and shaft are subtracted; the bearing of a cam replaces the outer part of the drawn cam.

    Raises
    ------
    DesignError
        A part does not fit.
    """
    sizes = casing(reducer)
    added = sum(mass for mass, _ in _added(reducer).values())
    return added + _bought(reducer, sizes) - _hollow_cams(reducer)


def casing_inertia(reducer: Reducer) -> float:
    """Compute the inertia that the casing adds at the input [kg m2]: hub and flange, less the bore of the shaft.

    Raises
    ------
    DesignError
        A part does not fit.
    """
    added = _added(reducer)
    turning = TURNING[reducer.mechanism.turning]
    slow = sum(inertia for name, (_, inertia) in added.items() if name in turning)
    _, fast = added.get(names.SHAFT, (0.0, 0.0))
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


@once
def _added(reducer: Reducer) -> Mapping[str, tuple[float, float]]:
    """Compute mass [kg] and inertia about the axis [kg m2] that the casing adds to each manufactured part."""
    bare, cased = (manufactured_parts(reducer, CHORD_ERROR, sizes=sizes) for sizes in (None, casing(reducer)))
    of_casing = [name for name, part in casing_parts(reducer, casing(reducer)).items() if not part.bought]
    gains = {}
    for name in of_casing:
        if name in cased:
            (mass, inertia), (before, slower) = _heaviness(cased[name]), _heaviness(bare.get(name))
            gains[name] = mass - before, inertia - slower
    return gains


def _heaviness(part: PrintedPart | None) -> tuple[float, float]:
    if part is None:
        return 0.0, 0.0
    whole = mass_properties(part.solid)
    return whole.mass, float(whole.inertia[2, 2] + whole.mass * (whole.centroid[:2] ** 2).sum())


def _bought(reducer: Reducer, sizes: Casing) -> float:
    """Compute the mass of screws, dowels and the bearings of shaft and output [kg]."""
    drawn = {name: part for name, part in casing_parts(reducer, sizes).items() if part.bought}
    each = {name: _steel(part) for name, part in drawn.items()}
    for bearing in (SHAFT_BEARING, OUTPUT_BEARING):
        each[bearing] *= BEARING_FILL
    return sum(each.get(place.part, 0.0) for place in casing_places(reducer, sizes))


def _hollow_cams(reducer: Reducer) -> float:
    """Compute the mass that cams with bearings in stock save, compared with cams that fill the bores [kg]."""
    bought = cam_bearing(reducer)
    if not bought:
        return 0.0
    bearing, count = bought
    drawn, made = (separate_parts(reducer, cam) for cam in (0.0, 0.5 * bearing.bore))
    crank = drawn.keys() & {names.SHAFT, *names.all_numbered(names.CAM, reducer.design.gear.discs)}
    ring = _steel(tube(0.5 * bearing.bore, 0.5 * bearing.outside, bearing.width))
    saved = sum(_mass(drawn[name]) - _mass(made[name]) for name in crank)
    return saved - BEARING_FILL * count * reducer.design.gear.discs * ring


def _steel(part: RoundPart) -> float:
    return _mass(Part("bought", with_holes("bought", part), STEEL))


def _mass(part: Part) -> float:
    return mass_properties(part.solid(CHORD_ERROR)).mass
