"""Relative curvature of the contact lines of designs: the argument of Hsieh 2014 for the internal gear."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from cycloid_mj.design import Design
from cycloid_mj.geometry.contact_lines import ContactLines, contact_lines, mesh_period, peak_pressure
from cycloid_mj.geometry.modification import tooth_profile
from cycloid_mj.plots.comparison import COLORS
from cycloid_mj.plots.style import GREY, crank_axis, create_figure, legend_handles, with_style
from cycloid_mj.reducer import Reducer, reducer_of

CRANK_ANGLES = 120
"""Crank angles per mesh period: with 36 teeth the contact lines are 1/12 deg of phase apart."""

ON_TEETH: dict[str, Any] = {"linestyle": "-"}
ON_SIGMA: dict[str, Any] = {"linestyle": (0, (4, 1.5))}
PARTS: tuple[tuple[tuple[str, ...], dict[str, Any]], ...] = (
    (("pin", "arc"), ON_TEETH),
    (("sigma1",), ON_SIGMA),
    (("sigma2",), ON_SIGMA),
)
MAX_LINE_WIDTH = 4.0
"""Line width of the first design [pt]; further designs have narrower lines, so that equal curves remain visible."""


@with_style
def curvature_figure(designs: Sequence[Design]) -> Figure:
    """Draw the relative curvature and the Hertz pressure of the contact lines against their phase on the disc.

    All contact lines over a mesh period are drawn, and all `designs` in the same two panels. The pressure is that of a
    single line under the working force of the teeth at the rated load (`Contact.force`). At phase 0 deg the ring tooth
    touches a valley of the disc, at 180 deg the tip of a lobe.
    """
    figure = create_figure(4.4)
    curvature_axes, pressure_axes = figure.subplots(2, 1, sharex=True)
    for index, design in enumerate(designs):
        gear = tooth_profile(design)
        lines = contact_lines(gear, design.ring.kind, mesh_period(gear, CRANK_ANGLES))
        line_style = {"color": COLORS[index % len(COLORS)], "linewidth": MAX_LINE_WIDTH * (1 - index / len(designs))}
        _draw_flanks(curvature_axes, lines, 1e-3 * lines.relative_curvature, line_style)
        _draw_flanks(pressure_axes, lines, 1e-6 * _pressure(lines, reducer_of(design)), line_style)
    curvature_axes.set_title("Relative normal curvature of the contact lines")
    curvature_axes.set_ylabel("curvature [1/mm]")
    force_text = ", ".join(
        f"{force:.4g}" for force in dict.fromkeys(_working_force(reducer_of(design)) for design in designs)
    )
    pressure_axes.set_title(f"Hertz pressure of a single contact line under {force_text} N")
    pressure_axes.set_ylabel("pressure [MPa]")
    for panel in (curvature_axes, pressure_axes):
        panel.set_ylim(bottom=0.0)
        crank_axis(panel, np.array([0.0, 360.0]))
        panel.axvline(180.0, color=GREY, linewidth=0.6)
        panel.xaxis.set_major_locator(MultipleLocator(30))
    curvature_axes.set_xlabel("")
    pressure_axes.set_xlabel("phase of the contact [deg]: 0 valley, 180 tip of a lobe of the disc")
    design_entries: list[tuple[str, dict[str, Any]]] = [
        (design.name, {"color": COLORS[design_index % len(COLORS)]}) for design_index, design in enumerate(designs)
    ]
    flank_entries: list[tuple[str, dict[str, Any]]] = [
        ("pin or arc", {"color": GREY, **ON_TEETH}),
        ("flank Sigma", {"color": GREY, **ON_SIGMA}),
    ]
    figure.legend(
        handles=legend_handles(*design_entries, *flank_entries),
        loc="outside lower center",
        ncols=len(design_entries) + 2,
    )
    return figure


def _draw_flanks(axes: Axes, lines: ContactLines, values: Any, line_style: dict[str, Any]) -> None:
    """Draw values of contact lines, shape (n,), over their phase, with a style for each kind of flank."""
    for parts, flank_style in PARTS:
        rows = np.flatnonzero(np.isin(lines.part, parts))
        rows = rows[np.argsort(lines.phase[rows])]
        if rows.size:
            axes.plot(np.degrees(lines.phase[rows]), values[rows], **line_style, **flank_style)


def _working_force(reducer: Reducer) -> float:
    return reducer.at_rated_load.contacts[reducer.design.tooth_pair].force


def _pressure(lines: ContactLines, reducer: Reducer) -> Any:
    modulus = reducer.contacts[reducer.design.tooth_pair].modulus
    return peak_pressure(lines, _working_force(reducer), reducer.design.gear.face_width, modulus)
