"""Vibration of RV reducers: the housing's force against weight and momentum, tilting moment, unbalance, the measure."""

import numpy as np
import pytest
from rv_runs import COULOMB_RV80E

from cycloid_mj.base.names import planar_speeds
from cycloid_mj.dynamics.run import model_for, simulate
from cycloid_mj.measure import vibration
from cycloid_mj.measure.reaction import carrier_tilting, inertia_force, reaction, unbalance, weight_force
from cycloid_mj.measure.steady import run_steady, steady_design
from cycloid_mj.parts import moving_masses
from cycloid_mj.reducer import reducer_of
from cycloid_mj.statics.ideal import ideal_rv_at

FIXED = {"ring": {"pins": "fixed"}}


@pytest.mark.parametrize(
    "changes",
    [
        pytest.param({}, id="floating"),
        pytest.param({"planet": {"sun_support": "fixed"}}, id="fixed sun"),
        pytest.param({"output": {"member": "ring"}}, id="ring"),
    ],
)
def test_force_on_the_housing_is_weight_less_momentum(changes: dict[str, dict[str, str]]) -> None:
    """A single disc, so that neither the forces nor the momentum of two discs cancel."""
    reducer = reducer_of(COULOMB_RV80E.but(**FIXED, drive={"ramp": 0.0, "hold": 0.03}, settings={"log_rate": 1e5}))
    reducer = reducer.but(gear={"discs": 1}, **changes)
    run = simulate(reducer.design, model_for("planar", reducer))
    run = run.select(run.time > 0.01)
    forces, interval = reaction(run, reducer), np.diff(run.time)[:, np.newaxis]
    accelerations = [np.diff(run.block(planar_speeds(gear)[:2]), axis=0) / interval for gear in reducer.gears]
    expected = weight_force(reducer) + inertia_force(run, reducer, accelerations)
    assert forces.total.mean(axis=0) == pytest.approx(expected.mean(axis=0), abs=0.15)
    assert np.abs(inertia_force(run, reducer, accelerations)).max() > 5.0
    assert np.abs(forces.ring).max() > 1000.0
    assert np.abs(forces.output).max() > 1000.0
    assert bool(np.any(forces.crank)) == (reducer.planet.sun_support == "fixed")


def test_weight_is_that_of_all_moving_parts() -> None:
    reducer = reducer_of(COULOMB_RV80E.but(**FIXED))
    masses = moving_masses(reducer)
    carrier_and_cranks = masses["output"].mass + 3 * masses["crank"].mass
    discs = masses["gear_1"].mass + masses["gear_2"].mass
    total = carrier_and_cranks + discs + masses["sun"].mass
    assert weight_force(reducer) == pytest.approx([0.0, -9.8 * total])


def test_tilting_moment_on_the_carrier_is_that_of_ideal_sharing() -> None:
    """Both discs press with opposite forces, 17 mm apart; the deflection of their bearings changes them by 3 %."""
    reducer = steady_design(reducer_of(COULOMB_RV80E.but(**FIXED)))
    run = run_steady(reducer, 0.01, 13)
    moment = np.linalg.norm(carrier_tilting(run, reducer), axis=1)
    resultant = ideal_rv_at(reducer, np.linspace(0.0, 0.5, 40)).resultant
    force = np.linalg.norm(resultant[:, 0] - resultant[:, 1], axis=-1).mean() / 2.0
    assert moment.mean() == pytest.approx(force * 0.017, rel=0.03)


def test_two_discs_are_balanced_and_one_is_not() -> None:
    two, one = reducer_of(COULOMB_RV80E), reducer_of(COULOMB_RV80E.but(gear={"discs": 1}))
    moment = moving_masses(two)["gear_1"].mass * 1.5e-3
    assert unbalance(two).bare < 1e-9 * moment
    assert unbalance(one).bare == pytest.approx(moving_masses(one)["gear"].mass * 1.5e-3)
    # discs 17 mm apart; the eccentrics of the cranks lie in the same planes
    assert unbalance(two).couple > moment * 0.017


@pytest.mark.slow
def test_the_measure_has_the_speed_of_the_cranks() -> None:
    measured = vibration(COULOMB_RV80E.but(**FIXED), quick=True)
    orbit = measured.quantities["orbit_loaded"]
    assert orbit.value == pytest.approx(orbit.reference, rel=0.01)
    assert orbit.reference == pytest.approx(1.5e-3 * (39.0 * 2.0 * np.pi * 0.25) ** 2)
    assert measured["mean_force_loaded"] == pytest.approx(measured.quantities["mean_force_loaded"].reference, rel=2e-3)
    assert measured["output_tilting_rms_loaded"] > 100.0
    assert "housing_bare_rotating" not in measured.quantities
    assert {curve.x_label for curve in measured.curves if curve.panel.startswith("rms")} == {"sun speed [rpm]"}
