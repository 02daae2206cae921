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

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import RunError
from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.overlay import Branches, LoopCondition, distances, model_branches
from cycloid_mj.bench.parameters import Model, Parameter

OUTLIER = 0.03
"""Residual, as a share of a loop's range, from which a point counts less and less (soft L1)."""

DISCREPANCY = 0.03
"""What the model itself may miss the loops by, rms, as a share of their ranges: no model of a drive is nearer."""

ZERO_OF_TORQUE = 0.2
"""What a bench's zero of torque may be off by, as a share of the loop's range: standard deviation, assumed, and wide.

Play and such an offset explain a loop of few points beyond its play nearly alike: the smaller offset is the likelier.
"""

FAILED = 1.0
"""Residual of every point where the model has no balance."""

STEP = 0.05
"""Step of differences, on a value's scale."""

SHORT, LONG = 12, 60
"""Most steps of a search from each of the starts, and of the one that goes on from the best of them."""

STARTS: tuple[dict[str, float], ...] = (
    {},
    {"friction": 2.5, "drag": 0.5},
    {"hysteresis": 3.0, "hysteresis_travel": 3.0},
    {"hysteresis": 3.0, "drag": 0.5},
)
"""Where searches start, in factors on what a loop suggests: friction of contacts, or one that comes on little by
little, and constant friction, which make a loop wide, are told apart by little, so that there is a valley between them
in which a single search stops."""


@dataclass(frozen=True, eq=False)
class FitProblem:
    """The residuals of a model, and their slopes, by where all values are on their scales."""

    model: Model
    parameters: tuple[Parameter, ...]
    loops: tuple[MeasuredLoop, ...]
    bench: LoopCondition
    on_step: Callable[[], None]

    @cached_property
    def known(self) -> Array:
        """What is known of each place without the loops: 1 over its standard deviation, 0 where that is nothing."""
        deviations = [parameter.place_deviation for parameter in self.parameters]
        zeros = [ZERO_OF_TORQUE * np.ptp(loop.torque) / offset_scales(loop)[0] for loop in self.loops]
        return 1.0 / np.array([*deviations, *(one for zero in zeros for one in (zero, np.inf))])

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
        """The least and the greatest places."""
        free = np.full(2 * len(self.loops), np.inf)
        low, high = (
            [parameter.place(getattr(parameter, end)) for parameter in self.parameters] for end in ("least", "most")
        )
        return np.concatenate([low, -free]), np.concatenate([high, free])

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
        self.on_step()
        off = DISCREPANCY * (self.known * (places - self.expected))[self.known > 0.0]
        return np.concatenate([*(part / np.sqrt(len(part)) for part in self.parts(places)), off])

    def slopes(self, places: Array, by: Sequence[int], central: bool = False) -> Array:
        """Compute slopes of the residuals by some places, shape (points, by): forward differences, or central ones."""
        low, high = self.bounds
        columns = []
        for place in by:
            ends = np.stack([places, places])
            ends[1, place] += STEP
            ends[0, place] -= STEP if central else 0.0
            if ends[1, place] > high[place]:
                ends[:, place] = places[place] - STEP, places[place]
            ends[:, place] = np.clip(ends[:, place], low[place], high[place])
            step = ends[1, place] - ends[0, place]
            columns.append((self.residuals(ends[1]) - self.residuals(ends[0])) / step)
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
        for wide in STARTS:
            if not set(wide) <= keys:
                continue
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
                tried.append((sum(float(np.mean(np.abs(part))) for part in self.parts(places)), places))
            starts.append(min(tried, key=itemgetter(0))[1])
        return starts

    def run(
        self, start: Array, steps: int, method: Literal["trf", "dogbox"], held: int | None = None
    ) -> tuple[float, Array]:
        """Search from a start, with the value at one place `held` if it is given; return cost and end."""
        from scipy.optimize import least_squares

        low, high = self.bounds
        free = [place for place in range(len(start)) if place != held]

        def whole(part: Array) -> Array:
            places = start.copy()
            places[free] = part
            return places

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


def _weights(loops: Sequence[MeasuredLoop]) -> list[Array]:
    lengths = [len(loop.torque) - loop.lead for loop in loops]
    return [np.full(length, 1.0 / length) for length in lengths]


def _centre(loop: MeasuredLoop) -> float:
    return 0.5 * float(loop.deflection.max() + loop.deflection.min())


def offset_scales(loop: MeasuredLoop) -> Array:
    """Compute the scales of a loop's offsets in torque [N m] and deflection [rad]."""
    return np.array([0.02 * float(np.ptp(loop.torque)), 0.02 * loop.height])
