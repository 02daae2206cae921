"""The counts of the code, and the list of figures that differ between two revisions."""

import ast
import re
from pathlib import Path

import counts
import moved
import pytest

SOURCE = """
from functools import cache, lru_cache

@cache
def kept(design: Design) -> float: ...

@lru_cache(maxsize=4)
def kept_too(designs: Sequence[Design]) -> float: ...

@cache
def other(length: float) -> float: ...

class Gear:
    def cut(self, of: "Design", design: Design | None = None) -> None:
        if design.output.turns_ring:
            seen_from_ring(design)
        if mechanism.turning in bodies and mechanism.turning == HOUSING:
            ...
"""


@pytest.fixture
def module() -> counts.Module:
    return counts.Module("a.py", ast.parse(SOURCE))


def test_functions_that_take_a_design_are_counted_wherever_it_stands_in_a_type(module: counts.Module) -> None:
    assert [each.split()[1] for each in counts.taking_design([module])] == ["kept", "kept_too", "cut"]


def test_only_caches_with_a_design_among_their_keys_count(module: counts.Module) -> None:
    assert [each.split()[1] for each in counts.cached_by_design([module])] == ["kept", "kept_too"]


def test_each_line_that_converts_for_a_turning_ring_counts_once(module: counts.Module) -> None:
    assert sorted(counts.ring_conversions([module])) == ["a.py:15", "a.py:16", "a.py:17"]
    assert counts.ring_conversions([counts.Module(counts.RING_MODULE, module.tree)]) == ()


def test_a_class_name_of_two_modules_is_a_homonym(module: counts.Module) -> None:
    assert counts.list_homonyms([module]) == ()
    assert counts.list_homonyms([module, counts.Module("b.py", module.tree)]) == ("Gear: a.py:13, b.py:13",)


def test_no_count_is_above_what_contributing_says() -> None:
    """The counts that the sources alone decide; those of a data sheet take ten seconds."""
    page = (Path(__file__).parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8")
    stated = dict(re.findall(r"^\| (.+?) \| (\d+) \| under", page, re.MULTILINE))
    counted = {one.name: one.value for one in counts.count_sources()}
    assert counted.keys() < stated.keys()
    assert {name: value for name, value in counted.items() if value > int(stated[name])} == {}


def test_a_figure_moves_when_its_printed_digits_do() -> None:
    old, new = {"same": 1.0, "moved": 2.0, "gone": 3.0, "from_zero": 0.0}, {"same": 1.000001, "moved": 2.1, "new": 4.0}
    listed = {one.key: one.change for one in moved.moves("pin", "statics", old, {**new, "from_zero": 1.0})}
    assert listed == {"moved": "+5 %", "gone": "gone", "from_zero": "from 0", "new": "new"}


def test_what_only_one_revision_prints_is_counted_and_not_listed() -> None:
    of = [moved.Move("pin", "rate", "life", 1.0, None), moved.Move("pin", "rate", "heat", 1.0, 1.5)]
    assert moved.table(of).cells == [["pin", "rate", "heat", "1", "1.5", "+50 %"]]
    assert moved.come_and_gone(of) == "Printed by one revision alone: 0 new, 1 gone."
