"""Contact forces and transmission error of an RV reducer over a turn of its cranks, for the page."""

from typing import Any

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.units import ARCSECONDS
from cycloid_mj.measure.orders import output_order
from cycloid_mj.reducer import RvReducer
from cycloid_mj.scene import ring_places
from cycloid_mj.statics.rv import compute_rv_springs, solve_rv_loads
from cycloid_mj.statics.rv_film import running_friction
from cycloid_mj.statics.rv_motion import runout_at, rv_springs_at, static_rotations
from cycloid_mj.statics.rv_sheet import torque_on_carrier


def rv_forces(reducer: RvReducer, crank: Array, torque: float) -> dict[str, Any]:
    """Compute the contact forces on the discs of a running RV reducer at m crank angles against the ring [rad], (m,).

    `torque` [N m] acts on the output. All vectors are in the frame of the ring.

    Returns
    -------
    dict
        ``teeth`` and ``output``: ``force`` [N], shape (m, D * contacts), with ``position`` [m] and unit ``direction``,
        shape (m, D * contacts, 2), disc by disc; D is the number of discs, and contacts are pins for ``teeth``, cranks
        for ``output``. ``discs``: displacements of the discs from their ideal pose
        (x, y [m], rotation [rad]), shape (m, D, 3); ``output_turn``: rotation of the carrier from its ideal angle
        [rad], shape (m,); ``share``: share of each disc in the torque on the carrier, shape (m, D).
    """
    springs, carrier_torque = compute_rv_springs(reducer, crank), torque_on_carrier(reducer, torque)
    loads = solve_rv_loads(springs, carrier_torque, running_friction(reducer, crank, float(np.sign(carrier_torque))))
    normal = springs.tooth_slope[..., :2]
    disc_count, crank_count, shape = springs.discs, reducer.cranks.count, (len(crank), springs.discs, -1)
    bearing_forces = loads.bearings
    bearing_directions = loads.cranks / np.maximum(bearing_forces, np.finfo(float).tiny)[..., np.newaxis]
    axes = reducer.stage.crank_positions(crank)[:, np.newaxis]
    centres = reducer.design.gear.eccentricity * reducer.stage.eccentrics(crank)[:, :, np.newaxis]
    moments = axes[..., 0] * loads.cranks[..., 1] - axes[..., 1] * loads.cranks[..., 0]
    disc_moments = moments.sum(axis=2)
    poses = loads.displacements[:, : 3 * disc_count].reshape(shape) / [1.0, 1.0, springs.lever]
    return {
        "teeth": {
            "force": loads.pins,
            "position": np.tile(ring_places(reducer), (len(crank), disc_count, 1))
            + reducer.design.ring.pin_radius * normal,
            "direction": normal,
        },
        "output": {
            "force": bearing_forces.reshape(len(crank), disc_count * crank_count),
            "position": (axes + centres).reshape(len(crank), disc_count * crank_count, 2),
            "direction": bearing_directions.reshape(len(crank), disc_count * crank_count, 2),
        },
        "discs": poses,
        "output_turn": loads.carrier_turn,
        "share": disc_moments / np.where(disc_moments.sum(axis=1) == 0.0, 1.0, disc_moments.sum(axis=1))[:, np.newaxis],
    }


def rv_error(reducer: RvReducer, crank: Array, torque: float) -> Array:
    """Compute the transmission error [arcsec], mean subtracted, at m angles of the cranks against the ground [rad].

    `torque` [N m] acts on the output. Friction is left out, the run-out of the output is included.
    """
    rotations = static_rotations(reducer, rv_springs_at(reducer, crank), torque)
    output_error = ARCSECONDS * (reducer.member.sense * rotations[:, 1] + runout_at(reducer, crank))
    return np.asarray(output_error - output_error.mean())


def rv_orders(reducer: RvReducer) -> list[tuple[float, str]]:
    """Return order [cycles per turn of the cranks] and name of the periodic errors of cranks, planets and output."""
    crank_order = reducer.mesh_periods / reducer.design.lobes
    return [
        (crank_order, "cranks"),
        (crank_order * reducer.planet.planet_teeth, "planet mesh"),
        *([(float(output_order(reducer)), "run-out of the output")] if reducer.has_runout else []),
    ]
