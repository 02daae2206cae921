"""The collider: exact gaps, MuJoCo's own structures, foreign pairs, injected contacts as an independent reference."""

import itertools

import mujoco
import numpy as np
import pytest

from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.contact import collider, gap
from cycloid_mj.dynamics.contact.layout import find_layout
from cycloid_mj.dynamics.contact.library import CYLINDER, TYPES, collision_table
from cycloid_mj.dynamics.drive_cycle import initial_state
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.geometry.profile import CycloidGear, curvature, trochoid
from cycloid_mj.parts.gear import tooth_profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate import equilibrium

PAPER = CycloidGear(ring_teeth=36, eccentricity=1e-3, pin_circle_radius=40.75e-3, pin_radius=2.25e-3)
OTHERS = (
    CycloidGear(ring_teeth=8, eccentricity=1.5e-3, pin_circle_radius=20e-3, pin_radius=3e-3),
    CycloidGear(ring_teeth=120, eccentricity=0.8e-3, pin_circle_radius=150e-3, pin_radius=2e-3),
)


def brute_force(gear: CycloidGear, point: np.ndarray) -> float:
    """Distance to the trochoid by sampling it ever finer around the nearest sample."""
    centre, half = np.pi, np.pi
    for _ in range(4):
        t = np.linspace(centre - half, centre + half, 20_001)
        distance = np.linalg.norm(trochoid(gear, t) - point, axis=1)
        centre, half = t[np.argmin(distance)], half / 5_000
    return float(distance.min())


@pytest.mark.slow
@pytest.mark.parametrize("gear", [PAPER, *OTHERS])
def test_distance_equals_brute_force(gear: CycloidGear) -> None:
    rng = np.random.default_rng(1)
    curve = gap.Trochoid(gear.pin_circle_radius, gear.eccentricity, float(gear.ring_teeth))
    for t in rng.uniform(0.0, 2.0 * np.pi, 40):
        point = trochoid(gear, t) + rng.uniform(-5e-6, 5e-6, 2)
        _, distance, nx, ny = gap.trochoid_distance(point[0], point[1], curve)
        assert abs(distance) == pytest.approx(brute_force(gear, point), abs=2e-11)
        foot = point - distance * np.array([nx, ny])
        assert np.hypot(nx, ny) == pytest.approx(1.0, abs=1e-14)
        _, again, _, _ = gap.trochoid_distance(foot[0], foot[1], curve)
        assert abs(again) < 1e-15


@pytest.mark.parametrize("gear", [PAPER, *OTHERS])
def test_distance_has_the_sign_of_outside(gear: CycloidGear) -> None:
    t = np.linspace(0.0, 2.0 * np.pi, 97)
    curve = gap.Trochoid(gear.pin_circle_radius, gear.eccentricity, float(gear.ring_teeth))
    for x, y in trochoid(gear, t) * 1.0002:
        assert gap.trochoid_distance(x, y, curve)[1] > 0.0
    for x, y in trochoid(gear, t) * 0.9998:
        assert gap.trochoid_distance(x, y, curve)[1] < 0.0


def test_far_points_find_the_nearest_foot() -> None:
    rng = np.random.default_rng(2)
    curve = gap.Trochoid(PAPER.pin_circle_radius, PAPER.eccentricity, float(PAPER.ring_teeth))
    for t in rng.uniform(0.0, 2.0 * np.pi, 30):
        point = trochoid(PAPER, t) + rng.uniform(-5e-4, 5e-4, 2)
        distance = gap.trochoid_distance(point[0], point[1], curve)[1]
        assert abs(distance) == pytest.approx(brute_force(PAPER, point), abs=1e-9)


def test_circle_in_circle() -> None:
    distance, nx, ny = gap.circle_in_circle(3e-6, 4e-6, 1e-3, 1.004e-3)
    assert (distance, nx, ny) == pytest.approx((-1e-6, 0.6, 0.8), abs=1e-15)
    assert gap.circle_in_circle(0.0, 0.0, 1e-3, 1.004e-3)[0] == pytest.approx(4e-6, abs=1e-15)


def test_layout_is_found_and_stable() -> None:
    layout = find_layout()
    assert len({layout.geom_size, layout.geom_priority, layout.geom_user}) == 3
    assert layout.geom_xpos != layout.geom_xmat


@pytest.mark.parametrize("crank", [0.0, 1.0, 4.4])
def test_gaps_of_the_centred_model_are_its_clearances(crank: float) -> None:
    """Every pin is one clearance from the gear at every crank angle; a deep margin shows gaps as contacts."""
    design = PRESETS["pin"]
    compiled = build(design)
    margin = 1e-5
    compiled.model.pair_margin[:] = margin
    data = pose(compiled, design, crank)
    with collider.install():
        mujoco.mj_forward(compiled.model, data)
    assert data.ncon == len(compiled.pairs)
    assert data.contact.dist == pytest.approx(np.full(data.ncon, 1e-6), abs=2e-14)


def pose(compiled, design, crank: float):
    """Place every part as the closed form has it."""
    data = mujoco.MjData(compiled.model)
    c = design.gear.eccentricity
    place = {
        "crank": crank,
        "gear_x": -c * np.sin(crank),
        "gear_y": c * np.cos(crank),
        "gear_angle": -crank / design.lobes,
        "output": -crank / design.lobes,
    }
    for joint, value in place.items():
        data.joint(joint).qpos[0] = value
    return data


def test_foreign_cylinders_keep_mujocos_collider() -> None:
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody><geom type="cylinder" size="1 1"/>
        <body pos="1.2 0.3 0.2"><freejoint/><geom type="cylinder" size="1 1"/></body></worldbody></mujoco>"""
    )
    found = []
    for _ in range(2):
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        found.append(data.contact.dist.copy())
    with collider.install():
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
    assert len(found[0]) > 0
    np.testing.assert_array_equal(found[0], data.contact.dist)


def test_collider_comes_out_again() -> None:
    entry = CYLINDER * TYPES + CYLINDER
    before = collision_table()[entry]
    with collider.install():
        inside = collision_table()[entry]
        with collider.install():
            assert collision_table()[entry] == inside
        assert collision_table()[entry] == inside
    assert inside != before
    assert collision_table()[entry] == before


def without_pairs(spec):
    """Compile the same model without explicit pairs: MuJoCo itself then finds no contact."""
    bare = spec.copy()
    for pair in list(bare.pairs):
        bare.delete(pair)
    return bare.compile()


def inject(model, data, compiled, design) -> None:
    """Add the contacts of our gap functions by MuJoCo's public API: an independent way in."""
    law = compiled.model
    number = {law.pair(i).name: i for i in range(law.npair)}
    for pair in compiled.pairs:
        on, by = model.geom(pair.on).id, model.geom(pair.by).id
        delta = data.geom_xpos[by] - data.geom_xpos[on]
        if pair.kind == "pin_gear":
            frame = data.geom_xmat[on].reshape(3, 3)
            x, y, _ = frame.T @ delta
            gear, clearance = tooth_profile(design), design.clearance.pin_gear
            t, distance, nx, ny = gap.trochoid_distance(
                x, y, gap.Trochoid(gear.pin_circle_radius, gear.eccentricity, float(gear.ring_teeth))
            )
            dist = distance + clearance
            relative = curvature(gear, t, gear.pin_radius + clearance) + 1.0 / gear.pin_radius
            scale = Reducer(design).contacts.teeth.curvature_law.factor(relative)
            normal = frame @ [nx, ny, 0.0]
            point = data.geom_xpos[by] - (model.geom_size[by, 0] + 0.5 * dist) * normal
        else:
            inner, outer = (on, by) if pair.kind == "pin_socket" else (by, on)
            away = data.geom_xpos[inner] - data.geom_xpos[outer]
            inner_radius, outer_radius = model.geom_size[[inner, outer], 0]
            scale = 1.0
            dist, nx, ny = gap.circle_in_circle(away[0], away[1], inner_radius, outer_radius)
            if pair.kind == "pin_socket":
                between, towards = equilibrium.seat_gaps(Reducer(design), np.tile(away[:2], (design.ring.teeth, 1)))
                dist, (nx, ny) = between[pair.owner], towards[pair.owner]
            outward = np.array([nx, ny, 0.0])
            point = data.geom_xpos[inner] + (inner_radius + 0.5 * dist) * outward
            normal = outward if inner == on else -outward
        if dist >= 0.0:
            continue
        i = number[pair.name]
        contact = mujoco.MjContact()
        contact.dist, contact.pos, contact.dim = scale * dist, point, law.pair_dim[i]
        contact.frame = np.concatenate([normal, [-normal[1], normal[0], 0.0], [0.0, 0.0, 1.0]])
        contact.geom = [on, by]
        contact.friction = law.pair_friction[i]
        contact.solref, contact.solimp = law.pair_solref[i], law.pair_solimp[i]
        contact.solreffriction = law.pair_solreffriction[i]
        contact.includemargin = 0.0
        contact.exclude = 0
        mujoco.mj_addContact(model, data, contact)


def take_off_lift(model, data) -> None:
    """Lower the reference of each contact that slides by what MuJoCo's cone lifts it (`reference_correction`)."""
    accelerations = np.zeros(data.nefc)
    mujoco.mj_mulJacVec(model, data, accelerations, data.qacc)  # of the step before
    remaining = data.efc_aref - accelerations
    for contact in data.contact:
        if contact.dim == 3:
            normal, *sliding = remaining[contact.efc_address : contact.efc_address + 3]
            lift = contact.friction[0] * np.linalg.norm(sliding) - contact.mu**2 * max(normal, 0.0)
            data.efc_aref[contact.efc_address] -= max(lift, 0.0)


def injected_step(model, data, compiled, design) -> None:
    """One semi-implicit Euler step, stage by stage, with injected contacts."""
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_crb(model, data)
    mujoco.mj_factorM(model, data)
    mujoco.mj_collision(model, data)
    inject(model, data, compiled, design)
    mujoco.mj_makeConstraint(model, data)
    mujoco.mj_transmission(model, data)
    mujoco.mj_projectConstraint(model, data)
    mujoco.mj_fwdVelocity(model, data)
    take_off_lift(model, data)
    mujoco.mj_fwdActuation(model, data)
    mujoco.mj_fwdAcceleration(model, data)
    mujoco.mj_fwdConstraint(model, data)
    mujoco.mj_Euler(model, data)


def test_collider_equals_injected_contacts() -> None:
    """Two hundred loaded steps by the collider and by ``mj_addContact`` move every joint alike."""
    changes = ["drive.ramp_s=0.0", "load.torque_nm=36.0", "load.rise_s=0.0005", "settings.timestep_us=1"]
    design = override(PRESETS["pin"], changes)
    compiled = build(design)
    by_collider, by_injection = initial_state(compiled, Reducer(design)), initial_state(compiled, Reducer(design))
    bare = without_pairs(compiled.spec)
    for number, (model, data, step) in itertools.product(
        range(200), ((compiled.model, by_collider, "collider"), (bare, by_injection, "injection"))
    ):
        data.ctrl[:] = [171.74 * 2e-6 * number, 36.0 * number / 200]
        if step == "collider":
            with collider.install():
                mujoco.mj_step(model, data)
        else:
            injected_step(model, data, compiled, design)
    assert by_collider.ncon > 30
    assert by_injection.ncon == by_collider.ncon
    # The collider expands near the foot, to 1e-7 rad in the normal, and rattling light pins amplify that.
    np.testing.assert_allclose(by_injection.qpos, by_collider.qpos, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(by_injection.qvel, by_collider.qvel, rtol=0.0, atol=1e-4)
