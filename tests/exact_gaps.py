"""Gaps of teeth and of output pins from their exact curves, by search."""

import numpy as np

from cycloid_mj.design import Design
from cycloid_mj.geometry import kinematics, profile
from cycloid_mj.geometry.deviations import deviations
from cycloid_mj.geometry.modification import profile_offset, tooth_profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate.gaps import GearPose, design_flanks, pin_gaps, rotate


def exact(design: Design, crank: float, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gaps of teeth (pins or arcs) and of output pins at departures z, by search and by two circles."""
    gear, made, output = tooth_profile(design), deviations(design), design.output
    centre = kinematics.gear_centre(gear, crank) + z[:2]
    turned = float(kinematics.gear_rotation(gear, crank))
    angle, out = turned + z[2] / output.pin_circle_radius, turned + z[3] / output.pin_circle_radius
    flanks = design_flanks(Reducer(design))
    pins = gear.pin_circle_radius * profile.unit(profile.pin_angles(gear)) + made.pin_displacement
    mesh = pin_gaps(gear, GearPose(centre, angle), pins, flanks)
    teeth = mesh.distance + profile_offset(design) - gear.pin_radius - made.pin_radius
    around = output.pin_circle_radius * profile.unit(2.0 * np.pi * np.arange(output.pins) / output.pins)
    between = rotate(around, out) - centre - rotate(around + made.hole_displacement[0], angle)
    room = output.hole_radius + design.clearance.output - output.pin_radius
    return teeth, room - np.linalg.norm(between, axis=1)
