"""Pins that two discs press tilt: their inertia and their contacts in the planes of both discs."""

import mujoco
import numpy as np
import pytest

from cycloid_mj.base import names
from cycloid_mj.base.powers import mean_powers
from cycloid_mj.base.record import Run
from cycloid_mj.design import PRESETS
from cycloid_mj.dynamics.contact import collider
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.planar.model import planar_model
from cycloid_mj.dynamics.planar.state import start_state
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.parts import moving_masses, pin_mass_matrix
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.balance import powers

COULOMB = {"friction": {"law": "coulomb"}}


def two_discs(pins: str = "free") -> Reducer:
    return Reducer(PRESETS["twodisc"].but(ring={"pins": pins}, **COULOMB))


def test_mass_matrix_is_that_of_a_cylinder() -> None:
    """A slender rod with planes at a quarter of its length from its middle has the elements 7/12 m and -m/12."""
    reducer = two_discs().but(gear={"face_width": 30e-3, "disc_gap": 1e-6})
    mass, radius = moving_masses(reducer)[names.PIN].mass, reducer.design.ring.pin_radius
    thickness = 0.25 * mass * (radius / 30e-3) ** 2
    diagonal, coupling = 7.0 / 12.0 * mass + thickness, -mass / 12.0 - thickness
    expected = np.array([[diagonal, coupling], [coupling, diagonal]])
    assert pin_mass_matrix(reducer) == pytest.approx(expected, rel=2e-3)
    one = Reducer(PRESETS["pin"])
    assert pin_mass_matrix(one).tolist() == [[moving_masses(one)[names.PIN].mass]]


@pytest.mark.parametrize("pins", ["free", "sleeved"])
def test_mujoco_has_the_mass_matrix_of_the_planar_solver(pins: str) -> None:
    reducer = two_discs(pins)
    model = build(reducer.design).model
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mass, distance, pin = pin_mass_matrix(reducer), reducer.design.gear.disc_spacing, names.pin(1)
    for low, high in ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0)):  # speeds along x in the planes of both discs
        data.joint(names.planar_joints(pin)[0]).qvel[0] = 0.5 * (low + high)
        data.joint(names.tilt_joints(pin)[1]).qvel[0] = (high - low) / distance
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_energyVel(model, data)
        assert data.energy[1] == pytest.approx(0.5 * np.array([low, high]) @ mass @ np.array([low, high]), rel=1e-6)


@pytest.mark.parametrize("pins", ["free", "sleeved"])
def test_contacts_of_a_tilted_pin_are_those_of_its_points_in_the_planes(pins: str) -> None:
    """A pin that is displaced in the plane of one disc is pressed into its seat there only."""
    reducer = two_discs(pins)
    model = build(reducer.design).model
    data = mujoco.MjData(model)
    half = 0.5 * reducer.design.gear.disc_spacing
    shift, pin = 5e-6, names.pin(1)
    seat = reducer.mechanism.mating(reducer.design.seat_pair)
    pair = {model.geom(seat.on.names[0]).id, model.geom(seat.by.names[0]).id}
    data.joint(names.planar_joints(pin)[1]).qpos[0] = 0.5 * shift
    data.joint(names.tilt_joints(pin)[0]).qpos[0] = -0.5 * shift / half  # y rises in the plane of disc 2
    with collider.install(lobes=False):
        mujoco.mj_forward(model, data)
    contacts = [contact for contact in data.contact if {int(geom) for geom in contact.geom} == pair]
    assert [contact.pos[2] for contact in contacts if contact.dist < 0.0] == pytest.approx([half])
    clearance = getattr(reducer.design.clearance, reducer.design.seat_pair)
    assert min(contact.dist for contact in contacts) == pytest.approx(clearance - shift, abs=1e-9)


def short_run(reducer: Reducer, solver: str) -> Run:
    short = reducer.steady(0.02, 0.2, settings={"log_rate": 5000.0})
    model = planar_model(short) if solver == "planar" else build(short.design)
    run = simulate(short.design, model)
    return run.select(run.time > 0.02)


def test_planar_energy_has_the_mass_of_tilting_pins() -> None:
    reducer = two_discs().but(output={"member": "ring"})
    system = planar_model(reducer).system
    _, speeds = start_state(reducer, 0.3, 100.0)
    width, first = 5, len(system.inertia)
    kinetic = sum(
        0.5 * speeds[first + shift :: width] @ speeds[first + other :: width] * system.pin_mass[plane, opposite]
        for plane, row in enumerate(((0, 1), (3, 4)))
        for opposite, column in enumerate(((0, 1), (3, 4)))
        for shift, other in zip(row, column, strict=True)
    )
    pin, ring = moving_masses(reducer)[names.PIN].mass, reducer.design.ring
    speed = ring.pin_circle_radius * float(reducer.member.output_angle(100.0))
    assert kinetic == pytest.approx(0.5 * ring.teeth * pin * speed**2, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("solver", ["planar", "mujoco"])
@pytest.mark.parametrize("pins", ["free", "sleeved"])
def test_efficiency_of_cold_drives_is_that_of_statics(pins: str, solver: str) -> None:
    reducer = two_discs(pins)
    torque = reducer.design.load.torque or reducer.design.rated_torque
    loaded = reducer.but(load={"torque": torque})
    efficiency = mean_powers(short_run(loaded, solver)).efficiency
    assert 100.0 * efficiency == pytest.approx(100.0 * powers(loaded, torque).efficiency, abs=0.2)
