"""Transmission error: orders against made signals and rules, statics, one pin in error, and no error at all."""

import json

import numpy as np
import pytest
from designs import unlike

from cycloid_mj.analysis.spectrum import periodic_orders
from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.units import ARCSECONDS
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.geometry.ideal_loads import ideal_load_sharing
from cycloid_mj.measure.orders import Cause, causes
from cycloid_mj.measure.te import te
from cycloid_mj.measure.trace import TraceCondition, run_trace
from cycloid_mj.measure.vibration import vibration
from cycloid_mj.parts.gear import tooth_profile
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.gaps import arc_gaps, cam_displacements
from cycloid_mj.statics import transmission_error
from cycloid_mj.validate import equilibrium

N, LOBES, HOLES = 36, 35, 8
AGAINST_GEAR = N / LOBES
PAIRS = ("pin_gear", "pin_socket", "tooth", "cam", "output")
SMOOTH = [*(f"friction.{pair}=0.0" for pair in PAIRS), "environment.gravity_y_m_s2=0.0"]
CLOSED = [f"clearance.{pair}_um=0.001" for pair in PAIRS]
TURN = 2.0 * np.pi * np.arange(12 * N + 1) / (12 * N)


def fixed(*changes: str) -> Design:
    return override(PRESETS["pin"], ['ring.pins="fixed"', *changes])


def cause(key: str) -> Cause:
    return next(one for one in causes(Reducer(fixed())) if one.key == key)


def shares(design: Design, place: str, base: float) -> dict[int, float]:
    """Amplitudes [arcsec] of the multiples of a base order in the elastic error under the rated load."""
    gear, output = ARCSECONDS * transmission_error(Reducer(design), TURN, 36.68).T
    found = periodic_orders(TURN, gear if place == "gear" else output - gear, base, 80.0)
    return {round(order / base): float(size) for order, size in zip(found.order, found.amplitude, strict=True)}


def test_each_order_has_one_cause() -> None:
    for place, base in (("gear", 1.0), ("stage", AGAINST_GEAR)):
        for multiple in range(1, 100):
            found = [one.key for one in causes(Reducer(fixed())) if one.signal == place and one.has(base * multiple)]
            assert len(found) <= 1
            if place == "gear":
                assert found == ["ring" if multiple % N else "mesh"]
    assert not cause("ring").has(AGAINST_GEAR)
    assert cause("eccentricity").has(HOLES * AGAINST_GEAR)
    assert cause("holes").has(AGAINST_GEAR)


def kinematic_error(design: Design, crank: np.ndarray) -> np.ndarray:
    """Turn [rad] at which the first rigid tooth stops a gear that is centred on the cam, pressed counter-clockwise."""
    found = arc_gaps(Reducer(design), crank)
    teeth = found.kind == design.tooth_pair
    at_cam = np.einsum("kni,ki->kn", found.slope[:, teeth, :2], cam_displacements(Reducer(design), crank)[:, 0])
    gap, closing = found.width[:, teeth] + at_cam, -design.output.pin_circle_radius * found.slope[:, teeth, 2]
    return np.min(np.divide(gap, closing, out=np.full(gap.shape, np.inf), where=closing > 0.0), axis=1)


@pytest.mark.parametrize("around", [1, 5])
def test_an_error_that_orbits_the_ring_has_its_own_orders(around: int) -> None:
    made = 0.05 * np.cos(2.0 * np.pi * around * np.arange(N) / N)
    exact = [*SMOOTH, *CLOSED, 'contact.stiffness_law="uniform"', "stiffness.cam_n_m=1e12"]
    found = shares(fixed(*exact, f"errors.pin_dr_um={made.tolist()}"), "gear", 1.0)
    own = {k: size for k, size in found.items() if k % N in (around, N - around)}
    other = {k: size for k, size in found.items() if k % N and k % N not in (around, N - around)}
    assert own[around] > 0.02
    # What is left comes from the output pins' stage through the cam's give, and from contacts that open.
    assert max(other.values()) < 0.05 * own[around]


def test_holes_and_eccentricity_give_the_orders_that_are_stated() -> None:
    calm = shares(fixed(*SMOOTH, *CLOSED), "stage", AGAINST_GEAR)
    hole = shares(fixed(*SMOOTH, *CLOSED, "errors.hole_x_um={1=0.5}"), "stage", AGAINST_GEAR)
    wide = [*SMOOTH, "clearance.output_um=3.0"]
    eccentric = shares(fixed(*wide, "errors.eccentricity_um=1.0"), "stage", AGAINST_GEAR)
    assert hole[1] > 10.0 * calm[1]
    alike = {k: size for k, size in eccentric.items() if k % HOLES == 0}
    apart = {k: size for k, size in eccentric.items() if k % HOLES and k % LOBES}
    assert max(alike.values()) > 10.0 * max(apart.values())


def test_statics_without_clearance_is_ideal_load_sharing() -> None:
    """A stiff cam and stiff output pins leave the mesh alone: the gear turns by T / (K sum l^2)."""
    stiff = ['contact.stiffness_law="uniform"', "stiffness.pin_gear_n_m=1e7", "stiffness.cam_n_m=1e12"]
    design = fixed(*SMOOTH, *(f"clearance.{pair}_um=1e-6" for pair in PAIRS), *stiff, "stiffness.output_n_m=1e12")
    crank = np.linspace(0.0, 2.0 * np.pi / N, 7)
    turned = transmission_error(Reducer(design), crank, 0.1)[:, 0]
    arms = ideal_load_sharing(tooth_profile(design), 0.1, crank).arms
    ideal = 0.1 / (1e7 * np.sum(np.where(arms < 0.0, arms**2, 0.0), axis=-1))
    # The cam gives 1e-5 as much as the teeth; at ten times the load the normals' turning shows, by 1e-3.
    assert turned == pytest.approx(ideal, rel=3e-4)


@pytest.mark.parametrize("changes", [['ring.pins="fixed"', "errors.pin_y_um={1=-2.0}"], ['ring.kind="nonpin"']])
def test_statics_agrees_with_the_independent_solution(changes: list[str]) -> None:
    """`validation.equilibrium` takes the exact gaps in the displaced pose, flanks included; ours is linear."""
    design = override(PRESETS["pin"], [*SMOOTH, "load.torque_nm=36.0", *changes])
    stiffness = {kind: law.stiffness for kind, law in build(design).laws.items()}
    for crank in (4.2, 5.0):
        solved = equilibrium.solve(Reducer(design), stiffness, crank)
        gear, output = transmission_error(Reducer(design), crank, 36.0)[0]
        assert gear == pytest.approx(solved.gear_turn, rel=0.005)
        assert output == pytest.approx(solved.output_turn, rel=0.005)


@pytest.mark.slow
def test_one_pin_in_error_shows_as_its_displacement_over_its_arm() -> None:
    """Cam and output pins are without play, so the pin in the way stops the gear alone: n . d / l."""
    tight = ["clearance.cam_um=0.01", "clearance.output_um=0.01", "clearance.pin_gear_um=8.0"]
    design = fixed(*tight, "errors.pin_y_um={1=-5.0}")
    found = run_trace(Reducer(design), build(design), 1.0, TraceCondition("unloaded", "forward", "slow", 0.1, 30.0))
    rigid = ARCSECONDS * kinematic_error(design, found.crank)
    assert np.ptp(found.gear) == pytest.approx(np.ptp(rigid), rel=0.05)
    assert np.std(found.gear) == pytest.approx(np.std(rigid), rel=0.05)
    seen, ideal = (periodic_orders(found.crank, error, 1.0, 40.0).amplitude for error in (found.gear, rigid))
    assert seen[:2] == pytest.approx(ideal[:2], rel=0.05)
    assert cause("ring").strongest(periodic_orders(found.crank, found.gear, 1.0, 40.0))[0] == 1.0
    # The neighbouring pin would show a pitch earlier, a pin that is pulled out not at all.
    for spoiled in ("errors.pin_y_um={2=-5.0}", "errors.pin_y_um={1=5.0}"):
        wrong = ARCSECONDS * kinematic_error(override(fixed(*tight), [spoiled]), found.crank)
        assert np.std(found.gear - wrong) > 5.0 * np.std(found.gear - rigid)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pin", "nonpin"])
def test_no_error_no_load_and_no_clearance_leave_no_transmission_error(name: str) -> None:
    """Weight is a load: the gear's, which goes round in its frame, winds it up by 0.05 arcsec once a turn."""
    pins = ['ring.pins="fixed"'] if name == "pin" else []
    design = Reducer(override(PRESETS[name], [*pins, *CLOSED, "environment.gravity_y_m_s2=0"])).at_rated_load
    found = run_trace(
        design,
        build(design.design),
        1.0,
        TraceCondition("unloaded", "forward", "speed", 0.0, design.design.drive.speed),
    )
    assert np.ptp(found.gear) < 0.02
    assert np.ptp(found.output) < 0.02


def test_the_measure_has_both_directions_both_loads_and_errors() -> None:
    design = fixed("settings.timestep_us=10.0", *SMOOTH)
    done: list[int] = []
    found = te(design, slow=design.drive.speed / 2.0, progress=lambda count, whole: done.append(whole - count))
    assert done[-1] == 0
    for shaft in ("gear", "output"):
        for pace in ("slow", "speed"):
            ahead, back = (found[f"{shaft}_rms_loaded_{way}_{pace}"] for way in ("forward", "reverse"))
            # Both ways are mirror images, but for where the holes are in the turn.
            assert back == pytest.approx(ahead, rel=0.006)
    level = found.quantities["output_peak_to_peak_loaded_forward_slow"]
    assert level.error is not None
    assert level.error < 0.015 * level.value
    assert level.value == pytest.approx(level.reference, rel=0.11)
    assert found["output_wind_up"] == pytest.approx(found.quantities["output_wind_up"].reference, rel=0.002)
    assert found["gear_reversal"] == pytest.approx(found.quantities["gear_reversal"].reference, rel=0.0012)
    told = json.loads(json.dumps(found.as_json(), allow_nan=False))
    assert {one["key"] for one in told["orders"]["causes"]} == {"mesh", "ring", "holes", "eccentricity"}
    assert len(found.runs) == len(told["orders"]["cases"]) == 8


def test_te_and_vibration_refuse_a_crank_at_rest() -> None:
    for measure in (te, vibration):
        with pytest.raises(DesignError, match=r"drive\.speed_rpm is 0"):
            measure(fixed("drive.speed_rpm=0.0"))


@pytest.mark.parametrize("name", ["large", "few"])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_statics_converges_from_the_ideal_pose_of_any_reducer(name: str, way: float) -> None:
    """A step past the middle of a valley's circle would leave the large reducer without a balance at 0.1 rad."""
    design = unlike(name)
    found = transmission_error(Reducer(design), [0.1], way * design.rated_torque)[0]
    near = transmission_error(Reducer(design), np.linspace(0.0, 0.1, 6), way * design.rated_torque)[-1]
    assert found == pytest.approx(near, rel=1e-4)
    assert way * found[1] > way * found[0] > 0.0


@pytest.mark.slow
def test_turns_too_few_to_separate_all_orders_are_reported() -> None:
    """Over one crank turn the orders of output pins are beside whole ones, said of by an assumption alone."""
    few = fixed("ring.teeth=9")
    lobes = few.lobes
    for turns in (1, lobes):
        found = te(few, turns=turns, quick=True)
        orders = found.details["orders"]
        assert (orders["turns"], orders["turns_that_part_orders"]) == (turns, lobes)
        assert orders["apart"] == (turns == lobes)
        notes = [one.note for key, one in found.quantities.items() if "_orders_rms_" in key]
        assert notes
        assert all((f"over 1 of {lobes} crank turns" in note) == (turns == 1) for note in notes)
