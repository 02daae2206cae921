"""Objectives of the search: limits, and the expected improvement against its integral."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from cycloid_mj.sizing.objective import DEVIATIONS, Objective, lightest, shortest, strongest
from cycloid_mj.sizing.requirement import Requirement

FIGURES = {
    "capacity": np.array([10.0, 20.0]),
    "mass": np.array([1.0, 2.0]),
    "length": np.array([0.05, 0.08]),
    "backlash": np.array([3.0, 1.0]),
    "temperature": np.array([30.0, 40.0]),
}


def test_excess_is_that_of_the_limit_exceeded_most() -> None:
    objective = Objective("mass", {"capacity": 15.0, "length": 0.06})
    assert objective.excess(FIGURES) == pytest.approx([math.log(1.5), math.log(0.08 / 0.06)])
    assert (Objective("mass", {"capacity": 5.0}).excess(FIGURES) == 0.0).all()


def test_merit_increases_with_capacity_and_decreases_with_mass() -> None:
    strong, light = (Objective(key, {}).merit(FIGURES) for key in ("capacity", "mass"))
    assert strong[1] - strong[0] == pytest.approx(math.log(2.0))
    assert light[1] - light[0] == pytest.approx(-math.log(2.0))


def test_expected_improvement_equals_its_integral() -> None:
    objective, scale, best = Objective("mass", {"capacity": 12.0}), np.array([1.0, 0.5]), -math.log(1.1)
    found = objective.expected_improvement(FIGURES, scale, best)
    for row in range(2):
        improvement = _mean_gain(-math.log(FIGURES["mass"][row]), DEVIATIONS["mass"] * scale[row], best)
        probability = norm.cdf(math.log(FIGURES["capacity"][row] / 12.0) / (DEVIATIONS["capacity"] * scale[row]))
        assert found[row] == pytest.approx(improvement * probability, rel=1e-6, abs=1e-12)


def _mean_gain(mean: float, deviation: float, best: float) -> float:
    """Integrate the gain over `best` of a merit with a normal distribution."""
    density = norm(mean, deviation).pdf
    return float(quad(lambda merit: (merit - best) * density(merit), best, best + 3.0, points=[mean])[0])


def test_without_a_known_drive_the_improvement_is_the_probability_of_all_limits() -> None:
    found = Objective("mass", {"capacity": 10.0}).expected_improvement(FIGURES, np.ones(2), -math.inf)
    assert found[0] == pytest.approx(0.5)
    assert found[1] == pytest.approx(norm.cdf(math.log(2.0) / DEVIATIONS["capacity"]))


def test_infinite_limits_are_left_out() -> None:
    free = Requirement(29, 0.09, 13.0)
    assert set(lightest(free).limits) == {"capacity"}
    limited = free.but(length=0.06, backlash=3.0)
    assert lightest(limited).limits == {"capacity": 13.0, "length": 0.06, "backlash": 3.0}
    assert shortest(limited).limits == {"capacity": 13.0, "backlash": 3.0}
    assert strongest(limited).limits["length"] == 0.06
