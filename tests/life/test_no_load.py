"""Torque without load: viscosity, bearings and seals against worked values, over speed and temperature."""

import pytest

from cycloid_mj.design import resolve
from cycloid_mj.life.no_load import GREASE, no_load_torque
from cycloid_mj.lubrication.bearings import idle_torque, seal_torque
from cycloid_mj.reducer import Reducer

RPM = 0.10471975511965977


def test_viscosity_follows_walther() -> None:
    """ISO VG 100 of viscosity index 95: 100 mm2/s at 40 °C, 11.2 at 100 °C, about 300 at 20 °C."""
    assert GREASE.viscosity(40.0) == pytest.approx(100.0)
    assert GREASE.viscosity(100.0) == pytest.approx(11.2)
    assert GREASE.viscosity(20.0) == pytest.approx(310.0, rel=0.1)


def test_idle_torque_of_a_ball_bearing_by_hand() -> None:
    """f0 2, d_m 40 mm, 1000 rpm, 100 mm2/s: 1e-7 x 2 x (1e5)^(2/3) x 64 000 = 27.58 N mm; slowly 160e-7 x 128 000."""
    assert idle_torque(2.0, 40e-3, 1000.0 * RPM, 100.0) == pytest.approx(27.58e-3, rel=1e-3)
    assert idle_torque(2.0, 40e-3, 0.0, 100.0) == pytest.approx(2.048e-3)


def test_power_of_a_seal_by_hand() -> None:
    """7.69e-6 x 30^2 x 1500 = 10.38 W on a shaft of 30 mm at 1500 rpm (ISO/TR 14179-2)."""
    assert seal_torque(30e-3) * 1500.0 * RPM == pytest.approx(10.38, rel=1e-3)


def test_no_load_torque_grows_with_speed_and_falls_with_temperature() -> None:
    reducer = Reducer(resolve("pin"))
    slow, fast, warm = (
        no_load_torque(reducer, speed * RPM, temperature) for speed, temperature in ((200, 20), (1640, 20), (1640, 60))
    )
    assert slow.total < fast.total
    assert warm.total < fast.total
    assert fast.low < fast.total < fast.high
    assert 0.02 < no_load_torque(reducer, 0.0, 20.0).total < slow.total


def test_drag_of_the_design_replaces_the_seals() -> None:
    reducer = Reducer(resolve("pin", {"drag.crank_nm": 0.05}))
    assert no_load_torque(reducer, 100.0, 20.0).seals == 0.0
