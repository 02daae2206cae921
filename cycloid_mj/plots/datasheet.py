"""The three A4 pages of a data sheet, and its figures for an HTML page."""

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from cycloid_mj.base.result import Curve, Quantity
from cycloid_mj.design import Design
from cycloid_mj.life.datasheet import Datasheet
from cycloid_mj.plots.style import NotebookFigure, with_style
from cycloid_mj.plots.views import draw_views
from cycloid_mj.reducer import reducer_of


@dataclass(frozen=True)
class PageLayout:
    """Layout of the pages of a data sheet; lengths without a unit are relative to the page."""

    size: tuple[float, float] = (8.27, 11.69)
    """Width and height, A4 [in]."""
    left: float = 0.07
    right: float = 0.93
    """Margins."""
    row: float = 0.0166
    """Height of a row of a table, which is lower if the tables would reach the curves."""
    curves_top: float = 0.28
    """Upper end of the curves with their titles."""
    table_frame: float = 0.0305
    """Height of heading and gap of a table."""
    columns: tuple[float, float, float] = (0.0, 0.41, 0.515)
    """Start of name, unit and condition, relative to the width of a table; values end before the unit."""
    note_width: int = 138
    """Characters of a line of the notes."""
    condition_width: int = 70
    small_width: int = 104
    """Characters of a condition in a single line, and of each of two lines in a smaller font."""


LAYOUT = PageLayout()


NAVY, ACCENT, INK, SOFT, RULE = "#12324F", "#0072B2", "#1A1F24", "#59636E", "#D3DAE0"
KEYS = (
    *(("rated_torque",), ("momentary_torque",), ("backlash",), ("stiffness_ideal",)),
    *(("drive_efficiency_percent", "efficiency"), ("drive_mass_kg", "mass")),
)
"""Quantities of the tiles below the title: of several, the first that a sheet has, that of the complete drive."""

MOUNTING = ("Mass and size", "Output bearing", "Interfaces")
OPERATION = ("Without load", "Lubrication and environment", "Assembly")
"""Headings of the tables on the page of the drawing, and on that of the assumptions."""


@with_style
def datasheet_pages(sheet: Datasheet) -> list[Figure]:
    """Return the pages: performance with curves, mounting with dimensions, assumptions."""
    return [_performance_page(sheet), _mounting_page(sheet), _operation_page(sheet)]


@with_style
def datasheet_pictures(sheet: Datasheet) -> dict[str, Figure]:
    """Draw the diagrams of a data sheet's HTML page: ``views`` (dimensioned views) and ``curves`` (all its curves)."""
    views = NotebookFigure(figsize=(9.0, 6.0))
    draw_views(views.add_axes((0.0, 0.0, 1.0, 1.0)), reducer_of(sheet.design))
    curves = NotebookFigure(figsize=(9.0, 2.7), layout="constrained")
    panels = _curves_by_panel(sheet)
    for axes, panel in zip(curves.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        _draw_panel(axes, panel)
    return {"views": views, "curves": curves}


def _performance_page(sheet: Datasheet) -> Figure:
    """Draw the first page of a data sheet: main quantities, tables of performance, and curves."""
    figure = _empty_page(sheet, 1)
    _draw_tiles(figure, sheet, 0.855)
    top = 0.79
    tables = {key: group for key, group in sheet.groups.items() if key not in (*MOUNTING, *OPERATION)}
    height_of_rows = top - LAYOUT.curves_top - LAYOUT.table_frame * len(tables)
    row_height = min(LAYOUT.row, height_of_rows / sum(map(len, tables.values())))
    for heading, group in tables.items():
        top = _draw_table(figure, heading, group, top, row_height)
    panels = _curves_by_panel(sheet)
    column_width = (LAYOUT.right - LAYOUT.left) / len(panels)
    for column, panel in enumerate(panels):
        _draw_panel(
            figure.add_axes((LAYOUT.left + column * column_width + 0.045, 0.085, column_width - 0.06, 0.165)), panel
        )
    return figure


def _mounting_page(sheet: Datasheet) -> Figure:
    """Draw the second page of a data sheet: tables for mounting, and dimensioned views."""
    figure, top = _empty_page(sheet, 2), 0.868
    for heading in [heading for heading in sheet.groups if heading in MOUNTING]:
        top = _draw_table(figure, heading, sheet.groups[heading], top)
    _draw_heading(figure, "Dimensions of the mechanism [mm]", top)
    views = (LAYOUT.left - 0.02, 0.06, LAYOUT.right - LAYOUT.left + 0.04, top - 0.08)
    draw_views(figure.add_axes(views, anchor="N"), reducer_of(sheet.design))
    return figure


def _operation_page(sheet: Datasheet) -> Figure:
    """Draw the third page of a data sheet: tables for operation and assembly, and the assumptions."""
    figure, top = _empty_page(sheet, 3), 0.868
    for heading in [heading for heading in sheet.groups if heading in OPERATION]:
        top = _draw_table(figure, heading, sheet.groups[heading], top)
    _draw_heading(figure, "Assumptions", top)
    line_y = top - 0.019
    for note in sheet.notes:
        for number, text_line in enumerate(textwrap.wrap(note, LAYOUT.note_width, break_on_hyphens=False)):
            figure.text(LAYOUT.left, line_y, "•" if number == 0 else "", fontsize=6.6, color=ACCENT, va="top")
            figure.text(LAYOUT.left + 0.014, line_y, text_line, fontsize=6.4, color=INK, va="top")
            line_y -= 0.0115
        line_y -= 0.004
    return figure


def _empty_page(sheet: Datasheet, number: int) -> Figure:
    """Return page `number` of the three pages of a data sheet, with header and footer only."""
    figure, design = NotebookFigure(figsize=LAYOUT.size), sheet.design
    figure.add_artist(Rectangle((0.0, 0.913), 1.0, 0.087, facecolor=NAVY, edgecolor="none"))
    figure.add_artist(Rectangle((0.0, 0.909), 1.0, 0.004, facecolor=ACCENT, edgecolor="none"))
    name_size = min(25.0, 25.0 * 22.0 / max(len(design.name), 1))  # long names fit next to the ratio
    figure.text(LAYOUT.left, 0.966, design.name, fontsize=name_size, weight="bold", color="white", va="center")
    size_text = f"Ø{sheet.diameter:.4g} mm"
    figure.text(LAYOUT.left, 0.933, describe_kind(design), fontsize=9.5, color="white", va="center")
    figure.text(
        LAYOUT.right, 0.966, format_ratio(design.reduction), fontsize=21, color="white", ha="right", va="center"
    )
    figure.text(LAYOUT.right, 0.933, size_text, fontsize=9.5, color="white", ha="right", va="center")
    _draw_rule(figure, 0.045, RULE)
    figure.text(LAYOUT.left, 0.03, "Computed by cycloid_mj, not measured", fontsize=6.5, color=SOFT)
    figure.text(LAYOUT.right, 0.03, f"{number} / 3", fontsize=6.5, color=SOFT, ha="right")
    return figure


def describe_kind(design: Design) -> str:
    """Describe the kind of a drive, its ring and the number of discs, for the heading of a data sheet."""
    layout = {"central": "Cycloidal speed reducer", "rv": "RV reducer"}[design.layout]
    ring_text = "ring pins" if design.ring.kind == "pin" else "an internal gear"
    parts = [f"{design.cranks.count} cranks"] if design.cranks else []
    parts += [f"{design.gear.discs} discs"] if design.gear.discs > 1 else []
    return ", ".join([f"{layout} with {ring_text}", *parts])


def format_ratio(ratio: float) -> str:
    """Format a reduction ratio, such as ``35 : 1``."""
    return f"{ratio:.5g} : 1"


def _draw_tiles(figure: Figure, sheet: Datasheet, bottom: float) -> None:
    """Draw the main quantities of a data sheet in a row of boxes.

    `figure` is the page. `bottom` is the vertical position of the row, as a fraction of the page height.
    """
    quantity_by_key = {quantity.key: quantity for group in sheet.groups.values() for quantity in group}
    gap, tile_count = 0.012, len(KEYS)
    width = (LAYOUT.right - LAYOUT.left - (tile_count - 1) * gap) / tile_count
    for column, keys in enumerate(KEYS):
        x = LAYOUT.left + column * (width + gap)
        quantity = next(quantity_by_key[key] for key in keys if key in quantity_by_key)
        figure.add_artist(Rectangle((x, bottom - 0.025), width, 0.062, facecolor="#EEF3F7", edgecolor="none"))
        figure.add_artist(Rectangle((x, bottom - 0.025), 0.004, 0.062, facecolor=ACCENT, edgecolor="none"))
        figure.text(x + 0.012, bottom + 0.023, quantity.name.split(",")[0], fontsize=6.0, color=SOFT, va="center")
        figure.text(
            x + 0.012, bottom + 0.002, format_value(quantity), fontsize=13, weight="bold", color=NAVY, va="center"
        )
        figure.text(x + 0.012, bottom - 0.016, format_unit(quantity.unit), fontsize=6.5, color=SOFT, va="center")


def _draw_table(
    figure: Figure, heading: str, quantities: Sequence[Quantity], top: float, row_height: float = LAYOUT.row
) -> float:
    """Draw a table with name, value, unit and condition of each quantity, and return the position below it.

    `figure` is the page, and `top` the position of the heading. Both positions are vertical, from the bottom of the
    page; like `row_height`, they are fractions of the page height.
    """
    _draw_heading(figure, heading, top)
    name_x, unit_x, condition_x = (LAYOUT.left + share * (LAYOUT.right - LAYOUT.left) for share in LAYOUT.columns)
    line_y = top - 0.0185
    for quantity in quantities:
        text_style: dict[str, Any] = {"fontsize": 7.6, "va": "center", "color": INK}
        figure.text(name_x, line_y, quantity.name, **text_style)
        figure.text(unit_x - 0.012, line_y, format_value(quantity), weight="bold", ha="right", **text_style)
        figure.text(unit_x, line_y, format_unit(quantity.unit), **text_style)
        note_style = {**text_style, "fontsize": 6.2, "color": SOFT}
        if len(quantity.note) > LAYOUT.condition_width:
            note_style |= {"fontsize": 4.7, "linespacing": 1.05}
        figure.text(condition_x, line_y, _wrap_condition(quantity.note), **note_style)
        line_y -= row_height
        _draw_rule(figure, line_y + 0.5 * row_height, RULE, 0.4)
    return line_y - 0.012


def _wrap_condition(text: str) -> str:
    """Wrap a condition that is too long for its column into two lines, which have a smaller font."""
    if len(text) <= LAYOUT.condition_width:
        return text
    return textwrap.fill(text, LAYOUT.small_width, max_lines=2, placeholder=" …")


def format_value(quantity: Quantity) -> str:
    """Format a value with three digits, without a power of ten; a dash if it is not a number."""
    if not np.isfinite(quantity.value):
        return "\N{EN DASH}"
    if quantity.key == "ratio":
        return format_ratio(quantity.value)
    return f"{quantity.value:.3g}" if abs(quantity.value) < 999.5 else f"{float(f'{quantity.value:.4g}'):.0f}"


def format_unit(unit: str) -> str:
    """Return a unit with its symbols, such as µm and cm²; empty for a number without a unit."""
    return "" if unit == "1" else unit.replace("um", "µm").translate(str.maketrans("23", "²³"))


def _draw_heading(figure: Figure, text: str, level: float) -> None:
    figure.text(LAYOUT.left, level, text, fontsize=9.5, weight="bold", color=ACCENT, va="center")
    _draw_rule(figure, level - 0.0095, ACCENT)


def _draw_rule(figure: Figure, level: float, colour: str, width: float = 0.8) -> None:
    figure.add_artist(
        Rectangle((LAYOUT.left, level), LAYOUT.right - LAYOUT.left, 1e-3 * width, facecolor=colour, edgecolor="none")
    )


def _curves_by_panel(sheet: Datasheet) -> list[list[Curve]]:
    """Return the curves of each panel, in their order."""
    by_panel: dict[str, list[Curve]] = {}
    for curve in sheet.curves:
        by_panel.setdefault(curve.panel, []).append(curve)
    return list(by_panel.values())


def _draw_panel(axes: Axes, curves: Sequence[Curve]) -> None:
    """Draw the curves of one diagram of a data sheet, with title, axis labels and legend."""
    for curve, colour in zip(curves, (ACCENT, SOFT), strict=False):
        axes.plot(curve.x, curve.y, color=colour, linewidth=1.4, marker="o", markersize=2.2, label=curve.name)
    first_curve, values = curves[0], np.concatenate([curve.y for curve in curves])
    axes.set_title(first_curve.panel, fontsize=8.0, weight="bold", color=NAVY)
    axes.set_xlabel(first_curve.x_label, fontsize=7.0)
    axes.set_ylabel(first_curve.y_label, fontsize=7.0)
    axes.tick_params(labelsize=6.5)
    low, high = float(values.min()), float(values.max())
    if low > 0.0:
        y_min = 0.0 if low < 0.5 * high else 0.9 * low
        axes.set_ylim(y_min, high + 0.08 * (high - y_min))
    if len(curves) > 1:
        axes.legend(fontsize=6.0, frameon=False)
    axes.margins(x=0.04)
