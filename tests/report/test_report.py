"""The page holds the numbers of the analysis, needs no network, survives odd names, and runs in a browser."""

import base64
import json
import re
import shutil
import subprocess
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from designs import cases
from made_run import STEP, made_run

import cycloid_mj as cm
from cycloid_mj.analysis import FIGURES, SIGNALS, judge, series, table
from cycloid_mj.base.errors import LogError, UsageError
from cycloid_mj.design import PRESETS, override
from cycloid_mj.figures import FIGURES as FIGURES_OF_DESIGNS
from cycloid_mj.log import read, write
from cycloid_mj.reducer import Reducer
from cycloid_mj.report import MAX_RUNS, report, review_page
from cycloid_mj.report.data import CHARTS, curves
from cycloid_mj.report.encode import decimate
from cycloid_mj.report.mechanism import MAGNIFICATIONS
from cycloid_mj.report.page import page as page_of
from cycloid_mj.report.reviewed import review
from cycloid_mj.scene import contact_forces, drawn_radii, fitting_magnification, magnify_gaps, measure_gaps

BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--enable-logging=stderr", "--v=0", "--virtual-time-budget=4000"),
)
VOID = {"meta", "link", "input", "br"}


class Page(HTMLParser):
    """The elements of a page with their attributes, its texts, and whether every tag is closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[tuple[str, str]] = []
        self.open: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append((self.open[-1] if self.open else "", data))

    @property
    def data(self) -> dict:
        return json.loads(next(text for tag, text in self.texts if tag == "script"))

    def ids(self) -> set[str]:
        return {attributes["id"] for _, attributes in self.elements if attributes.get("id")}


def array(packed: dict) -> np.ndarray:
    return np.frombuffer(base64.b64decode(packed["f32"]), "<f4").reshape(packed["shape"]).astype(float)


@pytest.fixture(scope="module")
def pin():
    return made_run(override(PRESETS["pin"], ["drive.ramp_s=0", "drive.hold_s=0.1", "load.torque_nm=36"]), 1000)


@pytest.fixture(scope="module")
def nonpin():
    return made_run(override(PRESETS["nonpin"], ["drive.ramp_s=0", "drive.hold_s=0.1", "load.torque_nm=36"]), 1000)


@pytest.fixture(scope="module")
def text(pin):
    return report({"runs/pin.mcap": pin})


@pytest.fixture(scope="module")
def both(pin, nonpin):
    return report({"runs/pin.mcap": pin, "runs/nonpin.mcap": nonpin})


@pytest.mark.slow
def test_the_page_is_complete_and_needs_no_other_file(text, both):
    for page in (text, both):
        found = Page(page)
        assert found.open == []
        for tag, attributes in found.elements:
            assert tag not in ("img", "iframe", "object", "base")
            if tag == "link":  # an icon of nothing: else a browser asks the server of the page for one
                assert (attributes["rel"], attributes.pop("href")) == ("icon", "data:,")
            assert not {"src", "href", "srcset", "action"} & attributes.keys()
        assert not re.search(r"https?://(?!www\.w3\.org/)|@import|url\(\s*['\"]?(?!#)", page)
        assert "viewport" in [attributes.get("name") for _, attributes in found.elements]
        assert "@media print" in page
        assert "prefers-color-scheme: dark" in page
        assert len(page) < 2e6


def test_every_section_and_figure_is_present_in_order(text, both):
    titles = [words for tag, words in Page(both).texts if tag == "h2"]
    assert titles == [
        "Warnings",  # the paper's design does not pass every check
        *("Mechanism", "Simulation and closed form: 36 N m, 1640 rpm"),
        *("Over time: 36 N m, 1640 rpm", "Order spectrum of output and disc speed"),
        *("Losses", "Provenance"),
    ]
    expected = {f"figure-{figure.name}" for figure in FIGURES} | {"figure-spectrum", "mechanism-0"}
    assert expected <= Page(text).ids()
    assert expected | {"mechanism-1"} <= Page(both).ids()
    used = set(re.findall(r"getElementById\(\"([\w-]+)\"\)", both)) | {"play", "frame", "pace", "magnify", "forces"}
    assert used <= Page(both).ids()


def test_a_negative_loss_is_explained_below_its_table(pin):
    (item,) = review({"a.mcap": pin})
    (first, *others) = item.findings.losses
    for power, explained in ((-1e-3, True), (1e-3, False)):
        losses = (replace(first, normal_w=power), *(replace(one, normal_w=0.0) for one in others))
        text = page_of([replace(item, findings=replace(item.findings, losses=losses))])
        assert ("is elastic energy that is returned" in text) == explained


def test_the_report_shows_static_backlash_and_stiffness(pin, text):
    told = [words for tag, words in Page(text).texts if tag in ("dt", "dd")]
    for name, key in (("backlash", "backlash_arcmin"), ("stiffness at 36 N m", "stiffness_nm_per_arcmin")):
        one = FIGURES_OF_DESIGNS[key]
        value = one.value(Reducer(series(pin).design))
        assert told[told.index(f"{name} (static)") + 1] == f"{value:.3g} {one.unit}"


def test_table_is_that_of_the_analysis(pin, nonpin, both):
    cells = Page(both).texts
    words = [text for tag, text in cells if tag in ("th", "td")]
    for run in (pin, nonpin):
        for row in table(judge(series(run))):
            at = words.index(row.quantity)
            for number in (row.simulated, row.closed_form, row.error):
                assert not number or number.replace("-", "\N{MINUS SIGN}") in words[at : at + 9], (row, number)


def test_curves_are_those_of_the_series(pin, text):
    run = Page(text).data["runs"][0]
    motion = series(pin)
    np.testing.assert_allclose(run["start"] + array(run["time"]), pin.time, atol=1e-8)
    truth = curves(motion)
    assert run["curves"].keys() == truth.keys()
    for name, values in truth.items():
        np.testing.assert_allclose(array(run["curves"][name]), values, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(truth["gear_speed_error"], 3.0 * np.cos(36 * pin["crank_angle"]), atol=1e-9)
    np.testing.assert_allclose(truth["pin_radial"], 1e6 * np.hypot(pin["pin_1_x"], pin["pin_1_y"]), atol=1e-12)
    shown = {
        panel[key] for figure in Page(text).data["figures"] for panel in figure["panels"] for key in ("curve", "theory")
    }
    assert shown - {None} == truth.keys()
    # every signal is drawn somewhere
    drawn = {key for figure in FIGURES for key in (*figure.panels, figure.path)}
    assert drawn - {None} == SIGNALS.keys()
    turn = motion.one_turn
    np.testing.assert_allclose(
        array(run["paths"]["q_path"]["simulated"]), 1e3 * motion.q_position.simulated[turn], rtol=1e-6
    )
    assert run["paths"]["pin_path"]["circle"] == pytest.approx(1.0)
    assert run["spans"]["turn"] == [pin.time[turn][0], pin.time[turn][-1]]


def test_the_mechanism_has_the_gaps_and_forces_of_the_scene(pin, nonpin, both):
    for run, data in zip((pin, nonpin), Page(both).data["runs"], strict=True):
        design = series(run).design
        frames, shape = data["mechanism"]["frames"], data["mechanism"]
        time = frames["start"] + array(frames["time"])
        rows = np.searchsorted(run.time, time - 1e-7)
        np.testing.assert_allclose(run.time[rows], time, atol=1e-8)
        columns = {name: values[rows] for name, values in run.columns.items()}
        measured, acting = measure_gaps(Reducer(design), columns), contact_forces(Reducer(design), columns)
        np.testing.assert_allclose(array(frames["opening"]), 1e3 * measured.opening, rtol=1e-5, atol=1e-12)
        np.testing.assert_allclose(array(frames["outputDistance"]), 1e3 * measured.output_away, rtol=1e-5, atol=1e-12)
        np.testing.assert_allclose(array(frames["force"]["ring"]), acting.of("pin_gear", "tooth").force, rtol=1e-6)
        np.testing.assert_allclose(array(frames["force"]["cam"]), acting.of("cam").force, rtol=1e-6)
        turns = np.ptp(columns["crank_angle"]) / (2 * np.pi)
        assert 0.98 < turns <= 1.001
        for drawn in shape["magnifications"]:
            radii = drawn_radii(Reducer(design), drawn["times"])
            assert drawn["pin"] == pytest.approx(1e3 * radii.pin)
            assert magnify_gaps(Reducer(design), measured, drawn["times"]).radii == radii
        assert ("ring" in shape) == (design.ring.kind == "nonpin")


def test_the_widest_gap_decides_how_wide_gaps_are_drawn(both):
    """No pin is drawn outside its hole, however wide the clearance; gaps of 1 um are still seen."""
    for data in Page(both).data["runs"]:
        assert data["mechanism"]["usual"] >= 100
    for um, largest in ((1.0, 200), (5.0, 50), (50.0, 5), (500.0, 1)):
        design = override(PRESETS["pin"], [f"clearance.{pair}_um={um}" for pair in ("pin_gear", "cam", "output")])
        factor = fitting_magnification(Reducer(design), 2e-6 * um, MAGNIFICATIONS)
        assert factor == largest
        assert factor == 1 or factor * 2e-6 * um <= 0.25 * min(design.ring.pin_radius, design.output.pin_radius)
    text = "".join(both.split())
    assert re.search(r"clearances,atmost[\d.]+µm,aremagnified\d+timesbydefault", text)


def test_page_of_a_log_is_that_of_its_run(pin, tmp_path):
    """Of which it reads forces in the frames of the mechanism alone."""
    path = tmp_path / "pin.mcap"
    write(pin, path)
    assert review_page(path) == report({str(path): read(path)})


def test_decimation_keeps_every_extreme_in_its_place():
    rng = np.random.default_rng(1)
    time = np.cumsum(rng.uniform(0.5, 1.5, 10_007))
    values = rng.normal(size=(10_007, 3))
    few, kept = decimate(time, values, 500)
    assert few.size <= 502
    assert (np.diff(few) >= 0).all()
    width = -(-10_007 // 250)
    for first in range(0, 10_007, width):
        part, pair = values[first : first + width], kept[2 * (first // width) : 2 * (first // width) + 2]
        np.testing.assert_array_equal(pair.min(axis=0), part.min(axis=0))
        np.testing.assert_array_equal(pair.max(axis=0), part.max(axis=0))
        np.testing.assert_array_equal(pair[0] == part.max(axis=0), part.argmax(axis=0) <= part.argmin(axis=0))
        assert few[2 * (first // width)] == time[first]
    same_time, same = decimate(time, values, 10_007)
    assert same_time is time
    assert same is values


@pytest.mark.slow
def test_page_of_a_long_run_stays_small():
    design = override(PRESETS["nonpin"], ["drive.ramp_s=0", "drive.hold_s=5.0"])
    page = report({"a.mcap": made_run(design, 50_000)})
    assert len(page) < 8e6
    data = Page(page).data["runs"][0]
    assert sum(array(curve).size for curve in data["curves"].values()) <= CHARTS.max_values + 2 * len(data["curves"])


def test_the_spectrum_of_a_run_states_its_band_and_turns():
    design = override(PRESETS["pin"], ["drive.ramp_s=0", "drive.hold_s=0.2"])
    page = Page(report({"a.mcap": made_run(design, 2000)}))
    spectrum = page.data["runs"][0]["spectrum"]
    per_turn = 60.0 / 1640.0 / STEP
    # 0.4 of the samples in a turn; three cycles in five turns
    assert spectrum["band"] == pytest.approx([3.0 / 5.0, 0.4 * per_turn], rel=1e-3)
    assert spectrum["turns"] == 5
    assert array(spectrum["order"])[-1] <= spectrum["band"][1]
    assert "error below 1 % from order 0.6 to 146.3" in " ".join(words for _, words in page.texts)


def test_no_spectrum_of_less_than_a_turn():
    design = override(PRESETS["pin"], ["drive.ramp_s=0", "drive.hold_s=0.03"])
    run = made_run(design, 300)
    page = Page(report({"a.mcap": run}))
    assert page.data["runs"][0]["spectrum"] is None
    assert "figure-spectrum" not in page.ids()


def test_warnings_state_what_spoils_the_numbers(pin):
    def told(run) -> list[str]:
        (reviewed,) = review({"a.mcap": run})
        return list(reviewed.findings.warnings)

    assert told(pin) == []
    cut = replace(pin.select(slice(0, 250)), complete=False, note="killed <b>")
    deep = replace(pin, columns={**pin.columns, "penetration": pin["penetration"] + 30e-6})
    assert told(cut)[0] == "the run is incomplete: killed <b>"
    assert "crank turns at constant speed were evaluated" in told(cut)[1]
    assert told(deep) == [
        "largest contact deflection 31 um; a run stops with an error at 50 um (contact.max_penetration_um)"
    ]
    page = report({"a.mcap": cut})
    assert "stopped early" in page
    assert "killed &lt;b&gt;" in page
    assert "killed <b>" not in page


def test_warnings_of_the_design_are_counted_as_warnings_and_unfold(pin):
    checks = cm.check(series(pin).design)
    listed = [*checks.failures, *checks.warnings]
    assert listed
    assert not checks.failures
    page = Page(report({"a.mcap": pin}))
    (summary,) = [words for tag, words in page.texts if tag == "summary" and words.startswith("design checks")]
    assert f"0 failed, {len(listed)} warnings" in summary
    assert all(one.name.replace("_", " ") in summary for one in listed)
    assert [words for tag, words in page.texts if tag == "li"] == [f"{one.judgement}: {one}" for one in listed]
    assert not [one for one in page.elements if one[0] == "details" and "open" in one[1]]


def test_the_settling_time_is_excluded_from_the_report(pin):
    spans = [Page(report({"a.mcap": pin}, settle=settle)).data["runs"][0]["spans"]["hold"] for settle in (None, 0.03)]
    assert spans[0][0] < 0.03
    assert spans[1] == pytest.approx([0.03, pin.time[-1]], abs=1e-4)


def test_a_run_that_ended_in_its_ramp_is_reported(tmp_path):
    design = override(PRESETS["pin"], ["drive.ramp_s=0.2", "drive.hold_s=0.1", "load.torque_nm=36"])
    page = Page(report({"a.mcap": replace(made_run(design, 1000), complete=False, note="stopped by Ctrl-C")}))
    words = " ".join(text for _, text in page.texts)
    assert "ended during the ramp" in words
    assert "No spectrum" in words
    assert page.data["runs"][0]["spans"]["hold"] == pytest.approx([0.0, 0.0999])


def test_odd_names_are_text_and_nothing_else(pin):
    name = "</script><script>alert(1)</script>&.mcap"
    odd = replace(pin, provenance={**pin.provenance, "command": "<i>'\"&", "seed": "</script>"})
    page = report({name: odd, "b.mcap": pin})
    found = Page(page)
    assert found.open == []
    assert sum(tag == "script" for tag, _ in found.elements) == 6
    assert any(name in words for _, words in found.texts)
    assert ("td", "<i>'\"&") in found.texts
    # two designs of one name are told apart by their logs
    assert [run["name"] for run in found.data["runs"]] != ["pin", "pin"]


def test_unsuitable_logs_are_refused(pin):
    with pytest.raises(UsageError, match="but a report shows 1 to 6"):
        report({})
    with pytest.raises(UsageError, match="the number of logs is 7, but a report shows"):
        report({str(k): pin for k in range(MAX_RUNS + 1)})
    with pytest.raises(LogError, match=r"lacks the attached file design\.toml"):
        report({"a": replace(pin, attachments={})})
    with pytest.raises(UsageError, match="point q"):
        report({"a": pin}, q=(1.0, np.nan))


@pytest.mark.skipif(BROWSER is None, reason="no Chromium here")
@pytest.mark.parametrize(("which", "width"), cases([("text", 390), ("both", 1280)], ("both", 1280)))
def test_page_draws_everything_in_a_browser_without_an_error(which, width, request, tmp_path):
    path = tmp_path / "page.html"
    # what a user would do, at the end of the page's own script
    deeds = """<script>
      for (const key of ["all", "turn", "hold"]) document.querySelector(`[data-span=${key}]`).click();
      for (const [id, value, kind] of [["frame", 400, "input"], ["magnify", 50, "change"]]) {
        document.getElementById(id).value = value;
        document.getElementById(id).dispatchEvent(new Event(kind));
      }
      for (const kind of ["beforeprint", "afterprint"]) window.dispatchEvent(new Event(kind));
      document.querySelector("dd").textContent = "123456 N m/arcmin";
      const out = [...document.querySelectorAll("dl > div")].filter(card => card.scrollWidth > card.clientWidth);
      document.body.dataset.cards = out.map(card => card.textContent).join("; ");
      const pictures = [...document.querySelectorAll("svg[role=img]")];
      document.body.dataset.unnamed = pictures.filter(one => !one.getAttribute("aria-label")).length;
      const count = look => document.querySelectorAll(look).length;
      document.body.dataset.unread = count(".chart") - Math.min(count(".values-of"), count(".reader"));
    </script></body>"""
    path.write_text(request.getfixturevalue(which).replace("</body>", deeds), encoding="utf-8")
    options = (f"--user-data-dir={tmp_path / 'profile'}", f"--window-size={width},900", "--dump-dom")
    done = subprocess.run(
        [BROWSER, *FLAGS, *options, path.as_uri()], capture_output=True, text=True, timeout=60, check=True
    )
    assert "CONSOLE" not in done.stderr, done.stderr
    assert 'data-ready="true"' in done.stdout
    (cards,) = re.findall(r'<body data-cards="([^"]*)"', done.stdout)
    assert cards == "", "a number sticks out of its card"
    assert 'data-unnamed="0"' in done.stdout, "a picture has no text"
    assert 'data-unread="0"' in done.stdout, "the values of a chart cannot be read by keyboard or as a table"
    for figure in (*FIGURES, "spectrum"):
        name = figure if isinstance(figure, str) else figure.name
        drawn = done.stdout.split(f'id="figure-{name}"')[1].split("</figure>")[0]
        lines = re.findall(r'<path class="curve" d="(M[^"]*)"', drawn)
        panels = 1 if isinstance(figure, str) else len(figure.panels)
        assert len(lines) >= panels, name
        assert all(line.count("L") >= 20 for line in lines), name
        assert "NaN" not in drawn
    for view in done.stdout.split('class="clock"')[1:]:
        drawn = view.split("</figure>")[0]
        assert "NaN" not in drawn
        assert re.search(r"crank at +[\u2007\d.]+", drawn)
        assert len(re.findall(r'<path d="M[^"]+Z"', drawn)) > 10  # arrows
