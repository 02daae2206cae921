"""Backlash of a rigid reducer at a locked crank, by closed forms.

Rigid contacts only push and parts move by micrometres, so the stops of the output are the ends of a linear programme
(``reducer.limits``). Its dual is statics: half the backlash is the least sum of F_i delta_i over all loads F_i >= 0
that balance a unit torque on the output. With one clearance alone this has a closed form (`single_clearance_backlash`):

- teeth, and pins in their sockets or sleeves, which are in series with them: the force per torque is least on the
  largest arm l of either sign, at most c (N-1): delta/max l + delta/max(-l), about 2 delta/(c (N-1)).
- output pins: all push along the eccentric, with the arms R sin beta: delta/max(R sin beta) + delta/max(-R sin beta).
- cam: all tooth normals meet in the pitch point, c (N-1) from the gear's centre, and the output pins push along the
  line through both: only the cam's force across the eccentric carries the torque. 2 delta/(c (N-1)), as the disc turns
  about the pitch point.
"""

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.reducer import Reducer, once
from cycloid_mj.reducer.gaps import Gaps, arc_gaps, flank_gaps
from cycloid_mj.reducer.limits import FIT, stops_at

COARSE_SIDES = 180
"""Sides of the polygon around the cam's clearance over a full turn, where many angles are solved: 1.6e-4 too large."""


def has_linear_gaps(reducer: Reducer) -> bool:
    """Return whether `stops_at` includes all gaps; it neglects the shape of modified flanks."""
    return not (reducer.design.modification.pin_circle or reducer.design.modification.rotation)


def single_clearance_backlash(reducer: Reducer, crank_angles: npt.ArrayLike) -> dict[str, Array]:
    """Compute the backlash of the output [rad] due to each clearance alone in closed form, at k crank angles [rad].

    It is delta (1/a_max - 1/a_min), with the clearance delta and the extreme lever arms a of the contacts of a kind.

    Returns
    -------
    dict
        Kind of pair -> backlash [rad], shape (k,); (1,) for a single angle.
    """
    design = reducer.design
    relative_angles = np.atleast_1d(reducer.member.against_ring(np.asarray(crank_angles, float)))
    mesh_gaps = arc_gaps(reducer, relative_angles)
    max_arm, min_arm = _extreme_arms(reducer, mesh_gaps, design.tooth_pair)
    if design.ring.kind == "nonpin":
        flank_arm_pairs = [
            [
                _extreme_arms(reducer, flank_gaps(reducer, float(angle), disc), design.tooth_pair)
                for disc in range(design.gear.discs)
            ]
            for angle in relative_angles
        ]
        flank_arms = np.array(flank_arm_pairs)
        max_arm, min_arm = (
            np.maximum(max_arm, flank_arms[..., 0].max(axis=1)),
            np.minimum(min_arm, flank_arms[..., 1].min(axis=1)),
        )
    mesh_factor, pin_factor = (
        1.0 / max_lever - 1.0 / min_lever
        for max_lever, min_lever in ((max_arm, min_arm), _extreme_arms(reducer, mesh_gaps, "output"))
    )
    cam_factor = np.full(len(relative_angles), 2.0 / (design.gear.eccentricity * design.lobes))
    backlash_per_clearance = {"cam": cam_factor, "output": pin_factor}
    return {
        kind: reducer.share * backlash_per_clearance.get(kind, mesh_factor) * effective_clearance(reducer, kind)
        for kind in design.pair_kinds
    }


def _extreme_arms(reducer: Reducer, gaps: Gaps, kind: str) -> tuple[Array, Array]:
    """Return the largest and the smallest lever arm of a kind's normals about a disc's centre [m], shape (k,)."""
    arms = reducer.design.output.pin_circle_radius * gaps.slope[..., np.arange(gaps.disc.size), 3 * gaps.disc + 2]
    arms_of_kind = arms[..., gaps.kind == kind]
    return arms_of_kind.max(axis=-1), arms_of_kind.min(axis=-1)


def effective_clearance(reducer: Reducer, kind: str) -> float:
    """Compute the radial clearance of a kind of contact pair [m], with all parts at their ideal positions.

    `kind` is one of `Design.pair_kinds`, such as "pin_gear", "cam" or "output". The result is the nominal clearance
    plus the offset of modified flanks or, for output pins, the excess of the hole radius over pin radius plus
    eccentricity.
    """
    design = reducer.design
    output = design.output
    enlargement = {
        design.tooth_pair: design.modification.equidistant,
        "output": output.hole_radius - output.pin_radius - design.gear.eccentricity,
    }
    return float(getattr(design.clearance, kind) + enlargement.get(kind, 0.0))


def total_backlash(reducer: Reducer, crank_angles: Array, sides: int = FIT.cam_sides) -> Array:
    """Compute the backlash of the output [rad] at crank angles [rad], shape (n,), with all clearances together.

    It is the range of a linear programme; `sides` is the number of sides of the polygon around the cam's clearance.
    """
    stops = stops_at(reducer, crank_angles, sides)
    return np.asarray(stops[:, 1] - stops[:, 0])


@once
def backlash_over_turn(reducer: Reducer) -> tuple[Array, Array]:
    """Return the crank angles of `full_turn_angles` [rad] and the backlash at each [rad], both of shape (n,)."""
    crank_angles = full_turn_angles(reducer)
    return crank_angles, total_backlash(reducer, crank_angles, COARSE_SIDES)


def full_turn_angles(reducer: Reducer) -> Array:
    """Compute crank angles [rad] that resolve the mesh over a full turn, including both ends."""
    # at least 180 in all, which matters for few teeth
    return np.linspace(0.0, 2.0 * np.pi, max(6 * reducer.design.ring.teeth, 180) + 1)
