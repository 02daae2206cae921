"""The joint of an RV reducer: its parameters against statics and closed forms, in MuJoCo, and in other formats."""

from dataclasses import replace
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest
from rv_runs import COULOMB_RV80E

from cycloid_mj.base.units import ARCMINUTE, ARCSECOND
from cycloid_mj.design import override
from cycloid_mj.dynamics.planar.rv_system import input_inertia
from cycloid_mj.explore.rv_samples import draw_rv_drive
from cycloid_mj.geometry.rv_loads import closed_form_error
from cycloid_mj.parts.export.rv_assembly import rv_mass
from cycloid_mj.reducer import RvReducer
from cycloid_mj.robot import ReducedJoint, identification, reduce
from cycloid_mj.robot.comparison import compare_with_full_model
from cycloid_mj.robot.description import DRIVE, OUTPUT, compute_link_inertias, write_descriptions
from cycloid_mj.robot.full_model import full_model
from cycloid_mj.robot.identification import GRID, solve_play
from cycloid_mj.robot.lossy import lossy_efficiencies
from cycloid_mj.robot.population import draw_population
from cycloid_mj.robot.ripple import Ripple
from cycloid_mj.robot.trial import create_trial_scene
from cycloid_mj.statics.rv import crank_misfits, phase_errors
from cycloid_mj.statics.rv_sheet import rv_powers, solve_rv_equilibrium
from cycloid_mj.statics.sheet import sheet_part

RV80E = COULOMB_RV80E
RATED = RV80E.rated_torque


def reducer(*changes: str) -> RvReducer:
    """Return the reducer of the preset with changes, with contacts at the nominal torque."""
    return RvReducer(override(RV80E, changes)).working_at(RATED)


@pytest.fixture(scope="module")
def joint() -> ReducedJoint:
    """The joint of the preset with few points in its friction map, and without transmission error."""
    with pytest.MonkeyPatch.context() as patch:
        few_points = replace(GRID, torques=(0.05, 0.1, 0.25, 0.5, 1.0, 2.0), speeds=(0.5, 1.0), angles_factor=2)
        patch.setattr(identification, "GRID", few_points)
        patch.setattr(identification, "solve_ripple", lambda *_: Ripple((), (0.0,), *[((),)] * 6))
        return reduce(RV80E)


@pytest.mark.parametrize("member", ["carrier", "ring"])
def test_play_and_stiffness_are_those_of_statics(member: str) -> None:
    drive = reducer(f'output.member="{member}"')
    figures = {item.key: item.value for item in sheet_part(drive, "motions", RATED).values()}
    play = solve_play(drive, 61)
    assert play.backlash / ARCMINUTE == pytest.approx(figures["backlash"], rel=2e-3)
    assert play.stiffness * ARCMINUTE == pytest.approx(figures["stiffness_ideal"], rel=2e-3)
    assert play.stops[0] < 0.0 < play.stops[1]


def test_compliances_of_teeth_bearings_and_planets_add_up() -> None:
    """By the work of the springs, against the rotation of the output; damping is between those of the springs."""
    drive = reducer()
    model, stiffness = full_model(drive), solve_play(drive, 61).stiffness
    compliances, time_constants = model.compliances(), model.time_constants()
    assert sum(compliances.values()) * stiffness == pytest.approx(1.0, rel=2e-3)
    assert max(compliances, key=lambda kind: compliances[kind]) == "crank_bearing"
    assert min(time_constants.values()) < model.damping() / stiffness < max(time_constants.values())


@pytest.mark.parametrize("member", ["carrier", "ring"])
def test_inertias_add_up_to_that_at_the_sun(member: str) -> None:
    drive = reducer(f'output.member="{member}"', "ring.pins=fixed")  # free pins of a turning ring are own bodies
    rotor, output = full_model(drive).inertias()
    total = input_inertia(drive)
    assert rotor + output / drive.design.reduction**2 == pytest.approx(total, rel=1e-9)
    assert 0.9 * total < rotor < total


@pytest.mark.parametrize("member", ["carrier", "ring"])
@pytest.mark.parametrize("direction", [1, -1])
def test_error_of_a_bore_is_the_closed_form(member: str, direction: int) -> None:
    """Sense and phase of the error over the angle of the sun; the bore of a disc is displaced by 10 um."""
    no_friction = ("friction.pin_gear=0", "friction.pin_socket=0", "friction.cam_rolling=0", "planet.friction=0")
    drive = reducer(f'output.member="{member}"', "crank_errors.bore_x_um=[10,0,0,0,0,0]", *no_friction)
    model, part = full_model(drive), 5
    rotation = model.rotation_over_part(RATED, direction, part, 1)
    sun = 2.0 * np.pi * drive.design.reduction / model.parts * (part + np.arange(rotation.size) / rotation.size)
    crank = drive.member.against_ring(sun)
    carrier = closed_form_error(drive.stage, crank, phase_errors(drive, crank), crank_misfits(drive, crank))
    closed = (-1.0 if member == "ring" else 1.0) * drive.share * carrier
    error = rotation - rotation.mean() - (closed - closed.mean())
    assert np.ptp(closed) == pytest.approx(11.4 * ARCSECOND, rel=0.02)
    assert np.abs(error).max() < 0.03 * np.ptp(closed)


def test_joint_rests_in_mujoco_as_in_statics(joint: ReducedJoint) -> None:
    """Backlash and wind-up of the locked joint in stock MuJoCo, against statics at crank angles of its own."""
    scene = create_trial_scene(joint.at("backlash"), 1e-3 * joint.reflected_inertia, 5e-3)
    scene.hold()
    drive = reducer()
    for share in (0.03, 0.5, 1.0):
        width = scene.find_rest(share * RATED) - scene.find_rest(-share * RATED)
        turns = [solve_rv_equilibrium(drive, sign * share * RATED, 97).carrier_turn.mean() for sign in (1.0, -1.0)]
        assert width == pytest.approx(abs(turns[0] - turns[1]), rel=1e-3)
    assert joint.quantities["ratio"].value == 153.0
    assert joint.quantities["backlash_arcmin"].value == pytest.approx(0.02286, rel=1e-3)


def test_joint_loses_as_much_in_mujoco_as_in_statics(joint: ReducedJoint) -> None:
    """Efficiency of both directions with losses by a contact, in stock MuJoCo without Python code."""
    drive = reducer()
    for item in lossy_efficiencies(joint):
        torque = (1.0 if item.driving else -1.0) * item.share * RATED
        assert item.percent == pytest.approx(100.0 * rv_powers(drive, torque, 97).efficiency, abs=0.1)
    assert joint.quantities["efficiency"].value == pytest.approx(88.9, abs=0.05)
    assert joint.quantities["back_driving_efficiency"].value == pytest.approx(88.9, abs=0.05)


def test_urdf_has_mass_and_inertia_of_the_reducer(joint: ReducedJoint) -> None:
    drive = RvReducer(RV80E)
    links = compute_link_inertias(joint, drive)
    assert sum(link.mass for link in links.values()) == pytest.approx(rv_mass(drive), abs=2e-3)
    for link in links.values():
        moments = sorted((link.ixx, link.iyy, link.izz))
        assert moments[2] <= moments[0] + moments[1]
    files = {form: write_descriptions(joint, drive, form) for form in ("urdf", "sdf", "isaaclab", "mjx")}
    model = mujoco.MjModel.from_xml_string(files["urdf"]["rv80e.urdf"].decode())
    assert model.joint(OUTPUT).range == pytest.approx(joint.stops)
    assert model.body(DRIVE).inertia.max() == pytest.approx(153.0**2 * joint.rotor_inertia)
    root = ElementTree.fromstring(files["urdf"]["rv80e.urdf"].decode())
    assert float(root.findtext(".//mechanicalReduction") or "nan") == 153.0
    scene = {name: content for name, content in files["mjx"].items() if name != "scene.xml"}
    assert mujoco.MjModel.from_xml_string(files["mjx"]["scene.xml"].decode(), scene).nv == 2


def test_a_random_drive_has_errors_within_the_tolerances() -> None:
    toleranced = reducer("crank_tolerance.bore_position=uniform 4", "crank_tolerance.eccentricity=uniform 3")
    design, drawn = draw_rv_drive(toleranced, 1, 5)
    assert draw_rv_drive(toleranced, 1, 5) == (design, drawn)
    assert draw_rv_drive(toleranced, 1, 6)[1] != drawn
    assert len(drawn) == 3 * 6  # bores along x and y, eccentricities
    errors = design.crank_errors
    assert errors is not None
    assert errors.bore_x[1] == pytest.approx(1e-6 * drawn["drawn_bore_x_2_um"])
    assert 0.0 < max(map(abs, errors.bore_x)) <= 4e-6
    assert 0.0 < max(map(abs, errors.eccentric_radial)) <= 3e-6
    assert draw_rv_drive(reducer(), 1, 5) == (reducer().design, {})


@pytest.mark.slow
def test_random_drives_spread_about_the_nominal_joint() -> None:
    drives = draw_population(reducer("crank_tolerance.bore_position=uniform 4"), 4, seed=1)
    assert drives.samples == 4
    nominal, values = drives.nominal, drives.values
    assert nominal["stiffness_nm_per_arcmin"] == pytest.approx(208.2, rel=1e-3)
    assert nominal["no_load_torque_nm"] == 0.0
    assert values["te_loaded_forward_arcsec"].min() > 10.0 * nominal["te_loaded_forward_arcsec"]
    assert np.ptp(values["loss_percent"]) > 1.0  # friction of teeth and planets
    # misfits of bores by some micrometres close the clearance of the teeth, 0.1 um
    assert values["backlash_arcmin"].max() < 1e-3 * nominal["backlash_arcmin"]
    assert {"friction", "planet", "clearance"} == {item.table for item in drives.ranges}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "order", "arcsec"),
    [((), 1560.0 / 153.0, 0.026), (("crank_errors.bore_x_um=[10,0,0,0,0,0]",), 40.0 / 153.0, 5.7)],
)
def test_joint_matches_the_full_model(changes: tuple[str, ...], order: float, arcsec: float) -> None:
    """All rows of the comparison are within their bounds; the strongest harmonic is that of pins or of the bore."""
    design = override(RV80E, changes)
    joint = reduce(design)
    comparison = compare_with_full_model(RvReducer(design), joint)
    assert comparison.outside_bounds == []
    rated = [item for item in joint.ripple.harmonics(joint.way, RATED) if item["load_nm"] == pytest.approx(RATED)]
    strongest = max(rated, key=lambda item: item["value"])
    assert strongest["order"] == pytest.approx(order)
    assert strongest["value"] == pytest.approx(arcsec, rel=0.02)
    assert sum(row.key.startswith("te_") for row in comparison.rows) >= 2
