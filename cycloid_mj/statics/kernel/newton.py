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
        to the minimum of the quadratic model: contacts that close during the step push back.
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
    """Result of a solution at one or more crank angles.

    `force` is the residual force over the largest load [1], `angle` the index of the crank angle that failed, or of the
    last angle, and `work` the number of assemblies of the equations.
    """

    force: float
    angle: int
    work: int


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def newton(
    springs: KernelSprings,
    k: int,
    load: Array,
    z: Array,
    stiffness_factor: float,
    friction: float,
    use_foot_points: bool,
    tolerance: float,
    damping: float,
    warm_start: bool,
    use_backtracking: bool,
    system: System,
) -> float:
    """Solve for the displacements of static equilibrium at a crank angle by a semismooth Newton method.

    Parameters
    ----------
    springs, k, load
        Contact springs, index of the crank angle, and generalised load on the u unknown displacements (u,) [N].
    z
        Start values of the u unknown displacements [m], which are replaced by the solution.
    stiffness_factor, friction
        Factors on all stiffnesses and on the friction [1]: 1 and 1 for the equilibrium, other values on the way to it.
    use_foot_points
        Whether the foot point of every tooth is computed, instead of the third-order expansion.
    tolerance
        Residual norm of a solution [N].
    damping
        Stiffness added to the tangent, divided by the stiffness of the cam and the residual norm [1/N].
    warm_start
        Whether contacts that carried a force count as closed in the first step (warm-started active set). Without
        friction, a step along which the energy then rises steeply is changed to the minimum of the quadratic model.
    use_backtracking
        Whether steps are halved until the energy falls (Armijo), along descent directions; only without friction.
    system
        Residual, tangent and workspace, which are overwritten.

    Returns
    -------
    float
        Largest residual force [N] when it was last evaluated: at the solution, or above `tolerance` if the method
        fails. If it fails by the number of steps, `z` is one step further.
    """
    cam_stiffness, max_length = stiffness_factor * springs.cam_stiffness, _NEWTON.max_step * springs.trochoid[1]
    residual, step, start, unknown_count = system.residual, system.step, system.start, z.size
    norm, energy, step_share, predicted_decrease = math.inf, math.inf, 1.0, math.inf
    use_line_search = warm_start and springs.friction_per_force.shape[0] == 0
    for i in range(system.kept_closed.size):
        system.kept_closed[i] = warm_start and system.spring_forces[i] > 0.0
    for step_number in range(
        _NEWTON.descent_steps if use_backtracking else springs.cam_position.shape[1] * _NEWTON.steps_per_disc
    ):
        new_energy = assemble(
            springs, k, load, z, stiffness_factor, friction, use_foot_points, step_number == 0, system
        )
        norm = largest(residual)
        if not norm < math.inf:
            break
        energy_slope = _product(step, residual)
        max_energy = energy - _NEWTON.armijo_slope * step_share * predicted_decrease + ROUNDING * abs(energy)
        if use_backtracking and new_energy > max_energy and step_share > ROUNDING:
            step_share *= 0.5
        elif use_line_search and norm > tolerance and -energy_slope > _NEWTON.overshoot * abs(predicted_decrease):
            step_share = max(step_share + energy_slope / max(_quadratic_form(system.tangent, step), 1e-300), 0.0)
        else:
            if norm <= tolerance and not warm_start:
                return norm
            energy = new_energy
            if not _compute_step(use_backtracking, cam_stiffness, damping * norm * cam_stiffness, system):
                break
            step_share, predicted_decrease = min(1.0, max_length / max(largest(step), 1e-300)), _product(step, residual)
            copy(z, start)
        for j in range(unknown_count):
            z[j] = start[j] + step_share * step[j]
        for i in range(system.kept_closed.size if warm_start else 0):
            system.kept_closed[i] = False
        warm_start = FALSE
    return norm


@njit(nogil=True, error_model="numpy", inline="always")
def _compute_step(use_backtracking: bool, cam_stiffness: float, damping: float, system: System) -> bool:
    """Write the Newton step of the u unknowns [m] to ``system.step``; return False if the tangent is singular.

    With `use_backtracking`, the step is a descent direction from the modified Hessian, whose eigenvalues are at least a
    small share of `cam_stiffness` [N/m]. If not, `damping` [N/m] is added to the diagonal of the tangent. The tangent
    is overwritten.
    """
    tangent, residual, step = system.tangent, system.residual, system.step
    if use_backtracking:
        modified_newton_step(tangent, residual, step, _NEWTON.min_stiffness * cam_stiffness, system.vectors)
        return True
    return solve_linear(tangent, residual, step, RIGID_BODY_STIFFNESS * cam_stiffness + damping) != 0.0


@njit(nogil=True, error_model="numpy", inline="always")
def _product(direction: Array, values: Array) -> float:
    """Compute the scalar product of two vectors (u,)."""
    total = 0.0
    for j in range(direction.size):
        total += direction[j] * values[j]
    return total


@njit(nogil=True, error_model="numpy", inline="always")
def _quadratic_form(stiffness: Array, direction: Array) -> float:
    """Compute the quadratic form of a stiffness (u, u) [N/m] and a direction (u,) [m], [J]."""
    total = 0.0
    for j in range(direction.size):
        total += direction[j] * _product(direction, stiffness[j])
    return total


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def solve_linear(matrix: Array, right_side: Array, solution: Array, diagonal: float) -> float:
    """Solve the linear system `matrix` x = `right_side` of u equations by Gaussian elimination with pivoting.

    The matrix has the shape (u, u). The solution x is written to `solution` (u,), which may be `right_side` itself; the
    matrix is overwritten. `diagonal` is first added to the diagonal of the matrix (regularization of rigid-body modes).
    Returns the sign of the determinant, or 0 if the matrix is singular.
    """
    unknown_count, sign = right_side.size, 1.0
    for j in range(unknown_count):
        matrix[j, j] += diagonal
        solution[j] = right_side[j]
    for j in range(unknown_count):
        pivot = j
        for i in range(j + 1, unknown_count):
            if abs(matrix[i, j]) > abs(matrix[pivot, j]):
                pivot = i
        if pivot != j:
            sign = -sign
            solution[j], solution[pivot] = solution[pivot], solution[j]
            for column in range(j, unknown_count):
                matrix[j, column], matrix[pivot, column] = matrix[pivot, column], matrix[j, column]
        if not abs(matrix[j, j]) > 0.0:
            return 0.0
        sign = sign if matrix[j, j] > 0.0 else -sign
        inverse = 1.0 / matrix[j, j]
        for i in range(j + 1, unknown_count):
            factor = matrix[i, j] * inverse
            if factor == 0.0:
                continue
            for column in range(j + 1, unknown_count):
                matrix[i, column] -= factor * matrix[j, column]
            solution[i] -= factor * solution[j]
    for j in range(unknown_count - 1, -1, -1):
        remainder = solution[j]
        for column in range(j + 1, unknown_count):
            remainder -= matrix[j, column] * solution[column]
        solution[j] = remainder / matrix[j, j]
    return sign


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def solve_cholesky(matrix: Array, right_side: Array, solution: Array, diagonal: float) -> bool:
    """Solve a symmetric linear system of u equations by Cholesky factorization; return whether it is positive definite.

    Only the lower half of the `matrix` (u, u) is read and overwritten; `diagonal` is added to its diagonal. The
    solution of `matrix` times x = `right_side` (u,) is written to `solution` (u,), which may be `right_side` itself.
    """
    unknown_count = right_side.size
    for j in range(unknown_count):
        pivot = matrix[j, j] + diagonal
        for column in range(j):
            pivot -= matrix[j, column] * matrix[j, column]
        if not pivot > 0.5 * diagonal:
            return False
        pivot = math.sqrt(pivot)
        matrix[j, j] = pivot
        for i in range(j + 1, unknown_count):
            remainder = matrix[i, j]
            for column in range(j):
                remainder -= matrix[i, column] * matrix[j, column]
            matrix[i, j] = remainder / pivot
    for i in range(unknown_count):
        remainder = right_side[i]
        for column in range(i):
            remainder -= matrix[i, column] * solution[column]
        solution[i] = remainder / matrix[i, i]
    for i in range(unknown_count - 1, -1, -1):
        remainder = solution[i]
        for column in range(i + 1, unknown_count):
            remainder -= matrix[column, i] * solution[column]
        solution[i] = remainder / matrix[i, i]
    return True


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def modified_newton_step(
    matrix: Array, residual: Array, direction: Array, min_eigenvalue: float, vectors: Array
) -> None:
    """Compute a descent `direction` from a `residual` and a symmetric `matrix`, which may be indefinite.

    There are u unknowns: direction and residual have the shape (u,), the matrix (u, u). The eigenvalues of the matrix
    are replaced by their absolute values, at least `min_eigenvalue`, and the residual is multiplied by the inverse. If
    all eigenvalues exceed this minimum, a Cholesky factorization suffices. The matrix is overwritten; `vectors` (u, u)
    is workspace.
    """
    unknown_count = residual.size
    for i in range(unknown_count):
        copy(matrix[i], vectors[i])
        vectors[i, i] -= min_eigenvalue
    if solve_cholesky(vectors, residual, direction, 0.0):
        solve_cholesky(matrix, residual, direction, 0.0)
        return
    _find_eigenvectors(matrix, vectors)
    clear(direction)
    for column in range(unknown_count):
        component = 0.0
        for j in range(unknown_count):
            component += vectors[j, column] * residual[j]
        for j in range(unknown_count):
            direction[j] += component / max(abs(matrix[column, column]), min_eigenvalue) * vectors[j, column]


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def _find_eigenvectors(matrix: Array, vectors: Array) -> None:
    """Compute the eigenvectors of a symmetric matrix as columns of `vectors`, of the same shape, by Jacobi rotations.

    The matrix is overwritten, and its diagonal becomes the eigenvalues (Golub & Van Loan, Matrix Computations, 8.5).
    NumPy's function is not used in compiled code, because it would import SciPy, which takes 0.25 s per command.
    """
    unknown_count, tolerance = len(matrix), 0.0
    for i in range(unknown_count):
        tolerance = max(tolerance, ROUNDING * largest(matrix[i]))
    for i in range(unknown_count):
        clear(vectors[i])
        vectors[i, i] = 1.0
    has_rotated = True
    while has_rotated:
        has_rotated = False
        for p in range(unknown_count - 1):
            for q in range(p + 1, unknown_count):
                off_diagonal = matrix[p, q]
                if not abs(off_diagonal) > tolerance:
                    continue
                has_rotated = True
                cotangent = (matrix[q, q] - matrix[p, p]) / (2.0 * off_diagonal)
                tangent = math.copysign(1.0, cotangent) / (abs(cotangent) + math.hypot(1.0, cotangent))
                cos = 1.0 / math.hypot(1.0, tangent)
                sin = tangent * cos
                for i in range(unknown_count):
                    entry_p, entry_q = matrix[i, p], matrix[i, q]
                    matrix[i, p], matrix[i, q] = cos * entry_p - sin * entry_q, sin * entry_p + cos * entry_q
                    entry_p, entry_q = vectors[i, p], vectors[i, q]
                    vectors[i, p], vectors[i, q] = cos * entry_p - sin * entry_q, sin * entry_p + cos * entry_q
                for i in range(unknown_count):
                    entry_p, entry_q = matrix[p, i], matrix[q, i]
                    matrix[p, i], matrix[q, i] = cos * entry_p - sin * entry_q, sin * entry_p + cos * entry_q


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def largest(values: Array) -> float:
    """Return the largest absolute value of an array (m,); 0 if it is empty."""
    largest = 0.0
    for j in range(values.size):
        largest = max(largest, abs(values[j]))
    return largest


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def copy(values: Array, target: Array) -> None:
    """Copy `values` to the array `target` (m,) in a loop, as numba takes a second to compile an array assignment."""
    for j in range(target.size):
        target[j] = values[j]


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def clear(values: Array) -> None:
    """Set an array (m,) to 0."""
    for j in range(values.size):
        values[j] = 0.0
