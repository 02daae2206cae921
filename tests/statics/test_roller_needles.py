"""Output rollers on separate needles: closed forms, equilibrium of each roller, and the planar solver."""

import numpy as np
import pytest

from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.powers import mean_powers
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.run import model_for, simulate
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.roller_needles import RollerNeedles, onset, roller_contact
from cycloid_mj.statics import Loads, springs_of
from cycloid_mj.statics import loads as solve_loads

ROLLERS = override(
    PRESETS["pin"],
    [
        *('friction.law="coulomb"', 'ring.pins="fixed"', "environment.gravity_y_m_s2=0", "output.core_radius_mm=2.5"),
        *("gear.bearing=plain", "clearance.output_um=0.001", "friction.cam=0", "contact.needles=each"),
    ],
)
FRICTIONLESS = [f"friction.{pair}=0" for pair in ("pin_gear", "pin_socket", "output", "output_rolling", "cam")]
STIFFNESS = 4e8


def at_nominal_torque(design: Design) -> Reducer:
    return Reducer(design.but(load={"torque": design.rated_torque}))


def solve(reducer: Reducer, crank: np.ndarray, friction: bool = False) -> Loads:
    return solve_loads(reducer, springs_of(reducer, crank, friction=friction), reducer.design.load.torque)


def by_grid(approach: float, angle: float, needles: RollerNeedles) -> float:
    """Force [N] on a roller from its energy on a grid of displacements, refined twelve times about the lowest point."""
    turns = 2.0 * np.pi * np.arange(needles.needles) / needles.needles - angle
    middle, width = np.zeros(2), approach
    for _ in range(12):
        x, y = np.meshgrid(*(at + width * np.linspace(-1.0, 1.0, 41) for at in middle), indexing="ij")
        depth = x[..., np.newaxis] * np.cos(turns) + y[..., np.newaxis] * np.sin(turns) - needles.clearance
        energy = STIFFNESS * (approach - x) ** 2 + needles.stiffness * np.sum(np.maximum(depth, 0.0) ** 2, axis=-1)
        lowest = np.unravel_index(np.argmin(energy), energy.shape)
        middle, width = np.array([x[lowest], y[lowest]]), 0.2 * width
    return STIFFNESS * (approach - middle[0])


@pytest.mark.parametrize("angle", [0.0, 0.1, 0.3, 5.0])
@pytest.mark.parametrize("clearance", [0.0, 2e-6])
def test_the_force_is_that_of_the_least_energy(angle: float, clearance: float) -> None:
    needles = RollerNeedles(14, 9e7, clearance, -0.5)
    for approach in (3e-6, 8e-6):
        force, slope = roller_contact(approach, angle, STIFFNESS, 14, 9e7, clearance)
        assert force == pytest.approx(by_grid(approach, angle, needles), rel=1e-6)
        step = 1e-11
        beyond = roller_contact(approach + step, angle, STIFFNESS, 14, 9e7, clearance)[0]
        assert slope == pytest.approx((beyond - force) / step, rel=1e-3)


def test_needles_without_clearance_are_a_spring_in_series() -> None:
    """An even number of them has a quarter of their stiffness in every direction."""
    for angle in (0.0, 0.2, 1.9):
        force, slope = roller_contact(5e-6, angle, STIFFNESS, 16, 1e8, 0.0)
        series = 1.0 / (1.0 / STIFFNESS + 1.0 / 4e8)
        assert (force, slope) == pytest.approx((5e-6 * series, series), rel=1e-6)


@pytest.mark.parametrize("angle", [0.0, 0.05, 2.0 * np.pi / 28.0, 3.0])
def test_a_roller_begins_to_carry_load_on_the_two_needles_next_to_it(angle: float) -> None:
    needles = RollerNeedles(14, 9e7, 2e-6, -0.5)
    first = onset(needles, angle)
    assert 2e-6 <= first <= 2e-6 / np.cos(np.pi / 14.0)
    forces = [roller_contact(first + step, angle, STIFFNESS, 14, 9e7, 2e-6)[0] for step in (-1e-10, 1e-10)]
    assert forces[0] == pytest.approx(0.0, abs=1e-5)
    assert forces[1] > 1e-3


@pytest.mark.parametrize("torque", [5.0, 36.0])
def test_a_lumped_roller_bearing_has_the_secant_stiffness_of_its_needles(torque: float) -> None:
    """Force over displacement of the core in its roller, of an even number of needles without clearance."""
    each = Reducer(ROLLERS.but(load={"torque": torque}))
    lumped = each.but(contact={"needles": "lumped"})
    needles, force = each.roller_needles, each.contacts["output"].force
    assert needles.needles % 2 == 0
    for angle in (0.0, 0.07, 1.3):
        rigid_hole = 1e6 * needles.stiffness
        approach = force * (lumped.roller_compliance + 1.0 / rigid_hole)
        found, _ = roller_contact(approach, angle, rigid_hole, needles.needles, needles.stiffness, 0.0)
        assert found == pytest.approx(force, rel=1e-4)
    (lumped_stiffness,), (hole,) = (one.contacts["output"].stiffness_by_disc for one in (lumped, each))
    assert 1.0 / lumped_stiffness == pytest.approx(1.0 / hole + 4.0 / (needles.needles * needles.stiffness), rel=1e-9)


def test_only_rollers_on_needles_have_their_compliance() -> None:
    lumped = Reducer(override(ROLLERS, ["contact.needles=lumped"]))
    assert lumped.roller_compliance > 0.0
    for changes in ("output.core_radius_mm=0", "output.roller_bearing=plain", "output.rollers=false"):
        assert Reducer(override(lumped.design, [changes])).roller_compliance == 0.0
    assert [Reducer(PRESETS[name]).roller_compliance for name in ("pin", "nonpin", "twodisc")] == [0.0] * 3


def test_output_pins_are_softer_by_the_compliance_of_their_needles() -> None:
    """Without clearance, separate needles have the wind-up of lumped ones, and of a softer contact with the hole."""
    reducer, crank = at_nominal_torque(ROLLERS), np.linspace(0.0, 2.0 * np.pi, 61)
    needles, contact = reducer.roller_needles, reducer.contacts["output"]
    series = 1.0 / (1.0 / contact.stiffness + 4.0 / (needles.needles * needles.stiffness))
    assert 0.6 * contact.stiffness < series < 0.9 * contact.stiffness
    each = solve(reducer, crank)
    for changes in ([], ["output.roller_bearing=plain", "friction.output=0", f"stiffness.output_n_m={series!r}"]):
        softer = solve(at_nominal_torque(override(ROLLERS, ["contact.needles=lumped", *changes])), crank)
        np.testing.assert_allclose(each.output_turn, softer.output_turn, rtol=1e-4)
        np.testing.assert_allclose(each.output, softer.output, atol=1e-3 * softer.output.max())


def test_needles_with_clearance_are_in_equilibrium_in_a_rolling_cage() -> None:
    """Force of each roller from its approach, with the cage between core and a roller that rolls in its hole."""
    reducer = at_nominal_torque(override(ROLLERS, ["clearance.output_um=3"]))
    crank = np.array([0.4, 2.9])
    springs = springs_of(reducer, crank, friction=False)
    loads, needles = solve_loads(reducer, springs, reducer.design.load.torque), reducer.at_rated_load.roller_needles
    output, gear = reducer.design.output, reducer.design.gear
    lines = springs.contacts
    # gaps to first order: circles roll by micrometres on an eccentricity of a millimetre
    gaps = lines.clearance + lines.distance + np.einsum("mnu,mu->mn", lines.slope, loads.departures)
    gaps += 0.5 * lines.curvature * (lines.shift + np.einsum("mnu,mu->mn", lines.shift_slope, loads.departures)) ** 2
    needle = 0.35 * 2.0 * (output.pin_radius - output.root_radius)
    bore = output.root_radius + needle
    for row, angle in enumerate(crank):
        carrier = -angle / reducer.design.lobes
        spin = -(gear.eccentricity / output.pin_radius) * (angle - carrier)
        cage = carrier + spin * bore / (output.root_radius + bore)
        push = springs.directions[row, springs.teeth]
        direction = np.arctan2(-push[0], push[1]) - cage
        loaded = np.flatnonzero(loads.output[row] > 0.1 * loads.output.max())
        assert loaded.size >= 2
        for pin in loaded:
            approach = 3e-6 - gaps[row, springs.teeth + pin]
            stiffness = lines.stiffness[row, springs.teeth + pin]
            force, _ = roller_contact(approach, direction, stiffness, needles.needles, needles.stiffness, 3e-6)
            assert loads.output[row, pin] == pytest.approx(force, rel=0.01)


def test_solid_output_pins_have_no_needles_and_mujoco_refuses_them() -> None:
    assert not Reducer(override(ROLLERS, ["output.core_radius_mm=0", "gear.bearing=rolling"])).roller_needles.needles
    with pytest.raises(DesignError, match="output pins with rollers on needles"):
        override(ROLLERS, ["output.roller_bearing=plain"])
    with pytest.raises(DesignError, match="use --solver planar"):
        model_for("mujoco", Reducer(ROLLERS))


@pytest.mark.slow
@pytest.mark.parametrize("clearance_um", [0.001, 3.0])
@pytest.mark.parametrize("has_friction", [False, True])
def test_runs_with_rollers_on_needles_are_those_of_statics(clearance_um: float, has_friction: bool) -> None:
    changes = [f"clearance.output_um={clearance_um}", *([] if has_friction else FRICTIONLESS)]
    design = at_nominal_torque(override(ROLLERS, changes)).design.but(drive={"ramp": 0.0, "hold": 0.03})
    reducer = Reducer(design)
    run = simulate(design, model_for("planar", reducer))
    run = run.select(run.time > 0.012)
    powers, run = mean_powers(run), run.select(slice(0, None, 3))
    static = solve(reducer, run["crank_angle"], has_friction)
    wind_up = run["output_angle"] - reducer.member.output_angle(run["crank_angle"])
    simulated = np.linalg.norm(run.forces("output"), axis=-1)
    assert abs(wind_up.mean()) == pytest.approx(abs(static.output_turn.mean()), rel=5e-3)
    assert simulated.max() == pytest.approx(static.output.max(), rel=0.01)
    assert simulated.sum(axis=1).mean() == pytest.approx(static.output.sum(axis=1).mean(), rel=5e-3)
    assert abs(powers.missing) < 1e-4 * powers.supplied
