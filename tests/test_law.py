"""The mapping of stiffness, damping and added mass to MuJoCo, on two bodies and one contact."""

import math

import mujoco
import numpy as np
import pytest

from cycloid_mj.contact.collider import Role, installed
from cycloid_mj.contact.law import ContactLaw, contact_law, solver_parameters
from cycloid_mj.errors import ContactError

STIFFNESS, MASS = 2.6e8, 0.05


def two_bodies(law: ContactLaw, timestep: float, mass: float = MASS, gravity: float = 0.0):
    """A disc on a slide inside a fixed circle; the gap is minus its height above y = 0."""
    parameters = solver_parameters(law, 1.0 / mass)
    solref = " ".join(map(repr, parameters.solref))
    solimp = " ".join(map(repr, parameters.solimp))
    return mujoco.MjModel.from_xml_string(f"""<mujoco>
      <option timestep="{timestep!r}" gravity="0 {gravity!r} 0" tolerance="1e-14" cone="elliptic"/>
      <worldbody>
        <geom name="outer" type="cylinder" size="0.0151 0.01" priority="{int(Role.OUTER)}"/>
        <body pos="0 0.0001 0"><joint name="y" type="slide" axis="0 1 0"/>
          <inertial pos="0 0 0" mass="{mass!r}" diaginertia="1 1 1"/>
          <geom name="inner" type="cylinder" size="0.015 0.01" priority="{int(Role.INNER)}"/></body>
      </worldbody>
      <contact><pair geom1="outer" geom2="inner" condim="1" solref="{solref}" solimp="{solimp}"/></contact>
    </mujoco>""")


@pytest.mark.parametrize("added", [1e-3, 1e-2, 1.0])
def test_a_static_force_goes_in_by_force_over_stiffness(added: float) -> None:
    law = ContactLaw(STIFFNESS, 2.0 * 0.7 * math.sqrt(STIFFNESS * MASS), added * MASS, 0.0)
    force = 400.0
    model = two_bodies(law, 1e-6, gravity=force / MASS)
    data = mujoco.MjData(model)
    with installed():
        mujoco.mj_step(model, data, 4000)
    assert data.qpos[0] == pytest.approx(force / STIFFNESS, rel=1e-3)
    assert data.efc_force[0] == pytest.approx(force, rel=1e-3)


def frequency(law: ContactLaw, timestep: float) -> float:
    """Angular frequency about the loaded equilibrium, from the zero crossings of the velocity."""
    force = 400.0
    model = two_bodies(law, timestep, gravity=force / MASS)
    data = mujoco.MjData(model)
    data.qpos[0] = 0.5 * force / STIFFNESS
    speeds = []
    with installed():
        for _ in range(round(40 * 2.0 * math.pi / math.sqrt(STIFFNESS / MASS) / timestep)):
            mujoco.mj_step(model, data)
            speeds.append(data.qvel[0])
    v = np.array(speeds)
    k = np.flatnonzero((v[:-1] < 0.0) & (v[1:] >= 0.0))
    crossings = k + v[k] / (v[k] - v[k + 1])
    return 2.0 * math.pi / (float(np.mean(np.diff(crossings))) * timestep)


@pytest.mark.parametrize("share", [0.01, 0.3, 1.0])
def test_the_added_mass_swings_along(share: float) -> None:
    law = ContactLaw(STIFFNESS, 0.0, share * MASS, 0.0)
    assert frequency(law, 1e-6) == pytest.approx(math.sqrt(STIFFNESS / (MASS + share * MASS)), rel=2e-3)


def test_where_the_step_allows_the_frequency_is_physical() -> None:
    law = contact_law(STIFFNESS, 1e-6, MASS, 0.0, 0.0, timestep=2e-6)
    assert frequency(law, 2e-6) == pytest.approx(math.sqrt(STIFFNESS / MASS), rel=0.01)


@pytest.mark.parametrize("ratio", [0.05, 0.2, 0.5])
def test_an_impact_returns_as_the_damping_ratio_says(ratio: float) -> None:
    """The force may not pull: the impact ends when it reaches zero, which shortens the damped half wave."""
    law = contact_law(STIFFNESS, ratio, MASS, 0.0, 0.0, timestep=2e-7)
    model = two_bodies(law, 2e-7)
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = -1e-9, 0.01
    with installed():
        while data.qpos[0] >= -1e-9:
            mujoco.mj_step(model, data)
    damped = math.sqrt(1.0 - ratio**2)
    # Force -(K r + C v) of a linear half wave vanishes at this phase (Nagurka and Huang 2004).
    expected = math.exp(-ratio / damped * math.atan2(2.0 * ratio * damped, 2.0 * ratio**2 - 1.0))
    assert -data.qvel[0] / 0.01 == pytest.approx(expected, rel=0.02)


def test_stability_sets_the_added_mass() -> None:
    pin = 1.25e-3
    for timestep in (1e-6, 2e-6, 5e-6, 1e-5, 2e-5):
        law = contact_law(STIFFNESS, 0.5, pin, 0.05, 1e3, timestep)
        assert STIFFNESS * timestep**2 <= (pin + law.added_mass) * (1.0 + 1e-12)
        assert law.damping * timestep <= (pin + law.added_mass) * (1.0 + 1e-12)
    assert contact_law(STIFFNESS, 0.5, 10.0, 0.05, 1e3, 1e-6).added_mass == pytest.approx(0.1)


def test_an_impossible_impedance_is_refused() -> None:
    with pytest.raises(ContactError, match="timestep_us"):
        solver_parameters(ContactLaw(1e14, 0.0, 1e9, 0.0), 1.0)


def test_frictionless_contacts_have_one_dimension() -> None:
    assert solver_parameters(ContactLaw(1e8, 0.0, 0.1, 0.0), 1.0).condim == 1
    assert solver_parameters(ContactLaw(1e8, 0.0, 0.1, 0.05), 1.0).condim == 3
