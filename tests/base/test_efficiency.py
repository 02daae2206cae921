"""The one power balance: its efficiency whichever shaft drives, where it locks itself, and where there is no power."""

import math

import pytest

from cycloid_mj.base.powers import SELF_LOCKING, Powers
from cycloid_mj.robot.friction import FrictionMap


@pytest.mark.parametrize(("crank", "output"), [(10.0, -7.0), (-7.0, 10.0)])
def test_the_efficiency_is_the_same_whichever_shaft_drives(crank: float, output: float) -> None:
    powers = Powers(crank, output, {"teeth": 2.0, "cam": 0.5}, {"teeth": 0.25}, stored=0.125)
    assert (powers.supplied, powers.delivered, powers.lost) == (10.0, 7.0, 2.75)
    assert powers.efficiency == 0.7
    assert powers.missing == 0.125
    assert powers.residual == 0.0125
    assert powers.loss_shares() == {"teeth_friction": 0.2, "cam_friction": 0.05, "teeth_normal": 0.025}
    assert powers.note == ""


def test_a_self_locking_reducer_has_the_efficiency_0_and_its_word() -> None:
    powers = Powers(3.0, 10.0, {"teeth": 13.0})
    assert powers.supplied == powers.lost == 13.0
    assert math.copysign(1.0, powers.efficiency) == 1.0
    assert powers.efficiency == 0.0
    assert powers.note == SELF_LOCKING


def test_without_power_there_is_no_efficiency_and_no_error() -> None:
    powers = Powers(0.0, 0.0, {"cam": 0.0})
    assert math.isnan(powers.efficiency)
    assert math.isnan(powers.residual)
    assert math.isnan(powers.loss_shares()["cam_friction"])
    assert powers.note == ""


def test_an_idling_reducer_delivers_nothing_and_does_not_lock() -> None:
    assert (Powers(2.0, 0.0).efficiency, Powers(2.0, 0.0).note) == (0.0, "")


@pytest.mark.parametrize(
    ("torque", "driving", "efficiency"),
    [(20.0, True, 2.0 / 3.0), (20.0, False, 0.5), (5.0, False, 0.0), (0.0, True, 0.0), (0.0, False, 0.0)],
)
def test_a_joint_has_the_same_efficiency(torque: float, driving: bool, efficiency: float) -> None:
    """A friction of 1 N m on the crank at a ratio of 10: it locks itself against less than 1 N m on the crank."""
    friction = FrictionMap((0.0, 30.0), (1.0,), ((1.0, 1.0),), ((1.0, 1.0),))
    assert friction.efficiency(torque, 1.0, 10.0, driving) == pytest.approx(efficiency)
