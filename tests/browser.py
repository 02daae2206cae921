"""A browser without a window, to measure pages as a reader has them."""

from pathlib import Path

from chromium import CHROMIUM, Tab, tab

__all__ = ["AXE", "CHROMIUM", "MISSING", "OVERHANG", "UNDRAWN", "Tab", "show", "tab", "violations"]

MISSING = "needs Chromium (Debian: chromium)"

OVERHANG = """(() => {
const width = document.documentElement.clientWidth;
const inside = e => { for (let p = e.parentElement; p && p !== document.body; p = p.parentElement)
    if (getComputedStyle(p).overflowX !== "visible") return true; };
return [...document.body.querySelectorAll("*")].filter(e => {
    const box = e.getBoundingClientRect();
    return box.width && box.left < width && box.right > width + 1 && !inside(e);
}).map(e => `${e.tagName} ${e.className} ${e.textContent.slice(0, 40)}`).slice(0, 5);
})()"""
"""What hangs over the right edge of the screen, but for what scrolls inside itself."""

UNDRAWN = '[...document.images].filter(e => e.loading !== "lazy" && !e.naturalWidth).map(e => e.src)'


AXE = Path(__file__).parent.parent / "node_modules" / "axe-core" / "axe.min.js"
"""The rules of axe (Deque, MPL-2.0), once ``npm install --no-save axe-core`` has been run."""

VIOLATIONS = """axe.run().then(({ violations }) => violations.map(rule =>
    `${rule.id}: ${rule.nodes.slice(0, 3).map(node => `${node.target} (${node.failureSummary})`).join("; ")}`))"""


def violations(page: Tab) -> list[str]:
    """Return the rules of axe that the open page violates, with elements and reasons."""
    if not page.run("!!window.axe"):
        page.run(f"{AXE.read_text()};true")
    return list(page.run(VIOLATIONS))


def show(page: Tab, file: Path, width: int = 390, scheme: str = "dark") -> None:
    """Open a file on a screen so many pixels wide, in a light or dark scheme."""
    page.screen(width, 900, scheme)
    page.go(file.as_uri())
