"""What a run says, held against the closed form: a `Run`'s `Findings`, their table and the series behind them.

Transmission error is the gear's (or the output's) angle less the one that the measured crank angle asks for. The
closed form of everything but the crank is evaluated at the *measured* crank angle and speed, so that the servo's lag
is judged once, in the crank's own line.
"""

from cycloid_mj.analysis.curves import FIGURES, MICROMETRE, SIGNALS, Signal, SignalFigure
from cycloid_mj.analysis.findings import Findings, condition
from cycloid_mj.analysis.judge import analyze, judge
from cycloid_mj.analysis.meaning import RETURNED, meaning
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
    "groups",
    "judge",
    "meaning",
    "series",
    "table",
]
