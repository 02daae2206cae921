"""Measures run by the planar solver unless MuJoCo is asked for; both find the same, and the condition names which."""

import numpy as np
import pytest
from designs import cases

from cycloid_mj.base.names import SOLVERS
from cycloid_mj.design import PRESETS, override
from cycloid_mj.dynamics.drive_cycle import rising
from cycloid_mj.dynamics.run import Solver, model_for, simulate
from cycloid_mj.measure import MEASURES, bench
from cycloid_mj.measure.brake_test import with_speed_slope
from cycloid_mj.reducer import Reducer

FIXED = override(PRESETS["pin"], ['ring.pins="fixed"'])

COMPARED = {
    "loads": ("capacity", 2e-3),
    "te": ("output_peak_to_peak_loaded_forward_speed", 2e-2),
    "efficiency": ("efficiency", 1e-3),
    "torque": ("output_torque", 1e-3),
    "backlash": ("backlash", 5e-3),
    "lost-motion": ("lost_motion", 1e-2),
    "vibration": ("output_rms_loaded", 5e-2),
}
"""Measure -> one of its quantities, and how far the solvers may differ in it."""


@pytest.mark.parametrize("name", cases(COMPARED, "loads"))
def test_both_solvers_measure_the_same(name: str) -> None:
    key, bound = COMPARED[name]
    ours, theirs = (MEASURES[name](FIXED, quick=True, solver=solver) for solver in SOLVERS)
    assert set(ours.quantities) == set(theirs.quantities)
    assert ours[key] == pytest.approx(theirs[key], rel=bound)
    assert ours.condition.endswith("by the planar solver")
    assert theirs.condition.endswith("by MuJoCo")
    for measurement, solver in ((ours, "planar"), (theirs, "mujoco")):
        assert {run.provenance["solver"] for run in measurement.runs.values()} == {solver}


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_motors_torque_falls_with_its_speed(solver: Solver) -> None:
    """A free crank under a torque T that falls by s w comes to T/s, at the rate s/J of its inertia."""
    alone = override(FIXED, ["drive.rotor_inertia_kg_m2=1.0", "drive.ramp_s=0", "drive.hold_s=0.02"])
    reducer = Reducer(override(alone, ["settings.log_rate_hz=5000"]))
    compiled = with_speed_slope(model_for(solver, reducer, held=""), 100.0)
    course = bench.locked_crank(compiled, 0.0, lambda time: np.zeros_like(time))
    run = simulate(reducer.design, compiled, type(course)(0.0, 0.0, rising(0.2, 1e-6), course.load))
    expected = 0.2 / 100.0 * (1.0 - np.exp(-100.0 * run.time / compiled.crank_inertia))
    np.testing.assert_allclose(run["crank_speed"][5:], expected[5:], rtol=0.02)
    np.testing.assert_allclose(run["crank_torque"][1:], 0.2 - 100.0 * run["crank_speed"][1:], atol=5e-3)
