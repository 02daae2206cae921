"""A browser without a window, to measure pages as a reader has them."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
MISSING = "needs Chromium and its driver (Debian: chromium, chromium-driver)"

OVERHANG = """
const width = document.documentElement.clientWidth;
const inside = e => { for (let p = e.parentElement; p && p !== document.body; p = p.parentElement)
    if (getComputedStyle(p).overflowX !== "visible") return true; };
return [...document.body.querySelectorAll("*")].filter(e => {
    const box = e.getBoundingClientRect();
    return box.width && box.left < width && box.right > width + 1 && !inside(e);
}).map(e => `${e.tagName} ${e.className} ${e.textContent.slice(0, 40)}`).slice(0, 5);
"""
"""What hangs over the right edge of the screen, but for what scrolls inside itself."""

UNDRAWN = 'return [...document.images].filter(e => e.loading !== "lazy" && !e.naturalWidth).map(e => e.src)'


@contextmanager
def browser(downloads: Path | None = None) -> Iterator[Any]:
    """Open a browser of 1400 by 1000 pixels, which logs what its console says; downloads go to a folder."""
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    if downloads:
        options.add_experimental_option("prefs", {"download.default_directory": str(downloads)})
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    for word in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1400,1000"):
        options.add_argument(word)
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    try:
        yield driver
    finally:
        driver.quit()


def show(driver: Any, page: Path, width: int = 390, scheme: str = "dark") -> None:
    """Open a page on a screen so many pixels wide, in a light or dark scheme."""
    screen = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
    liking = [{"name": "prefers-color-scheme", "value": scheme}]
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": liking})
    driver.get(page.as_uri())


def errors(driver: Any) -> list[str]:
    """List what the console has said of errors since it was last asked."""
    return [line["message"] for line in driver.get_log("browser") if line["level"] == "SEVERE"]
