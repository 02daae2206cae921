"""Every command and code block of the README and of the tour does what it says."""

import re
import shlex
from dataclasses import fields, is_dataclass
from pathlib import Path

import pytest
from cyclopts import CycloptsError

from cycloid_mj.cli import main
from cycloid_mj.cli.app import application
from cycloid_mj.design import resolve

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
TOUR = (ROOT / "docs" / "tour.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", README + TOUR, flags=re.DOTALL)
COMMANDS = [
    line.split(" #")[0].strip()
    for language, block in BLOCKS
    if language == "sh"
    for line in block.splitlines()
    if line.startswith("cycloid-mj ")
]
INLINE = sorted(set(re.findall(r"`(cycloid-mj [^`]+)`", README + TOUR)))
QUICK = ["--ramp-s", "0", "--hold-s", "0.006"]
SLOW = ("validate", "reproduce", "compare", "render", "view", "build", "export", "measure", "stress")


def words_of(command: str) -> list[str]:
    """What stands behind ``cycloid-mj`` in a command, without its redirection."""
    return shlex.split(command.split(" > ")[0])[1:]


def parsed(words: list[str]) -> dict[str, object]:
    """Values that a command would be called with: every flag is known, and its value read and tested."""
    _, bound, unknown = application().parse_args(words, exit_on_error=False, print_error=False)[:3]
    assert not unknown
    values = dict(bound.arguments)
    for options in [value for value in values.values() if is_dataclass(value)]:
        values |= {field.name: getattr(options, field.name) for field in fields(options)}
    return values


def shortened(arguments: list[str]) -> list[str]:
    """The same command with the shortest run."""
    if arguments[0] != "simulate":
        return arguments
    for flag in ("--ramp-s", "--hold-s"):
        if flag in arguments:
            at = arguments.index(flag)
            del arguments[at : at + 2]
    return [*arguments, *QUICK, "--quiet"]


def test_the_first_two_commands_install_and_run() -> None:
    shell = [block.strip() for language, block in BLOCKS if language == "sh"]
    assert shell[0].endswith(".venv/bin/cycloid-mj simulate --design pin")
    assert shell[1] in (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    for command in shell[:2]:
        assert "\n" not in command
        assert command.startswith("python3 -m venv .venv && .venv/bin/pip install ")


def test_every_command_runs_in_order(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    assert len(COMMANDS) > 5
    for command in COMMANDS:
        arguments, *redirection = command.split(" > ")
        words = words_of(arguments)
        if words[0] in SLOW:
            continue
        assert main(shortened(words)) == 0, command
        printed = capsys.readouterr().out
        if redirection:
            Path(redirection[0]).write_text(printed, encoding="utf-8")


@pytest.mark.parametrize("command", INLINE)
def test_commands_in_the_text_exist(command, capsys) -> None:
    words = [word for word in words_of(command) if word.islower() and not word.startswith("-")]
    assert main([*words, "--help"]) == 0
    assert capsys.readouterr().out.startswith(" ".join(["Usage: cycloid-mj", *words]))


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_is_understood_to_its_last_flag(command) -> None:
    words = words_of(command)
    parsed(words)
    with pytest.raises(CycloptsError):
        parsed([*words, "--no-such-flag"])
    for at, word in enumerate(words):
        if word.startswith("--"):
            with pytest.raises(CycloptsError):
                parsed([*words[:at], f"{word}-misspelt", *words[at + 1 :]])


def test_values_of_commands_that_are_only_parsed_are_designs_and_numbers_that_exist(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    slow = [words_of(command) for command in COMMANDS if words_of(command)[0] in SLOW]
    assert len(slow) > 10
    named = []
    for words in slow:
        values = parsed(words)
        for name in ("design", "designs", "sources"):
            given = values.get(name, ())
            named += [given] if isinstance(given, str) else list(given)
    assert len(named) >= 10
    assert {resolve(name).name for name in named} == {"pin", "nonpin"}


@pytest.mark.parametrize("code", [block for language, block in BLOCKS if language == "python"])
def test_python_blocks_print_figures_that_mean_something(code: str, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "README.md", "exec"), {})
    first, second = capsys.readouterr().out.splitlines()
    efficiency, error = map(
        float, re.fullmatch(r"efficiency ([\d.]+)%, transmission error ([\d.]+) arcsec", first).groups()
    )
    force = float(re.fullmatch(r"largest force on a pin (\d+) N", second)[1])
    assert 85.0 < efficiency < 93.0
    assert 0.2 < error < 2.0
    assert 120.0 < force < 200.0


def test_links_and_pictures_exist() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        if not target.startswith("http"):
            assert (ROOT / target).exists(), target
