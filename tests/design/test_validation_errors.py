"""Errors of pydantic in the words of the design file: every type of error, and names in any case."""

from typing import get_args

import pytest
from pydantic import BaseModel, Field, ValidationError
from pydantic_core import InitErrorDetails, PydanticKnownError, core_schema

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import PRESETS, Design, loads, override, resolve
from cycloid_mj.design.materials import MATERIALS
from cycloid_mj.design.validation_errors import BOUNDS, as_design_error, range_words

WORDS = {"value_error": ValueError("set halves = 2 as well"), "assertion_error": AssertionError("set halves = 2")}
"""Type of error -> what stands for its exception."""


def filling(kind: str) -> dict[str, object]:
    """Return words or numbers that the message of a type of error is filled with."""
    context: dict[str, object] = {}
    while True:
        try:
            PydanticKnownError(kind, context)
            return context
        except TypeError as problem:
            name = str(problem).split("'")[1]
            context[name] = 3 if name in context else WORDS.get(kind, "word")


TYPES = [kind for kind in get_args(core_schema.ErrorType) if kind != "missing"]


@pytest.mark.parametrize("kind", TYPES)
def test_every_type_of_error_is_reported_without_the_words_of_pydantic(kind: str) -> None:
    details = InitErrorDetails(type=kind, ctx=filling(kind), loc=("ring", "pin_radius"), input="a\nb")
    error = as_design_error(ValidationError.from_exception_data("Design", [details]), Design, "my.toml")
    text = str(error)
    assert text.startswith('my.toml: ring.pin_radius_mm = "a\\nb" is not allowed: '), text
    for words in ("Value error", "Assertion failed", "Input should", "Input must", "pydantic", "  "):
        assert words not in text
    assert text.isprintable()


@pytest.mark.parametrize(
    "change",
    [
        "ring.pins_=1",
        "ring.halves=0.5",
        "settings.log_rate_hz=-1",
        "material.poisson=0.5",
        "ring.socket=open",
        "gear=1",
    ],
)
def test_a_wrong_value_never_has_the_words_of_pydantic(change: str) -> None:
    with pytest.raises(DesignError) as caught:
        override(PRESETS["pin"], [change])
    assert "Input should" not in str(caught.value)
    assert "Value error" not in str(caught.value)


def test_a_range_is_written_in_the_units_of_the_file() -> None:
    assert range_words({"ge": 4.0, "le": 400.0}) == "from 4 to 400"
    assert range_words({"gt": 0.0, "le": 1000.0}) == "greater than 0 and at most 1000"
    assert range_words({"lt": 0.5}) == "less than 0.5"
    assert set(BOUNDS) == {"gt", "ge", "lt", "le"}


def test_a_value_without_a_declared_range_states_the_violated_bound() -> None:
    class Inner(BaseModel):
        x: list[int] = Field(default=[], description="places")

    class Outer(BaseModel):
        inner: Inner = Inner()

    details = InitErrorDetails(type="less_than", ctx={"lt": 3}, loc=("inner", "x", 1), input=5)
    refused = as_design_error(ValidationError.from_exception_data("Outer", [details]), Outer, "f")
    assert str(refused) == "f: inner.x[2] = 5 is not allowed: it must be less than 3 (places)"


@pytest.mark.parametrize("name", MATERIALS)
@pytest.mark.parametrize("change", [str.lower, str.upper, str.swapcase], ids=["lower", "upper", "swapped"])
def test_a_material_is_found_in_capital_and_small_letters(name: str, change) -> None:
    found = override(PRESETS["pin"], {"gear_material.name": change(name)}).gear_material
    assert found == override(PRESETS["pin"], {"gear_material.name": name}).gear_material
    assert found.name == name
    assert PRESETS["pin"].but(gear_material={"name": change(name)}).gear_material == found


def test_no_two_materials_differ_only_in_case() -> None:
    assert len({name.casefold() for name in MATERIALS}) == len(MATERIALS)


def test_an_unknown_material_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(DesignError, match=r'material\.name = "petgg" .*unknown material; did you mean "PETG"\? Avail'):
        override(PRESETS["pin"], ["material.name=petgg"])


def test_a_preset_and_a_kind_are_found_in_capital_and_small_letters(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert resolve("NonPin") == PRESETS["nonpin"]
    assert override(PRESETS["pin"], ["ring.kind=NONPIN"]).ring.kind == "nonpin"
    assert loads('[output]\nsupport = "Both_Ends"\n').output.support == "both_ends"
    (tmp_path / "NonPin").write_text('name = "mine"\n')
    assert resolve("NonPin").name == "mine", "a file of that very name comes first"


@pytest.mark.parametrize("word", ["hypocycloid", "Hypocycloid", "hypo"])
def test_a_hypocycloid_drive_is_refused_as_not_supported(word: str) -> None:
    with pytest.raises(
        DesignError, match=r"ring\.kind = .* hypocycloid drives, with the pins on the disc, are not supp"
    ):
        override(PRESETS["pin"], [f"ring.kind={word}"])


def test_text_that_needs_escapes_in_toml_is_read_back_as_it_was() -> None:
    design = loads('[tolerance]\nmesh = "a\\"\\n\\u0000\\\\b"\n')
    from cycloid_mj.design import dump

    assert design.tolerance.mesh == 'a"\n\x00\\b'
    assert loads(dump(design)) == design
