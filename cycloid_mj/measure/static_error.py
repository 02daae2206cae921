"""Transmission error in closed form and in statics: ``mechanism.gaps`` with the contact stiffness of the simulation.

Nothing is from the collider, and friction and inertia but the gear's centrifugal force are left out.
"""

import numpy as np
import numpy.typing as npt

from cycloid_mj.contact.law import pair_stiffness
from cycloid_mj.design import Design
from cycloid_mj.kinematics import gear_centre
from cycloid_mj.loaded.springs import tooth_stiffness
from cycloid_mj.mechanism import balance
from cycloid_mj.mechanism.gaps import Gaps, arc_gaps, cam_places
from cycloid_mj.solid import gear_solid, mass_properties
from cycloid_mj.solid.gear import tooth_profile
from cycloid_mj.types import Array


def kinematic_error(design: Design, crank: npt.ArrayLike, direction: float) -> Array:
    """Turn of the gear from the ideal one [rad], shape of `crank`, where a torque's `direction` (+-1) presses it.

    Rigid parts, and a gear centred on the cam (no cam clearance): the first contact to close stops the gear, at its
    gap over its arm. So where one pin stands in the way alone, the error is its normal displacement over its arm.
    """
    angles = np.ravel(np.asarray(crank, dtype=np.float64))
    found = arc_gaps(design, angles)
    teeth = found.kind == design.tooth_pair
    at_cam = np.einsum("kni,ki->kn", found.slope[:, teeth, :2], cam_places(design, angles)[:, 0])
    gap = found.width[:, teeth] + design.pin_play + at_cam
    closing = -direction * design.output.pin_circle_radius * found.slope[:, teeth, 2]
    turn = np.min(np.where(closing > 0.0, gap / np.where(closing > 0.0, closing, 1.0), np.inf), axis=1)
    return np.reshape(direction * turn, np.shape(crank))


def static_error(design: Design, crank: npt.ArrayLike, torque: float, speed: float = 0.0) -> Array:
    """Transmission errors of gear and output in balance [rad], shape (k, 2), at k crank angles [rad].

    Parameters
    ----------
    design
        The design; friction is left out.
    crank
        Crank angles [rad].
    torque
        On the output [N m], counter-clockwise: against a crank that turns counter-clockwise.
    speed
        Of the crank [rad/s]: the gear's centrifugal force.

    Raises
    ------
    RunError
        No balance was found.
    """
    angles = np.ravel(np.asarray(crank, dtype=np.float64))
    mass = mass_properties(gear_solid(design)).mass
    weight = mass * np.array([design.environment.gravity_x, design.environment.gravity_y])
    load = np.zeros((angles.size, 4))
    load[:, :2] = weight + mass * speed**2 * gear_centre(tooth_profile(design), angles)
    load[:, 3] = torque / design.output.pin_circle_radius
    found = balance.solve(design, angles, _stiffness(design), load)
    return np.stack([found.disc_turn(design), found.output_turn(design)], axis=1)


def _stiffness(design: Design) -> balance.Stiffness:
    """Give the springs of the simulation; of a pin that moves, in series with what carries it."""
    output = pair_stiffness(design, "output")

    def contacts(found: Gaps) -> Array:
        return np.where(found.kind == "output", output, tooth_stiffness(design, found.relative_curvature))

    return balance.Stiffness(contacts, pair_stiffness(design, "cam"))
