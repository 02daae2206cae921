"""Frames of RV reducers for viewers: poses of cranks and discs fit together, and every part has a mesh and a frame."""

import numpy as np
import pytest
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

from cycloid_mj.base.array import Array
from cycloid_mj.design import PRESETS
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.rv_bodies import rv_motion
from cycloid_mj.scene import Scene
from cycloid_mj.scene.messages import FRAMES
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
        for crank, eccentric, bore in zip(bearing.by.bodies, bearing.by.place, bearing.on.place, strict=True):
            np.testing.assert_allclose(transform(found[crank], eccentric), transform(found[gear], bore), atol=1e-12)


def test_every_part_has_a_mesh_and_a_frame() -> None:
    reducer = RvReducer(PRESETS["rv80e"].but(ring={"pins": "fixed"}))
    scene = Scene(reducer.design, 1000.0)
    (_, _, content), *_ = scene.opening(0.0)
    drawn = {entity.frame_id for entity in SceneUpdate.FromString(content).entities}
    frames = list(scene.frames(np.array([0.0, 1e-3]), ideal_columns(reducer, np.array([0.0, 0.5]))))
    assert [topic for topic, _, _ in frames] == [FRAMES, FRAMES]
    moved = {item.child_frame_id for item in FrameTransforms.FromString(frames[0][2]).transforms}
    assert {"housing", "sun", "crank_1", "crank_3", "gear_2", "output"} <= drawn
    assert drawn <= moved
