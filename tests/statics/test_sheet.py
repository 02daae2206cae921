"""The data sheet of statics: against the dynamic runs, on designs of every kind, and its command."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from designs import CENTRAL, design_file, unlike

from cycloid_mj.base.errors import DesignError, RunError, UsageError
from cycloid_mj.base.powers import mean_powers
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, Design, load, override
from cycloid_mj.measure import steady
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import Loads, loads, powers, springs_of
from cycloid_mj.statics.sheet import (
    KNOWN_DIFFERENCES,
    KNOWN_DIFFERENCES_OF_KINDS,
    known_difference,
    quick_sheet,
    sheet,
    sheet_part,
)
from cycloid_mj.statics.springs import Springs, turn_evenly
from cycloid_mj.statics.structure import wind_up
from cycloid_mj.statics.windup import Windup, solve_windups

MEASURED = json.loads((Path(__file__).parents[1] / "data" / "measured.json").read_text())
FIXED = override(PRESETS["pin"], ['ring.pins="fixed"'])
SLEEVED = override(PRESETS["pin"], ['ring.pins="sleeved"'])
KINDS = {**CENTRAL, "fixed": FIXED, "sleeved": SLEEVED}


@pytest.mark.parametrize("name", MEASURED)
def test_known_differences_are_those_of_the_measured_runs(name: str) -> None:
    """The service loop's lost motion, with friction, is near that without; its stiffness is not, and is left out."""
    found, seen = sheet(Reducer(PRESETS[name])).quantities, set()
    for place, seen_value in MEASURED[name].items():
        key = {"lost_motion": "lost_motion_ideal"}.get(place.split("/")[1], place.split("/")[1])
        if key not in found or key == "stiffness":
            continue
        known = known_difference(found[key])
        assert known is not None, key
        assert found[key].value == pytest.approx(seen_value["value"], rel=known), key
        seen.add(
            key
            if key in KNOWN_DIFFERENCES
            else next(end for end in KNOWN_DIFFERENCES_OF_KINDS if key.endswith(f"_{end}"))
        )
    assert seen == {*KNOWN_DIFFERENCES, *KNOWN_DIFFERENCES_OF_KINDS}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["nonpin", "sleeved", "twodisc", "printed"])
def test_every_kind_of_design_has_every_figure(name: str) -> None:
    design = KINDS[name]
    made = override(design, ["errors.hole_position_um=0.3", "modification.equidistant_um=0.2"])
    for one in (design, made):
        found = sheet(Reducer(one))
        for key, quantity in found.quantities.items():
            assert math.isfinite(quantity.value) or quantity.note, key
        for key, quantity in quick_sheet(Reducer(one)).quantities.items():
            assert repr(quantity) == repr(found.quantities[key])
        value = {key: quantity.value for key, quantity in found.quantities.items()}
        assert 0.0 < value["backlash_min"] <= value["backlash"] <= value["backlash_max"]
        assert value["backlash"] < value["lost_motion_ideal"]
        assert 0.0 <= value["back_driving_efficiency"] < 100.0
        assert 0.0 < value["efficiency"] < 100.0
        parts = sum(value[key] for key in value if key.startswith("compliance_"))
        assert parts * value["stiffness_ideal"] == pytest.approx(1.0, rel=0.02)
        losses = sum(value[f"{kind}_friction_power"] for kind in (one.tooth_pair, "cam", "output"))
        assert value["input_power"] == pytest.approx(value["output_power"] + losses + value["seals_power"], rel=1e-9)
        for kind in one.pair_kinds:
            assert value[f"{kind}_mean_force"] <= value[f"{kind}_peak_force"]


@pytest.mark.parametrize("name", CENTRAL)
def test_the_deflection_of_a_spring_follows_from_its_work(name: str) -> None:
    """Next to no play, so that no contact comes or goes: a softer spring turns the output by what is told of it."""
    clearance = dict.fromkeys(type(PRESETS[name].clearance).model_fields, 1e-10)
    design = Reducer(PRESETS[name].but(clearance=clearance)).working_at(PRESETS[name].rated_torque).design

    def solved(one: Design) -> list[Windup]:
        return solve_windups(Reducer(one), [0.3, 1.1], design.rated_torque)

    told, contacts = (
        [one.compliance_by_spring(Reducer(design)) for one in solved(design)],
        Reducer(design).at_rated_load.contacts,
    )
    # the spring of an output pin is its contact with the hole, which changes, and the needles of its roller
    needles = Reducer(design).at_rated_load.roller_compliance
    changed = {"output": 1.0 / (1.0 + needles * contacts["output"].stiffness)}
    mesh = [design.tooth_pair, *([design.seat_pair] if design.seat_pair else [])]
    for spring, kinds in (("output", ["output"]), ("cam", ["cam"]), ("mesh", mesh)):
        softer, stiffer = (
            solved(design.but(stiffness={kind: contacts[kind].stiffness / times for kind in kinds}))
            for times in (1.01, 0.99)
        )
        for one, low, high in zip(told, softer, stiffer, strict=True):
            given = (low.compliance(low.turn) - high.compliance(high.turn)) / 0.02
            assert changed.get(spring, 1.0) * one[spring] == pytest.approx(given, rel=0.015), spring
    for one, whole in zip(told, solved(design), strict=True):
        assert sum(one.values()) + wind_up(Reducer(design)) == pytest.approx(whole.compliance(whole.turn))


@pytest.mark.parametrize("design", [*CENTRAL.values(), unlike("large")], ids=lambda design: design.name)
def test_balances_of_successive_angles_equal_those_of_single_angles(design: Design) -> None:
    torque, cranks = design.rated_torque, turn_evenly(Reducer(design), 31)
    alone, following = (solve_windups(Reducer(design), cranks, torque, follow) for follow in (False, True))
    for one, other in zip(alone, following, strict=True):
        for share, turn in one.turn.items():
            assert other.turn[share] == pytest.approx(turn, rel=1e-6)
    springs = springs_of(Reducer(design), cranks)
    one, other = (loads(Reducer(design), springs, torque, follow) for follow in (False, True))
    assert other.teeth == pytest.approx(one.teeth, abs=1e-5 * one.teeth.max())


def test_without_friction_only_seals_have_losses() -> None:
    smooth = override(FIXED, [f"friction.{kind}=0" for kind in ("pin_gear", "cam_rolling", "output_rolling")])
    assert powers(Reducer(smooth), 30.0).efficiency == pytest.approx(1.0, abs=1e-12)
    sealed = powers(Reducer(override(smooth, ["drag.crank_nm=0.01", "drag.output_nm=0.7"])), 35.0)
    assert sealed.efficiency == pytest.approx(35.0 / (35.0 + 0.7 + 0.01 * 35), rel=1e-12)


def crank_power(design: Design, found: Loads, springs: Springs) -> float:
    """Compute the mean power of the crank [W] from the cams' forces on the eccentrics, and their friction."""
    turned = springs.crank[:, np.newaxis] + 2.0 * np.pi * np.arange(found.discs) / found.discs
    ahead = np.stack([-np.cos(turned), -np.sin(turned)], axis=-1)
    held = np.sum(found.cam * ahead, axis=(1, 2)).mean() * design.gear.eccentricity
    pressed = springs.cam_normal_share * np.linalg.norm(found.cam, axis=-1).sum(axis=1).mean()
    return float((held + design.friction_of("cam") * design.gear.bore_radius * pressed) * design.drive.speed)


def test_losses_are_input_power_minus_output_power() -> None:
    design, torque = PRESETS["nonpin"], 36.68
    springs = springs_of(Reducer(design), np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False))
    found = loads(Reducer(design), springs, torque)
    assert powers(Reducer(design), torque).crank == pytest.approx(crank_power(design, found, springs), rel=3e-4)


@pytest.mark.parametrize("share", [pytest.param(1e-4, marks=pytest.mark.slow), 1e-3])
def test_under_a_light_ring_load_the_carrier_supports_the_losses(share: float) -> None:
    """Discs flung outwards at four times the speed rub more than the load: the carrier is held against its sense."""
    friction = ["friction.law=coulomb", "friction.cam=0.25", "friction.output=0.25"]
    fast = override(PRESETS["twodisc"], ["gear.bearing=plain", *friction])
    design = fast.but(output={"member": "ring"}, drive={"speed": 4.0 * fast.drive.speed})
    springs = springs_of(Reducer(design), np.linspace(0.0, 2.0 * np.pi, 90, endpoint=False))
    torque = share * design.rated_torque
    found = loads(Reducer(design), springs, torque)
    assert powers(Reducer(design), torque).crank == pytest.approx(crank_power(design, found, springs), rel=5e-3)
    assert np.abs(found.share).max() < 2.0


def test_a_reducer_that_locks_is_reported() -> None:
    found = sheet(Reducer(unlike("printed"))).quantities
    assert found["back_driving_efficiency"].value == 0.0
    assert math.isnan(found["back_driving_torque_rated"].value)
    assert "self-locking" in found["back_driving_efficiency"].note


def test_the_torque_of_self_locking_is_stated() -> None:
    """At these coefficients the rated torque drives a crank without load, but none that brakes by its share of it."""
    for friction, said in ((0.38, "drives a crank without load"), (0.45, "does not drive a crank without load")):
        found = sheet_part(Reducer(override(FIXED, [f"friction.pin_gear={friction}"])), "losses")[
            "back_driving_efficiency"
        ]
        assert "self-locking against 1.048 N m on the crank" in found.note
        assert said in found.note
        alone = powers(Reducer(override(FIXED, [f"friction.pin_gear={friction}"])), -FIXED.rated_torque)
        assert (alone.crank < 0.0) == (friction < 0.4)


def test_a_jam_a_crank_at_rest_or_a_negative_torque_is_one_error() -> None:
    with pytest.raises(RunError, match="friction jams the drive"):
        sheet(Reducer(override(FIXED, ["friction.pin_gear=0.9"])))
    with pytest.raises(DesignError, match=r"drive\.speed_rpm is 0"):
        sheet(Reducer(override(FIXED, ["drive.speed_rpm=0"])))
    with pytest.raises(UsageError, match="choose a torque greater than 0 N m"):
        sheet(Reducer(FIXED), -3.0)


def test_a_tooth_at_the_limit_of_the_foot_point_search_is_balanced() -> None:
    """At 46 N m and one crank angle a tooth goes from one way of reckoning its width to the other."""
    capacity = [
        sheet_part(Reducer(override(unlike("teeth21"), [f"clearance.cam_um={cam}"])), "loads")[
            "capacity_shakedown"
        ].value
        for cam in (1.95, 2.0, 2.05)
    ]
    assert capacity[1] == pytest.approx(0.5 * (capacity[0] + capacity[2]), rel=1e-5)


@pytest.mark.slow
def test_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["statics", "--design", "nonpin", "--load-nm", "20", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["design"] == "nonpin"
    assert told["condition"].startswith("20 N m, 1640 rpm")
    assert told["quantities"]["efficiency"]["value"] == pytest.approx(
        sheet(Reducer(PRESETS["nonpin"]), 20.0).quantities["efficiency"].value
    )
    assert told["quantities"]["efficiency"]["known_difference"] == KNOWN_DIFFERENCES["efficiency"]
    assert told["figures"]["efficiency_percent"]["value"] == told["quantities"]["efficiency"]["value"]
    assert told["figures"]["mass_kg"]["unit"] == "kg"
    assert main(["statics", "--design", str(design_file("few")), "--set", "errors.pin_position_um=0.4", "--all"]) == 0
    out = capsys.readouterr().out
    assert "capacity" in out
    assert "known difference" in out
    for words, said in (
        (["--load-nm", "0"], "must be greater than 0"),
        (["--load-nm", "x"], "load-nm"),
        (["--set", "ring.teeth=3"], "ring.teeth"),
    ):
        assert main(["statics", "--design", "pin", *words]) == 2
        assert said in capsys.readouterr().err
    assert main(["statics", "--design", "pin", "--set", "output.hole_radius_mm=4.5"]) == 1
    assert main(["statics", "--design", "pin", "--set", 'ring.pins="fixed"', "--set", "friction.pin_gear=0.9"]) == 1
    assert "friction jams the drive" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("name", ["nonpin", "fixed", "pin"])
def test_efficiency_losses_and_error_are_those_of_the_dynamic_run(name: str, way: float) -> None:
    """Within 0.1 points, 1 % of each loss, and 0.2 % of the mean error, driven by the crank and by the output."""
    design: Design = steady.steady_design(Reducer(KINDS[name])).design
    torque = way * design.rated_torque
    run = steady.run_steady(Reducer(override(design, [f"load.torque_nm={torque!r}"])), steady.STEADY.settling_time, 12)
    dynamic, found = mean_powers(run), powers(Reducer(design), torque)
    assert 100.0 * found.efficiency == pytest.approx(100.0 * dynamic.efficiency, abs=0.1)
    friction = dict(dynamic.friction)
    losses = {kind: friction.pop(kind) for kind in ("cam", "output")} | {"teeth": sum(friction.values())}
    for part, lost in losses.items():
        assert found.friction[part] == pytest.approx(lost, rel=0.01), part
    error = run["output_angle"] + run["crank_angle"] / design.lobes
    ours = loads(Reducer(design), springs_of(Reducer(design), run["crank_angle"][::10]), torque).output_turn
    assert ours.mean() == pytest.approx(error.mean(), rel=0.002)


@pytest.mark.slow
def test_a_drive_with_wide_play_is_balanced_at_every_angle() -> None:
    """A printed size whose contacts change at once under a hundredth of its load."""
    found = sheet(Reducer(load(Path(__file__).parents[1] / "data" / "wide_play.toml")))
    assert 0.0 < found.quantities["efficiency"].value < 100.0
    assert found.quantities["output_peak_to_peak_unloaded_forward_speed"].value > 0.0
