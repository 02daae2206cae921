"""The planar solver against MuJoCo, its own energy and its own order; and the witness of `validate`, which it is."""

import math
from pathlib import Path

import numpy as np
import pytest

from cycloid_mj.analysis import analyze
from cycloid_mj.base import names
from cycloid_mj.base.errors import CycloidWarning, RunError, UsageError
from cycloid_mj.base.record import Run
from cycloid_mj.base.statistics import rms
from cycloid_mj.cli.app import main
from cycloid_mj.design import PRESETS, Design, dump, override
from cycloid_mj.dynamics import timestep as steps
from cycloid_mj.dynamics.drive_cycle import braked_output, locked_crank, rising
from cycloid_mj.dynamics.mjcf import build
from cycloid_mj.dynamics.planar.model import planar_model
from cycloid_mj.dynamics.planar.settings import NEWTON
from cycloid_mj.dynamics.planar.timestep import acceleration_timestep
from cycloid_mj.dynamics.run import Model, model_for, simulate
from cycloid_mj.geometry.kinematics import CrankLaw
from cycloid_mj.log import read
from cycloid_mj.reducer import Reducer
from cycloid_mj.validate import witness
from cycloid_mj.validate.rig import FIXED, FREE, SETTLED, design_of_kind, without_friction

MESH = 60.0 / 1640.0 / 36.0
"""Time from tooth to tooth of the paper's designs [s]."""

LAYOUTS = {
    "free": ("pin",),
    "closed sockets": ("pin", 'ring.socket="closed"'),
    "fixed": ("pin", 'ring.pins="fixed"'),
    "massless": ("pin", 'ring.pins="massless"'),
    "sleeved": ("pin", 'ring.pins="sleeved"'),
    "massless sleeved": ("pin", 'ring.pins="massless_sleeved"'),
    "nonpin": ("nonpin",),
    "nonpin, two discs": ("nonpin", "gear.discs=2"),
    "modified nonpin": ("nonpin", "modification.rotation_arcsec=20.0", "modification.equidistant_um=2.0"),
    "two discs": ("twodisc",),
    "three discs": ("pin", "gear.discs=3", 'ring.pins="fixed"', "output.pins=9"),
    "ring output": ("pin", 'output.member="ring"'),
    "ring output, nonpin": ("nonpin", 'output.member="ring"'),
    "sleeves on a ring": ("pin", 'output.member="ring"', 'ring.pins="sleeved"'),
    "wide play": ("printed",),
    "errors and waves": (
        "pin",
        'ring.pins="fixed"',
        "errors.pin_position_um=1.0",
        "errors.hole_position_um=2.0",
        "errors.eccentricity_um=3.0",
        "errors.profile_cos_um={3=1.0, 35=0.5}",
        "clearance.pin_gear_um=10.0",
        "clearance.output_um=10.0",
    ),
    "backwards": ("pin", 'ring.pins="fixed"', "drive.speed_rpm=-1640.0"),
    "drag": ("pin", 'ring.pins="fixed"', "drag.crank_nm=0.05", "drag.output_nm=1.0"),
}
MANY_LIGHT_PINS = (
    "ring.teeth=79",
    "ring.pin_circle_radius_mm=20.21",
    "ring.pin_radius_mm=0.514",
    "gear.eccentricity_mm=0.112",
    "gear.face_width_mm=4.45",
    "gear.bore_radius_mm=5.77",
    "output.pins=10",
    "output.pin_radius_mm=1.59",
    "output.pin_circle_radius_mm=11.72",
    "output.hole_radius_mm=1.702",
    "shaft.radius_mm=2.63",
    "shaft.counterweight_radius_mm=14.15",
    "housing.outer_radius_mm=26.77",
    "clearance.pin_gear_um=0.52",
    "clearance.pin_socket_um=0.46",
    "clearance.cam_um=0.69",
    "clearance.output_um=0.61",
    "drive.torque_nm=0.004233",
    "drive.speed_rpm=1000.0",
    "drive.hold_s=0.03",
    "load.torque_nm=0.0099",
)
"""A drive of 78:1 and 40 mm at 3 % of its rated torque."""

QUICK = ("free", "fixed", "nonpin", "two discs", "sleeves on a ring")
SHARES = (1.0, 0.3, 0.03)
"""Of the rated torque."""

CASES = [
    pytest.param(layout, share, marks=() if layout in QUICK and share == 1.0 else pytest.mark.slow)
    for layout in LAYOUTS
    for share in SHARES
]


def design_of(layout: str, share: float = 1.0, periods: float = 4.0) -> Design:
    """Return a layout under a share of its rated torque, settled and then for some mesh periods of its own."""
    preset, *changes = LAYOUTS[layout]
    design = override(PRESETS[preset], ["drive.ramp_s=0.0", *changes])
    mesh = 2.0 * math.pi / (design.ring.teeth * abs(design.drive.speed))
    load = f"load.torque_nm={share * design.rated_torque!r}"
    return override(design, [load, f"drive.hold_s={2.0 * SETTLED + periods * mesh!r}"])


def settled(run: Run) -> Run:
    return run.select(run.time >= 2.0 * SETTLED)


def transmission_error(run: Run, design: Design) -> np.ndarray:
    """Of the output [arcsec]."""
    return np.degrees(run["output_angle"] - run["crank_angle"] / design.ratio) * 3600.0


def efficiency(run: Run) -> float:
    supplied, given = run["crank_torque"] * run["crank_speed"], run["load_torque"] * run["output_speed"]
    return float(-given.mean() / supplied.mean())


@pytest.mark.parametrize(("layout", "share"), CASES)
def test_means_agree_with_mujoco(layout: str, share: float) -> None:
    design = design_of(layout, share)
    bound = 1e-3 if share > 0.1 else 5e-3  # hardly pressed parts rattle in their play: a mean of some meshes spreads
    ours, theirs = settled(simulate(design, planar_model(Reducer(design)))), settled(simulate(design))
    mean = transmission_error(theirs, design).mean()
    play = np.degrees(design.clearance.output / design.output.pin_circle_radius) * 3600.0
    assert transmission_error(ours, design).mean() == pytest.approx(mean, rel=bound, abs=2.0 * bound * play)
    assert efficiency(ours) == pytest.approx(efficiency(theirs), abs=bound)
    for kind in ("cam", "output"):
        sizes = [np.linalg.norm(run.forces(kind), axis=-1).mean() for run in (ours, theirs)]
        assert sizes[0] == pytest.approx(sizes[1], rel=bound)
    assert ours["penetration"].mean() == pytest.approx(theirs["penetration"].mean(), rel=2.0 * bound)


def test_contact_geometry_that_does_not_converge_is_a_warning_of_the_run() -> None:
    """At 200 us, 50 times the step chosen for MuJoCo, sleeves jump between both sides of their play within a step."""
    design = override(design_of("sleeves on a ring"), ["settings.timestep_us=200"])
    with pytest.warns(CycloidWarning, match=r"in \d+ of \d+ time steps .* contact geometry did not converge"):
        run = simulate(design, planar_model(Reducer(design)))
    assert any("contact geometry did not converge" in text for text in run.warnings)


def test_contact_geometry_converges_at_the_chosen_steps() -> None:
    for layout in ("free", "sleeves on a ring", "nonpin", "wide play"):
        design = design_of(layout)
        run = simulate(design, planar_model(Reducer(design)))
        assert not [text for text in run.warnings if "geometry" in text]


def test_a_log_keeps_the_warning_of_contact_geometry(tmp_path: Path) -> None:
    design = override(design_of("sleeves on a ring"), ["settings.timestep_us=200"])
    path = tmp_path / "drive.toml"
    path.write_text(dump(design))
    main(["simulate", "--design", str(path), "--solver", "planar", "--out", str(tmp_path), "--quiet"])
    run = read(tmp_path / f"{design.name}.mcap")
    assert run.complete
    assert any("contact geometry did not converge" in text for text in analyze(run).warnings)


@pytest.mark.slow
@pytest.mark.parametrize("layout", ["free", "sleeved"])
def test_unloaded_moving_pins_settle_without_ringing(layout: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Idle, at the step that MuJoCo takes then, twice that which follows pins; a start among others, as in its play."""
    preset, *changes = LAYOUTS[layout]
    design = override(PRESETS[preset], ["drive.ramp_s=0", "drive.hold_s=0.08", *changes])
    reducer = Reducer(design)

    def hardest(model: Model) -> float:
        """Compute the largest force of a contact [N], once settled."""
        run = simulate(design, model)
        return float(run.select(run.time > 0.02)["peak_force"].max())

    witness = hardest(planar_model(reducer))
    model = build(design)
    assert model.timestep > 1.5 * min(steps.step_limits(reducer, must_follow=True).values())
    assert hardest(model) == pytest.approx(witness, rel=0.15)
    monkeypatch.setattr("cycloid_mj.dynamics.mjcf.laws.may_settle", lambda *of: False)
    assert hardest(build(design)) > 2.0 * witness


def test_accelerations_of_moving_pins_equal_mujocos_if_the_step_resolves_them() -> None:
    design = override(design_of("free", periods=18.0), ["settings.log_rate_hz=20000.0"])

    def level(model: Model) -> float:
        """Compute the rms acceleration of the output about the crank's [rad/s2]."""
        run = settled(simulate(design, model))
        error = run["output_speed"] - run["crank_speed"] / design.ratio
        return rms(np.diff(error) * design.settings.log_rate)

    reducer, theirs = Reducer(design), level(build(design))
    assert level(planar_model(reducer, timestep=acceleration_timestep(reducer))) == pytest.approx(theirs, rel=0.1)
    assert level(planar_model(reducer)) < 0.8 * theirs


@pytest.mark.parametrize("layout", ["drag", pytest.param("ring output, nonpin", marks=pytest.mark.slow)])
def test_every_column_of_the_log_is_mujocos(layout: str) -> None:
    """Chatter of contacts aside: what damping takes, iterations, and the spin that pins have by friction."""
    design = design_of(layout)
    ours, theirs = (settled(simulate(design, model)) for model in (planar_model(Reducer(design)), build(design)))
    assert ours.topics == theirs.topics
    assert ours.units == theirs.units
    np.testing.assert_allclose(ours.time, theirs.time, rtol=1e-12)
    pins = {name for stem in names.all_numbered(names.PIN, design.ring.teeth) for name in names.planar_joints(stem)[2:]}
    speeds = {names.planar_speeds(stem)[2] for stem in names.all_numbered(names.PIN, design.ring.teeth)}
    chatters = {"solver_iterations", "contacts"} | pins | speeds
    for name in ours.columns:
        if name in chatters or name.endswith("normal_power"):
            continue
        # what like things bear is seen against all of them: one may bear next to nothing
        like = [each for each in ours.columns if names.family(each.split("_force")[0]) == name]
        size = np.abs(np.stack([theirs[each] for each in like or [name]])).max()
        size = max(size, 1e-3 * np.abs(theirs["peak_force"]).max() if "force" in name else 0.0)
        assert np.sqrt(np.mean((ours[name] - theirs[name]) ** 2)) <= 5e-2 * size, name


@pytest.mark.parametrize("layout", ["fixed", "free", pytest.param("sleeves on a ring", marks=pytest.mark.slow)])
def test_energy_is_conserved(layout: str) -> None:
    """What comes in leaves as friction and damping, or stays in motion, height and the depth of contacts."""
    design = design_of(layout)
    step = planar_model(Reducer(design)).timestep
    run = simulate(override(design, [f"settings.log_rate_hz={1.0 / step!r}"]), planar_model(Reducer(design)))
    late = settled(run)
    supplied = (late["crank_torque"] * late["crank_speed"]).mean()
    given = (late["load_torque"] * late["output_speed"]).mean()
    taken = sum(late[name].mean() for name in late.columns if name.endswith(("friction_power", "normal_power")))
    energy = late["potential_energy"] + late["kinetic_energy"]
    stored = (energy[-1] - energy[0]) / (late.time[-1] - late.time[0])
    assert supplied + given - taken - stored == pytest.approx(0.0, abs=2e-5 * supplied)


def test_errors_fall_with_the_square_of_the_step() -> None:
    def end(step: float) -> np.ndarray:
        design = override(design_of("nonpin"), ["drive.hold_s=0.0041"])
        run = simulate(design, planar_model(Reducer(design), timestep=step))
        error = run["output_angle"] + run["crank_angle"] / design.lobes
        return np.array([run["gear_x"][-1], run["gear_y"][-1], error[-1]])

    exact = end(0.5e-6)
    coarse, fine = (np.abs(end(step) - exact) for step in (20e-6, 5e-6))
    order = np.log(coarse / fine) / np.log(4.0)
    assert ((order > 1.6) & (order < 2.4)).all()


@pytest.mark.parametrize("layout", ["fixed", pytest.param("free", marks=pytest.mark.slow)])
def test_a_held_output_and_a_driven_crank_agree(layout: str) -> None:
    """The drive is driven back: a torque on the crank, and an output that turns it."""
    design = design_of(layout)
    torque = rising(-0.6, 0.005)
    models = planar_model(Reducer(design), "output"), build(design, held="output")
    ours, theirs = (settled(simulate(design, each, braked_output(each, Reducer(design), torque))) for each in models)
    assert ours["load_torque"].mean() == pytest.approx(theirs["load_torque"].mean(), rel=1e-3)
    assert ours["crank_speed"].mean() == pytest.approx(theirs["crank_speed"].mean(), rel=1e-4)


def test_a_locked_crank_deflects_equally_in_both_solvers() -> None:
    design = design_of("massless")
    angles = [
        settled(simulate(design, each, locked_crank(each, 0.3, rising(20.0, 0.01))))["output_angle"].mean()
        for each in (planar_model(Reducer(design)), build(design))
    ]
    assert angles[0] == pytest.approx(angles[1], rel=1e-3)


def test_a_start_from_rest_follows_its_law() -> None:
    design = override(PRESETS["pin"], ["drive.ramp_s=0.01", "drive.hold_s=0.002", "ring.pins='fixed'"])
    run = simulate(design, planar_model(Reducer(design)))
    law = CrankLaw(design.drive.speed, design.drive.ramp)
    np.testing.assert_allclose(run["crank_speed"], law.speed_at(run.time), atol=1e-3 * design.drive.speed)


def test_without_friction_all_power_comes_out() -> None:
    """Over a mesh period springs and masses give back what they take; damping takes next to nothing."""
    design = design_of_kind(FIXED, *without_friction(), "load.torque_nm=36.0", f"drive.hold_s={2.0 * SETTLED + MESH!r}")
    late = settled(simulate(design, planar_model(Reducer(design))))
    assert efficiency(late) == pytest.approx(1.0, abs=1e-3)


def test_a_run_that_penetrates_too_deeply_ends() -> None:
    design = override(design_of("fixed"), ["contact.max_penetration_um=0.5"])
    with pytest.raises(RunError, match=r"penetrates by .* um, more than contact"):
        simulate(design, planar_model(Reducer(design)))


def test_slices_are_mujocos_alone() -> None:
    with pytest.raises(UsageError, match="exact profiles only"):
        model_for("planar", Reducer(PRESETS["pin"]), "mesh")


def test_an_automatic_step_fits_between_samples() -> None:
    design = override(PRESETS["pin"], ["settings.log_rate_hz=30000.0"])
    model = planar_model(Reducer(design))
    assert model.timestep <= 35e-6
    assert (1.0 / 30000.0 / model.timestep) == pytest.approx(round(1.0 / 30000.0 / model.timestep))
    assert planar_model(Reducer(override(design, ["settings.timestep_us=3.0"]))).timestep == 3e-6


def test_a_long_step_stays_bounded() -> None:
    """Normals turn in tight valleys and in the play of a cam: where a step goes far, contacts are looked for anew."""
    design = override(design_of("fixed"), ["settings.timestep_us=100.0", "settings.log_rate_hz=10000.0"])
    fine = override(design, ["settings.timestep_us=10.0"])
    errors = [transmission_error(settled(simulate(each, planar_model(Reducer(each)))), each) for each in (design, fine)]
    assert errors[0].mean() == pytest.approx(errors[1].mean(), rel=1e-4)


def test_reversing_friction_needs_few_iterations() -> None:
    """Hardly pressed contacts creep in a narrow range of speeds: rounds of a step must not jump over it for ever."""
    run = settled(simulate(design_of("free", 0.03), planar_model(Reducer(design_of("free", 0.03)))))
    assert run["solver_iterations"].max() < 30


def test_many_light_pins_that_rattle_settle() -> None:
    """Both contacts of a pin of 28 mg change at once: a step of one sample in thirteen did not settle."""
    design = design_of_kind(FREE, *MANY_LIGHT_PINS)
    rounds = simulate(design, planar_model(Reducer(design)))["solver_iterations"]
    assert np.mean(rounds > NEWTON.max_iterations) < 0.02
    assert rounds.mean() < 12.0


def test_a_run_at_high_friction_agrees_unless_friction_leads(monkeypatch: pytest.MonkeyPatch) -> None:
    design = override(witness.high_friction(), [f"drive.hold_s={SETTLED + MESH!r}"])
    assert all(row.verdict == "pass" for row in witness.comparison_rows("short", Reducer(design)))
    monkeypatch.setattr("cycloid_mj.dynamics.mjcf.model.impratio", lambda *_: 2e5)
    assert sum(row.verdict == "fail" for row in witness.comparison_rows("short", Reducer(design))) >= 2


def test_half_the_step_of_the_witness_changes_nothing() -> None:
    design = override(witness.high_friction(), [f"drive.hold_s={SETTLED + MESH!r}"])
    np.testing.assert_allclose(
        witness.planar_figures(Reducer(design)),
        witness.planar_figures(Reducer(design), 0.5 * witness.WITNESS.timestep),
        rtol=2e-3,
    )


@pytest.mark.slow
@pytest.mark.parametrize("case", witness.CASES)
def test_runs_agree_with_the_witness(case: str) -> None:
    assert all(row.verdict == "pass" for row in witness.comparison_rows(case, Reducer(witness.CASES[case]())))
