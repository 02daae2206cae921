"""Rules for the disc's body: its bore, the output holes, the walls between them, and its balance."""

import math
from collections.abc import Iterator

from cycloid_mj.checks.check import Check
from cycloid_mj.checks.limit import Limit, millimetres
from cycloid_mj.checks.rule import Rule, wall_rule
from cycloid_mj.checks.teeth import TEETH, circles_on_circle
from cycloid_mj.design.units import MILLIMETRE
from cycloid_mj.parts.accuracy import RELATIVE_ROUNDING
from cycloid_mj.reducer import Reducer


def body_rules(reducer: Reducer) -> Iterator[Rule | Check]:
    """Yield the rules (`wall_rule`) for the thickness of the disc's walls, and the check of the radius of its holes.

    In texts, E is the radius of the pin circle. The walls are those between bore and root of the lobes ("bore"), bore
    and output holes ("holes_to_bore"), output holes and root ("holes_to_root"), and between neighbouring output holes.
    """
    design = reducer.design
    output_circle_radius, cam_clearance = design.output.pin_circle_radius, design.clearance.cam
    E, pin_radius, bore_radius, hole_radius = (
        design.ring.pin_circle_radius,
        design.ring.pin_radius,
        _bore_radius(reducer),
        _hole_radius(reducer),
    )
    root_depth = design.gear.eccentricity + reducer.profile_offset - design.modification.pin_circle
    root_radius = E - root_depth
    root_text = f"the root of the lobes (radius {millimetres(root_radius)})"

    def bore_to_root_limits(relative_wall: float) -> tuple[Limit, ...]:
        """Return the limits for a wall of `relative_wall` [1] times the pin-circle radius between bore and roots."""
        return (
            Limit("gear.bore_radius", "less than", root_radius - relative_wall * E - cam_clearance),
            Limit("ring.pin_circle_radius", "more than", (bore_radius + root_depth) / (1 - relative_wall)),
            Limit("ring.pin_radius", "less than", root_radius - relative_wall * E - bore_radius + pin_radius),
        )

    def bore_to_holes_limits(relative_wall: float) -> tuple[Limit, ...]:
        """Return the limits for a wall of `relative_wall` [1] times the pin-circle radius between bore and holes."""
        return (
            Limit(
                "gear.bore_radius", "less than", output_circle_radius - hole_radius - relative_wall * E - cam_clearance
            ),
            Limit("output.pin_circle_radius", "more than", bore_radius + relative_wall * E + hole_radius),
        )

    def holes_to_root_limits(relative_wall: float) -> tuple[Limit, ...]:
        """Return the limits for a wall of `relative_wall` [1] times the pin-circle radius between holes and roots."""
        return (
            Limit("output.pin_circle_radius", "less than", root_radius - relative_wall * E - hole_radius),
            Limit(
                "ring.pin_circle_radius",
                "more than",
                (output_circle_radius + hole_radius + root_depth) / (1 - relative_wall),
            ),
        )

    yield wall_rule("bore", bore_to_root_limits, TEETH.min_wall_share, E, f"between the bore and {root_text}")
    yield wall_rule(
        "holes_to_bore", bore_to_holes_limits, TEETH.min_wall_share, E, "between the bore and the output holes"
    )
    yield wall_rule(
        "holes_to_root",
        holes_to_root_limits,
        TEETH.min_wall_share,
        E,
        f"between the output holes and {root_text}",
    )
    yield _hole_wall_rule(reducer)
    yield _check_hole_size(reducer)


def balance_rules(reducer: Reducer) -> tuple[Rule, ...]:
    """Return the rules that the counterweight balances the disc and that the bearings have room next to it.

    The disc must be feasible. Several discs balance each other and have no rule for a counterweight. The rule for the
    bearings is left out if the rule for the counterweight is not met.
    """
    if reducer.design.gear.discs > 1:
        return (bearing_room_rule(reducer),)
    balance_rule = counterweight_rule(reducer)
    return (balance_rule, bearing_room_rule(reducer)) if balance_rule.limit.is_met(reducer) else (balance_rule,)


def counterweight_rule(reducer: Reducer) -> Rule:
    """Return the rule that a half-disc counterweight as long as the shaft can balance disc and cam.

    Its limits are a smallest radius [m] for the present length, and a smallest length [m] for the present radius. Disc
    and shaft must be feasible, and the counterweight larger than the shaft.

    The static moments about the axis are w c (q S_gear + S_cam) < 2/3 (R^3 - r^3) L, with the eccentricity c, face
    width w, areas S, ratio q of the densities of disc and shaft, radii R and r of counterweight and shaft, and the
    shaft's length L.
    """
    shaft = reducer.design.shaft
    moment, moment_per_length = _static_moments(reducer)
    return Rule(
        "balance",
        Limit("shaft.counterweight_radius", "more than", math.cbrt(shaft.radius**3 + 1.5 * moment / shaft.length)),
        "a smaller half-disc counterweight cannot balance the disc within the length of the shaft",
        (Limit("shaft.length", "more than", moment / moment_per_length),),
    )


def bearing_room_rule(reducer: Reducer) -> Rule:
    """Return the rule that the journal is long enough for the shaft's bearings and the counterweight.

    A bearing width that the design does not set counts as 0, because it is then chosen to fit the remaining length.
    """
    design = reducer.design
    shaft = design.shaft
    moment, moment_per_length = _static_moments(reducer) if design.gear.discs == 1 else (0.0, 1.0)
    second_bearing_length = 0.0 if shaft.mounting == "straddle" else shaft.bearing_spacing or shaft.bearing_width
    return Rule(
        "bearings",
        Limit(
            "shaft.length",
            "at least",
            moment / moment_per_length + shaft.bearing_offset + shaft.bearing_width + second_bearing_length,
        ),
        "counterweight and bearings sit next to each other on the shaft"
        if design.gear.discs == 1
        else "the bearings sit next to each other on the shaft",
    )


def _static_moments(reducer: Reducer) -> tuple[float, float]:
    """Compute the static moments (mass times distance) for the counterweight, divided by the shaft's density.

    Returns
    -------
    tuple of float
        Moment of disc and cam [m4], and of the counterweight per thickness [m3].
    """
    design = reducer.design
    gear, shaft = design.gear, design.shaft
    density_ratio = design.material_of("gear").density / design.material_of("shaft").density
    weighted_area = density_ratio * reducer.disc_section + math.pi * gear.bore_radius**2
    moment = gear.face_width * gear.eccentricity * weighted_area
    return moment, 2 / 3 * (shaft.counterweight_radius**3 - shaft.radius**3)


def _hole_wall_rule(reducer: Reducer) -> Rule:
    """Return the rule (`wall_rule`) for the thickness of the wall between neighbouring output holes.

    A smaller hole alone is no remedy, because its radius depends on output-pin radius and eccentricity.
    """
    design = reducer.design
    output, output_circle_radius, E = design.output, design.output.pin_circle_radius, design.ring.pin_circle_radius
    half_pitch = output_circle_radius * math.sin(math.pi / output.pins)

    def hole_limits(relative_wall: float) -> tuple[Limit, ...]:
        """Return the limits of radius, number and circle of the output holes that leave a wall between them.

        The wall is `relative_wall` [1] times the radius of the circle of ring pins.
        """
        needed_radius = _hole_radius(reducer) + relative_wall * E / 2
        return (
            Limit("output.hole_radius", "less than", half_pitch - relative_wall * E / 2 - design.clearance.output),
            Limit("output.pins", "less than", circles_on_circle(needed_radius / output_circle_radius)),
            Limit("output.pin_circle_radius", "more than", needed_radius / math.sin(math.pi / output.pins)),
        )

    return wall_rule(
        "neighbouring_holes",
        hole_limits,
        TEETH.min_wall_share,
        E,
        "between neighbouring output holes",
        depends_on_others=True,
    )


def _check_hole_size(reducer: Reducer) -> Check:
    """Return the check that the radius of the output holes is that of an output pin plus the eccentricity.

    The centre of a pin moves in its hole on a circle whose radius is the eccentricity.
    """
    design = reducer.design
    required_radius = design.output.pin_radius + design.gear.eccentricity
    hole_radius = design.output.hole_radius
    is_passed = abs(hole_radius - required_radius) <= RELATIVE_ROUNDING * required_radius
    key, required_text = "output.hole_radius_mm", f"{MILLIMETRE.from_si(required_radius):.14g}"
    return Check(
        name="hole_size",
        passed=is_passed,
        got=f"{MILLIMETRE.from_si(hole_radius):.14g} mm",
        limit=f"{required_text} mm (output pin + eccentricity)",
        why="an output pin that orbits at the eccentricity jams in a smaller hole;"
        " a larger hole adds clearance, which is set by clearance.output_um",
        remedy="" if is_passed else f"{'raise' if hole_radius < required_radius else 'lower'} {key} to {required_text}",
        key=key,
        changes=() if is_passed else ({key: float(required_text)},),
    )


def _bore_radius(reducer: Reducer) -> float:
    """Return the radius of the disc's bore [m], with its clearance."""
    return reducer.design.gear.bore_radius + reducer.design.clearance.cam


def _hole_radius(reducer: Reducer) -> float:
    """Return the radius of an output hole as cut [m], with its clearance."""
    return reducer.design.output.hole_radius + reducer.design.clearance.output
