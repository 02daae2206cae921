"""Checks of shaft, play, material, drive and load."""

import math
from collections.abc import Iterator

from cycloid_mj.checks.limit import Check, Limit, millimetres, told, verdict
from cycloid_mj.checks.teeth import pitches
from cycloid_mj.design import Design
from cycloid_mj.design.units import MICROMETRE

PLAY_SHARE = 0.1
"""Assumed: most play of the whole gear, as a share of the smaller of c and rho; a tooth jumps at about 2 c."""

OVERLOAD = 1.2
"""Assumed: most power that drive torque times speed may ask for, as a share of the rated power."""

PLAUSIBLE = {"youngs_modulus": (0.5e9, 700e9), "density": (800.0, 20000.0), "poisson": (0.1, 0.49)}
"""Assumed [SI]: from polymers to tungsten carbide. Beyond, it is mostly a slip of units."""


def mechanical_checks(design: Design) -> Iterator[Check]:
    """Check what is not the shape of gear and ring."""
    yield verdict(
        design,
        "output_pins",
        Limit("output.pins", "at least", 3),
        "two output pins carry no torque when they stand in line with the eccentricity",
    )
    yield from _output_root_checks(design)
    yield from _shaft_checks(design)
    if design.housing.support == "bolts" and design.ring_root_radius < design.housing.outer_radius:
        yield from _bolt_checks(design)
    yield _play(design)
    yield verdict(
        design,
        "yield_strength",
        Limit("material.yield_strength", "at most", design.material.tensile_strength),
        "no material yields above its tensile strength",
        Limit("material.tensile_strength", "at least", design.material.yield_strength),
    )
    for name, (low, high) in PLAUSIBLE.items():
        at_least = Limit(f"material.{name}", "at least", low)
        limit = Limit(at_least.key, "at most", high) if at_least.holds(design) else at_least
        why = "no material between polymers and tungsten carbide lies beyond (a slip of units?)"
        yield verdict(design, name, limit, why, severity="warning")
    yield from _drive_checks(design)


def _output_root_checks(design: Design) -> Iterator[Check]:
    output = design.output
    if output.rollers:
        yield verdict(
            design,
            "output_core",
            Limit("output.core_radius", "less than", output.pin_radius),
            "the core pin carries the roller round it",
            Limit("output.pin_radius", "more than", output.core_radius),
        )
    yield verdict(
        design,
        "output_fillet",
        Limit("output.fillet_radius", "less than", output.root_radius),
        "a fillet is to be smaller than the radius of the pin it rounds off",
    )


def _bolt_checks(design: Design) -> Iterator[Check]:
    """Check that the bolts' clamped circles lie within the wall behind the teeth, and apart from each other."""
    outer, root, circle = design.housing.outer_radius, design.ring_root_radius, design.bolt_circle_radius
    above = Limit("housing.bolt_circle_radius", "more than", root)
    limit = Limit(above.key, "less than", outer) if circle > root else above
    why = f"the bolts stand in the wall between the teeth (out to {millimetres(root)}) and the rim"
    yield verdict(design, "bolt_circle", limit, why)
    room = min(outer - circle, circle - max(root, 0.0))
    if not room > 0.0:
        return
    yield verdict(design, "bolt_radius", Limit("housing.bolt_radius", "less than", room), why)
    if design.bolt_radius < room:
        yield verdict(
            design,
            "bolts",
            Limit("housing.bolts", "less than", pitches(design.bolt_radius / circle)),
            "neighbouring bolts would clamp the same place",
            Limit("housing.bolt_radius", "less than", circle * math.sin(math.pi / design.housing.bolts)),
        )


def _shaft_checks(design: Design) -> Iterator[Check]:
    shaft, c = design.shaft, design.gear.eccentricity
    yield verdict(
        design,
        "shaft",
        Limit("shaft.radius", "less than", design.gear.bore_radius - c),
        "the cam must enclose the shaft, or the gear cannot be slid on",
        Limit("gear.bore_radius", "more than", shaft.radius + c),
    )
    yield verdict(
        design,
        "shaft_fillet",
        Limit("shaft.fillet_radius", "at most", max(design.gear.bore_radius - c - shaft.radius, 0.0)),
        "the cam's shoulder, which is lowest opposite the eccentricity, leaves no more room for a fillet",
        Limit("gear.bore_radius", "more than", shaft.radius + c + shaft.fillet_radius),
    )
    yield verdict(
        design,
        "counterweight",
        Limit("shaft.counterweight_radius", "more than", shaft.radius),
        "the counterweight must stand out from the shaft",
        Limit("shaft.radius", "less than", shaft.counterweight_radius),
    )
    yield verdict(
        design,
        "counterweight_room",
        Limit("shaft.counterweight_radius", "less than", design.ring.pin_circle_radius - design.ring.pin_radius),
        "the counterweight turns inside the ring's teeth, which reach in to E - rho",
        Limit("ring.pin_circle_radius", "more than", shaft.counterweight_radius + design.ring.pin_radius),
    )


def _play(design: Design) -> Check:
    """Check the sum of the clearances on the way from crank to ring and output."""
    holders = {"pin_socket": design.ring.has_sockets, "pin_sleeve": design.ring.has_sleeves}
    names = [design.tooth_pair, *(name for name, holds in holders.items() if holds), "cam", "output"]
    total = sum(getattr(design.clearance, name) for name in names)
    allowed = PLAY_SHARE * min(design.gear.eccentricity, design.ring.pin_radius)
    got, limit = told(total, "at most", allowed, MICROMETRE)
    shares = [Limit(f"clearance.{name}", "at most", allowed / len(names)) for name in names]
    remedies = [] if total <= allowed else [share.remedy(design) for share in shares if not share.holds(design)]
    return Check(
        name="play",
        passed=total <= allowed,
        got=f"{got} ({' + '.join(names)})",
        limit=f"{limit} ({PLAY_SHARE:.0%} of the smaller of c and rho, assumed)",
        why="with more play the teeth leave their conjugate contact, and in the end jump",
        remedy=" and ".join(remedies),
        key="clearance",
    )


def _drive_checks(design: Design) -> Iterator[Check]:
    drive, load = design.drive, design.load.torque
    speed = abs(drive.speed)
    yield verdict(
        design,
        "power",
        Limit("drive.power", "at least", drive.torque * speed / OVERLOAD),
        f"drive torque times speed is to be at most {OVERLOAD:g} times the rated power (assumed)",
        Limit("drive.torque", "at most", OVERLOAD * drive.power / speed if speed else math.inf),
        severity="warning",
    )
    capacity = drive.torque * design.lobes
    yield verdict(
        design,
        "load",
        Limit("load.torque", "at most", capacity) if load >= 0 else Limit("load.torque", "at least", -capacity),
        "the rated drive torque times the ratio, N - 1, is all that a drive without losses can move",
        Limit("drive.torque", "at least", abs(load) / design.lobes),
        severity="warning",
    )
