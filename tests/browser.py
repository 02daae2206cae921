"""A browser without a window, to measure pages as a reader has them."""

from pathlib import Path

from chromium import CHROMIUM, Tab, tab

__all__ = ["CHROMIUM", "MISSING", "OVERHANG", "UNDRAWN", "Tab", "show", "tab"]

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


def show(page: Tab, file: Path, width: int = 390, scheme: str = "dark") -> None:
    """Open a file on a screen so many pixels wide, in a light or dark scheme."""
    page.screen(width, 900, scheme)
    page.go(file.as_uri())
