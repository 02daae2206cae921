"""The output disc with its pins, the rollers on them, and where they stand."""

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.geometry.profile import unit
from cycloid_mj.parts.accuracy import drawing_error
from cycloid_mj.parts.contour import CircleContour, circles_at
from cycloid_mj.parts.part import Part, Stretch
from cycloid_mj.parts.prism import Solid
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP

RIM = 0.5
"""Width of the disc outside its pins, as a share of their radius."""


def output_centres(reducer: Reducer) -> Array:
    """Compute the centres of the output pins, and of the gear's holes, (n, 2) [m]: the first on +y, then clockwise."""
    output = reducer.design.output
    return output.pin_circle_radius * unit(2 * np.pi * np.arange(output.pins) / output.pins)


def output_part(reducer: Reducer) -> Part:
    """Lay out the output disc behind the gear (+z) with its pins through all discs, in the frame of the output axis.

    Where both ends of the pins are held, a second disc lies before the gear; the crank with its cams fits through it.
    Pins under rollers that are parts of their own (`roller_part`) are as thick as their cores.
    """
    design = reducer.design
    gear, output, half = design.gear, design.output, design.gear.stack_width / 2
    face = half + AXIAL_GAP
    both_ends = output.support == "both_ends"
    rim = CircleContour(output.pin_circle_radius + (1 + RIM) * output.pin_radius)
    disc = Stretch("disc", rim, (), face, face + output.disc_thickness)
    start = -face if both_ends else -half
    pins = [Stretch("pins", pin, (), start, face) for pin in circles_at(pin_radius(reducer), output_centres(reducer))]
    eye = CircleContour(gear.bore_radius + gear.eccentricity)
    second = [Stretch("second_disc", rim, (eye,), -face - output.disc_thickness, -face)] if both_ends else []
    return Part(names.OUTPUT, (disc, *pins, *second), design.material_of("output").density)


def output_solid(reducer: Reducer, chord_error: float | None = None) -> Solid:
    """Draw `output_part` with a chord error [m], that for mass properties when left out."""
    return output_part(reducer).solid(drawing_error(reducer, chord_error))


def pin_radius(reducer: Reducer) -> float:
    """Compute the radius of an output pin as it is drawn [m]: of its core under a roller that is a part of its own."""
    design = reducer.design
    return design.output.core_radius if design.output.has_roller_parts else design.output.pin_radius


def roller_part(reducer: Reducer) -> Part:
    """Lay out the roller of one output pin in one disc, in its own frame: a tube of the pins' material.

    It is as wide as the disc, and its bore has the radius of the core: needles between the two weigh as if they filled
    their room.
    """
    design = reducer.design
    output, half = design.output, design.gear.face_width / 2
    tube = Stretch("roller", CircleContour(output.pin_radius), (CircleContour(output.root_radius),), -half, half)
    return Part(names.ROLLER, (tube,), design.material_of("output").density)
