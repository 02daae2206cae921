"""Check of the drive around a mechanism: the rules of its joints."""

from collections.abc import Iterator

from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.checks.check import Check
from cycloid_mj.parts.export.casing import casing_or_none
from cycloid_mj.parts.export.rules import describe_violations
from cycloid_mj.parts.export.running import running_gaps
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.sockets import is_drawn

FREE_CAM_JOINTS = "key", "one_piece"
"""Joints of the cams that do not require a drive with covers."""


def casing_checks(reducer: Reducer) -> Iterator[Check]:
    """Yield the check that the drive with covers, bearings and screws meets all rules for joints, as a warning.

    It compares the smallest axial gap [mm] with the play, and its remedy lists what `describe_violations` yields.
    Nothing is yielded for a design without solids of its parts (`is_drawn`). Without fitting covers (`casing_or_none`),
    the check fails if the design has a part that needs them, such as a seal ring; otherwise nothing is yielded.
    """
    design = reducer.design
    if not is_drawn(design):
        return
    casing, reason = casing_or_none(reducer)
    if casing is None:
        shaft = design.shaft
        has_parts = shaft.bore_radius or shaft.retaining_rings or shaft.seal_ring
        is_requested = has_parts or shaft.cam_joint not in FREE_CAM_JOINTS
        if is_requested or design.output.main_bearing_seat != "hub":
            yield Check(
                name="joints",
                passed=False,
                got="not possible",
                limit="possible",
                why="a through bore, shrunk, splined or clamped cams, retaining rings, a seal ring or bearings around "
                "the output disc need covers that fit",
                remedy=reason,
                severity="warning",
                key="drive with covers",
            )
        return
    violations = tuple(describe_violations(reducer, casing))
    play = f"{MILLIMETRES * casing.play:g} mm"
    smallest_axial_gap = min(gap.distance for gap in running_gaps(reducer, casing) if gap.axial)
    yield Check(
        name="joints",
        passed=not violations,
        got=violations[0] if violations else f"axial play of discs, pins and crank of {play} at each end",
        limit=f"all rules for joints: moving parts are at least {play} apart, and every part can be assembled",
        why="covers, bearings, screws and dowels must fit, and the drive must turn with all screws tightened",
        remedy="; ".join(violations),
        severity="warning",
        key="drive with covers",
        value=MILLIMETRES * smallest_axial_gap,
        bound=MILLIMETRES * casing.play,
        unit="mm",
    )
