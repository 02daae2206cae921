"""The designer's page: what it shows of any design, and the page in a real browser."""

import asyncio
import gc
import logging
import math
import os
import random
import re
import signal
import socket
import subprocess
import sys
import time
import tomllib
import urllib.error
import urllib.request
import weakref
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest
import websocket
from browser import CHROMIUM, DRIVER, MISSING, browser, errors
from designs import UNLIKE, unlike
from nicegui.testing.user_simulation import user_simulation
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

from cycloid_mj.app.drawing import mechanism_svg
from cycloid_mj.app.knobs import SHAPES, knobs, shape_of, turned
from cycloid_mj.app.local import LocalOnly
from cycloid_mj.app.made import FILES
from cycloid_mj.app.page import Page, in_one_line
from cycloid_mj.app.running import Runner
from cycloid_mj.app.shown import NAMES, FigureLine, check_lines, error_lines, life_lines, static_lines
from cycloid_mj.app.workers import Workers
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.figures import FIGURES
from cycloid_mj.parts import mass_properties, parts
from cycloid_mj.reducer import Reducer

DESIGNS = {**PRESETS, **{name: unlike(name) for name in UNLIKE}}


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
    rated = [life_lines(override(pin, [f"load.torque_nm={torque}"])) for torque in (10, 20)]
    assert [lines[0].value.partition(" at ")[0] for lines in rated] == ["10 N m", "20 N m"]
    hours = [float(lines[2].value.removesuffix(" h")) for lines in rated]
    assert hours[0] > 4.0 * hours[1]


@pytest.mark.parametrize("design", [PRESETS["twodisc"], unlike("light")], ids=["twodisc", "light"])
def test_every_design_has_its_figures(design: Design) -> None:
    wanted = {"backlash", "lost motion at +-3 %", "transmission error, peak to peak", "efficiency"}
    lines = static_lines(design)
    assert wanted <= {line.name for line in lines}
    assert NAMES.keys() <= FIGURES.keys()
    assert len(lines) == 1 + sum(FIGURES[key].exists(Reducer(design)) for key in NAMES)
    head, weakest, *bearings = life_lines(design)
    assert head.name == "by rating, at"
    assert weakest.name.startswith("weakest: ")
    assert weakest.value
    assert all(line.value.endswith((" h", "endless")) for line in bearings)
    assert len(bearings) == 1
    assert not error_lines(design)
    assert all(line.name.startswith(("warning: ", "checks")) for line in check_lines(design))


def test_what_breaks_is_told_with_its_reason_errors_first() -> None:
    broken = override(PRESETS["pin"], ["output.pin_circle_radius_mm=17", "load.torque_nm=80"])
    told, errors = check_lines(broken), error_lines(broken)
    assert told[: len(errors)] == errors
    assert errors[0].name.startswith("error: ")
    assert any("bore" in line.value for line in errors)
    with pytest.raises(CycloidError):
        mechanism_svg(turned(PRESETS["pin"], {"gear.eccentricity_mm": 3.0}), 0.0)


@pytest.mark.slow
def test_no_place_of_the_sliders_crashes() -> None:
    """Wherever sliders stand, there are figures or a reason for which there are none."""
    rng = random.Random(3)
    for _ in range(8):
        base = rng.choice(list(DESIGNS.values()))
        places = {knob.key: rng.choice([knob.low, knob.high]) for knob in rng.sample(knobs(base), 2)}
        try:
            design = turned(base, places)
            mechanism_svg(design, 0.0)
        except CycloidError:
            continue
        lines = error_lines(design) or (*static_lines(design), *life_lines(design), *check_lines(design))
        assert all(line.value for line in lines)


def test_the_switch_shows_what_a_design_is() -> None:
    assert {name: shape_of(override(PRESETS["pin"], shape)) for name, shape in SHAPES.items()} == {
        name: name for name in SHAPES
    }
    assert shape_of(override(PRESETS["pin"], {"gear.discs": 3})) is None


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in {"MJCF", "Datasheet"})) for name in FILES]
)
def test_every_button_gives_a_file(name: str) -> None:
    ((file, content),) = FILES[name](unlike("few")).items()
    assert file.startswith(unlike("few").name)
    assert content.startswith({"TOML": b"#", "Datasheet": b"%PDF"}.get(name, b"PK"))


def test_a_crank_that_stands_still_is_not_run() -> None:
    with pytest.raises(CycloidError, match="stands still"):
        Runner().run(PRESETS["nonpin"].but(drive={"speed": 0.0}))


def dying(mark: Path, _: Design) -> tuple[FigureLine, ...]:
    """End the process it is done in, as a system without memory does, but the first time alone."""
    if mark.exists():
        mark.unlink()
        os.kill(os.getpid(), signal.SIGKILL)
    return (FigureLine("process", str(os.getpid())),)


@pytest.mark.slow
def test_a_process_that_dies_is_replaced(tmp_path: Path) -> None:
    mark, workers = tmp_path / "mark", Workers(())
    mark.touch()

    async def all_done() -> list[tuple[FigureLine, ...]]:
        return await asyncio.gather(*(workers.do(partial(dying, mark), PRESETS["pin"]) for _ in range(3)))

    try:
        found = asyncio.run(all_done())
    finally:
        workers.close()
    assert not mark.exists()
    assert all(int(line.value) != os.getpid() for (line,) in found)


@pytest.mark.slow
def test_mistakes_are_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["app", "--design", "pin", "--port", "0"]) == 2
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        assert main(["app", "--no-browser", "--port", str(taken.getsockname()[1])]) == 1
    errors = capsys.readouterr().err.splitlines()
    assert len(errors) == 2
    assert "is taken" in errors[1]


# --- whatever a browser may send


@pytest.mark.parametrize(
    ("host", "origin", "answered"),
    [
        ("localhost:8137", None, True),
        ("LOCALHOST", "http://localhost", True),
        ("127.0.0.1:8137", "http://127.0.0.1:8137", True),
        ("[::1]:8137", "http://[::1]:8137", True),
        ("evil.example:8137", None, False),
        ("evil.example:8137", "http://evil.example:8137", False),
        ("127.0.0.1.evil.example", None, False),
        ("localhost@evil.example", None, False),
        ("127.0.0.1:8137", "http://evil.example", False),
        ("127.0.0.1:8137", "http://127.0.0.1:3000", False),
        ("127.0.0.1:8137", "null", False),
        ("[::1", None, False),
        ("", None, False),
        (None, None, False),
    ],
)
@pytest.mark.parametrize("kind", ["http", "websocket"])
def test_only_local_names_of_the_same_origin_are_answered(
    kind: str, host: str | None, origin: str | None, answered: bool
) -> None:
    reached, sent = [], []

    async def app(scope, receive, send) -> None:
        reached.append(scope)

    async def send(message) -> None:
        sent.append(message)

    pairs = ((b"host", host), (b"origin", origin))
    scope = {"type": kind, "headers": [(name, value.encode()) for name, value in pairs if value is not None]}
    asyncio.run(LocalOnly(app)(scope, None, send))
    assert bool(reached) is answered
    if not answered:
        assert sent[0].get("status", 403) == 403
        assert sent[0]["type"] in {"http.response.start", "websocket.close"}


def on_the_page(visit) -> None:
    """Open the page as a simulated browser does, and let `visit` use it; works are done by nobody."""

    class Nobody:
        async def do(self, work, design):
            if design.load.torque == 13.0:
                raise ZeroDivisionError("by the thirteenth")
            return (FigureLine("done", work.__name__),)

    async def run() -> None:
        async with user_simulation(lambda: Page(PRESETS["pin"], {}, Nobody())) as user:
            await user.open("/")
            await visit(user)

    asyncio.run(run())


def shown(user, part: str) -> str:
    (element,) = user.find(part).elements
    return element.content


BAD = [3.7, 1e308, "x", None, [1], math.inf]


def test_values_that_no_design_has_are_told_on_the_page_and_mended(caplog: pytest.LogCaptureFixture) -> None:
    async def visit(user) -> None:
        for key, good in (("ring.teeth", 36), ("crank", 17.0)):
            for value in BAD if key == "ring.teeth" else BAD[2:]:
                user.find(key).trigger("update:modelValue", value)
                assert "not possible" in shown(user, "checks"), (key, value)
                user.find(key).trigger("update:modelValue", good)
                user.find("ring.teeth").trigger("update:modelValue", 36.0)
                await asyncio.sleep(0.01)
                assert "not possible" not in shown(user, "checks"), (key, value)
        user.find("ring.teeth").trigger("update:modelValue", 3.7)
        assert "ring.teeth = 3.7 is not allowed" in shown(user, "checks")

    on_the_page(visit)
    assert "Traceback" not in caplog.text


def test_work_that_fails_is_told_on_the_page_and_in_a_line(caplog: pytest.LogCaptureFixture) -> None:
    async def visit(user) -> None:
        user.find("load.torque_nm").trigger("update:modelValue", 13)
        await asyncio.sleep(0.05)
        assert "ZeroDivisionError: by the thirteenth" in shown(user, "statics")
        user.find("load.torque_nm").trigger("update:modelValue", 14)
        await asyncio.sleep(0.05)
        assert "done" in shown(user, "statics")

    on_the_page(visit)
    assert "Traceback" not in caplog.text
    assert len(caplog.records) == 3  # a work each


def test_an_exception_of_the_server_is_one_line(caplog: pytest.LogCaptureFixture) -> None:
    log = logging.getLogger("of this test")
    log.addFilter(in_one_line)
    try:
        math.sqrt(-1)
    except ValueError as error:
        log.exception(error)
    assert re.fullmatch(r"ERROR .*error: ValueError: .* \(.*test_app.py:\d+\)\n", caplog.text)


def test_shapes_that_a_slider_went_through_are_let_go() -> None:
    first, *others = (turned(PRESETS["pin"], {"ring.pin_radius_mm": 2.0 + 0.001 * step}) for step in range(14))
    solid = parts(Reducer(first), 1e-4)["gear"]
    mass_properties(solid)
    kept = weakref.ref(solid)
    del solid
    for design in others:
        mass_properties(parts(Reducer(design), 1e-4)["gear"])
    gc.collect()
    assert kept() is None


@pytest.mark.slow
def test_a_worker_does_not_grow() -> None:
    """In a process of its own, over more shapes than any cache holds."""
    code = """
import psutil
from cycloid_mj.app.knobs import turned
from cycloid_mj.app.shown import life_lines
from cycloid_mj.design import PRESETS
pin = PRESETS["pin"]
def moved(first, last):
    for step in range(first, last):
        life_lines(turned(pin, {"ring.pin_radius_mm": 2.0 + 0.0005 * step}))
    return psutil.Process().memory_info().rss
print(moved(0, 5) / 1e6, moved(5, 40) / 1e6)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    before, after = map(float, done.stdout.split())
    assert after - before < 30.0


# --- in a browser: one server and one browser for all


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


@pytest.mark.slow
def test_the_server_answers_local_names_alone(served: tuple[str, Path]) -> None:
    own = served[0].removeprefix("http://")
    page = urllib.request.Request(served[0], headers={"Host": own.replace("127.0.0.1", "evil.example")})
    with pytest.raises(urllib.error.HTTPError, match="403"):
        urllib.request.urlopen(page)
    address = f"ws://{own}/_nicegui_ws/socket.io/?EIO=4&transport=websocket"
    websocket.create_connection(address, origin=served[0]).close()
    for host, origin in ((own, "http://evil.example"), ("evil.example", "http://evil.example")):
        with pytest.raises(websocket.WebSocketBadStatusException, match="403"):
            websocket.create_connection(address, origin=origin, host=host)


@pytest.fixture(scope="module")
def page(served: tuple[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Iterator:
    """Open the page in Chromium, and wait for its figures."""
    if not (CHROMIUM and DRIVER):
        pytest.skip(MISSING)
    folder = tmp_path_factory.mktemp("downloads")
    with browser(folder) as driver:
        driver.folder = folder
        driver.get(served[0])
        wait(lambda: solved(driver), "the first figures")
        yield driver


@pytest.fixture(autouse=True)
def quiet(request: pytest.FixtureRequest) -> Iterator[None]:
    """Hold every test in the browser to leave no exception in the server or on the console."""
    yield
    if "page" in request.fixturenames:
        page, (_, log) = request.getfixturevalue("page"), request.getfixturevalue("served")
        assert not errors(page)
        assert "Traceback" not in log.read_text()


def wait(found, what: str, seconds: float = 60.0):
    """Wait for `found` to return something, and return it."""
    for _ in range(int(seconds / 0.05)):
        if one := found():
            return one
        time.sleep(0.05)
    raise AssertionError(what)


def text(page, part: str) -> str:
    return page.execute_script("return document.querySelector(arguments[0]).innerText", f".{part}")


def solved(page) -> bool:
    return "efficiency" in text(page, "statics") and "weakest" in text(page, "life") and bool(text(page, "checks"))


def drawn(page) -> str:
    return page.execute_script("return document.querySelector('.mechanism').innerHTML")


def slider(page, label: str):
    return page.find_element("css selector", f".q-slider[aria-label^='{label}']")


def drag(page, label: str, by: int) -> None:
    ActionChains(page, duration=30).click_and_hold(slider(page, label)).move_by_offset(by, 0).release().perform()


def typed(page, label: str, value: float | str) -> None:
    box = page.find_element("css selector", f"input[aria-label^='{label}']")
    box.send_keys(Keys.CONTROL + "a")
    box.send_keys(f"{value}" or Keys.BACKSPACE, Keys.ENTER)


def press(page, word: str) -> None:
    next(one for one in page.find_elements("tag name", "button") if one.text == word).click()


def test_drags_redraw_and_throw_nothing(page) -> None:
    rng = random.Random(7)
    labels = ("ring teeth", "pin circle", "pin radius", "eccentricity", "bore radius", "output pin [", "crank [")
    for _ in range(10):
        before = drawn(page)
        drag(page, rng.choice(labels), rng.choice([-1, 1]) * rng.randint(5, 45))
        wait(lambda was=before: drawn(page) != was or page.find_elements("class name", "stale"), "it is redrawn")


def test_a_check_that_breaks_is_told_and_mended_by_a_number(page) -> None:
    page.refresh()
    wait(lambda: solved(page), "a new page has the design as it was")
    box = page.find_element("css selector", "input[aria-label^='their circle']")
    ActionChains(page, duration=30).click_and_hold(slider(page, "their circle")).move_by_offset(
        -60, 0
    ).release().perform()
    wait(lambda: re.search(r"error: |not possible", text(page, "checks")), "the holes no longer fit")
    assert not text(page, "statics")
    assert not text(page, "life")
    assert float(box.get_attribute("value")) < 26.0
    press(page, "RUN IN MUJOCO")
    wait(lambda: "mend them first" in page.execute_script("return document.body.innerText"), "no run of such a design")
    typed(page, "their circle", 26)
    wait(lambda: solved(page) and "error" not in text(page, "checks"), "it fits again")

    # a number that no design has is refused, and an emptied box has its number again
    typed(page, "ring teeth", 3)
    wait(lambda: text(page, "checks").startswith("not possible\nring.teeth = 3"), "too few")
    typed(page, "ring teeth", 36)
    wait(lambda: solved(page), "as before")
    typed(page, "ring teeth", "")
    box = page.find_element("css selector", "input[aria-label^='ring teeth']")
    wait(lambda: box.get_attribute("value") == "36", "its number")

    # what cannot even be drawn says so, also while the crank is turned
    typed(page, "eccentricity", 3)
    wait(lambda: page.find_elements("class name", "stale"), "its teeth are undercut")
    assert "error: " in text(page, "checks")
    slider(page, "crank [").find_element("css selector", "[tabindex]").send_keys(Keys.ARROW_RIGHT)
    typed(page, "eccentricity", 1)
    wait(lambda: solved(page), "and is drawn again")


def test_each_window_has_a_design_of_its_own(page, served: tuple[str, Path]) -> None:
    before = drawn(page)
    first = page.current_window_handle
    page.switch_to.new_window("tab")
    page.get(served[0])
    wait(lambda: solved(page), "a second window")
    typed(page, "ring teeth", 30)
    wait(lambda: drawn(page) != before, "it has other teeth")
    page.close()
    page.switch_to.window(first)
    assert drawn(page) == before


def test_the_switch_a_file_and_a_run(page) -> None:
    press(page, "NONPIN")
    wait(lambda: "largest force on a tooth" in text(page, "statics"), "nonpin's figures")
    press(page, "TOML")
    file = wait(lambda: next(page.folder.glob("*.toml"), None), "the design is downloaded")
    assert tomllib.loads(file.read_text())["ring"]["kind"] == "nonpin"
    press(page, "RUN IN MUJOCO")
    wait(lambda: page.find_element("css selector", "[role=progressbar]").is_displayed(), "its progress")
    link = wait(lambda: page.find_elements("partial link text", "report of the run"), "the run ends", 120.0)[0]
    with urllib.request.urlopen(link.get_attribute("href")) as report:
        assert b"transmission error" in report.read().lower()


def test_nothing_sticks_out_on_a_phone(page) -> None:
    size = {"width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True}
    page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    assert page.execute_script("return document.documentElement.scrollWidth") == 390
    page.execute_script("window.scrollTo(0, 500)")
    assert page.execute_script("return document.querySelector('.mechanism').getBoundingClientRect().top") >= 0.0
