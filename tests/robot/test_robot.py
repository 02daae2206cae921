"""The reducer as one joint: in MuJoCo against the full model, its steps, its files, and joints of other models."""

import json
import math
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest
from designs import design_file, unlike
from scipy import stats

import cycloid_mj as cm
from cycloid_mj import measure
from cycloid_mj.base.errors import CycloidError, DesignError, UsageError
from cycloid_mj.base.result import to_json_values
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.cli import main
from cycloid_mj.cli.reduce import describe_inaccuracy
from cycloid_mj.design import PRESETS
from cycloid_mj.measure import rigid_backlash
from cycloid_mj.measure.efficiency_map import run_backward, run_forward
from cycloid_mj.reducer import Reducer
from cycloid_mj.robot import LEVELS, ReducedJoint, identification, standalone
from cycloid_mj.robot.bam import fit_bam_models
from cycloid_mj.robot.comparison import BOUNDS, COMPARISON, compare_with_full_model
from cycloid_mj.robot.impact import run_impact, solve_impact
from cycloid_mj.robot.lossy import lossy_efficiencies, lossy_joint_xml, lossy_scene_xml
from cycloid_mj.robot.mjcf import joint_xml, scene_xml
from cycloid_mj.robot.population import Population, compute_parameters, draw_population
from cycloid_mj.robot.reducer import Slip
from cycloid_mj.robot.stability import (
    STUDY,
    choose_time_step,
    longest_accurate,
    measure_vibration,
    study_time_steps,
    try_time_step,
)
from cycloid_mj.robot.trial import create_trial_scene
from cycloid_mj.statics.locked import LockedCurve, SlipElements, follow_locked_path
from cycloid_mj.statics.sheet import sheet

KEYS = (
    "ratio",
    "backlash_arcmin",
    "stiffness_nm_per_arcmin",
    "stiffness_polynomial",
    "efficiency",
    "back_driving_efficiency",
    "no_load_torque_nm",
    "rotor_inertia_kg_m2",
)


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> Path:
    """The files of a preset."""
    into = tmp_path_factory.mktemp("pin")
    assert main(["reduce", "--design", "pin", "--out", str(into), "--quiet"]) == 0
    return into


@cache
def joint_of(name: str) -> ReducedJoint:
    return cm.reduce(unlike(name))


@pytest.fixture
def few() -> ReducedJoint:
    """A small reducer, 6:1, whose transmission error is large."""
    return joint_of("few")


@pytest.fixture(scope="module")
def told(files: Path) -> dict:
    return json.loads((files / "reducer.json").read_text())


def test_a_joint_has_a_figure_and_a_short_repr(few: ReducedJoint) -> None:
    assert repr(few).startswith(f"<ReducedJoint: {few.name}, ")
    assert few.frame.rows == len(few.quantities)
    (line,) = few.plot().axes[0].lines
    wound, arcmin = few.wind_up(few.rated_torque), 10800.0 / math.pi
    assert line.get_ydata()[0] == pytest.approx((few.stops[0] - wound) * arcmin)
    assert line.get_ydata()[-1] == pytest.approx((few.stops[1] + wound) * arcmin)


@pytest.mark.slow
def test_joint_matches_the_full_model(told: dict) -> None:
    """The bounds of the comparison are those promised; it is run by MuJoCo, not read back."""
    assert BOUNDS == {
        "backlash_arcmin": 0.002,
        "loop_arcmin": 0.01,
        "wind_up_arcmin": 0.01,
        "resonance_hz": 0.02,
        "te_harmonic": 0.05,
    }
    assert COMPARISON.max_efficiency == 0.3
    rows = {row["key"]: row for row in told["comparison"]}
    assert set(BOUNDS) - {"te_harmonic"} < set(rows)
    assert sum(row["unit"] == "%" for row in rows.values()) == 10
    for way in ("forward", "reverse"):
        assert sum(key.startswith(f"te_{way}") for key in rows) >= 2
    assert all(row["holds"] for row in rows.values())
    assert all(abs(row["value"] - row["reference"]) <= row["bound"] for row in rows.values())


@pytest.mark.slow
def test_joint_parameters_match_the_full_model(told: dict) -> None:
    design = PRESETS[told["design"]]
    found = sheet(Reducer(design)).quantities
    assert told["ratio"]["value"] == design.lobes
    assert told["backlash_arcmin"]["value"] == pytest.approx(
        rigid_backlash.backlash_over_turn(Reducer(design))[1].mean() / ARCMINUTE, rel=0.002
    )
    assert told["backlash_arcmin"]["value"] == pytest.approx(found["backlash"].value, rel=0.002)
    assert told["stiffness_nm_per_arcmin"]["value"] == pytest.approx(found["stiffness_ideal"].value, rel=0.01)
    assert told["efficiency"]["value"] == pytest.approx(found["efficiency"].value, abs=0.05)
    assert told["back_driving_efficiency"]["value"] == pytest.approx(found["back_driving_efficiency"].value, abs=0.05)
    for key in KEYS:
        assert set(told[key]) >= {"value", "unit", "numerical_error"}
    for one in told["te_harmonics"]:
        assert set(one) >= {"value", "unit", "numerical_error", "order", "way", "load_nm"}
        assert one["numerical_error"] < 0.05 * max(one["value"], 0.02)
    peak = sum(
        2.0 * one["value"]
        for one in told["te_harmonics"]
        if one["way"] == "forward" and one["load_nm"] == pytest.approx(design.rated_torque)
    )
    assert found["output_peak_to_peak_loaded_forward_speed"].value <= peak
    a, b, c = told["stiffness_polynomial"]["value"]
    x = told["wind_up_arcmin"]["value"] * ARCMINUTE
    assert a * x + b * x**2 + c * x**3 == pytest.approx(design.rated_torque, rel=0.03)


@pytest.mark.slow
def test_dynamic_runs_find_the_same(told: dict) -> None:
    """The figures of the dynamic full model, as ``tests/data/measured.json`` keeps them with their errors."""
    found = json.loads((Path(__file__).parents[1] / "data" / "measured.json").read_text())[told["design"]]
    joint = {row["key"]: row["value"] for row in told["comparison"]}
    rows = (
        (joint["backlash_arcmin"], found["backlash/backlash"], 0.002),
        (joint["loop_arcmin"], found["lost-motion/lost_motion"], 0.01),
        (told["stiffness_nm_per_arcmin"]["value"], found["lost-motion/stiffness_ideal"], 0.01),
    )
    for ours, theirs, bound in rows:
        assert ours == pytest.approx(theirs["value"], rel=bound)
    for key in ("efficiency", "back_driving_efficiency"):
        assert told[key]["value"] == pytest.approx(found[f"efficiency/{key}"]["value"], abs=0.3)


@pytest.mark.slow
def test_a_dynamic_loop_and_run_find_the_same() -> None:
    """The full model in MuJoCo, run here: slow loops at two locked crank angles, and a loaded run each way."""
    design = PRESETS["nonpin"]
    reduced = cm.reduce(design)
    loop = measure.lost_motion(design, quick=True)
    wound = 2.0 * reduced.wind_up(0.03 * reduced.rated_torque) + reduced.backlash
    assert loop["lost_motion"] == pytest.approx(wound / ARCMINUTE, rel=0.015)  # two of the angles that the mean is over
    assert loop["stiffness_ideal"] == pytest.approx(reduced.quantities["stiffness_nm_per_arcmin"].value, rel=0.02)
    logged = Reducer(design.but(settings={"log_rate": 20000.0}))
    run = run_forward(logged, design.rated_torque, design.drive.speed, 4, "mujoco")
    assert 100.0 * run.powers.efficiency == pytest.approx(reduced.quantities["efficiency"].value, abs=0.3)
    back = run_backward(logged, design.drive.torque, 4, "mujoco")
    assert 100.0 * back.powers.efficiency == pytest.approx(reduced.quantities["back_driving_efficiency"].value, abs=0.3)


@pytest.mark.slow
def test_steps_are_recommended_by_an_impact(told: dict) -> None:
    """`discrete` is stable at 5 ms and far off there; what is recommended is right, with its error beside it."""
    reduced = ReducedJoint.from_json(told)
    steps = study_time_steps(reduced)
    assert {one.timestep for one in steps} >= set(STUDY.steps)
    assert [one["stable"] for one in told["steps"]] == [one.stable for one in steps]
    for one in steps:
        if one.level == "rigid":
            assert one.accurate
            continue
        if one.integrator == "implicitfast":
            fastest = math.sqrt(reduced.stiffness(reduced.rated_torque) / (one.inertia + reduced.output_inertia))
            assert not (one.good and one.timestep * fastest > 2.2)
            assert one.good or one.timestep * fastest > 0.3
        elif one.load != "bare output":
            assert one.stable
    rows = {(one["level"], one["integrator"]): one for one in told["recommended"]}
    for (level, integrator), row in rows.items():
        for load, step in row["by_load"].items():
            found = longest_accurate(steps, level, integrator, load)
            assert step == (found.timestep if found else 0.0)
            if level != "rigid" and found:
                assert row["impact_error"][load] == found.impact_error
                assert abs(found.impact_error) <= STUDY.impact_rtol
    assert 5e-4 <= rows["full", "implicitfast"]["by_load"]["matched"] <= 1e-3
    assert rows["full", "discrete"]["by_load"]["matched"] == 0.0
    [far] = [
        one
        for one in told["steps"]
        if one["load"] == "matched" and one["timestep_s"] == 5e-3 and one["stable"] and one["level"] == "backlash"
    ]
    assert far["impact_hz"] == 3.0
    assert far["impact_error"] > 1.0
    assert told["scene"]["accurate"]
    assert told["scene"]["timestep_s"] <= 1e-3


def test_the_output_rests_where_the_springs_balance_at_any_play(few: ReducedJoint) -> None:
    """Play from 0.1 arcmin to 5 deg, and a damping that would take minutes to cross it under the small torque."""
    for arcmin in (0.1, 10.0, 150.0, 300.0):
        half = 0.5 * arcmin * ARCMINUTE
        wide = replace(few, stops=(-half, half), damping=100.0 * few.damping, level="backlash")
        on = create_trial_scene(wide, 1e-3 * wide.reflected_inertia, 5e-3)
        on.hold()
        for torque in (1e-4 * wide.rated_torque, wide.rated_torque):
            turn = on.find_rest(torque) - on.find_rest(-torque)
            assert turn == pytest.approx(2.0 * (half + wide.wind_up(torque)), rel=2e-6)


def test_a_slow_vibration_has_its_frequency(few: ReducedJoint) -> None:
    """Of a load so heavy that ten thousand steps of 0.1 ms see less than two periods."""
    slow = replace(few, level="backlash")
    inertia = 1e6 * slow.reflected_inertia
    period = 2.0 * math.pi * math.sqrt(inertia / slow.stiffness(slow.rated_torque))
    assert period > 0.6
    stable, error, frequency = measure_vibration(
        create_trial_scene(slow, inertia, period / 300.0, "implicitfast"), inertia
    )
    assert stable
    assert abs(error) < 2e-3
    assert abs(frequency) < 1e-3


def test_an_impact_converges_to_another_integrator(few: ReducedJoint) -> None:
    """LSODA on the joint's equation against MuJoCo at a hundredth of the vibration's period; damping halves by step."""
    reduced = replace(few, level="backlash")
    inertia = reduced.reflected_inertia
    struck = solve_impact(reduced, inertia)
    period = 2.0 * math.pi * math.sqrt(inertia / reduced.stiffness(reduced.rated_torque))
    errors = {
        integrator: run_impact(create_trial_scene(reduced, inertia, period / 400.0, integrator), struck) / struck.peak
        - 1.0
        for integrator in ("implicitfast", "discrete")
    }
    assert abs(errors["implicitfast"]) < 0.005
    assert errors["discrete"] < 3.0 * -abs(errors["implicitfast"])
    assert struck.peak > 1.01 * reduced.wind_up(reduced.rated_torque)


def test_an_impact_waits_for_a_heavy_load_to_cross(few: ReducedJoint) -> None:
    wide = replace(few, stops=(-0.04, 0.04), level="backlash")
    struck = solve_impact(wide, 100.0 * wide.reflected_inertia)
    assert struck.frequency < 3.0
    assert struck.peak > 0.0


def test_a_pressed_joint_rests(few: ReducedJoint) -> None:
    """At `backlash` the transmission error has no part in where the joint is wound up to, at `full` it has."""
    for level in ("backlash", "full"):
        on = create_trial_scene(few.at(level), few.reflected_inertia, 1e-4)
        on.hold()
        on.press_to_stop(few.rated_torque)
        before = on.length
        for _ in range(200):
            on.step()
        assert on.length == pytest.approx(before, abs=1e-4 * few.wind_up(few.rated_torque))


@pytest.mark.slow
@pytest.mark.parametrize("um", [0.06, 100.0, 150.0])
def test_the_joint_of_a_printed_drive_holds_whatever_its_play(um: float, tmp_path: Path, monkeypatch) -> None:
    """15:1 of 60 mm in plastic: 0.1 to more than 200 arcmin of play."""
    monkeypatch.chdir(tmp_path)
    size = ["--ratio", "15", "--diameter-mm", "60", "--torque-nm", "0.3", "--process", "printed"]
    assert main(["design", "new", "p15", *size]) == 0
    design = cm.load("p15.toml").but(clearance=dict.fromkeys(("pin_gear", "cam", "output"), um * 1e-6))
    reduced = cm.reduce(design)
    found = compare_with_full_model(Reducer(design), reduced)
    by_gaps = rigid_backlash.backlash_over_turn(Reducer(design))[1].mean()
    assert reduced.backlash == pytest.approx(by_gaps, rel=0.02)
    assert found.outside_bounds == []


@pytest.mark.slow
def test_the_scene_opens_in_mujoco_without_this_package(files: Path) -> None:
    """In a process where cycloid_mj cannot be imported; what the joint does there is the play of its JSON file."""
    code = """
import sys, json, importlib.util
sys.modules["cycloid_mj"] = None
import mujoco
model = mujoco.MjModel.from_xml_path(sys.argv[1])
data = mujoco.MjData(model)
crank, output = (model.joint(name) for name in ("output_rotor", "output"))
model.dof_armature[crank.dofadr[0]] = 1e6
mujoco.mj_setConst(model, data)
turned = []
for torque in (0.5, -0.5):
    data.qfrc_applied[output.dofadr[0]] = torque
    for _ in range(3000):
        mujoco.mj_step(model, data)
    turned.append(data.qpos[output.qposadr[0]] + data.qpos[crank.qposadr[0]] * model.wrap_prm[0])
data.ctrl[0] = 1.0
mujoco.mj_step(model, data)
assert not data.warning.number.any()
print(json.dumps({"turn": turned[0] - turned[1], "version": mujoco.__version__}))
"""
    # without the folder of the tests and the project on the path
    run = subprocess.run(
        [sys.executable, "-c", code, str(files / "scene.xml")], capture_output=True, text=True, cwd=files, check=False
    )
    assert run.returncode == 0, run.stderr
    reduced = ReducedJoint.read(files / "reducer.json")
    expected = reduced.backlash + 2.0 * reduced.wind_up(0.5)
    assert json.loads(run.stdout)["turn"] == pytest.approx(expected, rel=1e-4)


@pytest.mark.slow
def test_a_reducer_is_restored_from_its_file(files: Path) -> None:
    reduced = ReducedJoint.read(files / "reducer.json")
    again = ReducedJoint.from_json(json.loads(json.dumps(reduced.as_json())))
    assert again == reduced
    assert again.fingerprint == reduced.fingerprint
    assert (files / "joint.xml").read_text() == joint_xml(again)


@pytest.mark.slow
def test_bam_holds_the_friction(files: Path) -> None:
    """M5 by BAM's own formula is the reducer's friction both ways; M3 cannot tell who drives."""
    reduced, found = ReducedJoint.read(files / "reducer.json"), json.loads((files / "bam.json").read_text())
    assert found == json.loads(json.dumps(fit_bam_models(reduced)))
    rated, ratio = reduced.rated_torque, reduced.ratio
    for driving in (True, False):
        own = ratio * reduced.friction.torque(rated, reduced.rated_speed, driving)
        external, motor = -rated, rated + (own if driving else -own)
        m3, m5 = found["m3"], found["m5"]
        by_m3 = m3["friction_base"] + m3["load_friction_base"] * abs(external - motor)
        by_m5 = m5["friction_base"] + abs(external * m5["load_friction_external"] - motor * m5["load_friction_motor"])
        assert by_m5 == pytest.approx(own, rel=0.05)
        assert by_m3 == pytest.approx(own, rel=0.1)
        assert abs(by_m5 - own) <= found["largest_error_nm"]["m5"] * 1.0001
    assert found["largest_error_nm"]["m5"] <= found["largest_error_nm"]["m3"]


@pytest.mark.slow
def test_the_page_is_complete(files: Path) -> None:
    page = (files / "reducer.html").read_text()
    assert "http" not in page.replace("http://www.w3.org/2000/svg", "")
    for word in ("hysteresis loop", "transmission error", "efficiency of back-driving", "&lt;dynamics&gt;", "BAM"):
        assert word in page


@pytest.mark.slow
@pytest.mark.parametrize("name", ["few", "light", "printed", "nonpin-n33-d2-ring-60um"])
def test_other_designs_hold_too(name: str) -> None:
    """Wide clearances and a reducer that locks itself; few teeth, whose error is a third of the wind-up; play, by which
    the losses of light loads bend."""
    design, reduced = unlike(name), joint_of(name)
    assert compare_with_full_model(Reducer(design), reduced).outside_bounds == []
    assert reduced.backlash == pytest.approx(rigid_backlash.backlash_over_turn(Reducer(design))[1].mean(), rel=0.005)
    if name == "printed":
        assert reduced.quantities["back_driving_efficiency"].value == 0.0
        assert "self-locking" in reduced.quantities["back_driving_efficiency"].note


@pytest.mark.slow
def test_a_reducer_that_locks_itself_supports_its_load() -> None:
    """With friction from the load the output cannot turn the crank; the same without `step` lets it go."""
    reduced, turned = joint_of("printed"), []
    for level in ("full", "backlash"):
        on = create_trial_scene(reduced.at(level), 0.01, 1e-3)
        on.press_to_stop(reduced.rated_torque)
        for _ in range(500):
            on.step()
        turned.append(abs(on.data.qpos[on.addresses.crank_angle]))
    assert turned[0] < 0.05
    assert turned[1] > 10.0


@pytest.mark.slow
def test_the_error_comes_through_up_to_the_speed_stated(few: ReducedJoint) -> None:
    """At the matched inertia the strongest harmonic is within 5 % at the speed that is stated, not at thrice that."""
    design = unlike("few")
    stated = compare_with_full_model(Reducer(design), few).highest_speed
    strongest = int(np.argmax(np.hypot(few.ripple.high_cos[-1], few.ripple.high_sin[-1])))
    order = few.ripple.orders[strongest]
    expected = math.hypot(few.ripple.high_cos[-1][strongest], few.ripple.high_sin[-1][strongest])

    def amplitude(speed: float) -> float:
        step = 2.0 * np.pi / (order * speed) / 200.0
        on = create_trial_scene(few, few.reflected_inertia, step, "implicitfast")
        on.model.dof_damping[on.addresses.output_speed] = 3.0 * few.damping  # for the transient to die away
        on.hold(speed)
        on.press_to_stop(few.rated_torque)
        on.push(few.rated_torque - 3.0 * few.damping * few.coefficient * speed)
        angle, length = np.empty((2, 14_000))
        for i in range(angle.size):
            on.step()
            angle[i], length[i] = on.data.qpos[on.addresses.crank_angle], on.length
        rows = slice(-round(few.ratio) * 200 * 9, None)
        basis = np.exp(-1j * order * angle[rows])
        return 2.0 * abs(np.mean(basis * (length[rows] - length[rows].mean())))

    assert amplitude(stated) == pytest.approx(expected, rel=0.05)
    assert amplitude(3.0 * stated) != pytest.approx(expected, rel=0.05)


ARM = """<mujoco>
  <compiler angle="radian" {compiler}/>
  <default><joint damping="1" armature="0.04"/></default>
  <worldbody><body name="upper" pos="0 0 1">
    <joint name="shoulder" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.04"/>
    <body name="lower" pos="0.4 0 0" euler="0.3 0.1 0.2">
      <joint name="elbow" pos="0.01 0 0" axis="0 0.6 0.8"/><geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03"/>
      <body name="tool" pos="0.3 0 0"><joint name="wrist" axis="1 0 0"/><joint name="out" type="slide"/>
      <geom size="0.03"/></body>
    </body></body></worldbody>
  <actuator><motor name="torque" joint="shoulder" gear="2"/><position name="servo" joint="elbow" kp="50"/></actuator>
  <keyframe><key name="home" qpos="0.1 0.2 0.3 0.01" qvel="1 2 3 0" ctrl="1 0.2"/></keyframe>
</mujoco>"""


def arm(compiler: str = "") -> "mujoco.MjSpec":
    return mujoco.MjSpec.from_string(ARM.format(compiler=compiler))


@pytest.mark.parametrize("compiler", ["", 'inertiafromgeom="true"'])
def test_a_reducer_attaches_to_joints_of_any_model(few: ReducedJoint, compiler: str) -> None:
    """Two joints of a tree: cranks on the joints' axes, motors that mean what they did, a keyframe that fits."""
    spec, before = arm(compiler), arm(compiler).compile()
    for joint in ("shoulder", "elbow"):
        cm.attach_reducer(spec, joint, few)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    assert model.nv == before.nv + 2
    assert len(list(few.places(model))) == 2
    for place in few.places(model):
        length = data.qpos[place.output_angle] + few.coefficient * data.qpos[place.crank_angle]
        assert length == pytest.approx(few.middle, abs=1e-12)
        assert data.qvel[place.output_speed] == pytest.approx(-few.coefficient * data.qvel[place.crank_speed])
        assert model.dof_damping[place.output_speed] == model.dof_damping[place.crank_speed] == 0.0
        assert model.dof_armature[place.output_speed] == pytest.approx(few.output_inertia)
        assert model.dof_armature[place.crank_speed] == pytest.approx(few.rotor_inertia)
    for joint in ("shoulder", "elbow", "wrist", "out"):
        at = [one.joint(joint).qposadr[0] for one in (before, model)]
        assert model.key_qpos[0][at[1]] == before.key_qpos[0][at[0]]
    for joint in ("shoulder", "elbow"):
        mine, crank = model.joint(joint), model.joint(f"{joint}_rotor")
        assert data.xaxis[crank.id] == pytest.approx(data.xaxis[mine.id]) or joint == "elbow"
    # the same torque at the output, the same angle as the motor sees it
    assert data.actuator("torque").length[0] == pytest.approx(2.0 * data.joint("shoulder").qpos[0], abs=2e-3)
    assert data.actuator("servo").length[0] == pytest.approx(data.joint("elbow").qpos[0], abs=1e-3)
    turned = model.joint("shoulder_rotor").dofadr[0]
    assert data.qfrc_actuator[turned] == pytest.approx(2.0 / few.ratio * few.way)


def test_an_arm_moves_as_one_with_that_inertia(few: ReducedJoint) -> None:
    """By the same motor, an arm on the springs of a reducer goes the way of one on a joint with its inertia alone."""
    turned = []
    for level in ("backlash", "rigid"):
        spec = arm()
        for joint in ("elbow", "wrist", "out"):
            spec.joint(joint).stiffness[0] = 1e4
        cm.attach_reducer(spec, "shoulder", few.at(level))
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
        model = spec.compile()
        data = mujoco.MjData(model)
        data.ctrl[0] = -10.0
        for _ in range(150):
            mujoco.mj_step(model, data)
        turned.append(data.joint("shoulder").qpos[0])
    assert abs(turned[0]) > 0.1
    assert turned[0] == pytest.approx(turned[1], rel=0.02)


@pytest.mark.parametrize("driving", [True, False])
def test_the_lossy_joint_has_the_same_loss_in_mujoco_without_this_package(few: ReducedJoint, driving: bool) -> None:
    """Within 2 points of the full model at half and all of the rated torque, with the crank or the output driving."""
    found = [one for one in lossy_efficiencies(few) if one.driving == driving]
    assert [one.share for one in found] == [0.1, 0.5, 1.0]
    for one in found[1:]:
        assert one.percent == pytest.approx(one.full_model_percent, abs=2.0)
        assert one.full_model_percent < 98.0


@pytest.mark.parametrize("slower", [1.0, 64.0])
def test_the_lossy_joint_distinguishes_driving_from_being_driven(few: ReducedJoint, slower: float) -> None:
    """Where a drive loses half as much again driving as driven, one shoe loses both, within 2 points, if slow too."""
    driven = tuple(tuple(one / 6.0 for one in row) for row in few.friction.driven)
    other = replace(
        few.friction,
        speeds=tuple(one / slower for one in few.friction.speeds),
        driven=driven,
        driving=tuple(tuple(1.5 * one for one in row) for row in driven),
    )
    slow = replace(few, ratio=6.0 * few.ratio, rated_speed=few.rated_speed / slower, friction=other)
    found = lossy_efficiencies(slow)
    for one in found:
        if one.share > 0.1:
            assert one.percent == pytest.approx(one.full_model_percent, abs=2.0)
    driving, driven = (next(one for one in found if one.share == 1.0 and one.driving == way) for way in (True, False))
    assert driving.percent < driven.percent - 3.0


@pytest.mark.parametrize(("share", "moves"), [(0.5, False), (2.0, True)])
def test_the_shoe_holds_up_to_its_friction(few: ReducedJoint, share: float, moves: bool) -> None:
    """The rated load is balanced but for a share of what the shoe can hold: at rest, or off within a second."""
    files = {"lossy_joint.xml": lossy_joint_xml(few).encode()}
    model = mujoco.MjModel.from_xml_string(lossy_scene_xml(few, few.reflected_inertia, 1e-3), files)
    data, place = mujoco.MjData(model), next(few.places(model))
    data.qfrc_applied[place.output_speed] = few.rated_torque
    data.qpos[place.output_angle] = few.stops[1] + few.wind_up(few.rated_torque)
    lost = [few.friction.torque(few.rated_torque, few.rated_speed, way) for way in (True, False)]
    data.ctrl[0] = few.coefficient * few.rated_torque + share * 0.5 * sum(lost)
    for _ in range(1000):
        mujoco.mj_step(model, data)
    assert (abs(data.qpos[place.crank_angle]) > 0.1) == moves


STANDALONE = """
import sys, json
sys.modules["cycloid_mj"] = None
sys.path.insert(0, sys.argv[1])
import joint, mujoco, numpy as np
one = joint.Joint()
model = mujoco.MjModel.from_xml_path(sys.argv[1] + "/scene.xml")
data, found = mujoco.MjData(model), []
for angle, length, speed, torque in json.loads(sys.argv[2]):
    data.qpos[:], data.qvel[:] = 0.0, 0.0
    crank, output = model.joint("output_rotor"), model.joint("output")
    data.qpos[crank.qposadr[0]], data.qvel[crank.dofadr[0]] = angle, speed
    data.qpos[output.qposadr[0]] = length - one.coefficient * angle
    data.qfrc_applied[crank.dofadr[0]] = torque
    one.step(model, data)
    found.append([*model.tendon_lengthspring.ravel(), *model.tendon_damping, *model.dof_frictionloss])
print(json.dumps({"found": found, "timestep": one.timestep}))
"""


def test_joint_py_repeats_the_step_with_numpy_only(few: ReducedJoint, tmp_path: Path) -> None:
    """In a process where cycloid_mj cannot be imported it writes what `ReducedJoint.step` does in any state."""
    draw = np.random.default_rng(0).uniform
    reach = few.backlash + 2.0 * few.wind_up(few.rated_torque)
    states = [
        (
            draw(0.0, 40.0),
            few.middle + draw(-reach, reach),
            draw(-2.0, 2.0) * few.rated_speed * (i % 3),
            draw(-1.0, 1.0),
        )
        for i in range(60)
    ]
    content = few.as_json() | {"scene": {"timestep_s": 1e-3, "integrator": "discrete"}}
    (tmp_path / "reducer.json").write_text(json.dumps(content))
    (tmp_path / "joint.py").write_text(Path(standalone.__file__).read_text())
    (tmp_path / "joint.xml").write_text(joint_xml(few))
    (tmp_path / "scene.xml").write_text(scene_xml(few, 0.1, 1e-3))
    words = [sys.executable, "-c", STANDALONE, str(tmp_path), json.dumps(states)]
    run = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert run.returncode == 0, run.stderr
    told = json.loads(run.stdout)
    assert told["timestep"] == 1e-3
    on = create_trial_scene(few, 0.1, 1e-3)
    for (angle, length, speed, torque), found in zip(states, told["found"], strict=True):
        on.data.qpos[on.addresses.crank_angle], on.data.qvel[on.addresses.crank_speed] = angle, speed
        on.data.qpos[on.addresses.output_angle] = length - few.coefficient * angle
        on.data.qfrc_applied[on.addresses.crank_speed] = torque
        few.step(on.model, on.data)
        ours = [*on.model.tendon_lengthspring.ravel(), *on.model.tendon_damping, *on.model.dof_frictionloss]
        assert found == pytest.approx(ours, rel=1e-9, abs=1e-15)


MAPPED = """
import json, sys
import jax
jax.config.update("jax_enable_x64", True)
import numpy as np
import joint
states = np.array(json.loads(sys.argv[1])).T
one = joint.Joint()
mapped = jax.jit(jax.vmap(lambda *state: one.terms(*state, xp=jax.numpy)))(*states)
each = [one.terms(*state) for state in states.T]
print(json.dumps([[np.array(part).ravel().tolist() for part in found] for found in (mapped, zip(*each))]))
"""


def test_joint_py_compiles_for_mjx(few: ReducedJoint, tmp_path: Path) -> None:
    """Compiled and mapped by JAX over 200 states, in double precision, it gives what numpy does in each."""
    pytest.importorskip("jax", reason="JAX is no requirement of the tests: see pyproject.toml")
    draw = np.random.default_rng(0).uniform
    reach = few.backlash + 2.0 * few.wind_up(few.rated_torque)
    crank = draw(0.0, 40.0, 200)
    output = few.middle + draw(-reach, reach, 200) - few.coefficient * crank
    speed = draw(-2.0, 2.0, 200) * few.rated_speed * (np.arange(200) % 3)
    states = np.stack([output, crank, speed, draw(-1.0, 1.0, 200)], axis=1)
    content = few.as_json() | {"scene": {"timestep_s": 1e-3, "integrator": "implicitfast"}}
    (tmp_path / "reducer.json").write_text(json.dumps(content))
    (tmp_path / "joint.py").write_text(Path(standalone.__file__).read_text())
    # a process of its own: JAX starts threads, after which none may be forked
    words = [sys.executable, "-c", MAPPED, json.dumps(states.tolist())]
    run = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert run.returncode == 0, run.stderr
    mapped, each = json.loads(run.stdout)
    for compiled, expected in zip(mapped, each, strict=True):
        assert compiled == pytest.approx(expected, rel=1e-9, abs=1e-12)


TOLERANCES = {"cam": "uniform 4", "output": "between -2 6", "pin_position": "normal 2"}


@pytest.fixture(scope="module")
def drives() -> Population:
    """Some drives of a small reducer."""
    return draw_population(Reducer(unlike("few")).but(tolerance=TOLERANCES), 8, seed=3)


def test_drives_are_the_same_by_the_same_seed_and_not_by_another(drives: Population) -> None:
    reducer = Reducer(unlike("few")).but(tolerance=TOLERANCES)
    again, other = draw_population(reducer, 4, seed=3), draw_population(reducer, 4, seed=4)
    first = {key: values[: again.samples].tolist() for key, values in drives.values.items()}
    assert {key: values.tolist() for key, values in again.values.items()} == first
    assert other.values["backlash_arcmin"][0] != pytest.approx(again.values["backlash_arcmin"][0], rel=1e-6)


def test_a_drive_is_the_design_with_what_was_drawn(drives: Population) -> None:
    """A row made again by hand, as a design file of its own, has the row's parameters."""
    design, row = unlike("few"), 2
    drawn = {key: values[row] for key, values in drives.deviations.items()}
    places = {
        f"pin_{axis}": tuple(1e-6 * drawn[f"drawn_pin_position_{pin}_{axis}_um"] for pin in range(1, design.lobes + 2))
        for axis in "xy"
    }
    clearance = {key: getattr(design.clearance, key) + 1e-6 * drawn[f"drawn_{key}_um"] for key in ("cam", "output")}
    friction = {key.removeprefix("drawn_friction_"): value for key, value in drawn.items() if "_friction_" in key}
    made = Reducer(design).but(
        errors=places, clearance=clearance, friction=friction, stiffness={"cam": drawn["drawn_stiffness_cam"]}
    )
    assert compute_parameters(made) == pytest.approx(
        {key: values[row] for key, values in drives.values.items()}, rel=1e-6
    )


def test_ranges_meet_what_is_drawn_and_follow_a_design_beyond_them(drives: Population) -> None:
    for one in drives.ranges:
        assert one.low < one.high
        for key, low in one.low_values.items():
            values = drives.deviations[f"drawn_{one.table}_{key}"]
            assert low <= values.min() < values.max() <= one.high_values[key]
    rough = draw_population(Reducer(unlike("few")).but(friction={"pin_gear": 0.3}), 2)
    teeth = next(one for one in rough.ranges if one.name == "friction of the teeth")
    # of lubricated steel 0.02 to 0.1
    assert math.sqrt(teeth.low_values["pin_gear"] * teeth.high_values["pin_gear"]) == pytest.approx(0.3)
    assert teeth.high_values["pin_gear"] / teeth.low_values["pin_gear"] == pytest.approx(5.0)
    assert any("no tolerances" in note for note in rough.notes)


def test_the_correlation_is_that_of_the_drives(drives: Population) -> None:
    found, keys = drives.correlation, list(drives.values)
    assert np.allclose(np.diag(found), 1.0)
    assert np.allclose(found, found.T)
    one, other = (stats.zscore(drives.values[key]) for key in (keys[0], keys[3]))
    assert found[0, 3] == pytest.approx(float(np.mean(one * other)))


def test_a_varied_joint_has_the_parameters_that_were_requested(few: ReducedJoint) -> None:
    """Play, slope and torque of friction by the joint's own methods, each moved alone by its factor."""
    same = dict.fromkeys(standalone.PARAMETERS, 1.0)
    assert few.varied(same).stops == pytest.approx(few.stops, rel=1e-14)
    assert replace(few.varied(same), stops=few.stops, friction=few.friction) == few
    rated, speed = few.rated_torque, few.rated_speed
    other = few.varied(dict(zip(standalone.PARAMETERS, (2.0, 3.0, 5.0, 0.5, 4.0), strict=True)))
    assert other.backlash == pytest.approx(2.0 * few.backlash)
    assert other.middle == pytest.approx(few.middle)
    for share in (0.1, 0.5, 1.0):
        assert other.wind_up(share * rated) == pytest.approx(few.wind_up(share * rated) / 3.0)
    assert other.no_load_torque == pytest.approx(5.0 * few.no_load_torque)
    for driving in (True, False):
        grown = few.friction.torque(rated, speed, driving) - few.no_load_torque
        assert other.friction.torque(rated, speed, driving) - other.no_load_torque == pytest.approx(0.5 * grown)
    assert other.ripple.errors(0.3, 1.0) == pytest.approx([4.0 * one for one in few.ripple.errors(0.3, 1.0)])


def test_joint_py_writes_a_drive_into_a_model(few: ReducedJoint, drives: Population, tmp_path: Path) -> None:
    """The model then is the one that is compiled of that drive's joint."""
    content = {
        **few.as_json(),
        "scene": {"timestep_s": 1e-3, "integrator": "discrete"},
        "spread": to_json_values(drives.as_json()),
    }
    (tmp_path / "reducer.json").write_text(json.dumps(content))
    joint = standalone.Joint(tmp_path / "reducer.json")
    row = {key: str(values[2]) for key, values in drives.values.items()}
    model = create_trial_scene(few, 0.1, 1e-3).model
    joint.varied(row).write(model)
    factors = {key: float(row[key]) / own if own else 1.0 for key, own in drives.nominal.items()}
    made = create_trial_scene(few.varied(factors), 0.1, 1e-3).model
    for name in ("tendon_lengthspring", "tendon_stiffness", "tendon_damping", "dof_frictionloss"):
        assert getattr(model, name) == pytest.approx(getattr(made, name), rel=1e-9), name
    del content["spread"]
    (tmp_path / "reducer.json").write_text(json.dumps(content))
    with pytest.raises(ValueError, match="--spread"):
        standalone.Joint(tmp_path / "reducer.json").varied(row)


@pytest.mark.slow
def test_reduce_writes_the_drives(tmp_path: Path) -> None:
    changes = [word for key, value in TOLERANCES.items() for word in ("--set", f'tolerance.{key}="{value}"')]
    words = ["reduce", str(design_file("few")), *changes, "--spread", "--samples", "6", "--seed", "3"]
    assert main([*words, "--out", str(tmp_path), "--quiet"]) == 0
    told = json.loads((tmp_path / "reducer.json").read_text())["spread"]
    rows = (tmp_path / "samples.csv").read_text().splitlines()
    assert len(rows) == 1 + told["samples"]
    assert set(told["parameters"]) == set(standalone.PARAMETERS) == set(told["correlation"]["parameters"])
    for one in told["parameters"].values():
        assert one["p05"] <= one["p50"] <= one["p95"]
    assert "Spread over manufactured drives" in (tmp_path / "reducer.html").read_text()


SLIPS = (Slip(0.3, 900.0), Slip(0.2, 90.0))
"""Friction that holds the wind-up of `few`, which is rated at a few N m."""


def test_slip_elements_reproduce_the_hysteresis_in_mujoco(few: ReducedJoint) -> None:
    """A slow loop at a held crank is that of the elements beside the springs: half of it to 1 in 1000 of its height.

    Where the output leaps across its play hardly anything pulls it on: near there it is to 5 %.
    """
    reduced = replace(few.at("backlash"), slips=SLIPS)
    assert ReducedJoint.from_json(reduced.as_json()).slips == SLIPS
    on = create_trial_scene(reduced, 0.1, 1e-3, "implicitfast")
    on.hold()
    on.model.dof_damping[on.addresses.output_speed] = 20.0
    most = reduced.rated_torque
    torque = most * np.concatenate([np.linspace(a, b, 30) for a, b in ((0.0, 1.0), (1.0, -1.0), (-1.0, 1.0))])
    turns = []
    for pulled in torque.tolist():
        on.push(pulled)
        for _ in range(150):
            on.step()
        turns.append(on.length)
    knots = np.array([1e-6, *(one.start for one in reduced.springs[1:]), 10.0 * reduced.wind_up(most)])
    carried = np.array([sum(one.stiffness * max(at - one.start, 0.0) for one in reduced.springs) for at in knots])
    low, high = reduced.stops
    curve = LockedCurve(np.concatenate([-carried[::-1], carried]), np.concatenate([low - knots[::-1], high + knots]))
    elements = SlipElements(*np.array([(one.limit, one.stiffness) for one in SLIPS]).T)
    expected = follow_locked_path(curve, elements, torque)
    still = np.abs(np.diff(expected, prepend=0.0)) < 0.1 * np.ptp(expected)
    assert np.mean(still) > 0.9
    left = np.abs(turns - expected)[still] / np.ptp(expected)
    assert np.median(left) < 1e-3
    assert left.max() < 0.05


def test_attached_and_included_are_one_model(few: ReducedJoint) -> None:
    """joint.xml and `attach_reducer` give the same joint, level by level."""
    bare = (
        "<mujoco><option timestep='0.001' integrator='discrete' gravity='0 0 0'/><worldbody><body pos='0 0 0.05'>"
        "<inertial pos='0 0 0' mass='1' diaginertia='0.1 0.1 0.1'/><joint name='output' axis='0 0 1'/>"
        "</body></worldbody><actuator><motor joint='output'/></actuator></mujoco>"
    )
    for level in LEVELS:
        reduced = replace(few.at(level), slips=SLIPS)
        spec = mujoco.MjSpec.from_string(bare)
        cm.attach_reducer(spec, "output", reduced)
        attached = spec.compile()
        included = mujoco.MjModel.from_xml_string(
            scene_xml(reduced, 0.1, 1e-3), {"joint.xml": joint_xml(reduced).encode()}
        )
        assert attached.nv == included.nv == (1 if level == "rigid" else 2 + len(SLIPS))
        for name in ("tendon_lengthspring", "tendon_stiffness", "tendon_damping", "tendon_stiffnesspoly"):
            assert getattr(attached, name) == pytest.approx(getattr(included, name), rel=1e-9), name
        for joint in ("output",) if level == "rigid" else ("output", "output_rotor", "output_slip_1", "output_slip_2"):
            dofs = [one.joint(joint).dofadr[0] for one in (attached, included)]
            for name in ("dof_armature", "dof_frictionloss", "dof_damping"):
                one, other = (getattr(m, name)[dof] for m, dof in zip((attached, included), dofs, strict=True))
                assert one == pytest.approx(other, rel=1e-9), name
        assert len(list(reduced.places(attached))) == len(list(reduced.places(included))) == 1


def test_the_rigid_joint_loses_what_the_load_takes(few: ReducedJoint) -> None:
    """At the level rigid `step` reads the load from the motor's balance: power out over power in is the efficiency."""
    reduced = few.at("rigid")
    on = create_trial_scene(reduced, 0.1, 1e-3)
    torque = reduced.rated_torque
    on.data.qvel[0] = reduced.way * reduced.rated_speed / reduced.ratio
    on.push(-reduced.way * torque)
    expected = reduced.friction.efficiency(torque, reduced.rated_speed, reduced.ratio, driving=True)
    on.data.ctrl[0] = torque / reduced.ratio / expected
    for _ in range(50):
        reduced.step(on.model, on.data)
        mujoco.mj_step(on.model, on.data)
    assert on.model.dof_frictionloss[0] == pytest.approx(torque * (1.0 / expected - 1.0), rel=0.02)
    assert abs(on.data.qvel[0]) == pytest.approx(reduced.rated_speed / reduced.ratio, rel=0.01)


@pytest.mark.parametrize(
    ("joint", "message"),
    [("knee", "no joint 'knee': choose one of shoulder, elbow"), ("out", "not a hinge"), ("elbow", "already has")],
)
def test_a_reducer_on_an_unsuitable_joint_is_refused(few: ReducedJoint, joint: str, message: str) -> None:
    spec = arm()
    cm.attach_reducer(spec, "elbow", few)
    with pytest.raises(UsageError, match=message):
        cm.attach_reducer(spec, joint, few)
    spec.compile()


def test_a_model_that_does_not_compile_is_reported(few: ReducedJoint) -> None:
    spec = mujoco.MjSpec.from_string("<mujoco><worldbody><body><joint name='j'/></body></worldbody></mujoco>")
    with pytest.raises(UsageError, match="cannot compile the robot's model"):
        cm.attach_reducer(spec, "j", few)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"ratio": "x"}, "does not describe a joint (ValueError: could not convert"),
        ({"ratio": -6.0}, "the value of joint.ratio must be finite and greater than 0, but is -6.0"),
        ({"damping": float("nan")}, "the value of joint.damping must be finite and greater than 0, but is nan"),
        ({"springs": []}, "the value of joint.springs must be a list of at least one spring, but is []"),
        ({"springs": [1]}, "does not describe a joint (TypeError"),
        ({"level": "soft"}, "the value of joint.level must be one of rigid, backlash, full, but is 'soft'"),
        ({"way": 0}, "the value of joint.way must be 1 (the output turns as the crank) or -1 (opposite), but is 0"),
        ({"friction": None}, "does not describe a joint (TypeError"),
        ({"ripple": {}}, "does not describe a joint (KeyError"),
        ({"more": 1}, "does not describe a joint (TypeError"),
    ],
    ids=str,
)
def test_a_spoiled_reducer_is_refused(few: ReducedJoint, change: dict, told: str, tmp_path: Path) -> None:
    given = few.as_json()
    ReducedJoint.from_json(given)
    given["joint"] = given["joint"] | change
    path = tmp_path / "reducer.json"
    path.write_text(json.dumps(given))
    with pytest.raises(UsageError) as refused:
        ReducedJoint.read(path)
    assert str(refused.value).startswith(str(path))
    assert told in str(refused.value)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"joint": {}}', '{"joint": {"name": "x", "springs": [1]}}'])
def test_a_file_that_is_not_a_reducer_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "reducer.json"
    path.write_text(text)
    with pytest.raises(CycloidError, match=r"reducer\.json"):
        ReducedJoint.read(path)
    with pytest.raises(CycloidError, match="cannot read"):
        ReducedJoint.read(tmp_path / "none.json")


def test_a_model_without_it_is_refused(few: ReducedJoint) -> None:
    """A step that serves no joint would be a joint without friction and ripple, and nobody told."""
    model = arm().compile()
    with pytest.raises(UsageError, match="no joint of the model has the reducer 'few'"):
        few.step(model, mujoco.MjData(model))


def test_a_reducer_serves_its_joints_at_any_level(few: ReducedJoint) -> None:
    assert len({few.at(level).fingerprint for level in LEVELS}) == 1
    assert 0 < few.fingerprint < 1_000_000


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        pytest.param({"output": {"member": "ring"}}, id="ring turns"),
        pytest.param({"gear": {"discs": 2}}, id="two discs"),
    ],
)
def test_either_member_and_several_discs(changes: dict) -> None:
    """The ring turns as the crank does, by one in N; two discs share the load, and both turn with the output."""
    design, plain = unlike("few").but(**changes), joint_of("few")
    reduced = cm.reduce(design)
    assert compare_with_full_model(Reducer(design), reduced).outside_bounds == []
    assert (reduced.ratio, reduced.way) == ((7.0, 1) if design.output.turns_ring else (6.0, -1))
    if design.output.turns_ring:
        # Willis: the same play and springs, seen from the ring, through (N - 1)/N
        assert reduced.backlash == pytest.approx(plain.backlash * 6.0 / 7.0, rel=2e-3)
        stiffness = [one.quantities["stiffness_nm_per_arcmin"].value for one in (reduced, plain)]
        assert stiffness[0] == pytest.approx(stiffness[1] * (7.0 / 6.0) ** 2, rel=0.02)
        on = create_trial_scene(reduced, 0.01, 1e-3)
        on.data.ctrl[0] = 0.1
        for _ in range(200):
            on.step()
        assert on.data.qpos[on.addresses.output_angle] * on.data.qpos[on.addresses.crank_angle] > 0.0
    else:
        assert reduced.output_inertia > plain.output_inertia
        assert reduced.wind_up(reduced.rated_torque) < 0.9 * plain.wind_up(plain.rated_torque)


def test_an_unknown_level_is_refused(few: ReducedJoint) -> None:
    with pytest.raises(UsageError, match="choose one of rigid, backlash, full"):
        few.at("soft")


def test_a_crank_at_rest_is_refused() -> None:
    with pytest.raises(DesignError, match=r"drive\.speed_rpm is 0"):
        identification.reduce(PRESETS["pin"].but(drive={"speed": 0.0}))


@pytest.mark.slow
def test_a_joint_whose_error_changes_with_the_load_by_more_than_it_winds_up_has_a_step() -> None:
    """The middle of its vibration is 21 % off its rest at any step: the error falls by nine wind-ups up to the load."""
    loose = joint_of("fixed-n31-d1-carrier-250um")
    chosen = choose_time_step(loose, loose.reflected_inertia)
    assert chosen.accurate
    assert abs(chosen.error) < 0.01
    assert not try_time_step(loose, "implicitfast", 1e-3, loose.reflected_inertia).good


@pytest.mark.parametrize(
    ("given", "advice"),
    [
        ((None, None), "; use a larger --load-inertia-kgm2"),
        ((5.0, None), "; leave out --timestep-ms, or use a larger --load-inertia-kgm2"),
        ((5.0, "discrete"), "; leave out --timestep-ms and --integrator, or use a larger --load-inertia-kgm2"),
    ],
)
def test_advice_names_only_the_flags_of_the_command_line(
    few: ReducedJoint, given: tuple[float | None, str | None], advice: str
) -> None:
    asked = try_time_step(few.at("backlash"), "implicitfast", 5e-3, few.reflected_inertia)
    (told,) = describe_inaccuracy(asked, *given)
    assert told.endswith(f"unstable{advice}")


def test_an_unstable_scene_is_reported(few: ReducedJoint) -> None:
    asked = try_time_step(few.at("backlash"), "implicitfast", 5e-3, few.reflected_inertia)
    assert not asked.stable
    assert asked.summary == "unstable"
    damped = try_time_step(few.at("backlash"), "discrete", 5e-3, few.reflected_inertia)
    assert damped.good
    assert not damped.accurate
    assert "rated load at 3 Hz" in damped.sentence
    chosen = choose_time_step(few.at("backlash"), few.reflected_inertia)
    assert chosen.accurate
    assert chosen.timestep <= 1e-3


@pytest.mark.parametrize(
    ("flags", "message", "code"),
    [
        (["--timestep-ms", "0"], "--timestep-ms", 2),
        (["--load-inertia-kgm2", "-1"], "--load-inertia-kgm2", 2),
        (["--load-inertia-kgm2", "nan"], "--load-inertia-kgm2", 2),
        (["--level", "soft"], "level", 2),
        (["--samples", "10"], "--samples applies only with --spread", 2),
        (["--seed", "0"], "--seed applies only with --spread", 2),
        (["--set", "drive.speed_rpm=0"], "drive.speed_rpm is 0", 1),
        (["--set", "clearance.output_um=-1"], "clearance.output_um", 2),
    ],
)
def test_wrong_flags_are_reported_in_one_line(
    flags: list[str], message: str, code: int, tmp_path: Path, capsys
) -> None:
    assert main(["reduce", "--design", "pin", "--out", str(tmp_path / "made"), *flags]) == code
    err = capsys.readouterr().err.strip()
    assert message in err
    assert "\n" not in err
    assert not list(tmp_path.glob("made/*"))


def test_a_folder_that_cannot_be_created_is_reported(tmp_path: Path, capsys) -> None:
    (tmp_path / "file").write_text("")
    assert main(["reduce", "--design", "pin", "--out", str(tmp_path / "file" / "made")]) == 1
    assert "Choose another folder with --out" in capsys.readouterr().err
