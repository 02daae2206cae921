"""What MuJoCo's solver found in the contacts of one step, gathered by mating pair."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

from cycloid_mj.base import compiling
from cycloid_mj.base.array import Array
from cycloid_mj.dynamics.contact.gap import flank_distance
from cycloid_mj.dynamics.contact.memory import read_address, read_float, read_int, write_float
from cycloid_mj.dynamics.contact.step_state import StepState
from cycloid_mj.dynamics.contact.teeth import PLAY, read_teeth
from cycloid_mj.reducer.bodies import Role

_ROUND = 1e-9
"""Angle [rad] by which the normal of a contact on a round mate may miss the mate's middle: that of rounding."""

OF_PAIR = 6
"""Numbers of a pair: force x, y on its ``on`` body [N], moment about that body's origin [N m], largest normal force
since the sample before [N], and the powers that friction and normal force take [W]. Friction's is never negative but
for rounding; the normal force's is damping, and elastic energy on its way in or out."""


@dataclass(frozen=True)
class PairIndex:
    """Which mating pair two geoms belong to, and the teeth that the collider knows.

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
        Address of the ``geom user`` of a geom that stands for exact teeth, 0 of any other, shape (ngeom,).
    """

    surface: npt.NDArray[np.int32]
    pair: npt.NDArray[np.int32]
    origin: npt.NDArray[np.int32]
    reach: Array
    teeth: npt.NDArray[np.int64]


def pair_index(model: Any, pairs: Sequence[Any]) -> PairIndex:
    """Return the index of a model's mating pairs; a geom named ``<surface>/...`` is a slice of that surface."""
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


def _exact_teeth(model: Any) -> tuple[Array, npt.NDArray[np.int64]]:
    """Compute reach and teeth of each geom, see `PairIndex`; of a model without exact teeth none has any."""
    priority, user, reach = model.geom_priority, model.geom_user, np.zeros(model.ngeom)
    exact = priority == int(Role.TEETH)
    if exact.any():
        for role, play in ((Role.PIN, user[:, PLAY]), (Role.LOBE, 0.0)):
            reach = np.where(priority == int(role), model.geom_size[:, 0] - play, reach)
    address = model.geom_user.ctypes.data + 8 * model.nuser_geom * np.arange(model.ngeom)
    return reach, np.where(exact, address, 0)


def surface_name(model: Any, geom: int) -> str:
    """Name the surface that a geom is, or is a slice of."""
    name: str = model.geom(geom).name
    return name.partition("/")[0]


@njit(inline="always")
def pair_of(kept: StepState, contact: int) -> int:
    """Get the number of the mating pair of a contact at an address, with a minus sign where its first geom is ``on``.

    Numbers begin at 1; 0 is none.
    """
    geoms = contact + kept.geom
    one, two = read_int(kept.surface + 4 * read_int(geoms)), read_int(kept.surface + 4 * read_int(geoms + 4))
    return read_int(kept.pair + 4 * (kept.surfaces * one + two))


@compiling.njit(inner=True)
def gather(kept: StepState, summary: int, of_pairs: int) -> None:
    """Gather the contacts of the step just taken.

    Written are, at one address, the number of contacts that carry a force, the deepest geometric penetration [m] and
    the largest force of one contact [N]; at the other, what `OF_PAIR` says of every pair, where zeros and the largest
    forces stand already.
    """
    contacts, forces = read_address(kept.contacts), read_address(kept.forces)
    active, depth, peak = 0, 0.0, 0.0
    for k in range(read_int(kept.count)):
        contact = contacts + kept.stride * k
        depth = max(depth, _overlap(kept, contact))
        number, row = pair_of(kept, contact), read_int(contact + kept.row)
        if number == 0 or row < 0:
            continue
        pair, sign = abs(number) - 1, (1.0 if number > 0 else -1.0)
        force = forces + 8 * row
        speed = read_address(kept.speeds) + 8 * row
        fx = read_float(force) * read_float(contact + kept.frame)
        fy = read_float(force) * read_float(contact + kept.frame + 8)
        place = of_pairs + 8 * OF_PAIR * pair
        for axis in range(1, read_int(contact + kept.dim)):
            along, tangent = read_float(force + 8 * axis), contact + kept.frame + 24 * axis
            fx += along * read_float(tangent)
            fy += along * read_float(tangent + 8)
            _add(place + 32, -along * read_float(speed + 8 * axis))
        origin = kept.xpos + 24 * read_int(kept.origin + 4 * pair)
        x, y = read_float(contact + kept.pos), read_float(contact + kept.pos + 8)
        _add(place, sign * fx)
        _add(place + 8, sign * fy)
        _add(place + 16, sign * ((x - read_float(origin)) * fy - (y - read_float(origin + 8)) * fx))
        _add(place + 40, -read_float(force) * read_float(speed))
        magnitude = math.sqrt(fx * fx + fy * fy)
        active += magnitude > 0.0
        peak = max(peak, magnitude)
    write_float(summary, float(active))
    write_float(summary + 8, depth)
    write_float(summary + 16, peak)


@njit(inline="always")
def _add(place: int, value: float) -> None:
    write_float(place, read_float(place) + value)


@compiling.njit(inner=True)
def _overlap(kept: StepState, contact: int) -> float:
    """Compute how deep the parts of a contact are in each other [m]; MuJoCo's own distance where no exact teeth meet.

    With them that distance is scaled: it makes the stiffness follow the local curvature (``mating``).
    """
    overlap = -read_float(contact)
    first, second = read_int(contact + kept.geom), read_int(contact + kept.geom + 4)
    teeth, mate = (first, second) if read_address(kept.teeth + 8 * first) else (second, first)
    user = read_address(kept.teeth + 8 * teeth)
    if not user or overlap <= 0.0:
        return overlap
    x, y = read_float(contact + kept.pos), read_float(contact + kept.pos + 8)
    centre = kept.geom_xpos + 24 * mate
    dx, dy = read_float(centre) - x, read_float(centre + 8) - y
    away = math.sqrt(dx * dx + dy * dy)
    if abs(dx * read_float(contact + kept.frame + 8) - dy * read_float(contact + kept.frame)) < _ROUND * away:
        return 2.0 * (read_float(kept.reach + 8 * mate) - away)
    # a root of the ring: its depth from the contact point, which lies half-way
    flank = read_teeth(user, kept.numbers).flank
    gear, turn = kept.geom_xpos + 24 * teeth, kept.geom_xmat + 72 * teeth
    gx, gy, cosine, sine = x - read_float(gear), y - read_float(gear + 8), read_float(turn), read_float(turn + 24)
    return -2.0 * (flank_distance(cosine * gx + sine * gy, cosine * gy - sine * gx, flank)[1] + flank.offset)


def drag_rows(model: Any, drags: Mapping[str, str]) -> dict[str, int]:
    """Map loss to row of its constraint, for those of the joints, by loss, that seals and lubricant brake in a model.

    A model of ours has no equalities: the rows of joint friction come first, in the order of the degrees of freedom.
    """
    braked = model.dof_frictionloss > 0.0
    dofs = {name: int(model.joint(joint).dofadr[0]) for name, joint in drags.items()}
    return {name: int(np.count_nonzero(braked[:dof])) for name, dof in dofs.items() if braked[dof]}
