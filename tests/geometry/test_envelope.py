"""The double-enveloping internal gear against 30-digit references, quadrature and the swept area itself."""

import csv
import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from cycloid_mj.base.errors import DesignError
from cycloid_mj.geometry import envelope, profile
from cycloid_mj.geometry.profile import CycloidGear

DATA = Path(__file__).parents[1] / "data"
PAPER = CycloidGear(ring_teeth=36, eccentricity=1e-3, pin_circle_radius=40.75e-3, pin_radius=2.25e-3)
SMALL = CycloidGear(ring_teeth=12, eccentricity=0.75e-3, pin_circle_radius=15e-3, pin_radius=1.5e-3)
LARGE = CycloidGear(ring_teeth=60, eccentricity=1.2e-3, pin_circle_radius=120e-3, pin_radius=3e-3)
FEW_TEETH = CycloidGear(ring_teeth=6, eccentricity=1.5e-3, pin_circle_radius=20e-3, pin_radius=4e-3)
# c N / E = 0.88 > (N-2)/N: the crank angle of a Sigma contact turns back along the flank.
STEEP = CycloidGear(ring_teeth=8, eccentricity=1.1e-3, pin_circle_radius=10e-3, pin_radius=0.6e-3)
GEARS = {"paper": PAPER, "small": SMALL, "large": LARGE, "few-teeth": FEW_TEETH, "steep": STEEP}
each_gear = pytest.mark.parametrize("gear", GEARS.values(), ids=GEARS.keys())
MM = 1e-3


def reference_ring() -> dict[str, np.ndarray]:
    """Columns of the reference ring; its header quotes a name with a comma."""
    with (DATA / "ring_points.csv").open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    columns = dict(zip(header, zip(*rows, strict=True), strict=True))
    table = {name.split("(")[0]: np.array(values, float) for name, values in columns.items() if name != "part"}
    return {"part": np.array(columns["part"]), **table}


def sigma_range(gear: CycloidGear, points: int, fraction: float = 1.0) -> np.ndarray:
    best = gear.best_phase
    return np.pi + fraction * np.linspace(best - np.pi, np.pi - best, points)


def random_gears(count: int) -> list[CycloidGear]:
    """Valid gears of any kind, up to the very limits of c N < E and of undercut."""
    rng = np.random.default_rng(7)
    gears = []
    for _ in range(count):
        teeth = int(rng.integers(3, 80))
        thin = CycloidGear(teeth, 40e-3 / teeth * rng.uniform(0.01, 0.999), 40e-3, 1e-6)
        limit = profile.undercut_radius(thin)
        gears.append(dataclasses.replace(thin, pin_radius=limit * (1 - 10 ** rng.uniform(-9, -0.1))))
    return gears


def test_ring_agrees_with_the_30_digit_reference():
    table = reference_ring()
    expected = np.stack([table["x1_mm"], table["y1_mm"]], axis=1)
    arc = table["part"] == "arc"
    assert {str(part) for part in table["part"]} == {"arc", "Sigma1", "Sigma2"}
    B = np.radians(table["B_deg"])
    # 1e-12 mm is some 100 units in the last place of the radius.
    assert np.abs(envelope.arc_points(PAPER, table["alpha_rad"][arc]) / MM - expected[arc]).max() < 1e-12
    assert np.abs(envelope.Sigma(PAPER, B[~arc]).points / MM - expected[~arc]).max() < 1e-12
    crank = envelope.Sigma(PAPER, B).crank_angle_cw
    assert np.abs(crank - table["crank_phi_rad"])[~arc].max() < 1e-13
    assert np.abs(np.exp(1j * (36 / 35 * crank - table["psi1_rad"])) + 1)[~arc].max() < 1e-13


def test_constants_of_the_paper_ring():
    junction = [[-1.98773006134969325, 39.6957565730787103], [1.98773006134969325, 39.6957565730787103]]
    assert np.abs(envelope.junction(PAPER) / MM - junction).max() < 1e-13
    assert math.degrees(envelope.largest_alpha(PAPER)) == pytest.approx(62.0596141611306429, rel=1e-14)
    assert envelope.radii(PAPER) == pytest.approx((40.5 * MM, 38.5 * MM), rel=1e-15)
    assert envelope.perimeter(PAPER) / MM == pytest.approx(303.02245, abs=5e-6)
    assert envelope.area(PAPER) / MM**2 == pytest.approx(4895.8471, abs=5e-5)
    assert envelope.tightest_radius(PAPER) / MM == pytest.approx(0.545987, abs=5e-7)
    assert envelope.Sigma(PAPER, math.radians(54.514)).radius == pytest.approx(
        envelope.tightest_radius(PAPER), rel=1e-9
    )


def turned_to_ring(gear: CycloidGear, points: np.ndarray, crank_cw: np.ndarray) -> np.ndarray:
    """Points of the gear frame in the ring frame, for clockwise crank angles, by plain vectors."""
    centre = gear.eccentricity * np.stack([np.sin(crank_cw), np.cos(crank_cw)], axis=-1)
    turn = crank_cw / gear.lobes
    x, y = points[..., 0], points[..., 1]
    return centre + np.stack([x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)], axis=-1)


def gear_radius(gear: CycloidGear, direction: np.ndarray, crank_cw: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Radius of the gear's outline in each direction; `near` is the point's t within half a lobe."""

    def polar_excess(t: np.ndarray) -> np.ndarray:
        x, y = turned_to_ring(gear, profile.outline(gear, t), crank_cw).T
        return np.arctan2(x * np.cos(direction) - y * np.sin(direction), x * np.sin(direction) + y * np.cos(direction))

    def slope(t: np.ndarray) -> np.ndarray:
        return (polar_excess(t + 1e-7) - polar_excess(t - 1e-7)) / 2e-7

    half_lobe = np.pi / gear.lobes
    t = profile.solve_monotone(polar_excess, slope, np.zeros_like(near), near - half_lobe, near + half_lobe)
    return np.linalg.norm(turned_to_ring(gear, profile.outline(gear, t), crank_cw), axis=-1)


def swept_radius(gear: CycloidGear, direction: np.ndarray, grid: int = 360, candidates: int = 2) -> np.ndarray:
    """Largest radius in each direction that the gear reaches on one orbit.

    A polygon of the gear finds candidates; the exact outline, searched around these, then decides.
    """
    cranks = np.linspace(0, 2 * np.pi, grid, endpoint=False)
    t = np.linspace(0, 2 * np.pi, 80 * gear.lobes, endpoint=False)
    outline = profile.outline(gear, t)
    radius, start = np.empty((grid, direction.size)), np.empty((grid, direction.size))
    for i, crank in enumerate(cranks):
        x, y = turned_to_ring(gear, outline, np.array(crank)).T
        polar = np.arctan2(x, y)
        radius[i] = np.interp(direction, polar, np.hypot(x, y), period=2 * np.pi)
        # The polar angle of t is t - crank/(N-1) but for a small periodic part.
        slip = np.mod(t - crank / gear.lobes - polar + np.pi, 2 * np.pi) - np.pi
        start[i] = direction + crank / gear.lobes + np.interp(direction, polar, slip, period=2 * np.pi)
    peaks = (radius >= np.roll(radius, 1, axis=0)) & (radius >= np.roll(radius, -1, axis=0))
    best = np.argsort(np.where(peaks, radius, 0.0), axis=0)[-candidates:]
    reach_of_polygon_error, step = 6, 2 * np.pi / grid

    def reach(crank: np.ndarray, crank_0: np.ndarray, t_0: np.ndarray, b: np.ndarray) -> np.ndarray:
        flat = (array.ravel() for array in np.broadcast_arrays(b, crank, t_0 + (crank - crank_0) / gear.lobes))
        return gear_radius(gear, *flat).reshape(np.broadcast_shapes(crank.shape, b.shape))

    around = step * np.linspace(-reach_of_polygon_error, reach_of_polygon_error, 2 * reach_of_polygon_error + 1)
    crank_0, t_0 = cranks[best], np.take_along_axis(start, best, axis=0)
    near = crank_0 + around[:, None, None]
    found = np.argmax(reach(near, crank_0, t_0, direction).reshape(-1, direction.size), axis=0)
    every = np.arange(direction.size)
    crank_0, t_0 = crank_0[found % candidates, every], t_0[found % candidates, every]
    low, high = (near.reshape(-1, direction.size)[found, every] + side * step for side in (-1, 1))
    ratio = (math.sqrt(5) - 1) / 2
    for _ in range(22):
        inner, outer = high - ratio * (high - low), low + ratio * (high - low)
        rising = reach(inner, crank_0, t_0, direction) < reach(outer, crank_0, t_0, direction)
        low, high = np.where(rising, inner, low), np.where(rising, high, outer)
    return reach((low + high) / 2, crank_0, t_0, direction)


def polar(points: np.ndarray) -> float:
    return math.atan2(points[0], points[1])


def ring_radius(gear: CycloidGear, direction: float) -> float:
    """Radius of the closed-form ring in one direction, by root finding along its parts."""
    pitch = 2 * math.pi / gear.ring_teeth
    folded = -abs(math.remainder(direction, pitch))
    if folded >= polar(envelope.junction(gear)[0]):
        alpha = brentq(
            lambda a: polar(envelope.arc_points(gear, a)) - folded, -envelope.largest_alpha(gear), 0, xtol=1e-15
        )
        return float(np.linalg.norm(envelope.arc_points(gear, alpha)))
    B = brentq(lambda B: polar(envelope.Sigma(gear, B).points) - folded, gear.best_phase, math.pi + 1e-6, xtol=1e-14)
    return float(np.linalg.norm(envelope.Sigma(gear, B).points))


@pytest.mark.slow
@pytest.mark.parametrize("gear", [PAPER, STEEP], ids=["paper", "steep"])
def test_ring_is_the_envelope_of_the_disc_over_one_orbit(gear):
    directions = np.random.default_rng(11).uniform(-np.pi, np.pi, 40)
    expected = np.array([ring_radius(gear, direction) for direction in directions])
    assert np.abs(swept_radius(gear, directions) - expected).max() < 1e-9 * MM


@each_gear
def test_the_gear_of_another_pin_radius_does_not_sweep_this_ring(gear):
    directions = np.random.default_rng(12).uniform(-np.pi, np.pi, 2)
    expected = np.array([ring_radius(gear, direction) for direction in directions])
    thicker = dataclasses.replace(gear, pin_radius=gear.pin_radius - 1e-8)
    assert np.all(swept_radius(thicker, directions) - expected > 5e-9)


def test_the_branch_below_best_phase_is_a_ghost_inside_the_swept_area():
    B = np.linspace(0.05, 0.9, 20) * PAPER.best_phase
    ghost = envelope.Sigma(PAPER, B).points
    ring = [ring_radius(PAPER, polar(point)) for point in ghost]
    assert np.all(np.linalg.norm(ghost, axis=1) < np.array(ring) - 1e-6)


@each_gear
def test_normals_rates_and_radius_of_sigma_follow_from_its_points(gear):
    B, h = sigma_range(gear, 101), 1e-5
    ahead, back = envelope.Sigma(gear, B + h).points, envelope.Sigma(gear, B - h).points
    rate = (ahead - back) / (2 * h)
    speed = np.linalg.norm(rate, axis=1)
    # B grows counter-clockwise, so the outward normal lies to the right of the travel.
    normal = np.stack([rate[:, 1], -rate[:, 0]], axis=1) / speed[:, None]
    assert np.abs(profile.unit(envelope.Sigma(gear, B).normal_angle) - normal).max() < 1e-7
    assert np.abs(envelope.Sigma(gear, B).arc_rate / speed - 1).max() < 1e-7
    turn = (envelope.Sigma(gear, B + h).normal_angle - envelope.Sigma(gear, B - h).normal_angle) / (2 * h)
    assert np.abs(envelope.Sigma(gear, B).radius * -turn / speed - 1).max() < 1e-7
    length = envelope.Sigma(gear, B + h).arc_length - envelope.Sigma(gear, B - h).arc_length
    assert np.abs(length / (2 * h) / speed - 1).max() < 1e-6


@each_gear
def test_arcs_and_sigma_join_in_position_and_tangent(gear):
    best, alpha = gear.best_phase, envelope.largest_alpha(gear)
    ccw, cw = envelope.junction(gear)
    turn = 2 * np.pi / gear.ring_teeth
    at_next_lobe = [cw[0] * np.cos(turn) - cw[1] * np.sin(turn), cw[0] * np.sin(turn) + cw[1] * np.cos(turn)]
    size = gear.pin_circle_radius
    assert np.abs(envelope.Sigma(gear, best).points - ccw).max() < 1e-15 * size / MM
    assert np.abs(envelope.Sigma(gear, 2 * np.pi - best).points - at_next_lobe).max() < 1e-15 * size / MM
    assert envelope.Sigma(gear, best).normal_angle == pytest.approx(alpha, abs=1e-14)
    assert envelope.Sigma(gear, 2 * np.pi - best).normal_angle == pytest.approx(-alpha - turn, abs=1e-14)
    joined = math.sqrt(gear.pin_circle_radius**2 - (gear.eccentricity * gear.ring_teeth) ** 2) - gear.pin_radius
    assert envelope.Sigma(gear, best).radius == pytest.approx(joined, rel=1e-12)
    assert np.linalg.norm(envelope.Sigma(gear, np.pi).points) == pytest.approx(envelope.radii(gear)[0], rel=1e-14)


@pytest.mark.parametrize("gear", [*GEARS.values(), *random_gears(20)])
def test_area_and_perimeter_agree_with_quadrature(gear):
    nodes, weights = np.polynomial.legendre.leggauss(60)
    edges = np.pi - (np.pi - gear.best_phase) * np.linspace(1, 0, 13) ** 3
    half = np.diff(edges)[:, None] / 2
    B = edges[:-1, None] + half * (1 + nodes)
    rate, normal = envelope.Sigma(gear, B).arc_rate, profile.unit(envelope.Sigma(gear, B).normal_angle)
    length = np.sum(half * rate * weights)
    sector = np.sum(half * rate * np.sum(envelope.Sigma(gear, B).points * normal, axis=-1) * weights) / 2
    alpha, E, rho = envelope.largest_alpha(gear), gear.pin_circle_radius, gear.pin_radius
    arc_sector = rho * (E * math.sin(alpha) - rho * alpha) / 2
    assert envelope.perimeter(gear) == pytest.approx(2 * gear.ring_teeth * (rho * alpha + length), rel=1e-11)
    assert envelope.area(gear) == pytest.approx(2 * gear.ring_teeth * (arc_sector + sector), rel=1e-11)


def test_a_gear_without_undercut_has_a_ring_without_cusps():
    for gear in random_gears(300):
        B = sigma_range(gear, 101)
        gear_curvature = profile.curvature(gear, -B / gear.lobes)
        assert gear_curvature.min() > 0
        # Rounding near the limits costs up to 1e-9 relative; where the contact is osculating, both are equal.
        assert np.all(envelope.Sigma(gear, B).radius * gear_curvature > 1 - 1e-9)
        assert envelope.tightest_radius(gear) > 0


@pytest.mark.parametrize("gear", [*GEARS.values(), *random_gears(20)])
def test_tightest_radius_is_the_smallest_along_sigma(gear):
    radii = envelope.Sigma(gear, np.linspace(gear.best_phase, np.pi, 100_001)).radius
    assert envelope.tightest_radius(gear) == pytest.approx(radii.min(), rel=1e-7)
    assert envelope.tightest_radius(gear) <= radii.min() * (1 + 1e-12)


def test_undercut_gears_have_no_ring():
    undercut = dataclasses.replace(PAPER, pin_radius=2.61e-3)
    with pytest.raises(DesignError, match="is undercut"):
        envelope.require_envelope(undercut)
    for build in (
        lambda: envelope.sample_ring(undercut, 100),
        lambda: envelope.sample_ring_by_sagitta(undercut, 1e-6),
        lambda: envelope.sigma_contacts(undercut, 0.0),
    ):
        with pytest.raises(DesignError, match="Reduce pin_radius"):
            build()
    envelope.require_envelope(PAPER)


@each_gear
@pytest.mark.parametrize("points", [3, 901])
def test_ring_samples_are_equally_spaced_and_lie_on_their_parts(gear, points):
    ring = envelope.sample_ring(gear, points)
    total = envelope.perimeter(gear)
    assert np.abs(ring.arc_length - np.arange(points) * total / points).max() < 1e-13 * total
    assert ring.points[0] == pytest.approx([0, envelope.radii(gear)[1]], abs=1e-15)
    assert_ring_is_consistent(gear, ring)


def assert_ring_is_consistent(gear: CycloidGear, ring: envelope.RingOutline) -> None:
    """Each point has the radius of its direction, each normal points into the bore, parts have their curvature."""
    some = np.linspace(0, len(ring.points) - 1, 40).astype(int)
    expected = [ring_radius(gear, polar(point)) for point in ring.points[some]]
    assert np.linalg.norm(ring.points[some], axis=1) == pytest.approx(expected, rel=1e-13)
    assert np.all(np.sum(ring.points * ring.normals, axis=1) < 0)
    assert np.abs(np.linalg.norm(ring.normals, axis=1) - 1).max() < 1e-15
    on_arc = ring.part == "arc"
    centres = ring.points[on_arc] - gear.pin_radius * ring.normals[on_arc]
    assert np.linalg.norm(centres, axis=1) == pytest.approx(gear.pin_circle_radius, rel=1e-13)
    assert np.all(ring.curvature[on_arc] == 1 / gear.pin_radius)
    assert np.all(ring.curvature[~on_arc] < 0)


def errors_of_ring_differences(points_per_lobe: int) -> np.ndarray:
    """Largest errors of central differences: normal within the parts, curvature within them, normal at junctions."""
    ring = envelope.sample_ring(PAPER, 36 * points_per_lobe)
    step = envelope.perimeter(PAPER) / len(ring.points)
    ahead, back = np.roll(ring.points, -1, axis=0), np.roll(ring.points, 1, axis=0)
    tangent = (ahead - back) / (2 * step)
    # Clockwise travel: the normal into the bore is to the right of the tangent.
    normal = np.abs(np.stack([tangent[:, 1], -tangent[:, 0]], axis=1) - ring.normals).max(axis=1)
    bend = np.abs(-np.sum((ahead - 2 * ring.points + back) * ring.normals, axis=1) / step**2 - ring.curvature)
    within = (ring.part == np.roll(ring.part, 1)) & (ring.part == np.roll(ring.part, -1))
    return np.array([normal[within].max(), bend[within].max(), normal[~within].max() / step])


def test_normals_and_curvature_of_the_sampled_ring_are_limits_of_its_differences():
    coarse, fine = errors_of_ring_differences(500), errors_of_ring_differences(1000)
    order = np.log2(coarse / fine)
    assert order[:2] == pytest.approx([2, 2], abs=0.1)
    # Where the curvature jumps but the tangent does not, the error is at most a quarter of jump times step.
    jump = 1 / PAPER.pin_radius + 1 / envelope.Sigma(PAPER, PAPER.best_phase).radius
    assert fine[2] <= jump / 4 * (1 + 1e-3)


def test_sampled_ring_has_the_area_and_the_parts_of_the_closed_form():
    ring = envelope.sample_ring(PAPER, 36 * 1000)
    step = envelope.perimeter(PAPER) / len(ring.points)
    x, y = ring.points.T
    area = np.sum(y * np.roll(x, -1) - x * np.roll(y, -1)) / 2
    assert area == pytest.approx(envelope.area(PAPER), rel=1e-6)
    parts, counts = np.unique(ring.part, return_counts=True)
    assert list(parts) == ["arc", "sigma1", "sigma2"]
    arc_length = 72 * PAPER.pin_radius * envelope.largest_alpha(PAPER)
    assert counts[0] * step == pytest.approx(arc_length, abs=72 * step)
    assert abs(counts[1] - counts[2]) <= 36
    # Sigma(1) lies counter-clockwise of its lobe, Sigma(2) clockwise.
    beside_lobe = np.vectorize(math.remainder)(np.arctan2(x, y), np.pi / 18)
    middle = np.pi / 36 - np.abs(beside_lobe) < 1e-9
    assert np.all((beside_lobe < 0) | middle, where=ring.part == "sigma1")
    assert np.all((beside_lobe > 0) | middle, where=ring.part == "sigma2")


@each_gear
@pytest.mark.parametrize("chord_error", [1e-7, 2e-6])
def test_ring_chords_keep_their_sagitta(gear, chord_error):
    ring = envelope.sample_ring_by_sagitta(gear, chord_error)
    per_lobe, rest = divmod(len(ring.points), gear.ring_teeth)
    assert rest == 0
    x, y = ring.points[: per_lobe + 1].T
    for i in range(per_lobe // 2 + 1):
        chord = np.array([x[i + 1] - x[i], y[i + 1] - y[i]])
        across = np.array([-chord[1], chord[0]]) / np.linalg.norm(chord)
        for share in (0.25, 0.5, 0.75):
            at = np.array([x[i], y[i]]) + share * chord
            radial = at / np.linalg.norm(at)
            deviation = (ring_radius(gear, polar(at)) - np.linalg.norm(at)) * abs(radial @ across)
            # A radial look at a slanted chord sees its sagitta to first order only.
            assert abs(deviation) <= 1.02 * chord_error
    lengths = ring.arc_length.reshape(gear.ring_teeth, per_lobe)
    pitch = envelope.perimeter(gear) / gear.ring_teeth
    assert np.all(np.diff(ring.arc_length) > 0)
    assert np.abs(lengths - lengths[0] - pitch * np.arange(gear.ring_teeth)[:, None]).max() < 1e-15
    assert np.abs(lengths[0, 1:] + lengths[0, :0:-1] - pitch).max() < 1e-16
    corner = envelope.junction(gear)[1]
    assert np.abs(ring.points - corner).max(axis=1).min() < 1e-15
    assert_ring_is_consistent(gear, ring)


def test_sampling_refuses_what_makes_no_ring():
    with pytest.raises(DesignError, match="at least 3"):
        envelope.sample_ring(PAPER, 2)
    with pytest.raises(DesignError, match="chord_error"):
        envelope.sample_ring_by_sagitta(PAPER, 0.0)


def assert_gear_touches(gear: CycloidGear, contacts: envelope.RingContacts, crank_angle: float) -> None:
    """The gear's own points at `t`, placed by plain vectors, are the contacts, with opposite normals."""
    crank_cw = np.array(-crank_angle)
    placed = turned_to_ring(gear, profile.outline(gear, contacts.t), crank_cw)
    assert np.abs(placed - contacts.points).max() < 1e-14 * gear.pin_circle_radius / MM
    origin = turned_to_ring(gear, np.zeros(2), crank_cw)
    opposite = turned_to_ring(gear, profile.normals(gear, contacts.t), crank_cw) - origin
    assert np.abs(opposite + contacts.normals).max() < 1e-12
    assert np.abs(np.exp(1j * profile.phase(gear, contacts.t)) - np.exp(1j * contacts.B)).max() < 1e-12
    assert contacts.relative_curvature.min() > -1e-6 / gear.pin_radius


@each_gear
def test_contacts_are_all_the_solutions_of_the_meshing_equation(gear):
    """Brute force: sign changes of (T - pitch point) . T', which knows nothing of the two factors of Eq. 11."""
    t = np.linspace(0, 2 * np.pi, 3000 * gear.lobes, endpoint=False) + 1e-5
    first, _ = profile.trochoid_derivatives(gear, t)
    positions = profile.trochoid(gear, t)
    for crank_angle in np.random.default_rng(5).uniform(-40, 40, 6):
        arcs, sigma = envelope.arc_contacts(gear, crank_angle), envelope.sigma_contacts(gear, crank_angle)
        assert len(arcs.B) == gear.ring_teeth
        assert_gear_touches(gear, arcs, crank_angle)
        if len(sigma.B):
            assert_gear_touches(gear, sigma, crank_angle)
        pitch_point = (
            gear.eccentricity * gear.lobes * profile.unit(-crank_angle * gear.ring_teeth / (gear.ring_teeth - 1))
        )
        meshing = np.sum((positions - pitch_point) * first, axis=1)
        roots = t[np.signbit(meshing) != np.signbit(np.roll(meshing, -1))]
        expected = np.mod(np.concatenate([arcs.t, sigma.t]), 2 * np.pi)
        spacing = t[1] - t[0]
        apart = np.abs(np.angle(np.exp(1j * (roots[:, None] - expected))))
        assert apart.min(axis=0).max() <= 1.01 * spacing
        unexplained = roots[apart.min(axis=1) > 1.01 * spacing]
        phases = np.abs(np.angle(np.exp(1j * profile.phase(gear, unexplained))))
        assert np.all(phases < gear.best_phase + gear.lobes * spacing)


@pytest.mark.slow
def test_counts_of_contacts_of_the_paper_ring():
    cranks = np.linspace(0, 2 * np.pi, 901)[:-1] + 1e-4
    found = [envelope.sigma_contacts(PAPER, crank) for crank in cranks]
    counts = np.array([len(contacts.B) for contacts in found])
    assert set(counts) == {4, 5}
    mean = 36 * PAPER.best_phase / np.pi - 1
    assert mean == pytest.approx(4.588, abs=5e-4)
    # Each of the 36 flanks is in touch over one stretch of the crank, known to two of the 900 steps.
    assert counts.mean() == pytest.approx(mean, abs=2 * 36 / 900)
    aside = [
        np.angle(np.exp(1j * (np.arctan2(contacts.points[:, 0], contacts.points[:, 1]) + crank)))
        for contacts, crank in zip(found, cranks, strict=True)
    ]
    limit = PAPER.best_phase - math.radians(2.86664135902833452)
    assert math.degrees(limit) == pytest.approx(25.07, abs=5e-3)
    assert np.abs(np.concatenate(aside)).max() == pytest.approx(limit, abs=2 * np.pi / 900)
    assert np.abs(np.concatenate(aside)).max() < limit


@each_gear
def test_contact_condition_of_the_paper(gear):
    """N/(N-1) B + A(B) + psi_1 = 0 modulo 2 pi, where psi_1 is N/(N-1) of the crank angle less half a turn."""
    N, c, E, _ = gear.symbols
    B = sigma_range(gear, 101)
    A = 2 * np.arctan2(E * np.sin(B), c * N - E * np.cos(B))
    psi_1 = N / (N - 1) * envelope.Sigma(gear, B).crank_angle_cw - np.pi
    assert np.abs(np.exp(1j * (N / (N - 1) * B + A + psi_1)) - 1).max() < 1e-13
    # The other sign of A, a plausible slip, does not close.
    assert np.abs(np.exp(1j * (N / (N - 1) * B - A + psi_1)) - 1).max() > 0.1


def test_steep_design_is_beyond_the_monotone_range_and_the_others_are_not():
    for name, gear in GEARS.items():
        limit = (gear.ring_teeth - 2) / gear.ring_teeth
        rising = np.diff(envelope.Sigma(gear, sigma_range(gear, 2001)).crank_angle_cw) > 0
        steep = gear.eccentricity * gear.ring_teeth / gear.pin_circle_radius > limit
        assert steep == (name == "steep") == (np.any(rising) and not np.all(rising))
