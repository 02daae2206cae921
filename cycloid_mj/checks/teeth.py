"""Rules for the teeth: the path of the pins, the lobes, the sockets, and the ring around them."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from cycloid_mj.checks.limit import Limit, millimetres
from cycloid_mj.checks.rule import Rule, wall_rule
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.sockets import socket_half_angle


@dataclass(frozen=True)
class ToothLimits:
    """Assumed limits of walls and cores, and the margin to a profile with loops."""

    min_wall_share: float = 0.01
    """Assumed least wall between any two cut-outs over E: 0.4 mm of a pin circle of 40 mm."""
    loop_margin: float = 1e-6
    """Relative distance of c N from E: closer to a loop the closed forms lose their digits to rounding."""
    min_core_share: float = 1 / 3
    """Assumed least radius of the pin inside a sleeve over rho: it carries the entire force in bending."""


TEETH = ToothLimits()


WALLS = ("bore", "holes_to_bore", "holes_to_root", "neighbouring_holes", "neighbouring_pins", "housing", "sleeve")
"""Names of the checks of walls: thinner than assumed is a warning, no wall an error."""


def tooth_rules(reducer: Reducer) -> Iterator[Rule]:
    """Yield the rules for the teeth of disc and ring, in the order in which they depend on each other.

    They are, as far as they apply: no loops in the path of the pins in the disc, no undercut, walls between the
    sockets, a core pin in each sleeve, pins thicker than the eccentricity, sockets that support them, and the wall of
    the housing. With loops, undercut and support of the sockets are left out. In texts, N are the ring teeth, c is the
    eccentricity, E the pin-circle radius and rho the pin radius.
    """
    design = reducer.design
    N, c, E, rho = design.ring.teeth, design.gear.eccentricity, design.ring.pin_circle_radius, design.ring.pin_radius
    circle_shift = min(design.modification.pin_circle, 0.0)  # the disc may be generated with a smaller pin circle
    loop_rule = Rule(
        "loops",
        Limit("gear.eccentricity", "less than", (E + circle_shift) / N * (1 - TEETH.loop_margin)),
        "at c >= E / N the path of a pin in the disc has loops, and the profile crosses itself",
        (
            Limit("ring.teeth", "less than", (E + circle_shift) / c * (1 - TEETH.loop_margin)),
            Limit("ring.pin_circle_radius", "more than", N * c / (1 - TEETH.loop_margin) - circle_shift),
        ),
    )
    yield loop_rule
    has_loops = not loop_rule.limit.is_met(reducer)
    if not has_loops:
        yield _undercut_rule(reducer)
    if design.ring.kind == "pin":
        yield _pin_wall_rule(reducer)
        if design.ring.has_sleeves:
            yield _sleeve_rule(reducer)
        yield Rule(
            "socket",
            Limit("ring.pin_radius", "more than", c),
            "the tips of the disc reach out to E - rho + 2 c, and must not reach the bottoms of the sockets at E + rho",
            (Limit("gear.eccentricity", "less than", rho),),
        )
        if not has_loops and design.ring.has_sockets and c < rho and design.ring.socket == "half_open":
            yield _socket_support_rule(reducer)
    yield _housing_wall_rule(reducer)


def _undercut_rule(reducer: Reducer) -> Rule:
    """Return the rule that the profile has no undercut: the radius of curvature of the path must exceed the offset.

    The path of a pin centre in the disc is a trochoid, and the profile is offset from it by pin radius and clearance.
    The smallest convex radius of the path counts. An internal gear exists under the same condition (see
    ``geometry.envelope``). The condition also keeps the outline simple: for N >= 4 ring teeth the smallest convex
    radius is below the smallest distance of the path's tangents from the disc's centre, so that the polar angle grows
    along the entire profile.
    """
    design = reducer.design
    ring, eccentricity, offset = design.ring, design.gear.eccentricity, reducer.profile_offset
    generating_radius = design.ring.pin_circle_radius + design.modification.pin_circle

    def remaining_radius(trial_eccentricity: float) -> float:
        disc_profile = CycloidGear(ring.teeth, trial_eccentricity, generating_radius, ring.pin_radius)
        return profile.undercut_radius(disc_profile) - offset

    alternatives = (
        ()
        if remaining_radius(eccentricity) > 0
        else (Limit("gear.eccentricity", "less than", _find_decreasing_root(remaining_radius, eccentricity)),)
    )
    return Rule(
        "undercut",
        Limit("ring.pin_radius", "less than", ring.pin_radius + remaining_radius(eccentricity)),
        "pin and clearance must be smaller than the smallest convex radius of the pin's path, or they undercut lobes",
        alternatives,
    )


def _pin_wall_rule(reducer: Reducer) -> Rule:
    """Return the rule (`wall_rule`) for the thickness of the wall between the sockets of neighbouring ring pins."""
    design = reducer.design
    E, N, play = design.ring.pin_circle_radius, design.ring.teeth, design.socket_play
    socket_radius = design.ring.pin_radius + play

    def pin_limits(relative_wall: float) -> tuple[Limit, ...]:
        """Return the limits of radius, number and circle of the ring pins that leave a wall between their sockets.

        The wall is `relative_wall` [1] times the pin-circle radius.
        """
        relative_radius = math.sin(math.pi / N) - relative_wall / 2
        return (
            Limit("ring.pin_radius", "less than", E * relative_radius - play),
            Limit("ring.teeth", "less than", circles_on_circle(socket_radius / E + relative_wall / 2)),
            Limit(
                "ring.pin_circle_radius",
                "more than",
                socket_radius / relative_radius if relative_radius > 0.0 else math.inf,
            ),
        )

    return wall_rule(
        "neighbouring_pins", pin_limits, TEETH.min_wall_share, E, "between the sockets of neighbouring pins"
    )


def _sleeve_rule(reducer: Reducer) -> Rule:
    """Return the rule that the core pin in a sleeve has at least `TEETH.min_core_share` of the sleeve's radius."""
    ring, play = reducer.design.ring, reducer.design.clearance.pin_sleeve
    failure_rule = Rule(
        "sleeve", Limit("ring.sleeve_thickness", "less than", ring.pin_radius - play), "the sleeve leaves no pin inside"
    )
    return Rule(
        "sleeve",
        Limit("ring.sleeve_thickness", "at most", (1 - TEETH.min_core_share) * ring.pin_radius - play),
        f"the pin inside should have at least {TEETH.min_core_share:.0%} of the sleeve's outside diameter (assumed)",
        (Limit("ring.pin_radius", "at least", (ring.sleeve_thickness + play) / (1 - TEETH.min_core_share)),),
        severity="warning",
        failure=failure_rule,
    )


def _socket_support_rule(reducer: Reducer) -> Rule:
    """Return the rule that half-open sockets support their pins in all directions in which the disc presses them.

    The disc presses a pin outwards, at most asin(c N/E) to the side (Hsieh 2014, Eq. 7). Within that angle a loaded pin
    rests on the wall of its socket, and an unloaded pin is retained by the disc in front of it. c is the eccentricity,
    N the number of pins and E the pin-circle radius.
    """
    design = reducer.design
    N, c, E, rho = design.ring.teeth, design.gear.eccentricity, design.ring.pin_circle_radius, design.ring.pin_radius

    def remaining_angle(pin_radius: float, eccentricity: float) -> float:
        """Compute half the support angle of a socket minus the largest angle of the disc's force to the radius [rad].

        It is negative if the socket does not support its pin. `pin_radius` and `eccentricity` [m] replace those of the
        design.
        """
        changed_design = design.model_copy(
            update={
                "ring": design.ring.model_copy(update={"pin_radius": pin_radius}),
                "gear": design.gear.model_copy(update={"eccentricity": eccentricity}),
            }
        )
        return socket_half_angle(changed_design) - math.asin(min(1.0, eccentricity * N / E))

    remedies = (
        (
            Limit(
                "gear.eccentricity",
                "less than",
                _find_decreasing_root(lambda trial: remaining_angle(rho, trial), E / N),
            ),
        )
        if remaining_angle(rho, c) <= 0.0
        else ()
    )
    return Rule(
        "pin_held",
        Limit("ring.pin_radius", "more than", _find_decreasing_root(lambda radius: -remaining_angle(radius, c), E)),
        f"the disc presses pins up to {math.degrees(math.asin(c * N / E)):.4g} deg to the side, and half-open sockets "
        f"support them only to {math.degrees(socket_half_angle(design)):.4g} deg (closed sockets retain them)",
        remedies,
    )


def _housing_wall_rule(reducer: Reducer) -> Rule:
    """Return the rule (`wall_rule`) for the housing's thickness outside the sockets, or an internal gear's roots."""
    design = reducer.design
    ring, c, outer_radius = design.ring, design.gear.eccentricity, design.housing.outer_radius
    socket_radius = ring.pin_circle_radius + ring.pin_radius + design.socket_play
    root_radius = ring.pin_circle_radius - ring.pin_radius + 2 * c
    cut_radius = socket_radius if ring.kind == "pin" else root_radius
    cut_depth = cut_radius - ring.pin_circle_radius

    def housing_limits(relative_wall: float) -> tuple[Limit, ...]:
        """Return the limits for a wall of `relative_wall` [1] times the pin-circle radius outside the teeth."""
        return (
            Limit("housing.outer_radius", "more than", cut_radius + relative_wall * ring.pin_circle_radius),
            Limit("ring.pin_circle_radius", "less than", (outer_radius - cut_depth) / (1 + relative_wall)),
        )

    location = f"outside the ring's teeth (out to {millimetres(cut_radius)})"
    return wall_rule("housing", housing_limits, TEETH.min_wall_share, ring.pin_circle_radius, location)


def circles_on_circle(half_pitch_share: float) -> float:
    """Compute how many circles fit on a circle, not rounded, from half of their pitch over its radius [1]."""
    return math.pi / math.asin(min(half_pitch_share, 1.0))


def _find_decreasing_root(function: Callable[[float], float], high: float) -> float:
    """Find the root of a decreasing function in (0, `high`) by bisection, to rounding; return 0 if there is none.

    Argument and `high` have any common unit. The result is the lower end of the last interval, where the function is
    positive; if the function is positive everywhere, the result is `high` to rounding. A root below 1e-12 of `high`
    counts as none.
    """
    low, min_root = 0.0, 1e-12 * high
    while max(low, min_root) < (midpoint := (low + high) / 2) < high:
        low, high = (midpoint, high) if function(midpoint) > 0 else (low, midpoint)
    return low
