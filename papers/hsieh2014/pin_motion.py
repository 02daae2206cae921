"""Motion of pin 1 in a run: displacement, rotation, and sliding on the gear (Figs 9 and 16)."""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.analysis import Series
from cycloid_mj.base.array import Array
from cycloid_mj.base.statistics import rms
from hsieh2014.stated import PIN_1_LOADED, SHOWN


@dataclass(frozen=True)
class PinMotion:
    """Motion of pin 1 in one run."""

    clearance: float
    """Of its socket [m]."""
    span: float
    reach: float
    """Range of its centre, and its largest distance from the middle of its socket [m]."""
    mean_spin: float
    rms_spin: float
    """Rotational speed over full crank turns [rad/s]."""
    turned: tuple[float, ...]
    """Rotation since the beginning of the turn, at the crank angles of Fig. 9(a) [deg]."""
    rolling: float
    """Speed of its surface as a share of the gear's at the contact, from 10 to 350 deg [1]."""

    @property
    def seen_turned(self) -> float:
        """Return the largest rotation between the crank angles of Fig. 9(a) [deg]."""
        return max(self.turned) - min(self.turned)


def pin_motion(motion: Series) -> PinMotion:
    """Evaluate the motion of pin 1 in a settled run with free or fixed pins."""
    pin = motion.pin_1
    assert pin is not None
    spin = pin.spin[motion.whole_periods]
    return PinMotion(
        clearance=pin.clearance,
        span=float(np.ptp(pin.position[motion.hold], axis=0).max()),
        reach=float(pin.radial[motion.hold].max()),
        mean_spin=float(np.mean(spin)),
        rms_spin=rms(spin),
        turned=_rotation(motion),
        rolling=_rolling(motion, spin),
    )


def _rotation(motion: Series) -> tuple[float, ...]:
    rows = motion.one_turn
    crank = np.abs(np.degrees(motion.crank_angle[rows]))
    angle = np.degrees(motion.run["pin_1_angle"][rows])
    shown = np.interp(crank[0] + np.array(SHOWN), crank, angle)
    return tuple(float(each - angle[0]) for each in shown)


def _rolling(motion: Series, spin: Array) -> float:
    """Compute the speed of pin 1's surface as a share of the gear's at their contact.

    At the contact, the gear's speed is along both surfaces. The crank angle is measured from gravity's direction in the
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
