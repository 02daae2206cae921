"""The data sheet: its numbers hold under their conditions, its pages are whole, nothing on them is clipped."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from designs import UNLIKE, unlike
from page_texts import require_separate_texts

from cycloid_mj.base.errors import CycloidWarning, DesignError
from cycloid_mj.base.result import Quantity
from cycloid_mj.base.units import RPM
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, override
from cycloid_mj.figures import figure
from cycloid_mj.life import datasheet as datasheet_module
from cycloid_mj.life import rate
from cycloid_mj.life.datasheet import Datasheet, axial_extent, datasheet, life_curve
from cycloid_mj.life.duty import constant_duty
from cycloid_mj.life.rated import rated_torque
from cycloid_mj.life.sheet_rows import backlash_with_bearings, environment_rows
from cycloid_mj.life.thermal import thermal
from cycloid_mj.parts import input_inertia, mass_properties, parts
from cycloid_mj.parts.cut import cut_prism
from cycloid_mj.parts.prism import Prism
from cycloid_mj.plots.datasheet import datasheet_pages, datasheet_pictures, format_value
from cycloid_mj.plots.save import document
from cycloid_mj.reducer import Reducer
from cycloid_mj.report.datasheet import datasheet_page
from cycloid_mj.statics.sheet import sheet as static

PIN = PRESETS["pin"]
SQUARE = np.array([[-3.0, -2.0], [3.0, -2.0], [3.0, 2.0], [-3.0, 2.0]])


@pytest.fixture(scope="module")
def sheet() -> Datasheet:
    return datasheet(Reducer(PIN))


def told(sheet: Datasheet) -> dict[str, Quantity]:
    return {one.key: one for group in sheet.groups.values() for one in group}


@pytest.mark.slow
def test_the_deciding_item_just_reaches_the_required_life_at_the_rated_torque(sheet) -> None:
    """At that torque what decides it lasts as long as asked, and nothing but wear and stops is weaker."""
    torque = told(sheet)["rated_torque"].value
    found = rate(PIN, constant_duty(torque, PIN.drive.speed), sheet.life)
    steadily = {key: item for key, item in found.items.items() if not key.startswith("peak_")}
    deciding = next(item for key, item in steadily.items() if not key.endswith(("_wear", "_pv", "_static")))
    assert deciding.key == "pin_gear_pitting"
    assert deciding.name in told(sheet)["rated_torque"].note
    # nine times the accuracy of the torque, which is what pitting makes of it
    assert deciding.life == pytest.approx(6000.0, rel=0.01)


@pytest.mark.slow
def test_a_sheet_at_20_degrees_names_no_temperature(sheet) -> None:
    assert not any(note.startswith("Temperature of the parts") for note in sheet.notes)


def test_each_key_has_one_value(sheet) -> None:
    """`rated_torque_nm` was 42.32 N m at the top and 40.0 N m, motor torque times ratio, among the figures."""
    content = sheet.as_json()
    assert content["rated_torque_nm"] == told(sheet)["rated_torque"].value
    assert "rated_torque_nm" not in content["figures"]
    assert content["figures"]["nominal_torque_nm"]["value"] == pytest.approx(36.68)
    assert content["quantities"]["nominal_torque"]["value"] == pytest.approx(36.68)


def test_former_key_of_the_nominal_torque_is_accepted_with_a_warning() -> None:
    with pytest.warns(CycloidWarning, match="rated_torque_nm is deprecated: use nominal_torque_nm"):
        assert figure("rated_torque_nm").key == "nominal_torque_nm"


def test_progress_is_counted_to_the_end() -> None:
    counted: list[tuple[int, int]] = []
    datasheet(Reducer(PIN), progress=lambda done, whole: counted.append((done, whole)))
    assert [done for done, _ in counted] == list(range(1, counted[0][1] + 1))


def test_the_bearing_torque_follows_its_law(sheet) -> None:
    near = rate(PIN).items["shaft_bearing_near"]
    by_law = PIN.rated_torque * (near.life / 6000.0) ** 0.3
    assert told(sheet)["bearing_torque"].value == pytest.approx(by_law, rel=0.03)


@pytest.mark.slow
def test_a_longer_life_is_required_of_a_smaller_torque() -> None:
    torques = [rated_torque(Reducer(PIN), PIN.drive.speed, life)[0] for life in (1000.0, 6000.0)]
    assert torques[0] / torques[1] > 1.15
    assert rated_torque(Reducer(PIN), PIN.drive.speed, 6000.0, start_torque=50.0)[0] == pytest.approx(
        torques[1], rel=2e-3
    )


def test_a_drive_without_a_rated_torque_for_a_life_is_reported() -> None:
    with pytest.raises(DesignError, match=r"no rated torque for 1e\+20 h"):
        rated_torque(Reducer(PIN), PIN.drive.speed, 1e20)


def test_the_momentary_torque_is_that_of_the_weakest_stop(sheet) -> None:
    stops = [item for item in rate(PIN).items.values() if item.key.startswith("peak_")]
    assert len(stops) == 5
    assert told(sheet)["momentary_torque"].value == pytest.approx(2.0 * 36.68 * min(item.safety for item in stops))


@pytest.mark.slow
def test_the_momentary_torque_is_at_least_the_rated_torque() -> None:
    """Where first yield comes before what lasts, it governs: no sheet has a momentary torque below its rated one."""
    soft = PIN.but(material={"name": "", "youngs_modulus": 2.1e11, "tensile_strength": 2e9, "yield_strength": 2e8})
    for design in (soft, PIN):
        rated, momentary = (told(datasheet(Reducer(design), 10.0))[key] for key in ("rated_torque", "momentary_torque"))
        assert rated.value <= momentary.value
        assert "safety factor 1" in rated.note
        assert "safety factor 1" in momentary.note


def test_figures_are_those_of_statics_and_solids(sheet) -> None:
    found, expected = told(sheet), static(Reducer(PIN)).quantities
    for key in ("backlash", "lost_motion_ideal", "stiffness_ideal", "efficiency", "back_driving_torque_rated"):
        assert found[key].value == expected[key].value
    low, high = axial_extent(Reducer(PIN))
    assert found["length"].value == pytest.approx(1e3 * (high - low)) == pytest.approx(50.0)
    solids = {name: mass_properties(solid) for name, solid in parts(Reducer(PIN)).items()}
    assert found["mass"].value == pytest.approx(
        sum(one.mass * (36 if name == "pin" else 1) for name, one in solids.items())
    )
    assert all(one.note for one in found.values())


def test_the_inertia_at_the_input_is_that_of_the_energy() -> None:
    """Twice the kinetic energy over the square of the crank's speed, part by part from their motion."""
    solids, speed = {name: mass_properties(solid) for name, solid in parts(Reducer(PIN)).items()}, 7.0
    slow = speed / PIN.lobes
    shaft, gear, output = solids["shaft"], solids["gear"], solids["output"]
    spun = shaft.inertia[2, 2] * speed**2 + shaft.mass * (speed * np.hypot(*shaft.centroid[:2])) ** 2
    rolled = gear.mass * (PIN.gear.eccentricity * speed) ** 2 + gear.inertia[2, 2] * slow**2
    assert input_inertia(Reducer(PIN)) == pytest.approx(
        (spun + rolled + output.inertia[2, 2] * slow**2) / speed**2, rel=1e-9
    )


def test_a_rotating_ring_replaces_the_output() -> None:
    """The discs then orbit without turning, and housing and pins turn by one in N."""
    turned = PIN.but(output={"member": "ring"})
    solids = {name: mass_properties(solid) for name, solid in parts(Reducer(turned)).items()}
    pin = solids["pin"]
    ring = solids["housing"].inertia[2, 2] + 36 * (pin.inertia[2, 2] + pin.mass * PIN.ring.pin_circle_radius**2)
    crank = solids["shaft"].inertia[2, 2] + solids["shaft"].mass * np.sum(solids["shaft"].centroid[:2] ** 2)
    orbit = solids["gear"].mass * PIN.gear.eccentricity**2
    assert input_inertia(Reducer(turned)) == pytest.approx(crank + orbit + ring / 36.0**2, rel=1e-9)


def test_a_cut_is_what_the_plane_meets() -> None:
    hole = np.array([[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]])
    assert cut_prism(Prism(SQUARE, (hole,), 0.0, 1.0)) == [(-2.0, -0.5), (0.5, 2.0)]
    assert cut_prism(Prism(SQUARE, (hole,), 0.0, 1.0), (0.0, 5.0)) == [(3.0, 4.5), (5.5, 7.0)]
    assert cut_prism(Prism(SQUARE, (hole,), 0.0, 1.0), (2.0, 0.0)) == [(-2.0, 2.0)]
    assert cut_prism(Prism(SQUARE, (), 0.0, 1.0), (9.0, 0.0)) == []
    # edges that lie in the plane itself count once
    assert cut_prism(Prism(SQUARE + np.array([3.0, 0.0]), (), 0.0, 1.0)) in ([], [(-2.0, 2.0)])


def test_the_section_of_the_gear_has_its_holes_and_bore() -> None:
    found = cut_prism(parts(Reducer(PIN))["gear"].prisms[0])
    edges = 1e3 * np.array(found).ravel()
    hole = 5.001
    assert edges[1:-1] == pytest.approx([-26 - hole, -26 + hole, -15.001, 15.001, 26 - hole, 26 + hole], abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["twodisc", "large"])
def test_nothing_is_clipped_and_no_text_lies_on_another(sheet, name: str) -> None:
    design = unlike(name) if name in UNLIKE else PRESETS[name]
    pages = datasheet_pages(replace(sheet, design=design))
    for page in pages if name == "twodisc" else pages[1:2]:
        require_separate_texts(page)


@pytest.mark.slow
def test_the_pdf_has_three_pages_and_is_the_same_each_time(sheet) -> None:
    first, second = (document(datasheet_pages(sheet)) for _ in range(2))
    assert first == second
    assert first.startswith(b"%PDF")
    assert len(re.findall(rb"/Type /Page\b", first)) == 3


@pytest.mark.slow
def test_the_page_needs_no_other_file_and_has_every_number(sheet) -> None:
    page = datasheet_page(sheet)
    assert re.findall(r'(?:src|href)="(?!#)([^"]*)"', page) == ["data:,"]
    assert page.count("<svg") == len(datasheet_pictures(sheet)) == 2
    assert "prefers-color-scheme: dark" in page
    for one in told(sheet).values():
        assert f'<td class="value">{format_value(one)}</td>' in page, one


def test_values_are_written_without_powers_of_ten() -> None:
    def of(value: float) -> str:
        return format_value(Quantity("", "", value, ""))

    assert [of(value) for value in (0.01234, 3.0, 123.4, 999.9, 12345.0, math.nan)] == [
        *("0.0123", "3", "123", "1000", "12340"),
        "\N{EN DASH}",
    ]


@pytest.mark.slow
def test_the_command_writes_both_files(sheet, tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.setattr("cycloid_mj.life.datasheet.datasheet", lambda design, life, progress: replace(sheet, life=life))
    assert main(["datasheet", "--design", "pin", "--out", str(tmp_path / "new"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {Path(file).name for file in found["files"]} == {"pin-datasheet.pdf", "pin-datasheet.html"}
    assert all(Path(file).stat().st_size > 10_000 for file in found["files"])
    keys = {"rated_torque", "momentary_torque", "lost_motion_ideal", "stiffness_ideal", "efficiency", "backlash"}
    assert keys | {"mass", "inertia"} <= set(found["quantities"])
    assert found["quantities"]["rated_torque"]["condition"]
    assert found["figures"]["mass_kg"]["value"] == pytest.approx(found["quantities"]["mass"]["value"], rel=1e-3)
    monkeypatch.chdir(tmp_path)
    assert main(["datasheet"]) == 0
    assert (tmp_path / "runs" / "pin-datasheet.pdf").exists()


def test_a_failed_write_and_a_wrong_request_are_reported(tmp_path: Path, capsys) -> None:
    file = tmp_path / "file"
    file.write_text("")
    assert main(["datasheet", "--design", "pin", "--out", str(file)]) == 1
    assert "it is a file" in capsys.readouterr().err
    assert main(["datasheet", "--design", "pin", "--life-h", "-1"]) == 2
    assert "--life-h -1" in capsys.readouterr().err
    assert main(["datasheet", "--design", "pin", "--set", "drive.speed_rpm=0", "--out", str(tmp_path)]) == 1
    assert "drive.speed_rpm is 0" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [file]


def test_a_curve_omits_speeds_without_a_rated_torque(monkeypatch) -> None:
    def borne(reducer, speed, life, guess=0.0, **accuracy):
        if speed > reducer.design.drive.speed:
            raise DesignError("too fast")
        return 100.0 / speed, None

    monkeypatch.setattr("cycloid_mj.life.datasheet.rated_torque", borne)
    found = life_curve(Reducer(PIN), 6000.0)
    assert found.x == pytest.approx([410.0, 820.0, 1230.0, 1640.0])
    assert np.all(np.diff(found.y) < 0.0)


def test_makers_rows_state_units_and_conditions(sheet) -> None:
    """Acceleration torque, hysteresis, torque without load, environment, run-out and tightening torques."""
    rows = told(sheet)
    for key in (
        *("acceleration_torque", "hysteresis_loss", "running_torque_cold", "running_torque_warm"),
        *("starting_torque_drive", "back_driving_torque_drive", "base_oil_viscosity", "ambient_min", "ambient_max"),
        *("duty", "radial_run_out", "axial_run_out", "input_radial_load", "motor_torque"),
    ):
        assert rows[key].note, key
        assert rows[key].unit, key
    assert rows["acceleration_torque"].value <= rows["momentary_torque"].value
    assert rows["backlash"].value < rows["hysteresis_loss"].value < 2.0 * rows["lost_motion_ideal"].value
    assert rows["running_torque_warm"].value < rows["running_torque_cold"].value
    assert rows["starting_torque_drive"].value > 100.0 * rows["starting_torque_nm"].value
    assert rows["back_driving_torque_drive"].value > 35.0 * rows["starting_torque_drive"].value
    hottest = max(thermal(PIN).temperatures.values())
    assert rows["ambient_max"].value == pytest.approx(100.0 - (hottest - 20.0))
    assert rows["ambient_max"].note.endswith("; the parts jam at any ambient temperature")
    tightening = [row for key, row in rows.items() if key.startswith("tightening_")]
    assert {row.unit for row in tightening} == {"N m"}
    assert len(tightening) == 4


def test_a_sheet_states_the_limits_of_the_thermal_command(sheet) -> None:
    """`pin`: 1138 rpm, where its crank reaches 100 °C. By its housing alone it was 1532 rpm."""
    rows, state = told(sheet), thermal(PIN)
    assert state.speed / RPM == pytest.approx(1138.0, rel=5e-3)
    assert rows["continuous_speed_rpm"].value == pytest.approx(state.speed / RPM)
    assert figure("continuous_speed_rpm").value(Reducer(PIN)) == pytest.approx(state.speed / RPM)
    assert rows["thermal_torque"].value == pytest.approx(state.torque)
    paused = thermal(PIN.but(service={"duty_share": 0.25}))
    assert rows["intermittent_speed_rpm"].value == pytest.approx(paused.speed / RPM)
    assert rows["intermittent_speed_rpm"].value < rows["largest_speed_rpm"].value
    hottest = max(state.temperatures.values())
    assert rows["duty"].value == pytest.approx(100.0 * 80.0 / (hottest - 20.0), rel=1e-5)
    assert rows["duty"].note.endswith("limit: 100 °C, grease")


def test_a_paused_drive_jams_beyond_its_intermittent_speed() -> None:
    """The limit of a cycle of 10 minutes, not of its mean temperatures: `nonpin`, a quarter of the time."""
    design = PRESETS["nonpin"].but(service={"duty_share": 0.25})
    limit = figure("intermittent_speed_rpm").value(Reducer(PRESETS["nonpin"])) * RPM
    for share, jams in ((0.97, False), (1.03, True)):
        state = thermal(design, constant_duty(design.rated_torque, share * limit))
        assert state.jams == jams, share


def test_a_rated_torque_beyond_the_thermal_limit_states_it() -> None:
    note = datasheet_module._heat_note(Reducer(PRESETS["twodisc"]), 39.6)
    assert note == f"; more than the thermal torque limit, {thermal('twodisc').torque:.4g} N m"
    assert datasheet_module._heat_note(Reducer(PRESETS["twodisc"]), 30.0) == ""


def test_a_thermal_torque_beyond_the_strength_is_marked() -> None:
    """`printed` would reach 80 °C at 108 N m, but its dowels fail at 23 N m."""
    rows = {row.key: row for row in datasheet_module._thermal_rows(Reducer(PRESETS["printed"]))}
    assert rows["thermal_torque"].value > 100.0
    assert "by heat alone, the momentary torque is 22.85 N m" in rows["thermal_torque"].note


def test_motor_torque_includes_the_losses(sheet) -> None:
    """The motor delivers the nominal torque over ratio and efficiency, not the nominal torque over the ratio alone."""
    rows = told(sheet)
    efficiency = 0.01 * rows["drive_efficiency_percent"].value
    ideal = rows["nominal_torque"].value / rows["ratio"].value
    assert rows["motor_torque"].value == pytest.approx(ideal / efficiency)
    assert f"for {rows['nominal_torque'].value:.4g} N m" in rows["motor_torque"].note


def test_backlash_with_bearings_includes_needles_and_rollers() -> None:
    """Statics with the mean radial play added: HK1210 in F8/h5, (16 + 51)/4 um, and rollers on 4 mm, E8/m6, 10.5 um.

    A pin moves by twice its play, 21 um, at 26 mm at most, so by at least 2.8 arcmin.
    """
    assert not list(backlash_with_bearings(Reducer(PIN)))
    rollers = Reducer(override(PIN, ["output.core_radius_mm=2", "output.roller_bearing=plain"]))
    (row,) = backlash_with_bearings(rollers)
    assert "output 10.5 um (E8/m6)" in row.note
    plain = static(rollers).quantities["backlash"].value
    assert 2.8 < row.value - plain < 3.6
    needles = Reducer(override(PIN, ["gear.bore_radius_mm=8", "shaft.radius_mm=4"]))
    (row,) = backlash_with_bearings(needles)
    assert "cam 16.8 um (F8/h5)" in row.note
    by_hand = needles.but(clearance={"cam": needles.design.clearance.cam + 0.25 * 67e-6})
    assert row.value == pytest.approx(static(by_hand).quantities["backlash"].value)


def test_long_tables_do_not_reach_the_curves(sheet) -> None:
    """With film friction a sheet has 26 rows on its first page, of which the last ran into the titles below."""
    more = tuple(replace(sheet.groups["Speed"][0], key=f"row_{number}", name=f"row {number}") for number in range(8))
    longer = replace(sheet, groups=sheet.groups | {"Speed": sheet.groups["Speed"] + more})
    assert sum(len(longer.groups[key]) for key in longer.groups if key in list(longer.groups)[:4]) >= 26
    require_separate_texts(datasheet_pages(longer)[0])


def test_tiles_state_efficiency_and_mass_of_the_complete_drive(sheet) -> None:
    rows, (page, *_) = told(sheet), datasheet_pages(sheet)
    tiles = [text.get_text() for text in page.texts if text.get_fontsize() == 13]
    assert tiles[-2:] == [format_value(rows[key]) for key in ("drive_efficiency_percent", "drive_mass_kg")]


def test_conditions_are_whole_on_paper_and_on_the_terminal(sheet, capsys, tmp_path: Path) -> None:
    texts = " ".join(text.get_text() for page in datasheet_pages(sheet) for text in page.texts).split()
    for row in told(sheet).values():
        assert not row.note or " ".join(row.note.split()) in " ".join(texts), row.key
    assert main(["datasheet", "pin", "--all", "--out", str(tmp_path)]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "Backlash: perfect parts; without load" in shown


def test_rows_without_seals_and_of_perfect_parts_state_so(sheet) -> None:
    rows = told(sheet)
    for key in ("starting_torque_nm", "no_load_torque_nm", "back_driving_torque_free_nm", "back_driving_torque_rated"):
        assert "without seals, grease and bearings" in rows[key].note
    for key in ("rated_torque", "momentary_torque", "backlash", "stiffness_ideal", "drive_efficiency_percent"):
        assert rows[key].note.startswith("perfect parts")
    assert "perfect" not in rows["mass"].note
    faulty = Reducer(override(sheet.design, {"errors.pin_position_um": 1.0}))
    assert faulty.parts_text == "with the errors of the design"


@pytest.mark.slow
def test_tolerances_lower_the_torques_of_the_sheet() -> None:
    rows = told(datasheet(Reducer(override(PIN, {"tolerance.pin_position": "normal 1"}))))
    for kind in ("rated", "momentary"):
        toleranced = rows[f"{kind}_torque_toleranced"]
        assert toleranced.value < rows[f"{kind}_torque"].value
        assert "95 % percentile of 200 samples" in toleranced.note


def test_a_drive_too_hot_at_any_ambient_temperature_states_none() -> None:
    """The sheet of `twodisc` stated "from -20 °C to -32 °C"."""
    rows = {row.key: row for row in environment_rows(Reducer(PRESETS["twodisc"]))}
    assert "ambient_max" not in rows
    assert rows["duty"].value < 100.0


def test_the_permissible_duty_does_not_depend_on_the_duty_of_the_design() -> None:
    """Half of the time under load heats half as much, and the same share of the time reaches the limit."""
    pin = PRESETS["pin"]
    continuous, paused = (
        {row.key: row for row in environment_rows(Reducer(pin.but(service={"duty_share": share})))}
        for share in (1.0, 0.5)
    )
    assert continuous["duty"].value < 100.0
    assert paused["duty"].value == pytest.approx(continuous["duty"].value)
    rises = [100.0 - rows["ambient_max"].value for rows in (continuous, paused)]
    assert rises[1] == pytest.approx(0.5 * rises[0])
    assert "S1" in continuous["ambient_max"].note
    assert "S3 50 %" in paused["ambient_max"].note


@pytest.mark.slow
def test_a_warm_sheet_states_its_temperature() -> None:
    parts = ("disc", "ring", "crank", "output", "housing")
    warm = datasheet(Reducer(override(PIN, [f"thermal.{part}_c=60" for part in parts])))
    assert "Temperature of the parts: 60 °C, unless a row states another." in warm.notes
