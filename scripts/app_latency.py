"""Measure in Chromium how long the designer's page takes from a move of a slider to the new drawing and to the figures.

    python scripts/app_latency.py [--design pin] [--moves 40]

Needs Chromium and its driver. Times are the browser's own clock, from the pointer's move to the change on the page.
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
const figures = () => document.body.innerText.match(/by statics[^]*?largest force of the cam[^\\n]*\\n[^\\n]*/)?.[0];
window.begin = () => {
  window.moved = window.drawn = window.solved = null;
  window.before = [picture(), figures()];
};
document.addEventListener('mousemove', () => { window.moved ??= performance.now() }, true);
new MutationObserver(() => {
  if (!window.moved) return;
  const now = performance.now();
  if (picture() !== window.before[0]) window.drawn ??= now;
  if (figures() !== window.before[1] && figures()) window.solved ??= now;
}).observe(document.body, {childList: true, subtree: true, characterData: true});
"""


def main() -> int:
    """Serve the page, move a slider again and again, print both times."""
    from selenium import webdriver
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By

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
        while "cam bearing" not in driver.execute_script("return document.body.innerText"):
            time.sleep(0.1)
        driver.execute_script(WATCH)
        slider = driver.find_elements(By.CSS_SELECTOR, ".q-slider")[3]
        for move in range(options.moves):
            driver.execute_script("window.begin()")
            way = 3 if move % 2 else -3
            ActionChains(driver, duration=0).click_and_hold(slider).move_by_offset(way, 0).release().perform()
            time.sleep(1.5)
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
