import pytest
from designs import UNLIKE, unlike

from cycloid_mj.checks import check, require_sound
from cycloid_mj.reducer import Reducer


@pytest.mark.parametrize("name", UNLIKE)
def test_the_designs_that_others_are_tried_on_can_be_built(name):
    require_sound(Reducer(unlike(name)))


@pytest.mark.parametrize("name", [name for name in UNLIKE if name != "teeth21"])
def test_the_designs_made_to_be_good_pass_every_check(name):
    assert [str(item) for item in check(unlike(name)) if not item.passed] == []


def test_the_designs_that_others_are_tried_on_cover_every_kind_of_ring():
    rings = [unlike(name).ring for name in UNLIKE]
    assert {ring.pins if ring.kind == "pin" else ring.kind for ring in rings} == {"free", "fixed", "sleeved", "nonpin"}
