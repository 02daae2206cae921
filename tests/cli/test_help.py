"""Help pages and groups of commands without a command: right on terminals of any width, and without one."""

import os
import re
import shlex
import struct
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import is_dataclass
from inspect import BoundArguments
from itertools import pairwise
from pathlib import Path

import pytest
from cyclopts import App

from cycloid_mj.cli import main
from cycloid_mj.cli.app import ABOUT_PAPERS, application, parse
from cycloid_mj.cli.contents import GROUPS
from cycloid_mj.cli.flags import whole
from cycloid_mj.cli.new import SizeFlags
from cycloid_mj.cli.page import NARROWEST, WIDEST, commands, fold_line
from cycloid_mj.design import resolve


def pages(app: App, chain: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    yield chain
    for name in commands(app):
        yield from pages(app[name], (*chain, name))


PAGES = list(pages(application()))


def prose(page: str) -> list[str]:
    """Paragraphs between the line of usage and the first box."""
    return page.split("╭")[0].split("\n\n")[1:]


@pytest.mark.parametrize(
    ("chain", "width"), [*((chain, 60) for chain in PAGES), (("simulate",), 200), (("simulate",), 20)]
)
def test_help_fills_the_terminal_up_to_a_readable_width(chain, width, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", str(width))
    assert main([*chain, "--help"]) == 0
    page, err = capsys.readouterr()
    assert err == ""
    room = min(max(width, NARROWEST), WIDEST)
    assert max(map(len, page.splitlines())) <= room
    assert not re.search(r"--[a-z-]+ (INT|FLOAT|STR)\b", page), "a flag takes N, X or NAME, not a type of Python"
    for paragraph in prose(page):
        lines = [line.rstrip() for line in paragraph.strip("\n").splitlines()]
        for line, following in pairwise(lines):
            assert len(line) + 1 + len(following.split()[0]) > room, f"{line!r} breaks too early"


@pytest.mark.parametrize("chain", PAGES)
def test_an_example_can_be_pasted_as_it_is_printed(chain):
    app = application()
    for name in chain:
        app = app[name]
    examples = app.help_epilogue or ""
    assert max(map(len, examples.splitlines()), default=0) <= WIDEST
    for line in examples.replace("\\\n", " ").splitlines():
        assert re.match(r"  (cycloid-mj|python) |\w[\w ]*:$|$", line), line


def test_an_example_is_wrapped_between_flags_only():
    line = "  cycloid-mj sweep --design my.toml --vary load.torque_nm=5:40:8 --limit 'mass_kg <= 1' --out here"
    assert fold_line(line).splitlines() == [
        "  cycloid-mj sweep --design my.toml --vary load.torque_nm=5:40:8 \\",
        "      --limit 'mass_kg <= 1' --out here",
    ]
    assert fold_line("  cycloid-mj app") == "  cycloid-mj app"


def test_pages_are_those_of_every_command():
    assert len(PAGES) > 25
    assert {("measure", "te"), ("design", "check"), ("log", "repair"), ("simulate",)} <= set(PAGES)


def rows(page: str) -> dict[str, str]:
    """Collect the boxes of a help page, unwrapped: the first column of each row, and its text."""
    found: dict[str, str] = {}
    for line in page.splitlines():
        if line.startswith("│ "):
            name, _, text = line.strip("│").rstrip()[1:].partition("  ")
            if name:
                found[current := name] = text.strip()
            else:
                found[current] += f" {text.strip()}"
    return found


@pytest.mark.parametrize("width", [20, 60, 80, 500])
def test_the_list_has_each_command_in_one_line_equal_to_its_help(width, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", str(width))
    assert main(["--help"]) == 0
    listed = capsys.readouterr().out
    app = application()
    pages = {name: app[name].help.partition("\n")[0] for name in commands(app)}
    lines = pages | {"reproduce": ABOUT_PAPERS.partition("\n")[0]}
    assert [title.group(1) for title in re.finditer(r"╭─ ([\w ]+?) ─", listed)] == [*GROUPS]
    shown = rows(listed)
    assert {name: shown[name] for name in lines} == lines


def test_the_list_imports_no_command() -> None:
    code = "import sys; from cycloid_mj.cli import main; main(['--help']); assert not {heavy} & set(sys.modules)"
    heavy = "{'pydantic', 'numpy', 'cycloid_mj.cli.flags', 'cycloid_mj.design', 'hsieh2014'}"
    done = subprocess.run([sys.executable, "-c", code.format(heavy=heavy)], capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.parametrize("name", [name for commands in GROUPS.values() for name in commands])
def test_a_command_is_where_the_list_says(name: str) -> None:
    """What is asked for is the same command alone as among all others."""
    alone, among_all = application([name])[name], application()[name]
    assert commands(alone) == commands(among_all)
    assert (alone.help, alone.help_epilogue) == (among_all.help, among_all.help_epilogue)
    assert alone.help_epilogue.startswith("Examples:")


def test_help_in_a_very_wide_terminal_has_a_readable_width():
    fcntl, pty, termios = map(pytest.importorskip, ("fcntl", "pty", "termios"))
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 200, 0, 0))
    environment = {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "LINES")}
    command = [sys.executable, "-m", "cycloid_mj", "design", "--help"]
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
    assert error == f"error: {group} needs a command: choose one of {', '.join(names)}"
    assert page[0] == f"Usage: cycloid-mj {group} COMMAND"
    assert all(any(f" {name} " in line for line in page) for name in names)


def leaves(app: App, chain: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], App]]:
    """Yield every command that does something, after its words."""
    if not commands(app):
        yield chain, app
    for name in commands(app):
        yield from leaves(app[name], (*chain, name))


LEAVES = dict(leaves(application()))


WITHOUT_DESIGN = {("validate",), ("doctor",), ("figures",), ("reproduce",), ("design", "new")}
"""Commands that take neither a design nor a log: what they work on is their own."""

NEEDED = {
    "calibrate": ("--loop", "loop.csv"),
    "compare-bench": ("--te", "te.csv"),
    "build": ("--out", "model"),
    "export": ("--out", "parts"),
    "profile": ("--csv", "-"),
    "kinematics": ("--csv", "-"),
}
"""Flags that a command cannot do without."""


WINDOWS = {("app",): "serves a page until Ctrl-C", ("view",): "opens a window until it is closed"}
"""Commands that give no result which could be written or shown, and why."""

COMMON = {"--out", "--html", "--json", "--all", "--force", "--quiet", "--workers"}
"""Flags of every other command."""


def flag_names(command: App) -> set[str]:
    """Return all names of a command's arguments."""
    return {name for argument in command.assemble_argument_collection() for name in argument.names}


@pytest.mark.parametrize("chain", sorted(LEAVES.keys() - WINDOWS.keys()), ids=" ".join)
def test_results_go_out_by_the_same_flags(chain: tuple[str, ...]) -> None:
    assert COMMON - flag_names(LEAVES[chain]) == set()


def test_a_window_has_no_results() -> None:
    assert {chain: flag_names(LEAVES[chain]) & COMMON for chain in WINDOWS} == {chain: {"--quiet"} for chain in WINDOWS}


DESIGNED = [chain for chain, command in LEAVES.items() if "--design" in flag_names(command)]


def test_every_command_takes_a_design_or_a_log_or_needs_neither() -> None:
    without = {chain for chain, command in LEAVES.items() if not {"--design", "LOG", "LOGS"} & flag_names(command)}
    assert without == WITHOUT_DESIGN


@pytest.mark.parametrize("chain", DESIGNED, ids=" ".join)
def test_a_design_is_taken_by_position_and_by_its_flag(chain: tuple[str, ...]) -> None:
    """Both give the command the same designs, and the page of every command that has the flag shows both."""
    app = application()
    needed = NEEDED.get(chain[-1], ())
    (_, by_place, _), (_, by_flag, _) = (
        app.parse_args([*chain, *words, *needed]) for words in (["nonpin"], ["--design", "nonpin"])
    )
    assert designs_of(by_place) == designs_of(by_flag) == ("nonpin",)


@pytest.mark.parametrize("chain", DESIGNED, ids=" ".join)
def test_every_command_with_a_design_takes_a_temperature(chain: tuple[str, ...]) -> None:
    assert "--at-c" in flag_names(LEAVES[chain])


def designs_of(bound: BoundArguments) -> tuple[str, ...]:
    """Return the designs that a command was asked for."""
    given = bound.arguments
    if "design_options" in given:
        return (given["design_options"].design,)
    if "what" in given:
        return (given["what"],)
    return (*given.get("names", ()), *given.get("designs", ()), *given.get("design", ()))


def test_a_renamed_flag_still_works_and_states_its_new_name(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", "pin", "--jobs=2"]) == 2
    assert capsys.readouterr().err.splitlines() == [
        "warning: the flag --jobs is deprecated: use --workers; the old name will be removed in the next release",
        "error: a comparison needs at least two designs: name another one, e.g. cycloid-mj compare pin nonpin",
    ]


def test_integers_are_not_rounded() -> None:
    """cyclopts rounds 1.5 to 2 by itself: every flag for a whole number reads it by `whole`."""
    found = {
        (one.name[-1], argument.name): argument.parameter.converter
        for one in LEAVES.values()
        for argument in one.assemble_argument_collection()
        if argument.hint in (int, int | None)
    }
    assert {("new", "--ratio"), ("app", "--port"), ("animate", "--frames")} < found.keys()
    assert {flag for flag, converter in found.items() if converter is not whole} == set()


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
    flags: tuple[str, ...], told: str, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["design", "new", "my", *flags, "--diameter-mm", "60", "--torque-nm", "5"]) == 2
    err = capsys.readouterr().err
    assert told in err
    assert err.count("\n") == 1
    assert not list(here.iterdir())


HELPS = {
    (chain, argument.name): (argument, argument.parameter.help)
    for chain, command in LEAVES.items()
    for argument in command.assemble_argument_collection()
    if argument.parse and argument.parameter.help
}
"""Every argument of every command, and its help."""


def test_the_default_of_each_flag_is_next_to_it() -> None:
    nothing = (None, False, (), "")
    untold = [
        place
        for place, (argument, text) in HELPS.items()
        if not argument.required
        and argument.field_info.default not in (*nothing, argument.field_info.empty)
        and "Default: " not in text
    ]
    assert untold == []


def test_help_names_the_design_of_a_default_value() -> None:
    """A preset has values of its own: none stands for all of them."""
    texts = [text for _, text in HELPS.values()]
    told = [float(number) for text in texts for number in re.findall(r"times the ratio \(([\d.]+) of pin", text)]
    assert len(told) > 5
    assert told == pytest.approx([resolve("pin").rated_torque] * len(told), abs=0.005)
    assert [place for place, (_, text) in HELPS.items() if "presets)" in text] == []


NUMBERED = {("simulate",), ("stress",), ("compare",), ("design", "show"), ("design", "check")}
"""Commands whose results take the next free name, or that write none by default."""


def results_of(line: str) -> tuple[object, ...] | None:
    """What names the files that an example writes: command, place and designs; None where it writes none."""
    _, *words = shlex.split(line.partition("&&")[0].partition(">")[0])
    chain = next((chain for chain in DESIGNED if tuple(words[: len(chain)]) == chain), None)
    if chain is None or chain in NUMBERED or chain in WINDOWS:
        return None
    _, bound, _ = application().parse_args(words)
    given = dict(bound.arguments)
    for one in bound.arguments.values():
        given |= vars(one) if is_dataclass(one) else {}
    out = given.get("out") or given.get("csv")
    by_default = HELPS.get((chain, "--out"), (None, ""))[1]
    if out == "-" or (out is None and "no files are written" in by_default):
        return None
    return chain, out, given.get("design"), given.get("designs")


@pytest.mark.parametrize("chain", [chain for chain in PAGES if chain and chain[0] != "log"], ids=" ".join)
def test_examples_of_a_page_can_be_pasted_one_after_the_other(chain: tuple[str, ...]) -> None:
    """No command writes over what is there, so each example has a place of its own."""
    app = application()
    for name in chain:
        app = app[name]
    lines = [line.strip() for line in (app.help_epilogue or "").replace("\\\n", " ").splitlines()]
    found = [results for line in lines if line.startswith("cycloid-mj") and (results := results_of(line))]
    assert len(set(found)) == len(found), found


@pytest.mark.parametrize(
    ("words", "name", "value"),
    [
        (["simulate", "pin", "--solver", "PLANAR"], "solver", "planar"),
        (["simulate", "pin", "--solver=Planar", "--contact", "Profile"], "contact", "profile"),
        (["export", "pin", "--out", "STL", "--format", "STL"], "format_", "stl"),
        (["design", "new", "my", "--process", "Printed"], "size", SizeFlags(process="printed")),
    ],
)
def test_a_word_of_a_fixed_set_is_taken_in_any_case(words: list[str], name: str, value: object) -> None:
    bound = parse(application(words[:1]), words)[1]
    assert bound.arguments[name] == value


def test_a_wrong_word_of_a_fixed_set_is_refused_with_the_choices(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "pin", "--solver", "planarr"]) == 2
    assert 'Choose from: "mujoco", "planar"' in capsys.readouterr().err


def test_the_command_reference_lists_exactly_the_flags_of_help() -> None:
    text = application().generate_docs(output_format="markdown")
    assert re.findall(r"`[^`]*, --(?:no|empty)-[\w-]+|\*\[default: ", text) == []
