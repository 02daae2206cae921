"""The static balance of springs that only push, compiled: one small Newton iteration for each crank angle.

Every spring is a gap from ``reducer.gaps``, round by its `bend`; the cams are circles in circles. The energy of the
springs less the work of the load is convex up to the turning of the gaps, and of springs so soft that all press it has
one least value. Newton's method finds it downhill, and follows it while the springs are hardened and friction, which
goes with their forces, is brought on. Angles follow each other along the turn: each starts from the balances before it,
and where Newton's method gets from there to its own no path is needed.

A path with friction that remembers which way it slid is followed in steps, each a balance by Newton's method on springs
and friction at once, or else with friction's limits held and renewed.

All is in one file: numba does not see when code that it has kept calls other code that has changed.
"""

import math
from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array, Integers, Mask
from cycloid_mj.base.compiling import cacheable, njit

BALANCED = 1e-8
"""Largest residual of a balance, as a share of the largest load."""

FLOATING = 1e-9
"""Stiffness that keeps floating parts where they are, as a share of the cam's."""

CARRIES = 0.01
"""A tooth carries where its force is at least this share of the largest over the turn."""

FIGURES = 9
"""Numbers of a sample: of gear and output the mean turn and its range; peaks of a tooth, an output pin, the cam; teeth
that carry on average; what no balance was found for."""

_VALLEY, _BOTTOM = 1e-3, 0.5
"""Twist of a curve, over the square of its largest curvature, from which it counts as a valley, which is no circle; and
curvature, over the largest, from which it is a valley's bottom, where there is no twist."""

_FAR, _SMALL = 0.7, 4e-4
"""Way along a curve, over its least radius and over E, beyond which its foot point is looked for."""

_FARTHEST_FOOT, _LONGEST = 1.5, 0.5
"""How far from its contact the search for a foot point begins, at most, and its longest step, in the generating
circle's turn N t [rad]: within the half lobe, 1.57, next to which another flank begins, and a third of that."""

_ROUNDS, _SETTLED = 60, 1e-12
"""Most steps to a foot point, as halvings of a lobe down to rounding need them, and the step at which it is found
[rad]: convergence is quadratic, so that the foot is then known to rounding."""

_SURELY = 1e-4
"""Most that a gap's third order narrows it, as a share of the way along the curve."""

FOLLOWED = 1e-6
"""Largest residual of a step along a path, as a share of the path's largest load."""

FINEST = 1024
"""Most parts of a step along a path in which the output leaps."""

_LEAPS, _RENEWALS, _SHORTEST = 12, 40, 1.0 / 16.0
"""Newton steps that a step along a path is given before the slower search, rounds of that, and its least share."""

_MOST_WORK, _MOST_SETTLING = 150, 2000
"""How often a system may be put together, for each step of a path on average, and in one slow search."""

_NEAR = 0.5
"""Longest step along a path, as a share of the least radius of a contact's curve."""

_HALVINGS = 20

_SHORT = 3
"""How often a system is put together in a short search."""

_STEPS, _STEPS_DOWN, _FARTHEST = 15, 200, 0.3
"""Most Newton steps with friction, and downhill without; the longest as a share of the eccentricity."""

_ARMIJO, _SOFT = 0.01, 1e-6
"""Share of the fall that the slope promises which a step downhill must bring, and least stiffness that it reckons with,
as a share of the cam's."""

_TRIES = (
    (10.0, 1.0, False),
    (1.0, 0.125, False),
    (10.0, 0.03, False),
    (10.0, 0.06, True),
)
"""Paths that are tried one after the other: how many plays deep soft springs are pressed, the longest step as a share
of the way, and whether springs are hardened before friction is brought on."""

_EXACTLY, _DAMPED, _LEAST = 2, 0.1, 1e-4
"""The path from which the foot point of every tooth is looked for; stiffness that damps Newton's steps until all
friction is borne, as a share of the cam's for the share of the load that is left over; the least step of a path."""

_LAGS = (1.0, -1.0, 0.0)
"""By how much play comes after friction on the paths that are followed one after the other, until one leads to a
balance, as a share of the way of each. Where two branches nearly meet a step may change over from one to the other."""

_OPENINGS = 32
"""Steps in which play opens where a path without friction is lost: downhill, from one least energy to the next."""

_MOST_POINTS, _CORRECTIONS, _WIDEST, _CORNER, _REMOTE = 5000, 8, 0.3, 1e-8, 10.0
"""Of a path that is followed by its length: most points that are tried; most Newton steps to each, and how far they may
lead from where it goes straight on, over the length of the step; the length, in plays, below which there is a corner;
and how often the play and the first give, and an eccentricity, it may lead to: farther on friction jams."""

_BENT, _AROUND = 1e-3, 3.0
"""Length of a step, in plays, at which a path may go round a corner, and how far Newton steps may lead there. A path
that is as near its beginning again is lost in wedged parts, far from where it began."""

_WEDGED, _DEEP = 100.0, 100.0
"""Force on a cam over the load, and its depth in plays, beyond which parts are wedged: friction holds what nothing has
pressed together."""

_RATE = 4
"""Column of a contact's stiffness, after those of its gradient."""

_ROUNDING = 1e-12
"""By how much energy [1] may seem to grow: next to the balance it is flat, and its differences are rounding."""


_YES: bool = np.bool_(True)  # type: ignore[assignment]
_NO: bool = np.bool_(False)  # type: ignore[assignment]
_FIRST: int = np.int64(0)  # type: ignore[assignment]
"""Arguments: for a literal, Python's own, numba would compile what is called once more."""


class KernelSprings(NamedTuple):
    """Springs at k crank angles, n at each, on the unknowns of D discs and an output, u = 3 D + 1.

    For the meaning of most of them see ``gaps.Gaps``; `room` [m] has the play of the pins in it. Shapes: `room` (n,)
    [m]; `distance`, `shift`, `bend`, `twist`, `phase`, `stiffness` (k, n) [m, m, 1/m, 1/m2, rad, N/m]; `slope`,
    `shift_slope` (k, n, u) [1].

    `radius` [m] is that of the circle of output pins: an unknown of turning is the angle times that. `trochoid`, on
    which ideal pins have their centres, is E u(t) - c u(N t): E and c [m], and N. `disc` (n,) is that of a contact, and
    `turning` (n,) tells whether its curve turns with the disc: the teeth do, round holes need not. `cam_place`
    (k, D, 2) [m], `cam_clearance` [m] and `cam_stiffness` [N/m] are those of the cams; a cam of negative clearance
    presses on both sides. `rubbing` (k, n, u) and `cam_rubbing` [1] are the generalised friction per normal force, of
    the cam on its disc's turn; k is 0 in `rubbing` without friction.

    `bending` (D, D) [m/N] is by how much an output pin that carries several discs gives way to each along its own push,
    for the force of each: off the diagonal alone, which is in `stiffness`. Its size is 0 where no disc's force moves
    another's contact; else the last D `pins` contacts are those of the output pins, disc after disc.
    """

    radius: float
    disc: Integers
    turning: Mask
    room: Array
    distance: Array
    slope: Array
    shift: Array
    shift_slope: Array
    bend: Array
    twist: Array
    phase: Array
    trochoid: tuple[float, float, float]
    stiffness: Array
    cam_place: Array
    cam_clearance: float
    cam_stiffness: float
    rubbing: Array
    cam_rubbing: float
    bending: Array
    pins: int


class Curved(NamedTuple):
    """A gap at some departures: its `width` [m] and derivatives by x, y and turn of its disc and turn of the output.

    `ahead` is the gradient [1], `aside` the rate at which the contact moves along the surface, `rate` [1/m] how fast
    the normal turns with that.
    """

    width: float
    ahead: tuple[float, float, float, float]
    aside: tuple[float, float, float, float]
    rate: float


class Left(NamedTuple):
    """How far a search got: the `force` left over as a share of the largest load, and of the `friction` what it bore.

    The latter is 1 where there is a balance; less where friction jams the parts. `work` counts how often the system was
    put together on the way.
    """

    force: float
    friction: float
    work: int


class State(NamedTuple):
    """Springs at some departures: `energy` less the work of the load [J] and forces left over (u,) [N], its descent.

    `stiffness` (u, u) [N/m] is the second derivative of that energy.
    """

    energy: float
    residual: Array
    stiffness: Array


class Effects(NamedTuple):
    """How far the curves of a contact are moved by errors of the parts, per error [1], [1], [1], [m/rad].

    `distance` and `shift`, shape (k, n, 4), as in ``kernel.KernelSprings``: by the place of its pin or hole in x and y,
    the gear's pin circle, and the turn of its flanks. `cam_place` (k, D, 2) [1] is that of the cams by the
    eccentricity, `turned` (k, 2) cosine and sine of the crank angle. `waves` (k, n, w) [1] is that of `distance` by the
    waves of the gear's profile.
    """

    distance: Array
    shift: Array
    cam_place: Array
    turned: Array
    waves: Array


class SampleDeviations(NamedTuple):
    """How s samples were made: `room` (s, n) and `place` (s, n, 2) of each contact [m], and that of cams (s, D, 2).

    `waves` (s, w) [m] are those of the profile. The rest has the shape (s,): `pin_circle` [m], `rotation` [rad],
    `eccentricity` [m], and the `cam`'s clearance [m].
    """

    room: Array
    place: Array
    waves: Array
    cam_place: Array
    pin_circle: Array
    rotation: Array
    eccentricity: Array
    cam: Array


class _System(NamedTuple):
    """Generalised forces left over [N], shape (u,), and the springs' stiffness [N/m], shape (u, u).

    `pressed` (n,) [N] are the forces of the springs. The rest are arrays of the search: the Newton `step` and where it
    is from, `start` (u,), `ahead` (4,) [1], and `assembled` (1,), how often the system was put together.
    """

    residual: Array
    tangent: Array
    pressed: Array
    step: Array
    start: Array
    back: Array
    row: Array
    kept: Mask
    assembled: Integers


class _Path(NamedTuple):
    """The path of `_open` with a `lag`, and arrays: its points are the u departures over a `unit` [m], and the way [1].

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


class _Pose(NamedTuple):
    """Departures of a disc in x and y, by its turn and by the output's [m], and both turns, phi and psi [rad]."""

    x: float
    y: float
    t: float
    o: float
    phi: float
    psi: float


class _Cam(NamedTuple):
    """Where a disc is from its cam: which way (u, v) [1], and how deep it presses, less what the far side presses [m].

    Force and stiffness of the cam go with that `depth`, with its rates along that way, `along`, and across, `around`
    [1]; the `energy` [m2] too, and friction with what both sides press, `both` [m].
    """

    u: float
    v: float
    depth: float
    along: float
    around: float
    energy: float
    both: float


class _Apart(NamedTuple):
    """How far two curves are apart at their ideal contact [m]: across it, q, and along it, p.

    `arm_q` and `arm_p` [m] are that of what turns with the disc: of a curve that turns, less its turn's second order;
    of a round hole's middle, as it is made.
    """

    q: float
    p: float
    arm_q: float
    arm_p: float


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def balance(springs: KernelSprings, load: Array, z: Array, force: Array, follow: bool) -> Left:
    """Solve for the departures z (k, u) [m] at every crank angle under a load (k, u) [N], and the springs' forces.

    z and force (k, n) [N] are filled in. Each row of z is where its search starts. With `follow`, the first row is; the
    others start where the balances before them lead.

    Returns
    -------
    The worst of all angles, and their work together: where its force is above ``BALANCED``, no balance was found, and
    that angle is the last.
    """
    count, number = load.shape
    system = _system(springs)
    start, near, left = np.zeros(number), False, Left(0.0, 1.0, 0)
    worst = 0.0
    for k in range(count):
        here = z[k]
        _copy(here, start)
        if follow and k:
            _lead(z, k, near)
        begun = system.assembled[0]
        keep = follow and k > 0 and not near
        left = _search(springs, k, load[k], here, start, keep, system)
        near = system.assembled[0] - begun <= _SHORT
        _copy(system.pressed, force[k])
        worst = max(worst, left.force)
        if not left.force <= BALANCED:
            break
    return Left(worst, left.friction, system.assembled[0])


@njit(nogil=True, error_model="numpy", inline="always")
def _lead(z: Array, k: int, near: bool) -> None:
    """Put the departures at an angle where those before lead: to the second order, where the search was short."""
    for j in range(z.shape[1]):
        z[k, j] = 2.0 * z[k - 1, j] - z[k - 2, j] if k > 1 else z[k - 1, j]
        if near and k > 2:
            z[k, j] += z[k - 1, j] - 2.0 * z[k - 2, j] + z[k - 3, j]


@njit(nogil=True, error_model="numpy", inline="always")
def _search(
    springs: KernelSprings, k: int, load: Array, here: Array, start: Array, keep: bool, system: _System
) -> Left:
    """Solve for the departures `here` (u,) [m] by Newton's method from where they are; else along a path.

    Springs so soft that they press in spite of all play have one energy without ridges, whose least Newton's method
    finds from a `start`. From there friction is brought on and the springs are hardened, in steps that are halved until
    Newton's method, with friction and springs at once, gets to the end of each. Where that path has an end, as where
    parts snap over, the springs are hardened first, downhill all the way, and friction is brought on then. Where all
    of these end, the paths of `_open` are followed by their length, one where another is lost.

    For `keep` see `_newton`.
    """
    scale, rubbed = _largest(load) or 1.0, springs.rubbing.shape[0] > 0
    softest, friction, soft, way, further, stride, boldest, borne = 1.0, 1.0, 1.0, 2.0, 2.0, 0.0, 0.0, 0.0
    attempt, downhill, left, most = -1, _NO, 0.0, BALANCED * scale
    while True:
        damping = _DAMPED / scale if attempt >= 0 and friction < 1.0 else 0.0
        exact = attempt >= _EXACTLY
        left = _newton(springs, k, load, here, soft, friction, exact, most, damping, keep, downhill, system)
        keep = _NO
        if rubbed and soft == 1.0 and friction == 1.0 and _wedged(springs, k, here, scale):
            left = math.inf
        if left <= most:
            if soft == 1.0 and friction == 1.0:
                borne = 1.0
                break
            if soft == 1.0:
                borne = max(borne, friction)
            way, stride = (further, min(2.0 * stride, boldest)) if further > 0.0 else (0.0, boldest)
            _copy(here, system.back)
        else:
            stride *= 0.5
            _copy(system.back, here)
        if not stride >= _LEAST:
            attempt += 1
            if attempt == len(_TRIES):
                break
            _copy(start, here)
            _copy(start, system.back)
            further, stride, way = 0.0, 0.0, 0.0
            softest = min(1.0, scale / (_hardest(springs, k) * _depth(springs, _TRIES[attempt][0])))
        else:
            further = min(way + stride, 1.0 if way < 1.0 else 2.0)
        _, boldest, hardens_first = _TRIES[attempt]
        if not rubbed and not hardens_first and 0.0 < further <= 1.0:
            further = min(1.0 + stride, 2.0)
        first, last = min(further, 1.0), max(further - 1.0, 0.0)
        friction, hardened = (last, first) if hardens_first else (first, last)
        soft, downhill = softest ** (1.0 - hardened), further == 0.0 or (hardens_first and friction == 0.0)
    for lag in _LAGS:
        if borne == 1.0:
            break
        _copy(start, here)
        left, carried = _open(springs, k, load, here, lag if rubbed else 0.0, most, system)
        if rubbed and left <= most and _wedged(springs, k, here, scale):
            left, carried = math.inf, borne
        borne = max(borne, carried)
        if not rubbed:
            break
    for step in range(_OPENINGS + 1 if left > most and not rubbed else 0):
        opened = _opened(springs, step / _OPENINGS, system.row[:, 0].copy())
        left = _newton(opened, k, load, here, 1.0, 0.0, _YES, most, 0.0, _NO, _YES, system)
    return Left(left / scale, borne if rubbed else 1.0, 0)


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _open(
    springs: KernelSprings, k: int, load: Array, here: Array, lag: float, most: float, system: _System
) -> tuple[float, float]:
    """Solve for the departures `here` (u,) [m] along a path on which friction grows and, with a `lag`, play.

    Without play and friction parts are held by springs that only push, whose energy has one least value, and Newton's
    method finds it downhill. From this only beginning the path cannot come back there: it leads to the whole friction
    and play, or its forces grow until they wedge the parts, where friction jams them. It is followed by its length, by
    Newton's method across it, since it turns back where parts snap over; where a contact opens or closes it has a
    corner, beyond which it goes on in the direction that leaves the sign of its determinant (Allgower and Georg,
    Numerical Continuation Methods, 1990, chapters 2 and 12).

    Returns
    -------
    What is left over of the load [N]; and the greatest share of friction that was borne with the whole play [1].
    """
    number, last, path = here.size, 1.0 + abs(lag), _path(springs, here.size, lag)
    point, beyond, allowed, borne = path.point, path.beyond, FOLLOWED / BALANCED * most, 0.0
    _newton(_opened(springs, 0.0, path.room), k, load, here, 1.0, 0.0, _YES, most, 0.0, _NO, _YES, system)
    for j in range(number):
        point[j] = here[j] / path.unit
    path.ahead[number] = path.end[number] = 1.0
    left, length = _along(springs, k, load, point, path, system), 0.5
    sign = _direct(springs, k, load, point, 1.0, path, system)
    for j in range(number + 1):
        path.ahead[j] *= sign
    farthest = _REMOTE * (1.0 + _largest(point)) + springs.trochoid[1] / path.unit
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
            left = _newton(springs, k, load, here, 1.0, 1.0, _YES, most, 0.0, _NO, _NO, system)
            if left <= most:
                return left, 1.0
            _copy(path.before, path.ahead)
            length *= 0.5
            continue
        _copy(beyond, point)
        friction, play = _shares(lag, point[number])
        if play >= 1.0:
            borne = max(borne, friction)
        if _largest(point) > farthest or (point[number] < _BENT and path.ahead[number] < 0.0):
            break
        length *= 2.0
    return math.inf, borne


@njit(nogil=True, error_model="numpy", inline="always")
def _shares(lag: float, way: float) -> tuple[float, float]:
    """Compute the shares of friction and of play at a `way` along a path; beyond its end they go on growing."""
    if lag == 0.0:
        return way, way
    first, second = min(way, 1.0), max(way - 1.0, 0.0)
    return (first, second) if lag > 0.0 else (second, first)


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _path(springs: KernelSprings, number: int, lag: float) -> _Path:
    return _Path(
        lag,
        _play(springs),
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
def _opened(springs: KernelSprings, share: float, room: Array) -> KernelSprings:
    """Return springs with a share of their play; its contacts' is written into `room` (n,) [m]."""
    for i in range(room.size):
        room[i] = share * springs.room[i]
    return KernelSprings(
        springs.radius,
        springs.disc,
        springs.turning,
        room,
        springs.distance,
        springs.slope,
        springs.shift,
        springs.shift_slope,
        springs.bend,
        springs.twist,
        springs.phase,
        springs.trochoid,
        springs.stiffness,
        springs.cam_place,
        springs.cam_clearance * (share if springs.cam_clearance > 0.0 else 1.0),
        springs.cam_stiffness,
        springs.rubbing,
        springs.cam_rubbing,
        springs.bending,
        springs.pins,
    )


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _along(springs: KernelSprings, k: int, load: Array, point: Array, path: _Path, system: _System) -> float:
    """Put together what is left of the load at a point of the path of `_open`, and how it falls with the point; [N]."""
    number, matrix, residual, here = load.size, path.matrix, system.residual, system.back
    for j in range(number):
        here[j] = point[j] * path.unit
    way, rate, lag = point[number], path.rate, path.lag
    friction, play = _shares(lag, way)
    opened, rubs = _opened(springs, play, path.room), (way < 1.0) == (lag > 0.0)
    if lag == 0.0 or rubs:
        _assemble(opened, k, load, here, 1.0, friction + 1.0, _YES, system)
        for j in range(number):
            path.left[j] = residual[j]
    _assemble(opened, k, load, here, 1.0, friction, _YES, system)
    _clear(rate)
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
    return _largest(residual)


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _give(
    springs: KernelSprings, opened: KernelSprings, k: int, here: Array, friction: float, rate: Array, system: _System
) -> None:
    """Add how the springs' forces change as their play opens to a `rate` [N], shape (u,), at departures (u,) [m]."""
    number, rubbed = here.size, springs.rubbing.shape[0] > 0
    for i in range(springs.disc.size):
        if system.pressed[i] == 0.0:
            continue
        for a in range(4):
            to = 3 * springs.disc[i] + a if a < 3 else number - 1
            rubs = friction * springs.rubbing[k, i, to] if rubbed else 0.0
            rate[to] -= system.row[i, _RATE] * springs.room[i] * (system.row[i, a] + rubs)
    for disc in range(springs.cam_place.shape[1]):
        cam = _cam(opened, k, disc, here)
        if cam.both > 0.0 and springs.cam_clearance > 0.0:
            falls = springs.cam_stiffness * springs.cam_clearance
            rate[3 * disc] += falls * cam.u
            rate[3 * disc + 1] += falls * cam.v
            rate[3 * disc + 2] -= friction * springs.cam_rubbing * falls if rubbed else 0.0


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _direct(
    springs: KernelSprings, k: int, load: Array, point: Array, sign: float, path: _Path, system: _System
) -> float:
    """Turn the path's direction to that at a `point`, whose determinant has a `sign`; give the sign it had before."""
    last = load.size
    _along(springs, k, load, point, path, system)
    _copy(path.ahead, path.matrix[last])
    found = _solve(path.matrix, path.end, path.step, 0.0)
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
    system: _System,
) -> bool:
    """Find the path's point a `length` ahead and its direction there; tell whether it goes on that way, as it must."""
    _copy(path.ahead, path.before)
    if not _across(springs, k, load, length, allowed, path, system):
        return False
    found, onward = _direct(springs, k, load, path.beyond, sign, path, system), 0.0
    for j in range(load.size + 1):
        onward += path.ahead[j] * (path.beyond[j] - path.point[j])
    if found == 0.0 or not onward > 0.0:
        _copy(path.before, path.ahead)
        return False
    return True


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _across(
    springs: KernelSprings, k: int, load: Array, length: float, allowed: float, path: _Path, system: _System
) -> bool:
    """Look for the path's point a `length` ahead by Newton's method across its direction; tell whether it is found."""
    last, point, beyond, ahead, left = load.size, path.point, path.beyond, path.ahead, path.left
    widest = _WIDEST if length > _BENT else _AROUND
    for j in range(last + 1):
        beyond[j] = point[j] + length * ahead[j]
    for _ in range(_CORRECTIONS):
        found = _along(springs, k, load, beyond, path, system)
        if found <= allowed:
            return True
        _copy(ahead, path.matrix[last])
        left[last] = length
        for j in range(last + 1):
            left[last] -= ahead[j] * (beyond[j] - point[j])
        if _solve(path.matrix, left, path.step, 0.0) == 0.0:
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
    springs: KernelSprings, k: int, load: Array, sign: float, allowed: float, path: _Path, system: _System
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
        _copy(until, path.ahead)
    return 0.0


@njit(nogil=True, error_model="numpy", inline="always")
def _depth(springs: KernelSprings, plays: float) -> float:
    """Compute how deep soft springs are pressed [m]: several plays, but well within the reach of the curves."""
    return min(plays * _play(springs), 0.1 * springs.trochoid[1])


@njit(nogil=True, error_model="numpy", inline="always")
def _hardest(springs: KernelSprings, k: int) -> float:
    """Compute the largest stiffness of all contacts and cams [N/m]."""
    hardest = springs.cam_stiffness
    for i in range(springs.disc.size):
        hardest = max(hardest, springs.stiffness[k, i])
    return hardest


@njit(nogil=True, error_model="numpy", inline="always")
def _wedged(springs: KernelSprings, k: int, here: Array, load: float) -> bool:
    """Tell whether at departures (u,) [m] a cam is pressed as no load [N] presses it: friction holds it so."""
    deepest = max(_DEEP * _play(springs), _WEDGED * load / springs.cam_stiffness)
    for disc in range(springs.cam_place.shape[1]):
        x = here[3 * disc] - springs.cam_place[k, disc, 0]
        y = here[3 * disc + 1] - springs.cam_place[k, disc, 1]
        if x * x + y * y > deepest * deepest:
            return True
    return False


@njit(nogil=True, error_model="numpy", inline="always")
def _play(springs: KernelSprings) -> float:
    """Compute the largest play of all contacts and cams [m]."""
    play = max(abs(springs.cam_clearance), 1e-6)
    for i in range(springs.disc.size):
        play = max(play, springs.room[i])
    return play


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _newton(
    springs: KernelSprings,
    k: int,
    load: Array,
    here: Array,
    soft: float,
    friction: float,
    exact: bool,
    allowed: float,
    damping: float,
    keep: bool,
    downhill: bool,
    system: _System,
) -> float:
    """Solve for the departures `here` (u,) [m] by Newton's method, from where they are; give what is left over [N].

    Of springs that are `soft` and a share of the friction, see `_assemble`. With `keep`, contacts that pressed before
    count as closed in the first step. `downhill`, without friction, steps are shortened until the energy falls.
    """
    hard, longest = soft * springs.cam_stiffness, _FARTHEST * springs.trochoid[1]
    residual, step, start, number = system.residual, system.step, system.start, here.size
    left, energy, share, falls = math.inf, math.inf, 1.0, 0.0
    for i in range(system.kept.size):
        system.kept[i] = keep and system.pressed[i] > 0.0
    for _ in range(_STEPS_DOWN if downhill else _STEPS):
        found = _assemble(springs, k, load, here, soft, friction, exact, system)
        left = _largest(residual)
        if not left < math.inf:
            break
        if downhill and found > energy - _ARMIJO * share * falls + _ROUNDING * abs(energy) and share > _ROUNDING:
            share *= 0.5
        else:
            if left <= allowed and not keep:
                return left
            energy = found
            if downhill:
                _roll_off(system.tangent, residual, step, _SOFT * hard)
            elif _solve(system.tangent, residual, step, FLOATING * hard + damping * left * hard) == 0.0:
                break
            share, falls = min(1.0, longest / max(_largest(step), 1e-300)), 0.0
            for j in range(number):
                start[j] = here[j]
                falls += step[j] * residual[j]
        for j in range(number):
            here[j] = start[j] + share * step[j]
        for i in range(system.kept.size if keep else 0):
            system.kept[i] = False
        keep = _NO
    return left


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _copy(values: Array, to: Array) -> None:
    """Put values (m,) into an array: numba takes a second to compile this as an assignment, for its message alone."""
    for j in range(to.size):
        to[j] = values[j]


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _clear(values: Array) -> None:
    for j in range(values.size):
        values[j] = 0.0


@njit(nogil=True, error_model="numpy", inline="always")
def balance_along(springs: KernelSprings, load: Array, z: Array, force: Array) -> Left:
    """Balance crank angles that follow each other closely: `balance`, with every disc where its cam is at first."""
    for k in range(len(z)):
        _clear(z[k])
        for disc in range(springs.cam_place.shape[1]):
            z[k, 3 * disc], z[k, 3 * disc + 1] = springs.cam_place[k, disc, 0], springs.cam_place[k, disc, 1]
    return balance(springs, load, z, force, _YES)


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def balance_samples(
    ideal: KernelSprings, effects: Effects, made: SampleDeviations, load: Array, first: int, last: int, out: Array
) -> None:
    """Balance samples `first` to `last` under a load (k, u) [N] at crank angles that follow each other.

    `ideal` are the springs of ideal parts; the row of each sample in `out` (s, ``FIGURES``) is filled in.
    """
    count, contacts, discs = ideal.distance.shape[0], ideal.disc.size, effects.cam_place.shape[1]
    distance, shift = np.empty((count, contacts)), np.empty((count, contacts))
    z, force, cam_place = np.empty(load.shape), np.empty((count, contacts)), np.empty(effects.cam_place.shape)
    for s in range(first, last):
        circle, rotation = made.pin_circle[s], made.rotation[s]
        for k in range(count):
            for i in range(contacts):
                across = along = 0.0
                for j, size in enumerate((made.place[s, i, 0], made.place[s, i, 1], circle, rotation)):
                    across += effects.distance[k, i, j] * size
                    along += effects.shift[k, i, j] * size
                for j in range(made.waves.shape[1]):
                    across += effects.waves[k, i, j] * made.waves[s, j]
                distance[k, i], shift[k, i] = across, along
            cosine, sine = effects.turned[k, 0], effects.turned[k, 1]
            for disc in range(discs):
                x, y = made.cam_place[s, disc, 0], made.cam_place[s, disc, 1]
                out_x, out_y = effects.cam_place[k, disc, 0], effects.cam_place[k, disc, 1]
                cam_place[k, disc, 0] = made.eccentricity[s] * out_x + (cosine * x - sine * y)
                cam_place[k, disc, 1] = made.eccentricity[s] * out_y + (sine * x + cosine * y)
        springs = KernelSprings(
            ideal.radius,
            ideal.disc,
            ideal.turning,
            made.room[s],
            distance,
            ideal.slope,
            shift,
            ideal.shift_slope,
            ideal.bend,
            ideal.twist,
            ideal.phase,
            ideal.trochoid,
            ideal.stiffness,
            cam_place,
            made.cam[s],
            ideal.cam_stiffness,
            ideal.rubbing,
            ideal.cam_rubbing,
            ideal.bending,
            ideal.pins,
        )
        left = balance_along(springs, load, z, force)
        _sum_up(springs, z, force, out[s])
        out[s, FIGURES - 1] = left.force


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _sum_up(springs: KernelSprings, z: Array, force: Array, out: Array) -> None:
    """Write the figures of one sample, but the last."""
    count, discs = len(z), springs.cam_place.shape[1]
    for part in range(2):
        total, least, most = 0.0, math.inf, -math.inf
        for k in range(count):
            turned = z[k, 3 * discs] if part else 0.0
            for disc in range(0 if part else discs):
                turned += z[k, 3 * disc + 2] / discs
            total, least, most = total + turned, min(least, turned), max(most, turned)
        out[2 * part], out[2 * part + 1] = total / count / springs.radius, (most - least) / springs.radius
    tooth = pin = cam = 0.0
    for k in range(count):
        for i in range(force.shape[1]):
            if springs.turning[i]:
                tooth = max(tooth, force[k, i])
            else:
                pin = max(pin, force[k, i])
        for disc in range(springs.cam_place.shape[1]):
            pressing = _cam(springs, k, disc, z[k])
            # where both sides press, what the harder one does: depth is what it has more, both what they have together
            cam = max(cam, 0.5 * springs.cam_stiffness * (pressing.depth + pressing.both))
    carrying = 0
    for k in range(count):
        for i in range(force.shape[1]):
            if springs.turning[i] and force[k, i] > CARRIES * tooth:
                carrying += 1
    out[4], out[5], out[6], out[7] = tooth, pin, cam, carrying / count


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def gap(springs: KernelSprings, k: int, i: int, z: Array) -> Curved:
    """Compute a gap at departures z [m], shape (u,)."""
    pose = _pose(springs, springs.disc[i], z)
    return _curved(springs, k, i, pose, _apart(springs, k, i, pose), _NO)


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def is_open(springs: KernelSprings, k: int, i: int, z: Array) -> bool:
    """Tell whether a gap is surely open at departures z [m], shape (u,), without its width."""
    return _is_open(springs, k, i, _apart(springs, k, i, _pose(springs, springs.disc[i], z)), _NO)


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def state(springs: KernelSprings, k: int, load: Array, z: Array) -> State:
    """Compute the springs of a crank angle under a load (u,) [N] at departures z (u,) [m], which need be no balance.

    Without friction.
    """
    system = _system(springs)
    energy = _assemble(springs, k, load, z, 1.0, 0.0, _NO, system)
    return State(energy, system.residual, system.tangent)


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _system(springs: KernelSprings) -> _System:
    number = springs.slope.shape[2]
    return _System(
        np.zeros(number),
        np.zeros((number, number)),
        np.zeros(springs.disc.size + springs.cam_place.shape[1]),
        np.zeros(number),
        np.zeros(number),
        np.zeros(number),
        np.zeros((springs.disc.size, 5)),
        np.zeros(springs.disc.size + springs.cam_place.shape[1], np.bool_),
        np.zeros(1, np.int64),
    )


# Arrays are read before any branch: numba counts references to those that are read in one. It counts those to all of
# them where a loop calls what is not inlined: what `_assemble` calls at every contact is.


@njit(nogil=True, error_model="numpy", inline="always")
def _pose(springs: KernelSprings, disc: int, z: Array) -> _Pose:
    """Compute where a disc and the output are at departures z [m], shape (u,)."""
    x, radius = 3 * disc, springs.radius
    turned, output = z[x + 2], z[z.size - 1]
    return _Pose(z[x], z[x + 1], turned, output, turned / radius, output / radius)


@njit(nogil=True, error_model="numpy", inline="always")
def _apart(springs: KernelSprings, k: int, i: int, pose: _Pose) -> _Apart:
    """Compute how far two curves are apart.

    Finite turns count to the second order: a curve that turns with its disc by phi sees its mate's place turn the other
    way, q + i p as e^(i phi); a round hole only moves, its middle about the disc's and the pin's about the output's.
    """
    x, o = 3 * springs.disc[i], springs.slope.shape[2] - 1
    y, t, turning, phi, psi = x + 1, x + 2, springs.turning[i], pose.phi, pose.psi
    q, p = springs.distance[k, i], springs.shift[k, i]
    turned_q, turned_p = springs.slope[k, i, t] * pose.t, springs.shift_slope[k, i, t] * pose.t
    out_q, out_p = springs.slope[k, i, o] * pose.o, springs.shift_slope[k, i, o] * pose.o
    moved_q = springs.slope[k, i, x] * pose.x + springs.slope[k, i, y] * pose.y
    moved_p = springs.shift_slope[k, i, x] * pose.x + springs.shift_slope[k, i, y] * pose.y
    if turning:
        all_q, all_p = q + moved_q + turned_q, p + moved_p + turned_p
        return _Apart(all_q - phi * (all_p - 0.5 * turned_p), all_p + phi * (all_q - 0.5 * turned_q), all_q, all_p)
    second_q = phi * (p + 0.5 * turned_p) + 0.5 * psi * out_p
    second_p = phi * (q + 0.5 * turned_q) + 0.5 * psi * out_q
    return _Apart(q + moved_q + turned_q + out_q + second_q, p + moved_p + turned_p + out_p - second_p, q, p)


@njit(cache=cacheable(), nogil=True, error_model="numpy", forceinline=True)
def _curved(springs: KernelSprings, k: int, i: int, pose: _Pose, apart: _Apart, exact: bool) -> Curved:
    """Compute a gap and its derivatives from what `_apart` gives."""
    x, o = 3 * springs.disc[i], springs.slope.shape[2] - 1
    y, t, turning, phi, psi = x + 1, x + 2, springs.turning[i], pose.phi, pose.psi
    qx, px = springs.slope[k, i, x], springs.shift_slope[k, i, x]
    qy, py = springs.slope[k, i, y], springs.shift_slope[k, i, y]
    qt, pt = springs.slope[k, i, t], springs.shift_slope[k, i, t]
    qo, po = springs.slope[k, i, o], springs.shift_slope[k, i, o]
    bend, twist, room = springs.bend[k, i], springs.twist[k, i], springs.room[i]
    phase, trochoid = springs.phase[k, i], springs.trochoid
    arm_q, arm_p = apart.arm_q / springs.radius, apart.arm_p / springs.radius
    if turning:
        # the rate of w + i phi (w - v phi/2), with w, the arm, linear in the turn phi at the rate v, is v + i w
        qt, pt = qt - arm_p, pt + arm_q
        qx, px, qy, py = qx - phi * px, px + phi * qx, qy - phi * py, py + phi * qy
    else:
        qt, pt = qt + arm_p + phi * pt, pt - arm_q - phi * qt
        qo, po = qo + psi * po, po - psi * qo
    q, p = apart.q, apart.p
    width, c, s, rate = _rounded(trochoid, phase, bend, twist, q, p, turning, exact)
    ahead = (c * qx + s * px, c * qy + s * py, c * qt + s * pt, c * qo + s * po)
    aside = (c * px - s * qx, c * py - s * qy, c * pt - s * qt, c * po - s * qo)
    return Curved(room + width, ahead, aside, rate)


@njit(cache=cacheable(), nogil=True, error_model="numpy", forceinline=True)
def _rounded(
    trochoid: tuple[float, float, float],
    phase: float,
    bend: float,
    twist: float,
    q: float,
    p: float,
    turning: bool,
    exact: bool,
) -> tuple[float, float, float, float]:
    """Compute the distance of two round curves [m], cosine and sine of their normal's turn, and the rate of that [1/m].

    Where the third order may not be relied on, the foot point on the trochoid is looked for; where there is none near,
    as of parts that are far apart, the curve counts as its circle.
    """
    along, across, gentle = 1.0 + bend * q, bend * p, _is_gentle(trochoid, bend, twist, p)
    if turning and (exact or not gentle):
        found, distance, nq, np_, rate = _foot(trochoid, phase, q, p, along)
        if found:
            return distance, nq, np_, rate
        twist = 0.0
    reach = math.sqrt(along * along + across * across)
    if not reach > 0.0 or (turning and along <= 0.0):  # a hole is a whole circle, a valley is open beyond its middle
        return q, 1.0, 0.0, 0.0
    share = 1.0 / reach
    # (reach - 1) / bend without its cancellation, and what makes the circle a curve of third order
    beyond = q + across * p / (reach + along) if along > 0.0 else (reach - 1.0) / bend
    width = beyond + twist * p * p * p / 6.0
    return width, along * share, across * share + 0.5 * twist * p * p, bend * share + twist * p


@njit(nogil=True, error_model="numpy", inline="always")
def _is_gentle(trochoid: tuple[float, float, float], bend: float, twist: float, p: float) -> bool:
    """Tell whether the trochoid is known well enough by its curvature and the rate of that, so far along [m]."""
    sharpest = _sharpest(trochoid)
    if abs(sharpest * p) >= _FAR or abs(p) >= _SMALL * trochoid[0]:
        return False
    return abs(twist) <= _VALLEY * sharpest * sharpest and bend >= min(_BOTTOM * sharpest, 0.0)


@njit(nogil=True, error_model="numpy", inline="always")
def _sharpest(trochoid: tuple[float, float, float]) -> float:
    """Compute the curvature in the middle of a valley [1/m]: nowhere is the trochoid more concave."""
    E, c, N = trochoid
    return (E - c * N * N) / (E - c * N) ** 2


@njit(cache=cacheable(), nogil=True, error_model="numpy", forceinline=True)
def _foot(
    trochoid: tuple[float, float, float], phase: float, q: float, p: float, along: float
) -> tuple[bool, float, float, float, float]:
    """Tell whether a point has a foot on the trochoid nearby, and give what `_rounded` does of it, exactly.

    The point is q across and p along from the curve's point at the `phase` (N - 1) t, where the normal is at the angle
    t - alpha: tan(alpha) = c N sin(phase)/(E - c N cos(phase)). Its foot is found by Newton's method, from that on the
    circle of curvature, where the curve is p over `along` away.
    """
    E, c, N = trochoid
    sine, cosine = math.sin(phase), math.cos(phase)
    sa, ca = c * N * sine, E - c * N * cosine
    rate = math.sqrt(sa * sa + ca * ca)
    sa, ca = sa / rate, ca / rate
    sb, cb = sine * ca + cosine * sa, cosine * ca - sine * sa
    t = p / (rate * max(along, 0.5))  # the curve goes on at that rate by t
    t = min(max(t, -_FARTHEST_FOOT / N), _FARTHEST_FOOT / N)
    before, beyond = -math.inf, math.inf
    for _ in range(_ROUNDS):
        # sine, and cosine less 1, of t and N t
        half, wide = math.sin(0.5 * t), math.sin(0.5 * N * t)
        st, ct, sw, cw = 2.0 * half * math.cos(0.5 * t), -2.0 * half * half, math.sin(N * t), -2.0 * wide * wide
        # how far the curve has come from its point, then its rate and the rate of that, by t; each across and along
        uq, up = E * (ca * ct - sa * st), E * (sa * ct + ca * st)
        wq, wp = c * (cb * cw - sb * sw), c * (sb * cw + cb * sw)
        xq, xp = uq - wq, up - wp
        vq, vp = -up - E * sa + N * (wp + c * sb), uq + E * ca - N * (wq + c * cb)
        aq, ap = -uq - E * ca + N * N * (wq + c * cb), -up - E * sa + N * N * (wp + c * sb)
        square = vq * vq + vp * vp
        nearer = (q - xq) * vq + (p - xp) * vp
        if nearer > 0.0:
            before = t
        else:
            beyond = t
        step = nearer / max(square - (q - xq) * aq - (p - xp) * ap, 0.1 * square)
        step = min(max(step, -_LONGEST / N), _LONGEST / N)
        if not before <= t + step <= beyond:
            step = 0.5 * (before + beyond) - t
        t += step
        if abs(step) < _SETTLED:
            break
    speed = math.sqrt(square)
    nq, np_ = vp / speed, -vq / speed
    distance, curvature = (q - xq) * nq + (p - xp) * np_, -(aq * nq + ap * np_) / square
    bent = 1.0 + curvature * distance
    return abs(step) < _SETTLED and bent > 0.0, distance, nq, np_, curvature / bent


@njit(nogil=True, error_model="numpy", inline="always")
def _is_open(springs: KernelSprings, k: int, i: int, apart: _Apart, exact: bool) -> bool:
    """Tell whether a gap is surely open, by what `_apart` gives: most are, and their roots need not be taken."""
    q, p = apart.q, apart.p
    bend, twist, trochoid = springs.bend[k, i], springs.twist[k, i], springs.trochoid
    room, turning = springs.room[i] - _SURELY * abs(p), springs.turning[i]
    if room + q <= 0.0:
        return False
    if turning and (exact or not _is_gentle(trochoid, bend, twist, p)):
        bend = _sharpest(trochoid)  # a circle as sharp as the curve is anywhere lies within it
    along, across, rim = 1.0 + bend * q, bend * p, 1.0 - bend * room
    return bend > 0.0 or along * along + across * across < rim * rim


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _assemble(
    springs: KernelSprings, k: int, load: Array, z: Array, soft: float, friction: float, exact: bool, system: _System
) -> float:
    """Put together the system at departures z, of springs that are `soft` and a share of the friction.

    Returns
    -------
    The energy of the springs less the work of the load [J].
    """
    number = z.size
    residual, tangent, pressed, row = system.residual, system.tangent, system.pressed, system.row
    kept = system.kept
    turning_curve, of_disc, radius = springs.turning, springs.disc, springs.radius
    rough = springs.rubbing.shape[0] > 0 and friction > 0.0
    energy, hard = 0.0, soft * springs.cam_stiffness
    system.assembled[0] += 1
    for j in range(number):
        energy -= load[j] * z[j]
        residual[j] = load[j]
        for m in range(number):
            tangent[j, m] = 0.0
    straight, discs = _straight(springs), springs.cam_place.shape[1]
    for disc in range(discs):
        # Sums stand in names, not in the arrays, which the compiler would write at every contact.
        rx = ry = rt = ro = xx = xy = yy = xt = yt = tt = xo = yo = to = oo = 0.0
        pose = _pose(springs, disc, z)
        for i in range(straight):
            if of_disc[i] != disc:
                continue
            apart, stiffness = _apart(springs, k, i, pose), soft * springs.stiffness[k, i]
            pressed[i] = 0.0
            holds = kept[i]
            if not holds and _is_open(springs, k, i, apart, exact):
                continue
            found = _curved(springs, k, i, pose, apart, exact)
            if found.width >= 0.0 and not holds:
                continue
            force = -stiffness * found.width
            pressed[i] = force
            energy -= 0.5 * force * found.width
            if rough or exact:
                row[i, 0], row[i, 1], row[i, 2], row[i, 3] = found.ahead
                row[i, _RATE] = stiffness
            # The normal's turning stiffens a concave contact and softens a convex one; so do the turns of the parts.
            turning, with_disc = -force * found.rate, force / radius if turning_curve[i] else 0.0
            alone = with_disc if turning_curve[i] else -force / radius
            (ax, ay, at, ao), (bx, by, bt, bo) = found.ahead, found.aside
            rx, ry, rt, ro = rx + force * ax, ry + force * ay, rt + force * at, ro + force * ao
            xx += stiffness * ax * ax + turning * bx * bx
            xy += stiffness * ax * ay + turning * bx * by
            yy += stiffness * ay * ay + turning * by * by
            xt += stiffness * ax * at + turning * bx * bt + with_disc * bx
            yt += stiffness * ay * at + turning * by * bt + with_disc * by
            tt += stiffness * at * at + turning * bt * bt + alone * bt
            xo += stiffness * ax * ao + turning * bx * bo
            yo += stiffness * ay * ao + turning * by * bo
            to += stiffness * at * ao + turning * bt * bo
            oo += stiffness * ao * ao + turning * bo * bo + alone * bo
        x, y, t, o = 3 * disc, 3 * disc + 1, 3 * disc + 2, number - 1
        cam = _cam(springs, k, disc, z)
        i = springs.disc.size + disc
        pressed[i] = hard * cam.depth if cam.both > 0.0 else 0.0
        if cam.both > 0.0 or kept[i]:
            force, rate, u, v = hard * cam.depth, hard * cam.along, cam.u, cam.v
            energy += hard * cam.energy
            if rough:
                sliding = friction * springs.cam_rubbing * hard
                residual[t] += sliding * (cam.both if cam.both > 0.0 else cam.depth)
                if cam.both == cam.depth or cam.depth < 0.0:
                    tangent[t, x] -= sliding * u
                    tangent[t, y] -= sliding * v
            around = force / cam.depth * cam.around if cam.depth > 0.0 else hard * cam.around
            along = rate - around
            rx, ry = rx - force * u, ry - force * v
            xx += around + along * u * u
            xy += along * u * v
            yy += around + along * v * v
        residual[x], residual[y], residual[t] = residual[x] + rx, residual[y] + ry, residual[t] + rt
        residual[o] += ro
        tangent[x, x], tangent[y, y], tangent[t, t] = tangent[x, x] + xx, tangent[y, y] + yy, tangent[t, t] + tt
        tangent[x, y], tangent[y, x] = tangent[x, y] + xy, tangent[y, x] + xy
        tangent[x, t], tangent[t, x] = tangent[x, t] + xt, tangent[t, x] + xt
        tangent[y, t], tangent[t, y] = tangent[y, t] + yt, tangent[t, y] + yt
        tangent[x, o], tangent[o, x] = tangent[x, o] + xo, tangent[o, x] + xo
        tangent[y, o], tangent[o, y] = tangent[y, o] + yo, tangent[o, y] + yo
        tangent[t, o], tangent[o, t] = tangent[t, o] + to, tangent[o, t] + to
        tangent[o, o] += oo
    if rough:
        _drag(springs, k, friction, system)
    if springs.bending.size:
        energy += _bend(springs, k, z, soft, friction, system)
    return energy


@njit(nogil=True, error_model="numpy", inline="always")
def _straight(springs: KernelSprings) -> int:
    """Count the contacts that no other moves: all, or all but those of output pins that bend under several discs."""
    return springs.disc.size - springs.pins * springs.bending.shape[0]


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _bend(springs: KernelSprings, k: int, z: Array, soft: float, friction: float, system: _System) -> float:
    """Add output pins that bend, at departures z, to a system.

    Forces f on one pin in contacts of stiffness K, at widths w of the straight pin, hold where K^-1 f + B f + w = 0 and
    are 0 where that is positive, B the `bending`.

    Returns
    -------
    The energy of contacts and pins [J].
    """
    discs, energy = springs.bending.shape[0], 0.0
    first, o = _straight(springs), z.size - 1
    rough = springs.rubbing.shape[0] > 0 and friction > 0.0
    width, pressed = np.empty(discs), np.empty(discs)
    ahead, aside, rate = np.empty((discs, 4)), np.empty((discs, 4)), np.empty(discs)
    carries, held = np.empty(discs, np.bool_), np.empty(discs, np.bool_)
    flexible, stiff = np.empty((discs, discs)), np.empty((discs, discs))
    for pin in range(springs.pins):
        for d in range(discs):
            i = first + d * springs.pins + pin
            pose = _pose(springs, d, z)
            found = _curved(springs, k, i, pose, _apart(springs, k, i, pose), _NO)
            width[d], rate[d], held[d] = found.width, found.rate, system.kept[i]
            for j in range(4):
                ahead[d, j], aside[d, j] = found.ahead[j], found.aside[j]
            for e in range(discs):
                flexible[d, e] = springs.bending[d, e] / soft
            flexible[d, d] += 1.0 / (soft * springs.stiffness[k, i])
        _hold(flexible, width, held, carries, pressed, stiff)
        for d in range(discs):
            system.pressed[first + d * springs.pins + pin] = pressed[d]
            energy -= 0.5 * pressed[d] * width[d]
        for d in range(discs):
            i = first + d * springs.pins + pin
            if not carries[d]:
                continue
            force, system.row[i, _RATE] = pressed[d], 0.0
            for e in range(discs):
                system.row[i, _RATE] += stiff[d, e]  # as the plays of all discs on a pin open alike
            turning, alone = -force * rate[d], -force / springs.radius
            for a in range(4):
                system.row[i, a] = ahead[d, a]
                row = 3 * d + a if a < 3 else o
                rubs = friction * springs.rubbing[k, i, row] if rough else 0.0
                system.residual[row] += force * (ahead[d, a] + rubs)
                for b in range(4):
                    system.tangent[row, 3 * d + b if b < 3 else o] += turning * aside[d, a] * aside[d, b]
                for e in range(discs):
                    for b in range(4):
                        column = 3 * e + b if b < 3 else o
                        system.tangent[row, column] += stiff[d, e] * (ahead[d, a] + rubs) * ahead[e, b]
            # the turns of disc and output stiffen as in `_assemble`
            system.tangent[3 * d + 2, 3 * d + 2] += alone * aside[d, 2]
            system.tangent[o, o] += alone * aside[d, 3]
    return energy


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _hold(flexible: Array, width: Array, held: Mask, carries: Mask, pressed: Array, stiff: Array) -> None:
    """Find the forces on one pin [N] and which contacts carry, from widths [m] and flexibility [m/N]; and stiffness.

    Contacts that would pull open, the strongest first.
    """
    discs = width.size
    for d in range(discs):
        carries[d] = held[d] or width[d] < 0.0
    for _ in range(4 * discs):
        _stiffen(flexible, carries, stiff)
        changes, most = -1, 0.0
        for d in range(discs):
            pressed[d] = 0.0
            for e in range(discs):
                pressed[d] -= stiff[d, e] * width[e]
            if not held[d] and pressed[d] < most:
                changes, most = d, pressed[d]
        for d in range(discs if changes < 0 else 0):  # none pulls: does one that is open close?
            left = width[d]
            for e in range(discs):
                left += flexible[d, e] * pressed[e]
            if not carries[d] and left < most:
                changes, most = d, left
        if changes < 0:
            break
        carries[changes] = not carries[changes]


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _stiffen(flexible: Array, carries: Mask, stiff: Array) -> None:
    """Put the stiffness of the contacts of a pin that carry [N/m] into `stiff`, 0 for the others.

    It is the inverse of their flexibility, by Gauss and Jordan, in place.
    """
    discs = carries.size
    for d in range(discs):
        for e in range(discs):
            stiff[d, e] = flexible[d, e] if carries[d] and carries[e] else 0.0
    for pivot in range(discs):
        if not carries[pivot]:
            continue
        inverse = 1.0 / stiff[pivot, pivot]
        stiff[pivot, pivot] = 1.0
        for e in range(discs):
            stiff[pivot, e] *= inverse
        for d in range(discs):
            factor = stiff[d, pivot]
            if d == pivot or factor == 0.0:
                continue
            stiff[d, pivot] = 0.0
            for e in range(discs):
                stiff[d, e] -= factor * stiff[pivot, e]


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _cam(springs: KernelSprings, k: int, disc: int, z: Array) -> _Cam:
    """Compute how a disc presses on its cam: as a circle in a circle, on both sides where it has no clearance."""
    x, y = z[3 * disc] - springs.cam_place[k, disc, 0], z[3 * disc + 1] - springs.cam_place[k, disc, 1]
    reach, clearance = math.sqrt(x * x + y * y), springs.cam_clearance
    depth, share = reach - clearance, 1.0 / reach if reach > 0.0 else 0.0
    if reach < -clearance:
        within = reach * reach + clearance * clearance
        return _Cam(x * share, y * share, 2.0 * reach, 2.0, 2.0, within, -2.0 * clearance)
    return _Cam(x * share, y * share, depth, 1.0, depth * share, 0.5 * depth * depth, max(depth, 0.0))


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _drag(springs: KernelSprings, k: int, friction: float, system: _System) -> None:
    """Add the friction of contacts that slide, in proportion to their normal forces, to a system."""
    o, residual, tangent, row = springs.slope.shape[2] - 1, system.residual, system.tangent, system.row
    for i in range(_straight(springs)):
        force, x = system.pressed[i], 3 * springs.disc[i]
        for a in range(4 if force != 0.0 else 0):
            to = x + a if a < 3 else o
            rubs = friction * springs.rubbing[k, i, to]
            residual[to] += force * rubs
            for b in range(4):
                tangent[to, x + b if b < 3 else o] += row[i, _RATE] * rubs * row[i, b]


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _largest(values: Array) -> float:
    """Compute the largest size among values."""
    largest = 0.0
    for j in range(values.size):
        largest = max(largest, abs(values[j]))
    return largest


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _solve(matrix: Array, right: Array, out: Array, floating: float) -> float:
    """Solve a system by Gauss's elimination with pivots, in place; give the sign of its determinant, 0 if unsolvable.

    What only floats is held by a stiffness beside.
    """
    number, sign = right.size, 1.0
    for j in range(number):
        matrix[j, j] += floating
        out[j] = right[j]
    for j in range(number):
        pivot = j
        for i in range(j + 1, number):
            if abs(matrix[i, j]) > abs(matrix[pivot, j]):
                pivot = i
        if pivot != j:
            sign = -sign
            out[j], out[pivot] = out[pivot], out[j]
            for m in range(j, number):
                matrix[j, m], matrix[pivot, m] = matrix[pivot, m], matrix[j, m]
        if not abs(matrix[j, j]) > 0.0:
            return 0.0
        sign = sign if matrix[j, j] > 0.0 else -sign
        share = 1.0 / matrix[j, j]
        for i in range(j + 1, number):
            factor = matrix[i, j] * share
            if factor == 0.0:
                continue
            for m in range(j + 1, number):
                matrix[i, m] -= factor * matrix[j, m]
            out[i] -= factor * out[j]
    for j in range(number - 1, -1, -1):
        value = out[j]
        for m in range(j + 1, number):
            value -= matrix[j, m] * out[m]
        out[j] = value / matrix[j, j]
    return sign


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _roll_off(matrix: Array, right: Array, out: Array, floating: float) -> None:
    """Solve a symmetric system as if all of its eigenvalues were positive: that leads down from a ridge."""
    number = right.size
    values, vectors = np.linalg.eigh(matrix)
    _clear(out)
    for m in range(number):
        along = 0.0
        for j in range(number):
            along += vectors[j, m] * right[j]
        for j in range(number):
            out[j] += along / max(abs(values[m]), floating) * vectors[j, m]


class Rubbing(NamedTuple):
    """Friction that remembers, of n contacts, D cams and e seals, in this order: s = n + D + e of them.

    Each is a tangential spring that slips at its limit, with a force that it keeps between steps. `slip` (s, u) [1] is
    how far surfaces slide with the unknowns; the way of a disc across its cam comes on top. `coefficient` (s,) [1] is
    the limit per normal force, and `drag` (e,) [N] that of the seals. `stick` (s,) [N/m] is the stiffness till then.

    `loss` (s,) [1] is the share of a contact's normal force that its material holds back while it is let go, as
    another such spring, of the stiffness `backing` (s,) [N/m], along the normal.
    """

    slip: Array
    coefficient: Array
    drag: Array
    stick: Array
    loss: Array
    backing: Array


class _Memory(NamedTuple):
    """What a path has left behind: departures z (u,) [m], and of s contacts what they hold.

    That is the force along the surface and that of the material [N], the `pressed` force of the spring [N] and its
    `depth` [m], and how far surfaces slide with the unknowns from there on, `slip` (s, u) [1].
    """

    z: Array
    side: Array
    normal: Array
    pressed: Array
    depth: Array
    slip: Array


class _Step(NamedTuple):
    """One step of a path: its load [N], `residual`, `tangent` and Newton step, and friction's limits [N], if given.

    `side` and `normal` (s,) are the limits along the surface and in the material that a search holds; without `given`
    they follow from the normal forces at once, and the tangent is not symmetric. `work` (1,) counts what is assembled.
    """

    load: Array
    residual: Array
    tangent: Array
    step: Array
    start: Array
    ahead: Array
    side: Array
    normal: Array
    work: Integers


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def follow_path(
    springs: KernelSprings, rubbing: Rubbing, path: Array, reach: float, when: Array, z: Array
) -> tuple[Left, int]:
    """Follow loads along a path (m, u) [N] at the first crank angle, with friction that remembers.

    The departures z (rows, u) [m] are filled in, and `when` (rows,) each was, in steps of the path from its first load,
    which is at 0; the first of z is where the path begins, at rest. Each step is the balance with the forces of
    friction that the step itself leaves (backward Euler); one that finds none is halved. One in which the output moves
    by more than `reach` [m] is halved too, down to ``FINEST`` parts, while there are rows for them: under a load that
    only grows a reducer leaps across its play, and the leap is no wider than that.

    Returns
    -------
    Of force 0, or where no balance was found, what was left over there as a share of the largest load; and how many
    rows there are.
    """
    count, number = path.shape
    elements = rubbing.stick.size
    old, new = _memory(elements, number), _memory(elements, number)
    one = _step(elements, number)
    _copy(z[0], old.z)
    scale, rows, spare = 0.0, 0, when.size - count
    finest = 1.0 / FINEST if spare > 0 else 1.0
    for m in range(count):
        scale = max(scale, _largest(path[m]))
    for m in range(count):
        share, done, shortest = 1.0, 0.0, finest
        while done < 1.0:
            share = min(share, 1.0 - done)
            for j in range(number):
                before = path[m - 1, j] if m else 0.0
                one.load[j] = before + (path[m, j] - before) * (done + share)
            _slips(springs, rubbing, old)
            left = _leap(springs, rubbing, FOLLOWED * scale, one, old, new) / scale
            far = not left <= FOLLOWED or abs(new.z[number - 1] - old.z[number - 1]) > reach
            if far and m > 0 and share > shortest and spare > 0:
                share *= 0.5
                continue
            if not left <= FOLLOWED and one.work[0] <= _MOST_WORK * count:
                left = _settle(springs, rubbing, FOLLOWED * scale, one, old, new) / scale
            if not left <= FOLLOWED:
                if share < _SHORTEST and shortest < _SHORTEST:
                    # so close to a leap there is nothing to find: it is taken in a longer step
                    share, shortest = _SHORTEST, _SHORTEST
                    continue
                if share <= _SHORTEST or one.work[0] > _MOST_WORK * count:
                    return Left(left, 1.0, one.work[0]), rows
                share *= 0.5
                continue
            done += share
            share *= 2.0
            old, new = new, old
            if done >= 1.0:
                _copy(old.z, z[rows])
                when[rows] = float(m)
                rows += 1
            elif m > 0 and spare > 0:
                _copy(old.z, z[rows])
                when[rows] = m - 1.0 + done
                rows += 1
                spare -= 1
    return Left(0.0, 1.0, one.work[0]), rows


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def state_after(springs: KernelSprings, rubbing: Rubbing, before: Array, load: Array, z: Array, given: bool) -> State:
    """Compute a step of a path from rest by way of departures `before` to z (u,) [m] under a load (u,) [N].

    Neither need be a balance. Friction's limits follow from the normal forces at z, as `follow_path` has them; or they
    are `given`, as they follow from those before: then the forces left over are the descent of the energy.
    """
    number, elements = z.size, rubbing.stick.size
    rest, old, new = _memory(elements, number), _memory(elements, number), _memory(elements, number)
    one = _step(elements, number)
    _slips(springs, rubbing, rest)
    _copy(before, old.z)
    _copy(z, new.z)
    _copy(load, one.load)
    _weigh(springs, rubbing, _NO, one, rest, old)
    _slips(springs, rubbing, old)
    _renew(rubbing, one, old, 1.0)
    _, energy = _weigh(springs, rubbing, given, one, old, new)
    return State(energy, one.residual, one.tangent)


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _step(elements: int, number: int) -> _Step:
    return _Step(
        np.zeros(number),
        np.zeros(number),
        np.zeros((number, number)),
        np.zeros(number),
        np.zeros(number),
        np.zeros(number),
        np.zeros(elements),
        np.zeros(elements),
        np.zeros(1, np.int64),
    )


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _memory(elements: int, number: int) -> _Memory:
    return _Memory(
        np.zeros(number),
        np.zeros(elements),
        np.zeros(elements),
        np.zeros(elements),
        np.zeros(elements),
        np.zeros((elements, number)),
    )


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _slips(springs: KernelSprings, rubbing: Rubbing, at: _Memory) -> None:
    """Put how far each surface slides with the unknowns into `at`: on a cam that turns with the way of its disc."""
    for i in range(len(at.slip)):
        _copy(rubbing.slip[i], at.slip[i])
    for disc in range(springs.cam_place.shape[1]):
        cam, row = _cam(springs, _FIRST, disc, at.z), springs.disc.size + disc
        at.slip[row, 3 * disc] -= cam.v
        at.slip[row, 3 * disc + 1] += cam.u


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _leap(springs: KernelSprings, rubbing: Rubbing, allowed: float, one: _Step, old: _Memory, new: _Memory) -> float:
    """Look for the balance by Newton's method on springs and friction at once: quick, where it gets there; [N]."""
    _copy(old.z, new.z)
    longest = _NEAR / _largest(springs.bend[0])
    left = _weigh(springs, rubbing, _NO, one, old, new)[0]
    for _ in range(_LEAPS):
        if left <= allowed or not abs(np.linalg.det(one.tangent)) > 0.0:
            break
        _copy(np.linalg.solve(one.tangent, one.residual), one.step)
        share = min(1.0, longest / max(_largest(one.step), 1e-300))
        for j in range(one.step.size):
            new.z[j] += share * one.step[j]
        left = _weigh(springs, rubbing, _NO, one, old, new)[0]
    return left


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _settle(springs: KernelSprings, rubbing: Rubbing, allowed: float, one: _Step, old: _Memory, new: _Memory) -> float:
    """Look for the balance with friction's limits held, whose energy falls with every step, and renew them; [N]."""
    _copy(old.z, new.z)
    longest = _NEAR / _largest(springs.bend[0])
    floating = FLOATING * springs.cam_stiffness
    left = np.inf
    begun = one.work[0]
    for renewed in range(_RENEWALS):
        if one.work[0] - begun > _MOST_SETTLING:
            break
        _renew(rubbing, one, new if renewed else old, 1.0 if renewed < _HALVINGS else 0.3)
        inner, energy = _weigh(springs, rubbing, _YES, one, old, new)
        for _ in range(_RENEWALS):
            if inner <= 0.1 * allowed:
                break
            if not _solve_stable(one.tangent, one.residual, one.step, floating):
                _weigh(springs, rubbing, _YES, one, old, new)
                _roll_off(one.tangent, one.residual, one.step, floating)
            _copy(new.z, one.start)
            share = min(1.0, longest / max(_largest(one.step), 1e-300))
            for _ in range(_HALVINGS):
                for j in range(one.step.size):
                    new.z[j] = one.start[j] + share * one.step[j]
                inner, found = _weigh(springs, rubbing, _YES, one, old, new)
                if found <= energy + _ROUNDING * abs(energy):
                    break
                share *= 0.5
            energy = found
        left = _weigh(springs, rubbing, _NO, one, old, new)[0]
        if left <= allowed:
            break
    return left


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _solve_stable(matrix: Array, right: Array, out: Array, floating: float) -> bool:
    """Solve a symmetric system by Cholesky's method, from its lower half, in place; tell whether it is positive."""
    number = right.size
    for j in range(number):
        pivot = matrix[j, j] + floating
        for m in range(j):
            pivot -= matrix[j, m] * matrix[j, m]
        if not pivot > 0.5 * floating:
            return False
        pivot = math.sqrt(pivot)
        matrix[j, j] = pivot
        for i in range(j + 1, number):
            value = matrix[i, j]
            for m in range(j):
                value -= matrix[i, m] * matrix[j, m]
            matrix[i, j] = value / pivot
    for i in range(number):
        value = right[i]
        for m in range(i):
            value -= matrix[i, m] * out[m]
        out[i] = value / matrix[i, i]
    for i in range(number - 1, -1, -1):
        value = out[i]
        for m in range(i + 1, number):
            value -= matrix[m, i] * out[m]
        out[i] = value / matrix[i, i]
    return True


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _renew(rubbing: Rubbing, one: _Step, at: _Memory, share: float) -> None:
    """Bring friction's limits by a share to those of the normal forces."""
    for i in range(one.side.size):
        spring = at.pressed[i]
        one.normal[i] += share * (rubbing.loss[i] * spring - one.normal[i])
        one.side[i] += share * (rubbing.coefficient[i] * (spring + at.normal[i]) - one.side[i])


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _weigh(
    springs: KernelSprings, rubbing: Rubbing, given: bool, one: _Step, old: _Memory, new: _Memory
) -> tuple[float, float]:
    """Put together what is left of the load at the departures of `new`; give the largest of it [N] and the energy [J].

    With friction's limits `given` there is an energy, and the tangent is symmetric.
    """
    one.work[0] += 1
    number, contacts, z = one.load.size, springs.disc.size, new.z
    floating, energy, ahead = FLOATING * springs.cam_stiffness, 0.0, one.ahead
    for j in range(number):
        moved = z[j] - old.z[j]
        one.residual[j] = one.load[j] - floating * moved
        energy += (0.5 * floating * moved - one.load[j]) * moved
        for m in range(number):
            one.tangent[j, m] = floating if j == m else 0.0
    for i in range(contacts):
        x, t, o = 3 * springs.disc[i], 3 * springs.disc[i] + 2, number - 1
        pose = _pose(springs, springs.disc[i], z)
        apart = _apart(springs, _FIRST, i, pose)
        _clear(ahead)
        depth = 0.0
        if not _is_open(springs, _FIRST, i, apart, _NO):
            found = _curved(springs, _FIRST, i, pose, apart, _NO)
            depth = max(-found.width, 0.0)
            if depth > 0.0:
                ahead[x], ahead[x + 1], ahead[t], ahead[o] = found.ahead
        energy += _bear(rubbing, given, i, springs.stiffness[0, i], depth, one, old, new)
        if depth == 0.0:
            continue
        force = new.pressed[i] + new.normal[i]
        # The normal's turning, and the turns of the parts, as in `_assemble`.
        (bx, by, bt, bo), turning = found.aside, -force * found.rate
        with_disc = force / springs.radius if springs.turning[i] else 0.0
        alone = with_disc if springs.turning[i] else -force / springs.radius
        tangent = one.tangent
        tangent[x, x] += turning * bx * bx
        tangent[x + 1, x + 1] += turning * by * by
        tangent[t, t] += turning * bt * bt + alone * bt
        tangent[o, o] += turning * bo * bo + alone * bo
        for row, column, rate in (
            (x, x + 1, turning * bx * by),
            (x, t, turning * bx * bt + with_disc * bx),
            (x + 1, t, turning * by * bt + with_disc * by),
            (x, o, turning * bx * bo),
            (x + 1, o, turning * by * bo),
            (t, o, turning * bt * bo),
        ):
            tangent[row, column] += rate
            tangent[column, row] += rate
    for disc in range(springs.cam_place.shape[1]):
        x, y = 3 * disc, 3 * disc + 1
        cam = _cam(springs, _FIRST, disc, z)
        u, v, depth, around = cam.u, cam.v, cam.depth, cam.around
        _clear(ahead)
        if depth > 0.0:
            ahead[x], ahead[y] = -u, -v
        i = contacts + disc
        energy += _bear(rubbing, given, i, springs.cam_stiffness, max(depth, 0.0), one, old, new)
        if depth > 0.0:
            across = (new.pressed[i] + new.normal[i]) / depth * around
            one.tangent[x, x] += across * v * v
            one.tangent[y, y] += across * u * u
            one.tangent[x, y] -= across * u * v
            one.tangent[y, x] -= across * u * v
    for e in range(rubbing.drag.size):
        i = contacts + springs.cam_place.shape[1] + e
        energy += _rub_along(rubbing, i, rubbing.drag[e], 0.0, one, old, new)
    return _largest(one.residual), energy


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _bear(
    rubbing: Rubbing, given: bool, i: int, stiffness: float, depth: float, one: _Step, old: _Memory, new: _Memory
) -> float:
    """Add a contact that is pressed to a `depth` [m], its material and its friction; give their energy [J]."""
    spring, backing, loss = stiffness * depth, rubbing.backing[i], rubbing.loss[i]
    new.depth[i], new.pressed[i], new.normal[i] = depth, spring, 0.0
    energy, force, rate = 0.5 * spring * depth, spring, stiffness
    if loss > 0.0:
        most = one.normal[i] if given else loss * spring
        held, more = old.normal[i] + backing * (depth - old.depth[i]), backing
        energy += _stored(held, most, backing)
        if abs(held) > most:
            sign = 1.0 if held > 0.0 else -1.0
            held, more = sign * most, 0.0 if given else sign * loss * stiffness
        new.normal[i] = held
        force, rate = force + held, rate + more
    ahead = one.ahead
    for j in range(ahead.size):
        one.residual[j] += force * ahead[j]
        for m in range(ahead.size):
            one.tangent[j, m] += rate * ahead[j] * ahead[m]
    most, rising = one.side[i], 0.0
    if not given:
        most, rising = rubbing.coefficient[i] * force, rubbing.coefficient[i] * rate
    return energy + _rub_along(rubbing, i, most, rising, one, old, new)


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _rub_along(rubbing: Rubbing, i: int, most: float, rate: float, one: _Step, old: _Memory, new: _Memory) -> float:
    """Add the friction of a surface that slips at `most` [N], rising by `rate` [N/m] with depth; its energy [J]."""
    slip, stick, number = old.slip[i], rubbing.stick[i], one.load.size
    new.side[i] = 0.0
    if not most > 0.0:
        return 0.0
    held = old.side[i]
    for j in range(number):
        held += stick * slip[j] * (new.z[j] - old.z[j])
    energy = _stored(held, most, stick)
    if abs(held) > most:
        sign = 1.0 if held > 0.0 else -1.0
        held = sign * most
        for j in range(number):
            for m in range(number):
                one.tangent[j, m] -= sign * rate * slip[j] * one.ahead[m]
    else:
        for j in range(number):
            for m in range(number):
                one.tangent[j, m] += stick * slip[j] * slip[m]
    new.side[i] = held
    for j in range(number):
        one.residual[j] -= held * slip[j]
    return energy


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _stored(force: float, most: float, stiffness: float) -> float:
    """Find the energy of a spring that would hold a `force` [N] but slips at `most`, with what its slip takes [J]."""
    size = abs(force)
    return 0.5 * size * size / stiffness if size <= most else most * (size - 0.5 * most) / stiffness
