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

Array = NDArray[np.float64]

ROUNDS = 200
"""Most Newton steps at one crank angle."""

BALANCED = 1e-10
"""Largest residual of a balance, as a share of the largest force in it."""

FLOATING = 1e-9
"""Stiffness that keeps floating parts where they are, as a share of the cam's."""

_NEAR = 0.5
"""Longest step as a share of the least radius of a contact's curve: past its middle the circle pushes the other way."""

_SHORTEST = 1e-6
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


@njit(cache=True, nogil=True)
def balance(springs: Springs, cam_clearance: float, cam_stiffness: float, load: Array, z: Array, force: Array) -> float:
    """Solve for the departures z (k, u) [m] at every crank angle under a load (k, u) [N], and the springs' forces.

    z and force (k, n) [N] are filled in; the first row of z is where the search starts.

    Returns
    -------
    The worst residual, as a share of the largest load [1]: above ``BALANCED`` no balance was found somewhere.
    """
    count, number = load.shape
    tangent, residual, step = np.zeros((number, number)), np.zeros(number), np.zeros(number)
    trial = np.zeros(number)
    worst = 0.0
    for k in range(count):
        here = z[k]
        if k:
            here[:] = z[k - 1]
        scale = max(1.0, np.abs(load[k]).max())
        energy = _spring_energy(springs, k, cam_clearance, cam_stiffness, load[k], here)
        left = math.inf
        for _ in range(ROUNDS):
            _assemble(springs, k, cam_clearance, cam_stiffness, load[k], here, residual, tangent)
            left = np.abs(residual).max() / scale
            if left <= BALANCED:
                break
            _solve(tangent, residual, step, FLOATING * cam_stiffness)
            share = min(1.0, _NEAR / (np.abs(springs.bend[k]).max() * np.abs(step).max()))
            shortest = _SHORTEST * share
            while share > shortest:
                for i in range(number):
                    trial[i] = here[i] + share * step[i]
                found = _spring_energy(springs, k, cam_clearance, cam_stiffness, load[k], trial)
                if found <= energy + _ROUNDING * abs(energy):
                    break
                share *= 0.5
            here[:] = trial
            energy = found
        worst = max(worst, left)
        for i in range(springs.distance.shape[1]):
            force[k, i] = -springs.stiffness[k, i] * min(_gap(springs, k, i, here)[0], 0.0)
    return worst


@njit(cache=True, nogil=True, inline="always")
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


@njit(cache=True, nogil=True)
def _spring_energy(
    springs: Springs, k: int, cam_clearance: float, cam_stiffness: float, load: Array, z: Array
) -> float:
    """Give the energy of the springs less the work of the load [J]."""
    energy = -np.sum(load * z)
    for i in range(springs.distance.shape[1]):
        gap, _, _, _ = _gap(springs, k, i, z)
        if gap < 0.0:
            energy += 0.5 * springs.stiffness[k, i] * gap * gap
    for disc in range(springs.cam_place.shape[1]):
        x = z[3 * disc] - springs.cam_place[k, disc, 0]
        y = z[3 * disc + 1] - springs.cam_place[k, disc, 1]
        depth = math.sqrt(x * x + y * y) - cam_clearance
        if depth > 0.0:
            energy += 0.5 * cam_stiffness * depth * depth
    return energy


@njit(cache=True, nogil=True)
def _assemble(
    springs: Springs,
    k: int,
    cam_clearance: float,
    cam_stiffness: float,
    load: Array,
    z: Array,
    residual: Array,
    tangent: Array,
) -> None:
    """Give the generalised forces on z [N], shape (u,), and the springs' stiffness [N/m], shape (u, u)."""
    number = z.size
    residual[:] = load
    tangent[:] = 0.0
    slope, side = np.empty(number), np.empty(number)
    for i in range(springs.distance.shape[1]):
        gap, cosine, sine, rate = _gap(springs, k, i, z)
        if gap >= 0.0:
            continue
        stiffness = springs.stiffness[k, i]
        for j in range(number):
            slope[j] = cosine * springs.slope[k, i, j] + sine * springs.shift_slope[k, i, j]
            side[j] = cosine * springs.shift_slope[k, i, j] - sine * springs.slope[k, i, j]
        # The normal's turning stiffens a concave contact and softens a convex one: what softens is left to Newton.
        turning = max(stiffness * gap * rate, 0.0)
        for j in range(number):
            residual[j] -= stiffness * gap * slope[j]
            for m in range(j + 1):
                tangent[j, m] += stiffness * slope[j] * slope[m] + turning * side[j] * side[m]
    for disc in range(springs.cam_place.shape[1]):
        a, b = 3 * disc, 3 * disc + 1
        x, y = z[a] - springs.cam_place[k, disc, 0], z[b] - springs.cam_place[k, disc, 1]
        reach = math.sqrt(x * x + y * y)
        depth = reach - cam_clearance
        if depth > 0.0:
            x, y = x / reach, y / reach
            residual[a] -= cam_stiffness * depth * x
            residual[b] -= cam_stiffness * depth * y
            around = depth / reach
            tangent[a, a] += cam_stiffness * (x * x + around * y * y)
            tangent[b, a] += cam_stiffness * (1.0 - around) * x * y
            tangent[b, b] += cam_stiffness * (y * y + around * x * x)


@njit(cache=True, nogil=True)
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
