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


def output_centres(design: Design) -> Array:
    """Give the centres of the output pins, and of the gear's holes, (n, 2) [m]: the first on +y, then clockwise."""
    output = design.output
    return output.pin_circle_radius * unit(2 * np.pi * np.arange(output.pins) / output.pins)


def output_solid(design: Design, chord_error: float | None = None) -> Solid:
    """Give the output disc behind the gear (+z) with its pins through the gear, in the frame of the output axis.

    Parameters
    ----------
    design
        The design.
    chord_error
        Largest distance of a chord from its circle [m]; right for mass properties when left out.
    """
    chord_error = drawing_error(design, chord_error)
    output, half = design.output, design.gear.face_width / 2
    face = half + AXIAL_GAP
    rim = circle(output.pin_circle_radius + (1 + RIM) * output.pin_radius, chord_error)
    pin = circle(output.pin_radius, chord_error)
    disc = Prism(rim, (), face, face + output.disc_thickness)
    pins = [Prism(pin + centre, (), -half, face) for centre in output_centres(design)]
    return Solid("output", (disc, *pins), design.material_of("output").density)
