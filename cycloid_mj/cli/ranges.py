"""Allowed ranges of numeric flags."""

from dataclasses import dataclass


@dataclass(frozen=True)
class FlagRanges:
    """Least and largest value of each numeric flag: they stop mistakes of units, and work that would never end.

    Attributes
    ----------
    frames, turns
        Of an animation; turns of the crank.
    chord_error_um, offset_um, cam_bearing_bore_mm, motor_mm, motor_screws
        Of an export.
    point_q_mm
        Each coordinate of a point on the disc.
    rows
        Of a table, such as the points of a profile.
    workers
        Processes or threads.
    time_s
        Of a table of the kinematics.
    log_rate_hz
        Of a log that is made smaller.
    evaluations, starts
        Of an optimisation.
    angles
        Crank angles of a protocol.
    tolerance_samples, joint_samples
        Drives of a tolerance study, and of a population of joints.
    """

    frames: tuple[int, int] = (1, 20_000)
    turns: tuple[float, float] = (1e-3, 10_000.0)
    chord_error_um: tuple[float, float] = (0.001, 100.0)
    offset_um: tuple[float, float] = (0.0, 1000.0)
    cam_bearing_bore_mm: tuple[float, float] = (0.001, 10_000.0)
    motor_mm: tuple[float, float] = (0.5, 1000.0)
    motor_screws: tuple[int, int] = (2, 12)
    point_q_mm: tuple[float, float] = (-10_000.0, 10_000.0)
    rows: tuple[int, int] = (3, 1_000_000)
    workers: tuple[int, int] = (1, 4096)
    time_s: tuple[float, float] = (1e-12, 1e6)
    log_rate_hz: tuple[float, float] = (0.1, 1e5)
    evaluations: tuple[int, int] = (1, 1_000_000)
    starts: tuple[int, int] = (1, 1000)
    angles: tuple[int, int] = (1, 360)
    tolerance_samples: tuple[int, int] = (2, 1_000_000)
    joint_samples: tuple[int, int] = (2, 100_000)


RANGES = FlagRanges()
