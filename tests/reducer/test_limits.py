"""How far rigid parts can move: stops against closed forms, the pose with the most room against exact curves.

All of it runs in a second without compiling, so that `scripts/flip_signs.py` can try every sign.
"""

import numpy as np
import pytest
from designs import unlike

from cycloid_mj.base.array import Array
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.deviations import deviations
from cycloid_mj.geometry.kinematics import gear_centre
from cycloid_mj.geometry.modification import tooth_profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.limits import Fit, best_fit, stops
from cycloid_mj.validate.displaced import cam_offsets, exact_gaps, in_ring_frame

CRANK = 1.9
TIGHT = 1e-12
"""A clearance that leaves a part where it is [m]."""

ERRORS = (
    *("errors.seed=4", "errors.pin_position_um=1.0", "errors.pin_radius_um=0.5", "errors.disc_size_um=0.7"),
    *("errors.hole_position_um=1.0", "errors.cam_position_um=0.8", "errors.eccentricity_um=1.5"),
)


def with_clearances(design: Design, rest: float, **clearances: float) -> Design:
    """Return a design whose mating pairs all have one clearance [m], but for some."""
    return design.but(clearance=dict.fromkeys(design.pair_kinds, rest) | clearances)


@pytest.mark.parametrize("crank", [0.3, CRANK])
def test_the_output_stops_where_the_pin_with_the_longest_arm_touches(crank: float) -> None:
    """The disc stands still, and every output pin is at its hole's wall towards the axis, along the eccentric.

    Of seven pins the longest arm one way is not that the other way: the output turns farther to one side.
    """
    play = 2e-6
    design = with_clearances(override(PRESETS["pin"], ["ring.pins=fixed", "output.pins=7"]), TIGHT, output=play)
    out = gear_centre(tooth_profile(design), crank) / design.gear.eccentricity
    clockwise = 2.0 * np.pi * np.arange(7) / 7 + crank / design.lobes
    pins = design.output.pin_circle_radius * profile.unit(clockwise)
    arm = pins[:, 0] * out[1] - pins[:, 1] * out[0]
    low, high = stops(Reducer(design), crank)
    assert (low, high) == pytest.approx((-play / arm.max(), -play / arm.min()), rel=1e-4)
    assert abs(low + high) > 0.01 * high


@pytest.mark.parametrize("design", [PRESETS["pin"], unlike("few"), unlike("large")], ids=["pin", "few", "large"])
def test_free_pin_equals_fixed_pin_with_summed_clearances_for_rigid_parts(design: Design) -> None:
    made = override(design, [one for one in ERRORS if "radius" not in one])
    moving = with_clearances(made, 2e-6, **{design.seat_pair: 3e-6})
    fixed = with_clearances(override(made, ["ring.pins=fixed"]), 2e-6, pin_gear=5e-6)
    assert stops(Reducer(moving), CRANK) == pytest.approx(stops(Reducer(fixed), CRANK), rel=1e-9)


def gaps_of_fit(design: Design, crank: float, fit: Fit, pins: Array | float = 0.0) -> tuple[Array, Array]:
    """Compute the gaps of teeth and output pins, and those of cams [m], of parts that stand as a fit tells."""
    seen, z = in_ring_frame(Reducer(design), crank, fit.shift, fit.gear_turn, fit.output_turn)
    cams = design.clearance.cam - np.linalg.norm(cam_offsets(Reducer(design), seen, z), axis=1)
    return exact_gaps(Reducer(design), seen, z, pins), cams


@pytest.mark.parametrize("member", ["carrier", "ring"])
@pytest.mark.parametrize("discs", [1, 3])
def test_smallest_gap_of_the_best_fit_is_its_play(discs: int, member: str) -> None:
    design = override(PRESETS["pin"], [*ERRORS, "ring.pins=fixed", f"gear.discs={discs}", f"output.member={member}"])
    design = with_clearances(design, 4e-6)
    fit = best_fit(Reducer(design), CRANK)
    assert abs(fit.output_turn) > 8e-6, "the output is not where it would be anyhow"
    # The polygon around a cam's play has sixteen sides: it is larger than the circle by up to 2 %.
    assert np.concatenate(gaps_of_fit(design, CRANK, fit)).min() == pytest.approx(
        fit.min_gap, abs=0.02 * design.clearance.cam
    )


def test_a_displaced_pin_is_in_the_middle_of_its_space() -> None:
    """As far from the nearer disc as from the wall of its socket."""
    design = override(unlike("few"), [*ERRORS, "gear.discs=2"])
    design = with_clearances(design, 0.5e-6, pin_socket=4e-6)
    fit = best_fit(Reducer(design), CRANK)
    moved, pins = np.any(fit.pin_shift, axis=1), design.ring.teeth
    assert moved.any()
    ahead = gaps_of_fit(design, CRANK, fit, fit.pin_shift)[0][: 2 * pins].reshape(2, pins).min(axis=0)
    behind = design.pin_play - deviations(design).pin_radius - np.linalg.norm(fit.pin_shift, axis=1)
    assert ahead[moved] == pytest.approx(behind[moved], abs=6e-8)


@pytest.mark.parametrize("crank", [0.0, np.pi])
def test_a_pin_in_the_way_of_two_discs_moves_no_farther_than_for_one(crank: float) -> None:
    """The topmost pin stands 3 um too deep, on a tip of one disc and in a valley of the other: both push it up."""
    one = with_clearances(override(PRESETS["pin"], ["errors.pin_y_um={1=-3.0}"]), 1e-6, cam=TIGHT, output=TIGHT)
    alone, both = (best_fit(Reducer(design), crank).pin_shift[0] for design in (one, override(one, ["gear.discs=2"])))
    assert alone[1] > 1e-6
    assert both == pytest.approx(alone, abs=1e-12)
