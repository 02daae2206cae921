import json
import os
import signal
import subprocess
import sys
import zlib
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from folders import disk_of
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.data_stream import RecordBuilder
from mcap.reader import make_reader
from mcap.records import Chunk, Message
from mcap.stream_reader import StreamReader, breakup_chunk, get_chunk_data_stream
from mcap.writer import CompressionType, Writer

from cycloid_mj.base.errors import LogError
from cycloid_mj.base.record import Run
from cycloid_mj.log import ColumnGroup, LogWriter, read

pytest.importorskip("resource", reason="limits of processes are of POSIX alone")

GROUPS = {
    "/reducer": [("crank_angle", "rad"), ("gear_torque", "N m"), ("transmission_error", "rad")],
    "/output_pins": [(f"output_pin_force_{k}", "N") for k in range(20)],
}
UNITS = {name: unit for columns in GROUPS.values() for name, unit in columns}
PROVENANCE = {"seed": "1", "author": "Hsieh, 謝"}
ATTACHMENTS = {"design.toml": b"lobes = 35\n", "model.xml": b"<mujoco/>", "odd.bin": bytes(range(256)), "none": b""}
ROW = 4 * 9 + 21 * 9 + 6  # bytes of one sample: 9 a value, and 6 field numbers of the second group have longer keys
SPECIAL = np.array(
    [0x8000000000000000, 0x1, 0x7FF8DEADBEEF0001, 0x7FF0000000000001, 0x7FF0000000000000, 0xFFF0000000000000, 0x0],
    dtype=np.uint64,
).view(np.float64)  # -0, the smallest number, two NaNs with payloads, the infinities, 0


def make_run(samples: int = 95) -> Run:
    rng = np.random.default_rng(11)
    columns = {name: rng.normal(size=samples) for name in UNITS}
    columns["crank_angle"][: SPECIAL.size] = SPECIAL[:samples]
    columns["output_pin_force_19"] = np.zeros(samples)
    return Run(np.arange(samples) * 1e-5 / 3, columns, UNITS, PROVENANCE, ATTACHMENTS)


def write(path: Path, run: Run, block: int = 10, samples_per_chunk: int = 10, **options) -> None:
    with LogWriter(path, GROUPS, PROVENANCE, ATTACHMENTS, chunk_size=samples_per_chunk * ROW, **options) as log:
        write_samples(log, run, block)


def write_samples(log: LogWriter, run: Run, block: int = 10) -> None:
    for start in range(0, len(run), block):
        part = run.select(slice(start, start + block))
        log.write(part.time, {topic: part.block([name for name, _ in GROUPS[topic]]) for topic in GROUPS})


def assert_prefix(part: Run, whole: Run) -> None:
    """Bit for bit, the samples of `part` are the first of `whole`."""
    n = len(part)
    assert part.time.tobytes() == whole.time[:n].tobytes()
    assert dict(part.units) == dict(whole.units)
    assert list(part.columns) == list(whole.columns)
    for name in whole.columns:
        assert part[name].tobytes() == whole[name][:n].tobytes(), name
    assert part.attachments.items() <= whole.attachments.items()


def assert_same(left: Run, right: Run) -> None:
    assert len(left) == len(right)
    assert_prefix(left, right)
    for name in ("provenance", "attachments", "complete", "note"):
        assert getattr(left, name) == getattr(right, name), name


def repack(source: Path, target: Path, edit: Callable[[str, dict], dict | None], **options) -> None:
    """Write the records of a log again with mcap's own writer, each changed, or left out, by `edit(kind, fields)`."""
    with source.open("rb") as old, target.open("wb") as new:
        reader, writer = make_reader(old), Writer(new, **options)
        writer.start()
        metadata = [edit("metadata", {"name": m.name, "data": m.metadata}) for m in reader.iter_metadata()]
        for fields in metadata[:2]:
            if fields:
                writer.add_metadata(**fields)
        summary = reader.get_summary()
        channels: dict[int, int] = {}
        for channel in summary.channels.values():
            schema = summary.schemas[channel.schema_id]
            described = {"name": schema.name, "encoding": schema.encoding, "data": schema.data}
            schema_id = writer.register_schema(**edit("schema", described))
            described = {"topic": channel.topic, "message_encoding": "protobuf", "metadata": channel.metadata}
            channels[channel.id] = writer.register_channel(**edit("channel", described), schema_id=schema_id)
        for _, channel, message in reader.iter_messages(log_time_order=False):
            sample = {"topic": channel.topic, "data": message.data, "sequence": message.sequence}
            if edited := edit("message", sample):
                writer.add_message(
                    channels[channel.id], message.log_time, edited["data"], message.log_time, edited["sequence"]
                )
        writer.flush()
        for fields in metadata[2:]:
            if fields:
                writer.add_metadata(**fields)
        writer.finish()


def chunks_of(path: Path) -> list:
    with path.open("rb") as stream:
        return make_reader(stream).get_summary().chunk_indexes


def read_or_error(path: Path) -> Run | LogError:
    try:
        return read(path)
    except LogError as error:
        return error


@pytest.fixture(scope="module")
def truth() -> Run:
    return make_run()


@pytest.fixture(scope="module")
def log(truth, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    write(path, truth)
    return path


def test_round_trip_is_bitwise(log, truth):
    assert_same(read(log), truth)
    assert np.signbit(read(log)["crank_angle"][0])


@pytest.mark.parametrize(("block", "samples_per_chunk"), [(1, 10), (7, 10), (95, 10), (95, 1), (95, 1000)])
def test_log_does_not_depend_on_how_samples_come(block, samples_per_chunk, truth, tmp_path):
    write(tmp_path / "a.mcap", truth, block=10, samples_per_chunk=samples_per_chunk)
    write(tmp_path / "b.mcap", truth, block=block, samples_per_chunk=samples_per_chunk)
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()
    assert_same(read(tmp_path / "b.mcap"), truth)


def test_google_protobuf_and_mcap_decode_it(log, truth):
    """Two programs of others find the same numbers: mcap the records, protobuf the values by the embedded schema."""
    names = {topic: [name for name, _ in columns] for topic, columns in GROUPS.items()}
    seen = dict.fromkeys(GROUPS, 0)
    with log.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        for schema, channel, message in reader.iter_messages():
            files = descriptor_pb2.FileDescriptorSet.FromString(schema.data)
            classes = message_factory.GetMessages(files.file, pool=descriptor_pool.DescriptorPool())
            decoded = classes[schema.name].FromString(message.data)
            i = message.sequence
            values = np.array([getattr(decoded, name) for name in ["time", *names[channel.topic]]])
            expected = np.array([truth.time[i], *truth.block(names[channel.topic])[i]])
            assert values.tobytes() == expected.tobytes()
            assert message.log_time == message.publish_time == round(truth.time[i] * 1e9)
            assert schema.name in ("cycloid_mj.Reducer", "cycloid_mj.OutputPins")
            assert json.loads(channel.metadata["units"]) == dict(GROUPS[channel.topic])
            comments = [line.trailing_comments.strip() for line in files.file[0].source_code_info.location]
            assert comments == ["[s]", *(f"[{unit}]" for _, unit in GROUPS[channel.topic])]
            seen[channel.topic] += 1
        assert seen == dict.fromkeys(GROUPS, len(truth))
        statistics = reader.get_summary().statistics
        assert (statistics.message_count, statistics.chunk_count, statistics.attachment_count) == (190, 10, 4)
        assert {a.name: a.data for a in reader.iter_attachments()} == ATTACHMENTS
        assert [m.name for m in reader.iter_metadata()] == ["cycloid_mj", "provenance", "cycloid_mj.end"]


def test_records_come_in_the_order_of_the_format(log):
    with log.open("rb") as stream:
        kinds = [type(record).__name__ for record in StreamReader(stream, emit_chunks=True).records]
    kinds = [kind for kind in kinds[: kinds.index("DataEnd")] if kind != "MessageIndex"]
    assert kinds == ["Header", *["Metadata"] * 2, *["Attachment"] * 4, *["Chunk"] * 10, "Metadata"]


def test_protobuf_would_write_the_same_bytes():
    """Keys of one and of two bytes: the encoder against google.protobuf's (it leaves out zeros, so there are none)."""
    group = ColumnGroup("/pins", {f"force_{k}": "N" for k in range(40)})
    files = descriptor_pb2.FileDescriptorSet.FromString(group.schema())
    pool = descriptor_pool.DescriptorPool()
    message = message_factory.GetMessages(files.file, pool=pool)["cycloid_mj.Pins"]
    values = np.random.default_rng(2).normal(size=(1, 40))
    fields = {f"force_{k}": values[0, k] for k in range(40)}
    theirs = message(time=0.5, **fields).SerializeToString(deterministic=True)
    assert group.encode(np.array([0.5]), values).tobytes() == theirs


def test_a_topic_is_passed_over_and_samples_are_chosen(log, truth):
    without = read(log, without=("/output_pins",))
    assert list(without.columns) == [name for name, _ in GROUPS["/reducer"]]
    assert without["gear_torque"].tobytes() == truth["gear_torque"].tobytes()
    rows = np.array([0, 9, 10, 57, 94])
    some = read(log, rows=rows)
    assert some.time.tobytes() == truth.time[rows].tobytes()
    for name in truth.columns:
        assert some[name].tobytes() == truth[name][rows].tobytes(), name
    assert some.complete


@pytest.mark.slow
def test_a_log_cut_anywhere_has_all_complete_chunks(log, truth, tmp_path):
    """The number of samples is known from mcap's index of the whole file."""
    content = log.read_bytes()
    ends = np.array([chunk.chunk_start_offset + chunk.chunk_length for chunk in chunks_of(log)])
    cuts = {int(end) + step for end in ends for step in (-1, 0, 1)} | {len(content) - 1, 1, 7, 8, 9, 100}
    cuts |= set(np.random.default_rng(3).integers(1, len(content), size=150).tolist())
    path = tmp_path / "cut.mcap"
    for cut in sorted(cuts):
        path.write_bytes(content[:cut])
        samples = min(10 * int((ends <= cut).sum()), 95)
        if samples == 0:
            with pytest.raises(LogError):
                read(path)
            continue
        run = read(path)
        assert len(run) == samples, cut
        assert_prefix(run, truth)
        assert run.provenance == PROVENANCE
        assert run.attachments == ATTACHMENTS
        assert not run.complete
        assert f"truncated: {samples} samples, up to {run.time[-1]:.9g} s" in run.note


def test_a_cut_log_states_what_it_has_lost(truth, tmp_path):
    """A bit wrong in a record before the samples, which only the end of a whole log would give away."""
    whole, path = tmp_path / "whole.mcap", tmp_path / "cut.mcap"
    with LogWriter(whole, {"/a": [("x", "m")]}, {"design": "pin", "k": "v"}, {"design.toml": b"name"}) as log:
        log.write(np.arange(9.0), {"/a": np.ones((9, 1))})
    content = whole.read_bytes()
    chunk = content.index(b"\x06", content.index(b"application/toml"))
    cut = content[: chunk + 9 + int.from_bytes(content[chunk + 1 : chunk + 9], "little")]
    path.write_bytes(cut)
    assert read(path).note.endswith("could be read")
    told = []
    for at in range(8, chunk):
        for bit in (0, 4):
            damaged = bytearray(cut)
            damaged[at] ^= 1 << bit
            path.write_bytes(damaged)
            with suppress(LogError):
                run = read(path)
                same = dict(run.provenance) == {"design": "pin", "k": "v"} and set(run.attachments) == {"design.toml"}
                assert same or "missing" in run.note or "damaged" in run.note, (at, run.note)
                told.append(run.note.rpartition("; ")[2])
    assert {"its provenance is missing", "its provenance is damaged", "its design.toml is missing"} <= set(told)


def test_bytes_reserved_but_never_written_are_a_cut(log, truth, tmp_path):
    path = tmp_path / "zeros.mcap"
    path.write_bytes(log.read_bytes()[: chunks_of(log)[4].chunk_start_offset] + bytes(5000))
    run = read(path)
    assert (len(run), run.complete) == (40, False)
    assert_prefix(run, truth)


def test_killed_process_leaves_its_chunks(tmp_path):
    path = tmp_path / "killed.mcap"
    program = f"""
import os, signal, numpy as np
from cycloid_mj.log import LogWriter
log = LogWriter({str(path)!r}, {{"/a": [("x", "1")]}}, chunk_size=18 * 10)
for k in range(4):
    log.write(np.arange(8.0) + 8 * k, {{"/a": np.arange(8.0)[:, None] + 8 * k}})
os.kill(os.getpid(), signal.SIGKILL)
"""
    root = Path(__file__).parents[2]
    done = subprocess.run([sys.executable, "-c", program], cwd=root, check=False, timeout=60)
    assert done.returncode == -signal.SIGKILL
    run = read(path)
    np.testing.assert_array_equal(run["x"], np.arange(30.0))
    assert not run.complete


@pytest.mark.slow
def test_random_damage_never_yields_wrong_numbers(log, truth, tmp_path):
    """Bytes overwritten, bits flipped, pieces lost or doubled: a LogError, or samples that are true."""
    content = log.read_bytes()
    rng = np.random.default_rng(20)
    path = tmp_path / "damaged.mcap"
    refused = 0
    for case in range(400):
        damaged = bytearray(content)
        for _ in range(rng.integers(1, 4)):
            place = int(rng.integers(0, len(damaged)))
            if case % 4 == 0:
                damaged[place] ^= 1 << int(rng.integers(0, 8))
            elif case % 4 == 1:
                damaged[place : place + 8] = rng.bytes(8)
            elif case % 4 == 2:
                del damaged[place : place + int(rng.integers(1, 400))]
            else:
                damaged[place:place] = damaged[place : place + int(rng.integers(1, 400))]
        path.write_bytes(damaged)
        found = read_or_error(path)
        if isinstance(found, LogError):
            assert str(path) in str(found)
            assert "\n" not in str(found)
            refused += 1
        else:
            assert_prefix(found, truth)
            assert not found.complete or len(found) == len(truth)
    assert 200 < refused < 400


@pytest.mark.slow
def test_every_record_length_and_kind_may_be_damaged(log, truth, tmp_path):
    """The places where damage is most dangerous, one by one: opcode and length of each record of the file."""
    content = log.read_bytes()
    path = tmp_path / "damaged.mcap"
    position = 8
    while position + 9 < len(content):
        for place in range(position, position + 9):
            for flip in (0x01, 0x02, 0x80) if place == position else (0x01, 0x80):
                damaged = bytearray(content)
                damaged[place] ^= flip
                path.write_bytes(damaged)
                found = read_or_error(path)
                if isinstance(found, Run):
                    assert_prefix(found, truth)
                    assert not found.complete or len(found) == len(truth)
        position += 9 + int.from_bytes(content[position + 1 : position + 9], "little")


def test_one_wrong_bit_in_each_chunk_is_found(log, tmp_path):
    content = log.read_bytes()
    path = tmp_path / "damaged.mcap"
    for chunk in chunks_of(log):
        damaged = bytearray(content)
        damaged[chunk.chunk_start_offset + chunk.chunk_length // 2] ^= 4
        for end in (len(content), len(content) - 1):
            path.write_bytes(damaged[:end])
            with pytest.raises(LogError, match=f"corrupt: malformed chunk at byte {chunk.chunk_start_offset} "):
                read(path)


@pytest.mark.parametrize(
    ("where", "end", "message"),
    [(b"Hsieh", None, "CRC of its data is wrong"), (b"lobes = 35", None, "CRC"), (b"lobes = 35", -1, "CRC is wrong")],
)
def test_one_wrong_bit_in_provenance_and_attachments_is_found(where, end, message, log, tmp_path):
    damaged = bytearray(log.read_bytes())
    damaged[damaged.index(where)] ^= 1
    (tmp_path / "damaged.mcap").write_bytes(damaged[:end])
    with pytest.raises(LogError, match=message):
        read(tmp_path / "damaged.mcap")


def test_a_wrong_length_in_a_complete_file_is_not_a_cut(log, tmp_path):
    damaged = bytearray(log.read_bytes())
    place = chunks_of(log)[5].chunk_start_offset
    damaged[place + 8] = 1
    (tmp_path / "damaged.mcap").write_bytes(damaged)
    with pytest.raises(LogError, match=f"corrupt: there is no valid record at byte {place} of {len(damaged)}"):
        read(tmp_path / "damaged.mcap")
    (tmp_path / "damaged.mcap").write_bytes(damaged[:-1])
    assert len(read(tmp_path / "damaged.mcap")) == 50


def unchanged(_: str, fields: dict) -> dict:
    return fields


@pytest.mark.parametrize("compression", [CompressionType.ZSTD, CompressionType.LZ4, CompressionType.NONE])
@pytest.mark.parametrize("chunk_size", [300, 4000, 1 << 20])
def test_other_tools_may_repack_a_log(compression, chunk_size, log, truth, tmp_path):
    repack(log, tmp_path / "r.mcap", unchanged, compression=compression, chunk_size=chunk_size)
    run = read(tmp_path / "r.mcap")
    assert run.complete
    assert_prefix(run, truth)
    assert len(run) == len(truth)


@pytest.mark.parametrize("missing", [1, 200, 240])
def test_chunk_that_ends_within_a_message_is_refused(missing, log, tmp_path):
    """Its CRC is right, so this is no damage but a faulty writer."""
    with log.open("rb") as stream:
        records = list(StreamReader(stream, emit_chunks=True).records)
    chunk = next(record for record in records if isinstance(record, Chunk))
    inner, size = get_chunk_data_stream(chunk)
    chunk.data = inner.read(size)[:-missing]
    chunk.compression, chunk.uncompressed_size, chunk.uncompressed_crc = "", len(chunk.data), zlib.crc32(chunk.data)
    builder = RecordBuilder()
    builder.write(log.read_bytes()[:8])
    for record in [*records[: records.index(chunk)], chunk]:
        record.write(builder)
    (tmp_path / "faulty.mcap").write_bytes(builder.end())
    with pytest.raises(LogError, match="corrupt: malformed chunk"):
        read(tmp_path / "faulty.mcap")


@pytest.mark.slow
def test_groups_of_different_length_after_a_cut_give_the_common_samples(log, truth, tmp_path):
    """Chunks of mcap's own writer end between two groups of one sample."""
    path = tmp_path / "r.mcap"
    repack(log, path, unchanged, chunk_size=300)
    content = path.read_bytes()
    with path.open("rb") as stream:
        chunks = [r for r in StreamReader(stream, emit_chunks=True).records if isinstance(r, Chunk)]
    counts = Counter({1: 0, 2: 0})
    uneven = 0
    for chunk, place in zip(chunks, chunks_of(path), strict=True):
        counts.update(record.channel_id for record in breakup_chunk(chunk) if isinstance(record, Message))
        uneven += counts[1] != counts[2]
        path.write_bytes(content[: place.chunk_start_offset + place.chunk_length])
        found = read_or_error(path)
        if min(counts.values()) == 0:
            assert isinstance(found, LogError)
        else:
            assert len(found) == min(counts.values())
            assert_prefix(found, truth)
    assert uneven > 10


def test_channels_and_records_of_viewers_are_passed_over(log, truth, tmp_path):
    def with_scene(kind: str, fields: dict) -> dict:
        if kind == "message" and fields["topic"] == "/output_pins":
            return fields | {"data": fields["data"][: 20 + fields["sequence"]]}
        if kind == "channel" and fields["topic"] == "/output_pins":
            return fields | {"topic": "/scene", "metadata": {}}
        return fields

    repack(log, tmp_path / "r.mcap", with_scene)
    run = read(tmp_path / "r.mcap")
    assert list(run.columns) == [name for name, _ in GROUPS["/reducer"]]
    assert run["gear_torque"].tobytes() == truth["gear_torque"].tobytes()


def edits() -> dict[str, tuple[Callable[[str, dict], dict | None], str]]:
    """Map name to (change of the log, what the reader must say about it)."""

    def on(kind: str, change: Callable[[dict], dict | None], topic: str = "") -> Callable[[str, dict], dict | None]:
        def edit(this: str, fields: dict) -> dict | None:
            return change(fields) if this == kind and topic in fields.get("topic", "") else fields

        return edit

    def sample(number: int, change: Callable[[dict], dict | None]) -> Callable[[str, dict], dict | None]:
        return on("message", lambda f: change(f) if f["sequence"] == number else f, "/reducer")

    def retimed(fields: dict) -> dict:
        return fields | {"data": fields["data"][:1] + np.float64(7.5).tobytes() + fields["data"][9:]}

    units = {"units": json.dumps(dict(GROUPS["/reducer"]))}
    int_schema = ColumnGroup("/reducer", dict(GROUPS["/reducer"])).schema().replace(b"\x28\x01", b"\x28\x06")
    return {
        "foreign": (on("metadata", lambda _: None), "not a log of cycloid_mj"),
        "version": (
            on("metadata", lambda f: f | {"data": {"format": "2"}} if f["name"] == "cycloid_mj" else f),
            "has format '2', but this version of cycloid_mj reads '1'",
        ),
        "keys": (sample(40, lambda f: f | {"data": b"\x11" + f["data"][1:]}), "fields that differ from their schema"),
        "length": (sample(40, lambda f: f | {"data": f["data"] + b"\0"}), "/reducer differ in length"),
        "lengths": (on("message", lambda f: f | {"data": f["data"] + b"\0"}), "37 bytes, but their schema defines 36"),
        "missing": (sample(40, lambda _: None), "missing or out of order"),
        "order": (sample(40, lambda f: f | {"sequence": 41}), "missing or out of order"),
        "last": (on("message", lambda f: f if f["sequence"] < 94 else None), "should have 95 samples and has 94"),
        "count": (
            on("metadata", lambda f: None if f["name"] == "cycloid_mj.end" else f),
            "should have None samples and has 95",
        ),
        "times": (sample(40, retimed), "the sampling times of its topics differ"),
        "backward": (
            on("message", lambda f: retimed(f) if f["sequence"] == 40 else f),
            "the times of the run do not increase at sample .*: 7.5 s is followed",
        ),
        "units": (on("channel", lambda f: f | {"metadata": {"units": "{"}}), "malformed schema of /reducer"),
        "no unit": (on("channel", lambda f: f | {"metadata": {"units": "{}"}}), "malformed schema of /reducer"),
        "list": (on("channel", lambda f: f | {"metadata": {"units": "[1]"}}), "malformed schema of /reducer"),
        "encoding": (
            on("channel", lambda f: f | {"message_encoding": "json"}),
            "does not consist of the time followed by 64-bit numbers",
        ),
        "schema": (on("schema", lambda f: f | {"data": b"\xff\xff"}), "malformed schema of /reducer"),
        "types": (
            on("schema", lambda f: f | {"data": int_schema}),
            "does not consist of the time followed by 64-bit numbers",
        ),
        "twice": (
            lambda kind, f: (
                f | {"metadata": units}
                if kind == "channel"
                else f | {"data": ColumnGroup("/reducer", dict(GROUPS["/reducer"])).schema()}
                if kind == "schema"
                else f | {"data": f["data"][:36]}
                if kind == "message"
                else f
            ),
            "a column occurs in two topics",
        ),
        "no channel": (on("channel", lambda f: f | {"metadata": {}}), "contains no samples"),
    }


@pytest.mark.parametrize("name", edits())
def test_a_log_that_contradicts_the_format_is_refused(name, log, tmp_path):
    edit, message = edits()[name]
    repack(log, tmp_path / "r.mcap", edit)
    with pytest.raises(LogError, match=message) as caught:
        read(tmp_path / "r.mcap")
    assert "r.mcap" in str(caught.value)


def test_files_that_are_not_logs(log, truth, tmp_path):
    (tmp_path / "empty.mcap").write_bytes(b"")
    (tmp_path / "text.mcap").write_text("time,angle\n0,1\n")
    os.mkfifo(tmp_path / "pipe.mcap")
    with LogWriter(tmp_path / "nothing.mcap", GROUPS):
        pass
    expected = {
        "runn.mcap": r"runn\.mcap does not exist: nearest in that folder: .*nothing\.mcap",
        "no/run.mcap": "there is no folder .*no either",
        "empty.mcap": "is empty",
        "text.mcap": "is not an MCAP file",
        "pipe.mcap": "is not a regular file",
        "nothing.mcap": "contains no samples",
        "x" * 300: "cannot read log|no log",
        ".": "is a folder",
    }
    for name, message in expected.items():
        with pytest.raises(LogError, match=message):
            read(tmp_path / name)
    (tmp_path / "bare").mkdir()
    with pytest.raises(LogError, match=r"no \.mcap file in that folder"):
        read(tmp_path / "bare" / "run.mcap")


def test_existing_log_is_kept_unless_forced(truth, tmp_path):
    path = tmp_path / "run.mcap"
    write(path, truth.select(slice(0, 20)))
    before = path.read_bytes()
    with pytest.raises(LogError, match=r"run\.mcap already exists: .*--force"):
        LogWriter(path, GROUPS)
    assert path.read_bytes() == before
    write(path, truth, force=True)
    assert_same(read(path), truth)
    assert [entry.name for entry in tmp_path.iterdir()] == ["run.mcap"]


def test_forced_log_replaces_the_old_one_only_once_it_has_begun(truth, tmp_path):
    path = tmp_path / "run.mcap"
    write(path, truth)
    before = path.read_bytes()
    big = {"model.xml": bytes(5000)}
    with disk_of(2000), pytest.raises(LogError, match=r"cannot write log .*run\.mcap"):
        LogWriter(path, GROUPS, {}, big, force=True)
    with disk_of(2000), pytest.raises(LogError, match="cannot write log"):
        LogWriter(tmp_path / "new.mcap", GROUPS, {}, big)
    with pytest.raises(TypeError):
        LogWriter(path, GROUPS, {}, {"model.xml": 3}, force=True)
    assert [entry.name for entry in tmp_path.iterdir()] == ["run.mcap"]
    assert path.read_bytes() == before


def test_a_log_does_not_begin_before_zero(tmp_path):
    with LogWriter(tmp_path / "run.mcap", {"/a": [("x", "1")]}) as log:
        with pytest.raises(LogError, match="first sample time, -1 s, is too early: pass times of at least 0 s"):
            log.write(np.array([-1.0, 1.0]), {"/a": np.zeros((2, 1))})
        log.write(np.array([0.0, 1.0]), {"/a": np.zeros((2, 1))})


def test_log_can_be_read_while_it_is_written(truth, tmp_path):
    path = tmp_path / "run.mcap"
    with LogWriter(path, GROUPS, chunk_size=10 * ROW) as log:
        write_samples(log, truth.select(slice(0, 25)))
        assert len(read(path)) == 20
        assert_prefix(read(path), truth)
    assert len(read(path)) == 25


def test_places_where_no_log_can_be_written(tmp_path):
    (tmp_path / "file").write_text("x")
    os.mkfifo(tmp_path / "pipe")
    places = {"file/run.mcap": "Not a directory", "no/run.mcap": "No such file", ".": "not a regular file"}
    for name, message in (places | {"pipe": "not a regular file"}).items():
        for force in (False, True):
            with pytest.raises(LogError, match=message):
                LogWriter(tmp_path / name, GROUPS, force=force)
    assert (tmp_path / "pipe").is_fifo()


def test_full_disk_keeps_the_chunks_before(truth, tmp_path):
    path = tmp_path / "run.mcap"
    with (
        disk_of(12_000),
        pytest.raises(LogError, match=r"run\.mcap: File too large\. Its first (\d+) samples") as caught,
        LogWriter(path, GROUPS, chunk_size=10 * ROW) as log,
    ):
        write_samples(log, truth)
    run = read(path)
    assert 10 <= len(run) < 95
    assert f"first {len(run)} samples" in str(caught.value)
    assert_prefix(run, truth)
    with pytest.raises(LogError, match="is closed"):
        write_samples(log, truth)
    log.close()


def test_full_disk_at_the_very_end_is_reported(truth, tmp_path):
    path = tmp_path / "run.mcap"
    log = LogWriter(path, GROUPS, chunk_size=10 * ROW)
    write_samples(log, truth.select(slice(0, 20)))
    with disk_of(path.stat().st_size), pytest.raises(LogError, match="Its first 20 samples can be read"):
        log.close()
    assert len(read(path)) == 20


def stop(error: BaseException, path: Path, run: Run) -> None:
    with LogWriter(path, GROUPS, chunk_size=10 * ROW) as log:
        write_samples(log, run)
        raise error


@pytest.mark.parametrize("error", [RuntimeError("NaN at 0.3 s"), KeyboardInterrupt()])
def test_exception_closes_the_log_as_incomplete(error, truth, tmp_path):
    path = tmp_path / "run.mcap"
    with pytest.raises(type(error)):
        stop(error, path, truth)
    run = read(path)
    assert_prefix(run, truth)
    assert (len(run), run.complete) == (95, False)
    assert run.note == {"RuntimeError": "RuntimeError: NaN at 0.3 s"}.get(type(error).__name__, "KeyboardInterrupt")


def test_close_states_why_a_run_ended(truth, tmp_path):
    path = tmp_path / "run.mcap"
    with LogWriter(path, GROUPS, {"command": "x \udcff"}) as log:
        write_samples(log, truth)
        log.close("jumped tooth of pin \udc80", complete=False)
        log.close()
    run = read(path)
    assert (run.note, run.complete) == ("jumped tooth of pin \\udc80", False)
    assert run.provenance["command"] == "x \\udcff"
    path.write_bytes(path.read_bytes()[:-1])
    assert read(path).note.startswith("jumped tooth of pin \\udc80; the log is truncated: 95 samples")


@pytest.mark.parametrize(
    ("groups", "message"),
    [
        ({}, "at least one group"),
        ({"/a": [("x", "1")], "/b": [("x", "1")]}, "'x' occurs in /b and in /a"),
        ({"/a": [("x", "1"), ("x", "N")]}, "'x' occurs in /a and in /a"),
        ({"/a": [("time", "s")]}, "'time'"),
        ({"/a": [("gearAngle", "rad")]}, "lower-case letters"),
        ({"reducer": [("x", "1")]}, "topic 'reducer'"),
        ({"/Pins": [("x", "1")]}, "topic '/Pins'"),
    ],
)
def test_names_that_a_log_refuses(groups, message, tmp_path):
    with pytest.raises(LogError, match=message):
        LogWriter(tmp_path / "run.mcap", groups)
    assert not (tmp_path / "run.mcap").exists()


@pytest.mark.parametrize(
    ("time", "shapes", "message"),
    [
        ([1.0, 2.0], {"/a": (2, 1)}, r"topics \['/a'\], but the log .* has \['/a', '/b'\]"),
        ([1.0, 2.0], {"/a": (2, 1), "/b": (2, 3)}, r"/b have shape \(2, 3\): pass an array of shape \(2, 2\)"),
        ([1.0, 2.0], {"/a": (1, 1), "/b": (2, 2)}, r"/a have shape \(1, 1\): pass an array of shape \(2, 1\)"),
        ([[1.0, 2.0]], {"/a": (2, 1), "/b": (2, 2)}, r"shape \(1, 2\)"),
        ([1.0, 1.0], {"/a": (2, 1), "/b": (2, 2)}, "index 1, 1 s, is not later than the time before it, 1 s: pass str"),
        ([0.5, 1.0], {"/a": (2, 1), "/b": (2, 2)}, "first sample time, 0.5 s, is too early: pass times later than 0.5"),
        ([-1.0, 1.0], {"/a": (2, 1), "/b": (2, 2)}, "first sample time, -1 s, is too early: pass times later than 0.5"),
        ([1.0, np.nan], {"/a": (2, 1), "/b": (2, 2)}, "sample time at index 1 is nan: pass finite times"),
    ],
)
def test_samples_that_a_log_refuses_leave_it_unharmed(time, shapes, message, tmp_path):
    path = tmp_path / "run.mcap"
    with LogWriter(path, {"/a": [("x", "1")], "/b": [("y", "1"), ("z", "1")]}) as log:
        log.write(np.array([0.0, 0.5]), {"/a": np.zeros((2, 1)), "/b": np.zeros((2, 2))})
        with pytest.raises(LogError, match=message):
            log.write(np.array(time), {topic: np.ones(shape) for topic, shape in shapes.items()})
        log.write(np.empty(0), {"/a": np.empty((0, 1)), "/b": np.empty((0, 2))})
        log.write(np.array([0.75]), {"/a": np.ones((1, 1)), "/b": np.ones((1, 2))})
    run = read(path)
    np.testing.assert_array_equal(run.block(["x", "y", "z"]), np.repeat([[0.0], [0.0], [1.0]], 3, axis=1))
    assert run.complete
