"""Comparison of a measured transmission error of an RV reducer with its model, against the angle of the sun."""

import numpy as np
import pytest

from cycloid_mj.base.errors import UsageError
from cycloid_mj.base.units import ARCSECOND
from cycloid_mj.bench.te import MeasuredError, compare_bench
from cycloid_mj.design import PRESETS
from cycloid_mj.reducer import reducer_of
from cycloid_mj.statics import transmission_error
from cycloid_mj.statics.rv import runout_error

BORE = PRESETS["rv80e"].but(crank_errors={"bore_x": (1e-5, 0.0, 0.0, 0.0, 0.0, 0.0)})
LOAD = 100.0


@pytest.mark.slow
@pytest.mark.parametrize("member", ["carrier", "ring"])
def test_the_error_of_a_bore_is_explained_by_the_orders_of_the_cranks(member: str) -> None:
    design = BORE.but(output={"member": member})
    reducer = reducer_of(design)
    turns = 40 if member == "ring" else 39
    sun = reducer.member.driven_angle(-2.0 * np.pi * turns * np.arange(4000) / 4000)
    crank = reducer.member.crank_angle(sun)
    order = 1.0 if member == "ring" else 40.0 / 39.0
    model = reducer.member.sense * transmission_error(reducer, crank[:400] + 0.3, LOAD)[:, 1]
    # a bench that sees only the wave of the bore, with another zero of its encoder
    waves = np.stack([np.ones(400), np.cos(order * crank[:400]), np.sin(order * crank[:400])], axis=1)
    offset, cosine, sine = np.linalg.lstsq(waves, model, rcond=None)[0]
    error = offset + cosine * np.cos(order * crank) + sine * np.sin(order * crank)
    comparison = compare_bench(design, MeasuredError("bench", sun, error), LOAD)
    assert comparison.explained_share > 0.99
    strongest = comparison.strongest_first[0]
    assert comparison.order[strongest] == pytest.approx(order)
    assert abs(comparison.bench_amplitude[strongest]) > 2.0 * ARCSECOND
    assert abs(comparison.model_amplitude[strongest] / comparison.bench_amplitude[strongest]) == pytest.approx(
        1.0, rel=0.02
    )
    assert "cranks" in comparison.causes[strongest]


@pytest.mark.slow
@pytest.mark.parametrize("member", ["carrier", "ring"])
def test_order_1_of_a_measurement_is_explained_by_the_run_out_of_the_output(member: str) -> None:
    """A bench that sees the closed form of the run-out, 26.6 arcsec for 10 um on 77.5 mm, with its encoder at 1 rad."""
    design = PRESETS["rv80e"].but(crank_errors={"output_x": 1e-5}, output={"member": member})
    reducer = reducer_of(design)
    output = np.linspace(0.0, 2.0 * np.pi, 4000, endpoint=False)
    sun = output * float(reducer.design.ratio)
    comparison = compare_bench(design, MeasuredError("bench", sun, runout_error(reducer, output + 1.0)), LOAD)
    strongest = comparison.strongest_first[0]
    assert comparison.order[strongest] == pytest.approx(1.0 / (40.0 if member == "ring" else 39.0))
    for amplitudes in (comparison.bench_amplitude, comparison.model_amplitude):
        assert abs(amplitudes[strongest]) == pytest.approx(1e-5 / 77.5e-3, rel=1e-3)
    assert comparison.causes[strongest] == "run-out of the output"
    assert comparison.explained_share > 0.999


def test_less_than_a_turn_of_the_cranks_is_refused() -> None:
    sun = np.linspace(0.0, 2.0 * np.pi, 400)
    with pytest.raises(UsageError, match="a turn of the cranks takes 1412 deg"):
        compare_bench(BORE, MeasuredError("bench", sun, 1e-5 * np.sin(sun)), LOAD)
