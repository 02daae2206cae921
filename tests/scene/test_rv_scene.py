"""RV reducers in viewers: poses of cranks and discs fit together, every part has a mesh, forces have their points."""

from pathlib import Path

import numpy as np
import pytest
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from PIL import Image
from rv_runs import COULOMB_RV80E

from cycloid_mj.base.array import Array, cross
from cycloid_mj.base.record import Run
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS
from cycloid_mj.dynamics.run import model_for, simulate
from cycloid_mj.log import write
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.rv_bodies import rv_motion
from cycloid_mj.scene import Scene
from cycloid_mj.scene.force import contact_forces, reference_force, shown_forces
from cycloid_mj.scene.layout import viewer_layout
from cycloid_mj.scene.messages import FORCES, FRAMES
from cycloid_mj.scene.pose import poses, transform


def ideal_columns(reducer: RvReducer, sun_angles: Array) -> dict[str, Array]:
    """Columns of the ideal motion at angles of the sun."""
    joints = [rv_motion(reducer, angle, 1.0)[0] for angle in sun_angles]
    columns = {name: np.array([values[name] for values in joints]) for name in joints[0]}
    return columns | {"output_angle": columns["output"]}


@pytest.mark.parametrize("member", ["carrier", "ring"])
def test_eccentrics_are_in_the_bores_of_the_discs(member: str) -> None:
    reducer = RvReducer(PRESETS["rv80e"].but(output={"member": member}))
    found = poses(reducer, ideal_columns(reducer, np.linspace(0.0, 700.0, 23)))
    for disc, gear in enumerate(reducer.gears):
        bearing = reducer.mechanism.mating("crank_bearing", disc)
        for crank, eccentric, bore in zip(bearing.by.bodies, bearing.by.position, bearing.on.position, strict=True):
            np.testing.assert_allclose(transform(found[crank], eccentric), transform(found[gear], bore), atol=1e-12)


def test_every_part_has_a_mesh_and_a_frame() -> None:
    reducer = RvReducer(PRESETS["rv80e"].but(ring={"pins": "fixed"}))
    scene = Scene(reducer.design, 1000.0)
    (_, _, content), *_ = scene.opening(0.0)
    drawn = {entity.frame_id for entity in SceneUpdate.FromString(content).entities}
    frames = list(scene.frames(np.array([0.0, 1e-3]), ideal_columns(reducer, np.array([0.0, 0.5]))))
    assert [topic for topic, _, _ in frames] == [FRAMES, FORCES, FRAMES, FORCES]
    moved = {item.child_frame_id for item in FrameTransforms.FromString(frames[0][2]).transforms}
    assert {"housing", "sun", "crank_1", "crank_3", "gear_2", "output"} <= drawn
    assert drawn <= moved


@pytest.fixture(scope="module", params=["carrier", "ring"])
def loaded(request: pytest.FixtureRequest) -> tuple[RvReducer, Run]:
    """A run under load, after it has settled."""
    changes = {"drive": {"ramp": 0.0, "hold": 0.015}, "output": {"member": request.param}}
    reducer = RvReducer(COULOMB_RV80E.but(ring={"pins": "fixed"}, **changes))
    run = simulate(reducer.design, model_for("planar", reducer))
    return reducer, run.select(run.time > 0.01)


def test_forces_balance_each_disc_at_their_points(loaded: tuple[RvReducer, Run]) -> None:
    """The weight of a disc and its centrifugal force are 20 N; its forces are thousands of newtons."""
    reducer, run = loaded
    forces, found = contact_forces(reducer, run.columns), poses(reducer, run.columns)
    for disc, gear in enumerate(reducer.gears):
        acting = forces.of("pin_gear", "crank_bearing").of_disc(disc)
        arms = acting.point - found[gear][:, np.newaxis, :2]
        assert np.abs(acting.force.sum(axis=1)).max() < 30.0
        assert acting.size.max() > 4000.0
        moments = cross(arms, acting.force)
        # friction torque of the needles, which have no arm in the drawing: 4 forces of 5 kN, 0.004, 12 mm
        assert np.abs(moments.sum(axis=1)).max() < 2e-3 * np.abs(moments).sum(axis=1).max() + 1.0


def test_forces_of_the_planets_turn_the_sun(loaded: tuple[RvReducer, Run]) -> None:
    reducer, run = loaded
    meshes, found = contact_forces(reducer, run.columns).of("planet_mesh"), poses(reducer, run.columns)
    torque = cross(meshes.point - found["sun"][:, np.newaxis, :2], meshes.force).sum(axis=1)
    np.testing.assert_allclose(torque, -run["sun_torque"], rtol=0.01)


def test_arrows_of_teeth_and_crank_bearings_have_the_scale_of_ideal_sharing(loaded: tuple[RvReducer, Run]) -> None:
    reducer, run = loaded
    shown, references = shown_forces(reducer, run.columns), reference_force(reducer)
    assert set(shown.kinds) == {"pin_gear", "crank_bearing"}
    for kind in set(shown.kinds):
        assert 0.5 < shown.of(kind).size.max() / references[kind] < 2.0


def test_the_layout_plots_the_torque_of_the_sun() -> None:
    content = viewer_layout(RvReducer(PRESETS["rv80e"]))
    torque, _ = content["configById"]["Plot!torque"]["paths"]
    assert torque["value"] == "/reducer.sun_torque"
    hidden = content["configById"]["3D!mechanism"]["transforms"]
    assert {"frame:sun", "frame:crank_3", "frame:gear_2"} <= hidden.keys()
    assert "frame:shaft" not in hidden


@pytest.mark.slow
def test_render_draws_a_run_with_arrows(tmp_path: Path, loaded: tuple[RvReducer, Run]) -> None:
    _, run = loaded
    log, picture = tmp_path / "rv80e.mcap", tmp_path / "rv80e.png"
    write(run, log)
    if main(["render", str(log), str(picture), "--quiet", "--width", "400", "--height", "300"]) != 0:
        pytest.skip("no OpenGL here")
    with Image.open(picture) as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    red, green, blue = np.moveaxis(pixels, -1, 0)
    is_orange = (red > 150) & (green < 0.65 * red) & (blue < 0.4 * red)
    assert pixels.shape == (300, 400, 3)
    assert is_orange.mean() > 1e-3
