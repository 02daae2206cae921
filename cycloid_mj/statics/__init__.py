"""What the contacts of a reducer carry at rest under a load, with its real clearances and errors, in milliseconds.

Parts are rigid and contacts are springs that only push, each as stiff as in the simulation; gaps and balance are those
of ``reducer``. Friction, of a crank that turns so slowly that only the weight and centrifugal force of the gear
matter, comes on as a load, from the normal forces before, until both agree. A pin that moves in its play is a two-force
body: its two contacts are one, in series, and the smaller of both frictions is that of both.
"""

from cycloid_mj.statics.balance import Loads, loads, powers, transmission_error
from cycloid_mj.statics.peaks import peak_force, peak_pressure, torque_at_pressure, yield_torque
from cycloid_mj.statics.springs import Springs, body_force, springs_of

__all__ = [
    "Loads",
    "Springs",
    "body_force",
    "loads",
    "peak_force",
    "peak_pressure",
    "powers",
    "springs_of",
    "torque_at_pressure",
    "transmission_error",
    "yield_torque",
]
