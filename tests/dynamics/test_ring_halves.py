"""Runs of a ring in two halves: unturned they are the ring, turned they press and rub as statics has it."""

import numpy as np
import pytest

from cycloid_mj.base.record import Run
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.design import PRESETS
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.planar.model import planar_model
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.parts import moving_masses
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.balance import powers

SETTLED = 0.03


def made(kind: str, halves: int, arcmin: float = 0.0, name: str = "printed") -> Reducer:
    ring = {"kind": kind, "halves": halves, "preload": arcmin * ARCMINUTE}
    return Reducer(PRESETS[name].but(ring=ring, friction={"law": "coulomb"}))


def run_of(reducer: Reducer, solver: str, turns: float = 0.02) -> Run:
    short = reducer.steady(SETTLED, turns, settings={"log_rate": 2000.0})
    return simulate(short.design, planar_model(short) if solver == "planar" else build(short.design))


@pytest.mark.parametrize("solver", ["planar", "mujoco"])
@pytest.mark.parametrize("kind", ["pin", "nonpin"])
def test_halves_that_are_not_turned_run_as_the_ring(kind: str, solver: str) -> None:
    whole, halves = (run_of(made(kind, count), solver) for count in (1, 2))
    for name in ("output_angle", "gear_x", "gear_y", "crank_torque"):
        assert halves[name] == pytest.approx(whole[name], rel=1e-6, abs=1e-9), name
    tooth = made(kind, 1).design.tooth_pair
    one, other = np.split(halves.forces(tooth), 2, axis=1)
    assert one == pytest.approx(other, abs=1e-6)
    assert one + other == pytest.approx(whole.forces(tooth), rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("solver", ["planar", "mujoco"])
def test_pressed_halves_rub_as_much_as_by_statics(solver: str) -> None:
    """The crank's torque in the mean, at the same angles and load; by statics it is 1.66 times that without preload."""
    reducer = made("pin", 2, 20.0)
    run = run_of(reducer, solver, 0.1)
    late = run.time > SETTLED
    torque = float(run["crank_torque"][late].mean())
    solved = powers(reducer, reducer.design.load.torque, run["crank_angle"][late])
    assert torque == pytest.approx(solved.crank / reducer.design.drive.speed, rel=0.02)


def test_free_pins_of_both_halves_move_and_have_half_the_mass() -> None:
    whole, halves = (made("pin", count, name="pin") for count in (1, 2))
    assert moving_masses(halves)["pin"].mass == pytest.approx(0.5 * moving_masses(whole)["pin"].mass)
    pressed = made("pin", 2, 0.2, "pin")
    run = run_of(pressed, "planar")
    teeth = pressed.design.ring.teeth
    assert run.forces("pin_gear").shape[1] == run.forces("pin_socket").shape[1] == 2 * teeth
    assert np.ptp(run[f"pin_{2 * teeth}_x"]) > 0.0
