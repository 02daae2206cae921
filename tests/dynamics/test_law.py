"""The mapping of stiffness, damping and added mass to MuJoCo, on two bodies and one contact."""

import math

import mujoco
import numpy as np
import pytest

from cycloid_mj.base.errors import ContactError
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics import timestep as steps
from cycloid_mj.dynamics.contact.collider import install
from cycloid_mj.dynamics.law import (
    FRICTION,
    ContactParameters,
    contact_law,
    friction_leads,
    settling_law,
    solver_parameters,
    stock_impratio,
)
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.mjcf.laws import contact_laws
from cycloid_mj.geometry import ideal_loads
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.reducer.bodies import Role
from cycloid_mj.reducer.contact import STRIBECK

STIFFNESS, MASS = 2.6e8, 0.05


def two_bodies(law: ContactParameters, timestep: float, mass: float = MASS, gravity: float = 0.0):
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
def test_static_penetration_is_force_over_stiffness(added: float) -> None:
    law = ContactParameters(STIFFNESS, 2.0 * 0.7 * math.sqrt(STIFFNESS * MASS), added * MASS, 0.0)
    force = 400.0
    model = two_bodies(law, 1e-6, gravity=force / MASS)
    data = mujoco.MjData(model)
    with install():
        mujoco.mj_step(model, data, 4000)
    assert data.qpos[0] == pytest.approx(force / STIFFNESS, rel=1e-9)
    assert data.efc_force[0] == pytest.approx(force, rel=1e-9)


def frequency(law: ContactParameters, timestep: float) -> float:
    """Angular frequency about the loaded equilibrium, from the zero crossings of the velocity."""
    force = 400.0
    model = two_bodies(law, timestep, gravity=force / MASS)
    data = mujoco.MjData(model)
    data.qpos[0] = 0.5 * force / STIFFNESS
    speeds = []
    with install():
        for _ in range(round(40 * 2.0 * math.pi / math.sqrt(STIFFNESS / MASS) / timestep)):
            mujoco.mj_step(model, data)
            speeds.append(data.qvel[0])
    v = np.array(speeds)
    k = np.flatnonzero((v[:-1] < 0.0) & (v[1:] >= 0.0))
    crossings = k + v[k] / (v[k] - v[k + 1])
    return 2.0 * math.pi / (float(np.mean(np.diff(crossings))) * timestep)


@pytest.mark.parametrize("share", [0.01, 0.3, 1.0])
def test_added_mass_lowers_the_frequency(share: float) -> None:
    law = ContactParameters(STIFFNESS, 0.0, share * MASS, 0.0)
    assert frequency(law, 1e-6) == pytest.approx(math.sqrt(STIFFNESS / (MASS + share * MASS)), rel=7e-4)


def test_contact_frequency_is_physical_if_the_step_resolves_it() -> None:
    """The law of Fox and Goodwin is of fourth order: at K dt^2/m = 0.5 the frequency is right to a thousandth."""
    timestep = math.sqrt(0.5 * MASS / STIFFNESS)
    law = contact_law(STIFFNESS, 1e-9, MASS, 0.0, 0.0, timestep)
    assert frequency(law, timestep) == pytest.approx(math.sqrt(STIFFNESS / MASS), rel=1e-3)
    without = ContactParameters(STIFFNESS, 0.0, 0.01 * MASS, 0.0)
    assert frequency(without, timestep) != pytest.approx(math.sqrt(STIFFNESS / MASS), rel=1e-2)


@pytest.mark.parametrize("ratio", [0.05, 0.2, 0.5])
def test_restitution_follows_from_the_damping_ratio(ratio: float) -> None:
    """The force may not pull: the impact ends when it reaches zero, which shortens the damped half wave."""
    law = contact_law(STIFFNESS, ratio, MASS, 0.0, 0.0, timestep=2e-7)
    model = two_bodies(law, 2e-7)
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = -1e-9, 0.01
    with install():
        while data.qpos[0] >= -1e-9:
            mujoco.mj_step(model, data)
    damped = math.sqrt(1.0 - ratio**2)
    # Force -(K r + C v) of a linear half wave vanishes at this phase (Nagurka and Huang 2004).
    expected = math.exp(-ratio / damped * math.atan2(2.0 * ratio * damped, 2.0 * ratio**2 - 1.0))
    assert -data.qvel[0] / 0.01 == pytest.approx(expected, rel=0.005)  # 0.18 % at the strongest damping


@pytest.mark.parametrize("ratio", [0.0, 0.5, 2.0])
def test_the_added_mass_keeps_a_body_on_a_contact_stable_at_any_step(ratio: float) -> None:
    """Its step has no eigenvalue outside the unit circle."""
    pin = 1.25e-3
    for timestep in (1e-6, 2e-6, 5e-6, 1e-5, 1e-4):
        law = contact_law(STIFFNESS, ratio, pin, 0.05, 1e3, timestep)
        assert np.abs(swung(law, pin, timestep)).max() <= 1.0 + 1e-9


@pytest.mark.parametrize("ratio", [0.0, 0.5, 2.0])
@pytest.mark.parametrize("longer", [3.0, 10.0])
def test_a_settling_contact_follows_implicit_euler_steps(ratio: float, longer: float) -> None:
    """Their eigenvalues are 1/(1 - s dt) for those s of the contact itself: what is too fast for the step dies away."""
    pin = 1.25e-3
    swing = math.sqrt(STIFFNESS / pin)
    timestep = longer / swing
    law = settling_law(STIFFNESS, ratio, pin, 0.05, 1e3, timestep)
    own = swing * (-ratio + np.array([1.0, -1.0]) * np.emath.sqrt(ratio**2 - 1.0))
    assert np.sort_complex(swung(law, pin, timestep)) == pytest.approx(np.sort_complex(1.0 / (1.0 - own * timestep)))
    assert law.stiffness == STIFFNESS
    followed = contact_law(STIFFNESS, ratio, pin, 0.05, 1e3, timestep)
    assert np.abs(swung(law, pin, timestep)).max() < np.abs(swung(followed, pin, timestep)).max()


def swung(law: ContactParameters, mass: float, timestep: float) -> np.ndarray:
    """Eigenvalues of the step v' = v - dt (K r + C v)/(m + 1/R), r' = r + dt v' of a body on its contact."""
    moved = mass + law.added_mass
    speed = np.array([-timestep * law.stiffness, moved - timestep * law.damping]) / moved
    return np.linalg.eigvals(np.array([[1.0 + timestep * speed[0], timestep * speed[1]], speed]))


def test_only_moving_pins_without_load_settle() -> None:
    """Under a load, for slices, by the law IMPACT and at given steps their contacts are followed, as all others are."""
    pin = PRESETS["pin"]
    step = steps.timestep(Reducer(pin))
    for kind, law in contact_laws(Reducer(pin)).items():
        own = 2.0 * pin.contact.damping_ratio * math.sqrt(law.stiffness * law.effective_mass)
        settling = kind in ("pin_gear", "pin_socket")
        assert law.damping == pytest.approx(own + settling * law.stiffness * step)
    for other in (
        pin.but(load={"torque": 1.0}),
        Reducer(pin).for_slices.design,
        pin.but(contact={"working_load": 1.0}),
        pin.but(contact={"law": "impact"}),
        pin.but(settings={"timestep": step}),
        pin.but(ring={"pins": "fixed"}),
    ):
        reducer = Reducer(other)
        assert not any(steps.may_settle(reducer, kind) for kind in other.pair_kinds)
        assert steps.step_limits(reducer) == steps.step_limits(reducer, must_follow=True)


def test_an_impossible_impedance_is_refused() -> None:
    with pytest.raises(ContactError, match="timestep_us"):
        solver_parameters(ContactParameters(1e14, 0.0, 1e9, 0.0), 1.0)


@pytest.mark.parametrize("name", ["pin", "nonpin", "rv80e"])
@pytest.mark.parametrize("torque", [1.0, 36.68])
def test_friction_leads_its_sliding_by_little(name: str, torque: float) -> None:
    design = PRESETS[name].but(load={"torque": torque})
    reducer = reducer_of(design)
    laws, ratio, step = contact_laws(reducer), build(design).model.opt.impratio, steps.timestep(reducer)
    rubbing = [law for law in laws.values() if law.friction]
    assert all(ratio * law.added_mass >= 0.4999 * law.creep * step for law in rubbing)
    assert all(law.friction**2 / ratio <= 1.0001 * FRICTION.max_coupling for law in rubbing)
    assert 0.0 < max(friction_leads(reducer, laws, ratio).values()) < 0.02


@pytest.mark.parametrize(("name", "first", "most"), [("nonpin", "tooth", 0.15), ("pin", "pin_socket", 0.05)])
def test_stock_friction_leads_its_sliding_no_more_than_allowed(name: str, first: str, most: float) -> None:
    soft = PRESETS[name].but(contact={"creep_speed": 0.02})
    light, rated = (soft.but(load={"torque": torque}) for torque in (1.0, 36.68))
    laws = contact_laws(Reducer(light))
    found = friction_leads(Reducer(light), laws, stock_impratio(Reducer(light), [laws]))
    assert found[first] == pytest.approx(most, rel=1e-9)
    assert max(found.values()) < 0.151
    assert stock_impratio(Reducer(rated), [contact_laws(Reducer(rated))]) == FRICTION.impratio


def test_a_crank_at_rest_has_the_largest_impratio() -> None:
    assert build(PRESETS["pin"].but(drive={"speed": 0.0})).model.opt.impratio == FRICTION.impratio


def test_friction_has_its_creep_at_every_impratio() -> None:
    law = ContactParameters(STIFFNESS, 100.0, 0.1, 0.05, creep=8.0)
    for ratio in (0.2, FRICTION.impratio):
        parameters = solver_parameters(law, 1.0 / MASS, ratio)
        impedance = parameters.solimp[0]
        regularisation = (1.0 - impedance) / (impedance * MASS) / ratio
        # b/R, with b = -solreffriction[1]/d (MuJoCo, "Computation": direct format)
        assert -parameters.solreffriction[1] / impedance / regularisation == pytest.approx(law.creep, rel=1e-9)


def test_frictionless_contacts_have_one_dimension() -> None:
    assert solver_parameters(ContactParameters(1e8, 0.0, 0.1, 0.0), 1.0).condim == 1
    assert solver_parameters(ContactParameters(1e8, 0.0, 0.1, 0.05), 1.0).condim == 3


KINDS = ("pin_gear", "pin_socket", "pin_sleeve", "tooth", "cam", "output")
RING = {"pin_sleeve": "ring.pins=sleeved", "tooth": "ring.kind=nonpin"}


def with_pair(kind: str, *changes: str) -> Design:
    """Return the paper's design with the ring that has a kind of pair, and ``table.key=value`` changes."""
    return override(PRESETS["pin"], [RING.get(kind, "ring.pins=free"), "settings.timestep_us=1", *changes])


def laws_of(design: Design) -> dict[str, ContactParameters]:
    return contact_laws(Reducer(design))


def others(kind: str, before: Design, after: Design) -> None:
    """Check that no other pair of two designs has another law."""
    old, new = laws_of(before), laws_of(after)
    assert {name for name in old if old[name] != new[name]} == {kind}


@pytest.mark.parametrize("kind", KINDS)
def test_each_pair_has_its_stiffness(kind: str) -> None:
    before, after = with_pair(kind), with_pair(kind, f"stiffness.{kind}_n_m=1.5e8")
    assert Reducer(before).contacts[kind].stiffness != 1.5e8
    assert laws_of(after)[kind].stiffness == 1.5e8
    others(kind, before, after)


@pytest.mark.parametrize("kind", KINDS)
def test_each_pair_has_its_damping(kind: str) -> None:
    before, after = with_pair(kind), with_pair(kind, f"damping.{kind}=0.1")
    assert (Reducer(before).contacts[kind].damping_ratio, Reducer(after).contacts[kind].damping_ratio) == (0.5, 0.1)
    assert laws_of(after)[kind].damping == pytest.approx(0.2 * laws_of(before)[kind].damping, rel=1e-12)
    others(kind, before, after)


@pytest.mark.parametrize("kind", KINDS)
def test_each_pair_has_its_working_force(kind: str) -> None:
    before, after = (
        with_pair(kind, "contact.working_force_n=100", *own) for own in ([], [f"working_force.{kind}_n=400"])
    )
    assert Reducer(after).contacts[kind].force == 400.0
    others(kind, before, after)
    # The secant stiffness pi E* L / (a + ln kappa) falls by the logarithm of the force in a.
    modulus = ideal_loads.contact_modulus(210e9, 0.28)
    compliance = [
        math.pi * modulus * 10e-3 / Reducer(d).contacts[kind].curvature_law.stiffness for d in (before, after)
    ]
    roller = 400.0 * STRIBECK / 20 if kind == "cam" else 400.0
    assert compliance[0] - compliance[1] == pytest.approx(math.log(roller / 100.0), rel=1e-9)


def test_teeth_follow_their_own_stiffness_and_force() -> None:
    """The collider's law of the teeth, and the gap below which lines are one patch, follow the tooth pair's keys."""
    law = Reducer(
        with_pair("tooth", "stiffness.tooth_n_m=2e8", "working_force.tooth_n=50")
    ).contacts.teeth.curvature_law
    assert (law.stiffness, law.deflection) == (2e8, 50.0 / 2e8)
    # Those of the pins do not reach an internal gear.
    assert (
        Reducer(with_pair("tooth", "stiffness.pin_gear_n_m=2e8")).contacts.teeth.curvature_law
        == Reducer(with_pair("tooth")).contacts.teeth.curvature_law
    )


def test_the_common_stiffness_is_that_of_a_pin_on_a_flat() -> None:
    design = with_pair("pin_gear", "contact.stiffness_n_m=1e8", "contact.working_force_n=100")
    assert Reducer(design).contacts["pin_gear"].stiffness == 1e8
    assert Reducer(design).contacts["cam"].stiffness == pytest.approx(1e8 * 20 / (2 * STRIBECK), rel=1e-12)
    assert Reducer(design).contacts["pin_socket"].stiffness == pytest.approx(2e8, rel=1e-12)


def test_one_working_force_may_be_stated_for_all_pairs() -> None:
    design = with_pair("pin_gear", "contact.working_force_n=70")
    assert {Reducer(design).contacts[kind].force for kind in KINDS if kind != "cam"} == {70.0}
    # Its most loaded roller bears 70 N, or ideal load sharing asks N/4 of it of a plain cam.
    assert Reducer(design).contacts["cam"].force == pytest.approx(70.0 * 20 / STRIBECK, rel=1e-12)
    assert Reducer(override(design, ["gear.bearing=plain"])).contacts["cam"].force == 70.0 * 36 / 4


def test_rollers_have_separate_friction_coefficients() -> None:
    sliding = ["friction.cam=0.03", "friction.output=0.04"]
    sliding += ["friction.cam_rolling=0.001", "friction.output_rolling=0.002"]
    for cam, rollers in (("rolling", "true"), ("plain", "false")):
        laws = laws_of(with_pair("tooth", *sliding, f"gear.bearing={cam}", f"output.rollers={rollers}"))
        rolls = cam == "rolling"
        assert (laws["cam"].friction, laws["output"].friction) == ((0.001, 0.002) if rolls else (0.03, 0.04))
    laws = laws_of(with_pair("tooth"))
    # needle rollers with a cage, by the makers' catalogues
    assert laws["cam"].friction == laws["output"].friction == 0.002
    laws = laws_of(with_pair("tooth", "gear.bearing=plain", "output.rollers=false"))
    assert laws["cam"].friction == laws["output"].friction == 0.05


def test_a_plain_cam_is_a_conformal_bearing() -> None:
    design = with_pair("cam", "gear.bearing=plain", "contact.working_force_n=100")
    modulus = ideal_loads.contact_modulus(210e9, 0.28)
    assert Reducer(design).contacts["cam"].stiffness == ideal_loads.conformal_stiffness(900.0, 10e-3, modulus, 1e-6)
    # It is stiffer than the rollers, and no stiffer than a bearing without play.
    assert (
        Reducer(with_pair("cam")).contacts["cam"].stiffness
        < Reducer(design).contacts["cam"].stiffness
        < math.pi / 2 * modulus * 10e-3
    )


def test_a_working_force_beyond_a_line_contact_is_reported_by_its_key() -> None:
    with pytest.raises(ContactError, match=r"^working_force\.output_n "):
        assert (
            Reducer(with_pair("output", "working_force.output_n=1e6", "gear.face_width_mm=0.1"))
            .contacts["output"]
            .stiffness_by_disc
        )
    with pytest.raises(ContactError, match=r"^contact\.working_force_n "):
        assert (
            Reducer(with_pair("output", "contact.working_force_n=1e6", "gear.face_width_mm=0.1"))
            .contacts["output"]
            .stiffness_by_disc
        )
