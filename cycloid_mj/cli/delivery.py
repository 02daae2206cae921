"""Delivery of the results of all commands: an `Outcome` as text, as a JSON object, as a page, and as files."""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cycloid_mj.base.atomic_write import encodable_text, write_files
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.interrupt import defer_signals
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.base.overwrite_guard import require_ending
from cycloid_mj.base.result import Table
from cycloid_mj.cli.flags import CommonFlags, Delivery
from cycloid_mj.cli.outfile import STDOUT, Columns, claim_file, claim_folder, write_csv
from cycloid_mj.cli.terminal import json_text, note, say, say_json, show, tell, with_warnings
from cycloid_mj.design import PRESETS

RUNS = "runs"
"""Folder of a page without a name, where the command writes no other file."""


@dataclass(frozen=True)
class TextLimits:
    """Limits of the printed text without ``--all``."""

    max_lines: int = 25
    """Lines on the terminal."""
    frame_lines: int = 6
    """Lines that a table needs in addition to its rows, with the hint at ``--all``."""
    max_named_files: int = 12
    """Files that are named one by one; more are counted by folder."""
    min_warnings: int = 3
    """Warnings that are shown however long the rest is."""


TEXT = TextLimits()


@dataclass(frozen=True)
class Destination:
    """Destination of the files of a command, claimed before its work begins.

    Attributes
    ----------
    stem
        Name of its JSON file, CSV file and page, without the ending.
    folder
        Folder of all files; None if the command writes none.
    page
        Path of the HTML page; None if the command writes none.
    """

    stem: str
    folder: Path | None
    page: Path | None

    def paths(self, names: Iterable[str]) -> list[str]:
        """Return the paths of files in the folder."""
        return [str(self.folder / name) for name in names] if self.folder else []


def claim_destination(
    flags: Delivery,
    stem: str,
    names: Iterable[str] = (),
    default_folder: str = "",
    with_page: bool = False,
    resumed: bool = False,
) -> Destination:
    """Check and reserve the output files of a command before its work, and return their paths as a `Destination`.

    A later command cannot overwrite them.

    Parameters
    ----------
    flags
        Output flags of the command.
    stem
        Name of the JSON file, the CSV file and the page, without the ending.
    names
        Names of further files in the folder.
    default_folder
        Folder without ``--out``; if it is empty, no files are written.
    with_page
        Whether the folder gets a page without ``--html``, too.
    resumed
        Whether the command continues an earlier run, whose files in the folder may be replaced.

    Raises
    ------
    UsageError
        ``--html`` names several files, or a file that cannot be a page.
    TakenError
        A file exists and must not be replaced.
    CycloidError
        The folder cannot be created.
    """
    out = flags.out or default_folder
    files = () if resumed else (f"{stem}.json", f"{stem}.csv", *names)
    directory = claim_folder(out, "the results", files, flags.force) if out else None
    return Destination(stem, directory, claim_page(flags, stem, directory, with_page, resumed))


def claim_page(
    flags: CommonFlags, stem: str, directory: Path | None = None, with_page: bool = False, resumed: bool = False
) -> Path | None:
    """Check and reserve the file of the HTML page of a command, and return its path; None if no page is requested.

    A page is requested by the flag ``--html``, or by `with_page` for a command that writes its page without this flag.
    ``--html`` can name the file; otherwise, it is ``<stem>.html`` in the folder `directory`, or in `RUNS` if that is
    None. `flags` are the output flags of the command. `resumed` is whether the command continues an earlier run, whose
    page it will replace: the file is then neither checked nor reserved.

    Raises
    ------
    UsageError
        ``--html`` names several files, or a file that cannot be a page.
    TakenError
        The file exists and must not be replaced.
    CycloidError
        The file cannot be written, or the folder `RUNS` cannot be created.
    """
    if flags.html is None and not with_page:
        return None
    page_names = flags.html or ()
    if len(page_names) > 1:
        raise UsageError(
            f"--html takes one file, but {len(page_names)} are given ({', '.join(page_names)}): give only one of them"
        )
    if page_names and page_names[0] in PRESETS:
        raise UsageError(
            f"--html takes the next word, {page_names[0]}, as the name of the page, but {page_names[0]} is a preset: "
            f"write --html {page_names[0]}.html, or put the design {page_names[0]} before the flags"
        )
    path = (
        Path(page_names[0])
        if page_names
        else (directory or claim_folder(RUNS, "the page", (), flags.force)) / f"{stem}.html"
    )
    require_ending(path, ".html")
    if not resumed:
        claim_file(path, flags.force)
    return path


def deliver(outcome: Outcome, destination: Destination, flags: CommonFlags) -> int:
    """Write the files of a command's results, print the results as text or JSON, and return the exit code.

    JSON is printed with ``--json``. `outcome` are the results with the exit code, `destination` has the paths of the
    files, `flags` are the output flags of the command.
    """
    write(outcome, destination, flags)
    if flags.json:
        say_json(_result_json(outcome))
    else:
        show_outcome(outcome, flags.all)
    return outcome.code


def _result_json(outcome: Outcome) -> dict[str, Any]:
    """Return the JSON object of an outcome, including all warnings."""
    content = with_warnings(dict(outcome.result))
    issued_warnings = content.get("warnings", [])
    added_warnings = [warning for warning in outcome.warnings if warning not in issued_warnings]
    return content | {"warnings": [*issued_warnings, *added_warnings]} if added_warnings else content


def deliver_files(title: str, files: Iterable[str | Path], page: Path | None, flags: CommonFlags) -> int:
    """Print the paths of files that a command has written, one per line."""
    paths = list(map(str, files))
    outcome = Outcome(title=title, text=paths, result={"files": paths})
    return deliver(outcome, Destination(title, None, page), flags)


def deliver_columns(title: str, columns: Columns, file: str, page: Path | None, flags: CommonFlags) -> int:
    """Write columns of n numbers as CSV to `file` or stdout, and return the exit code 0.

    `title` and `page` are the title and the HTML page of the outcome. If `file` is a path, and ``--all`` is among the
    `flags`, a table of the range of each column is printed. With ``--json``, a JSON object with the names of the
    columns and the number of rows is printed. If `file` is stdout, this object is printed instead of the CSV, and has
    the values.
    """
    destination, files = Destination(title, None, page), [] if file == STDOUT else [file]
    row_count = len(next(iter(columns.values())))
    if files or not flags.json:
        write_csv(file, columns)
    if files:
        note(f"wrote {row_count} rows of {len(columns)} columns to {file}")
    numbers = {name: column for name, column in columns.items() if column.dtype.kind == "f"}
    ranges = tuple((name, f"{column.min():.6g}", f"{column.max():.6g}") for name, column in numbers.items())
    values = {name: column.tolist() for name, column in columns.items()} if flags.json and not files else None
    outcome = Outcome(
        title=title,
        tables=[Table(f"{row_count} rows of {len(columns)} columns", ("column", "least", "most"), ranges)],
        result={"files": files, "rows": row_count, "columns": list(columns)} | ({"values": values} if values else {}),
    )
    if flags.json or (flags.all and files):
        return deliver(outcome, destination, flags)
    write(outcome, destination, flags)
    return 0


def write(outcome: Outcome, destination: Destination, flags: CommonFlags) -> None:
    """Write the files of a command's results, all or none, and print their names unless ``--quiet`` is set.

    `outcome` are the results, `destination` has the paths. Files that the printed text mentions are not repeated.
    """
    files = dict(_encode_files(outcome, destination))
    if files:
        with defer_signals():
            write_files(files)
        if not flags.quiet and (unlisted_files := [path for path in files if str(path) not in (outcome.text or ())]):
            tell(f"wrote {_list_files(unlisted_files)}")


def _list_files(files: Collection[Path]) -> str:
    """Name some files, and count many by their folders."""
    if len(files) <= TEXT.max_named_files:
        return ", ".join(map(str, files))
    folders = Counter(path.parent for path in files)
    return ", ".join(f"{count} file{'s' if count > 1 else ''} in {parent}" for parent, count in folders.items())


def _encode_files(outcome: Outcome, destination: Destination) -> Iterator[tuple[Path, bytes]]:
    """Yield path and content of every file of a command's results: files, pictures, JSON, CSV and page.

    `outcome` are the results. Each picture has a file in each format. Without a folder, only the page is yielded, if
    there is one.
    """
    if destination.folder:
        for name, content in outcome.files.items():
            yield destination.folder / name, content
        for name, encode_picture in outcome.pictures.items():
            for file_format in outcome.formats:
                yield destination.folder / f"{name}.{file_format}", encode_picture(file_format)
        if outcome.filed:
            yield (
                destination.folder / f"{destination.stem}.json",
                encodable_text(f"{json_text(_result_json(outcome))}\n").encode(),
            )
        if outcome.frame:
            yield destination.folder / f"{destination.stem}.csv", encodable_text(outcome.frame.as_csv()).encode()
    if destination.page:
        from cycloid_mj.report.results import outcome_page

        yield destination.page, encodable_text(outcome.page() if outcome.page else outcome_page(outcome)).encode()


def show_outcome(outcome: Outcome, show_hidden: bool) -> None:
    """Print a command's results as text: headline, failures, warnings, summary; tables and notes if there is room.

    `outcome` are the results. Tables and notes are printed if they fit into 25 lines. With `show_hidden` (``--all``),
    all warnings, tables, notes and passed checks are printed. Otherwise the last line states how many of them are
    hidden.
    """
    passed_checks = outcome.passes if show_hidden else ()
    show_hidden = show_hidden or _count_lines(outcome) <= TEXT.max_lines
    title = ", ".join(filter(None, (outcome.title, outcome.condition)))
    for line in [title] if outcome.text is None else outcome.text:
        say(line)
    if outcome.headline:
        show(outcome.headline_table)
    for line in outcome.failures:
        say(f"FAIL  {line}")
    used_lines = TEXT.frame_lines + sum(map(len, (outcome.headline, outcome.failures, outcome.summary)))
    shown_warnings = (
        outcome.warnings if show_hidden else outcome.warnings[: max(TEXT.min_warnings, TEXT.max_lines - used_lines)]
    )
    for line in shown_warnings:
        say(f"warn  {line}")
    for line in passed_checks:
        say(f"ok    {line}")
    if show_hidden:
        for table in outcome.tables:
            show(table)
        for note in outcome.notes:
            say(note)
    hidden = {
        "more warning": len(outcome.warnings) - len(shown_warnings),
        "passed check": len(outcome.passes) - len(passed_checks),
        "table row": 0 if show_hidden else sum(len(table.rows) for table in outcome.tables),
        "note": 0 if show_hidden else len(outcome.notes),
    }
    if hidden_text := ", ".join(f"{count} {kind}{'s' if count > 1 else ''}" for kind, count in hidden.items() if count):
        say(f"--all also shows {hidden_text}")
    for line in outcome.summary:
        say(line)


def _count_lines(outcome: Outcome) -> int:
    """Count the lines of an outcome when printed in full, without wrapped lines."""
    tables = [len(outcome.headline), *(len(table.rows) for table in outcome.tables)]
    lines = (outcome.failures, outcome.warnings, outcome.notes, outcome.summary)
    return 1 + sum(map(len, lines)) + sum(rows + TEXT.frame_lines for rows in tables if rows)
