"""Loops of torque with friction that remembers: parts that leap across their play, where no balance is near."""

from pathlib import Path

import numpy as np
import pytest
from designs import cases, unlike

from cycloid_mj.base.array import Array
from cycloid_mj.design import PRESETS, load
from cycloid_mj.design.model import NO_FRICTION
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.friction_path import Losses, follow_torque_path
from cycloid_mj.statics.springs import turn_evenly

COURSE = np.sin(2.0 * np.pi * np.linspace(0.0, 1.25, 250))
WEIGHTLESS = {"gravity_x": 0.0, "gravity_y": 0.0}
LEAPS = [
    ("printed", 0.0),
    ("fixed-n34-d2-carrier-120um", 0.0),
    ("fixed-n34-d2-carrier-120um", 1.0),
    ("nonpin-n33-d2-ring-60um", 1.0),
    ("fixed-n70-d1-ring-5um", 1.0),
    ("sleeved-n27-d1-carrier-3um", 1.0),
    ("free-n35-d2-carrier-15um", 1.0),
]


def turns(reducer: Reducer, crank: float) -> Array:
    """Compute the turn of the output [rad] along a loop of the rated torque."""
    course = reducer.design.rated_torque * COURSE
    _, turn = follow_torque_path(
        reducer.working_at(reducer.design.rated_torque), course, crank, Losses(), "crank", 1e-4
    )
    return turn


@pytest.mark.parametrize(("name", "crank"), cases(LEAPS, LEAPS[0]))
def test_parts_that_leap_across_their_play_come_to_a_balance(name: str, crank: float) -> None:
    """Without weight nothing but friction holds the gear in its play: the loop is narrower by what that takes."""
    reducer = Reducer(PRESETS[name] if name in PRESETS else unlike(name)).but(environment=WEIGHTLESS)
    smooth = reducer.but(friction=NO_FRICTION)
    held, free = np.ptp(turns(reducer, crank)), np.ptp(turns(smooth, crank))
    assert 0.95 * free < held <= 1.001 * free


def test_a_step_without_equilibrium_is_halved() -> None:
    """At the reversal of a milled drive, the step from -6 to -12 N m had no equilibrium: no data sheet was written."""
    reducer = Reducer(load(Path(__file__).parent.parent / "data" / "milled_loop.toml"))
    crank = float(turn_evenly(reducer, 4)[1])
    loop = np.array([0.0, 6.0, 12.0, 6.0, 0.12, -6.0, -12.0, -6.0, -0.12])
    rows, turn = follow_torque_path(reducer, loop, crank, Losses())
    assert rows.tolist() == list(range(9))
    fine = np.interp(np.arange(129) / 16.0, np.arange(9), loop)
    _, fine_turn = follow_torque_path(reducer, fine, crank, Losses())
    assert turn == pytest.approx(fine_turn[::16], abs=0.01 * np.ptp(fine_turn))
