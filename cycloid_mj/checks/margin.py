"""Rules for the margins of the teeth: the range of K1, undercut, valleys that a tool can cut."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from cycloid_mj.checks.limit import Limit, millimetres
from cycloid_mj.checks.rule import Rule
from cycloid_mj.geometry import envelope, profile
from cycloid_mj.reducer import Reducer


@dataclass(frozen=True)
class MarginLimits:
    """Assumed limits of the margins of teeth."""

    k1_range: tuple[float, float] = (0.35, 0.95)
    """Assumed range of K1 = c N / E: below, tooth forces are mostly radial; above, the lobes are sharply curved."""
    max_undercut_share: float = 0.95
    """Assumed largest share of the smallest convex radius of the pins' path that pin and clearance may use."""
    cutter_reach: float = 10.0
    """Assumed cutting depth of a cutter over its radius: five diameters."""


MARGINS = MarginLimits()


def margin_rules(reducer: Reducer) -> Iterator[Rule]:
    """Yield the rules for the margins of feasible teeth; all are warnings."""
    yield _short_width_rule(reducer)
    yield _undercut_margin_rule(reducer)
    yield _gear_cutter_rule(reducer)
    if reducer.design.ring.kind == "nonpin":
        yield _ring_cutter_rule(reducer)


def _short_width_rule(reducer: Reducer) -> Rule:
    """Return the rule that the short-width coefficient K1 = c N / E is within the usual range `MARGINS.k1_range`.

    c is the eccentricity, N the number of ring teeth, and E the pin-circle radius; at K1 = 1 the path of a pin centre
    in the disc begins to have loops.
    """
    design = reducer.design
    N, E = design.ring.teeth, design.ring.pin_circle_radius
    min_k1, max_k1 = MARGINS.k1_range
    lower_limit = Limit("gear.eccentricity", "at least", min_k1 * E / N)
    limit = Limit(lower_limit.key, "at most", max_k1 * E / N) if lower_limit.is_met(reducer) else lower_limit
    return Rule(
        "short_width",
        limit,
        f"K1 = c N / E, here {design.gear.eccentricity * N / E:.3g}, should be {min_k1:g} to {max_k1:g} (assumed):"
        " below, the tooth forces are mostly radial; above, the lobes are sharply curved",
        severity="warning",
    )


def _undercut_margin_rule(reducer: Reducer) -> Rule:
    """Return the rule that the flank's offset is at most a share of the radius of curvature of the pins' path.

    The flank is the path of the pin centres, offset by pin radius, clearance and modification. At the sharpest convex
    point of the path, the offset must be at most `MARGINS.max_undercut_share` of the radius of curvature.
    """
    path_radius, offset = profile.undercut_radius(reducer.gear_profile), reducer.profile_offset
    pin_radius = reducer.design.ring.pin_radius
    return Rule(
        "undercut_margin",
        Limit("ring.pin_radius", "at most", pin_radius - offset + MARGINS.max_undercut_share * path_radius),
        f"the smallest convex radius of the lobes is {millimetres(path_radius - offset)}; it should be at least"
        f" {1 - MARGINS.max_undercut_share:.0%} of that of the pins' path, {millimetres(path_radius)} (assumed), or the"
        " edge wears",
        severity="warning",
    )


def _gear_cutter_rule(reducer: Reducer) -> Rule:
    """Return the rule that a cutter that fits into the disc's valleys reaches through the face width."""
    radius = -1.0 / float(profile.curvature(reducer.gear_profile, 0.0, reducer.profile_offset))
    return _cutter_rule("gear_tool", radius if radius > 0.0 else math.inf, "valleys of the disc")


def _ring_cutter_rule(reducer: Reducer) -> Rule:
    """Return the rule that a cutter that fits into the roots of the internal gear reaches through the face width."""
    return _cutter_rule("ring_tool", envelope.tightest_radius(reducer.tooth_profile), "roots of the internal gear")


def _cutter_rule(name: str, radius: float, location: str) -> Rule:
    """Return the rule that a milling cutter as small as a concave radius [m] is long enough for the face width.

    `name` is the name of the rule, `location` the cut feature in words, such as "valleys of the lobes".
    """
    return Rule(
        name,
        Limit("gear.face_width", "at most", MARGINS.cutter_reach * radius),
        f"the {location} have a radius of {millimetres(radius)}, which limits the radius of a cutter, and a cutter "
        f"reaches {MARGINS.cutter_reach / 2:g} diameters deep (assumed); wire erosion or broaching cuts deeper",
        severity="warning",
    )
