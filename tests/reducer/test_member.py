"""The ring as the output: the same drive seen from another frame, in closed forms, statics and dynamics."""

import math

import numpy as np
import pytest
from designs import cases

from cycloid_mj.analysis import analyze
from cycloid_mj.analysis.series import design_of
from cycloid_mj.base.names import FORCE_X, FORCE_Y
from cycloid_mj.base.record import Run
from cycloid_mj.base.units import ARCSECONDS
from cycloid_mj.checks import check
from cycloid_mj.design import PRESETS, Design
from cycloid_mj.design.model import NO_FRICTION
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.geometry.kinematics import point_path
from cycloid_mj.geometry.modification import tooth_profile
from cycloid_mj.measure import bench, hysteresis, rigid_backlash
from cycloid_mj.measure.backlash import press_to_stops
from cycloid_mj.measure.closed_form import ideal_efficiency
from cycloid_mj.measure.orders import causes
from cycloid_mj.measure.te_table import quantities
from cycloid_mj.measure.trace import ErrorCurves, TraceCondition, run_trace
from cycloid_mj.parts import body_solids, mass_properties, turning_inertia
from cycloid_mj.reducer import Reducer, member
from cycloid_mj.reducer.limits import best_fit, stops
from cycloid_mj.scene.drawing import measure_gaps
from cycloid_mj.scene.force import contact_forces
from cycloid_mj.scene.pose import poses
from cycloid_mj.statics import loads, powers, springs_of, transmission_error
from cycloid_mj.statics.structure import wind_up
from cycloid_mj.statics.windup import solve_windups, split_in_series
from cycloid_mj.stress.loads import part_loads

PIN, PRINTED = PRESETS["pin"], PRESETS["printed"]
RING = {"member": "ring"}
FREE_OF_LOSSES = {
    "friction": NO_FRICTION,
    "environment": {"gravity_x": 0.0, "gravity_y": 0.0},
}


def turned_over(design: Design) -> Design:
    """Return the design with its ring as the output, at the same speeds and, without losses, torques in the mesh."""
    more = design.ring.teeth / design.lobes
    return design.but(
        output=RING, drive={"speed": more * design.drive.speed}, load={"torque": more * design.load.torque}
    )


def rotated(vectors, angle):
    """Turn vectors (n, 2) by angles (n,), counter-clockwise."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = vectors.T
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)


# --- closed forms -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("pins", ["free", "fixed", "massless"])
def test_the_bodies_of_the_output_turn_with_the_carrier_or_the_ring(pins: str) -> None:
    design = PRESETS["twodisc"].but(ring={"pins": pins})
    solids = {name: mass_properties(solid) for name, solid in body_solids(Reducer(design)).items()}
    about = {name: one.inertia[2, 2] for name, one in solids.items()}
    carrier = about["output"] + about["gear_1"] + about["gear_2"]
    assert turning_inertia(Reducer(design)) == pytest.approx(carrier, rel=1e-9)
    orbit = solids["pin"].mass * design.ring.pin_circle_radius**2
    ring = about["housing"] + design.ring.teeth * (about["pin"] + orbit)
    assert turning_inertia(Reducer(design.but(output=RING))) == pytest.approx(ring, rel=1e-9)


@pytest.mark.parametrize("design", [PIN, PRINTED, PRESETS["nonpin"]])
def test_willis(design: Design) -> None:
    ring, theta = design.but(output=RING), np.linspace(-7.0, 9.0, 5)
    assert (design.ratio, ring.ratio) == (-design.lobes, design.ring.teeth)
    assert ring.rated_torque == pytest.approx(design.drive.torque * design.ring.teeth)
    assert (Reducer(design).mesh_periods, Reducer(ring).mesh_periods) == (design.ring.teeth, design.ring.teeth - 1)
    for one in (design, ring):
        # of both: seen from the ring the carrier turns by -1/(N - 1) of the crank
        about = Reducer(one).member.ring_angle(theta)
        ring_turn, carrier_turn = Reducer(one).member.ring_and_carrier(Reducer(one).member.output_angle(theta))
        assert ring_turn == pytest.approx(about, abs=1e-14)
        assert carrier_turn == pytest.approx(Reducer(one).member.gear_angle(theta), abs=1e-14)
        assert Reducer(one).member.gear_angle(theta) - about == pytest.approx(-(theta - about) / one.lobes, abs=1e-14)
        assert Reducer(one).member.against_ring(theta) == pytest.approx(theta - about, abs=1e-14)
    assert Reducer(ring).member.output_angle(theta) == pytest.approx(theta / design.ring.teeth)
    seen = member.view_from_ring(turned_over(design))
    assert seen.drive.speed == pytest.approx(design.drive.speed)
    assert seen == design.but(drive={"speed": seen.drive.speed}, load={"torque": seen.load.torque})


def test_the_points_of_a_gear_that_does_not_turn_run_on_circles() -> None:
    gear, theta, speed, rise = tooth_profile(PIN), np.array([0.3, 2.0]), 5.0, 2.0
    found = point_path(gear, (0.01, 0.02), theta, speed, rise, turning=False)
    middle = np.array([0.01, 0.02 - gear.eccentricity])
    assert np.linalg.norm(found.position - middle, axis=1) == pytest.approx(gear.eccentricity)
    h = 1e-4
    at = [point_path(gear, (0.01, 0.02), theta + s * h, turning=False).position for s in (-1, 1)]
    assert found.velocity == pytest.approx(speed * (at[1] - at[0]) / (2 * h), rel=1e-6)
    size = gear.eccentricity * math.hypot(speed**2, rise)
    assert np.linalg.norm(found.acceleration, axis=1) == pytest.approx(size)


# --- statics ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("design", [PIN, PRINTED])
def test_stops_of_the_ring_are_those_of_the_carrier_times_the_ratio_of_ratios(design: Design) -> None:
    errors = design.but(errors={"pin_position": 5e-7, "hole_position": 5e-7})
    ring, of = errors.but(output=RING), errors.lobes / errors.ring.teeth
    for theta in (0.0, 1.0):
        low, high = stops(Reducer(errors), float(Reducer(ring).member.against_ring(theta)))
        assert stops(Reducer(ring), theta) == pytest.approx((-of * high, -of * low), rel=1e-9)
        assert best_fit(Reducer(ring), theta).min_gap == pytest.approx(
            best_fit(Reducer(errors), theta / (1 + 1 / errors.lobes)).min_gap
        )


def test_forces_stiffness_and_working_forces_are_those_of_the_mesh() -> None:
    ring = turned_over(PIN.but(load={"torque": 30.0}, drive={"speed": 1.0}, **FREE_OF_LOSSES))
    carrier, more = member.view_from_ring(ring), PIN.ring.teeth / PIN.lobes
    for kind in PIN.pair_kinds:
        assert Reducer(ring).contacts[kind].force == pytest.approx(Reducer(carrier).contacts[kind].force)
    theta = np.linspace(0.0, 6.0, 7)
    own = loads(Reducer(ring), springs_of(Reducer(ring), theta), 30.0 * more)
    same = loads(Reducer(carrier), springs_of(Reducer(carrier), Reducer(ring).member.against_ring(theta)), 30.0)
    for name in ("teeth", "output"):
        assert getattr(own, name) == pytest.approx(getattr(same, name), rel=2e-4, abs=0.02), name
    assert own.output_turn == pytest.approx(same.output_turn / more, rel=1e-3)
    assert own.gear_turn == pytest.approx(same.output_turn - same.gear_turn, rel=1e-3)
    theta = float(Reducer(ring).member.against_ring(0.5))
    wound = solve_windups(Reducer(ring), [0.5], 30.0 * more)[0], solve_windups(Reducer(carrier), [theta], 30.0)[0]
    stiff = [1.0 / one.compliance(one.turn) for one in wound]
    assert stiff[0] == pytest.approx(more**2 * stiff[1], rel=1e-6)


@pytest.mark.parametrize("torque", [30.0, -30.0])
def test_efficiency_follows_from_the_carriers_by_the_balance_of_power(torque: float) -> None:
    slowly = {"gravity_x": 0.0, "gravity_y": 0.0}
    level = PIN.but(environment=slowly, ring={"pins": "fixed"}, drive={"speed": 1.0})
    ring = level.but(output=RING, load={"torque": abs(torque)})
    own = powers(Reducer(ring), torque)
    crank, slow = own.crank / ring.drive.speed, ring.drive.speed / ring.ring.teeth
    held = torque - crank
    assert own.output == pytest.approx(-torque * slow)
    assert own.crank + own.output == pytest.approx(sum(own.friction.values()))
    # the carrier's drive at the same speeds, under what holds the carrier here, takes the same torque on its crank
    seen = member.view_from_ring(ring)
    same = powers(Reducer(seen), held)
    assert same.crank / seen.drive.speed == pytest.approx(crank, rel=1e-4)
    if torque > 0.0:
        known = (1.0 + level.lobes * same.efficiency) / level.ring.teeth
        assert own.efficiency == pytest.approx(known, rel=1e-5)
        assert own.efficiency > same.efficiency
    else:
        assert own.efficiency < 1.0


def test_weight_turns_round_the_ring() -> None:
    ring = PIN.but(output=RING, drive={"speed": 0.0})
    # a quarter of a turn of the ring, seen from which the weight has turned back
    force = springs_of(Reducer(ring), [0.0, 9.0 * 2.0 * math.pi], friction=False).body_force[:, 0]
    assert force[0, 1] < 0.0
    assert force == pytest.approx(np.array([[0.0, force[0, 1]], [force[0, 1], 0.0]]), abs=1e-9)


def test_checks_judge_the_same_mesh() -> None:
    """The joints alone differ: a motor on the cover turns with the ring."""
    failed = [[one.name for one in check(design) if not one.passed] for design in (PIN, PIN.but(output=RING))]
    assert failed[1] == [*failed[0], "joints"]
    assert [one.name for one in check(PRINTED.but(output=RING)) if not one.passed] == ["joints"]


# --- dynamics ---------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("kind", cases(["fixed pins", "free pins", "internal gear"], "fixed pins", "internal gear"))
def test_superposed_rotation_does_not_change_tooth_forces(kind: str) -> None:
    changes = {"internal gear": {"kind": "nonpin"}}.get(kind, {"pins": kind.partition(" ")[0]})
    step = 2e-6 if kind == "free pins" else 10e-6
    carrier = PIN.but(
        ring=changes,
        load={"torque": PIN.rated_torque},
        drive={"ramp": 0.0, "hold": 0.018},
        settings={"timestep": step},
        **FREE_OF_LOSSES,
    )
    ring = turned_over(carrier)
    held, turning = simulate(carrier), simulate(ring)
    judged = held.time > 0.01
    assert turning["crank_angle"] - turning["output_angle"] == pytest.approx(held["crank_angle"], abs=5e-4)
    for pair_kind in carrier.pair_kinds:
        if pair_kind == "pin_socket":  # its force is that of the pin's inertia as well
            continue
        ones, others = (_forces(run, pair_kind) for run in (held, turning))
        seen = {name: rotated(force, -turning["output_angle"]) for name, force in others.items()}
        apart = np.concatenate([(ones[name] - seen[name])[judged] for name in ones])
        size = np.concatenate([ones[name][judged] for name in ones])
        assert np.linalg.norm(apart) < 0.004 * np.linalg.norm(size), pair_kind
        plain = np.concatenate([(ones[name] - others[name])[judged] for name in ones])
        assert np.linalg.norm(plain) > 0.01 * np.linalg.norm(size), pair_kind
    found = analyze(turning, settle=0.01)
    assert found.output_speed.mean_rad_s == pytest.approx(ring.drive.speed / ring.ring.teeth, rel=1e-3)
    assert found.gear_speed.theory_rad_s == 0.0
    assert found.efficiency == pytest.approx(1.0, abs=0.002)
    assert found.power.crank_torque_nm == pytest.approx(found.power.ideal_crank_torque_nm, rel=0.002)
    assert found.q_path.rms_error_um < 20.0


def _forces(run: Run, kind: str):
    """Map pair to force (n, 2) of a kind."""
    return {name: run.block([f"{name}_{FORCE_X}", f"{name}_{FORCE_Y}"]) for name in run.pairs(kind)}


# --- measures ---------------------------------------------------------------------------------------------------------

RIGID = PIN.but(ring={"pins": "fixed"})


@pytest.fixture(scope="module")
def at_the_ring() -> Design:
    return RIGID.but(output=RING)


@pytest.mark.slow
@pytest.mark.parametrize("turning", cases(["carrier", "ring"], "ring"))
def test_structural_twist_rotates_the_output_only(turning: str) -> None:
    """A carrier that twists more changes the output's turn alone, in statics and in a run, forward and in reverse."""
    stiff = PRESETS["twodisc"].but(output={"member": turning}, friction=FREE_OF_LOSSES["friction"])
    torque = stiff.rated_torque
    stiff = Reducer(stiff).working_at(torque).design
    soft = stiff.but(springs={"carrier": 1e5})
    more = wind_up(Reducer(soft)) - wind_up(Reducer(stiff))
    assert more > 5e-6
    found = [solve_windups(Reducer(one), [0.7], torque)[0] for one in (stiff, soft)]
    parts = [one.series(Reducer(design)) for one, design in zip(found, (stiff, soft), strict=True)]
    assert parts[1] == pytest.approx(parts[0] | {"output": parts[0]["output"] + more}, rel=1e-6)
    assert found[1].gear_turn == pytest.approx(found[0].gear_turn, rel=1e-9)
    for way, sign in (("forward", 1.0), ("reverse", -1.0)):
        case = TraceCondition("loaded", way, "speed", torque, sign * stiff.drive.speed)
        first, second = (run_trace(Reducer(one), build(one), 0.02, case) for one in (stiff, soft))
        twist = sign * Reducer(stiff).member.sense * more * torque * ARCSECONDS
        assert second.output - first.output == pytest.approx(np.full(first.output.size, twist), rel=1e-3)
        assert second.gear == pytest.approx(first.gear, rel=1e-4)
        solved = (
            ARCSECONDS * Reducer(stiff).member.sense * transmission_error(Reducer(soft), second.crank, sign * torque)
        )
        assert second.gear.mean() == pytest.approx(solved[:, 0].mean(), rel=0.05)
        assert second.output.mean() == pytest.approx(solved[:, 1].mean(), rel=0.05)


def test_backlash_at_the_ring_is_measured_as_the_programme_has_it(at_the_ring) -> None:
    found, known = (
        press_to_stops(bench.without_friction(Reducer(at_the_ring)), 0.7, time_factor=4.0).backlash,
        stops(Reducer(at_the_ring), 0.7),
    )
    assert found == pytest.approx(known[1] - known[0], rel=0.005)
    parts = rigid_backlash.single_clearance_backlash(Reducer(at_the_ring), 0.7)
    gear, clearance = at_the_ring.gear, at_the_ring.clearance
    assert parts["cam"] == pytest.approx(2.0 * clearance.cam / (gear.eccentricity * at_the_ring.ring.teeth))


def test_the_loop_at_the_ring_has_the_slope_of_statics(at_the_ring) -> None:
    level = bench.without_friction(Reducer(at_the_ring)).working_at(at_the_ring.rated_torque)
    rated = level.design.rated_torque
    loop = hysteresis.run_loop(level, 0.7, rated, hysteresis.quasi_static_period(level, rated), 1.0)
    known = solve_windups(level, [0.7], rated)[0]
    assert loop.lost_motion == pytest.approx(known.lost_motion, rel=0.005)
    assert loop.compliance() == pytest.approx(known.compliance(known.turn), rel=0.01)
    seen = split_in_series(level, loop.compliance(), loop.compliance(loop.gear_turn), loop.compliance(loop.centre_lead))
    assert seen == pytest.approx(known.series(level), rel=0.02)
    assert sum(seen.values()) == pytest.approx(loop.compliance())


def test_the_transmission_error_of_the_ring_is_that_of_statics(at_the_ring) -> None:
    slow = at_the_ring.but(drive={"speed": 20.0})
    case = TraceCondition("loaded", "forward", "slow", slow.rated_torque, slow.drive.speed)
    free = slow.but(friction=FREE_OF_LOSSES["friction"])
    compiled = build(free.but(load={"torque": case.torque}))
    periods, loaded = 3 / Reducer(slow).mesh_periods, Reducer(free.but(contact={"working_load": case.torque}))
    found = run_trace(loaded, compiled, periods, case)
    solved = transmission_error(loaded, found.crank, case.torque)
    theory = ARCSECONDS * Reducer(free).member.sense * solved
    assert found.gear == pytest.approx(theory[:, 0], abs=0.02 * np.abs(theory[:, 0]).max())
    assert found.output == pytest.approx(theory[:, 1], abs=0.02 * np.abs(theory[:, 1]).max())
    assert found.output.mean() < 0.0


@pytest.mark.parametrize("turning", ["carrier", "ring"])
def test_backlash_and_wind_up_are_positive_in_both_directions(turning: str) -> None:
    """An output that lags by 5 arcsec of play and 30 of wind-up: behind the crank's sense for the ring, before it."""
    design = RIGID.but(output={"member": turning})
    points, lag = 8 * 35 * 36, {"unloaded": 5.0, "loaded": 35.0}
    crank = 2.0 * np.pi * (36 if turning == "ring" else 35) * np.arange(points) / points
    made = {
        TraceCondition(load, way, "speed", 1.0, sign): ErrorCurves(
            crank, *2 * [np.full(points, sign * Reducer(design).member.sense * lag[load])]
        )
        for load in lag
        for way, sign in (("forward", 1.0), ("reverse", -1.0))
    }
    found = {one.key: one for one in quantities(Reducer(design), made, {}, made, 1)}
    for shaft in ("gear", "output"):
        assert (found[f"{shaft}_reversal"].value, found[f"{shaft}_reversal"].reference) == pytest.approx((10.0, 10.0))
        assert (found[f"{shaft}_wind_up"].value, found[f"{shaft}_wind_up"].reference) == pytest.approx((30.0, 30.0))


def test_causes_of_orders_at_the_ring() -> None:
    own = {cause.key: cause for cause in causes(Reducer(PIN.but(output=RING)))}
    assert own["mesh"].has(35.0)
    assert not own["mesh"].has(36.0)
    assert own["ring"].has(35.0 / 36.0)
    assert own["holes"].has(1.0)
    assert own["eccentricity"].has(8.0)
    assert {key: cause.signal for key, cause in own.items()} == {
        "mesh": "stage", "ring": "stage", "holes": "gear", "eccentricity": "gear",
    }  # fmt: skip


def test_the_closed_form_of_efficiency_at_the_ring_is_its_balance_of_power() -> None:
    ring = RIGID.but(output=RING, drag={"crank": 0.01})
    carrier = ideal_efficiency(Reducer(RIGID), 30.0).efficiency
    own = ideal_efficiency(Reducer(ring.but(drag={"crank": 0.0})), 30.0).efficiency
    assert own == pytest.approx((1.0 + 35.0 * carrier) / 36.0)
    supplied = 30.0 / own + 0.01 * 36.0
    assert ideal_efficiency(Reducer(ring), 30.0).efficiency == pytest.approx(30.0 / supplied)


# --- pictures and parts -----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def turning() -> Run:
    """Run a ring under its load, with friction and weight, for a turn of the crank from it and a little more."""
    steady = RIGID.but(output=RING, load={"torque": 30.0})
    return simulate(steady.steady(0.012, 1.05 / Reducer(steady).share))


def test_columns_seen_from_the_ring_are_those_of_a_carrier(turning) -> None:
    design = design_of(turning)
    seen, carrier = member.view_columns_from_ring(Reducer(design), turning.columns), member.view_from_ring(design)
    late = turning.time > 0.008
    slow = Reducer(carrier).member.output_angle(seen["crank_speed"])
    assert seen["output_speed"][late] == pytest.approx(slow[late], abs=0.02 * abs(slow).max())
    assert seen["gear_speed"][late] == pytest.approx(slow[late], abs=0.02 * abs(slow).max())
    step = float(np.diff(turning.time).mean())
    for name, speed in (("gear_x", "gear_vx"), ("gear_y", "gear_vy"), ("gear_angle", "gear_speed")):
        assert np.gradient(seen[name], step)[late] == pytest.approx(seen[speed][late], rel=0.01, abs=2e-3), name
    middle = np.hypot(seen["gear_x"], seen["gear_y"])
    assert middle == pytest.approx(np.hypot(turning["gear_x"], turning["gear_y"]))
    assert seen["load_torque"][late].mean() == pytest.approx(30.0 - turning["crank_torque"][late].mean(), rel=1e-6)
    assert member.view_columns_from_ring(Reducer(RIGID), turning.columns) == turning.columns


def test_the_housing_and_its_pins_turn_and_the_carrier_does_not(turning) -> None:
    design = design_of(turning)
    place, last = poses(Reducer(design), turning.columns), turning["output_angle"][-1]
    assert last > 0.1
    assert place["housing"][-1] == pytest.approx([0.0, 0.0, last])
    assert place["output"][:, 2] == pytest.approx(np.zeros(len(turning)))
    radius = design.ring.pin_circle_radius
    assert place["pin_1"][-1] == pytest.approx([-radius * math.sin(last), radius * math.cos(last), last])
    # forces act where the pins are: towards the pitch point, from there
    acting = contact_forces(Reducer(design), turning.columns).of("pin_gear")
    pressed = acting.size[-1] > 1.0
    assert pressed.sum() > 5
    centres = np.stack([place[f"pin_{number}"][-1, :2] for number in range(1, 37)])
    assert np.linalg.norm(acting.point[-1] - centres, axis=1)[pressed] == pytest.approx(
        design.ring.pin_radius, rel=0.01
    )


def test_the_mechanism_is_drawn_as_its_ring_sees_it(turning) -> None:
    design = design_of(turning)
    seen = member.view_columns_from_ring(Reducer(design), turning.columns)
    measured = measure_gaps(Reducer(member.view_from_ring(design)), seen)
    late = turning.time > 0.008
    assert np.abs(measured.deviation[late, :2]).max() < 20e-6
    assert np.abs(measured.opening[late]).max() < 60e-6
    pressed = np.hypot(turning["pin_9_force_x"], turning["pin_9_force_y"]) > 50.0
    assert pressed.any()
    # a pin that is pressed is nearer than its clearance
    assert measured.opening[pressed & late, 8].max() < -0.9 * design.clearance.pin_gear


@pytest.mark.parametrize("part", ["gear", "shaft", "output", "ring"])
def test_the_loads_on_a_part_are_in_balance(turning, part: str) -> None:
    found = part_loads(turning, Reducer(design_of(turning)), part, np.radians(np.arange(0.0, 360.0, 15.0)))
    assert np.abs(found.force).max() > 50.0
    if part in ("output", "ring"):
        arms = found.position[..., 0] * found.force[..., 1] - found.position[..., 1] * found.force[..., 0]
        held = -30.0 if part == "ring" else 30.0 - turning["crank_torque"][turning.time > 0.008].mean()
        assert abs(np.nansum(arms, axis=1).mean()) == pytest.approx(abs(held), rel=0.01)
