"""Tooth roots by ISO 6336-3 against the fillet that the rack cuts."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from cycloid_mj.geometry.involute import InvoluteGear, gear_pair
from cycloid_mj.geometry.tooth_root import contact_ratio, tooth_root

MODULE = 1.75e-3
PAIRS = {"rv80e": (10, 38), "unshifted": (20, 40), "shifted": (17, 60)}


def _gears(name: str) -> tuple[InvoluteGear, InvoluteGear, float]:
    teeth = PAIRS[name]
    distance = MODULE * sum(teeth) / 2.0 * (1.005 if name == "shifted" else 1.0)
    return (*gear_pair(teeth, MODULE, math.radians(20.0), distance, 0.0), distance)


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("which", [0, 1])
def test_critical_section_is_where_the_cut_fillet_leans_30_degrees(name: str, which: int) -> None:
    *pair, distance = _gears(name)
    gear, mate = pair[which], pair[1 - which]
    root = tooth_root(gear, mate, distance)
    axis = np.array([math.sin(math.pi / gear.teeth), math.cos(math.pi / gear.teeth)])

    def lean(corner: float) -> float:
        return math.acos(min(1.0, float(gear.fillet_tangents([corner])[0] @ axis))) - math.radians(30.0)

    corner = brentq(lean, 0.0, gear.last_corner, xtol=1e-15)
    point = gear.fillet([corner])[0]
    assert root.chord * MODULE == pytest.approx(2.0 * abs(point @ [axis[1], -axis[0]]), rel=1e-8)
    assert root.radius * MODULE == pytest.approx(1.0 / gear.fillet_curvature([corner])[0], rel=1e-8)
    # the line of action is a tangent of the base circle, which meets the axis of the tooth
    assert root.arm * MODULE == pytest.approx(gear.base_radius / math.cos(root.force_angle) - point @ axis, rel=1e-8)


def test_contact_ratio_of_unshifted_gears_is_that_of_the_textbook() -> None:
    """Tips of one module above the pitch circles: 1.635 for 20 and 40 teeth at 20 deg."""
    gear, mate, distance = _gears("unshifted")
    assert contact_ratio(gear, mate, distance) == pytest.approx(1.635, abs=5e-4)


def test_thinner_teeth_have_a_larger_form_factor() -> None:
    distance = MODULE * 30.0
    thick, thin = (
        tooth_root(*gear_pair((20, 40), MODULE, math.radians(20.0), distance, backlash), distance)
        for backlash in (0.0, 50e-6)
    )
    assert thin.form_factor > thick.form_factor
