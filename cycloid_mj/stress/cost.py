"""Estimate of a study's processor time and memory from the sizes of its grids.

The rates were measured on the parts of the presets with a single thread of a 2026 server (Linux x86-64). On other
computers they are approximate.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from cycloid_mj.stress.grid import Grid
from cycloid_mj.stress.study import SUPPORTS, StudySettings

BASE_MEMORY = 200e6
"""Memory of Python with its packages [B]."""

PLANE, SPACE, SHAFT = (16e-6, 1.0), (2.6e-6, 1.25), (5.9e-6, 1.25)
"""Time [s] of a grid of n unknowns, to mesh, factorise and recover, as a n^b: (a, b). The shaft has many unit loads."""

PER_ANGLE = {2: 0.12e-6, 3: 0.16e-6}
"""Time [s] per unknown and crank angle, by dimension."""

MEMORY = {2: 2.9e3, 3: 7.0e3}
"""Memory [B] per unknown of the largest grid, by dimension."""

KEPT_PER_UNKNOWN = 600.0
"""Memory [B] per unknown of a finished part: its grid and its map."""

GROWTH = {2: 1.16, 3: 1.9}
"""Exponent of the number of unknowns over the refinement of a grid, by dimension."""


@dataclass(frozen=True)
class Cost:
    """Processor time `seconds` [s], peak `memory` [B], and the part of it that is `retained` to the end [B]."""

    seconds: float
    memory: float
    retained: float


def cost(grid: Grid, settings: StudySettings) -> Cost:
    """Estimate the cost of a part's study: its own grid, a finer one, and its other supports."""
    dimension, power = grid.dimension, GROWTH[grid.dimension]
    finer = grid.unknowns * settings.finer(grid) ** power
    rate, order = SHAFT if grid.part == "shaft" else PLANE if dimension == 2 else SPACE
    grids = [grid.unknowns, finer, *([grid.unknowns] if grid.part in SUPPORTS else [])]
    solved = grid.unknowns * settings.angles + finer * settings.checked
    seconds = rate * sum(unknowns**order for unknowns in grids) + PER_ANGLE[dimension] * solved
    return Cost(seconds, BASE_MEMORY + MEMORY[dimension] * finer, KEPT_PER_UNKNOWN * grid.unknowns)


def total(costs: Iterable[Cost]) -> Cost:
    """Add the costs of parts that are studied one after the other."""
    seconds, memory, retained = 0.0, BASE_MEMORY, 0.0
    for cost in costs:
        seconds, memory, retained = (
            seconds + cost.seconds,
            max(memory, retained + cost.memory),
            retained + cost.retained,
        )
    return Cost(seconds, memory, retained)
