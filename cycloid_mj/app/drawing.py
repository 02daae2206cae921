"""The cross-section of a reducer as outlines in millimetres, fast enough to be redrawn while a slider moves.

The page moves them: each disc orbits and rotates with the crank at the rates that come with the outlines.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from cycloid_mj.app.rv_section import rv_dimensions, rv_holes, rv_section
from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.names import HOUSING, gears
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.design.layouts import Layout
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.modification import profile_offset, tooth_profile
from cycloid_mj.parts import Prism, Solid, circle, output_centres, parts, rv_solids
from cycloid_mj.reducer import Reducer
from cycloid_mj.scene import ring_places

CHORDS_PER_RADIUS = 4000.0
"""Outer radius over the chord error of outlines: finer than a screen shows."""

POINTS_PER_LOBE = 40
"""Points of each lobe of a profile that cannot be manufactured."""

MARKED_PARTS: Mapping[str, str] = {
    "loops": "gear",
    "undercut": "gear",
    "undercut_margin": "gear",
    "short_width": "gear",
    "gear_tool": "gear",
    "tooth_yield": "pin",
    "tooth_shakedown": "pin",
    "tooth_hardness": "pin",
    "neighbouring_pins": "pin",
    "pin_held": "pin",
    "pin_in_socket": "pin",
    "socket": "pin",
    "sleeve": "pin",
    "housing": "ring",
    "housing_ligament": "ring",
    "bolts": "ring",
    "bore": "bore",
    "holes_to_bore": "bore",
    "bore_to_hole": "bore",
    "cam_yield": "bore",
    "holes_to_root": "hole",
    "hole_to_root": "hole",
    "hole_to_hole": "hole",
    "neighbouring_holes": "hole",
    "hole_size": "hole",
    "output_pins": "output",
    "output_core": "output",
    "output_fillet": "output",
    "output_yield": "output",
    "output_shakedown": "output",
    "output_hardness": "output",
    "crank_bores": "output",
    "windows_to_bores": "output",
    "windows_to_root": "output",
    "windows_to_hole": "output",
    "bearing_space": "output",
    "eccentric_in_bearing": "output",
    "planets_mesh": "shaft",
    "crank_circle": "shaft",
    "sun_teeth": "shaft",
    "planet_teeth": "shaft",
    "shaft": "shaft",
    "shaft_fillet": "shaft",
    "shaft_bore": "shaft",
    "balance": "shaft",
    "counterweight": "shaft",
    "counterweight_room": "shaft",
}
"""Check -> the part of the cross-section at which it is marked."""


class SectionOfLayout(NamedTuple):
    """Functions that return what the cross-section of a layout has in addition to ring, discs and pins.

    Attributes
    ----------
    parts
        Further values of `section`, from the reducer and the largest chord error [m].
    solids
        Solids of all parts by name, from the same.
    holes
        Radius [m] and centres [m], shape (n, 2), of the holes of a disc.
    dimensions
        Radii [m] of further circles with a dimension line, by name.
    """

    parts: Callable[[Any, float], dict[str, Any]]
    solids: Callable[[Any, float], Mapping[str, Solid]]
    holes: Callable[[Any], list[tuple[float, Array]]]
    dimensions: Callable[[Any], dict[str, float]]


def section(reducer: Reducer, magnification: float = 1.0) -> dict[str, Any]:
    """Return the cross-section of a reducer, which the page animates, as JSON values; y is upward.

    `magnification` is the requested factor of all clearances.

    Returns
    -------
    dict
        ``ring`` and ``discs``: SVG paths of the housing and of each disc [mm]; ``pins``, ``holes``: centres of ring
        pins and output holes [mm]; ``dimensions``: ``name`` and ``diameter`` [mm] of each circle with a dimension line.
        ``pin_radius``, ``hole_radius``,
        ``output_radius`` (output pins), ``bore_radius``, ``shaft_radius``, ``reach`` (outermost radius) and ``orbit``
        (eccentricity): lengths [mm]. An RV reducer has the values of `rv_section` instead of holes, bore and shaft.
        ``phases``: angles of the discs on the crank [rad]; ``gear_rate``: turns of a disc
        per crank turn. ``play``: factor of the clearances as drawn, 1 if the magnified parts cannot be drawn;
        ``whole``: false for a design that cannot be built, whose disc profile is drawn with its loops or undercuts.
    """
    drawn_reducer = reducer if magnification == 1.0 else _magnify_clearances(reducer, magnification)
    try:
        outlines, buildable = _outlines(drawn_reducer), True
    except CycloidError:
        outlines, buildable = _unbuildable_outlines(reducer), False
    design = reducer.design
    ring = design.ring
    return {
        "whole": buildable,
        "play": magnification if drawn_reducer is not reducer else 1.0,
        "reach": MILLIMETRES * max(design.housing.outer_radius, ring.pin_circle_radius + 2.0 * ring.pin_radius),
        "pins": _points(ring_places(reducer)) if ring.kind == "pin" else [],
        "pin_radius": MILLIMETRES * ring.pin_radius,
        "phases": [float(phase) for phase in reducer.phases],
        "orbit": MILLIMETRES * design.gear.eccentricity,
        "gear_rate": -1.0 / design.lobes,
        "dimensions": _dimensions(reducer),
        **SECTIONS[reducer.LAYOUT].parts(reducer, _chord_error(reducer)),
        **outlines,
    }


def _holes_and_shaft(reducer: Reducer, _chord_error: float) -> dict[str, Any]:
    """Return centres [mm] and radii [mm] of output holes and pins, bore and shaft of a drive with a central crank.

    The keys are those that `section` describes, such as ``hole_radius``. The chord error has no effect.
    """
    design = reducer.design
    return {
        "holes": _points(output_centres(reducer)),
        "hole_radius": MILLIMETRES * (design.output.hole_radius + design.clearance.output),
        "output_radius": MILLIMETRES * design.output.pin_radius,
        "bore_radius": MILLIMETRES * design.gear.bore_radius,
        "shaft_radius": MILLIMETRES * design.shaft.radius,
    }


def _central_holes(reducer: Reducer) -> list[tuple[float, Array]]:
    """Return radius [m] and centres [m], shape (n, 2), of the bore of a disc and of its holes for output pins."""
    design = reducer.design
    return [(design.gear.bore_radius, np.zeros((1, 2))), (design.output.hole_radius, output_centres(reducer))]


def _central_dimensions(reducer: Reducer) -> dict[str, float]:
    """Return the radii [m] of the circles of output pins and bore, by name."""
    design = reducer.design
    return {"output circle": design.output.pin_circle_radius, "bore": design.gear.bore_radius}


SECTIONS: Mapping[Layout, SectionOfLayout] = {
    "central": SectionOfLayout(_holes_and_shaft, parts, _central_holes, _central_dimensions),
    "rv": SectionOfLayout(rv_section, rv_solids, rv_holes, rv_dimensions),
}
"""Layout -> what its cross-section has in addition."""


def _chord_error(reducer: Reducer) -> float:
    """Return the largest distance of a drawn chord from its curve [m]."""
    return reducer.design.housing.outer_radius / CHORDS_PER_RADIUS


def _magnify_clearances(reducer: Reducer, factor: float) -> Reducer:
    """Return a reducer with every clearance magnified; unchanged where its parts cannot be drawn then."""
    clearance = {name: factor * value for name, value in reducer.design.clearance if isinstance(value, float)}
    try:
        return reducer.but(clearance=clearance)
    except CycloidError:
        return reducer


def _outlines(reducer: Reducer) -> dict[str, Any]:
    """Return the outlines of housing and discs as SVG paths."""
    design, chord_error = reducer.design, _chord_error(reducer)
    solids = SECTIONS[reducer.LAYOUT].solids(reducer, chord_error)
    discs = [_svg_path(solids[name].prisms[0]) for name in gears(design.gear.discs)]
    return {"ring": _svg_path(solids[HOUSING].prisms[0]), "discs": discs}


def _unbuildable_outlines(reducer: Reducer) -> dict[str, Any]:
    """Return SVG paths of a design that cannot be built: a plain ring, and discs with their uncorrected profile.

    They are the text ``ring``, and the list ``discs`` with one text per disc.
    """
    design = reducer.design
    chord_error = _chord_error(reducer)
    ring_outlines = [
        circle(radius, chord_error) for radius in (design.housing.outer_radius, design.ring.pin_circle_radius)
    ]
    circle_groups = SECTIONS[reducer.LAYOUT].holes(reducer)
    hole_outlines = [circle(radius, chord_error) + centre for radius, centres in circle_groups for centre in centres]
    try:
        gear = tooth_profile(design)
        parameters = np.linspace(0.0, 2.0 * np.pi, POINTS_PER_LOBE * gear.lobes, endpoint=False)
        tooth_outlines = [profile.outline(gear, parameters, profile_offset(design))]
    except CycloidError:
        tooth_outlines = []
    disc_paths = ["".join(map(_svg_loop, (*tooth_outlines, *hole_outlines)))] * design.gear.discs
    return {"ring": "".join(map(_svg_loop, ring_outlines)), "discs": disc_paths}


def _dimensions(reducer: Reducer) -> list[dict[str, Any]]:
    """List name and diameter [mm] of the circles of a reducer that get a dimension line in the page's cross-section."""
    design = reducer.design
    radii = {"outside": design.housing.outer_radius, "pin circle": design.ring.pin_circle_radius}
    radii |= SECTIONS[reducer.LAYOUT].dimensions(reducer)
    return [{"name": name, "diameter": 2.0 * MILLIMETRES * radius} for name, radius in radii.items()]


def _svg_path(prism: Prism) -> str:
    return "".join(_svg_loop(loop) for loop in (prism.outline, *prism.holes))


def _svg_loop(points: Array) -> str:
    return f"M{' '.join(f'{x:.5g},{y:.5g}' for x, y in (MILLIMETRES * points).tolist())}Z"


def _points(positions: Array) -> list[list[float]]:
    return [[x, y] for x, y in (MILLIMETRES * positions).round(5).tolist()]
