"""Comparison of designs: one figure per quantity, a column for each load, a row for each design."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cycloid_mj.analysis import SIGNALS, Series, Signal, condition
from cycloid_mj.analysis.spectrum import SPECTRUM
from cycloid_mj.base.array import Array
from cycloid_mj.base.names import CRANK_BEARING
from cycloid_mj.base.result import load_words
from cycloid_mj.comparison.forces import cam_force, crank_bearing_force, tooth_forces
from cycloid_mj.comparison.vibration import spectrum
from cycloid_mj.plots import style
from cycloid_mj.reducer import reducer_of

Grid = Sequence[Sequence[Series]]

COLORS = (style.BLUE, style.VERMILION, style.GREEN, style.PURPLE, style.ORANGE)
ABOUT_MEAN = (SIGNALS["output_te"], SIGNALS["gear_te"])
OVER_A_TURN = {
    "transmission_error": ("Transmission error of the output", SIGNALS["output_te"]),
    "gear_transmission_error": ("Transmission error of the disc", SIGNALS["gear_te"]),
    "output_speed": ("Speed error of the output", SIGNALS["output_speed_error"]),
    "gear_speed": ("Speed error of the disc", SIGNALS["gear_speed_error"]),
    "q_path": ("Path error of point q", SIGNALS["q_error"]),
    "q_speed": ("Velocity error of point q", SIGNALS["q_speed_error"]),
    "teeth": ("Loaded teeth", Signal("teeth", lambda m: np.count_nonzero(tooth_forces(m), axis=1) + 0.0)),
    "tooth_force": ("Force on the most loaded tooth", Signal("force [N]", lambda m: tooth_forces(m).max(axis=1))),
}
"""Name of the figure -> title and signal."""

FORCES = {
    "cam_force": ("cam", "Force of the cam on the disc", Signal("force [N]", cam_force)),
    "crank_bearing_force": (
        CRANK_BEARING,
        "Force on the most loaded crank bearing of the disc",
        Signal("force [N]", crank_bearing_force),
    ),
}
"""Name of the figure -> kind of pair that all designs must have, title and signal."""

MAX_TITLE, SMALL = 40, {"fontsize": 7.2}
"""Characters of a title that fit above a panel, and the style of longer titles."""

ROW, HEAD = 1.25, 0.75
"""Height of a row of axes, and of title and legend [in]."""


def comparison_captions(designs: Sequence[str]) -> dict[str, str]:
    """Return the captions of the diagrams of a comparison: name of the diagram -> one sentence.

    `designs` are the names of the compared designs.
    """
    names = " and ".join(designs)
    titles = {name: title for name, (title, _) in OVER_A_TURN.items()}
    titles |= {name: title for name, (_, title, _) in FORCES.items()}
    captions = {
        f"compare_{name}": f"{title} over one crank turn of the settled hold: {names}, one column for each load."
        for name, title in titles.items()
    }
    return captions | {
        "compare_vibration": f"Amplitude spectra of the vibration of {names} about the closed form.",
        "compare_curvature": f"Curvature of the tooth profiles of {names}.",
    }


def comparison_figures(motions: Sequence[Series]) -> dict[str, Figure]:
    """Draw a comparison of runs: a diagram for each signal over one crank turn, and one of the spectra, by name.

    The crank turn is `Series.one_turn`.

    Parameters
    ----------
    motions
        The runs, one for each design and load. Every design has the same loads in the same order.
    """
    names = list(dict.fromkeys(motion.design.name for motion in motions))
    grid = [[motion for motion in motions if motion.design.name == name] for name in names]
    signals = OVER_A_TURN | {
        name: (title, signal)
        for name, (kind, title, signal) in FORCES.items()
        if all(kind in motion.reducer.mechanism.kinds for motion in motions)
    }
    figures = {f"compare_{name}": _draw_signal(grid, title, signal) for name, (title, signal) in signals.items()}
    return figures | {"compare_vibration": _draw_spectra(grid)}


@style.with_style
def _draw_signal(grid: Grid, title: str, signal: Signal) -> Figure:
    """Draw a signal, such as the disc speed, of every run over one crank turn: a row per design, a column per load.

    `grid` has a sequence of runs for each design, one per load. `title` is the title of the figure. All axes in a
    column have the same scale. The mean of a transmission error is subtracted and stated in the heading, because
    backlash and wind-up would hide its variation.
    """
    unit = signal.unit
    figure, axes = _empty_figure(len(grid), len(grid[0]), f"{title}, {_speed(grid)}", sharey="col")
    for row, runs in enumerate(grid):
        for column, motion in enumerate(runs):
            panel, values = axes[row][column], signal.simulated(motion)[motion.one_turn]
            degrees = style.turn_degrees(motion)
            heading = f"{motion.design.name}, {load_words(motion.design.load.torque)}"
            if signal in ABOUT_MEAN:
                mean = float(values.mean())
                values, heading = values - mean, style.typeset(f"{heading}: mean {mean:.4g} {unit}")
            panel.plot(degrees, values, color=_color(row), linewidth=0.8)
            if values.min() < 0.0 < values.max():
                panel.axhline(0.0, color=style.BLACK, linewidth=0.5)
            panel.margins(y=0.1)
            panel.set_title(heading, **(SMALL if len(heading) > MAX_TITLE else {}))
            style.crank_axis(panel, degrees)
            if row + 1 < len(grid):
                panel.set_xlabel("")
    figure.supylabel(f"[{unit}]" if unit else "number", fontsize=8.0)
    return figure


@style.with_style
def _draw_spectra(grid: Grid) -> Figure:
    """Draw the spectra of the vibration, a column for each load, with dotted lines at multiples of the mesh frequency.

    Spectra are the square roots of the spectral densities of acceleration: that of the disc's centre in the upper row,
    that of the output in the lower row. `grid` has a sequence of runs for each design, one per load.
    """
    loads = len(grid[0])
    figure, axes = _empty_figure(
        2, loads, f"Vibration about the closed form, {_speed(grid)}", sharey="row", sharex=True, row_height=1.9
    )
    for row, runs in enumerate(grid):
        for column, motion in enumerate(runs):
            spectra = spectrum(motion)
            for panel, spectral_density in zip(
                (axes[0][column], axes[1][column]), (spectra.centre, spectra.output), strict=True
            ):
                panel.loglog(spectra.frequency[1:], np.sqrt(spectral_density[1:]), color=_color(row), linewidth=0.9)
            if row == 0:
                _mark_mesh(axes[0][column], motion, spectra.frequency)
                _mark_mesh(axes[1][column], motion, spectra.frequency)
                axes[0][column].set_title(load_words(motion.design.load.torque))
    for panel in axes[1]:
        panel.set_xlabel(f"frequency [Hz], up to {SPECTRUM.band:g} of the log rate")
    axes[0][0].set_ylabel("disc centre\n[m/s\N{SUPERSCRIPT TWO}/\N{SQUARE ROOT}Hz]")
    axes[1][0].set_ylabel("output\n[rad/s\N{SUPERSCRIPT TWO}/\N{SQUARE ROOT}Hz]")
    entries = [(runs[0].design.name, {"color": _color(row)}) for row, runs in enumerate(grid)]
    mesh_entry = ("multiples of the mesh frequency", {"color": style.GREY, "linestyle": ":"})
    figure.legend(
        handles=style.legend_handles(*entries, mesh_entry), loc="outside lower center", ncols=len(entries) + 1
    )
    return figure


def _mark_mesh(panel: Axes, motion: Series, frequency: Array) -> None:
    """Mark the mesh frequency and its first two multiples in a panel, where within the range of `frequency` [Hz]."""
    mesh_frequency = motion.reducer.mesh_periods * abs(motion.reducer.orbit_speed) / (2 * np.pi)
    for frequency_multiple in np.arange(1, 4) * mesh_frequency:
        if frequency[1] < frequency_multiple < frequency[-1]:
            panel.axvline(frequency_multiple, color=style.GREY, linewidth=0.7, linestyle=":", zorder=0)


def _empty_figure(
    rows: int, columns: int, title: str, row_height: float = ROW, **subplot_options: Any
) -> tuple[Figure, Any]:
    """Return a figure with a title and a grid of axes; `row_height` is the height of each row [in]."""
    figure = style.NotebookFigure(figsize=(style.WIDTH, row_height * rows + HEAD), layout="constrained")
    figure.suptitle(title, x=0.01, ha="left", fontsize=9.5)
    return figure, figure.subplots(rows, columns, squeeze=False, **subplot_options)


def _speed(grid: Grid) -> str:
    """Return the crank speed, which is common to all runs, in words."""
    return f"{condition(reducer_of(grid[0][0].design)).speed_rpm:g} rpm"


def _color(number: int) -> str:
    return COLORS[number % len(COLORS)]
