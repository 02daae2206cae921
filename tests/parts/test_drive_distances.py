"""Distances of the parts of a drive by OpenCASCADE: the method, and no contact in the presets at 12 crank angles."""

import math

import pytest
from designs import CENTRAL, design_file

from cycloid_mj.checks import check
from cycloid_mj.design import PRESETS, load
from cycloid_mj.design.processes import PROCESSES
from cycloid_mj.parts import PartSection
from cycloid_mj.parts.curve import Circle
from cycloid_mj.parts.export import PlacedPart, casing
from cycloid_mj.reducer import Reducer

pytest.importorskip("OCP")

import check_drives
from drive_distances import Face, face_of, planar_distance, smallest_distances


def ring(outer: float, inner: float) -> Face:
    return face_of(PartSection("ring", ((Circle((0.0, 0.0), outer),), (Circle((0.0, 0.0), inner),)), 0.0, 1.0))


def moved(face: Face, x: float, y: float) -> Face:
    return face.moved(PlacedPart("", "", (x, y, 0.0), 0.3))


def test_distances_of_rings_match_closed_forms():
    outer, inner = ring(20e-3, 10e-3), ring(6e-3, 2e-3)
    assert planar_distance(outer, moved(inner, 1e-3, 2e-3)) == pytest.approx(4e-3 - math.hypot(1e-3, 2e-3), abs=1e-9)
    assert planar_distance(outer, moved(inner, 30e-3, 0.0)) == pytest.approx(4e-3, abs=1e-9)
    assert planar_distance(outer, moved(inner, 15e-3, 0.0)) == 0.0
    assert planar_distance(outer, moved(inner, 30e-3, 0.0), 3e-3) == math.inf


@pytest.mark.slow
@pytest.mark.parametrize("name", CENTRAL)
def test_moving_parts_of_the_presets_never_touch(name):
    reducer = Reducer(PRESETS[name])
    sizes = casing(reducer)
    distances = smallest_distances(reducer, sizes, check_drives.CRANK_ANGLES)
    assert [one for one in distances if not one.keeps(sizes.play)] == []
    clearance = 1e6 * reducer.design.clearance.output
    assert any("output" in one.part and "gear" in one.other and 1e6 * one.value <= clearance + 0.1 for one in distances)


def test_a_design_without_covers_is_a_fault_with_its_reason(tmp_path):
    file = tmp_path / "short.toml"
    bearings = 'main_bearing_seat = "disc"\nmain_bearings = "tapered"'
    file.write_text(f'name = "short"\n[base]\npreset = "pin"\n[output]\n{bearings}\n')
    (fault,) = check_drives.faults(str(file))
    assert fault.startswith("no covers: no standard bearing, with the space that it needs, fits around the output disc")
    assert check_drives.reported_violations(str(file)) == ()


def test_new_drives_cover_all_processes():
    flags = [words.split() for words in check_drives.NEW_DRIVES.values()]
    assert len(flags) >= 10
    chosen = {words[words.index("--process") + 1] if "--process" in words else "steel" for words in flags}
    assert chosen == set(PROCESSES)


def test_an_rv_reducer_has_no_rules_of_covers():
    assert check_drives.reported_violations("rv80e") == ()


def test_violated_rules_are_those_of_design_check():
    (violation,) = check_drives.reported_violations(str(design_file("sleeved-n40-d2-ring-25um")))
    (joints,) = [one for one in check(load(design_file("sleeved-n40-d2-ring-25um"))) if one.name == "joints"]
    assert joints.got == violation
