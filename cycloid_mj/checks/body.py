"""Checks of the gear's body: its bore, the output holes, the walls between them, and its balance."""

import math
from collections.abc import Iterator

from cycloid_mj.checks.limit import Check, Demand, Limit, millimetres, wall_rule
from cycloid_mj.checks.teeth import WALL_SHARE, pitches
from cycloid_mj.design.units import MILLIMETRE
from cycloid_mj.reducer import Reducer

HOLE_TOLERANCE = 1e-9
"""Relative; lets a hole of output pin + eccentricity pass in spite of rounding, and nothing else."""


def body_rules(reducer: Reducer) -> Iterator[Demand | Check]:
    """State the rules of bore and holes of the gear."""
    design = reducer.design
    circle, cam = design.output.pin_circle_radius, design.clearance.cam
    E, rho, bore, hole = design.ring.pin_circle_radius, design.ring.pin_radius, _bore(reducer), _hole(reducer)
    below_root = design.gear.eccentricity + reducer.profile_offset - design.modification.pin_circle
    root = E - below_root
    root_text = f"the root of the lobes (radius {millimetres(root)})"

    def beside_bore(wall: float) -> tuple[Limit, ...]:
        return (
            Limit("gear.bore_radius", "less than", root - wall * E - cam),
            Limit("ring.pin_circle_radius", "more than", (bore + below_root) / (1 - wall)),
            Limit("ring.pin_radius", "less than", root - wall * E - bore + rho),
        )

    def bore_to_holes(wall: float) -> tuple[Limit, ...]:
        return (
            Limit("gear.bore_radius", "less than", circle - hole - wall * E - cam),
            Limit("output.pin_circle_radius", "more than", bore + wall * E + hole),
        )

    def holes_to_root(wall: float) -> tuple[Limit, ...]:
        return (
            Limit("output.pin_circle_radius", "less than", root - wall * E - hole),
            Limit("ring.pin_circle_radius", "more than", (circle + hole + below_root) / (1 - wall)),
        )

    yield wall_rule("bore", beside_bore, WALL_SHARE, E, f"between the bore and {root_text}")
    yield wall_rule("holes_to_bore", bore_to_holes, WALL_SHARE, E, "between the bore and the output holes")
    yield wall_rule("holes_to_root", holes_to_root, WALL_SHARE, E, f"between the output holes and {root_text}")
    yield _neighbouring_holes(reducer)
    yield _hole_size(reducer)


def whole_rules(reducer: Reducer) -> tuple[Demand, ...]:
    """State what a sound gear can be checked for: bearings stand beside a counterweight that balances it.

    Several discs balance each other, and need none.
    """
    if reducer.design.gear.discs > 1:
        return (bearings(reducer),)
    balanced = balance(reducer)
    return (balanced, bearings(reducer)) if balanced.limit.holds(reducer) else (balanced,)


def balance(reducer: Reducer) -> Demand:
    """State that a half disc, at most as thick as the shaft is long, balances gear and cam.

    Needs a sound gear and a counterweight that stands out from the shaft.

    Static moments about the axis: w c (q S_gear + S_cam) < 2/3 (R^3 - r^3) L with the face width w, areas S, the gear's
    density over the shaft's q, radii R and r of counterweight and shaft, and the shaft's length L.
    """
    shaft = reducer.design.shaft
    moment, moment_per_length = _static_moments(reducer)
    return Demand(
        "balance",
        Limit("shaft.counterweight_radius", "more than", math.cbrt(shaft.radius**3 + 1.5 * moment / shaft.length)),
        "a smaller half-disc counterweight cannot balance the gear within the length of the shaft",
        (Limit("shaft.length", "more than", moment / moment_per_length),),
    )


def bearings(reducer: Reducer) -> Demand:
    """State that the bearings of the shaft find room on its journal, before the counterweight that balances it.

    Bearings whose width or spacing follows a rule take the room that there is.
    """
    design = reducer.design
    shaft = design.shaft
    moment, moment_per_length = _static_moments(reducer) if design.gear.discs == 1 else (0.0, 1.0)
    beside = 0.0 if shaft.mounting == "straddle" else shaft.bearing_spacing or shaft.bearing_width
    return Demand(
        "bearings",
        Limit(
            "shaft.length", "at least", moment / moment_per_length + shaft.bearing_offset + shaft.bearing_width + beside
        ),
        "counterweight and bearings stand on the shaft one beside the other"
        if design.gear.discs == 1
        else "the bearings stand on the shaft one beside the other",
    )


def _static_moments(reducer: Reducer) -> tuple[float, float]:
    """Compute the static moment of gear and cam [m4], and that of the counterweight per thickness [m3].

    Both over the shaft's density.
    """
    design = reducer.design
    gear, shaft = design.gear, design.shaft
    lighter = design.material_of("gear").density / design.material_of("shaft").density
    area = lighter * reducer.disc_section + math.pi * gear.bore_radius**2
    moment = gear.face_width * gear.eccentricity * area
    return moment, 2 / 3 * (shaft.counterweight_radius**3 - shaft.radius**3)


def _neighbouring_holes(reducer: Reducer) -> Demand:
    """State the wall between holes as a rule; their radius follows from pin and eccentricity: others are remedies."""
    design = reducer.design
    output, circle, E = design.output, design.output.pin_circle_radius, design.ring.pin_circle_radius
    half_pitch = circle * math.sin(math.pi / output.pins)

    def limits(wall: float) -> tuple[Limit, ...]:
        taken = _hole(reducer) + wall * E / 2
        return (
            Limit("output.hole_radius", "less than", half_pitch - wall * E / 2 - design.clearance.output),
            Limit("output.pins", "less than", pitches(taken / circle)),
            Limit("output.pin_circle_radius", "more than", taken / math.sin(math.pi / output.pins)),
        )

    return wall_rule("neighbouring_holes", limits, WALL_SHARE, E, "between neighbouring output holes", tied=True)


def _hole_size(reducer: Reducer) -> Check:
    """Check that a hole is exactly as large as its pin's orbit: the one limit from both sides."""
    design = reducer.design
    orbit = design.output.pin_radius + design.gear.eccentricity
    hole = design.output.hole_radius
    passed = abs(hole - orbit) <= HOLE_TOLERANCE * orbit
    key, number = "output.hole_radius_mm", f"{MILLIMETRE.from_si(orbit):.14g}"
    return Check(
        name="hole_size",
        passed=passed,
        got=f"{MILLIMETRE.from_si(hole):.14g} mm",
        limit=f"{number} mm (output pin + eccentricity)",
        why="an output pin, orbiting at the eccentricity, jams in a smaller hole;"
        " a larger one adds play, which belongs to clearance.output_um",
        remedy="" if passed else f"{'raise' if hole < orbit else 'lower'} {key} to {number}",
        key=key,
        changes=() if passed else ({key: float(number)},),
    )


def _bore(reducer: Reducer) -> float:
    """Radius of the gear's bore [m]: the cam and its clearance."""
    return reducer.design.gear.bore_radius + reducer.design.clearance.cam


def _hole(reducer: Reducer) -> float:
    """Radius of a hole as it is cut [m], with its clearance."""
    return reducer.design.output.hole_radius + reducer.design.clearance.output
