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

from cycloid_mj.base.array import Array
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.reducer.gaps import gaps
from cycloid_mj.reducer.limits import CAM_SIDES, stops
from cycloid_mj.reducer.member import against_ring

COARSE_SIDES = 180
"""Sides of the polygon around the cam's play over a whole turn, where many angles are solved: larger by 1.6e-4."""

PER_MESH_PERIOD = 6
"""Crank angles in a mesh period over a whole turn."""

FEWEST_IN_A_TURN = 180
"""Crank angles over a whole turn of a reducer with few teeth."""


def has_linear_gaps(reducer: Reducer) -> bool:
    """Tell whether `stops` knows every gap: it leaves the shape of a modified flank out."""
    return not (reducer.design.modification.pin_circle or reducer.design.modification.rotation)


def parts_alone(reducer: Reducer, crank: float) -> dict[str, float]:
    """Compute the backlash of the output [rad] at a crank angle [rad] by each kind of clearance, if it were alone."""
    design = reducer.design
    mesh_gaps = gaps(reducer, float(against_ring(design, crank)))
    arms = design.output.pin_circle_radius * mesh_gaps.slope[np.arange(mesh_gaps.disc.size), 3 * mesh_gaps.disc + 2]
    mesh, output = (_both_ways(arms[mesh_gaps.kind == kind]) for kind in (design.tooth_pair, "output"))
    per_clearance = {"cam": 2.0 / (design.gear.eccentricity * design.lobes), "output": output}
    of = reducer.share
    return {kind: of * per_clearance.get(kind, mesh) * clearance(reducer, kind) for kind in design.pair_kinds}


def clearance(reducer: Reducer, kind: str) -> float:
    """Compute the clearance of a kind of pairs [m] between parts in their ideal places."""
    design = reducer.design
    output = design.output
    wider = {
        design.tooth_pair: design.modification.equidistant,
        "output": output.hole_radius - output.pin_radius - design.gear.eccentricity,
    }
    return float(getattr(design.clearance, kind) + wider.get(kind, 0.0))


def _both_ways(arms: Array) -> float:
    """Turn per clearance [1/m], from stop to stop."""
    return float(1.0 / arms.max() - 1.0 / arms.min())


def total(reducer: Reducer, cranks: Array, sides: int = CAM_SIDES) -> Array:
    """Compute the backlash of the output [rad] at crank angles [rad] (n,) with all clearances together."""
    ends = np.array([stops(reducer, float(crank), sides) for crank in cranks])
    return np.asarray(ends[:, 1] - ends[:, 0])


@once
def over_a_turn(reducer: Reducer) -> tuple[Array, Array]:
    """Compute crank angles [rad] all over a turn, shape (n,), and the backlash [rad] at each as `total` does."""
    cranks = turn(reducer)
    return cranks, total(reducer, cranks, COARSE_SIDES)


def turn(reducer: Reducer) -> Array:
    """Compute crank angles [rad] that resolve the mesh all over a turn, both of its ends among them."""
    return np.linspace(0.0, 2.0 * np.pi, max(PER_MESH_PERIOD * reducer.design.ring.teeth, FEWEST_IN_A_TURN) + 1)
