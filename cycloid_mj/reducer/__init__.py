"""The reducer as one value: its rigid parts, the surfaces on which they meet, and every gap with its sign.

Owns the ``Reducer`` that all rooms above hand on (`reducer`), its bodies and mating surfaces (`bodies`), their gaps
(`gaps`), what presses each kind of contact and how stiff it is (`contact`), and what follows from these without
inertia: whether the parts go together and how far the output turns at a locked crank (`limits`).
"""

from cycloid_mj.reducer.reducer import Reducer, once
from cycloid_mj.reducer.rv import RvReducer, reducer_of

__all__ = ["Reducer", "RvReducer", "once", "reducer_of"]
