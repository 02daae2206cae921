"""A reducer's own loop beside measured ones, nothing fitted: what one drive's values say of another drive."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.frame import Cell, Frame, framed
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.loop_figures import LoopReading, read_figures
from cycloid_mj.bench.overlay import LoopCondition, deflections, model_branches
from cycloid_mj.bench.parameters import Model
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.friction_path import Losses


@dataclass(frozen=True, eq=False, repr=False)
class Prediction(Presented):
    """Loops of a reducer at the torques of measured ones.

    Attributes
    ----------
    loops
        The measured ones.
    turns
        Deflection at each point of each loop [rad], in the middle of the measured ones.
    shares
        Rms difference of each from the measured one, over its height.
    measured, modelled
        The figures of both, by the same definitions.
    """

    loops: tuple[MeasuredLoop, ...]
    turns: tuple[Array, ...]
    shares: tuple[float, ...]
    measured: LoopReading
    modelled: LoopReading

    @property
    def frame(self) -> Frame:
        """The figures of both, a row each."""
        modelled = self.modelled.in_units()
        rows: list[dict[str, Cell]] = [
            {"key": key, "measured": one.value, "modelled": modelled[key].value}
            for key, one in self.measured.in_units().items()
        ]
        return framed(rows, ("key", "measured", "modelled"), {})

    @property
    def line(self) -> str:
        """How far each loop is off."""
        off = (f"{loop.name} {share:.2%}" for loop, share in zip(self.loops, self.shares, strict=True))
        return f"rms difference over the height of the loop: {', '.join(off)}"


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
    return Prediction(tuple(loops), tuple(turns), shares, read_figures(loops), read_figures(modelled))
