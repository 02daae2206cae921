"""RV reducers in MuJoCo: planet mesh, forces, wind-up, ratio and power balance against independent sources."""

import math
from pathlib import Path
from typing import Any

import build_models
import mujoco
import numpy as np
import pytest
from rv_runs import COULOMB_RV80E, FRICTIONLESS, static_loads

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import ContactError, DesignError
from cycloid_mj.base.powers import mean_powers
from cycloid_mj.base.record import Run
from cycloid_mj.dynamics.contact.crank_train import mesh_numbers, planet_flanks
from cycloid_mj.dynamics.contact.gap import Pose
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.mjcf.folder import model_files
from cycloid_mj.dynamics.mjcf.laws import laws_of_discs, stiffest
from cycloid_mj.dynamics.mjcf.mesh import build_mesh
from cycloid_mj.dynamics.mjcf.springs import add_springs
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.geometry.involute import InvoluteGear
from cycloid_mj.parts.convex import ConvexSettings
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.rv import compute_rv_springs, solve_rv_loads
from cycloid_mj.statics.sheet import sampled_efficiency, shaft_powers

MODELS = Path(__file__).parents[2] / "models"

HOLD, SETTLED = 0.02, 0.012
"""Duration of the runs, and time after which they are evaluated [s]."""


def rv(load: float, **changes: Any) -> RvReducer:
    """An RV-80E with pressed-in pins, which cost little, at full speed under a load [N m]."""
    design = COULOMB_RV80E.but(
        ring={"pins": "fixed"}, drive={"ramp": 0.0, "hold": HOLD}, load={"torque": load, "rise": 0.004}
    )
    return RvReducer(design.but(**changes))


def settled(reducer: RvReducer) -> Run:
    run = simulate(reducer.design, build(reducer.design))
    return run.select(run.time > SETTLED)


def sizes(run: Run, kind: str) -> Array:
    return np.linalg.norm(run.forces(kind)[:, :, :2], axis=2)


@pytest.mark.parametrize(
    "changes",
    [
        pytest.param({}, id="preset"),
        pytest.param({"output": {"member": "ring"}}, id="ring", marks=pytest.mark.slow),
        pytest.param({"cranks": {"needle_clearance": 5e-6}}, id="clearance", marks=pytest.mark.slow),
        pytest.param({"cranks": {"needle_clearance": -6e-5}}, id="preload", marks=pytest.mark.slow),
        pytest.param({"cranks": {"count": 2}}, id="two-cranks", marks=pytest.mark.slow),
        pytest.param(
            {"planet": {"friction": 0.0, "sun_support": "fixed", "backlash": 2e-5}},
            id="fixed-sun",
            marks=pytest.mark.slow,
        ),
        pytest.param({"settings": {"timestep": 5e-6}}, id="half-step", marks=pytest.mark.slow),
        pytest.param({"friction": {}, "planet": {}}, id="friction", marks=pytest.mark.slow),
    ],
)
def test_forces_and_wind_up_are_those_of_statics(changes: dict[str, Any]) -> None:
    reducer = rv(784.0, **(FRICTIONLESS | changes))
    run = settled(reducer)
    static = static_loads(reducer, run)
    sense = -reducer.share if reducer.design.output.turns_ring else 1.0
    error = run["output_angle"] - reducer.member.output_angle(run["sun_angle"])
    np.testing.assert_allclose(error, sense * static.carrier_turn, rtol=1e-3)
    bearings = static.bearings.reshape(len(run), -1)
    np.testing.assert_allclose(sizes(run, "crank_bearing"), bearings, atol=5e-3 * bearings.max())
    assert sizes(run, "pin_gear").max() == pytest.approx(static.pins.max(), rel=5e-3)
    # a run logs the resultant of both flanks, whose lines of action cross at twice the pressure angle
    # with friction, the contact of a planet stays on one side of the pitch point
    front, back = static.flanks[:, 0], static.flanks[:, 1]
    both = np.sqrt(front**2 + back**2 - 2.0 * front * back * math.cos(2.0 * reducer.planet.pressure_angle))
    assert sizes(run, "planet_mesh").mean() == pytest.approx(both.mean(), rel=0.02)


@pytest.mark.parametrize("load", [pytest.param(78.4, marks=pytest.mark.slow), 784.0])
def test_powers_balance_and_losses_follow_from_the_forces(load: float) -> None:
    reducer = rv(load, planet={"backlash": 2e-5})
    run = settled(reducer)
    turned = [np.ptp(run[name]) for name in ("sun_angle", "output_angle")]
    assert turned[0] / turned[1] == pytest.approx(153.0, rel=1e-5)
    supplied = np.mean(run["sun_torque"] * run["sun_speed"])
    delivered = -np.mean(run["load_torque"] * run["output_speed"])
    kinds = ("pin_gear", "crank_bearing", "planet_mesh")
    friction = {kind: np.mean(run[f"{kind}_friction_power"]) for kind in kinds}
    normal = sum(np.mean(run[f"{kind}_normal_power"]) for kind in kinds)
    stored = np.ptp(run["kinetic_energy"][[0, -1]]) / np.ptp(run.time)
    assert supplied - delivered - sum(friction.values()) - normal == pytest.approx(0.0, abs=1e-5 * supplied + stored)
    forces = {kind: sizes(run, kind).sum(axis=1).mean() for kind in kinds}
    rolling = abs(reducer.crank_speed) * reducer.cranks.eccentric_radius
    assert friction["crank_bearing"] == pytest.approx(
        0.004 * forces["crank_bearing"] * rolling, rel=2e-3
    )  # the contact yields by 0.3 % of the radius
    mesh_speed = abs(reducer.crank_speed) * (1.0 + 38.0 / 10.0) * reducer.planet_mesh.arm
    assert friction["planet_mesh"] == pytest.approx(0.05 * forces["planet_mesh"] * mesh_speed, rel=0.01)
    assert 100.0 * shaft_powers(reducer, load).efficiency == pytest.approx(100.0 * delivered / supplied, abs=0.1)


def test_efficiency_with_film_friction_is_that_of_statics() -> None:
    reducer = rv(784.0, friction={"law": "film"})
    powers = mean_powers(settled(reducer))
    assert 100.0 * powers.efficiency == pytest.approx(sampled_efficiency(reducer, 784.0, 16).value, abs=0.2)


def flank_gap(sun: InvoluteGear, planet: InvoluteGear, poses: tuple[Pose, Pose], side: float) -> float:
    """Smallest gap of facing flanks of two gears along the common normal, by the points of their involutes [m]."""
    roll = np.linspace(0.05, 0.9, 20001)
    best = np.inf
    u = np.array([poses[1].x - poses[0].x, poses[1].y - poses[0].y])
    base = sun.base_radius + planet.base_radius
    alpha = np.arccos(base / np.linalg.norm(u))
    gamma = np.arctan2(u[1], u[0])
    normal = np.array([np.cos(gamma + side * (np.pi / 2 - alpha)), np.sin(gamma + side * (np.pi / 2 - alpha))])
    lines = []
    for gear, pose, mirror in ((sun, poses[0], side), (planet, poses[1], side)):
        # the flanks cross the line of action, at which their normals lie along it
        flank = gear.flank(roll) * np.array([mirror, 1.0])
        angles = np.arctan2(pose.sine, pose.cosine) + 2.0 * np.pi * np.arange(gear.teeth) / gear.teeth
        crossing = []
        tangent = gear.flank_tangents(roll) * np.array([mirror, 1.0])
        for angle in angles:
            cos, sin = np.cos(angle), np.sin(angle)
            turn = np.array([[cos, sin], [-sin, cos]])
            along = (tangent @ turn) @ normal
            k = int(np.argmin(np.abs(along)))
            if abs(along[k]) < 1e-3:
                crossing.append(float((np.array([pose.x, pose.y]) + (flank @ turn)[k]) @ normal))
        lines.append(crossing)
    for first in lines[0]:
        for second in lines[1]:
            if abs(second - first) < abs(best):
                best = second - first
    return best


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_planet_flanks_are_those_of_the_drawn_teeth(side: float) -> None:
    """Distance along the line of action of the involutes of sun and planet, as drawn, at displaced poses."""
    reducer = rv(784.0, planet={"backlash": 1e-4})
    sun, planet = reducer.stage_gears
    rng = np.random.default_rng(3)
    for number, (x, y) in enumerate(reducer.stage.crank_positions([0.0])[0]):
        dx, dy, dpx, dpy = rng.normal(0.0, 1e-5, 4)
        turn = 0.31 * number + 0.1
        sun_turn, planet_turn = turn + 1e-4, -turn * 10 / 38
        poses = (
            Pose(dx, dy, np.cos(sun_turn), np.sin(sun_turn)),
            Pose(x + dpx, y + dpy, np.cos(planet_turn), np.sin(planet_turn)),
        )
        flanks = planet_flanks(mesh_numbers(reducer.planet_mesh, number), *poses)
        first_tooth = np.pi - np.pi / 38
        drawn = Pose(poses[1].x, poses[1].y, np.cos(planet_turn + first_tooth), np.sin(planet_turn + first_tooth))
        gap = flanks.gap if side > 0 else flanks.opposite
        assert gap == pytest.approx(flank_gap(sun, planet, (poses[0], drawn), side), abs=2e-7)


def require_stock_run(model: Any, data: Any, steps: int) -> None:
    """Turn a stock model from its keyframe at full speed under a load that rises to 784 N m in a third of the steps."""
    mujoco.mj_resetDataKeyframe(model, data, model.key("2295rpm_0").id)
    for step in range(steps):
        data.ctrl[1] = -784.0 * 0.5 * (1.0 - math.cos(math.pi * min(1.0, 3.0 * step / steps)))
        mujoco.mj_step(model, data)
    assert not data.warning.number.any()


def test_stock_model_has_the_springs_of_bearings_and_planet_meshes() -> None:
    """Ideal motion keeps all tendons at their free lengths and the teeth free of contact; a load stretches them."""
    reducer = RvReducer(COULOMB_RV80E.but(ring={"pins": "fixed"}, clearance={"pin_gear": 5e-5}))
    files = model_files(reducer.but(settings={"timestep": 5e-6}), ConvexSettings(chord_error=1e-5))
    model = mujoco.MjModel.from_xml_string(
        files["reducer.xml"].decode(), {Path(name).name: content for name, content in files.items()}
    )
    data = mujoco.MjData(model)
    for key in range(model.nkey):
        mujoco.mj_resetDataKeyframe(model, data, key)
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(data.ten_length, 0.0, atol=1e-9)
        assert data.ncon == 0
    data.joint("crank_1_angle").qpos[0] += 1e-3
    mujoco.mj_forward(model, data)
    assert data.ten_length[model.tendon("gear_1_crank_1").id] == pytest.approx(1.5e-6, rel=1e-3)
    assert data.ten_length[model.tendon("planet_1").id] == pytest.approx(1e-3 * reducer.planet_mesh.planet_base)
    moment = data.joint("crank_1_angle").qfrc_passive[0]
    stiffness = reducer.mesh_stiffness * reducer.planet_mesh.planet_base**2 + 2.0 * 1e8 * 1.5e-3**2
    assert moment == pytest.approx(-1e-3 * stiffness, rel=1e-3)


def test_springs_too_stiff_for_the_step_are_refused() -> None:
    reducer = rv(784.0, drive={"rotor_inertia": 0.0}).for_slices
    spec = mujoco.MjSpec()
    spec.option.timestep = 1e-5
    with pytest.raises(ContactError, match=r"planet_mesh: with MuJoCo's own springs .* reduce settings.timestep_us to"):
        add_springs(spec, reducer, stiffest(laws_of_discs(reducer)))


def test_runs_with_mesh_contact_are_refused() -> None:
    with pytest.raises(DesignError, match="--contact mesh does not support RV reducers"):
        build_mesh(rv(784.0))


@pytest.mark.slow
def test_the_committed_model_comes_out_again_and_winds_up_as_statics() -> None:
    folder = MODELS / "rv80e"
    made = build_models.rv_files()
    for name, content in made.items():
        assert (folder / name).read_bytes() == content, name
    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    data = mujoco.MjData(model)
    require_stock_run(model, data, 900)
    sun, output = data.sensor("sun_angle").data[0], data.sensor("output_angle").data[0]
    reducer = RvReducer(build_models.rv_design())
    static = solve_rv_loads(compute_rv_springs(reducer, reducer.member.against_ring(sun)), -784.0)
    assert output - sun / 153.0 == pytest.approx(static.carrier_turn[0], rel=0.02)
