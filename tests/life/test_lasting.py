"""Hard surfaces, plastics that take a set, and the checks that sum a rating up."""

import pytest

from cycloid_mj.design import PRESETS, override
from cycloid_mj.design.materials import SHAKEDOWN_PRESSURE, YIELD_PRESSURE
from cycloid_mj.life import rate
from cycloid_mj.life.duty import steady
from cycloid_mj.life.give import CamGive, Give
from cycloid_mj.life.lasting import checks_of, lasting_checks, lasting_ways
from cycloid_mj.life.rated import rated_torque
from cycloid_mj.life.surfaces import set_hours
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.sheet import sheet

PIN = PRESETS["pin"]


def test_a_hard_surface_bears_more_and_the_core_as_much_as_before() -> None:
    soft = PIN.but(material={"name": "tempered steel"})
    hard = PIN.but(material={"name": "case-hardened 16MnCr5"})
    before, after = rate(soft).items, rate(hard).items
    assert before["pin_gear_pitting"].limit == pytest.approx(2.22 * 1000.0 / 3.45 + 200.0)
    assert after["pin_gear_pitting"].limit == 1240.0
    assert after["pin_gear_yield"].limit == pytest.approx(YIELD_PRESSURE * hard.material.surface_yield / 1e6)
    assert after["output_pin_fatigue"].limit < before["output_pin_fatigue"].limit
    assert after["peak_pin_bending"].limit == 490.0


def test_a_plastic_takes_a_set_as_its_creep_modulus_falls() -> None:
    """Hostaform C 9021: 2850 MPa in a short test, 2500 after 1 h, 1300 after 1000 h of load."""
    assert set_hours(2500.0 / 2850.0, 1.0) == pytest.approx(1.0)
    assert set_hours(1300.0 / 2850.0, 1.0) == pytest.approx(1000.0)
    plastic = override(PIN, {"gear_material.name": "POM", "drive.torque_nm": 0.1})
    items = rate(plastic).items
    assert not {"pin_gear_yield", "pin_gear_shakedown", "pin_gear_pitting"} & items.keys()
    item = items["pin_gear_set"]
    assert item.limit == pytest.approx(SHAKEDOWN_PRESSURE * 64.0)
    assert item.life == pytest.approx(set_hours(item.value, item.limit))
    assert "pin_socket_yield" in items, "steel in steel"


def test_a_plastic_is_held_once_to_its_set() -> None:
    soft = override(PIN, {"gear_material.name": "POM", "drive.torque_nm": 0.1})
    items = rate(soft).items
    at_it = rate(soft, steady(items["peak_yield"].limit, soft.drive.speed), give=False).items
    assert at_it["pin_gear_set"].value == pytest.approx(SHAKEDOWN_PRESSURE * 64.0, rel=2e-3)


@pytest.mark.parametrize("name", ["pin", pytest.param("twodisc", marks=pytest.mark.slow)])
def test_an_emergency_stop_is_the_same_whatever_the_load(name: str) -> None:
    """At 3 % of the load `pin` was told to yield by 9.44 N m, at the load by 29.9: by the root of the torque."""
    design = PRESETS[name]
    capacity = sheet(Reducer(design)).quantities["capacity"].value
    for share in (0.03, 1.0):
        stops = rate(design, steady(share * design.rated_torque, design.drive.speed), give=False).items
        assert stops["peak_yield"].limit == pytest.approx(capacity, rel=0.005)


def test_the_checks_tell_the_weakest_item_of_each_kind() -> None:
    found = {item.name: item for item in lasting_checks(Reducer(PIN))}
    assert list(found) == ["momentary_torque", "heat", "life", "strength"]
    assert {item.name for item in found.values() if not item.passed} == {"momentary_torque", "life", "strength"}
    assert all(item.severity == "warning" and item.passed != bool(item.remedy) for item in found.values())
    rating = rate(PIN)
    assert found["life"].value == pytest.approx(rating.items["pin_gear_pitting"].life)
    assert found["life"].bound == PIN.service.life
    assert found["heat"].value == pytest.approx(rating.items["temperature"].safety)
    assert found["momentary_torque"].value == pytest.approx(rating.items["peak_yield"].safety)


@pytest.mark.parametrize("name", ["pin", "printed", pytest.param("twodisc", marks=pytest.mark.slow)])
def test_every_check_that_fails_is_mended_by_each_of_its_ways(name: str) -> None:
    reducer = Reducer(PRESETS[name])
    ways = lasting_ways(reducer)
    assert ways.keys() == {item.name for item in lasting_checks(reducer) if not item.passed}
    for check, changes in ways.items():
        assert "drive.torque_nm" in dict(changes)
        for key, value in changes:
            mended = {
                item.name: item.passed for item in lasting_checks(Reducer(override(reducer.design, {key: value})))
            }
            assert mended[check], key


def test_a_drive_at_the_torque_of_its_data_sheet_lasts() -> None:
    torque, _ = rated_torque(Reducer(PIN), PIN.drive.speed, PIN.service.life)
    lasting = PIN.but(drive={"torque": 0.99 * torque / PIN.lobes})
    passed = {item.name: item.passed for item in checks_of(rate(lasting))}
    assert passed["life"]
    assert passed["strength"]
    assert passed["heat"]


def test_a_crank_that_stands_still_has_no_such_checks() -> None:
    assert lasting_checks(Reducer(PIN.but(drive={"speed": 0.0}))) == ()


def test_a_longer_life_is_asked_for_by_the_design() -> None:
    longer = PIN.but(service={"life": 12345.0})
    assert rate(longer).life == 12345.0
    assert rate(longer, life=100.0).life == 100.0


def test_a_life_that_no_give_of_the_cam_ends_is_told_once() -> None:
    """It read "its life unlimited to unlimited"."""
    rows = tuple(Give("as assumed", 1e9, load, life) for load, life in ((40.0, 1e12), (44.0, 2e12)))
    assert "its life unlimited over the stiffness" in CamGive(rows).words
    shorter = (*rows, Give("stiffer", 1e10, 50.0, 500.0))
    assert "its life 500 h to unlimited over" in CamGive(shorter).words
