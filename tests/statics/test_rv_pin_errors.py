"""Rotation of an RV reducer's output by position errors of its pins: reciprocity, and equilibrium of all springs."""

import numpy as np
import pytest

from cycloid_mj.base.statistics import peak_to_peak
from cycloid_mj.base.units import ARCSECOND
from cycloid_mj.design import PRESETS
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.rv import compute_rv_springs, contact_gradients, solve_rv_loads
from cycloid_mj.statics.rv_sheet import closed_form_angles, closed_rotation, error_rotation, pin_equilibrium

REDUCER = RvReducer(PRESETS["rv80e"])
RATED = REDUCER.design.rated_torque


def with_pins(displacements: np.ndarray) -> RvReducer:
    """`rv80e` with displaced pins, shape (40, 2) [m]."""
    x, y = (tuple(column.tolist()) for column in displacements.T)
    return REDUCER.but(errors={"pin_x": x, "pin_y": y})


@pytest.mark.parametrize("pin", [0, 13])
def test_a_small_error_turns_the_output_by_the_change_of_its_pin_force_per_torque(pin: int) -> None:
    """Maxwell-Betti: a displacement d of a pin turns the carrier by -d dF/dT, with the force F(T) on this pin."""
    equilibrium, step, offset = pin_equilibrium(REDUCER), 0.001, np.array([3e-9, -2e-9])
    along = []
    for sign in (1, -1):
        loads = solve_rv_loads(equilibrium.springs, (1.0 + sign * step) * equilibrium.torque)
        gradients = contact_gradients(equilibrium.springs, loads.displacements)
        # the force of a pin on its disc is along the gradient of their gap
        along.append(
            sum(
                -loads.pins[:, contact] * (gradients[:, contact, 3 * disc : 3 * disc + 2] @ offset)
                for disc, contact in enumerate((pin, 40 + pin))
            )
        )
    displacements = np.zeros((40, 2))
    displacements[pin] = offset
    rotation, expected = equilibrium.rotation(displacements), (along[0] - along[1]) / (2.0 * step * equilibrium.torque)
    np.testing.assert_allclose(rotation, expected, atol=0.03 * np.abs(expected).max())


def test_the_rotation_is_that_of_the_equilibrium_of_a_design_with_these_errors() -> None:
    displacements = np.random.default_rng(4).normal(0.0, 3e-6, (40, 2))
    equilibrium = pin_equilibrium(REDUCER)
    loads = solve_rv_loads(compute_rv_springs(with_pins(displacements), equilibrium.springs.crank), equilibrium.torque)
    expected = loads.carrier_turn - equilibrium.loads.carrier_turn
    np.testing.assert_allclose(equilibrium.rotation(displacements), expected, atol=1e-6 * np.abs(expected).max())


def test_the_rotation_of_a_design_adds_its_pins_to_the_closed_form() -> None:
    displacements = np.random.default_rng(4).normal(0.0, 3e-6, (40, 2))
    reducer = with_pins(displacements).but(crank_errors={"bore_x": (5e-6, 0.0, 0.0, 0.0, 0.0, 0.0)})
    pins = error_rotation(reducer) - closed_rotation(reducer)
    crank = closed_form_angles(reducer)[::7]
    springs = compute_rv_springs(with_pins(displacements), crank)
    expected = solve_rv_loads(springs, pin_equilibrium(REDUCER).torque).carrier_turn
    expected -= solve_rv_loads(compute_rv_springs(REDUCER, crank), pin_equilibrium(REDUCER).torque).carrier_turn
    # linear interpolation between two angles in each pin pitch
    np.testing.assert_allclose(pins[::7], expected, atol=0.03 * np.ptp(expected))
    assert error_rotation(REDUCER).max() == 0.0


def test_all_pins_on_a_larger_circle_turn_the_output_evenly() -> None:
    """Equal radial displacements open all gaps alike."""
    angles = 2.0 * np.pi * np.arange(40) / 40
    outwards = 1e-6 * np.stack([np.sin(angles), np.cos(angles)], axis=1)
    rotation = pin_equilibrium(REDUCER).rotation(outwards)
    assert abs(rotation.mean()) > 1.0 * ARCSECOND
    assert peak_to_peak(rotation) < 0.03 * abs(rotation.mean())


def test_two_discs_average_an_eccentric_ring() -> None:
    """A displaced ring is a displaced carrier: both discs turn the output in opposite directions (error map)."""
    displacements = np.tile([1e-6, 0.0], (40, 1))
    assert peak_to_peak(pin_equilibrium(REDUCER).rotation(displacements)) < 0.02 * ARCSECOND
    single = REDUCER.but(gear={"discs": 1})
    rotation = pin_equilibrium(single).rotation(displacements)
    assert peak_to_peak(rotation) / ARCSECOND == pytest.approx(6.83, rel=0.02)
