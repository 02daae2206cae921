"""A cycloid gear as a solid: its profile, its bore and the holes of the output pins."""

import math

import numpy as np

from cycloid_mj.geometry import profile
from cycloid_mj.geometry.modification import gear_profile, profile_offset, sample_turned, tooth_profile
from cycloid_mj.parts.accuracy import drawing_error
from cycloid_mj.parts.fit import require_above, require_below
from cycloid_mj.parts.output import output_centres
from cycloid_mj.parts.polygon import circle, signed_area, turned
from cycloid_mj.parts.prism import Prism, Solid
from cycloid_mj.reducer import Reducer

__all__ = ["gear_outline", "gear_profile", "gear_solid", "profile_offset", "section_area", "tooth_profile"]

from cycloid_mj.base.array import Array

ROUNDING = 1e-9
"""Relative; a hole of exactly output pin + eccentricity passes."""


def gear_solid(reducer: Reducer, chord_error: float | None = None, disc: int = 0) -> Solid:
    """Build a cycloid gear in its own frame: valley 1 and hole 1 on +y, holes numbered clockwise.

    The teeth of a disc that is ahead on the crank are turned back, clockwise, against its holes. Its profile is the
    modified one; its holes are where the design has them, without errors.

    Parameters
    ----------
    reducer
        The reducer; each clearance is taken from the gear (profile and holes) or added to its bore.
    chord_error
        Largest distance of a chord from its curve [m]; right for mass properties when left out.
    disc
        Index of the disc, 0 next to the motor.

    Raises
    ------
    DesignError
        The profile is undercut, bore, holes and valleys meet, or the output pins cannot orbit in the holes.
    """
    design = reducer.design
    _require_room(reducer)
    chord_error = drawing_error(reducer, chord_error)
    outline = turned(gear_outline(reducer, chord_error)[::-1], -reducer.phases[disc] / design.lobes)
    bore = circle(design.gear.bore_radius + design.clearance.cam, chord_error)
    hole = circle(design.output.hole_radius + design.clearance.output, chord_error)
    holes = [hole + centre for centre in output_centres(reducer)]
    half = design.gear.face_width / 2
    return Solid(
        reducer.gears[disc], (Prism(outline, (bore, *holes), -half, half),), design.material_of("gear").density
    )


def gear_outline(reducer: Reducer, chord_error: float) -> Array:
    """Compute the gear's outline with its clearance and modification, (n, 2) [m], clockwise from the valley on +y.

    Raises
    ------
    DesignError
        The profile is undercut, `chord_error` [m] is too small, or nothing is left of the lobes.
    """
    teeth, offset, rotation = reducer.gear_profile, reducer.profile_offset, reducer.design.modification.rotation
    if rotation:
        return sample_turned(teeth, chord_error, offset, rotation)
    return profile.outline(teeth, profile.sagitta_parameters(teeth, chord_error, offset), offset)


def section_area(reducer: Reducer, chord_error: float | None = None) -> float:
    """Compute the area of a disc's cross-section as `gear_solid` draws it [m2], without drawing it: by one lobe's edge.

    Errors as there.
    """
    design = reducer.design
    _require_room(reducer)
    chord_error = drawing_error(reducer, chord_error)
    inside = _area_inside(reducer, chord_error)
    bore = signed_area(circle(design.gear.bore_radius + design.clearance.cam, chord_error))
    hole = signed_area(circle(design.output.hole_radius + design.clearance.output, chord_error))
    return inside - bore - design.output.pins * hole


def _area_inside(reducer: Reducer, chord_error: float) -> float:
    """Compute the area inside of `gear_outline` [m2]: lobes are alike, but for those of a turned profile."""
    if reducer.design.modification.rotation:
        return -signed_area(gear_outline(reducer, chord_error))
    teeth, offset = reducer.gear_profile, reducer.profile_offset
    parameters = profile.sagitta_parameters(teeth, chord_error, offset)
    lobe = profile.outline(teeth, parameters[: len(parameters) // teeth.lobes + 1], offset)
    return -teeth.lobes * signed_area(np.concatenate([lobe, np.zeros((1, 2))]))


def _require_room(reducer: Reducer) -> None:
    """Raise DesignError unless bore, holes and valleys stay apart and the output pins have room to orbit."""
    design = reducer.design
    gear, output, clearance = design.gear, design.output, design.clearance
    orbit = (output.pin_radius + gear.eccentricity) * (1 - ROUNDING)
    half_pitch = output.pin_circle_radius * math.sin(math.pi / output.pins)
    to_bore = output.pin_circle_radius - output.hole_radius - clearance.output
    valley = reducer.gear_profile.pin_circle_radius - gear.eccentricity - reducer.profile_offset
    to_valley = valley - output.hole_radius - clearance.output
    require_above("output.hole_radius", output.hole_radius, orbit, "the output pins cannot orbit in the holes")
    require_below("output.hole_radius", output.hole_radius, half_pitch - clearance.output, "neighbouring holes meet")
    require_below("gear.bore_radius", gear.bore_radius, to_bore - clearance.cam, "the bore meets the output holes")
    require_below("output.pin_circle_radius", output.pin_circle_radius, to_valley, "the holes meet the valleys")
