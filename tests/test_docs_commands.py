"""Every command and code block of the README and of every page runs, long commands in a short version.

New pages are tested automatically.
"""

import io
import itertools
import re
import shlex
from collections.abc import Iterator
from contextlib import redirect_stdout
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any

import mujoco
import pytest
from browser import CHROMIUM, MISSING, OVERHANG, UNDRAWN, show, tab
from cyclopts import CycloptsError

from cycloid_mj.checks import check
from cycloid_mj.cli import main
from cycloid_mj.cli.app import application
from cycloid_mj.design import loads, resolve
from cycloid_mj.explore.budget import SobolSettings

ROOT = Path(__file__).parent.parent
PAGES = {
    path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
    for path in [
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        *sorted(path for path in (ROOT / "docs").rglob("*.md") if "/docs/_" not in path.as_posix()),
        *sorted((ROOT / "models").rglob("*.md")),
    ]
}
LANGUAGES = {"sh", "console", "text", "python", "bibtex", "toml"}
"""Languages of code blocks. ``sh`` runs as it is, ``toml`` is a design file; others have placeholders or output."""

TUTORIAL = "docs/tutorial.md"
"""The page whose commands all run in one folder, with short runs and few samples."""

QUICK = {
    "simulate": ["--ramp-s", "0", "--hold-s", "0.006", "--quiet"],
    "compare": ["--quick", "--hold-s", "0.012"],
    "measure": ["--quick"],
}
"""Flags that are appended to a long command unless its line has them."""

PARSED_ONLY = ("view", "calibrate", "stress", "validate")
"""Commands that are only parsed: one opens a window, the others are long and have separate tests.

Exception: ``stress --springs``, whose design a page uses afterwards.
"""

FOREIGN_COMMANDS = (
    "python3 -m venv",
    ".venv/bin/",
    "pip install",
    "dask ",
    "python -m mujoco.viewer",
    ". .venv/bin/activate",
)
"""Beginnings of allowed lines that are not commands of this package."""


def blocks(text: str) -> list[tuple[str, str]]:
    """Return the code blocks of a page with their languages, without Sphinx directives and printed output."""
    text = re.sub(r"^<!-- printed by .*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)
    return [
        (language, block)
        for language, block in re.findall(r"^```(\S*)\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)
        if not language.startswith("{")
    ]


def lines(text: str, *languages: str) -> Iterator[str]:
    """Yield the commands of a page, one for each program that is called, without prompts, comments and output."""
    for language, block in blocks(text):
        if language in languages:
            for line in block.replace("\\\n", " ").splitlines():
                if language == "console" and not line.startswith("$ "):
                    continue  # output
                yield from line.removeprefix("$ ").split("  #")[0].strip().split(" && ")


def commands(text: str, *languages: str) -> list[str]:
    """Return the commands of this package on a page, from its name on."""
    return [line[line.index("cycloid-mj ") :] for line in lines(text, *languages) if _is_own(line)]


def _is_own(line: str) -> bool:
    return bool(re.match(r"(\.venv/bin/)?cycloid-mj ", line))


def words_of(command: str) -> list[str]:
    """Return the words behind ``cycloid-mj`` in a command, without its redirection."""
    return shlex.split(command.split(" > ")[0], comments=True)[1:]


FLAG = re.compile(r"(?<![\w-])--[a-z][\w-]*")

cached_application = cache(application)


def parsed(words: list[str]) -> dict[str, object]:
    """Return the values of a command's parameters; every flag must be known and every value valid."""
    _, bound, unknown = cached_application().parse_args(words, exit_on_error=False, print_error=False)[:3]
    assert not unknown
    values = dict(bound.arguments)
    for options in [value for value in values.values() if is_dataclass(value)]:
        values |= {field.name: getattr(options, field.name) for field in fields(options)}
    return values


def shortened(words: list[str]) -> list[str]:
    """Return the words of the command with the shortest run."""
    quick = QUICK.get(words[0], [])
    for flag in ("--ramp-s", "--hold-s"):
        if flag in words and flag in quick:
            at = words.index(flag)
            words = [*words[:at], *words[at + 2 :]]
    return words if "--quick" in words else [*words, *quick]


def run(command: str, words: list[str]) -> None:
    """Run a command, which must succeed, and redirect its output as its line does."""
    with redirect_stdout(io.StringIO()) as printed:
        assert main([*words]) == 0, command
    if " > " in command:
        Path(command.split(" > ")[1].split()[0]).write_text(printed.getvalue(), encoding="utf-8")


SHELL = [page for page, text in PAGES.items() if commands(text, "sh") and page != TUTORIAL]
NAMED = sorted(
    {command for text in PAGES.values() for command in re.findall(r"`(cycloid-mj [^`\n]+)`", text)},
)
CALLED = sorted({command for text in PAGES.values() for command in commands(text, "sh", "console", "text")})


@pytest.fixture(scope="module")
def tutorial_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder in which a reader of the tutorial has run its commands."""
    folder = tmp_path_factory.mktemp("tutorial")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr("cycloid_mj.explore.budget.SOBOL", SobolSettings(min_samples=16, min_drawn=16, max_samples=16))
        for command in commands(PAGES[TUTORIAL], "sh"):
            run(command, shortened(words_of(command)))
    return folder


@pytest.fixture
def empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Change to an empty folder with a link to the tests, which pages refer to."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tests").symlink_to(ROOT / "tests")
    return tmp_path


def test_every_code_block_has_a_tested_language() -> None:
    assert len(PAGES) > 30
    for page, text in PAGES.items():
        assert {language for language, _ in blocks(text)} <= LANGUAGES, page
        for line in lines(text, "sh", "console", "text"):
            assert _is_own(line) or line.startswith(FOREIGN_COMMANDS), f"{page}: {line}"
            for word in re.findall(r"\b(?:scripts|models|docs|tests)/[\w./]+", line):
                assert (ROOT / word).exists() or word == "docs/_build", f"{page}: {line}"


def test_the_design_files_of_the_pages_can_be_built() -> None:
    files = [code for text in PAGES.values() for language, code in blocks(text) if language == "toml"]
    assert files
    assert not any(check(loads(file)).failures for file in files)


@pytest.mark.slow
def test_the_tutorial_writes_design_parts_and_joint_in_under_ten_commands(tutorial_folder: Path) -> None:
    assert len(commands(PAGES[TUTORIAL], "sh")) < 10
    made = {"drive.toml", "runs/drive-review.html", "made/drive-tolerance.html", "parts/gear.step", "joint/scene.xml"}
    assert all((tutorial_folder / name).stat().st_size > 0 for name in made)


@pytest.mark.slow
@pytest.mark.skipif(not CHROMIUM, reason=MISSING)
def test_pages_that_commands_write_fit_a_phone(tutorial_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tutorial_folder)
    run("", ["rate", "--design", "drive.toml", "--html", "rating.html"])
    pages = {page.name: page for page in tutorial_folder.rglob("*.html")}
    assert pages.keys() == {"drive-review.html", "drive-tolerance.html", "reducer.html", "rating.html"}
    with tab() as screen:
        for page in pages.values():
            show(screen, page)
            assert not screen.run(OVERHANG), page.name
            assert not screen.run(UNDRAWN), page.name
            assert not screen.errors, page.name


@pytest.mark.slow
@pytest.mark.parametrize("page", SHELL)
@pytest.mark.usefixtures("empty_folder")
def test_the_commands_of_a_page_run_in_order(page: str) -> None:
    for command in commands(PAGES[page], "sh"):
        if words_of(command)[0] not in PARSED_ONLY or "--springs" in command:
            run(command, shortened(words_of(command)))


@pytest.mark.parametrize("command", CALLED)
def test_every_command_of_the_pages_parses(command: str) -> None:
    words = words_of(command)
    parsed(words)
    with pytest.raises(CycloptsError):
        parsed([*words, "--no-such-flag"])
    for at, word in enumerate(words):
        if word.startswith("--"):
            with pytest.raises(CycloptsError):
                parsed([*words[:at], f"{word}-misspelt", *words[at + 1 :]])


def test_designs_in_commands_exist() -> None:
    named = []
    for words in map(words_of, CALLED):
        values = parsed(words)
        for name in ("design", "designs", "sources"):
            given = values.get(name, ())
            named += [given] if isinstance(given, str) else list(given)
    presets = {name for name in named if not name.endswith(".toml")}
    assert len(named) > 10
    assert {resolve(name).name for name in presets} == presets


@pytest.mark.parametrize("command", NAMED)
def test_commands_in_the_text_exist(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = words_of(command)
    flags = [word for word in words if word.startswith("--")]
    called = list(itertools.takewhile(lambda word: re.fullmatch(r"[a-z][a-z-]*", word), words))
    assert main([*called, "--help"]) == 0
    told = capsys.readouterr().out
    assert told.startswith(" ".join(["Usage: cycloid-mj", *called]))
    assert all(flag in told for flag in flags)


@pytest.mark.slow
def test_flags_in_the_text_exist(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    import reference

    known = set(re.findall(r"--[a-z][\w-]*", reference.commands()))
    assert len(known) > 50
    for page, text in PAGES.items():
        if not page.startswith("models/"):
            named = set(re.findall(r"(?<=`)--[a-z][\w-]*", text))
            assert named <= known, f"{page}: {sorted(named - known)}"


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in PAGES if page.startswith("models/") and "```python" in PAGES[page]])
def test_the_python_of_a_model_runs(page: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    for language, block in blocks(PAGES[page]):
        if language == "python":
            exec(compile(block, page, "exec"), {})


@pytest.mark.slow
def test_the_python_of_the_joint_runs(
    tutorial_folder: Path, empty_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    attach, varied, alone = (block for language, block in blocks(PAGES["docs/joint.md"]) if language == "python")
    monkeypatch.chdir(tutorial_folder)
    spec = mujoco.MjSpec()
    arm = spec.worldbody.add_body()
    arm.add_joint(name="elbow", axis=[0.0, 0.0, 1.0])
    arm.add_geom(size=[0.05, 0.0, 0.0])
    exec(compile(attach, "joint.md", "exec"), {"spec": spec})
    assert spec.compile().ntendon > 0

    monkeypatch.chdir(empty_folder)
    (drawn,) = (command for command in commands(PAGES["docs/joint.md"], "sh") if "--spread" in command)
    run(drawn, words_of(drawn))
    monkeypatch.chdir("drives")
    monkeypatch.syspath_prepend(Path.cwd())
    scope: dict[str, Any] = {}
    exec(compile(alone, "joint.md", "exec"), scope)
    stiffness = scope["model"].tendon_stiffness.copy()
    exec(compile(varied, "joint.md", "exec"), scope)
    assert (scope["model"].tendon_stiffness != stiffness).any()


def test_the_python_of_other_pages_is_tested_elsewhere() -> None:
    with_python = {page for page, text in PAGES.items() if any(language == "python" for language, _ in blocks(text))}
    assert {page for page in with_python if not page.startswith("models/")} == {
        "README.md",
        "docs/joint.md",
        "docs/python.md",
    }


def test_the_python_of_the_page_on_python_runs(
    empty_folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The blocks run in order, and every function in the table is public."""
    page, scope = "docs/python.md", {}
    for language, block in blocks(PAGES[page]):
        assert language == "python"
        exec(compile(block, page, "exec"), scope)
    printed = capsys.readouterr().out
    efficiency = float(re.search(r"efficiency ([\d.]+)%", printed)[1])
    assert 80.0 < efficiency < 95.0
    assert len(re.findall(r"^backlash [\d.]+ arcmin$", printed, re.MULTILINE)) == 3
    assert {"pin.mcap", "pin.html", "gear.stl"} <= {path.name for path in empty_folder.iterdir()}
    named = set(re.findall(r"`cm\.(\w+)", PAGES[page]))
    assert named <= set(scope["cm"].__all__)


def test_a_broken_command_is_detected() -> None:
    page = "```sh\ncycloid-mj statics --design pin --torq 3\n```\n```text\n$ cycloid-mj nothing \\\n  --x\n```\n"
    assert commands(page, "sh", "text") == ["cycloid-mj statics --design pin --torq 3", "cycloid-mj nothing    --x"]
    for command in commands(page, "sh", "text"):
        with pytest.raises(CycloptsError):
            parsed(words_of(command))
    assert blocks("```toml\nx = 1\n```\n") == [("toml", "x = 1\n")]


def test_the_command_reference_escapes_angle_brackets(monkeypatch):
    """Markdown reads ``<design>`` as HTML and leaves it out."""
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    import reference

    page = reference.commands()
    assert "DIR/&lt;design>.mcap" in page
    prose = re.sub(r"```.*?```|`[^`\n]*`", "", page, flags=re.DOTALL)
    assert not re.findall(r"<\w", prose)


def test_the_command_reference_lists_the_flags_of_help(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    import reference

    parts = re.split(r"^#{2,} cycloid-mj ", reference.commands(), flags=re.MULTILINE)[1:]
    assert len(parts) > 40
    for part in parts:
        name = part.splitlines()[0]
        listed = {flag for names in re.findall(r"^\* `([^`]+)`", part, re.MULTILINE) for flag in FLAG.findall(names)}
        assert main([*name.split(), "--help"]) == 0
        shown = set(FLAG.findall(capsys.readouterr().out))
        assert listed <= shown, f"{name}: {sorted(listed - shown)}"
