"""What MuJoCo's solver found in the contacts of one step, gathered by mating pair."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

from cycloid_mj.compiling import cacheable
from cycloid_mj.contact.gap import Flank, flank_distance
from cycloid_mj.contact.teeth import PLAY, USER_DATA, teeth_of
from cycloid_mj.mechanism.reducer import Role
from cycloid_mj.types import Array

_ROUND = 1e-9
"""Angle [rad] by which the normal of a contact on a round mate may miss the mate's middle: that of rounding."""


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
        Deepest geometric penetration [m].
    peak_force
        Largest force of one contact [N].
    """

    wrench: Array
    friction_power: Array
    normal_power: Array
    active: int
    penetration: float
    peak_force: float


@dataclass(frozen=True)
class PairIndex:
    """Which mating pair two geoms belong to, and the flanks that the collider knows.

    Attributes
    ----------
    surface
        Number of the surface that a geom is, or is a slice of; 0 for none. Shape (ngeom,).
    pair
        Of two surfaces: +-(pair + 1), negative where the first is the ``on`` surface; 0 for none. Shape (surfaces + 1,
        surfaces + 1).
    origin
        Body of each pair's ``on`` surface, shape (pairs,).
    reach
        Radius of a geom that meets exact teeth, less the play that it gives way by [m], shape (ngeom,); 0 of any other.
    teeth
        Number of the exact teeth that a geom stands for, one of each disc, -1 for none, shape (ngeom,).
    flanks
        The flanks of these teeth.
    """

    surface: npt.NDArray[np.int32]
    pair: npt.NDArray[np.int32]
    origin: npt.NDArray[np.int32]
    reach: Array
    teeth: npt.NDArray[np.int32]
    flanks: tuple[Flank, ...]


def pair_index(model: Any, pairs: Sequence[Any]) -> PairIndex:
    """Give the index of a model's mating pairs; a geom named ``<surface>/...`` is a slice of that surface."""
    mating = dict.fromkeys(name for pair in pairs for name in (pair.on, pair.by))
    number = {name: count for count, name in enumerate(mating, start=1)}
    surface = np.array([number.get(surface_name(model, geom), 0) for geom in range(model.ngeom)], dtype=np.int32)
    body = dict(zip(surface.tolist(), model.geom_bodyid.tolist(), strict=True))
    index = np.zeros((len(number) + 1, len(number) + 1), dtype=np.int32)
    for count, pair in enumerate(pairs, start=1):
        on, by = number[pair.on], number[pair.by]
        index[on, by], index[by, on] = -count, count
    origin = np.array([body[number[pair.on]] for pair in pairs], dtype=np.int32)
    return PairIndex(surface, index, origin, *_exact_teeth(model))


def _exact_teeth(model: Any) -> tuple[Array, npt.NDArray[np.int32], tuple[Flank, ...]]:
    """Give reach and number of teeth of each geom, see `PairIndex`, and flanks; of nothing where there are none."""
    priority, user, reach = model.geom_priority, model.geom_user, np.zeros(model.ngeom)
    found = np.flatnonzero(priority == int(Role.TEETH))
    number = np.full(model.ngeom, -1, dtype=np.int32)
    number[found] = np.arange(found.size)
    if not found.size:
        return reach, number, (teeth_of(np.zeros(USER_DATA)).flank,)
    for role, play in ((Role.PIN, user[:, PLAY]), (Role.LOBE, 0.0)):
        reach = np.where(priority == int(role), model.geom_size[:, 0] - play, reach)
    return reach, number, tuple(teeth_of(np.array(user[geom])).flank for geom in found)


def surface_name(model: Any, geom: int) -> str:
    """Name the surface that a geom is, or is a slice of."""
    name: str = model.geom(geom).name
    return name.partition("/")[0]


def pair_forces(data: Any, index: PairIndex) -> PairForces:
    """Gather the contacts of the step just taken.

    Parameters
    ----------
    data
        ``MjData`` after ``mj_step``: forces, positions and velocities of the start of the step.
    index
        From ``pair_index``.
    """
    count = len(index.origin)
    wrench, friction, normal = np.zeros((count, 3)), np.zeros(count), np.zeros(count)
    contact = data.contact
    if not len(contact.dist):
        # empty arrays have another layout, for which numba would compile all of `_gather` a second time
        return PairForces(wrench, friction, normal, 0, 0.0, 0.0)
    active, depth, peak = _gather(
        contact.geom,
        contact.efc_address,
        contact.dim,
        contact.frame,
        contact.pos,
        contact.dist,
        data.efc_force,
        data.efc_vel,
        index.surface,
        index.pair,
        data.xpos,
        index.origin,
        index.reach,
        index.teeth,
        index.flanks,
        data.geom_xpos,
        data.geom_xmat,
        wrench,
        friction,
        normal,
    )
    return PairForces(wrench, friction, normal, active, depth, peak)


@njit(cache=cacheable())
def _gather(
    geom: Any,
    address: Any,
    dim: Any,
    frame: Any,
    pos: Any,
    dist: Any,
    force: Any,
    velocity: Any,
    surface: Any,
    pairs: Any,
    xpos: Any,
    origin: Any,
    reach: Any,
    teeth_number: Any,
    flanks: Any,
    geom_xpos: Any,
    geom_xmat: Any,
    wrench: Any,
    friction: Any,
    normal: Any,
) -> tuple[int, float, float]:
    active, depth, peak = 0, 0.0, 0.0
    for k in range(len(dist)):
        overlap = -dist[k]
        teeth, mate = (geom[k, 0], geom[k, 1]) if teeth_number[geom[k, 0]] >= 0 else (geom[k, 1], geom[k, 0])
        if overlap > 0.0 and teeth_number[teeth] >= 0:
            # MuJoCo's own distance is scaled: it makes the stiffness follow the local curvature (``mating``).
            dx, dy = geom_xpos[mate, 0] - pos[k, 0], geom_xpos[mate, 1] - pos[k, 1]
            away = np.sqrt(dx * dx + dy * dy)
            if abs(dx * frame[k, 1] - dy * frame[k, 0]) < _ROUND * away:
                overlap = 2.0 * (reach[mate] - away)
            else:
                overlap = _overlap(
                    pos[k, 0], pos[k, 1], flanks[teeth_number[teeth]], geom_xpos[teeth], geom_xmat[teeth]
                )
        depth = max(depth, overlap)
        number = pairs[surface[geom[k, 0]], surface[geom[k, 1]]]
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
        body = origin[pair]
        wrench[pair, 0] += sign * fx
        wrench[pair, 1] += sign * fy
        wrench[pair, 2] += sign * ((pos[k, 0] - xpos[body, 0]) * fy - (pos[k, 1] - xpos[body, 1]) * fx)
        magnitude = np.sqrt(fx * fx + fy * fy)
        active += magnitude > 0.0
        peak = max(peak, magnitude)
    return active, depth, peak


@njit(inline="always")
def _overlap(x: Any, y: Any, flank: Any, centre: Any, frame: Any) -> Any:
    """Give how deep a root of the ring is in the gear's teeth [m], from the contact point, which lies half-way."""
    dx, dy, cosine, sine = x - centre[0], y - centre[1], frame[0], frame[3]
    distance = flank_distance(cosine * dx + sine * dy, cosine * dy - sine * dx, flank)[1]
    return -2.0 * (distance + flank.offset)
