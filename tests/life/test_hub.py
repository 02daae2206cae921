"""The output's bearings: their ratings, what they bear beside the discs' forces, and how much they give."""

import math
from dataclasses import replace

import pytest

from cycloid_mj.design import PRESETS
from cycloid_mj.figures import figure
from cycloid_mj.life.hub import USUAL, hub
from cycloid_mj.parts.export import casing
from cycloid_mj.reducer import Reducer

TWO = Reducer(PRESETS["twodisc"])


def test_the_moment_leaves_the_bearings_their_force_over_their_distance() -> None:
    found, (inner, outer) = hub(TWO), (0.5 * sum(ends) for ends in casing(TWO).bearings)
    assert found.spacing == pytest.approx(outer - inner)
    alone = replace(found, own=(0.0, 0.0))
    assert alone.moment == pytest.approx(found.bears * found.spacing)
    assert found.moment == pytest.approx(alone.moment - max(found.own) * found.spacing)
    # a force on the flange's face, whose moment about the inner bearing the outer one holds
    assert alone.radial == pytest.approx(found.bears * found.spacing / (found.spacing + found.lever))
    assert replace(found, own=(1e6, 0.0)).moment == replace(found, own=(1e6, 0.0)).radial == 0.0


def test_a_bearing_bears_its_load_for_the_life_that_is_asked_for() -> None:
    found, design = hub(TWO), TWO.design
    turns = design.service.life * 3600.0 * abs(design.drive.speed) / (2.0 * math.pi) / design.reduction
    assert found.bears < found.static
    assert 1e6 * (found.dynamic / found.bears) ** 3 == pytest.approx(turns)
    shorter = hub(TWO.but(service={"life": 0.01}))
    assert shorter.bears == shorter.static


def test_a_hub_tilts_by_what_the_balls_give() -> None:
    """The tilt by both bearings' approach, from Palmgren's formula in N and mm."""
    found = hub(TWO)
    force = 0.5 * found.moment / found.spacing
    ball = 4.37 * force / found.row.balls
    approach = 0.00044e-3 * (ball**2 / (1e3 * found.row.diameter)) ** (1.0 / 3.0)
    assert found.tilting_stiffness() == pytest.approx(0.5 * found.moment / (2.0 * approach / found.spacing))
    assert found.tilting_stiffness(USUAL) == pytest.approx(found.tilting_stiffness() * (4.37 / 5.0) ** (2.0 / 3.0))
    assert replace(found, own=(1e6, 0.0)).tilting_stiffness() == 0.0


def test_the_catalogue_has_them() -> None:
    assert figure("output_tilting_capacity_nm").value(TWO) == hub(TWO).moment
    assert figure("output_radial_load_n").value(TWO) == hub(TWO).radial
    assert figure("output_axial_load_n").value(TWO) == 0.25 * hub(TWO).static
    assert figure("output_tilting_stiffness_nm_per_arcmin").value(TWO) > 0.0
