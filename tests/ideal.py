"""Runs of the ideal mechanism with what a test adds to it: the one maker of runs for the tests of what judges runs."""

from collections.abc import Callable

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.names import CAM, FORCE_X, FORCE_Y, MOMENT, OUTPUT_PIN, PEAK_FORCE, all_numbered, column
from cycloid_mj.base.record import Run
from cycloid_mj.design import Design, dump
from cycloid_mj.dynamics.run import schedule
from cycloid_mj.reducer import Reducer

LOBES, ECCENTRICITY = 35, 1e-3
SPIN = 7.0

Added = float | Array | Callable[[Array], Array]


def ideal_mechanism(design: Design, time: Array | None = None, **added: Added) -> Run:
    """The ideal mechanism of a preset at its log rate, the closed form in complex numbers; nothing presses on anything.

    `added` is added to the column of that name, or is one: a number, an array, or a function of the crank angle.
    """
    omega, ramp, rate = design.drive.speed, design.drive.ramp, design.settings.log_rate
    time = np.arange(round((ramp + design.drive.hold) * rate)) / rate if time is None else time
    early = np.minimum(time, ramp)
    theta = omega * (early**2 / (2 * ramp) if ramp else 0.0) + omega * (time - early)
    speed = omega * (early / ramp if ramp else np.ones_like(time))
    centre = 1j * ECCENTRICITY * np.exp(1j * theta)
    velocity = 1j * speed * centre
    columns = {"crank_angle": theta, "crank_speed": speed}
    columns |= {"gear_x": centre.real, "gear_y": centre.imag, "gear_vx": velocity.real, "gear_vy": velocity.imag}
    for part in ("gear", "output"):
        columns |= {f"{part}_angle": -theta / LOBES, f"{part}_speed": -speed / LOBES}
    ring = design.ring
    pairs = [*all_numbered("pin" if ring.kind == "pin" else "lobe", ring.teeth), CAM]
    pairs += [*all_numbered(OUTPUT_PIN, design.output.pins), *all_numbered("socket", ring.teeth * ring.has_sockets)]
    names = ["crank_torque", "load_torque", "contacts", "penetration", "peak_force"]
    names += ["pin_1_x", "pin_1_y", "pin_1_angle", "pin_1_speed"] if ring.has_moving_pins else []
    names += [column(pair, part) for pair in pairs for part in (FORCE_X, FORCE_Y, MOMENT, PEAK_FORCE)]
    columns |= dict.fromkeys(names, np.zeros_like(time))
    for name, value in added.items():
        columns[name] = columns.get(name, 0.0) + np.broadcast_to(value(theta) if callable(value) else value, time.shape)
    files = {"design.toml": dump(design).encode()}
    return Run(time, columns, dict.fromkeys(columns, "1"), {"design": design.name}, files)


def ideal_run(design: Design, wave: float = 0.0, ratio: float = LOBES) -> Run:
    """The ideal mechanism at the samples of a design's run under its load, its speeds with a wave of 36 a turn."""
    steps = schedule(Reducer(design))
    added = dict.fromkeys(("gear_speed", "output_speed", "gear_vx"), lambda theta: wave * np.cos(36 * theta))
    added |= dict.fromkeys(("gear_angle", "output_angle"), lambda theta: theta / LOBES - theta / ratio)
    if design.ring.has_moving_pins:
        added |= {"pin_1_x": lambda theta: 0.6e-6 * np.cos(theta), "pin_1_y": lambda theta: 0.6e-6 * np.sin(theta)}
        added["pin_1_speed"] = SPIN
    time = steps.stride * steps.timestep * np.arange(steps.samples)
    return ideal_mechanism(design, time, load_torque=design.load.torque, **added)
