"""Stress maps as VTU files for ParaView, through the optional package meshio."""

import tempfile
from pathlib import Path

import numpy as np

from cycloid_mj.stress.field import StressMap
from cycloid_mj.stress.packages import package

NAMES = {3: ("xx", "yy", "xy"), 6: ("xx", "yy", "zz", "yz", "xz", "xy")}


def as_vtu(stress_map: StressMap) -> bytes:
    """Encode a stress map as a VTU file: quadratic cells, displacement [m], stresses [Pa], and where it counts as bulk.

    Raises
    ------
    CycloidError
        The package meshio is not installed.
    """
    meshio = package("meshio")
    flat = np.zeros((len(stress_map.points), 3 - stress_map.points.shape[1]))
    components = dict(zip(NAMES[stress_map.stress.shape[1]], stress_map.stress.T, strict=True))
    mesh = meshio.Mesh(
        points=np.hstack([stress_map.points, flat]),
        cells=[("triangle6" if stress_map.points.shape[1] == 2 else "tetra10", _outward(stress_map))],
        point_data={
            "displacement": np.hstack([stress_map.displacement, flat]),
            "von_mises": stress_map.von_mises,
            **{f"principal_{i + 1}": values for i, values in enumerate(stress_map.principal.T)},
            **{f"stress_{name}": values for name, values in components.items()},
            "bulk": stress_map.bulk.astype(np.int8),
        },
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.vtu"
        meshio.write(path, mesh, file_format="vtu")
        return path.read_bytes()


def _outward(stress_map: StressMap) -> np.ndarray:
    """Order the nodes of each cell as VTK wants them: with a positive area or volume."""
    cells = stress_map.cells.copy()
    dimension = stress_map.points.shape[1]
    corners = stress_map.points[cells[:, : dimension + 1]]
    inverted = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0.0
    swapped = [0, 2, 1, 5, 4, 3] if dimension == 2 else [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]
    cells[inverted] = cells[inverted][:, swapped]
    return cells
