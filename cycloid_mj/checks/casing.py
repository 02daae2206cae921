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

    It compares the smallest axial gap between moving parts [mm] with the axial play of the drive (`Casing.play`), and
    its remedy lists the violated rules (`describe_violations`). Nothing is yielded for a design without solids of its
    parts (`is_drawn`). Without fitting covers (`casing_or_none`), the check fails if the design has a part that needs
    them, such as a seal ring; otherwise nothing is yielded.
    """
    design = reducer.design
    if not is_drawn(design):
        return
    drive_casing, reason = casing_or_none(reducer)
    if drive_casing is None:
        shaft = design.shaft
        needs_covers = shaft.bore_radius or shaft.retaining_rings or shaft.seal_ring
        is_requested = needs_covers or shaft.cam_joint not in FREE_CAM_JOINTS
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
    violations = tuple(describe_violations(reducer, drive_casing))
    play_text = f"{MILLIMETRES * drive_casing.play:g} mm"
    smallest_axial_gap = min(gap.distance for gap in running_gaps(reducer, drive_casing) if gap.axial)
    yield Check(
        name="joints",
        passed=not violations,
        got=violations[0] if violations else f"axial play of discs, pins and crank of {play_text} at each end",
        limit=f"all rules for joints: moving parts are at least {play_text} apart, and every part can be assembled",
        why="covers, bearings, screws and dowels must fit, and the drive must turn with all screws tightened",
        remedy="; ".join(violations),
        severity="warning",
        key="drive with covers",
        value=MILLIMETRES * smallest_axial_gap,
        bound=MILLIMETRES * drive_casing.play,
        unit="mm",
    )
