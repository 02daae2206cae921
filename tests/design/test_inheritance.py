"""What a short design file takes from a preset, and the motor of a file that states a load only."""

from pathlib import Path

import pytest

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import PRESETS, Design, find_inheritance, loads


def test_a_base_is_the_preset_whose_values_a_file_keeps() -> None:
    design = loads('name = "mine"\n[base]\npreset = "Printed"\n[ring]\nteeth = 12\n')
    assert design == PRESETS["printed"].but(name="mine", ring={"teeth": 12})
    assert loads('[base]\npreset = "pin"\n') == Design()


@pytest.mark.parametrize("base", ['preset = "pim"', "", 'preset = "pin"\nratio = 3', "preset = 3"])
def test_another_base_is_refused(base: str) -> None:
    with pytest.raises(
        DesignError, match=r'must contain only preset = "NAME"\. Choose NAME from pin, nonpin, printed, twodisc'
    ):
        loads(f"[base]\n{base}\n")


def test_the_values_of_the_preset_are_listed(tmp_path: Path) -> None:
    path = tmp_path / "short.toml"
    path.write_text("[ring]\nteeth = 20\n[gear]\neccentricity_mm = 1.0\n")
    taken = find_inheritance(path, ["drive.speed_rpm=1000"])
    assert taken is not None
    assert not taken.is_stated
    assert taken.motor == ("drive.torque_nm",)
    assert taken.values["output.hole_radius_mm"] == 5.0
    assert not taken.values.keys() & {"ring.teeth", "gear.eccentricity_mm", "drive.speed_rpm", "clearance.tooth_um"}
    assert 'are taken from the preset pin (the default; [base] preset = "pin" states it)' in taken.note
    assert find_inheritance("pin") is None


def test_a_given_base_needs_no_warning(tmp_path: Path) -> None:
    path = tmp_path / "stated.toml"
    path.write_text('[base]\npreset = "printed"\n')
    taken = find_inheritance(path)
    assert taken is not None
    assert taken.is_stated
    assert taken.motor == ()
    assert taken.values["drive.torque_nm"] == 0.8


def test_a_file_with_a_load_and_no_motor_has_a_motor_for_it(tmp_path: Path) -> None:
    text = "[ring]\nteeth = 21\n[load]\ntorque_nm = 5.0\n"
    design = loads(text)
    assert design.rated_torque == pytest.approx(5.0)
    assert design.drive.power == pytest.approx(0.25 * design.drive.speed)
    path = tmp_path / "load.toml"
    path.write_text(text)
    taken = find_inheritance(path)
    assert taken is not None
    assert taken.motor == ("drive.speed_rpm",)
    assert loads(f"{text}[drive]\ntorque_nm = 1.0\n").rated_torque == pytest.approx(20.0)
