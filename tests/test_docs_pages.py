"""The pages of the documentation build without a warning, load nothing from outside, and fit any screen.

All tests are slow, because they need one build with all examples.
"""

import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import pytest
from browser import CHROMIUM, MISSING, OVERHANG, UNDRAWN, show, tab

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"


class _Links(HTMLParser):
    """Links, loaded resources and anchors of a page."""

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


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> dict[Path, _Links]:
    """Build the pages with all examples and read them."""
    made = tmp_path_factory.mktemp("docs")
    gallery = {"run_stale_examples": "1", "filename_pattern": "/"}
    words = [word for key, value in gallery.items() for word in ("-D", f"sphinx_gallery_conf.{key}={value}")]
    words += ["-W", "--keep-going", "-q", "-d", str(made / "trees"), str(DOCS), str(made / "pages")]
    done = subprocess.run([sys.executable, "-m", "sphinx", *words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    pages: dict[Path, _Links] = {}
    for page in (made / "pages").rglob("*.html"):
        pages[page] = _Links()
        pages[page].feed(page.read_text(encoding="utf-8"))
    return pages


@pytest.mark.slow
def test_pages_load_nothing_from_outside(site: dict[Path, _Links]) -> None:
    assert len(site) > 25
    for page, found in site.items():
        assert not [place for place in found.loads if "//" in place], page.name
        text = page.read_text(encoding="utf-8")
        assert not re.search(r"@import|url\([\"']?https?:", text), page.name


@pytest.mark.slow
def test_links_between_pages_resolve(site: dict[Path, _Links]) -> None:
    for page, found in site.items():
        for link in [link for link in found.links if not re.match(r"[a-z]+:", link)]:
            name, _, anchor = link.partition("#")
            target = (page.parent / unquote(name)).resolve() if name else page
            assert target.exists(), f"{page.name}: {link}"
            if anchor and target in site:
                assert unquote(anchor) in site[target].anchors, f"{page.name}: {link}"


@pytest.mark.slow
@pytest.mark.skipif(not CHROMIUM, reason=MISSING)
def test_pages_fit_a_phone_and_follow_its_theme(site: dict[Path, _Links], tmp_path: Path) -> None:
    concepts = next(page for page in site if page.stem == "concepts")
    with tab() as screen:
        for page in site:
            show(screen, page)
            assert not screen.run(OVERHANG), page.name
            assert not screen.run(UNDRAWN), page.name
            assert not screen.errors, page.name
        for scheme in ("light", "dark"):
            show(screen, concepts, scheme=scheme)
            drawing = 'getComputedStyle(document.querySelector("article img")).filter'
            assert (screen.run(drawing) == "none") == (scheme == "light")
        (tmp_path / "wide.html").write_text("<!doctype html><p style='width: 500px'>too wide</p>", encoding="utf-8")
        show(screen, tmp_path / "wide.html")
        assert screen.run(OVERHANG)


@pytest.mark.slow
def test_every_example_has_a_page_with_a_figure(site: dict[Path, _Links]) -> None:
    pages = {page.stem: found for page, found in site.items()}
    for script in (ROOT / "examples").glob("plot_*.py"):
        assert any("sphx_glr" in place for place in pages[script.stem].loads)
        longest = 120 if "notebook" in script.stem else 70  # the notebook has sixteen cells
        assert 15 < len(script.read_text(encoding="utf-8").splitlines()) <= longest


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
