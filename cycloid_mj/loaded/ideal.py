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


def _peak(design: Design, kind: str, crank: Array, phase: float) -> float:
    """Give the largest force of a kind on the disc at a `phase` on the crank [N], as seen from the ring."""
    seen, turned = seen_from_ring(design), against_ring(design, crank)
    gear, output = tooth_profile(design), design.output
    torque = seen.load.torque * math.copysign(1.0, seen.drive.speed) / design.gear.discs
    ring = statics.ideal_load_sharing(gear, torque, turned + phase)
    pins = statics.ideal_output_forces(gear, output.pins, output.pin_circle_radius, torque, turned, phase)
    if kind == "output":
        return float(pins.max())
    if kind == "cam":
        held = statics.cam_force(ring, pins, turned + phase, body_force(design, crank, phase))
        return float(np.hypot(*held.T).max())
    return float(ring.forces.max())
