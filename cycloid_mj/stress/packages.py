"""Optional packages of the stress calculation, imported where they are used, with one error that names the extra."""

import importlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.interrupt import preserve_handlers
from cycloid_mj.base.units import MILLIMETRES

_MESHER_OPTIONS = {
    "General.Terminal": 0,
    "General.NumThreads": 1,
    "Mesh.MaxNumThreads1D": 1,
    "Mesh.MaxNumThreads2D": 1,
    "Mesh.MaxNumThreads3D": 1,
    "Mesh.Algorithm": 6,
    "Mesh.Algorithm3D": 1,
    "Mesh.RandomSeed": 1,
    "Mesh.RandomFactor": 1e-9,
    "Mesh.RandomFactor3D": 1e-12,
    "Mesh.OptimizeNetgen": 0,
    "Geometry.OCCParallel": 0,
    "Mesh.Optimize": 1,
    "Mesh.MeshSizeExtendFromBoundary": 0,
    "Mesh.MeshSizeFromPoints": 1,
    "Mesh.MeshSizeFromCurvature": 0,
    "Mesh.MeshSizeMin": 0,
    "Mesh.ElementOrder": 1,
    "Mesh.SecondOrderLinear": 0,
    "Mesh.HighOrderOptimize": 0,
}


def import_package(name: str) -> Any:
    """Import and return a package of the extra ``fem``.

    Raises
    ------
    CycloidError
        The package, or a library that it needs, is not installed.
    """
    try:
        return importlib.import_module(name)
    except (ImportError, OSError) as error:
        raise CycloidError(
            f"the package {name}, which stress calculations need, cannot be loaded ({error}): install it with "
            "`pip install 'cycloid-mj[fem]'`"
        ) from error


@contextmanager
def open_mesher(part: str, longest_edge: float) -> Iterator[Any]:
    """Context manager that yields gmsh with an empty model and fixed options, so that grids are reproducible.

    The previous options are restored afterwards. The user's options file is not read. A single thread is used, since
    the order of several threads would change the tetrahedra. ``longest_edge`` is in [m]; ``part`` is the name of the
    model.

    Raises
    ------
    CycloidError
        gmsh is not installed, or the part does not mesh.
    """
    gmsh = import_package("gmsh")
    is_first = not gmsh.isInitialized()
    if is_first:
        with preserve_handlers():
            gmsh.initialize(readConfigFiles=False, interruptible=False)
    old_options = {name: gmsh.option.getNumber(name) for name in (*_MESHER_OPTIONS, "Mesh.MeshSizeMax")}
    # gmsh works in mm: its tolerances are absolute
    for name, setting in {**_MESHER_OPTIONS, "Mesh.MeshSizeMax": longest_edge * MILLIMETRES}.items():
        gmsh.option.setNumber(name, setting)
    gmsh.model.add(part)
    try:
        yield gmsh
    except CycloidError:
        raise
    except Exception as error:
        raise CycloidError(
            f"cannot generate a finite-element mesh of the {part} ({str(error).strip()}): check its outline with "
            "`cycloid-mj export`, or use a finer mesh: omit --quick or, in Python, increase GridSettings.refinement"
        ) from error
    finally:
        gmsh.model.remove()
        for name, setting in old_options.items():
            gmsh.option.setNumber(name, setting)
        if is_first:
            gmsh.finalize()
