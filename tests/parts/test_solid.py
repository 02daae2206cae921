"""Solids: closed forms, Green's theorem against trimesh's own integrals, the balance, and what must be refused."""

import math
import re
from contextlib import nullcontext

import numpy as np
import pytest
import trimesh
from designs import CENTRAL, FEW_TEETH_CHANGES
from matplotlib.path import Path as PolygonPath

from cycloid_mj.base import names
from cycloid_mj.base.errors import DesignError
from cycloid_mj.checks.body import counterweight_rule
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.figures.geometry import masses
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.kinematics import gear_centre, gear_rotation
from cycloid_mj.measure.reaction import unbalance
from cycloid_mj.parts import (
    VISUAL_CHORD_ERROR,
    Prism,
    Solid,
    body_solids,
    circle,
    crank_solid,
    gear_solid,
    housing_solid,
    mass_chord_error,
    mass_properties,
    mesh,
    output_centres,
    output_solid,
    parts,
    pin_solid,
    shaft_solid,
)
from cycloid_mj.parts.gear import section_area
from cycloid_mj.parts.polygon import arc, area_moments
from cycloid_mj.reducer import Reducer

PIN, NONPIN = PRESETS["pin"], PRESETS["nonpin"]
FEW_TEETH = override(PIN, FEW_TEETH_CHANGES)
MANY_TEETH = override(
    NONPIN,
    [
        "ring.teeth=100",
        "ring.pin_circle_radius_mm=100.0",
        "ring.pin_radius_mm=1.4",
        "gear.eccentricity_mm=0.7",
        "output.pin_circle_radius_mm=60.0",
        "output.hole_radius_mm=4.7",
        "shaft.counterweight_radius_mm=50.0",
        "housing.outer_radius_mm=110.0",
    ],
)
DESIGNS = {"pin": PIN, "nonpin": NONPIN, "few teeth": FEW_TEETH, "many teeth": MANY_TEETH}
PARTS = [
    (which, part)
    for which, design in DESIGNS.items()
    for part in ("housing", "shaft", "gear", "pin", "output")
    if part != "pin" or design.ring.kind == "pin"
]

# A polygon with its vertices on the curve and the chord error s loses area to first order in s only; with s at most
# 5e-7 of the radius the loss is at most 6.7e-7 of the area, so 1e-6 holds for every part.
CLOSED_FORM = 1e-6


@pytest.fixture(params=DESIGNS.values(), ids=DESIGNS.keys())
def design(request: pytest.FixtureRequest) -> Design:
    return request.param


def solid_of(outline: np.ndarray, *holes: np.ndarray, z0: float = -0.01, z1: float = 0.03) -> Solid:
    return Solid("tried", (Prism(outline, holes, z0, z1),), 7850.0)


# --- polygons ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("chord_error", [1e-4, 1e-6, 1e-9])
def test_vertices_lie_on_the_circle_and_chords_keep_their_error(chord_error: float) -> None:
    polygon = circle(0.02, chord_error, (0.01, -0.03)) - [0.01, -0.03]
    middles = (polygon + np.roll(polygon, -1, axis=0)) / 2
    np.testing.assert_allclose(np.hypot(*polygon.T), 0.02, rtol=1e-14)
    sagitta = 0.02 - np.hypot(*middles.T)
    assert sagitta.max() <= chord_error * (1 + 1e-6)  # 1e-6: rounding of 1 - 5e-8
    fewer = 0.02 * (1 - math.cos(math.pi / (len(polygon) - 1)))
    assert fewer > chord_error  # one vertex less would not do


@pytest.mark.parametrize("chord_error", [1e-5, 1e-6, 1e-7])
def test_the_area_of_a_polygonal_circle_is_low_by_four_thirds_of_its_chord_error(chord_error: float) -> None:
    loss = 1 - area_moments(circle(0.02, chord_error)).area / (math.pi * 0.02**2)
    sagitta = 1 - math.cos(math.pi / len(circle(0.02, chord_error)))
    assert loss == pytest.approx(4 / 3 * sagitta, rel=0.01)  # the next term is of relative order s/r <= 5e-4


def test_area_moments_of_a_triangle_are_exact() -> None:
    # triangle (0,0) (a,0) (0,b): A = ab/2, x a/3, y b/3, x2 a^2/6, y2 b^2/6, xy ab/12, each times A
    a, b = 0.3, 0.7
    expected = a * b / 2 * np.array([1, a / 3, b / 3, a * a / 6, b * b / 6, a * b / 12])
    triangle = np.array([[0, 0], [a, 0], [0, b]])
    np.testing.assert_allclose(area_moments(triangle), expected, rtol=1e-15)
    np.testing.assert_allclose(area_moments(triangle[::-1]), -expected, rtol=1e-15)


def test_a_crossing_outline_is_refused_like_in_a_test_of_all_edge_pairs() -> None:
    rng = np.random.default_rng(7)
    found = 0
    for _ in range(200):
        angle = np.sort(rng.uniform(0, 2 * np.pi, 7)) + rng.normal(0, 0.25, 7)
        polygon = rng.uniform(0.5, 1.5, (7, 1)) * profile.unit(angle)
        expected = any(
            segments_meet(polygon[i], polygon[(i + 1) % 7], polygon[j], polygon[(j + 1) % 7])
            for i in range(7)
            for j in range(i + 2, 7 - (i == 0))
        )
        outline = polygon if area_moments(polygon).area > 0.0 else polygon[::-1]
        with pytest.raises(DesignError, match="touch or cross") if expected else nullcontext():
            mesh(Prism(outline, (), 0.0, 1.0))
        found += expected
    assert 20 < found < 180  # both answers occur


def segments_meet(a: np.ndarray, b: np.ndarray, p: np.ndarray, q: np.ndarray) -> bool:
    """Solve a + s (b - a) = p + t (q - p) and look whether s and t are within [0, 1]."""
    s, t = np.linalg.solve(np.column_stack([b - a, p - q]), p - a)
    return bool(0 <= s <= 1 and 0 <= t <= 1)


# --- mass properties --------------------------------------------------------------------------------------------------


def test_block_with_a_square_hole_is_exact() -> None:
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2
    block = solid_of(0.4 * square + [1.0, 2.0], 0.1 * square + [1.0, 2.0])
    found = mass_properties(block)
    outer, inner = 7850.0 * 0.04 * 0.4**2, 7850.0 * 0.04 * 0.1**2
    assert found.mass == pytest.approx(outer - inner, rel=1e-14)
    np.testing.assert_allclose(found.centroid, [1.0, 2.0, 0.01], rtol=1e-13)
    across = (outer * (0.4**2 + 0.04**2) - inner * (0.1**2 + 0.04**2)) / 12
    along = (outer * 2 * 0.4**2 - inner * 2 * 0.1**2) / 12
    # the block stands 2 m from the origin: 1e-16 of (2/0.1)^2 is lost in the parallel-axis theorem
    np.testing.assert_allclose(found.inertia, np.diag([across, across, along]), rtol=1e-11, atol=1e-12 * along)


def test_cylinder_and_annulus_have_their_closed_forms() -> None:
    outer, inner, height = 0.02, 0.012, 0.04
    fine = 5e-7 * inner
    for hole in (0.0, inner):
        holes = [circle(hole, fine)] if hole else []
        found = mass_properties(solid_of(circle(outer, fine), *holes))
        mass = 7850.0 * math.pi * (outer**2 - hole**2) * height
        along, across = mass * (outer**2 + hole**2) / 2, mass * (3 * (outer**2 + hole**2) + height**2) / 12
        assert found.mass == pytest.approx(mass, rel=CLOSED_FORM)
        assert found.volume == pytest.approx(mass / 7850.0, rel=CLOSED_FORM)
        # r^4 loses twice the share of r^2
        np.testing.assert_allclose(
            found.inertia, np.diag([across, across, along]), rtol=2 * CLOSED_FORM, atol=1e-15 * along
        )


def test_half_disc_has_its_closed_form() -> None:
    radius = 0.03
    found = mass_properties(solid_of(arc(radius, math.pi, 2 * math.pi, 5e-7 * radius), z0=-0.001, z1=0.001))
    mass = 7850.0 * math.pi * radius**2 / 2 * 0.002
    centroid = -4 * radius / (3 * math.pi)
    ixx = mass * (radius**2 / 4 - centroid**2 + 0.002**2 / 12)
    iyy = mass * (radius**2 / 4 + 0.002**2 / 12)
    izz = mass * (radius**2 / 2 - centroid**2)
    assert found.mass == pytest.approx(mass, rel=CLOSED_FORM)
    np.testing.assert_allclose(found.centroid, [0, centroid, 0], rtol=CLOSED_FORM, atol=1e-17)
    # the centroid's share is taken from radius^2/4: its error counts 1 / (1 - 64/(9 pi^2)) = 3.6 times
    np.testing.assert_allclose(found.inertia, np.diag([ixx, iyy, izz]), rtol=4 * CLOSED_FORM, atol=1e-15 * izz)


def test_prisms_add_by_the_parallel_axis_theorem() -> None:
    near, far = (Prism(circle(0.01, 1e-5, place), (), z, z + 0.02) for place, z in [((0, 0), 0.0), ((0.3, 0.4), 0.5)])
    one = mass_properties(Solid("one", (near,), 7850.0))
    both = mass_properties(Solid("both", (near, far), 7850.0))
    apart = np.array([0.3, 0.4, 0.5])
    assert both.mass == pytest.approx(2 * one.mass, rel=1e-13)
    np.testing.assert_allclose(both.centroid, one.centroid + apart / 2, rtol=1e-13)
    steiner = one.mass / 2 * (apart @ apart * np.eye(3) - np.outer(apart, apart))
    np.testing.assert_allclose(both.inertia, 2 * one.inertia + steiner, rtol=1e-10)


# --- the parts of the reducer -----------------------------------------------------------------------------------------


def test_every_part_is_there(design: Design) -> None:
    expected = ["housing", "shaft", "gear", "pin", "output"]
    if design.ring.kind == "nonpin":
        expected.remove("pin")
    named = parts(Reducer(design), VISUAL_CHORD_ERROR)
    assert list(named) == expected
    assert all(solid.name == name and solid.density == design.material.density for name, solid in named.items())


def test_gear_mass_is_its_closed_form(design: Design) -> None:
    pair = design.clearance.pin_gear if design.ring.kind == "pin" else design.clearance.tooth
    ring = design.ring
    teeth = profile.CycloidGear(ring.teeth, design.gear.eccentricity, ring.pin_circle_radius, ring.pin_radius)
    bore = math.pi * (design.gear.bore_radius + design.clearance.cam) ** 2
    holes = design.output.pins * math.pi * (design.output.hole_radius + design.clearance.output) ** 2

    def mass(offset: float) -> float:
        return design.material.density * design.gear.face_width * (profile.area(teeth, offset) - bore - holes)

    found = mass_properties(gear_solid(Reducer(design)))
    assert found.mass == pytest.approx(mass(ring.pin_radius + pair), rel=CLOSED_FORM)
    assert found.mass != pytest.approx(mass(ring.pin_radius), rel=10 * CLOSED_FORM)  # the clearance is seen
    np.testing.assert_allclose(found.centroid, 0.0, atol=1e-12)


def test_pin_output_and_pinwheel_have_their_closed_forms() -> None:
    density, width = PIN.material.density, PIN.gear.face_width
    pin = mass_properties(pin_solid(Reducer(PIN))).mass
    assert pin == pytest.approx(density * width * math.pi * PIN.ring.pin_radius**2, rel=CLOSED_FORM)

    disc = 0.008 * (0.026 + 1.5 * 0.004) ** 2
    pins = 8 * 0.011 * 0.004**2  # 10 mm in the gear and the gap of 1 mm
    output = mass_properties(output_solid(Reducer(PIN))).mass
    assert output == pytest.approx(density * math.pi * (disc + pins), rel=CLOSED_FORM)

    # disc of radius E and N sockets of radius r on its rim, less N lenses of the two
    big, small = PIN.ring.pin_circle_radius, PIN.ring.pin_radius + PIN.clearance.pin_socket
    lens = (
        small**2 * math.acos(small / (2 * big))
        + big**2 * math.acos(1 - small**2 / (2 * big**2))
        - small / 2 * math.sqrt(4 * big**2 - small**2)
    )
    hole = math.pi * big**2 + 36 * (math.pi * small**2 - lens)
    housing = mass_properties(housing_solid(Reducer(PIN))).mass
    assert housing == pytest.approx(density * width * (math.pi * 0.05**2 - hole), rel=CLOSED_FORM)


def test_nonpin_housing_is_the_annulus_of_the_internal_gear() -> None:
    bore_area = 4895.8471e-6  # m2, of the double-enveloping ring of the preset, to 5e-11
    expected = NONPIN.material.density * NONPIN.gear.face_width * (math.pi * 0.05**2 - bore_area)
    assert mass_properties(housing_solid(Reducer(NONPIN))).mass == pytest.approx(expected, rel=CLOSED_FORM)


def test_fixed_pins_are_pressed_in() -> None:
    fixed = override(PIN, ["ring.pins=fixed"])
    for design, play in [(fixed, 0.0), (PIN, 1e-6)]:
        hole = housing_solid(Reducer(design)).prisms[0].holes[0]
        bottom = np.hypot(*hole.T).max()
        assert bottom == pytest.approx(0.04075 + 0.00225 + play, abs=1e-8)  # no vertex need be quite at the bottom


@pytest.mark.parametrize("teeth", [33, 34, 36])
def test_the_sockets_are_arcs_about_the_pin_centres(teeth: int) -> None:
    hole = housing_solid(Reducer(override(PIN, [f"ring.teeth={teeth}"])), 1e-6).prisms[0].holes[0]
    pins = PIN.ring.pin_circle_radius * profile.unit(2 * np.pi * np.arange(teeth) / teeth)
    nearest = np.hypot(*(hole[:, None] - pins).transpose(2, 0, 1)).min(axis=1)
    on_the_wall = np.isclose(np.hypot(*hole.T), PIN.ring.pin_circle_radius, rtol=1e-12)
    np.testing.assert_allclose(nearest[~on_the_wall], 0.002251, rtol=1e-12)
    assert (nearest[on_the_wall] > 0.002251 * (1 - 1e-12)).all()
    assert on_the_wall.sum() > teeth  # the ends of the sockets, and the wall between them


def test_the_counterweight_balances_the_gear(design: Design) -> None:
    for chord_error in (None, VISUAL_CHORD_ERROR):
        gear = mass_properties(gear_solid(Reducer(design), chord_error))
        shaft = mass_properties(shaft_solid(Reducer(design), chord_error))
        moment = gear.mass * design.gear.eccentricity
        assert moment + shaft.mass * shaft.centroid[1] == pytest.approx(0.0, abs=1e-9 * moment)
        assert shaft.mass * shaft.centroid[0] == pytest.approx(0.0, abs=1e-9 * moment)


def test_the_counterweight_balances_a_gear_of_another_material() -> None:
    """A printed gear on a steel shaft: 2.49 mm of steel; the check of the shaft's length reckons with as much."""
    design = PRESETS["printed"]
    gear, shaft = mass_properties(gear_solid(Reducer(design))), mass_properties(shaft_solid(Reducer(design)))
    assert gear.mass * design.gear.eccentricity == pytest.approx(-shaft.mass * shaft.centroid[1], rel=1e-9)
    found = unbalance(Reducer(design))
    assert abs(found.balanced) < 1e-6 * found.bare
    long, short = (Reducer(override(design, [f"shaft.length_mm={length}"])) for length in (2.6, 2.4))
    assert counterweight_rule(long).limit.is_met(long)
    assert not counterweight_rule(short).limit.is_met(short)
    with pytest.raises(DesignError, match="no counterweight within the shaft's length"):
        shaft_solid(short)


@pytest.mark.parametrize("change", ["modification.rotation_arcsec=0", "modification.rotation_arcsec=40"])
def test_the_area_of_a_disc_is_that_of_its_solid(change: str) -> None:
    reducer = Reducer(override(PIN, [change]))
    for chord_error in (None, VISUAL_CHORD_ERROR):
        volume = mass_properties(gear_solid(reducer, chord_error)).volume
        assert section_area(reducer, chord_error) * PIN.gear.face_width == pytest.approx(volume, rel=1e-11)


def test_the_counterweight_has_the_closed_thickness() -> None:
    gear = mass_properties(gear_solid(Reducer(PIN))).mass
    cam = PIN.material.density * math.pi * 0.015**2 * 0.010
    thickness = 1.5 * (gear + cam) * 0.001 / (PIN.material.density * (0.030**3 - 0.008**3))
    journal, counterweight, gap, cam_prism = shaft_solid(Reducer(PIN)).prisms
    assert counterweight.height == pytest.approx(thickness, rel=CLOSED_FORM)
    assert counterweight.outline[:, 1].min() == pytest.approx(-0.030, rel=CLOSED_FORM)
    assert counterweight.outline[:, 1].max() == pytest.approx(0.008, rel=CLOSED_FORM)
    stack = [(prism.z0, prism.z1) for prism in (journal, counterweight, gap, cam_prism)]
    assert [low for low, _ in stack[1:]] == [high for _, high in stack[:-1]]
    assert stack[0][0] == pytest.approx(-0.036)
    assert stack[-1] == (-0.005, 0.005)


@pytest.mark.parametrize("discs", [2, 3, 4])
def test_several_discs_balance_each_other(discs: int) -> None:
    """No counterweight: the static moments of discs and cams add up to nothing, and each disc lies on its own cam."""
    design = override(PIN, [f"gear.discs={discs}", "gear.disc_gap_mm=1.5"])
    whole, found = mass_properties(body_solids(Reducer(design))["shaft"]), parts(Reducer(design))
    assert abs(whole.centroid[:2]).max() < 1e-9
    planes, angles = design.gear.disc_planes, 2.0 * math.pi * np.arange(discs) / discs
    for disc, (plane, angle) in enumerate(zip(planes, angles, strict=True)):
        (cam,) = found[f"cam_{disc + 1}"].prisms
        assert (cam.z0, cam.z1) == pytest.approx((plane - 5e-3, plane + 5e-3), abs=1e-15)
        np.testing.assert_allclose(cam.outline.mean(axis=0), [-1e-3 * np.sin(angle), 1e-3 * np.cos(angle)], atol=1e-9)
    apart = sum(mass_properties(found[name]).mass for name in found if name.startswith(("shaft", "cam_")))
    apart += (discs - 1) * mass_properties(found["spacer"]).mass
    assert whole.mass == pytest.approx(apart, rel=1e-9)


def test_the_teeth_of_a_disc_ahead_on_the_crank_are_turned_against_its_holes() -> None:
    design = override(PIN, ["gear.discs=3"])
    first, second = (gear_solid(Reducer(design), 1e-6, disc).prisms[0] for disc in (0, 1))
    turn = -2.0 * math.pi / 3.0 / design.lobes
    cos, sin = math.cos(turn), math.sin(turn)
    np.testing.assert_allclose(second.outline, first.outline @ [[cos, sin], [-sin, cos]], atol=1e-15)
    for hole, same in zip(first.holes, second.holes, strict=True):
        np.testing.assert_array_equal(hole, same)


def test_a_second_output_disc_supports_the_pins_around_the_crank() -> None:
    design = override(PIN, ["output.support=both_ends", "gear.discs=2"])
    disc, *pins, second = output_solid(Reducer(design), 1e-6).prisms
    assert all((pin.z0, pin.z1) == (second.z1, disc.z0) for pin in pins)
    assert second.z1 < design.gear.disc_planes[0] - 5e-3
    eye, crank = np.linalg.norm(second.holes[0], axis=1).max(), body_solids(Reducer(design))["shaft"]
    for prism in crank.prisms:
        if prism.z0 < second.z1 and prism.z1 > second.z0:
            assert np.linalg.norm(prism.outline, axis=1).max() < eye
    assert np.linalg.norm(parts(Reducer(design), 1e-6)["cam_1"].prisms[0].outline, axis=1).max() <= eye * (1.0 + 1e-12)


def test_cams_need_a_wall_around_the_shaft() -> None:
    with pytest.raises(DesignError, match=r"shaft.radius_mm = 14.5 .* cams leave no wall"):
        parts(Reducer(override(PIN, ["gear.discs=2", "shaft.radius_mm=14.5"])), 1e-5)


def test_holes_and_output_pins_are_numbered_clockwise_from_y() -> None:
    centres = output_centres(Reducer(PIN))
    np.testing.assert_allclose(centres[[0, 2, 4, 6]], 0.026 * np.array([[0, 1], [1, 0], [0, -1], [-1, 0]]), atol=1e-17)
    holes = gear_solid(Reducer(PIN), 1e-6).prisms[0].holes[1:]
    pins = output_solid(Reducer(PIN), 1e-6).prisms[1:]
    np.testing.assert_allclose([hole.mean(axis=0) for hole in holes], centres, atol=1e-15)
    np.testing.assert_allclose([pin.outline.mean(axis=0) for pin in pins], centres, atol=1e-15)


# --- meshes -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("which", "part"), PARTS)
def test_meshes_are_closed_and_weigh_what_the_outlines_do(which: str, part: str) -> None:
    solid = parts(Reducer(DESIGNS[which]), VISUAL_CHORD_ERROR)[part]
    drawn = mesh(solid)
    told = trimesh.Trimesh(drawn.vertices, drawn.faces, process=False)
    told.density = solid.density
    expected = mass_properties(solid)
    assert told.is_watertight
    assert told.is_winding_consistent
    # both are exact for the polygons; 1e-9 is rounding, magnified by the distance from the origin
    assert told.volume == pytest.approx(expected.volume, rel=1e-9)
    np.testing.assert_allclose(told.center_mass, expected.centroid, atol=1e-9 * told.scale)
    size = np.trace(expected.inertia)
    np.testing.assert_allclose(told.moment_inertia, expected.inertia, atol=1e-9 * size)
    for prism in solid.prisms:
        one = mesh(prism)
        assert trimesh.Trimesh(one.vertices, one.faces).is_volume  # also when trimesh joins equal vertices


def test_visual_meshes_are_small() -> None:
    for name, solid in parts(Reducer(PIN), VISUAL_CHORD_ERROR).items():
        assert len(mesh(solid).faces) < 8000, name


def test_exactly_straight_runs_of_vertices_stay_in_the_mesh() -> None:
    side = np.linspace(0.0, 1.0, 9)[:-1]
    zero, one = np.zeros(8), np.ones(8)
    rim = [np.column_stack(edge) for edge in [(side, zero), (one, side), (1 - side, one), (zero, 1 - side)]]
    square = np.concatenate(rim) - 0.5
    drawn = mesh(Prism(square, (0.25 * square, 0.125 * square + [0.25, 0.0]), 0.0, 1.0))
    assert len(np.unique(drawn.faces)) == len(drawn.vertices) == 6 * 32
    assert trimesh.Trimesh(drawn.vertices, drawn.faces, process=False).is_watertight


@pytest.mark.parametrize(("which", "part"), [("pin", "gear"), ("nonpin", "housing")])
def test_meshes_converge_with_the_chord_error(which: str, part: str) -> None:
    # area lost by chords is of first order in their error: ten times finer, ten times nearer
    exact = mass_properties(parts(Reducer(DESIGNS[which]), 1e-8)[part]).mass
    coarse, fine = (mass_properties(parts(Reducer(DESIGNS[which]), error)[part]).mass - exact for error in (1e-5, 1e-6))
    assert coarse / fine == pytest.approx(10, rel=0.15)


# --- what is refused --------------------------------------------------------------------------------------------------

SQUARE = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])


def test_a_self_crossing_outline_is_refused() -> None:
    crossed = np.array([[0.0, 0], [3, 0], [3, 3], [1, 3], [1, -1], [0, -1]])
    with pytest.raises(DesignError, match=r"of the tried .*cross near x = "):
        mesh(solid_of(crossed))
    assert mesh(solid_of(crossed[:4])).faces.size  # without its tail it is fine


@pytest.mark.parametrize(
    ("hole", "message"),
    [
        (0.5 * SQUARE + [0.75, 0.25], "cross"),
        (0.5 * SQUARE + [0.5, 0.25], "cross"),  # touches from inside
        (0.5 * SQUARE + [2.0, 0.0], "volume"),
        (2.0 * SQUARE - 0.5, "volume"),
    ],
)
def test_a_hole_outside_the_outline_is_refused(hole: np.ndarray, message: str) -> None:
    with pytest.raises(DesignError, match=f"of the tried .*{message}"):
        mesh(solid_of(SQUARE, hole))
    assert mesh(solid_of(SQUARE, 0.5 * SQUARE + 0.25)).faces.size


def test_a_hole_in_a_hole_is_refused() -> None:
    with pytest.raises(DesignError, match=r"of the tried .*volume"):
        mesh(solid_of(SQUARE, 0.5 * SQUARE + 0.25, 0.25 * SQUARE + 0.4))


@pytest.mark.parametrize("polygon", [SQUARE[::-1], SQUARE[:2], np.zeros((4, 3)), SQUARE * np.nan])
def test_a_polygon_that_is_not_a_counter_clockwise_polygon_is_refused(polygon: np.ndarray) -> None:
    with pytest.raises(DesignError, match="the outline or a hole of a prism"):
        Prism(polygon, (), 0.0, 1.0)


def test_a_prism_without_height_is_refused_and_its_polygons_are_locked() -> None:
    with pytest.raises(DesignError, match="no height"):
        Prism(SQUARE, (), 1.0, 1.0)
    with pytest.raises(ValueError, match="read-only"):
        Prism(SQUARE, (), 0.0, 1.0).outline[0] = 5.0


# each limit of the pin preset in mm, from the radii of physics and a clearance of 0.001
@pytest.mark.parametrize(
    ("key", "limit", "allowed"),
    [
        ("output.hole_radius", 5.0, "more"),  # pin 4 + eccentricity 1
        ("gear.bore_radius", 26 - 5.001 - 0.001, "less"),
        ("output.pin_circle_radius", 40.75 - 1 - 2.251 - 5.001, "less"),
        ("ring.pin_radius", 1.0, "more"),  # eccentricity
        ("housing.outer_radius", 40.75 + 2.251, "more"),
        ("shaft.counterweight_radius", None, "more"),
    ],
)
def test_parts_that_do_not_fit_are_refused_by_name(key: str, limit: float | None, allowed: str) -> None:
    start = PIN
    if key == "shaft.counterweight_radius":
        start = override(PIN, ["shaft.length_mm=3.0"])
        unbalance = (
            1.5
            * (mass_properties(gear_solid(Reducer(PIN))).mass / PIN.material.density + math.pi * 0.015**2 * 0.010)
            * 1e-3
        )
        limit = 1e3 * (0.008**3 + unbalance / 0.003) ** (1 / 3)
    assert limit is not None
    outward = 1e-4 if allowed == "less" else -1e-4
    assert parts(Reducer(override(start, [f"{key}_mm={limit - outward:.9f}"])), 1e-8)
    with pytest.raises(DesignError, match=f"^{re.escape(key)}_mm = .* is not allowed: make it {allowed} than"):
        parts(Reducer(override(start, [f"{key}_mm={limit + outward:.9f}"])), 1e-8)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (["output.pins=20"], r"output\.hole_radius_mm .* neighbouring holes meet"),
        (["shaft.counterweight_radius_mm=7.0"], r"shaft\.counterweight_radius_mm .* within the shaft"),
        (["ring.pin_radius_mm=2.7"], "undercut"),
        (["ring.kind=nonpin", "housing.outer_radius_mm=40.0"], r"housing\.outer_radius_mm"),
    ],
)
def test_other_misfits_are_refused_by_name(changes: list[str], message: str) -> None:
    with pytest.raises(DesignError, match=message):
        parts(Reducer(override(PIN, changes)), 1e-6)


# --- the parts together -----------------------------------------------------------------------------------------------

MESHING = 4e-7  # chord error [m]: twice that is within the clearance of 1 um


def in_the_ring(points: np.ndarray, design: Design, crank_angle: float) -> np.ndarray:
    """Move points from the gear's frame to the frame of the reducer axis."""
    teeth = profile.CycloidGear(
        design.ring.teeth, design.gear.eccentricity, design.ring.pin_circle_radius, design.ring.pin_radius
    )
    turn = float(gear_rotation(teeth, crank_angle))
    matrix = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    return gear_centre(teeth, crank_angle) + points @ matrix.T


def overlap(gear: np.ndarray, hole: np.ndarray) -> bool:
    """Tell whether a vertex of the gear is outside the hole or a vertex of the hole inside the gear."""
    outside = ~PolygonPath(hole).contains_points(gear)
    return bool(outside.any() or PolygonPath(gear).contains_points(hole).any())


@pytest.mark.slow
def test_the_gear_orbits_in_the_housing_without_touching_it(design: Design) -> None:
    gear = gear_solid(Reducer(design), MESHING).prisms[0].outline
    hole = housing_solid(Reducer(design), MESHING).prisms[0].holes[0]
    for crank_angle in 0.1 + np.linspace(0.0, 2 * np.pi, 8, endpoint=False):
        assert not overlap(in_the_ring(gear, design, crank_angle), hole)
    gap = 4e-6 if design.ring.kind == "nonpin" else 1e-3
    assert overlap(in_the_ring(gear, design, 0.1) + np.array([0.0, gap]), hole)


@pytest.mark.parametrize("design", [PIN, FEW_TEETH], ids=["pin", "few teeth"])
def test_the_gear_leaves_each_pin_its_clearance(design: Design) -> None:
    gear = in_the_ring(gear_solid(Reducer(design), MESHING).prisms[0].outline, design, 0.3)
    along = np.roll(gear, -1, axis=0) - gear
    for angle in 2 * np.pi * np.arange(design.ring.teeth) / design.ring.teeth:
        to = design.ring.pin_circle_radius * profile.unit(angle) - gear
        foot = np.clip((to * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
        distance = np.hypot(*(to - foot[:, None] * along).T).min()
        assert distance - design.ring.pin_radius == pytest.approx(design.clearance.pin_gear, abs=MESHING)


def test_output_pins_orbit_in_their_holes() -> None:
    hole = circle(PIN.output.hole_radius + PIN.clearance.output, 1e-7)
    pin = circle(PIN.output.pin_radius, 1e-7)
    for crank_angle in np.linspace(0.0, 2 * np.pi, 8, endpoint=False):
        around = PIN.gear.eccentricity * np.array([-math.sin(crank_angle), math.cos(crank_angle)])
        assert PolygonPath(hole + around).contains_points(pin).all()
        assert not PolygonPath(hole + 1.002 * around).contains_points(pin).all()


def test_mass_chord_error_follows_the_thinnest_radius() -> None:
    assert mass_chord_error(Reducer(PIN)) == pytest.approx(5e-7 * 0.00225)
    assert mass_chord_error(Reducer(override(PIN, ["output.pin_radius_mm=1.0"]))) == pytest.approx(5e-7 * 0.001)


@pytest.mark.parametrize("chord_error", [0.0, -1e-6, math.nan])
def test_a_chord_error_that_is_not_positive_is_refused(chord_error: float) -> None:
    for builder in (gear_solid, pin_solid, housing_solid, shaft_solid, output_solid):
        with pytest.raises(DesignError, match=r"chord_error = .* greater than 0 m"):
            builder(Reducer(PIN), chord_error)


@pytest.mark.slow
@pytest.mark.parametrize("discs", [1, 2])
def test_rollers_are_parts_of_their_own_where_their_cores_are_given(discs: int) -> None:
    """The output that moves weighs discs, cores and rollers, each by its closed form, and turns with all of them."""
    design = override(PIN, [f"gear.discs={discs}", "output.core_radius_mm=2.5", "output.support=both_ends"])
    found, output, gear = parts(Reducer(design)), design.output, design.gear
    (roller,) = found["output_roller"].prisms
    assert (roller.z0, roller.z1) == (-gear.face_width / 2, gear.face_width / 2)
    density, orbit = design.material_of("output").density, output.pin_circle_radius
    rim, eye = orbit + 1.5 * output.pin_radius, gear.bore_radius + gear.eccentricity
    tube = math.pi * density * gear.face_width * (output.pin_radius**2 - output.core_radius**2)
    core = math.pi * density * (gear.stack_width + 2e-3) * output.core_radius**2
    plate = math.pi * density * output.disc_thickness
    apart = mass_properties(found["output"])
    whole = mass_properties(body_solids(Reducer(design))["output"])
    assert mass_properties(found["output_roller"]).mass == pytest.approx(tube, rel=CLOSED_FORM)
    assert apart.mass == pytest.approx(plate * (2.0 * rim**2 - eye**2) + output.pins * core, rel=CLOSED_FORM)
    assert whole.mass == pytest.approx(apart.mass + output.pins * discs * tube, rel=CLOSED_FORM)
    turning = tube * (orbit**2 + 0.5 * (output.pin_radius**2 + output.core_radius**2))
    assert whole.inertia[2, 2] == pytest.approx(apart.inertia[2, 2] + output.pins * discs * turning, rel=CLOSED_FORM)
    assert whole.centroid[2] * whole.mass == pytest.approx(apart.centroid[2] * apart.mass, rel=1e-6)
    assert masses(Reducer(design))["output_roller"] == pytest.approx(output.pins * discs * tube, rel=1e-3)
    body = build(design).model.body("output")
    assert body.mass[0] == whole.mass
    assert body.geomnum[0] >= 1 + output.pins * discs


@pytest.mark.parametrize("name", ["pin", "nonpin", "twodisc"])
def test_without_a_core_pin_and_roller_are_one_solid(name: str) -> None:
    design = PRESETS[name]
    found = parts(Reducer(design))
    assert "output_roller" not in found
    assert body_solids(Reducer(design))["output"] is found["output"]
    pins = found["output"].prisms[1 : 1 + design.output.pins]
    radii = [np.hypot(*(pin.outline - pin.outline.mean(axis=0)).T).max() for pin in pins]
    assert radii == pytest.approx([design.output.pin_radius] * len(pins))


@pytest.mark.parametrize("design", CENTRAL.values(), ids=CENTRAL)
def test_the_crank_alone_is_that_of_all_bodies(design: Design) -> None:
    alone, among_all = (
        mass_properties(one) for one in (crank_solid(Reducer(design)), body_solids(Reducer(design))[names.SHAFT])
    )
    assert alone.mass == among_all.mass
    assert np.array_equal(alone.inertia, among_all.inertia)
