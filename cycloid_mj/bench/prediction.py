"""Loops of a reducer at the torques of measured loops, without a fit: a prediction from another drive's values."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cycloid_mj.base.array import Array
from cycloid_mj.base.frame import Cell, Frame, make_frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.bench.loop import MeasuredLoop
from cycloid_mj.bench.loop_figures import LoopFigures, loop_figures
from cycloid_mj.bench.overlay import LoopCondition, interpolate_deflections, model_branches
from cycloid_mj.bench.parameters import Model
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.friction_path import Losses


@dataclass(frozen=True, eq=False, repr=False)
class Prediction(Presented):
    """Loops of a reducer at the torques of measured loops.

    Attributes
    ----------
    loops
        The measured loops.
    turns
        Predicted deflection at each point of each loop [rad], shifted to the mean of the measured one.
    shares
        Rms difference of each loop from the measured one, over its height.
    measured, modelled
        Figures of the measured and the predicted loops, by the same definitions.
    """

    loops: tuple[MeasuredLoop, ...]
    turns: tuple[Array, ...]
    shares: tuple[float, ...]
    measured: LoopFigures
    modelled: LoopFigures

    @property
    def frame(self) -> Frame:
        """Return the loop quantities of `DEFINITIONS`, such as play and stiffness, as a table of named columns.

        A row has the key of the quantity, which ends in its unit, and its value for the measured and for the predicted
        loops.
        """
        modelled_figures = self.modelled.in_units()
        rows: list[dict[str, Cell]] = [
            {"key": key, "measured": measured_figure.value, "modelled": modelled_figures[key].value}
            for key, measured_figure in self.measured.in_units().items()
        ]
        return make_frame(rows, ("key", "measured", "modelled"), {})

    @property
    def line(self) -> str:
        """Rms difference of each loop."""
        differences = (f"{loop.name} {share:.2%}" for loop, share in zip(self.loops, self.shares, strict=True))
        return f"rms difference relative to the height of the loop: {', '.join(differences)}"


def predict_loops(reducer: Reducer, loops: Sequence[MeasuredLoop], crank: float = 0.0) -> Prediction:
    """Predict the hysteresis loops of a reducer with a locked crank at the torques of measured loops, without a fit.

    Parameters
    ----------
    reducer
        The reducer. The model has its clearances, stiffness and friction of the wind-up (`springs`), but no friction in
        the contacts.
    loops
        Measured loops. The predicted deflections of each are shifted to the mean of the measured deflections; the zero
        of the measured torque is assumed to be exact.
    crank
        Angle of the crank [rad].

    Returns
    -------
    Prediction
        Predicted deflections [rad], their rms difference from each measured loop, and loop quantities of both.

    Raises
    ------
    RunError
        The model has no static equilibrium.
    """
    model = Model(reducer, Losses(), contact_friction=False)
    condition = LoopCondition("crank", crank, max(loop.most for loop in loops))
    predicted_deflections = []
    for loop in loops:
        deflection = interpolate_deflections(loop, model_branches(model, condition, loop))
        predicted_deflections.append(
            deflection + float(np.mean((loop.deflection - deflection)[loop.points_left_out :]))
        )
    shares = tuple(
        float(np.std((deflection - loop.deflection)[loop.points_left_out :])) / loop.height
        for deflection, loop in zip(predicted_deflections, loops, strict=True)
    )
    modelled_loops = [
        replace(loop, deflection=deflection) for loop, deflection in zip(loops, predicted_deflections, strict=True)
    ]
    return Prediction(
        tuple(loops), tuple(predicted_deflections), shares, loop_figures(loops), loop_figures(modelled_loops)
    )
