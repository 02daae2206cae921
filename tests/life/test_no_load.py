"""Torque without load: viscosity, bearings and seals against worked values, over speed and temperature."""

import numpy as np
import pytest

from cycloid_mj.design import resolve
from cycloid_mj.figures import quantity
from cycloid_mj.life.no_load import GREASE, no_load_torque
from cycloid_mj.life.sheet_rows import no_load_curves, torques_without_load
from cycloid_mj.lubrication.bearings import idle_torque, seal_torque
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.sheet import sheet

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


def test_curves_of_a_data_sheet_are_over_speed_at_two_temperatures() -> None:
    """A tenth to one and a half times the design's speed, at 20 and 60 °C; their points are those of the rows."""
    reducer = Reducer(resolve("pin", {"friction.law": "film"}))
    cold, warm = no_load_curves(reducer)
    assert (cold.name, warm.name) == ("20 °C", "60 °C")
    speed = abs(reducer.design.drive.speed) / RPM
    assert cold.x == pytest.approx([share * speed for share in (0.1, 0.25, 0.5, 0.75, 1.0, 1.5)])
    assert np.all(np.diff(cold.y) > 0.0)
    assert np.all(np.diff(warm.y) > 0.0)
    assert np.all(warm.y < cold.y)
    rows = {row.key: row.value for row in torques_without_load(reducer, sheet(reducer, reducer.design.rated_torque))}
    assert cold.y[4] == pytest.approx(rows["running_torque_cold"], rel=1e-6)
    assert warm.y[4] == pytest.approx(rows["running_torque_warm"], rel=1e-6)


def test_drag_of_the_design_replaces_the_seals() -> None:
    reducer = Reducer(resolve("pin", {"drag.crank_nm": 0.05}))
    assert no_load_torque(reducer, 100.0, 20.0).seals == 0.0


def test_film_rows_have_intervals_and_count_seals_once() -> None:
    reducer = Reducer(resolve("pin", ["friction.law=film"]))
    rows = {row.key: row for row in torques_without_load(reducer, sheet(reducer, reducer.design.rated_torque))}
    for row in rows.values():
        assert row.low is not None
        assert row.high is not None
        assert row.low < row.value < row.high
        assert len(row.interval_json()["causes"]) == 2
        assert row.causes[0][0] in row.note
    assert rows["running_torque_warm"].value < rows["running_torque_cold"].value
    assert no_load_torque(reducer, 100.0, 20.0).seals == 0.0
    contacts = quantity(reducer, "starting_torque_nm").value
    assert rows["starting_torque_drive"].value - contacts == pytest.approx(no_load_torque(reducer, 0.0, 20.0).bearings)


def test_coulomb_rows_have_no_interval() -> None:
    reducer = Reducer(resolve("pin"))
    rows = torques_without_load(reducer, sheet(reducer, reducer.design.rated_torque))
    assert all(row.low is None and not row.causes for row in rows)
