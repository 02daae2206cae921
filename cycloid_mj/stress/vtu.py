"""Stress maps as VTU files (VTK's XML format for unstructured grids), which ParaView opens."""

import zlib
from base64 import b64encode
from xml.etree import ElementTree

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.stress.field import StressMap

NAMES = {3: ("xx", "yy", "xy"), 6: ("xx", "yy", "zz", "yz", "xz", "xy")}

_QUADRATIC = {2: 22, 3: 24}
"""VTK's numbers of the quadratic triangle and tetrahedron, by dimension."""

_TYPES = {"f4": "Float32", "f8": "Float64", "i8": "Int64", "i1": "Int8", "u1": "UInt8"}


def as_vtu(stress_map: StressMap) -> bytes:
    """Encode a stress map as VTU (VTK's XML format): quadratic cells, displacement [m], stresses [Pa] and bulk mask.

    Parameters
    ----------
    stress_map
        Fields on a part at one crank angle.
    """
    dimension = stress_map.points.shape[1]
    cells = _orient_cells(stress_map)
    padding = np.zeros((len(stress_map.points), 3 - dimension))
    components = dict(zip(NAMES[stress_map.stress.shape[1]], stress_map.stress.T, strict=True))

    root = ElementTree.Element(
        "VTKFile",
        type="UnstructuredGrid",
        version="1.0",
        byte_order="LittleEndian",
        header_type="UInt64",
        compressor="vtkZLibDataCompressor",
    )
    counts = {"NumberOfPoints": str(len(stress_map.points)), "NumberOfCells": str(len(cells))}
    piece = ElementTree.SubElement(ElementTree.SubElement(root, "UnstructuredGrid"), "Piece", counts)
    _add_arrays(piece, "Points", {"points": np.hstack([stress_map.points, padding])})
    cell_arrays = {
        "connectivity": cells.ravel().astype(np.int64),
        "offsets": np.arange(1, len(cells) + 1, dtype=np.int64) * cells.shape[1],
        "types": np.full(len(cells), _QUADRATIC[dimension], np.uint8),
    }
    _add_arrays(piece, "Cells", cell_arrays)
    values = {
        "displacement": np.hstack([stress_map.displacement, padding]),
        "von_mises": stress_map.von_mises,
        **{f"principal_{i + 1}": values for i, values in enumerate(stress_map.principal.T)},
        **{f"stress_{name}": values for name, values in components.items()},
        "bulk": stress_map.bulk.astype(np.int8),
    }
    _add_arrays(piece, "PointData", values)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)


def _add_arrays(piece: ElementTree.Element, tag: str, arrays: dict[str, Array]) -> None:
    """Add `arrays` by name to a new XML element `tag` below `piece`, compressed by zlib and encoded in base 64.

    Each array is a single block with a header: number of blocks, size of a block, size of the last block, and
    compressed size [bytes].
    """
    group = ElementTree.SubElement(piece, tag)
    for name, array in arrays.items():
        little_endian = np.ascontiguousarray(array, array.dtype.newbyteorder("<"))
        attributes = {"type": _TYPES[little_endian.dtype.str[1:]], "Name": name, "format": "binary"}
        if little_endian.ndim == 2:
            attributes["NumberOfComponents"] = str(little_endian.shape[1])
        compressed_data = zlib.compress(little_endian.tobytes())
        header = np.array([1, little_endian.nbytes, little_endian.nbytes, len(compressed_data)], "<u8")
        encoded_data = b64encode(header.tobytes()) + b64encode(compressed_data)
        ElementTree.SubElement(group, "DataArray", attributes).text = encoded_data.decode()


def _orient_cells(stress_map: StressMap) -> np.ndarray:
    """Return the nodes of each of m cells, (m, nodes), in an order for which VTK computes a positive area or volume."""
    cells = stress_map.cells.copy()
    dimension = stress_map.points.shape[1]
    corners = stress_map.points[cells[:, : dimension + 1]]
    is_inverted = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0.0
    swapped_order = [0, 2, 1, 5, 4, 3] if dimension == 2 else [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]
    cells[is_inverted] = cells[is_inverted][:, swapped_order]
    return cells
