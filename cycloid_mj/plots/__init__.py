"""Figures of runs and results, and drawings of the mechanism.

The only package that imports matplotlib. Every figure is independent of pyplot: no window, no global state.
"""

import numpy.typing as npt
from matplotlib.figure import Figure

from cycloid_mj.analysis import Series, condition, series
from cycloid_mj.base.record import Run
from cycloid_mj.plots.mechanism import mechanism
from cycloid_mj.plots.motion import gear_speed_figure, input_figure, transmission_error_figure
from cycloid_mj.plots.pin import pin_figure
from cycloid_mj.plots.point import path_figure, velocity_figure
from cycloid_mj.plots.save import FigureError, save
from cycloid_mj.plots.style import add_condition

__all__ = ["FigureError", "figures", "mechanism", "save"]


def figures(run: Run | Series, q: npt.ArrayLike | None = None) -> dict[str, Figure]:
    """Draw the diagrams of a run, and return them by name, each with its load and speed in the heading.

    They show speeds of crank and disc, path and velocity of point q, transmission error and, if pins can move, pin 1.
    ``fig5_input`` covers the entire run, all others one crank turn.

    Parameters
    ----------
    run
        A run, or its series if they have been computed already.
    q
        Point of the disc whose path and velocity are drawn, (x, y) in the frame of the disc [m]. Default: centre of
        hole 1. Not used for series, which have their own point.

    Raises
    ------
    LogError
        The run has no design, lacks a column, or has fewer than two samples.
    UsageError
        `q` is not a point.
    """
    motion = run if isinstance(run, Series) else series(run, q)
    figures_by_name = {
        "transmission_error": transmission_error_figure(motion),
        "fig5_input": input_figure(motion),
        "fig6_gear_speed": gear_speed_figure(motion),
        "fig7_q_path": path_figure(motion),
        "fig8_q_speed": velocity_figure(motion),
    }
    if motion.pin_1:
        figures_by_name["fig9_pin1"] = pin_figure(motion, motion.pin_1)
    ramp_note = "" if motion.phase == "hold" else ", a run that ended in its ramp"
    disc_note = f"; gear and q: {motion.gear_words}" if motion.design.gear.discs > 1 else ""
    for figure in figures_by_name.values():
        add_condition(figure, f"{motion.design.name}, {condition(motion.reducer)}{ramp_note}{disc_note}")
    return figures_by_name
