"""The data of a report's charts as JSON values."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_mj.analysis import FIGURES, SIGNALS, Series, SignalFigure
from cycloid_mj.analysis.spectrum import tapered_orders
from cycloid_mj.base.array import Array
from cycloid_mj.reducer import RvReducer
from cycloid_mj.report.encode import decimate, encode_array
from cycloid_mj.report.mechanism import mechanism
from cycloid_mj.report.reviewed import Reviewed


@dataclass(frozen=True)
class ChartLimits:
    """Size of the charts of a report, so that its file stays small."""

    max_values: int = 1_000_000
    """Values of all curves of a page: 5 MB."""
    max_samples: int = 40_000
    """Samples of a curve, of a page with few runs."""
    max_mesh_orders: int = 5
    """Highest order of the spectrum, as a multiple of the mesh order."""
    max_spectrum_turns: int = 50
    """Crank turns of the hold from which the spectrum is computed."""


CHARTS = ChartLimits()


SPECTRUM_MARGIN = 1.02
"""End of a spectrum over the highest mesh order, so that this is inside."""

HEIGHTS = {1: 2.2, 2: 1.1, 3: 0.8}
"""Number of panels of a chart -> relative height of each, so that charts next to each other are about equally high."""


def figures(reviewed: Sequence[Reviewed]) -> list[SignalFigure]:
    """Return the charts over time for which at least one run has data."""
    return [figure for figure in FIGURES if any(figure.shows(item.motion) for item in reviewed)]


def page_data(reviewed: Sequence[Reviewed]) -> dict[str, Any]:
    """Return the data of a report page of runs as JSON values, in lists ``figures`` (charts) and ``runs``.

    `reviewed` are the analysed runs. ``figures`` has name and panels of each chart (`_panel_json`), ``runs`` the data
    of each run (`_run_data`).
    """
    return {
        "figures": [
            {"name": figure.name, "panels": [_panel_json(key, HEIGHTS[len(figure.panels)]) for key in figure.panels]}
            for figure in figures(reviewed)
        ],
        "runs": [_run_data(reviewed_run, len(reviewed)) for reviewed_run in reviewed],
    }


def curves(motion: Series) -> dict[str, Array]:
    """Return the curves of a run over its n samples in the units of `SIGNALS`: name -> values (n,).

    `motion` are the time series of the run. Only charts that apply to the run have curves. Names are keys of `SIGNALS`;
    the closed form of a signal has the name of the signal with ``_theory`` appended.
    """
    curve_by_name = {}
    for key in dict.fromkeys(key for figure in FIGURES if figure.shows(motion) for key in figure.panels):
        signal = SIGNALS[key]
        curve_by_name[key] = signal.simulated(motion)
        if signal.theory:
            curve_by_name[_theory_key(key)] = signal.theory(motion)
    return curve_by_name


def _panel_json(key: str, height: float) -> dict[str, Any]:
    """Return the description of a chart's panel as JSON values: label, names of its curves, and height.

    `key` is the name of the signal in `SIGNALS`, and `height` is one of `HEIGHTS`.
    """
    signal = SIGNALS[key]
    return {
        "label": signal.label,
        "curve": key,
        "theory": _theory_key(key) if signal.theory else None,
        "is_error": signal.is_error,
        "theory_name": signal.theory_name,
        "height": height,
    }


def _theory_key(key: str) -> str:
    return f"{key}_theory"


def _run_data(reviewed_run: Reviewed, run_count: int) -> dict[str, Any]:
    """Return the data of a run as JSON values: curves, paths, mechanism and spectrum.

    `reviewed_run` is the analysed run. `run_count` is the number of runs on the page: curves are decimated so that all
    runs together have at most `CHARTS.max_values` values. ``time`` [s] counts from the first sample, which is at the
    time ``start`` [s] of the run. ``spans`` has the first and last time [s] of the evaluated part (``hold``), of one
    crank turn (``turn``), and of the run (``all``).
    """
    motion, signals = reviewed_run.motion, curves(reviewed_run.motion)
    max_samples = min(CHARTS.max_samples, CHARTS.max_values // (run_count * len(signals)))
    time, values = decimate(motion.time, np.stack(list(signals.values()), axis=1), max_samples)
    evaluated_times, turn_times = motion.time[motion.evaluation_mask], motion.time[motion.one_turn]
    paths = [figure.path for figure in FIGURES if figure.path and figure.shows(motion)]
    return {
        "name": reviewed_run.name,
        "colour": reviewed_run.colour,
        "start": float(time[0]),
        "time": encode_array(time - time[0]),
        "curves": {key: encode_array(values[:, column]) for column, key in enumerate(signals)},
        "paths": {path: _path_json(path, motion) for path in paths},
        "spans": {
            "hold": _first_and_last(evaluated_times),
            "turn": _first_and_last(turn_times),
            "all": _first_and_last(motion.time),
        },
        "mechanism": None if isinstance(motion.reducer, RvReducer) else mechanism(motion.reducer, reviewed_run.shown),
        "spectrum": spectrum_data(reviewed_run),
    }


def _path_json(key: str, motion: Series) -> dict[str, Any]:
    """Return a path over one crank turn as JSON values: points (m, 2) of m samples, and their unit.

    `key` is the name of the path in `SIGNALS`, `motion` are the time series of the run. The keys are ``simulated`` and
    ``unit``, and ``theory`` if the path has a closed form. The path of pin 1 has its clearance as ``circle`` [um].
    """
    signal, turn = SIGNALS[key], motion.one_turn
    path = {"unit": signal.unit, "simulated": encode_array(signal.simulated(motion)[turn])}
    if signal.theory:
        path["theory"] = encode_array(signal.theory(motion)[turn])
    return path | ({"circle": 1e6 * motion.pin_1.clearance} if key == "pin_path" and motion.pin_1 else {})


def _first_and_last(time: Array) -> list[float]:
    return [float(time[0]), float(time[-1])]


def spectrum_data(item: Reviewed) -> dict[str, Any] | None:
    """Compute the order spectra of output and disc speed as JSON values; None without a crank turn at constant speed.

    `item` is the analysed run. The spectra are evaluated over all full crank turns, ``turns``, within the first
    `CHARTS.max_spectrum_turns` at constant speed. ``output`` and ``gear`` are the amplitudes [mrad/s] at the orders
    ``order``, in cycles per crank turn. ``mesh`` is the order of the tooth mesh; spectra reach `CHARTS.max_mesh_orders`
    times this order. ``band`` has the lowest and highest order whose amplitude is accurate to 1 %.
    """
    motion, mesh_order = item.motion, item.motion.reducer.mesh_periods
    if motion.phase != "hold":
        return None
    turns_since_start = np.abs(motion.crank_angle - motion.crank_angle[motion.hold][0]) / (2.0 * np.pi)
    is_evaluated = motion.hold & (turns_since_start < CHARTS.max_spectrum_turns)
    crank_angle, max_order = motion.crank_angle[is_evaluated], CHARTS.max_mesh_orders * mesh_order * SPECTRUM_MARGIN
    output_spectrum, disc_spectrum = (
        tapered_orders(crank_angle, speed.simulated[is_evaluated], max_order)
        for speed in (motion.output_speed, motion.gear_speed)
    )
    if output_spectrum is None or disc_spectrum is None:
        return None
    return {
        "order": encode_array(output_spectrum.order),
        "output": encode_array(1e3 * output_spectrum.amplitude),
        "gear": encode_array(1e3 * disc_spectrum.amplitude),
        "mesh": mesh_order,
        "turns": output_spectrum.cycles,
        "band": list(output_spectrum.band),
    }
