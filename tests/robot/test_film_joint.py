"""The joint of a drive with film friction states the intervals of its efficiencies and its no-load torque."""

import pytest

from cycloid_mj.design import PRESETS, override
from cycloid_mj.figures import figure
from cycloid_mj.reducer import reducer_of
from cycloid_mj.robot import ReducedJoint, reduce


@pytest.fixture(scope="module")
def printed() -> ReducedJoint:
    return reduce("printed")


@pytest.mark.slow
@pytest.mark.parametrize("key", ["efficiency", "back_driving_efficiency", "no_load_torque_nm"])
def test_a_joint_with_film_friction_has_intervals(printed: ReducedJoint, key: str) -> None:
    quantity = printed.quantities[key]
    assert quantity.low is not None
    assert quantity.high is not None
    assert quantity.low < quantity.value < quantity.high
    assert len(quantity.interval_json()["causes"]) == 2


@pytest.mark.slow
def test_the_interval_is_that_of_statics(printed: ReducedJoint) -> None:
    at_nominal_torque = override(PRESETS["printed"], [f"load.torque_nm={printed.rated_torque}"])
    stated = figure("efficiency_percent").quantity(reducer_of(at_nominal_torque))
    quantity = printed.quantities["efficiency"]
    assert (quantity.low, quantity.high) == (stated.low, stated.high)
    assert quantity.value == pytest.approx(stated.value, abs=0.1), "interpolation in the map of friction"
