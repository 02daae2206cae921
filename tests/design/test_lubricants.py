"""Table of lubricants: Walther's viscosity, Gold's pressure coefficient, and the ranges of the plastics."""

import math

import pytest

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import PRESETS, override
from cycloid_mj.design.lubricants import lubricant, lubricant_warnings, lubricants, plastic_pairs, walther

GRADES = (32, 46, 68, 100, 150, 220, 320, 460)


@pytest.mark.parametrize("base", ["mineral", "PAO", "PAG", "ester"])
def test_all_grades_of_a_base_oil_exist(base: str) -> None:
    for grade in GRADES:
        oil = lubricant(f"{base} {grade}")
        assert oil.kinematic_viscosity(40.0) == pytest.approx(grade)
        assert oil.kinematic_viscosity(100.0) == pytest.approx(oil.viscosity_100)
        assert oil.source
        assert not oil.thickener


def test_walther_is_a_straight_line_in_its_coordinates() -> None:
    temperatures = (0.0, 20.0, 60.0, 80.0)
    points = [
        (math.log10(273.15 + t), math.log10(math.log10(walther(100.0, 11.2, t) + 0.7))) for t in (*temperatures, 40.0)
    ]
    slopes = [(y - points[-1][1]) / (x - points[-1][0]) for x, y in points[:-1]]
    assert slopes == pytest.approx([slopes[0]] * len(slopes))


@pytest.mark.parametrize(
    ("base", "expected"), [("mineral", 1.84e-8), ("PAO", 1.34e-8), ("PAG", 1.07e-8), ("ester", 1.21e-8)]
)
def test_pressure_coefficients_at_87_mm2_per_s(base: str, expected: float) -> None:
    oil = lubricant(f"{base} 100")
    low, high = 20.0, 90.0
    for _ in range(60):  # temperature at which the oil has this viscosity
        middle = 0.5 * (low + high)
        low, high = (middle, high) if oil.kinematic_viscosity(middle) > 87.0 else (low, middle)
    assert oil.pressure_coefficient(low) == pytest.approx(expected, rel=5e-3)


def test_dynamic_viscosity_has_the_density_of_the_temperature() -> None:
    oil = lubricant("mineral 100")
    assert oil.viscosity(40.0) == pytest.approx(100e-6 * (880.0 - 0.65 * 25.0))


def test_every_grease_has_a_base_oil_and_a_thickener() -> None:
    greases = [item for item in lubricants().values() if item.thickener]
    assert len(greases) >= 6
    for grease in greases:
        assert grease.viscosity_40 > grease.viscosity_100 > 1.0
        assert grease.base in ("mineral", "PAO", "PAG", "ester")


def test_a_name_is_found_in_any_case_and_an_unknown_one_is_corrected() -> None:
    assert lubricant("pao 150") is lubricant("PAO 150")
    with pytest.raises(DesignError, match='did you mean "PAO 150"'):
        lubricant("PAO 15O")


def test_grease_lowers_the_friction_of_plastics() -> None:
    for pair in plastic_pairs().values():
        assert pair.greased[0] < pair.greased[1] < pair.dry[1]
        assert pair.dry[0] < pair.dry[1]
        assert 1e4 < pair.pv_limit < 1e6


def test_temperatures_outside_the_range_of_the_lubricant_are_warned_of() -> None:
    """At -60 °C, statics printed an efficiency of 0.9 % without a warning."""
    film = override(PRESETS["pin"], ["friction.law=film"])
    assert list(lubricant_warnings(film)) == []
    assert list(lubricant_warnings(override(film, ["thermal.disc_c=100", "thermal.ring_c=-20"]))) == []
    (cold,) = lubricant_warnings(override(film, ["thermal.disc_c=-60", "thermal.ring_c=-21"]))
    assert "outside the range of lithium grease 100, -20 to 100 °C: disc -60 °C, ring -21 °C." in cold
    assert "choose another friction.lubricant, such as low-temperature grease 18 (to -50 °C)" in cold
    (hot,) = lubricant_warnings(override(film, ["thermal.crank_c=101"]))
    assert "crank 101 °C" in hot
    assert "set service.grease_temperature_c to the limit of your lubricant" in hot
    (air,) = lubricant_warnings(override(film, ["service.ambient_temperature_c=-40"]))
    assert ": air -40 °C." in air
    grease = ["service.ambient_temperature_c=-40", 'friction.lubricant="low-temperature grease 18"']
    assert list(lubricant_warnings(override(film, grease))) == []
    assert list(lubricant_warnings(override(PRESETS["pin"], ["thermal.disc_c=-60"]))) == [], "no film"
    assert list(lubricant_warnings(override(film, ["thermal.disc_c=-60", "thermal.applied=true"]))) == [], "a log"
