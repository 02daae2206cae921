"""Every command and code block of the README does what it says."""

import re
import shlex
from pathlib import Path

import pytest

from cycloid_mj.cli import main

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", README, flags=re.DOTALL)
COMMANDS = [
    line.split(" #")[0].strip()
    for language, block in BLOCKS
    if language == "sh"
    for line in block.splitlines()
    if line.startswith("cycloid-mj ")
]
QUICK = ["--ramp-s", "0", "--hold-s", "0.006"]
SLOW = ("validate", "reproduce", "compare", "render", "view", "build", "export", "measure", "stress")


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
        words = shlex.split(arguments)[1:]
        if words[0] in SLOW:
            words = [*words[: 1 + (words[0] == "measure")], "--help"]
        assert main(shortened(words)) == 0, command
        printed = capsys.readouterr().out
        if redirection:
            Path(redirection[0]).write_text(printed, encoding="utf-8")


@pytest.mark.parametrize("code", [block for language, block in BLOCKS if language == "python"])
def test_python_blocks_run(code: str, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "README.md", "exec"), {})


def test_links_and_pictures_exist() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        if not target.startswith("http"):
            assert (ROOT / target).exists(), target
