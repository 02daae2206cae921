"""The search for balances at crank angles, one after the other."""

import math

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import cacheable, njit
from cycloid_mj.statics.kernel.contacts import NO, YES, KernelSprings, largest_play, opened_by
from cycloid_mj.statics.kernel.continuation import by_continuation
from cycloid_mj.statics.kernel.newton import BALANCED, Residual, copy, largest, newton
from cycloid_mj.statics.kernel.system import Linearised, system_of

_SHORT, _KEPT = 3, 2
"""How often a system is put together in a search that was led well, and with contacts kept: from longer ones contacts
are kept for the next angle."""


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


_REACH = 0.1
"""How deep contacts may be pressed for their curves to be those of the flanks, as a share of the eccentricity."""


_OPENINGS = 32
"""Steps in which play opens where a path without friction is lost: downhill, from one least energy to the next."""


PATHS: bool = np.bool_(True)  # type: ignore[assignment]
"""Argument: a search goes on along the paths of `by_continuation` where the others lead nowhere."""


_WEDGED, _DEEP = 100.0, 100.0
"""Force on a cam over the load, and its depth in plays, beyond which parts are wedged: friction holds what nothing has
pressed together."""


def balance(springs: KernelSprings, load: Array, z: Array, force: Array, follow: bool) -> Residual:
    """Solve for the departures z (k, u) [m] at every crank angle under a load (k, u) [N], and the springs' forces.

    z and force (k, n) [N] are filled in. Each row of z is where its search starts. With `follow`, the first row is; the
    others start where the balances before them lead.

    Returns
    -------
    The worst of all angles, and their work together: where its force is above ``BALANCED``, no balance was found, and
    that angle is the last.
    """
    begun, system = z.copy(), system_of(springs)
    left = balance_briefly(springs, load, z, force, follow, None, system)
    if left.force <= BALANCED:
        return left
    z[:] = begun
    return balance_by_all(springs, load, z, force, follow, PATHS, system)


def _balance(
    springs: KernelSprings,
    load: Array,
    z: Array,
    force: Array,
    follow: bool,
    paths: bool | None,
    system: Linearised,
) -> Residual:
    """Do what `balance` does, by all paths, or without those of `by_continuation`, where `paths` is None.

    For None, numba leaves out what hangs on them, which is half of what there is to compile, and seldom needed.
    """
    count, start, near, keep, worst, last = len(load), system.begun, False, False, 0.0, 0
    system.assembled[0] = 0
    for k in range(count):
        here = z[k]
        copy(here, start)
        if follow and k:
            _lead(z, k, near)
        begun = system.assembled[0]
        scale = largest(load[k]) or 1.0
        left = _search(springs, k, load[k], here, start, scale, keep, system)
        if paths is not None:
            left = _search_on(springs, k, load[k], here, start, left, BALANCED * scale, system)
        left /= scale
        work = system.assembled[0] - begun
        near, keep = work <= _SHORT + 1, follow and work > (_KEPT if keep else _SHORT)
        copy(system.pressed, force[k])
        worst, last = max(worst, left), k
        if not left <= BALANCED:
            break
    return Residual(worst, last, system.assembled[0])


balance_briefly = njit(cache=cacheable(), allocates=False, nogil=True, error_model="numpy")(_balance)
"""`_balance` without the paths of `by_continuation`, which make arrays."""

balance_by_all = njit(cache=cacheable(), nogil=True, error_model="numpy")(_balance)
"""`_balance` by all paths."""


@njit(nogil=True, error_model="numpy", inline="always")
def _lead(z: Array, k: int, near: bool) -> None:
    """Put the departures at an angle where those before lead: to the second order, where the search was short."""
    for j in range(z.shape[1]):
        z[k, j] = 2.0 * z[k - 1, j] - z[k - 2, j] if k > 1 else z[k - 1, j]
        if near and k > 2:
            z[k, j] += z[k - 1, j] - 2.0 * z[k - 2, j] + z[k - 3, j]


@njit(nogil=True, error_model="numpy", inline="always")
def _search(
    springs: KernelSprings,
    k: int,
    load: Array,
    here: Array,
    start: Array,
    scale: float,
    keep: bool,
    system: Linearised,
) -> float:
    """Solve for the departures `here` (u,) [m] by Newton's method from where they are; else along a path.

    The `scale` [N] is that of the load. Gives what is left over of it [N].

    Springs so soft that they press in spite of all play have one energy without ridges, whose least Newton's method
    finds from a `start`. From there friction is brought on and the springs are hardened, in steps that are halved until
    Newton's method, with friction and springs at once, gets to the end of each. Where that path has an end, as where
    parts snap over, the springs are hardened first, downhill all the way, and friction is brought on then.

    For `keep` see `newton`.
    """
    rubbed = springs.rubbing.shape[0] > 0
    softest, friction, soft, way, further, stride, boldest = 1.0, 1.0, 1.0, 2.0, 2.0, 0.0, 0.0
    attempt, downhill, most, least = -1, NO, BALANCED * scale, math.inf
    while True:
        damping = _DAMPED / scale if attempt >= 0 and friction < 1.0 else 0.0
        exact = attempt >= _EXACTLY
        left = newton(springs, k, load, here, soft, friction, exact, most, damping, keep, downhill, system)
        keep = NO
        if soft == 1.0 and friction == 1.0:
            if rubbed and _wedged(springs, k, here, scale):
                left = math.inf
            least = min(least, left)
        if least <= most:
            break
        if left <= most:
            way, stride = (further, min(2.0 * stride, boldest)) if further > 0.0 else (0.0, boldest)
            copy(here, system.back)
        else:
            stride *= 0.5
            copy(system.back, here)
        if not stride >= _LEAST:
            attempt += 1
            if attempt == len(_TRIES):
                break
            copy(start, here)
            copy(start, system.back)
            further, stride, way = 0.0, 0.0, 0.0
            softest = min(1.0, scale / _soft_force(springs, k, _TRIES[attempt][0]))
        else:
            further = min(way + stride, 1.0 if way < 1.0 else 2.0)
        _, boldest, hardens_first = _TRIES[attempt]
        if not rubbed and not hardens_first and 0.0 < further <= 1.0:
            further = min(1.0 + stride, 2.0)
        first, last = min(further, 1.0), max(further - 1.0, 0.0)
        friction, hardened = (last, first) if hardens_first else (first, last)
        soft, downhill = softest ** (1.0 - hardened), further == 0.0 or (hardens_first and friction == 0.0)
    return least


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _search_on(
    springs: KernelSprings,
    k: int,
    load: Array,
    here: Array,
    start: Array,
    least: float,
    most: float,
    system: Linearised,
) -> float:
    """Go on where `_search` left more than `most` [N] over: along the paths of `by_continuation`, from a `start` (u,).

    They are followed by their length, one where another is lost. Gives the least that was left over [N].
    """
    scale, rubbed = largest(load) or 1.0, springs.rubbing.shape[0] > 0
    for lag in _LAGS:
        if least <= most or (not rubbed and lag != _LAGS[0]):
            break
        copy(start, here)
        left = by_continuation(springs, k, load, here, lag if rubbed else 0.0, most, system)
        if not (rubbed and _wedged(springs, k, here, scale)):
            least = min(least, left)
    for step in range(_OPENINGS + 1 if least > most and not rubbed else 0):
        opened = opened_by(springs, step / _OPENINGS, system.row[:, 0].copy())
        left = newton(opened, k, load, here, 1.0, 0.0, YES, most, 0.0, NO, YES, system)
        least = min(least, left) if step == _OPENINGS else least
    return least


@njit(nogil=True, error_model="numpy", inline="always")
def _soft_force(springs: KernelSprings, k: int, plays: float) -> float:
    """Compute the force [N] by which springs are softened to the load: the hardest is pressed several plays deep by it.

    No contact is pressed beyond the reach of the curves by it, however much harder a cam is.
    """
    reach, contact = _REACH * springs.trochoid[1], 0.0
    for i in range(springs.disc.size):
        contact = max(contact, springs.stiffness[k, i])
    return min(max(contact, springs.cam_stiffness) * min(plays * largest_play(springs), reach), contact * reach)


@njit(nogil=True, error_model="numpy", inline="always")
def _wedged(springs: KernelSprings, k: int, here: Array, load: float) -> bool:
    """Tell whether at departures (u,) [m] a cam is pressed as no load [N] presses it: friction holds it so."""
    deepest = max(_DEEP * largest_play(springs), _WEDGED * load / springs.cam_stiffness)
    for disc in range(springs.cam_place.shape[1]):
        x = here[3 * disc] - springs.cam_place[k, disc, 0]
        y = here[3 * disc + 1] - springs.cam_place[k, disc, 1]
        if x * x + y * y > deepest * deepest:
            return True
    return False
