"""Rules and checks of shaft, clearances, materials, drive and load."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from cycloid_mj.checks.check import Check
from cycloid_mj.checks.limit import LIMIT, Limit, joint_remedy, millimetres, numbers, value_and_limit
from cycloid_mj.checks.rule import Rule
from cycloid_mj.checks.teeth import circles_on_circle
from cycloid_mj.design import PARTS, Material
from cycloid_mj.design.units import DEGREE, MICROMETRE
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.limits import widest_play


@dataclass(frozen=True)
class MechanicsSettings:
    """Assumed limits of clearances and drive, and settings of the check of backlash."""

    max_clearance_share: float = 0.1
    """Assumed largest sum of the clearances over the smaller of c and rho that is small against the teeth."""
    jump_margin: float = 1e-3
    """Relative distance of a remedy from the limit on the backlash."""
    jump_poses: int = 4
    jump_sides: int = 32
    """Crank angles at which a large backlash is computed, and sides of the polygon around the clearance of the cam."""
    max_bore_share: float = 0.9
    """Assumed largest bore of a hollow shaft relative to its diameter: a tube that can still be turned and ground."""
    overload: float = 1.2
    """Assumed largest product of motor torque and speed over the rated power."""


MECHANICS = MechanicsSettings()


PLAUSIBLE = {"youngs_modulus": (0.5e9, 700e9), "density": (800.0, 20000.0), "poisson": (0.1, 0.49)}
"""Assumed ranges [SI], from polymers to tungsten carbide: values beyond are mostly mistakes of units."""


def mechanical_rules(reducer: Reducer, has_shape: bool) -> Iterator[Rule | Check]:
    """Yield the rules for number and roots of the output pins, shaft, bolts, clearances, materials and motor.

    `has_shape` is true if disc and ring are feasible, which the check of tooth skipping requires (`_clearance_checks`).
    """
    design = reducer.design
    yield Rule(
        "output_pins",
        Limit("output.pins", "at least", 3),
        "two output pins transmit no torque when they are in line with the eccentricity",
    )
    yield from _output_root_rules(reducer)
    yield from _shaft_rules(reducer)
    if design.housing.support == "bolts" and design.ring_root_radius < design.housing.outer_radius:
        yield from _bolt_rules(reducer)
    yield from _clearance_checks(reducer, has_shape)
    tables = ("material", *(f"{part}_material" for part in PARTS))
    for table in tables:
        if material := getattr(design, table):
            yield from material_rules(table, material)
    yield from _drive_rules(reducer)


def material_rules(table: str, material: Material) -> Iterator[Rule]:
    """Yield the rules for the values of a material, which is that of a table of the design, such as "pin_material".

    The yield strength is at most the tensile strength, and other values are in the ranges `PLAUSIBLE`. Names of the
    rules begin with the part in the name of the table, such as "pin_yield_strength"; those of the table "material" have
    no such prefix.
    """
    part = table.removesuffix("material")
    yield Rule(
        f"{part}yield_strength",
        Limit(f"{table}.yield_strength", "at most", material.tensile_strength),
        "the yield strength of a material cannot exceed its tensile strength",
        (Limit(f"{table}.tensile_strength", "at least", material.yield_strength),),
    )
    for name, (min_value, max_value) in PLAUSIBLE.items():
        side, bound = ("at most", max_value) if getattr(material, name) >= min_value else ("at least", min_value)
        limit = Limit(f"{table}.{name}", side, bound)
        explanation = "no material from polymers to tungsten carbide is beyond this limit: check the unit"
        yield Rule(f"{part}{name}", limit, explanation, severity="warning")


def _output_root_rules(reducer: Reducer) -> Iterator[Rule]:
    """Yield the rules that an output pin's core is thinner than its roller, and its fillet smaller than the pin."""
    output = reducer.design.output
    if output.rollers:
        yield Rule(
            "output_core",
            Limit("output.core_radius", "less than", output.pin_radius),
            "the roller turns around the core pin",
            (Limit("output.pin_radius", "more than", output.core_radius),),
        )
    yield Rule(
        "output_fillet",
        Limit("output.fillet_radius", "less than", output.root_radius),
        "a fillet must be smaller than the radius of its pin",
    )


def _bolt_rules(reducer: Reducer) -> Iterator[Rule]:
    """Yield the rules that the circles clamped by the bolts are in the wall behind the teeth and do not overlap.

    The rules for their size are left out if the bolt circle is outside the wall.
    """
    design = reducer.design
    outer_radius, root_radius, bolt_circle_radius = (
        design.housing.outer_radius,
        design.ring_root_radius,
        design.bolt_circle_radius,
    )
    lower_limit = Limit("housing.bolt_circle_radius", "more than", root_radius)
    limit = Limit(lower_limit.key, "less than", outer_radius) if bolt_circle_radius > root_radius else lower_limit
    explanation = f"the bolts are in the wall between the teeth (out to {millimetres(root_radius)}) and the rim"
    yield Rule("bolt_circle", limit, explanation)
    max_bolt_radius = min(outer_radius - bolt_circle_radius, bolt_circle_radius - max(root_radius, 0.0))
    if not max_bolt_radius > 0.0:
        return
    yield Rule("bolt_radius", Limit("housing.bolt_radius", "less than", max_bolt_radius), explanation)
    if design.bolt_radius < max_bolt_radius:
        yield Rule(
            "bolts",
            Limit("housing.bolts", "less than", circles_on_circle(design.bolt_radius / bolt_circle_radius)),
            "the clamped circles of neighbouring bolts would overlap",
            (Limit("housing.bolt_radius", "less than", bolt_circle_radius * math.sin(math.pi / design.housing.bolts)),),
        )


def _shaft_rules(reducer: Reducer) -> Iterator[Rule]:
    """Yield the rules that the cam encloses shaft and fillet, a hollow shaft has a wall, and the counterweight fits.

    The counterweight must be larger than the shaft, and turn inside the ring. Several discs need none.
    """
    design = reducer.design
    shaft, eccentricity = design.shaft, design.gear.eccentricity
    yield Rule(
        "shaft",
        Limit("shaft.radius", "less than", design.gear.bore_radius - eccentricity),
        "the cam must enclose the shaft, or the disc cannot be assembled",
        (Limit("gear.bore_radius", "more than", shaft.radius + eccentricity),),
    )
    if shaft.bore_radius:
        max_share = MECHANICS.max_bore_share
        yield Rule(
            "shaft_bore",
            Limit("shaft.bore_radius", "at most", max_share * shaft.radius),
            f"the wall of a hollow shaft must be at least {100.0 * (1.0 - max_share):.0f} % of its radius",
            (Limit("shaft.radius", "at least", shaft.bore_radius / max_share),),
        )
    yield Rule(
        "shaft_fillet",
        Limit("shaft.fillet_radius", "at most", max(design.gear.bore_radius - eccentricity - shaft.radius, 0.0)),
        "the cam's shoulder, lowest opposite the eccentricity, leaves no more room for a fillet",
        (Limit("gear.bore_radius", "more than", shaft.radius + eccentricity + shaft.fillet_radius),),
    )
    if design.gear.discs > 1:  # they balance each other
        return
    yield Rule(
        "counterweight",
        Limit("shaft.counterweight_radius", "more than", shaft.radius),
        "the counterweight must be larger than the shaft",
        (Limit("shaft.radius", "less than", shaft.counterweight_radius),),
    )
    yield Rule(
        "counterweight_room",
        Limit("shaft.counterweight_radius", "less than", design.ring.pin_circle_radius - design.ring.pin_radius),
        "the counterweight turns inside the ring's teeth, which reach inwards to E - rho",
        (Limit("ring.pin_circle_radius", "more than", shaft.counterweight_radius + design.ring.pin_radius),),
    )


def _clearance_checks(reducer: Reducer, has_shape: bool) -> Iterator[Check]:
    """Yield the check that the sum of all clearances, from crank to ring and output, is small.

    The bound is `MECHANICS.max_clearance_share` times the smaller of eccentricity and pin radius. If it is exceeded,
    and the disc has a feasible shape (`has_shape`), a second check is yielded: that the disc cannot skip a tooth.
    """
    design = reducer.design
    pair_kinds = design.pair_kinds
    clearance_sum, max_sum = _total_clearance(reducer)
    value_text, limit_text = value_and_limit(clearance_sum, "at most", max_sum, MICROMETRE)
    limits = [Limit(f"clearance.{kind}", "at most", max_sum / len(pair_kinds)) for kind in pair_kinds]
    violated_limits = [] if clearance_sum <= max_sum else [limit for limit in limits if not limit.is_met(reducer)]
    yield Check(
        name="play",
        passed=clearance_sum <= max_sum,
        got=f"{value_text} ({' + '.join(pair_kinds)})",
        limit=f"{limit_text} ({MECHANICS.max_clearance_share:.0%} of the smaller of c and rho, assumed)",
        why="with larger clearances the teeth are not in conjugate contact: statics and closed forms are estimates",
        severity="warning",
        key="clearance",
        **joint_remedy(reducer, violated_limits),
    )
    if clearance_sum > max_sum and has_shape:
        yield _check_tooth_skip(reducer)


def _total_clearance(reducer: Reducer) -> tuple[float, float]:
    """Return the sum of the clearances from crank to ring and output, and its assumed maximum [m]."""
    design = reducer.design
    clearance_sum = sum(getattr(design.clearance, kind) for kind in design.pair_kinds)
    return clearance_sum, MECHANICS.max_clearance_share * min(design.gear.eccentricity, design.ring.pin_radius)


def jumps(reducer: Reducer) -> bool:
    """Return whether the disc can skip a tooth within its clearances, by the criterion of `soundness`.

    Disc and ring must pass their checks; the search stops at the first crank angle where it can.
    """
    clearance_sum, max_sum = _total_clearance(reducer)
    return clearance_sum > max_sum and any(backlash > _half_lobe_rotation(reducer) for backlash in _backlashes(reducer))


def _half_lobe_rotation(reducer: Reducer) -> float:
    """Compute the rotation of the output by which the disc has turned by half a lobe [rad]."""
    return reducer.share * math.pi / reducer.design.lobes


def _backlashes(reducer: Reducer) -> Iterator[float]:
    """Yield the backlash of the output with rigid parts [rad] at each of `MECHANICS.jump_poses` crank angles."""
    crank_angles = (2.0 * math.pi * index / MECHANICS.jump_poses for index in range(MECHANICS.jump_poses))
    return (widest_play(reducer, crank_angle, MECHANICS.jump_sides) for crank_angle in crank_angles)


def _check_tooth_skip(reducer: Reducer) -> Check:
    """Return the check that the disc cannot skip a tooth: the total backlash must be less than half a lobe.

    The remedy reduces all clearances by a common factor.
    """
    design = reducer.design
    backlash, max_backlash = max(_backlashes(reducer)), _half_lobe_rotation(reducer)
    value_text, limit_text = value_and_limit(backlash, "at most", max_backlash, DEGREE)
    factor = (1.0 - MECHANICS.jump_margin) * max_backlash / backlash
    limits = [
        Limit(f"clearance.{kind}", "at most", factor * getattr(design.clearance, kind)) for kind in design.pair_kinds
    ]
    return Check(
        name="jump",
        passed=backlash <= max_backlash,
        got=f"{value_text} from stop to stop",
        limit=f"{limit_text} (half a lobe)",
        why="with a larger backlash the disc skips a tooth",
        key="the backlash of the output",
        **joint_remedy(reducer, [] if backlash <= max_backlash else limits),
        **numbers(backlash, max_backlash, DEGREE),
    )


def _drive_rules(reducer: Reducer) -> Iterator[Rule]:
    """Yield the rules that the motor has enough power for its torque and speed, and enough torque for the load."""
    design = reducer.design
    drive, load_torque = design.drive, design.load.torque
    speed = abs(drive.speed)
    yield Rule(
        "power",
        Limit("drive.power", "at least", drive.torque * speed / MECHANICS.overload),
        f"motor torque times speed should be at most {MECHANICS.overload:g} times the rated power (assumed)",
        (Limit("drive.torque", "at most", MECHANICS.overload * drive.power / speed if speed else math.inf),),
        severity="warning",
    )
    max_torque = design.rated_torque * (1.0 + LIMIT.strict_margin)  # the load may be that torque, up to rounding
    yield Rule(
        "load",
        Limit("load.torque", "at most", max_torque)
        if load_torque >= 0
        else Limit("load.torque", "at least", -max_torque),
        f"motor torque times ratio ({design.reduction}) is the limit of a drive without losses",
        (Limit("drive.torque", "at least", abs(load_torque) / design.reduction),),
        severity="warning",
    )
