"""Measure in Chromium how long the designer's page takes from a move of a slider to the new drawing and to the figures.

    python scripts/app_latency.py [--design pin] [--moves 40]

Needs Chromium and its driver. Times are by the browser's clock: from the key that moves the slider to the new page.
"""

import argparse
import shutil
import socket
import statistics
import subprocess
import sys
import time
import urllib.request
from typing import Any

WATCH = """
const picture = () => document.querySelector('svg[aria-label]').outerHTML;
window.figures = () => document.body.innerText.match(/backlash[^]*?largest force of the cam\\s+\\S+/)?.[0];
window.begin = () => {
  window.moved = window.drawn = window.solved = null;
  window.before = [picture(), window.figures()];
};
document.addEventListener('keydown', () => { window.moved ??= performance.now() }, true);
new MutationObserver(() => {
  if (!window.moved) return;
  const now = performance.now();
  if (picture() !== window.before[0]) window.drawn ??= now;
  if (window.figures() !== window.before[1] && window.figures()) window.solved ??= now;
}).observe(document.body, {childList: true, subtree: true, characterData: true});
"""


def main() -> int:
    """Serve the page, move a slider again and again, print both times."""
    from selenium import webdriver
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--design", default="pin")
    parser.add_argument("--moves", type=int, default=40)
    options = parser.parse_args()
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    words = [
        sys.executable,
        "-m",
        "cycloid_mj.cli",
        "app",
        "--no-browser",
        "--design",
        options.design,
        "--port",
        str(port),
    ]
    found: dict[str, list[float]] = {"drawn": [], "solved": []}
    with subprocess.Popen(words) as server:
        driver = _chromium(webdriver)
        _reach(f"http://127.0.0.1:{port}")
        driver.get(f"http://127.0.0.1:{port}")
        driver.execute_script(WATCH)
        for _ in range(300):
            if driver.execute_script("return !!window.figures()"):
                break
            time.sleep(0.1)
        thumb = driver.find_elements(By.CSS_SELECTOR, ".q-slider [tabindex]")[3]
        for move in range(options.moves):
            driver.execute_script("window.begin()")
            thumb.send_keys(Keys.ARROW_LEFT if move % 2 else Keys.ARROW_RIGHT)
            time.sleep(3.0)
            for key, times in found.items():
                if taken := driver.execute_script(f"return window.{key} && window.{key} - window.moved"):
                    times.append(taken)
        driver.quit()
        server.terminate()
    for key, times in found.items():
        print(
            f"{key}: median {statistics.median(times):.0f} ms, {min(times):.0f} to {max(times):.0f}, {len(times)} moves"
        )
    return 0


def _chromium(webdriver: Any) -> Any:
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or sys.exit("needs chromium")
    for word in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1400,1000"):
        options.add_argument(word)
    return webdriver.Chrome(options=options, service=webdriver.ChromeService(shutil.which("chromedriver")))


def _reach(address: str) -> None:
    for _ in range(300):
        try:
            urllib.request.urlopen(address).close()
            return
        except OSError:
            time.sleep(0.1)


if __name__ == "__main__":
    sys.exit(main())
