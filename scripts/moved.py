"""List the figures of the presets that changed between two revisions, and by how much, for release notes.

python scripts/moved.py OLD NEW      # revisions as git knows them

Both revisions are laid out in folders of their own and run by the same interpreter, so that nothing but the code
differs. The table lists what moved by more than its last printed digit; below it stand how many figures are new or
gone, and the lines that CHANGELOG.md has gained, which say why.
"""

import argparse
import hashlib
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from against import ROOT, Figures, Finished, Trial, check_out, figures_of_json, list_run_words, run_trial

from cycloid_mj.base.result import Table
from cycloid_mj.design import presets_for
from cycloid_mj.log import read

DIGITS = 5e-6
"""Least change that is listed, as a share of the figure: half of the last of five digits."""

SHORT = 0.02
"""Length of the runs under load [s]."""


@dataclass(frozen=True)
class Move:
    """A figure of a design that one command prints, in the old revision and in the new one; None where it has none."""

    design: str
    command: str
    key: str
    old: float | None
    new: float | None

    @property
    def change(self) -> str:
        """Change in percent of the old value where that is not 0."""
        if self.old is None or self.new is None:
            return "new" if self.old is None else "gone"
        return f"{100.0 * (self.new / self.old - 1.0):+.3g} %" if self.old else "from 0"


def trials(design: str) -> Iterator[Trial]:
    """Yield the commands whose figures of a design are compared between revisions."""
    run = ("--set", "drive.ramp_s=0", "--set", f"drive.hold_s={SHORT}")
    yield Trial("design check", ("design", "check", design), figures=figures_of_json, logged=False)
    yield Trial("statics", ("statics", "--design", design), figures=figures_of_json, logged=False)
    yield Trial("rate", ("rate", "--design", design), figures=figures_of_json, logged=False)
    yield Trial("simulate, no load", ("simulate", "--design", design, *run), figures=of_the_run)
    if design in ("pin", "nonpin"):
        yield Trial("simulate, 36.68 N m", list_run_words(design, hold=SHORT), figures=of_the_run)


def of_the_run(done: Finished) -> Figures:
    """Read the figures that a run has printed, and a number that every bit of its logged columns decides."""
    (log,) = done.out.glob("*.mcap")
    run = read(log)
    bits = hashlib.sha256(b"".join(run[name].tobytes() for name in sorted(run.columns)))
    return {**figures_of_json(done), "bits of the log": float(int(bits.hexdigest()[:8], 16))}


def moves(design: str, command: str, old: Figures, new: Figures) -> Iterator[Move]:
    """Yield the figures of a command that differ by more than `DIGITS`, and those that only one revision has."""
    for key in dict.fromkeys([*old, *new]):
        before, after = old.get(key), new.get(key)
        if before is None or after is None or abs(after - before) > DIGITS * abs(before):
            yield Move(design, command, key, before, after)


def come_and_gone(moves_found: list[Move]) -> str:
    """Count the figures that only one revision prints."""
    changes = Counter(move.change for move in moves_found)
    return f"Printed by one revision alone: {changes['new']} new, {changes['gone']} gone."


def table(moves_found: list[Move]) -> Table:
    """Tabulate the moves of figures that both revisions print."""
    rows = [
        (move.design, move.command, move.key, f"{move.old:.6g}", f"{move.new:.6g}", move.change)
        for move in moves_found
        if move.old is not None and move.new is not None
    ]
    return Table("what moved", ("design", "command", "figure", "old", "new", "change"), tuple(rows))


def reasons(old: str, new: str) -> list[str]:
    """List the lines that CHANGELOG.md gained between two revisions."""
    command = ["git", "diff", "--unified=0", old, new, "--", "CHANGELOG.md"]
    changed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return [line[1:] for line in changed.splitlines() if line.startswith("+- ")]


def compare_trees(old: Path, new: Path) -> list[Move]:
    """Run all commands with the packages of two trees, and list the figures that differ."""
    moved: list[Move] = []
    with TemporaryDirectory() as folder:
        for design in presets_for("simulate"):
            for number, trial in enumerate(trials(design)):
                print(f"{design}: {trial.name}", file=sys.stderr, flush=True)
                figures = [
                    trial.figures(run_trial(tree, trial, (), Path(folder) / f"{side}-{design}-{number}"))
                    for side, tree in (("old", old), ("new", new))
                ]
                moved += moves(design, trial.name, *figures)
    return moved


def main() -> None:
    """Compare two revisions and print the table in Markdown, with the reasons below it."""
    parser = argparse.ArgumentParser(description=str(__doc__).split("\n\n")[0])
    parser.add_argument("old", help="revision whose figures are known")
    parser.add_argument("new", help="revision whose figures are asked for")
    asked = parser.parse_args()
    with check_out(asked.old) as old, check_out(asked.new) as new:
        moved = compare_trees(old, new)
    print(table(moved).as_markdown(), come_and_gone(moved), sep="\n\n")
    print("", *reasons(asked.old, asked.new), sep="\n")


if __name__ == "__main__":
    main()
