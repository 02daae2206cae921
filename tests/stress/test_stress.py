"""Loads on the parts from the forces of a run, closed forms, the study, the paper's claims, figures and the command."""

import json
import math
import re
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import commands
import numpy as np
import pytest
from hsieh2014 import PAPER
from hsieh2014.one_run import claims
from hsieh2014.stated import is_ours, stress_references
from made_run import TORQUE, made_run

from cycloid_mj.base.array import cross
from cycloid_mj.base.errors import LogError, UsageError
from cycloid_mj.base.names import gears
from cycloid_mj.cli import stress as command
from cycloid_mj.cli.terminal import say_table
from cycloid_mj.comparison import settling_time
from cycloid_mj.design import PRESETS, dump, override
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.figures import figure
from cycloid_mj.geometry.envelope import arc_contacts
from cycloid_mj.geometry.ideal_loads import contact_modulus, hertz_line_contact, ideal_load_sharing
from cycloid_mj.geometry.kinematics import gear_centre_acceleration
from cycloid_mj.geometry.profile import conjugate_point, curvature, pin_angles, unit
from cycloid_mj.log import write
from cycloid_mj.parts import mass_properties, output_centres, parts
from cycloid_mj.parts.gear import tooth_profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.stress.closed import largest_von_mises, line_stress, von_mises_below
from cycloid_mj.stress.contacts import Action, list_contacts, rotate_vectors
from cycloid_mj.stress.figures import for_one_turn
from cycloid_mj.stress.findings import PartFindings, Peak, Refinement, StressFindings
from cycloid_mj.stress.loads import PARTS, part_loads, part_names
from cycloid_mj.stress.notch import Notch
from cycloid_mj.stress.study import StudySettings, corner_distance_change
from cycloid_mj.stress.table import BULK_HEADER, CONTACT_HEADER, bulk_table, contact_table
from cycloid_mj.stress.turn import select_turn

PIN, NONPIN = (override(PRESETS[name], ["drive.ramp_s=0.0"]) for name in ("pin", "nonpin"))
SOME = np.radians(np.arange(0.0, 360.0, 7.0))
QUARTERS = np.radians([0.0, 90.0, 180.0, 270.0])
LOADED = (
    *("drive.ramp_s=0.0", "drive.hold_s=0.047", "load.torque_nm=36.68", "load.rise_s=0.002"),
    "settings.log_rate_hz=20000.0",
)


def fem():
    """Whether the extra `fem` is there; gmsh also needs libraries of the system."""
    try:
        import gmsh  # noqa: F401
        import skfem  # noqa: F401
    except (ImportError, OSError):
        return False
    return True


needs_fem = pytest.mark.skipif(not fem(), reason="the extra fem is not installed")


@pytest.fixture(scope="module")
def pin_run():
    """A real run of the pin design, half a turn longer than a turn after the load has come on."""
    return simulate(override(PIN, LOADED))


@pytest.fixture(scope="module")
def nonpin_run():
    return simulate(override(NONPIN, LOADED))


def runs(request, kind):
    run = request.getfixturevalue(f"{kind}_run")
    return run, PRESETS[kind]


def patch_moments(loads, circles):
    """Moments about the origin of elliptical patches, (k, m), by adding up tractions that turn with the surface.

    `circles` are the centres of the surfaces' circles, (m, 2).
    """
    u = np.cos((np.arange(200) + 0.5) * np.pi / 200)
    weight = np.sqrt(1 - u**2) * np.sin(np.arccos(u))
    out = np.where(np.isnan(loads.position), 1.0, loads.position - circles)
    turned = loads.half_width / np.linalg.norm(out, axis=-1) * u[:, np.newaxis, np.newaxis]
    spin = np.exp(1j * turned)
    arm = (out[..., 0] + 1j * out[..., 1]) * spin
    traction = weight[:, np.newaxis, np.newaxis] * spin
    traction = traction / traction.sum(axis=0) * (loads.force[..., 0] + 1j * loads.force[..., 1])
    return np.sum((np.conj(arm) * traction).imag, axis=0) + cross(circles, loads.force)


def circles_of(loads, design):
    """Centres of the circles that a part's wide patches lie on; narrow ones act where they are."""
    nothing = np.zeros((len(loads.labels), 2))
    if loads.part == "shaft":
        nothing[:] = 0.0, design.gear.eccentricity
    if loads.part == "ring" and design.ring.kind == "pin":
        return design.ring.pin_circle_radius * unit(pin_angles(tooth_profile(design)))
    if loads.part in ("gear", "output"):
        nothing[-design.output.pins :] = output_centres(Reducer(design))
    return nothing


def moments(loads, design):
    """Moments about the origin [N m], (k, m): of the forces on flanks where they act, of others by their patches."""
    flank = np.array([name.startswith(("pin_", "lobe_")) for name in loads.labels])
    at_place = np.nan_to_num(cross(loads.position, loads.force))
    return np.where(flank, at_place, patch_moments(loads, circles_of(loads, design)))


def resultant(loads, design):
    """Forces and moment about the origin that loads, weight and inertia leave on a part, (k, 3)."""
    body = mass_properties(parts(Reducer(design))[{"pin_1": "pin"}.get(loads.part, loads.part)])
    force = loads.force.sum(axis=1) + body.mass * loads.body_force
    moment = moments(loads, design).sum(axis=1) - body.inertia[2, 2] * loads.spin_rate
    return np.column_stack([force, moment])


# Where a force acts


def test_the_line_of_action_meets_the_circle_on_the_loaded_side():
    rng = np.random.default_rng(1)
    centre, angle, slip = rng.normal(size=(50, 2)), rng.uniform(0, 2 * np.pi, 50), rng.uniform(-0.3, 0.3, 50)
    normal = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    place = centre + 0.7 * normal
    force = 30.0 * np.stack([np.cos(angle + slip), np.sin(angle + slip)], axis=1)
    action = Action(force, cross(place, force))
    assert action.on_hole(centre, 0.7) == pytest.approx(place, abs=1e-12)
    assert action.reaction().on_disc(centre, 0.7) == pytest.approx(place, abs=1e-12)
    assert np.abs(action.on_disc(centre, 0.7) - place).max() > 1.0


def test_the_line_of_action_is_the_same_in_another_frame():
    force, place = np.array([[3.0, -1.0]]), np.array([[0.2, 0.5]])
    origin, angle = np.array([[0.4, -0.3]]), np.array([0.7])
    seen = Action(force, cross(place, force)).in_frame(origin, angle)
    turned = np.array([[np.cos(0.7), np.sin(0.7)], [-np.sin(0.7), np.cos(0.7)]])
    assert seen.force == pytest.approx(force @ turned.T)
    assert seen.moment == pytest.approx(cross((place - origin) @ turned.T, seen.force))


def test_no_force_has_no_place():
    action = Action(np.zeros((1, 2)), np.zeros(1))
    assert np.isnan(action.on_disc(np.zeros(2), 1.0)).all()


# Loads of a run by the closed form


def test_loads_of_the_ideal_mesh_are_where_and_as_large_as_statics_says():
    run = made_run(PIN, scale=0.0)
    loads = part_loads(run, Reducer(PIN), "gear", QUARTERS)
    gear = tooth_profile(PIN)
    angle = select_turn(run, Reducer(PIN), QUARTERS)["crank_angle"]
    size = np.linalg.norm(loads.force[:, : gear.ring_teeth], axis=-1)
    assert size == pytest.approx(ideal_load_sharing(gear, np.full(4, TORQUE), angle).forces, abs=1e-9)
    touched = conjugate_point(gear, pin_angles(gear), -angle[:, np.newaxis]).gear_frame
    loaded = size > 0.0
    assert loads.position[:, : gear.ring_teeth][loaded] == pytest.approx(touched[loaded], abs=1e-9)
    assert np.isnan(loads.position[:, : gear.ring_teeth][~loaded]).all()


def test_a_wrong_moment_moves_the_place():
    run = made_run(PIN, scale=0.0)
    spoiled = replace(run, columns={**run.columns, "pin_30_moment": run["pin_30_moment"] + 1e-3})
    places = [part_loads(one, Reducer(PIN), "gear", QUARTERS).position[:, 29] for one in (run, spoiled)]
    assert np.nanmax(np.abs(places[0] - places[1])) > 1e-6


def test_lobes_press_on_the_flank_at_the_contact_of_the_arcs():
    run = made_run(NONPIN, scale=0.0)
    loads = part_loads(run, Reducer(NONPIN), "ring", QUARTERS)
    gear = tooth_profile(NONPIN)
    for row, angle in enumerate(select_turn(run, Reducer(NONPIN), QUARTERS)["crank_angle"]):
        loaded = np.linalg.norm(loads.force[row], axis=-1) > 0.0
        # the flank lies a clearance deeper in the gear than the arc
        assert loads.position[row][loaded] == pytest.approx(arc_contacts(gear, float(angle)).points[loaded], abs=1.1e-6)


def test_half_widths_follow_the_flank():
    run = made_run(PIN, scale=0.0)
    loads = part_loads(run, Reducer(PIN), "gear", QUARTERS)
    gear, material = tooth_profile(PIN), PIN.material
    modulus = contact_modulus(material.youngs_modulus, material.poisson)
    angle = select_turn(run, Reducer(PIN), QUARTERS)["crank_angle"]
    t = pin_angles(gear) - angle[:, np.newaxis] / gear.lobes
    bend = curvature(gear, t, gear.pin_radius + PIN.clearance.pin_gear) + 1.0 / gear.pin_radius
    size = np.linalg.norm(loads.force[:, : gear.ring_teeth], axis=-1)
    b = hertz_line_contact(size, PIN.gear.face_width, bend, modulus).half_width
    narrow = b < 1e-3
    assert loads.half_width[:, : gear.ring_teeth][narrow] == pytest.approx(b[narrow], rel=1e-9)


# Loads of a real run


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "part"), [("pin", "gear"), ("pin", "pin_1"), ("nonpin", "gear")])
def test_free_parts_are_in_balance(request, kind, part):
    run, design = runs(request, kind)
    loads = part_loads(run, Reducer(design), part, SOME)
    largest = np.linalg.norm(loads.force, axis=-1).max()
    left = resultant(loads, design) / largest
    reach = design.gear.bore_radius if part == "gear" else design.ring.pin_radius
    assert np.abs(left[:, :2]).max() < 1e-3
    assert np.abs(left[:, 2]).max() < 1e-4 * reach
    # the loads of inertia are needed for it in the gear
    still = replace(loads, body_force=np.zeros_like(loads.body_force))
    assert part == "pin_1" or np.abs(resultant(still, design)[:, :2] / largest).max() > 2e-3


@pytest.mark.parametrize("kind", ["pin", pytest.param("nonpin", marks=pytest.mark.slow)])
def test_the_acceleration_of_the_gear_is_the_closed_form_plus_vibration(request, kind):
    """The acceleration comes from the logged forces; the closed form is a second way to it."""
    run, design = runs(request, kind)
    sampled, loads = select_turn(run, Reducer(design)), part_loads(run, Reducer(design), "gear")
    accelerated = gear_centre_acceleration(tooth_profile(design), sampled["crank_angle"], sampled["crank_speed"])
    gravity = [design.environment.gravity_x, design.environment.gravity_y]
    free = rotate_vectors(gravity - accelerated, -sampled["gear_angle"])
    mass = mass_properties(parts(Reducer(design))["gear"]).mass
    largest = np.linalg.norm(loads.force, axis=-1).max()
    vibration = mass * np.linalg.norm(free - loads.body_force, axis=-1)
    assert np.sqrt(np.mean(vibration**2)) < 1.5e-3 * largest
    heavy = np.linalg.norm(2 * mass * free - mass * loads.body_force, axis=-1)
    assert np.sqrt(np.mean(heavy**2)) > 4e-3 * largest


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pin", "nonpin"])
def test_every_patch_has_the_moment_of_its_force(request, kind):
    run, design = runs(request, kind)
    for part in part_names(Reducer(design)):
        loads = part_loads(run, Reducer(design), part, SOME)
        of_contacts = np.stack(
            [one.action.moment for one in list_contacts(select_turn(run, Reducer(design), SOME), part)], axis=1
        )
        assert moments(loads, design) == pytest.approx(of_contacts, abs=1e-6)
        assert np.array_equal(np.isnan(loads.position[..., 0]), np.linalg.norm(loads.force, axis=-1) == 0.0)


def test_actions_are_opposite_to_reactions(request):
    run, design = runs(request, "pin")
    gear, shaft, output = (part_loads(run, Reducer(design), part) for part in ("gear", "shaft", "output"))
    sizes = [np.linalg.norm(loads.force, axis=-1) for loads in (gear, shaft, output)]
    cam = gear.labels.index("cam")
    assert sizes[1][:, 0] == pytest.approx(sizes[0][:, cam])
    assert sizes[2] == pytest.approx(sizes[0][:, cam + 1 :])
    # the load's torque, the pins and the disc's inertia are in balance about the axis
    axis = moments(output, design).sum(axis=1) + output.torque
    body = mass_properties(parts(Reducer(design))["output"])
    # friction of 2 N acts at the middle of a contact's depth of 2 um, not on the surface
    assert axis == pytest.approx(body.inertia[2, 2] * output.spin_rate, abs=3e-6)
    assert np.abs(axis).max() < 0.02 * np.abs(output.torque).max()


def test_the_nearest_samples_of_the_last_turn_are_taken(request):
    run, design = runs(request, "pin")
    sampled = select_turn(run, Reducer(design))
    step = np.median(np.diff(run["crank_angle"]))
    assert sampled.angle == pytest.approx(np.radians(np.arange(360)), abs=0.51 * step)
    assert np.unique(sampled.rows).size == 360
    assert run["crank_angle"][-1] - run["crank_angle"][sampled.rows].min() <= 2 * np.pi + step


def test_pins_in_open_sockets_press_on_the_wall_only(request):
    run, design = runs(request, "pin")
    loads = part_loads(run, Reducer(design), "ring")
    out = np.linalg.norm(loads.position, axis=-1)
    # an edge lies on the wall's radius, and gives way by less than the clearance
    assert np.nanmin(out) >= design.ring.pin_circle_radius - design.clearance.pin_socket
    assert np.nanmax(out) <= design.ring.pin_circle_radius + design.ring.pin_radius + design.clearance.pin_socket


# Mistakes


def test_a_log_without_forces_is_refused():
    run = made_run(PIN)
    kept = {name: values for name, values in run.columns.items() if not name.endswith(("_force_x", "_force_y"))}
    bare = replace(run, columns=kept, units={name: run.units[name] for name in kept}, topics={})
    with pytest.raises(LogError, match=r"lacks the contact forces.*simulate` again"):
        part_loads(bare, Reducer(PIN), "gear")


def test_a_log_without_its_design_is_refused():
    with pytest.raises(LogError, match=r"lacks the attached file design\.toml"):
        part_loads(replace(made_run(PIN), attachments={}), Reducer(PIN), "gear")


def test_a_design_that_did_not_run_is_refused():
    other = override(PIN, ["gear.eccentricity_mm=0.9"])
    with pytest.raises(UsageError, match=r"gear.eccentricity \(0.0009.* in the design, 0.001 in the log\)"):
        part_loads(made_run(PIN), Reducer(other), "gear")
    faster = override(PIN, ["drive.speed_rpm=3000.0", "load.torque_nm=5.0", "settings.timestep_us=2.0"])
    assert part_loads(made_run(PIN), Reducer(faster), "gear", QUARTERS).part == "gear"


def test_a_short_hold_is_refused():
    with pytest.raises(LogError, match=r"crank turns\), but at least one turn is needed.*longer --hold-s"):
        part_loads(made_run(PIN, samples=400), Reducer(PIN), "gear")


def test_a_coarse_log_is_refused():
    run = made_run(PIN, samples=900).select(slice(0, None, 3))
    with pytest.raises(LogError, match=r"one sample per 2.95 deg .*log_rate_hz of 98\d\d or more"):
        part_loads(run, Reducer(PIN), "gear")
    assert part_loads(run, Reducer(PIN), "gear", np.radians(np.arange(0, 360, 3))).angle.size == 120


@pytest.mark.parametrize(("design", "part"), [(PIN, "lobe"), (NONPIN, "pin_1")])
def test_an_unknown_part_is_refused(design, part):
    with pytest.raises(UsageError, match=rf"no part '{part}': choose one of shaft, gear"):
        part_loads(made_run(design), Reducer(design), part)


# Closed forms


def test_von_mises_below_a_line_contact():
    """0.558 p0 at 0.70 b for nu = 0.3 (Johnson 1985, section 4.2); with nu = 0 it is 1 at the surface (uniaxial)."""
    share, depth = largest_von_mises(0.3)
    assert share == pytest.approx(0.558, abs=5e-4)
    assert depth == pytest.approx(0.704, abs=2e-3)
    assert von_mises_below(0.0, 0.3) == pytest.approx(1.0 - 2 * 0.3)
    assert von_mises_below(np.array([50.0]), 0.3) == pytest.approx(np.sqrt(1 - 0.3 + 0.3**2) / 50.0, rel=1e-2)


def test_hertz_pressure_of_the_loads_is_that_of_statics():
    run = made_run(PIN, scale=0.0)
    loads = part_loads(run, Reducer(PIN), "output", QUARTERS)
    output = PIN.output
    bend = 1.0 / output.pin_radius - 1.0 / (output.hole_radius + PIN.clearance.output)
    modulus = contact_modulus(PIN.material.youngs_modulus, PIN.material.poisson)
    hertz = hertz_line_contact(np.linalg.norm(loads.force, axis=-1), PIN.gear.face_width, bend, modulus)
    found = line_stress(loads, Reducer(PIN))
    assert found.peak_pressure == pytest.approx(hertz.peak_pressure, rel=1e-12)


def test_the_cam_has_one_answer_here_and_in_measure_loads():
    """Its most loaded roller: 719 MPa at 1402 N, not 5.7 MPa of a force smeared over 120 deg."""
    from cycloid_mj.measure.contact_pressure import contact_pressures

    run = made_run(PIN, scale=0.0)
    loads = part_loads(run, Reducer(PIN), "shaft", QUARTERS)
    measured = contact_pressures(run, Reducer(PIN))["cam"]
    found = line_stress(loads, Reducer(PIN)).peak_pressure[:, 0]
    assert found == pytest.approx(measured.pressure[select_turn(run, Reducer(PIN), QUARTERS).rows, 0], rel=1e-12)
    roller = 15e-3 * np.sin(np.pi / 20)
    modulus = contact_modulus(PIN.material.youngs_modulus, PIN.material.poisson)
    force = 4.08 / 20 * np.linalg.norm(loads.force[:, 0], axis=-1)
    by_hand = hertz_line_contact(force, PIN.gear.face_width, 1 / roller + 1 / 15e-3, modulus).peak_pressure
    assert found == pytest.approx(by_hand, rel=1e-9)
    assert not loads.narrow.any()


def test_a_conformal_contact_has_no_hertz_figure():
    """A plain cam with a micrometre of play has none, on shaft, in gear, or in `measure loads`; one with 1 mm does."""
    from cycloid_mj.measure.contact_pressure import contact_pressures

    for changes, conformal in (([], True), (["clearance.cam_um=1000.0", "clearance.output_um=500.0"], False)):
        design = override(PIN, ['gear.bearing="plain"', *changes])
        run = made_run(design, scale=0.0)
        found = line_stress(part_loads(run, Reducer(design), "shaft", QUARTERS), Reducer(design))
        assert np.isnan(found.peak_pressure).all() == conformal
        assert np.isnan(contact_pressures(run, Reducer(design))["cam"].peak_pressure) == conformal


# The paper's claims, from findings made by hand


def test_the_fillet_governs_safety_and_the_table_has_it() -> None:
    """Bulk 188 MPa at the edge of what is left out, 270 nominal times 2.19 at the root: 592 MPa, safety 1.05."""
    root = Notch("root", 3e-3, 3e-4, 0.0, 270e6, 0.0, 2.19, 1.5)
    part = replace(made_part("output", [188.0, 170.0]), notches=(root,))
    assert part.governing == root.stress == pytest.approx(591.3e6, rel=1e-3)
    assert part.safety == pytest.approx(1.05, abs=0.01)
    found = StressFindings("pin", "pin", 36.68, None, 620.4e6, (part,), 1.0)
    [row] = bulk_table(found)
    cells = dict(zip(BULK_HEADER, row, strict=True))
    assert (cells["bulk [MPa]"], cells["safety"]) == ("188", "1.05 (fillet 591)")
    told = part.as_json()
    assert told["governing_mpa"] == pytest.approx(591.3, rel=1e-3)
    assert told["safety_against_yield"] == pytest.approx(1.05, abs=0.01)
    assert replace(part, notches=()).safety == pytest.approx(620.4 / 188.0)


def test_the_choice_counts_the_distance_from_corners() -> None:
    assert corner_distance_change([(0.5e-3, 260e6), (1e-3, 188e6), (2e-3, 150e6)]) == pytest.approx(260.0 / 188.0 - 1.0)
    assert corner_distance_change([]) == 0.0


def made_part(part, bulk, teeth=36):
    bulk = np.asarray(bulk) * 1e6
    angle = 2 * np.pi * np.arange(bulk.size) / bulk.size
    row = int(np.argmax(bulk))
    peak = Peak(float(bulk[row]), float(angle[row]), np.zeros(2), "", 620.4e6 / max(bulk[row], 1.0))
    refined = Refinement((200, 400), angle[[row]], np.array([[1.02], [1.0]]) * bulk[row])
    return PartFindings(
        part=part,
        unknowns=200,
        dimension=2,
        teeth=teeth,
        angle=angle,
        bulk=bulk,
        bulk_peak=peak,
        bulk_distance=1e-3,
        sensitivity=((0.5e-3, 2 * peak.stress), (2e-3, float("nan"))),
        choice=0.25,
        by_distance=(np.array([0.5e-3, 1e-3]), np.array([2.0, 1.0]) * peak.stress),
        contact=bulk,
        contact_peak=peak,
        largest_pressure=1e9,
        shakedown=1.433,
        largest_force=100.0,
        near_field=0.0,
        imbalance=0.0,
        notches=(),
        variants=(),
        yield_strength=620.4e6,
        refinement=refined,
        wall=1.0,
    )


def made_findings(kind, /, **bulk):
    found = tuple(made_part(part, values) for part, values in bulk.items())
    return StressFindings(kind, kind, 0.0, None, 620.4e6, found, 1.0, stress_references(PRESETS[kind]))


DEGREES = np.arange(360.0)
AS_THE_PAPER = {
    "shaft": 100.0 + 55.0 * np.cos(np.radians(2 * (DEGREES - 75.0))),
    "gear": np.full(360, 19.0),
    "ring": np.full(360, 60.0),
    "output": 8.0 + 0.1 * np.cos(np.radians(DEGREES)),
    "pin_1": np.where((DEGREES < 10.0) | (DEGREES >= 350.0), 50.0, 0.1),
}
NONPIN_AS_THE_PAPER = {
    "shaft": 40.0 + 15.0 * np.cos(np.radians(2 * (DEGREES - 75.0))),
    "gear": np.full(360, 9.0),
    "ring": np.full(360, 45.0),
}


def test_every_claim_agrees_with_stress_as_in_the_paper():
    judged = claims([made_findings("pin", **AS_THE_PAPER), made_findings("nonpin", **NONPIN_AS_THE_PAPER)])
    assert [claim.claim for claim in judged if claim.verdict != "agrees"] == []
    assert len(judged) == 15


@pytest.mark.parametrize(
    ("part", "bulk", "statement"),
    [
        ("shaft", 0.2 * AS_THE_PAPER["shaft"], "the shaft's stress stays below 160 MPa"),
        ("shaft", 1.2 * AS_THE_PAPER["shaft"], "the shaft's stress stays below 160 MPa"),
        ("shaft", np.roll(AS_THE_PAPER["shaft"], 60), "two peaks a turn"),
        ("shaft", 100.0 + np.cos(np.radians(36 * DEGREES)), "two peaks a turn"),
        ("gear", np.full(360, 61.0), "shaft > ring > gear"),
        ("ring", np.full(360, 44.0), "ring: less stress in nonpin than in pin"),
        ("pin_1", np.where(DEGREES > 180.0, 50.0, 0.1), "pin 1 carries load from 350"),
        ("pin_1", np.full(360, 50.0), "pin 1 carries load from 350"),
        ("output", np.full(360, 300.0), "the output's stress is low"),
    ],
)
def test_a_claim_disagrees_if_the_stress_differs(part, bulk, statement):
    studies = [made_findings("pin", **(AS_THE_PAPER | {part: bulk})), made_findings("nonpin", **NONPIN_AS_THE_PAPER)]
    found = [claim.verdict for claim in claims(studies) if statement in claim.claim and "nonpin:" not in claim.claim]
    assert found == ["disagrees"]


def test_only_unloaded_runs_of_the_papers_designs_are_judged():
    paper = made_findings("pin", **AS_THE_PAPER)
    assert claims([paper])
    assert claims([replace(paper, load=36.68)]) == ()
    wider = override(PIN, ["gear.face_width_mm=12.0"])
    other = replace(paper, references=stress_references(wider))
    own = other.as_json()
    assert PAPER.stress_claims([SimpleNamespace(design=PIN, findings=paper)]) == claims([paper])
    assert PAPER.stress_claims([SimpleNamespace(design=wider, findings=paper)]) == ()
    assert {part["reference"] for part in own["parts"]} == {None}
    assert {part["part"]: part["reference"]["below_mpa"] for part in paper.as_json()["parts"]}["shaft"] == 160.0
    assert (paper.published_limit("shaft"), replace(paper, load=36.68).published_limit("shaft")) == (160e6, None)
    assert (paper.published_limit("output"), other.published_limit("shaft")) == (None, None)


def test_a_preset_is_of_the_paper_under_any_load_and_another_design_is_not():
    assert is_ours(override(NONPIN, ["load.torque_nm=5.0", "settings.timestep_us=3.0"]))
    assert is_ours(PIN.model_copy(update={"name": "mine"}))
    assert is_ours(PIN.but(material={"name": ""}))
    assert not is_ours(override(PIN, ["gear.face_width_mm=12.0"]))
    assert not is_ours(PIN.but(gear_material=PIN.material.model_dump() | {"density": 2700.0}))


def test_refinement_holds_below_its_bound():
    assert made_part("gear", [1.0, 2.0]).refinement.change == pytest.approx(0.02)
    assert made_part("gear", [1.0, 2.0]).refinement.is_converged
    assert not Refinement((1, 2), np.zeros(1), np.array([[1.04], [1.0]])).is_converged
    idle = Refinement((1, 2), np.zeros(1), np.zeros((2, 1)))
    assert (idle.change, idle.scatter) == (0.0, 0.0)


def test_the_stress_of_a_part_is_stated_at_other_bulk_distances():
    found = made_findings("pin", gear=[1.0, 2.0])
    written = found.as_json()["parts"][0]
    assert written["bulk_distance_mm"] == pytest.approx(1.0)
    assert written["sensitivity"] == [{"distance_mm": 0.5, "bulk_mpa": 4.0}, {"distance_mm": 2.0, "bulk_mpa": None}]
    assert written["by_distance"] == {"distance_mm": [0.5, 1.0], "bulk_mpa": [4.0, 2.0]}
    assert bulk_table(found)[0][1:4] == ["2", "1", "-25 %"]


def test_a_pin_without_load_is_reported_as_idle():
    judged = claims([made_findings("pin", pin_1=np.zeros(36))])
    assert "never loaded" in judged[0].ours.text


# The study and the command


@needs_fem
def test_the_study_of_a_part(pin_run):
    from cycloid_mj.stress.study import select_angles, stress_study

    settings = StudySettings(angles=12, refinement=0.4, checked=3)
    told = []
    study = stress_study(pin_run, Reducer(PIN), ["pin_1"], settings, "a.mcap", lambda *what: told.append(what))
    assert told == [("pin_1", 0, 1)]
    found = study.findings["pin_1"]
    assert found.bulk_peak.stress == found.bulk.max()
    assert found.bulk_peak.safety == pytest.approx(PIN.material.yield_strength / found.bulk.max())
    assert found.contact_peak.stress == pytest.approx(
        np.nanmax(line_stress(study["pin_1"].loads, Reducer(PIN)).von_mises)
    )
    assert found.angle[np.argmax(found.bulk)] == found.bulk_peak.angle
    assert list(found.refinement.unknowns) == sorted(found.refinement.unknowns)
    assert found.refinement.stress[0].max() == found.bulk.max()
    assert found.imbalance < 1e-3
    # the disc between two opposite forces is loaded as they are: half of the turn, in proportion
    size = np.linalg.norm(study["pin_1"].loads.force, axis=-1).max(axis=1)
    assert np.corrcoef(size, found.bulk)[0, 1] > 0.95
    assert study["pin_1"].map.angle == found.bulk_peak.angle
    assert select_angles(study["pin_1"].loads, [3]).force == pytest.approx(study["pin_1"].loads.force[[3]])
    written = json.loads(json.dumps(study.findings.as_json()))
    assert written["parts"][0]["bulk_peak"]["stress_mpa"] == pytest.approx(found.bulk.max() / 1e6)
    assert written["assumptions"]


@pytest.mark.slow
@needs_fem
def test_the_swing_of_the_ring_is_that_of_its_bulk(pin_run, tmp_path):
    """At its worst node the stress swings between what the maxima of the turn allow; rate takes it from the result."""
    from cycloid_mj.life import rate
    from cycloid_mj.life.ranges import read_ranges
    from cycloid_mj.stress.study import stress_study

    study = stress_study(pin_run, Reducer(PIN), ["ring"], StudySettings(angles=12, refinement=0.3, checked=1))
    found = study.findings["ring"]
    largest = found.stress_range.amplitude + abs(found.stress_range.mean)
    assert 0.6 * found.bulk.max() < largest < 1.05 * found.bulk.max()
    told = study.findings.as_json() | {"load_nm": 10.0}
    (tmp_path / "stress.json").write_text(json.dumps({"designs": [told]}))
    ranges = read_ranges(tmp_path, Reducer(PIN))
    assert ranges["ring"].amplitude == pytest.approx(found.stress_range.amplitude)
    rated = rate(PIN, ranges=ranges).items
    assert rated["ring_fatigue"].value == pytest.approx(
        1e-6 * PIN.rated_torque / 10.0 * (found.stress_range.amplitude + max(found.stress_range.mean, 0.0))
    )
    assert "housing_ligament_fatigue" not in rated
    assert "hole_to_hole_fatigue" in rated


def unwarned(err):
    """Lines of stderr but warnings: of the coarse step of the log."""
    return [line for line in err.splitlines() if not line.startswith("warning: ")]


@pytest.fixture
def told():
    """Run a command in-process: exit code, stdout, stderr."""
    return partial(commands.told, "stress")


@pytest.fixture(scope="module")
def log(pin_run, tmp_path_factory):
    """The real run as a log."""
    path = tmp_path_factory.mktemp("stress") / "pin.mcap"
    write(pin_run, path)
    return path


@needs_fem
def test_the_command_reads_a_log(told, log):
    code, out, err = told("--log", str(log), "--part", "pin_1", "--quick", "--figure", "all", "--json")
    assert code == 0
    needs, *progress = unwarned(err)
    assert re.fullmatch(
        r"finite elements: [\d,]+ unknowns at 36 crank angles; about [01] s of CPU time and 0.\d GB of memory", needs
    )
    assert progress[0] == "pin: pin_1 (1 of 1 parts)"
    assert [line.split()[0] for line in progress[1:]] == ["wrote"]
    result = json.loads(out, parse_constant=pytest.fail)
    into = log.with_name("pin-stress")
    assert {path.name for path in into.iterdir()} == {
        *(
            f"{name}.{form}"
            for form in ("png", "svg")
            for name in (
                "fig16_stress_pin_1",
                "stress_refinement",
                "fig10_grid_pin",
                "fig11_map_pin",
            )
        ),
        "pin_pin_1.vtu",
        "stress.csv",
        "stress.json",
    }
    assert json.loads((into / "stress.json").read_text()) == result
    part = result["designs"][0]["parts"][0]
    assert (part["part"], len(part["bulk_mpa"])) == ("pin_1", 36)
    assert result["designs"][0]["load_nm"] == pytest.approx(36.68)
    assert result["paper"] == []  # the paper's figures are without load
    assert part["reference"] == {"source": "Hsieh 2014, Fig. 16", "below_mpa": None, "load_nm": 0.0}


@pytest.mark.slow
@needs_fem
def test_the_command_runs_a_design(told, tmp_path):
    fast = ("--set", "ring.pins=fixed", "--set", "load.rise_s=0.001")
    code, out, err = told(
        "--design", "pin", *fast, "--part", "pin_1", "--quick", "--out", str(tmp_path), "--angle-deg", "9", "--all"
    )
    assert (code, "running 1 simulation\n" in err) == (0, True), err
    for words in ("largest von Mises stress", "assumed: ", "pin.mcap"):
        assert words in out
    assert not [path for path in tmp_path.iterdir() if path.suffix in (".png", ".svg")]  # none was asked for
    code, out, err = told("--design", "pin", "--out", str(tmp_path), "--quick")
    assert (code, out) == (1, "")
    assert "pin.mcap already exists" in err


@pytest.mark.slow
@needs_fem
def test_a_stress_figure_equals_that_of_its_command(told, tmp_path):
    fast = ("--set", "ring.pins=fixed", "--set", "load.rise_s=0.001")
    code, out, err = told("pin", *fast, "--part", "pin_1", "--quick", "--out", str(tmp_path), "--json")
    assert code == 0, err
    (study,) = json.loads(out)["designs"]
    assert list(study["figures"]) == ["pin_stress_mpa", "pin_contact_pressure_mpa", "pin_contact_safety"]
    part = study["parts"][0]
    assert study["figures"]["pin_contact_pressure_mpa"]["value"] == part["largest_pressure_mpa"]
    assert study["figures"]["pin_contact_safety"]["value"] == part["safety_against_shakedown"]
    assert study["figures"]["pin_stress_mpa"]["value"] == study["parts"][0]["governing_mpa"]
    fixed = override(PIN, ["ring.pins=fixed", "load.rise_s=0.001"])
    assert figure("pin_stress_mpa").value(Reducer(fixed)) == pytest.approx(study["parts"][0]["governing_mpa"])
    assert math.isnan(figure("pin_stress_mpa").value(Reducer(NONPIN)))


@pytest.mark.parametrize(("degrees", "first"), [(None, 0.0), (74.0, 2.0), (72.0, 0.0), (3.0, 3.0), (360.0, 0.0)])
def test_the_angle_of_the_maps_is_an_angle_of_the_turn(degrees, first):
    asked = None if degrees is None else math.radians(degrees)
    turn = np.degrees(StudySettings(angles=40, map_angle=asked).turn)
    assert turn == pytest.approx(first + 9.0 * np.arange(40), abs=1e-9)


def test_the_default_run_holds_one_settled_turn_at_two_samples_a_degree():
    design = for_one_turn(PIN)
    drive = design.drive
    assert design.load.torque == pytest.approx(36.68)
    assert drive.ramp == 0.0
    assert (drive.hold - settling_time(Reducer(design))) * drive.speed > 2 * np.pi
    assert design.settings.log_rate * 2 * np.pi / drive.speed >= 720
    assert for_one_turn(override(PIN, ["load.torque_nm=5.0"]), None).load.torque == 5.0
    assert for_one_turn(PIN, 7.0).load.torque == 7.0


@pytest.mark.parametrize(
    ("argv", "exit_code", "words"),
    [
        ((), 2, "no design or log is given"),
        (("--log", "a.mcap", "--load-nm", "3"), 2, "have no effect on logs"),
        (
            ("--log", "a.mcap", "--design", "pin", "nonpin"),
            2,
            "the number of designs (2) differs from the number of logs (1)",
        ),
        (("--design", "pin", "pin", "--out", "{}"), 2, "two designs have the name 'pin'"),
        (("--log", "{}/none.mcap"), 2, "none.mcap"),
        (
            ("--log", "{log}", "--design", "nonpin"),
            2,
            "the log does not belong to the design 'nonpin': it differs in ring.kind",
        ),
        (("--log", "{log}", "--part", "tooth"), 2, "no part 'tooth': choose one of shaft, gear, ring, output, pin_1"),
    ],
)
@needs_fem
def test_wrong_input_is_reported_in_one_line(told, log, tmp_path, argv, exit_code, words):
    code, out, err = told(*(word.format(tmp_path, log=log) for word in argv))
    lines = unwarned(err)
    assert (code, out, len(lines)) == (exit_code, "", 1), err
    assert lines[0].startswith("error: ")
    assert words in lines[0]


def test_without_the_extra_one_line_states_what_to_install(told, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "gmsh", None)
    code, out, err = told("--design", "pin")
    assert (code, out) == (1, "")
    assert "pip install 'cycloid-mj[fem]'" in err


def test_every_part_has_its_title_and_number():
    from cycloid_mj.plots.stress import NUMBERS, TITLES

    assert set(TITLES) == set(NUMBERS) == {*PARTS, *gears(4)}


def test_a_log_of_a_changed_design_is_refused_by_the_words_of_its_file():
    changed = made_run(PIN, attachments={"design.toml": dump(override(PIN, ["shaft.radius_mm=9.0"])).encode()})
    with pytest.raises(UsageError, match=r"shaft.radius \(0.008 in the design, 0.009 in the log\)"):
        part_loads(changed, Reducer(PIN), "shaft")


def test_a_log_with_another_material_in_a_part_is_refused():
    bronze = override(PIN, ["gear_material.youngs_modulus_mpa=110000.0"])
    with pytest.raises(UsageError, match=r"gear_material.youngs_modulus \(1100+.0 in the design, None in the log\)"):
        part_loads(made_run(PIN), Reducer(bronze), "gear")


def test_a_part_is_studied_in_the_designs_that_have_it():
    assert command._parts_by_design([PIN, NONPIN], ["pin_1"]) == [["pin_1"], []]
    assert command._parts_by_design([PIN, NONPIN], []) == [list(PARTS), [part for part in PARTS if part != "pin_1"]]
    with pytest.raises(UsageError, match="no part 'pin_1'"):
        command._parts_by_design([NONPIN], ["pin_1"])
    assert part_names(Reducer(override(PIN, ['ring.pins="sleeved"']))) == ("shaft", "gear", "output")


def test_a_part_whose_contacts_are_all_conformal_has_no_contact_figure_but_valid_json():
    part = replace(
        made_part("shaft", [1.0, 2.0]),
        contact=np.full(2, np.nan),
        contact_peak=Peak(np.nan, 0.0, np.zeros(2), "cam", np.nan),
        largest_pressure=np.nan,
        shakedown=np.nan,
    )
    written = part.as_json()
    assert json.dumps(written, allow_nan=False)
    assert (written["contact_peak"]["stress_mpa"], written["largest_pressure_mpa"]) == (None, None)
    shown = contact_table(StressFindings("pin", "pin", 36.68, None, 620.4e6, (part,), 1.0))[0]
    assert shown[1:] == ["-", "-", "conformal", "-", "-"]


def test_tables_keep_their_numbers_whole_in_80_columns(monkeypatch, capsys):
    monkeypatch.setattr("cycloid_mj.cli.terminal.PIPE_WIDTH", 80)
    part = made_part("output", [123.456, 200.0])
    peak = Peak(123.4e6, 3.0, np.array([-0.0263, -0.0123, -0.0095]), "pin_socket", 12.34)
    found = StressFindings("pin", "pin", 36.68, None, 620.4e6, (replace(part, bulk_peak=peak, contact_peak=peak),), 1.0)
    for header, rows in ((BULK_HEADER, bulk_table(found)), (CONTACT_HEADER, contact_table(found))):
        say_table("stress", header, rows)
        words = capsys.readouterr().out.split()
        assert set(" ".join((*header, *rows[0])).split()) <= set(words)


def test_a_part_without_force_has_no_place_and_endless_safety_but_valid_json():
    peak = Peak(0.0, 0.0, np.array([np.nan, np.nan]), "cam", float("inf")).as_json()
    assert json.dumps(peak, allow_nan=False)
    assert (peak["place_mm"], peak["safety_against_yield"]) == ([None, None], None)


def test_progress_estimates_the_time_left(capsys, monkeypatch):
    clock = iter([0.0, 10.0])
    monkeypatch.setattr(command, "monotonic", lambda: next(clock))
    watch = command._TimeReporter([2.0, 6.0], quiet=False)
    watch.report_part("pin", "ring", 0, 2)
    watch.report_part("pin", "output", 1, 2)
    assert capsys.readouterr().err.splitlines() == [
        "pin: ring (1 of 2 parts)",
        "pin: output (2 of 2 parts), about 30 s left",
    ]
