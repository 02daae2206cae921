"""Links, modules, files and figures in the documentation exist and are right."""

import importlib
import importlib.util
import re
from pathlib import Path

import pytest

from cycloid_mj.design import PRESETS
from cycloid_mj.life.items import rate
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.sheet import sheet

ROOT = Path(__file__).parent.parent
WRITTEN = [
    page
    for page in sorted((ROOT / "docs").rglob("*.md"))
    if not page.relative_to(ROOT / "docs").parts[0].startswith("_")
]
FOR_USERS = {"tutorial", "tour", "log-format"}
"""Pages that mention files of the user."""

PAGES = [ROOT / "CONTRIBUTING.md", *WRITTEN]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_links_resolve(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8")):
        if not re.match(r"https?:|_", target):  # generated pages are checked by the build
            assert (page.parent / target).exists(), target


@pytest.mark.parametrize("page", [page for page in PAGES if page.stem not in FOR_USERS], ids=lambda page: page.stem)
def test_files_and_modules_exist(page: Path) -> None:
    for word in re.findall(r"`([\w./]+)`", page.read_text(encoding="utf-8")):
        if "/" in word:
            assert any((root / word).exists() for root in (ROOT, ROOT / "cycloid_mj")), word
        elif re.fullmatch(r"(mechanism|loaded|cycloid_mj)\.[a-z_.]+", word):
            module = word if word.startswith("cycloid_mj") else f"cycloid_mj.{word}"
            assert importlib.util.find_spec(module), word


def test_figures_of_statics_are_those_of_the_code() -> None:
    """Figures of `pin` at 36.68 N m on the pages agree with statics and rating to all printed digits."""
    design = PRESETS["pin"]
    found = {key: one.value for key, one in sheet(Reducer(design)).quantities.items()}
    items = rate(design).items
    printed = {
        "explore": (
            f"| largest pressure on the teeth [MPa] | {found['pin_gear_pressure']:.0f} |",
            f"| capacity, first yield of any contact [N m] | {found['capacity']:.1f} |",
            f"| backlash, mean [arcmin] | {found['backlash']:.3f} |",
            f"| stiffness [N m/arcmin] | {found['stiffness_ideal']:.1f} |",
            f"largest tooth force [N] | {found['pin_gear_peak_force']:.0f} |",
            f"| friction of the teeth [W] | {found['pin_gear_friction_power']:.1f} |",
            f"[arcsec] | {found['output_peak_to_peak_loaded_forward_speed']:.2f} |",
            f"output, unloaded, peak to peak [arcsec] | {found['output_peak_to_peak_unloaded_forward_speed']:.2f} |",
        ),
        "rating": (
            f"| {items['cam_bearing'].value:.0f} N | 1687 rpm | {round(items['cam_bearing'].life, -2):,.0f} h |",
        ),
        "peers": (
            f"| {found['cam_mean_force']:.0f} N mean, {found['cam_peak_force']:.0f} N largest |",
            f"as a beam: {items['shaft_bearing_near'].value:.0f} N and {items['shaft_bearing_far'].value:.0f} N",
            f"{items['output_pin_fatigue'].safety:.2f} with its core of 3 mm",
            f"| {items['power_lost'].value:.1f} W, {items['temperature'].value:.0f} °C",
            f"| {found['backlash']:.2f} arcmin",
            f"| {found['efficiency']:.1f} % |",
        ),
    }
    for page, figures in printed.items():
        text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8").replace(",", " ")
        assert not [figure for figure in figures if figure.replace(",", " ") not in text], page


def test_the_data_flow_names_existing_functions() -> None:
    text = (ROOT / "docs" / "data-flow.md").read_text(encoding="utf-8")
    named = re.findall(r"`([\w/]+):(\w+)`", text)
    assert len(named) > 30
    for module, name in named:
        found = importlib.import_module(f"cycloid_mj.{module.replace('/', '.').removesuffix('.__init__')}")
        assert callable(getattr(found, name)), f"{module}:{name}"


@pytest.mark.parametrize("page", sorted((ROOT / "docs" / "physics").glob("*.md")), ids=lambda page: page.stem)
def test_every_section_of_the_equations_names_existing_tests(page: Path) -> None:
    sections = re.split(r"^## ", page.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    assert sections
    for section in sections:
        named = re.findall(r"\[`(test_\w+)`\]\(\.\./\.\./(tests/(?:\w+/)?test_\w+\.py)\)", section)
        assert named, section.splitlines()[0]
        for name, file in named:
            assert f"\ndef {name}(" in (ROOT / file).read_text(encoding="utf-8"), f"{file}: {name}"
            section = section.replace(f"`{name}`", "")
        assert "`test_" not in section, "a test without its file"


def test_every_design_decision_states_reason_alternatives_and_check() -> None:
    text = (ROOT / "docs" / "decisions.md").read_text(encoding="utf-8")
    sections = re.split(r"^## ", text, flags=re.MULTILINE)[1:]
    assert sections
    for section in sections:
        assert re.findall(r"^\*\*(\w+)\.\*\*", section, flags=re.MULTILINE) == ["Why", "Rejected", "Check"], section


def test_the_check_of_one_package_names_the_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "scripts"))
    import check

    assert not any(word.startswith("tests/") for word in check.tests(None))
    assert "tests/reducer" in check.tests("reducer")
    with pytest.raises(SystemExit, match=r"choose one of .*reducer"):
        check.tests("cellar")
