"""Former names of arguments work for one release, with a warning."""

import pytest

from cycloid_mj.base.deprecated import deprecated_argument


@deprecated_argument("old", "new")
def double(new: int) -> int:
    """Return twice the argument."""
    return 2 * new


def test_the_former_name_of_an_argument_warns_and_passes_its_value() -> None:
    with pytest.warns(DeprecationWarning, match="the argument old of double is deprecated: use new"):
        assert double(**{"old": 3}) == 6


def test_the_present_name_of_an_argument_gives_no_warning() -> None:
    assert double(new=3) == double(3) == 6


def test_both_names_together_are_refused() -> None:
    with pytest.raises(TypeError, match="double got both new and old"):
        double(**{"old": 3, "new": 3})
