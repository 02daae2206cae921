"""Validation step "cam": the full load of the cam, from ring, output pins, weight and inertia of the disc.

The ideal reducer (almost no clearance, no friction, stiff cam) is compared with `ideal_loads.cam_force`: first slowly
under load, then at rated speed under so little load that inertia and weight are a large share. For the real design the
logged forces on the disc must equal its mass times its acceleration by the closed form.
"""

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.base.record import Run
from cycloid_mj.base.validation import ValidationRow, deviation, relative
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.geometry import ideal_loads, kinematics
from cycloid_mj.parts import gear_solid, mass_properties
from cycloid_mj.parts.gear import tooth_profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate import rig
from cycloid_mj.validate.rig import FIXED, FREE, reducer_of

IDEAL = [
    *rig.without_friction(),
    *rig.clearances(1e-4),
    'contact.stiffness_law="uniform"',
    "settings.timestep_us=2.0",
]
STIFF_CAM = 2e11
"""Stiffness of an ideal cam [N/m]."""
SETTLED = 0.008
"""Time at which the load is applied and its transient has decayed [s]."""


def rows(quick: bool) -> list[ValidationRow]:
    """Return the rows of this step."""
    return [_slow_row(quick), *_fast_rows(quick), *_rated_rows()]


def _slow_row(quick: bool) -> ValidationRow:
    rpm = 100.0 if quick else 40.0
    design = reducer_of(FIXED, *IDEAL, *rig.without_gravity(), "contact.stiffness_n_m=1e7", "load.torque_nm=1.0")
    reducer = Reducer(design)
    run = _ideal_run(reducer, rpm, 60.0 / (rpm * design.ring.teeth))
    ours, ideal = run.forces("cam")[:, 0], statics_load(reducer, run["crank_angle"])
    return deviation("load of the cam, slow and ideal", ours, ideal, "N", "ring + output pins, closed form", 0.5)


def _fast_rows(quick: bool) -> list[ValidationRow]:
    """Compare the mean radial force in the rotating frame and the mean upward force, over one turn at rated speed."""
    design = reducer_of(
        FIXED, *IDEAL, "contact.stiffness_n_m=3e7", "load.torque_nm=0.5", "environment.gravity_y_m_s2=-98.0"
    )
    reducer = Reducer(design)
    run = _ideal_run(reducer, 1640.0, 60.0 / 1640.0)
    crank, speed = run["crank_angle"], run["crank_speed"]
    ours = run.forces("cam")[:, 0]
    inertia = body_force(reducer, crank, speed)
    ideal = statics_load(reducer, crank, inertia)
    outward = np.stack([-np.sin(crank), np.cos(crank)], axis=-1)
    radial, expected = (float(np.mean(np.sum(force * outward, axis=1))) for force in (ours, ideal))
    up, weight = (float(np.mean(force[:, 1])) for force in (ours, ideal))
    return [
        relative("radial load of the cam, fast and ideal", radial, expected, "N", "ring + output + m c w^2", 1.5),
        relative("upward load of the cam, fast, at 10 g", up, weight, "N", "ring + output + weight", 0.3),
    ]


def _rated_rows() -> list[ValidationRow]:
    """Compare the cam load of a run at rated load with the balance of forces and with the ideal load."""
    run, design = rig.rated_run(FREE, 1640.0, 12)
    reducer = Reducer(design)
    crank, cam = run["crank_angle"], run.forces("cam")[:, 0]
    body = body_force(reducer, crank, run["crank_speed"])
    balance = -run.forces(design.tooth_pair).sum(axis=1) - run.forces("output").sum(axis=1) - body
    # The vibration of the disc has zero mean in the rotating frame.
    ours, balanced = (np.mean(_in_crank_frame(force, crank), axis=0, keepdims=True) for force in (cam, balance))
    ideal = statics_load(reducer, crank, body)
    return [
        deviation("load of the cam, rated, free pins", ours, balanced, "N", "m (g - a), ring, output, logged", 0.01),
        relative(
            "load of the cam, rated, free pins",
            float(rig.lengths(cam).mean()),
            float(rig.lengths(ideal).mean()),
            "N",
            "ideal, closed form",
            None,
            "clearance and cam compliance shift the load to pins farther from the pitch point; friction adds to it",
        ),
    ]


def statics_load(reducer: Reducer, crank: Array, force: npt.ArrayLike = (0.0, 0.0)) -> Array:
    """Compute the ideal force of the cam on the disc [N], shape (n, 2), with a `force` [N] on the disc."""
    design = reducer.design
    gear, torque, output = tooth_profile(design), design.load.torque, design.output
    ring = ideal_loads.ideal_load_sharing(gear, torque, crank)
    pins = ideal_loads.ideal_output_forces(gear, output.pins, output.pin_circle_radius, torque, crank)
    return ideal_loads.cam_force(ring, pins, crank, force)


def body_force(reducer: Reducer, crank: Array, speed: Array) -> Array:
    """Compute the weight of the disc less its mass times its ideal acceleration [N], shape (n, 2)."""
    design = reducer.design
    mass = mass_properties(gear_solid(reducer)).mass
    gravity = np.array([design.environment.gravity_x, design.environment.gravity_y])
    return mass * (gravity - kinematics.gear_centre_acceleration(tooth_profile(design), crank, speed))


def _ideal_run(reducer: Reducer, rpm: float, duration: float) -> Run:
    """Simulate an ideal reducer at a crank speed [rpm]; return the samples of a last duration [s]."""
    drive = f"drive.speed_rpm={rpm!r}", f"drive.hold_s={SETTLED + duration!r}"
    reducer = rig.with_changes(reducer, *drive, "load.rise_s=0.004", "settings.log_rate_hz=10000.0")
    compiled = build(reducer.design)
    rig.stiffen_cam(compiled, STIFF_CAM)
    run = simulate(reducer.design, compiled)
    return run.select(run.time >= run.time[-1] - duration)


def _in_crank_frame(force: Array, crank: Array) -> Array:
    """Transform forces (n, 2) to the directions along and across the eccentricity."""
    cos, sin = np.cos(crank), np.sin(crank)
    return np.stack([force[:, 1] * cos - force[:, 0] * sin, -force[:, 0] * cos - force[:, 1] * sin], axis=-1)
