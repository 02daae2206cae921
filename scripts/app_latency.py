"""Measure in Chromium how long the designer's page takes from a move of a slider to the new drawing and to the figures.

    python scripts/app_latency.py [--design pin] [--moves 40]

Needs Chromium and its driver. Times are by the browser's clock, from the key that moves the slider: until the event is
sent, the answer with the drawing comes, it stands in the page, it is painted, and the figures of statics and rating
stand there. What each step computes is timed beside them, as CPU time, without browser and server.
"""

import argparse
import os
import shutil
import socket
import statistics
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterable
from typing import Any

from cycloid_mj.app.drawing import mechanism_svg
from cycloid_mj.app.knobs import turned
from cycloid_mj.app.shown import check_lines, error_lines, life_lines, static_lines
from cycloid_mj.design import Design, resolve

SLIDER = "eccentricity [mm]"
KEY = "gear.eccentricity_mm"

STEPS = ("sent", "answered", "drawn", "painted", "solved", "rated")

WATCH = """
window.times = {};
const note = key => { window.times[key] ??= performance.now() };
document.addEventListener('keydown', () => { window.times = {}; note('moved') }, true);
const {send} = WebSocket.prototype;
WebSocket.prototype.send = function (data) {
  if (String(data).includes('"event"')) note('sent');
  return send.call(this, data);
};
const {set} = Object.getOwnPropertyDescriptor(WebSocket.prototype, 'onmessage');
Object.defineProperty(WebSocket.prototype, 'onmessage', {set(handle) {
  set.call(this, event => { if (String(event.data).includes('"mechanism"')) note('answered'); handle(event) });
}});
new MutationObserver(records => {
  for (const {target} of records) {
    if (!target.matches?.('.mechanism, .statics, .life')) continue;
    if (target.matches('.statics')) note('solved');
    if (target.matches('.life')) note('rated');
    if (!target.matches('.mechanism')) continue;
    note('drawn');
    requestAnimationFrame(() => setTimeout(() => note('painted')));
  }
}).observe(document, {childList: true, subtree: true});
"""


def main() -> int:
    """Serve the page, move a slider again and again, print the times of each step."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--design", default="pin")
    parser.add_argument("--moves", type=int, default=40)
    options = parser.parse_args()
    measured = _in_browser(options.design, options.moves)
    print(
        f"in the browser [ms from the key]: median, least and most of {options.moves} moves; load {os.getloadavg()[0]}"
    )
    for step in STEPS:
        taken = [times[step] - times["moved"] for times in measured if step in times]
        if taken:
            print(f"  {step:9} {statistics.median(taken):6.0f} {min(taken):6.0f} {max(taken):6.0f}")
    print("computed alone [ms of CPU]: median and least of 8 designs")
    for name, taken in _computed(resolve(options.design)):
        print(f"  {name:9} {statistics.median(taken):6.1f} {min(taken):6.1f}")
    return 0


def _in_browser(design: str, moves: int) -> list[dict[str, float]]:
    """List the times of each move by the browser's clock [ms]."""
    from selenium import webdriver
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys

    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    words = [sys.executable, "-m", "cycloid_mj.cli", "app", "--no-browser", "--design", design, "--port", str(port)]
    times = []
    with subprocess.Popen(words) as server:
        try:
            driver = _chromium(webdriver)
            driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": WATCH})
            _reach(f"http://127.0.0.1:{port}")
            driver.get(f"http://127.0.0.1:{port}")
            _wait_for(driver, ("solved", "rated"), 60.0)
            thumb = driver.find_element(By.CSS_SELECTOR, f".q-slider[aria-label='{SLIDER}'] [tabindex]")
            for move in range(moves):
                time.sleep(0.5)
                thumb.send_keys(Keys.ARROW_LEFT if move % 2 else Keys.ARROW_RIGHT)
                times.append(_wait_for(driver, STEPS, 10.0))
            driver.quit()
        finally:
            server.terminate()
    return times


def _wait_for(driver: Any, steps: Iterable[str], seconds: float) -> dict[str, float]:
    """Compute the times once all steps have theirs, or those that have after some seconds."""
    for _ in range(int(seconds / 0.2)):
        time.sleep(0.2)
        times: dict[str, float] = driver.execute_script("return window.times")
        if all(step in times for step in steps):
            break
    return times


def _computed(design: Design) -> Iterable[tuple[str, list[float]]]:
    """Yield what each step computes, and its CPU times on designs that differ a little [ms]."""
    design = design.but(load={"torque": design.rated_torque})
    designs = [turned(design, {KEY: 1e3 * design.gear.eccentricity * (1.0 - 1e-4 * step)}) for step in range(9)]
    works: dict[str, Callable[[Design], object]] = {
        "drawing": lambda one: mechanism_svg(one, 0.3),
        "errors": error_lines,
        "statics": static_lines,
        "rating": life_lines,
        "checks": check_lines,
    }
    for name, work in works.items():
        taken = []
        for one in designs:
            start = time.process_time()
            work(one)
            taken.append(1e3 * (time.process_time() - start))
        yield name, taken[1:]  # the first loads its code


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
