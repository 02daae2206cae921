"""The static balance of springs that only push, compiled: one small Newton iteration for each crank angle.

Every spring is a gap from ``mechanism.gaps``, round by its `bend`; the cams are circles in circles. The energy of the
springs less the work of the load is convex up to the turning of the gaps, so Newton's steps are shortened until the
energy falls. Angles follow each other along the turn: each starts from the balance before it.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cycloid_mj.compiling import cacheable

Array = NDArray[np.float64]

ROUNDS = 200
"""Most Newton steps at one crank angle."""

BALANCED = 1e-8
"""Largest residual of a balance, as a share of the largest force in it."""

FLOATING = 1e-9
"""Stiffness that keeps floating parts where they are, as a share of the cam's."""

_NEAR = 0.5
"""Longest step as a share of the least radius of a contact's curve: past its middle the circle pushes the other way."""

_HALVINGS = 20
_ROUNDING = 1e-12
"""By how much energy [1] may seem to grow: next to the balance it is flat, and its differences are rounding."""


class Springs(NamedTuple):
    """Springs at k crank angles, n at each, on u unknowns; see ``gaps.Gaps`` for the meaning of each.

    Shapes: `room`, `distance`, `shift`, `bend`, `stiffness` (k, n) [m, m, m, 1/m, N/m]; `slope`, `shift_slope`
    (k, n, u) [1]; `cam_place` (k, D, 2) [m].
    """

    room: Array
    distance: Array
    slope: Array
    shift: Array
    shift_slope: Array
    bend: Array
    stiffness: Array
    cam_place: Array


class System(NamedTuple):
    """Generalised forces left over [N], shape (u,), and the springs' stiffness [N/m], shape (u, u), its lower half."""

    residual: Array
    tangent: Array


@njit(cache=cacheable(), nogil=True)
def balance(
    springs: Springs, cam_clearance: float, cam_stiffness: float, load: Array, z: Array, force: Array, follow: bool
) -> float:
    """Solve for the departures z (k, u) [m] at every crank angle under a load (k, u) [N], and the springs' forces.

    z and force (k, n) [N] are filled in. Each row of z is where its search starts; with `follow`, the first row is, and
    the others start from the balance before them.

    Returns
    -------
    The worst residual, as a share of the largest load [1]: above ``BALANCED`` no balance was found somewhere.
    """
    count, number = load.shape
    system = System(np.zeros(number), np.zeros((number, number)))
    trial = System(np.zeros(number), np.zeros((number, number)))
    step, there = np.zeros(number), np.zeros(number)
    worst = 0.0
    for k in range(count):
        here = z[k]
        if follow and k > 1:
            here[:] = 2.0 * z[k - 1] - z[k - 2]
        elif follow and k:
            here[:] = z[k - 1]
        scale = np.abs(load[k]).max() or 1.0
        least_radius = 1.0 / np.abs(springs.bend[k]).max()
        energy = _assemble(springs, k, cam_clearance, cam_stiffness, load[k], here, system)
        left = np.abs(system.residual).max() / scale
        for _ in range(ROUNDS):
            if left <= BALANCED:
                break
            _solve(system.tangent, system.residual, step, FLOATING * cam_stiffness)
            share = min(1.0, _NEAR * least_radius / np.abs(step).max())
            for _ in range(_HALVINGS):
                for i in range(number):
                    there[i] = here[i] + share * step[i]
                found = _assemble(springs, k, cam_clearance, cam_stiffness, load[k], there, trial)
                if found <= energy + _ROUNDING * abs(energy):
                    break
                share *= 0.5
            here[:] = there
            energy = found
            system, trial = trial, system
            left = np.abs(system.residual).max() / scale
        worst = max(worst, left)
        for i in range(springs.distance.shape[1]):
            force[k, i] = -springs.stiffness[k, i] * min(_gap(springs, k, i, here)[0], 0.0)
    return worst


@njit(cache=cacheable(), nogil=True, inline="always")
def _gap(springs: Springs, k: int, i: int, z: Array) -> tuple[float, float, float, float]:
    """Give a gap [m], cosine and sine of the angle by which its normal has turned, and the rate of that [1/m]."""
    distance, shift = springs.distance[k, i], springs.shift[k, i]
    for j in range(z.size):
        distance += springs.slope[k, i, j] * z[j]
        shift += springs.shift_slope[k, i, j] * z[j]
    room, bend = springs.room[k, i], springs.bend[k, i]
    along, across = 1.0 + bend * distance, bend * shift
    reach = math.sqrt(along * along + across * across)
    if along <= 0.0:  # open by more than the curve's radius
        return room + distance, 1.0, 0.0, 0.0
    # (reach - 1) / bend without its cancellation
    return room + distance + across * across / (bend * (reach + along)), along / reach, across / reach, bend / reach


@njit(cache=cacheable(), nogil=True)
def _assemble(
    springs: Springs, k: int, cam_clearance: float, cam_stiffness: float, load: Array, z: Array, system: System
) -> float:
    """Put together the system at departures z; give the energy of the springs less the work of the load [J]."""
    number = z.size
    residual, tangent = system.residual, system.tangent
    energy = 0.0
    for j in range(number):
        energy -= load[j] * z[j]
        residual[j] = load[j]
        for m in range(j + 1):
            tangent[j, m] = 0.0
    for i in range(springs.distance.shape[1]):
        gap, cosine, sine, rate = _gap(springs, k, i, z)
        if gap >= 0.0:
            continue
        stiffness = springs.stiffness[k, i]
        energy += 0.5 * stiffness * gap * gap
        # The normal's turning stiffens a concave contact and softens a convex one: what softens is left to Newton.
        turning = max(stiffness * gap * rate, 0.0)
        for j in range(number):
            ahead = cosine * springs.slope[k, i, j] + sine * springs.shift_slope[k, i, j]
            aside = cosine * springs.shift_slope[k, i, j] - sine * springs.slope[k, i, j]
            residual[j] -= stiffness * gap * ahead
            for m in range(j + 1):
                also = cosine * springs.slope[k, i, m] + sine * springs.shift_slope[k, i, m]
                beside = cosine * springs.shift_slope[k, i, m] - sine * springs.slope[k, i, m]
                tangent[j, m] += stiffness * ahead * also + turning * aside * beside
    for disc in range(springs.cam_place.shape[1]):
        a, b = 3 * disc, 3 * disc + 1
        x, y = z[a] - springs.cam_place[k, disc, 0], z[b] - springs.cam_place[k, disc, 1]
        reach = math.sqrt(x * x + y * y)
        depth = reach - cam_clearance
        if depth > 0.0:
            energy += 0.5 * cam_stiffness * depth * depth
            x, y = x / reach, y / reach
            residual[a] -= cam_stiffness * depth * x
            residual[b] -= cam_stiffness * depth * y
            around = depth / reach
            tangent[a, a] += cam_stiffness * (x * x + around * y * y)
            tangent[b, a] += cam_stiffness * (1.0 - around) * x * y
            tangent[b, b] += cam_stiffness * (y * y + around * x * x)
    return energy


@njit(cache=cacheable(), nogil=True)
def _solve(matrix: Array, right: Array, out: Array, floating: float) -> None:
    """Solve a symmetric positive system by Cholesky's method, from its lower half, in place."""
    number = right.size
    for j in range(number):
        pivot = matrix[j, j] + floating
        for m in range(j):
            pivot -= matrix[j, m] * matrix[j, m]
        pivot = math.sqrt(max(pivot, floating))
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
