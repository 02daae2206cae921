"""Cams with a spring for each roller: against closed forms, the single spring of the bearing, and the planar solver."""

from pathlib import Path

import numpy as np
import pytest

from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.powers import mean_powers
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, Design, dump, loads, override
from cycloid_mj.dynamics.run import model_for, simulate
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import Loads, springs_of
from cycloid_mj.statics import loads as solve_loads
from cycloid_mj.statics.cam_needles import CamNeedles

COULOMB = override(PRESETS["pin"], ['friction.law="coulomb"', 'ring.pins="fixed"', "environment.gravity_y_m_s2=0"])
TWO_DISCS = override(PRESETS["twodisc"], ['friction.law="coulomb"', 'ring.pins="fixed"'])
TIGHT = 1e-9
FRICTIONLESS = [
    f"friction.{pair}=0" for pair in ("pin_gear", "pin_socket", "output", "output_rolling", "cam", "cam_rolling")
]


def with_rollers(design: Design, clearance: float, needles: str = "each", rollers: int = 20) -> Reducer:
    """A design at its nominal torque, with a radial clearance of the cam [m]."""
    changed = design.but(contact={"needles": needles, "cam_rollers": rollers}, clearance={"cam": clearance})
    return Reducer(changed.but(load={"torque": changed.rated_torque}))


def solve(reducer: Reducer, friction: bool = False, angles: int = 61) -> Loads:
    crank = np.linspace(0.0, 2.0 * np.pi, angles)
    return solve_loads(reducer, springs_of(reducer, crank, friction=friction), reducer.design.load.torque)


def deflected(displacement: float, clearance: float, rollers: int) -> tuple[float, float]:
    """Force [N] on a bearing of stiffness 1 N/m and on its most loaded roller, at a displacement along +y [m]."""
    angles = 2.0 * np.pi * np.arange(rollers) / rollers
    directions = np.stack([-np.sin(angles), np.cos(angles)], axis=-1)[np.newaxis]
    bearing = CamNeedles(directions, 4.0 / rollers, np.inf, np.ones((1, 1)))
    forces = bearing.stiffness * np.maximum(displacement * directions[:, :, 1] - clearance, 0.0)[:, np.newaxis]
    return float(bearing.resultants(forces)[0, 0, 1]), float(forces.max())


@pytest.mark.parametrize("loaded_half_angle", [0.4, 1.0, np.pi / 2.0])
def test_load_sharing_of_many_rollers_is_that_of_sjovall(loaded_half_angle: float) -> None:
    """The integral of Sjovall for linear springs: F = (2 k/pi) d (psi - sin psi cos psi), with cos psi = c/d.

    Without clearance, psi = pi/2, the most loaded of Z rollers carries 4 F/Z, the number of Stribeck for linear springs
    (4.08 for line contacts with the exponent 10/9).
    """
    rollers, psi = 1440, loaded_half_angle
    force, largest = deflected(1.0, np.cos(psi), rollers)
    assert force == pytest.approx(2.0 / np.pi * (psi - np.sin(psi) * np.cos(psi)), rel=1e-4)
    stribeck = 2.0 * np.pi * (1.0 - np.cos(psi)) / (psi - np.sin(psi) * np.cos(psi))
    assert largest * rollers / force == pytest.approx(stribeck, rel=1e-4)
    if psi == np.pi / 2.0:
        assert stribeck == pytest.approx(4.0)


@pytest.mark.parametrize("design", [COULOMB, TWO_DISCS], ids=["pin", "twodisc"])
def test_rollers_without_clearance_are_as_stiff_as_the_lumped_bearing(design: Design) -> None:
    """The squared cosines of an even number of rollers on any half of the circle sum up to a quarter of it."""
    lumped, each = solve(with_rollers(design, TIGHT, "lumped")), solve(with_rollers(design, TIGHT))
    largest = np.linalg.norm(lumped.cam, axis=-1).max()
    np.testing.assert_allclose(each.cam, lumped.cam, atol=1e-3 * largest)
    np.testing.assert_allclose(each.output_turn, lumped.output_turn, rtol=1e-4)
    np.testing.assert_allclose(each.teeth, lumped.teeth, atol=1e-3 * lumped.teeth.max())


def test_a_clearance_counts_more_than_in_the_lumped_bearing() -> None:
    """The closed form of the deflection of the cam under its force, on average over a turn of the cage."""
    clearance, reducer = 2e-6, with_rollers(COULOMB, 2e-6)
    crank = np.linspace(0.0, 2.0 * np.pi, 61)
    springs = springs_of(reducer, crank, friction=False)
    found = solve_loads(reducer, springs, reducer.design.load.torque)
    displaced = np.linalg.norm(found.departures[:, :2] - springs.contacts.cam_position[:, 0], axis=1).mean()
    psi = np.arccos(clearance / displaced)
    force = 2.0 / np.pi * springs.contacts.cam_stiffness * displaced * (psi - np.sin(psi) * np.cos(psi))
    assert np.linalg.norm(found.cam, axis=-1).mean() == pytest.approx(force, rel=5e-3)
    lumped = solve(with_rollers(COULOMB, clearance, "lumped"))
    assert found.output_turn.mean() > 1.01 * lumped.output_turn.mean()


def test_forces_of_discs_and_output_balance_with_bent_output_pins() -> None:
    """The cam balances teeth and output pins, whose springs stay in their places next to those of the rollers."""
    reducer = with_rollers(TWO_DISCS.but(structure="springs"), 3e-6)
    found = solve(reducer)
    springs = springs_of(reducer, np.linspace(0.0, 2.0 * np.pi, 61), friction=False)
    forces = np.concatenate([found.teeth, found.output], axis=1)
    total = np.einsum("mn,mnj->mj", forces, springs.directions) + found.cam.sum(axis=1) + springs.body_force.sum(axis=1)
    assert np.abs(total).max() < 2e-3 * np.linalg.norm(found.cam, axis=-1).max()


def test_friction_acts_on_the_resultant_of_the_rollers() -> None:
    """The power that a rolling cam loses is that of its coefficient and the force on it, as for a single spring."""
    lumped, each = (solve(with_rollers(COULOMB, TIGHT, needles), True) for needles in ("lumped", "each"))
    assert np.linalg.norm(each.cam, axis=-1).mean() == pytest.approx(
        np.linalg.norm(lumped.cam, axis=-1).mean(), rel=1e-4
    )
    assert each.output_turn.mean() == pytest.approx(lumped.output_turn.mean(), rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("clearance", [TIGHT, 5e-6], ids=["tight", "loose"])
@pytest.mark.parametrize("has_friction", [False, True])
def test_runs_with_separate_rollers_are_those_of_statics(clearance: float, has_friction: bool) -> None:
    design = override(COULOMB, [] if has_friction else FRICTIONLESS)
    design = with_rollers(design, clearance).design.but(drive={"ramp": 0.0, "hold": 0.03})
    reducer = Reducer(design)
    run = simulate(design, model_for("planar", reducer))
    run = run.select(run.time > 0.012)
    powers, run = mean_powers(run), run.select(slice(0, None, 3))
    springs = springs_of(reducer, run["crank_angle"], friction=has_friction)
    static = solve_loads(reducer, springs, design.load.torque)
    wind_up = run["output_angle"] - reducer.member.output_angle(run["crank_angle"])
    simulated, solved = (np.linalg.norm(force, axis=-1) for force in (run.forces("cam"), static.cam))
    assert abs(wind_up.mean()) == pytest.approx(abs(static.output_turn.mean()), rel=5e-3)
    assert simulated.mean() == pytest.approx(solved.mean(), rel=5e-3)
    assert simulated.max() == pytest.approx(solved.max(), rel=0.01)
    assert abs(powers.missing) < 1e-4 * powers.supplied


def test_plain_cams_and_mujoco_refuse_the_option(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "\nneedles = " not in dump(PRESETS["pin"])
    separate = override(PRESETS["pin"], ["contact.needles=each"])
    assert loads(dump(separate), "pin") == separate
    with pytest.raises(DesignError, match="applies to cams on rollers"):
        override(separate, ["gear.bearing=plain"])
    with pytest.raises(DesignError, match="use --solver planar"):
        model_for("mujoco", Reducer(separate))
    words = ["simulate", "pin", "--set", "contact.needles=each", "--out", str(tmp_path), "--quiet"]
    assert main(words) == 1
    assert "--solver planar" in capsys.readouterr().err
