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
    """Measure a quantity of a design at the default conditions of its measure, in the quantity's unit.

    It raises the errors of the measure.

    Parameters
    ----------
    reducer
        The drive.
    measure
        A name of `MEASURES`.
    quantity
        The key of one of its quantities.
    """
    return _quantities(reducer, measure)[quantity].value
