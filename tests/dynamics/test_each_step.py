"""Between samples the largest normal force of each pair is noted, and every step has its own command."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest
from designs import UNLIKE, unlike

from cycloid_mj.analysis import analyze
from cycloid_mj.base.errors import ContactError, RunError
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.contact import collider, each_step
from cycloid_mj.dynamics.contact.each_step import EachStep
from cycloid_mj.dynamics.contact.forces import pair_index, surface_name
from cycloid_mj.dynamics.contact.layout import find_step_layout
from cycloid_mj.dynamics.contact.sample_layout import OF_PAIR
from cycloid_mj.dynamics.drive_cycle import initial_state, ramp_and_hold
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.run import Contact, blocks, reducer_model, schedule, simulate
from cycloid_mj.dynamics.timestep import timestep
from cycloid_mj.log import read, write
from cycloid_mj.reducer import Reducer

STEPS, STRIDE = 300, 15
BRIEF = (("drive.hold_s=0.0015", "settings.timestep_us=5"), "profile")


def short(preset: str, *changes: str) -> Design:
    # At full speed from the start, across the clearances: the parts knock against each other.
    begin = ["drive.ramp_s=0", f"drive.hold_s={STEPS * 1e-6}", "load.torque_nm=20", "load.rise_s=0.0001"]
    begin.append("settings.timestep_us=1")
    return override(unlike(preset) if preset in UNLIKE else PRESETS[preset], [*begin, *changes])


def sampled(design: Design, every: int) -> Design:
    return override(design, [f"settings.log_rate_hz={1.0 / (every * timestep(Reducer(design)))!r}"])


def normal_forces(data, compiled) -> dict[str, float]:
    """Add up MuJoCo's own normal forces by the geoms' names."""
    named = {frozenset((pair.on, pair.by)): pair.name for pair in compiled.pairs}
    total = dict.fromkeys((pair.name for pair in compiled.pairs), 0.0)
    force = np.zeros(6)
    for number, contact in enumerate(data.contact):
        mujoco.mj_contactForce(compiled.model, data, number, force)
        total[named[frozenset(surface_name(compiled.model, geom) for geom in contact.geom)]] += force[0]
    return total


@pytest.mark.slow
@pytest.mark.parametrize(
    ("preset", "changes", "contact"),
    [
        ("pin", (), "profile"),
        ("pin", ("ring.pins=sleeved",), "profile"),
        ("nonpin", ("drive.hold_s=0.0005", "settings.timestep_us=5"), "mesh"),
        ("light", *BRIEF),
    ],
)
def test_peaks_are_the_largest_of_mujocos_own_forces_at_every_step(
    preset: str, changes: tuple[str, ...], contact: Contact
) -> None:
    design = short(preset, *changes)
    compiled = reducer_model(Reducer(design), contact)
    data, course = initial_state(compiled, Reducer(design)), ramp_and_hold(compiled, Reducer(design))
    index = pair_index(compiled.model, compiled.pairs)
    largest = dict.fromkeys((pair.name for pair in compiled.pairs), 0.0)
    plan = schedule(Reducer(design))
    commands = course.commands(plan.timestep * np.arange(min(plan.steps, STEPS)))
    for command in commands:
        data.ctrl[:] = command
        with collider.install():
            mujoco.mj_step(compiled.model, data)
        largest = {name: max(largest[name], force) for name, force in normal_forces(data, compiled).items()}
    run = EachStep(compiled.model, initial_state(compiled, Reducer(design), course), index, every=len(commands) - 1)
    run.command(commands)
    with collider.install(), each_step.install():
        first, last = (np.array(row[run.pairs]).reshape(-1, OF_PAIR)[:, 3] for row in run.advance(2))
    assert np.maximum(first, last) == pytest.approx(list(largest.values()), rel=1e-12)
    assert any(force > 0.0 for force in largest.values())


@pytest.mark.slow
def test_a_log_contains_peaks_between_its_samples() -> None:
    design = short("nonpin")
    whole, thinned = simulate(sampled(design, 1)), simulate(sampled(design, STRIDE))
    between = 0
    for pair in build(design).pairs:
        every, some = whole[f"{pair.name}_peak_force"], thinned[f"{pair.name}_peak_force"]
        # A sample at step k stands for the steps after the sample before it, k included.
        since = every[1 : (len(some) - 1) * STRIDE + 1].reshape(-1, STRIDE).max(axis=1)
        np.testing.assert_array_equal(some, [every[0], *since])
        between += int(np.sum(some > 1.001 * every[::STRIDE][: len(some)]))
    assert between > 20, "most peaks fall between samples"
    read = [name for name in whole.columns if not name.endswith("_peak_force")]
    assert {"potential_energy", "kinetic_energy", "crank_torque", "solver_iterations", "cam_force_x"} < set(read)
    for name in read:
        # Steps between samples leave out what nobody reads: the motion is the same to the last bit.
        np.testing.assert_array_equal(thinned[name], whole[name][::STRIDE][: len(thinned[name])], name)


@pytest.mark.parametrize("steps", [1, 2, 3, 10])
def test_as_many_steps_are_taken_as_were_requested(steps: int) -> None:
    design = short("pin")
    compiled = build(design)
    data, course = initial_state(compiled, Reducer(design)), ramp_and_hold(compiled, Reducer(design))
    run = EachStep(compiled.model, data, pair_index(compiled.model, compiled.pairs), steps, [data.qpos.ctypes.data])
    run.command(course.commands(1e-6 * np.arange(STEPS)))
    with collider.install(), each_step.install():
        for taken, samples in ((0, 1), (2, 2), (5, 3)):
            rows = run.advance(samples)
            assert data.time == pytest.approx((taken * steps + 1) * 1e-6, rel=1e-9)
            np.testing.assert_array_equal(data.ctrl, course.commands(np.array([taken * steps + 1]) * 1e-6)[0])
            assert rows.shape[0] == samples
            # the row is of the start of the last step, which has turned the crank further
            turned = data.qpos[0] - 1e-6 * data.qvel[0]
            assert rows[-1, 0] == pytest.approx(turned, rel=1e-12)


@pytest.mark.parametrize("contact", ["profile", "mesh"])
def test_speeds_of_a_sample_are_of_the_middle_between_two_steps(contact: Contact) -> None:
    """MuJoCo's are half a step behind: what the step leaves, and what it found, have the sample's in their middle."""
    design = short("pin", "load.torque_nm=20", "ring.pins=fixed")
    compiled = reducer_model(Reducer(design), contact)
    data, course = initial_state(compiled, Reducer(design)), ramp_and_hold(compiled, Reducer(design))
    with collider.install():
        mujoco.mj_step(compiled.model, data, 30)
    speeds = data.qvel.ctypes.data + 8 * np.arange(compiled.model.nv)
    run = EachStep(compiled.model, data, pair_index(compiled.model, compiled.pairs), 1, speeds.tolist())
    run.command(course.commands(1e-6 * np.arange(STEPS)))
    before = data.qvel.copy()
    with collider.install(), each_step.install():
        row = run.advance(1)[0]
    middle = 0.5 * (before + data.qvel)
    np.testing.assert_allclose(row[: compiled.model.nv], middle, rtol=1e-12, atol=1e-15)
    assert np.abs(middle - before).max() > 1e-6
    momentum = np.zeros(compiled.model.nv)
    mujoco.mj_mulM(compiled.model, data, momentum, middle)
    assert row[run.copied][-1] == pytest.approx(0.5 * middle @ momentum, rel=1e-9)


def test_a_fatal_error_of_mujocos_between_samples_is_an_error_of_python(monkeypatch, tmp_path) -> None:
    """Too little memory for the solver, once the load is on."""
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its warnings to a file there
    design = short("pin")
    compiled = build(design)
    compiled.spec.memory = 80_000
    model, start = compiled.spec.compile(), initial_state(compiled, Reducer(design))
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = start.qpos, start.qvel
    run = EachStep(model, data, pair_index(model, compiled.pairs), STEPS)
    run.command(ramp_and_hold(compiled, Reducer(design)).commands(1e-6 * np.arange(STEPS)))
    with collider.install(), each_step.install(), pytest.raises(mujoco.FatalError, match="out of memory"):
        run.advance(2)
    assert 1 < round(1e6 * data.time) < STEPS - 2


def test_frictionless_pairs_peak_at_the_size_of_their_force() -> None:
    design = sampled(short("pin", *(f"friction.{kind}=0" for kind in ("pin_gear", "pin_socket"))), 1)
    run = simulate(design)
    for number in (1, 9, 30):
        force = np.hypot(run[f"pin_{number}_force_x"], run[f"pin_{number}_force_y"])
        np.testing.assert_allclose(run[f"pin_{number}_peak_force"], force, rtol=1e-12)


def test_the_places_in_mujocos_structures_are_found() -> None:
    found = find_step_layout()
    assert len({found.contact, found.efc_force, found.efc_vel, found.userdata, found.ncon}) == 5
    within = [0, found.pos, found.frame, found.dim, found.geom, found.efc_address, found.stride]
    assert within == sorted(set(within))
    assert all(place % 4 == 0 for place in found)


def test_a_log_without_peaks_is_read_and_judged_as_before(tmp_path) -> None:
    run = simulate(sampled(short("nonpin"), STRIDE))
    older = {name: values for name, values in run.columns.items() if not name.endswith("_peak_force")}
    topics = {topic: [name for name in names if name in older] for topic, names in run.topics.items()}
    run = replace(run, columns=older, units={name: run.units[name] for name in older}, topics=topics)
    write(run, tmp_path / "old.mcap")
    again = read(tmp_path / "old.mcap")
    assert set(again.columns) == set(older)
    assert analyze(again).contact_summary == analyze(run).contact_summary


def test_peak_forces_are_logged_with_the_forces() -> None:
    run = simulate(sampled(short("pin"), STRIDE))
    assert {"cam_peak_force", "pin_1_peak_force", "socket_36_peak_force"} <= set(run.topics["/forces"])
    assert "peak_force" in run.topics["/reducer"]


def test_a_model_steps_without_a_run() -> None:
    compiled = build(short("nonpin"))
    data = mujoco.MjData(compiled.model)
    data.ctrl[:] = 1e-3
    with collider.install(), each_step.install():
        mujoco.mj_step(compiled.model, data, 3)
    assert data.ctrl.tolist() == [1e-3, 1e-3]
    assert data.sensor(each_step.SENSOR).data == [0.0]


def test_a_foreign_model_keeps_its_user_sensors_and_user_data() -> None:
    text = '<mujoco><size nuserdata="{}"/><worldbody/><sensor><user dim="1" needstage="acc"/></sensor></mujoco>'
    with each_step.install():
        for count in (0, 1, 2):
            model = mujoco.MjModel.from_xml_string(text.format(count))
            data = mujoco.MjData(model)
            mujoco.mj_step(model, data, 3)
            assert not data.userdata.any()


@pytest.mark.parametrize("setter", [mujoco.set_mjcb_sensor, mujoco.set_mjcb_control])
def test_a_callback_of_somebody_else_is_not_replaced(setter: Callable[[Any], None]) -> None:
    design = short("nonpin")
    compiled = build(design)
    setter(lambda *_: None)
    try:
        with pytest.raises(ContactError, match=setter.__name__):
            list(blocks(compiled, Reducer(design)))
    finally:
        setter(None)
    assert len(simulate(sampled(short("nonpin"), STRIDE)))


def test_the_model_of_a_run_is_written_when_it_is_requested(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    monkeypatch.setattr("cycloid_mj.dynamics.run.xml", lambda spec: asked.append("model") or "<mujoco/>")
    run = simulate(sampled(short("nonpin"), STRIDE))
    late = run.select(run.time > 1e-4)
    assert set(late.attachments) == {"design.toml", "model.xml"}
    assert not asked
    assert [late.attachments["model.xml"] for _ in range(2)] == [b"<mujoco/>"] * 2
    assert asked == ["model"]


def test_timers_are_disabled_in_a_run_and_enabled_afterwards() -> None:
    compiled = build(short("nonpin"))
    data = mujoco.MjData(compiled.model)
    with each_step.install():
        mujoco.mj_step(compiled.model, data)
    assert not data.timer.duration.any()
    mujoco.mj_step(compiled.model, data)
    assert data.timer.duration.any()


def test_a_run_that_fails_yields_its_samples_up_to_there() -> None:
    """Many samples are taken at a time; the first that is wrong is the last that is given."""
    design = sampled(short("pin"), 3)
    depth = simulate(design)["penetration"]
    limit = 0.5 * float(depth.max())
    limited = override(design, [f"contact.max_penetration_um={1e6 * limit!r}"])
    given = blocks(build(limited), Reducer(limited))
    kept = []
    with pytest.raises(RunError, match="max_penetration_um"):
        kept.extend(block.values["/reducer"] for block in given)
    wrong = int(np.argmax(depth > limit))
    assert 0 < wrong < len(depth) - 1
    assert sum(map(len, kept)) == wrong + 1
