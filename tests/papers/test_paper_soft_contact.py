"""The idle mechanism with the contact of a commercial motion solver, and what its forces are held against."""

import math
from dataclasses import astuple, fields
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from hsieh2014 import hypothesis
from hsieh2014.idle_stress import heaviest, idle_stress, join_loads
from hsieh2014.plan import FULL, QUICK, at_speed
from hsieh2014.soft_contact import GENERIC, STEEL, PeakForces, SoftContact, _facets, in_millimetres, soft_idle

from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.parts import mass_properties, parts
from cycloid_mj.reducer import Reducer
from cycloid_mj.stress.loads import PartLoads
from cycloid_mj.stress.study import StudySettings

PIN, NONPIN = PRESETS["pin"], PRESETS["nonpin"]


@cache
def turned(error: float) -> PeakForces:
    """The nonpin design with facets of a chord error [m]."""
    return soft_idle(NONPIN, STEEL, error, 1, 0)


def test_parameters_are_those_of_the_solvers_table():
    # 100 N at a hundredth of a millimetre, 3162 N at a tenth; damping 50 N s/mm
    assert STEEL.stiffness * (1e-5) ** STEEL.exponent == pytest.approx(100.0)
    assert STEEL.stiffness * (1e-4) ** STEEL.exponent == pytest.approx(10**3.5)
    assert GENERIC.stiffness * (1e-3) ** GENERIC.exponent == pytest.approx(1e5)
    assert astuple(in_millimetres("", 2.0, 1.0, 3.0, 0.5))[1:] == pytest.approx((2e3, 1.0, 3e3, 5e-4))


@pytest.mark.slow
def test_stiff_linear_springs_strike_as_hard_as_the_model():
    # another integrator, without friction, added mass or MuJoCo: the cam's largest force of an idle turn
    gear = mass_properties(parts(Reducer(PIN))["gear"]).mass
    stiffness = Reducer(PIN).contacts["pin_gear"].stiffness
    linear = SoftContact("linear", stiffness, 1.0, math.sqrt(stiffness * gear / PIN.ring.teeth), 1e-15)
    soft = soft_idle(PIN, linear, 0.0, 1, 0)
    run = simulate(at_speed(PIN, 0.0, 1))
    settled = run.time > run.time[-1] / 3.0
    assert soft.cam == pytest.approx(float(run["cam_peak_force"][settled].max()), rel=0.2)
    # and lets the pins as far out of their half-open sockets; closed ones hold them
    numbers = range(1, PIN.ring.teeth + 1)
    ways = [np.hypot(run[f"pin_{number}_x"], run[f"pin_{number}_y"])[settled].max() for number in numbers]
    assert soft.reach == pytest.approx(max(ways), rel=0.25)
    assert soft.reach > 4.0 * PIN.clearance.pin_socket
    closed = soft_idle(PIN.but(ring={"socket": "closed"}), linear, 0.0, 1, 0)
    assert PIN.clearance.pin_socket < closed.reach < 1.05 * PIN.clearance.pin_socket
    # neither strays far from what carries the gear round: its centrifugal force and weight
    carried = gear * (PIN.gear.eccentricity * PIN.drive.speed**2 + 9.8)
    assert 0.5 * carried < soft.cam < 1.5 * carried


@pytest.mark.slow
def test_facets_press_where_exact_flanks_do_not_touch():
    exact, faceted = (turned(error) for error in (0.0, 50e-6))
    assert faceted.tooth > 100.0 * exact.tooth
    assert faceted.cam > 20.0 * exact.cam
    # a sample misses little of what lasts longer than a degree
    assert 0.9 * faceted.cam <= faceted.sampled <= faceted.cam


@pytest.mark.slow
def test_a_reducer_turns_equally_from_any_phase():
    # another start, the same mean mechanism: forces of one size
    first, second = turned(0.0), soft_idle(NONPIN, STEEL, 0.0, 1, 0, 2.0)
    assert first != second
    assert first.cam == pytest.approx(second.cam, rel=0.5)


def test_facets_are_chords_with_the_error_requested():
    assert not _facets(PIN, 0.0, 0).any()
    found = _facets(PIN, 50e-6, 0)
    assert found.mean() == pytest.approx(50e-6, rel=0.1)
    length = 2 * math.pi * PIN.ring.pin_circle_radius / PIN.lobes / found.shape[1]
    assert length**2 / (8 * PIN.ring.pin_radius) == pytest.approx(50e-6, rel=0.2)
    assert np.array_equal(found, _facets(PIN, 50e-6, 0))
    assert not np.array_equal(found, _facets(PIN, 50e-6, 1))


def test_the_hypothesis_holds_forces_against_those_the_paper_would_take():
    assert {case[0] for case in hypothesis.soft_cases(QUICK)} == {"pin", "nonpin"}
    assert len(hypothesis.soft_cases(FULL)) > len(hypothesis.soft_cases(QUICK))
    needed = hypothesis.needed({"shaft": 32.0, "ring": 6.5}, {"shaft": 1400.0, "ring": 150.0}, "pin")
    assert needed == pytest.approx({"shaft": 7000.0, "ring": 1500.0})
    found = {case: PeakForces(*range(1, 6)) for case in hypothesis.soft_cases(QUICK)}
    wanted = dict.fromkeys(("pin", "nonpin"), needed)
    told = hypothesis.as_json(found, wanted)
    assert told["status"] == "hypothesis"
    assert "verdict" not in told
    assert {round(case["chord_error_um"], 6) for case in told["cases"]} == {0.0, 50.0}
    assert len(hypothesis.table(found, wanted).rows) == len(found) + 2


def loads(forces) -> PartLoads:
    """Loads of which only the sizes matter."""
    force = np.stack([np.array(forces, float), np.zeros_like(forces, float)], axis=2)
    count = len(force)
    each, every = np.zeros(count), np.zeros(force.shape[:2])
    return PartLoads(
        part="gear",
        angle=np.arange(count, dtype=float),
        position=np.zeros_like(force),
        force=force,
        half_width=every,
        pressure=every,
        strip=every,
        hertz=every > 0.0,
        labels=("cam", "pin_1"),
        body_force=np.zeros((count, 2)),
        spin=each,
        spin_rate=each,
        torque=each,
    )


def test_the_heaviest_angles_of_a_start_are_solved_for():
    many = loads([[0.0, 1.0], [9.0, 0.0], [6.0, 6.0], [0.0, 0.0], [5.0, 4.5], [8.0, 0.0]])
    chosen = heaviest(many, 4)
    assert chosen.angle.tolist() == [1.0, 5.0, 2.0, 4.0]
    both = join_loads([chosen, many])
    assert len(both.angle) == 10
    assert {len(getattr(both, each.name)) for each in fields(both) if each.name not in ("part", "labels")} == {10}
    assert both.labels == many.labels


@pytest.mark.slow
def test_a_wider_play_needs_longer_facets_to_jam():
    loose = override(NONPIN, ["clearance.tooth_um=300.0"])
    assert soft_idle(loose, STEEL, 50e-6, 1, 0).tooth < 0.5 * turned(50e-6).tooth


def test_the_bulk_of_every_start_begins_as_under_the_rated_load(monkeypatch):
    run, rated = SimpleNamespace(rated=False), SimpleNamespace(rated=True)
    asked = []

    def solve(design, grid, loads, distance=None):
        asked.append((len(loads.angle), distance))
        return SimpleNamespace(bulk_stress=1e6 * loads.angle, bulk_distance=0.007, load=loads.angle)

    many = loads([[0.0, 1.0], [9.0, 0.0], [6.0, 6.0], [0.0, 0.0], [5.0, 4.5], [8.0, 0.0]])
    part = SimpleNamespace(findings=SimpleNamespace(part="gear"), grid=None)
    monkeypatch.setattr("hsieh2014.idle_stress.at_peaks", lambda run, window: run)
    monkeypatch.setattr("cycloid_mj.stress.field.solve", solve)
    monkeypatch.setattr("cycloid_mj.stress.loads.part_loads", lambda run, design, part, angles: many)
    monkeypatch.setattr("cycloid_mj.stress.study.stress_study", lambda *_, **__: SimpleNamespace(parts=(part,)))
    monkeypatch.setattr("hsieh2014.idle_stress.design_of", lambda run: PIN)
    monkeypatch.setattr("hsieh2014.idle_stress.with_output", lambda run, pins: run)
    monkeypatch.setattr("cycloid_mj.stress.part.part_grid", lambda design, part, settings: None)
    found = idle_stress([run] * 3, rated, StudySettings(angles=36))
    # with the output pins held otherwise, bulk begins where that stands on its own plateau
    assert asked == [(6, None), (12, 0.007), (12, None), (12, None)]
    assert [one.values for one in found.outputs.values()] == [(5.0, 5.0, 5.0)] * 2
    assert found.starts["gear"].values == (5.0, 5.0, 5.0)
    assert found.rated["gear"].high == 5.0
