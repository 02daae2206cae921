"""The page itself, by NiceGUI: sliders, the mechanism, checks, figures, and what can be made of the design."""

import logging
import sys
import traceback
from collections.abc import Callable
from functools import partial
from html import escape
from typing import Any

from nicegui import app, run, ui
from starlette.responses import HTMLResponse

from cycloid_mj.app.drawing import mechanism_svg
from cycloid_mj.app.knobs import SHAPES, Knob, angle, knobs, shape_of, turned
from cycloid_mj.app.local import LocalOnly
from cycloid_mj.app.made import FILES
from cycloid_mj.app.newest import Newest
from cycloid_mj.app.running import Runner
from cycloid_mj.app.shown import FigureLine, check_lines, error_lines, life_lines, refused, static_lines
from cycloid_mj.app.workers import Workers
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.design import Design, override

CRANK = Knob("crank", "crank [deg]", 17.0, 0.0, 360.0, 1.0)
"""The slider that turns the mechanism and is no value of the design."""

SWITCH = 1e-3
"""Seconds after which a thread that runs a design or makes a file lets the page go on."""

STYLE = """
.page { display: grid; width: 100%; gap: 1rem 1.5rem; align-items: start }
.page { grid: "sliders picture figures" / 23rem minmax(0, 1.2fr) minmax(0, 1fr) }
.sliders { grid-area: sliders } .picture { grid-area: picture } .figures { grid-area: figures }
.knob { display: grid; grid-template-columns: 11rem 1fr 4.5rem; align-items: center; column-gap: .6rem; width: 100% }
.knob input { text-align: right }
.told { display: grid; grid-template-columns: minmax(0, 1.2fr) minmax(0, 1fr); column-gap: .8rem; padding: .1rem 0 }
.checks .told { display: block; padding-bottom: .4rem } .checks .told span { display: block }
.checks .told :first-child { font-weight: 600 }
.mechanism svg { display: block; width: 100%; height: auto }
.stale { opacity: .35 }
@media (max-width: 1150px) {
  .page { grid: "sliders picture" auto "sliders figures" 1fr / 23rem minmax(0, 1fr) }
}
@media (max-width: 720px) {
  .page { grid: "picture" "sliders" "figures" / minmax(0, 1fr) }
  .picture { position: sticky; top: 0; z-index: 1; background: white; padding-bottom: .5rem }
  .body--dark .picture { background: var(--q-dark-page) }
  .mechanism svg { max-height: 36vh }
  .knob { grid-template-columns: 9rem 1fr 4rem; font-size: .85rem }
}
"""


def serve(design: Design, port: int, show: bool) -> None:
    """Serve the page on this machine alone until the process is stopped; every window has a design of its own."""
    reports: dict[str, str] = {}
    workers = Workers((static_lines, life_lines, check_lines))
    app.add_middleware(LocalOnly)
    logging.getLogger("nicegui").addFilter(in_one_line)

    @app.get("/report/{number}", response_class=HTMLResponse)
    def report(number: str) -> str:
        return reports.get(number, "This report is gone: run the design again.")

    @ui.page("/")
    def page() -> None:
        Page(design, reports, workers)

    sys.setswitchinterval(SWITCH)
    try:
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
    finally:
        workers.close()


class _Slider(ui.slider):
    """A slider that follows the hand at once: the server does not send it the value that it has."""

    LOOPBACK = False


class Page:
    """One window: its design, and the elements that show it."""

    def __init__(self, design: Design, reports: dict[str, str], workers: Workers) -> None:
        load = {"torque": abs(design.load.torque) or design.rated_torque}
        self._base, self._reports, self._runner = design.but(load=load), reports, Runner()
        self._values: dict[str, Any] = {}
        self._design, self._sound, self._crank = self._base, False, angle(CRANK.value)
        ui.on_exception(self._fail)
        ui.add_css(STYLE)
        with ui.element("div").classes("page"):
            with ui.column().classes("sliders gap-1"):
                ui.toggle(list(SHAPES), value=shape_of(design), on_change=self._reshape)
                self._sliders = ui.column().classes("w-full gap-0")
                _row(CRANK, self._turn)
            with ui.element("div").classes("picture"):
                self._picture = _html("mechanism")
            with ui.column().classes("figures"):
                self._statics, self._life, self._checks = _html("statics"), _html("life"), _html("checks")
                self._making()
        shown = {static_lines: self._statics, life_lines: self._life, check_lines: self._checks}
        self._solved = Newest(workers, {work: partial(_show, element) for work, element in shown.items()})
        self._knobs()
        self._redraw()

    def _knobs(self) -> None:
        """Put the sliders anew, as for another kind of ring."""
        self._sliders.clear()
        with self._sliders:
            for knob in knobs(self._base):
                _row(knob, partial(self._set, knob.key))

    def _making(self) -> None:
        with ui.row().classes("gap-2"):
            for label, make in FILES.items():
                ui.button(label, on_click=lambda event, make=make: self._give(event.sender, make)).props(
                    "outline dense"
                ).mark(label)
        with ui.row().classes("items-center gap-2 w-full"):
            self._run_button = ui.button("Run in MuJoCo", on_click=self._run).props("dense").mark("run")
            self._progress = ui.linear_progress(value=0.0, show_value=False).classes("w-40")
            self._outcome = _html("outcome")
        self._progress.visible = False

    def _reshape(self, event: Any) -> None:
        try:
            self._base = override(self._design, SHAPES[event.value])
        except CycloidError as error:
            self._refuse(refused(error))
            return
        self._values = {}
        self._knobs()
        self._redraw()

    def _set(self, key: str, value: float) -> None:
        self._values[key] = value
        self._redraw()

    def _turn(self, degrees: float) -> None:
        try:
            self._crank = angle(degrees)
        except CycloidError as error:
            self._refuse(refused(error))
            return
        if self._sound:
            self._draw()
        else:
            self._redraw()

    def _redraw(self) -> None:
        """Draw the design with the values of the sliders and say what breaks; have its figures solved."""
        try:
            self._design = turned(self._base, self._values)
        except CycloidError as error:
            self._refuse(refused(error))
            return
        undrawn, errors = self._draw(), error_lines(self._design)
        if reasons := errors or undrawn:
            self._refuse(reasons)
        else:
            self._sound = True
            self._solved.ask(self._design)

    def _draw(self) -> tuple[FigureLine, ...]:
        """Draw the design, or give why it cannot be; what was drawn before then stays, but pale."""
        try:
            self._picture.set_content(mechanism_svg(self._design, self._crank))
        except CycloidError as error:
            self._picture.classes(add="stale")
            return refused(error)
        self._picture.classes(remove="stale")
        return ()

    def _fail(self, error: Exception) -> None:
        """Say what nobody has foreseen."""
        self._refuse((FigureLine("not possible", _named(error)),))

    def _refuse(self, reasons: tuple[FigureLine, ...]) -> None:
        """Say why there are no figures."""
        self._sound = False
        self._solved.drop()
        self._statics.set_content("")
        self._life.set_content("")
        self._checks.set_content(_rows_of(reasons))

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
            self._outcome.set_content(_rows_of((FigureLine("failed", str(error)),)))
        else:
            number = str(len(self._reports) + 1)
            self._reports[number] = page or ""
            self._outcome.set_content(
                f'<a href="/report/{number}" target="_blank" class="text-primary underline">report of the run</a>'
            )
        finally:
            watch.cancel()
            self._progress.visible = False
            self._run_button.enable()


def _named(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"


def in_one_line(record: logging.LogRecord) -> bool:
    """Leave of an exception what it is and where it was raised."""
    if record.exc_info and (error := record.exc_info[1]):
        *_, (frame, line) = traceback.walk_tb(error.__traceback__)
        record.msg = f"error: {_named(error)} ({frame.f_code.co_filename}:{line})"
        record.args, record.exc_info = (), None
    return True


def _row(knob: Knob, changed: Callable[[float], None]) -> None:
    """Put a slider between its label and its value, which can be typed as well."""
    with ui.element("div").classes("knob"):
        ui.label(knob.label)
        slider = _Slider(min=knob.low, max=knob.high, step=knob.step, value=knob.value).mark(knob.key)
        number = ui.number(value=knob.value, step=knob.step, format="%.6g").props("dense borderless")
        for one in (slider, number):
            one.props["aria-label"] = knob.label

    def typed() -> None:
        if number.value is None:  # the box was emptied
            number.set_value(slider.value)
        else:
            slider.set_value(number.value)

    def moved(event: Any) -> None:
        if isinstance(event.value, int | float):
            number.set_value(event.value)
        changed(event.value)

    slider.on_value_change(moved)
    number.on("change", typed)  # once what is typed is whole


def _html(name: str) -> ui.html:
    """Put an element that shows what it is given; its class is its name."""
    return ui.html("", sanitize=False).classes(f"w-full {name}").mark(name)


def _show(element: ui.html, lines: tuple[FigureLine, ...]) -> None:
    element.set_content(_rows_of(lines))


def _rows_of(lines: tuple[FigureLine, ...]) -> str:
    return "".join(
        f"<div class=told><span>{escape(line.name)}</span>"
        f'<span title="{escape(line.note)}">{escape(line.value)}</span></div>'
        for line in lines
    )
