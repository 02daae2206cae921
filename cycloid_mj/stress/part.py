"""Grid and load case of each part by its name; the shaft has its own grid and loads."""

import numpy.typing as npt

from cycloid_mj.design import Design
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.stress.case import LoadCase, patch_case
from cycloid_mj.stress.extrude import solid_grid
from cycloid_mj.stress.grid import Grid, GridSettings, planar_grid
from cycloid_mj.stress.loads import PartLoads
from cycloid_mj.stress.region import part_region
from cycloid_mj.stress.shaft import shaft_case
from cycloid_mj.stress.shaftgrid import shaft_grid


def part_grid(
    design: Design, part: str, settings: GridSettings | None = None, focus: npt.ArrayLike | None = None
) -> Grid:
    """Build the grid of a part: "gear", "ring", "output", "pin_1" (planar, unless the settings say solid), or "shaft".

    Parameters
    ----------
    design
        The design.
    part
        Name of the part.
    settings
        How fine; the default has more than 150 000 unknowns for the default gear.
    focus
        Rows (x, y, edge length) [m]: outlines of planar grids are that fine there, e.g. to resolve a contact patch.

    Raises
    ------
    UsageError
        The design has no such part.
    CycloidError
        The part does not mesh, or a package of the extra ``fem`` is missing.
    """
    reducer = reducer_of(design)
    settings = GridSettings() if settings is None else settings
    if part == "shaft":
        return shaft_grid(reducer, settings)
    if settings.solid:
        return solid_grid(reducer, part, settings)
    return planar_grid(part_region(reducer, part), settings, reducer.design.ring.pin_radius, focus)


def part_case(reducer: Reducer, grid: Grid, loads: PartLoads) -> LoadCase:
    """Factorise a part with its loads; on the shaft they are superposed unit loads."""
    case = shaft_case if grid.part == "shaft" else patch_case
    return case(reducer, grid, loads)
