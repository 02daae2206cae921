"""The cycloid gear against 30-digit references, finite differences, quadrature and its own conjugacy."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipe, ellipeinc

from cycloid_mj.base.errors import DesignError
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.profile import CycloidGear

DATA = Path(__file__).parents[1] / "data"
PAPER = CycloidGear(ring_teeth=36, eccentricity=1e-3, pin_circle_radius=40.75e-3, pin_radius=2.25e-3)
SMALL = CycloidGear(ring_teeth=12, eccentricity=0.75e-3, pin_circle_radius=15e-3, pin_radius=1.5e-3)
LARGE = CycloidGear(ring_teeth=60, eccentricity=1.2e-3, pin_circle_radius=120e-3, pin_radius=3e-3)
FEW_TEETH = CycloidGear(ring_teeth=6, eccentricity=1.5e-3, pin_circle_radius=20e-3, pin_radius=4e-3)
CONVEX = CycloidGear(ring_teeth=5, eccentricity=0.2e-3, pin_circle_radius=20e-3, pin_radius=4e-3)
GEARS = [PAPER, SMALL, LARGE, FEW_TEETH]
each_gear = pytest.mark.parametrize("gear", GEARS, ids=["paper", "small", "large", "few-teeth"])
each_gear_and_convex = pytest.mark.parametrize(
    "gear", [*GEARS, CONVEX], ids=["paper", "small", "large", "few", "convex"]
)
MM = 1e-3


def reference(name: str) -> np.ndarray:
    return np.genfromtxt(DATA / name, delimiter=",", names=True)


def key_constants() -> dict[str, float]:
    table = np.genfromtxt(DATA / "key_constants.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    return {str(row["name"]): float(row["value"]) for row in table}


def closest_distance(gear: CycloidGear, centres: np.ndarray) -> np.ndarray:
    """Distance from points to the trochoid, by a minimisation blind to conjugacy: grid, then Gauss-Newton."""
    polar = np.arctan2(centres[:, 0], centres[:, 1])
    nearby = polar[:, None] + np.linspace(-1, 1, 61) * 2 * np.pi / gear.lobes
    squares = np.sum((profile.trochoid(gear, nearby) - centres[:, None]) ** 2, axis=-1)
    t = np.take_along_axis(nearby, np.argmin(squares, axis=1)[:, None], axis=1)[:, 0]
    for _ in range(8):
        first, _ = profile.trochoid_derivatives(gear, t)
        t = t - np.sum((profile.trochoid(gear, t) - centres) * first, axis=1) / np.sum(first**2, axis=1)
    refined = np.linalg.norm(profile.trochoid(gear, t) - centres, axis=1)
    return np.minimum(refined, np.sqrt(squares.min(axis=1)))


def pin_centres_in_gear_frame(gear: CycloidGear, crank_angle: float, eccentricity_sign: int = 1) -> np.ndarray:
    """Pin centres through plain vectors: crank counter-clockwise, gear turned back by its rotation."""
    N, c, E, _ = gear.symbols
    pins = 2 * np.pi * np.arange(N) / N
    fixed = E * np.stack([np.sin(pins), np.cos(pins)], axis=1)
    centre = eccentricity_sign * c * np.array([-np.sin(crank_angle), np.cos(crank_angle)])
    rotation = -crank_angle / (N - 1)
    cos, sin = np.cos(rotation), np.sin(rotation)
    return (fixed - centre) @ np.array([[cos, -sin], [sin, cos]])


def test_conjugate_points_agree_with_the_30_digit_reference():
    rows = reference("gear_points.csv")
    pin, crank = 2 * np.pi * (rows["pin_i"] - 1) / 36, np.radians(rows["phi1_deg"])
    contact = profile.conjugate_point(PAPER, pin, crank)
    # 1e-12 mm is some 100 units in the last place of the radius.
    assert np.abs(contact.gear_frame[:, 0] / MM - rows["x2_mm"]).max() < 1e-12
    assert np.abs(contact.gear_frame[:, 1] / MM - rows["y2_mm"]).max() < 1e-12
    assert np.abs(contact.ring_frame[:, 0] / MM - rows["x1_contact_mm"]).max() < 1e-12
    assert np.abs(contact.ring_frame[:, 1] / MM - rows["y1_contact_mm"]).max() < 1e-12
    assert np.abs(profile.conjugate_alpha(PAPER, pin - crank) - rows["alpha_rad"]).max() < 1e-14


def test_the_sign_printed_in_equation_2_misses_the_reference():
    rows = reference("gear_points.csv")
    pin, crank = 2 * np.pi * (rows["pin_i"] - 1) / 36, np.radians(rows["phi1_deg"])
    alpha = profile.conjugate_alpha(PAPER, pin - crank)
    turn = crank / 35
    pin_centre = 40.75 * profile.unit(pin + turn) - profile.unit(36 * turn)
    printed = pin_centre - 2.25 * profile.unit(pin + turn + alpha)
    corrected = pin_centre - 2.25 * profile.unit(pin + turn - alpha)
    assert np.abs(corrected[:, 0] - rows["x2_mm"]).max() < 1e-12
    assert np.abs(printed[:, 0] - rows["x2_mm"]).max() > 1.0


@each_gear
def test_pin_contact_lies_on_the_outline_at_its_phase(gear):
    rng = np.random.default_rng(1)
    pin, crank = profile.pin_angles(gear)[rng.integers(gear.ring_teeth, size=200)], rng.uniform(-20, 20, 200)
    t = pin + crank / gear.lobes
    assert np.abs(np.exp(1j * profile.phase(gear, t)) - np.exp(1j * (pin - crank))).max() < 1e-12
    contact = profile.conjugate_point(gear, pin, crank).gear_frame
    assert np.abs(contact - profile.outline(gear, t)).max() < 1e-15


@each_gear
def test_all_pins_touch_at_every_crank_angle(gear):
    cranks = np.linspace(0, 2 * np.pi * gear.lobes, 301)
    centres = np.concatenate([pin_centres_in_gear_frame(gear, crank) for crank in cranks])
    assert closest_distance(gear, centres).max() < 1e-9 * MM


@each_gear
def test_pins_do_not_touch_with_the_eccentricity_reversed(gear):
    spoiled = pin_centres_in_gear_frame(gear, 0.3, eccentricity_sign=-1)
    assert closest_distance(gear, spoiled).max() > 0.1 * gear.eccentricity


@each_gear
def test_trochoid_derivatives_are_second_order_limits_of_differences(gear):
    t = np.linspace(0.0, 6.0, 101)
    first, second = profile.trochoid_derivatives(gear, t)

    def errors(h: float) -> np.ndarray:
        back, here, ahead = (profile.trochoid(gear, t + step) for step in (-h, 0, h))
        return np.array(
            [np.abs((ahead - back) / (2 * h) - first).max(), np.abs((ahead - 2 * here + back) / h**2 - second).max()]
        )

    step = 1e-2 / gear.ring_teeth
    order = np.log2(errors(2 * step) / errors(step))
    assert np.abs(order - 2).max() < 0.02


@each_gear_and_convex
def test_normals_and_curvature_match_finite_differences_of_the_outline(gear):
    t = np.linspace(0.0, 2 * np.pi, 401)
    h = 1e-4 / gear.ring_teeth
    ahead, back = profile.outline(gear, t + h), profile.outline(gear, t - h)
    tangent = (ahead - back) / np.linalg.norm(ahead - back, axis=1)[:, None]
    outward = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    assert np.abs(profile.normals(gear, t) - outward).max() < 1e-6
    turn = np.cross(
        np.pad(profile.normals(gear, t + h), ((0, 0), (0, 1))), np.pad(profile.normals(gear, t - h), ((0, 0), (0, 1)))
    )[:, 2]
    bend = turn / np.linalg.norm(ahead - back, axis=1)
    assert np.abs(profile.curvature(gear, t) - bend).max() < 1e-5 * np.abs(bend).max()
    assert np.abs(profile.turning_rate(gear, t) - np.arcsin(turn) / (2 * h)).max() < 1e-5 * gear.ring_teeth


@each_gear_and_convex
def test_arc_length_is_the_integral_of_its_rate(gear):
    for offset in (None, 0.0):
        end = 1.7 * 2 * np.pi / gear.lobes
        expected, _ = quad(lambda t, d=offset: float(profile.arc_rate(gear, t, d)), 0, end, epsabs=1e-16, limit=200)
        assert float(profile.arc_length(gear, end, offset)) == pytest.approx(expected, rel=1e-12)


@each_gear_and_convex
def test_length_and_area_agree_with_quadrature(gear):
    # The trapezoidal rule converges faster than any power for a smooth closed curve.
    t = np.linspace(0, 2 * np.pi, 800 * gear.lobes, endpoint=False)
    for offset in (None, 0.0, 0.5 * gear.pin_radius):
        rho = gear.pin_radius if offset is None else offset
        points = profile.outline(gear, t, offset)
        first, _ = profile.trochoid_derivatives(gear, t)
        speed = np.linalg.norm(first, axis=1)
        velocity = first * (1 - rho * profile.turning_rate(gear, t) / speed)[:, None]
        step = 2 * np.pi / t.size
        length = np.sum(np.linalg.norm(velocity, axis=1)) * step
        area = np.sum(points[:, 1] * velocity[:, 0] - points[:, 0] * velocity[:, 1]) / 2 * step
        assert profile.length(gear, offset) == pytest.approx(length, rel=1e-12)
        assert profile.area(gear, offset) == pytest.approx(area, rel=1e-12)


def test_constants_of_the_paper_gear():
    known = key_constants()
    valley, tip, best = 0.0, np.pi / 35, PAPER.best_phase / 35
    sharpest = math.radians(known["minRconvex_B_deg"]) / 35
    for t, name in [
        (valley, "gear_valley_R"),
        (tip, "gear_tip_R"),
        (best, "gear_R_at_B0"),
        (sharpest, "gear_min_convex_R"),
    ]:
        assert 1 / profile.curvature(PAPER, t) / MM == pytest.approx(known[name], rel=1e-12)
    assert math.degrees(PAPER.best_phase) == pytest.approx(known["B0_deg"], rel=1e-14)
    assert math.degrees(profile.inflection_phase(PAPER)) == pytest.approx(known["inflection_B_deg"], rel=1e-13)
    assert profile.undercut_radius(PAPER) / MM == pytest.approx(known["rho_max_no_undercut"], rel=1e-13)
    assert profile.radii(PAPER) == pytest.approx((known["gear_root_radius"] * MM, known["gear_tip_radius"] * MM))
    assert profile.length(PAPER) / MM == pytest.approx(295.02245, abs=5e-6)
    assert profile.area(PAPER) / MM**2 == pytest.approx(4650.2035, abs=5e-5)


@each_gear
def test_best_phase_has_the_largest_arm_and_the_smallest_pressure_angle(gear):
    best = gear.best_phase
    around = best + np.linspace(-0.2, 0.2, 401)
    assert profile.moment_arm(gear, best) == pytest.approx(gear.eccentricity * gear.lobes, rel=1e-14)
    assert np.argmax(profile.moment_arm(gear, around)) == 200
    assert np.argmin(profile.pressure_angle(gear, around)) == 200
    assert profile.pressure_angle(gear, best) == pytest.approx(best, rel=1e-13)


@each_gear
def test_moment_arm_is_the_moment_of_the_pins_push(gear):
    t = np.linspace(0, 2 * np.pi, 99)
    points, push = profile.outline(gear, t), -profile.normals(gear, t)
    moment = points[:, 0] * push[:, 1] - points[:, 1] * push[:, 0]
    assert np.abs(profile.moment_arm(gear, profile.phase(gear, t)) - moment).max() < 1e-15


@each_gear_and_convex
def test_undercut_radius_is_the_smallest_convex_trochoid_radius(gear):
    t = np.linspace(0, np.pi / gear.lobes, 200_001)
    bend = profile.curvature(gear, t, 0.0)
    assert profile.undercut_radius(gear) == pytest.approx(1 / bend.max(), rel=1e-8)


def test_undercut_is_refused_at_its_limit_and_not_just_below():
    limit = profile.undercut_radius(PAPER)
    profile.require_no_undercut(PAPER, limit * (1 - 1e-12))
    with pytest.raises(DesignError, match=r"less than 2\.60795 mm, .* undercut.*Reduce pin_radius"):
        profile.require_no_undercut(dataclasses.replace(PAPER, pin_radius=limit))
    with pytest.raises(DesignError, match="undercut"):
        profile.sample(PAPER, 100, offset=2.7e-3)
    with pytest.raises(DesignError, match="undercut"):
        profile.sagitta_parameters(dataclasses.replace(PAPER, pin_radius=2.7e-3), 1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"eccentricity": 40.75e-3 / 36}, "less than pin_circle_radius / ring_teeth = 1.13194 mm.*Reduce eccentricity"),
        ({"ring_teeth": 2}, "at least 3"),
        ({"pin_radius": 0.0}, "pin_radius = 0.0 m is not allowed: give a finite length"),
        ({"pin_circle_radius": math.nan}, "pin_circle_radius = nan"),
    ],
)
def test_gears_that_cannot_be_are_refused(change, message):
    with pytest.raises(DesignError, match=message):
        dataclasses.replace(PAPER, **change)


def test_the_convex_gear_has_no_inflection():
    t = np.linspace(0, 2 * np.pi, 1001)
    assert profile.inflection_phase(CONVEX) == 0
    assert profile.curvature(CONVEX, t).min() > 0
    assert profile.inflection_phase(PAPER) > 0 > profile.curvature(PAPER, t).min()


@each_gear_and_convex
@pytest.mark.parametrize("points", [3, 700, 997])
def test_sample_is_equally_spaced_along_the_outline(gear, points):
    outline = profile.sample(gear, points)
    total = profile.length(gear)
    spacing = np.diff(np.append(outline.arc_length, total))
    assert np.abs(spacing - total / points).max() < 1e-13 * total
    assert outline.points[0] == pytest.approx([0.0, profile.radii(gear)[0]], abs=1e-15)
    assert outline.points.shape == outline.normals.shape == (points, 2)
    # Quadrature by itself, between neighbours, knows no elliptic integral.
    nodes, weights = np.polynomial.legendre.leggauss(40)
    panels = 300 if points == 3 else 1
    ends = np.append(outline.t, 2 * np.pi)
    starts = ends[:-1, None] + np.diff(ends)[:, None] * np.arange(panels) / panels
    half = np.diff(ends)[:, None, None] / (2 * panels)
    rates = profile.arc_rate(gear, starts[..., None] + half * (1 + nodes))
    assert np.abs(np.sum((half * rates) @ weights, axis=1) - total / points).max() < 1e-13 * total


@each_gear
def test_sample_works_close_to_undercut(gear):
    sharp = dataclasses.replace(gear, pin_radius=profile.undercut_radius(gear) * (1 - 1e-9))
    outline = profile.sample(sharp, 1000)
    total = profile.length(sharp)
    assert np.abs(np.diff(outline.arc_length) - total / 1000).max() < 1e-12 * total
    assert np.all(np.diff(outline.t) > 0)


def polygon_error(gear: CycloidGear, t: np.ndarray, offset: float | None = None) -> np.ndarray:
    """Largest deviation of every chord, from 100 points of its arc."""
    ends = np.append(t, 2 * np.pi)
    inside = ends[:-1, None] + np.diff(ends)[:, None] * np.linspace(0, 1, 100)
    arcs = profile.outline(gear, inside, offset)
    chord = arcs[:, -1] - arcs[:, 0]
    across = np.stack([-chord[:, 1], chord[:, 0]], axis=1) / np.linalg.norm(chord, axis=1)[:, None]
    return np.abs(np.einsum("ijk,ik->ij", arcs - arcs[:, :1], across)).max(axis=1)


@each_gear_and_convex
@pytest.mark.parametrize("chord_error", [1e-7, 1e-6, 5e-5])
def test_chords_keep_their_sagitta_and_waste_little(gear, chord_error):
    t = profile.sagitta_parameters(gear, chord_error)
    deviation = polygon_error(gear, t)
    # 100 points of an arc see its sagitta to 1e-4.
    assert deviation.max() <= chord_error
    if t.size > 40 * gear.lobes:
        assert deviation.min() > 0.5 * chord_error


@each_gear_and_convex
def test_adaptive_outline_is_symmetric_and_the_same_in_every_lobe(gear):
    t = profile.sagitta_parameters(gear, 1e-7, offset=0.9 * gear.pin_radius)
    per_lobe, rest = divmod(t.size, gear.lobes)
    assert rest == 0
    angle = 2 * np.pi / gear.lobes
    lobes = t.reshape(gear.lobes, per_lobe) - angle * np.arange(gear.lobes)[:, None]
    assert np.abs(lobes - lobes[0]).max() < 1e-14
    assert np.abs(lobes[0, 1:] + lobes[0, :0:-1] - angle).max() < 1e-15
    assert np.abs(polygon_error(gear, t, 0.9 * gear.pin_radius)).max() <= 1e-7


def test_sampling_refuses_what_makes_no_outline():
    with pytest.raises(DesignError, match="at least 3"):
        profile.sample(PAPER, 2)
    for chord_error in (0.0, -1e-6, math.nan):
        with pytest.raises(DesignError, match="chord_error"):
            profile.sagitta_parameters(PAPER, chord_error)


def test_solve_monotone_stops_within_a_share_of_its_bracket():
    steps = []

    def square(x):
        steps.append(1)
        return x**2

    root = profile.solve_monotone(square, lambda x: 2.0 * x, 2.0, 1.0, 2.0, rtol=1e-3)
    few = len(steps)
    assert abs(root - math.sqrt(2.0)) < 1e-5
    profile.solve_monotone(square, lambda x: 2.0 * x, 2.0, 1.0, 2.0)
    assert few < len(steps) - few


def test_solve_monotone_inverts_rising_and_falling_functions_and_stays_in_its_bracket():
    x = np.linspace(-2, 2, 41)

    def cube(y):
        return y**3

    def slope(y):
        return 3 * y**2

    assert np.abs(profile.solve_monotone(cube, slope, x**3, -2, 3) - x).max() < 1e-14
    falling = profile.solve_monotone(lambda y: -cube(y), lambda y: -slope(y), -(x**3), -2, 3)
    assert np.abs(falling - x).max() < 1e-14
    assert profile.solve_monotone(cube, slope, [-50.0, 50.0], -2, 3) == pytest.approx([-2, 3], rel=1e-14)


@pytest.mark.parametrize("m", [0.0, 1e-12, 1e-3, 0.3, 0.9, 0.9999, 1.0 - 1e-12])
def test_elliptic_integrals_are_scipys(m: float) -> None:
    phi = np.concatenate([np.random.default_rng(0).uniform(-200, 200, 2000), np.pi / 2 * np.arange(-50, 51), [1e-12]])
    np.testing.assert_allclose(profile.incomplete_elliptic(phi, m), ellipeinc(phi, m), rtol=3e-15, atol=3e-14)
    assert profile.complete_elliptic(m) == pytest.approx(ellipe(m), rel=1e-14)
