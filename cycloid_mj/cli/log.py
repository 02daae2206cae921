"""``cycloid-mj log``: show, export and repair logs."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import App, Parameter

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.base.overwrite_guard import claim_outputs, require_ending
from cycloid_mj.base.result import Table
from cycloid_mj.cli.analyze import LogName
from cycloid_mj.cli.completion import CompletingApp
from cycloid_mj.cli.delivery import claim_destination, claim_page, deliver, deliver_columns, deliver_files
from cycloid_mj.cli.flags import COMMON, DELIVERY, FLAT, CommonFlags, Delivery, number_flag
from cycloid_mj.cli.outfile import STDOUT, claim_csv
from cycloid_mj.cli.plot import EXAMPLES as PLOT_EXAMPLES
from cycloid_mj.cli.plot import plot
from cycloid_mj.cli.ranges import RANGES
from cycloid_mj.cli.terminal import note
from cycloid_mj.reducer import reducer_of

if TYPE_CHECKING:
    from cycloid_mj.base.record import Run
    from cycloid_mj.log import Log
    from cycloid_mj.scene import Scene

EXAMPLES = """Examples:
  cycloid-mj log info runs/pin.mcap
  cycloid-mj log csv runs/pin.mcap --columns gear_speed,crank_angle > pin.csv
  cycloid-mj log repair runs/pin.mcap
  cycloid-mj log repair runs/pin.mcap slow.mcap --scene-hz 2000"""


ColumnsFlag = Annotated[
    str | None,
    Parameter(
        name="--columns",
        metavar="A,B,...",
        help="Columns to write after the time, e.g. gear_speed,gear_x. Default: all.",
    ),
]
SceneFlag = Annotated[
    float | None,
    number_flag(
        "Frames of the 3-D scene per simulated second, recomputed from the columns; 2000 for slow "
        "motion. Default: the frames of the log, or 60.",
        RANGES.log_rate_hz,
        name="--scene-hz",
    ),
]


def commands(sort_key: int) -> App:
    """Build the group of commands `log` (info, columns, csv, parquet, repair, rerun, layout, plot).

    `sort_key` is its position in the help.
    """
    help_text = "Inspect, convert and repair logs."
    app = CompletingApp(name="log", help=help_text, help_epilogue=EXAMPLES, sort_key=sort_key)
    subcommands: tuple[Callable[..., int], ...] = (info, columns, csv, parquet, repair, rerun, layout)
    for order, command in enumerate(subcommands):
        app.command(command, sort_key=order)
    app.command(plot, help_epilogue=PLOT_EXAMPLES, sort_key=len(subcommands))
    return app


def info(log: LogName, /, *, output_flags: Annotated[Delivery, FLAT] = DELIVERY) -> int:
    """Print the contents of a log: run, topics, attachments and provenance.

    For a truncated log, it reports how far the log can be read.
    """
    from cycloid_mj.log import load

    contents = load(log)
    destination = claim_destination(output_flags, f"{Path(log).stem}-info")
    run = contents.run
    state_text = "complete" if run.complete else f"not complete: {run.note or 'no reason is known'}"
    span_text = f"{len(run):,} samples from {run.time[0]:g} to {run.time[-1]:g} s, {_rate(run):.6g} per second"
    topics = [(topic, f"{len(names)} columns", f"{len(run):,}") for topic, names in run.topics.items()]
    topics += [
        (topic, viewer_topic.schema, f"{viewer_topic.messages:,}") for topic, viewer_topic in contents.viewers.items()
    ]
    attachment_rows = tuple((name, f"{len(data):,}") for name, data in run.attachments.items())
    outcome = Outcome(
        title=f"log: {log}",
        condition=f"{contents.size:,} bytes, {state_text}",
        text=[f"{log}: {contents.size:,} bytes, {state_text}", span_text],
        tables=[
            Table("topics", ("topic", "holds", "messages"), tuple(topics)),
            Table("attachments", ("file", "bytes"), attachment_rows),
            Table("provenance", ("what", "value"), tuple(sorted(run.provenance.items()))),
        ],
        result={"log": log, **_describe_contents(contents)},
    )
    # the tables are the requested result, however long
    return deliver(outcome, destination, replace(output_flags, all=True))


def columns(log: LogName, /, *, output_flags: Annotated[Delivery, FLAT] = DELIVERY) -> int:
    """List the columns of a log with topic, name and unit."""
    from cycloid_mj.base.frame import make_frame
    from cycloid_mj.log import load

    groups = load(log).run.groups
    destination = claim_destination(output_flags, f"{Path(log).stem}-columns")
    rows = [
        {"topic": topic, "column": name, "unit": unit}
        for topic, units in groups.items()
        for name, unit in units.items()
    ]
    outcome = Outcome(
        title=f"columns: {log}",
        text=["\t".join(row.values()) for row in rows],
        frame=make_frame(rows, ("topic", "column", "unit"), {}),
        result={"columns": rows},
    )
    return deliver(outcome, destination, output_flags)


def csv(
    log: LogName,
    /,
    out: Annotated[str, Parameter(name="--out", metavar="FILE", help="CSV file. Default: stdout.")] = STDOUT,
    *,
    columns: ColumnsFlag = None,
    output_flags: Annotated[CommonFlags, FLAT] = COMMON,
) -> int:
    """Write time [s] and columns of a log as CSV, with all digits."""
    run = _read(log)
    columns_by_name = {"time": run.time, **{name: run[name] for name in _names(columns) or run.columns}}
    claim_csv(out, output_flags.force, "--out")
    page = claim_page(output_flags, f"{Path(log).stem}-columns")
    return deliver_columns(f"columns: {log}", columns_by_name, out, page, output_flags)


def parquet(
    log: LogName,
    /,
    out: Annotated[
        str | None, Parameter(name="--out", metavar="FILE", help="Parquet file. Default: RUN.parquet.")
    ] = None,
    *,
    columns: ColumnsFlag = None,
    output_flags: Annotated[CommonFlags, FLAT] = COMMON,
) -> int:
    """Write time [s] and columns of a log as Parquet, with units and provenance as metadata.

    Requires DuckDB: pip install 'cycloid-mj[parquet]'.
    """
    from cycloid_mj.log.parquet import write_parquet

    run, (path, page) = _read(log), _claim_output(log, out, ".parquet", output_flags)
    write_parquet(run, path, _names(columns))
    return deliver_files(f"columns: {log}", [path], page, output_flags)


def repair(
    log: LogName,
    /,
    out: Annotated[
        str | None, Parameter(name="--out", metavar="FILE", help="Log to write. Default: RUN-repaired.mcap.")
    ] = None,
    *,
    scene_hz: SceneFlag = None,
    output_flags: Annotated[CommonFlags, FLAT] = COMMON,
) -> int:
    """Repair a truncated log by writing a complete copy of it, up to its last complete chunk.

    All topics and attachments are preserved. With --scene-hz, complete logs are accepted too, and the copy has that
    number of frames of the 3-D scene per second. The original log is unchanged.
    """
    from cycloid_mj.log import load, write

    contents = load(log)
    if contents.complete and scene_hz is None:
        note(f"{log} is complete: nothing to repair")
        return deliver_files(f"nothing to repair: {log}", [], claim_page(output_flags, "repaired"), output_flags)
    source = Path(log)
    path = source.with_name(f"{source.stem}-repaired.mcap") if out is None else Path(out)
    claim_outputs(path, force=output_flags.force)
    page = claim_page(output_flags, path.stem)
    write(contents.run, path, _build_scene(contents, scene_hz), force=output_flags.force)
    note(contents.run.note or f"wrote all {len(contents.run)} samples")
    return deliver_files(f"repaired: {log}", [path], page, output_flags)


def rerun(
    log: LogName,
    /,
    out: Annotated[
        str | None, Parameter(name="--out", metavar="FILE", help="Recording for Rerun to write. Default: RUN.rrd.")
    ] = None,
    *,
    output_flags: Annotated[CommonFlags, FLAT] = COMMON,
) -> int:
    """Write a recording for Rerun (.rrd) with moving parts, forces and all columns.

    Rerun also opens the log itself, but without its parts. Requires the Rerun SDK: pip install 'cycloid-mj[rerun]'.
    """
    from cycloid_mj.analysis.series import design_of
    from cycloid_mj.log import read
    from cycloid_mj.scene.rerun import write_rerun

    run, (path, page) = read(log), _claim_output(log, out, ".rrd", output_flags)
    write_rerun(run, reducer_of(design_of(run)), path)
    return deliver_files(f"recording: {log}", [path], page, output_flags)


def layout(log: LogName, /, *, output_flags: Annotated[Delivery, FLAT] = DELIVERY) -> int:
    """Print a layout for Foxglove and Lichtblick with the mechanism and three plots.

    Import it once: the default 3-D view of these programs starts 20 m away and hides everything nearer than 0.5 m.
    """
    from cycloid_mj.analysis.series import design_of
    from cycloid_mj.scene.layout import viewer_layout

    arrangement = viewer_layout(reducer_of(design_of(_read(log))))
    destination = claim_destination(output_flags, f"{Path(log).stem}-layout")
    text = json.dumps(arrangement, indent=2).splitlines()
    return deliver(Outcome(title=f"layout: {log}", text=text, result=arrangement), destination, output_flags)


def _claim_output(log: str, out: str | None, ending: str, output_flags: CommonFlags) -> tuple[Path, Path | None]:
    """Return the paths of the converted log and of its HTML page, after checking that both can be written.

    The converted file is `out`, or by default the path of the `log` with the suffix `ending`. `output_flags` has the
    output flags. The path of the page is None if the flags do not request a page. Existing files may be replaced only
    with ``--force``.
    """
    path = Path(log).with_suffix(ending) if out is None else Path(out)
    require_ending(path, ending)
    claim_outputs(path, force=output_flags.force)
    return path, claim_page(output_flags, f"{path.stem}-{ending[1:]}")


def _read(log: str) -> "Run":
    from cycloid_mj.log import read

    run = read(log)
    if not run.complete:
        note(f"note: the run in {log} is incomplete: {run.note}")
    return run


def _names(columns: str | None) -> list[str] | None:
    return None if columns is None else [name.strip() for name in columns.split(",") if name.strip()]


def _build_scene(log: "Log", rate: float | None) -> "Scene | None":
    """Return the 3-D scene of a logged design with `rate` frames [1/s]; by default, with the rate of the log.

    If the log has no valid design, a note is printed and None is returned; if `rate` is set, CycloidError is raised
    instead.
    """
    from cycloid_mj.analysis.series import design_of
    from cycloid_mj.scene import RATE, Scene

    logged_rates = [viewer_topic.rate for viewer_topic in log.viewers.values() if viewer_topic.rate]
    try:
        return Scene(design_of(log.run), rate or (logged_rates[0] if logged_rates else RATE))
    except CycloidError as problem:
        if rate is not None:
            raise
        note(f"note: the new log has no 3-D scene: {problem}. The log contains all samples that could be read")
        return None


def _describe_contents(log: "Log") -> dict[str, Any]:
    """Return the contents of a log as JSON values.

    ``bytes`` is its size, ``whole`` whether the file is complete, ``complete`` whether the run reached its end, and
    ``note`` the reason if not.
    ``samples``, ``start_s``, ``end_s`` and ``rate_hz`` describe its samples, ``topics`` are the columns by topic,
    ``viewers`` the topics for 3-D viewers, ``attachments`` sizes in bytes by name, and ``provenance`` texts by name.
    """
    run = log.run
    return {
        "bytes": log.size,
        "whole": log.complete,
        "complete": run.complete,
        "note": run.note,
        "samples": len(run),
        "start_s": float(run.time[0]),
        "end_s": float(run.time[-1]),
        "rate_hz": _rate(run),
        "topics": {topic: list(names) for topic, names in run.topics.items()},
        "viewers": {topic: vars(viewer_topic) for topic, viewer_topic in log.viewers.items()},
        "attachments": {name: len(data) for name, data in run.attachments.items()},
        "provenance": dict(run.provenance),
    }


def _rate(run: "Run") -> float:
    """Compute the samples per second [1/s]; 0 of a single one."""
    duration = float(run.time[-1] - run.time[0])
    return (len(run) - 1) / duration if duration else 0.0
