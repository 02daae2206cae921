"""Logs and designs made to harm: each is refused, or read as far as it goes, in one clear line and bounded room."""

import json
import tracemalloc
import zlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard
from commands import told
from designs import unlike
from made_run import made_groups, made_run
from mcap.data_stream import RecordBuilder
from mcap.records import Chunk

from cycloid_mj.base.errors import DesignError, LogError
from cycloid_mj.base.record import Run
from cycloid_mj.base.text import MESSAGE
from cycloid_mj.cli.terminal import printable, tell
from cycloid_mj.design import PRESETS, Design, dump, loads, override
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.mjcf.model import xml
from cycloid_mj.dynamics.run import model_for, simulate
from cycloid_mj.log import LogWriter, read
from cycloid_mj.log import write as write_run
from cycloid_mj.log.container import CHUNK, decompress
from cycloid_mj.reducer import reducer_of

RUN = ["drive.ramp_s=0", "drive.hold_s=0.08", "load.torque_nm=36"]
DESIGNS = {name: override(PRESETS[name], RUN) for name in ("pin", "nonpin")}
RV80E = override(PRESETS["rv80e"], ["drive.ramp_s=0", "drive.hold_s=0.004"])


def write(
    path: Path,
    design: Design,
    edit: Callable[[dict[str, np.ndarray]], None] = lambda columns: None,
    inside: Design | None = None,
    samples: int = 800,
) -> None:
    """Write a log of a made run whose columns are edited, with the design file of `inside`."""
    run = made_run(design, samples, attachments={"model.xml": xml(build(design).spec).encode()})
    columns = {name: values.copy() for name, values in run.columns.items()}
    edit(columns)
    files = {**run.attachments, "design.toml": dump(inside or design).encode()}
    groups = made_groups(design)
    with LogWriter(path, {topic: list(units.items()) for topic, units in groups.items()}, run.provenance, files) as log:
        tables = {topic: [columns[name] for name in units] for topic, units in groups.items()}
        log.write(run.time, {topic: np.stack(table, axis=1) for topic, table in tables.items()})


@pytest.fixture(scope="module")
def rv_run() -> Run:
    """A short run of an RV reducer by the planar solver: `made_run` has the motion of a central crank."""
    return simulate(RV80E, model_for("planar", reducer_of(RV80E)))


# --- chunks -----------------------------------------------------------------------------------------------------------


def chunk_record(data: bytes, size: int, crc: int, compression: str = "zstd") -> bytes:
    builder = RecordBuilder()
    Chunk(compression, data, 0, 0, crc, size).write(builder)
    return builder.end()


def bombed(path: Path, chunk: bytes) -> None:
    """Write a log that goes on, after its attachments, with a chunk."""
    with LogWriter(path, {"/a": [("x", "1")]}):
        pass
    content = path.read_bytes()
    path.write_bytes(content[: content.index(b"cycloid_mj.end") - 13] + chunk)


@pytest.mark.parametrize("compression", ["zstd", "lz4", ""])
@pytest.mark.parametrize("says", [1000, 10**7 - 1, 10**7 + 1])
def test_a_chunk_larger_than_its_stated_size_is_not_inflated(compression, says, tmp_path):
    true = 10**7
    compressors = {"zstd": zstandard.ZstdCompressor().compress, "lz4": lz4.frame.compress, "": bytes}
    data = compressors[compression](bytes(true))
    path = tmp_path / "bomb.mcap"
    bombed(path, chunk_record(data, says, zlib.crc32(bytes(true)), compression))
    with pytest.raises(LogError, match=rf"malformed chunk .*its size is not the stated {says:,} bytes"):
        read(path)
    if compression:
        tracemalloc.start()
        with pytest.raises(ValueError, match="is not the stated"):
            decompress(data, compression, 1000)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < 10**6


def test_chunk_beyond_the_limit_is_refused_unread(tmp_path):
    path = tmp_path / "bomb.mcap"
    bombed(path, chunk_record(b"", CHUNK.max_size + 1, 0))
    with pytest.raises(LogError, match=r"its stated size is 1,073,741,825 bytes; the limit is 1,073,741,824"):
        read(path)


@pytest.mark.parametrize(
    "content",
    [
        bytes(10**6),  # 145 s for each GB of such records of no kind and no length
        b"\x80" + bytes(8) + bytes(10**6),
        b"\x05" + (4).to_bytes(8, "little") + bytes(10**6),  # a message without room for its own head
        b"\x0f" + bytes(10**6),
    ],
)
def test_an_empty_chunk_is_refused_at_its_first_record(content, tmp_path):
    path = tmp_path / "zeros.mcap"
    bombed(path, chunk_record(zstandard.compress(content), len(content), zlib.crc32(content)))
    with pytest.raises(LogError, match="there is no valid schema, channel or message at its byte 0"):
        read(path)


@pytest.mark.parametrize("compression", ["zstd", pytest.param("lz4", marks=pytest.mark.slow)])
def test_chunk_of_countless_empty_messages_is_refused_by_counting(compression, tmp_path):
    """Without a count, 23 million of them took 66 s and 3.3 GB, from a file of 67 kB."""
    empty = b"\x05" + (22).to_bytes(8, "little") + bytes(22)
    content = empty * 3_000_000
    data = {"zstd": zstandard.compress, "lz4": lz4.frame.compress}[compression](content)
    path = tmp_path / "countless.mcap"
    bombed(path, chunk_record(data, len(content), zlib.crc32(content), compression))
    tracemalloc.start()
    with pytest.raises(LogError, match=rf"more than {4 * len(data):,} messages in {len(data):,} compressed bytes"):
        read(path)
    assert tracemalloc.get_traced_memory()[1] < 2e7
    tracemalloc.stop()


def test_a_chunk_with_a_long_constant_message_is_accepted(tmp_path):
    """A chunk that inflates a thousand times is read, as long as it has few messages."""
    long = b"\x05" + (22 + 5_000_000).to_bytes(8, "little") + bytes(22 + 5_000_000)
    content = long + long
    path = tmp_path / "long.mcap"
    bombed(path, chunk_record(zstandard.compress(content), len(content), zlib.crc32(content)))
    with pytest.raises(LogError, match="contains no samples"):
        read(path)


def test_chunk_of_an_unknown_compression_is_refused(tmp_path):
    path = tmp_path / "odd.mcap"
    bombed(path, chunk_record(b"abc", 3, zlib.crc32(b"abc"), "brotli"))
    with pytest.raises(LogError, match="compression 'brotli' is not supported; zstd and lz4 are"):
        read(path)


# --- a design of another run ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def foreign(tmp_path_factory, rv_run: Run) -> dict[str, Path]:
    """Logs with the design file of another run: fewer ring pins, more, another kind of ring, other output pins.

    The last is the log of an RV reducer.
    """
    folder, pin = tmp_path_factory.mktemp("foreign"), DESIGNS["pin"]
    insides = {
        "12 ring pins, but the log contains forces for 36": (pin, override(pin, ["ring.teeth=12"])),
        "36 ring pins, but the log contains forces for 7": (unlike("few"), pin),
        "0 ring pins, but the log contains forces for 36": (pin, DESIGNS["nonpin"]),
        "5 output pins, but the log contains forces for 8": (pin, override(pin, ["output.pins=5"])),
    }
    for number, (design, inside) in enumerate(insides.values()):
        write(folder / f"{number}.mcap", design, inside=inside)
    logs = {words: folder / f"{number}.mcap" for number, words in enumerate(insides)}
    logs["36 ring pins, but the log contains forces for 40"] = folder / "rv80e.mcap"
    files = {**rv_run.attachments, "design.toml": dump(override(RV80E, ["ring.teeth=36"])).encode()}
    write_run(replace(rv_run, attachments=files), folder / "rv80e.mcap")
    return logs


@pytest.mark.parametrize(
    "argv",
    [
        ("analyze", "RUN"),
        ("log", "plot", "RUN", "--out", "DIR"),
        ("report", "RUN", "--out", "DIR/run.html"),
        ("animate", "RUN", "DIR/run.gif"),
        ("render", "RUN", "DIR/run.png"),
        ("compare", "RUN", "RUN", "--out", "DIR"),
        ("log", "layout", "RUN"),
        ("log", "repair", "RUN", "DIR/new.mcap", "--scene-hz", "10"),
        ("stress", "--log", "RUN", "--out", "DIR"),
    ],
    ids=lambda argv: " ".join(argv[:2]).removesuffix(" RUN"),
)
def test_design_of_another_run_is_one_error(argv, foreign, tmp_path):
    for words, path in foreign.items():
        code, out, err = told(*(word.replace("RUN", str(path)).replace("DIR", str(tmp_path)) for word in argv))
        assert (code, out) == (1, "")
        assert f"has {words}" in err
        assert err.startswith("error: ")
        assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_cut_log_with_the_design_of_another_run_is_repaired_without_a_scene(foreign, tmp_path):
    whole = next(iter(foreign.values()))
    cut, new = tmp_path / "cut.mcap", tmp_path / "new.mcap"
    cut.write_bytes(whole.read_bytes()[:-100])
    code, _, err = told("log", "repair", cut, new)
    assert code == 0
    assert "note: the new log has no 3-D scene: the design.toml attached to log" in err
    assert len(read(new)) == 800


# --- numbers ----------------------------------------------------------------------------------------------------------


def setting(value: float, words: str = "", first: int = 0) -> Callable[[dict[str, np.ndarray]], None]:
    def edit(columns: dict[str, np.ndarray]) -> None:
        for name, values in columns.items():
            if words in name:
                values[first:] = value

    return edit


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "edit"),
    [
        ("pin", setting(1e308)),
        ("nonpin", setting(-1e308, first=500)),
        ("pin", setting(np.inf, "pin_1_force")),
        ("rv80e", setting(1e308)),
        ("rv80e", setting(-np.inf, "crank_2_force", first=50)),
    ],
    ids=["all", "late", "infinite", "RV reducer, all", "RV reducer, infinite"],
)
def test_huge_numbers_are_no_warnings(name, edit, rv_run, tmp_path):
    """Every warning of numpy's is an error here (pyproject.toml)."""
    path = tmp_path / "huge.mcap"
    if name == "rv80e":
        columns = {key: values.copy() for key, values in rv_run.columns.items()}
        edit(columns)
        topics = {topic: [(key, rv_run.units[key]) for key in keys] for topic, keys in rv_run.topics.items()}
        tables = {topic: np.stack([columns[key] for key in keys], axis=1) for topic, keys in rv_run.topics.items()}
        with LogWriter(path, topics, rv_run.provenance, rv_run.attachments) as log:
            log.write(rv_run.time, tables)
    else:
        write(path, DESIGNS[name], edit)
    for argv in (
        ("analyze", path),
        ("report", path, "--out", tmp_path / "run.html"),
        ("animate", path, tmp_path / "run.gif", "--frames", "2", "--width", "200"),
        ("log", "repair", path, tmp_path / "new.mcap", "--scene-hz", "10", "--force"),
        ("log", "info", path),
    ):
        code, _, err = told(*argv)
        assert code == 0 or (code, err.count("\n")) == (1, 1), err


# --- words ------------------------------------------------------------------------------------------------------------

CODES = "\x1b[31m\x1b]0;title\x07\r\x08\x7f\x9b\u202e\u2028"


def test_control_codes_are_shown_and_not_obeyed(tmp_path):
    path, key = tmp_path / f"{CODES}.mcap", tmp_path / "key.toml"
    with LogWriter(path, {"/a": [("x", CODES)]}, {CODES: CODES}, {CODES: b""}) as log:
        log.write(np.zeros(1), {"/a": np.zeros((1, 1))})
        log.close(note=CODES, complete=False)
    key.write_text(f"[gear]\n{json.dumps(CODES)} = 1\n")
    commands = {
        ("log", "info", path): 0,
        ("log", "columns", path): 0,
        ("log", "csv", path): 0,
        ("analyze", path): 1,
        ("report", path): 1,
        ("compare", path, path): 1,
        ("design", "check", key): 1,
        ("simulate", "--design", "pin", "--set", f"{CODES}=1"): 2,
        ("simulate", "--design", CODES): 2,
        ("log", "plot", "no.mcap", f"--{CODES}"): 2,
        (CODES,): 2,
    }
    for argv, expected in commands.items():
        code, out, err = told(*argv)
        assert code == expected, (argv, err)
        for text in (out, err):
            assert text == printable(text)
        if expected == 2:
            assert "x1b" in err


def test_readable_text_is_printed_unchanged():
    text = "Hsieh, 謝: ω_c = 2 ω_i\n\t± 1 µm"
    assert printable(text) == text
    assert printable("\x1b[0m\x00\udcff") == "\\x1b[0m\\x00\\udcff"


def test_long_messages_are_cut_short(capsys):
    tell("x" * 10**6)
    err = capsys.readouterr().err
    assert len(err) < MESSAGE.message + 100
    tell("two words " * 10**5)
    err = capsys.readouterr().err
    assert "characters left out)..." in err
    assert len(err) < MESSAGE.message + 100


def test_the_first_of_many_wrong_values_are_named_and_the_others_counted():
    with pytest.raises(DesignError) as caught:
        loads("[errors]\npin_x_um = [" + '"a", ' * 20_000 + "]")
    message = str(caught.value)
    assert 'errors.pin_x_um[1] = "a"' in message
    assert 'errors.pin_x_um[5] = "a"' in message
    assert message.endswith("; and 19,995 more")
    assert len(caught.value.details) == 6
    assert len(message) < 1000


def test_a_list_for_more_parts_than_allowed_is_refused():
    with pytest.raises(DesignError, match=r"ring\.teeth = 10000000 is not allowed: it must be from 4 to 400"):
        loads("[ring]\nteeth = 10_000_000\n[errors]\npin_x_um = {1 = 2.0}\n")


# --- names ------------------------------------------------------------------------------------------------------------

ODD = "odd\udcff"
"""A name with a byte that is no UTF-8, as Python has it."""


def test_names_that_are_not_utf8_are_names_and_reported_as_escapes(tmp_path):
    log, design = tmp_path / f"{ODD}.mcap", tmp_path / f"{ODD}.toml"
    write(log, DESIGNS["pin"], samples=200)
    design.write_text(dump(DESIGNS["pin"]))
    sweep = (
        "sweep",
        "--design",
        design,
        "--vary",
        "clearance.cam_um=1,2",
        "--measure",
        "mass",
        "--out",
        tmp_path / ODD,
    )
    short = (design, "--solver", "planar", "--ramp-s", "0", "--hold-s", "0.002")
    written = {
        ("report", log, "--out", tmp_path / f"{ODD}.html"): tmp_path / f"{ODD}.html",
        ("log", "parquet", log, tmp_path / f"{ODD}.parquet"): tmp_path / f"{ODD}.parquet",
        ("log", "csv", log, tmp_path / f"{ODD}.csv"): tmp_path / f"{ODD}.csv",
        sweep: tmp_path / ODD / "sweep.csv",
        ("analyze", log): log,
        ("simulate", *short, "--out", tmp_path / f"{ODD}-run"): tmp_path / f"{ODD}-run" / "pin-review.html",
        ("statics", design, "--out", tmp_path / f"{ODD}-sheet", "--html", tmp_path / f"{ODD}-sheet.html"): (
            tmp_path / f"{ODD}-sheet.html"
        ),
    }
    for argv, path in written.items():
        code, out, err = told(*argv)
        assert code == 0, (argv, err)
        assert path.stat().st_size
        assert "\udcff" not in out + err
    te = tmp_path / f"{ODD}-te.csv"
    te.write_text("crank_deg,te_arcsec\n" + "".join(f"{angle},{angle % 7}\n" for angle in range(0, 400, 10)))
    code, out, err = told("compare-bench", "pin", "--te", te, "--out", tmp_path / f"{ODD}-bench")
    assert code == 0, err
    assert (tmp_path / f"{ODD}-bench" / f"pin-{ODD}-te.png").stat().st_size
    code, _, err = told("report", tmp_path / f"no-{ODD}.mcap")
    assert (code, err.count("\n")) == (2, 1)
    assert "odd\\udcff" in err


@pytest.mark.slow
def test_loops_whose_names_are_no_utf8_are_reported_in_the_residuals(tmp_path):
    loop = Path(__file__).parents[1] / "data" / "bench" / "play_loop.csv"
    first, *rows = loop.read_text().splitlines()
    (tmp_path / f"{ODD}.csv").write_text("\n".join([first, *rows[::8]]))
    argv = ("calibrate", "printed", "--loop", tmp_path / f"{ODD}.csv", "--fit", "drag", "--out", tmp_path / "fit")
    code, _, err = told(*argv)
    assert "Traceback" not in err
    assert code == 0, err
    assert "odd\\udcff," in (tmp_path / "fit" / "printed-calibrated-residuals.csv").read_text()


def test_a_newline_in_a_key_of_a_design_file_leaves_one_line(tmp_path):
    path = tmp_path / "key.toml"
    for text in ('"a\\nb" = 1\n', '[gear]\n"a\\nb" = 1\n', '["a\\nb"]\nc = 1\n'):
        path.write_text(text)
        code, _, err = told("design", "check", path)
        assert (code, err.count("\n")) == (1, 1), err
        assert "a\\nb" in err
