"""Figures hold the numbers of the series, say their units, fit on their page and come out the same every time."""

import itertools
import math
import re
import subprocess
import sys
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from ideal import ideal_mechanism
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.patches import Circle, PathPatch
from matplotlib.quiver import Quiver

from cycloid_mj.analysis import analyze, series
from cycloid_mj.base.errors import CycloidError, LogError, UsageError
from cycloid_mj.base.record import Run
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.geometry import kinematics, profile
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.plots import FigureError, figures, mechanism, save
from cycloid_mj.plots.pin import pin_figure
from cycloid_mj.plots.stress import map_figure
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.sockets import socket_half_angle
from cycloid_mj.stress.field import StressMap

GEAR = CycloidGear(36, 1e-3, 40.75e-3, 2.25e-3)
DT = 1e-4
NAMES = ["transmission_error", "fig5_input", "fig6_gear_speed", "fig7_q_path", "fig8_q_speed", "fig9_pin1"]
ARCSEC = math.pi / 180 / 3600


def run_of(design: Design) -> Run:
    """Return the closed form with waves on everything that the figures show."""
    pin_1 = {
        "pin_1_x": lambda theta: 0.9e-6 * np.cos(theta),
        "pin_1_y": lambda theta: 0.7e-6 * np.sin(theta),
        "pin_1_speed": lambda theta: 2 + np.cos(theta),
    }
    return ideal_mechanism(
        design,
        crank_speed=lambda theta: 1e-3 * np.cos(3 * theta),
        crank_torque=1.2,
        gear_x=lambda theta: 1e-6 * np.cos(theta),
        gear_y=lambda theta: 1e-6 * np.sin(2 * theta),
        gear_angle=lambda theta: 20 * ARCSEC * np.sin(36 * theta),
        gear_vx=lambda theta: 1e-3 * np.sin(theta),
        gear_vy=lambda theta: 1e-3 * np.cos(theta),
        gear_speed=lambda theta: 0.002 * np.cos(36 * theta),
        output_angle=lambda theta: ARCSEC * np.sin(8 * theta) - 96 * ARCSEC,
        load_torque=36.0,
        **dict.fromkeys(("contacts", "penetration", "peak_force"), 1.0),
        **(pin_1 if design.ring.has_moving_pins else {}),
    )


@pytest.fixture(scope="module")
def design():
    return override(PRESETS["pin"], ["drive.ramp_s=0.03", "drive.hold_s=0.09"])


@pytest.fixture(scope="module")
def motion(design):
    return series(run_of(design), q=(3e-3, -20e-3))


@pytest.fixture(scope="module")
def drawn(motion):
    return figures(motion)


def curves(axes) -> list[np.ndarray]:
    """Every line of more than two points, each (n, 2)."""
    return [line.get_xydata() for line in axes.lines if len(line.get_xdata()) > 2]


def has_curve(axes, x, y) -> bool:
    wanted = np.stack([x, y], axis=1)
    return any(curve.shape == wanted.shape and np.allclose(curve, wanted, 1e-12, 1e-12) for curve in curves(axes))


@pytest.fixture(scope="module")
def turn(motion):
    """Samples of the second turn of the run, the first that lies in the hold, and their crank angles [deg]."""
    angle = np.degrees(motion.crank_angle)
    rows = (angle >= 360) & (angle <= 720)
    assert motion.hold[rows].all()
    assert not motion.hold[angle < 360].all()
    return rows, angle[rows] - 360


# --- what is drawn


def test_figures_are_named_after_the_paper(design, drawn):
    assert list(drawn) == NAMES
    without = override(design, ['ring.pins="fixed"'])
    assert list(figures(run_of(without))) == [name for name in NAMES if name != "fig9_pin1"]


def test_every_figure_names_load_and_speed(drawn):
    for name, figure in drawn.items():
        assert figure.get_suptitle() == "pin, no load, 1640 rpm", name


def test_a_run_that_ended_in_its_ramp_is_drawn(design):
    cut = run_of(design).select(slice(0, 250))
    found = figures(cut)
    assert list(found) == NAMES
    for figure in found.values():
        assert "ended in its ramp" in figure.get_suptitle()
    top = found["fig6_gear_speed"].axes[0]
    assert top.get_ylim()[0] < -1640 * math.pi / 30 / 35 * 250 / 300


def test_input(motion, drawn):
    top, bottom = drawn["fig5_input"].axes
    speed = motion.crank_speed
    assert has_curve(top, motion.time, speed.theory)
    assert has_curve(top, motion.time, speed.simulated)
    assert has_curve(bottom, motion.time, 1e3 * (speed.simulated - speed.theory))


@pytest.mark.parametrize(("name", "place"), [("fig5_input", 0), ("fig6_gear_speed", 0), ("fig9_pin1", 2)])
def test_a_speed_has_a_scale_in_degrees_next_to_it(drawn, name, place):
    axes = drawn[name].axes[place]
    drawn[name].draw_without_rendering()
    (beside,) = axes.child_axes
    assert (axes.get_ylabel()[-7:], beside.get_ylabel()) == ("[rad/s]", "[deg/s]")
    assert beside.get_ylim() == pytest.approx(np.degrees(axes.get_ylim()))


def test_gear_speed(motion, turn, drawn):
    rows, degrees = turn
    top, bottom = drawn["fig6_gear_speed"].axes
    crank, gear = motion.run["crank_speed"][rows], motion.run["gear_speed"][rows]
    assert has_curve(top, degrees, -crank / 35)
    assert has_curve(top, degrees, gear)
    assert has_curve(bottom, degrees, 1e3 * (gear + crank / 35))
    assert not has_curve(bottom, degrees, 1e3 * (gear - crank / 35))
    assert top.get_xlim() == (0, 360)


def test_path_of_q(motion, turn, drawn):
    rows, degrees = turn
    path, near, error = drawn["fig7_q_path"].axes
    theory, simulated = motion.q_position.theory[rows], motion.q_position.simulated[rows]
    assert has_curve(path, *(1e3 * theory.T))
    assert has_curve(path, *(1e3 * simulated.T))
    x, y = 1e6 * (simulated - theory).T
    distance = np.hypot(x, y)
    for values in (x, y, distance):
        assert has_curve(error, degrees, values)
    worst = np.argmax(distance)
    assert has_curve(near, *(1e6 * (theory - theory[worst]).T))
    assert has_curve(near, *(1e6 * (simulated - theory[worst]).T))
    assert near.get_xlim()[1] > distance[worst]
    assert path.get_title("left") == "Path of q = (3, \N{MINUS SIGN}20) mm"


def test_velocity_of_q(motion, turn, drawn):
    rows, degrees = turn
    top, bottom = drawn["fig8_q_speed"].axes
    theory, simulated = motion.q_velocity.theory[rows], motion.q_velocity.simulated[rows]
    size_18 = kinematics.point_speed(GEAR, motion.q, motion.crank_angle, motion.run["crank_speed"])[rows]
    assert has_curve(top, degrees, 1e3 * size_18)
    assert has_curve(bottom, degrees, 1e3 * (np.hypot(*simulated.T) - size_18))
    for i in range(2):
        assert has_curve(top, degrees, 1e3 * theory[:, i])
        assert has_curve(top, degrees, 1e3 * simulated[:, i])
        assert has_curve(bottom, degrees, 1e3 * (simulated - theory)[:, i])


def test_pin_1(motion, turn, drawn, design):
    rows, degrees = turn
    path, radial, spin = drawn["fig9_pin1"].axes
    x, y = 1e6 * motion.run["pin_1_x"][rows], 1e6 * motion.run["pin_1_y"][rows]
    limit, play = curves(path)[0], 1e6 * design.clearance.pin_socket
    half, radius = socket_half_angle(design), 1e6 * design.ring.pin_radius
    inside = np.abs(np.arctan2(limit[:, 0], limit[:, 1])) <= half + 1e-9
    assert np.hypot(*limit[inside].T) == pytest.approx(np.full(inside.sum(), play))
    edge = (radius + play) * np.array([np.sin(half), np.cos(half)])
    beyond = np.abs(limit[~inside]) * [1.0, -1.0]
    assert np.hypot(*(beyond - edge).T) == pytest.approx(np.full(len(beyond), radius))
    assert limit[:, 1].min() < min(y.min(), -2.0 * play)
    assert has_curve(path, x, y)
    assert has_curve(radial, degrees, np.hypot(x, y))
    assert has_curve(spin, degrees, motion.run["pin_1_speed"][rows])


def test_transmission_error_is_that_of_the_findings(motion, turn, drawn):
    rows, degrees = turn
    output, gear = drawn["transmission_error"].axes
    for axes, column in ((gear, "gear_angle"), (output, "output_angle")):
        assert has_curve(axes, degrees, (motion.run[column] + motion.crank_angle / 35)[rows] / ARCSEC)
    found = analyze(motion.run, q=motion.q)
    (curve,) = curves(output)
    assert np.ptp(curve[:, 1]) == pytest.approx(found.output_transmission_error.peak_to_peak_arcsec, rel=0.02)


def test_a_run_and_its_series_give_the_same_figures(motion, drawn):
    again = figures(motion.run, q=motion.q)
    for name, figure in drawn.items():
        for axes, same in zip(figure.axes, again[name].axes, strict=True):
            for curve, other in zip(curves(axes), curves(same), strict=True):
                np.testing.assert_array_equal(curve, other)


def test_a_backward_crank_is_drawn_over_its_own_turn(design):
    back = figures(run_of(override(design, ["drive.speed_rpm=-1640"])))
    top, _ = back["fig6_gear_speed"].axes
    assert top.get_xlim() == (-360, 0)


@pytest.mark.parametrize("rounding", [-1e-9, 1e-9])
def test_a_turn_that_starts_within_rounding_of_zero_is_drawn_from_zero(design, rounding):
    run = run_of(override(design, ["drive.ramp_s=0.0", "drive.speed_rpm=1666.6666666666667"]))
    columns = dict(run.columns) | {"crank_angle": run["crank_angle"] + rounding}
    drawn = figures(Run(run.time, columns, run.units, {}, run.attachments))
    assert drawn["fig6_gear_speed"].axes[0].get_xlim() == (0, 360)


# --- how it looks


def labels(axes):
    """Titles, axis labels and legend of an axes, as far as they are printed."""
    titles = [axes.title, axes._left_title, axes.get_legend()]
    names = [axes.xaxis.label, axes.yaxis.label] if axes.axison else []
    return [text for text in [*titles, *names] if text is not None and text.get_visible()]


def tick_labels(axis):
    low, high = sorted(axis.get_view_interval())
    for tick in axis.get_major_ticks():
        if low <= tick.get_loc() <= high:
            yield from (label for label in (tick.label1, tick.label2) if label.get_visible() and label.get_text())


def boxes_of(figure):
    """Return every text and legend of a figure with its box in pixels, as it will be printed."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    written = [*figure.legends]
    for axes in figure.axes:
        written += labels(axes)
        if axes.axison:
            written += [*tick_labels(axes.xaxis), *tick_labels(axes.yaxis)]
    boxes = [(item, item.get_window_extent(renderer)) for item in written]
    return [(item, box) for item, box in boxes if box.width > 1 and box.height > 1]


def crowded(figure) -> list[str]:
    """Name the texts that leave the page or cover each other."""
    boxes, page = boxes_of(figure), figure.bbox
    pairs = itertools.combinations(boxes, 2)
    found = [f"{text} leaves the page" for text, box in boxes if not _inside(box, page)]
    return found + [f"{one} covers {two}" for (one, a), (two, b) in pairs if a.overlaps(b)]


def _inside(box, page) -> bool:
    return box.x0 >= page.x0 and box.y0 >= page.y0 and box.x1 <= page.x1 + 1 and box.y1 <= page.y1 + 1


@pytest.mark.parametrize("name", NAMES)
def test_texts_stay_on_the_page_and_apart(drawn, name):
    assert crowded(drawn[name]) == []


def test_maps_of_stress_name_the_load_and_keep_their_titles_apart():
    corners = 0.05 * np.array([[-1.0, -1.0], [1.0, -1.0], [0.0, 1.0]])
    nodes = np.concatenate([corners, (corners + np.roll(corners, -1, axis=0)) / 2.0])
    stress = np.linspace(1e6, 123.4e6, 6)
    found = StressMap("gear", 2.1, nodes, np.arange(6)[np.newaxis], nodes, nodes, stress, nodes, stress > 0.0)
    figure = map_figure(dict.fromkeys(("shaft", "gear", "ring", "output"), found), "nonpin, 36.68 N m")
    assert figure.get_suptitle().startswith("nonpin, 36.68 N m")
    assert crowded(figure) == []


def test_a_long_title_is_detected(motion):
    figure = figures(motion)["fig9_pin1"]
    figure.axes[1].set_title("much too long a title for an axes of half of the page's width, as everybody will see")
    assert crowded(figure)


@pytest.mark.parametrize("name", NAMES)
def test_every_axis_states_its_unit(drawn, name):
    written = [label for axes in drawn[name].axes for label in (axes.get_xlabel(), axes.get_ylabel()) if label]
    assert len(written) >= 3
    known = {"[rad/s]", "[mrad/s]", "[mm]", "[\N{MICRO SIGN}m]", "[mm/s]", "[arcsec]", "[deg]", "[s]"}
    assert {re.search(r"\[.*\]$", label).group() for label in written} <= known
    FigureCanvasAgg(drawn[name]).draw()  # only then do ticks have their labels
    for axes in drawn[name].axes:
        assert axes.get_ylabel()
        assert list(tick_labels(axes.yaxis))
        if axes.get_subplotspec().is_last_row():
            assert axes.get_xlabel()
            assert list(tick_labels(axes.xaxis))


def test_drawing_does_not_change_matplotlib_settings(motion):
    with matplotlib.rc_context({"font.size": 20.0, "axes.grid": False}):
        before = dict(matplotlib.rcParams)
        figure = figures(motion)["fig5_input"]
        assert dict(matplotlib.rcParams) == before
        assert figure.axes[0].yaxis.label.get_fontsize() == 8.0


@pytest.mark.slow
def test_no_global_figure_state_is_touched():
    code = "import sys, cycloid_mj.plots; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


# --- files


@pytest.mark.slow
def test_files_come_out_the_same_twice(motion, tmp_path):
    formats = ("png", "svg", "pdf")
    drawn = ({"fig9_pin1": pin_figure(motion, motion.pin_1)} for _ in "ab")
    first, second = (save(figure, tmp_path / name, formats) for figure, name in zip(drawn, "ab", strict=True))
    assert [path.relative_to(tmp_path) for path in first] == [Path(f"a/fig9_pin1.{form}") for form in formats]
    for one, two in zip(first, second, strict=True):
        assert one.read_bytes() == two.read_bytes()
        assert not re.search(rb"CreationDate|<dc:date>|Matplotlib v|Software", one.read_bytes())


def test_a_png_has_200_dots_per_inch(drawn, tmp_path):
    (path,) = save({"input": drawn["fig5_input"]}, str(tmp_path / "new" / "folder"))
    head = path.read_bytes()[:24]
    assert head[:8] == b"\x89PNG\r\n\x1a\n"
    assert int.from_bytes(head[16:20], "big") == 1300  # 6.5 in


def test_a_failed_write_is_reported(drawn, tmp_path):
    some = {"input": drawn["fig5_input"]}
    with pytest.raises(UsageError, match=r"unknown figure format .bmp.: choose one of png, svg, pdf"):
        save(some, tmp_path, ("bmp",))
    (tmp_path / "file").write_text("")
    with pytest.raises(FigureError, match="cannot write figures to") as caught:
        save(some, tmp_path / "file" / "folder")
    assert isinstance(caught.value, CycloidError)
    (tmp_path / "input.png").mkdir()
    with pytest.raises(CycloidError, match=r"cannot write .*input\.png: it is not a regular file"):
        save(some, tmp_path)


# --- the mechanism


def outlines(figure) -> list[np.ndarray]:
    return [patch.get_path().vertices for patch in figure.axes[0].patches if isinstance(patch, PathPatch)]


def circles(figure, radius: float) -> np.ndarray:
    found = [p for p in figure.axes[0].patches if isinstance(p, Circle) and math.isclose(p.get_radius(), radius)]
    return np.array([circle.get_center() for circle in found])


def angle_cw(points: np.ndarray) -> np.ndarray:
    return np.degrees(np.arctan2(points[:, 0], points[:, 1])) % 360


@pytest.mark.parametrize("crank_angle", [0.0, 0.9, -2.0])
def test_the_drawn_gear_touches_the_drawn_pins(crank_angle):
    figure = mechanism(Reducer(PRESETS["pin"]), crank_angle=crank_angle)
    _, gear = outlines(figure)
    pins = circles(figure, 2.25)
    assert angle_cw(pins) == pytest.approx(np.arange(36) * 10.0, abs=1e-9)
    gaps = [np.hypot(*(gear - pin).T).min() - 2.25 for pin in pins]
    # every pin touches: the chords leave the profile by 5 um, the clearance is 1 um, the vertices are some 0.2 mm apart
    assert max(np.abs(gaps)) < 0.03


def test_a_gear_turned_the_wrong_way_would_not_touch_the_pins():
    figure = mechanism(Reducer(PRESETS["pin"]), crank_angle=0.9)
    centre, back = 1e3 * kinematics.gear_centre(GEAR, 0.9), 2 * 0.9 / 35
    turn = np.array([[math.cos(back), -math.sin(back)], [math.sin(back), math.cos(back)]])
    wrong = centre + (outlines(figure)[1] - centre) @ turn.T
    assert max(abs(np.hypot(*(wrong - pin).T).min() - 2.25) for pin in circles(figure, 2.25)) > 0.3


def test_the_drawn_output_pins_touch_their_holes():
    design = PRESETS["pin"]
    figure = mechanism(Reducer(design), crank_angle=0.9)
    pins = circles(figure, 4.0)
    centre = 1e3 * kinematics.gear_centre(GEAR, 0.9)
    turn = math.degrees(0.9 / 35)
    assert angle_cw(pins) == pytest.approx(np.arange(8) * 45.0 + turn, abs=1e-9)
    # hole - pin is the crank's c at every hole; each hole is a ring of vertices about it
    vertices = outlines(figure)[1]
    for pin in pins:
        radius = np.hypot(*(vertices - pin - centre).T)
        assert radius.min() == pytest.approx(5.001, abs=2e-3)


def test_the_internal_gear_is_drawn_as_one_piece():
    figure = mechanism(Reducer(PRESETS["nonpin"]), crank_angle=0.4)
    ring, gear = outlines(figure)
    assert len(circles(figure, 2.25)) == 0
    radius = np.hypot(*ring.T)
    assert radius.min() == pytest.approx(38.5, abs=1e-3)
    assert radius[radius < 49].max() == pytest.approx(40.5, abs=1e-3)
    assert np.hypot(*gear.T).max() < 40.5
    assert not crowded(figure)


def loaded(design: Design) -> Run:
    run = run_of(design)
    force = {"pin_4_force_x": -80.0, "pin_4_force_y": 60.0, "output_pin_3_force_x": 0.0, "output_pin_3_force_y": -400.0}
    columns = dict(run.columns) | {name: np.full(len(run), value) for name, value in force.items()}
    columns["pin_4_force_x"] = np.where(np.degrees(columns["crank_angle"]) > 1000, -80.0, 0.0)
    pin = 40.75e-3 * profile.unit(math.radians(30)) + 2.25e-3 * np.array([-0.8, 0.6])
    x, y = pin[0] - columns["gear_x"], pin[1] - columns["gear_y"]
    columns["pin_4_moment"] = x * 60.0 + y * 80.0
    hole = 26e-3 * np.sin(math.pi / 2 - columns["output_angle"])
    columns["output_pin_3_moment"] = (hole - columns["gear_x"]) * -400.0
    return Run(run.time, columns, dict.fromkeys(columns, "1"), {}, run.attachments)


def test_force_arrows_start_at_the_contacts_of_pins_and_gear(design):
    run = loaded(design)
    figure = mechanism(Reducer(design), run)
    (arrows,) = (item for item in figure.axes[0].collections if isinstance(item, Quiver))
    (pin, output), forces = arrows.get_offsets(), np.stack([arrows.U, arrows.V], axis=1)
    np.testing.assert_allclose(forces, [[-80, 60], [0, -400]])
    np.testing.assert_allclose(pin, 40.75 * profile.unit(math.radians(30)) + 2.25 * np.array([-0.8, 0.6]))
    turn = -run["output_angle"][-1]
    np.testing.assert_allclose(output, 26 * profile.unit(math.pi / 2 + turn) + [0, -4])
    longest = 400 / arrows.scale
    assert longest == pytest.approx(0.3 * 50)
    assert crowded(figure) == []


def test_a_run_is_drawn_at_the_requested_crank_angle_of_its_last_turn(design):
    run = loaded(design)
    figure = mechanism(Reducer(design), run, crank_angle=1.0)
    written, time = re.fullmatch(r"crank angle (\S+) deg, (\S+) s", figure.axes[0].get_title()).groups()
    assert abs(float(written) - math.degrees(1.0)) < 0.6  # half a sample
    sample = int(np.argmin(np.abs(run.time - float(time))))
    assert 0 <= run["crank_angle"][-1] - run["crank_angle"][sample] < 2 * math.pi
    _, gear = outlines(figure)
    _, ideal = outlines(mechanism(Reducer(design), crank_angle=float(run["crank_angle"][sample])))
    assert np.abs(gear - ideal).max() < 0.01  # the run's waves are um, not its place in the turn


def test_a_run_without_forces_is_drawn_without_arrows(design):
    figure = mechanism(Reducer(design), run_of(design))
    assert not [item for item in figure.axes[0].collections if isinstance(item, Quiver)]


def test_a_run_of_something_else_is_refused(design):
    strange = Run(np.arange(3.0), {"x": np.arange(3.0)}, {"x": "m"})
    with pytest.raises(LogError, match="no column 'crank_angle'; its columns are x"):
        mechanism(Reducer(design), strange)
    with pytest.raises(LogError, match=r"design\.toml"):
        figures(strange)
