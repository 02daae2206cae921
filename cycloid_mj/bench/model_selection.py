"""Choice between models of a measured loop by the Bayesian information criterion, and where a fitted one misses it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.statistics import rms
from cycloid_mj.base.units import DEGREE
from cycloid_mj.bench.fit import Fitted, fit_loops
from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.loop_figures import READING, loop_coulomb_torque
from cycloid_mj.bench.overlay import LoopCondition
from cycloid_mj.bench.parameters import WIND_UP_FRICTION, Model, default_keys, fit_parameters
from cycloid_mj.bench.search import MODEL_ERROR, FitProblem, Trials

DESIGN_MODEL = "hysteresis"
"""Candidate whose values the calibrated design has: a design and stock MuJoCo have only friction of constant size."""

CANDIDATES: Mapping[str, tuple[str, tuple[str, ...]]] = {
    DESIGN_MODEL: ("constant friction and hysteresis", ("hysteresis", "hysteresis_travel")),
    "constant": ("constant friction alone", ()),
    "load": ("constant friction and friction in proportion to the torque", ("load_friction",)),
}
"""Models of a locked drive by their keys: meaning, and what is fitted in addition to the values that all have."""


@dataclass(frozen=True)
class ModelFit:
    """The fit of one model to the same loops."""

    key: str
    meaning: str
    """Its key in JSON, and what it is."""
    shares: tuple[float, ...]
    """Rms difference of each loop's deflection from the model's at the same torque, over the loop's height."""
    bayesian: float
    akaike: float
    """Bayesian and Akaike's information criterion; they compare only with those of the same comparison."""
    values: dict[str, float]
    """The fitted values of the parameters by key, in their units."""


@dataclass(frozen=True)
class LoopStretch:
    """Deviation of a fitted model from a stretch of a measured loop."""

    loop: str
    stretch: str
    """Name of the loop, and which part of it."""
    first: float
    last: float
    """Torque at which it begins and ends [N m]."""
    mean: float
    rms: float
    """Mean and rms of the measured deflection minus the model's [rad]."""
    share: float
    """The rms over the loop's height [1]."""

    @property
    def is_within_model_error(self) -> bool:
        """True if the deviation is within the model error that the intervals assume (`MODEL_ERROR`)."""
        return self.share <= MODEL_ERROR

    @property
    def sentence(self) -> str:
        """Describe position and size of the deviation in a sentence."""
        side = "above" if self.mean > 0.0 else "below"
        return (
            f"{self.loop}, {self.stretch} from {self.first:+.3g} to {self.last:+.3g} N m: the measured deflection is "
            f"{abs(self.mean) / DEGREE:.2g} deg {side} the fitted one in the mean, {self.share:.1%} of the height rms"
        )


def compare_candidates(fits: Mapping[str, Fitted]) -> tuple[ModelFit, ...]:
    """Compare the fits of `CANDIDATES` by their keys."""
    return compare_fits({(key, CANDIDATES[key][0]): fitted for key, fitted in fits.items()})


def compare_fits(fits: Mapping[tuple[str, str], Fitted]) -> tuple[ModelFit, ...]:
    """Compare several models that are fitted to the same measured loops; return one `ModelFit` for each, in order.

    A `ModelFit` has the rms residual of each loop over the height of the loop [1], the Bayesian and Akaike's
    information criterion [1], and the fitted values of the model's parameters in their units. The keys of `fits` are
    pairs of a model's key and its meaning in words. All criteria use the same number of independent residuals of each
    loop: those of the model with the most parameters, because its residuals are nearest to noise.
    """
    independent_residuals = max(fits.values(), key=lambda fit: len(fit.parameters)).independent
    return tuple(
        ModelFit(
            key,
            meaning,
            tuple(fitted.rms(index) / loop.height for index, loop in enumerate(fitted.loops)),
            fitted.bayesian_criterion(independent_residuals),
            fitted.akaike_criterion(independent_residuals),
            {parameter.key: float(value) for parameter, value in zip(fitted.parameters, fitted.values, strict=True)},
        )
        for (key, meaning), fitted in fits.items()
    )


def fit_candidates(
    model: Model, loops: Sequence[MeasuredLoop], condition: LoopCondition, trials: Trials
) -> Iterator[tuple[str, Fitted]]:
    """Fit each friction model in `CANDIDATES` to the loops, one after the other.

    The fits have no intervals by profile likelihood. `condition` has the locked shaft and the crank angle of the
    measurement. `trials` counts the evaluations; the number that it expects includes a later fit of the design's own
    model, `DESIGN_MODEL`, with intervals.

    Yields
    ------
    tuple
        Key of the model, and its fit.

    Raises
    ------
    RunError
        The model has no static equilibrium.
    FitStopped
        Ctrl-C was pressed.
    """
    common_keys = [key for key in default_keys(model.reducer) if key not in WIND_UP_FRICTION]
    parameters_by_model = {
        key: fit_parameters(model.reducer, (*common_keys, *extra_keys), loops)
        for key, (_, extra_keys) in CANDIDATES.items()
    }
    problems = {
        key: FitProblem(model, parameters, tuple(loops), condition, trials)
        for key, parameters in parameters_by_model.items()
    }
    trials_by_model = {key: problem.usual_trials(intervals=False) for key, problem in problems.items()}
    final_trials = problems[DESIGN_MODEL].usual_trials(intervals=True)
    for fitted_count, (key, parameters) in enumerate(parameters_by_model.items(), 1):
        trials.later = sum(list(trials_by_model.values())[fitted_count:]) + final_trials
        yield key, fit_loops(model, parameters, loops, condition, trials, intervals=False)
    trials.later = 0.0


def select_model(fits: Sequence[ModelFit]) -> ModelFit:
    """Return the model with the lowest Bayesian information criterion (Schwarz, Ann. Statist. 6, 1978, 461-464)."""
    return min(fits, key=lambda item: item.bayesian)


def compare_sections(fitted: Fitted) -> tuple[LoopStretch, ...]:
    """Return the deviation of the model's deflection from the measured one in six sections of each loop.

    `fitted` is the result of the fit. There are three sections with rising and three with falling torque. In the first
    the drive is unloaded to zero torque, in the second it crosses the play, and in the third, from
    `READING.loaded_coulomb` times the Coulomb torque on, it is loaded on the other side. A section without points is
    omitted.
    """
    rows = []
    for loop, modelled_deflection in zip(fitted.loops, fitted.turns, strict=True):
        coulomb_torque = loop_coulomb_torque(loop).value
        loaded_torque = READING.loaded_coulomb * coulomb_torque if np.isfinite(coulomb_torque) else 0.0
        for direction, direction_text in ((1, "torque rising"), (-1, "torque falling")):
            is_moving, signed_torque = loop.moving(direction), direction * loop.torque
            is_across_play = (signed_torque >= 0.0) & (signed_torque < loaded_torque)
            sections = {
                "unloading": signed_torque < 0.0,
                "across the play": is_across_play,
                "loading": signed_torque >= loaded_torque,
            }
            for section, is_inside in sections.items():
                if np.any(is_moving & is_inside):
                    rows.append(
                        _compare_section(
                            loop, modelled_deflection, f"{direction_text}, {section}", is_moving & is_inside, direction
                        )
                    )
    return tuple(rows)


def _compare_section(loop: MeasuredLoop, modelled: Array, name: str, mask: Mask, direction: int) -> LoopStretch:
    """Return the deviation of the modelled deflection [rad] from the measured one in a section of a loop.

    `modelled` (n,) has the n points of the loop. `mask` selects the points of the section, `name` is its name;
    `direction` is 1 if the torque rises in it, else -1.
    """
    differences, torque = (loop.deflection - modelled)[mask], loop.torque[mask]
    start_torque, end_torque = (float(torque.min()), float(torque.max()))[::direction]
    return LoopStretch(
        loop.name,
        name,
        start_torque,
        end_torque,
        float(np.mean(differences)),
        rms(differences),
        rms(differences) / loop.height,
    )
