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
from cycloid_mj.base.extras import extra
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts import PartSection
from cycloid_mj.parts.curve import Arc, Circle, Curve, LineSegment, Spline
from cycloid_mj.parts.parts import Colour

SPLINES = 6
"""Splines per lobe or root: CAD systems integrate long splines coarsely (0.6 % of the volume with one per lobe)."""


@dataclass(frozen=True)
class Place:
    """Position of a part: its name there, the part, its origin [m], its angle about z [rad], and its rigid body."""

    name: str
    part: str
    origin: tuple[float, float, float]
    angle: float
    body: str = ""


def step_part(name: str, sections: Sequence[PartSection], solids_wanted: int = 1) -> bytes:
    """Encode the sections of a part as STEP solids, one or several; the bytes of equal sections are equal.

    Raises
    ------
    CycloidError
        The package OCP is not installed, or OpenCASCADE cannot build the solid.
    """
    document = _document()
    _add_part(document, name, _build_shape(name, sections, solids_wanted))
    return _encode(document, name)


def step_assembly(
    name: str, parts: Mapping[str, Sequence[PartSection]], colours: Mapping[str, Colour], places: Sequence[Place]
) -> bytes:
    """Encode an assembly of named, coloured parts, each drawn once, with an occurrence of a part at each place.

    Raises
    ------
    CycloidError
        The package OCP is not installed, or OpenCASCADE cannot build a part.
    """
    quantity, gp, tree, location = map(_ocp, ("Quantity", "gp", "XCAFDoc", "TopLoc"))
    document = _document()
    shapes, colouring = (tool(document.Main()) for tool in (_shape_tool, tree.XCAFDoc_DocumentTool.ColorTool_s))
    root = shapes.NewShape()
    _set_name(root, name)
    labels = {part: _add_part(document, part, _build_shape(part, sections)) for part, sections in parts.items()}
    for part, label in labels.items():
        colour = quantity.Quantity_Color(*colours[part][:3], quantity.Quantity_TypeOfColor.Quantity_TOC_sRGB)
        colouring.SetColor(label, colour, tree.XCAFDoc_ColorType.XCAFDoc_ColorSurf)
    axis = gp.gp_Ax1(gp.gp_Pnt(), gp.gp_Dir(0.0, 0.0, 1.0))
    for place in places:
        motion = gp.gp_Trsf()
        motion.SetRotation(axis, place.angle)
        motion.SetTranslationPart(gp.gp_Vec(*(MILLIMETRES * value for value in place.origin)))
        occurrence = shapes.AddComponent(root, labels[place.part], location.TopLoc_Location(motion))
        _set_name(occurrence, place.name)
    shapes.UpdateAssemblies()
    return _encode(document, name)


def read_volume(content: bytes) -> float:
    """Compute the volume [m3] of the solids in a STEP file.

    Raises
    ------
    CycloidError
        The package OCP is not installed.
    """
    reader = _ocp("STEPControl").STEPControl_Reader()
    _silence()
    reader.ReadStream("part.step", BytesIO(content))
    reader.TransferRoots()
    properties = _ocp("GProp").GProp_GProps()
    _ocp("BRepGProp").BRepGProp.VolumeProperties_s(reader.OneShape(), properties)
    return float(properties.Mass()) / MILLIMETRES**3


def _ocp(module: str) -> Any:
    """Import a module of OCP, the Python binding of OpenCASCADE."""
    extra("OCP", "STEP", "cad", "export stl, obj or dxf")
    return import_module(f"OCP.{module}")


def _document() -> Any:
    """Return an empty document for shapes with names and colours."""
    text = _ocp("TCollection").TCollection_ExtendedString
    return _ocp("TDocStd").TDocStd_Document(text("BinXCAF"))


def _shape_tool(label: Any) -> Any:
    return _ocp("XCAFDoc").XCAFDoc_DocumentTool.ShapeTool_s(label)


def _set_name(label: Any, name: str) -> None:
    text = _ocp("TCollection").TCollection_ExtendedString
    _ocp("TDataStd").TDataStd_Name.Set_s(label, text(name))


def _add_part(document: Any, name: str, shape: Any) -> Any:
    """Add a named shape to a document; return its label."""
    label = _shape_tool(document.Main()).AddShape(shape, False)
    _set_name(label, name)
    return label


def _encode(document: Any, name: str) -> bytes:
    """Write a document as STEP, without the time and the machine."""
    text = _ocp("TCollection").TCollection_HAsciiString
    writer = _ocp("STEPCAFControl").STEPCAFControl_Writer()
    _silence()
    writer.Transfer(document, _ocp("STEPControl").STEPControl_StepModelType.STEPControl_AsIs)
    model = writer.ChangeWriter().Model()
    _make_reproducible(model)
    header = _ocp("APIHeaderSection").APIHeaderSection_MakeHeader(model)
    header.SetName(text(f"{name}.step"))
    header.SetOriginatingSystem(text("cycloid_mj"))
    for blank in (header.SetTimeStamp, header.SetAuthorisation):
        blank(text(""))
    for blank in (header.SetAuthorValue, header.SetOrganizationValue):
        blank(1, text(""))
    content = BytesIO()
    writer.WriteStream(content)
    return content.getvalue()


def _make_reproducible(model: Any) -> None:
    """Renumber the occurrences of a file from 1, and sort its colours by part: their order depends on addresses."""
    visual, usage = _ocp("StepVisual"), _ocp("StepRepr").StepRepr_NextAssemblyUsageOccurrence
    entities = [model.Value(number) for number in range(1, model.NbEntities() + 1)]
    for number, occurrence in enumerate((one for one in entities if isinstance(one, usage)), start=1):
        occurrence.SetId(_ocp("TCollection").TCollection_HAsciiString(str(number)))
    kind = visual.StepVisual_MechanicalDesignGeometricPresentationRepresentation
    starts = [number for number, entity in enumerate(entities) if isinstance(entity, kind)]
    if not starts:
        return
    # each starts a chain from a styled solid to its colour; equal colours are shared
    position = {id(entity): number for number, entity in enumerate(entities)}
    chains = [entities[start:end] for start, end in pairwise([*starts, len(entities)])]
    chains.sort(key=lambda styled: position[id(styled[1].Item())])
    rgb, styles = visual.StepVisual_ColourRgb, entities[starts[0] :]
    wanted = sorted(chain.from_iterable(chains), key=lambda one: _rgb(one) if isinstance(one, rgb) else ())
    for number, entity in enumerate(wanted):
        current = styles.index(entity, number)
        if current != number:
            model.ChangeOrder(starts[0] + current + 1, starts[0] + number + 1)
            styles.insert(number, styles.pop(current))


def _rgb(colour: Any) -> tuple[float, float, float]:
    return colour.Red(), colour.Green(), colour.Blue()


def _silence() -> None:
    """Stop OpenCASCADE from writing its messages to stdout."""
    message = _ocp("Message")
    message.Message.DefaultMessenger_s().RemovePrinters(message.Message_Printer.get_type_descriptor_s())


def _build_shape(name: str, sections: Sequence[PartSection], solids_wanted: int = 1) -> Any:
    """Build the union of the sections of a part: a solid, or a compound of several."""
    try:
        first, *others = [_extrude(section) for section in sections]
        shape = _fuse(first, others) if others else first
    except CycloidError:
        raise
    except Exception as error:
        raise CycloidError(
            f"OpenCASCADE cannot build the solid {name}: {error}; check the design with `cycloid-mj design check`"
        ) from error
    count = _count_solids(shape)
    if count != solids_wanted:
        raise CycloidError(
            f"the sections of the {name} make {count} solids instead of {solids_wanted}; check the design"
        )
    return shape


def _count_solids(shape: Any) -> int:
    """Return the number of solids in a shape."""
    explorer = _ocp("TopExp").TopExp_Explorer(shape, _ocp("TopAbs").TopAbs_ShapeEnum.TopAbs_SOLID)
    count = 0
    while explorer.More():
        count += 1
        explorer.Next()
    return count


def _fuse(first: Any, others: Sequence[Any]) -> Any:
    """Return the union of solids, without the faces and edges that it makes superfluous."""
    fuse = _ocp("BRepAlgoAPI").BRepAlgoAPI_Fuse()
    many = _ocp("collections").List_TopoDS_Shape
    for setter, shapes in ((fuse.SetArguments, [first]), (fuse.SetTools, others)):
        collected = many()
        for shape in shapes:
            collected.Append(shape)
        setter(collected)
    fuse.Build()
    fuse.SimplifyResult()
    return fuse.Shape()


def _extrude(section: PartSection) -> Any:
    """Return the solid of a section."""
    build, gp = _ocp("BRepBuilderAPI"), _ocp("gp")
    outline, *holes = [_wire(loop, section.z0 * MILLIMETRES) for loop in section.loops]
    plane = gp.gp_Pln(gp.gp_Pnt(0.0, 0.0, section.z0 * MILLIMETRES), gp.gp_Dir(0.0, 0.0, 1.0))
    face = build.BRepBuilderAPI_MakeFace(plane, outline, True)
    for hole in holes:
        hole.Reverse()
        face.Add(hole)
    height = gp.gp_Vec(0.0, 0.0, (section.z1 - section.z0) * MILLIMETRES)
    return _ocp("BRepPrimAPI").BRepPrimAPI_MakePrism(face.Face(), height).Shape()


def _wire(loop: Sequence[Curve], z: float) -> Any:
    """Return a closed loop of curves at a height [mm]."""
    wire = _ocp("BRepBuilderAPI").BRepBuilderAPI_MakeWire()
    for curve in loop:
        wire.Add(_edge(curve, z))
    return wire.Wire()


def _edge(curve: Curve, z: float) -> Any:
    """Return a curve at a height [mm] as an edge."""
    gp, edge = _ocp("gp"), _ocp("BRepBuilderAPI").BRepBuilderAPI_MakeEdge

    def point(position: Array | tuple[float, float]) -> Any:
        x, y = np.asarray(position) * MILLIMETRES
        return gp.gp_Pnt(float(x), float(y), z)

    match curve:
        case Circle() | Arc():
            frame = gp.gp_Ax2(point(curve.centre), gp.gp_Dir(0.0, 0.0, 1.0))
            circle = gp.gp_Circ(frame, curve.radius * MILLIMETRES)
            return (edge(circle, curve.start, curve.end) if isinstance(curve, Arc) else edge(circle)).Edge()
        case LineSegment():
            return edge(point(curve.start), point(curve.end)).Edge()
        case Spline():
            knots, counts = np.unique(curve.knots * MILLIMETRES, return_counts=True)
            arrays = _ocp("collections")
            poles = _array(arrays.Array1_gp_Pnt, [point(control) for control in curve.controls])
            marks = _array(arrays.Array1_double, knots.tolist())
            times = _array(arrays.Array1_int, counts.tolist())
            return edge(_ocp("Geom").Geom_BSplineCurve(poles, marks, times, 3)).Edge()


def _array(kind: Any, values: Sequence[Any]) -> Any:
    """Return an array of OpenCASCADE with values, numbered from 1."""
    array = kind(1, len(values))
    for number, value in enumerate(values, start=1):
        array.SetValue(number, value)
    return array
