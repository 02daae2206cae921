"""What pyproject.toml and README.md promise about other packages."""

import importlib.metadata
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import mujoco
import pytest

from cycloid_mj.cli.app import main
from cycloid_mj.contact import library
from cycloid_mj.contact.tested import FAULTY, NEWEST, OLDEST, REQUIREMENT, UNTESTED, require_tested
from cycloid_mj.errors import ContactError
from cycloid_mj.papers import GROUP, Paper, papers

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def test_mujoco_is_bounded_alike_by_pip_and_at_run_time():
    assert REQUIREMENT in PROJECT["dependencies"]
    bounds = dict(re.findall(r"(>=|<=|!=)([\d.]+)", REQUIREMENT))
    numbers = {operator: tuple(map(int, f"{text}.0".split(".")[:3])) for operator, text in bounds.items()}
    assert numbers == {">=": OLDEST, "<=": NEWEST, "!=": FAULTY[0]}


@pytest.mark.parametrize("version", ["3.17.0", "3.18", "4.0.1", mujoco.__version__])
def test_tested_releases_of_mujoco_pass(version):
    require_tested(version)


@pytest.mark.parametrize("version", ["3.16.0", "4.0.0", "4.0.2", "4.1.0", "4.1.0rc1", "5.0"])
def test_other_releases_of_mujoco_are_refused(version, monkeypatch):
    monkeypatch.delenv(UNTESTED, raising=False)
    message = rf"MuJoCo {version} is not one .* \(3\.17\.0 to 4\.0\.1, without 4\.0\.0\): pip install 'mujoco>="
    with pytest.raises(ContactError, match=message):
        require_tested(version)
    monkeypatch.setattr(mujoco, "__version__", version)
    library.library.cache_clear()
    with pytest.raises(ContactError, match="is not one"):
        library.collision_table()
    monkeypatch.undo()
    library.collision_table()
    monkeypatch.setenv(UNTESTED, "1")
    require_tested(version)


@pytest.mark.slow
def test_the_licence_of_gmsh_is_told_and_only_extras_import_it():
    extras = [name for name, needs in PROJECT["optional-dependencies"].items() if any("gmsh" in need for need in needs)]
    assert extras == ["cad", "fem", "test"]
    licence = importlib.metadata.metadata("gmsh")["License"]
    assert licence.startswith("GPL"), "it has changed: README.md and pyproject.toml name it"
    readme = " ".join((ROOT / "README.md").read_text().split())
    assert "`cad` and `fem` (and `test`) install gmsh, which is under GPL-2.0-or-later" in readme
    assert "GPL-2.0-or-later" in (ROOT / "pyproject.toml").read_text()
    script = "import sys, cycloid_mj.cli.app, cycloid_mj.run, cycloid_mj.report; print('gmsh' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script], capture_output=True, text=True).stdout == "False\n"


def test_every_paper_is_shipped_and_found():
    folders = sorted(path.parent for path in ROOT.glob("papers/*/__init__.py"))
    config = tomllib.loads((ROOT / "pyproject.toml").read_text())
    assert PROJECT["entry-points"][GROUP] == {folder.name: f"{folder.name}:PAPER" for folder in folders}
    shipped = config["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]
    assert shipped == ["cycloid_mj", *(str(folder.relative_to(ROOT)) for folder in folders)]
    assert [paper.key for paper in papers()] == [folder.name for folder in folders]


@pytest.fixture
def found(monkeypatch):
    """Sets the entry points that are found: name -> what is named."""

    def point(name, value):
        return importlib.metadata.EntryPoint(name, value, GROUP)

    def install(**points):
        entries = [point(name, value) for name, value in points.items()]
        monkeypatch.setattr("cycloid_mj.papers.entry_points", lambda group: entries)
        papers.cache_clear()

    yield install
    papers.cache_clear()


def test_a_paper_that_does_not_load_stops_no_other_command(found, capsys):
    found(broken="nobody_2000:PAPER")
    assert main(["profile", "--help"]) == 0
    assert "paper broken: left out, since nobody_2000:PAPER does not load: No module named" in capsys.readouterr().err


def test_a_second_paper_makes_reproduce_a_group_of_commands(found, capsys):
    found(hsieh2014="hsieh2014:PAPER", second="test_packaging:SECOND")
    assert main(["reproduce", "--help"]) == 0
    out = capsys.readouterr().out
    assert "hsieh2014" in out
    assert "second" in out
    assert main(["reproduce", "second"]) == 7


def test_without_a_paper_reproduce_says_what_it_is_for(found, capsys):
    found()
    assert main(["reproduce"]) == 2
    told = " ".join(capsys.readouterr().err.split())
    assert f"entry points of the group {GROUP}" in told
    assert "reproduce needs a command: none is there" in told


def reproduce_second() -> int:
    """Run the second paper."""
    return 7


SECOND = Paper("second", "Second 2000", "test_packaging:reproduce_second", "")
