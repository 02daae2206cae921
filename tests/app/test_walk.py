"""The designer's page in a real browser: from what a drive is to do to the files that build it.

The fixture `page` and the download use the keyboard alone.
"""

import base64
import re
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from app_walk import SIZES, break_design, download_drive, serving, visit_tabs, wait_for_result, walk
from browser import CHROMIUM, MISSING, OVERHANG, Tab, tab
from pdf_text import pdf_text

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not CHROMIUM, reason=MISSING)]


@pytest.fixture(scope="module")
def downloads(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("downloads")


@pytest.fixture(scope="module")
def page(downloads: Path) -> Iterator[Tab]:
    with serving() as address, tab(downloads) as one:
        one.screen(1400, 950)
        walk(one, address, lambda _: None)
        yield one


@pytest.fixture(autouse=True)
def quiet(page: Tab) -> Iterator[None]:
    """Hold every test to leave no error on the console."""
    yield
    assert not page.errors


def head(page: Tab) -> str:
    return str(page.run("document.querySelector('#head').innerText"))


def test_the_start_form_leads_to_a_drive_that_meets_the_requirements(page: Tab) -> None:
    assert head(page).startswith("15:1 ✓")
    failed = page.run("[...document.querySelectorAll('#head .fails')].map(e => e.innerText)")
    assert all("diameter" in text and "with covers" in text for text in failed), "the search leaves the covers out"
    assert "15:1" in page.run("document.title")


def test_the_files_of_the_drive_close_it(page: Tab, downloads: Path) -> None:
    inside = zipfile.ZipFile(download_drive(page, downloads, lambda _: None)).namelist()
    names = {name.partition("/")[2] for name in inside}
    assert {"plate.3mf", "bom.csv", "assembly.txt", "exploded.png", "drawings/drawings.pdf"} <= names
    assert {"stl/motor_cover.stl", "stl/output_cover.stl", "stl/output_flange.stl", "coupon_block.stl"} <= names
    assert page.run("document.querySelector('.choose select').value") == "nema17"
    assert page.run("document.querySelectorAll('.order li').length") == 10


def test_a_steel_drive_is_designed_and_closed(tmp_path: Path) -> None:
    with serving() as address, tab(tmp_path) as steel:
        steel.screen(1400, 950)
        walk(steel, address, lambda _: None, "steel")
        assert head(steel).startswith("39:1 ✓")
        assert not steel.run("document.querySelectorAll('#head .fails').length")
        inside = zipfile.ZipFile(download_drive(steel, tmp_path, lambda _: None)).namelist()
        assert {name.partition("/")[0] for name in inside} == {"steel-39-drive"}
        names = {name.partition("/")[2] for name in inside}
        assert {"plate.3mf", "bom.csv", "assembly.txt", "exploded.png", "drawings/drawings.pdf"} <= names
        assert not steel.run("document.querySelector('#panel').innerText.includes('Printer')")
        assert not steel.errors


def test_all_tabs_show_results_and_a_remedy_resolves_an_error(page: Tab) -> None:
    seen: list[str] = []
    visit_tabs(page, seen.append)
    assert len(seen) == 6


def test_a_design_file_does_not_wait_for_a_study_which_stops_with_its_tab(page: Tab) -> None:
    page.click("[role=tab]", "Tolerances")
    assert page.run("document.getElementById('spread').value") == "", "the tolerances of the design are the default"
    page.click("#panel button", "Run Monte Carlo")
    page.wait("document.querySelector('#panel progress')", "the study runs")
    files = page.run(
        "import('./net.js').then(net => net.work({ kind: 'toml', design: {} })).then(job => job.files.length)"
    )
    assert files == 1
    assert page.run("!!document.querySelector('#panel progress')"), "the study still runs"
    page.click("[role=tab]", "Figures")
    page.click("[role=tab]", "Tolerances")
    page.wait("!document.querySelector('#panel progress')", "the study was stopped")
    page.click("[role=tab]", "Figures")


SEARCH_WITH_ONE_DRIVE = """
window.realFetch = window.fetch;
window.states = ["running"];
const verdict = { judgement: "passed", words: "1 drive meets the requirements" };
const met = { ...verdict, words: "" };
const drive = { title: "lightest", why: "", figures: {}, life: "500 h", verdicts: {}, verdict: met };
const answer = { required: { torque_nm: 3 }, drives: [drive], verdict, remedies: [], max_torque_nm: 0, limit: "" };
window.fetch = async (address, options) => {
    if (!/job|status|stop/.test(address)) return realFetch(address, options);
    const job = { job: 99, state: states.at(-1), progress: { answer }, result: answer, error: "", files: [] };
    return new Response(JSON.stringify(job), { headers: { "Content-Type": "application/json" } });
};
"""
"""A search that has found its first drive and goes on until its state is "done"."""


def test_the_first_drive_is_shown_and_can_be_chosen_while_the_search_goes_on(page: Tab) -> None:
    """Until the search had ended, the page stated that no design reaches the torque."""
    page.run(SEARCH_WITH_ONE_DRIVE)
    page.run("document.getElementById('new').click()")
    page.run("document.querySelector('#start [type=submit]').click()")
    page.wait("document.activeElement.matches('.drives .first button')", "the first drive has the focus")
    assert page.run("document.querySelector('.answer h3').innerText") == "✓ 1 drive meets the requirements"
    assert page.run("!!document.querySelector('.answer .busy')"), "the search goes on"
    page.run("states.push('done')")
    page.wait("!document.querySelector('.answer .busy')", "the search has ended")
    assert page.run("document.activeElement.matches('.drives .first button')"), "the focus stays"
    page.run("window.fetch = realFetch")
    page.key("Escape")
    page.wait("!document.getElementById('start').open", "the form closes")


def test_the_order_of_keys_is_that_on_the_screen(page: Tab) -> None:
    """On a narrow screen the crank comes first, then the closed parameters, then the tabs."""
    page.screen(390, SIZES[390])
    order = (
        "[...document.querySelectorAll('#crank, #parameters-open > summary, #tab-figures')]"
        ".map(e => e.id || 'parameters').join()"
    )
    # the media query changes with the next rendered frame
    page.wait(f"{order} === 'crank,parameters,tab-figures'", "the crank comes first on a narrow screen")
    tops = page.run(
        "['#crank', '#parameters-open > summary', '[role=tablist]'].map(s => "
        "document.querySelector(s).getBoundingClientRect().top + scrollY)"
    )
    assert tops == sorted(tops)
    page.screen(1400, SIZES[1400])
    first = "document.querySelector('#parameters').compareDocumentPosition(document.querySelector('#crank'))"
    page.wait(f"{first} & Node.DOCUMENT_POSITION_FOLLOWING", "the parameters come first on a wide screen")
    page.wait("document.querySelector('#parameters-open').open", "and are open")


def test_results_are_announced_once_and_not_each_step(page: Tab) -> None:
    wait_for_result(page)
    before = page.run("location.hash")
    page.run(
        "window.said = []; new MutationObserver(() => said.push(document.getElementById('says').textContent))"
        ".observe(document.getElementById('says'), { childList: true })"
    )
    page.run("document.getElementById('k-gear.face_width_mm').focus()")
    for _ in range(5):
        page.key("ArrowRight")
    wait_for_result(page)
    page.wait("said.length", "the results are announced", 180.0)
    page.listen(1.0)
    assert page.run("said.length") <= 2
    assert "rated torque" in page.run("said.at(-1)")
    page.key("z", 2)
    page.wait(f"location.hash === {before!r}", "undone")
    live = page.run("[...document.querySelectorAll('[aria-live], output, [role=status]')].map(e => e.id)")
    assert live == ["says"]


def test_keys_undo_and_redo_and_the_address_contains_the_design(page: Tab) -> None:
    before = page.run("location.hash")
    page.run("document.getElementById('k-gear.face_width_mm').focus()")
    page.key("ArrowRight")
    page.wait(f"location.hash !== {before!r}", "the width is another")
    after = page.run("location.hash")
    page.key("z", 2)
    page.wait(f"location.hash === {before!r}", "undone")
    page.key("z", 2 | 8)
    page.wait(f"location.hash === {after!r}", "redone")
    address = page.run("location.origin")
    page.go("about:blank")
    page.go(f"{address}/{after}")
    page.wait(f"location.hash === {after!r} && document.title.includes('15:1')", "opened by its address")


def test_the_focus_stays_in_place(page: Tab) -> None:
    page.click("[role=tab]", "Figures")
    page.run("document.getElementById('skip').focus()")
    page.key("Enter")
    assert page.run("document.activeElement.id") == "tab-figures"
    page.key("End")
    page.key("ArrowLeft")
    page.run("document.querySelector('#panel .strong').focus()")
    page.key("Enter")
    page.wait("document.querySelector('#panel table')", "A stands beside B")
    assert page.run("document.getElementById('panel').contains(document.activeElement)")
    break_design(page)
    page.wait("document.querySelector('#wrong .remedy')", "a remedy is offered")
    page.run("document.querySelector('#wrong .remedy').focus()")
    page.key("Enter")
    page.wait("document.querySelector('#wrong').hidden", "a button mends it")
    assert page.run("document.getElementById('checks').contains(document.activeElement)")
    wait_for_result(page)


def test_an_invalid_value_is_refused_at_its_slider(page: Tab) -> None:
    page.run("document.querySelector('[data-key=\"ring.teeth\"] [type=number]').select()")
    page.type("3")
    page.key("Enter")
    page.wait("document.querySelector('.refused .said')?.innerText.includes('ring teeth = 3')", "refused where it is")
    wait_for_result(page)


def test_the_saved_file_is_named_after_the_design(page: Tab, downloads: Path) -> None:
    name = page.run("document.querySelector('#name').value")
    page.key("s", 2)
    for _ in range(200):
        if (file := downloads / f"{name}.toml").exists():
            break
        page.listen(0.1)
    assert "teeth = 16" in file.read_text()


@pytest.mark.parametrize("width", [1000, 1400, 1920])
def test_the_header_is_visible_at_the_last_slider(page: Tab, width: int) -> None:
    page.screen(width, 900)
    last = "document.getElementById('k-service.life_h')"
    page.run(f"{last}.scrollIntoView({{ block: 'nearest' }})")
    # pages scroll by whole pixels, and boxes end between them
    page.wait(f"{last}.getBoundingClientRect().bottom < innerHeight + 1", "a slider")
    for part in ("head", "section"):
        top, bottom = page.run(f"(b => [b.top, b.bottom])(document.getElementById('{part}').getBoundingClientRect())")
        assert top >= 0.0, f"the {part} has gone"
        assert bottom <= 900.0, f"the {part} has gone"


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", SIZES)
def test_nothing_overflows_the_screen(page: Tab, width: int, scheme: str) -> None:
    page.screen(width, SIZES[width], scheme)
    for word in ("Figures", "Loads", "Life", "A | B", "Export"):
        page.click("[role=tab]", word)
        assert page.run("document.querySelector('[aria-selected=true]').innerText") == word, "something covers the tab"
        assert not page.run(OVERHANG), word
    assert page.run("document.documentElement.scrollWidth") == width


def test_the_figures_are_on_a_printed_page(page: Tab) -> None:
    wait_for_result(page)
    page.click("[role=tab]", "Figures")
    backlash = page.run("document.querySelector('.figures td').innerText")
    printed = pdf_text(base64.b64decode(page.send("Page.printToPDF")["data"]))
    assert backlash.replace(" ", "") in re.sub(r"\s", "", printed)
