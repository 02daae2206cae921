"""The reducer as one value: its rigid parts, the surfaces on which they meet, and every gap with its sign.

The package has the ``Reducer`` that all upper packages use (`reducer`), its bodies and mating surfaces (`bodies`),
their gaps (`gaps`), working force and stiffness of each kind of contact (`contact`), and what follows without
inertia: whether the parts fit together, and how far the output turns at a locked crank (`limits`).
"""

from cycloid_mj.reducer.reducer import Reducer, once
from cycloid_mj.reducer.rv import RvReducer, reducer_of

__all__ = ["Reducer", "RvReducer", "once", "reducer_of"]
