"""Shell completion: commands, flags, choices and files; and words of fixed sets in any case."""

import os
import select
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from cycloid_mj.cli.app import application
from cycloid_mj.cli.completion import complete_files

pty = pytest.importorskip("pty", reason="terminals are of POSIX alone")


@pytest.fixture(scope="module")
def scripts() -> dict[str, str]:
    app = application()
    return {shell: app.generate_completion(prog_name="cycloid-mj", shell=shell) for shell in ("bash", "zsh", "fish")}


@pytest.fixture
def shell(scripts: dict[str, str], tmp_path: Path) -> Iterator[int]:
    """Start bash on a terminal, in a folder with a design, with the completion script read."""
    (tmp_path / "drawing_one.toml").touch()
    (tmp_path / "outputs").mkdir()
    (tmp_path / "script").write_text(scripts["bash"])
    child, terminal = pty.fork()
    if child == 0:
        os.chdir(tmp_path)
        os.environ |= {"PS1": "$ ", "TERM": "dumb"}
        try:
            os.execvp("bash", ["bash", "--norc", "--noprofile", "-i"])
        finally:
            os._exit(1)
    os.write(terminal, b"source ./script; echo rea''dy\n")
    if "ready" not in read_until(terminal, "ready"):
        pytest.skip("there is no bash")
    yield terminal
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    os.close(terminal)


def read_until(terminal: int, text: str, patience: float = 5.0) -> str:
    seen, end = "", time.monotonic() + patience
    while text not in seen and time.monotonic() < end:
        if select.select([terminal], [], [], 0.1)[0]:
            seen += os.read(terminal, 65536).decode(errors="replace")
    return seen


def test_bash_completes_commands_flags_choices_and_files(shell: int) -> None:
    expected = {
        "cycloid-mj simul": "cycloid-mj simulate ",
        "cycloid-mj simulate draw": "cycloid-mj simulate drawing_one.toml ",
        "cycloid-mj simulate pin --out ou": "--out outputs/",
        "cycloid-mj simulate pin --solver pl": "--solver planar ",
        "cycloid-mj simulate pin --qui": "--quiet ",
        "cycloid-mj rate --design draw": "--design drawing_one.toml ",
    }
    for typed, completed in expected.items():
        os.write(shell, typed.encode() + b"\t")
        assert completed in read_until(shell, completed), typed
        os.write(shell, b"\x15")


def test_zsh_completes_files_where_it_has_no_choices(scripts: dict[str, str]) -> None:
    lines = [line.strip() for line in scripts["zsh"].splitlines()]
    assert "'1:Log of a run, written by cycloid-mj simulate.:_files' \\" in lines
    assert any(line.startswith("'*--out[") and line.endswith("]:out:_files' \\") for line in lines)
    assert any("*--solver[" in line and "]:solver:(mujoco planar)" in line for line in lines)
    assert any(line.startswith("'--json[") and line.endswith("]' \\") for line in lines)
    assert "'1: :->cmds' \\" in lines


def test_no_script_offers_a_flag_that_help_does_not_have(scripts: dict[str, str]) -> None:
    for script in scripts.values():
        assert "--no-json" not in script
        assert "--empty-set" not in script


def test_only_the_registration_of_a_bash_script_is_changed() -> None:
    assert complete_files("a\ncomplete -F _x x\n") == "a\ncomplete -o bashdefault -o default -F _x x\n"
