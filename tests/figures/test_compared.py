"""A comparison has the catalogue's figures of every design beside those of its runs."""

import pytest

from cycloid_mj.cli.verdict import HEADLINE, catalogue_figures, catalogue_table
from cycloid_mj.design import PRESETS
from cycloid_mj.figures import figure
from cycloid_mj.reducer import Reducer


def test_designs_are_compared_side_by_side_by_catalogue_key() -> None:
    designs = [PRESETS["pin"], PRESETS["nonpin"]]
    found = catalogue_figures(designs)
    table = catalogue_table(found)
    assert table.header == ("figure", "pin", "nonpin", "ratio", "unit")
    assert tuple(row[0] for row in table.rows) == tuple(key for key in HEADLINE if key != "crank_bearing_force_n")
    for column, design in enumerate(designs, 1):
        values = {row[0]: row[column] for row in table.rows}
        for key in ("te_loaded_arcsec", "mass_kg"):
            assert values[key] == pytest.approx(figure(key).value(Reducer(design)))
    assert "pin_gear_pressure_mpa" in found["pin"]
    assert "pin_gear_pressure_mpa" not in found["nonpin"]
