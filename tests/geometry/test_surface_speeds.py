"""Surface speeds at teeth, seats and output pins, against following the material points of both surfaces."""

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from cycloid_mj.design import resolve
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.geometry.surface_speeds import (
    entrainment_zeros,
    hole_speeds,
    involute_speeds,
    tooth_speeds,
)
from cycloid_mj.reducer import Reducer, reducer_of

Array = npt.NDArray[np.float64]
DESIGNS = Path(__file__).parents[1] / "data" / "designs"
DRIVES = (
    "pin",
    "printed",
    "twodisc",
    str(DESIGNS / "sleeved-n40-d2-ring-25um.toml"),
    str(DESIGNS / "nonpin-n33-d2-ring-60um.toml"),
)
RV_80E = CycloidGear(40, 0.0015, 0.0775, 0.004)
STEP = 1e-5


def followed_speeds(gear: CycloidGear, zeta: Array, crank_speed: float) -> tuple[Array, Array]:
    """Follow the contact point on the pin and on the disc by central differences; crank angle 0, so B = zeta."""
    ahead, behind = (profile.conjugate_point(gear, zeta, -step) for step in (STEP, -STEP))
    rate = crank_speed / (2.0 * STEP)
    normal = profile.unit(zeta - profile.conjugate_alpha(gear, zeta))
    along = np.stack([-normal[..., 1], normal[..., 0]], axis=-1)
    on_pin = -np.sum((ahead.ring_frame - behind.ring_frame) * along, axis=-1) * rate
    # in the disc's frame, which coincides with the ring's at crank angle 0 but for its translation
    on_disc = -np.sum((ahead.gear_frame - behind.gear_frame) * along, axis=-1) * rate
    return on_disc, on_pin


@pytest.mark.parametrize("name", [*DRIVES, "rv80e"])
def test_speeds_match_followed_material_points(name: str) -> None:
    reducer = reducer_of(resolve(name))
    gear, speed = reducer.tooth_profile, float(reducer.member.against_ring(reducer.design.drive.speed))
    B = profile.pin_angles(gear) + 1e-3
    on_disc, on_pin = followed_speeds(gear, B, speed)
    fixed = tooth_speeds(gear, B, speed)
    # both follow one direction along the surface, which may be the opposite one
    sign = np.sign(np.sum(on_disc * fixed.moving))
    assert fixed.moving == pytest.approx(sign * on_disc, abs=1e-4)
    assert fixed.fixed == pytest.approx(sign * on_pin, abs=1e-4)
    assert fixed.entrainment == pytest.approx(sign * 0.5 * (on_disc + on_pin), abs=1e-4)
    assert fixed.sliding == pytest.approx(sign * (on_disc - on_pin), abs=1e-4)


@pytest.mark.parametrize("name", DRIVES)
def test_speeds_at_an_output_pin_match_followed_material_points(name: str) -> None:
    reducer = Reducer(resolve(name))
    gear, output = reducer.tooth_profile, reducer.design.output
    speed = float(reducer.member.against_ring(reducer.design.drive.speed))
    passing = []
    for step in (-STEP, STEP):
        # the line of centres of hole and pin is the eccentricity, which turns against the disc and the output
        angle = step * gear.ring_teeth / gear.lobes
        towards = np.array([-math.sin(angle), math.cos(angle)])
        passing.append([towards * output.pin_radius, towards * output.hole_radius])
    on_pin, on_hole = (np.linalg.norm(passing[1][k] - passing[0][k]) * abs(speed) / (2.0 * STEP) for k in (0, 1))
    speeds = hole_speeds(gear, output.pin_radius, output.hole_radius, speed)
    assert abs(speeds.entrainment) == pytest.approx(0.5 * (on_pin + on_hole), abs=1e-4)
    assert abs(speeds.sliding) == pytest.approx(abs(on_hole - on_pin), abs=1e-4)


@pytest.mark.parametrize("distance", [-1.5e-3, 0.0, 4e-3])
def test_speeds_of_involute_gears_match_followed_material_points(distance: float) -> None:
    """Sun and planet of the RV-80E at 600 rpm, with the sun's axis in the origin and the planet's on +y."""
    radii, angle, planet_speed = np.array([8.75e-3, 33.25e-3]), math.radians(20.0), 20.0 * math.pi
    speeds = np.array([planet_speed * radii[1] / radii[0], planet_speed])
    along = np.array([-math.cos(angle), math.sin(angle)])  # the line of action, from the sun's base circle
    tangent = np.array([along[1], -along[0]])
    centres, turning = np.array([[0.0, 0.0], [0.0, radii.sum()]]), speeds * [1.0, -1.0]

    def in_gears(time: float) -> Array:
        """Return the contact point in the frame of each gear, which coincides with that at rest at the time 0."""
        path = distance + radii[0] * math.cos(angle) * speeds[0] * time
        contact = np.array([0.0, radii[0]]) + path * along - centres
        cos, sin = np.cos(turning * time), np.sin(turning * time)
        return np.stack([cos * contact[:, 0] + sin * contact[:, 1], cos * contact[:, 1] - sin * contact[:, 0]], axis=1)

    on_sun, on_planet = (
        (in_gears(STEP / planet_speed) - in_gears(-STEP / planet_speed)) @ tangent * (planet_speed / (2.0 * STEP))
    )
    found = involute_speeds(tuple(radii * math.sin(angle)), distance, tuple(speeds))
    sign = np.sign(on_sun * found.fixed)
    assert float(found.fixed) == pytest.approx(sign * on_sun, abs=1e-4)
    assert float(found.moving) == pytest.approx(sign * on_planet, abs=1e-4)


def test_sliding_equals_that_of_the_gaps() -> None:
    from cycloid_mj.statics.springs import springs_of

    reducer = Reducer(resolve("pin"))
    springs = springs_of(reducer, [0.3])
    speeds = tooth_speeds(reducer.tooth_profile, profile.pin_angles(reducer.tooth_profile) + 0.3, 1640 * math.pi / 30)
    assert np.abs(springs.slip[0, : springs.teeth]) == pytest.approx(np.abs(speeds.sliding), rel=1e-9)


def test_entrainment_vanishes_at_the_published_angles() -> None:
    assert np.degrees(entrainment_zeros(Reducer(resolve("pin")).tooth_profile)) == pytest.approx(
        [32.69, 164.31], abs=0.01
    )
    assert np.degrees(entrainment_zeros(RV_80E))[0] == pytest.approx(51.56, abs=0.01)
    assert entrainment_zeros(CycloidGear(14, 0.0015, 0.034, 0.0035)).size == 0


def test_entrainment_changes_sign_at_its_zeros() -> None:
    gear = Reducer(resolve("pin")).tooth_profile
    for zero in entrainment_zeros(gear):
        below, above = tooth_speeds(gear, np.array([zero - 1e-3, zero + 1e-3]), 100.0).entrainment
        assert below * above < 0.0


def test_a_seat_scales_the_speeds_by_its_radius() -> None:
    gear, B = Reducer(resolve("pin")).tooth_profile, np.linspace(0.1, 3.0, 7)
    flank = tooth_speeds(gear, B, 100.0)
    seat = flank.scaled(0.5)
    assert seat.sliding == pytest.approx(0.5 * flank.sliding)
    assert seat.entrainment == pytest.approx(0.5 * flank.entrainment)
