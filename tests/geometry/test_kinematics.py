"""Eqs 12-20 (corrected) against 30-digit references, finite differences, and the equations as printed."""

import math
from pathlib import Path

import numpy as np
import pytest

from cycloid_mj.base.errors import DesignError
from cycloid_mj.geometry import kinematics
from cycloid_mj.geometry.kinematics import CrankLaw
from cycloid_mj.geometry.profile import CycloidGear

DATA = Path(__file__).parents[1] / "data"
PAPER = CycloidGear(ring_teeth=36, eccentricity=1e-3, pin_circle_radius=40.75e-3, pin_radius=2.25e-3)
SMALL = CycloidGear(ring_teeth=12, eccentricity=0.75e-3, pin_circle_radius=15e-3, pin_radius=1.5e-3)
FEW_TEETH = CycloidGear(ring_teeth=6, eccentricity=1.5e-3, pin_circle_radius=20e-3, pin_radius=4e-3)
each_gear = pytest.mark.parametrize("gear", [PAPER, SMALL, FEW_TEETH], ids=["paper", "small", "few-teeth"])
Q = np.array([0.0, 24e-3])
OMEGA = 1640 * 2 * math.pi / 60
MM = 1e-3
TABLES = {"traj_const_q0_24.csv": CrankLaw(OMEGA, 0.0), "traj_ramp_q0_24.csv": CrankLaw(OMEGA, 1.0)}


def reference(name: str) -> dict[str, np.ndarray]:
    """Columns by their first words: the headers of the last two hold commas and brackets."""
    names = [
        "t",
        "crank_deg",
        "omega",
        "Rx",
        "Ry",
        "vx",
        "vy",
        "v",
        "ax",
        "ay",
        "a",
        "v_18",
        "a_20_const",
        "a_20_printed",
    ]
    return dict(zip(names, np.loadtxt(DATA / name, delimiter=",", skiprows=1).T, strict=True))


def rotation_cw(angle: np.ndarray) -> np.ndarray:
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def assert_vectors_agree(got: np.ndarray, *expected_mm: np.ndarray) -> None:
    """Length of the difference against the length of the reference vector, so that single zeros do not matter."""
    expected = np.stack(expected_mm, axis=1) * MM
    difference = np.linalg.norm(got - expected, axis=1)
    assert np.all(difference <= 1e-9 * np.linalg.norm(expected, axis=1))


@pytest.mark.parametrize("table", TABLES)
def test_point_path_agrees_with_the_30_digit_reference(table):
    rows, law = reference(table), TABLES[table]
    theta = law.angle_at(rows["t"])
    assert np.all(np.abs(theta - np.radians(rows["crank_deg"])) <= 1e-9 * theta)
    assert np.all(np.abs(law.speed_at(rows["t"]) - rows["omega"]) <= 1e-9 * rows["omega"])
    path = kinematics.point_path(PAPER, Q, theta, law.speed_at(rows["t"]), law.acceleration_at(rows["t"]))
    assert_vectors_agree(path.position, rows["Rx"], rows["Ry"])
    assert_vectors_agree(path.velocity, rows["vx"], rows["vy"])
    assert_vectors_agree(path.acceleration, rows["ax"], rows["ay"])


@pytest.mark.parametrize("table", TABLES)
def test_closed_form_sizes_agree_with_the_30_digit_reference(table):
    rows, law = reference(table), TABLES[table]
    state = law.angle_at(rows["t"]), law.speed_at(rows["t"])
    speed = kinematics.point_speed(PAPER, Q, *state)
    assert np.all(np.abs(speed - rows["v_18"] * MM) <= 1e-9 * rows["v_18"] * MM)
    steady = kinematics.point_acceleration(PAPER, Q, *state)
    assert np.all(np.abs(steady - rows["a_20_const"] * MM) <= 1e-9 * rows["a_20_const"] * MM)
    full = kinematics.point_acceleration(PAPER, Q, *state, law.acceleration_at(rows["t"]))
    assert np.all(np.abs(full - rows["a"] * MM) <= 1e-9 * rows["a"] * MM)


@each_gear
def test_closed_form_sizes_are_the_norms_of_the_vectors(gear):
    rng = np.random.default_rng(3)
    theta, speed, acceleration = rng.uniform(-9, 9, 50), rng.uniform(-5, 5, 50), rng.uniform(-30, 30, 50)
    for q in rng.uniform(-0.03, 0.03, (5, 2)):
        path = kinematics.point_path(gear, q, theta, speed, acceleration)
        norms = np.linalg.norm(path.velocity, axis=1), np.linalg.norm(path.acceleration, axis=1)
        assert kinematics.point_speed(gear, q, theta, speed) == pytest.approx(norms[0], rel=1e-10)
        got = kinematics.point_acceleration(gear, q, theta, speed, acceleration)
        assert got == pytest.approx(norms[1], rel=1e-10)


def errors_of_differences(gear: CycloidGear, law: CrankLaw, time: np.ndarray, h: float) -> np.ndarray:
    """Largest error of central differences of position and of velocity, for a general point and for the centre."""

    def at(t: np.ndarray) -> tuple[np.ndarray, ...]:
        theta, speed, acceleration = law.angle_at(t), law.speed_at(t), law.acceleration_at(t)
        path = kinematics.point_path(gear, [7e-3, -11e-3], theta, speed, acceleration)
        return (
            path.position,
            path.velocity,
            path.acceleration,
            kinematics.gear_centre(gear, theta),
            kinematics.gear_centre_velocity(gear, theta, speed),
            kinematics.gear_centre_acceleration(gear, theta, speed, acceleration),
        )

    ahead, here, back = at(time + h), at(time), at(time - h)
    return np.array([np.abs((ahead[i] - back[i]) / (2 * h) - here[i + 1]).max() for i in (0, 1, 3, 4)])


@each_gear
@pytest.mark.parametrize("law", [CrankLaw(5.0, 0.0), CrankLaw(5.0, 2.0), CrankLaw(-5.0, 2.0)])
def test_velocity_and_acceleration_are_second_order_limits_of_differences(gear, law):
    time = np.linspace(0.1, 1.9, 61)
    order = np.log2(errors_of_differences(gear, law, time, 4e-3) / errors_of_differences(gear, law, time, 2e-3))
    assert np.abs(order - 2).max() < 0.01


def test_without_the_tangential_term_the_ramp_fails():
    rows, law = reference("traj_ramp_q0_24.csv"), TABLES["traj_ramp_q0_24.csv"]
    path = kinematics.point_path(PAPER, Q, law.angle_at(rows["t"]), law.speed_at(rows["t"]))
    with pytest.raises(AssertionError):
        assert_vectors_agree(path.acceleration, rows["ax"], rows["ay"])


def test_the_printed_equations_13_and_14_are_wrong():
    speed = np.linalg.norm(kinematics.gear_centre_velocity(PAPER, 0.4, OMEGA))
    size = np.linalg.norm(kinematics.gear_centre_acceleration(PAPER, 0.4, OMEGA))
    assert speed / MM == pytest.approx(171.740398396242, rel=1e-12)
    assert size / MM == pytest.approx(29494.76, abs=0.005)
    printed = PAPER.eccentricity * abs(float(kinematics.gear_speed(OMEGA, PAPER.lobes)))
    assert speed / printed == pytest.approx(35.0)


def test_the_printed_equation_17_is_wrong():
    rows = reference("traj_const_q0_24.csv")
    zeta, zeta_dot = np.radians(rows["crank_deg"]) / 35, OMEGA / 35
    carried = np.stack([24 * np.cos(zeta), -24 * np.sin(zeta)], axis=1)
    orbit = 35 * np.stack([np.cos(35 * zeta), np.sin(35 * zeta)], axis=1)
    assert_vectors_agree(zeta_dot * (carried - orbit) * MM, rows["vx"], rows["vy"])
    with pytest.raises(AssertionError):
        assert_vectors_agree(zeta_dot * (carried + orbit) * MM, rows["vx"], rows["vy"])


def test_the_printed_equation_20_is_wrong():
    rows = reference("traj_const_q0_24.csv")
    got = kinematics.point_acceleration(PAPER, Q, np.radians(rows["crank_deg"]), OMEGA)
    turn = 36 * np.radians(rows["crank_deg"]) / 35
    printed = (OMEGA / 35) ** 2 * np.sqrt(35**4 + 24**2 - 2 * 35**2 * 24 * np.cos(turn)) * MM
    assert printed == pytest.approx(rows["a_20_printed"] * MM, rel=1e-12)
    assert np.abs(got / printed - 1).max() > 0.03


@each_gear
def test_rotation_and_pitch_point_are_those_of_rolling_circles(gear):
    theta, speed = 0.8, 3.0
    q = rotation_cw(-theta / gear.lobes) @ (gear.lobes * kinematics.gear_centre(gear, theta))
    at_rest = kinematics.point_path(gear, q, theta, speed)
    moving = kinematics.point_path(gear, 0.9 * q, theta, speed)
    # The pitch point, c N from the axis along the eccentric, is the gear's instantaneous centre.
    assert np.linalg.norm(at_rest.velocity) < 1e-16
    assert np.linalg.norm(moving.velocity) > 1e-4
    expected = gear.ring_teeth * kinematics.gear_centre(gear, theta) - [0, gear.eccentricity]
    assert at_rest.position == pytest.approx(expected, abs=1e-16)
    step = kinematics.gear_rotation(gear, theta + 1.0) - kinematics.gear_rotation(gear, theta)
    assert step == pytest.approx(kinematics.gear_speed(1.0, gear.lobes), rel=1e-14)
    assert step == pytest.approx(-1 / (gear.ring_teeth - 1))


def test_speed_at_the_pitch_point_is_zero_and_not_nan():
    assert kinematics.point_speed(PAPER, [0.0, 35e-3], np.linspace(0, 1e-7, 50), OMEGA).max() < 1e-6


def test_one_angle_yields_one_vector_and_rest_is_the_default():
    path = kinematics.point_path(PAPER, Q, 0.0)
    assert path.position == pytest.approx(Q)
    assert path.position.shape == (2,)
    assert not path.velocity.any()
    assert not path.acceleration.any()


def test_crank_law_ramps_and_then_holds():
    law = CrankLaw(speed=10.0, ramp=2.0)
    time = np.array([-1.0, 0.0, 1.0, 2.0, 3.0])
    assert law.angle_at(time) == pytest.approx([0, 0, 2.5, 10, 20])
    assert law.speed_at(time) == pytest.approx([0, 0, 5, 10, 10])
    assert law.acceleration_at(time) == pytest.approx([0, 5, 5, 0, 0])
    sudden = CrankLaw(speed=10.0, ramp=0.0)
    assert sudden.angle_at(time) == pytest.approx([0, 0, 10, 20, 30])
    assert sudden.speed_at(time) == pytest.approx([0, 10, 10, 10, 10])
    assert sudden.acceleration_at(time) == pytest.approx(np.zeros(5))
    assert CrankLaw(10.0, 1e-9).angle_at(3.0) == pytest.approx(sudden.angle_at(3.0))


@pytest.mark.parametrize(("speed", "ramp"), [(10.0, -0.1), (math.nan, 1.0), (10.0, math.inf)])
def test_crank_laws_that_cannot_be_are_refused(speed, ramp):
    with pytest.raises(DesignError, match="crank speed"):
        CrankLaw(speed, ramp)
