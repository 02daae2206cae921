"""The suite of `validate`: its references by their own predicates, every rung, and each rung spoiled once.

What simulates for more than a moment is marked slow; there each rung runs once and is judged again with one formula or
sign broken, which must make its row fail.
"""

import functools
import json
import math
import re
from dataclasses import replace
from io import StringIO

import numpy as np
import pytest

from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.base.validation import ValidationRow, absolute, deviation_row, relative
from cycloid_mj.cli import main
from cycloid_mj.cli.validate import validate
from cycloid_mj.design import PRESETS
from cycloid_mj.dynamics import law
from cycloid_mj.geometry import envelope, ideal_loads, kinematics, profile
from cycloid_mj.geometry.profile import CycloidGear, unit
from cycloid_mj.parts import mass_properties
from cycloid_mj.parts.gear import tooth_profile
from cycloid_mj.reducer import Reducer, limits
from cycloid_mj.statics.friction import ideal_losses
from cycloid_mj.validate import (
    backlash,
    balance,
    cam_load,
    energy,
    equilibrium,
    gaps,
    incline,
    mechanism,
    published,
    rig,
    sharing,
    steps,
    suite,
    symmetry,
    two_bodies,
)
from cycloid_mj.validate.rig import FIXED, FREE, KINDS

PAPER = CycloidGear(ring_teeth=36, eccentricity=1e-3, pin_circle_radius=40.75e-3, pin_radius=2.25e-3)


def failed(rows) -> list[str]:
    """Quantities of the rows that fail."""
    return [row.measured.name for row in rows if row.verdict == "fail"]


# --- rows -------------------------------------------------------------------------------------------------------------


def test_a_row_passes_up_to_its_bound_and_states_without_one():
    assert relative("q", 101.0, 100.0, "N", "s", 1.01).verdict == "pass"
    assert relative("q", 101.0, 100.0, "N", "s", 0.99).verdict == "fail"
    assert relative("q", 101.0, 100.0, "N", "s", None).verdict == "stated"
    assert (
        absolute("q", 88.0, 88.5, "%", "s", 0.4).as_json() | {"verdict": "fail", "error_unit": "points"}
        == absolute("q", 88.0, 88.5, "%", "s", 0.4).as_json()
    )


@pytest.mark.parametrize("ours", [math.nan, math.inf])
def test_a_nan_fails(ours):
    assert relative("q", ours, 1.0, "", "s", 1e9).verdict == "fail"
    assert absolute("q", ours, 1.0, "", "s", 1e9).verdict == "fail"
    assert relative("q", 1.0, 0.0, "", "s", 1e9).verdict == "fail"


def test_a_deviation_is_the_largest_difference_over_the_largest_reference():
    ours, reference = np.array([[3.0, 4.0], [0.0, 1.0]]), np.array([[3.0, 4.0], [0.5, 1.0]])
    row = deviation_row("q", ours, reference, "N", "s", 10.0)
    assert (row.measured.value, row.measured.reference, row.difference) == pytest.approx((5.0, 5.0, 10.0))
    assert deviation_row("q", np.array([1.0, -2.0]), np.array([1.0, -2.5]), "N", "s", 10.0).difference == pytest.approx(
        20.0
    )


# --- the independent static solution ----------------------------------------------------------------------------------


@pytest.mark.parametrize("crank", [0.0, 0.4, 1.7, 5.9])
def test_every_gap_of_the_ideal_mesh_is_closed(crank):
    pose = gaps.GearPose(kinematics.gear_centre(PAPER, crank), float(kinematics.gear_rotation(PAPER, crank)))
    found = gaps.ring_gaps(PAPER, pose, np.arange(36))
    touching = np.abs(found.distance) < 1e-9
    roots = envelope.sigma_contacts(PAPER, crank)
    assert np.count_nonzero(touching & np.isnan(found.B)) == 36
    on_roots = touching & ~np.isnan(found.B)
    assert np.sort(found.B[on_roots]) == pytest.approx(np.sort(roots.B), abs=3e-4)
    assert found.distance[touching] == pytest.approx(np.zeros(touching.sum()), abs=1e-12)
    contacts = envelope.arc_contacts(PAPER, crank)
    assert found.normals[:36] == pytest.approx(-contacts.normals, abs=1e-9)


def test_a_gap_changes_by_the_motion_along_its_normal():
    crank, shift, turn = 0.7, np.array([2e-7, -3e-7]), 4e-6
    centres = PAPER.pin_circle_radius * unit(profile.pin_angles(PAPER))
    centre, angle = kinematics.gear_centre(PAPER, crank), float(kinematics.gear_rotation(PAPER, crank))
    before = gaps.pin_gaps(PAPER, gaps.GearPose(centre, angle), centres)
    after = gaps.pin_gaps(PAPER, gaps.GearPose(centre + shift, angle + turn), centres)
    arms = profile.moment_arm(PAPER, profile.pin_angles(PAPER) + crank)
    # The gear's turn about its centre closes the gaps of the contacts whose push would turn it back.
    expected = -before.normals @ shift + turn * arms
    # Second order: the curvature of the trochoid is up to 1/18 um in its valleys.
    assert after.distance - before.distance == pytest.approx(expected, abs=5e-9)


LOADED = (*rig.without_friction(), *rig.without_gravity(), "load.torque_nm=36.0")
STIFFNESS = {"pin_gear": 3e8, "pin_socket": 6e8, "tooth": 3e8, "cam": 8e8, "output": 4e8}


@pytest.mark.parametrize("kind", KINDS)
def test_residual_is_the_gradient_of_the_energy(kind):
    design = rig.design_of_kind(kind, *LOADED)
    locked = equilibrium._make_locked_reducer(Reducer(design), STIFFNESS, 0.3)
    rng = np.random.default_rng(4)
    z = 3e-6 * rng.standard_normal(locked.load.size)
    direction = rng.standard_normal(locked.load.size)
    step = 1e-10
    slope = np.diff([equilibrium._energy(locked, z + sign * step * direction) for sign in (-1, 1)])[0] / (2 * step)
    balance = equilibrium._residual_force(locked, z, uniform=True)
    assert slope == pytest.approx(-balance @ direction, rel=1e-5)


def test_without_clearance_the_static_solution_shares_the_load_ideally():
    design = rig.design_of_kind(FIXED, *sharing.IDEAL)
    soft = dict.fromkeys(STIFFNESS, 1e7) | {"cam": 1e12}
    solved = equilibrium.solve(Reducer(design), soft, 0.3)
    ideal = sharing.ideal_forces(Reducer(design), 0.3)
    assert solved.ring_forces == pytest.approx(ideal, abs=2e-3 * rig.vector_lengths(ideal).max())
    tangential = kinematics.gear_centre_velocity(tooth_profile(design), 0.3, 1.0) / design.gear.eccentricity
    share = design.load.torque / (design.gear.eccentricity * design.lobes)
    assert solved.cam_force @ tangential == pytest.approx(share, rel=2e-3)


def test_an_unsolvable_equilibrium_is_reported(monkeypatch):
    monkeypatch.setattr(equilibrium, "_RESIDUAL_RTOL", 0.0)
    with pytest.raises(RunError, match="no static equilibrium"):
        equilibrium.solve(Reducer(rig.design_of_kind(FIXED, *LOADED)), STIFFNESS, 0.3)


# --- rungs that take a moment -----------------------------------------------------------------------------------------


def test_two_bodies_pass():
    rows = two_bodies.rows(True)
    assert failed(rows) == []
    assert {row.verdict for row in rows} == {"pass", "stated"}


@pytest.mark.parametrize(
    ("spoiled", "victim"),
    [
        (lambda law: replace(law, stiffness=1.005 * law.stiffness), "penetration"),
        (lambda law: replace(law, damping=1.05 * law.damping), "restitution"),
        (lambda law: replace(law, added_mass=1.05 * law.added_mass), "added mass"),
    ],
)
def test_two_bodies_fail_with_a_spoiled_law(monkeypatch, spoiled, victim):
    honest = two_bodies.solver_parameters
    monkeypatch.setattr(two_bodies, "solver_parameters", lambda law, weight: honest(spoiled(law), weight))
    assert any(victim in quantity for quantity in failed(two_bodies.rows(True)))


def test_friction_validation_passes():
    assert failed(incline.rows(True)) == []


@pytest.mark.parametrize(
    ("spoiled", "victim"),
    [
        (lambda law: replace(law, friction=1.03 * law.friction), "above"),
        (lambda law: replace(law, creep=1.03 * law.creep), "creep"),
        (lambda law: replace(law, creep=1.03 * law.creep), "slip"),
        (lambda law: replace(law, friction=0.1 * law.friction), "rolling"),
    ],
)
def test_friction_fails_with_a_spoiled_law(monkeypatch, spoiled, victim):
    honest = incline.solver_parameters
    monkeypatch.setattr(incline, "solver_parameters", lambda law, weight: honest(spoiled(law), weight))
    assert any(victim in quantity for quantity in failed(incline.rows(True)))


def test_published_stresses_pass_and_fail_when_spoiled(monkeypatch):
    assert failed(published.hertz_rows(True)) == []
    assert len(published.hertz_rows(True)) == 9
    honest = profile.curvature
    monkeypatch.setattr(published.profile, "curvature", lambda gear, t: -honest(gear, t))
    assert len(failed(published.hertz_rows(True))) == 6
    monkeypatch.setattr(published.profile, "curvature", honest)
    monkeypatch.setattr(published.ideal_loads, "contact_modulus", lambda young, poisson: young / (2 * (1 + poisson**2)))
    assert len(failed(published.hertz_rows(True))) == 9


def test_the_efficiency_formula_reproduces_its_printed_results():
    for case in published.WANG:
        assert published.total_efficiency(case) == pytest.approx(case.printed, abs=case.rounding)
    assert published.total_efficiency(replace(published.WANG[0], mesh_friction=0.051)) != pytest.approx(
        0.8947, abs=0.5e-4
    )


def test_wangs_formula_is_the_closed_form_without_the_moment_of_friction():
    case = published.WANG[0]
    design = published.wang_design(case, True)
    crank = np.linspace(0.0, 2 * np.pi, 441)
    gear, load = tooth_profile(design), design.load.torque
    B = profile.pin_angles(gear) + crank[:, None]
    forces = ideal_loads.ideal_load_sharing(gear, load, crank).forces
    plain = 0.05 * np.sum(forces * (profile.pitch_distance(gear, B) - gear.pin_radius), axis=1).mean() / load
    assert 1 / (1 + plain) == pytest.approx(published.mesh_efficiency(case), abs=2e-4)
    mesh, output, cam = ideal_losses(Reducer(design), crank, 0.05)
    assert mesh > plain
    assert cam == 0.0
    assert 1 / (1 + output) == pytest.approx(published.output_efficiency(case), abs=5e-4)


# --- the step study's judgement ---------------------------------------------------------------------------------------

FIGURES = steps.StepFigures(gear_speed=2.0, mean_error=21.0, peak_to_peak=0.24, cam_force=1250.0, efficiency=89.0)


def test_the_order_is_found_where_there_is_one():
    for order in (1.0, 2.0, 3.5):
        values = tuple(7.0 - 2.0 * step**order for step in (1.0, 2.0, 5.0))
        assert steps.observed_order((1.0, 2.0, 5.0), values) == pytest.approx(order, abs=1e-9)
    assert math.isnan(steps.observed_order((1.0, 2.0, 5.0), (1.0, 1.1, 1.05)))


@pytest.mark.parametrize(
    ("name", "within", "beyond"),
    [
        ("gear_speed", 2.0039, 2.0041),
        ("mean_error", 21.0008, 21.0009),
        ("peak_to_peak", 0.2401, 0.2402),
        ("cam_force", 1249.98, 1249.97),
        ("efficiency", 89.0002, 88.9996),
    ],
)
def test_a_step_up_to_the_default_is_judged(name, within, beyond):
    good = {1.0: FIGURES, 2.0: replace(FIGURES, **{name: within})}
    bad = {1.0: FIGURES, 2.0: replace(FIGURES, **{name: beyond})}
    assert failed(steps.judge_study(FIXED, good, 4.0)) == []
    assert len(failed(steps.judge_study(FIXED, bad, 4.0))) == 1
    assert failed(steps.judge_study(FIXED, bad, 1.0)) == []


@pytest.mark.parametrize(("kind", "bound"), [(FIXED, 1.2), (FREE, 6.0)])
def test_the_automatic_step_has_separate_bounds(kind, bound):
    def study(error):
        return {1.0: FIGURES, 2.0: replace(FIGURES, peak_to_peak=FIGURES.peak_to_peak * (1.0 + error / 100.0))}

    assert failed(steps.judge_study(kind, study(0.99 * bound), 2.0)) == []
    assert len(failed(steps.judge_study(kind, study(1.01 * bound), 2.0))) == 1


def test_a_run_that_fails_is_judged_by_its_step():
    study = {1.0: FIGURES, 2.0: FIGURES, 20.0: RunError("a contact is 60 um deep")}
    rows = steps.judge_study(FREE, study, 2.0)
    assert failed(rows) == []
    assert any("60 um deep" in row.measured.note for row in rows)
    assert len(failed(steps.judge_study(FREE, study, 20.0))) == 1
    with pytest.raises(RunError, match="deep"):
        steps.judge_study(FREE, {1.0: RunError("a contact is deep"), 2.0: FIGURES}, 2.0)


def test_friction_that_leads_by_too_much_is_reported_under_a_light_load(monkeypatch):
    assert failed(steps.light_load_rows(FIXED)) == []
    monkeypatch.setattr("cycloid_mj.dynamics.mjcf.model.impratio", lambda *_: 60.0 * law.FRICTION.impratio)
    assert len(failed(steps.light_load_rows(FIXED))) == 2


# --- the suite and its command ---------------------------------------------------------------------------------------


def test_every_step_has_parts():
    assert {part.rung for part in suite.PARTS} == set(suite.STEP_NAMES)
    assert {part.rung for part in suite.select_parts(["steps", "cam"])} == {"steps", "cam"}
    with pytest.raises(UsageError, match="two-body, friction"):
        suite.select_parts(["stepps"])
    steps = " ".join(str(validate.__doc__).split()).partition("simple to complex: ")[2].partition(". ")[0]
    assert re.sub(r" \([^)]*\)", "", steps).split(", ") == list(suite.STEP_NAMES)


def test_a_part_that_cannot_run_fails_alone():
    def broken(quick: bool) -> list[ValidationRow]:
        raise RunError("the gear jumped a tooth")

    def sound(quick: bool) -> list[ValidationRow]:
        return [absolute("sound", 1.0, 1.0, "", "s", 0.0)]

    parts = (suite.ValidationPart("cam", broken, (2.0, 2.0)), suite.ValidationPart("energy", sound, (1.0, 1.0)))
    rows = suite.sort_rows(suite.run_parts(parts, quick=True, workers=1))
    assert [(row.rung, row.verdict) for row in rows] == [("cam", "fail"), ("energy", "pass")]
    assert rows[0].measured.note == "the gear jumped a tooth"


def told(monkeypatch, *argv: str) -> tuple[int, str, str]:
    out, err = StringIO(), StringIO()
    monkeypatch.setattr("sys.stdout", out)
    monkeypatch.setattr("sys.stderr", err)
    return main(["validate", *argv]), out.getvalue(), err.getvalue()


def test_the_command_prints_table_notes_and_sum(monkeypatch):
    code, out, err = told(monkeypatch, "--quick", "--only", "friction")
    assert code == 0
    assert "2/3 g sin" in out
    assert out.splitlines()[-1].startswith("4 pass, 0 fail, 0 stated")
    assert "1 of 1 parts" in err


def test_the_command_fails_with_a_row(monkeypatch):
    honest = incline.solver_parameters
    spoil = lambda law, weight: honest(replace(law, friction=1.03 * law.friction), weight)  # noqa: E731
    monkeypatch.setattr(incline, "solver_parameters", spoil)
    code, out, _ = told(monkeypatch, "--only", "friction", "--json")
    found = json.loads(out)
    assert code == 1
    assert found["passed"] is False
    assert {row["verdict"] for row in found["rows"]} >= {"fail"}
    assert list(found["rows"][0]) == [
        *("quantity", "ours", "reference", "unit", "source", "error", "error_unit", "bound", "note", "rung", "verdict")
    ]


def test_the_command_names_the_rungs_there_are(monkeypatch):
    code, out, err = told(monkeypatch, "--only", "frcition")
    assert (code, out) == (2, "")
    assert "two-body" in err


# --- rungs that simulate ----------------------------------------------------------------------------------------------


@pytest.fixture
def remembered(monkeypatch):
    """Keep runs, so that a rung judged again does not simulate again."""
    for room, name in [
        (sharing, "settled_run"),
        (cam_load, "_ideal_run"),
        (published, "wang_run"),
        (backlash, "stop_angles"),
    ]:
        monkeypatch.setattr(room, name, functools.cache(getattr(room, name)))
    shared = functools.cache(rig.rated_run)
    for room in (rig, symmetry, steps):
        monkeypatch.setattr(room, "rated_run", shared)


@pytest.mark.slow
def test_backlash(remembered, monkeypatch):
    assert failed(backlash.rows(True)) == []
    honest = backlash.closed_form_backlash
    monkeypatch.setattr(backlash, "closed_form_backlash", lambda design, kind: honest(design, kind) * 35.0 / 36.0)
    assert len(failed(backlash.rows(True))) == 3


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_ideal_sharing(kind, remembered, monkeypatch):
    assert failed(sharing.ideal_rows(kind, True)) == []
    honest = profile.moment_arm
    monkeypatch.setattr(profile, "moment_arm", lambda gear, B: honest(gear, 1.02 * B))
    assert len(failed(sharing.ideal_rows(kind, True))) == 1


@pytest.mark.slow
def test_patches_are_not_whole_springs(remembered, monkeypatch):
    assert failed(sharing.patch_rows(True)) == []
    monkeypatch.setattr(sharing, "_patch_weights", lambda design, crank: 1.0)
    assert len(failed(sharing.patch_rows(True))) == 1


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_sharing_with_clearance(kind, remembered, monkeypatch):
    assert failed(sharing.clearance_rows(kind, True)) == []
    honest = equilibrium.profile_offset
    with monkeypatch.context() as spoiled:
        spoiled.setattr(equilibrium, "profile_offset", lambda design: honest(design) + 0.1e-6)
        assert any(quantity.startswith("turn") for quantity in failed(sharing.clearance_rows(kind, True)))
    honest_law = equilibrium.tooth_stiffness
    monkeypatch.setattr(equilibrium, "tooth_stiffness", lambda *given: 1.1 * honest_law(*given))
    assert failed(sharing.clearance_rows(kind, True))


@pytest.mark.slow
def test_cam_load(remembered, monkeypatch):
    assert failed(cam_load.rows(True)) == []
    with monkeypatch.context() as spoiled:
        spoiled.setattr(ideal_loads, "ideal_output_forces", lambda *given: np.zeros((1, 8)))
        assert len(failed(cam_load.rows(True))) == 2
    with monkeypatch.context() as spoiled:
        spoiled.setattr(kinematics, "gear_centre_acceleration", lambda *given: 0.0)
        assert len(failed(cam_load.rows(True))) == 2
    honest = cam_load.body_force
    monkeypatch.setattr(cam_load, "body_force", lambda *given: -honest(*given))
    assert len(failed(cam_load.rows(True))) == 3


def test_the_printed_drive_reaches_its_stops_and_fails_when_spoiled(monkeypatch):
    drawn, bench = published.printed_drive_rows(True)
    assert (drawn.verdict, bench.verdict) == ("pass", "stated")
    # the authors' play is about twice what their drawing gives
    assert bench.measured.reference / bench.measured.value == pytest.approx(1.24 / 0.669, rel=0.01)
    spoiled = PRESETS["printed"].but(clearance={"cam": 11e-6})
    programme = limits.stops
    monkeypatch.setattr(
        published.limits, "stops", lambda _, *rest, **sides: programme(Reducer(spoiled), *rest, **sides)
    )
    assert failed(published.printed_drive_rows(True)) == ["backlash of a printed drive"]


@pytest.mark.slow
def test_efficiency(remembered, monkeypatch):
    assert failed(published.efficiency_rows(True)) == []
    with monkeypatch.context() as spoiled:
        honest = profile.pitch_distance
        spoiled.setattr(profile, "pitch_distance", lambda gear, B: honest(gear, B) + gear.pin_radius)
        assert len(failed(published.efficiency_rows(True))) == 2
    monkeypatch.setattr(published, "WANG", [replace(case, sleeve_wall=4.0) for case in published.WANG])
    assert len(failed(published.efficiency_rows(True))) == 2


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_energy(kind, monkeypatch):
    kept = functools.cache(energy.simulate)
    monkeypatch.setattr(energy, "simulate", kept)
    assert failed(energy.rows(kind, True)) == []
    honest = energy.balance
    for name in ("friction", "stored", "delivered"):
        monkeypatch.setattr(energy, "balance", lambda run, name=name: replace(honest(run), **{name: 0.0}))
        assert len(failed(energy.rows(kind, True))) == 1


@pytest.mark.slow
def test_the_energy_of_pins_at_the_edges_of_their_sockets(monkeypatch):
    kept = functools.cache(energy.simulate)
    monkeypatch.setattr(energy, "simulate", kept)
    assert failed(energy.idle_rows(True)) == []
    honest, runs = energy.balance, []
    monkeypatch.setattr(energy, "balance", lambda run: runs.append(run) or replace(honest(run), friction=0.0))
    assert len(failed(energy.idle_rows(True))) == 1
    # the premise: pins do leave the walls, by several clearances
    assert max(np.hypot(runs[0][f"pin_{pin}_x"], runs[0][f"pin_{pin}_y"]).max() for pin in range(1, 37)) > 4e-6


@pytest.mark.slow
def test_the_work_of_the_normal_forces(monkeypatch):
    monkeypatch.setattr(energy, "simulate", functools.cache(energy.simulate))
    assert failed(energy.jolt_rows(True)) == []
    honest = energy.balance
    monkeypatch.setattr(energy, "balance", lambda run: replace(honest(run), stored=1e-3))
    assert len(failed(energy.jolt_rows(True))) == 1


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_mirror(kind, remembered, monkeypatch):
    assert failed(symmetry.mirror_rows(kind, True)) == []
    honest = symmetry.rated_run

    def one_sided(kind: str, rpm: float, *given):
        return honest(kind, rpm, *given, *(["environment.gravity_x_m_s2=100.0"] if rpm < 0 else []))

    monkeypatch.setattr(symmetry, "rated_run", one_sided)
    assert any("ripple" in quantity for quantity in failed(symmetry.mirror_rows(kind, True)))


@pytest.mark.slow
def test_gravity(remembered, monkeypatch):
    assert failed(symmetry.gravity_rows(FIXED, True)) == []
    with monkeypatch.context() as spoiled:
        spoiled.setattr(symmetry, "mass_properties", lambda solid: replace(mass_properties(solid), mass=0.25))
        assert len(failed(symmetry.gravity_rows(FIXED, True))) == 2
    honest = symmetry.first_harmonic
    monkeypatch.setattr(symmetry, "first_harmonic", lambda *given: honest(*given).conjugate())
    assert any("ripple" in quantity for quantity in failed(symmetry.gravity_rows(FIXED, True)))


@pytest.mark.slow
def test_the_quick_ladder_passes(monkeypatch):
    code, out, _ = told(monkeypatch, "--quick", "--json")
    found = json.loads(out)
    assert code == 0
    assert found["passed"] is True
    assert {row["rung"] for row in found["rows"]} == set(suite.STEP_NAMES)


@pytest.mark.parametrize("part", [*mechanism.STATICS, *mechanism.MODELS, *balance.STATICS])
def test_every_row_of_the_mechanism_passes(part) -> None:
    for row in part():
        assert row.verdict == "pass", row
