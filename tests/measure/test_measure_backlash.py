"""Backlash: the linear programme of rigid contacts against closed forms, the simulation against both."""

import json

import numpy as np
import pytest
from designs import cases

from cycloid_mj.base.errors import RunError, UsageError
from cycloid_mj.cli.app import main
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.measure import backlash, bench, rigid_backlash
from cycloid_mj.measure.backlash import PRESS, press_to_stops, with_single_clearance
from cycloid_mj.reducer import Reducer, limits

DESIGNS = {
    "free": PRESETS["pin"],
    "fixed": override(PRESETS["pin"], ['ring.pins="fixed"']),
    "sleeved": override(PRESETS["pin"], ['ring.pins="sleeved"']),
    "nonpin": PRESETS["nonpin"],
}
CASES = [(name, kind) for name, design in DESIGNS.items() for kind in design.pair_kinds]
CRANK = 1.7


def width(design: Design, crank: float = CRANK) -> float:
    low, high = limits.stops(Reducer(design), crank)
    return high - low


@pytest.mark.parametrize(("name", "kind"), CASES)
@pytest.mark.parametrize("crank", [0.0, 0.43, CRANK, 4.0])
def test_the_linear_programme_matches_each_closed_form(name: str, kind: str, crank: float):
    design = with_single_clearance(Reducer(DESIGNS[name]), kind)
    design = Reducer(design.design.model_copy(update={"clearance": _others(design.design, kind, 1e-12)}))
    # the others' 1e-6 um, and the cam's polygon
    assert width(design.design, crank) == pytest.approx(
        rigid_backlash.single_clearance_backlash(design, crank)[kind], rel=5e-5
    )


def _others(design: Design, kind: str, value: float):
    kinds = design.pair_kinds
    return design.clearance.model_copy(update={other: value for other in kinds if other != kind})


@pytest.mark.parametrize("name", ["free", "nonpin"])
def test_teeth_and_cam_alone_are_those_of_the_pitch_point(name: str):
    design = DESIGNS[name]
    parts = rigid_backlash.single_clearance_backlash(Reducer(design), CRANK)
    pitch = 2e-6 / (design.gear.eccentricity * design.lobes)
    assert parts["cam"] == pytest.approx(pitch, rel=1e-12)
    # the nearest pin is at most 5 deg of phase off the largest arm
    assert pitch <= parts[design.tooth_pair] < 1.01 * pitch


@pytest.mark.parametrize("name", ["free", "nonpin"])
def test_backlash_is_proportional_to_clearance_and_exceeds_the_sum_of_its_parts(name: str):
    design = DESIGNS[name]
    doubled = design.clearance.model_copy(update={k: 2.0 * v for k, v in design.clearance.model_dump().items()})
    assert width(design.model_copy(update={"clearance": doubled})) == pytest.approx(2.0 * width(design), rel=1e-9)
    assert width(design) > 1.05 * sum(rigid_backlash.single_clearance_backlash(Reducer(design), CRANK).values())


def test_thicker_pins_are_a_smaller_clearance_and_too_thick_ones_jam():
    design = override(DESIGNS["fixed"], [f"errors.pin_dr_um={[0.4] * 36}"])
    smaller = override(DESIGNS["fixed"], ["clearance.pin_gear_um=0.6"])
    assert width(design) == pytest.approx(width(smaller), rel=1e-9)
    with pytest.raises(RunError, match="jams"):
        limits.stops(Reducer(override(design, [f"errors.pin_dr_um={[1.2] * 36}"])), CRANK)


def test_holes_moved_all_equally_change_the_gaps_of_the_output_pins_along_the_eccentric_alone():
    across = override(DESIGNS["fixed"], [f"errors.hole_x_um={[0.1] * 8}", f"errors.hole_y_um={[0.0] * 8}"])
    along = override(DESIGNS["fixed"], [f"errors.hole_x_um={[0.0] * 8}", f"errors.hole_y_um={[0.1] * 8}"])
    closer = override(DESIGNS["fixed"], ["clearance.output_um=0.9"])
    # at crank 0 the eccentric is on +y, and each pin at the bottom of its hole
    assert width(across, 0.0) == pytest.approx(width(DESIGNS["fixed"], 0.0), rel=1e-9)
    assert width(along, 0.0) == pytest.approx(width(closer, 0.0), rel=1e-9)


@pytest.mark.parametrize(("name", "kind"), [case for case in CASES if case[0] in ("free", "nonpin")])
def test_simulated_backlash_of_one_clearance_is_its_closed_form(name: str, kind: str):
    design = with_single_clearance(Reducer(DESIGNS[name]), kind)
    found, closed = (
        press_to_stops(design, CRANK).backlash,
        rigid_backlash.single_clearance_backlash(design, CRANK)[kind],
    )
    # 0.4 % for pins, which the small torques press into their sockets; 0.06 % for cam and output pins
    within = 0.012 if kind.startswith(("pin", "tooth")) else 0.002
    assert found == pytest.approx(closed, rel=within)
    spoiled = design.design.clearance.model_copy(update={kind: 1.05 * getattr(design.design.clearance, kind)})
    wrong = rigid_backlash.single_clearance_backlash(
        Reducer(design.design.model_copy(update={"clearance": spoiled})), CRANK
    )[kind]
    assert found != pytest.approx(wrong, rel=within)


def test_backlash_does_not_depend_on_how_long_a_free_pin_is_pressed():
    design = with_single_clearance(Reducer(DESIGNS["free"]), "pin_gear")
    pressed = [press_to_stops(design, CRANK, time_factor=longer).backlash for longer in (1.0, 1.1)]
    assert pressed[0] == pytest.approx(pressed[1], rel=1e-3)


@pytest.mark.parametrize("name", cases(["free", "nonpin"], "nonpin"))
def test_simulated_backlash_of_all_clearances_is_the_linear_programme(name: str):
    design = bench.without_friction(Reducer(DESIGNS[name]))
    # 0.1 to 0.3 % is the press of the small torques that the line to zero does not take off
    found = press_to_stops(design, CRANK, time_factor=PRESS.all_clearances)
    assert found.backlash == pytest.approx(width(design.design), rel=0.006)


@pytest.mark.parametrize("eccentricity", [0.6, -0.6])
@pytest.mark.parametrize("crank", cases([0.0, CRANK], CRANK))
def test_a_larger_eccentricity_reduces_play_and_a_smaller_one_adds_it(eccentricity: float, crank: float):
    """The simulation moves the cam itself; the wrong sign would be 25 % off."""
    design = override(DESIGNS["fixed"], [f"errors.eccentricity_um={eccentricity}"])
    found = press_to_stops(bench.without_friction(Reducer(design)), crank, time_factor=PRESS.all_clearances)
    assert (found.low, found.high) == pytest.approx(limits.stops(Reducer(design), crank), rel=0.005)
    assert (width(design, crank) < width(DESIGNS["fixed"], crank)) == (eccentricity > 0.0)


def test_crank_angles_spread_over_turn_and_mesh_period():
    angles = bench.crank_angles(Reducer(PRESETS["pin"]), 8)
    phases = np.sort(np.mod(angles * 36 / (2.0 * np.pi), 1.0))
    np.testing.assert_allclose(phases, np.arange(8) / 8, atol=1e-9)
    assert np.all(np.diff(angles) > 0.7)
    assert angles[-1] < 2.0 * np.pi


@pytest.mark.slow
def test_the_command_writes_table_and_logs(tmp_path, capsys):
    flags = ["--set", 'ring.pins="fixed"', "--quick", "--json", "--quiet", "--out", str(tmp_path)]
    assert main(["measure", "backlash", "--design", "pin", *flags]) == 0
    told = json.loads(capsys.readouterr().out)
    whole = told["quantities"]["backlash"]
    assert whole["value"] == pytest.approx(whole["reference"], rel=0.03)
    # two angles of a turn: the error tells what they leave out, nearly all of the difference
    assert abs(whole["value"] - whole["reference"]) < whole["numerical_error"]
    assert whole["numerical_error"] > 0.003 * whole["value"]
    for key in ("backlash_min", "backlash_max"):
        one = told["quantities"][key]
        # the press that the line to zero does not take off is no numerical error
        assert abs(one["value"] - one["reference"]) < one["numerical_error"] + 0.003 * one["value"]
    curve = next(one for one in told["curves"] if one["name"] == "closed form")
    points = next(one for one in told["curves"] if one["name"] == "simulated")
    assert len(curve["x"]) > 5 * PRESETS["pin"].ring.teeth
    assert np.interp(points["x"], curve["x"], curve["y"]) == pytest.approx(points["y"], rel=0.005)
    assert len(told["angles"]) == 2
    assert told["angles"][0]["timestep_s"]["all"] == pytest.approx(35e-6)
    written = {path.name for path in tmp_path.iterdir()}
    assert {"backlash-pin.json", "backlash-pin-all.mcap"} <= written
    assert "backlash-pin.png" not in written  # no figure was asked for


def test_no_angle_is_a_usage_error():
    with pytest.raises(UsageError, match="angles = 0 "):
        backlash(PRESETS["pin"], 0)
