"""Several discs on one crank: ideal forces, the laws of two discs, and how discs share a load that is not ideal."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize

from cycloid_mj import statics
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.kinematics import gear_centre, gear_rotation
from cycloid_mj.loaded import Loads, loads, springs_of
from cycloid_mj.loaded.samples import alike, solve_samples
from cycloid_mj.modification import tooth_profile
from cycloid_mj.structure import beam_flexibility, pin_flexibility, twisting_compliance

PAIRS = ("pin_gear", "pin_socket", "pin_sleeve", "tooth", "cam", "output")
UNIFORM = {"stiffness_law": "uniform"}


def ideal(design: Design, **changes: object) -> Design:
    """Give a design without friction, weight, inertia and play, whose cams hold and whose contacts are alike."""
    still = {"environment": {"gravity_x": 0.0, "gravity_y": 0.0}, "drive": {"speed": 0.0}}
    smooth = dict.fromkeys((*PAIRS, "cam_rolling", "output_rolling"), 0.0)
    stiff = {"pin_gear": 1e8, "tooth": 1e8, "output": 1e8, "cam": 1e12}
    tight = dict.fromkeys(PAIRS, 1e-12)
    made = {"ring": {"pins": "fixed"}, "friction": smooth, "stiffness": stiff, "contact": UNIFORM, "clearance": tight}
    return design.but(**made, **still).but(**changes)


def two(design: Design, **gear: object) -> Design:
    return design.but(gear={"discs": 2, **gear})


def carried(design: Design, torque: float, cranks: np.ndarray | None = None) -> Loads:
    cranks = np.linspace(0.0, 2.0 * np.pi, 181) if cranks is None else cranks
    return loads(design, springs_of(design, cranks, friction=False), torque)


def size(found: Loads) -> np.ndarray:
    """Size of each cam's force, (m, D)."""
    return np.linalg.norm(found.cam, axis=-1)


def on_ring(design: Design, found: Loads, cranks: np.ndarray) -> np.ndarray:
    """Net force of the teeth on the ring, (m, 2)."""
    contacts = springs_of(design, cranks, friction=False)
    slope = contacts.contacts.slope[:, : contacts.teeth]
    by_place = slope[..., :-1].reshape(*slope.shape[:2], -1, 3)[..., :2].sum(axis=2)
    return -np.einsum("mn,mni->mi", found.teeth, by_place)


@pytest.mark.parametrize("discs", [2, 3, 4])
def test_each_of_several_discs_carries_what_a_single_one_does_of_its_share(discs: int) -> None:
    design, cranks = ideal(PRESETS["pin"]), np.linspace(0.0, 2.0 * np.pi, 25)
    several = carried(design.but(gear={"discs": discs}), 1.8 * discs, cranks)
    np.testing.assert_allclose(several.share, 1.0 / discs, atol=1e-3)
    gear, output = tooth_profile(design), design.output
    for disc in range(discs):
        phase = 2.0 * math.pi * disc / discs
        ring = statics.ideal_load_sharing(gear, 1.8, cranks + phase)
        pins = statics.ideal_output_forces(gear, output.pins, output.pin_circle_radius, 1.8, cranks, phase)
        cam = statics.cam_force(ring, pins, cranks + phase)
        np.testing.assert_allclose(several.by_disc(several.teeth)[:, disc], ring.forces, atol=0.02)
        np.testing.assert_allclose(several.by_disc(several.output)[:, disc], pins, atol=0.1)
        np.testing.assert_allclose(several.cam[:, disc], cam, atol=0.2)


@pytest.mark.parametrize(("teeth", "pins"), [(36, 8), (37, 8), (36, 7), (37, 7)])
def test_the_net_force_vanishes_if_and_only_if_teeth_and_output_pins_are_even(teeth: int, pins: int) -> None:
    design = two(ideal(PRESETS["pin"], ring={"teeth": teeth}, output={"pins": pins}))
    cranks = np.linspace(0.0, 2.0 * np.pi, 181)
    found = carried(design, 36.0, cranks)
    ring, largest = np.linalg.norm(on_ring(design, found, cranks), axis=1).max(), found.teeth.max()
    net = np.linalg.norm(found.cam.sum(axis=1), axis=1).max()
    assert (ring < 1e-6 * largest) == (teeth % 2 == 0 and pins % 2 == 0)
    assert (net < 1e-6 * size(found).max()) == (teeth % 2 == 0 and pins % 2 == 0)


def test_bent_pins_of_the_paper_take_a_third_of_its_stiffness() -> None:
    """Solid pins of 4 mm, loaded 5 mm from their roots: 165 N m/arcmin, which turn 76.5 into 52."""
    pin = PRESETS["pin"]
    give = beam_flexibility(pin.material, 4e-3, np.array([5e-3]))[0, 0]
    around = 0.5 * pin.output.pins / 2.0 * pin.output.pin_circle_radius**2
    bent = around / give * math.pi / 10800.0
    assert bent == pytest.approx(165.0, rel=0.02)
    assert 1.0 / (1.0 / 76.5 + 1.0 / bent) == pytest.approx(52.0, rel=0.01)


@pytest.mark.parametrize("support", ["cantilever", "both_ends"])
def test_pins_bend_as_a_beam_of_finite_elements(support: str) -> None:
    """Hermite elements of Euler's beam with shear as a second spring in each: Timoshenko's beam in the limit."""
    design = PRESETS["pin"].but(structure="springs", gear={"discs": 3}, output={"support": support})
    ours = pin_flexibility(design)
    made, radius, count = design.material, design.output.root_radius, 480
    length = design.gear.stack_width + 2e-3
    h, modulus = length / count, made.youngs_modulus
    bending = modulus * math.pi * radius**4 / 4.0
    shear = 6.0 * (1.0 + made.poisson) / (7.0 + 6.0 * made.poisson) * modulus / (2.0 * (1.0 + made.poisson))
    share = 12.0 * bending / (shear * math.pi * radius**2 * h**2)
    element = np.array(
        [
            [12.0, 6.0 * h, -12.0, 6.0 * h],
            [6.0 * h, (4.0 + share) * h**2, -6.0 * h, (2.0 - share) * h**2],
            [-12.0, -6.0 * h, 12.0, -6.0 * h],
            [6.0 * h, (2.0 - share) * h**2, -6.0 * h, (4.0 + share) * h**2],
        ]
    ) * (bending / (h**3 * (1.0 + share)))
    whole = np.zeros((2 * count + 2, 2 * count + 2))
    for one in range(count):
        whole[2 * one : 2 * one + 4, 2 * one : 2 * one + 4] += element
    nodes = np.round((design.gear.stack_width / 2.0 + 1e-3 - np.array(design.gear.disc_planes)) / h).astype(int)
    free = slice(2, None) if support == "cantilever" else slice(2, -2)
    flexible = np.linalg.inv(whole[free, free])
    rows = 2 * (nodes - 1)
    np.testing.assert_allclose(ours, flexible[np.ix_(rows, rows)], rtol=2e-5)


def searched(design: Design, torque: float, crank: float) -> tuple[np.ndarray, float]:
    """Find the shares of two discs and the output's turn by the least energy of springs, from the geometry alone.

    Teeth to first order, by their common normals through the pitch point; output pins as circles in circles, on
    cantilevers whose deflections at each disc, along the eccentrics, are unknowns of their own.
    """
    gear, output, stiff = tooth_profile(design), design.output, design.stiffness
    radius, bends = output.pin_circle_radius, design.structure == "springs"
    angle = 2.0 * math.pi * np.arange(gear.ring_teeth) / gear.ring_teeth
    pins = gear.pin_circle_radius * np.stack([np.sin(angle), np.cos(angle)], axis=1)
    around = 2.0 * math.pi * np.arange(output.pins) / output.pins - float(gear_rotation(gear, crank))
    studs = radius * np.stack([np.sin(around), np.cos(around)], axis=1)
    larger, held = design.errors.disc_dr or (0.0, 0.0), np.zeros((2, 2))
    if bends:
        held = np.linalg.inv(pin_flexibility(design))
    middles = [np.asarray(gear_centre(gear, crank + math.pi * disc)) for disc in range(2)]
    along = middles[0] / gear.eccentricity

    def turned(angle: float) -> tuple[np.ndarray, np.ndarray]:
        """Give the studs turned, and their rate by the angle."""
        c, s = math.cos(angle), math.sin(angle)
        return studs @ np.array([[c, s], [-s, c]]), studs @ np.array([[-s, c], [-c, -s]])

    def state(unknown: np.ndarray) -> tuple[float, np.ndarray, list[float]]:
        """Give the energy [J], its gradient by the unknowns [um], and each disc's moment on the output [N m]."""
        z, bent = unknown[:7] * 1e-6, np.resize(unknown[7:], (output.pins, 2)) * 1e-6 * bends
        slope, by_bend = np.zeros(7), bent @ held
        psi, energy, moments = z[6] / radius, 0.5 * float(np.sum(by_bend * bent)), []
        pin, pin_rate = turned(psi)
        for disc, middle in enumerate(middles):
            x, (hole, hole_rate) = z[3 * disc : 3 * disc + 2], turned(z[3 * disc + 2] / radius)
            normal, lever = middle * gear.ring_teeth - pins, pins - middle
            normal /= np.linalg.norm(normal, axis=1)[:, np.newaxis]
            arm = (lever[:, 0] * normal[:, 1] - lever[:, 1] * normal[:, 0]) / radius
            mesh = normal @ x + arm * z[3 * disc + 2] + design.clearance.pin_gear - larger[disc]
            teeth = stiff.pin_gear * np.minimum(mesh, 0.0)
            between = pin + bent[:, disc, np.newaxis] * along - hole - middle - x
            apart = np.linalg.norm(between, axis=1)
            depth = np.maximum(apart - gear.eccentricity - design.clearance.output, 0.0)
            push = between * (stiff.output * depth / apart)[:, np.newaxis]
            from_cam = float(np.linalg.norm(x))
            pressed = stiff.cam * max(from_cam - design.clearance.cam, 0.0)
            energy += 0.5 * float(teeth @ teeth) / stiff.pin_gear + 0.5 * stiff.output * float(depth @ depth)
            energy += 0.5 * pressed**2 / stiff.cam
            slope[3 * disc : 3 * disc + 2] = normal.T @ teeth - push.sum(axis=0) + pressed * x / (from_cam or 1.0)
            slope[3 * disc + 2] = arm @ teeth - np.sum(push * hole_rate) / radius
            moments.append(float(np.sum(push * pin_rate)))
            by_bend[:, disc] += push @ along
        slope[6] = (sum(moments) - torque) / radius
        return energy - torque * psi, np.concatenate([slope, by_bend.ravel() if bends else []]) * 1e-6, moments

    start = np.zeros(7 + 2 * output.pins * bends)
    start[[2, 5, 6]] = 1.0, 1.0, 4.0
    for _ in range(4):
        found = minimize(
            lambda z: state(z)[:2], start, jac=True, method="BFGS", options={"gtol": 1e-14, "maxiter": 4000}
        )
        start = found.x
    assert np.abs(state(start)[1]).max() < 1e-7  # 0.1 N
    moments = state(start)[2]
    return np.array(moments) / sum(moments), start[6] * 1e-6 / radius


NOT_IDEAL = two(ideal(PRESETS["pin"])).but(stiffness={"cam": 8e8}, clearance=dict.fromkeys(PAIRS, 1e-6))


@pytest.mark.parametrize("crank", [0.7, 2.9])
@pytest.mark.parametrize("structure", ["rigid", "springs"])
@pytest.mark.parametrize("larger", ["[0, 0]", "[1, 0]", "[0, 1]"])
def test_unlike_discs_share_as_an_independent_search_of_the_least_energy_finds(larger, structure, crank) -> None:
    design = override(NOT_IDEAL, [f"errors.disc_dr_um={larger}", f"structure={structure}"])
    found = carried(design, 36.0, np.array([crank]))
    share, turn = searched(design, 36.0, crank)
    np.testing.assert_allclose(found.share[0], share, rtol=0.02)
    assert found.output_turn[0] - 36.0 * sum(twisting_compliance(design).values()) == pytest.approx(turn, rel=0.005)
    if structure == "rigid" and larger == "[0, 0]":
        np.testing.assert_allclose(found.share, 0.5, rtol=0.01)
    elif structure == "rigid":
        assert found.share[0, 0 if larger.startswith("[1") else 1] > 0.55


def test_samples_of_two_discs_are_the_statics_of_designs_made_so() -> None:
    errors = ["errors.hole_position_um=0.8", "errors.disc_size_um=0.5", "errors.cam_position_um=0.5"]
    design = override(NOT_IDEAL, [*errors, "errors.pin_position_um=0.5", "structure=springs"])
    cranks = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    alone = loads(design, springs_of(design, cranks, friction=False), 36.0)
    found = solve_samples(design, alike(design, 1), [36.0], cranks.size)[0]
    assert found.output_mean[0] == pytest.approx(alone.output_turn.mean(), rel=1e-4)
    assert found.tooth[0] == pytest.approx(alone.teeth.max(), rel=1e-4)
    assert found.cam[0] == pytest.approx(size(alone).max(), rel=1e-4)
    assert found.output_pin[0] == pytest.approx(alone.output.max(), rel=1e-4)
