"""Lubricant factors of ISO 6336-2 for pitting: reference conditions, worked values, and the items of a rating."""

import math

import pytest

from cycloid_mj.design import PRESETS, override
from cycloid_mj.life import rate
from cycloid_mj.life.pitting_factors import (
    FULL_CYCLES,
    STATIC_CYCLES,
    lubricant_factor,
    lubricated_cycles,
    relative_roughness,
    roughness_factor,
    speed_factor,
)
from cycloid_mj.life.surfaces import AGMA_2001


@pytest.mark.parametrize("limit", [600e6, 1000e6, 1500e6])
def test_factors_are_1_at_the_conditions_of_the_reference_gear(limit: float) -> None:
    """134/1.2-1: 167.5 mm2/s at 40 °C, which is about 100 at 50 °C; 10 m/s; Rz10 of 3 um."""
    assert lubricant_factor(167.5, limit) == pytest.approx(1.0)
    assert speed_factor(10.0, limit) == pytest.approx(1.0)
    assert roughness_factor(3.0, limit) == pytest.approx(1.0)


def test_factors_match_hand_calculations() -> None:
    """Case-hardened: C_ZL 0.91, C_Zv 0.93, C_ZR 0.08; soft: 0.83, 0.85, 0.15; 1025 MPa is half way."""
    assert lubricant_factor(100.0, 1500e6) == pytest.approx(0.91 + 0.36 / 2.54**2)
    assert speed_factor(1.0, 1500e6) == pytest.approx(0.93 + 0.14 / math.sqrt(32.8))
    assert roughness_factor(6.0, 800e6) == pytest.approx(0.5**0.15)
    assert lubricant_factor(100.0, 1025e6) == pytest.approx(0.87 + 0.52 / 2.54**2)
    assert relative_roughness(0.4e-6, 10e-3) == pytest.approx(6.0 * 0.7979 * 0.4 / math.sqrt(2.0), rel=1e-4)
    assert speed_factor(0.0, 800e6) == 0.85


@pytest.mark.parametrize("factor", [0.85, 1.05])
def test_the_factors_grow_into_the_curve_between_static_and_full_cycles(factor: float) -> None:
    power = AGMA_2001.power
    assert lubricated_cycles(STATIC_CYCLES, factor, power) == STATIC_CYCLES
    assert lubricated_cycles(1e10, factor, power) == pytest.approx(1e10 * factor ** (1.0 / power))
    cycles = lubricated_cycles(3e6, factor, power)
    share = math.log(cycles / STATIC_CYCLES) / math.log(FULL_CYCLES / STATIC_CYCLES)
    assert 0.0 < share < 1.0
    assert cycles == pytest.approx(3e6 * factor ** (share / power), rel=1e-9)


def test_rating_states_pitting_with_the_lubricant_under_film() -> None:
    oiled = rate(override(PRESETS["nonpin"], {"friction.law": "film"}), stops=False).items
    item, plain = oiled["tooth_pitting_lubricated"], oiled["tooth_pitting"]
    assert 0.7 * plain.limit < item.limit < plain.limit
    assert "Z_L" in item.note
    assert not any(key.endswith("_lubricated") for key in rate(PRESETS["nonpin"], stops=False).items)
