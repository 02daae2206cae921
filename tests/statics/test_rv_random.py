"""Random RV reducers that can be built: statics against closed forms, its own balance, its powers, and runs."""

from collections.abc import Iterator

import numpy as np
import pytest

from cycloid_mj.base.errors import DesignError
from cycloid_mj.checks import soundness
from cycloid_mj.design import PRESETS, Design
from cycloid_mj.geometry.rv_loads import closed_form_stiffness
from cycloid_mj.measure.efficiency_map import run_forward
from cycloid_mj.measure.steady import steady_design
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.contact import tooth_stiffness
from cycloid_mj.statics.rv_sheet import (
    ideal_rv,
    rv_powers,
    solve_running_equilibrium,
    solve_rv_equilibrium,
    torque_on_carrier,
)


def random_rv_reducers(count: int, seed: int) -> Iterator[RvReducer]:
    """Iterate over RV reducers without an error in ``design check``; the others that are drawn are skipped."""
    draw, found = np.random.default_rng(seed), 0
    while found < count:
        design = drawn(draw, found)
        try:
            reducer = RvReducer(design) if design else None
            if reducer and all(item.passed or item.severity == "warning" for item in soundness(reducer)):
                found += 1
                yield reducer
        except DesignError:
            pass


def drawn(draw: np.random.Generator, number: int) -> Design | None:
    """Draw a design, which may well not be one that can be built; None where its values are not even allowed."""
    base = PRESETS["rv80e" if draw.random() < 0.5 else "rv64"]
    circle, count = base.ring.pin_circle_radius, int(draw.integers(2, 4))
    discs = int(draw.integers(1 if count == 3 else 2, 4))  # a single disc on two cranks has dead points
    sun = int(draw.integers(8, 16))
    assert base.planet is not None
    planet = count * int(draw.integers(30 // count, 44 // count)) - sun % count
    module = 2.0 * draw.uniform(0.5, 0.58) * circle / (sun + planet)
    teeth = int(draw.integers(30, 52))
    try:
        return base.but(
            name=f"drawn {number}",
            ring={"teeth": teeth, "pins": str(draw.choice(["free", "fixed"]))},
            gear={"discs": discs, "eccentricity": draw.uniform(0.6, 0.85) * circle / teeth},
            output={"member": str(draw.choice(["carrier", "ring"]))},
            planet={"sun_teeth": sun, "planet_teeth": planet, "module": module, "backlash": draw.uniform(0.0, 4e-5)},
            cranks={
                "count": count,
                "needle_clearance": draw.uniform(-3e-6, 6e-6),
                "taper_clearance": draw.uniform(0.0, 3e-6),
                "post_radius": 0.6 * (base.cranks.post_radius if base.cranks else 0.0),
            },
            clearance={"pin_gear": draw.uniform(1e-7, 4e-6), "pin_socket": draw.uniform(1e-7, 4e-6)},
            contact={"needles": str(draw.choice(["lumped", "each"]))},
            friction={"law": "coulomb"},
            crank_errors={"carrier_x": tuple(draw.normal(0.0, 3e-6, count).tolist())},
        )
    except DesignError:
        return None


REDUCERS = list(random_rv_reducers(8, 5))


@pytest.mark.parametrize("reducer", REDUCERS, ids=lambda reducer: reducer.design.name)
@pytest.mark.parametrize("share", [0.03, 1.0])
def test_forces_balance_discs_and_carrier(reducer: RvReducer, share: float) -> None:
    """The torque that cranks and planets transmit to the carrier is the load; forces of bearings have no net force."""
    torque = share * reducer.design.load.torque
    loads = solve_rv_equilibrium(reducer, torque, 25)
    assert np.all(np.isfinite(loads.carrier_turn))
    assert loads.pins.min() >= 0.0
    ideal = ideal_rv(reducer, torque)
    # the force of all pins on a disc has a fixed moment, so its mean is that of ideal sharing up to deflections
    assert loads.pins.sum(axis=1).mean() == pytest.approx(ideal.pins.sum(axis=(1, 2)).mean(), rel=0.5)
    assert np.all(loads.compliance > 0.0)
    doubled = solve_rv_equilibrium(reducer, 2.0 * torque, 25)
    assert np.all(np.abs(doubled.carrier_turn - loads.carrier_turn) > 0.0)


@pytest.mark.parametrize("reducer", REDUCERS, ids=lambda reducer: reducer.design.name)
def test_power_of_the_sun_covers_output_and_losses(reducer: RvReducer) -> None:
    """The work of the planets' forces on the sun, at its speed against the ring, is that of output and friction."""
    torque = reducer.design.load.torque
    powers = rv_powers(reducer, torque, 61)
    assert 0.5 < powers.efficiency < 1.0
    loads = solve_running_equilibrium(reducer, torque, 61)
    flanks = (loads.flanks[:, 0] - loads.flanks[:, 1]).sum(axis=1)
    base = 0.5 * reducer.planet.module * reducer.planet.sun_teeth * np.cos(reducer.planet.pressure_angle)
    ideal = abs(torque_on_carrier(reducer, torque)) / reducer.stage.to_carrier / base
    # the flanks carry the torque of the sun with the losses of all that follows, without those of their own
    assert abs(float(flanks.mean())) == pytest.approx(ideal / powers.efficiency, rel=0.05)


@pytest.mark.parametrize("reducer", REDUCERS, ids=lambda reducer: reducer.design.name)
def test_stiffness_is_near_the_closed_form(reducer: RvReducer) -> None:
    loads = solve_rv_equilibrium(reducer, 5.0 * reducer.design.load.torque, 25)
    tooth = float(np.mean(tooth_stiffness(reducer.at_rated_load, np.array([1.0 / reducer.design.ring.pin_radius]))))
    closed = closed_form_stiffness(reducer.stage, reducer.bearing_stiffness, tooth)
    assert 1.0 / loads.compliance.mean() == pytest.approx(closed, rel=0.25)


@pytest.mark.slow
@pytest.mark.parametrize("reducer", REDUCERS, ids=lambda reducer: reducer.design.name)
def test_runs_have_ratio_and_efficiency_of_statics(reducer: RvReducer) -> None:
    steady = steady_design(reducer)
    point = run_forward(steady, reducer.design.load.torque, reducer.design.drive.speed, 20, "planar")
    turns = [np.ptp(point.run[name]) for name in ("sun_angle", "output_angle")]
    assert turns[0] / turns[1] == pytest.approx(abs(reducer.design.ratio), rel=1e-3)
    efficiency = rv_powers(point.reducer, reducer.design.load.torque, 241).efficiency
    assert 100.0 * point.powers.efficiency == pytest.approx(100.0 * efficiency, abs=0.5)
