"""Sweeps of RV reducers: their rows are single results, and measures without support are refused at once."""

import pytest
from rv_runs import COULOMB_RV80E

from cycloid_mj.base.engine import Engine
from cycloid_mj.base.errors import UsageError
from cycloid_mj.design import override
from cycloid_mj.explore.sweeps import sweep
from cycloid_mj.figures import figure
from cycloid_mj.parts.export.rv_assembly import rv_mass
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.sheet import shaft_powers, sheet

HERE = Engine(1)
RV80E = COULOMB_RV80E
CLEARANCE = "cranks.needle_clearance_um"


def test_backlash_and_mass_vary_with_the_clearance_of_the_needles() -> None:
    table = sweep("rv80e", {CLEARANCE: [0.0, 2.0]}, "backlash_arcmin,mass", engine=HERE).frame
    # 9.5 arcsec of lost motion per micrometre of radial clearance
    backlash = table["backlash_arcmin"]
    assert 60.0 * (backlash[1] - backlash[0]) == pytest.approx(2.0 * 9.5, rel=0.01)
    for row, clearance in enumerate((0.0, 2.0)):
        reducer = RvReducer(override(RV80E, {CLEARANCE: clearance}))
        assert table["mass.mass_kg"][row] == pytest.approx(rv_mass(reducer))


@pytest.mark.slow
def test_statics_of_a_point_are_those_of_a_single_design() -> None:
    table = sweep(RV80E, {CLEARANCE: [2.0]}, "statics", engine=HERE).frame
    quantities = sheet(RvReducer(override(RV80E, {CLEARANCE: 2.0}))).quantities
    assert table["backlash_arcmin"][0] == quantities["backlash"].value
    for key in ("stiffness_nm_per_arcmin", "te_loaded_forward_arcsec", "efficiency_percent", "pin_gear_peak_force_n"):
        (quantity,) = (item for item in quantities.values() if figure(item.key).key == key)
        assert table[key][0] == quantity.value


def test_figures_of_rating_and_size_vary_with_the_width_of_the_discs() -> None:
    measure = "torque_for_6000_h_nm,momentary_torque_nm,input_inertia_kg_cm2,length_mm"
    table = sweep(RV80E, {"gear.face_width_mm": [14.0, 15.0]}, measure, engine=HERE).frame
    assert table["torque_for_6000_h_nm"][1] == pytest.approx(801.8, rel=1e-3)
    # a pressure with the root of the force per width: the limit by pitting is in proportion to the width
    assert table["torque_for_6000_h_nm"][0] == pytest.approx(801.8 * 14.0 / 15.0, rel=0.02)
    assert table["momentary_torque_nm"][1] == pytest.approx(4697.0, rel=1e-3)
    assert table["length_mm"].tolist() == pytest.approx([81.0, 83.0])
    assert table["input_inertia_kg_cm2"][0] < table["input_inertia_kg_cm2"][1]


def test_figures_of_a_central_crank_are_refused() -> None:
    with pytest.raises(UsageError, match="drive_mass_kg does not apply to layout"):
        sweep("rv80e", {CLEARANCE: [0.0]}, "drive_mass_kg", engine=HERE)


def test_a_simulated_point_has_the_efficiency_of_statics() -> None:
    design = RV80E.but(drive={"ramp": 0.0, "hold": 0.03})
    table = sweep(design, {CLEARANCE: [0.0]}, "simulate", engine=HERE, solver="planar").frame
    assert table["efficiency"][0] == pytest.approx(shaft_powers(RvReducer(RV80E), 784.0).efficiency, abs=2e-3)


def test_each_figure_of_both_layouts_has_a_value() -> None:
    reducer = RvReducer(RV80E)
    for key, value in (("mass_kg", 10.6), ("length_mm", 83.0), ("bearing_life_h", 19340.0), ("life_h", 7294.0)):
        assert figure(key).value(reducer) == pytest.approx(value, rel=1e-3)
