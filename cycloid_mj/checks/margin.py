"""Checks of how near the teeth are to what they must not be: the ends of K1, cusps, valleys that no tool reaches."""

import math
from collections.abc import Iterator

from cycloid_mj.checks.limit import Demand, Limit, millimetres
from cycloid_mj.geometry import envelope, profile
from cycloid_mj.reducer import Reducer

K1_ENDS = 0.35, 0.95
"""Assumed range of K1 = c N / E: below, teeth push the gear aside more than round; above, their bends are sharp."""

UNDERCUT_SHARE = 0.95
"""Assumed: most of the sharpest convex bend of the pins' path that pin and clearance may take."""

REACH = 10.0
"""Assumed: a cutter of radius r reaches 10 r deep, five of its diameters."""


def margin_rules(reducer: Reducer) -> Iterator[Demand]:
    """State the margins of sound teeth; all are warnings."""
    yield _short_width(reducer)
    yield _undercut_margin(reducer)
    yield _gear_tool(reducer)
    if reducer.design.ring.kind == "nonpin":
        yield _ring_tool(reducer)


def _short_width(reducer: Reducer) -> Demand:
    """State the rule of the short-width coefficient K1 = c N / E, the eccentricity as a share of what makes loops."""
    design = reducer.design
    N, E = design.ring.teeth, design.ring.pin_circle_radius
    low, high = K1_ENDS
    above = Limit("gear.eccentricity", "at least", low * E / N)
    limit = Limit(above.key, "at most", high * E / N) if above.holds(reducer) else above
    return Demand(
        "short_width",
        limit,
        f"K1 = c N / E, here {design.gear.eccentricity * N / E:.3g}, is to lie from {low:g} to {high:g} (assumed):"
        " below, the teeth push the gear aside more than round; above, their bends are sharp",
        severity="warning",
    )


def _undercut_margin(reducer: Reducer) -> Demand:
    bend, offset = profile.undercut_radius(reducer.gear_profile), reducer.profile_offset
    radius = reducer.design.ring.pin_radius
    return Demand(
        "undercut_margin",
        Limit("ring.pin_radius", "at most", radius - offset + UNDERCUT_SHARE * bend),
        f"the sharpest convex bend left on the lobes has a radius of {millimetres(bend - offset)}; it is to keep"
        f" {1 - UNDERCUT_SHARE:.0%} of that of the pins' path, {millimetres(bend)} (assumed), or its edge wears",
        severity="warning",
    )


def _gear_tool(reducer: Reducer) -> Demand:
    """State the rule of the gear's valley: a cutter must be smaller, and reach through the face width."""
    radius = -1.0 / float(profile.curvature(reducer.gear_profile, 0.0, reducer.profile_offset))
    return _tool(reducer, "gear_tool", radius if radius > 0.0 else math.inf, "valleys of the gear")


def _ring_tool(reducer: Reducer) -> Demand:
    return _tool(reducer, "ring_tool", envelope.tightest_radius(reducer.tooth_profile), "roots of the internal gear")


def _tool(reducer: Reducer, name: str, radius: float, where: str) -> Demand:
    return Demand(
        name,
        Limit("gear.face_width", "at most", REACH * radius),
        f"the {where} have a radius of {millimetres(radius)}, the largest of a cutter, and one reaches"
        f" {REACH / 2:g} diameters deep (assumed); a wire or a broach cuts deeper",
        severity="warning",
    )
