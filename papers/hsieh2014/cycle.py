"""The load cycle of pin 1: the part of a crank turn in which the disc presses on it, for varied parameters."""

from collections.abc import Mapping, Sequence

import numpy as np

from cycloid_mj.analysis import Series
from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Table
from cycloid_mj.comparison import settle_run
from cycloid_mj.comparison.forces import tooth_forces

RELIEVED = 0.1
"""Share of its largest force below which pin 1 counts as relieved, as in the stress study (heuristic)."""


def cycle_table(cases: Mapping[str, Sequence[Run]]) -> Table:
    """Return the table of pin 1's load cycle; of the runs by name, `cases`, only loaded runs with ring pins count."""
    rows: list[tuple[str | float, ...]] = []
    for name, runs in cases.items():
        for motion in (settle_run(run) for run in runs):
            if motion.design.ring.kind == "pin" and motion.design.load.torque:
                rows.append((name, *cycle(motion)))
    head = ("rated load", "loaded from [deg]", "relieved from [deg]", "share of the turn [%]", "loaded pins, mean")
    return Table(
        "load cycle of pin 1 (paper: loaded at 0, relieved from 10, loaded again from 350 deg)", head, tuple(rows)
    )


def cycle(motion: Series) -> tuple[float, float, float, float]:
    """Return the load cycle of pin 1; the angles are NaN if it is always or never loaded.

    Returns
    -------
    tuple of float
        Crank angles from which it is loaded and relieved [deg], loaded share of the turn [%], mean number of loaded
        pins.
    """
    force = tooth_forces(motion)[motion.one_turn]
    loaded = force[:, 0] > RELIEVED * force[:, 0].max()
    degrees = np.mod(np.degrees(motion.crank_angle[motion.one_turn]), 360.0)
    count = float(np.mean(np.count_nonzero(force > RELIEVED * force.max(), axis=1)))
    return _angle_of_change(degrees, loaded), _angle_of_change(degrees, ~loaded), 100.0 * float(loaded.mean()), count


def _angle_of_change(degrees: Array, begins: Mask) -> float:
    """Return the angle [deg] at which the longest interval with a True mask begins; NaN if the mask is constant.

    `degrees` are the crank angles of a turn, `begins` is the mask, shape (n,) each.
    """
    starts = np.flatnonzero(begins & ~np.roll(begins, 1))
    if starts.size == 0:
        return float("nan")
    lengths = [int(np.argmin(np.append(np.roll(begins, -start), False))) for start in starts]
    return float(degrees[starts[int(np.argmax(lengths))]])
