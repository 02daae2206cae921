"""Trials of a comparison from runs of the ideal mechanism with known waves."""

import math
from dataclasses import replace

import numpy as np
from ideal import ideal_mechanism

from cycloid_mj.analysis import Series
from cycloid_mj.comparison import STARTS, Trial, measure_run, settle_run
from cycloid_mj.design import PRESETS, Design, override

DT = 1e-4
SPEED = math.radians(1.0) / DT
"""1 deg of crank in a sample, so that turns and waves end on samples."""
TURNS, LOBES, ECCENTRICITY, HOLE = 6, 35, 1e-3, 26e-3


def designed(preset: str, *changes: str, turns: float = TURNS + 1) -> Design:
    """A turn to settle, then whole turns."""
    hold = turns * 360 * DT + 0.01 + DT
    drive = ["drive.speed_rpm=1666.6666666666667", "drive.ramp_s=0.0", f"drive.hold_s={hold!r}"]
    return override(PRESETS[preset], [*drive, *changes])


def motion_of(preset: str = "pin", *changes: str, **added) -> Series:
    return settle_run(ideal_mechanism(designed(preset, *changes), **added))


def trial_of(preset: str, *changes: str, **added) -> Trial:
    motion = motion_of(preset, *changes, **added)
    return Trial(motion.design, measure_run(motion, f"{preset}.mcap"))


def waving(size: float):
    return lambda theta: size * np.cos(20 * theta)


def pair(load: float = 0.0, pin: float = 0.002, nonpin: float = 0.001) -> list[Trial]:
    change = f"load.torque_nm={load!r}"
    return [
        trial_of("pin", change, gear_speed=waving(pin), output_speed=waving(pin)),
        trial_of("nonpin", change, gear_speed=waving(nonpin), output_speed=waving(2 * nonpin)),
    ]


def started_pair() -> list[Trial]:
    """Idle designs with eight starts each, of which each fluctuates a little more than the one before it."""
    starts = [pair(0.0, pin=0.004 + 1e-4 * number, nonpin=0.001 + 1e-4 * number) for number in range(STARTS)]
    return [replace(starts[0][one], others=tuple(each[one].measures for each in starts[1:])) for one in (0, 1)]
