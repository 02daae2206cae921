"""The model: balance, masses, names, contact physics stated in the MJCF, exact XML."""

import mujoco
import numpy as np
import pytest

from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.contact import each_step
from cycloid_mj.dynamics.contact.collider import install
from cycloid_mj.dynamics.contact.library import exact_xml
from cycloid_mj.dynamics.drive_cycle import initial_state
from cycloid_mj.dynamics.mjcf import build, sensors, xml
from cycloid_mj.dynamics.run import log_columns
from cycloid_mj.parts import mass_properties, parts
from cycloid_mj.reducer import Reducer


@pytest.fixture(scope="module")
def design() -> Design:
    return PRESETS["pin"]


@pytest.fixture(scope="module")
def compiled(design):
    return build(design)


def test_degrees_of_freedom(compiled, design) -> None:
    assert compiled.model.nv == 1 + 3 + 1 + 3 * design.ring.teeth


def test_the_counterweight_balances_the_gear(compiled, design) -> None:
    """Static moment of all that turns with the crank, the gear at its centre, read from the compiled model."""
    model = compiled.model
    shaft, gear = model.body("shaft"), model.body("gear")
    moment = shaft.mass[0] * shaft.ipos[:2] + gear.mass[0] * np.array([0.0, design.gear.eccentricity])
    assert np.abs(moment).max() < 1e-9 * gear.mass[0] * design.gear.eccentricity
    unbalanced = shaft.mass[0] * shaft.ipos[:2]
    assert np.abs(unbalanced).max() == pytest.approx(gear.mass[0] * design.gear.eccentricity, rel=1e-6)


def test_masses_are_the_solids(compiled, design) -> None:
    solids = {name: mass_properties(solid) for name, solid in parts(Reducer(design)).items()}
    for body, part in (("gear", "gear"), ("shaft", "shaft"), ("output", "output"), ("pin_7", "pin")):
        made = compiled.model.body(body)
        assert made.mass[0] == pytest.approx(solids[part].mass, rel=1e-14)
        assert sorted(made.inertia) == pytest.approx(np.linalg.eigvalsh(solids[part].inertia), rel=1e-9)


def test_sensors_are_named_as_the_columns(compiled, design) -> None:
    *named, kept = [compiled.model.sensor(i).name for i in range(compiled.model.nsensor)]
    assert kept == each_step.SENSOR
    assert named == [name for group in sensors(Reducer(design)).values() for name in group]
    logged = [name for group in log_columns(compiled, Reducer(design)).values() for name in group]
    assert set(named) < set(logged)
    assert len(set(logged)) == len(logged)


def test_pairs_state_the_physics(compiled) -> None:
    """K, C and 1/R come back out of each compiled pair."""
    model = compiled.model
    for pair in compiled.pairs:
        law, number = compiled.laws[pair.kind], model.pair(pair.name).id
        bodies = [model.geom(name).bodyid[0] for name in (pair.on, pair.by)]
        weight = sum(model.body_invweight0[body, 0] for body in bodies)
        impedance = model.pair_solimp[number, 0]
        regularisation = (1.0 - impedance) / impedance * weight
        stiffness, damping = -model.pair_solref[number] / impedance / regularisation
        assert (stiffness, damping) == pytest.approx((law.stiffness, law.damping), rel=1e-9)
        assert 1.0 / regularisation == pytest.approx(law.added_mass, rel=1e-9)
        assert model.pair_dim[number] == (3 if law.friction else 1)
        if law.friction:
            creep = -model.pair_solreffriction[number, 1] / impedance / regularisation * model.opt.impratio
            assert creep == pytest.approx(law.creep, rel=1e-9)


def test_the_xml_is_the_model(compiled, design) -> None:
    """Compiled from its XML, the model moves bit for bit alike; six digits would not do."""
    text = xml(compiled.spec)
    again = mujoco.MjModel.from_xml_string(text)
    for name in (
        "body_pos",
        "geom_size",
        "geom_user",
        "pair_solref",
        "pair_solreffriction",
        "pair_solimp",
        "body_mass",
        "qpos0",
    ):
        np.testing.assert_array_equal(getattr(again, name), getattr(compiled.model, name), err_msg=name)
    states = []
    for model in (compiled.model, again):
        data = initial_state(compiled, Reducer(design)) if model is compiled.model else mujoco.MjData(again)
        with install():
            mujoco.mj_step(model, data, 50)
        states.append(data.qpos.copy())
    np.testing.assert_array_equal(*states)
    coarse = mujoco.MjModel.from_xml_string(compiled.spec.to_xml())
    assert np.any(coarse.body_pos != compiled.model.body_pos)


def test_exact_xml_is_undone() -> None:
    spec = mujoco.MjSpec()
    spec.option.timestep = 1.0 / 3.0
    spec.compile()
    with exact_xml():
        assert "0.33333333333333331" in spec.to_xml()
    assert "0.333333" in spec.to_xml()
    assert "0.3333333" not in spec.to_xml()


def test_contact_geoms_reach_each_other_at_every_crank_angle(compiled, design) -> None:
    """The broad phase drops pairs whose bounding boxes are apart; a wide margin shows every pair as a contact."""
    model = build(design).model
    model.pair_margin[:] = 1e-5
    for crank in np.linspace(0.0, 2.0 * np.pi * design.lobes, 60):
        data = mujoco.MjData(model)
        c = design.gear.eccentricity
        data.joint("crank").qpos[0] = crank
        data.joint("gear_x").qpos[0] = -c * np.sin(crank)
        data.joint("gear_y").qpos[0] = c * np.cos(crank)
        data.joint("gear_angle").qpos[0] = -crank / design.lobes
        data.joint("output").qpos[0] = -crank / design.lobes
        with install():
            mujoco.mj_forward(model, data)
        assert data.ncon == len(compiled.pairs), crank


def test_fixed_pins_are_part_of_the_housing() -> None:
    design = override(PRESETS["pin"], ['ring.pins="fixed"'])
    compiled = build(design)
    assert compiled.model.nv == 5
    assert {pair.kind for pair in compiled.pairs} == {"pin_gear", "cam", "output"}
