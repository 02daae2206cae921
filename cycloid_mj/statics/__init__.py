"""What the contacts of a reducer carry at rest under a load, with its real clearances and errors, in milliseconds.

Parts are rigid and contacts are springs that only push, each as stiff as in the simulation; gaps and balance are those
of ``reducer``. Friction, of a crank that turns so slowly that only the weight and centrifugal force of the gear
matter, comes on as a load, from the normal forces before, until both agree. A pin that moves in its play is a two-force
body: its two contacts are one, in series, and the smaller of both frictions is that of both.
"""

import sys
from typing import TYPE_CHECKING

from cycloid_mj.base.notebook_display import CallableRoom
from cycloid_mj.design import Named, resolve
from cycloid_mj.reducer import Reducer
from cycloid_mj.statics.balance import Loads, loads, powers, transmission_error
from cycloid_mj.statics.peaks import peak_force, peak_pressure, torque_at_pressure
from cycloid_mj.statics.springs import Springs, body_force, springs_of

if TYPE_CHECKING:
    from cycloid_mj.statics.sheet import Sheet

__all__ = [
    "Loads",
    "Springs",
    "body_force",
    "loads",
    "main",
    "peak_force",
    "peak_pressure",
    "powers",
    "springs_of",
    "torque_at_pressure",
    "transmission_error",
]


def main(design: Named, load_nm: float | None = None) -> "Sheet":
    """Compute what a data sheet has of a reducer; from Python as ``cm.statics(design)``.

    Parameters
    ----------
    design
        A sound design, or the name of a preset or a file.
    load_nm
        Torque on the output [N m]; by default the size of the design's load, or its rated torque where that is 0.

    Raises
    ------
    UsageError
        There is no such design, or the torque is not positive.
    DesignError
        The design cannot be read, or the crank does not turn.
    RunError
        No static balance was found, as where friction jams the reducer.
    """
    from cycloid_mj.statics.sheet import sheet

    return sheet(Reducer(resolve(design)), load_nm)


sys.modules[__name__].__class__ = CallableRoom
