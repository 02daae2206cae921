"""The way out of every result: an `Outcome` to the terminal, as one JSON object, as a page, and as files."""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cycloid_mj.base.atomic_write import encodable_text, write_files
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.interrupt import defer_signals
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.base.overwrite_guard import claim, require_ending
from cycloid_mj.base.result import Table
from cycloid_mj.cli.flags import CommonFlags, Delivery
from cycloid_mj.cli.outfile import STDOUT, Columns, folder, write_csv
from cycloid_mj.cli.terminal import json_text, note, say, say_json, show, tell, with_warnings
from cycloid_mj.design import PRESETS

RUNS = "runs"
"""Folder of a page without a name, where the command writes no other file."""

MOST_LINES = 25
"""Lines on the terminal, without ``--all``."""

FRAME_LINES = 6
"""Lines that a table needs in addition to its rows, with the hint at ``--all``."""

MOST_NAMED = 12
"""Files that are named one by one."""

FEWEST_WARNINGS = 3
"""Warnings that are shown however long the rest is."""


@dataclass(frozen=True)
class Destination:
    """Destination of the files of a command, claimed before its work begins.

    Attributes
    ----------
    stem
        Name of its JSON file, CSV file and page, without the ending.
    folder
        Of all files; None where it writes none.
    page
        The HTML page; None where it writes none.
    """

    stem: str
    folder: Path | None
    page: Path | None

    def paths(self, names: Iterable[str]) -> list[str]:
        """Return the paths of files in the folder."""
        return [str(self.folder / name) for name in names] if self.folder else []


def claim_destination(
    wanted: Delivery,
    stem: str,
    names: Iterable[str] = (),
    usual: str = "",
    paged: bool = False,
    resumed: bool = False,
) -> Destination:
    """Claim the output files of a command before its work.

    Parameters
    ----------
    wanted
        Files and format that the user requested.
    stem
        Name of the JSON file, the CSV file and the page, without the ending.
    names
        Other files.
    usual
        The folder where ``--out`` names none; without it no files are written.
    paged
        Whether there is a page in the folder without ``--html``, too.
    resumed
        True if an earlier run of the command is resumed: the files in its folder are then its own.

    Raises
    ------
    UsageError
        ``--html`` names several files, or none that a page can have.
    TakenError
        One of the files is there, and may not be replaced.
    CycloidError
        The folder cannot be created.
    """
    out = wanted.out or usual
    files = () if resumed else (f"{stem}.json", f"{stem}.csv", *names)
    into = folder(out, "the results", files, wanted.force) if out else None
    return Destination(stem, into, claim_page(wanted, stem, into, paged, resumed))


def claim_page(
    wanted: CommonFlags, stem: str, into: Path | None = None, paged: bool = False, resumed: bool = False
) -> Path | None:
    """Claim the name of the page; None if there is none. Parameters and errors are those of `claim_destination`."""
    if wanted.html is None and not paged:
        return None
    named = wanted.html or ()
    if len(named) > 1:
        raise UsageError(
            f"--html takes one file, but {len(named)} are given ({', '.join(named)}): give only one of them"
        )
    if named and named[0] in PRESETS:
        raise UsageError(
            f"--html {named[0]} would name the page after a preset: name the page {named[0]}.html, or move the design "
            f"{named[0]} in front of the flags"
        )
    path = Path(named[0]) if named else (into or folder(RUNS, "the page", (), wanted.force)) / f"{stem}.html"
    require_ending(path, ".html")
    if not resumed:
        claim(path, force=wanted.force)
    return path


def deliver(outcome: Outcome, place: Destination, wanted: CommonFlags) -> int:
    """Write the files of an outcome, print it, and return its exit code."""
    write(outcome, place, wanted)
    if wanted.json:
        say_json(_result(outcome))
    else:
        show_outcome(outcome, wanted.all)
    return outcome.code


def _result(outcome: Outcome) -> dict[str, Any]:
    """Return the JSON object of an outcome, with its own warnings after those issued before."""
    noted = with_warnings(dict(outcome.result))
    seen = noted.get("warnings", [])
    own = [item for item in outcome.warnings if item not in seen]
    return noted | {"warnings": [*seen, *own]} if own else noted


def deliver_files(title: str, files: Iterable[str | Path], page: Path | None, wanted: CommonFlags) -> int:
    """Print the paths of files that a command has written, one per line."""
    paths = list(map(str, files))
    outcome = Outcome(title=title, text=paths, result={"files": paths})
    return deliver(outcome, Destination(title, None, page), wanted)


def deliver_columns(title: str, columns: Columns, file: str, page: Path | None, wanted: CommonFlags) -> int:
    """Write columns, shape (n,) each, to a CSV file or stdout; as JSON, their numbers where stdout is the file."""
    place, files = Destination(title, None, page), [] if file == STDOUT else [file]
    rows = len(next(iter(columns.values())))
    if files or not wanted.json:
        write_csv(file, columns)
    if files:
        note(f"wrote {rows} rows of {len(columns)} columns to {file}")
    numbers = {name: column for name, column in columns.items() if column.dtype.kind == "f"}
    ranges = tuple((name, f"{column.min():.6g}", f"{column.max():.6g}") for name, column in numbers.items())
    values = {name: column.tolist() for name, column in columns.items()} if wanted.json and not files else None
    outcome = Outcome(
        title=title,
        tables=[Table(f"{rows} rows of {len(columns)} columns", ("column", "least", "most"), ranges)],
        result={"files": files, "rows": rows, "columns": list(columns)} | ({"values": values} if values else {}),
    )
    if wanted.json or (wanted.all and files):
        return deliver(outcome, place, wanted)
    write(outcome, place, wanted)
    return 0


def write(outcome: Outcome, place: Destination, wanted: CommonFlags) -> None:
    """Write the files of an outcome, all of them or none, and name those that its text does not."""
    files = dict(_files(outcome, place))
    if files:
        with defer_signals():
            write_files(files)
        if not wanted.quiet and (unnamed := [path for path in files if str(path) not in (outcome.text or ())]):
            tell(f"wrote {_list_files(unnamed)}")


def _list_files(files: Collection[Path]) -> str:
    """Name some files, and count many by their folders."""
    if len(files) <= MOST_NAMED:
        return ", ".join(map(str, files))
    folders = Counter(path.parent for path in files)
    return ", ".join(f"{count} file{'s' if count > 1 else ''} in {folder}" for folder, count in folders.items())


def _files(outcome: Outcome, place: Destination) -> Iterator[tuple[Path, bytes]]:
    """Yield path and content of every file."""
    if place.folder:
        for name, content in outcome.files.items():
            yield place.folder / name, content
        for name, draw in outcome.pictures.items():
            for form in outcome.formats:
                yield place.folder / f"{name}.{form}", draw(form)
        if outcome.filed:
            yield place.folder / f"{place.stem}.json", encodable_text(f"{json_text(_result(outcome))}\n").encode()
        if outcome.frame:
            yield place.folder / f"{place.stem}.csv", encodable_text(outcome.frame.as_csv()).encode()
    if place.page:
        from cycloid_mj.report.results import outcome_page

        yield place.page, encodable_text(outcome.page() if outcome.page else outcome_page(outcome)).encode()


def show_outcome(outcome: Outcome, everything: bool) -> None:
    """Print headline, failures and warnings first; with ``--all`` the passes, and with it or if they fit all tables."""
    passes = outcome.passes if everything else ()
    everything = everything or _lines(outcome) <= MOST_LINES
    title = ", ".join(filter(None, (outcome.title, outcome.condition)))
    for line in [title] if outcome.text is None else outcome.text:
        say(line)
    if outcome.headline:
        show(outcome.headline_table)
    for line in outcome.failures:
        say(f"FAIL  {line}")
    taken = FRAME_LINES + sum(map(len, (outcome.headline, outcome.failures, outcome.summary)))
    shown = outcome.warnings if everything else outcome.warnings[: max(FEWEST_WARNINGS, MOST_LINES - taken)]
    for line in shown:
        say(f"warn  {line}")
    for line in passes:
        say(f"ok    {line}")
    if everything:
        for table in outcome.tables:
            show(table)
        for note in outcome.notes:
            say(note)
    hidden = {
        "more warning": len(outcome.warnings) - len(shown),
        "passed check": len(outcome.passes) - len(passes),
        "table row": 0 if everything else sum(len(table.rows) for table in outcome.tables),
        "note": 0 if everything else len(outcome.notes),
    }
    if left := ", ".join(f"{count} {what}{'s' if count > 1 else ''}" for what, count in hidden.items() if count):
        say(f"--all also shows {left}")
    for line in outcome.summary:
        say(line)


def _lines(outcome: Outcome) -> int:
    """Count the lines of an outcome when printed in full, without wrapped lines."""
    tables = [len(outcome.headline), *(len(table.rows) for table in outcome.tables)]
    lines = (outcome.failures, outcome.warnings, outcome.notes, outcome.summary)
    return 1 + sum(map(len, lines)) + sum(rows + FRAME_LINES for rows in tables if rows)
