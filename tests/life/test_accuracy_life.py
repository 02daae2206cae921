"""Wear over hours: Archard in closed form, balance of worn volume, worn gaps against clearances, accuracy life."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from commands import told

import cycloid_mj as cm
from cycloid_mj.base.errors import UsageError
from cycloid_mj.design import PRESETS, override
from cycloid_mj.geometry import profile
from cycloid_mj.life.accuracy_life import Course, WearLife, wear
from cycloid_mj.life.duty import constant_duty
from cycloid_mj.life.wear_course import WearingDrive, WearSettings, lost_motion, wear_steps
from cycloid_mj.life.wear_data import RUN_IN, wear_coefficient, wear_rate, worn_depth
from cycloid_mj.life.wearing_surfaces import TABLE, dose_rate, sliding_contacts, sum_over_cells, wearing_surfaces
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.worn import WornGaps
from cycloid_mj.statics import loads, springs_of

PIN, NONPIN = PRESETS["pin"], PRESETS["nonpin"]
WITHOUT_RUN_IN = {"service": {"run_in_depth": 1e-15}}
PLAIN = PIN.but(gear={"bearing": "plain"}, output={"rollers": False}, friction={"cam": 0.01, "output": 0.01})
FILM = PIN.but(name="film", friction={"law": "film"})
SLEEVED = FILM.but(name="sleeved", ring={"pins": "sleeved"})


def drive_of(design: cm.Design, **settings: float) -> WearingDrive:
    points = constant_duty(design.rated_torque, design.drive.speed).points
    return WearingDrive(Reducer(design), points, WearSettings(**settings))


def test_depth_is_k_times_pressure_times_distance() -> None:
    """10 MPa over 1 km at 1e-9 mm3/(N m), without run-in: 10 nm."""
    assert worn_depth(np.array([10e6 * 1e3]), 1e-18, 0.0) == pytest.approx([1e-8], rel=1e-12)


def test_running_in_starts_at_its_factor_and_adds_its_depth() -> None:
    dose, coefficient, run_in = np.linspace(0.0, 5e12, 51), 1e-18, 0.5e-6
    depth, rate = worn_depth(dose, coefficient, run_in), wear_rate(dose, coefficient, run_in)
    assert rate[0] == pytest.approx(RUN_IN.factor * coefficient)
    assert rate[-1] == pytest.approx(coefficient, rel=1e-6)
    assert depth[-1] == pytest.approx(coefficient * dose[-1] + run_in, rel=1e-6)
    step = 1e6
    between = (worn_depth(dose + step, coefficient, run_in) - worn_depth(dose - step, coefficient, run_in)) / (2 * step)
    assert between == pytest.approx(rate, rel=1e-6)


def test_spreading_keeps_the_sum_and_matches_single_strips() -> None:
    random = np.random.default_rng(1)
    places, widths, weights = random.uniform(-1, 1, 7), random.uniform(0.01, 0.4, 7), random.uniform(0, 1, 7)
    edges, expected = (np.arange(51) / 50 - 0.5) * 2.0, np.zeros(50)
    for shift in (-2.0, 0.0, 2.0):
        for place, width, weight in zip(places + shift, widths, weights, strict=True):
            expected += np.diff(np.clip((edges - place + width) / (2.0 * width), 0.0, 1.0)) * weight
    assert sum_over_cells(places, widths, weights, 2.0, 50) == pytest.approx(expected, abs=1e-12)
    assert expected.sum() == pytest.approx(weights.sum())


@pytest.mark.parametrize(
    "design",
    [PIN, NONPIN, PLAIN, FILM, SLEEVED, pytest.param(PRESETS["twodisc"], marks=pytest.mark.slow)],
    ids=lambda item: item.name,
)
def test_worn_volume_is_k_times_force_times_distance(design: cm.Design) -> None:
    """The dose of all cells times their area is the mean of the sum of F v, on both surfaces of every pair."""
    drive = drive_of(design)
    springs = springs_of(drive.reducer, drive.crank)
    contact_loads = loads(drive.reducer, springs, math.copysign(design.rated_torque, design.drive.speed))
    sliding = sliding_contacts(drive.reducer, springs, contact_loads)
    assert {surface.gap for surface in drive.surfaces} >= {"teeth"}
    for surface in drive.surfaces:
        rub = sliding[surface.contacts]
        area = surface.count * surface.length * surface.section
        power = (rub.force * rub.speed).sum(axis=1).mean() * surface.lever
        assert dose_rate(surface, rub).mean() * area == pytest.approx(power, rel=1e-9), surface.key


@pytest.mark.parametrize("design", [FILM, SLEEVED], ids=lambda item: item.name)
def test_with_film_friction_flanks_and_seats_share_the_sliding(design: cm.Design) -> None:
    """A pin slides on the flank or in its seat, where its friction is lower, so both together have all sliding."""
    drive = drive_of(design)
    springs = springs_of(drive.reducer, drive.crank)
    contact_loads = loads(drive.reducer, springs, math.copysign(design.rated_torque, design.drive.speed))
    sliding = sliding_contacts(drive.reducer, springs, contact_loads)
    work = {kind: float((sliding[kind].force * sliding[kind].speed).sum()) for kind in ("teeth", "flank", "seat")}
    assert work["flank"] + work["seat"] == pytest.approx(work["teeth"], rel=1e-12)
    assert work["seat"] > work["flank"] > 0.0, "most loaded free pins roll"
    kinds = {surface.key: surface.contacts for surface in drive.surfaces if surface.gap == "teeth"}
    seats = {"socket": "seat"} if design.ring.has_sockets else {"sleeve": "seat", "core": "seat"}
    assert kinds == {"flank": "flank", "pin": "teeth" if design.ring.has_sockets else "flank", **seats}


def test_flank_loses_a_micrometre_in_the_hours_of_a_hand_calculation() -> None:
    """1e-9 mm3/(N m) over the whole flank of `pin` at constant loads, 36.68 N m: 3246 h for F v = 252 W of ideal
    sharing without friction; statics finds 330 W with clearances and friction, so 2480 h.
    """
    drive = drive_of(PIN)
    rate = drive.dose_rates(drive.reducer)["flank"].mean()
    assert 1e-6 / (1e-18 * rate) / 3600.0 == pytest.approx(2480.0, rel=0.02)


def worn(teeth: float, output: float, cam: float) -> Reducer:
    return Reducer(PLAIN, WornGaps(np.full(TABLE, teeth), np.full(TABLE, output), cam))


@pytest.mark.parametrize(
    ("pair", "depths"), [("pin_gear", (3e-6, 0, 0)), ("output", (0, 3e-6, 0)), ("cam", (0, 0, 3e-6))]
)
def test_even_wear_equals_a_wider_clearance(pair: str, depths: tuple[float, float, float]) -> None:
    wider = Reducer(PLAIN.but(clearance={pair: getattr(PLAIN.clearance, pair) + 3e-6}))
    new = lost_motion(Reducer(PLAIN))
    # the stiffness of a plain cam depends on its clearance in the design, not on its wear
    assert lost_motion(worn(*depths)) - new == pytest.approx(lost_motion(wider) - new, rel=3e-3)


def test_a_worn_place_of_the_flank_opens_the_gap_there_only() -> None:
    """A depth at phases of 50 to 70 deg appears in the gaps of the pins at these phases."""
    angles = np.linspace(-180.0, 180.0, TABLE, endpoint=False)
    table = np.where((angles > 50.0) & (angles < 70.0), 2e-6, 0.0)
    crank = np.linspace(0.0, 6.0, 13)
    new, used = (
        springs_of(item, crank, friction=False).contacts
        for item in (Reducer(PIN), Reducer(PIN, WornGaps(table, np.zeros(TABLE), 0.0)))
    )
    teeth = PIN.ring.teeth
    phase = np.degrees(np.mod(-new.phase[:, :teeth] + math.pi, 2 * math.pi) - math.pi)
    opened = (used.distance - new.distance)[:, :teeth]
    inside, outside = (phase > 51.0) & (phase < 69.0), (phase < 49.0) | (phase > 71.0)
    assert opened[inside] == pytest.approx(2e-6)
    assert not opened[outside].any()


def test_equal_worn_reducers_only_are_equal() -> None:
    gaps = WornGaps(np.zeros(TABLE), np.zeros(TABLE), 0.0)
    assert Reducer(PIN, gaps) == Reducer(PIN, gaps) != Reducer(PIN)
    assert Reducer(PIN, gaps).but(load={"torque": 5.0}).worn is gaps


def test_steps_converge() -> None:
    """A quarter of the step and three times the crank angles change the growth of the lost motion by less than 1 %."""
    ends = []
    for settings in ({}, {"step_share": 0.1, "poses": 361}):
        *_, last = wear_steps(drive_of(NONPIN, **settings), "typical", [100.0])
        ends.append(last.lost_motion - lost_motion(Reducer(NONPIN)))
    assert ends[0] == pytest.approx(ends[1], rel=0.01)


def test_wear_is_where_a_published_model_finds_it() -> None:
    """Lubricants 13 (2025) 362: convex flanks of the disc wear, and pins most at the edge of their contact zone."""
    fixed = PIN.but(ring={"pins": "fixed"})
    drive = drive_of(fixed)
    *_, last = wear_steps(drive, "typical", [300.0])
    flank, pin = drive.surfaces
    gear = drive.reducer.gear_profile
    inflection = profile.inflection_phase(gear) / fixed.lobes
    concave = profile.arc_length(gear, inflection, drive.reducer.profile_offset)
    depth = last.depths["flank"]
    assert depth[np.abs(flank.coordinates) > concave].sum() > 0.8 * depth.sum()
    edge = fixed.ring.pin_radius * math.asin(fixed.gear.eccentricity * fixed.ring.teeth / fixed.ring.pin_circle_radius)
    assert abs(pin.coordinates[np.argmax(last.depths["pin"])]) == pytest.approx(edge, rel=0.03)


@pytest.fixture(scope="module")
def pin_life() -> WearLife:
    return wear(PIN, 400.0, growth=0.3)


def test_the_life_is_an_interval(pin_life: WearLife) -> None:
    low, typical, high = (pin_life.life(case) for case in ("high", "typical", "low"))
    assert low < typical < 400.0
    assert high > 400.0
    assert (pin_life.extrapolated(), pin_life.extrapolated("low")) == (False, True)
    assert pin_life.courses["low"].hours[-1] == 400.0
    for course in pin_life.courses.values():
        assert np.all(np.diff(course.lost_motion) > 0.0)
    found = pin_life.as_json()
    assert found["accuracy_life_h"] == pytest.approx(typical)
    assert not found["accuracy_life_extrapolated"]
    assert found["accuracy_life_interval_h"] == pytest.approx([low, high])
    assert found["accuracy_life"]["low"].endswith("h, extrapolated")
    last = found["records"][-1]
    assert last["lost_motion_arcmin"] >= found["limit_arcmin"] > found["records"][0]["lost_motion_arcmin"]
    assert json.loads(json.dumps(found)) == found
    assert 0.0 < pin_life.run_in_share < 1.0
    assert pin_life.plot() is not None


def test_the_interval_of_extrapolated_lives_is_readable(pin_life: WearLife) -> None:
    assert re.fullmatch(r"[\d.]+ h to about [\d.e+]+ h, extrapolated", pin_life.interval_text)
    later = replace(pin_life, growth=1000.0)
    assert re.fullmatch(r"about [\d.e+]+ h to about [\d.e+]+ h, both extrapolated", later.interval_text)
    course = Course(np.array([0.0, 1.0]), np.ones(2), "end")
    assert replace(pin_life, courses=dict.fromkeys(pin_life.courses, course)).interval_text == "unlimited"


def test_beyond_its_course_a_life_follows_from_the_last_rate() -> None:
    course = Course(np.array([0.0, 1.0, 2.0]), np.array([1.0, 1.2, 1.3]), "end")
    assert course.life(1.1) == pytest.approx(0.5)
    assert course.life(1.6) == pytest.approx(5.0)
    assert math.isinf(Course(course.hours, np.ones(3), "end").life(1.6))


def test_a_life_is_extrapolated_by_the_law_of_run_in(pin_life: WearLife) -> None:
    """After 10 h, in the run-in, the last rate of growth would end the life after 49 h instead of 97 h."""
    early = wear(PIN, 10.0, growth=0.3)
    assert early.extrapolated()
    by_last_rate = replace(early.courses["typical"], trend=None).life(early.limit)
    assert by_last_rate < 0.55 * pin_life.life()
    assert early.life() == pytest.approx(pin_life.life(), rel=0.3)


def test_without_run_in_the_trend_is_the_last_rate() -> None:
    course = wear(PIN.but(**WITHOUT_RUN_IN), 400.0).courses["typical"]
    limit = 1.5 * float(course.lost_motion[-1])
    assert course.life(limit) == pytest.approx(replace(course, trend=None).life(limit), rel=1e-4)


def test_a_computation_ends_where_a_part_is_worn_through(monkeypatch: pytest.MonkeyPatch) -> None:
    """Flanks that are 0.3 um thick end all cases, and their lives, before the lost motion has grown enough."""
    thin = tuple(replace(surface, thickness=3e-7) for surface in wearing_surfaces(Reducer(PIN)))
    monkeypatch.setattr("cycloid_mj.life.wear_course.wearing_surfaces", lambda reducer: thin)
    worn = wear(PIN, 200.0, growth=10.0)
    course = worn.courses["typical"]
    assert course.end == f"after {course.hours[-1]:.4g} h, flanks of the discs are worn through (0.0003 mm)"
    assert worn.life() == course.hours[-1] < 200.0
    assert not worn.extrapolated()
    flank = worn.surfaces[0]
    assert 3e-7 <= flank.depth.max() < 4e-7
    assert worn.as_json()["courses"]["typical"]["end"] == course.end
    # within the computed hours of the course, its trend finds the same end
    before = wear(PIN, 0.9 * float(course.hours[-1]), growth=10.0)
    assert before.life() == pytest.approx(course.hours[-1], rel=0.1)
    assert before.extrapolated()


def test_sleeves_that_always_turn_wear_in_their_bores_only() -> None:
    rolling = SLEEVED.but(friction={"law": "coulomb", "pin_gear": 0.2, "pin_sleeve": 0.05})
    thickness = {item.key: item.thickness for item in wearing_surfaces(Reducer(rolling))}
    ring = rolling.ring
    assert thickness == pytest.approx(
        {"sleeve": ring.pin_radius - ring.sleeve_bore_radius, "core": ring.sleeve_bore_radius}
    )


def test_parts_are_worn_through_at_the_height_of_a_lobe_or_the_thickness_of_a_wall() -> None:
    thickness = {item.key: item.thickness for item in wearing_surfaces(Reducer(PLAIN))}
    hole_wall = PLAIN.output.pin_circle_radius * math.sin(math.pi / PLAIN.output.pins) - PLAIN.output.hole_radius
    assert thickness == pytest.approx(
        {
            "flank": 2.0 * PLAIN.gear.eccentricity,
            "pin": PLAIN.ring.pin_radius,
            "hole": hole_wall - PLAIN.clearance.output,
            "output_pin": PLAIN.output.pin_radius,
            "bore": PLAIN.output.pin_circle_radius
            - PLAIN.output.hole_radius
            - PLAIN.clearance.output
            - PLAIN.gear.bore_radius
            - PLAIN.clearance.cam,
            "cam": PLAIN.gear.bore_radius,
        }
    )


def test_time_scales_with_the_coefficient_without_run_in() -> None:
    """Archard: ten times the coefficient takes a tenth of the time, along the same course."""
    slow, fast = (
        wear(PIN.but(**WITHOUT_RUN_IN).but(service={"wear_coefficient": k}), hours, growth=0.1).life()
        for k, hours in ((2e-18, 1000.0), (2e-17, 100.0))
    )
    assert fast == pytest.approx(slow / 10.0, rel=1e-3)


def test_an_interruption_keeps_the_finished_steps() -> None:
    def stop(case: str, share: float) -> None:
        if case == "typical" and share > 0.05:
            raise KeyboardInterrupt

    stopped = wear(PIN, 100.0, on_progress=stop)
    assert stopped.interrupted
    assert set(stopped.courses) == {"typical"}
    assert len(stopped.records) >= 1
    assert stopped.as_json()["accuracy_life"]["high"] == "not computed"


def test_coefficients_follow_the_materials() -> None:
    printed = PRESETS["printed"]
    disc, pin = (wear_coefficient(printed.service, printed.material_of(part)) for part in ("gear", "pin"))
    assert disc.typical == pytest.approx(2.65e-15)
    assert pin.typical == pytest.approx(1e-18)
    stated = override(PIN, {"service.wear_coefficient_mm3_nm": 3e-9})
    assert wear_coefficient(stated.service, stated.material).high == pytest.approx(3e-17)
    with pytest.raises(UsageError, match="hours of the wear study is 0, which is out of range"):
        wear(PIN, 0.0)


def test_command_prints_life_and_interval() -> None:
    code, text, _ = told("wear", "pin", "--hours", "2", "--json")
    found = json.loads(text)
    assert code == 0
    assert found["accuracy_life_extrapolated"]
    low, high = found["accuracy_life_interval_h"]
    assert 2.0 < low < found["accuracy_life_h"] < high
    code, _, message = told("wear", "pin", "--hours", "0")
    assert code == 2
    assert "--hours 0 is out of range" in message
