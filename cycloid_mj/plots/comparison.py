"""Designs side by side: one figure for each measure, a column for each load, a row for each design."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cycloid_mj.analysis import Series, condition, load_words
from cycloid_mj.analysis.spectrum import BAND
from cycloid_mj.comparison.forces import cam_force, tooth_forces
from cycloid_mj.comparison.vibration import spectrum
from cycloid_mj.plots.motion import ARCSEC, turn_degrees
from cycloid_mj.plots.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    MICROMETRE,
    ORANGE,
    PURPLE,
    VERMILION,
    WIDTH,
    crank_axis,
    keys,
    styled,
    typeset,
)
from cycloid_mj.types import Array

Grid = Sequence[Sequence[Series]]
Signal = Callable[[Series], Array]

COLORS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE)
ROW, HEAD = 1.25, 0.75
"""Height of a row of axes, and of what stands above and below them [in]."""


def comparison_figures(motions: Sequence[Series]) -> dict[str, Figure]:
    """Give the figures of a comparison by name; one crank turn of the settled hold, but for the spectra.

    Parameters
    ----------
    motions
        The runs, load by load, each in the order of the designs.

    Raises
    ------
    LogError
        A run lacks the forces of its pairs.
    """
    names = list(dict.fromkeys(motion.design.name for motion in motions))
    grid = [[motion for motion in motions if motion.design.name == name] for name in names]
    return {
        "compare_transmission_error": _over_a_turn(
            grid, "Transmission error of the output", "arcsec", lambda m: ARCSEC * m.output_angle.error, about_mean=True
        ),
        "compare_gear_transmission_error": _over_a_turn(
            grid, "Transmission error of the gear", "arcsec", lambda m: ARCSEC * m.gear_angle.error, about_mean=True
        ),
        "compare_output_speed": _over_a_turn(
            grid, "Error of the output's speed", "mrad/s", lambda m: 1e3 * m.output_speed.error
        ),
        "compare_gear_speed": _over_a_turn(
            grid, "Error of the gear's speed", "mrad/s", lambda m: 1e3 * m.gear_speed.error
        ),
        "compare_q_path": _over_a_turn(
            grid, "Distance of q from its path", MICROMETRE, lambda m: 1e6 * m.q_position.error_size
        ),
        "compare_q_speed": _over_a_turn(
            grid, "Error of the speed of q", "mm/s", lambda m: 1e3 * m.q_velocity.size.error
        ),
        "compare_teeth": _over_a_turn(
            grid, "Teeth that carry force", "1", lambda m: np.count_nonzero(tooth_forces(m), axis=1).astype(float)
        ),
        "compare_tooth_force": _over_a_turn(
            grid, "Force on the most loaded tooth", "N", lambda m: tooth_forces(m).max(axis=1)
        ),
        "compare_cam_force": _over_a_turn(grid, "Force of the cam on the gear", "N", cam_force),
        "compare_vibration": _spectra(grid),
    }


@styled
def _over_a_turn(grid: Grid, title: str, unit: str, signal: Signal, about_mean: bool = False) -> Figure:
    """Draw a signal of every run over one crank turn; axes of one load share their scale.

    `about_mean` draws it about its mean, which is told: play and wind-up would hide what swings.
    """
    figure, axes = _sheet(len(grid), len(grid[0]), f"{title}, {_speed(grid)}", sharey="col")
    for row, runs in enumerate(grid):
        for column, motion in enumerate(runs):
            panel, values = axes[row][column], signal(motion)[motion.one_turn]
            degrees, named = turn_degrees(motion), f"{motion.design.name}, {load_words(motion.design.load.torque)}"
            if about_mean:
                mean = float(values.mean())
                values, named = values - mean, typeset(f"{named}: about {mean:.4g} {unit}")
            panel.plot(degrees, values, color=_color(row), linewidth=0.8)
            if values.min() < 0.0 < values.max():
                panel.axhline(0.0, color=BLACK, linewidth=0.5)
            panel.margins(y=0.1)
            panel.set_title(named)
            crank_axis(panel, degrees)
            if row + 1 < len(grid):
                panel.set_xlabel("")
    figure.supylabel(f"[{unit}]" if unit != "1" else "number", fontsize=8.0)
    return figure


@styled
def _spectra(grid: Grid) -> Figure:
    """Draw amplitude spectral densities of the vibration; the mesh frequency and its multiples are dotted."""
    loads = len(grid[0])
    figure, axes = _sheet(
        2, loads, f"Vibration about the closed form, {_speed(grid)}", sharey="row", sharex=True, row=1.9
    )
    for row, runs in enumerate(grid):
        for column, motion in enumerate(runs):
            found = spectrum(motion)
            for panel, density in zip((axes[0][column], axes[1][column]), (found.centre, found.output), strict=True):
                panel.loglog(found.frequency[1:], np.sqrt(density[1:]), color=_color(row), linewidth=0.9)
            if row == 0:
                _mark_mesh(axes[0][column], motion, found.frequency)
                _mark_mesh(axes[1][column], motion, found.frequency)
                axes[0][column].set_title(load_words(motion.design.load.torque))
    for panel in axes[1]:
        panel.set_xlabel(f"frequency [Hz], up to {BAND:g} of the log rate")
    axes[0][0].set_ylabel("gear centre\n[m/s\N{SUPERSCRIPT TWO}/\N{SQUARE ROOT}Hz]")
    axes[1][0].set_ylabel("output\n[rad/s\N{SUPERSCRIPT TWO}/\N{SQUARE ROOT}Hz]")
    entries = [(runs[0].design.name, {"color": _color(row)}) for row, runs in enumerate(grid)]
    mesh = ("multiples of the mesh frequency", {"color": GREY, "linestyle": ":"})
    figure.legend(handles=keys(*entries, mesh), loc="outside lower center", ncols=len(entries) + 1)
    return figure


def _mark_mesh(panel: Axes, motion: Series, frequency: Array) -> None:
    mesh = motion.design.ring.teeth * abs(motion.design.drive.speed) / (2 * np.pi)
    for multiple in np.arange(1, 4) * mesh:
        if frequency[1] < multiple < frequency[-1]:
            panel.axvline(multiple, color=GREY, linewidth=0.7, linestyle=":", zorder=0)


def _sheet(rows: int, columns: int, title: str, row: float = ROW, **shared: Any) -> tuple[Figure, Any]:
    figure = Figure(figsize=(WIDTH, row * rows + HEAD), layout="constrained")
    figure.suptitle(title, x=0.01, ha="left", fontsize=9.5)
    return figure, figure.subplots(rows, columns, squeeze=False, **shared)


def _speed(grid: Grid) -> str:
    """Name the crank speed, which all runs share."""
    return f"{condition(grid[0][0].design).speed_rpm:g} rpm"


def _color(number: int) -> str:
    return COLORS[number % len(COLORS)]
