"""Loads along a path, with friction that remembers which way it slid.

Each step is a balance by Newton's method on springs and friction at once, or else with friction's limits held and
renewed.
"""

from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.compiling import cacheable, njit
from cycloid_mj.statics.kernel.contacts import FIRST, NO, YES, KernelSprings, apart_of, curved, least_width, pose_of
from cycloid_mj.statics.kernel.newton import (
    FLOATING,
    FOLLOWED,
    ROUNDING,
    Residual,
    clear,
    copy,
    largest,
    roll_off,
    solve_stable,
)
from cycloid_mj.statics.kernel.system import State, cam_at

FINEST = 1024
"""Most parts of a step along a path in which the output leaps."""


_LEAPS, _RENEWALS, _SHORTEST = 12, 40, 1.0 / 16.0
"""Newton steps that a step along a path is given before the slower search, rounds of that, and its least share."""


_MOST_WORK, _MOST_SETTLING = 150, 2000
"""How often a system may be put together, for each step of a path on average, and in one slow search."""


_NEAR = 0.5
"""Longest step along a path, as a share of the least radius of a contact's curve."""


_HALVINGS = 20


_CREEPS, _EASED, _BRAKED, _STIFFEST = 2000, 0.5, 8.0, 1e8
"""Most steps of a creep to a balance; factors on the drag after a step that has gone through, and after one that has
not; and the drag beyond which nothing is looked for, as a share of the cam's stiffness, from which it begins."""


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
    they follow from the normal forces at once, and the tangent is not symmetric. `drag` (1,) [N/m] holds the unknowns
    where the step begins. `work` (1,) counts what is assembled; `vectors` (u, u) are for `roll_off`.
    """

    load: Array
    residual: Array
    tangent: Array
    step: Array
    start: Array
    ahead: Array
    side: Array
    normal: Array
    drag: Array
    work: Integers
    vectors: Array


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def follow_path(
    springs: KernelSprings, rubbing: Rubbing, path: Array, reach: float, when: Array, z: Array
) -> tuple[Residual, int]:
    """Follow loads along a path (m, u) [N] at the first crank angle, with friction that remembers.

    The departures z (rows, u) [m] are filled in, and `when` (rows,) each was, in steps of the path from its first load,
    which is at 0; the first of z is where the path begins, at rest. Each step is the balance with the forces of
    friction that the step itself leaves (backward Euler); one that finds none is halved, and crept through where that
    does not help. One in which the output moves by more than `reach` [m] is halved too, down to ``FINEST`` parts, while
    there are rows for them: under a load that only grows a reducer leaps across its play, and the leap is no wider than
    that.

    Returns
    -------
    Of force 0, or where no balance was found, what was left over there as a share of the largest load; and how many
    rows there are.
    """
    count, number = path.shape
    elements = rubbing.stick.size
    old, new = _memory(elements, number), _memory(elements, number)
    one = _step(elements, number)
    one.drag[0] = FLOATING * springs.cam_stiffness
    copy(z[0], old.z)
    scale, rows, spare = 0.0, 0, when.size - count
    finest = 1.0 / FINEST if spare > 0 else 1.0
    for m in range(count):
        scale = max(scale, largest(path[m]))
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
                if share > _SHORTEST and one.work[0] <= _MOST_WORK * count:
                    share *= 0.5
                    continue
                left = _creep(springs, rubbing, FOLLOWED * scale, one, old, new) / scale
                if not left <= FOLLOWED:
                    return Residual(left, 0, one.work[0]), rows
            done += share
            share *= 2.0
            old, new = new, old
            if done >= 1.0:
                copy(old.z, z[rows])
                when[rows] = float(m)
                rows += 1
            elif m > 0 and spare > 0:
                copy(old.z, z[rows])
                when[rows] = m - 1.0 + done
                rows += 1
                spare -= 1
    return Residual(0.0, 0, one.work[0]), rows


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def state_after(springs: KernelSprings, rubbing: Rubbing, before: Array, load: Array, z: Array, given: bool) -> State:
    """Compute a step of a path from rest by way of departures `before` to z (u,) [m] under a load (u,) [N].

    Neither need be a balance. Friction's limits follow from the normal forces at z, as `follow_path` has them; or they
    are `given`, as they follow from those before: then the forces left over are the descent of the energy.
    """
    number, elements = z.size, rubbing.stick.size
    rest, old, new = _memory(elements, number), _memory(elements, number), _memory(elements, number)
    one = _step(elements, number)
    one.drag[0] = FLOATING * springs.cam_stiffness
    _slips(springs, rubbing, rest)
    copy(before, old.z)
    copy(z, new.z)
    copy(load, one.load)
    _weigh(springs, rubbing, NO, one, rest, old)
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
        np.zeros(1),
        np.zeros(1, np.int64),
        np.zeros((number, number)),
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
        copy(rubbing.slip[i], at.slip[i])
    for disc in range(springs.cam_place.shape[1]):
        cam, row = cam_at(springs, FIRST, disc, at.z), springs.disc.size + disc
        at.slip[row, 3 * disc] -= cam.v
        at.slip[row, 3 * disc + 1] += cam.u


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _leap(springs: KernelSprings, rubbing: Rubbing, allowed: float, one: _Step, old: _Memory, new: _Memory) -> float:
    """Look for the balance by Newton's method on springs and friction at once: quick, where it gets there; [N]."""
    copy(old.z, new.z)
    longest = _NEAR / largest(springs.bend[0])
    left = _weigh(springs, rubbing, NO, one, old, new)[0]
    for _ in range(_LEAPS):
        if left <= allowed or not abs(np.linalg.det(one.tangent)) > 0.0:
            break
        copy(np.linalg.solve(one.tangent, one.residual), one.step)
        share = min(1.0, longest / max(largest(one.step), 1e-300))
        for j in range(one.step.size):
            new.z[j] += share * one.step[j]
        left = _weigh(springs, rubbing, NO, one, old, new)[0]
    return left


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _settle(springs: KernelSprings, rubbing: Rubbing, allowed: float, one: _Step, old: _Memory, new: _Memory) -> float:
    """Look for the balance with friction's limits held, whose energy falls with every step, and renew them; [N]."""
    copy(old.z, new.z)
    longest = _NEAR / largest(springs.bend[0])
    floating = FLOATING * springs.cam_stiffness
    left = np.inf
    begun = one.work[0]
    for renewed in range(_RENEWALS):
        if one.work[0] - begun > _MOST_SETTLING:
            break
        _renew(rubbing, one, new if renewed else old, 1.0 if renewed < _HALVINGS else 0.3)
        inner, energy = _weigh(springs, rubbing, YES, one, old, new)
        for _ in range(_RENEWALS):
            if inner <= 0.1 * allowed:
                break
            if not solve_stable(one.tangent, one.residual, one.step, floating):
                _weigh(springs, rubbing, YES, one, old, new)
                roll_off(one.tangent, one.residual, one.step, floating, one.vectors)
            copy(new.z, one.start)
            share = min(1.0, longest / max(largest(one.step), 1e-300))
            for _ in range(_HALVINGS):
                for j in range(one.step.size):
                    new.z[j] = one.start[j] + share * one.step[j]
                inner, found = _weigh(springs, rubbing, YES, one, old, new)
                if found <= energy + ROUNDING * abs(energy):
                    break
                share *= 0.5
            energy = found
        left = _weigh(springs, rubbing, NO, one, old, new)[0]
        if left <= allowed:
            break
    return left


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _creep(springs: KernelSprings, rubbing: Rubbing, allowed: float, one: _Step, old: _Memory, new: _Memory) -> float:
    """Let the parts creep to the balance against a drag, friction following on their way, and ease it; [N] is left.

    Where friction leaves no balance near, parts leap to one that is not, and what they rub on the way decides which. A
    drag that is large enough leaves one balance for each step. The parts begin at `old`, and both end where they are.
    """
    floating = FLOATING * springs.cam_stiffness
    drag, left = springs.cam_stiffness, np.inf
    for _ in range(_CREEPS):
        one.drag[0] = drag
        _slips(springs, rubbing, old)
        if _leap(springs, rubbing, 0.5 * allowed, one, old, new) <= 0.5 * allowed:
            left = 0.0
            for j in range(one.load.size):
                left = max(left, abs(drag * (new.z[j] - old.z[j])))
            _keep(new, old)
            if left <= 0.5 * allowed:
                break
            drag = max(_EASED * drag, floating)
        else:
            left = np.inf
            drag *= _BRAKED
            if drag > _STIFFEST * springs.cam_stiffness:
                break
    one.drag[0] = floating
    return left


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _keep(of: _Memory, to: _Memory) -> None:
    """Copy what a path has left behind, but not how far surfaces slide from there."""
    copy(of.z, to.z)
    copy(of.side, to.side)
    copy(of.normal, to.normal)
    copy(of.pressed, to.pressed)
    copy(of.depth, to.depth)


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
    drag, energy, ahead = one.drag[0], 0.0, one.ahead
    for j in range(number):
        moved = z[j] - old.z[j]
        one.residual[j] = one.load[j] - drag * moved
        energy += (0.5 * drag * moved - one.load[j]) * moved
        for m in range(number):
            one.tangent[j, m] = drag if j == m else 0.0
    for i in range(contacts):
        x, t, o = 3 * springs.disc[i], 3 * springs.disc[i] + 2, number - 1
        pose = pose_of(springs, springs.disc[i], z)
        apart = apart_of(springs, FIRST, i, pose)
        clear(ahead)
        depth = 0.0
        if least_width(springs, FIRST, i, apart, NO) == 0.0:
            found = curved(springs, FIRST, i, pose, apart, NO)
            depth = max(-found.width, 0.0)
            if depth > 0.0:
                ahead[x], ahead[x + 1], ahead[t], ahead[o] = found.ahead
        energy += _bear(rubbing, given, i, springs.stiffness[0, i], depth, one, old, new)
        if depth == 0.0:
            continue
        force = new.pressed[i] + new.normal[i]
        # The normal's turning, and the turns of the parts, as in `assemble`.
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
        cam = cam_at(springs, FIRST, disc, z)
        u, v, depth, around = cam.u, cam.v, cam.depth, cam.around
        clear(ahead)
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
    return largest(one.residual), energy


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
