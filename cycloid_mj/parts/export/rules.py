"""Rules that every joint of a drive has to follow, and the violations of a design."""

import math
from collections.abc import Iterator

from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.design.fits import clearances
from cycloid_mj.design.model import BEARING_CORNER
from cycloid_mj.parts.cam_bearing import cam_bearing, cam_radius
from cycloid_mj.parts.export.bearings import NEEDLE_BORE
from cycloid_mj.parts.export.casing import Casing
from cycloid_mj.parts.export.casing_rules import (
    RULES,
    is_plastic,
)
from cycloid_mj.parts.export.crank_rings import FILLETED_NECK, disc_collar_neck
from cycloid_mj.parts.export.insertion import blockages
from cycloid_mj.parts.export.joints import drive_joints
from cycloid_mj.parts.export.running import running_gaps
from cycloid_mj.reducer import Reducer


def describe_violations(reducer: Reducer, casing: Casing) -> Iterator[str]:
    """Yield a sentence with the remedy for each design rule that the joints of a drive violate.

    The rules are:

    - Between parts that move relative to each other, there is at least the axial play.
    - Each part can be moved to its place past the parts that are mounted before it.
    - Dowels centre the covers, and keep a plastic ring from turning.
    - Threads in a plastic have an insert. Pressed and turning parts have a fit.
    - Bearings reach their shoulders, and the crank has the fillets that its fatigue strength assumes.
    - Cams have little more play than the fit of their bearings.
    - A motor is not bolted to a cover that turns.
    """
    for gap in running_gaps(reducer, casing):
        if not gap.keeps(casing.play):
            yield (
                f"{gap.part} and {gap.other} move against each other but are only {MILLIMETRES * gap.distance:.3g} mm "
                f"apart; {MILLIMETRES * casing.play:g} mm are needed: please report this design"
            )
    for blockage in blockages(reducer, casing):
        yield f"{blockage.part} cannot pass {blockage.other} to its place: please report this design"
    yield from describe_missing_dowels(reducer, casing)
    for joint in drive_joints(reducer, casing):
        if joint.diameter and not joint.fit:
            yield f"{joint.name} has no fit: please report this design"
        for thread in joint.threads:
            if is_plastic(reducer) and not thread.insert:
                yield f"M{MILLIMETRES * thread.thread:g} in {thread.part}, a plastic, has no standard insert"
    fillet = reducer.design.shaft.shoulder_fillet
    if reducer.design.has_one_piece_crank and fillet > BEARING_CORNER:
        yield (
            f"the fillets of {MILLIMETRES * fillet:.3g} mm at the shoulders of the crank keep its bearings off them, "
            f"whose corners have a radius of {MILLIMETRES * BEARING_CORNER:g} mm: reduce shaft.fillet_radius_mm"
        )
    yield from _describe_short_necks(reducer, casing)
    yield from _describe_loose_cams(reducer)
    if reducer.member.ring_and_carrier(1.0)[0]:
        teeth = reducer.design.ring.teeth
        yield (
            f"the motor turns with the ring on its cover, so that it turns {teeth - 1} times for a turn of the output, "
            f"not {teeth}, and its cable winds up: hold the motor on the carrier, or choose output.member = carrier"
        )


def describe_missing_dowels(reducer: Reducer, casing: Casing) -> Iterator[str]:
    """Yield a sentence if no dowel centres the covers, or if none keeps a ring of plastic from turning."""
    if casing.dowel is None:
        yield "no dowel fits in the covers, which only the play of the screws centres: enlarge the housing"
    elif is_plastic(reducer) and casing.has_outer_dowels:
        yield "no dowel fits in the wall of the ring, which only friction keeps from turning: enlarge the housing"


def _describe_short_necks(reducer: Reducer, casing: Casing) -> Iterator[str]:
    """Yield a sentence if a crank in one piece for two discs has no room for the fillets between cams and collar."""
    gear, fillet = reducer.design.gear, reducer.design.shaft.shoulder_fillet
    if gear.discs == 1 or not reducer.design.has_one_piece_crank:
        return
    if disc_collar_neck(reducer, casing) < FILLETED_NECK * fillet:
        smallest_gap = 2.0 * FILLETED_NECK * fillet + RULES.min_wall
        yield (
            f"the gap of {MILLIMETRES * gear.disc_gap:g} mm between the discs has no room for fillets between the cams "
            f"and the collar of the crank: set gear.disc_gap_mm to at least {MILLIMETRES * smallest_gap:.2f}, or "
            "reduce shaft.fillet_radius_mm"
        )


def _describe_loose_cams(reducer: Reducer) -> Iterator[str]:
    """Yield a sentence if the cams are smaller than the bore of their bearing by more than the play of needles.

    Load ratings are valid for a cam of the nominal diameter. The limit is the largest play of a drawn cup on its shaft.
    """
    bearing, diameter = cam_bearing(reducer), 2.0 * cam_radius(reducer)
    if bearing is None:
        return
    bore = bearing[0].bore
    play = clearances(f"{NEEDLE_BORE}/h5", bore)[1]
    if diameter < bore - play:
        yield (
            f"cams of {MILLIMETRES * diameter:.4g} mm are loose in {bearing[0].designation}, which needs "
            f"{MILLIMETRES * bore:g} mm: set clearance.cam_um to at most {math.floor(0.5e6 * play)}"
        )
