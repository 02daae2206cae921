"""Friction below the creep speed is too small: the speed that is chosen hides none, and of a stated one a run tells."""

import math
import re

import pytest
from designs import design_file

from cycloid_mj.base.powers import mean_powers
from cycloid_mj.design import Design, load, override
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.planar.model import planar_model
from cycloid_mj.dynamics.regime import pace_warnings
from cycloid_mj.dynamics.run import Model, simulate
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.contact import CONTACT
from cycloid_mj.statics.sheet import sheet_part

SETTLED = 0.05
"""Time [s] after which a run counts."""

TOO_SOFT = "contact.creep_speed_mm_s=20"


def slow(name: str, share: float, speed: float, *changes: str) -> Design:
    """Return a design under a share of its rated load, at a crank speed [rpm], without weight: all is calm."""
    design = load(design_file(name))
    load_nm = f"load.torque_nm={share * design.rated_torque!r}"
    calm = ["environment.gravity_y_m_s2=0", "drive.ramp_s=0", f"drive.speed_rpm={speed!r}", load_nm]
    return override(design, [*calm, *changes])


def efficiency(design: Design, turns: float, model: type | None = None) -> float:
    """Compute the mean efficiency over some crank turns [points], by the planar solver or another."""
    hold = SETTLED + turns * 2.0 * math.pi / design.drive.speed
    design = override(design, [f"drive.hold_s={hold!r}"])
    compiled: Model = model(design) if model else planar_model(Reducer(design))
    run = simulate(design, compiled)
    return 100.0 * mean_powers(run.select(run.time >= SETTLED)).efficiency


@pytest.mark.parametrize(
    "name", ["nonpin-n69-d1-carrier-2um", pytest.param("fixed-n70-d1-ring-5um", marks=pytest.mark.slow)]
)
def test_the_creep_speed_that_is_chosen_hides_no_loss(name: str) -> None:
    design = slow(name, 0.3, 1000.0)
    tenth = override(design, [f"contact.creep_speed_mm_s={100.0 * Reducer(design).contacts.creep_speed!r}"])
    ours = efficiency(design, 3.0)
    assert ours == pytest.approx(efficiency(tenth, 3.0), abs=0.1)
    assert ours == pytest.approx(sheet_part(Reducer(design), "losses")["efficiency"].value, abs=0.3)
    assert efficiency(override(design, [TOO_SOFT]), 3.0) > ours + 2.0


@pytest.mark.slow
@pytest.mark.parametrize("model", [None, build])
def test_a_slow_run_with_wide_play_and_little_load_has_the_losses_of_statics(model: type | None) -> None:
    """Over 8.25 crank turns, after which teeth and output pins are as they were; 17 points too much at 20 mm/s."""
    design = slow("fixed-n34-d2-carrier-120um", 0.03, 100.0)
    exact = sheet_part(Reducer(design), "losses")["efficiency"].value
    assert efficiency(design, 8.25, model) == pytest.approx(exact, abs=0.7)
    assert efficiency(override(design, [TOO_SOFT]), 8.25, model) > exact + 15.0


def test_it_follows_the_crank_unless_it_is_given() -> None:
    design = slow("nonpin-n69-d1-carrier-2um", 1.0, 100.0)
    circling = design.gear.eccentricity * design.drive.speed
    assert Reducer(design).contacts.creep_speed == pytest.approx(CONTACT.creep_share * circling)
    assert Reducer(override(design, ["drive.speed_rpm=-100"])).contacts.creep_speed == pytest.approx(
        CONTACT.creep_share * circling
    )
    assert Reducer(override(design, ["drive.speed_rpm=0"])).contacts.creep_speed == CONTACT.slow_creep
    assert Reducer(override(design, [TOO_SOFT])).contacts.creep_speed == pytest.approx(0.02)


@pytest.mark.parametrize(
    ("name", "share", "speed", "more"),
    [
        ("nonpin-n69-d1-carrier-2um", 0.3, 1000.0, 2.34),
        ("free-n79-d1-carrier-0.7um", 0.03, 100.0, 10.6),
        ("fixed-n31-d1-carrier-250um", 0.03, 100.0, 19.2),
        ("free-n35-d2-carrier-15um", 1.0, 1000.0, 2.65),
        ("sleeved-n40-d2-ring-25um", 1.0, 1000.0, 2.13),
    ],
)
def test_a_run_states_the_share_of_friction_below_creep_speed(
    name: str, share: float, speed: float, more: float
) -> None:
    """Runs read `more` points, as measured, than those with the creep speed that is chosen."""
    design = slow(name, share, speed, "settings.log_rate_hz=20000")
    assert pace_warnings(Reducer(design)) == ()
    (text,) = pace_warnings(Reducer(override(design, [TOO_SOFT])))
    told = float(re.search(r"the efficiency is ([\d.]+) percentage points too high", text)[1])
    assert 0.7 * more < told < 1.4 * more
    assert pace_warnings(Reducer(override(design, ["contact.creep_speed_mm_s=0.02"]))) == ()
