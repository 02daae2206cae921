"""What pyproject.toml and README.md promise about other packages."""

import ast
import importlib.metadata
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterable
from pathlib import Path

import pytest
import yaml

from cycloid_mj.base.errors import CycloidWarning
from cycloid_mj.cli.app import main
from cycloid_mj.design import PRESETS
from cycloid_mj.dynamics.contact.library import KNOWN
from cycloid_mj.papers import GROUP, Paper, papers, published_torques, stress_references
from cycloid_mj.reducer import Reducer

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def test_the_requirement_on_mujoco_is_the_oldest_tested_version():
    (requirement,) = [one for one in PROJECT["dependencies"] if one.startswith("mujoco")]
    assert KNOWN[0].startswith(requirement.removeprefix("mujoco>="))


def test_every_extra_with_a_copyleft_library_is_stated_with_its_licence() -> None:
    extras = PROJECT["optional-dependencies"]
    needs = {"base": PROJECT["dependencies"], **extras}
    copyleft = {name: [need.partition(">")[0] for need in needs[name] if "GPL" in licences(need)] for name in needs}
    assert {name: packages for name, packages in copyleft.items() if packages} == {"fem": ["gmsh"], "test": ["gmsh"]}
    encoders = " ".join(file.name for file in importlib.metadata.files("av") or [])
    assert "x264" in encoders, "the wheel of PyAV has changed: README.md, docs/libraries.md, pyproject.toml"
    assert "x265" in encoders
    for package, expected in (("av", ["test", "video"]), ("cadquery-ocp", ["cad", "test"])):
        assert sorted(name for name in needs if any(need.startswith(package) for need in needs[name])) == expected
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    assert (
        "`cad` installs OpenCASCADE (LGPL-2.1), `fem` installs Gmsh (GPL-2.0-or-later), "
        "`video` installs x264 and x265 (GPL-2.0-or-later), and `test` installs all of them."
    ) in readme
    page = " ".join((ROOT / "docs" / "libraries.md").read_text(encoding="utf-8").split())
    for statement in (
        "`cad` installs cadquery-ocp-novtk (Apache-2.0). This library contains OpenCASCADE, which is under LGPL-2.1",
        "`fem` installs Gmsh (GPL-2.0-or-later).",
        "The wheel of PyAV contains x264 and x265 (GPL-2.0-or-later).",
    ):
        assert statement in page
    assert (ROOT / "pyproject.toml").read_text(encoding="utf-8").count("GPL-2.0-or-later") == 2


def licences(need: str) -> str:
    """Return what the metadata of an installed requirement state about its licence; nothing if it is not installed."""
    try:
        metadata = importlib.metadata.metadata(re.match(r"[\w-]+", need)[0])
    except importlib.metadata.PackageNotFoundError:
        return ""
    classifiers = [line for line in metadata.get_all("Classifier") or [] if line.startswith("License")]
    return " ".join([metadata.get("License-Expression") or "", (metadata.get("License") or "")[:80], *classifiers])


@pytest.mark.slow
def test_only_the_commands_of_extras_import_their_packages() -> None:
    script = "import sys, cycloid_mj.cli.app, cycloid_mj.dynamics.run, cycloid_mj.report; "
    script += "print({'gmsh', 'av', 'OCP'} & set(sys.modules))"
    assert subprocess.run([sys.executable, "-c", script], capture_output=True, text=True).stdout == "set()\n"


def imports(path: Path) -> tuple[set[str], set[str]]:
    """Return the packages that a module imports when it is loaded, and all that it imports."""

    def named(nodes: Iterable[ast.AST]) -> set[str]:
        names = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
        names += [node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)]
        return {name.partition(".")[0] for name in names}

    tree = ast.parse(path.read_text(encoding="utf-8"))
    return named(tree.body), named(list(ast.walk(tree)))


def test_every_import_is_a_requirement_or_an_extra() -> None:
    """What the base does not install is imported where it is used."""
    packages = importlib.metadata.packages_distributions()
    required, *_ = offered = [
        {re.match(r"[\w-]+", one)[0].lower() for one in needs}
        for needs in (PROJECT["dependencies"], *PROJECT["optional-dependencies"].values())
    ]
    required |= {"markupsafe", "pydantic-core", "llvmlite"}  # of jinja2, pydantic and numba
    own = sys.stdlib_module_names | {"cycloid_mj", ""}
    for path in sorted((ROOT / "cycloid_mj").rglob("*.py")):
        for found, allowed in zip(imports(path), (required, set().union(*offered)), strict=True):
            of = {name: {one.lower().replace("_", "-") for one in packages.get(name, [name])} for name in found - own}
            assert [name for name, distributions in of.items() if not distributions & allowed] == [], path


@pytest.mark.parametrize(
    ("module", "words", "told"),
    [
        (
            "ezdxf",
            ("export", "pin", "--format", "dxf"),
            r"DXF needs ezdxf .*pip install 'cycloid-mj\[dxf\]', or export",
        ),
        (
            "cma",
            ("optimize", "pin", "--vary", "gear.face_width_mm=8:12", "--minimize", "mass_kg", "--quick"),
            r"optimize needs cma .*pip install 'cycloid-mj\[optimize\]', or try points with `cycloid-mj sweep`",
        ),
    ],
)
def test_without_its_extra_a_command_states_what_to_install(module, words, told, monkeypatch, tmp_path, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, module, None)
    assert main([*words]) == 1
    assert re.fullmatch(rf"error: {told}.*", capsys.readouterr().err.splitlines()[-1])


def test_the_workflow_runs_the_second_command_on_three_systems() -> None:
    text = (ROOT / ".github" / "workflows" / "check.yml").read_text(encoding="utf-8")
    job = yaml.safe_load(text)["jobs"]["check"]
    matrix = job["strategy"]["matrix"]
    assert {name.partition("-")[0] for name in matrix["system"]} == {"ubuntu", "macos", "windows"}
    versions = [line.rpartition(" ")[2] for line in PROJECT["classifiers"] if ":: 3." in line]
    assert matrix["python"] == versions
    (command,) = [step["run"] for step in job["steps"] if step.get("if") == "runner.os != 'Windows'"]
    assert command in (ROOT / "README.md").read_text(encoding="utf-8")
    assert "not run there yet" in " ".join(text.split())


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


def reproduce_second() -> int:
    """Run the second paper."""
    return 7


def leave(*_: object) -> None:
    sys.exit("I leave")


SECOND = Paper("second", "Second 2000", "test_packaging:reproduce_second", "")
FAULTY = {
    "nobody_2000:PAPER": "nobody_2000:PAPER does not load: No module named 'nobody_2000'",
    "test_packaging:NO_PAPER": "test_packaging:NO_PAPER does not load: module 'test_packaging' has no attribute",
    "test_packaging:ROOT": "test_packaging:ROOT is not a Paper but of type PosixPath",
    "test_packaging:NOWHERE": "its command 'nobody_2000:run' does not load: No module named 'nobody_2000'",
    "test_packaging:NOTHING": "its command 'test_packaging:nothing' does not load: module 'test_packaging' has no",
    "test_packaging:NONSENSE": "its command 'non sense' is not written as module:function",
    "test_packaging:NO_FUNCTION": "its command 'test_packaging:ROOT' is not a function",
    "test_packaging:NO_FLAGS": "its command 'builtins:dict' cannot be read as a command with flags (no signature found",
    "test_packaging:TAKEN": "its key 'hsieh2014' is taken by another paper",
    "test_packaging:NAMELESS": "its key '--help' is not a valid command name",
    "leaves_2000:PAPER": "it ends the program (I leave)",
}
NOWHERE, NOTHING, NONSENSE, NO_FUNCTION = (
    Paper("other", "Other 2000", command, "")
    for command in ("nobody_2000:run", "test_packaging:nothing", "non sense", "test_packaging:ROOT")
)
NO_FLAGS = Paper("zebra", "Other 2000", "builtins:dict", "")
TAKEN, NAMELESS = (Paper(key, "Other 2000", "test_packaging:reproduce_second", "") for key in ("hsieh2014", "--help"))
ODD = Paper("odd", "Odd 2000", "test_packaging:reproduce_second", "", torques=lambda design: 5)
LEAVING = Paper(
    "leaving", "Leaving 2000", "test_packaging:reproduce_second", "", torques=leave, stress_references=leave
)


@pytest.mark.parametrize("value", FAULTY)
def test_a_faulty_paper_is_reported_in_one_line_and_stops_no_command(value, found, capsys, tmp_path, monkeypatch):
    (tmp_path / "leaves_2000.py").write_text("import sys\nsys.exit('I leave')\n")
    monkeypatch.syspath_prepend(tmp_path)
    for argv in (["rate", "--help"], ["--help"], ["design", "show", "pin"]):
        found(hsieh2014="hsieh2014:PAPER", zebra=value)
        assert main(argv) == 0
        assert capsys.readouterr().err == ""
    assert main(["reproduce", "--help"]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"warning: paper zebra: ignored: {FAULTY[value]}")


def test_a_paper_that_fails_is_skipped(found, capsys):
    found(leaving="test_packaging:LEAVING")
    for ask, nothing in ((published_torques, []), (stress_references, {})):
        with pytest.warns(CycloidWarning, match="paper leaving: passed over: it ends the program"):
            assert ask(Reducer(PRESETS["pin"])) == nothing


def test_a_paper_that_returns_no_list_is_skipped(found):
    found(odd="test_packaging:ODD")
    with pytest.warns(CycloidWarning, match="paper odd: passed over: 'int' object is not iterable"):
        assert published_torques(Reducer(PRESETS["pin"])) == []


def test_output_of_a_paper_during_import_goes_to_stderr(found, capsys, tmp_path, monkeypatch):
    (tmp_path / "talks_2000.py").write_text("from test_packaging import SECOND\nprint('I load')\n")
    monkeypatch.syspath_prepend(tmp_path)
    found(talks="talks_2000:SECOND")
    assert published_torques(Reducer(PRESETS["pin"])) == []
    assert capsys.readouterr() == ("", "I load\n")


def test_a_second_paper_makes_reproduce_a_group_of_commands(found, capsys):
    found(hsieh2014="hsieh2014:PAPER", second="test_packaging:SECOND")
    assert main(["reproduce", "--help"]) == 0
    out = capsys.readouterr().out
    assert "hsieh2014" in out
    assert "second" in out
    assert main(["reproduce", "second"]) == 7


def test_without_a_paper_reproduce_states_its_purpose(found, capsys):
    found()
    assert main(["reproduce"]) == 2
    told = " ".join(capsys.readouterr().err.split())
    assert f"entry points of the group {GROUP}" in told
    assert "reproduce has no commands: install a package" in told
