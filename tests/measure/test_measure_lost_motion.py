"""Lost motion and stiffness: the readings on a curve that is known, the loops against an independent balance."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from designs import cases

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.record import Run
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.cli.app import main
from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.settling import closed_stiffness
from cycloid_mj.measure import bench, hysteresis
from cycloid_mj.measure.hysteresis import HysteresisLoop
from cycloid_mj.measure.lost_motion import lost_motion
from cycloid_mj.measure.lost_motion_table import loop_series
from cycloid_mj.reducer import Reducer, limits
from cycloid_mj.statics.windup import solve_windups
from cycloid_mj.validate import equilibrium

FIXED = Reducer(override(PRESETS["pin"], ['ring.pins="fixed"'])).at_rated_load
CRANK = 1.7


def made_loop(play_width: float, compliance: float, friction: float) -> HysteresisLoop:
    """Return a loop of a spring behind a play, with a width of friction in proportion to the torque."""
    phase = np.linspace(0.25, 1.25, 4000, endpoint=False)
    torque = 30.0 * np.sin(2.0 * np.pi * phase) ** 5
    side = np.where((phase < 0.5) | (phase >= 1.0), 1.0, -1.0)
    unloading = np.where((phase % 0.5) >= 0.25, 1.0, -1.0)
    turn = side * play_width / 2 + compliance * torque * (1.0 + friction * unloading)
    run = Run(time=phase, columns={"x": turn}, units={"x": "rad"})
    return HysteresisLoop(0.0, 30.0, phase, torque, turn, 0.5 * turn, -turn, run)


def test_readings_of_a_known_curve():
    loop = made_loop(2e-4, 5e-6, 0.1)
    assert loop.backlash == pytest.approx(2e-4, rel=1e-9)
    assert loop.lost_motion == pytest.approx(2e-4 + 2 * 0.03 * 30.0 * 5e-6, rel=1e-9)
    assert loop.stiffness == pytest.approx(1 / 5e-6, rel=1e-9)
    assert loop.compliance(loop.gear_turn) == pytest.approx(2.5e-6, rel=1e-9)
    assert loop.width == pytest.approx(2 * 0.1 * 15.0 * 5e-6, rel=1e-9)
    assert loop.offset == pytest.approx(0.0, abs=1e-15)
    assert made_loop(2e-4, 6e-6, 0.1).stiffness != pytest.approx(1 / 5e-6, rel=0.03)


def test_work_of_a_loop_is_its_area():
    # two triangles between branches of slope compliance (1 +- friction)
    loop = made_loop(0.0, 5e-6, 0.1)
    assert abs(loop.work) == pytest.approx(2 * 0.5 * 30.0 * (2 * 0.1 * 30.0 * 5e-6), rel=1e-3)


@pytest.fixture(scope="module")
def ideal_loop() -> HysteresisLoop:
    rated = FIXED.design.rated_torque
    return hysteresis.run_loop(
        bench.without_friction(FIXED), CRANK, rated, hysteresis.quasi_static_period(FIXED, rated)
    )


def test_loop_without_friction_is_the_static_balance(ideal_loop: HysteresisLoop):
    solved = solve_windups(FIXED, [CRANK], ideal_loop.rated)[0]
    # left: inertia, damping and the straight lines through the readings, 0.05 %, 0.07 %, and 0.26 % of the mesh
    assert ideal_loop.stiffness == pytest.approx(1.0 / solved.compliance(solved.turn), rel=0.0015)
    assert ideal_loop.lost_motion == pytest.approx(solved.lost_motion, rel=0.0022)
    series = loop_series(FIXED, ideal_loop)
    assert sum(series.values()) == pytest.approx(1.0 / ideal_loop.stiffness, rel=1e-12)
    for part, value in solved.series(FIXED).items():
        assert series[part] == pytest.approx(value, rel=0.008 if part == "mesh" else 0.0015), part


def test_balance_of_a_softer_cam_is_another(ideal_loop: HysteresisLoop):
    softer = override(FIXED.design, ["stiffness.cam_n_m=4.0e8"])
    solved = solve_windups(Reducer(softer), [CRANK], ideal_loop.rated)[0]
    assert ideal_loop.stiffness != pytest.approx(1.0 / solved.compliance(solved.turn), rel=0.03)


def test_backlash_of_a_loop_is_that_of_rigid_contacts(ideal_loop: HysteresisLoop):
    low, high = limits.stops(FIXED, CRANK)
    # the contacts that close first are softer than the line that is drawn on to zero
    assert ideal_loop.backlash == pytest.approx(high - low, rel=0.005)


def test_friction_causes_hysteresis_whose_area_is_its_work():
    rated = FIXED.design.rated_torque
    period = hysteresis.quasi_static_period(FIXED, rated)
    loop = hysteresis.run_loop(FIXED, CRANK, rated, period)
    assert loop.width > 5.0 * ARCMINUTE * 2e-3
    assert loop.work == pytest.approx(loop.dissipation, rel=0.1)


def test_series_of_clearances_and_closed_stiffness_are_of_the_size_of_the_balance():
    design = Reducer(PRESETS["pin"]).at_rated_load
    solved = solve_windups(design, [CRANK], 36.68)[0]
    # with clearance, fewer contacts are closed than the estimate takes
    assert 0.5 < 1.0 / solved.compliance(solved.turn) / closed_stiffness(design) < 1.05


def test_lost_motion_is_slightly_larger_than_the_backlash():
    crank = float(bench.crank_angles(Reducer(PRESETS["pin"]), 6)[1])
    solved = solve_windups(Reducer(PRESETS["pin"]), [crank], 36.68)[0]
    low, high = limits.stops(Reducer(PRESETS["pin"]), crank)
    assert high - low < solved.lost_motion < 1.1 * (high - low)
    shares = sorted(solved.turn)
    assert all(solved.turn[a] < solved.turn[b] for a, b in pairwise(shares))


def test_a_free_pin_needs_the_step_of_its_bowl():
    ideal, rated = bench.without_friction(Reducer(PRESETS["pin"])), PRESETS["pin"].rated_torque
    assert bench.bench_timestep(ideal, rated, "mujoco") < 5e-6
    assert bench.bench_timestep(bench.without_friction(FIXED), rated, "mujoco") == bench.BENCH.max_step
    given = override(FIXED.design, ["settings.timestep_us=2.0"])
    assert bench.bench_timestep(Reducer(given), rated) == 2e-6


@pytest.mark.parametrize("changes", [["errors.pin_dr_um={9=0.9}"], ["modification.pin_circle_um=-2.0"]])
@pytest.mark.parametrize("kind", cases(["fixed", "free"], "fixed"))
def test_statics_of_parts_as_made_is_the_independent_balance(kind: str, changes: list[str]):
    design = Reducer(
        override(bench.without_friction(Reducer(PRESETS["pin"])).design, [f'ring.pins="{kind}"', *changes])
    ).at_rated_load
    solved = solve_windups(design, [CRANK], 36.68)[0]
    stiffness = {pair: design.contacts[pair].stiffness for pair in design.design.pair_kinds}
    for share, turn in solved.turn.items():
        if abs(share) >= 0.5:
            alone = equilibrium.solve(design.but(load={"torque": share * 36.68}), stiffness, CRANK)
            assert turn == pytest.approx(alone.output_turn, rel=2e-4)


@pytest.mark.parametrize(("rated", "angles"), [(0.0, 8), (-1.0, 8), (30.0, 0)])
def test_nothing_to_measure_is_a_usage_error(rated: float, angles: int):
    with pytest.raises(UsageError, match="give a torque greater than 0"):
        lost_motion(FIXED.design, rated, angles)


def test_command_refuses_a_torque_that_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys):
    """Before it looks at its files, of which one is there."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lost-motion-pin.json").write_text("{}")
    assert main(["measure", "lost-motion", "--load-nm", "0", "--out", "."]) == 2
    assert "--load-nm 0: must be greater than 0" in capsys.readouterr().err
