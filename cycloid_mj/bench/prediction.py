"""A reducer's own loop beside measured ones, nothing fitted: what one drive's values say of another drive."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.overlay import LoopCondition, deflections, model_branches
from cycloid_mj.bench.parameters import Model
from cycloid_mj.bench.reading import LoopReading, read_figures
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.sliding import Losses


@dataclass(frozen=True, eq=False)
class Prediction:
    """Loops of a reducer at the torques of measured ones.

    Attributes
    ----------
    turns
        Deflection at each point of each loop [rad], in the middle of the measured ones.
    shares
        Rms difference of each from the measured one, over its height.
    measured, modelled
        The figures of both, by the same definitions.
    """

    turns: tuple[Array, ...]
    shares: tuple[float, ...]
    measured: LoopReading
    modelled: LoopReading


def predict_loops(reducer: Reducer, loops: Sequence[MeasuredLoop], crank: float = 0.0) -> Prediction:
    """Compute the loops of a reducer at a locked crank [rad] at the torques of measured loops.

    Parameters
    ----------
    reducer
        Whose clearances, stiffness and friction of the wind-up (`springs`) count; its contacts do not rub.
    loops
        Measured: each has a zero of deflection of its own, which is laid on the mean of the model's, none of torque.
    crank
        Angle of the crank [rad].

    Raises
    ------
    RunError
        No static balance was found.
    """
    model = Model(reducer, Losses(), rubs=False)
    condition = LoopCondition("crank", crank, max(loop.most for loop in loops))
    turns = []
    for loop in loops:
        turn = deflections(loop, model_branches(model, condition, loop))
        turns.append(turn + float(np.mean((loop.deflection - turn)[loop.lead :])))
    shares = tuple(
        float(np.std((turn - loop.deflection)[loop.lead :])) / loop.height
        for turn, loop in zip(turns, loops, strict=True)
    )
    modelled = [replace(loop, deflection=turn) for loop, turn in zip(loops, turns, strict=True)]
    return Prediction(tuple(turns), shares, read_figures(loops), read_figures(modelled))
