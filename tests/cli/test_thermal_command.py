"""Warnings and errors of ``cycloid-mj thermal``."""

import pytest
from commands import told


@pytest.mark.parametrize(
    ("words", "warning"),
    [
        (
            ["--load-nm", "20", "--set", "service.grease_temperature_c=60"],
            "too hot at 20 N m (limit: 60 °C, grease): reduce the torque to 14.5 N m",
        ),
        (["--load-nm", "10"], ""),
        (["--load-nm", "1", "--set", "service.ambient_temperature_c=150"], "lower service.ambient_temperature_c"),
        (["--load-nm", "10", "--at-c", "60"], "those of the design are not used (60 °C)"),
    ],
)
def test_excess_heat_and_ignored_temperatures_are_warned_of(words: list[str], warning: str) -> None:
    code, out, _ = told("thermal", "pin", *words)
    assert code == 0
    assert warning in " ".join(out.split())
    assert bool(warning) == ("warn " in out)


@pytest.mark.parametrize(
    ("words", "allowed"),
    [
        (["--at-c", "-300"], "--at-c -300: must be at least -100 and at most 300 [°C]"),
        (["--at-c", "nan"], "--at-c nan: must be at least -100 and at most 300 [°C]"),
        (["--load-nm", "0"], "--load-nm 0: must be at least -1000000 and at most 1000000, not 0 [N m]"),
    ],
)
def test_a_flag_out_of_range_is_named_with_its_range(words: list[str], allowed: str) -> None:
    code, out, err = told("thermal", "pin", *words)
    assert (code, out) == (2, "")
    assert allowed in err
