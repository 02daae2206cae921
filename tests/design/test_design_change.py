"""Designs changed and told in Python."""

import math

import numpy as np
import pytest

from cycloid_mj.base.errors import DesignError, UsageError
from cycloid_mj.design import PRESETS, override
from cycloid_mj.design.model import NO_FRICTION

PIN = PRESETS["pin"]


def test_override_accepts_values_and_text():
    words = override(PIN, ["load.torque_nm=36", "ring.pins=fixed", "name=other", "output.rollers=false"])
    values = {"load.torque_nm": 36.0, "ring.pins": "fixed", "name": "other", "output.rollers": False}
    assert override(PIN, values) == words
    assert override(PIN, {}) is PIN


def test_override_accepts_lists_and_numpy_numbers():
    listed = override(PIN, {"errors.pin_dr_um": np.full(36, 0.5), "ring.teeth": np.int64(36), "load.torque_nm": 3})
    assert listed == override(PIN, [f"errors.pin_dr_um={[0.5] * 36}", "load.torque_nm=3"])
    assert override(PIN, {"errors.pin_dr_um": {"2": 1.5}}) == override(PIN, ["errors.pin_dr_um={2 = 1.5}"])


@pytest.mark.parametrize(
    ("changes", "error", "words"),
    [
        ({"load.torqe_nm": 3.0}, DesignError, "did you mean load.torque_nm"),
        ({"load.torque_nm": "much"}, DesignError, 'load.torque_nm = "much" is not allowed'),
        ({"load": 3.0}, DesignError, "load is a table"),
        ({"a.b.c": 3.0}, UsageError, "give table.key"),
        ({"": 3.0}, UsageError, "give table.key"),
        ({"name.x": 3.0}, UsageError, "a value and not a table"),
    ],
)
def test_a_wrong_value_is_reported_in_the_words_of_the_file(changes, error, words):
    with pytest.raises(error) as raised:
        override(PIN, changes)
    assert words in str(raised.value)
    assert "--set" not in str(raised.value)


def test_but_changes_only_the_given_si_values():
    changed = PIN.but(load={"torque": 36.0}, gear={"face_width": 0.012}, name="wide")
    assert changed == override(PIN, ["load.torque_nm=36", "gear.face_width_mm=12", "name=wide"])
    assert PIN.but() == PIN
    assert PIN.but(errors={"pin_dr": [1e-6] * 36}).errors.pin_dr == (1e-6,) * 36
    assert PIN.but(load=PIN.load.model_copy(update={"torque": 2.0})).load.torque == 2.0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"lod": {"torque": 3.0}}, "lod"),
        ({"load": {"torqe": 3.0}}, "torqe"),
        ({"gear": {"face_width": -0.01}}, "gear.face_width_mm = -10.0 is not allowed: it must be from 0.001 to 1000"),
        ({"load": 3.0}, "load"),
        ({"errors": {"pin_dr": [1e-6]}}, "pin_dr_um has 1 values"),
    ],
)
def test_but_refuses_what_the_file_refuses(changes, words):
    with pytest.raises(DesignError) as raised:
        PIN.but(**changes)
    assert words in str(raised.value)


def test_the_repr_of_a_design_is_one_line():
    assert repr(PIN) == (
        "Design(name 'pin', ratio 35:1, ring 36 teeth, free pins, E 40.75 mm, eccentricity 1 mm, speed 1640 rpm, "
        "nominal torque 36.68 N m, load 0 N m)"
    )
    assert str(PIN) == repr(PIN)
    html = PRESETS["nonpin"]._repr_html_()
    assert "<td>36 teeth, internal gear, E 40.75 mm</td>" in html


def test_a_steady_design_runs_whole_turns_at_full_speed_after_it_has_settled():
    design = PIN.steady(
        0.02, 3.0, samples=4.0, drive={"speed": -100.0}, load={"torque": 20.0}, settings={"log_rate": 1e4}
    )
    assert (design.drive.ramp, design.drive.speed, design.load.torque) == (0.0, -100.0, 20.0)
    assert design.drive.hold == pytest.approx(0.02 + 3.0 * 2.0 * math.pi / 100.0 + 4.0 / 1e4, rel=1e-14)
    assert PIN.steady(0.02, 1.0, drive={"ramp": 0.5}).drive.ramp == 0.5


@pytest.mark.parametrize("law", ["coulomb", "film"])
def test_a_drive_without_friction_has_none_in_any_pair(law: str) -> None:
    frictionless = PRESETS["twodisc"].but(friction={"law": law}).but(friction=NO_FRICTION)
    pairs = ("pin_gear", "pin_socket", "pin_sleeve", "tooth", "cam", "output")
    assert not frictionless.has_film
    assert [frictionless.friction_of(pair) for pair in pairs] == [0.0] * len(pairs)


def test_other_values_that_are_wrong_name_the_design() -> None:
    with pytest.raises(DesignError, match="design 'pin' with other values: "):
        PRESETS["pin"].but(gear={"face_width": -1.0})
