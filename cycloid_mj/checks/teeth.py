"""Checks of the teeth: the path of the pins, the lobes, the sockets, the ring around them."""

import math
from collections.abc import Callable, Iterator

from cycloid_mj.checks.limit import Demand, Limit, millimetres, wall_rule
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.sockets import socket_half_angle

WALL_SHARE = 0.01
"""Assumed: least wall between any two cut-outs, as a share of E (0.4 mm on the paper's gear)."""

LOOP_MARGIN = 1e-6
"""Relative distance that c N keeps from E, since closer to a loop the closed forms drown in rounding."""

WALLS = ("bore", "holes_to_bore", "holes_to_root", "neighbouring_holes", "neighbouring_pins", "housing", "sleeve")
"""Checks whose limit is a wall: one that is thinner than is assumed is a warning, one that is not there an error."""

LEAST_CORE = 1 / 3
"""Assumed: least radius of the pin inside a sleeve, as a share of rho: it carries all of the force in bending."""

BISECTIONS = 60


def tooth_rules(reducer: Reducer) -> Iterator[Demand]:
    """State the rules of the teeth of gear and ring."""
    design = reducer.design
    N, c, E, rho = design.ring.teeth, design.gear.eccentricity, design.ring.pin_circle_radius, design.ring.pin_radius
    smaller = min(design.modification.pin_circle, 0.0)  # the gear may be generated with a smaller pin circle
    loops = Demand(
        "loops",
        Limit("gear.eccentricity", "less than", (E + smaller) / N * (1 - LOOP_MARGIN)),
        "from E / N on the path of a pin in the gear has loops, which no gear can follow",
        (
            Limit("ring.teeth", "less than", (E + smaller) / c * (1 - LOOP_MARGIN)),
            Limit("ring.pin_circle_radius", "more than", N * c / (1 - LOOP_MARGIN) - smaller),
        ),
    )
    yield loops
    looped = not loops.limit.holds(reducer)
    if not looped:
        yield _undercut(reducer)
    if design.ring.kind == "pin":
        yield _neighbouring_pins(reducer)
        if design.ring.has_sleeves:
            yield _sleeve(reducer)
        yield Demand(
            "socket",
            Limit("ring.pin_radius", "more than", c),
            "the gear's tips sweep out to E - rho + 2 c, which must not reach the bottoms of the sockets at E + rho",
            (Limit("gear.eccentricity", "less than", rho),),
        )
        if not looped and design.ring.has_sockets and c < rho and design.ring.socket == "half_open":
            yield _sockets_hold(reducer)
    yield _housing(reducer)


def _undercut(reducer: Reducer) -> Demand:
    """State that the profile has no cusps.

    It is also all that the internal gear needs to exist (see `envelope`), and it keeps the outline simple: for N >= 4
    the least convex radius of the path is below the least distance of its tangents from the gear's centre, so that the
    polar angle of the profile grows all the way round.
    """
    design = reducer.design
    ring, c, offset = design.ring, design.gear.eccentricity, reducer.profile_offset
    generating = design.ring.pin_circle_radius + design.modification.pin_circle

    def spare(eccentricity: float) -> float:
        gear = CycloidGear(ring.teeth, eccentricity, generating, ring.pin_radius)
        return profile.undercut_radius(gear) - offset

    flatter = () if spare(c) > 0 else (Limit("gear.eccentricity", "less than", _falling_root(spare, c)),)
    return Demand(
        "undercut",
        Limit("ring.pin_radius", "less than", ring.pin_radius + spare(c)),
        "a pin that is larger, with its clearance, than the sharpest convex bend of its path cuts the lobes away",
        flatter,
    )


def _neighbouring_pins(reducer: Reducer) -> Demand:
    design = reducer.design
    E, N, play = design.ring.pin_circle_radius, design.ring.teeth, design.socket_play
    socket = design.ring.pin_radius + play

    def limits(wall: float) -> tuple[Limit, ...]:
        room = math.sin(math.pi / N) - wall / 2
        return (
            Limit("ring.pin_radius", "less than", E * room - play),
            Limit("ring.teeth", "less than", pitches(socket / E + wall / 2)),
            Limit("ring.pin_circle_radius", "more than", socket / room if room > 0.0 else math.inf),
        )

    return wall_rule("neighbouring_pins", limits, WALL_SHARE, E, "between the sockets of neighbouring pins")


def _sleeve(reducer: Reducer) -> Demand:
    """State that a sleeve leaves a pin, and one that can hold it: at least a third of rho (assumed)."""
    ring, play = reducer.design.ring, reducer.design.clearance.pin_sleeve
    none_left = Demand(
        "sleeve", Limit("ring.sleeve_thickness", "less than", ring.pin_radius - play), "the sleeve leaves no pin inside"
    )
    return Demand(
        "sleeve",
        Limit("ring.sleeve_thickness", "at most", (1 - LEAST_CORE) * ring.pin_radius - play),
        f"the pin inside the sleeve is to be at least {LEAST_CORE:.0%} as thick as the sleeve is outside (assumed)",
        (Limit("ring.pin_radius", "at least", (ring.sleeve_thickness + play) / (1 - LEAST_CORE)),),
        severity="warning",
        first=none_left,
    )


def _sockets_hold(reducer: Reducer) -> Demand:
    """State that sockets reach round their pins as far as the gear presses on these.

    It presses a pin outwards, up to asin(c N/E) aside (Hsieh 2014, Eq. 7). Where that is within the socket the pin
    stays in: pressed it lies on the socket's wall, and idle the gear in front of it holds it back.
    """
    design = reducer.design
    N, c, E, rho = design.ring.teeth, design.gear.eccentricity, design.ring.pin_circle_radius, design.ring.pin_radius

    def spare(pin_radius: float, eccentricity: float) -> float:
        changed = design.model_copy(
            update={
                "ring": design.ring.model_copy(update={"pin_radius": pin_radius}),
                "gear": design.gear.model_copy(update={"eccentricity": eccentricity}),
            }
        )
        return socket_half_angle(changed) - math.asin(min(1.0, eccentricity * N / E))

    return Demand(
        "pin_held",
        Limit("ring.pin_radius", "more than", _falling_root(lambda radius: -spare(radius, c), E)),
        f"the gear presses pins up to {math.degrees(math.asin(c * N / E)):.4g} deg aside, and a half-open socket that "
        f"holds them to {math.degrees(socket_half_angle(design)):.4g} deg lets them out (closed ones hold them)",
        (Limit("gear.eccentricity", "less than", _falling_root(lambda aside: spare(rho, aside), E / N)),),
    )


def _housing(reducer: Reducer) -> Demand:
    design = reducer.design
    ring, c, outer = design.ring, design.gear.eccentricity, design.housing.outer_radius
    sockets = ring.pin_circle_radius + ring.pin_radius + design.socket_play
    root = ring.pin_circle_radius - ring.pin_radius + 2 * c
    outermost = sockets if ring.kind == "pin" else root
    beyond = outermost - ring.pin_circle_radius

    def limits(wall: float) -> tuple[Limit, ...]:
        return (
            Limit("housing.outer_radius", "more than", outermost + wall * ring.pin_circle_radius),
            Limit("ring.pin_circle_radius", "less than", (outer - beyond) / (1 + wall)),
        )

    where = f"outside the ring's teeth (out to {millimetres(outermost)})"
    return wall_rule("housing", limits, WALL_SHARE, ring.pin_circle_radius, where)


def pitches(half_pitch_share: float) -> float:
    """Compute how many circles fit on a circle, from the half of their pitch as a share of its radius."""
    return math.pi / math.asin(min(half_pitch_share, 1.0))


def _falling_root(function: Callable[[float], float], high: float) -> float:
    """Compute the root of a falling function between 0 and `high`, where it is negative; 0 if there is none."""
    low = 0.0
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        low, high = (middle, high) if function(middle) > 0 else (low, middle)
    return low
