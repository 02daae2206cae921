"""A run made by hand: the closed form, with known deviations and the forces of ideal load sharing."""

import numpy as np

from cycloid_mj.base.record import Run
from cycloid_mj.design import Design, dump
from cycloid_mj.dynamics.mjcf import sensors
from cycloid_mj.geometry import kinematics, profile
from cycloid_mj.geometry.ideal_loads import ideal_load_sharing
from cycloid_mj.parts import output_centres
from cycloid_mj.parts.gear import tooth_profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bodies import build_mechanism
from cycloid_mj.scene.pose import ring_places

STEP = 1e-4
TORQUE = 36.0


def made_groups(design: Design) -> dict[str, dict[str, str]]:
    """Topics, columns and units, as ``simulate`` has them."""
    groups = {topic: dict(names) for topic, names in sensors(Reducer(design)).items()}
    groups["/reducer"] |= {"contacts": "1", "penetration": "m", "peak_force": "N"}
    groups["/reducer"] |= {"cam_friction_power": "W", "cam_normal_power": "W"}
    groups["/forces"] = {
        f"{pair.name}_{part}": unit
        for pair in build_mechanism(design).pairs
        for part, unit in (("force_x", "N"), ("force_y", "N"), ("moment", "N m"))
    }
    return groups


def made_run(
    design: Design, samples: int = 800, scale: float = 1.0, attachments: dict[str, bytes] | None = None
) -> Run:
    """A run at constant speed; `scale` is the size of its deviations from the closed form."""
    time = STEP * np.arange(samples)
    speed = design.drive.speed
    theta = speed * time
    gear = tooth_profile(design)
    turn = kinematics.gear_rotation(gear, theta)
    centre = kinematics.gear_centre(gear, theta) + scale * 1e-6 * np.stack([np.sin(3 * theta), np.cos(theta)], axis=1)
    tangent = kinematics.gear_centre_velocity(gear, theta, np.full_like(theta, speed))
    columns = {name: np.zeros(samples) for names in made_groups(design).values() for name in names}
    columns |= {
        "crank_angle": theta,
        "crank_speed": np.full_like(time, speed),
        "crank_torque": np.full_like(time, 1.1 * TORQUE / design.lobes),
        "gear_x": centre[:, 0],
        "gear_y": centre[:, 1],
        "gear_angle": turn + scale * 2e-5 * np.sin(5 * theta),
        "gear_vx": tangent[:, 0],
        "gear_vy": tangent[:, 1],
        "gear_speed": -speed / design.lobes + 0.003 * np.cos(36 * theta),
        "output_angle": turn - scale * 1e-5 * np.cos(2 * theta),
        "output_speed": np.full_like(time, -speed / design.lobes),
        "load_torque": np.full_like(time, TORQUE),
        "contacts": np.full_like(time, 40.0),
        "penetration": np.full_like(time, 1e-6),
        "peak_force": np.full_like(time, 1100.0),
        "cam_friction_power": np.full_like(time, 0.5),
    }
    if design.ring.has_moving_pins:
        for i in range(1, design.ring.teeth + 1):
            columns[f"pin_{i}_x"] = scale * 0.8e-6 * np.cos(theta + i)
            columns[f"pin_{i}_y"] = scale * 0.6e-6 * np.sin(theta - i)
            columns[f"pin_{i}_angle"] = 3.0 * theta + i
    columns |= _forces(design, columns)
    units = {name: unit for names in made_groups(design).values() for name, unit in names.items()}
    files = {"design.toml": dump(design).encode()} | (attachments or {})
    return Run(time, columns, units, {"design": design.name, "timestep_s": "2e-06", "steps": "40000"}, files)


def _forces(design: Design, columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The ring's contacts push the gear along their normals, each pin rests in its socket, the cam balances them."""
    gear, theta = tooth_profile(design), columns["crank_angle"]
    centre = np.stack([columns["gear_x"], columns["gear_y"]], axis=1)
    zeta = profile.pin_angles(gear)
    inwards = -profile.unit(zeta - profile.conjugate_alpha(gear, zeta + theta[:, np.newaxis]))
    sizes = ideal_load_sharing(gear, np.full_like(theta, TORQUE), theta).forces
    stem = "pin" if design.ring.kind == "pin" else "lobe"
    moving, holder = design.ring.has_moving_pins, "socket" if design.ring.has_sockets else "sleeve"
    found: dict[str, np.ndarray] = {}
    total = np.zeros_like(centre)
    for i, place in enumerate(ring_places(Reducer(design))):
        force = sizes[:, i : i + 1] * inwards[:, i]
        pin = np.stack([columns[f"pin_{i + 1}_{axis}"] for axis in "xy"], axis=1) if moving else 0.0
        point = place + pin + design.ring.pin_radius * inwards[:, i]
        found |= _columns(f"{stem}_{i + 1}", force, point - centre)
        if moving:
            found |= _columns(f"{holder}_{i + 1}", force, np.zeros_like(force))
        total += force
    found |= _columns("cam", -total, np.zeros_like(total))
    for k, place in enumerate(output_centres(Reducer(design))):
        force = 100.0 * (k + 1) * np.stack([-np.cos(theta), -np.sin(theta)], axis=1)
        found |= _columns(f"output_pin_{k + 1}", force, place + 0.0 * force)
    return found


def _columns(name: str, force: np.ndarray, arm: np.ndarray) -> dict[str, np.ndarray]:
    moment = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
    return {f"{name}_force_x": force[:, 0], f"{name}_force_y": force[:, 1], f"{name}_moment": moment}
