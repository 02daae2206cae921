"""Warnings reach everybody: Python's callers, stderr, the JSON of every command, the log and the report."""

import json
import threading
import warnings as python_warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from designs import UNLIKE, unlike

from cycloid_mj.analysis import analyze
from cycloid_mj.analysis.series import design_of
from cycloid_mj.analysis.warnings import LIMITS, balance_warnings, convergence_warnings
from cycloid_mj.base.errors import CycloidWarning, warn
from cycloid_mj.base.powers import mean_powers
from cycloid_mj.base.record import Run
from cycloid_mj.cli.app import main
from cycloid_mj.cli.terminal import collect_warnings, say_json, tell
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.planar.model import planar_model
from cycloid_mj.dynamics.planar.settings import NEWTON
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.log import read
from cycloid_mj.reducer import Reducer
from cycloid_mj.report import report

UNUSED = "friction.cam=0.01"
NO_EFFECT = "friction.cam = 0.01 has no effect"
SHORT = ["--ramp-s", "0", "--hold-s", "0.0005", "--timestep-us", "5", "--set", UNUSED]


def fast(rpm: float, *changes: str) -> Design:
    """Fixed pins at 20 N m and 10 us for some crank turns; the teeth's friction alone."""
    hold = 0.006 + 4.0 * 60.0 / rpm
    changes = ("friction.cam_rolling=0", "friction.output_rolling=0", *changes)
    begin = ["ring.pins=fixed", "settings.timestep_us=10", "load.torque_nm=20", "load.rise_s=0.003", "drive.ramp_s=0"]
    return override(PRESETS["pin"], [*begin, f"drive.speed_rpm={rpm}", f"drive.hold_s={hold!r}", *changes])


def command(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[dict, str]:
    """Return the JSON of a command, and what it wrote to stderr."""
    assert main([*words, "--json"]) == 0
    written = capsys.readouterr()
    return json.loads(written.out), written.err


# Python


def test_a_run_issues_and_stores_the_warnings_of_its_model() -> None:
    design = override(PRESETS["nonpin"], [UNUSED, "drive.ramp_s=0", "drive.hold_s=0.0005", "settings.timestep_us=5"])
    compiled = build(design)
    assert [NO_EFFECT in text for text in compiled.warnings] == [True]
    with pytest.warns(CycloidWarning, match=f"nonpin: {NO_EFFECT}"):
        run = simulate(design, compiled)
    assert run.warnings == compiled.warnings
    assert analyze(run).warnings[-1:] == compiled.warnings


@pytest.mark.parametrize("name", [name for name in UNLIKE if name != "teeth21"])
def test_other_designs_run_without_a_warning(name: str) -> None:
    design = override(unlike(name), ["drive.ramp_s=0", "drive.hold_s=0.002"])
    with python_warnings.catch_warnings():
        python_warnings.simplefilter("error", CycloidWarning)
        run = simulate(design)
    assert run.warnings == ()


# The command line


def test_simulate_analyze_and_report_state_what_the_log_keeps(tmp_path: Path, capsys) -> None:
    found, shown = command(capsys, "simulate", "--design", "nonpin", *SHORT, "--out", str(tmp_path))
    assert [text for text in found["warnings"] if text.startswith(NO_EFFECT)]
    assert shown.count(NO_EFFECT) == 1
    log = str(tmp_path / "nonpin.mcap")
    assert len(read(log).warnings) == 1
    assert set(read(log).warnings) <= set(found["warnings"])
    assert json.loads(read(log).attachments["findings.json"])["warnings"] == found["warnings"]
    again, shown = command(capsys, "analyze", log)
    assert again["warnings"] == found["warnings"]
    assert f"warning: nonpin: {NO_EFFECT}" in shown
    assert NO_EFFECT in report({log: read(log)})


def test_quiet_keeps_stderr_empty_and_warnings_in_the_json(tmp_path: Path, capsys) -> None:
    found, shown = command(capsys, "simulate", "--design", "nonpin", *SHORT, "--out", str(tmp_path), "--quiet")
    assert shown == ""
    assert [text for text in found["warnings"] if text.startswith(NO_EFFECT)]


@pytest.mark.slow
def test_compare_reports_every_run(tmp_path: Path, capsys, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cycloid_mj.cli.compare._figure_encoders", lambda comparison, motions: {})
    short = ["--ramp-s", "0", "--hold-s", "0.045", "--timestep-us", "5", "--out", str(tmp_path)]
    assert main(["simulate", "--design", "nonpin", *short, "--set", UNUSED]) == 0
    assert main(["simulate", "--design", "pin", *short, "--set", "ring.pins=fixed"]) == 0
    capsys.readouterr()
    logs = [str(tmp_path / f"{name}.mcap") for name in ("nonpin", "pin")]
    found, shown = command(capsys, "compare", *logs, "--out", str(tmp_path))
    assert [text for text in found["warnings"] if text.startswith(f"nonpin: {NO_EFFECT}")]
    assert shown.count(NO_EFFECT) == 1


@pytest.mark.slow
def test_a_measure_prints_json_and_writes_a_file(tmp_path: Path, capsys) -> None:
    words = [
        "measure",
        "loads",
        "--solver",
        "mujoco",
        "--design",
        "nonpin",
        "--quick",
        "--no-log",
        "--out",
        str(tmp_path),
    ]
    found, shown = command(capsys, *words, "--set", "stiffness.cam_n_m=1e12", "--set", "settings.timestep_us=10")
    told = [text for text in found["warnings"] if text.startswith("nonpin: cam: a stiffness of 1e+12 N/m is too")]
    assert len(told) == 2, "one for the step of the runs, one for the half step of their check"
    assert shown.count("cam: a stiffness") == len(told)
    assert json.loads(next(tmp_path.glob("*.json")).read_text())["warnings"] == found["warnings"]


@pytest.mark.slow
def test_validate_reports_its_progress(monkeypatch, capsys) -> None:
    found, shown = command(capsys, "validate", "--quick", "--only", "friction", "two-body")
    assert found["warnings"] == []
    assert "warning" not in shown


def test_a_command_without_a_run_has_the_warnings_of_its_checks(capsys) -> None:
    found, _ = command(capsys, "design", "check", "pin")
    failed = [check["name"] for check in found["checks"] if not check["passed"]]
    assert [text.partition(":")[0] for text in found["warnings"]] == failed != []


def test_each_warning_is_shown_once_whichever_thread_it_comes_from(capsys) -> None:
    with collect_warnings(tell):
        threads = [threading.Thread(target=warn, args=("pin", ["too fast", "too coarse"])) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        say_json({"a": 1})
    written = capsys.readouterr()
    assert sorted(json.loads(written.out)["warnings"]) == ["pin: too coarse", "pin: too fast"]
    assert sorted(written.err.splitlines()) == ["warning: pin: too coarse", "warning: pin: too fast"]


def test_other_warnings_are_passed_on() -> None:
    with pytest.warns(UserWarning, match="of another kind"), collect_warnings(tell):
        python_warnings.warn("of another kind", UserWarning, stacklevel=1)


# High speed and coarse logs


@pytest.mark.parametrize("rpm", [20000.0, 50000.0, 99999.0])
def test_at_high_speed_the_cause_is_named(rpm: float) -> None:
    found = analyze(simulate(fast(rpm)))
    assert found.efficiency is not None
    assert found.efficiency < 1.0
    for cause in ("of crank rotation per step", "samples per passing tooth"):
        assert sum(cause in text for text in found.warnings) == 1, cause


@pytest.mark.parametrize("step", [10.0, 1.0])
def test_powers_of_every_step_balance_at_any_speed(step: float) -> None:
    """Of speeds half a step off the gear's inertia would open it by m c^2 omega^4 dt/2, 1.9 kW at 10 us."""
    design = fast(50000.0, f"settings.timestep_us={step}", "settings.log_rate_hz=1e6")
    run = simulate(design)
    found = mean_powers(run.select(run.time > 0.006))
    assert abs(found.missing) < 1e-4 * found.crank


def test_within_its_regime_a_run_at_speed_has_no_warning() -> None:
    design = fast(5000.0, "settings.timestep_us=2", "settings.log_rate_hz=50000")
    found = analyze(simulate(design))
    assert found.warnings == ()
    assert found.efficiency == pytest.approx(0.906, abs=0.002)


@pytest.mark.parametrize("rate", [100.0, 1000.0])
def test_a_coarse_log_is_reported(rate: float) -> None:
    found = analyze(simulate(fast(1640.0, "drive.hold_s=0.05", f"settings.log_rate_hz={rate}")))
    assert [text for text in found.warnings if f"settings.log_rate_hz = {rate:g}: only" in text]


def loaded_run() -> Run:
    return simulate(fast(5000.0))


def test_an_open_balance_and_an_impossible_efficiency_are_reported() -> None:
    run = loaded_run()
    design = design_of(run)
    judged = run.select(run.time > 0.006)
    assert balance_warnings(judged, Reducer(design)) == ()

    def spoiled(name: str, factor: float) -> tuple[str, ...]:
        columns = dict(judged.columns) | {name: judged[name] * factor}
        return balance_warnings(replace(judged, columns=columns), Reducer(design))

    assert len(spoiled("crank_torque", 1.0 + 2.0 * LIMITS.balance_rtol)) == 1
    assert len(spoiled("crank_torque", 1.0 - 2.0 * LIMITS.balance_rtol)) == 1
    assert spoiled("crank_torque", 1.0 + 0.5 * LIMITS.balance_rtol) == ()
    impossible = spoiled("crank_torque", 0.5)
    assert len(impossible) == 2
    assert "efficiency 181" in impossible[1]
    assert "efficiency 0, self-locking" in spoiled("load_torque", -1.0)[-1]


def test_an_idling_drive_is_judged_by_what_it_takes() -> None:
    """A balance open by 0.23 % of what an idling drive took was said to make its figures wrong."""
    run = simulate(fast(5000.0, "load.torque_nm=0.0", "drive.torque_nm=0.01"))
    judged = run.select(run.time > 0.006)
    powers = mean_powers(judged)
    taken = max(powers.crank, powers.lost)

    def missing(share: float) -> tuple[str, ...]:
        more = (share * taken - powers.missing) / powers.crank
        columns = dict(judged.columns) | {"crank_torque": judged["crank_torque"] * (1.0 + more)}
        return balance_warnings(replace(judged, columns=columns), Reducer(design_of(run)))

    assert missing(0.0023) == ()
    (text,) = missing(0.03)
    assert text.startswith("power balance of the idling drive at 5000 rpm: ")
    assert "powers and losses have an error of this size" in text


@pytest.mark.parametrize("crank", [1e-9, 0.0, -1e-9])
def test_a_load_that_does_not_act_yet_has_no_efficiency(crank: float) -> None:
    """Parts that crossed their play were told to have an efficiency of 72839730070.09 %, or of nan %."""
    run = loaded_run()
    columns = dict(run.columns) | {"crank_torque": crank * run["crank_torque"]}
    judged = replace(run, columns=columns).select(run.time > 0.006)
    (said,) = (
        text
        for text in balance_warnings(judged, Reducer(design_of(run)))
        if "efficiency" in text and "power balance" not in text
    )
    assert said.startswith("the load does not act yet")


def test_a_run_without_friction_may_have_an_efficiency_of_one_to_rounding() -> None:
    run = loaded_run()
    design = design_of(run)
    judged = run.select(run.time > 0.006)
    powers = mean_powers(judged)

    def with_efficiency(value: float, lost: float) -> tuple[str, ...]:
        still = {
            name: lost * judged[name] for name in judged.columns if name.endswith(("friction_power", "normal_power"))
        }
        factor = -powers.output / (value * powers.crank)
        return balance_warnings(
            replace(judged, columns=dict(judged.columns) | still | {"crank_torque": factor * judged["crank_torque"]}),
            Reducer(design),
        )

    assert with_efficiency(1.0 + 0.2 * LIMITS.balance_rtol, lost=0.0) == ()
    assert "is impossible" in with_efficiency(1.0 + 2.0 * LIMITS.balance_rtol, lost=0.0)[-1]
    assert "is impossible" in with_efficiency(1.0 + 0.2 * LIMITS.balance_rtol, lost=1.0)[-1]


def test_less_than_a_turn_has_no_balance_but_an_efficiency() -> None:
    run = loaded_run()
    design = design_of(run)
    part = run.select((run.time > 0.006) & (run.time < 0.010))
    assert np.ptp(part["crank_angle"]) < 2.0 * np.pi
    half = replace(part, columns=dict(part.columns) | {"crank_torque": 0.5 * part["crank_torque"]})
    assert [text.startswith("efficiency ") for text in balance_warnings(half, Reducer(design))] == [True]
    assert "raise drive.hold_s" in balance_warnings(half, Reducer(design))[0]


@pytest.mark.slow
def test_a_planar_step_that_did_not_settle_is_counted() -> None:
    """Of MuJoCo's solver a run ends where it does not converge; there it is no doubt, and never comes here."""
    design = override(PRESETS["nonpin"], ["drive.ramp_s=0", "drive.hold_s=0.002"])
    run = simulate(design, planar_model(Reducer(design)))
    assert list(convergence_warnings(run)) == []
    rounds = run["solver_iterations"].copy()
    rounds[[3, 7]] = NEWTON.max_iterations + 1
    wild = replace(run, columns={**run.columns, "solver_iterations": rounds})
    (text,) = convergence_warnings(wild)
    assert text.startswith(
        f"in 2 of {len(run)} samples, the contact iteration of the planar solver did not converge within"
    )
    assert text in analyze(wild).warnings
    assert list(convergence_warnings(replace(wild, provenance={**run.provenance, "solver": "mujoco"}))) == []
