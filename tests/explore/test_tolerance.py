"""Tolerances: zones, draws, yield and budget, against the linear programme of rigid parts and the tables of ISO 286."""

import json
from dataclasses import astuple, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from designs import UNLIKE, unlike
from scipy.stats import binomtest

from cycloid_mj.base.engine import Engine
from cycloid_mj.base.errors import DesignError, UsageError
from cycloid_mj.cli import main
from cycloid_mj.cli.terminal import finite
from cycloid_mj.design import PRESETS, Design, load, override
from cycloid_mj.design.model import NO_FRICTION
from cycloid_mj.design.zone import Zone, parse_zone
from cycloid_mj.explore import budget, sampling, tolerances
from cycloid_mj.explore.constraints import parse_limit, require_consistent
from cycloid_mj.explore.tolerances import tolerance
from cycloid_mj.explore.verify import DynamicsCheck, verify_design
from cycloid_mj.figures import figure, sampled
from cycloid_mj.reducer import Reducer
from cycloid_mj.reducer.limits import best_fit, find_tightest_pairs, stops
from cycloid_mj.statics.samples import SampleFigures, solve_samples
from cycloid_mj.statics.springs import springs_of

PIN, NONPIN = PRESETS["pin"], PRESETS["nonpin"]
ANGLES = 6


@pytest.fixture(autouse=True)
def few_angles(monkeypatch):
    monkeypatch.setattr(tolerances, "ANGLES", ANGLES)
    monkeypatch.setattr(budget, "SOBOL", replace(budget.SOBOL, max_samples=64))


def play(design: Design) -> float:
    """Mean play of the output by the linear programme [arcmin], at the crank angles of the samples."""
    ends = [stops(Reducer(design), 2.0 * np.pi * i / ANGLES) for i in range(ANGLES)]
    return float(60.0 * np.degrees(np.mean([high - low for low, high in ends])))


def test_zones_are_read() -> None:
    assert parse_zone("", "cam", 0.03) is None
    assert parse_zone("0", "cam", 0.03) is None
    assert parse_zone("normal 2", "cam", 0.03) == Zone("normal", 0.0, 2e-6)
    assert parse_zone("Uniform 5", "cam", 0.03).width == pytest.approx(5e-6)
    between = parse_zone("between -1 4", "cam", 0.03)
    assert (between.middle, between.width) == pytest.approx((1.5e-6, 2.5e-6))


@pytest.mark.parametrize(
    ("size", "fit", "least", "most"), [(25e-3, "H7/g6", 7, 41), (40e-3, "H8/f7", 25, 89), (10e-3, "H7/h6", 0, 24)]
)
def test_fits_are_those_of_the_standard(size: float, fit: str, least: int, most: int) -> None:
    """ISO 286-1: limits of the clearance on the diameter [um], here half of it, 3 standard deviations to each side."""
    found = parse_zone(fit, "cam", size, 5e-6)
    low, high = (5e-6 + found.middle + sign * 3.0 * found.width for sign in (-1.0, 1.0))
    assert (low, high) == pytest.approx((0.5e-6 * least, 0.5e-6 * most), abs=1e-12)


@pytest.mark.parametrize(("size", "grade", "width"), [(25e-3, "IT6", 13), (81.5e-3, "IT7", 35), (4.5e-3, "IT5", 5)])
def test_grades_are_those_of_the_standard(size: float, grade: str, width: int) -> None:
    assert 6.0 * parse_zone(grade, "pin_radius", size).width == pytest.approx(0.5e-6 * width)


@pytest.mark.parametrize(
    "text", ["normal", "normal x", "normal -1", "between 2 1", "IT99", "H7/z99", "H7/g6 about", "five", "normal 1 2"]
)
def test_other_words_are_no_tolerance(text: str) -> None:
    with pytest.raises(DesignError, match=r"tolerance\.cam = "):
        parse_zone(text, "cam", 0.03, 1e-6)


@pytest.mark.parametrize(
    "text", ["uniform inf", "normal inf", "between -inf 1", "between 0 inf", "normal nan", "uniform 1e300"]
)
def test_infinite_zones_are_refused_before_any_sample(tmp_path: Path, capsys, text: str) -> None:
    flags = ["--samples", "8", "--out", str(tmp_path)]
    assert main(["tolerance", "--design", "pin", "--set", f'tolerance.mesh="{text}"', *flags]) == 1
    said = capsys.readouterr().err
    assert "tolerance.mesh" in said
    assert "out of range, which is -1e+06 to 1e+06 um" in said
    assert not list(tmp_path.iterdir())


def test_a_fit_applies_to_a_clearance_only() -> None:
    with pytest.raises(DesignError, match=r"tolerance\.pin_radius"):
        parse_zone("H7/g6", "pin_radius", 0.0045)


def drawn(design: Design, samples: int, seed: int) -> dict[str, np.ndarray]:
    """How far samples that depart in single numbers alone do so [m], by tolerance."""
    zones = sampling.tolerance_zones(Reducer(design))
    made = [sampling.draw_deviations(Reducer(design), zones, seed, block) for block in sampling.list_batches(samples)]
    return {key: np.concatenate([one[key] for one in made]) for key in zones}


@pytest.mark.slow
@pytest.mark.parametrize("design", [PIN, pytest.param(NONPIN, marks=pytest.mark.slow)], ids=["pin", "nonpin"])
def test_small_tolerances_add_up_as_their_gradients(design: Design, monkeypatch) -> None:
    """Mean, standard deviation and shares of the backlash of what was drawn, by the slopes of the rigid play."""
    monkeypatch.setattr(budget, "SOBOL", budget.SobolSettings())
    sigma = {"cam": 0.02e-6, "mesh": 0.01e-6, "output": 0.03e-6}
    slopes = {}
    for key in sigma:
        kind = design.tooth_pair if key == "mesh" else key
        step = 0.01e-6
        ends = [
            play(design.but(clearance={kind: getattr(design.clearance, kind) + side * step})) for side in (-1.0, 1.0)
        ]
        slopes[key] = (ends[1] - ends[0]) / (2.0 * step)
    expected = {key: (slopes[key] * sigma[key]) ** 2 for key in sigma}
    toleranced = override(design, [f'tolerance.{key}="normal {1e6 * value!r}"' for key, value in sigma.items()])
    found = tolerance(toleranced, 512, 3)
    figures = found.distributions["backlash_arcmin"]
    linear = sum(slopes[key] * values for key, values in drawn(toleranced, 512, 3).items())
    assert figures.mean == pytest.approx(play(design) + np.mean(linear), rel=2e-3)
    assert figures.std == pytest.approx(np.std(linear, ddof=1), rel=5e-3)
    # the draws themselves: four standard errors of a standard deviation
    assert np.std(linear) == pytest.approx(np.sqrt(sum(expected.values())), rel=4.0 / np.sqrt(2.0 * 512.0))
    for share in found.budget:
        exact = expected[share.source] / sum(expected.values())
        assert (share.first_order, share.total) == pytest.approx((exact, exact), abs=0.02)
        assert share.ci95[0] - 0.01 <= exact <= share.ci95[1] + 0.01


@pytest.mark.parametrize("design", [PIN, NONPIN], ids=["pin", "nonpin"])
def test_cam_compliance_matches_closed_form(design: Design) -> None:
    """Its play delta turns the output by 2 delta/(c (N - 1)), where no other pair has any."""
    none = dict.fromkeys((kind for kind in design.pair_kinds if kind != "cam"), 1e-12)
    alone = override(design.but(clearance=none), {"tolerance.cam": "normal 0.05"})
    figures = tolerance(alone, 200, 2).distributions["backlash_arcmin"]
    turn = 60.0 * np.degrees(2.0 / (design.gear.eccentricity * design.lobes))
    cam = drawn(alone, 200, 2)["cam"]
    assert figures.mean == pytest.approx(turn * (design.clearance.cam + np.mean(cam)), rel=0.005)
    assert figures.std == pytest.approx(turn * np.std(cam, ddof=1), rel=0.005)


@pytest.mark.slow
def test_equal_seeds_are_bit_equal_with_any_number_of_workers() -> None:
    design = override(PIN, ['tolerance.pin_position="normal 0.2"', 'tolerance.cam="uniform 0.3"'])
    cases = ((1, Engine(1)), (1, Engine(2, "threads")), (1, Engine(2)), (2, Engine(1)))
    one, two, apart, other = (tolerance(design, 64, seed, engine=engine) for seed, engine in cases)
    for key, values in one.figures.items():
        assert np.array_equal(values, two.figures[key])
        assert np.array_equal(values, apart.figures[key])
        assert not np.array_equal(values, other.figures[key])
    assert len(one.budget) == 2
    assert one.budget == two.budget == apart.budget


def test_the_samples_are_a_table() -> None:
    found = tolerance(override(PIN, {"tolerance.cam": "uniform 0.3"}), 4, 0)
    assert found["sample"].tolist() == [1, 2, 3, 4]
    assert np.array_equal(found["backlash_arcmin"], found.figures["backlash_arcmin"])
    assert (np.abs(found["drawn_cam_um"]) <= 0.3).all()
    assert found.frame.units["drawn_cam_um"] == "um"
    assert found.frame.units["cam_force_n"] == "N"
    assert "loaded_teeth" not in found.frame.units


@pytest.mark.parametrize(("samples", "each"), [(2, 0), (63, 0), (64, 80), (100, 100), (10_000, 512)])
def test_the_budget_has_as_many_samples_as_the_study(monkeypatch, samples: int, each: int) -> None:
    """Two sets, and the first with each of two tolerances of the second: none below 64 samples, 80 to 512 each."""
    monkeypatch.setattr(budget, "SOBOL", budget.SobolSettings())
    counts = []

    def stop(_done: int, whole: int) -> None:
        counts.append(whole)
        raise KeyboardInterrupt

    monkeypatch.setattr(tolerances, "ANGLES", 1)
    two = override(PIN, {"tolerance.cam": "uniform 0.3", "tolerance.mesh": "uniform 0.1"})
    with pytest.raises(tolerances.StudyInterrupted):
        tolerance(two, samples, progress=stop, engine=Engine(1))
    assert counts == [samples + 4 * each]


def test_drawn_values_are_listed_next_to_the_figures() -> None:
    words = {"cam": "between -0.3 -0.1", "pin_position": "normal 0.01", "hole_position": "normal 0.01"}
    words |= {"disc_size": "uniform 0.01", "profile": "2: normal 0.01"}
    design = override(PRESETS["twodisc"], {f"tolerance.{key}": text for key, text in words.items()})
    zones, block = sampling.tolerance_zones(Reducer(design)), sampling.Batch(0, 3)
    found, made = (
        sampling.deviation_columns(sampling.draw_deviations(Reducer(design), zones, 0, block)),
        sampling.draw_samples(Reducer(design), zones, 0, block),
    )
    assert ((found["drawn_cam_um"] >= -0.3) & (found["drawn_cam_um"] <= -0.1)).all()
    for column, values in (
        ("cam", made.cam - design.clearance.cam),
        ("pin_position_2_y", made.pin_displacement[:, 1, 1]),
        ("hole_position_2_3_x", made.hole_displacement[:, 1, 2, 0]),
        ("disc_size_2", made.disc_radius[:, 1]),
        ("profile_2_sin", made.waves[:, 1, 1]),
    ):
        assert 1e-6 * found[f"drawn_{column}_um"] == pytest.approx(values, abs=1e-15)
    assert len(found) == 1 + 2 * design.ring.teeth + 4 * design.output.pins + 2 + 2


def test_the_first_samples_are_the_same_however_many_there_are(monkeypatch) -> None:
    monkeypatch.setattr(sampling, "SAMPLING", sampling.SamplingSettings(block=8, first_batch=3))
    design = override(PIN, ['tolerance.cam="uniform 0.3"'])
    few, many = (tolerance(design, count, 1).figures["backlash_arcmin"] for count in (16, 30))
    assert np.array_equal(few, many[:16])
    assert len(np.unique(many)) == 30


def stopping_after(count: int):
    """Return a progress that Ctrl-C comes in as soon as so many samples are balanced."""

    def progress(done: int, _: int) -> None:
        if done >= count:
            raise KeyboardInterrupt

    return progress


@pytest.mark.parametrize("engine", [Engine(1), Engine(2, "threads")], ids=["alone", "threads"])
def test_ctrl_c_leaves_the_figures_of_a_shorter_study(monkeypatch, engine: Engine) -> None:
    monkeypatch.setattr(sampling, "SAMPLING", sampling.SamplingSettings(block=8))
    design = override(PIN, ['tolerance.cam="uniform 0.3"', 'tolerance.mesh="uniform 0.1"'])
    with pytest.raises(tolerances.StudyInterrupted) as stopped:
        tolerance(design, 40, 1, ["backlash_arcmin<=1"], stopping_after(17), engine)
    found = stopped.value.tolerances
    shorter = tolerance(design, found.samples, 1, ["backlash_arcmin<=1"])
    assert found.samples in (8, 16, 24)
    assert found.asked == 40
    for key, values in shorter.figures.items():
        assert np.array_equal(found.figures[key], values)
    assert found.worst == shorter.worst
    assert found.budget == ()
    assert "no error budget: it takes 64 samples or more" in found.notes[0]
    assert f"{found.samples} of 40 samples" in found.words


def test_ctrl_c_before_the_first_block_is_no_study(monkeypatch) -> None:
    def pressed(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(tolerances, "solve_sample_batch", pressed)
    with pytest.raises(KeyboardInterrupt) as stopped:
        tolerance(override(PIN, {"tolerance.cam": "uniform 0.3"}), 8, 1, engine=Engine(1))
    assert not isinstance(stopped.value, tolerances.StudyInterrupted)


def test_ctrl_c_among_the_runs_of_the_worst_keeps_those_that_are_done(monkeypatch) -> None:
    whole = DynamicsCheck("done", {"cam_force_n": 2.0}, {"cam_force_n": 3.0})
    runs = iter([whole])

    def run(_: Design, solver: str) -> DynamicsCheck:
        try:
            return next(runs)
        except StopIteration:
            raise KeyboardInterrupt from None

    monkeypatch.setattr(tolerances, "verify_design", run)
    design = override(PIN, ['tolerance.cam="uniform 0.3"', 'tolerance.mesh="uniform 0.1"'])
    with pytest.raises(tolerances.StudyInterrupted) as stopped:
        tolerance(design, 64, 1, engine=Engine(1), verify=3)
    assert stopped.value.tolerances.verified == (whole,)
    assert stopped.value.tolerances.budget == tolerance(design, 64, 1).budget


@pytest.mark.slow
def test_the_worst_samples_are_designs_that_have_that_play() -> None:
    words = {
        "pin_position": "normal 0.1",
        "pin_radius": "normal 0.1",
        "hole_position": "normal 0.1",
        "cam": "uniform 0.4",
    }
    found = tolerance(override(PIN, {f"tolerance.{key}": text for key, text in words.items()}), 60, 5)
    worst = np.sort(found.figures["backlash_arcmin"])[::-1][: len(found.worst)]
    for design, value in zip(found.worst, worst, strict=True):
        assert play(design) == pytest.approx(value, rel=5e-3)


@pytest.mark.slow
def test_errors_of_each_disc_are_drawn_and_budgeted() -> None:
    """Sizes and cams of two discs depart each by itself; the play is that of the rigid drive made so."""
    zones = {
        "tolerance.disc_size": "normal 0.4",
        "tolerance.cam_position": "normal 0.4",
        "tolerance.cam": "uniform 0.1",
    }
    found = tolerance(override(PRESETS["twodisc"], zones), 64, 5)
    widest = np.sort(found.figures["backlash_arcmin"])[-1]
    made = found.worst[0]
    assert made.errors.disc_dr[0] != made.errors.disc_dr[1]
    assert made.errors.cam_x[0] != made.errors.cam_x[1]
    assert play(made) == pytest.approx(widest, rel=5e-3)
    shares = {share.source: share.total for share in found.budget}
    assert set(shares) == {"disc_size", "cam_position", "cam"}
    assert min(shares["disc_size"], shares["cam_position"]) > shares["cam"]


def jammed_study(design: Design, samples: int) -> tolerances.Tolerances:
    """What a study that stops for its jams holds."""
    with pytest.raises(tolerances.TooManyJams) as stopped:
        tolerance(design, samples, 0)
    return stopped.value.tolerances


def test_parts_larger_than_their_clearances_jam() -> None:
    jammed = jammed_study(override(PIN, {"tolerance.mesh": "between -6 -5"}), 20)
    assert jammed.jams.all()
    assert jammed.as_json()["yield"] == 0.0
    assert not tolerance(override(PIN, {"tolerance.mesh": "between 0 1"}), 20, 0).jams.any()


@pytest.mark.parametrize("pair", ["mesh", "seat", "cam", "output"])
def test_every_pair_that_interferes_is_a_jam_by_name(pair: str) -> None:
    """Clearances of 1 um (a pin's play of 1 more) drawn at 5 to 7 um less."""
    jammed = jammed_study(override(PIN, {f"tolerance.{pair}": "between -8 -6"}), 8)
    assert jammed.jams.all()
    assert (jammed.as_json()["yield"], jammed.worst, jammed.budget) == (0.0, (), ())
    assert f"without tolerance.{pair} the parts of these samples fit" in jammed.jammed_by
    (warning,) = jammed.warnings
    assert warning.startswith(f"8 of the first 8 samples jam (99% or more end a study): {jammed.jammed_by}")
    assert ("pin_gear interferes" if pair in ("mesh", "seat") else pair) in jammed.jammed_by


def test_a_cam_larger_than_its_bore_presses_as_its_spring_does() -> None:
    """Both sides press with stiffness times interference; a fit jams in as many samples as lie below zero."""
    stiffness = springs_of(Reducer(PIN), friction=False).contacts.cam_stiffness
    found = tolerance(override(PIN, {"tolerance.cam": "H7/k6"}), 150, 0)
    interference = -1e-6 - 1e-6 * found.drawn["drawn_cam_um"]
    pressed = interference > 0.0
    assert found.figures["cam_preload_n"][pressed] == pytest.approx(stiffness * interference[pressed], rel=0.01)
    surely = stiffness * interference > 0.011 * found.figures["cam_force_n"]
    assert 0.2 < surely.mean() < 0.6
    assert found.jams[surely].all()
    assert not found.jams[~pressed].any()
    assert found["jams"].tolist() == found.jams.astype(int).tolist()
    assert all(design.clearance.cam > 0.0 for design in found.worst)
    assert "the cam in" in found.notes[0]


def test_jams_are_not_in_the_budget(monkeypatch) -> None:
    """Its variance is that of the samples that go together."""
    words = {"tolerance.cam": "between -4 -0.5", "tolerance.mesh": "uniform 0.01"}
    seen = {}
    monkeypatch.setattr(tolerances, "compute_shares", lambda zones, sets, values: seen.update(values) or ())
    design = override(PIN, words)
    tolerance(design, 64, 0)
    cam = sampling.draw_deviations(
        Reducer(design),
        sampling.tolerance_zones(Reducer(design)),
        0,
        budget.list_budget_sets(sampling.tolerance_zones(Reducer(design)), 64)["A"],
    )
    assert np.isnan(seen["A"][cam["cam"] < -1.1e-6]).all()
    assert np.isfinite(seen["A"][cam["cam"] > -1e-6]).all()


@pytest.mark.parametrize("engine", [Engine(1), Engine(2, "threads")], ids=["alone", "threads"])
def test_a_study_whose_beginning_jams_ends_with_the_cause(monkeypatch, engine: Engine) -> None:
    monkeypatch.setattr(sampling, "SAMPLING", sampling.SamplingSettings(first_batch=6))
    design = override(PIN, {"tolerance.cam": "H7/g6", "tolerance.pin_position": "normal 2"})
    with pytest.raises(
        tolerances.TooManyJams, match=r"^6 of the first 6 samples jam .*pin_gear interferes by"
    ) as stopped:
        tolerance(design, 300, 0, engine=engine)
    assert stopped.value.tolerances.samples == 6
    assert "without tolerance.pin_position the parts" in str(stopped.value)


def test_a_study_with_mostly_jammed_samples_ends_after_its_first_block(monkeypatch) -> None:
    """A cam 3 um too small to 1000 um too large: 2 of 1000 fit."""
    monkeypatch.setattr(sampling, "SAMPLING", sampling.SamplingSettings(first_batch=40))
    design = override(PIN, {"tolerance.cam": "between -1000 1", "tolerance.mesh": "uniform 0.1"})
    with pytest.raises(tolerances.TooManyJams, match=r"of the first 40 samples jam .*cam interferes") as stopped:
        tolerance(design, 3000, 0)
    assert stopped.value.tolerances.samples == 40
    assert stopped.value.tolerances.budget == ()


def test_few_samples_that_fit_have_no_distribution_and_no_budget() -> None:
    """One or none of 12 samples fits: no row of NaN, no warning of numpy's (warnings are errors here)."""
    design = override(PIN, {"tolerance.cam": "between -12 0", "tolerance.mesh": "uniform 0.1"})
    found = tolerance(design, 12, 4)
    assert 0.5 < found.jams.mean() < 0.99
    text = json.dumps([[list(row) for row in table.rows] for table in found.tables()])
    assert "nan" not in text
    assert found.budget == ()
    assert found.line


def test_interference_of_rigid_parts_is_that_of_their_radii() -> None:
    """A cam or flanks that are too large by so much: the most room is that, and the pair is named."""
    for changed, pair, depth in (
        ({"cam": -3e-6}, "cam", 3e-6),
        ({"pin_gear": -2e-6, "pin_socket": 1e-9}, "pin_gear", 2e-6),
    ):
        tight = PIN.model_copy(update={"clearance": PIN.clearance.model_copy(update=changed)})
        room, shares = find_tightest_pairs(Reducer(tight), 0.3)
        assert room == pytest.approx(-depth, abs=2e-9)
        assert shares[pair] == pytest.approx(1.0)
    room, shares = find_tightest_pairs(Reducer(PIN), 0.3)
    assert room == pytest.approx(best_fit(Reducer(PIN), 0.3).min_gap)
    assert sum(shares.values()) == pytest.approx(1.0)


@pytest.mark.slow
def test_samples_without_a_balance_jam_and_the_others_keep_their_figures(monkeypatch) -> None:
    def without_the_eighth(*given: Any) -> list[SampleFigures]:
        one = solve_samples(*given)
        return [
            SampleFigures(*(np.where(np.arange(value.size) == 7, np.nan, value) for value in astuple(of))) for of in one
        ]

    monkeypatch.setattr(sampled, "solve_samples", without_the_eighth)
    # the eighth sample has no value in any set: draw one more than a budget needs
    monkeypatch.setattr(budget, "SOBOL", replace(budget.SOBOL, max_samples=budget.SOBOL.min_samples + 1))
    words = {"pin_position": "normal 0.1", "hole_position": "normal 0.1", "eccentricity": "normal 0.1", "cam": "H7/g6"}
    found = tolerance(override(NONPIN, {f"tolerance.{key}": text for key, text in words.items()}), 70, 0)
    lost = np.isnan(found.figures["backlash_arcmin"])
    assert np.flatnonzero(lost).tolist() == [7]
    assert found.jams[lost].all()
    assert not found.jams.all()
    assert len(found.budget) == len(words)
    assert np.isfinite([share.total for share in found.budget]).all()
    assert found.notes[0] == "pressed without a load: no balance in 1.43%"
    assert "lack pin_position" in found.notes[1]
    json.dumps(finite(found.as_json()), allow_nan=False)


@pytest.mark.slow
def test_dynamics_of_a_sample_are_next_to_its_statics() -> None:
    """Without friction a slow run is the statics, waves included; a load that nothing bears is told, and no error."""
    design = override(
        unlike("light"),
        {"drive.speed_rpm": 900, "errors.hole_x_um": {"1": 2.0}, "errors.profile_sin_um": {"2": 0.5}},
    )
    smooth = design.but(friction=NO_FRICTION)
    found = verify_design(Reducer(smooth))
    assert set(found.dynamics) == {"te_loaded_arcsec", "tooth_force_n", "output_pin_force_n", "cam_force_n"}
    for key, difference in found.differences.items():
        assert abs(difference) < (0.2 if key == "te_loaded_arcsec" else 0.03), (key, difference)
    assert found.statics["tooth_force_n"] > 10.0
    torn = verify_design(Reducer(design.but(contact={"max_penetration": 1e-9})))
    assert not torn.dynamics
    assert "max_penetration_um" in torn.note


# --- waves, yield and limits


def test_waves_have_the_amplitudes_of_their_zones_and_begin_anywhere() -> None:
    design = override(PIN, {"tolerance.profile": "2: normal 0.01, 35: uniform 0.02"})
    zones = sampling.tolerance_zones(Reducer(design))
    assert list(zones) == ["profile_2", "profile_35"]
    waves = sampling.draw_deviations(Reducer(design), zones, 0, sampling.Batch(0, 20_000, compared=True))
    for order, square in (("profile_2", 0.01e-6**2), ("profile_35", 0.02e-6**2 / 3.0)):
        assert np.mean(waves[order] ** 2, axis=0) == pytest.approx([square / 2.0] * 2, rel=0.05)
        assert np.abs(waves[order].mean(axis=0)).max() < 0.05 * np.sqrt(square)
    made = sampling.draw_samples(Reducer(design), zones, 0, sampling.Batch(0, 4))
    assert np.flatnonzero(np.any(made.waves != 0.0, axis=(0, 2))).tolist() == [1, 34]


@pytest.mark.parametrize("text", ["normal 1", "0: normal 1", "37: normal 1", "2: normal", "2: IT99", "1: IT5, 1: IT5"])
def test_other_words_are_no_waves(text: str) -> None:
    with pytest.raises(DesignError, match=r"tolerance\.profile"):
        sampling.tolerance_zones(Reducer(override(PIN, {"tolerance.profile": text})))


def test_yield_counts_what_keeps_the_limits() -> None:
    design = override(PIN, {"tolerance.cam": "uniform 0.5"})
    asked = [parse_limit("backlash_arcmin<=0.98"), parse_limit("backlash_arcmin >= 0.9")]
    found = tolerance(design, 300, 1, asked)
    values = found.figures["backlash_arcmin"]
    assert found.good.mean() == np.mean((values <= 0.98) & (values >= 0.9))
    interval = binomtest(int(found.good.sum()), 300).proportion_ci(method="wilson")
    assert found.yield_interval == pytest.approx((interval.low, interval.high), rel=1e-12)


def test_limits_that_contradict_each_other_are_refused(tmp_path: Path, capsys) -> None:
    flags = ["--limit", "backlash_arcmin<=1", "--limit", "backlash_arcmin>=2", "--out", str(tmp_path)]
    assert main(["tolerance", "--design", "pin", "--set", 'tolerance.cam="normal 0.2"', *flags]) == 2
    said = capsys.readouterr().err
    assert "'backlash_arcmin>=2' contradicts --limit 'backlash_arcmin<=1'" in said
    require_consistent(
        [parse_limit("backlash_arcmin<=1"), parse_limit("backlash_arcmin>=1"), parse_limit("mass_kg>=2")]
    )


@pytest.mark.parametrize(
    "zones", [{"cam": "normal 0.2"}, {"cam": "normal 0.2", "mesh": "normal 0.1"}], ids=["one", "two"]
)
def test_a_figure_that_does_not_vary_has_no_budget(zones: dict[str, str]) -> None:
    found = tolerance(override(PIN, {f"tolerance.{key}": text for key, text in zones.items()}), 64, 0, ["ratio<=35"])
    assert found.budget == ()
    assert "no error budget: ratio does not vary with these tolerances: it is 35 in every sample" in found.notes
    assert not any("tighten" in table.title for table in found.tables())


@pytest.mark.parametrize("text", ["play<=1", "backlash_arcmin<1", "backlash_arcmin<=x", "backlash_arcmin<=nan", ""])
def test_wrong_limits_are_refused(text: str) -> None:
    with pytest.raises(UsageError, match="--limit"):
        parse_limit(text)


@pytest.mark.parametrize("name", UNLIKE)
def test_other_designs(name: str) -> None:
    design = override(unlike(name), {"tolerance.cam": "uniform 1", "tolerance.hole_position": "normal 0.5"})
    found = tolerance(design, 10, 0)
    assert all(np.isfinite(values).all() for values in found.figures.values())


def test_the_command(tmp_path: Path, capsys) -> None:
    flags = ["--samples", "50", "--seed", "4", "--out", str(tmp_path), "--limit", "backlash_arcmin<=1"]
    assert main(["tolerance", "--design", "pin", "--set", 'tolerance.cam="normal 0.2"', *flags, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {"samples", "seed", "yield", "yield_ci95", "jam_probability", "quantities", "budget"} <= set(found)
    assert set(found["quantities"]["backlash_arcmin"]) == {"mean", "std", "p05", "p50", "p95", "unit"}
    assert set(found["budget"][0]) == {"source", "first_order", "total", "ci95"}
    page = (tmp_path / "pin-tolerance.html").read_text()
    assert page.count("data:image/svg+xml") == 2
    assert 'src="http' not in page
    header, *rows = (tmp_path / "pin-samples.csv").read_text().splitlines()
    assert header.startswith("sample,drawn_cam_um,backlash_arcmin,")
    assert len(rows) == 50
    assert load(tmp_path / "pin-worst-1.toml").clearance.cam > PIN.clearance.cam


def test_the_command_fails_with_one_message_if_all_of_few_samples_jam(tmp_path: Path, capsys) -> None:
    flags = ["--samples", "4", "--out", str(tmp_path), "--set", 'tolerance.cam="between -8 -6"']
    assert main(["tolerance", "--design", "pin", *flags]) == 1
    said = capsys.readouterr()
    start = "4 of the first 4 samples jam (99% or more end a study): in the first 4 of them cam interferes by"
    assert said.out == ""
    assert said.err.splitlines()[-1].startswith(f"error: {start}")
    assert said.err.count("interferes") == 1
    (warning,) = json.loads((tmp_path / "pin-tolerance.json").read_text())["warnings"]
    assert warning.startswith(start)


def test_the_command_keeps_what_jammed_and_fails(tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.setattr(sampling, "SAMPLING", sampling.SamplingSettings(first_batch=6))
    flags = ["--samples", "50", "--out", str(tmp_path), "--set", 'tolerance.cam="between -8 -6"', "--json"]
    assert main(["tolerance", "--design", "pin", *flags]) == 1
    said = capsys.readouterr()
    last = said.err.splitlines()[-1]
    assert last.startswith("error: 6 of the first 6 samples jam (99% or more end a study): in the first 6 of them cam ")
    assert json.loads(said.out)["jammed_by"] in last
    assert json.loads(said.out)["warnings"][0] in last
    assert len((tmp_path / "pin-samples.csv").read_text().splitlines()) == 7


def test_the_command_writes_what_is_done_at_ctrl_c(tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.setattr(sampling, "SAMPLING", sampling.SamplingSettings(block=8))
    monkeypatch.setattr("cycloid_mj.cli.progress.count_progress", lambda *_: stopping_after(16))
    zones = ["--set", 'tolerance.cam="normal 0.2"', "--set", 'tolerance.mesh="normal 0.1"']
    flags = [*zones, "--samples", "50", "--workers", "1", "--out", str(tmp_path), "--json"]
    assert main(["tolerance", "--design", "pin", *flags]) == 130
    said = capsys.readouterr()
    found = json.loads(said.out)
    assert (found["samples"], found["asked"], found["budget"]) == (16, 50, [])
    assert said.err.splitlines()[-1] == (
        f"error: stopped by Ctrl-C; the results of the 16 of 50 samples so far are in {tmp_path}. "
        "Run the command again for all samples"
    )
    assert len((tmp_path / "pin-samples.csv").read_text().splitlines()) == 17
    page = (tmp_path / "pin-tolerance.html").read_text()
    assert "16 of 50 samples" in page
    assert "Tighten this first" not in page


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        ([], "has no tolerances"),
        (["--set", 'tolerance.cam="normal 1"', "--samples", "1"], "--samples 1"),
        (["--set", 'tolerance.cam="normal 1"', "--seed", "-1"], "--seed -1"),
        (["--set", 'tolerance.cam="normal 1"', "--limit", "play<=1"], "unknown quantity 'play'"),
    ],
)
def test_wrong_wishes_are_refused(tmp_path: Path, capsys, flags: list[str], message: str) -> None:
    assert main(["tolerance", "--design", "pin", *flags, "--out", str(tmp_path)]) == 2
    assert message in capsys.readouterr().err


def test_a_limit_accepts_a_figure_evaluated_design_by_design() -> None:
    """Lost motion is not balanced for many samples at a time: each is a design, whose own value stands in the table."""
    design = override(PIN, {"tolerance.cam": "uniform 0.5"})
    found = tolerance(design, 3, 1, ["lost_motion_arcmin<=1.1"], engine=Engine(1, kind="threads"))
    assert not found.budget or found.budget_of == "lost_motion_arcmin"
    of_each = [
        figure("lost_motion_arcmin").value(
            Reducer(sampling.sample_design(Reducer(design), sampling.tolerance_zones(Reducer(design)), 1, number))
        )
        for number in range(3)
    ]
    assert found.figures["lost_motion_arcmin"].tolist() == pytest.approx(of_each, rel=1e-12)
    assert found.distributions["lost_motion_arcmin"].unit == "arcmin"
    assert any("lost_motion_arcmin: computed for each sample" in note for note in found.notes)


def test_a_limit_on_no_figure_proposes_near_names() -> None:
    with pytest.raises(
        UsageError, match="--limit 'tooth_force<=1': unknown quantity 'tooth_force'; did you mean tooth"
    ):
        parse_limit("tooth_force<=1")
