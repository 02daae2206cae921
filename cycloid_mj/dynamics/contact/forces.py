"""Contact forces of one MuJoCo step, summed by mating pair."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

from cycloid_mj.base import compiling
from cycloid_mj.base.array import Array
from cycloid_mj.dynamics.contact import sample_layout
from cycloid_mj.dynamics.contact.gap import flank_distance
from cycloid_mj.dynamics.contact.memory import read_address, read_float, read_int, write_float
from cycloid_mj.dynamics.contact.step_state import StepState
from cycloid_mj.dynamics.contact.teeth import PLAY, read_teeth
from cycloid_mj.reducer.bodies import Role

_ROUND = 1e-9
"""Largest angle [rad] between the normal of a contact on a round surface and the direction of its centre: rounding."""


@dataclass(frozen=True)
class PairIndex:
    """Mating pairs of the geoms of a model, and the exact teeth.

    Attributes
    ----------
    surface
        Number of the surface that a geom represents or is a slice of; 0 for none. Shape (ngeom,).
    pair
        For two surfaces: +-(pair + 1), negative if the first is the ``on`` surface; 0 for none. Shape (surfaces + 1,
        surfaces + 1).
    origin
        Body of each pair's ``on`` surface, shape (pairs,).
    reach
        Radius of a geom that mates with exact teeth, less the clearance of a massless pin [m], shape (ngeom,); 0 for
        others.
    teeth
        Address of the ``geom user`` of a geom that represents exact teeth, 0 for others, shape (ngeom,).
    """

    surface: npt.NDArray[np.int32]
    pair: npt.NDArray[np.int32]
    origin: npt.NDArray[np.int32]
    reach: Array
    teeth: npt.NDArray[np.int64]


def pair_index(model: Any, pairs: Sequence[Any]) -> PairIndex:
    """Return lookup tables from two geoms in contact to their mating pair, for compiled code.

    `model` is the MuJoCo model, `pairs` are its mating pairs. The tables (`PairIndex`) have the surface of each geom,
    the number of the pair of any two surfaces, and for each pair the body on which its logged force acts: the body of
    the surface `Pair.on`. A geom named ``<surface>/...`` is a slice of that surface. Surfaces and pairs are counted
    from 1; 0 stands for none. The number of a pair is negative if the first of the two surfaces is `Pair.on`, because
    MuJoCo's contact force acts on the second.
    """
    surface_names = dict.fromkeys(name for pair in pairs for name in (pair.on, pair.by))
    surface_numbers = {name: number for number, name in enumerate(surface_names, start=1)}
    number_of_geom = np.array(
        [surface_numbers.get(surface_name(model, geom), 0) for geom in range(model.ngeom)], dtype=np.int32
    )
    body_of_surface = dict(zip(number_of_geom.tolist(), model.geom_bodyid.tolist(), strict=True))
    pair_numbers = np.zeros((len(surface_numbers) + 1, len(surface_numbers) + 1), dtype=np.int32)
    for pair_number, pair in enumerate(pairs, start=1):
        on_number, by_number = surface_numbers[pair.on], surface_numbers[pair.by]
        pair_numbers[on_number, by_number], pair_numbers[by_number, on_number] = -pair_number, pair_number
    origin_bodies = np.array([body_of_surface[surface_numbers[pair.on]] for pair in pairs], dtype=np.int32)
    return PairIndex(number_of_geom, pair_numbers, origin_bodies, *_tooth_contact_data(model))


def _tooth_contact_data(model: Any) -> tuple[Array, npt.NDArray[np.int64]]:
    """Return radii and data addresses from which the geometric penetration of teeth is computed, per MuJoCo geom.

    Both have the shape (geoms,), and are 0 in a model without exact teeth.

    Returns
    -------
    radii
        Radius of a ring pin or lobe, less the clearance of a massless pin [m]; 0 for other geoms.
    data_addresses
        Memory address of the user data of a geom that represents the teeth of a disc; 0 for other geoms.
    """
    priority, user_data, radii = model.geom_priority, model.geom_user, np.zeros(model.ngeom)
    is_teeth = priority == int(Role.TEETH)
    if is_teeth.any():
        for role, play in ((Role.PIN, user_data[:, PLAY]), (Role.LOBE, 0.0)):
            radii = np.where(priority == int(role), model.geom_size[:, 0] - play, radii)
    data_addresses = model.geom_user.ctypes.data + 8 * model.nuser_geom * np.arange(model.ngeom)
    return radii, np.where(is_teeth, data_addresses, 0)


def surface_name(model: Any, geom: int) -> str:
    """Return the name of the surface that a geom represents, or is a slice of."""
    name: str = model.geom(geom).name
    return name.partition("/")[0]


@njit(inline="always")
def pair_of(state: StepState, contact: int) -> int:
    """Return the number (from 1) of the mating pair of a contact, negative if its first geom is ``on``; 0 for none."""
    geoms = contact + state.geom
    first, second = read_int(state.surface + 4 * read_int(geoms)), read_int(state.surface + 4 * read_int(geoms + 4))
    return read_int(state.pair + 4 * (state.surfaces * first + second))


@compiling.njit(inner=True)
def sum_contacts(state: StepState, summary: int, pair_table: int) -> None:
    """Sum the forces and powers of the contacts of the current step of a run by mating pair.

    Three values are written at the memory address `summary`: the number of contacts that carry a force, the deepest
    geometric penetration [m], and the largest force of one contact [N]. At the address `pair_table`, force x and y [N],
    moment [N m], peak force [N] and powers of friction and normal force [W] of every pair are written
    (``PAIR_COLUMNS``); all numbers there but the peak forces must be zero before. Force and moment act on the body of
    the surface `Pair.on`, the moment about its origin. `state` is the state of the run.
    """
    contacts_address, forces_address = read_address(state.contact), read_address(state.efc_force)
    active_contacts, max_depth, largest_force = 0, 0.0, 0.0
    for contact_index in range(read_int(state.ncon)):
        contact = contacts_address + state.stride * contact_index
        max_depth = max(max_depth, _compute_penetration(state, contact))
        signed_pair_number, first_row = pair_of(state, contact), read_int(contact + state.efc_address)
        if signed_pair_number == 0 or first_row < 0:
            continue
        pair_index, sign = abs(signed_pair_number) - 1, (1.0 if signed_pair_number > 0 else -1.0)
        force_address = forces_address + 8 * first_row
        speed_address = read_address(state.efc_vel) + 8 * first_row
        force_x = read_float(force_address) * read_float(contact + state.frame)
        force_y = read_float(force_address) * read_float(contact + state.frame + 8)
        pair_columns = pair_table + 8 * sample_layout.OF_PAIR * pair_index
        for axis in range(1, read_int(contact + state.dim)):
            tangential_force, tangent_address = read_float(force_address + 8 * axis), contact + state.frame + 24 * axis
            force_x += tangential_force * read_float(tangent_address)
            force_y += tangential_force * read_float(tangent_address + 8)
            _add(
                pair_columns + 8 * sample_layout.FRICTION_POWER,
                -tangential_force * read_float(speed_address + 8 * axis),
            )
        origin_address = state.xpos + 24 * read_int(state.origin + 4 * pair_index)
        x, y = read_float(contact + state.pos), read_float(contact + state.pos + 8)
        _add(pair_columns + 8 * sample_layout.FORCE_X, sign * force_x)
        _add(pair_columns + 8 * sample_layout.FORCE_Y, sign * force_y)
        _add(
            pair_columns + 8 * sample_layout.MOMENT,
            sign * ((x - read_float(origin_address)) * force_y - (y - read_float(origin_address + 8)) * force_x),
        )
        _add(pair_columns + 8 * sample_layout.NORMAL_POWER, -read_float(force_address) * read_float(speed_address))
        magnitude = math.sqrt(force_x * force_x + force_y * force_y)
        active_contacts += magnitude > 0.0
        largest_force = max(largest_force, magnitude)
    write_float(summary + 8 * sample_layout.ACTIVE, float(active_contacts))
    write_float(summary + 8 * sample_layout.PENETRATION, max_depth)
    write_float(summary + 8 * sample_layout.LARGEST_FORCE, largest_force)


@njit(inline="always")
def _add(address: int, value: float) -> None:
    write_float(address, read_float(address) + value)


@compiling.njit(inner=True)
def _compute_penetration(state: StepState, contact: int) -> float:
    """Compute the penetration [m] of a contact; it is negative where the surfaces do not touch.

    `contact` is the memory address of the ``mjContact``, `state` the state of the run. At exact teeth it is the
    geometric penetration, because MuJoCo's distance there is scaled by the stiffness factor of the local curvature
    (``mating``).
    """
    overlap = -read_float(contact)
    first_geom, second_geom = read_int(contact + state.geom), read_int(contact + state.geom + 4)
    teeth, mate = (first_geom, second_geom) if read_address(state.teeth + 8 * first_geom) else (second_geom, first_geom)
    teeth_data = read_address(state.teeth + 8 * teeth)
    if not teeth_data or overlap <= 0.0:
        return overlap
    x, y = read_float(contact + state.pos), read_float(contact + state.pos + 8)
    mate_position = state.geom_xpos + 24 * mate
    dx, dy = read_float(mate_position) - x, read_float(mate_position + 8) - y
    distance = math.sqrt(dx * dx + dy * dy)
    if abs(dx * read_float(contact + state.frame + 8) - dy * read_float(contact + state.frame)) < _ROUND * distance:
        return 2.0 * (read_float(state.reach + 8 * mate) - distance)
    # a root of the ring: its depth from the contact point, which lies half-way
    flank = read_teeth(teeth_data, state.nuser_geom).flank
    gear_position, gear_rotation = state.geom_xpos + 24 * teeth, state.geom_xmat + 72 * teeth
    along_x, along_y, cosine, sine = (
        x - read_float(gear_position),
        y - read_float(gear_position + 8),
        read_float(gear_rotation),
        read_float(gear_rotation + 24),
    )
    return -2.0 * (
        flank_distance(cosine * along_x + sine * along_y, cosine * along_y - sine * along_x, flank)[1] + flank.offset
    )


def drag_rows(model: Any, joint_by_loss: Mapping[str, str]) -> dict[str, int]:
    """Return the index of the constraint row that models each loss by seals and lubricant, by the name of the loss.

    `joint_by_loss` maps losses, such as ``crank_drag``, to joints of the model. Losses without such a joint, or without
    friction there, are omitted. The models have no equalities: joint friction has the first rows, in the order of the
    degrees of freedom.
    """
    has_drag = model.dof_frictionloss > 0.0
    dof_by_joint = {model.joint(i).name: int(model.jnt_dofadr[i]) for i in range(model.njnt)}
    dof_by_loss = {name: dof_by_joint[joint] for name, joint in joint_by_loss.items() if joint in dof_by_joint}
    return {name: int(np.count_nonzero(has_drag[:dof])) for name, dof in dof_by_loss.items() if has_drag[dof]}
