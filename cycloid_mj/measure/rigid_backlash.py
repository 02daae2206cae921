"""How far the output of a rigid reducer turns at a locked crank: the closed forms of backlash.

Rigid contacts only push and parts move by micrometres, so the stops of the output are the ends of a linear programme
(``reducer.limits``). Its dual is statics: half the backlash is the least sum of F_i delta_i over all loads F_i >= 0
that balance a unit torque on the output. With one clearance alone this has a closed form (`parts_alone`):

- teeth, and pins in their sockets or sleeves, which are in series with them: the force per torque is least on the
  largest arm l of either sign, at most c (N-1): delta/max l + delta/max(-l), about 2 delta/(c (N-1)).
- output pins: all push along the eccentric, with the arms R sin beta: delta/max(R sin beta) + delta/max(-R sin beta).
- cam: all tooth normals meet in the pitch point, c (N-1) from the gear's centre, and the output pins push along the
  line through both: the cam's force across the eccentric alone bears the torque. 2 delta/(c (N-1)), as the gear turns
  about the pitch point.
"""

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.reducer.gaps import Gaps, arc_gaps, flank_gaps
from cycloid_mj.reducer.limits import CAM_SIDES, stops_at

COARSE_SIDES = 180
"""Sides of the polygon around the cam's play over a whole turn, where many angles are solved: larger by 1.6e-4."""

PER_MESH_PERIOD = 6
"""Crank angles in a mesh period over a whole turn."""

FEWEST_IN_A_TURN = 180
"""Crank angles over a whole turn of a reducer with few teeth."""


def has_linear_gaps(reducer: Reducer) -> bool:
    """Tell whether `stops_at` knows every gap: it leaves the shape of a modified flank out."""
    return not (reducer.design.modification.pin_circle or reducer.design.modification.rotation)


def parts_alone(reducer: Reducer, cranks: npt.ArrayLike) -> dict[str, Array]:
    """Compute the backlash of the output [rad] by each kind of clearance, if it were alone, at crank angles (k,) [rad].

    Returns
    -------
    Kind of pair -> shape (k,); (1,) at one angle.
    """
    design = reducer.design
    seen = np.atleast_1d(reducer.member.against_ring(np.asarray(cranks, float)))
    mesh_gaps = arc_gaps(reducer, seen)
    most, least = _arms(reducer, mesh_gaps, design.tooth_pair)
    if design.ring.kind == "nonpin":
        flanks = [
            [
                _arms(reducer, flank_gaps(reducer, float(at), disc), design.tooth_pair)
                for disc in range(design.gear.discs)
            ]
            for at in seen
        ]
        ends = np.array(flanks)
        most, least = np.maximum(most, ends[..., 0].max(axis=1)), np.minimum(least, ends[..., 1].min(axis=1))
    mesh, output = (1.0 / high - 1.0 / low for high, low in ((most, least), _arms(reducer, mesh_gaps, "output")))
    cam = np.full(len(seen), 2.0 / (design.gear.eccentricity * design.lobes))
    per_clearance = {"cam": cam, "output": output}
    of = reducer.share
    return {kind: of * per_clearance.get(kind, mesh) * clearance(reducer, kind) for kind in design.pair_kinds}


def _arms(reducer: Reducer, of: Gaps, kind: str) -> tuple[Array, Array]:
    """Compute the largest arm of a kind's normals about a disc's centre, and the least [m], shape (k,) each."""
    arms = reducer.design.output.pin_circle_radius * of.slope[..., np.arange(of.disc.size), 3 * of.disc + 2]
    own = arms[..., of.kind == kind]
    return own.max(axis=-1), own.min(axis=-1)


def clearance(reducer: Reducer, kind: str) -> float:
    """Compute the clearance of a kind of pairs [m] between parts in their ideal places."""
    design = reducer.design
    output = design.output
    wider = {
        design.tooth_pair: design.modification.equidistant,
        "output": output.hole_radius - output.pin_radius - design.gear.eccentricity,
    }
    return float(getattr(design.clearance, kind) + wider.get(kind, 0.0))


def total(reducer: Reducer, cranks: Array, sides: int = CAM_SIDES) -> Array:
    """Compute the backlash of the output [rad] at crank angles [rad] (n,) with all clearances together."""
    ends = stops_at(reducer, cranks, sides)
    return np.asarray(ends[:, 1] - ends[:, 0])


@once
def over_a_turn(reducer: Reducer) -> tuple[Array, Array]:
    """Compute crank angles [rad] all over a turn, shape (n,), and the backlash [rad] at each as `total` does."""
    cranks = turn(reducer)
    return cranks, total(reducer, cranks, COARSE_SIDES)


def turn(reducer: Reducer) -> Array:
    """Compute crank angles [rad] that resolve the mesh all over a turn, both of its ends among them."""
    return np.linspace(0.0, 2.0 * np.pi, max(PER_MESH_PERIOD * reducer.design.ring.teeth, FEWEST_IN_A_TURN) + 1)
