"""Drawings show each gap to scale, films have the frames that were asked for, and MuJoCo's picture shows the poses."""

import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import mujoco
import numpy as np
import pytest
from made_run import made_run
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from cycloid_mj.base.animation import ANIMATION
from cycloid_mj.base.atomic_write import atomic_file
from cycloid_mj.base.errors import CycloidError, LogError, UsageError
from cycloid_mj.base.names import all_numbered
from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.contact.gap import Trochoid, trochoid_distance
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.mjcf.model import xml
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.envelope import sample_ring_by_sagitta
from cycloid_mj.parts import output_centres
from cycloid_mj.parts.gear import tooth_profile
from cycloid_mj.plots import movie, stage
from cycloid_mj.plots.animation import draw_frames, select_samples
from cycloid_mj.plots.movie import write_movie
from cycloid_mj.reducer import Reducer
from cycloid_mj.scene import (
    contact_forces,
    drawn_radii,
    ideal_forces,
    largest_magnification,
    magnify_gaps,
    measure_gaps,
    poses,
    ring_outline,
)
from cycloid_mj.scene.force import FORCE_COLOURS
from cycloid_mj.scene.replay import replay_model, set_sample

PIN = override(PRESETS["pin"], ["drive.ramp_s=0", "drive.hold_s=0.08", "load.torque_nm=36"])
NONPIN = override(PRESETS["nonpin"], ["drive.ramp_s=0", "drive.hold_s=0.08", "load.torque_nm=36"])
CLEARANCE = 1e-6
MAGNIFICATIONS = (1.0, 40.0, 500.0)


def rotate(points, angle):
    cos, sin = np.cos(angle), np.sin(angle)
    return points @ np.array([[cos, sin], [-sin, cos]])


def tooth_gap(gear_pose, centre, radius) -> float:
    """Gap of a circle to the flank of a gear in a pose; the flank is rho + clearance inside the path of the pins."""
    x, y = rotate(np.asarray(centre) - gear_pose[:2], -gear_pose[2])
    _, distance, _, _ = trochoid_distance(x, y, Trochoid(40.75e-3, 1e-3, 36.0))
    return distance + 2.25e-3 + CLEARANCE - radius


@pytest.fixture(scope="module")
def pin_run():
    return made_run(PIN)


@pytest.fixture(scope="module")
def nonpin_run():
    return made_run(NONPIN)


@pytest.fixture(scope="module", params=[PIN, NONPIN], ids=["pin", "nonpin"])
def made(request):
    design = request.param
    run = made_run(design, 400).select(slice(0, 400, 13))
    return design, run, poses(Reducer(design), run.columns), measure_gaps(Reducer(design), run.columns)


def nominal(i):
    return 40.75e-3 * np.array([np.sin(np.pi * i / 18), np.cos(np.pi * i / 18)])


@pytest.mark.parametrize("scale", [1.0, 8.0])
@pytest.mark.parametrize("design", [PIN, NONPIN], ids=["pin", "nonpin"])
def test_openings_are_the_exact_gaps(design, scale):
    """Against the collider's own distance to the trochoid, also where gear and pin are nearly conformal."""
    run = made_run(design, 400, scale).select(slice(0, 400, 23))
    place, measured = poses(Reducer(design), run.columns), measure_gaps(Reducer(design), run.columns)
    for row in range(len(run)):
        for i in range(36):
            pin = place[f"pin_{i + 1}"][row, :2] if "pin_1" in place else nominal(i)
            true = tooth_gap(place["gear"][row], pin, 2.25e-3)
            assert measured.opening[row, i] + CLEARANCE == pytest.approx(true, abs=1e-15)
    shifted = dict(run.columns) | {"gear_x": run["gear_x"] + 1e-6}
    assert np.abs(measure_gaps(Reducer(design), shifted).opening - measured.opening).max() > 0.9e-6


def test_a_pin_far_from_its_socket_is_measured_to_its_own_lobe():
    run = made_run(PIN, 400, 1.0).select(slice(0, 400, 23))
    away = {f"pin_{number}_x": run[f"pin_{number}_x"] + 4e-4 for number in range(1, 37)}
    assert np.abs(measure_gaps(Reducer(PIN), dict(run.columns) | away).opening).max() < 4.1e-4


@pytest.mark.parametrize("times", MAGNIFICATIONS)
def test_every_gap_is_drawn_to_one_scale(made, times):
    design, run, place, measured = made
    drawn = magnify_gaps(Reducer(design), measured, times)
    gear, centres = tooth_profile(design), output_centres(Reducer(design))
    zeta = profile.pin_angles(gear)
    normals = profile.unit(zeta - profile.conjugate_alpha(gear, zeta + run["crank_angle"][:, np.newaxis]))
    for row in range(len(run)):
        for i in range(36):
            # the flank where the ideal mesh touches it (Eq. 2): rho and the clearance inside the pin's nominal centre
            flank = nominal(i) - (2.25e-3 + CLEARANCE) * normals[row, i]
            shown = (drawn.ring[row, i] - flank) @ normals[row, i] - drawn.radii.pin
            assert shown == pytest.approx(times * (measured.opening[row, i] + CLEARANCE), abs=1e-14)
            sideways = (drawn.ring[row, i] - flank) @ (normals[row, i, ::-1] * [-1, 1])
            assert sideways == pytest.approx(0.0, abs=1e-14)
        holes = drawn.gear[row, :2] + rotate(centres, drawn.gear[row, 2])
        true_holes = place["gear"][row, :2] + rotate(centres, place["gear"][row, 2])
        true_pins = rotate(centres, place["output"][row, 2])
        true = 5e-3 + CLEARANCE - 4e-3 - np.linalg.norm(true_pins - true_holes, axis=1)
        apart = np.linalg.norm(drawn.output_pins[row] - holes, axis=1)
        np.testing.assert_allclose(5e-3 + CLEARANCE - drawn.radii.output_pin - apart, times * true, atol=1e-12)
        cam = drawn.shaft[row, :2] + rotate(np.array([0.0, 1e-3]), drawn.shaft[row, 2])
        true_cam = rotate(np.array([0.0, 1e-3]), run["crank_angle"][row])
        true = CLEARANCE - np.linalg.norm(true_cam - place["gear"][row, :2])
        shown = 15e-3 + CLEARANCE - drawn.radii.cam - np.linalg.norm(cam - drawn.gear[row, :2])
        assert shown == pytest.approx(times * true, abs=1e-12)
    away = np.linalg.norm(drawn.ring - drawn.sockets, axis=2)
    np.testing.assert_allclose(away, times * np.linalg.norm(measured.away, axis=2), atol=1e-15)
    play = CLEARANCE if design.ring.has_sockets else 0.0
    assert drawn.radii.socket - drawn.radii.pin == pytest.approx(times * play)


@pytest.mark.parametrize("times", MAGNIFICATIONS)
def test_internal_gear_is_drawn_by_its_gaps(times):
    """Where the ideal mesh touches, each point is as far from its flank as the true gap, magnified, to first order."""
    run = made_run(NONPIN, 200).select(slice(0, 200, 40))
    place, measured = poses(Reducer(NONPIN), run.columns), measure_gaps(Reducer(NONPIN), run.columns)
    drawn = magnify_gaps(Reducer(NONPIN), measured, times)
    ring = sample_ring_by_sagitta(tooth_profile(NONPIN), 3e-7)
    touching = 0
    for row in range(len(run)):
        outline = ring_outline(Reducer(NONPIN), ring.points, ring.normals, drawn, row)
        for point, normal, shown in zip(ring.points, ring.normals, outline, strict=True):
            if tooth_gap(drawn.gear[row], point, 0.0) < CLEARANCE + 1e-8:
                touching += 1
                room = (point - shown) @ normal + CLEARANCE
                # in the valleys the flank turns within 18 um
                true = tooth_gap(place["gear"][row], point, 0.0)
                assert room == pytest.approx(times * true, abs=times * 1.5e-7)
    assert touching > 40


def test_arrows_of_a_magnified_drawing_end_on_its_parts(pin_run):
    run = pin_run.select(slice(0, 300, 25))
    drawn = magnify_gaps(Reducer(PIN), measure_gaps(Reducer(PIN), run.columns), 300.0)
    acting = contact_forces(Reducer(PIN), run.columns, drawn)
    ring = acting.of("pin_gear")
    apart = np.linalg.norm(ring.point - drawn.ring, axis=2)
    assert np.abs(apart - drawn.radii.pin)[ring.size > 0].max() < 2e-7
    cam = acting.of("cam").point[:, 0] - drawn.shaft[:, :2]
    assert np.abs(np.linalg.norm(cam, axis=1) - drawn.radii.cam).max() < 1.1e-3  # about the shaft, c away from the cam


def test_magnifications_that_are_refused():
    largest = largest_magnification(Reducer(PIN))
    assert largest == pytest.approx(1 + 0.6 * 2250)
    assert drawn_radii(Reducer(PIN), largest).pin == pytest.approx(0.4 * 2.25e-3)
    assert drawn_radii(Reducer(PIN)).pin == 2.25e-3
    for times in (0.99, largest + 1, np.nan, np.inf):
        with pytest.raises(UsageError, match="out of range for pin: choose a value from 1 to 1351"):
            drawn_radii(Reducer(PIN), times)


def test_take_is_even_over_the_settled_turns(pin_run):
    angle = pin_run["crank_angle"]
    one = select_samples(pin_run, frames=60)
    steps = np.diff(angle[one.rows])
    assert one.rows.size == 60
    assert angle[one.rows[0]] % (2 * np.pi) < angle[1]
    np.testing.assert_allclose(steps, 2 * np.pi / 60, atol=angle[1])
    assert select_samples(pin_run, frames=10_000).rows.size == pytest.approx(366, abs=1)
    half = select_samples(pin_run, frames=30, turns=0.5)
    assert np.ptp(angle[half.rows]) == pytest.approx(np.pi * 29 / 30, abs=angle[1])
    for frames, turns in ((0, 1.0), (5, 0.0), (5, np.nan)):
        with pytest.raises(UsageError, match=r"choose 1 or more|greater than 0"):
            select_samples(pin_run, frames=frames, turns=turns)


def test_a_pair_without_its_whole_wrench_has_no_arrow():
    run = made_run(PIN, 3)
    columns = {name: values for name, values in run.columns.items() if name not in ("cam_moment", "pin_3_force_y")}
    assert set(contact_forces(Reducer(PIN), run.columns).names) - set(contact_forces(Reducer(PIN), columns).names) == {
        "cam",
        "pin_3",
    }


def test_frames_show_parts_and_forces_at_their_positions(pin_run):
    scene = select_samples(pin_run, 200.0, frames=4)
    frames = list(draw_frames(scene, 401))
    assert [frame.shape for frame in frames] == [(500, 400, 3)] * 4  # even, for MP4
    assert all((a != b).mean() > 0.01 for a, b in pairwise(frames))
    colours = {tuple(colour) for colour in frames[0].reshape(-1, 3)}
    for look in ("ring", "pins", "gear", "output", "cam", "shaft"):
        colour = stage.PART_STYLES[look]["facecolor"]
        assert tuple(int(colour[i : i + 2], 16) for i in (1, 3, 5)) in colours, look


def test_the_stage_moves_the_requested_parts(pin_run, monkeypatch):
    """The artists' own data: arrow tips, forces, bars and closed form are those of the row."""
    columns = {name: values[100:103] for name, values in pin_run.columns.items()}
    drawn = magnify_gaps(Reducer(PIN), measure_gaps(Reducer(PIN), columns), 100.0)
    acting = contact_forces(Reducer(PIN), columns, drawn)
    ideal = ideal_forces(Reducer(PIN), columns)
    script = stage.Script(Reducer(PIN), drawn, acting, ideal)
    set_up = stage.create_stage(script, 400)
    assert "36 N m, 1640 rpm" in [text.get_text() for text in set_up.figure.texts]
    for row in (2, 0):
        stage.update_stage(set_up, script, row)
        ring = acting.of("pin_gear")
        arrows = set_up.arrows["pin_gear"]
        np.testing.assert_allclose(arrows.get_offsets(), 1e3 * ring.point[row])
        np.testing.assert_allclose(np.ma.filled(np.ma.masked_array(arrows.U, arrows.Umask), 0.0), ring.force[row, :, 0])
        assert [bar.get_height() for bar in set_up.bars] == ring.size[row].tolist()
        np.testing.assert_allclose(set_up.ideal_steps.get_data().values, ideal[row])
        to_mm = set_up.parts[stage.PIN][9][0].get_transform() - set_up.axes.transData
        np.testing.assert_allclose(to_mm.transform((0.0, 0.0)), 1e3 * drawn.ring[row, 9], atol=1e-9)
    FigureCanvasAgg(set_up.figure).draw()
    np.testing.assert_allclose(ring.size[row], ideal[row], rtol=1e-9, atol=1e-9)  # the made run has that load


def test_nonpin_film_has_no_pins(nonpin_run):
    frames = list(draw_frames(select_samples(nonpin_run, 100.0, frames=2), 300))
    colours = {tuple(colour) for colour in frames[0].reshape(-1, 3)}
    colour = stage.PART_STYLES["pins"]["facecolor"]
    assert tuple(int(colour[i : i + 2], 16) for i in (1, 3, 5)) not in colours
    assert (frames[0] != frames[1]).any()


def test_width_of_a_film(pin_run):
    for width in (10, 10_000):
        with pytest.raises(UsageError, match="200 to 4000 pixels"):
            draw_frames(select_samples(pin_run, frames=1), width)


def clip(count: int = 5) -> list[np.ndarray]:
    """A bar that moves over a grey ground."""
    frames = np.full((count, 48, 64, 3), 90, dtype=np.uint8)
    for number, frame in enumerate(frames):
        frame[:, 4 * number : 4 * number + 8] = (210, 90, 30)
    return list(frames)


def test_gif_has_every_frame_and_repeats(tmp_path):
    path = tmp_path / "a.GIF"
    write_movie(clip(), path, 20)
    with Image.open(path) as picture:
        assert (picture.n_frames, picture.size, picture.info["loop"], picture.info["duration"]) == (5, (64, 48), 0, 50)
        for frame, made in enumerate(clip()):
            picture.seek(frame)
            assert np.abs(np.asarray(picture.convert("RGB"), dtype=int) - made).max() < 3


def test_mp4_has_every_frame(tmp_path):
    av = pytest.importorskip("av")
    path = tmp_path / "a.mp4"
    write_movie(clip(12), path, 25)
    with av.open(str(path)) as file:
        frames = [frame.to_ndarray(format="rgb24") for frame in file.decode(video=0)]
        assert (len(frames), file.duration) == (12, pytest.approx(1e6 * 12 / 25, abs=2e4))
        assert (file.streams.video[0].codec.name, file.streams.video[0].average_rate) == ("h264", 25)
    assert frames[0].shape == (48, 64, 3)
    assert np.abs(frames[0][:, 20:].astype(int) - 90).max() < 12


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_is_an_error_of_an_mp4() -> None:
    pytest.importorskip("av")
    with pytest.raises(OSError, match="No space left on device"):
        movie._write_mp4(clip(), Path("/dev/full"), 25)


def test_unsuitable_movie_settings_are_refused(tmp_path, monkeypatch):
    with pytest.raises(UsageError, match=r"cannot write a\.avi: unknown animation format.* \.gif or \.mp4"):
        write_movie(clip(), "a.avi")
    with pytest.raises(UsageError, match="choose a rate from 1 to 50"):
        write_movie(clip(), tmp_path / "a.gif", 100)
    with pytest.raises(CycloidError, match=r"cannot write .*no/a\.gif: No such file"):
        write_movie(clip(), tmp_path / "no" / "a.gif")
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(CycloidError, match=r"MP4 needs av .*pip install 'cycloid-mj\[video\]', or write a"):
        write_movie(clip(), tmp_path / "a.mp4")

    def broken():
        yield clip()[0]
        raise LogError("gone")

    (tmp_path / "b.gif").write_bytes(b"old")
    with pytest.raises(LogError, match="gone"):
        write_movie(broken(), tmp_path / "b.gif")
    assert (tmp_path / "b.gif").read_bytes() == b"old"
    assert [path.name for path in tmp_path.iterdir()] == ["b.gif"]
    assert ANIMATION.rate == 25


def test_files_are_written_completely_or_not_at_all(tmp_path):
    with atomic_file(tmp_path / "a.html") as beside:
        beside.write_text("new")
        assert not (tmp_path / "a.html").exists()
        assert beside.suffix == ".html"
    assert (tmp_path / "a.html").read_text() == "new"
    with pytest.raises(CycloidError, match="it is not a regular file"), atomic_file(tmp_path):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["a.html"]


@pytest.fixture(scope="module")
def compiled():
    return build(PIN)


@pytest.fixture(scope="module")
def modelled(compiled):
    return made_run(PIN, 300, attachments={"model.xml": xml(compiled.spec).encode()})


def test_replay_puts_every_body_where_the_poses_have_it(modelled):
    model = replay_model(modelled)
    data = mujoco.MjData(model)
    place = poses(Reducer(PIN), modelled.columns)
    for row in (0, 123, 299):
        set_sample(model, data, modelled, row)
        assert data.time == modelled.time[row]
        for part, pose in place.items():
            body = data.body(part)
            np.testing.assert_allclose(body.xpos[:2], pose[row, :2], atol=1e-15, err_msg=part)
            angle = np.arctan2(body.xmat[3], body.xmat[0])
            assert np.angle(np.exp(1j * (angle - pose[row, 2]))) == pytest.approx(0.0, abs=1e-12)


def test_runs_that_cannot_be_replayed(pin_run, modelled):
    with pytest.raises(LogError, match=r"lacks the attached file model\.xml"):
        replay_model(pin_run)
    for content in (b"<mujoco><nonsense/></mujoco>", b"\xff\xfe"):
        with pytest.raises(LogError, match=r"cannot load the model\.xml attached to .*\): simulate the design again"):
            replay_model(made_run(PIN, 2, attachments={"model.xml": content}))
    old = replace(made_run(PIN, 2, attachments={"model.xml": b"\xff\xfe"}), provenance={"mujoco": "2.3.0"})
    with pytest.raises(
        LogError, match=r"install MuJoCo 2\.3\.0, which simulated the run, or simulate the design again"
    ):
        replay_model(old)
    other = made_run(PIN, 2, attachments={"model.xml": b"<mujoco><worldbody/></mujoco>"})
    model = replay_model(other)
    with pytest.raises(LogError, match="joint positions of its model"):
        set_sample(model, mujoco.MjData(model), other, 0)


@pytest.mark.slow
def test_picture_has_the_parts_and_arrows_that_reach_the_contacts(modelled, monkeypatch):
    from cycloid_mj.scene import render

    straight_down = (90.0, -90.0)
    try:
        picture = render.render(modelled, Reducer(PIN), 200, (400, 400), straight_down)
    except CycloidError as missing:
        pytest.skip(f"no OpenGL here: {missing}")
    assert picture.shape == (400, 400, 3)
    blue = (picture[..., 2] > 130) & (picture[..., 2] > picture[..., 0].astype(int) + 60)
    assert 0.03 < blue.mean() < 0.4
    # a red arrow from the axis to the right, seen from straight above: its tip is where its end is
    end = np.array([0.02, 0.0, 0.02])
    arrow = {"tail": np.array([0.0, 0.0, 0.02]), "tip": end, "width": 8e-4, "colour": (1.0, 0.0, 0.0, 1.0)}
    monkeypatch.setattr(render, "_force_arrows", lambda *_: [arrow])
    red = render.render(modelled, Reducer(PIN), 200, (400, 400), straight_down).astype(int)
    columns = np.flatnonzero((red[..., 0] > red[..., 1:].max(axis=2) + 20).any(axis=0))
    model = replay_model(modelled)
    height = 1.35 * model.stat.extent - end[2]
    scale = 200 / (height * np.tan(np.radians(0.5 * model.vis.global_.fovy)))
    assert columns.min() == pytest.approx(200, abs=3)
    assert columns.max() == pytest.approx(200 + scale * end[0], abs=4)


@pytest.mark.slow
def test_a_part_is_shown_alone_and_completely(modelled):
    from cycloid_mj.scene import render

    size = (200, 200)
    try:
        gear, pins = (render.render_part(modelled, names, size) for names in (["gear"], all_numbered("pin", 36)))
    except CycloidError as missing:
        pytest.skip(f"no OpenGL here: {missing}")
    blue = gear[..., 2] > gear[..., 0].astype(int) + 60
    assert 0.1 < blue.mean() < 0.6
    # nothing of it touches the frame, and no pin is blue
    assert not np.concatenate([blue[0], blue[-1], blue[:, 0], blue[:, -1]]).any()
    assert not (pins[..., 2] > pins[..., 0].astype(int) + 60).any()
    with pytest.raises(UsageError, match="no body named wheel"):
        render.render_part(modelled, ["wheel"], size)


def test_pictures_that_are_refused(modelled, monkeypatch):
    from cycloid_mj.scene import render

    with pytest.raises(UsageError, match="choose 64 to 8192 pixels"):
        render.render(modelled, Reducer(PIN), 0, (10, 400))
    monkeypatch.setenv("MUJOCO_GL", "nothing")
    with pytest.raises(CycloidError, match=r"OpenGL \(nothing\) cannot render images: .*cycloid-mj animate"):
        render.render(modelled, Reducer(PIN), 0, (100, 100))
    assert FORCE_COLOURS.keys() == {"pin_gear", "tooth", "cam", "output", "crank_bearing"}
