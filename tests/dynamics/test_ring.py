"""Contact of the gear with the internal gear: against brute force, through junctions and roots, without steps."""

from dataclasses import replace

import numpy as np
import pytest
from ring_rig import Rig, compare_gaps
from scipy.spatial import cKDTree

from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.contact.gap import Trochoid
from cycloid_mj.dynamics.contact.ring import ideal_root_phase, is_monotone, offset_root
from cycloid_mj.dynamics.contact.teeth import DEFLECTION
from cycloid_mj.geometry import envelope, profile
from cycloid_mj.geometry.profile import CycloidGear, unit
from cycloid_mj.parts.gear import tooth_profile
from cycloid_mj.reducer import Reducer

DESIGNS = {
    "paper": (),
    "small": (
        "ring.teeth=12",
        "ring.pin_circle_radius_mm=30.0",
        "ring.pin_radius_mm=3.0",
        "gear.bore_radius_mm=6.0",
        "output.pin_circle_radius_mm=15.0",
        "output.pin_radius_mm=2.0",
        "output.hole_radius_mm=3.0",
        "shaft.radius_mm=4.0",
    ),
    "steep": (
        "ring.teeth=8",
        "gear.eccentricity_mm=4.2",
        "ring.pin_radius_mm=4.5",
        "gear.bore_radius_mm=10.0",
        "output.pin_circle_radius_mm=20.0",
        "output.pin_radius_mm=2.0",
        "output.hole_radius_mm=6.2",
        "shaft.radius_mm=4.0",
        "output.pins=4",
        "housing.outer_radius_mm=60.0",
    ),
}


def nonpin(*changes: str) -> Design:
    return override(PRESETS["nonpin"], changes)


@pytest.fixture(scope="module")
def rig() -> Rig:
    return Rig(nonpin("clearance.tooth_um=20.0"), margin=1e-4)


@pytest.mark.parametrize("crank", [0.0, 0.4, 1.7, 5.9])
def test_ideal_contacts_are_at_the_points_of_the_envelope(crank: float) -> None:
    """36 arcs and 4 or 5 lines on Sigma, with the envelope's own points and normals."""
    rig = Rig(nonpin(), margin=1e-5)
    found = rig.contacts(crank)
    arcs, roots = envelope.arc_contacts(rig.gear, crank), envelope.sigma_contacts(rig.gear, crank)
    on_arc = np.abs(arcs.B % (2 * np.pi) - np.pi) > np.pi - 10.0  # all of them
    assert on_arc.all()
    assert len(roots.lobe) in (4, 5)
    assert len(found) == 36 + len(roots.lobe)
    expected = np.concatenate([arcs.points, roots.points])
    distance, nearest = cKDTree(found[:, 2:4]).query(expected)
    assert distance.max() < 0.6e-6  # half the clearance of 1 um lies between surface and contact point
    assert len(set(nearest)) == len(found)
    outward = -np.concatenate([arcs.normals, roots.normals])
    assert np.abs(found[nearest, 4:] - outward).max() < 2e-3
    assert found[:, 1] == pytest.approx(np.full(len(found), 1e-6), abs=1e-12)


@pytest.mark.parametrize("name", ["paper", "small"])
def test_ideal_phase_inverts_the_envelope(name: str) -> None:
    gear = tooth_profile(nonpin(*DESIGNS[name]))
    ring = Trochoid(gear.pin_circle_radius, gear.eccentricity, float(gear.ring_teeth))
    assert is_monotone(ring)
    low = gear.best_phase
    for crank in np.linspace(-low + 1e-6, low - 2 * np.pi / gear.ring_teeth - 1e-6, 101):
        phase = ideal_root_phase(crank, low, ring)
        assert envelope.Sigma(gear, phase).crank_angle_cw == pytest.approx(crank, abs=1e-5)


@pytest.mark.parametrize("name", list(DESIGNS))
def test_offset_root_is_the_envelope_without_pin_radius(name: str) -> None:
    gear = tooth_profile(nonpin(*DESIGNS[name]))
    bare = replace(gear, pin_radius=1e-15)
    ring = Trochoid(gear.pin_circle_radius, gear.eccentricity, float(gear.ring_teeth))
    low = gear.best_phase
    for phase in np.linspace(low, 2 * np.pi - low, 50):
        x, y, psi, rate, curvature = offset_root(phase, ring)
        assert [x, y] == pytest.approx(envelope.Sigma(bare, phase).points, abs=1e-14)
        assert psi == pytest.approx(envelope.Sigma(gear, phase).normal_angle, abs=1e-14)
        assert rate == pytest.approx(envelope.Sigma(bare, phase).arc_rate, rel=1e-11)
        assert curvature == pytest.approx(1.0 / envelope.Sigma(bare, phase).radius, rel=1e-9)


class BruteForce:
    """Gap of ring points to a finely sampled gear, by the nearest sample's tangent and curvature."""

    def __init__(self, gear: CycloidGear, offset: float, samples: int = 600_000) -> None:
        t = np.linspace(0.0, 2.0 * np.pi, samples, endpoint=False)
        self.points = profile.outline(gear, t, offset)
        self.normals = profile.normals(gear, t)
        self.curvature = profile.curvature(gear, t, offset)
        self.tree = cKDTree(self.points)

    def gap(self, points: np.ndarray) -> np.ndarray:
        _, k = self.tree.query(points)
        away = points - self.points[k]
        normal = np.sum(away * self.normals[k], axis=1)
        along2 = np.sum(away**2, axis=1) - normal**2
        return normal + 0.5 * self.curvature[k] * along2


@pytest.mark.slow
def test_gap_equals_brute_force_in_random_poses(rig: Rig) -> None:
    brute = BruteForce(rig.gear, rig.gear.pin_radius + rig.design.clearance.tooth)
    assert compare_gaps(rig, brute.gap, poses=100, reach=6e-5, tolerance=1e-9) > 8


@pytest.mark.slow
@pytest.mark.parametrize("name", ["paper", "steep"])
def test_no_contact_is_missed_in_a_sweep(name: str) -> None:
    """The smallest gap of the whole ring is continuous while a shifted gear passes junctions and roots."""
    rig = Rig(nonpin("clearance.tooth_um=20.0", *DESIGNS[name]), margin=1e-4)
    shift, turn = np.array([2.5e-6, -3e-6]), 2e-5
    pitch = 2 * np.pi / rig.design.ring.teeth
    cranks = np.linspace(0.3, 0.3 + 1.3 * pitch, 600 if name == "paper" else 250)
    smallest = np.array([rig.contacts(crank, shift, turn)[:, 1].min() for crank in cranks])
    steps = np.abs(np.diff(smallest))
    assert steps.max() < 1.5 * 4e-6 * (cranks[1] - cranks[0]) * rig.design.ring.teeth


def resultant(rig: Rig, crank: float) -> np.ndarray:
    """Sum of penetrations along their normals of a gear turned against the ring: force per unit of stiffness [m]."""
    found = rig.contacts(crank, (0.0, 0.0), 6e-5)
    depth = np.maximum(-found[:, 1], 0.0)
    return np.concatenate([depth @ found[:, 4:], [depth.sum()]])


def largest_step(rig: Rig) -> float:
    """Largest jump of the resultant between neighbouring crank angles, as a share of its size."""
    cranks = np.linspace(0.2, 0.2 + 2 * np.pi / 36, 3000)
    forces = np.array([resultant(rig, crank) for crank in cranks])
    return float(np.abs(np.diff(forces, axis=0)).max() / np.linalg.norm(forces[:, :2], axis=1).mean())


@pytest.mark.slow
def test_no_step_in_the_force_when_lines_merge_or_part() -> None:
    """An arc and a flank line that merge share one stiffness; without the sharing the force jumps."""
    shared = Rig(nonpin(), margin=0.0)
    apart = Rig(nonpin(), margin=0.0)
    apart.model.geom_user[apart.model.geom("teeth").id, DEFLECTION] = 0.0
    assert largest_step(shared) < 0.01
    assert largest_step(apart) > 0.1


def test_contacts_shrink_with_the_normal_curvature(rig: Rig) -> None:
    """The stiffness factor of a lobe's contact is the law's at the local relative curvature."""

    design = nonpin()
    loaded, uniform = Rig(design, 0.0), Rig(override(design, ['contact.stiffness_law="uniform"']), 0.0)
    law = Reducer(design).contacts.teeth.curvature_law
    shift = 3e-6 * unit(2.0)
    local, plain = loaded.contacts(0.0, shift), uniform.contacts(0.0, shift)
    arcs = envelope.arc_contacts(loaded.gear, 0.0)
    checked = 0
    for lobe in set(local[:, 0].astype(int)):
        one, other = local[local[:, 0] == lobe], plain[plain[:, 0] == lobe]
        if len(one) == 1 and np.hypot(*(one[0, 2:4] - arcs.points[lobe])) < 1e-5:
            expected = law.factor(arcs.relative_curvature[lobe])
            assert one[0, 1] / other[0, 1] == pytest.approx(expected, rel=2e-3)
            checked += 1
    assert checked > 8


def test_roots_passed_over_have_no_contact() -> None:
    """Without a margin the collider looks only at roots that may touch: it finds all that a wide margin shows."""
    design = nonpin()
    narrow, wide = Rig(design, margin=0.0), Rig(design, margin=5e-6)
    for one in (narrow, wide):  # an open arc within the margin would share its patch with the root
        one.model.geom_user[one.model.geom("teeth").id, DEFLECTION] = 0.0
    rng = np.random.default_rng(11)
    touching = 0
    for _ in range(400):
        crank, angle = rng.uniform(0.0, 2 * np.pi, 2)
        shift, turn = rng.uniform(0.0, 3e-6) * unit(angle), rng.uniform(-5e-5, 5e-5)
        found, expected = narrow.contacts(crank, shift, turn), wide.contacts(crank, shift, turn)
        expected = expected[expected[:, 1] < 0.0]
        assert len(found) == len(expected)
        np.testing.assert_allclose(np.sort(found[:, 1]), np.sort(expected[:, 1]), rtol=0.0, atol=1e-12)
        touching += len(found)
    assert touching > 1000
