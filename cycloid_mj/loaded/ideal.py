"""Ideal sharing of a design's own load: contacts alike, without clearance or friction, and every disc its share."""

import math

import numpy as np

from cycloid_mj import statics
from cycloid_mj.design import Design
from cycloid_mj.loaded.springs import body_force
from cycloid_mj.mechanism.reducer import phases
from cycloid_mj.member import against_ring, seen_from_ring
from cycloid_mj.modification import tooth_profile
from cycloid_mj.types import Array


def ideal_peak(design: Design, kind: str, crank_angle: Array) -> float:
    """Give the largest force [N] that ideal sharing of ``load.torque`` puts on a contact of a kind."""
    return max(_peak(design, kind, crank_angle, phase) for phase in phases(design))


def ideal_cam(design: Design, crank_angle: Array) -> Array:
    """Compute the force of each cam [N] by ideal sharing of ``load.torque``, shape (m, discs), at crank angles (m,)."""
    return np.stack([_cam(design, crank_angle, phase) for phase in phases(design)], axis=-1)


def _cam(design: Design, crank: Array, phase: float) -> Array:
    ring, pins, turned = _shared(design, crank, phase)
    held = statics.cam_force(ring, pins, turned + phase, body_force(design, crank, phase))
    return np.asarray(np.hypot(*held.T))


def _peak(design: Design, kind: str, crank: Array, phase: float) -> float:
    """Give the largest force of a kind on the disc at a `phase` on the crank [N], as seen from the ring."""
    if kind == "cam":
        return float(_cam(design, crank, phase).max())
    ring, pins, _ = _shared(design, crank, phase)
    return float((pins if kind == "output" else ring.forces).max())


def _shared(design: Design, crank: Array, phase: float) -> tuple[statics.LoadSharing, Array, Array]:
    """Share the load of the disc at a `phase`: the ring, the output pins, and the crank's angles against the ring."""
    seen, turned = seen_from_ring(design), against_ring(design, crank)
    gear, output = tooth_profile(design), design.output
    torque = seen.load.torque * math.copysign(1.0, seen.drive.speed) / design.gear.discs
    ring = statics.ideal_load_sharing(gear, torque, turned + phase)
    pins = statics.ideal_output_forces(gear, output.pins, output.pin_circle_radius, torque, turned, phase)
    return ring, pins, turned
