"""How pin 1 moves in a run: within its clearance, about itself, and along the gear (Figs 9 and 16)."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.analysis import Series
from cycloid_mj.base.array import Array
from cycloid_mj.base.statistics import rms
from hsieh2014.stated import PIN_1_LOADED, SHOWN


@dataclass(frozen=True)
class PinMotion:
    """How pin 1 moves in one run.

    Attributes
    ----------
    clearance
        Of its socket [m].
    span, reach
        Width that its centre moves in, and how far it gets from the middle of its socket [m].
    mean_spin, rms_spin
        Over whole crank turns [rad/s].
    turned
        How far it has turned since the turn began, at the crank angles of Fig. 9(a) [deg].
    rolling
        Speed of its surface as a share of the gear's where that passes, from 10 to 350 deg [1].
    """

    clearance: float
    span: float
    reach: float
    mean_spin: float
    rms_spin: float
    turned: tuple[float, ...]
    rolling: float

    @property
    def seen_turned(self) -> float:
        """How far it turns between the crank angles of Fig. 9(a) [deg]."""
        return max(self.turned) - min(self.turned)


def pin_motion(motion: Series) -> PinMotion:
    """Measure the motion of pin 1 in a settled run of free or fixed pins."""
    pin = motion.pin_1
    assert pin is not None
    spin = pin.spin[motion.whole_periods]
    return PinMotion(
        clearance=pin.clearance,
        span=float(np.ptp(pin.position[motion.hold], axis=0).max()),
        reach=float(pin.radial[motion.hold].max()),
        mean_spin=float(np.mean(spin)),
        rms_spin=rms(spin),
        turned=_turned(motion),
        rolling=_rolling(motion, spin),
    )


def _turned(motion: Series) -> tuple[float, ...]:
    rows = motion.one_turn
    crank = np.abs(np.degrees(motion.crank_angle[rows]))
    angle = np.degrees(motion.run["pin_1_angle"][rows])
    shown = np.interp(crank[0] + np.array(SHOWN), crank, angle)
    return tuple(float(each - angle[0]) for each in shown)


def _rolling(motion: Series, spin: Array) -> float:
    """Compute the speed of pin 1's surface as a share of the gear's where that passes.

    Where gear and pin touch, the gear's speed is along both. The crank angle is counted from gravity's direction in the
    first start, where pin 1 is at 0 deg.
    """
    gear, rows = motion.design.gear, motion.whole_periods
    crank = motion.crank_angle[rows]
    away = np.abs((np.degrees(crank) + 180.0) % 360.0 - 180.0) >= PIN_1_LOADED[1]
    centre = gear.eccentricity * np.stack([-np.sin(crank), np.cos(crank)], axis=1)
    arm = np.array([0.0, motion.design.ring.pin_circle_radius]) - centre
    speed, turning = motion.design.drive.speed, motion.gear_speed.theory[rows]
    passing = speed * np.stack([-centre[:, 1], centre[:, 0]], axis=1)
    passing += turning[:, np.newaxis] * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
    surface = motion.design.ring.pin_radius * np.abs(spin)
    return float(np.mean(surface[away]) / np.mean(np.linalg.norm(passing[away], axis=1)))
