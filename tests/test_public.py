"""The public face: what `import cycloid_mj` offers, lazily, under names that are true."""

import subprocess
import sys
from pathlib import Path

import pytest

import cycloid_mj as cm


def test_every_public_name_is_there() -> None:
    assert all(getattr(cm, name) is not None for name in cm.__all__)
    assert len(set(cm.__all__)) == len(cm.__all__)
    assert set(cm.__all__) <= set(dir(cm))


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(AttributeError, match=r"no attribute 'simulat'; it has .*simulate"):
        cm.simulat  # noqa: B018


def test_the_import_alone_loads_nothing_heavy() -> None:
    heavy = "{'numpy', 'mujoco', 'pydantic', 'numba', 'matplotlib', 'scipy'}"
    code = f"import sys, cycloid_mj; assert not {heavy} & set(sys.modules), {heavy} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_functions_stay_functions_after_every_module_is_imported() -> None:
    """A submodule of the same name would hide them."""
    code = "import cycloid_mj as cm, cycloid_mj.cli.app; assert all(callable(getattr(cm, n)) for n in names)"
    names = ["analyze", "build", "check", "load", "rate", "read_log", "simulate", "tolerance"]
    subprocess.run([sys.executable, "-c", f"names = {names}; {code}"], check=True)


def test_a_design_to_findings(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('name = "mine"\n[ring]\nteeth = 12\n[gear]\neccentricity_mm = 2.0\n')
    assert cm.load(path) == cm.load(str(path))
    assert cm.load(path).lobes == 11
    fast = cm.load("nonpin", {"drive.ramp_s": 0.0, "drive.hold_s": 0.002, "load.torque_nm": 5.0, "load.rise_s": 0.001})
    run = cm.simulate(fast)
    assert cm.analyze(run, settle=0.001).power.load_torque_nm == pytest.approx(5.0, rel=0.01)
