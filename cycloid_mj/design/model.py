"""The frozen ``Design``: every input of the project, in SI units; the defaults are the paper's pin reducer."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from html import escape
from typing import TYPE_CHECKING, Any, Literal, Self

from pydantic import Field, ValidationError, field_validator, model_validator

from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.names import CRANK_BEARING, PLANET_MESH
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.design import units as u
from cycloid_mj.design.layouts import RV_TABLES, applies
from cycloid_mj.design.materials import BY_CASEFOLD, DEFAULT, MATERIALS, SOFTEST_METAL, material_name
from cycloid_mj.design.measured import Measured
from cycloid_mj.design.rv import CrankErrors, Cranks, CrankTolerance, Planet
from cycloid_mj.design.section import Offsets, Section
from cycloid_mj.design.units import (
    PAPER,
    choice,
    counted_by,
    file_key,
    list_quantity,
    quantity,
    section_of,
    switch,
    unit_of,
)
from cycloid_mj.design.validation_errors import as_design_error

if TYPE_CHECKING:
    from cycloid_mj.base.frame import Frame


@dataclass(frozen=True)
class DefaultShares:
    """Assumed proportions of dimensions that a design leaves open."""

    sleeve_room: float = 0.05  # gap between a sleeve and the housing behind it, as a share of the sleeve's radius
    core: float = 0.75  # radius of the core pin under an output roller, as a share of the roller's
    fillet: float = 0.1  # radius of a fillet, as a share of the radius of the thinner stretch
    bolt: float = 0.25  # radius that a bolt of the ring clamps, as a share of the wall behind the teeth


SHARES = DefaultShares()


CamJoint = Literal["key", "shrink", "spline", "clamp", "one_piece"]
"""Joint of cams and shaft."""

BEARING_CORNER = 0.3e-3
"""Smallest corner radius r_s min of the bearings in stock from 8 mm bore on [m] (ISO 15, ISO 582)."""

PARTS = ("gear", "housing", "pin", "output", "shaft")
"""Parts that may have their own material; sleeves count as pins, and rollers as the part they turn on."""

REFERENCE_TEMPERATURE = 20.0
"""Temperature at which the sizes of a design file hold [°C] (ISO 1)."""

PARTNERS = {
    "pin_gear": ("pin", "gear"),
    "pin_socket": ("pin", "housing"),
    "pin_sleeve": ("pin", "pin"),
    "tooth": ("housing", "gear"),
    "cam": ("shaft", "gear"),
    "output": ("output", "gear"),
}
"""Parts that meet in each kind of mating pair."""


class Ring(Section):
    """The ring around the discs: ring pins, or an internal gear."""

    kind: Literal["pin", "nonpin"] = choice("pin", "pin: ring pins; nonpin: internal gear", PAPER)
    teeth: int = quantity(
        36, "number of ring teeth N (a disc has N - 1 lobes, the ratio is N - 1)", source=PAPER, ge=4, le=400
    )
    pin_circle_radius: float = quantity(40.75, "pin-circle radius E", u.MILLIMETRE, PAPER, ge=0.001, le=5000.0)
    pin_radius: float = quantity(2.25, "pin radius rho", u.MILLIMETRE, PAPER, ge=0.001, le=1000.0)
    pins: Literal["free", "fixed", "sleeved", "massless", "massless_sleeved"] = choice(
        "free",
        "free: the pins lie loose in their sockets and can turn; fixed: pressed in; sleeved: pressed in, each with a "
        "sleeve that can turn; massless, massless_sleeved: as free and sleeved, but without inertia, only for mean "
        "values under load",
        PAPER,
    )
    socket: Literal["half_open", "closed"] = choice(
        "half_open",
        "socket of a free or massless pin. half_open: open towards the disc, which retains the pin; closed: a full "
        "circle, such as bores in two end plates (parts cannot be exported)",
    )
    sleeve_thickness: float = quantity(
        0.75, "wall thickness of a sleeve; pin_radius is its outer radius", u.MILLIMETRE, ge=0.001, le=1000.0
    )
    halves: int = quantity(
        1,
        "1: ring in one piece; 2: two halves next to each other, each around half of every disc, rotated relative to "
        "each other to remove the backlash",
        ge=1,
        le=2,
    )
    preload: float = quantity(0.0, "angle between the two halves of the ring", u.ARCMINUTE, ge=0.0, le=600.0)
    preload_torque: float = quantity(
        0.0,
        "instead of preload_arcmin: torque of the spring that turns the halves before they are fixed; "
        "commands compute the angle",
        u.NEWTON_METRE,
        ge=0.0,
        le=1e6,
    )

    @model_validator(mode="after")
    def _check_preload(self) -> Self:
        """Raise ValueError if an undivided ring has a preload, or a preload is set both as an angle and as a torque."""
        preload_values = {"preload_arcmin": self.preload, "preload_torque_nm": self.preload_torque}
        set_keys = [key for key, value in preload_values.items() if value]
        if set_keys and self.halves == 1:
            raise ValueError(f"{set_keys[0]} applies only to a ring in two halves: set halves = 2 as well")
        if len(set_keys) > 1:
            raise ValueError(f"{' and '.join(set_keys)} both set the angle between the halves: set one of them to 0")
        return self

    @property
    def ahead(self) -> tuple[float, ...]:
        """Return the counter-clockwise rotation [rad] of each half of the ring, which preloads the teeth.

        An undivided ring has one value, 0.

        Raises
        ------
        DesignError
            The preload is set as a torque; `statics.preloaded` converts it to an angle.
        """
        if self.preload_torque:
            raise DesignError(
                "ring.preload_torque_nm must be converted to an angle before this calculation: set or vary "
                "ring.preload_arcmin instead, or call cm.preloaded(design) in Python"
            )
        return (0.5 * self.preload, -0.5 * self.preload) if self.halves == 2 else (0.0,)

    @property
    def mate_count(self) -> int:
        """Number of pins or lobes that mesh with the discs: N, or 2 N for a ring in two halves (second half last)."""
        return self.teeth * self.halves

    @property
    def has_sockets(self) -> bool:
        """True if the pins float in sockets."""
        return self.kind == "pin" and self.pins in ("free", "massless")

    @property
    def has_sleeves(self) -> bool:
        """True if each pin is pressed in and carries a turning sleeve."""
        return self.kind == "pin" and self.pins in ("sleeved", "massless_sleeved")

    @property
    def has_moving_pins(self) -> bool:
        """True if the parts on which the discs roll move in their seats: free pins, or sleeves on pressed-in pins."""
        return self.has_sockets or self.has_sleeves

    @property
    def has_massless_pins(self) -> bool:
        """True if these parts have no inertia, and so are part of the contact between disc and housing."""
        return self.kind == "pin" and self.pins.startswith("massless")

    @property
    def has_pin_bodies(self) -> bool:
        """True if these parts are bodies of the simulation, with position and spin."""
        return self.has_moving_pins and not self.has_massless_pins

    @property
    def sleeve_bore_radius(self) -> float:
        """Bore radius of a sleeve [m]; the pin in it is smaller by the clearance."""
        return self.pin_radius - self.sleeve_thickness


class Gear(Section):
    """The cycloid discs."""

    eccentricity: float = quantity(1.0, "eccentricity c of the cam", u.MILLIMETRE, PAPER, ge=0.001, le=500.0)
    discs: int = quantity(
        1,
        "number of discs on the crank, each with its own cam, equally spaced; disc 1 is next to the motor",
        source=PAPER,
        ge=1,
        le=4,
    )
    disc_gap: float = quantity(2.0, "gap between neighbouring discs", u.MILLIMETRE, ge=0.001, le=1000.0)
    face_width: float = quantity(
        10.0, "face width of each disc; pins and ring span all of them", u.MILLIMETRE, ge=0.001, le=1000.0
    )
    bore_radius: float = quantity(
        15.0, "radius of the cam (the bore of the disc adds the clearance)", u.MILLIMETRE, ge=0.001, le=5000.0
    )
    bearing: Literal["rolling", "plain"] = choice(
        "rolling", "bearing of the cam in the bore: rolling (rollers share the load), or plain (sliding)"
    )

    @property
    def disc_spacing(self) -> float:
        """Distance between the mid-planes of neighbouring discs [m]."""
        return self.face_width + self.disc_gap

    @property
    def stack_width(self) -> float:
        """Width of all discs with the gaps between them [m], which is the length of pins and ring."""
        return self.face_width + (self.discs - 1) * self.disc_spacing

    @property
    def disc_planes(self) -> tuple[float, ...]:
        """Position of the mid-plane of each disc along z [m]; 0 is the middle of all, the output is at their +z end."""
        return tuple((disc - (self.discs - 1) / 2.0) * self.disc_spacing for disc in range(self.discs))


class Output(Section):
    """The output carrier with its pins, and the holes of the discs."""

    member: Literal["carrier", "ring"] = choice(
        "carrier",
        "output member: carrier, the plate with the output pins, while the ring is fixed (with a "
        "central crank ratio N - 1, opposite to the crank); ring, the ring with its housing, while the carrier is "
        "fixed (ratio N, with the crank)",
        PAPER,
    )
    pins: int = quantity(8, "number of output pins and holes", ge=2, le=100)
    pin_radius: float = quantity(4.0, "radius of an output pin", u.MILLIMETRE, ge=0.001, le=5000.0)
    pin_circle_radius: float = quantity(
        26.0, "radius of the circle of output pins and holes", u.MILLIMETRE, ge=0.001, le=5000.0
    )
    hole_radius: float = quantity(
        5.0, "radius of a hole without its clearance: output pin plus eccentricity", u.MILLIMETRE, ge=0.001, le=5000.0
    )
    rollers: bool = switch(True, "true: rollers on the output pins; false: the pins slide in their holes")
    roller_bearing: Literal["needles", "plain"] = choice(
        "needles", "bearing of a roller on its core pin: needles, or plain (a sliding sleeve)"
    )
    core_radius: float = quantity(
        0.0,
        "radius of the core pin under a roller; 0: three quarters of pin_radius (without rollers the pin is solid)",
        u.MILLIMETRE,
        ge=0.0,
        le=5000.0,
    )
    fillet_radius: float = quantity(
        0.0, "fillet at the root of a pin; 0: a tenth of the core's radius", u.MILLIMETRE, ge=0.0, le=1000.0
    )
    disc_thickness: float = quantity(8.0, "thickness of the output disc", u.MILLIMETRE, ge=0.001, le=5000.0)
    support: Literal["cantilever", "both_ends"] = choice(
        "cantilever",
        "support of the output pins: cantilever, by the output disc only; both_ends, also by a second "
        "disc beyond the cycloid discs",
    )
    main_bearings: Literal["deep_groove", "angular_contact", "tapered", "crossed_roller"] = choice(
        "deep_groove",
        "bearings of the output's hub: deep_groove, two, sealed; angular_contact, a preloaded pair back to back, "
        "for several times the tilting moment and stiffness; tapered, such a pair of tapered roller bearings, for the "
        "largest loads; crossed_roller, one, sealed, under a retainer",
    )
    main_bearing_seat: Literal["hub", "disc", "both_discs"] = choice(
        "hub",
        "seat of the bearings of the output: hub, behind the output disc; disc, around it, for a short (pancake) "
        "drive; both_discs, one around each of two output discs, on either side of the cycloid discs",
    )

    @property
    def turns_ring(self) -> bool:
        """True if the ring is the output and the carrier of the output pins is fixed."""
        return self.member == "ring"

    @property
    def has_disc_seat(self) -> bool:
        """True if the bearings of the output are around its discs, not around a hub behind them."""
        return self.main_bearing_seat != "hub"

    @property
    def has_needles(self) -> bool:
        """True if the pins carry rollers on needles, not plain sleeves that slide on their cores."""
        return self.rollers and self.roller_bearing == "needles"

    @property
    def has_roller_parts(self) -> bool:
        """True if the rollers are separate parts, because the radius of their core pins is set.

        Otherwise pin and roller are drawn and weighed as one cylinder of ``pin_radius``.
        """
        return self.rollers and self.core_radius > 0.0

    @property
    def root_radius(self) -> float:
        """Radius of a pin at its root in the carrier [m]: of the core under its roller, or of the solid pin."""
        if not self.rollers:
            return self.pin_radius
        return self.core_radius or SHARES.core * self.pin_radius

    @property
    def root_fillet(self) -> float:
        """Radius of the fillet at the root of a pin [m]."""
        return self.fillet_radius or SHARES.fillet * self.root_radius


class Shaft(Section):
    """The eccentric input shaft with its counterweight."""

    radius: float = quantity(8.0, "radius of the input shaft", u.MILLIMETRE, ge=0.001, le=5000.0)
    bore_radius: float = quantity(
        0.0,
        "radius of a bore through shaft, hub and output flange, for cables or a tool; 0: none",
        u.MILLIMETRE,
        ge=0.0,
        le=5000.0,
    )
    length: float = quantity(30.0, "length of the input shaft before the discs", u.MILLIMETRE, ge=0.001, le=5000.0)
    counterweight_radius: float = quantity(
        30.0, "outer radius of the half-disc counterweight", u.MILLIMETRE, ge=0.001, le=5000.0
    )
    mounting: Literal["overhang", "straddle"] = choice(
        "overhang",
        "overhang: both bearings before the counterweight; straddle: one of them in the hub of the output",
    )
    cam_joint: CamJoint = choice(
        "key",
        "joint of the cams of several discs to the shaft: key, or adhesive if none fits; shrink, heated cams; spline, "
        "by ISO 14; clamp, slotted cams with screws; one_piece, a ground crank for two discs",
    )
    bearing_width: float = quantity(
        0.0, "width of each bearing; 0: the shaft's radius, or less on a short journal", u.MILLIMETRE, ge=0.0, le=5000.0
    )
    bearing_offset: float = quantity(
        0.0, "gap between the counterweight and the bearing next to it", u.MILLIMETRE, ge=0.0, le=5000.0
    )
    bearing_spacing: float = quantity(
        0.0,
        "overhang: distance between the two bearing centres; 0: the outer bearing is at the end of the journal",
        u.MILLIMETRE,
        ge=0.0,
        le=5000.0,
    )
    retaining_rings: bool = switch(
        False,
        "retaining rings (DIN 471, 472) that locate the crank along its axis, next to ball bearings in the motor cover",
    )
    seal_ring: bool = switch(
        False, "seal ring of a crank in drawn-cup needle bearings, next to the bearing on the motor side"
    )
    fillet_radius: float = quantity(
        0.0,
        "fillet at the shoulders; 0: a tenth of the shaft's radius, at most 0.3 mm, which bearings clear",
        u.MILLIMETRE,
        ge=0.0,
        le=1000.0,
    )

    @property
    def shoulder_fillet(self) -> float:
        """Radius of the fillets at the shoulders [m]."""
        return self.fillet_radius or min(SHARES.fillet * self.radius, BEARING_CORNER)

    @property
    def section_share(self) -> float:
        """Second moment of area of the hollow journal relative to that of a solid one: 1 - (bore/diameter)^4."""
        return 1.0 - (self.bore_radius / self.radius) ** 4


class Housing(Section):
    """The housing, which supports the pins or forms the internal gear."""

    outer_radius: float = quantity(
        50.0, "outer radius of the pinwheel or internal gear", u.MILLIMETRE, ge=0.001, le=5000.0
    )
    support: Literal["bolts", "rim"] = choice(
        "bolts", "support of the ring: bolts, clamped around each bolt; rim, a rigid seat around the outside"
    )
    bolts: int = quantity(6, "number of bolts on the bolt circle, the first on +y, if support is bolts", ge=2, le=400)
    bolt_circle_radius: float = quantity(
        0.0, "radius of the bolt circle; 0: middle of the wall behind the teeth", u.MILLIMETRE, ge=0.0, le=5000.0
    )
    bolt_radius: float = quantity(
        0.0,
        "radius of the area that a bolt clamps; 0: a quarter of the wall behind the teeth",
        u.MILLIMETRE,
        ge=0.0,
        le=1000.0,
    )


class Clearance(Section):
    """Normal clearance of each mating pair (the paper's tolerance of 0.001 mm)."""

    pin_gear: float = quantity(1.0, "between a centred pin and the disc", u.MICROMETRE, PAPER, gt=0.0, le=1000.0)
    pin_socket: float = quantity(1.0, "between a free pin and its socket", u.MICROMETRE, PAPER, gt=0.0, le=1000.0)
    pin_sleeve: float = quantity(1.0, "between a pressed-in pin and its sleeve", u.MICROMETRE, gt=0.0, le=1000.0)
    tooth: float = quantity(1.0, "between the disc and the internal gear", u.MICROMETRE, PAPER, gt=0.0, le=1000.0)
    cam: float = quantity(1.0, "between the cam and the bore of the disc", u.MICROMETRE, PAPER, gt=0.0, le=1000.0)
    output: float = quantity(1.0, "between an output pin and its hole", u.MICROMETRE, PAPER, gt=0.0, le=1000.0)


class Errors(Section):
    """Manufacturing errors, drawn at random with a seed; a list such as [5, 0, ...] or {1 = 5} replaces the draw."""

    seed: int = quantity(0, "seed of the random draws", ge=0, le=2**53)
    pin_position: float = quantity(
        0.0, "standard deviation of the position of a ring pin, along x and along y", u.MICROMETRE, ge=0.0, le=1000.0
    )
    pin_radius: float = quantity(
        0.0, "standard deviation of the radius of a ring pin (its socket is unchanged)", u.MICROMETRE, ge=0.0, le=1000.0
    )
    hole_position: float = quantity(
        0.0, "standard deviation of the position of a disc hole, along x and along y", u.MICROMETRE, ge=0.0, le=1000.0
    )
    disc_size: float = quantity(
        0.0,
        "standard deviation of the offset of a disc's flanks from the drawing, outwards positive",
        u.MICROMETRE,
        ge=0.0,
        le=1000.0,
    )
    cam_position: float = quantity(
        0.0,
        "standard deviation of the position of a cam on the crank, along x and along y",
        u.MICROMETRE,
        ge=0.0,
        le=1000.0,
    )
    eccentricity: float = quantity(
        0.0, "eccentricity of the cam minus that for which the teeth are cut", u.MICROMETRE, ge=-1000.0, le=1000.0
    )
    pin_x: Offsets = list_quantity(
        "position of each ring pin along x, pin 1 on +y, clockwise", u.MICROMETRE, "ring.teeth"
    )
    pin_y: Offsets = list_quantity("position of each ring pin along y", u.MICROMETRE, "ring.teeth")
    pin_dr: Offsets = list_quantity("radius of each ring pin", u.MICROMETRE, "ring.teeth")
    hole_x: Offsets = list_quantity(
        "position of each disc hole along x, hole 1 on +y, clockwise, disc after disc",
        u.MICROMETRE,
        "output.pins gear.discs",
    )
    hole_y: Offsets = list_quantity(
        "position of each disc hole along y, disc after disc", u.MICROMETRE, "output.pins gear.discs"
    )
    disc_dr: Offsets = list_quantity(
        "offset of each disc's flanks from the drawing, outwards positive", u.MICROMETRE, "gear.discs"
    )
    profile_cos: Offsets = list_quantity(
        "waves of the disc profile, orders 1, 2, ... per turn: offset of the flanks into the disc, "
        "coefficients of cos(k t) at the angle t clockwise from the valley on +y",
        u.MICROMETRE,
        "ring.teeth",
    )
    profile_sin: Offsets = list_quantity("the same, coefficients of sin(k t)", u.MICROMETRE, "ring.teeth")
    cam_x: Offsets = list_quantity("position of each cam along x, at the crank angle 0", u.MICROMETRE, "gear.discs")
    cam_y: Offsets = list_quantity("position of each cam along y, at the crank angle 0", u.MICROMETRE, "gear.discs")


def _zone(what: str) -> Any:
    return choice("", what, source="")


class Tolerance(Section):
    """Tolerances of the samples of `cycloid-mj tolerance`; empty: no variation.

    ``normal 2``, ``uniform 5`` and ``between -1 4`` are micrometres about the value of the design; ``IT6`` is a grade
    at the size of the part; a clearance can be a fit, ``H7/g6`` (ISO 286-1).
    """

    mesh: str = _zone('clearance between discs and ring: "normal 2", "uniform 5", "between -1 4" [um], or "H7/g6"')
    seat: str = _zone("clearance of pins or sleeves in their seats")
    cam: str = _zone("clearance of the cam")
    output: str = _zone("clearance of the output pins")
    pin_position: str = _zone("position of each ring pin (or lobe), along x and along y")
    pin_radius: str = _zone('radius of each ring pin, or a grade, "IT5"')
    pin_circle: str = _zone("radius of the pin circle")
    hole_position: str = _zone("position of each disc hole, along x and along y")
    eccentricity: str = _zone("eccentricity of the cam")
    disc_size: str = _zone("offset of each disc's flanks from the drawing")
    cam_position: str = _zone("position of each cam on the crank, along x and along y")
    profile: str = _zone(
        'amplitudes of waves of the disc profile by order, per turn of the disc, "2: normal 1, 35: '
        'uniform 2"; phases are random'
    )


class Modification(Section):
    """Intended deviation of the disc flanks from the profile that is conjugate to the ring."""

    equidistant: float = quantity(
        0.0, "offset of the flanks into the disc (more clearance)", u.MICROMETRE, ge=-1000.0, le=1000.0
    )
    pin_circle: float = quantity(
        0.0, "the disc is generated with a pin circle of E plus this value", u.MICROMETRE, ge=-1000.0, le=1000.0
    )
    rotation: float = quantity(
        0.0, "rotation of each flank towards the middle of its lobe", u.ARCSECOND, ge=0.0, le=3600.0
    )


class Friction(Section):
    """Friction of the mating pairs: a Coulomb coefficient of each, or mixed friction of a lubricant.

    The coefficient acts at the surface where the two parts of the pair meet. Catalogues state the torque of a rolling
    bearing as 0.5 mu P d with its bore d, and mu = 0.0020 for caged needle rollers (SKF, Rolling bearings, "Constant
    coefficient of friction"; JTEKT, Bearing knowledge, table 8-1: 0.0020 to 0.0030; cylindrical rollers 0.0008 to
    0.0012). Here it acts at the radius of the cam and at the rim of the rollers of output pins, as if these were the
    bore, which is an upper bound. If ``output.core_radius`` is set, the coefficient of the rollers acts there, and at
    their rim in proportion. A plain roller
    (``output.roller_bearing``) slides on its core, with the coefficient of a sliding pin there.
    """

    law: Literal["coulomb", "film"] = choice(
        "coulomb",
        "coulomb: the coefficients below; film: mixed friction of a lubricant, from film thickness and roughness",
    )
    lubricant: str = choice(
        "lithium grease 100",
        "film: lubricant, such as PAO 150 (base oil and ISO VG) or the name of a grease; see docs/lubrication.md",
        max_length=64,
    )
    roughness: float = quantity(
        0.4, "film: composite rms roughness Rq of both surfaces, ground", u.MICROMETRE, gt=0.0, le=100.0
    )
    boundary: float = quantity(
        0.11, "film: friction coefficient of boundary lubrication (0.08 to 0.14 for greased steel)", ge=0.0, le=2.0
    )
    film_formula: Literal["pan-hamrock", "dowson-higginson", "hamrock-dowson"] = choice(
        "pan-hamrock", "film: formula of the film thickness; they agree to about 20 %"
    )
    pin_gear: float = quantity(0.05, "pin on disc (lubricated steel)", ge=0.0, le=2.0)
    pin_socket: float = quantity(0.05, "pin in its socket", ge=0.0, le=2.0)
    pin_sleeve: float = quantity(0.05, "sleeve on its pin (lubricated steel, sliding)", ge=0.0, le=2.0)
    tooth: float = quantity(0.05, "disc on internal gear", ge=0.0, le=2.0)
    cam: float = quantity(0.05, "sliding cam in the bore, if gear.bearing is plain", ge=0.0, le=2.0)
    cam_rolling: float = quantity(
        0.002,
        "cam on rollers, at the radius of the cam, if gear.bearing is rolling",
        source=u.CATALOGUE,
        ge=0.0,
        le=2.0,
    )
    output: float = quantity(
        0.05,
        "output pin sliding in its hole (without output.rollers), or in its plain roller",
        ge=0.0,
        le=2.0,
    )
    output_rolling: float = quantity(
        0.002,
        "output pin with a roller on needles, at output.core_radius, or at the rim of the roller if that is 0",
        source=u.CATALOGUE,
        ge=0.0,
        le=2.0,
    )

    @property
    def words(self) -> str:
        """Name of the law as a condition of results, with the lubricant of film friction."""
        return f"film friction, {self.lubricant}" if self.law == "film" else "Coulomb friction"

    @field_validator("lubricant")
    @classmethod
    def _refuse_unknown_lubricant(cls, name: str) -> str:
        """Return the lubricant's name as in the table of lubricants; raise ValueError if it is not there."""
        from cycloid_mj.design.lubricants import lubricant

        try:
            return lubricant(name).name
        except DesignError as error:
            raise ValueError(str(error)) from None


NO_FRICTION: Mapping[str, str | float] = {"law": "coulomb"} | dict.fromkeys(
    ("pin_gear", "pin_socket", "pin_sleeve", "tooth", "cam", "cam_rolling", "output", "output_rolling"), 0.0
)
"""Values of the table `Friction` of a drive without friction."""


class Drag(Section):
    """Torque of seals and lubricant, independent of load and speed (Coulomb); 0: none."""

    crank: float = quantity(0.0, "drag torque on the crank", u.NEWTON_METRE, ge=0.0, le=1e5)
    output: float = quantity(0.0, "drag torque on the output", u.NEWTON_METRE, ge=0.0, le=1e6)


class ContactLaw(Section):
    """Stiffness and damping of the contacts.

    With ``law = "impact"`` every contact follows the function IMPACT of motion solvers such as ADAMS or SolidWorks
    Motion, F = k d^e + c step(d) v with the depth d and the closing speed v, instead of line contacts of steel; the
    defaults are those of such a program where no material is chosen ("Contact Parameters for Parts with Small Mass",
    Adams View help).
    """

    law: Literal["line", "impact"] = choice(
        "line", "line: line contacts with the stiffness and damping below; impact: F = k d^e + c step(d) v"
    )
    impact_stiffness: float = quantity(
        1e5, "impact: k, the force at a depth of 1 mm (N/mm^e)", u.NEWTON_AT_MILLIMETRE, gt=0.0, le=1e12
    )
    impact_exponent: float = quantity(2.2, "impact: e, exponent of the depth", ge=1.0, le=4.0)
    impact_damping: float = quantity(10.0, "impact: c, damping at the full depth", u.DAMPING, ge=0.0, le=1e6)
    impact_depth: float = quantity(
        0.1, "impact: depth from which damping is full; below, it follows a cubic step", u.MILLIMETRE, gt=0.0, le=100.0
    )
    stiffness_law: Literal["local", "uniform"] = choice(
        "local", "local: follows the relative curvature along the tooth; uniform: a pin on a flat everywhere"
    )
    stiffness: float = quantity(
        0.0, "stiffness of a pin on a flat; 0: from material and working force", u.NEWTON_PER_METRE, ge=0.0, le=1e12
    )
    working_force: float = quantity(
        0.0,
        "force at which every line contact has its secant stiffness; 0: that of each pair",
        u.NEWTON,
        ge=0.0,
        le=1e6,
    )
    working_load: float = quantity(
        0.0,
        "output torque whose ideal sharing gives the working force of each pair; 0: load.torque_nm",
        u.NEWTON_METRE,
        ge=0.0,
        le=1e6,
    )
    cam_rollers: int = quantity(
        20, "number of rollers of the cam bearing, which share its load (Stribeck)", ge=3, le=1000
    )
    needles: Literal["lumped", "each"] = choice(
        "lumped",
        "crank bearings and output rollers. lumped: all needles of a bearing are a single spring; each: a spring for "
        "each needle, in a cage that turns with the needles",
    )
    damping_ratio: float = quantity(
        0.5, "damping of a contact as a share of critical damping (0.5: restitution 0.3, lubricated)", gt=0.0, le=2.0
    )
    creep_speed: float = quantity(
        0.0,
        "sliding speed below which friction is viscous, under the working force; 0: 0.2 % of the disc centre's speed",
        u.MILLIMETRE_PER_SECOND,
        ge=0.0,
        le=1e4,
    )
    max_penetration: float = quantity(
        0.0,
        "penetration at which the run ends; 0: 50 um, or ten times that of the working forces if that is more",
        u.MICROMETRE,
        ge=0.0,
        le=1000.0,
    )


def _of_flat(pair: str) -> Any:
    return quantity(0.0, f"{pair}; 0: from material, curvature and working force", u.NEWTON_PER_METRE, ge=0.0, le=1e12)


class Stiffness(Section):
    """Stiffness of each mating pair; 0: from material, curvature and working force."""

    pin_gear: float = _of_flat("pin on disc, as on a flat (contact.stiffness_law applies)")
    pin_socket: float = _of_flat("pin in its socket")
    pin_sleeve: float = _of_flat("sleeve on its pin")
    tooth: float = _of_flat("disc on internal gear, as a pin on a flat (contact.stiffness_law applies)")
    cam: float = _of_flat("cam in the bore of the disc")
    output: float = _of_flat("output pin in its hole")


def _of_structure(part: str) -> Any:
    return quantity(0.0, f"{part}; 0: from its shape and material", u.TORSION, ge=0.0, le=1e9)


def _of_wind_up(what: str) -> Any:
    return quantity(0.0, f"{what}, for calibrate and reduce only", u.NEWTON_METRE, ge=0.0, le=1e6)


def _travel(what: str) -> Any:
    return quantity(0.1, what, u.DEGREE, gt=0.0, le=90.0)


class StructureSprings(Section):
    """Torsional stiffness of the structure between contacts and foundation, used if structure is springs, and friction.

    The bending of the output pins follows from their shape. Friction resists wind-up with the crank locked, as in
    loops.
    """

    carrier: float = _of_structure("torsional stiffness of the output disc, from its pins to the driven machine")
    shaft: float = _of_structure("torsional stiffness of the crank, from the motor to its cams")
    housing: float = _of_structure("torsional stiffness of the ring, from its pins or lobes to the foundation")
    friction: float = _of_wind_up("friction torque against rotation of the output with the crank locked")
    friction_travel: float = _travel("rotation of the output over which springs.friction develops")
    hysteresis: float = _of_wind_up("a second friction torque, such as that of seats that slip gradually")
    hysteresis_travel: float = _travel("rotation of the output over which springs.hysteresis develops")


def _ratio(pair: str) -> Any:
    return quantity(0.0, f"{pair}; 0: contact.damping_ratio", ge=0.0, le=2.0)


class Damping(Section):
    """Damping of each mating pair as a share of critical damping; 0: contact.damping_ratio."""

    pin_gear: float = _ratio("pin on disc")
    pin_socket: float = _ratio("pin in its socket")
    pin_sleeve: float = _ratio("sleeve on its pin")
    tooth: float = _ratio("disc on internal gear")
    cam: float = _ratio("cam in the bore of the disc")
    output: float = _ratio("output pin in its hole")


def _force(pair: str) -> Any:
    return quantity(0.0, f"{pair}; 0: contact.working_force_n, or by the load", u.NEWTON, ge=0.0, le=1e6)


class WorkingForce(Section):
    """Force at which each mating pair has its secant stiffness; 0: by contact.working_*."""

    pin_gear: float = _force("pin on disc")
    pin_socket: float = _force("pin in its socket")
    pin_sleeve: float = _force("sleeve on its pin")
    tooth: float = _force("disc on internal gear")
    cam: float = _force("total force of the cam")
    output: float = _force("output pin in its hole")


class Material(Section):
    """Material of the parts: a name of the library, and values that replace those of the library.

    The default is the steel of the paper's Table 1, which is the "Alloy Steel" of SolidWorks' material library. Yield
    strength 620.422 MPa and shear modulus 79 000 MPa are that entry's; Poisson's ratio and density, which the paper
    does not print, are taken from it too.
    """

    name: str = choice(DEFAULT, "name of the material library; empty: the values below are used", source="")
    youngs_modulus: float = quantity(210000.0, "Young's modulus", u.MEGAPASCAL, PAPER, ge=100.0, le=2e6)
    poisson: float = quantity(0.28, "Poisson's ratio", source=u.ALLOY_STEEL, ge=0.0, lt=0.5)
    density: float = quantity(7700.0, "density", u.DENSITY, u.ALLOY_STEEL, gt=100.0, le=25000.0)
    tensile_strength: float = quantity(723.1, "tensile strength", u.MEGAPASCAL, PAPER, gt=0.0, le=1e5)
    yield_strength: float = quantity(620.4, "yield strength", u.MEGAPASCAL, PAPER, gt=0.0, le=1e5)
    expansion: float = quantity(13.0, "linear thermal expansion", u.EXPANSION, u.ALLOY_STEEL, ge=0.0, le=500.0)
    surface_yield: float = quantity(
        0.0, "yield strength of a hardened surface; 0: that of the body", u.MEGAPASCAL, u.ALLOY_STEEL, ge=0.0, le=1e5
    )
    endurance_pressure: float = quantity(
        0.0,
        "Hertz pressure that a surface withstands 10^7 times without pitting; 0: of steel, from its tensile strength",
        u.MEGAPASCAL,
        u.ALLOY_STEEL,
        ge=0.0,
        le=1e5,
    )

    @property
    def surface_strength(self) -> float:
        """Yield strength of the surface [Pa], which can be hardened."""
        return self.surface_yield or self.yield_strength

    @property
    def surface_tensile_strength(self) -> float:
        """Tensile strength of the surface [Pa]; of a hardened surface approximately its yield strength."""
        return max(self.surface_yield, self.tensile_strength)

    @property
    def is_plastic(self) -> bool:
        """True for a plastic, by its Young's modulus (`SOFTEST_METAL`)."""
        return self.youngs_modulus < SOFTEST_METAL

    @model_validator(mode="before")
    @classmethod
    def _fill_from_library(cls, value: Any) -> Any:
        """Return a material table, `value`, with the values that it does not set taken from the library by its name.

        A table that sets numbers but no name has all other values from the default material. The table itself is
        unchanged; a `value` that is no table is returned as it is, for the validation to report.
        """
        if not isinstance(value, Mapping):
            return value
        numbers = [key for key in cls.model_fields if key != "name"]
        name = value.get("name", "" if any(key in value for key in numbers) else DEFAULT)
        name = material_name(name) if isinstance(name, str) else name
        library_entry = MATERIALS.get(name or DEFAULT) if isinstance(name, str) else None
        return {**{key: getattr(library_entry, key) for key in numbers if library_entry}, **value, "name": name}

    @field_validator("name")
    @classmethod
    def _refuse_unknown_material(cls, name: str) -> str:
        """Return the name of a material, which may be empty; raise ValueError if it is not in the library."""
        if name and name not in MATERIALS:
            similar_names = get_close_matches(name.casefold(), BY_CASEFOLD, n=1)
            suggestion = f'did you mean "{BY_CASEFOLD[similar_names[0]]}"? ' if similar_names else ""
            raise ValueError(
                f"unknown material; {suggestion}Available: {', '.join(MATERIALS)}. For any other, leave the name empty "
                "and set the numbers of this table"
            )
        return name

    @classmethod
    def merge_change(cls, values: Mapping[str, Any], change: Mapping[str, Any]) -> dict[str, Any]:
        """Return the values of a table with some of them changed; a new name replaces all values."""
        return dict(change) if "name" in change else super().merge_change(values, change)


def _part_material(part: str) -> Any:
    return Field(default=None, description=f"Material of {part}, if it differs from [material].")


class Bearing(Section):
    """Catalogue ratings of rolling bearings, and the required reliability, for `cycloid-mj rate` only."""

    dynamic_capacity: float = quantity(
        0.0,
        "dynamic load rating of the cam bearing; 0: ISO 281 with contact.cam_rollers rollers next to each other",
        u.NEWTON,
        ge=0.0,
        le=1e9,
    )
    static_capacity: float = quantity(
        0.0, "static load rating of the cam bearing; 0: ISO 76 with the same rollers", u.NEWTON, ge=0.0, le=1e9
    )
    shaft_dynamic_capacity: float = quantity(
        0.0,
        "dynamic load rating of each shaft bearing; 0: ISO 281 with rollers of a usual size",
        u.NEWTON,
        ge=0.0,
        le=1e9,
    )
    shaft_static_capacity: float = quantity(
        0.0, "static load rating of each shaft bearing; 0: ISO 76 with the same rollers", u.NEWTON, ge=0.0, le=1e9
    )
    output_dynamic_capacity: float = quantity(
        0.0,
        "dynamic load rating of the bearing in a roller of the output; 0: ISO 281 with as many needles as fit",
        u.NEWTON,
        ge=0.0,
        le=1e9,
    )
    output_static_capacity: float = quantity(
        0.0,
        "static load rating of the bearing in a roller of the output; 0: ISO 76 with the same needles",
        u.NEWTON,
        ge=0.0,
        le=1e9,
    )
    reliability: float = quantity(0.9, "share of bearings and parts that reach their life", ge=0.5, le=0.9999)
    service_factor: float = quantity(1.0, "factor on the loads of bearings, for shocks", ge=0.1, le=10.0)
    viscosity: float = quantity(
        0.0,
        "kinematic viscosity of the (base) oil at the temperature of the bearings, for a_ISO of ISO 281; 0: that of "
        "friction.lubricant with friction.law = film, else L10 only",
        u.VISCOSITY,
        ge=0.0,
        le=1e5,
    )
    cleanliness: float = quantity(
        0.5,
        "contamination factor e_C of ISO 281: 0.5 to 0.6 normal, 0.1 to 0.3 typical, 1 extremely clean",
        ge=0.0,
        le=1.0,
    )


MIN_FILM_COEFFICIENT = 1.0
"""Smallest heat transfer coefficient of a housing [W/(m2 K)]: 0.026 W/(m K) of still air over 26 mm, an insulation."""


class Service(Section):
    """Required life, and conditions of fatigue, wear and heat other than the loads."""

    life: float = quantity(6000.0, "required life at the rated torque (robot reducers: 6000)", u.HOUR, gt=0.0, le=1e9)
    duty_share: float = quantity(
        1.0, "share of the time under load, for the heat (1: continuous, less: intermittent duty S3)", gt=0.0, le=1.0
    )
    surface: Literal["ground", "machined", "forged"] = choice(
        "machined", "surface of shaft and pins: ground, machined or forged"
    )
    endurance_limit: float = quantity(
        0.0, "endurance limit of every part; 0: from tensile strength, surface and size", u.MEGAPASCAL, ge=0.0, le=1e5
    )
    notch_factor: float = quantity(
        0.0, "fatigue notch factor at the root of an output pin; 0: from its fillet", ge=0.0, le=10.0
    )
    wear_coefficient: float = quantity(
        1e-9,
        "worn volume of each surface per force and sliding distance; 1e-9: this value for metals, others for plastics",
        u.WEAR,
        ge=0.0,
        le=1.0,
    )
    run_in_depth: float = quantity(
        0.0,
        "depth that run-in removes from each sliding surface, for `cycloid-mj wear`; 0: by its material",
        u.MICROMETRE,
        ge=0.0,
        le=1000.0,
    )
    ambient_temperature: float = quantity(20.0, "temperature around the housing", u.CELSIUS, ge=-100.0, le=200.0)
    film_coefficient: float = quantity(
        12.0,
        "heat transfer coefficient to still air, at least 1; 0: convection and radiation by ISO/TR 14179-2",
        u.FILM,
        ge=0.0,
        le=1e4,
    )
    grease_temperature: float = quantity(
        100.0, "maximum temperature of the grease; 500: no limit", u.CELSIUS, ge=0.0, le=500.0
    )
    seal_temperature: float = quantity(
        100.0, "maximum temperature of the seals; 500: no limit", u.CELSIUS, ge=0.0, le=500.0
    )

    @field_validator("film_coefficient")
    @classmethod
    def _refuse_insulation(cls, coefficient: float) -> float:
        """Return a heat transfer coefficient [W/(m2 K)]; raise ValueError between 0 and that of insulation."""
        if 0.0 < coefficient < MIN_FILM_COEFFICIENT:
            raise ValueError(
                f"it must be 0 (convection and radiation by ISO/TR 14179-2) or from {MIN_FILM_COEFFICIENT:g} to 10000 "
                f"W/(m2 K): housings in still air have 8 to 15, and {MIN_FILM_COEFFICIENT:g} is that of a layer of 26 "
                "mm of insulation. Temperatures at smaller values have no meaning"
            )
        return coefficient


def _temperature(part: str) -> float:
    return quantity(REFERENCE_TEMPERATURE, f"temperature of {part}", u.CELSIUS, "ISO 1", ge=-100.0, le=300.0)


HEATED = ("disc", "ring", "crank", "output", "housing")
"""Parts with a temperature of their own."""


class Thermal(Section):
    """Temperatures of the parts; all dimensions of a design file are valid at 20 °C (ISO 1)."""

    disc: float = _temperature("the cycloid discs")
    ring: float = _temperature("the ring: its pin circle, or the internal gear, and its pins")
    crank: float = _temperature("the crank with its cams")
    output: float = _temperature("the output carrier with its pins")
    housing: float = _temperature("the covers, without effect on the clearances of the mechanism")
    grease_conductivity: float = quantity(
        0.13, "thermal conductivity of the grease", u.CONDUCTIVITY, "mineral oil greases", gt=0.0, le=10.0
    )
    face_gap: float = quantity(
        0.5, "grease between a face of the discs and the part next to it", u.MILLIMETRE, gt=0.0, le=100.0
    )
    joint_conductance: float = quantity(
        5000.0, "thermal conductance of clamped faces, such as ring on cover", u.FILM, gt=0.0, le=1e6
    )
    emissivity: float = quantity(
        0.9, "emissivity of the covers, if service.film_coefficient_w_m2_k is 0; 0.9: painted", gt=0.0, le=1.0
    )
    applied: bool = switch(
        False,
        "true: the clearances and errors of this file already include the thermal expansion, as in a log",
        "ISO 1",
    )

    @property
    def is_reference(self) -> bool:
        """True if no expansion is to be applied: all parts are at 20 °C, or the sizes are already warm."""
        return self.applied or not self.words

    @property
    def words(self) -> str:
        """Temperatures of the parts as a condition of results; empty at 20 °C."""
        values = {part: getattr(self, part) for part in ("disc", "ring", "crank", "output")}
        if len(set(values.values())) > 1:
            return ", ".join(f"{part} {value:g} °C" for part, value in values.items())
        return f"{self.disc:g} °C" if self.disc != REFERENCE_TEMPERATURE else ""


class Drive(Section):
    """The motor and its speed: a linear ramp, then constant speed."""

    power: float = quantity(0.18, "rated input power", u.KILOWATT, PAPER, gt=0.0, le=1e5)
    torque: float = quantity(1.048, "rated input torque", u.NEWTON_METRE, PAPER, gt=0.0, le=1e6)
    speed: float = quantity(1640.0, "crank speed after the ramp", u.RPM, PAPER, gt=-1e5, lt=1e5)
    ramp: float = quantity(1.0, "duration of the linear ramp from rest", u.SECOND, ge=0.0, le=1000.0)
    hold: float = quantity(0.25, "duration at constant speed after the ramp", u.SECOND, gt=0.0, le=1000.0)
    rotor_inertia: float = quantity(1e-4, "inertia of the motor's rotor on the crank", u.INERTIA, ge=0.0, le=100.0)


class Load(Section):
    """The load on the output."""

    torque: float = quantity(0.0, "constant torque against the rotation of the output", u.NEWTON_METRE, ge=-1e6, le=1e6)
    rise: float = quantity(0.005, "time over which the load is applied smoothly", u.SECOND, gt=0.0, le=1000.0)


class Environment(Section):
    """Gravity."""

    gravity_x: float = quantity(0.0, "gravity along x", u.ACCELERATION, PAPER, ge=-1000.0, le=1000.0)
    gravity_y: float = quantity(-9.8, "gravity along y", u.ACCELERATION, PAPER, ge=-1000.0, le=1000.0)


class Settings(Section):
    """Settings of simulation and log."""

    timestep: float = quantity(
        0.0, "time step; 0: the longest step at which the results are accurate", u.MICROSECOND, ge=0.0, le=1000.0
    )
    log_rate: float = quantity(10000.0, "samples of every signal per second", u.HERTZ, gt=0.0, le=1e6)
    scene_rate: float = quantity(
        60.0, "minimum number of 3-D frames per second; a run has one every 10 deg of crank", u.HERTZ, gt=0.0, le=1e5
    )


def _rv_table(what: str) -> Any:
    return Field(default=None, description=f"{what} (layout rv).")


def _value_rows(section: Section, prefix: str) -> Iterator[dict[str, str]]:
    """Yield ``key``, ``value``, ``unit`` and ``meaning`` of each value of a section and its tables as a dict of texts.

    Values are in the units of the design file. `prefix` is the name of the section followed by a dot; all keys begin
    with it.
    """
    for name, field in type(section).model_fields.items():
        value = getattr(section, name)
        if isinstance(value, Section):
            yield from _value_rows(value, f"{name}.")
        elif value is not None:
            unit = unit_of(field)
            file_value = unit.from_si(value) if isinstance(value, float) else value
            file_value = [unit.from_si(item) for item in value] if isinstance(value, tuple) else file_value
            key = f"{prefix}{file_key(name, field)}"
            yield {"key": key, "value": str(file_value), "unit": unit.suffix, "meaning": field.description or ""}


class Design(Section, Presented):
    """A cycloidal reducer with its drive and load; all values in SI.

    The defaults are the paper's pin reducer (Hsieh 2014, section 3.1 and Table 1); what the paper leaves open
    is marked as assumed in the design file.
    """

    name: str = choice(
        "pin",
        "name of the design and its runs: letters, digits, space . _ -",
        source="",
        pattern=r"^\w[\w .-]*$",
        max_length=64,
    )
    structure: Literal["rigid", "springs"] = choice(
        "rigid",
        "structure behind the contacts: rigid; springs: output pins bend, and carrier, shaft and housing twist",
        PAPER,
    )
    layout: Literal["central", "rv"] = choice(
        "central",
        "central: one crank in the middle, and output pins; rv: a planet stage, two or three cranks, no output pins",
        PAPER,
    )
    ring: Ring = Ring()
    gear: Gear = Gear()
    planet: Planet | None = _rv_table("The planet stage of an RV reducer")
    cranks: Cranks | None = _rv_table("The cranks of an RV reducer with their bearings, and its carrier")
    crank_errors: CrankErrors | None = _rv_table(
        "Manufacturing errors of cranks, crank bores and planets: crank 1 on +y, clockwise, at the crank angle 0"
    )
    crank_tolerance: CrankTolerance | None = _rv_table("Tolerances of the samples of `cycloid-mj tolerance`")
    output: Output = Output()
    shaft: Shaft = Shaft()
    housing: Housing = Housing()
    clearance: Clearance = Clearance()
    errors: Errors = Errors()
    measured: Measured = Measured()
    tolerance: Tolerance = Tolerance()
    modification: Modification = Modification()
    friction: Friction = Friction()
    drag: Drag = Drag()
    contact: ContactLaw = ContactLaw()
    stiffness: Stiffness = Stiffness()
    springs: StructureSprings = StructureSprings()
    damping: Damping = Damping()
    working_force: WorkingForce = WorkingForce()
    material: Material = Material()
    gear_material: Material | None = _part_material("the discs")
    housing_material: Material | None = _part_material("the housing or the internal gear")
    pin_material: Material | None = _part_material("the ring pins or their sleeves")
    output_material: Material | None = _part_material("the output disc and its pins")
    shaft_material: Material | None = _part_material("the shaft and the rollers on its cams")
    bearing: Bearing = Bearing()
    service: Service = Service()
    thermal: Thermal = Thermal()
    drive: Drive = Drive()
    load: Load = Load()
    environment: Environment = Environment()
    settings: Settings = Settings()

    def __repr__(self) -> str:
        """Return the key facts in one line; `design.dump` writes the complete file."""
        return f"Design({', '.join(f'{key} {value}' for key, value in self._key_facts())})"

    __str__ = __repr__

    def _repr_html_(self) -> str:
        """Return the key facts as a table for a notebook."""
        rows = "".join(f"<tr><th>{escape(key)}</th><td>{escape(value)}</td></tr>" for key, value in self._key_facts())
        return f"<table>{rows}</table>"

    @property
    def frame(self) -> "Frame":
        """Its values as the design file has them, a row each."""
        from cycloid_mj.base.frame import make_frame  # which takes NumPy, that no help page needs

        return make_frame([*_value_rows(self, "")], ("key", "value", "unit", "meaning"), {})

    def _key_facts(self) -> tuple[tuple[str, str], ...]:
        """Return the main properties of a design as pairs of name and text.

        They are name, ratio, ring, eccentricity, speed, nominal torque and load.
        """
        ring = self.ring
        kind = "internal gear" if ring.kind == "nonpin" else f"{ring.pins.replace('_', ' ')} pins"
        return (
            ("name", repr(self.name)),
            ("ratio", f"{self.reduction}:1"),
            ("ring", f"{ring.teeth} teeth, {kind}, E {1e3 * ring.pin_circle_radius:g} mm"),
            ("eccentricity", f"{1e3 * self.gear.eccentricity:g} mm"),
            ("speed", f"{self.drive.speed * 30.0 / math.pi:.6g} rpm"),
            ("nominal torque", f"{self.rated_torque:.6g} N m"),
            ("load", f"{self.load.torque:.6g} N m"),
        )

    def but(self, **changes: Any) -> Self:
        """Return a copy of the design with changed values in SI: ``design.but(load={"torque": 36.0}, name="loaded")``.

        Names are those of the model, without units. Values of a table that are not named do not change.

        Raises
        ------
        DesignError
            There is no such table or value, or it is not allowed.
        """
        values: dict[str, Any] = dict(self)  # tables that do not change are not validated again
        for name, change in changes.items():
            section = section_of(field) if (field := type(self).model_fields.get(name)) else None
            if section and isinstance(change, Mapping):
                table = values[name].model_dump() if values[name] else {}
                change = section.merge_change(table, {key: _as_tuple(value) for key, value in change.items()})
            values[name] = change
        try:
            return type(self).model_validate(values, strict=True)
        except ValidationError as error:
            raise as_design_error(error, type(self), f"design {self.name!r} with other values") from error

    @property
    def at_reference(self) -> Self:
        """Return the same design at 20 °C, the temperature at which its parts are manufactured.

        Raises
        ------
        DesignError
            The dimensions already include thermal expansion (``thermal.applied``), as in the design stored in a log.
        """
        if self.thermal.applied:
            raise DesignError(
                f"{self.name}: the clearances are those of warm parts (thermal.applied = true), but parts are "
                "manufactured at 20 °C. Use the original design file, not the one from the log"
            )
        return self.but(thermal=dict.fromkeys(HEATED, REFERENCE_TEMPERATURE)) if self.thermal.words else self

    def steady(self, settled: float, turns: float, samples: float = 0.0, **changes: Mapping[str, Any]) -> Self:
        """Return a copy that runs at full speed from the start: through the transients, then for some crank turns.

        Parameters
        ----------
        settled
            Duration of the transients [s].
        turns
            Number of crank turns after the transients.
        samples
            Additional time for filters and differences at the end, in sampling intervals of the log.
        changes
            Other changes of the design by table, then key; the crank's speed must not be 0.
        """
        design = self.but(**{**changes, "drive": {"ramp": 0.0, **changes.get("drive", {})}})
        duration = turns * 2.0 * math.pi / abs(design.drive.speed) + samples / design.settings.log_rate
        return design.but(drive={"hold": settled + duration})

    @model_validator(mode="before")
    @classmethod
    def _inherit_material(cls, value: Any) -> Any:
        """Return the tables of a design, `value`, in which parts without their own material inherit ``material``.

        These are the material tables of parts that set no ``name``. Runs before validation; `value` is unchanged.
        """
        part_keys = [f"{part}_material" for part in PARTS]
        tables = {key: value[key] for key in part_keys if isinstance(value.get(key), Mapping)}
        base_material = value.get("material", {})
        if not tables or not isinstance(base_material, Mapping):
            return value
        return {**value, **{key: {**base_material, **table} for key, table in tables.items() if "name" not in table}}

    @model_validator(mode="before")
    @classmethod
    def _rv_has_its_tables(cls, value: Any) -> Any:
        """Fill the tables of an RV reducer that are left out with their defaults."""
        if not isinstance(value, Mapping) or value.get("layout") != "rv":
            return value
        absent = [name for name in RV_TABLES if value.get(name) is None]
        return {**value, **{name: {} for name in absent}}

    @model_validator(mode="after")
    def _check_layout(self) -> Self:
        """Raise ValueError if values are set for parts that do not exist in the layout of the design."""
        if self.layout == "central":
            set_keys = [f"the table {name}" for name in RV_TABLES if getattr(self, name) is not None]
            remedy = 'remove it, or set layout = "rv"'
        else:
            set_keys = [key for key, is_default in _unused_keys(self) if not is_default]
            remedy = "remove it; an RV reducer has neither a central crank nor output pins"
            if "output.main_bearings" in set_keys:
                remedy += ", and its main bearings are set by cranks.main_bearings"
        if set_keys:
            raise ValueError(f'layout = "{self.layout}" has no use for {", ".join(set_keys)}: {remedy}')
        return self

    def material_of(self, part: str) -> Material:
        """Return the material of a part of `PARTS`."""
        return getattr(self, f"{part}_material") or self.material

    def material_table(self, part: str) -> str:
        """Return the table of the design file that sets the material of a part."""
        return f"{part}_material" if getattr(self, f"{part}_material") else "material"

    def partners(self, pair: str) -> tuple[Material, Material]:
        """Return the materials of the two parts that meet in a kind of mating pair."""
        part, other_part = PARTNERS[pair]
        return self.material_of(part), self.material_of(other_part)

    @property
    def rated_torque(self) -> float:
        """Nominal output torque: rated input torque times the ratio, without losses [N m]."""
        return self.drive.torque * self.reduction

    @property
    def cam_joint(self) -> CamJoint:
        """Joint of the cams to the shaft: `shaft.cam_joint`, but always ``one_piece`` with a single disc."""
        return "one_piece" if self.gear.discs == 1 else self.shaft.cam_joint

    @property
    def has_one_piece_crank(self) -> bool:
        """True if the cams are in one piece with the shaft: of a single disc, or as `shaft.cam_joint` requires."""
        return self.cam_joint == "one_piece"

    @property
    def lobes(self) -> int:
        """Lobes of the cycloid gear, N - 1."""
        return self.ring.teeth - 1

    @property
    def ratio(self) -> float:
        """Return the input turns per output turn [1]; negative if they rotate in opposite directions.

        It is R with the carrier as output and 1 - R with the ring as output. With N teeth of the ring, R is -(N - 1)
        for a central crank. For an RV reducer, whose input is the sun, R is 1 + N z_p/z_s with z_p teeth of a planet
        and z_s of the sun.
        """
        carrier_ratio: float = -self.lobes
        if self.planet is not None:
            carrier_ratio = 1.0 + self.ring.teeth * self.planet.planet_teeth / self.planet.sun_teeth
        return 1 - carrier_ratio if self.output.turns_ring else carrier_ratio

    @property
    def reduction(self) -> float:
        """Magnitude of the ratio [1]."""
        return abs(self.ratio)

    @property
    def tooth_pair(self) -> str:
        """Kind of mating pair between gear and ring: pin_gear or tooth."""
        return "tooth" if self.ring.kind == "nonpin" else "pin_gear"

    @property
    def ring_root_radius(self) -> float:
        """Radius out to which sockets or roots reach into the ring [m]: E + rho, or that of the gear's swept tips."""
        ring = self.ring
        if ring.kind == "pin":
            return ring.pin_circle_radius + ring.pin_radius
        return ring.pin_circle_radius - ring.pin_radius + 2.0 * self.gear.eccentricity

    @property
    def pin_retaining_radius(self) -> float:
        """Largest radius [m] of a cavity next to the ring whose wall covers a fifth of the end face of each ring pin.

        Without pins, it is the radius out to which the teeth reach.
        """
        ring = self.ring
        return ring.pin_circle_radius + 0.5 * ring.pin_radius if ring.kind == "pin" else self.ring_root_radius

    @property
    def bolt_circle_radius(self) -> float:
        """Radius of the ring's bolt circle [m]."""
        return self.housing.bolt_circle_radius or (self.ring_root_radius + self.housing.outer_radius) / 2.0

    @property
    def bolt_radius(self) -> float:
        """Radius that each of the ring's bolts clamps [m]."""
        return self.housing.bolt_radius or SHARES.bolt * (self.housing.outer_radius - self.ring_root_radius)

    def line_length(self, pair: str) -> float:
        """Return how long the contact line of a kind of mating pair is [m]: of a ring in two halves half the disc."""
        return self.gear.face_width / self.lines(pair)

    def lines(self, pair: str) -> int:
        """Count the lines that a kind of mating pair has across a disc: those on a ring in two halves have two."""
        return self.ring.halves if pair in (self.tooth_pair, self.seat_pair) else 1

    @property
    def has_tilting_pins(self) -> bool:
        """True if moving pins or sleeves tilt in simulations: two discs displace each of them in different planes."""
        return self.ring.has_pin_bodies and self.gear.discs == 2 and self.ring.halves == 1

    @property
    def seat_pair(self) -> str:
        """Kind of mating pair that carries a moving pin: pin_socket or pin_sleeve; empty where none moves."""
        return "pin_socket" if self.ring.has_sockets else "pin_sleeve" if self.ring.has_sleeves else ""

    @property
    def pair_kinds(self) -> tuple[str, ...]:
        """Kinds of mating pairs, from the ring to the output: the keys of their clearances."""
        return tuple(kind for kind in (self.tooth_pair, self.seat_pair, "cam", "output") if kind)

    @property
    def pin_play(self) -> float:
        """Clearance within which a pin, or its sleeve, moves about its place [m]; 0 where none moves."""
        if self.ring.has_sockets:
            return self.clearance.pin_socket
        return self.clearance.pin_sleeve if self.ring.has_sleeves else 0.0

    @property
    def socket_play(self) -> float:
        """Return the radial clearance of the housing around a loose ring pin or a sleeve [m]; 0 for other rings.

        A loose pin has no sleeve; its clearance is `clearance.pin_socket`. A pin with a sleeve is supported by the
        housing at both ends. The sleeve must not touch the housing, so its clearance is `SHARES.sleeve_room` times its
        radius.
        """
        if self.ring.has_sleeves:
            return SHARES.sleeve_room * self.ring.pin_radius
        return self.clearance.pin_socket if self.ring.has_sockets else 0.0

    def friction_of(self, pair: str) -> float:
        """Return the friction coefficient [1] of a kind of mating pair, reduced where rollers turn between the parts.

        `pair` is the kind, such as "pin_gear", "output" or "cam". With the law ``film``, sliding parts have its upper
        limit, the coefficient of boundary lubrication. Where a roller slides on an output pin, the coefficient is
        multiplied by the ratio of the radii of pin and roller. In an RV reducer, needles and tapered bearing of a crank
        both carry the force of a disc, so that their friction is counted twice.
        """
        if self.planet is not None and pair in (CRANK_BEARING, PLANET_MESH):
            if pair == CRANK_BEARING:
                return 2.0 * self.friction.cam_rolling
            return self.friction.boundary if self.has_film else self.planet.friction
        output = self.output
        is_rolling = {"cam": self.gear.bearing == "rolling", "output": output.has_needles}
        if self.has_film and not is_rolling.get(pair):
            coefficient = self.friction.boundary
        else:
            coefficient = float(getattr(self.friction, f"{pair}_rolling" if is_rolling.get(pair) else pair))
        if pair == "output" and output.rollers and (output.core_radius or not output.has_needles):
            return coefficient * output.root_radius / output.pin_radius
        return coefficient

    @property
    def mesh_friction(self) -> float:
        """Return the friction force per normal force [1] where the teeth of a disc slide on the ring.

        A pin or sleeve that can turn slides where its friction is lower: on the disc, or in its socket or on its core.
        The friction in a sleeve acts at the smaller radius of its bore.
        """
        gear_friction, ring = self.friction_of(self.tooth_pair), self.ring
        if ring.has_sockets:
            return min(gear_friction, self.friction_of("pin_socket"))
        if ring.has_sleeves:
            return min(gear_friction, self.friction_of("pin_sleeve") * ring.sleeve_bore_radius / ring.pin_radius)
        return gear_friction

    @property
    def condition_words(self) -> str:
        """Temperatures of the parts, unless they are 20 °C, and friction law, as a condition of results."""
        return ", ".join(filter(None, (self.thermal.words, self.friction.words)))

    @property
    def has_film(self) -> bool:
        """True if friction follows the film of a lubricant."""
        return self.friction.law == "film"

    @model_validator(mode="after")
    def _check_needles(self) -> Self:
        """Raise ValueError if a spring for each needle is requested, but neither cams nor output pins have rollers."""
        has_rollers = self.gear.bearing == "rolling" or (self.output.has_needles and self.output.has_roller_parts)
        if self.layout == "central" and self.contact.needles == "each" and not has_rollers:
            raise ValueError(
                'contact.needles = "each" applies to cams on rollers and to output pins with rollers on needles '
                '(output.core_radius), but this design has neither: set gear.bearing = "rolling", or contact.needles = '
                '"lumped"'
            )
        return self

    @model_validator(mode="after")
    def _check_impact_law(self) -> Self:
        """Raise ValueError if the contact law IMPACT is combined with stiffness, damping or a flexible structure."""
        if self.contact.law != "impact":
            return self
        set_keys = [f"stiffness.{kind}_n_m" for kind, value in self.stiffness if value]
        set_keys += [f"damping.{kind}" for kind, value in self.damping if value]
        set_keys += ["contact.stiffness_n_m"] * bool(self.contact.stiffness)
        set_keys += ['structure = "springs"'] * (self.structure == "springs")
        if set_keys:
            raise ValueError(
                f'contact.law = "impact" has its own stiffness and damping, but {", ".join(set_keys)} is set: '
                "remove it, or set contact.impact_stiffness_n_mm and contact.impact_damping_n_s_mm"
            )
        return self

    @model_validator(mode="after")
    def _check_error_lists(self) -> Self:
        """Raise ValueError if a list of manufacturing errors has a wrong length, or the ring has no pins for it."""
        tables: tuple[tuple[str, Section], ...] = (("errors", self.errors),)
        if self.crank_errors is not None:
            tables += (("crank_errors", self.crank_errors),)
        for table, section in tables:
            self._check_error_table(table, section)
        return self

    def _check_error_table(self, table: str, section: Section) -> None:
        """Raise ValueError if a list in a table of manufacturing errors has a wrong length, or is for missing pins.

        `section` has the lists, `table` is its name in messages.
        """
        for name, field in type(section).model_fields.items():
            if not (value := getattr(section, name)):
                continue
            key = f"{table}.{file_key(name, field)}"
            counts = {key: getattr(getattr(self, key[0]), key[1]) for key in counted_by(field)}
            part_count = math.prod(counts.values())
            if counts and len(value) != part_count:
                plural_counts = {part: count for part, count in counts.items() if count > 1} or counts
                product = " times ".join(".".join(part) for part in plural_counts)
                raise ValueError(
                    f"{key} has {len(value)} values, but {product} is {part_count}: give one value for each, or only "
                    f"those other than 0, as in {{1 = 5.0}}"
                )
            if self.ring.kind == "nonpin" and name.startswith("pin_") and (any(value) if counts else value):
                raise ValueError(
                    f"{key} is set, but an internal gear (ring.kind = 'nonpin') has no pins: remove this key, or set "
                    "ring.kind = 'pin'"
                )

    @model_validator(mode="after")
    def _check_measured_pins(self) -> Self:
        """Raise ValueError if there are measured pins for an internal gear, or not as many as ``ring.teeth``."""
        count, teeth = len(self.measured.pins_radial), self.ring.teeth
        if count and self.ring.kind == "nonpin":
            raise ValueError(
                f'measured.pins = "{self.measured.pins}" has pins, but an internal gear (ring.kind = "nonpin") has '
                "none: remove this key, or set ring.kind = 'pin'"
            )
        if count not in (0, teeth):
            raise ValueError(
                f'measured.pins = "{self.measured.pins}" has {count} pins, but ring.teeth is {teeth}: list each once'
            )
        return self


def _unused_keys(design: Design) -> Iterator[tuple[str, bool]]:
    """Yield the keys of the design file that have no effect with the layout of a design.

    Yields
    ------
    tuple
        Key, and whether its value is the default.
    """
    for name, field in Design.model_fields.items():
        section_type = section_of(field)
        if section_type is None or name.endswith("material"):
            if not applies(design.layout, "", name):
                yield file_key(name, field), getattr(design, name) == field.default
            continue
        values = getattr(design, name)
        for key, inner_field in section_type.model_fields.items() if values is not None else ():
            if not applies(design.layout, name, key):
                yield f"{name}.{file_key(key, inner_field)}", getattr(values, key) == inner_field.default


def _as_tuple(value: Any) -> Any:
    """Convert a list to the tuple that the model has in its place."""
    return tuple(value) if isinstance(value, list) else value


def describe_plastic_limits(design: Design) -> tuple[str, ...]:
    """Describe temperature limits and creep of the plastics of a design, a sentence for each; empty for metals."""
    parts_by_material: dict[Material, list[str]] = {}
    for part in PARTS:
        parts_by_material.setdefault(design.material_of(part), []).append(part)
    sentences = []
    for material, part_names in parts_by_material.items():
        entry = MATERIALS.get(material.name)
        if material.is_plastic:
            material_text = f"{material.name or 'a plastic'} ({', '.join(part_names)})"
            limit_text = f" and is usable up to {entry.hottest:g} °C ({entry.source})" if entry else ""
            sentences.append(
                f"{material_text} creeps{limit_text}: its stiffness and strength are those of a short load"
            )
    return tuple(sentences)
