"""Drives for a requirement: the answer of the search with its remedies."""

from collections.abc import Callable
from dataclasses import replace

from cycloid_mj.sizing.answer import Answer, other_drives, sized_drive, solve
from cycloid_mj.sizing.remedies import remedies
from cycloid_mj.sizing.requirement import Requirement


def size_drive(requirement: Requirement, on_progress: Callable[[Answer], None] = lambda _: None) -> Answer:
    """Find drives that meet a requirement, or the maximum torque with its other values.

    `on_progress` receives the first drive found, or a refusal as soon as the maximum is known, and with each remedy.
    """
    solution, refused, pools = solve(requirement)
    if solution:
        lightest = sized_drive(solution, solution.rated, "lightest", "lowest mass of the drive with its covers")
        on_progress(Answer(requirement, (lightest,)))
        return Answer(solution.requirement, (lightest, *other_drives(solution)))
    on_progress(refused)
    for remedy in remedies(requirement, refused.most, pools):
        refused = replace(refused, remedies=(*refused.remedies, remedy))
        on_progress(refused)
    return refused
