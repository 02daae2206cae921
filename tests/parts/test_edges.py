"""Chamfers of seats and fillets of shoulders: where they are, and what they do to the solids of STEP files."""

import math

import pytest

from cycloid_mj.design import PRESETS
from cycloid_mj.life.strength import SHOULDER_STRESSES, shoulder_factor
from cycloid_mj.parts import Segment
from cycloid_mj.parts.contour import CircleContour
from cycloid_mj.parts.crank import shaft_dimensions
from cycloid_mj.parts.export import casing, read_volume, step_part
from cycloid_mj.parts.export.assembly import assembly_parts
from cycloid_mj.parts.export.drawing import part_drawings
from cycloid_mj.parts.export.edges import EDGES, broken_edges
from cycloid_mj.parts.export.rules import describe_violations
from cycloid_mj.parts.export.step import BrokenEdge
from cycloid_mj.reducer import Reducer

PIN = Reducer(PRESETS["pin"])


def edges_of(name: str) -> tuple[BrokenEdge, ...]:
    sizes = casing(PIN)
    return broken_edges(PIN, sizes, assembly_parts(PIN, sizes)[name])


def test_every_bearing_seat_is_open_through_a_chamfer():
    sizes, radius = casing(PIN), 0.5 * casing(PIN).hub.outside
    assert sizes.output_cavity == radius, "the seat is open down to the ring"
    mouths = edges_of("output_cover")
    assert [edge.radius for edge in mouths] == pytest.approx([radius, radius])
    assert [edge.z for edge in mouths] == pytest.approx([sizes.end, sizes.top])
    (mouth,) = edges_of("motor_cover")
    assert (mouth.radius, mouth.is_fillet) == (pytest.approx(sizes.seat), False)
    hub = [edge for edge in edges_of("output") if math.hypot(*edge.centre) == 0.0]
    assert [(edge.radius, edge.z) for edge in hub] == [pytest.approx((0.5 * sizes.hub.bore, sizes.top))]


def test_shoulders_of_the_crank_have_the_fillet_that_its_fatigue_assumes():
    shaft = PIN.design.shaft
    fillets = [edge for edge in edges_of("shaft") if edge.is_fillet]
    assert {edge.size for edge in fillets} == {shaft.shoulder_fillet}
    assert {edge.radius for edge in fillets} == {shaft.radius}
    assert len(fillets) == 2, "one at the collar, one at the cam"
    collar = next(one for one in assembly_parts(PIN, casing(PIN))["shaft"].segments if one.name == "collar")
    assumed = shaft_dimensions(PIN).counterweight_radius
    for terms, _ in SHOULDER_STRESSES:
        drawn, rated = (
            shoulder_factor(shaft.radius, shaft.shoulder_fillet, outer, terms)
            for outer in (collar.outline.radius, assumed)
        )
        assert drawn < rated, "the counterweight, which the rating assumes, is the larger step"


def test_fillets_that_keep_a_bearing_off_its_shoulder_are_reported():
    assert list(describe_violations(PIN, casing(PIN))) == []
    rounder = Reducer(PRESETS["pin"].but(shaft={"fillet_radius": 0.8e-3}))
    (text,) = describe_violations(rounder, casing(rounder))
    assert "0.8 mm" in text
    assert "shaft.fillet_radius_mm" in text


def test_a_step_without_room_for_a_chamfer_stays_sharp():
    """A seat of 12 mm whose wall is 0.2 mm thick has none; one of 1 mm has one at each end."""
    part = assembly_parts(PIN, casing(PIN))["motor_cover"]
    for wall, count in ((0.2e-3, 0), (1e-3, 2)):
        tube = Segment("tube", CircleContour(11.2e-3 + wall), (CircleContour(11.2e-3),), 0.0, 10e-3)
        assert len(broken_edges(PIN, casing(PIN), part.of([tube]))) == count


def test_thin_pins_have_small_chamfers_and_drawings_state_them():
    """A tenth of the radius: 0.3 mm at 6 mm of diameter, less at thinner pins."""
    thin = Reducer(PRESETS["pin"].but(output={"core_radius": 1.5e-3}))
    sizes = casing(thin)
    part = assembly_parts(thin, sizes)["output_pin"]
    assert [edge.size for edge in broken_edges(thin, sizes, part)] == pytest.approx([0.15e-3, 0.15e-3])
    notes = next(one for one in part_drawings(thin, sizes) if one.name == "output").notes
    assert "⌀3: chamfer 0.15 x 45°" in notes
    assert any(note.endswith(": chamfer 0.3 x 45°") for note in notes)


def test_solids_lose_the_volume_of_their_chamfers():
    """A chamfer of width c around a bore of radius R takes pi c^2 (R + c/3), a fillet r adds to a journal."""
    pytest.importorskip("OCP")
    sizes = casing(PIN)
    part = assembly_parts(PIN, sizes)["output_cover"]
    edges, sections = broken_edges(PIN, sizes, part), part.sections(1)
    sharp, broken = (read_volume(step_part(part.name, sections, edges=one)) for one in ((), edges))
    c, radius = EDGES.chamfer, 0.5 * sizes.hub.outside
    assert sharp - broken == pytest.approx(2.0 * math.pi * c**2 * (radius + c / 3.0), rel=1e-4)
    journal = Segment("journal", CircleContour(5e-3), (), 0.0, 10e-3)
    flange = Segment("flange", CircleContour(9e-3), (), 10e-3, 12e-3)
    step = part.of([journal, flange]).sections(1)
    r = 0.3e-3
    fillet = BrokenEdge((0.0, 0.0), 5e-3, 10e-3, r, is_fillet=True)
    added = read_volume(step_part("shaft", step, edges=[fillet])) - read_volume(step_part("shaft", step))
    area, centroid = (1.0 - math.pi / 4.0) * r**2, r * (10.0 - 3.0 * math.pi) / (12.0 - 3.0 * math.pi)
    assert added == pytest.approx(2.0 * math.pi * (5e-3 + centroid) * area, rel=1e-4)
