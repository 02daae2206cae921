"""What the contacts of a reducer carry at rest under a load, with its real clearances and errors, in milliseconds.

Parts are rigid and contacts are springs that only push, each as stiff as in the simulation. Gaps are linear in the
small motion of gear and output (`assembly`), but for the cam in its bore, a circle in a circle. Without friction the
pose has the least elastic energy less the work of the load, which is convex: Newton's method finds it, at all crank
angles at once. Friction, of a crank that turns so slowly that only the weight and centrifugal force of the gear matter,
comes on as a load, from the normal forces before, until both agree. A pin that moves in its play is a two-force body:
its two contacts are one, in series, and the smaller of both frictions is that of both.
"""

from cycloid_mj.loaded.balance import Loads, loads
from cycloid_mj.loaded.play import backlash
from cycloid_mj.loaded.pressure import kinds, peak_force, peak_pressure, torque_at_pressure, yield_torque
from cycloid_mj.loaded.springs import Springs, springs_of

__all__ = [
    "Loads",
    "Springs",
    "backlash",
    "kinds",
    "loads",
    "peak_force",
    "peak_pressure",
    "springs_of",
    "torque_at_pressure",
    "yield_torque",
]
