"""A comparison on stdout: tables and words for people, or one JSON object."""

import textwrap
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cycloid_mj.base.errors import warn
from cycloid_mj.cli.terminal import say, say_json, show
from cycloid_mj.papers import vibration

if TYPE_CHECKING:
    from cycloid_mj.comparison import Comparison

LINE = 110


def report(comparison: "Comparison", figures: Sequence[Path], json: bool) -> None:
    """Write the comparison: a table for each load and words, or one JSON object; warn of what is doubtful in it."""
    for trial in comparison.trials:
        warn(trial.name, tuple(dict.fromkeys(each for start in trial.starts for each in start.findings.warnings)))
    if json:
        say_json(comparison.as_json() | {"figures": [str(path) for path in figures]})
        return
    for table in comparison.tables:
        show(table)
    for line in _words(comparison):
        say(line)
    say("logs: " + " ".join(str(trial.measures.findings.log) for trial in comparison.trials))
    say("figures: " + " ".join(str(path) for path in figures))


def _words(comparison: "Comparison") -> Iterator[str]:
    """Yield what the tables do not say, in lines."""
    differing = (f"{key} ({', '.join(map(_value, each))})" for key, each in comparison.differences.items())
    yield from _wrapped(f"{', '.join(comparison.designs)} differ in: {'; '.join(differing) or 'nothing'}")
    if not comparison.rankings:
        yield "the paper's findings on vibration set a pin against a nonpin design: not judged here"
        return
    yield ""
    bases = ["at no load by their independent starts"] if 0.0 in comparison.loads else []
    bases += ["under load by their crank turns"] if any(comparison.loads) else []
    yield from _wrapped(
        f"The paper ({vibration().source}) finds that the pin design fluctuates more. Of these runs, judged "
        f"{' and '.join(bases)}:"
    )
    for sentence in comparison.summary:
        yield from _wrapped(sentence, "- ")
    yield ""
    yield "In numbers (path and velocity of q without steady shifts):"
    for ranking in comparison.rankings:
        yield from _wrapped(ranking.sentence, "- ")
    if comparison.sweep:
        yield ""
        yield "What decides, by the ratio of the rms values:"
        for sentence in comparison.decisions:
            yield from _wrapped(sentence, "- ")
    yield ""


def _value(value: object) -> str:
    """Format a value of a design in words: a number with six digits, which is more than a design is made to."""
    if value is None:
        return "not given"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _wrapped(text: str, mark: str = "") -> list[str]:
    return textwrap.wrap(text, LINE, initial_indent=mark, subsequent_indent=" " * len(mark), break_on_hyphens=False)
