"""The error budget: Sobol indices against closed forms, and the coverage of their confidence intervals."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.stats import binom, qmc, sobol_indices, uniform

from cycloid_mj.design import PRESETS, override
from cycloid_mj.design.zone import Zone
from cycloid_mj.explore import budget, sampling, tolerances
from cycloid_mj.explore.jam import PRELOADS, find_jams
from cycloid_mj.reducer import Reducer

Function = Callable[[dict[str, np.ndarray]], np.ndarray]


def ishigami(x: np.ndarray) -> np.ndarray:
    return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def sets_of(function, zones: dict[str, Zone], count: int) -> tuple[list[dict], dict[str, np.ndarray]]:
    """Deviations in the sets A and B, and a function of one number for each zone in all sets."""
    width = len(zones)
    shares_of = qmc.Sobol(2 * width, rng=np.random.default_rng(1)).random(count)
    a, b = (
        np.stack([zone.quantiles(half[:, i]) for i, zone in enumerate(zones.values())], axis=1)
        for half in (shares_of[:, :width], shares_of[:, width:])
    )
    mixed = {key: np.where(np.arange(width) == i, b, a) for i, key in enumerate(zones)}
    values = {name: function(x) for name, x in {"A": a, "B": b, **mixed}.items()}
    return [dict(zip(zones, x.T, strict=True)) for x in (a, b)], values


def test_shares_match_the_closed_form_and_scipy() -> None:
    """Ishigami's function: first order 0.314, 0.442, 0, total 0.558, 0.442, 0.244 (Saltelli 2008, p. 179)."""
    zones = {key: Zone("uniform", 0.0, np.pi) for key in "xyz"}
    found = {one.source: one for one in budget.compute_shares(zones, *sets_of(ishigami, zones, 4096))}
    for key, first, total in (("x", 0.3139, 0.5576), ("y", 0.4424, 0.4424), ("z", 0.0, 0.2437)):
        assert (found[key].first_order, found[key].total) == pytest.approx((first, total), abs=0.02)
        assert found[key].ci95[0] <= total <= found[key].ci95[1]
    dists = [uniform(loc=-np.pi, scale=2.0 * np.pi)] * 3
    theirs = sobol_indices(func=lambda x: ishigami(x.T)[np.newaxis], n=4096, dists=dists, rng=np.random.default_rng(3))
    ours = np.array([[found[key].first_order, found[key].total] for key in "xyz"]).T
    np.testing.assert_allclose(ours, [theirs.first_order.ravel(), theirs.total_order.ravel()], atol=0.03)


def test_a_linear_figure_has_exact_shares_and_an_idle_tolerance_none() -> None:
    zones = {"a": Zone("normal", 1.0, 2.0), "b": Zone("uniform", 0.0, 3.0), "idle": Zone("normal", 0.0, 5.0)}
    sets, values = sets_of(lambda x: 3.0 + 1.5 * x[:, 0] - x[:, 1], zones, 128)
    values = {name: np.where(np.arange(128) == 7, np.nan, of) for name, of in values.items()}  # a sample that jams
    a, b, idle = budget.compute_shares(zones, sets, values)
    assert (a.source, b.source, idle.source) == tuple(zones)
    assert (a.first_order, a.total, b.total) == pytest.approx((0.75, 0.75, 0.25), abs=1e-9)
    assert (idle.first_order, idle.total, *idle.ci95) == (0.0, 0.0, 0.0, 0.0)


def test_too_few_samples_have_no_shares() -> None:
    zones = {"a": Zone("normal", 0.0, 1.0), "b": Zone("normal", 0.0, 1.0)}
    sets, values = sets_of(lambda x: x[:, 0] + x[:, 1], zones, 64)
    assert len(budget.compute_shares(zones, sets, values)) == 2
    jammed = {**values, "b": np.where(np.arange(64) == 7, np.nan, values["b"])}
    assert budget.compute_shares(zones, sets, jammed) == ()


PINS = {"cam": Zone("uniform", 0.0, 3.0**0.5), "pins": Zone("normal", 0.0, 1.0), "holes": Zone("normal", 0.0, 1.0)}
SHAPES = {"cam": (), "pins": (36, 2), "holes": (8, 2)}


def nearly_linear(x: dict[str, np.ndarray]) -> np.ndarray:
    """A cam, 36 pins and 8 holes; the cam acts together with one pin, and one hole by its square."""
    cam, pins, holes = x["cam"], x["pins"].sum(axis=(1, 2)), x["holes"].sum(axis=(1, 2))
    return cam + 0.05 * pins + 0.05 * holes + 0.2 * cam * x["pins"][:, 0, 0] + 0.1 * x["holes"][:, 0, 0] ** 2


def interacting(x: dict[str, np.ndarray]) -> np.ndarray:
    """The cam acts only together with one pin."""
    return x["cam"] * x["pins"][:, 0, 0] + 0.3 * x["holes"][:, 0, 0]


EXACT = {
    "nearly_linear": (1.0 + 0.2**2, 0.05**2 * 72 + 0.2**2, 0.05**2 * 16 + 2.0 * 0.1**2),
    "interacting": (1.0, 1.0, 0.3**2),
}
"""Variance of each tolerance in total, by hand: squares of the coefficients, twice that of a normal number's square."""
VARIANCE = {"nearly_linear": 1.0 + 0.05**2 * 88 + 0.2**2 + 2.0 * 0.1**2, "interacting": 1.0 + 0.3**2}


def synthetic(function: Function, samples: int, generator: np.random.Generator) -> tuple[budget.Share, ...]:
    """The budget of a function of many numbers, of independent draws."""
    a, b = (
        {key: zone.quantiles(generator.random((samples, *SHAPES[key]))) for key, zone in PINS.items()} for _ in range(2)
    )
    mixed = {key: function({**a, key: b[key]}) for key in PINS}
    return budget.compute_shares(PINS, [a, b], {"A": function(a), "B": function(b), **mixed})


@pytest.mark.parametrize("samples", [64, pytest.param(256, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", list(EXACT))
def test_intervals_contain_the_exact_share(name: str, samples: int) -> None:
    """Of 200 seeds 90 % or more each; a binomial count of 0.9 lies above the bound with 99.9 %."""
    studies, generator = 200, np.random.default_rng(samples)
    hits = dict.fromkeys(PINS, 0)
    exact = dict(zip(PINS, np.array(EXACT[name]) / VARIANCE[name], strict=True))
    for _ in range(studies):
        for share in synthetic(globals()[name], samples, generator):
            assert 0.0 <= share.first_order <= share.total <= 1.0
            low, high = share.ci95
            hits[share.source] += low <= min(exact[share.source], 1.0) <= high
    assert min(hits.values()) >= binom.ppf(0.001, studies, 0.9), hits


def test_a_dominant_single_tolerance_keeps_its_control_variate_next_to_many_pins(monkeypatch) -> None:
    """At 64 samples the 72 numbers of the pins are too many for a fit; a fit of the cam lowers its error."""
    exact = EXACT["nearly_linear"][0] / VARIANCE["nearly_linear"]

    def error() -> float:
        generator = np.random.default_rng(3)
        largest = [synthetic(nearly_linear, 64, generator)[0] for _ in range(60)]
        assert all(share.source == "cam" for share in largest)
        return float(np.sqrt(np.mean([(share.total - exact) ** 2 for share in largest])))

    fitted = error()
    monkeypatch.setattr(budget, "SOBOL", budget.SobolSettings(max_columns=0.0))
    assert fitted < 0.8 * error()


@pytest.mark.slow
def test_intervals_contain_the_share_of_a_drive_with_errors_of_every_pin() -> None:
    """`pin`, cam, pin and hole positions: the intervals of 24 seeds of 64 samples and the mean of 4 of 512."""
    words = {"cam": "uniform 0.3", "pin_position": "normal 0.3", "hole_position": "normal 0.3"}
    reducer = Reducer(override(PRESETS["pin"], {f"tolerance.{key}": text for key, text in words.items()}))
    zones = sampling.tolerance_zones(reducer)
    keys = ("backlash_arcmin", *PRELOADS, *PRELOADS.values())

    def study(samples: int, seed: int) -> dict[str, budget.Share]:
        blocks = budget.list_budget_sets(zones, samples)
        figures = {
            name: tolerances.solve_sample_batch(reducer, zones, seed, 12, (block, keys))
            for name, block in blocks.items()
        }
        values = {name: np.where(find_jams(one), np.nan, one["backlash_arcmin"]) for name, one in figures.items()}
        drawn = [sampling.draw_deviations(reducer, zones, seed, blocks[name]) for name in "AB"]
        return {share.source: share for share in budget.compute_shares(zones, drawn, values)}

    reference = [study(512, seed) for seed in range(4)]
    few = [study(72, 100 + seed) for seed in range(24)]
    for key in zones:
        exact = float(np.mean([one[key].total for one in reference]))
        hits = sum(one[key].ci95[0] <= exact <= one[key].ci95[1] for one in few if one)
        assert hits >= binom.ppf(0.001, sum(map(bool, few)), 0.9), (key, exact, hits)
