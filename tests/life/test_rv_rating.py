"""Rating of an RV reducer: the crank bearings by ISO 281."""

import numpy as np
import pytest
from rv_runs import COULOMB_RV80E

from cycloid_mj.base.errors import UsageError
from cycloid_mj.design import override
from cycloid_mj.explore.rv_samples import draw_rv_drive
from cycloid_mj.life import as_built, rate
from cycloid_mj.life.as_built import SampleSettings
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.rv_sheet import solve_rv_equilibrium

RV80E = COULOMB_RV80E


def test_needles_last_6000_h_with_the_capacity_of_the_closed_form() -> None:
    """C = P (60 600 6000/1e6)^0.3 = 20.5 kN for 6000 h at 15 rpm of the output, so 600 rpm in the bearing."""
    rating = rate(override(RV80E, ["bearing.dynamic_capacity_n=20477"]))
    needles = rating.items["crank_needles"]
    assert needles.value == pytest.approx(4083.0, rel=1e-3)
    assert needles.life == pytest.approx(6000.0, rel=5e-3)
    assert "600 rpm mean speed" in needles.note


def test_two_cranks_need_half_as_much_more_capacity() -> None:
    items = rate(override(RV80E, ["cranks.count=2"])).items
    assert items["crank_needles"].value == pytest.approx(6124.0, rel=1e-3)


def test_flanges_carry_less_than_the_discs_because_opposed_forces_cancel_in_part() -> None:
    items = rate(RV80E).items
    assert items["crank_tapers"].value < items["crank_needles"].value
    one = rate(override(RV80E, ["gear.discs=1"])).items
    # the force of a single disc in the middle is shared equally by both flanges
    assert one["crank_tapers"].value == pytest.approx(0.5 * one["crank_needles"].value, rel=1e-6)


def test_rating_of_samples_requires_tolerances() -> None:
    with pytest.raises(UsageError, match=r"set at least one in the table \[crank_tolerance\]"):
        rate(RV80E, parts="toleranced")


def test_rated_samples_are_at_the_percentile_of_each_force(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 20 samples, the nineteenth largest of each force: forces of all samples are computed here one by one."""
    monkeypatch.setattr(as_built, "SETTINGS", SampleSettings(samples=20))
    design = RV80E.but(crank_tolerance={"bore_position": "uniform 6", "planet_runout": "uniform 20"})
    reducer = RvReducer(design)
    samples = as_built.select_rated_samples(reducer)
    forces = []
    for number in range(20):
        loads = solve_rv_equilibrium(RvReducer(draw_rv_drive(reducer, 0, number)[0]), 784.0, 61)
        means = np.mean(loads.bearings ** (10.0 / 3.0), axis=0) ** 0.3
        forces.append((loads.pins.max(), means.max(), loads.flanks.max()))
    ranks = np.argsort(np.array(forces), axis=0)
    assert set(samples.numbers) == set(ranks[18].tolist())
    rating, perfect = rate(reducer, parts="toleranced"), rate(RV80E)
    assert rating.parts == "toleranced"
    singles = [rate(sample).items for sample in samples.designs]
    for key in ("pin_gear_pitting", "crank_needles", "sun_pitting"):
        assert rating.items[key].life == min(items[key].life or 0.0 for items in singles)
        assert (rating.items[key].life or 0.0) < (perfect.items[key].life or 0.0)


def test_film_friction_adds_the_influence_of_the_lubricant() -> None:
    """Speed factor, and viscosity ratio at 20 °C, by hand: sun and planet have 2.089 m/s at the pitch point."""
    items = rate(RV80E.but(friction={"law": "film", "lubricant": "lithium grease 100"}), steady=False).items
    plain = rate(RV80E).items
    assert set(items) - set(plain) == {
        *("crank_needles_modified", "crank_tapers_modified"),
        *("pin_gear_pitting_lubricated", "sun_pitting_lubricated"),
    }
    # nu_1 = 45000 n^-0.83 d_m^-0.5 at 600 rpm and 29 mm
    kappa = 339.24 / (45000.0 * 600.0**-0.83 / 29.0**0.5)
    assert f"kappa {kappa:.3g}" in items["crank_needles_modified"].note
    speed = 0.85 + 0.08 + 2.0 * 0.07 / (0.8 + 32.0 / 2.089) ** 0.5
    assert f"Z_v {speed:.3g} (v 2.09 m/s" in items["sun_pitting_lubricated"].note
    for key in ("pin_gear_pitting", "sun_pitting"):
        assert items[f"{key}_lubricated"].life < items[key].life
    assert items["pin_gear_pitting_lubricated"].life == pytest.approx(1960.0, rel=0.01)


def test_a_stated_viscosity_modifies_the_life_of_bearings_without_film_friction() -> None:
    items = rate(RV80E.but(bearing={"viscosity": 30e-6})).items
    assert "= 30 mm2/s over nu_1" in items["crank_tapers_modified"].note
    assert "pin_gear_pitting_lubricated" not in items
