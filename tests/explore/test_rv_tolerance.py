"""Tolerance study of an RV reducer: published spread, error budget, and the worst samples in the balance."""

import math

import numpy as np
import pytest

from cycloid_mj.base.engine import Engine
from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.units import ARCSECOND
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.explore import tolerances
from cycloid_mj.explore.rv_samples import FIGURE, draw_rv_drive
from cycloid_mj.explore.tolerances import StudyInterrupted, tolerance
from cycloid_mj.explore.verify import DynamicsCheck
from cycloid_mj.reducer import Reducer, RvReducer
from cycloid_mj.statics import main as statics
from cycloid_mj.statics.rv_sheet import closed_rotation, pin_equilibrium

ZONES = {
    "eccentricity": "uniform 3",
    "phase": "uniform 3",
    "bore_position": "uniform 4",
    "carrier_position": "uniform 4",
    "planet_runout": "uniform 5",
    "axis_position": "uniform 5",
}


def toleranced(**zones: str) -> Design:
    """Return the preset with tolerances."""
    return override(PRESETS["rv80e"], {f"crank_tolerance.{key}": text for key, text in zones.items()})


def test_spread_of_the_transmission_error_is_that_of_the_derivation() -> None:
    """2.9, 11.1 and 22.6 arcsec at 5, 50 and 95 % of 2000 samples, drawn by another program."""
    study = tolerance(toleranced(**ZONES), 4000, limits=["te_errors_arcsec<=20"])
    assert np.percentile(study.figures["te_errors_arcsec"], [5, 50, 95]) == pytest.approx([2.9, 11.1, 22.6], rel=0.1)
    assert 0.85 < study.good.mean() < 0.95
    assert study.budget[0].source == "bore_position"
    assert sum(share.total for share in study.budget) == pytest.approx(1.0)
    shares = {share.source: share.total for share in study.budget}
    # two opposed discs cancel what is common to both
    assert max(shares["carrier_position"], shares["axis_position"]) < 1e-9


@pytest.mark.slow
def test_the_worst_sample_has_its_error_in_the_balance_of_springs() -> None:
    (worst, *_) = tolerance(toleranced(**ZONES), 200).worst
    found = {key: item.value for key, item in statics(worst).quantities.items()}
    assert found["te_ideal"] == pytest.approx(found["te_errors"], rel=0.05)


def test_a_single_tolerance_has_the_variance_of_its_closed_form() -> None:
    """Each of six eccentricities turns the output by a wave of 15.84 arcsec per 10 um, peak to peak."""
    study = tolerance(toleranced(eccentricity="normal 1"), 4000)
    amplitude = 0.5 * 15.84 / 10.0
    # the errors of both discs add up as vectors in three directions: each component has half of the sum of squares
    rms = math.sqrt(6.0 * amplitude**2)
    ranges = study.figures["te_errors_arcsec"]
    assert math.sqrt(np.mean((0.5 * ranges) ** 2)) == pytest.approx(rms, rel=0.05)


def test_a_design_without_tolerances_and_other_figures_are_refused() -> None:
    with pytest.raises(UsageError, match="crank_tolerance"):
        tolerance(PRESETS["rv80e"], 10)
    with pytest.raises(UsageError, match="Use --limit with te_errors_arcsec instead"):
        tolerance(toleranced(phase="uniform 3"), 10, limits=["backlash_arcmin<=1"])


def test_an_interrupted_simulation_keeps_the_study(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C in the second simulation: the study has all samples, its budget and the first simulation."""
    design, finished = toleranced(**ZONES), DynamicsCheck("first", {FIGURE: 2.0}, {FIGURE: 3.0})
    checks = iter([finished])

    def simulate(_: Reducer, solver: str) -> DynamicsCheck:
        if check := next(checks, None):
            return check
        raise KeyboardInterrupt

    monkeypatch.setattr(tolerances, "verify_design", simulate)
    with pytest.raises(StudyInterrupted) as stop:
        tolerance(design, 100, verify=2, engine=Engine(1))
    study, complete = stop.value.tolerances, tolerance(design, 100)
    assert study.verified == (finished,)
    assert np.array_equal(study.figures[FIGURE], complete.figures[FIGURE])
    assert study.budget == complete.budget


@pytest.mark.slow
def test_a_run_of_the_worst_sample_has_the_transmission_error_of_statics() -> None:
    (check,) = tolerance(toleranced(**ZONES), 200, verify=1).verified
    assert not check.note
    assert check.statics["te_loaded_forward_arcsec"] > 10.0
    for key, difference in check.differences.items():
        assert abs(difference) < 0.02, key


PINS = {"pin_position": "uniform 3"}


def test_pins_have_a_share_of_the_budget_and_add_to_the_transmission_error() -> None:
    """The variances of independent sources add up, and no error changes a range by more than its own."""
    samples = 30
    study, other = tolerance(toleranced(**ZONES, **PINS), samples), tolerance(toleranced(**ZONES), samples)
    shares, (bores, *_) = {share.source: share.total for share in study.budget}, other.budget
    assert sum(shares.values()) == pytest.approx(1.0)
    assert bores.total / shares["bore_position"] == pytest.approx(1.0 / (1.0 - shares["pin_position"]))
    drawn = np.array([[study.drawn[f"pin_{axis}_{pin}"] for axis in "xy"] for pin in range(1, 41)])
    assert np.abs(drawn).max() == pytest.approx(3.0, rel=0.01)
    balance = pin_equilibrium(RvReducer(toleranced()))
    rotations = np.array([balance.rotation(1e-6 * drawn[..., row]) for row in range(samples)]) / ARCSECOND
    change = np.abs(study.figures[FIGURE] - other.figures[FIGURE])
    assert np.all(change <= np.ptp(rotations, axis=1) + 1e-9)
    variance = np.var(closed_rotation(RvReducer(toleranced().but(crank_errors={"bore_x": (1e-6, *[0.0] * 5)}))))
    # uniform 4: variance 16/3; 12 coordinates of bores
    expected = 12.0 * 16.0 / 3.0 * variance / ARCSECOND**2
    measured = np.var(rotations, axis=1).mean() * shares["bore_position"] / shares["pin_position"]
    assert measured == pytest.approx(expected, rel=0.01)


def test_a_drawn_drive_has_the_pins_of_its_sample() -> None:
    reducer = RvReducer(toleranced(**PINS))
    drive, errors = draw_rv_drive(reducer, 3, 7)
    assert drive.errors.pin_x[4] == pytest.approx(1e-6 * errors["drawn_pin_x_5_um"])
    assert drive.errors.pin_y[39] == pytest.approx(1e-6 * errors["drawn_pin_y_40_um"])
    own = toleranced(**PINS).but(errors={"pin_x": (1e-6,) * 40})
    shifted, _ = draw_rv_drive(RvReducer(own), 3, 7)
    assert np.subtract(shifted.errors.pin_x, drive.errors.pin_x) == pytest.approx(1e-6)


def test_errors_of_the_nominal_pins_are_in_all_samples() -> None:
    own = np.random.default_rng(1).normal(0.0, 2e-6, (40, 2))
    pins = {"pin_x": tuple(own[:, 0].tolist()), "pin_y": tuple(own[:, 1].tolist())}
    design = toleranced(phase="uniform 0.001").but(errors=pins)
    expected = np.ptp(pin_equilibrium(RvReducer(design)).rotation(own)) / ARCSECOND
    assert tolerance(design, 10).figures[FIGURE] == pytest.approx(expected, abs=0.02)


@pytest.mark.slow
def test_the_worst_sample_with_pins_has_its_error_in_the_balance_of_springs() -> None:
    (worst, *_) = tolerance(toleranced(**ZONES, **PINS), 200).worst
    computed = {key: item.value for key, item in statics(worst).quantities.items()}
    assert computed["te_ideal"] == pytest.approx(computed["te_errors"], rel=0.05)
