"""Compliance between contacts and foundation: torsion of carrier, shaft and housing.

It applies if ``structure`` is ``springs``; in a rigid structure it is 0. The compliances of the shaft's bearings and of
the discs are not included; bending of the shaft is reported only.
"""

import math

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.design.model import Material
from cycloid_mj.parts.parts import crank_segments
from cycloid_mj.parts.shaft import bearing_seats
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import round_beam, shear_modulus

HUB = 0.5
"""Radius at which the output disc transmits its torque, relative to the pin circle (assumed)."""

TWISTING = ("carrier", "shaft", "housing")
"""Parts in torsion, in series with all contacts: keys of the table ``springs``."""


def twisting_stiffness(reducer: Reducer) -> dict[str, float]:
    """Compute the torsional stiffness of carrier, shaft and housing about their own axes [N m/rad]; inf if rigid.

    The keys are `TWISTING`. Values that the design does not set follow from the shape and the shear modulus G. A solid
    shaft of the radius r and the length L has G pi r^4/(2 L). A ring of inner radius r, outer radius R and thickness t
    has G 4 pi t/(1/r^2 - 1/R^2) (in-plane shear): the output disc between hub and pins, and the housing between its
    pins or lobes and its bolts or rim.
    """
    design = reducer.design
    if design.structure == "rigid":
        return dict.fromkeys(TWISTING, math.inf)
    output, shaft, housing = design.output, design.shaft, design.housing
    outer_radius = design.bolt_circle_radius if housing.support == "bolts" else housing.outer_radius
    pin_circle = output.pin_circle_radius
    torsion_constant = math.pi * shaft.radius**4 / (2.0 * shaft.length) * shaft.section_share
    stiffness_by_shape = {
        "carrier": _ring_stiffness(design.material_of("output"), output.disc_thickness, HUB * pin_circle, pin_circle),
        "shaft": shear_modulus(design.material_of("shaft")) * torsion_constant,
        "housing": _ring_stiffness(
            design.material_of("housing"), design.gear.stack_width, design.ring.pin_circle_radius, outer_radius
        ),
    }
    return {part: getattr(design.springs, part) or stiffness_by_shape[part] for part in TWISTING}


def twisting_compliance(reducer: Reducer) -> dict[str, float]:
    """Compute the rotation of the output due to the torsion of each part, per output torque [rad/(N m)].

    Keys are `TWISTING`; the crank is locked, and N is the number of ring teeth. The crank has the torque of the output
    divided by the ratio N - 1, and its torsion appears at the output divided by N - 1. The ring has N/(N - 1) times the
    torque of the output, and its torsion appears multiplied by N/(N - 1). If the ring is the output, each is multiplied
    by the square of `Member.share`. Contact forces do not change, as all contacts rotate together.
    """
    design = reducer.design
    stiffness, ring_teeth, share_squared = twisting_stiffness(reducer), design.ring.teeth, reducer.share**2
    return {
        "carrier": share_squared / stiffness["carrier"],
        "shaft": share_squared / (stiffness["shaft"] * design.lobes**2),
        "housing": share_squared * (ring_teeth / design.lobes) ** 2 / stiffness["housing"],
    }


def wind_up(reducer: Reducer) -> float:
    """Compute the rotation of the output by all torsion of the structure per output torque [rad/(N m)]."""
    return sum(twisting_compliance(reducer).values())


def crank_flexibility(reducer: Reducer) -> Array:
    """Compute the deflection of the shaft at each cam per force on each of D cams [m/N], shape (D, D).

    The shaft is an Euler-Bernoulli beam with its radius and bore on two rigid bearings that allow it to tilt. No
    quantity of the data sheet includes this deflection; only `structure_text` states it.

    Raises
    ------
    DesignError
        The crank cannot be manufactured.
    """
    design = reducer.design
    far_bearing, near_bearing = (0.5 * sum(seat_ends) for seat_ends in bearing_seats(reducer, crank_segments(reducer)))
    disc_planes, radius = np.array(design.gear.disc_planes), design.shaft.radius
    breakpoints = np.unique([far_bearing, near_bearing, *disc_planes])
    points = np.stack([breakpoints[:-1], 0.5 * (breakpoints[:-1] + breakpoints[1:]), breakpoints[1:]])
    near_reaction = -(disc_planes - far_bearing) / (near_bearing - far_bearing)
    moments = sum(
        force[:, np.newaxis, np.newaxis] * np.maximum(points - np.reshape(position, (-1, 1, 1)), 0.0)
        for force, position in (
            (np.ones_like(disc_planes), disc_planes),
            (near_reaction, near_bearing),
            (-1.0 - near_reaction, far_bearing),
        )
    )
    simpson_weights = np.array([1.0, 4.0, 1.0])[:, np.newaxis] / 6.0 * np.diff(breakpoints)
    bending, _ = round_beam(design.material_of("shaft"), radius)
    bending *= design.shaft.section_share
    return np.asarray(np.einsum("dps,eps,ps->de", moments, moments, simpson_weights) / bending)


def structure_text(reducer: Reducer) -> str:
    """Describe in a sentence which parts of the structure are elastic, with their torsional stiffness [N m/arcmin]."""
    if reducer.design.structure == "rigid":
        return "shafts, discs, output and housing are rigid; only contacts are elastic"
    stated_parts = [part for part in TWISTING if getattr(reducer.design.springs, part)]
    twisting = ", ".join(
        f"{part} {ARCMINUTE * stiffness:.3g}{' (from the design)' if part in stated_parts else ''}"
        for part, stiffness in twisting_stiffness(reducer).items()
    )
    support = {"cantilever": "at one end", "both_ends": "at both ends"}[reducer.design.output.support]
    return (
        f"output pins are beams supported {support}; torsional stiffness about the axis: {twisting} N m/arcmin, which "
        f"affects the output only; not included{', unless the design sets them,' if stated_parts else ''} are the "
        "compliances of discs and of all bearings but the "
        f"cams', and bending of the shaft ({1e9 * crank_flexibility(reducer).max():.3g} um at a cam under 1 kN; a "
        "lower stiffness.cam_n_m can represent it)"
    )


def _ring_stiffness(material: Material, thickness: float, inner_radius: float, outer_radius: float) -> float:
    return 4.0 * math.pi * shear_modulus(material) * thickness / (inner_radius**-2 - outer_radius**-2)
