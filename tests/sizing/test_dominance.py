"""Small changes that improve all figures of a drive: which changes there are, and that they are recognized."""

from itertools import count

import dominance
import pytest

from cycloid_mj.design import stock
from cycloid_mj.reducer import Reducer
from cycloid_mj.sizing.requirement import Requirement
from cycloid_mj.sizing.search import first_drive


@pytest.fixture(scope="module")
def drive() -> Reducer:
    reducer = first_drive(Requirement(20, 0.06, 3.0))
    assert reducer
    return reducer


def test_one_or_two_keys_change_by_a_step_or_to_the_next_size_in_stock(drive: Reducer) -> None:
    changes = list(dominance.list_changes(drive))
    singles = {(table, key) for ((table, key, _),) in (item for item in changes if len(item) == 1)}
    assert {f"{table}.{key}" for table, key in singles} == {
        *("gear.face_width", "gear.eccentricity", "gear.bore_radius", "ring.pin_radius"),
        *("output.pin_radius", "output.core_radius", "output.roller_bearing"),
    }
    assert all(len({change[:2] for change in item}) == len(item) <= 2 for item in changes)
    values = {key: [item[0][2] for item in changes if len(item) == 1 and item[0][1] == key] for _, key in singles}
    face = drive.design.gear.face_width
    assert values["face_width"] == pytest.approx([0.9 * face, 1.1 * face])
    cores = sorted([*values["core_radius"], drive.design.output.core_radius])
    dowels = [0.5 * size for size in stock.dowel_diameters()]
    assert cores == pytest.approx(dowels[dowels.index(cores[0]) :][: len(cores)])


@pytest.fixture(scope="module")
def wide(drive: Reducer) -> Reducer:
    """Return the drive with a face width 1.1 times as large: it is heavier, and can be changed back."""
    changed = dominance.change_drive(drive, [("gear", "face_width", 1.1 * drive.design.gear.face_width)])
    assert changed
    return changed


def test_a_changed_drive_has_parts_in_stock(drive: Reducer, wide: Reducer) -> None:
    assert dominance.output_pin(wide)
    assert wide.design.output.disc_thickness < drive.design.output.disc_thickness, "for the same dowels"
    for share in (0.9, 3.0):  # the disc is narrower than the bearing of its cam, or wider than the covers allow
        assert dominance.change_drive(drive, [("gear", "face_width", share * drive.design.gear.face_width)]) is None


@pytest.mark.parametrize("is_stronger", [True, False])
def test_a_lighter_drive_dominates_only_if_it_is_stronger_too(
    wide: Reducer, is_stronger: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    narrow, wider = ((("gear", "face_width", share * wide.design.gear.face_width),) for share in (1.0 / 1.1, 1.1))
    torques = count(3.0, 0.1 if is_stronger else -0.1)
    monkeypatch.setattr(dominance, "list_changes", lambda _: [narrow, wider])
    monkeypatch.setattr(dominance, "CHEAP", {"drive_mass_kg": -1.0})
    monkeypatch.setattr(dominance, "find_jam_share", lambda _: 0.0)
    monkeypatch.setattr(dominance, "find_torques", lambda _: (next(torques), 7.0 + next(torques)))
    dominating = list(dominance.dominating_changes(wide))
    assert [changes for changes, _ in dominating] == ([narrow] if is_stronger else [])
    for _, rows in dominating:
        assert [key for key, _, _ in rows] == ["drive_mass_kg", "rated_torque_nm", "momentary_torque_nm"]
