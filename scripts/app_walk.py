"""Use the designer's page as a new user does, and take a picture of each step.

    python scripts/app_walk.py [--drive printed] [--out docs/app] [--width 1400] [--scheme light]

Needs Chromium. The steps: enter the requirements of a printed 15:1 actuator of 70 mm for 3 N m, or of a steel 39:1
drive, and choose the motor; read a refusal with the largest possible torque and choose the first remedy; choose a
drive; read its figures; download all files to build it. All this is done by keyboard alone; the tour of the tabs that
follows also uses the mouse.
"""

import argparse
import json
import os
import re
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from chromium import Tab, tab

ROOT = Path(__file__).resolve().parent.parent

SIZES = {390: 844, 1400: 950, 1920: 1080}

REQUIREMENTS = {"printed": ("15", "70", "3"), "steel": ("39", "90", "20")}
"""Process -> ratio, diameter [mm] and torque [N m] of the form."""

MOTORS = {"printed": "nema17", "steel": "nema23"}

FORM_PROCESSES = ("printed", "milled", "steel")
"""Processes in their order on the form; the first one is chosen."""

MAX_REFUSALS = 3
"""Requirements that may be refused one after the other, each changed by its first remedy."""

SEARCH_SECONDS = 1800.0
"""Longest duration of a search [s]: alone, it takes less than a minute; next to other work, it has to wait."""

MAX_TAB_PRESSES = 80
"""Presses of the tab key to reach an element; the page has fewer elements that take the focus."""

Shown = Callable[[str], None]


@contextmanager
def serving(*words: str) -> Iterator[str]:
    """Serve the page as a user does while the context is open, and yield its address with the access token.

    `words` are those of ``cycloid-mj app``.
    """
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "cycloid_mj", "app", "--no-browser", "--port", str(port), *words]
    environment = {key: value for key, value in os.environ.items() if "PYTEST" not in key}
    with (
        tempfile.TemporaryFile("w+") as messages,
        subprocess.Popen(command, stderr=messages, cwd=ROOT, env=environment) as server,
    ):
        try:
            yield _printed_address(server, messages)
        finally:
            server.terminate()


def _printed_address(server: "subprocess.Popen[bytes]", messages: IO[str]) -> str:
    """Wait until the command has printed the page's address, and return it; raise RuntimeError if it ends before."""
    for _ in range(900):
        messages.seek(0)
        if printed := re.search(r"http://\S+", messages.read()):
            return printed[0]
        if server.poll() is not None:
            break
        time.sleep(0.1)
    raise RuntimeError("the server did not start")


def tab_to(page: Tab, selector: str, word: str = "") -> None:
    """Press the tab key until an element that matches a CSS selector and contains a word has the focus.

    Raise TimeoutError if it is not reached within `MAX_TAB_PRESSES`.
    """
    has_focus = f"(e => e.matches({json.dumps(selector)}) && e.textContent.includes({json.dumps(word)}))"
    for _ in range(MAX_TAB_PRESSES):
        if page.run(f"{has_focus}(document.activeElement)"):
            return
        page.key("Tab")
    raise TimeoutError(f"{selector} {word}: not reached by the tab key")


def walk(page: Tab, address: str, on_step: Shown, process: str = "printed") -> float:
    """Design a drive on the page by keyboard, from the start form to its figures; return the duration [s].

    `process` is a key of `REQUIREMENTS`; `on_step` is called with the name of each step that is reached.
    """
    page.go(address)
    page.wait("document.querySelector('#start')?.open", "the start form opens by itself")
    start = time.monotonic()
    for number, value in enumerate(REQUIREMENTS[process]):
        if number:
            page.key("Tab")
        page.type(value)
    tab_to(page, "#start [name=process]")
    for _ in range(FORM_PROCESSES.index(process)):
        page.key("ArrowRight")
    page.wait(f"document.querySelector('#start [name=process]:checked').value === '{process}'", "the process is chosen")
    tab_to(page, "#start summary")
    page.key("Enter")
    tab_to(page, "#start [name=motor]")
    page.key("N")  # the first option that begins with it, NEMA 17
    for _ in range(MOTORS[process] == "nema23"):
        page.key("N")
    page.wait(f"document.querySelector('#start [name=motor]').value === '{MOTORS[process]}'", "the motor is chosen")
    on_step("1-requirements")
    tab_to(page, "#start [type=submit]")
    page.key("Enter")
    for _ in range(MAX_REFUSALS):
        page.wait(
            "document.querySelector('.drives button, .alternative:not(.less)')", "drives, or remedies", SEARCH_SECONDS
        )
        if page.run("!!document.querySelector('.drives button')"):
            break
        on_step("2-refused")
        tab_to(page, ".alternative:not(.less)")
        page.key("Enter")
    page.wait("document.querySelector('.drives button')", "drives that meet the requirements", SEARCH_SECONDS)
    on_step("3-drives")
    tab_to(page, ".drives .first button")
    page.key("Enter")
    page.wait("!document.querySelector('#start').open", "the form closes")
    wait_for_result(page)
    on_step("4-designed")
    return time.monotonic() - start


def download_drive(page: Tab, downloads: Path, on_step: Shown) -> Path:
    """Download all files to build the drive from the tab Export by keyboard, and return the path of the ZIP file."""
    tab_to(page, "[role=tab]")
    page.key("End")
    page.wait("document.querySelector('.bill')", "the bill of materials", 200.0)
    on_step("5-export")
    tab_to(page, "#panel button", "All files to build it")
    page.key("Enter")
    for _ in range(6000):
        if ready := [*downloads.glob("*-drive.zip")]:
            return ready[0]
        page.listen(0.1)
    raise TimeoutError("the files of the drive were not downloaded within 600 s")


def wait_for_result(page: Tab) -> None:
    """Wait until the page's header shows all its figures, and the checks next to it."""
    page.wait(
        "(t => t.includes('h') && !t.includes('…'))(document.querySelector('#head').innerText)"
        " && document.querySelector('#checks h2') && !document.querySelector('#head.old, #checks.old')",
        "the header has its figures",
        120.0,
    )


def break_design(page: Tab) -> None:
    """Set the bore radius to the radius of the output circle, so that no wall is left, and wait for the refusal."""
    circle = page.run("document.getElementById('k-output.pin_circle_radius_mm').value")
    page.run("document.querySelector('[data-key=\"gear.bore_radius_mm\"] [type=number]').select()")
    page.type(circle)
    page.key("Enter")
    page.wait("!document.querySelector('#wrong').hidden", "it cannot be built, and the picture says so")


def visit_tabs(page: Tab, on_step: Shown) -> None:
    """Visit all tabs of a drive, set a value that cannot be built, and repair it by a remedy's button."""
    page.click("[role=tab]", "Loads")
    page.wait("document.querySelectorAll('.chart').length === 3", "forces over the turn")
    on_step("6-loads")
    page.click("[role=tab]", "Accuracy")
    page.wait("document.querySelectorAll('.chart').length === 2", "transmission error and orders")
    on_step("7-error")
    page.click("[role=tab]", "3-D")
    page.wait("document.querySelector('canvas.solid')", "the assembly")
    page.listen(1.0)
    on_step("8-solid")
    for name, words in (("9-exploded", "Exploded"), ("10-step", "Assembly step")):
        page.run(
            f"[...document.querySelectorAll('.range')].find(e => e.innerText === '{words}').firstElementChild.focus()"
        )
        page.key("End" if words == "Exploded" else "ArrowLeft")
        page.listen(0.5)
        on_step(name)
    page.click("[role=tab]", "Figures")
    break_design(page)
    on_step("11-broken")
    page.click("#wrong .remedy")
    page.wait("document.querySelector('#wrong').hidden", "a button mends it")
    wait_for_result(page)


def main() -> int:
    """Walk through the app, and write a picture of each step; return 1 if the page reports errors, else 0."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drive", default="printed", choices=REQUIREMENTS)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "app")
    parser.add_argument("--width", type=int, default=1400, choices=SIZES)
    parser.add_argument("--scheme", default="light", choices=("light", "dark"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)

    def on_step(name: str) -> None:
        page.picture(options.out / f"{name}.png")

    with tempfile.TemporaryDirectory() as downloads, serving() as address, tab(Path(downloads)) as page:
        page.screen(options.width, SIZES[options.width], options.scheme)
        began = time.monotonic()
        taken = walk(page, address, on_step, options.drive)
        content = download_drive(page, Path(downloads), on_step).read_bytes()
        print(f"a drive after {taken:.0f} s, its files after {time.monotonic() - began:.0f} s", end="")
        print(f" ({len(content) / 1e6:.1f} MB); load {os.getloadavg()[0]:.1f}")
        visit_tabs(page, on_step)
        if page.errors:
            print(*page.errors, sep="\n", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
