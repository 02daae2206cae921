"""Tolerance study of an RV reducer: published spread, error budget, and the worst samples in the balance."""

import math

import numpy as np
import pytest

from cycloid_mj.base.engine import Engine
from cycloid_mj.base.errors import UsageError
from cycloid_mj.design import PRESETS, Design, override
from cycloid_mj.explore import tolerances
from cycloid_mj.explore.rv_samples import FIGURE
from cycloid_mj.explore.tolerances import StudyInterrupted, tolerance
from cycloid_mj.explore.verify import DynamicsCheck
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics import main as statics

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
