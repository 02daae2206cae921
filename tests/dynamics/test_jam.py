"""A drive whose friction locks it is named, and its log holds what was there."""

import math

import numpy as np
import pytest

from cycloid_mj.analysis import analyze
from cycloid_mj.base.errors import RunError
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.jam import JAM, jamming_power, moving_means
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.log import read
from cycloid_mj.reducer import Reducer

KINDS = ("pin_gear", "pin_socket", "cam", "output", "cam_rolling", "output_rolling")
SHORT = ["drive.ramp_s=0", "drive.hold_s=0.006"]


def rubbing(friction: float, load: float, *changes: str) -> Design:
    """Load a drive of fixed pins that rubs everywhere."""
    everywhere = [f"friction.{kind}={friction}" for kind in KINDS]
    return override(PRESETS["pin"], [*SHORT, "ring.pins=fixed", *everywhere, f"load.torque_nm={load}", *changes])


@pytest.mark.parametrize("pins", ["fixed", "free"])
@pytest.mark.parametrize("load", [0.0, 1.0, 36.68])
def test_teeth_that_lock_themselves_are_a_jam(load: float, pins: str) -> None:
    """Without a load, free pins let go again and again within a mesh: the mean over it tells."""
    with pytest.raises(RunError, match="the drive jams"):
        simulate(rubbing(2.0, load, f"ring.pins={pins}"))


def test_pins_that_wedge_a_cam_on_rollers_are_a_jam() -> None:
    """The crank's power goes into the give of cam and teeth, and little of it into friction."""
    sliding = [f"friction.{kind}=2" for kind in ("pin_gear", "pin_socket")]
    with pytest.raises(RunError, match="the drive jams: friction and wedging dissipate"):
        simulate(override(PRESETS["pin"], [*SHORT, *sliding, "load.torque_nm=36"]))


def test_deep_contacts_of_a_long_step_are_no_jam() -> None:
    long = ["settings.timestep_us=20", "settings.log_rate_hz=50000", "load.torque_nm=36"]
    with pytest.warns(Warning, match="too long"), pytest.raises(RunError, match=r"settings\.timestep_us") as failed:
        simulate(override(PRESETS["pin"], [*SHORT, *long]))
    assert "jams" not in str(failed.value)


@pytest.mark.parametrize("load", [0.0, 0.3])
def test_no_start_across_wide_play_is_a_jam(load: float) -> None:
    thrown = ["ring.pins=fixed", "drive.speed_rpm=12000", "clearance.pin_gear_um=100", "drive.hold_s=0.002"]
    simulate(override(PRESETS["twodisc"], [*SHORT[:1], *thrown, f"load.torque_nm={load}"]))


def test_a_jam_leaves_its_log(tmp_path, capsys) -> None:
    changes = [f"friction.{kind}=2" for kind in KINDS]
    flags = [flag for change in [*changes, *SHORT] for flag in ("--set", change)]
    assert main(["simulate", "--design", "pin", "--load-nm", "36.68", *flags, "--out", str(tmp_path / "jam")]) == 1
    assert "the drive jams" in capsys.readouterr().err
    run = read(next(tmp_path.rglob("*.mcap")))
    assert not run.complete
    assert "jams" in run.note
    assert len(run) > 5


def test_a_nearly_self_locking_run_warns() -> None:
    with pytest.warns(Warning, match="has no effect"):
        run = simulate(rubbing(0.5, 1.0, "drive.hold_s=0.05"))
    assert any("almost self-locking" in text for text in analyze(run).warnings)


def test_the_limit_of_a_jam_follows_the_rated_torque_or_a_larger_load() -> None:
    pin = PRESETS["pin"]
    speed, rated = pin.drive.speed, pin.drive.torque
    for idle in ("0", "1"):
        assert jamming_power(Reducer(override(pin, [f"load.torque_nm={idle}"]))) == pytest.approx(
            JAM.max_friction_over_rated * rated * speed
        )
    assert jamming_power(Reducer(override(pin, ["load.torque_nm=36.68"]))) == pytest.approx(
        JAM.max_friction_over_load * rated * speed
    )
    larger = override(pin, ["load.torque_nm=100"])
    assert jamming_power(Reducer(larger)) == pytest.approx(JAM.max_friction_over_load * 100.0 / 35.0 * speed)
    assert jamming_power(Reducer(override(pin, ["drive.speed_rpm=0"]))) == math.inf


def test_a_jam_is_reported_by_the_mean_of_a_mesh_across_blocks() -> None:
    lost = np.random.default_rng(1).random(30)
    whole = moving_means(lost, np.zeros(6))
    np.testing.assert_allclose(whole[6:], [lost[i - 6 : i + 1].mean() for i in range(6, 30)], rtol=1e-12)
    np.testing.assert_allclose(whole[0], lost[0] / 7.0)
    np.testing.assert_allclose(whole[10:], moving_means(lost[10:], lost[4:10]), rtol=1e-12)
    np.testing.assert_allclose(moving_means(lost, np.zeros(0)), lost, rtol=1e-12)
