"""Validity of statics at speed: whether load and discs can follow the transmission error."""

from collections.abc import Iterator, Mapping

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.result import Quantity
from cycloid_mj.base.units import RPM
from cycloid_mj.design import Design
from cycloid_mj.parts import turning_inertia
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.sheet_figures import INERTIA_SHARE

MAX_INERTIA_SHARE = 0.1
"""Inertia torque relative to the load up to which statics and runs agree within 0.5 percentage points of efficiency."""

EFFICIENCY_ERRORS = ((2.0, 1.0), (20.0, 1.5), (100.0, 5.0), (np.inf, 13.0))
"""Largest relative inertia torque, and difference of the efficiency between runs and statics [percentage points].

Eight drives with clearances of 2 to 250 um at 3 and 10 % of the nominal torque, three of them at 30 and 100 % too, at
1000 rpm; means of twelve crank turns, with a creep speed below the sliding speeds.
"""


def inertia_share(reducer: Reducer, rotation: Array, load: float) -> float:
    """Compute the rms inertia torque of an output that follows the transmission error, over the load torque [1].

    `rotation` (n,) is the rotation of the output from its ideal angle [rad] at n evenly spaced crank angles of a turn.
    Its second derivative is computed by FFT. The inertia is `turning_inertia`; `load` is the torque on the output
    [N m].
    """
    orders = np.fft.rfftfreq(rotation.size, 1.0 / rotation.size)
    second_derivative = np.fft.irfft(-(orders**2) * np.fft.rfft(rotation), rotation.size)
    return float(turning_inertia(reducer) * reducer.design.drive.speed**2 * np.std(second_derivative) / load)


def tracking_warnings(design: Design, quantities: Mapping[str, Quantity]) -> Iterator[str]:
    """Yield a warning if the inertia torque of the load exceeds its share `MAX_INERTIA_SHARE`; otherwise nothing.

    `quantities` are the values of the design's static data sheet, by key. The warning states by how much the static
    efficiency of drives with such a share differed from simulations (`EFFICIENCY_ERRORS`).
    """
    share = quantities[INERTIA_SHARE].value
    if share > MAX_INERTIA_SHARE:
        error = next(error for max_share, error in EFFICIENCY_ERRORS if share <= max_share)
        yield (
            f"at {abs(design.drive.speed) / RPM:.0f} rpm, the inertia torque of the load would be {share:.3g} times "
            "the load (rms) if the output followed the transmission error: contacts open and strike, which is not "
            f"part of statics; in simulations, the efficiency of such drives differed by up to {error:g} percentage "
            "points; use `cycloid-mj measure efficiency`"
        )
