"""What settles and how deep contacts go, by stiffness and mass: as ever for the paper's, more for what is softer."""

import math

import numpy as np
import pytest
from designs import unlike

from cycloid_mj.analysis import window
from cycloid_mj.base.errors import RunError
from cycloid_mj.design import PRESETS, Design
from cycloid_mj.design.model import NO_FRICTION
from cycloid_mj.dynamics.drive_cycle import locked_crank, rising
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.dynamics.settling import (
    SETTLING,
    closed_stiffness,
    crossing_time,
    penetration_limit,
    slowness,
    swing_period,
    turning_inertia,
)
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.limits import widest_play

PIN, PRINTED = PRESETS["pin"], PRESETS["printed"]
SOFT = PRINTED.but(output_material={"name": "", "density": 20000.0}, output={"disc_thickness": 0.2})
"""The printed drive under a disc that is 200 mm of a heavy metal."""


@pytest.mark.parametrize("name", ["pin", "nonpin"])
def test_the_papers_designs_have_the_papers_times_and_depths(name: str) -> None:
    design = PRESETS[name].but(load={"torque": 36.68})
    assert slowness(Reducer(design)) == 1.0
    assert window.settling(Reducer(design)) == SETTLING.min_time == 0.005
    assert penetration_limit(Reducer(design)) == SETTLING.min_depth_limit == 50e-6


def test_a_soft_and_heavy_drive_oscillates_at_the_estimated_frequency() -> None:
    """Its output, let go of under a locked crank, by zero crossings about where it comes to rest."""
    level = SOFT.but(
        ring={"pins": "fixed"},
        drive={"ramp": 0.0, "hold": 0.05},
        load={"torque": 0.0},
        contact={"damping_ratio": 0.02},
        friction=NO_FRICTION,
    )
    level = level.but(contact={"working_load": 10.0})
    compiled = build(level)
    # half of the load held on: contacts stay closed while the other half is let go
    run = simulate(level, compiled, locked_crank(compiled, 0.3, lambda t: rising(10.0, 0.02)(t) - 3.0 * (t > 0.025)))
    swing = run["output_angle"][run.time > 0.026]
    swing = swing - 0.5 * (swing.max() + swing.min())
    times = run.time[run.time > 0.026][:-1][np.diff(np.signbit(swing).astype(int)) != 0]
    period = 2.0 * float(np.mean(np.diff(times)))
    # half of the teeth are reckoned with, and three of fourteen carry
    assert 1.0 < period / swing_period(Reducer(level)) < 1.6
    assert swing_period(Reducer(level)) > 3.0 * swing_period(Reducer(PRINTED))
    assert slowness(Reducer(level)) == pytest.approx(6.0 * swing_period(Reducer(level)) / 0.005)
    slower = level.but(drive={"speed": 1e4})
    assert window.settling(Reducer(slower)) == pytest.approx(0.005 * slowness(Reducer(slower)))


def test_the_period_is_that_of_inertia_on_stiffness() -> None:
    loaded = PRINTED.but(load={"torque": 10.0})
    known = 2.0 * math.pi * math.sqrt(turning_inertia(Reducer(loaded)) / closed_stiffness(Reducer(loaded)))
    assert swing_period(Reducer(loaded)) == pytest.approx(known)
    ring = PRINTED.but(output={"member": "ring"})
    assert turning_inertia(Reducer(ring)) > 1.3 * turning_inertia(Reducer(PRINTED))
    assert closed_stiffness(Reducer(ring)) == pytest.approx(
        (14 / 13) ** 2 * closed_stiffness(Reducer(PRINTED)), rel=0.05
    )


def test_a_drive_settles_once_the_load_has_crossed_its_play() -> None:
    """By constant acceleration, but no longer than the crank takes for a turn; without play or a load at once."""
    loose = Reducer(unlike("fixed-n31-d1-carrier-250um")).but(load={"torque": 4.0})
    play = widest_play(loose, 0.0)
    assert crossing_time(loose) == pytest.approx(math.sqrt(0.5 * play * turning_inertia(loose)))
    assert slowness(loose) == pytest.approx(4.0 * crossing_time(loose) / 0.005)
    assert crossing_time(loose.but(load={"torque": 0.0})) == 0.0
    still = loose.but(drive={"speed": 0.0}, load={"torque": 1e-3})
    assert crossing_time(still) == pytest.approx(math.sqrt(4e3) * crossing_time(loose))
    turn = 2.0 * math.pi / loose.design.drive.speed
    assert 4.0 * crossing_time(loose.but(load={"torque": 1e-3})) == pytest.approx(turn)
    jammed = loose.but(errors={"pin_dr": tuple([3e-4] * 31)})
    assert crossing_time(jammed) == 0.0


def test_the_depth_allowed_follows_the_load_and_stays_below_the_teeth() -> None:
    heavy = PRINTED.but(load={"torque": 20.0})
    pressed = [
        Reducer(heavy).contacts[kind].force / Reducer(heavy).contacts[kind].stiffness_by_disc[0]
        for kind in heavy.pair_kinds
    ]
    assert penetration_limit(Reducer(heavy)) == pytest.approx(10.0 * max(pressed))
    assert penetration_limit(Reducer(heavy)) > 2.0 * SETTLING.min_depth_limit
    crushed = PRINTED.but(load={"torque": 45.0}, material={"youngs_modulus": 4e8, "name": ""})
    assert penetration_limit(Reducer(crushed)) == pytest.approx(0.25 * crushed.gear.eccentricity)
    assert penetration_limit(Reducer(heavy.but(contact={"max_penetration": 7e-6}))) == 7e-6


def test_a_load_beyond_the_papers_depth_runs_unless_a_limit_is_set() -> None:
    heavy = _short(PRINTED.but(load={"torque": 45.0, "rise": 0.02}))
    assert simulate(heavy)["penetration"].max() > SETTLING.min_depth_limit
    with pytest.raises(RunError, match=r"more than contact\.max_penetration_um = 50"):
        simulate(heavy.but(contact={"max_penetration": SETTLING.min_depth_limit}))


def _short(design: Design) -> Design:
    return design.but(drive={"ramp": 0.0, "hold": 0.06})
