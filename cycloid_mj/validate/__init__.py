"""The validation steps of `cycloid-mj validate`: simulation results compared with closed forms and published cases.

Each module is one step and returns rows of *quantity, ours, reference, source, error, bound*; `suite` runs them. The
references use `profile`, `envelope` and `statics` only, never the collider.
"""

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from cycloid_mj.base.engine import Progress, silent
from cycloid_mj.base.notebook_display import CallableRoom
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.base.registry import get_provider

if TYPE_CHECKING:
    from cycloid_mj.validate.suite import Validation

__all__ = ["main"]


@shows_progress
def main(only: Sequence[str] = (), quick: bool = True, progress: Progress = silent) -> "Validation":
    """Compare the simulation with closed forms and published cases; public as ``cycloid_mj.validate``.

    Parameters
    ----------
    only
        Names of steps, such as ``("sharing", "cam")``; by default all.
    quick
        Whether to use shorter runs and fewer crank angles: less than a minute on two cores instead of some minutes.
    progress
        Called with the number of finished parts and the number of all parts.

    Returns
    -------
    Validation
        A row for each quantity with its reference, difference, bound and verdict; `failed` has the rows that fail.

    Raises
    ------
    UsageError
        A name is not that of a step.
    """
    from cycloid_mj.validate.suite import Validation, run_parts, select_parts, sort_rows

    parts = select_parts(only, get_provider("further_validation"))
    finished_rows = []
    for numbered_rows in run_parts(parts, quick):
        finished_rows.append(numbered_rows)
        progress(len(finished_rows), len(parts))
    return Validation(tuple(sort_rows(finished_rows)))


sys.modules[__name__].__class__ = CallableRoom
