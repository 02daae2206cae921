"""Style of all figures: settings, palette, and common axes and legends.

The palette is that of Okabe and Ito for colour-blind readers. Theory is a broad light line under the thin dark line of
the simulation, so that both also differ in greyscale.
"""

import re
from collections.abc import Callable
from functools import wraps
from io import BytesIO
from textwrap import wrap
from typing import Any, ParamSpec, TypeVar

import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, MultipleLocator

from cycloid_mj.analysis import MICROMETRE, Series
from cycloid_mj.base.array import Array
from cycloid_mj.base.units import unit_suffix

P = ParamSpec("P")
R = TypeVar("R")

ORANGE, SKY, GREEN, BLUE = "#E69F00", "#56B4E9", "#009E73", "#0072B2"
VERMILION, PURPLE, BLACK, GREY = "#D55E00", "#CC79A7", "#000000", "#8A8A8A"

PALETTE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)
"""Colours of the curves of a panel, in this order."""

THEORY: dict[str, Any] = {"color": "#9CCBEA", "linewidth": 3.2, "solid_capstyle": "butt"}
SIMULATED: dict[str, Any] = {"color": "#0B2E4F", "linewidth": 0.9}
ERROR: dict[str, Any] = {"color": VERMILION, "linewidth": 0.8}
BOTH = (("closed form", THEORY), ("simulation", SIMULATED))

WIDTH = 6.5
"""Width of a figure [in]: the text width of a page."""

SCREEN_DPI, PIXEL_RATIO = 110, 2
"""Size of a figure in a notebook [px/in], and pixels of its picture for each of these: screens are that fine."""

ROUNDING = 1e-6
"""Part of a turn by which an angle may miss a complete turn by rounding."""

STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 8.0,
    "axes.titlesize": 8.5,
    "axes.titlelocation": "left",
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-4, 6),
    "axes.xmargin": 0.0,
    "grid.color": "#E3E3E3",
    "grid.linewidth": 0.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "hatch.linewidth": 0.35,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "legend.handlelength": 2.2,
    "path.simplify_threshold": 0.05,
    "svg.hashsalt": "cycloid_mj",
    "pdf.fonttype": 42,
}


def with_style(draw: Callable[P, R]) -> Callable[P, R]:
    """Decorate a drawing function so that it uses the package's style without changing matplotlib's global settings."""

    @wraps(draw)
    def in_style(*args: P.args, **kwargs: P.kwargs) -> R:
        with style.context(["default", STYLE]):
            return draw(*args, **kwargs)

    return in_style


class NotebookFigure(Figure):
    """A figure that a notebook shows as a picture, without pyplot and its global state."""

    def _repr_png_(self) -> tuple[bytes, dict[str, int]]:
        """Return the picture as PNG, and its size in the notebook [px]."""
        content = BytesIO()
        with style.context(["default", STYLE]):
            self.savefig(content, format="png", dpi=PIXEL_RATIO * SCREEN_DPI)
        width, height = (round(SCREEN_DPI * side) for side in self.get_size_inches())
        return content.getvalue(), {"width": width, "height": height}


def create_figure(height: float) -> Figure:
    """Return an empty figure with the width `WIDTH` and a height [in]."""
    return NotebookFigure(figsize=(WIDTH, height), layout="constrained")


def add_condition(figure: Figure, condition: str) -> None:
    """Add design and condition above a figure in small type."""
    figure.suptitle(condition, x=0.008, ha="left", fontsize=7.5, color=GREY)


def turn_degrees(motion: Series) -> Array:
    """Return the crank angle of the samples of the evaluated turn [deg], shape (n,), without complete turns before it.

    The first angle is between -360 and 360 deg, with the sign of the rotation.
    """
    angle = np.degrees(motion.crank_angle[motion.one_turn])
    return angle - 360.0 * np.trunc(angle[0] / 360.0 + np.copysign(ROUNDING, angle[0]))


def add_degree_axis(axes: Axes) -> None:
    """Add an axis in deg/s on the right of a speed in rad/s."""
    axes.secondary_yaxis("right", functions=(np.degrees, np.radians)).set_ylabel("[deg/s]")


def crank_axis(axes: Axes, degrees: Array) -> None:
    """Set up the x axis for curves against n crank angles `degrees`, (n,): label, limits at whole degrees, ticks.

    Ticks are at multiples of 45 deg if the angles cover about a turn (180 to 400 deg).
    """
    low, high = float(np.floor(degrees.min() + 1e-3)), float(np.ceil(degrees.max() - 1e-3))
    axes.set_xlabel("crank angle [deg]")
    axes.set_xlim(low, max(high, low + 1.0))
    if 180 <= high - low <= 400:
        axes.xaxis.set_major_locator(MultipleLocator(45))


def centre_on_zero(axes: Axes, *errors: Array) -> None:
    """Scale the y axis symmetrically about zero so that it covers all `errors`, and draw a line at zero."""
    largest_error = max(float(np.max(np.abs(error), initial=0.0)) for error in errors) or 1.0
    axes.set_ylim(-1.15 * largest_error, 1.15 * largest_error)
    axes.axhline(0.0, color=BLACK, linewidth=0.5)


def set_square_limits(axes: Axes, limit: float) -> None:
    """Set the limits of both axes to -limit and limit [um], with equal scales and labels in micrometres."""
    axes.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal")
    axes.set(xlabel=f"x [{MICROMETRE}]", ylabel=f"y [{MICROMETRE}]")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))


def typeset(text: str) -> str:
    """Replace hyphens before numbers in a text by minus signs."""
    return re.sub(r"(?<![\w)])-(?=[\d.])|(?<=\de)-(?=\d)", "\N{MINUS SIGN}", text)


def in_words(key: str, unit: str = "") -> str:
    """Return a column name, `key`, in words with its unit.

    ``clearance.cam_um`` in um becomes ``clearance: cam [um]``.
    """
    table, _, name = key.rpartition(".")
    ending = unit_suffix(unit)
    for end in (ending, ending.replace("_", "_per_")):
        name = name.removesuffix(f"_{end}")
    label = name.replace("_", " ") + (f" [{unit}]" if unit else "")
    return f"{table.replace('_', ' ')}: {label}" if table else label


def wrap_label(words: str, width: int) -> str:
    """Break a label into lines of at most `width` characters."""
    return "\n".join(wrap(words, width))


def legend_handles(*entries: tuple[str, dict[str, Any]]) -> list[Line2D]:
    """Return the handles of a legend from pairs of a label and the properties of a line."""
    return [Line2D([], [], label=label, **line_style) for label, line_style in entries]


def legend_above(axes: Axes, *entries: tuple[str, dict[str, Any]]) -> None:
    """Add a one-line legend above the axes on the right."""
    anchor: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.2}
    axes.legend(handles=legend_handles(*entries), ncols=len(entries), **anchor)
