"""No command replaces what it reads, nor anything else without --force: every command that writes is tried."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from commands import told
from folders import contents
from made_run import made_groups, made_run

from cycloid_mj.base.atomic_write import write_files
from cycloid_mj.base.errors import CycloidError, UsageError
from cycloid_mj.base.overwrite_guard import KINDS, claim_outputs, command_scope
from cycloid_mj.cli import main
from cycloid_mj.cli.app import application
from cycloid_mj.cli.page import commands
from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.mjcf.folder import write_folder
from cycloid_mj.log import LogWriter

LOG = b"\x89MCAP0\r\n another one"
STANDING = {
    ".mcap": LOG,
    ".html": b"<!doctype html><title>another</title>",
    ".json": b'{"design": "another"}',
    ".svg": b"<?xml another",
    ".png": b"\x89PNG another",
    ".gif": b"GIF89a another",
    ".pdf": b"%PDF another",
    ".parquet": b"PAR1 another",
    ".rrd": b"RRF2 another",
    ".toml": b'name = "another"\n',
}
"""What stands there, by ending: of the kind that the command writes, but not its own."""

WRITING = {
    "simulate": ("simulate --design pin --out d", "d/pin.mcap"),
    "log plot": ("log plot run.mcap --out d", "d/fig5_input.png"),
    "report": ("report run.mcap", "run.html"),
    "animate": ("animate run.mcap run.gif --frames 2 --width 200", "run.gif"),
    "render": ("render run.mcap run.png", "run.png"),
    "compare": ("compare pin nonpin --out d", "d/pin-no-load.mcap"),
    "compare logs": ("compare run.mcap other.mcap --out d", "d/compare_curvature.png"),
    "stress": ("stress --design pin --quick --out d", "d/pin.mcap"),
    "stress result": ("stress --log run.mcap --part pin_1 --quick --out d", "d/stress.json"),
    "rate": ("rate --design pin --html page.html", "page.html"),
    "analyze": ("analyze run.mcap --out d", "d/run-analysis.json"),
    "validate": ("validate --only friction --quick --out d", "d/validation.json"),
    "statics": ("statics pin --out d", "d/pin-statics.json"),
    "design check": ("design check pin --out d", "d/pin-check.csv"),
    "datasheet": ("datasheet --design pin --out d", "d/pin-datasheet.pdf"),
    "sweep": ("sweep --vary clearance.cam_um=1,2 --measure mass --out d", "d/sweep.csv"),
    "tolerance": ('tolerance --set tolerance.cam="IT6" --samples 2 --out d', "d/pin-samples.csv"),
    "optimize": ("optimize --vary gear.eccentricity_mm=0.6:1 --minimize mass_kg --out d", "d/best.toml"),
    "reduce": ("reduce --design pin --out d", "d/reducer.json"),
    "calibrate": ("calibrate --design printed --loop loop.csv --out d", "d/printed-calibrated.toml"),
    "compare-bench": ("compare-bench --design pin --te te.csv --out d", "d/pin-te.json"),
    "protocol": ("protocol --design pin --angles 1 --out d", "d/pin-protocol.json"),
    "thermal": ("thermal --design pin --out d", "d/pin-thermal.json"),
    "wear": ("wear --design pin --hours 1 --out d", "d/pin-wear.json"),
    "build": ("build --design pin --out d", "d/scene.xml"),
    "export": ("export --design pin --format dxf --out d", "d/gear.dxf"),
    "design profile": ("design profile --design pin --csv gear.csv", "gear.csv"),
    "design kinematics": ("design kinematics --design pin --csv q.csv --until-s 0.001", "q.csv"),
    "reproduce": ("reproduce --only geometry --out d", "d/reproduce.html"),
    "design new": ("design new my", "my.toml"),
    "log csv": ("log csv run.mcap run.csv --columns gear_x", "run.csv"),
    "log parquet": ("log parquet run.mcap --columns gear_x", "run.parquet"),
    "log repair": ("log repair run.mcap --scene-hz 10", "run-repaired.mcap"),
    "log rerun": ("log rerun run.mcap", "run.rrd"),
    **{
        f"measure {name}": (f"measure {name} --design pin --quick --out d", f"d/{name}-pin.json")
        for name in ("te", "backlash", "lost-motion", "loads", "torque", "efficiency", "vibration")
    },
}
"""Command -> how it is called, and a file that it writes."""

READING = {"app", "view", "doctor", "figures"}
READING |= {"design show", "log info", "log columns", "log layout"}

QUICK = {
    "log plot",
    "report",
    "animate",
    "design profile",
    "design kinematics",
    "design new",
    "log csv",
    "log parquet",
    "log repair",
}
QUICK |= {"export", "sweep"}
"""Commands that run to their end here."""


def called(*argv: str) -> tuple[int, str]:
    """Run a command; return its exit code and what it says on stderr."""
    code, _, err = told(*argv)
    return code, err


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("logs")
    for name, preset in (("run", "pin"), ("other", "nonpin")):
        design = override(PRESETS[preset], ["drive.ramp_s=0", "drive.hold_s=0.08", "load.torque_nm=36"])
        run, groups = made_run(design), made_groups(design)
        topics = {topic: list(units.items()) for topic, units in groups.items()}
        with LogWriter(folder / f"{name}.mcap", topics, run.provenance, run.attachments) as log:
            log.write(run.time, {topic: run.block(list(units)) for topic, units in groups.items()})
    return folder


@pytest.fixture
def here(logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Stand in a folder with two logs and what a bench measured."""
    for name in ("run.mcap", "other.mcap"):
        (tmp_path / name).write_bytes((logs / name).read_bytes())
    steps = [*range(0, 11), *range(9, -11, -1), *range(-9, 11)]
    rows = [f"{0.1 * step},{0.002 * step}" for step in steps]
    (tmp_path / "loop.csv").write_text("torque_output_Nm,deflection_deg\n" + "\n".join(rows) + "\n")
    angles = [f"{angle},{30 if angle % 20 else -30}" for angle in range(0, 400, 10)]
    (tmp_path / "te.csv").write_text("crank_deg,te_arcsec\n" + "\n".join(angles) + "\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def names() -> Iterator[str]:
    """Yield every command, those of groups with the group's name."""
    app = application()
    for name in commands(app):
        inside = commands(app[name])
        yield from (f"{name} {one}" for one in inside) if inside else [name]


def test_every_command_is_listed_as_writing_files_or_not() -> None:
    assert set(names()) == {name for name in WRITING if name not in ("compare logs", "stress result")} | READING


@pytest.mark.parametrize("name", WRITING)
def test_an_existing_file_is_reported_and_not_replaced(name: str, here: Path) -> None:
    words, file = WRITING[name]
    Path(file).parent.mkdir(exist_ok=True)
    Path(file).write_bytes(STANDING.get(Path(file).suffix, b"another"))
    before = contents(here)
    code, err = called(*words.replace('"', "").split())
    assert code == 1, err
    last = err.splitlines()[-1]
    assert last.startswith(f"error: {file} already exists (")
    assert "overwrite it with --force" in last
    assert KINDS.get(Path(file).suffix, KINDS[".csv"]).name in last or Path(file).suffix not in KINDS
    assert contents(here) == before


@pytest.mark.parametrize("name", sorted(QUICK))
def test_force_replaces_results_of_the_same_kind(name: str, here: Path) -> None:
    words, file = WRITING[name]
    old = STANDING.get(Path(file).suffix, b"another")
    Path(file).parent.mkdir(exist_ok=True)
    Path(file).write_bytes(old)
    code, err = called(*words.split(), "--force")
    assert code == 0, err
    assert Path(file).read_bytes() != old


def test_kinds_with_the_same_beginning_are_reported_by_their_names(tmp_path: Path) -> None:
    """A picture and a VTK file are both XML: each may be replaced where --force says so, and is called what it is."""
    for name, kind in (("a.svg", "a picture"), ("a.vtu", "a VTK file")):
        path = tmp_path / name
        path.write_bytes(b'<?xml version="1.0"?> another')
        with command_scope():
            with pytest.raises(CycloidError, match=rf"already exists \({kind} of"):
                claim_outputs(path, force=False)
            claim_outputs(path, force=True)
            write_files({path: b"new"})
        assert path.read_bytes() == b"new"


READ = [
    "log csv run.mcap IT",
    "log parquet run.mcap IT",
    "log repair run.mcap IT --scene-hz 10",
    "log rerun run.mcap IT",
    "report run.mcap --out IT",
    "report run.mcap other.mcap --out IT",
    "animate run.mcap IT --frames 2",
    "render run.mcap IT",
    "rate --design pin --html IT",
    "design profile --design pin --csv IT",
    "design kinematics --design pin --csv IT",
]


@pytest.mark.parametrize("words", READ)
def test_a_log_is_never_replaced_by_files_made_from_it(words: str, here: Path) -> None:
    (here / "d").mkdir()
    os.link("run.mcap", "hard.mcap")
    for name in ("soft.mcap", "soft.csv", "soft.html"):
        Path(name).symlink_to("run.mcap")
    before = contents(here)
    spellings = ("run.mcap", "./d/../run.mcap", "hard.mcap", "soft.mcap", "soft.csv", "soft.html")
    for force, spelling in (("", "run.mcap"), *(("--force", each) for each in spellings)):
        code, err = called(*f"{words.replace('IT', spelling)} {force}".split())
        assert code in (1, 2), (spelling, err)
        assert err.splitlines()[-1].startswith("error: ")
        assert contents(here) == before
        assert Path("soft.csv").is_symlink()


@pytest.mark.parametrize(
    ("words", "file"),
    [
        ("calibrate --design my.toml --loop loop.csv --out .", "pin-calibrated.toml"),
        ("calibrate --design printed --loop loop.csv --out .", "loop.csv"),
        ("optimize --design best.toml --vary gear.eccentricity_mm=0.6:1 --minimize mass_kg --out .", "best.toml"),
        ("sweep --table sweep.csv --measure mass --out .", "sweep.csv"),
        ("rate --design my.toml --html page.html --duty page.html", "page.html"),
        ("design new my --from my.toml", "my.toml"),
        ("tolerance --design pin-worst-1.toml --samples 2 --out .", "pin-worst-1.toml"),
    ],
)
def test_no_input_is_replaced_even_by_force(words: str, file: str, here: Path) -> None:
    for source, name in (("printed", "printed"), ("pin", "best"), ("pin", "my"), ("pin", "pin-worst-1")):
        code, printed, _ = told("design", "show", source)
        assert code == 0
        Path(f"{name}.toml").write_text(printed)
    Path("sweep.csv").write_text("clearance.cam_um\n1\n2\n")
    Path("page.html").write_text("torque_nm,speed_rpm,share\n10,1000,1\n")
    if file == "pin-calibrated.toml":
        Path(file).symlink_to("my.toml")
    if file == "loop.csv":
        Path("printed-calibrated-residuals.csv").symlink_to("loop.csv")
    before = contents(here)
    code, err = called(*words.split(), "--force")
    assert code == 1, err
    assert "this command reads that file" in err.splitlines()[-1]
    assert contents(here) == before


def test_files_of_another_kind_are_never_replaced(here: Path) -> None:
    Path("page.html").write_bytes(LOG)
    Path("table.csv").symlink_to("other.mcap")
    Path("my.toml").write_text('name = "my"\n')
    before = contents(here)
    for words in ("report run.mcap --out page.html", "design profile --design pin --csv table.csv"):
        code, err = called(*words.split(), "--force")
        assert (code, "the existing file is a log" in err) == (1, True), err
    for words in (
        "design profile --design pin --csv my.toml",
        "report run.mcap --out my.csv",
        "log parquet run.mcap a.mcap",
        "log repair run.mcap my.toml --scene-hz 10",
    ):
        code, err = called(*words.split(), "--force")
        assert (code, "the extension ." in err) == (2, True), err
    assert contents(here) == before


def test_a_command_that_claims_nothing_replaces_nothing(tmp_path: Path) -> None:
    old = tmp_path / "old.csv"
    write_files({old: b"old"})
    with command_scope(), pytest.raises(CycloidError, match="already exists"):
        write_files({old: b"new"})
    with command_scope():
        write_files({tmp_path / "new.csv": b"first"})
        write_files({tmp_path / "new.csv": b"second"})
    with pytest.raises(UsageError, match="is reserved for logs"):
        write_files({tmp_path / "new.mcap": b"no log"})
    assert contents(tmp_path) == {"old.csv": b"old", "new.csv": b"second"}


def test_a_sweep_continues_in_its_folder_and_begins_anew_by_force(here: Path) -> None:
    words = ["sweep", "--vary", "clearance.cam_um=1,2", "--measure", "mass", "--out", "d"]
    assert called(*words)[0] == 0
    first = Path("d/sweep.rows.jsonl").read_bytes()
    assert called(*words)[0] == 0
    assert Path("d/sweep.rows.jsonl").read_bytes() == first
    code, err = called(*[word.replace("1,2", "3,4") for word in words])
    assert (code, "overwrite it with --force" in err) == (2, True)
    assert called(*[word.replace("1,2", "3,4") for word in words], "--force")[0] == 0
    assert b"3.0" in Path("d/sweep.csv").read_bytes()


def test_a_command_that_fails_leaves_no_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(files: object) -> None:
        raise CycloidError("no space left")

    monkeypatch.chdir(tmp_path)
    (tmp_path / "there").mkdir()
    monkeypatch.setattr("cycloid_mj.cli.delivery.write_files", failing)
    for out in ("new/deeper", "there"):
        assert main(["design", "show", "pin", "--out", out]) == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["there"]


def test_a_model_that_cannot_be_written_leaves_no_empty_assets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Called from Python, without a command that clears up."""
    (tmp_path / "scene.xml").mkdir()
    with pytest.raises(CycloidError):
        write_folder({"assets/a.obj": b"a", "scene.xml": b"b"}, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["scene.xml"]
    (tmp_path / "assets").mkdir()
    (tmp_path / "assets" / "old.obj").write_bytes(b"old")
    with pytest.raises(CycloidError):
        write_folder({"assets/a.obj": b"a", "scene.xml": b"b"}, tmp_path)
    assert [path.name for path in (tmp_path / "assets").iterdir()] == ["old.obj"]
