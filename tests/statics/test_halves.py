"""A ring in two halves that are turned against each other: gaps, play, friction, and what refuses it."""

import math
from pathlib import Path

import numpy as np
import pytest

from cycloid_mj.base.errors import DesignError
from cycloid_mj.base.units import ARCMINUTE
from cycloid_mj.checks import check
from cycloid_mj.cli import main
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.figures import figure
from cycloid_mj.geometry import profile
from cycloid_mj.life import rate
from cycloid_mj.parts.export import export, read_stl
from cycloid_mj.parts.housing import SLIT_SHARE
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.gaps import arc_gaps
from cycloid_mj.robot.identification import solve_play
from cycloid_mj.statics.balance import loads
from cycloid_mj.statics.locked import solve_locked_curve
from cycloid_mj.statics.preload import halves_torque, preloaded
from cycloid_mj.statics.springs import springs_of, turn_evenly

FIGURES = ("backlash_arcmin", "stiffness_nm_per_arcmin", "no_load_torque_nm", "efficiency", "te_loaded_forward_arcsec")


def halved(design: Design, arcmin: float = 0.0, *changes: str) -> Reducer:
    return Reducer(override(design, ["ring.halves=2", f"ring.preload_arcmin={arcmin}", *changes]))


@pytest.mark.parametrize("kind", ["pin", "nonpin"])
def test_halves_that_are_not_turned_are_the_ring(kind: str) -> None:
    design = override(PRESETS["printed"], [f"ring.kind={kind}"])
    whole, halves = Reducer(design), halved(design)
    for key in FIGURES:
        assert figure(key).value(halves) == pytest.approx(figure(key).value(whole), rel=1e-6), key
    # each of them carries half on half the line: the same pressure
    force, pressure = ("tooth" if kind == "nonpin" else "pin_gear") + "_peak_force_n", "_pressure_mpa"
    assert figure(force).value(halves) == pytest.approx(0.5 * figure(force).value(whole), rel=1e-6)
    pressure = force.replace("_peak_force_n", pressure)
    assert figure(pressure).value(halves) == pytest.approx(figure(pressure).value(whole), rel=1e-6)


def test_a_rotated_ring_half_equals_a_ring_with_rotated_pins() -> None:
    """By pins put where they are turned to, counter-clockwise first; to first order in the turn."""
    design, turn = PRESETS["printed"], 2.0 * ARCMINUTE
    found = arc_gaps(halved(design, 4.0), 0.3)
    gear = Reducer(design).tooth_profile
    teeth = design.ring.teeth
    places = design.ring.pin_circle_radius * profile.unit(profile.pin_angles(gear))
    for half, way in enumerate((1.0, -1.0)):
        cos, sin = math.cos(way * turn), math.sin(way * turn)
        moved = places @ np.array([[cos, sin], [-sin, cos]]) - places
        errors = {"pin_x": tuple(moved[:, 0].tolist()), "pin_y": tuple(moved[:, 1].tolist())}
        alone = arc_gaps(Reducer(design).but(errors=errors), 0.3)
        rows = slice(half * teeth, (half + 1) * teeth)
        assert found.width[rows] == pytest.approx(alone.width[:teeth], abs=2e-3 * np.abs(moved).max())


@pytest.mark.parametrize(("kind", "preload"), [("pin", 4.0), ("nonpin", 0.2)])
def test_preload_takes_up_play_by_the_turn_of_the_gear(kind: str, preload: float) -> None:
    """A ring that turns at a locked crank takes the gear along by N/(N-1): each stop comes nearer by half of that.

    Until the teeth are pressed, which those of an internal gear are sooner.
    """
    design = override(PRESETS["printed"], [f"ring.kind={kind}"])
    backlash = figure("backlash_arcmin").value
    taken = backlash(Reducer(design)) - backlash(halved(design, preload))
    assert taken == pytest.approx(preload * design.ring.teeth / design.lobes, rel=1e-3)


def test_preload_beyond_the_play_of_teeth_leaves_that_of_holes_and_costs_friction() -> None:
    design = override(PRESETS["printed"], ["ring.kind=nonpin", "clearance.tooth_um=1", "friction.law=coulomb"])
    plays, lost = zip(
        *(
            (figure("backlash_arcmin").value(one), figure("no_load_torque_nm").value(one))
            for one in (halved(design, arcmin) for arcmin in (0.0, 10.0, 20.0, 40.0))
        ),
        strict=True,
    )
    assert sorted(plays, reverse=True) == list(plays)
    assert plays[-1] > 0.5 * plays[0]  # no preload of the ring takes up the play of the output pins
    assert lost[0] < 1e-3 * lost[1]
    assert sorted(lost) == list(lost)
    # pressed teeth are springs: friction grows with the preload
    assert (lost[3] - lost[2]) / 20.0 == pytest.approx((lost[2] - lost[1]) / 10.0, rel=0.2)


def test_pressed_halves_push_against_each_other_without_a_load() -> None:
    reducer = halved(override(PRESETS["printed"], ["ring.kind=nonpin"]), 40.0)
    still = reducer.but(drive={"speed": 0.0}, environment={"gravity_x": 0.0, "gravity_y": 0.0})
    springs = springs_of(still, [0.3], friction=False)
    seen = loads(still, springs, 1e-4 * still.design.rated_torque)
    teeth = still.design.ring.teeth
    moments = -(seen.teeth * springs.contacts.slope[:, : 2 * teeth, 2])[0]
    first, second = moments[:teeth].sum(), moments[teeth:].sum()
    assert abs(first) > 20.0 * abs(first + second)
    assert first * second < 0.0


def test_the_curve_of_a_locked_crank_has_the_preload() -> None:
    design = PRESETS["printed"]
    plays = [
        float(np.ptp(np.interp([-0.01, 0.01], curve.torque, curve.turn)))
        for curve in (
            solve_locked_curve(one, design.rated_torque, 0.0) for one in (Reducer(design), halved(design, 10.0))
        )
    ]
    assert plays[0] - plays[1] == pytest.approx(10.0 * ARCMINUTE * design.ring.teeth / design.lobes, rel=0.1)


@pytest.mark.parametrize("kind", ["pin", "nonpin"])
def test_rating_and_checks_of_halves_that_are_not_turned_are_those_of_the_ring(kind: str) -> None:
    design = override(PRESETS["printed"], [f"ring.kind={kind}"])
    whole, halves = (rate(one.design, poses=13) for one in (Reducer(design), halved(design)))
    for key, item in whole.items.items():
        if key == "joint_ring_pin_glue":  # half the force on half the length
            assert halves.items[key].safety == pytest.approx(item.safety, rel=1e-6)
            continue
        assert halves.items[key].value == pytest.approx(item.value, rel=1e-6, nan_ok=True), key
    checks, of_halves = check(design), check(halved(design).design)
    drawn = [(one.name, one.got) for one in checks if one.name != "joints"]  # two halves have no drawn casing
    assert [(one.name, one.got) for one in of_halves] == drawn


@pytest.mark.parametrize("kind", ["pin", "nonpin"])
def test_each_half_of_a_ring_is_a_part(kind: str) -> None:
    design = override(PRESETS["printed"], [f"ring.kind={kind}"])
    whole, halves = (export(one, "stl").files for one in (design, halved(design, 10.0).design))
    assert set(halves) - set(whole) == {"housing_1.stl", "housing_2.stl"}
    volumes = [volume_of(halves["housing_1.stl"]), volume_of(whole["housing.stl"])]
    assert volumes[0] == pytest.approx(0.5 * (1.0 - SLIT_SHARE) * volumes[1], rel=1e-6)
    assert halves["gear.stl"] == whole["gear.stl"]


def volume_of(content: bytes) -> float:
    """Compute the volume within the triangles of an STL file."""
    a, b, c = np.transpose(read_stl(content), (1, 0, 2))
    return float(np.sum(np.cross(a, b) * c) / 6.0)


def test_preload_without_halves_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["statics", "printed", "--set", "ring.preload_arcmin=5"]) == 2
    assert "halves" in capsys.readouterr().err


@pytest.mark.parametrize("words", ["tolerance", "stress --quick", "export --plate --out {out}"])
def test_commands_that_do_not_support_ring_halves_report_it(
    words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name, *flags = words.format(out=tmp_path).split()
    assert main([name, "printed", "--set", "ring.halves=2", *flags]) == 1
    error = capsys.readouterr().err
    assert "(ring.halves = 2) cannot be combined with" in error
    assert "Traceback" not in error


@pytest.mark.parametrize("kind", ["pin", "nonpin"])
def test_a_spring_turns_the_halves_to_the_angle_of_its_torque(kind: str) -> None:
    asked = override(PRESETS["printed"], [f"ring.kind={kind}", "ring.halves=2", "ring.preload_torque_nm=6"])
    found = preloaded(asked)
    assert found.ring.preload_torque == 0.0
    assert halves_torque(Reducer(found)) == pytest.approx(6.0, rel=1e-3)
    with pytest.raises(DesignError, match="preloaded"):
        Reducer(asked).mechanism  # noqa: B018


def test_the_torque_of_the_halves_is_what_turning_them_works() -> None:
    """What the springs of all contacts hold, by loads at rest, is the torque's integral over the angle."""
    angles = np.linspace(10.0, 14.0, 5)
    reducers = [
        halved(override(PRESETS["printed"], ["ring.kind=nonpin", "clearance.tooth_um=1"]), arcmin) for arcmin in angles
    ]
    torques = [halves_torque(one) for one in reducers]
    held = [stored(one) for one in reducers]
    work = float(np.trapezoid(torques, angles * ARCMINUTE))
    assert held[-1] - held[0] == pytest.approx(work, rel=0.02)


def stored(reducer: Reducer) -> float:
    """Compute the energy of all contacts at rest, in the mean over the turn [J]; what is next to no load left out."""
    still = reducer.but(drive={"speed": 0.0}, environment={"gravity_x": 0.0, "gravity_y": 0.0})
    springs = springs_of(still, turn_evenly(still, 13), friction=False)
    found = loads(still, springs, 1e-3 * still.design.rated_torque)
    lines = springs.contacts.stiffness
    of_lines = 0.5 * np.sum(np.concatenate([found.teeth, found.output], axis=1) ** 2 / lines, axis=1)
    of_cam = 0.5 * np.sum(found.cam**2, axis=(1, 2)) / springs.contacts.cam_stiffness
    return float((of_lines + of_cam).mean())


def test_a_torque_and_an_angle_exclude_each_other(capsys: pytest.CaptureFixture[str]) -> None:
    changes = ["ring.halves=2", "ring.preload_arcmin=5", "ring.preload_torque_nm=1"]
    assert main(["statics", "printed", *(word for one in changes for word in ("--set", one))]) == 2
    assert "one of them" in capsys.readouterr().err


def test_a_command_finds_the_angle_of_a_torque(capsys: pytest.CaptureFixture[str]) -> None:
    halves = ["--set", "ring.halves=2", "--set", "ring.preload_torque_nm=6"]
    assert main(["design", "show", "printed", *halves]) == 0
    assert "preload_torque_nm = 0.0" in capsys.readouterr().out


def test_a_reducer_without_play_has_a_joint_without() -> None:
    """Its stops do not cross: MuJoCo takes no such tendon."""
    design = override(PRESETS["printed"], ["ring.kind=nonpin", "clearance.output_um=0.001", "clearance.tooth_um=0.001"])
    low, high = solve_play(halved(design, 5.0), 61).stops
    assert low == high
