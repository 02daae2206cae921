"""Findings on stdout: a table for people, or one JSON object."""

from typing import TYPE_CHECKING

from cycloid_mj.cli.terminal import say, say_groups, say_json
from cycloid_mj.errors import warn

if TYPE_CHECKING:
    from cycloid_mj.analysis import Findings

HEADER = ("quantity", "simulated", "closed form", "error", "unit")


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
    if findings.wall_s is not None:
        say(f"{findings.steps} steps of {findings.timestep_s * 1e6:g} us in {findings.wall_s:.1f} s of wall time")
