"""Parts as STEP solids in millimetres, by OpenCASCADE through the optional package gmsh."""

import os
import re
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.interrupt import signals_kept
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts import PartSection
from cycloid_mj.parts.curve import Arc, Circle, Curve, LineSegment, Spline

SPLINES = 6
"""Splines per lobe or root: OpenCASCADE integrates long splines coarsely (0.6 % of the volume with one per lobe)."""

_SESSION = re.compile(rb"FILE_NAME\(.*?\);", re.DOTALL)
_PRODUCT = re.compile(rb"Open CASCADE STEP translator [\d. ]+")


def step_part(name: str, sections: tuple[PartSection, ...], solids_wanted: int = 1) -> bytes:
    """Encode the sections of a part as STEP solids, one or several; equal sections give equal bytes.

    Raises
    ------
    CycloidError
        The package gmsh is not installed, or OpenCASCADE cannot make the solid.
    """
    with _kernel(name) as gmsh:
        solids = [_extrude(gmsh.model.occ, section) for section in sections]
        if len(solids) > 1:
            solids, _ = gmsh.model.occ.fuse(solids[:1], solids[1:])
        for dimension in (2, 1, 0):  # what bounds no solid: controls of the splines, faces that were joined
            gmsh.model.occ.remove(gmsh.model.occ.getEntities(dimension))
        gmsh.model.occ.synchronize()
        if len(solids) != solids_wanted:
            raise CycloidError(
                f"the sections of the {name} make {len(solids)} solids instead of {solids_wanted}; check the design"
            )
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"{name}.step"
            with _silence_stdout():
                gmsh.write(str(path))
            content = path.read_bytes()
    return _without_session(content, name)


def read_volume(content: bytes) -> float:
    """Compute the volume [m3] of the solids in a STEP file.

    Raises
    ------
    CycloidError
        The package gmsh is not installed.
    """
    with _kernel("read") as gmsh, tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "part.step"
        path.write_bytes(content)
        solids = gmsh.model.occ.importShapes(str(path))
        return float(sum(gmsh.model.occ.getMass(*solid) for solid in solids) / MILLIMETRES**3)


def _without_session(content: bytes, name: str) -> bytes:
    """Remove time, folder and counters from a STEP file."""
    file_name = f"FILE_NAME('{name}.step','',(''),(''),'','cycloid_mj','');"
    return _PRODUCT.sub(name.encode(), _SESSION.sub(file_name.encode(), content, count=1))


@contextmanager
def _silence_stdout() -> Iterator[None]:
    """Redirect the messages of OpenCASCADE, which bypass Python, away from stdout."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


@contextmanager
def _kernel(name: str) -> Iterator[Any]:
    """Yield gmsh with an empty model of its own."""
    try:
        import gmsh
    except (ImportError, OSError) as error:
        raise CycloidError(
            f"STEP needs the package gmsh ({error}): install the extra with `pip install 'cycloid-mj[cad]'`, "
            "or export stl, obj or dxf"
        ) from error
    fresh = not gmsh.isInitialized()
    if fresh:
        with signals_kept():
            gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
    gmsh.model.add(name)
    try:
        yield gmsh
    except Exception as error:
        if isinstance(error, CycloidError):
            raise
        raise CycloidError(
            f"OpenCASCADE cannot build the solid {name}: {error}; check the design with `cycloid-mj design check`"
        ) from error
    finally:
        gmsh.model.remove()
        if fresh:
            gmsh.finalize()


def _extrude(occ: Any, section: PartSection) -> tuple[int, int]:
    loops = [occ.addCurveLoop([_edge(occ, curve, section.z0) for curve in loop]) for loop in section.loops]
    face = occ.addPlaneSurface(loops)
    height = (section.z1 - section.z0) * MILLIMETRES
    (solid,) = [entity for entity in occ.extrude([(2, face)], 0.0, 0.0, height) if entity[0] == 3]
    return int(solid[0]), int(solid[1])


def _edge(occ: Any, curve: Curve, z: float) -> int:
    """Add a curve at a height [m] to the kernel; return the number of its edge."""
    z *= MILLIMETRES
    match curve:
        case Circle():
            x, y = np.array(curve.centre) * MILLIMETRES
            return int(occ.addCircle(x, y, z, curve.radius * MILLIMETRES))
        case Arc():
            x, y = np.array(curve.centre) * MILLIMETRES
            return int(occ.addCircle(x, y, z, curve.radius * MILLIMETRES, angle1=curve.start, angle2=curve.end))
        case LineSegment():
            ends = [occ.addPoint(*(np.array(end) * MILLIMETRES), z) for end in (curve.start, curve.end)]
            return int(occ.addLine(*ends))
        case Spline():
            controls = [occ.addPoint(*point, z) for point in curve.controls * MILLIMETRES]
            knots, counts = np.unique(curve.knots * MILLIMETRES, return_counts=True)
            return int(occ.addBSpline(controls, degree=3, knots=knots.tolist(), multiplicities=counts.tolist()))
