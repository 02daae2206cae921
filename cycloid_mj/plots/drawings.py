"""Drawings of manufactured parts as the pages of a PDF file."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.parts.export.casing import Casing
from cycloid_mj.parts.export.drawing import (
    Dimension,
    PartDrawing,
    dimension_lines,
    drawing_dxf,
    part_drawings,
    sheet_ends,
)
from cycloid_mj.parts.export.rv_drawing import rv_part_drawings
from cycloid_mj.plots.save import document
from cycloid_mj.plots.style import with_style
from cycloid_mj.reducer import Reducer, RvReducer

PAGE = (16.54, 11.69)
"""Size of a page, A3 [in]."""

ARROW = {"arrowstyle": "<->", "linewidth": 0.35, "shrinkA": 0.0, "shrinkB": 0.0}


def drawing_files(reducer: Reducer, casing: Casing | None) -> dict[str, bytes]:
    """Draw the manufactured parts of a drive, and return the contents of the files: file name -> bytes.

    The files are ``drawings.pdf`` with a page for each part, and ``NAME-drawing.dxf`` for each part. With `casing`
    None, the result is empty, except for an RV reducer, which has no casing.

    Raises
    ------
    DesignError
        A part cannot be manufactured.
    CycloidError
        The package ezdxf is not installed.
    """
    if isinstance(reducer, RvReducer):
        drawings = rv_part_drawings(reducer)
    elif casing:
        drawings = part_drawings(reducer, casing)
    else:
        return {}
    pages = [drawing_figure(drawing) for drawing in drawings]
    return {"drawings.pdf": document(pages)} | {f"{item.name}-drawing.dxf": drawing_dxf(item) for item in drawings}


@with_style
def drawing_figure(drawing: PartDrawing) -> Figure:
    """Draw a manufactured part on an A3 page in mm: hatched section with dimensions, front view, notes and title block.

    `drawing` is the drawing in metres. In the section, the axis of the part (+z) points to the right. The
    front view is seen along the axis and has its own scale.
    """
    figure = Figure(figsize=PAGE)
    section_axes, front_axes = figure.add_axes((0.03, 0.28, 0.55, 0.68)), figure.add_axes((0.6, 0.34, 0.37, 0.6))
    for left, right, bottom, top in drawing.section:
        corner = MILLIMETRES * left, MILLIMETRES * bottom
        width, height = MILLIMETRES * (right - left), MILLIMETRES * (top - bottom)
        section_axes.add_patch(
            Rectangle(corner, width, height, facecolor="none", edgecolor="black", hatch="////", linewidth=0.5)
        )
    for outline in drawing.front:
        front_axes.add_patch(
            Polygon(MILLIMETRES * outline, closed=True, facecolor="none", edgecolor="black", linewidth=0.4)
        )
    for start, end, dimension in dimension_lines(drawing):
        _draw_dimension(section_axes, start, end, dimension)
    for axes in (section_axes, front_axes):
        axes.set_aspect("equal")
        axes.axis("off")
        axes.autoscale_view()
    min_x, max_x, bottom, top = sheet_ends(drawing)
    section_axes.set_xlim(min_x, max_x)
    section_axes.set_ylim(bottom, top)
    front_axes.axhline(0.0, color="grey", linewidth=0.3, linestyle="-.")
    front_axes.axvline(0.0, color="grey", linewidth=0.3, linestyle="-.")
    section_axes.axhline(0.0, color="grey", linewidth=0.3, linestyle="-.")
    figure.text(0.03, 0.25, "\n".join(drawing.notes), va="top", fontsize=7.5)
    figure.text(
        0.97, 0.04, "\n".join((*drawing.title, "dimensions in mm, ISO 128, first angle")), ha="right", fontsize=9.0
    )
    return figure


def _draw_dimension(axes: Axes, start: tuple[float, float], end: tuple[float, float], dimension: Dimension) -> None:
    """Draw a dimension line between the points `start` and `end`, (x, y) in mm, with its text.

    The text of a diameter is vertical, to the left of the line. The text of a length is above the line.
    """
    axes.annotate("", end, start, arrowprops=ARROW)
    middle = 0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])
    rotation = 90.0 if dimension.radius else 0.0
    axes.text(
        *middle, dimension.text, rotation=rotation, ha="center", va="bottom", fontsize=6.5, rotation_mode="anchor"
    )
