"""Pin 1's cycle: over which part of a crank turn the gear presses on it, as parameters vary."""

from collections.abc import Mapping, Sequence

import numpy as np

from cycloid_mj.analysis import Series
from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.record import Run
from cycloid_mj.base.result import Table
from cycloid_mj.comparison import settled
from cycloid_mj.comparison.forces import tooth_forces

RELIEVED = 0.1
"""Pin 1 counts as relieved below this share of its largest force, as in the study of stress."""


def cycle_table(cases: Mapping[str, Sequence[Run]]) -> Table:
    """List pin 1's cycle under load in each case that has ring pins: name -> runs, of which the loaded ones count."""
    rows: list[tuple[str | float, ...]] = []
    for name, runs in cases.items():
        for motion in (settled(run) for run in runs):
            if motion.design.ring.kind == "pin" and motion.design.load.torque:
                rows.append((name, *cycle(motion)))
    head = ("rated load", "loaded from [deg]", "relieved from [deg]", "share of the turn [%]", "loaded pins, mean")
    return Table("pin 1's cycle (the paper: loaded at 0, relieved by 10, loaded again from 350 deg)", head, tuple(rows))


def cycle(motion: Series) -> tuple[float, float, float, float]:
    """Find the crank angles [deg] at which pin 1 is loaded and relieved, its share of the turn [%], and loaded pins."""
    force = tooth_forces(motion)[motion.one_turn]
    loaded = force[:, 0] > RELIEVED * force[:, 0].max()
    degrees = np.mod(np.degrees(motion.crank_angle[motion.one_turn]), 360.0)
    count = float(np.mean(np.count_nonzero(force > RELIEVED * force.max(), axis=1)))
    return _change(degrees, loaded), _change(degrees, ~loaded), 100.0 * float(loaded.mean()), count


def _change(degrees: Array, begins: Mask) -> float:
    """Compute where something begins, by the longest stretch of it; not a number where it always or never holds."""
    starts = np.flatnonzero(begins & ~np.roll(begins, 1))
    if starts.size == 0:
        return float("nan")
    lengths = [int(np.argmin(np.append(np.roll(begins, -start), False))) for start in starts]
    return float(degrees[starts[int(np.argmax(lengths))]])
