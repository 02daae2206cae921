"""Tests of the tolerance samples that a rating uses."""

import numpy as np
import pytest

from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.explore.sampling import Batch, draw_samples, tolerance_zones
from cycloid_mj.figures.sampled import solve_states
from cycloid_mj.life.as_built import SETTINGS, _select_critical_samples, select_rated_samples
from cycloid_mj.reducer import Reducer


def test_a_sample_is_not_selected_if_any_of_its_loads_exceeds_the_percentile() -> None:
    """A sample at the percentile of one load may have the largest of another, which then determined the rating."""
    tooth, pin = np.arange(200.0), np.arange(200.0)
    pin[199], pin[189] = 189.0, 199.0  # the largest tooth load has the pin load at the percentile
    numbers, words = _select_critical_samples(
        {"tooth": tooth, "pin": pin}, {"tooth": "tooth {:g} MPa", "pin": "pin {:g} N"}, np.arange(200)
    )
    assert numbers == (188,)
    assert "tooth 188 MPa, pin 188 N" in words


@pytest.mark.parametrize("count", [1, 2, 3, 20, 200])
def test_loads_of_the_selected_samples_are_the_largest_below_their_percentiles(count: int) -> None:
    random = np.random.default_rng(count)
    loads = {key: random.random(count) for key in ("tooth", "pin", "cam")}
    numbers, _ = _select_critical_samples(loads, dict.fromkeys(loads, "{:g}"), np.arange(count))
    limits = {
        key: np.quantile(values, 0.01 * SETTINGS.percentile, method="inverted_cdf") for key, values in loads.items()
    }
    usual = np.all([loads[key] <= limits[key] for key in loads], axis=0)
    assert set(numbers) == {int(np.argmax(np.where(usual, values, -1.0))) for values in loads.values()}


def toleranced() -> Design:
    """Return `pin` with tolerances, and with clearances that let all samples turn."""
    clearances = [f"clearance.{pair}_um=5" for pair in ("pin_gear", "pin_socket", "cam", "output")]
    zones = [f'tolerance.{key}="normal 0.5"' for key in ("pin_position", "pin_radius", "hole_position")]
    return override(PRESETS["pin"], [*clearances, *zones])


def test_teeth_are_ranked_by_their_pressure() -> None:
    """Samples with equal tooth forces have pressures that differ by 4 %, and lives that differ by a factor of two."""
    reducer = Reducer(toleranced())
    selected = select_rated_samples(reducer)
    assert not selected.jams.any()
    samples = draw_samples(reducer, tolerance_zones(reducer), SETTINGS.seed, Batch(0, SETTINGS.samples))
    pressure = solve_states(reducer, samples, ["loaded"], SETTINGS.loaded_angles)["loaded"].tooth_pressure
    largest = max(pressure[[*selected.numbers]])
    assert 0.05 <= np.mean(pressure > largest) <= 0.06
    assert f"tooth {1e-6 * largest:.4g} MPa" in selected.words
