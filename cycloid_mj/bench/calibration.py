"""Calibration: the design that fits measured loops, the uncertainty of its values, and what remains undetermined."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any, get_args

import numpy as np

from cycloid_mj.base.arguments import require_choice, require_number
from cycloid_mj.base.array import Array
from cycloid_mj.base.engine import Progress, silent
from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.base.frame import Cell, Frame, make_frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.base.notebook_progress import shows_progress
from cycloid_mj.base.result import Table
from cycloid_mj.base.units import DEGREE
from cycloid_mj.bench import model_selection
from cycloid_mj.bench.fit import PROFILE, FitStopped, Fitted, fit_loops
from cycloid_mj.bench.loop import DEFLECTION, MeasuredLoop, require_torque
from cycloid_mj.bench.loop_figures import DEFINITIONS, LoopFigures, loop_coulomb_torque, loop_figures, loop_width
from cycloid_mj.bench.overlay import LoopCondition, model_branches
from cycloid_mj.bench.parameters import (
    CONTACT_FRICTION,
    WIND_UP_FRICTION,
    Model,
    default_keys,
    fit_parameters,
    needs_contact_friction,
)
from cycloid_mj.bench.search import MODEL_ERROR, SETTINGS, FitProblem, Trials
from cycloid_mj.design import Design, Named, resolve
from cycloid_mj.design.model import NO_FRICTION, StructureSprings
from cycloid_mj.reducer import Reducer, RvReducer, reducer_of
from cycloid_mj.statics.friction_path import Held, Losses


@dataclass(frozen=True)
class IdentifiabilityLimits:
    """Limits of what the loops determine, and of plausible units of a deflection.

    Attributes
    ----------
    max_correlation
        Correlation of two values from which the loops do not distinguish them.
    max_prior_share
        Share of the knowledge of a value from which the drawing determines it, not the loops.
    min_sensitivity
        Smallest change of the residuals, by a scaled value, of a parameter on which a loop depends: above rounding.
    radians_factor, arcminutes_factor
        How many times lower than the design's loop a loop is that may be in radians, and higher one in arcminutes
        (heuristic).
    """

    max_correlation: float = 0.95
    max_prior_share: float = 0.5
    min_sensitivity: float = 1e-6
    radians_factor: float = 8.0
    arcminutes_factor: float = 30.0


LIMITS = IdentifiabilityLimits()

LOSSES = (
    ("constant", "constant friction alone", (), False),
    ("friction", "constant friction and friction in the contacts", ("friction",), True),
    ("material", "constant friction and losses in the material", ("material_loss",), False),
    (
        "both",
        "constant friction, friction in the contacts and losses in the material",
        ("friction", "material_loss"),
        True,
    ),
)
"""Losses that are compared: key, meaning, additional parameters, and whether the contacts have friction."""

RESIDUAL = (
    "rms difference of all measured deflections from the fitted loop's at the same torque, without the points before "
    "the loop"
)
"""Definition of the residual of a calibration."""

INTERVALS = (
    f"the intervals of 95 % include an assumed model error of {MODEL_ERROR:.0%} of each loop's ranges (rms), whatever "
    "its course, and do not become narrower with less noise; those of noise alone assume that the model is exact"
)
"""Coverage of the intervals of the values."""

STOPPED = (
    "stopped before the end of the fit: the values are the likeliest so far, and intervals that no search had widened "
    "yet are those of the linearised model"
)
"""Remark on a fit that was stopped."""

RV_UNEXPLAINED = (
    "bearing_stiffness represents all compliance but that of teeth and planets, also of carrier, cranks and mounting",
    "drag is written to the design as drag.output_nm; a design of an RV reducer has neither drag_travel nor hysteresis",
)
"""Effects of an RV reducer that no parameter, or no key of the design, represents."""

UNEXPLAINED = (
    "twist of housing, discs, shafts and mounting is not separated: structure_stiffness represents all of it",
    "friction of the crank is not separated from that of the wind-up: drag and hysteresis represent both",
    "creep is not modelled: under a constant torque a plastic part continues to turn, and the model does not",
    "contacts are linear springs at one working force: stiffness increases with the load only by the number of teeth",
)
"""Effects that no parameter represents."""


@dataclass(frozen=True)
class Estimate:
    """A fitted value, in its `unit`."""

    value: float
    unit: str
    meaning: str
    """The value and its definition."""
    ci95: tuple[float, float]
    noise95: tuple[float, float]
    """Ends of its intervals of 95 %: with the assumed model error (`INTERVALS`), and of the measurement's noise alone
    about the likeliest value; no numbers for a value at its bound."""
    identified: bool
    """Whether the loop determines it: both ends of `ci95` follow from the loop, not from the bounds of the search, nor
    for the most part from the drawing, and the interval is no wider than the value."""
    drawn: float
    deviation: float
    source: str
    """Its prior: the start of the search, the standard deviation, inf without a prior, and the source of that."""


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
    indistinguishable
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
    indistinguishable: tuple[tuple[str, str, float], ...]
    measured: LoopFigures
    modelled: LoopFigures
    variants: tuple[model_selection.ModelFit, ...] = ()
    candidates: tuple[model_selection.ModelFit, ...] = ()
    notes: tuple[str, ...] = ()
    complete: bool = True

    @property
    def frame(self) -> Frame:
        """Return a table with named columns: values fitted to measured loops in their units, with 95 % intervals."""
        names = ("key", "value", "unit", "low", "high", "identified")
        rows: list[dict[str, Cell]] = [
            dict(zip(names, (key, estimate.value, estimate.unit, *estimate.ci95, estimate.identified), strict=True))
            for key, estimate in self.estimates.items()
        ]
        return make_frame(rows, names, {})

    @property
    def line(self) -> str:
        """Name of the design, residual, the fitted values, and which of them the loops do not determine."""
        value_text = ", ".join(f"{key} {item.value:.4g} {item.unit}" for key, item in self.estimates.items())
        unknown_text = f"; not determined by the loops: {', '.join(self.unidentified)}" if self.unidentified else ""
        return f"{self.design.name}, residual {self.rms / DEGREE:.3g} deg rms; {value_text}{unknown_text}"

    @property
    def rms(self) -> float:
        """Return the rms difference of all measured deflections from the fitted model's at the same torque [rad]."""
        loops = self.fitted.loops
        squares = sum(len(loop.torque) * self.fitted.rms(number) ** 2 for number, loop in enumerate(loops))
        return float(np.sqrt(squares / sum(len(loop.torque) for loop in loops)))

    @property
    def unidentified(self) -> tuple[str, ...]:
        """Keys of the values that the loops do not determine."""
        return tuple(key for key, estimate in self.estimates.items() if not estimate.identified)

    @property
    def unexplained(self) -> tuple[str, ...]:
        """Effects that no parameter represents, a sentence each."""
        is_rv = isinstance(self.fitted.model.reducer, RvReducer)
        return (*RV_UNEXPLAINED, *UNEXPLAINED[1:]) if is_rv else UNEXPLAINED

    @property
    def stretches(self) -> tuple[model_selection.LoopStretch, ...]:
        """Deviation of the fitted model from each stretch of each loop."""
        return model_selection.compare_sections(self.fitted)

    @property
    def preferred(self) -> model_selection.ModelFit | None:
        """The candidate model that the loops support best; None where there are no candidates."""
        return model_selection.select_model(self.candidates) if self.candidates else None

    @property
    def misfits(self) -> tuple[str, ...]:
        """Return sentences on how the measured loops deviate from the fitted model.

        There is a sentence for each loop that deviates by more than the model error (`MODEL_ERROR`). The last sentence
        reports the candidate model of friction that explains the loops better than the design's, if there is one.
        """
        best_fit, sentences = self.preferred, list(self._worst_sections())
        if best_fit is None or best_fit.key == model_selection.DESIGN_MODEL:
            return tuple(sentences)
        design_fit = next(fit for fit in self.candidates if fit.key == model_selection.DESIGN_MODEL)
        extra_text = ", ".join(
            f"{key} {value:.3g}" for key, value in best_fit.values.items() if key not in design_fit.values
        )
        sentence = (
            f"{best_fit.meaning}{f' ({extra_text})' if extra_text else ''} explains the loops better than the design's "
            f"{design_fit.meaning}: Bayesian criterion lower by {design_fit.bayesian - best_fit.bayesian:.3g}, "
            f"residual {_percent(best_fit.shares)} instead of {_percent(design_fit.shares)} of the heights"
        )
        remedy = (
            "; a design and a MuJoCo joint have only friction of constant size at a locked crank. To see the fit, use "
            f"--fit {','.join(best_fit.values)}"
        )
        return (*sentences, sentence + (remedy if best_fit.key == "load" else ""))

    def _worst_sections(self) -> Iterator[str]:
        """Yield a sentence for each loop on the section of it that deviates most from the fitted model.

        A loop has six sections: unloading, crossing of the play and loading, with rising and with falling torque. Loops
        within the model error are skipped.
        """
        all_sections = self.stretches
        for loop in self.fitted.loops:
            loop_sections = [section for section in all_sections if section.loop == loop.name]
            deviating_sections = [section for section in loop_sections if not section.is_within_model_error]
            if deviating_sections:
                worst_section = max(deviating_sections, key=attrgetter("share"))
                count_text = (
                    f"{len(deviating_sections)} of {len(loop_sections)} stretches differ by more than {MODEL_ERROR:.0%}"
                )
                yield f"{worst_section.sentence} ({count_text})"

    @property
    def measure_next(self) -> tuple[str, ...]:
        """Describe loops that would determine most of the undetermined values, a sentence each."""
        return _advise_loops(self.fitted, self.unidentified, self.indistinguishable)

    def tables(self) -> tuple[Table, ...]:
        """Return tables on a fit to measured loops: fitted values, loop quantities, loops, deviations, compared models.

        The deviations are those of the fitted model by section of a loop.
        """
        comparisons = (
            ("candidate models of the loops", self.candidates),
            ("which losses explain the loops", self.variants),
        )
        return (
            self._parameter_table(),
            self._quantity_table(),
            self._loop_table(),
            self._deviation_table(),
            *(_comparison_table(title, self.fitted.loops, fits) for title, fits in comparisons if fits),
        )

    def _parameter_table(self) -> Table:
        """Return a table of the fitted values in their units, with intervals of 95 % and priors, a row each."""
        interval_labels = f"95 %, with a model error of {MODEL_ERROR:.0%}", "95 %, noise alone"
        header = ("value", "fitted", *interval_labels, "unit", "determined by the loop", "prior (one sigma)")
        rows: list[tuple[str | float, ...]] = []
        for key, estimate in self.estimates.items():
            interval_text, noise_text = (f"{low:.4g} to {high:.4g}" for low, high in (estimate.ci95, estimate.noise95))
            texts = (
                noise_text if np.isfinite(estimate.noise95[0]) else "-",
                estimate.unit,
                "yes" if estimate.identified else "no",
            )
            prior_text = (
                f"{estimate.drawn:.4g} +- {estimate.deviation:.3g} ({estimate.source})" if estimate.source else ""
            )
            rows.append((key, estimate.value, interval_text, *texts, prior_text))
        return Table(f"{self.design.name}: fitted values", header, tuple(rows))

    def _quantity_table(self) -> Table:
        """Return a table of play, width, stiffness and Coulomb torque of measured loops and fitted model.

        Each has a row with its unit and 95 % intervals (`DEFINITIONS`).
        """
        modelled_figures = self.modelled.in_units()
        rows = []
        for key, loop_figure in self.measured.in_units().items():
            interval_text = f"{loop_figure.low:.4g} to {loop_figure.high:.4g}" if np.isfinite(loop_figure.value) else ""
            values = _format_number(loop_figure.value), interval_text, _format_number(modelled_figures[key].value)
            rows.append((key, *values, DEFINITIONS[key]))
        return Table("figures of the loop", ("figure", "measured", "95 %", "fitted model", "definition"), tuple(rows))

    def _loop_table(self) -> Table:
        """Return a table of the loops: points, ranges of deflection [deg] and torque [N m], and rms residual [deg].

        The residual is also stated relative to the range of deflection, with and without a fitted zero offset of the
        torque.
        """
        header = (
            *("loop", "points", "height [deg]", "residual rms [deg]", "relative to the height"),
            *("without an offset of torque", "torque range [N m]"),
        )
        rows: list[tuple[str | float, ...]] = []
        for loop_index, loop in enumerate(self.fitted.loops):
            rms, rms_without_offset = self.fitted.rms(loop_index), self.fitted.rms_without_offset(loop_index)
            share_texts = f"{rms / loop.height:.1%}", f"{rms_without_offset / loop.height:.1%}"
            degrees = loop.height / DEGREE, rms / DEGREE
            rows.append((loop.name, float(len(loop.torque)), *degrees, *share_texts, 2.0 * loop.most))
        return Table("loops", header, tuple(rows))

    def _deviation_table(self) -> Table:
        """Return a table of the deviation of the loops from the fitted model, with a row for each section of each loop.

        A loop has up to six sections: unloading, crossing of the play and loading, with rising and with falling torque.
        Columns are loop, section, range of torque [N m], mean and rms of the measured minus the modelled deflection
        [deg], and this rms relative to the loop's height, the range of its deflection.
        """
        deviation_labels = "measured less model, mean [deg]", "rms [deg]", "rms of the height"
        rows: list[tuple[str | float, ...]] = []
        for section in self.stretches:
            torque_text, deviations = (
                f"{section.first:+.3g} to {section.last:+.3g}",
                (section.mean / DEGREE, section.rms / DEGREE),
            )
            rows.append((section.loop, section.stretch, torque_text, *deviations, f"{section.share:.1%}"))
        header = ("loop", "stretch", "torque [N m]", *deviation_labels)
        return Table("where the fitted model misses the loops", header, tuple(rows))

    def as_json(self) -> dict[str, Any]:
        """Convert the calibration to JSON values; keys end in their units.

        ``parameters`` are the fitted values with intervals. ``measured`` and ``model`` are play, width, stiffness and
        Coulomb torque of measured loops and fitted model (`DEFINITIONS`). ``loops`` are the measured loops, ``misses``
        the deviations of the model by section of each loop. ``models`` are the fits of several friction models, and
        ``losses`` those of models with different losses (`compare_losses`), each with residuals and criteria.
        """
        figures = self.measured.in_units()
        return {
            "design": self.design.name,
            "held": self.fitted.condition.held,
            "crank_deg": self.fitted.condition.crank / DEGREE,
            "parameters": {key: _estimate_json(estimate) for key, estimate in self.estimates.items()},
            "model_error_share": MODEL_ERROR,
            "intervals": INTERVALS,
            "complete": self.complete,
            "unidentified": list(self.unidentified),
            "indistinguishable": [
                {"keys": [first_key, second_key], "correlation": correlation}
                for first_key, second_key, correlation in self.indistinguishable
            ],
            "correlations": {
                estimate: dict(zip(self.estimates, row, strict=True))
                for estimate, row in zip(self.estimates, correlations(self.fitted).tolist(), strict=True)
            },
            "residual_rms_deg": self.rms / DEGREE,
            **{key: figures[key].value for key in ("play_deg", "width_deg", "stiffness_nm_per_rad", "coulomb_nm")},
            "measured": {key: {"value": item.value, "ci95": [item.low, item.high]} for key, item in figures.items()},
            "model": {key: {"value": item.value} for key, item in self.modelled.in_units().items()},
            "definitions": DEFINITIONS | {"residual_rms_deg": RESIDUAL},
            "measure_next": list(self.measure_next),
            "loops": [_loop_json(self.fitted, number) for number in range(len(self.fitted.loops))],
            "torque_offset": {"fitted": self.fitted.torque_offset, "bic_gain": self.fitted.offset_gain},
            "models": [_model_fit_json(item) for item in self.candidates],
            "preferred_model": self.preferred.key if self.preferred else None,
            "misses": [
                {
                    "loop": item.loop,
                    "stretch": item.stretch,
                    "torque_nm": [item.first, item.last],
                    "mean_deg": item.mean / DEGREE,
                    "rms_deg": item.rms / DEGREE,
                    "rms_share": item.share,
                }
                for item in self.stretches
            ],
            "losses": [_model_fit_json(item) for item in self.variants],
            "unexplained": list(self.unexplained),
            "notes": list(self.notes),
        }


def _estimate_json(estimate: Estimate) -> dict[str, Any]:
    """Convert the estimate of a fitted parameter to JSON values: value, unit, meaning, and whether it is identified.

    ``ci95`` and ``noise95`` are its intervals of 95 %, with the assumed model error and from the noise alone. ``prior``
    is None if the parameter has none. All are in the ``unit`` of the parameter.
    """
    prior = {"value": estimate.drawn, "deviation": estimate.deviation, "source": estimate.source}
    return {
        **{key: getattr(estimate, key) for key in ("value", "unit", "identified", "meaning")},
        **{"ci95": list(estimate.ci95), "noise95": list(estimate.noise95)},
        "prior": prior if estimate.source else None,
    }


def _loop_json(fit: Fitted, loop_index: int) -> dict[str, Any]:
    """Convert a measured loop and its deviation from the fitted model to JSON values; keys end in their units.

    `loop_index` is the index of the loop in the `fit`. ``height`` is the range of the measured deflection, and
    ``residual_rms`` the rms difference of the model from it. ``offset_torque`` and ``offset`` are the fitted zero
    offsets of torque and deflection. ``residual_share`` is relative to the height.
    """
    loop, residual_rms, offset = fit.loops[loop_index], fit.rms(loop_index), fit.offsets[loop_index]
    return {
        "name": loop.name,
        "points": len(loop.torque),
        "height_deg": loop.height / DEGREE,
        "residual_rms_deg": residual_rms / DEGREE,
        "residual_share": residual_rms / loop.height,
        "residual_share_without_offset": fit.rms_without_offset(loop_index) / loop.height,
        "width_at_zero_torque_deg": loop_width(loop).value / DEGREE,
        "offset_torque_nm": float(offset[0]),
        "offset_deg": float(offset[1]) / DEGREE,
        "points_left_out": loop.points_left_out,
        "sign_turned": loop.flipped,
    }


class CalibrationStopped(KeyboardInterrupt):
    """Ctrl-C, or an equivalent signal, after at least one search ended: `calibration` has the values by then."""

    def __init__(self, stop: KeyboardInterrupt, calibration: Calibration) -> None:
        super().__init__(*stop.args)
        self.calibration = calibration


@shows_progress
def calibrate(
    design: Named,
    loops: Sequence[MeasuredLoop],
    keys: Sequence[str] | None = None,
    held: Held = "crank",
    crank: float = 0.0,
    progress: Progress = silent,
) -> Calibration:
    """Fit values of a design to measured hysteresis loops.

    Parameters
    ----------
    design
        A design, or the name of a preset or a file. The search starts from it, and values that are not fitted are its
        own.
    loops
        Loops of one drive.
    keys
        Values to fit: names of ``bench.parameters.names_of``, such as "play" or "drag", or keys of the design file; by
        default ``bench.parameters.default_keys``.
    held, crank
        Shaft that was locked ("crank" or "output"; the crank is the sun of an RV reducer), and angle of the crank
        [rad], or of the cranks of an RV reducer relative to the ring.
    progress
        Called at each evaluation with the number of evaluations so far and the expected total.

    Returns
    -------
    Calibration
        Fitted values with their intervals, the residuals, and the design with these values.

    Raises
    ------
    UsageError
        There is no loop, a key is unknown, no loop depends on the keys, a loop is not in degrees, or another argument
        is not valid.
    RunError
        The model has no static equilibrium.
    CalibrationStopped
        Ctrl-C was pressed; the attribute `calibration` of the error has the best values so far.
    """
    require_choice("held", held, get_args(Held))
    require_number("crank", crank, "rad")
    reducer = reducer_of(resolve(design))
    keys = default_keys(reducer) if keys is None else [keys] if isinstance(keys, str) else keys
    if not loops:
        raise UsageError("no measured hysteresis loop is given: add at least one CSV file with --loop LOOP.csv")
    drag = reducer.design.drag.output + (reducer.design.lobes * reducer.design.drag.crank if held == "output" else 0.0)
    model = Model(reducer, Losses(drag), needs_contact_friction(reducer, keys))
    condition = LoopCondition(held, crank, max(loop.most for loop in loops))
    _require_units(model, loops, condition)
    problem = FitProblem(model, fit_parameters(reducer, keys, loops), tuple(loops), condition, Trials())
    _require_sensitivity(problem)
    return _fit_and_compare(
        replace(problem, trials=Trials(progress)), with_candidates=set(keys) == set(default_keys(reducer))
    )


def _fit_and_compare(problem: FitProblem, with_candidates: bool) -> Calibration:
    """Fit the parameters of a problem to its loops, and return the calibration with values, intervals and notes.

    If `with_candidates`, all friction models of `model_selection.CANDIDATES` are fitted first. The candidate with the
    lowest Bayesian information criterion then decides whether the final fit has an offset of the torque's zero point
    for each loop. The result has the residuals and criteria of all candidates as `candidates`.

    Raises
    ------
    RunError
        The model has no static equilibrium.
    CalibrationStopped
        Ctrl-C was pressed; the attribute `calibration` of the error has the best values so far.
    """
    model, loops, condition, trials = problem.model, problem.loops, problem.condition, problem.trials
    fits: dict[str, Fitted] = {}
    compared_fits: tuple[model_selection.ModelFit, ...] = ()
    torque_offset, offset_gain = None, math.nan
    try:
        if with_candidates:
            for key, candidate_fit in model_selection.fit_candidates(model, loops, condition, trials):
                fits[key] = candidate_fit
            compared_fits = model_selection.compare_candidates(fits)
            # a zero offset belongs to the bench, not to the friction: the model nearest to the loops decides on it
            best_fit = fits[model_selection.select_model(compared_fits).key]
            torque_offset, offset_gain = best_fit.torque_offset, best_fit.offset_gain
        fitted = fit_loops(model, problem.parameters, loops, condition, trials, torque_offset=torque_offset)
    except FitStopped as stop:
        partial_calibration = _build_calibration(fits.get(model_selection.DESIGN_MODEL, stop.fitted))
        notes = (*partial_calibration.notes, STOPPED)
        raise CalibrationStopped(
            stop, replace(partial_calibration, complete=False, candidates=compared_fits, notes=notes)
        ) from stop
    if torque_offset is not None:
        fitted = replace(fitted, offset_gain=offset_gain)
    return replace(_build_calibration(fitted), candidates=compared_fits)


def calibrated_name(design: Design) -> str:
    """Return the name that a design has once it is calibrated."""
    return f"{design.name}-calibrated"[:64]


def compare_losses(
    calibration: Calibration,
    progress: Progress = silent,
    on_fit: Callable[[Calibration], object] = lambda _: None,
) -> Calibration:
    """Fit models with different losses to the loops of a calibration; return it with these fits as `variants`.

    The models (`LOSSES`) have constant friction, either alone, with friction of the contacts, with a lossy material, or
    with both. The stiffness of the teeth is fitted in place of that of the structure, since only elastic contacts have
    friction.

    Parameters
    ----------
    calibration
        The calibration whose loops and parameters are used.
    progress
        Called at each evaluation with the number of evaluations so far and the expected total.
    on_fit
        Called after each fit with the calibration that has the fits so far as `variants`.

    Raises
    ------
    RunError
        The model has no static equilibrium.
    """
    fitted = calibration.fitted
    if isinstance(fitted.model.reducer, RvReducer):
        raise UsageError(
            "the losses of an RV reducer cannot be compared (--losses), because its loops are computed without "
            "friction of the contacts: remove --losses"
        )
    common_keys = [
        "tooth_stiffness" if parameter.key == "structure_stiffness" else parameter.key
        for parameter in fitted.parameters
        if parameter.key not in (*CONTACT_FRICTION, *WIND_UP_FRICTION)
    ]
    frictionless_design = fitted.model.reducer.but(friction=NO_FRICTION).design
    trials = Trials(progress)
    fits: dict[tuple[str, str], Fitted] = {}
    for key, meaning, extra_keys, has_friction in LOSSES:
        base_model = replace(
            fitted.model,
            reducer=Reducer(fitted.model.reducer.design if has_friction else frictionless_design),
            contact_friction=True,
        )
        parameters = fit_parameters(fitted.model.reducer, [*common_keys, *extra_keys], fitted.loops)
        loops, offset = fitted.loops, fitted.torque_offset
        fits[key, meaning] = fit_loops(
            base_model, parameters, loops, fitted.condition, trials, intervals=False, torque_offset=offset
        )
        trials.later = (len(LOSSES) - len(fits)) * trials.done / len(fits)
        calibration = replace(calibration, variants=model_selection.compare_fits(fits))
        on_fit(calibration)
    return calibration


def correlations(fitted: Fitted) -> Array:
    """Compute the correlation matrix of the fitted parameters, shape (p, p); 0 for those at a bound."""
    count = len(fitted.parameters)
    covariance = fitted.uncertainty.covariance[:count, :count]
    errors = np.sqrt(np.diag(covariance))
    products = np.outer(errors, errors)
    return np.asarray(np.divide(covariance, products, out=np.eye(count), where=products > 0.0))


def _build_calibration(fitted: Fitted) -> Calibration:
    """Return the calibration of a fit: the calibrated design, estimates with intervals, notes, and loop quantities.

    The loop quantities are play, width, stiffness and Coulomb torque of the measured loops and of the fitted model.
    """
    parameter_count = len(fitted.parameters)
    estimates = {parameter.key: _estimate_value(fitted, index) for index, parameter in enumerate(fitted.parameters)}
    parameter_correlations = correlations(fitted)
    keys = list(estimates)
    correlated_pairs = [
        (row, column)
        for row in range(parameter_count)
        for column in range(row)
        if abs(parameter_correlations[row, column]) > LIMITS.max_correlation
    ]
    indistinguishable = tuple(
        (keys[row], keys[column], float(parameter_correlations[row, column])) for row, column in correlated_pairs
    )
    calibrated_design = _writable_design(fitted.calibrated_model.reducer)
    modelled_loops = [
        replace(loop, deflection=rotation) for loop, rotation in zip(fitted.loops, fitted.turns, strict=True)
    ]
    return Calibration(
        fitted=fitted,
        design=calibrated_design.but(name=calibrated_name(calibrated_design)),
        estimates=estimates,
        indistinguishable=indistinguishable,
        measured=loop_figures(fitted.loops),
        modelled=loop_figures(modelled_loops),
        notes=_fit_notes(fitted),
    )


def _writable_design(reducer: Reducer) -> Design:
    """Return the design of a calibrated reducer, without values that the design file of its layout does not have.

    An RV reducer has no table ``[springs]``: its constant friction becomes ``drag.output``.
    """
    design = reducer.design
    if not isinstance(reducer, RvReducer):
        return design
    design_without_springs = design.model_copy(update={"springs": StructureSprings()})
    return design_without_springs.but(drag={"output": design.springs.friction})


def _estimate_value(fitted: Fitted, index: int) -> Estimate:
    """Return the estimate of a fitted parameter: value, two 95 % intervals, and whether it is identified.

    `fitted` is the result of the fit, and `index` is the index of the parameter. `Estimate.ci95` includes the assumed
    error of the model. `Estimate.noise95` is from the noise of the measurement alone; it is NaN for a value at a bound
    of the search. The value is not identified if it or an end of `ci95` is at a bound, if the prior contributes at
    least the share `LIMITS.max_prior_share` to it, or if `ci95` is at least as wide as the value.
    """
    parameter, scaled_value, interval = fitted.parameters[index], float(fitted.scaled[index]), fitted.ends[index]
    value, low, high = (parameter.from_scale(float(scaled)) for scaled in (scaled_value, *interval))
    lower_bound, upper_bound = parameter.to_scale(parameter.lower), parameter.to_scale(parameter.upper)
    margin = SETTINGS.difference_step
    is_bounded = lower_bound + margin < interval[0] and interval[1] < upper_bound - margin
    is_at_bound, prior_share = bool(fitted.at_bound[index]), float(fitted.prior_share[index])
    is_identified = bool(
        not is_at_bound and is_bounded and prior_share < LIMITS.max_prior_share and high - low < abs(value)
    )
    likeliest, half_width = float(fitted.likeliest[index]), float(fitted.uncertainty.half_widths[index])
    noise_interval = math.nan, math.nan
    if not is_at_bound:
        noise_interval = parameter.from_scale(likeliest - half_width), parameter.from_scale(likeliest + half_width)
    prior_values = parameter.start, parameter.deviation, parameter.source
    return Estimate(value, parameter.unit, parameter.meaning, (low, high), noise_interval, is_identified, *prior_values)


def _percent(shares: Sequence[float]) -> str:
    return " and ".join(f"{share:.1%}" for share in shares)


def _comparison_table(title: str, loops: Sequence[MeasuredLoop], fits: Sequence[model_selection.ModelFit]) -> Table:
    """Return a table of the fits of several models to the same loops, a row for each model.

    The columns are the residuals of each loop, the information criteria minus the lowest of all models, and the fitted
    values. `title` is the heading of the table, `fits` are the fits.
    """
    min_bayesian, min_akaike = (min(getattr(fit, key) for fit in fits) for key in ("bayesian", "akaike"))
    header = ("model", *(f"{loop.name}: rms of height" for loop in loops), "BIC above best", "AIC above best", "values")
    rows = tuple(
        (
            fit.meaning,
            *(f"{share:.1%}" for share in fit.shares),
            fit.bayesian - min_bayesian,
            fit.akaike - min_akaike,
            ", ".join(f"{key} {value:.3g}" for key, value in fit.values.items()),
        )
        for fit in fits
    )
    return Table(title, header, rows)


def _model_fit_json(fit: model_selection.ModelFit) -> dict[str, Any]:
    """Convert the fit `fit` of one of several compared models to JSON values.

    ``residual_shares`` are the rms deviations from the loops over their heights, ``bic`` and ``aic`` the Bayesian and
    Akaike's information criterion, and ``values`` the fitted values in the units of the parameters.
    """
    criteria = {"bic": fit.bayesian, "aic": fit.akaike}
    return {
        "key": fit.key,
        "meaning": fit.meaning,
        "residual_shares": list(fit.shares),
        **criteria,
        "values": fit.values,
    }


def _format_number(value: float) -> str:
    return f"{value:.4g}" if np.isfinite(value) else "-"


def _advise_loops(
    fitted: Fitted, undetermined_keys: Sequence[str], indistinguishable: Sequence[tuple[str, str, float]]
) -> tuple[str, ...]:
    """Return recommendations, a sentence each, of further loops to measure that would determine uncertain values.

    `fitted` is the result of the fit. `undetermined_keys` are the keys of undetermined values, `indistinguishable`
    pairs of keys with their correlation. There are recommendations for play, friction and stiffness only.
    """
    uncertain_keys = {*undetermined_keys, *(key for pair in indistinguishable for key in pair[:2])}
    max_torque, condition = max(loop.most for loop in fitted.loops), fitted.condition
    smallest_loop = min(fitted.loops, key=attrgetter("height"))
    coulomb_torque, advice = loop_coulomb_torque(smallest_loop).value, []
    if any(key == "play" or key.endswith(("_play", "_um")) for key in uncertain_keys):
        design = fitted.model.reducer.design
        turns = design.lobes if isinstance(fitted.model.reducer, RvReducer) else design.reduction
        angle = condition.crank / DEGREE + 180.0 / design.ring.teeth * turns
        advice.append(
            f"play: a loop at a second crank angle, {angle:.4g} deg, at which other teeth and holes carry the load"
        )
    if {"drag", "drag_travel", "hysteresis", "hysteresis_travel", *CONTACT_FRICTION} & uncertain_keys:
        small_torque = 1.5 * coulomb_torque if np.isfinite(coulomb_torque) else 0.2 * max_torque
        advice.append(
            f"losses: a loop of +-{small_torque:.2g} N m, in which constant friction is most of the torque, in "
            f"addition to one of +-{max_torque:.4g} N m"
        )
        other_shaft = "output" if condition.held == "crank" else "crank"
        advice.append(
            f"friction: the same loop with the {other_shaft} locked (--held {other_shaft}), where friction acts in the "
            "other direction"
        )
    if {"tooth_stiffness", "structure_stiffness", "bearing_stiffness", "hysteresis_travel"} & uncertain_keys:
        advice.append(
            f"stiffness: a loop of +-{2.0 * max_torque:.4g} N m, of which play and friction are a smaller part"
        )
    return tuple(advice)


def _fit_notes(fitted: Fitted) -> tuple[str, ...]:
    """Return remarks on a fit to loops, a sentence each: omitted points, values at bounds, intervals, offsets.

    `fitted` is the result of the fit.
    """
    notes, sign_text = [], "counts deflection against the torque: its sign was changed"
    for loop in fitted.loops:
        notes += [f"{loop.name} {sign_text}"] if loop.flipped else []
    for loop in fitted.loops:
        notes += (
            [f"{loop.name}: the first {loop.points_left_out} points lead to the loop and are not used"]
            if loop.points_left_out
            else []
        )
    notes += [
        f"{parameter.key} is at the limit of the search, {value:.4g} {parameter.unit}: its interval is one-sided"
        for parameter, value, scaled_value in zip(fitted.parameters, fitted.values, fitted.scaled, strict=False)
        if min(scaled_value - parameter.to_scale(parameter.lower), parameter.to_scale(parameter.upper) - scaled_value)
        < PROFILE.bound_distance
    ]
    notes.append(INTERVALS)
    if math.isfinite(fitted.offset_gain):
        no_offset_note, word = "the zero of torque is taken as exact", "with" if fitted.torque_offset else "without"
        offset_note = "each loop has a fitted zero offset of torque" if fitted.torque_offset else no_offset_note
        gain_text = f"{abs(fitted.offset_gain):.3g}"
        notes.append(f"{offset_note}: the Bayesian criterion {word} such offsets is lower by {gain_text}")
    return tuple(notes)


def _require_units(model: Model, loops: Sequence[MeasuredLoop], condition: LoopCondition) -> None:
    """Raise UsageError if torques are probably not in N m, or deflections not in degrees.

    Torques are compared with the rated torque, deflections with those that the model predicts. `condition` has the
    locked shaft and the crank angle of the measurement. Units that are recognised are N mm and kN m, radians and
    arcminutes. A deflection is not checked if the model has no static equilibrium at the torques of its loop.
    """
    rated_torque = model.reducer.design.rated_torque
    for loop in loops:
        require_torque(loop, rated_torque)
        try:
            rotation = np.concatenate([rotation for _, rotation in model_branches(model, condition, loop)])
        except RunError:
            continue
        expected = float(np.ptp(rotation))
        if loop.height * LIMITS.radians_factor < expected < loop.height / DEGREE * LIMITS.radians_factor:
            raise UsageError(
                f"{loop.name}: the measured deflection has a range of {loop.height / DEGREE:.3g} deg, but the model "
                f"predicts {expected / DEGREE:.3g} deg. If the column {DEFLECTION} is in radians, multiply it by "
                "57.2958; if not, set the clearances of the design closer to those of the measured drive"
            )
        if loop.height > LIMITS.arcminutes_factor * expected:
            raise UsageError(
                f"{loop.name}: the measured deflection has a range of {loop.height / DEGREE:.3g} deg, but the model "
                f"predicts {expected / DEGREE:.3g} deg. If the column {DEFLECTION} is in arcminutes, divide it by 60; "
                "if not, set the clearances and the stiffness of the design closer to those of the measured drive"
            )


def _require_sensitivity(problem: FitProblem) -> None:
    """Raise UsageError if no parameter of the fit `problem` changes any loop (central differences of the residuals)."""
    start_values = np.array(
        [parameter.to_scale(parameter.start) for parameter in problem.parameters] + [0.0] * (2 * len(problem.loops))
    )
    if not np.any(
        np.abs(problem.slopes(start_values, range(len(problem.parameters)), central=True)) > LIMITS.min_sensitivity
    ):
        raise UsageError(
            f"--fit {','.join(parameter.key for parameter in problem.parameters)}: none of these parameters affects "
            f"the modelled loop. Fit parameters that do, such as {','.join(default_keys(problem.model.reducer))}"
        )
