"""Quantities, curves and orders of a measured transmission error."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from cycloid_mj.analysis.spectrum import Orders, periodic_orders
from cycloid_mj.base.array import Array
from cycloid_mj.base.result import Curve, Quantity
from cycloid_mj.base.statistics import peak_to_peak, rms_about_mean
from cycloid_mj.measure.orders import OUTPUT_RUNOUT, Signal, causes
from cycloid_mj.measure.trace import ErrorCurves, Trace, TraceCondition
from cycloid_mj.reducer import Reducer

STATICS = "statics"
_CRANK, _ERROR = "crank angle [deg]", "error [arcsec]"
_ORDER, _AMPLITUDE = "order [cycles in a crank turn]", "amplitude [arcsec]"
_PACES = {"slow": "slow", "speed": "at speed"}
_SIGNAL_NAMES: Mapping[Signal, str] = {"gear": "disc", "stage": "output against the disc", "output": "output"}


Traces = Mapping[TraceCondition, Trace]
FinerTraces = Mapping[tuple[str, str], Trace]
"""(load, pace) -> first part of the forward run, repeated with half the time step."""
Statics = Mapping[TraceCondition, ErrorCurves]


def quantities(
    reducer: Reducer, traces: Traces, finer_traces: FinerTraces, statics: Statics, turns: int
) -> list[Quantity]:
    """Return all quantities of the transmission error [arcsec].

    A condition is load, direction and speed of a run. The quantities are peak to peak and rms of each condition, the
    shifts of the mean error between conditions, and for each cause, such as mesh or ring, the rms of the orders
    [cycles per crank turn] that it excites.

    Parameters
    ----------
    reducer
        The drive.
    traces
        Simulated errors of each condition.
    finer_traces
        (load, pace) -> errors in the first part of the forward run, repeated with half the time step; empty without
        this check. The pace is ``slow`` or ``speed`` (full speed).
    statics
        Transmission errors of each condition, computed by statics.
    turns
        Crank turns of a trace.
    """
    levels = [
        Quantity(
            key=f"{shaft}_{level}_{condition.key}",
            name=f"{level_name} of the {shaft}, {condition.words}",
            value=_LEVELS[level][1](getattr(trace, shaft)),
            unit="arcsec",
            error=_step_error(traces, finer_traces, condition, shaft, level),
            reference=_LEVELS[level][1](getattr(statics[condition], shaft)),
            source=STATICS,
        )
        for condition, trace in traces.items()
        for shaft in ("gear", "output")
        for level, (level_name, _) in _LEVELS.items()
    ]
    return [
        *levels,
        *_shift_quantities(reducer, traces, finer_traces, statics),
        *_cause_quantities(reducer, traces, finer_traces, statics, turns),
    ]


def curves(reducer: Reducer, traces: Traces, statics: Statics) -> tuple[Curve, ...]:
    """Return curves of the transmission errors [arcsec] over the crank angle, and of some of their amplitude spectra.

    `traces` are the simulated errors and `statics` those by statics, by load, direction and speed. The spectra are
    those of simulated forward runs at one speed (`evaluated_conditions`). The loaded error is drawn first and in a
    panel of its own, because the unloaded error is larger.
    """
    paces = dict.fromkeys(condition.pace for condition in traces)
    curve_list = [
        curve
        for pace in paces
        for shaft in ("output", "gear")
        for load in ("loaded", "unloaded")
        for curve in _panel_curves(traces, statics, pace, shaft, load)
    ]
    curve_list += _panel_curves(traces, statics, next(iter(paces)), "output")
    for signal, cycles_per_turn in _bases(reducer):
        for condition in evaluated_conditions(traces):
            spectrum = _spectrum(reducer, traces[condition], signal, cycles_per_turn)
            panel = f"orders of the {_signal_name(reducer, signal, cycles_per_turn)}, {condition.direction}, "
            panel += _PACES[condition.pace]
            curve_list.append(
                Curve(panel, condition.load, spectrum.order, spectrum.amplitude, _ORDER, _AMPLITUDE, "bars")
            )
    return tuple(curve_list)


def _panel_curves(traces: Traces, statics: Statics, pace: str, shaft: str, load: str = "") -> Iterator[Curve]:
    """Yield the error [arcsec] of a `shaft`, "gear" or "output", over the crank angle, simulated and by statics.

    `traces` are the simulated errors by condition. Only conditions at one `pace`, the speed "slow" or "speed" (full),
    are drawn. With a `load`, only its conditions are drawn, and the mean is subtracted from each error; otherwise, all
    loads are drawn with their means.
    """
    panel, with_mean = f"{shaft}, {f'{load}, ' * bool(load)}{_PACES[pace]}{', minus its mean' * bool(load)}", not load
    labels = {
        condition: f"{condition.load}, {condition.direction}"
        for condition in traces
        if condition.pace == pace and load in ("", condition.load)
    }
    for condition, label in labels.items():
        static_curves = statics[condition]
        error = _remove_mean(getattr(static_curves, shaft), with_mean)
        yield Curve(panel, STATICS, np.degrees(static_curves.crank), error, _CRANK, _ERROR, "theory", label)
    for condition, label in labels.items():
        trace = traces[condition]
        error = _remove_mean(getattr(trace, shaft), with_mean)
        yield Curve(panel, label, np.degrees(trace.crank), error, _CRANK, _ERROR)


def _remove_mean(error: Array, with_mean: bool) -> Array:
    return error if with_mean else error - error.mean()


def separates_orders(reducer: Reducer, turns: int) -> bool:
    """Return whether some crank turns separate all orders; those of the output are multiples of N/(N-1)."""
    return turns % reducer.design.lobes == 0


def covers_output_turn(reducer: Reducer, turns: int) -> bool:
    """Return whether `turns` of the crank relative to the ring are at least a turn of the output."""
    return turns >= reducer.design.lobes


def order_details(reducer: Reducer, traces: Traces, turns: int) -> dict[str, Any]:
    """Return the strongest orders (cycles per crank turn) of the transmission error in each run, as JSON values.

    `traces` are the errors over crank `turns` by condition (load, direction, speed). In the result, "causes" explains
    which orders mesh, ring and other parts excite, and "cases" has the orders by condition. "turns_that_part_orders" is
    the smallest number of turns that separates the orders of ring and holes, "apart" whether `turns` separates them.
    """
    return {
        "turns": turns,
        "turns_that_part_orders": reducer.design.lobes,
        "apart": separates_orders(reducer, turns),
        "causes": [cause_of_orders.as_json() for cause_of_orders in causes(reducer)],
        "cases": {condition.key: _strongest_orders(reducer, trace) for condition, trace in traces.items()},
    }


def evaluated_conditions(traces: Traces) -> list[TraceCondition]:
    """List the cases whose orders are evaluated: forward, at the first pace that was run."""
    first_pace = next(iter(traces)).pace
    return [condition for condition in traces if condition.direction == "forward" and condition.pace == first_pace]


def _shift_quantities(
    reducer: Reducer, traces: Traces, finer_traces: FinerTraces, statics: Statics
) -> Iterator[Quantity]:
    """Yield the backlash and the elastic wind-up of disc and output [arcsec], as differences of mean errors.

    The backlash is the difference between both directions without load, the wind-up that between the loads. The order
    of subtraction makes both positive, whether the output is a carrier, which turns against the crank, or a ring, which
    turns with the crank. `traces` and `statics` are the errors by simulation and by statics, for each condition (load,
    direction, speed). `finer_traces` are the errors of runs with half the time step, for the numerical error.
    """
    evaluated_condition = evaluated_conditions(traces)[0]
    by_load_and_direction = {
        (trace.load, trace.direction): trace for trace in traces if trace.pace == evaluated_condition.pace
    }
    forward_unloaded, reverse_unloaded, forward_loaded = (
        ("unloaded", "forward"),
        ("unloaded", "reverse"),
        ("loaded", "forward"),
    )
    pairs = {
        "reversal": ("forward minus reverse, unloaded: backlash", forward_unloaded, reverse_unloaded),
        "wind_up": ("loaded minus unloaded, forward: elastic wind-up", forward_loaded, forward_unloaded),
    }
    if reducer.member.sense < 0:
        pairs = {
            "reversal": ("reverse minus forward, unloaded: backlash", reverse_unloaded, forward_unloaded),
            "wind_up": ("unloaded minus loaded, forward: elastic wind-up", forward_unloaded, forward_loaded),
        }
    for shaft in ("gear", "output"):
        for key, (shift_name, minuend, subtrahend) in pairs.items():
            shift, reference = (
                float(
                    np.mean(getattr(source[by_load_and_direction[minuend]], shaft))
                    - np.mean(getattr(source[by_load_and_direction[subtrahend]], shaft))
                )
                for source in (traces, statics)
            )
            error = (
                sum(
                    _mean_change(traces, finer_traces, by_load_and_direction[load_case], shaft)
                    for load_case in (minuend, subtrahend)
                )
                if finer_traces
                else None
            )
            name = f"mean of the {shaft}, {shift_name}"
            yield Quantity(f"{shaft}_{key}", name, shift, "arcsec", error, reference, STATICS)


def _cause_quantities(
    reducer: Reducer, traces: Traces, finer_traces: FinerTraces, statics: Statics, turns: int
) -> Iterator[Quantity]:
    """Yield the rms transmission error [arcsec] in the orders of each cause, such as the meshing of teeth.

    There is one quantity for each load, from forward runs at one speed, and each cause. The run-out of the output is
    left out if the runs are shorter than a turn of the output. The note of a quantity has the strongest
    order (cycles per crank turn). `traces` and `statics` are the simulated and static errors by condition (load,
    direction, speed) over crank `turns`; the static value is the reference. `finer_traces` are runs with half the
    time step, from which the numerical error follows; without them it is None.
    """
    turns_text = f"{turns} of {reducer.design.lobes} crank turns"
    neighbour_note = (
        ""
        if separates_orders(reducer, turns)
        else f"; over {turns_text}, it includes neighbouring orders (use more --turns)"
    )
    for condition in evaluated_conditions(traces):
        for cause_of_orders in causes(reducer):
            if cause_of_orders.key == OUTPUT_RUNOUT and not covers_output_turn(reducer, turns):
                continue
            simulated_orders, static_orders = (
                _spectrum(reducer, source[condition], cause_of_orders.signal, cause_of_orders.base)
                for source in (traces, statics)
            )
            order, amplitude = cause_of_orders.strongest(simulated_orders)
            yield Quantity(
                key=f"{cause_of_orders.key}_orders_rms_{condition.key}",
                name=f"rms of orders of {cause_of_orders.name}, {condition.words}",
                value=cause_of_orders.rms(simulated_orders),
                unit="arcsec",
                error=rms_about_mean(
                    np.subtract(*_overlapping_errors(traces, finer_traces, condition, cause_of_orders.signal))
                )
                if finer_traces
                else None,
                reference=cause_of_orders.rms(static_orders),
                source=STATICS,
                note=f"strongest: order {order:.6g} with amplitude {amplitude:.3g} arcsec{neighbour_note}",
            )


def _strongest_orders(reducer: Reducer, trace: Trace) -> list[dict[str, Any]]:
    """Return the twelve strongest orders (cycles per crank turn) of a transmission error, as JSON objects.

    `trace` has the errors of disc and output, which have twelve orders each. The keys are ``order``,
    ``amplitude_arcsec``, ``cause``, and ``shows_in``, the rotation with this error: gear, output or stage. Orders that
    no cause excites, which are due to leakage from other orders, have the cause "between".
    """
    rows = []
    for signal, cycles_per_turn in _bases(reducer):
        spectrum = _spectrum(reducer, trace, signal, cycles_per_turn)
        causes_of_signal = [
            cause
            for cause in causes(reducer)
            if cause.signal == signal and (cause.base == cycles_per_turn or cause.key == OUTPUT_RUNOUT)
        ]
        for index in np.argsort(spectrum.amplitude)[::-1][:12]:
            order = float(spectrum.order[index])
            cause = next(
                (possible_cause.key for possible_cause in causes_of_signal if possible_cause.has(order)), "between"
            )
            rows.append(
                {
                    "shows_in": signal,
                    "order": order,
                    "amplitude_arcsec": float(spectrum.amplitude[index]),
                    "cause": cause,
                }
            )
    return rows


def _bases(reducer: Reducer) -> tuple[tuple[Signal, float], ...]:
    """List the signals in which orders appear, each with the base of its orders [1]; a signal may have two bases.

    The order of the output's run-out is not a base: the spectra of the other bases include it if the runs cover a turn
    of the output.
    """
    return tuple(dict.fromkeys((cause.signal, cause.base) for cause in causes(reducer) if cause.key != OUTPUT_RUNOUT))


def _signal_name(reducer: Reducer, signal: Signal, base: float) -> str:
    """Return the name of a signal, with the base of its orders if it has another base as well."""
    has_two_bases = sum(signal == other_signal for other_signal, _ in _bases(reducer)) > 1
    return f"{_SIGNAL_NAMES[signal]}{f', multiples of {base:.4g}' if has_two_bases else ''}"


def _spectrum(reducer: Reducer, errors: ErrorCurves, signal: str, base: float) -> Orders:
    return periodic_orders(errors.crank, getattr(errors, signal), base, 3 * reducer.design.ring.teeth)


def _step_error(
    traces: Traces, finer_traces: FinerTraces, condition: TraceCondition, shaft: str, level: str
) -> float | None:
    """Estimate the numerical error of a statistic of the transmission error [arcsec]; None without finer runs.

    It is the change of the statistic with half the time step, plus half of its change between both halves of the run.

    Parameters
    ----------
    traces, finer_traces
        Errors of each condition, and of the runs with half the time step.
    condition, shaft
        Load, direction and speed of the run; and "gear" (the disc) or "output".
    level
        Key of the statistic in `_LEVELS`, "peak_to_peak" or "rms".
    """
    if not finer_traces:
        return None
    statistic, error = _LEVELS[level][1], getattr(traces[condition], shaft)
    coarse_value, fine_value = (
        statistic(error_part) for error_part in _overlapping_errors(traces, finer_traces, condition, shaft)
    )
    first_half_value, second_half_value = (statistic(half_error) for half_error in np.array_split(error, 2))
    return abs(coarse_value - fine_value) + 0.5 * abs(first_half_value - second_half_value)


def _mean_change(traces: Traces, finer_traces: FinerTraces, condition: TraceCondition, signal: str) -> float:
    coarse_errors, fine_errors = _overlapping_errors(traces, finer_traces, condition, signal)
    return abs(float(np.mean(fine_errors - coarse_errors)))


def _overlapping_errors(
    traces: Traces, finer_traces: FinerTraces, condition: TraceCondition, signal: str
) -> tuple[Array, Array]:
    """Return the transmission errors of a forward run and of its repetition with half the time step.

    The run has the load and the speed ("pace") of `condition`. `traces` are the transmission errors by condition, and
    `finer_traces` those with half the time step by load and pace, for the first part of the run. `signal` is an
    attribute of `Trace`, such as "output".

    Returns
    -------
    tuple of Array
        Errors with the full and with half the time step [arcsec], at their n common crank angles, shape (n,) each.
    """
    fine_trace = finer_traces[condition.load, condition.pace]
    coarse_trace = traces[
        next(
            trace
            for trace in traces
            if (trace.load, trace.pace, trace.direction) == (condition.load, condition.pace, "forward")
        )
    ]
    is_common = (coarse_trace.crank >= fine_trace.crank[0] - 1e-9) & (coarse_trace.crank <= fine_trace.crank[-1] + 1e-9)
    return getattr(coarse_trace, signal)[is_common], getattr(fine_trace, signal)


_LEVELS: dict[str, tuple[str, Callable[[Array], float]]] = {
    "peak_to_peak": ("peak to peak", peak_to_peak),
    "rms": ("rms about the mean", rms_about_mean),
}
"""Statistics of a transmission error: key -> name, and function that computes the statistic."""
