"""The output disc with its pins, their rollers and positions."""

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts.accuracy import checked_chord_error
from cycloid_mj.parts.contour import CircleContour, circles_at
from cycloid_mj.parts.part import Part, Segment
from cycloid_mj.parts.prism import Solid
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP

RIM = 0.5
"""Width of the disc outside its pins relative to their radius (heuristic)."""


def output_centres(reducer: Reducer) -> Array:
    """Compute the centres of output pins and of disc holes (n, 2) [m]: the first on +y, then clockwise."""
    output = reducer.design.output
    return output.pin_circle_radius * unit(2 * np.pi * np.arange(output.pins) / output.pins)


def output_part(reducer: Reducer) -> Part:
    """Return the output disc behind the cycloid discs (+z) with its pins, as exact outlines about the output axis.

    If both ends of the pins are supported, there is a second disc before the cycloid discs, through which the crank
    with its cams fits. Pins under separate rollers (`roller_part`) have the radius of their cores.
    """
    design = reducer.design
    gear, output, half_width = design.gear, design.output, design.gear.stack_width / 2
    face_z = half_width + AXIAL_GAP
    has_second_disc = output.support == "both_ends"
    rim = CircleContour(output.pin_circle_radius + (1 + RIM) * output.pin_radius)
    disc = Segment("disc", rim, (), face_z, face_z + output.disc_thickness)
    pins_start = -face_z if has_second_disc else -half_width
    pins = [
        Segment("pins", pin, (), pins_start, face_z) for pin in circles_at(pin_radius(reducer), output_centres(reducer))
    ]
    opening = CircleContour(gear.bore_radius + gear.eccentricity)
    second_disc = (
        [Segment("second_disc", rim, (opening,), -face_z - output.disc_thickness, -face_z)] if has_second_disc else []
    )
    return Part(names.OUTPUT, (disc, *pins, *second_disc), design.material_of("output").density)


def output_solid(reducer: Reducer, chord_error: float | None = None) -> Solid:
    """Return `output_part` as prisms with a chord error [m]; by default that for mass properties."""
    return output_part(reducer).solid(checked_chord_error(reducer, chord_error))


def pin_radius(reducer: Reducer) -> float:
    """Return the radius of a drawn output pin [m]: that of its core under a separate roller."""
    design = reducer.design
    return design.output.core_radius if design.output.has_roller_parts else design.output.pin_radius


def roller_part(reducer: Reducer) -> Part:
    """Return the roller of an output pin in a disc, in its own frame: a tube of the material of the pins.

    It is as wide as the disc. Its bore has the radius of the core pin: needles between them count as solid material.
    """
    design = reducer.design
    output, half_width = design.output, design.gear.face_width / 2
    tube = Segment(
        "roller", CircleContour(output.pin_radius), (CircleContour(output.root_radius),), -half_width, half_width
    )
    return Part(names.ROLLER, (tube,), design.material_of("output").density)
