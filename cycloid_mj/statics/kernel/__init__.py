"""The static balance of springs that only push, compiled: one small Newton iteration for each crank angle.

Every spring is a gap from ``reducer.gaps``, round by its `bend`; the cams are circles in circles. `contacts` has the
springs and how wide each gap is, `system` their energy, stiffness and what is left over of the load, `newton` Newton's
method on these. `search` tries one way to a balance after the other, of which `continuation` is the last; `samples`
balances many reducers alike, and `hysteresis` follows loads along a path with friction that remembers. Why the search
ends at a balance, or at a jam, is in docs/physics.md.
"""

from cycloid_mj.statics.kernel.contacts import Curved, KernelSprings, gap, is_open
from cycloid_mj.statics.kernel.hysteresis import FINEST, Rubbing, follow_path, state_after
from cycloid_mj.statics.kernel.newton import BALANCED, FLOATING, FOLLOWED, Residual
from cycloid_mj.statics.kernel.samples import (
    CARRIES,
    FIGURES,
    Effects,
    SampleDeviations,
    balance_few_samples,
    balance_samples,
    balance_samples_by_all,
    room_for,
)
from cycloid_mj.statics.kernel.search import PATHS, balance
from cycloid_mj.statics.kernel.system import State, state

__all__ = [
    "BALANCED",
    "CARRIES",
    "FIGURES",
    "FINEST",
    "FLOATING",
    "FOLLOWED",
    "PATHS",
    "Curved",
    "Effects",
    "KernelSprings",
    "Residual",
    "Rubbing",
    "SampleDeviations",
    "State",
    "balance",
    "balance_few_samples",
    "balance_samples",
    "balance_samples_by_all",
    "follow_path",
    "gap",
    "is_open",
    "room_for",
    "state",
    "state_after",
]
