"""The compiled balance of springs: energy, forces and stiffness belong together, and few steps lead to the balance.

All of it runs in a second without compiling, so that `scripts/flip_signs.py` can try every sign.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from designs import UNLIKE, cases, unlike

from cycloid_mj import statics
from cycloid_mj.base.array import Array
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import loads, springs_of
from cycloid_mj.statics.friction_path import Held, Losses, build_friction_elements
from cycloid_mj.statics.kernel import (
    CARRYING_SHARE,
    PATH_RESIDUAL_RTOL,
    RESIDUAL_RTOL,
    RIGID_BODY_STIFFNESS,
    FrictionElements,
    KernelSprings,
    Residual,
    State,
    assemble_after,
    contacts,
    follow_path,
    gap,
    is_open,
    search,
    solve_equilibria,
    state,
)
from cycloid_mj.statics.kernel.continuation import allocate_path, augmented_residual, solve_by_arclength
from cycloid_mj.statics.kernel.system import allocate_system
from cycloid_mj.statics.samples import identical_samples, solve_samples
from cycloid_mj.statics.springs import turn_evenly
from cycloid_mj.validate.displaced import exact_gaps, slip_force

CRANK = 1.9
HELD: tuple[Held, ...] = ("crank", "output")


def design_of(name: str) -> Design:
    """Return a preset, one of `UNLIKE`, or the paper's gear with several discs on pins that bend."""
    if name in UNLIKE:
        return unlike(name)
    if name in PRESETS:
        return PRESETS[name]
    return override(PRESETS["pin"], [f"gear.discs={name}", "structure=springs", "ring.pins=fixed"])


def springs(name: str, *changes: str, crank: tuple[float, ...] = (CRANK,), friction: bool = False) -> KernelSprings:
    """Compute the springs of a design with errors in all parts."""
    made = ("errors.seed=4", "errors.hole_position_um=1.0", "errors.eccentricity_um=1.5", "errors.cam_position_um=0.7")
    design = override(design_of(name), [*made, *changes])
    return springs_of(Reducer(design.but(clearance=dict.fromkeys(design.pair_kinds, 1e-6))), crank, friction).contacts


def rubbed(name: str, held: Held) -> tuple[statics.Springs, FrictionElements]:
    """Return the springs of a design with friction of all kinds, and that friction."""
    design = design_of(name)
    pairs = design.pair_kinds
    design = design.but(clearance=dict.fromkeys(pairs, 1e-6), friction=dict.fromkeys(pairs, 0.15), drive={"speed": 0.0})
    found = springs_of(Reducer(design), [CRANK], friction=False)
    return found, build_friction_elements(
        Reducer(design), found.contacts, CRANK, Losses(drag=1.0, travel=1e-4, material=0.1), held
    )


def pose(contacts: KernelSprings, size: float) -> np.ndarray:
    """Compute departures up to some size [m], turns three times as far."""
    drawn = np.random.default_rng(5).uniform(-size, size, contacts.slope.shape[2])
    drawn[[*range(2, drawn.size, 3), -1]] *= 3.0
    return drawn


@pytest.mark.parametrize("phase", [1.0, -1.0])
def test_a_nearby_foot_point_is_found_in_one_iteration(monkeypatch: pytest.MonkeyPatch, phase: float) -> None:
    """Its search starts right to the second order: to the first it would take another round."""
    monkeypatch.setattr(contacts, "_FOOT_POINT", contacts._FOOT_POINT._replace(max_iterations=1))
    foot = getattr(contacts._find_foot_point, "py_func", contacts._find_foot_point)
    E, c, N = trochoid = 1.0, 0.1, 6.0
    rate = np.hypot(c * N * np.sin(phase), E - c * N * np.cos(phase))
    found, *_ = foot(trochoid, phase, 0.0, 5e-4 * rate, 1.0)
    assert found


@pytest.mark.parametrize("name", ["pin", "twodisc", "light"])
def test_no_contact_that_is_closed_is_passed_over(name: str) -> None:
    """The energy is that of all gaps, with curves apart and displaced along each other at random."""
    contacts = springs(name, "structure=rigid")
    rest, shape = np.zeros(contacts.slope.shape[2]), contacts.distance.shape
    away = np.linalg.norm(contacts.cam_position[0], axis=1)
    deep = np.maximum(away - contacts.cam_clearance, 0.0)
    draw = np.random.default_rng(3).uniform
    for size in np.outer(np.repeat((1e-6, 5e-6), 20), np.where(contacts.rotates, 1.0, 200.0)):  # holes are circles
        apart = contacts._replace(distance=draw(-size, size, shape), shift=draw(-size, size, shape))
        widths = np.array([gap(apart, 0, i, rest).width for i in range(contacts.disc.size)])
        stored = contacts.stiffness[0] @ np.minimum(widths, 0.0) ** 2 + contacts.cam_stiffness * deep @ deep
        assert state(apart, 0, rest, rest).energy == pytest.approx(0.5 * stored, rel=1e-12)


def test_a_barely_closed_contact_is_not_counted_as_open() -> None:
    """Gaps that are drawn at random about the place where parts touch, with the curves displaced along each other."""
    contacts = springs("pin", "structure=rigid")._replace(cam_clearance=np.inf)
    rest, shape = np.zeros(contacts.slope.shape[2]), contacts.distance.shape
    draw = np.random.default_rng(6).uniform
    for size, aside in ((1e-9, 0.0), (5e-11, 5e-7)):
        distance = draw(-size, size, shape) - contacts.clearance
        touching = contacts._replace(distance=distance, shift=draw(-aside, aside, shape))
        widths = np.array([gap(touching, 0, i, rest).width for i in range(contacts.disc.size)])
        assert np.any(widths < 0.0)
        stored = 0.5 * contacts.stiffness[0] @ np.minimum(widths, 0.0) ** 2
        assert state(touching, 0, rest, rest).energy == pytest.approx(stored, rel=1e-6)


@pytest.mark.parametrize("name", ["pin", "nonpin", "twodisc", "light"])
@pytest.mark.parametrize("size", [2e-5, 5e-5])
def test_far_from_their_places_teeth_press_by_exact_gaps(name: str, size: float) -> None:
    """Discs that are displaced as far as wide clearances let them, and the output turned against them."""
    design = override(design_of(name), ["structure=rigid"])
    design = design.but(clearance=dict.fromkeys(design.pair_kinds, 0.9 * size))
    contacts = springs_of(Reducer(design), [CRANK], friction=False).contacts
    teeth = contacts.rotates.sum()
    for angle in np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False):
        z = np.zeros(contacts.slope.shape[2])
        z[:-1:3], z[1:-1:3] = size * np.cos(angle), size * np.sin(angle)
        z[2:-1:3] = 0.7 * size
        exact = exact_gaps(Reducer(design), CRANK, z)[:teeth] + design.pin_play
        found = np.array([gap(contacts, 0, i, z).width for i in range(teeth)])
        np.testing.assert_allclose(np.minimum(found, 0.0), np.minimum(exact, 0.0), rtol=0.0, atol=2e-9)
        holes = np.array([gap(contacts, 0, i, z).width for i in range(teeth, contacts.disc.size)])
        stored = contacts.stiffness[0] @ np.minimum(np.concatenate([exact, holes]), 0.0) ** 2
        energy = state(contacts._replace(cam_clearance=np.inf), 0, 0.0 * z, z).energy
        assert energy == pytest.approx(0.5 * stored, rel=1e-3)


@pytest.mark.parametrize("name", ["pin", "light"])
def test_pins_beyond_the_middle_of_their_holes_press_by_exact_gaps(name: str) -> None:
    """A hole is a whole circle: a pin that is farther off than its middle presses on the other side."""
    design, size = override(design_of(name), ["structure=rigid"]), 4e-4
    design = design.but(clearance=dict.fromkeys(design.pair_kinds, size))
    contacts = springs_of(Reducer(design), [CRANK], friction=False).contacts
    holes = np.flatnonzero(~contacts.rotates)
    for z in np.random.default_rng(1).uniform(-1.5 * size, 1.5 * size, (25, contacts.slope.shape[2])):
        z[2::3], z[-1] = 3.0 * z[2::3], 4.0 * z[-1]
        found = np.array([gap(contacts, 0, i, z).width for i in holes])
        np.testing.assert_allclose(
            np.minimum(found, 0.0), np.minimum(exact_gaps(Reducer(design), CRANK, z)[holes], 0.0), rtol=0.0, atol=1.6e-5
        )


def differences(at: Callable[[np.ndarray], State], z: np.ndarray, what: str, step: float = 1e-9) -> np.ndarray:
    """Compute by how much energy or forces fall with each departure [m]; that of forces is a stiffness."""
    sides = [[getattr(at(z + s * step * axis), what) for axis in np.eye(z.size)] for s in (-1, 1)]
    return (np.array(sides[0]) - np.array(sides[1])).T / (2.0 * step)


@pytest.mark.parametrize("size", [2e-6, 1e-5])
@pytest.mark.parametrize("name", ["pin", "3", "light", "printed", "few"])
def test_forces_are_the_descent_of_the_energy_and_stiffness_that_of_the_forces(name: str, size: float) -> None:
    contacts = springs(name)
    z = pose(contacts, size)
    load = pose(contacts, 100.0)
    found = state(contacts, 0, load, z)
    assert np.abs(found.residual - load).max() > 10.0, "something presses"

    def at(z: np.ndarray) -> State:
        return state(contacts, 0, load, z)

    bound = 2e-7 * np.abs(found.residual).max()
    np.testing.assert_allclose(differences(at, z, "energy"), found.residual, rtol=0.0, atol=bound)
    if size < 1e-5:  # farther away a curve that turns counts as its circle: its stiffness as a way to the balance
        stiffness = differences(at, z, "residual", 3e-10)
        np.testing.assert_allclose(stiffness, found.stiffness, rtol=0.0, atol=1e-7 * np.abs(stiffness).max())
        assert stiffness[-1, -1] > 0.0, "output pins press"


@pytest.mark.parametrize("lag", [0.0, 1.0, -1.0])
@pytest.mark.parametrize(("name", "most"), [("few", 115), pytest.param("2", 140, marks=pytest.mark.slow)])
def test_a_path_leads_in_few_steps_to_the_balance_of_the_other_search(name: str, lag: float, most: int) -> None:
    contacts = springs(name, friction=True)
    u = contacts.slope.shape[2]
    load, other, force = np.zeros((1, u)), np.zeros((1, u)), np.zeros(contacts.distance.shape)
    load[:, -1] = design_of(name).rated_torque / contacts.radius
    assert solve_equilibria(contacts, load, other, force, False).force <= RESIDUAL_RTOL
    here, system = np.zeros(u), allocate_system(contacts)
    for disc, place in enumerate(contacts.cam_position[0]):
        here[3 * disc : 3 * disc + 2] = place
    allowed = RESIDUAL_RTOL * load.max()
    path = allocate_path(contacts, u, lag)
    assert solve_by_arclength(contacts, 0, load[0], here, allowed, path, system) <= allowed
    np.testing.assert_allclose(here, other[0], rtol=0.0, atol=1e-6 * np.abs(other).max())
    assert system.assembly_count[0] <= most


@pytest.mark.parametrize(("lag", "way"), [(0.0, 0.6), (0.5, 0.6), (0.5, 1.3), (-0.5, 0.6), (-0.5, 1.3)])
@pytest.mark.parametrize("name", ["pin", pytest.param("3", marks=pytest.mark.slow)])
def test_the_equations_of_a_path_fall_with_its_point(name: str, lag: float, way: float) -> None:
    contacts = springs(name, friction=True)
    u = contacts.slope.shape[2]
    path, system, load = allocate_path(contacts, u, lag), allocate_system(contacts), np.zeros(u)

    def left(point: np.ndarray) -> np.ndarray:
        augmented_residual(contacts, 0, load, point, path, system)
        return path.residual[:u].copy()

    # pressed well beyond the play, so that what is closed stays so within a step of the differences
    point = np.append(4.0 * pose(contacts, 1.0), way)
    left(point)
    falls = path.matrix[:u].copy()
    falls[np.diag_indices(u)] -= RIGID_BODY_STIFFNESS * contacts.cam_stiffness * path.length_unit
    ways = 1e-6 * np.eye(u + 1)
    exact = np.transpose([left(point - step) - left(point + step) for step in ways]) / 2e-6
    assert np.abs(exact[:, u]).max() > 1.0
    assert (np.abs(falls - exact).max(axis=0) / np.abs(exact).max(axis=0)).max() < 1e-6


@pytest.mark.parametrize("name", ["pin", "light"])
def test_wide_open_gaps_are_recognised_immediately(name: str) -> None:
    """Of concave curves as soon as the gap is wider than the third order may make it; their roots cost the most."""
    contacts, draw = springs(name, "structure=rigid"), np.random.default_rng(8).uniform
    rest, shape, hollow = np.zeros(contacts.slope.shape[2]), contacts.distance.shape, contacts.curvature[0] <= 0.0
    for room in (1e-6, 1e-4):
        wide = np.full(contacts.clearance.shape, room)
        apart = contacts._replace(clearance=wide, distance=draw(-room, 0.0, shape), shift=draw(-1e-6, 1e-6, shape))
        well = [gap(apart, 0, i, rest).width > 1e-8 and hollow[i] for i in range(hollow.size)]
        assert sum(well) > 0.5 * hollow.sum()
        assert all(is_open(apart, 0, i, rest) for i in np.flatnonzero(well))


def test_figures_of_a_sample_are_those_of_its_balances() -> None:
    sizes = ("pin_position", "hole_position", "eccentricity", "disc_size", "cam_position")
    made = ["errors.seed=4", "errors.profile_cos_um={1=0.5}", *(f"errors.{name}_um=0.5" for name in sizes)]
    design = override(design_of("2"), made)
    design = design.but(stiffness=dict.fromkeys(design.pair_kinds, 3e8))
    cranks = np.linspace(0.0, 2.0 * np.pi, 4, endpoint=False)
    found = solve_samples(Reducer(design), identical_samples(Reducer(design), 1), [36.0], cranks.size)[0]
    alone = loads(Reducer(design), springs_of(Reducer(design), cranks, friction=False), 36.0)
    for name, exact in (
        ("gear_mean", alone.gear_turn.mean()),
        ("gear_range", np.ptp(alone.gear_turn)),
        ("output_mean", alone.output_turn.mean()),
        ("output_range", np.ptp(alone.output_turn)),
        ("tooth", alone.teeth.max()),
        ("output_pin", alone.output.max()),
        ("cam", np.linalg.norm(alone.cam, axis=-1).max()),
        ("carrying", np.sum(alone.teeth > CARRYING_SHARE * alone.teeth.max()) / cranks.size),
    ):
        assert getattr(found, name)[0] == pytest.approx(exact, rel=1e-6), name


TURN = (0.3, 0.375, 0.45)
STEPS = {
    "pin": (41, 23, 22),
    "twodisc": (33, 21, 21),
    "2": (36, 22, 21),
    "light": (30, 18, 17),
    "printed": (21, 14, 14),
    "few": (34, 20, 20),
    "teeth21": (28, 16, 16),
}
"""How often the system is put together at three crank angles: each by itself, following each other, and with friction.

Observed. A sign that turns a Newton step into a worse one makes it more.
"""


def test_the_forces_of_a_balance_turn_no_part() -> None:
    """Of discs on pins that bend: those of all contacts, along their gaps, hold each disc and the output."""
    contacts, load, z = springs("2"), np.zeros((1, 7)), np.zeros((1, 7))
    load[:, -1] = design_of("2").rated_torque / contacts.radius
    force = np.zeros(contacts.distance.shape)
    assert balance_along(contacts, load, z, force).force <= RESIDUAL_RTOL
    push = force[0] @ np.array([gap(contacts, 0, i, z[0]).normal for i in range(contacts.disc.size)])
    assert push[3] == pytest.approx(-load[0, -1], rel=1e-6)
    for disc in range(2):
        of_disc = contacts.disc == disc
        turn = force[0, of_disc] @ np.array([gap(contacts, 0, i, z[0]).normal[2] for i in np.flatnonzero(of_disc)])
        assert abs(turn) < 1e-6 * load.max()


def test_an_unloaded_drive_with_large_clearances_needs_few_assemblies() -> None:
    clearances = {"pin_gear": 1e-4, "output": 1e-4, "cam": 1e-4}
    drive = {"speed": 1e-6}
    weightless = {"gravity_x": 0.0, "gravity_y": 0.0}
    changed = PRESETS["pin"].but(ring={"pins": "fixed"}, clearance=clearances, drive=drive, environment=weightless)
    reducer, count = Reducer(changed), 61
    springs = springs_of(reducer, turn_evenly(reducer, count), friction=False)
    contacts = springs.contacts
    z, force = np.zeros((count, 4)), np.zeros(contacts.distance.shape)
    z[:, :2] = contacts.cam_position[:, 0]
    load = springs.load(reducer.share * 1e-4 * changed.rated_torque)
    result = solve_equilibria(contacts, load, z, force, True)
    assert result.force <= RESIDUAL_RTOL
    assert result.work < 45 * count  # 37 per angle


def test_the_friction_of_a_cam_turns_its_own_disc() -> None:
    contacts, load, z = springs("2")._replace(cam_friction_per_force=0.01), np.zeros((1, 7)), np.zeros((1, 7))
    contacts = contacts._replace(friction_per_force=np.zeros((1, *contacts.slope.shape[1:])))
    load[:, -1] = design_of("2").rated_torque / contacts.radius
    force = np.zeros(contacts.distance.shape)
    left = solve_equilibria(contacts, load, z, force, False)
    assert left.force <= RESIDUAL_RTOL
    for disc, place in enumerate(contacts.cam_position[0]):
        of_disc = np.flatnonzero(contacts.disc == disc)
        turn = force[0, of_disc] @ np.array([gap(contacts, 0, i, z[0]).normal[2] for i in of_disc])
        depth = np.linalg.norm(z[0, 3 * disc : 3 * disc + 2] - place) - contacts.cam_clearance
        assert -turn == pytest.approx(0.01 * contacts.cam_stiffness * depth, rel=1e-6)


def test_the_friction_of_a_plain_cam_pushes_its_disc_sideways() -> None:
    contacts, load, z = springs("2")._replace(cam_lateral=0.1), np.zeros((1, 7)), np.zeros((1, 7))
    contacts = contacts._replace(friction_per_force=np.zeros((1, *contacts.slope.shape[1:])))
    load[:, -1] = design_of("2").rated_torque / contacts.radius
    force = np.zeros(contacts.distance.shape)
    assert solve_equilibria(contacts, load, z, force, False).force <= RESIDUAL_RTOL
    for disc, place in enumerate(contacts.cam_position[0]):
        of_disc = np.flatnonzero(contacts.disc == disc)
        push = force[0, of_disc] @ np.array([gap(contacts, 0, i, z[0]).normal[:2] for i in of_disc])
        offset = z[0, 3 * disc : 3 * disc + 2] - place
        normal = contacts.cam_stiffness * (np.linalg.norm(offset) - contacts.cam_clearance)
        u, v = offset / np.linalg.norm(offset)
        assert push == pytest.approx(normal * np.array([u - 0.1 * v, v + 0.1 * u]), rel=1e-6)


def balance_along(contacts: KernelSprings, load: Array, z: Array, force: Array) -> Residual:
    """Balance crank angles that follow each other, with every disc where its cam is at first."""
    z[:, :-1].reshape(len(z), -1, 3)[..., :2] = contacts.cam_position
    return search.solve_equilibria_briefly(contacts, load, z, force, True, 0, allocate_system(contacts))


def balanced(name: str, follow: bool, friction: bool) -> Residual:
    """Balance the rated torque at three crank angles, from where the cams are."""
    contacts = springs(name, crank=TURN, friction=friction)
    load = np.zeros((len(TURN), contacts.slope.shape[2]))
    load[:, -1] = design_of(name).rated_torque / contacts.radius
    z, force = np.zeros_like(load), np.zeros(contacts.distance.shape)
    for disc, place in enumerate(contacts.cam_position.swapaxes(0, 1)):
        z[:, 3 * disc : 3 * disc + 2] = place
    return balance_along(contacts, load, z, force) if follow else solve_equilibria(contacts, load, z, force, False)


@pytest.mark.parametrize("name", STEPS)
def test_a_balance_needs_few_steps(name: str) -> None:
    found = [balanced(name, follow, friction) for follow, friction in ((False, False), (True, False), (True, True))]
    assert all(left.force <= RESIDUAL_RTOL for left in found)
    for left, most in zip(found, STEPS[name], strict=True):
        assert 0.8 * most < left.work <= 1.02 * most + 1


@pytest.mark.parametrize("extrapolate", [False, True])
def test_a_failed_search_continues_along_paths_from_its_start_values(
    extrapolate: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At the angle that failed, and at the next ones by the usual search: all end at the same poses."""
    contacts, usual = springs("few", crank=TURN, friction=True), search.solve_equilibria_briefly
    load = np.zeros((len(TURN), contacts.slope.shape[2]))
    load[:, -1] = design_of("few").rated_torque / contacts.radius
    z, paths, force = np.zeros_like(load), np.zeros_like(load), np.zeros(contacts.distance.shape)
    assert solve_equilibria(contacts, load, z, force, extrapolate).force <= RESIDUAL_RTOL
    first_angles = []

    def fail_once(*inputs: Any) -> Residual:
        *_, extrapolate, first_angle, system = inputs
        first_angles.append(first_angle)
        if first_angle > 1:
            return usual(*inputs)
        usual(contacts, load[:2], paths[:2], force[:2], extrapolate, 0, system)
        system.path_start[:] = 0.0
        return Residual(0.3, 1, 40)

    monkeypatch.setattr(search, "solve_equilibria_briefly", fail_once)
    assert solve_equilibria(contacts, load, paths, np.zeros_like(force), extrapolate).force <= RESIDUAL_RTOL
    assert first_angles == [0, 2]
    np.testing.assert_allclose(paths, z, rtol=0.0, atol=1e-6 * np.abs(z).max())


def followed(contacts: KernelSprings, torque: float) -> Residual:
    """Balance crank angles that follow each other under a torque on the output."""
    load = np.zeros((len(contacts.distance), contacts.slope.shape[2]))
    load[:, -1] = torque / contacts.radius
    return balance_along(contacts, load, np.zeros_like(load), np.zeros(contacts.distance.shape))


@pytest.mark.parametrize(("share", "most"), [(1.0, 32), (1e-3, 46)])
def test_balances_lead_to_those_a_degree_on(share: float, most: int) -> None:
    """Ten angles, observed; with a start of the first order, or without the contacts of the angle before, it is more.

    Under a small load parts are held by few contacts, which must not be lost.
    """
    contacts = springs("pin", crank=tuple(1.0 + 0.0175 * np.arange(10)))
    left = followed(contacts, share * design_of("pin").rated_torque)
    assert left.force <= RESIDUAL_RTOL
    assert 0.8 * most < left.work <= most


@pytest.mark.parametrize("name", ["printed", "light"])
def test_a_cam_far_stiffer_than_the_teeth_needs_hardly_more_steps(name: str) -> None:
    """With 100 um of play: springs softened by the cam alone would let teeth go deeper than their curves reach."""
    contacts = springs(name, friction=True)
    steps = []
    for factor in (1.0, 100.0):
        hard = contacts._replace(
            clearance=np.full(contacts.disc.size, 1e-4), cam_stiffness=factor * contacts.cam_stiffness
        )
        load, z = np.zeros((1, contacts.slope.shape[2])), np.zeros((1, contacts.slope.shape[2]))
        load[:, -1] = design_of(name).rated_torque / contacts.radius
        for disc, place in enumerate(contacts.cam_position[0]):
            z[0, 3 * disc : 3 * disc + 2] = place
        left = solve_equilibria(hard, load, z, np.zeros(contacts.distance.shape), False)
        assert left.force <= RESIDUAL_RTOL
        steps.append(left.work)
    assert steps[1] < 1.5 * steps[0]


@pytest.mark.parametrize("reach", [0.0, 1e-8, 0.9e-6, 1.1e-6, 3e-6])
def test_a_tight_cam_presses_on_both_sides_until_the_far_side_is_free(reach: float) -> None:
    tight, way = 1e-6, np.array([0.6, -0.8])
    contacts = untouched(springs("pin"))._replace(cam_clearance=-tight)
    z = np.zeros(4)
    z[:2] = contacts.cam_position[0, 0] + reach * way

    def at(z: np.ndarray) -> State:
        return state(contacts, 0, np.zeros(4), z)

    found, stiffness = at(z), contacts.cam_stiffness
    sides = np.maximum([tight + reach, tight - reach], 0.0)
    assert found.energy == pytest.approx(0.5 * stiffness * sides @ sides, rel=1e-9)
    np.testing.assert_allclose(found.residual[:2], -stiffness * (sides[0] - sides[1]) * way, rtol=1e-9, atol=1e-6)
    apart = differences(at, z, "residual")
    np.testing.assert_allclose(found.stiffness, apart, rtol=0.0, atol=1e-6 * stiffness)


def test_a_tight_cam_needs_no_more_steps_than_a_cam_with_play() -> None:
    """From the second angle on: at the first, without angles before it, a cam that presses anywhere is no help."""
    turn, torque = tuple(1.0 + 0.0175 * np.arange(10)), 1e-4 * design_of("pin").rated_torque
    work = []
    for width in (1e-7, -5e-7):
        ways = [springs("pin", crank=angles)._replace(cam_clearance=width) for angles in (turn[:1], turn)]
        first, whole = (followed(contacts, torque) for contacts in ways)
        assert max(first.force, whole.force) <= RESIDUAL_RTOL
        work.append(whole.work - first.work)
    loose, tight = work
    assert tight <= 1.2 * loose


@pytest.mark.parametrize("held", HELD)
def test_each_cam_rubs_on_the_turn_of_its_own_disc(held: Held) -> None:
    """By the bore's radius for each radian, whatever the other disc does."""
    found, elements = rubbed("twodisc", held)
    contacts, bore = found.contacts, design_of("twodisc").gear.bore_radius
    cams, turns = slice(contacts.disc.size, contacts.disc.size + 2), [2, 5]
    np.testing.assert_allclose(elements.slip[cams][:, turns], bore / contacts.radius * np.eye(2), rtol=1e-12)


LOOP = np.array([0.2, 1.0, -1.0, 1.0])
LOOPS = {
    "pin": (37, 38),
    "twodisc": (115, 39),
    "printed": (102, 179),
    "few": (252, 230),
}
"""The same for four large steps of a loop with friction that remembers, crank or output held."""


def looped(name: str, held: Held, course: np.ndarray = LOOP) -> Residual:
    """Follow a loop of torque in large steps."""
    found, elements = rubbed(name, held)
    load = np.concatenate([found.load(share * design_of(name).rated_torque) for share in course])
    return follow_path(found.contacts, elements, load, np.inf, np.zeros(len(load)), np.zeros_like(load))[0]


@pytest.mark.parametrize("name", cases(LOOPS, "pin", "printed", "few"))
def test_a_loop_needs_few_steps(name: str) -> None:
    found = [looped(name, held) for held in HELD]
    for left, most in zip(found, LOOPS[name], strict=True):
        assert left.force == 0.0
        assert 0.8 * most < left.work <= 1.02 * most + 1


@pytest.mark.parametrize(
    ("name", "held"),
    [
        ("pin", "crank"),
        ("printed", "crank"),
        ("few", "output"),
        pytest.param("twodisc", "output", marks=pytest.mark.slow),
    ],
)
def test_forces_after_a_step_with_friction_are_the_descent_of_the_energy(name: str, held: Held) -> None:
    """With friction's limits given; where they follow from the normal forces, there is a stiffness, but no energy."""
    loose, elements = rubbed(name, held)
    contacts = loose.contacts
    before, load = pose(contacts, 2e-6), pose(contacts, 100.0)
    z = before + pose(contacts, 1e-7)[::-1]
    for given in (True, False):

        def at(z: np.ndarray, given: bool = given) -> State:
            return assemble_after(contacts, elements, before, load, z, given)

        found, stiffness = at(z), differences(at, z, "residual", 1e-10)
        np.testing.assert_allclose(stiffness, found.stiffness, rtol=0.0, atol=4e-8 * np.abs(stiffness).max())
        if given:
            bound = 2e-7 * np.abs(found.residual).max()
            np.testing.assert_allclose(differences(at, z, "energy", 1e-10), found.residual, rtol=0.0, atol=bound)


def test_earlier_searches_do_not_limit_a_slow_search() -> None:
    still = np.zeros(1010)
    found = looped("few", "crank", np.concatenate([still, LOOP[1:]]))
    assert found.force == 0.0
    assert found.work < still.size + 255


def test_a_tooth_that_rests_at_the_limit_of_the_foot_point_search_is_solved_again() -> None:
    """At this torque its force is too small on one side of the step of its width and too large beyond it."""
    design = PRESETS["pin"].but(clearance=dict.fromkeys(PRESETS["pin"].pair_kinds, 4e-6))
    found = springs_of(Reducer(design), [3.37], friction=False)
    load = found.load(11.288784096638361)
    z, force = np.zeros_like(load), np.zeros(found.contacts.distance.shape)
    z[:, :2] = found.contacts.cam_position[:, 0]
    left = solve_equilibria(found.contacts, load, z, force, False)
    assert left.force <= RESIDUAL_RTOL
    assert left.work > 200, "the first searches must have failed"


def friction_elements(contacts: KernelSprings, **given: float) -> FrictionElements:
    """Return friction that remembers of nothing, or the same of all."""
    count = contacts.disc.size + contacts.cam_position.shape[1]
    none = {name: np.zeros(count) for name in ("coefficient", "stiffness", "retained_share", "retained_stiffness")}
    values = {name: none[name] + given.get(name, 0.0) for name in none}
    return FrictionElements(slip=np.zeros((count, contacts.slope.shape[2])), drag=np.zeros(0), **values)


def untouched(contacts: KernelSprings) -> KernelSprings:
    """Compute springs whose contacts are all open: what is left are the cams."""
    return contacts._replace(clearance=np.ones(contacts.clearance.shape))


def test_a_long_step_is_divided_while_rows_are_left() -> None:
    """Without friction every pose is the balance of the load there."""
    contacts = springs("few")
    path = np.zeros((4, contacts.slope.shape[2]))
    path[:, -1] = np.array([0.02, 1.0, 0.04, 0.6]) * design_of("few").rated_torque / contacts.radius
    reach, most = 7e-7, np.abs(path).max()
    steps = []
    for spare in (20, 3):
        when = np.full(len(path) + spare, np.nan)
        z = np.zeros((when.size, path.shape[1]))
        left, rows = follow_path(contacts, friction_elements(contacts), path, reach, when, z)
        assert left.force == 0.0
        when, z = when[:rows], z[:rows]
        assert np.all(np.diff(when) > 0.0)
        assert set(when) >= set(range(len(path)))
        for at, pose in zip(when, z, strict=True):
            load = np.array([np.interp(at, range(len(path)), course) for course in path.T])
            assert np.abs(state(contacts, 0, load, pose).residual).max() < 2.0 * PATH_RESIDUAL_RTOL * most
        steps.append((rows, np.abs(np.diff(z[:, -1])).max()))
    (parted, longest), (spent, _) = steps
    assert 7 < parted < 24
    assert longest <= reach
    assert spent == 7


def test_a_part_without_contact_is_held_by_the_weak_springs() -> None:
    contacts = untouched(springs("twodisc"))._replace(cam_clearance=1.0)
    path = np.outer([0.0, 1.0, 0.5], pose(contacts, 1e-6))
    z = np.zeros_like(path)
    follow_path(contacts, friction_elements(contacts), path, np.inf, np.zeros(len(path)), z)
    np.testing.assert_allclose(z, np.cumsum(path, axis=0) / (RIGID_BODY_STIFFNESS * contacts.cam_stiffness), rtol=1e-6)


def test_a_disc_rubs_its_cam_across_its_way() -> None:
    """It sticks, then slips, on both discs: against the law of a circle in a circle."""
    contacts = untouched(springs("twodisc"))._replace(cam_clearance=1e-6)
    number, discs, stick, coefficient = contacts.disc.size, contacts.cam_position.shape[1], 1e9, 0.2
    path = np.zeros((4, contacts.slope.shape[2]))
    path[:, :2] = [[100.0, 40.0], [95.0, 50.0], [60.0, 90.0], [80.0, 80.0]]
    path[:, 3:5] = [[-80.0, 150.0], [-85.0, 145.0], [-150.0, 90.0], [-140.0, 95.0]]
    elements = friction_elements(contacts, stiffness=stick, coefficient=coefficient)
    elements.coefficient[:number] = 0.0
    z = np.zeros_like(path)
    left = follow_path(contacts, elements, path, np.inf, np.zeros(len(path)), z)[0]
    assert left.force == 0.0
    for disc in range(discs):
        way = z[:, 3 * disc : 3 * disc + 2] - contacts.cam_position[0, disc]
        side, before, slipped = 0.0, -contacts.cam_position[0, disc], 0
        for here, load in zip(way, path[:, 3 * disc : 3 * disc + 2], strict=True):
            across = np.array([-before[1], before[0]]) / np.linalg.norm(before)
            out = np.linalg.norm(here)
            normal = contacts.cam_stiffness * (out - contacts.cam_clearance)
            side = float(slip_force(side, across @ (here - before), coefficient * normal, stick))
            slipped += abs(side) == pytest.approx(coefficient * normal)
            np.testing.assert_allclose(normal * here / out + side * across, load, rtol=0.0, atol=2e-4)
            before = here
        assert 0 < slipped < len(path)


@pytest.mark.parametrize("across", [-2e-5, -1e-6, 1e-6, 2e-5])
@pytest.mark.parametrize("name", ["pin", "light", "few"])
def test_gaps_fall_with_their_gradient_and_normals_turn_at_their_rate(name: str, across: float) -> None:
    """Of curves far apart, too: the exact foot of a normal in a valley is found there, the rate where it has one."""
    contacts, step = springs(name), 1e-9
    rest = np.zeros(contacts.slope.shape[2])
    for ahead in np.array([-3.5e-4, -1e-4, 8e-5, 3e-4]) * contacts.trochoid[0]:
        moved = contacts._replace(
            distance=np.full(contacts.distance.shape, across), shift=np.full(contacts.shift.shape, ahead)
        )
        gradient, rate = [], []
        for i in np.flatnonzero(contacts.rotates):
            here, ways = gap(moved, 0, i, rest), step * np.eye(rest.size)[:2]
            sides = [[gap(moved, 0, i, s * way) for way in ways] for s in (1, -1)]
            widths, normals = ([[getattr(one, what) for one in side] for side in sides] for what in ("width", "normal"))
            aside = np.array(here.tangential[:2])
            gradient.append([here.normal[:2], np.subtract(*widths) / (2.0 * step)])
            rate.append([here.rate * np.outer(aside, aside), np.subtract(*normals)[:, :2] / (2.0 * step)])
        np.testing.assert_allclose(*np.swapaxes(gradient, 0, 1), rtol=0.0, atol=1e-7)
        if abs(across) < 1e-5:
            ours, exact = np.swapaxes(rate, 0, 1)
            np.testing.assert_allclose(ours, exact, rtol=0.0, atol=6e-6 * np.abs(exact).max())


def test_the_gap_is_continuous_where_the_foot_point_search_begins() -> None:
    """On a convex flank the third order hands over smoothly: a step would be a leap of the second difference."""
    contacts = springs("2")
    rest, size = np.zeros(contacts.slope.shape[2]), contacts.trochoid[0]
    step = 2e-6 * size
    cut = np.flatnonzero(contacts.rotates & (contacts.curvature[0] > 0.0) & (contacts.curvature_rate[0] != 0.0))
    for i in cut[:: cut.size // 4]:
        moved = (contacts._replace(shift=np.full(contacts.shift.shape, p)) for p in np.arange(-1e-3, 1e-3, 2e-6) * size)
        width = np.array([gap(one, 0, i, rest).width for one in moved])
        assert np.abs(np.diff(width, 2)).max() < 1.05 * step**2 * contacts.curvature[0, i]
