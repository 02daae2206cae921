"""The search of a calibration: residuals of measured loops by where all values are, and robust least squares of them.

Each loop has an offset of its own in torque and in deflection, which are no part of the drive. All values are looked
for on scales of their own, on which a step of one matters (`Parameter.place`).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product
from operator import itemgetter
from typing import Any, Literal

import numpy as np

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.engine import Progress, silent
from cycloid_mj.base.errors import RunError
from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.overlay import Branches, LoopCondition, deflections, distances, model_branches
from cycloid_mj.bench.parameters import Model, Parameter

OUTLIER = 0.03
"""Residual, as a share of a loop's range, from which a point counts less and less (soft L1)."""

DISCREPANCY = 0.03
"""What the model itself may miss the loops by, rms, as a share of their ranges: no model of a drive is nearer."""

FAILED = 1.0
"""Residual of every point where the model has no balance."""

STEP = 0.05
"""Step of differences, on a value's scale."""

SHORT, LONG = 12, 60
"""Most steps of a search from each of the starts, and of the one that goes on from the best of them."""

HELD = 1e-6
"""Way between both ends of a value, on its scale, below which it does not move."""

ENOUGH = 1e-3
"""Relative gain in squares at which a search for the nearest turns stops: half as much of their rms."""

STARTS: tuple[dict[str, float], ...] = (
    {},
    {"friction": 2.5, "drag": 0.5},
    {"hysteresis": 3.0, "hysteresis_travel": 3.0},
    {"hysteresis": 3.0, "drag": 0.5},
)
"""Where searches start, in factors on what a loop suggests: friction of contacts, or one that comes on little by
little, and constant friction, which make a loop wide, are told apart by little, so that there is a valley between them
in which a single search stops."""


TAKEN = {"starts": 8, "again": 3, "long": 14, "ends": 9, "nearest": 14}
"""Steps that the searches of a fit take by experience, for a progress: one from each start, one from there without
an offset of torque, the one that goes on, all for an end of an interval, and that for the nearest deflections."""


class Trials:
    """Counts the trials of a search for a progress, which is told how many are done and how many there may be."""

    def __init__(self, progress: Progress = silent) -> None:
        self.done, self.later, self._whole, self._progress = 0, 0.0, 0.0, progress

    def expect(self, more: float) -> None:
        """Say how many trials of this fit are to come; `later` ones, of other fits, are added."""
        self._whole = self.done + more + self.later

    def __call__(self) -> None:
        """Count one; none is told to be the last, as a search does not know."""
        self.done += 1
        self._progress(self.done, max(round(self._whole), self.done + 1))


@dataclass(frozen=True, eq=False)
class FitProblem:
    """The residuals of a model, and their slopes, by where all values are on their scales.

    Attributes
    ----------
    model, parameters, loops, bench
        What is fitted to what.
    trials
        Counter of the model's evaluations.
    torque_offset
        Whether each loop has a zero offset of torque that is fitted; else all of them are 0.
    """

    model: Model
    parameters: tuple[Parameter, ...]
    loops: tuple[MeasuredLoop, ...]
    bench: LoopCondition
    trials: Trials
    torque_offset: bool = True

    @cached_property
    def known(self) -> Array:
        """What is known of each place without the loops: 1 over its standard deviation, 0 where that is nothing."""
        deviations = [parameter.place_deviation for parameter in self.parameters]
        return 1.0 / np.array([*deviations, *([np.inf] * (2 * len(self.loops)))])

    @cached_property
    def expected(self) -> Array:
        """The places that are expected without the loops."""
        drawn = [parameter.place(parameter.start) for parameter in self.parameters]
        return np.array([*drawn, *([0.0] * (2 * len(self.loops)))])

    @cached_property
    def counts(self) -> Array:
        """Share of its loop that each residual is; one of what was known is whole."""
        return np.concatenate([*_weights(self.loops), np.ones(np.count_nonzero(self.known))])

    @property
    def bounds(self) -> tuple[Array, Array]:
        """The smallest and the largest places; alike where a place is fixed."""
        free = np.tile([np.inf if self.torque_offset else 0.0, np.inf], len(self.loops))
        low, high = (
            [parameter.place(getattr(parameter, end)) for parameter in self.parameters] for end in ("least", "most")
        )
        return np.concatenate([low, -free]), np.concatenate([high, free])

    def expected_trials(self, **searches: int) -> float:
        """Estimate the trials of some searches, as many of each kind of `TAKEN`."""
        step = 1 + 2 * (len(self.parameters) + 2 * len(self.loops))
        return float(step * sum(TAKEN[kind] * count for kind, count in searches.items()))

    @cached_property
    def start_factors(self) -> list[dict[str, float]]:
        """Those of `STARTS` whose values are fitted."""
        keys = {parameter.key for parameter in self.parameters}
        return [wide for wide in STARTS if set(wide) <= keys]

    def usual_trials(self, intervals: bool) -> float:
        """Estimate the trials of a fit from all starts, with intervals or without."""
        starts, ends = len(self.start_factors), 2 * len(self.parameters)
        searches = {"ends": ends, "nearest": 1} if intervals else {}
        return self.expected_trials(starts=starts, again=starts, long=1, **searches)

    @cached_property
    def _models(self) -> Callable[[tuple[float, ...]], Model]:
        """Put the first values, as many as there are: what only later ones change is kept."""

        @lru_cache(maxsize=8 * len(self.parameters))
        def with_first(places: tuple[float, ...]) -> Model:
            if not places:
                return self.model
            parameter = self.parameters[len(places) - 1]
            return parameter.put(with_first(places[:-1]), parameter.value(places[-1]))

        return with_first

    @cached_property
    def _branches(self) -> Callable[[tuple[float, ...], int, float], Branches | None]:
        @lru_cache(maxsize=4 * len(self.loops))
        def branches(places: tuple[float, ...], loop: int, shift: float) -> Branches | None:
            try:
                return model_branches(self._models(places), self.bench, self.loops[loop], shift)
            except RunError:
                return None

        return branches

    def parts(self, places: Array) -> list[Array]:
        """Compute the residuals of each loop's points."""
        count, residuals = len(self.parameters), []
        for number, loop in enumerate(self.loops):
            offset = offset_scales(loop) * places[count + 2 * number : count + 2 * number + 2]
            branches = self._branches(tuple(places[:count].tolist()), number, float(offset[0]))
            failed = np.full(len(loop.torque) - loop.lead, FAILED)
            residuals.append(failed if branches is None else distances(loop, branches, *offset.tolist()))
        return residuals

    def residuals(self, places: Array) -> Array:
        """Join the residuals of all loops, so that each loop counts the same, and those of what is known without them.

        A value that is off by its standard deviation counts as a loop that is missed by `DISCREPANCY`.
        """
        self.trials()
        off = DISCREPANCY * (self.known * (places - self.expected))[self.known > 0.0]
        return np.concatenate([*(part / np.sqrt(len(part)) for part in self.parts(places)), off])

    def misses(self, places: Array, offset: bool) -> Array:
        """Compute by how much the model's turn misses each measured one at its torque, as shares of the loops' heights.

        With each loop's `offset` of torque, or with none, as a scene has it; so that each loop counts the same.
        """
        self.trials()
        count, missed = len(self.parameters), []
        for number, loop in enumerate(self.loops):
            torque, turn = offset_scales(loop) * places[count + 2 * number : count + 2 * number + 2] * [offset, 1.0]
            branches = self._branches(tuple(places[:count].tolist()), number, float(torque))
            if branches is None:
                off = np.full(len(loop.torque), FAILED * loop.height)
            else:
                off = deflections(loop, [(loads + torque, turns) for loads, turns in branches]) - loop.deflection
                off = off + turn if offset else off - np.mean(off[loop.lead :])
            missed.append(off[loop.lead :] / (loop.height * np.sqrt(len(off) - loop.lead)))
        return np.concatenate(missed)

    def slopes(
        self,
        places: Array,
        by: Sequence[int],
        central: bool = False,
        ends: tuple[Array, Array] | None = None,
        of: Callable[[Array], Array] | None = None,
    ) -> Array:
        """Compute slopes of residuals by some places, shape (points, by): forward differences, or central ones.

        The residuals are those of the fit, or `of` some others; the steps stay within the bounds, or narrower `ends`.
        """
        low, high = ends or self.bounds
        residuals, columns = of or self.residuals, []
        for place in by:
            pair = np.stack([places, places])
            pair[1, place] += STEP
            pair[0, place] -= STEP if central else 0.0
            if pair[1, place] > high[place]:
                pair[:, place] = places[place] - STEP, places[place]
            pair[:, place] = np.clip(pair[:, place], low[place], high[place])
            step = pair[1, place] - pair[0, place]
            change = residuals(pair[1]) - residuals(pair[0])
            columns.append(change / step if step else np.zeros_like(change))
        return np.stack(columns, axis=1)

    def starts(self) -> list[Array]:
        """Compute where searches start: by `STARTS`, with the design's own values and the middle of each loop.

        Where stiffness or play is fitted, those that bring the model's loops nearest to the measured ones.
        """
        keys = {parameter.key for parameter in self.parameters}
        shifts = [[0.5 * sum(loop.ends), _centre(loop)] / offset_scales(loop) for loop in self.loops]
        plays = (1.0, 2.0, 0.5, 4.0) if {"mesh_play", "play", "output_play"} & keys else (1.0,)
        softer = (1.0, 0.3, 0.1, 0.03, 0.01, 3.0) if {"tooth_stiffness", "structure_stiffness"} & keys else (1.0,)
        starts = []
        for wide in self.start_factors:
            tried = []
            for play, stiffness in product(plays, softer):
                factors = {"mesh_play": play, "output_play": play, "play": play, "tooth_stiffness": stiffness}
                factors |= {"structure_stiffness": stiffness} | wide
                start = [
                    parameter.place(
                        min(max(parameter.start * factors.get(parameter.key, 1.0), parameter.least), parameter.most)
                    )
                    for parameter in self.parameters
                ]
                places = np.concatenate([start, *shifts])
                self.trials()
                tried.append((sum(float(np.mean(np.abs(part))) for part in self.parts(places)), places))
            starts.append(min(tried, key=itemgetter(0))[1])
        return starts

    def run(
        self, start: Array, steps: int, method: Literal["trf", "dogbox"], held: int | None = None
    ) -> tuple[float, Array]:
        """Search from a start, with the value at one place `held` if it is given; return cost and end."""
        from scipy.optimize import least_squares

        low, high = self.bounds
        start = np.clip(start, low, high)
        free = [place for place in np.flatnonzero(high - low > HELD).tolist() if place != held]

        whole = _filled(start, free)

        def residuals(part: Array) -> Array:
            return self.residuals(whole(part))

        def slopes(part: Array) -> Array:
            return self.slopes(whole(part), free)

        def robust(squares: Array) -> Array:
            """Compute the soft L1 loss of residuals, each by its size as a point of its loop, and two derivatives."""
            root = np.sqrt(1.0 + squares / self.counts)
            return np.stack([2.0 * self.counts * (root - 1.0), 1.0 / root, -0.5 / (self.counts * root**3)])

        loss: Any = robust  # the stubs ask for a protocol with a name of theirs
        solution = least_squares(
            residuals,
            np.clip(start, low + 1e-9, high - 1e-9)[free],
            jac=slopes,
            bounds=(low[free], high[free]),
            method=method,
            loss=loss,
            f_scale=OUTLIER,
            xtol=1e-6,
            ftol=1e-6,
            gtol=1e-9,
            max_nfev=steps,
        )
        return float(solution.cost), np.clip(whole(solution.x), low, high)

    def nearest(self, start: Array, low: Array, high: Array) -> Array:
        """Return the places between two ends at which the model's deflections are nearest to the measured ones, rms.

        A value that moves from the start by a quarter of the distance between its ends, which is its standard
        deviation, adds the cost of a loop that is missed by `DISCREPANCY`, so that a value on which the deflections
        hardly depend stays.
        """
        tied = DISCREPANCY * np.divide(4.0, high - low, out=np.zeros_like(start), where=high - low > HELD)

        def residuals(places: Array) -> Array:
            return np.concatenate([self.misses(places, offset=self.torque_offset), tied * (places - start)])

        return self._least(residuals, start, low, high)[1]

    def _least(self, residuals: Callable[[Array], Array], start: Array, low: Array, high: Array) -> tuple[float, Array]:
        """Search from a start for the least sum of squares between two ends; return it and where it is."""
        from scipy.optimize import least_squares

        start, free = np.clip(start, low, high), np.flatnonzero(high - low > HELD)

        whole = _filled(start, free)

        def of(part: Array) -> Array:
            return residuals(whole(part))

        def slopes(part: Array) -> Array:
            return self.slopes(whole(part), free.tolist(), ends=(low, high), of=residuals)

        solution = least_squares(
            of,
            np.clip(start, low + 1e-9, high - 1e-9)[free],
            jac=slopes,
            bounds=(low[free], high[free]),
            xtol=ENOUGH,
            ftol=ENOUGH,
            max_nfev=LONG,
        )
        return float(solution.cost), whole(solution.x)


def _filled(start: Array, free: Sequence[int] | Integers) -> Callable[[Array], Array]:
    """Return a function that puts values in the free places of a start, and leaves the others there."""

    def whole(part: Array) -> Array:
        places = start.copy()
        places[free] = part
        return places

    return whole


def _weights(loops: Sequence[MeasuredLoop]) -> list[Array]:
    lengths = [len(loop.torque) - loop.lead for loop in loops]
    return [np.full(length, 1.0 / length) for length in lengths]


def _centre(loop: MeasuredLoop) -> float:
    return 0.5 * float(loop.deflection.max() + loop.deflection.min())


def offset_scales(loop: MeasuredLoop) -> Array:
    """Compute the scales of a loop's offsets in torque [N m] and deflection [rad]."""
    return np.array([0.02 * float(np.ptp(loop.torque)), 0.02 * loop.height])
