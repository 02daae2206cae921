"""The public face: what `import cycloid_mj` offers, lazily, under names that are true."""

import inspect
import pydoc
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import cycloid_mj as cm
from cycloid_mj.base.errors import CycloidError, UsageError
from cycloid_mj.base.frame import Frame
from cycloid_mj.cli.contents import GROUPS, PYTHON, WITHOUT_PYTHON


def test_every_public_name_exists() -> None:
    assert all(getattr(cm, name) is not None for name in cm.__all__)
    assert len(set(cm.__all__)) == len(cm.__all__)
    assert dir(cm) == sorted(cm.__all__), "the public names alone"


def test_a_package_completes_to_its_public_names_only() -> None:
    for room in (cm.measure, cm.stress, cm.statics, cm.report):
        assert dir(room) == sorted(room.__all__)


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(AttributeError, match=r"no attribute 'simulat'; it has .*simulate"):
        cm.simulat  # noqa: B018


def test_the_import_alone_loads_nothing_heavy() -> None:
    heavy = "{'numpy', 'mujoco', 'pydantic', 'numba', 'matplotlib', 'scipy'}"
    code = f"import sys, cycloid_mj; assert not {heavy} & set(sys.modules), {heavy} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_no_module_hides_a_public_function_of_its_name() -> None:
    """A submodule of the same name would hide them."""
    code = "import cycloid_mj as cm, cycloid_mj.cli.app; assert all(callable(getattr(cm, n)) for n in names)"
    names = [
        "analyze",
        "build",
        "check",
        "datasheet",
        "export",
        "load",
        "new",
        "rate",
        "read_log",
        "read_loop",
        "report",
    ]
    names += ["compare", "protocol", "simulate", "statics", "stress", "tolerance", "validate"]
    subprocess.run([sys.executable, "-c", f"names = {names}; {code}"], check=True)


def test_a_design_to_findings(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('name = "mine"\n[ring]\nteeth = 12\n[gear]\neccentricity_mm = 2.0\n')
    assert cm.load(path) == cm.load(str(path))
    assert cm.load(path).lobes == 11
    fast = cm.load("nonpin", {"drive.ramp_s": 0.0, "drive.hold_s": 0.002, "load.torque_nm": 5.0, "load.rise_s": 0.001})
    run = cm.simulate(fast)
    assert cm.analyze(run, settle=0.001).power.load_torque_nm == pytest.approx(5.0, rel=0.01)


def test_the_python_page_begins_with_lines_that_work(capsys, monkeypatch: pytest.MonkeyPatch) -> None:
    docs = Path(__file__).parents[1] / "docs" / "reference.py"
    code = re.search(r"^PYTHON = .*?```python\n(.*?)```", docs.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)[1]
    names: dict[str, object] = {}
    exec(compile(code, "reference", "exec"), names)
    sheet, play, findings, force = capsys.readouterr().out.splitlines()
    assert re.fullmatch(r"<Sheet: pin, 36.68 N m, 1640 rpm, .*; backlash \S+ arcmin, .*>", sheet)
    assert re.fullmatch(r"<Findings: pin, 36 N m, 1640 rpm; efficiency 8\d.\d\d %, .*>", findings)
    assert re.fullmatch(r"backlash \S+ arcmin", play)
    assert 500.0 < float(re.fullmatch(r"largest contact force (\S+) N", force)[1]) < 3000.0
    assert names["page"].startswith("<!doctype html>")
    rows = dict(zip(*names["results"].frame.columns.values(), strict=True))
    assert rows["power.load_torque_nm"] == pytest.approx(36.0)


def test_a_design_is_accepted_by_its_name_too() -> None:
    by_name, by_design = cm.statics("printed", load_nm=2.0), cm.statics(cm.load("printed"), 2.0)
    assert by_name == by_design
    assert by_name.condition.startswith("2 N m")
    printed = cm.load("printed")
    assert cm.check("printed") == cm.check(printed)
    assert cm.rate("printed").as_json() == cm.rate(printed).as_json()


def taking_a_design() -> dict[str, Callable[..., Any]]:
    """Every public function that begins with a design."""
    rooms = {"": cm, "measure.": cm.measure}
    public = {f"{room}{name}": getattr(of, name) for room, of in rooms.items() for name in of.__all__}
    functions = {name: getattr(value, "main", value) for name, value in public.items()}
    functions = {name: value for name, value in functions.items() if inspect.isfunction(value)}
    return {name: value for name, value in functions.items() if "design" in inspect.signature(value).parameters}


@pytest.mark.parametrize("name", taking_a_design())
def test_every_function_of_a_design_accepts_its_name(name: str) -> None:
    function = taking_a_design()[name]
    others = {
        key: None
        for key, parameter in inspect.signature(function).parameters.items()
        if key != "design" and parameter.default is parameter.empty
    }
    with pytest.raises(UsageError, match="nosuch"):
        function(design="nosuch", **others)


@pytest.mark.slow
def test_drives_of_a_requirement_and_the_data_sheet_of_one() -> None:
    answer = cm.new(15, 100.0, 1.0, process="printed", life_h=100.0)
    assert str(answer).startswith("<Answer: 15:1, 100 mm, 1 N m; ")
    assert len(answer.frame["title"]) == len(answer.drives)
    sheet = cm.datasheet("printed")
    assert f"rated torque {sheet.value('rated_torque'):.4g} N m" in str(sheet)


TABLE = Frame({"name": np.array(["<b>", "c"], dtype=object), "value": np.array([1.5, np.nan])})


def test_a_table_shows_in_a_line_and_as_html_with_its_text_escaped() -> None:
    assert repr(TABLE) == "<Frame: 2 rows of name, value>"
    page = TABLE._repr_html_()
    assert "<td>&lt;b&gt;</td><td>1.5</td>" in page
    assert "<td>c</td><td></td>" in page
    long = Frame({"value": np.arange(100.0)})
    assert "<p>40 rows more</p>" in long._repr_html_()


@pytest.mark.parametrize("package", ["pandas", "polars"])
def test_a_data_frame_is_of_the_installed_package(package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cycloid_mj.base.notebook_display.find_spec", lambda name: name == package or None)
    monkeypatch.setitem(sys.modules, package, SimpleNamespace(DataFrame=lambda columns: (package, columns)))
    made, columns = TABLE.to_frame()
    assert made == package
    assert columns["name"] == ["<b>", "c"]


def test_without_either_a_data_frame_states_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cycloid_mj.base.notebook_display.find_spec", lambda name: None)
    with pytest.raises(CycloidError, match="pip install pandas"):
        TABLE.to_frame()


def test_no_example_imports_from_deeper_than_the_package() -> None:
    examples = sorted((Path(__file__).parents[1] / "examples").glob("plot_*.py"))
    deeper = [path.name for path in examples if re.search(r"(from|import) cycloid_mj\.", path.read_text("utf-8"))]
    assert examples
    assert deeper == []


def test_a_result_is_drawn_by_one_call() -> None:
    pytest.importorskip("matplotlib")
    still = cm.load("pin", {"drive.ramp_s": 0.0, "drive.hold_s": 0.002, "load.torque_nm": 5.0, "load.rise_s": 0.001})
    sheet, rating = cm.statics("pin", 5.0), cm.rate(still)
    for result in (sheet, rating):
        (axes,) = result.plot().axes
        assert axes.patches, f"a bar for each value of {result}"
    assert repr(rating).startswith("<Rating: pin; ")
    assert list(rating.frame.columns["key"]) == list(rating.items)
    with pytest.raises(UsageError, match="Sheet has no figure 'nosuch': choose one of closed_form"):
        sheet.plot("nosuch")
    with pytest.raises(UsageError, match="Frame has no figure"):
        TABLE.plot()


def test_a_run_and_a_measurement_have_a_figure_and_a_short_repr() -> None:
    still = cm.load("pin", {"drive.ramp_s": 0.0, "drive.hold_s": 0.002, "load.torque_nm": 5.0, "load.rise_s": 0.001})
    run = cm.simulate(still)
    assert run.plot("fig6_gear_speed").axes
    assert list(run.frame.columns)[:1] == ["time"]
    assert run.frame.rows == len(run)
    page = cm.report({"run <1>": run})
    assert page.startswith("<!doctype html>")
    assert len(repr(page)) < 80
    assert page._repr_html_().count("<") == 2
    model = repr(cm.build(still))
    assert model.startswith("<ReducerModel: 113 freedoms, 81 mating pairs")
    assert len(model) < 100
    (axes,) = cm.analyze(run, settle=0.001).plot().axes
    assert axes.get_xlabel() == "loss by kind of contact [W]"
    backlash = cm.measure.Measurement(
        "backlash",
        still,
        {"backlash": cm.Quantity("backlash", "backlash", 1.25, "arcmin")},
        (cm.Curve("play", "model", np.arange(3.0), np.arange(3.0), "crank angle [deg]", "turn [arcmin]"),),
        condition="5 N m",
    )
    assert repr(backlash) == "<Measurement: backlash of pin, 5 N m; backlash 1.25 arcmin>"
    assert backlash.frame.columns["value"].tolist() == [1.25]
    assert backlash.plot().axes[0].get_title("left") == "play"


def test_a_measured_loop_has_a_figure_and_a_short_repr() -> None:
    loop = cm.read_loop(str(Path(__file__).parent / "data" / "bench" / "play_loop.csv"))
    assert repr(loop).startswith(f"<MeasuredLoop: {loop.name}, {len(loop.torque)} points, ")
    assert loop.plot().axes[0].get_ylabel() == "deflection [deg]"
    assert loop.frame.rows == len(loop.torque)
    assert loop._repr_html_().count("<tr>") <= 61


def test_a_design_and_its_checks_have_a_repr_a_frame_and_a_figure() -> None:
    design = cm.load("pin", {"clearance.cam_um": 98.0})
    checks = cm.check(design)
    warned = [check.name for check in checks if not check.passed]
    assert {"life", "strength", "momentary_torque"} <= set(warned), "those of `design check`"
    assert repr(checks) == f"<Checks: {len(checks)} checks: 0 failed, {len(warned)} warnings ({', '.join(warned)})>"
    assert dict(zip(*(checks.frame.columns[key] for key in ("name", "passed")), strict=True))["play"] is np.False_
    yields = next(one for one in checks if one.name == "tooth_yield")
    assert checks.margins["tooth_yield"] == pytest.approx(yields.bound / yields.value)
    assert checks.plot().axes[0].patches
    rows = dict(zip(*(design.frame.columns[key] for key in ("key", "value")), strict=True))
    assert float(rows["clearance.cam_um"]) == pytest.approx(98.0)
    assert rows["ring.teeth"] == "36"
    assert design.plot().axes


def test_files_of_parts_have_a_repr_a_frame_and_a_figure_of_clearances() -> None:
    files = cm.export(cm.load("pin"), "stl")
    assert repr(files).startswith("<Export: ")
    assert files.frame.columns["bytes"].tolist() == [len(content) for content in files.files.values()]
    assert files.plot().axes[0].patches


def test_a_prediction_and_a_spectrum_have_a_repr_and_a_figure() -> None:
    loop = cm.read_loop(Path(__file__).parent / "data" / "bench" / "play_loop.csv")
    found = cm.predict_loops(cm.Reducer(cm.load("pin")), [loop])
    assert (
        repr(found)
        == f"<Prediction: rms difference relative to the height of the loop: {loop.name} {found.shares[0]:.2%}>"
    )
    assert found.frame.columns["modelled"][0] == pytest.approx(found.modelled.in_units()["play_deg"].value)
    assert len(found.plot().axes[0].lines) == 2
    angle = np.linspace(0.0, 8.0 * np.pi, 4000)
    orders = cm.tapered_orders(angle, 2.0 * np.cos(3.0 * angle))
    assert repr(orders).endswith(" at 3>")
    assert orders.frame.rows == len(orders.order)
    assert orders.plot().axes[0].get_ylabel() == "amplitude [unit of the signal]"


def public_functions() -> dict[str, Callable[..., Any]]:
    """Every public function of the package and of its rooms."""
    rooms = {"": cm, "measure.": cm.measure, "stress.": cm.stress, "statics.": cm.statics, "report.": cm.report}
    public = {f"{room}{name}": getattr(of, name) for room, of in rooms.items() for name in of.__all__}
    functions = {name: getattr(value, "main", value) for name, value in public.items()}
    return {name: value for name, value in functions.items() if inspect.isfunction(value)}


@pytest.mark.parametrize("name", public_functions())
def test_every_public_function_describes_its_parameters(name: str) -> None:
    function = public_functions()[name]
    _, _, described = inspect.getdoc(function).partition("Parameters\n----------\n")
    described = described.partition("\n\n")[0]
    given = {one for line in described.splitlines() if line[:1].strip() for one in re.findall(r"\w+", line)}
    assert set(inspect.signature(function).parameters) <= given


def command_functions() -> dict[str, Callable[..., Any]]:
    """Every public function that does what a command does."""
    return {name: function for names in PYTHON.values() for name in names if (function := public_functions().get(name))}


def test_every_command_has_a_function() -> None:
    commands = {name for group in GROUPS.values() for name in group}
    assert commands == set(PYTHON) | WITHOUT_PYTHON
    assert {name for names in PYTHON.values() for name in names} <= set(cm.__all__)


@pytest.mark.parametrize("name", command_functions())
def test_the_function_of_a_command_describes_its_result(name: str) -> None:
    function = command_functions()[name]
    if inspect.signature(function).return_annotation not in (None, "None"):
        assert "\nReturns\n-------\n" in (inspect.getdoc(function) or "")


def test_help_of_a_package_that_is_called_is_that_of_its_function() -> None:
    text = pydoc.render_doc(cm.statics, renderer=pydoc.plaintext)
    head = text.split("PACKAGE CONTENTS")[0]
    assert "cycloid_mj.statics - Compute the data-sheet quantities of a reducer by statics" in head
    assert "Call: cm.statics(design, load_nm=None)" in head
    for heading in ("Parameters", "Returns", "Raises"):
        assert f"{heading}\n    -" in head


def test_a_comparison_of_a_single_design_names_the_remedy() -> None:
    with pytest.raises(UsageError, match="add another design"):
        cm.compare("pin")


@pytest.mark.slow
def test_designs_are_compared_and_drawn() -> None:
    comparison = cm.compare("pin", "printed", load_nm=5.0, quick=True)
    assert repr(comparison) == "<Comparison: pin / printed; no load, 5 N m; by the planar solver>"
    rows = comparison.frame.columns
    assert set(rows["design"]) == {"pin", "printed"}
    efficiency = rows["mean"][(rows["quantity"] == "efficiency") & (rows["load_nm"] == 5.0)]
    assert ((efficiency > 50.0) & (efficiency < 100.0)).all()
    assert comparison.plot("compare_tooth_force").axes


def test_the_protocol_of_a_design_has_a_figure_and_a_short_repr() -> None:
    protocol = cm.protocol("pin", 20.0, angles=1)
    assert re.match(r"<Protocol: pin, rated torque 20 N m; lost motion [01]\.\d+ arcmin, ", repr(protocol))
    assert protocol.frame.rows > 5
    assert protocol.plot().axes


def test_a_validation_step_has_rows_and_no_failure() -> None:
    validation = cm.validate(("friction",))
    assert repr(validation).startswith(f"<Validation: {validation.frame.rows} pass, 0 fail")
    assert not validation.failed


def test_a_callable_package_shows_its_parameters() -> None:
    assert list(inspect.signature(cm.statics).parameters) == ["design", "load_nm"]
    assert list(inspect.signature(cm.report).parameters) == ["runs", "q", "settle"]


def test_a_curve_and_a_table_have_a_short_repr_and_a_frame() -> None:
    curve = cm.Curve("play", "model", np.arange(300.0), np.arange(300.0), "crank angle [deg]", "turn [arcmin]")
    assert repr(curve) == "<Curve: play: model, 300 points; crank angle [deg], turn [arcmin]>"
    assert curve.frame["turn [arcmin]"][-1] == 299.0
    (axes,) = curve.plot().axes
    assert (axes.get_title("left"), axes.get_ylabel()) == ("play", "turn [arcmin]")
    table = cm.Table("orders", ("order", "cause", "arcsec"), ((1.0, "<weight>", 0.5), (36.0, "mesh", 2.0)))
    assert repr(table) == "<Table: orders; 2 rows of order, cause, arcsec>"
    assert table.frame["arcsec"].tolist() == [0.5, 2.0]
    assert "&lt;weight&gt;" in table._repr_html_()


def test_studies_state_their_result_in_a_line() -> None:
    made = cm.tolerance(cm.load("pin", {"tolerance.cam": "uniform 0.1"}), samples=20)
    assert re.fullmatch(
        r"<Tolerances: pin, 20 samples; yield 100.00%, backlash_arcmin 0.9\d+ \+- 0.0\d+ arcmin>", repr(made)
    )
    swept = cm.sweep("pin", {"gear.face_width_mm": "8:12:2"}, "mass_kg")
    assert repr(swept) == "<Sweep: pin, 2 points of gear.face_width_mm; mass_kg>"
    best = cm.optimize("pin", {"ring.pin_radius_mm": "2:2.4"}, minimize="mass_kg", evaluations=4, starts=1)
    assert re.match(
        r"<Optimum: pin, \d+ points, \d+ feasible; best: mass_kg 0.8\d+, ring.pin_radius_mm 2.\d+>", repr(best)
    )
