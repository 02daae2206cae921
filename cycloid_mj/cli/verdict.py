"""A comparison on stdout: tables and words for people, or one JSON object."""

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cycloid_mj.base.errors import warn
from cycloid_mj.base.result import Quantity, Table
from cycloid_mj.cli.terminal import say, say_json, show
from cycloid_mj.design import Design
from cycloid_mj.papers import vibration
from cycloid_mj.reducer import Reducer

if TYPE_CHECKING:
    from cycloid_mj.comparison import Comparison

LINE = 110

HEADLINE = (
    *("backlash_arcmin", "lost_motion_arcmin", "stiffness_nm_per_arcmin", "te_unloaded_arcsec", "te_loaded_arcsec"),
    *("tooth_force_n", "output_pin_force_n", "cam_force_n", "capacity_nm", "efficiency_percent", "mass_kg"),
)
"""Keys of the catalogue's figures that are printed beside those of the runs; JSON has all of geometry and statics."""


def catalogued(designs: Sequence[Design]) -> dict[str, dict[str, Quantity]]:
    """Compute the catalogue's figures of geometry and statics of each design, by its name."""
    from cycloid_mj.figures import quantities

    return {design.name: quantities(Reducer(design)) for design in designs}


def catalogue_table(by_design: Mapping[str, Mapping[str, Quantity]]) -> Table:
    """Put the figures of `HEADLINE` side by side."""
    first = next(iter(by_design.values()))
    rows: list[tuple[str | float, ...]] = [
        (key, *(of[key].value for of in by_design.values()), first[key].unit) for key in HEADLINE
    ]
    return Table("by geometry and statics: see `cycloid-mj figures`", ("figure", *by_design, "unit"), tuple(rows))


def report(comparison: "Comparison", figures: Sequence[Path], json: bool) -> None:
    """Write the comparison: a table for each load and words, or one JSON object; warn of what is doubtful in it."""
    for trial in comparison.trials:
        warn(trial.name, tuple(dict.fromkeys(each for start in trial.starts for each in start.findings.warnings)))
    from cycloid_mj.figures import values_json

    by_statics = catalogued([trial.design for trial in comparison.at(comparison.loads[-1])])
    if json:
        statics = {name: values_json(computed) for name, computed in by_statics.items()}
        say_json(comparison.as_json() | {"by_statics": statics, "figures": [str(path) for path in figures]})
        return
    for table in (*comparison.tables, catalogue_table(by_statics)):
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
