"""How far the output of a rigid reducer turns at a locked crank: the closed forms of backlash.

Rigid contacts only push and parts move by micrometres, so each gap is linear in the small motion of the gear (d, phi)
and of the output (psi), and the stops of the output are the ends of a linear programme. Its dual is statics: half the
backlash is the least sum of F_i delta_i over all loads F_i >= 0 that balance a unit torque on the output. With one
clearance alone this has a closed form (`parts_alone`):

- teeth, and pins in their sockets or sleeves, which are in series with them: the force per torque is least on the
  largest arm l of either sign, at most c (N-1): delta/max l + delta/max(-l), about 2 delta/(c (N-1)).
- output pins: all push along the eccentric, with the arms R sin beta: delta/max(R sin beta) + delta/max(-R sin beta).
- cam: all tooth normals meet in the pitch point, c (N-1) from the gear's centre, and the output pins push along the
  line through both: the cam's force across the eccentric alone bears the torque. 2 delta/(c (N-1)), as the gear turns
  about the pitch point.
"""

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from cycloid_mj import envelope, kinematics, profile
from cycloid_mj.design import Design
from cycloid_mj.deviations import deviations
from cycloid_mj.errors import RunError
from cycloid_mj.profile import unit
from cycloid_mj.solid.gear import tooth_profile

Array = npt.NDArray[np.float64]

CAM_DIRECTIONS = 720
"""Sides of the polygon that stands for the cam's play: it is larger than the circle by 1e-5 at most."""

COARSE_DIRECTIONS = 180
"""The same over a whole turn, where many angles are solved: larger by 1.6e-4 at most."""

PER_MESH_PERIOD = 6
"""Crank angles in a mesh period over a whole turn."""


def clearance_kinds(design: Design) -> tuple[str, ...]:
    """Give the kinds of pairs that a design has, from the ring to the output: the keys of their clearances."""
    moving = "pin_socket" if design.ring.has_sockets else "pin_sleeve" if design.ring.has_sleeves else ""
    return tuple(kind for kind in (design.tooth_pair, moving, "cam", "output") if kind)


def has_linear_gaps(design: Design) -> bool:
    """Tell whether `stops` knows every gap: it leaves the shape of a modified flank out."""
    return not (design.modification.pin_circle or design.modification.rotation)


def parts_alone(design: Design, crank: float) -> dict[str, float]:
    """Give the backlash of the output [rad] at a crank angle [rad] by each kind of clearance, if it were alone."""
    gear = tooth_profile(design)
    arms = profile.moment_arm(gear, np.concatenate([contacts.B for contacts in _ring_contacts(design, crank)]))
    largest = gear.eccentricity * gear.lobes
    mesh, output = _both_ways(arms), _both_ways(_output_arms(design, crank))
    per_clearance = {"cam": 2.0 / largest, "output": output}
    return {kind: per_clearance.get(kind, mesh) * clearance(design, kind) for kind in clearance_kinds(design)}


def clearance(design: Design, kind: str) -> float:
    """Give the clearance of a kind of pairs [m] between parts in their ideal places."""
    output = design.output
    wider = {
        design.tooth_pair: design.modification.equidistant,
        "output": output.hole_radius - output.pin_radius - design.gear.eccentricity,
    }
    return float(getattr(design.clearance, kind) + wider.get(kind, 0.0))


def stops(design: Design, crank: float, directions: int = CAM_DIRECTIONS) -> tuple[float, float]:
    """Give the output's stops [rad], clockwise and counter-clockwise of the ideal angle, at a crank angle [rad].

    All clearances and manufacturing errors are in it, of a modified profile the equidistant part. `directions` are the
    sides of the polygon that stands for the cam's play.

    Raises
    ------
    RunError
        The errors leave no place for the gear: it jams.
    """
    from scipy.optimize import linprog

    matrix, gaps = _constraints(design, crank, directions)
    found = []
    for direction in (-1.0, 1.0):
        ends = linprog([0.0, 0.0, 0.0, -direction], matrix, gaps * 1e6, bounds=(None, None))
        if ends.x is None:
            raise RunError(f"the gear jams at crank angle {crank:.4f} rad: its errors are larger than its clearances")
        found.append(float(ends.x[3]) * 1e-6 / design.output.pin_circle_radius)
    return found[0], found[1]


def _constraints(design: Design, crank: float, directions: int) -> tuple[Array, Array]:
    """Give A and the gaps [m] of A z <= gaps, z = d_x, d_y, R phi, R psi [m]: teeth, output pins, cam."""
    made, lever = deviations(design), design.output.pin_circle_radius
    centre = kinematics.gear_centre(tooth_profile(design), crank)
    outward = centre / design.gear.eccentricity
    rows, gaps = [], []
    for contacts in _ring_contacts(design, crank):
        normals, arms = -contacts.normals, profile.moment_arm(tooth_profile(design), contacts.B)
        rows.append(np.column_stack([normals, -arms / lever, np.zeros(arms.size)]))
        places, radii = made.pin_place[contacts.lobe], made.pin_radius[contacts.lobe]
        play = clearance(design, design.tooth_pair) + design.pin_play
        gaps.append(play - radii + np.sum(normals * places, axis=1))

    arms = _output_arms(design, crank) / lever
    rows.append(np.column_stack([np.tile(outward, (arms.size, 1)), arms, -arms]))
    turned = float(kinematics.gear_rotation(tooth_profile(design), crank))
    holes = made.hole_place @ np.array([[np.cos(turned), np.sin(turned)], [-np.sin(turned), np.cos(turned)]])
    gaps.append(clearance(design, "output") - holes @ outward)

    around = unit(np.linspace(0.0, 2.0 * np.pi, directions, endpoint=False))
    rows.append(np.column_stack([around, np.zeros((directions, 2))]))
    gaps.append(design.clearance.cam + made.eccentricity * around @ outward)
    return np.concatenate(rows), np.concatenate(gaps)


def _ring_contacts(design: Design, crank: float) -> list[envelope.RingContacts]:
    gear = tooth_profile(design)
    arcs = envelope.arc_contacts(gear, crank)
    return [arcs, envelope.sigma_contacts(gear, crank)] if design.ring.kind == "nonpin" else [arcs]


def _output_arms(design: Design, crank: float) -> Array:
    """Arms R sin beta of the output pins [m] about the axis, beta clockwise from the eccentric."""
    output, gear = design.output, tooth_profile(design)
    clockwise = 2.0 * np.pi * np.arange(output.pins) / output.pins - kinematics.gear_rotation(gear, crank) + crank
    return output.pin_circle_radius * np.sin(clockwise)


def _both_ways(arms: Array) -> float:
    """Turn per clearance [1/m], from stop to stop."""
    return float(1.0 / arms.max() - 1.0 / arms.min())


def total(design: Design, cranks: Array, directions: int = CAM_DIRECTIONS) -> Array:
    """Give the backlash of the output [rad] at crank angles [rad] (n,) with all clearances together."""
    ends = np.array([stops(design, float(crank), directions) for crank in cranks])
    return np.asarray(ends[:, 1] - ends[:, 0])


@lru_cache(maxsize=8)
def over_a_turn(design: Design) -> tuple[Array, Array]:
    """Give crank angles [rad] all over a turn, shape (n,), and the backlash [rad] at each as `total` does."""
    cranks = turn(design)
    return cranks, total(design, cranks, COARSE_DIRECTIONS)


def turn(design: Design) -> Array:
    """Give crank angles [rad] that resolve the mesh all over a turn, both of its ends among them."""
    return np.linspace(0.0, 2.0 * np.pi, PER_MESH_PERIOD * design.ring.teeth + 1)
