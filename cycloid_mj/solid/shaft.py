"""The eccentric input shaft: input journal, balancing counterweight and cam."""

import math

import numpy as np

from cycloid_mj.design import Design
from cycloid_mj.solid.accuracy import drawing_error
from cycloid_mj.solid.fit import require_above, too_small
from cycloid_mj.solid.gear import gear_solid
from cycloid_mj.solid.inertia import mass_properties
from cycloid_mj.solid.output import AXIAL_GAP
from cycloid_mj.solid.polygon import arc, area_moments, circle
from cycloid_mj.solid.prism import Prism, Solid
from cycloid_mj.types import Array


def shaft_solid(design: Design, chord_error: float | None = None) -> Solid:
    """Give the input shaft with its counterweight and cam, frame of the reducer axis, crank at 0 (cam towards +y).

    Along z: journal, counterweight (with the shaft in its middle), journal across the gap, cam within the gear; and,
    where the shaft straddles the gear, a journal beyond it, for the bearing in the output's hub.

    Parameters
    ----------
    design
        The design.
    chord_error
        Largest distance of a chord from its arc [m]; right for mass properties when left out.

    Raises
    ------
    DesignError
        No counterweight of this radius balances the gear within the shaft's length.
    """
    return balanced_shaft(design, gear_solid(design, chord_error), chord_error)


def balanced_shaft(design: Design, gear: Solid, chord_error: float | None = None) -> Solid:
    """Give the input shaft that balances a given gear; see ``shaft_solid``."""
    chord_error = drawing_error(design, chord_error)
    shaft, half = design.shaft, design.gear.face_width / 2
    journal = circle(shaft.radius, chord_error)
    cam = Prism(circle(design.gear.bore_radius, chord_error, (0.0, design.gear.eccentricity)), (), -half, half)
    counterweight = _counterweight(design, chord_error)
    end = -half - AXIAL_GAP
    start = end - _balancing_thickness(design, gear, cam, counterweight)
    prisms = (
        Prism(journal, (), end - shaft.length, start),
        Prism(counterweight, (), start, end),
        Prism(journal, (), end, -half),
        cam,
        *_far_journal(design, journal, start - (end - shaft.length)),
    )
    return Solid("shaft", prisms, design.material_of("shaft").density)


def bearing_width(design: Design, journal: float) -> float:
    """Give the width [m] of each bearing on a journal [m] before the counterweight: as given, or its radius if it fits.

    Where that is longer than a third of the journal, it is the third.
    """
    return design.shaft.bearing_width or min(design.shaft.radius, journal / 3.0)


def _far_journal(design: Design, outline: Array, journal: float) -> list[Prism]:
    """Give the journal beyond the gear, as far as the bearing in the output's hub; none on an overhung shaft."""
    if design.shaft.mounting == "overhang":
        return []
    half = design.gear.face_width / 2
    return [Prism(outline, (), half, half + AXIAL_GAP + bearing_width(design, journal))]


def _counterweight(design: Design, chord_error: float) -> Array:
    """Give the outline of the lower half disc, joined to the whole shaft in its middle."""
    shaft = design.shaft
    require_above("shaft.counterweight_radius", shaft.counterweight_radius, shaft.radius, "it is within the shaft")
    lower = arc(shaft.counterweight_radius, math.pi, 2 * math.pi, chord_error)
    upper = arc(shaft.radius, 0.0, math.pi, chord_error)
    return np.concatenate([lower, upper])


def _balancing_thickness(design: Design, gear: Solid, cam: Prism, counterweight: Array) -> float:
    """Solve the balance of static moments [m4] about the axis for the counterweight's thickness t [m].

    t S_counterweight + w S_cam + V_gear c = 0, with S the integral of y over a cross-section.
    """
    unbalance = cam.height * area_moments(cam.outline).y + mass_properties(gear).volume * design.gear.eccentricity
    thickness = -unbalance / area_moments(counterweight).y
    shaft = design.shaft
    if thickness >= shaft.length:
        # a half disc has the static moment -2/3 R^3 per thickness, the shaft in it takes 2/3 r^3 away
        radius = (shaft.radius**3 + 1.5 * unbalance / shaft.length) ** (1 / 3)
        otherwise = "no counterweight within the shaft's length balances the gear"
        raise too_small("shaft.counterweight_radius", shaft.counterweight_radius, radius, otherwise)
    return thickness
