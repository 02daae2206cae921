"""The pages of the documentation: they build without a warning, load nothing from outside, and fit any screen.

All are slow, since the pages are built for them; one example of the gallery is drawn for most, all for one.
"""

import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest
from browser import CHROMIUM, DRIVER, MISSING, OVERHANG, UNDRAWN, browser, errors, show

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
EXAMPLE = "plot_2_own_design"
"""The example that is drawn by default."""

KINDS = {"concepts", "physics", "results", "tutorial", "design-file", "commands", "11-bent-output-pins", EXAMPLE}
"""A page of each kind: drawings, formulas, tables, shell blocks, the two references, a decision, an example."""


class _Links(HTMLParser):
    """What a page links to and loads, and the anchors it has."""

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.anchors: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.anchors |= {given[name] for name in ("id", "name") if name in given}
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        elif tag == "link" and given.get("rel") in {"stylesheet", "icon", "preload"}:
            self.loads.append(given["href"])
        elif "src" in given:
            self.loads.append(given["src"])


def built(made: Path, examples: str) -> dict[Path, _Links]:
    """Build the pages in a folder, draw the examples of this pattern, and read the pages."""
    gallery = {"run_stale_examples": "1", "filename_pattern": examples}
    words = [word for key, value in gallery.items() for word in ("-D", f"sphinx_gallery_conf.{key}={value}")]
    words += ["-W", "--keep-going", "-q", "-d", str(made / "trees"), str(DOCS), str(made / "pages")]
    done = subprocess.run([sys.executable, "-m", "sphinx", *words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    pages: dict[Path, _Links] = {}
    for page in (made / "pages").rglob("*.html"):
        pages[page] = _Links()
        pages[page].feed(page.read_text(encoding="utf-8"))
    return pages


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> dict[Path, _Links]:
    """Collect the pages, with one example drawn."""
    return built(tmp_path_factory.mktemp("docs"), EXAMPLE)


@pytest.mark.slow
def test_pages_load_nothing_from_outside(site: dict[Path, _Links]) -> None:
    assert len(site) > 25
    for page, found in site.items():
        assert not [place for place in found.loads if "//" in place], page.name
        text = page.read_text(encoding="utf-8")
        assert not re.search(r"@import|url\([\"']?https?:", text), page.name


@pytest.mark.slow
def test_links_between_pages_lead_somewhere(site: dict[Path, _Links]) -> None:
    for page, found in site.items():
        for link in [link for link in found.links if not re.match(r"[a-z]+:", link)]:
            name, _, anchor = link.partition("#")
            target = (page.parent / unquote(name)).resolve() if name else page
            assert target.exists(), f"{page.name}: {link}"
            if anchor and target in site:
                assert unquote(anchor) in site[target].anchors, f"{page.name}: {link}"


@pytest.mark.slow
@pytest.mark.skipif(not (CHROMIUM and DRIVER), reason=MISSING)
def test_pages_fit_a_phone_and_follow_its_theme(site: dict[Path, _Links], tmp_path: Path) -> None:
    seen = {page.stem: page for page in site if page.stem in KINDS and page.parent.name != "_modules"}
    assert seen.keys() == KINDS
    with browser() as driver:
        for page in seen.values():
            require_fit(driver, page)
        for scheme in ("light", "dark"):
            show(driver, seen["concepts"], scheme=scheme)
            drawing = 'getComputedStyle(document.querySelector("article img")).filter'
            assert (driver.execute_script(f"return {drawing}") == "none") == (scheme == "light")
        (tmp_path / "wide.html").write_text("<!doctype html><p style='width: 500px'>too wide</p>", encoding="utf-8")
        show(driver, tmp_path / "wide.html")
        assert driver.execute_script(OVERHANG)


def require_fit(driver: Any, page: Path) -> None:
    """Hold a page to fit a phone, draw its pictures and say nothing on the console."""
    show(driver, page)
    assert not driver.execute_script(OVERHANG), page.name
    assert not driver.execute_script(UNDRAWN), page.name
    assert not errors(driver), page.name


def require_figure(site: dict[Path, _Links], example: str) -> None:
    page = next(page for page in site if page.stem == example)
    assert any("sphx_glr" in place for place in site[page].loads)


@pytest.mark.slow
def test_an_example_drew_its_figure_and_all_have_a_page(site: dict[Path, _Links]) -> None:
    require_figure(site, EXAMPLE)
    names = {page.stem for page in site}
    for script in (ROOT / "examples").glob("plot_*.py"):
        assert script.stem in names
        assert 15 < len(script.read_text(encoding="utf-8").splitlines()) <= 70


@pytest.mark.slow
def test_every_example_draws_its_figure_and_every_page_fits_a_phone(tmp_path: Path) -> None:
    site = built(tmp_path, "/")
    for script in (ROOT / "examples").glob("plot_*.py"):
        require_figure(site, script.stem)
    if not (CHROMIUM and DRIVER):
        pytest.skip(MISSING)
    with browser() as driver:
        for page in site:
            require_fit(driver, page)


@pytest.mark.slow
def test_the_design_file_and_every_command_are_explained(site: dict[Path, _Links]) -> None:
    from cycloid_mj.design import Design
    from cycloid_mj.design.units import file_key, section_of

    text = next(page for page in site if page.stem == "design-file").read_text(encoding="utf-8")
    for name, field in Design.model_fields.items():
        for key, inner in (section.model_fields if (section := section_of(field)) else {}).items():
            assert f">{file_key(key, inner)}<" in text, f"{name}.{key}"
    commands = next(page for page in site if page.stem == "commands").read_text(encoding="utf-8")
    assert all(f"cycloid-mj {name}" in commands for name in ("simulate", "measure te", "log repair", "design new"))
    assert "-m sphinx" not in commands
