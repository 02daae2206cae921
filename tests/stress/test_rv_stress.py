"""Stress of an RV reducer: loads of its static balance, cranks and gears in closed form, and the command."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from rv_runs import COULOMB_RV80E

from cycloid_mj.base.array import cross
from cycloid_mj.base.errors import LogError, UsageError
from cycloid_mj.base.record import Run
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, dump
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.ideal_loads import contact_modulus, hertz_line_contact
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.parts import body_solids, mass_properties
from cycloid_mj.parts.rv import axial_layout
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics.rv_sheet import solve_running_equilibrium
from cycloid_mj.stress.loads import PartLoads, loads_in_turn, part_names, turn_of
from cycloid_mj.stress.rv_strength import compute_rv_strength, crank_moments, planet_forces
from cycloid_mj.stress.static_turn import solve_over_turn, static_turn
from cycloid_mj.stress.turn import select_turn

DRIVE = RvReducer(COULOMB_RV80E.but(load={"torque": 784.0}))
ANGLES = np.radians(np.arange(0.0, 360.0, 7.5))


def _loads(part: str, reducer: RvReducer = DRIVE) -> PartLoads:
    return loads_in_turn(static_turn(reducer, ANGLES), part)


@pytest.mark.parametrize("law", ["coulomb", "film"])
@pytest.mark.parametrize("part", ["gear_1", "gear_2", "pin_1"])
def test_static_forces_balance_each_free_part(part: str, law: str) -> None:
    loads = _loads(part, DRIVE.but(friction={"law": law}))
    body = mass_properties(body_solids(DRIVE)[{"pin_1": "pin"}.get(part, part)])
    largest = np.linalg.norm(loads.force, axis=-1).max()
    assert np.abs(loads.force.sum(axis=1)).max() < 1e-6 * largest
    assert np.abs(loads.spin_rate * body.inertia[2, 2]).max() < 1e-6 * largest * DRIVE.lever


def test_largest_forces_are_those_of_statics() -> None:
    running = solve_running_equilibrium(DRIVE, 784.0)
    loads = _loads("gear_1")
    force = np.linalg.norm(loads.force, axis=-1)
    assert force[:, -3:].max() == pytest.approx(running.bearings.max(), rel=5e-3)
    assert force[:, :-3].max() == pytest.approx(
        running.pins.max() * math.hypot(1.0, DRIVE.design.mesh_friction), rel=5e-3
    )
    needle = 4.08 / DRIVE.cranks.needles * force[:, -1]
    modulus = contact_modulus(DRIVE.design.material.youngs_modulus, DRIVE.design.material.poisson)
    curvature = 1.0 / DRIVE.cranks.needle_radius - 1.0 / DRIVE.bore_radius
    expected = hertz_line_contact(needle, DRIVE.design.gear.face_width, curvature, modulus).peak_pressure
    assert loads.pressure[:, -1] == pytest.approx(expected, rel=1e-9)


def test_loads_on_a_disc_repeat_after_a_turn_of_the_cranks_against_the_carrier() -> None:
    """The ring has then turned by a pin: each lobe carries what its neighbour did, and the cranks the same."""
    first, second = (loads_in_turn(static_turn(DRIVE, [0.3 + turn]), "gear_2") for turn in (0.0, 2.0 * np.pi))
    assert second.force[0, -3:] == pytest.approx(first.force[0, -3:], abs=1e-6)
    assert np.roll(second.force[0, :-3], -1, axis=0) == pytest.approx(first.force[0, :-3], abs=1e-6)
    assert static_turn(DRIVE, [0.3])["crank_angle"] == pytest.approx([0.3 * 39 / 40])


def test_an_internal_gear_has_the_same_resultant() -> None:
    """Rings of pins and lobes carry the same torque, so that their resultants differ by friction and springs only."""
    lobes = _loads("gear_1", DRIVE.but(ring={"kind": "nonpin"}))
    assert lobes.labels[0] == "gear_1_lobe_1"
    resultants = [np.linalg.norm(item.force[:, :-3].sum(axis=1), axis=-1).mean() for item in (lobes, _loads("gear_1"))]
    assert resultants[0] == pytest.approx(resultants[1], rel=0.05)


def test_bending_of_cranks_is_that_of_distributed_forces() -> None:
    """The moment at a section is the sum over 2000 slices of what lies before it, and of the near support."""
    springs, loads = solve_over_turn(DRIVE, ANGLES)
    gear, along = DRIVE.design.gear, axial_layout(DRIVE)
    first, last = (sum(ends) / 2.0 for ends in along.flanges)
    bending, torsion = crank_moments(DRIVE, springs, loads, np.array([first, 0.001, 0.009, last]))
    assert bending[..., -1] == pytest.approx(np.zeros(bending.shape[:-1]), abs=1e-9)
    assert torsion[..., -1] == pytest.approx(np.zeros(bending.shape[:-1]), abs=1e-12)
    planet = planet_forces(DRIVE, springs, loads)
    assert bending[..., 0] == pytest.approx(np.linalg.norm(planet, axis=-1) * (first - along.planet_middle))
    row, crank = 5, 1
    centres, forces = [along.planet_middle], [planet[row, crank]]
    for disc, plane in enumerate(gear.disc_planes):
        slices = plane + gear.face_width * ((np.arange(2000) + 0.5) / 2000 - 0.5)
        centres += slices.tolist()
        forces += [-loads.cranks[row, disc, crank] / 2000] * 2000
    z, f = np.array(centres), np.array(forces)
    near = -(f * (last - z)[:, np.newaxis]).sum(axis=0) / (last - first)
    for station, size in zip((0.001, 0.009), bending[row, crank, 1:3], strict=True):
        before = z < station
        moment = (f[before] * (station - z[before])[:, np.newaxis]).sum(axis=0) + near * (station - first)
        assert size == pytest.approx(np.linalg.norm(moment), rel=1e-3)


def test_torque_of_a_crank_is_its_share_of_the_ring_torque() -> None:
    """n T_p = T_ring/zb of ideal sharing: 6.49 N m at 784 N m without friction."""
    reducer = DRIVE.but(friction={"pin_gear": 0.0, "pin_socket": 0.0, "cam_rolling": 0.0}, planet={"friction": 0.0})
    springs, loads = solve_over_turn(reducer, ANGLES)
    before_discs = [axial_layout(reducer).flanges[0][0]]
    _, torsion = crank_moments(reducer, springs, loads, np.array(before_discs))
    assert torsion.mean() == pytest.approx(6.49, abs=0.01)
    planet = loads.meshes * reducer.stage_gears[1].base_radius
    assert torsion[..., 0] == pytest.approx(planet, rel=1e-3)


def test_tooth_roots_and_shoulders_scale_with_the_torque_of_stiff_contacts() -> None:
    whole, half = (
        compute_rv_strength(DRIVE.working_at(784.0).but(load={"torque": torque}), ANGLES) for torque in (784.0, 392.0)
    )
    assert set(whole.largest) == {"crank", "sun", "planet"}
    assert half.largest["planet"] == pytest.approx(0.5 * whole.largest["planet"], rel=5e-3)
    assert half.largest["crank"] == pytest.approx(0.5 * whole.largest["crank"], rel=0.05)
    assert half.needle_pressure == pytest.approx(whole.needle_pressure / math.sqrt(2.0), rel=0.05)
    stresses = whole.as_json()
    assert len(stresses["crank"]) == 4
    assert stresses["tooth_roots"][0]["stress_mpa"] == pytest.approx(whole.largest["sun"] / 1e6)


def test_tooth_pressures_through_the_inflection() -> None:
    """Pins 20-27 of a published 59/60 drive, 6 deg apart, from the concave through to the convex flank.

    Their pressures have the curvature of the flank to 1e-4, but with its sign reversed: they add it where the flank is
    concave. A circle through three points of the outline shows that the flank is concave before the inflection.
    """
    gear, length = CycloidGear(60, 2.2e-3, 168.0104e-3, 4.0e-3), 14e-3
    forces = np.array([432.55, 1344.17, 1516.90, 1707.90, 1630.38, 1265.69, 690.60, 24.98])
    published = np.array([675.7, 1096.9, 1027.5, 917.5, 725.3, 508.3, 306.2, 51.2])
    angle, modulus = np.radians(24.0 + 6.0 * np.arange(8)) / gear.lobes, contact_modulus(206e9, 0.3)
    curvature = profile.curvature(gear, angle)
    assert np.degrees(profile.inflection_phase(gear)) == pytest.approx(37.4, abs=0.1)
    before, middle, after = (profile.outline(gear, angle + step) for step in (-1e-6, 0.0, 1e-6))
    turn = cross(middle - before, after - middle)
    assert -turn / np.linalg.norm(middle - before, axis=1) ** 3 == pytest.approx(curvature, rel=1e-2)
    assert (curvature < 0.0).tolist() == [True] * 3 + [False] * 5
    pressures = [
        1e-6 * hertz_line_contact(forces, length, 1.0 / 3.99e-3 + sign * curvature, modulus).peak_pressure
        for sign in (-1.0, 1.0)
    ]
    assert pressures[0] == pytest.approx(published, abs=0.1)
    assert pressures[1] == pytest.approx([318.4, 728.6, 949.2, 1166.8, 1255.8, 1172.3, 892.8, 172.1], abs=0.1)


def test_parts_of_an_rv_reducer_are_those_of_finite_elements() -> None:
    assert part_names(DRIVE) == ("gear_1", "gear_2", "ring", "pin_1")


def test_logs_and_springs_of_rv_reducers_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    run = Run(np.arange(2.0), {}, {}, attachments={"design.toml": dump(PRESETS["rv80e"]).encode()})
    with pytest.raises(LogError, match="from static equilibrium"):
        select_turn(run)
    with pytest.raises(UsageError, match="is computed from a run"):
        turn_of(None, Reducer(PRESETS["pin"]), ANGLES)
    assert main(["stress", "--design", "rv80e", "--springs"]) == 2
    assert '--springs does not support layout = "rv" (rv80e)' in capsys.readouterr().err


@pytest.mark.slow
def test_stress_of_the_rv80e(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Bulk stresses converge, and a pin carries the pressure of the data sheet but for the curvature of its flank."""
    pytest.importorskip("skfem")
    words = ["stress", "--design", "rv80e", "--load-nm", "784", "--quick", "--out", str(tmp_path / "out"), "--json"]
    assert main(words) == 0
    result = json.loads(capsys.readouterr().out)["designs"][0]
    assert [part["part"] for part in result["parts"]] == ["gear_1", "gear_2", "ring", "pin_1"]
    assert all(part["refinement"]["holds"] for part in result["parts"])
    assert all(part["imbalance"] < 1e-3 for part in result["parts"])
    assert result["cranks_and_gears"]["crank"][0]["stress_mpa"] > 100.0
    assert set(result["figures"]) >= {"gear_stress_mpa", "gear_contact_pressure_mpa", "pin_stress_mpa"}
    assert "static balance" in result["assumptions"][0]
