"""What reaches the terminal: no control characters, one clear error for each bad file, and any encoding or width."""

import ast
import os
import random
import signal
import subprocess
import sys
import time
import unicodedata
from collections.abc import Iterator
from pathlib import Path

import pytest
from commands import told
from designs import cases

import cycloid_mj
from cycloid_mj.base.errors import CycloidError, DesignError, UsageError
from cycloid_mj.base.interrupt import Stopped, exit_code
from cycloid_mj.base.text import MESSAGE, legible, shorten
from cycloid_mj.cli.process import SUBSTITUTES, SUBSTITUTING, substitutes
from cycloid_mj.cli.progress import count_progress
from cycloid_mj.cli.terminal import tell_error
from cycloid_mj.design import PRESETS, dump, loads

ESCAPES = (r"\u001b[31m", r"\n", r"\r", r"\u0007", r"\u009b", r"\u202e", r"\u2028", r"\u0000", r"\t", r"\\", r"\"")
RAW = (
    *("\x1b[2J", "\r", "\x00", "\x9b", "\u202e", "\u2028", "\n", "\t", '"', "'", "[", "]", "{", "=", "#", "é"),
    *("\ufeff", "1e400", "nan", "inf", "-", ".", "9" * 400, "true", '""'),
)
VALUES = (
    *("nan", "inf", "-1", "0", "1e308", "[]", "{}", '"x"', "true", '[1, "a"]', r'{"\n" = 1}', "1979-01-01"),
    *("10" * 300, "{a = {b = {c = 1}}}", f'"{"y" * 5000}"'),
)
FILES = [dump(preset) for preset in PRESETS.values()]


def mutated(seed: int) -> str:
    """Return the design file of a preset with one to four random mutations."""
    rng = random.Random(seed)
    lines = rng.choice(FILES).splitlines()
    for _ in range(rng.randint(1, 4)):
        row = rng.randrange(len(lines))
        line = lines[row]
        column = rng.randrange(len(line) + 1)
        escape, key = rng.choice(ESCAPES), line.split("=")[0]
        lines[row : row + 1] = rng.choice(
            [
                [line[:column] + rng.choice(RAW) + line[column:]],
                [line[:column] + line[column + rng.randint(1, 5) :]],
                [line[:column] + chr(rng.randrange(1, 0x3000)) + line[column:]],
                [f'"{escape}{line[:6].strip("[ ")}{rng.choice(ESCAPES)}" = 1', line],
                [f'["{escape}a"]', line],
                [f'{key}= "{escape}{rng.choice(ESCAPES)}"'],
                [f"{key}= {rng.choice(VALUES)}"],
                [line, rng.choice(lines)],
                [""],
            ]
        )
    return "\n".join(lines)


@pytest.mark.parametrize("batch", cases(range(10), 0))
def test_a_mutated_design_file_is_a_design_or_one_clear_error(batch: int, capsys: pytest.CaptureFixture[str]) -> None:
    """2000 files in all; the first 200 by default."""
    refused = 0
    for seed in range(200 * batch, 200 * (batch + 1)):
        try:
            design = loads(mutated(seed), "my.toml")
        except CycloidError as error:
            refused += 1
            tell_error(error)
            first, *others = capsys.readouterr().err.rstrip("\n").split("\n")
            assert first.startswith(("error: my.toml", "error: errors.", "error: ")), seed
            assert all(line.startswith("  ") for line in others), seed
            for text in (first, *others, str(error)):
                assert text.isprintable(), (seed, text)
                assert len(text) < 2 * MESSAGE.message, (seed, text)
                assert "Value error" not in text, (seed, text)
                assert "Input should" not in text, (seed, text)
        else:
            assert loads(dump(design)) == design, seed
    assert 100 < refused < 200


def test_controls_in_a_mutated_file_reach_no_terminal(tmp_path: Path) -> None:
    """The same through the command, for some files."""
    path = tmp_path / "my.toml"
    for seed in range(20):
        path.write_text(mutated(seed), encoding="utf-8")
        code, out, err = told("design", "show", path)
        assert (out if code == 0 else err).strip(), seed
        assert all(sign.isprintable() or sign == "\n" for sign in out + err), seed


def test_an_error_is_one_line_and_its_details_are_lines_below_it(capsys: pytest.CaptureFixture[str]) -> None:
    error = DesignError("the design 'a\nb' cannot be built:", ["undercut\tat 1", "shaft: 2"])
    assert str(error) == "the design 'a\\nb' cannot be built: undercut\\tat 1; shaft: 2"
    tell_error(error)
    assert capsys.readouterr().err == "error: the design 'a\\nb' cannot be built:\n  undercut\\tat 1\n  shaft: 2\n"


def test_checks_that_fail_are_printed_one_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    changes = ("--set", "ring.pin_radius_mm=2.7", "--set", "shaft.radius_mm=14.2")
    code, _, err = told("simulate", "pin", *changes)
    first, *others = err.splitlines()
    assert (code, first) == (1, "error: the design 'pin' cannot be built:")
    assert [line.split(":")[0] for line in others] == ["  undercut", "  shaft"]
    assert "\\n" not in err


@pytest.mark.parametrize("path", ["x" * 4000, "x " * 2000, "x/" * 2000])
@pytest.mark.parametrize("command", [("design", "check"), ("analyze",), ("statics",), ("report",)], ids=" ".join)
def test_a_very_long_path_is_shortened(command: tuple[str, ...], path: str) -> None:
    code, out, err = told(*command, path)
    assert code in (1, 2)
    assert out == ""
    assert err.count("\n") == 1
    assert len(err) < MESSAGE.message + 100
    assert "characters left out" in err


def test_legible_is_idempotent_and_keeps_ordinary_text() -> None:
    text = "a\x1b[2Jb\n" + "w" * 10_000 + " " + "many words " * 1000
    assert legible(legible(text)) == legible(text)
    assert legible("Hsieh, 謝: ω_c = 2 ω_i ± 1 µm, 5 °C") == "Hsieh, 謝: ω_c = 2 ω_i ± 1 µm, 5 °C"
    assert shorten("x" * MESSAGE.word, MESSAGE.word) == "x" * MESSAGE.word


@pytest.mark.parametrize(
    "text",
    [
        f"{'.'.join('a' * 30_000)} = 1",
        f"[{'.'.join('a' * 30_000)}]",
        f"a = {{{'.'.join('a' * 30_000)} = 1}}",
        f"a = {'[' * 30_000}{']' * 30_000}",
        f"a = {'{a=' * 30_000}1{'}' * 30_000}",
        "#" * 2_000_000,
    ],
    ids=["key", "table", "inline", "list", "tables", "size"],
)
def test_a_deeply_nested_or_huge_file_is_refused_immediately(text: str) -> None:
    """tomllib alone takes 48 s for the first."""
    begin = time.process_time()
    with pytest.raises(DesignError, match=r"nested too deeply|at most 1,000,000 are allowed"):
        loads(text)
    assert time.process_time() - begin < 0.5


# --- encodings --------------------------------------------------------------------------------------------------------


def run_in_ascii(*words: str) -> subprocess.CompletedProcess[bytes]:
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    command = [sys.executable, "-m", "cycloid_mj", *words]
    return subprocess.run(command, capture_output=True, check=False, env=environment)


COMMANDS = (
    *("design check printed --all", "design show prinzed°", "design show printed", "rate printed --all", "--help"),
    *("statics printed --all", "figures", "doctor", "measure backlash printed --all"),
    "design new my --ratio 15 --diameter-mm 60 --torque-nm 500",
)


@pytest.mark.parametrize("words", cases(COMMANDS, COMMANDS[1]))
def test_a_command_writes_to_an_ascii_stream(words: str) -> None:
    done = run_in_ascii(*words.split())
    assert b"Traceback" not in done.stderr
    assert (done.stdout + done.stderr).isascii()
    assert b"\\xb0" not in done.stdout + done.stderr
    if "check" in words:
        assert b"80 degC" in done.stdout


def non_ascii_texts() -> Iterator[str]:
    """Yield the texts with characters beyond ASCII in modules whose text reaches the terminal."""
    package = Path(cycloid_mj.__file__).parent
    for path in package.rglob("*.py"):
        if not {"plots", "app", "report"} & set(path.parts):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Constant) and isinstance(node.value, str) and not node.value.isascii():
                    yield node.value


def test_every_character_of_the_package_has_a_readable_substitute() -> None:
    texts = list(non_ascii_texts())
    assert len(texts) > 10
    assert all(substitute.isascii() for substitute in SUBSTITUTES.values())
    missing = {sign for text in texts for sign in text if not sign.isascii() and "\\" in substituted(sign)}
    assert {unicodedata.name(sign) for sign in missing} == set()


def substituted(text: str) -> str:
    return substitutes(UnicodeEncodeError("ascii", text, 0, len(text), SUBSTITUTING))[0]


def test_a_character_without_a_substitute_is_escaped() -> None:
    assert substituted("é°謝\udcff") == "edeg\\u8b1d\\udcff"


def test_a_usage_error_keeps_its_details() -> None:
    with pytest.raises(UsageError) as caught:
        raise UsageError("a:", ["b"]) from None
    assert (caught.value.message, caught.value.details, caught.value.exit_code) == ("a:", ("b",), 2)


# --- signals ----------------------------------------------------------------------------------------------------------

STOPPED_BY = """
import os, signal, sys
from cycloid_mj.cli import app, process

def command(argv=None):
    def raising(*words):
        os.kill(os.getpid(), int(sys.argv[1]))
        for _ in range(10**9):
            pass
    app.application = raising
    return app.main(["design"])

process.main = command
process.run()
"""


@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP", "SIGINT"])
def test_a_signal_ends_a_command_with_128_and_its_number(name: str) -> None:
    number = getattr(signal, name, None)
    if number is None or os.name != "posix":
        pytest.skip(f"no {name} here")
    argv = [sys.executable, "-c", STOPPED_BY, str(int(number))]
    done = subprocess.run(
        argv, capture_output=True, text=True, check=False, preexec_fn=lambda: signal.signal(number, signal.SIG_DFL)
    )
    said = f"error: stopped by {'Ctrl-C' if name == 'SIGINT' else name}\n"
    assert (done.returncode, done.stderr) == (128 + number, said)


def test_the_exit_code_of_a_stop_is_that_of_its_signal() -> None:
    assert [exit_code(stop) for stop in (KeyboardInterrupt(), Stopped("SIGTERM"), Stopped("SIGHUP"))] == [130, 143, 129]
    assert exit_code(Stopped("the failure of another run")) == 130
    assert exit_code(ValueError()) == 1


def test_progress_without_a_finished_item_has_no_time_left(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("cycloid_mj.cli.progress.SECONDS_BETWEEN_COUNTS", 0.0)
    progress = count_progress("wear, percent", quiet=False)
    progress(0, 100)
    assert capsys.readouterr().err == "wear, percent: 0 of 100\n"
    progress(50, 100)
    assert capsys.readouterr().err.endswith(" s left\n")
