"""Every valid drive has a static balance, or is told to jam: odd designs, and those of a random draw."""

from pathlib import Path

import numpy as np
import pytest

from cycloid_mj.base.errors import RunError
from cycloid_mj.design import PRESETS, Design, override, resolve
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import loads, powers, springs_of
from cycloid_mj.statics.balance import require_equilibrium
from cycloid_mj.statics.jam import friction_limit
from cycloid_mj.statics.kernel import Residual, state
from cycloid_mj.statics.sheet import PARTS_OF_SHEET, sheet_part
from cycloid_mj.statics.springs import POSES, turn_evenly

DESIGNS = Path(__file__).parents[1] / "data" / "designs"
ZOO = sorted(DESIGNS.glob("*.toml"))
SHARES = (0.001, 0.01, 0.03, 0.1, 0.3, 1.0, 1.5)
"""Loads, as shares of the rated torque."""

WAYS = {"forward": (1.0, 1.0), "reversed": (-1.0, -1.0), "back-driven": (1.0, -1.0)}
"""Signs of the crank's speed and of the torque on the output."""


def odd(name: str) -> Design:
    """Return one of the designs of `ZOO`."""
    return resolve(str(DESIGNS / f"{name}.toml"))


def wide(play: float) -> Design:
    """Return the preset of two discs with wide clearances [um]."""
    plays = [f"clearance.{kind}_um={play}" for kind in ("pin_gear", "cam", "output")]
    return override(PRESETS["twodisc"], ["friction.law=coulomb", *plays])


@pytest.mark.parametrize("path", ZOO, ids=lambda path: path.stem)
def test_unusual_drives_have_an_equilibrium_at_all_loads(path: Path) -> None:
    """Forward, reversed and back-driven; what is left over is seen by the springs' own forces, without the search."""
    design = resolve(str(path))
    cranks = np.linspace(0.0, 2.0 * np.pi, 5, endpoint=False)
    for way, sign in WAYS.values():
        turning = design.but(drive={"speed": way * abs(design.drive.speed)})
        springs = springs_of(Reducer(turning), cranks)
        smooth = springs_of(Reducer(turning), cranks, friction=False)
        for torque in sign * np.array(SHARES) * design.rated_torque:
            assert np.isfinite(loads(Reducer(turning), springs, torque).teeth).all()
            found, load = loads(Reducer(turning), smooth, torque), smooth.load(Reducer(design).share * torque)
            for k, z in enumerate(found.departures):
                left = state(smooth.contacts, k, load[k], z)
                assert np.abs(left.residual).max() < 1e-3 * np.abs(load[k]).max()
                assert np.linalg.eigvalsh(left.stiffness)[0] > -1e-6 * smooth.contacts.cam_stiffness, "a least energy"


@pytest.mark.parametrize("play", [10.0, 30.0])
@pytest.mark.parametrize("torque", [0.3, 3.5, 11.6])
def test_wide_play_jams_nothing(play: float, torque: float) -> None:
    for part in PARTS_OF_SHEET:
        assert sheet_part(Reducer(wide(play)), part, torque)


def test_two_discs_with_wide_play_match_an_independent_integration() -> None:
    """Rigid, 11.6 N m: an efficiency of 0.8362, 211.3 N on a cam and 206.4 arcsec behind, in the mean."""
    design = override(wide(10.0), ["structure=rigid", "load.torque_nm=11.6"])
    found = loads(Reducer(design), springs_of(Reducer(design)), 11.6)
    assert powers(Reducer(design), 11.6).efficiency == pytest.approx(0.8362, abs=5e-4)
    assert np.linalg.norm(found.cam, axis=-1).mean() == pytest.approx(211.3, rel=2e-3)
    assert np.rad2deg(found.output_turn.mean()) * 3600.0 == pytest.approx(206.4, rel=3e-3)


@pytest.mark.parametrize("share_of_rated", [0.03, -1.0])
def test_losses_under_high_friction_exclude_wedged_balances(share_of_rated: float) -> None:
    """A search of its own at each crank angle ends in wedged parts at some, which lose a thousand times as much."""
    frictions = [f"friction.{kind}=0.5" for kind in ("pin_gear", "cam", "output")]
    reducer = Reducer(override(PRESETS["printed"], frictions))
    torque = share_of_rated * reducer.design.rated_torque
    finer = powers(reducer, torque, turn_evenly(reducer, 4 * POSES))
    assert powers(reducer, torque).lost == pytest.approx(finer.lost, rel=1e-3)


@pytest.mark.parametrize("name", ["fixed-n8-d1-carrier-4um", "fixed-n31-d1-carrier-250um", "sleeved-n40-d2-ring-25um"])
def test_stops_are_found_under_a_very_small_load(name: str) -> None:
    reducer = Reducer(odd(name))
    light, rated = (sheet_part(reducer, "motions", share * reducer.design.rated_torque) for share in (0.001, 1.0))
    assert light["backlash"].value == pytest.approx(rated["backlash"].value, rel=1e-3)


def test_a_wide_play_whose_path_passes_wedged_parts_balances() -> None:
    design = odd("fixed-n31-d1-carrier-250um").but(drive={"speed": 26.18})
    found = loads(Reducer(design), springs_of(Reducer(design), [0.78296]), 0.05 * design.rated_torque)
    assert found.share == pytest.approx(1.0)
    assert np.linalg.norm(found.cam[0]) < 10.0 * found.teeth[0].sum()


def test_failed_equilibrium_is_no_jam_if_parts_without_clearance_balance() -> None:
    """The same load with and without friction, as if no balance had been found."""
    rubbing, smooth = (springs_of(Reducer(PRESETS["pin"]), [0.3], friction=one) for one in (True, False))
    lost = Residual(0.25, 0, 1)
    for springs, told in (
        (
            rubbing,
            r"residual is 0.25 of the load \(allowed: .*\)\. Friction is not the cause: .* raised to 110% of those "
            "of the design",
        ),
        (smooth, r"found at a crank angle of 17.19 deg .*: the residual is 0.25 of the load .*; check the clearances"),
    ):
        with pytest.raises(RunError, match=told):
            require_equilibrium(lost, springs, springs.load(36.0))


def test_failed_equilibrium_near_the_friction_limit_is_a_jam() -> None:
    """Parts without play bear 104 % of this friction, where forces are many times the load."""
    fixed = override(PRESETS["pin"], ["ring.pins=fixed", "friction.pin_gear=1.2"])
    whole = springs_of(Reducer(fixed), [0.7])
    load = whole.load(fixed.rated_torque)
    share = friction_limit(whole.contacts, 0, load[0]) / 1.045
    less = Reducer(fixed.but(friction={pair: share * fixed.friction_of(pair) for pair in ("pin_gear", "output")}))
    with pytest.raises(
        RunError, match=r"friction jams the drive .* coefficients are at most 10[3-5]% of those.*close to this limit"
    ):
        require_equilibrium(Residual(2.18, 0, 1), springs_of(less, [0.7]), load)


def test_a_jam_is_reported_with_the_largest_friction_in_equilibrium() -> None:
    design = override(PRESETS["pin"], ["ring.pins=fixed", "friction.pin_gear=0.9"])
    with pytest.raises(RunError, match=r"friction jams the drive under this load at any crank torque.*% of"):
        loads(Reducer(design), springs_of(Reducer(design)), design.rated_torque)
