"""The data of a report's charts as JSON values."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from cycloid_mj.analysis import FIGURES, SIGNALS, Series, SignalFigure
from cycloid_mj.analysis.spectrum import tapered_orders
from cycloid_mj.base.array import Array
from cycloid_mj.report.encode import decimate, encode_array
from cycloid_mj.report.mechanism import mechanism
from cycloid_mj.report.reviewed import Reviewed

MAX_VALUES = 1_000_000
"""Values of all curves of a page: 5 MB."""

MAX_SAMPLES = 40_000
"""Samples of a curve, of a page with few runs."""

MAX_MESH_ORDERS = 5
"""Highest order of the spectrum, as a multiple of the mesh order."""

MAX_SPECTRUM_TURNS = 50
"""Crank turns of the hold from which the spectrum is computed."""

HEIGHTS = {1: 2.2, 2: 1.1, 3: 0.8}
"""Number of panels of a chart -> relative height of each, so that charts next to each other are about equally high."""


def figures(reviewed: Sequence[Reviewed]) -> list[SignalFigure]:
    """Return the charts over time for which at least one run has data."""
    return [figure for figure in FIGURES if any(figure.shows(item.motion) for item in reviewed)]


def page_data(reviewed: Sequence[Reviewed]) -> dict[str, Any]:
    """Return the data of all charts and mechanisms of a page."""
    return {
        "figures": [
            {"name": figure.name, "panels": [_panel(key, HEIGHTS[len(figure.panels)]) for key in figure.panels]}
            for figure in figures(reviewed)
        ],
        "runs": [_run_data(item, len(reviewed)) for item in reviewed],
    }


def curves(motion: Series) -> dict[str, Array]:
    """Return the curves of a run in the units of their panels, shape (n,) each; closed forms end in _theory."""
    by_name = {}
    for key in dict.fromkeys(key for figure in FIGURES if figure.shows(motion) for key in figure.panels):
        signal = SIGNALS[key]
        by_name[key] = signal.simulated(motion)
        if signal.theory:
            by_name[_theory(key)] = signal.theory(motion)
    return by_name


def _panel(key: str, height: float) -> dict[str, Any]:
    """Return label, curves and height of a panel."""
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
    """Return the data of a run on a page with a number of runs."""
    motion, signals = item.motion, curves(item.motion)
    max_samples = min(MAX_SAMPLES, MAX_VALUES // (runs * len(signals)))
    time, values = decimate(motion.time, np.stack(list(signals.values()), axis=1), max_samples)
    judged, turn = motion.time[motion.evaluation_mask], motion.time[motion.one_turn]
    paths = [figure.path for figure in FIGURES if figure.path and figure.shows(motion)]
    return {
        "name": item.name,
        "colour": item.colour,
        "start": float(time[0]),
        "time": encode_array(time - time[0]),
        "curves": {key: encode_array(values[:, column]) for column, key in enumerate(signals)},
        "paths": {path: _path(path, motion) for path in paths},
        "spans": {"hold": _span(judged), "turn": _span(turn), "all": _span(motion.time)},
        "mechanism": mechanism(motion.reducer, item.shown),
        "spectrum": spectrum_data(item),
    }


def _path(key: str, motion: Series) -> dict[str, Any]:
    """Return a path over one crank turn, shape (m, 2), and the unit of both axes; for pin 1 also its clearance."""
    signal, turn = SIGNALS[key], motion.one_turn
    path = {"unit": signal.unit, "simulated": encode_array(signal.simulated(motion)[turn])}
    if signal.theory:
        path["theory"] = encode_array(signal.theory(motion)[turn])
    return path | ({"circle": 1e6 * motion.pin_1.clearance} if key == "pin_path" and motion.pin_1 else {})


def _span(time: Array) -> list[float]:
    return [float(time[0]), float(time[-1])]


def spectrum_data(item: Reviewed) -> dict[str, Any] | None:
    """Return the order spectra of output and disc speed; None if the hold has no complete crank turn."""
    motion, teeth = item.motion, item.motion.reducer.mesh_periods
    if motion.phase != "hold":
        return None
    swept = np.abs(motion.crank_angle - motion.crank_angle[motion.hold][0]) / (2.0 * np.pi)
    rows = motion.hold & (swept < MAX_SPECTRUM_TURNS)
    output, gear = (
        tapered_orders(motion.crank_angle[rows], part.simulated[rows], MAX_MESH_ORDERS * teeth * 1.02)
        for part in (motion.output_speed, motion.gear_speed)
    )
    if output is None or gear is None:
        return None
    return {
        "order": encode_array(output.order),
        "output": encode_array(1e3 * output.amplitude),
        "gear": encode_array(1e3 * gear.amplitude),
        "mesh": teeth,
        "turns": output.cycles,
        "band": list(output.band),
    }
