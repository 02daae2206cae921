"""The data sheet of an RV reducer: rows with their conditions, from rating, statics, heat and parts."""

import json
from pathlib import Path

import numpy as np
import pytest
from page_texts import require_separate_texts
from rv_runs import COULOMB_RV80E

from cycloid_mj.base.result import Quantity
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, override
from cycloid_mj.life import rate
from cycloid_mj.life.datasheet import Datasheet, axial_extent, datasheet
from cycloid_mj.life.duty import constant_duty
from cycloid_mj.life.rated import rated_torque
from cycloid_mj.life.rv_sheet_rows import compute_rv_limits, rv_wind_up_curve, toleranced_error_rows
from cycloid_mj.life.thermal import thermal
from cycloid_mj.parts import input_inertia, mass_properties
from cycloid_mj.parts.export.rv_assembly import place_rv_parts, rv_assembly_parts, rv_mass
from cycloid_mj.parts.polygon import rotate_points
from cycloid_mj.parts.rv import NEEDLE
from cycloid_mj.plots.datasheet import datasheet_pages, format_value
from cycloid_mj.plots.save import document
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.report.datasheet import datasheet_page
from cycloid_mj.statics.sheet import sheet as static_sheet

RV80E = COULOMB_RV80E
FILM_ROWS = {
    *("no_load_torque_nm", "starting_torque_nm"),
    *("running_torque_cold", "running_torque_warm", "starting_torque_drive"),
}
TOLERANCES = {
    "crank_tolerance.bore_position": "uniform 4",
    "crank_tolerance.carrier_position": "uniform 4",
    "crank_tolerance.eccentricity": "uniform 3",
    "crank_tolerance.phase": "uniform 3",
    "crank_tolerance.planet_runout": "uniform 5",
}


def rows_of(sheet: Datasheet) -> dict[str, Quantity]:
    return {row.key: row for group in sheet.groups.values() for row in group}


@pytest.fixture(scope="module")
def sheet() -> Datasheet:
    return datasheet(RvReducer(RV80E))


def test_the_weakest_item_lasts_the_required_life_at_the_rated_torque() -> None:
    limits = compute_rv_limits(RvReducer(RV80E), 6000.0)
    torque, weakest = limits.rated
    assert (weakest.key, limits.bearings[1].key) == ("pin_gear_pitting", "crank_tapers")
    assert torque == pytest.approx(801.8, rel=1e-3)
    items = rate(RV80E, constant_duty(torque, RV80E.drive.speed)).items
    lives = {key: item.life for key, item in items.items() if item.life is not None}
    assert min(lives.values()) == lives["pin_gear_pitting"] == pytest.approx(6000.0, rel=0.01)


def test_bearing_torque_follows_the_exponent_of_iso_281() -> None:
    life = rate(RV80E).items["crank_tapers"].life
    assert life is not None
    bearing_torque = compute_rv_limits(RvReducer(RV80E), 6000.0).bearings[0]
    assert bearing_torque == pytest.approx(784.0 * (life / 6000.0) ** 0.3, rel=2e-3)


def test_momentary_torque_is_that_of_the_smallest_safety_at_twice_the_nominal_torque() -> None:
    items = rate(RV80E).items
    safeties = [items[key].safety or 0.0 for key in ("crank_needles_static", "crank_tapers_static", "pin_gear_yield")]
    momentary = compute_rv_limits(RvReducer(RV80E), 6000.0).momentary[0]
    assert momentary == pytest.approx(2.0 * 784.0 * min(safeties))
    assert momentary == pytest.approx(4697.0, rel=1e-3)


@pytest.mark.parametrize(("member", "inertia"), [("carrier", 0.368), ("ring", 0.391)])
def test_inertia_at_the_sun_is_that_of_the_energy(member: str, inertia: float) -> None:
    """Twice the kinetic energy of all drawn parts but needles, from their places at two angles, over the square."""
    reducer = RvReducer(RV80E.but(output={"member": member}))
    step = 1e-5
    parts = rv_assembly_parts(reducer)
    masses = {name: mass_properties(part.solid(2e-5)) for name, part in parts.items() if name != NEEDLE}
    energy, sun = 0.0, 0.0
    fixed = "carrier_1" if member == "ring" else "housing"
    before, after = ([*place_rv_parts(reducer, angle)] for angle in (0.0, step))
    turned = next(b.angle - a.angle for a, b in zip(before, after, strict=True) if a.part == fixed)
    for first, second in zip(before, after, strict=True):
        if first.part == "sun":
            sun = second.angle - first.angle - turned
        if first.part not in masses:
            continue
        mass = masses[first.part]
        places = [
            rotate_points(rotate_points(mass.centroid[np.newaxis, :2], place.angle) + place.origin[:2], -back)[0]
            for place, back in ((first, 0.0), (second, turned))
        ]
        path, turn = places[1] - places[0], second.angle - first.angle - turned
        energy += mass.mass * float(path @ path) + float(mass.inertia[2, 2]) * turn**2
    assert input_inertia(reducer) == pytest.approx(energy / sun**2, rel=2e-3)
    assert 1e4 * input_inertia(reducer) == pytest.approx(inertia, abs=0.001)


def test_length_is_that_of_planets_carrier_and_gaps() -> None:
    low, high = axial_extent(RvReducer(RV80E))
    planet, flanges, discs, gaps = 12.0, 2.0 * 18.0, 32.0, 3.0
    assert 1e3 * (high - low) == pytest.approx(planet + flanges + discs + gaps)


def test_toleranced_parts_have_the_transmission_error_of_the_tolerance_study() -> None:
    """docs/rv-forces.md: 3 to 23 arcsec for 90 % of the samples."""
    assert toleranced_error_rows(RvReducer(RV80E)) == ()
    (row,) = toleranced_error_rows(RvReducer(override(RV80E, TOLERANCES)))
    assert row.value == pytest.approx(23.0, abs=1.0)
    assert "95 % percentile of 2000 samples" in row.note


@pytest.mark.parametrize("speed", [2295.0, -2295.0])
def test_the_output_turns_with_the_stiffness_of_statics(speed: float) -> None:
    design = override(RV80E, {"drive.speed_rpm": speed})
    curve = rv_wind_up_curve(RvReducer(design), (0.5, 1.0))
    slope = np.diff(curve.y)[[0, -1]].mean() / (0.5 * RV80E.rated_torque)
    assert 1.0 / slope == pytest.approx(208.2, rel=1e-3)


def test_errors_of_cranks_and_carrier_are_stated() -> None:
    assert reducer_of(RV80E).parts_text == "perfect"
    for key, value in (("crank_errors.axis_x_um", 1.0), ("crank_errors.bore_x_um", [0, 2, 0, 0, 0, 0])):
        assert reducer_of(override(RV80E, {key: value})).parts_text == "with the errors of the design"


@pytest.mark.slow
def test_figures_are_those_of_statics_and_parts(sheet: Datasheet) -> None:
    rows, statics = rows_of(sheet), static_sheet(RvReducer(RV80E), RV80E.rated_torque).quantities
    for key in ("backlash", "lost_motion_ideal", "stiffness_ideal", "efficiency"):
        assert rows[key].value == statics[key].value
    assert rows["mass"].value == pytest.approx(rv_mass(RvReducer(RV80E)))
    assert rows["ratio"].value == 153.0
    assert rows["output_speed"].value == pytest.approx(15.0)
    at_limit = thermal(RV80E, constant_duty(rows["thermal_torque"].value, RV80E.drive.speed))
    assert max(at_limit.temperatures.values()) == pytest.approx(100.0, abs=0.2), "limit of the grease [°C]"
    assert rows["duty"].value == pytest.approx(8000.0 / (rows["temperature_rise"].value + 20.1), rel=2e-3)
    assert all(row.note for row in rows.values())
    assert not FILM_ROWS & set(rows)
    assert any("Not computed" in note and "main bearings" in note for note in sheet.notes)


@pytest.mark.slow
def test_backlash_and_lost_motion_state_the_play_that_they_assume(sheet: Datasheet) -> None:
    for key in ("backlash", "lost_motion_ideal"):
        note = rows_of(sheet)[key].note
        assert note.startswith("perfect parts; ")
        assert note.endswith("; play of the planet teeth 0 um, of the crank bearings 0 um")


def test_keys_and_units_are_those_of_a_drive_with_a_central_crank(sheet: Datasheet) -> None:
    rows, others = rows_of(sheet), rows_of(datasheet(Reducer(PRESETS["pin"])))
    assert set(rows) - set(others) == {"output_speed"}
    assert {key: row.unit for key, row in rows.items() if key in others and row.unit != others[key].unit} == {}
    assert set(sheet.as_json()) == set(datasheet(Reducer(PRESETS["pin"])).as_json())


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes", [{}, {"friction": {"law": "film", "lubricant": "lithium grease 100"}}], ids=["coulomb", "film"]
)
def test_pages_have_every_number_and_nothing_is_clipped(sheet: Datasheet, changes: dict[str, dict[str, str]]) -> None:
    result = datasheet(RvReducer(RV80E.but(**changes))) if changes else sheet
    rows = rows_of(result)
    assert set(rows) >= FILM_ROWS if changes else not FILM_ROWS & set(rows)
    pages = datasheet_pages(result)
    for page in pages:
        require_separate_texts(page)
    assert document(pages).startswith(b"%PDF")
    html = datasheet_page(result)
    assert "RV reducer with ring pins, 3 cranks, 2 discs" in html
    assert "153 : 1" in html
    for row in rows.values():
        assert f'<td class="value">{format_value(row)}</td>' in html, row
    if changes:
        cold, warm, start = (
            rows[key] for key in ("running_torque_cold", "running_torque_warm", "starting_torque_drive")
        )
        assert cold.value == pytest.approx(0.094, abs=0.001)
        assert warm.value == pytest.approx(0.031, abs=0.001)
        assert start.value < warm.value
        for row in (cold, warm, start):
            assert row.low is not None
            assert row.high is not None
            assert row.low < row.value < row.high


@pytest.mark.slow
def test_two_cranks_and_a_rotating_ring_have_a_sheet() -> None:
    result = datasheet(RvReducer(PRESETS["rv64"].but(output={"member": "ring"}, cranks={"count": 2})))
    for page in datasheet_pages(result):
        require_separate_texts(page)
    assert all(np.isfinite(row.value) for row in rows_of(result).values())
    assert rows_of(result)["ratio"].value == 120.0


@pytest.mark.slow
def test_the_command_writes_all_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["datasheet", "rv80e", "--out", str(tmp_path / "new"), "--life-h", "3000", "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["life_h"] == 3000.0
    assert content["weakest"]["key"] == "pin_gear_pitting_lubricated"
    # AGMA 2001-D04: the permissible pressure follows n^-0.056 for n loads, and the torque its square. For 6000 h, the
    # tapered bearings limit the torque, so the pitting of the teeth is rated alone.
    torque, rv80e = content["rated_torque_nm"], PRESETS["rv80e"]
    reducer, pitting = RvReducer(rv80e), content["weakest"]["key"]
    full_life = rated_torque(reducer, rv80e.drive.speed, 6000.0, lambda key: key == pitting)[0]
    assert torque == pytest.approx(full_life * 2.0 ** (2.0 * 0.056), rel=5e-3)
    assert compute_rv_limits(reducer, 6000.0).rated[1].key == "crank_tapers_modified"
    # ISO 6336-2: the lubricant (130 mm2/s, 0.38 m/s, Rz10 2.15 um) multiplies the permissible pressure by Z_L Z_v Z_R
    items = rate(rv80e, constant_duty(torque, rv80e.drive.speed)).items
    dry, lubricated = (items[f"pin_gear_pitting{suffix}"] for suffix in ("", "_lubricated"))
    factors = lubricated.limit / dry.limit
    by_hand = (0.91 + 0.36 / (1.2 + 134.0 / 130.0) ** 2) * (0.93 + 0.14 / (0.8 + 32.0 / 0.38) ** 0.5)
    assert factors == pytest.approx(by_hand * (3.0 / 2.15) ** 0.08, rel=1e-3)
    assert dry.life * factors ** (1.0 / 0.056) == pytest.approx(3000.0, rel=0.01)
    names = {path.name for path in (tmp_path / "new").iterdir()}
    assert names >= {"rv80e-datasheet.pdf", "rv80e-datasheet.html", "rv80e-datasheet.csv"}
