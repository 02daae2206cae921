"""Every measure on designs unlike the paper's: it ends, its numbers are sound, and it agrees with its closed forms.

On an internal gear, on sleeves, and where friction takes half of the power and the output cannot drive the crank.
"""

import json
import math
from collections.abc import Callable

import pytest
from designs import unlike

from cycloid_mj.cli.terminal import finite
from cycloid_mj.design import Design
from cycloid_mj.measure import Measurement
from cycloid_mj.measure.backlash import backlash
from cycloid_mj.measure.efficiency import efficiency
from cycloid_mj.measure.loads import loads
from cycloid_mj.measure.lost_motion import lost_motion
from cycloid_mj.measure.te import te
from cycloid_mj.measure.torque import torque
from cycloid_mj.measure.vibration import vibration
from cycloid_mj.plots.measure import measurement_figure

Measure = Callable[[Design], Measurement]
MEASURES: dict[str, Measure] = {
    "te": lambda design: te(design, quick=True),
    "backlash": lambda design: backlash(design, angles=1),
    "lost-motion": lambda design: lost_motion(design, angles=1),
    "torque": lambda design: torque(design, quick=True),
    "efficiency": lambda design: efficiency(design, quick=True),
    "loads": lambda design: loads(design, quick=True),
    "vibration": lambda design: vibration(design, quick=True),
}

NEAR = {
    "te": {"output_wind_up": 0.05, "output_reversal": 0.1},
    "backlash": {"backlash_cam": 0.005, "backlash_output": 0.02},
    "lost-motion": {"lost_motion": 0.01, "stiffness_ideal": 0.005, "backlash_ideal": 0.05},
    "torque": {},
    "efficiency": {},
    "loads": {"cam_peak_force": 0.3},
    "vibration": {"orbit_loaded": 0.05, "mean_force_loaded": 0.05},
}
"""Measure -> quantity -> by which share it may be off its closed form."""

RUBS = "printed"
"""Its friction takes nearly half of the power: it winds up further than statics without friction says, its cam carries
350 N where it carries 174 N without friction, and its slow gear's centre is shaken as much as it orbits."""

SHARES = {"torque": ("output_rate",), "efficiency": ("efficiency",)}
"""Measure -> quantities in percent between 0 and 100."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("measure", "name"),
    [*((measure, name) for measure in MEASURES for name in ("light", RUBS)), ("te", "large"), ("loads", "large")],
)
def test_every_measure_holds_on_every_design(measure: str, name: str) -> None:
    found = MEASURES[measure](unlike(name))
    assert found.design.name == name
    for key, one in found.quantities.items():
        assert math.isfinite(one.value) or one.note, key
        assert one.error is None or math.isnan(one.error) or one.error >= 0.0, key
    near = {} if name == RUBS and measure in ("te", "vibration", "loads") else NEAR[measure]
    for key, within in near.items():
        one = found.quantities[key]
        # what the numerical error says is left out of the turn comes on top
        assert abs(one.value - one.reference) <= within * abs(one.reference) + (one.error or 0.0), key
    for key in SHARES.get(measure, ()):
        assert 0.0 < found[key] < 100.0
    assert json.loads(json.dumps(finite(found.as_json())))["measure"] == measure
    assert len(measurement_figure(found).axes) == len({curve.panel for curve in found.curves})
