"""Bad regimes are told, the default designs are silent, and to follow a warning silences it."""

import re
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from designs import UNLIKE, cases, unlike

from cycloid_mj.analysis import analyze
from cycloid_mj.cli.app import main
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.dynamics.mjcf import ReducerModel, build
from cycloid_mj.dynamics.regime import LIMITS, model_warnings, pace_warnings, static_warnings
from cycloid_mj.dynamics.run import simulate
from cycloid_mj.dynamics.timestep import SETTINGS, choose_step, describe_accuracy, step_limits, timestep
from cycloid_mj.log import read
from cycloid_mj.reducer import Reducer, reducer_of

FIXED, SLEEVED = "ring.pins=fixed", "ring.pins=sleeved"


@cache
def told(preset: str, *changes: str) -> tuple[str, ...]:
    # contacts are as stiff as their load makes them: under the rated one, they bear the least
    design = override(PRESETS[preset], ["load.torque_nm=36", *changes])
    return model_warnings(Reducer(design), build(design))


@pytest.mark.parametrize(
    "made",
    [
        ("pin",),
        ("nonpin",),
        ("pin", FIXED),
        ("pin", SLEEVED),
        ("nonpin", "settings.timestep_us=17"),
        ("pin", FIXED, "settings.timestep_us=17"),
        ("pin", "settings.timestep_us=3.1"),
        ("nonpin", "stiffness.cam_n_m=1e12"),
        ("pin", "gear.bearing=plain", "output.rollers=false", "friction.output=0.02", "friction.cam=0.02"),
    ],
)
def test_the_presets_and_their_stable_steps_cause_no_warning(made: tuple[str, ...]) -> None:
    assert told(*made) == ()


@pytest.mark.parametrize(
    ("made", "kinds"),
    [
        (("pin", "settings.timestep_us=3.3"), {"pin_socket"}),
        (("pin", "settings.timestep_us=4"), {"settings.timestep_us", "pin_socket", "pin_gear"}),
        (("pin", "clearance.pin_socket_um=0.01", "settings.timestep_us=2.4"), {"settings.timestep_us"}),
        (("pin", SLEEVED, "settings.timestep_us=2.5"), {"pin_sleeve"}),
        (("pin", FIXED, "settings.timestep_us=18"), {"pin_gear"}),
        (("nonpin", "settings.timestep_us=18"), {"tooth"}),
        (("nonpin", "stiffness.cam_n_m=1e12", "settings.timestep_us=10"), {"cam"}),
        (
            ("nonpin", "stiffness.cam_n_m=7e10", "clearance.cam_um=1e-3", "settings.timestep_us=4"),
            {"settings.timestep_us"},
        ),
        (("pin", "clearance.pin_socket_um=1e-8"), {"clearance.pin_socket_um"}),
        (("pin", "friction.output=0.01"), {"friction.output"}),
        (("pin", "friction.cam=0.01"), {"friction.cam"}),
    ],
)
def test_every_unsuitable_contact_regime_has_its_warning(made: tuple[str, ...], kinds: set[str]) -> None:
    assert {re.split(r"[: ]", text)[0] for text in told(*made)} == kinds


@pytest.mark.parametrize(
    "made",
    [
        ("pin", "settings.timestep_us=4"),
        ("pin", SLEEVED, "settings.timestep_us=3"),
        ("nonpin", "settings.timestep_us=20"),
        ("pin", FIXED, "stiffness.cam_n_m=1e12", "settings.timestep_us=10"),
        ("pin", "clearance.cam_um=1e-8"),
    ],
)
def test_to_follow_a_warning_silences_it(made: tuple[str, ...]) -> None:
    found = told(*made)
    assert found
    steps = [float(number) for text in found for number in re.findall(r"reduce \S*?(?: to|it to) ([\d.]+)", text)]
    raised = [f"{key}={n}" for text in found for key, n in re.findall(r"^(\S+) = .* raise it to (\S+) or more", text)]
    assert steps or raised
    shorter = [f"settings.timestep_us={min(steps)!r}"] if steps else []
    assert told(*made, *raised, *shorter) == ()


def test_heavy_or_soft_parts_allow_a_longer_step() -> None:
    # Ten times as long, wide and thick: 1000 times the mass. The stiffness of a line goes with its length: ten times.
    lengths = [("ring", "pin_circle_radius", 40.75), ("ring", "pin_radius", 2.25), ("gear", "eccentricity", 1.0)]
    lengths += [("gear", "face_width", 10.0), ("gear", "bore_radius", 15.0), ("housing", "outer_radius", 50.0)]
    lengths += [("output", name, size) for name, size in (("pin_radius", 4.0), ("pin_circle_radius", 26.0))]
    lengths += [("output", "hole_radius", 5.0), ("output", "disc_thickness", 8.0), ("shaft", "radius", 8.0)]
    lengths += [("shaft", "length", 30.0), ("shaft", "counterweight_radius", 30.0)]
    large = [f"{table}.{name}_mm={10.0 * size}" for table, name, size in lengths]
    assert told("pin", *large, "settings.timestep_us=5") == ()


def test_a_stiff_cam_with_a_warning_does_chatter() -> None:
    """At K dt^2/m = 390 the gear's speed error is many times that at a hundredth of it."""
    changes = [FIXED, "drive.ramp_s=0", "drive.hold_s=0.006", "load.torque_nm=36", "load.rise_s=0.001"]
    changes += ["settings.timestep_us=10", "settings.log_rate_hz=20000", "drive.hold_s=0.012"]
    error = []
    for stiffness in ("1e10", "1e12"):
        design = override(PRESETS["pin"], [*changes, f"stiffness.cam_n_m={stiffness}"])
        run = simulate(design)
        deviation = run["gear_speed"][run.time > 3.5e-3] + design.drive.speed / design.lobes
        error.append(float(np.sqrt(np.mean(deviation**2))))
        assert bool(model_warnings(Reducer(design), build(design))) == (stiffness == "1e12")
    assert error[1] > 20.0 * error[0]


@dataclass(frozen=True)
class Other:
    """A reducer with one thing exchanged."""

    model: Any
    pairs: Any
    laws: Any


def test_a_raised_impedance_is_reported() -> None:
    design = PRESETS["nonpin"]
    compiled: ReducerModel = build(design)
    law = compiled.laws["cam"]
    light = replace(law, added_mass=1e-7, effective_mass=1e-4)
    found = model_warnings(Reducer(design), Other(compiled.model, compiled.pairs, {**compiled.laws, "cam": light}))
    assert len([text for text in found if "minimum impedance" in text]) == 1
    heavy = replace(law, added_mass=1e-7)
    assert model_warnings(Reducer(design), Other(compiled.model, compiled.pairs, {**compiled.laws, "cam": heavy})) == ()


def test_the_step_of_the_model_is_judged() -> None:
    """By mesh contact it is shorter than the design's own."""
    design = override(PRESETS["pin"], ["load.torque_nm=1.0"])
    compiled = build(design)
    compiled.model.opt.timestep *= 2.0
    assert any("pin_socket" in text for text in model_warnings(Reducer(design), compiled))
    longer = design.but(settings={"timestep": 2.0 * timestep(Reducer(design))})
    assert any("pin_socket" in text for text in model_warnings(Reducer(longer), compiled))
    compiled.model.opt.timestep /= 2.0
    assert not model_warnings(Reducer(longer), compiled)


@pytest.mark.slow
def test_simulate_prints_warnings_before_the_run_and_logs_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flags = ["--ramp-s", "0", "--hold-s", "0.0005", "--out", str(tmp_path), "--set", "friction.cam=0.01"]
    assert main(["simulate", "--design", "nonpin", "--timestep-us", "5", *flags]) == 0
    shown = capsys.readouterr().err
    assert shown.count("friction.cam = 0.01") == 1
    assert "warning: nonpin: friction.cam = 0.01 has no effect" in shown
    assert read(tmp_path / "nonpin.mcap").provenance["warnings"].startswith("friction.cam = 0.01 has no effect")
    assert main(["simulate", "--design", "nonpin", *flags[:-2], "--force", "--timestep-us", "5"]) == 0
    assert "friction.cam" not in capsys.readouterr().err
    assert "warnings" not in read(tmp_path / "nonpin.mcap").provenance


def test_a_remedy_lies_well_within_the_limit() -> None:
    """Sockets of 21 light pins ask for 1.98 us instead of 2 us: the remedy is a round step below it."""
    stiffness = 0.612e-3 * SETTINGS.max_settling_ratio / 1.98e-6**2
    design = override(PRESETS["pin"], [f"stiffness.pin_socket_n_m={stiffness!r}", "settings.timestep_us=2"])
    found = model_warnings(Reducer(design), build(design))
    assert [text for text in found if "reduce settings.timestep_us to 1, or" in text] == list(found) != []
    shorter = override(design, ["settings.timestep_us=1"])
    assert model_warnings(Reducer(shorter), build(shorter)) == ()


@pytest.mark.parametrize("name", ["pin", "light", "printed"])
@pytest.mark.parametrize("share", cases([0.0, 0.1, 1.0, 3.0], 0.0, 1.0))
def test_the_automatic_step_has_no_warning_and_twice_the_step_of_a_pin_has(name: str, share: float) -> None:
    design = unlike(name) if name in UNLIKE else PRESETS[name]
    design = override(design, [f"load.torque_nm={share * design.rated_torque!r}", "settings.timestep_us=0"])
    step = timestep(Reducer(design))
    assert step <= min(SETTINGS.max_step, *step_limits(Reducer(design)).values()) * (1.0 + 1e-9)
    assert step > 0.8 * min(SETTINGS.max_step, *step_limits(Reducer(design)).values())
    assert model_warnings(Reducer(design), build(design)) == ()
    assert pace_warnings(Reducer(design)) == ()
    if design.ring.has_pin_bodies:
        longer = override(design, [f"settings.timestep_us={2e6 * step!r}"])
        assert model_warnings(Reducer(longer), build(longer))


def test_the_step_follows_mass_stiffness_play_force_and_speed() -> None:
    """Each limit by its own formula, from the masses of the built model."""
    design = override(PRESETS["pin"], ["load.torque_nm=36.68"])
    model, found = build(design).model, step_limits(Reducer(design))
    pin = float(model.body("pin_1").mass[0])
    seat, force = Reducer(design).contacts["pin_socket"].stiffness, Reducer(design).contacts["pin_socket"].force
    assert found["stiffness of pin_socket"] == pytest.approx(
        (SETTINGS.max_seat_ratio * 0.5 * pin / seat) ** 0.5, rel=1e-6
    )
    idle = override(design, ["load.torque_nm=0", "contact.working_load_nm=36.68"])
    assert step_limits(Reducer(idle))["stiffness of pin_socket"] == pytest.approx(
        (SETTINGS.max_idle_seat_ratio * 0.5 * pin / seat) ** 0.5, rel=1e-6
    )
    for followed, most in ((False, SETTINGS.max_settling_ratio), (True, SETTINGS.max_idle_seat_ratio)):
        free = Reducer(PRESETS["pin"])
        time = (0.5 * pin / free.contacts["pin_socket"].stiffness) ** 0.5
        assert step_limits(free, followed)["stiffness of pin_socket"] == pytest.approx(most**0.5 * time, rel=1e-6)
    cam = Reducer(design).contacts["cam"].stiffness
    gear = float(model.body("gear").mass[0])
    assert found["stiffness of cam"] == pytest.approx((SETTINGS.max_stiffness_ratio * gear / cam) ** 0.5, rel=1e-6)
    bowl = force / (1e-6 + force / seat)
    assert found["rolling of pins in their clearance"] == pytest.approx(
        SETTINGS.max_rolling_share * 2.0 * (pin / bowl) ** 0.5, rel=1e-6
    )
    passing = 36 * 1640.0 / 60.0
    assert found["tooth passing"] == pytest.approx(1.0 / (SETTINGS.min_steps_per_tooth * passing), rel=1e-6)
    assert timestep(Reducer(design)) == pytest.approx(3.125e-6)
    assert timestep(Reducer(override(design, ["settings.timestep_us=0.7"]))) == pytest.approx(0.7e-6)
    assert str(choose_step(Reducer(override(design, ["settings.timestep_us=0.7"])))) == "0.7 us (given)"


@pytest.mark.parametrize("design", [*PRESETS.values(), *map(unlike, UNLIKE)], ids=lambda one: one.name)
def test_steps_and_samples_are_counted_from_tooth_to_tooth(design: Design) -> None:
    """A disc of N - 1 lobes passes N (N - 1) teeth per turn of the output against the ring."""
    assert pace_warnings(reducer_of(design)) == ()
    passing = design.ring.teeth * design.lobes * abs(design.drive.speed / design.ratio) / (2.0 * np.pi)
    for inside, count in ((False, 0.99), (True, 1.01)):
        rate = override(design, [f"settings.log_rate_hz={count * LIMITS.min_samples_per_tooth * passing!r}"])
        fast = override(design, ["settings.log_rate_hz=1e6", "settings.timestep_us=1", "contact.creep_speed_mm_s=1e-3"])
        speed = design.drive.speed * 1e6 / passing / (count * SETTINGS.min_steps_per_tooth)
        fast = fast.model_copy(update={"drive": design.drive.model_copy(update={"speed": speed})})
        assert (pace_warnings(reducer_of(rate)) == ()) == inside
        assert (pace_warnings(reducer_of(fast)) == ()) == inside
    still = design.model_copy(update={"drive": design.drive.model_copy(update={"speed": 0.0})})
    assert pace_warnings(reducer_of(still)) == ()


@pytest.mark.parametrize(
    "changes",
    [
        ("drive.speed_rpm=20000", "settings.timestep_us=10"),
        ("drive.speed_rpm=-50000",),
        ("drive.speed_rpm=99999", "settings.timestep_us=10"),
        ("settings.log_rate_hz=100",),
        ("settings.log_rate_hz=1000",),
    ],
)
def test_to_follow_a_warning_of_pace_silences_it(changes: tuple[str, ...]) -> None:
    design = override(PRESETS["pin"], [FIXED, *changes])
    found = pace_warnings(Reducer(design))
    remedies = [re.search(r"^(settings\.\w+) .*(?:reduce|raise) it to ([\d.e+]+)", text) for text in found]
    assert remedies
    assert pace_warnings(Reducer(override(design, [f"{one[1]}={one[2]}" for one in remedies if one]))) == ()


def test_a_slow_bench_is_judged_by_what_counts_at_rest() -> None:
    design = override(PRESETS["pin"], ["settings.timestep_us=10", "friction.cam=0.01", "clearance.cam_um=1e-8"])
    found = static_warnings(Reducer(design), build(design).laws)
    assert {re.split(r"[: ]", text)[0] for text in found} == {"friction.cam", "clearance.cam_um"}
    assert set(found) < set(model_warnings(Reducer(design), build(design)))


def test_zero_friction_means_no_sliding_friction() -> None:
    assert told("pin", *(f"friction.{kind}=0" for kind in ("cam", "output", "pin_gear", "pin_socket"))) == ()


def test_a_run_reports_the_accuracy_at_its_time_step() -> None:
    loaded = PRESETS["pin"].but(load={"torque": 36.0})
    assert "rms speeds within 15 %" in describe_accuracy(Reducer(loaded))
    assert "rms speeds within 2 %" in describe_accuracy(Reducer(loaded.but(ring={"pins": "fixed"})))
    assert "rms speeds are not valid" in describe_accuracy(Reducer(loaded.but(ring={"pins": "massless"})))
    assert "starts" in describe_accuracy(Reducer(PRESETS["pin"]))
    given = loaded.but(settings={"timestep": 2e-6})
    assert describe_accuracy(Reducer(given)).startswith("not known, as the design sets the step")
    found = analyze(simulate(given.but(drive={"ramp": 0.0, "hold": 0.001})))
    assert found.timestep_for == describe_accuracy(Reducer(given))


def test_friction_that_leads_its_sliding_is_reported_and_a_shorter_step_follows_it() -> None:
    changes = ["ring.pins=fixed", "friction.pin_gear=0.5", "drive.speed_rpm=12000", "load.torque_nm=1"]
    fast = override(PRESETS["pin"], [*changes, "contact.working_load_nm=1", "settings.timestep_us=10"])
    told = [text for text in build(fast).warnings if "leads the sliding" in text]
    assert len(told) == 1
    step = re.search(r"settings.timestep_us to ([\d.]+)", told[0])
    assert step
    followed = fast.but(settings={"timestep": 1e-6 * float(step[1])})
    assert not any("leads the sliding" in text for text in build(followed).warnings)
    assert not any("leads the sliding" in text for text in build(PRESETS["pin"].but(load={"torque": 1.0})).warnings)
