"""Whether the load follows the transmission error of statics: inertia by a known curve, and what is said of it."""

import warnings

import numpy as np
import pytest
from designs import unlike

from cycloid_mj.base.errors import CycloidWarning
from cycloid_mj.design import PRESETS
from cycloid_mj.parts import turning_inertia
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.load_tracking import inertia_share
from cycloid_mj.statics.sheet import sheet

LOOSE = "fixed-n31-d1-carrier-250um"


def test_the_inertia_follows_by_the_second_derivative() -> None:
    reducer = Reducer(PRESETS["pin"])
    crank = np.linspace(0.0, 2.0 * np.pi, 288, endpoint=False)
    turn = 3e-6 * np.sin(36.0 * crank) + 1e-3
    known = turning_inertia(reducer) * (36.0 * reducer.design.drive.speed) ** 2 * 3e-6 / np.sqrt(2.0) / 5.0
    assert inertia_share(reducer, turn, 5.0) == pytest.approx(known, rel=1e-9)


def test_a_drive_whose_load_cannot_follow_states_by_how_much_runs_differ() -> None:
    with pytest.warns(
        CycloidWarning, match=r"1000 rpm, the inertia torque of the load would be 0\.59.* by up to 1 percentage points"
    ):
        sheet(Reducer(unlike(LOOSE)))
    slow = Reducer(unlike(LOOSE)).but(drive={"speed": 0.1 * unlike(LOOSE).drive.speed})
    for one in (slow, Reducer(PRESETS["pin"])):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert sheet(one).quantities["inertia_torque_share"].value < 0.1
