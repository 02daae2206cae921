"""Runs of the ideal mechanism with known waves, for the tests of what judges runs."""

import numpy as np

from cycloid_mj.design import Design, dump
from cycloid_mj.record import Run
from cycloid_mj.run import schedule

LOBES, ECCENTRICITY = 35, 1e-3
SPIN = 7.0


def ideal_run(design: Design, wave: float = 0.0, ratio: float = LOBES) -> Run:
    """The ideal mechanism at the samples of a design's run, its speeds with a wave of 36 a turn."""
    steps = schedule(design)
    time = steps.stride * steps.timestep * np.arange(steps.samples)
    theta = design.drive.speed * time
    centre = 1j * ECCENTRICITY * np.exp(1j * theta)
    velocity = 1j * design.drive.speed * centre
    columns = {"crank_angle": theta, "crank_speed": np.full_like(time, design.drive.speed)}
    columns |= {"gear_x": centre.real, "gear_y": centre.imag, "gear_vx": velocity.real, "gear_vy": velocity.imag}
    for part in ("gear", "output"):
        columns |= {f"{part}_angle": -theta / ratio, f"{part}_speed": np.full_like(time, -design.drive.speed / LOBES)}
    for name in ("gear_speed", "output_speed", "gear_vx"):
        columns[name] = columns[name] + wave * np.cos(36 * theta)
    stem = "pin" if design.ring.kind == "pin" else "lobe"
    pairs = [*(f"{stem}_{i}" for i in range(1, 37)), "cam", *(f"output_pin_{i}" for i in range(1, 9))]
    pairs += [f"socket_{i}" for i in range(1, 37)] if design.ring.has_sockets else []
    names = ["crank_torque", "contacts", "penetration", "peak_force"]
    names += ["pin_1_angle"] if design.ring.has_moving_pins else []
    names += [f"{pair}{ending}" for pair in pairs for ending in ("_force_x", "_force_y", "_moment", "_peak_force")]
    columns |= {name: np.zeros_like(time) for name in names}
    columns["load_torque"] = np.full_like(time, design.load.torque)
    if design.ring.has_moving_pins:
        columns |= {"pin_1_x": 0.6e-6 * np.cos(theta), "pin_1_y": 0.6e-6 * np.sin(theta)}
        columns["pin_1_speed"] = np.full_like(time, SPIN)
    return Run(
        time, columns, dict.fromkeys(columns, "1"), {"design": design.name}, {"design.toml": dump(design).encode()}
    )


def ideal_runs(designs):
    """The pin design's gear is the rougher one under load, and the calmer one without."""
    loaded = [design.load.torque != 0.0 for design in designs]
    rough = [(design.ring.kind == "pin") == load for design, load in zip(designs, loaded, strict=True)]
    return [ideal_run(design, 0.004 if more else 0.001) for design, more in zip(designs, rough, strict=True)]
