"""Waves of the gear's profile by order: exact outlines, statics, and slow runs that must find what statics finds."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from cycloid_mj.base.array import Array
from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.record import Run
from cycloid_mj.base.units import ARCSECONDS
from cycloid_mj.design import PRESETS, Design, dump, loads, override
from cycloid_mj.dynamics.contact.gap import Flank, Trochoid, flank_distance
from cycloid_mj.dynamics.contact.teeth import USER_DATA
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.mjcf.mesh import build_mesh
from cycloid_mj.dynamics.mjcf.model import xml
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.deviations import deviations, profile_error
from cycloid_mj.geometry.kinematics import gear_centre, gear_rotation
from cycloid_mj.geometry.modification import gear_profile, profile_offset
from cycloid_mj.geometry.profile import unit
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.gaps import arc_gaps
from cycloid_mj.statics.balance import loads as static_loads
from cycloid_mj.statics.springs import springs_of
from cycloid_mj.statics.structure import wind_up
from cycloid_mj.validate.gaps import rotate

TORQUE = 30.0
ORDERS = 12
"""Of the transmission error that are compared, from the first."""


def waved(preset: str, size: float, *changes: str) -> Design:
    """A design with waves of some orders, the largest of 2 um times a size; runs of it are slow and frictionless."""
    lobes = PRESETS[preset].lobes
    cosines = f"errors.profile_cos_um={{2 = {2.0 * size}, 3 = {-1.5 * size}}}"
    sines = f"errors.profile_sin_um={{5 = {1.0 * size}, {lobes} = {0.5 * size}}}"
    kinds = ("pin_gear", "pin_socket", "tooth", "cam", "cam_rolling", "output", "output_rolling")
    free = ["friction.law=coulomb", *(f"friction.{kind}=0" for kind in kinds), "environment.gravity_y_m_s2=0"]
    slow = ["drive.speed_rpm=600", "drive.ramp_s=0", "drive.hold_s=0.12", "load.rise_s=0.01"]
    settings = [f"load.torque_nm={TORQUE}", "settings.timestep_us=10", "settings.log_rate_hz=4000"]
    return override(PRESETS[preset], [cosines, sines, *free, *slow, *settings, *changes])


def settled(design: Design) -> Run:
    """The samples of one turn of the crank, after the load has come on."""
    run = simulate(design)
    assert not run.warnings
    return run.select(run.time > 0.02)


def orders(error: Array) -> Array:
    """Amplitudes of the first orders in the turn [arcsec], with their phases, complex, shape (ORDERS,)."""
    return np.fft.rfft(ARCSECONDS * error)[1 : ORDERS + 1] * 2.0 / len(error)


def compared(design: Design) -> tuple[Array, Array, Array, Array]:
    """Orders of the transmission error in a run and in statics, and forces on the teeth [N] in both, (samples, n)."""
    run = settled(design)
    found = static_loads(
        Reducer(design), springs_of(Reducer(design), run["crank_angle"], friction=False), TORQUE, warm_start=True
    )
    # a run's output is the model's: what carrier and shaft twist is beyond it
    turned = found.output_turn - wind_up(Reducer(design)) * TORQUE
    seen = orders(run["output_angle"] - Reducer(design).member.output_angle(run["crank_angle"]))
    return seen, orders(turned), np.linalg.norm(run.forces(design.tooth_pair), axis=2), found.teeth


@pytest.mark.slow
@pytest.mark.parametrize("pins", ["fixed", "massless"])
def test_a_slow_run_finds_what_statics_finds(pins: str) -> None:
    """Order by order and tooth by tooth; statics is of first order in the waves, so that is what parts them."""
    apart = []
    for size in (0.5, 1.0):
        run, statics, forces, expected = compared(waved("pin", size, f"ring.pins={pins}"))
        assert np.abs(statics).max() > 2.0
        assert np.abs(run - statics).max() < 0.01 * np.abs(statics).max()
        assert np.abs(forces - expected).max() < 0.02 * expected.max()
        apart.append(np.abs(forces - expected).max())
    assert apart[1] > 2.0 * apart[0]


@pytest.mark.slow
def test_two_discs_have_the_waves_each_at_its_place() -> None:
    run, statics, forces, expected = compared(waved("twodisc", 0.5))
    assert np.abs(statics).max() > 1.0
    assert np.abs(run - statics).max() < 0.01 * np.abs(statics).max()
    assert np.abs(forces - expected).max() < 0.02 * expected.max()


@pytest.mark.slow
def test_the_normal_is_the_gradient_of_the_gap() -> None:
    """By differences, on either side of the trochoid and as far from it as half of the valley's radius of curvature."""
    rng, away, step = np.random.default_rng(2), 9e-6, 1e-9
    waves = 1e-6 * rng.uniform(-1.0, 1.0, (35, 2))
    flank = Flank(Trochoid(40.75e-3, 1e-3, 36.0), 2.25e-3, 0.0, 0.0, 0.0, 0.0, 0.0, waves)
    gear = gear_profile(PRESETS["pin"])
    t = rng.uniform(0.0, 2.0 * np.pi, 200)
    t[::4] = 2.0 * np.pi / 35.0 * rng.integers(0, 35, 50) + rng.uniform(-1e-3, 1e-3, 50)  # in valleys
    for x, y in profile.trochoid(gear, t) + rng.uniform(-away, away, (200, 1)) * profile.normals(gear, t):
        across = flank_distance(x + step, y, flank)[1] - flank_distance(x - step, y, flank)[1]
        upwards = flank_distance(x, y + step, flank)[1] - flank_distance(x, y - step, flank)[1]
        size = np.hypot(across, upwards)
        assert flank_distance(x, y, flank)[2:4] == pytest.approx((across / size, upwards / size), abs=1e-5)


def test_waves_of_nothing_leave_the_model_as_it_is() -> None:
    plain, none = PRESETS["pin"], override(PRESETS["pin"], ["errors.profile_cos_um={2 = 0.0}"])
    assert build(plain).model.nuser_geom == USER_DATA
    assert xml(build(none).spec) == xml(build(plain).spec)


def test_a_model_has_as_many_numbers_as_its_last_wave_needs() -> None:
    model = build(waved("pin", 1.0)).model
    numbers = model.geom("teeth").user[USER_DATA:].reshape(-1, 2)
    np.testing.assert_allclose(numbers, deviations(waved("pin", 1.0)).waves[:35], rtol=1e-11)


@pytest.mark.parametrize("preset", ["pin", "nonpin"])
def test_waves_of_the_profile_widen_gaps_as_the_exact_outline_does(preset: str) -> None:
    """Places of the ring's pins, or the middles of its arcs, against a fine polygon of the wavy outline."""
    changes = ["clearance.pin_gear_um=30.0", "clearance.tooth_um=30.0", "errors.profile_cos_um={2 = 1.5, 3 = -0.7}"]
    design = override(PRESETS[preset], [*changes, "errors.profile_sin_um={2 = 0.4, 35 = 0.8}"])
    crank, gear, made = 0.7, gear_profile(design), deviations(design)
    t = np.linspace(0.0, 2.0 * np.pi, 400_001)[:-1]
    back = profile_offset(design) + profile_error(made.waves, t)
    outline = profile.trochoid(gear, t) - back[:, np.newaxis] * profile.normals(gear, t)
    turned = rotate(outline, float(gear_rotation(gear, crank))) + gear_centre(gear, crank)
    pins = gear.pin_circle_radius * unit(profile.pin_angles(gear))
    near, _ = cKDTree(turned).query(pins)
    found = arc_gaps(Reducer(design), crank)
    count = design.ring.teeth
    # in the valleys the nearest point of a polygon lies beside the foot: there nothing carries
    flat = np.abs(found.curvature[:count]) < 500.0
    assert flat.sum() > 0.7 * count
    # what is left is of second order in the waves: their slope turns the normal
    np.testing.assert_allclose((near - gear.pin_radius)[flat], found.width[:count][flat], atol=6e-9)
    assert np.ptp(found.width[:count]) > 2e-6


def test_convex_slices_refuse_waves_of_the_profile() -> None:
    with pytest.raises(DesignError, match="profile_cos_um"):
        build_mesh(Reducer(override(PRESETS["pin"], ["errors.profile_cos_um={2 = 1.0}"])))


def test_waves_are_no_ideal_parts_and_survive_the_file() -> None:
    design = override(PRESETS["pin"], ["errors.profile_sin_um={35 = 1.0}"])
    assert not Reducer(design).is_ideal
    assert loads(dump(design)) == design
