"""How rarely Python looks for circles of objects."""

import gc

import pytest

from cycloid_mj.base.memory import collect_rarely


@pytest.fixture
def as_before():
    threshold, callbacks = gc.get_threshold(), list(gc.callbacks)
    yield
    gc.set_threshold(*threshold)
    gc.callbacks[:] = callbacks


@pytest.mark.usefixtures("as_before")
def test_the_first_collection_of_cycles_waits_for_more_objects():
    collect_rarely()
    first, *older = gc.get_threshold()
    gc.collect(0)
    assert gc.get_threshold() == (first // 4, *older)
    collect_rarely()
    collect_rarely()
    gc.collect(0)
    gc.collect(0)
    assert gc.get_threshold() == (first // 4, *older)
