"""Run-out of the output of an RV reducer: a wave of order 1 with the amplitude of the run-out over its radius."""

import numpy as np
import pytest

from cycloid_mj.base.units import ARCSECOND
from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.planar.model import planar_model
from cycloid_mj.explore.tolerances import tolerance
from cycloid_mj.measure.trace import TraceCondition, run_trace
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.rv_motion import runout_at, rv_transmission_error
from cycloid_mj.statics.rv_sheet import closed_rotation

RUNOUT = ("crank_errors.output_x_um=6", "crank_errors.output_y_um=-8")
"""10 um on the pin circle, whose radius is 77.5 mm: 26.6 arcsec."""

AMPLITUDE = 10e-6 / 77.5e-3


def drive(*changes: str, member: str = "carrier") -> RvReducer:
    return RvReducer(override(PRESETS["rv80e"], [f"output.member={member}", *changes]))


def orders(rotation: np.ndarray) -> np.ndarray:
    """Amplitudes of the orders 0, 1, 2, ... over a turn of the output [rad]."""
    return 2.0 * np.abs(np.fft.rfft(rotation)) / rotation.size


@pytest.mark.parametrize("member", ["carrier", "ring"])
def test_order_1_has_the_amplitude_of_run_out_over_radius(member: str) -> None:
    found = orders(closed_rotation(drive(*RUNOUT, member=member)))
    assert found[1] == pytest.approx(AMPLITUDE, rel=1e-12)
    assert found[1] / ARCSECOND == pytest.approx(26.6, abs=0.05)
    assert np.delete(found, 1).max() < 1e-12 * found[1]
    wider = drive(*RUNOUT, "crank_errors.output_radius_mm=155", member=member)
    assert orders(closed_rotation(wider))[1] == pytest.approx(0.5 * AMPLITUDE, rel=1e-12)


def test_a_radius_alone_is_no_error() -> None:
    assert not drive("crank_errors.output_radius_mm=50").has_errors
    assert drive(*RUNOUT).has_errors


@pytest.mark.parametrize("member", ["carrier", "ring"])
def test_statics_adds_the_wave_to_the_transmission_error_of_the_load(member: str) -> None:
    perfect, eccentric = drive(member=member), drive(*RUNOUT, member=member)
    crank = np.array([0.0, 40.0, 100.0])
    errors = [item.member.sense * rv_transmission_error(item, crank, 784.0) for item in (perfect, eccentric)]
    output = perfect.member.output_angle(perfect.member.driven_angle(crank))
    wave = (-8e-6 * np.sin(output) - 6e-6 * np.cos(output)) / 77.5e-3
    assert errors[1][:, 1] - errors[0][:, 1] == pytest.approx(wave, abs=1e-12)
    assert np.array_equal(errors[1][:, 0], errors[0][:, 0])


@pytest.mark.slow
def test_a_run_has_the_wave_too() -> None:
    perfect, eccentric = (drive("ring.pins=fixed", *changes) for changes in ((), RUNOUT))
    condition = TraceCondition("loaded", "forward", "speed", 784.0, perfect.design.drive.speed)
    first, second = (run_trace(item, planar_model(item), 0.05, condition) for item in (perfect, eccentric))
    assert second.output - first.output == pytest.approx(runout_at(eccentric, first.crank) / ARCSECOND, abs=1e-6)
    assert np.abs(second.output - first.output).max() > 1.0
    assert np.array_equal(second.gear, first.gear)


def test_tolerance_draws_the_run_out() -> None:
    """A uniform offset along x and along y has the variance w^2/3 each."""
    design = override(PRESETS["rv80e"], ['crank_tolerance.output_runout="uniform 6"'])
    study = tolerance(design, 4000)
    expected = 2.0 * 6e-6 / 77.5e-3 / ARCSECOND
    assert study.figures["te_errors_arcsec"].max() == pytest.approx(np.sqrt(2.0) * expected, rel=0.03)
    assert np.mean(study.figures["te_errors_arcsec"] ** 2) == pytest.approx(2.0 * expected**2 / 3.0, rel=0.05)
    assert [share.source for share in study.budget] == ["output_runout"]
