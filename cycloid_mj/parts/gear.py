"""A cycloid disc: its profile, its bore and the holes of the output pins."""

import math
from dataclasses import dataclass

import numpy as np

from cycloid_mj.geometry import profile
from cycloid_mj.geometry.modification import (
    flank_ends,
    gear_profile,
    profile_offset,
    sample_rotated_flanks,
    tooth_profile,
)
from cycloid_mj.parts.accuracy import RELATIVE_ROUNDING, checked_chord_error
from cycloid_mj.parts.contour import CircleContour, TurnedContour, circles_at
from cycloid_mj.parts.curve import Curve, SmoothCurve, fit_splines, rotate_curve
from cycloid_mj.parts.fit import require_above, require_below
from cycloid_mj.parts.output import output_centres
from cycloid_mj.parts.part import Part, Segment
from cycloid_mj.parts.polygon import signed_area
from cycloid_mj.parts.prism import Solid
from cycloid_mj.reducer import Reducer, once

__all__ = ["gear_outline", "gear_part", "gear_profile", "gear_solid", "profile_offset", "section_area", "tooth_profile"]

from cycloid_mj.base.array import Array


def gear_part(reducer: Reducer, disc: int = 0) -> Part:
    """Return a cycloid disc as exact outlines in its own frame: valley 1 and hole 1 on +y, holes numbered clockwise.

    If the phase of the disc on the crank is p [rad] counter-clockwise, its teeth are rotated clockwise relative to its
    holes by p over the number of lobes. The profile has the modification of the design; the holes have no errors. The
    profile is smaller, holes and bore are larger by their clearances.

    Parameters
    ----------
    disc
        Index of the disc, 0 next to the motor.

    Raises
    ------
    DesignError
        The profile is undercut, bore, holes and valleys overlap, or the output pins cannot orbit in the holes.
    """
    design = reducer.design
    _require_separate_holes(reducer)
    profile.require_no_undercut(reducer.gear_profile, reducer.profile_offset)
    outline = TurnedContour(GearContour(reducer.shape), -reducer.phases[disc] / design.lobes)
    holes = circles_at(_hole_radius(reducer), output_centres(reducer))
    half_width = design.gear.face_width / 2
    segment = Segment("gear", outline, (CircleContour(_bore_radius(reducer)), *holes), -half_width, half_width)
    return Part(reducer.gears[disc], (segment,), design.material_of("gear").density)


def gear_solid(reducer: Reducer, chord_error: float | None = None, disc: int = 0) -> Solid:
    """Return `gear_part` as prisms with a chord error [m]; by default that for mass properties."""
    chord_error = checked_chord_error(reducer, chord_error)
    return gear_part(reducer, disc).solid(chord_error)


@dataclass(frozen=True)
class GearContour:
    """The outline of the disc with its clearance and modification, valley 1 on +y."""

    reducer: Reducer

    def polygon(self, chord_error: float) -> Array:
        """Return its polygon, lobe by lobe; see `gear_outline`."""
        return gear_outline(self.reducer, chord_error)[::-1]

    def curves(self, splines: int) -> tuple[Curve, ...]:
        """Return splines lobe by lobe, each from the middle of a valley to that of the next.

        Flanks rotated towards the middle of their lobe are separate splines.
        """
        return _teeth_curves(self.reducer, splines)


@once
def _teeth_curves(reducer: Reducer, splines: int) -> tuple[Curve, ...]:
    """Return the outline of a disc's teeth as consecutive splines, `splines` for each lobe (each flank if rotated)."""
    gear, offset, rotation = reducer.gear_profile, reducer.profile_offset, reducer.design.modification.rotation
    pitch = 2.0 * math.pi / gear.lobes
    reversed_flank = SmoothCurve(
        points=lambda x: profile.outline(gear, -x, offset),
        arc_length=lambda x: -profile.arc_length(gear, -x, offset),
        tangents=lambda x: profile.unit(profile.normal_angle(gear, -x) - math.pi / 2.0),
        curvature=lambda x: profile.curvature(gear, -x, offset),
    )
    intervals = [(0.0, pitch, 0.0)]
    if rotation:
        ends = flank_ends(gear, offset, rotation)
        rising_interval, falling_interval = (
            (-ends.valley, pitch / 2.0 - ends.tip),
            (pitch / 2.0 + ends.tip, pitch + ends.valley),
        )
        intervals = [(*rising_interval, -rotation), (*falling_interval, rotation)]
    lobe_curves = [
        rotate_curve(curve, rotation_angle)
        for first_parameter, last_parameter, rotation_angle in intervals
        for curve in fit_splines(reversed_flank, first_parameter, last_parameter, splines)
    ]
    return tuple(rotate_curve(curve, -i * pitch) for i in range(gear.lobes) for curve in lobe_curves)


def gear_outline(reducer: Reducer, chord_error: float) -> Array:
    """Compute the outline of a disc as a polygon of n points (n, 2) [m], clockwise from the valley on +y.

    It has the clearance and the modification of the design; its chords deviate by `chord_error` [m].

    Raises
    ------
    DesignError
        The profile is undercut, `chord_error` [m] is too small, or nothing is left of the lobes.
    """
    gear, offset, rotation = reducer.gear_profile, reducer.profile_offset, reducer.design.modification.rotation
    if rotation:
        return sample_rotated_flanks(gear, chord_error, offset, rotation)
    return profile.outline(gear, profile.sagitta_parameters(gear, chord_error, offset), offset)


def section_area(reducer: Reducer, chord_error: float | None = None) -> float:
    """Compute the cross-section area of `gear_solid` [m2] from the outline of one lobe."""
    _require_separate_holes(reducer)
    chord_error = checked_chord_error(reducer, chord_error)
    outline_area = _area_inside(reducer, chord_error)
    bore_polygon, hole_polygon = (
        CircleContour(radius(reducer)).polygon(chord_error) for radius in (_bore_radius, _hole_radius)
    )
    return outline_area - signed_area(bore_polygon) - reducer.design.output.pins * signed_area(hole_polygon)


def _bore_radius(reducer: Reducer) -> float:
    return reducer.design.gear.bore_radius + reducer.design.clearance.cam


def _hole_radius(reducer: Reducer) -> float:
    return reducer.design.output.hole_radius + reducer.design.clearance.output


def _area_inside(reducer: Reducer, chord_error: float) -> float:
    """Compute the area [m2] of the polygon that `gear_outline` returns for a `chord_error` [m].

    If all lobes are equal (no rotated flanks), it is computed from one lobe.
    """
    if reducer.design.modification.rotation:
        return -signed_area(gear_outline(reducer, chord_error))
    gear, offset = reducer.gear_profile, reducer.profile_offset
    parameters = profile.sagitta_parameters(gear, chord_error, offset)
    lobe_points = profile.outline(gear, parameters[: len(parameters) // gear.lobes + 1], offset)
    return -gear.lobes * signed_area(np.concatenate([lobe_points, np.zeros((1, 2))]))


def _require_separate_holes(reducer: Reducer) -> None:
    """Raise DesignError unless bore, holes and valleys are separate and the output pins can orbit in the holes."""
    design = reducer.design
    gear, output, clearance = design.gear, design.output, design.clearance
    min_hole_radius = (output.pin_radius + gear.eccentricity) * (1 - RELATIVE_ROUNDING)
    half_pitch = output.pin_circle_radius * math.sin(math.pi / output.pins)
    inner_reach_of_holes = output.pin_circle_radius - output.hole_radius - clearance.output
    valley_radius = reducer.gear_profile.pin_circle_radius - gear.eccentricity - reducer.profile_offset
    max_pin_circle_radius = valley_radius - output.hole_radius - clearance.output
    require_above(
        "output.hole_radius", output.hole_radius, min_hole_radius, "the output pins cannot orbit in the holes"
    )
    require_below("output.hole_radius", output.hole_radius, half_pitch - clearance.output, "neighbouring holes meet")
    require_below(
        "gear.bore_radius", gear.bore_radius, inner_reach_of_holes - clearance.cam, "the bore meets the output holes"
    )
    require_below(
        "output.pin_circle_radius", output.pin_circle_radius, max_pin_circle_radius, "the holes meet the valleys"
    )
