"""One script lists every figure that the documentation prints, tells when it is stale, and writes it anew."""

import json
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import docs_figures
import pytest

ROOT = Path(__file__).parent.parent


@pytest.fixture
def made(monkeypatch, tmp_path: Path) -> ModuleType:
    """Return the script in a folder of its own, with one artefact of two steps, and a probe."""
    copy = (sys.executable, "-c", "import sys; open('runs', 'a').write(sys.argv[1]); print(sys.argv[1])")
    join = "import sys, pathlib; a, b = map(pathlib.Path, sys.argv[1:]); "
    join += "pathlib.Path('out').write_text(a.read_text() + b.read_text())"
    both = {"a": docs_figures.Step((*copy, "1"), stdout=True), "b": docs_figures.Step((*copy, "2"), stdout=True)}
    one = docs_figures.Artefact(("out",), both, ((sys.executable, "-c", join, "{a}", "{b}"),), ("probe",), 0.1)
    monkeypatch.setattr(docs_figures, "ROOT", tmp_path)
    monkeypatch.setattr(docs_figures, "STAMPS", tmp_path / "figures.json")
    monkeypatch.setattr(docs_figures, "SCRATCH", tmp_path / "scratch")
    monkeypatch.setattr(docs_figures, "ARTEFACTS", {"one": one})
    monkeypatch.setattr(docs_figures, "probe_values", lambda _: docs_figures.now)
    monkeypatch.setattr(sys, "argv", ["docs_figures.py"])
    docs_figures.now = {"force": 100.0, "word": "as it was"}
    return docs_figures


@pytest.mark.parametrize(
    "name",
    [
        *("picture", "doors", "report", "datasheet", "app", "validation", "solvers", "models", "measured", "compared"),
        *("paper", "authors"),
        *(pytest.param(name, marks=pytest.mark.slow) for name in ("tutorial", "market")),
    ],
)
def test_printed_figures_are_those_of_the_present_model(name: str) -> None:
    """Where this fails: `python scripts/docs_figures.py --list` says by how much, without --list it writes it anew."""
    assert docs_figures.stale(docs_figures.ARTEFACTS[name], docs_figures.stamps().get(name)) == []


def test_the_script_lists_all_that_is_generated() -> None:
    """Pictures and marked sections of the pages; `_drawings` are drawn with the pages."""
    listed = {name for artefact in docs_figures.ARTEFACTS.values() for name in artefact.files}
    commands = [" ".join(command) for artefact in docs_figures.ARTEFACTS.values() for command in artefact.last]
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        text = page.read_text(encoding="utf-8")
        for picture in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text):
            if not picture.startswith(("_drawings/", "http", "../../actions/")):
                assert str((page.parent / picture).resolve().relative_to(ROOT)) in listed, picture
        for writer in re.findall(r"<!-- Begin of \w+: (\S+) writes", text):
            assert any(writer in command for command in commands), writer
    assert set(docs_figures.stamps()) <= set(docs_figures.ARTEFACTS)
    assert {name for artefact in docs_figures.ARTEFACTS.values() for name in artefact.probes} == set(
        docs_figures.PROBES
    )


def test_an_artefact_is_stale_if_its_printed_values_have_changed(made: ModuleType, tmp_path: Path, capsys) -> None:
    one = made.ARTEFACTS["one"]
    assert "no stamp" in made.stale(one, None)[0]
    assert made.main() == 0
    assert (tmp_path / "out").read_text() == "1\n2\n"
    kept = made.stamps()["one"]
    assert made.stale(one, kept) == []
    made.now = {"force": 100.0 * (1.0 + 0.5 * made.TOLERANCE), "word": "as it was"}
    assert made.stale(one, kept) == []
    made.now = {"force": 101.0, "word": "another"}
    assert made.stale(one, kept) == ["probe, force: 100, now 101", "probe, word: as it was, now another"]
    made.now = {"force": 100.0, "word": "as it was"}
    (tmp_path / "out").write_text("edited")
    assert made.stale(one, kept) == ["out is not what the stamp is of"]
    capsys.readouterr()
    sys.argv.append("--list")
    assert made.main() == 0
    assert capsys.readouterr().out.startswith("one: out is not what the stamp is of (0.1 min of CPU)")


def test_finished_steps_are_repeated_only_if_the_model_has_changed(
    made: ModuleType, tmp_path: Path, monkeypatch
) -> None:
    """Stopped after the first step: the same command goes on; a model that says otherwise begins anew."""
    begun, run = [], subprocess.run

    def stopped(*given, **more):
        begun.append(given)
        if len(begun) == 2:
            raise KeyboardInterrupt
        return run(*given, **more)

    monkeypatch.setattr(made.subprocess, "run", stopped)
    assert made.main() == 1
    assert not made.STAMPS.exists()
    assert made.main() == 0
    assert (tmp_path / "runs").read_text() == "12"
    assert not (tmp_path / "scratch" / "one").exists()
    assert made.main() == 0
    assert (tmp_path / "runs").read_text() == "12"
    begun.clear()
    made.now = {"force": 200.0}
    assert made.main() == 1
    made.now = {"force": 300.0}
    assert made.main() == 0
    assert (tmp_path / "runs").read_text() == "12112"
    assert json.loads(made.STAMPS.read_text())["one"]["probes"]["probe"] == {"force": 300.0}


def test_an_artefact_that_fails_stops_no_other(made: ModuleType, tmp_path: Path, capsys) -> None:
    broken = made.Artefact(("none",), {"a": made.Step((sys.executable, "-c", "exit(3)"))}, (), ("probe",), 0.1)
    made.ARTEFACTS.update({"one": broken, "two": made.ARTEFACTS["one"]})
    assert made.main() == 1
    assert list(made.stamps()) == ["two"]
    told = capsys.readouterr().err
    assert "error: one: " in told
    assert "1 written, 1 failed (one)" in told


def test_pages_print_no_place_of_this_machine(made: ModuleType, tmp_path: Path) -> None:
    """A report names its logs: the last commands are handed paths from the root of the repository."""
    one = made.ARTEFACTS["one"]
    write = (sys.executable, "-c", "import sys, pathlib; pathlib.Path('out').write_text(sys.argv[1])", "{a}/pin.mcap")
    made.ARTEFACTS["one"] = made.Artefact(one.files, one.steps, (write,), one.probes, one.minutes)
    assert made.main() == 0
    assert (tmp_path / "out").read_text() == "scratch/one/a/pin.mcap"


@pytest.mark.slow
def test_the_moving_picture_is_replaced(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    import picture

    monkeypatch.setattr(picture, "LENGTH", ("--hold-s", "0.012"))
    monkeypatch.setattr(picture, "LOOK", ("--frames", "2", "--width", "200"))
    path = tmp_path / "mechanism.gif"
    path.write_bytes(b"GIF89a of an earlier one")
    assert picture.animation(path) == 0
    assert path.stat().st_size > 1000
