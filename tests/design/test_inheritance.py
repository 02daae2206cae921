"""What a short design file takes from a preset, and the motor of a file that states a load only."""

from pathlib import Path

import pytest

from cycloid_mj.base.errors import DesignError
from cycloid_mj.checks import check
from cycloid_mj.design import PRESETS, Design, find_inheritance, loads, value_of
from cycloid_mj.statics import main as statics


def test_a_base_is_the_preset_whose_values_a_file_keeps() -> None:
    design = loads('name = "mine"\n[base]\npreset = "Printed"\n[ring]\nteeth = 12\n')
    assert design == PRESETS["printed"].but(name="mine", ring={"teeth": 12})
    assert loads('[base]\npreset = "pin"\n') == Design()


@pytest.mark.parametrize(
    "base",
    ['preset = "pim"', "", 'preset = "pin"\nratio = 3', "preset = 3", "scaled = true", 'preset = "pin"\nscaled = 2.0'],
)
def test_another_base_is_refused(base: str) -> None:
    with pytest.raises(
        DesignError,
        match=r'must contain only preset = "NAME" and, .* scaled = .* Choose NAME from pin, nonpin, printed, twodisc',
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


SCALED = '[base]\npreset = "{}"\nscaled = true\n[ring]\npin_circle_radius_mm = {!r}\n'


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("factor", [0.3, 1.0, 3.0])
def test_a_scaled_preset_can_be_built_in_every_size(preset: str, factor: float) -> None:
    design = loads(SCALED.format(preset, factor * value_of(PRESETS[preset], "ring.pin_circle_radius_mm")))
    assert not check(design).failures
    for key, exponent in {"ring.pin_radius_mm": 1, "clearance.pin_gear_um": 1, "drive.torque_nm": 3}.items():
        assert value_of(design, key) == pytest.approx(factor**exponent * value_of(PRESETS[preset], key), rel=1e-12), key
    for key in ("drive.speed_rpm", "ring.teeth", "material.youngs_modulus_mpa", "friction.roughness_um"):
        assert value_of(design, key) == value_of(PRESETS[preset], key), key


def test_a_scaled_design_is_similar() -> None:
    """Backlash in angle and pressure stay the same; torsional stiffness, as torque over angle, grows with the cube."""
    small, large = (
        {
            key: item.value
            for key, item in statics(
                loads(SCALED.format("twodisc", radius)).but(friction={"law": "coulomb"})
            ).quantities.items()
        }
        for radius in (15.75, 157.5)
    )
    assert large["backlash"] == pytest.approx(small["backlash"], rel=1e-9)
    assert large["stiffness_contacts"] == pytest.approx(1000.0 * small["stiffness_contacts"], rel=1e-9)
    # the centrifugal force of the discs grows faster than the other forces
    assert large["pin_gear_pressure"] == pytest.approx(small["pin_gear_pressure"], rel=1e-3)


def test_stated_values_are_not_scaled_and_the_factor_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "small.toml"
    path.write_text(SCALED.format("pin", 20.375) + "[gear]\nface_width_mm = 10.0\n")
    taken = find_inheritance(path)
    assert taken is not None
    assert "from the preset pin ([base]), with its lengths scaled by 0.5 to the pin circle" in taken.note
    assert taken.values["gear.bore_radius_mm"] == pytest.approx(7.5)
    assert loads(path.read_text()).gear.face_width == 0.01
    assert taken.remedy == ()


@pytest.mark.parametrize("size", ["0.0", "-1.0", "true", "inf", '"x"', "1e9"])
def test_an_invalid_pin_circle_of_a_scaled_file_is_refused(size: str) -> None:
    with pytest.raises(DesignError, match=r"ring\.pin_circle_radius_mm"):
        loads(SCALED.format("pin", 1.0).replace("= 1.0", f"= {size}"))


def test_lengths_that_do_not_fit_the_pin_circle_are_named(tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    path.write_text("[ring]\npin_circle_radius_mm = 100.0\n")
    taken = find_inheritance(path)
    assert taken is not None
    (remedy,) = taken.remedy
    assert 'lengths are those of the preset pin, which has another pin circle: add preset = "pin" and scaled' in remedy
    path.write_text("[ring]\nteeth = 20\n")
    same_size = find_inheritance(path)
    assert same_size is not None
    assert same_size.remedy == ()
