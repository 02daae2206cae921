"""Checks of the teeth: the path of the pins, the lobes, the sockets, the ring around them."""

import math
from collections.abc import Callable, Iterator

from cycloid_mj import profile
from cycloid_mj.checks.limit import Check, Limit, millimetres, verdict
from cycloid_mj.design import Design
from cycloid_mj.modification import profile_offset
from cycloid_mj.profile import CycloidGear

WALL_SHARE = 0.01
"""Assumed: least wall between any two cut-outs, as a share of E (0.4 mm on the paper's gear)."""

LOOP_MARGIN = 1e-6
"""Relative distance that c N keeps from E, since closer to a loop the closed forms drown in rounding."""

LEAST_CORE = 1 / 3
"""Assumed: least radius of the pin inside a sleeve, as a share of rho: it carries all of the force in bending."""

BISECTIONS = 60


def tooth_checks(design: Design) -> Iterator[Check]:
    """Check the teeth of gear and ring."""
    N, c, E, rho = design.ring.teeth, design.gear.eccentricity, design.ring.pin_circle_radius, design.ring.pin_radius
    smaller = min(design.modification.pin_circle, 0.0)  # the gear may be generated with a smaller pin circle
    loops = verdict(
        design,
        "loops",
        Limit("gear.eccentricity", "less than", (E + smaller) / N * (1 - LOOP_MARGIN)),
        "from E / N on the path of a pin in the gear has loops, which no gear can follow",
        Limit("ring.teeth", "less than", (E + smaller) / c * (1 - LOOP_MARGIN)),
        Limit("ring.pin_circle_radius", "more than", N * c / (1 - LOOP_MARGIN) - smaller),
    )
    yield loops
    if loops.passed:
        yield _undercut(design)
    if design.ring.kind == "pin":
        yield _neighbouring_pins(design)
        if design.ring.has_sleeves:
            yield _sleeve(design)
        yield verdict(
            design,
            "socket",
            Limit("ring.pin_radius", "more than", c),
            "the gear's tips sweep out to E - rho + 2 c, which must not reach the bottoms of the sockets at E + rho",
            Limit("gear.eccentricity", "less than", rho),
        )
    yield _housing(design)


def wall(design: Design) -> float:
    """Give the least wall [m]."""
    return WALL_SHARE * design.ring.pin_circle_radius


def wall_needed(design: Design, where: str) -> str:
    """Say where a wall is needed, and how thick."""
    return f"{where} a wall of at least {millimetres(wall(design))} is needed ({WALL_SHARE:.0%} of E, assumed)"


def _undercut(design: Design) -> Check:
    """Check that the profile has no cusps.

    It is also all that the internal gear needs to exist (see `envelope`), and it keeps the outline simple: for N >= 4
    the least convex radius of the path is below the least distance of its tangents from the gear's centre, so that the
    polar angle of the profile grows all the way round.
    """
    ring, c, offset = design.ring, design.gear.eccentricity, profile_offset(design)
    generating = design.ring.pin_circle_radius + design.modification.pin_circle

    def spare(eccentricity: float) -> float:
        gear = CycloidGear(ring.teeth, eccentricity, generating, ring.pin_radius)
        return profile.undercut_radius(gear) - offset

    flatter = [] if spare(c) > 0 else [Limit("gear.eccentricity", "less than", _falling_root(spare, c))]
    return verdict(
        design,
        "undercut",
        Limit("ring.pin_radius", "less than", ring.pin_radius + spare(c)),
        "a pin that is larger, with its clearance, than the sharpest convex bend of its path cuts the lobes away",
        *flatter,
    )


def _neighbouring_pins(design: Design) -> Check:
    E, N, play = design.ring.pin_circle_radius, design.ring.teeth, design.socket_play
    socket = design.ring.pin_radius + play
    room = math.sin(math.pi / N) - WALL_SHARE / 2
    return verdict(
        design,
        "neighbouring_pins",
        Limit("ring.pin_radius", "less than", E * room - play),
        wall_needed(design, "between the sockets of neighbouring pins"),
        Limit("ring.teeth", "less than", pitches(socket / E + WALL_SHARE / 2)),
        Limit("ring.pin_circle_radius", "more than", socket / room),
    )


def _sleeve(design: Design) -> Check:
    """Check that a sleeve leaves a pin that can hold it: at least a third of rho (assumed)."""
    ring = design.ring
    room = (1 - LEAST_CORE) * ring.pin_radius - design.clearance.pin_sleeve
    return verdict(
        design,
        "sleeve",
        Limit("ring.sleeve_thickness", "at most", room),
        f"the pin inside the sleeve is to be at least {LEAST_CORE:.0%} as thick as the sleeve is outside (assumed)",
        Limit("ring.pin_radius", "at least", (ring.sleeve_thickness + design.clearance.pin_sleeve) / (1 - LEAST_CORE)),
    )


def _housing(design: Design) -> Check:
    ring, c = design.ring, design.gear.eccentricity
    sockets = ring.pin_circle_radius + ring.pin_radius + design.socket_play
    root = ring.pin_circle_radius - ring.pin_radius + 2 * c
    outermost = sockets if ring.kind == "pin" else root
    return verdict(
        design,
        "housing",
        Limit("housing.outer_radius", "more than", outermost + wall(design)),
        wall_needed(design, f"outside the ring's teeth (out to {millimetres(outermost)})"),
        Limit(
            "ring.pin_circle_radius",
            "less than",
            (design.housing.outer_radius - (outermost - ring.pin_circle_radius)) / (1 + WALL_SHARE),
        ),
    )


def pitches(half_pitch_share: float) -> float:
    """Give how many circles fit on a circle, from the half of their pitch as a share of its radius."""
    return math.pi / math.asin(min(half_pitch_share, 1.0))


def _falling_root(function: Callable[[float], float], high: float) -> float:
    """Give the root of a falling function between 0 and `high`, where it is negative; 0 if there is none."""
    low = 0.0
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        low, high = (middle, high) if function(middle) > 0 else (low, middle)
    return low
