"""Vibration: unbalance against closed forms, the housing's force against the momentum of what moves, the sweep."""

import json
import math

import numpy as np
import pytest
from designs import cases

from cycloid_mj.analysis.spectrum import SPECTRUM
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.geometry import profile
from cycloid_mj.measure import Measurement
from cycloid_mj.measure.conditions import STEADY
from cycloid_mj.measure.reaction import body_masses, reaction, unbalance, weight_force, without_counterweight
from cycloid_mj.measure.vibration import vibration
from cycloid_mj.parts import shaft_solid
from cycloid_mj.parts.gear import profile_offset, tooth_profile
from cycloid_mj.reducer import Reducer

LONG_STEP = "settings.timestep_us=10.0"


def fixed(*changes: str) -> Design:
    return override(PRESETS["pin"], ['ring.pins="fixed"', *changes])


def test_the_bare_unbalance_is_gear_and_cam_at_the_eccentricity() -> None:
    design = PRESETS["pin"]
    gear, play = design.gear, design.clearance
    holes = design.output.pins * math.pi * (design.output.hole_radius + play.output) ** 2
    disc = profile.area(tooth_profile(design), profile_offset(design))
    solid = disc - holes - math.pi * (gear.bore_radius + play.cam) ** 2 + math.pi * gear.bore_radius**2
    closed = design.material.density * gear.face_width * solid * gear.eccentricity
    assert unbalance(Reducer(design)).bare == pytest.approx(closed, rel=1e-4)


def test_the_counterweight_balances_the_force_and_leaves_the_couple() -> None:
    """The couple is the balancing force times the way from the gear's middle to the counterweight's."""
    design = PRESETS["pin"]
    found, counterweight = unbalance(Reducer(design)), shaft_solid(Reducer(design)).prisms[1]
    assert abs(found.balanced) < 1e-12 * found.bare
    middle = 0.5 * (counterweight.z0 + counterweight.z1)
    assert abs(found.couple) == pytest.approx(found.bare * abs(middle), rel=1e-9)


@pytest.mark.parametrize("pins", cases(["fixed", "free", "sleeved"], "fixed"))
def test_contact_forces_on_the_housing_are_weight_less_momentum(pins: str) -> None:
    """Sum of all forces on what moves: mass times acceleration; checked by the impulse over the run's second half."""
    step = "settings.timestep_us=10.0" if pins == "fixed" else "settings.timestep_us=1.0"
    quick = ["drive.ramp_s=0.0", "drive.hold_s=0.006", "load.torque_nm=20.0", "load.rise_s=0.003", step]
    design = override(PRESETS["pin"], [f'ring.pins="{pins}"', *quick, "settings.log_rate_hz=100000.0"])
    run = simulate(design)
    run = run.select(run.time > 0.003)
    of, span = body_masses(Reducer(design)), run.time[-1] - run.time[0]
    whole = reaction(run, Reducer(design)).total
    turned = np.stack([-np.sin(run["crank_angle"]), np.cos(run["crank_angle"])], axis=1)
    tangent = np.stack([-turned[:, 1], turned[:, 0]], axis=1) * run["crank_speed"][:, np.newaxis]
    momentum = of["gear"].mass * run.block(["gear_vx", "gear_vy"])
    momentum += of["shaft"].mass * of["shaft"].centroid[1] * tangent
    change = (momentum[-1] - momentum[0]) / span
    # Forces near 1000 N each are summed here; pins that rattle carry momentum of their own.
    assert whole.mean(axis=0) == pytest.approx(weight_force(Reducer(design)) - change, abs=0.15)
    assert np.abs(reaction(run, Reducer(design)).ring.mean(axis=0)).max() > 100.0


def test_without_the_counterweight_the_unbalance_rotates() -> None:
    design = fixed("drive.ramp_s=0.0", "drive.hold_s=0.002", LONG_STEP)
    run = simulate(design)
    added = without_counterweight(run, Reducer(design), np.zeros((len(run), 2)))
    assert np.hypot(*added.T) == pytest.approx(unbalance(Reducer(design)).bare * run["crank_speed"] ** 2, rel=1e-9)
    centre = run.block(["gear_x", "gear_y"])
    # Along the gear's centre, which stays within clearances of c.
    assert np.sum(added * centre, axis=1) / np.hypot(*centre.T) == pytest.approx(np.hypot(*added.T), rel=1e-4)


@pytest.fixture(scope="module")
def found() -> Measurement:
    design = fixed(LONG_STEP)
    return vibration(design, speeds=[1.5 * design.drive.speed])


@pytest.mark.slow
def test_the_measure_over_speed(found: Measurement) -> None:
    design = found.design
    speed = design.drive.speed
    orbit, bare = found.quantities["orbit_loaded"], found.quantities["housing_bare_rotating"]
    assert orbit.value == pytest.approx(design.gear.eccentricity * speed**2, rel=0.005)
    assert bare.value == pytest.approx(bare.reference, rel=0.005)
    assert found["housing_rotating"] < 0.01 * bare.value
    mean = found.quantities["mean_force_loaded"]
    assert mean.value == pytest.approx(mean.reference, rel=0.01)
    assert found["housing_bare_rms_loaded"] == pytest.approx(bare.reference, rel=0.02)
    sweep = {(round(row["speed_rpm"]), row["load"]): row for row in json.loads(json.dumps(found.as_json()))["sweep"]}
    assert sorted({rpm for rpm, _ in sweep}) == [1640, 2460]
    ratio = sweep[2460, "loaded"]["housing_bare_rms"] / sweep[1640, "loaded"]["housing_bare_rms"]
    assert ratio == pytest.approx(2.25, rel=0.01)
    error = found.quantities["gear_centre_rms_loaded"].error
    assert error is not None
    assert error < 0.1 * found["gear_centre_rms_loaded"]


@pytest.mark.parametrize(("load", "within"), [("unloaded", 0.15), ("loaded", 0.3)])
def test_a_spectrum_contains_the_power_of_its_signal(found: Measurement, load: str, within: float) -> None:
    curve = next(one for one in found.curves if one.panel.startswith("spectrum of the force") and one.name == load)
    low, high = (float(word) for word in curve.x_label.split("from ")[1].removesuffix(" Hz").split(" to "))
    whole = math.sqrt(0.5 * float(np.sum(curve.y**2)) / (SPECTRUM.padding * SPECTRUM.hann_bandwidth))
    # The spectrum ends at 0.4 of the log rate, the rms at half of it, and under load much lies there; the taper weighs
    # the middle of the turn more.
    assert whole == pytest.approx(found[f"housing_rms_{load}"], rel=within)
    assert high == pytest.approx(SPECTRUM.band * STEADY.log_rate, rel=0.05)
    assert low < 100.0
    assert curve.x[-1] <= 1.01 * SPECTRUM.band * STEADY.log_rate


@pytest.mark.parametrize(("load", "within"), [("unloaded", 0.01), ("loaded", 0.1)])
def test_the_force_on_the_housing_below_the_band_is_the_momentum(found: Measurement, load: str, within: float) -> None:
    """Two ways to the same force, both filtered: with pins that are fixed only gear and shaft have momentum."""
    one = found.quantities[f"housing_rms_{load}"]
    # Under load three quarters of the force's power lie above the band, some of it above what 10 us can sample.
    assert one.value == pytest.approx(one.reference, rel=within)


def test_power_above_the_band_is_reported(found: Measurement) -> None:
    for key in ("gear_centre", "output", "housing"):
        share = found.quantities[f"{key}_above_band_unloaded"]
        assert 0.0 <= share.value < 100.0
    assert found.quantities["output_above_band_unloaded"].value > 1.0
    assert found.as_json()["band_hz"] == pytest.approx(0.5 * STEADY.log_rate, rel=1e-3)
