"""Static equilibria at crank angles in turn: Newton's method, then continuation."""

import math
from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import cacheable, njit
from cycloid_mj.statics.kernel.contacts import FALSE, TRUE, KernelSprings, largest_play
from cycloid_mj.statics.kernel.continuation import allocate_path, solve_by_arclength, solve_scaled
from cycloid_mj.statics.kernel.newton import RESIDUAL_RTOL, Residual, copy, largest, newton
from cycloid_mj.statics.kernel.system import System, allocate_system


class SearchSettings(NamedTuple):
    """Settings of the natural-parameter continuation in stiffness and friction with step halving.

    The continuation, `_solve_with_continuation`, begins with springs so soft that all contacts are closed in spite of
    the clearances: their energy is convex, and Newton's method finds its minimum. Friction is then increased and the
    springs are hardened. Steps are halved until Newton's method converges at their end. If such a path ends, because
    parts snap across their clearances, the springs are hardened first, by descent of the energy, and friction is
    increased afterwards. Without friction, all steps are descents of the energy. The first path then begins at the
    start values of Newton's method, with springs that the load deflects by only 0.02 of the clearance.

    Attributes
    ----------
    short_work, warm_work
        Assemblies of a good start, and of one with a warm-started active set; after more, the next angle is
        warm-started.
    exact_schedule
        First of `_SCHEDULES` that computes the foot point of every tooth.
    damping
        Stiffness that damps Newton steps until friction is complete, relative to the cam's, per relative residual.
    min_step
        Smallest step of a schedule.
    reach
        Largest deflection at which the curves of the contacts are valid, over the eccentricity.
    clearance_steps
        Steps in which clearance grows if a path without friction fails: each a descent of the energy.
    wedged_force, wedged_depth
        Force of a cam over the load, and deflection over the clearance, beyond which friction wedges the parts. A
        deflection beyond the reach under a force that large is wedged too.
    """

    short_work: int = 3
    warm_work: int = 2
    exact_schedule: int = 2
    damping: float = 0.1
    min_step: float = 1e-4
    reach: float = 0.1
    clearance_steps: int = 32
    wedged_force: float = 100.0
    wedged_depth: float = 100.0


_SEARCH = SearchSettings()

_SCHEDULES = (
    (10.0, 1.0, False),
    (1.0, 0.125, False),
    (10.0, 0.03, False),
    (10.0, 0.06, True),
)
"""Continuation schedules in the order in which they are tried.

Deflection of the soft springs at the beginning, in clearances; largest step, as a share of the path; and whether the
springs are hardened before friction is increased.
"""

_FRICTIONLESS_SCHEDULES = (
    (0.02, 0.5, True),
    (1.0, 0.5, True),
    (10.0, 0.125, True),
    (1.0, 0.03, True),
)
"""As `_SCHEDULES`, without friction; the first one begins at the start values of Newton's method."""

PARAMETER_ORDERS = (1.0, -1.0, 0.0)
"""Orders of friction and clearance on the paths of `solve_by_arclength`, followed until one reaches equilibrium.

1: friction, then clearance; -1: the other order; 0: together. Where two branches nearly meet, a step may change over.
"""


def solve_equilibria(springs: KernelSprings, load: Array, z: Array, force: Array, extrapolate: bool) -> Residual:
    """Solve for static equilibrium at every crank angle, by Newton's method and, where it fails, by continuation.

    Parameters
    ----------
    springs
        Contact springs at k crank angles.
    load
        Generalised loads (k, u) [N].
    z
        Start values of the u unknown displacements at each angle (k, u) [m], which are replaced by the solutions.
    force
        Output array for the forces of the n contacts (k, n) [N].
    extrapolate
        Whether only the first row of z is a start value, and the others are extrapolated from the previous equilibria.

    Returns
    -------
    Residual
        Largest relative residual, at most ``RESIDUAL_RTOL``, and how many times the equations were assembled. If an
        angle has no equilibrium, its index and its residual; later angles are then not solved.
    """
    return solve_equilibria_with_paths(springs, load, z, force, extrapolate, allocate_system(springs))


def solve_equilibria_with_paths(
    springs: KernelSprings, load: Array, z: Array, force: Array, extrapolate: bool, system: System
) -> Residual:
    """Solve for static equilibrium at each crank angle by Newton's method, and where that fails by continuation.

    `springs` are the contact springs at k crank angles. `load` (k, u) [N] are the loads on the u unknown displacements.
    `z` (k, u) [m] are start values of the displacements, which are replaced by the solutions. `force` (k, n) [N] is the
    output array for the forces of the n contacts. With `extrapolate`, only the first row of z is a start value.
    `system` is the workspace. Returned are the largest relative residual and how many times the equations were
    assembled. If an angle has no equilibrium, its index and residual are returned, and later angles are not solved.
    """
    residual = solve_equilibria_briefly(springs, load, z, force, extrapolate, 0, system)
    while not residual.force <= RESIDUAL_RTOL:
        k, scale = residual.angle, float(np.abs(load[residual.angle]).max()) or 1.0
        norm = _continue_by_arclength(springs, k, load[k], z[k], residual.force * scale, RESIDUAL_RTOL * scale, system)
        force[k] = system.spring_forces[: force.shape[1]]
        residual = Residual(norm / scale, k, int(system.assembly_count[0]))
        if not residual.force <= RESIDUAL_RTOL or k + 1 == len(load):
            break
        residual = solve_equilibria_briefly(springs, load, z, force, extrapolate, k + 1, system)
    return residual


@njit(cache=cacheable(), allocates=False, nogil=True, error_model="numpy")
def solve_equilibria_briefly(
    springs: KernelSprings,
    load: Array,
    z: Array,
    force: Array,
    extrapolate: bool,
    first_angle: int,
    system: System,
) -> Residual:
    """Solve for static equilibrium at each crank angle from index `first_angle` on, without continuation along a path.

    `springs` are the contact springs, and `load` the generalised loads on the u unknowns. `z` (angles, u) [m] are start
    values of the displacements, which are replaced by the solutions; `force` is the output array for the contact forces
    [N]. The workspace `system` counts the assemblies. If there is no solution at an angle, the result has the index of
    the angle, and `system.path_start` its start values. With `extrapolate` and a `first_angle` above 0, the first
    solution is warm-started as after a difficult angle (`SearchSettings.short_work`), and the count of assemblies
    continues.
    """
    start, largest_norm = system.path_start, 0.0
    was_quick, warm_start = FALSE, extrapolate and first_angle > 0
    if first_angle == 0:
        system.assembly_count[0] = 0
    for k in range(first_angle, len(load)):
        z_k = z[k]
        copy(z_k, start)
        if extrapolate and k:
            _extrapolate_row(z, k, was_quick)
        assemblies_before = system.assembly_count[0]
        load_size = largest(load[k]) or 1.0
        norm = _solve_with_continuation(springs, k, load[k], z_k, start, load_size, warm_start, system) / load_size
        assemblies = system.assembly_count[0] - assemblies_before
        was_quick, warm_start = (
            assemblies <= _SEARCH.short_work + 1,
            extrapolate and assemblies > (_SEARCH.warm_work if warm_start else _SEARCH.short_work),
        )
        copy(system.spring_forces, force[k])
        if not norm <= RESIDUAL_RTOL:
            return Residual(norm, k, system.assembly_count[0])
        largest_norm = max(largest_norm, norm)
    return Residual(largest_norm, len(load) - 1, system.assembly_count[0])


@njit(nogil=True, error_model="numpy", inline="always")
def _extrapolate_row(z: Array, k: int, quadratic: bool) -> None:
    """Replace row `k` of the displacements `z` (angles, unknowns) by their extrapolation from the rows before it.

    The extrapolation is linear, or of the second order if `quadratic` and there are three rows before it.
    """
    for j in range(z.shape[1]):
        z[k, j] = 2.0 * z[k - 1, j] - z[k - 2, j] if k > 1 else z[k - 1, j]
        if quadratic and k > 2:
            z[k, j] += z[k - 1, j] - 2.0 * z[k - 2, j] + z[k - 3, j]


def _is_wedged(springs: KernelSprings, k: int, z: Array, load: float, play: float) -> bool:
    """Return whether friction wedges a cam, so that its deflection by far exceeds that under the load alone.

    `SearchSettings` has the limits. `springs` are the contact springs, `k` is the index of the crank angle, `z` (u,)
    [m] are the u unknown displacements, `load` [N] is the largest component of the load, and `play` [m] the largest
    clearance (`largest_play`).
    """
    valid_range = springs.cam_clearance + _SEARCH.reach * springs.trochoid[1]
    max_deflection = max(
        min(_SEARCH.wedged_depth * play, valid_range), _SEARCH.wedged_force * load / springs.cam_stiffness
    )
    for disc in range(springs.cam_position.shape[1]):
        x = z[3 * disc] - springs.cam_position[k, disc, 0]
        y = z[3 * disc + 1] - springs.cam_position[k, disc, 1]
        if x * x + y * y > max_deflection * max_deflection:
            return True
    return False


_wedges = njit(nogil=True, error_model="numpy", inline="always")(_is_wedged)
"""`_is_wedged` for compiled code."""


@njit(nogil=True, error_model="numpy", inline="always")
def _solve_with_continuation(
    springs: KernelSprings,
    k: int,
    load: Array,
    z: Array,
    start: Array,
    scale: float,
    warm_start: bool,
    system: System,
) -> float:
    """Solve for equilibrium at the crank angle `k` (index) by Newton's method, or if that fails by continuation.

    `springs` are the contact springs, with u unknown displacements. `z` (u,) [m] contains start values of Newton's
    method and is overwritten by the solution; `start` (u,) [m] are the start values of the continuation. `scale` [N] is
    the largest component of the `load` (u,) [N]. With `warm_start`, contacts that carried a force in `system` count as
    closed in the first step of Newton's method. `system` is overwritten. Returns the smallest residual norm [N]: a
    solution if at most `RESIDUAL_RTOL` times `scale`.
    """
    has_friction = springs.friction_per_force.shape[0] > 0
    schedules = _SCHEDULES if has_friction else _FRICTIONLESS_SCHEDULES
    min_factor, friction, factor, parameter, target, step, max_step = 1.0, 1.0, 1.0, 2.0, 2.0, 0.0, 0.0
    attempt, descends, tolerance, smallest_norm = -1, FALSE, RESIDUAL_RTOL * scale, math.inf
    copy(z, system.newton_start)
    while True:
        damping = _SEARCH.damping / scale if attempt >= 0 and friction < 1.0 else 0.0
        use_foot_points = attempt >= _SEARCH.exact_schedule
        norm = newton(
            springs, k, load, z, factor, friction, use_foot_points, tolerance, damping, warm_start, descends, system
        )
        warm_start = FALSE
        if factor == 1.0 and friction == 1.0:
            if has_friction and _wedges(springs, k, z, scale, largest_play(springs)):
                norm = math.inf
            smallest_norm = min(smallest_norm, norm)
        if smallest_norm <= tolerance:
            break
        if norm <= tolerance:
            parameter, step = (target, min(2.0 * step, max_step)) if target > 0.0 else (0.0, max_step)
            copy(z, system.last_solution)
        else:
            step *= 0.5
            copy(system.last_solution, z)
        if not step >= _SEARCH.min_step:
            attempt += 1
            if attempt == len(schedules):
                break
            copy(start if has_friction or attempt else system.newton_start, z)
            copy(z, system.last_solution)
            target, step, parameter = 0.0, 0.0, 0.0
            min_factor = min(1.0, scale / _force_at_deflection(springs, k, schedules[attempt][0]))
        else:
            target = min(parameter + step, 1.0 if parameter < 1.0 else 2.0)
        _, max_step, stiffness_first = schedules[attempt]
        first_share, second_share = min(target, 1.0), max(target - 1.0, 0.0)
        friction, hardening = (second_share, first_share) if stiffness_first else (first_share, second_share)
        factor, descends = min_factor ** (1.0 - hardening), target == 0.0 or (stiffness_first and friction == 0.0)
        friction = friction if has_friction else 1.0
    return smallest_norm


def _continue_by_arclength(
    springs: KernelSprings, k: int, load: Array, z: Array, smallest_norm: float, tolerance: float, system: System
) -> float:
    """Solve for equilibrium at the crank angle `k` (index) by `solve_by_arclength`, after Newton's method failed.

    `springs` are the contact springs at all crank angles, `load` (u,) [N] is the load on the u unknown displacements.
    The solution is written to `z` (u,) [m]. The start values are `system.path_start` (u,). A path is followed for each
    of `PARAMETER_ORDERS`, the orders in which friction and clearance are increased, until one reaches a residual norm
    of at most `tolerance` [N]. Returns the smallest residual norm [N]; `smallest_norm` is the smallest of the earlier
    attempts. A solution in which friction wedges a cam does not count. Without friction, `_grow_clearances` is tried
    last. If no attempt succeeds, `z` need not belong to the returned norm.
    """
    has_friction = springs.friction_per_force.shape[0] > 0
    for order in PARAMETER_ORDERS if has_friction else (0.0,):
        z[:] = system.path_start
        path = allocate_path(springs, z.size, order)
        norm = solve_by_arclength(springs, k, load, z, tolerance, path, system)
        if not (has_friction and _is_wedged(springs, k, z, float(np.abs(load).max()) or 1.0, path.length_unit)):
            smallest_norm = min(smallest_norm, norm)
        if smallest_norm <= tolerance:
            return smallest_norm
    if has_friction:
        return smallest_norm
    return min(smallest_norm, _grow_clearances(springs, k, load, z, tolerance, path.clearance, system))


@njit(cache=cacheable(), allocates=False, nogil=True, error_model="numpy")
def _grow_clearances(
    springs: KernelSprings, k: int, load: Array, z: Array, tolerance: float, clearance: Array, system: System
) -> float:
    """Solve for equilibrium without friction while clearances increase from none to full; return the last norm [N].

    Each step is a descent of the energy until the residual norm is at most `tolerance` [N]. `springs` are the contact
    springs, `k` is the index of the crank angle, and `load` (u,) [N] the generalised load on the u unknowns. `z` (u,)
    [m] has start values and ends at the solution. `clearance` (n,) [m] and `system` are workspace.
    """
    norm, steps = math.inf, _SEARCH.clearance_steps
    for step in range(steps + 1):
        norm = solve_scaled(springs, step / steps, 0.0, k, load, z, tolerance, TRUE, clearance, system)
    return norm


@njit(nogil=True, error_model="numpy", inline="always")
def _force_at_deflection(springs: KernelSprings, k: int, clearance_count: float) -> float:
    """Compute the force [N] that deflects the stiffest contact or cam by a multiple of the largest clearance.

    The multiple is `clearance_count`. The deflection is limited to the range in which the curves of the contacts are
    valid. `springs` are the contact springs, and `k` is the index of the crank angle.
    """
    reach, stiffness = _SEARCH.reach * springs.trochoid[1], 0.0
    for i in range(springs.disc.size):
        stiffness = max(stiffness, springs.stiffness[k, i])
    return min(
        max(stiffness, springs.cam_stiffness) * min(clearance_count * largest_play(springs), reach), stiffness * reach
    )
