"""The designer's page: what it shows of any design, and the page in a real browser."""

import os
import random
import re
import shutil
import socket
import subprocess
import sys
import time
import tomllib
import urllib.request
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import pytest
from designs import UNLIKE, unlike

from cycloid_mj.app.drawing import mechanism_svg
from cycloid_mj.app.knobs import knobs, turned
from cycloid_mj.app.made import FILES
from cycloid_mj.app.running import Runner
from cycloid_mj.app.shown import failed, life_lines, static_lines
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.errors import CycloidError

DESIGNS = {**PRESETS, **{name: unlike(name) for name in UNLIKE}}
BROWSER, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")


@pytest.mark.parametrize("design", DESIGNS.values(), ids=DESIGNS)
def test_the_sliders_start_where_the_design_is_and_go_either_way(design: Design) -> None:
    for knob in knobs(design):
        assert knob.low <= knob.value <= knob.high or (knob.key, knob.value) == ("load.torque_nm", 0.0)
        assert knob.low < knob.low + knob.step < knob.high
        assert (knob.high - knob.low) / knob.step <= 3000.0
    same = {knob.key: knob.value for knob in knobs(design)}
    changed = turned(design, same)
    assert changed.but(output={"hole_radius": design.output.hole_radius}) == design


@pytest.mark.parametrize("design", DESIGNS.values(), ids=DESIGNS)
def test_the_drawing_is_whole_and_within_its_frame(design: Design) -> None:
    root = ET.fromstring(mechanism_svg(design, 0.4))
    x, y, width, height = map(float, root.attrib["viewBox"].split())
    space = "{http://www.w3.org/2000/svg}"
    circles, paths = root.findall(f".//{space}circle"), root.findall(f".//{space}path")
    pins = design.ring.teeth if design.ring.kind == "pin" else 0
    assert len(circles) == pins + design.output.pins + 2
    assert len(paths) == 1 + design.gear.discs
    numbers = [float(one) for path in paths for one in re.findall(r"-?\d+\.\d+", path.attrib["d"])]
    assert x <= min(numbers) < max(numbers) <= x + width
    assert min(y, height) == -max(-y, -height) or height == width


def test_figures_follow_the_design() -> None:
    pin = override(PRESETS["pin"], ["load.torque_nm=30"])
    wide = override(pin, ["clearance.pin_gear_um=5"])
    told = [{line.name: line.value for line in static_lines(design)} for design in (pin, wide)]
    backlash = [float(one["backlash"].split()[0]) for one in told]
    assert backlash[1] - backlash[0] == pytest.approx(4.0e-6 * 2.0 / (1e-3 * 35) * 10800 / 3.14159265, rel=0.05)
    assert "30 N m" in told[0]["by statics, at"]
    assert any(line.name.startswith("weakest") for line in life_lines(pin))


def test_what_breaks_is_told_with_its_reason_errors_first() -> None:
    broken = override(PRESETS["pin"], ["output.pin_circle_radius_mm=17", "load.torque_nm=80"])
    found = failed(broken)
    assert [one.severity for one in found] == sorted((one.severity for one in found), key=lambda one: one != "error")
    assert any("bore" in one.name for one in found)
    with pytest.raises(CycloidError):
        mechanism_svg(turned(PRESETS["pin"], {"gear.eccentricity_mm": 3.0}), 0.0)


@pytest.mark.parametrize("name", ["TOML", "STL", "DXF", "STEP", "Datasheet"])
def test_every_button_gives_a_file(name: str) -> None:
    ((file, content),) = FILES[name](PRESETS["nonpin"]).items()
    assert file.startswith("nonpin")
    assert content.startswith({"TOML": b"#", "Datasheet": b"%PDF"}.get(name, b"PK"))


def test_a_run_of_the_page_ends_with_its_report() -> None:
    runner = Runner()
    page = runner.run(override(PRESETS["nonpin"], ["load.torque_nm=30"]))
    assert runner.share == 1.0
    assert page.lstrip().startswith("<!")
    with pytest.raises(CycloidError, match="stands still"):
        runner.run(PRESETS["nonpin"].but(drive={"speed": 0.0}))


def test_mistakes_are_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["app", "--design", "pin", "--port", "0"]) == 2
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        assert main(["app", "--no-browser", "--port", str(taken.getsockname()[1])]) == 1
    errors = capsys.readouterr().err.splitlines()
    assert len(errors) == 2
    assert "is taken" in errors[1]


# --- in a browser


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, Path]]:
    """Serve the page as a user does; give its address and what the server wrote."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    log = tmp_path_factory.mktemp("app") / "log"
    command = [sys.executable, "-m", "cycloid_mj.cli", "app", "--no-browser", "--port", str(port)]
    environment = {key: value for key, value in os.environ.items() if "PYTEST" not in key}
    with log.open("w") as written, subprocess.Popen(command, stdout=written, stderr=written, env=environment) as server:
        for _ in range(600):
            try:
                urllib.request.urlopen(f"http://127.0.0.1:{port}").close()
                break
            except OSError:
                time.sleep(0.1)
        yield f"http://127.0.0.1:{port}", log
        server.terminate()


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator:
    if not (BROWSER and DRIVER):
        pytest.skip("needs Chromium and its driver (Debian: chromium, chromium-driver)")
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    folder = tmp_path_factory.mktemp("downloads")
    options.add_experimental_option("prefs", {"download.default_directory": str(folder)})
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    for word in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1400,1000"):
        options.add_argument(word)
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    driver.folder = folder
    yield driver
    driver.quit()


def wait(found, what: str, seconds: float = 60.0):
    """Give what `found` gives as soon as it gives something."""
    for _ in range(int(seconds / 0.05)):
        if one := found():
            return one
        time.sleep(0.05)
    raise AssertionError(what)


def text(browser) -> str:
    return browser.execute_script("return document.body.innerText")


def test_the_page_in_a_browser(served: tuple[str, Path], browser) -> None:
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By

    address, log = served
    browser.get(address)
    wait(lambda: "cam bearing" in text(browser), "figures and life come up")
    sliders = browser.find_elements(By.CSS_SELECTOR, ".q-slider")
    assert len(sliders) == 15
    drawn = "return document.querySelector('svg[aria-label]').outerHTML"

    # ten drags at random: each redraws, and nothing is thrown here or there
    rng = random.Random(7)
    for _ in range(10):
        before = browser.execute_script(drawn)
        slider = sliders[rng.choice([0, 1, 2, 3, 5, 7, 8, 14])]
        ActionChains(browser, duration=30).click_and_hold(slider).move_by_offset(
            rng.randint(-45, 45), 0
        ).release().perform()
        wait(lambda was=before: browser.execute_script(drawn) != was or "not allowed" in text(browser), "it is redrawn")
    severe = [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]
    assert not severe
    assert "Traceback" not in log.read_text()

    # a check that breaks is told
    browser.get(address)
    wait(lambda: "cam bearing" in text(browser), "the page starts anew")
    slider = browser.find_elements(By.CSS_SELECTOR, ".q-slider")[8]
    ActionChains(browser, duration=30).click_and_hold(slider).move_by_offset(-60, 0).release().perform()
    wait(lambda: re.search(r"error: |not allowed", text(browser)), "the hole circle no longer fits")

    # the switch, a download, a run
    browser.get(address)
    wait(lambda: "cam bearing" in text(browser), "the page starts anew")
    next(one for one in browser.find_elements(By.TAG_NAME, "button") if one.text == "NONPIN").click()
    wait(lambda: "largest force on a tooth" in text(browser), "nonpin's figures")
    next(one for one in browser.find_elements(By.TAG_NAME, "button") if one.text == "TOML").click()
    file = wait(lambda: next(browser.folder.glob("*.toml"), None), "the design is downloaded")
    assert tomllib.loads(file.read_text())["ring"]["kind"] == "nonpin"
    next(one for one in browser.find_elements(By.TAG_NAME, "button") if one.text == "RUN IN MUJOCO").click()
    link = wait(lambda: browser.find_elements(By.PARTIAL_LINK_TEXT, "report of the run"), "the run ends", 120.0)
    browser.get(link[0].get_attribute("href"))
    assert "transmission error" in text(browser).lower()

    # on a phone nothing sticks out
    browser.set_window_size(420, 900)
    browser.get(address)
    wait(lambda: "cam bearing" in text(browser), "the page on a phone")
    assert browser.execute_script("return document.documentElement.scrollWidth <= window.innerWidth")
    assert "Traceback" not in log.read_text()
