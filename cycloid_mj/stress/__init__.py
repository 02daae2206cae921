"""Finite elements of each part under the loads of a logged run: ``PartLoads`` -> ``PartStress`` and ``StressMap``.

A part is meshed and factorised once. Each crank angle is a right-hand side::

    settings = GridSettings(refinement=1.0)          # one number is a refinement study
    grid = part_grid(design, "gear", settings)       # planar, quadratic triangles; "shaft" is tetrahedra
    stress = solve(design, grid, loads)              # PartStress: maxima at each of the k angles
    picture = stress_map(design, grid, loads, 74)    # StressMap: fields at the angle of that index
    Path("gear.vtu").write_bytes(as_vtu(picture))

``part_grid(design, part, settings, focus)``
    ``part`` is "gear", "ring", "output", "pin_1" (plane stress, in the frame of its solid; 3-D where
    ``settings.solid``), or "shaft" (3-D).
    ``focus`` refines around contacts: rows (x, y, edge length) [m].
``solve(design, grid, loads)``
    ``bulk_stress`` (k,) [Pa] is the largest von Mises stress farther than ``bulk_distance`` [m] from all loaded
    patches (and from the sharp inner corners of the shaft), ``bulk_place`` (k, d) its position.
"""

import sys
from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any

from cycloid_mj.base.engine import Progress, silent
from cycloid_mj.base.notebook_display import CallableRoom
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.design import Named, resolve

if TYPE_CHECKING:
    from cycloid_mj.stress.field import PartStress, StressMap, solve, stress_map
    from cycloid_mj.stress.grid import Grid, GridSettings
    from cycloid_mj.stress.loads import PartLoads, part_loads
    from cycloid_mj.stress.part import part_grid
    from cycloid_mj.stress.study import StressStudy
    from cycloid_mj.stress.vtu import as_vtu

__all__ = [
    "Grid",
    "GridSettings",
    "PartLoads",
    "PartStress",
    "StressMap",
    "as_vtu",
    "main",
    "part_grid",
    "part_loads",
    "solve",
    "stress_map",
]

_ORIGINS = {
    **dict.fromkeys(("PartStress", "StressMap", "solve", "stress_map"), "field"),
    **dict.fromkeys(("Grid", "GridSettings"), "grid"),
    **dict.fromkeys(("PartLoads", "part_loads"), "loads"),
    "part_grid": "part",
    "as_vtu": "vtu",
}
"""Module of each public name; imported on use, since notches and shaft measures are needed without finite elements."""


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name not in _ORIGINS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; it has {', '.join(__all__)}")
    return getattr(import_module(f"{__name__}.{_ORIGINS[name]}"), name)


@shows_progress
def main(
    design: Named,
    parts: Sequence[str] = (),
    load_nm: float | None = None,
    *,
    quick: bool = True,
    progress: Progress = silent,
) -> "StressStudy":
    """Simulate a design for a crank turn, and compute the stress of its parts; in Python ``cm.stress(design)``.

    Requires the extra ``fem``: gmsh and scikit-fem.

    Parameters
    ----------
    design
        A valid design, or the name of a preset or a file.
    parts
        Names of parts, such as ``"gear"`` or ``"shaft"``; by default all.
    load_nm
        Torque on the output [N m]; by default the design's load, or its rated torque if that is 0.
    quick
        Whether to use every tenth degree and coarser finite-element grids: 15 s instead of 60 s of processor time for
        ``pin``.
    progress
        Called with the number of finished parts and the number of all parts.

    Returns
    -------
    StressStudy
        Largest stresses [Pa] of each part over the turn in ``findings``, and its stress map in ``parts``; ``plot()``
        draws a stress map.

    Raises
    ------
    UsageError
        The design does not exist, or has no such part.
    CycloidError
        A part does not mesh, or a package of the extra ``fem`` is missing.
    """
    from cycloid_mj.stress.figures import run_for_one_turn
    from cycloid_mj.stress.study import QUICK, StudySettings, stress_study

    ran, run = run_for_one_turn(resolve(design), load_nm)
    settings = QUICK if quick else StudySettings()
    return stress_study(run, ran, parts, settings, on_part=lambda part, done, total: progress(done, total))


sys.modules[__name__].__class__ = CallableRoom
