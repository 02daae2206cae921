"""Help pages and groups of commands without a command: right on terminals of any width, and without one."""

import fcntl
import os
import pty
import re
import struct
import subprocess
import sys
import termios
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest
from cyclopts import App

from cycloid_mj.cli import main
from cycloid_mj.cli.app import application
from cycloid_mj.cli.flags import whole
from cycloid_mj.cli.page import WIDEST, commands


def pages(app: App, chain: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    yield chain
    for name in commands(app):
        yield from pages(app[name], (*chain, name))


PAGES = list(pages(application()))


def prose(page: str) -> list[str]:
    """Paragraphs between the line of usage and the first box."""
    return page.split("╭")[0].split("\n\n")[1:]


@pytest.mark.parametrize(("chain", "width"), [*((chain, 60) for chain in PAGES), (("simulate",), 200)])
def test_help_fills_the_terminal_and_is_never_wider_than_reads_well(chain, width, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", str(width))
    assert main([*chain, "--help"]) == 0
    page, err = capsys.readouterr()
    assert err == ""
    room = min(width, WIDEST)
    assert max(map(len, page.splitlines())) <= room
    for paragraph in prose(page):
        lines = [line.rstrip() for line in paragraph.strip("\n").splitlines()]
        for line, following in pairwise(lines):
            assert len(line) + 1 + len(following.split()[0]) > room, f"{line!r} breaks too early"


def test_pages_are_those_of_every_command():
    assert len(PAGES) > 25
    assert {("measure", "te"), ("design", "check"), ("log", "repair"), ("simulate",)} <= set(PAGES)


def test_help_in_a_very_wide_terminal_is_as_wide_as_reads_well():
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 200, 0, 0))
    environment = {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "LINES")}
    command = [sys.executable, "-m", "cycloid_mj.cli", "design", "--help"]
    child = subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=theirs, env={**environment, "TERM": "xterm"})
    os.close(theirs)
    text = b""
    while True:
        try:
            got = os.read(ours, 65536)
        except OSError:  # Linux tells the end of a terminal so
            break
        if not got:
            break
        text += got
    os.close(ours)
    assert child.wait() == 0
    lines = re.sub(r"\x1b\[[0-9;]*m", "", text.decode()).split("\r\n")
    assert max(len(line) for line in lines) == WIDEST


@pytest.mark.parametrize("group", ["measure", "design", "log"])
def test_group_without_a_command_is_wrong_use_and_prints_its_help(group, capsys):
    assert main([group]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    *page, error = err.splitlines()
    names = commands(application()[group])
    assert error == f"error: {group} needs a command: {', '.join(names)}"
    assert page[0] == f"Usage: cycloid-mj {group} COMMAND"
    assert all(any(f" {name} " in line for line in page) for name in names)


def leaves(app: App) -> Iterator[App]:
    """Yield every command that does something."""
    for name in commands(app):
        yield from leaves(app[name]) if commands(app[name]) else [app[name]]


def test_no_whole_number_is_rounded() -> None:
    """cyclopts rounds 1.5 to 2 by itself: every flag for a whole number reads it by `whole`."""
    found = {
        (one.name[-1], argument.name): argument.parameter.converter
        for one in leaves(application())
        for argument in one.assemble_argument_collection()
        if argument.hint in (int, int | None)
    }
    assert {("new", "--ratio"), ("new", "--discs"), ("app", "--port"), ("animate", "--frames")} < found.keys()
    assert {flag for flag, converter in found.items() if converter is not whole} == set()


@pytest.fixture
def empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Stand in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("flags", "told"),
    [
        (("--ratio", "15.5"), "--ratio: '15.5' is not a whole number; give 15 or 16"),
        (("--ratio", "16.0"), "--ratio: '16.0' is not a whole number; give 16"),
        (("--ratio", "15", "--discs", "1.6"), "--discs: '1.6' is not a whole number; give 1 or 2"),
        (("--ratio", "many"), "--ratio: 'many' is not a whole number; see"),
    ],
)
def test_the_nearest_whole_numbers_are_offered(
    flags: tuple[str, ...], told: str, empty: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["design", "new", "my", *flags, "--diameter-mm", "60", "--torque-nm", "5"]) == 2
    err = capsys.readouterr().err
    assert told in err
    assert err.count("\n") == 1
    assert not list(empty.iterdir())
