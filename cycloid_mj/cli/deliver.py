"""What every measure leaves: a table or JSON on stdout; a figure, the JSON and the logs of its runs in a folder."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cycloid_mj.base.interrupt import unbroken
from cycloid_mj.base.result import quantity_table
from cycloid_mj.base.whole import write_whole
from cycloid_mj.cli.terminal import json_text, say, say_json, show, tell

if TYPE_CHECKING:
    from cycloid_mj.cli.measure import Delivered
    from cycloid_mj.design import Design
    from cycloid_mj.measure import Measurement


def stem(measure: str, design: "Design") -> str:
    """Return the name of a measurement's files, without its ending."""
    return f"{measure}-{design.name}"


def deliver(measurements: "Sequence[Measurement]", into: Path, wanted: "Delivered") -> int:
    """Print measurements and write their files; return the exit code."""
    for one in measurements:
        with unbroken():
            written = write(one, into, wanted.no_log, wanted.force)
        if not wanted.json:
            print_table(one)
        if not wanted.quiet:
            tell(f"wrote {', '.join(str(path) for path in written)}")
    if wanted.json:
        say_json(
            measurements[0].as_json()
            if len(measurements) == 1
            else {"measurements": [one.as_json() for one in measurements]}
        )
    return 0


def write(measurement: "Measurement", into: Path, no_log: bool, force: bool) -> list[Path]:
    """Write figure, JSON and logs of a measurement; return their paths."""
    from cycloid_mj.log import write as write_log
    from cycloid_mj.plots.measure import measurement_figure
    from cycloid_mj.plots.save import pictures

    name = stem(measurement.measure, measurement.design)
    files = pictures({name: measurement_figure(measurement)}, into, ("png", "svg"))
    files[into / f"{name}.json"] = f"{json_text(measurement.as_json())}\n".encode()
    write_whole(files)
    written = [*files]
    if not no_log:
        for run_name, run in measurement.runs.items():
            written.append(into / f"{name}-{run_name}.mcap")
            write_log(run, written[-1], force=force)
    return written


def print_table(measurement: "Measurement") -> None:
    """Print the quantities of a measurement, their notes, and what they stand on."""
    quantities = measurement.quantities.values()
    show(quantity_table(f"{measurement.measure}: {measurement.design.name}", quantities))
    for one in quantities:
        if one.note:
            say(f"{one.name}: {one.note}")
    for table in measurement.tables:
        show(table)
    for sentence in measurement.assumptions:
        say(f"assumed: {sentence}")
