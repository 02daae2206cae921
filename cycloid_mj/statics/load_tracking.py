"""Whether load and discs can follow the transmission error at the speed of the crank, as statics has it do."""

from collections.abc import Iterator, Mapping

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.result import Quantity
from cycloid_mj.base.units import RPM
from cycloid_mj.design import Design
from cycloid_mj.parts import turning_inertia
from cycloid_mj.reducer import Reducer

INERTIA_SHARE = "inertia_torque_share"

FOLLOWS = 0.1
"""Share of the load up to which statics and runs agree within 0.5 points of efficiency."""

MISSED = ((2.0, 1.0), (20.0, 1.5), (100.0, 5.0), (np.inf, 13.0))
"""By how many points the efficiency of runs differed from statics up to such a share.

Eight drives with clearances of 2 to 250 um at 3 and 10 % of the rated torque, three of them at 30 and 100 % too, at
1000 rpm; means of twelve crank turns, with a creep speed below what slides.
"""


def inertia_share(reducer: Reducer, turn: Array, load: float) -> float:
    """Compute the rms torque by which the inertia would follow a transmission error, as a share of the load [1].

    `turn` is the output's turn from its ideal angle [rad] at even steps of one crank turn, shape (n,); `load` is the
    torque on it [N m].
    """
    order = np.fft.rfftfreq(turn.size, 1.0 / turn.size)
    bent = np.fft.irfft(-(order**2) * np.fft.rfft(turn), turn.size)
    return float(turning_inertia(reducer) * reducer.design.drive.speed**2 * np.std(bent) / load)


def unfollowed(design: Design, quantities: Mapping[str, Quantity]) -> Iterator[str]:
    """Say where the load does not follow, and how far runs were from statics then."""
    share = quantities[INERTIA_SHARE].value
    if share > FOLLOWS:
        missed = next(points for most, points in MISSED if share <= most)
        yield (
            f"at {abs(design.drive.speed) / RPM:.0f} rpm the load's inertia alone asks for {share:.3g} times the load "
            "(rms) to follow the transmission error, and the discs' for more: contacts open and strike where statics "
            f"keeps them closed, and the efficiency by runs of such drives was up to {missed:g} points off; take "
            "`cycloid-mj measure efficiency`"
        )
