"""Exploded view: the section of an assembled drive, and its parts along the axis in the order of assembly."""

from collections.abc import Sequence
from itertools import zip_longest

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from cycloid_mj.base import names
from cycloid_mj.base.units import MILLIMETRES
from cycloid_mj.life.rv import crank_bearing_ratings
from cycloid_mj.parts import VISUAL_CHORD_ERROR, Prism
from cycloid_mj.parts.cut import cut_prism
from cycloid_mj.parts.export.assembly import COLOURS, assembly_parts, assembly_step, place_parts
from cycloid_mj.parts.export.bill import bill_csv
from cycloid_mj.parts.export.casing import Casing
from cycloid_mj.parts.export.order import ALONG, assembly_order
from cycloid_mj.parts.export.print_files import BILL
from cycloid_mj.parts.export.rv_bill import rv_bill
from cycloid_mj.parts.export.step import PlacedPart
from cycloid_mj.plots.save import encode_figure
from cycloid_mj.plots.style import WIDTH, NotebookFigure, with_style
from cycloid_mj.reducer import Reducer, RvReducer

GAP = 0.12
"""Distance between parts of the exploded view, relative to the outer radius of the housing."""

AXIS = {"color": "#7A8590", "linewidth": 0.45, "linestyle": (0, (9, 2.5, 1.5, 2.5))}
HEIGHT = 6.2  # of the figure [in]

ASSEMBLY, ORDER, EXPLODED = "assembly.step", "assembly.txt", "exploded.png"
"""Files of an assembly."""


def assembly_files(reducer: Reducer, casing: Casing | None) -> dict[str, bytes]:
    """Encode the assembly (STEP), and where there are covers its exploded view (PNG) and the order of assembly.

    An RV reducer has no covers; its bill of materials is added. Errors as `assembly_step`.
    """
    files = {ASSEMBLY: assembly_step(reducer, 0.0, casing)}
    if isinstance(reducer, RvReducer):
        ratings = crank_bearing_ratings(reducer)[1]
        return files | {BILL: bill_csv(rv_bill(reducer, (ratings.dynamic, ratings.static)))}
    return files | instruction_files(reducer, casing) if casing else files


def instruction_files(reducer: Reducer, casing: Casing) -> dict[str, bytes]:
    """Encode the exploded view of a drive (PNG) and the order of its assembly (text)."""
    steps = (f"{number}. {step}\n" for number, step in enumerate(assembly_order(reducer, casing), start=1))
    return {EXPLODED: encode_figure(exploded_figure(reducer, casing), "png"), ORDER: "".join(steps).encode()}


@with_style
def exploded_figure(reducer: Reducer, casing: Casing) -> Figure:
    """Draw the axial section of a drive twice: assembled, and below it exploded along the axis.

    In the exploded view, the groups of `exploded_groups` follow each other, with a label that has the number of their
    parts. Parts off the axis are rotated about it into the plane of the section.
    """
    geometry, components = assembly_parts(reducer, casing), place_parts(reducer, 0.0, casing)
    prisms = {name: part.solid(VISUAL_CHORD_ERROR).prisms for name, part in geometry.items()}
    figure = NotebookFigure(figsize=(2.0 * WIDTH, HEIGHT), layout="constrained")
    assembled_axes, exploded_axes = figure.subplots(2, 1)
    gap, start = GAP * reducer.design.housing.outer_radius, 0.0
    for position, members in enumerate(exploded_groups(components)):
        family = names.family(members[0].part)
        end_heights = [
            component.origin[2] + z
            for component in members
            for prism in prisms[component.part]
            for z in (prism.z0, prism.z1)
        ]
        shift, largest_radius = start - min(end_heights), 0.0
        for component in members:
            _draw_section(assembled_axes, component, prisms[component.part], 0.0)
        for component in members:
            largest_radius = max(largest_radius, _draw_section(exploded_axes, component, prisms[component.part], shift))
        start += max(end_heights) - min(end_heights) + gap
        mid_height = MILLIMETRES * (shift + 0.5 * (min(end_heights) + max(end_heights)))
        label = family.replace("_", " ") + (f" x{len(members)}" if len(members) > 1 else "")
        exploded_axes.annotate(
            f"{position + 1}  {label}",
            (mid_height, MILLIMETRES * largest_radius),
            (mid_height, 1.12 * MILLIMETRES * casing.outer),
            rotation=60,
            fontsize=6.5,
            arrowprops={"arrowstyle": "-", "linewidth": 0.3, "color": "#7A8590"},
        )
    for axes in (assembled_axes, exploded_axes):
        axes.set_aspect("equal")
        axes.axis("off")
        axes.autoscale_view()
        axes.plot(axes.get_xlim(), (0.0, 0.0), **AXIS)
    assembled_axes.set_title(f"{reducer.design.name}, assembled: motor on the left, output on the right")
    return figure


def exploded_groups(components: Sequence[PlacedPart]) -> tuple[tuple[PlacedPart, ...], ...]:
    """Return the parts of a drive in groups that stay together in the exploded view, from input to output.

    `components` are all parts. Families of parts that are not in `ALONG`, such as rollers, are left out. Equal parts
    are one group, but cams and spacers of several discs stand alone, because each spacer is between two cams.
    """
    parts_by_family: dict[str, list[PlacedPart]] = {}
    for component in components:
        parts_by_family.setdefault(names.family(component.part), []).append(component)
    spacers = parts_by_family.pop(names.SPACER, [])
    groups: list[tuple[PlacedPart, ...]] = []
    for family in (family for family in ALONG if family in parts_by_family):
        if family == names.CAM:
            pairs = zip_longest(parts_by_family[family], spacers)
            groups += [(part,) for pair in pairs for part in pair if part]
        else:
            groups.append(tuple(parts_by_family[family]))
    return tuple(groups)


def _draw_section(axes: Axes, component: PlacedPart, prisms: tuple[Prism, ...], shift: float) -> float:
    """Draw the section of a part with a plane through the reducer's axis, in mm; the axis points to the right.

    A part off the axis is rotated about it into the plane, so that its centre is above the axis. A cycloid disc is
    not rotated: it is cut at the y coordinate of its centre. Return the height of the section above the axis [m].

    Parameters
    ----------
    component, prisms
        The part with its position, and the prisms that it consists of.
    shift
        Displacement of the part along the axis [m].
    """
    x, y, z = component.origin
    distance = float(np.hypot(x, y))
    red, green, blue, _ = COLOURS[names.family(component.part)]
    outer_radius = 0.0
    for prism in prisms:
        for low, high in cut_prism(prism, (0.0, distance if names.family(component.part) != names.GEAR else y)):
            corner = MILLIMETRES * (prism.z0 + z + shift), MILLIMETRES * low
            size = MILLIMETRES * (prism.z1 - prism.z0), MILLIMETRES * (high - low)
            axes.add_patch(Rectangle(corner, *size, facecolor=(red, green, blue), edgecolor="#26323D", linewidth=0.3))
            outer_radius = max(outer_radius, high)
    return outer_radius
