"""Changes of a requirement: their series, and the search for the smallest one that suffices."""

from itertools import pairwise
from types import SimpleNamespace

import pytest

from cycloid_mj.sizing import remedies
from cycloid_mj.sizing.remedies import STEP, first_feasible, list_changes
from cycloid_mj.sizing.requirement import Requirement

ASKED = Requirement(20, 0.06, 3.0)


@pytest.mark.parametrize("key", ["life", "duty_share", "speed", "diameter"])
def test_changes_of_a_value_are_a_series_in_small_steps(key: str) -> None:
    values = [getattr(ASKED, key), *(getattr(item.requirement, key) for item in list_changes(ASKED, key))]
    ratios = [max(second / first, first / second) for first, second in pairwise(values)]
    assert len(ratios) > 40
    assert all(1.0 < ratio < 1.05 for ratio in ratios), f"steps of {STEP}, rounded to three digits"
    assert values == sorted(values, reverse=values[1] < values[0])


def test_a_fit_limits_the_diameters_to_those_of_its_standard() -> None:
    sizes = [item.requirement.diameter for item in list_changes(ASKED.but(fit="H7/g6"), "diameter")]
    assert 0.75 < max(sizes) < 0.85
    assert max(item.requirement.diameter for item in list_changes(ASKED, "diameter")) > 2.8


def test_a_value_without_a_limit_has_no_changes() -> None:
    assert list_changes(ASKED, "backlash") == []
    assert list_changes(ASKED.but(backlash=5.0), "backlash")[0].words == "a backlash of 5.2 arcmin"


def test_the_first_feasible_change_is_searched_in_steps_that_double() -> None:
    changes, tried = list_changes(ASKED, "diameter"), []

    def is_met(requirement: Requirement) -> bool:
        tried.append(requirement)
        return len(tried) == 3

    assert list(first_feasible(changes, is_met)) == [changes[3]]
    assert tried == [changes[index].requirement for index in (0, 1, 3)]
    assert list(first_feasible(changes, lambda requirement: False)) == []


@pytest.mark.parametrize("error", [0.7, 1.0, 1.4])
def test_the_smallest_sufficient_change_is_found_by_few_ratings(error: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ratings correct predictions that are too large or too small; steps that doubled took up to six ratings."""
    changes, rated = list_changes(ASKED, "diameter"), []
    search = object.__new__(remedies.RemedySearch)
    search.scale = 1.0

    def carried(requirement: Requirement) -> float:
        return 0.1 * ASKED.torque * (requirement.diameter / ASKED.diameter) ** 2.7

    def rate(requirement: Requirement) -> float:
        rated.append(requirement)
        return carried(requirement)

    monkeypatch.setattr(search, "_predict", lambda requirement: error * carried(requirement), raising=False)
    monkeypatch.setattr(search, "_rate", rate, raising=False)
    monkeypatch.setattr(remedies, "is_feasible", lambda requirement: carried(requirement) >= requirement.torque)
    (found,) = search.smallest(changes)
    assert found == next(item for item in changes if carried(item.requirement) >= ASKED.torque)
    assert len(rated) <= 4
    assert not list(search.smallest(changes[:5]))
    nothing = SimpleNamespace(scale=0.0, _predict=lambda requirement: 0.0, _rate=rate)
    assert not list(remedies.RemedySearch.smallest(nothing, changes))


def test_predictions_that_decrease_do_not_end_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """From 213 mm on, no parts of 5:1 are in stock; ratings at 164 mm were below the predictions, and none was left."""
    changes = list_changes(ASKED, "diameter")
    search = object.__new__(remedies.RemedySearch)
    search.scale = 1.0

    def carried(requirement: Requirement) -> float:
        index = [item.requirement for item in changes].index(requirement)
        return ASKED.torque * 1.03 ** (index - 33) if index < 38 else 0.0

    monkeypatch.setattr(search, "_predict", lambda requirement: 1.2 * carried(requirement), raising=False)
    monkeypatch.setattr(search, "_rate", lambda requirement: 0.95 * carried(requirement), raising=False)
    monkeypatch.setattr(remedies, "is_feasible", lambda requirement: carried(requirement) >= requirement.torque)
    (found,) = search.smallest(changes)
    assert found in changes[33:37]
