"""Friction torque on the crank as a function of output torque, crank speed and the driving shaft."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from cycloid_mj.base.powers import Powers

Rows = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class FrictionMap:
    """Map of friction: linear interpolation; beyond the largest torque the last line continues."""

    torques: tuple[float, ...]
    """Torques on the output [N m], rising from 0, shape (n,)."""
    speeds: tuple[float, ...]
    """Speeds of the crank [rad/s], rising, shape (m,); outside, the nearest is used."""
    driving: Rows
    driven: Rows
    """Friction torque on the crank [N m] where the crank drives, and where the output drives, shape (m, n)."""

    def torque(self, torque: float, speed: float, driving: bool) -> float:
        """Compute the torque of friction [N m] under a torque on the output [N m] at a speed of the crank [rad/s]."""
        lost = [_interpolate(abs(torque), self.torques, row) for row in (self.driving if driving else self.driven)]
        return float(np.interp(abs(speed), self.speeds, lost))

    def efficiency(self, torque: float, speed: float, ratio: float, driving: bool) -> float:
        """Compute the efficiency; 0 where friction locks the output (self-locking)."""
        return joint_powers(abs(torque) / ratio, self.torque(torque, speed, driving), driving).efficiency

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> Self:
        """Create the friction map from the JSON object `content`."""
        rows = {key: tuple(tuple(map(float, row)) for row in content[key]) for key in ("driving", "driven")}
        return cls(tuple(map(float, content["torques"])), tuple(map(float, content["speeds"])), **rows)


def joint_powers(useful: float, lost: float, driving: bool) -> Powers:
    """Return the powers of a joint [W] at a crank speed of 1 rad/s.

    `useful` is the load's torque on the crank without friction [N m], `lost` the friction torque there [N m]; `driving`
    is True if the crank drives, False if the output does.
    """
    return Powers(lost + useful if driving else lost - useful, -useful if driving else useful, {"joint": lost})


def _interpolate(argument: float, x: tuple[float, ...], y: tuple[float, ...]) -> float:
    """Interpolate linearly between points; beyond the last point the last line continues."""
    if argument <= x[-1]:
        return float(np.interp(argument, x, y))
    return y[-1] + (y[-1] - y[-2]) / (x[-1] - x[-2]) * (argument - x[-1])
