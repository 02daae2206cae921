"""Lost motion and stiffness by statics: an independent balance of contact springs, without friction, weight or time.

The compliance of the whole is that of three parts in series, told apart by how the parts move, in simulation and
statics alike: the output against the gear (output pins); the gear's turn about the pitch point that goes with its
centre's way s along the eccentric's circle, -s/(c (N-1)) (cam); and the rest of the gear's turn (teeth, pins, sockets).
"""

from dataclasses import dataclass

import numpy as np

from cycloid_mj.contact.law import pair_stiffness
from cycloid_mj.design import Design, Errors, Modification
from cycloid_mj.errors import RunError
from cycloid_mj.measure.hysteresis import LOST_MOTION_SHARE, STRAIGHT, Loop
from cycloid_mj.types import Array
from cycloid_mj.validation import equilibrium
from cycloid_mj.validation.equilibrium import Equilibrium

SERIES = ("output", "cam", "mesh")
SHARES = (*sorted(STRAIGHT, reverse=True), LOST_MOTION_SHARE)
BETWEEN = 4
"""Times that the way to a share is halved at most, where no balance is found from the last one."""


@dataclass(frozen=True, eq=False)
class Balance:
    """Static solutions at one crank angle, at the shares (+-1, +-0.5, +-0.03) of the rated torque.

    Attributes
    ----------
    rated
        [N m].
    turn, gear_turn, centre_lead
        Share -> turn of output and gear, from the ideal pose [rad], and way of the gear's centre along the eccentric's
        circle [m].
    """

    rated: float
    turn: dict[float, float]
    gear_turn: dict[float, float]
    centre_lead: dict[float, float]

    @property
    def lost_motion(self) -> float:
        """Turn between +3 % and -3 % of the rated torque [rad]."""
        return self.turn[LOST_MOTION_SHARE] - self.turn[-LOST_MOTION_SHARE]

    def compliance(self, values: dict[float, float]) -> float:
        """Slope of the turn, or of other values, over the straight part [rad/(N m)]; mean of both sides."""
        low, high = STRAIGHT
        rise = [side * (values[side * high] - values[side * low]) for side in (-1, 1)]
        return float(np.mean(rise)) / ((high - low) * self.rated)

    def series(self, design: Design) -> dict[str, float]:
        """Give the compliance of each part in series [rad/(N m)], keyed by `SERIES`."""
        return in_series(design, *(self.compliance(at) for at in (self.turn, self.gear_turn, self.centre_lead)))


def loop_series(design: Design, loop: Loop) -> dict[str, float]:
    """Give the compliance of each part in series [rad/(N m)] by a loop, keyed by `SERIES`."""
    return in_series(design, loop.compliance(), loop.compliance(loop.gear_turn), loop.compliance(loop.centre_lead))


def in_series(design: Design, turn: float, gear_turn: float, centre_lead: float) -> dict[str, float]:
    """Tell the parts of a compliance [rad/(N m)] from those of turn, gear and gear's centre [m/(N m)]."""
    cam = -centre_lead / (design.gear.eccentricity * design.lobes)
    return {"output": turn - gear_turn, "cam": cam, "mesh": gear_turn - cam}


def is_known(design: Design) -> bool:
    """Tell whether `balance` knows a design: it is without errors and without modification of the flanks' shape."""
    shape = design.modification.model_copy(update={"equidistant": 0.0})
    return design.errors.model_copy(update={"seed": 0}) == Errors() and shape == Modification()


def balance(design: Design, crank: float, rated: float) -> Balance:
    """Solve for the static poses at a crank angle [rad] under shares of a rated torque [N m] on the output.

    Raises
    ------
    RunError
        No balance was found.
    """
    stiffness = {kind: pair_stiffness(design, kind) for kind in design.pair_kinds}
    turn, gear_turn, centre_lead = {}, {}, {}
    for side in (-1, 1):
        near: Equilibrium | None = None
        last = 2.0 * side * rated
        for share in SHARES:
            near = _solved(design, stiffness, crank, side * share * rated, near, last)
            last = side * share * rated
            turn[side * share], gear_turn[side * share] = near.output_turn, near.gear_turn
            centre_lead[side * share] = _lead(design, stiffness["cam"], near.cam_force, crank)
    return Balance(rated, turn, gear_turn, centre_lead)


def _solved(
    design: Design,
    stiffness: dict[str, float],
    crank: float,
    torque: float,
    near: Equilibrium | None,
    last: float,
    between: int = BETWEEN,
) -> Equilibrium:
    """Solve under a torque [N m]: from the balance `near` under the torque `last`, from none, or on the way there."""
    loaded = design.model_copy(update={"load": design.load.model_copy(update={"torque": torque})})
    for start in (near, None) if near is not None else (None,):
        try:
            return equilibrium.solve(loaded, stiffness, crank, start)
        except RunError:
            if start is None and not between:
                raise
    halfway = 0.5 * (last + torque)
    near = _solved(design, stiffness, crank, halfway, near, last, between - 1)
    return _solved(design, stiffness, crank, torque, near, halfway, between - 1)


def _lead(design: Design, stiffness: float, cam_force: Array, crank: float) -> float:
    """Way of the gear's centre [m]: against the cam's force, by its clearance and what it gives."""
    force = float(np.linalg.norm(cam_force))
    shift = -cam_force / force * (design.clearance.cam + force / stiffness)
    return float(-shift[0] * np.cos(crank) - shift[1] * np.sin(crank))
