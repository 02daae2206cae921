"""What a study is said to need: from the sizes of its grids, for any design, before it begins."""

from dataclasses import dataclass

import pytest

from cycloid_mj.stress.cost import COST, Cost, add_costs, estimate_cost
from cycloid_mj.stress.study import QUICK, StudySettings


@dataclass(frozen=True)
class Sized:
    """As much of a grid as its cost takes."""

    part: str
    unknowns: int
    dimension: int = 2
    section: object = None


def test_the_cost_is_near_what_was_measured() -> None:
    """Quick studies of the paper's pin design in CPU seconds and peak memory, measured part by part: within 40 %."""
    for part, unknowns, dimension, seconds, megabytes in (
        ("pin_1", 5124, 2, 0.2, 246),
        ("ring", 51046, 2, 3.3, 465),
        ("gear", 87532, 2, 4.7, 597),
        ("shaft", 10593, 3, 3.1, 530),
        ("output", 33804, 3, 3.3, 525),
    ):
        found = estimate_cost(Sized(part, unknowns, dimension, section=part if part == "output" else None), QUICK)
        assert found.seconds == pytest.approx(seconds, rel=0.4), part
        assert found.memory == pytest.approx(1e6 * megabytes, rel=0.4), part


def test_the_cost_grows_with_grid_angles_and_supports() -> None:
    small, large = (estimate_cost(Sized("gear", unknowns), QUICK) for unknowns in (10_000, 40_000))
    assert large.seconds == pytest.approx(4 * small.seconds)
    assert large.memory - COST.base_memory == pytest.approx(4 * (small.memory - COST.base_memory))
    assert estimate_cost(Sized("gear", 10_000), StudySettings(angles=360, checked=5)).seconds > small.seconds
    assert estimate_cost(Sized("ring", 10_000), QUICK).seconds > small.seconds  # also under its other support


def test_parts_are_studied_one_after_the_other() -> None:
    large, small = Cost(1.0, 3e9, 1e8), Cost(2.0, 1e9, 2e8)
    assert add_costs([large, small]) == Cost(3.0, 3e9, 3e8)
    assert add_costs([small, large]).memory == 3.2e9  # beside what is kept of the first
