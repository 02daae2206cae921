"""Equilibrium under Coulomb's friction at one crank angle, with the normals of exact curves."""

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import Springs
from cycloid_mj.validate.displaced import cam_ways, exact_contacts


def pushes(reducer: Reducer, springs: Springs, z: Array) -> Array:
    """Compute the generalised force of each contact, with its friction, per normal force [1], shape (n, u).

    Normals are those of the exact curves at departures z [m], by search; the angle is the first of the springs.
    """
    slopes = exact_contacts(reducer, float(springs.crank[0]), z)[1]
    return slopes + (springs.contacts.rubbing[0] if springs.contacts.rubbing.size else 0.0)


def cam_pushes(springs: Springs, z: Array, ways: Array) -> Array:
    """Compute the generalised force of each cam that pushes its disc along a way (D, 2) [1], shape (D, u)."""
    found = np.zeros((len(ways), z.size))
    for disc, way in enumerate(ways):
        found[disc, 3 * disc : 3 * disc + 2] = way
        found[disc, 3 * disc + 2] = springs.contacts.cam_rubbing
    return found


def left_over(reducer: Reducer, springs: Springs, z: Array, forces: Array, load: Array) -> Array:
    """Compute what forces of the contacts (n,) [N], and of cams that are pressed by z [m], leave of a load (u,) [N]."""
    ways = cam_ways(reducer, float(springs.crank[0]), z)
    away = np.linalg.norm(ways, axis=1)
    pressed = springs.contacts.cam_stiffness * np.maximum(away - reducer.design.clearance.cam, 0.0)
    on_cams = pressed @ cam_pushes(springs, z, -ways / np.maximum(away, 1e-15)[:, np.newaxis])
    return np.asarray(load + forces @ pushes(reducer, springs, z) + on_cams)
