"""The planar witness against closed forms and itself, and a run of MuJoCo's against it."""

import numpy as np
import pytest

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import PRESETS, override
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate import planar, witness
from cycloid_mj.validate.rig import FIXED, FREE, SETTLED, reducer_of, without_friction

SHORT = (*witness.HELD, "load.torque_nm=36.0", f"drive.hold_s={SETTLED + 60.0 / 1640.0 / 36.0!r}")


def late(design, step: float = 1e-6) -> planar.History:
    history = planar.run(design, design.drive.hold, step, 20)
    return planar.History(history.values[history["time"] >= SETTLED])


def test_without_friction_all_power_comes_out() -> None:
    """Over a mesh period springs and masses give back what they take; damping takes next to nothing."""
    found = late(reducer_of(FIXED, *SHORT, *without_friction()))
    given = -(found["load"] * found["output_speed"]).mean()
    assert (found["crank_torque"] * 1640.0 * np.pi / 30.0).mean() == pytest.approx(given, rel=1e-3)
    assert found["output_speed"].mean() == pytest.approx(-1640.0 * np.pi / 30.0 / 35.0, rel=1e-3)


def test_a_run_at_high_friction_agrees_and_one_whose_friction_leads_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    design = override(witness.high_friction(), [f"drive.hold_s={SETTLED + 60.0 / 1640.0 / 36.0!r}"])
    assert all(row.verdict == "pass" for row in witness.rows_of("short", Reducer(design)))
    monkeypatch.setattr("cycloid_mj.dynamics.mjcf.model.impratio", lambda *_: 3e3)
    assert sum(row.verdict == "fail" for row in witness.rows_of("short", Reducer(design))) >= 2


def test_half_the_step_changes_nothing() -> None:
    design = override(witness.high_friction(), [f"drive.hold_s={SETTLED + 60.0 / 1640.0 / 36.0!r}"])
    np.testing.assert_allclose(
        witness.of_witness(Reducer(design)), witness.of_witness(Reducer(design), 0.5e-6), rtol=2e-3
    )


@pytest.mark.slow
def test_free_pins_in_closed_sockets_agree() -> None:
    rows = witness.rows_of("free", Reducer(reducer_of(FREE, *SHORT, 'ring.socket="closed"')))
    assert [row.verdict for row in rows[:4]] == ["pass"] * 4
    assert rows[4].difference < 10.0


@pytest.mark.slow
@pytest.mark.parametrize("case", witness.CASES)
def test_runs_agree_with_the_witness(case: str) -> None:
    assert all(row.verdict == "pass" for row in witness.rows_of(case, Reducer(witness.CASES[case]())))


@pytest.mark.parametrize(("preset", "change"), [("nonpin", "load.torque_nm=1"), ("pin", "drag.crank_nm=0.1")])
def test_what_the_witness_does_not_cover_is_refused(preset: str, change: str) -> None:
    with pytest.raises(DesignError, match="witness"):
        planar.planar(override(PRESETS[preset], [change, "drive.ramp_s=0"]))
