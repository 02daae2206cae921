"""Stress maps as VTU files for ParaView, through the optional package meshio."""

import tempfile
from pathlib import Path

import numpy as np

from cycloid_mj.stress.field import StressMap
from cycloid_mj.stress.packages import package

NAMES = {3: ("xx", "yy", "xy"), 6: ("xx", "yy", "zz", "yz", "xz", "xy")}


def as_vtu(found: StressMap) -> bytes:
    """Encode a stress map as a VTU file: quadratic cells, displacement [m], stresses [Pa], and where it counts as bulk.

    Raises
    ------
    CycloidError
        The package meshio is not installed.
    """
    meshio = package("meshio")
    flat = np.zeros((len(found.points), 3 - found.points.shape[1]))
    components = dict(zip(NAMES[found.stress.shape[1]], found.stress.T, strict=True))
    mesh = meshio.Mesh(
        points=np.hstack([found.points, flat]),
        cells=[("triangle6" if found.points.shape[1] == 2 else "tetra10", _outward(found))],
        point_data={
            "displacement": np.hstack([found.displacement, flat]),
            "von_mises": found.von_mises,
            **{f"principal_{i + 1}": values for i, values in enumerate(found.principal.T)},
            **{f"stress_{name}": values for name, values in components.items()},
            "bulk": found.bulk.astype(np.int8),
        },
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.vtu"
        meshio.write(path, mesh, file_format="vtu")
        return path.read_bytes()


def _outward(found: StressMap) -> np.ndarray:
    """Order the nodes of each cell as VTK wants them: with a positive area or volume."""
    cells = found.cells.copy()
    dimension = found.points.shape[1]
    corners = found.points[cells[:, : dimension + 1]]
    inverted = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0.0
    swapped = [0, 2, 1, 5, 4, 3] if dimension == 2 else [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]
    cells[inverted] = cells[inverted][:, swapped]
    return cells
