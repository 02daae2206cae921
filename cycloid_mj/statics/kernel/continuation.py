"""Paths from parts without play and friction to a balance with both, followed by their length."""

import math
from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import cacheable, njit
from cycloid_mj.statics.kernel.contacts import NO, YES, KernelSprings, largest_play, opened_by
from cycloid_mj.statics.kernel.newton import BALANCED, FLOATING, FOLLOWED, clear, copy, largest, newton, solve
from cycloid_mj.statics.kernel.system import RATE, Linearised, assemble, cam_at

_MOST_POINTS, _CORRECTIONS, _WIDEST, _CORNER, _REMOTE = 5000, 8, 0.3, 1e-8, 10.0
"""Of a path that is followed by its length: most points that are tried; most Newton steps to each, and how far they may
lead from where it goes straight on, over the length of the step; the length, in plays, below which there is a corner;
and how often the play and the first give, and an eccentricity, it may lead to: farther on friction jams."""


_BENT, _AROUND = 1e-3, 3.0
"""Length of a step, in plays, at which a path may go round a corner, and how far Newton steps may lead there. A path
that is as near its beginning again is lost in wedged parts, far from where it began."""


class _Path(NamedTuple):
    """A path with a `lag`, and arrays: its points are the u departures over a `unit` [m], and the way [1].

    `point`, `beyond` the next one, `ahead` the direction, of length 1, and `before`; `step`, what is `left` over and
    `end`, all (u + 1,); `room` (n,) [m] and `rate` (u,) [N] at a point; the `matrix` (u + 1, u + 1) of its equations.
    """

    lag: float
    unit: float
    room: Array
    point: Array
    beyond: Array
    ahead: Array
    before: Array
    step: Array
    left: Array
    end: Array
    rate: Array
    matrix: Array


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def by_continuation(
    springs: KernelSprings, k: int, load: Array, here: Array, lag: float, most: float, system: Linearised
) -> float:
    """Solve for the departures `here` (u,) [m] along a path on which friction grows and, with a `lag`, play.

    Without play and friction parts are held by springs that only push, whose energy has one least value, and Newton's
    method finds it downhill. From this only beginning the path cannot come back there: it leads to the whole friction
    and play, or its forces grow until they wedge the parts, where friction jams them. It is followed by its length, by
    Newton's method across it, since it turns back where parts snap over; where a contact opens or closes it has a
    corner, beyond which it goes on in the direction that leaves the sign of its determinant (Allgower and Georg,
    Numerical Continuation Methods, 1990, chapters 2 and 12).

    Returns
    -------
    What is left over of the load [N]; infinity where the path was lost, or wedges the parts.
    """
    number, last, path = here.size, 1.0 + abs(lag), new_path(springs, here.size, lag)
    point, beyond, allowed = path.point, path.beyond, FOLLOWED / BALANCED * most
    newton(opened_by(springs, 0.0, path.room), k, load, here, 1.0, 0.0, YES, most, 0.0, NO, YES, system)
    for j in range(number):
        point[j] = here[j] / path.unit
    path.ahead[number] = path.end[number] = 1.0
    left, length = along(springs, k, load, point, path, system), 0.5
    sign = _direct(springs, k, load, point, 1.0, path, system)
    for j in range(number + 1):
        path.ahead[j] *= sign
    farthest = _REMOTE * (1.0 + largest(point)) + springs.trochoid[1] / path.unit
    for _ in range(_MOST_POINTS if left <= allowed else 0):
        if not _step_on(springs, k, load, length, sign, allowed, path, system):
            length *= 0.5
            if length > _CORNER:
                continue
            length = _corner(springs, k, load, sign, allowed, path, system)
            if length == 0.0:
                break
        if beyond[number] >= last:
            share = (last - point[number]) / (beyond[number] - point[number])
            for j in range(number):
                here[j] = (point[j] + share * (beyond[j] - point[j])) * path.unit
            left = newton(springs, k, load, here, 1.0, 1.0, YES, most, 0.0, NO, NO, system)
            if left <= most:
                return left
            copy(path.before, path.ahead)
            length *= 0.5
            continue
        copy(beyond, point)
        if largest(point) > farthest or (point[number] < _BENT and path.ahead[number] < 0.0):
            break
        length *= 2.0
    return math.inf


@njit(nogil=True, error_model="numpy", inline="always")
def _shares(lag: float, way: float) -> tuple[float, float]:
    """Compute the shares of friction and of play at a `way` along a path; beyond its end they go on growing."""
    if lag == 0.0:
        return way, way
    first, second = min(way, 1.0), max(way - 1.0, 0.0)
    return (first, second) if lag > 0.0 else (second, first)


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def new_path(springs: KernelSprings, number: int, lag: float) -> _Path:
    """Make room for a path of so many departures."""
    return _Path(
        lag,
        largest_play(springs),
        np.zeros(springs.disc.size),
        np.zeros(number + 1),
        np.zeros(number + 1),
        np.zeros(number + 1),
        np.zeros(number + 1),
        np.zeros(number + 1),
        np.zeros(number + 1),
        np.zeros(number + 1),
        np.zeros(number),
        np.zeros((number + 1, number + 1)),
    )


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def along(springs: KernelSprings, k: int, load: Array, point: Array, path: _Path, system: Linearised) -> float:
    """Put together what is left of the load at a point of the path, and how it falls with the point; [N]."""
    number, matrix, residual, here = load.size, path.matrix, system.residual, system.back
    for j in range(number):
        here[j] = point[j] * path.unit
    way, rate, lag = point[number], path.rate, path.lag
    friction, play = _shares(lag, way)
    opened, rubs = opened_by(springs, play, path.room), (way < 1.0) == (lag > 0.0)
    if lag == 0.0 or rubs:
        assemble(opened, k, load, here, 1.0, friction + 1.0, YES, YES, system)
        for j in range(number):
            path.left[j] = residual[j]
    assemble(opened, k, load, here, 1.0, friction, YES, YES, system)
    clear(rate)
    if lag == 0.0 or rubs:
        for j in range(number):
            rate[j] = path.left[j] - residual[j]
    if lag == 0.0 or not rubs:
        _give(springs, opened, k, here, friction, rate, system)
    for j in range(number):
        path.left[j] = residual[j]
        for m in range(number):
            matrix[j, m] = system.tangent[j, m] * path.unit
        matrix[j, j] += FLOATING * springs.cam_stiffness * path.unit
        matrix[j, number] = -path.rate[j]
    return largest(residual)


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _give(
    springs: KernelSprings, opened: KernelSprings, k: int, here: Array, friction: float, rate: Array, system: Linearised
) -> None:
    """Add how the springs' forces change as their play opens to a `rate` [N], shape (u,), at departures (u,) [m]."""
    number, rubbed = here.size, springs.rubbing.shape[0] > 0
    for i in range(springs.disc.size):
        if system.pressed[i] == 0.0:
            continue
        for a in range(4):
            to = 3 * springs.disc[i] + a if a < 3 else number - 1
            rubs = friction * springs.rubbing[k, i, to] if rubbed else 0.0
            rate[to] -= system.row[i, RATE] * springs.room[i] * (system.row[i, a] + rubs)
    for disc in range(springs.cam_place.shape[1]):
        cam = cam_at(opened, k, disc, here)
        if cam.both > 0.0 and springs.cam_clearance > 0.0:
            falls = springs.cam_stiffness * springs.cam_clearance
            rate[3 * disc] += falls * cam.u
            rate[3 * disc + 1] += falls * cam.v
            rate[3 * disc + 2] -= friction * springs.cam_rubbing * falls if rubbed else 0.0


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _direct(
    springs: KernelSprings, k: int, load: Array, point: Array, sign: float, path: _Path, system: Linearised
) -> float:
    """Turn the path's direction to that at a `point`, whose determinant has a `sign`; give the sign it had before."""
    last = load.size
    along(springs, k, load, point, path, system)
    copy(path.ahead, path.matrix[last])
    found = solve(path.matrix, path.end, path.step, 0.0)
    size = 0.0
    for j in range(last + 1):
        size += path.step[j] * path.step[j]
    size = math.sqrt(size)
    if found != 0.0 and size < math.inf:
        for j in range(last + 1):
            path.ahead[j] = path.step[j] * (found * sign / size)
    return found


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _step_on(
    springs: KernelSprings,
    k: int,
    load: Array,
    length: float,
    sign: float,
    allowed: float,
    path: _Path,
    system: Linearised,
) -> bool:
    """Find the path's point a `length` ahead and its direction there; tell whether it goes on that way, as it must."""
    copy(path.ahead, path.before)
    if not _across(springs, k, load, length, allowed, path, system):
        return False
    found, onward = _direct(springs, k, load, path.beyond, sign, path, system), 0.0
    for j in range(load.size + 1):
        onward += path.ahead[j] * (path.beyond[j] - path.point[j])
    if found == 0.0 or not onward > 0.0:
        copy(path.before, path.ahead)
        return False
    return True


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _across(
    springs: KernelSprings, k: int, load: Array, length: float, allowed: float, path: _Path, system: Linearised
) -> bool:
    """Look for the path's point a `length` ahead by Newton's method across its direction; tell whether it is found."""
    last, point, beyond, ahead, left = load.size, path.point, path.beyond, path.ahead, path.left
    widest = _WIDEST if length > _BENT else _AROUND
    for j in range(last + 1):
        beyond[j] = point[j] + length * ahead[j]
    for _ in range(_CORRECTIONS):
        found = along(springs, k, load, beyond, path, system)
        if found <= allowed:
            return True
        copy(ahead, path.matrix[last])
        left[last] = length
        for j in range(last + 1):
            left[last] -= ahead[j] * (beyond[j] - point[j])
        if solve(path.matrix, left, path.step, 0.0) == 0.0:
            return False
        gone = 0.0
        for j in range(last + 1):
            beyond[j] += path.step[j]
            gone += (beyond[j] - point[j] - length * ahead[j]) ** 2
        if not gone < (widest * length) ** 2:
            return False
    return False


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _corner(
    springs: KernelSprings, k: int, load: Array, sign: float, allowed: float, path: _Path, system: Linearised
) -> float:
    """Find a point of the path beyond a corner, where it may turn back; give how far it is [1], 0 if there is none."""
    last = load.size
    until = path.ahead.copy()
    for power in range(-7, -2):
        for j in range(last + 1):
            path.beyond[j] = path.point[j] + 10.0**power * until[j]
        if _direct(springs, k, load, path.beyond, sign, path, system) != 0.0:
            for shorter in range(2, 7):
                if _step_on(springs, k, load, 10.0**-shorter, sign, allowed, path, system):
                    return 10.0**-shorter
        copy(until, path.ahead)
    return 0.0
