"""The page itself, by NiceGUI: sliders, the mechanism, checks, figures, and what can be made of the design."""

import asyncio
import math
from collections.abc import Callable
from html import escape
from typing import Any

from nicegui import app, run, ui
from starlette.responses import HTMLResponse

from cycloid_mj.app.drawing import mechanism_svg
from cycloid_mj.app.knobs import Knob, knobs, turned
from cycloid_mj.app.made import FILES
from cycloid_mj.app.running import Runner
from cycloid_mj.app.shown import Line, failed, life_lines, static_lines
from cycloid_mj.checks import Check
from cycloid_mj.design import Design, override
from cycloid_mj.errors import CycloidError

WAIT = 0.04
"""Seconds between two redraws while a slider moves."""

START_DEG = 17.0
"""Crank angle that the page starts with."""

SHAPES = {
    "pin": {"ring.kind": "pin", "gear.discs": 1},
    "nonpin": {"ring.kind": "nonpin", "gear.discs": 1},
    "two discs": {"ring.kind": "pin", "gear.discs": 2},
}
"""The switch above the sliders -> values of the design."""

STYLE = """
body { overflow-x: hidden }
.knob { display: grid; grid-template-columns: 11rem 1fr 4.5rem; align-items: center; column-gap: .6rem; width: 100% }
.knob input { text-align: right }
.told { display: grid; grid-template-columns: minmax(0, 1fr) minmax(0, 1fr); column-gap: .8rem; padding: .1rem 0 }
@media (max-width: 700px) { .knob { grid-template-columns: 8.5rem 1fr 4rem; font-size: .85rem } }
"""


def serve(design: Design, port: int, show: bool) -> None:
    """Serve the page on this machine alone until the process is stopped; every window has a design of its own."""
    reports: dict[str, str] = {}

    @app.get("/report/{number}", response_class=HTMLResponse)
    def report(number: str) -> str:
        return reports.get(number, "This report is gone: run the design again.")

    @ui.page("/")
    def page() -> None:
        _Page(design, reports)

    ui.run(
        host="127.0.0.1",
        port=port,
        show=show,
        reload=False,
        title="cycloid_mj",
        favicon="⚙",
        dark=None,
        show_welcome_message=False,
    )


class _Page:
    """One window: its design, and the elements that show it."""

    def __init__(self, design: Design, reports: dict[str, str]) -> None:
        load = {"torque": design.load.torque or design.rated_torque}
        self._base, self._reports, self._runner = design.but(load=load), reports, Runner()
        self._values: dict[str, Any] = {}
        self._design, self._sound, self._crank = self._base, False, math.radians(START_DEG)
        self._stale, self._working = False, False
        ui.add_css(STYLE)
        with ui.row().classes("w-full items-start gap-4"):
            with ui.column().classes("w-full md:w-96 gap-1 order-2 md:order-1"):
                start = "two discs" if design.gear.discs > 1 else design.ring.kind
                ui.toggle(list(SHAPES), value=start, on_change=lambda event: self._shape(event.value))
                self._sliders = ui.column().classes("w-full gap-0")
                with ui.element("div").classes("knob"):
                    ui.label("crank [deg]")
                    ui.slider(min=0, max=360, value=START_DEG).on("update:model-value", self._turn, throttle=WAIT)
            with ui.column().classes("w-full md:w-1/3 order-1 md:order-2"):
                self._picture = ui.html("", sanitize=False).classes("w-full").mark("mechanism")
            with ui.column().classes("w-full md:w-96 order-3"):
                self._figures = ui.html("", sanitize=False).classes("w-full").mark("figures")
                self._checks = ui.html("", sanitize=False).classes("w-full").mark("checks")
                self._making()
        self._knobs()
        self._redraw()

    def _knobs(self) -> None:
        """Put the sliders anew, as for another kind of ring."""
        self._sliders.clear()
        with self._sliders:
            for knob in knobs(self._base):
                self._knob(knob)

    def _knob(self, knob: Knob) -> None:
        with ui.element("div").classes("knob"):
            ui.label(knob.label)
            slider = ui.slider(min=knob.low, max=knob.high, step=knob.step, value=knob.value).mark(knob.key)
            number = ui.number(value=knob.value, step=knob.step, format="%.6g").props("dense borderless")
            number.bind_value(slider)
            slider.on("update:model-value", lambda event: self._set(knob.key, event.args), throttle=WAIT)
            number.on("change", lambda: self._set(knob.key, number.value))

    def _making(self) -> None:
        with ui.row().classes("gap-2"):
            for label, make in FILES.items():
                ui.button(label, on_click=lambda event, make=make: self._give(event.sender, make)).props(
                    "outline dense"
                ).mark(label)
        with ui.row().classes("items-center gap-2 w-full"):
            self._run_button = ui.button("Run in MuJoCo", on_click=self._run).props("dense").mark("run")
            self._progress = ui.linear_progress(value=0.0, show_value=False).classes("w-40")
            self._outcome = ui.html("", sanitize=False).mark("outcome")
        self._progress.visible = False

    def _shape(self, name: str) -> None:
        try:
            self._base = override(self._design, SHAPES[name])
        except CycloidError as error:
            self._refuse(str(error))
            return
        self._values = {}
        self._knobs()
        self._redraw()

    def _set(self, key: str, value: Any) -> None:
        if isinstance(value, (int, float)):
            self._values[key] = value
            self._redraw()

    def _turn(self, event: Any) -> None:
        self._crank = math.radians(float(event.args))
        self._draw()

    def _redraw(self) -> None:
        """Draw the design with the values of the sliders and say what breaks; have its figures solved."""
        try:
            self._design = turned(self._base, self._values)
            self._draw()
            broken = failed(self._design)
        except CycloidError as error:
            self._refuse(str(error))
            return
        self._sound = not any(one.severity == "error" for one in broken)
        self._checks.set_content(_told_checks(broken))
        self._stale = True
        if not self._working:
            asyncio.get_running_loop().create_task(self._solve())

    def _draw(self) -> None:
        self._picture.set_content(mechanism_svg(self._design, self._crank))

    async def _solve(self) -> None:
        """Solve the newest design until none is newer."""
        self._working = True
        while self._stale:
            self._stale = False
            if not self._sound:
                self._figures.set_content("")
                continue
            content = ""
            for make in (static_lines, life_lines):
                content += await run.io_bound(_solved, make, self._design) or ""
                if self._stale:
                    break
                self._figures.set_content(content)
        self._working = False

    def _refuse(self, text: str) -> None:
        self._sound = False
        self._checks.set_content(_row("not allowed", escape(text)))
        self._figures.set_content("")

    async def _give(self, button: ui.button, make: Callable[[Design], dict[str, bytes]]) -> None:
        button.disable()
        try:
            files = await run.io_bound(make, self._design)
        except CycloidError as error:
            ui.notify(str(error), type="negative", multi_line=True)
        else:
            for name, content in (files or {}).items():
                ui.download.content(content, name)
        finally:
            button.enable()

    async def _run(self) -> None:
        if not self._sound:
            ui.notify("the design has failed checks: mend them first", type="negative")
            return
        self._progress.visible, self._outcome.content = True, ""
        self._run_button.disable()
        watch = ui.timer(0.1, lambda: self._progress.set_value(self._runner.share))
        try:
            page = await run.io_bound(self._runner.run, self._design)
        except CycloidError as error:
            self._outcome.set_content(_row("failed", escape(str(error))))
        else:
            number = str(len(self._reports) + 1)
            self._reports[number] = page or ""
            self._outcome.set_content(f'<a href="/report/{number}" target="_blank">report of the run</a>')
        finally:
            watch.cancel()
            self._progress.visible = False
            self._run_button.enable()


def _solved(make: Callable[[Design], tuple[Line, ...]], design: Design) -> str:
    """Give figures as rows of a table, or why there are none."""
    try:
        lines = make(design)
    except CycloidError as error:
        return _row("no figures", escape(str(error)))
    return "".join(_row(line.name, f'<b title="{escape(line.note)}">{escape(line.value)}</b>') for line in lines)


def _told_checks(broken: tuple[Check, ...]) -> str:
    if not broken:
        return _row("checks", "all hold")
    return "".join(_row(f"{one.severity}: {one.name}", escape(str(one).partition(": ")[2])) for one in broken)


def _row(name: str, text: str) -> str:
    return f"<div class=told><span>{name}</span><span>{text}</span></div>"
