"""A calibration: the design that a measured loop is that of, how sure each of its values is, and what stays open."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.engine import Progress, silent
from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.base.frame import Cell, Frame, framed
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.result import Table
from cycloid_mj.base.units import DEGREE
from cycloid_mj.bench.fit import AT_BOUND, FitStopped, Fitted, fit
from cycloid_mj.bench.loop import DEFLECTION, MeasuredLoop, require_torque
from cycloid_mj.bench.loop_figures import DEFINITIONS, LoopReading, coulomb_of, read_figures, width_of
from cycloid_mj.bench.model_selection import (
    WRITTEN,
    LoopStretch,
    Variant,
    candidates,
    fit_candidates,
    preferred,
    stretches,
    variants,
)
from cycloid_mj.bench.overlay import LoopCondition, model_branches
from cycloid_mj.bench.parameters import DEFAULT, RUBBING, STANDS_FOR_RUBBING, Model, parameters, rub
from cycloid_mj.bench.search import DISCREPANCY, STEP, FitProblem, Trials
from cycloid_mj.bench.uncertainty import COVERED
from cycloid_mj.design import Design, Friction, Named, resolve
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.friction_path import Held, Losses

ALIKE = 0.95
"""Correlation from which on a loop cannot tell two values apart."""

MOST_KNOWN = 0.5
"""Share of what is known of a value from which on the drawing tells it, and not the loops."""

SILENT = 1e-6
"""Change of the residuals, as shares of a loop's ranges and by a parameter's scale, below which there is none."""

RADIANS, MINUTES = 8.0, 30.0
"""How much lower than the design's own a loop is at least that is taken to be in radians; how much higher one in
minutes of arc."""

LOSSES = (
    ("constant", "constant friction alone", (), False),
    ("friction", "and friction of the contacts", ("friction",), True),
    ("material", "and a lossy material, no friction of the contacts", ("material_loss",), False),
    ("both", "and both", ("friction", "material_loss"), True),
)
"""Losses that are compared: key, meaning, what is fitted beside the rest, and whether contacts rub."""

RESIDUAL = (
    "rms difference of all measured deflections from the fitted loop's at the same torque, without those on the way to "
    "the loop"
)
"""How the residual of a calibration is read."""

INTERVALS = (
    f"the intervals of 95 % include an assumed model error of {DISCREPANCY:.0%} of each loop's ranges (rms), whatever "
    "its course, and do not become narrower with less noise; those of noise alone assume that the model is exact"
)
"""What the intervals of the values cover."""

STOPPED = (
    "stopped before the end of the fit: the values are the likeliest so far, and intervals are those of the straight "
    "neighbourhood where no search had widened them"
)
"""What holds of a fit that was stopped."""

UNEXPLAINED = (
    "twist of housing, discs, shafts and mounting is not told apart: structure_stiffness stands for all of it",
    "friction of the crank is not told apart from that of the wind-up: drag and hysteresis stand for both",
    "creep is left out: where the torque rests, a plastic part turns on, and the model does not",
    "contacts are linear springs at one working force: what stiffens with the load is the number of teeth alone",
)
"""What no parameter stands for."""


@dataclass(frozen=True)
class Estimate:
    """One fitted value, in its `unit`.

    Attributes
    ----------
    value, unit, meaning
        The value and its definition.
    ci95, noise95
        Ends of its intervals of 95 %: with the assumed model error (`INTERVALS`), and of the measurement's noise alone
        about the likeliest value; no numbers for a value at its bound.
    identified
        Whether the loop determines it: both ends of `ci95` follow from the loop, not from the bounds of the search, nor
        for the most part from the drawing, and the interval is no wider than the value.
    drawn, deviation, source
        What is known of it without the loops: where the search began, its standard deviation, inf where nothing is
        known, and what says so.
    """

    value: float
    unit: str
    meaning: str
    ci95: tuple[float, float]
    noise95: tuple[float, float]
    identified: bool
    drawn: float
    deviation: float
    source: str


@dataclass(frozen=True, eq=False, repr=False)
class Calibration(Presented):
    """A calibrated design, and how well the measured loops determine it.

    Attributes
    ----------
    fitted
        The fit.
    design
        The calibrated design.
    estimates
        Fitted values by key.
    alike
        Pairs of keys that the loop cannot distinguish, with their correlation.
    measured, modelled
        Figures of the measured loops, and of the fitted model's at the same torques, by the same definitions.
    variants
        Fits with other losses, if they were requested (`compare_losses`).
    candidates
        Fits of the candidate models (`model_selection.CANDIDATES`); none where other values than the default were
        fitted.
    notes
        Remarks, a sentence each.
    complete
        Whether the fit was not stopped before its end.
    """

    fitted: Fitted
    design: Design
    estimates: dict[str, Estimate]
    alike: tuple[tuple[str, str, float], ...]
    measured: LoopReading
    modelled: LoopReading
    variants: tuple[Variant, ...] = ()
    candidates: tuple[Variant, ...] = ()
    notes: tuple[str, ...] = ()
    complete: bool = True

    @property
    def frame(self) -> Frame:
        """The fitted values, a row each."""
        rows: list[dict[str, Cell]] = [
            {
                "key": key,
                "value": one.value,
                "unit": one.unit,
                "low": one.ci95[0],
                "high": one.ci95[1],
                "identified": one.identified,
            }
            for key, one in self.estimates.items()
        ]
        return framed(rows, ("key", "value", "unit", "low", "high", "identified"), {})

    @property
    def line(self) -> str:
        """Name of the design, residual, the fitted values, and which of them the loops do not determine."""
        values = ", ".join(f"{key} {one.value:.4g} {one.unit}" for key, one in self.estimates.items())
        unknown = f"; not determined by the loops: {', '.join(self.unidentified)}" if self.unidentified else ""
        return f"{self.design.name}, residual {self.rms / DEGREE:.3g} deg rms; {values}{unknown}"

    @property
    def rms(self) -> float:
        """Rms difference of all deflections from the model's [rad]."""
        loops = self.fitted.loops
        squares = sum(len(loop.torque) * self.fitted.rms(place) ** 2 for place, loop in enumerate(loops))
        return float(np.sqrt(squares / sum(len(loop.torque) for loop in loops)))

    @property
    def unidentified(self) -> tuple[str, ...]:
        """Keys of the values that the loop does not determine."""
        return tuple(key for key, estimate in self.estimates.items() if not estimate.identified)

    @property
    def stretches(self) -> tuple[LoopStretch, ...]:
        """How far the fitted model is from each stretch of each loop."""
        return stretches(self.fitted)

    @property
    def preferred(self) -> Variant | None:
        """The candidate model that the loops support best; None where there are no candidates."""
        return preferred(self.candidates) if self.candidates else None

    @property
    def misfits(self) -> tuple[str, ...]:
        """Where the fitted model cannot follow the loops, and which model does better; a sentence each."""
        best, sentences = self.preferred, [one.sentence for one in self.stretches if not one.followed]
        if best is None or best.key == WRITTEN:
            return tuple(sentences)
        own = next(one for one in self.candidates if one.key == WRITTEN)
        extra = ", ".join(f"{key} {value:.3g}" for key, value in best.values.items() if key not in own.values)
        better = (
            f"{best.meaning}{f' ({extra})' if extra else ''} explains the loops better than the design's "
            f"{own.meaning}: Bayesian criterion lower by {own.criterion - best.criterion:.3g}, residual "
            f"{_percent(best.shares)} instead of {_percent(own.shares)} of the heights"
        )
        remedy = (
            "; a design and a MuJoCo joint have only friction of constant size at a locked crank. To see the fit, use "
            f"--fit {','.join(best.values)}"
        )
        return (*sentences, better + (remedy if best.key == "load" else ""))

    @property
    def measure_next(self) -> tuple[str, ...]:
        """What loop would tell most of what these leave open, a sentence each."""
        return _next_loops(self.fitted, self.unidentified, self.alike)

    def tables(self) -> tuple[Table, ...]:
        """Tabulate parameters, figures, loops and variants."""
        rows = tuple(
            (
                key,
                estimate.value,
                f"{estimate.ci95[0]:.4g} to {estimate.ci95[1]:.4g}",
                f"{estimate.noise95[0]:.4g} to {estimate.noise95[1]:.4g}" if np.isfinite(estimate.noise95[0]) else "-",
                estimate.unit,
                "yes" if estimate.identified else "no",
                f"{estimate.drawn:.4g} +- {estimate.deviation:.3g} ({estimate.source})" if estimate.source else "",
            )
            for key, estimate in self.estimates.items()
        )
        read, modelled = self.measured.in_units(), self.modelled.in_units()
        figures = tuple(
            (
                key,
                _written(one.value),
                f"{one.low:.4g} to {one.high:.4g}" if np.isfinite(one.value) else "",
                _written(modelled[key].value),
                DEFINITIONS[key],
            )
            for key, one in read.items()
        )
        loops = tuple(
            (
                loop.name,
                float(len(loop.torque)),
                loop.height / DEGREE,
                self.fitted.rms(place) / DEGREE,
                f"{self.fitted.rms(place) / loop.height:.1%}",
                f"{self.fitted.rms_without(place) / loop.height:.1%}",
                2.0 * loop.most,
            )
            for place, loop in enumerate(self.fitted.loops)
        )
        tables = [
            Table(
                f"{self.design.name}: fitted values",
                (
                    "value",
                    "fitted",
                    f"95 %, with a model error of {DISCREPANCY:.0%}",
                    "95 %, noise alone",
                    "unit",
                    "determined by the loop",
                    "known without it (one sigma)",
                ),
                rows,
            ),
            Table("figures of the loop", ("figure", "measured", "95 %", "fitted model", "definition"), figures),
            Table(
                "loops",
                (
                    "loop",
                    "points",
                    "height [deg]",
                    "residual rms [deg]",
                    "of the height",
                    "with no offset of torque",
                    "torque range [N m]",
                ),
                loops,
            ),
        ]
        tables.append(
            Table(
                "where the fitted model misses the loops",
                (
                    "loop",
                    "stretch",
                    "torque [N m]",
                    "measured less model, mean [deg]",
                    "rms [deg]",
                    "rms of the height",
                ),
                tuple(
                    (
                        one.loop,
                        one.stretch,
                        f"{one.first:+.3g} to {one.last:+.3g}",
                        one.mean / DEGREE,
                        one.rms / DEGREE,
                        f"{one.share:.1%}",
                    )
                    for one in self.stretches
                ),
            )
        )
        for title, compared in (
            ("candidate models of the loops", self.candidates),
            ("which losses explain the loops", self.variants),
        ):
            if compared:
                tables.append(_comparison_table(title, self.fitted.loops, compared))
        return tuple(tables)

    def as_json(self) -> dict[str, Any]:
        """Convert all of it to JSON values."""
        loops, read = self.fitted.loops, self.measured.in_units()
        return {
            "design": self.design.name,
            "held": self.fitted.bench.held,
            "crank_deg": self.fitted.bench.crank / DEGREE,
            "parameters": {
                key: {
                    "value": estimate.value,
                    "unit": estimate.unit,
                    "ci95": list(estimate.ci95),
                    "noise95": list(estimate.noise95),
                    "identified": estimate.identified,
                    "meaning": estimate.meaning,
                    "prior": (
                        {"value": estimate.drawn, "deviation": estimate.deviation, "source": estimate.source}
                        if estimate.source
                        else None
                    ),
                }
                for key, estimate in self.estimates.items()
            },
            "model_error_share": DISCREPANCY,
            "intervals": INTERVALS,
            "complete": self.complete,
            "unidentified": list(self.unidentified),
            "indistinguishable": [{"keys": [one, other], "correlation": size} for one, other, size in self.alike],
            "correlations": {
                estimate: dict(zip(self.estimates, row, strict=True))
                for estimate, row in zip(self.estimates, correlations(self.fitted).tolist(), strict=True)
            },
            "residual_rms_deg": self.rms / DEGREE,
            **{key: read[key].value for key in ("play_deg", "width_deg", "stiffness_nm_per_rad", "coulomb_nm")},
            "measured": {key: {"value": one.value, "ci95": [one.low, one.high]} for key, one in read.items()},
            "model": {key: {"value": one.value} for key, one in self.modelled.in_units().items()},
            "definitions": DEFINITIONS | {"residual_rms_deg": RESIDUAL},
            "measure_next": list(self.measure_next),
            "loops": [
                {
                    "name": loop.name,
                    "points": len(loop.torque),
                    "height_deg": loop.height / DEGREE,
                    "residual_rms_deg": self.fitted.rms(place) / DEGREE,
                    "residual_share": self.fitted.rms(place) / loop.height,
                    "residual_share_without_offset": self.fitted.rms_without(place) / loop.height,
                    "width_at_zero_torque_deg": width_of(loop).value / DEGREE,
                    "offset_torque_nm": float(self.fitted.offsets[place, 0]),
                    "offset_deg": float(self.fitted.offsets[place, 1]) / DEGREE,
                    "points_left_out": loop.lead,
                    "sign_turned": loop.flipped,
                }
                for place, loop in enumerate(loops)
            ],
            "torque_offset": {
                "fitted": self.fitted.torque_offset,
                "bic_gain": self.fitted.offset_gain,
            },
            "models": [_variant_json(one) for one in self.candidates],
            "preferred_model": self.preferred.key if self.preferred else None,
            "misses": [
                {
                    "loop": one.loop,
                    "stretch": one.stretch,
                    "torque_nm": [one.first, one.last],
                    "mean_deg": one.mean / DEGREE,
                    "rms_deg": one.rms / DEGREE,
                    "rms_share": one.share,
                }
                for one in self.stretches
            ],
            "losses": [_variant_json(one) for one in self.variants],
            "unexplained": list(UNEXPLAINED),
            "notes": list(self.notes),
        }


class CalibrationStopped(KeyboardInterrupt):
    """Ctrl-C, or a signal of the same effect, came when a search had ended: `calibration` is what came of it."""

    def __init__(self, stop: KeyboardInterrupt, calibration: Calibration) -> None:
        super().__init__(*stop.args)
        self.calibration = calibration


def calibrate(
    design: Named,
    loops: Sequence[MeasuredLoop],
    keys: Sequence[str] = DEFAULT,
    held: Held = "crank",
    crank: float = 0.0,
    progress: Progress = silent,
) -> Calibration:
    """Fit values of a design to measured hysteresis loops.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file, as drawn: where the search begins, and all that is not fitted.
    loops
        Measured on one drive.
    keys
        What to fit: names of ``bench.parameters.NAMED``, or keys of the design file.
    held
        Which shaft the bench held.
    crank
        Angle of the crank [rad].
    progress
        Called at each trial with how many there have been, and how many there may be in all.

    Raises
    ------
    UsageError
        There is no loop, a key is unknown, no key answers to the loop, or a loop is not in degrees.
    RunError
        No static balance was found.
    CalibrationStopped
        Ctrl-C: it has what was fitted by then.
    """
    design = resolve(design)
    reducer = Reducer(design)
    if not loops:
        raise UsageError("there is no loop to calibrate by: give at least one with --loop")
    drag = reducer.design.drag.output + (reducer.design.lobes * reducer.design.drag.crank if held == "output" else 0.0)
    model = Model(reducer, Losses(drag), rub(keys))
    bench = LoopCondition(held, crank, max(loop.most for loop in loops))
    _require_units(model, loops, bench)
    chosen, trials = parameters(reducer, keys, loops), Trials(progress)
    _require_answers(FitProblem(model, chosen, tuple(loops), bench, Trials()))
    fits: dict[str, Fitted] = {}
    compared: tuple[Variant, ...] = ()
    torque_offset, offset_gain = None, math.nan
    try:
        if set(keys) == set(DEFAULT):
            for key, one in fit_candidates(model, loops, bench, trials):
                fits[key] = one
            compared = candidates(fits)
            # a zero offset belongs to the bench, not to the friction: the model nearest to the loops decides on it
            best = fits[preferred(compared).key]
            torque_offset, offset_gain = best.torque_offset, best.offset_gain
        fitted = fit(model, chosen, loops, bench, trials, torque_offset=torque_offset)
    except FitStopped as stop:
        so_far = _calibration(fits.get(WRITTEN, stop.fitted))
        notes = (*so_far.notes, STOPPED)
        raise CalibrationStopped(stop, replace(so_far, complete=False, candidates=compared, notes=notes)) from stop
    if torque_offset is not None:
        fitted = replace(fitted, offset_gain=offset_gain)
    return replace(_calibration(fitted), candidates=compared)


def calibrated_name(reducer: Reducer) -> str:
    """Return the name that a design has once it is calibrated."""
    return f"{reducer.design.name}-calibrated"[:64]


def compare_losses(
    calibration: Calibration,
    progress: Progress = silent,
    done: Callable[[Calibration], object] = lambda _: None,
) -> Calibration:
    """Fit constant friction alone, with that of the contacts, with a lossy material, and with both, to the same loops.

    Each search has starts of its own; `done` is called after each with what there is by then.

    Raises
    ------
    RunError
        No static balance was found.
    """
    fitted = calibration.fitted
    # contacts rub only where they give
    common = [
        "tooth_stiffness" if parameter.key == "structure_stiffness" else parameter.key
        for parameter in fitted.parameters
        if parameter.key not in (*RUBBING, *STANDS_FOR_RUBBING)
    ]
    smooth, trials = _smooth(fitted.model.reducer), Trials(progress)
    fits: dict[tuple[str, str], Fitted] = {}
    for key, meaning, extra, rough in LOSSES:
        base = replace(fitted.model, reducer=Reducer(fitted.model.reducer.design if rough else smooth), rubs=True)
        chosen = parameters(fitted.model.reducer, [*common, *extra], fitted.loops)
        fits[key, meaning] = fit(
            base,
            chosen,
            fitted.loops,
            fitted.bench,
            trials,
            intervals=False,
            torque_offset=fitted.torque_offset,
        )
        trials.later = (len(LOSSES) - len(fits)) * trials.done / len(fits)
        calibration = replace(calibration, variants=variants(fits))
        done(calibration)
    return calibration


def correlations(fitted: Fitted) -> Array:
    """Compute the correlations of the parameters, shape (p, p); 0 of those at a bound."""
    count = len(fitted.parameters)
    covariance = fitted.spread.covariance[:count, :count]
    size = np.sqrt(np.diag(covariance))
    both = np.outer(size, size)
    return np.asarray(np.divide(covariance, both, out=np.eye(count), where=both > 0.0))


def _calibration(fitted: Fitted) -> Calibration:
    count = len(fitted.parameters)
    estimates = {parameter.key: _estimate(fitted, number) for number, parameter in enumerate(fitted.parameters)}
    related = correlations(fitted)
    keys = list(estimates)
    alike = tuple(
        (keys[i], keys[j], float(related[i, j])) for i in range(count) for j in range(i) if abs(related[i, j]) > ALIKE
    )
    calibrated = fitted.calibrated.reducer.design
    modelled = [replace(loop, deflection=turn) for loop, turn in zip(fitted.loops, fitted.turns, strict=True)]
    return Calibration(
        fitted=fitted,
        design=calibrated.but(name=calibrated_name(Reducer(calibrated))),
        estimates=estimates,
        alike=alike,
        measured=read_figures(fitted.loops),
        modelled=read_figures(modelled),
        notes=_notes(fitted),
    )


def _estimate(fitted: Fitted, number: int) -> Estimate:
    """Collect one fitted value with its intervals, and decide whether the loops determine it."""
    parameter, place, ends = fitted.parameters[number], float(fitted.places[number]), fitted.ends[number]
    value, low, high = (parameter.value(float(at)) for at in (place, *ends))
    bounded = parameter.place(parameter.least) + STEP < ends[0] and ends[1] < parameter.place(parameter.most) - STEP
    at_bound, known = bool(fitted.at_bound[number]), float(fitted.known[number])
    identified = bool(not at_bound and bounded and known < MOST_KNOWN and high - low < abs(value))
    reach = float(fitted.spread.reach(COVERED)[number] * fitted.spread.errors[number])
    likeliest = float(fitted.likeliest[number])
    noise = math.nan, math.nan
    if not at_bound:
        noise = parameter.value(likeliest - reach), parameter.value(likeliest + reach)
    drawn = parameter.start, parameter.deviation, parameter.source
    return Estimate(value, parameter.unit, parameter.meaning, (low, high), noise, identified, *drawn)


def _smooth(reducer: Reducer) -> Design:
    """Return a design whose contacts have no friction."""
    return reducer.but(friction=dict.fromkeys(Friction.model_fields, 0.0)).design


def _percent(shares: Sequence[float]) -> str:
    return " and ".join(f"{share:.1%}" for share in shares)


def _comparison_table(title: str, loops: Sequence[MeasuredLoop], compared: Sequence[Variant]) -> Table:
    """Tabulate fits of several models to the same loops, with their criteria above the lowest."""
    bayesian, akaike = (min(getattr(one, key) for one in compared) for key in ("criterion", "akaike"))
    header = ("model", *(f"{loop.name}: rms of height" for loop in loops), "BIC above best", "AIC above best", "values")
    rows = tuple(
        (
            one.meaning,
            *(f"{share:.1%}" for share in one.shares),
            one.criterion - bayesian,
            one.akaike - akaike,
            ", ".join(f"{key} {value:.3g}" for key, value in one.values.items()),
        )
        for one in compared
    )
    return Table(title, header, rows)


def _variant_json(one: Variant) -> dict[str, Any]:
    return {
        "key": one.key,
        "meaning": one.meaning,
        "residual_shares": list(one.shares),
        "bic": one.criterion,
        "aic": one.akaike,
        "values": one.values,
    }


def _written(value: float) -> str:
    return f"{value:.4g}" if np.isfinite(value) else "-"


def _next_loops(fitted: Fitted, unknown: Sequence[str], alike: Sequence[tuple[str, str, float]]) -> tuple[str, ...]:
    """Suggest which loop to measure next, by which values are undetermined."""
    open_keys = {*unknown, *(key for pair in alike for key in pair[:2])}
    most, bench = max(loop.most for loop in fitted.loops), fitted.bench
    lowest = min(fitted.loops, key=attrgetter("height"))
    coulomb, advice = coulomb_of(lowest).value, []
    if any(key == "play" or key.endswith(("_play", "_um")) for key in open_keys):
        half_pitch = 180.0 / fitted.model.reducer.design.ring.teeth
        angle = bench.crank / DEGREE + half_pitch * fitted.model.reducer.design.reduction
        advice.append(f"play: a loop at a second crank angle, {angle:.4g} deg, where other teeth and holes carry")
    if {"drag", "drag_travel", "hysteresis", "hysteresis_travel", *RUBBING} & open_keys:
        small = 1.5 * coulomb if np.isfinite(coulomb) else 0.2 * most
        advice.append(
            f"losses: a loop of +-{small:.2g} N m, in which constant friction is most of the torque, beside one of "
            f"+-{most:.4g} N m"
        )
        other = "output" if bench.held == "crank" else "crank"
        advice.append(
            f"friction: the same loop with the {other} held (--held {other}): friction acts the other way there"
        )
    if {"tooth_stiffness", "structure_stiffness", "hysteresis_travel"} & open_keys:
        advice.append(f"stiffness: a loop of +-{2.0 * most:.4g} N m, in which play and friction are a smaller part")
    return tuple(advice)


def _notes(fitted: Fitted) -> tuple[str, ...]:
    notes = [
        f"{loop.name} counts deflection against torque: its sign was turned" for loop in fitted.loops if loop.flipped
    ]
    notes += [
        f"{loop.name}: its first {loop.lead} points are the way to the loop, not the loop itself, and are left out"
        for loop in fitted.loops
        if loop.lead
    ]
    notes += [
        f"{one.key} came out at the end of what is looked for, {value:.4g} {one.unit}: its interval is one-sided"
        for one, value, place in zip(fitted.parameters, fitted.values, fitted.places, strict=False)
        if min(place - one.place(one.least), one.place(one.most) - place) < AT_BOUND
    ]
    notes.append(INTERVALS)
    if math.isfinite(fitted.offset_gain):
        notes.append(_offset_note(fitted.torque_offset, fitted.offset_gain))
    return tuple(notes)


def _offset_note(fitted: bool, gain: float) -> str:
    chosen = "each loop has a fitted zero offset of torque" if fitted else "the zero of torque is taken as exact"
    return (
        f"{chosen}: the Bayesian criterion {'with' if fitted else 'without'} such offsets is lower by {abs(gain):.3g}"
    )


def _require_units(model: Model, loops: Sequence[MeasuredLoop], bench: LoopCondition) -> None:
    """Refuse a loop that is near the design's only if it was meant in N mm, in radians, or in minutes of arc."""
    rated = model.reducer.design.rated_torque
    for loop in loops:
        require_torque(loop, rated)
        try:
            turn = np.concatenate([turn for _, turn in model_branches(model, bench, loop)])
        except RunError:
            continue
        expected = float(np.ptp(turn))
        if loop.height * RADIANS < expected < loop.height / DEGREE * RADIANS:
            raise UsageError(
                f"{loop.name}: the deflection goes over {loop.height / DEGREE:.3g} deg, but the design's own loop over "
                f"{expected / DEGREE:.3g} deg: is {DEFLECTION} in radians? then "
                "multiply it by 57.2958; if not, give the design clearances nearer to the drive's"
            )
        if loop.height > MINUTES * expected:
            raise UsageError(
                f"{loop.name}: the deflection goes over {loop.height / DEGREE:.3g} deg, but the design's own loop over "
                f"{expected / DEGREE:.3g} deg: is {DEFLECTION} in minutes of arc? then divide it by 60; if not, "
                "give the design clearances and stiffness nearer to the drive's"
            )


def _require_answers(search: FitProblem) -> None:
    """Refuse values none of which any loop answers to."""
    start = np.array([one.place(one.start) for one in search.parameters] + [0.0] * (2 * len(search.loops)))
    if not np.any(np.abs(search.slopes(start, range(len(search.parameters)), central=True)) > SILENT):
        raise UsageError(
            f"--fit {','.join(one.key for one in search.parameters)}: the loop determines none of these; fit what it "
            f"answers to, such as {','.join(DEFAULT)}"
        )
