"""A turn of the cranks of an RV reducer by its static equilibrium with friction: forces as those that a run logs."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from cycloid_mj.base import names
from cycloid_mj.base.array import Array, cross
from cycloid_mj.reducer import RvReducer, once
from cycloid_mj.reducer.gaps import mesh_gaps
from cycloid_mj.statics.rv import (
    RunningFriction,
    RvLoads,
    RvSprings,
    compute_rv_springs,
    contact_gradients,
    solve_rv_loads,
)
from cycloid_mj.statics.rv_film import running_friction
from cycloid_mj.statics.rv_sheet import torque_on_carrier
from cycloid_mj.stress.contacts import nominal_pin_centre
from cycloid_mj.stress.turn import DEGREES, Turn


def solve_over_turn(reducer: RvReducer, angles: npt.ArrayLike = DEGREES) -> tuple[RvSprings, RvLoads]:
    """Solve the static equilibrium of a running RV reducer under its load; return contact springs and loads.

    Both have k crank angles: `angles` (k,) [rad] are angles of the cranks relative to the carrier.

    Raises
    ------
    RunError
        No static equilibrium exists.
    """
    return _solve_turn(reducer, tuple(np.ravel(angles).tolist()))


@once
def _solve_turn(reducer: RvReducer, angles: tuple[float, ...]) -> tuple[RvSprings, RvLoads]:
    """Solve the static equilibrium at crank angles [rad]; the result is cached (see `solve_over_turn`)."""
    design = reducer.design
    springs = compute_rv_springs(reducer, np.array(angles) * design.lobes / design.ring.teeth)
    torque = torque_on_carrier(reducer, design.load.torque)
    return springs, solve_rv_loads(springs, torque, _friction(reducer, springs))


def _friction(reducer: RvReducer, springs: RvSprings) -> RunningFriction:
    """Return the friction of the running drive under its load."""
    sense = np.sign(torque_on_carrier(reducer, reducer.design.load.torque))
    return running_friction(reducer, springs.crank, float(sense))


def static_turn(reducer: RvReducer, angles: npt.ArrayLike = DEGREES) -> Turn:
    """Return positions and contact forces of an RV reducer at k angles of a turn in static equilibrium.

    They have the names and units of the logged columns of a simulation.

    `angles` [rad] (k,) are angles of the cranks relative to the carrier. Weight and inertia are left out.

    Raises
    ------
    RunError
        No static equilibrium exists.
    """
    crank_angles = np.ravel(np.asarray(angles, dtype=np.float64))
    springs, loads = solve_over_turn(reducer, crank_angles)
    zeros = np.zeros_like(crank_angles)
    columns = {"crank_angle": springs.crank, "load_torque": np.full_like(crank_angles, reducer.design.load.torque)}
    columns |= dict(_disc_columns(reducer, springs)) | dict(_force_columns(reducer, springs, loads))
    if reducer.design.ring.has_pin_bodies:
        for pin in names.all_numbered(names.PIN, reducer.design.ring.teeth):
            columns |= dict.fromkeys((*names.planar_joints(pin), *names.planar_speeds(pin)), zeros)
    return Turn(reducer, crank_angles, columns, np.arange(crank_angles.size), zeros, zeros)


def _disc_columns(reducer: RvReducer, springs: RvSprings) -> Iterator[tuple[str, Array]]:
    """Yield name and values (k,) of the logged columns of each disc at k crank angles: x, y [m], angle [rad]; speeds.

    The speeds are 0. `springs` are the contact springs at the crank angles.
    """
    eccentrics = reducer.design.gear.eccentricity * reducer.stage.eccentrics(springs.crank)
    for disc, name in enumerate(reducer.gears):
        x, y, angle = names.planar_joints(name)
        yield from ((x, eccentrics[:, disc, 0]), (y, eccentrics[:, disc, 1]))
        yield angle, -springs.crank / reducer.design.lobes
        yield from ((speed, np.zeros_like(springs.crank)) for speed in names.planar_speeds(name))


def _force_columns(reducer: RvReducer, springs: RvSprings, loads: RvLoads) -> Iterator[tuple[str, Array]]:
    """Yield name and values (k,) of the logged columns of contact forces [N] and moments [N m] at k crank angles.

    `loads` are the forces on the contact `springs`. Forces on a disc have moments about its centre; forces of the
    sockets on free ring pins have moments about the centre of the pin.
    """
    design, (tooth_friction, bearing_friction) = reducer.design, _friction(reducer, springs).on_discs(loads)
    directions = contact_gradients(springs, loads.displacements)[:, : springs.pins] + tooth_friction
    owners = mesh_gaps(reducer.at_rated_load, springs.crank).owner
    base_name = names.PIN if design.ring.kind == "pin" else names.LOBE
    pin_loads = np.zeros((design.ring.teeth, springs.crank.size, 3))
    for disc in range(springs.discs):
        wrenches = np.zeros_like(pin_loads)
        for contact in np.flatnonzero(springs.disc == disc):
            contact_direction = directions[:, contact, 3 * disc : 3 * disc + 3] * [1.0, 1.0, springs.lever]
            wrenches[owners[contact]] += loads.pins[:, contact, np.newaxis] * contact_direction
        centre = design.gear.eccentricity * reducer.stage.eccentrics(springs.crank)[:, disc]
        pin_loads += [_wrench_about(wrench, centre) for wrench in wrenches]
        for name, wrench in zip(names.all_numbered(base_name, design.ring.teeth), wrenches, strict=True):
            yield from _wrench_columns(names.of_disc(name, disc, springs.discs), wrench)
        for crank_index, name in enumerate(names.all_numbered(names.CRANK, reducer.cranks.count)):
            force = loads.cranks[:, disc, crank_index]
            moment = cross(reducer.stage.crank_positions(springs.crank)[:, crank_index], force)
            moment += (
                springs.lever * bearing_friction[disc, crank_index, 3 * disc + 2] * loads.bearings[:, disc, crank_index]
            )
            yield from _wrench_columns(names.of_disc(name, disc, springs.discs), np.column_stack([force, moment]))
    if design.ring.has_pin_bodies:
        for pin, name in enumerate(names.all_numbered(names.SOCKET, design.ring.teeth)):
            yield from _wrench_columns(name, _wrench_about(pin_loads[pin], -nominal_pin_centre(reducer, pin)))


def _wrench_about(wrench: Array, origin: Array) -> Array:
    """Return force and moment (k, 3) [N], [N m] about the point from which the present one is at `origin` [m]."""
    moment = wrench[:, 2] + cross(np.broadcast_to(origin, wrench[:, :2].shape), wrench[:, :2])
    return np.column_stack([wrench[:, :2], moment])


def _wrench_columns(pair: str, wrench: Array) -> Iterator[tuple[str, Array]]:
    """Yield name and values of the columns of the force and moment (k, 3) of a pair."""
    for quantity, values in zip((names.FORCE_X, names.FORCE_Y, names.MOMENT), wrench.T, strict=True):
        yield names.column(pair, quantity), values
