"""The table of measures in docs/results.md is what the script writes from what was measured."""

import importlib.util
import json
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("docs_measured", ROOT / "scripts" / "docs_measured.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_says_what_was_measured(script: ModuleType) -> None:
    page = script.PAGE.read_text(encoding="utf-8")
    found = json.loads(script.KEPT.read_text(encoding="utf-8"))
    assert script.written(page, found) == page
    for design, quantities in found.items():
        for label, keys in script.ROWS:
            assert sum(key in quantities for key in keys) == 1, (design, label)


def test_a_number_stands_with_its_error_and_its_closed_form(script: ModuleType) -> None:
    one = {"value": 1.23456, "unit": "m", "numerical_error": 0.0123, "reference": 1.2}
    table = script.table({"pin": dict.fromkeys([key for _, keys in script.ROWS for key in keys], one)})
    assert "| 1.235 +- 0.01 (1.2) |" in table
    bare = {**one, "numerical_error": None, "reference": None}
    assert "| 1.235 |" in script.table({"pin": dict.fromkeys([key for _, keys in script.ROWS for key in keys], bare)})


def test_a_page_without_marks_is_refused(script: ModuleType) -> None:
    with pytest.raises(ValueError, match="lacks"):
        script.written("nothing", {})
