"""``cycloid-mj analyze``: compare a logged run with the closed form, from the log alone."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_mj.base.errors import warn
from cycloid_mj.base.names import SOLVERS
from cycloid_mj.base.outcome import Outcome
from cycloid_mj.base.result import Table
from cycloid_mj.cli.delivery import claim_destination, deliver
from cycloid_mj.cli.flags import DELIVERY, FLAT, Delivery, PointFlag, parse_point

if TYPE_CHECKING:
    from cycloid_mj.analysis import Findings
    from cycloid_mj.analysis.table import RowGroup

EXAMPLES = """Examples:
  cycloid-mj analyze runs/pin.mcap
  cycloid-mj analyze runs/pin.mcap --q 26,0 --json"""

HEADER = ("quantity", "simulated", "closed form", "error", "unit")
COLUMNS = ("part", "quantity", "simulated", "closed_form", "error", "unit")

LogName = Annotated[str, Parameter(metavar="RUN.mcap", help="Log of a run, written by `cycloid-mj simulate`.")]


def analyze(log: LogName, /, *, q: PointFlag = None, output_flags: Annotated[Delivery, FLAT] = DELIVERY) -> int:
    """Compare a logged run with closed-form results.

    At constant speed, the command evaluates transmission error and speed of output and disc (Hsieh 2014, Eq. 12), path
    and speed of the point q (Eqs 16-18 at the measured crank angle), contacts, pin 1, torques and losses. During the
    ramp of the speed, it evaluates the path of q. A log of an interrupted run is evaluated up to its end; if it ends
    during the ramp, the ramp is evaluated. No file except the log is needed.
    """
    from cycloid_mj.analysis import analyze as analyze_run
    from cycloid_mj.log import read

    point_q, destination = parse_point(q), claim_destination(output_flags, f"{Path(log).stem}-analysis")
    run = read(log)
    findings = analyze_run(run, point_q, log=log)
    if not run.complete:
        # the log knows how many steps were planned, not how many were taken
        findings = replace(findings, steps=None)
    warn(findings.design, findings.warnings)
    return deliver(outcome_of(findings), destination, output_flags)


def outcome_of(findings: "Findings") -> Outcome:
    """Convert the findings of a run's analysis to printable results: evaluated time, table in groups, notes."""
    from cycloid_mj.analysis import RETURNED, groups
    from cycloid_mj.base.frame import make_frame

    window, part_groups = findings.window, groups(findings)
    phase_text = f"{window.phase} from {window.start_s:.6g} to {window.end_s:.6g} s"
    span_text = f"{phase_text} ({window.crank_turns:.1f} crank turns), {SOLVERS[findings.solver]}"
    headings = [(f"[{f'{part.name} {part.detail}'.strip()}]", "", "", "", "") for part in part_groups]
    rows = [row for heading, part in zip(headings, part_groups, strict=True) for row in (heading, *part.rows)]
    notes = [f"log: {findings.log}"]
    if findings.timestep_for:
        notes.append(f"time step {findings.timestep}; accuracy of the results: {findings.timestep_for}")
    if findings.wall_s is not None:
        step_text = f"{findings.steps} time steps of {findings.timestep_s * 1e6:g} us"
        notes.append(f"{step_text} in {findings.wall_s:.1f} s of wall time")
    return Outcome(
        title=f"{findings.design}, {findings.condition_words}",
        condition=span_text,
        headline=dict(map(_main_quantity, part_groups)),
        summary=notes,
        notes=[RETURNED] if any(loss.normal_w < 0.0 for loss in findings.losses) else [],
        tables=[Table("findings", HEADER, tuple(rows))],
        frame=make_frame(
            [{"part": part.name, **row._asdict()} for part in part_groups for row in part.rows], COLUMNS, {}
        ),
        result=findings.as_json(),
    )


def _main_quantity(part: "RowGroup") -> tuple[str, str]:
    """Return name and value of the first quantity of a group of findings, as text for the headline."""
    row = part.rows[0]
    return row.quantity, f"{row.simulated or row.error} {row.unit if row.unit != '1' else ''}".strip()
