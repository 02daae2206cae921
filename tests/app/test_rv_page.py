"""RV reducers on the designer's page: in a real browser, and what the server returns for them."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from app_walk import SEARCH_SECONDS, serving, tab_to, wait_for_result
from browser import CHROMIUM, MISSING, OVERHANG, Tab, tab

from cycloid_mj.app import artifacts, monte_carlo, part_stress, requirement, solid, summary
from cycloid_mj.app.api import checks, draw, error, find, forces, open_design, remedies
from cycloid_mj.app.controls import controls
from cycloid_mj.app.drive import BuildOptions
from cycloid_mj.app.state import apply_changes, changed_values, parse_design
from cycloid_mj.base.array import Array, rotate
from cycloid_mj.base.errors import DesignError, UsageError
from cycloid_mj.design import PRESETS, dump, value_of
from cycloid_mj.explore.rv_samples import ERRORS
from cycloid_mj.explore.tolerances import tolerance
from cycloid_mj.figures import figure
from cycloid_mj.parts.export.rv_assembly import place_rv_parts
from cycloid_mj.reducer import RvReducer
from cycloid_mj.sizing.rv import DUTY_SHARE, RvRequirement
from cycloid_mj.statics.rv_sheet import solve_running_equilibrium
from cycloid_mj.stress.rv_strength import compute_rv_strength
from cycloid_mj.stress.study import QUICK

RV = {"layout": "rv"}
FORM = {"layout": "rv", "ratio": 121, "diameter_mm": 160, "torque_nm": 412}


@pytest.mark.parametrize("name", ["rv80e", "rv64"])
def test_a_design_is_its_values_and_back(name: str) -> None:
    design = PRESETS[name]
    values = changed_values(design)
    assert values["layout"] == "rv"
    assert parse_design(values) == design
    shown = open_design({"text": dump(design), "name": "my.toml"})
    assert shown["name"] == name
    assert shown["head"]["ratio"] == design.reduction
    assert shown["errors"] == []


def test_controls_have_the_tables_of_an_rv_reducer_within_their_bounds() -> None:
    design = parse_design(RV)
    shown = {control.key: control for control in controls(design)}
    assert {"planet.sun_teeth", "planet.module_mm", "cranks.eccentric_radius_mm", "drive.speed_rpm"} <= shown.keys()
    assert not {key for key in shown if key.split(".")[0] in ("shaft", "springs")}
    assert "output.pins" not in shown
    assert dict(shown["cranks.count"].options) == {2: "two", 3: "three"}
    assert shown["planet.module_mm"].unit == "mm"
    assert shown["cranks.needle_clearance_um"].low < 0.0 < shown["cranks.needle_clearance_um"].high
    assert shown["planet.sun_teeth"].low == 5
    for control in shown.values():
        assert control.value == value_of(design, control.key)
        assert control.options or control.low <= control.value <= control.high
    found = {control["key"] for control in find({"design": RV, "text": "stiffness"})["controls"]}
    assert {"cranks.taper_stiffness_n_m", "planet.mesh_stiffness_n_m"} <= found
    assert "stiffness.cam_n_m" not in found


def test_a_change_of_teeth_keeps_the_load_and_adapts_the_torque_of_the_sun() -> None:
    design = apply_changes(parse_design(RV), {"ring.teeth": 36.0, "cranks.count": 2})
    assert (design.ring.teeth, design.reduction) == (36, 1 + 36 * 38 / 10)
    assert design.load.torque == 784.0
    assert design.drive.torque * design.reduction == pytest.approx(784.0)


def test_planets_that_do_not_mesh_are_reported_with_remedies() -> None:
    shown = draw({"design": RV, "changes": {"planet.planet_teeth": 37}})
    (problem,) = shown["errors"]
    assert problem["name"] == "planets mesh"
    assert [change["changes"] for change in problem["changes"]] == [
        {"planet.planet_teeth": 38.0},
        {"planet.planet_teeth": 35.0},
    ]
    crossed = draw({"design": RV, "changes": {"gear.eccentricity_mm": 2.5}})
    assert not crossed["section"]["whole"]
    assert len(crossed["section"]["discs"]) == 2


def test_the_section_has_cranks_posts_and_planets_at_their_places() -> None:
    shown = draw({"design": RV})["section"]
    reducer = RvReducer(PRESETS["rv80e"])
    assert np.allclose(1e-3 * np.array(shown["cranks"]), reducer.stage.crank_positions([0.0])[0])
    assert len(shown["posts"]) == 3
    assert shown["sun_rate"] == pytest.approx(-153.0 / 39.0)
    assert np.hypot(*np.array(shown["planet"]).T).max() > np.hypot(*np.array(shown["sun"]).T).max()


def test_forces_are_those_of_statics_and_balance_each_disc() -> None:
    found: dict[str, Any] = forces({"design": RV})
    running = solve_running_equilibrium(RvReducer(PRESETS["rv80e"]), 784.0)
    for kind, largest in (("teeth", running.pins.max()), ("output", running.bearings.max())):
        assert np.max(found[kind]["force"]) == pytest.approx(largest, rel=5e-3)
    total = sum(
        np.sum(np.array(found[kind]["force"])[..., np.newaxis] * np.array(found[kind]["direction"]), axis=2)
        for kind in ("teeth", "output")
    )
    # the rest is friction, which is not drawn
    assert np.abs(total).max() < 0.15 * np.max(found["output"]["force"])
    assert np.allclose(np.sum(found["share"], axis=1), 1.0, atol=2e-4)
    assert found["words"] == {"teeth": "tooth", "output": "crank"}


@pytest.mark.slow
def test_results_are_those_of_statics_and_rating() -> None:
    reducer = RvReducer(PRESETS["rv80e"])
    static, rated = summary.statics(reducer), summary.life(reducer, {"diameter_mm": 190, "length_mm": 80})
    rows = {row["name"]: row["value"] for row in static["rows"]}
    assert rows["Torsional stiffness"] == f"{figure('stiffness_nm_per_arcmin').value(reducer):.4g} N m/arcmin"
    lost = sum(part["watts"] for part in static["losses"]["parts"])
    assert lost == pytest.approx(static["losses"]["input_power"] - static["losses"]["output_power"], rel=0.01)
    assert rated["length_mm"] == pytest.approx(83.0)
    assert [rated["verdicts"][key]["judgement"] for key in ("diameter_mm", "length_mm")] == ["passed", "failed"]
    found = error({"design": RV})
    assert found["curves"][0]["peak_to_peak"] == pytest.approx(figure("te_ideal_arcsec").value(reducer), rel=0.05)
    assert [name for _, name in found["named"]] == ["mesh", "2 x mesh", "cranks", "planet mesh"]


@pytest.mark.slow
def test_a_rotating_ring_has_the_order_of_its_run_out() -> None:
    found = error({"design": {**RV, "output": {"member": "ring"}, "crank_errors": {"output_x_um": 10}}})
    sizes = dict(zip(found["orders"], found["amplitudes"], strict=True))
    assert sizes[0.025] == max(sizes.values()) == pytest.approx(26.6, abs=0.1)
    assert [0.025, "run-out of the output"] in found["named"]


def test_files_are_those_that_an_rv_reducer_has() -> None:
    offered = open_design({"preset": "rv80e"})["files"]
    assert "3mf" not in offered
    made = artifacts.create_files(lambda _: None, RV, "dxf")
    assert list(made.files) == ["rv80e-dxf.zip"]
    for kind in ("3mf", "drive"):
        with pytest.raises(DesignError, match="no covers"):
            artifacts.create_files(lambda _: None, RV, kind)


def test_the_3d_view_moves_each_part_as_the_assembly_does() -> None:
    reducer, crank = RvReducer(PRESETS["rv80e"]), 0.7
    shown = solid.assembly_meshes(reducer, BuildOptions())
    copies = {part["name"]: part["copies"] for part in shown["parts"]}
    assert {name: len(places) for name, places in copies.items() if len(places) > 1} == {
        **{"pin": 40, "crank": 3, "planet": 3, "needle": 84, "tapered bearing": 6}
    }
    placed: dict[str, list[Any]] = {}
    for component in place_rv_parts(reducer, crank):
        placed.setdefault(component.part.replace("_", " "), []).append(component)
    for name, places in copies.items():
        for copy, component in zip(places, placed[name], strict=True):
            spin, carry = (crank * rate for rate in shown["motions"][copy["moves"]])
            at, axis = np.array(copy["at"]), np.array([*copy["axis"], 0.0])
            assert turned(spin, at) + turned(carry, axis) == pytest.approx(1e3 * np.array(component.origin), abs=3e-4)
            assert np.exp(1j * (copy["angle"] + spin)) == pytest.approx(np.exp(1j * component.angle), abs=1e-9)
    assert shown["steps"] == []
    assert "no steps of assembly" in shown["reason"]


def turned(angle: float, place: Array) -> Array:
    """Rotate a place (x, y, z) about z."""
    return np.append(rotate(place[np.newaxis, :2], angle)[0], place[2])


def test_tolerances_are_those_of_the_closed_form() -> None:
    found = monte_carlo.study_tolerances(lambda _: None, {**RV, "crank_tolerance.bore_position": "uniform 4"}, None)
    study = tolerance(PRESETS["rv80e"].but(crank_tolerance={"bore_position": "uniform 4"}), found["samples"])
    (chart,) = found["charts"]
    assert sum(chart["counts"]) == found["samples"] == monte_carlo.STUDY.samples
    assert chart["p95"] == pytest.approx(study.distributions["te_errors_arcsec"].p95)
    assert found["budget"] == [{"source": "bore_position", "share": 1.0}]
    assert "closed form" in found["condition"]
    spread = monte_carlo.study_tolerances(lambda _: None, RV, 4)
    assert {share["source"] for share in spread["budget"]} == set(ERRORS) - {"pin_position"}
    with pytest.raises(UsageError, match=r"\[crank_tolerance\]"):
        monte_carlo.study_tolerances(lambda _: None, RV, None)
    assert not open_design({"preset": "rv80e"})["toleranced"]
    assert draw({"design": RV, "changes": {"crank_tolerance.phase": "uniform 4"}})["toleranced"]


def test_stress_of_cranks_and_gears_is_next_to_that_by_finite_elements(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = SimpleNamespace(name="stress", definition="largest", value=lambda _: 100.0)
    monkeypatch.setattr(part_stress, "figure", lambda _: entry)
    found = part_stress.stress(lambda _: None, RV)
    parts = {part["name"]: part for part in found["parts"]}
    assert list(parts) == ["sun", "disc", "cranks", "planets", "ring pins", "ring"]
    strength = compute_rv_strength(RvReducer(PRESETS["rv80e"]), QUICK.turn).largest
    assert parts["cranks"]["bulk"][0]["text"].startswith(f"{1e-6 * strength['crank']:.3g} of ")
    assert parts["planets"]["bulk"][0]["text"].startswith(f"{1e-6 * strength['planet']:.3g} of ")
    assert [row["name"] for row in parts["sun"]["rated"]] == [
        *("sun on planets, pitting with the lubricant", "sun on planets, pitting")
    ]
    assert "teeth on pins, pitting" in [row["name"] for row in parts["disc"]["rated"]]


@pytest.mark.slow
def test_warnings_of_heat_and_life_have_changes_that_resolve_them() -> None:
    """Each change passes alone when it is applied on the page."""
    failed = {check["name"]: check for check in checks({"design": RV})["failed"]}
    assert set(failed) == {"heat", "life"}
    assert not any(check["remedy"] for check in failed.values())
    keys: dict[str, set[str]] = {name: set() for name in failed}
    for name in failed:
        for change in remedies({"design": RV, "check": name})["changes"]:
            keys[name] |= change["changes"].keys()
            if name == "life":
                changed = draw({"design": RV, "changes": change["changes"]})["design"]
                assert name not in {check["name"] for check in checks({"design": changed})["failed"]}
    assert keys == {
        "heat": {"load.torque_nm", "drive.speed_rpm", "service.duty_share"},
        "life": {"load.torque_nm", "service.life_h"},  # a wider disc does not relieve the tapered bearings
    }


def test_a_form_becomes_a_requirement_of_an_rv_reducer_and_back() -> None:
    parsed = requirement.parse_form({**FORM, "process": "printed", "backlash_arcmin": 1})
    assert isinstance(parsed, RvRequirement)
    assert parsed.duty_share == DUTY_SHARE
    assert requirement.parse_form(requirement.fill_form(parsed)) == parsed
    assert requirement.fill_form(parsed)["speed_rpm"] == pytest.approx(15.0 * 121)
    with pytest.raises(UsageError, match="from 31 to 321"):
        requirement.parse_form({**FORM, "ratio": 15})
    with pytest.raises(UsageError, match="unknown layout"):
        requirement.parse_form({**FORM, "layout": "two"})


@pytest.fixture(scope="module")
def page() -> Iterator[Tab]:
    """Search for an RV reducer by the requirement form, and choose it."""
    with serving() as address, tab() as one:
        one.screen(1400, 950)
        one.go(address)
        one.wait("document.querySelector('#start')?.open", "the start form opens by itself")
        one.run("document.querySelector('#start [name=discs][value=rv]').click()")
        for key in ("ratio", "diameter_mm", "torque_nm"):
            one.run(f"document.querySelector('#start [name={key}]').select()")
            one.type(str(FORM[key]))
        assert one.run("document.querySelector('#start [name=duty_percent]').value") == "40"
        assert one.run("document.querySelector('#start [name=process]').closest('fieldset').hidden")
        tab_to(one, "#start [type=submit]")
        one.key("Enter")
        one.wait("document.querySelector('.drives .first button')", "a drive", SEARCH_SECONDS)
        one.click(".drives .first button")
        one.wait("!document.querySelector('#start').open", "the form closes")
        wait_for_result(one)
        yield one


BROWSER = [pytest.mark.slow, pytest.mark.skipif(not CHROMIUM, reason=MISSING)]


def head(page: Tab) -> str:
    return str(page.run("document.querySelector('#head').innerText"))


def set_value(page: Tab, key: str, value: str) -> None:
    page.run(f"document.querySelector('[data-key=\"{key}\"] [type=number]').select()")
    page.type(value)
    page.key("Enter")


class TestInTheBrowser:
    """The page of an RV reducer that the requirement form has found."""

    pytestmark = BROWSER

    def test_the_form_leads_to_a_drive_that_meets_the_requirements(self, page: Tab) -> None:
        assert head(page).startswith("121:1 ✓")
        assert not page.run("document.querySelectorAll('#head .fails').length")
        assert not page.errors

    def test_a_slider_changes_the_drive(self, page: Tab) -> None:
        before = head(page)
        set_value(page, "gear.face_width_mm", "12")
        page.wait(f"document.querySelector('#head').innerText !== {before!r}", "the header changes")
        wait_for_result(page)
        assert "gear.face_width_mm=12" in page.run("location.hash") or page.listen(0.5) is None
        page.wait("location.hash.includes('gear.face_width_mm=12')", "the address has the value")
        assert "layout=rv" in page.run("location.hash")
        assert not page.errors

    def test_planets_that_do_not_mesh_are_mended_by_a_button(self, page: Tab) -> None:
        teeth = int(page.run("document.querySelector('[data-key=\"planet.planet_teeth\"] [type=number]').value"))
        set_value(page, "planet.planet_teeth", str(teeth + 1))
        page.wait("!document.querySelector('#wrong').hidden", "the planets do not mesh")
        page.click("#wrong .remedy")
        page.wait("document.querySelector('#wrong').hidden", "a button mends it")
        wait_for_result(page)
        assert not page.errors

    def test_tabs_show_results(self, page: Tab) -> None:
        tabs = "[...document.querySelectorAll('[role=tab]')].filter(e => !e.hidden).map(e => e.innerText)"
        studies = {"Tolerances": "Run Monte Carlo", "Stress": "Compute stresses"}
        assert page.run(tabs) == [
            *("Figures", "Loads", "Accuracy", "Losses", "Life", "Tolerances", "Stress", "3-D", "A | B", "Export")
        ]
        for name in page.run(tabs):
            page.click("[role=tab]", name)
            if name in studies:
                page.click("#panel button", studies[name])
                page.wait(
                    "document.querySelector('#panel .lying') && !document.querySelector('#panel progress')", name, 900.0
                )
            page.wait("!document.querySelector('#panel .waits')", f"results of {name}", 400.0)
            assert not page.run("document.querySelectorAll('#panel .fails:not(b)').length") or name == "Life", name
        assert page.run("document.querySelectorAll('#panel .make button').length") == 7
        page.click("[role=tab]", "Figures")
        assert not page.errors

    def test_nothing_hangs_over_a_narrow_screen(self, page: Tab) -> None:
        page.screen(390, 844)
        assert page.run(OVERHANG) == []
        page.screen(1400, 950)
