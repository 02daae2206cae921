"""The opening of the sockets: one angle for parts and contact, the pin at its edges, and what it changes."""

import math

import mujoco
import numpy as np
import pytest

from cycloid_mj.base.errors import DesignError, RunError
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.design.units import MICROMETRE
from cycloid_mj.dynamics.contact import collider
from cycloid_mj.dynamics.contact.gap import PartialCircle, circle_at_edge, circle_in_circle, nearest_on_arc
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.mjcf.mesh import build_mesh
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.parts import VISUAL_CHORD_ERROR, housing_solid
from cycloid_mj.parts.export import export
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bodies import Role, build_mechanism
from cycloid_mj.reducer.sockets import arc_half_angle, socket_half_angle, wall_radius

PIN = PRESETS["pin"]
TURNED = 0.7
"""Clockwise angle of a socket's middle from +y [rad]."""


def arc_of(half: float, radius: float) -> PartialCircle:
    return PartialCircle(radius, math.sin(TURNED), math.cos(TURNED), math.cos(half), math.sin(half))


def nearest(place: np.ndarray, inner: float, arc: PartialCircle) -> tuple[float, float, float]:
    """Compute the nearest of the contacts that the collider would find."""
    side, on_arc, other = nearest_on_arc(*place, arc)
    first = circle_in_circle(*place, inner, arc.radius) if on_arc else circle_at_edge(*place, inner, arc, side)
    return min(first, circle_at_edge(*place, inner, arc, -side)) if other else first


@pytest.mark.parametrize("half", [0.6, 1.22, 1.598, 2.6])
def test_pin_touches_the_nearest_point_of_its_socket(half):
    """Against a hundred thousand points of the arc; the normal leads to the nearest one."""
    radius, inner = 2.251e-3, 2.25e-3
    angles = TURNED + np.linspace(-half, half, 100_001)
    points = radius * np.stack([np.sin(angles), np.cos(angles)], axis=1)
    for place in np.random.default_rng(1).uniform(-20e-6, 20e-6, (12, 2)):
        away = points - place
        size = np.linalg.norm(away, axis=1)
        gap, *normal = nearest(place, inner, arc_of(half, radius))
        assert gap == pytest.approx(size.min() - inner, abs=2e-11)
        assert normal @ away[np.argmin(size)] == pytest.approx(size.min(), rel=1e-6)


@pytest.mark.parametrize("half", [1.22, 1.598])
def test_gap_and_normal_are_continuous_at_an_edge(half):
    arc, inner = arc_of(half, 2.251e-3), 2.25e-3
    before, after = (
        nearest(2e-6 * np.array([math.sin(TURNED + angle), math.cos(TURNED + angle)]), inner, arc)
        for angle in (half - 1e-9, half + 1e-9)
    )
    assert before == pytest.approx(after, abs=1e-8)


def test_socket_opening_matches_the_solids():
    """The points of the housing's hole that lie as far from a pin's centre as its socket's wall span the same angle."""
    hole = housing_solid(Reducer(PIN), VISUAL_CHORD_ERROR).prisms[0].holes[0]
    seat = hole - [0.0, PIN.ring.pin_circle_radius]
    radius = PIN.ring.pin_radius + PIN.clearance.pin_socket
    wall = seat[np.abs(np.linalg.norm(seat, axis=1) - radius) < 1e-9]
    angle = np.abs(np.arctan2(wall[:, 0], wall[:, 1]))
    assert angle.max() == pytest.approx(socket_half_angle(PIN), abs=1e-9)
    assert math.degrees(socket_half_angle(PIN)) == pytest.approx(91.5824, abs=1e-3)
    assert wall_radius(PIN) == PIN.ring.pin_circle_radius == pytest.approx(np.linalg.norm(hole, axis=1).min())


def test_tips_that_reach_far_cut_the_wall_back():
    design = override(PIN, ["ring.teeth=21", "ring.pin_circle_radius_mm=27", "ring.pin_radius_mm=1.5"])
    assert MICROMETRE.from_si(wall_radius(design)) == pytest.approx(27550.0)
    assert socket_half_angle(design) == pytest.approx(arc_half_angle(design, 1.501e-3))
    assert socket_half_angle(design) < math.pi / 2.0


@pytest.mark.parametrize("pins", ["free", "massless"])
def test_closed_sockets_hold_all_round(pins):
    design = PIN.but(ring={"pins": pins, "socket": "closed"})
    assert socket_half_angle(design) == math.pi
    assert {surfaces.half_angle for surfaces in build_mechanism(design).surfaces} == {math.pi}
    opened = build_mechanism(design.but(ring={"socket": "half_open"}))
    assert {surfaces.half_angle for surfaces in opened.surfaces} == {math.pi, socket_half_angle(PIN)}


FALL = 9.8
"""Acceleration of a pin that slides off an edge [m/s2]."""


def test_pin_leaves_its_socket_at_the_energy_limit():
    """Without friction its centre runs on a circle about the edge, which carries m (g cos - v^2/r): v^2 = 2 g (drop).

    It starts at rest, pressed on the edge 0.3 rad beyond where it would balance.
    """
    radius, inner, mass, stiffness, begin = 2.251e-3, 2.25e-3, 1e-3, 1e4, 0.3
    half = 1.2
    edge = radius * np.array([math.sin(half), math.cos(half)])
    # gravity acts along the direction from which the pin's angle about the edge is counted
    down = np.array([math.sin(half - 0.5), math.cos(half - 0.5)])
    aside = np.array([-down[1], down[0]])
    start = edge - inner * (math.cos(begin) * down + math.sin(begin) * aside)
    user = " ".join(map(str, (math.cos(half), math.sin(half))))
    ratio = 0.05  # of added to all mass in the contact: small, so that its inertia carries nothing
    scale = (1.0 - ratio) / mass
    model = mujoco.MjModel.from_xml_string(f"""
        <mujoco><size nuser_geom="13"/>
        <option timestep="2e-6" gravity="{FALL * down[0]} {FALL * down[1]} 0" cone="elliptic"/>
        <worldbody><geom name="socket" type="cylinder" size="{radius} 5e-3" priority="{int(Role.OUTER)}"
            contype="0" conaffinity="0" user="{user}"/>
        <body name="pin"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
        <geom name="pin" type="cylinder" size="{inner} 5e-3" mass="{mass}" priority="{int(Role.PIN)}"
            contype="0" conaffinity="0"/></body></worldbody>
        <contact><pair geom1="pin" geom2="socket" condim="1" solimp="{ratio} {ratio} 1e-3 0.5 1"
            solref="{-stiffness * scale} {-2.0 * math.sqrt(stiffness * mass) * scale}"/></contact></mujoco>""")
    data = mujoco.MjData(model)
    data.qpos[:] = start
    with collider.install(lobes=False):
        mujoco.mj_step(model, data, 5000)
    leg = edge - data.qpos
    angle = math.atan2(leg @ aside, leg @ down)
    assert angle > begin + 0.05
    assert data.ncon == 1
    drop = inner * (math.cos(begin) - math.cos(angle))
    assert data.qvel @ data.qvel == pytest.approx(2.0 * FALL * drop, rel=1e-2)
    carried = mass * (FALL * math.cos(angle) - data.qvel @ data.qvel / inner)
    assert data.efc_force[0] == pytest.approx(carried, rel=1e-2)


def ways(design: Design, by_mesh: bool = False) -> np.ndarray:
    """Compute how far each pin gets from its place in a short run [m], shape (N,)."""
    run = simulate(design, build_mesh(Reducer(design)) if by_mesh else None)
    numbers = range(1, design.ring.teeth + 1)
    return np.array([np.hypot(run[f"pin_{number}_x"], run[f"pin_{number}_y"]).max() for number in numbers])


def lightly_loaded(hold: float, *changes: str) -> Design:
    course = (f"drive.hold_s={hold}", "drive.ramp_s=0", "load.torque_nm=1", "settings.timestep_us=5")
    return override(PIN, [*course, *changes])


@pytest.mark.filterwarnings("ignore:pin. pin_:cycloid_mj.base.errors.CycloidWarning")
@pytest.mark.slow
def test_pins_leave_open_sockets_equally_in_profile_and_mesh_models():
    """At 1 N m; convex meshes know nothing of arcs and edges."""
    design = lightly_loaded(0.025)
    profile, mesh = ways(design), ways(design, by_mesh=True)
    assert profile.mean() == pytest.approx(mesh.mean(), rel=0.2)
    assert np.quantile(profile, 0.9) == pytest.approx(np.quantile(mesh, 0.9), rel=0.2)
    assert profile.max() > 5.0 * PIN.clearance.pin_socket


@pytest.mark.slow
def test_closed_sockets_keep_pins_within_their_clearance():
    assert (
        ways(lightly_loaded(0.01, "ring.socket=closed", "settings.timestep_us=0")).max()
        < 1.05 * PIN.clearance.pin_socket
    )


def test_a_massless_pin_pressed_into_the_opening_has_no_contact():
    """Of pins that a turned gear presses at up to 62 degrees from their middles, a narrow socket holds fewer."""
    design = PIN.but(ring={"pins": "massless"})
    touched = []
    for wall in (socket_half_angle(design), 0.5):
        compiled = build(design)
        for number in range(1, design.ring.teeth + 1):
            compiled.model.geom(f"pin_{number}").user[4] = 1.0 + math.cos(wall)
        data = mujoco.MjData(compiled.model)
        data.joint("gear_angle").qpos[0] = 2e-4
        with collider.install():
            mujoco.mj_forward(compiled.model, data)
        touched.append(data.ncon)
    assert touched[0] > touched[1] > 0


@pytest.mark.parametrize("make", [lambda design: build_mesh(Reducer(design)), lambda design: export(design, "stl")])
def test_parts_that_are_not_drawn_are_refused(make):
    with pytest.raises(DesignError, match="bores in end plates, whose solids cannot be generated"):
        make(PIN.but(ring={"socket": "closed"}))


@pytest.mark.slow
def test_a_pin_that_its_socket_does_not_retain_ends_the_run():
    design = override(PIN, ["ring.pin_radius_mm=1.2", "drive.ramp_s=0", "drive.hold_s=0.02", "load.torque_nm=10"])
    with pytest.raises(RunError, match="left its socket"):
        simulate(design)
