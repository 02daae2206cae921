"""Several discs on one crank: ideal forces, the laws of two discs, and how discs share a load that is not ideal."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize

from cycloid_mj.checks import check
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.geometry import ideal_loads
from cycloid_mj.geometry.kinematics import gear_centre, gear_rotation
from cycloid_mj.geometry.modification import tooth_profile
from cycloid_mj.parts.shaft import bearing_seats
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.bending import beam_flexibility
from cycloid_mj.reducer.bodies import are_discs_identical
from cycloid_mj.statics import Loads, loads, springs_of
from cycloid_mj.statics.bearings import compute_reactions
from cycloid_mj.statics.samples import identical_samples, solve_samples
from cycloid_mj.statics.sheet import sheet
from cycloid_mj.statics.structure import crank_flexibility, structure_text, twisting_compliance

PAIRS = ("pin_gear", "pin_socket", "pin_sleeve", "tooth", "cam", "output")
UNIFORM = {"stiffness_law": "uniform"}


def ideal(design: Design, **changes: object) -> Design:
    """Return a design without friction, weight, inertia and play, whose cams hold and whose contacts are alike."""
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
    return loads(Reducer(design), springs_of(Reducer(design), cranks, friction=False), torque)


def size(found: Loads) -> np.ndarray:
    """Size of each cam's force, (m, D)."""
    return np.linalg.norm(found.cam, axis=-1)


def on_ring(design: Design, found: Loads, cranks: np.ndarray) -> np.ndarray:
    """Net force of the teeth on the ring, (m, 2)."""
    contacts = springs_of(Reducer(design), cranks, friction=False)
    slope = contacts.contacts.slope[:, : contacts.teeth]
    by_place = slope[..., :-1].reshape(*slope.shape[:2], -1, 3)[..., :2].sum(axis=2)
    return -np.einsum("mn,mni->mi", found.teeth, by_place)


@pytest.mark.parametrize("discs", [2, 3, 4])
def test_each_of_several_discs_carries_its_share_like_a_single_disc(discs: int) -> None:
    design, cranks = ideal(PRESETS["pin"]), np.linspace(0.0, 2.0 * np.pi, 25)
    several = carried(design.but(gear={"discs": discs}), 1.8 * discs, cranks)
    np.testing.assert_allclose(several.share, 1.0 / discs, atol=1e-3)
    gear, output = tooth_profile(design), design.output
    for disc in range(discs):
        phase = 2.0 * math.pi * disc / discs
        ring = ideal_loads.ideal_load_sharing(gear, 1.8, cranks + phase)
        pins = ideal_loads.ideal_output_forces(gear, output.pins, output.pin_circle_radius, 1.8, cranks, phase)
        cam = ideal_loads.cam_force(ring, pins, cranks + phase)
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


TWODISC = PRESETS["twodisc"]


def test_the_published_two_disc_drive_has_its_ideal_forces() -> None:
    """Case K: kubakos/cycloid-drive-generator, 58 N m a disc; a hundredth of the load keeps to first order."""
    design = ideal(TWODISC).but(structure="rigid")
    found = carried(design, 1.16, np.linspace(0.0, 2.0 * np.pi, 721))
    assert found.teeth.max() == pytest.approx(2.1314, rel=0.005)
    assert found.output.max() == pytest.approx(17.059, rel=0.005)
    assert size(found).max() == pytest.approx(24.60, rel=0.005)
    assert size(found).min() == pytest.approx(19.67, rel=0.005)
    np.testing.assert_allclose(found.share, 0.5, rtol=0.01)
    loaded = (found.by_disc(found.teeth) > 1e-3 * found.teeth.max()).sum(axis=-1)
    assert set(loaded.ravel()) <= {14, 15}
    turned = np.linspace(0.0, 2.0 * np.pi, 721)
    for disc, phase in enumerate((0.0, math.pi)):
        back = -np.stack([np.cos(turned + phase), np.sin(turned + phase)], axis=1)
        around = np.sum(found.cam[:, disc] * back, axis=1)
        np.testing.assert_allclose(around, 15.9997, rtol=0.005)


def test_ideal_sharing_equals_two_discs_with_equal_shares() -> None:
    value = sheet(Reducer(TWODISC)).quantities
    stated = {"pin_gear": 213.14, "output": 1705.9, "cam": 2460.0}
    for kind, force in stated.items():
        assert value[f"{kind}_peak_force"].reference == pytest.approx(force, rel=0.005)
    for disc in (1, 2):
        assert value[f"disc_{disc}_share"].value == pytest.approx(0.5, rel=0.01)
    assert value["shaft_net_force"].value < 0.01 * value["cam_peak_force"].value
    couple = value["cam_peak_force"].value * TWODISC.gear.disc_spacing
    assert value["shaft_tilting_moment"].value == pytest.approx(couple, rel=0.01)
    parts = sum(one.value for key, one in value.items() if key.startswith("compliance_"))
    assert parts * value["stiffness_ideal"].value == pytest.approx(1.0, rel=0.02)
    assert value["stiffness_contacts"].value > 1.3 * value["stiffness_ideal"].value


@pytest.mark.parametrize(("teeth", "pins", "left"), [(30, 4, (0.0, 0.0)), (37, 4, (10.9, 0.0)), (30, 7, (0.0, 21.4))])
def test_an_odd_number_leaves_a_net_force(teeth: int, pins: int, left: tuple[float, float]) -> None:
    """At 18 N m a disc: 37 teeth leave 10.9 N of 445 on the ring, 7 output pins 21.4 N of 691 on the output."""
    gear, radius = tooth_profile(TWODISC.but(ring={"teeth": teeth})), TWODISC.output.pin_circle_radius
    crank, net, largest = np.linspace(0.0, 2.0 * np.pi, 2001), np.zeros((2, 2001, 2)), np.zeros(2)
    for phase in (0.0, math.pi):
        ahead = crank + phase
        out, forward = np.stack([-np.sin(ahead), np.cos(ahead)], 1), -np.stack([np.cos(ahead), np.sin(ahead)], 1)
        ring = ideal_loads.ideal_load_sharing(gear, 18.0, ahead)
        teeth_hold = out * ring.eccentric_radial[:, np.newaxis] + forward * ring.eccentric_tangential[:, np.newaxis]
        push = out * ideal_loads.ideal_output_forces(gear, pins, radius, 18.0, crank, phase).sum(axis=1)[:, np.newaxis]
        for part, force in enumerate((teeth_hold, push)):
            net[part] += force
            largest[part] = max(largest[part], np.linalg.norm(force, axis=1).max())
    np.testing.assert_allclose(np.linalg.norm(net, axis=2).max(axis=1), left, rtol=0.01, atol=1e-9)
    if teeth == 37:
        assert largest[0] == pytest.approx(444.0, rel=0.01)
    if pins == 7:
        assert largest[1] == pytest.approx(691.0, rel=0.01)


def test_an_output_pin_carries_one_disc_at_a_time_except_at_handover() -> None:
    found = carried(two(ideal(PRESETS["pin"])), 3.6, np.linspace(0.0, 2.0 * np.pi, 1441))
    pressed = found.by_disc(found.output) > 1e-3 * found.output.max()
    both = pressed.all(axis=1)
    assert both.mean() < 0.01
    assert pressed.mean() == pytest.approx(0.5, abs=0.02)


def test_bearings_balance_forces_and_moments() -> None:
    """The shaft hangs in two bearings: what they hold is opposite to the discs' forces and to their moments."""
    design = two(ideal(PRESETS["pin"], ring={"teeth": 37}, output={"pins": 7, "support": "both_ends"}))
    springs = springs_of(Reducer(design), np.linspace(0.0, 6.0, 7), friction=False)
    held = compute_reactions(Reducer(design), springs, loads(Reducer(design), springs, 36.0))
    far, near = (0.5 * sum(seat) for seat in bearing_seats(Reducer(design)))
    np.testing.assert_allclose(held.shaft_far + held.shaft_near, -held.shaft.net, atol=1e-9)
    lever = np.stack([-held.shaft.moment[:, 1], held.shaft.moment[:, 0]], axis=1)
    np.testing.assert_allclose(far * held.shaft_far + near * held.shaft_near, lever, atol=1e-9)
    assert held.output_far is not None
    whole = held.shaft.net + held.output.net + held.ring.net
    np.testing.assert_allclose(whole, 0.0, atol=1e-3 * np.abs(held.shaft.force).max())


@pytest.mark.parametrize("discs", [2, 3, 4])
def test_discs_are_identical_if_a_rotation_aligns_teeth_and_holes(discs: int) -> None:
    """By brute force: turn a disc by every pitch of its holes, and look where its teeth come to lie."""
    seen = set()
    for lobes in range(5, 40):
        for pins in range(3, 17):
            turns = 2.0 * math.pi * np.arange(pins) / pins
            pitch = 2.0 * math.pi / lobes
            wanted = [pitch * disc / discs for disc in range(discs)]
            off = [np.abs(np.mod(turns - want + pitch / 2.0, pitch) - pitch / 2.0).min() for want in wanted]
            same = max(off) < 1e-9
            seen.add(same)
            assert are_discs_identical(discs, pins, lobes) == same, (lobes, pins)
    assert seen == {True, False}


def test_the_check_states_the_numbers_of_output_pins_with_identical_discs() -> None:
    alike = next(item for item in check(TWODISC) if item.name == "identical_discs")
    assert alike.passed
    even = override(TWODISC, ["ring.teeth=29", "output.pins=6"])
    unlike = next(item for item in check(even) if item.name == "identical_discs")
    assert not unlike.passed
    assert unlike.severity == "warning"
    assert unlike.remedy == "raise output.pins to 8"


def test_bending_of_the_papers_pins_reduces_stiffness_by_a_third() -> None:
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
    ours = Reducer(design).contacts.pin_flexibility
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
        held = np.linalg.inv(Reducer(design).contacts.pin_flexibility)
    middles = [np.asarray(gear_centre(gear, crank + math.pi * disc)) for disc in range(2)]
    along = middles[0] / gear.eccentricity

    def turned(angle: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the studs turned, and their rate by the angle."""
        c, s = math.cos(angle), math.sin(angle)
        return studs @ np.array([[c, s], [-s, c]]), studs @ np.array([[-s, c], [-c, -s]])

    def state(unknown: np.ndarray) -> tuple[float, np.ndarray, list[float]]:
        """Compute the energy [J], its gradient by the unknowns [um], and each disc's moment on the output [N m]."""
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


@pytest.mark.parametrize("structure", ["rigid", "springs"])
@pytest.mark.parametrize("larger", ["[0, 0]", "[1, 0]", "[0, 1]"])
def test_unequal_discs_share_load_as_in_an_independent_energy_minimum(larger, structure) -> None:
    design = override(NOT_IDEAL, [f"errors.disc_dr_um={larger}", f"structure={structure}"])
    found = carried(design, 36.0, np.array([0.7]))
    share, turn = searched(design, 36.0, 0.7)
    np.testing.assert_allclose(found.share[0], share, rtol=0.02)
    assert found.output_turn[0] - 36.0 * sum(twisting_compliance(Reducer(design)).values()) == pytest.approx(
        turn, rel=0.005
    )
    if structure == "rigid" and larger == "[0, 0]":
        np.testing.assert_allclose(found.share, 0.5, rtol=0.01)
    elif structure == "rigid":
        assert found.share[0, 0 if larger.startswith("[1") else 1] > 0.55


def test_the_crank_bends_at_its_cams_as_handbooks_have_it() -> None:
    """Overhung a^2 (l + a)/(3 E I), between its bearings a^2 b^2/(3 E I l), and Maxwell's symmetry; told in um."""
    one, two = PRESETS["printed"].but(shaft={"mounting": "overhang"}), PRESETS["twodisc"]
    stiff = {
        design: design.material_of("shaft").youngs_modulus * np.pi * design.shaft.radius**4 / 4.0
        for design in (one, two)
    }
    far, near = (0.5 * sum(seat) for seat in bearing_seats(Reducer(one)))
    overhung = near**2 * -far / (3.0 * stiff[one])
    assert crank_flexibility(Reducer(one)) == pytest.approx(np.array([[overhung]]), rel=1e-9)
    assert f"{1e9 * overhung:.3g} um at a cam under 1 kN" in structure_text(Reducer(one))
    far, near = (0.5 * sum(seat) for seat in bearing_seats(Reducer(two)))
    found, planes = crank_flexibility(Reducer(two)), np.array(two.gear.disc_planes)
    between = ((planes - near) * (far - planes)) ** 2 / (3.0 * stiff[two] * (far - near))
    assert found.diagonal() == pytest.approx(between, rel=1e-9)
    assert found[0, 1] == pytest.approx(found[1, 0], rel=1e-12)
    assert 0.0 < found[0, 1] < np.sqrt(between.prod())


def test_the_statics_of_two_disc_samples_equal_those_of_designs_with_their_errors() -> None:
    errors = ["errors.hole_position_um=0.8", "errors.disc_size_um=0.5", "errors.cam_position_um=0.5"]
    design = override(NOT_IDEAL, [*errors, "errors.pin_position_um=0.5", "structure=springs"])
    cranks = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    alone = loads(Reducer(design), springs_of(Reducer(design), cranks, friction=False), 36.0)
    found = solve_samples(Reducer(design), identical_samples(Reducer(design), 1), [36.0], cranks.size)[0]
    assert found.output_mean[0] == pytest.approx(alone.output_turn.mean(), rel=1e-4)
    assert found.tooth[0] == pytest.approx(alone.teeth.max(), rel=1e-4)
    assert found.cam[0] == pytest.approx(size(alone).max(), rel=1e-4)
    assert found.output_pin[0] == pytest.approx(alone.output.max(), rel=1e-4)


def test_pins_are_solved_with_their_discs_only_where_they_bend_for_several() -> None:
    for design, bends in ((PRESETS["pin"], False), (override(TWODISC, ["structure=rigid"]), False), (TWODISC, True)):
        contacts = springs_of(Reducer(design), [0.3], friction=False).contacts
        assert contacts.bending.any() == bends
        assert contacts.pins == (design.output.pins if bends else 0)
