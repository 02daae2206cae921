"""The pieces of the benchmark run, and what they measure hangs together."""

import json
import subprocess
import sys
import threading
from pathlib import Path

import against
import benchmark
import cost_limits
import costs
import pytest
import sweeping

from cycloid_mj.checks import require_sound
from cycloid_mj.design import PRESETS, override
from cycloid_mj.reducer import Reducer


@pytest.mark.slow
def test_every_part_of_a_step_has_a_cost() -> None:
    """Only signs are compared: costs on a loaded machine differ by any factor."""
    case = costs.example("nonpin", 36.0, 2_000)
    bare, _ = costs.bare_cost(*case)
    parts = *costs.own_cost(*case), costs.loop_cost(*case), costs.run_cost(*case), costs.logged_cost(*case)
    assert min(bare, *parts) > 0.0


def test_passes_are_taken_in_turn() -> None:
    taken: list[str] = []

    def one(name: str) -> float:
        taken.append(name)
        return float(len(taken))

    row = benchmark.in_turn(3, a=lambda: one("a"), b=lambda: one("b"))
    assert "".join(taken) == "ababab"
    assert benchmark.ratio(row, "b", "a") == {"b / a": [2.0, 4.0 / 3.0, 6.0 / 5.0]}


def test_threads_are_timed_together() -> None:
    met = threading.Barrier(3)

    def work() -> float:
        met.wait(timeout=300.0)  # nobody goes on before all three are there
        return float(threading.get_ident() != threading.main_thread().ident)

    wall, given = benchmark.together(3, work)
    assert 0.0 < wall < 10.0
    assert given == 1.0


@pytest.mark.slow
def test_the_number_of_teeth_fits() -> None:
    for teeth, fit in (benchmark.TEETH | benchmark.FREE_PINS).items():
        design, compiled = costs.example(
            "fixed pins", 36.0, 0, f"ring.teeth={teeth}", *(f"{name}={value}" for name, value in fit.items())
        )
        assert design.ring.teeth == teeth
        assert sum(pair.kind == "pin_gear" for pair in compiled.pairs) == teeth


@pytest.mark.slow
def test_two_discs_are_compared_with_one_under_the_same_load_per_disc(monkeypatch) -> None:
    def cost(design, compiled):
        assert compiled.model.opt.timestep == design.settings.timestep
        assert costs.schedule(Reducer(design)).steps == costs.WARM + 10_000
        return design.gear.discs * design.load.torque

    monkeypatch.setattr(costs, "loop_cost", cost)
    table = benchmark.discs_table(1)
    assert table["twodisc"]["1 disc"] == [58.0]
    assert list(table) == ["twodisc", *costs.KINDS]
    assert all(row["2 discs / 1 disc"] == [4.0] for row in table.values())


@pytest.mark.slow
def test_scaling_uses_steps_that_resolve_the_pins_equally(monkeypatch) -> None:
    seen = {}

    def cost(design, compiled):
        seen[design.ring.teeth] = max(law.stiffness / law.effective_mass for law in compiled.laws.values())
        seen[design.ring.teeth] *= design.settings.timestep**2
        assert costs.schedule(Reducer(design)).steps == costs.WARM + 5_000
        return float(design.ring.teeth) ** 1.1

    monkeypatch.setattr(costs, "loop_cost", cost)
    table = benchmark.scaling_table(1)
    assert list(seen) == [12, 36, 72, 144]
    # the stiffness of a line contact grows a little as its radius falls
    assert list(seen.values()) == pytest.approx([seen[12]] * 4, rel=0.1)
    assert [row["exponent"] for row in list(table.values())[1:]] == [[pytest.approx(1.1)]] * 3


def test_the_ratio_to_exudyn_is_stated_for_each_published_cost(monkeypatch) -> None:
    def cost(design, compiled):
        assert costs.schedule(Reducer(design)).steps == costs.WARM + 20_000
        assert costs.schedule(Reducer(design)).stride * 100 == costs.WARM
        return 20.0

    monkeypatch.setattr(costs, "loop_cost", cost)
    table = benchmark.exudyn_table(1)
    for kind, published in (("fixed pins", [5.0, 15.0]), ("free pins", [247.0])):
        step = 1e6 * costs.example(kind, 36.0, 0, benchmark.OWN_STEP)[1].model.opt.timestep
        assert table[kind]["Exudyn / here"] == pytest.approx([cost * step / 20.0 for cost in published])


def test_figures_of_two_trees_are_compared_by_name(tmp_path) -> None:
    printed = {"a": [{"key": "x", "value": 2.0}, 3.0], "wall_s": 1.0, "n": 4, "none": None, "bad": float("inf")}
    ours = against.figures_of_json(against.Finished(1.0, 1.0, json.dumps(printed), tmp_path))
    assert ours == {"a.x.value": 2.0, "a.1": 3.0}
    assert against.difference(ours, {"a.x.value": 2.5, "a.1": 3.0, "b": 1.0}) == ("a.x.value", pytest.approx(0.2), 2)


def test_main_writes_what_it_prints(tmp_path, monkeypatch, capsys) -> None:
    table = {"case": {"a": [1.0, 3.0, 2.0]}}

    def made(passes: int) -> benchmark.Table:
        """Say what this is."""
        return table

    monkeypatch.setitem(benchmark.SECTIONS, "loop", made)
    monkeypatch.setattr(sys, "argv", ["benchmark.py", "loop", "--quick", "--json", str(tmp_path / "told.json")])
    benchmark.main()
    printed = capsys.readouterr().out
    assert "Say what this is." in printed
    assert "2 (2)" in printed, "median and spread"
    told = json.loads((tmp_path / "told.json").read_text())
    assert told["tables"] == {"loop": table}
    assert {"processor", "versions", "load average"} <= set(told["machine"])


def test_an_unknown_section_is_an_error(monkeypatch, capsys) -> None:
    monkeypatch.setattr(sys, "argv", ["benchmark.py", "loops"])
    with pytest.raises(SystemExit):
        benchmark.main()
    assert "choose of loop" in capsys.readouterr().err


@pytest.mark.skipif(not (Path(__file__).parents[1] / ".git").exists(), reason="not in a clone")
def test_against_needs_one_revision_that_git_knows(monkeypatch, capsys) -> None:
    monkeypatch.setattr(sys, "argv", ["benchmark.py", "loop", "against"])
    with pytest.raises(SystemExit):
        benchmark.main()
    assert "against REVISION" in capsys.readouterr().err
    with pytest.raises(SystemExit, match="no revision nowhere"), against.check_out("nowhere"):
        pass


@pytest.mark.slow
def test_a_tree_against_itself_has_the_same_figures(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(against, "SETTLING", 0.001)
    words = ("simulate", "--design", "nonpin", "--ramp-s", "0", "--hold-s", "0.002")
    trial = against.Trial("short", words, reference=("--load-nm", "0"))
    ours, theirs, found = against.compare(trial, against.ROOT, 1)
    assert min(one.cpu for one in (*ours, *theirs)) > 0.3
    assert min(one.memory for one in (*ours, *theirs)) > 50.0
    assert list(found) == ["this tree", "other", "this tree, fine", "other, fine"]
    here, *rest = found.values()
    assert all(figures == here for figures in rest)
    assert here["cam [N]"] > 0.0
    assert against.difference(here, rest[0])[1] == 0.0


@pytest.mark.slow
def test_the_loops_of_two_trees_are_timed_in_turn() -> None:
    found = against.loops(against.ROOT, 1)
    assert len(found) == 4
    assert all(0.2 < here / there < 5.0 for (here,), (there,) in found.values())
    assert found["massless pins, 36.68 N m"][0][0] < 0.3 * found["free pins, 36.68 N m"][0][0]


@pytest.mark.slow
def test_the_program_of_the_statics_runs_in_this_tree(tmp_path) -> None:
    trial = next(trial for trial in against.TRIALS if trial.words == (against.STATICS,))
    found = trial.figures(against.run_trial(against.ROOT, trial, (), tmp_path / "out"))
    assert 0.0 < found["pin 0.std"] != found["pin 1.std"]
    assert found["nonpin 4.mean"] > 0.0


@pytest.mark.slow
def test_the_cost_of_a_point_is_its_work_and_its_way() -> None:
    works = sweeping.works(fast_points=50, slow_points=2)
    assert len(works) == 5
    table = sweeping.sweep_table(1, {name: works[name] for name in ("nothing", "statics")})
    for name, row in table.items():
        assert set(row) == set(sweeping.COLUMNS), name
    assert 0.0 < table["nothing"]["CPU"][0] < 0.1 * table["statics"]["CPU"][0]
    assert table["nothing"]["Dask"][0] > table["nothing"]["CPU"][0]


def test_a_cluster_is_as_fast_as_its_workers_or_its_scheduler() -> None:
    assert sweeping.hours(3.6e6, 64.0, 0.5, 64) == 1.0
    assert sweeping.hours(3.6e6, 64.0, 3.0, 64) == 3.0


def test_requirements_are_compared_with_measurements(monkeypatch, capsys) -> None:
    cost, gained = (
        cost_limits.Demand("cost", 4.0, "s", lambda: 2.0),
        cost_limits.Demand("gain", 4.0, "1", lambda: 2.0, least=True),
    )
    monkeypatch.setattr(cost_limits, "DEMANDS", (cost, gained))
    monkeypatch.setattr(cost_limits, "launch", lambda *words, **environment: None)
    table = cost_limits.limits_table(3)
    assert table == {
        "cost": {"measured": [2.0] * 3, "limit": [4.0], "share": [0.5] * 3},
        "gain": {"measured": [2.0] * 3, "limit": [4.0], "share": [2.0] * 3},
    }
    assert "gain" in capsys.readouterr().err


def test_designs_of_the_requirements_pass_their_checks() -> None:
    changes = [cost_limits.SLEEVED, *(("ring.teeth=" + str(teeth), *fit) for teeth, fit in cost_limits.TOOTHED.items())]
    for design in [override(PRESETS["pin"], change) for change in changes]:
        require_sound(Reducer(design))
    assert len({demand.name for demand in cost_limits.DEMANDS}) == len(cost_limits.DEMANDS)


@pytest.mark.slow
def test_a_command_runs_in_a_separate_folder() -> None:
    took = costs.launch("figures", "--quiet")
    assert 0.0 < took.cpu < 60.0
    assert took.memory > 10.0
    with pytest.raises(subprocess.CalledProcessError):
        costs.launch("no-such-command")


def test_the_tests_of_releases_of_mujoco_are_there() -> None:
    from test_mujoco_versions import ROOT, TESTS

    assert [test for test in TESTS if not (ROOT / test).is_file()] == []
