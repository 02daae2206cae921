"""The torque of friction on the crank, over the torque on the output, the crank's speed, and which shaft drives."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from cycloid_mj.base.powers import Powers

Rows = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class FrictionMap:
    """A map of friction; between its points straight lines, beyond its largest torque the last of them goes on.

    Attributes
    ----------
    torques
        On the output [N m], shape (n,), rising from 0.
    speeds
        Of the crank [rad/s], shape (m,), rising; slower is as the first, faster as the last.
    driving, driven
        Torque of friction on the crank [N m] where the crank drives, and where the output does, shape (m, n).
    """

    torques: tuple[float, ...]
    speeds: tuple[float, ...]
    driving: Rows
    driven: Rows

    def torque(self, torque: float, speed: float, driving: bool) -> float:
        """Compute the torque of friction [N m] under a torque on the output [N m] at a speed of the crank [rad/s]."""
        lost = [_line(abs(torque), self.torques, row) for row in (self.driving if driving else self.driven)]
        return float(np.interp(abs(speed), self.speeds, lost))

    def efficiency(self, torque: float, speed: float, ratio: float, driving: bool) -> float:
        """Compute the share of the power supplied given out; 0 where friction holds the output (self-locking)."""
        return joint_powers(abs(torque) / ratio, self.torque(torque, speed, driving), driving).efficiency

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> Self:
        """Read the map from a JSON object."""
        rows = {key: tuple(tuple(map(float, row)) for row in content[key]) for key in ("driving", "driven")}
        return cls(tuple(map(float, content["torques"])), tuple(map(float, content["speeds"])), **rows)


def joint_powers(useful: float, lost: float, driving: bool) -> Powers:
    """Collect the powers of a joint for a crank at 1 rad/s, from the load's torque and that of friction on it [N m]."""
    return Powers(lost + useful if driving else lost - useful, -useful if driving else useful, {"joint": lost})


def _line(at: float, x: tuple[float, ...], y: tuple[float, ...]) -> float:
    """Compute the value of straight lines through points; beyond the last point the last line goes on."""
    if at <= x[-1]:
        return float(np.interp(at, x, y))
    return y[-1] + (y[-1] - y[-2]) / (x[-1] - x[-2]) * (at - x[-1])
