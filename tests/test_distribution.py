"""What is handed on: source archive and wheel, built offline, with all files inside, and the wheel at work."""

import os
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import hatchling.build
import pytest
import yaml

from cycloid_mj.base.version import __version__

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
STEM = f"cycloid_mj-{__version__}"
PACKAGES = {"cycloid_mj": ROOT / "cycloid_mj", "hsieh2014": ROOT / "papers" / "hsieh2014"}


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> tuple[set[str], Path]:
    """Return the files of the source archive, and the wheel that is built of what the archive holds alone."""
    folder = tmp_path_factory.mktemp("built")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        archive = folder / hatchling.build.build_sdist(str(folder))
        with tarfile.open(archive) as tar:
            tar.extractall(folder, filter="data")
            files = {name.removeprefix(f"{STEM}/") for name in tar.getnames()}
        patch.chdir(folder / STEM)
        return files, folder / hatchling.build.build_wheel(str(folder))


@pytest.mark.slow
def test_the_source_archive_has_all_sources_and_no_build_output(built: tuple[set[str], Path]) -> None:
    files, _ = built
    folders = {"cycloid_mj", "papers", "docs", "examples", "models", "scripts", "tests"}
    pages = {"README.md", "LICENSE", "CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md"}
    assert {name.partition("/")[0] for name in files} == {*folders, *pages, "pyproject.toml", "PKG-INFO", ".gitignore"}
    assert {"models/pin/scene.xml", "docs/tutorial.md", "docs/_static/pages.css", "tests/data/measured.json"} <= files
    made = ("docs/_build", "docs/_reference", "docs/_gallery", "__pycache__", ".egg-info", "_cache/")
    assert [name for name in files if any(word in name for word in made)] == []


@pytest.mark.slow
def test_the_wheel_has_every_file_of_its_packages(built: tuple[set[str], Path]) -> None:
    """Modules, templates, styles and scripts of the pages, the layout of the scene, the paper."""
    names = {name for name in zipfile.ZipFile(built[1]).namelist() if ".dist-info/" not in name}
    there = {
        f"{package}/{path.relative_to(folder)}"
        for package, folder in PACKAGES.items()
        for path in folder.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert names == there
    assert {"cycloid_mj/report/assets/page.html", "cycloid_mj/scene/assets/layout.json", "cycloid_mj/py.typed"} <= names
    assert "hsieh2014/assets/reproduction.html" in names


@pytest.fixture(scope="module")
def installed(built: tuple[set[str], Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install the wheel, and nothing else, into a folder of its own."""
    target = tmp_path_factory.mktemp("installed")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
    options = ["--no-deps", "--no-index", "--no-compile", "--target", str(target)]
    subprocess.run([*pip, *options, str(built[1])], check=True, capture_output=True, text=True)
    return target


def told(target: Path, *command: str) -> str:
    """Run a command whose packages are first those of `target`, away from the sources, and give what it prints."""
    environment = {**os.environ, "PYTHONPATH": str(target)}
    done = subprocess.run(command, cwd=target, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


LOOK = """
import importlib.metadata, cycloid_mj, hsieh2014
from cycloid_mj.design import PRESETS
from cycloid_mj.papers import papers
from cycloid_mj.reducer import Reducer
from cycloid_mj.report.page import environment
from cycloid_mj.scene.layout import viewer_layout
print(cycloid_mj.__file__, hsieh2014.__file__)
print(importlib.metadata.version("cycloid-mj"), [paper.key for paper in papers()])
print(sorted(environment().list_templates()))
print(bool(viewer_layout(Reducer(PRESETS["pin"]))["configById"]))
"""


@pytest.mark.slow
def test_the_installed_wheel_finds_its_assets_and_its_papers(installed: Path) -> None:
    places, found, templates, layout = told(installed, sys.executable, "-c", LOOK).splitlines()
    assert all(place.startswith(str(installed)) for place in places.split())
    assert found == f"{__version__} ['hsieh2014']"
    assets = ROOT / "cycloid_mj" / "report" / "assets"
    assert templates == str(sorted(path.name for path in assets.iterdir()))
    assert layout == "True"


@pytest.mark.slow
def test_the_installed_command_states_its_version(installed: Path) -> None:
    assert told(installed, str(installed / "bin" / "cycloid-mj"), "--version") == __version__


def test_the_citation_is_of_this_version() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["cff-version"] == "1.2.0"
    assert (citation["title"], citation["version"]) == (PROJECT["name"], __version__)
    assert citation["license"] == PROJECT["license"]
    assert {"message", "authors", "abstract", "keywords"} <= set(citation)
    assert citation["keywords"] == PROJECT["keywords"]
