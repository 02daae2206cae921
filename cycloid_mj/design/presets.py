"""The built-in designs: the two of the paper, and drives that other people have built and published."""

from collections.abc import Mapping
from operator import attrgetter

from cycloid_mj.design.layouts import supports
from cycloid_mj.design.lubricants import greased_friction
from cycloid_mj.design.model import Design, Ring
from cycloid_mj.design.units import MICROMETRE, MILLIMETRE, RPM


def _make_printed() -> Design:
    """Return the design of the printed drive of a master thesis (JelmerV, Twente 2024).

    Source: github.com/JelmerV/Anti-Backlash-Cycloidal-Actuator (CC BY-SA 4.0), ``CAD source/parameters.txt``, and the
    parts that ``Documentation/Bill of Materials.xlsx`` names: HK0509 needle rollers on 5 mm output pins, HK1522 with an
    inner ring 12 x 15 x 22.5 on the shaft. Other values are assumed, each with its `preset_reasons`. Two parts differ
    from the thesis. The ring has pins of steel instead of a printed internal gear. The shaft has a diameter of 12 mm,
    that of the inner ring, instead of steps for the bearings 6803 and 6806.
    """
    mm, um = MILLIMETRE.to_si, MICROMETRE.to_si
    return Design(name="printed", structure="springs").but(
        ring={"teeth": 14, "pin_circle_radius": mm(34.0), "pin_radius": mm(3.5), "pins": "fixed"},
        gear={"eccentricity": mm(1.5), "face_width": mm(25.0), "bore_radius": mm(10.5)},
        output={
            "pins": 8,
            "pin_radius": mm(4.5),
            "pin_circle_radius": mm(20.0),
            "hole_radius": mm(6.0),
            "core_radius": mm(2.5),
            "support": "both_ends",
        },
        shaft={"radius": mm(6.0), "length": mm(40.0), "counterweight_radius": mm(24.0), "mounting": "straddle"},
        housing={"outer_radius": mm(45.0)},
        clearance={"pin_gear": um(50.0), "tooth": um(50.0), "cam": um(10.0), "output": um(50.0)},
        friction={
            "law": "film",
            "lubricant": "lithium complex grease 220",
            "roughness": um(10.0),
            "boundary": sum(greased_friction("Onyx")) / 2.0,
            "pin_gear": 0.12,
        },
        material={"name": "Onyx"},
        pin_material={"name": "bearing steel"},
        output_material={"name": "bearing steel"},
        shaft_material={"name": "tempered steel"},
        drive={"power": 50.0, "torque": 0.8, "speed": RPM.to_si(100.0), "ramp": 0.1, "hold": 1.5},
        load={"torque": 10.0},
    )


def _make_twodisc() -> Design:
    """Return the design of a two-disc drive from a worked calculation (github.com/kubakos/cycloid-drive-generator).

    Ratio, teeth, discs, output pins, input torque and speed, and the rating of the bearings on the eccentrics are taken
    from this source. Other values are assumed, each with its `preset_reasons`.
    """
    mm, um = MILLIMETRE.to_si, MICROMETRE.to_si
    return Design(name="twodisc", structure="springs").but(
        ring={"teeth": 30, "pin_circle_radius": mm(52.5), "pin_radius": mm(3.5), "pins": "fixed"},
        gear={
            "discs": 2,
            "disc_gap": mm(3.0),
            "eccentricity": mm(1.250025),
            "face_width": mm(13.5),
            "bore_radius": mm(19.0),
        },
        output={
            "pins": 4,
            "pin_radius": mm(6.0),
            "pin_circle_radius": mm(34.0),
            "hole_radius": mm(7.250025),
            "rollers": False,
            "disc_thickness": mm(10.0),
            "support": "both_ends",
        },
        shaft={"radius": mm(12.0), "length": mm(40.0), "counterweight_radius": mm(40.0), "mounting": "straddle"},
        housing={"outer_radius": mm(65.0)},
        clearance=dict.fromkeys(("pin_gear", "pin_socket", "pin_sleeve", "tooth", "cam", "output"), um(2.0)),
        friction={"law": "film"},
        material={"name": "tempered steel"},
        pin_material={"name": "bearing steel"},
        output_material={"name": "bearing steel"},
        bearing={"dynamic_capacity": 34500.0, "service_factor": 1.2},
        drive={"power": 300.0, "torque": 4.0, "speed": RPM.to_si(600.0), "ramp": 0.1, "hold": 0.4},
    )


_RV_GREASED = {"law": "film", "lubricant": "fluid reducer grease 130"}
"""Friction of RV reducers, which makers fill with a fluid grease."""


def _make_rv80e() -> Design:
    """Return the design of an RV-80E reducer (Yang, Zhou, Chang, Chen, Mech. Mach. Theory 163 (2021), 104384).

    Teeth, module, pin circle, eccentricity, pin radius and cranks are published. The load is the catalogue's rated
    torque at 15 rpm of the output. Other values are assumed, each with its `preset_reasons`. Among them, the stiffness
    of bearings and teeth is chosen so that the drive has the torsional stiffness of the catalogue.
    """
    mm, um = MILLIMETRE.to_si, MICROMETRE.to_si
    return Design(name="rv80e", layout="rv").but(
        ring={"teeth": 40, "pin_circle_radius": mm(77.5), "pin_radius": mm(4.0)},
        gear={"discs": 2, "disc_gap": mm(2.0), "eccentricity": mm(1.5), "face_width": mm(15.0)},
        housing={"outer_radius": mm(95.0)},
        clearance={"pin_gear": um(0.1), "pin_socket": um(0.1)},
        friction=_RV_GREASED,
        contact={"stiffness_law": "uniform"},
        stiffness={"pin_gear": 6e8, "pin_socket": 6e8},
        material={"name": "bearing steel"},
        drive={"power": 1500.0, "torque": 784.0 / 153.0, "speed": RPM.to_si(153.0 * 15.0), "ramp": 0.1, "hold": 0.4},
        load={"torque": 784.0},
    )


def _make_rv64() -> Design:
    """Return the design of an RV reducer with a pin-circle radius of 64 mm, as in the RV example of the code Exudyn.

    Discs, pins, eccentricity, cranks and needles are those of the example. Sun and planets are not part of it: with a
    module of 1.25 mm they fit the circle of cranks. They have the ratio 121, which the catalogue states for the RV-40E,
    a drive of similar size. Other values are assumed, each with its `preset_reasons`.
    """
    mm, um = MILLIMETRE.to_si, MICROMETRE.to_si
    return Design(name="rv64", layout="rv").but(
        ring={"teeth": 40, "pin_circle_radius": mm(64.0), "pin_radius": mm(3.0)},
        gear={"discs": 2, "disc_gap": mm(2.0), "eccentricity": mm(1.3), "face_width": mm(12.0)},
        planet={"sun_teeth": 12, "planet_teeth": 36, "module": mm(1.25), "face_width": mm(10.0)},
        cranks={
            "count": 3,
            "eccentric_radius": mm(12.0),
            "needle_radius": mm(2.0),
            "needles": 16,
            "taper_radius": mm(18.0),
            "middle_hole_radius": mm(10.0),
            "post_radius": mm(8.5),
            "flange_thickness": mm(15.0),
        },
        housing={"outer_radius": mm(80.0)},
        clearance={"pin_gear": um(0.1), "pin_socket": um(0.1)},
        friction=_RV_GREASED,
        contact={"stiffness_law": "uniform"},
        stiffness={"pin_gear": 4.8e8, "pin_socket": 4.8e8},
        material={"name": "bearing steel"},
        drive={"power": 800.0, "torque": 412.0 / 121.0, "speed": RPM.to_si(121.0 * 15.0), "ramp": 0.1, "hold": 0.4},
        load={"torque": 412.0},
    )


PRESETS = {
    "pin": Design(),
    "nonpin": Design(name="nonpin", ring=Ring(kind="nonpin")),
    "printed": _make_printed(),
    "twodisc": _make_twodisc(),
    "rv80e": _make_rv80e(),
    "rv64": _make_rv64(),
}
"""Designs by name."""


def presets_for(command: str) -> dict[str, Design]:
    """Return the presets whose layout a command supports, by name."""
    return {name: design for name, design in PRESETS.items() if supports(design.layout, command)}


_DRAWN = "parameters.txt"
_BEARING = "of a drawn cup in its seat (assumed; 5 um more or less are 2 arcmin of backlash)"

_WORKED = "the worked calculation"

_YANG = "Yang et al. 2021"
_STIFF_AS = "a drive as stiff as the catalogue's, 196 N m/arcmin"

_RV_GREASE = "filled with a fluid grease, as RV reducers are (assumed)"

_EXUDYN = "RV example for Exudyn"

_REASONS: Mapping[str, Mapping[str, str]] = {
    "rv80e": {
        **dict.fromkeys(("ring.teeth", "ring.pin_circle_radius", "ring.pin_radius"), _YANG),
        **dict.fromkeys(("gear.discs", "gear.eccentricity"), _YANG),
        **dict.fromkeys(("stiffness.pin_gear", "stiffness.pin_socket", "contact.stiffness_law"), _STIFF_AS),
        **dict.fromkeys(("cranks.needle_stiffness", "cranks.taper_stiffness"), _STIFF_AS),
        **dict.fromkeys(("cranks.needle_clearance", "cranks.taper_clearance"), "adjusted without play (assumed)"),
        **dict.fromkeys(("clearance.pin_gear", "clearance.pin_socket"), "paired parts, nearly without play (assumed)"),
        "friction.law": _RV_GREASE,
        "friction.lubricant": _RV_GREASE,
        "ring.pins": "needles in half-open grooves",
        "drive.torque": "rated torque 784 N m over the ratio",
        "drive.speed": "15 rpm of the output (catalogue)",
        "load.torque": "rated torque (catalogue)",
    },
    "rv64": {
        **dict.fromkeys(("ring.teeth", "ring.pin_circle_radius", "ring.pin_radius"), _EXUDYN),
        **dict.fromkeys(("gear.discs", "gear.eccentricity"), _EXUDYN),
        **dict.fromkeys(("cranks.count", "cranks.eccentric_radius"), _EXUDYN),
        **dict.fromkeys(("cranks.needle_radius", "cranks.needles"), _EXUDYN),
        **dict.fromkeys(("cranks.needle_clearance", "cranks.taper_clearance"), "adjusted without play (assumed)"),
        **dict.fromkeys(("cranks.needle_stiffness", "cranks.taper_stiffness"), "as rv80e (assumed)"),
        **dict.fromkeys(("cranks.middle_hole_radius", "cranks.post_radius"), "leaves walls (assumed)"),
        **dict.fromkeys(("planet.sun_teeth", "planet.planet_teeth"), "ratio 121 of the RV-40E (catalogue)"),
        **dict.fromkeys(("stiffness.pin_gear", "stiffness.pin_socket"), "as rv80e, by the face width (assumed)"),
        **dict.fromkeys(("clearance.pin_gear", "clearance.pin_socket"), "paired parts, nearly without play (assumed)"),
        "planet.module": "cranks on a radius of 30 mm (RV example for Exudyn)",
        "contact.stiffness_law": "as rv80e (assumed)",
        "friction.law": _RV_GREASE,
        "friction.lubricant": _RV_GREASE,
        "ring.pins": "needles in half-open grooves (assumed)",
        "drive.torque": "rated torque 412 N m over the ratio",
        "drive.speed": "15 rpm of the output (catalogue)",
        "load.torque": "rated torque of the RV-40E (catalogue), a drive of this size",
    },
    "twodisc": {
        **dict.fromkeys(("ring.teeth", "ring.pin_circle_radius", "ring.pin_radius"), _WORKED),
        **dict.fromkeys(("gear.discs", "gear.disc_gap", "gear.eccentricity", "gear.face_width"), _WORKED),
        **dict.fromkeys(("output.pins", "output.pin_radius", "output.pin_circle_radius"), _WORKED),
        **dict.fromkeys(("drive.torque", "drive.speed"), _WORKED),
        "structure": "as drives are built",
        "ring.pins": "pressed in (assumed)",
        "gear.bore_radius": "leaves walls to the output holes (assumed)",
        "output.hole_radius": "output pin + eccentricity",
        "output.rollers": "solid pins slide in their holes (assumed)",
        "output.support": "held at one end, the pins would leave three quarters of the load to disc 2 (assumed)",
        "shaft.mounting": "a bearing on either side of the discs (assumed)",
        "housing.outer_radius": "a wall of 9 mm outside the pins (assumed)",
        "clearance.pin_gear": "ground parts (assumed)",
        "friction.law": "a greased drive of steel (assumed)",
        "material.name": "assumed",
        "bearing.dynamic_capacity": _WORKED,
        "bearing.service_factor": _WORKED,
        "drive.power": "what 4 N m at 600 rpm ask for, with a fifth to spare",
    },
    "printed": {
        "structure": "as drives are built",
        "ring.teeth": _DRAWN,
        "ring.pin_circle_radius": _DRAWN,
        "ring.pin_radius": _DRAWN,
        "ring.kind": "assumed: the drive that was measured has the internal gear (nonpin), printed in one piece",
        "ring.pins": "steel, held at both ends (assumed)",
        "gear.eccentricity": _DRAWN,
        "gear.face_width": _DRAWN,
        "gear.bore_radius": "outside of the needle bearing HK1522",
        "output.pins": _DRAWN,
        "output.pin_radius": "outside of the needle roller HK0509",
        "output.pin_circle_radius": _DRAWN,
        "output.hole_radius": "output pin + eccentricity",
        "output.core_radius": "the pin in the needle roller HK0509",
        "output.support": "parameters.txt: output_stiffener",
        "shaft.radius": "bore of the inner ring 12 x 15 x 22.5",
        "shaft.mounting": "section view of its CAD: one bearing in the housing, one in the output's hub",
        "clearance.pin_gear": "parameters.txt: cycloid_clearance",
        "clearance.tooth": "parameters.txt: cycloid_clearance",
        "clearance.cam": _BEARING,
        "clearance.output": "as the teeth (assumed)",
        "friction.law": "greased (assumed)",
        "friction.lubricant": "synthetic base oil, which plastics withstand (assumed)",
        "friction.roughness": "layers of a printed flank (assumed)",
        "friction.pin_gear": "with the law coulomb: greased plastic on steel, assumed",
        "friction.boundary": "greased plastic on steel, 0.05 to 0.12 (VDI 2736-2)",
        "material.name": "what housing and gear were printed of in one of its builds; dry, in the layers' plane",
        "drive.torque": "for the load of the run; the thesis names 52 N m at the output, beyond first yield here",
        "drive.speed": "assumed",
        "load.torque": "assumed: below the first yield of the teeth",
    },
}
"""Why a preset's values are as they are; those of the paper's designs have their sources in the model itself."""


def preset_reasons(name: str, design: Design) -> dict[str, str]:
    """Return the reasons for values of the preset called `name`; empty if no preset has this name.

    The keys are attributes of `Design`, such as "ring.pin_radius", and not keys of a design file, which end in units.
    `design` is derived from the preset; values that differ from the preset are left out.
    """
    name = name.casefold()
    return {
        key: reason
        for key, reason in _REASONS.get(name, {}).items()
        if attrgetter(key)(design) == attrgetter(key)(PRESETS[name])
    }
