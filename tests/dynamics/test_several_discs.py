"""Two and more discs in motion: contact by profiles and by meshes, logs, figures, pictures, files of each disc."""

import io
import math
import re
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import trimesh
from designs import cases
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from scipy.spatial import cKDTree

from cycloid_mj.analysis import analyze, series
from cycloid_mj.analysis.series import design_of
from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.record import Run
from cycloid_mj.base.units import ARCSECONDS
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.drive_cycle import initial_state, load_torque, servo_target
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.mjcf.mesh import build_mesh, mesh_spec
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.geometry.kinematics import CrankLaw
from cycloid_mj.measure.closed_form import ideal_limit
from cycloid_mj.measure.reaction import bearing_reactions, unbalance
from cycloid_mj.parts import gear_solid, mass_properties
from cycloid_mj.parts.convex import ConvexSettings, decompose, sectors
from cycloid_mj.parts.polygon import area_moments
from cycloid_mj.parts.shaft import bearing_seats
from cycloid_mj.plots import figures
from cycloid_mj.plots.animation import draw_frames, select_samples
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import AXIAL_GAP
from cycloid_mj.reducer.bodies import phases
from cycloid_mj.report import report
from cycloid_mj.scene import contact_forces, poses
from cycloid_mj.scene.drawing import measure_gaps
from cycloid_mj.scene.force import arrow_heights
from cycloid_mj.scene.glb import encode_glb
from cycloid_mj.scene.messages import Scene
from cycloid_mj.scene.shape import shapes
from cycloid_mj.statics.balance import loads as static_loads
from cycloid_mj.statics.shoulder import root_arms
from cycloid_mj.statics.springs import springs_of
from cycloid_mj.statics.structure import wind_up
from cycloid_mj.stress.grid import GridSettings
from cycloid_mj.stress.loads import part_loads
from cycloid_mj.stress.part import part_grid

MODELS = Path(__file__).parents[2] / "models"

CASE_K = [
    *("ring.teeth=30", "ring.pin_circle_radius_mm=52.5", "ring.pin_radius_mm=3.5", "ring.pins=fixed"),
    *("gear.discs=2", "gear.disc_gap_mm=3", "gear.face_width_mm=13.5", "gear.eccentricity_mm=1.250025"),
    *("gear.bore_radius_mm=20", "shaft.radius_mm=12", "housing.outer_radius_mm=65"),
    *("output.pins=4", "output.pin_radius_mm=6", "output.pin_circle_radius_mm=34", "output.hole_radius_mm=7.250025"),
    *("drive.speed_rpm=100", "drive.ramp_s=0", "load.torque_nm=116", "load.rise_s=0.002"),
    *("settings.timestep_us=5", "settings.log_rate_hz=5000"),
]
"""Its ring, discs and output (29:1, 58 N m a disc) on a crank of our own, with pressed-in pins, which cost little."""


FRICTIONLESS = [
    "friction.law=coulomb",
    *(f"friction.{kind}=0" for kind in ("pin_gear", "cam", "cam_rolling", "output", "output_rolling")),
]


def case_k(*changes: str) -> Design:
    return override(PRESETS["pin"], [*CASE_K, *changes])


def stems(model: Any) -> list[str]:
    return [model.geom(i).name.split("/")[0] for i in range(model.ngeom)]


UNLIKE = ("errors.disc_dr_um=[0.3,1]", "errors.cam_x_um=[0,0.5]")


def test_meshes_of_unlike_discs_carry_their_own_teeth() -> None:
    made = mesh_spec(Reducer(case_k(*UNLIKE)), ConvexSettings(chord_error=1e-6))
    first, second = (
        {geom.meshname for geom in made.spec.body(gear).geoms if "teeth/" in geom.name} for gear in ("gear_1", "gear_2")
    )
    assert {name.rpartition("_")[0] for name in first} == {"teeth"}
    assert {name.rpartition("_")[0] for name in second} == {"gear_2_teeth"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("errors", "agreement"),
    # chords leave the profile by 0.4 um to either side, which counts beside discs that differ by 0.7 um
    [pytest.param((), 0.05, id="alike"), pytest.param(UNLIKE, 0.06, id="unlike", marks=pytest.mark.slow)],
)
def test_meshes_of_two_discs_touch_their_mates_with_the_forces_of_profiles(
    errors: tuple[str, ...], agreement: float
) -> None:
    """No cap of a cam reaches the next disc's bore; forces of every disc agree with those of profile contact."""
    design = case_k("drive.hold_s=0.003", "load.rise_s=0.001", *errors)
    mesh = build_mesh(Reducer(design), ConvexSettings(chord_error=4e-7))
    data, surfaces, met = mujoco.MjData(mesh.model), stems(mesh.model), Counter[frozenset[str]]()
    data.qvel[:] = initial_state(mesh, Reducer(design)).qvel
    law = CrankLaw(design.drive.speed, 0.0)
    for step in range(150):
        now = np.array([step * mesh.model.opt.timestep])
        data.ctrl[0], data.ctrl[1] = servo_target(mesh, law, now)[0], load_torque(Reducer(design), now)[0]
        mujoco.mj_step(mesh.model, data)
        met.update(frozenset(surfaces[geom] for geom in data.contact[i].geom) for i in range(data.ncon))
    mating = {frozenset((pair.on, pair.by)): pair.name for pair in mesh.pairs}
    assert set(met) <= set(mating)
    assert {names.kind_of(mating[pair]) for pair in met} == {"pin_gear", "cam", "output"}
    assert {names.disc_of(mating[pair]) for pair in met} == {0, 1}
    runs = [simulate(design, compiled) for compiled in (mesh, build(design))]
    for kind in ("cam", "output"):
        sliced, exact = (np.linalg.norm(run.forces(kind)[-8:], axis=2).max(axis=0) for run in runs)
        pressed = exact > 100.0
        np.testing.assert_allclose(sliced[pressed], exact[pressed], rtol=agreement)


@pytest.fixture(scope="module")
def run() -> Run:
    """A little more than a turn of the crank, without friction."""
    stiff = [f"clearance.{kind}_um=0.1" for kind in ("pin_gear", "cam", "output")]
    turn = ["drive.speed_rpm=600", "drive.hold_s=0.12", "load.rise_s=0.01", "settings.timestep_us=10"]
    return simulate(case_k(*FRICTIONLESS, *stiff, *turn, "settings.log_rate_hz=4000"))


def test_a_log_has_columns_of_each_disc_and_figures_of_each(run: Run) -> None:
    for disc in (1, 2):
        assert set(names.planar_joints(f"gear_{disc}")) < set(run.columns)
        assert {f"gear_{disc}_cam_moment", f"gear_{disc}_pin_30_force_x", f"gear_{disc}_output_pin_4_peak_force"} < set(
            run.columns
        )
    found = analyze(run)
    assert [disc.name for disc in found.discs] == ["gear_1", "gear_2"]
    assert found.discs[0].speed == found.gear_speed
    for disc in found.discs:
        assert disc.speed.mean_rad_s == pytest.approx(-run["crank_speed"].mean() / 29.0, rel=1e-3)
        assert disc.q_path.max_error_um < 15.0
    assert found.efficiency == pytest.approx(1.0, abs=0.002)


def test_figures_over_time_state_which_disc_they_are_of(run: Run) -> None:
    page = report({"runs/two.mcap": run})
    for told in (
        "below show gear 1 of 2",
        "gear 1 of 2: transmission error, peak to peak",
        "gear 2 speed, mean",
    ):
        assert told in page
    assert "<td>(0, 34) mm of gear 1 of 2" in page
    for figure in figures(series(run)).values():
        assert figure.get_suptitle().endswith("; gear and q: gear 1 of 2")
    assert figures(series(run).of_disc(1))["fig6_gear_speed"].get_suptitle().endswith("gear 2 of 2")


def test_the_second_disc_repeats_the_first_half_a_turn_later(run: Run) -> None:
    """Its forces are those of the first, half a turn round: 30 ring teeth and 4 output pins are even numbers."""
    design, half = design_of(run), np.pi
    settled = run.select(run.time > 0.02)
    for kind, count in ((design.tooth_pair, 30), ("output", 4), ("cam", 1)):
        forces = settled.forces(kind).reshape(len(settled), 2, count, 2)
        first, second = forces[:, 0], np.roll(forces[:, 1], -count // 2 if count > 1 else 0, axis=1)
        np.testing.assert_allclose(-second, first, atol=0.02 * np.abs(first).max())
    motion = series(run)
    assert half == phases(design)[1]
    for disc in (0, 1):
        assert np.abs(motion.of_disc(disc).q_position.error).max() < 20e-6


def test_a_disc_is_drawn_at_its_position(run: Run) -> None:
    """Arrows of each disc act on that disc: their points lie in it, on its pins, and on its cam."""
    design = design_of(run)
    columns = {name: values[300:303] for name, values in run.columns.items()}
    place, acting = poses(Reducer(design), columns), contact_forces(Reducer(design), columns)
    mass = np.zeros((3, 2, 2))
    for row, (kind, disc) in enumerate(zip(acting.kinds, acting.discs, strict=True)):
        away = acting.point[:, row] - place[f"gear_{disc + 1}"][:, :2]
        if kind == "cam":
            np.testing.assert_allclose(np.linalg.norm(away, axis=1), design.gear.bore_radius, rtol=1e-4)
        mass[:, disc] += acting.force[:, row]
    np.testing.assert_allclose(mass, 0.0, atol=0.05 * acting.size.max())
    for disc in (0, 1):
        measured = measure_gaps(Reducer(design), columns, disc)
        assert np.abs(measured.deviation[:, :2]).max() < 20e-6
        touching = acting.of_disc(disc).of("pin_gear").size > 50.0
        assert touching.any()
        opened = measured.opening - design.ring.pin_radius + design.clearance.pin_gear
        assert np.abs(measured.opening[touching]).max() < 4e-6
        assert opened.shape == (3, 30)


@pytest.mark.slow
@pytest.mark.parametrize("kind", cases(["pin", "nonpin"], "pin"))
def test_contacts_lie_on_the_part_that_they_press_on(kind: str) -> None:
    """Where each disc is touched is on its own outline, its bore and its holes; actions and reactions are the same."""
    changes = ["gear.discs=3", "drive.speed_rpm=3000", "drive.ramp_s=0", "drive.hold_s=0.028", "load.torque_nm=60"]
    pins = ["ring.pins=fixed"] if kind == "pin" else []
    stiff = [
        "settings.timestep_us=5",
        "settings.log_rate_hz=5000",
        "load.rise_s=0.001",
        "contact.max_penetration_um=50",
    ]
    design = override(PRESETS[kind], [*changes, *stiff, *pins])
    run, few = simulate(design), np.radians(np.arange(0.0, 360.0, 30.0))
    on_gears = [part_loads(run, Reducer(design), gear, few) for gear in ("gear_1", "gear_2", "gear_3")]
    for disc, loads in enumerate(on_gears):
        (prism,) = gear_solid(Reducer(design), 1e-7, disc).prisms
        near = cKDTree(np.concatenate([prism.outline, *prism.holes]))
        pressed = np.linalg.norm(loads.force, axis=2) > 5.0
        away, _ = near.query(loads.position[pressed])
        assert away.max() < 1e-4
        assert {names.disc_of(label) for label in loads.labels} == {disc}
    shaft = part_loads(run, Reducer(design), "shaft", few)
    assert shaft.labels == ("gear_1_cam", "gear_2_cam", "gear_3_cam")
    for disc, loads in enumerate(on_gears):
        cam = loads.labels.index(shaft.labels[disc])
        sizes = [np.linalg.norm(one, axis=1) for one in (shaft.force[:, disc], loads.force[:, cam])]
        np.testing.assert_allclose(*sizes, rtol=1e-12)


def test_forces_on_output_and_shaft_act_in_the_planes_of_their_discs() -> None:
    pytest.importorskip("skfem")
    design = case_k("output.support=both_ends")
    grid = part_grid(design, "output", GridSettings(refinement=0.35, solid=True))
    assert grid.section is not None
    for lift, plane in zip(grid.section.distributions, design.gear.disc_planes, strict=True):
        force = (lift @ np.ones(lift.shape[1])).reshape(-1, 3)[:, 0]
        assert force @ grid.points[:, 2] / force.sum() == pytest.approx(plane, abs=1e-12)
        pressed = grid.points[force != 0.0, 2]
        np.testing.assert_allclose([pressed.min(), pressed.max()], [plane - 6.75e-3, plane + 6.75e-3], atol=1e-12)
    assert grid.points[:, 2].min() == pytest.approx(-0.015 - 1e-3 - design.output.disc_thickness, abs=1e-12)


def shares(run: Run) -> Array:
    """Share of each disc in the torque on the output, shape (n, D)."""
    torque = []
    for gear in names.gears(design_of(run).gear.discs):
        pins = [f"{gear}_output_pin_{number}" for number in range(1, design_of(run).output.pins + 1)]
        moments = [run[f"{pin}_moment"] for pin in pins]
        levers = [run[f"{gear}_x"] * run[f"{pin}_force_y"] - run[f"{gear}_y"] * run[f"{pin}_force_x"] for pin in pins]
        torque.append(np.sum([*moments, *levers], axis=0))
    return np.stack(torque, axis=1) / np.sum(torque, axis=0)[:, np.newaxis]


@pytest.mark.parametrize("changes", [("output.support=cantilever",), ("errors.disc_dr_um={2=1.0}",)])
def test_a_slow_run_shares_the_load_as_statics_does(changes: tuple[str, ...]) -> None:
    """Pins that bend, or a disc that is larger, put unequal loads on two discs: statics has them by another way."""
    slow = ["drive.speed_rpm=300", "drive.ramp_s=0", "drive.hold_s=0.05", "load.rise_s=0.01", "load.torque_nm=116"]
    logged = ["settings.timestep_us=10", "settings.log_rate_hz=2000"]
    design = override(PRESETS["twodisc"], [*FRICTIONLESS, *slow, *logged, *changes])
    run = simulate(design)
    assert not run.warnings
    settled = run.select(run.time > 0.034)
    found = static_loads(
        Reducer(design), springs_of(Reducer(design), settled["crank_angle"], friction=False), 116.0, warm_start=True
    )
    assert abs(found.share[:, 0] - 0.5).min() > 0.04
    np.testing.assert_allclose(shares(settled), found.share, atol=5e-4)
    turn = settled["output_angle"] + settled["crank_angle"] / design.lobes
    np.testing.assert_allclose(turn, found.output_turn - wind_up(Reducer(design)) * 116.0, atol=1e-3 * turn.mean())


def test_output_pins_bent_by_several_discs_have_a_warning() -> None:
    slender = ["output.support=cantilever", "output.rollers=true"]
    (told,) = build(override(PRESETS["twodisc"], [*slender, "load.torque_nm=116"])).warnings
    assert "output pins bend: when disc 2 carries" in told
    rigid = override(PRESETS["twodisc"], [*slender, "structure=rigid"])
    assert not any("bend" in told for told in build(rigid).warnings)


@pytest.mark.parametrize("core", [3.0, 4.0])
def test_the_warning_states_how_much_the_coupling_of_bent_pins_moves(core: float) -> None:
    """Statics with the whole flexibility of the pins against statics whose discs do not know of each other."""
    slender = ["output.support=cantilever", "output.rollers=true", f"output.core_radius_mm={core}"]
    design = override(PRESETS["twodisc"], [*slender, "load.torque_nm=116"])
    springs = springs_of(Reducer(design), np.linspace(0.0, 2.0, 20), friction=False)
    alone = springs.contacts._replace(bending=np.diag(springs.contacts.bending.diagonal()))
    whole, apart = (
        static_loads(Reducer(design), one, 116.0).share for one in (springs, replace(springs, contacts=alone))
    )
    moved = 0.01 * float(re.search(r"up to ([\d.]+)%", " ".join(build(design).warnings))[1])
    assert 0.6 * moved < np.abs(whole - apart).max() < 1.1 * moved


def test_discs_balance_each_other_but_for_couples(run: Run) -> None:
    """Gears and crank have no static unbalance; of the couple what the closed form has: m c times the spacing."""
    design = design_of(run)
    found, gear = unbalance(Reducer(design)), mass_properties(gear_solid(Reducer(design))).mass
    cam = math.pi * 0.02**2 * 13.5e-3 * design.material.density
    assert found.bare < 1e-12
    assert found.couple == pytest.approx((gear + cam) * 1.250025e-3 * 16.5e-3, rel=1e-5)


def test_tilting_moments_are_the_forces_times_their_distance(run: Run) -> None:
    """The cams of two discs pull the shaft to opposite sides; two bearings hold the couple, and no force is left."""
    design, settled = design_of(run), run.select(run.time > 0.02)
    found, cams = bearing_reactions(settled, Reducer(design)), settled.forces("cam")
    size = np.linalg.norm(cams, axis=2).mean(axis=1)
    np.testing.assert_allclose(np.linalg.norm(found.shaft.moment, axis=1), 16.5e-3 * size, rtol=0.01)
    np.testing.assert_allclose(found.shaft.net, 0.0, atol=0.02 * size.max())
    np.testing.assert_allclose(found.shaft_far + found.shaft_near, -found.shaft.net, atol=1e-9)
    far, near = (0.5 * sum(seat) for seat in bearing_seats(Reducer(design)))
    held = far * found.shaft_far + near * found.shaft_near
    np.testing.assert_allclose(held[:, 0], -found.shaft.moment[:, 1], atol=1e-9)
    np.testing.assert_allclose(held[:, 1], found.shaft.moment[:, 0], atol=1e-9)


def test_a_pin_clamped_at_both_ends_has_the_moments_of_a_beam() -> None:
    """Its near root bears F a b^2/l^2: with the force in the middle F l/8."""
    one = case_k("gear.discs=1", "output.support=both_ends")
    length = 13.5e-3 + 2.0 * AXIAL_GAP
    np.testing.assert_allclose(root_arms(Reducer(one)), [[length / 8.0], [length / 8.0]], rtol=1e-12)
    cantilever = root_arms(Reducer(case_k()))
    np.testing.assert_allclose(cantilever, [[15e-3 + AXIAL_GAP + 8.25e-3, 15e-3 + AXIAL_GAP - 8.25e-3]], rtol=1e-12)


def test_viewers_get_every_disc_in_its_plane(run: Run) -> None:
    design = design_of(run)
    heights = {}
    for gear in ("gear_1", "gear_2"):
        (piece,) = shapes(Reducer(design))[gear]
        heights[gear] = [piece.mesh.vertices[:, 2].min(), piece.mesh.vertices[:, 2].max()]
        # a GLB has y up
        assert np.ptp(trimesh.load(io.BytesIO(encode_glb([piece])), file_type="glb").bounds, axis=0).min() > 13e-3
    np.testing.assert_allclose(heights["gear_1"], [-15e-3, -1.5e-3], atol=1e-8)
    np.testing.assert_allclose(heights["gear_2"], [1.5e-3, 15e-3], atol=1e-8)
    assert [piece.name for piece in shapes(Reducer(design))["shaft"]] == ["shaft", "cam_1", "cam_2", "spacer_1"]
    first, second = arrow_heights(Reducer(design))
    assert first < -15e-3
    assert second > 15e-3
    messages = list(Scene(design).frames(run.time[:2], {name: values[:2] for name, values in run.columns.items()}))
    frames = FrameTransforms.FromString(messages[0][2])
    assert {"gear_1", "gear_2", "shaft", "output", "housing"} <= {one.child_frame_id for one in frames.transforms}


def test_an_animation_follows_the_disc_that_is_requested(run: Run) -> None:
    first, second = (next(draw_frames(select_samples(run, frames=1, disc=disc), 320)) for disc in (0, 1))
    assert first.shape == second.shape
    assert np.any(first != second)
    with pytest.raises(UsageError, match="no disc 3: choose a disc from 1 to 2"):
        select_samples(run, disc=2)


def test_the_committed_model_of_two_discs_runs_in_stock_mujoco() -> None:
    """It opens without this package, has both discs with their cams and spacer, and turns them alike."""
    model = mujoco.MjModel.from_xml_path(str(MODELS / "twodisc" / "scene.xml"))
    assert {"cam_1", "cam_2", "spacer", "gear_1", "gear_2"} <= {model.mesh(i).name for i in range(model.nmesh)}
    assert model.body("gear_2").pos[2] - model.body("gear_1").pos[2] == pytest.approx(16.5e-3, rel=1e-9)
    assert sum(model.body(part).mass[0] for part in ("shaft", "gear_1", "gear_2", "output")) > 1.0
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("600rpm_0").id)
    assert data.ncon == 0
    speeds = []
    for _ in range(200):
        mujoco.mj_step(model, data)
        speeds.append([data.sensor(f"gear_{disc}_speed").data[0] for disc in (1, 2)])
    assert not any(warning.number for warning in data.warning)
    np.testing.assert_allclose(np.mean(speeds, axis=0), -20.0 * np.pi / 29.0, rtol=0.05)


def test_a_ring_of_a_second_output_disc_is_cut_in_wedges() -> None:
    """Its wide eye is round: all wedges are the ring, and the convex pieces of one stay within its bound."""
    found = [one for one in sectors(Reducer(PRESETS["twodisc"]), ConvexSettings()) if one.part == "output"]
    disc, wedge = found
    assert disc.count == 1
    area = wedge.count * area_moments(wedge.region.outline).area
    rim, eye = 34e-3 + 9e-3, 19e-3 + 1.250025e-3
    assert area == pytest.approx(np.pi * (rim**2 - eye**2), rel=1e-3)
    pieces = decompose(wedge, ConvexSettings())
    assert pieces.quality.max_overfill < wedge.bound
    assert wedge.region.z1 < -15e-3


def mesh_orders(teeth: int, discs: int) -> dict[int, float]:
    """Amplitude of the discs' mean transmission error [arcsec] at the first mesh orders, over a turn of the crank."""
    slow = ["drive.speed_rpm=400", "drive.hold_s=0.18", "load.rise_s=0.01", "settings.timestep_us=10"]
    drive = [f"ring.teeth={teeth}", f"gear.discs={discs}", f"load.torque_nm={58 * discs}"]
    run = simulate(case_k(*FRICTIONLESS, *slow, *drive))
    turn = run.select(slice(len(run) - 750, None))
    angles = np.mean([turn[f"{gear}_angle"] for gear in names.gears(discs)], axis=0)
    error = ARCSECONDS * (angles + turn["crank_angle"] / (teeth - 1))
    return {k: 2.0 * float(abs(np.mean(error * np.exp(-1j * k * teeth * turn["crank_angle"])))) for k in (1, 2)}


@pytest.mark.slow
def test_two_discs_cancel_odd_mesh_orders_of_odd_rings_only() -> None:
    """Equal spacing takes the crank orders k N that the number of discs does not divide; an even N gains nothing."""
    even, odd = ([mesh_orders(teeth, discs) for discs in (1, 2)] for teeth in (30, 31))
    assert even[1] == pytest.approx(even[0], rel=0.05)
    assert odd[1][1] < 0.2 * odd[0][1]
    assert odd[1][2] == pytest.approx(odd[0][2], rel=0.05)


@pytest.mark.slow
def test_a_slow_run_of_ideal_contacts_has_the_forces_of_the_worked_calculation() -> None:
    """Next to no clearance, no friction, a cam that holds: 213.1 N, 1706 N and 1967 to 2460 N within 2 %."""
    slow = ["drive.speed_rpm=120", "drive.ramp_s=0", "drive.hold_s=0.17", "load.torque_nm=116", "load.rise_s=0.02"]
    weightless = ["structure=rigid", "settings.log_rate_hz=2000", "environment.gravity_y_m_s2=0"]
    run = simulate(ideal_limit(Reducer(override(PRESETS["twodisc"], [*FRICTIONLESS, *slow, *weightless]))).design)
    settled = run.select(run.time > 0.04)
    ring, output, cam = (np.linalg.norm(settled.forces(kind), axis=2) for kind in ("pin_gear", "output", "cam"))
    assert ring.max() == pytest.approx(213.14, rel=0.02)
    assert output.max() == pytest.approx(1705.9, rel=0.02)
    assert [cam.min(), cam.max()] == pytest.approx([1967.0, 2460.0], rel=0.02)
    np.testing.assert_allclose(shares(settled), 0.5, atol=0.005)
