"""Manufacturing errors and profile modification: drawn, listed, seen by the collider, and carried into load sharing."""

from functools import cache

import mujoco
import numpy as np
import pytest
from designs import CENTRAL
from ring_rig import Rig, compare_gaps
from scipy.spatial import cKDTree

from cycloid_mj.base.errors import DesignError
from cycloid_mj.checks import check
from cycloid_mj.design import PRESETS, Design, dump, loads, override
from cycloid_mj.dynamics.contact.collider import install
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.geometry import profile
from cycloid_mj.geometry.deviations import deviations, profile_error
from cycloid_mj.geometry.modification import flank_ends, gear_profile, profile_offset, sample_rotated_flanks
from cycloid_mj.geometry.profile import CycloidGear, unit
from cycloid_mj.parts.gear import gear_outline
from cycloid_mj.reducer import Reducer, limits
from cycloid_mj.validate import backlash, equilibrium, rig
from cycloid_mj.validate.gaps import GearPose, design_flanks, pin_gaps, rotate

MODIFICATIONS = {
    "strong rotation": ["modification.rotation_arcsec=150.0"],
    "all": [
        "modification.equidistant_um=6.0",
        "modification.pin_circle_um=12.0",
        "modification.rotation_arcsec=40.0",
    ],
    "waves": ["errors.profile_cos_um={1 = 2.0, 3 = -1.5, 35 = 0.8}", "errors.profile_sin_um={2 = 1.0, 9 = 0.5}"],
}


def pin(*changes: str) -> Design:
    return override(PRESETS["pin"], ['ring.pins="fixed"', "clearance.pin_gear_um=30.0", *changes])


def nonpin(*changes: str) -> Design:
    return override(PRESETS["nonpin"], ["clearance.tooth_um=30.0", *changes])


# --- what is drawn and what is listed


def test_draws_follow_the_seed_independently_for_each_kind() -> None:
    changes = ["errors.pin_position_um=2.0", "errors.seed=5"]
    first, again = (deviations(override(PRESETS["pin"], changes)) for _ in range(2))
    np.testing.assert_array_equal(first.pin_displacement, again.pin_displacement)
    other = deviations(override(PRESETS["pin"], ["errors.pin_position_um=2.0", "errors.seed=6"]))
    assert not np.any(first.pin_displacement == other.pin_displacement)
    more = deviations(override(PRESETS["pin"], [*changes, "errors.pin_radius_um=1.0", "errors.hole_position_um=3.0"]))
    np.testing.assert_array_equal(first.pin_displacement, more.pin_displacement)
    columns = [*more.pin_displacement.T / 2e-6, more.pin_radius / 1e-6]
    assert np.abs(np.corrcoef(columns) - np.eye(3)).max() < 0.5  # 36 pairs of independent deviates: 3 sigma
    assert first.pin_radius.tolist() == [0.0] * 36


def test_draws_have_the_standard_deviation_requested() -> None:
    """400 teeth and 10 seeds: 4000 deviates give theirs to 1.1 % (one sigma), the mean to 0.016 of it."""
    teeth = ["ring.teeth=400", "gear.eccentricity_mm=0.1", "output.hole_radius_mm=4.1"]
    drawn = np.concatenate(
        [
            deviations(override(PRESETS["pin"], [*teeth, "errors.pin_radius_um=2.0", f"errors.seed={seed}"])).pin_radius
            for seed in range(10)
        ]
    )
    assert drawn.std() == pytest.approx(2e-6, rel=0.05)
    assert abs(drawn.mean()) < 0.07 * 2e-6


def test_a_list_replaces_the_draw() -> None:
    values = [0.0] * 36
    values[2] = 5.0
    full = override(PRESETS["pin"], [f"errors.pin_x_um={values}", "errors.pin_position_um=1.0"])
    sparse = override(PRESETS["pin"], ["errors.pin_x_um={3 = 5}", "errors.pin_position_um=1.0"])
    assert full == sparse
    made = deviations(full)
    assert made.pin_displacement[:, 0].tolist() == [0.0, 0.0, 5e-6, *[0.0] * 33]
    assert np.all(made.pin_displacement[:, 1] != 0.0)


def test_errors_survive_the_round_trip() -> None:
    rng = np.random.default_rng(8)
    holes = ", ".join(f"{value!r}" for value in rng.normal(0.0, 3.0, 8).tolist())
    design = override(
        PRESETS["pin"],
        ["errors.pin_y_um={36 = -1.7}", f"errors.hole_x_um=[{holes}]", "errors.eccentricity_um=-2.2", "errors.seed=9"],
    )
    assert loads(dump(design)) == design
    assert dump(loads(dump(design))) == dump(design)
    assert override(design, ["load.torque_nm=3"]).errors == design.errors
    assert loads("[errors]\npin_dr_um = {2 = 1}").errors.pin_dr == (0.0, 1e-6, *[0.0] * 34)
    assert Reducer(PRESETS["pin"]).is_ideal
    assert not Reducer(design).is_ideal


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        (["errors.pin_x_um=[1, 2]"], r"errors\.pin_x_um has 2 values, but ring\.teeth is 36"),
        (["errors.hole_y_um=[1]"], r"errors\.hole_y_um has 1 values, but output\.pins is 8"),
        (["errors.pin_x_um={1 = 1}", "ring.teeth=30"], r"give one value for each, or only"),
        (
            ["errors.pin_x_um={37 = 1}"],
            r"there is no value number 37: use numbers from 1 to 36",
        ),
        (["errors.pin_x_um={a = 1}"], r"there is no value number a"),
        (["errors.pin_x_um=3"], r"errors\.pin_x_um = 3 is not allowed: it must be a list such as"),
        (
            ["errors.pin_x_um={2 = 2000}"],
            r"errors\.pin_x_um\[2\] = 2000\.0 is not allowed: it must be at most 1000",
        ),
        (["errors.pin_x_um={2 = nan}"], r"errors\.pin_x_um\[2\] = nan is not allowed"),
        (["errors.pin_x_um={2 = true}"], r"a number"),
        (['errors.pin_x_um=["a"]'], r'errors\.pin_x_um\[1\] = "a" is not allowed'),
        (["errors.pinx_um=3"], r"did you mean errors\.pin_x_um"),
        (["errors.pin_position_um=-1"], r"from 0 to"),
        (["errors.seed=1.5"], r"a whole number"),
        (["ring.kind=nonpin", "errors.pin_radius_um=1"], r"errors\.pin_radius_um is set, .* has no pins"),
        (["ring.kind=nonpin", "errors.pin_y_um={1 = 1}"], r"errors\.pin_y_um is set"),
        (["modification.rotation_arcsec=-1"], r"from 0 to"),
    ],
)
def test_wrong_errors_are_reported(changes: list[str], told: str) -> None:
    *before, last = changes
    design = override(PRESETS["pin"], before)
    with pytest.raises(DesignError, match=told) as error:
        override(design, [last])
    assert "\n" not in str(error.value)


# --- the shape of the gear


def even_parameters(gear: CycloidGear, offset: float, samples: int) -> np.ndarray:
    """Parameters of points at nearly equal distances along the outline."""
    t = np.linspace(0.0, 2 * np.pi, samples)
    length = np.cumsum(profile.arc_rate(gear, t, offset))
    return np.interp(np.linspace(length[0], length[-1], samples, endpoint=False), length, t)


@cache
def polygons_of(design: Design) -> "Polygons":
    return Polygons(design)


class Polygons:
    """The gear by dense points of its profile turned to both sides, less those cut away: no theory of flanks."""

    def __init__(self, design: Design, samples: int = 300_000) -> None:
        gear, offset, turn = gear_profile(design), profile_offset(design), design.modification.rotation
        t = even_parameters(gear, offset, samples)
        path = self._path(design, t)
        # points lie unevenly: differences of the path by its own parameter, over a step that loses no digits
        along = self._path(design, t + 1e-6) - self._path(design, t - 1e-6)
        normals = rotate(along / np.linalg.norm(along, axis=1, keepdims=True), np.pi / 2)
        whole, curvature = path - offset * normals, profile.curvature(gear, t, offset)
        kept = []
        for side in (1, -1) if turn else (1,):
            points = rotate(whole, -side * turn)
            spare = self._radius(whole, rotate(points, -side * turn)) - np.hypot(*points.T)
            inside, directions = spare >= -1e-15, rotate(normals, -side * turn)
            kept.append((points[inside], directions[inside], curvature[inside], np.zeros(inside.sum(), bool)))
            # The corner between a sample inside and the next one outside, where the two outlines cross.
            last = np.flatnonzero(inside != np.roll(inside, -1))
            here, ahead = spare[last], np.roll(spare, -1)[last]
            step = (np.roll(points, -1, axis=0) - points)[last] * (here / (here - ahead))[:, np.newaxis]
            kept.append((points[last] + step, directions[last], curvature[last], np.ones(last.size, bool)))
        joined = (np.concatenate(column) for column in zip(*kept, strict=True))
        self.points, self.normals, self.curvature, self.is_corner = joined
        self.tree = cKDTree(self.points)

    @staticmethod
    def _path(design: Design, t: np.ndarray) -> np.ndarray:
        """Path of a pin's centre round the gear: the trochoid, less the waves of the profile along its normals."""
        gear = gear_profile(design)
        back = profile_error(deviations(design).waves, t)[:, np.newaxis]
        return profile.trochoid(gear, t) - back * profile.normals(gear, t)

    @staticmethod
    def _radius(outline: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Radius of an outline at the polar angles of points: the profile turns around its centre once."""
        angle = np.arctan2(*outline.T)
        order = np.argsort(angle)
        return np.interp(np.arctan2(*points.T), angle[order], np.hypot(*outline[order].T), period=2 * np.pi)

    def gap(self, points: np.ndarray) -> np.ndarray:
        """Gap of points of the ring near the gear, by the nearest sample's tangent and curvature, or its corner."""
        k = self.tree.query(points)[1]
        away = points - self.points[k]
        normal = np.sum(away * self.normals[k], axis=1)
        along2 = np.sum(away**2, axis=1) - normal**2
        bulge = normal + 0.5 * self.curvature[k] * along2
        return np.where(self.is_corner[k], np.copysign(np.sqrt(normal**2 + along2), normal), bulge)

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Distance of points far outside; samples 1 um apart give it to 4e-10 m at the sharpest bend."""
        return self.tree.query(points)[0]


@pytest.mark.slow
@pytest.mark.parametrize("name", MODIFICATIONS)
def test_pins_touch_the_polygons(name: str) -> None:
    """Gaps of the collider and of the independent statics, in poses that reach flanks and corners.

    A pin farther from its valley than the 48 um between their radii is beyond the valley's centre: no contact is near.
    """
    design = pin(*MODIFICATIONS[name])
    compiled, polygons, rng = build(design), polygons_of(design), np.random.default_rng(1)
    flanks = design_flanks(Reducer(design))
    nominal = CycloidGear(36, 1e-3, 40.75e-3, 2.25e-3)
    centres = nominal.pin_circle_radius * unit(profile.pin_angles(nominal))
    unmodified = polygons_of(pin())
    difference, count = 0.0, 0
    for _ in range(30):
        crank, shift, turn = rng.uniform(0, 2 * np.pi), rng.uniform(-8e-6, 8e-6, 2), rng.uniform(-1e-4, 1e-4)
        pose = GearPose(1e-3 * np.array([-np.sin(crank), np.cos(crank)]) + shift, -crank / 35 + turn)
        expected = polygons.distance(pose.to_gear(centres)) - nominal.pin_radius
        seen = gaps_of_pins(compiled, pose, crank)
        near = expected < 4.5e-5
        assert seen[near] == pytest.approx(expected[near], abs=6e-10)
        statics = pin_gaps(nominal, pose, centres, flanks).distance + flanks.offset - nominal.pin_radius
        # the model has 12 digits; of waves it leaves out half of the square of the normal's turn
        assert statics[near] == pytest.approx(seen[near], abs=5e-11 if name == "waves" else 1.2e-13)
        without = unmodified.distance(pose.to_gear(centres)) - nominal.pin_radius
        difference = max(difference, float(np.abs(expected - without)[near].max()))
        count += np.count_nonzero(near)
    assert count > 300
    assert difference > 1e-6


def gaps_of_pins(compiled, pose: GearPose, crank: float) -> np.ndarray:
    """Gap of each pin by the collider, at a stiffness factor of one: closed contacts would be scaled."""
    model, data = compiled.model, mujoco.MjData(compiled.model)
    model.pair_margin[:] = 1e-3
    for joint, value in (("gear_x", pose.centre[0]), ("gear_y", pose.centre[1]), ("gear_angle", pose.angle)):
        data.joint(joint).qpos[0] = value
    data.joint("crank").qpos[0] = crank
    with install():
        mujoco.mj_fwdPosition(model, data)
    number = {model.geom(pair.by).id: k for k, pair in enumerate(compiled.pairs) if pair.kind == "pin_gear"}
    found = np.full(36, np.nan)
    for contact in data.contact:
        for geom in contact.geom:
            if geom in number:
                found[number[geom]] = contact.dist
    return found


@pytest.mark.slow
@pytest.mark.parametrize("name", MODIFICATIONS)
def test_lobes_touch_the_polygons(name: str) -> None:
    design = nonpin(*MODIFICATIONS[name])
    ring, brute = Rig(design, margin=1e-4), polygons_of(design)
    assert compare_gaps(ring, brute.gap, poses=75, reach=4.2e-5, tolerance=2e-9) > 5


@pytest.mark.parametrize("arcsec", [5.0, 150.0, 2000.0])
def test_flanks_end_in_corners_on_the_middles(arcsec: float) -> None:
    """The drawn outline: the largest star of points inside both turned profiles, and corners at tips and valleys."""
    gear, offset, turn = CycloidGear(36, 1e-3, 40.75e-3, 2.25e-3), 2.251e-3, np.radians(arcsec / 3600)
    points, ends = sample_rotated_flanks(gear, 1e-8, offset, turn), flank_ends(gear, offset, turn)
    whole = profile.outline(gear, even_parameters(gear, offset, 500_000), offset)
    reach = np.minimum(*(Polygons._radius(whole, rotate(points, side * turn)) for side in (1, -1)))
    assert np.hypot(*points.T) == pytest.approx(reach, abs=4e-10)  # sagitta of 0.6 um over the least radius
    corners = np.array([ends.valley_radius, ends.tip_radius])
    assert points[0] == pytest.approx([0.0, corners[0]], abs=1e-15)
    assert np.hypot(*points.T).max() == pytest.approx(corners[1], rel=1e-14)
    # Tips lose height, valleys lose depth; both by the second order of a small turn.
    assert corners[0] > 40.75e-3 - 1e-3 - offset
    assert corners[1] < 40.75e-3 + 1e-3 - offset


def test_the_solid_follows_the_modification() -> None:
    """Areas: less by perimeter times the equidistant; a turn takes its angle times what the radii span."""
    changes = ("equidistant_um=12.0", "pin_circle_um=-15.0", "rotation_arcsec=20.0", "rotation_arcsec=150.0")
    plain = polygon_area(gear_outline(Reducer(pin()), 1e-8))
    equidistant, circle, turn, strong = (
        polygon_area(gear_outline(Reducer(pin(f"modification.{change}")), 1e-8)) for change in changes
    )
    perimeter = 295.02e-3
    assert plain - equidistant == pytest.approx(perimeter * 12e-6, rel=2e-3)
    assert plain - circle == pytest.approx(2 * np.pi * 40.75e-3 * 15e-6, rel=0.2)
    # Of each of 70 flanks r dr times the turn is lost: 35 (r_tip^2 - r_valley^2) in all.
    lost = 35 * (39.5e-3**2 - 37.5e-3**2)
    assert plain - turn == pytest.approx(lost * np.radians(20.0 / 3600), rel=0.01)
    assert plain - strong == pytest.approx(lost * np.radians(150.0 / 3600), rel=0.05)


def polygon_area(points: np.ndarray) -> float:
    x, y = points.T
    return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)))


def test_a_turn_that_leaves_no_lobe_is_refused() -> None:
    with pytest.raises(DesignError, match=r"modification\.rotation_arcsec = 3600 is too large, because at 812"):
        flank_ends(CycloidGear(400, 0.1e-3, 40.75e-3, 0.2e-3), 0.2e-3, np.radians(1.0))


# --- pins, holes and cam out of place


def test_a_displaced_pin_shows_in_its_gap() -> None:
    """Finite differences: n . d for the place, minus one for the radius; no other gap changes."""
    step, crank, gear = 1e-8, float(np.arcsin(0.3)), CycloidGear(36, 1e-3, 40.75e-3, 2.25e-3)
    pose = GearPose(np.array([-3e-4, np.sqrt(1e-6 - 9e-8)]) + 2e-6, -crank / 35 + 3e-5)
    plain = gaps_of_pins(build(pin()), pose, crank)
    normals = pin_gaps(gear, pose, gear.pin_circle_radius * unit(profile.pin_angles(gear))).normals
    for number in (1, 30):
        for key, expected in (("pin_x", normals[number - 1, 0]), ("pin_y", normals[number - 1, 1]), ("pin_dr", -1.0)):
            changed = gaps_of_pins(build(pin(f"errors.{key}_um={{{number} = {1e6 * step!r}}}")), pose, crank)
            slope = (changed - plain) / step
            assert slope[number - 1] == pytest.approx(expected, abs=1e-3)  # curvature: step / 18 um of the valley
            assert np.abs(np.delete(slope, number - 1)).max() < 1e-6


def test_model_parts_are_at_their_manufactured_positions() -> None:
    design = override(
        PRESETS["pin"],
        [
            "errors.pin_position_um=3.0",
            "errors.pin_radius_um=0.2",
            "errors.hole_position_um=2.0",
            "errors.eccentricity_um=4.0",
        ],
    )
    made, ideal, model = deviations(design), build(PRESETS["pin"]).model, build(design).model

    def moved(name: str) -> np.ndarray:
        geom, body = model.geom(name).id, model.geom(name).bodyid[0]
        place, nominal = (
            one.geom_pos[geom] + (one.body_pos[body] if name[:3] == "pin" else 0) for one in (model, ideal)
        )
        return (place - nominal)[:2]

    for k in range(36):
        for name in (f"pin_{k + 1}", f"socket_{k + 1}"):
            assert moved(name) == pytest.approx(made.pin_displacement[k], abs=1e-15)
        assert model.geom(f"pin_{k + 1}").size[0] == pytest.approx(2.25e-3 + made.pin_radius[k], abs=1e-17)
        assert model.geom(f"socket_{k + 1}").size[0] == ideal.geom(f"socket_{k + 1}").size[0]
    for k in range(8):
        assert moved(f"hole_{k + 1}") == pytest.approx(made.hole_displacement[0, k], abs=1e-15)
    assert moved("cam") == pytest.approx([0.0, 4e-6], abs=1e-15)


# --- assembly


def test_the_free_room_of_an_ideal_reducer_is_its_smallest_clearance() -> None:
    for preset in CENTRAL.values():
        least = min(getattr(preset.clearance, kind) for kind in preset.pair_kinds if kind != preset.seat_pair)
        assert limits.best_fit(Reducer(preset), 0.7).min_gap == pytest.approx(least, rel=1e-6)


def test_the_best_pose_is_seen_by_the_collider() -> None:
    """A run starts in that pose: its deepest penetration is the room that lacks."""
    changes = ["errors.pin_position_um=2.0", "errors.eccentricity_um=6.0", "errors.hole_position_um=2.0"]
    start = ["drive.ramp_s=0.0", "drive.hold_s=1e-5", 'contact.stiffness_law="uniform"']
    for design in (pin(*changes, *start), nonpin(*changes[1:], "modification.pin_circle_um=-30.0", *start)):
        room = limits.best_fit(Reducer(design), 0.0).min_gap
        assert room < -1e-6
        # The polygon around the cam's circle: 1 - cos(pi/16) of its displacement, 6 um.
        assert simulate(design)["penetration"][0] == pytest.approx(-room, abs=0.15e-6)


def test_obstructing_free_pins_move_aside() -> None:
    design = override(
        PRESETS["pin"], ["errors.pin_y_um={1 = -3.0}", "drive.ramp_s=0.0", "drive.hold_s=1e-5", "clearance.cam_um=0.1"]
    )
    fit = limits.best_fit(Reducer(design), np.pi)
    assert fit.pin_shift.any()
    run = simulate(design)
    assert run["penetration"][0] < 1.2e-6


@pytest.mark.slow
def test_checks_report_parts_that_do_not_fit_together() -> None:
    def verdicts(*changes: str) -> dict[str, bool]:
        found = check(override(PRESETS["pin"], list(changes)))
        return {item.name: item.passed for item in found if item.name in ("assembly", "pin_in_socket")}

    assert verdicts() == {}
    assert verdicts("modification.rotation_arcsec=10") == {"pin_in_socket": True, "assembly": True}
    assert verdicts("errors.eccentricity_um=10") == {"pin_in_socket": True, "assembly": False}
    assert verdicts("errors.eccentricity_um=10", "clearance.cam_um=12") == {"pin_in_socket": True, "assembly": True}
    assert verdicts("errors.pin_dr_um={4 = 1.5}") == {"pin_in_socket": False, "assembly": True}
    assert verdicts("errors.pin_dr_um={4 = 1.5}", 'ring.pins="fixed"') == {"assembly": True}


# --- mechanics


@pytest.mark.parametrize("kind", [rig.FIXED, rig.NONPIN])
def test_equidistant_is_backlash_as_clearance_is(kind: str) -> None:
    """2 delta/(c (N-1)) with delta the sum of both."""
    tooth = "tooth" if kind == rig.NONPIN else "pin_gear"
    design = rig.design_of_kind(
        kind,
        *rig.without_friction(),
        *rig.without_gravity(),
        "clearance.cam_um=0.0001",
        "clearance.output_um=100.0",
        "drive.rotor_inertia_kg_m2=10.0",
        "settings.timestep_us=2.0",
        f"clearance.{tooth}_um=1.0",
        "modification.equidistant_um=1.5",
    )
    low, high = backlash.stop_angles(Reducer(design))
    assert high - low == pytest.approx(2 * 2.5e-6 / (1e-3 * 35), rel=0.005)


DISPLACED = {
    "fixed pins, cam and holes": (rig.FIXED, ["errors.eccentricity_um=2.0", "errors.hole_position_um=2.0"]),
    "free pins": (rig.FREE, ["errors.pin_position_um=1.0", "errors.pin_radius_um=0.2"]),
    "turned flanks": (rig.FIXED, ["modification.rotation_arcsec=8.0", "modification.pin_circle_um=-5.0"]),
    "waves, nonpin": (rig.NONPIN, ["errors.profile_cos_um={2 = 2.0}", "errors.profile_sin_um={5 = 1.0, 35 = 0.2}"]),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", DISPLACED)
def test_load_sharing_is_the_independent_solution(name: str) -> None:
    """At a standstill's pace, frictionless: forces of the teeth within 2 % of the largest."""
    kind, changes = DISPLACED[name]
    design = rig.design_of_kind(
        kind,
        *rig.without_friction(),
        *rig.without_gravity(),
        "load.torque_nm=36.0",
        "load.rise_s=0.003",
        "settings.timestep_us=2.0",
        "drive.speed_rpm=10.0",
        "drive.hold_s=0.006",
        "settings.log_rate_hz=2500.0",
        *changes,
    )
    compiled = build(design)
    run = simulate(design)
    stiffness = {kind: law.stiffness for kind, law in compiled.laws.items()}
    crank = float(run["crank_angle"][-1])
    ours = run.forces(design.tooth_pair)[-1]
    solved = equilibrium.solve(Reducer(design), stiffness, crank).ring_forces
    largest = rig.vector_lengths(solved).max()
    assert rig.vector_lengths(ours - solved).max() < 0.02 * largest
    # The control: the ideal reducer shares the load otherwise.
    ideal = rig.design_of_kind(kind, "load.torque_nm=36.0")
    assert (
        rig.vector_lengths(ours - equilibrium.solve(Reducer(ideal), stiffness, crank).ring_forces).max()
        > 0.04 * largest
    )


def test_every_disc_has_its_errors_and_the_first_those_of_a_single_disc() -> None:
    drawn = [
        *("errors.hole_position_um=1.0", "errors.disc_size_um=2.0", "errors.cam_position_um=0.5"),
        *("errors.pin_position_um=1.0", "errors.seed=7"),
    ]
    one, three = (deviations(override(PRESETS["pin"], [*drawn, f"gear.discs={count}"])) for count in (1, 3))
    assert three.hole_displacement.shape == (3, 8, 2)
    for name in ("hole_displacement", "disc_radius", "cam_displacement"):
        assert np.array_equal(getattr(three, name)[0], getattr(one, name)[0])
        assert len(np.unique(np.ravel(getattr(three, name)))) == getattr(three, name).size
    assert np.array_equal(three.pin_displacement, one.pin_displacement)


def test_listed_errors_continue_disc_after_disc() -> None:
    design = override(PRESETS["pin"], ["gear.discs=2", "errors.hole_x_um={10 = 3.0}", "errors.disc_dr_um=[0, 1]"])
    made = deviations(design)
    assert made.hole_displacement[1, 1, 0] == pytest.approx(3e-6)
    assert np.count_nonzero(made.hole_displacement) == 1
    np.testing.assert_allclose(made.disc_radius, [0.0, 1e-6])
    with pytest.raises(DesignError, match=r"has 8 values, but output\.pins times gear\.discs is 16"):
        override(PRESETS["pin"], ["gear.discs=2", f"errors.hole_x_um={[0.0] * 8}"])
