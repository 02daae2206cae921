"""Interfaces of motors, and the choice of a frame by torque and speed."""

import math
from dataclasses import dataclass
from typing import Literal

MotorName = Literal["auto", "nema17", "nema23", "nema34", "bldc16", "bldc19", "bldc25", "circle"]


@dataclass(frozen=True)
class MotorFlange:
    """Interface of a motor, and what motors of that frame drive.

    Attributes
    ----------
    name
        Its name in words.
    pilot, circle, thread
        Radii of pilot and bolt circle, and thread of the screws [m].
    shaft, shaft_length
        Radius and length of the shaft [m]; a radius of 0: unknown, coupled to the end of the crank.
    tapped
        Whether the holes of the motor are tapped, for screws from within the cover; else screws go into the cover.
    screws
        Number of screws.
    torque, power
        Largest continuous torque [N m] and power [W] of usual motors of the frame; 0: unknown.
    """

    name: str
    pilot: float
    circle: float
    thread: float
    shaft: float = 0.0
    shaft_length: float = 0.0
    tapped: bool = False
    screws: int = 4
    torque: float = 0.0
    power: float = 0.0

    def drives(self, torque: float, speed: float) -> bool:
        """Return whether usual motors of the frame drive a torque [N m] at a speed [rad/s]."""
        return abs(torque) <= self.torque and abs(torque * speed) <= self.power


MOTORS = {
    "nema17": MotorFlange(
        "NEMA 17", 11e-3, 15.5e-3 * math.sqrt(2.0), 3e-3, 2.5e-3, 22e-3, tapped=True, torque=0.45, power=100.0
    ),
    "nema23": MotorFlange(
        "NEMA 23", 19.05e-3, 23.57e-3 * math.sqrt(2.0), 4e-3, 3.175e-3, 20.6e-3, torque=1.9, power=190.0
    ),
    "nema34": MotorFlange("NEMA 34", 36.5125e-3, 49.21e-3, 5e-3, 4.7625e-3, 28.7e-3, torque=8.5, power=660.0),
    "bldc16": MotorFlange("BLDC, 16 mm circle", 4e-3, 8e-3, 3e-3, tapped=True),
    "bldc19": MotorFlange("BLDC, 19 mm circle", 5e-3, 9.5e-3, 3e-3, tapped=True),
    "bldc25": MotorFlange("BLDC, 25 mm circle", 6e-3, 12.5e-3, 3e-3, tapped=True),
}
"""NEMA ICS 16, as in the charts of Kollmorgen and piclist.com: pilots 22, 38.1 and 73.025 mm, holes in squares of 31,
47.14 and 69.6 mm, shafts of 5, 6.35 and 9.525 mm; M4 passes the holes of 23 (0.195 in), M5 those of 34 (0.218 in);
makers tap those of 17 M3, some 4.5 mm deep. Torque is that of usual steppers (48, 76 and 118 mm long), power that of
brushless motors of the frame (42, 57 and 86 mm), both assumed from catalogues. Outrunners have four M3 on a circle of
16, 19 or 25 mm; their shafts differ (assumed: none).
"""


def frames_for(torque: float, speed: float) -> tuple[MotorFlange, ...]:
    """Return the NEMA frames for a torque [N m] at a speed [rad/s], the smallest first."""
    return tuple(motor for motor in MOTORS.values() if motor.drives(torque, speed))
