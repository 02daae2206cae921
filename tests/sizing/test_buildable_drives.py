"""Candidates of a search: printed drives follow all rules for joints, and their output pins are in stock."""

import numpy as np
import pytest

from cycloid_mj.parts.export import casing
from cycloid_mj.parts.export.bearings import output_pin
from cycloid_mj.parts.export.rules import describe_violations
from cycloid_mj.reducer import Reducer
from cycloid_mj.sizing.candidates import build_drive, decode
from cycloid_mj.sizing.requirement import Requirement

SMALL = Requirement(ratio=15, diameter=70e-3, torque=1.5, process="printed")


def drives(requirement: Requirement, count: int) -> list[Reducer]:
    points = np.random.default_rng(0).random((count, 9))
    _, sizes = decode(requirement, points)
    built = (build_drive(requirement, row, requirement.torque) for row in sizes)
    return [drive for drive in built if drive]


@pytest.fixture(scope="module")
def printed() -> list[Reducer]:
    return drives(SMALL, 400)


def test_printed_drives_follow_all_rules_for_joints(printed: list[Reducer]) -> None:
    """Dowels keep rings from turning whose screws are outside of them, and threads for the load do not overlap."""
    assert any(casing(drive).screws.outside for drive in printed)
    assert {casing(drive).flange_screws for drive in printed} >= {4, 6}
    for drive in printed:
        assert list(describe_violations(drive, casing(drive))) == []


def test_output_pins_of_printed_drives_have_needles_or_sleeves_or_are_dowels_alone(printed: list[Reducer]) -> None:
    kinds = {(drive.design.output.rollers, drive.design.output.has_needles) for drive in printed}
    assert kinds == {(True, True), (True, False), (False, False)}
    for drive in (drive for drive in printed if not drive.design.output.rollers):
        pin = output_pin(drive)
        assert pin
        assert pin.designation.startswith("ISO 8734")
        assert pin.diameter == pytest.approx(2.0 * drive.design.output.pin_radius)
        assert drive.design.output.hole_radius == pytest.approx(pin.diameter / 2 + drive.design.gear.eccentricity)


def test_discs_of_metal_have_rollers() -> None:
    found = drives(Requirement(ratio=15, diameter=70e-3, torque=4.0), 60)
    assert found
    assert all(drive.design.output.rollers for drive in found)
