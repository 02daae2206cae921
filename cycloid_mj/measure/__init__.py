"""Measures of a reducer by simulation, with closed forms where they exist.

Each measure is one function from a design to a `Measurement`, and one row of `MEASURES`.
"""

from collections.abc import Callable, Mapping

from cycloid_mj.base.result import Quantity
from cycloid_mj.measure.backlash import backlash
from cycloid_mj.measure.efficiency import efficiency
from cycloid_mj.measure.loads import loads
from cycloid_mj.measure.lost_motion import lost_motion
from cycloid_mj.measure.measurement import Measurement
from cycloid_mj.measure.te import te
from cycloid_mj.measure.torque import torque
from cycloid_mj.measure.vibration import vibration
from cycloid_mj.reducer import Reducer, once

MEASURES: Mapping[str, Callable[..., Measurement]] = {
    **{"te": te, "backlash": backlash, "lost-motion": lost_motion, "loads": loads},
    **{"torque": torque, "efficiency": efficiency, "vibration": vibration},
}
"""Name on the command line -> measure. Each takes a design, its own options, `quick`, and `progress`."""

__all__ = ["MEASURES", "Measurement", "backlash", "efficiency", "loads", "lost_motion", "measure_quantity"]
__all__ += ["te", "torque", "vibration"]


def __dir__() -> list[str]:
    """List the public names alone, for completion."""
    return sorted(__all__)


@once
def _quantities(reducer: Reducer, measure: str) -> Mapping[str, Quantity]:
    return MEASURES[measure](reducer.design).quantities


def measure_quantity(reducer: Reducer, measure: str, quantity: str) -> float:
    """Run a simulated measurement of a design under its default conditions, and return one of its quantities.

    The result is in the unit of the quantity. The errors of the measurement are raised.

    Parameters
    ----------
    reducer
        The drive.
    measure
        Name of the measurement, a key of `MEASURES`.
    quantity
        Key of one of the quantities of this measurement.
    """
    return _quantities(reducer, measure)[quantity].value
