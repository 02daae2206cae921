"""Every valid drive has a static balance, or is told to jam: odd designs, and those of a random draw."""

from pathlib import Path

import numpy as np
import pytest

from cycloid_mj.base.errors import RunError
from cycloid_mj.design import PRESETS, Design, override, resolve
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.member import share
from cycloid_mj.statics import loads, powers, springs_of
from cycloid_mj.statics.kernel import state
from cycloid_mj.statics.sheet import PARTS_OF_SHEET, sheet_part

ZOO = sorted((Path(__file__).parents[1] / "data" / "designs").glob("*.toml"))
SHARES = (0.001, 0.01, 0.03, 0.1, 0.3, 1.0, 1.5)
"""Loads, as shares of the rated torque."""

WAYS = {"forward": (1.0, 1.0), "reversed": (-1.0, -1.0), "back-driven": (1.0, -1.0)}
"""Signs of the crank's speed and of the torque on the output."""


def wide(play: float) -> Design:
    """Return the preset of two discs with wide clearances [um]."""
    return override(PRESETS["twodisc"], [f"clearance.{kind}_um={play}" for kind in ("pin_gear", "cam", "output")])


@pytest.mark.parametrize("path", ZOO, ids=lambda path: path.stem)
def test_every_odd_drive_balances_under_every_load(path: Path) -> None:
    """Forward, reversed and back-driven; what is left over is seen by the springs' own forces, without the search."""
    design = resolve(str(path))
    cranks = np.linspace(0.0, 2.0 * np.pi, 5, endpoint=False)
    for way, sign in WAYS.values():
        turning = design.but(drive={"speed": way * abs(design.drive.speed)})
        springs = springs_of(Reducer(turning), cranks)
        smooth = springs_of(Reducer(turning), cranks, friction=False)
        for torque in sign * np.array(SHARES) * design.rated_torque:
            assert np.isfinite(loads(Reducer(turning), springs, torque).teeth).all()
            found, load = loads(Reducer(turning), smooth, torque), smooth.load(share(design) * torque)
            for k, z in enumerate(found.departures):
                left = state(smooth.contacts, k, load[k], z)
                assert np.abs(left.residual).max() < 1e-3 * np.abs(load[k]).max()
                assert np.linalg.eigvalsh(left.stiffness)[0] > -1e-6 * smooth.contacts.cam_stiffness, "a least energy"


@pytest.mark.parametrize("play", [10.0, 30.0])
@pytest.mark.parametrize("torque", [0.3, 3.5, 11.6])
def test_wide_play_jams_nothing(play: float, torque: float) -> None:
    for part in PARTS_OF_SHEET:
        assert sheet_part(Reducer(wide(play)), part, torque)


def test_two_discs_of_wide_play_carry_what_an_independent_integration_finds() -> None:
    """Rigid, 11.6 N m: an efficiency of 0.8362, 211.3 N on a cam and 206.4 arcsec behind, in the mean."""
    design = override(wide(10.0), ["structure=rigid", "load.torque_nm=11.6"])
    found = loads(Reducer(design), springs_of(Reducer(design)), 11.6)
    assert powers(Reducer(design), 11.6).efficiency == pytest.approx(0.8362, abs=5e-4)
    assert np.linalg.norm(found.cam, axis=-1).mean() == pytest.approx(211.3, rel=2e-3)
    assert np.rad2deg(found.output_turn.mean()) * 3600.0 == pytest.approx(206.4, rel=3e-3)


def test_a_jam_is_told_with_the_friction_that_is_borne() -> None:
    design = override(PRESETS["pin"], ["ring.pins=fixed", "friction.pin_gear=0.9"])
    with pytest.raises(RunError, match=r"too large for the crank to turn under this load, whatever .* crank .*% of"):
        loads(Reducer(design), springs_of(Reducer(design)), design.rated_torque)
