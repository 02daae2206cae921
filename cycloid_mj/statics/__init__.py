"""Static equilibrium of the contacts of a reducer under a load, with its clearances and errors, in milliseconds.

Parts are rigid and contacts are unilateral springs with the stiffness of the simulation; the gaps are those of
``reducer``. Friction is that of a crank that rotates so slowly that weight and centrifugal force of the disc are the
only other body forces. A pin that moves in its seat is a two-force body: its two contacts act in series, with the
smaller of both friction coefficients.
"""

import sys
from typing import TYPE_CHECKING

from cycloid_mj.base.notebook_display import CallableRoom
from cycloid_mj.design import Named, resolve
from cycloid_mj.reducer import reducer_of
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
    """Compute the data-sheet quantities of a reducer by statics; in Python ``cm.statics(design)``.

    Parameters
    ----------
    design
        A design that passes its checks, or the name of a preset or a file.
    load_nm
        Torque on the output [N m]; by default the magnitude of the design's load, or its nominal torque if that is 0.

    Returns
    -------
    Sheet
        Backlash, stiffness, transmission error, loads and losses. `quantities` has them by key; a notebook shows them
        as a table, and `plot` draws them.

    Raises
    ------
    UsageError
        The design does not exist, or the torque is not positive.
    DesignError
        The design is invalid, or the crank does not rotate.
    RunError
        There is no static equilibrium, for example because friction jams the reducer.
    """
    from cycloid_mj.statics.sheet import sheet

    return sheet(reducer_of(resolve(design)), load_nm)


sys.modules[__name__].__class__ = CallableRoom
