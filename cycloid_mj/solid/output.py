"""The output disc with its pins, and where they stand."""

import numpy as np

from cycloid_mj.design import Design
from cycloid_mj.profile import unit
from cycloid_mj.solid.accuracy import drawing_error
from cycloid_mj.solid.polygon import circle
from cycloid_mj.solid.prism import Prism, Solid
from cycloid_mj.types import Array

AXIAL_GAP = 1e-3
"""Distance of the output disc and of the counterweight from the gear's faces [m]."""

RIM = 0.5
"""Width of the disc outside its pins, as a share of their radius."""


def near_face(design: Design) -> float:
    """Give where along z what lies on the input side of the discs ends, the second output disc counted in [m]."""
    output, near = design.output, -design.gear.stack_width / 2 - AXIAL_GAP
    return near - output.disc_thickness - AXIAL_GAP if output.support == "both_ends" else near


def output_centres(design: Design) -> Array:
    """Give the centres of the output pins, and of the gear's holes, (n, 2) [m]: the first on +y, then clockwise."""
    output = design.output
    return output.pin_circle_radius * unit(2 * np.pi * np.arange(output.pins) / output.pins)


def output_solid(design: Design, chord_error: float | None = None) -> Solid:
    """Give the output disc behind the gear (+z) with its pins through all discs, in the frame of the output axis.

    Where both ends of the pins are held, a second disc lies before the gear; the crank with its cams fits through it.

    Parameters
    ----------
    design
        The design.
    chord_error
        Largest distance of a chord from its circle [m]; right for mass properties when left out.
    """
    chord_error = drawing_error(design, chord_error)
    gear, output, half = design.gear, design.output, design.gear.stack_width / 2
    face = half + AXIAL_GAP
    held = output.support == "both_ends"
    rim = circle(output.pin_circle_radius + (1 + RIM) * output.pin_radius, chord_error)
    pin = circle(output.pin_radius, chord_error)
    disc = Prism(rim, (), face, face + output.disc_thickness)
    start = -face if held else -half
    pins = [Prism(pin + centre, (), start, face) for centre in output_centres(design)]
    eye = circle(gear.bore_radius + gear.eccentricity, chord_error)
    second = [Prism(rim, (eye,), -face - output.disc_thickness, -face)] if held else []
    return Solid("output", (disc, *pins, *second), design.material_of("output").density)
