"""The contact code is compiled once and kept; where nothing can be kept, it is compiled for each run, and said so."""

import shutil
import signal
from pathlib import Path

import mujoco
import pytest
from numba import njit, types
from own_process import RUN, ran

import cycloid_mj
from cycloid_mj.base import compile_cache
from cycloid_mj.base.compiling import announce_compilation, cfunc
from cycloid_mj.base.errors import DesignError
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.contact.collider import CYLINDER, TYPES, collision_table, install
from cycloid_mj.dynamics.run import simulate


@pytest.mark.slow
def test_first_run_states_that_it_compiles_and_the_next_has_it(tmp_path):
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    first, second = (ran(tmp_path, *RUN, **cache) for _ in range(2))
    assert (first.returncode, second.returncode) == (0, 0), first.stderr + second.stderr
    told = "compiling the contact code, once per installation; this takes some seconds"
    assert first.stderr.splitlines().count(told) == 1
    assert "compiling" not in second.stderr


def test_compilation_is_reported_once_and_not_when_quiet(capsys, monkeypatch, tmp_path):
    for quiet, lines in ((), 1), (("--quiet",), 0):
        monkeypatch.setattr(compile_cache, "_logged_topics", set())

        def build(*given):
            for number in range(2):
                # code that is not in any cache
                with announce_compilation():
                    njit(lambda x, number=number: x + number)(1)
            raise DesignError("enough")

        monkeypatch.setattr("cycloid_mj.dynamics.run.model_for", build)
        assert main([*RUN, *quiet, "--out", str(tmp_path)]) == 1
        assert capsys.readouterr().err.count("compiling the contact code") == lines


def test_compilation_of_planar_steps_and_c_functions_is_reported(capsys, caplog, monkeypatch, tmp_path):
    monkeypatch.setattr(compile_cache, "_logged_topics", set())

    def advance(*given):
        njit(lambda x: x)(1)
        raise DesignError("enough")

    monkeypatch.setattr("cycloid_mj.dynamics.planar.stepper._compile_steps", lambda: advance)
    assert main([*RUN, "--solver", "planar", "--out", str(tmp_path)]) == 1
    assert capsys.readouterr().err.count("compiling the contact code") == 1
    monkeypatch.setattr(compile_cache, "_logged_topics", set())
    caplog.clear()
    with caplog.at_level("INFO"):
        called = njit(lambda x: x)
        cfunc(types.intp(types.intp))(lambda address: called(address))
    assert "compiling the contact code" in caplog.text


@pytest.mark.slow
@pytest.mark.parametrize("argv", [RUN, ("design", "check", "pin")])
def test_installation_that_cannot_be_written_runs_and_states_so_once(argv, tmp_path):
    shutil.copytree(
        Path(cycloid_mj.__file__).parent, tmp_path / "code" / "cycloid_mj", ignore=shutil.ignore_patterns("__pycache__")
    )
    # no folder can be made where there is a file: not even by root, whom permissions do not stop
    for module in [*(tmp_path / "code").rglob("__init__.py")]:
        (module.parent / "__pycache__").write_text("")
    nowhere = {"HOME": "/dev/null", "XDG_CACHE_HOME": "/dev/null"}
    done = ran(tmp_path, *argv, code=tmp_path / "code", **nowhere)
    assert done.returncode == 0, done.stderr
    told = [line for line in done.stderr.splitlines() if "compiling" in line]
    assert len(told) == 1
    assert "no cache folder is writable: set NUMBA_CACHE_DIR" in told[0]
    assert "Traceback" not in done.stderr


def test_pins_do_without_the_collider_of_lobes():
    entry = CYLINDER * TYPES + CYLINDER
    own = collision_table()[entry]
    with install(lobes=False):
        pins = collision_table()[entry]
        with install(lobes=True):
            both = collision_table()[entry]
        assert collision_table()[entry] == both
    assert collision_table()[entry] == own
    assert len({own, pins, both}) == 3
    with install(lobes=False):
        assert collision_table()[entry] == pins


@pytest.mark.parametrize("ring", [(), ('ring.pins="fixed"',)])
def test_pins_have_the_same_contacts_in_either_collider(ring):
    design = override(PRESETS["pin"], ["drive.ramp_s=0", "drive.hold_s=0.002", "load.torque_nm=36", *ring])
    alone = simulate(design)
    with install(lobes=True):
        beside = simulate(design)
    for name, values in alone.columns.items():
        assert values.tobytes() == beside[name].tobytes(), name
    assert alone["contacts"].max() > mujoco.mjMINVAL


def test_a_signal_waits_until_the_code_is_compiled() -> None:
    """Raised within LLVM's calls back to Python it would be printed and lost."""
    reached: list[bool] = []

    def compiling() -> None:
        with announce_compilation():
            signal.raise_signal(signal.SIGINT)
            reached.append(True)

    with pytest.raises(KeyboardInterrupt):
        compiling()
    assert reached
