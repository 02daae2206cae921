"""Equilibria along a load path with elastoplastic friction: backward Euler with return mapping."""

from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array, Integers
from cycloid_mj.base.compiling import cacheable, njit
from cycloid_mj.statics.kernel.contacts import FALSE, FIRST, TRUE, KernelSprings, apart_of, gap_at, least_width, pose_of
from cycloid_mj.statics.kernel.newton import (
    PATH_RESIDUAL_RTOL,
    RIGID_BODY_STIFFNESS,
    ROUNDING,
    Residual,
    clear,
    copy,
    largest,
    modified_newton_step,
    solve_stable,
)
from cycloid_mj.statics.kernel.system import State, cam_at

MAX_SUBSTEPS = 1024
"""Largest number of parts of a step along a path in which the output jumps."""


class HysteresisSettings(NamedTuple):
    """Settings of the steps along a path with elastoplastic friction (`follow_path`).

    A step is solved by Newton's method with the consistent tangent (Simo & Hughes, Computational Inelasticity, 1998),
    then by a fixed-point iteration of Tresca friction problems (Haslinger 1983), then by pseudo-transient continuation
    (Kelley & Keyes, SIAM J. Numer. Anal. 35 (1998), 508-523).

    Attributes
    ----------
    newton_steps
        Newton steps before the Tresca iteration.
    tresca_iterations
        Tresca iterations, and Newton steps in each.
    tresca_work
        Largest number of assemblies in a Tresca iteration.
    undamped_iterations
        Tresca iterations before the update of the limits is damped, and largest number of halvings of a Newton step.
    damped_update
        Share by which the limits are updated then.
    work_per_step
        Largest number of assemblies per step of the path, on average; beyond it, pseudo-transient continuation follows.
    min_step
        Smallest share of a step before pseudo-transient continuation.
    max_step
        Largest component of a Newton step, relative to the smallest radius of curvature of the contacts.
    pseudo_steps
        Largest number of pseudo time steps.
    decrease, increase
        Factors on the inverse pseudo time step after a step that converged, and after one that did not.
    max_stiffness
        Inverse pseudo time step beyond which the continuation fails, relative to the cam's stiffness, its first value.
    """

    newton_steps: int = 12
    tresca_iterations: int = 40
    tresca_work: int = 2000
    undamped_iterations: int = 20
    damped_update: float = 0.3
    work_per_step: int = 150
    min_step: float = 1.0 / 16.0
    max_step: float = 0.5
    pseudo_steps: int = 2000
    decrease: float = 0.5
    increase: float = 8.0
    max_stiffness: float = 1e8


_HYSTERESIS = HysteresisSettings()


class Rubbing(NamedTuple):
    """Friction elements (Prandtl-Jenkin) of n contacts, D cams and e seals, in this order: s = n + D + e of them.

    Each is a tangential spring that slips at its limit and keeps its force between steps. `slip` (s, u) [1] is the
    sliding per unknown; that of a disc across its cam is added. `coefficient` (s,) [1] is the limit per normal force,
    and `drag` (e,) [N] that of the seals. `stick` (s,) [N/m] is the stiffness below the limit.

    `loss` (s,) [1] is the share of a contact's normal force that its material retains during unloading, as another such
    spring of the stiffness `backing` (s,) [N/m] along the normal.
    """

    slip: Array
    coefficient: Array
    drag: Array
    stick: Array
    loss: Array
    backing: Array


class _ElastoplasticState(NamedTuple):
    """State at the end of a step: displacements z (u,) [m], and forces of s elements.

    These are the friction force `side` and the force of the material `normal` [N], the force of the spring `pressed`
    [N] and its `depth` [m], and the sliding per unknown in the next step, `slip` (s, u) [1].
    """

    z: Array
    side: Array
    normal: Array
    pressed: Array
    depth: Array
    slip: Array


class _Step(NamedTuple):
    """A step of a path: `load` [N], `residual`, `tangent` and Newton step, and workspace.

    `side` and `normal` (s,) are the fixed limits of friction and material in a Tresca iteration; otherwise the limits
    follow from the normal forces, and the tangent is not symmetric. `drag` (1,) [N/m] is the inverse pseudo time step,
    or the regularization of rigid-body modes. `gradient` (u,) [1] is that of the current contact's depth. `work` (1,)
    counts the assemblies; `vectors` (u, u) are for `modified_newton_step`.
    """

    load: Array
    residual: Array
    tangent: Array
    step: Array
    start: Array
    gradient: Array
    side: Array
    normal: Array
    drag: Array
    work: Integers
    vectors: Array


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def follow_path(
    springs: KernelSprings, rubbing: Rubbing, path: Array, reach: float, when: Array, z: Array
) -> tuple[Residual, int]:
    """Solve for equilibrium along a load path (m, u) [N] at the first crank angle, with elastoplastic friction.

    The displacements z (rows, u) [m] are filled in, with their positions `when` (rows,) on the path, counted in loads
    from 0; the first of z is the initial state, at rest. Each step is an equilibrium with the friction forces at its
    end (backward Euler). A step without solution is halved, and then solved by pseudo-transient continuation. A step in
    which the output moves by more than `reach` [m] is halved, too, up to ``MAX_SUBSTEPS`` parts, while there are rows
    for them: under a load that only grows, a reducer jumps across its backlash.

    Returns
    -------
    tuple of Residual and int
        Residual of force 0, or that of a step without equilibrium relative to the largest load; and the number of rows.
    """
    count, number = path.shape
    elements = rubbing.stick.size
    old, new = _new_state(elements, number), _new_state(elements, number)
    one = _new_step(elements, number)
    one.drag[0] = RIGID_BODY_STIFFNESS * springs.cam_stiffness
    copy(z[0], old.z)
    scale, rows, spare = 0.0, 0, when.size - count
    finest = 1.0 / MAX_SUBSTEPS if spare > 0 else 1.0
    for m in range(count):
        scale = max(scale, largest(path[m]))
    for m in range(count):
        share, done, shortest = 1.0, 0.0, finest
        while done < 1.0:
            share = min(share, 1.0 - done)
            for j in range(number):
                before = path[m - 1, j] if m else 0.0
                one.load[j] = before + (path[m, j] - before) * (done + share)
            _update_slip(springs, rubbing, old)
            norm = _solve_newton(springs, rubbing, PATH_RESIDUAL_RTOL * scale, one, old, new) / scale
            far = not norm <= PATH_RESIDUAL_RTOL or abs(new.z[number - 1] - old.z[number - 1]) > reach
            if far and m > 0 and share > shortest and spare > 0:
                share *= 0.5
                continue
            if not norm <= PATH_RESIDUAL_RTOL and one.work[0] <= _HYSTERESIS.work_per_step * count:
                norm = _solve_tresca(springs, rubbing, PATH_RESIDUAL_RTOL * scale, one, old, new) / scale
            if not norm <= PATH_RESIDUAL_RTOL:
                if share < _HYSTERESIS.min_step and shortest < _HYSTERESIS.min_step:
                    # close to a jump there is no equilibrium: it is taken in a longer step
                    share, shortest = _HYSTERESIS.min_step, _HYSTERESIS.min_step
                    continue
                if share > _HYSTERESIS.min_step and one.work[0] <= _HYSTERESIS.work_per_step * count:
                    share *= 0.5
                    continue
                norm = _solve_pseudo_transient(springs, rubbing, PATH_RESIDUAL_RTOL * scale, one, old, new) / scale
                if not norm <= PATH_RESIDUAL_RTOL:
                    return Residual(norm, 0, one.work[0]), rows
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
    """Assemble a step of a path from rest via displacements `before` to z (u,) [m] under a load (u,) [N].

    Neither needs to be an equilibrium. The friction limits follow from the normal forces at z, as in `follow_path`, or
    are `given` by those at `before`: then the residual is the descent of the energy.
    """
    number, elements = z.size, rubbing.stick.size
    rest, old, new = _new_state(elements, number), _new_state(elements, number), _new_state(elements, number)
    one = _new_step(elements, number)
    one.drag[0] = RIGID_BODY_STIFFNESS * springs.cam_stiffness
    _update_slip(springs, rubbing, rest)
    copy(before, old.z)
    copy(z, new.z)
    copy(load, one.load)
    _assemble_step(springs, rubbing, FALSE, one, rest, old)
    _update_slip(springs, rubbing, old)
    _update_limits(rubbing, one, old, 1.0)
    _, energy = _assemble_step(springs, rubbing, given, one, old, new)
    return State(energy, one.residual, one.tangent)


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _new_step(elements: int, number: int) -> _Step:
    """Allocate a step of friction elements with a number of unknowns."""
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
def _new_state(elements: int, number: int) -> _ElastoplasticState:
    """Allocate the state of friction elements at rest, with a number of unknowns."""
    return _ElastoplasticState(
        np.zeros(number),
        np.zeros(elements),
        np.zeros(elements),
        np.zeros(elements),
        np.zeros(elements),
        np.zeros((elements, number)),
    )


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _update_slip(springs: KernelSprings, rubbing: Rubbing, at: _ElastoplasticState) -> None:
    """Set the sliding per unknown at a state; that of a cam depends on the direction of its disc's displacement."""
    for i in range(len(at.slip)):
        copy(rubbing.slip[i], at.slip[i])
    for disc in range(springs.cam_place.shape[1]):
        cam, row = cam_at(springs, FIRST, disc, at.z), springs.disc.size + disc
        at.slip[row, 3 * disc] -= cam.v
        at.slip[row, 3 * disc + 1] += cam.u


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _solve_newton(
    springs: KernelSprings,
    rubbing: Rubbing,
    allowed: float,
    one: _Step,
    old: _ElastoplasticState,
    new: _ElastoplasticState,
) -> float:
    """Solve a step by Newton's method with the consistent tangent of springs and friction; return the residual [N]."""
    copy(old.z, new.z)
    longest = _HYSTERESIS.max_step / largest(springs.bend[0])
    norm = _assemble_step(springs, rubbing, FALSE, one, old, new)[0]
    for _ in range(_HYSTERESIS.newton_steps):
        if norm <= allowed or not abs(np.linalg.det(one.tangent)) > 0.0:
            break
        copy(np.linalg.solve(one.tangent, one.residual), one.step)
        share = min(1.0, longest / max(largest(one.step), 1e-300))
        for j in range(one.step.size):
            new.z[j] += share * one.step[j]
        norm = _assemble_step(springs, rubbing, FALSE, one, old, new)[0]
    return norm


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _solve_tresca(
    springs: KernelSprings,
    rubbing: Rubbing,
    allowed: float,
    one: _Step,
    old: _ElastoplasticState,
    new: _ElastoplasticState,
) -> float:
    """Solve a step by a fixed-point iteration of the friction limits (Tresca); return the residual norm [N].

    With fixed limits the solution minimizes an energy.
    """
    copy(old.z, new.z)
    longest = _HYSTERESIS.max_step / largest(springs.bend[0])
    floating = RIGID_BODY_STIFFNESS * springs.cam_stiffness
    norm = np.inf
    begun = one.work[0]
    for iteration in range(_HYSTERESIS.tresca_iterations):
        if one.work[0] - begun > _HYSTERESIS.tresca_work:
            break
        share = 1.0 if iteration < _HYSTERESIS.undamped_iterations else _HYSTERESIS.damped_update
        _update_limits(rubbing, one, new if iteration else old, share)
        inner, energy = _assemble_step(springs, rubbing, TRUE, one, old, new)
        for _ in range(_HYSTERESIS.tresca_iterations):
            if inner <= 0.1 * allowed:
                break
            if not solve_stable(one.tangent, one.residual, one.step, floating):
                _assemble_step(springs, rubbing, TRUE, one, old, new)
                modified_newton_step(one.tangent, one.residual, one.step, floating, one.vectors)
            copy(new.z, one.start)
            share = min(1.0, longest / max(largest(one.step), 1e-300))
            for _ in range(_HYSTERESIS.undamped_iterations):
                for j in range(one.step.size):
                    new.z[j] = one.start[j] + share * one.step[j]
                inner, trial = _assemble_step(springs, rubbing, TRUE, one, old, new)
                if trial <= energy + ROUNDING * abs(energy):
                    break
                share *= 0.5
            energy = trial
        norm = _assemble_step(springs, rubbing, FALSE, one, old, new)[0]
        if norm <= allowed:
            break
    return norm


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _solve_pseudo_transient(
    springs: KernelSprings,
    rubbing: Rubbing,
    allowed: float,
    one: _Step,
    old: _ElastoplasticState,
    new: _ElastoplasticState,
) -> float:
    """Solve a step by pseudo-transient continuation with friction along the path; return the residual norm [N].

    Without an equilibrium nearby, parts jump to a distant one, which depends on the friction along the way. A viscous
    drag that is large enough (a short pseudo time step) has a unique solution. `old` and `new` end at the solution.
    """
    floating = RIGID_BODY_STIFFNESS * springs.cam_stiffness
    drag, norm = springs.cam_stiffness, np.inf
    for _ in range(_HYSTERESIS.pseudo_steps):
        one.drag[0] = drag
        _update_slip(springs, rubbing, old)
        if _solve_newton(springs, rubbing, 0.5 * allowed, one, old, new) <= 0.5 * allowed:
            norm = 0.0
            for j in range(one.load.size):
                norm = max(norm, abs(drag * (new.z[j] - old.z[j])))
            _copy_state(new, old)
            if norm <= 0.5 * allowed:
                break
            drag = max(_HYSTERESIS.decrease * drag, floating)
        else:
            norm = np.inf
            drag *= _HYSTERESIS.increase
            if drag > _HYSTERESIS.max_stiffness * springs.cam_stiffness:
                break
    one.drag[0] = floating
    return norm


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _copy_state(of: _ElastoplasticState, to: _ElastoplasticState) -> None:
    """Copy a state except its sliding per unknown."""
    copy(of.z, to.z)
    copy(of.side, to.side)
    copy(of.normal, to.normal)
    copy(of.pressed, to.pressed)
    copy(of.depth, to.depth)


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _update_limits(rubbing: Rubbing, one: _Step, at: _ElastoplasticState, share: float) -> None:
    """Move the friction limits by a share towards those of the normal forces."""
    for i in range(one.side.size):
        spring = at.pressed[i]
        one.normal[i] += share * (rubbing.loss[i] * spring - one.normal[i])
        one.side[i] += share * (rubbing.coefficient[i] * (spring + at.normal[i]) - one.side[i])


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _assemble_step(
    springs: KernelSprings,
    rubbing: Rubbing,
    given: bool,
    one: _Step,
    old: _ElastoplasticState,
    new: _ElastoplasticState,
) -> tuple[float, float]:
    """Assemble residual and tangent at the displacements of `new`; return the residual norm [N] and the energy [J].

    With `given` friction limits there is an energy, and the tangent is symmetric.
    """
    one.work[0] += 1
    number, contacts, z = one.load.size, springs.disc.size, new.z
    drag, energy, gradient = one.drag[0], 0.0, one.gradient
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
        clear(gradient)
        depth = 0.0
        if least_width(springs, FIRST, i, apart, FALSE) == 0.0:
            found = gap_at(springs, FIRST, i, pose, apart, FALSE)
            depth = max(-found.width, 0.0)
            if depth > 0.0:
                gradient[x], gradient[x + 1], gradient[t], gradient[o] = found.normal
        energy += _add_contact(rubbing, given, i, springs.stiffness[0, i], depth, one, old, new)
        if depth == 0.0:
            continue
        force = new.pressed[i] + new.normal[i]
        # geometric stiffness of the rotation of the normal and of the parts, as in `assemble`
        (bx, by, bt, bo), turning = found.tangential, -force * found.rate
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
        clear(gradient)
        if depth > 0.0:
            gradient[x], gradient[y] = -u, -v
        i = contacts + disc
        energy += _add_contact(rubbing, given, i, springs.cam_stiffness, max(depth, 0.0), one, old, new)
        if depth > 0.0:
            across = (new.pressed[i] + new.normal[i]) / depth * around
            one.tangent[x, x] += across * v * v
            one.tangent[y, y] += across * u * u
            one.tangent[x, y] -= across * u * v
            one.tangent[y, x] -= across * u * v
    for e in range(rubbing.drag.size):
        i = contacts + springs.cam_place.shape[1] + e
        energy += _add_friction(rubbing, i, rubbing.drag[e], 0.0, one, old, new)
    return largest(one.residual), energy


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _add_contact(
    rubbing: Rubbing,
    given: bool,
    i: int,
    stiffness: float,
    depth: float,
    one: _Step,
    old: _ElastoplasticState,
    new: _ElastoplasticState,
) -> float:
    """Add a contact with a deflection `depth` [m], its material and its friction; return their energy [J]."""
    spring, backing, loss = stiffness * depth, rubbing.backing[i], rubbing.loss[i]
    new.depth[i], new.pressed[i], new.normal[i] = depth, spring, 0.0
    energy, force, rate = 0.5 * spring * depth, spring, stiffness
    if loss > 0.0:
        most = one.normal[i] if given else loss * spring
        held, more = old.normal[i] + backing * (depth - old.depth[i]), backing
        energy += _slip_energy(held, most, backing)
        if abs(held) > most:
            sign = 1.0 if held > 0.0 else -1.0
            held, more = sign * most, 0.0 if given else sign * loss * stiffness
        new.normal[i] = held
        force, rate = force + held, rate + more
    gradient = one.gradient
    for j in range(gradient.size):
        one.residual[j] += force * gradient[j]
        for m in range(gradient.size):
            one.tangent[j, m] += rate * gradient[j] * gradient[m]
    most, rising = one.side[i], 0.0
    if not given:
        most, rising = rubbing.coefficient[i] * force, rubbing.coefficient[i] * rate
    return energy + _add_friction(rubbing, i, most, rising, one, old, new)


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _add_friction(
    rubbing: Rubbing,
    i: int,
    most: float,
    rate: float,
    one: _Step,
    old: _ElastoplasticState,
    new: _ElastoplasticState,
) -> float:
    """Add the friction of a surface with the limit `most` [N] and its rate by depth [N/m]; return its energy [J]."""
    slip, stick, number = old.slip[i], rubbing.stick[i], one.load.size
    new.side[i] = 0.0
    if not most > 0.0:
        return 0.0
    held = old.side[i]
    for j in range(number):
        held += stick * slip[j] * (new.z[j] - old.z[j])
    energy = _slip_energy(held, most, stick)
    if abs(held) > most:
        sign = 1.0 if held > 0.0 else -1.0
        held = sign * most
        for j in range(number):
            for m in range(number):
                one.tangent[j, m] -= sign * rate * slip[j] * one.gradient[m]
    else:
        for j in range(number):
            for m in range(number):
                one.tangent[j, m] += stick * slip[j] * slip[m]
    new.side[i] = held
    for j in range(number):
        one.residual[j] -= held * slip[j]
    return energy


@njit(cache=cacheable(), nogil=True, error_model="numpy")
def _slip_energy(force: float, most: float, stiffness: float) -> float:
    """Return the energy of a spring with an elastic `force` [N] that slips at `most` [N], including dissipation [J]."""
    size = abs(force)
    return 0.5 * size * size / stiffness if size <= most else most * (size - 0.5 * most) / stiffness
