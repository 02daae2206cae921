"""The catalogue: keys with units, one number by each, as sheet and samples have it; errors propose near names."""

import json
from importlib import import_module

import pytest
from designs import UNLIKE, cases, unlike

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.units import with_unit
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS
from cycloid_mj.figures import FIGURES, Need, figure, figures_of
from cycloid_mj.figures.sampled import OF_SAMPLES, STATES, solve_states
from cycloid_mj.figures.statics import OF_STATICS
from cycloid_mj.reducer import Reducer, reducer_of
from cycloid_mj.statics.samples import identical_samples
from cycloid_mj.statics.sheet import sheet

PIN = Reducer(PRESETS["pin"])


def test_a_key_ends_in_its_unit_and_denotes_one_figure() -> None:
    names = [name for row in FIGURES.values() for name in (row.key, *row.aliases)]
    assert len(set(names)) == len(names) > 200
    for row in FIGURES.values():
        assert row.key == with_unit(row.key, row.unit.replace("/", " per "))
        assert row.definition.endswith(".")
        assert row.definition.count(". ") == 0, row.key


@pytest.mark.parametrize("name", cases([*PRESETS, *UNLIKE[:1], *UNLIKE[2:]], "pin", "twodisc"))
def test_the_rows_of_statics_are_the_numbers_of_the_sheet(name: str) -> None:
    reducer = reducer_of(unlike(name) if name not in PRESETS else PRESETS[name])
    there = sheet(reducer).quantities
    rows = {row.aliases[0] if row.aliases else row.key: row for row in OF_STATICS if row.applies_to(reducer)}
    assert set(rows) == set(there)
    for key, row in rows.items():
        assert (row.value(reducer), row.unit) == (pytest.approx(there[key].value, nan_ok=True), there[key].unit)
        assert there[key].name.startswith(row.name.split(",")[0]), key


def test_samples_without_errors_have_the_figures_of_the_design() -> None:
    states = solve_states(PIN, identical_samples(PIN, 3), STATES)
    for row in OF_SAMPLES:
        assert row.sampled
        value = row.sampled.value(*(states[state] for state in row.sampled.states))
        assert value.tolist() == [row.value(PIN)] * 3, row.key


def test_backlash_of_samples_is_that_of_the_sheet() -> None:
    row = figure("backlash_arcmin")
    assert row.sampled
    states = solve_states(PIN, identical_samples(PIN, 1), row.sampled.states)
    assert row.sampled.value(*states.values())[0] == pytest.approx(row.value(PIN), rel=2e-3)


def test_figures_of_upper_packages_name_existing_functions() -> None:
    named = [row.function for row in FIGURES.values() if isinstance(row.function, str)]
    assert named
    for words in named:
        module, _, name = words.partition(":")
        assert callable(getattr(import_module(module), name)), words


@pytest.mark.parametrize("need", [Need.GEOMETRY, Need.LIFE])
def test_figures_are_numbers(need: Need) -> None:
    for row in figures_of(PIN, {need}):
        assert row.value(PIN) > 0.0, row.key


def test_an_old_key_is_the_same_figure() -> None:
    assert figure("output_peak_to_peak_loaded_forward_speed") is figure("te_loaded_forward_arcsec")
    assert figure("stiffness_ideal_nm_arcmin") is figure("stiffness_nm_per_arcmin")


@pytest.mark.parametrize(
    ("key", "needs", "words"),
    [
        ("te_loaded", Need, "unknown quantity 'te_loaded'; did you mean .*te_loaded_arcsec"),
        ("tooth_force", Need, "did you mean tooth_force_n"),
        ("baklash_arcmin", Need, "did you mean backlash_arcmin"),
        ("xyz", Need, "unknown quantity 'xyz'; choose one listed by `cycloid-mj figures`"),
        ("life_h", [Need.STATICS], "the quantity life_h is computed from a life rating, but .* computed from statics;"),
        ("tooth_pressure", Need, "the quantity tooth_pressure does not apply to the design 'pin'"),
    ],
)
def test_a_figure_that_does_not_exist_is_reported_with_near_names(key: str, needs: list[Need], words: str) -> None:
    with pytest.raises(UsageError, match=words):
        figure(key, needs, PIN)


def test_the_command_lists_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["figures", "--need", "life", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["figures"]
    assert {one["need"] for one in listed.values()} == {"life"}
    assert listed["life_h"]["unit"] == "h"
    assert main(["figures"]) == 0
    shown = capsys.readouterr().out
    assert all(key in shown for key in FIGURES)
