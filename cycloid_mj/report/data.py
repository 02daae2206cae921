"""All that the page's figures are drawn from, as JSON."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from cycloid_mj.analysis import FIGURES, SIGNALS, Series, SignalFigure
from cycloid_mj.analysis.spectrum import tapered_orders
from cycloid_mj.base.array import Array
from cycloid_mj.reducer import Reducer
from cycloid_mj.report.encode import decimated, encoded
from cycloid_mj.report.mechanism import mechanism
from cycloid_mj.report.reviewed import Reviewed

MOST_VALUES = 1_000_000
"""Values of curves that a page carries, over all runs: 5 MB."""

MOST_SAMPLES = 40_000
HIGHEST_ORDER = 5
"""Largest order of the spectrum that is shown, in mesh orders."""

MOST_TURNS = 50
"""Crank turns of the hold that the spectrum is taken over."""

HEIGHTS = {1: 2.2, 2: 1.1, 3: 0.8}
"""Number of panels of a figure -> height of each, so that figures side by side are about as high."""


def figures(reviewed: Sequence[Reviewed]) -> list[SignalFigure]:
    """List the figures over time that the runs have something to show in."""
    return [figure for figure in FIGURES if any(figure.shows(item.motion) for item in reviewed)]


def page_data(reviewed: Sequence[Reviewed]) -> dict[str, Any]:
    """Collect all that the page draws from."""
    return {
        "figures": [
            {"name": figure.name, "panels": [_panel(key, HEIGHTS[len(figure.panels)]) for key in figure.panels]}
            for figure in figures(reviewed)
        ],
        "runs": [_run_data(item, len(reviewed)) for item in reviewed],
    }


def curves(motion: Series) -> dict[str, Array]:
    """Map name to values over the whole run, shape (n,), in the units of the panels; a theory's name ends so."""
    by_name = {}
    for key in dict.fromkeys(key for figure in FIGURES if figure.shows(motion) for key in figure.panels):
        signal = SIGNALS[key]
        by_name[key] = signal.simulated(motion)
        if signal.theory:
            by_name[_theory(key)] = signal.theory(motion)
    return by_name


def _panel(key: str, height: float) -> dict[str, Any]:
    signal = SIGNALS[key]
    return {
        "label": signal.label,
        "curve": key,
        "theory": _theory(key) if signal.theory else None,
        "is_error": signal.is_error,
        "theory_name": signal.theory_name,
        "height": height,
    }


def _theory(key: str) -> str:
    return f"{key}_theory"


def _run_data(item: Reviewed, runs: int) -> dict[str, Any]:
    motion, drawn = item.motion, curves(item.motion)
    most = min(MOST_SAMPLES, MOST_VALUES // (runs * len(drawn)))
    time, values = decimated(motion.time, np.stack(list(drawn.values()), axis=1), most)
    judged, turn = motion.time[motion.judged], motion.time[motion.one_turn]
    paths = [figure.path for figure in FIGURES if figure.path and figure.shows(motion)]
    return {
        "name": item.name,
        "colour": item.colour,
        "start": float(time[0]),
        "time": encoded(time - time[0]),
        "curves": {key: encoded(values[:, column]) for column, key in enumerate(drawn)},
        "paths": {path: _path(path, motion) for path in paths},
        "spans": {"hold": _span(judged), "turn": _span(turn), "all": _span(motion.time)},
        "mechanism": mechanism(motion.reducer, item.shown),
        "spectrum": spectrum_data(item),
    }


def _path(key: str, motion: Series) -> dict[str, Any]:
    """Collect a path over one crank turn, shape (m, 2) each, and the unit of both axes; of pin 1 its clearance, too."""
    signal, turn = SIGNALS[key], motion.one_turn
    path = {"unit": signal.unit, "simulated": encoded(signal.simulated(motion)[turn])}
    if signal.theory:
        path["theory"] = encoded(signal.theory(motion)[turn])
    return path | ({"circle": 1e6 * motion.pin_1.clearance} if key == "pin_path" and motion.pin_1 else {})


def _span(time: Array) -> list[float]:
    return [float(time[0]), float(time[-1])]


def spectrum_data(item: Reviewed) -> dict[str, Any] | None:
    """List the order spectra of the output's and the gear's speed; None if there is no whole crank turn of the hold."""
    motion, teeth = item.motion, Reducer(item.motion.design).mesh_periods
    if motion.phase != "hold":
        return None
    swept = np.abs(motion.crank_angle - motion.crank_angle[motion.hold][0]) / (2.0 * np.pi)
    rows = motion.hold & (swept < MOST_TURNS)
    output, gear = (
        tapered_orders(motion.crank_angle[rows], part.simulated[rows], HIGHEST_ORDER * teeth * 1.02)
        for part in (motion.output_speed, motion.gear_speed)
    )
    if output is None or gear is None:
        return None
    return {
        "order": encoded(output.order),
        "output": encoded(1e3 * output.amplitude),
        "gear": encoded(1e3 * gear.amplitude),
        "mesh": teeth,
        "turns": output.cycles,
        "band": list(output.band),
    }
