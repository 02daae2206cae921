"""Use the designer's page as a new user does, by mouse and keyboard alone, and take a picture of each step.

    python scripts/app_walk.py [--out docs/app] [--width 1400] [--scheme light]

Needs Chromium. The steps: require a printed 15:1 actuator of 60 mm that carries 2 N m; read the refusal with the
largest possible torque and the remedies; choose a remedy, then a drive; read its figures.
"""

import argparse
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

ASKED = {"ratio": "15", "diameter_mm": "60", "torque_nm": "2", "life_h": "6000"}

Shown = Callable[[str], None]


@contextmanager
def serving(*words: str) -> Iterator[str]:
    """Serve the page as a user does, and return its address with the access token."""
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
    """Wait for the address that the command prints."""
    for _ in range(900):
        messages.seek(0)
        if printed := re.search(r"http://\S+", messages.read()):
            return printed[0]
        if server.poll() is not None:
            break
        time.sleep(0.1)
    raise RuntimeError("the server did not start")


def walk(page: Tab, address: str, shown: Shown) -> float:
    """Design the actuator; `shown` is called with the name of each step. Return how long it took [s]."""
    page.go(address)
    page.wait("document.querySelector('#start')?.open", "the start form opens by itself")
    began = time.monotonic()
    for number, value in enumerate(ASKED.values()):
        if number:
            page.key("Tab")
        page.type(value)
    shown("1-asked")
    page.key("Enter")
    page.wait("document.querySelector('.ways button')", "the remedies", 400.0)
    page.wait("[...document.querySelectorAll('.way')].find(e => /mm/.test(e.innerText))", "a remedy by size", 400.0)
    shown("2-refused")
    page.click(".way", "mm")
    page.wait("document.querySelector('.drives button')", "drives that carry it", 400.0)
    shown("3-drives")
    page.click(".drives .first button")
    page.wait("!document.querySelector('#start').open", "the form closes")
    wait_for_result(page)
    shown("4-designed")
    taken = time.monotonic() - began
    page.click("[role=tab]", "Life")
    page.wait("document.querySelectorAll('.lying .row').length > 5", "the life of its parts")
    shown("5-life")
    return taken


def wait_for_result(page: Tab) -> None:
    """Wait until the header has all its figures, and the checks are shown next to it."""
    page.wait(
        "(t => t.includes('h') && !t.includes('…'))(document.querySelector('#head').innerText)"
        " && document.querySelector('#checks h2') && !document.querySelector('#head.old, #checks.old')",
        "the header has its figures",
        120.0,
    )


def looks(page: Tab, shown: Shown) -> None:
    """Look at a drive from all sides, break it, and mend it by a button."""
    page.click("[role=tab]", "Loads")
    page.wait("document.querySelectorAll('.chart').length === 3", "forces over the turn")
    shown("6-loads")
    page.click("[role=tab]", "Error")
    page.wait("document.querySelectorAll('.chart').length === 2", "transmission error and orders")
    shown("7-error")
    page.click("[role=tab]", "3-D")
    page.wait("document.querySelector('canvas.solid')", "the assembly")
    page.listen(1.0)
    shown("8-solid")
    page.click("[role=tab]", "Figures")
    page.run("document.getElementById('k-gear.bore_radius_mm').focus()")
    page.key("End")
    page.wait("!document.querySelector('#wrong').hidden", "it cannot be built, and the picture says so")
    shown("9-broken")
    page.click("#wrong .remedy")
    page.wait("document.querySelector('#wrong').hidden", "a button mends it")
    wait_for_result(page)


def main() -> int:
    """Take the pictures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "app")
    parser.add_argument("--width", type=int, default=1400, choices=SIZES)
    parser.add_argument("--scheme", default="light", choices=("light", "dark"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    with serving() as address, tab() as page:
        page.screen(options.width, SIZES[options.width], options.scheme)
        taken = walk(page, address, lambda name: page.picture(options.out / f"{name}.png"))
        looks(page, lambda name: page.picture(options.out / f"{name}.png"))
        print(f"a drive after {taken:.0f} s; load {os.getloadavg()[0]:.1f}")
        if page.errors:
            print(*page.errors, sep="\n", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
