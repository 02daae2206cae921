"""Accessibility of the designer's page by the rules of axe, on narrow and wide screens, light and dark."""

from collections.abc import Iterator

import pytest
from app_walk import break_design, serving, wait_for_result
from browser import AXE, CHROMIUM, MISSING, Tab, tab, violations

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not CHROMIUM, reason=MISSING),
    pytest.mark.skipif(not AXE.exists(), reason="needs axe-core (npm install --no-save axe-core)"),
]

SCREENS = [(width, scheme) for width in (360, 768, 1280) for scheme in ("light", "dark")]


@pytest.fixture(scope="module")
def page() -> Iterator[Tab]:
    with serving("--design", "printed") as address, tab() as opened:
        opened.screen(1280, 900)
        opened.go(address)
        wait_for_result(opened)
        yield opened


def require_no_violation(page: Tab) -> None:
    """Fail if axe finds a violation on any of the `SCREENS`; the screen is 1280 px wide afterwards."""
    for width, scheme in SCREENS:
        page.screen(width, 900, scheme)
        assert not violations(page), f"{width} px, {scheme}"


TABS = ("figures", "turn", "error", "losses", "life", "scatter", "stress", "solid", "compare", "make")


@pytest.mark.parametrize("name", TABS)
def test_axe_finds_nothing_on_a_tab(page: Tab, name: str) -> None:
    page.run(f"document.getElementById('tab-{name}').click()")
    page.wait("!document.querySelector('#panel .waits')", "the results of the tab", 300.0)
    require_no_violation(page)


def test_axe_finds_nothing_on_the_start_form(page: Tab) -> None:
    page.run("document.getElementById('new').click()")
    page.run("document.querySelector('#start summary').click()")
    require_no_violation(page)
    page.key("Escape")


def test_axe_finds_nothing_on_a_design_that_cannot_be_built(page: Tab) -> None:
    break_design(page)
    require_no_violation(page)
