"""``cycloid-mj analyze``: hold a logged run against the closed form, from the log alone."""

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from cycloid_mj.base.errors import warn
from cycloid_mj.cli.flags import JsonFlag, PointFlag, point
from cycloid_mj.cli.terminal import say, say_groups, say_json

if TYPE_CHECKING:
    from cycloid_mj.analysis import Findings

EXAMPLES = """Examples:
  cycloid-mj analyze runs/pin.mcap
  cycloid-mj analyze runs/pin.mcap --q 26,0 --json"""

HEADER = ("quantity", "simulated", "closed form", "error", "unit")

LogName = Annotated[str, Parameter(metavar="RUN.mcap", help="Log of a run, written by `cycloid-mj simulate`.")]


def analyze(log: LogName, /, *, q: PointFlag = None, json: JsonFlag = False) -> int:
    """Compare a logged run with the closed form, from the log alone.

    Over the hold phase: transmission error and speed of the output and the
    gear (Hsieh 2014, Eq. 12), path and speed of the point q (Eqs 16-18 at the
    measured crank angle), contacts, pin 1, torques and losses; over the ramp:
    the path of q. The log of a run that was stopped is judged as far as it
    goes; one that ended in its ramp, over the ramp.
    """
    from cycloid_mj.analysis import analyze as judged
    from cycloid_mj.log import read

    place = point(q)
    run = read(log)
    findings = judged(run, place, log=log)
    if not run.complete:
        # the log knows how many steps were planned, not how many were made
        findings = replace(findings, steps=None)
    report(findings, json)
    return 0


def report(findings: "Findings", json: bool) -> None:
    """Write the findings of a run, and what to know before trusting them as warnings."""
    warn(findings.design, findings.warnings)
    if json:
        say_json(findings.as_json())
        return
    from cycloid_mj.analysis import groups

    window = findings.window
    span = f"{window.phase} from {window.start_s:.6g} to {window.end_s:.6g} s ({window.crank_turns:.1f} crank turns)"
    say_groups(
        f"{findings.design}, {findings.condition_words}: {span}",
        HEADER,
        [(f"{group.name} {group.detail}".strip(), group.rows) for group in groups(findings)],
    )
    say(f"log: {findings.log}")
    if findings.timestep_for:
        say(f"time step {findings.timestep}, for {findings.timestep_for}")
    if findings.wall_s is not None:
        say(f"{findings.steps} steps of {findings.timestep_s * 1e6:g} us in {findings.wall_s:.1f} s of wall time")
