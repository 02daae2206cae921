"""Motors: their interfaces, and the frame for the torque and speed of a design."""

import pytest

from cycloid_mj.base.errors import UsageError
from cycloid_mj.cli.export import MotorInterface
from cycloid_mj.design import resolve
from cycloid_mj.parts.export.casing import casing, motor_centres
from cycloid_mj.parts.export.motors import MOTORS, MotorFlange, frames_for
from cycloid_mj.reducer import Reducer

RPM = 0.10471975511965977


@pytest.mark.parametrize(
    ("torque", "speed", "frame"),
    [(0.3, 1000.0, "NEMA 17"), (0.4, 4000.0, "NEMA 23"), (1.5, 600.0, "NEMA 23"), (4.0, 600.0, "NEMA 34")],
)
def test_the_smallest_frame_that_is_strong_enough_is_chosen(torque: float, speed: float, frame: str) -> None:
    assert frames_for(torque, speed * RPM)[0].name == frame


def test_no_frame_drives_too_much() -> None:
    assert frames_for(20.0, 100.0 * RPM) == ()
    assert frames_for(2.0, 10_000.0 * RPM) == ()


def test_a_small_drive_gets_a_small_motor_although_a_larger_one_fits() -> None:
    weak = resolve("pin", {"drive.torque_nm": 0.2})
    sizes = {name: casing(Reducer(weak), name) for name in ("nema23", "auto")}
    assert sizes["nema23"].motor.name == "NEMA 23"
    assert sizes["auto"].motor in (MOTORS["nema17"], MOTORS["nema23"])
    assert casing(Reducer(resolve("pin", {"drive.torque_nm": 20.0}))).motor.name == "bolt circle"


def test_a_custom_motor_flange_has_the_given_circle_screws_and_shaft() -> None:
    flags = MotorInterface(motor_circle_mm=70.0, motor_thread_mm=4.0, motor_shaft_mm=8.0, motor_screws=6)
    motor = flags.choose_motor()
    assert isinstance(motor, MotorFlange)
    sizes = casing(Reducer(resolve("pin")), motor)
    assert sizes.motor.shaft == pytest.approx(4e-3)
    centres = motor_centres(sizes)
    assert centres.shape == (6, 2)
    assert (centres**2).sum(axis=1) ** 0.5 == pytest.approx(35e-3)
    assert MotorInterface(motor="bldc25", motor_shaft_mm=5.0).choose_motor().circle == pytest.approx(12.5e-3)
    with pytest.raises(UsageError, match="--motor-circle-mm"):
        MotorInterface(motor_shaft_mm=5.0).choose_motor()
    with pytest.raises(UsageError, match="not an available thread size"):
        MotorInterface(motor="nema17", motor_thread_mm=7.0).choose_motor()
