"""How far stress swings at a node: the same in every frame, exact where it is known, and what fatigue takes from it."""

import numpy as np
import pytest

from cycloid_mj.stress.recover import von_mises
from cycloid_mj.stress.swing import CANDIDATES, von_mises_bound, worst_nodes

TURN = np.linspace(0.0, np.pi, 25)


def one_node(*components) -> np.ndarray:
    """States (c, components, 1) of a node."""
    return np.stack(np.broadcast_arrays(*components), axis=1)[:, :, np.newaxis].astype(float)


def swung(states: np.ndarray) -> tuple[float, float]:
    (amplitude,), (mean,), _ = worst_nodes(states)
    return float(amplitude), float(mean)


def test_a_pull_that_comes_and_goes_pulsates() -> None:
    pulled = np.where(np.arange(25) % 2, 80.0, 0.0)
    assert swung(one_node(pulled, 0.0, 0.0)) == pytest.approx((40.0, 40.0))
    assert swung(one_node(-pulled, 0.0, 0.0)) == pytest.approx((40.0, -40.0))
    assert swung(one_node(pulled - 40.0, 0.0, 0.0))[0] == pytest.approx(40.0)


def test_stress_that_stands_still_has_no_amplitude() -> None:
    assert swung(one_node(np.full(25, 30.0), 0.0, 0.0)) == pytest.approx((0.0, 30.0))


def test_a_pull_that_turns_swings_though_its_size_stands_still() -> None:
    """Along x and along y lie sqrt(3) of it apart (von Mises of the difference); a signed size would see nothing."""
    cosine, sine = np.cos(TURN), np.sin(TURN)
    states = one_node(100.0 * cosine**2, 100.0 * sine**2, 100.0 * sine * cosine)
    assert np.ptp(von_mises(states[:, :, 0].T)) == pytest.approx(0.0, abs=1e-9)
    assert swung(states) == pytest.approx((50.0 * np.sqrt(3.0), 50.0))


def test_shear_to_and_fro_counts_as_von_mises() -> None:
    assert swung(one_node(0.0, 0.0, 10.0 * np.cos(TURN)))[0] == pytest.approx(10.0 * np.sqrt(3.0))
    assert swung(one_node(0.0, 0.0, 0.0, 0.0, 0.0, 10.0 * np.cos(TURN)))[0] == pytest.approx(10.0 * np.sqrt(3.0))


def test_instants_near_a_patch_do_not_count() -> None:
    pulled = np.where(np.arange(25) % 2, 80.0, 0.0)
    pulled[7] = np.nan
    spoiled = pulled.copy()
    spoiled[7] = 900.0
    assert swung(one_node(pulled, 0.0, 0.0)) == pytest.approx((40.0, 40.0))
    assert swung(one_node(spoiled, 0.0, 0.0))[0] == pytest.approx(450.0)
    never = np.concatenate([one_node(np.full(25, np.nan), 0.0, 0.0), one_node(pulled, 0.0, 0.0)], axis=2)
    assert list(worst_nodes(never)[2]) == [1]


def test_the_worst_of_many_nodes_is_found() -> None:
    """By brute force over all pairs of instants and all nodes, more than are looked at closely."""
    rng = np.random.default_rng(5)
    count = CANDIDATES + 700
    states = rng.normal(size=(9, 3, count)) * rng.uniform(0.2, 1.0, count)
    every = [von_mises(states[i] - states[j]) for i in range(9) for j in range(i)]
    amplitude, _, nodes = worst_nodes(states)
    assert amplitude.max() == pytest.approx(0.5 * np.max(every), rel=1e-9)
    assert nodes[amplitude.argmax()] == np.max(every, axis=0).argmax()
    assert np.all(von_mises_bound(states) >= np.max(every, axis=0))
