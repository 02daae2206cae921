"""Equilibrium under Coulomb's friction at one crank angle, with the normals of exact curves."""

import numpy as np
from scipy.optimize import root

from cycloid_mj.base.array import Array
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import Springs
from cycloid_mj.validate.displaced import cam_offsets, exact_contacts


def pushes(reducer: Reducer, springs: Springs, z: Array) -> Array:
    """Compute the generalised force of each contact, with its friction, per normal force [1], shape (n, u).

    Normals are those of the exact curves at departures z [m], by search; the angle is the first of the springs.
    """
    slopes = exact_contacts(reducer, float(springs.crank[0]), z)[1]
    return slopes + (springs.contacts.friction_per_force[0] if springs.contacts.friction_per_force.size else 0.0)


def cam_pushes(springs: Springs, z: Array, ways: Array) -> Array:
    """Compute the generalised force of each cam that pushes its disc along a way (D, 2) [1], shape (D, u)."""
    found = np.zeros((len(ways), z.size))
    for disc, way in enumerate(ways):
        found[disc, 3 * disc : 3 * disc + 2] = way + springs.contacts.cam_lateral * np.array([-way[1], way[0]])
        found[disc, 3 * disc + 2] = springs.contacts.cam_friction_per_force
    return found


def left_over(reducer: Reducer, springs: Springs, z: Array, forces: Array, load: Array) -> Array:
    """Compute what forces of the contacts (n,) [N], and of cams that are pressed by z [m], leave of a load (u,) [N]."""
    ways = cam_offsets(reducer, float(springs.crank[0]), z)
    away = np.linalg.norm(ways, axis=1)
    pressed = springs.contacts.cam_stiffness * np.maximum(away - reducer.design.clearance.cam, 0.0)
    on_cams = pressed @ cam_pushes(springs, z, -ways / np.maximum(away, 1e-15)[:, np.newaxis])
    return np.asarray(load + forces @ pushes(reducer, springs, z) + on_cams)


def friction_borne(reducer: Reducer, springs: Springs, load: Array, most: float) -> float:
    """Compute up to which share of the friction parts without play carry a load (u,) [N], at the first crank angle.

    At their ideal places each contact is a linear spring that only pushes, and a cam one that pulls nowhere: a system
    that is homogeneous in departures and load. Friction comes on in steps of a hundredth until it has no solution, or
    one of forces a thousand times the load; at `most` it ends.
    """
    contacts, ideal = springs.contacts, np.zeros(load.size)
    discs = ideal[:-1].reshape(-1, 3)
    discs[:, :2] = contacts.cam_position[0]
    slopes, scale = exact_contacts(reducer, float(springs.crank[0]), ideal)[1], float(np.abs(load).max())
    unit = scale / contacts.cam_stiffness

    def left(z: Array, friction: float) -> Array:
        forces = contacts.stiffness[0] * np.maximum(-slopes @ z * unit, 0.0)
        found = load + forces @ (slopes + friction * contacts.friction_per_force[0])
        away = z[:-1].reshape(-1, 3)[:, :2] * unit
        across = friction * contacts.cam_lateral * np.stack([away[:, 1], -away[:, 0]], axis=1)
        found[:-1].reshape(-1, 3)[:, :2] -= contacts.cam_stiffness * (away - across)
        found[2:-1:3] += (
            friction * contacts.cam_friction_per_force * contacts.cam_stiffness * np.linalg.norm(away, axis=1)
        )
        return np.asarray(found / scale)

    z, borne = np.zeros(load.size), 0.0
    for friction in np.arange(0.0, most, 0.01):
        found = root(left, z, args=(friction,), method="lm")
        if np.abs(found.fun).max() > 1e-6 or np.abs(found.x[:-1].reshape(-1, 3)[:, :2]).max() > 1000.0:
            return borne
        z, borne = found.x, float(friction)
    return borne
