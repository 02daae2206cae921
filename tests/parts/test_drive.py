"""A whole drive: mass, inertia and length with covers, bearings and screws."""

import math

import numpy as np
import pytest

from cycloid_mj.base.names import HOUSING
from cycloid_mj.design import PRESETS
from cycloid_mj.figures import figure
from cycloid_mj.life.figures import input_inertia
from cycloid_mj.parts import PartSection
from cycloid_mj.parts.cam_bearing import cam_bearing
from cycloid_mj.parts.curve import Circle
from cycloid_mj.parts.export import casing, drive, places
from cycloid_mj.parts.export.assembly import assembly_sections
from cycloid_mj.parts.export.printing import PRESSED_PIN, separate_parts
from cycloid_mj.reducer import Reducer

PIN = Reducer(PRESETS["pin"])


def volume_of_rounds(sections: tuple[PartSection, ...]) -> float:
    """Compute the volume of a part of circles alone [m3]."""
    total = 0.0
    for one in sections:
        outer, *holes = (loop[0] for loop in one.loops)
        assert all(isinstance(circle, Circle) for circle in (outer, *holes))
        area = math.pi * (outer.radius**2 - sum(hole.radius**2 for hole in holes))
        total += area * (one.z1 - one.z0)
    return total


def test_the_mass_is_that_of_all_parts_in_their_places() -> None:
    """Covers, flange, screws and bearings by their circles; ring, output and shaft by what is added or drilled."""
    sizes = casing(PIN)
    cased, bare = assembly_sections(PIN, sizes), assembly_sections(PIN)
    mass = 0.0
    for place in places(PIN, 0.0, sizes):
        part = place.part
        volume = volume_of_rounds(cased[part]) if part in cased and part not in bare else 0.0
        if part == "output":
            volume = volume_of_rounds(cased[part]) - volume_of_rounds(bare[part])
        if part == "housing":
            holes = len(sizes.screws.angles) * sizes.screws.hole**2 * PIN.design.gear.stack_width
            dowels = len(sizes.dowel_angles) * (0.5 * sizes.dowel.diameter) ** 2 * sizes.dowel.length
            volume = -math.pi * (holes + dowels)
        if part == "shaft":
            # the journal, drilled from its end on
            volume = volume_of_rounds(cased[part][:2]) - volume_of_rounds(bare[part][:1])
        bearing = part in ("shaft_bearing", "output_bearing")
        bought = bearing or part in ("screw", "flange_screw", "dowel")
        density = drive.STEEL if bought else PIN.design.material.density
        mass += (drive.BEARING_FILL if bearing else 1.0) * density * volume
    assert cam_bearing(PIN) is None
    assert drive.casing_mass(PIN) == pytest.approx(mass, rel=1e-4)
    assert figure("drive_mass_kg").value(PIN) == figure("mass_kg").value(PIN) + drive.casing_mass(PIN)


def test_the_length_is_from_face_to_face() -> None:
    sizes = casing(PIN)
    low, high = sizes.ends
    sections = [one for part in ("motor_cover", "output_flange") for one in assembly_sections(PIN, sizes)[part]]
    assert (low, high) == (min(one.z0 for one in sections), max(one.z1 for one in sections))
    assert figure("drive_length_mm").value(PIN) == pytest.approx(1e3 * (high - low))


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
    assert drive.casing_mass(split) == pytest.approx(drive.casing_mass(whole), rel=1e-3)
    assert len(separate_parts(split)[HOUSING].stretches) == 2
    assert (PRESSED_PIN in separate_parts(split)) == (kind == "pin")
