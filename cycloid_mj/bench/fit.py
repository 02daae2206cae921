"""The least squares of a calibration: loops of a model laid over measured ones, with intervals and correlations.

A point's residual is its distance from the model's own branch, with torque and deflection as shares of their ranges:
where the loop crosses its play a little torque is a large turn, and where it sticks it is none, so that neither alone
would do. Each loop has an offset of its own in torque and in deflection, which are no part of the drive.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.parameters import Model, Parameter
from cycloid_mj.errors import RunError
from cycloid_mj.loaded.sliding import Held, turn_along
from cycloid_mj.types import Array, Mask

GRID, LEAD = 32, 8
"""Torques of a branch of the model, and of each that only leads to the loop."""

OUTLIER = 0.03
"""Residual, as a share of a loop's range, from which a point counts less and less (soft L1)."""

FAILED = 1.0
"""Residual of every point where the model has no balance."""

STEP = 0.02
"""Step of differences, as a share of a parameter's scale."""

STEPS = 30
"""Most steps of the search."""

COVERED = 0.95
LONGEST_MEMORY = 0.25
"""Largest lag over which residuals count as one, as a share of a loop's points."""


@dataclass(frozen=True, eq=False)
class Bench:
    """Under what the loops were taken: what was held, and at which crank angle [rad]."""

    held: Held
    crank: float


@dataclass(frozen=True, eq=False)
class Fitted:
    """A model laid over loops.

    Attributes
    ----------
    model, parameters, bench, loops
        What was fitted to what.
    values
        Of the parameters, then each loop's offsets of torque [N m] and deflection [rad].
    residuals
        Of each loop's points, as shares of its range.
    slopes
        Of all residuals by all values, shape (points, values).
    covariance
        Of the values; of those at a bound, which is no measurement, 0.
    """

    model: Model
    parameters: tuple[Parameter, ...]
    bench: Bench
    loops: tuple[MeasuredLoop, ...]
    values: Array
    residuals: tuple[Array, ...]
    slopes: Array
    covariance: Array
    freedom: float

    @cached_property
    def turns(self) -> tuple[Array, ...]:
        """The model's deflection at every measured point [rad]: that of its branch at the measured torque."""
        count = len(self.parameters)
        model = put_all(self.model, self.parameters, self.values)
        found = []
        for place, loop in enumerate(self.loops):
            shift = self.values[count + 2 * place : count + 2 * place + 2]
            branches = model_branches(model, self.bench, loop, float(shift[0]))
            turn = np.empty(len(loop.torque))
            for number, (torque, deflection) in enumerate(branches):
                here = loop.branch == number
                order = np.argsort(torque)
                turn[here] = np.interp(loop.torque[here], torque[order] + shift[0], deflection[order]) + shift[1]
            found.append(turn)
        return tuple(found)

    @property
    def errors(self) -> Array:
        """Standard errors of the values."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def criterion(self) -> float:
        """Bayes's information criterion, over the residuals that count as independent (`memory`)."""
        total, points = 0.0, 0.0
        for one in self.residuals:
            count = len(one) / memory(one)
            total += count * float(np.log(np.mean(one**2)))
            points += count
        return total + len(self.values) * float(np.log(points))

    def rms(self, place: int) -> float:
        """Give the rms difference of a loop's deflection from the model's at the measured torque [rad]."""
        return float(np.sqrt(np.mean((self.turns[place] - self.loops[place].deflection) ** 2)))


def put_all(model: Model, parameters: Sequence[Parameter], values: Array) -> Model:
    """Give a model with the values of parameters."""
    for parameter, value in zip(parameters, values, strict=False):
        model = parameter.put(model, float(value))
    return model


def model_branches(model: Model, bench: Bench, loop: MeasuredLoop, shift: float = 0.0) -> list[tuple[Array, Array]]:
    """Give torque [N m] and turn [rad] of a model along each branch of a loop, less a `shift` of torque [N m].

    The course before the loop is a loop as large, so that its first branch is that of a loop which closes.

    Raises
    ------
    RunError
        There is no balance.
    """
    ends = [end - shift for end in loop.turns]
    lead = [np.linspace(a, b, LEAD, endpoint=False) for a, b in ((0.0, ends[1]), (ends[1], ends[0]))]
    each = [np.linspace(a, b, GRID) for a, b in pairwise(ends)]
    course = np.concatenate([*lead, *each])
    turn = turn_along(model.design, course, bench.crank, model.losses, bench.held)
    parts = np.split(turn[2 * LEAD :], len(each))
    return list(zip(each, parts, strict=True))


def fit(
    model: Model,
    parameters: Sequence[Parameter],
    loops: Sequence[MeasuredLoop],
    bench: Bench,
    told: Callable[[], None] = lambda: None,
    start: Array | None = None,
) -> Fitted:
    """Fit parameters to loops by robust least squares; `told` is called at each trial.

    Raises
    ------
    RunError
        The model has no balance where the search begins, or where it ends.
    """
    from scipy.optimize import least_squares

    first = _first(model, parameters, loops, bench) if start is None else start
    scale = np.concatenate([[one.scale for one in parameters], *[_scales(loop) for loop in loops]])
    low = np.concatenate([[one.least for one in parameters], np.full(2 * len(loops), -np.inf)])
    high = np.concatenate([[one.most for one in parameters], np.full(2 * len(loops), np.inf)])
    margin = 1e-9 * scale

    def residuals(scaled: Array) -> Array:
        told()
        parts = _residuals(model, parameters, loops, bench, np.clip(scaled * scale, low, high))
        return np.concatenate([part / np.sqrt(len(part)) for part in parts])

    def slopes(scaled: Array) -> Array:
        here, columns = residuals(scaled), []
        for place in range(len(scaled)):
            step = STEP if scaled[place] + STEP < high[place] / scale[place] else -STEP
            moved = scaled.copy()
            moved[place] += step
            columns.append((residuals(moved) - here) / step)
        return np.stack(columns, axis=1)

    found = least_squares(
        residuals,
        np.clip(first, low + margin, high - margin) / scale,
        jac=slopes,
        bounds=(low / scale, high / scale),
        loss="soft_l1",
        f_scale=OUTLIER / np.sqrt(min(len(loop.torque) for loop in loops)),
        xtol=1e-6,
        ftol=1e-6,
        gtol=1e-9,
        max_nfev=STEPS,
    )
    values = np.clip(found.x * scale, low, high)
    parts = _residuals(model, parameters, loops, bench, values)
    if all(np.all(part == FAILED) for part in parts):
        raise RunError("no model of the loop has a static balance near the design: is its friction too large?")
    jacobian = slopes(found.x) / scale
    free = (values > low + 1e-3 * scale) & (values < high - 1e-3 * scale)
    covariance, freedom = _covariance(jacobian, parts, free, scale)
    return Fitted(model, tuple(parameters), bench, tuple(loops), values, tuple(parts), jacobian, covariance, freedom)


def _first(model: Model, parameters: Sequence[Parameter], loops: Sequence[MeasuredLoop], bench: Bench) -> Array:
    """Give where the search begins: the design's own values and the middle of each loop.

    Where its stiffness or its play is fitted, those that bring the model's loops nearest to the height of the measured.
    """
    own = np.array([one.start for one in parameters])
    shifts = np.concatenate([[0.5 * sum(loop.ends), _centre(loop)] for loop in loops])
    best, least = own, np.inf
    places = {one.key: place for place, one in enumerate(parameters)}
    tried = [
        (play, stiffness)
        for play in ((1.0, 2.0, 0.5, 4.0) if {"mesh_play", "play", "output_play"} & set(places) else (1.0,))
        for stiffness in ((1.0, 0.3, 0.1, 0.03, 3.0) if "tooth_stiffness" in places else (1.0,))
    ]
    for play, stiffness in tried:
        trial = own.copy()
        for key, factor in (
            ("mesh_play", play),
            ("output_play", play),
            ("play", play),
            ("tooth_stiffness", stiffness),
        ):
            if key in places:
                trial[places[key]] *= factor
        values = np.concatenate([trial, shifts])
        worst = sum(float(np.mean(np.abs(part))) for part in _residuals(model, parameters, loops, bench, values))
        best, least = (values, worst) if worst < least else (best, least)
    return best if len(best) > len(own) else np.concatenate([own, shifts])


def _centre(loop: MeasuredLoop) -> float:
    return 0.5 * float(loop.deflection.max() + loop.deflection.min())


def _scales(loop: MeasuredLoop) -> Array:
    return np.array([0.02 * float(np.ptp(loop.torque)), 0.02 * loop.height])


def _residuals(
    model: Model, parameters: Sequence[Parameter], loops: Sequence[MeasuredLoop], bench: Bench, values: Array
) -> list[Array]:
    count, changed = len(parameters), put_all(model, parameters, values)
    found = []
    for place, loop in enumerate(loops):
        torque, deflection = values[count + 2 * place : count + 2 * place + 2]
        try:
            branches = model_branches(changed, bench, loop, float(torque))
        except RunError:
            found.append(np.full(len(loop.torque), FAILED))
            continue
        found.append(_distances(loop, branches, float(torque), float(deflection)))
    return found


def _distances(loop: MeasuredLoop, branches: list[tuple[Array, Array]], torque: float, deflection: float) -> Array:
    """Give the signed distance of every point from the model's branch, as shares of the loop's ranges."""
    ranges = float(np.ptp(loop.torque)), loop.height
    found = np.zeros(len(loop.torque))
    for number, (loads, turns) in enumerate(branches):
        here = loop.branch == number
        points = np.stack([loop.torque[here] / ranges[0], loop.deflection[here] / ranges[1]], axis=-1)
        line = np.stack([(loads + torque) / ranges[0], (turns + deflection) / ranges[1]], axis=-1)
        found[here] = _from_line(points, line)
    return found


def _from_line(points: Array, line: Array) -> Array:
    """Give the distance of points (n, 2) from a line through points (m, 2), positive to the right of its way."""
    begin, along = line[:-1], np.diff(line, axis=0)
    square = np.maximum(np.sum(along**2, axis=1), 1e-30)
    way = points[:, np.newaxis] - begin
    share = np.clip(np.sum(way * along, axis=-1) / square, 0.0, 1.0)
    apart = way - share[..., np.newaxis] * along
    distance = np.linalg.norm(apart, axis=-1)
    nearest = np.argmin(distance, axis=1)
    rows = np.arange(len(points))
    beside, direction = apart[rows, nearest], along[nearest]
    cross = direction[:, 0] * beside[:, 1] - direction[:, 1] * beside[:, 0]
    return np.asarray(np.where(cross < 0.0, -1.0, 1.0) * distance[rows, nearest])


def memory(residuals: Array) -> float:
    """Give how many residuals that follow each other count as one: 1 for noise, more for what a model leaves out.

    That is 1 + 2 sum rho_k, up to the first lag k whose correlation rho_k is not above 0 (Geyer's initial sequence).
    """
    centred = residuals - residuals.mean()
    variance = float(np.mean(centred**2))
    total = 1.0
    for lag in range(1, int(LONGEST_MEMORY * len(residuals))):
        correlation = float(np.mean(centred[lag:] * centred[:-lag])) / variance if variance else 0.0
        if correlation <= 2.0 / np.sqrt(len(residuals)):
            break
        total += 2.0 * correlation
    return total


def _covariance(jacobian: Array, parts: Sequence[Array], free: Mask, scale: Array) -> tuple[Array, float]:
    """Give the covariance of the values, and the degrees of freedom behind it.

    Each loop has noise of its own size, and its residuals count as often as `memory` allows. What no residual answers
    to has an infinite error, here one of a million of its scales.
    """
    ends = np.cumsum([len(part) for part in parts])[:-1]
    slopes = np.split(jacobian * scale, ends)
    information = np.sum([rows.T @ rows for rows in slopes], axis=0)
    points = sum(len(part) / memory(part) for part in parts)
    freedom = max(points - int(free.sum()), 1.0)
    noise = np.zeros_like(information)
    for part, rows in zip(parts, slopes, strict=True):
        noise += points / freedom * float(np.mean(part**2)) * memory(part) / len(part) * rows.T @ rows
    inverse = np.zeros_like(information)
    chosen = np.ix_(free, free)
    values, vectors = np.linalg.eigh(information[chosen])
    values = np.maximum(values, 1e-12 * max(float(values.max(initial=0.0)), 1e-300))
    inverse[chosen] = (vectors / values) @ vectors.T
    return inverse @ noise @ inverse * np.outer(scale, scale), freedom
