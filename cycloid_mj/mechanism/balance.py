"""The pose in which springs balance a load, at every crank angle of a turn: teeth, output pins and cams that only push.

Free of friction and of inertia but what the load states. What holds for errors of some micrometres is an estimate
beyond: see ``gaps``. The flanks of an internal gear close only beside an arc, as one patch with it, and are left out
(below 0.1 % of the gear's turn).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cycloid_mj.compiling import announced
from cycloid_mj.design import Design
from cycloid_mj.errors import RunError
from cycloid_mj.mechanism.gaps import Gaps, arc_gaps, cam_places
from cycloid_mj.mechanism.kernel import BALANCED, Springs, balance
from cycloid_mj.types import Array


@dataclass(frozen=True)
class Stiffness:
    """Stiffness of the springs.

    Attributes
    ----------
    contacts
        Gives that of each contact [N/m], shape (k, n), from the gaps; of a pin that moves, in series with what carries
        it.
    cam
        Of each disc's cam [N/m].
    """

    contacts: Callable[[Gaps], Array]
    cam: float


@dataclass(frozen=True)
class Balance:
    """Balances at k crank angles.

    Attributes
    ----------
    departures
        The unknowns of ``gaps`` [m], shape (k, 3 D + 1).
    forces
        Of the contacts [N], shape (k, n), in the order of `contacts`.
    contacts
        Their gaps at z = 0.
    """

    departures: Array
    forces: Array
    contacts: Gaps

    def disc_turn(self, design: Design, disc: int = 0) -> Array:
        """Turn of a disc from the ideal one [rad], shape (k,)."""
        return self.departures[:, 3 * disc + 2] / design.output.pin_circle_radius

    def output_turn(self, design: Design) -> Array:
        """Turn of the output from the ideal one [rad], shape (k,)."""
        return self.departures[:, -1] / design.output.pin_circle_radius


def solve(design: Design, crank: npt.ArrayLike, stiffness: Stiffness, load: Array) -> Balance:
    """Balance a load at crank angles that follow each other.

    Parameters
    ----------
    design
        The design; its errors and its modification are in the gaps.
    crank
        Crank angles [rad], shape (k,).
    stiffness
        Of the springs.
    load
        Generalised force on each unknown [N], shape (k, 3 D + 1): a torque on the output over the radius of its pins.

    Raises
    ------
    RunError
        No balance was found.
    """
    angles = np.ravel(np.asarray(crank, dtype=np.float64))
    contacts, cams = arc_gaps(design, angles), cam_places(design, angles)
    play = np.where(contacts.kind == design.tooth_pair, design.pin_play, 0.0)
    springs = Springs(
        room=contacts.room + play,  # a pin that moves gives way by its play first
        distance=contacts.distance,
        slope=contacts.slope,
        shift=contacts.shift,
        shift_slope=contacts.shift_slope,
        bend=contacts.bend,
        stiffness=stiffness.contacts(contacts),
        cam_place=cams,
    )
    departures, forces = np.zeros_like(load), np.zeros_like(springs.distance)
    for disc, place in enumerate(cams[0]):
        departures[0, 3 * disc : 3 * disc + 2] = place
    with announced():
        left = balance(springs, design.clearance.cam, stiffness.cam, load, departures, forces, True)
    if not left <= BALANCED:
        raise RunError(f"no static balance of the mesh: {left:.3g} of the load is left over")
    return Balance(departures, forces, contacts)
