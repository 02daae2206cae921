"""A plate of parts as 3MF (Core Specification 1.3): one named object per part, in millimetres."""

from collections import Counter
from collections.abc import Iterator

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


def threemf_bytes(plate: PrintPlate) -> bytes:
    """Encode a plate; copies of a part are numbered."""
    texts = {"[Content_Types].xml": TYPES, "_rels/.rels": RELATIONS, MODEL: _model(plate)}
    return zip_files({name: text.encode() for name, text in texts.items()})


def _model(plate: PrintPlate) -> str:
    """Write the objects at their coordinates; a part and its supports are one object."""
    objects: list[str] = []
    built: list[int] = []
    for name, mesh, supports in zip(_names(plate), plate.meshes, plate.supports, strict=True):
        objects.append(_object(len(objects) + 1, name, _mesh(mesh)))
        first = len(objects)
        for number, support in enumerate(supports, start=1):
            objects.append(_object(len(objects) + 1, f"{name}_support_{number}", _mesh(support)))
        if supports:
            components = "".join(f'<component objectid="{part}"/>' for part in range(first, len(objects) + 1))
            objects.append(_object(len(objects) + 1, f"{name}_on_supports", f"<components>{components}</components>"))
        built.append(len(objects))
    items = "".join(f'<item objectid="{number}"/>' for number in built)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<model unit="millimeter" xml:lang="en-US" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">\n'
        f"<resources>\n{''.join(objects)}</resources>\n<build>{items}</build>\n</model>\n"
    )


def _object(number: int, name: str, content: str) -> str:
    return f'<object id="{number}" type="model" name="{name}">{content}</object>\n'


def _names(plate: PrintPlate) -> Iterator[str]:
    counts, seen = plate.counts, Counter[str]()
    for place in plate.places:
        seen[place.part] += 1
        yield f"{place.part}_{seen[place.part]}" if counts[place.part] > 1 else place.part


def _mesh(mesh: Mesh) -> str:
    vertices = "".join(f'<vertex x="{x:.7g}" y="{y:.7g}" z="{z:.7g}"/>' for x, y, z in mesh.vertices * MILLIMETRES)
    faces = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in mesh.faces.tolist())
    return f"<mesh><vertices>{vertices}</vertices><triangles>{faces}</triangles></mesh>"
