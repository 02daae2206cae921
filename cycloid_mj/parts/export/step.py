"""Parts and assemblies as STEP files (AP 214) in millimetres, by OpenCASCADE through the optional package OCP."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from io import BytesIO
from itertools import chain, pairwise
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import CycloidError
from cycloid_mj.base.extras import import_extra
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts import PartSection
from cycloid_mj.parts.curve import Arc, Circle, Curve, LineSegment, Spline
from cycloid_mj.parts.export.joint import CrossHole
from cycloid_mj.parts.parts import Colour

SPLINES = 6
"""Splines per lobe or root: CAD systems integrate long splines coarsely (0.6 % of the volume with one per lobe)."""


@dataclass(frozen=True)
class PlacedPart:
    """Position of a part: its name there, the part, its origin [m], its angle about z [rad], and its rigid body."""

    name: str
    part: str
    origin: tuple[float, float, float]
    angle: float
    body: str = ""


@dataclass(frozen=True)
class BrokenEdge:
    """A circular edge of a part: centre and radius, height z and size of its chamfer or fillet [m]."""

    centre: tuple[float, float]
    radius: float
    z: float
    size: float
    is_fillet: bool = False


def step_part(
    name: str,
    sections: Sequence[PartSection],
    solids_wanted: int = 1,
    edges: Sequence[BrokenEdge] = (),
    bores: Sequence[CrossHole] = (),
) -> bytes:
    """Encode the sections of a part as a STEP file, with the chamfers and fillets `edges` and the cross holes `bores`.

    `name` is the name of the part. Equal arguments give files with equal bytes.

    Raises
    ------
    CycloidError
        The package OCP is not installed, OpenCASCADE cannot build the solid, or the sections do not form
        `solids_wanted` separate solids.
    """
    document = occ.TDocStd_Document(occ.TCollection_ExtendedString("BinXCAF"))
    _add_part(document, name, sections, solids_wanted, edges, bores)
    return _encode_document(document, name)


def step_assembly(
    name: str,
    parts: Mapping[str, Sequence[PartSection]],
    colours: Mapping[str, Colour],
    placements: Sequence[PlacedPart],
    edges: Mapping[str, Sequence[BrokenEdge]] | None = None,
    bores: Mapping[str, Sequence[CrossHole]] | None = None,
) -> bytes:
    """Encode an assembly as one STEP file of named, coloured parts, each drawn once, with all its positions.

    Parameters
    ----------
    name
        Name of the assembly.
    parts, colours
        Sections and colour of each part, by name.
    placements
        Positions of the parts.
    edges, bores
        Edges with chamfers and fillets, and holes across the axis, by part.

    Raises
    ------
    CycloidError
        The package OCP is not installed, or OpenCASCADE cannot build a part.
    """
    document = occ.TDocStd_Document(occ.TCollection_ExtendedString("BinXCAF"))
    shapes = occ.XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    colouring = occ.XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    root = shapes.NewShape()
    _set_name(root, name)
    labels = {
        part: _add_part(document, part, sections, 1, (edges or {}).get(part, ()), (bores or {}).get(part, ()))
        for part, sections in parts.items()
    }
    for part, label in labels.items():
        colour = occ.Quantity_Color(*colours[part][:3], occ.Quantity_TypeOfColor.Quantity_TOC_sRGB)
        colouring.SetColor(label, colour, occ.XCAFDoc_ColorType.XCAFDoc_ColorSurf)
    axis = occ.gp_Ax1(occ.gp_Pnt(), occ.gp_Dir(0.0, 0.0, 1.0))
    for placement in placements:
        motion = occ.gp_Trsf()
        motion.SetRotation(axis, placement.angle)
        motion.SetTranslationPart(occ.gp_Vec(*(MILLIMETRES * coordinate for coordinate in placement.origin)))
        _set_name(shapes.AddComponent(root, labels[placement.part], occ.TopLoc_Location(motion)), placement.name)
    shapes.UpdateAssemblies()
    return _encode_document(document, name)


def read_volume(content: bytes) -> float:
    """Compute the volume [m3] of the solids in a STEP file with the `content`.

    Raises
    ------
    CycloidError
        The package OCP is not installed.
    """
    reader, properties = occ.STEPControl_Reader(), occ.GProp_GProps()
    _silence()
    reader.ReadStream("part.step", BytesIO(content))
    reader.TransferRoots()
    occ.BRepGProp.VolumeProperties_s(reader.OneShape(), properties)
    return float(properties.Mass()) / MILLIMETRES**3


class _OpenCascade:
    """The classes of OpenCASCADE by their names, each from its module of OCP."""

    def __getattr__(self, name: str) -> Any:
        import_extra("OCP", "STEP", "cad", "export stl, obj or dxf")
        module = name.partition("_")[0]
        return getattr(import_module("OCP.collections" if module in ("Array1", "List") else f"OCP.{module}"), name)


occ = _OpenCascade()


def _set_name(label: Any, name: str) -> None:
    occ.TDataStd_Name.Set_s(label, occ.TCollection_ExtendedString(name))


def _add_part(
    document: Any,
    name: str,
    sections: Sequence[PartSection],
    solids_wanted: int = 1,
    edges: Sequence[BrokenEdge] = (),
    bores: Sequence[CrossHole] = (),
) -> Any:
    """Add a part to a document of OpenCASCADE as the union of its sections, and return its label there.

    Parameters
    ----------
    document, name
        The document, and the name of the part.
    sections
        Sections of the part.
    solids_wanted
        Number of separate solids that the part should have.
    edges, bores
        Edges with chamfers and fillets, and holes across the axis.

    Raises
    ------
    CycloidError
        The part cannot be built, or has another number of solids.
    """
    try:
        first_body, *other_bodies = [_extrude(section) for section in sections]
        shape = _unite_bodies(first_body, other_bodies) if other_bodies else first_body
        shape = _break_edges(_drill_bores(shape, bores), edges)
    except CycloidError:
        raise
    except Exception as error:
        raise CycloidError(
            f"OpenCASCADE cannot build the solid of the part {name} ({error}): check the design with `cycloid-mj "
            "design check`, or export STL (--format stl)"
        ) from error
    solids, solid_count = occ.TopExp_Explorer(shape, occ.TopAbs_ShapeEnum.TopAbs_SOLID), 0
    while solids.More():
        solid_count += 1
        solids.Next()
    if solid_count != solids_wanted:
        raise CycloidError(
            f"the sections of the {name} form {solid_count} separate solids instead of {solids_wanted}: check the "
            "design with `cycloid-mj design check`, or export STL (--format stl)"
        )
    label = occ.XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).AddShape(shape, False)
    _set_name(label, name)
    return label


def _encode_document(document: Any, name: str) -> bytes:
    """Encode a document of OpenCASCADE as STEP, without time and machine, so that equal documents give equal bytes."""
    text, writer, content = occ.TCollection_HAsciiString, occ.STEPCAFControl_Writer(), BytesIO()
    _silence()
    writer.Transfer(document, occ.STEPControl_StepModelType.STEPControl_AsIs)
    model = writer.ChangeWriter().Model()
    _make_reproducible(model)
    header = occ.APIHeaderSection_MakeHeader(model)
    header.SetName(text(f"{name}.step"))
    header.SetOriginatingSystem(text("cycloid_mj"))
    header.SetTimeStamp(text(""))
    header.SetAuthorisation(text(""))
    header.SetAuthorValue(1, text(""))
    header.SetOrganizationValue(1, text(""))
    writer.WriteStream(content)
    return content.getvalue()


def _silence() -> None:
    """Stop OpenCASCADE from writing its messages to stdout."""
    occ.Message.DefaultMessenger_s().RemovePrinters(occ.Message_Printer.get_type_descriptor_s())


def _make_reproducible(model: Any) -> None:
    """Renumber the occurrences of a STEP `model` from 1, and sort its colours by part; both vary between runs."""
    entities = [model.Value(number) for number in range(1, model.NbEntities() + 1)]
    occurrences = (entity for entity in entities if isinstance(entity, occ.StepRepr_NextAssemblyUsageOccurrence))
    for number, occurrence in enumerate(occurrences, start=1):
        occurrence.SetId(occ.TCollection_HAsciiString(str(number)))
    style_type = occ.StepVisual_MechanicalDesignGeometricPresentationRepresentation
    starts = [number for number, entity in enumerate(entities) if isinstance(entity, style_type)]
    if not starts:
        return
    # each starts a chain from a styled solid to its colour; equal colours are shared
    position = {id(entity): number for number, entity in enumerate(entities)}
    chains = [entities[start:end] for start, end in pairwise([*starts, len(entities)])]
    chains.sort(key=lambda style_chain: position[id(style_chain[1].Item())])
    styles = entities[starts[0] :]
    for number, entity in enumerate(sorted(chain.from_iterable(chains), key=_rgb)):
        current_index = styles.index(entity, number)
        if current_index != number:
            model.ChangeOrder(starts[0] + current_index + 1, starts[0] + number + 1)
            styles.insert(number, styles.pop(current_index))


def _rgb(entity: Any) -> tuple[float, ...]:
    """Return the components of a colour; of other entities, which come before all colours, none."""
    is_colour = isinstance(entity, occ.StepVisual_ColourRgb)
    return (entity.Red(), entity.Green(), entity.Blue()) if is_colour else ()


def _unite_bodies(first_body: Any, other_bodies: Sequence[Any]) -> Any:
    """Return the union of OpenCASCADE solids, `first_body` and `other_bodies`, without superfluous faces and edges."""
    fuse = occ.BRepAlgoAPI_Fuse()
    fuse.SetArguments(_list([first_body]))
    fuse.SetTools(_list(other_bodies))
    fuse.Build()
    fuse.SimplifyResult()
    return fuse.Shape()


def _drill_bores(shape: Any, bores: Sequence[CrossHole]) -> Any:
    """Return an OpenCASCADE solid, `shape`, with the holes `bores` across its axis."""
    for bore in bores:
        start = occ.gp_Pnt(*(MILLIMETRES * coordinate for coordinate in bore.start))
        frame = occ.gp_Ax2(start, occ.gp_Dir(*bore.direction))
        cylinder_size = MILLIMETRES * bore.radius, MILLIMETRES * bore.length
        shape = occ.BRepAlgoAPI_Cut(shape, occ.BRepPrimAPI_MakeCylinder(frame, *cylinder_size).Shape()).Shape()
    return shape


def _break_edges(shape: Any, edges: Sequence[BrokenEdge]) -> Any:
    """Return an OpenCASCADE solid, `shape`, with chamfers and fillets of its circular edges; other edges stay sharp.

    All fillets, or all chamfers, stay sharp if OpenCASCADE cannot build a valid solid with them.
    """
    for maker, edges_of_kind in (
        (occ.BRepFilletAPI_MakeFillet, [edge for edge in edges if edge.is_fillet]),
        (occ.BRepFilletAPI_MakeChamfer, [edge for edge in edges if not edge.is_fillet]),
    ):
        if not edges_of_kind:
            continue
        builder, explorer = maker(shape), occ.TopExp_Explorer(shape, occ.TopAbs_ShapeEnum.TopAbs_EDGE)
        done_edges: list[Any] = []
        while explorer.More():
            edge = occ.TopoDS.Edge(explorer.Current())
            size = _edge_break_size(edge, edges_of_kind)
            if size and not any(edge.IsSame(done_edge) for done_edge in done_edges):
                builder.Add(MILLIMETRES * size, edge)
                done_edges.append(edge)
            explorer.Next()
        if done_edges:
            builder.Build()
            if builder.IsDone() and occ.BRepCheck_Analyzer(builder.Shape()).IsValid():
                shape = builder.Shape()
    return shape


def _edge_break_size(edge: Any, edges: Sequence[BrokenEdge]) -> float:
    """Return the size [m] of the chamfer or fillet at an edge of OpenCASCADE, from `edges`; 0 if it has none."""
    curve = occ.BRepAdaptor_Curve(edge)
    if curve.GetType() != occ.GeomAbs_CurveType.GeomAbs_Circle or not curve.IsClosed():
        return 0.0
    circle = curve.Circle()
    centre = circle.Location()
    circle_data = np.array([centre.X(), centre.Y(), centre.Z(), circle.Radius()]) / MILLIMETRES
    matches = (
        broken.size
        for broken in edges
        if np.allclose(circle_data, (*broken.centre, broken.z, broken.radius), atol=1e-9)
    )
    return next(matches, 0.0)


def _list(shapes: Sequence[Any]) -> Any:
    """Return a list of OpenCASCADE with shapes."""
    occ_list = occ.List_TopoDS_Shape()
    for shape in shapes:
        occ_list.Append(shape)
    return occ_list


def _extrude(section: PartSection) -> Any:
    """Return the solid of a section."""
    height = occ.gp_Vec(0.0, 0.0, (section.z1 - section.z0) * MILLIMETRES)
    return occ.BRepPrimAPI_MakePrism(planar_face(section, section.z0), height).Shape()


def planar_face(section: PartSection, height: float = 0.0) -> Any:
    """Return a section as a face of OpenCASCADE [mm] at a height along z [m]."""
    z = height * MILLIMETRES
    outline, *holes = [_wire(loop, z) for loop in section.loops]
    plane = occ.gp_Pln(occ.gp_Pnt(0.0, 0.0, z), occ.gp_Dir(0.0, 0.0, 1.0))
    face = occ.BRepBuilderAPI_MakeFace(plane, outline, True)
    for hole in holes:
        hole.Reverse()
        face.Add(hole)
    return face.Face()


def _wire(loop: Sequence[Curve], z: float) -> Any:
    """Return a closed loop of curves at a height [mm]."""
    wire = occ.BRepBuilderAPI_MakeWire()
    for curve in loop:
        wire.Add(_curve_edge(curve, z))
    return wire.Wire()


def _curve_edge(curve: Curve, z: float) -> Any:
    """Convert a curve at a height z [mm] to an edge of OpenCASCADE [mm]."""

    def point(position: Array | tuple[float, float]) -> Any:
        x, y = np.asarray(position) * MILLIMETRES
        return occ.gp_Pnt(float(x), float(y), z)

    match curve:
        case Circle() | Arc():
            frame = occ.gp_Ax2(point(curve.centre), occ.gp_Dir(0.0, 0.0, 1.0))
            ends = (curve.start, curve.end) if isinstance(curve, Arc) else ()
            shape: tuple[Any, ...] = (occ.gp_Circ(frame, curve.radius * MILLIMETRES), *ends)
        case LineSegment():
            shape = (point(curve.start), point(curve.end))
        case Spline():
            knots, counts = np.unique(curve.knots * MILLIMETRES, return_counts=True)
            poles = _array(occ.Array1_gp_Pnt, [point(control) for control in curve.controls])
            knot_array, multiplicities = (
                _array(occ.Array1_double, knots.tolist()),
                _array(occ.Array1_int, counts.tolist()),
            )
            shape = (occ.Geom_BSplineCurve(poles, knot_array, multiplicities, 3),)
    return occ.BRepBuilderAPI_MakeEdge(*shape).Edge()


def _array(kind: Any, items: Sequence[Any]) -> Any:
    """Return an array of OpenCASCADE with values, numbered from 1."""
    array = kind(1, len(items))
    for number, item in enumerate(items, start=1):
        array.SetValue(number, item)
    return array
