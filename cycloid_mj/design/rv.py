"""Tables of the design file that only an RV reducer has: its planet stage, its cranks, and their errors."""

from typing import Any, Literal

from cycloid_mj.design import units as u
from cycloid_mj.design.section import Offsets, Section
from cycloid_mj.design.units import choice, list_quantity, quantity

YANG = "Yang et al. 2021"
"""Yang, Zhou, Chang, Chen, Mech. Mach. Theory 163 (2021), 104384: the RV-80E."""

OF_ECCENTRICS = "cranks.count gear.discs"
"""Keys whose product is the length of lists of eccentrics and crank bores: cranks of disc 1, then of disc 2."""


class Planet(Section):
    """The first stage of an RV reducer: a sun on the input shaft, and a spur planet on each crank."""

    sun_teeth: int = quantity(10, "number of teeth of the sun", source=YANG, ge=5, le=400)
    planet_teeth: int = quantity(38, "number of teeth of each planet", source=YANG, ge=5, le=400)
    module: float = quantity(1.75, "module of sun and planets", u.MILLIMETRE, YANG, ge=0.05, le=100.0)
    pressure_angle: float = quantity(20.0, "pressure angle at the pitch circle", u.DEGREE, YANG, ge=10.0, le=35.0)
    face_width: float = quantity(12.0, "face width of sun and planets", u.MILLIMETRE, ge=0.01, le=1000.0)
    backlash: float = quantity(
        0.0, "circumferential backlash between sun and planet at the pitch circle", u.MICROMETRE, ge=0.0, le=1000.0
    )
    transmission_error: float = quantity(
        0.0, "amplitude of the transmission error of a mesh at tooth frequency", u.MICROMETRE, ge=0.0, le=1000.0
    )
    sun_support: Literal["floating", "fixed"] = choice(
        "floating", "floating: the sun is centred by the planets, which it loads equally; fixed: by bearings"
    )
    friction: float = quantity(0.05, "friction coefficient of the planet mesh (lubricated steel)", ge=0.0, le=2.0)
    mesh_stiffness: float = quantity(
        0.0,
        "stiffness of a mesh along its line of action; 0: ISO 6336-1, method B",
        u.NEWTON_PER_METRE,
        ge=0.0,
        le=1e12,
    )


class Cranks(Section):
    """The cranks of an RV reducer, one on each planet, with their bearings, and the carrier of two flanges."""

    count: int = quantity(3, "number of cranks and planets", source=YANG, ge=2, le=3)
    radius: float = quantity(
        0.0, "radius of the circle of crank axes; 0: module (sun + planet teeth)/2", u.MILLIMETRE, ge=0.0, le=5000.0
    )
    eccentric_radius: float = quantity(
        12.0, "radius of an eccentric, the inner raceway of its needles", u.MILLIMETRE, ge=0.01, le=5000.0
    )
    needle_radius: float = quantity(2.5, "radius of the needles on an eccentric", u.MILLIMETRE, ge=0.01, le=1000.0)
    needles: int = quantity(14, "number of needles on an eccentric", ge=3, le=1000)
    needle_clearance: float = quantity(
        0.0, "radial clearance of an eccentric in its bore; negative: preloaded", u.MICROMETRE, ge=-100.0, le=1000.0
    )
    needle_stiffness: float = quantity(
        2e8, "radial stiffness of the needle bearing of an eccentric", u.NEWTON_PER_METRE, gt=0.0, le=1e12
    )
    taper_radius: float = quantity(
        19.0, "outer radius of the tapered bearings of a crank in the flanges", u.MILLIMETRE, ge=0.01, le=5000.0
    )
    taper_clearance: float = quantity(
        0.0, "radial clearance of the tapered bearings; negative: preloaded", u.MICROMETRE, ge=-100.0, le=1000.0
    )
    taper_stiffness: float = quantity(
        2e8,
        "radial stiffness of the tapered bearings under the force of one disc",
        u.NEWTON_PER_METRE,
        gt=0.0,
        le=1e12,
    )
    middle_hole_radius: float = quantity(
        18.0, "radius of the hole in the middle of each disc", u.MILLIMETRE, ge=0.0, le=5000.0
    )
    post_radius: float = quantity(
        13.0, "radius of the posts that join the flanges, one between two cranks", u.MILLIMETRE, ge=0.01, le=5000.0
    )
    post_circle_radius: float = quantity(
        0.0, "radius of the circle of posts; 0: that of the cranks", u.MILLIMETRE, ge=0.0, le=5000.0
    )
    window_radius: float = quantity(
        0.0,
        "radius of the windows of the discs for the posts; 0: post radius plus eccentricity plus 0.5 mm",
        u.MILLIMETRE,
        ge=0.0,
        le=5000.0,
    )
    flange_thickness: float = quantity(18.0, "thickness of each flange", u.MILLIMETRE, ge=0.01, le=5000.0)
    main_bearings: Literal["none", "angular_contact"] = choice(
        "none",
        "bearings of the carrier in the housing, one on each flange: none; angular_contact, a preloaded pair back to "
        "back",
    )


def _zone(what: str) -> Any:
    return choice("", what, source="")


class CrankTolerance(Section):
    """Tolerances of the samples of an RV reducer, in the words of the table [tolerance]; empty: no variation."""

    eccentricity: str = _zone('eccentricity of each eccentric: "normal 2", "uniform 5", "between -1 4" [um], or "IT6"')
    phase: str = _zone("displacement of each eccentric by its phase error")
    bore_position: str = _zone("position of each crank bore of the discs, along x and along y")
    carrier_position: str = _zone("position of each crank axis in the carrier, along x and along y")
    planet_runout: str = _zone("offset of the teeth of each planet from its crank's axis, along x and along y")
    axis_position: str = _zone("offset of the carrier's axis from that of the ring, along x and along y")
    output_runout: str = _zone("run-out of the output, as offset along x and along y")
    pin_position: str = _zone("position of each ring pin, along x and along y")


class CrankErrors(Section):
    """Manufacturing errors of the cranks of an RV reducer, their bores and planets; empty lists: none.

    The lists begin with crank 1 on +y and go clockwise. Directions hold at the crank angle 0.
    """

    eccentric_radial: Offsets = list_quantity(
        "eccentricity of each eccentric minus the nominal one, disc after disc", u.MICROMETRE, OF_ECCENTRICS
    )
    eccentric_tangential: Offsets = list_quantity(
        "displacement of each eccentric by its phase error, counter-clockwise, disc after disc",
        u.MICROMETRE,
        OF_ECCENTRICS,
    )
    bore_x: Offsets = list_quantity("position of each crank bore along x, disc after disc", u.MICROMETRE, OF_ECCENTRICS)
    bore_y: Offsets = list_quantity("position of each crank bore along y, disc after disc", u.MICROMETRE, OF_ECCENTRICS)
    carrier_x: Offsets = list_quantity(
        "position of each crank axis in the carrier along x", u.MICROMETRE, "cranks.count"
    )
    carrier_y: Offsets = list_quantity(
        "position of each crank axis in the carrier along y", u.MICROMETRE, "cranks.count"
    )
    planet_x: Offsets = list_quantity(
        "run-out of each planet: offset of its teeth from its crank's axis along x", u.MICROMETRE, "cranks.count"
    )
    planet_y: Offsets = list_quantity("the same along y", u.MICROMETRE, "cranks.count")
    axis_x: float = quantity(
        0.0,
        "offset of the carrier's axis from that of the ring, fixed in the housing, along x",
        u.MICROMETRE,
        ge=-1000.0,
        le=1000.0,
    )
    axis_y: float = quantity(0.0, "the same along y", u.MICROMETRE, ge=-1000.0, le=1000.0)
    output_x: float = quantity(
        0.0,
        "run-out of the output: offset of its hole or flange from its axis of rotation along x, which turns with it",
        u.MICROMETRE,
        ge=-1000.0,
        le=1000.0,
    )
    output_y: float = quantity(0.0, "the same along y", u.MICROMETRE, ge=-1000.0, le=1000.0)
    output_radius: float = quantity(
        0.0,
        "radius at which the rotation of the output is transmitted or measured; 0: that of the pin circle",
        u.MILLIMETRE,
        ge=0.0,
        le=5000.0,
    )
