"""Measure in Chromium how long the designer's page takes from a key on a slider to the drawing and to the figures.

    python scripts/app_latency.py [--design pin] [--moves 40]

Needs Chromium. Times are by the browser's clock, from the key that moves the slider: until the new section stands in
the page, until it is painted, and until the figures of statics stand in the header. What each step computes is timed
beside them, as CPU time, without browser and server.
"""

import argparse
import os
import statistics
import sys
import time
from collections.abc import Callable, Iterable

from app_walk import serving
from chromium import tab

from cycloid_mj.app import summary
from cycloid_mj.app.api import draw, with_load
from cycloid_mj.app.state import changed, values_of
from cycloid_mj.design import Design, resolve
from cycloid_mj.reducer import Reducer

KEY = "gear.eccentricity_mm"
STEPS = ("drawn", "painted", "solved")

WATCH = """
window.times = {};
const note = key => { window.times[key] ??= performance.now(); };
document.addEventListener("keydown", () => { window.times = {}; note("moved"); }, true);
new MutationObserver(() => { note("drawn"); requestAnimationFrame(() => setTimeout(() => note("painted"))); })
  .observe(document.getElementById("section"), { childList: true });
new MutationObserver(() => { if (!document.getElementById("tabs").querySelector(".old")) note("solved"); })
  .observe(document.getElementById("panel"), { childList: true });
document.getElementById("k-gear.eccentricity_mm").focus();
"""


def main() -> int:
    """Serve the page, move a slider again and again, print the times of each step."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--design", default="pin")
    parser.add_argument("--moves", type=int, default=40)
    options = parser.parse_args()
    measured = _in_browser(options.design, options.moves)
    print(f"in the browser [ms from the key]: median, least, most of {options.moves}; load {os.getloadavg()[0]:.1f}")
    for step in STEPS:
        taken = [times[step] - times["moved"] for times in measured if step in times]
        if taken:
            print(f"  {step:9} {statistics.median(taken):6.0f} {min(taken):6.0f} {max(taken):6.0f}")
    print("computed alone [ms of CPU]: median and least of 8 designs")
    for name, taken in _computed(with_load(resolve(options.design))):
        print(f"  {name:9} {statistics.median(taken):6.1f} {min(taken):6.1f}")
    return 0


def _in_browser(design: str, moves: int) -> list[dict[str, float]]:
    """List the times of each move by the browser's clock [ms]."""
    times = []
    with serving("--design", design) as address, tab() as page:
        page.screen(1400, 1000)
        page.go(address)
        page.wait("!!document.querySelector('#panel tr') && document.title.includes(':')", "the first figures")
        page.run("document.getElementById('start').close()")
        page.run(f"(() => {{ {WATCH} }})()")
        for move in range(moves):
            time.sleep(0.8)
            page.key("ArrowLeft" if move % 2 else "ArrowRight")
            done = " && ".join(f"window.times.{step}" for step in STEPS)
            page.wait(done, "a move is answered", 20.0)
            times.append(page.run("window.times"))
    return times


def _computed(design: Design) -> Iterable[tuple[str, list[float]]]:
    """Yield what each step computes, and its CPU times on designs that differ a little [ms]."""
    size = 1e3 * design.gear.eccentricity
    designs = [changed(design, {KEY: size * (1.0 - 1e-4 * step)}) for step in range(9)]
    works: dict[str, Callable[[Design], object]] = {
        "drawing": lambda one: draw({"design": values_of(one), "changes": {}}),
        "statics": lambda one: summary.statics(Reducer(one)),
        "life": lambda one: summary.life(Reducer(one)),
        "checks": lambda one: summary.checks(Reducer(one)),
    }
    for name, work in works.items():
        taken = []
        for one in designs:
            start = time.process_time()
            work(one)
            taken.append(1e3 * (time.process_time() - start))
        yield name, taken[1:]  # the first loads its code


if __name__ == "__main__":
    sys.exit(main())
