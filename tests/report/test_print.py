"""Pages on paper: every figure of a page is there when a browser prints it."""

import base64
import re
from collections.abc import Iterator
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from browser import AXE, CHROMIUM, MISSING, Tab, show, tab, violations
from made_run import made_run
from pdf_text import pdf_text

from cycloid_mj.base.outcome import Outcome
from cycloid_mj.base.result import Curve, Quantity, Table
from cycloid_mj.design import PRESETS
from cycloid_mj.life.datasheet import Datasheet
from cycloid_mj.life.item import RatedItem, Rating
from cycloid_mj.report import report
from cycloid_mj.report.datasheet import datasheet_page
from cycloid_mj.report.rating import rating_page
from cycloid_mj.report.results import MAX_SVG_BYTES, outcome_page

ASSETS = resources.files("cycloid_mj.report").joinpath("assets")

TEXT_TAGS = "td|th|tr|table|dd|dt|dl|div|h1|h2|h3|p|li|ul|pre|figcaption|section|main|header"

ITEM = RatedItem("gear_pitting", "cycloid disc, pitting", 812.5, 900.0, "MPa", 1.234, None, "ISO 6336-2")


def hidden_classes(style: str) -> set[str]:
    """Return the classes that a style sheet hides on paper."""
    printed = "".join(re.findall(r"@media print \{(.*?)\n\}", style, flags=re.DOTALL))
    rules = re.findall(r"([^{}]+)\{([^{}]*)\}", printed)
    return {name for selector, body in rules if "display: none" in body for name in re.findall(r"\.([\w-]+)", selector)}


def test_no_style_sheet_hides_text_on_paper() -> None:
    style = "".join(file.read_text() for file in ASSETS.iterdir() if file.name.endswith(".css"))
    hidden = hidden_classes(style)
    assert "controls" in hidden
    for file in ASSETS.iterdir():
        if file.name.endswith(".html"):
            marked = re.findall(rf'<(?:{TEXT_TAGS})\b[^>]*\bclass="([^"{{]*)"', file.read_text())
            shown = {name for classes in marked for name in classes.split()} - {"controls"}
            assert not shown & hidden, file.name


def datasheet_of_one_value() -> str:
    quantity = Quantity("rated_torque", "Rated torque", 43.21, "N m", "for 6000 h")
    points = np.array([1.0, 2.0])
    curve = Curve("Life", "life", points, points, "torque [N m]", "life [h]")
    sizes = Quantity("drive_diameter_mm", "Overall diameter", 108.4, "mm"), Quantity("run_out", "Run-out", 15.0, "um")
    groups = {"Torque": (quantity,), "Mass and size": sizes}
    sheet = Datasheet(PRESETS["pin"], 6000.0, groups, (curve,) * 3, ("a note",), {}, ITEM)
    return datasheet_page(sheet)


def report_of_a_run() -> str:
    return report({"runs/pin.mcap": made_run(PRESETS["pin"])})


def rating_of_one_item() -> str:
    return rating_page(Rating("pin", "36 N m", 6000.0, {ITEM.key: ITEM}, ("an assumption",)))


def outcome_with_a_table() -> str:
    table = Table("Backlash", ("quantity", "value"), (("backlash", "1.2345"),))
    return outcome_page(Outcome(title="measure", headline={"lost motion": "6.789 arcmin"}, tables=[table], result={}))


PAGES = {
    "datasheet": (datasheet_of_one_value, ["43.2", "N m", "Rated torque", "Ø108.4 mm", "15µm"]),
    "report": (report_of_a_run, ["4.13 arcsec", "1100 N"]),
    "rating": (rating_of_one_item, ["812.5", "1.23", "ISO6336-2"]),
    "outcome": (outcome_with_a_table, ["1.2345", "6.789 arcmin"]),
}


@pytest.fixture(scope="module")
def browser() -> Iterator[Tab]:
    if not CHROMIUM:
        pytest.skip(MISSING)
    with tab() as one:
        yield one


@pytest.mark.parametrize("name", PAGES)
def test_figures_of_a_page_are_in_its_pdf(name: str, browser: Tab, tmp_path: Path) -> None:
    write, figures = PAGES[name]
    file = tmp_path / "page.html"
    file.write_text(write(), encoding="utf-8")
    browser.go(file.as_uri())
    pdf = base64.b64decode(browser.send("Page.printToPDF", printBackground=True)["data"])
    text = re.sub(r"\s+", "", pdf_text(pdf))
    for figure in figures:
        assert re.sub(r"\s+", "", figure) in text, text


@pytest.mark.slow
@pytest.mark.skipif(not AXE.exists(), reason="needs axe-core (npm install --no-save axe-core)")
@pytest.mark.parametrize("name", PAGES)
def test_axe_finds_nothing_on_a_page(name: str, browser: Tab, tmp_path: Path) -> None:
    write, _ = PAGES[name]
    file = tmp_path / "page.html"
    file.write_text(write(), encoding="utf-8")
    for width in (360, 768, 1280):
        for scheme in ("light", "dark"):
            show(browser, file, width, scheme)
            assert not violations(browser), f"{width} px, {scheme}"


@pytest.mark.slow
def test_a_long_word_in_a_note_does_not_widen_a_page(browser: Tab, tmp_path: Path) -> None:
    """Notes of comparisons list keys of the design file, such as output_material.youngs_modulus_mpa."""
    file = tmp_path / "page.html"
    file.write_text(outcome_page(Outcome(title="compare", notes=["key_" * 20], result={})), encoding="utf-8")
    show(browser, file, 320)
    assert browser.run("document.documentElement.scrollWidth") == 320


def test_pictures_of_a_page_have_a_text_and_large_ones_are_pixels() -> None:
    small, large = (lambda form: form.encode()), (lambda form: form.encode() * (MAX_SVG_BYTES if form == "svg" else 1))
    page = outcome_page(
        Outcome(title="compare: a / b", pictures={"x_y": small, "many": large}, captions={"many": "Of a."}, result={})
    )
    assert f'src="data:image/svg+xml;base64,{base64.b64encode(b"svg").decode()}" alt="compare: a / b: x y"' in page
    assert f'src="data:image/png;base64,{base64.b64encode(b"png").decode()}" alt="Of a."' in page
