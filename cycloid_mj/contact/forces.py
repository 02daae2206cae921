"""What MuJoCo's solver found in the contacts of one step, gathered by mating pair."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class PairForces:
    """Contacts of one step.

    Attributes
    ----------
    wrench
        Force x, y [N] on the ``on`` body of each pair and moment about its origin [N m], shape (pairs, 3).
    friction_power
        Power that sliding takes in each pair [W], shape (pairs,), never negative but for rounding.
    normal_power
        Power that the normal force takes in each pair [W]: damping, and elastic energy on its way in or out.
    active
        Contacts that carry a force.
    penetration
        Deepest penetration [m].
    peak_force
        Largest force of one contact [N].
    """

    wrench: Array
    friction_power: Array
    normal_power: Array
    active: int
    penetration: float
    peak_force: float


def pair_index(model: Any, pairs: Any) -> npt.NDArray[np.int32]:
    """Map two geoms to +-(pair + 1), negative where the first is the ``on`` geom; 0 for none. Shape (ngeom, ngeom)."""
    index = np.zeros((model.ngeom, model.ngeom), dtype=np.int32)
    for number, pair in enumerate(pairs, start=1):
        on, by = model.geom(pair.on).id, model.geom(pair.by).id
        index[on, by], index[by, on] = -number, number
    return index


def pair_forces(data: Any, index: npt.NDArray[np.int32], origins: npt.NDArray[np.int32]) -> PairForces:
    """Gather the contacts of the step just taken.

    Parameters
    ----------
    data
        ``MjData`` after ``mj_step``: forces, positions and velocities of the start of the step.
    index
        From ``pair_index``.
    origins
        Body of each pair's ``on`` geom, shape (pairs,).
    """
    count = len(origins)
    wrench, friction, normal = np.zeros((count, 3)), np.zeros(count), np.zeros(count)
    contact = data.contact
    active, depth, peak = _gather(
        contact.geom,
        contact.efc_address,
        contact.dim,
        contact.frame,
        contact.pos,
        contact.dist,
        data.efc_force,
        data.efc_vel,
        index,
        data.xpos,
        origins,
        wrench,
        friction,
        normal,
    )
    return PairForces(wrench, friction, normal, active, depth, peak)


@njit(cache=True)
def _gather(
    geom: Any,
    address: Any,
    dim: Any,
    frame: Any,
    pos: Any,
    dist: Any,
    force: Any,
    velocity: Any,
    index: Any,
    xpos: Any,
    origins: Any,
    wrench: Any,
    friction: Any,
    normal: Any,
) -> tuple[int, float, float]:
    active, depth, peak = 0, 0.0, 0.0
    for k in range(len(dist)):
        depth = max(depth, -dist[k])
        number = index[geom[k, 0], geom[k, 1]]
        row = address[k]
        if number == 0 or row < 0:
            continue
        pair, sign = abs(number) - 1, (1.0 if number > 0 else -1.0)
        fx, fy = force[row] * frame[k, 0], force[row] * frame[k, 1]
        normal[pair] -= force[row] * velocity[row]
        for axis in range(1, dim[k]):
            fx += force[row + axis] * frame[k, 3 * axis]
            fy += force[row + axis] * frame[k, 3 * axis + 1]
            friction[pair] -= force[row + axis] * velocity[row + axis]
        body = origins[pair]
        wrench[pair, 0] += sign * fx
        wrench[pair, 1] += sign * fy
        wrench[pair, 2] += sign * ((pos[k, 0] - xpos[body, 0]) * fy - (pos[k, 1] - xpos[body, 1]) * fx)
        magnitude = np.sqrt(fx * fx + fy * fy)
        active += magnitude > 0.0
        peak = max(peak, magnitude)
    return active, depth, peak
