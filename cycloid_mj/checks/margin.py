"""Checks of how near the teeth are to what they must not be: the ends of K1, cusps, valleys that no tool reaches."""

import math
from collections.abc import Iterator

from cycloid_mj import envelope, profile
from cycloid_mj.checks.limit import Check, Limit, millimetres, verdict
from cycloid_mj.design import Design
from cycloid_mj.modification import gear_profile, profile_offset, tooth_profile

K1_ENDS = 0.35, 0.95
"""Assumed range of K1 = c N / E: below, teeth push the gear aside more than round; above, their bends are sharp."""

UNDERCUT_SHARE = 0.95
"""Assumed: most of the sharpest convex bend of the pins' path that pin and clearance may take."""

REACH = 10.0
"""Assumed: a cutter of radius r reaches 10 r deep, five of its diameters."""


def margin_checks(design: Design) -> Iterator[Check]:
    """Check the margins of sound teeth; all are warnings."""
    yield _short_width(design)
    yield _undercut_margin(design)
    yield _gear_tool(design)
    if design.ring.kind == "nonpin":
        yield _ring_tool(design)


def _short_width(design: Design) -> Check:
    """Check the short-width coefficient K1 = c N / E, the eccentricity as a share of what makes loops."""
    N, E = design.ring.teeth, design.ring.pin_circle_radius
    low, high = K1_ENDS
    above = Limit("gear.eccentricity", "at least", low * E / N)
    limit = Limit(above.key, "at most", high * E / N) if above.holds(design) else above
    return verdict(
        design,
        "short_width",
        limit,
        f"K1 = c N / E, here {design.gear.eccentricity * N / E:.3g}, is to lie from {low:g} to {high:g} (assumed):"
        " below, the teeth push the gear aside more than round; above, their bends are sharp",
        severity="warning",
    )


def _undercut_margin(design: Design) -> Check:
    bend, offset = profile.undercut_radius(gear_profile(design)), profile_offset(design)
    radius = design.ring.pin_radius
    return verdict(
        design,
        "undercut_margin",
        Limit("ring.pin_radius", "at most", radius - offset + UNDERCUT_SHARE * bend),
        f"the sharpest convex bend left on the lobes has a radius of {millimetres(bend - offset)}; it is to keep"
        f" {1 - UNDERCUT_SHARE:.0%} of that of the pins' path, {millimetres(bend)} (assumed), or its edge wears",
        severity="warning",
    )


def _gear_tool(design: Design) -> Check:
    """Check the radius of the gear's valley: a cutter must be smaller, and reach through the face width."""
    radius = -1.0 / float(profile.curvature(gear_profile(design), 0.0, profile_offset(design)))
    return _tool(design, "gear_tool", radius if radius > 0.0 else math.inf, "valleys of the gear")


def _ring_tool(design: Design) -> Check:
    return _tool(design, "ring_tool", envelope.tightest_radius(tooth_profile(design)), "roots of the internal gear")


def _tool(design: Design, name: str, radius: float, where: str) -> Check:
    return verdict(
        design,
        name,
        Limit("gear.face_width", "at most", REACH * radius),
        f"the {where} have a radius of {millimetres(radius)}, the largest of a cutter, and one reaches"
        f" {REACH / 2:g} diameters deep (assumed); a wire or a broach cuts deeper",
        severity="warning",
    )
