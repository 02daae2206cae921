"""Estimate of a study's processor time and memory from the sizes of its grids.

The rates were measured on the parts of the presets with a single thread of a 2026 server (Linux x86-64). On other
computers they are approximate.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from cycloid_mj.stress.grid import Grid
from cycloid_mj.stress.study import SUPPORTS, StudySettings


@dataclass(frozen=True)
class GridCost:
    """Measured cost of a kind of grid with n unknowns.

    Attributes
    ----------
    factor, exponent
        Time [s] to mesh, factorise and recover: factor n^exponent.
    per_angle
        Time [s] per unknown and crank angle.
    memory
        Memory [B] per unknown of the largest grid.
    growth
        Exponent of the number of unknowns over the refinement of a grid.
    """

    factor: float
    exponent: float
    per_angle: float
    memory: float
    growth: float


@dataclass(frozen=True)
class CostModel:
    """Cost of planar, solid and shaft grids (the shaft has many unit loads), and of what remains of each part.

    Attributes
    ----------
    base_memory
        Memory of Python with its packages [B].
    retained_per_unknown
        Memory [B] per unknown of a finished part: its grid and its map.
    """

    plane: GridCost = GridCost(16e-6, 1.0, 0.12e-6, 2.9e3, 1.16)
    space: GridCost = GridCost(2.6e-6, 1.25, 0.16e-6, 7.0e3, 1.9)
    shaft: GridCost = GridCost(5.9e-6, 1.25, 0.16e-6, 7.0e3, 1.9)
    base_memory: float = 200e6
    retained_per_unknown: float = 600.0


COST = CostModel()


@dataclass(frozen=True)
class Cost:
    """Processor time `seconds` [s], peak `memory` [B], and the part of it that is `retained` to the end [B]."""

    seconds: float
    memory: float
    retained: float


def estimate_cost(grid: Grid, settings: StudySettings) -> Cost:
    """Estimate processor time [s], peak memory and retained memory [B] of the stress computation of a part.

    The computation solves the finite-element mesh `grid` of the part and a finer mesh. For parts in `SUPPORTS`, it also
    solves a mesh with other supports. The estimate depends on the numbers of unknowns of these meshes, by `settings`.
    """
    rates = COST.shaft if grid.part == "shaft" else COST.plane if grid.dimension == 2 else COST.space
    finer_unknowns = grid.unknowns * settings.finer(grid) ** rates.growth
    unknown_counts = [grid.unknowns, finer_unknowns, *([grid.unknowns] if grid.part in SUPPORTS else [])]
    solved_unknowns = grid.unknowns * settings.angles + finer_unknowns * settings.checked
    seconds = (
        rates.factor * sum(unknowns**rates.exponent for unknowns in unknown_counts) + rates.per_angle * solved_unknowns
    )
    return Cost(seconds, COST.base_memory + rates.memory * finer_unknowns, COST.retained_per_unknown * grid.unknowns)


def add_costs(costs: Iterable[Cost]) -> Cost:
    """Return the cost of consecutive studies: total time [s], peak memory [B], and total retained memory [B].

    While a part is studied, the memory that earlier parts retain is in use, too.
    """
    seconds, memory, retained_memory = 0.0, COST.base_memory, 0.0
    for cost in costs:
        seconds, memory, retained_memory = (
            seconds + cost.seconds,
            max(memory, retained_memory + cost.memory),
            retained_memory + cost.retained,
        )
    return Cost(seconds, memory, retained_memory)
