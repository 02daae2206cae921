"""Validation step "cam": the full load of the cam, from ring, output pins, weight and inertia of the disc.

The ideal reducer (almost no clearance, no friction, stiff cam) is compared with `ideal_loads.cam_force`: first slowly
under load, then at rated speed under so little load that inertia and weight are a large share. For the real design the
logged forces on the disc must equal its mass times its acceleration by the closed form.
"""

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.base.record import Run
from cycloid_mj.base.validation import ValidationRow, deviation_row, relative
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.geometry import ideal_loads, kinematics
from cycloid_mj.parts import gear_solid, mass_properties
from cycloid_mj.parts.gear import tooth_profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate import rig
from cycloid_mj.validate.rig import FIXED, FREE, design_of_kind
from cycloid_mj.validate.sharing import SHARING

IDEAL = [
    *rig.without_friction(),
    *rig.clearances(1e-4),
    'contact.stiffness_law="uniform"',
    "settings.timestep_us=2.0",
]


def rows(quick: bool) -> list[ValidationRow]:
    """Return the comparisons of this validation step, the rows of its table; `quick` shortens a simulation."""
    return [_slow_ideal_row(quick), *_fast_ideal_rows(quick), *_rated_rows()]


def _slow_ideal_row(quick: bool) -> ValidationRow:
    """Compare the cam's force on a disc of the ideal reducer, turning slowly under load, with `statics_load`.

    This closed form is the equilibrium of the disc with ideally shared forces of ring pins and output pins, without
    weight and inertia. With `quick` the crank turns at 100 rpm instead of 40.
    """
    rpm = 100.0 if quick else 40.0
    design = design_of_kind(FIXED, *IDEAL, *rig.without_gravity(), "contact.stiffness_n_m=1e7", "load.torque_nm=1.0")
    reducer = Reducer(design)
    run = _ideal_run(reducer, rpm, 60.0 / (rpm * design.ring.teeth))
    simulated_force, expected_force = run.forces("cam")[:, 0], statics_load(reducer, run["crank_angle"])
    return deviation_row(
        "load of the cam, slow and ideal", simulated_force, expected_force, "N", "ring + output pins, closed form", 0.5
    )


def _fast_ideal_rows(quick: bool) -> list[ValidationRow]:
    """Compare the mean force of the cam on a fast disc with `statics_load`: radial and upward components.

    The reducer has almost no clearance, no friction and a stiff cam. It runs at 1640 rpm under 0.5 N m, with a gravity
    of 98 m/s2. `quick` is ignored.
    """
    design = design_of_kind(
        FIXED, *IDEAL, "contact.stiffness_n_m=3e7", "load.torque_nm=0.5", "environment.gravity_y_m_s2=-98.0"
    )
    reducer = Reducer(design)
    run = _ideal_run(reducer, 1640.0, 60.0 / 1640.0)
    crank_angle, speed = run["crank_angle"], run["crank_speed"]
    simulated_force = run.forces("cam")[:, 0]
    disc_force = body_force(reducer, crank_angle, speed)
    expected_force = statics_load(reducer, crank_angle, disc_force)
    outward_direction = np.stack([-np.sin(crank_angle), np.cos(crank_angle)], axis=-1)
    mean_radial, expected_radial = (
        float(np.mean(np.sum(force * outward_direction, axis=1))) for force in (simulated_force, expected_force)
    )
    upward, expected_upward = (float(np.mean(force[:, 1])) for force in (simulated_force, expected_force))
    return [
        relative(
            "radial load of the cam, fast and ideal", mean_radial, expected_radial, "N", "ring + output + m c w^2", 1.5
        ),
        relative("upward load of the cam, fast, at 10 g", upward, expected_upward, "N", "ring + output + weight", 0.3),
    ]


def _rated_rows() -> list[ValidationRow]:
    """Compare the cam's force at rated load with equilibrium of the other logged forces, and with ideal load sharing.

    The second row has no bound, as clearance and a compliant cam change the load sharing.
    """
    run, design = rig.rated_run(FREE, 1640.0, 12)
    reducer = Reducer(design)
    crank_angle, cam_force = run["crank_angle"], run.forces("cam")[:, 0]
    disc_force = body_force(reducer, crank_angle, run["crank_speed"])
    balancing_force = -run.forces(design.tooth_pair).sum(axis=1) - run.forces("output").sum(axis=1) - disc_force
    # The vibration of the disc has zero mean in the rotating frame.
    mean_cam_force, mean_balancing_force = (
        np.mean(_in_crank_frame(force, crank_angle), axis=0, keepdims=True) for force in (cam_force, balancing_force)
    )
    ideal_force = statics_load(reducer, crank_angle, disc_force)
    return [
        deviation_row(
            "load of the cam, rated, free pins",
            mean_cam_force,
            mean_balancing_force,
            "N",
            "m (g - a), ring, output, logged",
            0.01,
        ),
        relative(
            "load of the cam, rated, free pins",
            float(rig.vector_lengths(cam_force).mean()),
            float(rig.vector_lengths(ideal_force).mean()),
            "N",
            "ideal, closed form",
            None,
            "clearance and cam compliance shift the load to pins farther from the pitch point; friction adds to it",
        ),
    ]


def statics_load(reducer: Reducer, crank: Array, force: npt.ArrayLike = (0.0, 0.0)) -> Array:
    """Compute the ideal force of the cam on the disc in closed form [N], shape (n, 2), at n crank angles `crank` [rad].

    It is in equilibrium with the ideally shared forces of ring pins and output pins at the design's load, and with a
    `force` [N] on the disc, such as `body_force`.
    """
    design = reducer.design
    gear, torque, output = tooth_profile(design), design.load.torque, design.output
    tooth_loads = ideal_loads.ideal_load_sharing(gear, torque, crank)
    output_forces = ideal_loads.ideal_output_forces(gear, output.pins, output.pin_circle_radius, torque, crank)
    return ideal_loads.cam_force(tooth_loads, output_forces, crank, force)


def body_force(reducer: Reducer, crank: Array, speed: Array) -> Array:
    """Compute the weight of the disc minus its mass times its ideal acceleration [N], shape (n, 2)."""
    design = reducer.design
    mass = mass_properties(gear_solid(reducer)).mass
    gravity = np.array([design.environment.gravity_x, design.environment.gravity_y])
    return mass * (gravity - kinematics.gear_centre_acceleration(tooth_profile(design), crank, speed))


def _ideal_run(reducer: Reducer, rpm: float, duration: float) -> Run:
    """Simulate a reducer with a nearly rigid cam at a crank speed [rpm]; return samples of the last `duration` [s]."""
    drive_changes = f"drive.speed_rpm={rpm!r}", f"drive.hold_s={SHARING.settled + duration!r}"
    reducer = rig.with_changes(reducer, *drive_changes, "load.rise_s=0.004", "settings.log_rate_hz=10000.0")
    model = build(reducer.design)
    rig.stiffen_cam(model, SHARING.stiff_cam)
    run = simulate(reducer.design, model)
    return run.select(run.time >= run.time[-1] - duration)


def _in_crank_frame(force: Array, crank: Array) -> Array:
    """Transform forces (n, 2) to the directions along and across the eccentricity."""
    cos, sin = np.cos(crank), np.sin(crank)
    return np.stack([force[:, 1] * cos - force[:, 0] * sin, -force[:, 0] * cos - force[:, 1] * sin], axis=-1)
