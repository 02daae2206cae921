"""Pseudo-arclength continuation from parts without clearance and friction to an equilibrium with both."""

import math
from typing import NamedTuple

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import cacheable, njit
from cycloid_mj.statics.kernel.contacts import FALSE, TRUE, KernelSprings, scale_clearances
from cycloid_mj.statics.kernel.newton import (
    PATH_RESIDUAL_RTOL,
    RESIDUAL_RTOL,
    RIGID_BODY_STIFFNESS,
    clear,
    copy,
    largest,
    newton,
    solve_linear,
)
from cycloid_mj.statics.kernel.system import CONTACT_STIFFNESS, System, assemble, cam_at


class ContinuationSettings(NamedTuple):
    """Settings of the pseudo-arclength continuation (`solve_by_arclength`); lengths in clearances.

    Keller, in: Applications of Bifurcation Theory, 1977, 359-384; Allgower & Georg, Numerical Continuation Methods,
    1990, chapters 2 and 12. The nearly jammed drives of ``tests/statics/test_random.py`` need it.

    Attributes
    ----------
    max_points
        Largest number of points of a path.
    max_corrections
        Newton steps of the corrector.
    max_deviation
        Largest distance of the corrected point from the predictor, over the length of the step.
    min_step
        Length of a step below which the path has a corner: a contact opens or closes.
    max_distance
        Largest distance of a path from its beginning, over clearances, first deflections and an eccentricity: beyond
        it, friction jams.
    corner_step
        Length of a step up to which a path may go around a corner. A path that is this close to its beginning again is
        lost in wedged parts.
    corner_deviation
        `max_deviation` of such a step.
    """

    max_points: int = 5000
    max_corrections: int = 8
    max_deviation: float = 0.3
    min_step: float = 1e-8
    max_distance: float = 10.0
    corner_step: float = 1e-3
    corner_deviation: float = 3.0


_CONTINUATION = ContinuationSettings()


class Path(NamedTuple):
    """Workspace of a continuation path with an `order` of its parameters (`search.PARAMETER_ORDERS`).

    Its points are the u displacements over a `length_unit` [m], and the parameter [1]. `point`, the `next_point`, the
    unit `tangent`, the `previous_tangent` and that at a corner, the Newton `step`, the `residual` and the unit vector
    `last_axis` have shape (u + 1,). `clearance` (n,) [m] are the clearances at a point, `rate` (u,) [N] is the
    derivative of the residual by the parameter, and `matrix` (u + 1, u + 1) that of the augmented system.
    """

    order: float
    length_unit: float
    clearance: Array
    point: Array
    next_point: Array
    tangent: Array
    previous_tangent: Array
    corner_tangent: Array
    step: Array
    residual: Array
    last_axis: Array
    rate: Array
    matrix: Array


@njit(cache=cacheable(), allocates=False, nogil=True, error_model="numpy")
def solve_by_arclength(
    springs: KernelSprings, k: int, load: Array, z: Array, tolerance: float, path: Path, system: System
) -> float:
    """Solve for u displacements `z` [m] by pseudo-arclength continuation in friction and clearance.

    `springs` are the contact springs at all crank angles, `k` is the index of an angle, and `load` (u,) [N] the
    generalised load. `tolerance` [N] is the residual norm of a solution. `z` is an output array. `path` is a result of
    `allocate_path`; `path` and `system` are overwritten. Returns the residual norm [N]: infinity if the path ends
    before full friction and clearance, or if friction wedges parts.

    Notes
    -----
    The path begins at parts without clearance and friction, whose energy is convex, so that Newton's method finds their
    only equilibrium. It cannot return there: either it reaches the full friction and clearance, or forces grow until
    friction wedges the parts. The continuation uses the arc length, as the path turns back where parts snap across
    their clearances. The path has a corner where a contact opens or closes. Beyond it, the continuation keeps the sign
    of the determinant (Allgower & Georg, Numerical Continuation Methods, 1990, chapters 2 and 12).
    """
    unknown_count, end_parameter = z.size, 1.0 + abs(path.order)
    point, next_point, path_tolerance = path.point, path.next_point, PATH_RESIDUAL_RTOL / RESIDUAL_RTOL * tolerance
    solve_scaled(springs, 0.0, 0.0, k, load, z, tolerance, TRUE, path.clearance, system)
    for j in range(unknown_count):
        point[j] = z[j] / path.length_unit
    path.tangent[unknown_count] = path.last_axis[unknown_count] = 1.0
    norm, length = augmented_residual(springs, k, load, point, path, system), 0.5
    sign = _update_tangent(springs, k, load, point, 1.0, path, system)
    for j in range(unknown_count + 1):
        path.tangent[j] *= sign
    farthest = _CONTINUATION.max_distance * (1.0 + largest(point)) + springs.trochoid[1] / path.length_unit
    for _ in range(_CONTINUATION.max_points if norm <= path_tolerance else 0):
        if not _predict_and_correct(springs, k, load, length, sign, path_tolerance, path, system):
            length *= 0.5
            if length > _CONTINUATION.min_step:
                continue
            length = _pass_corner(springs, k, load, sign, path_tolerance, path, system)
            if length == 0.0:
                break
        if next_point[unknown_count] >= end_parameter:
            share = (end_parameter - point[unknown_count]) / (next_point[unknown_count] - point[unknown_count])
            for j in range(unknown_count):
                z[j] = (point[j] + share * (next_point[j] - point[j])) * path.length_unit
            norm = solve_scaled(springs, 1.0, 1.0, k, load, z, tolerance, FALSE, path.clearance, system)
            if norm <= tolerance:
                return norm
            copy(path.previous_tangent, path.tangent)
            length *= 0.5
            continue
        copy(next_point, point)
        if largest(point) > farthest or (
            point[unknown_count] < _CONTINUATION.corner_step and path.tangent[unknown_count] < 0.0
        ):
            break
        length *= 2.0
    return math.inf


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def solve_scaled(
    springs: KernelSprings,
    clearance: float,
    friction: float,
    k: int,
    load: Array,
    z: Array,
    tolerance: float,
    use_backtracking: bool,
    scaled_clearance: Array,
    system: System,
) -> float:
    """Solve for equilibrium with scaled clearances and friction by Newton's method; return the residual norm [N].

    The foot point of every tooth is computed. The method is the same as in `newton`, but without damping and warm
    start.

    Parameters
    ----------
    springs, k, load
        Contact springs, index of the crank angle, and generalised load on the u unknown displacements (u,) [N].
    z
        Start values of the u unknown displacements [m], which are replaced by the solution.
    tolerance, use_backtracking
        Residual norm of a solution [N], and whether steps are halved until the energy falls.
    system
        Residual, tangent and workspace, which are overwritten.
    clearance, friction
        Factors on all clearances (`scale_clearances`) and on the friction [1].
    scaled_clearance
        Workspace for the clearances of the n contacts (n,) [m].

    Notes
    -----
    This function is compiled once, unlike `newton`, which is compiled into each of its callers.
    """
    scaled_springs = scale_clearances(springs, clearance, scaled_clearance)
    return newton(scaled_springs, k, load, z, 1.0, friction, TRUE, tolerance, 0.0, FALSE, use_backtracking, system)


@njit(nogil=True, error_model="numpy", inline="always")
def _continuation_factors(order: float, parameter: float) -> tuple[float, float]:
    """Return the factors on friction and clearance [1] at a `parameter` of the continuation; above 1 beyond its end.

    If `order` is 1, friction grows at parameters from 0 to 1, then clearance at parameters from 1 to 2. If it is -1,
    clearance grows first. If it is 0, both grow together at parameters from 0 to 1.
    """
    if order == 0.0:
        return parameter, parameter
    first_factor, second_factor = min(parameter, 1.0), max(parameter - 1.0, 0.0)
    return (first_factor, second_factor) if order > 0.0 else (second_factor, first_factor)


def allocate_path(springs: KernelSprings, unknown_count: int, order: float) -> Path:
    """Allocate the workspace of a continuation path.

    The unit of length of the path is the largest clearance of all contacts and cams, at least 1 um.

    Parameters
    ----------
    springs
        Contact springs at all crank angles.
    unknown_count
        Number of displacements.
    order
        Order in which friction and clearance grow along the path, see `search.PARAMETER_ORDERS`.
    """
    return Path(
        order,
        float(max(abs(springs.cam_clearance), 1e-6, springs.clearance.max())),
        np.zeros(springs.disc.size),
        np.zeros(unknown_count + 1),
        np.zeros(unknown_count + 1),
        np.zeros(unknown_count + 1),
        np.zeros(unknown_count + 1),
        np.zeros(unknown_count + 1),
        np.zeros(unknown_count + 1),
        np.zeros(unknown_count + 1),
        np.zeros(unknown_count + 1),
        np.zeros(unknown_count),
        np.zeros((unknown_count + 1, unknown_count + 1)),
    )


@njit(cache=cacheable(), allocates=False, nogil=True, error_model="numpy")
def augmented_residual(springs: KernelSprings, k: int, load: Array, point: Array, path: Path, system: System) -> float:
    """Write the residual at a point of a continuation path, and its derivatives, to `path`; return its norm [N].

    The `point` (u + 1,) consists of the displacements over `path.length_unit`, and the parameter. The residual forces
    of equilibrium are written to ``path.residual``, their derivatives by the elements of `point` to ``path.matrix``.
    `system` is workspace. `springs` are the contact springs, `k` is the index of the crank angle, and `load` (u,) [N]
    the generalised load on the u unknowns.
    """
    unknown_count, matrix, residual, z = load.size, path.matrix, system.residual, system.last_solution
    for j in range(unknown_count):
        z[j] = point[j] * path.length_unit
    parameter, rate, order = point[unknown_count], path.rate, path.order
    friction, clearance = _continuation_factors(order, parameter)
    scaled_springs = scale_clearances(springs, clearance, path.clearance)
    friction_grows = (parameter < 1.0) == (order > 0.0)
    # with more friction for the rate, and at the point: a second call would be compiled once more
    for is_at_point in range(0 if order == 0.0 or friction_grows else 1, 2):
        for j in range(unknown_count):
            path.residual[j] = residual[j]
        assemble(scaled_springs, k, load, z, 1.0, friction + (1 - is_at_point), TRUE, TRUE, system)
    clear(rate)
    if order == 0.0 or friction_grows:
        for j in range(unknown_count):
            rate[j] = path.residual[j] - residual[j]
    if order == 0.0 or not friction_grows:
        _add_clearance_rate(springs, scaled_springs, k, z, friction, rate, system)
    for j in range(unknown_count):
        path.residual[j] = residual[j]
        for column in range(unknown_count):
            matrix[j, column] = system.tangent[j, column] * path.length_unit
        matrix[j, j] += RIGID_BODY_STIFFNESS * springs.cam_stiffness * path.length_unit
        matrix[j, unknown_count] = -path.rate[j]
    return largest(residual)


@njit(nogil=True, error_model="numpy", inline="always")
def _add_clearance_rate(
    springs: KernelSprings,
    scaled_springs: KernelSprings,
    k: int,
    z: Array,
    friction: float,
    rate: Array,
    system: System,
) -> None:
    """Add the derivative of the contact forces by the clearance to `rate` [N], shape (u,), for a continuation step.

    The continuation multiplies all clearances by a factor from 0 to 1; the derivative of the generalised forces on the
    u unknown displacements is taken by this factor.

    Parameters
    ----------
    springs, scaled_springs
        Contact springs with their full clearances, and with clearances multiplied by the factor at this step.
    k, z
        Index of the crank angle, and displacements [m].
    friction
        Factor on the friction coefficients [1].
    system
        Forces and gradients of the contacts at `z`.
    """
    unknown_count, has_friction = z.size, springs.friction_per_force.shape[0] > 0
    for i in range(springs.disc.size):
        if system.spring_forces[i] == 0.0:
            continue
        for component in range(4):
            unknown = 3 * springs.disc[i] + component if component < 3 else unknown_count - 1
            friction_rate = friction * springs.friction_per_force[k, i, unknown] if has_friction else 0.0
            rate[unknown] -= (
                system.row[i, CONTACT_STIFFNESS] * springs.clearance[i] * (system.row[i, component] + friction_rate)
            )
    for disc in range(springs.cam_position.shape[1]):
        contact = cam_at(scaled_springs, k, disc, z)
        if contact.total_depth > 0.0 and springs.cam_clearance > 0.0:
            force_rate = springs.cam_stiffness * springs.cam_clearance
            rate[3 * disc] += force_rate * contact.u
            rate[3 * disc + 1] += force_rate * contact.v
            if has_friction:
                lateral_rate = friction * springs.cam_lateral * force_rate
                rate[3 * disc] -= lateral_rate * contact.v
                rate[3 * disc + 1] += lateral_rate * contact.u
                rate[3 * disc + 2] -= friction * springs.cam_friction_per_force * force_rate


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _update_tangent(
    springs: KernelSprings, k: int, load: Array, point: Array, sign: float, path: Path, system: System
) -> float:
    """Write the unit tangent of the continuation path at a `point`; return the sign of the determinant there.

    The tangent is written to ``path.tangent``; `system` is workspace. The determinant is that of the derivatives of the
    residual with the old tangent as last row; if it is 0, the tangent is unchanged. The tangent points forwards along
    the path, by `sign`, the sign of the determinant at the beginning of the path. `springs` are the contact springs,
    `k` is the index of the crank angle, and `load` (u,) [N] the generalised load on the u unknowns.
    """
    unknown_count = load.size
    augmented_residual(springs, k, load, point, path, system)
    copy(path.tangent, path.matrix[unknown_count])
    determinant = solve_linear(path.matrix, path.last_axis, path.step, 0.0)
    length = 0.0
    for j in range(unknown_count + 1):
        length += path.step[j] * path.step[j]
    length = math.sqrt(length)
    if determinant != 0.0 and length < math.inf:
        for j in range(unknown_count + 1):
            path.tangent[j] = path.step[j] * (determinant * sign / length)
    return determinant


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _predict_and_correct(
    springs: KernelSprings,
    k: int,
    load: Array,
    length: float,
    sign: float,
    tolerance: float,
    path: Path,
    system: System,
) -> bool:
    """Compute the next point of a continuation path and its tangent; return whether this succeeds.

    `path.next_point` is at the arc length `length` [1] from `path.point` (Euler predictor, Newton corrector). `system`
    is workspace.

    The step fails if the corrector does not converge, if the tangent is not unique, or if the new point is not ahead of
    the old one along the new tangent. The tangent is then unchanged. `sign` is the sign at the beginning of the path of
    the determinant that `_update_tangent` returns, `tolerance` [N] is the residual norm of a solution, `k` the index of
    the crank angle, and `load` (u,) [N] the generalised load.
    """
    copy(path.tangent, path.previous_tangent)
    if not _correct_point(springs, k, load, length, tolerance, path, system):
        return False
    determinant, advance = _update_tangent(springs, k, load, path.next_point, sign, path, system), 0.0
    for j in range(load.size + 1):
        advance += path.tangent[j] * (path.next_point[j] - path.point[j])
    if determinant == 0.0 or not advance > 0.0:
        copy(path.previous_tangent, path.tangent)
        return False
    return True


@njit(nogil=True, error_model="numpy", inline="always")
def _correct_point(
    springs: KernelSprings, k: int, load: Array, length: float, tolerance: float, path: Path, system: System
) -> bool:
    """Compute the next point of a continuation path by Newton's method (corrector); return whether it converges.

    `system` is workspace. `path.next_point` is at the arc length `length` [1] from `path.point`. The predictor is the
    point at this length along `path.tangent`. The method fails if the residual norm stays above `tolerance` [N], or if
    the new point is too far from the predictor. `springs` are the contact springs, `k` is the index of the crank angle,
    and `load` (u,) [N] the generalised load on the u unknowns.
    """
    unknown_count, point, next_point, tangent, residual = (
        load.size,
        path.point,
        path.next_point,
        path.tangent,
        path.residual,
    )
    is_corner = length <= _CONTINUATION.corner_step
    max_deviation = _CONTINUATION.corner_deviation if is_corner else _CONTINUATION.max_deviation
    for j in range(unknown_count + 1):
        next_point[j] = point[j] + length * tangent[j]
    for _ in range(_CONTINUATION.max_corrections):
        if augmented_residual(springs, k, load, next_point, path, system) <= tolerance:
            return True
        copy(tangent, path.matrix[unknown_count])
        residual[unknown_count] = length
        for j in range(unknown_count + 1):
            residual[unknown_count] -= tangent[j] * (next_point[j] - point[j])
        if solve_linear(path.matrix, residual, path.step, 0.0) == 0.0:
            return False
        deviation = 0.0
        for j in range(unknown_count + 1):
            next_point[j] += path.step[j]
            deviation += (next_point[j] - point[j] - length * tangent[j]) ** 2
        if not deviation < (max_deviation * length) ** 2:
            return False
    return False


@njit(nogil=True, error_model="numpy", inline="always")
def _pass_corner(
    springs: KernelSprings, k: int, load: Array, sign: float, tolerance: float, path: Path, system: System
) -> float:
    """Write a point of the continuation path beyond a corner to `path.next_point`; return the step length [1], or 0.

    At a corner, a contact opens or closes and the path may turn back. Tangents are computed at distances of 1e-7 to
    1e-3 ahead of `path.point`. Along each, steps of 1e-2 to 1e-6 are tried. `springs` are the contact springs, `k` is
    the index of the crank angle, `load` (u,) [N] the generalised load on the u unknowns, `sign` the sign of the
    determinant at the beginning of the path, `tolerance` [N] the residual norm of a solution, and `system` workspace.
    """
    unknown_count = load.size
    tangent = path.corner_tangent
    copy(path.tangent, tangent)
    for power in range(-7, -2):
        for j in range(unknown_count + 1):
            path.next_point[j] = path.point[j] + 10.0**power * tangent[j]
        if _update_tangent(springs, k, load, path.next_point, sign, path, system) != 0.0:
            for shorter in range(2, 7):
                if _predict_and_correct(springs, k, load, 10.0**-shorter, sign, tolerance, path, system):
                    return 10.0**-shorter
        copy(tangent, path.tangent)
    return 0.0
