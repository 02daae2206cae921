"""Findings on stdout: a table for people, or one JSON object."""

from typing import TYPE_CHECKING

from cycloid_mj.cli.terminal import say, say_json, say_table

if TYPE_CHECKING:
    from cycloid_mj.analysis import Findings

HEADER = ("quantity", "simulated", "closed form", "error", "unit")


def report(findings: "Findings", json: bool) -> None:
    """Write the findings of a run."""
    if json:
        say_json(findings.as_json())
        return
    from cycloid_mj.analysis import table

    window = findings.window
    say_table(
        f"{findings.design}: from {window.start_s:g} to {window.end_s:g} s ({window.crank_turns:.1f} crank turns)",
        HEADER,
        table(findings),
    )
    say(f"log: {findings.log}")
    if findings.wall_s is not None:
        say(f"{findings.steps} steps of {findings.timestep_s * 1e6:g} us in {findings.wall_s:.1f} s of wall time")
