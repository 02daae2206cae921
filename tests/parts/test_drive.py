"""A whole drive: mass, inertia and length with covers, bearings and screws."""

import math

import numpy as np
import pytest

from cycloid_mj.base import names
from cycloid_mj.base.names import HOUSING
from cycloid_mj.design import PRESETS
from cycloid_mj.figures import figure
from cycloid_mj.life.figures import input_inertia
from cycloid_mj.parts import crank_segments, mass_properties, shaft_segments
from cycloid_mj.parts.export import casing, drive
from cycloid_mj.parts.export.assembly import assembly_parts, assembly_sections
from cycloid_mj.parts.export.printing import separate_parts
from cycloid_mj.reducer import Reducer

PIN = Reducer(PRESETS["pin"])


def test_the_length_is_from_face_to_face() -> None:
    sizes = casing(PIN)
    low, high = sizes.ends
    sections = [one for part in ("motor_cover", "output_flange") for one in assembly_sections(PIN, sizes)[part]]
    assert (low, high) == (min(one.z0 for one in sections), max(one.z1 for one in sections))
    assert figure("drive_length_mm").value(PIN) == pytest.approx(1e3 * (high - low))


@pytest.mark.parametrize("name", ["pin", "nonpin", "twodisc"])
def test_the_mass_of_a_part_is_that_of_its_solid(name: str) -> None:
    reducer = Reducer(PRESETS[name])
    for part in assembly_parts(reducer, casing(reducer)).values():
        assert part.mass(1e-5) == pytest.approx(mass_properties(part.solid(1e-5)).mass, rel=1e-6)


def test_hub_and_flange_count_at_the_input_over_the_ratio_squared() -> None:
    added = figure("drive_inertia_kg_cm2").value(PIN) - input_inertia(PIN)
    radius = 0.5 * casing(PIN).hub.bore
    disc = 0.5 * math.pi * radius**4 * (casing(PIN).ends[1] - casing(PIN).hub_floor) * PIN.design.material.density
    assert 0.5 < added / (1e4 * disc / PIN.design.reduction**2) < 3.0


def test_a_drive_without_room_for_its_covers_has_no_such_figures() -> None:
    crowded = PIN.but(shaft={"counterweight_radius": 0.048})
    assert not drive.has_casing(crowded)
    assert not figure("drive_mass_kg").exists(crowded)
    assert np.isnan(figure("drive_length_mm").value(crowded))


@pytest.mark.parametrize("kind", ["pin", "nonpin"])
def test_a_ring_in_two_halves_is_cased_as_one(kind: str) -> None:
    """Both halves are the housing: neither is taken for what is pressed into it."""
    whole, split = (PIN.but(ring={"kind": kind, "pins": "sleeved", "halves": halves}) for halves in (1, 2))
    assert drive.drive_mass(split) == pytest.approx(drive.drive_mass(whole), rel=1e-3)
    assert len(separate_parts(split)[HOUSING].segments) == 2
    assert (names.PRESSED_PIN in separate_parts(split)) == (kind == "pin")


@pytest.mark.parametrize(
    ("name", "mass", "length"), [("pin", 2.0, 87.5), ("twodisc", 5.7, 107.0), ("printed", 1.0, 85.0)]
)
def test_pockets_and_a_short_crank_keep_drives_light_and_short(name: str, mass: float, length: float) -> None:
    """With solid covers and hubs, and the whole journal, they had 2.57, 7.48 and 1.41 kg, and 87.5, 134 and 113 mm."""
    reducer = Reducer(PRESETS[name])
    assert drive.drive_mass(reducer) < mass
    assert 1e3 * drive.drive_length(reducer) == pytest.approx(length, abs=0.5)


@pytest.mark.parametrize("name", ["twodisc", "printed"])
def test_a_straddled_crank_ends_at_its_bearing_and_receives_the_motor_shaft(name: str) -> None:
    reducer = Reducer(PRESETS[name])
    sizes = casing(reducer)
    shaft = assembly_parts(reducer, sizes)["shaft"].segments
    assert min(segment.z0 for segment in shaft) == pytest.approx(sizes.near[0])
    radius, start, end = sizes.motor_bore
    assert start == pytest.approx(sizes.near[0])
    assert min(end, sizes.face + sizes.motor.shaft_length) - start >= 1.5 * 2.0 * radius
    coupled = casing(reducer, "circle")
    assert coupled.journal == pytest.approx(crank_segments(reducer)["journal"].z0), "its end stays for a coupling"


def test_the_segments_of_a_crank_are_built_once_for_all_loads() -> None:
    """The balance of the counterweight took a seventh of the time of rating a drive in a search."""
    reducer = Reducer(PRESETS["pin"])
    segments = shaft_segments(reducer)
    assert segments is shaft_segments(reducer.with_nominal_torque(1.0)) is crank_segments(reducer)
    coarse = shaft_segments(reducer, 1e-4)
    assert coarse["counterweight"].z0 != segments["counterweight"].z0
