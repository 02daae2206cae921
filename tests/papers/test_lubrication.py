"""Mean friction that the measured output torques of the paper leave, against a hand calculation at one crank angle."""

import pytest
from hsieh2014.lubrication import largest_mean_friction, lubrication_table

from cycloid_mj.design import PRESETS
from cycloid_mj.reducer import Reducer


@pytest.mark.parametrize(("name", "rate", "by_hand"), [("pin", 0.936, 0.0209), ("nonpin", 0.956, 0.0143)])
def test_the_friction_bound_agrees_with_a_hand_calculation(name: str, rate: float, by_hand: float) -> None:
    """The teeth then lose 252 W and the output pins 301 W at a coefficient of 1."""
    assert largest_mean_friction(Reducer(PRESETS[name]), rate) == pytest.approx(by_hand, rel=0.04)


def test_table_shows_that_free_pins_reach_the_measured_rate_and_fixed_pins_and_lobes_do_not() -> None:
    table = lubrication_table()
    highest = {(row[0], row[4]): float(str(row[5]).split(" to ")[1]) for row in table.rows}
    assert highest["pin", "60"] > 93.6
    assert max(highest["nonpin", "20"], highest["nonpin", "60"]) < 95.6
    assert highest["pin, fixed pins", "60"] < highest["pin", "60"] - 3.0
    assert {row[2] for row in table.rows if row[0] == "pin, fixed pins"} == {"not measured"}
