"""Rotation of output and discs of an RV reducer by statics, at any crank angles: transmission error, wind-up, stops.

Crank angles are those of the cranks against the ground. Signs are those of `Member.sense`: a positive torque on the
output brakes a sun that turns counter-clockwise, and rotations are positive in the direction of a positive torque.
"""

import numpy as np
import numpy.typing as npt

from cycloid_mj.base.array import Array
from cycloid_mj.reducer import RvReducer
from cycloid_mj.statics.rv import RvSprings, compute_rv_springs, runout_error, solve_rv_loads
from cycloid_mj.statics.rv_film import running_friction
from cycloid_mj.statics.stops import stop_width


def rv_springs_at(reducer: RvReducer, crank: npt.ArrayLike) -> RvSprings:
    """Compute the contact springs of an RV reducer at angles of the cranks against the ground [rad], shape (m,)."""
    return compute_rv_springs(reducer, reducer.member.against_ring(reducer.member.driven_angle(crank)))


def static_rotations(reducer: RvReducer, springs: RvSprings, torque: float, sense: float = 0.0) -> Array:
    """Compute the rotations of the discs (their mean) and of the output from their ideal angles under a torque.

    Parameters
    ----------
    reducer
        The reducer; its sun is fixed.
    springs
        Its contact springs, at m crank angles.
    torque
        Torque on the output [N m]. At a torque of 0, the parts are in the middle of their clearances.
    sense
        Direction in which the sun turns, 1 or -1, for the friction of a running drive; 0: no friction.

    Returns
    -------
    Array
        Rotations of discs and output [rad], shape (m, 2).

    Raises
    ------
    RunError
        There is no equilibrium.
    """
    # the cranks turn against the sun
    friction = running_friction(reducer, springs.crank, -sense) if sense and torque else None
    loads = solve_rv_loads(springs, -reducer.share * torque, friction)
    disc_rotation = loads.displacements[:, 2 : 3 * springs.discs : 3].mean(axis=1) / springs.lever
    if reducer.design.output.turns_ring:
        return np.stack([disc_rotation - loads.carrier_turn, -reducer.share * loads.carrier_turn], axis=1)
    return -np.stack([disc_rotation, reducer.share * loads.carrier_turn], axis=1)


def rv_transmission_error(reducer: RvReducer, crank: npt.ArrayLike, torque: float) -> Array:
    """Compute the rotations of discs and output of a running drive from their ideal angles, with friction.

    The direction is that of the design's speed. `crank` are k crank angles [rad], and `torque` [N m] is the torque on
    the output. The result (k, 2) [rad] and the errors are those of `static_rotations`. The rotation of the output
    includes that by its run-out (`runout_error`).
    """
    sense = float(np.sign(reducer.design.drive.speed))
    rotations = static_rotations(reducer, rv_springs_at(reducer, crank), torque, sense)
    rotations[:, 1] += reducer.member.sense * runout_at(reducer, crank)
    return rotations


def runout_at(reducer: RvReducer, crank: npt.ArrayLike) -> Array:
    """Compute the apparent rotation of the output by its run-out at crank angles [rad], shape (m,), see `runout_error`.

    Crank angles are against the ground. The rotation is counter-clockwise, not of the sense of this module.
    """
    crank = np.ravel(np.asarray(crank, dtype=np.float64))
    return runout_error(reducer, reducer.member.output_angle(reducer.member.driven_angle(crank)))


def rv_backlash(reducer: RvReducer, crank: npt.ArrayLike, torque: float) -> Array:
    """Compute the backlash of the output [rad] at crank angles [rad], shape (m,), without friction and weight.

    `torque` is the smaller torque that presses the output against its stops [N m], see `stop_width`.
    """
    springs = rv_springs_at(reducer, crank)
    return np.abs(stop_width(lambda stop_torque: static_rotations(reducer, springs, stop_torque)[:, 1], torque))
