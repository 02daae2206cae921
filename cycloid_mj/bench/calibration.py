"""A calibration: the design that a measured loop is that of, how sure each of its values is, and what stays open."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.base.result import Table
from cycloid_mj.base.types import Array
from cycloid_mj.base.units import DEGREE
from cycloid_mj.bench.fit import COVERED, Fitted, fit
from cycloid_mj.bench.loop import DEFLECTION, TORQUE, MeasuredLoop
from cycloid_mj.bench.overlay import LoopCondition, model_branches, put_all
from cycloid_mj.bench.parameters import DEFAULT, Model, Parameter, parameters
from cycloid_mj.bench.search import STEP, FitProblem
from cycloid_mj.design import Design, Friction
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.limits import stops
from cycloid_mj.statics.sliding import Held, Losses, turn_under
from cycloid_mj.statics.windup import STRAIGHT

Progress = Callable[[int], None]
"""Called at each trial of the search with how many there have been."""

ALIKE = 0.95
"""Correlation from which on a loop cannot tell two values apart."""

SILENT = 1e-6
"""Change of the residuals, as shares of a loop's ranges and by a parameter's scale, below which there is none."""

RADIANS, MINUTES, MILLIMETRES = 8.0, 30.0, 30.0
"""How much lower than the design's own a loop is at least that is taken to be in radians; how much higher one in
minutes of arc; and how many times the rated torque a torque goes to that is taken to be in N mm."""

DEFINITIONS = {
    "play_deg": "turn of the output between its stops at the held crank angle, rigid parts, with the fitted clearances",
    "stiffness_nm_per_rad": "slope of the fitted curve without friction from 50 to 100 % of the largest torque "
    "measured, mean of both sides",
    "coulomb_nm": "half the torque between the measured branches half-way up the deflection of the lowest loop, where "
    "the teeth carry nothing",
    "residual_rms_deg": "rms difference of all measured deflections from the fitted loop's at the same torque, without "
    "those on the way to the loop",
}
"""How the figures of a calibration are read."""

UNEXPLAINED = (
    "twist of housing, shafts and output pins is not told apart from the teeth: tooth_stiffness stands for all of it",
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
        What it came out as, and what it is.
    ci95
        The ends of its interval of 95 %.
    identified
        Whether the loop determines it: the interval is no wider than twice the value, and neither of its ends is that
        of what is looked for.
    """

    value: float
    unit: str
    meaning: str
    ci95: tuple[float, float]
    identified: bool


@dataclass(frozen=True)
class Variant:
    """The fit of other losses to the same loops: rms over height of each loop, Bayes's criterion, and its values.

    The criterion compares with those of the other variants alone.
    """

    key: str
    meaning: str
    shares: tuple[float, ...]
    criterion: float
    values: dict[str, float]


@dataclass(frozen=True, eq=False)
class Calibration:
    """What a calibration found.

    Attributes
    ----------
    fitted
        The fit.
    design
        The calibrated design.
    estimates
        By key.
    alike
        Pairs of keys that the loop cannot tell apart, with their correlation.
    play, stiffness, coulomb
        By `DEFINITIONS` [rad], [N m/rad], [N m]; the first two with the ends of their intervals of 95 %.
    variants
        Fits with other losses, if they were asked for.
    notes
        What was noticed, a sentence each.
    """

    fitted: Fitted
    design: Design
    estimates: dict[str, Estimate]
    alike: tuple[tuple[str, str, float], ...]
    play: tuple[float, float, float]
    stiffness: tuple[float, float, float]
    coulomb: float
    variants: tuple[Variant, ...] = ()
    notes: tuple[str, ...] = ()

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

    def tables(self) -> tuple[Table, ...]:
        """Tabulate parameters, figures, loops and variants."""
        rows = tuple(
            (
                key,
                estimate.value,
                f"{estimate.ci95[0]:.4g} to {estimate.ci95[1]:.4g}",
                estimate.unit,
                "" if estimate.identified else "no",
            )
            for key, estimate in self.estimates.items()
        )
        low, high = (f"{end / DEGREE:.4g}" for end in self.play[1:])
        figures = (
            ("play", self.play[0] / DEGREE, f"{low} to {high}", "deg", DEFINITIONS["play_deg"]),
            (
                "stiffness",
                self.stiffness[0],
                f"{self.stiffness[1]:.4g} to {self.stiffness[2]:.4g}",
                "N m/rad",
                DEFINITIONS["stiffness_nm_per_rad"],
            ),
            ("Coulomb friction", self.coulomb, "", "N m", DEFINITIONS["coulomb_nm"]),
        )
        loops = tuple(
            (
                loop.name,
                float(len(loop.torque)),
                loop.height / DEGREE,
                self.fitted.rms(place) / DEGREE,
                f"{self.fitted.rms(place) / loop.height:.1%}",
                2.0 * loop.most,
            )
            for place, loop in enumerate(self.fitted.loops)
        )
        tables = [
            Table(
                f"{self.design.name}: fitted values",
                ("value", "fitted", "95 %", "unit", "determined by the loop"),
                rows,
            ),
            Table("figures, by definition", ("figure", "value", "95 %", "unit", "definition"), figures),
            Table(
                "loops",
                ("loop", "points", "height [deg]", "residual rms [deg]", "of the height", "torque range [N m]"),
                loops,
            ),
        ]
        if self.variants:
            least = min(variant.criterion for variant in self.variants)
            header = (
                "losses",
                *(f"{loop.name}: rms of height" for loop in self.fitted.loops),
                "BIC above best",
                "values",
            )
            tables.append(
                Table(
                    "which losses explain the loops",
                    header,
                    tuple(
                        (
                            variant.meaning,
                            *(f"{share:.1%}" for share in variant.shares),
                            variant.criterion - least,
                            ", ".join(f"{key} {value:.3g}" for key, value in variant.values.items()),
                        )
                        for variant in self.variants
                    ),
                )
            )
        return tuple(tables)

    def as_json(self) -> dict[str, Any]:
        """Convert all of it to JSON values."""
        loops = self.fitted.loops
        return {
            "design": self.design.name,
            "held": self.fitted.bench.held,
            "crank_deg": self.fitted.bench.crank / DEGREE,
            "parameters": {
                key: {
                    "value": estimate.value,
                    "unit": estimate.unit,
                    "ci95": list(estimate.ci95),
                    "identified": estimate.identified,
                    "meaning": estimate.meaning,
                }
                for key, estimate in self.estimates.items()
            },
            "unidentified": list(self.unidentified),
            "indistinguishable": [{"keys": [one, other], "correlation": size} for one, other, size in self.alike],
            "correlations": {
                estimate: dict(zip(self.estimates, row, strict=True))
                for estimate, row in zip(self.estimates, correlations(self.fitted).tolist(), strict=True)
            },
            "residual_rms_deg": self.rms / DEGREE,
            "play_deg": self.play[0] / DEGREE,
            "play_ci95_deg": [end / DEGREE for end in self.play[1:]],
            "stiffness_nm_per_rad": self.stiffness[0],
            "stiffness_ci95_nm_per_rad": list(self.stiffness[1:]),
            "coulomb_nm": self.coulomb,
            "definitions": DEFINITIONS,
            "loops": [
                {
                    "name": loop.name,
                    "points": len(loop.torque),
                    "height_deg": loop.height / DEGREE,
                    "residual_rms_deg": self.fitted.rms(place) / DEGREE,
                    "residual_share": self.fitted.rms(place) / loop.height,
                    "width_at_zero_torque_deg": loop.middle()[0] / DEGREE,
                    "offset_torque_nm": float(self.fitted.offsets[place, 0]),
                    "offset_deg": float(self.fitted.offsets[place, 1]) / DEGREE,
                    "points_left_out": loop.lead,
                    "sign_turned": loop.flipped,
                }
                for place, loop in enumerate(loops)
            ],
            "losses": [
                {
                    "key": variant.key,
                    "residual_shares": list(variant.shares),
                    "bic": variant.criterion,
                    "values": variant.values,
                }
                for variant in self.variants
            ],
            "unexplained": list(UNEXPLAINED),
            "notes": list(self.notes),
        }


def calibrate(
    design: Design,
    loops: Sequence[MeasuredLoop],
    keys: Sequence[str] = DEFAULT,
    held: Held = "crank",
    crank: float = 0.0,
    progress: Progress = lambda done: None,
) -> Calibration:
    """Fit values of a design to measured hysteresis loops.

    Parameters
    ----------
    design
        As drawn: where the search begins, and all that is not fitted.
    loops
        Measured on one drive.
    keys
        What to fit: names of ``bench.parameters.NAMED``, or keys of the design file.
    held
        Which shaft the bench held.
    crank
        Angle of the crank [rad].
    progress
        Called at each trial.

    Raises
    ------
    UsageError
        There is no loop, a key is unknown, no key answers to the loop, or a loop is not in degrees.
    RunError
        No static balance was found.
    """
    reducer = Reducer(design)
    if not loops:
        raise UsageError("there is no loop to calibrate by: give at least one with --loop")
    drag = reducer.design.drag.output + (reducer.design.lobes * reducer.design.drag.crank if held == "output" else 0.0)
    model, bench = Model(reducer, Losses(drag)), LoopCondition(held, crank)
    _require_units(model, loops, bench)
    chosen, counted = parameters(reducer, keys, loops), _counting(progress)
    _require_answers(FitProblem(model, chosen, tuple(loops), bench, counted))
    return _calibration(fit(model, chosen, loops, bench, counted))


def calibrated_name(reducer: Reducer) -> str:
    """Return the name that a design has once it is calibrated."""
    return f"{reducer.design.name}-calibrated"[:64]


def compare_losses(
    calibration: Calibration,
    progress: Progress = lambda done: None,
    done: Callable[[Calibration], object] = lambda found: None,
) -> Calibration:
    """Fit constant friction alone, with that of the contacts, with a lossy material, and with both, to the same loops.

    Each search has starts of its own; `done` is called after each with what there is by then.

    Raises
    ------
    RunError
        No static balance was found.
    """
    fitted = calibration.fitted
    common = [parameter.key for parameter in fitted.parameters if parameter.key not in ("friction", "material_loss")]
    smooth, counted = _smooth(fitted.model.reducer), _counting(progress)
    fits: dict[tuple[str, str], Fitted] = {}
    for key, meaning, extra, rough in (
        ("constant", "constant friction alone", (), False),
        ("friction", "and friction of the contacts", ("friction",), True),
        ("material", "and a lossy material, no friction of the contacts", ("material_loss",), False),
        ("both", "and both", ("friction", "material_loss"), True),
    ):
        base = replace(fitted.model, reducer=Reducer(fitted.model.reducer.design if rough else smooth))
        chosen = parameters(fitted.model.reducer, [*common, *extra], fitted.loops)
        fits[key, meaning] = fit(base, chosen, fitted.loops, fitted.bench, counted, intervals=False)
        calibration = replace(calibration, variants=variants(fits))
        done(calibration)
    return calibration


def variants(fits: Mapping[tuple[str, str], Fitted]) -> tuple[Variant, ...]:
    """Set side by side the fits of several models to the same loops, by their keys and meanings.

    What counts as independent is told by the fullest of them, for all: its residuals are nearest to noise.
    """
    independent = max(fits.values(), key=lambda one: len(one.parameters)).independent
    return tuple(
        Variant(
            key,
            meaning,
            tuple(fit.rms(place) / loop.height for place, loop in enumerate(fit.loops)),
            fit.criterion(independent),
            {name.key: float(value) for name, value in zip(fit.parameters, fit.values, strict=True)},
        )
        for (key, meaning), fit in fits.items()
    )


def correlations(fitted: Fitted) -> Array:
    """Compute the correlations of the parameters, shape (p, p); 0 of those at a bound."""
    count = len(fitted.parameters)
    covariance = fitted.spread.covariance[:count, :count]
    size = np.sqrt(np.diag(covariance))
    both = np.outer(size, size)
    return np.asarray(np.divide(covariance, both, out=np.eye(count), where=both > 0.0))


def _counting(progress: Progress) -> Callable[[], None]:
    done = [0]

    def count() -> None:
        done[0] += 1
        progress(done[0])

    return count


def _calibration(fitted: Fitted) -> Calibration:
    count = len(fitted.parameters)
    estimates = {
        parameter.key: _estimate(parameter, float(place), ends, bool(bound))
        for parameter, place, ends, bound in zip(
            fitted.parameters, fitted.places, fitted.ends, fitted.at_bound, strict=False
        )
    }
    related = correlations(fitted)
    keys = list(estimates)
    alike = tuple(
        (keys[i], keys[j], float(related[i, j])) for i in range(count) for j in range(i) if abs(related[i, j]) > ALIKE
    )
    calibrated = fitted.calibrated.reducer.design
    lowest = min(fitted.loops, key=_height)
    return Calibration(
        fitted=fitted,
        design=calibrated.but(name=calibrated_name(Reducer(calibrated))),
        estimates=estimates,
        alike=alike,
        play=_derived(fitted, _play),
        stiffness=_derived(fitted, _slope),
        coulomb=0.5 * lowest.middle()[1],
        notes=_notes(fitted),
    )


def _estimate(parameter: Parameter, place: float, ends: Array, at_bound: bool) -> Estimate:
    value, low, high = (parameter.value(float(at)) for at in (place, *ends))
    ended = parameter.place(parameter.least) < ends[0] and ends[1] < parameter.place(parameter.most)
    identified = bool(not at_bound and ended and high - low < 2.0 * abs(value))
    return Estimate(value, parameter.unit, parameter.meaning, (low, high), identified)


def _derived(fitted: Fitted, read: Callable[[Fitted, Model], float]) -> tuple[float, float, float]:
    """Compute a figure of the fitted model and its interval, by how it answers to each value."""
    count = len(fitted.parameters)

    def at(places: Array) -> float:
        return read(fitted, put_all(fitted.model, fitted.parameters, fitted.values_at(places)))

    value, slopes = at(fitted.places), np.zeros(len(fitted.places))
    for place in np.flatnonzero(~fitted.at_bound[:count]):
        moved = np.stack([fitted.places, fitted.places])
        moved[:, place] += [-STEP, STEP]
        slopes[place] = (at(moved[1]) - at(moved[0])) / (2.0 * STEP)
    variance = float(slopes @ fitted.spread.covariance @ slopes)
    spread = fitted.spread.reach_along(slopes, COVERED) * max(variance, 0.0) ** 0.5
    return value, max(value - spread, 0.0), value + spread


def _height(loop: MeasuredLoop) -> float:
    return loop.height


def _play(fitted: Fitted, model: Model) -> float:
    low, high = stops(model.reducer, fitted.bench.crank)
    return high - low


def _slope(fitted: Fitted, model: Model) -> float:
    smooth = Reducer(_smooth(model.reducer))
    most = max(loop.most for loop in fitted.loops)
    low, high = STRAIGHT
    # without friction a torque alone decides where parts are: no course needs to be followed
    rise = [
        way
        * (
            turn_under(smooth, way * high * most, fitted.bench.crank)
            - turn_under(smooth, way * low * most, fitted.bench.crank)
        )
        for way in (-1.0, 1.0)
    ]
    return (high - low) * most / float(np.mean(rise))


def _smooth(reducer: Reducer) -> Design:
    """Return a design whose contacts have no friction."""
    return reducer.but(friction=dict.fromkeys(Friction.model_fields, 0.0)).design


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
        for one, value, bound in zip(fitted.parameters, fitted.values, fitted.at_bound, strict=False)
        if bound
    ]
    return tuple(notes)


def _require_units(model: Model, loops: Sequence[MeasuredLoop], bench: LoopCondition) -> None:
    """Refuse a loop that is near the design's only if it was meant in N mm, in radians, or in minutes of arc."""
    rated = model.reducer.design.rated_torque
    for loop in loops:
        if rated and loop.most > MILLIMETRES * rated:
            raise UsageError(
                f"{loop.name}: the torque goes to {loop.most:.4g} N m, {loop.most / rated:.3g} times the design's "
                f"rated {rated:.4g} N m: is {TORQUE} in N mm? then divide it by 1000; if not, give the design its "
                "drive.torque_nm"
            )
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
