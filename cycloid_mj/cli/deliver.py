"""What every measure leaves: a table or JSON on stdout; a figure, the JSON and the logs of its runs in a folder."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cycloid_mj.cli.terminal import json_text, say, say_json, show, tell
from cycloid_mj.interrupt import unbroken
from cycloid_mj.result import quantity_table
from cycloid_mj.whole import write_whole

if TYPE_CHECKING:
    from cycloid_mj.measure import Measurement


def deliver(found: "Sequence[Measurement]", into: Path, json: bool, quiet: bool, no_log: bool = False) -> int:
    """Print measurements and write their files; give the exit code."""
    for one in found:
        with unbroken():
            written = write(one, into, no_log)
        if not json:
            print_table(one)
        if not quiet:
            tell(f"wrote {', '.join(str(path) for path in written)}")
    if json:
        say_json(found[0].as_json() if len(found) == 1 else {"measurements": [one.as_json() for one in found]})
    return 0


def write(found: "Measurement", into: Path, no_log: bool) -> list[Path]:
    """Write figure, JSON and logs of a measurement; give their paths."""
    from cycloid_mj.log import write as write_log
    from cycloid_mj.plots import save
    from cycloid_mj.plots.measure import measurement_figure

    stem = f"{found.measure}-{found.design.name}"
    written = [*save({stem: measurement_figure(found)}, into, ("png", "svg"))]
    result = into / f"{stem}.json"
    write_whole({result: f"{json_text(found.as_json())}\n".encode()})
    written.append(result)
    if not no_log:
        for name, run in found.runs.items():
            written.append(into / f"{stem}-{name}.mcap")
            write_log(run, written[-1], force=True)
    return written


def print_table(found: "Measurement") -> None:
    """Print the quantities of a measurement, their notes, and what they stand on."""
    quantities = found.quantities.values()
    show(quantity_table(f"{found.measure}: {found.design.name}", quantities))
    for one in quantities:
        if one.note:
            say(f"{one.name}: {one.note}")
    for table in found.tables:
        show(table)
    for sentence in found.assumptions:
        say(f"assumed: {sentence}")
