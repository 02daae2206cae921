"""Modified rating life of ISO 281:2007: its curves, viscosity ratio, fatigue load limit, and the item of a rating."""

import math

import pytest

from cycloid_mj.base.units import RPM
from cycloid_mj.design import PRESETS, override
from cycloid_mj.design.lubricants import lubricant
from cycloid_mj.life import rate
from cycloid_mj.life.bearings import oil_viscosity
from cycloid_mj.life.modified_life import (
    BALLS,
    LIMITS,
    ROLLERS,
    LifeCurve,
    fatigue_load_limit,
    life_factor,
    reference_viscosity,
)
from cycloid_mj.reducer import Reducer


def test_factor_matches_hand_calculations() -> None:
    """Rollers at kappa 1, e_C C_u/P 1: 0.1 (1 - 0.3511)^-9.185 = 5.31; balls at kappa 1, 0.1: 0.1 (1 - 0.2904)^-9.3."""
    assert life_factor(1.0, 1.0, 1.0, 1.0, ROLLERS) == pytest.approx(0.1 * (1.0 - 0.3511) ** -9.185, rel=1e-6)
    film = (2.5671 - 1.9987) ** 0.83
    assert life_factor(1.0, 0.5, 0.2, 1.0, BALLS) == pytest.approx(0.1 * (1.0 - film * 0.1 ** (1 / 3)) ** -9.3)


@pytest.mark.parametrize("curve", [BALLS, ROLLERS])
@pytest.mark.parametrize("kappa", [0.4, 1.0])
def test_branches_meet(curve: LifeCurve, kappa: float) -> None:
    """The standard's branches agree at their ends to its printed digits."""
    below, above = (life_factor(kappa * factor, 0.5, 0.2, 1.0, curve) for factor in (1.0 - 1e-9, 1.0 + 1e-9))
    assert below == pytest.approx(above, rel=2e-3)


def test_factor_stays_in_its_range() -> None:
    assert life_factor(10.0, 1.0, 1.0, 1.0, BALLS) == LIMITS.max_factor
    assert life_factor(9.0, 0.5, 0.2, 1.0, ROLLERS) == life_factor(4.0, 0.5, 0.2, 1.0, ROLLERS)
    assert life_factor(0.05, 1.0, 1.0, 1.0, ROLLERS) == LIMITS.min_factor
    assert life_factor(1.0, 0.0, 1.0, 1.0, ROLLERS) == pytest.approx(LIMITS.min_factor)


def test_reference_viscosity_and_load_limit() -> None:
    """d_m 64 mm: 4500/sqrt(1500 * 64) = 14.5 mm2/s at 1500 rpm, 45000 * 100^-0.83/8 = 123 at 100 rpm."""
    assert reference_viscosity(1500.0 * RPM, 0.064) == pytest.approx(4500.0 / math.sqrt(1500.0 * 64.0))
    assert reference_viscosity(-100.0 * RPM, 0.064) == pytest.approx(45000.0 * 100.0**-0.83 / 8.0)
    assert fatigue_load_limit(8200.0, 0.05, ROLLERS) == pytest.approx(1000.0)
    assert fatigue_load_limit(8200.0, 0.2, ROLLERS) == pytest.approx(1000.0 * 0.5**0.3)


def test_rating_states_the_modified_life_next_to_l10() -> None:
    plain = rate(PRESETS["pin"], stops=False).items
    assert not any(key.endswith("_modified") for key in plain)
    oiled = rate(override(PRESETS["pin"], {"bearing.viscosity_mm2_s": 20.0}), stops=False).items
    item = oiled["cam_bearing_modified"]
    assert oiled["cam_bearing"].life == plain["cam_bearing"].life
    factor = float(item.note.split()[1].rstrip(":"))
    assert item.life == pytest.approx(factor * plain["cam_bearing"].life, rel=5e-3)
    assert "e_C 0.5" in item.note
    thin = rate(override(PRESETS["pin"], {"bearing.viscosity_mm2_s": 5.0}), stops=False).items
    assert thin["cam_bearing_modified"].life < item.life


def test_the_lubricant_of_the_film_law_sets_the_viscosity() -> None:
    """That of PAO 150 at the temperature of the parts; a stated viscosity takes precedence."""
    oiled = override(PRESETS["pin"], {"friction.law": "film", "friction.lubricant": "PAO 150"})
    warm = oiled.but(thermal=dict.fromkeys(("disc", "ring", "crank", "output"), 60.0))
    assert 1e6 * oil_viscosity(Reducer(warm)) == pytest.approx(lubricant("PAO 150").kinematic_viscosity(60.0))
    assert oil_viscosity(Reducer(warm.but(bearing={"viscosity": 2e-5}))) == 2e-5
    assert oil_viscosity(Reducer(PRESETS["pin"])) == 0.0
