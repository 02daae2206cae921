"""The cycloid gear as a solid: its profile, its bore and the holes of the output pins."""

import math

from cycloid_mj import profile
from cycloid_mj.design import Design
from cycloid_mj.profile import CycloidGear
from cycloid_mj.solid.accuracy import drawing_error
from cycloid_mj.solid.fit import require_above, require_below
from cycloid_mj.solid.output import output_centres
from cycloid_mj.solid.polygon import circle
from cycloid_mj.solid.prism import Prism, Solid

ROUNDING = 1e-9
"""Relative; a hole of exactly output pin + eccentricity passes."""


def gear_solid(design: Design, chord_error: float | None = None) -> Solid:
    """Give the cycloid gear in its own frame: valley 1 and hole 1 on +y, holes numbered clockwise.

    Parameters
    ----------
    design
        The design; each clearance is taken from the gear (profile and holes) or added to its bore.
    chord_error
        Largest distance of a chord from its curve [m]; right for mass properties when left out.

    Raises
    ------
    DesignError
        The profile is undercut, bore, holes and valleys meet, or the output pins cannot orbit in the holes.
    """
    _require_room(design)
    chord_error = drawing_error(design, chord_error)
    outline = profile.sample_by_sagitta(tooth_profile(design), chord_error, profile_offset(design)).points[::-1]
    bore = circle(design.gear.bore_radius + design.clearance.cam, chord_error)
    hole = circle(design.output.hole_radius + design.clearance.output, chord_error)
    holes = [hole + centre for centre in output_centres(design)]
    half = design.gear.face_width / 2
    return Solid("gear", (Prism(outline, (bore, *holes), -half, half),), design.material.density)


def tooth_profile(design: Design) -> CycloidGear:
    """Give the ideal mesh of a design, without clearance."""
    ring = design.ring
    return CycloidGear(ring.teeth, design.gear.eccentricity, ring.pin_circle_radius, ring.pin_radius)


def profile_offset(design: Design) -> float:
    """Give the distance of the gear's profile from its trochoid [m]: the pin radius and the normal clearance."""
    clearance = design.clearance.pin_gear if design.ring.kind == "pin" else design.clearance.tooth
    return design.ring.pin_radius + clearance


def _require_room(design: Design) -> None:
    """Raise DesignError unless bore, holes and valleys stay apart and the output pins have room to orbit."""
    gear, output, clearance = design.gear, design.output, design.clearance
    orbit = (output.pin_radius + gear.eccentricity) * (1 - ROUNDING)
    half_pitch = output.pin_circle_radius * math.sin(math.pi / output.pins)
    to_bore = output.pin_circle_radius - output.hole_radius - clearance.output
    valley = design.ring.pin_circle_radius - gear.eccentricity - profile_offset(design)
    to_valley = valley - output.hole_radius - clearance.output
    require_above("output.hole_radius", output.hole_radius, orbit, "the output pins cannot orbit in the holes")
    require_below("output.hole_radius", output.hole_radius, half_pitch - clearance.output, "neighbouring holes meet")
    require_below("gear.bore_radius", gear.bore_radius, to_bore - clearance.cam, "the bore meets the output holes")
    require_below("output.pin_circle_radius", output.pin_circle_radius, to_valley, "the holes meet the valleys")
