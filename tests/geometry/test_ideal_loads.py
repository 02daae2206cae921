"""Load sharing against equilibrium and measured ranges, Hertz against its stress field, published cases, Palmgren."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import lsq_linear, minimize_scalar

from cycloid_mj.base.errors import DesignError
from cycloid_mj.design import PRESETS
from cycloid_mj.geometry import envelope, ideal_loads, kinematics, profile
from cycloid_mj.geometry.profile import CycloidGear
from cycloid_mj.reducer import Reducer

PAPER = CycloidGear(ring_teeth=36, eccentricity=1e-3, pin_circle_radius=40.75e-3, pin_radius=2.25e-3)
SMALL = CycloidGear(ring_teeth=12, eccentricity=0.75e-3, pin_circle_radius=15e-3, pin_radius=1.5e-3)
FEW_TEETH = CycloidGear(ring_teeth=6, eccentricity=1.5e-3, pin_circle_radius=20e-3, pin_radius=4e-3)
each_gear = pytest.mark.parametrize("gear", [PAPER, SMALL, FEW_TEETH], ids=["paper", "small", "few-teeth"])
TORQUE = 36.68
CRANKS = np.linspace(0, 2 * np.pi, 721)


@pytest.mark.parametrize(("young", "poisson", "radius"), [(210e9, 0.28, 2.25e-3), (206e9, 0.3, 1e-3), (3e9, 0.4, 5e-3)])
def test_a_line_contact_deflects_as_the_strain_along_its_axis(young: float, poisson: float, radius: float) -> None:
    """Johnson 1985, Contact Mechanics, section 5.6: a cylinder pressed by P per length from both ends of a diameter.

    Along that, z from a contact of half width a: sigma_x = P/pi (1/R - 2(a^2 + 2 z^2)/(a^2 sqrt(a^2 + z^2)) + 4 z/a^2)
    and sigma_z = P/pi (1/R - 2/(2 R - z) - 2/sqrt(a^2 + z^2)); in plane strain their strain, summed up to the axis, is
    the approach of one body, P (1 - nu^2)/(pi E) (2 ln(4 R/a) - 1) for a much smaller than R. Both bodies are alike.
    """
    force, length = 117.0, 10e-3
    P, elastic = force / length, (1.0 - poisson**2) / young
    a = math.sqrt(8.0 * P * radius * elastic / math.pi)  # on a flat of the same material: 4 P R/(pi E*)

    def strain(z: float) -> float:
        x = 1.0 / radius - 2.0 * (a**2 + 2.0 * z**2) / (a**2 * math.hypot(a, z)) + 4.0 * z / a**2
        along = 1.0 / radius - 2.0 / (2.0 * radius - z) - 2.0 / math.hypot(a, z)
        return elastic * P / math.pi * (along - poisson / (1.0 - poisson) * x)

    approach = -2.0 * quad(strain, 0.0, radius, points=[a, 10.0 * a], limit=200)[0]
    closed = 2.0 * P * elastic / math.pi * (2.0 * math.log(4.0 * radius / a) - 1.0)
    assert closed == pytest.approx(approach, rel=3.0 * (a / radius) ** 2 + 1e-6)
    modulus = ideal_loads.contact_modulus(young, poisson)
    stiffness = ideal_loads.line_contact_stiffness(force, length, modulus, radius, 1.0 / radius)
    assert stiffness == pytest.approx(force / closed, rel=1e-12)
    if (young, radius) == (210e9, 2.25e-3):  # the pins of the paper's drive at its rated torque
        assert stiffness == pytest.approx(3.105e8, rel=1e-3)


def test_teeth_are_as_stiff_as_that_line_contact() -> None:
    """117 N on 10 mm of steel, pin on a flat: what the design says of itself."""
    design = PRESETS["pin"].but(working_force={"pin_gear": 117.0})
    assert Reducer(design).contacts["pin_gear"].stiffness == pytest.approx(3.105e8, rel=1e-3)


@pytest.mark.parametrize("sign", [1, -1])
def test_paper_design_at_its_theoretical_torque(sign):
    shared = ideal_loads.ideal_load_sharing(PAPER, sign * TORQUE, CRANKS)
    largest = shared.forces.max(axis=1)
    loaded = np.count_nonzero(shared.forces > 1e-6 * largest[:, None], axis=1)
    assert set(loaded) == {17, 18}
    assert largest.min() == pytest.approx(115.8, abs=0.05)
    assert largest.max() == pytest.approx(117.0, abs=0.05)
    assert shared.eccentric_tangential == pytest.approx(sign * TORQUE / 0.035, rel=1e-12)
    # The eccentric pulls the gear inwards.
    assert shared.eccentric_radial.max() == pytest.approx(-484, abs=0.5)
    assert shared.eccentric_radial.min() == pytest.approx(-512, abs=0.5)


@pytest.mark.slow
def test_ring_of_the_paper_design_shares_the_load_with_sigma():
    one_pitch = np.linspace(0, np.pi / 18, 401)
    shared = [ideal_loads.ideal_internal_gear_load_sharing(PAPER, TORQUE, crank) for crank in one_pitch]
    largest = np.array([load.forces.max() for load in shared])
    # A range from a coarser study: the force jumps as Sigma contacts come and go, so its ends move with the grid.
    assert largest.min() == pytest.approx(92.5, abs=0.3)
    assert largest.max() == pytest.approx(101.1, abs=0.3)
    pins = ideal_loads.ideal_load_sharing(PAPER, TORQUE, one_pitch).forces.max(axis=1)
    assert np.all(largest < pins)


@each_gear
@pytest.mark.parametrize("torque", [7.0, -7.0])
def test_pins_and_eccentric_hold_the_gear_in_equilibrium(gear, torque):
    """Forces and moments as plain vectors at the contact points; the output load is the given couple."""
    for crank in (0.0, 0.4, -2.0, 11.0):
        for shared, contacts in [
            (ideal_loads.ideal_load_sharing(gear, torque, crank), [envelope.arc_contacts(gear, crank)]),
            (
                ideal_loads.ideal_internal_gear_load_sharing(gear, torque, crank),
                [envelope.arc_contacts(gear, crank), envelope.sigma_contacts(gear, crank)],
            ),
        ]:
            centre = kinematics.gear_centre(gear, crank)
            pushes = shared.forces[:, None] * np.concatenate([part.normals for part in contacts])
            levers = np.concatenate([part.points for part in contacts]) - centre
            moment = np.sum(levers[:, 0] * pushes[:, 1] - levers[:, 1] * pushes[:, 0])
            assert moment == pytest.approx(-torque, rel=1e-12)
            outward, forward = centre / gear.eccentricity, np.array([-centre[1], centre[0]]) / gear.eccentricity
            eccentric = shared.eccentric_radial * outward + shared.eccentric_tangential * forward
            assert np.abs(pushes.sum(axis=0) + eccentric).max() < 1e-9 * shared.forces.sum()
            # Power: the crank's moment on its eccentric is the load's, divided by the ratio.
            assert shared.eccentric_tangential * gear.eccentricity == pytest.approx(torque / gear.lobes, rel=1e-12)


def test_the_load_that_opposes_the_gear_presses_on_pins_ahead_of_the_crank():
    crank = 0.3
    shared = ideal_loads.ideal_load_sharing(PAPER, TORQUE, crank)
    ahead = np.mod(-profile.pin_angles(PAPER) - crank, 2 * np.pi)
    assert np.all(ahead[shared.forces > 0] < np.pi)
    assert np.all(ahead[shared.forces == 0] > np.pi)
    # Positive torque and the gear's rotation under a positive crank speed have opposite signs: it is a load.
    assert TORQUE * kinematics.gear_speed(1.0, PAPER.lobes) < 0
    other = ideal_loads.ideal_load_sharing(PAPER, -TORQUE, crank)
    assert np.all((other.forces > 0) == (shared.forces == 0))


def test_sharing_is_the_equilibrium_of_equal_springs():
    """One-sided least squares, min |F|^2 with F >= 0 at given torque, is the same as springs that only push."""
    shared = ideal_loads.ideal_load_sharing(PAPER, TORQUE, 0.77)
    heavy = 1e6
    system = np.vstack([heavy * shared.arms[None, :], np.eye(36)])
    springs = lsq_linear(system, np.append(-heavy * TORQUE, np.zeros(36)), bounds=(0, np.inf), tol=1e-14)
    assert shared.forces == pytest.approx(springs.x, abs=1e-8 * shared.forces.max())


def test_shapes_broadcast_and_no_torque_means_no_force():
    shared = ideal_loads.ideal_load_sharing(PAPER, [[1.0], [0.0]], np.zeros((1, 5)))
    assert shared.forces.shape == (2, 5, 36)
    assert shared.eccentric_radial.shape == (2, 5)
    assert shared.forces[0].max() > 0
    assert not shared.forces[1].any()
    assert ideal_loads.share_load([0.0, 0.0], 3.0).tolist() == [0.0, 0.0]


def test_undercut_ring_is_refused():
    with pytest.raises(DesignError, match="undercut"):
        ideal_loads.ideal_internal_gear_load_sharing(dataclasses.replace(PAPER, pin_radius=2.7e-3), TORQUE, 0.0)


def test_hertz_pressure_carries_the_force_and_fits_the_curvature():
    force, length, kappa, modulus = 110.0, 10e-3, 1 / 2.25e-3 + 50.0, ideal_loads.contact_modulus(210e9, 0.3)
    contact = ideal_loads.hertz_line_contact(force, length, kappa, modulus)
    b, p0 = contact.half_width, contact.peak_pressure
    # The semi-elliptic pressure sums to the force, and bends the surfaces by the relative curvature: p0 = E* b kappa/2.
    assert math.pi / 2 * p0 * b * length == pytest.approx(force, rel=1e-14)
    assert p0 == pytest.approx(modulus * b * kappa / 2, rel=1e-14)
    assert modulus == pytest.approx(210e9 / (2 * 0.91))
    assert ideal_loads.contact_modulus(210e9, 0.3, 70e9, 0.33) == pytest.approx(1 / (0.91 / 210e9 + 0.8911 / 70e9))


def test_largest_shear_matches_the_stress_field():
    def shear(depth: float) -> float:
        """Half the difference of the principal stresses on the axis, over p0, at a depth over b."""
        root = math.sqrt(1 + depth**2)
        across = -((1 + 2 * depth**2) / root - 2 * depth)
        along_depth = -1 / root
        return abs(across - along_depth) / 2

    found = minimize_scalar(lambda depth: -shear(depth), bounds=(0.1, 2.0), method="bounded", options={"xatol": 1e-9})
    contact = ideal_loads.hertz_line_contact(100.0, 0.01, 500.0, 1e11)
    assert contact.largest_shear / contact.peak_pressure == pytest.approx(-found.fun, rel=1e-12)
    assert contact.shear_depth / contact.half_width == pytest.approx(found.x, abs=1e-7)
    assert contact.largest_shear / contact.peak_pressure == pytest.approx(0.30, abs=1e-3)
    assert contact.shear_depth / contact.half_width == pytest.approx(0.786, abs=5e-4)


@pytest.mark.parametrize(
    ("hole_circle", "width", "sleeve", "hole", "published"),
    [(30, 10, 5, 8, 303), (20, 8, 3, 5, 552)],
)
def test_output_sleeves_published_by_krol_et_al(hole_circle, width, sleeve, hole, published):
    """Krol et al. 2019, doi 10.1007/978-3-030-20131-9_103: 15 lobes, 1.55 N m in, E 200 GPa, nu 0.3; mm, MPa."""
    force = 2 * 1.550 * 15 * math.cos(2 * math.pi / 8) / (math.pi * hole_circle * 1e-3)
    kappa = 1e3 / sleeve - 1e3 / hole
    contact = ideal_loads.hertz_line_contact(force, width * 1e-3, kappa, ideal_loads.contact_modulus(200e9, 0.3))
    # The published values are whole MPa.
    assert contact.peak_pressure / 1e6 == pytest.approx(published, abs=0.6)


def test_hertz_accepts_arrays_and_refuses_invalid_values():
    contact = ideal_loads.hertz_line_contact([0.0, 100.0, 400.0], 0.01, 500.0, 1e11)
    assert contact.half_width[0] == contact.peak_pressure[0] == 0
    assert contact.peak_pressure[2] / contact.peak_pressure[1] == pytest.approx(2)
    good = {"force": 1.0, "length": 0.01, "relative_curvature": 500.0, "modulus": 1e11}
    for spoiled in ({"force": -1.0}, {"length": 0.0}, {"relative_curvature": [3.0, -1e-9]}, {"modulus": math.nan}):
        with pytest.raises(DesignError, match="not valid for a Hertz line contact"):
            ideal_loads.hertz_line_contact(**{**good, **spoiled})


def test_palmgren_in_millimetres_and_newtons():
    deflection_mm = 3.84e-5 * 100**0.9 / 10**0.8
    assert ideal_loads.palmgren_stiffness(100.0, 10e-3) == pytest.approx(100.0 / (deflection_mm * 1e-3), rel=1e-14)
    assert ideal_loads.palmgren_stiffness(100.0, 10e-3) == pytest.approx(2.6e8, rel=0.01)
    assert ideal_loads.palmgren_stiffness(0.0, 7e-3) == 0


@each_gear
@pytest.mark.parametrize("torque", [7.0, -7.0])
def test_output_pins_transmit_the_torque_and_push_inwards(gear, torque):
    """Forces as plain vectors at the holes' centres, with the pins where the geometry puts them."""
    pins, radius = 8, 0.6 * gear.pin_circle_radius
    for crank in (0.0, 0.4, -2.0, 11.0):
        forces = ideal_loads.ideal_output_forces(gear, pins, radius, torque, crank)
        turn = -2 * np.pi * np.arange(pins) / pins + kinematics.gear_rotation(gear, crank)
        levers = radius * np.stack([-np.sin(turn), np.cos(turn)], axis=-1)
        inward = -kinematics.gear_centre(gear, crank) / gear.eccentricity
        pushes = forces[:, None] * inward
        assert np.all(forces >= 0)
        assert 0 < np.count_nonzero(forces) <= pins // 2
        assert np.sum(levers[:, 0] * pushes[:, 1] - levers[:, 1] * pushes[:, 0]) == pytest.approx(torque, rel=1e-12)


@each_gear
@pytest.mark.parametrize("torque", [7.0, -7.0])
def test_the_cam_holds_ring_output_and_body_forces(gear, torque):
    body = np.array([3.0, -5.0])
    for crank in (0.0, 0.4, -2.0):
        ring = ideal_loads.ideal_load_sharing(gear, torque, crank)
        output = ideal_loads.ideal_output_forces(gear, 8, 0.6 * gear.pin_circle_radius, torque, crank)
        cam = ideal_loads.cam_force(ring, output, crank, body)
        contacts = envelope.arc_contacts(gear, crank)
        outward = kinematics.gear_centre(gear, crank) / gear.eccentricity
        held = np.sum(ring.forces[:, None] * contacts.normals, axis=0) - np.sum(output) * outward + body
        assert np.abs(held + cam).max() < 1e-9 * np.linalg.norm(cam)
        # Without losses and body forces the crank's torque is the load's, divided by the ratio.
        ideal = ideal_loads.cam_force(ring, output, crank)
        on_crank = -gear.eccentricity * (outward[0] * ideal[1] - outward[1] * ideal[0])
        assert on_crank == pytest.approx(-torque / gear.lobes, rel=1e-10)


def test_the_cam_of_the_paper_carries_more_than_the_ring_requires():
    """Leaving out the reaction of the output pins gives a cam load that is too small."""
    ring = ideal_loads.ideal_load_sharing(PAPER, TORQUE, CRANKS)
    output = ideal_loads.ideal_output_forces(PAPER, 8, 26e-3, TORQUE, CRANKS)
    full = np.linalg.norm(ideal_loads.cam_force(ring, output, CRANKS), axis=-1)
    alone = np.hypot(ring.eccentric_tangential, ring.eccentric_radial)
    assert np.all(full > 1.3 * alone)
    # Of 8 pins, sin^2 of the loaded ones sums to 2 at every angle, and their sines to 8/pi on average.
    assert output.sum(axis=-1).mean() == pytest.approx(4 * TORQUE / (np.pi * 26e-3), rel=1e-3)


@pytest.mark.parametrize(("force", "play"), [(900.0, 1e-6), (10.0, 1e-6), (5000.0, 20e-6), (900.0, 1e-12)])
def test_conformal_bearing_pressure_matches_elastic_foundation(force, play):
    """The pressure of an elastic bed as thick as the radius, summed over the bore by quadrature."""
    modulus, length, radius = ideal_loads.contact_modulus(210e9, 0.3), 10e-3, 15e-3
    depth = force / ideal_loads.conformal_stiffness(force, length, modulus, play)
    angle = (np.arange(200_000) + 0.5) / 200_000 * np.pi - np.pi / 2
    pressed = np.maximum((play + depth) * np.cos(angle) - play, 0.0)
    pressure = modulus / radius * pressed
    total = np.sum(pressure * np.cos(angle)) * radius * length * np.pi / angle.size
    assert total == pytest.approx(force, rel=1e-5)


def test_a_conformal_bearing_without_play_is_linear():
    for force in (1.0, 1e5):
        stiffness = ideal_loads.conformal_stiffness(force, 0.02, 1e11, 1e-15)
        assert stiffness == pytest.approx(np.pi / 2 * 1e11 * 0.02, rel=3e-6)
