"""Newton's method on the system of a balance, and the linear systems of its steps."""

import math
from typing import NamedTuple

from cycloid_mj.base.array import Array
from cycloid_mj.base.compiling import njit
from cycloid_mj.statics.kernel.contacts import NO, KernelSprings
from cycloid_mj.statics.kernel.system import Linearised, assemble

BALANCED = 1e-8
"""Largest residual of a balance, as a share of the largest load."""


FOLLOWED = 1e-6
"""Largest residual of a step along a path, as a share of the path's largest load."""


FLOATING = 1e-9
"""Stiffness that keeps floating parts where they are, as a share of the cam's."""


ROUNDING = 1e-12
"""By how much energy [1] may seem to grow: next to the balance it is flat, and its differences are rounding."""


_STEPS, _STEPS_DOWN, _FARTHEST = 15, 200, 0.3
"""Most Newton steps for each disc, and downhill in all; the longest as a share of the eccentricity."""


_OVERSHOT = 10.0
"""How often the energy's fall before a step, without friction, it may rise after it: contacts that close on the way
push back, and the step is ended where the stiffness there puts the least energy of its line. Else steps would leap."""


_ARMIJO, _SOFT = 0.01, 1e-6
"""Share of the fall that the slope promises which a step downhill must bring, and least stiffness that it reckons with,
as a share of the cam's."""


class Residual(NamedTuple):
    """How far a search got: the least `force` left over, as a share of the largest load, at an `angle`, by its number.

    `work` counts how often the system was put together on the way.
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
    keep: bool,
    downhill: bool,
    system: Linearised,
) -> float:
    """Solve for the departures `here` (u,) [m] by Newton's method, from where they are; give what is left over [N].

    Of springs that are `soft` and a share of the friction, see `assemble`. With `keep`, contacts that pressed before
    count as closed in the first step. `downhill`, without friction, steps are shortened until the energy falls.
    """
    hard, longest = soft * springs.cam_stiffness, _FARTHEST * springs.trochoid[1]
    residual, step, start, number = system.residual, system.step, system.start, here.size
    left, energy, share, falls = math.inf, math.inf, 1.0, math.inf
    led = keep and springs.rubbing.shape[0] == 0
    for i in range(system.kept.size):
        system.kept[i] = keep and system.pressed[i] > 0.0
    for step_number in range(_STEPS_DOWN if downhill else springs.cam_place.shape[1] * _STEPS):
        found = assemble(springs, k, load, here, soft, friction, exact, step_number == 0, system)
        left = largest(residual)
        if not left < math.inf:
            break
        slope = _product(step, residual)
        if downhill and found > energy - _ARMIJO * share * falls + ROUNDING * abs(energy) and share > ROUNDING:
            share *= 0.5
        elif led and left > allowed and -slope > _OVERSHOT * abs(falls):
            share = max(share + slope / max(_curvature(system.tangent, step), 1e-300), 0.0)
        else:
            if left <= allowed and not keep:
                return left
            energy = found
            if downhill:
                roll_off(system.tangent, residual, step, _SOFT * hard, system.vectors)
            elif solve(system.tangent, residual, step, FLOATING * hard + damping * left * hard) == 0.0:
                break
            share, falls = min(1.0, longest / max(largest(step), 1e-300)), _product(step, residual)
            copy(here, start)
        for j in range(number):
            here[j] = start[j] + share * step[j]
        for i in range(system.kept.size if keep else 0):
            system.kept[i] = False
        keep = NO
    return left


@njit(nogil=True, error_model="numpy", inline="always")
def _product(step: Array, values: Array) -> float:
    """Compute the product of two vectors (u,)."""
    total = 0.0
    for j in range(step.size):
        total += step[j] * values[j]
    return total


@njit(nogil=True, error_model="numpy", inline="always")
def _curvature(stiffness: Array, step: Array) -> float:
    """Compute by how much the energy of a stiffness (u, u) curves along a step (u,) [m], [J]."""
    total = 0.0
    for j in range(step.size):
        total += step[j] * _product(step, stiffness[j])
    return total


@njit(allocates=False, inner=True, nogil=True, error_model="numpy", forceinline=True)
def solve(matrix: Array, right: Array, out: Array, floating: float) -> float:
    """Solve a system by Gauss's elimination with pivots, in place; give the sign of its determinant, 0 if unsolvable.

    What only floats is held by a stiffness beside. `out` may be `right`.
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


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def roll_off(matrix: Array, right: Array, out: Array, floating: float, vectors: Array) -> None:
    """Solve a symmetric system as if all of its eigenvalues were positive: that leads down from a ridge.

    In place, with room for a matrix of `vectors`. Where the eigenvalues are above what floats, they need not be known.
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
    """Compute the eigenvectors of a symmetric matrix, as columns, by Jacobi's turns; its diagonal becomes the values.

    Golub and Van Loan, Matrix Computations, 8.5. NumPy's would load SciPy, a quarter of a second of each command.
    """
    number, least = len(matrix), 0.0
    for i in range(number):
        least = max(least, ROUNDING * largest(matrix[i]))
    for i in range(number):
        clear(vectors[i])
        vectors[i, i] = 1.0
    turned = True
    while turned:
        turned = False
        for p in range(number - 1):
            for q in range(p + 1, number):
                beside = matrix[p, q]
                if not abs(beside) > least:
                    continue
                turned = True
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
    """Compute the largest size among values."""
    largest = 0.0
    for j in range(values.size):
        largest = max(largest, abs(values[j]))
    return largest


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def copy(values: Array, to: Array) -> None:
    """Put values (m,) into an array: numba takes a second to compile this as an assignment, for its message alone."""
    for j in range(to.size):
        to[j] = values[j]


@njit(allocates=False, inner=True, nogil=True, error_model="numpy")
def clear(values: Array) -> None:
    """Put 0 into an array (m,)."""
    for j in range(values.size):
        values[j] = 0.0
