"""Hard surfaces, plastics that take a set, and the checks that sum a rating up."""

import math

import numpy as np
import pytest
from commands import told

from cycloid_mj.base.judgement import Judgement
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.design.materials import SHAKEDOWN_PRESSURE, YIELD_PRESSURE
from cycloid_mj.geometry import profile
from cycloid_mj.life import emergency_stop, rate
from cycloid_mj.life.bearing_compliance import CamCase, CamCompliance
from cycloid_mj.life.checks import check_design, checks_of_rating, life_checks, life_remedies
from cycloid_mj.life.duty import DutyPoint, constant_duty
from cycloid_mj.life.loading import Loading, solve_loading
from cycloid_mj.life.plastic_set import creep_damage, damage_rate, load_shares
from cycloid_mj.life.rated import rated_torque
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.peaks import line_loads
from cycloid_mj.statics.sheet import sheet

PIN = PRESETS["pin"]
POM = override(PIN, {"gear_material.name": "POM", "drive.torque_nm": 0.1})


def pom_loading(design: Design) -> Loading:
    """Return the loading of a design at its nominal torque and speed."""
    return solve_loading(Reducer(design), DutyPoint(design.rated_torque, design.drive.speed, 1.0), with_wind_up=False)


def test_a_hard_surface_carries_more_and_the_core_is_unchanged() -> None:
    soft = PIN.but(material={"name": "tempered steel"})
    hard = PIN.but(material={"name": "case-hardened 16MnCr5"})
    before, after = rate(soft).items, rate(hard).items
    assert before["pin_gear_pitting"].limit == pytest.approx(2.22 * 1000.0 / 3.45 + 200.0)
    assert after["pin_gear_pitting"].limit == 1240.0
    assert after["pin_gear_yield"].limit == pytest.approx(YIELD_PRESSURE * hard.material.surface_yield / 1e6)
    assert after["output_pin_fatigue"].limit < before["output_pin_fatigue"].limit
    assert after["peak_pin_bending"].limit == 490.0


def test_a_plastic_creeps_as_its_creep_modulus_falls() -> None:
    """Hostaform C 9021: 2850 MPa in a short test, 2500 after 1 h, 1300 after 1000 h of load."""
    assert creep_damage([2500.0 / 2850.0, 1300.0 / 2850.0, 0.0], 1.0) == pytest.approx([1.0, 1e-3, 0.0])
    items = rate(POM).items
    assert not {"pin_gear_yield", "pin_gear_shakedown", "pin_gear_pitting"} & items.keys()
    assert items["pin_gear_set"].limit == pytest.approx(SHAKEDOWN_PRESSURE * 64.0)
    assert "pin_socket_yield" in items, "steel in steel"


def test_a_place_of_a_lobe_is_loaded_while_the_contact_strip_passes_it() -> None:
    """Of the turn of the crank against the disc, the strip needs its width over the travel of the contact line."""
    loading = pom_loading(POM)
    gear, reducer = loading.reducer.tooth_profile, loading.reducer
    phases = loading.springs.crank[:, np.newaxis] + profile.pin_angles(gear)
    step = 1e-5
    ends = [-(phases + side * step) / gear.lobes for side in (-1.0, 1.0)]
    low, high = (profile.arc_length(reducer.gear_profile, end, reducer.profile_offset) for end in ends)
    travel = np.abs(high - low) / (2.0 * step)  # of the contact line on the disc, per radian of the crank [m]
    widths = np.full(phases.shape, 1e-6)
    expected = 2.0 * widths / (2.0 * np.pi * travel) * gear.ring_teeth / gear.lobes
    assert load_shares(loading, "pin_gear", "gear", widths) == pytest.approx(expected, rel=5e-3)
    assert load_shares(loading, "pin_gear", "gear", np.full(phases.shape, 1.0)) == pytest.approx(1.0)
    hole = load_shares(loading, "output", "gear", np.full((1, 1), 1e-6))
    assert hole == pytest.approx(1e-6 / (np.pi * POM.output.hole_radius))


def test_a_lobe_meets_a_protruding_pin_once_in_as_many_passes_as_there_are_pins() -> None:
    protruding = POM.but(errors={"pin_dr": (20e-6, *[0.0] * (POM.ring.teeth - 1))})
    loading = pom_loading(protruding)
    limit = SHAKEDOWN_PRESSURE * 64e6
    force, curvature = line_loads(loading.reducer, loading.springs, loading.contacts, "pin_gear")
    contact = loading.reducer.contacts["pin_gear"]
    shares = load_shares(loading, "pin_gear", "gear", contact.half_width(force, curvature))
    largest = float((shares * creep_damage(contact.pressure(force, curvature), limit)).max())
    passes = largest / damage_rate(loading, "pin_gear", limit)
    assert 0.5 * POM.ring.teeth < passes < 2.0 * POM.ring.teeth


def test_a_plastic_withstands_a_single_load_up_to_its_permanent_set() -> None:
    soft = override(PIN, {"gear_material.name": "POM", "drive.torque_nm": 0.1})
    items = rate(soft).items
    at_it = rate(soft, constant_duty(items["peak_yield"].limit, soft.drive.speed)).items
    assert at_it["pin_gear_set"].value == pytest.approx(SHAKEDOWN_PRESSURE * 64.0, rel=2e-3)


@pytest.mark.parametrize("name", ["pin", pytest.param("twodisc", marks=pytest.mark.slow)])
def test_an_emergency_stop_is_the_same_whatever_the_load(name: str) -> None:
    """At 3 % of the load `pin` was told to yield by 9.44 N m, at the load by 29.9: by the root of the torque."""
    design = PRESETS[name]
    capacity = sheet(Reducer(design)).quantities["capacity"].value
    for share in (0.03, 1.0):
        stops = rate(design, constant_duty(share * design.rated_torque, design.drive.speed)).items
        assert stops["peak_yield"].limit == pytest.approx(capacity, rel=0.005)


@pytest.mark.parametrize("name", ["pin", "nonpin", "printed"])
def test_no_equilibrium_is_sought_far_beyond_another_limit_of_a_stop(name: str, monkeypatch) -> None:
    """At 15 kN m, a thousand times the load, the search for an equilibrium took 15 s and found none."""
    bounded = rate(PRESETS[name], poses=19)
    monkeypatch.setattr(emergency_stop, "FAR_BEYOND", math.inf)
    searched = rate(PRESETS[name], poses=19)
    bounds, limits = (
        {key: item.safety for key, item in rating.items.items() if key.startswith("peak_")}
        for rating in (bounded, searched)
    )
    assert min(bounds.values()) == min(limits.values())
    assert all(0.7 * limits[key] < bounds[key] <= limits[key] for key in limits)
    assert ("lower bound" in bounded.items["peak_dents"].note) == (bounds["peak_dents"] < limits["peak_dents"])
    assert "lower bound" not in searched.items["peak_dents"].note


def test_the_checks_state_the_weakest_item_of_each_kind() -> None:
    found = {item.name: item for item in life_checks(Reducer(PIN))}
    assert list(found) == ["momentary_torque", "heat", "life", "strength"]
    # with the bearings of shaft and output, 34.8 W heat the housing to 106 deg C; 24.4 W left them out
    assert {item.name for item in found.values() if not item.passed} == set(found)
    assert all(item.severity == "warning" and item.passed != bool(item.remedy) for item in found.values())
    rating = rate(PIN)
    assert found["life"].value == pytest.approx(rating.items["pin_gear_pitting"].life)
    assert found["life"].bound == PIN.service.life
    assert found["heat"].value == pytest.approx(rating.items["temperature"].safety)
    assert found["momentary_torque"].value == pytest.approx(rating.items["peak_yield"].safety)


TOLERANCED = override(PRESETS["printed"], ['tolerance.cam="uniform 10"', 'tolerance.pin_position="normal 5"'])


def test_a_design_with_tolerances_is_checked_within_them_as_by_rate() -> None:
    """At 3 N m, perfect parts last 4000 h and those of the samples 70 h: check and rate disagreed."""
    design = Reducer(TOLERANCED).with_nominal_torque(3.0).design
    life = next(check for check in check_design(design) if check.name == "life")
    rating = rate(design, parts="toleranced")
    assert life.value == pytest.approx(min(item.life for item in rating.items.values() if item.life and item.decisive))
    assert life.value < 0.1 * rate(design).shortest_life
    assert "toleranced parts" in life.why


@pytest.mark.parametrize(
    "design",
    [
        PRESETS["pin"],
        PRESETS["printed"],
        pytest.param(PRESETS["twodisc"], marks=pytest.mark.slow),
        pytest.param(TOLERANCED, marks=pytest.mark.slow),
    ],
    ids=["pin", "printed", "twodisc", "toleranced"],
)
def test_each_remedy_of_a_failed_check_makes_it_pass(design: Design) -> None:
    reducer = Reducer(design)
    ways = life_remedies(reducer)
    assert ways
    assert ways.keys() == {item.name for item in life_checks(reducer) if not item.passed}
    for check, changes in ways.items():
        assert "drive.torque_nm" in dict(changes)
        for key, value in changes:
            mended = {item.name: item.passed for item in life_checks(Reducer(override(reducer.design, {key: value})))}
            assert mended[check], key


def test_a_drive_at_the_torque_of_its_data_sheet_lasts() -> None:
    torque, _ = rated_torque(Reducer(PIN), PIN.drive.speed, PIN.service.life)
    lasting = PIN.but(drive={"torque": 0.99 * torque / PIN.lobes})
    passed = {item.name: item.passed for item in checks_of_rating(rate(lasting))}
    assert passed["life"]
    assert passed["strength"]
    assert passed["heat"]


def test_a_crank_at_rest_has_no_such_checks() -> None:
    assert life_checks(Reducer(PIN.but(drive={"speed": 0.0}))) == ()


def test_a_longer_life_is_requested_by_the_design() -> None:
    longer = PIN.but(service={"life": 12345.0})
    assert rate(longer).life == 12345.0
    assert rate(longer, life=100.0).life == 100.0


def test_a_life_unlimited_at_any_cam_stiffness_is_reported_once() -> None:
    """It read "its life unlimited to unlimited"."""
    rows = tuple(CamCase("as assumed", 1e9, load, life) for load, life in ((40.0, 1e12), (44.0, 2e12)))
    assert "its life unlimited, over the range" in CamCompliance(rows).words
    shorter = (*rows, CamCase("stiffer", 1e10, 50.0, 500.0))
    assert "its life 500 h to unlimited, over" in CamCompliance(shorter).words


def test_python_and_terminal_have_the_same_verdicts() -> None:
    """At 36.68 N m the teeth of `pin` pit after 0.0017 h: `cm.check` said that all checks hold where they warned."""
    checks = check_design(PIN)
    assert {"life", "strength", "momentary_torque"} <= {check.name for check in checks.warnings}
    assert not checks.failures
    printed = told("design", "check", "pin")[1].splitlines()
    warned = [line.split()[1] for line in printed if line.startswith("warn")]
    assert warned == [f"{check.name}:" for check in checks.warnings]
    assert not [line for line in printed if line.startswith(("FAIL", "ok"))]
    assert printed[-1] == f"{len(checks)} checks: {checks.counts}"


def test_passed_checks_are_listed_only_with_all() -> None:
    """One failed check brought all "ok" rows with it, which hid it."""
    arguments = ("design", "check", "pin", "--set", "ring.pin_radius_mm=2.7")
    short, full = (told(*arguments, *more)[1].splitlines() for more in ((), ("--all",)))
    assert [line.split()[0] for line in short[1:-2]] == ["FAIL"]
    assert sum(line.startswith("ok") for line in full) == 27


def test_items_that_outlast_everything_pass_and_wear_only_warns() -> None:
    rating = rate(PIN)
    judgements = {key: item.judgement(rating.life) for key, item in rating.items.items()}
    unlimited = [key for key, item in rating.items.items() if item.margin(rating.life) == math.inf and item.decisive]
    assert unlimited
    assert {judgements[key] for key in unlimited} == {Judgement.PASSED}
    assert judgements["power_lost"] is Judgement.NOT_APPLICABLE
    assert judgements["pin_gear_pitting"] is Judgement.FAILED
    worn = rate(PIN.but(service={"wear_coefficient": 1e-14}))
    assert worn.items["pin_gear_wear"].judgement(worn.life) is Judgement.WARNING
    assert worn.items["pin_gear_wear"] not in worn.failing
    assert rating.as_json()["items"]["pin_gear_pitting"]["judgement"] == "failed"
