"""Results of runs compared with the closed form: the `Findings` of a `Run`, their table, and the series behind them.

The transmission error is the angle of disc or output minus its ideal value at the measured crank angle. The closed form
of all quantities but the crank's is evaluated at the *measured* crank angle and speed, so that the lag of the servo
counts only once, as an error of the crank.
"""

from cycloid_mj.analysis.curves import FIGURES, MICROMETRE, SIGNALS, Signal, SignalFigure
from cycloid_mj.analysis.explanations import RETURNED, explain
from cycloid_mj.analysis.findings import Findings, condition
from cycloid_mj.analysis.judge import analyze, judge
from cycloid_mj.analysis.series import Compared, PinPath, Series, series
from cycloid_mj.analysis.table import GROUPS, FigureRow, RowGroup, groups, table

__all__ = [
    "FIGURES",
    "GROUPS",
    "MICROMETRE",
    "RETURNED",
    "SIGNALS",
    "Compared",
    "FigureRow",
    "Findings",
    "PinPath",
    "RowGroup",
    "Series",
    "Signal",
    "SignalFigure",
    "analyze",
    "condition",
    "explain",
    "groups",
    "judge",
    "series",
    "table",
]
