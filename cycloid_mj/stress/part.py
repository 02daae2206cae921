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
    """Mesh a part by quadratic finite elements: planar triangles, or solid tetrahedra.

    Parameters
    ----------
    design
        The design.
    part
        "gear" (with several discs "gear_1", ...), "ring", "output" or "pin_1", which are planar unless
        `settings.solid`; or "shaft", which is always solid.
    settings
        Edge lengths; the default results in more than 150 000 unknowns for the default gear.
    focus
        Positions with short edges, rows (x, y, edge length) [m], e.g. to resolve a contact patch. Solid grids ignore
        it.

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
    """Factorise the stiffness of a part; the `response` of the result solves for the loads at any crank angle."""
    case = shaft_case if grid.part == "shaft" else patch_case
    return case(reducer, grid, loads)
