"""Quantities, curves and orders of a measured transmission error."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from cycloid_mj.analysis.spectrum import Orders, periodic_orders
from cycloid_mj.base.array import Array
from cycloid_mj.base.result import Curve, Quantity
from cycloid_mj.base.statistics import peak_to_peak, rms_about_mean
from cycloid_mj.measure.orders import causes
from cycloid_mj.measure.trace import ErrorCurves, Trace, TraceCondition
from cycloid_mj.reducer import Reducer

STATICS = "statics"
_CRANK, _ERROR = "crank angle [deg]", "error [arcsec]"
_ORDER, _AMPLITUDE = "order [cycles in a crank turn]", "amplitude [arcsec]"
_PACES = {"slow": "slow", "speed": "at speed"}
_PLACES = {"gear": "disc", "stage": "output against the disc"}


Found = Mapping[TraceCondition, Trace]
Finer = Mapping[tuple[str, str], Trace]
"""Load and pace -> the start of the forward run, with half the time step."""
Statics = Mapping[TraceCondition, ErrorCurves]


def quantities(reducer: Reducer, traces: Found, finer: Finer, statics: Statics, turns: int) -> list[Quantity]:
    """List the quantities: levels of each case, shifts between cases, and the orders of each cause over some turns."""
    levels = [
        Quantity(
            key=f"{shaft}_{name}_{case.key}",
            name=f"{words} of the {shaft}, {case.words}",
            value=_LEVELS[name][1](getattr(trace, shaft)),
            unit="arcsec",
            error=_step_error(traces, finer, case, shaft, name),
            reference=_LEVELS[name][1](getattr(statics[case], shaft)),
            source=STATICS,
        )
        for case, trace in traces.items()
        for shaft in ("gear", "output")
        for name, (words, _) in _LEVELS.items()
    ]
    return [
        *levels,
        *_shifts(reducer, traces, finer, statics),
        *_cause_quantities(reducer, traces, finer, statics, turns),
    ]


def curves(reducer: Reducer, traces: Found, statics: Statics) -> tuple[Curve, ...]:
    """List the errors over the crank angle, and the spectra of the `chosen` cases.

    The loaded error has its own axes and is first, because a drive works under load and the unloaded one is larger.
    """
    paces = dict.fromkeys(case.pace for case in traces)
    drawn = [
        curve
        for pace in paces
        for shaft in ("output", "gear")
        for load in ("loaded", "unloaded")
        for curve in _panel(traces, statics, pace, shaft, load)
    ]
    drawn += _panel(traces, statics, next(iter(paces)), "output")
    for place, base in _bases(reducer).items():
        for case in chosen(traces):
            seen = _spectrum(reducer, traces[case], place, base)
            panel = f"orders of the {_PLACES[place]}, {case.way}, {_PACES[case.pace]}"
            drawn.append(Curve(panel, case.load, seen.order, seen.amplitude, _ORDER, _AMPLITUDE, "bars"))
    return tuple(drawn)


def _panel(traces: Found, statics: Statics, pace: str, shaft: str, load: str = "") -> Iterator[Curve]:
    """Yield the curves of a shaft at one pace with those of statics: of one load minus their means, or of all."""
    panel, with_mean = f"{shaft}, {f'{load}, ' * bool(load)}{_PACES[pace]}{', minus its mean' * bool(load)}", not load
    shown = {case: f"{case.load}, {case.way}" for case in traces if case.pace == pace and load in ("", case.load)}
    for case, words in shown.items():
        solved = statics[case]
        error = _about_mean(getattr(solved, shaft), with_mean)
        yield Curve(panel, STATICS, np.degrees(solved.crank), error, _CRANK, _ERROR, "theory", words)
    for case, words in shown.items():
        trace = traces[case]
        error = _about_mean(getattr(trace, shaft), with_mean)
        yield Curve(panel, words, np.degrees(trace.crank), error, _CRANK, _ERROR)


def _about_mean(error: Array, with_mean: bool) -> Array:
    return error if with_mean else error - error.mean()


def separates_orders(reducer: Reducer, turns: int) -> bool:
    """Return whether some crank turns separate all orders; those of the output are multiples of N/(N-1)."""
    return turns % reducer.design.lobes == 0


def details(reducer: Reducer, traces: Found, turns: int) -> dict[str, Any]:
    """Return the strongest orders of each case with their causes, the causes, and whether the turns part all orders."""
    return {
        "turns": turns,
        "turns_that_part_orders": reducer.design.lobes,
        "apart": separates_orders(reducer, turns),
        "causes": [cause.as_json() for cause in causes(reducer)],
        "cases": {case.key: _strongest(reducer, trace) for case, trace in traces.items()},
    }


def chosen(traces: Found) -> list[TraceCondition]:
    """List the cases whose orders are evaluated: forward, at the first pace that was run."""
    first = next(iter(traces)).pace
    return [case for case in traces if case.way == "forward" and case.pace == first]


def _shifts(reducer: Reducer, traces: Found, finer: Finer, statics: Statics) -> Iterator[Quantity]:
    """Yield the differences of mean errors: between directions the backlash, between loads the wind-up.

    Both are positive: a carrier turns against the crank and so lags at a larger angle, a ring turns with it and lags at
    a smaller one.
    """
    case = chosen(traces)[0]
    cases = {(trace.load, trace.way): trace for trace in traces if trace.pace == case.pace}
    back, ahead, loaded = ("unloaded", "forward"), ("unloaded", "reverse"), ("loaded", "forward")
    pairs = {
        "reversal": ("forward minus reverse, unloaded: backlash", back, ahead),
        "wind_up": ("loaded minus unloaded, forward: elastic wind-up", loaded, back),
    }
    if reducer.member.sense < 0:
        pairs = {
            "reversal": ("reverse minus forward, unloaded: backlash", ahead, back),
            "wind_up": ("unloaded minus loaded, forward: elastic wind-up", back, loaded),
        }
    for shaft in ("gear", "output"):
        for key, (words, one, other) in pairs.items():
            value, reference = (
                float(np.mean(getattr(source[cases[one]], shaft)) - np.mean(getattr(source[cases[other]], shaft)))
                for source in (traces, statics)
            )
            error = sum(_mean_change(traces, finer, cases[which], shaft) for which in (one, other)) if finer else None
            name = f"mean of the {shaft}, {words}"
            yield Quantity(f"{shaft}_{key}", name, value, "arcsec", error, reference, STATICS)


def _cause_quantities(
    reducer: Reducer, traces: Found, finer: Finer, statics: Statics, turns: int
) -> Iterator[Quantity]:
    """Yield the rms value of each cause's orders, and its strongest order."""
    count = f"{turns} of {reducer.design.lobes} crank turns"
    beside = (
        ""
        if separates_orders(reducer, turns)
        else f"; over {count}, it includes neighbouring orders (use more --turns)"
    )
    for case in chosen(traces):
        for cause in causes(reducer):
            seen, solved = (_spectrum(reducer, part[case], cause.place, cause.base) for part in (traces, statics))
            order, amplitude = cause.strongest(seen)
            yield Quantity(
                key=f"{cause.key}_orders_rms_{case.key}",
                name=f"rms of orders of {cause.name}, {case.words}",
                value=cause.rms(seen),
                unit="arcsec",
                error=rms_about_mean(np.subtract(*_both_errors(traces, finer, case, cause.place))) if finer else None,
                reference=cause.rms(solved),
                source=STATICS,
                note=f"strongest: order {order:.6g} with amplitude {amplitude:.3g} arcsec{beside}",
            )


def _strongest(reducer: Reducer, trace: Trace) -> list[dict[str, Any]]:
    """List the strongest orders of a run with their causes."""
    rows = []
    for place, base in _bases(reducer).items():
        seen = _spectrum(reducer, trace, place, base)
        mine = [cause for cause in causes(reducer) if cause.place == place]
        for k in np.argsort(seen.amplitude)[::-1][:12]:
            order = float(seen.order[k])
            cause = next((item.key for item in mine if item.has(order)), "between")
            rows.append(
                {"shows_in": place, "order": order, "amplitude_arcsec": float(seen.amplitude[k]), "cause": cause}
            )
    return rows


def _bases(reducer: Reducer) -> dict[str, float]:
    return {cause.place: cause.base for cause in causes(reducer)}


def _spectrum(reducer: Reducer, errors: ErrorCurves, signal: str, base: float) -> Orders:
    return periodic_orders(errors.crank, getattr(errors, signal), base, 3 * reducer.design.ring.teeth)


def _step_error(traces: Found, finer: Finer, case: TraceCondition, shaft: str, level: str) -> float | None:
    """Compute the change of a level with half the time step, plus half its change between the halves of the window."""
    if not finer:
        return None
    measure, error = _LEVELS[level][1], getattr(traces[case], shaft)
    coarse, fine = (measure(item) for item in _both_errors(traces, finer, case, shaft))
    first, second = (measure(half) for half in np.array_split(error, 2))
    return abs(coarse - fine) + 0.5 * abs(first - second)


def _mean_change(traces: Found, finer: Finer, case: TraceCondition, signal: str) -> float:
    coarse, fine = _both_errors(traces, finer, case, signal)
    return abs(float(np.mean(fine - coarse)))


def _both_errors(traces: Found, finer: Finer, case: TraceCondition, signal: str) -> tuple[Array, Array]:
    """Return the errors of the forward run under a case's load, and of that with half the time step, where both run."""
    fine = finer[case.load, case.pace]
    coarse = traces[
        next(trace for trace in traces if (trace.load, trace.pace, trace.way) == (case.load, case.pace, "forward"))
    ]
    inside = (coarse.crank >= fine.crank[0] - 1e-9) & (coarse.crank <= fine.crank[-1] + 1e-9)
    return getattr(coarse, signal)[inside], getattr(fine, signal)


_LEVELS: dict[str, tuple[str, Callable[[Array], float]]] = {
    "peak_to_peak": ("peak to peak", peak_to_peak),
    "rms": ("rms about the mean", rms_about_mean),
}
"""Key -> name and measure of an error."""
