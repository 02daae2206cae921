"""A model laid over measured loops: the values that bring it nearest, and how far each of them can be from there.

An interval ends where the loops are missed by too much even with all other values fitted anew: that of the profile
likelihood (Venzon and Moolgavkar, Appl. Statist. 37, 1988, 87-94). Where values lie in a long bent valley, as friction
of contacts and constant friction do, that of the straight neighbourhood would be far too narrow. There may be several
valleys that explain the loops alike: an interval reaches as far as any of them does, from the ends of all searches.

A model is off by more than noise. Whatever the course of an error of the rms value d is, it moves a value by no more
than d times the root of its inverse curvature (by Cauchy and Schwarz, where the model is straight): intervals reach as
much farther than noise alone carries them, with d = `DISCREPANCY`. What is known without the loops, as of a clearance
whose tolerance the design states, counts as one that is off by as much at one standard deviation.

Such intervals leave a room in which the loops tell no values from others. What a design is asked for is the loop again:
of all values within their intervals those are taken with which the model's turns miss the measured ones least, rms at
the same torque, and what that does not ask for stays where it is likeliest (`FitProblem.nearest`). The likeliest values
need not be these where the model is off: their measure is the distance from a branch, in which a leap across the play
that comes a little early counts little, and an outlier less.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from operator import itemgetter

import numpy as np

from cycloid_mj.base.array import Array, Mask
from cycloid_mj.base.errors import RunError
from cycloid_mj.base.statistics import rms
from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.overlay import Branches, LoopCondition, deflections, model_branches, put_all
from cycloid_mj.bench.parameters import Model, Parameter
from cycloid_mj.bench.search import DISCREPANCY, FAILED, LONG, SHORT, FitProblem, Trials, offset_scales
from cycloid_mj.bench.uncertainty import COVERED, FitUncertainty, memory, spread

AT_BOUND = 1e-3
"""Distance from a bound, on a value's scale, at which a value is at it."""

PROFILED, DOUBLED = 4, 4
"""Steps of the search for all other values with one of them held, and how often that one is moved twice as far."""

GAINED, RENEWED = 1e-3, 3
"""Relative gain at which a place found on the way is where the search goes on, and how often it may."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """A model laid over loops.

    Attributes
    ----------
    model, parameters, bench, loops
        What was fitted to what.
    likeliest
        Places of the parameters, then of each loop's offsets of torque and deflection, on their scales: where the
        residuals are least.
    places
        The same where the model repeats the loops best, within the intervals of 95 %.
    residuals
        Of each loop's points, as shares of its range, where they are least.
    slopes
        Of all residuals by all places there, shape (points, values).
    spread
        How sure the places are; of those at a bound, which is no measurement, 0.
    at_bound
        Which of them are.
    ends
        Of the interval of each place that covers `COVERED`, shape (values, 2); one-sided at a bound.
    known
        Share of what is known of each place that the loops do not tell, but the drawing: from 0 to 1, shape (values,).
    torque_offset
        Whether the loops have zero offsets of torque; else these are 0.
    offset_gain
        Bayesian information criterion without such offsets less that with them: positive where the loops support them.
    """

    model: Model
    parameters: tuple[Parameter, ...]
    bench: LoopCondition
    loops: tuple[MeasuredLoop, ...]
    likeliest: Array
    places: Array
    residuals: tuple[Array, ...]
    slopes: Array
    spread: FitUncertainty
    at_bound: Mask
    ends: Array
    known: Array
    torque_offset: bool = True
    offset_gain: float = math.nan

    @property
    def values(self) -> Array:
        """The parameters' values, in their units."""
        return self.values_at(self.places)

    @cached_property
    def calibrated(self) -> Model:
        """The model with them."""
        return put_all(self.model, self.parameters, self.values)

    @property
    def offsets(self) -> Array:
        """Of each loop in torque [N m] and deflection [rad], shape (loops, 2)."""
        shares = self.places[len(self.parameters) :].reshape(-1, 2)
        return shares * np.array([offset_scales(loop) for loop in self.loops])

    @cached_property
    def branches(self) -> tuple[Branches, ...]:
        """Torque [N m] and deflection [rad] of the model along each branch of each loop, with the loop's offsets."""
        lines = []
        for loop, (torque, deflection) in zip(self.loops, self.offsets, strict=True):
            branches = model_branches(self.calibrated, self.bench, loop, float(torque))
            lines.append([(loads + torque, turns + deflection) for loads, turns in branches])
        return tuple(lines)

    @cached_property
    def turns(self) -> tuple[Array, ...]:
        """The model's deflection at every measured point [rad]: that of its branch at the measured torque."""
        return tuple(deflections(loop, branches) for loop, branches in zip(self.loops, self.branches, strict=True))

    @property
    def independent(self) -> tuple[float, ...]:
        """How many residuals of each loop count as independent (`memory`)."""
        return tuple(len(residual) / memory(residual) for residual in self.residuals)

    @property
    def free_values(self) -> int:
        """Number of values that were fitted, offsets included."""
        return len(self.places) - (0 if self.torque_offset else len(self.loops))

    def criterion(self, independent: Sequence[float]) -> float:
        """Compute the Bayesian information criterion, with a number of independent residuals of each loop.

        Criteria of models compare only where that number is the same: a model that leaves something out has correlated
        residuals, and by its own count would have less to explain.
        """
        return _misfit(self.residuals, independent) + self.free_values * float(np.log(sum(independent)))

    def akaike(self, independent: Sequence[float]) -> float:
        """Compute Akaike's information criterion by the same residuals."""
        return _misfit(self.residuals, independent) + 2.0 * self.free_values

    def values_at(self, places: Array) -> Array:
        """Compute the parameters' values at other places."""
        return np.array([parameter.value(place) for parameter, place in zip(self.parameters, places, strict=False)])

    def rms(self, place: int) -> float:
        """Compute the rms difference of a loop's deflection from the model's at the measured torque [rad]."""
        loop = self.loops[place]
        return rms((self.turns[place] - loop.deflection)[loop.lead :])

    def rms_without(self, place: int) -> float:
        """Compute that difference with no offset of torque, as in a scene, and the best of deflection [rad]."""
        loop = self.loops[place]
        turn = deflections(loop, model_branches(self.calibrated, self.bench, loop))
        return float(np.std((turn - loop.deflection)[loop.lead :]))


class FitStopped(KeyboardInterrupt):
    """Ctrl-C, or a signal of the same effect, came when a search had ended: `fitted` is the best there was by then."""

    def __init__(self, stop: KeyboardInterrupt, fitted: Fitted) -> None:
        super().__init__(*stop.args)
        self.fitted = fitted


def fit(
    model: Model,
    parameters: Sequence[Parameter],
    loops: Sequence[MeasuredLoop],
    bench: LoopCondition,
    trials: Trials | None = None,
    start: Array | None = None,
    intervals: bool = True,
    torque_offset: bool | None = None,
) -> Fitted:
    """Fit parameters to loops by robust least squares, from several starts or one; `trials` are counted.

    Without `intervals` they are those of the straight neighbourhood, which take no further search, and the values are
    the likeliest. Whether each loop has a zero offset of torque, `torque_offset`, is by default chosen by the Bayesian
    information criterion.

    Raises
    ------
    RunError
        No static balance was found.
    FitStopped
        Ctrl-C: it has the best values by then, and intervals of the straight neighbourhood where no other was found.
    """
    search = FitProblem(model, tuple(parameters), tuple(loops), bench, trials or Trials(), torque_offset is not False)
    searches = {"ends": 2 * len(search.parameters), "nearest": 1} if intervals else {}
    ended: list[tuple[float, Array]] = []
    fits: list[Fitted] = []
    try:
        search.trials.expect(search.usual_trials(intervals))
        starts = search.starts() if start is None else [start]
        again = len(starts) if torque_offset is None else 0
        for number, one in enumerate(starts):
            search.trials.expect(search.expected_trials(starts=len(starts) - number, again=again, long=1, **searches))
            ended.append(search.run(one, SHORT, "trf"))
        ended.sort(key=itemgetter(0))
        gain = math.nan
        if torque_offset is None:
            search, gain, ended = _choose_offset(search, ended)
        best, *others = ended
        place = best[1]
        for _ in range(RENEWED):
            search.trials.expect(search.expected_trials(long=1, **searches))
            cost, place = search.run(place, LONG, "trf")
            ended.append((cost, place))
            fits.append(replace(fitted_at(search, place), offset_gain=gain))
            better = widen(search, fits[-1], [(cost, place), *others]) if intervals else None
            if better is None:
                break
            others.append((cost, place))
            place = better
        return replace(fits[-1], places=search.nearest(place, *fits[-1].ends.T)) if intervals else fits[-1]
    except KeyboardInterrupt as stop:
        if not ended:
            raise
        raise FitStopped(stop, fits[-1] if fits else fitted_at(search, min(ended, key=itemgetter(0))[1])) from stop


def fitted_at(search: FitProblem, places: Array) -> Fitted:
    """Compute the fit at places, with the intervals of the straight neighbourhood.

    Raises
    ------
    RunError
        A loop has no model there.
    """
    low, high = search.bounds
    parts = search.parts(places)
    if failed := [loop.name for loop, part in zip(search.loops, parts, strict=True) if np.all(part == FAILED)]:
        raise RunError(
            f"no model of {' and '.join(failed)} has a static balance near the design: is its friction too large?"
        )
    # those of what is known without the loops stand last
    slopes = search.slopes(places, range(len(places)), central=True)[: sum(map(len, parts))]
    known = DISCREPANCY * search.known
    at_bound = ~((places > low + AT_BOUND) & (places < high - AT_BOUND))
    of_loops = np.split(slopes, np.cumsum([len(part) for part in parts])[:-1])
    weighted = [part / np.sqrt(len(part)) for part in parts]
    sure = spread(of_loops, weighted, ~at_bound, known)
    whole = spread(of_loops, weighted, np.ones_like(at_bound), known) if at_bound.any() else sure
    each = (whole if bound else sure for bound in at_bound.tolist())
    reach = np.array(
        [
            one.reach(COVERED)[place] * one.errors[place] + DISCREPANCY * one.inverse[place, place] ** 0.5
            for place, one in enumerate(each)
        ]
    )
    ends = np.clip(places[:, np.newaxis] + np.outer(reach, [-1.0, 1.0]), low[:, np.newaxis], high[:, np.newaxis])
    return Fitted(
        model=search.model,
        parameters=search.parameters,
        bench=search.bench,
        loops=search.loops,
        likeliest=places,
        places=places,
        residuals=tuple(parts),
        slopes=slopes,
        spread=sure,
        at_bound=at_bound,
        ends=ends,
        known=known**2 * np.diag(sure.inverse),
        torque_offset=search.torque_offset,
    )


def _misfit(residuals: Sequence[Array], independent: Sequence[float]) -> float:
    """Compute n log(mean square) over the loops: twice the negative logarithm of the likelihood, but for a constant."""
    each = zip(independent, residuals, strict=True)
    return sum(count * float(np.log(np.mean(one**2))) for count, one in each)


def _choose_offset(
    search: FitProblem, ended: list[tuple[float, Array]]
) -> tuple[FitProblem, float, list[tuple[float, Array]]]:
    """Choose by the Bayesian information criterion whether the loops have zero offsets of torque.

    `ended` are the ends of the searches with such offsets and their costs, the best first. Returned are the problem, by
    how much the criterion is lower with offsets, and the ends of the searches of that problem, the best first.
    """
    without = replace(search, torque_offset=False)
    again = sorted((without.run(place, SHORT, "trf") for _, place in ended), key=itemgetter(0))
    parts, fixed = search.parts(ended[0][1]), without.parts(again[0][1])
    independent = [len(part) / memory(part) for part in parts]
    gain = _misfit(fixed, independent) - _misfit(parts, independent) - len(search.loops) * math.log(sum(independent))
    return (search, gain, ended) if gain > 0.0 else (without, gain, again)


def widen(search: FitProblem, fitted: Fitted, valleys: Sequence[tuple[float, Array]]) -> Array | None:
    """Put the ends of each interval where the loops are missed by too much; or return a place that misses them less.

    `valleys` are where searches ended, each with its cost, the fit itself first: in each of them that explains the
    loops as well as the interval allows, an end of its own is looked for, and the farthest one counts.
    """
    inverse, least = fitted.spread.inverse, valleys[0][0]
    apart = [np.any(np.abs(one - fitted.likeliest) > fitted.spread.errors) for _, one in valleys[1:]]
    valleys = [valleys[0], *(valley for valley, other in zip(valleys[1:], apart, strict=True) if other)]
    unknown = np.all(fitted.ends == np.stack(search.bounds, axis=1), axis=1)
    open_places = np.flatnonzero(~(fitted.at_bound | unknown)[: len(search.parameters)])
    before, done, usual = search.trials.done, 0, search.expected_trials(ends=1)
    for place in open_places:
        for side, end in enumerate(fitted.ends[place].tolist()):
            each = (search.trials.done - before + usual) / (done + 1)
            search.trials.expect((2 * len(open_places) - done) * each + search.expected_trials(nearest=1))
            done += 1
            straight = end - fitted.likeliest[place]
            # what the sum of squares rises by there, where it is a paraboloid
            allowed, reached = 0.5 * straight**2 / inverse[place, place], []
            for cost, middle in valleys:
                if (left := allowed - (cost - least)) <= 0.0:
                    continue
                way, better = _reach(search, fitted, (cost, middle), int(place), side, left)
                if better is not None and better[0] < (1.0 - GAINED) * least:
                    return better[1]
                reached.append(float(middle[place]) + way)
            fitted.ends[place, side] = max(reached) if side else min(reached)
    return None


def _reach(
    search: FitProblem, fitted: Fitted, valley: tuple[float, Array], place: int, side: int, allowed: float
) -> tuple[float, tuple[float, Array] | None]:
    """Compute how far a value can be from where a valley has it, until the cost has risen by what is allowed.

    With it comes a place, and its cost, where the search ran into one that misses the loops less than the valley.
    """
    (cost, middle), inverse = valley, fitted.spread.inverse
    along = inverse[:, place] / inverse[place, place]
    most = float(search.bounds[side][place] - middle[place])
    way = (2.0 * allowed * float(inverse[place, place])) ** 0.5
    way = min(way, most) if side else max(-way, most)
    before = reached = rise = 0.0
    better = None
    for _ in range(DOUBLED):
        start = np.clip(middle + way * along, *search.bounds)
        now, trial = search.run(start, PROFILED, "dogbox", held=place)
        if now < cost:
            better = now, trial
        rise = max(now - cost, 0.0)
        if rise >= allowed or way == most:
            break
        reached, before = way, rise
        way = min(2.0 * way, most) if side else max(2.0 * way, most)
    else:
        # nothing that was tried ends the interval
        way = most
    if rise > allowed:
        ratio = (allowed**0.5 - before**0.5) / (rise**0.5 - before**0.5)
        way = reached + ratio * (way - reached)
    return way, better
