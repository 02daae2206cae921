"""What a study costs before it begins: processor time and memory, from the sizes of its grids.

The rates were measured on this project's own parts, one thread of a 2026 server (Linux x86-64) at a time; on another
machine they are a guide.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from cycloid_mj.stress.grid import Grid
from cycloid_mj.stress.study import SUPPORTS, StudySettings

BASE = 200e6
"""Memory of Python with its packages [B]."""

PLANE, SPACE, SHAFT = (16e-6, 1.0), (2.6e-6, 1.25), (5.9e-6, 1.25)
"""Time [s] of a grid of n unknowns, to mesh, factorise and recover, as a n^b: (a, b). The shaft has many unit loads."""

PER_ANGLE = {2: 0.12e-6, 3: 0.16e-6}
"""Time [s] of one unknown at one crank angle."""

MEMORY = {2: 2.9e3, 3: 7.0e3}
"""Memory [B] of one unknown of the largest grid."""

KEPT = 600.0
"""Memory [B] of one unknown of a part that is done: its grid and its map."""

GROWTH = {2: 1.16, 3: 1.9}
"""Unknowns of a grid go with this power of its refinement."""


@dataclass(frozen=True)
class Cost:
    """Processor time `seconds` [s], the most `memory` at a time [B], and how much of it is `kept` to the end [B]."""

    seconds: float
    memory: float
    kept: float


def cost(grid: Grid, settings: StudySettings) -> Cost:
    """Estimate the cost of a part's study: its own grid, a finer one, and its other supports."""
    dimension, power = grid.dimension, GROWTH[grid.dimension]
    finer = grid.unknowns * settings.finer(grid) ** power
    rate, order = SHAFT if grid.part == "shaft" else PLANE if dimension == 2 else SPACE
    grids = [grid.unknowns, finer, *([grid.unknowns] if grid.part in SUPPORTS else [])]
    solved = grid.unknowns * settings.angles + finer * settings.checked
    seconds = rate * sum(unknowns**order for unknowns in grids) + PER_ANGLE[dimension] * solved
    return Cost(seconds, BASE + MEMORY[dimension] * finer, KEPT * grid.unknowns)


def total(costs: Iterable[Cost]) -> Cost:
    """Add the costs of parts that are studied one after the other."""
    seconds, memory, kept = 0.0, BASE, 0.0
    for cost in costs:
        seconds, memory, kept = seconds + cost.seconds, max(memory, kept + cost.memory), kept + cost.kept
    return Cost(seconds, memory, kept)
