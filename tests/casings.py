"""Checks of a casing that several tests of drives share."""

import pytest

from cycloid_mj.parts.export import Casing, bill
from cycloid_mj.parts.export.bill import BillLine
from cycloid_mj.parts.export.drive import drive_mass
from cycloid_mj.parts.export.rules import describe_violations
from cycloid_mj.reducer import Reducer


def check_casing(reducer: Reducer, sizes: Casing) -> tuple[BillLine, ...]:
    """Assert that no parts interfere and that the bill has the mass of the drive; return the bill."""
    assert list(describe_violations(reducer, sizes)) == []
    lines = bill(reducer, 0.0, sizes)
    masses = sum(line.mass_kg for line in lines if line.made_or_bought != "consumable")
    assert masses == pytest.approx(drive_mass(reducer), rel=0.01)
    return lines
