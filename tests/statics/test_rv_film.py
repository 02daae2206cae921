"""The friction law ``film`` of RV reducers: speeds and limits of each contact, power balance, and intervals."""

from dataclasses import replace

import numpy as np
import pytest
from rv_runs import COULOMB_RV80E

from cycloid_mj.design import PRESETS, override
from cycloid_mj.design.model import HEATED
from cycloid_mj.figures.film_map import compute_film_map
from cycloid_mj.figures.statics import no_load_torque, starting_spread
from cycloid_mj.geometry.involute import contact_path, gear_pair
from cycloid_mj.geometry.rv import mesh_loss_factor
from cycloid_mj.geometry.surface_speeds import entrainment_zeros
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics import rv_sheet
from cycloid_mj.statics.film import FilmInputs, drag_torques, idle_power, roller_bearings, seal_torques
from cycloid_mj.statics.film_spread import sample_inputs
from cycloid_mj.statics.rv import RvLoads, RvSprings, solve_rv_loads
from cycloid_mj.statics.rv_film import (
    RvFilm,
    build_rv_film,
    build_rv_losses,
    planet_friction,
    planet_path,
    planet_speeds,
)
from cycloid_mj.statics.rv_sheet import friction_powers, rv_powers, springs_over_turn, torque_on_carrier
from cycloid_mj.statics.sheet import sampled_efficiency

LOAD, FEW_ANGLES = 784.0, 61
RPM = np.pi / 30.0


def lubricated(*changes: str, at: float = 20.0) -> RvReducer:
    """Return the reducer of the preset with the law ``film`` and lithium grease at a temperature [°C]."""
    temperatures = [f"thermal.{part}_c={at}" for part in HEATED]
    grease = "friction.lubricant=lithium grease 100"
    return RvReducer(override(PRESETS["rv80e"], ["friction.law=film", grease, *temperatures, *changes]))


def balanced(reducer: RvReducer, inputs: FilmInputs, load: float = LOAD) -> tuple[RvFilm, RvSprings, RvLoads]:
    """Return film, springs and loads of a reducer under a load [N m], for inputs of the law."""
    springs, torque = springs_over_turn(reducer, FEW_ANGLES), torque_on_carrier(reducer, load)
    film = build_rv_film(reducer, springs.crank, np.sign(torque))
    surfaces = replace(film.contacts.surfaces, inputs=inputs)
    film = replace(film, contacts=replace(film.contacts, surfaces=surfaces))
    return film, springs, solve_rv_loads(springs, torque, film)


@pytest.mark.parametrize("member", ["carrier", "ring"])
def test_speeds_are_those_of_the_mechanism(member: str) -> None:
    reducer = lubricated(f"output.member={member}")
    film, springs, _ = balanced(reducer, FilmInputs())
    sliding = np.abs(springs.slip * reducer.speed_against_ring)
    assert np.abs(film.contacts.surfaces.flank.sliding) == pytest.approx(sliding, rel=1e-9)
    sun, members = reducer.design.drive.speed, reducer.member
    needles, tapers, main = roller_bearings(reducer)
    for bearing in (needles, tapers):
        assert bearing.speed == pytest.approx(abs(float(members.crank_angle(sun) - members.gear_angle(sun))))
    assert main.speed == pytest.approx(abs(float(members.ring_angle(sun) - members.gear_angle(sun))))
    path, speeds = planet_path(reducer), planet_speeds(reducer)
    at_pitch = float(np.interp(0.0, path.distance, speeds.entrainment))
    against_carrier = abs(sun - float(members.gear_angle(sun)))
    sine = np.sin(reducer.planet_mesh.pressure_angle)
    assert at_pitch == pytest.approx(against_carrier * 0.5 * 0.00175 * 10 * sine, rel=1e-9)


def test_lubrication_is_boundary_where_the_entrainment_of_the_teeth_vanishes() -> None:
    reducer = lubricated("ring.pins=fixed")
    zero = entrainment_zeros(reducer.tooth_profile)[0]
    assert np.degrees(zero) == pytest.approx(51.56, abs=0.01)
    surfaces = build_rv_film(reducer, [zero], 1.0).contacts.surfaces
    friction = surfaces.smaller_friction(np.full(surfaces.radius.shape, 300.0))[0]
    assert abs(surfaces.flank.entrainment[0, 0]) < 1e-12
    assert friction.asperity_share[0, 0] > 0.99
    assert friction.coefficient[0, 0] == pytest.approx(0.11, rel=0.01)
    assert np.min(friction.asperity_share) < 0.6


def test_a_path_of_contact_has_the_loss_factor_of_the_standard() -> None:
    """Of gears without profile shift, whose flanks end above their base circles."""
    teeth, angle, centre_distance = (24, 36), np.radians(20.0), 0.5 * 60 * 2e-3
    pair = gear_pair(teeth, 2e-3, angle, centre_distance, 0.0)
    path = contact_path(pair, centre_distance)
    pitch = 2.0 * np.pi * pair[0].base_radius / teeth[0]
    assert np.sum(path.weight * path.load_share) == pytest.approx(pitch, rel=1e-12)
    arm = np.sum(path.weight * path.load_share * np.abs(path.distance)) / pitch
    loss_factor = arm * (1.0 + teeth[0] / teeth[1]) / pair[0].base_radius
    assert loss_factor == pytest.approx(mesh_loss_factor(*teeth, angle), rel=1e-9)


def test_without_viscosity_friction_is_that_of_the_boundary() -> None:
    reducer = lubricated()
    inputs = FilmInputs(viscosity=0.0)
    film, springs, loads = balanced(reducer, inputs)
    assert film.tooth_friction(loads).coefficient == pytest.approx(0.11)
    assert planet_friction(reducer, loads.meshes, inputs) == pytest.approx(0.11)
    powers = build_rv_losses(film, springs, loads).contact_powers(inputs)
    torque = 0.5 * sum(0.0005 * bearing.diameter for bearing in roller_bearings(reducer)[:2])
    coulomb = ("friction.pin_gear=0.11", "friction.pin_socket=0.11", "planet.friction=0.11")
    rolling = f"friction.cam_rolling={torque / reducer.cranks.eccentric_radius!r}"
    dry = friction_powers(RvReducer(override(COULOMB_RV80E, [*coulomb, rolling])), LOAD, FEW_ANGLES)
    for source, power in powers.items():
        assert power == pytest.approx(dry[source], rel=1e-4)


@pytest.mark.parametrize(("load", "error"), [(LOAD, 1e-3), (0.01 * LOAD, 1e-5)])
def test_powers_balance(load: float, error: float) -> None:
    """Power of the sun by the forces of the planets, against that of the output and the losses of the contacts.

    Losses are those of ideal sliding, so the error is in proportion to the displacements.
    """
    reducer = lubricated()
    film, springs, loads = balanced(reducer, FilmInputs(), load)
    mesh, driving = reducer.planet_mesh, np.abs(loads.flanks[:, 0] - loads.flanks[:, 1])
    rubbing = planet_friction(reducer, loads.meshes) * loads.meshes * mesh.arm
    torque = np.sum(driving * mesh.sun_base + rubbing, axis=1).mean()
    lost = sum(build_rv_losses(film, springs, loads).contact_powers().values())
    delivered = load * reducer.output_speed
    assert torque * reducer.design.drive.speed == pytest.approx(delivered + lost, rel=error)


@pytest.mark.parametrize(
    ("temperature", "value", "low", "high"), [(20.0, 85.61, 82.93, 89.08), (60.0, 88.81, 86.00, 92.54)]
)
def test_efficiency_of_the_rv80e_is_an_interval(temperature: float, value: float, low: float, high: float) -> None:
    spread = sampled_efficiency(lubricated(at=temperature), LOAD)
    assert (spread.value, spread.low, spread.high) == pytest.approx((value, low, high), abs=0.02)


def test_samples_at_fixed_forces_match_full_solutions() -> None:
    reducer = lubricated()
    _, outcomes = rv_sheet.rv_lost_powers(reducer, LOAD)
    for k in (0, 5, 9):
        inputs = sample_inputs()[0][k]
        losses = build_rv_losses(*balanced(reducer, inputs, LOAD + drag_torques(reducer)[1]))
        assert outcomes[k] == pytest.approx(sum(losses.powers(inputs).values()), rel=2e-3)


def test_few_crank_angles_have_the_losses_of_many() -> None:
    reducer = lubricated()
    many, few = (friction_powers(reducer, LOAD, count) for count in (720, FEW_ANGLES))
    assert few == pytest.approx(many, rel=1e-4)


def test_torque_without_load_is_that_of_bearings_and_seal() -> None:
    reducer = lubricated()
    needles, tapers, main = (idle_power(reducer, bearings) for bearings in roller_bearings(reducer))
    # M0 = 1e-7 f0 (nu n)^(2/3) d_m^3 [N mm] of six needle bearings, 29 mm, 600 rpm, and 339.2 mm2/s at 20 °C
    viscosity = 339.2
    assert needles == pytest.approx(6 * 1e-10 * 3.0 * (viscosity * 600.0) ** (2 / 3) * 29.0**3 * 600 * RPM, rel=0.01)
    _, seal = seal_torques(reducer)
    assert seal == pytest.approx(7.69e-6 * (2e3 * reducer.flange_radius) ** 2 / RPM, rel=1e-9)
    drag = (needles + tapers + main + seal * reducer.output_speed) / reducer.design.drive.speed
    # teeth, bearings and planets carry the drag of the output, which adds 3 %
    assert drag < no_load_torque(reducer) < 1.04 * drag
    start = starting_spread(reducer, 16)
    assert start.low < start.value < start.high
    assert start.value == pytest.approx(0.0147, rel=0.01)


def test_the_map_has_no_back_driving_torque() -> None:
    points = compute_film_map(lubricated(), shares=(1.0,), temperatures=(60.0,))
    assert [point.quantity for point in points] == ["starting torque", "no-load torque", "efficiency"]


def test_friction_that_oscillates_with_the_sliding_of_a_pin_converges() -> None:
    """Full steps of the fixed-point iteration oscillate at one of these angles, under a torque that drives."""
    grease = {"law": "film", "lubricant": "lithium grease 100"}
    powers = rv_powers(RvReducer(PRESETS["rv80e"].but(friction=grease)).working_at(LOAD), -907.06)
    assert powers.crank < 0.0
    assert powers.efficiency == pytest.approx(0.8643, abs=5e-4)
