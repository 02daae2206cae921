"""Ideal load sharing: identical contacts without clearance and friction, and equal discs."""

import math

import numpy as np

from cycloid_mj.base import names
from cycloid_mj.base.array import Array
from cycloid_mj.geometry import ideal_loads
from cycloid_mj.geometry.rv_loads import IdealRvLoads, ideal_rv_loads
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics.friction import ideal_mesh_loss
from cycloid_mj.statics.rv_sheet import ideal_rv, torque_on_carrier
from cycloid_mj.statics.springs import body_force


def ideal_peak(reducer: Reducer, kind: str, crank_angle: Array) -> float:
    """Compute the largest force [N] of a kind of contact at crank angles (m,) [rad], by ideal load sharing.

    The torque is ``load.torque`` of the design; `kind` is "cam", "output" (pins) or that of the teeth, "pin_gear" or
    "tooth". An RV reducer has "crank_bearing" and "planet_mesh" instead of "cam" and "output".
    """
    if isinstance(reducer, RvReducer):
        return _ideal_rv_peak(reducer, kind, crank_angle)
    return max(_ideal_peak_of_disc(reducer, kind, crank_angle, phase) for phase in reducer.phases)


def ideal_rv_at(reducer: RvReducer, crank_angle: Array) -> IdealRvLoads:
    """Compute the ideal forces of pins and cranks under ``load.torque`` at angles of the cranks (m,) [rad]."""
    against_ring = reducer.member.against_ring(reducer.member.driven_angle(crank_angle))
    return ideal_rv_loads(reducer.stage, torque_on_carrier(reducer, reducer.design.load.torque), against_ring)


def _ideal_rv_peak(reducer: RvReducer, kind: str, crank_angle: Array) -> float:
    """Compute the largest force [N] of a kind of contact of an RV reducer at crank angles (m,) [rad].

    `kind` is "crank_bearing", "planet_mesh" or that of the teeth, "pin_gear" or "tooth". Load sharing is ideal; planets
    share the torque of the sun equally.
    """
    if kind == names.PLANET_MESH:
        sun_torque = reducer.share * abs(reducer.design.load.torque) / reducer.stage.to_carrier
        return sun_torque / (reducer.cranks.count * reducer.planet_mesh.sun_base)
    loads = ideal_rv_at(reducer, crank_angle)
    return float((loads.bearings if kind == names.CRANK_BEARING else loads.pins).max())


def ideal_rv_losses(reducer: RvReducer, crank: Array, friction: float) -> tuple[float, float, float]:
    """Compute the friction losses of an RV reducer with ideal load sharing, relative to the power of the carrier.

    Torque and speed of the carrier are taken relative to the ring. The relative losses are the same at all torques.

    Parameters
    ----------
    crank
        Crank angles [rad], shape (n,), over which the loss of the mesh is averaged.
    friction
        Friction coefficient of the mesh [1].

    Returns
    -------
    tuple of float
        Losses of mesh, crank bearings and planets, each divided by the power [1].

    Notes
    -----
    The carrier, of the torque T, turns at w/(N-1) against the ring if the cranks turn at w. The mesh of all discs
    carries the torque T (R-1)/R (N-1)/N, with N ring teeth and the ratio R of sun and carrier. The friction of a crank
    bearing acts at the radius of its eccentric, under its force of ideal sharing. The planets transmit the power of the
    carrier and the losses of mesh and bearings, T/R (1 + losses) on the sun.
    """
    ratio, design = reducer.stage.to_carrier, reducer.design
    disc_share = (ratio - 1.0) / ratio * design.lobes / design.ring.teeth
    mesh_loss = disc_share * ideal_mesh_loss(reducer, crank, friction)
    bearing_force = ideal_rv(reducer, 1.0).bearings.sum(axis=(1, 2)).mean()
    carrier_power = reducer.share * abs(reducer.output_speed)
    bearing_loss = design.friction_of(names.CRANK_BEARING) * bearing_force * reducer.cranks.eccentric_radius
    relative_loss = bearing_loss * reducer.crank_speed / carrier_power
    flank_force = reducer.share / ratio * (1.0 + mesh_loss + relative_loss) / reducer.planet_mesh.sun_base
    planet_loss = design.friction_of(names.PLANET_MESH) * flank_force * reducer.planet_mesh.arm
    return mesh_loss, float(relative_loss), float(planet_loss * reducer.planet_mesh_speed / carrier_power)


def ideal_cam(reducer: Reducer, crank_angle: Array) -> Array:
    """Compute the force of each cam [N] by ideal sharing of ``load.torque``, shape (m, discs), at crank angles (m,)."""
    return np.stack([_cam_force(reducer, crank_angle, phase) for phase in reducer.phases], axis=-1)


def _cam_force(reducer: Reducer, crank: Array, phase: float) -> Array:
    """Compute the magnitude of the cam's force on a disc [N], shape (m,), with weight and inertia of the disc.

    `crank` (m,) [rad] are the crank angles, and `phase` [rad] is the phase of the disc on the crank.
    """
    ring_loads, pin_forces, crank_in_ring = _share_load(reducer, crank, phase)
    force = ideal_loads.cam_force(ring_loads, pin_forces, crank_in_ring + phase, body_force(reducer, crank, phase))
    return np.asarray(np.hypot(*force.T))


def _ideal_peak_of_disc(reducer: Reducer, kind: str, crank: Array, phase: float) -> float:
    """Compute the largest force [N] of a kind of contact on the disc at a `phase` [rad], at crank angles (m,) [rad]."""
    if kind == "cam":
        return float(_cam_force(reducer, crank, phase).max())
    ring_loads, pin_forces, _ = _share_load(reducer, crank, phase)
    return float((pin_forces if kind == "output" else ring_loads.forces).max())


def _share_load(reducer: Reducer, crank: Array, phase: float) -> tuple[ideal_loads.LoadSharing, Array, Array]:
    """Compute the ideal loads of a disc on the ring teeth and the output pins at m crank angles [rad], shape (m,).

    `phase` [rad] is the angle of the disc's eccentric on the crank.

    Returns
    -------
    ring, pin_forces, ring_crank
        Load sharing of the ring teeth, forces of the disc on the output pins [N] (m, pins), and the crank angles in the
        frame of the ring [rad] (m,).
    """
    design = reducer.design
    gear, output, ring_crank = reducer.tooth_profile, design.output, reducer.member.against_ring(crank)
    torque = reducer.share * math.copysign(1.0, design.drive.speed) * design.load.torque / design.gear.discs
    ring_loads = ideal_loads.ideal_load_sharing(gear, torque, ring_crank + phase)
    pin_forces = ideal_loads.ideal_output_forces(gear, output.pins, output.pin_circle_radius, torque, ring_crank, phase)
    return ring_loads, pin_forces, ring_crank
