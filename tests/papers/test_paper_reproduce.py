"""The stages, claims and page of `reproduce` on runs with known waves; README and JSON; both designs alike."""

import csv
import gc
import json
import math
import re
import tomllib
import weakref
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace

import docs_results
import numpy as np
import pytest
from docs_page import replace_sections
from given import Given, ideal_runs
from hsieh2014 import command, cycle, motion, plan
from hsieh2014 import run as stages
from hsieh2014.authors import CHANGES, brought_by
from hsieh2014.command import ReproduceDelivery
from hsieh2014.errata import errata
from hsieh2014.logs import KEPT, Logs, fits, log_name
from hsieh2014.page import TALLY as PAGE_TALLY
from hsieh2014.plan import FULL, QUICK, at_speed, idle_runs, main_runs, ramp_run, rated_runs
from hsieh2014.plan import varied_idle_runs as varied_idle
from hsieh2014.plan import varied_rated_runs as varied_rated
from hsieh2014.stage import StageResult, silent
from hsieh2014.stated import TORQUES
from ideal import ideal_run

from cycloid_mj.base.errors import CycloidError, RunError, UsageError
from cycloid_mj.comparison import STARTS, gravity_turn, settle_run, settling_time, start_variant
from cycloid_mj.comparison.conditions import differences
from cycloid_mj.design import PRESETS, dump, override
from cycloid_mj.dynamics.run import schedule
from cycloid_mj.dynamics.timestep import step_limits
from cycloid_mj.reducer import Reducer

ROOT = Path(__file__).parents[2]
# --- the two designs under one rule


def test_the_presets_differ_in_name_and_ring_kind_alone():
    pin, nonpin = (tomllib.loads(dump(PRESETS[name])) for name in ("pin", "nonpin"))
    assert (pin.pop("name"), nonpin.pop("name")) == ("pin", "nonpin")
    assert (pin["ring"].pop("kind"), nonpin["ring"].pop("kind")) == ("pin", "nonpin")
    assert pin == nonpin


def test_values_implied_by_the_ring_are_equal():
    # pairs that stand for each other have the same friction, clearance, stiffness, damping and working force
    design = PRESETS["pin"]
    for table in ("friction", "clearance", "stiffness", "damping", "working_force"):
        values = getattr(design, table)
        assert values.pin_gear == values.tooth, table
        assert values.pin_socket == values.tooth, table


@pytest.mark.parametrize("which", [QUICK, pytest.param(FULL, marks=pytest.mark.slow)])
def test_runs_of_both_designs_differ_in_the_ring_only(which):
    pin, nonpin = plan.designs()
    pairs = list(zip(main_runs(which)[::2], main_runs(which)[1::2], strict=True))
    pairs += list(zip(idle_runs(which, pin), idle_runs(which, nonpin), strict=True))
    pairs += [tuple(rated_runs(which)[:2]), tuple(ramp_run(which, design) for design in plan.designs())]
    for each in plan.variations(which):
        if not each.pins_only:
            pairs += zip(varied_idle(which, each, pin), varied_idle(which, each, nonpin), strict=True)
            pairs.append(tuple(varied_rated(which, each)))
    for one, other in pairs:
        assert list(differences([one, other])) == ["ring.kind"]
        assert one.load == other.load
    spoiled = override(PRESETS["nonpin"], ["friction.tooth=0.04"])
    assert "friction.tooth" in differences([PRESETS["pin"], spoiled])


def test_the_third_rated_design_has_the_play_and_stiffness_of_the_pin_design():
    pin, nonpin, third = rated_runs(QUICK)
    assert third.ring.kind == "nonpin"
    assert set(differences([nonpin, third])) == {"clearance.tooth_um", "stiffness.tooth_n_m"}
    assert third.clearance.tooth == pytest.approx(pin.clearance.pin_gear + pin.clearance.pin_socket)
    # At the load of these runs; at none the springs are 0.7 times as stiff.
    assert third.stiffness.tooth == pytest.approx(Reducer(pin).contacts.mesh_stiffness, rel=1e-9)


# --- independent starts


def test_starts_turn_gravity_by_whole_tooth_pitches():
    design = at_speed(PRESETS["pin"], 0.0, 1)
    found = [start_variant(Reducer(design), number) for number in range(STARTS)]
    assert found[0] == design
    assert len(set(found)) == STARTS >= 8
    pitches = [gravity_turn(Reducer(each)) / (2 * np.pi / 36) for each in found]
    assert pitches == pytest.approx(np.round(pitches), abs=1e-9)
    assert np.diff(pitches) == pytest.approx(4.5, abs=0.5 + 1e-9)
    for each in found:
        pull = each.environment
        assert math.hypot(pull.gravity_x, pull.gravity_y) == pytest.approx(9.8)
        assert differences([design, each]).keys() <= {"environment.gravity_x_m_s2", "environment.gravity_y_m_s2"}


# --- the paper's sampling


@pytest.mark.parametrize("design", plan.designs(), ids=["pin", "nonpin"])
def test_samples_fall_on_whole_degrees(design):
    run = schedule(Reducer(at_speed(design, 0.0, 4)))
    assert run.stride == QUICK.steps
    sample = plan.SAMPLES.logged * run.stride * run.timestep
    assert sample == pytest.approx(0.000101626, abs=5e-10)
    assert np.degrees(design.drive.speed * sample) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("which", [QUICK, pytest.param(FULL, marks=pytest.mark.slow)])
def test_no_step_is_longer_than_its_design_states(which):
    runs = [*main_runs(which), *rated_runs(which), *(ramp_run(which, design) for design in plan.designs())]
    runs += [run for one in plan.variations(which) for of in plan.designs() for run in varied_idle(which, one, of)]
    for run in dict.fromkeys(runs):
        assert schedule(Reducer(run)).timestep <= min(step_limits(Reducer(run)).values()), run.name


def test_half_the_step_keeps_the_samples():
    coarse, fine = (schedule(Reducer(at_speed(PRESETS["pin"], 0.0, 4, finer * QUICK.steps))) for finer in (1, 2))
    assert fine.stride * fine.timestep == pytest.approx(coarse.stride * coarse.timestep, rel=1e-12)
    assert fine.timestep == pytest.approx(coarse.timestep / 2, rel=1e-12)


def test_figures_show_one_turn_of_360_samples():
    found = motion.motions(replace(QUICK, turns=2), ideal_runs)[0]
    shown = motion.at_degrees(found)
    turn = shown.one_turn
    assert turn.stop - turn.start in (360, 361)
    degrees = np.degrees(shown.crank_angle[turn])
    assert degrees == pytest.approx(np.round(degrees), abs=1e-6)


def test_the_ramp_is_the_papers():
    design = ramp_run(FULL, PRESETS["pin"])
    assert (design.drive.ramp, design.load.torque) == (1.0, 0.0)
    assert design.drive.hold > settling_time(Reducer(design))


# --- stages


def test_the_cycle_of_pin_1_follows_its_force():
    design = at_speed(PRESETS["pin"], 36.0, 2)
    run = ideal_run(design)
    # from 300 deg over 0 to 60 deg, and a touch at 180 deg, which is not the cycle
    turned = np.degrees(run["crank_angle"]) % 360.0
    force = np.where((turned > 299.8) | (turned < 59.8), 50.0, 0.0) + np.where(np.abs(turned - 180.0) < 2.0, 20.0, 0.0)
    pressed = replace(run, columns={**run.columns, "pin_1_force_x": force})
    start, end, share, count = cycle.cycle(settle_run(pressed))
    assert (start, end) == (pytest.approx(300.0), pytest.approx(60.0))
    assert share == pytest.approx(100.0 * 123.5 / 360, abs=0.3)
    assert count == pytest.approx(123.5 / 360, abs=0.003)
    table = cycle.cycle_table({"as it is": [pressed, ideal_run(at_speed(PRESETS["nonpin"], 36.0, 2))]})
    assert [row[0] for row in table.rows] == ["as it is"]


# --- stages, one of which may break


def test_a_failed_stage_is_reported_and_the_others_are_complete(tmp_path, monkeypatch, capsys):
    def breaks(which, runs, told):
        raise ZeroDivisionError("nothing to divide by <here>")

    steps = [replace(step, work=breaks) if step.key == "geometry" else step for step in stages.STEPS]
    monkeypatch.setattr(stages, "STEPS", tuple(steps))
    delivery = ReproduceDelivery(out=str(tmp_path), quiet=True)
    assert command.reproduce(quick=True, only=("geometry", "equal"), delivery=delivery) == 1
    page = (tmp_path / "reproduce.html").read_text(encoding="utf-8")
    assert "ZeroDivisionError: nothing to divide by &lt;here&gt;" in page
    assert "ring.kind" in page
    assert "FAIL  stage geometry (Figs 1-4) failed: ZeroDivisionError" in capsys.readouterr().out
    told = json.loads((tmp_path / "reproduce.json").read_text(encoding="utf-8"))
    assert [stage["error"] != "" for stage in told["stages"]] == [True, False]


class Sources(HTMLParser):
    """What a page would load."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag, attrs):
        self.found += [value for name, value in attrs if name in ("src", "href") and value]


@pytest.mark.slow
def test_the_page_needs_nothing_but_itself(tmp_path, capsys):
    delivery = ReproduceDelivery(out=str(tmp_path), json=True)
    assert command.reproduce(quick=True, only=("geometry", "equal"), delivery=delivery) == 0
    printed = capsys.readouterr()
    told = json.loads(printed.out)
    assert [stage["key"] for stage in told["stages"]] == ["geometry", "equal"]
    assert told["stages"][1]["findings"]["differences"] == {"ring.kind": ["pin", "nonpin"]}
    assert [one["equation"] for one in told["errata"]] == [one["equation"] for one in errata()]
    assert re.search(r"Generation of the profiles \(Figs 1-4\); about \d+ s left\n", printed.err)
    page = Path(told["page"]).read_text(encoding="utf-8")
    sources = Sources()
    sources.feed(page)
    assert all(source.startswith(("data:", "#")) for source in sources.found)
    assert sum(source.startswith("data:image/") for source in sources.found) == 4
    assert (tmp_path / "reproduce.json").read_text(encoding="utf-8").strip() == printed.out.strip()
    (row,) = csv.DictReader((tmp_path / "reproduce.csv").read_text(encoding="utf-8").splitlines())
    (claim,) = told["claims"]
    assert (row["key"], row["verdict"]) == (claim["key"], claim["verdict"]) == ("poisson", "depends")
    assert float(row["ours_value"]) == claim["ours"]["value"]
    assert {path.name for path in (tmp_path / "figures").glob("*.svg")} == {
        f"{name}.svg" for name in ("fig1_rolling", "fig2_gear", "fig3_meshing", "fig4_ring")
    }


def test_an_unknown_stage_is_a_usage_error(tmp_path):
    with pytest.raises(UsageError, match=r"unknown stage 'stres': choose one of geometry, .*torque"):
        command.reproduce(only=("stres",), delivery=ReproduceDelivery(out=str(tmp_path)))


def test_stress_that_is_requested_by_name_needs_its_extra_before_any_run(tmp_path, monkeypatch):
    def absent(name):
        raise ImportError(f"No module named {name!r}")

    monkeypatch.setattr("cycloid_mj.stress.packages.importlib.import_module", absent)
    with pytest.raises(CycloidError, match=r"the package gmsh, .*cycloid-mj\[fem\]"):
        command.reproduce(only=("geometry", "stress"), delivery=ReproduceDelivery(out=str(tmp_path / "paper")))
    assert not (tmp_path / "paper").exists()


def test_the_time_left_follows_the_pace(monkeypatch):
    assert stages.pace(0.0, 0.0, 100.0) == 1.0
    assert stages.pace(50.0, 50.0, 100.0) == 1.0
    assert 1.0 < stages.pace(100.0, 50.0, 100.0) < 2.0
    clock, told = [0.0], []

    def slow(plan, runs, progress):
        clock[0] += 100.0
        progress("late")
        return StageResult()

    monkeypatch.setattr(stages, "monotonic", lambda: clock[0])
    monkeypatch.setattr(stages, "STEPS", (replace(stages.STEPS[0], work=slow), stages.STEPS[1]))
    stages.run_steps(QUICK, ideal_runs, lambda step, text, left: told.append(left))
    # a stage that takes longer than its share leaves the later ones to do, which may take longer, too
    assert told[:2] == pytest.approx([4.1, 0.1])
    assert 0.1 < told[2] < 100.0


# --- logs that fit


def test_a_log_fits_its_own_design_and_versions_only(monkeypatch):
    design, told = at_speed(PRESETS["pin"], 0.0, 1), {"mujoco": "1", "timestep_s": "1e-06"}
    run = replace(ideal_run(design), provenance=told | {"steps": "7"})
    assert fits(run, design, told)
    assert not fits(replace(run, complete=False), design, told)
    assert not fits(run, design, told | {"mujoco": "2"})
    assert not fits(run, at_speed(PRESETS["pin"], 1.0, 1), told)
    assert log_name(design, told) != log_name(design, told | {"mujoco": "2"})
    assert re.fullmatch(r"pin-no-load-[0-9a-f]{12}\.mcap", log_name(design, told))


def test_runs_are_read_again_where_their_logs_fit(tmp_path, monkeypatch):
    design = override(PRESETS["nonpin"], ["drive.ramp_s=0.0", "drive.hold_s=0.0004", "settings.log_rate_hz=20000.0"])
    first = Logs(tmp_path, fresh=False, quiet=True)([design])[0]
    monkeypatch.setattr("hsieh2014.logs.run_all", lambda *_, **__: pytest.fail("run again"))
    second = Logs(tmp_path, fresh=False, quiet=True)([design])[0]
    assert np.array_equal(first["gear_angle"], second["gear_angle"])
    with pytest.raises(pytest.fail.Exception, match="run again"):
        Logs(tmp_path, fresh=True, quiet=True)([design])


def test_each_solver_has_its_own_log_and_starts_are_not_shown(tmp_path):
    design = override(PRESETS["nonpin"], ["drive.ramp_s=0.0", "drive.hold_s=0.0004", "settings.log_rate_hz=20000.0"])
    logs = Logs(tmp_path, fresh=False, quiet=True)
    shown, start = logs([design])[0], logs([design], "planar")[0]
    assert (shown.provenance["solver"], start.provenance["solver"]) == ("mujoco", "planar")
    assert set(start.attachments) == {"design.toml"} < set(shown.attachments)
    assert start["gear_angle"] == pytest.approx(shown["gear_angle"], abs=1e-9)


@pytest.mark.slow
def test_claims_over_starts_name_their_solver():
    step = next(step for step in stages.STEPS if step.key == "gear_speed")
    claims = stages.run_step(step, QUICK, ideal_runs, silent).result.claims
    assert {claim.as_json()["condition"]["solver"] for claim in claims} == {"planar"}


def test_each_run_is_read_once_for_all_judgements():
    asked = []

    @Given
    def runs(which):
        asked.extend(which)
        return [ideal_run(one) for one in which]

    starts = idle_runs(QUICK, PRESETS["pin"])[:2]
    first = runs.figures(starts, "planar")
    assert runs.figures([starts[1], starts[0], starts[1]], "planar") == [first[1], first[0], first[1]]
    assert asked == starts
    # another solver's run is another one
    runs.figures(starts[:1], "mujoco")
    assert asked == [*starts, starts[0]]


def test_only_a_few_runs_are_in_memory(tmp_path, monkeypatch):
    class Logged(SimpleNamespace):
        """A run that can be referred to weakly."""

    read = []

    def reading(path):
        run = Logged(warnings=(), path=path, provenance={"design": "pin"})
        read.append(weakref.ref(run))
        return run

    monkeypatch.setattr("hsieh2014.logs.read", reading)
    monkeypatch.setattr("hsieh2014.logs.run_all", lambda *_, **__: None)
    designs = idle_runs(QUICK, PRESETS["pin"])
    found = Logs(tmp_path, fresh=True, quiet=True)(designs)
    assert len({run.path for run in found}) == len(found) == len(designs) > KEPT
    assert [run.path for run in found[2:4]] == [found[2].path, found[3].path]
    gc.collect()
    assert sum(run() is not None for run in read) == KEPT


def test_ctrl_c_ends_the_command_and_a_run_that_fails_its_stage(tmp_path, monkeypatch):
    def stopped(*_, **__):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as stop:
            raise RunError("stopped by Ctrl-C") from stop

    def failed(*_, **__):
        raise RunError("it jumped")

    logs = Logs(tmp_path, fresh=False, quiet=True)
    monkeypatch.setattr("hsieh2014.logs.run_all", stopped)
    step = next(step for step in stages.STEPS if step.key == "gear_speed")
    with pytest.raises(KeyboardInterrupt):
        stages.run_step(step, QUICK, logs, silent)
    monkeypatch.setattr("hsieh2014.logs.run_all", failed)
    assert stages.run_step(step, QUICK, logs, silent).error == "RunError: it jumped"


def test_every_stage_has_a_name_and_a_time():
    assert len({step.key for step in stages.STEPS}) == len(stages.STEPS)
    # on two free cores: quick under 3 minutes, full under 25
    assert sum(step.quick for step in stages.STEPS) < 180
    assert sum(step.full for step in stages.STEPS) < 1500
    assert isinstance(stages.run_step(stages.STEPS[1], QUICK, ideal_runs, silent).result, StageResult)


# --- the page of the documentation


def test_the_page_agrees_with_the_json():
    content, hypothesis = (
        json.loads(path.read_text(encoding="utf-8")) for path in (docs_results.KEPT, docs_results.AUTHORS)
    )
    page = docs_results.PAGE.read_text(encoding="utf-8")
    assert replace_sections(page, docs_results.sections(content), docs_results.SCRIPT) == page
    assert docs_results.CLAIMS.read_text(encoding="utf-8") == docs_results.claims_csv(content)
    assert docs_results.HYPOTHESIS.read_text(encoding="utf-8") == docs_results.hypothesis_csv(hypothesis)
    assert docs_results.format_tally(content) in page
    content["claims"][0]["verdict"] = "disagrees" if content["claims"][0]["verdict"] == "agrees" else "agrees"
    assert replace_sections(page, docs_results.sections(content), docs_results.SCRIPT) != page
    with pytest.raises(ValueError, match="not on the page once: poisson"):
        docs_results.sections(content | {"claims": content["claims"][1:]})


def test_the_tables_of_the_hypothesis_are_stored():
    stage = {"key": "authors", "error": "", "notes": ["two maxima", "a hypothesis"]}
    stage["tables"] = [{"title": "what brings it", "columns": ["feature", "by"], "rows": [["Fig. 12", "soft"]]}]
    kept = docs_results.kept_authors({"stages": [stage]})
    assert docs_results.hypothesis_csv(kept) == "what brings it\nfeature,by\nFig. 12,soft\n"
    with pytest.raises(ValueError, match="broken stage: ZeroDivisionError"):
        docs_results.kept_authors({"stages": [stage | {"error": "ZeroDivisionError"}]})


def test_the_cause_of_a_feature_follows_from_the_table():
    """By removal: each row says yes or no of neither change, of each alone, and of both."""
    features, varied, torques = json.loads(docs_results.AUTHORS.read_text(encoding="utf-8"))["tables"]
    names = dict(zip(features["columns"][1:5], CHANGES, strict=True))
    assert {row[0].split(",")[0] for row in features["rows"]} >= {f"Fig. {number}" for number in (6, 8, 9, 12, 13, 14)}
    for row in features["rows"]:
        holds = {name: cell.startswith("yes") for name, cell in zip(names.values(), row[1:5], strict=True)}
        assert row[-1] == brought_by(holds)
    soft = {row[0]: row[2] for row in features["rows"]}
    assert all(row[1] == soft[row[0]] for row in varied["rows"])
    assert [row[0] for row in torques["rows"]] == [f"{name}, {way}" for name, ways in TORQUES.items() for way in ways]


def test_the_reproduced_page_sums_up_as_the_readme_does():
    tally = {str(verdict): words.removesuffix(" under its condition") for verdict, words in PAGE_TALLY.items()}
    assert tally == docs_results.TALLY


def test_a_row_of_the_page_names_its_load():
    claim = {
        **{"figure": "Fig. 6", "design": "both", "condition": {"load_nm": 0.0, "speed_rpm": 1640.0}},
        "paper": {"claim": "more with pins", "text": "pin > nonpin"},
        **{"ours": {"text": "0.4 to 1"}, "verdict": "not determined"},
        "numerical_error": {"value": 0.125, "unit": "pin / nonpin", "source": "spread of 8 starts"},
        **{"at_rated_load": {"text": "2.3 to 1"}, "decided_by": "friction"},
    }
    loaded = claim | {"condition": {"load_nm": 36.68, "input_torque_nm": 1.048}, "at_rated_load": None}
    content = {"quick": True, "claims": [claim, loaded]}
    assert docs_results.format_tally(content).startswith("`cycloid-mj reproduce --quick` compares 2 claims")
    assert ", 0 disagree, and 2 are not determined." in docs_results.format_tally(content)
    rows = docs_results.claim_rows(content)
    assert rows[0][:6] == ("Fig. 6", "both", "none", "more with pins", "pin > nonpin", "0.4 to 1")
    assert rows[0][6].startswith("0.12 pin / nonpin (")
    assert rows[0][7:] == ("not determined", "friction", "2.3 to 1")
    assert rows[1][2] == "1.048 N m on the crank"


def test_the_errata_of_the_json_are_those_of_the_code():
    found = json.loads(docs_results.KEPT.read_text(encoding="utf-8"))
    # rounding differs between machines; the page rounds
    assert docs_results.format_errata(found["errata"]) == docs_results.format_errata(errata())


def test_a_run_with_a_broken_or_missing_stage_is_refused():
    assert list(docs_results.STAGES) == [step.key for step in stages.STEPS]
    whole = [{"key": key, "error": ""} for key in docs_results.STAGES]
    found = {"quick": True, "claims": [], "errata": [], "stages": whole}
    assert set(docs_results.extract_page_data(found)) == {"quick", "claims", "errata"}
    with pytest.raises(ValueError, match="missing: torque"):
        docs_results.extract_page_data(found | {"stages": whole[:-1]})
    with pytest.raises(ValueError, match="broken stage: torque"):
        docs_results.extract_page_data(
            found | {"stages": [*whole[:-1], {"key": "torque", "error": "RunError: it jumped"}]}
        )
