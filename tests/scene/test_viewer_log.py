"""What viewers see in a log: it decodes by its own schemas, and every pose, part and force agrees with the columns."""

import cProfile
import json
import pstats
import struct
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import foxglove_schemas_protobuf.FrameTransforms_pb2
import foxglove_schemas_protobuf.SceneUpdate_pb2
import numpy as np
import pytest
import trimesh
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from made_run import made_groups, made_run
from mcap.reader import NonSeekingReader, SeekingReader

from cycloid_mj.base.errors import CycloidError, LogError, UsageError
from cycloid_mj.base.names import gears
from cycloid_mj.base.record import Run
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.geometry import profile
from cycloid_mj.log import LogWriter, load, read
from cycloid_mj.log import write as write_run
from cycloid_mj.log.viewer import select_frames
from cycloid_mj.parts import attached_parts, mass_properties, parts
from cycloid_mj.parts.gear import tooth_profile
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.scene import RATE, Scene, contact_forces, frame_rate, poses, ring_places
from cycloid_mj.scene.glb import encode_glb
from cycloid_mj.scene.layout import viewer_layout
from cycloid_mj.scene.messages import FORCES, FRAMES, PARTS, ROOT
from cycloid_mj.scene.shading import CREASE
from cycloid_mj.scene.shape import CHORD_ERROR, shapes

DATA = Path(__file__).parents[1] / "data"
DESIGNS = {
    "free": PRESETS["pin"],
    "fixed": override(PRESETS["pin"], ["ring.pins=fixed", "drive.speed_rpm=-1640"]),
    "nonpin": PRESETS["nonpin"],
}


def write(path: Path, design: Design, run: Run, rate: float = RATE, block: int = 100, **options) -> None:
    groups = {topic: list(units.items()) for topic, units in made_groups(design).items()}
    scene = Scene(design, rate)
    with LogWriter(path, groups, run.provenance, run.attachments, viewer=scene, **options) as log:
        for start in range(0, len(run), block):
            part = run.select(slice(start, start + block))
            log.write(part.time, {topic: part.block(list(names)) for topic, names in made_groups(design).items()})


def decoded(path: Path, topic: str, reader=SeekingReader) -> list[tuple[float, object]]:
    """Log time [s] and message of a topic, decoded by nothing but the schema in the file."""
    found = []
    with path.open("rb") as stream:
        for schema, _, message in reader(stream, validate_crcs=True).iter_messages(topics=[topic]):
            files = descriptor_pb2.FileDescriptorSet.FromString(schema.data)
            pool = descriptor_pool.DescriptorPool()
            for file in files.file:
                pool.Add(file)
            kind = message_factory.GetMessageClass(pool.FindMessageTypeByName(schema.name))
            found.append((message.log_time * 1e-9, kind.FromString(message.data)))
    return found


def whole_chunks(path: Path) -> int:
    """Chunks that are wholly in a file, counted by hand: opcode, length and content of each record after the magic."""
    content, place, count = path.read_bytes(), 8, 0
    while place + 9 <= len(content):
        opcode, length = struct.unpack_from("<BQ", content, place)
        place += 9 + length
        count += opcode == 6 and place <= len(content)
    return count


@pytest.fixture(scope="module", params=DESIGNS)
def logged(request, tmp_path_factory):
    design = DESIGNS[request.param]
    run = made_run(design, 400)
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    write(path, design, run, 1000.0)
    return design, run, path


@pytest.fixture(scope="module")
def small():
    return made_run(PRESETS["nonpin"], 300)


def test_poses_are_those_of_the_columns(logged):
    design, run, path = logged
    truth = poses(Reducer(design), run.columns)
    frames = decoded(path, FRAMES)
    assert len(frames) == 40
    for k, (time, message) in enumerate(frames):
        row = 10 * k
        assert time == pytest.approx(run.time[row], abs=1e-9)
        assert [transform.child_frame_id for transform in message.transforms] == list(truth)
        for transform in message.transforms:
            x, y, angle = truth[transform.child_frame_id][row]
            moved, turn = transform.translation, transform.rotation
            assert transform.parent_frame_id == ROOT
            assert (moved.x, moved.y, moved.z, turn.x, turn.y) == (x, y, 0.0, 0.0, 0.0)
            assert np.remainder(2 * np.arctan2(turn.z, turn.w) - angle + 1, 2 * np.pi) == pytest.approx(1, abs=1e-12)
            assert transform.timestamp.ToNanoseconds() == round(1e9 * time)


def test_poses_are_read_from_the_columns():
    design = DESIGNS["free"]
    run = made_run(design, 50)
    found = poses(Reducer(design), run.columns)
    np.testing.assert_array_equal(found["gear"], run.block(["gear_x", "gear_y", "gear_angle"]))
    np.testing.assert_array_equal(found["shaft"][:, 2], run["crank_angle"])
    np.testing.assert_array_equal(found["output"][:, 2], run["output_angle"])
    assert not found["housing"].any()
    # pin 10 of 36 stands a quarter of a turn clockwise of +y
    np.testing.assert_allclose(found["pin_10"][:, 0], 40.75e-3 + run["pin_10_x"], atol=1e-17)
    np.testing.assert_allclose(found["pin_10"][:, 1], run["pin_10_y"], atol=1e-16)
    with pytest.raises(LogError, match="lacks the columns gear_x"):
        poses(Reducer(design), {name: values for name, values in run.columns.items() if name != "gear_x"})


def test_scene_has_every_part_once_in_its_own_frame(logged):
    design, run, path = logged
    ((time, update),) = decoded(path, PARTS)
    assert time == run.time[0]
    make_frame = {transform.child_frame_id for transform in decoded(path, FRAMES)[0][1].transforms}
    assert {entity.frame_id for entity in update.entities} == make_frame
    assert [entity.id for entity in update.entities] == [entity.frame_id for entity in update.entities]
    for entity in update.entities:
        (model,) = entity.models
        assert entity.frame_locked
        assert entity.lifetime.ToNanoseconds() == 0
        assert model.media_type == "model/gltf-binary"
        assert (model.scale.x, model.scale.y, model.scale.z, model.pose.orientation.w) == (1, 1, 1, 1)
        assert model.data[:4] == b"glTF"
    assert len(make_frame) == (4 + 36 if design.ring.kind == "pin" else 4)


@pytest.mark.parametrize("kind", PRESETS)
def test_parts_are_the_solids_seen_through_a_gltf_viewer(kind):
    """Foxglove turns glTF's y to its z; what it then shows has the volume and the place of the solid."""
    design, reducer = PRESETS[kind], reducer_of(PRESETS[kind])
    solids = parts(reducer, CHORD_ERROR)
    planes = dict(zip(gears(design.gear.discs), design.gear.disc_planes, strict=True))
    to_z_up = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])
    for name, pieces in shapes(reducer).items():
        scene = trimesh.load_scene(trimesh.util.wrap_as_stream(encode_glb(pieces)), file_type="glb")
        mesh = scene.to_mesh().apply_transform(to_z_up)
        mesh.merge_vertices(merge_norm=True)
        own = np.array([0.0, 0.0, planes.get(name, 0.0)])
        truths = [
            (mass_properties(solids[part]), at) for part, at in [(name, own), *attached_parts(reducer, name).values()]
        ]
        volume = sum(truth.volume for truth, _ in truths)
        centroid = sum(truth.volume * (truth.centroid + at) for truth, at in truths) / volume
        assert mesh.is_watertight, name
        assert mesh.volume == pytest.approx(volume, rel=2e-6)  # single precision
        np.testing.assert_allclose(mesh.center_mass, centroid, atol=1e-8)
        corners = np.concatenate([piece.mesh.vertices for piece in pieces])
        np.testing.assert_allclose(mesh.bounds, [corners.min(axis=0), corners.max(axis=0)], atol=1e-8)


def test_normals_are_perpendicular_to_their_faces():
    """Within the crease of each face, and exactly radial on a pin's wall, where its faces are 10 degrees apart."""
    (pin,) = shapes(Reducer(PRESETS["pin"]))["pin"]
    data = encode_glb([pin])
    length, kind = struct.unpack_from("<I4s", data, 12)
    described = json.loads(data[20 : 20 + length])
    assert (kind, struct.unpack_from("<4sII", data), len(data) % 4) == (b"JSON", (b"glTF", 2, len(data)), 0)
    binary = data[28 + length :]
    views = [described["bufferViews"][accessor["bufferView"]] for accessor in described["accessors"]]
    blocks = [binary[v["byteOffset"] : v["byteOffset"] + v["byteLength"]] for v in views]
    (drawn,) = described["meshes"][0]["primitives"]
    vertices = (blocks[drawn["attributes"][key]] for key in ("POSITION", "NORMAL"))
    points, normals = (np.frombuffer(block, "<f4").reshape(-1, 3).astype(float) for block in vertices)
    faces = np.frombuffer(blocks[drawn["indices"]], "<u4").reshape(-1, 3)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-6)
    flat = np.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    assert np.einsum("fck,fk->fc", normals[faces], flat).min() > np.cos(CREASE)
    wall = np.abs(normals[:, 2]) < 0.5
    radial = points[wall, :2] / np.linalg.norm(points[wall, :2], axis=1, keepdims=True)
    np.testing.assert_allclose(normals[wall, :2], radial, atol=1e-6)
    assert wall.sum() == (~wall).sum()  # each point of the rim is on the wall and on a cap


def test_ring_forces_act_where_the_flanks_touch():
    """Eq. 2 gives the contact of each pin; the wrench alone, and the pin's measured place, must lead there."""
    for design in DESIGNS.values():
        run = made_run(design, 60)
        gear, theta = tooth_profile(design), run["crank_angle"]
        acting = contact_forces(Reducer(design), run.columns).of("pin_gear", "tooth")
        zeta = profile.pin_angles(gear)
        inwards = -profile.unit(zeta - profile.conjugate_alpha(gear, zeta + theta[:, np.newaxis]))
        place = np.broadcast_to(ring_places(Reducer(design)), inwards.shape)
        if "pin_1_x" in run.columns:
            place = place + np.stack([run.block([f"pin_{i}_x", f"pin_{i}_y"]) for i in range(1, 37)], axis=1)
        loaded = acting.size > 0
        assert loaded.sum(axis=1).min() >= 17
        contact = place + design.ring.pin_radius * inwards
        np.testing.assert_allclose(acting.point[loaded], contact[loaded], atol=1e-13)


def test_every_force_is_on_its_line_of_action():
    design = DESIGNS["free"]
    run = made_run(design, 40)
    acting = contact_forces(Reducer(design), run.columns)
    assert list(dict.fromkeys(acting.kinds)) == ["pin_gear", "pin_socket", "cam", "output"]
    for k, name in enumerate(acting.names):
        if acting.kinds[k] in ("pin_gear", "cam"):
            arm = acting.point[:, k] - run.block(["gear_x", "gear_y"])
            moment = arm[:, 0] * acting.force[:, k, 1] - arm[:, 1] * acting.force[:, k, 0]
            np.testing.assert_allclose(moment, run[f"{name}_moment"], atol=1e-9)
    wrong = dict(run.columns) | {"pin_30_moment": run["pin_30_moment"] + 1e-5 * run["pin_30_force_x"]}
    moved = contact_forces(Reducer(design), wrong).point - acting.point
    assert np.abs(moved).max() > 1e-6


def test_arrows_end_at_the_contacts(logged):
    design, run, path = logged
    acting = contact_forces(Reducer(design), run.columns)
    for k, (_, update) in enumerate(decoded(path, FORCES)):
        row = 10 * k
        for entity in update.entities:
            these = acting.of(entity.id)
            loaded = these.size[row] > 0
            (told,) = entity.metadata
            assert (entity.frame_id, told.key) == (ROOT, "scale [N/m]")
            tails = np.array([[a.pose.position.x, a.pose.position.y] for a in entity.arrows])
            angles = np.array([2 * np.arctan2(a.pose.orientation.z, a.pose.orientation.w) for a in entity.arrows])
            lengths = np.array([a.shaft_length + a.head_length for a in entity.arrows])
            directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
            np.testing.assert_allclose(
                tails + lengths[:, np.newaxis] * directions, these.point[row][loaded], atol=1e-12
            )
            vectors = float(told.value) * lengths[:, np.newaxis] * directions
            np.testing.assert_allclose(vectors, these.force[row][loaded], rtol=1e-5, atol=1e-9)
    assert [entity.id for entity in update.entities] == list(
        dict.fromkeys(k for k in acting.kinds if k != "pin_socket")
    )


def test_topics_decode_by_the_schema_library_and_in_order_of_time(logged):
    _, _, path = logged
    kinds = {
        FRAMES: foxglove_schemas_protobuf.FrameTransforms_pb2.FrameTransforms,
        PARTS: foxglove_schemas_protobuf.SceneUpdate_pb2.SceneUpdate,
        FORCES: foxglove_schemas_protobuf.SceneUpdate_pb2.SceneUpdate,
    }
    with path.open("rb") as stream:
        summary = SeekingReader(stream, validate_crcs=True).get_summary()
        counts = {
            channel.topic: summary.statistics.channel_message_counts[id] for id, channel in summary.channels.items()
        }
        stream.seek(0)
        for schema, channel, message in NonSeekingReader(stream, validate_crcs=True).iter_messages():
            if channel.topic in kinds:
                kind = kinds[channel.topic]
                assert (schema.name, schema.encoding) == (kind.DESCRIPTOR.full_name, "protobuf")
                assert kind.FromString(message.data).ByteSize() == len(message.data)
    assert (counts[FRAMES], counts[PARTS], counts[FORCES], counts["/reducer"]) == (40, 1, 40, 400)
    for topic in kinds:
        stamps = [time for time, _ in decoded(path, topic)]
        assert all(a < b for a, b in pairwise(stamps))


def test_round_trip_with_a_scene_is_bitwise(logged):
    _, run, path = logged
    found = load(path)
    assert found.run.time.tobytes() == run.time.tobytes()
    assert {name: v.tobytes() for name, v in found.run.columns.items()} == {
        name: v.tobytes() for name, v in run.columns.items()
    }
    assert (found.run.complete, found.complete, found.size) == (True, True, path.stat().st_size)
    assert found.viewers.keys() == {FRAMES, PARTS, FORCES}
    assert {shown.rate for shown in found.viewers.values()} == {1000.0}


@pytest.mark.parametrize("rate", [60.0, 59.94, 1000.0, 7.0, 1e4, 1e5])
@pytest.mark.parametrize("block", [1, 7, 100, 10_000])
def test_frames_are_due_however_samples_come(rate, block):
    time = 1e-4 * np.arange(3000) + 0.02
    found, last = [], -np.inf
    for start in range(0, time.size, block):
        part = time[start : start + block]
        found += (start + select_frames(part, last, rate)).tolist()
        last = part[-1]
    # the first sample, and the first at or after each multiple of the frame's length
    multiples = np.arange(np.floor(time[0] * rate) + 1, np.floor(time[-1] * rate + 1e-6) + 1) / rate
    expected = np.unique([0, *np.searchsorted(time, multiples - 1e-10)])
    assert found == expected.tolist()


def test_log_does_not_depend_on_how_samples_come(small, tmp_path):
    design = DESIGNS["nonpin"]
    for block in (1, 64, 300):
        write(tmp_path / f"{block}.mcap", design, small, 200.0, block)
    contents = {path.read_bytes() for path in tmp_path.iterdir()}
    assert len(contents) == 1


def test_cut_log_keeps_scene_and_samples_of_complete_chunks(small, tmp_path):
    design = DESIGNS["nonpin"]
    path = tmp_path / "run.mcap"
    write(path, design, small, 1000.0, chunk_size=60_000)
    content = path.read_bytes()
    with path.open("rb") as stream:
        chunks = SeekingReader(stream).get_summary().chunk_indexes
    assert len(chunks) > 5
    for chunk in chunks:
        path.write_bytes(content[: chunk.chunk_start_offset + chunk.chunk_length + 5])
        found = load(path)
        count = len(found.run)
        assert found.run["gear_x"].tobytes() == small["gear_x"][:count].tobytes()
        assert "the log is truncated" in found.run.note
        assert found.viewers[PARTS].messages == 1
        assert found.viewers[FRAMES].messages == -(-count // 10)
        target = tmp_path / "repaired.mcap"
        write_run(found.run, target, Scene(design, 1000.0), force=True)
        mended = load(target)
        assert mended.complete
        assert not mended.run.complete
        assert mended.run.note == found.run.note
        assert mended.viewers == found.viewers
        assert mended.run.topics == found.run.topics
        assert {n: v.tobytes() for n, v in mended.run.columns.items()} == {
            n: v.tobytes() for n, v in found.run.columns.items()
        }
        assert mended.run.attachments == found.run.attachments


def test_random_damage_to_a_log_with_a_scene_never_yields_wrong_numbers(small, tmp_path):
    design = DESIGNS["nonpin"]
    path = tmp_path / "run.mcap"
    write(path, design, small, 1000.0, chunk_size=60_000)
    content = path.read_bytes()
    rng = np.random.default_rng(3)
    errors = 0
    for _ in range(60):
        damaged = bytearray(content[: rng.integers(1, len(content) + 1)] if rng.random() < 0.5 else content)
        for place in rng.integers(0, len(damaged), size=rng.integers(0, 3)):
            damaged[place] ^= 1 << rng.integers(8)
        path.write_bytes(damaged)
        try:
            found = read(path)
        except LogError:
            errors += 1
            continue
        for name in small.columns:
            assert found[name].tobytes() == small[name][: len(found)].tobytes()
    assert 10 < errors < 60


@pytest.mark.slow
def test_killed_at_a_random_moment_twenty_times(tmp_path):
    """The program that writes is killed with no warning; each log opens up to its last whole chunk."""
    program = f"""
import os, signal, time
import numpy as np
from cycloid_mj.log import LogWriter
rng = np.random.default_rng(5)
for number in range(20):
    child = os.fork()
    if child == 0:
        log = LogWriter(f"{tmp_path}/{{number}}.mcap", {{"/a": [("x", "1"), ("y", "m")]}}, chunk_size=27 * 50)
        for k in range(1_000_000):
            x = np.arange(40.0) + 40 * k
            log.write(x, {{"/a": np.stack([x, -x], axis=1)}})
    # moments in the log, not in time: the machine may be busy
    size = rng.integers(1, 100_000) if number else 0
    while not os.path.exists(f"{tmp_path}/{{number}}.mcap") or os.path.getsize(f"{tmp_path}/{{number}}.mcap") < size:
        time.sleep(0.0005)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
"""
    subprocess.run([sys.executable, "-c", program], cwd=Path(__file__).parents[2], check=True, timeout=600)
    samples = [50 * whole_chunks(tmp_path / f"{number}.mcap") for number in range(20)]
    assert sum(samples) > 1000
    for number, count in enumerate(samples):
        path = tmp_path / f"{number}.mcap"
        if count == 0:
            with pytest.raises(LogError, match=r"contains no samples|is empty"):
                read(path)
            continue
        run = read(path)
        assert (len(run), run.complete) == (count, False)
        np.testing.assert_array_equal(run["x"], np.arange(float(count)))
        np.testing.assert_array_equal(run["y"], -run["x"])


def test_log_of_the_first_format_stays_readable():
    """Written by the first version of the writer: no scene, two groups of waves, one attachment."""
    found = load(DATA / "log_format_1.mcap")
    time = np.arange(500) * 1e-4
    np.testing.assert_array_equal(found.run.time, time)
    np.testing.assert_array_equal(found.run["crank_angle"], 171.0 * time)
    np.testing.assert_array_equal(found.run["pin_1_x"], np.arange(500.0) ** 2)
    assert dict(found.run.units) == {"crank_angle": "rad", "gear_speed": "rad/s", "pin_1_x": "m"}
    assert dict(found.run.provenance) == {"mujoco": "3.17.0"}
    assert dict(found.run.attachments) == {"design.toml": b"name = 'old'\n"}
    assert (found.run.complete, found.complete, dict(found.viewers)) == (True, True, {})


def test_findings_come_last_and_are_read_back(small, tmp_path):
    path = tmp_path / "run.mcap"
    with LogWriter(path, {"/a": [("x", "1")]}, {}, {"design.toml": b"d"}) as log:
        log.write(np.arange(5.0), {"/a": np.ones((5, 1))})
        log.flush()
        assert len(read(path)) == 5
        log.close(attachments={"findings.json": b"{}"})
    run = read(path)
    assert dict(run.attachments) == {"design.toml": b"d", "findings.json": b"{}"}
    assert run.complete
    log.flush()


def test_a_failed_run_has_no_frame_of_its_failure(small, tmp_path):
    """A last sample that is not a number is logged, but no viewer is asked to draw it."""
    columns = {name: values.copy() for name, values in small.columns.items()}
    columns["gear_x"][-1] = np.nan
    run = Run(small.time, columns, small.units, small.provenance, small.attachments)
    path = tmp_path / "run.mcap"
    write(path, DESIGNS["nonpin"], run, 1e4)
    assert len(decoded(path, FRAMES)) == len(run) - 1
    assert np.isnan(read(path)["gear_x"][-1])


@pytest.mark.parametrize("rate", [0.0, -1.0, np.nan, np.inf, 1e7])
def test_rates_that_a_scene_refuses(rate):
    with pytest.raises(UsageError, match="choose a rate greater than 0"):
        Scene(PRESETS["pin"], rate)


@pytest.mark.parametrize("hold", [0.05, 2.0, 1000.0])
def test_a_replay_shows_which_way_the_crank_turns(hold):
    """At 60 frames a second it came on by 164 deg from one to the next, which looks like any other angle."""
    design = override(PRESETS["pin"], ["drive.ramp_s=0", f"drive.hold_s={hold}"])
    rate = frame_rate(Reducer(design))
    assert rate * hold <= max(900.0, 60.0 * hold) + 1e-6
    if hold < 1.0:
        assert np.degrees(design.drive.speed / rate) == pytest.approx(10.0)
    assert frame_rate(Reducer(override(design, ["settings.scene_rate_hz=5000"]))) == 5000.0
    assert frame_rate(Reducer(override(design, ["drive.speed_rpm=0"]))) == 60.0


def test_scene_costs_little():
    """A frame costs Python calls in proportion to the parts and forces in it, so that logs are not slowed down by it.

    Some 40 calls for each of the 36 pins' poses and arrows, their sockets and the rest: 9 300 a frame, and 1000 frames
    a simulated second, are 3 % of the second's steps. Calls are counted, for time depends on the machine and its load.
    """
    run, scene = made_run(PRESETS["pin"], 11), Scene(PRESETS["pin"])
    parts = [run.select(slice(row, row + 1)) for row in range(10)]
    counter = cProfile.Profile()
    with counter:
        for part in parts:
            assert len(list(scene.frames(part.time, part.columns))) == 2
    assert pstats.Stats(counter).total_calls < 15_000 * len(parts)


def test_layout_names_what_the_log_has(logged):
    design, _, path = logged
    found = viewer_layout(Reducer(design))
    make_frame = {f"frame:{transform.child_frame_id}" for transform in decoded(path, FRAMES)[0][1].transforms}
    view = found["configById"]["3D!mechanism"]
    assert view["transforms"].keys() == make_frame | {f"frame:{ROOT}"}
    assert view["topics"].keys() == {PARTS, FORCES}
    assert view["cameraState"]["near"] < 0.1 * design.housing.outer_radius
    columns = {f"{topic}.{name}" for topic, names in read(path).topics.items() for name in names}
    plots = [panel for name, panel in found["configById"].items() if name.startswith("Plot!")]
    assert {line["value"] for plot in plots for line in plot["paths"]} <= columns
    arranged = json.dumps(found["layout"])
    assert all(f'"{name}"' in arranged for name in found["configById"])


def test_a_missing_rerun_package_is_reported_clearly(small, tmp_path, monkeypatch):
    from cycloid_mj.scene.rerun import write_rerun

    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(CycloidError, match=r"a recording needs rerun .*pip install 'cycloid-mj\[rerun\]'"):
        write_rerun(small, Reducer(DESIGNS["nonpin"]), tmp_path / "x.rrd")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_rerun_loads_the_log_and_what_is_written_for_it(logged, tmp_path):
    pytest.importorskip("rerun")
    from cycloid_mj.scene.rerun import write_rerun

    design, _, path = logged
    tool = [sys.executable, "-m", "rerun"]
    checked = subprocess.run([*tool, "mcap", "check", path], capture_output=True, text=True, check=True, timeout=120)
    for topic in (FRAMES, PARTS, FORCES, "/reducer", "/forces"):
        assert any(line.split()[:1] == ["ok"] and topic in line for line in checked.stdout.splitlines()), checked.stdout
    target = tmp_path / "run.rrd"
    write_rerun(read(path), Reducer(design), target)
    done = subprocess.run([*tool, "rrd", "verify", target], capture_output=True, text=True, check=True, timeout=120)
    assert "verified without error" in done.stdout + done.stderr
    told = subprocess.run([*tool, "rrd", "stats", target], capture_output=True, text=True, check=True, timeout=120)
    for entity in ("/mechanism/gear", "/mechanism/output/disc", "/mechanism/forces/cam", "/signals/reducer/gear_speed"):
        assert f"{entity}:" in told.stdout + told.stderr


def test_strict_readers_accept_the_log_of_a_run(tmp_path):
    """Some decoders build the messages of each file descriptor as they come, and refuse a log that goes back in time.

    Every descriptor set is in topological order and complete, no channel is empty, log times do not decrease, chunks do
    not overlap, and a second reading in the same process decodes the same number of messages.
    """
    changes = [flag for change in ("drive.ramp_s=0.02", "drive.hold_s=0.02") for flag in ("--set", change)]
    command = ["simulate", "--design", "printed", "--solver", "planar", *changes, "--json", "--out", str(tmp_path)]
    assert main([*command, "--quiet"]) == 0
    with (tmp_path / "printed.mcap").open("rb") as stream:
        summary = SeekingReader(stream, validate_crcs=True).get_summary()
        for schema in summary.schemas.values():
            described = set()
            for file in descriptor_pb2.FileDescriptorSet.FromString(schema.data).file:
                assert set(file.dependency) <= described, (schema.name, file.name)
                described.add(file.name)
        counts = summary.statistics.channel_message_counts
        assert set(counts) == set(summary.channels)
        assert min(counts.values()) > 0
        spans = [(chunk.message_start_time, chunk.message_end_time) for chunk in summary.chunk_indexes]
        assert all(last <= first for (_, last), (first, _) in pairwise(sorted(spans)))
        numbers = []
        for _ in range(2):
            stream.seek(0)
            times = [message.log_time for _, _, message in NonSeekingReader(stream).iter_messages(log_time_order=False)]
            assert all(before <= after for before, after in pairwise(times))
            numbers.append(
                sum(len(decoded(tmp_path / "printed.mcap", channel.topic)) for channel in summary.channels.values())
            )
    assert numbers == [len(times)] * 2
    assert len(times) == summary.statistics.message_count


def test_samples_without_a_finite_pose_have_no_frames() -> None:
    run = made_run(PRESETS["pin"], 3)
    columns = {name: np.full_like(values, np.nan) for name, values in run.columns.items()}
    assert list(Scene(PRESETS["pin"]).frames(run.time, columns)) == []
