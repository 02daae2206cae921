"""Compliance between contacts and foundation: twist of carrier, shaft and housing; output pins bend by `bending`.

Only where ``structure`` is ``springs``; in a rigid one all of it is 0. The shaft's bearings and the discs' own give are
left out; the shaft's bending is told, and counted nowhere.
"""

import math

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.design.model import Material
from cycloid_mj.parts.parts import crank_stretches
from cycloid_mj.parts.shaft import bearing_seats
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import round_beam, shear_modulus

HUB = 0.5
"""Assumed: radius at which the output disc hands on its torque, as a share of the circle of its pins."""

TWISTING = ("carrier", "shaft", "housing")
"""What twists, in series with all contacts: keys of the table ``springs``."""


def twisting_stiffness(reducer: Reducer) -> dict[str, float]:
    """Compute the torsional stiffness of each of `TWISTING` about its own axis [N m/rad]; inf in a rigid structure.

    What is not given follows from the shape: of the shaft G pi r^4/(2 L), of rings G 4 pi t/(1/r^2 - 1/R^2) from the
    inner radius r to the outer R at the thickness t (in-plane shear): the output disc from its hub to its pins, the
    housing from the ring's pins or lobes out to its bolts or its rim.
    """
    design = reducer.design
    if design.structure == "rigid":
        return dict.fromkeys(TWISTING, math.inf)
    output, shaft, housing = design.output, design.shaft, design.housing
    outside = design.bolt_circle_radius if housing.support == "bolts" else housing.outer_radius
    circle = output.pin_circle_radius
    shapes = {
        "carrier": _ring(design.material_of("output"), output.disc_thickness, HUB * circle, circle),
        "shaft": shear_modulus(design.material_of("shaft")) * math.pi * shaft.radius**4 / (2.0 * shaft.length),
        "housing": _ring(
            design.material_of("housing"), design.gear.stack_width, design.ring.pin_circle_radius, outside
        ),
    }
    return {part: getattr(design.springs, part) or shapes[part] for part in TWISTING}


def twisting_compliance(reducer: Reducer) -> dict[str, float]:
    """Compute by how much the output turns at a locked crank, by what twists, per torque on it [rad/(N m)].

    The crank's twist reaches the output divided by the ratio N - 1, as the torque on it is; the ring's, under the
    torque N/(N - 1), times N/(N - 1); where the ring is the output, `member.share` squared of all that. The forces of
    the contacts stay: all of them turn alike.
    """
    design = reducer.design
    stiffness, teeth, seen = twisting_stiffness(reducer), design.ring.teeth, reducer.share**2
    return {
        "carrier": seen / stiffness["carrier"],
        "shaft": seen / (stiffness["shaft"] * design.lobes**2),
        "housing": seen * (teeth / design.lobes) ** 2 / stiffness["housing"],
    }


def wind_up(reducer: Reducer) -> float:
    """Compute the sum of `twisting_compliance` [rad/(N m)]."""
    return sum(twisting_compliance(reducer).values())


def crank_flexibility(reducer: Reducer) -> Array:
    """Compute by how much the shaft bends at each cam per force on each [m/N], shape (D, D).

    An Euler beam of the shaft's radius on two bearings that do not give and let it tilt: the integral of M_d M_d'/(E I)
    along it, exact for moments that are linear from place to place. No figure counts it: `structure_text` states it.

    Raises
    ------
    DesignError
        The crank cannot be made.
    """
    design = reducer.design
    far, near = (0.5 * sum(seat) for seat in bearing_seats(reducer, crank_stretches(reducer)))
    planes, radius = np.array(design.gear.disc_planes), design.shaft.radius
    ends = np.unique([far, near, *planes])
    places = np.stack([ends[:-1], 0.5 * (ends[:-1] + ends[1:]), ends[1:]])
    on_near = -(planes - far) / (near - far)
    moments = sum(
        force[:, np.newaxis, np.newaxis] * np.maximum(places - np.reshape(at, (-1, 1, 1)), 0.0)
        for force, at in ((np.ones_like(planes), planes), (on_near, near), (-1.0 - on_near, far))
    )
    weights = np.array([1.0, 4.0, 1.0])[:, np.newaxis] / 6.0 * np.diff(ends)
    bending, _ = round_beam(design.material_of("shaft"), radius)
    return np.asarray(np.einsum("dps,eps,ps->de", moments, moments, weights) / bending)


def structure_text(reducer: Reducer) -> str:
    """Describe the assumed structure."""
    if reducer.design.structure == "rigid":
        return "shafts, discs, output and housing are rigid: only contacts give"
    given = [part for part in TWISTING if getattr(reducer.design.springs, part)]
    twisting = ", ".join(
        f"{part} {ARCMINUTE * one:.3g}{' (given)' if part in given else ''}"
        for part, one in twisting_stiffness(reducer).items()
    )
    support = {"cantilever": "at one end", "both_ends": "at both ends"}[reducer.design.output.support]
    return (
        f"output pins bend as beams held {support}, {twisting} N m/arcmin twist, each about its own axis, which adds "
        f"to the output's turn and not to the gear's; left out{', unless what is given holds it,' if given else ''} "
        "are the discs' own give, that of all bearings but the "
        f"cams', and the shaft's bending: {1e9 * crank_flexibility(reducer).max():.3g} um at a cam under 1 kN there, "
        "which a softer stiffness.cam_n_m can stand for"
    )


def _ring(material: Material, thickness: float, inner: float, outer: float) -> float:
    return 4.0 * math.pi * shear_modulus(material) * thickness / (inner**-2 - outer**-2)
