"""The protocol: loops read by makers' definitions, of the model and of a bench alike, and starts from rest."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.units import ARCMINUTE, DEGREE
from cycloid_mj.bench import MeasuredLoop, measured_loop, read_loop
from cycloid_mj.bench.loop_figures import loop_coulomb_torque, loop_hysteresis, loop_lost_motion, stiffness_between
from cycloid_mj.bench.protocol import (
    CRANK_TORQUE,
    INTERVALS,
    LINES,
    OUTPUT_TORQUE,
    BenchFiles,
    compute_model_loop,
    protocol,
    read_breakaway_torque,
)
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS
from cycloid_mj.measure import hysteresis
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.balance import powers
from cycloid_mj.statics.windup import LOST_MOTION_SHARE

RATED, STIFFNESS, PLAY = 40.0, 9000.0, 4e-3  # [N m], [N m/rad], [rad]


def loop_of(coulomb: float, noise: float = 0.0, most: float = RATED) -> MeasuredLoop:
    """A spring beyond a play with Coulomb friction beside it: what the teeth carry is the torque less friction."""
    up = np.linspace(-most, most, 801)
    torque = np.concatenate([up, up[::-1]])
    carried = torque - coulomb * np.repeat([1.0, -1.0], len(up))
    turn = carried / STIFFNESS + 0.5 * PLAY * np.sign(carried)
    ends = (most - coulomb) / STIFFNESS + 0.5 * PLAY
    # friction turns round before the output does
    turn = np.clip(turn, -ends, ends)
    turn += noise * np.random.default_rng(0).standard_normal(len(turn))
    return measured_loop("made", torque, turn / DEGREE)


@pytest.mark.parametrize("coulomb", [0.3, 4.0])
def test_a_synthetic_loop_has_its_known_figures(coulomb: float) -> None:
    """Friction above 3 % of the rated torque hides the play from the lost motion; let go, the branches show it."""
    loop, level = loop_of(coulomb), LOST_MOTION_SHARE * RATED
    shown = PLAY if coulomb < level else 0.0
    assert loop_lost_motion(loop, RATED).value == pytest.approx(shown + 2.0 * level / STIFFNESS, rel=1e-6)
    assert loop_hysteresis(loop, RATED).value == pytest.approx(PLAY + 2.0 * coulomb / STIFFNESS, rel=1e-6)
    for low, high in INTERVALS.values():
        assert stiffness_between(loop, low * RATED, high * RATED).value == pytest.approx(STIFFNESS, rel=1e-3)


def test_intervals_hold_the_truth_in_noise() -> None:
    loop, level = loop_of(0.3, noise=2e-5), LOST_MOTION_SHARE * RATED
    for found, truth in (
        (loop_lost_motion(loop, RATED), PLAY + 2.0 * level / STIFFNESS),
        (loop_hysteresis(loop, RATED), PLAY + 0.6 / STIFFNESS),
        (stiffness_between(loop, 0.5 * RATED, RATED), STIFFNESS),
    ):
        assert found.low < truth < found.high
        assert found.high - found.low < 0.1 * truth


def test_a_torque_range_beyond_the_loop_has_no_stiffness() -> None:
    loop = loop_of(0.3, most=0.4 * RATED)
    assert math.isnan(stiffness_between(loop, 0.5 * RATED, RATED).value)
    assert math.isnan(stiffness_between(loop, 0.15 * RATED, 0.5 * RATED).value)
    assert stiffness_between(loop, 0.03 * RATED, 0.15 * RATED).value == pytest.approx(STIFFNESS, rel=1e-3)
    assert math.isnan(loop_lost_motion(loop_of(0.3, most=0.02 * RATED), RATED).value)


def test_the_models_loop_has_the_lost_motion_that_is_measured() -> None:
    """By another reading of the same run: that of `measure lost-motion`."""
    design = PRESETS["pin"]
    reducer = Reducer(design).working_at(design.rated_torque)
    rated = design.rated_torque
    run = hysteresis.run_loop(reducer, 0.0, rated, hysteresis.quasi_static_period(reducer, rated))
    found = compute_model_loop(reducer, rated, 0.0)
    assert loop_lost_motion(found, rated).value == pytest.approx(run.lost_motion, rel=1e-3)
    # to zero by a line through other points
    assert loop_hysteresis(found, rated).value == pytest.approx(run.backlash, rel=0.03)


def test_friction_of_the_wind_up_is_in_the_models_loop() -> None:
    design = PRESETS["printed"]
    reducer = Reducer(design).but(springs={"friction": 2.0, "friction_travel": 1e-4})
    loop = compute_model_loop(reducer, design.rated_torque, 0.0)
    assert loop_coulomb_torque(loop).value == pytest.approx(2.0, rel=0.02)


def test_a_measurement_simulated_by_the_model_agrees_with_it(tmp_path: Path) -> None:
    """Files written of the model's own loop give the model's figures, through the command."""
    design = PRESETS["pin"]
    rated = design.rated_torque
    loop = compute_model_loop(Reducer(design).working_at(rated), rated, 0.0)
    rows = zip(loop.torque.tolist(), (loop.deflection / DEGREE).tolist(), strict=True)
    file, run = tmp_path / "loop.csv", tmp_path / "run.csv"
    file.write_text("torque_output_Nm,deflection_deg\n" + "".join(f"{one!r},{other!r}\n" for one, other in rows))
    run.write_text(f"{CRANK_TORQUE}\n0.01\n-0.03\n")
    words = ["protocol", "pin", "--angles", "1", "--loop", str(file), "--running", str(run), "--out", str(tmp_path)]
    assert main([*words, "--quiet"]) == 0
    lines = json.loads((tmp_path / "pin-protocol.json").read_text())["lines"]
    assert set(lines) == set(LINES)
    for key in ("lost_motion_arcmin", "hysteresis_loss_arcmin", "stiffness_high_nm_per_arcmin"):
        assert lines[key]["bench"]["value"] == pytest.approx(lines[key]["model"]["value"], rel=1e-9)
    assert lines["running_torque_nm"]["bench"]["value"] == pytest.approx(0.02)
    assert lines["te_arcsec"]["bench"] is None
    assert all(line["definition"] and line["source"] for line in lines.values())
    assert 0.5 < lines["lost_motion_arcmin"]["model"]["value"] < 2.0


def test_the_back_driving_torque_leaves_a_free_crank_none() -> None:
    """At that torque the output's share is what friction takes, as told by how it grows under a smaller load."""
    design = PRESETS["pin"]
    reducer = Reducer(design).working_at(design.rated_torque)
    found = protocol(reducer, BenchFiles(), design.rated_torque, angles=1).model
    driving = found["back_driving_torque_nm"].value
    resting = reducer.but(drive={"speed": 1e-3 * design.drive.speed})
    lost = powers(resting, -10.0 * driving).lost / abs(resting.design.drive.speed)
    grown = (lost - found["starting_torque_nm"].value) / (10.0 * driving)
    assert driving / design.reduction == pytest.approx(found["starting_torque_nm"].value + grown * driving, rel=0.1)
    assert found["starting_torque_nm"].value < found["running_torque_nm"].value  # no centrifugal force at rest
    assert found["lost_motion_arcmin"].value * ARCMINUTE < 1e-3


def test_a_crank_breaks_away_where_it_does_not_return(tmp_path: Path) -> None:
    file = tmp_path / "start.csv"
    # it moves within its play and comes back, then goes
    file.write_text(f"crank_deg,{OUTPUT_TORQUE}\n5.0,0.0\n5.3,0.5\n5.02,1.0\n5.05,-1.5\n6.0,-2.0\n9.0,-2.1\n")
    assert read_breakaway_torque(file, OUTPUT_TORQUE) == 1.5
    file.write_text(f"crank_deg,{OUTPUT_TORQUE}\n5.0,0.0\n5.05,0.5\n5.02,1.0\n")
    with pytest.raises(UsageError, match="until the crank turns"):
        read_breakaway_torque(file, OUTPUT_TORQUE)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--rated-nm", "-3"], "greater than 0"),
        (["--angles", "0"], "from 1 to 360"),
        (["--loop", "none.csv"], "cannot read"),
        (["--starting", "none.csv"], "cannot read"),
    ],
)
def test_wrong_flags_are_reported_in_one_line(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["protocol", "pin", *words]) == 2
    error = capsys.readouterr().err.strip().splitlines()
    assert len(error) == 1
    assert message in error[0]


def test_a_loop_in_newton_millimetres_is_refused_before_the_work(tmp_path: Path) -> None:
    loop = Path(__file__).parents[1] / "data" / "bench" / "play_loop.csv"
    first, *rows = loop.read_text().splitlines()
    split = [row.split(",") for row in rows]
    (tmp_path / "loop.csv").write_text("\n".join([first, *(f"{1000.0 * float(t)},{d}" for t, d in split)]))
    with pytest.raises(UsageError, match="If the column torque_output_Nm is in N mm"):
        protocol(Reducer(PRESETS["printed"]), BenchFiles((read_loop(tmp_path / "loop.csv"),)), 10.4)
