"""The one way out of results: to the terminal, as JSON, as a page and as files."""

import csv
import json
from collections.abc import Callable
from pathlib import Path

import pytest

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.outcome import MOST_FIGURES, Outcome
from cycloid_mj.base.result import Table
from cycloid_mj.cli import main
from cycloid_mj.cli.delivery import TEXT, claim_destination, deliver
from cycloid_mj.cli.flags import Delivery

TABLE = Table("all of it", ("what", "number"), tuple((f"row {number}", float(number)) for number in range(40)))


def outcome(**changes: object) -> Outcome:
    parts: dict[str, object] = {"title": "tried: pin", "condition": "9 N m", "result": {"key": 1.0}}
    return Outcome(**(parts | changes))  # type: ignore[arg-type]


@pytest.fixture
def printed(capsys: pytest.CaptureFixture[str]) -> Callable[..., list[str]]:
    """Deliver an outcome to the terminal; return the lines."""

    def lines(found: Outcome, **flags: bool) -> list[str]:
        wanted = Delivery(**flags)  # type: ignore[arg-type]
        deliver(found, claim_destination(wanted, "stem"), wanted)
        return capsys.readouterr().out.splitlines()

    return lines


def test_headline_failures_and_warnings_come_first_and_the_rest_with_all(printed: Callable[..., list[str]]) -> None:
    found = outcome(
        headline={f"figure {number}": "1 mm" for number in range(MOST_FIGURES)},
        failures=["it breaks"],
        warnings=[f"reason {number}" for number in range(50)],
        passes=["it turns"],
        tables=[TABLE],
        notes=["assumed: steel"],
        summary=["51 checks"],
    )
    short, whole = printed(found), printed(found, all=True)
    assert len(short) <= TEXT.max_lines
    assert short[0].rstrip() == "tried: pin, 9 N m"
    first = short.index("FAIL  it breaks")
    assert all(f"figure {number} " in "".join(short[:first]) for number in range(MOST_FIGURES))
    assert short[first + 1] == "warn  reason 0"
    assert short[-2:] == ["--all also shows 45 more warnings, 1 passed check, 40 table rows, 1 note", "51 checks"]
    assert not any("row 3" in line or "steel" in line for line in short)
    assert {"warn  reason 49", "ok    it turns", "assumed: steel", "51 checks"} <= set(whole)
    assert sum("row " in line for line in whole) == len(TABLE.rows)


def test_many_files_are_counted_by_folder_and_few_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "out" / "figures").mkdir(parents=True)
    for count, told in ((2, "wrote out/figures/0.png, out/figures/1.png, out/stem.json\n"), (40, None)):
        files = {f"figures/{number}.png": b"" for number in range(count)}
        wanted = Delivery(out="out", force=True)
        deliver(outcome(files=files), claim_destination(wanted, "stem"), wanted)
        assert capsys.readouterr().err == (told or "wrote 40 files in out/figures, 1 file in out\n")


def test_no_failure_is_left_out(printed: Callable[..., list[str]]) -> None:
    lines = printed(outcome(failures=[f"part {number}" for number in range(60)], warnings=list("abcde")))
    assert sum(line.startswith("FAIL") for line in lines) == 60
    assert sum(line.startswith("warn") for line in lines) == 3


def test_a_headline_is_a_dozen_figures_at_most() -> None:
    with pytest.raises(ValueError, match="at most 12"):
        outcome(headline={str(number): "1" for number in range(MOST_FIGURES + 1)})


def test_files_are_what_was_requested(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    found = outcome(pictures={"drawn": lambda form: f"<{form}>".encode()}, files={"more.txt": b"more"})
    for wanted, names in (
        (Delivery(), set()),
        (Delivery(html=()), {"runs/stem.html"}),
        (Delivery(html=("mine.html",)), {"mine.html"}),
        (Delivery(out="d"), {"d/stem.json", "d/drawn.png", "d/drawn.svg", "d/more.txt"}),
        (Delivery(out="e", html=()), {"e/stem.json", "e/drawn.png", "e/drawn.svg", "e/more.txt", "e/stem.html"}),
    ):
        before = set(tmp_path.rglob("*.*"))
        assert deliver(found, claim_destination(wanted, "stem"), wanted) == 0
        assert {path.relative_to(tmp_path).as_posix() for path in set(tmp_path.rglob("*.*")) - before} == names
    assert json.loads(Path("d/stem.json").read_text())["key"] == 1.0
    assert "<h1>cycloid_mj: tried: pin</h1>" in Path("mine.html").read_text()


def test_results_replace_no_others_without_force(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    argv = ("statics", "pin", "--out", str(tmp_path), "--quiet", "--json")
    assert main(list(argv)) == 0
    assert main(list(argv)) == 1
    assert "pin-statics.json already exists" in capsys.readouterr().err
    assert main([*argv, "--force"]) == 0


@pytest.mark.parametrize("html", [("a.html", "b.html"), ("pin",), ("page.toml",)])
def test_the_name_of_a_page_ends_in_html(html: tuple[str, ...]) -> None:
    with pytest.raises(UsageError, match="html"):
        claim_destination(Delivery(html=html), "stem")


def test_a_page_that_cannot_be_written_is_reported_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def work(*_: object, **__: object) -> None:
        raise AssertionError

    monkeypatch.setattr("cycloid_mj.life.heat_and_strength.thermal_of", work)
    assert main(["thermal", "pin", "--html", str(tmp_path / "missing" / "page.html")]) == 1
    assert f"there is no folder {tmp_path / 'missing'}. Create it" in capsys.readouterr().err
    (tmp_path / "folder.html").mkdir()
    assert main(["thermal", "pin", "--html", str(tmp_path / "folder.html")]) == 1
    assert "it is not a regular file. Choose another file name" in capsys.readouterr().err


def test_csv_has_every_digit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["statics", "pin", "--out", str(tmp_path), "--json", "--quiet"]) == 0
    figures = json.loads(capsys.readouterr().out)["quantities"]
    with (tmp_path / "pin-statics.csv").open(newline="") as stream:
        rows = {row["key"]: row for row in csv.DictReader(stream)}
    assert list(rows) == list(figures)
    assert all(float(rows[key]["value"]) == one["value"] for key, one in figures.items() if one["value"] is not None)
    assert json.loads((tmp_path / "pin-statics.json").read_text())["quantities"] == figures


@pytest.mark.parametrize("command", [("statics",), ("rate",), ("design", "check")])
def test_the_terminal_shows_some_25_lines(command: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*command, "pin"]) == 0
    short = capsys.readouterr().out.splitlines()
    assert main([*command, "pin", "--all"]) == 0
    assert len(short) <= TEXT.max_lines < len(capsys.readouterr().out.splitlines())


WRITING = [
    *(("figures",), ("design", "show", "pin"), ("design", "new", "my")),
    *(("design", "profile", "pin", "--csv", "-"), ("design", "kinematics", "pin", "--csv", "-", "--until-s", "0.01")),
]


@pytest.mark.parametrize("words", WRITING, ids=" ".join)
def test_commands_that_write_files_or_lists_take_the_same_flags(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main([*words, "--json", "--quiet", "--all", "--workers", "1", "--html", "page.html"]) == 0
    out, err = capsys.readouterr()
    assert (err, isinstance(json.loads(out), dict)) == ("", True)
    assert Path("page.html").read_text().startswith("<!doctype html")
    assert main([*words, "--json", "--quiet", "--html", "page.html"]) == 1
    assert "already exists" in capsys.readouterr().err


def test_columns_are_json_without_a_file_and_show_ranges_with_all(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    motion = ("design", "kinematics", "pin", "--until-s", "0.01", "--step-s", "0.005", "--csv")
    assert main([*motion, "-", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["rows"], told["values"]["t_s"]) == (3, [0.0, 0.005, 0.01])
    file = tmp_path / "q.csv"
    assert main([*motion, str(file), "--json", "--quiet"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["files"], told["rows"], "values" in told) == ([str(file)], 3, False)
    assert main([*motion, str(file), "--force", "--all"]) == 0
    out, err = capsys.readouterr()
    assert "3 rows of 8 columns" in out
    assert err == f"wrote 3 rows of 8 columns to {file}\n"


def test_a_new_design_is_written_to_its_folder_and_a_shown_design_to_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["design", "new", "my", "--out", "designs"]) == 0
    assert capsys.readouterr().out == "designs/my.toml\n"
    assert main(["design", "show", "designs/my.toml", "--out", "shown"]) == 0
    assert capsys.readouterr().out == Path("shown/my.toml").read_text()
    assert json.loads(Path("shown/my-design.json").read_text())["name"] == "my"


@pytest.mark.parametrize(
    ("words", "taken"),
    [
        (("statics", "pin", "--load-nm", "0", "--out", "."), "pin-statics.json"),
        (("rate", "pin", "--life-h", "-1", "--out", "."), "pin-rating.json"),
        (("analyze", "run.mcap", "--q", "here", "--out", "."), "run-analysis.json"),
        (("design", "profile", "pin", "--part", "ring", "--csv", "x.csv"), "x.csv"),
        (("design", "kinematics", "pin", "--until-s", "1e6", "--csv", "x.csv"), "x.csv"),
        (("animate", "run.mcap", "x.gif", "--fps", "99"), "x.gif"),
        (("design", "new", "my", "--discs", "2"), "my.toml"),
    ],
    ids=lambda value: value if isinstance(value, str) else value[0],
)
def test_wrong_usage_is_reported_before_an_existing_file(
    words: tuple[str, ...], taken: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path(taken).write_text("{}")
    assert main(list(words)) == 2
