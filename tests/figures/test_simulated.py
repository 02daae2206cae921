"""Figures of runs are the quantities of measures, under the catalogue's keys and units."""

import pytest

from cycloid_mj.base.result import Quantity
from cycloid_mj.design import PRESETS
from cycloid_mj.figures import figure, of_measure
from cycloid_mj.figures.simulated import OF_RUNS
from cycloid_mj.measure import MEASURES, Measurement
from cycloid_mj.reducer import Reducer

PIN = PRESETS["pin"]
BACKLASH = {"backlash": Quantity("backlash", "backlash", 0.97, "arcmin"), "backlash_cam": Quantity("", "", 0.1, "")}


def test_a_measure_is_taken_once_for_all_its_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    taken = []

    def loads(design: object) -> Measurement:
        taken.append(design)
        keys = ("capacity", "cam_peak_force", "output_peak_force")
        return Measurement("loads", PIN, {key: Quantity(key, key, float(len(key)), "N") for key in keys})

    monkeypatch.setitem(MEASURES, "loads", loads)
    reducer = Reducer(PIN.but(name="once"))
    values = [row.value(reducer) for row in OF_RUNS if row.aliases[0].startswith("loads/")]
    assert values == [8.0, 14.0, 17.0]
    assert taken == [reducer.design]


def test_the_json_of_a_measure_has_the_catalogue_s_keys_beside_its_own() -> None:
    found = Measurement("backlash", PIN, BACKLASH).as_json()
    assert found["figures"]["simulated_backlash_arcmin"]["value"] == found["quantities"]["backlash"]["value"] == 0.97
    assert set(of_measure("backlash", BACKLASH)) == {"simulated_backlash_arcmin"}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["backlash", "te", "torque", "loads"])
def test_rows_have_the_units_of_the_measures(name: str) -> None:
    found = MEASURES[name](PIN, quick=True)
    rows = {row.aliases[0]: row for row in OF_RUNS if row.aliases[0].startswith(f"{name}/")}
    assert rows
    for alias, row in rows.items():
        assert found.quantities[alias.partition("/")[2]].unit == row.unit
        assert figure(alias) is row
