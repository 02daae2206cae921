"""Contact lines: their number and place, relative curvature against the gap between the curves, Hertz's pressure."""

import math

import numpy as np
import pytest

from cycloid_mj.base.errors import DesignError
from cycloid_mj.geometry import envelope, profile
from cycloid_mj.geometry.contact_lines import contact_lines, mesh_period, peak_pressure
from cycloid_mj.geometry.ideal_loads import contact_modulus
from cycloid_mj.geometry.profile import CycloidGear, unit

PAPER = CycloidGear(36, 1e-3, 40.75e-3, 2.25e-3)
OTHER = CycloidGear(12, 1.6e-3, 30e-3, 3e-3)


def test_pins_and_arcs_have_the_same_lines_and_sigma_adds_its_own():
    """Physics: 36 lines on the arcs and on average 4.588 on Sigma over a mesh period; 200 angles find it to 0.5 %."""
    angles = mesh_period(PAPER, 200)
    pins, ring = (contact_lines(PAPER, kind, angles) for kind in ("pin", "nonpin"))
    arcs = ring.part == "arc"
    assert set(pins.part) == {"pin"}
    for name in ("crank_angle", "tooth", "phase", "points", "relative_curvature"):
        np.testing.assert_array_equal(getattr(pins, name), getattr(ring, name)[arcs])
    assert arcs.sum() == 200 * 36
    assert (~arcs).sum() / 200 == pytest.approx(4.588, abs=0.01)
    assert (np.diff(ring.crank_angle) >= 0).all()


@pytest.mark.parametrize("gear", [PAPER, OTHER])
def test_contact_lines_lie_on_their_part_and_tooth(gear):
    """Counter-clockwise of a lobe's middle is Sigma(1), clockwise Sigma(2), beyond the arc's ends on both sides."""
    lines = contact_lines(gear, "nonpin", mesh_period(gear, 40))
    angle = np.arctan2(lines.points[:, 0], lines.points[:, 1]) - 2 * np.pi * lines.tooth / gear.ring_teeth
    angle = (angle + np.pi) % (2 * np.pi) - np.pi
    end = math.atan2(*envelope.junction(gear)[1])
    assert np.abs(angle[lines.part == "arc"]).max() <= end + 1e-12
    for part, sign in (("sigma1", -1), ("sigma2", 1)):
        outward = sign * angle[lines.part == part]
        assert outward.min() >= end - 1e-12
        assert outward.max() <= np.pi / gear.ring_teeth + 1e-12


@pytest.mark.parametrize("gear", [PAPER, OTHER])
def test_relative_curvature_is_that_of_the_gap(gear):
    """The gap along the ring is kappa s^2/2 about a line: second differences over 2 um, the gear's foot by Newton.

    The third order drops out; the fourth leaves kappa'' s^2/12, below 1e-3 of the largest curvature.
    """
    crank = 0.1
    lines = contact_lines(gear, "nonpin", crank)
    arcs, roots = envelope.arc_contacts(gear, crank), envelope.sigma_contacts(gear, crank)
    normals = np.concatenate([arcs.normals, roots.normals])
    bends = np.concatenate([np.full(gear.ring_teeth, 1 / gear.pin_radius), -1 / envelope.Sigma(gear, roots.B).radius])
    step = 2e-6
    found = []
    for point, normal, bend in zip(lines.points, normals, bends, strict=True):
        tangent = np.array([normal[1], -normal[0]])
        on_ring = [point + s * tangent - 0.5 * bend * s**2 * normal for s in (-step, 0.0, step)]
        before, at, after = (_gap(gear, place, crank) for place in on_ring)
        assert abs(at) < 1e-15
        found.append((before - 2 * at + after) / step**2)
    assert np.abs(found - lines.relative_curvature).max() < 1e-3 * lines.relative_curvature.max()
    assert lines.relative_curvature.min() >= 0.0


def _gap(gear: CycloidGear, point: np.ndarray, crank: float) -> float:
    """Distance of a point of the ring's frame from the gear, by Newton's method on the foot of the normal."""
    turn, c = crank / gear.lobes, gear.eccentricity
    x, y = point - c * np.array([-math.sin(crank), math.cos(crank)])
    local = np.array([math.cos(turn) * x - math.sin(turn) * y, math.sin(turn) * x + math.cos(turn) * y])
    coarse = np.linspace(0, 2 * np.pi, 4_001)
    t = coarse[np.argmin(np.linalg.norm(profile.outline(gear, coarse) - local, axis=1))]
    for _ in range(12):
        normal = profile.normals(gear, t)
        tangent = np.array([normal[1], -normal[0]])
        away = local - profile.outline(gear, t)
        t += (away @ tangent) / (profile.arc_rate(gear, t) * (1 + profile.curvature(gear, t) * (away @ normal)))
    return float((local - profile.outline(gear, t)) @ profile.normals(gear, t))


def test_flanks_are_less_curved_than_pins_at_every_phase():
    """The paper's argument: where both touch at the same phase, Sigma's line is the flatter one."""
    lines = contact_lines(PAPER, "nonpin", mesh_period(PAPER, 100))
    arcs = lines.part == "arc"
    order = np.argsort(lines.phase[arcs])
    of_pins = np.interp(lines.phase[~arcs], lines.phase[arcs][order], lines.relative_curvature[arcs][order])
    assert (lines.relative_curvature[~arcs] < 0.5 * of_pins).all()
    assert lines.relative_curvature[arcs].max() == pytest.approx(1e3 * (1 / 0.357950 + 1 / 2.25), rel=1e-5)


def test_curvature_of_sigma_tends_to_zero_at_the_junction():
    """At B0 the normals of gear and flank turn at the same rate."""
    low = PAPER.best_phase
    cranks = -envelope.Sigma(PAPER, low + np.array([1e-3, 1e-5])).crank_angle_cw
    flattest = [contact_lines(PAPER, "nonpin", crank).relative_curvature.min() for crank in cranks]
    assert flattest[1] < 0.02 * flattest[0] < 1.0


def test_pressure_is_the_textbook_formula():
    """0.418 sqrt(F E kappa / L) for steel on steel with a Poisson's ratio of 0.3; 0.418 is rounded."""
    lines = contact_lines(PAPER, "pin", 0.3)
    force, length, young = 100.0, 10e-3, 210e9
    found = peak_pressure(lines, force, length, contact_modulus(young, 0.3))
    assert found == pytest.approx(0.418 * np.sqrt(force * young * lines.relative_curvature / length), rel=1e-3)


def test_mesh_period_is_divided_equally():
    assert mesh_period(PAPER, 4) == pytest.approx(np.radians([0.0, 2.5, 5.0, 7.5]))


def test_lines_repeat_after_a_mesh_period():
    """The next tooth takes the place of the last one."""
    first = contact_lines(PAPER, "nonpin", 0.05)
    later = contact_lines(PAPER, "nonpin", 0.05 + 2 * np.pi / 36)
    assert np.sort(later.relative_curvature) == pytest.approx(np.sort(first.relative_curvature), rel=1e-9)
    assert unit(0.0) @ unit(first.phase[0] - 0.05) == pytest.approx(1.0)


def test_an_undercut_gear_is_refused():
    with pytest.raises(DesignError, match="undercut"):
        contact_lines(CycloidGear(36, 1e-3, 40.75e-3, 2.7e-3), "pin", 0.0)
