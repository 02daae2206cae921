"""Mechanism of an RV reducer: the ideal motion of its bodies closes every contact."""

from typing import Any

import numpy as np
import pytest

from cycloid_mj.base.array import Array
from cycloid_mj.design import PRESETS
from cycloid_mj.geometry.kinematics import gear_centre
from cycloid_mj.parts import moving_masses
from cycloid_mj.reducer import RvReducer
from cycloid_mj.reducer.rv_bodies import rv_motion
from cycloid_mj.statics.rv import crank_misfits

LAYOUTS = [
    pytest.param({}, id="preset"),
    pytest.param({"output": {"member": "ring"}}, id="ring"),
    pytest.param({"cranks": {"count": 2}, "gear": {"discs": 3}}, id="two-cranks-three-discs"),
]


def rv(changes: dict[str, Any]) -> RvReducer:
    return RvReducer(PRESETS["rv80e"].but(**changes))


def turned(vectors: Array, angle: float) -> Array:
    cos, sin = np.cos(angle), np.sin(angle)
    return vectors @ np.array([[cos, sin], [-sin, cos]])


def eccentric_offsets(reducer: RvReducer, sun: float) -> Array:
    """Displacement of each eccentric from its bore at an angle of the sun (D, n, 2) [m]."""
    position, mechanism = rv_motion(reducer, sun, 0.0)[0], reducer.mechanism
    carrier = float(reducer.member.gear_angle(sun))
    offsets = []
    for disc, gear in enumerate(reducer.gears):
        mating = mechanism.mating("crank_bearing", disc)
        centre = np.array([position[f"{gear}_x"], position[f"{gear}_y"]])
        bores = centre + turned(mating.on.position, position[f"{gear}_angle"])
        eccentrics = [
            turned(mechanism.body(crank).position, carrier) + turned(place, carrier + position[f"{crank}_angle"])
            for crank, place in zip(mating.by.bodies, mating.by.position, strict=True)
        ]
        offsets.append(np.array(eccentrics) - bores)
    return np.array(offsets)


@pytest.mark.parametrize("changes", LAYOUTS)
def test_ideal_motion_keeps_eccentrics_in_their_bores_and_discs_in_the_mesh(changes: dict[str, Any]) -> None:
    reducer = rv(changes)
    for sun in (0.0, 7.3, -411.0):
        np.testing.assert_allclose(eccentric_offsets(reducer, sun), 0.0, atol=1e-15)
        position, velocity = rv_motion(reducer, sun, 1.0)
        later, _ = rv_motion(reducer, sun + 1e-6, 1.0)
        for joint, rate in velocity.items():
            assert (later[joint] - position[joint]) / 1e-6 == pytest.approx(rate, abs=1e-7)
        ring, mesh = float(reducer.member.ring_angle(sun)), float(reducer.member.against_ring(sun))
        for gear, phase in zip(reducer.gears, reducer.phases, strict=True):
            centre = turned(np.array([position[f"{gear}_x"], position[f"{gear}_y"]]), -ring)
            np.testing.assert_allclose(centre, gear_centre(reducer.tooth_profile, mesh + phase), atol=1e-15)
            assert position[f"{gear}_angle"] - ring == pytest.approx(-mesh / reducer.design.lobes, abs=1e-12)


@pytest.mark.parametrize("changes", LAYOUTS)
def test_planets_roll_on_the_sun(changes: dict[str, Any]) -> None:
    reducer = rv(changes)
    _, velocity = rv_motion(reducer, 0.0, 1.0)
    carrier, mesh = float(reducer.member.gear_angle(1.0)), reducer.planet_mesh
    assert mesh.sun_base * (1.0 - carrier) + mesh.planet_base * velocity["crank_1_angle"] == pytest.approx(0.0)
    assert velocity["output"] == pytest.approx(1.0 / reducer.design.ratio)
    assert reducer.orbit_speed == pytest.approx(reducer.design.drive.speed * (velocity["crank_1_angle"] + carrier))


def test_errors_displace_eccentrics_as_in_statics() -> None:
    """All but the offset of the axes, which displaces the ring instead."""
    rng = np.random.default_rng(7)
    names = ("eccentric_radial", "eccentric_tangential", "bore_x", "bore_y")
    errors = {name: tuple(rng.normal(0.0, 1e-5, 6).tolist()) for name in names}
    errors |= {name: tuple(rng.normal(0.0, 1e-5, 3).tolist()) for name in ("carrier_x", "carrier_y")}
    reducer = rv({"crank_errors": errors})
    for sun in (0.0, 50.0):
        crank = np.array([float(reducer.member.against_ring(sun))])
        np.testing.assert_allclose(eccentric_offsets(reducer, sun), crank_misfits(reducer, crank)[0], atol=1e-15)


def test_an_offset_of_the_axes_displaces_the_ring() -> None:
    sockets = rv({"crank_errors": {"axis_x": 1e-5}}).mechanism.mating("pin_socket").by
    np.testing.assert_allclose(
        sockets.position - rv({}).mechanism.mating("pin_socket").by.position, [[-1e-5, 0.0]] * 40
    )


def test_masses_of_bodies_are_those_of_the_assembly() -> None:
    masses, reducer = moving_masses(rv({})), rv({})
    assert set(masses) == {"housing", "sun", "gear_1", "gear_2", "crank", "output", "pin"}
    np.testing.assert_allclose(masses["crank"].centroid[:2], 0.0, atol=1e-9)  # two opposed eccentrics balance
    single = moving_masses(rv({"gear": {"discs": 1}}))["crank"]
    assert single.centroid[1] > 1e-5
    pitch_radius = reducer.planet.module * reducer.planet.planet_teeth / 2.0
    assert 0.1 < masses["crank"].inertia[2, 2] / (masses["crank"].mass * pitch_radius**2) < 0.5


def test_working_forces_balance_the_load() -> None:
    """The sun's torque is shared by its planets; friction and stiffness are those of the balance of springs."""
    reducer = rv({})
    contact = reducer.contacts["planet_mesh"]
    assert contact.force * 3 * reducer.planet_mesh.sun_base * 153 == pytest.approx(784.0)
    assert reducer.contacts["crank_bearing"].stiffness == 1e8
    assert 696.0 < reducer.contacts["crank_bearing"].force < 4083.0  # between the least and the 10/3-mean of a turn
    assert reducer.design.friction_of("crank_bearing") == 2 * reducer.design.friction.cam_rolling
