"""A plate of parts as 3MF (Core Specification 1.3): one named object per part, in millimetres."""

from collections import Counter
from collections.abc import Iterator, Mapping
from html import escape

from cycloid_mj.base.atomic_write import zip_files
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts import Mesh
from cycloid_mj.parts.export.plate import PrintPlate

TYPES = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)
RELATIONS = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    '<Relationship Target="/3D/3dmodel.model" Id="rel0" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
)
MODEL = "3D/3dmodel.model"


MATERIALS_ID = 1 << 30
"""Identifier of the group of base materials; objects are numbered from 1 on."""

Material = tuple[str, tuple[float, ...]]
"""Name of a material, and red, green and blue of a part of it, from 0 to 1."""


def threemf_bytes(plate: PrintPlate, materials: Mapping[str, Material] | None = None) -> bytes:
    """Encode a plate; copies of a part are numbered, and parts have the base materials of their name, if any."""
    texts = {"[Content_Types].xml": TYPES, "_rels/.rels": RELATIONS, MODEL: _model_xml(plate, materials or {})}
    return zip_files({name: text.encode() for name, text in texts.items()})


def _model_xml(plate: PrintPlate, materials: Mapping[str, Material]) -> str:
    """Format the XML text of a 3MF model: its materials, its objects at their coordinates, and the objects to print.

    `plate` has the parts on the print bed, and `materials` the material of each part by its name. A part and its
    supports are the components of one object.
    """
    objects: list[str] = []
    build_ids: list[int] = []
    base_materials = list(dict.fromkeys(materials.values()))
    for placement, name, mesh, supports in zip(
        plate.places, _object_names(plate), plate.meshes, plate.supports, strict=True
    ):
        material = materials.get(placement.part)
        property_ = f' pid="{MATERIALS_ID}" pindex="{base_materials.index(material)}"' if material else ""
        objects.append(_object_xml(len(objects) + 1, name, _mesh_xml(mesh), property_))
        first_id = len(objects)
        for number, support in enumerate(supports, start=1):
            objects.append(_object_xml(len(objects) + 1, f"{name}_support_{number}", _mesh_xml(support)))
        if supports:
            components = "".join(
                f'<component objectid="{object_id}"/>' for object_id in range(first_id, len(objects) + 1)
            )
            objects.append(
                _object_xml(len(objects) + 1, f"{name}_on_supports", f"<components>{components}</components>")
            )
        build_ids.append(len(objects))
    items = "".join(f'<item objectid="{number}"/>' for number in build_ids)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<model unit="millimeter" xml:lang="en-US" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">\n'
        f"<resources>\n{_base_materials(base_materials)}{''.join(objects)}</resources>\n<build>{items}</build>\n</model>\n"
    )


def _base_materials(materials: list[Material]) -> str:
    """Format the XML element of the base materials of a 3MF model; empty if there are none."""
    if not materials:
        return ""
    bases = "".join(
        f'<base name="{escape(name)}" displaycolor="#{"".join(f"{round(255 * share):02X}" for share in colour[:3])}"/>'
        for name, colour in materials
    )
    return f'<basematerials id="{MATERIALS_ID}">{bases}</basematerials>\n'


def _object_xml(number: int, name: str, content: str, property_: str = "") -> str:
    return f'<object id="{number}" type="model" name="{name}"{property_}>{content}</object>\n'


def _object_names(plate: PrintPlate) -> Iterator[str]:
    counts, numbers = plate.counts, Counter[str]()
    for placement in plate.places:
        numbers[placement.part] += 1
        yield f"{placement.part}_{numbers[placement.part]}" if counts[placement.part] > 1 else placement.part


def _mesh_xml(mesh: Mesh) -> str:
    vertices = "".join(f'<vertex x="{x:.7g}" y="{y:.7g}" z="{z:.7g}"/>' for x, y, z in mesh.vertices * MILLIMETRES)
    faces = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in mesh.faces.tolist())
    return f"<mesh><vertices>{vertices}</vertices><triangles>{faces}</triangles></mesh>"
