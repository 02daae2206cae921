"""Semismooth Newton method for the static equilibrium, and the linear solvers of its steps."""

import math
from typing import NamedTuple

from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import njit
from cycloid_mj.statics.kernel.contacts import FALSE, KernelSprings
from cycloid_mj.statics.kernel.system import System, assemble

RESIDUAL_RTOL = 1e-8
"""Largest residual of an equilibrium, relative to the largest load."""

PATH_RESIDUAL_RTOL = 1e-6
"""Largest residual of a step along a path, relative to the largest load of the path."""

RIGID_BODY_STIFFNESS = 1e-9
"""Stiffness that regularizes rigid-body modes of floating parts, relative to that of the cam."""

ROUNDING = 1e-12
"""Relative increase of the energy that counts as rounding: near an equilibrium it is flat."""


class NewtonSettings(NamedTuple):
    """Settings of the semismooth Newton method with warm-started active set and Armijo backtracking (`newton`).

    Hintermueller, Ito & Kunisch, SIAM J. Optim. 13 (2002), 865-888; Nocedal & Wright, Numerical Optimization, 2006,
    3.1 and 3.4.

    Attributes
    ----------
    steps_per_disc, descent_steps
        Largest number of steps for each disc, and of a descent of the energy.
    max_step
        Largest component of a step, relative to the eccentricity.
    overshoot
        Rise of the energy after a warm-started step, relative to its fall before, from which on the step is shortened
        to the minimum of the quadratic model: contacts that close on the way push back.
    armijo_slope
        Share of the fall predicted by the slope that a descent step must reach.
    min_stiffness
        Smallest eigenvalue of the modified Hessian of a descent step, relative to the stiffness of the cam.
    """

    steps_per_disc: int = 15
    descent_steps: int = 200
    max_step: float = 0.3
    overshoot: float = 10.0
    armijo_slope: float = 0.01
    min_stiffness: float = 1e-6


_NEWTON = NewtonSettings()


class Residual(NamedTuple):
    """Result of a solution: the residual `force`, relative to the largest load, at the `angle` of a number.

    `work` is the number of assemblies.
    """

    force: float
    angle: int
    work: int


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def newton(
    springs: KernelSprings,
    k: int,
    load: Array,
    here: Array,
    soft: float,
    friction: float,
    exact: bool,
    allowed: float,
    damping: float,
    warm_start: bool,
    descend: bool,
    system: System,
) -> float:
    """Solve for the displacements `here` (u,) [m] by Newton's method from their values; return the residual norm [N].

    For `soft` springs and a share of the friction see `assemble`. With `warm_start`, contacts that carried a force
    count as closed in the first step (warm-started active set). With `descend`, without friction, steps are shortened
    until the energy falls (Armijo backtracking).
    """
    hard, longest = soft * springs.cam_stiffness, _NEWTON.max_step * springs.trochoid[1]
    residual, step, start, number = system.residual, system.step, system.start, here.size
    norm, energy, share, fall = math.inf, math.inf, 1.0, math.inf
    use_line_search = warm_start and springs.rubbing.shape[0] == 0
    for i in range(system.warm.size):
        system.warm[i] = warm_start and system.pressed[i] > 0.0
    for step_number in range(_NEWTON.descent_steps if descend else springs.cam_place.shape[1] * _NEWTON.steps_per_disc):
        trial = assemble(springs, k, load, here, soft, friction, exact, step_number == 0, system)
        norm = largest(residual)
        if not norm < math.inf:
            break
        slope = _product(step, residual)
        bound = energy - _NEWTON.armijo_slope * share * fall + ROUNDING * abs(energy)
        if descend and trial > bound and share > ROUNDING:
            share *= 0.5
        elif use_line_search and norm > allowed and -slope > _NEWTON.overshoot * abs(fall):
            share = max(share + slope / max(_curvature(system.tangent, step), 1e-300), 0.0)
        else:
            if norm <= allowed and not warm_start:
                return norm
            energy = trial
            if descend:
                modified_newton_step(system.tangent, residual, step, _NEWTON.min_stiffness * hard, system.vectors)
            elif solve(system.tangent, residual, step, RIGID_BODY_STIFFNESS * hard + damping * norm * hard) == 0.0:
                break
            share, fall = min(1.0, longest / max(largest(step), 1e-300)), _product(step, residual)
            copy(here, start)
        for j in range(number):
            here[j] = start[j] + share * step[j]
        for i in range(system.warm.size if warm_start else 0):
            system.warm[i] = False
        warm_start = FALSE
    return norm


@njit(nogil=True, error_model="numpy", inline="always")
def _product(step: Array, values: Array) -> float:
    """Compute the scalar product of two vectors (u,)."""
    total = 0.0
    for j in range(step.size):
        total += step[j] * values[j]
    return total


@njit(nogil=True, error_model="numpy", inline="always")
def _curvature(stiffness: Array, step: Array) -> float:
    """Compute the quadratic form of a stiffness (u, u) [N/m] and a step (u,) [m], [J]."""
    total = 0.0
    for j in range(step.size):
        total += step[j] * _product(step, stiffness[j])
    return total


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def solve(matrix: Array, right: Array, out: Array, floating: float) -> float:
    """Solve a linear system by Gaussian elimination with pivoting, in place; return the sign of its determinant, or 0.

    The stiffness `floating` is added to the diagonal (regularization of rigid-body modes). `out` may be `right`.
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


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def solve_stable(matrix: Array, right: Array, out: Array, floating: float) -> bool:
    """Solve a symmetric system by Cholesky factorization of its lower half, in place; return whether it is definite."""
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


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def modified_newton_step(matrix: Array, right: Array, out: Array, floating: float, vectors: Array) -> None:
    """Solve a symmetric system with the absolute values of its eigenvalues, at least `floating`: a descent direction.

    In place, with workspace `vectors` (u, u). A Cholesky factorization replaces the eigenvalues if all exceed
    `floating`.
    """
    number = right.size
    for i in range(number):
        copy(matrix[i], vectors[i])
        vectors[i, i] -= floating
    if solve_stable(vectors, right, out, 0.0):
        solve_stable(matrix, right, out, 0.0)
        return
    _find_eigenvectors(matrix, vectors)
    clear(out)
    for m in range(number):
        along = 0.0
        for j in range(number):
            along += vectors[j, m] * right[j]
        for j in range(number):
            out[j] += along / max(abs(matrix[m, m]), floating) * vectors[j, m]


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _find_eigenvectors(matrix: Array, vectors: Array) -> None:
    """Compute the eigenvectors of a symmetric matrix as columns, by Jacobi rotations; its diagonal becomes the values.

    Golub & Van Loan, Matrix Computations, 8.5. NumPy's function would import SciPy, a quarter of a second per command.
    """
    number, least = len(matrix), 0.0
    for i in range(number):
        least = max(least, ROUNDING * largest(matrix[i]))
    for i in range(number):
        clear(vectors[i])
        vectors[i, i] = 1.0
    rotated = True
    while rotated:
        rotated = False
        for p in range(number - 1):
            for q in range(p + 1, number):
                beside = matrix[p, q]
                if not abs(beside) > least:
                    continue
                rotated = True
                slant = (matrix[q, q] - matrix[p, p]) / (2.0 * beside)
                tangent = math.copysign(1.0, slant) / (abs(slant) + math.hypot(1.0, slant))
                cos = 1.0 / math.hypot(1.0, tangent)
                sin = tangent * cos
                for i in range(number):
                    first, second = matrix[i, p], matrix[i, q]
                    matrix[i, p], matrix[i, q] = cos * first - sin * second, sin * first + cos * second
                    first, second = vectors[i, p], vectors[i, q]
                    vectors[i, p], vectors[i, q] = cos * first - sin * second, sin * first + cos * second
                for i in range(number):
                    first, second = matrix[p, i], matrix[q, i]
                    matrix[p, i], matrix[q, i] = cos * first - sin * second, sin * first + cos * second


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def largest(values: Array) -> float:
    """Return the largest absolute value."""
    largest = 0.0
    for j in range(values.size):
        largest = max(largest, abs(values[j]))
    return largest


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def copy(values: Array, to: Array) -> None:
    """Copy values (m,) to an array; numba takes a second to compile an assignment, for its error message."""
    for j in range(to.size):
        to[j] = values[j]


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def clear(values: Array) -> None:
    """Set an array (m,) to 0."""
    for j in range(values.size):
        values[j] = 0.0
