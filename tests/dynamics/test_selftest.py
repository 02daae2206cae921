"""A release of MuJoCo that has not been seen before is tried at first use, and refused where anything is read wrong."""

import os

import mujoco
import pytest
import spoiled_places

from cycloid_mj.base.errors import ContactError
from cycloid_mj.dynamics.contact import collider, each_step, layout, reference_correction, selftest
from cycloid_mj.dynamics.contact.library import CYLINDER, KNOWN, TYPES, collision_table


def collide(**spoiled):
    """Try a collider that was compiled for a layout of which some places are spoiled."""
    found = layout.find_layout()
    places = found._replace(**spoiled)
    collider._general_collider()  # it binds the collider of MuJoCo's own
    return selftest.try_collider(collider._compile_general_collider(places).address)


def test_the_release_that_is_installed_passes():
    assert collide() == ""
    with each_step._installation.apply():
        assert selftest.try_steps(each_step.add_sensor, each_step.EachStep) == ""
    lift = reference_correction.compile_control_callback(layout.find_step_layout())
    assert selftest.try_correction(lift.address) == ""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("place", "instead"),
    [
        ("geom_size", "geom_user"),
        ("geom_xpos", "geom_xmat"),
        ("geom_user", "geom_size"),
        ("geom_priority", "geom_size"),
    ],
)
def test_an_exchanged_position_is_detected_in_the_gaps(place, instead):
    assert collide(**{place: getattr(layout.find_layout(), instead)})


def test_a_collider_that_is_not_called_is_detected():
    own = collision_table()[CYLINDER * TYPES + CYLINDER]
    assert selftest.try_collider(own).startswith("gaps of ")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="each place is tried in a process that may crash")
@pytest.mark.slow
@pytest.mark.parametrize(("part", "places"), [("steps", 4), ("lift", 10)])
def test_places_that_are_read_wrong_are_seen(part, places):
    told = spoiled_places.outcomes(part)
    assert len(told) == places
    assert not [place for place, outcome in told.items() if not outcome]
    seen = [outcome for outcome in told.values() if outcome != spoiled_places.CRASHED]
    assert len(seen) > places / 2
    assert all(outcome.startswith("forces of ") or "contacts carry" in outcome for outcome in seen)


def test_an_uncorrected_cone_lift_is_detected():
    assert selftest.try_correction(0).startswith("forces of ")


def test_a_passed_validation_is_stored_and_a_failed_one_is_one_line(monkeypatch, tmp_path):
    monkeypatch.setattr(selftest, "cache_folder", lambda: tmp_path)
    tried = []
    for _ in range(2):
        selftest.require_passed("part", lambda: tried.append(1) or "")
    assert len(tried) == 1
    (record,) = tmp_path.iterdir()
    assert record.name.startswith(f"mujoco-{mujoco.__version__}-part-")
    monkeypatch.setattr(mujoco, "__version__", "5.1.0")
    for _ in range(2):
        with pytest.raises(ContactError, match=r"MuJoCo 5\.1\.0 is not compatible .*part: it is wrong") as error:
            selftest.require_passed("part", lambda: tried.append(1) or "it is wrong")
        assert ", ".join(KNOWN) in str(error.value)
        assert "\n" not in str(error.value)
    assert len(tried) == 3


def test_nowhere_to_keep_it_is_no_error(monkeypatch, tmp_path):
    monkeypatch.setattr(selftest, "cache_folder", lambda: None)
    selftest.require_passed("part", lambda: "")
    monkeypatch.setattr(selftest, "cache_folder", lambda: tmp_path / "gone")
    selftest.require_passed("part", lambda: "")
